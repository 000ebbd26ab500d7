//! The fit test against dense samples of faces, on closed and open solids, dense and coarse.

use super::*;
use crate::bounded::containment::boundary::Boundary;
use crate::bounded::containment::inside::{OPEN_INSIDE, winding_number};
use crate::bounded::settings::Settings;
use crate::control::Control;
use crate::geometry::TriangleMesh;
use crate::geometry::vector::{add, scale};
use crate::mesh::canonical_order::MeshOrder;
use crate::mesh::repair::prepare;
use crate::mesh::shapes::{cuboid, hemisphere, join, torus};
use crate::parameters::{Length, Parameters};

/// Samples along each side of a face.
const SAMPLES: usize = 16;

/// Winding numbers of open surfaces are expansions, and a grid's sides are those of its cells.
const DOUBTFUL: f64 = 0.05;

/// A solid, and the vertices of its surface.
struct Case {
    name: &'static str,
    solid: Solid,
    corners: Vec<Vector>,
}

impl Case {
    /// With a grid that is filled in advance.
    fn dense(name: &'static str, mesh: &TriangleMesh, bound: f64) -> Self {
        let TriangleMesh { positions, triangles, .. } = mesh;
        let boundary = Boundary::new(positions, triangles);
        let solid =
            Solid::of_surface(positions, triangles, boundary, bound, &Control::new()).unwrap();
        assert!(!solid.is_coarse());
        Self { name, solid, corners: positions.clone() }
    }

    /// With a grid that is filled where it is asked.
    fn coarse(name: &'static str, mesh: &TriangleMesh, bound: f64) -> Self {
        let control = Control::new();
        let prepared = prepare(mesh.view(), MeshOrder::Place, &control).unwrap();
        let parameters = Parameters::default().max_error(Length::share(bound));
        let settings = Settings::of_preset(&parameters, 1.0).swap_remove(0);
        let solid = Solid::new(&prepared, None, &settings, &control).unwrap();
        assert!(solid.is_coarse());
        Self { name, solid, corners: prepared.mesh.positions }
    }

    fn all(bound: f64) -> [Self; 4] {
        let beam = cuboid([0.3, -0.3, -0.2], [2.0, 0.4, 0.1]);
        let closed = join(&[torus(24, 12), beam.clone()]);
        let open = join(&[hemisphere(10), beam]);
        let cases = [
            Self::dense("dense, closed", &closed, bound),
            Self::coarse("coarse, closed", &closed, bound),
            Self::dense("dense, open", &open, bound),
            Self::coarse("coarse, open", &open, bound),
        ];
        assert_eq!(cases.each_ref().map(|case| case.solid.is_closed()), [true, true, false, false]);
        cases
    }

    /// Without the grid, how far a point is from the surface if the winding number is below a limit there, else 0.
    fn outside(&self, point: Vector, limit: f64) -> f64 {
        let Solid { bvh, boundary, .. } = &self.solid;
        match bvh.closest_point(point, f64::INFINITY) {
            Some(closest) if winding_number(bvh, boundary, point) < limit => closest.distance,
            _ => 0.0,
        }
    }

    /// The greatest of these over a face, where it is outside for certain.
    fn sampled(&self, [a, b, c]: [Vector; 3]) -> f64 {
        let share = |index: usize| index as f64 / SAMPLES as f64;
        let weights = (0..=SAMPLES).flat_map(|i| (0..=SAMPLES - i).map(move |j| (i, j)));
        let points = weights.map(|(i, j)| {
            let rest = share(SAMPLES - i - j);
            add(add(scale(a, share(i)), scale(b, share(j))), scale(c, rest))
        });
        points.map(|point| self.outside(point, OPEN_INSIDE - DOUBTFUL)).fold(0.0, f64::max)
    }

    /// Faces between points of the surface, near ones and far ones.
    fn faces(&self) -> impl Iterator<Item = [Vector; 3]> + '_ {
        let count = self.corners.len();
        (0..300).map(move |number| {
            let reach = if number % 3 == 0 { count } else { 30 };
            let second = number + 1 + number * number % reach;
            let third = number + 2 + 7 * number * number % reach;
            [number, second, third].map(|index| self.corners[index % count])
        })
    }
}

#[test]
fn what_does_not_fit_protrudes_where_it_is_said_to_and_what_fits_hardly_anywhere() {
    for bound in [0.01, 0.03, 0.1] {
        for case in Case::all(bound) {
            let mut scratch = FitScratch::default();
            let (mut fitting, mut overlooked, mut refused, mut wrongly) = (0, 0, 0, 0);
            for face in case.faces() {
                let Some(point) = case.solid.protruding_point(face, None, bound, &mut scratch)
                else {
                    fitting += 1;
                    let sampled = case.sampled(face);
                    assert!(sampled < 2.0 * bound, "{}, {bound}: {sampled}", case.name);
                    overlooked += usize::from(sampled > 1.1 * bound);
                    continue;
                };
                refused += 1;
                let outside = case.outside(point, OPEN_INSIDE + DOUBTFUL);
                wrongly += usize::from(outside <= bound * (1.0 - 1e-6));
            }
            assert!(fitting > 50 && refused > 3, "{}: {fitting}, {refused}", case.name);
            // The side of a cell of a filled grid is that of its centre; where a surface ends, it changes
            // within the cell.
            let is_exact = case.solid.is_closed() || case.solid.is_coarse();
            let most = if is_exact { 0 } else { refused / 20 };
            assert!(wrongly <= most, "{}, {bound}: {wrongly} of {refused}", case.name);
            assert!(overlooked * 50 <= fitting, "{}: {overlooked} of {fitting}", case.name);
        }
    }
}

#[test]
fn points_fit_as_far_as_the_bound_from_the_solid_and_no_farther() {
    for bound in [0.01, 0.1] {
        for case in Case::all(bound) {
            for (face, share) in
                case.faces().zip([0.0, 0.5, 0.95, 1.05, 1.4, 3.0].into_iter().cycle())
            {
                let [a, b, c] = face;
                let away = subtract(a, scale(add(b, c), 0.5));
                let size = length_squared(away).sqrt().max(1e-12);
                let point = add(a, scale(away, share * bound / size));
                let fits = case.solid.point_fits(point, bound);
                let for_certain = case.outside(point, OPEN_INSIDE - DOUBTFUL);
                let perhaps = case.outside(point, OPEN_INSIDE + DOUBTFUL);
                assert!(!fits || for_certain <= bound * 1.001, "{} {for_certain}", case.name);
                assert!(fits || perhaps >= bound * 0.999, "{} {perhaps}", case.name);
            }
        }
    }
}
