//! Triangles that carry no surface: those without area, and those that are there already.

use std::cmp::Ordering;

use super::canonical_order::{MeshOrder, triangle_key};
use super::connectivity::SortedHalfEdges;
use crate::geometry::vector::{Vector, area_normal};

/// A triangle that is less high than this over its longest side, as a fraction of the diagonal of the bounding
/// box, has no area. It is below the rounding of coordinates in single precision, where the
/// normal of such a triangle means nothing.
const LEAST_HEIGHT: f64 = 1e-8;

/// Whether a triangle of the normalised mesh is, within rounding, no triangle.
pub(super) fn is_degenerate(positions: &[Vector], triangle: [u32; 3]) -> bool {
    let [i, j, k] = triangle;
    if i == j || j == k || k == i {
        return true;
    }
    let [a, b, c] = triangle.map(|vertex| positions[vertex as usize]);
    let longest_squared =
        b.distance_squared(a).max(c.distance_squared(b)).max(a.distance_squared(c));
    area_normal(a, b, c).length_squared() < LEAST_HEIGHT * LEAST_HEIGHT * longest_squared
}

// Caps are triangles without area whose middle vertex lies on their longest side.
//
// Triangulators of polygons with vertices along an edge leave them. To drop a cap would tear the
// surface, since its other side has the long edge and not the middle vertex. So the triangle
// beyond the long edge is split at the middle vertex first: then nothing is missing without
// the cap.

/// Caps may lie on caps, and each pass mends one layer. A polygon's edge rarely has more vertices.
const MOST_PASSES: usize = 16;

/// Splits the triangles beyond caps. Each cap that is mended becomes one half of such a triangle
/// and stands for the same triangle of the input, so `source_triangles` keeps naming the
/// surface that a triangle is part of. Caps on open and non-manifold edges remain.
///
/// Triangles have three different vertices. Linear time per pass.
pub(crate) fn split_beyond_caps(
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

/// Whether any cap was mended.
fn split_once(
    positions: &[Vector],
    triangles: &mut [[u32; 3]],
    source_triangles: &mut [u32],
) -> bool {
    let caps: Vec<u32> = (0_u32..)
        .zip(triangles.iter())
        .filter(|&(_, &triangle)| is_degenerate(positions, triangle))
        .map(|(t, _)| t)
        .collect();
    let mut at_long_edge = vec![false; positions.len()];
    for &cap in &caps {
        let triangle = triangles[cap as usize];
        let k = longest_side(positions, triangle);
        at_long_edge[triangle[k] as usize] = true;
        at_long_edge[triangle[(k + 1) % 3] as usize] = true;
    }
    // All triangles that have a cap's long edge are among these.
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
            let [(cap, side), (beyond, other_side)] =
                [own, other].map(|half_edge| (half_edge as usize / 3, half_edge as usize % 3));
            let triangle = near_triangles[cap];
            if changed[cap]
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
            changed[cap] = true;
            changed[beyond] = true;
            any = true;
            let [cap, beyond] = [near[cap] as usize, near[beyond] as usize];
            triangles[beyond] = halves[0];
            triangles[cap] = halves[1];
            source_triangles[cap] = source_triangles[beyond];
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

/// The candidates that have an area, in their order, each with its number in the input; and how many
/// have none. Where one that has none would leave a gap, what is beyond it is split.
pub(super) fn drop_degenerate(
    positions: &[Vector],
    mut candidates: Vec<u32>,
    corners: impl Fn(u32) -> [u32; 3],
    order: MeshOrder,
) -> (Vec<[u32; 3]>, Vec<u32>, usize) {
    let mut degenerate = 0;
    let mut has_caps = false;
    let mut kept = Vec::with_capacity(candidates.len());
    candidates.retain(|&source| {
        let triangle @ [a, b, c] = corners(source);
        let is_cap = is_degenerate(positions, triangle);
        degenerate += usize::from(is_cap);
        let keep = a != b && b != c && c != a;
        if keep {
            has_caps |= is_cap;
            kept.push(triangle);
        }
        keep
    });
    if has_caps {
        split_beyond_caps(positions, &mut kept, &mut candidates);
        let mut paired: Vec<(u32, [u32; 3])> = candidates.into_iter().zip(kept).collect();
        paired.retain(|&(_, triangle)| !is_degenerate(positions, triangle));
        match order {
            MeshOrder::Input => paired.sort_by_key(|&(source, _)| source),
            MeshOrder::Place => paired.sort_by_key(|&(_, triangle)| triangle_key(triangle)),
        }
        (candidates, kept) = paired.into_iter().unzip();
    }
    (kept, candidates, degenerate)
}

/// Keeps one of the triangles that have the same vertices, wound as most of them are. Returns how many go, and
/// for each triangle that is left whether there were as many of it one way round as the other:
/// then it is a sheet without an inside.
///
/// Triangles are sorted by their least vertex by counting, then by the others in short runs.
pub(super) fn drop_duplicates(
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
        let mut keep = is_duplicate.iter().map(|&is_duplicate| !is_duplicate);
        is_both_ways.retain(|_| keep.next().unwrap_or(true));
        let mut keep = is_duplicate.iter().map(|&is_duplicate| !is_duplicate);
        triangles.retain(|_| keep.next().unwrap_or(true));
        let mut keep = is_duplicate.iter().map(|&is_duplicate| !is_duplicate);
        source_triangles.retain(|_| keep.next().unwrap_or(true));
    }
    (duplicates, is_both_ways)
}

/// Whether the corners follow each other in the order of their numbers, from the least on.
fn is_ascending([a, b, c]: [u32; 3]) -> bool {
    let least = a.min(b).min(c);
    let (next, last) = if least == a {
        (b, c)
    } else if least == b {
        (c, a)
    } else {
        (a, b)
    };
    next < last
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vector::into_vectors;

    /// Vertices 0 and 1 end a line along x that the others divide evenly; the last is off it.
    fn line(inner: u32) -> Vec<Vector> {
        let mut positions = vec![[0.0; 3], [1.0, 0.0, 0.0]];
        let step = 1.0 / f64::from(inner + 1);
        positions.extend((1..=inner).map(|i| [f64::from(i) * step, 0.0, 0.0]));
        positions.push([0.5, -1.0, 0.0]);
        into_vectors(positions)
    }

    #[test]
    fn the_triangle_beyond_a_cap_is_split() {
        let mut triangles = [[1, 0, 3], [0, 1, 2]];
        let mut sources = [7, 8];
        split_beyond_caps(&line(1), &mut triangles, &mut sources);
        assert_eq!(triangles, [[1, 2, 3], [2, 0, 3]]);
        assert_eq!(sources, [7, 7]);
    }

    #[test]
    fn winding_that_disagrees_does_not_matter() {
        let mut triangles = [[0, 1, 3], [0, 1, 2]];
        split_beyond_caps(&line(1), &mut triangles, &mut [0, 1]);
        assert_eq!(triangles, [[0, 2, 3], [2, 1, 3]]);
    }

    #[test]
    fn caps_upon_caps_are_mended_layer_by_layer() {
        // A fan of caps from vertex 0 over the line's vertices 2, 3, 4.
        let mut triangles = [[1, 0, 5], [0, 1, 4], [0, 4, 3], [0, 3, 2]];
        let mut sources = [0, 1, 2, 3];
        let positions = line(3);
        split_beyond_caps(&positions, &mut triangles, &mut sources);
        assert!(triangles.iter().all(|&t| !is_degenerate(&positions, t)));
        assert!(triangles.iter().all(|t| t.contains(&5)));
        assert_eq!(sources, [0; 4]);
    }

    #[test]
    fn a_cap_on_an_open_edge_remains() {
        let mut triangles = [[0, 1, 2]];
        split_beyond_caps(&line(1), &mut triangles, &mut [0]);
        assert_eq!(triangles, [[0, 1, 2]]);
    }

    #[test]
    fn a_line_of_caps_alone_remains() {
        let mut triangles = [[0, 1, 2], [1, 0, 3]];
        split_beyond_caps(&line(2), &mut triangles, &mut [0, 1]);
        assert_eq!(triangles, [[0, 1, 2], [1, 0, 3]]);
    }
}
