//! Vertex clusters: which vertices of a very dense mesh become one, and which of them stays.
//!
//! Vertices in the same cell of a grid whose normals point into the same octant are merged (Rossignac
//! and Borrel, "Multi-resolution 3D Approximations for Rendering Complex Scenes", 1993; the octants keep
//! the two sides of a wall apart). The vertex of least quadric error stays (Garland and Heckbert 1997; in
//! clusters Lindstrom, "Out-of-Core Simplification of Large Polygonal Models", 2000), so that edges stay
//! sharp. O(n log n) for n vertices.

use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, area_normal, bounds};
use crate::mesh::TriangleMesh;
use crate::parallel;

/// A cell and an octant (3 bits) share a 32-bit key.
const MAX_CELLS: f64 = (1_u64 << 29) as f64;

/// Octants are bounded by the planes normal to these axes. The axes are oblique: many meshes have
/// sides along the coordinate axes, and noise in their normals would divide each side.
const AXES: [Vector; 3] =
    [Vector::new(0.51, 0.71, 0.48), Vector::new(-0.83, 0.27, 0.49), Vector::new(0.22, -0.65, 0.73)];

/// Share of the squared distance to the cluster's centroid that counts as error: of vertices that
/// fit their planes equally well, the most central one is best. Small enough not to round edges.
const CENTRE_WEIGHT: f64 = 1e-3;

/// Triangles between two checks for cancellation: about a millisecond.
const TRIANGLES_PER_CHECK: usize = 16_384;

/// Which vertices become one.
pub(super) struct VertexClusters {
    /// For each vertex its cluster.
    pub labels: Vec<u32>,
    pub count: usize,
}

impl VertexClusters {
    /// By grid cells of side `size` and by octants of normals; `None` if there are too many cells.
    pub(super) fn new(
        surface: &TriangleMesh,
        size: f64,
        control: &Control,
    ) -> Result<Option<Self>, Error> {
        let (min, max) = bounds(surface.points().iter().copied());
        let counts = (max - min).map(|extent| (extent / size).floor() + 1.0);
        if counts.to_array().iter().product::<f64>() > MAX_CELLS {
            return Ok(None);
        }
        let [width, height, _] = counts.to_array().map(|count| count as u64);
        let mut normals = vec![Vector::ZERO; surface.positions.len()];
        for triangle in &surface.triangles {
            let [a, b, c] = triangle.map(|vertex| surface.points()[vertex as usize]);
            let normal = area_normal(a, b, c);
            for &vertex in triangle {
                normals[vertex as usize] += normal;
            }
        }
        control.check()?;
        let vertices = (0_u64..).zip(surface.points().iter().zip(&normals));
        let mut keys: Vec<u64> = vertices
            .map(|(vertex, (&position, &normal))| {
                let [x, y, z] = (position - min).to_array().map(|x| (x / size) as u64);
                let cell = (z * height + y) * width + x;
                let octant = AXES
                    .iter()
                    .fold(0, |octant, &axis| 2 * octant + u64::from(axis.dot(normal) > 0.0));
                (cell * 8 + octant) << 32 | vertex
            })
            .collect();
        control.check()?;
        keys.sort_unstable();
        control.check()?;
        let mut labels = vec![0; keys.len()];
        let mut count = 0;
        for cluster in keys.chunk_by(|a, b| a >> 32 == b >> 32) {
            for &key in cluster {
                labels[(key & u64::from(u32::MAX)) as usize] = count;
            }
            count += 1;
        }
        Ok(Some(Self { labels, count: count as usize }))
    }

    /// Separates the corners of triangles that would collapse although a side is longer than
    /// `longest`, such as the tip of a needle.
    pub(super) fn separate_long(&mut self, surface: &TriangleMesh, longest: f64) {
        let is_long = |&[a, b, c]: &[u32; 3]| {
            let squared = |from: u32, to: u32| {
                let [from, to] = [from, to].map(|vertex| surface.points()[vertex as usize]);
                to.distance_squared(from)
            };
            squared(a, b).max(squared(b, c)).max(squared(c, a)) > longest * longest
        };
        let mut is_separate = vec![false; self.labels.len()];
        for triangle in surface.triangles.iter().filter(|&triangle| !self.keeps(triangle)) {
            if is_long(triangle) {
                triangle.iter().for_each(|&vertex| is_separate[vertex as usize] = true);
            }
        }
        for (cluster, _) in
            self.labels.iter_mut().zip(is_separate).filter(|(_, is_separate)| *is_separate)
        {
            *cluster = self.count as u32;
            self.count += 1;
        }
        self.renumber();
    }

    /// Separates the vertices of clusters that would keep no triangle, as those of a narrow ribbon.
    pub(super) fn separate_lost(
        &mut self,
        surface: &TriangleMesh,
        control: &Control,
    ) -> Result<(), Error> {
        loop {
            control.check()?;
            let mut has_triangle = vec![false; self.count];
            for triangle in surface.triangles.iter().filter(|&triangle| self.keeps(triangle)) {
                triangle
                    .iter()
                    .for_each(|&v| has_triangle[self.labels[v as usize] as usize] = true);
            }
            let before = self.count;
            let mut is_taken = vec![false; before];
            for cluster in &mut self.labels {
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

    /// Whether a triangle does not collapse: its corners are in three clusters.
    pub(super) fn keeps(&self, triangle: &[u32; 3]) -> bool {
        let [a, b, c] = triangle.map(|vertex| self.labels[vertex as usize]);
        a != b && b != c && c != a
    }

    /// Removes gaps between labels; their order stays.
    fn renumber(&mut self) {
        let mut new_labels = vec![0_u32; self.count];
        self.labels.iter().for_each(|&cluster| new_labels[cluster as usize] = 1);
        let mut count = 0;
        for label in new_labels.iter_mut().filter(|label| **label == 1) {
            *label = count;
            count += 1;
        }
        self.labels.iter_mut().for_each(|cluster| *cluster = new_labels[*cluster as usize]);
        self.count = count as usize;
    }
}

/// The area-weighted sum of squared distances to planes, as a polynomial in the coordinates.
#[derive(Clone, Default)]
struct Quadric {
    /// Of xx, yy, zz, xy, yz, zx; x, y, z; 1.
    coefficients: [f64; 10],
    weight: f64,
    /// Sum of the corners, weighted by area.
    weighted_sum: Vector,
}

impl Quadric {
    fn add_plane(&mut self, normal: Vector, point: Vector) {
        let area = normal.length();
        if area <= 0.0 {
            return;
        }
        let [x, y, z] = (normal * (1.0 / area)).to_array();
        let offset = -Vector::new(x, y, z).dot(point);
        let squares = [x * x, y * y, z * z, x * y, y * z, z * x];
        let others = [x * offset, y * offset, z * offset, offset * offset];
        let terms = squares.into_iter().chain(others);
        for (coefficient, term) in self.coefficients.iter_mut().zip(terms) {
            *coefficient += area * term;
        }
        self.weight += area;
        self.weighted_sum += point * area;
    }

    fn add_all(&mut self, other: &Self) {
        for (coefficient, term) in self.coefficients.iter_mut().zip(other.coefficients) {
            *coefficient += term;
        }
        self.weight += other.weight;
        self.weighted_sum += other.weighted_sum;
    }

    fn error(&self, Vector { x, y, z }: Vector) -> f64 {
        let [xx, yy, zz, xy, yz, zx, ox, oy, oz, one] = self.coefficients;
        let squares = xx * x * x + yy * y * y + zz * z * z;
        let products = xy * x * y + yz * y * z + zx * z * x;
        let away = Vector::new(x, y, z) - self.weighted_sum * (1.0 / self.weight);
        let to_centre = CENTRE_WEIGHT * self.weight * away.length_squared();
        squares + 2.0 * (products + ox * x + oy * y + oz * z) + one + to_centre
    }
}

/// For each cluster the vertex that replaces all of its vertices: that of least error. O(n).
pub(super) fn representatives(
    surface: &TriangleMesh,
    clusters: &VertexClusters,
    control: &Control,
) -> Result<Vec<u32>, Error> {
    // In reverse, so that the first vertex of each cluster remains.
    let mut first = vec![0_u32; clusters.count];
    for (vertex, &cluster) in (0..clusters.labels.len() as u32).zip(&clusters.labels).rev() {
        first[cluster as usize] = vertex;
    }
    let origins: Vec<Vector> =
        first.iter().map(|&vertex| surface.points()[vertex as usize]).collect();
    let quadrics = |triangles: &[[u32; 3]]| {
        let mut quadrics = vec![Quadric::default(); clusters.count];
        for (index, triangle) in triangles.iter().enumerate() {
            if index.is_multiple_of(TRIANGLES_PER_CHECK) {
                control.check()?;
            }
            let [a, b, c] = triangle.map(|vertex| surface.points()[vertex as usize]);
            let normal = area_normal(a, b, c);
            let [first, second, third] = triangle.map(|vertex| clusters.labels[vertex as usize]);
            let mut add = |cluster: u32, corner: Vector| {
                let point = corner - origins[cluster as usize];
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
    // Always the same two halves: floating-point sums must not depend on threads.
    let (one, other) = surface.triangles.split_at(surface.triangles.len() / 2);
    let (one, other) = parallel::join(|| quadrics(one), || quadrics(other));
    let mut quadrics = one?;
    for (quadric, other) in quadrics.iter_mut().zip(&other?) {
        quadric.add_all(other);
    }
    let mut best: Vec<(f64, u32)> =
        first.into_iter().map(|vertex| (f64::INFINITY, vertex)).collect();
    for ((vertex, &position), &cluster) in (0..).zip(surface.points()).zip(&clusters.labels) {
        let away = position - origins[cluster as usize];
        let error = quadrics[cluster as usize].error(away);
        let best = &mut best[cluster as usize];
        if error < best.0 {
            *best = (error, vertex);
        }
    }
    Ok(best.into_iter().map(|(_, vertex)| vertex).collect())
}
