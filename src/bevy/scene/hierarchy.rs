//! A whole scene tagged at once: which of its meshes, by a default, by names, by extras.

use std::collections::BTreeMap;

use bevy::ecs::entity::EntityHashSet;
use bevy::ecs::system::SystemParam;
use bevy::platform::collections::{HashMap, HashSet};
use bevy::prelude::*;

use crate::bevy::jobs::baked_scene::{BakedScene, FromBakedScene};
use crate::bevy::scene::artists::{Treatment, treatment};
use crate::bevy::scene::hierarchy_status::{HierarchyStatus, HierarchyWork};
use crate::bevy::scene::nodes::{Nodes, TaggedByHierarchy};
use crate::bevy::tag::components::{ConvexDecomposition, NoConvexDecomposition};
use crate::bevy::tag::describe::{Descriptions, entities};
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
///
/// ```
/// use bevy::prelude::*;
/// use hullwright::bevy::prelude::*;
///
/// # fn setup(server: Res<AssetServer>) {
/// let level = ConvexDecompositionHierarchy::default()
///     .with("statue", ConvexDecomposition::default().with_max_error(0.05))
///     .without("curtain")
///     .with_baked(server.load("level.hullscene"));
/// # }
/// ```
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
    pub fn new(default_tag: ConvexDecomposition) -> Self {
        Self { default_tag: Some(default_tag), ..Self::default() }
    }

    /// Only what is named here or by the artist.
    pub fn tagged_only() -> Self {
        Self { default_tag: None, ..Self::default() }
    }

    /// The same with another tag for a node or mesh of this name.
    #[must_use]
    pub fn with(mut self, name: impl Into<String>, tag: ConvexDecomposition) -> Self {
        self.by_name.insert(name.into(), Some(tag));
        self
    }

    /// The same with hulls that `hullwright bake` made of the scene.
    #[must_use]
    pub fn with_baked(mut self, baked: Handle<BakedScene>) -> Self {
        self.baked = Some(baked);
        self
    }

    /// The same without the node or mesh of this name.
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

    pub(crate) fn serialize<S: Serializer>(tags: &Tags, serializer: S) -> Result<S::Ok, S::Error> {
        tags.iter().collect::<BTreeMap<_, _>>().serialize(serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Tags, D::Error> {
        Ok(BTreeMap::deserialize(deserializer)?.into_iter().collect())
    }
}

/// Errors in extras, with the entities that have them. Each is logged once.
#[derive(Default)]
pub(crate) struct Complaints {
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

/// Hierarchies, and what is new about them.
#[derive(SystemParam)]
pub(crate) struct Hierarchies<'w, 's> {
    all: Query<'w, 's, (&'static ConvexDecompositionHierarchy, &'static mut HierarchyWork)>,
    changed: Query<'w, 's, Entity, Changed<ConvexDecompositionHierarchy>>,
    new_meshes: Query<'w, 's, Entity, NewMesh>,
}

impl Hierarchies<'_, '_> {
    /// Those that are new or changed, and those with new meshes.
    fn to_tag(&self, nodes: &Nodes) -> EntityHashSet {
        let mut roots: EntityHashSet = self.changed.iter().collect();
        for mesh in &self.new_meshes {
            let mut above = std::iter::once(mesh).chain(nodes.parents.iter_ancestors(mesh));
            roots.extend(above.find(|entity| self.all.contains(*entity)));
        }
        roots
    }
}

/// Tags what is new below a hierarchy, and all below one that is new or changed.
pub(crate) fn tag_hierarchies(
    mut commands: Commands,
    mut hierarchies: Hierarchies,
    nodes: Nodes,
    descriptions: Descriptions,
    mut complaints: Local<Complaints>,
) {
    if hierarchies.all.is_empty() {
        return;
    }
    for root in hierarchies.to_tag(&nodes) {
        if let Ok((hierarchy, mut work)) = hierarchies.all.get_mut(root) {
            let all = nodes.nodes_with_meshes(root);
            let rules = Rules::new(&nodes, root, hierarchy, &all);
            rules.tag(&mut commands, all, &mut work, &mut complaints);
        }
    }
    complaints.log(&descriptions);
}

/// What becomes of each node of a scene.
struct Rules<'a, 'w, 's> {
    nodes: &'a Nodes<'w, 's>,
    root: Entity,
    hierarchy: &'a ConvexDecompositionHierarchy,
    /// Names of meshes with pieces made by the artist.
    with_pieces: HashSet<&'a str>,
}

impl<'a, 'w, 's> Rules<'a, 'w, 's> {
    fn new(
        nodes: &'a Nodes<'w, 's>,
        root: Entity,
        hierarchy: &'a ConvexDecompositionHierarchy,
        all: &[Entity],
    ) -> Self {
        let with_pieces = match hierarchy.follows_artists {
            true => nodes.meshes_with_pieces(all),
            false => HashSet::default(),
        };
        Self { nodes, root, hierarchy, with_pieces }
    }

    /// The first rule that matches a node.
    fn treatment(&self, node: Entity, complaints: &mut Complaints) -> Treatment {
        let by_name = &self.hierarchy.by_name;
        let mut names = self.nodes.names_of(node).into_iter().flatten();
        if let Some(tag) = names.find_map(|name| by_name.get(name)) {
            return tag.clone().into();
        }
        let by_artist = match self.hierarchy.follows_artists {
            true => self.by_artist(node, complaints),
            false => None,
        };
        by_artist.unwrap_or_else(|| self.hierarchy.default_tag.clone().into())
    }

    /// The tag on which names and extras build.
    fn base(&self) -> ConvexDecomposition {
        self.hierarchy.default_tag.clone().unwrap_or_default()
    }

    /// By extras and names; `None` where they say nothing.
    fn by_artist(&self, node: Entity, complaints: &mut Complaints) -> Option<Treatment> {
        if self.nodes.is_left_out(node, self.root) {
            return Some(treatment(NameTag::LeftOut, self.base()));
        }
        if let Some(by_extras) = self.by_extras(node, complaints) {
            return Some(by_extras);
        }
        let [own, of_mesh] = self.nodes.names_of(node);
        if let Some(tag) = own.and_then(node_tag).or_else(|| of_mesh.and_then(mesh_tag)) {
            return Some(treatment(tag, self.base()));
        }
        let has_pieces = |name: &str| {
            [name, without_copy_number(name)].iter().any(|name| self.with_pieces.contains(*name))
        };
        [own, of_mesh].into_iter().flatten().any(has_pieces).then(|| None.into())
    }

    /// By the extras of a node or of its mesh.
    #[cfg(feature = "bevy_gltf")]
    fn by_extras(&self, node: Entity, complaints: &mut Complaints) -> Option<Treatment> {
        self.nodes.extras_of(node).find_map(|text| {
            let (tag, wrong) = crate::conventions::read_extras(text);
            for text in wrong {
                complaints.new.entry(text).or_default().push(node);
            }
            Some(crate::bevy::scene::artists::with_extras(&tag?, self.base()))
        })
    }

    #[cfg(not(feature = "bevy_gltf"))]
    fn by_extras(&self, _node: Entity, _complaints: &mut Complaints) -> Option<Treatment> {
        None
    }

    /// Tags all nodes with meshes.
    fn tag(
        &self,
        commands: &mut Commands,
        all: Vec<Entity>,
        work: &mut HierarchyWork,
        complaints: &mut Complaints,
    ) {
        let Self { nodes, hierarchy, .. } = self;
        let has_meshes = !all.is_empty();
        let (mut tagged, mut left_out) = (Vec::new(), 0);
        for node in all {
            if nodes.own_tags.contains(node) {
                continue;
            }
            let Treatment { tag, is_drawn, body } = self.treatment(node, complaints);
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
