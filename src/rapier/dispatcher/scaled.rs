//! Contacts of two convex shapes, found at a larger scale.

use rapier3d::parry::bounding_volume::Aabb;
use rapier3d::parry::math::{Pose, Real, Vector};
use rapier3d::parry::query::details::{NormalConstraints, contact_manifold_pfm_pfm};
use rapier3d::parry::query::gjk::VoronoiSimplex;
use rapier3d::parry::query::point::local_point_projection_on_support_map;
use rapier3d::parry::query::{ContactManifold, PointProjection, TrackedContact};
use rapier3d::parry::shape::{
    PackedFeatureId, PolygonalFeature, PolygonalFeatureMap, Shape, SupportMap,
};

/// Two convex shapes, of which the contacts are wanted.
#[derive(Clone, Copy)]
pub(super) struct Pair<'a> {
    pub shape1: &'a dyn Shape,
    pub shape2: &'a dyn Shape,
    /// The pose of the second in the frame of the first.
    pub pos12: Pose,
    /// Contacts this far apart count.
    pub prediction: Real,
}

impl Pair<'_> {
    pub(super) fn flipped(self) -> Self {
        Self {
            shape1: self.shape2,
            shape2: self.shape1,
            pos12: self.pos12.inverse(),
            prediction: self.prediction,
        }
    }

    /// Finds the contacts of shapes with faces, where directions of the normal may be forbidden on either
    /// side. False where a shape has no faces, or is large enough for Parry.
    pub(super) fn contacts_of_faces<M: Default, C: Default + Copy>(
        &self,
        forbidden: [Option<&dyn NormalConstraints>; 2],
        manifold: &mut ContactManifold<M, C>,
    ) -> bool {
        let (Some((map1, border1)), Some((map2, border2))) =
            (self.shape1.as_polygonal_feature_map(), self.shape2.as_polygonal_feature_map())
        else {
            return false;
        };
        // What is searched is the difference of both shapes, as large as the larger one.
        let [factor1, factor2] =
            [self.shape1, self.shape2].map(|shape| factor(&shape.compute_local_aabb()));
        let factor = factor1.min(factor2);
        if factor <= 1.0 {
            return false;
        }
        // The contacts of the last step are updated where they still hold.
        scale_manifold(manifold, factor);
        contact_manifold_pfm_pfm(
            &Pose { translation: self.pos12.translation * factor, ..self.pos12 },
            &Scaled { shape: map1, factor },
            border1 * factor,
            forbidden[0],
            &Scaled { shape: map2, factor },
            border2 * factor,
            forbidden[1],
            self.prediction * factor,
            manifold,
        );
        scale_manifold(manifold, factor.recip());
        true
    }

    /// Finds the contact of a polyhedron with a ball, the second shape; `flipped` where the manifold names
    /// the ball first. False for other shapes, or where the polyhedron is large enough for Parry.
    pub(super) fn contact_of_ball<M, C: Default + Copy>(
        &self,
        manifold: &mut ContactManifold<M, C>,
        flipped: bool,
    ) -> bool {
        let (Some(polyhedron), Some(ball)) =
            (self.shape1.as_convex_polyhedron(), self.shape2.as_ball())
        else {
            return false;
        };
        let factor = factor(&polyhedron.local_aabb());
        if factor <= 1.0 {
            return false;
        }
        let centre = self.pos12.translation;
        let projection = local_point_projection_on_support_map(
            &Scaled { shape: polyhedron, factor },
            &mut VoronoiSimplex::new(),
            centre * factor,
            false,
        );
        let (outward, distance) = outward_and_distance(centre * factor, &projection);
        let distance = distance / factor - ball.radius;
        if distance > self.prediction {
            manifold.clear();
            return true;
        }
        let inward2 = self.pos12.rotation.inverse() * -outward;
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
}

/// The direction out of the shape at the projection of a point, and the point's distance, negative
/// inside.
fn outward_and_distance(point: Vector, projection: &PointProjection) -> (Vector, Real) {
    let off = point - projection.point;
    let length = off.length();
    let direction = if length > 0.0 { off / length } else { point.normalize_or(Vector::Y) };
    if projection.is_inside { (-direction, -length) } else { (direction, length) }
}

/// Shapes are enlarged to an extent of 2 to this power, in Parry's unit: 16. Its tolerances are 1 mm and
/// 5 cm² there; beyond this size the rounding of `f32` exceeds them.
const EXTENT_EXPONENT: i32 = 4;

/// No extent is multiplied by more than 2 to this power, so that nothing overflows.
const LARGEST_EXPONENT: i32 = 60;

/// The power of two that enlarges a box to the extent above, give or take a factor of two. Large shapes
/// are not made smaller: details that are far above the tolerances would fall below.
fn factor(bounds: &Aabb) -> Real {
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
struct Scaled<'a, S: ?Sized> {
    shape: &'a S,
    factor: Real,
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

/// Multiplies the lengths in a manifold.
fn scale_manifold<M, C>(manifold: &mut ContactManifold<M, C>, factor: Real) {
    for point in &mut manifold.points {
        point.local_p1 *= factor;
        point.local_p2 *= factor;
        point.dist *= factor;
    }
}
