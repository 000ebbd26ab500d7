//! The groups of hulls that `hullwright bake --into` wrote into a glTF document: which nodes are in
//! them, and which meshes are their hulls.
//!
//! A group is a node whose extras hold a record (see
//! [`HullsRecord`](crate::conventions::HullsRecord)). Below it each node is a hull: by the mesh
//! that it shows, or by the collider of `KHR_physics_rigid_bodies` whose geometry is the mesh of
//! another node, which nothing draws.

use std::collections::HashSet;

use glam::DAffine3;

use super::gltf_json::{Document, entries, extension, indices, key, optional_number};
use super::gltf_nodes::transform;
use super::gltf_tree::Json;
use crate::hulls_extras::record;

/// The extension by which hulls are colliders.
pub(super) const PHYSICS: &str = "KHR_physics_rigid_bodies";

/// All groups of a document.
#[derive(Default)]
pub(super) struct Groups {
    pub(super) list: Vec<Group>,
    /// For each node whether it is in a group; empty where there is no group.
    is_inside: Vec<bool>,
}

/// A group of hulls.
pub(super) struct Group {
    /// The node whose extras hold the record.
    pub(super) node: usize,
    /// The node that it is a child of, which shows the mesh.
    pub(super) parent: Option<usize>,
    /// All nodes of the group: that with the record, those below it, and those with the shapes of
    /// colliders.
    pub(super) nodes: Vec<usize>,
    pub(super) hulls: Vec<HullNode>,
    /// Whether hulls are colliders.
    pub(super) is_physics: bool,
}

/// A hull of a group.
pub(super) struct HullNode {
    pub(super) mesh: usize,
    /// To the space of the group's parent.
    pub(super) transform: DAffine3,
}

/// The nodes of a document.
struct Tree<'b, 'a> {
    nodes: &'b [Json<'a>],
    parents: Vec<Option<usize>>,
    of_scenes: HashSet<usize>,
}

impl Tree<'_, '_> {
    /// Whether a node is in no tree that a scene names. Others may be geometry of a collider, too.
    fn is_undrawn(&self, node: usize) -> bool {
        self.parents.get(node) == Some(&None) && !self.of_scenes.contains(&node)
    }
}

impl Groups {
    /// Nodes that form no tree are in the first group that reaches them. O(nodes).
    pub(super) fn of(document: &Document<'_>) -> Result<Self, String> {
        let nodes = entries(&document.nodes);
        let has_record = |node: &Json<'_>| match key(node, "extras") {
            Some(Json::Extras(text)) => record(text).is_some(),
            _ => false,
        };
        let roots: Vec<usize> =
            (0..nodes.len()).filter(|&index| has_record(&nodes[index])).collect();
        if roots.is_empty() {
            return Ok(Self::default());
        }
        let mut parents = vec![None; nodes.len()];
        for (index, node) in nodes.iter().enumerate() {
            for child in indices(node, "children").unwrap_or_default() {
                if let Some(parent @ None) = parents.get_mut(child) {
                    *parent = Some(index);
                }
            }
        }
        let scenes = entries(&document.scenes);
        let of_scenes = scenes.iter().flat_map(|scene| indices(scene, "nodes").unwrap_or_default());
        let of_scenes: HashSet<usize> = of_scenes.collect();
        let tree = Tree { nodes, parents, of_scenes };
        let mut groups = Self { list: Vec::new(), is_inside: vec![false; nodes.len()] };
        for root in roots {
            groups.add(&tree, root)?;
        }
        Ok(groups)
    }

    /// Whether a node is in a group.
    pub(super) fn contain(&self, node: usize) -> bool {
        self.is_inside.get(node) == Some(&true)
    }

    fn add(&mut self, tree: &Tree<'_, '_>, root: usize) -> Result<(), String> {
        let nodes = tree.nodes;
        let mut group = Group {
            node: root,
            parent: tree.parents.get(root).copied().flatten(),
            nodes: Vec::new(),
            hulls: Vec::new(),
            is_physics: false,
        };
        let mut shapes = HashSet::new();
        let mut open = vec![(root, DAffine3::IDENTITY)];
        while let Some((index, above)) = open.pop() {
            let (Some(node), Some(is_inside @ false)) =
                (nodes.get(index), self.is_inside.get_mut(index))
            else {
                continue;
            };
            *is_inside = true;
            group.nodes.push(index);
            let at_node = |reason: String| format!("node {index}: {reason}");
            let transform = above * transform(node).map_err(at_node)?;
            let shape = shape_node(node).map_err(at_node)?;
            let shown = match shape {
                Some(shape) => nodes.get(shape).map(|shape| optional_number(shape, "mesh")),
                None => Some(optional_number(node, "mesh")),
            };
            if let Some(mesh) = shown.transpose().map_err(at_node)?.flatten() {
                group.hulls.push(HullNode { mesh, transform });
            }
            if let Some(shape) = shape {
                group.is_physics = true;
                // Groups whose nodes show one mesh share its hulls.
                if tree.is_undrawn(shape) && shapes.insert(shape) {
                    if let Some(is_inside) = self.is_inside.get_mut(shape) {
                        *is_inside = true;
                    }
                    group.nodes.push(shape);
                }
            }
            let children = indices(node, "children").map_err(at_node)?;
            open.extend(children.into_iter().rev().map(|child| (child, transform)));
        }
        if !group.nodes.is_empty() {
            self.list.push(group);
        }
        Ok(())
    }
}

/// The node whose mesh is the geometry of a node's collider.
fn shape_node(node: &Json<'_>) -> Result<Option<usize>, String> {
    let collider = extension(node, PHYSICS).and_then(|physics| key(physics, "collider"));
    match collider.and_then(|collider| key(collider, "geometry")) {
        Some(geometry) => optional_number(geometry, "node"),
        None => Ok(None),
    }
}
