//! Shapes that can be scaled again without their mesh.

use bevy::math::{Affine3A, Vec3};
use hullwright_parry::parry3d::math::Pose;
use hullwright_parry::parry3d::shape::{Ball, Capsule, SharedShape, TypedShape};

/// A larger triangle mesh takes more time than a frame has, and waits until its scale rests.
const MOST_TRIANGLES: usize = 5_000;

/// A shape whose points are moved by a map; `None` where it has none, or that takes too long.
/// O(points).
pub(super) fn moved(shape: &SharedShape, map: &Affine3A) -> Option<SharedShape> {
    let matrix = map.matrix3;
    if !(map.is_finite() && matrix.determinant().is_normal()) {
        return None;
    }
    let scale = Vec3::new(matrix.x_axis.x, matrix.y_axis.y, matrix.z_axis.z);
    let is_scale = scale.min_element() > 0.0 && *map == Affine3A::from_scale(scale);
    let scaled = is_scale.then(|| scaled(shape, scale)).flatten();
    scaled.or_else(|| mapped(shape, map))
}

/// By Parry, whose normals are wrong where factors differ.
fn scaled(shape: &SharedShape, scale: Vec3) -> Option<SharedShape> {
    let uniform = (scale.x == scale.y && scale.y == scale.z).then_some(scale.x);
    Some(match shape.as_typed_shape() {
        TypedShape::ConvexPolyhedron(hull) => {
            SharedShape::new(hull.clone().scaled(Vec3::splat(uniform?))?)
        }
        TypedShape::TriMesh(mesh) if mesh.indices().len() <= MOST_TRIANGLES => {
            SharedShape::new(mesh.clone().scaled(Vec3::splat(uniform?)))
        }
        TypedShape::Cuboid(cuboid) => SharedShape::new(cuboid.scaled(scale)),
        TypedShape::Ball(Ball { radius }) => SharedShape::ball(radius * uniform?),
        TypedShape::Capsule(Capsule { segment, radius }) => {
            let factor = uniform?;
            SharedShape::capsule(segment.a * factor, segment.b * factor, radius * factor)
        }
        TypedShape::Compound(parts) => {
            let part = |(pose, part): &(Pose, SharedShape)| {
                // What is turned would be sheared.
                if pose.rotation != Pose::IDENTITY.rotation {
                    uniform?;
                }
                let pose = Pose { translation: pose.translation * scale, ..*pose };
                Some((pose, scaled(part, scale)?))
            };
            SharedShape::compound(parts.shapes().iter().map(part).collect::<Option<_>>()?)
        }
        _ => return None,
    })
}

/// By hulls of the moved points.
fn mapped(shape: &SharedShape, map: &Affine3A) -> Option<SharedShape> {
    let one = [(Pose::IDENTITY, shape.clone())];
    let parts = shape.as_compound().map_or(&one[..], |compound| compound.shapes());
    let points = |(pose, part): &(Pose, SharedShape)| -> Option<Vec<[f64; 3]>> {
        let place = |point: &Vec3| {
            map.transform_point3(pose.transform_point(*point)).to_array().map(f64::from)
        };
        Some(part.as_convex_polyhedron()?.points().iter().map(place).collect())
    };
    let hulls: Vec<Vec<[f64; 3]>> = parts.iter().map(points).collect::<Option<_>>()?;
    hullwright_parry::shape_from_points(&hulls, [1.0; 3]).ok()
}
