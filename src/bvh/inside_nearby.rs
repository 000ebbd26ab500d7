//! How far it is to the inside of an open surface, which ends where no triangle is.

use super::{Bvh, INSIDE};
use crate::geometry::vector::{Vector, add, distance, length, scale, subtract};

/// Steps of Newton's method along the gradient: the winding number is smooth away from the surface,
/// so that most searches take two or three.
const STEPS: usize = 8;

/// Differences for the gradient, as a share of the distance to the surface.
const DIFFERENCE: f64 = 0.01;

/// How far beyond the level of the inside a step aims: a point on it need not count.
const BEYOND: f64 = 0.005;

impl Bvh {
    /// The distance from a point outside to a point inside that is nearer than `limit`, the distance
    /// to the surface; `limit` where none is found. An upper bound on the distance to the nearest one.
    pub(crate) fn distance_to_inside(&self, point: Vector, limit: f64) -> f64 {
        let step = DIFFERENCE * limit;
        let mut at = point;
        for _ in 0..STEPS {
            let number = self.winding_number(at);
            if number > INSIDE {
                return distance(at, point);
            }
            let slope = [0, 1, 2].map(|axis| {
                let mut beside = at;
                beside[axis] += step;
                (self.winding_number(beside) - number) / step
            });
            let steepness = length(slope);
            if steepness <= 0.0 {
                return limit;
            }
            let way = ((INSIDE + BEYOND - number) / steepness).min(0.5 * limit);
            at = add(at, scale(slope, way / steepness));
            if length(subtract(at, point)) >= limit {
                return limit;
            }
        }
        limit
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn above_the_mouth_of_a_box_without_a_lid_the_inside_is_nearer_than_the_surface() {
        let corner = |i: u32| [0, 1, 2].map(|axis| f64::from(i >> axis & 1) - 0.5);
        let positions: Vec<Vector> = (0..8).map(corner).collect();
        let walls = [[0, 2, 1], [1, 2, 3], [0, 1, 4], [1, 5, 4], [2, 6, 3], [3, 6, 7]];
        let triangles = [&walls[..], &[[0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5]]].concat();
        let bvh = Bvh::new(&positions, &triangles);
        let above = [0.0, 0.0, 0.51];
        assert!(!bvh.is_inside(above) && bvh.is_inside([0.0, 0.0, 0.49]));
        let to_surface = bvh.closest_point(above, f64::INFINITY).unwrap().distance;
        let to_inside = bvh.distance_to_inside(above, to_surface);
        assert!(to_surface > 0.49 && (0.01..0.03).contains(&to_inside), "{to_inside}");
        // Beside a wall nothing inside is nearer than the wall.
        let beside = [0.6, 0.0, 0.0];
        let to_wall = bvh.closest_point(beside, f64::INFINITY).unwrap().distance;
        assert_eq!(bvh.distance_to_inside(beside, to_wall), to_wall);
    }
}
