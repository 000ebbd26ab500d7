//! Results reach their entities: as colliders, as statuses, as events. Errors do so as statuses, as events, and in
//! one line of the log.

pub(super) mod changes;
pub(super) mod placement;
pub(super) mod resolve;
mod skins;
pub(super) mod waiting;
pub(super) mod work;

use std::collections::BTreeMap;

use bevy::ecs::query::QueryData;
use bevy::ecs::schedule::{InternedScheduleLabel, ScheduleLabel};
use bevy::ecs::system::{EntityCommands, SystemParam};
use bevy::math::Affine3A;
use bevy::prelude::*;
use bevy_rapier3d::plugin::PhysicsSet;
use bevy_rapier3d::plugin::context::RapierContextSimulation;
use bevy_rapier3d::prelude::{
    ActiveCollisionTypes, ActiveEvents, ActiveHooks, ColliderMassProperties, CollisionGroups,
    ContactForceEventThreshold, ContactSkin, Friction, MassProperties, RapierContextEntityLink,
    RapierRigidBodyHandle, RapierRigidBodySet, Restitution, Sensor, Sleeping, SolverGroups,
};

use self::changes::{
    detect_assets, detect_bodies, detect_late_scenes, detect_scales, detect_tags, drop_far,
    on_untag, start_near,
};
use self::placement::Placements;
use self::resolve::resolve;
use self::skins::warn_of_skins;
use self::waiting::{
    Fallbacks, Frozen, attach_fallbacks, freeze, freeze_new, hold_in, release, remove_fallbacks,
};
use self::work::{
    AttachedCollider, AttachedFallback, FailedRequest, FarFromFocus, Requested, Unfinished, Work,
    attach_shape, detach,
};
use super::jobs::baked::{BakedDecomposition, BakedScene};
use super::jobs::cache::{BuiltCollider, ColliderGeometry};
use super::jobs::task::map_mass;
use super::jobs::{Completed, Failed, Frame, Jobs, SlicesRun, finish_jobs, start_jobs};
use super::tag::outcomes::{
    DecompositionCounters, DecompositionError, DecompositionReady, Descriptions, MadeOf, Outcomes,
    VerifiedDistances, entities,
};
use super::tag::settings::{HullwrightSettings, HullwrightSystems};
use super::tag::{ConvexDecomposition, DEFAULT_DENSITY};
use crate::hulls_format::HullsFile;
use crate::rapier::{ColliderError, ContactDispatcher};

/// Turns tags into requests and results into colliders, and looks after what waits for one.
pub(super) struct ColliderPlugin;

impl Plugin for ColliderPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Unfinished>()
            .init_resource::<Fallbacks>()
            .add_observer(on_untag::<ConvexDecomposition>)
            .add_observer(on_untag::<BakedDecomposition>);
        // Where Rapier runs in fixed steps: a body that is tagged before them does not fall.
        app.add_systems(
            FixedUpdate,
            freeze_new.in_set(HullwrightSystems::DetectChanges).before(PhysicsSet::SyncBackend),
        );
        app.add_systems(
            PostUpdate,
            (
                set_dispatcher.in_set(HullwrightSystems::DetectChanges),
                (
                    detect_tags,
                    detect_bodies,
                    detect_assets::<Mesh>,
                    detect_assets::<BakedScene>,
                    detect_late_scenes,
                    detect_scales,
                    #[cfg(feature = "bevy_gltf")]
                    changes::detect_shown
                        .run_if(|settings: Res<HullwrightSettings>| settings.skip.hidden),
                    start_near.run_if(any_with_component::<FarFromFocus>),
                    drop_far.run_if(|settings: Res<HullwrightSettings>| settings.skip.drop_far),
                )
                    .chain()
                    .in_set(HullwrightSystems::DetectChanges),
                resolve
                    .after(finish_jobs)
                    .before(start_jobs)
                    .in_set(HullwrightSystems::RunJobs)
                    .run_if(is_busy),
                attach_fallbacks
                    .after(start_jobs)
                    .in_set(HullwrightSystems::RunJobs)
                    .run_if(|fallbacks: Res<Fallbacks>| !fallbacks.is_empty()),
                (
                    (attach, report_failures).chain().run_if(is_busy),
                    freeze.run_if(
                        is_busy
                            .or_else(any_with_component::<Frozen>)
                            .or_else(any_match_filter::<Added<FarFromFocus>>),
                    ),
                    release.run_if(any_with_component::<Frozen>),
                    remove_fallbacks.run_if(any_with_component::<AttachedFallback>),
                )
                    .chain()
                    .in_set(CollidersAttached),
                warn_of_skins
                    .after(CollidersAttached)
                    .in_set(HullwrightSystems::Attach)
                    .run_if(any_match_filter::<Added<AttachedCollider>>),
            ),
        )
        .configure_sets(
            PostUpdate,
            CollidersAttached.before(SlicesRun).in_set(HullwrightSystems::Attach),
        );
        hold_in(app, PostUpdate);
        hold_in(app, FixedUpdate);
    }

    /// Rapier may run in another schedule, which is known only now.
    fn finish(&self, app: &mut App) {
        let known = [PostUpdate.intern(), FixedUpdate.intern()];
        let all = app.world().resource::<Schedules>().iter().map(|(_, schedule)| schedule);
        let steps = |of: &&Schedule| of.graph().system_sets.contains(PhysicsSet::StepSimulation);
        let others: Vec<InternedScheduleLabel> =
            all.filter(steps).map(Schedule::label).filter(|label| !known.contains(label)).collect();
        others.into_iter().for_each(|schedule| hold_in(app, schedule));
    }
}

/// All of [`HullwrightSystems::Attach`] that concerns single entities.
#[derive(SystemSet, Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct CollidersAttached;

fn is_busy(
    unfinished: Res<Unfinished>,
    jobs: Res<Jobs>,
    counters: Res<DecompositionCounters>,
) -> bool {
    !unfinished.is_idle() || !jobs.is_idle() || counters.waiting_for_mesh > 0
}

/// Sets the dispatcher of each new world, for contacts that don't depend on the unit of length. Before the first
/// step a world has no contacts to lose.
fn set_dispatcher(
    settings: Res<HullwrightSettings>,
    mut worlds: Query<&mut RapierContextSimulation, Added<RapierContextSimulation>>,
) {
    if settings.contact_dispatcher {
        for mut world in &mut worlds {
            world.narrow_phase.set_query_dispatcher(ContactDispatcher);
        }
    }
}

/// Attaches colliders that are ready, within the frame's budget.
fn attach(
    mut work: Work,
    Frame { mut time, settings }: Frame,
    targets: Targets,
    mut sleepers: Sleepers,
    mut outcomes: Outcomes,
) {
    let mut budget = time.attaching_budget(&settings);
    for _ in 0..settings.budget.max_attached_per_frame.max(1) {
        if !budget.allows_one() {
            break;
        }
        let Some(Completed { entity, built }) = work.jobs.pop_completed() else { break };
        let Some(requested) = work.unfinished.requested(entity).cloned() else { continue };
        if let Err(error) = targets.attach(&mut outcomes.commands, entity, &requested, &built) {
            work.jobs.fail(entity, error);
            continue;
        }
        let Some((duration, _)) = work.unfinished.end(entity) else { continue };
        let present = targets.placements.stretch(entity);
        work.unfinished.detect_scale(entity, &requested.stretch, present);
        if let Some((body, _)) = targets.placements.body(entity) {
            sleepers.wake(body);
        }
        if let Some(reason) = requested.request.why_triangles() {
            outcomes.skipped(entity, reason);
            continue;
        }
        let (made_of, hulls, verified) = match &*built.geometry {
            ColliderGeometry::Triangles(_) => (MadeOf::Triangles, 0, None),
            ColliderGeometry::Primitive(..) => (MadeOf::Primitive, 1, None),
            ColliderGeometry::Hulls(file) => {
                let hulls = file.hulls.len();
                (MadeOf::Hulls(hulls), hulls, verified_distances(file))
            }
        };
        let (source, time) = (built.source, duration);
        outcomes.ready(DecompositionReady { entity, hulls, verified, source, time }, made_of);
    }
}

fn verified_distances(file: &HullsFile) -> Option<VerifiedDistances> {
    let errors = file.verified?;
    let share = |length: f64| (length / file.diagonal) as f32;
    let (protrusion, uncovered) = (share(errors.protrusion_max), share(errors.uncovered_max));
    Some(VerifiedDistances { protrusion, uncovered })
}

/// Reports failures. However many entities fail of the same in a frame, the log has one line.
fn report_failures(
    mut work: Work,
    placements: Placements,
    descriptions: Descriptions,
    attached: Query<&AttachedCollider>,
    mut outcomes: Outcomes,
) {
    // By their text: how many, and the first of them.
    let mut to_log: BTreeMap<String, (usize, String)> = BTreeMap::new();
    for Failed { entity, error, is_known } in work.jobs.take_failed() {
        let Some((_, requested)) = work.unfinished.end(entity) else { continue };
        if !is_known {
            let asset = requested.as_ref().and_then(|of| of.request.input.asset());
            let line = to_log.entry(error.to_string());
            line.or_insert_with(|| (0, descriptions.entity(entity, asset))).0 += 1;
        }
        if let Some(requested) = requested {
            let failed = FailedRequest { requested, error: error.clone() };
            if failed.depends_on_scale() {
                let present = placements.stretch(entity);
                work.unfinished.detect_scale(entity, &failed.requested.stretch, present);
            }
            outcomes.commands.entity(entity).try_insert(failed);
        }
        // One of another mesh or scale would be taken for this one.
        if let Ok(attached) = attached.get(entity) {
            let mut commands = outcomes.commands.entity(entity);
            detach::<AttachedCollider>(&mut commands, attached.owns_mass);
        }
        outcomes.failed(entity, error);
    }
    for (text, (count, first)) in to_log {
        log::warn!("no convex decomposition for {}: {text}", entities(count, &first));
    }
}

/// Bodies that may sleep.
#[derive(SystemParam)]
struct Sleepers<'w, 's> {
    components: Query<'w, 's, &'static mut Sleeping>,
    handles: Query<'w, 's, (&'static RapierRigidBodyHandle, &'static RapierContextEntityLink)>,
    bodies: Query<'w, 's, &'static mut RapierRigidBodySet>,
}

impl Sleepers<'_, '_> {
    fn wake(&mut self, body: Entity) {
        if let Ok(mut sleeping) = self.components.get_mut(body)
            && sleeping.sleeping
        {
            sleeping.sleeping = false;
        }
        // Bodies sleep without the component too.
        let Ok((handle, context)) = self.handles.get(body) else { return };
        let Ok(mut bodies) = self.bodies.get_mut(context.0) else { return };
        if let Some(body) = bodies.bodies.get_mut(handle.0)
            && body.is_sleeping()
        {
            body.wake_up(true);
        }
    }
}

/// The entities that colliders are attached to.
#[derive(SystemParam)]
struct Targets<'w, 's> {
    targets: Query<'w, 's, Target>,
    surfaces: Query<'w, 's, Surface>,
    placements: Placements<'w, 's>,
}

#[derive(QueryData)]
struct Target {
    tag: Option<&'static ConvexDecomposition>,
    baked: Option<&'static BakedDecomposition>,
    attached: Option<&'static AttachedCollider>,
    fallback: Option<&'static AttachedFallback>,
    has_mass: Has<ColliderMassProperties>,
}

impl Targets<'_, '_> {
    fn attach(
        &self,
        commands: &mut Commands,
        entity: Entity,
        requested: &Requested,
        built: &BuiltCollider,
    ) -> Result<(), DecompositionError> {
        let Ok(target) = self.targets.get(entity) else { return Ok(()) };
        let owned = target.attached.map(|attached| attached.owns_mass);
        let owned = owned.or_else(|| target.fallback.map(|fallback| fallback.owns_mass));
        let owns_mass = owned.unwrap_or(!target.has_mass);
        let mass = match owns_mass {
            true => mass_of(&built.geometry, target.tag, target.baked, &requested.request.map)?,
            false => None,
        };
        let mut commands = commands.entity(entity);
        let record = AttachedCollider { requested: requested.clone(), owns_mass };
        attach_shape(&mut commands, built.shape.clone(), record);
        if target.fallback.is_some() {
            commands.try_remove::<AttachedFallback>();
        }
        if let Some(mass) = mass {
            commands.try_insert(mass);
        }
        // A collider below a body inherits the components of its surface that it does not have itself.
        if let Some((body, _)) = self.placements.body(entity)
            && body != entity
            && let Ok([own, of_body]) = self.surfaces.get_many([entity, body])
        {
            own.inherit(&of_body, &mut commands);
        }
        Ok(())
    }
}

/// Declares what bevy_rapier reads from the entity of a collider, and people put on its body.
macro_rules! surface {
    ($($field:ident: $component:ty,)*) => {
        #[derive(QueryData)]
        struct Surface {
            $($field: Option<&'static $component>,)*
        }

        impl SurfaceItem<'_, '_> {
            fn inherit(&self, from: &Self, to: &mut EntityCommands) {
                $(if let (None, Some(component)) = (self.$field, from.$field) {
                    to.try_insert(*component);
                })*
            }
        }
    };
}

surface! {
    friction: Friction,
    restitution: Restitution,
    collision_groups: CollisionGroups,
    solver_groups: SolverGroups,
    sensor: Sensor,
    active_events: ActiveEvents,
    active_hooks: ActiveHooks,
    active_collision_types: ActiveCollisionTypes,
    contact_force_threshold: ContactForceEventThreshold,
    contact_skin: ContactSkin,
}

/// The mass of a collider; `None` for what has none, as triangles.
fn mass_of(
    geometry: &ColliderGeometry,
    tag: Option<&ConvexDecomposition>,
    baked: Option<&BakedDecomposition>,
    map: &Affine3A,
) -> Result<Option<ColliderMassProperties>, ColliderError> {
    // The mass is of the whole collider in the world.
    let (density, given) = match (baked, tag) {
        (Some(baked), _) => (baked.density, baked.mass),
        (None, Some(tag)) => (tag.density, tag.mass),
        (None, None) => (DEFAULT_DENSITY, None),
    };
    match geometry {
        ColliderGeometry::Triangles(_) => Ok(None),
        ColliderGeometry::Primitive(..) => {
            let number = given.unwrap_or(density);
            if !(number.is_finite() && number > 0.0) {
                return Err(ColliderError::UnusableMass { mass: number.into() });
            }
            Ok(Some(match given {
                Some(mass) => ColliderMassProperties::Mass(mass),
                None => ColliderMassProperties::Density(density),
            }))
        }
        ColliderGeometry::Hulls(file) => {
            let Some(properties) = file.mass_properties else { return Ok(None) };
            let mapped = map_mass(&properties.with_mass(properties.mass * f64::from(density)), map);
            let mapped = given.map_or(mapped, |mass| mapped.with_mass(mass.into()));
            rapier_mass(&mapped).map(Some)
        }
    }
}

fn rapier_mass(
    properties: &crate::MassProperties,
) -> Result<ColliderMassProperties, ColliderError> {
    let properties = crate::rapier::mass_properties(properties, [1.0; 3])?;
    Ok(ColliderMassProperties::MassProperties(MassProperties::from_rapier(properties)))
}
