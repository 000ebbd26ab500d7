//! Collapses up to the bound, and a measurement that has the last word.
//!
//! A collapse adds what it moves to what collapses before it have moved. The sum is larger than the
//! distance, since some of them move the surface back. So sums may be larger than the bound, and
//! distances are measured, from each triangle to the source and back. Where that refutes the
//! result, everything is done again, with sums within the bound there; at last within the bound
//! everywhere. What is refuted even then gives way to triangles of the source, so that the bound
//! always holds.

use super::distance::{NO_GUESS, Parts, Target};
use crate::bvh::Bvh;
use crate::control::{Control, Stage};
use crate::error::Error;
use crate::geometry::vector::{Vector, centre, larger};
use crate::mesh::collapse::{Collapsed, collapse};
use crate::mesh::flip::flip_diagonals;
use crate::parallel;

/// Sums of collapses as a multiple of the bound: those of curved surfaces are about twice their
/// distances. Larger ones are refuted so often that doing it again loses more than they gain.
const LOOSENESS: f64 = 2.0;

/// Times that a surface is reduced. In the last one all sums are within the bound.
const MAX_ATTEMPTS: usize = 5;

/// From this attempt on what is beside a refuted triangle is done again too: that ends sooner, but
/// leaves more triangles.
const WIDE_ATTEMPT: usize = 3;

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

/// Distances of triangles, where they are shown to be at most the limit.
struct Distances {
    of_result: Vec<Option<f64>>,
    of_source: Vec<Option<f64>>,
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
    // What the sums begin with.
    let mut begun = vec![0.0; repaired.triangles.len()];
    for attempt in 1..=MAX_ATTEMPTS {
        control.report(Stage::Simplify, (attempt - 1) as f32 / MAX_ATTEMPTS as f32);
        let mesh = collapsed(repaired, &begun, bound, control)?;
        let distances = measure(source, &target, repaired.points, &mesh, bound, control)?;
        let refuted = refuted(source, &mesh, &distances);
        if attempt == MAX_ATTEMPTS || !refuted.contains(&true) {
            let reduced = patched(source, repaired.points, mesh, distances, bound, control)?;
            return with_nearest(reduced, &target, repaired.points, control);
        }
        let is_last = attempt + 1 == MAX_ATTEMPTS;
        let again = if attempt < WIDE_ATTEMPT { refuted } else { near(repaired, &refuted) };
        for (begun, is_again) in begun.iter_mut().zip(again) {
            if is_again || is_last {
                *begun = (LOOSENESS - 1.0) * bound;
            }
        }
    }
    Err(Error::Cancelled)
}

/// The surface after collapses and flips.
fn collapsed(
    repaired: Repaired<'_>,
    begun: &[f64],
    bound: f64,
    control: &Control,
) -> Result<Collapsed, Error> {
    let Repaired { points, triangles } = repaired;
    let is_locked = vec![false; points.len()];
    let tolerance = LOOSENESS * bound;
    let mut mesh = Collapsed::unchanged(triangles);
    mesh.moved.copy_from_slice(begun);
    for shares in [&SHARES[..], &[1.0]] {
        collapse(&mut mesh, points, &is_locked, tolerance, (shares, WORTH_ANOTHER), control)?;
        // A flip makes way for collapses that were stuck.
        let origins = std::mem::take(&mut mesh.origins);
        flip_diagonals(&mut mesh, points, tolerance, |_, _| true);
        mesh.origins = origins;
    }
    Ok(mesh)
}

/// For each repaired triangle whether it or what stands for it is not shown to be within the bound.
fn refuted(source: &Source, mesh: &Collapsed, distances: &Distances) -> Vec<bool> {
    let is_refuted = |&owner: &u32| distances.of_result[owner as usize].is_none();
    let mut refuted: Vec<bool> = mesh.owners.iter().map(is_refuted).collect();
    for (distance, &triangle) in distances.of_source.iter().zip(&source.repaired) {
        if let (None, Some(refuted)) = (distance, refuted.get_mut(triangle as usize)) {
            *refuted = true;
        }
    }
    refuted
}

/// For each triangle whether it shares a vertex with one that is refuted: beside those the next
/// attempt would only just fail again.
fn near(repaired: Repaired<'_>, refuted: &[bool]) -> Vec<bool> {
    let mut is_touched = vec![false; repaired.points.len()];
    for (triangle, _) in repaired.triangles.iter().zip(refuted).filter(|(_, refuted)| **refuted) {
        triangle.iter().for_each(|&vertex| is_touched[vertex as usize] = true);
    }
    let touches = |triangle: &[u32; 3]| triangle.iter().any(|&vertex| is_touched[vertex as usize]);
    repaired.triangles.iter().map(touches).collect()
}

/// Takes out what is refuted even so, and puts triangles of the source in its place. That happens
/// where the bound is as small as what repair moves.
fn patched(
    source: &Source,
    points: &[Vector],
    mesh: Collapsed,
    distances: Distances,
    bound: f64,
    control: &Control,
) -> Result<Reduced, Error> {
    let Distances { of_result, mut of_source } = distances;
    let left: Vec<usize> = (0..of_result.len()).filter(|&t| of_result[t].is_some()).collect();
    let triangles: Vec<[u32; 3]> = left.iter().map(|&index| mesh.triangles[index]).collect();
    let origins = left.iter().map(|&index| mesh.origins[index]).collect();
    if left.len() < of_result.len() {
        let tree = Bvh::with_control(points, &triangles, control)?;
        let target = Target::new(tree, points, &triangles);
        of_source = all(source.triangles.len(), control, |index, parts| {
            target.farthest(source.corners(index), NO_GUESS, bound, parts)
        })?;
    }
    let is_missing = |index: &u32| of_source[*index as usize].is_none();
    let kept = (0..source.triangles.len() as u32).filter(is_missing).collect();
    let most = |distances: &[Option<f64>]| distances.iter().flatten().copied().fold(0.0, larger);
    let (from_source, to_source) = (most(&of_result), most(&of_source));
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

/// The distances both ways, each where it is at most the limit.
fn measure(
    source: &Source,
    target: &Target<'_>,
    points: &[Vector],
    mesh: &Collapsed,
    limit: f64,
    control: &Control,
) -> Result<Distances, Error> {
    // For each triangle of the result one of the source that is near.
    let mut near = vec![NO_GUESS; mesh.triangles.len()];
    for (index, &triangle) in (0_u32..).zip(&source.repaired) {
        if let Some(&owner) = mesh.owners.get(triangle as usize) {
            near[owner as usize] = index;
        }
    }
    let of_result = all(mesh.triangles.len(), control, |index, parts| {
        let corners = mesh.triangles[index].map(|vertex| points[vertex as usize]);
        target.farthest(corners, near[index], limit, parts)
    })?;
    let tree = Bvh::with_control(points, &mesh.triangles, control)?;
    let result = Target::new(tree, points, &mesh.triangles);
    let of_source = all(source.triangles.len(), control, |index, parts| {
        let corners = source.corners(index);
        let owner = mesh.owners.get(source.repaired[index] as usize);
        result.farthest(corners, owner.copied().unwrap_or(NO_GUESS), limit, parts)
    })?;
    Ok(Distances { of_result, of_source })
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
