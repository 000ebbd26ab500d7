//! From a tag to a request: which meshes, which scale, which kind of collider, and whether there is
//! anything to do at all.

use std::sync::Arc;

use bevy::asset::{AssetId, LoadState, UntypedAssetId};
use bevy::ecs::system::SystemParam;
use bevy::math::Affine3A;
use bevy::prelude::*;
use bevy_rapier3d::prelude::Collider;

use crate::bevy::collider::placement::{MapKey, Placements};
use crate::bevy::collider::skip::{FarFromFocus, SkipRules, is_too_small};
use crate::bevy::collider::static_geometry::StaticGeometry;
use crate::bevy::jobs::baked::{BakedDecomposition, BakedHulls};
use crate::bevy::jobs::baked_scene::{BakedScene, FromBakedScene};
use crate::bevy::jobs::cache::GeometryCache;
use crate::bevy::jobs::content::{ContentKey, goal_hash};
use crate::bevy::jobs::mesh_data::MeshPart;
use crate::bevy::jobs::queue::{Completed, Failed, WorkQueue};
use crate::bevy::jobs::request::{
    AttachedCollider, AttachedFallback, ColliderRequest, FailedRequest, InputBoundary, InputId,
};
use crate::bevy::jobs::task::BuiltCollider;
use crate::bevy::tag::components::ConvexDecomposition;
use crate::bevy::tag::describe::{Descriptions, entities};
use crate::bevy::tag::error::DecompositionError;
use crate::bevy::tag::outcomes::Outcomes;
use crate::bevy::tag::parameters::{Goal, has_absolute_length};
use crate::bevy::tag::settings::{FallbackCollider, HullwrightSettings};
use crate::bevy::tag::status::{DecompositionStatus, HullSource, SkipReason, WaitReason};

/// Everything from which requests follow.
#[derive(SystemParam)]
pub(crate) struct Scene<'w, 's> {
    tags: Query<'w, 's, TagComponents>,
    boundaries: Query<'w, 's, (), InputBoundary>,
    meshes_on: Query<'w, 's, &'static Mesh3d>,
    children: Query<'w, 's, &'static Children>,
    parents: Query<'w, 's, &'static ChildOf>,
    transforms: Query<'w, 's, &'static Transform>,
    failed: Query<'w, 's, (), With<FailedRequest>>,
    placements: Placements<'w, 's>,
    geometry: StaticGeometry<'w, 's>,
    skip_rules: SkipRules<'w, 's>,
    descriptions: Descriptions<'w, 's>,
    meshes: Res<'w, Assets<Mesh>>,
    baked: Res<'w, Assets<BakedHulls>>,
    scenes: Res<'w, Assets<BakedScene>>,
    from_scenes: Query<'w, 's, &'static FromBakedScene>,
    server: Option<Res<'w, AssetServer>>,
}

type TagComponents = (
    Option<&'static ConvexDecomposition>,
    Option<&'static BakedDecomposition>,
    Has<Collider>,
    Has<AttachedCollider>,
    Has<AttachedFallback>,
);

/// The next state of an entity.
enum Resolution {
    /// It is gone, or has no tag any more.
    Gone,
    /// What it is made of is not there yet.
    Later(Missing),
    Skipped(SkipReason),
    Failed(Box<ColliderRequest>, DecompositionError),
    Request(Box<ColliderRequest>),
}

/// What an entity waits for.
enum Missing {
    /// There is no mesh on it or below it.
    Mesh,
    /// This asset is not loaded.
    Asset(UntypedAssetId),
}

impl Missing {
    fn asset(&self) -> Option<UntypedAssetId> {
        match self {
            Self::Mesh => None,
            Self::Asset(id) => Some(*id),
        }
    }
}

impl Resolution {
    fn not_loaded(request: Box<ColliderRequest>) -> Self {
        Self::Failed(request, DecompositionError::NotLoaded)
    }
}

/// Resolves entities whose meshes are not known yet, each at most once per frame.
pub(crate) fn resolve(
    mut queue: ResMut<WorkQueue>,
    settings: Res<HullwrightSettings>,
    cache: Res<GeometryCache>,
    scene: Scene,
    mut outcomes: Outcomes,
) {
    let mut budget = queue.frame_time.budget(&settings);
    let mut overdue = Vec::new();
    for _ in 0..queue.to_resolve.len() {
        if !budget.allows_one() {
            break;
        }
        let Some(entity) = queue.to_resolve.pop_front() else { break };
        let resolution = scene.resolution(entity, &settings);
        if scene.failed.contains(entity) && !matches!(resolution, Resolution::Later(_)) {
            outcomes.commands.entity(entity).try_remove::<FailedRequest>();
        }
        match resolution {
            Resolution::Gone => {
                queue.unfinished.remove(&entity);
                outcomes.cancelled(entity);
            }
            Resolution::Later(missing) => {
                queue.to_resolve.push_back(entity);
                if is_overdue(&mut queue, entity, &settings) {
                    overdue.push((entity, missing));
                }
            }
            Resolution::Skipped(reason) => {
                queue.unfinished.remove(&entity);
                if reason == SkipReason::TooFar {
                    outcomes.commands.entity(entity).try_insert(FarFromFocus);
                }
                outcomes.skipped(entity, reason);
            }
            Resolution::Failed(request, error) => {
                queue.failed.push(Failed { entity, error, is_known: false });
                set_request(&mut queue, entity, request.into());
            }
            Resolution::Request(request) => {
                let request: Arc<ColliderRequest> = Arc::from(request);
                set_request(&mut queue, entity, request.clone());
                match known_result(&queue, &cache, &request) {
                    Some(Ok(built)) => {
                        queue.completed.push_back(Completed { entity, request, built });
                    }
                    Some(Err(error)) => {
                        queue.failed.push(Failed { entity, error, is_known: true });
                    }
                    None => {
                        queue.to_start.push(entity);
                        if scene.wants_fallback(entity, &settings) {
                            queue.fallbacks.waiting.push_back(entity);
                        }
                        outcomes.show(entity, DecompositionStatus::Waiting(WaitReason::InQueue));
                    }
                }
            }
        }
    }
    queue.frame_time.spend(&budget);
    log_overdue(&overdue, &scene.descriptions);
}

/// Whether an entity has waited for longer than most do, which is said once.
fn is_overdue(queue: &mut WorkQueue, entity: Entity, settings: &HullwrightSettings) -> bool {
    let (Some(patience), Some(unfinished)) =
        (settings.warn_without_mesh_after, queue.unfinished.get_mut(&entity))
    else {
        return false;
    };
    let is_overdue = !unfinished.is_wait_logged && unfinished.since.elapsed() >= patience;
    unfinished.is_wait_logged |= is_overdue;
    is_overdue
}

/// One line for those that have no mesh, and one for those whose asset is not loaded.
fn log_overdue(overdue: &[(Entity, Missing)], descriptions: &Descriptions) {
    let log = |of_kind: fn(&Missing) -> bool, why: &str| {
        let mut all = overdue.iter().filter(|(_, missing)| of_kind(missing)).peekable();
        if let Some((entity, missing)) = all.peek() {
            let first = descriptions.entity(*entity, missing.asset());
            let who = entities(all.count(), &first);
            log::warn!("no convex decomposition yet for {who}: {why}");
        }
    };
    log(|missing| missing.asset().is_none(), "there is no Mesh3d on it or below it");
    log(|missing| missing.asset().is_some(), "the asset is not loaded");
}

fn set_request(queue: &mut WorkQueue, entity: Entity, request: Arc<ColliderRequest>) {
    if let Some(unfinished) = queue.unfinished.get_mut(&entity) {
        unfinished.request = Some(request);
    }
}

/// A result that is there without any work.
fn known_result(
    queue: &WorkQueue,
    cache: &GeometryCache,
    request: &ColliderRequest,
) -> Option<Result<BuiltCollider, DecompositionError>> {
    let key = match queue.known.get(&request.input)? {
        Ok(key) => *key,
        Err(error) => return Some(Err(error.clone())),
    };
    let (geometry, shape) = cache.shape(key, request.map_key())?;
    let source = match key {
        ContentKey::Mesh { .. } => HullSource::Shared,
        ContentKey::Baked(_) => HullSource::Baked,
    };
    Some(Ok(BuiltCollider { key, geometry, shape, source }))
}

impl Scene<'_, '_> {
    fn resolution(&self, entity: Entity, settings: &HullwrightSettings) -> Resolution {
        let Ok((tag, baked, has_collider, is_attached, is_fallback)) = self.tags.get(entity) else {
            return Resolution::Gone;
        };
        if has_collider && !is_attached && !is_fallback {
            return Resolution::Skipped(SkipReason::HasCollider);
        }
        match (baked, tag) {
            (Some(baked), _) => self.baked_request(entity, baked),
            (None, Some(tag)) => match self.skip_rules.reason(entity) {
                Some(reason) => Resolution::Skipped(reason),
                None => self.mesh_request(entity, tag, settings),
            },
            (None, None) => Resolution::Gone,
        }
    }

    fn baked_request(&self, entity: Entity, baked: &BakedDecomposition) -> Resolution {
        let id = baked.hulls.id();
        let is_missing = !self.baked.contains(id);
        if is_missing && !self.failed_to_load(id.untyped()) {
            return Resolution::Later(Missing::Asset(id.untyped()));
        }
        let placement = self.placements.placement(entity);
        let request = Box::new(ColliderRequest {
            input: Arc::new(InputId::Baked(id)),
            parts: Vec::new(),
            goal: None,
            scene: None,
            map_before: Affine3A::IDENTITY,
            map: placement.map,
            stretch: placement.stretch,
        });
        if is_missing { Resolution::not_loaded(request) } else { Resolution::Request(request) }
    }

    fn mesh_request(
        &self,
        entity: Entity,
        tag: &ConvexDecomposition,
        settings: &HullwrightSettings,
    ) -> Resolution {
        let mut parts = Vec::new();
        self.collect(entity, entity, &mut parts);
        if parts.is_empty() {
            return Resolution::Later(Missing::Mesh);
        }
        let missing = parts.iter().map(|part| part.mesh).find(|mesh| !self.meshes.contains(*mesh));
        if let Some(mesh) = missing.filter(|mesh| !self.failed_to_load(mesh.untyped())) {
            return Resolution::Later(Missing::Asset(mesh.untyped()));
        }
        let scene = self.from_scenes.get(entity).ok().map(|from| from.0.id());
        if let Some(scene) = scene.filter(|scene| self.is_still_loading(*scene)) {
            return Resolution::Later(Missing::Asset(scene.untyped()));
        }
        let placement = self.placements.placement(entity);
        let goal = self.goal(entity, tag);
        if is_too_small(&parts, &placement, &self.meshes, settings) {
            return Resolution::Skipped(SkipReason::TooSmall);
        }
        // A bound in metres means metres of the world, so the mesh is scaled first.
        let (map_before, map) = match goal.parameters().is_some_and(has_absolute_length) {
            true => (placement.map, Affine3A::IDENTITY),
            false => (Affine3A::IDENTITY, placement.map),
        };
        let input = InputId::Meshes {
            parts: parts.iter().map(|part| (part.mesh, MapKey::new(&part.to_input))).collect(),
            goal: goal_hash(&goal),
            map_before: MapKey::new(&map_before),
        };
        let request = Box::new(ColliderRequest {
            input: Arc::new(input),
            parts,
            goal: Some(goal),
            scene,
            map_before,
            map,
            stretch: placement.stretch,
        });
        if missing.is_some() {
            Resolution::not_loaded(request)
        } else {
            Resolution::Request(request)
        }
    }

    fn goal(&self, entity: Entity, tag: &ConvexDecomposition) -> Goal {
        if let Some(reason) = self.geometry.why_triangles(entity, tag.shape) {
            return Goal::Triangles(reason);
        }
        let mut goal = Goal::of(tag);
        if self.is_primitive_among_others(entity) {
            goal.keep_openings_of_part();
        }
        goal
    }

    /// Whether an entity is one of several primitives of a glTF mesh, which Bevy spawns as children of one
    /// node without transforms of their own.
    fn is_primitive_among_others(&self, entity: Entity) -> bool {
        let is_primitive = |entity: Entity| {
            let transform = self.transforms.get(entity);
            self.meshes_on.contains(entity)
                && transform.is_ok_and(|transform| *transform == Transform::IDENTITY)
        };
        let Ok(siblings) = self.parents.get(entity).and_then(|of| self.children.get(of.parent()))
        else {
            return false;
        };
        is_primitive(entity) && siblings.iter().filter(|child| is_primitive(*child)).count() > 1
    }

    /// The meshes on an entity and below it, in the order of the children.
    fn collect(&self, top: Entity, entity: Entity, parts: &mut Vec<MeshPart>) {
        if entity != top && self.boundaries.contains(entity) {
            return;
        }
        if let Ok(mesh) = self.meshes_on.get(entity) {
            let to_input = self.placements.relative(entity, top);
            parts.push(MeshPart { mesh: mesh.id(), to_input });
        }
        if let Ok(children) = self.children.get(entity) {
            for child in children {
                self.collect(top, *child, parts);
            }
        }
    }

    /// Whether a scene is neither there nor lost.
    fn is_still_loading(&self, scene: AssetId<BakedScene>) -> bool {
        !self.scenes.contains(scene) && !self.failed_to_load(scene.untyped())
    }

    /// Whether an asset that is not there will not come.
    fn failed_to_load(&self, id: UntypedAssetId) -> bool {
        let state = self.server.as_ref().and_then(|server| server.get_load_state(id));
        matches!(state, Some(LoadState::Failed(_)))
    }

    /// Whether an entity gets a fallback before its first collider.
    fn wants_fallback(&self, entity: Entity, settings: &HullwrightSettings) -> bool {
        let Ok((Some(tag), None, false, ..)) = self.tags.get(entity) else { return false };
        tag.fallback_collider.unwrap_or(settings.fallback_collider) != FallbackCollider::None
    }
}
