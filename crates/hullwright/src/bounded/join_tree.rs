//! The tree of joins: from hulls on down to one, the pair whose joint hull protrudes least joins
//! first.
//!
//! Each state is a valid result, with an error that is verified like that of the final hulls. Most
//! pairs are only ever known by a lower bound of their joint hull's protrusion: a joint hull is
//! built and verified once its pair's bound is the least. O(k² + k · joins) lower bounds for k
//! hulls, and usually few joint hulls per join. The limit on hulls and
//! [`MergeTree`](crate::MergeTree) stand on it.
//!
//! The lower bounds: a plane that touches two hulls, with both on one side, touches their joint
//! hull along the bridge between them. If a point of the bridge is far outside of the solid, the
//! joint hull protrudes as far. A point below the surface serves as well: the distance to the solid
//! changes no faster than the position, so its depth is subtracted. That makes each bound valid for
//! all hulls that contain the two, once the plane has moved.

use std::collections::HashMap;

use super::joins::{Cost, Pair, PairQueue, ordered};
use super::output::normalized;
use super::settings::Settings;
use super::verifier::Verifier;
use crate::control::Control;
use crate::decomposition::Hull;
use crate::error::Error;
use crate::geometry::vector::{Vector, bounds};
use crate::hull::{ConvexHull, HullBuilder, joint_hull, limit_vertices};
use crate::mesh::PreparedMesh;
use crate::parallel;
use crate::parameters::Parameters;
use crate::solid::Solid;
use crate::solid::protrusion;

/// A hull of the tree, final or joint. Lengths are fractions of the diagonal.
#[derive(Debug, Clone)]
pub(crate) struct Node {
    pub hull: ConvexHull,
    /// No point of its surface is farther than this from the solid.
    pub protrusion: f64,
    /// How far it grew to keep the limit on vertices.
    pub growth: f64,
    /// The nodes that it joins; `None` for a leaf.
    pub joined: Option<Pair>,
}

/// The leaves, then the joint hulls in the order of joining.
#[derive(Debug, Clone, Default)]
pub(crate) struct JoinTree {
    pub nodes: Vec<Node>,
    pub leaves: usize,
}

impl JoinTree {
    /// Joins hulls, each given with its protrusion, until `until` are left.
    pub(super) fn new(
        leaves: Vec<(ConvexHull, f64)>,
        until: usize,
        solid: &Solid,
        settings: &Settings,
        control: &Control,
    ) -> Result<Self, Error> {
        let mut tree = Self { leaves: leaves.len(), nodes: Vec::new() };
        let leaf = |(hull, protrusion)| Node { hull, protrusion, growth: 0.0, joined: None };
        tree.nodes.extend(leaves.into_iter().map(leaf));
        let nodes = &mut tree.nodes;
        let joins = nodes.len().saturating_sub(until.max(1));
        let mut pairs = Pairs::new(nodes, solid, settings, control)?;
        while nodes.len() < tree.leaves + joins {
            let Some(node) = pairs.pop(nodes)? else { break };
            nodes.push(node);
            pairs.join(nodes);
        }
        Ok(tree)
    }

    /// Joins hulls that were returned down to one, and gives their uncovered distance, unless that
    /// is known. The solid is built anew: a decomposition does not keep it.
    pub(crate) fn from_hulls(
        prepared: &PreparedMesh,
        hulls: &[Hull],
        uncovered: Option<f64>,
        parameters: &Parameters,
        control: &Control,
    ) -> Result<(Self, f64), Error> {
        let verifier = Verifier::new(prepared, parameters, control)?;
        let mut leaves = Vec::with_capacity(hulls.len());
        for (index, hull) in hulls.iter().enumerate() {
            let (hull, verified) = normalized(hull, index, &prepared.normalization)?;
            let protrusion = match verified {
                Some(protrusion) => protrusion,
                None => verifier.protrusion(&hull, control)?,
            };
            leaves.push((hull, protrusion));
        }
        let tree = Self::new(leaves, 1, &verifier.solid, &verifier.settings, control)?;
        let uncovered = match uncovered {
            Some(uncovered) => uncovered,
            None => {
                let leaves = tree.nodes[..tree.leaves].iter();
                verifier.uncovered(leaves.map(|node| &node.hull), control)?
            }
        };
        Ok((tree, uncovered))
    }

    /// The number of joins.
    pub(crate) fn joins(&self) -> usize {
        self.nodes.len() - self.leaves
    }

    /// The nodes that are left after some joins.
    pub(crate) fn state(&self, joins: usize) -> Vec<usize> {
        let last = (self.leaves + joins).min(self.nodes.len());
        let mut is_left = vec![true; last];
        for (first, second) in self.nodes[..last].iter().filter_map(|node| node.joined) {
            is_left[first as usize] = false;
            is_left[second as usize] = false;
        }
        (0..last).filter(|&index| is_left[index]).collect()
    }

    /// The leaves below a node, ascending.
    pub(crate) fn leaves_below(&self, node: usize) -> Vec<usize> {
        let mut leaves = Vec::new();
        let mut stack = vec![node];
        while let Some(index) = stack.pop() {
            match self.nodes[index].joined {
                Some((first, second)) => stack.extend([first as usize, second as usize]),
                None => leaves.push(index),
            }
        }
        leaves.sort_unstable();
        leaves
    }
}

/// Of the joint hulls that are built for one join, at most this many may grow to keep the limit on
/// vertices. Lower bounds are computed from the gaps between hulls alone: where joint hulls
/// protrude by their growth, the bounds of all pairs are too low, and all would be built.
const MOST_GROWN: usize = 8;

/// How a pair's protrusion is known.
enum Known {
    /// By bridges that its parts had, or by few of its own.
    Roughly,
    /// By many bridges.
    Better,
    Verified(Box<Node>),
}

/// A lower bound on the joint hull's protrusion, or the verified one. Of equal ones those that are
/// no bound come first, so that nothing is verified in vain.
type ProtrusionOrBound = (Cost, bool);

/// All pairs of hulls that are left.
struct Pairs<'a> {
    solid: &'a Solid,
    settings: &'a Settings,
    control: &'a Control,
    queue: PairQueue<ProtrusionOrBound, Known>,
    /// The centre of each hull's box.
    centres: Vec<Vector>,
    /// The best witness of each pair.
    witnesses: HashMap<Pair, Witness>,
    /// Joint hulls that were built.
    #[cfg(test)]
    built: usize,
}

impl<'a> Pairs<'a> {
    /// All pairs of hulls. O(k²) bounds for k hulls.
    fn new(
        nodes: &[Node],
        solid: &'a Solid,
        settings: &'a Settings,
        control: &'a Control,
    ) -> Result<Self, Error> {
        let mut pairs = Self {
            solid,
            settings,
            control,
            queue: PairQueue::new(nodes.len()),
            centres: nodes.iter().map(centre).collect(),
            witnesses: HashMap::new(),
            #[cfg(test)]
            built: 0,
        };
        let rows = parallel::map_indices(nodes.len(), |second| {
            control.check()?;
            let row = (0..second as u32).map(|first| {
                let pair = (first, second as u32);
                (pair, pairs.find_witness(nodes, pair, Effort::Few))
            });
            Ok(row.collect::<Vec<_>>())
        });
        for row in rows {
            for (pair, (witness, bound)) in row? {
                pairs.witnesses.insert(pair, witness);
                pairs.push_roughly(nodes, pair, bound);
            }
        }
        Ok(pairs)
    }

    /// The joint hull that protrudes least, whose pair leaves the queue; `None` if fewer than two
    /// hulls are left. Where many grow to keep the limit on vertices, the least of some.
    fn pop(&mut self, nodes: &[Node]) -> Result<Option<Node>, Error> {
        let mut grown = 0;
        while let Some(((Cost(protrusion), _), pair, known)) = self.queue.pop() {
            match known {
                Known::Verified(node) => return Ok(Some(*node)),
                Known::Roughly => {
                    let (witness, bound) = self.find_witness(nodes, pair, Effort::Many);
                    if bound > protrusion {
                        self.witnesses.insert(pair, witness);
                    }
                    let bound = Cost(protrusion.max(bound));
                    self.queue.push((bound, true), pair, Known::Better);
                }
                Known::Better if grown == MOST_GROWN => {
                    self.queue.push((Cost(protrusion), true), pair, known);
                    return Ok(self.pop_verified());
                }
                Known::Better => {
                    self.control.check()?;
                    #[cfg(test)]
                    {
                        self.built += 1;
                    }
                    let node = self.joint(nodes, pair)?;
                    grown += usize::from(node.growth > 0.0);
                    let protrusion = Cost(node.protrusion);
                    self.queue.push((protrusion, false), pair, Known::Verified(Box::new(node)));
                }
            }
        }
        Ok(None)
    }

    /// The one that protrudes least of the joint hulls that are built.
    fn pop_verified(&mut self) -> Option<Node> {
        let mut found = None;
        for (cost, pair, known) in self.queue.pop_all() {
            match known {
                Known::Verified(node) if found.is_none() => found = Some(*node),
                known => self.queue.push(cost, pair, known),
            }
        }
        found
    }

    /// Replaces two hulls by their joint hull, the last node. O(k) bounds for k hulls.
    fn join(&mut self, nodes: &[Node]) {
        let Some((node, joined)) = nodes.last().and_then(|node| Some((node, node.joined?))) else {
            return;
        };
        self.centres.push(centre(node));
        let new = self.queue.join(joined);
        let others: Vec<u32> = self.queue.left().filter(|&other| other != new).collect();
        for other in others {
            let [a, b] = [joined.0, joined.1].map(|part| {
                let witness = self.witnesses.remove(&ordered(part, other)).unwrap_or_default();
                (witness, witness.bound([nodes[other as usize].hull.points(), node.hull.points()]))
            });
            let (witness, bound) = if a.1 >= b.1 { a } else { b };
            self.witnesses.insert((other, new), witness);
            self.push_roughly(nodes, (other, new), bound);
        }
    }

    /// A joint hull is not reported to protrude less than its parts.
    fn push_roughly(&mut self, nodes: &[Node], pair: Pair, bound: f64) {
        let [a, b] = [pair.0, pair.1].map(|part| nodes[part as usize].protrusion);
        self.queue.push((Cost(a.max(b).max(bound)), true), pair, Known::Roughly);
    }

    fn find_witness(&self, nodes: &[Node], (a, b): Pair, effort: Effort) -> (Witness, f64) {
        let pair = [a as usize, b as usize];
        let hulls = pair.map(|part| nodes[part].hull.points());
        find_witness(hulls, pair.map(|part| self.centres[part]), self.solid, effort)
    }

    /// The node that joins two others.
    fn joint(&self, nodes: &[Node], pair: Pair) -> Result<Node, Error> {
        let [first, second] = [pair.0, pair.1].map(|part| &nodes[part as usize]);
        let mut builder = HullBuilder::new();
        let hull = joint_hull(&mut builder, &first.hull, &second.hull)?;
        let (hull, growth) = match self.settings.max_vertices {
            Some(most) => limit_vertices(&mut builder, hull, most, self.control)?,
            None => (hull, 0.0),
        };
        let bound = self.settings.bound.verified();
        // It contains both and so protrudes at least as far; the upper bounds alone may disagree.
        let protrusion = protrusion(&hull, self.solid, bound, f64::INFINITY, self.control)?
            .max(first.protrusion)
            .max(second.protrusion);
        let growth = growth.max(first.growth).max(second.growth);
        Ok(Node { hull, protrusion, growth, joined: Some(pair) })
    }
}

fn centre(node: &Node) -> Vector {
    let (min, max) = bounds(node.hull.points().iter().copied());
    (min + max) * 0.5
}

/// A point outside of the solid, and the direction in which it is near to a joint hull's surface.
#[derive(Debug, Clone, Copy, Default)]
struct Witness {
    point: Vector,
    /// Of unit length.
    normal: Vector,
    /// No point of the solid is nearer.
    distance: f64,
}

/// Steps towards a plane that touches both hulls. Most bridges take two or three, and any plane
/// gives a valid bound.
const STEPS: usize = 4;

/// Shares of a bridge at which the distance to the solid is queried.
const MIDDLE: [f64; 1] = [0.5];
const ALONG: [f64; 3] = [0.5, 0.25, 0.75];

/// How many bridges are tried.
#[derive(Debug, Clone, Copy)]
enum Effort {
    /// Four, at their middle: they rule out most pairs.
    Few,
    /// Twelve, at three points each: as long as a tenth of verifying a joint hull.
    Many,
}

impl Witness {
    /// The joint hull of two hulls protrudes at least as far. Negative if the witness is too deep
    /// in it.
    fn bound(&self, hulls: [&[Vector]; 2]) -> f64 {
        if self.distance == 0.0 {
            return 0.0;
        }
        let [a, b] = hulls.map(|points| support(points, self.normal));
        self.distance - (a.1.max(b.1) - self.normal.dot(self.point)).max(0.0)
    }
}

/// The witness with the greatest bound on the protrusion of the joint hull of two hulls, and that
/// bound; 0 if none is outside of the solid.
fn find_witness(
    hulls: [&[Vector]; 2],
    centres: [Vector; 2],
    solid: &Solid,
    effort: Effort,
) -> (Witness, f64) {
    let (count, shares) = match effort {
        Effort::Few => (4, &MIDDLE[..]),
        Effort::Many => (12, &ALONG[..]),
    };
    let mut best = (Witness::default(), 0.0);
    let along = centres[1] - centres[0];
    let size = along.length();
    if size == 0.0 {
        return best;
    }
    let along = along * (1.0 / size);
    let axis = (0..3).min_by(|&i, &j| along[i].abs().total_cmp(&along[j].abs())).unwrap_or(0);
    let mut unit = Vector::ZERO;
    unit[axis] = 1.0;
    let first = along.cross(unit).normalize_or_zero();
    let second = along.cross(first);
    for index in 0..count {
        let angle = std::f64::consts::TAU * f64::from(index) / f64::from(count);
        let across = first * libm::cos(angle) + second * libm::sin(angle);
        let Some((normal, [from, to])) = bridge(hulls, across, along) else { continue };
        for &share in shares {
            let point = from + (to - from) * share;
            let Some(protruding) = solid.outside(point, best.1) else { continue };
            if protruding.lower <= best.1 {
                continue;
            }
            let witness = Witness { point, normal, distance: protruding.lower };
            let bound = witness.bound(hulls);
            if bound > best.1 {
                best = (witness, bound);
            }
        }
    }
    best
}

/// The unit normal of a plane that touches both hulls, near `across`, and a vertex of each on it.
fn bridge(hulls: [&[Vector]; 2], across: Vector, along: Vector) -> Option<(Vector, [Vector; 2])> {
    let mut normal = across;
    let mut ends = hulls.map(|points| support(points, normal).0);
    for _ in 0..STEPS {
        let gap = ends[1] - ends[0];
        let advance = gap.dot(along);
        if advance <= 0.0 {
            return None;
        }
        normal = across - along * (gap.dot(across) / advance);
        let last = std::mem::replace(&mut ends, hulls.map(|points| support(points, normal).0));
        if ends == last {
            break;
        }
    }
    Some((normal.normalize_or_zero(), ends))
}

/// The farthest point in a direction, and how far it is.
fn support(points: &[Vector], direction: Vector) -> (Vector, f64) {
    let mut best = (Vector::ZERO, f64::NEG_INFINITY);
    for &point in points {
        let height = point.dot(direction);
        if height > best.1 {
            best = (point, height);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hull::convex_hull;
    use crate::mesh::Normalization;
    use crate::parameters::Parameters;
    use crate::solid::Boundary;

    const BOXES: usize = 40;

    /// Boxes along a helix, of unlike sizes.
    fn boxes() -> Vec<Node> {
        let node = |index: usize| {
            let (angle, size) = (0.5 * index as f64, 0.03 + 0.001 * (index * 7 % 11) as f64);
            let corner = [0.3 * angle.cos(), 0.3 * angle.sin(), 0.02 * index as f64];
            let points =
                (0..8).map(|i| [0, 1, 2].map(|k| corner[k] + size * f64::from(i >> k & 1)));
            let hull = convex_hull(&points.collect::<Vec<_>>()).unwrap();
            Node { hull, protrusion: 0.0, growth: 0.0, joined: None }
        };
        (0..BOXES).map(node).collect()
    }

    fn solid_of(nodes: &[Node], bound: f64) -> Solid {
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for Node { hull, .. } in nodes {
            let first = positions.len() as u32;
            positions.extend_from_slice(hull.points());
            triangles.extend(hull.triangles.iter().map(|triangle| triangle.map(|v| v + first)));
        }
        Solid::of_surface(&positions, &triangles, Boundary::default(), bound, &Control::new())
            .unwrap()
    }

    #[test]
    fn the_least_joint_hull_is_found_with_few_that_are_built() {
        let (settings, control) =
            (Settings::after_search(&Parameters::default(), &Normalization::UNIT), Control::new());
        let mut nodes = boxes();
        let solid = solid_of(&nodes, settings.bound.verified());
        let mut pairs = Pairs::new(&nodes, &solid, &settings, &control).unwrap();
        let mut left: Vec<u32> = (0..BOXES as u32).collect();
        while let Some(node) = pairs.pop(&nodes).unwrap() {
            let (first, second) = node.joined.unwrap();
            // All pairs take long: every fifth time.
            if left.len().is_multiple_of(5) {
                for (index, &b) in left.iter().enumerate() {
                    for &a in &left[..index] {
                        let other = pairs.joint(&nodes, (a, b)).unwrap();
                        assert!(node.protrusion <= other.protrusion, "{a} and {b}");
                    }
                }
            }
            left.retain(|&index| index != first && index != second);
            left.push(nodes.len() as u32);
            nodes.push(node);
            pairs.join(&nodes);
        }
        assert_eq!(nodes.len(), 2 * BOXES - 1);
        // All pairs would be 780, and 741 more with the joint hulls.
        assert!(pairs.built <= 5 * BOXES, "{} joint hulls", pairs.built);
    }

    #[test]
    fn a_bound_is_never_above_what_is_verified() {
        let (settings, control) =
            (Settings::after_search(&Parameters::default(), &Normalization::UNIT), Control::new());
        let nodes = boxes();
        let solid = solid_of(&nodes, settings.bound.verified());
        let pairs = Pairs::new(&nodes, &solid, &settings, &control).unwrap();
        let mut sum = [0.0; 2];
        for b in 0..BOXES as u32 {
            for a in (0..b).step_by(3) {
                let verified = pairs.joint(&nodes, (a, b)).unwrap();
                for effort in [Effort::Few, Effort::Many] {
                    let (_, bound) = pairs.find_witness(&nodes, (a, b), effort);
                    assert!(bound <= verified.protrusion + 1e-9, "{a} and {b}: {bound}");
                    sum = [sum[0] + bound, sum[1] + verified.protrusion];
                }
            }
        }
        assert!(sum[0] > 0.5 * sum[1], "{sum:?}");
    }

    #[test]
    fn after_each_join_one_hull_fewer_is_left_and_all_leaves_are_below() {
        let (settings, control) =
            (Settings::after_search(&Parameters::default(), &Normalization::UNIT), Control::new());
        let nodes = &boxes()[..6];
        let solid = solid_of(nodes, settings.bound.verified());
        let leaves: Vec<(ConvexHull, f64)> =
            nodes.iter().map(|node| (node.hull.clone(), 0.0)).collect();
        let tree = JoinTree::new(leaves.clone(), 2, &solid, &settings, &control).unwrap();
        assert_eq!(tree.joins(), 4);
        for joins in 0..=4 {
            let state = tree.state(joins);
            assert_eq!(state.len(), 6 - joins);
            let mut below: Vec<usize> =
                state.iter().flat_map(|&node| tree.leaves_below(node)).collect();
            below.sort_unstable();
            assert_eq!(below, [0, 1, 2, 3, 4, 5]);
        }
        // No node is reported to protrude less than what it joins.
        for node in &tree.nodes {
            for part in node.joined.into_iter().flat_map(|(a, b)| [a, b]) {
                assert!(tree.nodes[part as usize].protrusion <= node.protrusion);
            }
        }
        let whole = JoinTree::new(leaves, 0, &solid, &settings, &control).unwrap();
        assert_eq!((whole.joins(), whole.state(9).len()), (5, 1));
    }

    #[test]
    fn a_bridge_touches_both_hulls_from_one_side() {
        let nodes = boxes();
        let hulls = [0, 3].map(|node: usize| nodes[node].hull.points());
        let along = (centre(&nodes[3]) - centre(&nodes[0])).normalize();
        let across = along.cross(Vector::Z).normalize();
        let (normal, ends) = bridge(hulls, across, along).unwrap();
        assert!((normal.length() - 1.0).abs() < 1e-12);
        let height = normal.dot(ends[0]);
        assert!((normal.dot(ends[1]) - height).abs() < 1e-9);
        for points in hulls {
            assert!(support(points, normal).1 <= height + 1e-9);
        }
        // One hull beyond the other has none.
        assert!(bridge([hulls[1], hulls[0]], across, along).is_none());
    }
}
