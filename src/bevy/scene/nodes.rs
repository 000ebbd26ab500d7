//! The nodes of a scene: which have meshes, what they and their meshes are called, what their extras say.

use bevy::ecs::entity::EntityHashSet;
use bevy::ecs::system::SystemParam;
use bevy::platform::collections::HashSet;
use bevy::prelude::*;

use crate::bevy::jobs::baked::BakedDecomposition;
use crate::bevy::tag::components::{ConvexDecomposition, NoConvexDecomposition};
use crate::conventions::{NameTag, node_tag, whole_of, without_copy_number};

/// Set on what a hierarchy tagged, so that another setting can take it back.
#[derive(Component, Debug, Clone, Copy)]
pub(crate) struct TaggedByHierarchy;

/// Set on what a hierarchy hides, so that another setting can show it again.
#[cfg(feature = "bevy_gltf")]
#[derive(Component, Debug, Clone, Copy)]
pub(crate) struct HiddenByHierarchy;

/// Bevy spawns the primitives of a mesh below their node, without a transform of their own.
fn is_identity(transform: Option<&Transform>) -> bool {
    transform.is_none_or(|transform| *transform == Transform::IDENTITY)
}

/// All of a scene that says what becomes of its meshes.
#[derive(SystemParam)]
pub(crate) struct Nodes<'w, 's> {
    meshes: Query<'w, 's, (Entity, Option<&'static Transform>), With<Mesh3d>>,
    names: Query<'w, 's, &'static Name>,
    pub parents: Query<'w, 's, &'static ChildOf>,
    children: Query<'w, 's, &'static Children>,
    pub own_tags: Query<'w, 's, (), OwnTag>,
    /// What hierarchies said before; `None` for no collider.
    pub tagged: Query<'w, 's, Option<&'static ConvexDecomposition>, With<TaggedByHierarchy>>,
    #[cfg(feature = "bevy_gltf")]
    hidden: Query<'w, 's, (), With<HiddenByHierarchy>>,
    #[cfg(feature = "bevy_gltf")]
    extras: Query<'w, 's, Extras>,
}

/// Tagged, but not by a hierarchy.
type OwnTag = (
    Or<(With<ConvexDecomposition>, With<BakedDecomposition>, With<NoConvexDecomposition>)>,
    Without<TaggedByHierarchy>,
);

#[cfg(feature = "bevy_gltf")]
type Extras = (
    Option<&'static bevy::gltf::GltfExtras>,
    Option<&'static bevy::gltf::GltfMeshExtras>,
    Option<&'static bevy::gltf::GltfMeshName>,
);

impl Nodes<'_, '_> {
    /// The entities that stand for one mesh each: those with a `Mesh3d`, or the parents of
    /// primitives.
    pub(crate) fn nodes_with_meshes(&self, root: Entity) -> Vec<Entity> {
        let mut seen = EntityHashSet::default();
        let is_root_node = self.is_gltf_node(root);
        let below = std::iter::once(root).chain(self.children.iter_descendants(root));
        let meshes = below.filter_map(|entity| self.meshes.get(entity).ok());
        meshes
            .map(|(entity, transform)| match self.parents.get(entity) {
                Ok(parent)
                    if entity != root
                        && (parent.parent() != root || is_root_node)
                        && is_identity(transform) =>
                {
                    parent.parent()
                }
                _ => entity,
            })
            .filter(|node| seen.insert(*node))
            .collect()
    }

    /// Whether the meshes right below are the primitives of one glTF mesh, whose name they have then,
    /// and not meshes of their own.
    #[cfg(feature = "bevy_gltf")]
    fn is_gltf_node(&self, entity: Entity) -> bool {
        let Ok(children) = self.children.get(entity) else { return false };
        let meshes = children.iter().filter(|child| self.meshes.contains(*child));
        let mut names = meshes.map(|mesh| Some(self.extras.get(mesh).ok()?.2?.0.as_str()));
        let Some(Some(first)) = names.next() else { return false };
        names.all(|name| name == Some(first))
    }

    #[cfg(not(feature = "bevy_gltf"))]
    fn is_gltf_node(&self, _entity: Entity) -> bool {
        false
    }

    /// The node's own name, and the one that its primitives have of their mesh.
    pub(crate) fn names_of(&self, node: Entity) -> [Option<&str>; 2] {
        let own = self.names.get(node).ok().map(Name::as_str);
        #[cfg(feature = "bevy_gltf")]
        let of_mesh = {
            let on = |entity| self.extras.get(entity).ok()?.2.map(|name| name.0.as_str());
            on(node).or_else(|| self.children.get(node).ok()?.iter().find_map(on))
        };
        #[cfg(not(feature = "bevy_gltf"))]
        let of_mesh = None;
        [own, of_mesh]
    }

    /// The extras of a node, of its mesh, and of its primitives.
    #[cfg(feature = "bevy_gltf")]
    pub(crate) fn extras_of(&self, node: Entity) -> impl Iterator<Item = &str> {
        let children = self.children.get(node).into_iter().flatten().copied();
        let primitives = children.filter(|child| self.meshes.contains(*child));
        let with_extras = std::iter::once(node).chain(primitives);
        with_extras.filter_map(|entity| self.extras.get(entity).ok()).flat_map(
            |(of_node, of_mesh, _)| {
                let texts = [of_node.map(|of| &of.value), of_mesh.map(|of| &of.value)];
                texts.into_iter().flatten().map(String::as_str)
            },
        )
    }

    /// Whether a node or one above it is none of the game's.
    pub(crate) fn is_left_out(&self, node: Entity, root: Entity) -> bool {
        std::iter::once(node)
            .chain(self.parents.iter_ancestors(node))
            .take_while(|entity| *entity != root)
            .filter_map(|entity| self.names.get(entity).ok())
            .any(|name| node_tag(name) == Some(NameTag::LeftOut))
    }

    /// The names of meshes that have pieces made by the artist.
    pub(crate) fn meshes_with_pieces(&self, nodes: &[Entity]) -> HashSet<&str> {
        let names = || nodes.iter().flat_map(|node| self.names_of(*node)).flatten();
        let all: HashSet<&str> = names().map(without_copy_number).collect();
        names()
            .filter_map(|name| match node_tag(name)? {
                NameTag::PieceOf { rest, .. } => Some(whole_of(rest, |name| all.contains(name))),
                _ => None,
            })
            .collect()
    }

    /// Hides the meshes of a node, or shows those that were hidden.
    #[cfg(feature = "bevy_gltf")]
    pub(crate) fn show(&self, commands: &mut Commands, node: Entity, is_drawn: bool) {
        let children = self.children.get(node).into_iter().flatten().copied();
        // What else is below the node stays as it is.
        let is_mesh = |entity: &Entity| self.meshes.contains(*entity);
        let primitives = children.filter(|child| {
            self.meshes.get(*child).is_ok_and(|(_, transform)| is_identity(transform))
        });
        for mesh in std::iter::once(node).filter(is_mesh).chain(primitives) {
            match (is_drawn, self.hidden.contains(mesh)) {
                (false, _) => {
                    commands.entity(mesh).try_insert((Visibility::Hidden, HiddenByHierarchy));
                }
                (true, true) => {
                    let mut mesh = commands.entity(mesh);
                    mesh.try_remove::<HiddenByHierarchy>();
                    mesh.try_insert(Visibility::Inherited);
                }
                (true, false) => {}
            }
        }
    }

    #[cfg(not(feature = "bevy_gltf"))]
    pub(crate) fn show(&self, _commands: &mut Commands, _node: Entity, _is_drawn: bool) {}
}
