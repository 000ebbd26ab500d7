//! Contacts of two convex shapes with faces.

use rapier3d::parry::math::{Pose, Real};
use rapier3d::parry::query::ContactManifold;
use rapier3d::parry::query::details::{NormalConstraints, contact_manifold_pfm_pfm};
use rapier3d::parry::shape::Shape;

use super::scaled::{Scaled, factor, scale_manifold, scaled_pose};

/// Finds the contacts at a larger scale. False where a shape has no faces, or none is needed.
pub(super) fn contacts<M, C>(
    pos12: &Pose,
    shape1: &dyn Shape,
    shape2: &dyn Shape,
    constraints: (Option<&dyn NormalConstraints>, Option<&dyn NormalConstraints>),
    prediction: Real,
    manifold: &mut ContactManifold<M, C>,
) -> bool
where
    M: Default,
    C: Default + Copy,
{
    let (Some((map1, border1)), Some((map2, border2))) =
        (shape1.as_polygonal_feature_map(), shape2.as_polygonal_feature_map())
    else {
        return false;
    };
    // What is searched is the difference of both shapes, as large as the larger one.
    let factor = factor(&shape1.compute_local_aabb()).min(factor(&shape2.compute_local_aabb()));
    if factor <= 1.0 {
        return false;
    }
    // The contacts of the last step are updated where they still hold.
    scale_manifold(manifold, factor);
    contact_manifold_pfm_pfm(
        &scaled_pose(pos12, factor),
        &Scaled { shape: map1, factor },
        border1 * factor,
        constraints.0,
        &Scaled { shape: map2, factor },
        border2 * factor,
        constraints.1,
        prediction * factor,
        manifold,
    );
    scale_manifold(manifold, factor.recip());
    true
}
