//! What users say of a whole scene, and how far it is: the component, its status, and the event in
//! which it ends.

use std::time::Duration;

use bevy::asset::HandleTemplate;
use bevy::ecs::template::OptionTemplate;
use bevy::platform::collections::HashMap;
use bevy::platform::time::Instant;
use bevy::prelude::*;

use crate::collider::placement::GivesSurface;
use crate::jobs::baked::BakedScene;
use crate::tag::ConvexDecomposition;
use crate::tag::template::template_like_default;

/// Tags the meshes below this entity, such as all of a glTF scene, also those that come later.
///
/// One glTF mesh is one input: children without a transform of their own below one parent, which
/// is how Bevy spawns the primitives of a mesh, are tagged by their parent. Entities with a tag of
/// their own keep it.
///
/// Below it, another hierarchy has its meshes to itself. What else stands beside it, such as
/// `Friction`, `CollisionGroups` or a `Sensor`, is inherited by all of its colliders, as from a
/// body above them.
///
/// The first rule that matches a mesh applies: [`by_name`](Self::by_name), the artist's
/// names and extras (if [`follows_artists`](Self::follows_artists)), then
/// [`default`](Self::default_tag).
///
/// ```
/// use bevy::prelude::*;
/// use bevy_hullwright::prelude::*;
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
#[require(HierarchyStatus, HierarchyWork, GivesSurface, Transform)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
pub struct ConvexDecompositionHierarchy {
    /// For meshes without a treatment of their own; `None` to leave them alone.
    pub default_tag: Option<ConvexDecomposition>,
    /// By the name of the node or the mesh; `None` to leave it out.
    #[cfg_attr(feature = "serde", serde(with = "by_name"))]
    pub by_name: HashMap<String, Option<ConvexDecomposition>>,
    /// Whether names and glTF extras say what becomes of a mesh: Godot's suffixes, such as `-col`
    /// and `-convcol`, and `-convdecomp`; Unreal's prefixes, where `UCX_chair_01` is a piece of the
    /// collider of `chair`, which is then not decomposed; extras such as `{"collider":
    /// "convex_decomposition", "max_error": 0.01}`. Extras are read, and colliders not drawn, with
    /// the feature `bevy_gltf`. Default true.
    pub follows_artists: bool,
    /// Where the hulls of its meshes may be found. What is not there, or was baked from another
    /// mesh or with other settings, is decomposed, and the log says so. Not in texts: paths belong
    /// to the code that loads them. Default `None`.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub baked: Option<Handle<BakedScene>>,
    /// The side of a cell, in metres of the world; positive. Meshes that fit into a cell and never
    /// move share one collider with the others of their cell, a [`LevelCell`](crate::LevelCell).
    /// `None` for a collider each. Default `None`.
    pub cell_size: Option<f32>,
}

template_like_default! {
    ConvexDecompositionHierarchy => ConvexDecompositionHierarchyTemplate {
        handle baked: OptionTemplate<HandleTemplate<BakedScene>>,
        default_tag: Option<ConvexDecomposition>,
        by_name: HashMap<String, Option<ConvexDecomposition>>,
        follows_artists: bool,
        cell_size: Option<f32>,
    }
}

impl Default for ConvexDecompositionHierarchy {
    fn default() -> Self {
        Self {
            default_tag: Some(ConvexDecomposition::default()),
            by_name: HashMap::default(),
            follows_artists: true,
            baked: None,
            cell_size: None,
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

    /// The same with one collider for all in a cell that never moves; `None` for one each.
    #[must_use]
    pub fn with_cells(mut self, size: impl Into<Option<f32>>) -> Self {
        self.cell_size = size.into();
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

/// How far the meshes below a [`ConvexDecompositionHierarchy`](crate::ConvexDecompositionHierarchy)
/// are.
#[derive(Component, Reflect, Debug, Clone, Copy, PartialEq, Default)]
#[reflect(Component, Default, Clone, PartialEq)]
#[type_path = "hullwright"]
pub enum HierarchyStatus {
    /// There is no mesh below it yet.
    #[default]
    Waiting,
    /// Some of its meshes are not finished.
    Running,
    /// All of them are.
    Finished(HierarchyReport),
}

impl HierarchyStatus {
    /// Whether nothing more will come, unless something changes.
    pub fn is_finished(&self) -> bool {
        matches!(self, Self::Finished(_))
    }
}

/// What became of the meshes of a scene. Those with a tag of their own are not counted.
#[non_exhaustive]
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Default)]
#[reflect(Default, Clone, PartialEq)]
#[type_path = "hullwright"]
pub struct HierarchyReport {
    /// With a collider, whatever it is made of.
    pub with_collider: usize,
    /// Tagged, but without a collider.
    pub without_collider: usize,
    /// With a collider of hulls, or a box, ball or capsule on request.
    pub ready: usize,
    /// Tagged, but without a decomposition:
    /// [`DecompositionStatus::Skipped`](crate::DecompositionStatus::Skipped) says why.
    pub skipped: usize,
    /// Without a collider, since the work failed:
    /// [`DecompositionStatus::Failed`](crate::DecompositionStatus::Failed) says why.
    pub failed: usize,
    /// Despawned or untagged before they were ready.
    pub cancelled: usize,
    /// Not tagged at all: by a name, an extra, or without a default.
    pub left_out: usize,
    /// Of those that are ready: from the baked scene.
    pub from_baked: usize,
    /// Of those that are ready: from hulls that the scene's own file holds.
    pub from_file: usize,
    /// Of those from the file: with hulls that were edited since they were baked.
    pub edited: usize,
    /// Of those that are ready: made anew, since the baked scene, or the file, has another state of
    /// them. The log says which and why.
    pub stale: usize,
    /// Of those that are ready: made anew, since the baked scene does not have them. The log says
    /// which.
    pub missing: usize,
    /// Whether the scene itself could not be loaded: it has no meshes, and
    /// `AssetServer::get_load_state` of its handle says why.
    pub is_lost: bool,
    /// From the first mesh to the last collider, by the clock on the wall.
    pub time: Duration,
}

impl HierarchyReport {
    /// Counts what became of the meshes of a scene within.
    pub(super) fn add(&mut self, inner: &Self) {
        self.with_collider += inner.with_collider;
        self.without_collider += inner.without_collider;
        self.ready += inner.ready;
        self.skipped += inner.skipped;
        self.failed += inner.failed;
        self.cancelled += inner.cancelled;
        self.left_out += inner.left_out;
        self.from_baked += inner.from_baked;
        self.from_file += inner.from_file;
        self.edited += inner.edited;
        self.stale += inner.stale;
        self.missing += inner.missing;
        self.is_lost |= inner.is_lost;
    }
}

/// All meshes below a [`ConvexDecompositionHierarchy`](crate::ConvexDecompositionHierarchy)
/// are finished. Once for each scene; again only after meshes were added or the hierarchy was
/// changed. One that holds other hierarchies ends after them, and counts their meshes too.
#[derive(EntityEvent, Debug, Clone)]
pub struct HierarchyFinished {
    /// The entity with the hierarchy.
    pub entity: Entity,
    /// What became of its meshes.
    pub report: HierarchyReport,
}

/// What of a scene is not finished.
#[derive(Component, Debug, Default)]
pub(crate) struct HierarchyWork {
    /// Tagged by the hierarchy.
    pub nodes: Vec<Entity>,
    pub unfinished: Vec<Entity>,
    pub left_out: usize,
    pub is_open: bool,
    pub start: Option<Instant>,
}

impl HierarchyWork {
    /// The hierarchy has tagged its meshes, for the first time or again.
    pub(super) fn begin(&mut self, nodes: Vec<Entity>, left_out: usize, has_meshes: bool) {
        self.unfinished.clone_from(&nodes);
        (self.nodes, self.left_out, self.is_open) = (nodes, left_out, true);
        if self.start.is_none() && has_meshes {
            self.start = Some(Instant::now());
        }
    }

    /// Some of what it tagged has started anew.
    pub(super) fn reopen(&mut self) {
        let nodes = std::mem::take(&mut self.nodes);
        self.begin(nodes, self.left_out, true);
    }

    /// Whether its meshes are still to come.
    pub(super) fn is_to_come(&self) -> bool {
        self.is_open && self.start.is_none()
    }
}

#[cfg(all(test, feature = "serde"))]
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
