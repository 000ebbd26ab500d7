//! The solid that hulls must not stand out of, and the fit test: whether a hull's surface stays
//! within the bound of it.
//!
//! Distance is 1-Lipschitz. So one query at the centre of a face of circumradius r decides it
//! where the distance d there is far enough from the bound ε: `d + r ≤ ε` accepts; outside of the
//! solid `d > ε` rejects; inside of it `r - d ≤ ε` accepts, since the surface must be crossed to
//! come out. Otherwise the face is halved.

use std::sync::Arc;

use super::cavities::cavities;
use super::cluster::Clustered;
use super::grid::{Grid, Verdict};
use super::verdicts::Verdicts;
use crate::bvh::Bvh;
use crate::bvh::closest_point::ClosestPoint;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, add, length_squared, scale, subtract};
use crate::mesh::TriangleMesh;

/// A face smaller than this share of the bound is decided by its centre.
const SMALL: f64 = 0.25;

/// The search never asks for less than this share of the solid's bound.
pub(super) const LEAST_SEARCH_SHARE: f64 = 0.9;

/// Where the grid gives a distance above the bound by less than this share, the field is asked.
const DOUBT: f64 = 1.5;

/// Where the surface is flat around the nearest point, the distance to it along its normal is
/// right. During the search the tree is asked only where that is above the bound by this factor.
const CERTAIN: f64 = 1.03;

/// During the search a face counts as if it were smaller by this factor: a notch narrower than the
/// rest is found when the result is verified.
const LENIENCE: f64 = 0.4;

/// Where the surface is open, a winding number above this is inside: along a flat sheet it is one
/// half on both sides, and its approximation would toss a coin.
pub(super) const OPEN_INSIDE: f64 = 0.52;

/// A face larger than this, in bounds, may lie along a single triangle of the source.
const LARGE: f64 = 3.0;

/// More than the rounding of the grid's distances, in diagonals.
const SINGLE_PRECISION: f64 = 1e-6;

/// The source mesh as a solid, or one of fewer triangles that stands for it.
pub(crate) struct Solid {
    pub bvh: Bvh,
    /// Whether the surface encloses the inside: only then does being inside say anything.
    pub is_closed: bool,
    grid: Grid,
    /// A point of each cavity that no hull may hold, with its distance to the surface.
    pub cavities: Vec<(Vector, f64)>,
    /// Of faces during the search.
    pub verdicts: Verdicts,
    /// Where the solid is that of fewer triangles than the source has: what they stand for.
    pub clustered: Option<Arc<Clustered>>,
}

/// How far a point is from the source.
pub(super) struct Near {
    /// At least the distance.
    pub upper: f64,
    /// At most how deep it is inside of the source, or of what is that near to it, if it is inside.
    pub lower: f64,
    /// The distance to the solid's own surface.
    own: f64,
    /// A triangle of the source that is at most `upper` away.
    triangle: u32,
}

impl Solid {
    /// O(n log n) for n triangles, and a grid of at most 1.5 million cells.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn new(
        positions: &[Vector],
        triangles: &[[u32; 3]],
        is_closed: bool,
        bound: f64,
        control: &Control,
    ) -> Result<Self, Error> {
        let (bvh, grid) = crate::parallel::join(
            || Bvh::with_control(positions, triangles, control),
            || Grid::new(positions, triangles, bound, control),
        );
        let (bvh, mut grid) = (bvh?, grid?);
        if is_closed {
            grid.flood(&bvh, (positions, triangles), control)?;
        }
        grid.judge_cells(LEAST_SEARCH_SHARE * bound, DOUBT * bound);
        Ok(Self {
            bvh,
            is_closed,
            grid,
            cavities: Vec::new(),
            verdicts: Verdicts::new(),
            clustered: None,
        })
    }

    /// The solid of a clustered mesh, for which the source is what that stands for.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn of_clustered(
        clustered: Arc<Clustered>,
        bound: f64,
        control: &Control,
    ) -> Result<Self, Error> {
        let TriangleMesh { positions, triangles } = &clustered.mesh;
        let solid = Self::new(positions, triangles, true, bound, control)?;
        Ok(Self { clustered: Some(clustered), ..solid })
    }

    /// The solid's own surface is at most this far from the source, and what is inside of the one is inside of
    /// the other, or that near to it.
    pub fn reach(&self) -> f64 {
        self.clustered.as_ref().map_or(0.0, |clustered| clustered.reach)
    }

    /// How far a point is from the source, and where the source is near, if it is.
    pub fn near(&self, point: Vector, guess: u32) -> Option<Near> {
        let ClosestPoint { distance, triangle, .. } =
            self.bvh.closest_point_near(point, f64::INFINITY, guess)?;
        let Some(clustered) = &self.clustered else {
            return Some(Near { upper: distance, lower: distance, own: distance, triangle });
        };
        let (upper, nearest) =
            clustered.closest_around(clustered.mesh.triangles[triangle as usize], point, distance);
        let lower = distance - clustered.reach;
        Some(Near { upper, lower, own: distance, triangle: nearest })
    }

    /// Whether a point is inside, or not farther outside than [`reach`](Self::reach): as the centre of its
    /// cell is, if that is nearer than the surface.
    pub fn holds_inside(&self, point: Vector, near: &Near) -> bool {
        match self.grid.side(point, near.own) {
            Some(inside) => inside,
            None => is_inside(&self.bvh, point, self.is_closed),
        }
    }

    /// At least the distance to the source from any point of a face, as far as one triangle of it tells.
    pub fn farthest_corner_from(&self, face: [Vector; 3], near: &Near) -> f64 {
        match &self.clustered {
            None => self.farthest_corner(face, near.triangle),
            Some(clustered) => {
                largest(face.map(|corner| clustered.squared_distance_to(corner, near.triangle)))
                    .sqrt()
            }
        }
    }

    /// From now on no hull may hold cavities deeper than `bound` (see `cavities`).
    pub fn keep_cavities(&mut self, bound: f64) {
        let points = cavities(&self.grid, &self.bvh, bound).into_iter();
        let depth =
            |point| self.bvh.closest_point(point, f64::INFINITY).map(|found| found.distance);
        self.cavities = points.filter_map(|point| Some((point, depth(point)?))).collect();
    }

    /// At least the distance to the surface.
    #[inline]
    pub fn upper_distance(&self, point: Vector) -> f64 {
        self.grid.probe(point).upper + SINGLE_PRECISION
    }

    /// At least the distance to the surface from any point of a triangle with this centre.
    ///
    /// The distance to one point of the surface, and to one of its triangles, is a convex
    /// function, so that it is largest at a corner. Those near the middle of the centre's cell are
    /// asked.
    #[inline]
    pub fn upper_distance_of(&self, face: [Vector; 3], centre: Vector, enough: f64) -> f64 {
        let Some(nearest) = self.grid.nearest(centre) else { return f64::INFINITY };
        let of_point = largest(face.map(|corner| length_squared(subtract(corner, nearest))));
        let of_point = of_point.sqrt() + SINGLE_PRECISION;
        if of_point <= enough {
            return of_point;
        }
        self.farthest_corner(face, self.grid.owner(centre)).min(of_point)
    }

    /// At least the distance to the solid's own surface from any point of a face, as far as one triangle of it
    /// tells.
    #[inline]
    pub fn farthest_corner(&self, face: [Vector; 3], triangle: u32) -> f64 {
        largest(face.map(|corner| self.bvh.distance_to_triangle(corner, triangle)))
    }

    /// The triangle nearest to the middle of the point's cell, if that is near, and how far it is.
    #[inline]
    pub fn close_distance(&self, point: Vector) -> (f64, u32) {
        let triangle = self.grid.owner(point);
        (self.bvh.distance_to_triangle(point, triangle), triangle)
    }

    /// At most the distance to the surface of a point inside; `None` if it may be outside.
    #[inline]
    pub fn depth(&self, point: Vector) -> Option<f64> {
        self.grid.depth(point)
    }

    /// Whether the point is in the solid or at most `bound` away from it: between
    /// [`LEAST_SEARCH_SHARE`] of the solid's bound and all of it.
    #[inline]
    pub fn holds(&self, point: Vector, bound: f64) -> bool {
        match self.grid.verdict(point) {
            Verdict::Near => return true,
            Verdict::Far => return false,
            Verdict::Mixed => {}
        }
        let probe = self.grid.probe(point);
        if probe.upper <= bound {
            return true;
        }
        match self.grid.is_inside(&probe, &self.bvh) {
            Some(inside) => {
                inside || probe.upper <= DOUBT * bound && self.bvh.is_within(point, bound)
            }
            None => self.bvh.is_within(point, bound) || is_inside(&self.bvh, point, self.is_closed),
        }
    }

    /// Whether the centre of a face is in the solid or at most `bound` away from it.
    pub fn centre_fits(&self, [a, b, c]: [Vector; 3], bound: f64) -> bool {
        self.holds(scale(add(add(a, b), c), 1.0 / 3.0), bound)
    }

    /// Whether some points between two of the solid are farther than `bound` from it.
    pub fn separates(&self, a: Vector, b: Vector, bound: f64) -> bool {
        let at = |share: f64| add(scale(a, 1.0 - share), scale(b, share));
        [0.5, 0.25, 0.75].into_iter().any(|share| !self.holds(at(share), bound))
    }

    /// Whether no point of the triangle is farther than `bound` from the solid.
    pub fn face_fits(&self, face: [Vector; 3], bound: f64, stack: &mut Vec<[Vector; 3]>) -> bool {
        stack.clear();
        stack.push(face);
        while let Some([a, b, c]) = stack.pop() {
            let centre = scale(add(add(a, b), c), 1.0 / 3.0);
            let radius = length_squared(subtract(centre, a))
                .max(length_squared(subtract(centre, b)))
                .max(length_squared(subtract(centre, c)))
                .sqrt();
            let probe = self.grid.probe(centre);
            let reach = LENIENCE * radius;
            if probe.upper + reach <= bound
                || (radius > LARGE * bound
                    && self.upper_distance_of([a, b, c], centre, bound) <= bound)
            {
                continue;
            }
            if probe.upper > bound {
                match self.grid.is_inside(&probe, &self.bvh) {
                    Some(true) => {}
                    Some(false) if probe.upper > DOUBT * bound => return false,
                    Some(false) => {
                        let known = self.bvh.distance_to_triangle(centre, self.grid.owner(centre));
                        if known + reach <= bound {
                            continue;
                        }
                        if known > bound
                            && self.grid.estimate(centre) > CERTAIN * bound
                            && !self.bvh.is_within(centre, bound)
                        {
                            return false;
                        }
                    }
                    // The grid is too coarse for such a bound.
                    None => match self.bvh.closest_point(centre, f64::INFINITY) {
                        Some(closest) if closest.distance <= bound => {
                            if closest.distance + reach <= bound
                                || self.farthest_corner([a, b, c], closest.triangle) <= bound
                            {
                                continue;
                            }
                        }
                        Some(closest) if is_inside(&self.bvh, centre, self.is_closed) => {
                            if self.is_closed && reach - closest.distance <= bound {
                                continue;
                            }
                        }
                        _ => return false,
                    },
                }
            }
            if radius <= SMALL * bound {
                continue;
            }
            // Where the surface is open, large faces might overlook where the inside ends.
            if probe.lower > 0.0
                && (self.is_closed || radius <= bound)
                && reach - probe.lower <= bound
                && self.grid.is_inside(&probe, &self.bvh) == Some(true)
            {
                continue;
            }
            stack.extend(halves([a, b, c]));
        }
        true
    }
}

/// Whether a point is inside of a surface.
#[inline]
pub(super) fn is_inside(bvh: &Bvh, point: Vector, is_closed: bool) -> bool {
    if is_closed { bvh.is_inside(point) } else { bvh.winding_number(point) > OPEN_INSIDE }
}

#[inline]
fn largest([a, b, c]: [f64; 3]) -> f64 {
    a.max(b).max(c)
}

/// The halves of a triangle across its longest side.
#[inline]
pub(super) fn halves([a, b, c]: [Vector; 3]) -> [[Vector; 3]; 2] {
    let (ab, bc, ca) = (square(a, b), square(b, c), square(c, a));
    if ab >= bc && ab >= ca {
        let middle = scale(add(a, b), 0.5);
        [[a, middle, c], [middle, b, c]]
    } else if bc >= ca {
        let middle = scale(add(b, c), 0.5);
        [[a, b, middle], [a, middle, c]]
    } else {
        let middle = scale(add(c, a), 0.5);
        [[a, b, middle], [middle, b, c]]
    }
}

#[inline]
fn square(a: Vector, b: Vector) -> f64 {
    length_squared(subtract(a, b))
}
