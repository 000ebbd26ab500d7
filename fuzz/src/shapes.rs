//! Triangles through the whole pipeline, and points into hulls.

use arbitrary::{Result, Unstructured};
use hullwright::hull::{DEFAULT_TOLERANCE, HullBuilder, Shape};
use hullwright::measure::{MeasureOptions, measure};
use hullwright::openings::close_openings;
use hullwright::surface::SurfaceParameters;
use hullwright::{
    Control, Error, Length, MeshView, Method, Openings, Parameters, Preset, convex_hull,
    mass_properties,
};

use super::independent::exact::{Faults, faults};
use super::independent::sampling::sample;
use super::points::points;

/// Small enough that thousands are decomposed in a second.
const MOST_VERTICES: usize = 40;
const MOST_TRIANGLES: usize = 80;
const MOST_POINTS: usize = 80;

/// Rounding of what was verified, in diagonals: that of the points, which are in single precision.
const ROUNDING: f64 = 1e-6;

/// A mesh of any triangles, decomposed: hulls are convex bodies, and the bound is kept.
pub fn soup(bytes: &[u8]) {
    hulls_of_soup(bytes);
}

/// The same, and how many hulls there are: none where nothing is to be decomposed.
pub fn hulls_of_soup(bytes: &[u8]) -> usize {
    // Where the bytes end, numbers are 0: there always is a mesh.
    try_soup(&mut Unstructured::new(bytes)).unwrap_or(0)
}

fn try_soup(bytes: &mut Unstructured<'_>) -> Result<usize> {
    let method = method(bytes)?;
    let count = bytes.int_in_range(1..=MOST_TRIANGLES)?;
    let vertices = bytes.int_in_range(3..=MOST_VERTICES as u32)?;
    let mut triangles = Vec::new();
    for _ in 0..count {
        let corners = bytes.arbitrary::<[u8; 3]>()?;
        triangles.push(corners.map(|corner| u32::from(corner) % vertices));
    }
    let positions = points(bytes, MOST_VERTICES)?;
    let mesh = MeshView::new(&positions, &triangles);
    let control = Control::new().with_parallel(false);
    let parameters = method.solid();
    let found = match method.decompose(mesh, &control) {
        Ok(found) => found,
        Err(
            Error::EmptyMesh { .. } | Error::IndexOutOfRange { .. } | Error::NothingUsable { .. },
        ) => {
            return Ok(0);
        }
        Err(error) => panic!("an unexpected error: {error}"),
    };
    assert!(!found.hulls.is_empty());
    for hull in &found.hulls {
        let most = parameters.max_vertices.unwrap_or(usize::MAX);
        assert!(hull.shape.points.len() <= most);
        // What is beyond single precision has no such form, and says so.
        let Ok((points, triangles)) = hull.shape.to_single_precision() else { continue };
        assert_eq!(faults(&points, &triangles), Faults::default());
    }
    if let Some(bounded) = found.report.bounded() {
        let rounding = ROUNDING * found.run.diagonal;
        let closed = close_openings(mesh, &parameters, &control).expect("it was done");
        let sampled = sample(&found, &closed.mesh, &closed.solid, 50);
        let uncovered = sampled.uncovered * found.run.diagonal;
        assert!(uncovered <= bounded.uncovered_max + rounding, "{sampled:?} {bounded:?}");
        assert!(sampled.beyond_verified <= ROUNDING, "{sampled:?} {bounded:?}");
        if parameters.max_hulls.is_none() {
            assert!(bounded.protrusion_max <= bounded.bound + rounding, "{bounded:?}");
            assert!(bounded.uncovered_max <= bounded.bound + rounding, "{bounded:?}");
        }
    }
    let mut options = MeasureOptions::default();
    (options.hull_samples, options.mesh_samples, options.volume_samples) = (50, 50, 50);
    measure(mesh, &found.hulls, &options, &control).expect("hulls of our own can be measured");
    let _ = mass_properties(mesh, &found.hulls, 1.0);
    Ok(found.hulls.len())
}

fn method(bytes: &mut Unstructured<'_>) -> Result<Method> {
    let is_paper = bytes.ratio(1, 16)?;
    let mut parameters = Parameters::default()
        .with_preset(*bytes.choose(&[Preset::Balanced, Preset::Fast, Preset::Fine])?)
        .with_max_error(Length::Share(*bytes.choose(&[0.02, 0.01, 0.05, 0.2])?))
        .with_openings(*bytes.choose(&[Openings::Auto, Openings::Keep, Openings::Close])?)
        .with_keep_cavities(bytes.ratio(1, 4)?);
    if bytes.ratio(1, 4)? {
        parameters.max_hulls = Some(bytes.int_in_range(1..=4)?);
    }
    let mut surface = SurfaceParameters::paper();
    if bytes.ratio(1, 4)? {
        parameters.max_vertices = Some(bytes.int_in_range(8..=32)?);
        surface.max_vertices = parameters.max_vertices;
    }
    if !is_paper {
        return Ok(parameters.into());
    }
    if bytes.ratio(1, 2)? {
        surface.concavity_threshold = Some(0.05);
    }
    Ok(surface.into())
}

/// Points into a hull at once, and in steps: both are exact hulls of their vertices, and hold all
/// points.
pub fn hull(bytes: &[u8]) {
    let _ = try_hull(&mut Unstructured::new(bytes));
}

fn try_hull(bytes: &mut Unstructured<'_>) -> Result<()> {
    let tolerance =
        *bytes.choose(&[DEFAULT_TOLERANCE, DEFAULT_TOLERANCE, 1e-3, 1e-10, 1e-14, 0.0])?;
    let step = bytes.int_in_range(1..=8)?;
    let first = bytes.int_in_range(4..=20)?;
    let points = points(bytes, MOST_POINTS)?;
    if let Ok(hull) = convex_hull(&points) {
        assert_eq!(faults(&hull.points, &hull.triangles), Faults::default());
        assert!(hull.points.iter().all(|vertex| points.contains(vertex)));
        if let Ok((points, triangles)) = hull.to_single_precision() {
            assert_eq!(faults(&points, &triangles), Faults::default());
        }
    }
    let first = first.min(points.len());
    let mut builder = HullBuilder::new().with_tolerance(tolerance);
    if builder.build(&points[..first]) != Shape::Solid {
        return Ok(());
    }
    for chunk in points[first..].chunks(step) {
        builder.insert(chunk);
    }
    let (vertices, triangles) = builder.extract();
    assert_eq!(faults(&vertices, &triangles), Faults::default());
    Ok(())
}
