//! The dispatcher's contacts are right at every size, and Rapier's own where that is right.

use hullwright_rapier::{ContactDispatcher, shape_from_points};
use rapier3d::parry::query::{ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher};
use rapier3d::prelude::*;

use crate::world::Prop;

type Manifold = ContactManifold<(), ()>;

fn manifold(
    dispatcher: &dyn PersistentQueryDispatcher<(), ()>,
    pose: &Pose,
    shapes: [&dyn Shape; 2],
    prediction: f32,
) -> Manifold {
    let mut manifolds: Vec<Manifold> = Vec::new();
    let [first, second] = shapes;
    dispatcher
        .contact_manifolds(pose, first, second, prediction, &mut manifolds, &mut None)
        .unwrap();
    manifolds.swap_remove(0)
}

/// Bodies put onto the faces of a hull, so that they sink in by a share of the hull's size: their
/// shape, their pose, and the face's normal.
fn bodies_on_faces(hull: &dyn Shape, size: f32, depth: f32) -> Vec<(SharedShape, Pose, Vector)> {
    let half = 0.05 * size;
    let (points, triangles) = hull.as_convex_polyhedron().unwrap().to_trimesh();
    triangles
        .iter()
        .filter_map(|triangle| {
            let [a, b, c] = triangle.map(|vertex| points[vertex as usize]);
            let across = (b - a).cross(c - a);
            // The normal of a sliver is noise.
            (across.length() > 1e-4 * size * size).then(|| ((a + b + c) / 3.0, across.normalize()))
        })
        .flat_map(|(middle, normal)| {
            let translation = middle + normal * (half - depth * size);
            let rotation = Rotation::from_rotation_arc(Vector::Y, normal);
            let pose = Pose::from_parts(translation, rotation);
            [SharedShape::ball(half), SharedShape::cuboid(half, half, half)]
                .map(|body| (body, pose, normal))
        })
        .collect()
}

/// Scaled by a power of two, a contact has the same bits except the exponent: so what is right at
/// 16 m, where Parry's tolerances are small, is right at a millimetre.
#[test]
fn contacts_are_right_and_the_same_from_a_millimetre_to_sixteen_metres() {
    const DEPTH: f32 = 0.005;
    const LARGEST: f32 = 16.0;
    let (mut count, mut right) = (0, 0);
    for name in ["bowl", "mug", "teapot", "chair"] {
        let prop = Prop::model(name);
        for hull in &prop.decomposition.hulls {
            let at_size = |size: f32| {
                let points = std::slice::from_ref(&hull.shape.points);
                let hull = shape_from_points(points, [size; 3]).unwrap();
                let bodies = bodies_on_faces(&*hull, size, DEPTH).into_iter();
                let contact = |(body, pose, normal): (SharedShape, Pose, Vector)| {
                    let found = manifold(&ContactDispatcher, &pose, [&*hull, &*body], DEPTH * size);
                    let deepest = found.find_deepest_contact().expect("they touch").dist;
                    (deepest / size, found.local_n1, normal)
                };
                bodies.map(contact).collect::<Vec<_>>()
            };
            let large = at_size(LARGEST);
            for (depth, found, normal) in &large {
                count += 1;
                right += usize::from((depth + DEPTH).abs() < 5e-4 && found.dot(*normal) > 0.985);
            }
            for size in [0.5, 0.0625, 1.0 / 1024.0] {
                assert_eq!(at_size(size), large, "{name}, {size}");
            }
        }
    }
    // The others are on faces so narrow that their normal is noise.
    assert!(count > 1000 && right > count * 98 / 100, "{right} of {count}");
}

#[test]
fn the_order_of_the_shapes_does_not_matter() {
    let hull = Prop::model("torus").collider().build();
    let part = hull.shape().as_compound().unwrap().shapes()[0].1.clone();
    for (body, pose, _) in bodies_on_faces(&*part, 1.0, 0.005) {
        let one = manifold(&ContactDispatcher, &pose, [&*part, &*body], 0.01);
        let other = manifold(&ContactDispatcher, &pose.inverse(), [&*body, &*part], 0.01);
        let depth = |found: &Manifold| found.find_deepest_contact().unwrap().dist;
        assert!((depth(&one) - depth(&other)).abs() < 1e-4);
        assert!(one.local_n1.dot(other.local_n2) > 0.99);
    }
}

#[test]
fn large_shapes_have_the_very_contacts_that_rapier_computes() {
    let hull = Prop::model("torus").scaled_collider([100.0; 3]).build();
    for (_, part) in hull.shape().as_compound().unwrap().shapes() {
        for (body, pose, _) in bodies_on_faces(&**part, 100.0, 0.005) {
            let [ours, rapiers] = [
                &ContactDispatcher as &dyn PersistentQueryDispatcher<(), ()>,
                &DefaultQueryDispatcher,
            ]
            .map(|dispatcher| manifold(dispatcher, &pose, [&**part, &*body], 1.0));
            assert_eq!(format!("{ours:?}"), format!("{rapiers:?}"));
        }
    }
}
