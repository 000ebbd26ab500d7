//! Colliders in which hulls that are boxes, balls or capsules within the bound become these.

use rapier3d::geometry::SharedShape;
use rapier3d::parry::math::{Matrix, Pose, Rotation, Vector};

use super::prepare::ColliderError;
use super::shape::{shape, shape_from_points};
use crate::Hull;
use crate::hull::{Primitive, Slack, fit_primitive};
use crate::hulls_format::HullsFile;

/// The same as [`shape`](super::shape()) of a file's hulls, with a box, ball or capsule for each hull that is one
/// within what the verified errors leave of the bound: neither hulls nor mesh come to be farther apart than the
/// bound says. Physics engines are faster with these.
///
/// Hulls stay as they are where no bound was verified, and where the factors of `scale` differ: a scaled ball is none.
///
/// ```
/// use hullwright::hulls_format::HullsFile;
/// use hullwright::{Control, Parameters, decompose};
///
/// let corners = [0, 1, 2, 3, 4, 5, 6, 7].map(|i| [0, 1, 2].map(|axis| f64::from(i >> axis & 1)));
/// let cube = hullwright::convex_hull(&corners)?;
/// let made = decompose(&cube, &Parameters::default(), &Control::new())?;
/// let file = HullsFile::new("cube", &made);
/// let shape = hullwright::rapier::shape_with_primitives(&file, [2.0; 3])?;
/// let parts = shape.as_compound().expect("a box that is placed");
/// assert!(parts.shapes()[0].1.as_cuboid().is_some());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`shape`](super::shape()).
pub fn shape_with_primitives(
    file: &HullsFile,
    scale: [f32; 3],
) -> Result<SharedShape, ColliderError> {
    let factor = scale[0];
    let is_uniform = scale.iter().all(|other| *other == factor);
    let (Some(bound), Some(verified), true) = (file.bound, file.verified, is_uniform) else {
        return shape(&file.hulls, scale);
    };
    let primitive = |hull: &Hull| {
        let protrusion = hull.errors.protrusion_max.unwrap_or(verified.protrusion_max);
        let slack = Slack { outside: bound - protrusion, inside: bound - verified.uncovered_max };
        let part = part(fit_primitive(&hull.shape, slack)?, factor);
        let sizes = part.1.compute_local_aabb().half_extents();
        (sizes.is_finite() && sizes.min_element() > 0.0).then_some(part)
    };
    let primitives: Vec<_> = file.hulls.iter().map(primitive).collect();
    if primitives.iter().all(Option::is_none) {
        return shape(&file.hulls, scale);
    }
    let mut parts = Vec::with_capacity(primitives.len());
    for (hull, primitive) in file.hulls.iter().zip(primitives) {
        match primitive {
            Some(part) => parts.push(part),
            None => match shape_from_points(&[&hull.shape.points], scale)?.as_compound() {
                // What Parry refused, as a box that is placed.
                Some(placed) => parts.extend(placed.shapes().iter().cloned()),
                None => {
                    parts.push((Pose::IDENTITY, shape_from_points(&[&hull.shape.points], scale)?))
                }
            },
        }
    }
    Ok(SharedShape::compound(parts))
}

/// Where a primitive is in the scaled collider. A negative factor mirrors through the origin, which makes no
/// difference to a primitive about its centre.
fn part(primitive: Primitive, factor: f32) -> (Pose, SharedShape) {
    let place = |point: [f64; 3]| Vector::from(point.map(|x| x as f32)) * factor;
    let size = |length: f64| length as f32 * factor.abs();
    match primitive {
        Primitive::Cuboid { centre, axes, half } => {
            let [x, y, z] = axes.map(|axis| Vector::from(axis.map(|x| x as f32)));
            let rotation = Rotation::from_mat3(&Matrix::from_cols(x, y, z));
            let [a, b, c] = half.map(size);
            (Pose::from_parts(place(centre), rotation), SharedShape::cuboid(a, b, c))
        }
        Primitive::Ball { centre, radius } => {
            (Pose::from_translation(place(centre)), SharedShape::ball(size(radius)))
        }
        Primitive::Capsule { ends: [a, b], radius } => {
            (Pose::IDENTITY, SharedShape::capsule(place(a), place(b), size(radius)))
        }
    }
}
