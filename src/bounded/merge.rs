//! Merging: pieces join in pairs, cheapest first, as long as the joint hull fits.
//!
//! Greedy agglomeration with a lazy priority queue. The cost of a pair is the volume that its joint
//! hull adds, as a share of its own: with the added volume itself there are 7 % more hulls.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};

use super::containment::fit_tester::FitTester;
use super::growing_hull::GrowingHull;
use super::patch_set::PatchSet;
use super::patches::conflicts::Conflicts;
use super::patches::patch::Patches;
use super::piece::Piece;
use super::search::Search;
use crate::control::Control;
use crate::error::Error;
use crate::parallel;

/// Two pieces that may join.
struct Candidate {
    /// Volume that the joint hull adds, as a share of its own; an earlier estimate as long as there
    /// is no joint hull.
    cost: f64,
    pair: (u32, u32),
    joint: Option<Box<Joint>>,
}

/// A joint hull, and whether only its new faces can protrude.
struct Joint {
    hull: GrowingHull,
    only_new: bool,
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Candidate {}
impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Candidate {
    /// The cheapest is the greatest, since the heap is a max-heap.
    fn cmp(&self, other: &Self) -> Ordering {
        other.cost.total_cmp(&self.cost).then_with(|| other.pair.cmp(&self.pair))
    }
}

/// The state of merging. Pieces keep their index; those that have joined another are `None`.
struct Merging<'a, 'b> {
    tester: &'a mut FitTester<'b>,
    conflicts: &'a Conflicts<'b>,
    pieces: Vec<Option<Piece>>,
    /// For each piece those beside it, with the last known cost of joining them.
    links: Vec<BTreeMap<u32, f64>>,
    refused: BTreeSet<(u32, u32)>,
    heap: BinaryHeap<Candidate>,
}

fn ordered(a: u32, b: u32) -> (u32, u32) {
    (a.min(b), a.max(b))
}

impl<'a, 'b> Merging<'a, 'b> {
    /// A piece for each block; neighbours across an edge are candidates.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    fn new(
        patches: &Patches,
        conflicts: &'a Conflicts<'b>,
        tester: &'a mut FitTester<'b>,
        control: &Control,
    ) -> Result<Self, Error> {
        let (count, blocks) = (patches.count(), conflicts.agreeing(&patches.blocks));
        let mut block_of = vec![0; count];
        for (block, members) in (0..).zip(&blocks) {
            members.iter().for_each(|&patch| block_of[patch as usize] = block);
        }
        let pieces = parallel::map(&blocks, |members| {
            control.check()?;
            let mut piece = Piece::new(patches, &PatchSet::of(count, members.iter().copied()));
            piece.vertices = piece.hull.vertices();
            Ok(Some(piece))
        });
        let pieces = pieces.into_iter().collect::<Result<Vec<Option<Piece>>, Error>>()?;
        let mut neighbours: Vec<(u32, u32)> = patches
            .neighbours
            .iter()
            .map(|&(a, b)| ordered(block_of[a as usize], block_of[b as usize]))
            .collect();
        neighbours.sort_unstable();
        neighbours.dedup();
        neighbours.retain(|&(a, b)| a != b);
        let mut merging = Self {
            pieces,
            conflicts,
            links: vec![BTreeMap::new(); blocks.len()],
            refused: BTreeSet::new(),
            heap: BinaryHeap::new(),
            tester,
        };
        for (a, b) in neighbours {
            merging.links[a as usize].insert(b, 0.0);
            merging.links[b as usize].insert(a, 0.0);
            merging.consider(a, b, f64::NEG_INFINITY);
        }
        Ok(merging)
    }

    /// Makes all pairs of near pieces candidates.
    fn consider_near(&mut self) {
        let alive: Vec<u32> = (0..self.pieces.len() as u32)
            .filter(|&index| self.pieces[index as usize].is_some())
            .collect();
        for (index, &a) in alive.iter().enumerate() {
            for &b in &alive[index + 1..] {
                if let (Some(first), Some(second)) =
                    (&self.pieces[a as usize], &self.pieces[b as usize])
                    && are_near(&first.hull, &second.hull, self.tester.bound())
                {
                    self.links[a as usize].insert(b, f64::NEG_INFINITY);
                    self.links[b as usize].insert(a, f64::NEG_INFINITY);
                    self.consider(a, b, f64::NEG_INFINITY);
                }
            }
        }
    }

    /// Adds a pair to the heap unless it is known that it can't join.
    fn consider(&mut self, a: u32, b: u32, cost: f64) {
        let pair = ordered(a, b);
        if !self.refused.contains(&pair) {
            self.heap.push(Candidate { cost, pair, joint: None });
        }
    }

    /// The candidate with its joint hull; `None` if there are conflicts between the two.
    fn evaluated(&self, pair: (u32, u32)) -> Option<Candidate> {
        let (a, b) =
            (self.pieces[pair.0 as usize].as_ref()?, self.pieces[pair.1 as usize].as_ref()?);
        if self.conflicts.between_sets(&a.patches, &b.patches) {
            return None;
        }
        // The smaller hull is inserted into the larger one.
        let (large, small) = if a.hull.volume >= b.hull.volume { (a, b) } else { (b, a) };
        let mut hull = large.hull.clone();
        let only_new = hull.insert(&small.vertices, small.hull.outward);
        hull.volume = hull.current_volume();
        let added = hull.volume - a.hull.volume - b.hull.volume;
        let cost = if hull.volume > 0.0 { added / hull.volume } else { 0.0 };
        Some(Candidate { cost, pair, joint: Some(Box::new(Joint { hull, only_new })) })
    }

    /// Evaluates all candidates at once: at the start nothing tells which are the cheapest.
    fn evaluate_all(&mut self, control: &Control) -> Result<(), Error> {
        let pairs: Vec<(u32, u32)> = self.heap.drain().map(|candidate| candidate.pair).collect();
        let evaluated = parallel::map(&pairs, |&pair| {
            control.check()?;
            Ok(self.evaluated(pair))
        });
        for (pair, candidate) in pairs.into_iter().zip(evaluated) {
            self.add_evaluated(pair, candidate?);
        }
        Ok(())
    }

    fn add_evaluated(&mut self, (a, b): (u32, u32), candidate: Option<Candidate>) {
        let Some(candidate) = candidate else {
            self.refused.insert((a, b));
            return;
        };
        self.links[a as usize].insert(b, candidate.cost);
        self.links[b as usize].insert(a, candidate.cost);
        self.heap.push(candidate);
    }

    fn is_alive(&self, (a, b): (u32, u32)) -> bool {
        self.pieces[a as usize].is_some() && self.pieces[b as usize].is_some()
    }

    /// Joins neighbours, then pieces that are near each other.
    fn run_to_end(&mut self, control: &Control) -> Result<(), Error> {
        self.run(control)?;
        self.consider_near();
        self.run(control)
    }

    /// Joins the cheapest pairs first. After the start, a joint hull is only built once its pair's estimate is the
    /// cheapest: before that, most pairs lose one of the two to another. Building or testing several of these at
    /// once on all threads takes as long: waking a thread costs what it saves.
    fn run(&mut self, control: &Control) -> Result<(), Error> {
        self.evaluate_all(control)?;
        while let Some(Candidate { pair, joint, .. }) = self.heap.pop() {
            if !self.is_alive(pair) {
                continue;
            }
            let Some(joint) = joint else {
                control.check()?;
                let candidate = self.evaluated(pair);
                self.add_evaluated(pair, candidate);
                continue;
            };
            if self.tester.fits(&joint.hull, joint.only_new) {
                self.join(pair, joint.hull);
            } else {
                self.refused.insert(pair);
            }
        }
        Ok(())
    }

    /// Replaces two pieces by one.
    fn join(&mut self, (a, b): (u32, u32), mut hull: GrowingHull) {
        let (Some(first), Some(second)) =
            (self.pieces[a as usize].take(), self.pieces[b as usize].take())
        else {
            return;
        };
        let mut patches = first.patches;
        patches.union_with(&second.patches);
        let vertices = hull.vertices();
        let new = self.pieces.len() as u32;
        self.pieces.push(Some(Piece { patches, hull, vertices, inner_points: Vec::new() }));
        let mut joined = std::mem::take(&mut self.links[a as usize]);
        for (link, cost) in std::mem::take(&mut self.links[b as usize]) {
            let known = joined.entry(link).or_insert(cost);
            *known = known.min(cost);
        }
        joined.retain(|&link, _| self.pieces[link as usize].is_some());
        for (&link, &cost) in &joined {
            if self.refused.contains(&ordered(a, link)) || self.refused.contains(&ordered(b, link))
            {
                self.refused.insert((link, new));
            }
            self.links[link as usize].insert(new, cost);
        }
        self.links.push(joined.clone());
        for (link, cost) in joined {
            self.consider(link, new, cost);
        }
    }
}

/// Whether the bounding boxes of two hulls are at most `gap` apart along each axis.
fn are_near(a: &GrowingHull, b: &GrowingHull, gap: f64) -> bool {
    (0..3).all(|k| a.min[k] <= b.max[k] + gap && b.min[k] <= a.max[k] + gap)
}

/// Merges patches into pieces, and on other threads meanwhile finds all conflicts between patches.
///
/// # Errors
/// [`Error::Cancelled`].
pub(crate) fn merge_patches(search: &Search<'_>) -> Result<(Vec<Piece>, Vec<PatchSet>), Error> {
    let &Search { solid, patches, settings, control } = search;
    let bound = settings.bound.search();
    let conflicts = Conflicts::new(patches, solid, bound);
    let mut tester = FitTester::new(solid, bound);
    let (pieces, all_conflicts) = parallel::join(
        || merge(patches, &conflicts, &mut tester, control),
        || conflicts.all(control),
    );
    Ok((pieces?, all_conflicts?))
}

/// Joins the blocks of patches into pieces: first neighbours across an edge, then all that are near
/// each other. O(k²) pairs for k pieces of the first round.
///
/// # Errors
/// [`Error::Cancelled`].
fn merge<'a>(
    patches: &Patches,
    conflicts: &Conflicts<'a>,
    tester: &mut FitTester<'a>,
    control: &Control,
) -> Result<Vec<Piece>, Error> {
    let mut merging = Merging::new(patches, conflicts, tester, control)?;
    let done = merging.run_to_end(control);
    let Merging { pieces, heap, links, refused, .. } = merging;
    parallel::drop_aside((heap, links, refused));
    done.map(|()| pieces.into_iter().flatten().collect())
}
