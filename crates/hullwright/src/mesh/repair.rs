//! Repair: any triangle soup becomes the clean mesh that the other stages work on.
//!
//! Triangles with a coordinate that is not finite go, the rest is moved to the origin and scaled,
//! vertices are sorted by place and welded, degenerate and duplicate triangles go without tearing
//! what is around them, winding is made consistent and outward, and connected components are found.
//! Holes, non-manifold edges and intersections stay: they are normal input.

use std::borrow::Cow;
use std::cmp::Ordering;

use super::adjacency::{Connectivity, SortedHalfEdges};
use super::canonical_order::{
    MeshOrder, rotated, triangle_key, triangles_by_place, used_vertices, vertices_by_place,
};
use super::orientation::{find_sheets, orient};
use super::weld::weld;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, area_normal, as_vectors, bounds};
use crate::geometry::{MeshView, TriangleMesh};
use crate::sorting::sort_by_key;

/// Stands in [`PreparedMesh::source_triangles`] for a triangle that closes an opening.
pub(crate) const CAP: u32 = u32::MAX;

/// The same for one within the solid.
pub(crate) const HIDDEN_CAP: u32 = u32::MAX - 1;

/// The map between the input's units and the space that the pipeline works in, where the bounding
/// box is centred at the origin and its diagonal is 1.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Normalization {
    /// Centre of the bounding box, in the input's units.
    pub centre: Vector,
    /// Diagonal of the bounding box, in the input's units.
    pub diagonal: f64,
}

impl Normalization {
    /// That of a mesh that is scaled already.
    #[cfg(test)]
    pub(crate) const UNIT: Self = Self { centre: Vector::ZERO, diagonal: 1.0 };

    /// Without overflow for coordinates up to half the largest number. The diagonal is 0 where its
    /// inverse would not be finite, as for a single point.
    pub(crate) fn of(points: impl Iterator<Item = Vector>) -> Self {
        let (low, high) = bounds(points);
        let extent = high - low;
        let longest = extent[0].max(extent[1]).max(extent[2]);
        if longest < f64::MIN_POSITIVE {
            return Self { centre: Vector::ZERO, diagonal: 0.0 };
        }
        Self {
            centre: low * 0.5 + high * 0.5,
            diagonal: longest * (extent * (1.0 / longest)).length(),
        }
    }

    pub(crate) fn normalize(&self, point: Vector) -> Vector {
        (point - self.centre) * (1.0 / self.diagonal)
    }

    /// A point of the pipeline's space in the input's units.
    pub fn restore(&self, point: Vector) -> Vector {
        point * self.diagonal + self.centre
    }
}

/// What was repaired in the input, as counts.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Repairs {
    /// Vertices that were welded to another.
    pub welded_vertices: usize,
    /// Vertices that no triangle uses.
    pub unused_vertices: usize,
    /// Triangles dropped because they use a coordinate that is not finite.
    pub non_finite_triangles: usize,
    /// Triangles dropped because they have no area.
    pub degenerate_triangles: usize,
    /// Triangles dropped because another has the same vertices.
    pub duplicate_triangles: usize,
    /// Triangles that were turned around, of those that are there one way round.
    pub flipped_triangles: usize,
    /// Edges with more than two triangles, which stay.
    pub non_manifold_edges: usize,
    /// Edges with one triangle, which stay open.
    pub open_edges: usize,
}

/// A repaired mesh, as all stages after repair take it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PreparedMesh {
    /// Welded, oriented, normalised, and in an order of its own.
    pub mesh: TriangleMesh,
    /// From this space to the input's.
    pub normalization: Normalization,
    /// For each triangle its index in the input; the same for both halves where a triangle was
    /// split. Those that close openings have none: `u32::MAX`.
    pub source_triangles: Vec<u32>,
    /// For each vertex its index in the input; of welded ones the first.
    pub source_vertices: Vec<u32>,
    /// For each triangle whether the input has it as often one way round as the other.
    pub is_both_ways: Vec<bool>,
    /// For each triangle whether it is, and bounds no solid.
    pub is_sheet: Vec<bool>,
    /// For each triangle its connected component (over shared edges).
    pub components: Vec<u32>,
    /// For each component whether each of its edges has exactly two triangles, which run along
    /// it in opposite directions.
    pub closed: Vec<bool>,
    /// What was changed in the input.
    pub repairs: Repairs,
    /// Triangles that close openings within the solid: they bound the inside, but are no surface.
    pub hidden_caps: Vec<[u32; 3]>,
}

impl PreparedMesh {
    /// The triangles by whose winding number a point is inside: sheets are there both ways round,
    /// so that their winding numbers cancel. Sheets are triangles that the input has both ways and
    /// that bound no solid, and the open parts of a mesh that is inside out as a whole: which of
    /// their sides is the inside is not clear.
    pub(crate) fn triangles_of_solid(&self) -> Cow<'_, [[u32; 3]]> {
        with_sheets_both_ways(&self.mesh.triangles, &self.sheets(), &self.hidden_caps)
    }

    /// For each triangle whether it is a sheet.
    pub(crate) fn sheets(&self) -> Vec<bool> {
        let is_inside_out = self.mesh.encloses_nothing();
        let is_closed = |&component: &u32| self.closed[component as usize];
        let all = self.is_sheet.iter().zip(&self.components);
        all.map(|(&sheet, component)| sheet || is_inside_out && !is_closed(component)).collect()
    }

    /// Keeps the triangles for which `keeps` holds, by their index in the input and their
    /// component. Vertices and the labels of components stay.
    pub(crate) fn retain(&mut self, keeps: impl Fn(u32, u32) -> bool) {
        let kept: Vec<usize> = (0..self.mesh.triangles.len())
            .filter(|&t| keeps(self.source_triangles[t], self.components[t]))
            .collect();
        self.mesh.triangles = kept.iter().map(|&t| self.mesh.triangles[t]).collect();
        self.source_triangles = kept.iter().map(|&t| self.source_triangles[t]).collect();
        self.is_both_ways = kept.iter().map(|&t| self.is_both_ways[t]).collect();
        self.is_sheet = kept.iter().map(|&t| self.is_sheet[t]).collect();
        self.components = kept.iter().map(|&t| self.components[t]).collect();
    }
}

/// Triangles, sheets both ways round so that their winding numbers cancel, and hidden caps.
pub(super) fn with_sheets_both_ways<'a>(
    triangles: &'a [[u32; 3]],
    is_sheet: &[bool],
    hidden_caps: &[[u32; 3]],
) -> Cow<'a, [[u32; 3]]> {
    let sheets = triangles.iter().zip(is_sheet).filter(|(_, is_sheet)| **is_sheet);
    let turned: Vec<[u32; 3]> = sheets.map(|(&[a, b, c], _)| [b, a, c]).collect();
    if turned.is_empty() && hidden_caps.is_empty() {
        Cow::Borrowed(triangles)
    } else {
        Cow::Owned([triangles, &turned, hidden_caps].concat())
    }
}

/// Coordinates beyond this count as not finite: sums and diagonals have to stay finite.
const LARGEST_COORDINATE: f64 = 1e300;

/// Half-edges (three per triangle) have indices of 32 bits.
const MOST_TRIANGLES: usize = u32::MAX as usize / 3;

/// One index is kept for "none".
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
    prepare_again(source, &[], order, control)
}

/// The same for a mesh that was repaired before and has changed since. `was_both_ways` says which
/// of its triangles, from the first on, are there both ways round and are given once.
///
/// # Errors
/// As [`prepare`].
pub(crate) fn prepare_again(
    source: MeshView<'_>,
    was_both_ways: &[bool],
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
        in_order = triangles_by_place(&in_order, corners);
        control.check()?;
    }
    let (mut kept, mut source_triangles, degenerate) =
        drop_degenerate(&welded.positions, in_order, corners, order);
    repairs.degenerate_triangles =
        triangles.len() - repairs.non_finite_triangles - candidates + degenerate;
    if kept.is_empty() {
        return Err(nothing_usable(triangles.len(), repairs.non_finite_triangles));
    }
    let (duplicates, mut is_both_ways) =
        drop_duplicates(&mut kept, &mut source_triangles, welded.vertices.len());
    for (both_ways, &source) in is_both_ways.iter_mut().zip(&source_triangles) {
        *both_ways |= was_both_ways.get(source as usize) == Some(&true);
    }
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
    let positions = as_vectors(&mesh.positions);
    let turned = orient(positions, &mut mesh.triangles, &connectivity, &is_both_ways);
    let is_sheet = find_sheets(positions, &mut mesh.triangles, &connectivity, &is_both_ways);
    if order == MeshOrder::Place {
        mesh.triangles.iter_mut().for_each(|triangle| *triangle = rotated(*triangle));
    }
    // One that is there both ways round already was as it is turned.
    let of_both = turned.iter().zip(&is_both_ways);
    repairs.flipped_triangles = of_both.filter(|&(&turned, &both)| turned && !both).count();
    control.check()?;

    Ok(PreparedMesh {
        mesh,
        normalization,
        source_triangles,
        source_vertices,
        is_both_ways,
        is_sheet,
        components: connectivity.components,
        closed: connectivity.closed,
        repairs,
        hidden_caps: Vec::new(),
    })
}

/// The vertices in use, in an order, and which of them are one.
struct Welded {
    /// Their indices in the input.
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
    source.check_indices()
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

/// Renumbers the vertices that triangles use, in their order. Returns for each its old index.
pub(crate) fn compact(triangles: &mut [[u32; 3]], vertices: usize) -> Vec<u32> {
    let mut new_indices = vec![0_u32; vertices];
    for &vertex in triangles.as_flattened() {
        new_indices[vertex as usize] = 1;
    }
    let mut old_indices = Vec::new();
    for (old, new) in (0_u32..).zip(&mut new_indices) {
        if *new == 1 {
            *new = old_indices.len() as u32;
            old_indices.push(old);
        }
    }
    for vertex in triangles.as_flattened_mut() {
        *vertex = new_indices[*vertex as usize];
    }
    old_indices
}

/// A triangle that is less high than this over its longest side, as a fraction of the diagonal of
/// the bounding box, has no area. It is below the rounding of coordinates in single precision,
/// where the normal of such a triangle means nothing.
const LEAST_HEIGHT: f64 = 1e-8;

/// Whether a triangle of the normalised mesh is, within rounding, no triangle.
pub(crate) fn is_degenerate(positions: &[Vector], triangle: [u32; 3]) -> bool {
    let [i, j, k] = triangle;
    if i == j || j == k || k == i {
        return true;
    }
    let [a, b, c] = triangle.map(|vertex| positions[vertex as usize]);
    let longest_squared =
        b.distance_squared(a).max(c.distance_squared(b)).max(a.distance_squared(c));
    area_normal(a, b, c).length_squared() < LEAST_HEIGHT * LEAST_HEIGHT * longest_squared
}

// Flat triangles have no area, and their middle vertex lies on their longest side.
//
// Triangulators of polygons with vertices along an edge leave them. To drop one would tear the
// surface, since its other side has the long edge and not the middle vertex. So the triangle
// beyond the long edge is split at the middle vertex first: then nothing is missing without
// the flat one.

/// Flat triangles may lie on flat ones, and each pass mends one layer. A polygon's edge rarely has
/// more vertices.
const MOST_PASSES: usize = 16;

/// Splits the triangles beyond flat ones. Each flat triangle that is mended becomes one half of
/// such a triangle and stands for the same triangle of the input, so `source_triangles` keeps
/// naming the surface that a triangle is part of. Those on open and non-manifold edges remain.
///
/// Triangles have three different vertices. Linear time per pass.
fn split_beyond_flat(
    positions: &[Vector],
    triangles: &mut [[u32; 3]],
    source_triangles: &mut [u32],
) {
    for _ in 0..MOST_PASSES {
        if !split_once(positions, triangles, source_triangles) {
            break;
        }
    }
}

/// Whether any flat triangle was mended.
fn split_once(
    positions: &[Vector],
    triangles: &mut [[u32; 3]],
    source_triangles: &mut [u32],
) -> bool {
    let flat: Vec<u32> = (0_u32..)
        .zip(triangles.iter())
        .filter(|&(_, &triangle)| is_degenerate(positions, triangle))
        .map(|(t, _)| t)
        .collect();
    let mut at_long_edge = vec![false; positions.len()];
    for &t in &flat {
        let triangle = triangles[t as usize];
        let k = longest_side(positions, triangle);
        at_long_edge[triangle[k] as usize] = true;
        at_long_edge[triangle[(k + 1) % 3] as usize] = true;
    }
    // All triangles that have a flat one's long edge are among these.
    let near: Vec<u32> = (0_u32..)
        .zip(triangles.iter())
        .filter(|(_, triangle)| triangle.iter().filter(|&&v| at_long_edge[v as usize]).count() > 1)
        .map(|(t, _)| t)
        .collect();
    let near_triangles: Vec<[u32; 3]> = near.iter().map(|&t| triangles[t as usize]).collect();

    let mut changed = vec![false; near.len()];
    let mut any = false;
    SortedHalfEdges::new(&near_triangles, positions.len()).for_each_edge(|edge| {
        if edge.len() != 2 {
            return;
        }
        let pair = [edge.half_edge(0), edge.half_edge(1)];
        for [own, other] in [pair, [pair[1], pair[0]]] {
            let [(flat, side), (beyond, other_side)] =
                [own, other].map(|half_edge| (half_edge as usize / 3, half_edge as usize % 3));
            let triangle = near_triangles[flat];
            if changed[flat]
                || changed[beyond]
                || !is_degenerate(positions, triangle)
                || longest_side(positions, triangle) != side
            {
                continue;
            }
            let middle = triangle[(side + 2) % 3];
            let split = near_triangles[beyond];
            let [from, to, apex] = [0, 1, 2].map(|k| split[(other_side + k) % 3]);
            let halves = [[from, middle, apex], [middle, to, apex]];
            if apex == middle || halves.iter().any(|&half| is_degenerate(positions, half)) {
                continue;
            }
            changed[flat] = true;
            changed[beyond] = true;
            any = true;
            let [flat, beyond] = [near[flat] as usize, near[beyond] as usize];
            triangles[beyond] = halves[0];
            triangles[flat] = halves[1];
            source_triangles[flat] = source_triangles[beyond];
        }
    });
    any
}

/// The `k` for which the side from vertex `k` to the next is longest.
fn longest_side(positions: &[Vector], triangle: [u32; 3]) -> usize {
    let [a, b, c] = triangle.map(|vertex| positions[vertex as usize]);
    let squares = [b - a, c - b, a - c].map(Vector::length_squared);
    let mut longest = 0;
    for k in 1..3 {
        if squares[k] > squares[longest] {
            longest = k;
        }
    }
    longest
}

/// The candidates that have an area, in their order, each with its index in the input; and how many
/// have none. Where one that has none would leave a gap, what is beyond it is split.
fn drop_degenerate(
    positions: &[Vector],
    mut candidates: Vec<u32>,
    corners: impl Fn(u32) -> [u32; 3],
    order: MeshOrder,
) -> (Vec<[u32; 3]>, Vec<u32>, usize) {
    let mut degenerate = 0;
    let mut has_flat = false;
    let mut kept = Vec::with_capacity(candidates.len());
    candidates.retain(|&source| {
        let triangle @ [a, b, c] = corners(source);
        let is_flat = is_degenerate(positions, triangle);
        degenerate += usize::from(is_flat);
        let keep = a != b && b != c && c != a;
        if keep {
            has_flat |= is_flat;
            kept.push(triangle);
        }
        keep
    });
    if has_flat {
        split_beyond_flat(positions, &mut kept, &mut candidates);
        let mut paired: Vec<(u32, [u32; 3])> = candidates.into_iter().zip(kept).collect();
        paired.retain(|&(_, triangle)| !is_degenerate(positions, triangle));
        match order {
            MeshOrder::Input => sort_by_key(&mut paired, |&(source, _)| source),
            MeshOrder::Place => sort_by_key(&mut paired, |&(_, triangle)| triangle_key(triangle)),
        }
        (candidates, kept) = paired.into_iter().unzip();
    }
    (kept, candidates, degenerate)
}

/// Keeps one of the triangles that have the same vertices, wound as most of them are. Returns how
/// many go, and for each triangle that is left whether there were as many of it one way round as
/// the other: then it is a sheet without an inside, unless it bounds a solid.
///
/// Triangles are sorted by their least vertex by counting, then by the others in short runs.
fn drop_duplicates(
    triangles: &mut Vec<[u32; 3]>,
    source_triangles: &mut Vec<u32>,
    vertices: usize,
) -> (usize, Vec<bool>) {
    let mut offsets = vec![0_u32; vertices + 1];
    for [a, b, c] in triangles.iter() {
        offsets[*a.min(b).min(c) as usize] += 1;
    }
    let mut sum = 0;
    for offset in &mut offsets {
        sum += *offset;
        *offset = sum;
    }
    let mut entries = vec![[0_u32; 3]; triangles.len()];
    for (t, &triangle) in (0_u32..).zip(triangles.iter()) {
        let mut sorted = triangle;
        sorted.sort_unstable();
        let offset = &mut offsets[sorted[0] as usize];
        *offset -= 1;
        entries[*offset as usize] = [sorted[1], sorted[2], t];
    }
    let mut is_duplicate = vec![false; triangles.len()];
    let mut is_both_ways = vec![false; triangles.len()];
    let mut duplicates = 0;
    for range in offsets.windows(2) {
        let bucket = &mut entries[range[0] as usize..range[1] as usize];
        bucket.sort_unstable();
        for copies in bucket.chunk_by(|first, second| first[..2] == second[..2]) {
            duplicates += copies.len() - 1;
            let is_up = |copy: &[u32; 3]| is_ascending(triangles[copy[2] as usize]);
            let ascending = copies.iter().filter(|copy| is_up(copy)).count();
            let kept = match (2 * ascending).cmp(&copies.len()) {
                Ordering::Equal => copies.first(),
                most => copies.iter().find(|copy| is_up(copy) == (most == Ordering::Greater)),
            };
            copies.iter().for_each(|copy| is_duplicate[copy[2] as usize] = true);
            if let Some(kept) = kept {
                is_duplicate[kept[2] as usize] = false;
                is_both_ways[kept[2] as usize] = 2 * ascending == copies.len();
            }
        }
    }
    if duplicates > 0 {
        retain_others(&mut is_both_ways, &is_duplicate);
        retain_others(triangles, &is_duplicate);
        retain_others(source_triangles, &is_duplicate);
    }
    (duplicates, is_both_ways)
}

fn retain_others<T>(items: &mut Vec<T>, is_dropped: &[bool]) {
    let mut is_dropped = is_dropped.iter();
    items.retain(|_| is_dropped.next() != Some(&true));
}

/// Whether the corners follow each other in ascending order, from the least on.
fn is_ascending(triangle: [u32; 3]) -> bool {
    let [_, next, last] = rotated(triangle);
    next < last
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    use super::*;
    use crate::geometry::Sidedness;
    use crate::mesh::adjacency::{Adjacency, NO_NEIGHBOUR};
    use crate::mesh::shapes::{cuboid, join, torus, turn};
    use crate::mesh::simplify::simplify;

    fn prepared(mesh: MeshView<'_>) -> Result<PreparedMesh, Error> {
        prepare(mesh, MeshOrder::Place, &Control::new())
    }

    fn repaired(mesh: &TriangleMesh) -> PreparedMesh {
        prepared(mesh.view()).expect("usable")
    }

    fn refused(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Error {
        prepared(MeshView::new(positions, triangles)).expect_err("unusable")
    }

    fn cube() -> TriangleMesh {
        cuboid([0.0; 3], [1.0; 3])
    }

    /// The cube with more vertices and triangles.
    fn cube_and(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> TriangleMesh {
        let mut mesh = cube();
        mesh.positions.extend(positions);
        mesh.triangles.extend(triangles);
        mesh
    }

    /// The same triangles, each with vertices of its own.
    fn soup(mesh: &TriangleMesh) -> TriangleMesh {
        let corners = mesh.triangles.as_flattened().iter();
        TriangleMesh::new(
            corners.map(|&v| mesh.positions[v as usize]).collect(),
            (0..mesh.triangles.len() as u32).map(|t| [0, 1, 2].map(|k| 3 * t + k)).collect(),
        )
    }

    fn moved(mesh: &TriangleMesh, factor: f64, offset: f64) -> TriangleMesh {
        let positions = mesh.positions.iter().map(|p| p.map(|x| x * factor + offset)).collect();
        TriangleMesh::new(positions, mesh.triangles.clone())
    }

    /// In the units of the input.
    fn volume(prepared: &PreparedMesh) -> f64 {
        let mesh = &prepared.mesh;
        let corners = |t: &[u32; 3]| t.map(|v| mesh.points()[v as usize]);
        let six: f64 = mesh.triangles.iter().map(corners).map(|[a, b, c]| a.dot(b.cross(c))).sum();
        six / 6.0 * prepared.normalization.diagonal.powi(3)
    }

    fn sorted(numbers: &[u32]) -> Vec<u32> {
        let mut sorted = numbers.to_vec();
        sorted.sort_unstable();
        sorted
    }

    #[test]
    fn a_clean_box_only_moves_to_the_origin_with_a_diagonal_of_one() {
        let prepared = repaired(&cuboid([1.0, 2.0, 3.0], [3.0, 5.0, 9.0]));
        assert_eq!(prepared.repairs, Repairs::default());
        assert_eq!(prepared.normalization.centre, Vector::new(2.0, 3.5, 6.0));
        assert!((prepared.normalization.diagonal - 7.0).abs() < 1e-12);
        let expected = Vector::new(1.0, 1.5, 3.0) / 7.0;
        assert!(prepared.mesh.points()[7].abs_diff_eq(expected, 1e-15));
        assert_eq!(sorted(&prepared.source_triangles), Vec::from_iter(0..12));
        assert_eq!(sorted(&prepared.source_vertices), Vec::from_iter(0..8));
        assert_eq!(prepared.components, [0; 12]);
        assert_eq!(prepared.closed, [true]);
    }

    #[test]
    fn single_precision_gives_the_same() {
        let positions: Vec<[f32; 3]> =
            cube().points().iter().map(|p| p.as_vec3().to_array()).collect();
        let prepared = prepared(MeshView::new(&positions, &cube().triangles));
        assert_eq!(prepared, Ok(repaired(&cube())));
    }

    #[test]
    fn what_can_not_be_used_is_refused_in_clear_words() {
        let empty = |vertices, triangles| Error::EmptyMesh { vertices, triangles };
        assert_eq!(refused(&[], &[]), empty(0, 0));
        assert_eq!(refused(&[[0.0; 3]], &[]), empty(1, 0));
        assert_eq!(empty(1, 0).to_string(), "the mesh is empty: 1 vertices, 0 triangles");
        assert_eq!(
            refused(&[[0.0; 3]; 3], &[[0, 1, 2], [0, 3, 1]]),
            Error::IndexOutOfRange { triangle: 1, index: 3, vertices: 3 }
        );
        let line = [[0.0; 3], [1.0; 3], [2.0; 3]];
        let tiny = [[0.0; 3], [1e-320, 0.0, 0.0], [0.0, 1e-320, 0.0]];
        let holes = [[0.0; 3], [1.0, f64::NAN, 0.0], [f64::INFINITY, 0.0, 0.0]];
        for (points, degenerate) in [([[2.0; 3]; 3], 1), (line, 1), (tiny, 1), (holes, 0)] {
            let expected =
                Error::NothingUsable { triangles: 1, degenerate, non_finite: 1 - degenerate };
            assert_eq!(refused(&points, &[[0, 1, 2]]), expected, "{points:?}");
        }
    }

    #[test]
    fn a_sidedness_is_given_for_all_triangles_or_for_none() {
        let cube = cube();
        let with = |count| prepared(cube.view().with_sidedness(&vec![Sidedness::Two; count]));
        assert_eq!(with(3), Err(Error::SidednessCount { sidedness: 3, triangles: 12 }));
        assert_eq!(with(12), Ok(repaired(&cube)));
    }

    /// The edge from 0 to 1 has a middle vertex on one side, and a flat triangle that hides it.
    fn a_box_with_a_flat_triangle_in_its_edge() -> TriangleMesh {
        let mut mesh = cube_and(&[[0.5, 0.0, 0.0]], &[[8, 3, 1], [0, 8, 1]]);
        assert_eq!(mesh.triangles[1], [0, 3, 1]);
        mesh.triangles[1] = [0, 3, 8];
        mesh
    }

    /// A torus glued along its last ring with a reflection.
    fn klein_bottle() -> TriangleMesh {
        let (n, m) = (24_u32, 12_u32);
        let mut mesh = torus(n, m);
        let start = (n - 1) * m;
        for triangle in &mut mesh.triangles {
            if triangle.iter().any(|&v| v >= start) && triangle.iter().any(|&v| v < m) {
                *triangle = triangle.map(|v| if v < m { (m - v) % m } else { v });
            }
        }
        mesh
    }

    #[test]
    fn each_defect_is_counted_and_mended_or_stays() {
        let none = Repairs::default();
        let mut hole = torus(24, 12);
        hole.positions[5][1] = f64::NAN;
        let triangle =
            TriangleMesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]);
        let at_a_corner = join(&[cube(), cuboid([1.0; 3], [2.0; 3])]);
        let at_an_edge = join(&[cube(), turn(cuboid([1.0, 1.0, 0.0], [2.0, 2.0, 1.0]))]);
        let copies: Vec<[u32; 3]> = cube().triangles.iter().map(|&[a, b, c]| [b, c, a]).collect();
        let thrice = cube_and(&[], &[copies, turn(cube()).triangles].concat());
        let far = cube_and(&[[1e9, 0.0, 0.0]], &[[8, 8, 0], [0, 8, 8]]);
        // Two equal indices, and three vertices on the edge from 0 to 1.
        let lines = cube_and(&[[0.5, 0.0, 0.0]], &[[0, 0, 1], [0, 8, 1]]);
        let fin = cube_and(&[[-1.0, -1.0, 0.5]], &[[0, 4, 8]]);
        // The thinnest wall that the tolerance allows, and a thinner one.
        let plate = |thickness| cuboid([0.0; 3], [1.0, 1.0, thickness]);
        for (name, mesh, repairs, triangles, closed) in [
            ("triangle", triangle, Repairs { open_edges: 3, ..none }, 1, &[false][..]),
            ("soup", soup(&cube()), Repairs { welded_vertices: 36 - 8, ..none }, 12, &[true]),
            ("plate", plate(1e-5), none, 12, &[true]),
            (
                "sheet",
                plate(1e-7),
                Repairs {
                    welded_vertices: 4,
                    degenerate_triangles: 8,
                    duplicate_triangles: 2,
                    open_edges: 4,
                    ..none
                },
                2,
                &[false],
            ),
            (
                "far",
                far,
                Repairs { degenerate_triangles: 2, unused_vertices: 1, ..none },
                12,
                &[true],
            ),
            (
                "hole",
                hole,
                Repairs { non_finite_triangles: 6, open_edges: 6, unused_vertices: 1, ..none },
                2 * 24 * 12 - 6,
                &[false],
            ),
            (
                "lines",
                lines,
                Repairs { degenerate_triangles: 2, unused_vertices: 1, ..none },
                12,
                &[true],
            ),
            (
                "flat triangle",
                a_box_with_a_flat_triangle_in_its_edge(),
                Repairs { degenerate_triangles: 1, ..none },
                14,
                &[true],
            ),
            ("thrice", thrice, Repairs { duplicate_triangles: 24, ..none }, 12, &[true]),
            (
                "boxes at an edge",
                at_an_edge,
                Repairs {
                    welded_vertices: 2,
                    non_manifold_edges: 1,
                    flipped_triangles: 12,
                    ..none
                },
                24,
                &[false],
            ),
            (
                "boxes at a corner",
                at_a_corner,
                Repairs { welded_vertices: 1, ..none },
                24,
                &[true; 2],
            ),
            ("fin", fin, Repairs { non_manifold_edges: 1, open_edges: 2, ..none }, 13, &[false]),
            ("Klein bottle", klein_bottle(), none, 2 * 24 * 12, &[false]),
        ] {
            let prepared = repaired(&mesh);
            assert_eq!(prepared.repairs, repairs, "{name}");
            assert_eq!(prepared.mesh.triangles.len(), triangles, "{name}");
            assert_eq!(prepared.closed, closed, "{name}");
            match name {
                "far" | "lines" | "thrice" => {
                    assert_eq!(prepared.mesh, repaired(&cube()).mesh, "{name}");
                    assert_eq!(prepared.is_both_ways, [false; 12], "{name}");
                    assert!(prepared.source_triangles.iter().all(|&t| t < 12), "{name}");
                }
                "flat triangle" => {
                    assert!((volume(&prepared) - 1.0).abs() < 1e-12);
                    assert_eq!(prepared.source_triangles.iter().filter(|&&t| t == 2).count(), 2);
                }
                "boxes at an edge" => assert!((volume(&prepared) - 2.0).abs() < 1e-12),
                _ => {}
            }
        }
    }

    #[test]
    fn any_size_that_numbers_can_hold_is_the_same_mesh() {
        let expected = repaired(&cube());
        for factor in [1e-300, 1e-20, 1e-6, 1e7, 1e30, 1e200, 1e299] {
            let prepared = repaired(&moved(&cube(), factor, 0.0));
            assert_eq!(prepared.repairs, Repairs::default(), "times {factor}");
            for (a, b) in prepared.mesh.points().iter().zip(expected.mesh.points()) {
                assert!(a.distance_squared(*b) < 1e-28, "times {factor}");
            }
        }
        let far = repaired(&moved(&torus(24, 12), 1.0, 1e7));
        assert_eq!(far.repairs, Repairs::default());
        assert!((volume(&far) - volume(&repaired(&torus(24, 12)))).abs() < 1e-5);
    }

    #[test]
    fn soup_with_rounded_coordinates_is_welded_to_one_of_it() {
        let mut mesh = soup(&moved(&torus(24, 12), 1.0, 0.7));
        for (v, position) in mesh.positions.iter_mut().enumerate() {
            position[v % 3] += (v % 7) as f64 * 1e-8;
        }
        let prepared = repaired(&mesh);
        assert_eq!(prepared.mesh.positions.len(), 24 * 12);
        assert_eq!(prepared.closed, [true]);
        for (&position, &source) in prepared.mesh.points().iter().zip(&prepared.source_vertices) {
            let expected = prepared.normalization.normalize(mesh.points()[source as usize]);
            assert_eq!(position, expected);
        }
    }

    #[test]
    fn an_unused_vertex_does_not_matter() {
        for unused in [[1e12, 0.0, 0.0], [f64::NAN; 3], [f64::INFINITY; 3]] {
            let mut mesh = cube();
            mesh.positions.insert(0, unused);
            mesh.triangles = mesh.triangles.iter().map(|t| t.map(|v| v + 1)).collect();
            let prepared = repaired(&mesh);
            assert_eq!(prepared.repairs, Repairs { unused_vertices: 1, ..Repairs::default() });
            assert_eq!(prepared.mesh, repaired(&cube()).mesh);
            assert_eq!(sorted(&prepared.source_vertices), Vec::from_iter(1..9));
        }
    }

    #[test]
    fn what_is_wound_both_ways_is_told_apart_from_what_is_there_twice() {
        let [a, b, c] = cube().triangles[4];
        let mut mesh = cube_and(&[], &[[b, a, c], cube().triangles[7]]);
        assert_eq!(repaired(&mesh).is_sheet, [false; 12], "it bounds the cube");
        mesh.triangles.remove(11);
        let prepared = repaired(&mesh);
        assert_eq!(prepared.repairs.duplicate_triangles, 2);
        assert_eq!(prepared.is_sheet, prepared.is_both_ways);
        for (&source, &is_both_ways) in prepared.source_triangles.iter().zip(&prepared.is_both_ways)
        {
            assert_eq!(is_both_ways, source == 4 || source == 11, "{source}");
        }
    }

    #[test]
    fn the_order_of_the_input_does_not_matter() {
        let mesh = torus(24, 12);
        let expected = repaired(&mesh).mesh;
        let vertices = mesh.positions.len() as u32;
        for step in [5, 7, 11] {
            // Each vertex, triangle and corner comes at another place.
            let place = |vertex: u32| vertex * step % vertices;
            let mut shuffled = TriangleMesh::new(vec![[0.0; 3]; mesh.positions.len()], Vec::new());
            for (vertex, &position) in (0_u32..).zip(&mesh.positions) {
                shuffled.positions[place(vertex) as usize] = position;
            }
            shuffled.triangles = mesh.triangles.iter().map(|t| t.map(place)).collect();
            shuffled.triangles.iter_mut().for_each(|t| t.rotate_left(step as usize % 3));
            shuffled.triangles.rotate_left(100);
            shuffled.triangles.reverse();
            assert_eq!(repaired(&shuffled).mesh, expected);
            assert_eq!(repaired(&turn(shuffled.clone())).mesh, expected, "wound the other way");
            shuffled.triangles.extend(shuffled.triangles.clone());
            assert_eq!(repaired(&shuffled).mesh, expected, "all triangles twice");
        }
    }

    #[test]
    fn every_given_vertex_is_kept_welded_or_unused() {
        let mut mesh = soup(&torus(24, 12));
        mesh.positions[7][2] = f64::INFINITY;
        mesh.positions.push([9.0; 3]);
        let PreparedMesh { repairs, mesh: kept, .. } = repaired(&mesh);
        let gone = repairs.welded_vertices + repairs.unused_vertices;
        assert_eq!(kept.positions.len() + gone, mesh.positions.len());
    }

    #[test]
    fn it_stops_when_cancelled() {
        let control = Control::new();
        control.cancel();
        let result = prepare(cube().view(), MeshOrder::Place, &control);
        assert_eq!(result, Err(Error::Cancelled));
    }

    /// Vertices 0 and 1 end a line along x that the others divide evenly; the last is off it.
    fn line(inner: u32) -> Vec<Vector> {
        let step = 1.0 / f64::from(inner + 1);
        let inner = (1..=inner).map(|i| Vector::X * f64::from(i) * step);
        let ends = [Vector::ZERO, Vector::X].into_iter();
        ends.chain(inner).chain([Vector::new(0.5, -1.0, 0.0)]).collect()
    }

    #[test]
    fn triangles_beyond_flat_ones_are_split_layer_by_layer() {
        for (inner, before, after, sources) in [
            (1, &[[1, 0, 3], [0, 1, 2]][..], &[[1, 2, 3], [2, 0, 3]][..], [0; 4]),
            // Winding that disagrees does not matter.
            (1, &[[0, 1, 3], [0, 1, 2]], &[[0, 2, 3], [2, 1, 3]], [0; 4]),
            // On an open edge, and where all are flat, they remain.
            (1, &[[0, 1, 2]], &[[0, 1, 2]], [0, 1, 2, 3]),
            (2, &[[0, 1, 2], [1, 0, 3]], &[[0, 1, 2], [1, 0, 3]], [0, 1, 2, 3]),
        ] {
            let (mut triangles, mut found) = (before.to_vec(), vec![0, 1, 2, 3]);
            found.truncate(before.len());
            split_beyond_flat(&line(inner), &mut triangles, &mut found);
            assert_eq!(triangles, after, "{before:?}");
            assert_eq!(found, sources[..before.len()], "{before:?}");
        }
        // A fan of flat triangles from vertex 0 over the line's vertices 2, 3, 4.
        let (mut triangles, mut sources) =
            ([[1, 0, 5], [0, 1, 4], [0, 4, 3], [0, 3, 2]], [0, 1, 2, 3]);
        split_beyond_flat(&line(3), &mut triangles, &mut sources);
        assert!(triangles.iter().all(|&t| t.contains(&5) && !is_degenerate(&line(3), t)));
        assert_eq!(sources, [0; 4]);
    }

    /// Triangles of few points on a coarse grid: full of everything that is wrong with meshes.
    fn any_soup() -> impl Strategy<Value = TriangleMesh> {
        let point = prop::array::uniform3((0..4_i32).prop_map(f64::from));
        let points = prop::collection::vec(point, 3..20);
        points.prop_flat_map(|positions| {
            let index = 0..positions.len() as u32;
            let triangles = prop::collection::vec(prop::array::uniform3(index), 1..120);
            triangles.prop_map(move |triangles| TriangleMesh::new(positions.clone(), triangles))
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: RngSeed::Fixed(1), ..Default::default() })]

        #[test]
        fn any_soup_is_repaired_or_refused(soup in any_soup()) {
            let prepared = match prepared(soup.view()) {
                Ok(prepared) => prepared,
                Err(error) => {
                    let is_expected = matches!(error, Error::NothingUsable { .. });
                    prop_assert!(is_expected);
                    return Ok(());
                }
            };
            let PreparedMesh { mesh, components, closed, repairs, .. } = prepared;
            prop_assert!(!mesh.triangles.iter().any(|&t| is_degenerate(mesh.points(), t)));
            prop_assert_eq!(mesh.positions.len(), prepared.source_vertices.len());

            let adjacency = Adjacency::new(&mesh);
            for (entry, &other) in adjacency.neighbours.iter().enumerate() {
                let own = entry as u32 / 3;
                if other == NO_NEIGHBOUR {
                    prop_assert!(!closed[components[own as usize] as usize]);
                } else {
                    prop_assert!(adjacency.triangle_neighbours(other).contains(&own));
                    prop_assert_eq!(components[own as usize], components[other as usize]);
                }
            }
            if closed.iter().all(|&closed| closed) {
                prop_assert_eq!(repairs.open_edges + repairs.non_manifold_edges, 0);
            }

            let target = mesh.triangles.len() / 3;
            let simplified = simplify(&mesh, &components, target, &Control::new());
            let left = simplified.expect("within the limits").components;
            prop_assert!((0..closed.len() as u32).all(|component| left.contains(&component)));
        }

        #[test]
        fn repairing_again_changes_nothing(soup in any_soup()) {
            if let Ok(once) = prepared(soup.view()) {
                let twice = repaired(&once.mesh);
                prop_assert_eq!(&twice.mesh.triangles, &once.mesh.triangles);
                prop_assert_eq!(&twice.components, &once.components);
                prop_assert_eq!(&twice.closed, &once.closed);
                prop_assert_eq!(twice.repairs.flipped_triangles, 0);
            }
        }
    }
}
