//! What modelling programs leave behind though nobody meant it: noise, needles, and a wall behind
//! another.

use std::collections::HashMap;

use hullwright::TriangleMesh;

use super::random::Random;
use crate::shapes::{Vector, join};

/// A place as a key; zero has two signs and is one place.
pub(super) fn place(point: [f64; 3]) -> [u64; 3] {
    point.map(|x| (x + 0.0).to_bits())
}

/// The vertices at each place.
pub(super) fn by_place(positions: &[[f64; 3]]) -> HashMap<[u64; 3], Vec<usize>> {
    let mut places: HashMap<[u64; 3], Vec<usize>> = HashMap::new();
    for (vertex, &point) in positions.iter().enumerate() {
        places.entry(place(point)).or_default().push(vertex);
    }
    places
}

/// Moves each coordinate by up to `size`, at random.
pub(super) fn jitter(mesh: &mut TriangleMesh, size: f64) {
    let mut random = Random(1);
    for x in mesh.positions.as_flattened_mut() {
        *x += size * (2.0 * random.unit() - 1.0);
    }
}

/// The same, but vertices at the same place move together.
pub(super) fn jitter_welded(mesh: &mut TriangleMesh, size: f64) {
    let mut random = Random(1);
    let mut moved = HashMap::new();
    for point in &mut mesh.positions {
        let mut drawn = || point.map(|x| x + size * (2.0 * random.unit() - 1.0));
        *point = *moved.entry(place(*point)).or_insert_with(&mut drawn);
    }
}

/// The largest fraction of a triangle's height that a needle takes; more would be no needle.
const HIGHEST_NEEDLE: f64 = 1.0 / 3.0;

/// Divides each triangle at a point inside, close to the middle of its longest edge: one of the
/// three is a needle whose height is this fraction of that edge. No edge is divided, so that the
/// surface stays as closed as it was.
pub(super) fn slivers(mesh: &TriangleMesh, aspect: f64) -> TriangleMesh {
    let mut positions = mesh.positions.clone();
    let divide = |&triangle: &[u32; 3]| {
        let corners = triangle.map(|vertex| Vector::from(mesh.positions[vertex as usize]));
        let length = |side: &usize| corners[*side].distance_squared(corners[(side + 1) % 3]);
        let longest = (0..3).max_by(|a, b| length(a).total_cmp(&length(b))).unwrap_or(0);
        let at = |corner: usize| (longest + corner) % 3;
        let ([a, b, c], [i, j, k]) =
            ([0, 1, 2].map(|x| corners[at(x)]), [0, 1, 2].map(|x| triangle[at(x)]));
        let height = (b - a).cross(c - a).length() / a.distance(b);
        let share = (aspect * a.distance(b) / height).min(HIGHEST_NEEDLE);
        let middle = a.midpoint(b);
        let tip = positions.len() as u32;
        positions.push((middle + share * (c - middle)).to_array());
        [[i, j, tip], [j, k, tip], [k, i, tip]]
    };
    let triangles = mesh.triangles.iter().flat_map(divide).collect();
    let sidedness = mesh.sidedness.iter().flat_map(|&side| [side; 3]).collect();
    TriangleMesh { positions, triangles, sidedness }
}

/// The mesh and a copy of it, whose vertices are this far from their own along their normals. Those
/// are weighted by angles (Bærentzen and Aanæs, 2005), so that they do not depend on how faces are
/// cut. Where normals cancel each other the copy touches the mesh.
pub(super) fn walls(mesh: &TriangleMesh, distance: f64) -> TriangleMesh {
    let mut normals: HashMap<[u64; 3], Vector> = HashMap::new();
    for triangle in &mesh.triangles {
        let points = triangle.map(|vertex| mesh.positions[vertex as usize]);
        let [a, b, c] = points.map(Vector::from);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        for (point, (from, to)) in
            points.into_iter().zip([(b - a, c - a), (c - b, a - b), (a - c, b - c)])
        {
            let angle = from.normalize_or_zero().dot(to.normalize_or_zero()).clamp(-1.0, 1.0);
            *normals.entry(place(point)).or_default() += angle.acos() * normal;
        }
    }
    let mut copy = mesh.clone();
    for point in &mut copy.positions {
        let normal = normals.get(&place(*point)).copied().unwrap_or_default();
        *point = (Vector::from(*point) + distance * normal.normalize_or_zero()).to_array();
    }
    let sidedness = mesh.sidedness.repeat(2);
    TriangleMesh { sidedness, ..join(&[mesh.clone(), copy]) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::{cuboid, uv_sphere, volume};

    fn corners(mesh: &TriangleMesh, triangle: [u32; 3]) -> [Vector; 3] {
        triangle.map(|vertex| Vector::from(mesh.positions[vertex as usize]))
    }

    fn area(mesh: &TriangleMesh) -> f64 {
        let of = |&triangle: &[u32; 3]| {
            let [a, b, c] = corners(mesh, triangle);
            (b - a).cross(c - a).length() / 2.0
        };
        mesh.triangles.iter().map(of).sum()
    }

    #[test]
    fn needles_have_their_aspect_and_leave_area_volume_and_surface() {
        let mesh = uv_sphere(12, 1.0);
        for aspect in [1e-3, 1e-6, 1e-9] {
            let divided = slivers(&mesh, aspect);
            assert_eq!(divided.triangles.len(), 3 * mesh.triangles.len());
            assert!((area(&divided) / area(&mesh) - 1.0).abs() < 1e-12);
            assert!((volume(&divided) / volume(&mesh) - 1.0).abs() < 1e-12);
            for (thirds, &whole) in divided.triangles.chunks(3).zip(&mesh.triangles) {
                let [a, b, tip] = corners(&divided, thirds[0]);
                let height = (b - a).cross(tip - a).length() / a.distance_squared(b);
                assert!((height / aspect - 1.0).abs() < 1e-6, "{height} for {aspect}");
                let [a, b, c] = corners(&mesh, whole);
                let normal = (b - a).cross(c - a).normalize();
                assert!(normal.dot(tip - a).abs() < 1e-15, "the tip is in the triangle's plane");
            }
        }
    }

    #[test]
    fn a_wall_is_as_far_from_the_surface_as_it_says() {
        for distance in [1e-9, 1e-5, 1e-2] {
            let mesh = cuboid([0.0; 3], [1.0, 2.0, 3.0]);
            let both = walls(&mesh, distance);
            assert_eq!(both.triangles.len(), 24);
            assert_eq!(both.positions[..8], mesh.positions);
            // All corners of a box move equally along its axes.
            let step = distance / 3.0_f64.sqrt();
            for (near, far) in both.positions[..8].iter().zip(&both.positions[8..]) {
                let moved = Vector::from(*far) - Vector::from(*near);
                assert!((moved.length() - distance).abs() < 1e-14);
                assert!(moved.abs().to_array().iter().all(|x| (x - step).abs() < 1e-14));
            }
            let copy = both.triangles[12..].to_vec();
            let copy = TriangleMesh::new(both.positions.clone(), copy);
            assert!(volume(&copy) > volume(&mesh), "it is outside");
        }
    }

    #[test]
    fn welded_vertices_stay_together_and_others_do_not() {
        let mut mesh = cuboid([0.0; 3], [1.0; 3]);
        mesh.positions.extend(mesh.positions.clone());
        mesh.positions[8] = [-0.0; 3];
        let (mut welded, mut parted) = (mesh.clone(), mesh.clone());
        jitter_welded(&mut welded, 1e-3);
        jitter(&mut parted, 1e-3);
        assert_eq!(welded.positions[..8], welded.positions[8..]);
        assert_ne!(parted.positions[..8], parted.positions[8..]);
        for moved in [welded, parted] {
            let pairs = moved.positions.as_flattened().iter().zip(mesh.positions.as_flattened());
            assert!(pairs.clone().all(|(x, y)| (x - y).abs() <= 1e-3));
            assert!(pairs.clone().all(|(x, y)| x != y));
        }
    }
}
