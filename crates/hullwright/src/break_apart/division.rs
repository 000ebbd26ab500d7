//! Planes that divide hulls: each set in two, until every hull is alone.
//!
//! A plane between two hulls lies in the middle of where they overlap, along the face that shows
//! the least overlap. Of all such planes a set is divided by the one that reaches least deep into
//! its hulls. So space is shared out where hulls overlap, each cell is convex, and hulls that move
//! a little move a plane by as little.

use std::collections::BTreeSet;

use crate::control::Control;
use crate::error::Error;
use crate::geometry::plane::Plane;
use crate::geometry::vector::{Vector, bounds, diagonal, mean};
use crate::hull::ConvexHull;

/// Each hull is set beside so many others, the nearest: farther ones have hulls between them, whose
/// planes divide them too.
const NEIGHBOURS: usize = 8;

/// A plane that parts hulls of one group counts as this much deeper for each such group, as a
/// fraction of the diagonal of all hulls: less than anybody notices of where a piece ends.
const PARTED: f64 = 0.02;

/// How far a hull reaches along a plane's normal, from the plane.
#[derive(Clone, Copy)]
struct Extent {
    low: f64,
    high: f64,
}

impl Extent {
    fn of(points: &[Vector], plane: &Plane) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for &point in points {
            let height = plane.height(point);
            (low, high) = (low.min(height), high.max(height));
        }
        Self { low, high }
    }

    fn is_above(&self) -> bool {
        self.low + self.high > 0.0
    }

    /// How far the plane reaches into the hull from the side of which there is less.
    fn depth(&self) -> f64 {
        self.high.min(-self.low).max(0.0)
    }
}

/// The planes by which a set of hulls may be divided.
pub(super) struct Division<'a> {
    groups: &'a [u32],
    /// How much deeper a plane counts for each group that it parts.
    parted: f64,
    planes: Vec<Plane>,
    /// For each plane, of each hull.
    extents: Vec<Vec<Extent>>,
    centres: Vec<Vector>,
}

impl<'a> Division<'a> {
    /// O(n² + n · faces · vertices) for n hulls.
    pub(super) fn new(
        hulls: &[&ConvexHull],
        groups: &'a [u32],
        control: &Control,
    ) -> Result<Self, Error> {
        let centres: Vec<Vector> = hulls.iter().map(|hull| mean(hull.points())).collect();
        let boxes: Vec<(Vector, Vector)> =
            hulls.iter().map(|hull| bounds(hull.points().iter().copied())).collect();
        let faces: Vec<Vec<Plane>> = hulls.iter().map(|hull| hull.face_planes()).collect();
        let mut planes = Vec::new();
        for first in 0..hulls.len() {
            control.check()?;
            for second in neighbours(first, &boxes, &centres) {
                let normals = faces[first].iter().map(|face| face.normal);
                let of_second = faces[second].iter().map(|face| -face.normal);
                let normals = normals.chain(of_second);
                planes.extend(between(hulls[first].points(), hulls[second].points(), normals));
            }
        }
        let mut extents = Vec::with_capacity(planes.len());
        for plane in &planes {
            control.check()?;
            extents.push(hulls.iter().map(|hull| Extent::of(hull.points(), plane)).collect());
        }
        let parted = PARTED * diagonal(hulls.iter().flat_map(|hull| hull.points()).copied());
        Ok(Self { groups, parted, planes, extents, centres })
    }

    /// The plane that divides some hulls, and those behind and in front of it; `None` where all
    /// have one centre. O(planes · hulls).
    pub(super) fn divide(&self, hulls: &[usize]) -> Option<(Plane, [Vec<usize>; 2])> {
        let mut best: Option<(f64, usize, usize)> = None;
        for (index, extents) in self.extents.iter().enumerate() {
            let above = hulls.iter().filter(|&&hull| extents[hull].is_above()).count();
            let fewer = above.min(hulls.len() - above);
            if fewer == 0 {
                continue;
            }
            let depth: f64 = hulls.iter().map(|&hull| extents[hull].depth()).sum();
            let sides: BTreeSet<(u32, bool)> =
                hulls.iter().map(|&hull| (self.groups[hull], extents[hull].is_above())).collect();
            let parted = sides.iter().filter(|side| side.1 && sides.contains(&(side.0, false)));
            let depth = depth + parted.count() as f64 * self.parted;
            let is_better = best.is_none_or(|(least, most_even, _)| {
                depth < least || (depth == least && fewer > most_even)
            });
            if is_better {
                best = Some((depth, fewer, index));
            }
        }
        let Some((.., index)) = best else { return self.divide_by_centres(hulls) };
        let is_above = |hull: &&usize| self.extents[index][**hull].is_above();
        let (above, below) = hulls.iter().partition(is_above);
        Some((self.planes[index], [below, above]))
    }

    /// Across the longest side of the box around their centres, for hulls of which no two stand
    /// side by side.
    fn divide_by_centres(&self, hulls: &[usize]) -> Option<(Plane, [Vec<usize>; 2])> {
        let (min, max) = bounds(hulls.iter().map(|&hull| self.centres[hull]));
        let size = max - min;
        let axes = [Vector::X, Vector::Y, Vector::Z];
        let normal = axes.into_iter().max_by(|a, b| size.dot(*a).total_cmp(&size.dot(*b)))?;
        let plane = Plane { normal, offset: normal.dot(min + max) / 2.0 };
        let (above, below): (Vec<usize>, Vec<usize>) =
            hulls.iter().partition(|&&hull| plane.height(self.centres[hull]) > 0.0);
        (!above.is_empty() && !below.is_empty()).then_some((plane, [below, above]))
    }
}

/// The hulls whose boxes are nearest, of equally near ones those with the nearest centres.
fn neighbours(hull: usize, boxes: &[(Vector, Vector)], centres: &[Vector]) -> Vec<usize> {
    let (min, max) = boxes[hull];
    let mut others: Vec<(f64, f64, usize)> = (0..boxes.len())
        .filter(|&other| other != hull)
        .map(|other| {
            let gap = (boxes[other].0 - max).max(min - boxes[other].1).max(Vector::ZERO);
            (gap.length(), centres[other].distance(centres[hull]), other)
        })
        .collect();
    others.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
    others.into_iter().take(NEIGHBOURS).map(|(.., other)| other).collect()
}

/// The plane between two hulls along the normal under which they overlap least, with the second one
/// in front.
fn between(
    first: &[Vector],
    second: &[Vector],
    normals: impl Iterator<Item = Vector>,
) -> Option<Plane> {
    let mut best: Option<(f64, Plane)> = None;
    for normal in normals.filter(|normal| *normal != Vector::ZERO) {
        let reach = |points: &[Vector], normal: Vector| {
            points.iter().fold(f64::NEG_INFINITY, |most, point| most.max(normal.dot(*point)))
        };
        let (high, low) = (reach(first, normal), -reach(second, -normal));
        if best.is_none_or(|(overlap, _)| high - low < overlap) {
            best = Some((high - low, Plane { normal, offset: (high + low) / 2.0 }));
        }
    }
    best.map(|(_, plane)| plane)
}
