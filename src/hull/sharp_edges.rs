//! Points beyond sharp edges: within the tolerance of all planes, and yet far from the hull.
//!
//! A hull grows by points that are farther than the tolerance in front of a plane. Where two faces
//! meet at an acute angle, a point beyond their edge may be within the tolerance of both planes, and
//! farther from both faces than that: all the farther, the thinner the hull.

use super::builder::HullBuilder;
use super::face::{NONE, face_of};
use crate::bvh::closest_point::closest_point_on_triangle;
use crate::geometry::vector::{Vector, length_squared, subtract};

/// More than the rounding errors of a distance between points whose coordinates are at most 1.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

impl HullBuilder {
    /// Adds waiting points that are farther from the hull itself than the tolerance, of each face's
    /// the farthest. Whether there was any.
    pub(super) fn add_points_beyond_sharp_edges(&mut self) -> bool {
        if self.is_coarse() {
            return false;
        }
        let limit = self.threshold + ROUNDING * self.heights.reach;
        let mut is_any = false;
        for face in 0..self.faces.len() as u32 {
            let (mut farthest, mut best) = (limit * limit, None);
            let mut point = self.waiting[face as usize].first;
            while point != NONE {
                let squared = self.squared_distance_to_face(point, face);
                if squared > farthest
                    && let Some((squared, seen)) =
                        self.squared_distance_to_hull(point, face, squared, limit * limit)
                    && squared > farthest
                {
                    (farthest, best) = (squared, Some((point, seen)));
                }
                point = self.next_waiting[point as usize];
            }
            if let Some((point, seen)) = best {
                self.add(point, seen);
                is_any = true;
            }
        }
        is_any
    }

    fn squared_distance_to_face(&self, point: u32, face: u32) -> f64 {
        let position = self.points[point as usize];
        let [a, b, c] = self.faces[face as usize]
            .vertices
            .map(|vertex| subtract(self.points[vertex as usize], position));
        length_squared(closest_point_on_triangle(a, b, c))
    }

    /// The squared distance to the nearest of the faces that a point is not behind, and one of them
    /// that it sees, exactly; `None` if it sees none, or if a face is within `limit`, squared. `start`
    /// is one of those faces, `known` its squared distance.
    fn squared_distance_to_hull(
        &mut self,
        point: u32,
        start: u32,
        known: f64,
        limit: f64,
    ) -> Option<(f64, u32)> {
        let position: Vector = self.points[point as usize];
        let mut least = known;
        let mut seen = self.is_seen(start, point).then_some(start);
        self.begin_walk(start);
        while let Some(face) = self.visible.pop() {
            for twin in self.faces[face as usize].twins {
                let neighbour = face_of(twin);
                if !self.is_new_to_walk(neighbour) {
                    continue;
                }
                let plane = self.faces[neighbour as usize].plane;
                if !self.heights.is_not_behind(plane.height(position), &plane) {
                    continue;
                }
                least = least.min(self.squared_distance_to_face(point, neighbour));
                if least <= limit {
                    return None;
                }
                if seen.is_none() && self.is_seen(neighbour, point) {
                    seen = Some(neighbour);
                }
                self.visible.push(neighbour);
            }
        }
        seen.map(|seen| (least, seen))
    }
}
