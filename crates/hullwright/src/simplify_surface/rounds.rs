//! Collapses up to the bound, and a measurement that has the last word.
//!
//! At first sums of what collapses move are within the bound. That is fast, but sums are several
//! times the distance, since most collapses move the surface back. Then collapses go on that
//! samples of the distance allow ([`Guesses`]), and distances are measured, from each whole
//! triangle to the source and back. Where that refutes the result, the last collapse there is taken
//! back, until nothing is refuted. What is refuted even without any gives way to triangles of the
//! source, so that the bound always holds.

use super::distance::{NO_GUESS, Parts, Target};
use super::guesses::Guesses;
use crate::bvh::Bvh;
use crate::control::{Control, Stage};
use crate::error::Error;
use crate::geometry::vector::{Vector, centre, larger};
use crate::mesh::collapse::{Collapsed, collapse};
use crate::mesh::flip::flip_diagonals;
use crate::parallel;

/// Rounds of collapses, measuring and taking back. Few are left after four.
const MAX_ROUNDS: usize = 16;

/// In the first rounds other collapses may take the place of those that were taken back. More of
/// them gain less than a hundredth.
const ROUNDS_WITH_COLLAPSES: usize = 3;

/// What may move at first, as fractions of the largest sum: planes go first, so that a plain shape
/// does not lose its corners to a large bound, and flat places before those that bend.
const SHARES: [f64; 3] = [0.01, 0.25, 1.0];

/// A pass that removes a smaller fraction of the triangles is the last.
const WORTH_ANOTHER: f64 = 0.02;

/// Triangles between two checks for cancellation.
const PER_TASK: usize = 512;

/// The surface that distances are measured from.
pub(super) struct Source {
    /// All vertices, in the pipeline's space.
    pub points: Vec<Vector>,
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle the repaired one that stands for it, or [`NO_GUESS`].
    pub repaired: Vec<u32>,
}

impl Source {
    fn corners(&self, triangle: usize) -> [Vector; 3] {
        self.triangles[triangle].map(|vertex| self.points[vertex as usize])
    }
}

/// The surface that is to have fewer triangles.
#[derive(Clone, Copy)]
pub(super) struct Repaired<'a> {
    pub points: &'a [Vector],
    pub triangles: &'a [[u32; 3]],
}

/// A surface with its distances from the source.
pub(super) struct Reduced {
    pub triangles: Vec<[u32; 3]>,
    /// For each the repaired triangle whose place it has taken.
    pub origins: Vec<u32>,
    /// For each the triangle of the source that is nearest to its centre.
    pub nearest: Vec<u32>,
    /// Triangles of the source that are as they were, besides.
    pub kept: Vec<u32>,
    /// How far the surface is from the source at most.
    pub from_source: f64,
    /// How far the source is from the surface at most.
    pub to_source: f64,
}

/// Distances as they are known, infinite where they are not shown to be at most the bound.
struct Distances {
    /// With the triangles as they were then.
    of_result: Vec<([u32; 3], f64)>,
    /// With the triangles of the result that they are from; at the last it was refuted.
    of_source: Vec<(Vec<u32>, f64)>,
}

/// Reduces a surface as far as the bound allows.
///
/// # Errors
/// [`Error::Cancelled`], [`Error::DeadlineExceeded`].
pub(super) fn reduce(
    source: &Source,
    repaired: Repaired<'_>,
    bound: f64,
    control: &Control,
) -> Result<Reduced, Error> {
    let tree = Bvh::with_control(&source.points, &source.triangles, control)?;
    let target = Target::new(tree, &source.points, &source.triangles);
    let Collapsed { triangles, origins, owners, .. } = collapsed(repaired, bound, control)?;
    // For each triangle of the result one of the source, and for each vertex one of the result.
    let mut near = vec![NO_GUESS; triangles.len()];
    for (index, &triangle) in (0_u32..).zip(&source.repaired) {
        if let Some(&owner) = owners.get(triangle as usize) {
            near[owner as usize] = index;
        }
    }
    let mut of_vertices = vec![0; repaired.points.len()];
    for (triangle, &owner) in repaired.triangles.iter().zip(&owners) {
        triangle.iter().for_each(|&vertex| of_vertices[vertex as usize] = owner);
    }
    let mut distances = Distances {
        of_result: vec![([NO_GUESS; 3], f64::INFINITY); triangles.len()],
        of_source: vec![(Vec::new(), f64::INFINITY); source.triangles.len()],
    };
    let verification = Verification { source, target: &target, repaired, owners, bound };
    let surface = (repaired.points, triangles);
    let mut result = Guesses::new(surface, (&target, bound), &of_vertices, near);
    for round in 0..MAX_ROUNDS {
        control.report(Stage::Simplify, round as f32 / MAX_ROUNDS as f32);
        if round < ROUNDS_WITH_COLLAPSES {
            result.collapse(control)?;
        }
        verification.measure(&result, &mut distances, control)?;
        // What is measured last is the result.
        if round + 1 == MAX_ROUNDS || !take_back(&mut result, &distances) {
            break;
        }
    }
    let reduced = patched(&verification, &result, &origins, distances, control)?;
    with_nearest(reduced, &target, repaired.points, control)
}

/// Takes the last collapses back where something is beyond the bound, and leaves room for others.
/// `false` if there are none.
fn take_back(result: &mut Guesses<'_>, distances: &Distances) -> bool {
    let Distances { of_result, of_source } = distances;
    let mut steps: Vec<u32> = result
        .left()
        .filter(|&triangle| of_result[triangle as usize].1 == f64::INFINITY)
        .filter_map(|triangle| result.last_step(triangle))
        .collect();
    let refuted = of_source.iter().filter(|(_, most)| *most == f64::INFINITY);
    steps.extend(refuted.filter_map(|(used, _)| {
        used.iter().rev().find_map(|&triangle| result.last_step(triangle))
    }));
    let mut changed = Vec::new();
    steps.iter().for_each(|&step| result.take_back(step, &mut changed));
    result.open(&changed);
    !steps.is_empty()
}

/// The surface after collapses and flips whose sums are within the bound.
fn collapsed(repaired: Repaired<'_>, bound: f64, control: &Control) -> Result<Collapsed, Error> {
    let Repaired { points, triangles } = repaired;
    let is_locked = vec![false; points.len()];
    let mut mesh = Collapsed::unchanged(triangles);
    for shares in [&SHARES[..], &[1.0]] {
        collapse(&mut mesh, points, &is_locked, bound, (shares, WORTH_ANOTHER), control)?;
        // A flip makes way for collapses that were stuck.
        let origins = std::mem::take(&mut mesh.origins);
        flip_diagonals(&mut mesh, points, bound, |_, _| true);
        mesh.origins = origins;
    }
    Ok(mesh)
}

/// Takes out what is refuted even so, and puts triangles of the source in its place. That happens
/// where the bound is as small as what repair moves.
fn patched(
    verification: &Verification<'_>,
    result: &Guesses<'_>,
    origins: &[u32],
    distances: Distances,
    control: &Control,
) -> Result<Reduced, Error> {
    let &Verification { source, repaired, bound, .. } = verification;
    let Distances { of_result, of_source } = distances;
    let is_within = |&index: &u32| of_result[index as usize].1.is_finite();
    let (left, out): (Vec<u32>, Vec<u32>) = result.left().partition(is_within);
    let triangles: Vec<[u32; 3]> = left.iter().map(|&index| result.triangle(index)).collect();
    let mut of_source: Vec<f64> = of_source.into_iter().map(|(_, most)| most).collect();
    if !out.is_empty() {
        let tree = Bvh::with_control(repaired.points, &triangles, control)?;
        let target = Target::new(tree, repaired.points, &triangles);
        of_source = all(source.triangles.len(), control, |index, parts| {
            let most = target.farthest(source.corners(index), NO_GUESS, bound, parts);
            most.unwrap_or(f64::INFINITY)
        })?;
    }
    let is_missing = |index: &u32| of_source[*index as usize] == f64::INFINITY;
    let kept = (0..source.triangles.len() as u32).filter(is_missing).collect();
    let from_source = left.iter().map(|&index| of_result[index as usize].1).fold(0.0, larger);
    let to_source = of_source.iter().copied().filter(|most| most.is_finite()).fold(0.0, larger);
    let origins = left.iter().map(|&index| origins[index as usize]).collect();
    Ok(Reduced { triangles, origins, nearest: Vec::new(), kept, from_source, to_source })
}

/// Finds the nearest triangles of the source.
fn with_nearest(
    mut reduced: Reduced,
    target: &Target<'_>,
    points: &[Vector],
    control: &Control,
) -> Result<Reduced, Error> {
    reduced.nearest = all(reduced.triangles.len(), control, |index, _| {
        let corners = reduced.triangles[index].map(|vertex| points[vertex as usize]);
        target.closest(centre(corners)).unwrap_or_default()
    })?;
    Ok(reduced)
}

/// What distances are measured with.
struct Verification<'a> {
    source: &'a Source,
    target: &'a Target<'a>,
    repaired: Repaired<'a>,
    /// For each repaired triangle one of the result that stood for it at first.
    owners: Vec<u32>,
    bound: f64,
}

impl Verification<'_> {
    /// Measures both ways what has changed, and what is near to that.
    fn measure(
        &self,
        result: &Guesses<'_>,
        distances: &mut Distances,
        control: &Control,
    ) -> Result<(), Error> {
        let Self { source, target, repaired, bound, .. } = self;
        let Distances { of_result, of_source } = distances;
        let left: Vec<u32> = result.left().collect();
        let triangles: Vec<[u32; 3]> = left.iter().map(|&index| result.triangle(index)).collect();
        let is_changed: Vec<bool> = (0_u32..)
            .zip(&*of_result)
            .map(|(index, known)| result.triangle(index) != known.0 || !result.is_left(index))
            .collect();
        let open: Vec<u32> =
            left.iter().copied().filter(|&index| is_changed[index as usize]).collect();
        let found = all(open.len(), control, |place, parts| {
            let corners = result.triangle(open[place]).map(|v| repaired.points[v as usize]);
            target.farthest(corners, result.near(open[place]), *bound, parts)
        })?;
        for (&index, most) in open.iter().zip(found) {
            of_result[index as usize] = (result.triangle(index), most.unwrap_or(f64::INFINITY));
        }
        let tree = Bvh::with_control(repaired.points, &triangles, control)?;
        let surface = Target::new(tree, repaired.points, &triangles);
        let mut places = vec![NO_GUESS; result.count()];
        (0_u32..).zip(&left).for_each(|(place, &index)| places[index as usize] = place);
        let of_vertices = result.owners();
        let guess = |triangle: usize| {
            let owner = places[*self.owners.get(triangle)? as usize];
            let [vertex, ..] = repaired.triangles[triangle];
            let other = of_vertices[vertex as usize] as usize;
            if owner == NO_GUESS { places.get(other).copied() } else { Some(owner) }
        };
        let is_open = |&index: &usize| {
            let (used, most) = &of_source[index];
            !most.is_finite() || used.iter().any(|&triangle| is_changed[triangle as usize])
        };
        let open: Vec<usize> = (0..of_source.len()).filter(is_open).collect();
        let found = all(open.len(), control, |place, parts| {
            let index = open[place];
            let guess = guess(source.repaired[index] as usize).unwrap_or(NO_GUESS);
            let most = surface.farthest(source.corners(index), guess, *bound, parts);
            let used = parts.used.iter().map(|&place| left[place as usize]).collect();
            (used, most.unwrap_or(f64::INFINITY))
        })?;
        for (index, found) in open.into_iter().zip(found) {
            of_source[index] = found;
        }
        Ok(())
    }
}

/// Applies a function to indices, on all threads, with memory for each task.
fn all<R: Send>(
    count: usize,
    control: &Control,
    function: impl Fn(usize, &mut Parts) -> R + Sync + Send,
) -> Result<Vec<R>, Error> {
    let tasks = parallel::map_indices(count.div_ceil(PER_TASK), |task| {
        control.check()?;
        let mut parts = Parts::default();
        let own = task * PER_TASK..count.min((task + 1) * PER_TASK);
        Ok(own.map(|index| function(index, &mut parts)).collect::<Vec<R>>())
    });
    let tasks = tasks.into_iter().collect::<Result<Vec<_>, Error>>()?;
    Ok(tasks.into_iter().flatten().collect())
}
