//! Where the viewer stands, and how what is seen is fitted into a panel.

use hullwright::UpAxis;

use super::panel::View;
use crate::{Vector, bounds};

/// Share of a panel that stays free on each side.
const MARGIN: f64 = 0.08;

/// The camera looks from a little farther away than the bounding sphere needs, so that no point
/// comes close to it.
const DISTANCE_SLACK: f64 = 1.05;

/// Least and greatest vertical field of view in degrees: less looks like parallel projection,
/// more distorts.
const FIELD_OF_VIEW_RANGE: (f64, f64) = (0.5, 90.0);

/// A camera that looks at a bounding sphere. Its space has x to the right, y up and z towards the
/// viewer; the sphere's radius is 1 and its centre is the origin.
#[derive(Debug, Clone, Copy)]
pub(super) struct Camera {
    right: Vector,
    up: Vector,
    towards_viewer: Vector,
    centre: Vector,
    radius: f64,
    /// From the viewer to the centre; more than 1.
    distance: f64,
}

impl Camera {
    /// A camera that sees all `points`.
    pub(super) fn facing(points: impl Iterator<Item = Vector> + Clone, view: &View) -> Self {
        let (min, max) = bounds(points.clone());
        let (mut centre, mut radius) = (Vector::ZERO, 0.0);
        if min[0] <= max[0] {
            centre = (min + max) * 0.5;
            radius = points.map(|point| point.distance(centre)).fold(0.0, f64::max);
        }
        if radius <= 0.0 {
            radius = 1.0;
        }
        let (azimuth_sine, azimuth_cosine) = view.azimuth.to_radians().sin_cos();
        let (elevation_sine, elevation_cosine) = view.elevation.to_radians().sin_cos();
        let towards_viewer = Vector::new(
            azimuth_sine * elevation_cosine,
            elevation_sine,
            azimuth_cosine * elevation_cosine,
        );
        let right = Vector::new(azimuth_cosine, 0.0, -azimuth_sine);
        let up = towards_viewer.cross(right).normalize_or_zero();
        let upright = |axis| match view.up {
            UpAxis::Y => axis,
            UpAxis::Z => turn_z_up(axis),
        };
        let (least, greatest) = FIELD_OF_VIEW_RANGE;
        let half_angle = 0.5 * view.field_of_view.clamp(least, greatest).to_radians();
        Self {
            right: upright(right),
            up: upright(up),
            towards_viewer: upright(towards_viewer),
            centre,
            radius,
            distance: DISTANCE_SLACK / half_angle.sin(),
        }
    }

    /// A point of the scene in the camera's space.
    pub(super) fn see(&self, point: Vector) -> Vector {
        let point = (point - self.centre) * (1.0 / self.radius);
        Vector::new(point.dot(self.right), point.dot(self.up), point.dot(self.towards_viewer))
    }

    /// Distance from the viewer along the line of sight of a point in the camera's space.
    fn depth(&self, seen: Vector) -> f64 {
        self.distance - seen[2]
    }
}

/// Where an axis of a Y-up view lies in a Z-up scene: a quarter turn about x.
fn turn_z_up(axis: Vector) -> Vector {
    Vector::new(axis[0], -axis[2], axis[1])
}

/// Perspective onto a raster: what is seen is centred and as large as fits.
#[derive(Debug, Clone, Copy)]
pub(super) struct Projection {
    camera: Camera,
    /// Raster units per unit of tangent.
    magnification: f64,
    /// Tangents of what lies in the middle of the raster.
    middle: [f64; 2],
    half_size: [f64; 2],
}

impl Projection {
    /// Fits points in the camera's space into a raster of the given size.
    pub(super) fn fitting(
        camera: Camera,
        seen: impl Iterator<Item = Vector>,
        width: usize,
        height: usize,
    ) -> Self {
        let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for point in seen {
            let depth = camera.depth(point);
            for axis in 0..2 {
                min[axis] = min[axis].min(point[axis] / depth);
                max[axis] = max[axis].max(point[axis] / depth);
            }
        }
        let size = [width as f64, height as f64];
        let (mut middle, mut magnification) = ([0.0; 2], f64::INFINITY);
        for axis in 0..2 {
            if min[axis] <= max[axis] {
                middle[axis] = 0.5 * (min[axis] + max[axis]);
                let extent = max[axis] - min[axis];
                magnification = magnification.min(size[axis] * (1.0 - 2.0 * MARGIN) / extent);
            }
        }
        if !magnification.is_finite() {
            magnification = size[0].min(size[1]) * camera.distance;
        }
        Self { camera, magnification, middle, half_size: [0.5 * size[0], 0.5 * size[1]] }
    }

    /// Raster position (y downwards) of a point in the camera's space, and one over its depth,
    /// which is linear across a projected triangle.
    pub(super) fn project(&self, seen: Vector) -> Vector {
        let inverse_depth = 1.0 / self.camera.depth(seen);
        let x = (seen[0] * inverse_depth - self.middle[0]) * self.magnification;
        let y = (seen[1] * inverse_depth - self.middle[1]) * self.magnification;
        Vector::new(self.half_size[0] + x, self.half_size[1] - y, inverse_depth)
    }

    /// The point in the camera's space that [`project`](Self::project) maps here.
    pub(super) fn unproject(&self, x: f64, y: f64, inverse_depth: f64) -> Vector {
        let depth = 1.0 / inverse_depth;
        Vector::new(
            ((x - self.half_size[0]) / self.magnification + self.middle[0]) * depth,
            ((self.half_size[1] - y) / self.magnification + self.middle[1]) * depth,
            self.camera.distance - depth,
        )
    }

    /// Size on the raster of a unit length at the given depth.
    pub(super) fn raster_length(&self, inverse_depth: f64) -> f64 {
        self.magnification * inverse_depth
    }

    /// Where the viewer stands, in the camera's space.
    pub(super) fn viewer(&self) -> Vector {
        Vector::new(0.0, 0.0, self.camera.distance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corners() -> Vec<Vector> {
        (0..8)
            .map(|corner| Vector::from_array([0, 1, 2].map(|axis| f64::from((corner >> axis) & 1))))
            .collect()
    }

    #[test]
    fn every_point_lands_inside_the_margin() {
        let camera = Camera::facing(corners().into_iter(), &View::default());
        let seen: Vec<Vector> = corners().into_iter().map(|point| camera.see(point)).collect();
        let projection = Projection::fitting(camera, seen.iter().copied(), 200, 100);
        for point in seen {
            let [x, y, _] = projection.project(point).to_array();
            assert!((x / 200.0 - 0.5).abs() <= 0.5 - MARGIN + 1e-9);
            assert!((y / 100.0 - 0.5).abs() <= 0.5 - MARGIN + 1e-9);
        }
    }

    #[test]
    fn unproject_undoes_project() {
        let camera = Camera::facing(corners().into_iter(), &View::default());
        let seen: Vec<Vector> = corners().into_iter().map(|point| camera.see(point)).collect();
        let projection = Projection::fitting(camera, seen.iter().copied(), 200, 100);
        for point in seen {
            let [x, y, inverse_depth] = projection.project(point).to_array();
            assert!(projection.unproject(x, y, inverse_depth).distance(point) < 1e-12);
        }
    }

    #[test]
    fn up_is_up_for_both_conventions() {
        for (up, axis) in [(UpAxis::Y, Vector::Y), (UpAxis::Z, Vector::Z)] {
            let view = View { up, ..View::default() };
            let camera = Camera::facing([Vector::ZERO, axis].into_iter(), &view);
            let (foot, tip) = (camera.see(Vector::ZERO), camera.see(axis));
            assert!(tip[1] > foot[1] && (tip[0] - foot[0]).abs() < 1e-12);
        }
    }
}
