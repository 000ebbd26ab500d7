//! From tags to requests, and from results to colliders: what has changed, what is attached, which
//! bodies wait. Errors become statuses, events, and one line of the log.

pub(super) mod cells;
pub(super) mod changes;
pub(super) mod children;
mod follow;
mod members;
mod moved;
pub(super) mod parts;
pub(super) mod placement;
pub(super) mod resolve;
mod skins;
mod split;
pub(super) mod waiting;
pub(super) mod work;

use std::collections::BTreeMap;

use bevy::ecs::system::SystemParam;
use bevy::mesh::skinning::SkinnedMesh;
use bevy::prelude::*;
use hullwright::hulls_format::HullsFile;
use hullwright_parry::ColliderError;

use self::cells::{InLevelCell, LevelCell};
use self::changes::{
    LoneScene, detect_assets, detect_moved_parts, detect_scales, detect_tags, drop_far,
    on_collider, on_untag, start_near,
};
use self::children::ColliderInChildren;
use self::follow::follow_scales;
use self::members::{Cells, detect_leaving, drop_clones, finish_members, on_empty, on_leave};
use self::parts::ColliderParts;
use self::placement::{Placements, Stretch, inherit_surface, maps_differ};
use self::resolve::{compare_marked, resolve};
use self::skins::warn_of_skins;
use self::waiting::{
    Fallbacks, attach_fallbacks, freeze, freeze_new, freeze_skipped, release, remove_fallbacks,
};
use self::work::{
    AttachedCollider, AttachedFallback, Ended, FailedRequest, FarFromFocus, MadeBefore,
    MadeBeforeItem, OwnCollider, Requested, Unfinished, Work, attach_shape,
};
use super::engine::{Engine, Frozen, Weight};
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
pub(super) fn plugin<E: Engine>(app: &mut App) {
    app.init_resource::<Unfinished>()
        .init_resource::<Fallbacks>()
        .init_resource::<Cells>()
        .init_resource::<E::Cache>()
        .add_observer(on_collider::<E>)
        .add_observer(on_empty)
        .add_observer(on_leave)
        .add_observer(on_untag::<E, ConvexDecomposition>)
        .add_observer(on_untag::<E, BakedDecomposition>);
    // Where the engine runs in fixed steps: a body that is tagged before them does not fall.
    app.add_systems(E::fixed_steps(), freeze_new::<E>.in_set(HullwrightSystems::DetectChanges));
    app.add_systems(
        PostUpdate,
        (
            (
                detect_tags::<E>,
                detect_assets::<E, Mesh>,
                detect_assets::<E, BakedScene>,
                detect_scales::<E>,
                detect_moved_parts::<E>,
                (detect_leaving::<E>, drop_clones),
                #[cfg(feature = "bevy_gltf")]
                changes::detect_shown::<E>
                    .run_if(|settings: Res<HullwrightSettings>| settings.skip.hidden),
                start_near.run_if(any_with_component::<FarFromFocus>),
                drop_far::<E>.run_if(|settings: Res<HullwrightSettings>| settings.skip.drop_far),
                compare_marked::<E>.run_if(|of: Res<Unfinished>| !of.marked.is_empty()),
            )
                .chain()
                .in_set(HullwrightSystems::DetectChanges),
            resolve::<E>
                .after(finish_jobs)
                .before(start_jobs)
                .in_set(HullwrightSystems::RunJobs)
                .run_if(is_busy),
            attach_fallbacks::<E>
                .after(start_jobs)
                .in_set(HullwrightSystems::RunJobs)
                .run_if(|fallbacks: Res<Fallbacks>| !fallbacks.is_empty()),
            (
                (attach::<E>, report_failures::<E>, finish_members::<E>).chain().run_if(is_busy),
                follow_scales::<E>.run_if(|of: Res<Unfinished>| !of.to_follow.is_empty()),
                freeze::<E>.run_if(
                    is_busy
                        .or_else(any_with_component::<Frozen>)
                        .or_else(any_match_filter::<Added<FarFromFocus>>),
                ),
                freeze_skipped::<E>.run_if(|| E::BODIES_FALL_WITHOUT_MASS),
                release::<E>.run_if(any_with_component::<Frozen>),
                remove_fallbacks::<E>.run_if(any_with_component::<AttachedFallback>),
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

/// Attaches colliders that are ready, within the frame's budget.
fn attach<E: Engine>(
    mut work: Work,
    Frame { mut time, settings }: Frame,
    targets: Targets<E>,
    mut cache: ResMut<E::Cache>,
    mut is_logged: Local<bool>,
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
        let commands = &mut outcomes.commands;
        let attached = targets.attach(commands, entity, &target, &requested, &built, &mut cache);
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
        match targets.placements.body(entity) {
            Some((body, _)) => E::wake(&mut outcomes.commands, body),
            None if *is_logged || targets.placements.is_sensor(entity) => {}
            None => {
                if let Some(why) = E::WITHOUT_BODY {
                    *is_logged = true;
                    let who = targets.descriptions.entity(entity, None);
                    log::warn!("{who}: {why}; so for all others of which nothing is said");
                }
            }
        }
        if targets.cells.contains(entity) {
            outcomes.counters.level_cells += 1;
            continue;
        }
        if let Some(reason) = requested.request.why_triangles() {
            outcomes.skipped(entity, reason);
            continue;
        }
        let (made_of, hulls, verified) = match &*built.geometry {
            ColliderGeometry::Triangles(_) => (MadeOf::Triangles, 0, None),
            ColliderGeometry::Primitive(..) => (MadeOf::Primitive, 1, None),
            ColliderGeometry::Hulls(file, _) => {
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
fn report_failures<E: Engine>(
    mut work: Work,
    placements: Placements<E>,
    descriptions: Descriptions,
    before: Query<MadeBefore<E>>,
    cells: Query<(), With<LevelCell>>,
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
        let is_cell = cells.contains(entity);
        if !is_known && !is_cell {
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
        // Those in it report for themselves.
        if !is_cell {
            outcomes.failed(entity, error);
        }
    }
    for (text, (count, first)) in to_log {
        log::warn!("no convex decomposition for {}: {text}", entities(count, &first));
    }
}

/// The entities that colliders are attached to.
#[derive(SystemParam)]
struct Targets<'w, 's, E: Engine> {
    before: Query<'w, 's, MadeBefore<E>>,
    surfaces: Query<'w, 's, <E as Engine>::Surface>,
    placements: Placements<'w, 's, E>,
    descriptions: Descriptions<'w, 's>,
    cells: Query<'w, 's, (), With<LevelCell>>,
}

impl<E: Engine> Targets<'_, '_, E> {
    /// Attaches what was made, at the scale of now, which it returns if it was made at another.
    fn attach(
        &self,
        commands: &mut Commands,
        entity: Entity,
        before: &MadeBeforeItem<E>,
        requested: &Requested,
        built: &BuiltCollider,
        cache: &mut E::Cache,
    ) -> Result<Option<Stretch>, DecompositionError> {
        let place = self.placements.placement(entity);
        let mass = match &*built.geometry {
            ColliderGeometry::Hulls(file, _) => file.mass_properties,
            ColliderGeometry::Triangles(_) | ColliderGeometry::Primitive(..) => None,
        };
        let made_map = requested.request.to_collider();
        let shape = built.shape.clone();
        let (own, collider) = OwnCollider::at::<E>(&place, shape, made_map, mass, cache);
        let mass = match (before.owns_mass(), &*built.geometry) {
            (false, _) => None,
            (true, ColliderGeometry::Primitive(..)) => {
                check_weight(requested.weight)?;
                Some(E::mass_by_volume(&own.shape, requested.weight))
            }
            (true, _) => own.weigh::<E>(requested.weight, &place.map)?,
        };
        let mut commands = commands.entity(entity);
        if before.owns_mass() && mass.is_none() {
            E::remove_mass(&mut commands);
        }
        commands.try_remove::<(AttachedFallback, InLevelCell)>();
        if before.is_in_children() {
            children::detach(&mut commands);
        }
        let parts = ColliderParts::new(requested.parts.clone(), built.geometry.clone());
        let is_of_hulls = matches!(*built.geometry, ColliderGeometry::Hulls(..));
        let grouping = requested.children.filter(|_| is_of_hulls);
        let in_children = grouping.map(|grouping| (grouping, own.clone(), parts.clone()));
        let record = (AttachedCollider { requested: requested.clone() }, parts);
        match in_children {
            Some(_) => {
                E::remove_collider(&mut commands);
                E::remove_mass(&mut commands);
                commands.try_insert((own, record, ColliderInChildren));
            }
            None => attach_shape::<E>(&mut commands, (own, collider), mass, record),
        }
        inherit_surface::<E>(entity, &self.placements, &self.surfaces, &mut commands);
        if let Some((grouping, own, parts)) = in_children {
            let how = (grouping, requested.weight);
            split::attach::<E>(commands.commands_mut(), entity, &own, &place, &parts, how, cache)?;
        }
        Ok(maps_differ(&made_map, &place.map).then_some(place.stretch))
    }
}

/// Whether a box, ball or capsule can have this density or mass.
fn check_weight(weight: Weight) -> Result<(), ColliderError> {
    let number = weight.mass.unwrap_or(weight.density);
    match number.is_finite() && number > 0.0 {
        true => Ok(()),
        false => Err(ColliderError::UnusableMass { mass: number.into() }),
    }
}
