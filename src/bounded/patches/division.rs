//! Division of a group of triangles into patches: it is halved along its longest principal axis
//! until each part is small and its hull fits.

use super::patch::Patch;
use super::patch_mesh::PatchMesh;
use crate::bounded::containment::fit_tester::FitTester;
use crate::bounded::containment::solid::Solid;
use crate::bounded::growing_hull::GrowingHull;
use crate::bounded::settings::Settings;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, add, diagonal, dot, length, scale, subtract};
use crate::hull::HullBuilder;

/// Triangles whose extent exceeds that of the longest of them by this factor can be divided by
/// size. Halving a bundle of needles across leaves parts as long as before: a tube of 300 facets
/// would become 5,000 patches.
const MIN_ELONGATION: f64 = 1.5;

/// Cells of a patch that are compared with each other: a hull around empty space has some of them
/// on either side of it.
const MAX_COMPARED: usize = 16;

/// Steps of the power iteration for the longest principal axis: any axis near it serves.
const POWER_STEPS: usize = 30;

/// Start of the power iteration: oblique, since flat groups are often orthogonal to an axis.
const POWER_START: Vector = [1.0, 0.7, 0.4];

/// Patches that merging joins from the start, with their triangles.
pub(super) type Block = Vec<(Patch, Vec<u32>)>;

/// Halves a group until no part is larger than `largest`, and the hull of each part, or of one that
/// contains it, fits. Parts of the same fitting hull form a block, others are blocks of their own.
/// O(n log n) for n triangles, and two fit tests per patch.
///
/// # Errors
/// [`Error::Cancelled`].
pub(super) fn divide(
    mesh: &PatchMesh,
    group: &[u32],
    solid: &Solid,
    largest: f64,
    settings: &Settings,
    control: &Control,
) -> Result<Vec<Block>, Error> {
    let mut tester = FitTester::new(solid, settings.bound.search());
    let mut reducer = HullBuilder::new().with_least_tolerance(settings.bound.tolerance());
    let mut stack = vec![(group.to_vec(), false)];
    let mut blocks: Vec<Block> = Vec::new();
    while let Some((triangles, mut is_in_block)) = stack.pop() {
        control.check()?;
        let mut make = || mesh.patch(&triangles, &mut reducer);
        let mut fits =
            |patch: &Patch| tester.fits(&GrowingHull::new(&patch.points, patch.outward), false);
        let swallows = || swallows_space(mesh, &triangles, solid, settings.bound.search());
        if triangles.len() > 1 && is_large(mesh, &triangles, largest) {
            if !is_in_block && fits(&make()) && !swallows() {
                is_in_block = true;
                // Its parts are next on the stack.
                blocks.push(Vec::new());
            }
        } else {
            let patch = make();
            // A part of a hull that fits, and holds no empty space, also fits.
            let is_fitting = triangles.len() == 1 || (is_in_block || fits(&patch)) && !swallows();
            if is_fitting {
                match blocks.last_mut() {
                    Some(block) if is_in_block => block.push((patch, triangles)),
                    _ => blocks.push(vec![(patch, triangles)]),
                }
                continue;
            }
        }
        let (first, second) = halves(mesh, &triangles);
        stack.extend([(second, is_in_block), (first, is_in_block)]);
    }
    Ok(blocks)
}

/// Whether a hull of several cells, all of whose faces may lie on the surface, holds empty space: a
/// point between two cells does not fit. Small patches have no room for that.
fn swallows_space(mesh: &PatchMesh, triangles: &[u32], solid: &Solid, bound: f64) -> bool {
    if mesh.parts.is_empty() {
        return false;
    }
    let units = units(mesh, triangles);
    let step = units.len().div_ceil(MAX_COMPARED);
    let centres: Vec<Vector> =
        units.iter().step_by(step).map(|unit| mesh.centre_of(unit)).collect();
    centres.iter().enumerate().any(|(index, &first)| {
        centres[..index].iter().any(|&second| solid.separates(first, second, bound))
    })
}

/// Whether triangles extend farther than `largest`, and not because a single one does.
fn is_large(mesh: &PatchMesh, triangles: &[u32], largest: f64) -> bool {
    let all = extent(mesh, triangles);
    all > largest
        && units(mesh, triangles).iter().all(|unit| all > MIN_ELONGATION * extent(mesh, unit))
}

/// Diagonal of the bounding box of triangles.
fn extent(mesh: &PatchMesh, triangles: &[u32]) -> f64 {
    diagonal(triangles.iter().flat_map(|&triangle| mesh.corners(triangle)))
}

/// The parts that triangles are halved by: whole cells, or the triangles of a single cell.
fn units(mesh: &PatchMesh, triangles: &[u32]) -> Vec<Vec<u32>> {
    let mut ordered: Vec<u32> = triangles.to_vec();
    ordered.sort_by_key(|&triangle| (mesh.cells[triangle as usize], triangle));
    let cell = |triangle: &u32| mesh.cells[*triangle as usize];
    let units: Vec<Vec<u32>> =
        ordered.chunk_by(|a, b| cell(a) == cell(b)).map(<[u32]>::to_vec).collect();
    if units.len() > 1 { units } else { ordered.into_iter().map(|t| vec![t]).collect() }
}

/// Two halves along the longest principal axis. Neither is empty for two triangles or more.
fn halves(mesh: &PatchMesh, triangles: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let units = units(mesh, triangles);
    let centres: Vec<Vector> = units.iter().map(|unit| mesh.centre_of(unit)).collect();
    let sum = centres.iter().fold([0.0; 3], |sum, &centre| add(sum, centre));
    let mean = scale(sum, 1.0 / units.len() as f64);
    let mut covariance = [[0.0; 3]; 3];
    for &centre in &centres {
        let away = subtract(centre, mean);
        for (row, &x) in covariance.iter_mut().zip(&away) {
            for (entry, &y) in row.iter_mut().zip(&away) {
                *entry += x * y;
            }
        }
    }
    let axis = principal_axis(covariance);
    let mut order: Vec<(f64, usize)> =
        (0..units.len()).map(|unit| (dot(axis, subtract(centres[unit], mean)), unit)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let half = order.partition_point(|entry| entry.0 < 0.0).clamp(1, order.len().max(2) - 1);
    let part = |entries: &[(f64, usize)]| {
        let mut part: Vec<u32> =
            entries.iter().flat_map(|entry| &units[entry.1]).copied().collect();
        part.sort_unstable();
        part
    };
    (part(&order[..half]), part(&order[half..]))
}

/// About the eigenvector of the greatest eigenvalue, by power iteration.
fn principal_axis(covariance: [Vector; 3]) -> Vector {
    let mut axis = POWER_START;
    for _ in 0..POWER_STEPS {
        let next = covariance.map(|row| dot(row, axis));
        let length = length(next);
        if length <= 0.0 {
            break;
        }
        axis = scale(next, 1.0 / length);
    }
    axis
}
