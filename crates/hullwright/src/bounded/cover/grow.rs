//! Growing: a piece takes the patches that fit, nearest first. O(patches) distances and fit tests
//! for each 15 % of its volume.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::nogoods::Learning;
use crate::bounded::joins::Cost;
use crate::bounded::patch::{Patch, PatchSet, Patches, Piece};
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::Vector;
use crate::hull::growing_hull::{EarlierFaces, GrowingHull};
use crate::solid::FitTester;

/// Maximum number of patches that are tried at once; 64 are no faster.
const MAX_BATCH: usize = 16;

/// A patch that protrudes from a hull by less than this fraction of the diagonal counts as
/// contained. Less than what a final hull may leave uncovered (5 % of the bound) for bounds from
/// 0.6 % on.
const CONTAINED_TOLERANCE: f64 = 3e-4;

/// Growth of the hull's volume after which the patches are ordered anew: a trade of the time to
/// compute all distances again for an order that follows the hull.
const REORDER: f64 = 1.15;

/// Patches that are refused one after the other before a piece stops growing: the nearest are tried
/// first, and few that come later fit.
const MAX_REFUSED_IN_TURN: usize = 8;

/// What pieces grow by, and what was learned from refusals.
pub(super) struct Grower<'a> {
    pub patches: &'a Patches,
    pub tester: FitTester<'a>,
    pub learning: Learning<'a>,
    pub control: &'a Control,
}

impl Grower<'_> {
    /// Whether a hull of a set of patches and another one may fit, by conflicts and nogoods.
    pub(super) fn may_take(&self, set: &PatchSet, patch: u32) -> bool {
        !self.patches.conflicts[patch as usize].intersects(set) && !self.learning.refuse(set, patch)
    }

    /// Grows a piece by the patches of `wanted` that fit, in order of distance, until many in turn
    /// do not.
    ///
    /// As long as batches fit, they double: faces that would only exist between one patch and the
    /// next are never tested.
    pub(super) fn grow(&mut self, piece: &mut Piece, wanted: &PatchSet) -> Result<(), Error> {
        let mut open = wanted.clone();
        open.difference_with(&piece.patches);
        for patch in piece.patches.iter() {
            open.difference_with(&self.patches.conflicts[patch as usize]);
        }
        Growth { grower: self, piece, open }.run()
    }
}

/// A piece that is growing.
struct Growth<'a, 'b> {
    grower: &'a mut Grower<'b>,
    piece: &'a mut Piece,
    /// The patches that may still be taken.
    open: PatchSet,
}

impl Growth<'_, '_> {
    fn run(&mut self) -> Result<(), Error> {
        let patches = self.grower.patches;
        let mut batch_size = 1;
        let mut batch: Vec<u32> = Vec::new();
        let mut refused_in_turn = 0;
        let mut order = Order::default();
        while !self.open.is_empty() {
            order.start(&self.piece.hull, patches, &self.open);
            let ordered_at = self.piece.hull.current_volume();
            while self.piece.hull.current_volume() <= REORDER * ordered_at {
                batch.clear();
                let mut together = self.piece.patches.clone();
                while let Some(index) = order.next(patches) {
                    if !self.open.contains(index) {
                        continue;
                    }
                    if contains(&self.piece.hull, &patches[index]) {
                        self.accept(index);
                        together.insert(index);
                        continue;
                    }
                    if !self.grower.may_take(&together, index) {
                        if batch.is_empty() {
                            self.open.remove(index);
                            refused_in_turn += 1;
                            if refused_in_turn >= MAX_REFUSED_IN_TURN {
                                return Ok(());
                            }
                        }
                        continue;
                    }
                    batch.push(index);
                    together.insert(index);
                    if batch.len() == batch_size {
                        break;
                    }
                }
                if batch.is_empty() {
                    break;
                }
                let before = self.piece.patches.count();
                let fits = self.insert(&batch)?;
                let has_grown = self.piece.patches.count() > before;
                refused_in_turn = if has_grown { 0 } else { refused_in_turn + batch.len() };
                if refused_in_turn >= MAX_REFUSED_IN_TURN {
                    return Ok(());
                }
                batch_size = if fits { (2 * batch_size).min(MAX_BATCH) } else { 1 };
            }
        }
        Ok(())
    }

    /// Inserts those patches of a batch that fit, by bisection. Returns whether all did at once.
    fn insert(&mut self, batch: &[u32]) -> Result<bool, Error> {
        self.grower.control.check()?;
        if self.may_take_all(batch) {
            let patches = self.grower.patches;
            let parts = batch.iter().map(|&index| {
                let Patch { points, outward, .. } = &patches[index];
                (&points[..], *outward)
            });
            if self.grower.tester.try_insert(&mut self.piece.hull, parts) {
                batch.iter().for_each(|&index| self.accept(index));
                return Ok(true);
            }
            let Grower { tester, learning, .. } = &mut *self.grower;
            tester.refusals().iter().for_each(|refusal| learning.learn(refusal));
        }
        if let &[index] = batch {
            self.open.remove(index);
            return Ok(false);
        }
        let (first, second) = batch.split_at(batch.len() / 2);
        self.insert(first)?;
        let second: Vec<u32> =
            second.iter().copied().filter(|&index| self.open.contains(index)).collect();
        if !second.is_empty() {
            self.insert(&second)?;
        }
        Ok(false)
    }

    /// Whether the hull with all of a batch may fit.
    fn may_take_all(&self, batch: &[u32]) -> bool {
        let mut together = self.piece.patches.clone();
        batch.iter().all(|&index| {
            let may_take = self.grower.may_take(&together, index);
            together.insert(index);
            may_take
        })
    }

    /// Adds a patch to the piece's set, and closes it and its conflicts.
    fn accept(&mut self, index: u32) {
        self.piece.patches.insert(index);
        self.open.remove(index);
        self.open.difference_with(&self.grower.patches.conflicts[index as usize]);
    }
}

/// Patches in the order of their distances from a hull, by their representatives.
///
/// Few of the patches are tried before the hull has grown and they are ordered anew. So most
/// distances are bounded by some of the hull's faces, and computed only where the bound is the
/// least.
#[derive(Default)]
struct Order {
    faces: EarlierFaces,
    /// The nearest first. Of equal distances bounds come first, then lower indices.
    heap: BinaryHeap<Reverse<(Cost, bool, u32)>>,
}

impl Order {
    fn start(&mut self, hull: &GrowingHull, patches: &Patches, open: &PatchSet) {
        let middle = |min: Vector, max: Vector| (min + max) * 0.5;
        let centre = middle(hull.min, hull.max);
        if hull.is_solid {
            self.faces.copy_from(&hull.builder);
        }
        let entry = |index: u32| {
            let patch = &patches[index];
            let distance = match hull.is_solid {
                true => self.faces.least_outside(&patch.representatives),
                false => centre.distance(middle(patch.min, patch.max)),
            };
            Reverse((Cost(distance), !hull.is_solid, index))
        };
        self.heap = open.iter().map(entry).collect::<Vec<_>>().into();
    }

    /// Takes out the nearest patch.
    fn next(&mut self, patches: &Patches) -> Option<u32> {
        loop {
            let Reverse((_, is_exact, index)) = self.heap.pop()?;
            if is_exact {
                return Some(index);
            }
            let distance = self.faces.farthest_outside(&patches[index].representatives);
            self.heap.push(Reverse((Cost(distance), true, index)));
        }
    }
}

fn contains(hull: &GrowingHull, patch: &Patch) -> bool {
    (0..3).all(|k| {
        patch.min[k] >= hull.min[k] - CONTAINED_TOLERANCE
            && patch.max[k] <= hull.max[k] + CONTAINED_TOLERANCE
    }) && hull.contains(&patch.points, CONTAINED_TOLERANCE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounded::cover::nogoods::{Nogoods, PointsOfPatches};
    use crate::bounded::fixture::{Fixture, cubes, l_prism, u_prism};
    use crate::mesh::shapes::torus;

    /// A piece of some patches after it has grown by those of a set.
    fn grown(fixture: &Fixture, piece: &[u32], wanted: &PatchSet) -> Piece {
        let points = PointsOfPatches::new(&fixture.patches);
        let nogoods = Nogoods::new(&points, fixture.patches.count());
        let bound = fixture.settings.bound.search();
        let mut grower = Grower {
            patches: &fixture.patches,
            tester: FitTester::new(&fixture.solids.coarse, bound),
            learning: Learning::after(&nogoods),
            control: &fixture.control,
        };
        let mut piece = fixture.piece(piece.iter().copied());
        grower.grow(&mut piece, wanted).unwrap();
        piece
    }

    #[test]
    fn a_box_takes_the_one_behind_a_crack_and_not_the_one_behind_a_gap() {
        let fixture = Fixture::new(&cubes([0.0, 1.02, 3.0]), 0.02);
        let piece = grown(&fixture, &[0], &fixture.patches.all());
        assert_eq!(piece.patches, fixture.set([0, 1]));
        assert!(piece.hull.contains(&fixture.patches[1].points, 1e-4));
    }

    #[test]
    fn only_patches_of_the_given_set_are_taken() {
        let fixture = Fixture::new(&cubes([0.0, 1.02, 2.04]), 0.02);
        let piece = grown(&fixture, &[0], &fixture.set([1]));
        assert_eq!(piece.patches, fixture.set([0, 1]));
    }

    #[test]
    fn a_patch_within_the_hull_is_taken_without_a_test() {
        let fixture = Fixture::new(&cubes([0.0, 1.02, 2.04]), 0.02);
        let points = PointsOfPatches::new(&fixture.patches);
        let nogoods = Nogoods::new(&points, fixture.patches.count());
        let mut grower = Grower {
            patches: &fixture.patches,
            tester: FitTester::new(&fixture.solids.coarse, fixture.settings.bound.search()),
            learning: Learning::after(&nogoods),
            control: &fixture.control,
        };
        let mut piece = fixture.piece([0, 2]);
        grower.grow(&mut piece, &fixture.patches.all()).unwrap();
        assert_eq!(piece.patches, fixture.patches.all());
        assert_eq!(grower.tester.attempts, 0);
    }

    #[test]
    fn what_has_grown_fits_and_holds_no_conflict() {
        for mesh in [l_prism(), u_prism(), torus(24, 12)] {
            let fixture = Fixture::new(&mesh, 0.03);
            let conflicts = &fixture.patches.conflicts;
            let bound = fixture.settings.bound.search();
            let mut tester = FitTester::new(&fixture.solids.coarse, bound);
            let mut most = 0;
            for start in (0..fixture.patches.count() as u32).step_by(5) {
                let piece = grown(&fixture, &[start], &fixture.patches.all());
                assert!(tester.fits(&piece.hull, false), "{start}");
                let mut members = piece.patches.iter();
                assert!(members.all(|patch| !conflicts[patch as usize].intersects(&piece.patches)));
                for patch in piece.patches.iter() {
                    assert!(
                        !piece.hull.is_solid
                            || piece.hull.contains(&fixture.patches[patch].points, 1e-3)
                    );
                }
                most = most.max(piece.patches.count());
            }
            assert!(most > 1);
        }
    }

    #[test]
    fn patches_come_in_the_order_of_their_distance_from_the_hull() {
        let fixture = Fixture::new(&cubes([0.0, 1.5, 3.5, 6.0, 9.0]), 0.02);
        for (start, expected) in [(0, [1, 2, 3, 4]), (4, [3, 2, 1, 0]), (2, [1, 3, 0, 4])] {
            let mut open = fixture.patches.all();
            open.remove(start);
            let mut order = Order::default();
            order.start(&fixture.piece([start]).hull, &fixture.patches, &open);
            let found: Vec<u32> = std::iter::from_fn(|| order.next(&fixture.patches)).collect();
            assert_eq!(found, expected, "{start}");
        }
    }

    #[test]
    fn a_cancelled_piece_is_an_error() {
        let fixture = Fixture::new(&cubes([0.0, 1.02]), 0.02);
        let points = PointsOfPatches::new(&fixture.patches);
        let nogoods = Nogoods::new(&points, 2);
        let control = Control::new();
        control.cancel();
        let mut grower = Grower {
            patches: &fixture.patches,
            tester: FitTester::new(&fixture.solids.coarse, 0.02),
            learning: Learning::after(&nogoods),
            control: &control,
        };
        let mut piece = fixture.piece([0]);
        assert_eq!(grower.grow(&mut piece, &fixture.patches.all()), Err(Error::Cancelled));
    }
}
