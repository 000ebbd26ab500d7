//! Volume, first and second moments of solids.

use robust::{Coord, orient2d};

use crate::geometry::vector::{Vector, bounds, cubed};
use crate::sorting::sort_by;

/// Integrals over a solid of 1, of x, and of the products of two coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Moments {
    pub volume: f64,
    pub first: Vector,
    pub second: [Vector; 3],
}

impl Moments {
    /// What closed, outward-oriented triangles enclose, by the divergence theorem: the signed
    /// tetrahedra between each triangle and the origin. O(triangles).
    pub fn enclosed(corners: impl Iterator<Item = [Vector; 3]>) -> Self {
        let mut sum = Self::default();
        for [a, b, c] in corners {
            let six_volumes = a.dot(b.cross(c));
            let total = a + b + c;
            sum.volume += six_volumes / 6.0;
            sum.first += total * (six_volumes / 24.0);
            for i in 0..3 {
                for j in 0..3 {
                    let products = a[i] * a[j] + b[i] * b[j] + c[i] * c[j] + total[i] * total[j];
                    sum.second[i][j] += six_volumes / 120.0 * products;
                }
            }
        }
        sum
    }
}

// The union of overlapping solids, which the divergence theorem would count twice, by columns.
//
// The bounding box is cut into columns along x. The line through the middle of each meets the
// surfaces at points where the winding number rises or falls by one; it is inside where the
// number is positive. Along the line the integrals are exact, across it they are the midpoint
// rule's. Whether a line meets a triangle is decided exactly, and for a line through an edge or
// a vertex as if it were moved aside by an infinitesimal amount: so closed surfaces are met in
// pairs, whatever their triangles.

/// A line meets a surface: in which column, at which x, and whether it enters (1) or leaves (-1).
#[derive(Clone, Copy)]
struct Crossing {
    column: u32,
    x: f64,
    step: i32,
}

/// Moments of where the winding number of outward-oriented triangles is positive, by
/// `resolution²` columns. O(triangles + columns that they cover).
pub(super) fn moments_of_union(triangles: &[[Vector; 3]], resolution: usize) -> Moments {
    let (low, high) = bounds(triangles.as_flattened().iter().copied());
    let grid = Grid { low, spacing: (high - low).map(|x| x / resolution as f64), resolution };
    if !(grid.spacing[1] > 0.0 && grid.spacing[2] > 0.0) {
        return Moments::default();
    }
    let mut crossings = Vec::new();
    for triangle in triangles {
        grid.meet(*triangle, &mut crossings);
    }
    sort_by(&mut crossings, |a, b| {
        a.column.cmp(&b.column).then(a.x.total_cmp(&b.x)).then(b.step.cmp(&a.step))
    });
    let mut moments = Moments::default();
    for column in crossings.chunk_by(|a, b| a.column == b.column) {
        let mut depth = 0;
        for pair in column.windows(2) {
            depth += pair[0].step;
            if depth > 0 {
                grid.add(pair[0].column, pair[0].x, pair[1].x, &mut moments);
            }
        }
    }
    moments
}

struct Grid {
    low: Vector,
    /// Between the middles of columns.
    spacing: Vector,
    resolution: usize,
}

impl Grid {
    fn middle(&self, axis: usize, index: usize) -> f64 {
        self.low[axis] + self.spacing[axis] * (index as f64 + 0.5)
    }

    /// The columns along an axis whose middles may lie between two coordinates.
    fn range(&self, axis: usize, from: f64, to: f64) -> std::ops::Range<usize> {
        let index = |x: f64| (x - self.low[axis]) / self.spacing[axis] - 0.5;
        // One more on either side, against rounding. `as` saturates.
        let first = (index(from).floor() - 1.0) as usize;
        let last = (index(to).ceil() + 2.0) as usize;
        first..last.min(self.resolution)
    }

    fn meet(&self, triangle: [Vector; 3], crossings: &mut Vec<Crossing>) {
        let [a, b, c] = triangle;
        let normal = (b - a).cross(c - a);
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        for row in self.range(2, low[2], high[2]) {
            for place in self.range(1, low[1], high[1]) {
                let (y, z) = (self.middle(1, place), self.middle(2, row));
                let sides = [is_left(a, b, y, z), is_left(b, c, y, z), is_left(c, a, y, z)];
                let step = match sides {
                    [true, true, true] => -1,
                    [false, false, false] => 1,
                    _ => continue,
                };
                let x = a[0] - (normal[1] * (y - a[1]) + normal[2] * (z - a[2])) / normal[0];
                // Rounding on a triangle that is nearly parallel to the line must not throw far.
                let x = if x.is_finite() { x.clamp(low[0], high[0]) } else { low[0] };
                let column = (row * self.resolution + place) as u32;
                crossings.push(Crossing { column, x, step });
            }
        }
    }

    fn add(&self, column: u32, from: f64, to: f64, moments: &mut Moments) {
        let (row, place) = (column as usize / self.resolution, column as usize % self.resolution);
        let [_, dy, dz] = self.spacing.to_array();
        let (y, z) = (self.middle(1, place), self.middle(2, row));
        let area = dy * dz;
        let length = (to - from) * area;
        let x = (to * to - from * from) / 2.0 * area;
        let xx = (cubed(to) - cubed(from)) / 3.0 * area;
        moments.volume += length;
        for (sum, value) in moments.first.as_mut().iter_mut().zip([x, y * length, z * length]) {
            *sum += value;
        }
        let yy = (y * y + dy * dy / 12.0) * length;
        let zz = (z * z + dz * dz / 12.0) * length;
        let (xy, xz, yz) = (x * y, x * z, y * z * length);
        let products = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        for (sum, row) in moments.second.iter_mut().zip(products) {
            *sum += Vector::from(row);
        }
    }
}

/// Whether a line lies to the left of an edge, seen along the line; on it, whether it would after
/// a step in y and a much smaller one in z.
fn is_left(a: Vector, b: Vector, y: f64, z: f64) -> bool {
    let coordinate = |p: Vector| Coord { x: p[1], y: p[2] };
    let side = orient2d(coordinate(a), coordinate(b), Coord { x: y, y: z });
    if side != 0.0 {
        return side > 0.0;
    }
    if a[2] == b[2] { b[1] > a[1] } else { a[2] > b[2] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TriangleMesh;
    use crate::mesh::shapes::{cuboid, join, torus, turn};

    fn moments(mesh: &TriangleMesh, resolution: usize) -> Moments {
        moments_of_union(&corners(mesh), resolution)
    }

    fn corners(mesh: &TriangleMesh) -> Vec<[Vector; 3]> {
        mesh.triangles.iter().map(|t| t.map(|v| mesh.points()[v as usize])).collect()
    }

    fn assert_close(found: f64, expected: f64, tolerance: f64) {
        assert!((found - expected).abs() < tolerance, "{found}, not {expected}");
    }

    #[test]
    fn a_box_is_exact_though_lines_run_through_its_diagonals() {
        let found = moments(&cuboid([0.0; 3], [2.0, 1.0, 1.0]), 8);
        assert_close(found.volume, 2.0, 1e-12);
        assert_close(found.first[0], 2.0, 1e-12);
        assert_close(found.second[0][0], 8.0 / 3.0, 1e-12);
        assert_close(found.second[1][1], 2.0 / 3.0, 1e-12);
        assert_close(found.second[1][2], 0.5, 1e-12);
    }

    #[test]
    fn overlapping_boxes_count_once_and_cavities_not_at_all() {
        let overlapping =
            join(&[cuboid([0.0; 3], [2.0, 1.0, 1.0]), cuboid([1.0, 0.0, 0.0], [3.0, 1.0, 1.0])]);
        assert_close(moments(&overlapping, 8).volume, 3.0, 1e-12);
        let hollow = join(&[cuboid([0.0; 3], [4.0; 3]), turn(cuboid([1.0; 3], [2.0; 3]))]);
        assert_close(moments(&hollow, 64).volume, 63.0, 1e-9);
    }

    #[test]
    fn a_round_body_agrees_with_the_divergence_theorem() {
        let mesh = torus(48, 24);
        let exact = Moments::enclosed(corners(&mesh).into_iter());
        let found = moments(&mesh, 128);
        assert_close(found.volume, exact.volume, 2e-3 * exact.volume);
        for i in 0..3 {
            let expected = exact.second[i][i];
            assert_close(found.second[i][i], expected, 4e-3 * expected);
        }
    }
}
