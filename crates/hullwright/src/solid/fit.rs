//! The fit test of the search: whether no point of a hull's surface is farther than the bound from
//! the solid.
//!
//! One query at the centre of a part whose corners are at most r from it decides it if the distance
//! d there is far enough from the bound ε: d + r ≤ ε accepts; outside the solid d > ε rejects;
//! inside it r - d ≤ ε accepts, since a path out of the solid crosses the surface. Otherwise the
//! part is halved.
//!
//! The test is lenient: verification decides the result. A hull's faces are tested by their
//! centres, largest first, then completely.

use super::grid::Location;
use super::solid::Solid;
use super::subdivide::{Face, Part, Policy, Scratch, Verdict, subdivide};
use super::surface::Side;
use crate::geometry::vector::{Vector, area_normal, as_arrays, centre};
use crate::hull::growing_hull::GrowingHull;
use crate::hull::{HullBuilder, LEAST_THICKNESS, solid_hull};
use crate::work;

/// A part of a smaller radius, as a fraction of the bound, is decided by its centre.
const SMALL: f64 = 0.35;

/// Where the surface is flat, the distance along its normal is exact. The tree decides only where
/// that exceeds the bound by this factor, which covers surfaces that are slightly curved.
const CERTAIN: f64 = 1.03;

/// A part counts as smaller by this factor: a notch narrower than the rest is found by
/// verification.
const LENIENCE: f64 = 0.4;

/// A part of a larger radius, as a multiple of the bound, is compared with the closest triangle as
/// a whole: it may lie along it, and halving it down to the bound would be slow.
const LONG: f64 = 3.0;

/// Faces that say why a hull is refused.
const MAX_REFUSALS: usize = 6;

/// The rules of the search.
struct Lenient<'a> {
    solid: &'a Solid,
    bound: f64,
    /// Where the face protrudes.
    protruding: Option<Vector>,
}

impl Lenient<'_> {
    fn protrudes(&mut self, point: Vector) -> Verdict {
        self.protruding = Some(point);
        Verdict::Stop
    }

    /// Judges a part whose centre is too far from the surface.
    fn judge_by_probe(&mut self, part: &Part) -> Verdict {
        let &mut Self { solid, bound, .. } = self;
        let centre = part.centre;
        if solid.probe_allows_all(|| part.extent(LENIENCE), bound) {
            return Verdict::Settled;
        }
        if !solid.probe_allows(centre, bound) {
            return self.protrudes(centre);
        }
        if part.radius <= SMALL * bound { Verdict::Settled } else { Verdict::Open }
    }

    /// Judges a part whose centre may be farther than the bound from the surface; `None` if that is
    /// left open.
    #[inline]
    fn judge_beyond(&mut self, part: &Part, at: &Location<'_>, reach: f64) -> Option<Verdict> {
        let &mut Self { solid, bound, .. } = self;
        let centre = part.centre;
        match at.side() {
            Some(Side::Inside) => {}
            Some(Side::Outside) if at.lower > bound => {
                return Some(self.judge_by_probe(part));
            }
            Some(Side::Outside) => {
                let distance = solid.tree().distance_to_triangle(centre, at.triangle());
                if distance + reach <= bound {
                    return Some(Verdict::Settled);
                }
                if distance > bound
                    && at.distance_to_tangent() > CERTAIN * bound
                    && !solid.tree().is_within(centre, bound)
                {
                    return Some(self.judge_by_probe(part));
                }
            }
            // The grid is too coarse for the bound.
            None => match solid.tree().closest_point(centre, f64::INFINITY) {
                Some(closest) if closest.distance <= bound => {
                    if closest.distance + reach <= bound
                        || solid.grid.upper_to_triangle(part.corners, closest.triangle) <= bound
                    {
                        return Some(Verdict::Settled);
                    }
                }
                Some(closest) if solid.side(centre) == Side::Inside => {
                    if solid.is_closed() && reach - closest.distance <= bound {
                        return Some(Verdict::Settled);
                    }
                }
                _ => return Some(self.judge_by_probe(part)),
            },
        }
        None
    }
}

impl Policy for Lenient<'_> {
    #[inline]
    fn judge(&mut self, part: &Part) -> Verdict {
        work::count(work::PART);
        let &mut Self { solid, bound, .. } = self;
        let radius = part.radius;
        let reach = LENIENCE * radius;
        let at = solid.locate(part.centre);
        if at.upper + reach <= bound
            || radius > LONG * bound && at.upper_of_face(part.corners, bound) <= bound
        {
            return Verdict::Settled;
        }
        if at.upper > bound
            && let Some(verdict) = self.judge_beyond(part, &at, reach)
        {
            return verdict;
        }
        let is_inside = || {
            // In an open surface, large faces could hide where the inside ends.
            at.lower > 0.0
                && (solid.is_closed() || radius <= bound)
                && reach - at.lower <= bound
                && at.side() == Some(Side::Inside)
        };
        let is_ball_inside = || {
            let is_coarse_and_open = solid.is_coarse() && !solid.is_closed();
            is_coarse_and_open && at.depth().is_some_and(|depth| reach - depth <= bound)
        };
        if radius <= SMALL * bound || is_ball_inside() || is_inside() {
            Verdict::Settled
        } else {
            Verdict::Open
        }
    }

    fn near(&self) -> f64 {
        self.bound
    }

    fn judge_outside(&mut self, centre: Vector) -> Verdict {
        let solid = self.solid;
        if solid.tree().is_within(centre, self.bound) || solid.probe_allows(centre, self.bound) {
            Verdict::Open
        } else {
            self.protrudes(centre)
        }
    }
}

impl Solid {
    /// Whether the centre of a face is in the solid or at most `bound` away from it.
    pub(super) fn centre_fits(&self, face: Face, bound: f64) -> bool {
        self.point_fits(centre(face), bound)
    }

    /// Whether no point of a face is farther than `bound` from the solid, leniently.
    pub fn face_fits(&self, face: Face, bound: f64, scratch: &mut Scratch) -> bool {
        self.centre_fits(face, bound) && self.protruding_point(face, bound, scratch).is_none()
    }

    /// A point of the face that is farther than `bound` from the solid; `None` if there is none.
    fn protruding_point(&self, face: Face, bound: f64, scratch: &mut Scratch) -> Option<Vector> {
        let mut policy = Lenient { solid: self, bound, protruding: None };
        subdivide(self, std::iter::once(face), &mut policy, scratch);
        policy.protruding
    }
}

/// Why a hull is refused.
#[derive(Debug, Clone)]
pub(crate) struct Refusal {
    /// A face of the hull.
    pub face: Face,
    /// A point of the face that is outside the solid by more than the bound.
    pub point: Vector,
}

/// Tests hulls against a solid under a bound. Keeps scratch buffers between tests.
pub(crate) struct FitTester<'a> {
    solid: &'a Solid,
    bound: f64,
    /// A copy of the hull that is to grow.
    trial: GrowingHull,
    thickener: HullBuilder,
    /// Faces to be tested, each with its squared area, times four.
    faces: Vec<(f64, Face)>,
    scratch: Scratch,
    points: Vec<Vector>,
    refusals: Vec<Refusal>,
    /// Joint hulls that [`try_insert`](Self::try_insert) has tested.
    pub attempts: usize,
}

impl<'a> FitTester<'a> {
    pub fn new(solid: &'a Solid, bound: f64) -> Self {
        Self {
            solid,
            bound,
            trial: GrowingHull::new(&[], Vector::ZERO),
            thickener: HullBuilder::new(),
            faces: Vec::new(),
            scratch: Scratch::default(),
            points: Vec::new(),
            refusals: Vec::new(),
            attempts: 0,
        }
    }

    /// Whether a hull's surface is nowhere farther than the bound from the solid. Only the faces of
    /// the last insertion are tested if `only_new`.
    pub fn fits(&mut self, hull: &GrowingHull, only_new: bool) -> bool {
        let mut faces = std::mem::take(&mut self.faces);
        faces.clear();
        let mut collect = |face: Face| {
            let [a, b, c] = face;
            faces.push((area_normal(a, b, c).length_squared(), face));
        };
        if hull.is_solid {
            if only_new {
                hull.builder.new_faces().for_each(&mut collect);
            } else {
                hull.builder.all_faces().for_each(&mut collect);
            }
        } else if let Ok((flat, _)) = solid_hull(
            &mut self.thickener,
            as_arrays(&hull.points),
            hull.outward.to_array(),
            LEAST_THICKNESS,
        ) {
            flat.faces().for_each(&mut collect);
        }
        self.refusals.clear();
        let contains = |&(point, _): &(Vector, f64)| hull.builder.farthest_outside(&[point]) <= 0.0;
        let has_cavity = hull.is_solid && self.solid.cavities.iter().any(contains);
        let fits = !has_cavity && self.faces_fit(&mut faces);
        self.faces = faces;
        fits
    }

    /// Whether faces fit: by their centres first, then as a whole, the largest first. Notes
    /// refusals.
    fn faces_fit(&mut self, faces: &mut [(f64, Face)]) -> bool {
        // Large faces are the most likely to protrude.
        faces.sort_by(|a, b| b.0.total_cmp(&a.0));
        let Self { solid, bound, scratch, refusals, .. } = self;
        let (solid, bound) = (*solid, *bound);
        let by_centre = faces.iter().map(|&(_, face)| Refusal { face, point: centre(face) });
        let by_centre = by_centre.filter(|refusal| !solid.point_fits(refusal.point, bound));
        refusals.extend(by_centre.take(MAX_REFUSALS));
        if refusals.is_empty() {
            let protruding = faces.iter().find_map(|&(_, face)| {
                let point = solid.protruding_point(face, bound, scratch)?;
                Some(Refusal { face, point })
            });
            refusals.extend(protruding);
        }
        refusals.is_empty()
    }

    /// Why the last hull was refused: faces that protrude. There are none where it contains a
    /// cavity. What they are depends on the hulls that were tested, and on nothing else.
    pub fn refusals(&self) -> &[Refusal] {
        &self.refusals
    }

    /// Grows a hull by parts of the surface, each given by its points and its outward direction, if
    /// the joint hull fits. Returns whether it does.
    pub fn try_insert<'p>(
        &mut self,
        hull: &mut GrowingHull,
        parts: impl Iterator<Item = (&'p [Vector], Vector)>,
    ) -> bool {
        self.points.clear();
        let mut outward = Vector::ZERO;
        for (part, part_outward) in parts {
            self.points.extend_from_slice(part);
            outward += part_outward;
        }
        self.try_points(hull, outward)
    }

    /// The same with the points that were noted. It is no part of the generic function, of which
    /// browsers would get a copy for each kind of iterator.
    fn try_points(&mut self, hull: &mut GrowingHull, outward: Vector) -> bool {
        self.attempts += 1;
        let points = std::mem::take(&mut self.points);
        let mut trial = std::mem::take(&mut self.trial);
        trial.copy_from(hull);
        let only_new = trial.insert(&points, outward);
        let fits = self.fits(&trial, only_new);
        if fits {
            std::mem::swap(hull, &mut trial);
        }
        (self.trial, self.points) = (trial, points);
        fits
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Control;
    use crate::geometry::TriangleMesh;
    use crate::geometry::vector::{as_vectors, into_vectors};
    use crate::mesh::canonical_order::MeshOrder;
    use crate::mesh::repair::prepare;
    use crate::mesh::shapes::{cuboid, hemisphere, join, torus};
    use crate::mesh::simplification::Simplification;
    use crate::solid::surface::{OPEN_INSIDE, Surface};
    use crate::solid::{Boundary, SolidSettings};

    const BOUND: f64 = 0.03;

    fn solid_of(mesh: &TriangleMesh, boundary: Boundary) -> Solid {
        let TriangleMesh { positions, triangles, .. } = mesh;
        Solid::of_surface(as_vectors(positions), triangles, boundary, BOUND, &Control::new())
            .unwrap()
    }

    #[test]
    fn a_hull_grows_by_what_fits_and_stays_as_it_is_where_that_does_not() {
        let cube = |x: f64| cuboid([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
        let solid = solid_of(&join(&[cube(0.0), cube(1.0 + 4.0 * BOUND)]), Boundary::default());
        let mut tester = FitTester::new(&solid, BOUND);
        let (near, far) =
            (into_vectors(cube(0.0).positions), into_vectors(cube(1.0 + 4.0 * BOUND).positions));
        let mut hull = GrowingHull::new(&near[..5], Vector::ZERO);
        assert!(hull.is_solid);
        let volume = hull.current_volume();
        let mut try_insert = |hull: &mut GrowingHull, points: &[Vector]| {
            tester.try_insert(hull, std::iter::once((points, Vector::ZERO)))
        };
        assert!(!try_insert(&mut hull, &far), "across a gap of four bounds");
        assert_eq!(hull.current_volume(), volume);
        assert!(try_insert(&mut hull, &near[5..]));
        assert!((hull.current_volume() - 1.0).abs() < 1e-12);
        assert!(
            try_insert(&mut hull, &[Vector::new(1.0 + 0.9 * BOUND, 0.5, 0.5)]),
            "within the bound"
        );
        assert!(!try_insert(&mut hull, &[Vector::new(1.0 + 1.5 * BOUND, 0.1, 0.1)]), "beyond it");
        assert_eq!(tester.attempts, 4);
    }

    // The test of faces against dense samples, on closed and open solids, dense and coarse.

    /// Samples along each side of a face.
    const SAMPLES: usize = 16;

    /// Winding numbers of open surfaces are expansions.
    const DOUBTFUL: f64 = 0.05;

    /// A solid, and the vertices of its surface.
    struct Case {
        name: &'static str,
        solid: Solid,
        corners: Vec<Vector>,
    }

    impl Case {
        /// Without what only coarse solids do.
        fn dense(name: &'static str, mesh: &TriangleMesh, bound: f64) -> Self {
            let TriangleMesh { positions, triangles, .. } = mesh;
            let boundary = Boundary::new(as_vectors(positions), triangles);
            let mut solid = Solid::of_surface(
                as_vectors(positions),
                triangles,
                boundary,
                bound,
                &Control::new(),
            )
            .unwrap();
            solid.is_coarse = false;
            Self { name, solid, corners: into_vectors(positions.clone()) }
        }

        fn coarse(name: &'static str, mesh: &TriangleMesh, bound: f64) -> Self {
            let control = Control::new();
            let prepared = prepare(mesh.view(), MeshOrder::Place, &control).unwrap();
            let settings = SolidSettings { bound, keep_cavities: false, probe: None };
            let solid =
                Solid::new(&Simplification::unchanged(&prepared), &settings, &control).unwrap();
            assert!(solid.is_coarse());
            Self { name, solid, corners: into_vectors(prepared.mesh.positions) }
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
            assert_eq!(
                cases.each_ref().map(|case| case.solid.is_closed()),
                [true, true, false, false]
            );
            cases
        }

        /// Without the grid, how far a point is from the surface if the winding number is below a
        /// limit there, else 0.
        fn outside(&self, point: Vector, limit: f64) -> f64 {
            let Surface { tree, .. } = self.solid.surface();
            match tree.closest_point(point, f64::INFINITY) {
                Some(closest) if self.solid.surface().winding_number(point) < limit => {
                    closest.distance
                }
                _ => 0.0,
            }
        }

        /// The greatest of these over a face, where it is outside for certain.
        fn sampled(&self, [a, b, c]: [Vector; 3]) -> f64 {
            let share = |index: usize| index as f64 / SAMPLES as f64;
            let weights = (0..=SAMPLES).flat_map(|i| (0..=SAMPLES - i).map(move |j| (i, j)));
            let points = weights.map(|(i, j)| {
                let rest = share(SAMPLES - i - j);
                a * share(i) + b * share(j) + c * rest
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
                let mut scratch = Scratch::default();
                let (mut fitting, mut overlooked, mut refused, mut wrongly) = (0, 0, 0, 0);
                for face in case.faces() {
                    let Some(point) = case.solid.protruding_point(face, bound, &mut scratch) else {
                        fitting += 1;
                        let sampled = case.sampled(face);
                        // What is accepted by d + LENIENCE · r ≤ bound is no farther than d + r.
                        assert!(LENIENCE * sampled < bound, "{}, {bound}: {sampled}", case.name);
                        overlooked += usize::from(sampled > 1.1 * bound);
                        continue;
                    };
                    refused += 1;
                    let outside = case.outside(point, OPEN_INSIDE + DOUBTFUL);
                    wrongly += usize::from(outside <= bound * (1.0 - 1e-6));
                }
                assert!(fitting > 50 && refused > 3, "{}: {fitting}, {refused}", case.name);
                // The side of a cell is that of its centre. Where a surface ends it changes within
                // the cell, and only a coarse solid looks at the depth as well.
                let is_exact = case.solid.is_closed() || case.solid.is_coarse();
                let most = if is_exact { 0 } else { refused / 20 };
                assert!(wrongly <= most, "{}, {bound}: {wrongly} of {refused}", case.name);
                assert!(overlooked * 20 <= fitting, "{}: {overlooked} of {fitting}", case.name);
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
                    let away = a - (b + c) * 0.5;
                    let size = away.length_squared().sqrt().max(1e-12);
                    let point = a + away * (share * bound / size);
                    let fits = case.solid.point_fits(point, bound);
                    let for_certain = case.outside(point, OPEN_INSIDE - DOUBTFUL);
                    let perhaps = case.outside(point, OPEN_INSIDE + DOUBTFUL);
                    assert!(!fits || for_certain <= bound * 1.001, "{} {for_certain}", case.name);
                    assert!(fits || perhaps >= bound * 0.999, "{} {perhaps}", case.name);
                }
            }
        }
    }
}
