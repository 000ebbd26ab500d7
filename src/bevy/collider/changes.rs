//! What makes an entity's collider out of date: a new tag, a changed mesh, a changed scale, a body that came or went,
//! a focus that came near or left. Mostly by Bevy's change detection, so that finished entities cost next to
//! nothing.

use bevy::asset::AssetEvent;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_rapier3d::prelude::{ColliderScale, RigidBody, Sensor};

use super::placement::{Placements, Stretch};
use super::resolve::Distances;
use super::work::{
    AttachedCollider, FailedRequest, FarFromFocus, InputBoundary, Requested, TooSmallAt, Work,
    detach,
};
use crate::bevy::jobs::baked::{BakedDecomposition, BakedScene, FromBakedScene};
use crate::bevy::tag::ConvexDecomposition;
use crate::bevy::tag::outcomes::{DecompositionStatus, Outcomes, SkipReason, WaitReason};
use crate::bevy::tag::settings::HullwrightSettings;

type Tagged = Or<(With<ConvexDecomposition>, With<BakedDecomposition>)>;
type ChangedTag = (
    Or<(Changed<ConvexDecomposition>, Changed<BakedDecomposition>, Changed<FromBakedScene>)>,
    Tagged,
);
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
    mut work: Work,
    changed_tags: Query<Entity, ChangedTag>,
    changed_meshes: Query<Entity, Changed<Mesh3d>>,
    owners: MeshOwners,
    mut outcomes: Outcomes,
) {
    let mut restart = |work: &mut Work, entity| {
        work.restart(entity);
        outcomes.show(entity, DecompositionStatus::Waiting(WaitReason::ForMesh));
    };
    for entity in &changed_tags {
        restart(&mut work, entity);
    }
    for mesh in &changed_meshes {
        let owner = owners.owner(mesh);
        if let Some(entity) = owner.filter(|entity| !work.unfinished.is_unresolved(*entity)) {
            restart(&mut work, entity);
        }
    }
}

/// What may make a collider static, or no longer.
type ChangedBody = Or<(Changed<RigidBody>, Changed<ChildOf>, Added<Sensor>)>;

/// Bodies, parents and sensors that came, changed or went.
#[derive(SystemParam)]
pub(super) struct BodyChanges<'w, 's> {
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

/// What an entity's work came to before.
type MadeBefore = (Option<&'static AttachedCollider>, Option<&'static FailedRequest>);

/// What an entity requests, or has requested last. What failed has at most the collider of an earlier request.
fn last_requested<'a>(
    work: &'a Work,
    entity: Entity,
    (attached, failed): (Option<&'a AttachedCollider>, Option<&'a FailedRequest>),
) -> Option<&'a Requested> {
    (work.unfinished.requested(entity))
        .or(failed.map(|failed| &failed.requested))
        .or(attached.map(|attached| &attached.requested))
}

/// What never moves gets triangles, all else hulls.
pub(super) fn detect_bodies(
    mut work: Work,
    mut changes: BodyChanges,
    children: Query<&Children>,
    tags: Query<(&ConvexDecomposition, MadeBefore), Without<BakedDecomposition>>,
    placements: Placements,
) {
    for above in changes.entities() {
        for entity in std::iter::once(above).chain(children.iter_descendants(above)) {
            let Ok((tag, before)) = tags.get(entity) else { continue };
            let requested = last_requested(&work, entity, before);
            let present = requested.map(|requested| requested.request.why_triangles());
            let wanted = placements.why_triangles(entity, tag.shape);
            if present.is_some_and(|present| present != wanted) {
                work.restart(entity);
            }
        }
    }
}

/// Meshes or baked scenes whose content came, changed or went.
pub(super) fn detect_assets<A: Asset>(
    mut work: Work,
    mut events: MessageReader<AssetEvent<A>>,
    attached: Query<(Entity, &AttachedCollider), Tagged>,
    failed: Query<(Entity, &FailedRequest)>,
) {
    for event in events.read() {
        let (AssetEvent::Added { id } | AssetEvent::Modified { id } | AssetEvent::Removed { id }) =
            event
        else {
            continue;
        };
        let asset = id.untyped();
        let is_added = matches!(event, AssetEvent::Added { .. });
        let failed = failed.iter().filter(|(_, failed)| {
            (failed.lacks_asset() || !is_added) && failed.requested.uses(asset)
        });
        let failed = failed.map(|(entity, _)| entity);
        if !is_added {
            work.jobs.forget_asset(asset);
        }
        let outdated: Vec<Entity> = match event {
            AssetEvent::Added { .. } => failed.collect(),
            AssetEvent::Modified { .. } => {
                let attached =
                    attached.iter().filter(|(_, attached)| attached.requested.uses(asset));
                let attached = attached.map(|(entity, _)| entity);
                work.unfinished.users(asset).chain(attached).chain(failed).collect()
            }
            _ => continue,
        };
        for entity in outdated {
            work.restart(entity);
        }
    }
}

/// Baked scenes that came after what could be in them was made without them.
pub(super) fn detect_late_scenes(
    mut work: Work,
    mut events: MessageReader<AssetEvent<BakedScene>>,
    takers: Query<(Entity, &FromBakedScene, MadeBefore), With<ConvexDecomposition>>,
) {
    for event in events.read() {
        let AssetEvent::Added { id } = event else { continue };
        for (entity, FromBakedScene(scene), before) in &takers {
            let requested = last_requested(&work, entity, before);
            let is_without = |requested: &Requested| {
                let makes_hulls = requested.request.why_triangles().is_none();
                makes_hulls && requested.request.input.scene().is_none()
            };
            if scene.id() == *id && requested.is_some_and(is_without) {
                work.restart(entity);
            }
        }
    }
}

type WithScale = AnyOf<(&'static AttachedCollider, &'static FailedRequest, &'static TooSmallAt)>;

/// Untagged colliders are no longer ours.
type MovedAndTagged = (Changed<GlobalTransform>, Tagged);

/// Scales that changed, once they have not changed for a while.
pub(super) fn detect_scales(
    mut work: Work,
    settings: Res<HullwrightSettings>,
    moved: Query<(Entity, &GlobalTransform, WithScale), MovedAndTagged>,
) {
    for (entity, transform, (attached, failed, small)) in &moved {
        // The work takes the scale that there is when it begins; one that changes later is noticed when it
        // ends. Begun anew for each movement until the new collider is there, it would never end.
        if work.unfinished.contains(entity) {
            continue;
        }
        let failed = failed.filter(|failed| failed.depends_on_scale());
        let baked = (failed.map(|failed| &failed.requested.stretch))
            .or(small.map(|TooSmallAt(stretch)| stretch))
            .or(attached.map(|attached| &attached.requested.stretch));
        if let Some(baked) = baked {
            work.unfinished.detect_scale(entity, baked, Stretch::of(transform));
        }
    }
    for entity in work.unfinished.rescaled(settings.scale_delay) {
        work.restart(entity);
    }
}

/// A removed tag cancels its work, also when the entity is despawned.
pub(super) fn on_untag<T: Component>(
    removed: On<Remove<T>>,
    mut work: Work,
    results: Query<(Has<FailedRequest>, Option<&AttachedCollider>)>,
    both_tags: Query<(), (With<ConvexDecomposition>, With<BakedDecomposition>)>,
    mut outcomes: Outcomes,
) {
    let entity = removed.entity;
    let (has_failed, attached) = results.get(entity).unwrap_or_default();
    // The other tag takes over. If it goes in the same instant, as all do when an entity is despawned, the
    // work is cancelled where it is resolved.
    if both_tags.contains(entity) {
        if work.unfinished.contains(entity) || has_failed {
            work.restart(entity);
        }
        return;
    }
    if has_failed {
        outcomes.commands.entity(entity).try_remove::<FailedRequest>();
    }
    // From now on the collider is Rapier's own, which scales it by what comes on top of what is baked.
    if let Some(scale) = attached.and_then(|attached| attached.requested.stretch.scale()) {
        let relative = ColliderScale::Relative(scale.recip());
        outcomes.commands.entity(entity).try_insert(relative);
    }
    if work.forget(entity) {
        match attached {
            // It stays, unless the entity is despawned, which is known when it is resolved.
            Some(_) => work.restart(entity),
            None => outcomes.cancelled(entity),
        }
    }
}

/// Entities whose distance is looked at in one frame: some ten microseconds. With ten thousand each has
/// its turn every twentieth frame.
const LOOKED_AT_PER_FRAME: usize = 512;

/// A collider is dropped this much farther than the radius within which it is made, so that it does not
/// come and go at the border.
const DROP_MARGIN: f32 = 1.25;

/// Entities that have come near start.
pub(super) fn start_near(
    mut commands: Commands,
    mut work: Work,
    distances: Distances,
    far: Query<Entity, (With<FarFromFocus>, With<ConvexDecomposition>)>,
    mut next: Local<usize>,
) {
    let radius = distances.settings.skip.focus_radius;
    for entity in turn(&mut next, far.iter()) {
        if !radius.is_some_and(|radius| distances.is_beyond(entity, radius)) {
            commands.entity(entity).try_remove::<FarFromFocus>();
            work.restart(entity);
        }
    }
}

/// Colliders that are far go, if the settings say so.
pub(super) fn drop_far(
    mut work: Work,
    distances: Distances,
    attached: Query<(Entity, &AttachedCollider), With<ConvexDecomposition>>,
    mut outcomes: Outcomes,
    mut next: Local<usize>,
) {
    let Some(radius) = distances.settings.skip.focus_radius else { return };
    for (entity, attached) in turn(&mut next, attached.iter()) {
        if !distances.is_beyond(entity, radius * DROP_MARGIN) {
            continue;
        }
        work.forget(entity);
        let mut commands = outcomes.commands.entity(entity);
        detach::<AttachedCollider>(&mut commands, attached.owns_mass);
        commands.try_insert(FarFromFocus);
        outcomes.skipped(entity, SkipReason::TooFar);
    }
}

/// Those whose turn it is: so many, from where the last ones ended.
fn turn<T>(next: &mut usize, all: impl ExactSizeIterator<Item = T>) -> impl Iterator<Item = T> {
    let start = if *next < all.len() { *next } else { 0 };
    *next = (start + LOOKED_AT_PER_FRAME).min(all.len());
    all.skip(start).take(*next - start)
}

/// What was skipped since it was hidden starts when it is shown.
#[cfg(feature = "bevy_gltf")]
pub(super) fn detect_shown(
    mut work: Work,
    changed: Query<(Entity, &Visibility), Changed<Visibility>>,
    children: Query<&Children>,
    statuses: Query<&DecompositionStatus>,
) {
    const HIDDEN: DecompositionStatus = DecompositionStatus::Skipped(SkipReason::Hidden);
    for (entity, visibility) in &changed {
        if *visibility == Visibility::Hidden {
            continue;
        }
        for entity in std::iter::once(entity).chain(children.iter_descendants(entity)) {
            if statuses.get(entity) == Ok(&HIDDEN) {
                work.restart(entity);
            }
        }
    }
}
