//! Planes that divide hulls: each set in two, until every hull is alone.
//!
//! For two hulls that are near each other the plane is looked for that leaves least of them on the
//! wrong side: along a face of one, in the middle of where they overlap, or at an end of that. Of
//! all these planes a set is divided by the one that does so for the whole set. So space is shared
//! out where hulls overlap, each cell is convex, and the same planes come of hulls that differ a
//! little.

use std::collections::BTreeSet;

use crate::control::Control;
use crate::error::Error;
use crate::geometry::plane::Plane;
use crate::geometry::vector::{Vector, bounds, mean, six_volumes};
use crate::hull::ConvexHull;

/// Each hull is set beside so many others, the nearest: farther ones have hulls between them, whose
/// planes divide them too.
const NEIGHBOURS: usize = 8;

/// So many directions of the least overlap are looked at for two hulls.
const DIRECTIONS: usize = 12;

/// Directions with a larger cosine are one.
const SAME_DIRECTION: f64 = 0.9999;

/// An end of an overlap has to leave this share of what its middle leaves on the wrong side, so
/// that equals share what they both hold.
const END: f64 = 0.8;

/// A plane that parts hulls of one group counts as if it left this much more on the wrong side for
/// each such group, as a share of the volume of all hulls: a thin slice.
const PARTED: f64 = 0.02;

/// The planes by which a set of hulls may be divided.
pub(super) struct Division<'a> {
    groups: &'a [u32],
    hulls: Vec<Solid>,
    planes: Vec<Between>,
    /// The volume of all hulls.
    volume: f64,
}

/// A hull.
struct Solid {
    points: Vec<Vector>,
    faces: Vec<[Vector; 3]>,
    /// Of its faces, each once.
    normals: Vec<Vector>,
    centre: Vector,
    volume: f64,
}

/// A plane between two hulls, the first one behind it.
struct Between {
    plane: Plane,
    first: usize,
    second: usize,
    /// The volume of each hull in front of it.
    above: Vec<f64>,
}

impl<'a> Division<'a> {
    /// O(h² · v) for h hulls of v vertices.
    pub(super) fn new(
        hulls: &[&ConvexHull],
        groups: &'a [u32],
        control: &Control,
    ) -> Result<Self, Error> {
        let hulls: Vec<Solid> = hulls.iter().map(|hull| Solid::new(hull)).collect();
        let boxes: Vec<(Vector, Vector)> =
            hulls.iter().map(|hull| bounds(hull.points.iter().copied())).collect();
        let mut pairs = BTreeSet::new();
        for hull in 0..hulls.len() {
            let pair = |other: usize| (hull.min(other), hull.max(other));
            pairs.extend(neighbours(hull, &boxes, &hulls).into_iter().map(pair));
        }
        let mut planes = Vec::with_capacity(pairs.len());
        for (first, second) in pairs {
            control.check()?;
            let Some(plane) = between(&hulls[first], &hulls[second]) else { continue };
            let above = hulls.iter().map(|hull| hull.volume_above(&plane)).collect();
            planes.push(Between { plane, first, second, above });
        }
        let volume = hulls.iter().map(|hull| hull.volume).sum();
        Ok(Self { groups, hulls, planes, volume })
    }

    /// The plane that divides some hulls, and those behind and in front of it; `None` where all
    /// have one centre. O(planes · hulls).
    pub(super) fn divide(&self, hulls: &[usize]) -> Option<(Plane, [Vec<usize>; 2])> {
        let usable =
            |between: &&Between| hulls.contains(&between.first) && hulls.contains(&between.second);
        let ranked = self.planes.iter().filter(usable).map(|of| (self.cost(of, hulls), of));
        let best = ranked.min_by(|a, b| {
            let ((cost, lopsided), (cost2, lopsided2)) = (a.0, b.0);
            cost.total_cmp(&cost2).then(lopsided.cmp(&lopsided2))
        });
        let Some((_, best)) = best else { return self.divide_by_centres(hulls) };
        let (above, below) = hulls.iter().partition(|&&hull| self.is_above(best, hull));
        Some((best.plane, [below, above]))
    }

    fn is_above(&self, between: &Between, hull: usize) -> bool {
        match hull {
            _ if hull == between.first => false,
            _ if hull == between.second => true,
            _ => 2.0 * between.above[hull] > self.hulls[hull].volume,
        }
    }

    /// The volume that a plane leaves on the wrong side, and how unevenly it divides.
    fn cost(&self, between: &Between, hulls: &[usize]) -> (f64, usize) {
        let mut wrong = 0.0;
        let mut sides = BTreeSet::new();
        let mut balance = 0_i64;
        for &hull in hulls {
            let (above, is_above) = (between.above[hull], self.is_above(between, hull));
            wrong += if is_above { self.hulls[hull].volume - above } else { above };
            balance += if is_above { 1 } else { -1 };
            sides.insert((self.groups[hull], is_above));
        }
        let parted =
            sides.iter().filter(|(group, is_above)| *is_above && sides.contains(&(*group, false)));
        (wrong + parted.count() as f64 * PARTED * self.volume, balance.unsigned_abs() as usize)
    }

    /// Across the longest side of the box around their centres, for hulls of which no two are
    /// neighbours.
    fn divide_by_centres(&self, hulls: &[usize]) -> Option<(Plane, [Vec<usize>; 2])> {
        let (min, max) = bounds(hulls.iter().map(|&hull| self.hulls[hull].centre));
        let size = max - min;
        let axes = [Vector::X, Vector::Y, Vector::Z];
        let normal = axes.into_iter().max_by(|a, b| size.dot(*a).total_cmp(&size.dot(*b)))?;
        let plane = Plane { normal, offset: normal.dot(min + max) / 2.0 };
        let (above, below): (Vec<usize>, Vec<usize>) =
            hulls.iter().partition(|&&hull| plane.height(self.hulls[hull].centre) > 0.0);
        (!above.is_empty() && !below.is_empty()).then_some((plane, [below, above]))
    }
}

impl Solid {
    fn new(hull: &ConvexHull) -> Self {
        let points = hull.points().to_vec();
        let mut normals: Vec<Vector> = Vec::new();
        for Plane { normal, .. } in hull.face_planes() {
            let is_known = |known: &Vector| known.dot(normal) > SAME_DIRECTION;
            if normal != Vector::ZERO && !normals.iter().any(is_known) {
                normals.push(normal);
            }
        }
        let centre = mean(&points);
        Self { points, faces: hull.faces().collect(), normals, centre, volume: hull.volume() }
    }

    /// How far it reaches in a direction.
    fn reach(&self, normal: Vector) -> f64 {
        self.points.iter().fold(f64::NEG_INFINITY, |most, point| most.max(normal.dot(*point)))
    }

    /// The volume in front of a plane: that between the parts of faces there and a point of the
    /// plane, to which the cut itself adds nothing.
    fn volume_above(&self, plane: &Plane) -> f64 {
        let (high, low) = (self.reach(plane.normal), -self.reach(-plane.normal));
        if high <= plane.offset {
            return 0.0;
        }
        if low >= plane.offset {
            return self.volume;
        }
        let apex = self.centre - plane.normal * plane.height(self.centre);
        let parts =
            self.faces.iter().flat_map(|face| above(face.map(|at| at - apex), plane.normal));
        six_volumes(parts) / 6.0
    }
}

/// The part of a triangle in front of a plane through the origin, as up to two triangles.
fn above(corners: [Vector; 3], normal: Vector) -> impl Iterator<Item = [Vector; 3]> {
    let heights = corners.map(|corner| normal.dot(corner));
    let mut polygon = [Vector::ZERO; 4];
    let mut count = 0;
    for (k, next) in [(0, 1), (1, 2), (2, 0)] {
        if heights[k] >= 0.0 {
            polygon[count] = corners[k];
            count += 1;
        }
        if (heights[k] < 0.0) != (heights[next] < 0.0) {
            let share = heights[k] / (heights[k] - heights[next]);
            polygon[count] = corners[k] + (corners[next] - corners[k]) * share;
            count += 1;
        }
    }
    let [a, b, c, d] = polygon;
    [[a, b, c], [a, c, d]].into_iter().take(count.saturating_sub(2))
}

/// The hulls whose boxes are nearest, of equally near ones those with the nearest centres.
fn neighbours(hull: usize, boxes: &[(Vector, Vector)], hulls: &[Solid]) -> Vec<usize> {
    let (min, max) = boxes[hull];
    let mut others: Vec<(f64, f64, usize)> = (0..boxes.len())
        .filter(|&other| other != hull)
        .map(|other| {
            let gap = (boxes[other].0 - max).max(min - boxes[other].1).max(Vector::ZERO);
            (gap.length(), hulls[other].centre.distance(hulls[hull].centre), other)
        })
        .collect();
    others.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
    others.into_iter().take(NEIGHBOURS).map(|(.., other)| other).collect()
}

/// The plane between two hulls that leaves least of them on the wrong side, with the second one in
/// front.
fn between(first: &Solid, second: &Solid) -> Option<Plane> {
    let normals = first.normals.iter().copied().chain(second.normals.iter().map(|own| -*own));
    let mut overlaps: Vec<(f64, f64, Vector)> =
        normals.map(|normal| (first.reach(normal), -second.reach(-normal), normal)).collect();
    overlaps.sort_by(|a, b| (a.0 - a.1).total_cmp(&(b.0 - b.1)));
    let mut best: Option<(f64, Plane)> = None;
    for (high, low, normal) in overlaps.into_iter().take(DIRECTIONS) {
        if high <= low {
            // Nothing is on the wrong side; first come those farthest apart.
            return Some(Plane { normal, offset: (high + low) / 2.0 });
        }
        for (offset, share) in [((high + low) / 2.0, END), (high, 1.0), (low, 1.0)] {
            let plane = Plane { normal, offset };
            let wrong = first.volume_above(&plane) + second.volume - second.volume_above(&plane);
            if best.is_none_or(|(least, _)| wrong * share < least) {
                best = Some((wrong * share, plane));
            }
        }
    }
    best.map(|(_, plane)| plane)
}
