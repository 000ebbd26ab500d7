//! What Parry's `ConvexPolyhedron::from_convex_mesh` relies on without looking: it indexes with
//! what it is given, asserts that neighbours are wound alike, and reads the first face of what it
//! made at every contact.

use std::collections::HashSet;

/// Whether triangles over `points` points close up: each edge has exactly two triangles, which
/// run along it in opposite directions, and no triangle names a vertex twice or one that is not
/// there.
pub(super) fn is_closed(points: usize, triangles: &[[u32; 3]]) -> bool {
    let mut edges = HashSet::with_capacity(3 * triangles.len());
    for &[a, b, c] in triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            if from == to || from as usize >= points || !edges.insert((from, to)) {
                return false;
            }
        }
    }
    !triangles.is_empty() && edges.iter().all(|&(from, to)| edges.contains(&(to, from)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

    #[test]
    fn a_tetrahedron_is_closed() {
        assert!(is_closed(4, &TETRAHEDRON));
    }

    #[test]
    fn holes_turned_triangles_and_wrong_indices_are_not() {
        assert!(!is_closed(4, &TETRAHEDRON[..3]));
        assert!(!is_closed(3, &TETRAHEDRON));
        assert!(!is_closed(0, &[]));
        let mut turned = TETRAHEDRON;
        turned[0].swap(0, 1);
        assert!(!is_closed(4, &turned));
        let mut twice = TETRAHEDRON.to_vec();
        twice.push(twice[0]);
        assert!(!is_closed(4, &twice));
        assert!(!is_closed(4, &[[0, 0, 1]]));
    }
}
