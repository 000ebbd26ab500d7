//! Nogoods: patches that no hull that fits contains together, learned from hulls that did not fit.
//!
//! A hull is refused where a face protrudes. Its corners are points of patches, and every hull that contains these
//! three points contains the protruding point: it does not fit either, or it swallows a point that is outside the solid by
//! more than the bound. So the three patches are a conflict of three, where [`Patches::conflicts`] are of two. A nogood
//! refuses a hull before anything is built. The word is that of constraint solving, as is learning from refusals.
//!
//! What is learned depends on the hull alone, not on what the cache of faces knows. Attempts at the same time do
//! not learn from each other: what they have learned is added in their order. So no result depends on threads.

use std::collections::{HashMap, HashSet};

use crate::bounded::patch::{PatchSet, Patches};
use crate::geometry::vector::Vector;
use crate::solid::{Refusal, Solid};

/// The patches that have a point.
pub(super) struct PatchesOfPoints(HashMap<[u64; 3], Vec<u32>>);

impl PatchesOfPoints {
    pub(super) fn new(patches: &Patches) -> Self {
        let mut of_points: HashMap<[u64; 3], Vec<u32>> = HashMap::new();
        for (index, patch) in (0..).zip(&patches.patches) {
            for &point in &patch.points {
                let of_point = of_points.entry(key(point)).or_default();
                if of_point.last() != Some(&index) {
                    of_point.push(index);
                }
            }
        }
        Self(of_points)
    }

    fn of(&self, point: Vector) -> &[u32] {
        self.0.get(&key(point)).map_or(&[], Vec::as_slice)
    }
}

fn key(point: Vector) -> [u64; 3] {
    point.to_array().map(f64::to_bits)
}

/// See the module.
pub(super) struct Nogoods<'a> {
    of_points: &'a PatchesOfPoints,
    /// For each patch the pairs of others, or twice the same, with which it does not fit.
    partners: Vec<Vec<[u32; 2]>>,
    known: HashSet<[u32; 3]>,
    refusals: Vec<Refusal>,
}

impl<'a> Nogoods<'a> {
    /// None yet, for a number of patches.
    pub(super) fn new(of_points: &'a PatchesOfPoints, count: usize) -> Self {
        let partners = vec![Vec::new(); count];
        Self { of_points, partners, known: HashSet::new(), refusals: Vec::new() }
    }

    /// Those that hold under a larger bound too.
    pub(super) fn under(&self, solid: &Solid, bound: f64) -> Self {
        let mut nogoods = Self::new(self.of_points, self.partners.len());
        let held = self.refusals.iter().filter(|refusal| !solid.point_fits(refusal.point, bound));
        held.for_each(|refusal| nogoods.learn(refusal));
        nogoods
    }

    /// Whether no hull of a set of patches and another one fits.
    pub(super) fn refuse(&self, set: &PatchSet, patch: u32) -> bool {
        self.partners[patch as usize].iter().any(|&[a, b]| set.contains(a) && set.contains(b))
    }

    pub(super) fn learn(&mut self, refusal: &Refusal) {
        let [first, second, third] = refusal.face.map(|corner| self.of_points.of(corner));
        let mut is_new = false;
        for &a in first {
            for &b in second {
                for &c in third {
                    let mut nogood = [a, b, c];
                    nogood.sort_unstable();
                    if self.known.insert(nogood) {
                        is_new = true;
                        self.add(nogood);
                    }
                }
            }
        }
        if is_new {
            self.refusals.push(refusal.clone());
        }
    }

    fn add(&mut self, nogood: [u32; 3]) {
        for (place, &patch) in nogood.iter().enumerate() {
            // A patch that has two of the corners brings both.
            let mut others = nogood.iter().copied().filter(|&other| other != patch);
            if let Some(first) = others.next()
                && !nogood[..place].contains(&patch)
            {
                let second = others.next().unwrap_or(first);
                self.partners[patch as usize].push([first, second]);
            }
        }
    }
}

/// The nogoods that are known before some attempts, and those that one of them learns.
pub(super) struct Learning<'a> {
    before: &'a Nogoods<'a>,
    learned: Nogoods<'a>,
}

impl<'a> Learning<'a> {
    pub(super) fn after(before: &'a Nogoods<'a>) -> Self {
        let learned = Nogoods::new(before.of_points, before.partners.len());
        Self { before, learned }
    }

    pub(super) fn refuse(&self, set: &PatchSet, patch: u32) -> bool {
        self.before.refuse(set, patch) || self.learned.refuse(set, patch)
    }

    pub(super) fn learn(&mut self, refusal: &Refusal) {
        self.learned.learn(refusal);
    }

    /// What was learned.
    pub(super) fn into_refusals(self) -> Vec<Refusal> {
        self.learned.refusals
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounded::patch::Patch;
    use crate::control::Control;
    use crate::mesh::shapes::cuboid;
    use crate::solid::Boundary;

    const COUNT: usize = 5;

    /// Points on the x-axis; patch k has the points k and k + 1.
    fn patches() -> Patches {
        let point = |x: usize| Vector::new(x as f64, 0.0, 0.0);
        let patch = |k: usize| Patch { points: vec![point(k), point(k + 1)], ..Patch::default() };
        Patches {
            patches: (0..COUNT).map(patch).collect(),
            neighbours: Vec::new(),
            seeds: Vec::new(),
            conflicts: vec![PatchSet::empty(COUNT); COUNT],
            surface: Default::default(),
            parents: Default::default(),
            mesh: Default::default(),
            labels: Vec::new(),
        }
    }

    fn refusal(corners: [f64; 3]) -> Refusal {
        let face = corners.map(|x| Vector::new(x, 0.0, 0.0));
        Refusal { face, point: face[0] + Vector::Y }
    }

    #[test]
    fn three_patches_are_refused_that_have_the_corners_of_a_face_and_no_two_of_them() {
        let of_points = PatchesOfPoints::new(&patches());
        let mut nogoods = Nogoods::new(&of_points, COUNT);
        // The corners of patch 0 alone, of 1 and 2, and of 4 alone.
        nogoods.learn(&refusal([0.0, 2.0, 5.0]));
        let refuse =
            |set: &[u32], patch| nogoods.refuse(&PatchSet::new(COUNT, set.iter().copied()), patch);
        for middle in [1, 2] {
            assert!(refuse(&[0, middle], 4) && refuse(&[0, 4], middle) && refuse(&[middle, 4], 0));
            assert!(!refuse(&[0, 4], 3) && !refuse(&[middle], 4) && !refuse(&[0], middle));
        }
    }

    #[test]
    fn a_patch_with_two_corners_of_a_face_is_refused_with_one_that_has_the_third() {
        let of_points = PatchesOfPoints::new(&patches());
        let mut nogoods = Nogoods::new(&of_points, COUNT);
        nogoods.learn(&refusal([0.0, 4.0, 5.0]));
        assert!(nogoods.refuse(&PatchSet::new(COUNT, [0]), 4));
        assert!(nogoods.refuse(&PatchSet::new(COUNT, [4]), 0));
        assert!(!nogoods.refuse(&PatchSet::new(COUNT, [1, 2]), 0));
    }

    #[test]
    fn what_was_learned_by_an_attempt_is_known_to_the_next_once_it_is_added() {
        let of_points = PatchesOfPoints::new(&patches());
        let mut nogoods = Nogoods::new(&of_points, COUNT);
        let set = PatchSet::new(COUNT, [0]);
        let mut learning = Learning::after(&nogoods);
        learning.learn(&refusal([0.0, 4.0, 5.0]));
        assert!(learning.refuse(&set, 4) && !nogoods.refuse(&set, 4));
        let refusals = learning.into_refusals();
        refusals.iter().for_each(|refusal| nogoods.learn(refusal));
        assert!(Learning::after(&nogoods).refuse(&set, 4));
    }

    #[test]
    fn nogoods_hold_under_a_larger_bound_where_the_point_still_protrudes() {
        let of_points = PatchesOfPoints::new(&patches());
        let mut nogoods = Nogoods::new(&of_points, COUNT);
        nogoods.learn(&Refusal { point: Vector::new(0.5, 0.5, 1.05), ..refusal([0.0, 4.0, 5.0]) });
        let cube = cuboid([0.0; 3], [1.0; 3]);
        let boundary = Boundary::default();
        let control = Control::new();
        let solid =
            Solid::of_surface(cube.points(), &cube.triangles, boundary, 0.04, &control).unwrap();
        let set = PatchSet::new(COUNT, [0]);
        assert!(nogoods.under(&solid, 0.04).refuse(&set, 4));
        assert!(!nogoods.under(&solid, 0.06).refuse(&set, 4));
    }
}
