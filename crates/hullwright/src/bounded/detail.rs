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
