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

    fn add(&mut self, [a, b, c]: [u32; 3]) {
        self.partners[a as usize].push([b, c]);
        if b != a {
            self.partners[b as usize].push([a, c]);
        }
        if c != b {
            self.partners[c as usize].push([a, b]);
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
