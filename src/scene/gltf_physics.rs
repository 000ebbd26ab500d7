//! What the physics extensions of a glTF file say, kept on its nodes while Bevy loads the file:
//! numbers become handles of meshes and places. Joints are left out.

use std::collections::HashSet;
use std::path::Path;

use bevy::asset::LoadContext;
use bevy::gltf::extensions::{ErasedGltfExtensionHandler, GltfExtensionHandler};
use bevy::gltf::{GltfAssetLabel, GltfLoaderSettings};
use bevy::prelude::*;
use gltf::json;
use hullwright_formats::conventions::{
    DeclaredCollider, Geometry, NodePhysics, PHYSICS_EXTENSIONS, PhysicsExtensions,
};
use serde_json::Map;

use crate::jobs::baked::BakedScene;

/// What the physics extensions of a file say of a node. Each node has it if any of its file does.
#[derive(Component, Reflect, Debug, Clone, PartialEq, Default)]
#[reflect(Component, Default, Clone, PartialEq)]
#[type_path = "hullwright"]
pub(super) struct GltfPhysics {
    /// A [`NodePhysics`] as JSON, so that a saved scene can hold it; empty for a node of which
    /// nothing is said.
    json: String,
    pub collider: DeclaredMeshes,
    pub trigger: DeclaredMeshes,
}

/// The meshes that a collider is made of.
#[derive(Reflect, Debug, Clone, PartialEq, Default)]
#[reflect(Default, Clone, PartialEq)]
#[type_path = "hullwright"]
pub(super) enum DeclaredMeshes {
    /// None: it has a shape by its measures, or there is no collider.
    #[default]
    None,
    /// That of the node itself.
    Own,
    /// Others, each where it is from the node.
    Placed(Vec<(Handle<Mesh>, Transform)>),
}

/// On a collider that a file makes of meshes: they are below it, and the tag that it gets says how.
#[derive(Component, Reflect, Debug, Clone, Copy, PartialEq, Default)]
#[reflect(Component, Default, Clone, PartialEq)]
#[type_path = "hullwright"]
pub(super) struct MadeOfMeshes {
    /// Whether it is their convex hull.
    pub is_convex: bool,
}

/// On a mesh that is there for a collider alone, and is none of the scene's.
#[derive(Component, Reflect, Debug, Clone, Copy, Default)]
#[reflect(Component, Default, Clone)]
#[type_path = "hullwright"]
pub(super) struct ColliderMesh;

/// On a node: the hulls of its mesh that its file has.
#[derive(Component, Reflect, Debug, Clone, PartialEq, Default)]
#[reflect(Component, Default, Clone, PartialEq)]
#[type_path = "hullwright"]
pub(super) struct HullsInFile {
    pub scene: Handle<BakedScene>,
    /// Whether they are others than were written.
    pub is_edited: bool,
}

impl GltfPhysics {
    pub(super) fn read(&self) -> NodePhysics {
        serde_json::from_str(&self.json).unwrap_or_default()
    }
}

/// Meshes that all colliders of a file may place. A small file could place a mesh any number of
/// times.
const MOST_PLACED: usize = 1 << 16;

/// Reads a file's physics while Bevy loads it.
#[derive(Debug, Clone, Default)]
pub(super) struct PhysicsReader {
    nodes: Vec<GltfPhysics>,
}

impl GltfExtensionHandler for PhysicsReader {
    fn dyn_clone(&self) -> Box<dyn ErasedGltfExtensionHandler> {
        Box::new(self.clone())
    }

    fn on_root(
        &mut self,
        context: &mut LoadContext<'_>,
        file: &gltf::Gltf,
        settings: &GltfLoaderSettings,
    ) {
        let root = file.document.as_json();
        let is_used = root.extensions_used.iter().any(|of| PHYSICS_EXTENSIONS.contains(&&**of));
        if is_used {
            let mut document = Document { root, context, settings, placed: 0 };
            self.nodes = document.read();
        }
    }

    fn on_gltf_node(
        &mut self,
        _: &mut LoadContext<'_>,
        node: &gltf::Node<'_>,
        entity: &mut EntityWorldMut<'_>,
    ) {
        if let Some(physics) = self.nodes.get(node.index()) {
            entity.insert(physics.clone());
        }
    }
}

/// A file that is read. It may not have been validated, so no number in it is trusted.
struct Document<'a, 'c> {
    root: &'a json::Root,
    context: &'a mut LoadContext<'c>,
    settings: &'a GltfLoaderSettings,
    /// Meshes that colliders have placed.
    placed: usize,
}

impl Document<'_, '_> {
    /// Of each node; nothing if there are no bodies and colliders.
    fn read(&mut self) -> Vec<GltfPhysics> {
        let none = Map::new();
        let extensions = self.root.extensions.as_ref().map_or(&none, |of| &of.others);
        let (nodes, meshes) = (self.root.nodes.len(), self.root.meshes.len());
        let extensions = PhysicsExtensions::new(extensions, nodes, meshes);
        let path = self.context.path().path().to_owned();
        let (mut joints, mut says_anything) = (0, false);
        let mut read = Vec::with_capacity(nodes);
        for (index, node) in self.root.nodes.iter().enumerate() {
            let of_node = node.extensions.as_ref().map(|of| extensions.of_node(&of.others));
            let (physics, errors) = of_node.unwrap_or_default();
            for error in errors {
                warn(&path, index, node, &error.to_string());
            }
            let Some(physics) = physics else {
                read.push(GltfPhysics::default());
                continue;
            };
            joints += usize::from(physics.has_joint);
            let geometry =
                |of: &Option<_>| of.as_ref().map(|of: &DeclaredCollider| of.geometry.clone());
            let mut made_of = |geometry: Option<Geometry>| {
                let Some(geometry) = geometry else { return DeclaredMeshes::None };
                self.meshes_of(index, &geometry).unwrap_or_else(|| {
                    warn(
                        &path,
                        index,
                        node,
                        "its colliders place too many meshes: they are left out",
                    );
                    DeclaredMeshes::Placed(Vec::new())
                })
            };
            let (collider, trigger) =
                (made_of(geometry(&physics.collider)), made_of(geometry(&physics.trigger)));
            says_anything |=
                physics.motion.is_some() || physics.collider.is_some() || physics.trigger.is_some();
            let json = serde_json::to_string(&physics).unwrap_or_default();
            read.push(GltfPhysics { json, collider, trigger });
        }
        if joints > 0 {
            log::warn!(
                "{}: joints are not read from files: {joints} {} left out",
                path.display(),
                if joints == 1 { "is" } else { "are" }
            );
        }
        if says_anything { read } else { Vec::new() }
    }

    /// What a geometry is made of; `None` if that is too much.
    fn meshes_of(&mut self, node: usize, geometry: &Geometry) -> Option<DeclaredMeshes> {
        let own = self.root.nodes.get(node)?.mesh.map(|mesh| mesh.value());
        let mut placed = Vec::new();
        match geometry {
            Geometry::Shape(_) => return Some(DeclaredMeshes::None),
            Geometry::Mesh { mesh, .. } if own == Some(*mesh) && !self.has_children(node) => {
                return Some(DeclaredMeshes::Own);
            }
            Geometry::Node { node: of, .. } if *of == node && !self.has_children(node) => {
                return Some(DeclaredMeshes::Own);
            }
            Geometry::Mesh { mesh, .. } => self.place(*mesh, Transform::IDENTITY, &mut placed)?,
            Geometry::Node { node, .. } => {
                let mut seen = HashSet::from([*node]);
                let mut open = vec![(*node, Transform::IDENTITY)];
                while let Some((node, place)) = open.pop() {
                    let Some(node) = self.root.nodes.get(node) else { continue };
                    if let Some(mesh) = node.mesh {
                        self.place(mesh.value(), place, &mut placed)?;
                    }
                    for child in node.children.iter().flatten().map(json::Index::value) {
                        if seen.insert(child)
                            && let Some(node) = self.root.nodes.get(child)
                        {
                            open.push((child, place * transform(node)));
                        }
                    }
                }
            }
        }
        Some(DeclaredMeshes::Placed(placed))
    }

    fn has_children(&self, node: usize) -> bool {
        let node = self.root.nodes.get(node);
        node.and_then(|node| node.children.as_ref()).is_some_and(|children| !children.is_empty())
    }

    /// `None` if there are too many.
    fn place(
        &mut self,
        mesh: usize,
        place: Transform,
        placed: &mut Vec<(Handle<Mesh>, Transform)>,
    ) -> Option<()> {
        // What is not loaded would never be there.
        if self.settings.load_meshes.is_empty() {
            return Some(());
        }
        let primitives = self.root.meshes.get(mesh).map_or(0, |mesh| mesh.primitives.len());
        self.placed += primitives;
        if self.placed > MOST_PLACED {
            return None;
        }
        placed.extend((0..primitives).map(|primitive| {
            let label = GltfAssetLabel::Primitive { mesh, primitive };
            (self.context.get_label_handle(label.to_string()), place)
        }));
        Some(())
    }
}

fn warn(path: &Path, index: usize, node: &json::Node, text: &str) {
    let name = node.name.as_deref().unwrap_or("without a name");
    log::warn!("{}, node {index} ({name}): {text}", path.display());
}

/// Where a node is from its parent.
fn transform(node: &json::Node) -> Transform {
    if let Some(matrix) = &node.matrix {
        return Transform::from_matrix(Mat4::from_cols_array(matrix));
    }
    Transform {
        translation: node.translation.map_or(Vec3::ZERO, Vec3::from),
        rotation: node.rotation.as_ref().map_or(Quat::IDENTITY, |of| Quat::from_array(of.0)),
        scale: node.scale.map_or(Vec3::ONE, Vec3::from),
    }
}

/// Logs what helps where Bevy's loader refuses a file that requires a physics extension: it
/// supports none of them, and does not call the handlers that do.
pub(super) fn explain_refusal(entity: Entity, error: &str) {
    if error.contains("extensionsRequired")
        && PHYSICS_EXTENSIONS.iter().any(|extension| error.contains(extension))
    {
        log::warn!(
            "the file of {entity} requires a physics extension, which is why Bevy refuses it: load \
             it with the settings `GltfLoaderSettings {{ validate: false, ..default() }}`"
        );
    }
}
