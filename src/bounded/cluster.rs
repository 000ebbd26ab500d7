//! Vertex clustering: a closed mesh of very many triangles is searched by one of fewer, and only repair, the
//! hulls of seeds and verification look at all of them (Rossignac and Borrel, "Multi-resolution 3D approximations for
//! rendering complex scenes", 1993).
//!
//! Vertices in the same cell of a grid whose normals point into the same octant become one of them: that
//! with the least quadric error (Lindstrom, "Out-of-core simplification of large polygonal models", 2000),
//! so that edges stay sharp. No point moves farther than [`Clustered::reach`]: the surface of fewer triangles is
//! that close to the source everywhere, and what is inside of it is inside of the source, or that close to it,
//! since the winding number about a point changes only when the surface moves across it. (The other way round
//! holds but for spikes and ribbons that are shorter and narrower than cells, and vanish.)

use std::sync::Arc;

use super::refine::refine;
use crate::bvh::closest_point::closest_point_on_triangle;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{
    Vector, add, area_normal, bounds, distance, dot, length, length_squared, scale, subtract,
};
use crate::mesh::{PreparedMesh, TriangleMesh};

/// Meshes of fewer triangles are quick enough without.
const MANY_TRIANGLES: usize = 100_000;

/// Side of a cell, in bounds: vertices move by about as much along the surface, and by far less away
/// from it.
const CELL: f64 = 0.4;

/// Clustering has to leave less than this share of the triangles to be worth it.
const WORTH_IT: f64 = 0.5;

/// Keys of cells and octants have 32 bits.
const MOST_CELLS: f64 = (1_u64 << 29) as f64;

/// Among vertices that fit their planes equally well, one in the middle is best. This share of the squared
/// distance to the middle counts as error.
const TO_THE_MIDDLE: f64 = 1e-3;

/// A triangle with a side longer than this, in cells, is kept as it is.
const LONG: f64 = 2.0;

/// All that became one vertex is looked through for distances: of a detail in a large scene that is too much.
const MOST_IN_A_CLUSTER: usize = 4096;

/// Octants are told apart along these axes: flat sides along the usual ones are common, and noise would
/// divide each of them.
const AXES: [Vector; 3] = [[0.51, 0.71, 0.48], [-0.83, 0.27, 0.49], [0.22, -0.65, 0.73]];

/// The triangles at the nearest vertex tell the distance, unless they are farther away than expected by
/// this factor.
const EXPECTED: f64 = 1.01;

/// Triangles between two looks at the control.
const TRIANGLES_PER_CHECK: usize = 16_384;

/// A mesh of fewer triangles, and what they stand for.
pub(crate) struct Clustered {
    /// The source, its long triangles halved.
    pub surface: Arc<TriangleMesh>,
    /// For each triangle of `surface` the prepared mesh's triangle that it is a part of.
    pub parents: Arc<Vec<u32>>,
    /// The mesh of fewer triangles.
    pub mesh: TriangleMesh,
    /// For each triangle of `mesh` the source's component.
    pub components: Vec<u32>,
    /// For each triangle of `surface` the one of `mesh` that stands in for it.
    pub stand_in: Vec<u32>,
    /// For each vertex of `mesh` those of `surface` that became it.
    vertices: Lists,
    /// For each vertex of `mesh` the triangles of `surface` around those.
    around: Lists,
    /// No point of `surface` has moved farther than this, in diagonals.
    pub reach: f64,
}

impl Clustered {
    /// `None` where the mesh has few triangles, would keep most of them, is not closed, or has sheets that are
    /// there both ways. O(n log n) for n vertices.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub(crate) fn new(
        prepared: &PreparedMesh,
        bound: f64,
        longest_edge: f64,
        control: &Control,
    ) -> Result<Option<Self>, Error> {
        // Where the surface ends, the winding number changes without it.
        let is_closed = prepared.closed.iter().all(|&closed| closed);
        if prepared.mesh.triangles.len() < MANY_TRIANGLES
            || !is_closed
            || prepared.is_both_ways.contains(&true)
        {
            return Ok(None);
        }
        let mut surface = prepared.mesh.clone();
        let parents = refine(&mut surface, longest_edge);
        control.check()?;
        let size = CELL * bound;
        let Some(mut clusters) = VertexClusters::new(&surface, size, control)? else {
            return Ok(None);
        };
        control.check()?;
        clusters.free_long(&surface, LONG * size);
        clusters.free_lost(&surface, control)?;
        control.check()?;
        let VertexClusters { of, count } = &clusters;
        let kept = surface.triangles.iter().filter(|&triangle| is_kept(of, triangle)).count();
        if kept as f64 > WORTH_IT * surface.triangles.len() as f64 {
            return Ok(None);
        }
        let of_vertices = || (0..).zip(of).map(|(vertex, &cluster)| (cluster, vertex));
        let of_triangles = || {
            (0..).zip(&surface.triangles).flat_map(|(index, triangle)| {
                let [a, b, c] = triangle.map(|vertex| of[vertex as usize]);
                let second = (b != a).then_some(b);
                let third = (c != a && c != b).then_some(c);
                [Some(a), second, third].into_iter().flatten().map(move |corner| (corner, index))
            })
        };
        let (chosen, (vertices, around)) = crate::parallel::join(
            || chosen(&surface, &clusters, control),
            || (Lists::new(*count, of_vertices), Lists::new(*count, of_triangles)),
        );
        let chosen = chosen?;
        control.check()?;
        if vertices.longest().max(around.longest()) > MOST_IN_A_CLUSTER {
            return Ok(None);
        }
        let position = |vertex: u32| surface.positions[vertex as usize];
        let positions: Vec<Vector> = chosen.iter().map(|&vertex| position(vertex)).collect();
        let moved = |(vertex, &cluster): (usize, &u32)| {
            distance(surface.positions[vertex], positions[cluster as usize])
        };
        let reach = of.iter().enumerate().map(moved).fold(0.0, f64::max);

        let mut triangles = Vec::with_capacity(kept);
        let mut components = Vec::with_capacity(kept);
        // For each cluster any triangle that is left there.
        let mut left = vec![u32::MAX; *count];
        let mut stand_in = vec![u32::MAX; surface.triangles.len()];
        for (index, triangle) in surface.triangles.iter().enumerate() {
            if is_kept(of, triangle) {
                let corners = triangle.map(|vertex| of[vertex as usize]);
                let new = triangles.len() as u32;
                stand_in[index] = new;
                corners.iter().for_each(|&corner| left[corner as usize] = new);
                triangles.push(corners);
                components.push(prepared.components[parents[index] as usize]);
            }
        }
        control.check()?;
        for (stand_in, corners) in stand_in.iter_mut().zip(&surface.triangles) {
            if *stand_in == u32::MAX {
                let left = corners.map(|corner| left[of[corner as usize] as usize]);
                *stand_in = left.into_iter().min().unwrap_or(u32::MAX);
            }
        }
        let mesh = TriangleMesh { positions, triangles };
        let (surface, parents) = (Arc::new(surface), Arc::new(parents));
        Ok(Some(Self { surface, parents, mesh, components, stand_in, vertices, around, reach }))
    }

    /// The distance to the surface from a point near three vertices of the mesh, or more, and the surface's
    /// triangle that is as near. The distance should be little more than `expected`.
    pub(crate) fn closest_around(
        &self,
        vertices: [u32; 3],
        point: Vector,
        expected: f64,
    ) -> (f64, u32) {
        let mut nearest = (f64::INFINITY, u32::MAX, u32::MAX);
        for cluster in vertices {
            for &vertex in self.vertices.of(cluster) {
                let away = subtract(self.surface.positions[vertex as usize], point);
                let squared = length_squared(away);
                if squared < nearest.0 {
                    nearest = (squared, vertex, cluster);
                }
            }
        }
        // Where triangles are small, the nearest one is at the nearest vertex.
        let (_, vertex, cluster) = nearest;
        let has_vertex =
            |&&triangle: &&u32| self.surface.triangles[triangle as usize].contains(&vertex);
        let at_vertex = self.around.of(cluster).iter().filter(has_vertex);
        let found = self.closest_of(at_vertex, point);
        if found.0 <= EXPECTED * expected {
            return found;
        }
        self.closest_of(vertices.iter().flat_map(|&cluster| self.around.of(cluster)), point)
    }

    fn closest_of<'a>(
        &self,
        triangles: impl Iterator<Item = &'a u32>,
        point: Vector,
    ) -> (f64, u32) {
        let mut nearest = (f64::INFINITY, u32::MAX);
        for &triangle in triangles {
            let squared = self.squared_distance_to(point, triangle);
            if squared < nearest.0 {
                nearest = (squared, triangle);
            }
        }
        (nearest.0.sqrt(), nearest.1)
    }

    /// The distance to a triangle of the surface, squared.
    pub(crate) fn squared_distance_to(&self, point: Vector, triangle: u32) -> f64 {
        let corners = self.surface.triangles[triangle as usize];
        let [a, b, c] =
            corners.map(|vertex| subtract(self.surface.positions[vertex as usize], point));
        length_squared(closest_point_on_triangle(a, b, c))
    }
}

/// Which vertices become one.
struct VertexClusters {
    /// For each vertex its cluster.
    of: Vec<u32>,
    count: usize,
}

impl VertexClusters {
    /// By cells of a size, and octants of normals; `None` if there are too many cells.
    fn new(surface: &TriangleMesh, size: f64, control: &Control) -> Result<Option<Self>, Error> {
        let (min, max) = bounds(surface.positions.iter().copied());
        let counts = subtract(max, min).map(|extent| (extent / size).floor() + 1.0);
        if counts.iter().product::<f64>() > MOST_CELLS {
            return Ok(None);
        }
        let [width, height, _] = counts.map(|count| count as u64);
        let mut normals = vec![[0.0; 3]; surface.positions.len()];
        for triangle in &surface.triangles {
            let [a, b, c] = triangle.map(|vertex| surface.positions[vertex as usize]);
            let normal = area_normal(a, b, c);
            for &vertex in triangle {
                normals[vertex as usize] = add(normals[vertex as usize], normal);
            }
        }
        control.check()?;
        let vertices = (0_u64..).zip(surface.positions.iter().zip(&normals));
        let mut keys: Vec<u64> = vertices
            .map(|(vertex, (&position, &normal))| {
                let [x, y, z] = subtract(position, min).map(|x| (x / size) as u64);
                let cell = (z * height + y) * width + x;
                let octant = AXES
                    .iter()
                    .fold(0, |octant, &axis| 2 * octant + u64::from(dot(axis, normal) > 0.0));
                (cell * 8 + octant) << 32 | vertex
            })
            .collect();
        control.check()?;
        keys.sort_unstable();
        control.check()?;
        let mut of = vec![0; keys.len()];
        let mut count = 0;
        for cluster in keys.chunk_by(|a, b| a >> 32 == b >> 32) {
            for &key in cluster {
                of[(key & u64::from(u32::MAX)) as usize] = count;
            }
            count += 1;
        }
        Ok(Some(Self { of, count: count as usize }))
    }

    /// The corners of triangles that would vanish, though a side of them is longer than `longest`, stay
    /// single: the tip of a needle, say.
    fn free_long(&mut self, surface: &TriangleMesh, longest: f64) {
        let is_long = |&[a, b, c]: &[u32; 3]| {
            let squared = |from: u32, to: u32| {
                let [from, to] = [from, to].map(|vertex| surface.positions[vertex as usize]);
                length_squared(subtract(to, from))
            };
            squared(a, b).max(squared(b, c)).max(squared(c, a)) > longest * longest
        };
        let mut is_free = vec![false; self.of.len()];
        for triangle in surface.triangles.iter().filter(|&triangle| !is_kept(&self.of, triangle)) {
            if is_long(triangle) {
                triangle.iter().for_each(|&vertex| is_free[vertex as usize] = true);
            }
        }
        for (cluster, _) in self.of.iter_mut().zip(is_free).filter(|(_, is_free)| *is_free) {
            *cluster = self.count as u32;
            self.count += 1;
        }
        self.renumber();
    }

    /// Where no triangle would be left, as of a narrow ribbon, vertices stay single.
    fn free_lost(&mut self, surface: &TriangleMesh, control: &Control) -> Result<(), Error> {
        loop {
            control.check()?;
            let mut has_triangle = vec![false; self.count];
            for triangle in surface.triangles.iter().filter(|&triangle| is_kept(&self.of, triangle))
            {
                triangle.iter().for_each(|&v| has_triangle[self.of[v as usize] as usize] = true);
            }
            let before = self.count;
            let mut is_taken = vec![false; before];
            for cluster in &mut self.of {
                if !has_triangle[*cluster as usize] {
                    if is_taken[*cluster as usize] {
                        *cluster = self.count as u32;
                        self.count += 1;
                    } else {
                        is_taken[*cluster as usize] = true;
                    }
                }
            }
            if self.count == before {
                return Ok(());
            }
        }
    }

    /// Numbers without gaps, in the order of the clusters.
    fn renumber(&mut self) {
        let mut numbers = vec![0_u32; self.count];
        self.of.iter().for_each(|&cluster| numbers[cluster as usize] = 1);
        let mut count = 0;
        for number in numbers.iter_mut().filter(|number| **number == 1) {
            *number = count;
            count += 1;
        }
        self.of.iter_mut().for_each(|cluster| *cluster = numbers[*cluster as usize]);
        self.count = count as usize;
    }
}

fn is_kept(of: &[u32], triangle: &[u32; 3]) -> bool {
    let [a, b, c] = triangle.map(|vertex| of[vertex as usize]);
    a != b && b != c && c != a
}

/// The sum of squared distances to planes, by a polynomial around an origin.
#[derive(Clone, Default)]
struct Quadric {
    /// xx, yy, zz, xy, yz, zx; x, y, z; 1.
    coefficients: [f64; 10],
    weight: f64,
    middle: Vector,
}

impl Quadric {
    fn add_plane(&mut self, normal: Vector, point: Vector) {
        let area = length(normal);
        if area <= 0.0 {
            return;
        }
        let [x, y, z] = scale(normal, 1.0 / area);
        let offset = -dot([x, y, z], point);
        let squares = [x * x, y * y, z * z, x * y, y * z, z * x];
        let others = [x * offset, y * offset, z * offset, offset * offset];
        let terms = squares.into_iter().chain(others);
        for (coefficient, term) in self.coefficients.iter_mut().zip(terms) {
            *coefficient += area * term;
        }
        self.weight += area;
        self.middle = add(self.middle, scale(point, area));
    }

    fn add_all(&mut self, other: &Self) {
        for (coefficient, term) in self.coefficients.iter_mut().zip(other.coefficients) {
            *coefficient += term;
        }
        self.weight += other.weight;
        self.middle = add(self.middle, other.middle);
    }

    fn error(&self, [x, y, z]: Vector) -> f64 {
        let [xx, yy, zz, xy, yz, zx, ox, oy, oz, one] = self.coefficients;
        let squares = xx * x * x + yy * y * y + zz * z * z;
        let products = xy * x * y + yz * y * z + zx * z * x;
        let away = subtract([x, y, z], scale(self.middle, 1.0 / self.weight));
        let to_the_middle = TO_THE_MIDDLE * self.weight * length_squared(away);
        squares + 2.0 * (products + ox * x + oy * y + oz * z) + one + to_the_middle
    }
}

/// For each cluster the vertex that all its vertices become.
fn chosen(
    surface: &TriangleMesh,
    clusters: &VertexClusters,
    control: &Control,
) -> Result<Vec<u32>, Error> {
    // Backwards, so that the first vertex of each cluster stays.
    let mut first = vec![0_u32; clusters.count];
    for (vertex, &cluster) in (0..clusters.of.len() as u32).zip(&clusters.of).rev() {
        first[cluster as usize] = vertex;
    }
    let origins: Vec<Vector> =
        first.iter().map(|&vertex| surface.positions[vertex as usize]).collect();
    let quadrics = |triangles: &[[u32; 3]]| {
        let mut quadrics = vec![Quadric::default(); clusters.count];
        for (index, triangle) in triangles.iter().enumerate() {
            if index.is_multiple_of(TRIANGLES_PER_CHECK) {
                control.check()?;
            }
            let [a, b, c] = triangle.map(|vertex| surface.positions[vertex as usize]);
            let normal = area_normal(a, b, c);
            let [first, second, third] = triangle.map(|vertex| clusters.of[vertex as usize]);
            let mut add = |cluster: u32, corner: Vector| {
                let point = subtract(corner, origins[cluster as usize]);
                quadrics[cluster as usize].add_plane(normal, point);
            };
            add(first, a);
            if second != first {
                add(second, b);
            }
            if third != first && third != second {
                add(third, c);
            }
        }
        Ok::<_, Error>(quadrics)
    };
    // Always the same two halves: sums must not depend on threads.
    let (one, other) = surface.triangles.split_at(surface.triangles.len() / 2);
    let (one, other) = crate::parallel::join(|| quadrics(one), || quadrics(other));
    let mut quadrics = one?;
    for (quadric, other) in quadrics.iter_mut().zip(&other?) {
        quadric.add_all(other);
    }
    let mut chosen: Vec<(f64, u32)> =
        first.into_iter().map(|vertex| (f64::INFINITY, vertex)).collect();
    for ((vertex, &position), &cluster) in (0..).zip(&surface.positions).zip(&clusters.of) {
        let away = subtract(position, origins[cluster as usize]);
        let error = quadrics[cluster as usize].error(away);
        let best = &mut chosen[cluster as usize];
        if error < best.0 {
            *best = (error, vertex);
        }
    }
    Ok(chosen.into_iter().map(|(_, vertex)| vertex).collect())
}

/// A list for each of some numbers.
struct Lists {
    /// Where each starts, and where the last one ends.
    starts: Vec<u32>,
    entries: Vec<u32>,
}

impl Lists {
    /// Of pairs of a number below `count` and an entry.
    fn new<I: Iterator<Item = (u32, u32)>>(count: usize, pairs: impl Fn() -> I) -> Self {
        let mut starts = vec![0_u32; count + 1];
        pairs().for_each(|(number, _)| starts[number as usize + 1] += 1);
        let mut total = 0;
        for start in &mut starts {
            total += *start;
            *start = total;
        }
        let mut next = starts.clone();
        let mut entries = vec![0; total as usize];
        for (number, entry) in pairs() {
            entries[next[number as usize] as usize] = entry;
            next[number as usize] += 1;
        }
        Self { starts, entries }
    }

    fn longest(&self) -> usize {
        self.starts.windows(2).map(|pair| (pair[1] - pair[0]) as usize).max().unwrap_or(0)
    }

    fn of(&self, number: u32) -> &[u32] {
        let [start, end] = [number, number + 1].map(|number| self.starts[number as usize] as usize);
        &self.entries[start..end]
    }
}

#[cfg(test)]
mod tests;
