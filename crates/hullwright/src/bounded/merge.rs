//! Merging: pieces join in pairs, cheapest first, as long as the joint hull fits.
//!
//! Takes the seeds of the patches, gives pieces. Greedy agglomeration: first neighbours across an
//! edge, then all pieces that are near each other. The cost of a pair is the volume that its joint
//! hull adds, as a share of its own: with the added volume itself there are 7 % more hulls. O(k²)
//! pairs for k pieces of the first round.

use std::collections::{BTreeMap, BTreeSet};

use super::joins::{Cost, Pair, PairQueue, near_pairs, ordered};
use super::patch::{PatchSet, Patches, Piece};
use super::search::Search;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::Vector;
use crate::hull::growing_hull::GrowingHull;
use crate::parallel;
use crate::solid::FitTester;

/// Joins the seeds of patches into pieces.
pub(crate) fn merge(search: &Search<'_>) -> Result<Vec<Piece>, Error> {
    let mut merging = Merging::new(search)?;
    merging.run(search.control)?;
    merging.consider_near();
    merging.run(search.control)?;
    Ok(merging.pieces.into_iter().flatten().collect())
}

/// A joint hull, and whether only its new faces can protrude.
struct Joint {
    hull: GrowingHull,
    only_new: bool,
}

/// A pair's cost, and whether it is known or an estimate. It is only computed once the estimate is
/// the cheapest: before that, most pairs lose one of the two to another. Joint hulls are not kept,
/// since a tangle has a million pairs.
type Queue = PairQueue<Cost, bool>;

/// The state of merging. Pieces keep their index; those that have joined another are `None`.
struct Merging<'a> {
    patches: &'a Patches,
    tester: FitTester<'a>,
    pieces: Vec<Option<Piece>>,
    /// For each piece those beside it, with the last known cost of joining them.
    links: Vec<BTreeMap<u32, f64>>,
    /// Pairs that can't join: what contains both can't either.
    refused: BTreeSet<Pair>,
    queue: Queue,
    /// Pieces farther apart do not join.
    widest_gap: f64,
}

impl<'a> Merging<'a> {
    /// A piece for each seed; neighbours across an edge are candidates.
    fn new(search: &Search<'a>) -> Result<Self, Error> {
        let patches = search.patches;
        let (count, seeds) = (patches.count(), &patches.seeds);
        let mut seed_of_patch = vec![0; count];
        for (seed, members) in (0..).zip(seeds) {
            members.iter().for_each(|&patch| seed_of_patch[patch as usize] = seed);
        }
        let pieces = parallel::map(seeds, |members| {
            search.control.check()?;
            let mut piece = Piece::new(patches, &PatchSet::new(count, members.iter().copied()));
            piece.vertices = piece.hull.vertices();
            Ok(Some(piece))
        });
        let mut merging = Self {
            patches,
            tester: FitTester::new(search.solid, search.settings.bound.search()),
            pieces: pieces.into_iter().collect::<Result<_, Error>>()?,
            links: vec![BTreeMap::new(); seeds.len()],
            refused: BTreeSet::new(),
            queue: PairQueue::new(seeds.len()),
            widest_gap: search.settings.widest_gap(search.settings.bound.search()),
        };
        let pairs =
            patches.neighbours.iter().map(|&(a, b)| [a, b].map(|p| seed_of_patch[p as usize]));
        let pairs: BTreeSet<Pair> = pairs.map(|[a, b]| ordered(a, b)).collect();
        for (a, b) in pairs.into_iter().filter(|&(a, b)| a != b) {
            merging.link(a, b, 0.0);
            merging.consider(a, b, f64::NEG_INFINITY);
        }
        Ok(merging)
    }

    /// Makes all pairs of near pieces candidates.
    fn consider_near(&mut self) {
        let corners = |index: u32| {
            let piece = self.pieces[index as usize].as_ref()?;
            Some((index, [piece.hull.min, piece.hull.max]))
        };
        let boxes: Vec<(u32, [Vector; 2])> = self.queue.left().filter_map(corners).collect();
        for (a, b) in near_pairs(&boxes, self.widest_gap) {
            self.link(a, b, f64::NEG_INFINITY);
            self.consider(a, b, f64::NEG_INFINITY);
        }
    }

    fn pieces(&self, (a, b): Pair) -> Option<(&Piece, &Piece)> {
        Some((self.pieces[a as usize].as_ref()?, self.pieces[b as usize].as_ref()?))
    }

    fn link(&mut self, a: u32, b: u32, cost: f64) {
        self.links[a as usize].insert(b, cost);
        self.links[b as usize].insert(a, cost);
    }

    /// Makes a pair a candidate unless it is known that it can't join.
    fn consider(&mut self, a: u32, b: u32, cost: f64) {
        let pair = ordered(a, b);
        if !self.refused.contains(&pair) {
            self.queue.push(Cost(cost), pair, false);
        }
    }

    /// The cost of a pair, and its joint hull; `None` if there are conflicts between the two.
    fn evaluated(&self, pair: Pair) -> Option<(f64, Joint)> {
        let (a, b) = self.pieces(pair)?;
        let conflicts = &self.patches.conflicts;
        if a.patches.iter().any(|patch| conflicts[patch as usize].intersects(&b.patches)) {
            return None;
        }
        // The smaller hull is inserted into the larger one.
        let (large, small) = if a.hull.volume >= b.hull.volume { (a, b) } else { (b, a) };
        let mut hull = large.hull.clone();
        let only_new = hull.insert(&small.vertices, small.hull.outward);
        hull.volume = hull.current_volume();
        let added = hull.volume - a.hull.volume - b.hull.volume;
        let cost = if hull.volume > 0.0 { added / hull.volume } else { 0.0 };
        Some((cost, Joint { hull, only_new }))
    }

    fn add_cost(&mut self, pair: Pair, cost: Option<f64>) {
        let Some(cost) = cost else {
            self.refused.insert(pair);
            return;
        };
        self.link(pair.0, pair.1, cost);
        self.queue.push(Cost(cost), pair, true);
    }

    /// Joins the cheapest pairs first. At the start all candidates are evaluated, since nothing is
    /// known of their costs.
    fn run(&mut self, control: &Control) -> Result<(), Error> {
        let pairs: Vec<Pair> = self.queue.pop_all().into_iter().map(|(_, pair, _)| pair).collect();
        let costs = parallel::map(&pairs, |&pair| {
            control.check()?;
            Ok(self.evaluated(pair).map(|(cost, _)| cost))
        });
        for (pair, cost) in pairs.into_iter().zip(costs) {
            self.add_cost(pair, cost?);
        }
        while let Some((_, pair, is_known)) = self.queue.pop() {
            control.check()?;
            let evaluated = self.evaluated(pair);
            match evaluated {
                Some((cost, _)) if !is_known => self.add_cost(pair, Some(cost)),
                Some((_, joint)) if self.tester.fits(&joint.hull, joint.only_new) => {
                    self.join(pair, joint.hull);
                }
                _ => {
                    self.refused.insert(pair);
                }
            }
        }
        Ok(())
    }

    /// Replaces two pieces by one.
    fn join(&mut self, (a, b): Pair, mut hull: GrowingHull) {
        let (Some(first), Some(second)) =
            (self.pieces[a as usize].take(), self.pieces[b as usize].take())
        else {
            return;
        };
        let mut patches = first.patches;
        patches.union_with(&second.patches);
        let vertices = hull.vertices();
        self.pieces.push(Some(Piece { patches, hull, vertices }));
        let new = self.queue.join((a, b));
        let mut joined = std::mem::take(&mut self.links[a as usize]);
        for (link, cost) in std::mem::take(&mut self.links[b as usize]) {
            let known = joined.entry(link).or_insert(cost);
            *known = known.min(cost);
        }
        joined.retain(|&link, _| self.queue.is_left(link));
        self.links.push(BTreeMap::new());
        for (link, cost) in joined {
            if self.refused.contains(&ordered(a, link)) || self.refused.contains(&ordered(b, link))
            {
                self.refused.insert((link, new));
            }
            self.link(link, new, cost);
            self.consider(link, new, cost);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounded::fixture::{Fixture, cubes, l_prism, times_in, u_prism};
    use crate::mesh::shapes::{cuboid, torus};

    fn merged(fixture: &Fixture) -> Vec<Piece> {
        merge(&fixture.search()).unwrap()
    }

    #[test]
    fn a_box_is_one_piece() {
        assert_eq!(merged(&Fixture::new(&cuboid([0.0; 3], [1.0, 2.0, 3.0]), 0.02)).len(), 1);
    }

    #[test]
    fn boxes_apart_never_merge() {
        assert_eq!(merged(&Fixture::new(&cubes([0.0, 1.5, 3.0]), 0.02)).len(), 3);
    }

    #[test]
    fn boxes_with_a_crack_between_them_merge() {
        // Not neighbours: the second round joins them.
        let fixture = Fixture::new(&cubes([0.0, 1.02, 2.04]), 0.02);
        assert!(fixture.patches.neighbours.is_empty());
        assert_eq!(merged(&fixture).len(), 1);
    }

    #[test]
    fn pieces_farther_apart_than_the_widest_gap_are_no_candidates() {
        // The joint hull would fit: no point of it is farther from a cube than half the gap.
        let gap = 0.06;
        let fixture = Fixture::new(&cubes([0.0, 1.0 + gap]), 0.02);
        let bound = fixture.settings.bound.search();
        let gap = gap / fixture.prepared.normalization.diagonal;
        assert!(bound < gap && 0.5 * gap < bound);
        assert_eq!(merged(&fixture).len(), 2);
    }

    #[test]
    fn prisms_have_a_piece_for_each_convex_part() {
        for (mesh, parts) in [(l_prism(), 2), (u_prism(), 3)] {
            assert_eq!(merged(&Fixture::new(&mesh, 0.02)).len(), parts);
        }
    }

    #[test]
    fn each_patch_is_in_one_piece_and_each_piece_fits() {
        for mesh in [l_prism(), u_prism(), torus(24, 12)] {
            let fixture = Fixture::new(&mesh, 0.03);
            let pieces = merged(&fixture);
            let count = fixture.patches.count();
            assert!(pieces.len() < count);
            assert_eq!(times_in(count, pieces.iter().map(|piece| &piece.patches)), vec![1; count]);
            let bound = fixture.settings.bound.search();
            let mut tester = FitTester::new(&fixture.solids.coarse, bound);
            assert!(pieces.iter().all(|piece| tester.fits(&piece.hull, false)));
        }
    }

    #[test]
    fn no_piece_contains_a_conflict() {
        let fixture = Fixture::new(&torus(24, 12), 0.03);
        let conflicts = &fixture.patches.conflicts;
        assert!(conflicts.iter().any(|conflicts| !conflicts.is_empty()));
        for Piece { patches, .. } in merged(&fixture) {
            assert!(patches.iter().all(|patch| !conflicts[patch as usize].intersects(&patches)));
        }
    }

    #[test]
    fn a_pair_costs_the_share_of_its_joint_hull_that_it_adds() {
        let fixture = Fixture::new(&cubes([0.0, 1.25]), 0.5);
        let merging = Merging::new(&fixture.search()).unwrap();
        let (cost, joint) = merging.evaluated((0, 1)).unwrap();
        assert!((cost - 0.25 / 2.25).abs() < 1e-6, "{cost}");
        assert!(joint.only_new);
    }

    #[test]
    fn a_pair_with_a_conflict_has_no_cost() {
        let fixture = Fixture::new(&cubes([0.0, 3.0]), 0.02);
        assert!(fixture.patches.conflicts[0].contains(1));
        assert!(Merging::new(&fixture.search()).unwrap().evaluated((0, 1)).is_none());
    }

    #[test]
    fn what_refuses_a_piece_refuses_the_one_that_it_has_joined() {
        let fixture = Fixture::new(&cubes([0.0, 1.02, 2.5]), 0.02);
        let mut merging = Merging::new(&fixture.search()).unwrap();
        for (a, b) in [(0, 1), (1, 2)] {
            merging.link(a, b, 0.0);
        }
        merging.refused.insert((1, 2));
        let (_, joint) = merging.evaluated((0, 1)).unwrap();
        merging.join((0, 1), joint.hull);
        assert!(merging.refused.contains(&(2, 3)) && merging.queue.pop().is_none());
        assert!(merging.pieces[0].is_none() && merging.pieces[1].is_none());
        assert_eq!(merging.pieces[3].as_ref().unwrap().patches, fixture.set([0, 1]));
    }
}
