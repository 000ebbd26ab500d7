//! Which vertex of a cluster replaces the others: that of least quadric error (Garland and
//! Heckbert 1997; in clusters Lindstrom, "Out-of-Core Simplification of Large Polygonal Models",
//! 2000), so that edges stay sharp.

use super::vertex_clusters::VertexClusters;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{
    Vector, add, area_normal, dot, length, length_squared, scale, subtract,
};
use crate::mesh::TriangleMesh;
use crate::parallel;

/// Share of the squared distance to the cluster's centroid that counts as error: of vertices that
/// fit their planes equally well, the most central one is best. Small enough not to round edges.
const CENTRE_WEIGHT: f64 = 1e-3;

/// Triangles between two checks for cancellation: about a millisecond.
const TRIANGLES_PER_CHECK: usize = 16_384;

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
        self.weighted_sum = add(self.weighted_sum, scale(point, area));
    }

    fn add_all(&mut self, other: &Self) {
        for (coefficient, term) in self.coefficients.iter_mut().zip(other.coefficients) {
            *coefficient += term;
        }
        self.weight += other.weight;
        self.weighted_sum = add(self.weighted_sum, other.weighted_sum);
    }

    fn error(&self, [x, y, z]: Vector) -> f64 {
        let [xx, yy, zz, xy, yz, zx, ox, oy, oz, one] = self.coefficients;
        let squares = xx * x * x + yy * y * y + zz * z * z;
        let products = xy * x * y + yz * y * z + zx * z * x;
        let away = subtract([x, y, z], scale(self.weighted_sum, 1.0 / self.weight));
        let to_centre = CENTRE_WEIGHT * self.weight * length_squared(away);
        squares + 2.0 * (products + ox * x + oy * y + oz * z) + one + to_centre
    }
}

/// For each cluster the vertex that replaces all of its vertices: that of least error. O(n).
///
/// # Errors
/// [`Error::Cancelled`].
pub(super) fn representatives(
    surface: &TriangleMesh,
    clusters: &VertexClusters,
    control: &Control,
) -> Result<Vec<u32>, Error> {
    // In reverse, so that the first vertex of each cluster remains.
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
    // Always the same two halves: floating-point sums must not depend on threads.
    let (one, other) = surface.triangles.split_at(surface.triangles.len() / 2);
    let (one, other) = parallel::join(|| quadrics(one), || quadrics(other));
    let mut quadrics = one?;
    for (quadric, other) in quadrics.iter_mut().zip(&other?) {
        quadric.add_all(other);
    }
    let mut best: Vec<(f64, u32)> =
        first.into_iter().map(|vertex| (f64::INFINITY, vertex)).collect();
    for ((vertex, &position), &cluster) in (0..).zip(&surface.positions).zip(&clusters.of) {
        let away = subtract(position, origins[cluster as usize]);
        let error = quadrics[cluster as usize].error(away);
        let best = &mut best[cluster as usize];
        if error < best.0 {
            *best = (error, vertex);
        }
    }
    Ok(best.into_iter().map(|(_, vertex)| vertex).collect())
}
