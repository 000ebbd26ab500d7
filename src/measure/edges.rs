//! Which edges of a triangle set are open, its vertices welded where they have the same position.

use crate::geometry::vector::Vector;

/// An index for each position, the same for the same position.
fn weld(positions: &[Vector]) -> Vec<u32> {
    // Adding zero turns -0 into 0.
    let key = |index: u32| positions[index as usize].map(|x| (x + 0.0).to_bits());
    let mut order: Vec<u32> = (0..positions.len() as u32).collect();
    order.sort_unstable_by_key(|&index| key(index));
    let mut welded = vec![0; positions.len()];
    let mut first = 0;
    for (place, &index) in order.iter().enumerate() {
        if place == 0 || key(index) != key(first) {
            first = index;
        }
        welded[index as usize] = first;
    }
    welded
}

/// The directed edges of triangles with three different corners, sorted.
fn directed_edges(positions: &[Vector], triangles: &[[u32; 3]]) -> Vec<(u32, u32)> {
    let welded = weld(positions);
    let mut edges: Vec<(u32, u32)> = triangles
        .iter()
        .map(|triangle| triangle.map(|index| welded[index as usize]))
        .filter(|&[a, b, c]| a != b && b != c && c != a)
        .flat_map(|[a, b, c]| [(a, b), (b, c), (c, a)])
        .collect();
    edges.sort_unstable();
    edges
}

/// Share of the edges that only one triangle uses. O(n log n).
pub(super) fn open_share(positions: &[Vector], triangles: &[[u32; 3]]) -> f64 {
    let mut edges = directed_edges(positions, triangles);
    for (a, b) in &mut edges {
        (*a, *b) = (*a.min(b), *a.max(b));
    }
    edges.sort_unstable();
    let (mut all, mut open) = (0, 0);
    for same in edges.chunk_by(|a, b| a == b) {
        all += 1;
        open += usize::from(same.len() == 1);
    }
    if all == 0 { 0.0 } else { open as f64 / f64::from(all) }
}

/// Whether each edge has exactly two triangles, in opposite directions. O(n log n).
pub(super) fn is_closed(positions: &[Vector], triangles: &[[u32; 3]]) -> bool {
    let edges = directed_edges(positions, triangles);
    let is_unique = edges.windows(2).all(|pair| pair[0] != pair[1]);
    let has_twin = |&(a, b): &(u32, u32)| edges.binary_search(&(b, a)).is_ok();
    is_unique && !edges.is_empty() && edges.iter().all(has_twin)
}

#[cfg(test)]
mod tests {
    use super::*;

    const POSITIONS: [Vector; 5] =
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-0.0, 0.0, 0.0]];
    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 4, 3]];

    #[test]
    fn a_tetrahedron_with_a_split_corner_is_closed() {
        assert!(is_closed(&POSITIONS, &TETRAHEDRON));
        assert_eq!(open_share(&POSITIONS, &TETRAHEDRON), 0.0);
    }

    #[test]
    fn a_missing_face_opens_three_of_six_edges() {
        assert!(!is_closed(&POSITIONS, &TETRAHEDRON[1..]));
        assert_eq!(open_share(&POSITIONS, &TETRAHEDRON[1..]), 0.5);
    }

    #[test]
    fn a_flipped_face_is_not_closed_but_has_no_open_edge() {
        let mut flipped = TETRAHEDRON;
        flipped[2].swap(0, 1);
        assert!(!is_closed(&POSITIONS, &flipped));
        assert_eq!(open_share(&POSITIONS, &flipped), 0.0);
    }

    #[test]
    fn triangles_without_three_corners_have_no_edges() {
        assert_eq!(open_share(&POSITIONS, &[[0, 4, 1]]), 0.0);
        assert!(!is_closed(&POSITIONS, &[[0, 4, 1]]));
    }
}
