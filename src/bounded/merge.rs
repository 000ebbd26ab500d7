//! Merging: pieces join best-first, as long as the joint hull fits.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};

use super::cover::hull_of;
use super::piece::{Hull, Piece, Workshop};
use super::seed_set::SeedSet;
use super::seeds::Seeds;
use crate::control::Control;
use crate::error::Error;

/// Two pieces that may join.
struct Candidate {
    /// Volume that the joint hull adds, as a share of its own; a guess as long as there is no
    /// joint hull.
    cost: f64,
    pair: (u32, u32),
    joint: Option<Joint>,
}

/// A joint hull, and whether only its new faces can stand out.
struct Joint {
    hull: Hull,
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
    /// The cheapest is the greatest, as a heap wants it.
    fn cmp(&self, other: &Self) -> Ordering {
        other.cost.total_cmp(&self.cost).then_with(|| other.pair.cmp(&self.pair))
    }
}

struct Merging<'a, 'b> {
    shop: &'a mut Workshop<'b>,
    pieces: Vec<Option<Piece>>,
    /// For each piece those that it must not join.
    conflicts: Vec<SeedSet>,
    /// For each piece those next to it, with the last known cost of joining them.
    links: Vec<BTreeMap<u32, f64>>,
    refused: BTreeSet<(u32, u32)>,
    heap: BinaryHeap<Candidate>,
}

fn ordered(a: u32, b: u32) -> (u32, u32) {
    (a.min(b), a.max(b))
}

impl Merging<'_, '_> {
    /// Adds a pair to the heap if it may join.
    fn consider(&mut self, a: u32, b: u32, cost: f64) {
        let pair = ordered(a, b);
        let Some(other) = &self.pieces[pair.1 as usize] else { return };
        if !self.refused.contains(&pair)
            && !self.conflicts[pair.0 as usize].intersects(&other.seeds)
        {
            self.heap.push(Candidate { cost, pair, joint: None });
        }
    }

    /// The candidate with its joint hull; `None` if one of the two is gone.
    fn evaluated(&self, pair: (u32, u32)) -> Option<Candidate> {
        let (a, b) =
            (self.pieces[pair.0 as usize].as_ref()?, self.pieces[pair.1 as usize].as_ref()?);
        // The smaller one joins the larger one.
        let (large, small) = if a.hull.volume >= b.hull.volume { (a, b) } else { (b, a) };
        let mut hull = large.hull.clone();
        let only_new = hull.insert(&small.vertices, small.hull.outward);
        hull.volume = hull.current_volume();
        let added = hull.volume - a.hull.volume - b.hull.volume;
        let cost = if hull.volume > 0.0 { added / hull.volume } else { 0.0 };
        Some(Candidate { cost, pair, joint: Some(Joint { hull, only_new }) })
    }

    fn is_alive(&self, (a, b): (u32, u32)) -> bool {
        self.pieces[a as usize].is_some() && self.pieces[b as usize].is_some()
    }

    /// Joins the cheapest pairs first. A cost is only a guess until its pair is the cheapest: most
    /// pairs never are before one of the two has joined another piece. (Evaluating several at once, on
    /// all threads, takes as long: waking a thread costs what it saves.)
    fn run(&mut self, control: &Control) -> Result<(), Error> {
        while let Some(Candidate { pair, joint, .. }) = self.heap.pop() {
            if control.is_past_deadline() {
                break;
            }
            if !self.is_alive(pair) {
                continue;
            }
            let Some(joint) = joint else {
                control.check()?;
                if let Some(candidate) = self.evaluated(pair) {
                    let (a, b) = pair;
                    self.links[a as usize].insert(b, candidate.cost);
                    self.links[b as usize].insert(a, candidate.cost);
                    self.heap.push(candidate);
                }
                continue;
            };
            if self.shop.fits(&joint.hull, joint.only_new) {
                self.take(pair, joint.hull);
            } else {
                self.refused.insert(pair);
            }
        }
        Ok(())
    }

    /// Two pieces become one.
    fn take(&mut self, (a, b): (u32, u32), mut hull: Hull) {
        let (Some(first), Some(second)) =
            (self.pieces[a as usize].take(), self.pieces[b as usize].take())
        else {
            return;
        };
        let mut seeds = first.seeds;
        seeds.unite(&second.seeds);
        let vertices = hull.vertices();
        let new = self.pieces.len() as u32;
        self.pieces.push(Some(Piece { seeds, hull, vertices }));
        let mut conflicts = std::mem::take(&mut self.conflicts[a as usize]);
        conflicts.unite(&self.conflicts[b as usize]);
        self.conflicts.push(conflicts);
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

fn near(a: &Hull, b: &Hull, gap: f64) -> bool {
    (0..3).all(|k| a.min[k] <= b.max[k] + gap && b.min[k] <= a.max[k] + gap)
}

/// Joins seeds into pieces: neighbours over an edge first, then all that are near.
pub(crate) fn merge(
    seeds: &Seeds,
    shop: &mut Workshop<'_>,
    control: &Control,
) -> Result<Vec<Piece>, Error> {
    let count = seeds.count();
    let mut block_of = vec![0; count];
    for (block, members) in (0..).zip(&seeds.blocks) {
        members.iter().for_each(|&seed| block_of[seed as usize] = block);
    }
    let pieces = seeds.blocks.iter().map(|members| {
        let mut piece = hull_of(seeds, &SeedSet::of(count, members.iter().copied()));
        piece.vertices = piece.hull.vertices();
        Some(piece)
    });
    let conflicts = seeds.blocks.iter().map(|members| {
        let mut conflicts = SeedSet::none(count);
        members.iter().for_each(|&seed| conflicts.unite(&seeds.conflicts[seed as usize]));
        conflicts
    });
    let mut links = vec![BTreeMap::new(); seeds.blocks.len()];
    let mut neighbours: Vec<(u32, u32)> = seeds
        .neighbours
        .iter()
        .map(|&(a, b)| ordered(block_of[a as usize], block_of[b as usize]))
        .collect();
    neighbours.sort_unstable();
    neighbours.dedup();
    neighbours.retain(|&(a, b)| a != b);
    for &(a, b) in &neighbours {
        links[a as usize].insert(b, 0.0);
        links[b as usize].insert(a, 0.0);
    }
    let mut merging = Merging {
        pieces: pieces.collect(),
        conflicts: conflicts.collect(),
        links,
        refused: BTreeSet::new(),
        heap: BinaryHeap::new(),
        shop,
    };
    for &(a, b) in &neighbours {
        merging.consider(a, b, f64::NEG_INFINITY);
    }
    merging.run(control)?;
    let alive: Vec<u32> = (0..merging.pieces.len() as u32)
        .filter(|&index| merging.pieces[index as usize].is_some())
        .collect();
    for (index, &a) in alive.iter().enumerate() {
        for &b in &alive[index + 1..] {
            if let (Some(first), Some(second)) =
                (&merging.pieces[a as usize], &merging.pieces[b as usize])
                && near(&first.hull, &second.hull, merging.shop.bound)
            {
                merging.links[a as usize].insert(b, f64::NEG_INFINITY);
                merging.links[b as usize].insert(a, f64::NEG_INFINITY);
                merging.consider(a, b, f64::NEG_INFINITY);
            }
        }
    }
    merging.run(control)?;
    Ok(merging.pieces.into_iter().flatten().collect())
}
