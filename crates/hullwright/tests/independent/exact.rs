//! Whether a hull is a convex body, by exact predicates: nothing is rounded, so that there is no
//! tolerance.

use robust::{Coord3D, orient3d};

/// What is wrong with a hull; nothing of a sound one.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Faults {
    /// An edge without exactly two triangles in opposite directions, a vertex that is not used, or
    /// not the surface of one ball.
    pub is_open: bool,
    /// A vertex strictly in front of a face.
    pub is_not_convex: bool,
    /// No vertex behind any face.
    pub has_no_volume: bool,
}

/// Tests each vertex against each face. O(vertices times faces).
///
/// A closed surface none of whose vertices is in front of a face bounds its convex hull; that has
/// volume where a vertex is behind a face.
pub fn faults<C: Copy + Into<f64>>(points: &[[C; 3]], triangles: &[[u32; 3]]) -> Faults {
    let exists = |&index: &u32| (index as usize) < points.len();
    if !triangles.iter().flatten().all(exists) || !is_ball(points.len(), triangles) {
        return Faults { is_open: true, ..Faults::default() };
    }
    let points: Vec<Coord3D<f64>> =
        points.iter().map(|&[x, y, z]| Coord3D { x: x.into(), y: y.into(), z: z.into() }).collect();
    let mut faults = Faults { has_no_volume: true, ..Faults::default() };
    for triangle in triangles {
        let [a, b, c] = triangle.map(|index| points[index as usize]);
        for &point in &points {
            // Positive behind a face that runs counter-clockwise seen from outside.
            let side = orient3d(a, b, c, point);
            faults.is_not_convex |= side < 0.0;
            faults.has_no_volume &= side <= 0.0;
        }
    }
    faults
}

/// Whether triangles are the closed surface of a ball over all of some vertices.
fn is_ball(vertices: usize, triangles: &[[u32; 3]]) -> bool {
    let mut edges: Vec<[u32; 2]> =
        triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    edges.sort_unstable();
    let has_twin = |&[a, b]: &[u32; 2]| a != b && edges.binary_search(&[b, a]).is_ok();
    let is_unique = edges.windows(2).all(|pair| pair[0] != pair[1]);
    let mut used: Vec<u32> = triangles.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    is_unique
        && edges.iter().all(has_twin)
        && used.len() == vertices
        // Euler's formula.
        && vertices + triangles.len() == edges.len() / 2 + 2
}
