//! Hulls to be shown, and all that they are joined to: shapes, figures, and errors point by point.

use std::ops::Range;

use hullwright::measure::{MeasuredHulls, Measurement, measure};
use hullwright::{Control, ConvexHull, Error, Hull, MergeTree, TriangleMesh, convex_hull};
use hullwright_formats::NamedMesh;
use rayon::prelude::*;

use super::document::{Geometry, HullEntry, SetEntry, StateEntry, UncoveredEntry};
use super::errors::{overlaps, uncovered};
use super::subject::{Subject, bytes, corners, divisions, map_places, points, points_of};
use crate::Vector;

/// Hulls to be shown: of a method or of any tool.
#[derive(Debug, Clone)]
pub struct HullSet<'a> {
    name: String,
    hulls: &'a [Hull],
    tree: Option<&'a MergeTree>,
    facts: Vec<(String, String)>,
}

impl<'a> HullSet<'a> {
    /// Hulls under a name. Without a [`tree`](Self::tree) their errors are sampled.
    pub fn new(name: impl Into<String>, hulls: &'a [Hull]) -> Self {
        Self { name: name.into(), hulls, tree: None, facts: Vec::new() }
    }

    /// The joins of these very hulls: the page gets a slider from all hulls to one, and errors are
    /// verified.
    #[must_use]
    pub fn tree(mut self, tree: &'a MergeTree) -> Self {
        self.tree = Some(tree);
        self
    }

    /// A name and a value that are shown with the figures, such as `time` and `74 ms`.
    #[must_use]
    pub fn fact(mut self, name: impl Into<String>, value: impl Into<String>) -> Self {
        self.facts.push((name.into(), value.into()));
        self
    }
}

/// Hulls that some tool wrote, each as the convex hull that an engine makes of its points; one
/// without a volume as it is. Those without triangles, or with a coordinate that is not finite,
/// are left out.
pub fn hulls_of(hulls: &[NamedMesh]) -> Vec<Hull> {
    let is_usable = |named: &&NamedMesh| {
        let TriangleMesh { positions, triangles, .. } = &named.mesh;
        !triangles.is_empty() && positions.iter().flatten().all(|x| x.is_finite())
    };
    let hull = |named: &NamedMesh| {
        let TriangleMesh { positions, triangles, .. } = &named.mesh;
        let as_it_is = || ConvexHull::from((positions.clone(), triangles.clone()));
        Hull::from(convex_hull(positions).unwrap_or_else(|_| as_it_is()))
    };
    hulls.iter().filter(is_usable).map(hull).collect()
}

/// Points on all hulls and joint hulls, unless their corners alone are more.
const MOST_SAMPLES: usize = 120_000;

/// Prepares hulls for the page. `objects` are the parts of the source that have a name.
pub(super) fn shown(
    set: HullSet<'_>,
    subject: &Subject<'_>,
    objects: &[Range<usize>],
    geometry: &mut Geometry,
    control: &Control,
) -> Result<SetEntry, Error> {
    let measured = measure(subject.source, set.hulls, &subject.options(), control)?;
    let joins = set.tree.map(MergeTree::joins).unwrap_or_default();
    let hulls: Vec<&Hull> = set.hulls.iter().chain(joins.iter().map(|join| &join.hull)).collect();
    let joined: Vec<[usize; 2]> = joins.iter().map(|join| join.joined).collect();
    let part = |(index, &hull): (usize, &&Hull)| {
        let part = MeasuredHulls::new(std::slice::from_ref(hull), &subject.mesh);
        part.map_err(|error| match error {
            Error::UnusableHull { reason, .. } => Error::UnusableHull { hull: index, reason },
            error => error,
        })
    };
    let parts: Vec<_> = hulls.par_iter().enumerate().map(part).collect();
    let parts = parts.into_iter().collect::<Result<Vec<_>, _>>()?;
    let overlaps = match measured.iou {
        Some(_) => overlaps(&parts, set.hulls.len(), &joined, subject),
        None => Vec::new(),
    };
    check(control)?;
    let states = states(&set, &hulls, &joined, &measured, &overlaps);

    let faces = |hull: &&Hull| corners(&hull.shape.points, &hull.shape.triangles);
    let faces: Vec<[Vector; 3]> = hulls.iter().flat_map(faces).collect();
    let divisions = divisions(&faces, subject.mesh.diagonal(), MOST_SAMPLES);
    let points = points(&faces, &divisions);
    let protrusions = map_places(&points, |point| subject.distance(point));
    check(control)?;
    let most_of_each = most_of_each(&hulls, &divisions, &protrusions);
    let uncovered =
        uncovered(subject, set.hulls, parts.get(set.hulls.len()..).unwrap_or_default())?;
    check(control)?;

    let (protrusion_most, protrusion_bytes) = bytes(&protrusions);
    let positions = hulls.iter().flat_map(|hull| &hull.shape.points).map(|&point| point.into());
    let triangles = hulls.iter().flat_map(|hull| hull.shape.triangles.iter().flatten().copied());
    let entries = hulls.iter().zip(most_of_each).map(|(hull, sampled)| HullEntry {
        vertices: hull.shape.points.len(),
        triangles: hull.shape.triangles.len(),
        volume: hull.shape.volume(),
        protrusion: hull
            .errors
            .protrusion_max
            .map_or(sampled, |most| most / subject.mesh.diagonal()),
        is_verified: hull.errors.protrusion_max.is_some(),
        objects: objects_of(hull, objects),
    });
    Ok(SetEntry {
        name: set.name,
        facts: set.facts,
        leaves: set.hulls.len(),
        is_verified: set.tree.is_some(),
        hulls: entries.collect(),
        joins: joined,
        states,
        positions: geometry.push_points(positions, &subject.frame()),
        triangles: geometry.push_u32(triangles),
        divisions: geometry.push_u8(divisions),
        protrusion_most,
        protrusions: geometry.push_u8(protrusion_bytes),
        uncovered: UncoveredEntry {
            most: uncovered.most,
            values: geometry.push_u8(uncovered.values),
            change_joins: geometry.push_u16(uncovered.changes.iter().map(|change| change.join)),
            change_samples: geometry.push_u32(uncovered.changes.iter().map(|change| change.sample)),
            change_values: geometry.push_u8(uncovered.changes.iter().map(|change| change.value)),
        },
    })
}

/// An error once the work is cancelled.
fn check(control: &Control) -> Result<(), Error> {
    if control.is_cancelled() { Err(Error::Cancelled) } else { Ok(()) }
}

/// The greatest sampled protrusion of each hull.
fn most_of_each(hulls: &[&Hull], divisions: &[u8], protrusions: &[f64]) -> Vec<f64> {
    let (mut divisions, mut protrusions) = (divisions.iter(), protrusions.iter());
    let of_hull = |hull: &&Hull| {
        let own = divisions.by_ref().take(hull.shape.triangles.len());
        let points = own.map(|&parts| points_of(parts)).sum();
        protrusions.by_ref().take(points).copied().fold(0.0, f64::max)
    };
    hulls.iter().map(of_hull).collect()
}

/// The figures of each state, from all hulls down to one. Lengths are fractions of the diagonal.
fn states(
    set: &HullSet<'_>,
    hulls: &[&Hull],
    joined: &[[usize; 2]],
    measured: &Measurement,
    overlaps: &[f64],
) -> Vec<StateEntry> {
    let count = |index: usize| hulls.get(index).map_or(0, |hull| hull.shape.points.len());
    let mut vertices: usize = (0..set.hulls.len()).map(count).sum();
    let Some(tree) = set.tree else {
        return vec![StateEntry {
            hulls: set.hulls.len(),
            vertices,
            error: measured.hausdorff,
            protrusion: measured.protrusion.max,
            uncovered: measured.uncovered.max,
            iou: measured.iou,
        }];
    };
    let states = tree.curve().into_iter().enumerate().map(|(state, point)| {
        if let Some(&[first, second]) = state.checked_sub(1).and_then(|join| joined.get(join)) {
            vertices += count(set.hulls.len() + state - 1);
            vertices = vertices.saturating_sub(count(first) + count(second));
        }
        let relative = |length: f64| length / measured.diagonal;
        StateEntry {
            hulls: point.hulls,
            vertices,
            error: relative(point.error),
            protrusion: relative(point.protrusion_max),
            uncovered: relative(point.uncovered_max),
            iou: overlaps.get(state).copied(),
        }
    });
    states.collect()
}

/// The named parts of the source that a hull stands for.
fn objects_of(hull: &Hull, objects: &[Range<usize>]) -> Vec<usize> {
    let sources = hull.provenance.source_triangles.iter();
    let mut found: Vec<usize> = sources
        .map(|&triangle| objects.partition_point(|object| object.end <= triangle as usize))
        .filter(|&object| object < objects.len())
        .collect();
    found.sort_unstable();
    found.dedup();
    found
}
