//! Whole scenes, tagged at once and ended together, and how far all work is.

#[cfg(feature = "bevy_gltf")]
pub(super) mod collision_systems;
mod complaints;
#[cfg(feature = "bevy_gltf")]
mod declared;
#[cfg(feature = "bevy_gltf")]
mod gltf_physics;
pub(super) mod hierarchy;
#[cfg(feature = "bevy_gltf")]
mod linked_levels;
#[cfg(feature = "bevy_gltf")]
mod shapes;
pub(super) mod tagging;
#[cfg(feature = "bevy_gltf")]
mod written_hulls;

use std::time::Duration;

#[cfg(feature = "bevy_gltf")]
use bevy::asset::LoadState;
use bevy::ecs::entity::{EntityHashMap, EntityHashSet};
use bevy::ecs::system::SystemParam;
#[cfg(feature = "bevy_gltf")]
use bevy::gltf::extensions::{ErasedGltfExtensionHandler, GltfExtensionHandlers};
use bevy::prelude::*;
#[cfg(feature = "bevy_gltf")]
use bevy::tasks::block_on;
#[cfg(feature = "bevy_gltf")]
use bevy::world_serialization::{WorldInstance, WorldInstanceSpawner};

use self::hierarchy::{
    ConvexDecompositionHierarchy, HierarchyFinished, HierarchyReport, HierarchyStatus,
    HierarchyWork,
};
use self::tagging::{
    ColliderPieceOf, ColliderPieces, Nodes, TaggedByHierarchy, on_hierarchy_gone, tag_hierarchies,
};
use super::collider::CollidersAttached;
use super::collider::changes::detect_tags;
use super::collider::work::{AttachedCollider, Unfinished};
use super::engine::Engine;
use super::jobs::baked::{Absence, BakedScene};
use super::jobs::{Jobs, SlicesRun};
use super::tag::ConvexDecomposition;
use super::tag::outcomes::DecompositionStatus;
use super::tag::parameters::Goal;
use super::tag::settings::HullwrightSystems;

/// Tags whole scenes, and sums up how far they and all else are.
pub(super) fn plugin<E: Engine>(app: &mut App) {
    app.init_resource::<DecompositionProgress>()
        .add_observer(on_hierarchy_gone)
        .register_type::<TaggedByHierarchy>()
        .register_type::<ConvexDecompositionHierarchy>()
        .register_type::<HierarchyStatus>()
        .register_type::<ColliderPieceOf>()
        .register_type::<ColliderPieces>()
        .register_type::<DecompositionProgress>();
    #[cfg(feature = "bevy_gltf")]
    follow_files::<E>(app);
    app.add_systems(
        PostUpdate,
        (
            tag_hierarchies::<E>.before(detect_tags::<E>).in_set(HullwrightSystems::DetectChanges),
            (
                (reopen, finish_hierarchies::<E>)
                    .chain()
                    .run_if(any_with_component::<HierarchyWork>),
                sum_up_progress,
            )
                .chain()
                .after(CollidersAttached)
                .before(SlicesRun)
                .in_set(HullwrightSystems::Attach),
        ),
    );
}

/// Puts on the nodes of glTF files what these say of physics, before they are tagged.
#[cfg(feature = "bevy_gltf")]
fn follow_files<E: Engine>(app: &mut App) {
    // Whichever comes first, this or Bevy's plugin for glTF.
    app.init_resource::<GltfExtensionHandlers>();
    let handlers = app.world().resource::<GltfExtensionHandlers>();
    // Browsers have no `write_blocking`.
    block_on(handlers.0.write()).extend::<[Box<dyn ErasedGltfExtensionHandler>; 2]>([
        Box::new(linked_levels::LinkedLevels::default()),
        Box::new(gltf_physics::PhysicsReader::default()),
    ]);
    app.init_resource::<collision_systems::CollisionSystems>()
        .register_type::<gltf_physics::GltfPhysics>()
        .register_type::<gltf_physics::MadeOfMeshes>()
        .register_type::<gltf_physics::ColliderMesh>()
        .register_type::<gltf_physics::HullsInFile>()
        .register_type::<collision_systems::CollisionSystems>()
        .register_type::<tagging::HiddenByHierarchy>()
        .register_type::<declared::Declared>()
        .add_systems(
            PostUpdate,
            (
                declared::set_masses::<E>,
                (declared::declare::<E>, declared::inherit_surfaces::<E>).chain(),
            )
                .before(tag_hierarchies::<E>)
                .before(detect_tags::<E>)
                .in_set(HullwrightSystems::DetectChanges),
        );
}

/// Meshes that the log names one by one; of more it says how many.
const MOST_LOGGED: usize = 20;

/// What is known of scenes, and from what the colliders below them were made.
#[derive(SystemParam)]
struct Scenes<'w, 's, E: Engine> {
    #[cfg(feature = "bevy_gltf")]
    roots: Query<'w, 's, &'static WorldAssetRoot>,
    #[cfg(feature = "bevy_gltf")]
    instances: Query<'w, 's, &'static WorldInstance>,
    #[cfg(feature = "bevy_gltf")]
    spawner: Option<Res<'w, WorldInstanceSpawner>>,
    #[cfg(feature = "bevy_gltf")]
    server: Option<Res<'w, AssetServer>>,
    baked: Res<'w, Assets<BakedScene>>,
    jobs: Res<'w, Jobs>,
    nodes: Nodes<'w, 's, E>,
    attached: Query<'w, 's, &'static AttachedCollider, With<ConvexDecomposition>>,
}

impl<E: Engine> Scenes<'_, '_, E> {
    /// Whether Bevy has spawned the scene below an entity, and whether that could not be loaded;
    /// `None` if it has none to spawn. It spawns one whose textures are missing.
    fn is_spawned_or_lost(&self, entity: Entity) -> Option<(bool, bool)> {
        #[cfg(feature = "bevy_gltf")]
        if let Ok(root) = self.roots.get(entity) {
            let state = self.server.as_ref().and_then(|server| server.get_load_state(&root.0));
            let instance = self.instances.get(entity).ok().zip(self.spawner.as_ref());
            let is_spawned = instance.is_some_and(|(id, spawner)| spawner.instance_is_ready(**id));
            return Some((is_spawned, matches!(state, Some(LoadState::Failed(_)))));
        }
        let _ = entity;
        None
    }

    /// What the log says of a scene that could not be loaded, beside Bevy's own line.
    fn explain_loss(&self, entity: Entity) {
        #[cfg(feature = "bevy_gltf")]
        if let Ok(root) = self.roots.get(entity)
            && let Some(LoadState::Failed(error)) =
                self.server.as_ref().and_then(|server| server.get_load_state(&root.0))
        {
            gltf_physics::explain_refusal(entity, &error.to_string());
        }
        let _ = entity;
    }

    /// Counts what came from a baked scene, and returns what did not and why, as a sentence without
    /// subject. Meshes whose hulls are in their own file are left out.
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
        for &node in nodes.iter().filter(|node| !self.has_hulls_in_file(**node)) {
            let why = match self.found(node, baked) {
                None => continue,
                Some(Ok(())) => {
                    report.from_baked += 1;
                    continue;
                }
                Some(Err(Absence::Stale(why))) => {
                    report.stale += 1;
                    why
                }
                Some(Err(Absence::Missing)) => {
                    report.missing += 1;
                    "it is not in the file".into()
                }
            };
            lines.push(self.line(node, &why));
        }
        without_hulls(lines)
    }

    /// Whether a node has hulls of a baked scene, or why not; `None` for what is not decomposed.
    fn found(&self, node: Entity, baked: &BakedScene) -> Option<Result<(), Absence>> {
        let request = &self.attached.get(node).ok()?.requested.request;
        let key = self.jobs.key_of(&request.input)?;
        let parameters = request.goal.as_ref().and_then(Goal::parameters)?;
        if key.is_baked() {
            return Some(Ok(()));
        }
        let names: Vec<&str> = self.nodes.names_of(node).into_iter().flatten().collect();
        Some(Err(baked.absence(key, parameters, &names)))
    }

    fn line(&self, node: Entity, why: &str) -> String {
        let name = self.nodes.names_of(node).into_iter().flatten().next();
        format!("`{}` ({node}): {why}", name.unwrap_or("a mesh without a name"))
    }

    fn has_hulls_in_file(&self, node: Entity) -> bool {
        #[cfg(feature = "bevy_gltf")]
        return self.nodes.hulls_in_file(node).is_some();
        #[cfg(not(feature = "bevy_gltf"))]
        return (node, false).1;
    }

    /// The same of hulls that are in the file of the meshes.
    #[cfg(feature = "bevy_gltf")]
    fn compare_with_file(&self, nodes: &[Entity], report: &mut HierarchyReport) -> Option<String> {
        let mut lines = Vec::new();
        for &node in nodes {
            let Some(hulls) = self.nodes.hulls_in_file(node) else { continue };
            if self.nodes.has_edited_hulls(node) {
                report.from_file += 1;
                report.edited += 1;
                continue;
            }
            let found = self.baked.get(&hulls.scene).and_then(|baked| self.found(node, baked));
            match found {
                None => {}
                Some(Ok(())) => report.from_file += 1,
                Some(Err(absence)) => {
                    report.stale += 1;
                    lines.push(self.line(
                        node,
                        match &absence {
                            Absence::Stale(why) => why,
                            // The hulls are those of the node, so its mesh is another.
                            Absence::Missing => "the mesh has changed since it was baked",
                        },
                    ));
                }
            }
        }
        without_hulls(lines)
    }
}

/// What the log says of meshes that were decomposed though they were baked.
fn without_hulls(mut lines: Vec<String>) -> Option<String> {
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

/// A baked scene that came late or changed has restarted what may be in it.
fn reopen(
    mut events: MessageReader<AssetEvent<BakedScene>>,
    mut hierarchies: Query<(&ConvexDecompositionHierarchy, &mut HierarchyWork)>,
    unfinished: Res<Unfinished>,
) {
    for event in events.read() {
        let (AssetEvent::Added { id } | AssetEvent::Modified { id }) = event else { continue };
        for (hierarchy, mut work) in &mut hierarchies {
            let is_restarted = || work.nodes.iter().any(|node| unfinished.contains(*node));
            let takes_it = hierarchy.baked.as_ref().is_some_and(|baked| baked.id() == *id);
            if takes_it && !work.is_open && is_restarted() {
                work.reopen();
            }
        }
    }
}

/// Ends the hierarchies whose meshes are all finished.
fn finish_hierarchies<E: Engine>(
    mut commands: Commands,
    mut hierarchies: Query<(
        Entity,
        &ConvexDecompositionHierarchy,
        &mut HierarchyWork,
        &mut HierarchyStatus,
    )>,
    statuses: Query<&DecompositionStatus>,
    parents: Query<&ChildOf>,
    scenes: Scenes<E>,
) {
    let above =
        |entity| parents.iter_ancestors(entity).filter(|above| hierarchies.contains(*above));
    let open = hierarchies.iter().filter(|(_, _, work, _)| work.is_open);
    let open: Vec<Entity> = open.map(|(entity, ..)| entity).collect();
    if open.is_empty() {
        return;
    }
    // One that holds others ends after them, and anew when they do.
    let waiting: EntityHashSet = open.iter().flat_map(|entity| above(*entity)).collect();
    let mut inner: EntityHashMap<Vec<HierarchyReport>> = EntityHashMap::default();
    for (entity, _, _, status) in &hierarchies {
        if let (HierarchyStatus::Finished(report), Some(outer)) = (status, above(entity).next()) {
            inner.entry(outer).or_default().push(*report);
        }
    }
    for (entity, hierarchy, mut work, mut status) in &mut hierarchies {
        let waits = waiting.contains(&entity);
        if waits && !work.is_open {
            work.reopen();
        }
        if !work.is_open {
            continue;
        }
        let is_running =
            |node: &Entity| statuses.get(*node).is_ok_and(|status| !status.is_finished());
        work.unfinished.retain(is_running);
        let has_inner = waits || inner.contains_key(&entity);
        let from_elsewhere = (work.start.is_some() || has_inner, false);
        let (is_there, is_lost) = scenes.is_spawned_or_lost(entity).unwrap_or(from_elsewhere);
        if !is_there && !is_lost {
            status.set_if_neq(HierarchyStatus::Waiting);
            continue;
        }
        if waits || !work.unfinished.is_empty() {
            status.set_if_neq(HierarchyStatus::Running);
            continue;
        }
        if is_lost {
            scenes.explain_loss(entity);
        }
        let mut report = HierarchyReport {
            left_out: work.left_out,
            is_lost,
            time: work.start.map_or(Duration::ZERO, |start| start.elapsed()),
            ..default()
        };
        for &node in &work.nodes {
            let status = statuses.get(node).ok();
            match status.and_then(DecompositionStatus::has_collider) {
                Some(true) => report.with_collider += 1,
                _ => report.without_collider += 1,
            }
            match status {
                Some(DecompositionStatus::Ready(_)) => report.ready += 1,
                Some(DecompositionStatus::Skipped(_)) => report.skipped += 1,
                Some(DecompositionStatus::Failed(_)) => report.failed += 1,
                _ => report.cancelled += 1,
            }
        }
        if let Some(handle) = &hierarchy.baked
            && let Some(difference) = scenes.compare(handle, &work.nodes, &mut report)
        {
            let path = handle.path().map_or_else(|| "the baked scene".into(), ToString::to_string);
            log::warn!("{path} of {entity} {difference}");
        }
        #[cfg(feature = "bevy_gltf")]
        if let Some(difference) = scenes.compare_with_file(&work.nodes, &mut report) {
            log::warn!("the glTF file of {entity} {difference}");
        }
        inner.get(&entity).into_iter().flatten().for_each(|inner| report.add(inner));
        (work.is_open, work.start) = (false, None);
        *status = HierarchyStatus::Finished(report);
        commands.trigger(HierarchyFinished { entity, report });
    }
}

/// How far all work is, from the first tag since everything was finished.
///
/// It is up to date after the plugin's systems, in `PostUpdate`. Whether all is done says
/// [`all_decompositions_done`] also for what was tagged since.
#[derive(Resource, Reflect, Debug, Clone, Copy, PartialEq, Default)]
#[reflect(Resource, Default, Clone, PartialEq)]
#[type_path = "hullwright"]
pub struct DecompositionProgress {
    /// Entities that are finished, however they ended.
    pub finished: usize,
    /// Entities in all; scenes that are not there yet count as one.
    pub total: usize,
    /// Share of the work that is done, from 0 to 1, with jobs at work by their own progress. It
    /// never falls until all is finished.
    pub fraction: f32,
}

impl DecompositionProgress {
    /// Whether all is finished, or there was nothing to do.
    pub fn is_done(&self) -> bool {
        self.finished == self.total
    }
}

/// A run condition: nothing that is tagged waits or is at work, and no scene below a
/// [`ConvexDecompositionHierarchy`](crate::ConvexDecompositionHierarchy) is still to come. It looks
/// at every tagged entity, so it includes those of this frame. O(tagged entities).
///
/// ```
/// use bevy::prelude::*;
/// use bevy_hullwright::prelude::*;
///
/// # let mut app = App::new();
/// app.add_systems(Update, start_level.run_if(all_decompositions_done));
/// # fn start_level() {}
/// ```
pub fn all_decompositions_done(
    statuses: Query<&DecompositionStatus>,
    hierarchies: Query<&HierarchyStatus>,
) -> bool {
    hierarchies.iter().all(HierarchyStatus::is_finished)
        && statuses.iter().all(DecompositionStatus::is_finished)
}

/// A run condition: the opposite of [`all_decompositions_done`], for what a loading screen shows.
pub fn decompositions_pending(
    statuses: Query<&DecompositionStatus>,
    hierarchies: Query<&HierarchyStatus>,
) -> bool {
    !all_decompositions_done(statuses, hierarchies)
}

/// What must not reach 1 before all is finished.
const ALMOST: f32 = 0.999;

/// Sums up the work.
fn sum_up_progress(
    mut unfinished: ResMut<Unfinished>,
    jobs: Res<Jobs>,
    mut progress: ResMut<DecompositionProgress>,
    hierarchies: Query<&HierarchyWork>,
) {
    let to_come = hierarchies.iter().filter(|work| work.is_to_come()).count();
    let open = unfinished.len() + to_come;
    if open == 0 {
        unfinished.begin_anew();
        if !progress.is_done() || progress.fraction < 1.0 {
            let total = progress.total;
            *progress = DecompositionProgress { finished: total, total, fraction: 1.0 };
        }
        return;
    }
    let total = unfinished.entered() + to_come;
    let (finished, running) = (total - open, jobs.progress());
    let fraction = ((finished as f32 + running) / total as f32).min(ALMOST);
    let least = if progress.is_done() { 0.0 } else { progress.fraction };
    let now = DecompositionProgress { finished, total, fraction: fraction.max(least) };
    progress.set_if_neq(now);
}
