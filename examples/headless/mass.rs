//! What the engine says of the mass of a body.

#[cfg(feature = "avian")]
mod engine {
    use avian3d::prelude::{ComputedCenterOfMass, ComputedMass};
    use bevy::prelude::*;

    /// What the engine says of a body.
    pub type MassOfBody = (&'static ComputedMass, &'static ComputedCenterOfMass);

    /// So that the engine says it.
    pub fn with_mass() -> impl Bundle {}

    /// Mass and centre of a body.
    pub fn mass((mass, centre): (&ComputedMass, &ComputedCenterOfMass)) -> (f32, Vec3) {
        (mass.value(), centre.0)
    }
}

#[cfg(not(feature = "avian"))]
mod engine {
    use bevy::prelude::*;
    use bevy_rapier3d::prelude::ReadMassProperties;

    /// What the engine says of a body.
    pub type MassOfBody = &'static ReadMassProperties;

    /// So that the engine says it.
    pub fn with_mass() -> impl Bundle {
        ReadMassProperties::default()
    }

    /// Mass and centre of a body.
    pub fn mass(properties: &ReadMassProperties) -> (f32, Vec3) {
        (properties.mass, properties.local_center_of_mass)
    }
}

pub use engine::*;
