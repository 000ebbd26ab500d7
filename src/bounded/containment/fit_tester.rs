//! The fit test of whole hulls: their faces are looked up in the cache, then tested by their
//! centres, largest first, then where earlier hulls have protruded, then completely.

use super::face_cache::{FaceCache, FaceKey};
use super::fit_test::FitScratch;
use super::solid::Solid;
use super::suspects::Suspects;
use crate::bounded::growing_hull::GrowingHull;
use crate::geometry::vector::{Vector, add, area_normal, length_squared, squared};
use crate::hull::{HullBuilder, LEAST_THICKNESS, solid_hull};

/// Faces of a larger area, squared and times four, in bounds to the fourth power, are tested at four
/// points before they are tested completely: most that protrude do so there.
const LARGE: f64 = 400.0;

/// Places where a hull has protruded that are remembered while it grows: more take as long as they save.
const MAX_SUSPECTS: usize = 16;

/// A face whose fit is not cached.
struct UntestedFace {
    /// Its squared area, times four.
    size: f64,
    key: FaceKey,
    face: [Vector; 3],
}

/// Tests hulls against a solid under a bound. Keeps scratch buffers between tests.
pub(in crate::bounded) struct FitTester<'a> {
    solid: &'a Solid,
    bound: f64,
    /// A copy of the hull that is to grow.
    trial: GrowingHull,
    thickener: HullBuilder,
    faces: Vec<UntestedFace>,
    scratch: FitScratch,
    points: Vec<Vector>,
    suspects: Suspects,
    /// Joint hulls that [`try_insert`](Self::try_insert) has tested.
    pub attempts: usize,
}

impl<'a> FitTester<'a> {
    pub fn new(solid: &'a Solid, bound: f64) -> Self {
        Self {
            solid,
            bound,
            trial: GrowingHull::new(&[], [0.0; 3]),
            thickener: HullBuilder::new(),
            faces: Vec::new(),
            scratch: FitScratch::default(),
            points: Vec::new(),
            suspects: Suspects::new(MAX_SUSPECTS),
            attempts: 0,
        }
    }

    pub fn bound(&self) -> f64 {
        self.bound
    }

    /// Whether a hull's surface is nowhere farther than the bound from the solid. Only the faces of
    /// the last insertion are tested if `only_new`.
    pub fn fits(&mut self, hull: &GrowingHull, only_new: bool) -> bool {
        let mut faces = std::mem::take(&mut self.faces);
        faces.clear();
        let (cache, bound) = (&self.solid.face_cache, self.bound);
        let mut is_refused = false;
        // A face that is known not to fit saves testing the others.
        let mut collect = |mut face: [Vector; 3]| {
            // A face is tested from the same corner on, whichever hull it belongs to.
            face.sort_unstable_by(|a, b| {
                a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(a[2].total_cmp(&b[2]))
            });
            let key = FaceCache::key(face, bound);
            match cache.get(key) {
                Some(true) => {}
                Some(false) => is_refused = true,
                None => {
                    let [a, b, c] = face;
                    let size = length_squared(area_normal(a, b, c));
                    faces.push(UntestedFace { size, key, face });
                }
            }
            !is_refused
        };
        if hull.is_solid {
            if only_new {
                hull.builder.new_faces().all(&mut collect);
            } else {
                hull.builder.all_faces().all(&mut collect);
            }
        } else if let Ok((flat, _)) =
            solid_hull(&mut self.thickener, &hull.points, hull.outward, LEAST_THICKNESS)
        {
            flat.corners().all(&mut collect);
        }
        let contains = |&(point, _): &(Vector, f64)| hull.builder.farthest_outside(&[point]) <= 0.0;
        is_refused |= hull.is_solid && self.solid.cavities.iter().any(contains);
        let fits = !is_refused && self.faces_fit(&mut faces);
        self.faces = faces;
        fits
    }

    fn faces_fit(&mut self, faces: &mut [UntestedFace]) -> bool {
        // Large faces are the most likely to protrude.
        faces.sort_unstable_by(|a, b| b.size.total_cmp(&a.size));
        let (solid, bound) = (self.solid, self.bound);
        let fits = |untested: &UntestedFace, test: &mut dyn FnMut([Vector; 3]) -> bool| {
            let fits = test(untested.face);
            if !fits {
                solid.face_cache.insert(untested.key, false);
            }
            fits
        };
        let is_likely_to_fit =
            faces.iter().all(|face| fits(face, &mut |face| solid.centre_fits(face, bound)))
                && faces.iter().all(|face| {
                    let is_large = face.size > LARGE * squared(squared(bound));
                    !is_large || fits(face, &mut |face| solid.quarters_fit(face, bound))
                });
        if !is_likely_to_fit {
            return false;
        }
        let Self { scratch, suspects, .. } = self;
        let protrudes = |face, point| {
            !solid.point_fits(point, bound)
                && solid.protruding_point(face, Some(point), bound, scratch).is_some()
        };
        if let Some(index) = suspects.find(faces, |untested| untested.face, protrudes) {
            solid.face_cache.insert(faces[index].key, false);
            return false;
        }
        for &UntestedFace { key, face, .. } in faces.iter() {
            let protruding = solid.protruding_point(face, None, bound, scratch);
            solid.face_cache.insert(key, protruding.is_none());
            if let Some(point) = protruding {
                suspects.remember(point, face);
                return false;
            }
        }
        true
    }

    /// Grows a hull by parts of the surface, each given by its points and its outward direction, if
    /// the joint hull fits. Returns whether it does.
    pub fn try_insert<'p>(
        &mut self,
        hull: &mut GrowingHull,
        parts: impl Iterator<Item = (&'p [Vector], Vector)>,
    ) -> bool {
        let mut points = std::mem::take(&mut self.points);
        points.clear();
        let mut outward = [0.0; 3];
        for (part, part_outward) in parts {
            points.extend_from_slice(part);
            outward = add(outward, part_outward);
        }
        self.attempts += 1;
        let mut trial = std::mem::take(&mut self.trial);
        trial.copy_from(hull);
        let only_new = trial.insert(&points, outward);
        let fits = self.fits(&trial, only_new);
        if fits {
            std::mem::swap(hull, &mut trial);
        }
        self.trial = trial;
        self.points = points;
        fits
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounded::containment::boundary::Boundary;
    use crate::control::Control;
    use crate::geometry::TriangleMesh;
    use crate::mesh::shapes::{cuboid, hemisphere, join, torus};

    const BOUND: f64 = 0.03;

    fn solid_of(mesh: &TriangleMesh, boundary: Boundary) -> Solid {
        let TriangleMesh { positions, triangles, .. } = mesh;
        Solid::of_surface(positions, triangles, boundary, BOUND, &Control::new()).unwrap()
    }

    #[test]
    fn no_answer_depends_on_where_earlier_hulls_protruded() {
        let two = join(&[torus(24, 12), cuboid([0.2, 0.2, -0.1], [0.5, 0.6, 0.9])]);
        let bowl = hemisphere(10);
        let rim = || Boundary::new(&bowl.positions, &bowl.triangles);
        let no_rim = Boundary::default;
        let meshes: [(&TriangleMesh, &dyn Fn() -> Boundary); 2] = [(&two, &no_rim), (&bowl, &rim)];
        for (mesh, boundary) in meshes {
            // Each has a cache of its own.
            let (solid, other) = (solid_of(mesh, boundary()), solid_of(mesh, boundary()));
            let mut tester = FitTester::new(&solid, BOUND);
            let count = mesh.positions.len();
            let (mut fitting, mut refused) = (0, 0);
            for start in (0..count).step_by(count / 24 + 1) {
                for size in [6, 12, 22, 34, 60] {
                    let points: Vec<Vector> =
                        (start..start + size).map(|k| mesh.positions[k % count]).collect();
                    let hull = GrowingHull::new(&points, [0.0; 3]);
                    let alone = FitTester::new(&other, BOUND).fits(&hull, false);
                    assert_eq!(tester.fits(&hull, false), alone);
                    if alone { fitting += 1 } else { refused += 1 }
                }
            }
            assert!(fitting > 10 && refused > 10, "{fitting} fit, {refused} do not");
        }
    }

    #[test]
    fn a_hull_grows_by_what_fits_and_stays_as_it_is_where_that_does_not() {
        let cube = |x: f64| cuboid([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
        let solid = solid_of(&join(&[cube(0.0), cube(1.0 + 4.0 * BOUND)]), Boundary::default());
        let mut tester = FitTester::new(&solid, BOUND);
        assert_eq!(tester.bound(), BOUND);
        let (near, far) = (cube(0.0).positions, cube(1.0 + 4.0 * BOUND).positions);
        let mut hull = GrowingHull::new(&near[..5], [0.0; 3]);
        assert!(hull.is_solid);
        let volume = hull.current_volume();
        let mut try_insert = |hull: &mut GrowingHull, points: &[Vector]| {
            tester.try_insert(hull, std::iter::once((points, [0.0; 3])))
        };
        assert!(!try_insert(&mut hull, &far), "across a gap of four bounds");
        assert_eq!(hull.current_volume(), volume);
        assert!(try_insert(&mut hull, &near[5..]));
        assert!((hull.current_volume() - 1.0).abs() < 1e-12);
        assert!(try_insert(&mut hull, &[[1.0 + 0.9 * BOUND, 0.5, 0.5]]), "within the bound");
        assert!(!try_insert(&mut hull, &[[1.0 + 1.5 * BOUND, 0.1, 0.1]]), "beyond it");
        assert_eq!(tester.attempts, 4);
    }
}
