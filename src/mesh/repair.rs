//! Repair: any triangle soup becomes the clean mesh that the other stages work on.
//!
//! Triangles with a coordinate that is not finite go, the rest is moved to the origin and scaled,
//! vertices are sorted by place and welded, degenerate and duplicate triangles go without tearing what is around
//! them, winding is made consistent and outward, and connected components are found. Holes,
//! non-manifold edges and intersections stay: they are normal input.

use super::canonical_order::{MeshOrder, rotated, triangle_key, used_vertices, vertices_by_place};
use super::connectivity::{Connectivity, SortedHalfEdges};
use super::degenerate::{drop_degenerate, drop_duplicates};
use super::orientation::orient;
use super::prepared::{Normalization, PreparedMesh, Repairs, compact};
use super::weld::weld;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, as_vectors};
use crate::geometry::{MeshView, TriangleMesh};

/// Coordinates beyond this count as not finite: sums and diagonals have to stay finite.
const LARGEST_COORDINATE: f64 = 1e300;

/// Half-edges (three per triangle) are numbered in 32 bits.
const MOST_TRIANGLES: usize = u32::MAX as usize / 3;

/// One number is kept for "none".
const MOST_VERTICES: usize = u32::MAX as usize - 1;

/// Repairs and normalises a mesh. See the module's head for what is done; the counts of it are in
/// the result. Almost linear time.
///
/// # Errors
/// [`Error::EmptyMesh`], [`Error::TooLarge`], [`Error::IndexOutOfRange`],
/// [`Error::NothingUsable`], [`Error::Cancelled`].
pub fn prepare(
    source: MeshView<'_>,
    order: MeshOrder,
    control: &Control,
) -> Result<PreparedMesh, Error> {
    let (vertices, triangles) = (source.vertex_count(), source.triangles());
    validate(source)?;
    control.check()?;
    let mut repairs = Repairs::default();

    let survey = Survey::new(source);
    repairs.non_finite_triangles = survey.non_finite_triangles;
    if survey.candidates.is_empty() || survey.normalization.diagonal == 0.0 {
        return Err(nothing_usable(triangles.len(), repairs.non_finite_triangles));
    }
    let normalized: Vec<Vector> =
        source.points().map(|point| survey.normalization.normalize(point)).collect();
    control.check()?;

    let welded = Welded::new(&normalized, &survey.used, order, control)?;
    drop(normalized);
    repairs.welded_vertices = welded.count();
    control.check()?;

    let candidates = survey.candidates.len();
    let corners = |t: u32| welded.corners(triangles[t as usize]);
    let mut in_order = survey.candidates;
    if order == MeshOrder::Place {
        in_order.sort_by_cached_key(|&t| triangle_key(corners(t)));
        control.check()?;
    }
    let (mut kept, mut source_triangles, degenerate) =
        drop_degenerate(&welded.positions, in_order, corners, order);
    repairs.degenerate_triangles =
        triangles.len() - repairs.non_finite_triangles - candidates + degenerate;
    if kept.is_empty() {
        return Err(nothing_usable(triangles.len(), repairs.non_finite_triangles));
    }
    let (duplicates, is_both_ways) =
        drop_duplicates(&mut kept, &mut source_triangles, welded.vertices.len());
    repairs.duplicate_triangles = duplicates;
    control.check()?;

    let mut source_vertices = compact(&mut kept, welded.vertices.len());
    source_vertices.iter_mut().for_each(|vertex| *vertex = welded.vertices[*vertex as usize]);
    repairs.unused_vertices = vertices - source_vertices.len() - repairs.welded_vertices;
    drop(welded);
    let normalization = Normalization::of(source_vertices.iter().map(|&v| source.at(v)));
    let positions = source_vertices
        .iter()
        .map(|&vertex| normalization.normalize(source.at(vertex)))
        .map(Into::into)
        .collect();
    let mut mesh = TriangleMesh::new(positions, kept);

    let half_edges = SortedHalfEdges::new(&mesh.triangles, mesh.positions.len());
    control.check()?;
    let connectivity = Connectivity::of(&mesh.triangles, &half_edges);
    repairs.open_edges = connectivity.open_edges;
    repairs.non_manifold_edges = connectivity.non_manifold_edges;
    control.check()?;
    let turned = orient(as_vectors(&mesh.positions), &mut mesh.triangles, &connectivity);
    if order == MeshOrder::Place {
        mesh.triangles.iter_mut().for_each(|triangle| *triangle = rotated(*triangle));
    }
    repairs.flipped_triangles = turned.iter().filter(|&&turned| turned).count();
    control.check()?;

    Ok(PreparedMesh {
        mesh,
        normalization,
        source_triangles,
        source_vertices,
        is_both_ways,
        components: connectivity.components,
        closed: connectivity.closed,
        repairs,
        hidden_caps: Vec::new(),
    })
}

/// The vertices in use, in an order, and which of them are one.
struct Welded {
    /// Their numbers in the input.
    vertices: Vec<u32>,
    positions: Vec<Vector>,
    /// For each the one that stands for it.
    representatives: Vec<u32>,
    /// For each vertex of the input its place in the order.
    places: Vec<u32>,
}

impl Welded {
    fn new(
        normalized: &[Vector],
        used: &[bool],
        order: MeshOrder,
        control: &Control,
    ) -> Result<Self, Error> {
        let vertices = match order {
            MeshOrder::Input => used_vertices(used),
            MeshOrder::Place => vertices_by_place(normalized, used),
        };
        control.check()?;
        let positions: Vec<Vector> =
            vertices.iter().map(|&vertex| normalized[vertex as usize]).collect();
        let mut places = vec![0_u32; normalized.len()];
        for (place, &vertex) in (0_u32..).zip(&vertices) {
            places[vertex as usize] = place;
        }
        let representatives = weld(&positions, control)?;
        Ok(Self { vertices, positions, representatives, places })
    }

    fn corners(&self, triangle: [u32; 3]) -> [u32; 3] {
        triangle.map(|vertex| self.representatives[self.places[vertex as usize] as usize])
    }

    /// How many were welded to another.
    fn count(&self) -> usize {
        let pairs = (0..).zip(&self.representatives);
        pairs.filter(|&(vertex, &representative)| vertex != representative).count()
    }
}

fn nothing_usable(triangles: usize, non_finite: usize) -> Error {
    Error::NothingUsable { triangles, degenerate: triangles - non_finite, non_finite }
}

fn validate(source: MeshView<'_>) -> Result<(), Error> {
    let (vertices, triangles) = (source.vertex_count(), source.triangles());
    if vertices == 0 || triangles.is_empty() {
        return Err(Error::EmptyMesh { vertices, triangles: triangles.len() });
    }
    for (what, count, limit) in
        [("vertices", vertices, MOST_VERTICES), ("triangles", triangles.len(), MOST_TRIANGLES)]
    {
        if count > limit {
            return Err(Error::TooLarge { what, count, limit });
        }
    }
    let sidedness = source.sidedness_count();
    if sidedness != 0 && sidedness != triangles.len() {
        return Err(Error::SidednessCount { sidedness, triangles: triangles.len() });
    }
    for (t, triangle) in triangles.iter().enumerate() {
        if let Some(&index) = triangle.iter().find(|&&index| index as usize >= vertices) {
            return Err(Error::IndexOutOfRange { triangle: t, index, vertices });
        }
    }
    Ok(())
}

/// Which triangles are worth a closer look, and where they are.
pub(crate) struct Survey {
    /// Triangles of three finite corners at three places, ascending.
    pub candidates: Vec<u32>,
    /// For each vertex whether a candidate uses it.
    used: Vec<bool>,
    non_finite_triangles: usize,
    pub normalization: Normalization,
}

impl Survey {
    /// All indices must exist.
    pub(crate) fn new(source: MeshView<'_>) -> Self {
        let triangles = source.triangles();
        let mut candidates = Vec::with_capacity(triangles.len());
        let mut used = vec![false; source.vertex_count()];
        let mut non_finite_triangles = 0;
        for (t, triangle) in (0_u32..).zip(triangles) {
            let [a, b, c] = triangle.map(|vertex| source.at(vertex));
            let is_finite = |x: f64| x.abs() <= LARGEST_COORDINATE;
            if ![a, b, c].iter().all(|point| point.to_array().into_iter().all(is_finite)) {
                non_finite_triangles += 1;
            } else if a != b && b != c && c != a {
                candidates.push(t);
                for &vertex in triangle {
                    used[vertex as usize] = true;
                }
            }
        }
        let used_positions =
            (0_u32..).zip(&used).filter(|(_, used)| **used).map(|(vertex, _)| source.at(vertex));
        Self {
            normalization: Normalization::of(used_positions),
            candidates,
            used,
            non_finite_triangles,
        }
    }
}

#[cfg(test)]
mod tests;
