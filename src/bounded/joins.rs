//! Pairs of hulls that may join, the cheapest first: one queue for merging, remerging and the tree of joins.
//!
//! The queue is lazy. A pair enters with an estimate or a lower bound of its cost, and again with what is known
//! better once it has come up. A pair one of whose hulls has joined another is skipped when it comes up.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use crate::geometry::vector::Vector;

/// Two hulls by their indices.
pub(super) type Pair = (u32, u32);

/// A pair of indices as a key: the smaller one first.
pub(super) fn ordered(a: u32, b: u32) -> Pair {
    (a.min(b), a.max(b))
}

/// Whether two bounding boxes, given by their corners, are at most `gap` apart along each axis.
pub(super) fn are_near(a: [Vector; 2], b: [Vector; 2], gap: f64) -> bool {
    (0..3).all(|k| a[0][k] <= b[1][k] + gap && b[0][k] <= a[1][k] + gap)
}

/// A number with a total order.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cost(pub f64);

impl PartialEq for Cost {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Cost {}
impl PartialOrd for Cost {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Cost {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0)
    }
}

/// A pair that may join. Candidates are compared by cost, equal costs by pair.
#[derive(Debug, Clone)]
pub(super) struct CandidatePair<C, K> {
    pub cost: C,
    pub pair: Pair,
    /// What has been found out about the joint hull.
    pub known: K,
}

impl<C: Ord, K> PartialEq for CandidatePair<C, K> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl<C: Ord, K> Eq for CandidatePair<C, K> {}
impl<C: Ord, K> PartialOrd for CandidatePair<C, K> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl<C: Ord, K> Ord for CandidatePair<C, K> {
    fn cmp(&self, other: &Self) -> Ordering {
        self.cost.cmp(&other.cost).then_with(|| self.pair.cmp(&other.pair))
    }
}

/// The candidates, and which hulls are left. Joint hulls get the next indices.
pub(super) struct PairQueue<C, K> {
    heap: BinaryHeap<Reverse<CandidatePair<C, K>>>,
    is_left: Vec<bool>,
}

impl<C: Ord, K> PairQueue<C, K> {
    /// No pairs of `count` hulls.
    pub(super) fn new(count: usize) -> Self {
        Self { heap: BinaryHeap::new(), is_left: vec![true; count] }
    }

    pub(super) fn is_left(&self, hull: u32) -> bool {
        self.is_left[hull as usize]
    }

    /// The hulls that are left, ascending.
    pub(super) fn left(&self) -> impl Iterator<Item = u32> + '_ {
        (0..).zip(&self.is_left).filter(|(_, is_left)| **is_left).map(|(hull, _)| hull)
    }

    pub(super) fn push(&mut self, cost: C, pair: Pair, known: K) {
        self.heap.push(Reverse(CandidatePair { cost, pair, known }));
    }

    /// Takes out the cheapest pair of hulls that are left.
    pub(super) fn pop(&mut self) -> Option<CandidatePair<C, K>> {
        while let Some(Reverse(candidate)) = self.heap.pop() {
            if self.are_left(&candidate) {
                return Some(candidate);
            }
        }
        None
    }

    /// Takes out all pairs of hulls that are left, the cheapest first.
    pub(super) fn take_sorted(&mut self) -> Vec<CandidatePair<C, K>> {
        let all = std::mem::take(&mut self.heap).into_iter().map(|Reverse(candidate)| candidate);
        let mut sorted: Vec<CandidatePair<C, K>> =
            all.filter(|entry| self.are_left(entry)).collect();
        sorted.sort_unstable();
        sorted
    }

    /// Two hulls give way to their joint hull. Returns its index.
    pub(super) fn join(&mut self, (a, b): Pair) -> u32 {
        self.is_left[a as usize] = false;
        self.is_left[b as usize] = false;
        self.is_left.push(true);
        self.is_left.len() as u32 - 1
    }

    fn are_left(&self, candidate: &CandidatePair<C, K>) -> bool {
        self.is_left(candidate.pair.0) && self.is_left(candidate.pair.1)
    }
}

impl<C: Ord, K> Extend<CandidatePair<C, K>> for PairQueue<C, K> {
    fn extend<I: IntoIterator<Item = CandidatePair<C, K>>>(&mut self, candidates: I) {
        self.heap.extend(candidates.into_iter().map(Reverse));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cheapest_pair_of_hulls_that_are_left_comes_first() {
        let mut queue = PairQueue::new(4);
        for (cost, pair) in [(2.0, (0, 3)), (1.0, (1, 2)), (1.0, (0, 1)), (0.5, (2, 3))] {
            queue.push(Cost(cost), pair, ());
        }
        assert_eq!(queue.pop().map(|candidate| candidate.pair), Some((2, 3)));
        assert_eq!(queue.join((2, 3)), 4);
        queue.push(Cost(f64::NEG_INFINITY), (1, 4), ());
        assert_eq!(queue.left().collect::<Vec<u32>>(), [0, 1, 4]);
        let pairs: Vec<Pair> = queue.take_sorted().iter().map(|entry| entry.pair).collect();
        assert_eq!(pairs, [(1, 4), (0, 1)]);
        assert!(queue.pop().is_none());
    }
}
