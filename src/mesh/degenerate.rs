//! Triangles that carry no surface: those without area, and those that are there already.

use std::cmp::Ordering;

use super::area::is_degenerate;
use super::canonical_order::{MeshOrder, triangle_key};
use super::caps::split_beyond_caps;
use crate::geometry::vector::Vector;

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
