//! The hierarchy of joins, from the final hulls down to one: the pair whose joint hull protrudes
//! least joins first. Each state is a valid result, with an error that is verified like that of the
//! final hulls.

use super::containment::solid::Solid;
use super::finalize::verify::protrusion::protrusion;
use super::settings::Settings;
use crate::control::Control;
use crate::error::Error;
use crate::hull::{ConvexHull, HullBuilder, cap_vertices, solid_hull};
use crate::parallel;

/// A hull of the hierarchy, final or joint. Lengths are in diagonals.
#[derive(Debug, Clone)]
pub(super) struct Node {
    pub hull: ConvexHull,
    /// No point of its surface is farther than this from the solid.
    pub protrusion: f64,
    /// How far it grew to keep the cap on vertices.
    pub growth: f64,
    /// The nodes that it joins; `None` for a final hull.
    pub children: Option<(usize, usize)>,
}

/// The final hulls, then the joint ones in the order of joining.
#[derive(Debug, Clone, Default)]
pub(super) struct Hierarchy {
    pub nodes: Vec<Node>,
    pub leaves: usize,
}

impl Hierarchy {
    /// Joins hulls, each given with its protrusion, until `until` are left. O(k² + k · joins) joint
    /// hulls for k hulls.
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
        let mut alive: Vec<usize> = (0..hierarchy.leaves).collect();
        let mut candidates: Vec<Node> = Vec::new();
        let mut pairs: Vec<(usize, usize)> = Vec::new();
        for (index, &second) in alive.iter().enumerate() {
            pairs.extend(alive[..index].iter().map(|&first| (first, second)));
        }
        while alive.len() > until.max(1) {
            let nodes = &hierarchy.nodes;
            let joints = parallel::map(&pairs, |&(first, second)| {
                control.check()?;
                joint(nodes, first, second, solid, settings, control)
            });
            candidates.extend(joints.into_iter().collect::<Result<Vec<Node>, Error>>()?);
            let least = candidates.iter().enumerate().min_by(|a, b| {
                a.1.protrusion.total_cmp(&b.1.protrusion).then(a.1.children.cmp(&b.1.children))
            });
            let Some((place, _)) = least else { break };
            let node = candidates.swap_remove(place);
            let Some((first, second)) = node.children else { break };
            let new = hierarchy.nodes.len();
            hierarchy.nodes.push(node);
            let is_gone = |index: usize| index == first || index == second;
            alive.retain(|&index| !is_gone(index));
            candidates.retain(|node| !node.children.is_some_and(|(a, b)| is_gone(a) || is_gone(b)));
            pairs = alive.iter().map(|&other| (other, new)).collect();
            alive.push(new);
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

/// The node that joins two others.
fn joint(
    nodes: &[Node],
    first: usize,
    second: usize,
    solid: &Solid,
    settings: &Settings,
    control: &Control,
) -> Result<Node, Error> {
    let mut builder = HullBuilder::new();
    let points: Vec<[f64; 3]> =
        nodes[first].hull.points.iter().chain(&nodes[second].hull.points).copied().collect();
    let (hull, _) = solid_hull(&mut builder, &points, [0.0; 3], 0.0)?;
    let (hull, growth) = match settings.max_vertices {
        Some(most) => cap_vertices(&mut builder, hull, most, control)?,
        None => (hull, 0.0),
    };
    // It contains both and so protrudes at least as far; the upper bounds alone may disagree.
    let protrusion = protrusion(&hull, solid, settings.bound, f64::INFINITY, control)?
        .max(nodes[first].protrusion)
        .max(nodes[second].protrusion);
    let growth = growth.max(nodes[first].growth).max(nodes[second].growth);
    Ok(Node { hull, protrusion, growth, children: Some((first, second)) })
}
