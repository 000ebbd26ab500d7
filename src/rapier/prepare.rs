//! Hulls made ready for Rapier.
//!
//! Rapier takes convex polyhedra as points and triangles in `f32`. Parry, its collision library,
//! checks little of them, and what it does not check ends in a panic or in wrong contacts later.
//! So hulls are scaled, rounded and built anew here, and everything that Parry relies on is
//! checked before it is called.

use crate::hull::{HullBuilder, SinglePrecisionHull, single_precision};
use crate::{Error, MassProperties};

/// Why there is no collider.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ColliderError {
    /// There is nothing to make a shape of.
    #[error("there are no hulls")]
    NoHulls,
    /// A factor is zero or not finite, or takes coordinates beyond the range of `f32`.
    #[error("the scale {scale:?} leaves no body")]
    InvalidScale {
        /// The scale given.
        scale: [f32; 3],
    },
    /// A hull has no counterpart in single precision.
    #[error("hull {hull}: {reason}")]
    UnusableHull {
        /// Its number.
        hull: usize,
        /// Why not.
        reason: Error,
    },
    /// Mass, centre or inertia is not finite in single precision, or the mass is not positive.
    #[error("the mass properties can't be held in f32: mass {mass:e}")]
    UnusableMass {
        /// The mass, after scaling.
        mass: f64,
    },
    /// Parry makes no polyhedron of a hull, or one whose faces yield no contacts.
    #[error("Parry refuses the hull")]
    Refused,
    /// Parry makes no triangle mesh.
    #[error("there is no triangle mesh: {reason}")]
    TriangleMesh {
        /// Why not.
        reason: String,
    },
    /// The mesh could not be decomposed or weighed.
    #[error(transparent)]
    Mesh(#[from] Error),
}

/// The hulls of sets of points multiplied by `scale`, in single precision: convex and closed, with
/// volume, wound outward. A negative factor mirrors. O(n log n) in the points.
///
/// # Errors
/// [`ColliderError::NoHulls`], [`ColliderError::InvalidScale`], [`ColliderError::UnusableHull`].
pub(super) fn scaled_hulls<P: AsRef<[[f64; 3]]>>(
    hulls: &[P],
    scale: [f32; 3],
) -> Result<Vec<SinglePrecisionHull>, ColliderError> {
    check_scale(scale)?;
    if hulls.is_empty() {
        return Err(ColliderError::NoHulls);
    }
    let mut builder = HullBuilder::new();
    let [x, y, z] = scale.map(f64::from);
    hulls
        .iter()
        .enumerate()
        .map(|(hull, points)| {
            let points = points.as_ref().iter();
            let scaled: Vec<_> = points.map(|p| [p[0] * x, p[1] * y, p[2] * z]).collect();
            single_precision(&scaled, &mut builder)
                .map_err(|reason| ColliderError::UnusableHull { hull, reason })
        })
        .collect()
}

/// A hull that Parry refuses is tried again with these tolerances, as shares of its extent: Parry
/// loses faces to slivers. From 50 times the usual tolerance to what shows on a hull a metre wide.
const COARSER: [f64; 3] = [1e-5, 1e-4, 1e-3];

/// The same hull with fewer and fewer slivers, for those that Parry refuses.
pub(super) fn coarser(points: &[[f32; 3]]) -> impl Iterator<Item = SinglePrecisionHull> {
    let points: Vec<_> = points.iter().map(|point| point.map(f64::from)).collect();
    COARSER.into_iter().filter_map(move |tolerance| {
        single_precision(&points, &mut HullBuilder::new().with_tolerance(tolerance)).ok()
    })
}

/// Mass properties as a rigid body of an engine holds them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RigidMass {
    pub mass: f32,
    pub centre: [f32; 3],
    /// About the principal axes.
    pub moments: [f32; 3],
    /// The frame of the principal axes, as a quaternion (x, y, z, w).
    pub rotation: [f32; 4],
}

impl RigidMass {
    /// # Errors
    /// [`ColliderError::InvalidScale`], [`ColliderError::UnusableMass`].
    pub(super) fn new(properties: &MassProperties, scale: [f32; 3]) -> Result<Self, ColliderError> {
        check_scale(scale)?;
        let properties = properties.scaled(scale.map(f64::from));
        let principal = properties.principal_inertia();
        let body = Self {
            mass: properties.mass as f32,
            centre: properties.centre.map(|x| x as f32),
            moments: principal.moments.map(|x| x as f32),
            rotation: principal.rotation.map(|x| x as f32),
        };
        // Engines keep inverses, in which a subnormal number becomes infinite.
        let is_usable = body.mass.is_normal()
            && body.mass > 0.0
            && body.centre.iter().chain(&body.rotation).all(|x| x.is_finite())
            && body.moments.iter().all(|x| x.is_normal());
        if is_usable {
            Ok(body)
        } else {
            Err(ColliderError::UnusableMass { mass: properties.mass })
        }
    }
}

fn check_scale(scale: [f32; 3]) -> Result<(), ColliderError> {
    if scale.iter().all(|factor| factor.is_normal()) {
        Ok(())
    } else {
        Err(ColliderError::InvalidScale { scale })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MassSource;
    use crate::hull::ConvexHull;

    fn unit_cube() -> [Vec<[f64; 3]>; 1] {
        [(0..8_u8).map(|corner| [0, 1, 2].map(|axis| f64::from(corner >> axis & 1))).collect()]
    }

    #[test]
    fn a_mirrored_hull_is_still_wound_outward() {
        let scaled = scaled_hulls(&unit_cube(), [-2.0, 1.0, 3.0]).unwrap();
        let (points, triangles) = &scaled[0];
        let points: Vec<[f64; 3]> = points.iter().map(|p| p.map(f64::from)).collect();
        let hull = ConvexHull { points, triangles: triangles.clone() };
        assert!((hull.volume() - 6.0).abs() < 1e-6);
        for (found, expected) in hull.bounds().unwrap().min.into_iter().zip([-2.0, 0.0, 0.0]) {
            assert!((found - expected).abs() < 1e-6);
        }
    }

    #[test]
    fn a_mass_that_single_precision_can_not_hold_is_an_error() {
        let cube = crate::hull::convex_hull(&unit_cube()[0]).unwrap();
        let of = |density| crate::mass_properties(&cube, &[], density).unwrap();
        assert_eq!(of(1.0).source, MassSource::Mesh);
        assert!(RigidMass::new(&of(1.0), [1.0; 3]).is_ok());
        for density in [1e-40, 1e60] {
            let result = RigidMass::new(&of(density), [1.0; 3]);
            assert!(matches!(result, Err(ColliderError::UnusableMass { .. })));
        }
    }
}
