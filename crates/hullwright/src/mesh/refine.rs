//! Refinement: long triangles are halved, so that a mesh can be divided into patches where
//! its shape requires it and not only along its own edges. Dense meshes stay unchanged.
//!
//! Longest-edge bisection (Rivara, "Algorithms for refining triangular grids suitable for adaptive
//! and multigrid techniques", 1984), with every triangle at a halved edge split.

use std::collections::BTreeMap;

use crate::geometry::vector::Vector;
use crate::mesh::TriangleMesh;

/// Refinement adds at most about this many triangles: more than patches of a coarse mesh need, and
/// few enough that later stages take no longer than on a dense mesh.
const MAX_ADDED: usize = 4000;

/// Halves the longest edges until none is longer than `longest`, without tearing the surface.
/// Returns for each triangle the original triangle that it is a part of.
///
/// O(triangles), and O(m log m) for m edges that are halved.
pub(crate) fn refine(mesh: &mut TriangleMesh, longest: f64) -> Vec<u32> {
    let mut parents: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
    let most = mesh.triangles.len() + MAX_ADDED;
    let limit = longest * longest;
    while mesh.triangles.len() < most {
        let mut middles: BTreeMap<(u32, u32), u32> = BTreeMap::new();
        let mut is_end = vec![false; mesh.positions.len()];
        for triangle in &mesh.triangles {
            let (edge, squared) = longest_edge(mesh.points(), *triangle);
            if squared > limit && !middles.contains_key(&edge) {
                let [a, b] = [edge.0, edge.1].map(|vertex| mesh.points()[vertex as usize]);
                middles.insert(edge, mesh.positions.len() as u32);
                is_end[edge.0 as usize] = true;
                is_end[edge.1 as usize] = true;
                mesh.positions.push(((a + b) * 0.5).to_array());
            }
        }
        if middles.is_empty() {
            break;
        }
        split(mesh, &mut parents, &middles, &is_end);
    }
    parents
}

/// Splits all triangles at halved edges, longest edge first. `is_end`: which vertices are ends of
/// those.
fn split(
    mesh: &mut TriangleMesh,
    parents: &mut Vec<u32>,
    middles: &BTreeMap<(u32, u32), u32>,
    is_end: &[bool],
) {
    let mut triangles = Vec::with_capacity(mesh.triangles.len() + 2 * middles.len());
    let mut new_parents = Vec::with_capacity(triangles.capacity());
    let mut stack = Vec::new();
    for (&triangle, &parent) in mesh.triangles.iter().zip(parents.iter()) {
        // Most triangles are far from any halved edge.
        if triangle.iter().filter(|&&vertex| is_end[vertex as usize]).count() < 2 {
            triangles.push(triangle);
            new_parents.push(parent);
            continue;
        }
        stack.push(triangle);
        while let Some(triangle) = stack.pop() {
            let halved = (0..3)
                .filter_map(|k| {
                    let [a, b] = [triangle[k], triangle[(k + 1) % 3]];
                    let middle = *middles.get(&edge(a, b))?;
                    let [p, q] = [a, b].map(|vertex| mesh.points()[vertex as usize]);
                    Some((p.distance_squared(q), k, middle))
                })
                .max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
            match halved {
                Some((_, k, middle)) => {
                    let [a, b, c] = [triangle[k], triangle[(k + 1) % 3], triangle[(k + 2) % 3]];
                    stack.push([middle, b, c]);
                    stack.push([a, middle, c]);
                }
                None => {
                    triangles.push(triangle);
                    new_parents.push(parent);
                }
            }
        }
    }
    mesh.triangles = triangles;
    *parents = new_parents;
}

/// An edge as the key of a map: the smaller vertex first.
pub(crate) fn edge(a: u32, b: u32) -> (u32, u32) {
    (a.min(b), a.max(b))
}

fn longest_edge(positions: &[Vector], triangle: [u32; 3]) -> ((u32, u32), f64) {
    let [a, b, c] = triangle;
    let squared = |a: u32, b: u32| positions[a as usize].distance_squared(positions[b as usize]);
    let mut longest = (edge(a, b), squared(a, b));
    for (from, to) in [(b, c), (c, a)] {
        let candidate = (edge(from, to), squared(from, to));
        if candidate.1 > longest.1 {
            longest = candidate;
        }
    }
    longest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::adjacency::{Adjacency, NO_NEIGHBOUR};
    use crate::mesh::shapes::{cuboid, torus};

    #[test]
    fn a_refined_mesh_has_no_long_edge_and_no_tear() {
        let mut mesh = cuboid([0.0; 3], [1.0, 0.5, 0.25]);
        let parents = refine(&mut mesh, 0.2);
        assert_eq!(parents.len(), mesh.triangles.len());
        for &triangle in &mesh.triangles {
            assert!(longest_edge(mesh.points(), triangle).1 <= 0.04 + 1e-12);
        }
        assert!(Adjacency::new(&mesh).neighbours.iter().all(|&n| n != NO_NEIGHBOUR));
    }

    #[test]
    fn a_fine_mesh_stays_as_it_is() {
        let mut mesh = torus(32, 16);
        let before = mesh.clone();
        refine(&mut mesh, 1.0);
        assert_eq!(mesh, before);
    }
}
