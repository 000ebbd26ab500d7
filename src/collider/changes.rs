//! What may have changed what a collider is made of: tags, meshes, what is below and above, scales,
//! assets, a focus that came near or left. All of it only marks entities, by Bevy's change
//! detection, so that finished ones cost next to nothing; whether anything differs is decided where
//! marked entities are resolved.

use bevy::asset::AssetEvent;
use bevy::ecs::entity::EntityHashMap;
use bevy::ecs::entity_disabling::Disabled;
use bevy::ecs::query::Allow;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use super::cells::LevelCell;
use super::placement::{Placements, Stretch};
use super::resolve::Distances;
use super::work::{
    AttachedCollider, FailedRequest, FarFromFocus, InputBoundary, MadeBefore, MadeBeforeItem,
    OwnCollider, TooSmallAt, Work,
};
use crate::engine::Engine;
use crate::jobs::baked::{BakedDecomposition, FromBakedScene};
use crate::tag::outcomes::{
    DecompositionError, DecompositionStatus, Descriptions, Outcomes, SkipReason, WaitReason,
    entities,
};
use crate::tag::settings::HullwrightSettings;
use crate::tag::{ConvexDecomposition, NoConvexDecomposition};

/// What gets a collider by the plugin.
pub(super) type Tagged = Or<(With<ConvexDecomposition>, With<BakedDecomposition>, With<LevelCell>)>;
type Tags = (Option<Ref<'static, ConvexDecomposition>>, Option<Ref<'static, BakedDecomposition>>);
type ChangedTag = (
    Or<(Changed<ConvexDecomposition>, Changed<BakedDecomposition>, Changed<FromBakedScene>)>,
    Tagged,
);

/// The tagged entities to which something belongs.
#[derive(SystemParam)]
pub(crate) struct Owners<'w, 's, E: Engine> {
    tagged: Query<'w, 's, (), (Tagged, Allow<Disabled>)>,
    boundaries: Query<'w, 's, (), (InputBoundary<E>, Allow<Disabled>)>,
    parents: Query<'w, 's, &'static ChildOf, Allow<Disabled>>,
    children: Query<'w, 's, &'static Children, Allow<Disabled>>,
}

impl<E: Engine> Owners<'_, '_, E> {
    /// An entity itself, and the one whose input it may be a part of.
    fn of(&self, entity: Entity) -> impl Iterator<Item = Entity> {
        let above = self.above(entity);
        std::iter::once(entity).chain(above).filter(|entity| self.tagged.contains(*entity))
    }

    fn above(&self, entity: Entity) -> Option<Entity> {
        self.parents.iter_ancestors(entity).find(|above| self.boundaries.contains(*above))
    }

    /// All that is tagged below an entity.
    fn below(&self, entity: Entity) -> impl Iterator<Item = Entity> {
        self.children.iter_descendants(entity).filter(|entity| self.tagged.contains(*entity))
    }
}

/// Entities where something came or changed, also disabled ones. One query for each component:
/// all rows of all tables are looked at in each frame, and `Or` takes several times as long.
type New<'w, 's, F> = Query<'w, 's, Entity, (F, Allow<Disabled>)>;

/// What came, changed or went above and below tagged entities.
#[derive(SystemParam)]
pub(crate) struct Structure<'w, 's, E: Engine> {
    // What makes a part of an input another, or none.
    meshes: New<'w, 's, Changed<Mesh3d>>,
    children: New<'w, 's, Changed<Children>>,
    exclusions: New<'w, 's, Added<NoConvexDecomposition>>,
    // What also concerns all below: bodies decide what moves, and where colliders are.
    bodies: New<'w, 's, Changed<<E as Engine>::Body>>,
    parents: New<'w, 's, Changed<ChildOf>>,
    sensors: New<'w, 's, Added<<E as Engine>::Sensor>>,
    disabled: New<'w, 's, Added<Disabled>>,
    meshes_gone: RemovedComponents<'w, 's, Mesh3d>,
    children_gone: RemovedComponents<'w, 's, Children>,
    exclusions_gone: RemovedComponents<'w, 's, NoConvexDecomposition>,
    tags_gone: RemovedComponents<'w, 's, ConvexDecomposition>,
    baked_gone: RemovedComponents<'w, 's, BakedDecomposition>,
    scenes_gone: RemovedComponents<'w, 's, FromBakedScene>,
    bodies_gone: RemovedComponents<'w, 's, <E as Engine>::Body>,
    parents_gone: RemovedComponents<'w, 's, ChildOf>,
    sensors_gone: RemovedComponents<'w, 's, <E as Engine>::Sensor>,
    disabled_gone: RemovedComponents<'w, 's, Disabled>,
    colliders_gone: RemovedComponents<'w, 's, <E as Engine>::Collider>,
}

/// Marks entities whose tag or surroundings changed; those with a new tag start.
pub(crate) fn detect_tags<E: Engine>(
    mut work: Work,
    changed: Query<(Entity, Tags), ChangedTag>,
    mut structure: Structure<E>,
    owners: Owners<E>,
    mut outcomes: Outcomes,
) {
    let above = structure.bodies.iter().chain(&structure.parents).chain(&structure.sensors);
    let above = above.chain(&structure.disabled).chain(structure.bodies_gone.read());
    let above = above.chain(structure.parents_gone.read()).chain(structure.sensors_gone.read());
    for entity in above.chain(structure.disabled_gone.read()) {
        work.unfinished.marked.extend(owners.of(entity).chain(owners.below(entity)));
    }
    let parts = structure.meshes.iter().chain(&structure.children).chain(&structure.exclusions);
    let parts = parts.chain(structure.meshes_gone.read());
    let parts = parts.chain(structure.children_gone.read()).chain(structure.exclusions_gone.read());
    let parts = parts.chain(structure.tags_gone.read()).chain(structure.baked_gone.read());
    let changed_entities = changed.iter().map(|(entity, _)| entity);
    for entity in parts.chain(structure.scenes_gone.read()).chain(changed_entities) {
        work.unfinished.marked.extend(owners.of(entity));
    }
    let colliders = structure.colliders_gone.read();
    work.unfinished.marked.extend(colliders.filter(|entity| owners.tagged.contains(*entity)));
    for (entity, (tag, baked)) in &changed {
        if tag.is_some_and(|tag| tag.is_added()) || baked.is_some_and(|baked| baked.is_added()) {
            work.restart(entity);
            outcomes.show(entity, DecompositionStatus::Waiting(WaitReason::ForMesh));
        }
    }
}

/// The game has put a collider in the place of the plugin's, or where one is to come.
pub(super) fn on_collider<E: Engine>(
    inserted: On<Insert<E::Collider>>,
    mut work: Work,
    before: Query<MadeBefore<E>, Tagged>,
) {
    if before.get(inserted.entity).is_ok_and(|before| before.has_games_collider()) {
        work.unfinished.marked.insert(inserted.entity);
    }
}

/// Meshes or baked scenes whose content came or changed.
pub(super) fn detect_assets<E: Engine, A: Asset>(
    mut work: Work,
    mut events: MessageReader<AssetEvent<A>>,
    made: Query<(Entity, MadeBefore<E>), Tagged>,
    takers: Query<(Entity, &FromBakedScene), With<ConvexDecomposition>>,
) {
    for event in events.read() {
        let (AssetEvent::Added { id } | AssetEvent::Modified { id } | AssetEvent::Removed { id }) =
            event
        else {
            continue;
        };
        let asset = id.untyped();
        let is_removed = matches!(event, AssetEvent::Removed { .. });
        let uses = |before: &MadeBeforeItem<E>| before.requested().is_some_and(|of| of.uses(asset));
        let users = made.iter().filter(|(_, before)| uses(before)).map(|(entity, _)| entity);
        let users: Vec<Entity> = users.chain(work.unfinished.users(asset)).collect();
        let is_used = !users.is_empty();
        work.jobs.note_asset(asset, is_removed, matches!(event, AssetEvent::Added { .. }), is_used);
        // What was made of it stays.
        if is_removed {
            continue;
        }
        // A scene that comes late is in no request yet.
        let takers = takers.iter().filter(|(_, of)| of.0.id().untyped() == asset);
        let takers = takers.map(|(entity, _)| entity);
        work.unfinished.marked.extend(users.into_iter().chain(takers));
    }
}

type WithScale = (
    Entity,
    Ref<'static, Transform>,
    &'static GlobalTransform,
    Has<ChildOf>,
    Option<&'static OwnCollider>,
    Option<&'static FailedRequest>,
    Option<&'static TooSmallAt>,
);

/// Untagged colliders are no longer ours.
type Moved = (Changed<Transform>, Without<ChildOf>, Tagged);

/// A transform of its own counts in this frame, those above it once Bevy has propagated them.
type MovedBelow = (Or<(Changed<Transform>, Changed<GlobalTransform>)>, With<ChildOf>, Tagged);

/// Scales that changed: colliders follow them, and are made anew once they have not changed for a
/// while.
pub(super) fn detect_scales<E: Engine>(
    mut work: Work,
    moved: Query<WithScale, Moved>,
    moved_below: Query<WithScale, MovedBelow>,
    placements: Placements<E>,
) {
    let all = moved.iter().chain(&moved_below);
    for (entity, transform, global, is_below, own, failed, small) in all {
        let present = match (is_below, transform.is_changed()) {
            (false, _) => Stretch::of_scale(transform.scale),
            (true, false) => placements.stretch_of(entity, global),
            (true, true) => placements.stretch(entity),
        };
        match own.map(|own| own.stretch.differs(&present)) {
            Some(true) => _ = work.unfinished.to_follow.insert(entity),
            // As it is with almost all that move.
            Some(false) if failed.is_none() && small.is_none() => continue,
            _ => {}
        }
        if failed.is_some_and(|failed| failed.error == DecompositionError::MirroredBody) {
            work.unfinished.marked.insert(entity);
        }
        let failed = failed.filter(|failed| failed.depends_on_scale());
        let baked = (failed.map(|failed| failed.requested.stretch))
            .or(small.map(|TooSmallAt(stretch)| *stretch))
            .or(own.map(|own| own.stretch))
            .or_else(|| Some(work.unfinished.requested(entity)?.stretch));
        if let Some(baked) = baked {
            work.unfinished.detect_scale(entity, &baked, present);
        }
    }
}

type MovedPart<E> = (Changed<Transform>, With<ChildOf>, Without<<E as Engine>::Body>);

/// Parts that moved relative to their tag: the collider is made anew once they rest, and so are
/// colliders whose scale does.
pub(super) fn detect_moved_parts<E: Engine>(
    mut work: Work,
    settings: Res<HullwrightSettings>,
    moved: Query<(Entity, &Transform), MovedPart<E>>,
    owners: Owners<E>,
    placements: Placements<E>,
    mut last: Local<EntityHashMap<Transform>>,
) {
    let before = std::mem::take(&mut *last);
    for (part, transform) in &moved {
        let Some(owner) = owners.above(part).filter(|_| !owners.boundaries.contains(part)) else {
            continue;
        };
        // Animations also write what is there.
        if owners.tagged.contains(owner) {
            last.insert(part, *transform);
            if before.get(&part) != Some(transform) {
                work.unfinished.moves(owner, placements.stretch(owner));
            }
        }
    }
    work.unfinished.mark_resting(settings.scale_delay);
}

/// What a baked scene is given for by mistake.
pub(super) type LoneScene = (Added<FromBakedScene>, Without<ConvexDecomposition>);

/// Logs entities that take hulls from a baked scene, but have no tag, one line a frame.
pub(super) fn warn_of_lone_scenes(lone: Query<Entity, LoneScene>, descriptions: Descriptions) {
    if let Some(first) = lone.iter().next() {
        let who = entities(lone.iter().count(), &descriptions.entity(first, None));
        log::warn!("FromBakedScene does nothing on {who}: it belongs beside a ConvexDecomposition");
    }
}

/// What is there of an earlier work, also on what is disabled.
type Earlier = (Has<FailedRequest>, Option<&'static OwnCollider>, Has<AttachedCollider>);
type BothTags = (With<ConvexDecomposition>, With<BakedDecomposition>, Allow<Disabled>);

/// A removed tag cancels its work, also when the entity is despawned.
pub(super) fn on_untag<E: Engine, T: Component>(
    removed: On<Remove<T>>,
    mut work: Work,
    results: Query<Earlier, Allow<Disabled>>,
    both_tags: Query<(), BothTags>,
    mut outcomes: Outcomes,
) {
    let entity = removed.entity;
    let (has_failed, own, is_attached) = results.get(entity).unwrap_or_default();
    let attached = own.filter(|_| is_attached);
    // The other tag takes over. If it goes in the same instant, as all do when an entity is
    // despawned, the work is cancelled where it is resolved.
    if both_tags.contains(entity) {
        if work.unfinished.contains(entity) || has_failed {
            work.restart(entity);
        }
        return;
    }
    if has_failed {
        outcomes.commands.entity(entity).try_remove::<FailedRequest>();
    }
    if let Some(own) = attached {
        E::leave(&mut outcomes.commands.entity(entity), own.stretch.scale());
    }
    if work.forget(entity) {
        match attached {
            // It stays, unless the entity is despawned, which is known when it is resolved.
            Some(_) => work.restart(entity),
            None => outcomes.cancelled(entity),
        }
    }
}

/// Entities whose distance is looked at in one frame: some ten microseconds. With ten thousand each
/// has its turn every twentieth frame.
const LOOKED_AT_PER_FRAME: usize = 512;

/// A collider is dropped this much farther than the radius within which it is made, so that it does
/// not come and go at the border.
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

type AttachedByTag = (With<AttachedCollider>, With<ConvexDecomposition>);

/// Colliders that are far go, if the settings say so.
pub(super) fn drop_far<E: Engine>(
    mut work: Work,
    distances: Distances,
    attached: Query<(Entity, MadeBefore<E>), AttachedByTag>,
    mut outcomes: Outcomes,
    mut next: Local<usize>,
) {
    let Some(radius) = distances.settings.skip.focus_radius else { return };
    for (entity, before) in turn(&mut next, attached.iter()) {
        if !distances.is_beyond(entity, radius * DROP_MARGIN) {
            continue;
        }
        work.forget(entity);
        let mut commands = outcomes.commands.entity(entity);
        before.detach(&mut commands);
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

/// What is shown or hidden may have something to do, or not.
#[cfg(feature = "bevy_gltf")]
pub(super) fn detect_shown<E: Engine>(
    mut work: Work,
    changed: Query<Entity, Changed<Visibility>>,
    owners: Owners<E>,
) {
    for entity in &changed {
        let all = std::iter::once(entity).chain(owners.children.iter_descendants(entity));
        work.unfinished.marked.extend(all.filter(|entity| owners.tagged.contains(*entity)));
    }
}
