//! Triangles to samples: a z-buffer that remembers which triangle is seen.

use std::ops::Range;

use super::camera::Projection;
use crate::Vector;

/// The triangle of a sample that shows only background.
pub(super) const NOTHING: u32 = u32::MAX;

/// A surface must be nearer by this fraction of its depth to hide one that was drawn before: hulls
/// often share a plane, and rounding must not make them flicker.
const TIE: f64 = 1e-5;

/// Triangles reach this many samples farther left and right than they are, so that rounding leaves
/// no crack between neighbours.
const OVERHANG: f64 = 1e-6;

/// Twice the least area, in squared samples, of a triangle that is drawn: below it is a line.
const LEAST_AREA: f64 = 1e-9;

/// A triangle in the camera's space.
#[derive(Debug, Clone, Copy)]
pub(super) struct SeenTriangle {
    pub corners: [Vector; 3],
    /// Unit normal, turned to the viewer.
    pub normal: Vector,
    /// Index of its part.
    pub part: u32,
}

impl SeenTriangle {
    pub(super) fn new(corners: [Vector; 3], part: u32, viewer: Vector) -> Self {
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let faces_away = normal.dot(viewer - a) < 0.0;
        Self { corners, normal: normal * (if faces_away { -1.0 } else { 1.0 }), part }
    }
}

/// What each sample of a raster sees.
#[derive(Debug)]
pub(super) struct Samples {
    pub width: usize,
    pub height: usize,
    /// One over the depth, 0 where nothing is seen; row by row from the top.
    pub inverse_depth: Vec<f32>,
    /// The triangle that is seen, or [`NOTHING`].
    pub triangle: Vec<u32>,
}

/// Draws all triangles. O(triangles + covered samples).
pub(super) fn rasterize(
    triangles: &[SeenTriangle],
    projection: &Projection,
    width: usize,
    height: usize,
) -> Samples {
    let mut samples = Samples {
        width,
        height,
        inverse_depth: vec![0.0; width * height],
        triangle: vec![NOTHING; width * height],
    };
    for (index, triangle) in (0..NOTHING).zip(triangles) {
        let corners = triangle.corners.map(|corner| projection.project(corner));
        draw(&mut samples, index, corners);
    }
    samples
}

/// The samples, whose centres lie at half numbers, between two coordinates.
fn sample_range(least: f64, greatest: f64, count: usize) -> Range<usize> {
    let start = (least - 0.5).ceil().max(0.0) as usize;
    let end = ((greatest - 0.5).floor() + 1.0).clamp(0.0, count as f64) as usize;
    start..end
}

/// A value that is linear across the raster.
#[derive(Clone, Copy)]
struct Linear {
    constant: f64,
    per_column: f64,
    per_row: f64,
}

impl Linear {
    /// Positive to the left of the way from a to b where y points down and `area` is positive;
    /// 1 at the third corner.
    fn edge(a: Vector, b: Vector, area: f64) -> Self {
        let (per_column, per_row) = ((a[1] - b[1]) / area, (b[0] - a[0]) / area);
        Self { constant: -(per_column * a[0] + per_row * a[1]), per_column, per_row }
    }

    fn at_row(&self, y: f64) -> f64 {
        self.constant + self.per_row * y
    }
}

fn draw(samples: &mut Samples, index: u32, corners: [Vector; 3]) {
    let [a, b, c] = corners;
    let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    // Also where a coordinate is not a number.
    if !area.is_finite() || area.abs() < LEAST_AREA {
        return;
    }
    let least = a.min(b).min(c);
    let greatest = a.max(b).max(c);
    let weights = [Linear::edge(b, c, area), Linear::edge(c, a, area), Linear::edge(a, b, area)];
    let depth_slope: f64 =
        (0..3).map(|corner| weights[corner].per_column * corners[corner][2]).sum();
    for row in sample_range(least[1], greatest[1], samples.height) {
        let y = row as f64 + 0.5;
        let (mut left, mut right) = (least[0], greatest[0]);
        for weight in weights {
            let crossing = -weight.at_row(y) / weight.per_column;
            if weight.per_column > 0.0 {
                left = left.max(crossing - OVERHANG);
            } else if weight.per_column < 0.0 {
                right = right.min(crossing + OVERHANG);
            }
        }
        let columns = sample_range(left, right, samples.width);
        if columns.is_empty() {
            continue;
        }
        let depth_at_start: f64 =
            (0..3).map(|corner| weights[corner].at_row(y) * corners[corner][2]).sum();
        let line = row * samples.width + columns.start..row * samples.width + columns.end;
        let depths = &mut samples.inverse_depth[line.clone()];
        let seen = &mut samples.triangle[line];
        for ((column, depth), seen) in columns.zip(depths).zip(seen) {
            let inverse_depth = depth_at_start + depth_slope * (column as f64 + 0.5);
            // A needle's slope is so steep that the overhang would leave its depths.
            let inverse_depth = inverse_depth.max(least[2]).min(greatest[2]);
            if inverse_depth > f64::from(*depth) * (1.0 + TIE) {
                *depth = inverse_depth as f32;
                *seen = index;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::View;
    use super::super::camera::Camera;
    use super::*;

    /// A camera straight in front of the square from -1 to 1 at z = 0.
    fn front(width: usize, height: usize) -> Projection {
        let square = [[-1.0, -1.0, 0.0], [1.0, 1.0, 0.0]].map(Vector::from);
        let view = View { azimuth: 0.0, elevation: 0.0, ..View::default() };
        let camera = Camera::facing(square.into_iter(), &view);
        let seen = square.map(|point| camera.see(point));
        Projection::fitting(camera, seen.into_iter(), width, height)
    }

    fn square_at(z: f64, half: f64) -> [SeenTriangle; 2] {
        let corners = [[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]]
            .map(Vector::from);
        let triangle = |a: usize, b: usize, c: usize| {
            SeenTriangle::new([corners[a], corners[b], corners[c]], 0, Vector::new(0.0, 0.0, 9.0))
        };
        [triangle(0, 1, 2), triangle(0, 2, 3)]
    }

    #[test]
    fn two_triangles_of_a_square_leave_no_crack() {
        let samples = rasterize(&square_at(0.0, 0.5), &front(64, 64), 64, 64);
        let covered: Vec<usize> = (0..64)
            .map(|row| {
                let line = &samples.triangle[row * 64..(row + 1) * 64];
                line.iter().filter(|seen| **seen != NOTHING).count()
            })
            .filter(|count| *count > 0)
            .collect();
        assert!(covered.len() > 20);
        assert!(covered.iter().all(|count| *count == covered.len()));
    }

    #[test]
    fn the_nearer_surface_wins_in_either_order() {
        let [near, far] = [square_at(0.3, 0.5), square_at(-0.3, 0.5)];
        let middle = 20 * 40 + 19;
        let first = rasterize(&[near, far].concat(), &front(40, 40), 40, 40);
        assert!(first.triangle[middle] < 2);
        let second = rasterize(&[far, near].concat(), &front(40, 40), 40, 40);
        assert!((2..4).contains(&second.triangle[middle]));
    }

    #[test]
    fn of_two_surfaces_in_one_plane_the_first_is_seen_everywhere() {
        let square = square_at(0.0, 0.5);
        let turned = [
            SeenTriangle::new(
                [square[0].corners[0], square[0].corners[1], square[1].corners[2]],
                1,
                Vector::new(0.0, 0.0, 9.0),
            ),
            SeenTriangle::new(
                [square[0].corners[1], square[0].corners[2], square[1].corners[2]],
                1,
                Vector::new(0.0, 0.0, 9.0),
            ),
        ];
        let samples = rasterize(&[square, turned].concat(), &front(64, 64), 64, 64);
        assert!(samples.triangle.iter().all(|seen| *seen < 2 || *seen == NOTHING));
    }

    #[test]
    fn degenerate_and_far_away_triangles_do_no_harm() {
        let far = 1e60;
        let triangles = [
            SeenTriangle::new([Vector::ZERO; 3], 0, Vector::new(0.0, 0.0, 9.0)),
            SeenTriangle::new([Vector::NAN; 3], 0, Vector::new(0.0, 0.0, 9.0)),
            SeenTriangle::new(
                [Vector::new(far, far, 0.0), Vector::new(-far, far, 0.0), Vector::splat(2.0 * far)],
                0,
                Vector::ZERO,
            ),
        ];
        let samples = rasterize(&triangles, &front(16, 16), 16, 16);
        assert_eq!(samples.triangle.len(), 256);
    }
}
