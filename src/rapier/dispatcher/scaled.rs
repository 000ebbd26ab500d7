//! Shapes as they look when lengths are multiplied.

use rapier3d::parry::bounding_volume::Aabb;
use rapier3d::parry::math::{Pose, Real, Vector};
use rapier3d::parry::query::ContactManifold;
use rapier3d::parry::shape::{PolygonalFeature, PolygonalFeatureMap, SupportMap};

/// Shapes are enlarged to an extent of 2 to this power, in Parry's unit: 16. Its tolerances are 1 mm and
/// 5 cm² there; beyond this size the rounding of `f32` exceeds them.
const EXTENT_EXPONENT: i32 = 4;

/// No extent is multiplied by more than 2 to this power, so that nothing overflows.
const LARGEST_EXPONENT: i32 = 60;

/// The power of two that enlarges a box to the extent above, give or take a factor of two. Large shapes
/// are not made smaller: details that are far above the tolerances would fall below.
pub(super) fn factor(bounds: &Aabb) -> Real {
    let extent = (bounds.maxs - bounds.mins).max_element();
    if !(extent.is_normal() && extent > 0.0) {
        return 1.0;
    }
    let exponent = EXTENT_EXPONENT - exponent(extent);
    Real::from_bits(((exponent.clamp(0, LARGEST_EXPONENT) + BIAS) as u32) << MANTISSA_BITS)
}

/// The logarithm to base 2, rounded down. Read off the bits, since `log2` may differ between platforms.
fn exponent(positive: Real) -> i32 {
    (positive.to_bits() >> MANTISSA_BITS) as i32 - BIAS
}

/// The format of `f32`.
const MANTISSA_BITS: u32 = Real::MANTISSA_DIGITS - 1;
const BIAS: i32 = Real::MAX_EXP - 1;

/// A shape, larger by a factor.
pub(super) struct Scaled<'a, S: ?Sized> {
    pub shape: &'a S,
    pub factor: Real,
}

impl<S: ?Sized + SupportMap> SupportMap for Scaled<'_, S> {
    fn local_support_point(&self, dir: Vector) -> Vector {
        self.shape.local_support_point(dir) * self.factor
    }

    fn local_support_point_toward(&self, dir: Vector) -> Vector {
        self.shape.local_support_point_toward(dir) * self.factor
    }
}

impl<S: ?Sized + PolygonalFeatureMap> PolygonalFeatureMap for Scaled<'_, S> {
    fn local_support_feature(&self, dir: Vector, out_feature: &mut PolygonalFeature) {
        self.shape.local_support_feature(dir, out_feature);
        out_feature.vertices = out_feature.vertices.map(|vertex| vertex * self.factor);
    }

    fn local_support_feature_toward(
        &self,
        dir: Vector,
        hint: Vector,
        out_feature: &mut PolygonalFeature,
    ) {
        self.shape.local_support_feature_toward(dir, hint / self.factor, out_feature);
        out_feature.vertices = out_feature.vertices.map(|vertex| vertex * self.factor);
    }

    fn is_convex_polyhedron(&self) -> bool {
        self.shape.is_convex_polyhedron()
    }
}

/// The pose of a shape whose surroundings are larger by a factor.
pub(super) fn scaled_pose(pose: &Pose, factor: Real) -> Pose {
    Pose { translation: pose.translation * factor, ..*pose }
}

/// Multiplies the lengths in a manifold.
pub(super) fn scale_manifold<M, C>(manifold: &mut ContactManifold<M, C>, factor: Real) {
    for point in &mut manifold.points {
        point.local_p1 *= factor;
        point.local_p2 *= factor;
        point.dist *= factor;
    }
}
