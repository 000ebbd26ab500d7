//! The physics engine of the examples that run with both: Avian where its feature is on, else
//! Rapier.

#[cfg(feature = "avian")]
mod engine {
    pub use avian3d::prelude::RigidBody;
    use avian3d::prelude::{Collider, PhysicsPlugins};
    use bevy::prelude::*;
    use bevy_hullwright::prelude::*;

    /// Steps with every frame.
    pub fn plugins(app: &mut App) {
        app.add_plugins(PhysicsPlugins::new(PostUpdate));
        app.add_plugins(HullwrightPlugin::default().with_engine(PhysicsEngine::Avian));
    }

    /// A box that never moves, by half of its sides.
    pub fn fixed_box(middle: Vec3, half: Vec3) -> impl Bundle {
        let [x, y, z] = (2.0 * half).to_array();
        (Transform::from_translation(middle), RigidBody::Static, Collider::cuboid(x, y, z))
    }
}

#[cfg(not(feature = "avian"))]
mod engine {
    use bevy::prelude::*;
    use bevy_hullwright::prelude::*;
    pub use bevy_rapier3d::prelude::RigidBody;
    use bevy_rapier3d::prelude::{Collider, NoUserData, RapierPhysicsPlugin};

    /// Steps with every frame.
    pub fn plugins(app: &mut App) {
        app.add_plugins(RapierPhysicsPlugin::<NoUserData>::default());
        app.add_plugins(HullwrightPlugin::default());
    }

    /// A box that never moves, by half of its sides.
    pub fn fixed_box(middle: Vec3, half: Vec3) -> impl Bundle {
        (Transform::from_translation(middle), Collider::cuboid(half.x, half.y, half.z))
    }
}

pub use engine::*;
