//! Shells within shells: closed components that nothing outside can reach.
//!
//! A closed component all of whose surface has solid on both sides, such as a board within a wall, adds nothing.
//! One with solid all around it and nothing within is a cavity, as the inner faces of a crate are: no body
//! gets there, so it is filled. Components that overlap others in part stay as they are.

use crate::bvh::Bvh;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, area_normal, bounds};
use crate::mesh::PreparedMesh;

/// Points on a component's triangles that are tried, at most.
const SAMPLES: usize = 24;

/// Distance of the samples from the surface, on both sides, as a fraction of the diagonal: more than welding moves a
/// surface, less than any wall that counts.
const STEP: f64 = 1e-4;

/// Filling a cavity puts what lay loose in it within the solid: that is found in the next pass.
const PASSES: usize = 4;

/// Drops the closed components that are within the solid. Returns how many.
///
/// Components whose box lies in no other's are passed over, and most others end with the first sample.
pub(super) fn drop_nested(prepared: &mut PreparedMesh, control: &Control) -> Result<usize, Error> {
    let mut dropped = 0;
    for _ in 0..PASSES {
        if prepared.closed.len() < 2 {
            break;
        }
        let candidates = boxed_in(prepared);
        if candidates.is_empty() {
            break;
        }
        let bvh =
            Bvh::with_control(prepared.mesh.points(), &prepared.triangles_of_solid(), control)?;
        bvh.expect_winding_numbers(control)?;
        let mut is_dropped = vec![false; prepared.closed.len()];
        for (component, triangles) in candidates {
            control.check()?;
            is_dropped[component] = is_nested(prepared, &triangles, &bvh);
        }
        let found = is_dropped.iter().filter(|&&is_dropped| is_dropped).count();
        if found == 0 {
            break;
        }
        dropped += found;
        prepared.retain(|_, component| !is_dropped[component as usize]);
    }
    Ok(dropped)
}

/// Closed components whose box lies in that of another component, with their triangles.
fn boxed_in(prepared: &PreparedMesh) -> Vec<(usize, Vec<u32>)> {
    let mut members: Vec<Vec<u32>> = vec![Vec::new(); prepared.closed.len()];
    for (triangle, &component) in (0_u32..).zip(&prepared.components) {
        members[component as usize].push(triangle);
    }
    let corners = |triangles: &Vec<u32>| {
        let vertices = triangles.iter().flat_map(|&t| prepared.mesh.triangles[t as usize]);
        vertices.map(|vertex| prepared.mesh.points()[vertex as usize]).collect::<Vec<Vector>>()
    };
    let boxes: Vec<(Vector, Vector)> = members.iter().map(|own| bounds(corners(own))).collect();
    let is_boxed_in = |own: usize| {
        let (low, high) = boxes[own];
        boxes.iter().enumerate().any(|(other, (other_low, other_high))| {
            other != own && (0..3).all(|i| other_low[i] <= low[i] && high[i] <= other_high[i])
        })
    };
    let is_candidate =
        |own: &usize| prepared.closed[*own] && !members[*own].is_empty() && is_boxed_in(*own);
    let found: Vec<usize> = (0..members.len()).filter(is_candidate).collect();
    found.into_iter().map(|own| (own, std::mem::take(&mut members[own]))).collect()
}

/// Whether all samples have solid on both sides, or all on the side behind the surface with nothing in front
/// of it while the component is wound inward.
fn is_nested(prepared: &PreparedMesh, triangles: &[u32], bvh: &Bvh) -> bool {
    let step = triangles.len().div_ceil(SAMPLES).max(1);
    let sides = |&triangle: &u32| {
        let [a, b, c] = prepared.mesh.triangles[triangle as usize]
            .map(|vertex| prepared.mesh.points()[vertex as usize]);
        let centre = (a + (b + c)) * (1.0 / 3.0);
        let normal = area_normal(a, b, c).normalize_or_zero() * STEP;
        let behind = bvh.is_inside(centre + -normal);
        behind.then(|| bvh.is_inside(centre + normal))
    };
    let mut samples = triangles.iter().step_by(step);
    let Some(Some(first)) = samples.next().map(sides) else { return false };
    let is_cavity = !first;
    if is_cavity && signed_volume(prepared, triangles) > 0.0 {
        return false;
    }
    samples.all(|triangle| sides(triangle) == Some(first))
}

/// Six times the volume that triangles enclose.
fn signed_volume(prepared: &PreparedMesh, triangles: &[u32]) -> f64 {
    let corners =
        |&t: &u32| prepared.mesh.triangles[t as usize].map(|v| prepared.mesh.points()[v as usize]);
    triangles.iter().map(corners).map(|[a, b, c]| a.dot(b.cross(c))).sum()
}
