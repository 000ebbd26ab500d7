//! What makes an entity's collider out of date: a new tag, a changed mesh, a changed scale. All
//! of it is noticed by change detection, so that finished entities cost next to nothing.

use bevy::asset::AssetEvent;
use bevy::ecs::system::SystemParam;
use bevy::platform::time::Instant;
use bevy::prelude::*;
use bevy_rapier3d::prelude::RigidBody;

use super::attach::Attached;
use super::baked::{BakedDecomposition, BakedHulls};
use super::failing::Rejected;
use super::library::{Content, Library};
use super::placement::Stretch;
use super::work::{Request, SourceId, Work};
use super::{
    ConvexDecomposition, DecompositionCounters, DecompositionStatus, HullwrightSettings, Wait,
};

type ChangedTag = Or<(Changed<ConvexDecomposition>, Changed<BakedDecomposition>)>;
type Tagged = Or<(With<ConvexDecomposition>, With<BakedDecomposition>)>;

/// Tags that are new or changed, and meshes that were put in another's place.
pub(super) fn notice_tags(
    mut work: ResMut<Work>,
    changed_tags: Query<Entity, ChangedTag>,
    changed_meshes: Query<Entity, Changed<Mesh3d>>,
    tagged: Query<(), Tagged>,
    parents: Query<&ChildOf>,
    mut statuses: Query<&mut DecompositionStatus>,
) {
    let mut restart = |work: &mut Work, entity| {
        work.restart(entity);
        if let Ok(mut status) = statuses.get_mut(entity) {
            status.set_if_neq(DecompositionStatus::Waiting(Wait::ForMesh));
        }
    };
    for entity in &changed_tags {
        restart(&mut work, entity);
    }
    for mesh in &changed_meshes {
        let tag = std::iter::once(mesh).chain(parents.iter_ancestors(mesh));
        let entity = tag.into_iter().find(|entity| tagged.contains(*entity));
        if let Some(entity) = entity.filter(|entity| !work.is_to_be_resolved(*entity)) {
            restart(&mut work, entity);
        }
    }
}

/// Bodies that became fixed or are no longer: one wants the triangles, the other hulls.
pub(super) fn notice_bodies(
    mut work: ResMut<Work>,
    settings: Res<HullwrightSettings>,
    changed: Query<(Entity, &RigidBody), Changed<RigidBody>>,
    children: Query<&Children>,
    attached: Query<&Attached>,
    rejected: Query<&Rejected>,
) {
    if !settings.exact_fixed_bodies {
        return;
    }
    for (body, kind) in &changed {
        let is_fixed = *kind == RigidBody::Fixed;
        for entity in std::iter::once(body).chain(children.iter_descendants(body)) {
            let ask = work.requests.get(&entity).and_then(|request| request.ask.as_ref());
            let is_exact = ask
                .or_else(|| rejected.get(entity).ok().map(|rejected| &rejected.ask))
                .map(|ask| ask.is_exact())
                .or_else(|| attached.get(entity).ok().map(|attached| attached.is_exact));
            if is_exact.is_some_and(|is_exact| is_exact != is_fixed) {
                work.restart(entity);
            }
        }
    }
}

/// Meshes and baked hulls whose content changed.
pub(super) fn notice_assets(
    mut work: ResMut<Work>,
    library: Res<Library>,
    mut mesh_events: MessageReader<AssetEvent<Mesh>>,
    mut baked_events: MessageReader<AssetEvent<BakedHulls>>,
    users: Users,
) {
    for event in mesh_events.read() {
        match event {
            AssetEvent::Modified { id } => {
                work.forget_mesh(*id);
                users.restart(&mut work, |source| source.uses_mesh(*id));
            }
            AssetEvent::Added { id } => {
                users.restart_those_that_lack(&mut work, |source| source.uses_mesh(*id));
            }
            AssetEvent::Removed { id } => work.forget_mesh(*id),
            _ => {}
        }
    }
    let forget_baked = |work: &mut Work, id| {
        library.remove(Content::Baked(id));
        work.known.remove(&SourceId::Baked(id));
    };
    for event in baked_events.read() {
        match event {
            AssetEvent::Modified { id } => {
                forget_baked(&mut work, *id);
                users.restart(&mut work, |source| *source == SourceId::Baked(*id));
            }
            AssetEvent::Added { id } => {
                users.restart_those_that_lack(&mut work, |source| *source == SourceId::Baked(*id));
            }
            AssetEvent::Removed { id } => forget_baked(&mut work, *id),
            _ => {}
        }
    }
}

/// Entities that are finished, by what their collider was made from or was to be made from.
#[derive(SystemParam)]
pub(super) struct Users<'w, 's> {
    /// What failed has at most the collider of something else.
    attached: Query<'w, 's, (Entity, &'static Attached), Without<Rejected>>,
    rejected: Query<'w, 's, (Entity, &'static Rejected)>,
}

impl Users<'_, '_> {
    /// Begins anew with all that use a source, the unfinished too.
    fn restart(&self, work: &mut Work, uses: impl Fn(&SourceId) -> bool) {
        let is_asked =
            |request: &Request| request.ask.as_ref().is_some_and(|ask| uses(&ask.source));
        let asking: Vec<Entity> = (work.requests.iter())
            .filter(|(_, request)| is_asked(request))
            .map(|(entity, _)| *entity)
            .collect();
        let having = self.attached.iter().filter(|(_, attached)| uses(&attached.source));
        let failed = self.rejected.iter().filter(|(_, rejected)| uses(&rejected.ask.source));
        let finished = having.map(|(entity, _)| entity).chain(failed.map(|(entity, _)| entity));
        for entity in asking.into_iter().chain(finished) {
            work.restart(entity);
        }
    }

    /// Begins anew with those that failed because an asset was not there.
    fn restart_those_that_lack(&self, work: &mut Work, uses: impl Fn(&SourceId) -> bool) {
        for (entity, rejected) in &self.rejected {
            if rejected.lacks_asset() && uses(&rejected.ask.source) {
                work.restart(entity);
            }
        }
    }
}

type AttachedOrRejected = AnyOf<(&'static Attached, &'static Rejected)>;

/// Scales that changed, once they have not changed for a while.
pub(super) fn notice_scales(
    mut work: ResMut<Work>,
    settings: Res<HullwrightSettings>,
    moved: Query<(Entity, &GlobalTransform, AttachedOrRejected), Changed<GlobalTransform>>,
) {
    let now = Instant::now();
    for (entity, transform, (attached, rejected)) in &moved {
        let baked = match rejected {
            Some(rejected) => rejected.depends_on_scale().then_some(&rejected.ask.stretch),
            None => attached.map(|attached| &attached.stretch),
        };
        let Some(baked) = baked else { continue };
        let stretch = Stretch::of(transform);
        let pending = work.rescaling.get(&entity);
        let last = pending.map_or(baked, |(stretch, _)| stretch);
        if stretch.differs(last) {
            work.rescaling.insert(entity, (stretch, now));
        }
    }
    if work.rescaling.is_empty() {
        return;
    }
    let is_due = |since: Instant| now.duration_since(since) >= settings.scale_delay;
    let due: Vec<Entity> = (work.rescaling.iter())
        .filter(|(_, (_, since))| is_due(*since))
        .map(|(entity, _)| *entity)
        .collect();
    for entity in due {
        work.restart(entity);
    }
}

/// A tag that is gone cancels its work, also when the entity is despawned.
pub(super) fn on_untag<T: Component>(
    removed: On<Remove<T>>,
    mut commands: Commands,
    mut work: ResMut<Work>,
    mut counters: ResMut<DecompositionCounters>,
    rejected: Query<(), With<Rejected>>,
    mut statuses: Query<&mut DecompositionStatus>,
) {
    let entity = removed.entity;
    if rejected.contains(entity) {
        commands.entity(entity).try_remove::<Rejected>();
    }
    if work.forget(entity) {
        counters.cancelled += 1;
        if let Ok(mut status) = statuses.get_mut(entity) {
            *status = DecompositionStatus::Cancelled;
        }
    }
}
