//! The solid that hulls must not stand out of, and the fit test: whether a hull's surface stays
//! within the bound of it.
//!
//! Distance is 1-Lipschitz. So one query at the centre of a face of circumradius r decides it
//! where the distance d there is far enough from the bound ε: `d + r ≤ ε` accepts; outside of the
//! solid `d > ε` rejects; inside of it `r - d ≤ ε` accepts, since the surface must be crossed to
//! come out. Otherwise the face is halved.

use crate::field::Field;
use crate::vector::{Vector, add, distance, scale};

/// A face smaller than this share of the bound is decided by its centre.
const SMALL: f64 = 0.125;

/// The source mesh as a solid.
pub(crate) struct Solid {
    pub field: Field,
    /// Whether the surface encloses the inside: only then does being inside say anything.
    pub is_closed: bool,
}

impl Solid {
    /// Whether the point is in the solid or at most `bound` away from it.
    #[inline]
    pub fn holds(&self, point: Vector, bound: f64) -> bool {
        self.field.is_within(point, bound) || self.field.is_inside(point)
    }

    /// Whether no point of the triangle is farther than `bound` from the solid.
    pub fn face_fits(&self, face: [Vector; 3], bound: f64, stack: &mut Vec<[Vector; 3]>) -> bool {
        stack.clear();
        stack.push(face);
        let mut guess = u32::MAX;
        while let Some([a, b, c]) = stack.pop() {
            let centre = scale(add(add(a, b), c), 1.0 / 3.0);
            let radius = distance(centre, a).max(distance(centre, b)).max(distance(centre, c));
            let Some(closest) = self.field.distance_near(centre, f64::INFINITY, guess) else {
                return true;
            };
            guess = closest.triangle;
            let d = closest.distance;
            if d + radius <= bound {
                continue;
            }
            let is_small = radius <= SMALL * bound;
            if d > bound {
                if !self.field.is_inside(centre) {
                    return false;
                }
                if is_small || (self.is_closed && radius - d <= bound) {
                    continue;
                }
            } else if is_small {
                continue;
            } else if self.is_closed && radius - d <= bound && d > 0.25 * radius && self.field.is_inside(centre) {
                continue;
            }
            let (ab, bc, ca) = (distance(a, b), distance(b, c), distance(c, a));
            if ab >= bc && ab >= ca {
                let m = scale(add(a, b), 0.5);
                stack.push([a, m, c]);
                stack.push([m, b, c]);
            } else if bc >= ca {
                let m = scale(add(b, c), 0.5);
                stack.push([a, b, m]);
                stack.push([a, m, c]);
            } else {
                let m = scale(add(c, a), 0.5);
                stack.push([a, b, m]);
                stack.push([m, b, c]);
            }
        }
        true
    }
}
