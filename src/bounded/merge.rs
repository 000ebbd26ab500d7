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
        let mut small_hull = small.hull.clone();
        let points = small_hull.vertices();
        Some(self.shop.join(&large.hull, &points, small.hull.outward))
    }

    fn consider(&mut self, a: u32, b: u32) {
        let pair = ordered(a, b);
        let (Some(pa), Some(pb)) = (&self.pieces[a as usize], &self.pieces[b as usize]) else {
            return;
        };
        if self.refused.contains(&pair) || self.conflicts[a as usize].intersects(&pb.seeds) {
            return;
        }
        let volumes = pa.hull.volume + pb.hull.volume;
        if self.join(a, b).is_none() {
            return;
        }
        let volume = self.shop.trial.current_volume();
        let cost = if volume > 0.0 { (volume - volumes) / volume } else { 0.0 };
        self.heap.push(Candidate { cost, pair });
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
            let new = self.pieces.len() as u32;
            self.pieces.push(Some(Piece { seeds, hull }));
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
            for link in joined {
                self.consider(link, new);
            }
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
        Some(Piece {
            seeds: SeedSet::of(count, [index as u32]),
            hull: Hull::of(&seed.points, seed.outward),
        })
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
    for &(a, b) in &seeds.neighbours {
        merging.consider(a, b);
    }
    merging.run(control)?;
    let alive: Vec<u32> = (0..merging.pieces.len() as u32)
        .filter(|&index| merging.pieces[index as usize].is_some())
        .collect();
    for (index, &a) in alive.iter().enumerate() {
        for &b in &alive[index + 1..] {
            if let (Some(pa), Some(pb)) = (&merging.pieces[a as usize], &merging.pieces[b as usize])
                && near(&pa.hull, &pb.hull, merging.shop.bound)
            {
                merging.links[a as usize].insert(b);
                merging.links[b as usize].insert(a);
                merging.consider(a, b);
            }
        }
    }
    merging.run(control)?;
    Ok(merging.pieces.into_iter().flatten().collect())
}
