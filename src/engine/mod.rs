//! The seam between the plugin and a physics engine: what an engine has to do, done by Rapier and
//! by Avian. Nothing else in this crate names an engine.

/// Declares what an engine reads from the entity of a collider, and people put on its body or its
/// scene.
macro_rules! surface {
    ($($field:ident: $component:ty,)*) => {
        fn copy_surface(entity: &mut EntityCommands, to: Entity) {
            entity.clone_with_opt_in(to, |builder| {
                $(builder.allow::<$component>();)*
            });
        }

        #[derive(bevy::ecs::query::QueryData)]
        pub(crate) struct Surface {
            $($field: Option<&'static $component>,)*
        }

        fn has_surface(own: &SurfaceItem) -> bool {
            $(own.$field.is_some())||*
        }

        fn inherit(own: &SurfaceItem, from: &[SurfaceItem], to: &mut EntityCommands) {
            $(if own.$field.is_none()
                && let Some(component) = from.iter().find_map(|giver| giver.$field)
            {
                to.try_insert(component.clone());
            })*
        }
    };
}

#[cfg(feature = "avian")]
pub(super) mod avian;
#[cfg(feature = "rapier")]
pub(super) mod rapier;

use bevy::ecs::component::Mutable;
use bevy::ecs::entity::EntityHashSet;
use bevy::ecs::query::{ArchetypeQueryData, QueryData, ReadOnlyQueryData};
use bevy::ecs::schedule::InternedScheduleLabel;
use bevy::ecs::system::EntityCommands;
use bevy::prelude::*;
#[cfg(feature = "bevy_gltf")]
use hullwright_formats::conventions::{BodyMotion, SurfaceProperties};
use hullwright_parry::parry3d::mass_properties::MassProperties;
use hullwright_parry::parry3d::shape::SharedShape;

use crate::tag::settings::HullwrightSystems;

#[cfg(not(any(feature = "avian", feature = "rapier")))]
compile_error!("bevy_hullwright needs a physics engine: enable the feature `rapier` or `avian`");

/// The physics engine that gets the colliders: the one whose plugin the app has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum PhysicsEngine {
    /// Rapier, by bevy_rapier3d (feature `rapier`).
    #[cfg(feature = "rapier")]
    #[default]
    Rapier,
    /// Avian, by avian3d (feature `avian`).
    #[cfg(feature = "avian")]
    #[cfg_attr(not(feature = "rapier"), default)]
    Avian,
}

/// How a body moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Motion {
    Fixed,
    Kinematic,
    Dynamic,
}

/// On a body that is frozen: the entities that it waits for. The engine holds it in place during
/// its steps alone, so that what users see, clone and save of it is their own.
#[derive(Component, Debug, Default)]
pub(crate) struct Frozen {
    pub for_entities: EntityHashSet,
}

/// What makes up a volume's mass: a density, or a mass that replaces it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Weight {
    pub density: f32,
    pub mass: Option<f32>,
}

/// How a body moves at one moment.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Velocity {
    pub linear: Vec3,
    pub angular: Vec3,
    /// The point that has the linear one, its centre of mass, in the world.
    pub centre: Vec3,
}

impl Velocity {
    /// The same motion, of a body with another centre of mass.
    pub(crate) fn at(self, centre: Vec3) -> Self {
        let linear = self.linear + self.angular.cross(centre - self.centre);
        Self { linear, centre, ..self }
    }
}

/// The item of a query.
pub(crate) type Item<'w, 's, D> = <D as QueryData>::Item<'w, 's>;

/// A physics engine. What is written is written by commands, since the entity may be gone.
pub(crate) trait Engine: Send + Sync + Sized + 'static {
    /// What makes an entity a body.
    type Body: Component;
    /// The collider of an entity.
    type Collider: Component;
    /// Marks colliders that touch nothing.
    type Sensor: Component;
    /// Mass properties, as components.
    type Mass: Send + 'static;
    /// What is kept of colliders so that equal ones share what they are made of.
    type Cache: Resource<Mutability = Mutable> + Default;
    /// What an entity has of a collider and its mass.
    type Made: ReadOnlyQueryData + ArchetypeQueryData + 'static;
    /// What a collider inherits from its body or scene.
    type Surface: ReadOnlyQueryData + 'static;

    /// Whether the engine scales colliders, and their offsets from their body, by the product of
    /// all scales above them.
    const SCALES_COLLIDERS: bool;

    /// What the log says once of colliders that no body moves, where nothing bumps into them.
    const WITHOUT_BODY: Option<&str>;

    /// Whether a body falls that has neither collider nor mass.
    const BODIES_FALL_WITHOUT_MASS: bool;

    /// Adds what the engine needs for itself: how bodies are held, and sets before its steps.
    fn build(app: &mut App);

    /// What can be known only when all plugins are there; warns where the engine's is missing.
    fn finish(app: &mut App);

    /// The schedule of fixed steps in which new bodies may have to be frozen, before its systems.
    fn fixed_steps() -> InternedScheduleLabel;

    fn motion(body: &Self::Body) -> Motion;

    fn body(motion: Motion) -> Self::Body;

    fn present<'a>(made: &'a Item<'_, '_, Self::Made>) -> Option<&'a Self::Collider>;

    /// Whether the plugin has left the collider to the engine, which changes it.
    fn is_left(_: &Item<'_, '_, Self::Made>) -> bool {
        false
    }

    /// Whether the mass of an entity is the plugin's to set.
    fn owns_mass(made: &Item<'_, '_, Self::Made>) -> bool;

    /// A collider that has this shape once the engine has applied the scale.
    fn collider(shape: &SharedShape, scale: Vec3, cache: &mut Self::Cache) -> Self::Collider;

    /// The shape of a collider before the engine scales it.
    fn unscaled(collider: &Self::Collider) -> &SharedShape;

    /// Gives an entity a collider.
    fn attach(entity: &mut EntityCommands, collider: Self::Collider);

    /// Changes the collider that an entity has, often: with as little work as the engine allows.
    fn replace(entity: &mut EntityCommands, collider: Self::Collider, mass: Option<Self::Mass>) {
        Self::attach(entity, collider);
        if let Some(mass) = mass {
            Self::set_mass(entity, mass);
        }
    }

    fn remove_collider(entity: &mut EntityCommands);

    /// The collider is the engine's from now on, and has this scale, where that is known.
    fn leave(_: &mut EntityCommands, _: Option<Vec3>) {}

    /// Mass properties in the collider's space.
    fn mass(properties: MassProperties) -> Self::Mass;

    /// Those of a shape by its volume.
    fn mass_by_volume(shape: &SharedShape, weight: Weight) -> Self::Mass;

    fn set_mass(entity: &mut EntityCommands, mass: Self::Mass);

    fn remove_mass(entity: &mut EntityCommands);

    /// Gives a collider the components of the nearest giver that has them, but none that it has.
    fn inherit(
        own: &Item<'_, '_, Self::Surface>,
        from: &[Item<'_, '_, Self::Surface>],
        to: &mut EntityCommands,
    );

    /// Whether a collider has anything of a surface by itself.
    fn has_surface(own: &Item<'_, '_, Self::Surface>) -> bool;

    /// Copies what a collider has of its surface to another entity.
    fn copy_surface(entity: &mut EntityCommands, to: Entity);

    /// Copies to another entity what a body has of its own, apart from where and how it moves.
    fn copy_dynamics(body: &mut EntityCommands, to: Entity);

    /// How a body moves; without any velocity for what is none.
    fn velocity(world: &World, body: Entity) -> Velocity;

    fn set_velocity(entity: &mut EntityCommands, velocity: Velocity);

    /// Wakes a body that may sleep.
    fn wake(commands: &mut Commands, body: Entity);

    /// Gives a collider the components that a file says, but none that it has.
    #[cfg(feature = "bevy_gltf")]
    fn insert_surface(entity: &mut EntityCommands, surface: &SurfaceProperties);

    /// A collider of a shape that the file has, which the engine scales from now on. `scale` is
    /// that of the entity.
    #[cfg(feature = "bevy_gltf")]
    fn attach_declared(entity: &mut EntityCommands, shape: SharedShape, scale: Vec3);

    /// A body that keeps the velocity that it has.
    #[cfg(feature = "bevy_gltf")]
    fn body_of_constant_velocity() -> Self::Body;

    #[cfg(feature = "bevy_gltf")]
    fn insert_gravity(entity: &mut EntityCommands, factor: f32);

    /// Gives a body the mass, the centre and the inertia that a file says, and what it says nothing
    /// of from its colliders, which weigh nothing from then on. False where the engine has not
    /// weighed the colliders yet.
    #[cfg(feature = "bevy_gltf")]
    fn set_declared_mass(
        body: &mut EntityWorldMut,
        declared: &BodyMotion,
        colliders: &[Entity],
    ) -> bool;
}

/// What a file says of a mass, and the engine of the rest.
#[cfg(feature = "bevy_gltf")]
#[derive(Debug, Clone, Copy)]
struct DeclaredMass {
    mass: f32,
    centre: Vec3,
    /// Around the principal axes. As a mass of 0, a moment of 0 is one without limit: engines keep
    /// inverses, and have 0 for both.
    inertia: Vec3,
    rotation: Quat,
}

#[cfg(feature = "bevy_gltf")]
impl DeclaredMass {
    /// `weighed` is of the colliders, whose inertia grows with the mass.
    fn new(declared: &BodyMotion, weighed: Self) -> Self {
        let mass = declared.mass.unwrap_or(weighed.mass);
        let factor = if mass > 0.0 { mass / weighed.mass } else { 1.0 };
        let (inertia, rotation) = match declared.inertia {
            Some(inertia) => (inertia.into(), Quat::from_array(declared.inertia_rotation)),
            None => (weighed.inertia * factor, weighed.rotation),
        };
        let centre = declared.centre.map_or(weighed.centre, Vec3::from);
        Self { mass, centre, inertia, rotation }
    }
}

/// Puts the plugin's systems before the steps of an engine, in each frame and in fixed steps.
fn run_before(app: &mut App, steps: impl SystemSet + Clone, fixed: InternedScheduleLabel) {
    app.configure_sets(
        PostUpdate,
        (HullwrightSystems::DetectChanges, HullwrightSystems::RunJobs, HullwrightSystems::Attach)
            .before(steps.clone()),
    );
    app.configure_sets(fixed, HullwrightSystems::DetectChanges.before(steps));
}
