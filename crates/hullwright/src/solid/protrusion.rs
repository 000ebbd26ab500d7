//! Verification: how far a hull protrudes from the solid, as an upper bound, not by samples.
//!
//! The rules of the fit test decide a part, without its leniences: no part is accepted because it
//! is small.

use super::grid::Location;
use super::solid::{NO_GUESS, Solid};
use super::subdivide::{Face, Part, Policy, Scratch, Verdict, subdivide};
use super::surface::Side;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::Vector;
use crate::hull::ConvexHull;
use crate::work;

/// Protrusions below this share of the bound are not resolved: they decide nothing, and resolving
/// them takes 3 to 14 % of the whole time. With [`RESOLUTION`], no result is below 0.29 of the
/// bound.
const UNRESOLVED: f64 = 0.25;

/// The same for an open solid, where a part is only known to be inside as far as the inside extends
/// around a point: the less is resolved, the fewer points.
const UNRESOLVED_IN_OPEN: f64 = 0.75;

/// Protrusions are too large by at most this share of the bound: a smaller one takes more parts of
/// faces for digits that decide nothing.
const RESOLUTION: f64 = 0.04;

/// The same for maxima just below the bound, where it decides whether a hull is divided.
const FINE_RESOLUTION: f64 = 0.005;

/// Maximum number of parts of a hull's faces: needles would otherwise be halved without end.
const MAX_PARTS: usize = 200_000;

/// Where the distance is maximal all along a line, as halfway between two sheets, resolving it
/// takes parts without end. After this many it is only decided whether the bound is kept. Two
/// plates 0.13 % apart under a bound of 0.2 % took 50 s without.
const MANY_PARTS: usize = 20_000;

/// Parts between two checks for cancellation: less than a millisecond.
const PARTS_PER_CHECK: usize = 1024;

/// No point of the hull's faces is farther than this from the solid of the source, as a fraction of
/// the diagonal: what the surface has moved is added. If it exceeds `limit`, any value above
/// `limit` may be returned.
///
/// # Errors
/// [`Error::Cancelled`].
pub(crate) fn protrusion(
    hull: &ConvexHull,
    solid: &Solid,
    bound: f64,
    limit: f64,
    control: &Control,
) -> Result<f64, Error> {
    let unresolved = if solid.is_closed() { UNRESOLVED } else { UNRESOLVED_IN_OPEN };
    let (bound, limit) = (bound - solid.moved, limit - solid.moved);
    let mut exact = Exact::new(solid, bound, limit, unresolved * bound, control);
    if exact.cavities_exceed(hull) {
        return Ok(exact.known + solid.moved);
    }
    let faces: Vec<Face> = hull.faces().collect();
    Ok(exact.run(&faces)? + solid.moved)
}

/// Whether no point of the hull's faces is farther than the bound from the solid. Faster than the
/// protrusion: nothing below the bound is resolved.
///
/// # Errors
/// [`Error::Cancelled`].
pub(crate) fn keeps_bound(
    hull: &ConvexHull,
    solid: &Solid,
    bound: f64,
    control: &Control,
) -> Result<bool, Error> {
    let bound = bound - solid.moved;
    let faces: Vec<Face> = hull.faces().collect();
    // Most hulls that protrude do so at one of few points.
    if !faces.iter().all(|&face| solid.centre_fits(face, bound)) {
        return Ok(false);
    }
    let mut exact = Exact::new(solid, bound, bound, (1.0 - RESOLUTION) * bound, control);
    Ok(!exact.cavities_exceed(hull) && exact.run(&faces)? <= bound)
}

/// The rules of verification: the greatest distance so far, and what it depends on.
struct Exact<'a> {
    solid: &'a Solid,
    bound: f64,
    limit: f64,
    control: &'a Control,
    /// What the result is at least.
    known: f64,
    parts: usize,
    end: Option<End>,
}

/// Why parts are left undecided.
enum End {
    /// The limit is exceeded.
    Exceeds(f64),
    /// There are too many; the one that was next.
    TooMany(Face),
    Error(Error),
}

/// The side of a part in an open solid, where the side may change without crossing the surface.
enum OpenSide {
    AllInside,
    CentreInside,
    CentreOutside,
}

impl<'a> Exact<'a> {
    /// Protrusions of no more than `unresolved` are not resolved.
    fn new(
        solid: &'a Solid,
        bound: f64,
        limit: f64,
        unresolved: f64,
        control: &'a Control,
    ) -> Self {
        Self { solid, bound, limit, control, known: unresolved, parts: 0, end: None }
    }

    /// The protrusion of some faces, or any value above the limit.
    fn run(&mut self, faces: &[Face]) -> Result<f64, Error> {
        // One large protrusion makes all other faces cheap.
        for &face in faces {
            self.control.check()?;
            let centre = Part::new(face).centre;
            if let Some(protruding) = self.solid.outside(centre, self.known) {
                self.known = protruding.upper;
            }
            if self.known > self.limit {
                return Ok(self.known);
            }
        }
        let (solid, mut scratch) = (self.solid, Scratch::default());
        subdivide(solid, faces.iter().copied(), self, &mut scratch);
        match self.end.take() {
            None => Ok(self.enough()),
            Some(End::Exceeds(distance)) => Ok(distance),
            Some(End::Error(error)) => Err(error),
            Some(End::TooMany(next)) => {
                let rest = scratch.stack.iter().map(|&(part, _)| part).chain([next]);
                let rest = rest.map(|part| upper_distance(&Part::new(part), solid));
                Ok(rest.fold(self.enough(), f64::max))
            }
        }
    }

    fn stop(&mut self, end: End) -> Verdict {
        self.end = Some(end);
        Verdict::Stop
    }

    /// Takes cavities into account that the hull contains. Whether they exceed the limit.
    fn cavities_exceed(&mut self, hull: &ConvexHull) -> bool {
        let cavities = &self.solid.cavities;
        if cavities.is_empty() {
            return false;
        }
        let planes = hull.face_planes();
        let contains = |point| planes.iter().all(|plane| plane.height(point) <= 0.0);
        for &(point, depth) in cavities {
            if depth > self.known && contains(point) {
                self.known = depth;
            }
        }
        self.known > self.limit
    }

    /// What the result may be anyway, by [`enough`].
    fn enough(&self) -> f64 {
        enough(self.known, self.bound)
    }

    fn side_in_open(&self, part: &Part, at: &Location<'_>, distance: f64) -> OpenSide {
        // From the ball that is inside no point of the part is farther than the rest.
        let needed = part.radius - self.enough();
        if needed <= 0.0 {
            return match at.side_in_open(part.centre) {
                Side::Inside => OpenSide::AllInside,
                Side::Outside => OpenSide::CentreOutside,
            };
        }
        match at.depth_at_distance(part.centre, distance, needed) {
            None => OpenSide::CentreOutside,
            Some(depth) if needed <= depth => OpenSide::AllInside,
            Some(_) => OpenSide::CentreInside,
        }
    }
}

impl Policy for Exact<'_> {
    fn judge(&mut self, part: &Part) -> Verdict {
        work::count(work::PART);
        let &mut Self { solid, bound, limit, .. } = self;
        self.parts += 1;
        if self.parts.is_multiple_of(PARTS_PER_CHECK)
            && let Err(error) = self.control.check()
        {
            return self.stop(End::Error(error));
        }
        if self.parts == MANY_PARTS && limit >= bound {
            self.known = self.known.max((1.0 - FINE_RESOLUTION) * bound);
        }
        if self.parts > MAX_PARTS {
            return self.stop(End::TooMany(part.corners));
        }
        let &Part { corners, centre, radius } = part;
        let (known, enough) = (self.known, self.enough());
        let at = solid.locate(centre);
        if at.upper_of_face(corners, enough) <= enough
            || at.depth().is_some_and(|depth| radius - depth <= enough)
        {
            return Verdict::Settled;
        }
        let guess = at.triangle();
        let slack = if known > bound { RESOLUTION * known } else { FINE_RESOLUTION * bound };
        let may_halve = radius > slack;
        // A distance below the maximum only decides where it is known to be small.
        if may_halve && solid.tree().distance_to_triangle(centre, guess) <= known {
            return Verdict::Open;
        }
        let Some(closest) = solid.closest(centre, guess) else {
            return self.stop(End::Exceeds(f64::INFINITY));
        };
        let distance = closest.distance;
        if distance + radius <= enough
            || solid.grid.upper_to_triangle(corners, closest.triangle) <= enough
        {
            return Verdict::Settled;
        }
        // Inside tests are expensive: only where they decide.
        let may_be_inside = radius - distance <= enough;
        let is_enough_inside = solid.is_closed() && may_be_inside;
        if distance > known || may_be_inside || !may_halve {
            let is_inside = if solid.is_closed() {
                solid.side_at_distance(centre, &at, distance) == Side::Inside
            } else {
                match self.side_in_open(part, &at, distance) {
                    OpenSide::AllInside => return Verdict::Settled,
                    OpenSide::CentreInside => true,
                    OpenSide::CentreOutside => false,
                }
            };
            if is_inside {
                if is_enough_inside || !may_halve {
                    return Verdict::Settled;
                }
            } else {
                if distance > known && solid.probe_allows_all(|| part.extent(1.0), enough) {
                    return Verdict::Settled;
                }
                let settled = (enough - radius).clamp(0.0, known);
                let entered = if distance > known { solid.entered(centre, settled) } else { None };
                let of_part = solid.upper_around(distance, entered, radius);
                if entered.is_some() && of_part <= enough {
                    return Verdict::Settled;
                }
                let mut protrusion = distance.min(entered.unwrap_or(f64::INFINITY));
                // Just beyond a ball's half, the distance from the mesh counts.
                if solid.probe.is_some() && !may_halve && of_part > enough {
                    protrusion = of_part;
                }
                if protrusion > known {
                    self.known = protrusion;
                }
                if self.known > limit {
                    let distance = self.known + radius;
                    return self.stop(End::Exceeds(distance));
                }
            }
        }
        if may_halve { Verdict::Open } else { Verdict::Settled }
    }

    fn near(&self) -> f64 {
        self.enough()
    }

    fn judge_outside(&mut self, _: Vector) -> Verdict {
        Verdict::Open
    }
}

/// No point of a part is farther than this from the surface.
fn upper_distance(part: &Part, solid: &Solid) -> f64 {
    solid.closest(part.centre, NO_GUESS).map_or(f64::INFINITY, |closest| {
        solid.upper_around(closest.distance, solid.entered(part.centre, 0.0), part.radius)
    })
}

/// The bound on a maximum that is at least `known`: near the promised bound as tight as it takes to
/// decide whether that is kept.
fn enough(known: f64, bound: f64) -> f64 {
    if known > bound {
        known * (1.0 + RESOLUTION)
    } else if known + RESOLUTION * bound <= bound {
        known + RESOLUTION * bound
    } else {
        bound.max(known + FINE_RESOLUTION * bound)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::Bvh;
    use crate::geometry::vector::{as_arrays, as_vectors, into_vectors};
    use crate::hull::convex_hull;
    use crate::mesh::TriangleMesh;
    use crate::mesh::canonical_order::MeshOrder;
    use crate::mesh::repair::prepare;
    use crate::mesh::shapes::{cuboid, hemisphere, join, torus, uv_sphere};
    use crate::mesh::simplification::Simplification;
    use crate::solid::{Boundary, SolidSettings};

    fn solid_of(mesh: &TriangleMesh, boundary: Boundary, bound: f64) -> Solid {
        let TriangleMesh { positions, triangles, .. } = mesh;
        Solid::of_surface(as_vectors(positions), triangles, boundary, bound, &Control::new())
            .unwrap()
    }

    fn keeps(hull: &ConvexHull, solid: &Solid, bound: f64) -> bool {
        keeps_bound(hull, solid, bound, &Control::new()).unwrap()
    }

    #[test]
    fn a_hull_keeps_the_bound_exactly_if_it_protrudes_by_no_more() {
        let cube = |x: f64| cuboid([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
        let bound = 0.02;
        let solid = solid_of(&cube(0.0), Boundary::default(), bound);
        for share in [0.0, 0.5, 0.9, 0.97, 0.99, 1.01, 1.03, 1.1, 2.0, 20.0] {
            let moved = convex_hull(&cube(share * bound).positions).unwrap();
            assert_eq!(keeps(&moved, &solid, bound), share <= 1.0, "{share}");
        }
    }

    #[test]
    fn a_hull_that_protrudes_far_from_the_centres_of_its_faces_does_not_keep_the_bound() {
        let mesh = cuboid([0.0; 3], [1.0; 3]);
        let bound = 0.02;
        let solid = solid_of(&mesh, Boundary::default(), bound);
        for share in [0.9, 0.97, 1.03, 1.5, 2.5] {
            let mut corners = mesh.positions.clone();
            // The centres of the faces are no higher than a third of this.
            corners.push([0.5, 0.5, 1.0 + share * bound]);
            let hull = convex_hull(&corners).unwrap();
            assert!(hull.faces().all(|face| solid.centre_fits(face, bound)));
            assert_eq!(keeps(&hull, &solid, bound), share <= 1.0, "{share}");
        }
    }

    #[test]
    fn a_hull_that_contains_a_cavity_deeper_than_the_bound_does_not_keep_it() {
        let mesh = cuboid([0.0; 3], [1.0; 3]);
        let mut solid = solid_of(&mesh, Boundary::default(), 0.02);
        let hull = convex_hull(&mesh.positions).unwrap();
        assert!(keeps(&hull, &solid, 0.02));
        solid.cavities = vec![(Vector::splat(0.5), 0.1)];
        assert!(!keeps(&hull, &solid, 0.02));
    }

    /// Hulls of some neighbouring vertices, from few to many.
    fn hulls(mesh: &TriangleMesh) -> Vec<ConvexHull> {
        let count = mesh.positions.len();
        let starts = (0..count).step_by(count / 24 + 1);
        let windows = starts.flat_map(|start| [6, 12, 22, 34, 60].map(|size| (start, size)));
        windows
            .filter_map(|(start, size)| {
                let points: Vec<Vector> =
                    (start..start + size).map(|k| mesh.points()[k % count]).collect();
                convex_hull(as_arrays(&points)).ok()
            })
            .collect()
    }

    #[test]
    fn a_hull_keeps_the_bound_where_its_protrusion_does() {
        let bound = 0.03;
        let two = join(&[torus(24, 12), cuboid([0.2, 0.2, -0.1], [0.5, 0.6, 0.9])]);
        let bowl = hemisphere(10);
        let rim = Boundary::new(bowl.points(), &bowl.triangles);
        for (mesh, boundary) in [(two, Boundary::default()), (bowl, rim)] {
            let solid = solid_of(&mesh, boundary, bound);
            let (mut kept, mut refused) = (0, 0);
            for hull in hulls(&mesh) {
                let keeps = keeps(&hull, &solid, bound);
                let found = protrusion(&hull, &solid, bound, bound, &Control::new()).unwrap();
                assert_eq!(found <= bound, keeps, "{found}");
                if keeps { kept += 1 } else { refused += 1 }
            }
            assert!(kept > 10 && refused > 10, "{kept} kept, {refused} refused");
        }
    }

    #[test]
    fn below_stacked_open_sheets_a_large_face_is_not_inside_as_a_whole() {
        // Six unit squares, close above each other: just below them the winding number is 3, but
        // at a depth of 0.9 less than one half.
        let mut positions = Vec::new();
        let mut triangles = Vec::new();
        for sheet in 0..6_u32 {
            let z = 1e-3 * f64::from(sheet);
            positions.extend([[0.0, 0.0, z], [1.0, 0.0, z], [1.0, 1.0, z], [0.0, 1.0, z]]);
            triangles.extend([[0, 1, 2], [0, 2, 3]].map(|corners| corners.map(|v| v + 4 * sheet)));
        }
        let control = Control::new();
        let bound = 0.01;
        let boundary = Boundary::new(as_vectors(&positions), &triangles);
        let solid =
            Solid::of_surface(as_vectors(&positions), &triangles, boundary, bound, &control)
                .unwrap();
        let depth = 0.9;
        let corners = [[0.5, 0.0, 0.0], [0.5, 1.0, 0.0], [0.5, 0.5, -depth], [0.6, 0.5, -0.1]]
            .map(Vector::from);
        let hull = convex_hull(as_arrays(&corners)).unwrap();
        assert_eq!(solid.side(corners[2]), Side::Outside);
        assert_eq!(solid.side(Vector::new(0.5, 0.5, -0.3)), Side::Inside);
        // No point of the solid is nearer to the tip than the nearest of a lattice, up to its
        // spacing.
        let steps = || (0..50).map(|k| 0.02 * f64::from(k));
        let lattice = steps()
            .flat_map(|x| steps().flat_map(move |y| steps().map(move |z| Vector::new(x, y, -z))));
        let inside = lattice.filter(|&point| solid.side(point) == Side::Inside);
        let nearest = inside.map(|point| point.distance(corners[2])).fold(depth, f64::min);
        let least = nearest - 0.02 * 3f64.sqrt();
        assert!(least > bound, "{least}");
        let found = protrusion(&hull, &solid, bound, f64::INFINITY, &control).unwrap();
        assert!(found >= least, "{found}, {least}");
    }

    fn cube(low: Vector) -> ConvexHull {
        let corners = (0..8).map(|i| [0, 1, 2].map(|k| low[k] + f64::from(i >> k & 1)));
        convex_hull(&corners.collect::<Vec<_>>()).unwrap()
    }

    fn solid_of_hull(hull: &ConvexHull, bound: f64) -> Solid {
        let boundary = Boundary::default();
        Solid::of_surface(hull.points(), &hull.triangles, boundary, bound, &Control::new()).unwrap()
    }

    #[test]
    fn a_hull_protrudes_into_the_cavities_that_it_contains_and_into_no_other() {
        let shell = cube(Vector::ZERO);
        let bound = 0.02;
        let mut solid = solid_of_hull(&shell, bound);
        solid.cavities = vec![
            (Vector::splat(0.5), 0.1),
            (Vector::new(0.5, 0.5, 0.2), 0.15),
            (Vector::splat(1.5), 0.3),
        ];
        let of = |hull| protrusion(hull, &solid, bound, f64::INFINITY, &Control::new()).unwrap();
        // A result is too large by a share at most.
        assert!((0.15..0.16).contains(&of(&shell)), "{}", of(&shell));
        let upper_half = [[0.0, 0.0, 0.4], [1.0, 0.0, 0.4], [0.0, 1.0, 0.4], [1.0, 1.0, 0.4]];
        let mut corners = upper_half.to_vec();
        corners.extend(upper_half.map(|[x, y, _]| [x, y, 1.0]));
        let upper_half = convex_hull(&corners).unwrap();
        assert!((0.1..0.11).contains(&of(&upper_half)), "{}", of(&upper_half));
    }

    #[test]
    fn a_shifted_hull_protrudes_by_its_shift() {
        let (inner, outer) = (cube(Vector::ZERO), cube(Vector::splat(0.25)));
        let (control, bound) = (Control::new(), 0.02);
        let solid = solid_of_hull(&inner, bound);
        let of = |hull| protrusion(hull, &solid, bound, f64::INFINITY, &control).unwrap();
        // A hull that is the solid protrudes by nothing: less than the share that is not resolved
        // is not reported.
        assert!(of(&inner) <= (UNRESOLVED + RESOLUTION) * bound + f64::EPSILON, "{}", of(&inner));
        // The farthest corner is shifted by a quarter along each axis.
        let farthest = 0.25 * 3f64.sqrt();
        assert!((farthest..1.05 * farthest).contains(&of(&outer)), "{}", of(&outer));
    }

    const BOUND: f64 = 0.02;

    /// The points of a shape, its solid, and a tree of its own.
    fn searched(mesh: &TriangleMesh) -> (Vec<Vector>, Solid, Bvh) {
        let control = Control::new();
        let prepared = prepare(mesh.view(), MeshOrder::Place, &control).unwrap();
        let settings = SolidSettings { bound: BOUND, keep_cavities: false, probe: None };
        let solid = Solid::new(&Simplification::unchanged(&prepared), &settings, &control).unwrap();
        let TriangleMesh { positions, triangles, .. } = prepared.mesh;
        let source = Bvh::new(as_vectors(&positions), &triangles);
        (into_vectors(positions), solid, source)
    }

    /// A pyramid that is within a round shape except for its tip.
    fn spike(at: Vector, height: f64, width: f64) -> ConvexHull {
        let outward = at.normalize_or_zero();
        let across = outward.cross(Vector::new(0.48, 0.6, 0.64)).normalize_or_zero();
        let along = outward.cross(across);
        let base = [[1.0, 0.0], [-0.5, 0.8], [-0.5, -0.8]].map(|[x, y]| {
            let foot = at + outward * -0.1;
            foot + (across * (x * width) + along * (y * width))
        });
        let tip = at + outward * height;
        convex_hull(&[base[0].to_array(), base[1].to_array(), base[2].to_array(), tip.to_array()])
            .unwrap()
    }

    #[test]
    fn a_spike_protrudes_as_far_as_its_tip() {
        let open = |n| {
            let mut mesh = uv_sphere(n, [0.0; 3], 1.0);
            let TriangleMesh { positions, triangles, .. } = &mut mesh;
            triangles.retain(|corners| corners.iter().all(|&v| positions[v as usize][2] < 0.95));
            mesh
        };
        let closed = |n| uv_sphere(n, [0.0; 3], 1.0);
        let control = Control::new();
        for mesh in [closed(20), closed(50), closed(300), open(20), open(50)] {
            let (positions, solid, source) = searched(&mesh);
            let count = positions.len();
            let unresolved = if solid.is_closed() { UNRESOLVED } else { UNRESOLVED_IN_OPEN };
            let low = positions.into_iter().filter(|point| point[2] < 0.0);
            for (at, step) in low.step_by(count / 12).zip(0..) {
                for share in [0.2, 0.4, 0.6, 0.7, 0.8, 0.9, 0.98, 1.01, 1.02, 1.03, 1.2, 1.5, 2.0] {
                    let (height, width) = (share * BOUND, [0.02, 0.08][step % 2]);
                    let hull = spike(at, height, width);
                    let tip = at + at.normalize_or_zero() * height;
                    let expected = source.closest_point(tip, f64::INFINITY).unwrap().distance;
                    let of = |limit| protrusion(&hull, &solid, BOUND, limit, &control).unwrap();
                    let found = of(f64::INFINITY);
                    let most = 1.001 * enough(expected.max(unresolved * BOUND), BOUND);
                    assert!(
                        (expected - 1e-12..=most).contains(&found),
                        "{count}, {share}: {found}, {expected}"
                    );
                    if (expected / BOUND - 1.0).abs() > 1e-3 {
                        assert_eq!(of(BOUND) > BOUND, expected > BOUND, "{count}, {share}");
                    }
                }
            }
        }
    }

    #[test]
    fn against_a_second_solid_a_hull_protrudes_by_its_distance() {
        let boxes = [cube(Vector::ZERO), cube(Vector::new(1.2, 0.0, 0.0))];
        let shapes = boxes.each_ref().map(|hull| hull.points.clone()).concat();
        let whole = convex_hull(&shapes).unwrap();
        let meshes = [0.0, 1.2].map(|x| cuboid([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]));
        let first = solid_of(&join(&meshes), Boundary::default(), BOUND);
        // The gap is filled, as where nothing can enter it.
        let second = solid_of_hull(&whole, BOUND);
        let shifted = cube(Vector::new(0.0, 0.0, 0.25));
        let of = |solid: &Solid, hull| {
            protrusion(hull, solid, BOUND, f64::INFINITY, &Control::new()).unwrap()
        };
        assert!((0.1..0.11).contains(&of(&first, &whole)), "half the gap");
        let (unmoved, moved) = (of(&second, &whole), of(&second, &shifted));
        assert!(unmoved <= enough(UNRESOLVED * BOUND, BOUND), "{unmoved}");
        assert!((0.25..1.05 * 0.25).contains(&moved), "{moved}");
    }

    #[test]
    fn what_protrudes_farther_than_the_limit_is_reported_to() {
        let (inner, outer) = (cube(Vector::ZERO), cube(Vector::new(0.0, 0.0, 0.25)));
        let solid = solid_of_hull(&inner, BOUND);
        // The first is what is not resolved, the last what the centres of the faces protrude.
        for limit in [UNRESOLVED * BOUND, BOUND, 0.2, 0.25 - 1e-9] {
            let found = protrusion(&outer, &solid, BOUND, limit, &Control::new()).unwrap();
            assert!(found > limit, "{found}, {limit}");
        }
    }

    #[test]
    fn a_cavity_hides_no_protrusion_elsewhere() {
        let (inner, outer) = (cube(Vector::ZERO), cube(Vector::new(0.0, 0.0, 0.25)));
        let mut solid = solid_of_hull(&inner, BOUND);
        solid.cavities = vec![(Vector::splat(0.5), 0.1)];
        for limit in [0.1, 0.2, f64::INFINITY] {
            let found = protrusion(&outer, &solid, BOUND, limit, &Control::new()).unwrap();
            assert!(found > limit.min(0.25 - 1e-9), "{found}, {limit}");
        }
    }

    #[test]
    fn across_a_gap_as_wide_as_two_bounds_or_less_the_bound_is_kept() {
        // On the line halfway the distance is the same everywhere.
        for share in [0.98, 1.02] {
            let above = 0.1 + 2.0 * share * BOUND;
            let plates = join(&[
                cuboid(Vector::ZERO, Vector::new(1.0, 1.0, 0.1)),
                cuboid(Vector::new(0.0, 0.0, above), Vector::new(1.0, 1.0, above + 0.1)),
            ]);
            let TriangleMesh { positions, triangles, .. } = &plates;
            let control = Control::new();
            let solid = Solid::of_surface(
                as_vectors(positions),
                triangles,
                Boundary::default(),
                BOUND,
                &control,
            )
            .unwrap();
            let hull = convex_hull(positions).unwrap();
            let found = protrusion(&hull, &solid, BOUND, BOUND, &control).unwrap();
            assert!(found >= share * BOUND, "{found}");
            assert_eq!(found <= BOUND, share <= 1.0, "{found}");
        }
    }

    #[test]
    fn what_is_left_when_parts_are_too_many_counts_with_its_distance_and_its_radius() {
        let solid = solid_of_hull(&cube(Vector::ZERO), 0.02);
        let above = |z: f64| [[0.2, 0.2, z], [0.8, 0.2, z], [0.2, 0.8, z]];
        let to_corner = Part::new(above(0.0).map(Into::into)).radius;
        for height in [0.0, 0.5, 2.0] {
            let upper = upper_distance(&Part::new(above(1.0 + height).map(Into::into)), &solid);
            assert!((upper - (height + to_corner)).abs() < 1e-9, "{height}: {upper}");
        }
    }
}
