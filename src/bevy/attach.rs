//! Results reach their entities: as as statuses, as events.

use std::sync::Arc;

use bevy::ecs::system::SystemParam;
use bevy::math::Affine3A;
use bevy::prelude::*;
use bevy_rapier3d::prelude::{
    Collider, ColliderMassProperties, ColliderScale, CollisionGroups, Friction, MassProperties,
    RapierContextEntityLink, RapierRigidBodyHandle, RapierRigidBodySet, Restitution, Sensor,
    Sleeping, SolverGroups,
};

use crate::ColliderError;

use super::baked::BakedDecomposition;
use super::failing::Failure;
use super::library::Material;
use super::meanwhile::StandIn;
use super::placement::{Placements, Stretch, map_mass};
use super::work::{Delivery, SourceId, Work};
use super::{
    ConvexDecomposition, DecompositionCounters, DecompositionFailure, DecompositionReady,
    DecompositionStatus, HullwrightSettings, Origin, Skip,
};

/// On entities whose collider is ours: what it was made from.
#[derive(Component, Debug, Clone)]
pub(super) struct Attached {
    pub source: Arc<SourceId>,
    pub stretch: Stretch,
    /// From the entity's space to the collider's.
    #[cfg_attr(
        not(feature = "debug"),
        expect(dead_code, reason = "drawn with the feature `debug`")
    )]
    pub map: Affine3A,
    /// Whether it is the triangle mesh.
    pub is_exact: bool,
    /// Whether we set the mass properties, or found them set.
    owns_mass: bool,
}

/// What is looked at when a collider is attached.
#[derive(SystemParam)]
pub(super) struct Targets<'w, 's> {
    targets: Query<'w, 's, TargetComponents>,
    surfaces: Query<'w, 's, SurfaceComponents>,
    placements: Placements<'w, 's>,
}

type TargetComponents = (
    Option<&'static ConvexDecomposition>,
    Option<&'static BakedDecomposition>,
    Option<&'static Attached>,
    Option<&'static StandIn>,
    Has<ColliderMassProperties>,
);

type SurfaceComponents = (
    Option<&'static Friction>,
    Option<&'static Restitution>,
    Option<&'static CollisionGroups>,
    Option<&'static SolverGroups>,
    Option<&'static Sensor>,
);

/// Attaches what is ready, within the frame's budget.
pub(super) fn attach(
    mut commands: Commands,
    mut work: ResMut<Work>,
    mut counters: ResMut<DecompositionCounters>,
    settings: Res<HullwrightSettings>,
    targets: Targets,
    mut sleepers: Sleepers,
    mut statuses: Query<&mut DecompositionStatus>,
) {
    let mut budget = work.budget(&settings);
    for _ in 0..settings.max_attached_per_frame.max(1) {
        if work.deliveries.is_empty() || !budget.allows_one() {
            break;
        }
        let Some(delivery) = work.deliveries.pop_front() else { break };
        let entity = delivery.entity;
        match targets.attach(&mut commands, &delivery) {
            Ok(hulls) => {
                work.requests.remove(&entity);
                let present = targets.placements.stretch(entity);
                work.notice_missed_scale(entity, &delivery.ask.stretch, present);
                if let Some((body, _)) = targets.placements.body(entity) {
                    sleepers.wake(body);
                }
                let status = count(&mut counters, &delivery, hulls);
                if let Ok(mut old) = statuses.get_mut(entity) {
                    *old = status;
                }
                commands.trigger(DecompositionReady { entity, hulls });
            }
            Err(why) => work.failures.push(Failure { entity, why, is_known: false }),
        }
    }
}

/// Bodies that may sleep.
#[derive(SystemParam)]
pub(super) struct Sleepers<'w, 's> {
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

fn count(
    counters: &mut DecompositionCounters,
    delivery: &Delivery,
    hulls: usize,
) -> DecompositionStatus {
    let made = &delivery.made;
    if let Material::Triangles(_) = *made.material {
        counters.triangle_meshes += 1;
        return DecompositionStatus::Skipped(Skip::FixedBody);
    }
    if hulls == 1 {
        counters.convex += 1;
    }
    match made.origin {
        Origin::Decomposed => {}
        Origin::Shared => counters.shared += 1,
        Origin::Disk => counters.from_disk += 1,
        Origin::Baked => counters.baked += 1,
    }
    DecompositionStatus::Ready(made.origin)
}

impl Targets<'_, '_> {
    /// The number of hulls.
    fn attach(
        &self,
        commands: &mut Commands,
        delivery: &Delivery,
    ) -> Result<usize, DecompositionFailure> {
        let Delivery { entity, ask, made } = delivery;
        let Ok((tag, baked, attached, stand_in, has_mass)) = self.targets.get(*entity) else {
            return Ok(0);
        };
        let owned = attached.map(|attached| attached.owns_mass);
        let owned = owned.or_else(|| stand_in.map(|stand_in| stand_in.owns_mass));
        let owns_mass = owned.unwrap_or(!has_mass);
        let (mass, hulls) = match &*made.material {
            Material::Triangles(_) => (None, 0),
            Material::Hulls(file) => {
                let density = tag.map_or(1.0, |tag| f64::from(tag.density));
                let mass = file.mass_properties.map(|properties| {
                    let mass = match baked {
                        Some(baked) => baked.mass.map_or(properties.mass, f64::from),
                        None => properties.mass * density,
                    };
                    map_mass(&properties.with_mass(mass), &ask.map)
                });
                (mass, file.hulls.len())
            }
        };
        let mass = match mass.filter(|_| owns_mass) {
            Some(mass) => Some(rapier_mass(&mass)?),
            None => None,
        };
        // The scale is in the points; bevy_rapier must not apply it again.
        commands.entity(*entity).try_insert((
            Collider::from(made.shape.clone()),
            ColliderScale::Absolute(Vec3::ONE),
            Attached {
                source: ask.source.clone(),
                stretch: ask.stretch,
                map: ask.map * ask.before,
                is_exact: ask.is_exact(),
                owns_mass,
            },
        ));
        if stand_in.is_some() {
            commands.entity(*entity).try_remove::<StandIn>();
        }
        if let Some(mass) = mass {
            commands.entity(*entity).try_insert(mass);
        }
        self.inherit_surface(commands, *entity);
        Ok(hulls)
    }

    /// A collider below a body feels as the body says, unless it says otherwise itself.
    fn inherit_surface(&self, commands: &mut Commands, entity: Entity) {
        let Some((body, _)) = self.placements.body(entity) else { return };
        if body == entity {
            return;
        }
        let (Ok(own), Ok(of_body)) = (self.surfaces.get(entity), self.surfaces.get(body)) else {
            return;
        };
        let mut entity = commands.entity(entity);
        if let (None, Some(friction)) = (own.0, of_body.0) {
            entity.try_insert(*friction);
        }
        if let (None, Some(restitution)) = (own.1, of_body.1) {
            entity.try_insert(*restitution);
        }
        if let (None, Some(groups)) = (own.2, of_body.2) {
            entity.try_insert(*groups);
        }
        if let (None, Some(groups)) = (own.3, of_body.3) {
            entity.try_insert(*groups);
        }
        if let (None, Some(sensor)) = (own.4, of_body.4) {
            entity.try_insert(*sensor);
        }
    }
}

fn rapier_mass(
    properties: &crate::MassProperties,
) -> Result<ColliderMassProperties, ColliderError> {
    let properties = crate::rapier::mass_properties(properties, [1.0; 3])?;
    Ok(ColliderMassProperties::MassProperties(MassProperties::from_rapier(properties)))
}
