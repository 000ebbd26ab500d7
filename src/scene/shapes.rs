//! Shapes by their measures, as physics extensions have them, as Parry's.

use hullwright::MeshView;
use hullwright_formats::conventions::ImplicitShape;
use hullwright_parry::parry3d::math::Vector;
use hullwright_parry::parry3d::shape::{HalfSpace, SharedShape, TriMeshFlags};
use hullwright_parry::{ColliderError, shape_from_points, triangle_mesh};

/// Half the size of a plane that never ends but is no half space: it has two sides, or an edge.
const FAR: f32 = 1e4;

/// Points around a circle where Parry has no shape of its own.
const AROUND: usize = 24;

/// Circles from the middle of a half ball to its pole.
const CIRCLES: usize = 6;

/// The shape, around the origin and along the y axis.
///
/// # Errors
/// If single precision leaves no body.
pub(super) fn shape(implicit: &ImplicitShape) -> Result<SharedShape, ColliderError> {
    match *implicit {
        ImplicitShape::Cuboid { size: [x, y, z] } => {
            Ok(SharedShape::cuboid(x / 2.0, y / 2.0, z / 2.0))
        }
        ImplicitShape::Ball { radius } => Ok(SharedShape::ball(radius)),
        ImplicitShape::Capsule { height, radius_top, radius_bottom } => {
            if radius_top == radius_bottom {
                return Ok(SharedShape::capsule_y(height / 2.0, radius_top));
            }
            let mut points = half_ball(radius_top, height / 2.0, 1.0);
            points.extend(half_ball(radius_bottom, -height / 2.0, -1.0));
            shape_from_points(&[points], [1.0; 3])
        }
        ImplicitShape::Cylinder { height, radius_top, radius_bottom } => {
            let half = height / 2.0;
            if radius_top == radius_bottom {
                return Ok(SharedShape::cylinder(half, radius_top));
            }
            if radius_top == 0.0 {
                return Ok(SharedShape::cone(half, radius_bottom));
            }
            let mut points = circle(radius_top, half);
            points.extend(circle(radius_bottom, -half));
            shape_from_points(&[points], [1.0; 3])
        }
        ImplicitShape::Plane { size_x: None, size_z: None, is_double_sided: false } => {
            Ok(SharedShape::new(HalfSpace::new(Vector::Y)))
        }
        ImplicitShape::Plane { size_x, size_z, .. } => {
            let [x, z] = [size_x, size_z].map(|size| size.map_or(FAR, |size| size / 2.0));
            let corners = [[-x, 0.0, -z], [-x, 0.0, z], [x, 0.0, z], [x, 0.0, -z]];
            let plane = MeshView::new(&corners, &[[0, 1, 2], [0, 2, 3]]);
            Ok(SharedShape::new(triangle_mesh(plane, TriMeshFlags::empty())?))
        }
    }
}

fn circle(radius: f32, y: f32) -> Vec<[f64; 3]> {
    let [radius, y] = [radius, y].map(f64::from);
    let point = |index| {
        let (sine, cosine) = (std::f64::consts::TAU * index as f64 / AROUND as f64).sin_cos();
        [radius * cosine, y, radius * sine]
    };
    // One of no radius is a point.
    let count = if radius > 0.0 { AROUND } else { 1 };
    (0..count).map(point).collect()
}

fn half_ball(radius: f32, y: f32, up: f32) -> Vec<[f64; 3]> {
    let angle = |index| std::f32::consts::FRAC_PI_2 * index as f32 / CIRCLES as f32;
    let circles = (0..CIRCLES).flat_map(|index| {
        let (sine, cosine) = angle(index).sin_cos();
        circle(radius * cosine, y + up * radius * sine)
    });
    circles.chain(circle(0.0, y + up * radius)).collect()
}

#[cfg(test)]
mod tests {
    use std::f32::consts::PI;

    use super::*;

    #[test]
    fn shapes_have_the_sizes_that_the_file_says() {
        let (height, radius_top, radius_bottom) = (2.0, 0.5, 1.0);
        for (implicit, size, volume) in [
            (ImplicitShape::Cuboid { size: [1.0, 2.0, 3.0] }, [1.0, 2.0, 3.0], 6.0),
            (ImplicitShape::Ball { radius: 0.5 }, [1.0; 3], PI / 6.0),
            (
                ImplicitShape::Capsule { height, radius_top: 0.5, radius_bottom: 0.5 },
                [1.0, 3.0, 1.0],
                2.0 * PI / 3.0,
            ),
            (
                ImplicitShape::Cylinder { height, radius_top: 1.0, radius_bottom },
                [2.0, 2.0, 2.0],
                2.0 * PI,
            ),
            (
                ImplicitShape::Cylinder { height, radius_top: 0.0, radius_bottom },
                [2.0; 3],
                2.0 * PI / 3.0,
            ),
            (
                ImplicitShape::Cylinder { height, radius_top, radius_bottom },
                [2.0; 3],
                3.5 * PI / 3.0,
            ),
            // A polyhedron within it.
            (ImplicitShape::Capsule { height, radius_top, radius_bottom }, [2.0, 3.5, 2.0], 6.25),
        ] {
            let shape = shape(&implicit).unwrap();
            let bounds = shape.compute_local_aabb();
            let extents = bounds.extents().to_array();
            for (found, expected) in extents.into_iter().zip(size) {
                assert!((found - expected).abs() < 0.01 * expected, "{implicit:?}: {extents:?}");
            }
            let found = shape.mass_properties(1.0).mass();
            assert!((found - volume).abs() < 0.05 * volume, "{implicit:?}: {found}");
        }
    }

    #[test]
    fn a_plane_is_a_half_space_or_has_edges() {
        let plane = |size_x, size_z, is_double_sided| {
            shape(&ImplicitShape::Plane { size_x, size_z, is_double_sided }).unwrap()
        };
        assert!(plane(None, None, false).as_halfspace().is_some());
        assert!(plane(None, None, true).as_trimesh().is_some());
        let size = plane(Some(2.0), Some(4.0), false).compute_local_aabb().extents();
        assert_eq!(size, Vector::new(2.0, 0.0, 4.0));
    }
}
