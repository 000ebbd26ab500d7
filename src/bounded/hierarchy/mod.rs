//! The hierarchy of joins, from the final hulls down to one: the pair whose joint hull protrudes
//! least joins first. Each state is a valid result, with an error that is verified like that of the
//! final hulls.
//!
//! | file | contents |
//! |---|---|
//! | `joint` | a joint hull, verified |
//! | `lower_bound` | what a joint hull protrudes at least, before it is built |
//! | `candidates` | the pairs, the least first |

mod candidates;
mod joint;
mod lower_bound;

use super::settings::Settings;
use crate::control::Control;
use crate::error::Error;
use crate::hull::ConvexHull;
use crate::solid::Solid;
use candidates::Candidates;
use joint::Node;

/// The final hulls, then the joint ones in the order of joining.
#[derive(Debug, Clone, Default)]
pub(super) struct Hierarchy {
    pub nodes: Vec<Node>,
    pub leaves: usize,
}

impl Hierarchy {
    /// Joins hulls, each given with its protrusion, until `until` are left. O(k² + k · joins)
    /// lower bounds for k hulls, and usually few joint hulls per join.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub(super) fn new(
        leaves: Vec<(ConvexHull, f64)>,
        until: usize,
        solid: &Solid,
        settings: &Settings,
        control: &Control,
    ) -> Result<Self, Error> {
        let mut hierarchy = Self { leaves: leaves.len(), nodes: Vec::new() };
        hierarchy.nodes.extend(leaves.into_iter().map(|(hull, protrusion)| Node {
            hull,
            protrusion,
            growth: 0.0,
            children: None,
        }));
        let nodes = &mut hierarchy.nodes;
        let joins = nodes.len().saturating_sub(until.max(1));
        let mut candidates = Candidates::new(nodes, solid, settings, control)?;
        while nodes.len() < hierarchy.leaves + joins {
            let Some(node) = candidates.pop(nodes)? else { break };
            nodes.push(node);
            candidates.join(nodes);
        }
        Ok(hierarchy)
    }

    /// The nodes that are left after some joins.
    pub(super) fn state(&self, joins: usize) -> Vec<usize> {
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

    /// The number of joins.
    pub(super) fn joins(&self) -> usize {
        self.nodes.len() - self.leaves
    }

    /// The final hulls below a node, ascending.
    pub(super) fn leaves_of(&self, node: usize) -> Vec<usize> {
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
