//! From the final hulls on down to one: the pair whose joint hull stands out least joins first.
//! Every state is valid, and its error verified like that of the final hulls.

use super::Tuning;
use super::certify::phantom;
use super::solid::Solid;
use crate::control::Control;
use crate::error::Error;
use crate::hull::{ConvexHull, HullBuilder, cap_vertices, solid_hull};

/// A hull of the tree, in diagonals: a final one, or a joint one.
#[derive(Debug, Clone)]
pub(crate) struct Node {
    pub hull: ConvexHull,
    /// No point of its surface is farther than this from the solid.
    pub phantom: f64,
    /// How far the cap on vertices made it grow.
    pub growth: f64,
    /// The nodes that it joins.
    pub children: Option<(usize, usize)>,
}

/// The final hulls, then the joint ones in the order in which they came about.
#[derive(Debug, Clone, Default)]
pub(crate) struct Tree {
    pub nodes: Vec<Node>,
    pub leaves: usize,
}

impl Tree {
    /// Joins hulls until `until` are left. O(k² + k · joins) joint hulls for k hulls.
    pub(crate) fn new(
        leaves: Vec<(ConvexHull, f64)>,
        until: usize,
        solid: &Solid,
        tuning: &Tuning,
        control: &Control,
    ) -> Result<Self, Error> {
        let mut tree = Self { leaves: leaves.len(), nodes: Vec::new() };
        tree.nodes.extend(leaves.into_iter().map(|(hull, phantom)| Node {
            hull,
            phantom,
            growth: 0.0,
            children: None,
        }));
        let mut alive: Vec<usize> = (0..tree.leaves).collect();
        let mut candidates: Vec<Node> = Vec::new();
        let mut pairs: Vec<(usize, usize)> = Vec::new();
        for (index, &second) in alive.iter().enumerate() {
            pairs.extend(alive[..index].iter().map(|&first| (first, second)));
        }
        while alive.len() > until.max(1) {
            let nodes = &tree.nodes;
            let joints = crate::parallel::map(&pairs, |&(first, second)| {
                control.check()?;
                joint(nodes, first, second, solid, tuning, control)
            });
            candidates.extend(joints.into_iter().collect::<Result<Vec<Node>, Error>>()?);
            let least = candidates.iter().enumerate().min_by(|a, b| {
                a.1.phantom.total_cmp(&b.1.phantom).then(a.1.children.cmp(&b.1.children))
            });
            let Some((place, _)) = least else { break };
            let node = candidates.swap_remove(place);
            let Some((first, second)) = node.children else { break };
            let new = tree.nodes.len();
            tree.nodes.push(node);
            let is_gone = |index: usize| index == first || index == second;
            alive.retain(|&index| !is_gone(index));
            candidates.retain(|node| !node.children.is_some_and(|(a, b)| is_gone(a) || is_gone(b)));
            pairs = alive.iter().map(|&other| (other, new)).collect();
            alive.push(new);
        }
        Ok(tree)
    }

    /// The nodes that are left when `joins` have been made.
    pub(crate) fn state(&self, joins: usize) -> Vec<usize> {
        let last = (self.leaves + joins).min(self.nodes.len());
        let mut is_alive = vec![true; last];
        for node in &self.nodes[..last] {
            if let Some((first, second)) = node.children {
                is_alive[first] = false;
                is_alive[second] = false;
            }
        }
        (0..last).filter(|&index| is_alive[index]).collect()
    }

    /// Number of joins.
    pub(crate) fn joins(&self) -> usize {
        self.nodes.len() - self.leaves
    }

    /// The final hulls below a node, ascending.
    pub(crate) fn leaves_of(&self, node: usize) -> Vec<usize> {
        let mut leaves = Vec::new();
        let mut stack = vec![node];
        while let Some(index) = stack.pop() {
            match self.nodes[index].children {
                Some((first, second)) => stack.extend([first, second]),
                None => leaves.push(index),
            }
        }
        leaves.sort_unstable();
        leaves
    }
}

fn joint(
    nodes: &[Node],
    first: usize,
    second: usize,
    solid: &Solid,
    tuning: &Tuning,
    control: &Control,
) -> Result<Node, Error> {
    let mut builder = HullBuilder::new();
    let points: Vec<[f64; 3]> =
        nodes[first].hull.points.iter().chain(&nodes[second].hull.points).copied().collect();
    let (hull, _) = solid_hull(&mut builder, &points, [0.0; 3], 0.0)?;
    let (hull, growth) = match tuning.max_vertices {
        Some(most) => cap_vertices(&mut builder, hull, most, control)?,
        None => (hull, 0.0),
    };
    // It holds both, so it stands out at least as far, whatever the upper bounds say.
    let phantom = phantom(&hull, solid, tuning.bound, f64::INFINITY, control)?
        .max(nodes[first].phantom)
        .max(nodes[second].phantom);
    let growth = growth.max(nodes[first].growth).max(nodes[second].growth);
    Ok(Node { hull, phantom, growth, children: Some((first, second)) })
}
