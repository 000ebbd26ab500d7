//! Ends the scenes all of whose meshes are finished.

use std::time::Duration;

#[cfg(feature = "bevy_gltf")]
use bevy::asset::LoadState;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use crate::bevy::jobs::baked_scene::{Absence, BakedScene};
use crate::bevy::jobs::queue::WorkQueue;
use crate::bevy::jobs::request::AttachedCollider;
use crate::bevy::scene::hierarchy::ConvexDecompositionHierarchy;
use crate::bevy::scene::hierarchy_status::{
    HierarchyFinished, HierarchyReport, HierarchyStatus, HierarchyWork, SceneState,
};
use crate::bevy::scene::nodes::Nodes;
use crate::bevy::tag::components::ConvexDecomposition;
use crate::bevy::tag::parameters::Goal;
use crate::bevy::tag::status::DecompositionStatus;

/// Meshes that the log names one by one; of more it says how many.
const MOST_LOGGED: usize = 20;

/// What is known of scenes, and from what the colliders below them were made.
#[derive(SystemParam)]
pub(crate) struct Scenes<'w, 's> {
    #[cfg(feature = "bevy_gltf")]
    roots: Query<'w, 's, &'static WorldAssetRoot>,
    #[cfg(feature = "bevy_gltf")]
    server: Option<Res<'w, AssetServer>>,
    baked: Res<'w, Assets<BakedScene>>,
    queue: Res<'w, WorkQueue>,
    nodes: Nodes<'w, 's>,
    attached: Query<'w, 's, (&'static AttachedCollider, &'static ConvexDecomposition)>,
}

impl Scenes<'_, '_> {
    /// Whether Bevy has still to spawn meshes below an entity.
    #[cfg(feature = "bevy_gltf")]
    fn is_to_be_spawned(&self, entity: Entity, state: SceneState) -> bool {
        self.roots.contains(entity) && state == SceneState::Unknown && !self.is_lost(entity)
    }

    #[cfg(not(feature = "bevy_gltf"))]
    fn is_to_be_spawned(&self, _entity: Entity, _state: SceneState) -> bool {
        false
    }

    /// Whether the scene of an entity could not be loaded. Bevy spawns one whose textures are missing.
    #[cfg(feature = "bevy_gltf")]
    fn is_lost(&self, entity: Entity) -> bool {
        let (Ok(root), Some(server)) = (self.roots.get(entity), &self.server) else { return false };
        matches!(server.get_load_state(&root.0), Some(LoadState::Failed(_)))
    }

    #[cfg(not(feature = "bevy_gltf"))]
    fn is_lost(&self, _entity: Entity) -> bool {
        false
    }

    /// Counts what came from a baked scene, and returns what did not and why, as a sentence without subject.
    fn compare(
        &self,
        handle: &Handle<BakedScene>,
        nodes: &[Entity],
        report: &mut HierarchyReport,
    ) -> Option<String> {
        let Some(baked) = self.baked.get(handle) else {
            report.missing = report.ready;
            return Some("could not be loaded: its meshes were decomposed".into());
        };
        let mut lines = Vec::new();
        for &node in nodes {
            let Ok((attached, tag)) = self.attached.get(node) else { continue };
            let Some(Ok(key)) = self.queue.known.get(&attached.input) else { continue };
            let goal = Goal::of(tag);
            let Some(parameters) = goal.parameters().filter(|_| attached.why_triangles.is_none())
            else {
                continue;
            };
            if baked.geometry().get(*key).is_some() {
                report.from_baked += 1;
                continue;
            }
            let names: Vec<&str> = self.nodes.names_of(node).into_iter().flatten().collect();
            let name = names.first().copied().unwrap_or("a mesh without a name");
            match baked.reason_of_absence(*key, parameters, &names) {
                None => report.from_baked += 1,
                Some(Absence::Stale(why)) => {
                    report.stale += 1;
                    lines.push(format!("`{name}` ({node}): {why}"));
                }
                Some(Absence::Missing) => {
                    report.missing += 1;
                    lines.push(format!("`{name}` ({node}): it is not in the file"));
                }
            }
        }
        if lines.is_empty() {
            return None;
        }
        let more = lines.len().saturating_sub(MOST_LOGGED);
        lines.truncate(MOST_LOGGED);
        if more > 0 {
            lines.push(format!("and {more} more"));
        }
        let lines = lines.join("; ");
        Some(format!("has no hulls for: {lines}. They were decomposed; bake it anew"))
    }
}

/// Ends the hierarchies all of whose meshes are finished.
pub(crate) fn finish_hierarchies(
    mut commands: Commands,
    mut hierarchies: Query<(
        Entity,
        &ConvexDecompositionHierarchy,
        &mut HierarchyWork,
        &mut HierarchyStatus,
    )>,
    statuses: Query<&DecompositionStatus>,
    scenes: Scenes,
) {
    for (entity, hierarchy, mut work, mut status) in &mut hierarchies {
        if !work.is_open {
            continue;
        }
        let is_running =
            |node: &Entity| statuses.get(*node).is_ok_and(|status| !status.is_finished());
        work.unfinished.retain(is_running);
        let has_begun = work.start.is_some() || work.scene == SceneState::Spawned;
        let is_lost = scenes.is_lost(entity);
        if scenes.is_to_be_spawned(entity, work.scene) || !(has_begun || is_lost) {
            status.set_if_neq(HierarchyStatus::Waiting);
            continue;
        }
        if !work.unfinished.is_empty() {
            status.set_if_neq(HierarchyStatus::Running);
            continue;
        }
        let mut report = HierarchyReport {
            left_out: work.left_out,
            is_lost,
            time: work.start.map_or(Duration::ZERO, |start| start.elapsed()),
            ..default()
        };
        for &node in &work.nodes {
            match statuses.get(node) {
                Ok(DecompositionStatus::Ready(_)) => report.ready += 1,
                Ok(DecompositionStatus::Skipped(_)) => report.skipped += 1,
                Ok(DecompositionStatus::Failed(_)) => report.failed += 1,
                _ => report.cancelled += 1,
            }
        }
        if let Some(handle) = &hierarchy.baked
            && let Some(difference) = scenes.compare(handle, &work.nodes, &mut report)
        {
            let path = handle.path().map_or_else(|| "the baked scene".into(), ToString::to_string);
            log::warn!("{path} of {entity} {difference}");
        }
        (work.is_open, work.start) = (false, None);
        *status = HierarchyStatus::Finished(report);
        commands.trigger(HierarchyFinished { entity, report });
    }
}

/// Bevy has spawned the scene below a hierarchy.
#[cfg(feature = "bevy_gltf")]
pub(crate) fn on_scene_spawned(
    spawned: On<bevy::world_serialization::WorldInstanceReady>,
    mut works: Query<&mut HierarchyWork>,
) {
    if let Ok(mut work) = works.get_mut(spawned.entity) {
        work.scene = SceneState::Spawned;
    }
}
