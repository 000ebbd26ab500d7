//! The mesh that a page is about: repaired, its openings closed, its surface sampled.

use crate::bvh::Bvh;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::MeshView;
use crate::geometry::vector::Vector;
use crate::measure::MeasureOptions;
use crate::mesh::{Normalization, TriangleMesh};
use crate::openings::closed_mesh::caps_last;
use crate::openings::prepare::prepare_closed;
use crate::openings::{Opening, OpeningSettings};
use crate::parameters::Parameters;

use super::samples;

/// Points on the surface, unless its corners alone are more.
const MOST_SAMPLES: usize = 150_000;

/// In normalised coordinates: centred, with a diagonal of 1.
pub(super) struct Subject<'a> {
    /// As it came.
    pub source: MeshView<'a>,
    pub normalization: Normalization,
    /// The repaired surface, then the caps.
    pub surface: TriangleMesh,
    /// How many of the triangles, the last ones, are caps.
    pub caps: usize,
    /// For each triangle the number of parts that its edges are divided into.
    pub divisions: Vec<u8>,
    /// The points of all triangles.
    pub samples: Vec<Vector>,
    pub openings: Vec<Opening>,
    /// How hulls are measured.
    pub options: MeasureOptions,
    /// The bound, in diagonals.
    pub bound: f64,
    /// The solid.
    bvh: Bvh,
}

/// A point nearer to the surface than this, in diagonals, is on it: rounding of hulls to `f32`.
const ON_SURFACE: f64 = 1e-6;

impl<'a> Subject<'a> {
    pub(super) fn new(
        source: MeshView<'a>,
        parameters: &Parameters,
        control: &Control,
    ) -> Result<Self, Error> {
        let settings = OpeningSettings::from(parameters);
        let closed = prepare_closed(source, &settings, control)?;
        let (prepared, normalization) = (&closed.prepared, closed.prepared.normalization);
        let (triangles, caps) = caps_last(prepared);
        let surface = TriangleMesh::new(prepared.mesh.positions.clone(), triangles);
        let corners = corners(&surface);
        let divisions = samples::divisions(&corners, MOST_SAMPLES);
        let bound = parameters.max_error;
        let options = MeasureOptions {
            openings: settings.openings,
            flatness: bound,
            up_axis: settings.up_axis,
            keep_cavities: settings.keep_cavities,
            ..MeasureOptions::default()
        };
        let solid = prepared.triangles_of_solid();
        Ok(Self {
            source,
            normalization,
            caps,
            samples: samples::points(&corners, &divisions),
            divisions,
            bvh: Bvh::with_control(&surface.positions, &solid, control)?,
            surface,
            options,
            bound: bound.of_diagonal(normalization.diagonal) / normalization.diagonal,
            openings: closed.openings,
        })
    }

    /// Whether a point is in the solid.
    pub(super) fn contains(&self, point: Vector) -> bool {
        self.bvh.is_inside(point)
    }

    /// How far a point is outside of the solid.
    pub(super) fn distance(&self, point: Vector) -> f64 {
        let distance =
            self.bvh.closest_point(point, f64::INFINITY).map_or(0.0, |closest| closest.distance);
        if distance <= ON_SURFACE || self.contains(point) { 0.0 } else { distance }
    }
}

/// The corners of each triangle, all of which exist.
pub(super) fn corners(mesh: &TriangleMesh) -> Vec<[Vector; 3]> {
    let corner = |&vertex: &u32| mesh.positions.get(vertex as usize).copied().unwrap_or_default();
    mesh.triangles.iter().map(|[a, b, c]| [corner(a), corner(b), corner(c)]).collect()
}
