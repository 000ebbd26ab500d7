//! The surface of a solid: which side a point is on, and how far the inside extends around it.
//!
//! A point is inside where the generalized winding number is above one half (Jacobson, Kavan,
//! Sorkine-Hornung, "Robust Inside-Outside Segmentation using Generalized Winding Numbers", 2013).
//! Of a closed surface it is the number of times that a ray leaves, less that of its entering: a
//! fraction of the work. Where a surface is open, the inside ends without it, but gradually.

use super::boundary::{Boundary, Slope};
use crate::bvh::Bvh;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::Vector;

/// Where the surface is open, a winding number above this is inside. On both sides of a flat sheet
/// it is one half, so that rounding would decide.
pub(super) const OPEN_INSIDE: f64 = 0.52;

/// Winding numbers by expansion are off by no more than this.
const EXPANSION_ERROR: f64 = 0.01;

/// Where a point is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Side {
    Inside,
    Outside,
}

/// The triangles of a solid, and where they end.
pub(super) struct Surface {
    pub tree: Bvh,
    /// Empty if the surface is closed.
    pub boundary: Boundary,
}

impl Surface {
    /// O(n log n) for n triangles.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn new(
        positions: &[Vector],
        triangles: &[[u32; 3]],
        boundary: Boundary,
        control: &Control,
    ) -> Result<Self, Error> {
        let tree = Bvh::with_control(positions, triangles, control)?;
        let surface = Self { tree, boundary };
        if !surface.is_closed() {
            surface.tree.expect_winding_numbers(control)?;
        }
        Ok(surface)
    }

    /// Whether the surface encloses the inside. Only then is a point's side also that of all points
    /// nearer to it than the surface.
    #[inline]
    pub fn is_closed(&self) -> bool {
        self.boundary.is_empty()
    }

    /// The side of a point. O(log n).
    #[inline]
    pub fn side(&self, point: Vector) -> Side {
        let is_inside = match self.is_closed() {
            true => self.tree.encloses(point),
            false => self.winding_number(point) > OPEN_INSIDE,
        };
        if is_inside { Side::Inside } else { Side::Outside }
    }

    /// The winding number about a point. It is exact except for rounding where the boundary has few
    /// edges: continued from its boundary to infinity, away from a ray, the surface winds about the
    /// point as often as the ray crosses it, and what was added is known in closed form.
    pub fn winding_number(&self, point: Vector) -> f64 {
        match self.boundary.winding_number_beyond(point) {
            Some(beyond) => f64::from(self.tree.crossings(point)) - beyond,
            None => self.tree.winding_number(point),
        }
    }

    /// The radius of a ball around a point that is inside an open surface as a whole, where the
    /// surface is at least `distance` away; `None` if the point itself is outside. A radius below
    /// `needed` may be returned as 0.
    pub fn depth(&self, point: Vector, distance: f64, needed: f64) -> Option<f64> {
        self.depth_by(self.winding_number(point), point, distance, needed)
    }

    /// The radius of a ball around a point that is outside as a whole, where the surface is
    /// `distance` away; 0 if the point itself is inside.
    pub fn clearance(&self, point: Vector, distance: f64) -> f64 {
        if self.is_closed() {
            return if self.tree.encloses(point) { 0.0 } else { distance };
        }
        let missing = OPEN_INSIDE - EXPANSION_ERROR - self.winding_number(point);
        if missing <= 0.0 {
            return 0.0;
        }
        let slope = self.boundary.slope(point, distance, f64::INFINITY);
        slope.way_within(missing).min(distance)
    }

    /// The same, where the winding number about the point is known.
    pub fn depth_by(&self, winding: f64, point: Vector, distance: f64, needed: f64) -> Option<f64> {
        let excess = winding - OPEN_INSIDE;
        if excess <= 0.0 {
            return None;
        }
        if distance <= 0.0 || needed >= distance {
            return Some(0.0);
        }
        // No gradient above this leaves as much as is needed, if the boundary is as near as the
        // surface.
        let limit =
            if needed > 0.0 { excess * (1.0 / needed - 1.0 / distance) } else { f64::INFINITY };
        let slope = self.boundary.slope(point, distance, limit);
        if slope.gradient > limit {
            return Some(0.0);
        }
        Winding { least: winding, most: winding, slope }.depth(distance)
    }
}

/// Bounds on the winding number about a point.
pub(super) struct Winding {
    pub least: f64,
    pub most: f64,
    pub slope: Slope,
}

impl Winding {
    /// The side of the point; `None` if it may be either.
    pub fn side(&self) -> Option<Side> {
        if self.least > OPEN_INSIDE {
            return Some(Side::Inside);
        }
        (self.most <= OPEN_INSIDE).then_some(Side::Outside)
    }

    /// The radius of a ball around the point that is inside as a whole, where the surface is at
    /// least `distance` away; `None` if the point itself may be outside.
    pub fn depth(&self, distance: f64) -> Option<f64> {
        let excess = self.least - OPEN_INSIDE;
        (excess > 0.0).then(|| self.slope.way_within(excess).min(distance))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::SLOPES;
    use crate::geometry::vector::{as_vectors, into_vectors};
    use crate::mesh::shapes::cuboid;

    /// Evenly spread in [-1, 1), another for each number.
    fn spread(number: u32) -> f64 {
        2.0 * (0.5 + 0.618_033_988_749_895 * f64::from(number)).fract() - 1.0
    }

    /// Loose triangles that face anyhow, so that their winding numbers add up and cancel.
    fn loose_triangles(seed: u32) -> (Vec<Vector>, Vec<[u32; 3]>) {
        let point = |k: u32| {
            Vector::from_array(
                [0, 1, 2].map(|axis| 0.4 * spread(seed + 7 * k * k + 3 * k + 11 * axis)),
            )
        };
        ((0..120).map(point).collect(), (0..40).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect())
    }

    fn surface_of(positions: &[Vector], triangles: &[[u32; 3]]) -> Surface {
        let boundary = Boundary::new(positions, triangles);
        Surface { tree: Bvh::new(positions, triangles), boundary }
    }

    fn distance_to(surface: &Surface, point: Vector) -> f64 {
        surface.tree.closest_point(point, f64::INFINITY).unwrap().distance
    }

    /// Calls `check` at many points around loose triangles, with the distance to them. It returns
    /// whether a point is inside: enough must be.
    fn at_many_points(check: impl Fn(&Surface, Vector, f64) -> bool) {
        let mut inside = 0;
        for seed in [0, 1000, 2000] {
            let (positions, triangles) = loose_triangles(seed);
            let surface = surface_of(&positions, &triangles);
            for number in 0..4000 {
                let at = Vector::from_array(
                    [0, 1, 2].map(|axis| 0.4 * spread(5 * number * number + axis)),
                );
                inside += usize::from(check(&surface, at, distance_to(&surface, at)));
            }
        }
        assert!(inside > 100, "{inside}");
    }

    #[test]
    fn within_its_depth_every_point_around_another_is_inside() {
        at_many_points(|surface, at, away| {
            let Some(depth) = surface.depth(at, away, 0.0) else { return false };
            assert!(depth <= away);
            for k in 0..20 {
                let way = Vector::from_array([0, 1, 2].map(|axis| spread(17 * k + 5 * axis)));
                let point = at + way * (0.999 * depth / way.length());
                let number_there = surface.winding_number(point);
                assert!(number_there > OPEN_INSIDE - 1e-9, "{at:?}");
            }
            true
        });
    }

    #[test]
    fn a_depth_is_exact_where_it_is_needed_and_may_be_less_where_it_is_not() {
        at_many_points(|surface, at, away| {
            let depth = |needed| surface.depth(at, away, needed);
            let Some(whole) = depth(0.0) else {
                assert_eq!(depth(0.5 * away), None, "a point outside has none");
                return false;
            };
            for share in [0.1, 0.5, 0.999] {
                assert_eq!(depth(share * whole), Some(whole), "{share}");
            }
            for share in [1.001, 1.5, 4.0] {
                let found = depth(share * whole).unwrap();
                assert!((0.0..=whole).contains(&found), "{share}: {found} of {whole}");
            }
            assert_eq!(depth(1.001 * away), Some(0.0), "farther than the surface is");
            true
        });
    }

    /// The sum of all triangles' solid angles, one by one.
    fn summed(positions: &[Vector], triangles: &[[u32; 3]], point: Vector) -> f64 {
        let half_angle = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|corner| positions[corner as usize] - point);
            let [of_a, of_b, of_c] = [a, b, c].map(Vector::length);
            let real = of_a * of_b * of_c + a.dot(b) * of_c + b.dot(c) * of_a + c.dot(a) * of_b;
            f64::atan2(a.dot(b.cross(c)), real)
        };
        triangles.iter().map(half_angle).sum::<f64>() / std::f64::consts::TAU
    }

    #[test]
    fn crossings_and_the_boundary_give_the_winding_number() {
        // A box without a lid, and loose triangles, some of them twice.
        let open_box = {
            let mesh = cuboid([-0.5, -0.4, -0.3], [0.5, 0.4, 0.3]);
            (into_vectors(mesh.positions), mesh.triangles[2..].to_vec())
        };
        let loose = |seed, count| {
            let (positions, mut triangles) = loose_triangles(seed);
            triangles.truncate(count);
            (positions, triangles)
        };
        let mut twice = loose(0, 20);
        twice.1.extend_from_within(..4);
        let slopes = Vector::new(1.0, SLOPES[0], SLOPES[1]);
        for (positions, triangles) in [open_box, twice, loose(1000, 24)] {
            let surface = surface_of(&positions, &triangles);
            let beyond = surface.boundary.winding_number_beyond(Vector::new(0.01, 0.02, 0.03));
            assert!(beyond.is_some(), "few edges");
            for number in 0..3000 {
                let spot =
                    Vector::from([0, 1, 2].map(|axis| 0.6 * spread(5 * number * number + axis)));
                // From every third point the ray passes through a corner, from another through an
                // edge.
                let [a, b, _] = triangles[number as usize % triangles.len()];
                let (a, b) = (positions[a as usize], positions[b as usize]);
                let point = match number % 3 {
                    0 => spot,
                    1 => a - slopes * 0.7,
                    _ => (a + b) * 0.5 - slopes * 0.3,
                };
                if distance_to(&surface, point) > 1e-6 {
                    let expected = summed(&positions, &triangles, point);
                    let found = surface.winding_number(point);
                    // Where the ray hits an edge, it is the expansion's.
                    let error = if number % 3 == 0 { 1e-9 } else { 0.01 };
                    assert!((found - expected).abs() < error, "{point:?}: {found} {expected}");
                }
            }
        }
    }

    #[test]
    fn sheets_that_cancel_do_not_hide_how_fast_the_number_falls() {
        // Eight sheets face up and seven down, a little smaller: around them the number is that of
        // one sheet, but near the edges it falls as fast as that of all.
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for sheet in 0..15_u32 {
            let (z, size) = (1e-3 * f64::from(sheet), if sheet % 2 == 0 { 0.5 } else { 0.45 });
            positions.extend([
                [-size, -size, z],
                [size, -size, z],
                [size, size, z],
                [-size, size, z],
            ]);
            let first = 4 * sheet;
            let corners =
                if sheet % 2 == 0 { [0, 1, 2, 3] } else { [3, 2, 1, 0] }.map(|k| first + k);
            triangles.extend([
                [corners[0], corners[1], corners[2]],
                [corners[0], corners[2], corners[3]],
            ]);
        }
        let Surface { tree, boundary } = surface_of(as_vectors(&positions), &triangles);
        for x in [0.0, 0.2, 0.4, 0.46] {
            let (at, step) = (Vector::new(x, 0.0, -0.05), 1e-3);
            let away = tree.closest_point(at, f64::INFINITY).unwrap().distance;
            let slope = Vector::from_array([0, 1, 2].map(|axis| {
                let [mut below, mut above] = [at; 2];
                below[axis] -= step;
                above[axis] += step;
                (tree.winding_number(above) - tree.winding_number(below)) / (2.0 * step)
            }));
            let gradient = boundary.slope(at, away, f64::INFINITY).gradient;
            assert!(slope.length() <= gradient, "{x}: {} {gradient}", slope.length());
        }
    }

    #[test]
    fn a_closed_surface_has_no_boundary() {
        let (positions, _) = loose_triangles(0);
        assert!(
            Boundary::new(&positions, &[[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]).is_empty()
        );
        assert!(!Boundary::new(&positions, &[[0, 1, 2], [0, 2, 3], [0, 3, 1]]).is_empty());
    }
}
