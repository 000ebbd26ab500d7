//! From tags to requests, and from results to colliders: what has changed, what is attached, which
//! bodies wait. Errors become statuses, events, and one line of the log.

pub(super) mod changes;
mod follow;
mod moved;
pub(super) mod placement;
pub(super) mod resolve;
mod skins;
pub(super) mod waiting;
mod wake;
pub(super) mod work;

use std::collections::BTreeMap;

use bevy::ecs::query::QueryData;
use bevy::ecs::schedule::{InternedScheduleLabel, ScheduleLabel};
use bevy::ecs::system::{EntityCommands, SystemParam};
use bevy::mesh::skinning::SkinnedMesh;
use bevy::prelude::*;
use bevy_rapier3d::plugin::PhysicsSet;
use bevy_rapier3d::plugin::context::RapierContextSimulation;
use bevy_rapier3d::prelude::{
    ActiveCollisionTypes, ActiveEvents, ActiveHooks, ColliderMassProperties, CollisionGroups,
    ContactForceEventThreshold, ContactSkin, Friction, Restitution, Sensor, SolverGroups,
};
use hullwright::hulls_format::HullsFile;
use hullwright_rapier::{ColliderError, ContactDispatcher};

use self::changes::{
    LoneScene, detect_assets, detect_moved_parts, detect_scales, detect_tags, drop_far,
    on_collider, on_untag, start_near,
};
use self::follow::follow_scales;
use self::placement::{Placements, Stretch, maps_differ};
use self::resolve::{compare_marked, resolve};
use self::skins::warn_of_skins;
use self::waiting::{
    Fallbacks, Frozen, attach_fallbacks, freeze, freeze_new, hold_in, release, remove_fallbacks,
};
use self::wake::Sleepers;
use self::work::{
    AttachedCollider, AttachedFallback, Ended, FailedRequest, FarFromFocus, MadeBefore,
    MadeBeforeItem, OwnCollider, OwnMass, Requested, Unfinished, Weight, Work, attach_shape,
};
use super::jobs::baked::{BakedDecomposition, BakedScene};
use super::jobs::cache::{BuiltCollider, ColliderGeometry};
use super::jobs::{Completed, Failed, Frame, Jobs, SlicesRun, finish_jobs, start_jobs};
use super::tag::ConvexDecomposition;
use super::tag::outcomes::{
    DecompositionCounters, DecompositionError, DecompositionReady, Descriptions, MadeOf, Outcomes,
    SkipReason, VerifiedDistances, entities,
};
use super::tag::settings::{HullwrightSettings, HullwrightSystems};

/// Turns tags into requests and results into colliders, and looks after what waits for one.
pub(super) struct ColliderPlugin;

impl Plugin for ColliderPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Unfinished>()
            .init_resource::<Fallbacks>()
            .register_type::<OwnMass>()
            .add_observer(on_collider)
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
                    detect_assets::<Mesh>,
                    detect_assets::<BakedScene>,
                    detect_scales,
                    detect_moved_parts,
                    #[cfg(feature = "bevy_gltf")]
                    changes::detect_shown
                        .run_if(|settings: Res<HullwrightSettings>| settings.skip.hidden),
                    start_near.run_if(any_with_component::<FarFromFocus>),
                    drop_far.run_if(|settings: Res<HullwrightSettings>| settings.skip.drop_far),
                    compare_marked.run_if(|of: Res<Unfinished>| !of.marked.is_empty()),
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
                    follow_scales.run_if(|of: Res<Unfinished>| !of.to_follow.is_empty()),
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
                    .run_if(any_with_component::<SkinnedMesh>),
                changes::warn_of_lone_scenes
                    .in_set(HullwrightSystems::Attach)
                    .run_if(any_match_filter::<LoneScene>),
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

/// Sets the dispatcher of each new world, for contacts that don't depend on the unit of length.
/// Before the first step a world has no contacts to lose.
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
        let Some(Completed { entity, request, built }) = work.jobs.pop_completed() else { break };
        if !work.unfinished.contains(entity) {
            continue;
        }
        let Some(wanted) = work.unfinished.requested(entity).cloned() else { continue };
        let Ok(target) = targets.before.get(entity) else {
            work.unfinished.park(entity);
            continue;
        };
        if target.has_games_collider() {
            work.unfinished.end(entity);
            target.detach(&mut outcomes.commands.entity(entity));
            outcomes.skipped(entity, SkipReason::HasCollider);
            continue;
        }
        let requested = Requested { request, ..wanted };
        let attached = targets.attach(&mut outcomes.commands, entity, &target, &requested, &built);
        let stretch = match attached {
            Ok(stretch) => stretch,
            Err(error) => {
                work.jobs.fail(entity, error);
                continue;
            }
        };
        let Some(Ended { time, .. }) = work.unfinished.end(entity) else { continue };
        // It is made anew once its scale rests.
        if let Some(stretch) = stretch {
            work.unfinished.moves(entity, stretch);
        }
        sleepers.wake(&targets.placements, entity);
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
        let source = built.source;
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
    before: Query<MadeBefore>,
    mut outcomes: Outcomes,
) {
    // By their text: how many, and the first of them.
    let mut to_log: BTreeMap<String, (usize, String)> = BTreeMap::new();
    for Failed { entity, error, is_known } in work.jobs.take_failed() {
        let Some(Ended { requested, is_outdated, .. }) = work.unfinished.end(entity) else {
            continue;
        };
        // It has started anew, and the collider that it has stays meanwhile.
        if is_outdated {
            continue;
        }
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
        if let Ok(before) = before.get(entity) {
            before.detach(&mut outcomes.commands.entity(entity));
        }
        outcomes.failed(entity, error);
    }
    for (text, (count, first)) in to_log {
        log::warn!("no convex decomposition for {}: {text}", entities(count, &first));
    }
}

/// The entities that colliders are attached to.
#[derive(SystemParam)]
struct Targets<'w, 's> {
    before: Query<'w, 's, MadeBefore>,
    surfaces: Query<'w, 's, Surface>,
    placements: Placements<'w, 's>,
}

impl Targets<'_, '_> {
    /// Attaches what was made, at the scale of now, which it returns if it was made at another.
    fn attach(
        &self,
        commands: &mut Commands,
        entity: Entity,
        before: &MadeBeforeItem,
        requested: &Requested,
        built: &BuiltCollider,
    ) -> Result<Option<Stretch>, DecompositionError> {
        let place = self.placements.placement(entity);
        let mass = match &*built.geometry {
            ColliderGeometry::Hulls(file) => file.mass_properties,
            ColliderGeometry::Triangles(_) | ColliderGeometry::Primitive(..) => None,
        };
        let made_map = requested.request.to_collider();
        let own = OwnCollider::at(&place, built.shape.clone(), made_map, mass);
        let mass = match (before.owns_mass(), &*built.geometry) {
            (false, _) => None,
            (true, ColliderGeometry::Primitive(..)) => Some(mass_of_primitive(requested.weight)?),
            (true, _) => own.weigh(requested.weight, &place.map)?,
        };
        let mut commands = commands.entity(entity);
        if before.owns_mass() && mass.is_none() {
            commands.try_remove::<(ColliderMassProperties, OwnMass)>();
        }
        let record = AttachedCollider { requested: requested.clone() };
        attach_shape(&mut commands, own, mass, record);
        commands.try_remove::<AttachedFallback>();
        // A collider inherits the components of its surface that it does not have itself.
        if let Ok(own) = self.surfaces.get(entity) {
            let givers = self.placements.givers(entity).filter(|giver| *giver != entity);
            let givers: Vec<_> = givers.filter_map(|giver| self.surfaces.get(giver).ok()).collect();
            own.inherit(&givers, &mut commands);
        }
        Ok(maps_differ(&made_map, &place.map).then_some(place.stretch))
    }
}

/// Declares what bevy_rapier reads from the entity of a collider, and people put on its body or its
/// scene.
macro_rules! surface {
    ($($field:ident: $component:ty,)*) => {
        #[derive(QueryData)]
        struct Surface {
            $($field: Option<&'static $component>,)*
        }

        impl SurfaceItem<'_, '_> {
            fn inherit(&self, from: &[Self], to: &mut EntityCommands) {
                $(if self.$field.is_none()
                    && let Some(component) = from.iter().find_map(|giver| giver.$field)
                {
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

/// The mass of a box, ball or capsule, by its volume.
fn mass_of_primitive(weight: Weight) -> Result<ColliderMassProperties, ColliderError> {
    let number = weight.mass.unwrap_or(weight.density);
    if !(number.is_finite() && number > 0.0) {
        return Err(ColliderError::UnusableMass { mass: number.into() });
    }
    Ok(match weight.mass {
        Some(mass) => ColliderMassProperties::Mass(mass),
        None => ColliderMassProperties::Density(weight.density),
    })
}
