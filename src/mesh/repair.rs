//! Repair: any triangle soup becomes the clean mesh that the other stages work on.
//!
//! Triangles with a coordinate that is not finite go, the rest is moved to the origin and scaled,
//! vertices are welded, degenerate and duplicate triangles go, winding is made consistent and
//! outward, and connected components are found. Holes, non-manifold edges and intersections stay:
//! they are normal input.

use super::components::Connectivity;
use super::orientation::orient;
use super::weld::weld;
use super::{Normalization, PreparedMesh, TriangleMesh, compact};
use crate::decompose::Coordinate;
use crate::vector::{Vector, area_normal, length_squared, subtract};
use crate::{Control, Error, Repairs};

/// A triangle that is less high than this over its longest side, in diagonals of the bounding
/// box, has no area. It is below the rounding of coordinates in single precision, where the
/// normal of such a triangle means nothing.
const LEAST_HEIGHT: f64 = 1e-8;

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
pub(crate) fn prepare<C: Coordinate>(
    positions: &[[C; 3]],
    triangles: &[[u32; 3]],
    control: &Control,
) -> Result<PreparedMesh, Error> {
    validate(positions.len(), triangles)?;
    control.check()?;
    let mut repairs = Repairs::default();

    let position = |vertex: u32| positions[vertex as usize].map(Coordinate::to_f64);
    let survey = Survey::new(positions.len(), triangles, position);
    repairs.non_finite_triangles = survey.non_finite_triangles;
    if survey.candidates.is_empty() || survey.normalization.diagonal == 0.0 {
        return Err(nothing_usable(
            triangles.len(),
            repairs.non_finite_triangles,
        ));
    }
    let normalized: Vec<Vector> = positions
        .iter()
        .map(|p| survey.normalization.normalize(p.map(Coordinate::to_f64)))
        .collect();
    control.check()?;

    let representatives = weld(&normalized, &survey.used);
    repairs.welded_vertices = (0..)
        .zip(&representatives)
        .filter(|&(vertex, &representative)| vertex != representative)
        .count();
    control.check()?;

    let mut source_triangles = survey.candidates;
    let mut kept = Vec::with_capacity(source_triangles.len());
    source_triangles.retain(|&source| {
        let triangle = triangles[source as usize].map(|vertex| representatives[vertex as usize]);
        let keep = !is_degenerate(&normalized, triangle);
        if keep {
            kept.push(triangle);
        }
        keep
    });
    repairs.degenerate_triangles = triangles.len() - repairs.non_finite_triangles - kept.len();
    if kept.is_empty() {
        return Err(nothing_usable(
            triangles.len(),
            repairs.non_finite_triangles,
        ));
    }
    repairs.duplicate_triangles =
        drop_duplicates(&mut kept, &mut source_triangles, positions.len());
    control.check()?;

    let source_vertices = compact(&mut kept, positions.len());
    repairs.unused_vertices = positions.len() - source_vertices.len() - repairs.welded_vertices;
    drop(normalized);
    drop(representatives);
    let normalization = Normalization::of(source_vertices.iter().map(|&v| position(v)));
    let mut mesh = TriangleMesh {
        positions: source_vertices
            .iter()
            .map(|&vertex| normalization.normalize(position(vertex)))
            .collect(),
        triangles: kept,
    };

    let connectivity = Connectivity::new(&mesh.triangles, mesh.positions.len());
    repairs.open_edges = connectivity.open_edges;
    repairs.non_manifold_edges = connectivity.non_manifold_edges;
    control.check()?;
    let turned = orient(&mesh.positions, &mut mesh.triangles, &connectivity);
    repairs.flipped_triangles = turned.iter().filter(|&&turned| turned).count();
    control.check()?;

    Ok(PreparedMesh {
        mesh,
        normalization,
        source_triangles,
        source_vertices,
        components: connectivity.components,
        closed: connectivity.closed,
        repairs,
    })
}

fn nothing_usable(triangles: usize, non_finite: usize) -> Error {
    Error::NothingUsable {
        triangles,
        degenerate: triangles - non_finite,
        non_finite,
    }
}

fn validate(vertices: usize, triangles: &[[u32; 3]]) -> Result<(), Error> {
    if vertices == 0 || triangles.is_empty() {
        return Err(Error::EmptyMesh {
            vertices,
            triangles: triangles.len(),
        });
    }
    for (what, count, limit) in [
        ("vertices", vertices, MOST_VERTICES),
        ("triangles", triangles.len(), MOST_TRIANGLES),
    ] {
        if count > limit {
            return Err(Error::TooLarge { what, count, limit });
        }
    }
    for (t, triangle) in triangles.iter().enumerate() {
        if let Some(&index) = triangle.iter().find(|&&index| index as usize >= vertices) {
            return Err(Error::IndexOutOfRange {
                triangle: t,
                index,
                vertices,
            });
        }
    }
    Ok(())
}

/// Which triangles are worth a closer look, and where they are.
struct Survey {
    /// Triangles of three finite corners at three places, ascending.
    candidates: Vec<u32>,
    /// For each vertex whether a candidate uses it.
    used: Vec<bool>,
    non_finite_triangles: usize,
    normalization: Normalization,
}

impl Survey {
    fn new(vertices: usize, triangles: &[[u32; 3]], position: impl Fn(u32) -> Vector) -> Self {
        let mut candidates = Vec::with_capacity(triangles.len());
        let mut used = vec![false; vertices];
        let mut non_finite_triangles = 0;
        for (t, triangle) in (0_u32..).zip(triangles) {
            let [a, b, c] = triangle.map(&position);
            let is_finite = |x: f64| x.abs() <= LARGEST_COORDINATE;
            if ![a, b, c].as_flattened().iter().all(|&x| is_finite(x)) {
                non_finite_triangles += 1;
            } else if a != b && b != c && c != a {
                candidates.push(t);
                for &vertex in triangle {
                    used[vertex as usize] = true;
                }
            }
        }
        let used_positions = (0_u32..)
            .zip(&used)
            .filter(|(_, used)| **used)
            .map(|(vertex, _)| position(vertex));
        Self {
            normalization: Normalization::of(used_positions),
            candidates,
            used,
            non_finite_triangles,
        }
    }
}

/// Whether a triangle of the normalised mesh is, within rounding, no triangle.
pub(super) fn is_degenerate(positions: &[Vector], triangle: [u32; 3]) -> bool {
    let [i, j, k] = triangle;
    if i == j || j == k || k == i {
        return true;
    }
    let [a, b, c] = triangle.map(|vertex| positions[vertex as usize]);
    let longest_squared = length_squared(subtract(b, a))
        .max(length_squared(subtract(c, b)))
        .max(length_squared(subtract(a, c)));
    length_squared(area_normal(a, b, c)) < LEAST_HEIGHT * LEAST_HEIGHT * longest_squared
}

/// Drops triangles whose vertices an earlier one has too, in whatever order. Returns how many.
///
/// Triangles are sorted by their least vertex by counting, then by the others in short runs.
pub(super) fn drop_duplicates(
    triangles: &mut Vec<[u32; 3]>,
    source_triangles: &mut Vec<u32>,
    vertices: usize,
) -> usize {
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
    let mut duplicates = 0;
    for range in offsets.windows(2) {
        let bucket = &mut entries[range[0] as usize..range[1] as usize];
        bucket.sort_unstable();
        for pair in bucket.windows(2) {
            if pair[0][..2] == pair[1][..2] {
                is_duplicate[pair[1][2] as usize] = true;
                duplicates += 1;
            }
        }
    }
    if duplicates > 0 {
        let mut keep = is_duplicate.iter().map(|&is_duplicate| !is_duplicate);
        triangles.retain(|_| keep.next().unwrap_or(true));
        let mut keep = is_duplicate.iter().map(|&is_duplicate| !is_duplicate);
        source_triangles.retain(|_| keep.next().unwrap_or(true));
    }
    duplicates
}
