//! Runs, and what they promise: judged by means of the tests' own.

use hullwright::measure::{MeasureOptions, Measurement, measure};
use hullwright::{Control, Decomposition, Hull, Length, MeshView, Parameters, Report, decompose};

use crate::common::Mesh;

pub fn run_with((positions, triangles): &Mesh, parameters: &Parameters) -> Decomposition {
    decompose(MeshView::new(positions, triangles), parameters, &Control::new()).unwrap()
}

pub fn run(mesh: &Mesh) -> Decomposition {
    run_with(mesh, &Parameters::default())
}

/// The default parameters with another bound, in diagonals.
pub fn with_bound(bound: f64) -> Parameters {
    let mut parameters = Parameters::default();
    parameters.max_error = Length::Share(bound);
    parameters
}

pub fn report(result: &Decomposition) -> &Report {
    &result.report
}

/// The hulls against dense samples of mesh and hulls.
pub fn judge((positions, triangles): &Mesh, hulls: &[Hull]) -> Measurement {
    let shapes: Vec<MeshView<'_>> = hulls.iter().map(MeshView::from).collect();
    let mut options = MeasureOptions::default();
    options.volume_samples = 50_000;
    measure(MeshView::new(positions, triangles), &shapes, &options, &hullwright::Control::new())
        .unwrap()
}

/// The promise: verified errors are within the bound, dense samples within the verified errors, and
/// hulls are convex and have volume.
pub fn assert_promise(name: &str, mesh: &Mesh, result: &Decomposition) {
    let report = report(result);
    let measured = judge(mesh, &result.hulls);
    let diagonal = measured.diagonal;
    let rounding = 1e-6 * diagonal;
    assert!(report.protrusion_max <= report.bound + rounding, "{name}: {report:?}");
    assert!(report.uncovered_max <= report.bound + rounding, "{name}: {report:?}");
    let (protrusion, uncovered) =
        (measured.protrusion.max * diagonal, measured.uncovered.max * diagonal);
    assert!(protrusion <= report.protrusion_max + rounding, "{name}: {protrusion} {report:?}");
    assert!(uncovered <= report.uncovered_max + rounding, "{name}: {uncovered} {report:?}");
    assert_eq!(measured.non_convex_hulls, 0, "{name}");
    assert_eq!(measured.non_positive_volumes, 0, "{name}");
}

/// Whether a point is in a hull.
pub fn contains(hull: &Hull, [x, y, z]: [f64; 3]) -> bool {
    hull.shape.triangles.iter().all(|triangle| {
        let [a, b, c] = triangle.map(|index| hull.shape.points[index as usize]);
        let [u, v] =
            [[b[0] - a[0], b[1] - a[1], b[2] - a[2]], [c[0] - a[0], c[1] - a[1], c[2] - a[2]]];
        let normal =
            [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        normal[0] * (x - a[0]) + normal[1] * (y - a[1]) + normal[2] * (z - a[2]) <= 0.0
    })
}

/// A triangle with three different corners that no hull represents.
pub fn lost((positions, triangles): &Mesh, result: &Decomposition) -> Option<usize> {
    let mut is_represented = vec![false; triangles.len()];
    for &triangle in result.hulls.iter().flat_map(|hull| &hull.provenance.source_triangles) {
        is_represented[triangle as usize] = true;
    }
    let has_area = |triangle: usize| {
        let [a, b, c] = triangles[triangle].map(|vertex| positions[vertex as usize]);
        a != b && b != c && c != a
    };
    (0..triangles.len()).find(|&triangle| !is_represented[triangle] && has_area(triangle))
}
