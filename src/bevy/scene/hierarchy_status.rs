//! The status of a scene whose meshes are tagged, and the event in which it ends.

use std::time::Duration;

use bevy::platform::time::Instant;
use bevy::prelude::*;

/// How far the meshes below a [`ConvexDecompositionHierarchy`](crate::bevy::ConvexDecompositionHierarchy) are.
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
    /// With a collider of hulls.
    pub ready: usize,
    /// Tagged, but without a decomposition: [`DecompositionStatus::Skipped`](crate::bevy::DecompositionStatus::Skipped) says why.
    pub skipped: usize,
    /// Without a collider: [`DecompositionStatus::Failed`](crate::bevy::DecompositionStatus::Failed) says why.
    pub failed: usize,
    /// Despawned or untagged before they were ready.
    pub cancelled: usize,
    /// Not tagged at all: by a name, an extra, or without a default.
    pub left_out: usize,
    /// Of those that are ready: from the baked scene.
    pub from_baked: usize,
    /// Of those that are ready: made anew, since the baked scene has another state of them. The log says
    /// which and why.
    pub stale: usize,
    /// Of those that are ready: made anew, since the baked scene does not know them. The log says which.
    pub missing: usize,
    /// Whether the scene itself could not be loaded: it has no meshes, and `AssetServer::get_load_state` of its
    /// handle says why.
    pub is_lost: bool,
    /// From the first mesh to the last collider, by the clock on the wall.
    pub time: Duration,
}

/// All meshes below a [`ConvexDecompositionHierarchy`](crate::bevy::ConvexDecompositionHierarchy) are finished. Once for each scene; again only after
/// meshes were added or the hierarchy was changed.
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
    pub scene: SceneState,
}

/// What is known of the scene that Bevy spawns below a hierarchy.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum SceneState {
    /// It was never spawned: its meshes come from somewhere else, or later.
    #[default]
    Unknown,
    Spawned,
}

impl HierarchyWork {
    /// The hierarchy has tagged its meshes, for the first time or again.
    pub(crate) fn begin(&mut self, nodes: Vec<Entity>, left_out: usize, has_meshes: bool) {
        self.unfinished.clone_from(&nodes);
        (self.nodes, self.left_out, self.is_open) = (nodes, left_out, true);
        if self.start.is_none() && has_meshes {
            self.start = Some(Instant::now());
        }
    }

    /// Whether its meshes are still to come.
    pub(crate) fn is_to_come(&self) -> bool {
        self.is_open && self.start.is_none()
    }
}
