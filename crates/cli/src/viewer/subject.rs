//! The mesh that a page is about: repaired, its openings closed, its surface sampled.

use std::collections::HashMap;

use hullwright::measure::{MeasureOptions, MeasuredMesh};
use hullwright::{Control, Error, MeshView, Parameters};
use rayon::prelude::*;

use crate::Vector;

/// Points on the surface, unless its corners alone are more.
const MOST_SAMPLES: usize = 150_000;

pub(super) struct Subject<'a> {
    /// As it came.
    pub source: MeshView<'a>,
    /// The surface with its caps, and the solid.
    pub mesh: MeasuredMesh,
    /// For each triangle of the surface the number of parts that its edges are divided into.
    pub divisions: Vec<u8>,
    /// The points of all triangles, in units.
    pub samples: Vec<Vector>,
    /// How the hulls are made and measured.
    pub parameters: Parameters,
}

impl<'a> Subject<'a> {
    pub(super) fn new(
        source: MeshView<'a>,
        parameters: &Parameters,
        control: &Control,
    ) -> Result<Self, Error> {
        let mesh = MeasuredMesh::new(source, parameters, control)?;
        let surface = &mesh.closed().mesh;
        let corners = corners(&surface.positions, &surface.triangles);
        let divisions = divisions(&corners, mesh.diagonal(), MOST_SAMPLES);
        let samples = points(&corners, &divisions);
        Ok(Self { source, mesh, divisions, samples, parameters: parameters.clone() })
    }

    pub(super) fn options(&self) -> MeasureOptions {
        MeasureOptions::from(&self.parameters)
    }

    /// The bound, as a fraction of the diagonal.
    pub(super) fn bound(&self) -> f64 {
        let diagonal = self.mesh.diagonal();
        self.parameters.max_error.of_diagonal(diagonal) / diagonal
    }

    /// The space of the page.
    pub(super) fn frame(&self) -> Frame {
        Frame { centre: self.mesh.centre().into(), diagonal: self.mesh.diagonal() }
    }

    /// How far a point in units is outside of the solid, as a fraction of the diagonal.
    pub(super) fn distance(&self, point: Vector) -> f64 {
        self.mesh.distance(point.to_array()) / self.mesh.diagonal()
    }
}

/// The space of the page, in the mesh's units.
pub(super) struct Frame {
    pub centre: Vector,
    pub diagonal: f64,
}

impl Frame {
    /// A point as the page has it: relative to the centre, as a fraction of the diagonal.
    pub(super) fn normalized(&self, point: Vector) -> Vector {
        (point - self.centre) * (1.0 / self.diagonal)
    }
}

/// The corners of each triangle, all of which exist.
pub(super) fn corners(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Vec<[Vector; 3]> {
    let corner =
        |&vertex: &u32| Vector::from(positions.get(vertex as usize).copied().unwrap_or_default());
    triangles.iter().map(|[a, b, c]| [corner(a), corner(b), corner(c)]).collect()
}

// The points at which errors are given: each triangle has a regular lattice of them, the finer the
// larger it is. The page divides triangles in the same way, so that only a byte per point is
// stored.

/// Distance of neighbouring points as a fraction of the diagonal, where there is room for as many
/// points as that takes: a protrusion between them is drawn a third too small at worst.
const SPACING: f64 = 1.0 / 64.0;

/// Factor by which the spacing grows until the points are few enough.
const COARSER: f64 = 1.25;

/// The most parts that an edge is divided into: needles would have points without end.
const MOST_PARTS: usize = 32;

/// For each triangle the number of parts that its edges are divided into, with at most `most`
/// points in all, or the corners alone.
pub(super) fn divisions(corners: &[[Vector; 3]], diagonal: f64, most: usize) -> Vec<u8> {
    let mut spacing = SPACING * diagonal;
    loop {
        let parts: Vec<u8> = corners.iter().map(|&corners| parts(corners, spacing)).collect();
        let points: usize = parts.iter().map(|&parts| points_of(parts)).sum();
        if points <= most || parts.iter().all(|&parts| parts == 1) {
            return parts;
        }
        spacing *= COARSER;
    }
}

fn parts([a, b, c]: [Vector; 3], spacing: f64) -> u8 {
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    (longest / spacing).ceil().clamp(1.0, MOST_PARTS as f64) as u8
}

/// Points of a triangle whose edges are divided into so many parts.
pub(super) fn points_of(parts: u8) -> usize {
    let parts = usize::from(parts);
    (parts + 1) * (parts + 2) / 2
}

/// All points, triangle by triangle: along the second edge within along the first. Corners are what
/// they are, without rounding, so that triangles share them.
pub(super) fn points(corners: &[[Vector; 3]], divisions: &[u8]) -> Vec<Vector> {
    let mut points = Vec::new();
    for (&[a, b, c], &parts) in corners.iter().zip(divisions) {
        let (to_b, to_c) = (b - a, c - a);
        let share = |part: u8| f64::from(part) / f64::from(parts);
        for i in 0..=parts {
            let start = a + to_b * share(i);
            points.extend((0..=parts - i).map(|j| match (i == parts, j == parts) {
                (true, _) => b,
                (_, true) => c,
                _ => start + to_c * share(j),
            }));
        }
    }
    points
}

/// Applies a function to each point, once for each place: triangles share corners, and joint
/// hulls have those of their parts.
pub(super) fn map_places(
    points: &[Vector],
    function: impl Fn(Vector) -> f64 + Sync + Send,
) -> Vec<f64> {
    let mut numbers: HashMap<[u64; 3], usize> = HashMap::new();
    let mut places = Vec::new();
    let mut number = |point: &Vector| {
        *numbers.entry(point.to_array().map(f64::to_bits)).or_insert_with(|| {
            places.push(*point);
            places.len() - 1
        })
    };
    let numbers: Vec<usize> = points.iter().map(&mut number).collect();
    let values: Vec<f64> = places.par_iter().map(|&place| function(place)).collect();
    numbers.into_iter().map(|number| values[number]).collect()
}

/// The greatest of some errors, and each error as a byte: the square root of its ratio to the
/// greatest, since small errors need the finest steps.
pub(super) fn bytes(errors: &[f64]) -> (f64, Vec<u8>) {
    let most = errors.iter().copied().fold(0.0, f64::max);
    (most, errors.iter().map(|&error| byte(error, most)).collect())
}

/// One error as a byte.
pub(super) fn byte(error: f64, most: f64) -> u8 {
    if most > 0.0 { (f64::from(u8::MAX) * (error / most).sqrt()).round() as u8 } else { 0 }
}
