//! The nodes of the hierarchy, and the joint hull of two of them.

use crate::bounded::containment::solid::Solid;
use crate::bounded::finalize::verify::protrusion::protrusion;
use crate::bounded::settings::Settings;
use crate::control::Control;
use crate::error::Error;
use crate::hull::{ConvexHull, HullBuilder, joint_hull, limit_vertices};

/// A hull of the hierarchy, final or joint. Lengths are in diagonals.
#[derive(Debug, Clone)]
pub(in crate::bounded) struct Node {
    pub hull: ConvexHull,
    /// No point of its surface is farther than this from the solid.
    pub protrusion: f64,
    /// How far it grew to keep the cap on vertices.
    pub growth: f64,
    /// The nodes that it joins; `None` for a final hull.
    pub children: Option<(usize, usize)>,
}

/// The node that joins two others.
///
/// # Errors
/// [`Error::Cancelled`].
pub(super) fn joint(
    nodes: &[Node],
    (first, second): (usize, usize),
    solid: &Solid,
    settings: &Settings,
    control: &Control,
) -> Result<Node, Error> {
    let mut builder = HullBuilder::new();
    let hull = joint_hull(&mut builder, &nodes[first].hull, &nodes[second].hull)?;
    let (hull, growth) = match settings.max_vertices {
        Some(most) => limit_vertices(&mut builder, hull, most, control)?,
        None => (hull, 0.0),
    };
    // It contains both and so protrudes at least as far; the upper bounds alone may disagree.
    let protrusion = protrusion(&hull, solid, settings.bound, f64::INFINITY, control)?
        .max(nodes[first].protrusion)
        .max(nodes[second].protrusion);
    let growth = growth.max(nodes[first].growth).max(nodes[second].growth);
    Ok(Node { hull, protrusion, growth, children: Some((first, second)) })
}
