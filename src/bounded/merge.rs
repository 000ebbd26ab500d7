//! Merging: pieces join best-first, as long as the joint hull fits.

use std::cmp::Ordering;
use std::collections::{BTreeSet, BinaryHeap};

use super::piece::{Hull, Piece, Workshop};
use super::seed_set::SeedSet;
use super::seeds::Seeds;
use crate::{Control, Error};

/// Two pieces that may join.
struct Candidate {
    cost: f64,
    pair: (u32, u32),
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
    links: Vec<BTreeSet<u32>>,
    refused: BTreeSet<(u32, u32)>,
    heap: BinaryHeap<Candidate>,
}

fn ordered(a: u32, b: u32) -> (u32, u32) {
    (a.min(b), a.max(b))
}

impl Merging<'_, '_> {
    fn join(&mut self, a: u32, b: u32) -> Option<bool> {
        let (Some(a), Some(b)) = (&self.pieces[a as usize], &self.pieces[b as usize]) else {
            return None;
        };
        // The smaller one joins the larger one.
        let (large, small) = if a.hull.volume >= b.hull.volume { (a, b) } else { (b, a) };
        Some(self.shop.join(&large.hull, &small.vertices, small.hull.outward))
    }

    /// Adds those pairs that may join to the heap.
    fn consider(&mut self, pairs: &[(u32, u32)]) {
        let cost = |&(a, b): &(u32, u32)| {
            let pair = ordered(a, b);
            let (Some(a), Some(b)) =
                (self.pieces[pair.0 as usize].as_ref(), self.pieces[pair.1 as usize].as_ref())
            else {
                return None;
            };
            let may_join = !self.refused.contains(&pair)
                && !self.conflicts[pair.0 as usize].intersects(&b.seeds);
            if !may_join {
                return None;
            }
            let (large, small) = if a.hull.volume >= b.hull.volume { (a, b) } else { (b, a) };
            let mut joint = large.hull.clone();
            joint.insert(&small.vertices, small.hull.outward);
            let volume = joint.current_volume();
            let added = volume - a.hull.volume - b.hull.volume;
            Some(Candidate { cost: if volume > 0.0 { added / volume } else { 0.0 }, pair })
        };
        let candidates = super::parallel::map(pairs, cost);
        self.heap.extend(candidates.into_iter().flatten());
    }

    fn run(&mut self, control: &Control) -> Result<(), Error> {
        while let Some(Candidate { pair, .. }) = self.heap.pop() {
            control.check()?;
            if control.is_past_deadline() {
                break;
            }
            let (a, b) = pair;
            let Some(only_new) = self.join(a, b) else { continue };
            if !self.shop.trial_fits(only_new) {
                self.refused.insert(pair);
                continue;
            }
            let (Some(pa), Some(pb)) =
                (self.pieces[a as usize].take(), self.pieces[b as usize].take())
            else {
                continue;
            };
            let mut seeds = pa.seeds;
            seeds.unite(&pb.seeds);
            let mut hull = pa.hull;
            self.shop.take_trial(&mut hull);
            hull.volume = hull.current_volume();
            let vertices = hull.vertices();
            let new = self.pieces.len() as u32;
            self.pieces.push(Some(Piece { seeds, hull, vertices }));
            let mut conflicts = std::mem::take(&mut self.conflicts[a as usize]);
            conflicts.unite(&self.conflicts[b as usize]);
            self.conflicts.push(conflicts);
            let joined: BTreeSet<u32> = self.links[a as usize]
                .union(&self.links[b as usize])
                .copied()
                .filter(|&link| self.pieces[link as usize].is_some())
                .collect();
            for &link in &joined {
                if self.refused.contains(&ordered(a, link))
                    || self.refused.contains(&ordered(b, link))
                {
                    self.refused.insert((link, new));
                }
                self.links[link as usize].insert(new);
            }
            self.links.push(joined.clone());
            let pairs: Vec<(u32, u32)> = joined.into_iter().map(|link| (link, new)).collect();
            self.consider(&pairs);
        }
        Ok(())
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
    let pieces = seeds.seeds.iter().enumerate().map(|(index, seed)| {
        let mut hull = Hull::of(&seed.points, seed.outward);
        let vertices = hull.vertices();
        Some(Piece { seeds: SeedSet::of(count, [index as u32]), hull, vertices })
    });
    let mut links = vec![BTreeSet::new(); count];
    for &(a, b) in &seeds.neighbours {
        links[a as usize].insert(b);
        links[b as usize].insert(a);
    }
    let mut merging = Merging {
        pieces: pieces.collect(),
        conflicts: seeds.conflicts.clone(),
        links,
        refused: BTreeSet::new(),
        heap: BinaryHeap::new(),
        shop,
    };
    merging.consider(&seeds.neighbours);
    merging.run(control)?;
    let alive: Vec<u32> = (0..merging.pieces.len() as u32)
        .filter(|&index| merging.pieces[index as usize].is_some())
        .collect();
    let mut pairs = Vec::new();
    for (index, &a) in alive.iter().enumerate() {
        for &b in &alive[index + 1..] {
            if let (Some(pa), Some(pb)) = (&merging.pieces[a as usize], &merging.pieces[b as usize])
                && near(&pa.hull, &pb.hull, merging.shop.bound)
            {
                merging.links[a as usize].insert(b);
                merging.links[b as usize].insert(a);
                pairs.push((a, b));
            }
        }
    }
    merging.consider(&pairs);
    merging.run(control)?;
    Ok(merging.pieces.into_iter().flatten().collect())
}
