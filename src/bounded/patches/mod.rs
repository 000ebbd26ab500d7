//! Patches: the paper's groups (section 3.4.1) of a simplified mesh, or cells of a coarse one, halved until the
//! hull of each, or of a part that contains it, fits.
//!
//! | file | contents |
//! |---|---|
//! | `patch` | a patch, and all patches |
//! | `patch_mesh` | the mesh that is divided, and the surface that it represents |
//! | `whole_components` | components that are one patch |
//! | `division` | halving of groups |
//! | `conflicts` | which patches no hull can contain together |

pub(super) mod conflicts;
mod division;
pub(crate) mod patch;
pub(super) mod patch_mesh;
mod whole_components;

use std::sync::Arc;

use super::cells::components;
use super::clustering::Clustered;
use super::containment::solid::Solid;
use super::settings::Settings;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::length;
use crate::hull::HullBuilder;
use crate::mesh::adjacency::{Adjacency, NO_NEIGHBOUR};
use crate::mesh::grouping::{group, members};
use crate::parallel;
use division::divide;
use patch::{Patch, Patches};
use patch_mesh::PatchMesh;
use whole_components::WholeComponents;

/// Above this number of groups the grouping is repeated with a larger threshold: under the first
/// one, each facet of a fine cylinder is a group.
const MAX_GROUPS: usize = 600;

/// Factor between the thresholds of repeated groupings.
const THRESHOLD_GROWTH: f64 = 2.0;

/// Divides the surface into patches. O(n log n) for n triangles.
///
/// # Errors
/// [`Error::Cancelled`].
pub(crate) fn divide_into_patches(
    patch_mesh: PatchMesh,
    solid: &Solid,
    settings: &Settings,
    control: &Control,
) -> Result<Patches, Error> {
    let adjacency = Adjacency::new(&patch_mesh.mesh);
    let mut groups = groups(&patch_mesh, &adjacency, settings, control)?;
    let WholeComponents { is_whole, mut patches, mut labels } =
        WholeComponents::find(&patch_mesh, solid, settings, control)?;
    // A group of a clustered mesh may extend over several components.
    for group in &mut groups {
        group.retain(|&triangle| !is_whole[patch_mesh.components[triangle as usize] as usize]);
    }
    groups.retain(|group| !group.is_empty());
    if !patch_mesh.parts.is_empty() {
        groups = between_cuts(&patch_mesh, &adjacency, &groups);
    }
    let largest = settings.patch_size * area(&patch_mesh).sqrt();
    let parts = parallel::map_largest_first(&groups, Vec::len, |group| {
        divide(&patch_mesh, group, solid, largest, settings, control)
    });
    let mut blocks: Vec<Vec<u32>> = (0..patches.len() as u32).map(|patch| vec![patch]).collect();
    for part in parts {
        for block in part? {
            let first = patches.len() as u32;
            for (patch, triangles) in block {
                for triangle in triangles {
                    labels[triangle as usize] = patches.len() as u32;
                }
                patches.push(patch);
            }
            blocks.push((first..patches.len() as u32).collect());
        }
    }
    let neighbours = neighbours(&adjacency, &labels);
    let PatchMesh { mesh, surface, parents, .. } = patch_mesh;
    let (mut surface, mut parents) = (Arc::new(surface), Arc::new(parents));
    if let Some(clustered) = solid.clustered.as_deref() {
        (surface, parents) = (clustered.surface.clone(), clustered.parents.clone());
        represent_source(&mut patches, clustered, settings, control)?;
    }
    let conflicts = Vec::new();
    Ok(Patches { patches, neighbours, blocks, conflicts, surface, parents, mesh, labels })
}

/// The paper's groups, each as its triangles.
fn groups(
    PatchMesh { mesh, .. }: &PatchMesh,
    adjacency: &Adjacency,
    settings: &Settings,
    control: &Control,
) -> Result<Vec<Vec<u32>>, Error> {
    let mut threshold = settings.bound.grouping_threshold();
    let mut grouping = group(mesh, adjacency, threshold, threshold, control)?;
    while grouping.count > MAX_GROUPS && threshold < settings.bound.protrusion() {
        threshold *= THRESHOLD_GROWTH;
        grouping = group(mesh, adjacency, threshold, threshold, control)?;
    }
    Ok(members(&grouping.labels, grouping.count))
}

/// The connected parts of groups between cuts.
fn between_cuts(mesh: &PatchMesh, adjacency: &Adjacency, groups: &[Vec<u32>]) -> Vec<Vec<u32>> {
    let PatchMesh { planes, parts, .. } = mesh;
    let mut labels = vec![u32::MAX; planes.len()];
    for (label, group) in (0..).zip(groups) {
        group.iter().for_each(|&triangle| labels[triangle as usize] = label);
    }
    let is_cut = |triangle: u32, _: usize, other: u32| {
        let (a, b) = (triangle as usize, other as usize);
        labels[a] != labels[b] || planes[a] == planes[b] && parts[a] != parts[b]
    };
    let components = components(adjacency, is_cut);
    let count = components.iter().max().map_or(0, |&last| last as usize + 1);
    let mut groups = members(&components, count);
    // What is in no group is whole already.
    groups.retain(|group| group.iter().all(|&triangle| labels[triangle as usize] != u32::MAX));
    groups
}

fn area(mesh: &PatchMesh) -> f64 {
    (0..mesh.mesh.triangles.len() as u32).map(|t| 0.5 * length(mesh.normal(t))).sum()
}

/// Pairs of labels with a common edge, ascending.
fn neighbours(adjacency: &Adjacency, labels: &[u32]) -> Vec<(u32, u32)> {
    let mut neighbours = Vec::new();
    for (triangle, &a) in (0_u32..).zip(labels) {
        for other in adjacency.triangle_neighbours(triangle) {
            if other != NO_NEIGHBOUR {
                let b = labels[other as usize];
                if a < b {
                    neighbours.push((a, b));
                }
            }
        }
    }
    neighbours.sort_unstable();
    neighbours.dedup();
    neighbours
}

/// Gives patches of a clustered mesh the source's triangles that theirs represent, and the points
/// of those.
fn represent_source(
    patches: &mut [Patch],
    clustered: &Clustered,
    settings: &Settings,
    control: &Control,
) -> Result<(), Error> {
    let mut owners = vec![u32::MAX; clustered.mesh.triangles.len()];
    for (index, patch) in (0..).zip(&mut *patches) {
        patch.triangles.drain(..).for_each(|triangle| owners[triangle as usize] = index);
    }
    for (triangle, &representative) in (0..).zip(&clustered.representatives) {
        if let Some(&owner) = owners.get(representative as usize)
            && let Some(patch) = patches.get_mut(owner as usize)
        {
            patch.triangles.push(triangle);
        }
    }
    control.check()?;
    let points = parallel::map(patches, |patch: &Patch| {
        control.check()?;
        let all = clustered.surface.positions_of(patch.triangles.iter().copied());
        let mut reducer = HullBuilder::new().with_least_tolerance(settings.bound.tolerance());
        let points = reducer.vertices_of(&all).unwrap_or_else(|| all.clone());
        Ok((all, points))
    });
    for (patch, result) in patches.iter_mut().zip(points) {
        let (all, points) = result?;
        if !points.is_empty() {
            patch.set_points(points);
        }
        patch.surface_points = all;
    }
    Ok(())
}
