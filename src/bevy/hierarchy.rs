//! A whole scene tagged at once: which of its meshes, by a default, by names, by extras.

use std::collections::BTreeMap;

use bevy::ecs::entity::EntityHashSet;
use bevy::platform::collections::{HashMap, HashSet};
use bevy::prelude::*;

use super::artists::{Treatment, treatment};
use super::baked_scene::{BakedScene, FromBakedScene};
use super::describe::{Descriptions, entities};
use super::hierarchy_status::{HierarchyStatus, HierarchyWork};
use super::nodes::{Nodes, TaggedByHierarchy};
use super::tag::{ConvexDecomposition, NoConvexDecomposition};
use crate::conventions::{NameTag, mesh_tag, node_tag, without_copy_number};

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
    /// Whether names and glTF extras say what becomes of a mesh: Godot's suffixes, such as `-col` and
    /// `-convcol`, and `-convdecomp`; Unreal's prefixes, where `UCX_chair_01` is a piece of the collider of
    /// `chair`, which is then not decomposed; extras such as `{"collider": "convex_decomposition",
    /// "max_error": 0.01}`. Extras are read, and colliders not drawn, with the feature `bevy_gltf`. Default
    /// true.
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

type NewMesh = (With<Mesh3d>, Or<(Added<Mesh3d>, Changed<ChildOf>)>);

/// Tags what is new below a hierarchy, and all below one that is new or changed.
#[expect(clippy::too_many_arguments, reason = "a system's are what it reads and writes")]
pub(super) fn tag_hierarchies(
    mut commands: Commands,
    hierarchies: Query<&ConvexDecompositionHierarchy>,
    mut works: Query<&mut HierarchyWork>,
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
        if let (Ok(hierarchy), Ok(mut work)) = (hierarchies.get(root), works.get_mut(root)) {
            tag_scene(&mut commands, &nodes, (root, hierarchy), &mut work, &mut complaints);
        }
    }
    complaints.log(&descriptions);
}

/// Tags the meshes below a root.
fn tag_scene(
    commands: &mut Commands,
    nodes: &Nodes,
    (root, hierarchy): (Entity, &ConvexDecompositionHierarchy),
    work: &mut HierarchyWork,
    complaints: &mut Complaints,
) {
    let all = nodes.nodes_with_meshes(root);
    let has_meshes = !all.is_empty();
    let (mut tagged, mut left_out) = (Vec::new(), 0);
    let with_pieces = match hierarchy.follows_artists {
        true => nodes.meshes_with_pieces(&all),
        false => HashSet::default(),
    };
    for node in all {
        if nodes.own_tags.contains(node) {
            continue;
        }
        let Treatment { tag, is_drawn, body } = match by_code(nodes, node, hierarchy) {
            Some(tag) => tag.clone().into(),
            None if hierarchy.follows_artists => {
                let base = || hierarchy.default_tag.clone().unwrap_or_default();
                by_artist(nodes, node, root, &base, &with_pieces, complaints)
                    .unwrap_or_else(|| hierarchy.default_tag.clone().into())
            }
            None => hierarchy.default_tag.clone().into(),
        };
        nodes.show(commands, node, is_drawn);
        if let Some(body) = body {
            commands.entity(node).try_insert_if_new(body);
        }
        match (&tag, &hierarchy.baked) {
            (Some(_), Some(baked)) => {
                commands.entity(node).try_insert(FromBakedScene(baked.clone()));
            }
            _ => {
                commands.entity(node).try_remove::<FromBakedScene>();
            }
        }
        match tag {
            Some(_) => tagged.push(node),
            None => left_out += 1,
        }
        // What is tagged anew starts anew.
        if nodes.tagged.get(node).is_ok_and(|before| before == tag.as_ref()) {
            continue;
        }
        let mut node = commands.entity(node);
        match tag {
            Some(tag) => {
                node.try_remove::<NoConvexDecomposition>();
                node.try_insert((tag, TaggedByHierarchy));
            }
            None => {
                node.try_remove::<ConvexDecomposition>();
                // Else it would be part of the input of a node above it.
                node.try_insert((NoConvexDecomposition, TaggedByHierarchy));
            }
        }
    }
    work.begin(tagged, left_out, has_meshes);
}

fn by_code<'a>(
    nodes: &Nodes,
    node: Entity,
    hierarchy: &'a ConvexDecompositionHierarchy,
) -> Option<&'a Option<ConvexDecomposition>> {
    let names = nodes.names_of(node);
    names.into_iter().flatten().find_map(|name| hierarchy.by_name.get(name))
}

/// What extras and names ask for; `base` is the tag that the scene has where it has one.
fn by_artist(
    nodes: &Nodes,
    node: Entity,
    root: Entity,
    base: &dyn Fn() -> ConvexDecomposition,
    with_pieces: &HashSet<&str>,
    complaints: &mut Complaints,
) -> Option<Treatment> {
    if nodes.is_left_out(node, root) {
        return Some(treatment(NameTag::LeftOut, base()));
    }
    if let Some(by_extras) = by_extras(nodes, node, base, complaints) {
        return Some(by_extras);
    }
    let [own, of_mesh] = nodes.names_of(node);
    if let Some(tag) = own.and_then(node_tag).or_else(|| of_mesh.and_then(mesh_tag)) {
        return Some(treatment(tag, base()));
    }
    let has_pieces =
        |name: &str| with_pieces.contains(name) || with_pieces.contains(without_copy_number(name));
    [own, of_mesh].into_iter().flatten().any(has_pieces).then(|| None.into())
}

/// What the extras of a node or of its mesh ask for.
#[cfg(feature = "bevy_gltf")]
fn by_extras(
    nodes: &Nodes,
    node: Entity,
    base: &dyn Fn() -> ConvexDecomposition,
    complaints: &mut Complaints,
) -> Option<Treatment> {
    nodes.extras_of(node).find_map(|text| {
        let (tag, wrong) = crate::conventions::read_extras(text);
        for text in wrong {
            complaints.new.entry(text).or_default().push(node);
        }
        Some(super::artists::with_extras(&tag?, base()))
    })
}

#[cfg(not(feature = "bevy_gltf"))]
fn by_extras(
    _nodes: &Nodes,
    _node: Entity,
    _base: &dyn Fn() -> ConvexDecomposition,
    _complaints: &mut Complaints,
) -> Option<Treatment> {
    None
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
