//! Boxes, balls and capsules around meshes that were modelled as such.

use bevy::math::Affine3A;
use bevy_rapier3d::rapier::geometry::SharedShape;
use bevy_rapier3d::rapier::math::{Pose, Vector};

use crate::Error;
use crate::bevy::jobs::mesh_data::MeshData;
use crate::rapier::ColliderError;

/// Which of Rapier's own shapes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum PrimitiveKind {
    Cuboid,
    Ball,
    Capsule,
}

/// The least thickness of a box, as a share of its longest side: a plane is a thin one.
const THINNEST: f32 = 1e-3;

/// The shape around a mesh that is moved by `map`, along the axes of the collider. O(size).
///
/// # Errors
/// If no point is finite, or all are one spot.
pub(crate) fn primitive_around(
    kind: PrimitiveKind,
    data: &MeshData,
    map: &Affine3A,
) -> Result<SharedShape, ColliderError> {
    let points: Vec<Vector> =
        used_points(data).map(|point| map.transform_point3(point.into())).collect();
    let (middle, half) = bounding_box(&points).ok_or(Error::NothingUsable {
        triangles: data.triangles.len(),
        degenerate: 0,
        non_finite: 0,
    })?;
    let half = half.max(Vector::splat(THINNEST * half.max_element()));
    let distances =
        |from: &dyn Fn(Vector) -> f32| points.iter().map(|p| from(*p)).fold(0.0, f32::max);
    let shape = match kind {
        PrimitiveKind::Cuboid => SharedShape::cuboid(half.x, half.y, half.z),
        // By the vertices, which lie on the surface of the ball that was meant, and not by the box, which
        // is smaller where no vertex lies on an axis.
        PrimitiveKind::Ball => SharedShape::ball(distances(&|point| (point - middle).length())),
        PrimitiveKind::Capsule => {
            let axis = longest_axis(half);
            let radius = distances(&|point| (point - middle).reject_from_normalized(axis).length());
            let end = axis * (half.dot(axis) - radius).max(0.0);
            SharedShape::capsule(-end, end, radius)
        }
    };
    Ok(match middle == Vector::ZERO {
        true => shape,
        false => SharedShape::compound(vec![(Pose::from_translation(middle), shape)]),
    })
}

fn longest_axis(half: Vector) -> Vector {
    match half.max_element() {
        longest if longest == half.x => Vector::X,
        longest if longest == half.y => Vector::Y,
        _ => Vector::Z,
    }
}

/// The points that triangles use, as far as they are finite.
pub(crate) fn used_points(data: &MeshData) -> impl Iterator<Item = [f32; 3]> {
    let corners = data.triangles.iter().flatten();
    let points = corners.filter_map(|vertex| data.positions.get(*vertex as usize).copied());
    points.filter(|point| point.iter().all(|x| x.is_finite()))
}

/// Middle and half sides of the box around points; `None` if that is no more than one spot.
fn bounding_box(points: &[Vector]) -> Option<(Vector, Vector)> {
    let low = points.iter().fold(Vector::INFINITY, |low, point| low.min(*point));
    let high = points.iter().fold(Vector::NEG_INFINITY, |high, point| high.max(*point));
    let half = (high - low) / 2.0;
    (half.is_finite() && half.max_element() > 0.0).then_some((low + half, half))
}
