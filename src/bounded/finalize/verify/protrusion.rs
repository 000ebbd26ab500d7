//! The protrusion of a hull: how far its surface is from the solid, as an upper bound.
//!
//! The rules of the fit test decide a face, without its leniences: no part is accepted because it
//! is small. The grid serves where it bounds a distance from above, and for the side of points that
//! are nearer to their cell's centre than to the surface. Where the mesh was clustered, distances
//! are those to the source, and what is inside the solid may be as far outside the source as
//! vertices have moved: the result is never below that.

use crate::bounded::containment::inside::is_inside;
use crate::bounded::containment::remainder::Remainder;
use crate::bounded::containment::solid::{Solid, SourceDistance};
use crate::bounded::containment::triangle::{centre, halves, is_within_sides};
use crate::bounded::work;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, distance, dot};
use crate::hull::ConvexHull;

/// No triangle of the solid is known to be near.
const NO_GUESS: u32 = u32::MAX;

/// Protrusions below this share of the bound are not resolved: they decide nothing, and resolving
/// them takes 3 to 14 % of the whole time. With [`RESOLUTION`], no result is below 0.29 of the
/// bound.
const UNRESOLVED: f64 = 0.25;

/// The same for an open solid, where a part is only known to be inside as far as the inside extends
/// around a point that was asked: the less is resolved, the fewer points.
const UNRESOLVED_IN_OPEN: f64 = 0.75;

/// Protrusions are too large by at most this share of the bound: a smaller one takes more parts of
/// faces for digits that decide nothing.
pub(super) const RESOLUTION: f64 = 0.04;

/// The same for maxima just below the bound, where it decides whether a hull is divided.
const FINE_RESOLUTION: f64 = 0.005;

/// Maximum number of parts of a hull's faces: needles would otherwise be halved without end.
const MAX_PARTS: usize = 200_000;

/// Where the distance is maximal all along a line, as halfway between two sheets, resolving it
/// takes parts without end. After this many it is only decided whether the bound is kept. Two
/// plates 0.13 % apart under a bound of 0.2 % took 50 s without.
const MANY_PARTS: usize = 20_000;

/// Parts between two checks for cancellation: less than a millisecond.
const PARTS_PER_CHECK: usize = 1024;

/// No point of the hull's faces is farther than this from the solid, in diagonals. If it exceeds
/// `limit`, any value above `limit` may be returned.
///
/// # Errors
/// [`Error::Cancelled`].
pub(in crate::bounded) fn protrusion(
    hull: &ConvexHull,
    solid: &Solid,
    bound: f64,
    limit: f64,
    control: &Control,
) -> Result<f64, Error> {
    let unresolved = if solid.is_closed() { UNRESOLVED } else { UNRESOLVED_IN_OPEN };
    let mut search = Search::new(solid, bound, limit, unresolved * bound);
    if search.cavities_exceed(hull) {
        return Ok(search.known);
    }
    let faces: Vec<[Vector; 3]> = hull.corners().collect();
    search.run(&faces, None, control)
}

/// The maximum found so far, and what it depends on.
pub(super) struct Search<'a> {
    solid: &'a Solid,
    bound: f64,
    limit: f64,
    displacement: f64,
    /// A lower bound on the maximum.
    pub known: f64,
    /// Where it was found, and the face or a part of it.
    pub farthest: Option<(Vector, [Vector; 3])>,
}

/// What is to be done about a part of a face.
enum Decision {
    /// It does not protrude farther than what is known.
    Settled,
    Halve,
    /// The limit is exceeded.
    Exceeds(f64),
}

impl<'a> Search<'a> {
    /// Protrusions of no more than `unresolved` are not told.
    pub fn new(solid: &'a Solid, bound: f64, limit: f64, unresolved: f64) -> Self {
        let displacement = solid.displacement();
        let known = unresolved.max(displacement);
        Self { solid, bound, limit, displacement, known, farthest: None }
    }

    /// The protrusion of some faces, or any value above the limit. If `around` is a point of a face, only the
    /// parts that contain it are looked at. If one of them exceeds the limit, so does the whole: whatever else is
    /// known there, it is halved as far.
    pub fn run(
        &mut self,
        faces: &[[Vector; 3]],
        around: Option<Vector>,
        control: &Control,
    ) -> Result<f64, Error> {
        let &mut Self { solid, bound, limit, displacement, .. } = self;
        let is_asked =
            |&part: &[Vector; 3]| around.is_none_or(|point| is_within_sides(part, point));
        // Faces and parts of them, and whether the surface may cross them.
        let mut stack: Vec<([Vector; 3], bool)> =
            faces.iter().map(|&face| (face, solid.is_coarse())).collect();
        // One large protrusion makes all other faces cheap.
        for &(face, _) in &stack {
            control.check()?;
            self.raise_by_centre(face);
            if self.known > limit {
                return Ok(self.known);
            }
        }
        let mut remainder = Remainder::default();
        let mut parts = 0;
        while let Some((part, may_be_crossed)) = stack.pop() {
            parts += 1;
            // In a clustered mesh, a single part may take a millisecond.
            if parts % PARTS_PER_CHECK == 0 || displacement > 0.0 {
                control.check()?;
            }
            if parts == MANY_PARTS && limit >= bound {
                self.known = self.known.max((1.0 - FINE_RESOLUTION) * bound);
            }
            if parts > MAX_PARTS {
                stack.push((part, false));
                let rest = stack.iter().map(|&(part, _)| upper_distance(part, solid));
                return Ok(rest.fold(enough(self.known, bound), f64::max));
            }
            match self.examine(part) {
                Decision::Settled => {}
                Decision::Halve => {
                    let radius = radius(centre(part), part);
                    let enough = enough(self.known, bound);
                    if may_be_crossed && remainder.find(part, radius, enough, &solid.bvh) {
                        for (centre, triangles) in remainder.parts() {
                            if !solid.is_closed() || !solid.bvh.is_inside(centre) {
                                stack.extend(triangles.filter(is_asked).map(|part| (part, false)));
                            }
                        }
                    } else {
                        let halves = halves(part).into_iter().filter(is_asked);
                        stack.extend(halves.map(|half| (half, may_be_crossed)));
                    }
                }
                Decision::Exceeds(distance) => return Ok(distance),
            }
        }
        Ok(enough(self.known, bound))
    }

    /// The distance from the surface to a point outside the solid, if it is more than `least`.
    fn distance_beyond(&self, least: f64, point: Vector) -> Option<f64> {
        if self.solid.upper_distance(point) + self.displacement <= least {
            return None;
        }
        let distance = self.solid.source_distance(point, NO_GUESS)?;
        (distance.upper > least && !self.solid.is_inside(point, &distance))
            .then_some(distance.upper)
    }

    /// Whether a point outside the solid is farther from its surface than the limit.
    pub fn may_exceed(&self, point: Vector) -> bool {
        self.distance_beyond(self.limit, point).is_some()
    }

    /// Takes cavities into account that the hull contains. Whether they exceed the limit.
    pub fn cavities_exceed(&mut self, hull: &ConvexHull) -> bool {
        let cavities = &self.solid.cavities;
        if cavities.is_empty() {
            return false;
        }
        let planes = hull.planes();
        let contains = |point| planes.iter().all(|&(normal, offset)| dot(normal, point) <= offset);
        for &(point, depth) in cavities {
            if depth > self.known && contains(point) {
                self.known = depth;
            }
        }
        self.known > self.limit
    }

    fn raise_by_centre(&mut self, face: [Vector; 3]) {
        let centre = centre(face);
        if let Some(distance) = self.distance_beyond(self.known, centre) {
            self.known = distance;
            self.farthest = Some((centre, face));
        }
    }

    fn examine(&mut self, part: [Vector; 3]) -> Decision {
        work::count(work::PART);
        let &mut Self { solid, bound, displacement, known, .. } = self;
        let centre = centre(part);
        let radius = radius(centre, part);
        let enough = enough(known, bound);
        let to_own_surface = enough - displacement;
        if solid.upper_distance_of_face(part, centre, to_own_surface) <= to_own_surface
            || solid.depth(centre).is_some_and(|depth| radius - depth <= to_own_surface)
        {
            return Decision::Settled;
        }
        let (to_cell_triangle, guess) = solid.nearest_triangle_of_cell(centre);
        let slack = if known > bound { RESOLUTION * known } else { FINE_RESOLUTION * bound };
        let may_halve = radius > slack;
        // A distance below the maximum only decides where it is known to be small.
        if may_halve && to_cell_triangle <= known && displacement == 0.0 {
            return Decision::Halve;
        }
        let Some(distance) = solid.source_distance(centre, guess) else {
            return Decision::Exceeds(f64::INFINITY);
        };
        if distance.upper + radius <= enough
            || solid.upper_distance_to_source(part, &distance) <= enough
        {
            return Decision::Settled;
        }
        // Inside tests are expensive: only where they decide.
        let is_enough_inside = solid.is_closed() && radius - distance.lower <= enough;
        if distance.upper > known || is_enough_inside || !may_halve || !solid.is_closed() {
            let is_inside = if solid.is_closed() {
                solid.is_inside(centre, &distance)
            } else {
                match self.side_in_open(centre, radius, &distance) {
                    OpenSide::AllInside => return Decision::Settled,
                    OpenSide::CentreInside => true,
                    OpenSide::CentreOutside => false,
                }
            };
            if is_inside {
                if is_enough_inside || !may_halve {
                    return Decision::Settled;
                }
            } else {
                if distance.upper > known {
                    self.known = distance.upper;
                    self.farthest = Some((centre, part));
                }
                if self.known > self.limit {
                    return Decision::Exceeds(self.known + radius);
                }
            }
        }
        if may_halve { Decision::Halve } else { Decision::Settled }
    }

    /// The side of a part in an open solid, where the side may change without crossing the surface.
    fn side_in_open(&self, centre: Vector, radius: f64, distance: &SourceDistance) -> OpenSide {
        let Solid { bvh, boundary, .. } = self.solid;
        // From the ball that is inside no point of the part is farther than the rest.
        let needed = radius - enough(self.known, self.bound);
        if needed <= 0.0 {
            let is_inside = is_inside(bvh, boundary, centre);
            return if is_inside { OpenSide::AllInside } else { OpenSide::CentreOutside };
        }
        match self.solid.inside_reach(centre, distance.lower, needed) {
            None => OpenSide::CentreOutside,
            Some(reach) if needed <= reach => OpenSide::AllInside,
            Some(_) => OpenSide::CentreInside,
        }
    }
}

enum OpenSide {
    AllInside,
    CentreInside,
    CentreOutside,
}

/// The greatest distance of a corner from the centre.
fn radius(centre: Vector, [a, b, c]: [Vector; 3]) -> f64 {
    distance(centre, a).max(distance(centre, b)).max(distance(centre, c))
}

/// No point of a part is farther than this from the source.
fn upper_distance(part: [Vector; 3], solid: &Solid) -> f64 {
    let centre = centre(part);
    let distance = solid.source_distance(centre, NO_GUESS);
    distance.map_or(f64::INFINITY, |distance| distance.upper + radius(centre, part))
}

/// The bound on a maximum that is at least `known`: near the promised bound as tight as it takes to
/// decide whether that is kept.
fn enough(known: f64, bound: f64) -> f64 {
    if known > bound {
        known * (1.0 + RESOLUTION)
    } else if known + RESOLUTION * bound <= bound {
        known + RESOLUTION * bound
    } else {
        bound.max(known + FINE_RESOLUTION * bound)
    }
}

#[cfg(test)]
mod tests;
