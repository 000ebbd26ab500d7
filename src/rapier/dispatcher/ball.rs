//! The contact of a ball with a convex shape.

use rapier3d::parry::math::{Pose, Real, Vector};
use rapier3d::parry::query::gjk::VoronoiSimplex;
use rapier3d::parry::query::point::local_point_projection_on_support_map;
use rapier3d::parry::query::{ContactManifold, PointProjection, TrackedContact};
use rapier3d::parry::shape::{PackedFeatureId, Shape};

use super::scaled::{Scaled, factor};

/// Finds the contact of `shape1` with the ball `shape2` at a larger scale; `flipped` where the manifold
/// names the ball first. False where that is not needed, or is not for us.
pub(super) fn contact<M, C: Default + Copy>(
    pos12: &Pose,
    shape1: &dyn Shape,
    shape2: &dyn Shape,
    prediction: Real,
    manifold: &mut ContactManifold<M, C>,
    flipped: bool,
) -> bool {
    let (Some(polyhedron), Some(ball)) = (shape1.as_convex_polyhedron(), shape2.as_ball()) else {
        return false;
    };
    let factor = factor(&polyhedron.local_aabb());
    if factor <= 1.0 {
        return false;
    }
    let centre = pos12.translation;
    let projection = local_point_projection_on_support_map(
        &Scaled { shape: polyhedron, factor },
        &mut VoronoiSimplex::new(),
        centre * factor,
        false,
    );
    let (outward, distance) = outward_and_distance(centre * factor, &projection);
    let distance = distance / factor - ball.radius;
    if distance > prediction {
        manifold.clear();
        return true;
    }
    let inward2 = pos12.rotation.inverse() * -outward;
    let contact = TrackedContact::flipped(
        projection.point / factor,
        inward2 * ball.radius,
        polyhedron.support_feature_id_toward(outward).into(),
        PackedFeatureId::face(0),
        distance,
        flipped,
    );
    // Where there is one contact as before, its impulse is where the solver starts.
    if let [point] = manifold.points.as_mut_slice() {
        point.copy_geometry_from(contact);
    } else {
        manifold.clear();
        manifold.points.push(contact);
    }
    let normals = if flipped { (inward2, outward) } else { (outward, inward2) };
    (manifold.local_n1, manifold.local_n2) = normals;
    true
}

/// The direction out of the shape at the projection of a point, and the point's distance, negative
/// inside.
fn outward_and_distance(point: Vector, projection: &PointProjection) -> (Vector, Real) {
    let off = point - projection.point;
    let length = off.length();
    let direction = if length > 0.0 { off / length } else { point.normalize_or(Vector::Y) };
    if projection.is_inside { (-direction, -length) } else { (direction, length) }
}
