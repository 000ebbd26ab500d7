//! Hierarchical approximate convex decomposition (HACD, Mamou and Ghorbel 2009) as section 4.2 of
//! the paper describes it: the method that the paper compares itself with.
//!
//! It replaces section 3.4 as a whole, so there is no sweep over planar thresholds.
//! Simplification [3.2], resolution selection [3.5] and group merging [3.6] stay the same: each
//! resolution has one candidate, and of those the one with the least average cost, equation (3),
//! is the result.
//!
//! Where the paper is silent:
//! - **β** isn't given; the benchmark sweeps it.
//! - **α** = β / (10 D_S) is one over a length, added to a share of a length. Here it is
//!   β ℓ / (10 D_S) with ℓ the average diagonal of the simplified mesh's triangles: α starts at
//!   about β / 10, as in the first publication of HACD, and falls while surfaces grow, as the paper
//!   says. The mesh's diagonal can't be meant: with it hardly any two triangles of a fine mesh could
//!   be joined, since a pair that is a twentieth of the mesh wide has α E_shape > 2 β, whatever β.
//! - The node with more triangles remains; of equal costs the pair with the lower numbers goes
//!   first.
//! - At an edge with more than two triangles, pairs in opposite directions are neighbours in their order.

mod collapse;
mod surface;

use std::time::Instant;

use hullwright::surface::{SimplifiedMeshes, SurfaceParameters, average_cost};
use hullwright::{Control, Error, GroupedMesh, Hull, MeshView, Stage, TriangleMesh};

use collapse::{Threshold, collapse};

use crate::shapes::Vector;

/// Parameters of [`decompose`].
#[derive(Debug, Clone, PartialEq)]
pub struct HacdParameters {
    /// β: a collapse must cost less than this; a depth as a share of a surface's own diagonal.
    /// Positive. The paper gives no value.
    pub concavity_threshold: f64,
    /// Q, R, μ, the guard of group merging and the limit on vertices, which are the same as in the paper's own
    /// method. p, a, ε and their unit are not used.
    pub surface: SurfaceParameters,
}

/// ε of the paper's own method, for want of another value.
const DEFAULT_CONCAVITY_THRESHOLD: f64 = 0.05;

impl Default for HacdParameters {
    fn default() -> Self {
        Self {
            concavity_threshold: DEFAULT_CONCAVITY_THRESHOLD,
            surface: SurfaceParameters::paper(),
        }
    }
}

/// Convex hulls, and the row that they would have in the paper's Table 1.
#[derive(Debug, Clone, PartialEq)]
pub struct HacdDecomposition {
    /// The convex pieces.
    pub hulls: Vec<Hull>,
    /// The simplified mesh and its groups.
    pub grouped: GroupedMesh,
    /// k: average number of pieces over the candidates of all resolutions.
    pub average_pieces: f64,
    /// Average concavity cost of the chosen candidate, equation (3).
    pub cost: f64,
    /// r of the chosen candidate.
    pub resolution: usize,
    /// Triangles before simplification.
    pub initial_polygons: usize,
    /// Wall-clock time by stage; the only part of a result that differs between runs.
    pub times: Vec<(Stage, f64)>,
}

/// The grouping of one resolution.
#[derive(Debug, Clone, PartialEq)]
struct Candidate {
    /// Of the mesh among all.
    place: usize,
    resolution: usize,
    /// The group of each triangle.
    groups: Vec<u32>,
    pieces: usize,
    /// Average of equation (3).
    cost: f64,
}

/// As in the paper's own method [3.5]: from this maximum resolution on fewer than μ pieces end the search, and
/// candidates with more than this many times k pieces are left out.
const LEAST_CUT_OFF_RESOLUTION: usize = 500;
const MOST_PIECES_FACTOR: f64 = 1.5;

/// Decomposes a triangle mesh.
///
/// # Errors
/// As [`hullwright::decompose`]; [`Error::DeadlineExceeded`] as soon as the deadline has passed.
pub fn decompose<'a>(
    mesh: impl Into<MeshView<'a>>,
    parameters: &HacdParameters,
    control: &Control,
) -> Result<HacdDecomposition, Error> {
    let HacdParameters { concavity_threshold, surface } = parameters;
    if !(concavity_threshold.is_finite() && *concavity_threshold > 0.0) {
        let reason = format!("must be positive, not {concavity_threshold}");
        return Err(Error::InvalidParameter { name: "concavity_threshold", reason });
    }
    let mut times = Vec::new();
    let mut start = Instant::now();
    let mut lap = |stage| {
        times.push((stage, start.elapsed().as_secs_f64()));
        start = Instant::now();
    };
    let simplified = SimplifiedMeshes::new(mesh, surface, control)?;
    lap(Stage::Simplify);
    let candidates = candidates(&simplified, parameters, control)?;
    let pieces: usize = candidates.iter().map(|candidate| candidate.pieces).sum();
    let average_pieces = pieces as f64 / candidates.len().max(1) as f64;
    let most = MOST_PIECES_FACTOR * average_pieces;
    let few_enough = candidates.into_iter().filter(|candidate| candidate.pieces as f64 <= most);
    let candidate = few_enough.min_by(|a, b| a.cost.total_cmp(&b.cost));
    let candidate = candidate.ok_or(Error::DeadlineExceeded)?;
    lap(Stage::Search);
    let (hulls, grouped) =
        simplified.hulls(candidate.place, &candidate.groups, surface, control)?;
    lap(Stage::Hulls);
    Ok(HacdDecomposition {
        hulls,
        grouped,
        average_pieces,
        cost: candidate.cost,
        resolution: candidate.resolution,
        initial_polygons: simplified.initial_polygons(),
        times,
    })
}

/// The candidate of each resolution, as far as μ lets them be reached; none for a mesh that is
/// the same as that of the resolution before.
fn candidates(
    simplified: &SimplifiedMeshes,
    parameters: &HacdParameters,
    control: &Control,
) -> Result<Vec<Candidate>, Error> {
    let candidate_of = |(place, (resolution, mesh)): (usize, (usize, &TriangleMesh))| {
        let length = mean_triangle_diagonal(mesh);
        let threshold = Threshold { concavity: parameters.concavity_threshold, length };
        let (groups, pieces) = collapse(mesh, &neighbours(mesh), threshold, control)?;
        let cost = average_cost(&grouped(mesh, &groups))?;
        Ok(Candidate { place, resolution, groups, pieces, cost })
    };
    let mut meshes: Vec<_> = simplified.iter().enumerate().collect();
    meshes.dedup_by(|finer, coarser| finer.1.1 == coarser.1.1);
    // One after the other, since μ may cut off all higher resolutions.
    let mut found: Vec<Candidate> = Vec::with_capacity(meshes.len());
    for mesh in meshes {
        let candidate = candidate_of(mesh)?;
        let may_cut_off = candidate.resolution >= LEAST_CUT_OFF_RESOLUTION;
        let cuts_off = may_cut_off && candidate.pieces < parameters.surface.resolution_cut_off;
        found.push(candidate);
        if cuts_off {
            break;
        }
    }
    Ok(found)
}

fn grouped(mesh: &TriangleMesh, groups: &[u32]) -> GroupedMesh {
    let mut grouped = GroupedMesh::default();
    grouped.positions.clone_from(&mesh.positions);
    grouped.triangles.clone_from(&mesh.triangles);
    grouped.groups = groups.to_vec();
    grouped
}

/// For each triangle those across its edges, from each corner to the next.
type Neighbours = Vec<[Option<u32>; 3]>;

fn neighbours(mesh: &TriangleMesh) -> Neighbours {
    let mut open: std::collections::HashMap<(u32, u32), Vec<(u32, usize)>> = Default::default();
    let mut neighbours = vec![[None; 3]; mesh.triangles.len()];
    for (triangle, corners) in (0_u32..).zip(&mesh.triangles) {
        for side in 0..3 {
            let (from, to) = (corners[side], corners[(side + 1) % 3]);
            let waiting = open.get_mut(&(to, from)).and_then(Vec::pop);
            if let Some((other, other_side)) = waiting {
                neighbours[triangle as usize][side] = Some(other);
                neighbours[other as usize][other_side] = Some(triangle);
            } else {
                open.entry((from, to)).or_default().push((triangle, side));
            }
        }
    }
    neighbours
}

fn corners(mesh: &TriangleMesh, triangle: u32) -> [Vector; 3] {
    mesh.triangles[triangle as usize].map(|vertex| mesh.positions[vertex as usize].into())
}

/// Average diagonal of the triangles' bounding boxes.
fn mean_triangle_diagonal(mesh: &TriangleMesh) -> f64 {
    let count = mesh.triangles.len() as u32;
    let diagonal = |triangle| {
        let [a, b, c] = corners(mesh, triangle);
        a.max(b).max(c).distance(a.min(b).min(c))
    };
    (0..count).map(diagonal).sum::<f64>() / f64::from(count.max(1))
}

#[cfg(test)]
mod tests;
