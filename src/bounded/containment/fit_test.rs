//! The fit test of faces: whether no point of a face is farther than the bound from the solid.
//!
//! Distance is 1-Lipschitz. So one query at the centre of a face whose corners are at most r from it decides it
//! if the distance d there is far enough from the bound ε: d + r ≤ ε accepts; outside the solid
//! d > ε rejects; inside it r - d ≤ ε accepts, since a path out of the solid crosses the surface.
//! Otherwise the face is halved.
//!
//! The search uses this test, and it is lenient; verification decides the result.

use super::distance_grid::Probe;
use super::inside::is_inside;
use super::remainder::Remainder;
use super::solid::{DOUBT, Solid};
use super::triangle::{centre, halves, is_within_sides};
use crate::bounded::work;
use crate::geometry::vector::{Vector, distance, length_squared, subtract};

/// A face of a radius (from its centre to the farthest corner) below this share of the bound is decided by its centre. With
/// [`CERTAIN`] this saves a tenth of all instructions, and hulls stay the same.
const SMALL: f64 = 0.25;

/// Where the surface is flat, the distance along its normal is exact. The tree is asked only where
/// that exceeds the bound by this factor, which covers surfaces that are slightly curved.
const CERTAIN: f64 = 1.03;

/// A face counts as smaller by this factor: a notch narrower than the rest is found by
/// verification. With 1, four of five models take 20 to 45 % more time and end with as many hulls.
const LENIENCE: f64 = 0.4;

/// A face of a larger radius, in bounds, is compared with the closest triangle as a whole: it
/// may lie along it, and halving it down to the bound would be slow.
const LARGE: f64 = 3.0;

/// Scratch memory of the fit test.
#[derive(Default)]
pub(crate) struct FitScratch {
    /// Parts of a face, and whether the surface may cross them.
    stack: Vec<([Vector; 3], bool)>,
    remainder: Remainder,
}

/// What one query says about a face.
enum Answer {
    Fits,
    Protrudes,
    Undecided,
}

impl Solid {
    /// Whether the centre of a face is in the solid or at most `bound` away from it.
    pub fn centre_fits(&self, face: [Vector; 3], bound: f64) -> bool {
        self.point_fits(centre(face), bound)
    }

    /// The same for the centres of a large face's quarters, for coarse solids.
    pub fn quarters_fit(&self, face: [Vector; 3], bound: f64) -> bool {
        !self.is_coarse()
            || halves(face)
                .into_iter()
                .flat_map(halves)
                .all(|quarter| self.point_fits(centre(quarter), bound))
    }

    /// A point of the face that is farther than `bound` from the solid; `None` if there is none. If `around` is
    /// a point of the face, only the parts that contain it are asked, a few of hundreds.
    pub fn protruding_point(
        &self,
        face: [Vector; 3],
        around: Option<Vector>,
        bound: f64,
        scratch: &mut FitScratch,
    ) -> Option<Vector> {
        let FitScratch { stack, remainder } = scratch;
        let is_asked =
            |&part: &[Vector; 3]| around.is_none_or(|point| is_within_sides(part, point));
        stack.clear();
        stack.push((face, self.is_coarse()));
        while let Some((part, may_be_crossed)) = stack.pop() {
            let centre = centre(part);
            match self.part_fits(part, bound) {
                Answer::Fits => continue,
                Answer::Protrudes => return Some(centre),
                Answer::Undecided => {}
            }
            let radius =
                part.map(|corner| distance(corner, centre)).into_iter().fold(0.0, f64::max);
            if may_be_crossed && remainder.find(part, radius, bound, &self.bvh) {
                for (centre, triangles) in remainder.parts() {
                    let mut triangles = triangles.filter(is_asked).peekable();
                    if around.is_some() && triangles.peek().is_none() {
                        continue;
                    }
                    if self.is_closed() && self.bvh.encloses(centre) {
                        continue;
                    }
                    if self.is_closed() && !self.bvh.is_within(centre, bound) {
                        return Some(centre);
                    }
                    stack.extend(triangles.map(|part| (part, false)));
                }
            } else {
                let halves = halves(part).into_iter().filter(is_asked);
                stack.extend(halves.map(|half| (half, may_be_crossed)));
            }
        }
        None
    }

    #[inline]
    fn part_fits(&self, face: [Vector; 3], bound: f64) -> Answer {
        work::count(work::PART);
        let [a, b, c] = face;
        let centre = centre(face);
        let radius = length_squared(subtract(centre, a))
            .max(length_squared(subtract(centre, b)))
            .max(length_squared(subtract(centre, c)))
            .sqrt();
        let probe = self.grid.probe(centre, &self.bvh);
        let reach = LENIENCE * radius;
        if probe.upper + reach <= bound
            || (radius > LARGE * bound && self.upper_distance_of_face(face, centre, bound) <= bound)
        {
            return Answer::Fits;
        }
        if probe.upper > bound {
            match self.beyond_bound(face, centre, &probe, reach, bound) {
                Answer::Undecided => {}
                decided => return decided,
            }
        }
        if radius <= SMALL * bound {
            return Answer::Fits;
        }
        if !self.is_closed()
            && self.is_coarse()
            && self.depth(centre).is_some_and(|depth| reach - depth <= bound)
        {
            return Answer::Fits;
        }
        // In an open surface, large faces could hide where the inside ends.
        if probe.lower > 0.0
            && (self.is_closed() || radius <= bound)
            && reach - probe.lower <= bound
            && self.grid.is_inside(&probe, &self.bvh) == Some(true)
        {
            return Answer::Fits;
        }
        Answer::Undecided
    }

    /// Decides a face whose centre may be outside the solid by more than the bound.
    #[inline]
    fn beyond_bound(
        &self,
        face: [Vector; 3],
        centre: Vector,
        probe: &Probe,
        reach: f64,
        bound: f64,
    ) -> Answer {
        match self.grid.is_inside(probe, &self.bvh) {
            Some(true) => {}
            Some(false) if probe.upper > DOUBT * bound => return Answer::Protrudes,
            Some(false) => {
                let (distance, _) = self.nearest_triangle_of_cell(centre);
                if distance + reach <= bound {
                    return Answer::Fits;
                }
                if distance > bound
                    && self.grid.distance_to_tangent(centre, &self.bvh) > CERTAIN * bound
                    && !self.bvh.is_within(centre, bound)
                {
                    return Answer::Protrudes;
                }
            }
            // The grid is too coarse for the bound.
            None => match self.bvh.closest_point(centre, f64::INFINITY) {
                Some(closest) if closest.distance <= bound => {
                    if closest.distance + reach <= bound
                        || self.upper_distance_to_triangle(face, closest.triangle) <= bound
                    {
                        return Answer::Fits;
                    }
                }
                Some(closest) if is_inside(&self.bvh, &self.boundary, centre) => {
                    if self.is_closed() && reach - closest.distance <= bound {
                        return Answer::Fits;
                    }
                }
                _ => return Answer::Protrudes,
            },
        }
        Answer::Undecided
    }
}

#[cfg(test)]
mod tests;
