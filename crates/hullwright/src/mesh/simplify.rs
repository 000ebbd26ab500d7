//! Mesh simplification [3.2]: fewer triangles, nearly the same surface.
//!
//! The work is done by meshoptimizer, in its port to Rust: edges are collapsed, those that change
//! the surface least first, each onto one of its two vertices, so that a vertex of the result is
//! exactly one of the source. It stops at the target alone, whatever the error.
//!
//! **When the target can't be reached.** The library never tears a surface and never joins two,
//! so locked non-manifold vertices can keep it above the target; that is rare. More often it gets
//! there by collapsing whole components to nothing, smallest first. A part must not vanish, so
//! each lost component is brought back, simplified on its own to a dozen triangles: the result
//! then has more triangles than the target. Too many triangles cost time, a lost part costs
//! the shape.
//!
//! Thin parts of a closed mesh may end as two triangles back to back, with the same vertices.
//! They stay: they are all that is left of the part.
//!
//! **Steps.** The paper simplifies by Q again and again, until there are at most r triangles, so
//! the steps for a finer r are the first steps for a coarser one.

use std::borrow::Cow;

use meshoptimizer_rs::{Limits, Positions, SimplifyOptions, SimplifySettings, Workspace};

use super::repair::{compact, is_degenerate};
use super::weld::WELD_TOLERANCE;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::TriangleMesh;
use crate::geometry::vector::{Vector, area_normal};
use crate::parallel::leave_if_stopped;

/// Far above any error that a mesh of diagonal 1 can have: only the target stops simplification.
const ANY_ERROR: f32 = 10.0;

/// Memory that the simplifier may take for each triangle, in bytes: three times the most that 471
/// meshes took, 342. (Closed meshes take 105.)
const BYTES_PER_TRIANGLE: usize = 1 << 10;

/// Visits of records that the simplifier may count for each triangle. The 471 meshes took at most
/// 304.
const WORK_PER_TRIANGLE: u64 = 1 << 13;

/// What meshes of a few triangles may take, in bytes and visits.
const LEAST_LIMIT: u32 = 1 << 20;

/// The library can't be stopped. Up to so many triangles it takes some milliseconds and runs on the
/// calling thread.
const WAITED_FOR: usize = 1 << 13;

/// The simplifier gets coordinates rounded to a multiple of the diagonal over this. Of a mesh in
/// double precision that was moved by a thousand of its sizes fewer digits are left than single
/// precision keeps of the one that was not, and edges that cost the same would collapse in another
/// order. (A coordinate between two multiples can still fall either way, but hardly one does.)
const GRID: f64 = (1_u32 << 22) as f64;
// Vertices that welding leaves apart must not meet: the simplifier would take them for a seam. A
// cell's diagonal is less than twice its side.
const _: () = assert!(2.0 / GRID < WELD_TOLERANCE);

/// The number of triangles that the next step aims for: `triangles` times Q, rounded as in the
/// paper's Table 1, and at least one less. With Q = 1 there is no simplification.
pub(crate) fn next_target(triangles: usize, quality: f64) -> usize {
    if quality >= 1.0 {
        return triangles;
    }
    ((triangles as f64 * quality).round() as usize).min(triangles.saturating_sub(1))
}

/// A simplified mesh, and where it comes from.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SimplifiedMesh {
    /// Each vertex is exactly one of the mesh that was simplified.
    pub mesh: TriangleMesh,
    /// For each vertex its index in the mesh that was simplified.
    pub source_vertices: Vec<u32>,
    /// For each triangle its component.
    pub components: Vec<u32>,
    /// How far the surface moved, as the simplifier estimates it.
    pub error: f64,
}

/// A component that simplification lost comes back with this many triangles: a box needs them.
const LOST_COMPONENT_TRIANGLES: usize = 12;

/// A component counts as lost if it has fewer triangles than [`LOST_COMPONENT_TRIANGLES`] with
/// less than this share of its area. An octahedron has 0.55 of the area of the sphere around it,
/// a flat triangle, seen from both sides, 0.21.
const LEAST_AREA_KEPT: f64 = 0.25;

/// Fewer triangles: `target`, or more, see the module's head. Never none.
///
/// `components` holds the component of each triangle. Time O(n log n) in the number of triangles.
pub(crate) fn simplify(
    mesh: &TriangleMesh,
    components: &[u32],
    target: usize,
    control: &Control,
) -> Result<SimplifiedMesh, Error> {
    if target >= mesh.triangles.len() {
        return Ok(SimplifiedMesh {
            mesh: mesh.clone(),
            source_vertices: (0..mesh.positions.len() as u32).collect(),
            components: components.to_vec(),
            error: 0.0,
        });
    }
    let limits = limits(mesh.triangles.len());
    let separated = Separated::new(mesh, components);
    let (mut triangles, error) = collapse_edges_of_all(&separated, target, limits, control)?;
    triangles.retain(|&triangle| !is_degenerate(&separated.positions, triangle));
    control.check()?;
    bring_back_lost(&separated, components, &mut triangles, &mut Workspace::new(limits))?;
    let components = triangles.iter().map(|&t| separated.component(t)).collect();
    for vertex in triangles.as_flattened_mut() {
        *vertex = separated.source_vertex(*vertex);
    }
    let source_vertices = compact(&mut triangles, mesh.positions.len());
    let positions = source_vertices.iter().map(|&vertex| mesh.positions[vertex as usize]).collect();
    let mesh = TriangleMesh::new(positions, triangles);
    Ok(SimplifiedMesh { mesh, source_vertices, components, error })
}

fn limits(triangles: usize) -> Limits {
    let work = (triangles as u64).saturating_mul(WORK_PER_TRIANGLE);
    Limits {
        max_bytes: triangles.saturating_mul(BYTES_PER_TRIANGLE).max(LEAST_LIMIT as usize),
        max_work: work.max(LEAST_LIMIT.into()),
    }
}

/// [`collapse_edges`] of a whole mesh, which may take long.
fn collapse_edges_of_all(
    mesh: &Separated<'_>,
    target: usize,
    limits: Limits,
    control: &Control,
) -> Result<(Vec<[u32; 3]>, f64), Error> {
    let positions = rounded(&mesh.positions);
    if mesh.triangles.len() <= WAITED_FOR {
        return collapse_edges(&positions, &mesh.triangles, target, &mut Workspace::new(limits));
    }
    let triangles = mesh.triangles.to_vec();
    let collapse =
        move || collapse_edges(&positions, &triangles, target, &mut Workspace::new(limits));
    let failed = || Err(Error::Simplification { reason: "the simplifier failed".into() });
    leave_if_stopped(collapse, control)?.unwrap_or_else(failed)
}

/// Positions as the library gets them.
fn rounded(positions: &[Vector]) -> Vec<[f32; 3]> {
    let rounded = |x: f64| ((x * GRID).round() / GRID) as f32;
    positions.iter().map(|position| position.to_array().map(rounded)).collect()
}

/// The one call to the library: triangles of the same vertices, `target` of them if possible,
/// and the error that the library estimates.
fn collapse_edges(
    positions: &[[f32; 3]],
    triangles: &[[u32; 3]],
    target: usize,
    workspace: &mut Workspace,
) -> Result<(Vec<[u32; 3]>, f64), Error> {
    let settings = SimplifySettings {
        target_index_count: 3 * target,
        target_error: ANY_ERROR,
        options: SimplifyOptions::ERROR_ABSOLUTE,
    };
    let positions = Positions::from_packed(positions);
    let simplified =
        meshoptimizer_rs::simplify(triangles.as_flattened(), positions, settings, workspace)
            .map_err(|error| Error::Simplification { reason: error.to_string() })?;
    let (triangles, _) = simplified.indices.as_chunks();
    Ok((triangles.to_vec(), f64::from(simplified.error)))
}

/// A mesh whose components share no vertex: where they touch, all but one have a copy.
///
/// The library finds copies by their place and does not move them. It would move a shared vertex,
/// and with it the triangles of one component into the other.
struct Separated<'a> {
    positions: Cow<'a, [Vector]>,
    triangles: Cow<'a, [[u32; 3]]>,
    /// For each vertex its component; empty if there is only one.
    owners: Vec<u32>,
    /// For each copy the vertex that it is a copy of. Copies come after all vertices.
    copied: Vec<u32>,
    vertices: usize,
}

impl<'a> Separated<'a> {
    fn new(mesh: &'a TriangleMesh, components: &[u32]) -> Self {
        let vertices = mesh.positions.len();
        let mut separated = Self {
            positions: Cow::Borrowed(mesh.points()),
            triangles: Cow::Borrowed(&mesh.triangles),
            owners: Vec::new(),
            copied: Vec::new(),
            vertices,
        };
        if components.iter().all(|&component| component == 0) {
            return separated;
        }
        const NOBODY: u32 = u32::MAX;
        separated.owners = vec![NOBODY; vertices];
        let mut copies: Vec<(u32, u32)> = Vec::new();
        for (triangle, &component) in mesh.triangles.iter().zip(components) {
            for &vertex in triangle {
                let owner = &mut separated.owners[vertex as usize];
                if *owner == NOBODY {
                    *owner = component;
                } else if *owner != component {
                    copies.push((vertex, component));
                }
            }
        }
        if copies.is_empty() {
            return separated;
        }
        copies.sort_unstable();
        copies.dedup();
        let positions = separated.positions.to_mut();
        for &(vertex, component) in &copies {
            positions.push(mesh.points()[vertex as usize]);
            separated.owners.push(component);
            separated.copied.push(vertex);
        }
        let triangles = separated.triangles.to_mut();
        for (triangle, &component) in triangles.iter_mut().zip(components) {
            for vertex in triangle {
                if separated.owners[*vertex as usize] != component {
                    let copy = copies.partition_point(|entry| *entry < (*vertex, component));
                    *vertex = (vertices + copy) as u32;
                }
            }
        }
        separated
    }

    fn component(&self, triangle: [u32; 3]) -> u32 {
        self.owners.get(triangle[0] as usize).copied().unwrap_or(0)
    }

    fn source_vertex(&self, vertex: u32) -> u32 {
        match (vertex as usize).checked_sub(self.vertices) {
            Some(copy) => self.copied[copy],
            None => vertex,
        }
    }
}

/// Replaces each component that has collapsed too far by a coarse version of its own.
fn bring_back_lost(
    mesh: &Separated<'_>,
    components: &[u32],
    triangles: &mut Vec<[u32; 3]>,
    workspace: &mut Workspace,
) -> Result<(), Error> {
    let count = components.iter().max().map_or(0, |&most| most as usize + 1);
    let before = measure(mesh, &mesh.triangles, count);
    let after = measure(mesh, triangles, count);
    let lost: Vec<bool> =
        (0..count).map(|component| is_lost(before[component], after[component])).collect();
    if !lost.contains(&true) {
        return Ok(());
    }
    triangles.retain(|&triangle| !lost[mesh.component(triangle) as usize]);
    let mut parts: Vec<Vec<[u32; 3]>> = vec![Vec::new(); count];
    for (&triangle, &component) in mesh.triangles.iter().zip(components) {
        if lost[component as usize] {
            parts[component as usize].push(triangle);
        }
    }
    for (part, before) in parts.into_iter().zip(before) {
        triangles.extend(simplify_alone(&mesh.positions, part, before, workspace)?);
    }
    Ok(())
}

/// Number of triangles, and twice their area.
type Measure = (usize, f64);

fn measure(mesh: &Separated<'_>, triangles: &[[u32; 3]], count: usize) -> Vec<Measure> {
    let mut measures = vec![(0, 0.0); count];
    for &triangle in triangles {
        let (number, area) = &mut measures[mesh.component(triangle) as usize];
        *number += 1;
        *area += doubled_area(&mesh.positions, triangle);
    }
    measures
}

fn doubled_area(positions: &[Vector], triangle: [u32; 3]) -> f64 {
    let [a, b, c] = triangle.map(|vertex| positions[vertex as usize]);
    area_normal(a, b, c).length()
}

fn is_lost(before: Measure, after: Measure) -> bool {
    after.0 < LOST_COMPONENT_TRIANGLES.min(before.0) && after.1 < LEAST_AREA_KEPT * before.1
}

/// The triangles of one component, as few as keep it from being lost.
fn simplify_alone(
    positions: &[Vector],
    part: Vec<[u32; 3]>,
    before: Measure,
    workspace: &mut Workspace,
) -> Result<Vec<[u32; 3]>, Error> {
    let mut sorted: Vec<u32> = part.as_flattened().to_vec();
    sorted.sort_unstable();
    sorted.dedup();
    let own_positions: Vec<Vector> = sorted.iter().map(|&v| positions[v as usize]).collect();
    let own = |vertex: u32| sorted.partition_point(|&other| other < vertex) as u32;
    let own_part: Vec<[u32; 3]> = part.iter().map(|triangle| triangle.map(own)).collect();

    let rounded_positions = rounded(&own_positions);
    let mut target = LOST_COMPONENT_TRIANGLES;
    while target < part.len() {
        let (mut coarse, _) = collapse_edges(&rounded_positions, &own_part, target, workspace)?;
        coarse.retain(|&triangle| !is_degenerate(&own_positions, triangle));
        let area = coarse.iter().map(|&t| doubled_area(&own_positions, t)).sum();
        if !is_lost(before, (coarse.len(), area)) {
            return Ok(coarse
                .iter()
                .map(|triangle| triangle.map(|vertex| sorted[vertex as usize]))
                .collect());
        }
        target *= 2;
    }
    Ok(part)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::adjacency::{Adjacency, NO_NEIGHBOUR};
    use crate::mesh::shapes::{join, uv_sphere};

    #[test]
    fn a_step_aims_for_the_count_times_q_and_takes_away_a_triangle_at_least() {
        for (triangles, quality, target) in [
            (11_258, 0.8, 9006),
            (9006, 0.8, 7205),
            (1000, 0.999_999, 999),
            (1000, 1e-9, 0),
            (11_258, 1.0, 11_258),
        ] {
            assert_eq!(next_target(triangles, quality), target);
        }
    }

    #[test]
    fn steps_reach_the_polygon_counts_of_the_papers_table_1() {
        // r, initial and final polygons. A closed surface loses two triangles at a time.
        for (r, initial, polygons) in [
            (500, 11_258, 494),
            (500, 30_008, 430),
            (500, 13_170, 462),
            (500, 31_456, 450),
            (500, 12_646, 442),
            (1000, 3026, 990),
            (250, 11_936, 212),
            (250, 29_994, 218),
            (250, 13_842, 246),
            (500, 19_510, 436),
        ] {
            let mut count: usize = initial;
            while count > r {
                count = next_target(count, 0.8) / 2 * 2;
            }
            assert_eq!(count, polygons);
        }
    }

    /// Simplified to a target, each vertex one of the source, and each used by a triangle with
    /// area.
    fn simplified(source: &TriangleMesh, components: &[u32], target: usize) -> SimplifiedMesh {
        let simplified = simplify(source, components, target, &Control::new()).unwrap();
        let mesh = &simplified.mesh;
        assert_eq!(mesh.triangles.len(), simplified.components.len());
        assert_eq!(mesh.positions.len(), simplified.source_vertices.len());
        for (position, &vertex) in mesh.points().iter().zip(&simplified.source_vertices) {
            assert_eq!(position, &source.points()[vertex as usize]);
        }
        assert!(!mesh.triangles.iter().any(|&triangle| is_degenerate(mesh.points(), triangle)));
        let used = |vertex: u32| mesh.triangles.as_flattened().contains(&vertex);
        assert!((0..mesh.positions.len() as u32).all(used));
        simplified
    }

    /// Several meshes as the components of one.
    fn join_components(parts: &[TriangleMesh]) -> (TriangleMesh, Vec<u32>) {
        let components = (0_u32..)
            .zip(parts)
            .flat_map(|(component, part)| vec![component; part.triangles.len()])
            .collect();
        (join(parts), components)
    }

    #[test]
    fn a_sphere_reaches_its_target_and_stays_closed() {
        let source = uv_sphere(40, [0.0; 3], 0.28);
        let components = vec![0; source.triangles.len()];
        for target in [2000, 1000, 250] {
            let simplified = simplified(&source, &components, target);
            let reached = simplified.mesh.triangles.len();
            assert!(reached <= target && reached + 10 > target, "{reached}");
            let adjacency = Adjacency::new(&simplified.mesh);
            assert!(!adjacency.neighbours.contains(&NO_NEIGHBOUR));
        }
    }

    #[test]
    fn a_target_that_is_reached_already_changes_nothing() {
        let source = uv_sphere(8, [0.0; 3], 0.28);
        let components = vec![0; source.triangles.len()];
        let simplified = simplified(&source, &components, source.triangles.len());
        assert_eq!(simplified.mesh, source);
        assert_eq!(simplified.error, 0.0);
    }

    #[test]
    fn no_component_vanishes() {
        let mut parts = vec![uv_sphere(40, [0.0; 3], 0.2)];
        for i in 0..12 {
            let angle = f64::from(i) * 0.5;
            let centre = [0.27 * angle.cos(), 0.27 * angle.sin(), 0.0];
            parts.push(uv_sphere(8, centre, 0.004));
        }
        let (source, components) = join_components(&parts);
        let simplified = simplified(&source, &components, 50);
        let measure_all = |mesh: &TriangleMesh, components: &[u32]| {
            measure(&Separated::new(mesh, components), &mesh.triangles, 13)
        };
        let before = measure_all(&source, &components);
        let after = measure_all(&simplified.mesh, &simplified.components);
        for (before, after) in before.into_iter().zip(after) {
            assert!(after.0 >= 4 && !is_lost(before, after), "{after:?}");
        }
        assert!(simplified.mesh.triangles.len() < 250);
    }

    #[test]
    fn loose_triangles_all_stay() {
        let mut source = TriangleMesh::default();
        for i in 0..100_u32 {
            let x = f64::from(i) * 0.005 - 0.25;
            source.positions.extend([[x, 0.0, 0.0], [x + 0.004, 0.0, 0.0], [x, 0.004, 0.0]]);
            source.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
        }
        let components: Vec<u32> = (0..100).collect();
        let simplified = simplified(&source, &components, 10);
        let mut left = simplified.components;
        left.sort_unstable();
        assert_eq!(left, components);
    }

    #[test]
    fn components_that_touch_at_a_vertex_stay_apart() {
        let mut source = uv_sphere(20, [0.0; 3], 0.1);
        let half = source.triangles.len();
        let other = uv_sphere(20, [0.0, 0.0, 0.2], 0.1);
        // The north pole of the first is the south pole of the second.
        let offset = source.positions.len() as u32;
        let south = other.positions.len() as u32 - 1;
        source.positions.extend(&other.positions);
        let number = |v: u32| if v == south { 0 } else { v + offset };
        let moved = other.triangles.iter().map(|t| t.map(number));
        source.triangles.extend(moved);
        let components: Vec<u32> =
            (0..source.triangles.len()).map(|t| u32::from(t >= half)).collect();
        let simplified = simplified(&source, &components, 60);
        for (triangle, &component) in simplified.mesh.triangles.iter().zip(&simplified.components) {
            let height =
                triangle.iter().map(|&v| simplified.mesh.points()[v as usize][2]).sum::<f64>();
            assert_eq!(component, u32::from(height > 0.3));
        }
    }
}
