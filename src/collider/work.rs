//! The entities that are not finished, and the components that record what became of the others.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use bevy::asset::UntypedAssetId;
use bevy::ecs::entity::{EntityHashMap, EntityIndexSet};
use bevy::ecs::query::QueryData;
use bevy::ecs::system::{EntityCommands, SystemParam};
use bevy::math::Affine3A;
use bevy::platform::time::Instant;
use bevy::prelude::*;
use hullwright::MassProperties;
use hullwright_parry::ColliderError;
use hullwright_parry::parry3d::shape::SharedShape;

use super::cells::{CellPlace, InLevelCell};
use super::children::{self, ColliderInChildren};
use super::moved::moved;
use super::parts::ColliderParts;
use super::placement::{Placement, Stretch, maps_differ};
use crate::engine::{Engine, Weight};
use crate::jobs::Jobs;
use crate::jobs::baked::BakedDecomposition;
use crate::jobs::request::ColliderRequest;
use crate::jobs::task::map_mass;
use crate::tag::outcomes::DecompositionError;
use crate::tag::parameters::Goal;
use crate::tag::{ConvexDecomposition, HullGrouping, NoConvexDecomposition};

/// What has any of these is left out of the input above it, with all below it.
pub(super) type InputBoundary<E> = Or<(
    With<ConvexDecomposition>,
    With<BakedDecomposition>,
    With<<E as Engine>::Body>,
    With<NoConvexDecomposition>,
)>;

/// All that a collider is made of. It is compared wherever something may have changed: what
/// requests the same keeps its collider, and its job.
#[derive(Debug, Clone)]
pub(crate) struct Requested {
    pub request: Arc<ColliderRequest>,
    pub stretch: Stretch,
    pub weight: Weight,
    /// Which hulls have a child of their own, if any.
    pub children: Option<HullGrouping>,
    /// The entities whose meshes it is made of, in the order of the request's parts.
    pub parts: Vec<Entity>,
    /// The cell whose collider it shares.
    pub cell: Option<Box<CellPlace>>,
}

impl Requested {
    pub(super) fn uses(&self, asset: UntypedAssetId) -> bool {
        self.request.input.uses(asset)
    }

    /// Whether a job for the one is none for the other.
    pub(super) fn needs_other_work(&self, other: &Self) -> bool {
        let (own, others) = (&self.request, &other.request);
        self.cell != other.cell
            || own.why_triangles() != others.why_triangles()
            || !own.input.is_same_unscaled(&others.input)
            || maps_differ(&own.map_before, &others.map_before)
    }

    fn has_other_scale(&self, other: &Self) -> bool {
        maps_differ(&self.request.to_collider(), &other.request.to_collider())
    }

    fn has_other_weight(&self, other: &Self) -> bool {
        let bits = |of: Weight| (of.density.to_bits(), of.mass.map(f32::to_bits));
        bits(self.weight) != bits(other.weight)
    }
}

/// Whether what an entity requests is there.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Presence {
    There,
    /// This asset is not loaded yet.
    Later(UntypedAssetId),
    Never(DecompositionError),
}

/// On entities with a collider of the plugin's: the shape, as it was made and as it is by now.
#[derive(Component, Debug, Clone)]
pub(crate) struct OwnCollider {
    pub made: SharedShape,
    /// With which it was made, from the entity's space to the collider's.
    pub made_map: Affine3A,
    /// Of hulls, at a density of 1 and in the mesh's own space.
    pub mass: Option<MassProperties>,
    /// As it is by now, at the scale of the entity.
    pub shape: SharedShape,
    /// That of the entity's collider, unless another was put there: the engine scales it.
    unscaled: SharedShape,
    /// The scale that it has.
    pub stretch: Stretch,
}

impl OwnCollider {
    /// A shape that was made with a map, moved to where its entity is.
    pub(super) fn at<E: Engine>(
        place: &Placement,
        made: SharedShape,
        made_map: Affine3A,
        mass: Option<MassProperties>,
        cache: &mut E::Cache,
    ) -> (Self, E::Collider) {
        let mut own = |shape, stretch| {
            let collider = E::collider(&shape, place.engine_scale, cache);
            let unscaled = E::unscaled(&collider).clone();
            (Self { made: made.clone(), made_map, mass, shape, unscaled, stretch }, collider)
        };
        if !maps_differ(&made_map, &place.map) {
            return own(made.clone(), place.stretch);
        }
        match moved(&made, &(place.map * made_map.inverse())) {
            Some(shape) => own(shape, place.stretch),
            // What can't follow has a scale that is no entity's, until it is made anew.
            None => own(made.clone(), Stretch::default()),
        }
    }

    /// Whether a collider is this one.
    pub(super) fn is<E: Engine>(&self, present: &E::Collider) -> bool {
        Arc::ptr_eq(&E::unscaled(present).0, &self.unscaled.0)
    }

    /// Changes to another shape at the scale that the entity has by now.
    pub(super) fn change<E: Engine>(
        &mut self,
        shape: SharedShape,
        place: &Placement,
    ) -> E::Collider {
        // One that changes each frame is not worth keeping.
        let collider = E::collider(&shape, place.engine_scale, &mut E::Cache::default());
        self.unscaled = E::unscaled(&collider).clone();
        (self.shape, self.stretch) = (shape, place.stretch);
        collider
    }

    /// The mass with a map; `None` for what has none.
    pub(super) fn weigh<E: Engine>(
        &self,
        weight: Weight,
        map: &Affine3A,
    ) -> Result<Option<E::Mass>, ColliderError> {
        let Some(properties) = self.mass else { return Ok(None) };
        let by_density = properties.with_mass(properties.mass * f64::from(weight.density));
        let mapped = map_mass(&by_density, map);
        let mapped = weight.mass.map_or(mapped, |mass| mapped.with_mass(mass.into()));
        Ok(Some(E::mass(hullwright_parry::mass_properties(&mapped, [1.0; 3])?)))
    }
}

/// On entities with a collider of the plugin's: what it was made from.
#[derive(Component, Debug, Clone)]
pub(crate) struct AttachedCollider {
    pub requested: Requested,
}

/// On entities that have their fallback collider.
#[derive(Component, Debug, Clone, Copy)]
pub(super) struct AttachedFallback;

/// On entities that failed: what they requested, to detect when another attempt may succeed.
#[derive(Component, Debug, Clone)]
pub(crate) struct FailedRequest {
    pub requested: Requested,
    pub error: DecompositionError,
}

impl FailedRequest {
    /// Whether it may succeed at another scale. A mesh that is bad in itself stays so.
    pub(super) fn depends_on_scale(&self) -> bool {
        use DecompositionError::{Collider, MirroredBody};
        matches!(self.error, Collider(_) | MirroredBody)
            || self.requested.request.goal.as_ref().is_some_and(Goal::has_absolute_length)
    }
}

/// What an entity's work came to before.
#[derive(QueryData)]
pub(crate) struct MadeBefore<E: Engine> {
    pub attached: Option<&'static AttachedCollider>,
    pub(super) failed: Option<&'static FailedRequest>,
    pub(super) parts: Option<&'static ColliderParts>,
    own: Option<&'static OwnCollider>,
    in_children: Has<ColliderInChildren>,
    in_cell: Has<InLevelCell>,
    in_engine: E::Made,
}

impl<E: Engine> MadeBeforeItem<'_, '_, E> {
    /// What it has requested last. What failed has at most the collider of an earlier request.
    pub(super) fn requested(&self) -> Option<&Requested> {
        let failed = self.failed.map(|failed| &failed.requested);
        failed.or(self.attached.map(|attached| &attached.requested))
    }

    pub(super) fn has_collider(&self) -> bool {
        self.in_children || self.in_cell || E::present(&self.in_engine).is_some()
    }

    /// Whether its collider is the game's. One that was left to the engine has its scale.
    pub(super) fn has_games_collider(&self) -> bool {
        let is_own = |present| {
            self.own.is_some_and(|own| E::is_left(&self.in_engine) || own.is::<E>(present))
        };
        E::present(&self.in_engine).is_some_and(|present| !is_own(present))
    }

    pub(super) fn is_in_children(&self) -> bool {
        self.in_children
    }

    pub(super) fn owns_mass(&self) -> bool {
        E::owns_mass(&self.in_engine)
    }

    /// Whether the same would come of a request.
    fn answers(&self, wanted: &Requested, presence: &Presence) -> bool {
        use DecompositionError::{MirroredBody, NotLoaded};
        let Some(last) = self.requested() else { return false };
        if last.needs_other_work(wanted)
            || last.has_other_weight(wanted)
            || last.children != wanted.children
        {
            return false;
        }
        if let Some(failed) = self.failed {
            return !(failed.depends_on_scale() && last.has_other_scale(wanted))
                && match presence {
                    Presence::There => !matches!(failed.error, NotLoaded | MirroredBody),
                    Presence::Later(_) => false,
                    Presence::Never(error) => *error == failed.error,
                };
        }
        if wanted.cell.is_some() {
            return self.in_cell;
        }
        let has_its_scale = self.own.is_some_and(|own| !own.stretch.differs(&wanted.stretch));
        self.has_collider()
            && has_its_scale
            && !last.has_other_scale(wanted)
            && *presence != Presence::Never(MirroredBody)
    }

    /// Takes the plugin's collider away, and the mass that it came with. One that the game has put
    /// in its place stays.
    pub(crate) fn detach(&self, entity: &mut EntityCommands) {
        if self.in_cell {
            entity.try_remove::<(InLevelCell, AttachedCollider)>();
        }
        self.detach_own(entity);
    }

    /// The same of a collider that is on the entity itself.
    pub(super) fn detach_own(&self, entity: &mut EntityCommands) {
        if self.own.is_none() {
            return;
        }
        if !self.has_games_collider() {
            E::remove_collider(entity);
        }
        if self.in_children {
            children::detach(entity);
        }
        entity.try_remove::<(OwnCollider, AttachedCollider, AttachedFallback, ColliderParts)>();
        if self.owns_mass() {
            E::remove_mass(entity);
        }
    }
}

/// On entities that are too far from every focus.
#[derive(Component, Debug, Clone, Copy)]
pub(super) struct FarFromFocus;

/// On entities that are too small: the scale that they had then.
#[derive(Component, Debug, Clone, Copy)]
pub(super) struct TooSmallAt(pub Stretch);

/// Gives an entity a collider, with a record of what it is.
pub(super) fn attach_shape<E: Engine>(
    entity: &mut EntityCommands,
    (own, collider): (OwnCollider, E::Collider),
    mass: Option<E::Mass>,
    record: impl Bundle,
) {
    // Whoever sees the collider come sees whose it is.
    entity.try_insert((own, record));
    E::attach(entity, collider);
    if let Some(mass) = mass {
        E::set_mass(entity, mass);
    }
}

/// An entity that is not finished.
#[derive(Debug)]
struct Entry {
    /// `None` until its meshes are known.
    requested: Option<Requested>,
    /// When it was tagged, or changed.
    since: Instant,
    /// Whether the log says that it waits for a mesh.
    is_wait_logged: bool,
    /// Whether it is disabled, so that nothing waits for it.
    is_parked: bool,
    /// Whether its job runs to the end, whatever changes: another was given up for it.
    is_patient: bool,
    /// Whether something has changed since its job began.
    is_outdated: bool,
}

/// How an entity has ended that was not finished.
pub(crate) struct Ended {
    pub time: Duration,
    pub requested: Option<Requested>,
    /// Whether something has changed meanwhile: it has started anew.
    pub is_outdated: bool,
}

/// The entities that are not finished, and those that may have changed.
#[derive(Resource, Default)]
pub(crate) struct Unfinished {
    entries: EntityHashMap<Entry>,
    /// Entities that were tagged since everything was finished.
    entered: usize,
    /// Entities whose meshes are not known yet.
    pub(super) unresolved: VecDeque<Entity>,
    /// Entities that may be made of something else by now.
    pub(super) marked: EntityIndexSet,
    /// Entities whose scale or parts moved, to which scale, and when they last did.
    moving: EntityHashMap<(Stretch, Instant)>,
    /// Entities whose colliders have another scale than they, since the longest first.
    pub to_follow: EntityIndexSet,
    /// Whether the log says that something changes faster than it can be made.
    is_haste_logged: bool,
}

impl Unfinished {
    /// Those that are not disabled.
    pub(super) fn awake(&self) -> impl Iterator<Item = Entity> {
        self.entries.iter().filter(|(_, entry)| !entry.is_parked).map(|(entity, _)| *entity)
    }

    /// Those that wait for the collider of a cell.
    pub(super) fn in_cells(&self) -> impl Iterator<Item = Entity> {
        self.awake().filter(|entity| self.requested(*entity).is_some_and(|of| of.cell.is_some()))
    }

    /// Whether an entity is made anew, or will be.
    pub(super) fn is_pending(&self, entity: Entity) -> bool {
        self.entries.contains_key(&entity)
            || self.moving.contains_key(&entity)
            || self.marked.contains(&entity)
    }

    pub(crate) fn len(&self) -> usize {
        self.awake().count()
    }

    /// Entities that were tagged since everything was finished, at least those that are not.
    pub(crate) fn entered(&self) -> usize {
        self.entered.max(self.len())
    }

    /// Counts from here on.
    pub(crate) fn begin_anew(&mut self) {
        self.entered = 0;
    }

    pub(super) fn is_idle(&self) -> bool {
        self.awake().next().is_none() && self.moving.is_empty()
    }

    pub(crate) fn contains(&self, entity: Entity) -> bool {
        self.entries.get(&entity).is_some_and(|entry| !entry.is_parked)
    }

    /// What an entity requests, once its meshes are known.
    pub(super) fn requested(&self, entity: Entity) -> Option<&Requested> {
        self.entries.get(&entity)?.requested.as_ref()
    }

    /// Entities whose request uses an asset.
    pub(super) fn users(&self, asset: UntypedAssetId) -> impl Iterator<Item = Entity> {
        let uses = move |entry: &Entry| entry.requested.as_ref().is_some_and(|of| of.uses(asset));
        self.entries.iter().filter(move |(_, entry)| uses(entry)).map(|(entity, _)| *entity)
    }

    /// The meshes of an entity are not there yet. Whether it has waited for longer than `patience`,
    /// which is said once.
    pub(super) fn resolve_later(&mut self, entity: Entity, patience: Option<Duration>) -> bool {
        self.unresolved.push_back(entity);
        let Some((patience, entry)) = patience.zip(self.entries.get_mut(&entity)) else {
            return false;
        };
        let is_overdue = !entry.is_wait_logged && entry.since.elapsed() >= patience;
        entry.is_wait_logged |= is_overdue;
        is_overdue
    }

    pub(super) fn resolve(&mut self, entity: Entity, requested: Requested) {
        if let Some(entry) = self.entries.get_mut(&entity) {
            entry.requested = Some(requested);
        }
    }

    /// An entity is disabled. It goes on when it is enabled.
    pub(super) fn park(&mut self, entity: Entity) {
        if let Some(entry) = self.entries.get_mut(&entity) {
            entry.is_parked = true;
            self.unresolved.retain(|other| *other != entity);
        }
        self.moving.remove(&entity);
    }

    /// An entity is finished. `None` if it was forgotten. What has changed meanwhile starts anew.
    pub(super) fn end(&mut self, entity: Entity) -> Option<Ended> {
        let Entry { requested, since, is_outdated, .. } = self.entries.remove(&entity)?;
        if is_outdated {
            self.enter(entity, true);
        }
        Some(Ended { time: since.elapsed(), requested, is_outdated })
    }

    fn enter(&mut self, entity: Entity, is_patient: bool) {
        let entry = Entry {
            requested: None,
            since: Instant::now(),
            is_wait_logged: false,
            is_parked: false,
            is_patient,
            is_outdated: false,
        };
        self.entries.insert(entity, entry);
        self.unresolved.push_back(entity);
    }

    /// Notes a scale that is another than the one that is baked, or that was noted before.
    pub(super) fn detect_scale(&mut self, entity: Entity, baked: &Stretch, present: Stretch) {
        let last = self.moving.get(&entity).map_or(baked, |(stretch, _)| stretch);
        if present.differs(last) {
            self.moves(entity, present);
        }
    }

    /// Notes that an entity, or a part of it, has moved just now.
    pub(super) fn moves(&mut self, entity: Entity, present: Stretch) {
        self.moving.insert(entity, (present, Instant::now()));
    }

    /// Marks entities that have moved, and have not for as long as this.
    pub(super) fn mark_resting(&mut self, delay: Duration) {
        let due = self.moving.extract_if(|_, (_, since)| since.elapsed() >= delay);
        self.marked.extend(due.map(|(entity, _)| entity));
    }
}

/// The work for entities, from the tag to the collider.
#[derive(SystemParam)]
pub(crate) struct Work<'w> {
    pub unfinished: ResMut<'w, Unfinished>,
    pub jobs: ResMut<'w, Jobs>,
}

impl Work<'_> {
    /// Restarts an entity from its tag.
    pub(super) fn restart(&mut self, entity: Entity) {
        let was_finished = !self.forget(entity);
        self.unfinished.entered += usize::from(was_finished);
        self.unfinished.enter(entity, false);
    }

    /// Stops all work that is only done for this entity. Whether it was unfinished.
    pub(super) fn forget(&mut self, entity: Entity) -> bool {
        self.unfinished.moving.remove(&entity);
        let was_unfinished = self.unfinished.entries.remove(&entity).is_some();
        if was_unfinished {
            self.unfinished.unresolved.retain(|other| *other != entity);
            self.jobs.forget(entity);
        }
        was_unfinished
    }

    /// Whether a marked entity is to be compared: what is not resolved yet will be anyway.
    pub(super) fn is_resolved(&mut self, entity: Entity) -> bool {
        match self.unfinished.entries.get_mut(&entity) {
            None => true,
            Some(entry) if !entry.is_parked => entry.requested.is_some(),
            Some(entry) if self.jobs.is_at_work_for(entity) => {
                entry.is_parked = false;
                true
            }
            Some(_) => {
                self.restart(entity);
                false
            }
        }
    }

    /// Takes note of what a marked entity requests now. Whether it has changed faster than it can
    /// be made, which is to be logged.
    pub(super) fn update<E: Engine>(
        &mut self,
        entity: Entity,
        before: &MadeBeforeItem<E>,
        wanted: Requested,
        presence: &Presence,
    ) -> bool {
        let Some(entry) = self.unfinished.entries.get_mut(&entity) else {
            if !before.answers(&wanted, presence) {
                self.restart(entity);
            }
            return false;
        };
        let is_other = entry.requested.as_ref().is_none_or(|now| now.needs_other_work(&wanted));
        if !is_other {
            // It is attached at the scale and with the mass of then.
            if let Some(now) = &mut entry.requested {
                (now.stretch, now.weight) = (wanted.stretch, wanted.weight);
                now.parts = wanted.parts;
            }
            entry.is_outdated = false;
            return false;
        }
        if *presence == Presence::There && self.jobs.exchange(entity, &wanted.request) {
            entry.requested = Some(wanted);
            return false;
        }
        if entry.is_patient && self.jobs.is_at_work_for(entity) {
            entry.is_outdated = true;
            return !std::mem::replace(&mut self.unfinished.is_haste_logged, true);
        }
        self.restart(entity);
        if let Some(entry) = self.unfinished.entries.get_mut(&entity) {
            entry.is_patient = true;
        }
        false
    }
}
