//! Frozen bodies, held in Avian's solver during its steps.

use avian3d::dynamics::solver::solver_body::{
    SolverBodies, SolverBodyFlags, SolverBodyIndex, SolverBodyInertia,
};
use avian3d::prelude::*;
use bevy::ecs::entity::EntityHashMap;
use bevy::prelude::*;

use super::{Avian, OwnMass};
use crate::engine::{Engine, Frozen};

/// The velocities that bodies are to have again after the step.
#[derive(Resource, Default)]
struct Held(EntityHashMap<(LinearVelocity, AngularVelocity)>);

/// Holds frozen bodies: for the solver they are kinematic and at rest. The schedule does not allow
/// ambiguity, and what reads velocities there reads them as they are to be.
pub(super) fn hold(app: &mut App) {
    app.init_resource::<Held>().add_observer(lend_mass).add_observer(take_mass_back);
    app.add_systems(
        PhysicsSchedule,
        (
            hold_bodies
                .after(SolverSystems::PrepareSolverBodies)
                .before(SolverSystems::PrepareJoints),
            let_go.after(SolverSystems::Finalize).before(PhysicsStepSystems::Sleeping),
        )
            .chain()
            .ambiguous_with_all()
            .run_if(any_with_component::<Frozen>),
    );
}

type Weightless = (Without<Mass>, Without<AngularInertia>, Without<CenterOfMass>);

/// Avian warns of each body that has no mass yet, so one that waits has this.
fn lend_mass(frozen: On<Add<Frozen>>, weightless: Query<(), Weightless>, mut commands: Commands) {
    if weightless.contains(frozen.entity) {
        Avian::set_mass(&mut commands.entity(frozen.entity), OwnMass::LENT);
    }
}

/// Where it has no other by then.
fn take_mass_back(released: On<Remove<Frozen>>, masses: Query<&OwnMass>, mut commands: Commands) {
    if masses.get(released.entity) == Ok(&OwnMass::LENT) {
        Avian::remove_mass(&mut commands.entity(released.entity));
    }
}

fn hold_bodies(
    frozen: Query<
        (Entity, &RigidBody, &SolverBodyIndex, &LinearVelocity, &AngularVelocity),
        With<Frozen>,
    >,
    mut solver: ResMut<SolverBodies>,
    mut all_held: ResMut<Held>,
) {
    for (entity, kind, index, linear, angular) in &frozen {
        if !kind.is_dynamic() {
            continue;
        }
        if let Some(body) = solver.get_mut(*index) {
            (body.linear_velocity, body.angular_velocity) = (Vec3::ZERO, Vec3::ZERO);
            body.flags |= SolverBodyFlags::IS_KINEMATIC;
        }
        if let Some(inertia) = solver.get_inertia_mut(*index) {
            let immovable = ComputedAngularInertia::INFINITY.inverse();
            *inertia = SolverBodyInertia::new(0.0, immovable, LockedAxes::ALL_LOCKED, 0, false);
        }
        all_held.0.insert(entity, (*linear, *angular));
    }
}

/// Awake, since it is to fall as soon as it is released.
fn let_go(
    mut frozen: Query<
        (&mut LinearVelocity, &mut AngularVelocity, Option<&mut SleepTimer>),
        With<Frozen>,
    >,
    mut all_held: ResMut<Held>,
) {
    for (entity, (held_linear, held_angular)) in all_held.0.drain() {
        if let Ok((mut linear, mut angular, timer)) = frozen.get_mut(entity) {
            (*linear, *angular) = (held_linear, held_angular);
            if let Some(mut timer) = timer {
                timer.0 = 0.0;
            }
        }
    }
}
