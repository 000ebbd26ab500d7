//! How far triangles are from a surface at most: an upper bound without samples.
//!
//! The distance to one triangle is a convex function. So a polygon whose corners are all within a
//! length of the same triangle is within that length as a whole. What is near to several triangles
//! is divided: what lies over the nearest one, within the prism of its sides, is cut out and judged
//! by its corners; the rest is judged in turn. What neither decides is halved, down to parts that
//! are decided by their centre, since distance is 1-Lipschitz. So a large triangle over n small
//! ones in its plane takes O(n) steps, however small the length is.

use crate::bvh::Bvh;
use crate::bvh::closest_point::EXACT;
use crate::geometry::vector::{Vector, larger};

/// A part smaller than this fraction of the length is not divided. If its centre does not decide
/// it, it counts as beyond the length: it is almost that far away.
const RESOLUTION: f64 = 0.02;

/// A part whose centre is no deeper than this over a triangle, in the pipeline's space, is not cut
/// by its sides: rounding would leave the same sliver again and again.
const LEAST_DEPTH: f64 = 1e-13;

/// Parts of one triangle. What is still open then counts as beyond the length. A face that is cut
/// into ten thousand triangles takes fewer.
const MAX_PARTS: usize = 1 << 16;

/// A triangle of the surface to begin with, where none is known.
pub(super) const NO_GUESS: u32 = u32::MAX;

/// A surface that distances are measured to.
pub(super) struct Target<'a> {
    tree: Bvh,
    points: &'a [Vector],
    triangles: &'a [[u32; 3]],
    resolution: f64,
    /// Whether large parts are halved before triangles are cut out of them.
    is_careful: bool,
}

/// Memory of measurements.
#[derive(Default)]
pub(super) struct Parts {
    /// The greatest distance that a point had: a lower bound.
    pub seen: f64,
    /// How many parts a triangle may have, if they are fewer than usual.
    pub most: Option<usize>,
    /// Whether the last triangle had more.
    pub are_spent: bool,
    /// Polygons one after another, and how many corners each has.
    corners: Vec<Vector>,
    counts: Vec<usize>,
    part: Vec<Vector>,
    uncut: Vec<Vector>,
    inside: Vec<Vector>,
    outside: Vec<Vector>,
    /// The triangles that the last measurement was from. Where it was refuted, the last is the
    /// nearest there.
    pub used: Vec<u32>,
}

impl Parts {
    fn push(&mut self) {
        self.corners.extend_from_slice(&self.outside);
        self.counts.push(self.outside.len());
    }

    /// Takes the last polygon as the current part.
    fn pop(&mut self) -> bool {
        let Some(count) = self.counts.pop() else { return false };
        self.part.clear();
        self.part.extend(self.corners.drain(self.corners.len() - count..));
        true
    }
}

impl<'a> Target<'a> {
    pub(super) fn new(tree: Bvh, points: &'a [Vector], triangles: &'a [[u32; 3]]) -> Self {
        Self { tree, points, triangles, resolution: RESOLUTION, is_careful: false }
    }

    /// The same, where a length that is not shown is that close to the distance: a fraction of it.
    /// What lies over many triangles takes fewer parts.
    pub(super) fn with_resolution(self, resolution: f64) -> Self {
        Self { resolution, is_careful: true, ..self }
    }

    /// How far a point is from the surface.
    pub(super) fn distance(&self, point: Vector) -> Option<f64> {
        Some(self.tree.closest_point(point, f64::INFINITY)?.distance)
    }

    /// The triangle that is closest to a point.
    pub(super) fn closest(&self, point: Vector) -> Option<u32> {
        Some(self.tree.closest_point(point, f64::INFINITY)?.triangle)
    }

    /// A triangle within a length of a point. Faster if the triangle `guess` is near.
    pub(super) fn near(&self, point: Vector, length: f64, guess: u32) -> Option<u32> {
        let closest = self.tree.closest_point_near(point, length, guess)?;
        (closest.distance <= length).then_some(closest.triangle)
    }

    /// An upper bound on the distance from any point of a triangle to the surface; `None` if it is
    /// not shown to be at most `limit`. Faster if the triangle `guess` of the surface is near.
    pub(super) fn farthest(
        &self,
        corners: [Vector; 3],
        guess: u32,
        limit: f64,
        parts: &mut Parts,
    ) -> Option<f64> {
        let of_guess = self.farthest_corner(&corners, guess);
        parts.used.clear();
        if of_guess <= limit {
            parts.used.push(guess);
            return Some(of_guess);
        }
        parts.corners.clear();
        parts.counts.clear();
        parts.outside.clear();
        parts.outside.extend(corners);
        parts.push();
        let (mut farthest, mut guess) = (0.0, guess);
        let mut left = parts.most.unwrap_or(MAX_PARTS);
        parts.are_spent = false;
        while parts.pop() {
            parts.are_spent = left == 0;
            left = left.checked_sub(1)?;
            let centre = parts.part.iter().fold(Vector::ZERO, |sum, &corner| sum + corner)
                * (1.0 / parts.part.len() as f64);
            let closest = self.tree.closest_point_near(centre, EXACT, guess)?;
            guess = closest.triangle;
            if parts.used.last() != Some(&guess) {
                parts.used.push(guess);
            }
            parts.seen = larger(parts.seen, closest.distance);
            // A distance that is not a number is beyond the limit, too.
            let is_within = closest.distance <= limit;
            if !is_within {
                return None;
            }
            let most = self.farthest_corner(&parts.part, guess);
            if most <= limit {
                farthest = larger(farthest, most);
                continue;
            }
            let radius = parts.part.iter().map(|corner| corner.distance(centre)).fold(0.0, larger);
            if closest.distance + radius <= limit {
                farthest = larger(farthest, closest.distance + radius);
                continue;
            }
            if radius <= self.resolution * limit {
                return None;
            }
            // A part that is cut in its whole length by each of many small triangles falls into the
            // square of their number.
            let is_large = self.is_careful && radius > self.extent(guess);
            let cut = if is_large { None } else { self.cut_out(centre, guess, limit, parts) };
            match cut {
                Some(most) => farthest = larger(farthest, most),
                None => halve(centre, parts),
            }
        }
        Some(farthest)
    }

    /// The longest side of a triangle.
    fn extent(&self, triangle: u32) -> f64 {
        let Some(corners) = self.triangles.get(triangle as usize) else { return 0.0 };
        let [a, b, c] = corners.map(|vertex| self.points[vertex as usize]);
        larger(larger(a.distance(b), b.distance(c)), c.distance(a))
    }

    /// The greatest distance of corners from one triangle.
    fn farthest_corner(&self, corners: &[Vector], triangle: u32) -> f64 {
        let distances =
            corners.iter().map(|&corner| self.tree.distance_to_triangle(corner, triangle));
        distances.fold(0.0, larger)
    }

    /// Cuts what lies over a triangle out of the part, and leaves the rest for later. Returns how
    /// far that is from the triangle; `None`, and leaves nothing, if there is nothing over the
    /// triangle or it is farther than `limit`.
    fn cut_out(&self, centre: Vector, triangle: u32, limit: f64, parts: &mut Parts) -> Option<f64> {
        let corners = self.triangles.get(triangle as usize)?;
        let [a, b, c] = corners.map(|vertex| self.points[vertex as usize]);
        let normal = (b - a).cross(c - a);
        let sides = [(a, b), (b, c), (c, a)]
            .map(|(from, to)| (from, (to - from).cross(normal).normalize_or_zero()));
        // Beside a sharp edge slivers would be cut off without end.
        if sides.iter().any(|&(from, outward)| outward.dot(centre - from) >= -LEAST_DEPTH) {
            return None;
        }
        let before = (parts.corners.len(), parts.counts.len());
        parts.inside.clear();
        parts.inside.extend_from_slice(&parts.part);
        for (from, outward) in sides {
            let Parts { uncut, inside, outside, .. } = parts;
            std::mem::swap(uncut, inside);
            split(uncut, |point| outward.dot(point - from), inside, outside);
            if outside.len() >= 3 {
                parts.push();
            }
            if parts.inside.len() < 3 {
                break;
            }
        }
        let most = (parts.inside.len() >= 3)
            .then(|| self.farthest_corner(&parts.inside, triangle))
            .filter(|&most| most <= limit);
        if most.is_none() {
            // The pieces are put together again: they would be cut the same way for ever.
            parts.corners.truncate(before.0);
            parts.counts.truncate(before.1);
        }
        most
    }
}

/// Splits a convex polygon where a height is zero.
fn split(
    polygon: &[Vector],
    height: impl Fn(Vector) -> f64,
    below: &mut Vec<Vector>,
    above: &mut Vec<Vector>,
) {
    below.clear();
    above.clear();
    let Some(&last) = polygon.last() else { return };
    let (mut before, mut height_before) = (last, height(last));
    for &corner in polygon {
        let height = height(corner);
        if height < 0.0 && height_before > 0.0 || height > 0.0 && height_before < 0.0 {
            let share = height_before / (height_before - height);
            let crossing = before + (corner - before) * share;
            below.push(crossing);
            above.push(crossing);
        }
        if height <= 0.0 {
            below.push(corner);
        }
        if height >= 0.0 {
            above.push(corner);
        }
        (before, height_before) = (corner, height);
    }
    // What only touches is not a part.
    let is_flat = |polygon: &[Vector]| polygon.iter().all(|&corner| height(corner).abs() == 0.0);
    if is_flat(above) {
        above.clear();
    }
    if is_flat(below) && !above.is_empty() {
        below.clear();
    }
}

/// Halves the part through its centre, across the way to its farthest corner.
fn halve(centre: Vector, parts: &mut Parts) {
    let far = parts.part.iter().fold(Vector::ZERO, |far, &corner| {
        let arm = corner - centre;
        if arm.length_squared() > far.length_squared() { arm } else { far }
    });
    let Parts { part, inside, outside, .. } = parts;
    split(part, |point| far.dot(point - centre), inside, outside);
    parts.push();
    std::mem::swap(&mut parts.inside, &mut parts.outside);
    parts.push();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::{cuboid, uv_sphere};

    const ABOVE: [Vector; 3] =
        [Vector::new(0.1, 0.1, 1.01), Vector::new(0.9, 0.2, 1.01), Vector::new(0.3, 0.8, 1.01)];

    fn farthest(
        mesh: &crate::geometry::TriangleMesh,
        corners: [Vector; 3],
        limit: f64,
    ) -> Option<f64> {
        let tree = Bvh::new(mesh.points(), &mesh.triangles);
        let target = Target::new(tree, mesh.points(), &mesh.triangles);
        target.farthest(corners, NO_GUESS, limit, &mut Parts::default())
    }

    #[test]
    fn a_triangle_above_a_face_is_as_far_away_as_its_height() {
        let cube = cuboid([0.0; 3], [1.0; 3]);
        let found = farthest(&cube, ABOVE, 0.010_001).unwrap();
        assert!((0.01 - 1e-12..=0.010_001).contains(&found), "{found}");
        assert_eq!(farthest(&cube, ABOVE, 0.009_999), None);
    }

    #[test]
    fn a_triangle_in_a_plane_of_many_is_at_no_distance_however_small_the_limit() {
        let cube = cuboid([0.0; 3], [1.0; 3]);
        let within = ABOVE.map(|corner| corner.with_z(1.0));
        assert!(farthest(&cube, within, 1e-9).is_some_and(|most| most < 1e-15));
    }

    #[test]
    fn a_chord_of_a_sphere_is_refuted_by_its_middle() {
        let sphere = uv_sphere(64, [0.0; 3], 1.0);
        let chord = [Vector::X, Vector::Y, Vector::Z];
        // The centre of the chord's triangle is at 0.577 from the sphere's.
        assert_eq!(farthest(&sphere, chord, 0.42), None);
        assert!(farthest(&sphere, chord, 0.43).is_some_and(|most| most >= 0.42));
    }

    #[test]
    fn numbers_that_are_none_are_beyond_any_limit() {
        let cube = cuboid([0.0; 3], [1.0; 3]);
        assert_eq!(farthest(&cube, [Vector::NAN; 3], 1.0), None);
        assert_eq!(farthest(&cube, [Vector::INFINITY; 3], 1.0), None);
    }
}
