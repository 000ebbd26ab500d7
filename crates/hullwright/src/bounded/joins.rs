//! Pairs of hulls that may join, the cheapest first: one queue for merging, remerging and the tree
//! of joins.
//!
//! The queue is lazy. A pair enters with an estimate or a lower bound of its cost, and again with
//! what is known better once it has come up. A pair one of whose hulls has joined another is
//! skipped when it comes up.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use crate::geometry::vector::Vector;
use crate::sorting::sort_by_number;

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

/// All pairs of boxes that are near, in no order. Boxes are sorted along one axis, so that those
/// which lie apart on it are never compared.
pub(super) fn near_pairs(boxes: &[(u32, [Vector; 2])], gap: f64) -> Vec<Pair> {
    let mut order: Vec<(f64, usize)> = boxes.iter().map(|(_, [min, _])| min.x).zip(0..).collect();
    sort_by_number(&mut order);
    let mut pairs = Vec::new();
    for (place, &(_, first)) in order.iter().enumerate() {
        let (first, corners) = boxes[first];
        for &(low, second) in &order[place + 1..] {
            if low > corners[1].x + gap {
                break;
            }
            let (second, others) = boxes[second];
            if are_near(corners, others, gap) {
                pairs.push(ordered(first, second));
            }
        }
    }
    pairs
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

/// The pairs by cost, equal costs by pair, with what is known of their joint hulls; and which hulls
/// are left. A pair is in the queue once.
pub(super) struct PairQueue<C, K> {
    pairs: BTreeMap<(C, Pair), K>,
    is_left: Vec<bool>,
}

impl<C: Ord, K> PairQueue<C, K> {
    /// No pairs of `count` hulls.
    pub(super) fn new(count: usize) -> Self {
        Self { pairs: BTreeMap::new(), is_left: vec![true; count] }
    }

    pub(super) fn is_left(&self, hull: u32) -> bool {
        self.is_left[hull as usize]
    }

    /// The hulls that are left, ascending.
    pub(super) fn left(&self) -> impl Iterator<Item = u32> + '_ {
        (0..).zip(&self.is_left).filter(|(_, is_left)| **is_left).map(|(hull, _)| hull)
    }

    pub(super) fn push(&mut self, cost: C, pair: Pair, known: K) {
        self.pairs.insert((cost, pair), known);
    }

    /// Takes out the cheapest pair of hulls that are left.
    pub(super) fn pop(&mut self) -> Option<(C, Pair, K)> {
        while let Some(((cost, pair), known)) = self.pairs.pop_first() {
            if self.are_left(pair) {
                return Some((cost, pair, known));
            }
        }
        None
    }

    /// Takes out all pairs of hulls that are left, the cheapest first.
    pub(super) fn pop_all(&mut self) -> Vec<(C, Pair, K)> {
        let all = std::mem::take(&mut self.pairs).into_iter();
        let left = all.filter(|((_, pair), _)| self.are_left(*pair));
        left.map(|((cost, pair), known)| (cost, pair, known)).collect()
    }

    /// Replaces two hulls by their joint hull. Returns its index, the next one.
    pub(super) fn join(&mut self, (a, b): Pair) -> u32 {
        self.is_left[a as usize] = false;
        self.is_left[b as usize] = false;
        self.is_left.push(true);
        self.is_left.len() as u32 - 1
    }

    fn are_left(&self, (a, b): Pair) -> bool {
        self.is_left(a) && self.is_left(b)
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
        assert_eq!(queue.pop().map(|(_, pair, ())| pair), Some((2, 3)));
        assert_eq!(queue.join((2, 3)), 4);
        queue.push(Cost(f64::NEG_INFINITY), (1, 4), ());
        assert_eq!(queue.left().collect::<Vec<u32>>(), [0, 1, 4]);
        let pairs: Vec<Pair> = queue.pop_all().into_iter().map(|(_, pair, ())| pair).collect();
        assert_eq!(pairs, [(1, 4), (0, 1)]);
        assert!(queue.pop().is_none());
    }

    #[test]
    fn boxes_are_near_if_no_axis_has_a_wider_gap_between_them() {
        let unit = [Vector::ZERO, Vector::ONE];
        let beside = |x: f64, y: f64| unit.map(|corner| corner + Vector::new(x, y, 0.0));
        for (x, y, expected) in
            [(1.1, 0.0, true), (1.1, 1.1, true), (1.3, 0.0, false), (0.5, -1.3, false)]
        {
            assert_eq!(are_near(unit, beside(x, y), 0.2), expected, "{x}, {y}");
            assert_eq!(are_near(beside(x, y), unit, 0.2), expected, "{x}, {y}");
        }
    }

    #[test]
    fn near_pairs_are_those_of_all_pairs_that_are_near() {
        let corner = |k: u32| Vector::new(f64::from(k * 7 % 11), f64::from(k * 5 % 13), 0.0);
        let boxes: Vec<(u32, [Vector; 2])> =
            (0..40).map(|k| (k, [corner(k), corner(k) + Vector::ONE])).collect();
        let all = boxes.iter().flat_map(|a| boxes.iter().map(move |b| (a, b)));
        let near = all.filter(|(a, b)| a.0 < b.0 && are_near(a.1, b.1, 1.0));
        let expected: Vec<Pair> = near.map(|(a, b)| (a.0, b.0)).collect();
        let mut found = near_pairs(&boxes, 1.0);
        found.sort_unstable();
        assert_eq!(found, expected);
        assert!(found.len() > 40 && found.len() < 40 * 39 / 2);
    }

    #[test]
    fn a_pair_is_the_same_either_way_round() {
        assert_eq!([ordered(3, 5), ordered(5, 3)], [(3, 5); 2]);
    }
}
