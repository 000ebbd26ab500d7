//! What the coarse surface stands for: for each triangle of the exact surface the part of the
//! coarse one that is closest, and for each part the exact vertices that are too far from it to be
//! contained with it.

use super::surfaces::Surfaces;
use crate::bvh::closest_point::closest_point_on_triangle;
use crate::geometry::TriangleMesh;
use crate::geometry::vector::{Vector, centre};
use crate::parallel;
use crate::solid::Solid;

/// The detail that parts of the coarse surface stand for.
#[derive(Default)]
pub(crate) struct Detail {
    /// For each triangle of the exact surface the part that stands for it.
    pub owners: Vec<u32>,
    /// For each part the exact vertices that its hull must contain beside its own; no list at all
    /// where there are none.
    pub points: Vec<Vec<Vector>>,
}

impl Detail {
    /// `solid` is that of the coarse surface, `parts` is the surface itself, cut or refined;
    /// `parents` names for each part the coarse triangle, ascending. Vertices within the tolerance
    /// of the coarse surface need not be contained. O(n log n) for n exact triangles.
    pub(super) fn new(
        surfaces: &Surfaces,
        solid: &Solid,
        parts: &TriangleMesh,
        parents: &[u32],
        tolerance: f64,
    ) -> Self {
        let Surfaces { exact, coarse, .. } = surfaces;
        let finder = Parts::new(parts, parents, coarse.mesh.triangles.len());
        let exact_points = exact.mesh.points();
        let owners = (0..).zip(&exact.mesh.triangles).map(|(triangle, &corners)| {
            finder.closest(surfaces.coarse_of(triangle), || centre(exact.mesh.corners(corners)))
        });
        let owners: Vec<u32> = owners.collect();
        if surfaces.are_one() || coarse.most_moved() <= tolerance {
            return Self { owners, points: Vec::new() };
        }
        let mut is_kept = vec![false; exact_points.len()];
        coarse.vertices.iter().for_each(|&vertex| is_kept[vertex as usize] = true);
        // Each vertex once, with a coarse triangle near it.
        let mut near = vec![u32::MAX; exact_points.len()];
        for (triangle, corners) in (0..).zip(&exact.mesh.triangles) {
            let parent = surfaces.coarse_of(triangle);
            if coarse.moved[parent as usize] > tolerance {
                corners.iter().for_each(|&vertex| near[vertex as usize] = parent);
            }
        }
        let count = coarse.mesh.triangles.len() as u32;
        let vertices = (0..near.len()).filter(|&v| near[v] != u32::MAX && !is_kept[v]);
        let vertices: Vec<usize> = vertices.collect();
        let closest = parallel::map(&vertices, |&vertex| {
            let point = exact_points[vertex];
            let found = solid.closest(point, near[vertex])?;
            // Sheets are there once more, turned around.
            let parent = if found.triangle < count { found.triangle } else { near[vertex] };
            let part = finder.closest(parent, || point);
            (finder.distance(part, point) > tolerance).then_some((part, vertex as u32))
        });
        let mut needed: Vec<(u32, u32)> = closest.into_iter().flatten().collect();
        needed.sort_unstable();
        let mut points = vec![Vec::new(); parts.triangles.len()];
        for (part, vertex) in needed {
            points[part as usize].push(exact_points[vertex as usize]);
        }
        Self { owners, points }
    }
}

/// The parts of each coarse triangle.
pub(super) struct Parts<'a> {
    mesh: &'a TriangleMesh,
    /// For each coarse triangle its first part, and the end.
    starts: Vec<u32>,
}

impl<'a> Parts<'a> {
    /// `parents` ascends.
    pub(super) fn new(mesh: &'a TriangleMesh, parents: &[u32], count: usize) -> Self {
        let first =
            |triangle: usize| parents.partition_point(|&parent| (parent as usize) < triangle);
        Self { mesh, starts: (0..=count).map(|triangle| first(triangle) as u32).collect() }
    }

    pub(super) fn of(&self, triangle: u32) -> std::ops::Range<u32> {
        self.starts[triangle as usize]..self.starts[triangle as usize + 1]
    }

    /// The part of a coarse triangle that is closest to a point.
    pub(super) fn closest(&self, triangle: u32, point: impl FnOnce() -> Vector) -> u32 {
        let parts = self.of(triangle);
        if parts.len() == 1 {
            return parts.start;
        }
        let point = point();
        let distances = parts.clone().map(|part| (self.distance(part, point), part));
        let closest = distances.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        closest.map_or(parts.start, |closest| closest.1)
    }

    pub(super) fn distance(&self, part: u32, point: Vector) -> f64 {
        let corners = self.mesh.corners(self.mesh.triangles[part as usize]);
        let [a, b, c] = corners.map(|corner| corner - point);
        closest_point_on_triangle(a, b, c).length()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounded::fixture::{Fixture, l_prism};
    use crate::mesh::shapes::{cuboid, uv_sphere};

    /// A strip of four triangles above the x-axis.
    fn strip() -> TriangleMesh {
        let positions = (0..6).map(|k| [f64::from(k), f64::from(k % 2), 0.0]).collect();
        TriangleMesh::new(positions, (0..4).map(|k| [k, k + 1, k + 2]).collect())
    }

    #[test]
    fn a_triangle_may_have_many_parts_or_none() {
        let mesh = strip();
        let parts = Parts::new(&mesh, &[0, 0, 2, 2], 4);
        let ranges = [0, 1, 2, 3].map(|triangle| parts.of(triangle));
        assert_eq!(ranges, [0..2, 2..2, 2..4, 4..4]);
    }

    #[test]
    fn the_closest_part_is_among_those_of_the_triangle() {
        let mesh = strip();
        let parts = Parts::new(&mesh, &[0, 0, 1, 1], 2);
        let closest = |triangle, x| parts.closest(triangle, || Vector::new(x, 0.5, 1.0));
        assert_eq!([closest(0, -1.0), closest(0, 9.0)], [0, 1]);
        assert_eq!([closest(1, -1.0), closest(1, 9.0)], [2, 3]);
        assert_eq!(parts.distance(3, Vector::new(4.0, 0.5, 2.0)), 2.0);
    }

    #[test]
    fn without_detail_each_part_stands_for_the_exact_triangle_that_contains_it() {
        for mesh in [cuboid([0.0; 3], [1.0; 3]), l_prism()] {
            let Fixture { surfaces, patches, .. } = Fixture::new(&mesh, 0.02);
            let Detail { owners, points } = &patches.detail;
            assert!(points.is_empty());
            assert_eq!(owners.len(), surfaces.exact.mesh.triangles.len());
            for (triangle, &owner) in (0..).zip(owners) {
                assert_eq!(patches.parents[owner as usize], triangle);
            }
        }
    }

    #[test]
    fn every_exact_vertex_is_near_the_coarse_surface_or_among_the_detail_of_one_part() {
        // A surface of so many triangles loses more detail than patches may leave out.
        let fixture = Fixture::new(&uv_sphere(40, [0.0; 3], 1.0), 0.02);
        let Fixture { surfaces, solids, patches, settings, .. } = &fixture;
        let tolerance = settings.bound.tolerance();
        assert!(surfaces.coarse.most_moved() > tolerance);
        let detail = &patches.detail.points;
        let parts =
            Parts::new(&patches.surface, &patches.parents, surfaces.coarse.mesh.triangles.len());
        let mut listed: Vec<Vector> = Vec::new();
        for (part, points) in (0..).zip(detail) {
            for &point in points {
                let distance = parts.distance(part, point);
                assert!(tolerance < distance && distance <= surfaces.coarse.most_moved());
                listed.push(point);
            }
        }
        let count = listed.len();
        for &point in surfaces.exact.mesh.points() {
            let closest = solids.coarse.closest(point, u32::MAX).unwrap();
            let corners = surfaces.coarse.mesh.triangles[closest.triangle as usize];
            let [a, b, c] = surfaces.coarse.mesh.corners(corners).map(|corner| corner - point);
            let is_far = closest_point_on_triangle(a, b, c).length() > tolerance + 1e-9;
            assert!(!is_far || listed.contains(&point));
        }
        listed.sort_by(|a, b| a.to_array().partial_cmp(&b.to_array()).unwrap());
        listed.dedup();
        assert!(count > 100 && listed.len() == count, "{count}");
    }
}
