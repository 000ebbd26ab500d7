//! A whole scene tagged at once: which of its meshes, by a default, by names, by extras.

use std::collections::BTreeMap;

use bevy::ecs::entity::EntityHashSet;
use bevy::ecs::system::SystemParam;
use bevy::platform::collections::{HashMap, HashSet};
use bevy::prelude::*;

use bevy_rapier3d::prelude::RigidBody;

use super::artists::{Treatment, treatment};
use super::baked::BakedDecomposition;
use super::describe::{Descriptions, entities};
use super::naming_conventions::{NameTag, mesh_tag, node_tag, whole_of, without_copy_number};
use super::tag::{ConvexDecomposition, NoConvexDecomposition};

/// Tags the meshes below this entity, such as all of a glTF scene, also those that come later.
///
/// One glTF mesh is one input: children without a transform of their own below one parent, which
/// is how Bevy spawns the primitives of a mesh, are tagged by their parent. Entities with a tag of
/// their own keep it.
///
/// The first rule that matches a mesh applies: [`by_name`](Self::by_name), the artist's
/// names and extras (if [`follows_artists`](Self::follows_artists)), then
/// [`default`](Self::default_tag).
#[derive(Component, Reflect, Debug, Clone, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[type_path = "hullwright"]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
pub struct ConvexDecompositionHierarchy {
    /// For meshes of which nothing else is said; `None` to leave them alone.
    pub default_tag: Option<ConvexDecomposition>,
    /// By the name of the node or the mesh; `None` to leave it out.
    #[cfg_attr(feature = "serde", serde(with = "by_name"))]
    pub by_name: HashMap<String, Option<ConvexDecomposition>>,
    /// Whether names and glTF extras say what becomes of a mesh: Godot's suffixes, such as `-col` and
    /// `-convcol`, and `-convdecomp`; Unreal's prefixes, where `UCX_chair_01` is a piece of the collider of
    /// `chair`, which is then not decomposed; extras such as `{"collider": "convex_decomposition",
    /// "max_error": 0.01}`. Extras are read, and colliders not drawn, with the feature `bevy_gltf`. Default
    /// true.
    pub follows_artists: bool,
}

impl Default for ConvexDecompositionHierarchy {
    fn default() -> Self {
        Self {
            default_tag: Some(ConvexDecomposition::default()),
            by_name: HashMap::default(),
            follows_artists: true,
        }
    }
}

impl ConvexDecompositionHierarchy {
    /// All meshes with this tag.
    ///
    /// ```
    /// use hullwright::bevy::prelude::*;
    ///
    /// let fine = ConvexDecomposition::from(DecompositionPreset::Fine);
    /// let scene = ConvexDecompositionHierarchy::new(fine.clone());
    /// assert_eq!(scene.default_tag, Some(fine));
    /// ```
    pub fn new(default_tag: ConvexDecomposition) -> Self {
        Self { default_tag: Some(default_tag), ..Self::default() }
    }

    /// Only what is named here or by the artist.
    ///
    /// ```
    /// use hullwright::bevy::prelude::*;
    ///
    /// assert_eq!(ConvexDecompositionHierarchy::tagged_only().default_tag, None);
    /// ```
    pub fn tagged_only() -> Self {
        Self { default_tag: None, ..Self::default() }
    }

    /// The same with another tag for a node or mesh of this name.
    ///
    /// ```
    /// use hullwright::bevy::prelude::*;
    ///
    /// let coarse = ConvexDecomposition::default().with_max_error(0.05);
    /// let scene = ConvexDecompositionHierarchy::default().with("statue", coarse.clone());
    /// assert_eq!(scene.by_name["statue"], Some(coarse));
    /// ```
    #[must_use]
    pub fn with(mut self, name: impl Into<String>, tag: ConvexDecomposition) -> Self {
        self.by_name.insert(name.into(), Some(tag));
        self
    }

    /// The same without the node or mesh of this name.
    ///
    /// ```
    /// use hullwright::bevy::prelude::*;
    ///
    /// let scene = ConvexDecompositionHierarchy::default().without("curtain");
    /// assert_eq!(scene.by_name["curtain"], None);
    /// ```
    #[must_use]
    pub fn without(mut self, name: impl Into<String>) -> Self {
        self.by_name.insert(name.into(), None);
        self
    }
}

/// Bevy's maps have serde of their own only behind a feature of Bevy's. Sorted, so that equal maps
/// are equal texts.
#[cfg(feature = "serde")]
mod by_name {
    use std::collections::BTreeMap;

    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use super::{ConvexDecomposition, HashMap};

    type Tags = HashMap<String, Option<ConvexDecomposition>>;

    pub(super) fn serialize<S: Serializer>(tags: &Tags, serializer: S) -> Result<S::Ok, S::Error> {
        tags.iter().collect::<BTreeMap<_, _>>().serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Tags, D::Error> {
        Ok(BTreeMap::deserialize(deserializer)?.into_iter().collect())
    }
}

/// Set on what a hierarchy tagged, so that another setting can take it back.
#[derive(Component, Debug, Clone, Copy)]
pub(super) struct TaggedByHierarchy;

/// Set on what a hierarchy hides, so that another setting can show it again.
#[derive(Component, Debug, Clone, Copy)]
pub(super) struct HiddenByHierarchy;

/// Bevy spawns the primitives of a mesh below their node, without a transform of their own.
fn is_identity(transform: Option<&Transform>) -> bool {
    transform.is_none_or(|transform| *transform == Transform::IDENTITY)
}

/// What was wrong with extras, and of whom it was said first. Each is logged once.
#[derive(Default)]
pub(super) struct Complaints {
    known: HashSet<String>,
    new: BTreeMap<String, Vec<Entity>>,
}

impl Complaints {
    fn log(&mut self, descriptions: &Descriptions) {
        for (text, of) in std::mem::take(&mut self.new) {
            if let Some(first) = of.first().filter(|_| self.known.insert(text.clone())) {
                let who = entities(of.len(), &descriptions.entity(*first, None));
                log::warn!("glTF extras of {who}: {text}");
            }
        }
    }
}

/// The scene that is tagged.
#[derive(SystemParam)]
pub(super) struct Nodes<'w, 's> {
    meshes: Query<'w, 's, (Entity, Option<&'static Transform>), With<Mesh3d>>,
    names: Query<'w, 's, &'static Name>,
    parents: Query<'w, 's, &'static ChildOf>,
    children: Query<'w, 's, &'static Children>,
    own_tags: Query<'w, 's, (), OwnTag>,
    tagged: Query<'w, 's, (), With<TaggedByHierarchy>>,
    hidden: Query<'w, 's, (), With<HiddenByHierarchy>>,
    #[cfg(feature = "bevy_gltf")]
    extras: Query<'w, 's, Extras>,
}

/// Tagged by somebody else.
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

type NewMesh = (With<Mesh3d>, Or<(Added<Mesh3d>, Changed<ChildOf>)>);

/// Tags what is new below a hierarchy, and all below one that is new or changed.
pub(super) fn tag_hierarchies(
    mut commands: Commands,
    hierarchies: Query<&ConvexDecompositionHierarchy>,
    changed: Query<Entity, Changed<ConvexDecompositionHierarchy>>,
    new_meshes: Query<Entity, NewMesh>,
    nodes: Nodes,
    descriptions: Descriptions,
    mut complaints: Local<Complaints>,
) {
    if hierarchies.is_empty() {
        return;
    }
    let mut roots: EntityHashSet = changed.iter().collect();
    for mesh in &new_meshes {
        let above = std::iter::once(mesh).chain(nodes.parents.iter_ancestors(mesh));
        roots.extend(above.into_iter().find(|entity| hierarchies.contains(*entity)));
    }
    for root in roots {
        if let Ok(hierarchy) = hierarchies.get(root) {
            nodes.tag(&mut commands, root, hierarchy, &mut complaints);
        }
    }
    complaints.log(&descriptions);
}

impl Nodes<'_, '_> {
    fn tag(
        &self,
        commands: &mut Commands,
        root: Entity,
        hierarchy: &ConvexDecompositionHierarchy,
        complaints: &mut Complaints,
    ) {
        let nodes = self.nodes_with_meshes(root);
        let with_pieces = match hierarchy.follows_artists {
            true => self.meshes_with_pieces(&nodes),
            false => HashSet::default(),
        };
        for node in nodes {
            if self.own_tags.contains(node) {
                continue;
            }
            let treatment = self.treatment(node, root, hierarchy, &with_pieces, complaints);
            self.show(commands, node, treatment.is_drawn);
            let mut node_commands = commands.entity(node);
            match treatment.tag {
                Some(tag) => {
                    node_commands.try_remove::<NoConvexDecomposition>();
                    node_commands.try_insert((tag, TaggedByHierarchy));
                }
                None => {
                    if self.tagged.contains(node) {
                        node_commands.try_remove::<ConvexDecomposition>();
                    }
                    // Else it would be part of the input of a node above it.
                    node_commands.try_insert((NoConvexDecomposition, TaggedByHierarchy));
                }
            }
            if treatment.is_body {
                node_commands.try_insert_if_new(RigidBody::Dynamic);
            }
        }
    }

    /// The names of meshes that have pieces made by the artist.
    fn meshes_with_pieces(&self, nodes: &[Entity]) -> HashSet<&str> {
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
    fn show(&self, commands: &mut Commands, node: Entity, is_drawn: bool) {
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
    fn show(&self, _commands: &mut Commands, _node: Entity, _is_drawn: bool) {}

    /// The entities that stand for one mesh each: those with a `Mesh3d`, or the parents of
    /// primitives.
    fn nodes_with_meshes(&self, root: Entity) -> Vec<Entity> {
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
    /// and not meshes of their own that somebody put there.
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
    fn names_of(&self, node: Entity) -> [Option<&str>; 2] {
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

    /// What the extras of a node or of its mesh ask for.
    #[cfg(feature = "bevy_gltf")]
    fn by_extras(
        &self,
        node: Entity,
        base: &dyn Fn() -> ConvexDecomposition,
        complaints: &mut Complaints,
    ) -> Option<Treatment> {
        let children = self.children.get(node).into_iter().flatten().copied();
        let primitives = children.filter(|child| self.meshes.contains(*child));
        for entity in std::iter::once(node).chain(primitives) {
            let Ok((of_node, of_mesh, _)) = self.extras.get(entity) else { continue };
            let texts = [of_node.map(|of| &of.value), of_mesh.map(|of| &of.value)];
            for text in texts.into_iter().flatten() {
                let (tag, wrong) = super::extras::read_extras(text);
                for text in wrong {
                    complaints.new.entry(text).or_default().push(node);
                }
                if let Some(tag) = tag {
                    return Some(super::artists::with_extras(&tag, base()).into());
                }
            }
        }
        None
    }

    #[cfg(not(feature = "bevy_gltf"))]
    fn by_extras(
        &self,
        _node: Entity,
        _base: &dyn Fn() -> ConvexDecomposition,
        _complaints: &mut Complaints,
    ) -> Option<Treatment> {
        None
    }

    /// Whether a node or one above it is none of the game's.
    fn is_left_out(&self, node: Entity, root: Entity) -> bool {
        let above = self.parents.iter_ancestors(node).take_while(|above| *above != root);
        std::iter::once(node)
            .chain(above)
            .filter_map(|entity| self.names.get(entity).ok())
            .any(|name| node_tag(name) == Some(NameTag::LeftOut))
    }

    fn treatment(
        &self,
        node: Entity,
        root: Entity,
        hierarchy: &ConvexDecompositionHierarchy,
        with_pieces: &HashSet<&str>,
        complaints: &mut Complaints,
    ) -> Treatment {
        let names = self.names_of(node);
        if let Some(tag) = names.iter().flatten().find_map(|name| hierarchy.by_name.get(*name)) {
            return tag.clone().into();
        }
        if hierarchy.follows_artists {
            let base = || hierarchy.default_tag.clone().unwrap_or_default();
            if self.is_left_out(node, root) {
                return treatment(NameTag::LeftOut, base());
            }
            if let Some(by_extras) = self.by_extras(node, &base, complaints) {
                return by_extras;
            }
            let [own, of_mesh] = names;
            if let Some(tag) = own.and_then(node_tag).or_else(|| of_mesh.and_then(mesh_tag)) {
                return treatment(tag, base());
            }
            let has_pieces = |name: &str| {
                with_pieces.contains(name) || with_pieces.contains(without_copy_number(name))
            };
            if names.into_iter().flatten().any(has_pieces) {
                return None.into();
            }
        }
        hierarchy.default_tag.clone().into()
    }
}

#[cfg(all(test, feature = "serde", feature = "io"))]
mod tests {
    use super::*;

    #[test]
    fn a_hierarchy_is_written_and_read() {
        let hierarchy = ConvexDecompositionHierarchy::tagged_only()
            .with("table", ConvexDecomposition::default().with_density(3.0))
            .without("lamp");
        let text = serde_json::to_string(&hierarchy).unwrap();
        let read: ConvexDecompositionHierarchy = serde_json::from_str(&text).unwrap();
        assert_eq!(read, hierarchy);
    }

    #[test]
    fn what_is_left_out_of_a_hierarchy_has_its_default() {
        let read: ConvexDecompositionHierarchy = serde_json::from_str("{}").unwrap();
        assert_eq!(read, ConvexDecompositionHierarchy::default());
    }
}
