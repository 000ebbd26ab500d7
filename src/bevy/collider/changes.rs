//! What makes an entity's collider out of date: a new tag, a changed mesh, a changed scale. All of
//! it by Bevy's change detection, so that finished entities cost next to nothing.

use bevy::asset::AssetEvent;
use bevy::ecs::system::SystemParam;
use bevy::platform::time::Instant;
use bevy::prelude::*;
use bevy_rapier3d::prelude::{ColliderScale, RigidBody, Sensor};

use crate::bevy::collider::placement::Stretch;
use crate::bevy::collider::static_geometry::StaticGeometry;
use crate::bevy::jobs::baked::{BakedDecomposition, BakedHulls};
use crate::bevy::jobs::cache::GeometryCache;
use crate::bevy::jobs::content::ContentKey;
use crate::bevy::jobs::queue::WorkQueue;
use crate::bevy::jobs::request::{
    AttachedCollider, ColliderRequest, FailedRequest, InputBoundary, InputId,
};
use crate::bevy::tag::components::ConvexDecomposition;
use crate::bevy::tag::outcomes::Outcomes;
use crate::bevy::tag::settings::HullwrightSettings;
use crate::bevy::tag::status::{DecompositionStatus, WaitReason};

type ChangedTag = Or<(Changed<ConvexDecomposition>, Changed<BakedDecomposition>)>;
type Tagged = Or<(With<ConvexDecomposition>, With<BakedDecomposition>)>;
type MadeOfMeshes = (With<ConvexDecomposition>, Without<BakedDecomposition>);

/// The tagged entities that meshes belong to.
#[derive(SystemParam)]
pub(crate) struct MeshOwners<'w, 's> {
    made_of_meshes: Query<'w, 's, (), MadeOfMeshes>,
    boundaries: Query<'w, 's, (), InputBoundary>,
    parents: Query<'w, 's, &'static ChildOf>,
}

impl MeshOwners<'_, '_> {
    fn owner(&self, mesh: Entity) -> Option<Entity> {
        let mut on_and_above = std::iter::once(mesh).chain(self.parents.iter_ancestors(mesh));
        let top = on_and_above.find(|entity| self.boundaries.contains(*entity));
        top.filter(|entity| self.made_of_meshes.contains(*entity))
    }
}

/// Tags that are new or changed, and meshes that replaced another.
pub(crate) fn detect_tags(
    mut queue: ResMut<WorkQueue>,
    changed_tags: Query<Entity, ChangedTag>,
    changed_meshes: Query<Entity, Changed<Mesh3d>>,
    owners: MeshOwners,
    mut statuses: Query<&mut DecompositionStatus>,
) {
    let mut restart = |queue: &mut WorkQueue, entity| {
        queue.restart(entity);
        if let Ok(mut status) = statuses.get_mut(entity) {
            status.set_if_neq(DecompositionStatus::Waiting(WaitReason::ForMesh));
        }
    };
    for entity in &changed_tags {
        restart(&mut queue, entity);
    }
    for mesh in &changed_meshes {
        let owner = owners.owner(mesh);
        if let Some(entity) = owner.filter(|entity| !queue.is_to_be_resolved(*entity)) {
            restart(&mut queue, entity);
        }
    }
}

/// What may make a collider static, or no longer.
type ChangedBody = Or<(Changed<RigidBody>, Changed<ChildOf>, Added<Sensor>)>;

/// Bodies, parents and sensors that came, changed or went.
#[derive(SystemParam)]
pub(crate) struct BodyChanges<'w, 's> {
    changed: Query<'w, 's, Entity, ChangedBody>,
    bodies: RemovedComponents<'w, 's, RigidBody>,
    parents: RemovedComponents<'w, 's, ChildOf>,
    sensors: RemovedComponents<'w, 's, Sensor>,
}

impl BodyChanges<'_, '_> {
    fn entities(&mut self) -> impl Iterator<Item = Entity> {
        let gone = self.bodies.read().chain(self.parents.read()).chain(self.sensors.read());
        self.changed.iter().chain(gone)
    }
}

type MayBeStatic = (
    &'static ConvexDecomposition,
    Option<&'static AttachedCollider>,
    Option<&'static FailedRequest>,
);

/// What never moves gets triangles, all else hulls.
pub(crate) fn detect_bodies(
    mut queue: ResMut<WorkQueue>,
    mut changes: BodyChanges,
    children: Query<&Children>,
    tags: Query<MayBeStatic, Without<BakedDecomposition>>,
    geometry: StaticGeometry,
) {
    for above in changes.entities() {
        for entity in std::iter::once(above).chain(children.iter_descendants(above)) {
            let Ok((tag, attached, failed)) = tags.get(entity) else { continue };
            let request = queue.request(entity).map(|request| request.why_triangles());
            let present = request
                .or_else(|| failed.map(|failed| failed.request.why_triangles()))
                .or_else(|| attached.map(|attached| attached.why_triangles));
            let wanted = geometry.why_triangles(entity, tag.shape);
            if present.is_some_and(|present| present != wanted) {
                queue.restart(entity);
            }
        }
    }
}

/// Meshes and baked hulls whose content changed.
pub(crate) fn detect_assets(
    mut queue: ResMut<WorkQueue>,
    cache: Res<GeometryCache>,
    mut mesh_events: MessageReader<AssetEvent<Mesh>>,
    mut baked_events: MessageReader<AssetEvent<BakedHulls>>,
    users: InputUsers,
) {
    for event in mesh_events.read() {
        match event {
            AssetEvent::Modified { id } => {
                queue.forget_mesh(*id);
                users.restart(&mut queue, |input| input.uses_mesh(*id));
            }
            AssetEvent::Added { id } => {
                users.restart_if_asset_was_missing(&mut queue, |input| input.uses_mesh(*id));
            }
            AssetEvent::Removed { id } => queue.forget_mesh(*id),
            _ => {}
        }
    }
    let forget_baked = |queue: &mut WorkQueue, id| {
        cache.remove(ContentKey::Baked(id));
        queue.known.remove(&InputId::Baked(id));
    };
    for event in baked_events.read() {
        match event {
            AssetEvent::Modified { id } => {
                forget_baked(&mut queue, *id);
                users.restart(&mut queue, |input| *input == InputId::Baked(*id));
            }
            AssetEvent::Added { id } => {
                users.restart_if_asset_was_missing(&mut queue, |input| {
                    *input == InputId::Baked(*id)
                });
            }
            AssetEvent::Removed { id } => forget_baked(&mut queue, *id),
            _ => {}
        }
    }
}

/// Entities by the input of their collider, whether it is attached, failed or not finished.
#[derive(SystemParam)]
pub(crate) struct InputUsers<'w, 's> {
    /// What failed has at most the collider of an earlier input.
    attached: Query<'w, 's, (Entity, &'static AttachedCollider), (Tagged, Without<FailedRequest>)>,
    failed: Query<'w, 's, (Entity, &'static FailedRequest)>,
}

impl InputUsers<'_, '_> {
    /// Restarts all that use an input, the unfinished too.
    fn restart(&self, queue: &mut WorkQueue, uses: impl Fn(&InputId) -> bool) {
        let asks = |request: &ColliderRequest| uses(&request.input);
        let unfinished: Vec<Entity> = (queue.unfinished.iter())
            .filter(|(_, unfinished)| unfinished.request.as_ref().is_some_and(|r| asks(r)))
            .map(|(entity, _)| *entity)
            .collect();
        let attached = self.attached.iter().filter(|(_, attached)| uses(&attached.input));
        let failed = self.failed.iter().filter(|(_, failed)| asks(&failed.request));
        let finished = attached.map(|(entity, _)| entity).chain(failed.map(|(entity, _)| entity));
        for entity in unfinished.into_iter().chain(finished) {
            queue.restart(entity);
        }
    }

    /// Restarts those that failed because an asset was missing.
    fn restart_if_asset_was_missing(&self, queue: &mut WorkQueue, uses: impl Fn(&InputId) -> bool) {
        for (entity, failed) in &self.failed {
            if failed.lacks_asset() && uses(&failed.request.input) {
                queue.restart(entity);
            }
        }
    }
}

type AttachedOrFailed = AnyOf<(&'static AttachedCollider, &'static FailedRequest)>;

/// Untagged colliders are no longer ours.
type MovedAndTagged = (Changed<GlobalTransform>, Tagged);

/// Scales that changed, once they have not changed for a while.
pub(crate) fn detect_scales(
    mut queue: ResMut<WorkQueue>,
    settings: Res<HullwrightSettings>,
    moved: Query<(Entity, &GlobalTransform, AttachedOrFailed), MovedAndTagged>,
) {
    let now = Instant::now();
    for (entity, transform, (attached, failed)) in &moved {
        // The work takes the scale that there is when it begins; one that changes later is noticed when it
        // ends. Begun anew for each movement until the new collider is there, it would never end.
        if queue.unfinished.contains_key(&entity) {
            continue;
        }
        let baked = match failed {
            Some(failed) => failed.depends_on_scale().then_some(&failed.request.stretch),
            None => attached.map(|attached| &attached.stretch),
        };
        let Some(baked) = baked else { continue };
        let stretch = Stretch::of(transform);
        let pending = queue.rescaling.get(&entity);
        let last = pending.map_or(baked, |(stretch, _)| stretch);
        if stretch.differs(last) {
            queue.rescaling.insert(entity, (stretch, now));
        }
    }
    if queue.rescaling.is_empty() {
        return;
    }
    let is_due = |since: Instant| now.duration_since(since) >= settings.scale_delay;
    let due: Vec<Entity> = (queue.rescaling.iter())
        .filter(|(_, (_, since))| is_due(*since))
        .map(|(entity, _)| *entity)
        .collect();
    for entity in due {
        queue.restart(entity);
    }
}

/// A removed tag cancels its work, also when the entity is despawned.
pub(crate) fn on_untag<T: Component>(
    removed: On<Remove<T>>,
    mut queue: ResMut<WorkQueue>,
    results: Query<(Has<FailedRequest>, Option<&AttachedCollider>)>,
    both_tags: Query<(), (With<ConvexDecomposition>, With<BakedDecomposition>)>,
    mut outcomes: Outcomes,
) {
    let entity = removed.entity;
    let (has_failed, attached) = results.get(entity).unwrap_or_default();
    // The other tag takes over. If it goes in the same instant, as all do when an entity is despawned, the
    // work is cancelled where it is resolved.
    if both_tags.contains(entity) {
        if queue.unfinished.contains_key(&entity) || has_failed {
            queue.restart(entity);
        }
        return;
    }
    if has_failed {
        outcomes.commands.entity(entity).try_remove::<FailedRequest>();
    }
    // From now on the collider is Rapier's own, which scales it by what comes on top of what is baked.
    if let Some(scale) = attached.and_then(|attached| attached.stretch.scale()) {
        let relative = ColliderScale::Relative(scale.recip());
        outcomes.commands.entity(entity).try_insert(relative);
    }
    if queue.forget(entity) {
        outcomes.cancelled(entity);
    }
}
