//! A whole scene tagged at once: which of its meshes, by a default, by names, by extras.

use bevy::ecs::entity::EntityHashSet;
use bevy::ecs::system::SystemParam;
use bevy::platform::collections::{HashMap, HashSet};
use bevy::prelude::*;

use crate::conventions::{NameTag, name_tag, without_copy_number};

use super::baked::BakedDecomposition;
use super::baked_scene::{BakedScene, FromBakedScene};
use super::hierarchy_progress::{HierarchyStatus, HierarchyWork};
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
#[require(HierarchyStatus, HierarchyWork)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
pub struct ConvexDecompositionHierarchy {
    /// For meshes of which nothing else is said; `None` to leave them alone.
    pub default_tag: Option<ConvexDecomposition>,
    /// By the name of the node or the mesh; `None` to leave it out.
    #[cfg_attr(feature = "serde", serde(with = "by_name"))]
    pub by_name: HashMap<String, Option<ConvexDecomposition>>,
    /// Whether names with `-convcol` and glTF extras with `{"collider": "convex_decomposition"}`
    /// are tagged, those with `{"collider": "none"}` are not, and meshes called `UCX_chair` or
    /// `UCX_chair_01` become convex pieces of the collider of `chair`, which is then not
    /// decomposed. Extras are read with the feature `bevy_gltf`. Default true.
    pub follows_artists: bool,
    /// Where the hulls of its meshes may be found. What is not there, or was baked from another mesh or
    /// with other settings, is decomposed, and the log says so. Not in texts: paths belong to the code
    /// that loads them. Default `None`.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub baked: Option<Handle<BakedScene>>,
}

impl Default for ConvexDecompositionHierarchy {
    fn default() -> Self {
        Self {
            default_tag: Some(ConvexDecomposition::default()),
            by_name: HashMap::default(),
            follows_artists: true,
            baked: None,
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

    /// The same with hulls that `hullwright bake` made of the scene.
    ///
    /// ```
    /// use bevy::prelude::*;
    /// use hullwright::bevy::prelude::*;
    ///
    /// # fn setup(server: Res<AssetServer>) {
    /// let level = ConvexDecompositionHierarchy::default()
    ///     .with_baked(server.load("level.hullscene"));
    /// # }
    /// ```
    #[must_use]
    pub fn with_baked(mut self, baked: Handle<BakedScene>) -> Self {
        self.baked = Some(baked);
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

/// The scene that is tagged.
#[derive(SystemParam)]
pub(super) struct Nodes<'w, 's> {
    meshes: Query<'w, 's, (Entity, Option<&'static Transform>), With<Mesh3d>>,
    names: Query<'w, 's, &'static Name>,
    parents: Query<'w, 's, &'static ChildOf>,
    children: Query<'w, 's, &'static Children>,
    own_tags: Query<'w, 's, (), OwnTag>,
    tagged: Query<'w, 's, (), With<TaggedByHierarchy>>,
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
    mut works: Query<&mut HierarchyWork>,
    changed: Query<Entity, Changed<ConvexDecompositionHierarchy>>,
    new_meshes: Query<Entity, NewMesh>,
    nodes: Nodes,
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
        if let (Ok(hierarchy), Ok(mut work)) = (hierarchies.get(root), works.get_mut(root)) {
            nodes.tag(&mut commands, root, hierarchy, &mut work);
        }
    }
}

impl Nodes<'_, '_> {
    fn tag(
        &self,
        commands: &mut Commands,
        root: Entity,
        hierarchy: &ConvexDecompositionHierarchy,
        work: &mut HierarchyWork,
    ) {
        let nodes = self.nodes_with_meshes(root);
        // Meshes that have pieces made by the artist.
        let mut with_pieces: HashSet<&str> = HashSet::default();
        if hierarchy.follows_artists {
            for node in &nodes {
                for name in self.names_of(*node) {
                    if let Some(NameTag::PieceOf(whole)) = name_tag(name) {
                        with_pieces.insert(whole);
                    }
                }
            }
        }
        let has_meshes = !nodes.is_empty();
        let (mut tagged, mut left_out) = (Vec::new(), 0);
        for node in nodes {
            if self.own_tags.contains(node) {
                continue;
            }
            let mut node_commands = commands.entity(node);
            match self.tag_of(node, hierarchy, &with_pieces) {
                Some(tag) => {
                    node_commands.try_remove::<NoConvexDecomposition>();
                    node_commands.try_insert((tag, TaggedByHierarchy));
                    match &hierarchy.baked {
                        Some(baked) => node_commands.try_insert(FromBakedScene(baked.clone())),
                        None => node_commands.try_remove::<FromBakedScene>(),
                    };
                    tagged.push(node);
                }
                None => {
                    if self.tagged.contains(node) {
                        node_commands.try_remove::<ConvexDecomposition>();
                    }
                    // Else it would be part of the input of a node above it.
                    node_commands.try_insert((NoConvexDecomposition, TaggedByHierarchy));
                    left_out += 1;
                }
            }
        }
        work.begin(tagged, left_out, has_meshes);
    }

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
                        && transform.is_none_or(|transform| *transform == Transform::IDENTITY) =>
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

    /// The node's own name, and those that its primitives have of their mesh.
    fn names_of(&self, node: Entity) -> impl Iterator<Item = &str> {
        let own = self.names.get(node).ok().map(Name::as_str);
        #[cfg(feature = "bevy_gltf")]
        let of_mesh = {
            let on = |entity| self.extras.get(entity).ok()?.2.map(|name| name.0.as_str());
            on(node).or_else(|| self.children.get(node).ok()?.iter().find_map(on))
        };
        #[cfg(not(feature = "bevy_gltf"))]
        let of_mesh = None;
        own.into_iter().chain(of_mesh)
    }

    #[cfg(feature = "bevy_gltf")]
    fn extras_of(&self, node: Entity) -> Option<bool> {
        let on = |entity| {
            let (extras, mesh_extras, _) = self.extras.get(entity).ok()?;
            let tag = |text: &String| crate::conventions::extras_tag(text);
            extras
                .and_then(|extras| tag(&extras.value))
                .or_else(|| mesh_extras.and_then(|extras| tag(&extras.value)))
        };
        on(node).or_else(|| {
            let children = self.children.get(node).ok()?;
            children.iter().filter(|child| self.meshes.contains(*child)).find_map(on)
        })
    }

    #[cfg(not(feature = "bevy_gltf"))]
    fn extras_of(&self, _node: Entity) -> Option<bool> {
        None
    }

    fn tag_of(
        &self,
        node: Entity,
        hierarchy: &ConvexDecompositionHierarchy,
        with_pieces: &HashSet<&str>,
    ) -> Option<ConvexDecomposition> {
        let by_name = |name: &str| hierarchy.by_name.get(name);
        if let Some(tag) = self.names_of(node).find_map(by_name) {
            return tag.clone();
        }
        if hierarchy.follows_artists {
            let asked = || hierarchy.default_tag.clone().unwrap_or_default();
            match self.extras_of(node) {
                Some(true) => return Some(asked()),
                Some(false) => return None,
                None => {}
            }
            match self.names_of(node).find_map(name_tag) {
                Some(NameTag::Decompose) => return Some(asked()),
                Some(NameTag::PieceOf(_)) => return Some(one_hull(asked())),
                None => {}
            }
            let has_pieces = |name: &str| {
                with_pieces.contains(name) || with_pieces.contains(without_copy_number(name))
            };
            if self.names_of(node).any(has_pieces) {
                return None;
            }
        }
        hierarchy.default_tag.clone()
    }
}

/// A piece made by an artist is convex up to modelling errors: one hull, with the tag's density and
/// fallback.
fn one_hull(tag: ConvexDecomposition) -> ConvexDecomposition {
    let ConvexDecomposition { density, fallback_collider, .. } = tag;
    let one = ConvexDecomposition::default().with_max_hulls(1);
    ConvexDecomposition { density, fallback_collider, ..one }
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
