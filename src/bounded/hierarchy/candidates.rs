//! Pairs that may join, those with the least protrusion first. Most are only ever known by a lower
//! bound: a joint hull is built and verified once its pair's bound is the least.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::joint::{Node, joint};
use super::lower_bound::{Effort, Witness, find_witness};
use crate::bounded::containment::solid::Solid;
use crate::bounded::settings::Settings;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, add, bounds, scale};
use crate::parallel;

/// How a pair's protrusion is known. Later ones win a tie, so that nothing is verified in vain.
enum Known {
    /// By bridges that its parts had, or by few of its own.
    Roughly,
    /// By many bridges.
    Better,
    Verified(Box<Node>),
}

struct Candidate {
    /// A lower bound, unless it is verified.
    protrusion: f64,
    pair: (usize, usize),
    known: Known,
}

impl Candidate {
    fn is_verified(&self) -> bool {
        matches!(self.known, Known::Verified(_))
    }
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
    /// The least is the greatest, since the heap is a max-heap.
    fn cmp(&self, other: &Self) -> Ordering {
        (other.protrusion.total_cmp(&self.protrusion))
            .then_with(|| self.is_verified().cmp(&other.is_verified()))
            .then_with(|| other.pair.cmp(&self.pair))
    }
}

/// All pairs of hulls that are left.
pub(super) struct Candidates<'a> {
    solid: &'a Solid,
    settings: &'a Settings,
    control: &'a Control,
    heap: BinaryHeap<Candidate>,
    /// The hulls that are left, by their slots; a joint hull takes the slot of its first part.
    slots: Vec<Option<usize>>,
    slot_of: Vec<usize>,
    /// The centre of each hull's box.
    centres: Vec<Vector>,
    /// The best witness of each pair of slots: for each slot one per slot before it.
    witnesses: Vec<Vec<Witness>>,
    /// Joint hulls that were built.
    #[cfg(test)]
    pub built: usize,
}

impl<'a> Candidates<'a> {
    /// All pairs of hulls. O(k²) bounds for k hulls.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn new(
        nodes: &[Node],
        solid: &'a Solid,
        settings: &'a Settings,
        control: &'a Control,
    ) -> Result<Self, Error> {
        let mut candidates = Self {
            solid,
            settings,
            control,
            heap: BinaryHeap::new(),
            slots: (0..nodes.len()).map(Some).collect(),
            slot_of: (0..nodes.len()).collect(),
            centres: nodes.iter().map(centre).collect(),
            witnesses: Vec::new(),
            #[cfg(test)]
            built: 0,
        };
        let rows = parallel::map_indices(nodes.len(), |second| {
            control.check()?;
            let row = (0..second).map(|first| {
                let (witness, bound) = candidates.witness(nodes, (first, second), Effort::Few);
                (witness, bound)
            });
            Ok(row.collect::<Vec<_>>())
        });
        for (second, row) in rows.into_iter().enumerate() {
            let row = row?;
            let pairs = row.iter().enumerate().map(|(first, &(_, bound))| Candidate {
                protrusion: parents_protrusion(nodes, (first, second)).max(bound),
                pair: (first, second),
                known: Known::Roughly,
            });
            candidates.heap.extend(pairs);
            candidates.witnesses.push(row.into_iter().map(|(witness, _)| witness).collect());
        }
        Ok(candidates)
    }

    /// The joint hull that protrudes least, which leaves the candidates; `None` if fewer than two
    /// hulls are left.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn pop(&mut self, nodes: &[Node]) -> Result<Option<Node>, Error> {
        while let Some(Candidate { protrusion, pair, known }) = self.heap.pop() {
            if !self.is_left(pair.0) || !self.is_left(pair.1) {
                continue;
            }
            let candidate = match known {
                Known::Verified(node) => return Ok(Some(*node)),
                Known::Roughly => {
                    let (witness, bound) = self.witness(nodes, pair, Effort::Many);
                    if bound > protrusion {
                        *self.known_witness(pair) = witness;
                    }
                    let protrusion = protrusion.max(bound);
                    Candidate { protrusion, pair, known: Known::Better }
                }
                Known::Better => {
                    self.control.check()?;
                    #[cfg(test)]
                    {
                        self.built += 1;
                    }
                    let node = joint(nodes, pair, self.solid, self.settings, self.control)?;
                    let known = Known::Verified(Box::new(node.clone()));
                    Candidate { protrusion: node.protrusion, pair, known }
                }
            };
            self.heap.push(candidate);
        }
        Ok(None)
    }

    /// Replaces two hulls by their joint hull, the last node. O(k) bounds for k hulls.
    pub fn join(&mut self, nodes: &[Node]) {
        let new = nodes.len() - 1;
        let Some((first, second)) = nodes[new].children else { return };
        self.centres.push(centre(&nodes[new]));
        let [slot, freed] = [first, second].map(|part| self.slot_of[part]);
        self.slot_of.push(slot);
        self.slots[slot] = Some(new);
        self.slots[freed] = None;
        for other in 0..self.slots.len() {
            let Some(node) = self.slots[other].filter(|&node| node != new) else { continue };
            let of_parts = [slot, freed].map(|part| {
                let witness = self.witnesses[part.max(other)][part.min(other)];
                (witness, witness.bound([&nodes[node].hull.points, &nodes[new].hull.points]))
            });
            let [a, b] = of_parts;
            let (witness, bound) = if a.1 >= b.1 { a } else { b };
            self.witnesses[slot.max(other)][slot.min(other)] = witness;
            let pair = (node, new);
            let protrusion = parents_protrusion(nodes, pair).max(bound);
            self.heap.push(Candidate { protrusion, pair, known: Known::Roughly });
        }
    }

    fn is_left(&self, node: usize) -> bool {
        self.slots[self.slot_of[node]] == Some(node)
    }

    fn known_witness(&mut self, pair: (usize, usize)) -> &mut Witness {
        let (a, b) = (self.slot_of[pair.0], self.slot_of[pair.1]);
        &mut self.witnesses[a.max(b)][a.min(b)]
    }

    fn witness(&self, nodes: &[Node], (a, b): (usize, usize), effort: Effort) -> (Witness, f64) {
        let hulls = [&nodes[a].hull.points[..], &nodes[b].hull.points[..]];
        find_witness(hulls, [self.centres[a], self.centres[b]], self.solid, effort)
    }
}

/// A joint hull is not reported to protrude less than its parts.
fn parents_protrusion(nodes: &[Node], (a, b): (usize, usize)) -> f64 {
    nodes[a].protrusion.max(nodes[b].protrusion)
}

fn centre(node: &Node) -> Vector {
    let (min, max) = bounds(node.hull.points.iter().copied());
    scale(add(min, max), 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounded::containment::boundary::Boundary;
    use crate::hull::convex_hull;
    use crate::parameters::Parameters;

    const BOXES: usize = 40;

    /// Boxes along a helix, of unlike sizes.
    fn boxes() -> Vec<Node> {
        let node = |index: usize| {
            let (angle, size) = (0.5 * index as f64, 0.03 + 0.001 * (index * 7 % 11) as f64);
            let corner = [0.3 * angle.cos(), 0.3 * angle.sin(), 0.02 * index as f64];
            let points =
                (0..8).map(|i| [0, 1, 2].map(|k| corner[k] + size * f64::from(i >> k & 1)));
            let hull = convex_hull(&points.collect::<Vec<_>>()).unwrap();
            Node { hull, protrusion: 0.0, growth: 0.0, children: None }
        };
        (0..BOXES).map(node).collect()
    }

    fn solid_of(nodes: &[Node], bound: f64) -> Solid {
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for Node { hull, .. } in nodes {
            let first = positions.len() as u32;
            positions.extend_from_slice(&hull.points);
            triangles.extend(hull.triangles.iter().map(|triangle| triangle.map(|v| v + first)));
        }
        Solid::of_surface(&positions, &triangles, Boundary::default(), bound, &Control::new())
            .unwrap()
    }

    #[test]
    fn the_least_joint_hull_is_found_with_few_that_are_built() {
        let (settings, control) =
            (Settings::after_search(&Parameters::default(), 1.0), Control::new());
        let mut nodes = boxes();
        let solid = solid_of(&nodes, settings.bound.protrusion());
        let mut candidates = Candidates::new(&nodes, &solid, &settings, &control).unwrap();
        let mut left: Vec<usize> = (0..BOXES).collect();
        while let Some(node) = candidates.pop(&nodes).unwrap() {
            let (first, second) = node.children.unwrap();
            // All pairs take long: every fifth time.
            if left.len().is_multiple_of(5) {
                for (index, &b) in left.iter().enumerate() {
                    for &a in &left[..index] {
                        let other = joint(&nodes, (a, b), &solid, &settings, &control).unwrap();
                        assert!(node.protrusion <= other.protrusion, "{a} and {b}");
                    }
                }
            }
            left.retain(|&index| index != first && index != second);
            left.push(nodes.len());
            nodes.push(node);
            candidates.join(&nodes);
        }
        assert_eq!(nodes.len(), 2 * BOXES - 1);
        // All pairs would be 780, and 741 more with the joint hulls.
        assert!(candidates.built <= 5 * BOXES, "{} joint hulls", candidates.built);
    }

    #[test]
    fn a_bound_is_never_above_what_is_verified() {
        let (settings, control) =
            (Settings::after_search(&Parameters::default(), 1.0), Control::new());
        let nodes = boxes();
        let solid = solid_of(&nodes, settings.bound.protrusion());
        let candidates = Candidates::new(&nodes, &solid, &settings, &control).unwrap();
        let mut sum = [0.0; 2];
        for b in 0..BOXES {
            for a in (0..b).step_by(3) {
                let verified = joint(&nodes, (a, b), &solid, &settings, &control).unwrap();
                for effort in [Effort::Few, Effort::Many] {
                    let (_, bound) = candidates.witness(&nodes, (a, b), effort);
                    assert!(bound <= verified.protrusion + 1e-9, "{a} and {b}: {bound}");
                    sum = [sum[0] + bound, sum[1] + verified.protrusion];
                }
            }
        }
        assert!(sum[0] > 0.5 * sum[1], "{sum:?}");
    }
}
