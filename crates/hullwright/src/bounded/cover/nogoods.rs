//! Nogoods: three points of patches that no hull that fits contains together, learned from hulls
//! that did not fit.
//!
//! A hull is refused where a face protrudes. The corners are points of patches, and every hull that
//! contains these three points contains the protruding point: it does not fit either, or it
//! swallows a point that is outside the solid by more than the bound. So they are a conflict of
//! three, where [`Patches::conflicts`] are of two. A nogood refuses a hull before anything is
//! built: O(1) for each that the new patch is part of. The word is that of constraint solving.
//!
//! The nogoods of an attempt depend only on the hulls that it tests. Concurrent attempts do not see
//! each other's: they are added afterwards, in the order of the attempts. So no result depends on
//! threads.

use std::collections::{HashMap, HashSet};

use crate::bounded::patch::{Patch, PatchSet, Patches};
use crate::geometry::vector::Vector;
use crate::solid::{Refusal, Solid};

/// Of a patch with more nogoods, the points of a set are looked up at once. Crossing triangles
/// teach thousands.
const MANY: usize = 64;

/// The points of patches. Neighbours share points, so a nogood of patches would be several.
pub(super) struct PointsOfPatches {
    /// By their coordinates.
    indices: HashMap<[u64; 3], u32>,
    /// For each point the patches that have it, ascending.
    patches: Vec<Vec<u32>>,
    /// For each patch its points.
    of_patch: Vec<Vec<u32>>,
}

impl PointsOfPatches {
    pub(super) fn new(patches: &Patches) -> Self {
        let mut points =
            Self { indices: HashMap::new(), patches: Vec::new(), of_patch: Vec::new() };
        for (patch, Patch { points: of_patch, .. }) in (0..).zip(&patches.patches) {
            let mut own = Vec::with_capacity(of_patch.len());
            for point in of_patch {
                let next = points.patches.len() as u32;
                let index = *points.indices.entry(key(*point)).or_insert(next);
                if index == next {
                    points.patches.push(Vec::new());
                }
                let patches = &mut points.patches[index as usize];
                if patches.last() != Some(&patch) {
                    patches.push(patch);
                    own.push(index);
                }
            }
            points.of_patch.push(own);
        }
        points
    }

    /// The three corners of a face as points of patches; `None` if one is not.
    fn corners(&self, face: [Vector; 3]) -> Option<[u32; 3]> {
        let [a, b, c] = face.map(|corner| self.indices.get(&key(corner)).copied());
        let mut corners = [a?, b?, c?];
        corners.sort_unstable();
        Some(corners)
    }

    /// The patches that have a point.
    fn patches_with(&self, point: u32) -> &[u32] {
        &self.patches[point as usize]
    }

    fn is_in(&self, point: u32, set: &PatchSet) -> bool {
        self.patches_with(point).iter().any(|&patch| set.contains(patch))
    }
}

fn key(point: Vector) -> [u64; 3] {
    point.to_array().map(f64::to_bits)
}

/// See the module.
pub(super) struct Nogoods<'a> {
    points: &'a PointsOfPatches,
    /// For each patch the pairs of points, or twice the same, with which no hull of it fits.
    partners: Vec<Vec<[u32; 2]>>,
    known: HashSet<[u32; 3]>,
    /// The first that led to each, in order.
    refusals: Vec<Refusal>,
}

impl<'a> Nogoods<'a> {
    /// None yet, for a number of patches.
    pub(super) fn new(points: &'a PointsOfPatches, count: usize) -> Self {
        let partners = vec![Vec::new(); count];
        Self { points, partners, known: HashSet::new(), refusals: Vec::new() }
    }

    /// Those that hold under a larger bound too.
    pub(super) fn under(&self, solid: &Solid, bound: f64) -> Self {
        let mut nogoods = Self::new(self.points, self.partners.len());
        let held = self.refusals.iter().filter(|refusal| !solid.point_fits(refusal.point, bound));
        held.for_each(|refusal| nogoods.learn(refusal));
        nogoods
    }

    /// Whether no hull of a set of patches and another one fits. O(nogoods of the patch).
    pub(super) fn refuse(&self, set: &PatchSet, patch: u32) -> bool {
        let (points, partners) = (self.points, &self.partners[patch as usize]);
        if partners.len() <= MANY {
            return partners.iter().any(|&[a, b]| points.is_in(a, set) && points.is_in(b, set));
        }
        let mut is_in = vec![false; points.patches.len()];
        for patch in set.iter() {
            points.of_patch[patch as usize].iter().for_each(|&point| is_in[point as usize] = true);
        }
        partners.iter().any(|&[a, b]| is_in[a as usize] && is_in[b as usize])
    }

    /// Learns from a face that protrudes. A face is no nogood unless its corners are points of
    /// patches: those of a flat hull that was thickened are not.
    pub(super) fn learn(&mut self, refusal: &Refusal) {
        let Some(corners) = self.points.corners(refusal.face) else { return };
        if !self.known.insert(corners) {
            return;
        }
        self.refusals.push(refusal.clone());
        let points = self.points;
        for (place, &corner) in corners.iter().enumerate() {
            for patch in points.patches_with(corner) {
                let is_missing = |&&other: &&u32| !points.patches_with(other).contains(patch);
                let is_known = !corners[..place].iter().all(|corner| is_missing(&corner));
                let mut missing = corners.iter().filter(is_missing).copied();
                // A patch that has all three corners does not fit, and is covered all the same.
                if let Some(first) = missing.next()
                    && !is_known
                {
                    let second = missing.next().unwrap_or(first);
                    self.partners[*patch as usize].push([first, second]);
                }
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
        let learned = Nogoods::new(before.points, before.partners.len());
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
    use crate::control::Control;
    use crate::mesh::shapes::cuboid;
    use crate::solid::Boundary;
    #[cfg(feature = "parallel")]
    use crate::{
        bounded::{
            cover::{dissolve::dissolve, grow_all},
            merge::merge,
            patch_mesh::PatchMesh,
            patches::divide_into_patches,
            search::Search,
            settings::Settings,
            surfaces::{simplify, solids},
        },
        mesh::{
            canonical_order::MeshOrder,
            repair::prepare,
            shapes::{join, torus},
        },
        parameters::{Length, Parameters},
    };

    const COUNT: usize = 5;

    /// Points on the x-axis; patch k has the points k and k + 1.
    fn patches() -> Patches {
        let point = |x: usize| Vector::new(x as f64, 0.0, 0.0);
        let patch = |k: usize| Patch { points: vec![point(k), point(k + 1)], ..Patch::default() };
        Patches {
            patches: (0..COUNT).map(patch).collect(),
            are_across_folds: false,
            neighbours: Vec::new(),
            seeds: Vec::new(),
            conflicts: vec![PatchSet::empty(COUNT); COUNT],
            surface: Default::default(),
            parents: Default::default(),
            detail: Default::default(),
            mesh: Default::default(),
            labels: Vec::new(),
        }
    }

    fn unit_cube() -> Solid {
        let cube = cuboid([0.0; 3], [1.0; 3]);
        let boundary = Boundary::default();
        Solid::of_surface(cube.points(), &cube.triangles, boundary, 0.04, &Control::new()).unwrap()
    }

    fn refusal(corners: [f64; 3]) -> Refusal {
        let face = corners.map(|x| Vector::new(x, 0.0, 0.0));
        Refusal { face, point: face[0] + Vector::Y }
    }

    #[test]
    fn three_patches_are_refused_that_have_the_corners_of_a_face_and_no_two_of_them() {
        let points = PointsOfPatches::new(&patches());
        let mut nogoods = Nogoods::new(&points, COUNT);
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
        let points = PointsOfPatches::new(&patches());
        let mut nogoods = Nogoods::new(&points, COUNT);
        nogoods.learn(&refusal([0.0, 4.0, 5.0]));
        assert!(nogoods.refuse(&PatchSet::new(COUNT, [0]), 4));
        assert!(nogoods.refuse(&PatchSet::new(COUNT, [4]), 0));
        assert!(!nogoods.refuse(&PatchSet::new(COUNT, [1, 2]), 0));
    }

    #[test]
    fn what_was_learned_by_an_attempt_is_known_to_the_next_once_it_is_added() {
        let points = PointsOfPatches::new(&patches());
        let mut nogoods = Nogoods::new(&points, COUNT);
        let set = PatchSet::new(COUNT, [0]);
        let mut learning = Learning::after(&nogoods);
        learning.learn(&refusal([0.0, 4.0, 5.0]));
        assert!(learning.refuse(&set, 4) && !nogoods.refuse(&set, 4));
        let refusals = learning.into_refusals();
        refusals.iter().for_each(|refusal| nogoods.learn(refusal));
        assert!(Learning::after(&nogoods).refuse(&set, 4));
    }

    #[test]
    fn a_face_with_a_corner_that_is_no_point_of_a_patch_is_no_nogood() {
        let points = PointsOfPatches::new(&patches());
        let mut nogoods = Nogoods::new(&points, COUNT);
        nogoods.learn(&refusal([0.0, 4.0, 5.5]));
        assert!(nogoods.refusals.is_empty());
        assert!(
            (0..COUNT as u32).all(|k| !nogoods.refuse(&PatchSet::new(COUNT, 0..COUNT as u32), k))
        );
    }

    #[test]
    fn nogoods_hold_under_a_larger_bound_where_the_point_still_protrudes() {
        let points = PointsOfPatches::new(&patches());
        let solid = unit_cube();
        let set = PatchSet::new(COUNT, [0]);
        let [near, far] = [1.05, 1.5]
            .map(|z| Refusal { point: Vector::new(0.5, 0.5, z), ..refusal([0.0, 4.0, 5.0]) });
        // Of two reasons for one nogood the first is kept: attempts are added in their order.
        for (reasons, holds) in [([&near, &far], false), ([&far, &near], true)] {
            let mut nogoods = Nogoods::new(&points, COUNT);
            reasons.into_iter().for_each(|refusal| nogoods.learn(refusal));
            assert!(nogoods.under(&solid, 0.04).refuse(&set, 4));
            assert_eq!(nogoods.under(&solid, 0.06).refuse(&set, 4), holds);
        }
    }

    /// The corners of all nogoods in the order in which they were learned, and the patches of the
    /// pieces.
    #[cfg(feature = "parallel")]
    fn learned_on(threads: usize) -> (Vec<[Vector; 3]>, Vec<PatchSet>) {
        let mesh = join(&[torus(48, 24), cuboid([0.2, 0.2, -0.1], [0.5, 0.6, 0.9])]);
        let parameters = Parameters::default().with_max_error(Length::share(0.007));
        let control = Control::new();
        let prepared = prepare(mesh.view(), MeshOrder::Place, &control).unwrap();
        let settings = &Settings::of_preset(&parameters, &prepared.normalization)[0];
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let surfaces = simplify(&prepared, None, settings, &control).unwrap();
            let solids = solids(&surfaces, None, settings, &control).unwrap();
            let divided =
                PatchMesh::new(&surfaces.coarse, &solids.coarse, settings, &control).unwrap();
            let patches =
                &divide_into_patches(divided, &surfaces, &solids.coarse, settings, &control)
                    .unwrap();
            let search = &Search::new(&surfaces, &solids, patches, settings, &control);
            let points = PointsOfPatches::new(patches);
            let mut nogoods = Nogoods::new(&points, patches.count());
            let mut pieces = grow_all(search, merge(search).unwrap(), &mut nogoods).unwrap();
            let (grown, while_growing) = (pieces.len(), nogoods.refusals.len());
            let bound = settings.bound.search();
            dissolve(search, &mut pieces, bound, usize::MAX, &mut nogoods).unwrap();
            assert!(pieces.len() < grown && grown > 8, "{grown} pieces, then {}", pieces.len());
            assert!(while_growing > 0 && nogoods.refusals.len() > while_growing);
            let corners = nogoods.refusals.iter().map(|refusal| refusal.face).collect();
            (corners, pieces.into_iter().map(|piece| piece.patches).collect())
        })
    }

    #[cfg(feature = "parallel")]
    #[test]
    fn the_same_is_learned_in_the_same_order_on_one_two_and_four_threads() {
        let one = learned_on(1);
        for threads in [2, 4] {
            assert!(learned_on(threads) == one, "{threads} threads");
        }
    }
}
