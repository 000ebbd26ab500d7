//! Which reading of the paper gives what its Table 1 says. Search and selection are written here
//! once more, so that their rules can be others than the library's; the groupings are the library's
//! own.

use std::collections::BTreeMap;

use hullwright::hull::convex_hull;
use hullwright::surface::SurfaceParameters;
use hullwright::{GroupedMesh, Length, TriangleMesh};

use super::{Model, Paper, decomposed, unity};
use crate::report::Table;
use crate::shapes::{Vector, bounds};
use crate::terminal::Failure;
use crate::tools::variations::Variation;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Simplifier {
    /// Unity Mesh Simplifier by steps of Q.
    Unity,
    /// meshoptimizer by steps of Q, as the library.
    Steps,
    /// meshoptimizer from the source to a power of Q in one go.
    Direct,
}

/// When the running average ends a threshold: above 3 ε, and three times the least average.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Limit {
    Both,
    Either,
    Threshold,
}

/// What counts as a piece.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Count {
    Large,
    All,
    Merged,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reading {
    simplifier: Simplifier,
    /// The length that counts as 1, as a share of the diagonal; `None`: the mesh's own unit.
    unit: Option<f64>,
    angular_threshold: f64,
    /// The normal of a vertex is weighted by the areas of its triangles.
    weighted: bool,
    count: Count,
    /// Groups of one or two polygons are in the divisor of the average.
    small_in_divisor: bool,
    limit: Limit,
    /// Aborted thresholds may be taken by the fail-safe.
    aborted_count: bool,
    /// A single group may be the candidate.
    single_group: bool,
    /// μ acts at r = 500 too.
    cut_off_at_500: bool,
    /// The order of triangles: 0 is the file's.
    order: u32,
}

/// Under this nine of ten rows are the paper's, figure by figure.
pub(super) const CLOSEST: Reading = Reading {
    simplifier: Simplifier::Unity,
    unit: None,
    angular_threshold: 0.01,
    weighted: false,
    count: Count::Large,
    small_in_divisor: false,
    limit: Limit::Both,
    aborted_count: false,
    single_group: true,
    cut_off_at_500: true,
    order: 0,
};

/// No dent is refused by the angular test.
const NO_ANGULAR_TEST: f64 = 1e3;

/// ε, μ, and the factor of the paper's limits on running averages.
const EPSILON: f64 = 0.05;
const CUT_OFF: usize = 5;
const ABORT_FACTOR: f64 = 3.0;

fn readings() -> Vec<(&'static str, Reading)> {
    let library = Reading { simplifier: Simplifier::Steps, unit: Some(1.0 / 2.24), ..CLOSEST };
    vec![
        ("the closest", CLOSEST),
        ("meshoptimizer by steps of Q", Reading { simplifier: Simplifier::Steps, ..CLOSEST }),
        ("meshoptimizer in one go", Reading { simplifier: Simplifier::Direct, ..CLOSEST }),
        ("unit of 1 / 2.24 diagonals", Reading { unit: Some(1.0 / 2.24), ..CLOSEST }),
        ("both: the library", library),
        ("normals weighted by area", Reading { weighted: true, ..CLOSEST }),
        ("all groups are pieces", Reading { count: Count::All, ..CLOSEST }),
        ("pieces after merging", Reading { count: Count::Merged, ..CLOSEST }),
        ("small groups in the divisor", Reading { small_in_divisor: true, ..CLOSEST }),
        ("aborted above either limit", Reading { limit: Limit::Either, ..CLOSEST }),
        ("aborted above 3 ε alone", Reading { limit: Limit::Threshold, ..CLOSEST }),
        ("aborted ones in the fail-safe", Reading { aborted_count: true, ..CLOSEST }),
        ("a single group has failed", Reading { single_group: false, ..CLOSEST }),
        ("μ above r = 500", Reading { cut_off_at_500: false, ..CLOSEST }),
        ("no angular test", Reading { angular_threshold: NO_ANGULAR_TEST, ..CLOSEST }),
        ("triangles in another order", Reading { order: 1, ..CLOSEST }),
        ("and another", Reading { order: 2, ..CLOSEST }),
    ]
}

/// A row for each reading, as the module's head says.
pub(super) fn table(papers: &[Paper], levels: &mut Levels) -> Result<Table, Failure> {
    let note = "The closest reading, and each other choice in its place alone. Of ten rows: how many have the \
                paper's polygons, pieces, cost (to its last digit), p, r, and both p and r. Then p and r of each \
                model, in bold where both are the paper's.";
    let heads = ["reading", "polygons", "pieces", "cost", "p", "r", "p and r"].map(String::from);
    let names = papers.iter().map(|paper| paper.row.model.clone());
    let mut table = Table::new("Readings of Table 1", note, &[]);
    table.header = heads.into_iter().chain(names).collect();
    let parameters = SurfaceParameters::paper();
    for (name, reading) in readings() {
        let (mut agreeing, mut cells) = ([0_usize; 6], Vec::new());
        for Paper { row, model } in papers {
            let tree = tree(model, &reading, &parameters, levels)?;
            let Some((found, _)) = select(&tree, &reading) else { continue };
            let (p, r) = (found.p == row.p, found.r == row.r);
            let is_cost = (found.cost - row.cost).abs() < 1e-6;
            let polygons = found.polygons == row.polygons;
            let is_equal = [polygons, found.pieces == row.pieces, is_cost, p, r, p && r];
            agreeing.iter_mut().zip(is_equal).for_each(|(n, is_equal)| *n += usize::from(is_equal));
            let text = format!("{} {}", found.p, found.r);
            cells.push(if p && r { format!("**{text}**") } else { text });
        }
        let agreeing = agreeing.map(|count| count.to_string());
        table.rows.push([name.to_owned()].into_iter().chain(agreeing).chain(cells).collect());
    }
    Ok(table)
}

/// A grouping under one p.
struct Leaf {
    p: f64,
    /// The costs of the groups of more than two polygons.
    costs: Vec<f64>,
    groups: usize,
    merged: usize,
}

/// A resolution.
pub(super) struct Branch {
    r: usize,
    mesh: TriangleMesh,
    leaves: Vec<Leaf>,
}

/// What a resolution gives to the selection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Candidate {
    pub r: usize,
    pub p: f64,
    pub pieces: usize,
    pub polygons: usize,
    pub cost: f64,
}

/// The simplified meshes of a model, which many readings share: coarsest last.
pub(super) type Levels = BTreeMap<(String, u8), Vec<TriangleMesh>>;

/// All groupings of a mesh.
pub(super) fn tree(
    model: &Model,
    reading: &Reading,
    parameters: &SurfaceParameters,
    known: &mut Levels,
) -> Result<Vec<Branch>, Failure> {
    let key = (model.name.clone(), reading.simplifier as u8);
    if !known.contains_key(&key) {
        known.insert(key.clone(), levels(model, reading.simplifier, parameters)?);
    }
    let mut branches = Vec::new();
    for (&r, level) in parameters.maximum_resolutions.iter().rev().zip(&known[&key]) {
        let mesh = match reading.order {
            0 => level.clone(),
            order => Variation::Shuffle(order).apply(level).0,
        };
        let mut leaves = Vec::new();
        for &p in &parameters.planar_thresholds {
            let mut one = parameters.clone();
            (one.simplification_quality, one.maximum_resolutions) = (1.0, vec![r]);
            one.planar_thresholds = vec![p];
            one.angular_threshold = reading.angular_threshold;
            one.unit = Length::units(reading.unit.map_or(1.0, |share| share * model.diagonal));
            let merged = match reading.count {
                Count::Merged => decomposed(&mesh, &one)?.decomposition.report.pieces,
                _ => 0,
            };
            one.significant_diagonal = 0.0;
            let grouped = decomposed(&mesh, &one)?.decomposition.grouped;
            let (groups, costs) = costs(&grouped, reading.weighted);
            leaves.push(Leaf { p, costs, groups, merged });
        }
        branches.push(Branch { r, mesh, leaves });
    }
    branches.reverse();
    Ok(branches)
}

/// The simplified meshes, finest first.
fn levels(
    model: &Model,
    simplifier: Simplifier,
    parameters: &SurfaceParameters,
) -> Result<Vec<TriangleMesh>, Failure> {
    let mut levels: Vec<TriangleMesh> = Vec::new();
    for &r in parameters.maximum_resolutions.iter().rev() {
        let quality = parameters.simplification_quality;
        let mut mesh = levels.last().unwrap_or(&model.mesh).clone();
        if simplifier == Simplifier::Direct {
            let mut target = model.mesh.triangles.len() as f64;
            while target.round() > r as f64 {
                target *= quality;
            }
            mesh = to_target(&model.mesh, target.round() as usize)?;
        }
        while mesh.triangles.len() > r {
            let count = mesh.triangles.len();
            mesh = match simplifier {
                Simplifier::Unity => unity::simplify(&mesh, quality),
                _ => to_target(&mesh, (count as f64 * quality).round() as usize)?,
            };
            if mesh.triangles.len() == count {
                break;
            }
        }
        levels.push(mesh);
    }
    Ok(levels)
}

/// The library's simplification, in one step.
fn to_target(mesh: &TriangleMesh, target: usize) -> Result<TriangleMesh, Failure> {
    let count = mesh.triangles.len();
    if target >= count {
        return Ok(mesh.clone());
    }
    let mut one = SurfaceParameters::paper();
    one.simplification_quality = target as f64 / count as f64;
    (one.maximum_resolutions, one.planar_thresholds) = (vec![count - 1], vec![0.0]);
    let grouped = decomposed(mesh, &one)?.decomposition.grouped;
    Ok(TriangleMesh::new(grouped.positions, grouped.triangles))
}

/// The number of groups, and the cost of each of more than two polygons.
fn costs(grouped: &GroupedMesh, weighted: bool) -> (usize, Vec<f64>) {
    let count = grouped.groups.iter().max().map_or(0, |&group| group as usize + 1);
    let mut groups = vec![Vec::new(); count];
    for (&triangle, &group) in grouped.triangles.iter().zip(&grouped.groups) {
        groups[group as usize].push(triangle);
    }
    groups.retain(|group| group.len() > 2);
    (count, groups.iter().map(|group| cost(&grouped.positions, group, weighted)).collect())
}

/// Equation (3).
fn cost(positions: &[[f64; 3]], group: &[[u32; 3]], weighted: bool) -> f64 {
    let mut normals: BTreeMap<u32, Vector> = BTreeMap::new();
    for triangle in group {
        let [a, b, c] = triangle.map(|vertex| Vector::from(positions[vertex as usize]));
        let normal = (b - a).cross(c - a);
        let normal = if weighted { normal } else { normal.normalize_or_zero() };
        triangle.iter().for_each(|&vertex| *normals.entry(vertex).or_default() += normal);
    }
    let points: Vec<[f64; 3]> = normals.keys().map(|&vertex| positions[vertex as usize]).collect();
    // A flat group is its own hull.
    let Ok(hull) = convex_hull(&points) else { return 0.0 };
    let planes = hull.planes();
    let depth = |(&point, normal): (&[f64; 3], &Vector)| {
        let (point, normal) = (Vector::from(point), normal.normalize_or_zero());
        let exits = planes.iter().filter_map(|&(plane, offset)| {
            let plane = Vector::from(plane);
            let towards = plane.dot(normal);
            (towards > 1e-9).then(|| ((offset - plane.dot(point)) / towards).max(0.0))
        });
        exits.reduce(f64::min).unwrap_or(0.0)
    };
    let deepest = points.iter().zip(normals.values()).map(depth).fold(0.0, f64::max);
    let (low, high) = bounds(&points);
    deepest / low.distance(high)
}

/// Section 3.5: the chosen candidate, and k.
pub(super) fn select(tree: &[Branch], reading: &Reading) -> Option<(Candidate, f64)> {
    let mut candidates: Vec<Candidate> = Vec::new();
    let mut before: Option<&TriangleMesh> = None;
    for branch in tree {
        if before.replace(&branch.mesh).is_some_and(|before| *before == branch.mesh) {
            continue;
        }
        let candidate = candidate(branch, reading)?;
        candidates.push(candidate);
        let may_cut_off = branch.r > 500 || (branch.r == 500 && reading.cut_off_at_500);
        if may_cut_off && candidate.pieces < CUT_OFF {
            break;
        }
    }
    let sum: usize = candidates.iter().map(|candidate| candidate.pieces).sum();
    let average = sum as f64 / candidates.len().max(1) as f64;
    candidates.retain(|candidate| candidate.pieces as f64 <= 1.5 * average);
    let better = |best: Candidate, next: Candidate| {
        if next.cost < best.cost - 1e-9 { next } else { best }
    };
    Some((candidates.into_iter().reduce(better)?, average))
}

/// Section 3.4.2: fewest pieces under ε, or else the least cost.
fn candidate(branch: &Branch, reading: &Reading) -> Option<Candidate> {
    let (mut best, mut cheapest): (Option<Candidate>, Option<Candidate>) = (None, None);
    let mut least = f64::INFINITY;
    for leaf in &branch.leaves {
        let (mut sum, mut cost, mut is_aborted) = (0.0, 0.0, false);
        for (index, of_group) in leaf.costs.iter().enumerate() {
            sum += of_group;
            cost = sum / (index + 1) as f64;
            let over = [EPSILON, least].map(|limit| cost > ABORT_FACTOR * limit);
            is_aborted = least.is_finite()
                && match reading.limit {
                    Limit::Both => over[0] && over[1],
                    Limit::Either => over[0] || over[1],
                    Limit::Threshold => over[0],
                };
            if is_aborted {
                break;
            }
        }
        if reading.small_in_divisor {
            cost = sum / leaf.groups.max(1) as f64;
        }
        let pieces = match reading.count {
            Count::Large => leaf.costs.len(),
            Count::All => leaf.groups,
            Count::Merged => leaf.merged,
        };
        let polygons = branch.mesh.triangles.len();
        let found = Candidate { r: branch.r, p: leaf.p, pieces, polygons, cost };
        let has_failed = leaf.groups == 1 && !reading.single_group;
        if !has_failed && (!is_aborted || reading.aborted_count) {
            cheapest = cheapest.filter(|cheapest| cheapest.cost <= cost).or(Some(found));
        }
        if !is_aborted {
            least = least.min(cost);
            if cost < 1e-6 && !has_failed {
                return Some(found);
            }
            if cost < EPSILON && !has_failed {
                best = best.filter(|best| best.pieces <= pieces).or(Some(found));
            }
        }
        if leaf.groups == 1 {
            break;
        }
    }
    best.or(cheapest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::torus;

    #[test]
    fn under_the_librarys_reading_the_choice_is_the_librarys() {
        let model = Model::new("torus", torus(24, 12));
        // Without simplification, each step of which is up to rounding.
        let mut parameters = SurfaceParameters::paper();
        parameters.maximum_resolutions = vec![600, 1000];
        let reading = Reading { simplifier: Simplifier::Steps, unit: Some(1.0 / 2.24), ..CLOSEST };
        let tree = tree(&model, &reading, &parameters, &mut Levels::new()).ok().unwrap();
        let (found, average) = select(&tree, &reading).unwrap();
        let report = decomposed(&model.mesh, &parameters).ok().unwrap().decomposition.report;
        assert_eq!((found.r, Some(found.p)), (report.resolution, report.planar_threshold));
        assert_eq!((found.polygons, average), (report.polygons, report.average_pieces));
        assert!((found.cost - report.cost).abs() < 1e-9);
    }
}
