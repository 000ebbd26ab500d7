//! What users put on entities: the tag, what keeps an entity out, and where to begin.

use bevy::prelude::*;

use crate::{BoundedParameters, Parameters, Preset};

use super::DecompositionStatus;

/// Gives the entity a collider of convex hulls, made in the background from the meshes on it and
/// below it, all as one input.
///
/// It may come before the mesh is loaded, before `Mesh3d` exists, or sit on a parent whose
/// children hold the meshes, as the nodes of a glTF scene do. Below it, what has a tag or a
/// [`RigidBody`](bevy_rapier3d::prelude::RigidBody) of its own or [`NoConvexDecomposition`] is
/// left out, with all its children.
///
/// An entity that has a `Collider` already is skipped. The tag may be removed once the collider is
/// there; the collider stays.
#[derive(Component, Reflect, Debug, Clone, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(DecompositionStatus)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
pub struct ConvexDecomposition {
    /// What the decomposition is asked to do. `Unit::Diagonals` is in diagonals of the mesh before
    /// the entity's scale, `Unit::Absolute` in units of the world.
    pub parameters: Parameters,
    /// Mass per cubed unit of the world; positive.
    pub density: f32,
    /// What stands in for the collider until it is ready; `None` for what
    /// [`HullwrightSettings`](super::HullwrightSettings) says.
    pub meanwhile: Option<Meanwhile>,
}

/// bevy_rapier's own default, so that a body with our collider beside one of Rapier's shapes
/// weighs as expected.
pub const DEFAULT_DENSITY: f32 = 1.0;

impl Default for ConvexDecomposition {
    fn default() -> Self {
        Self { parameters: Parameters::default(), density: DEFAULT_DENSITY, meanwhile: None }
    }
}

impl ConvexDecomposition {
    /// With the parameters given.
    pub fn new(parameters: Parameters) -> Self {
        Self { parameters, ..Self::default() }
    }

    /// The same with a density.
    #[must_use]
    pub fn with_density(mut self, density: f32) -> Self {
        self.density = density;
        self
    }

    /// The same with something in its place until it is ready.
    #[must_use]
    pub fn with_meanwhile(mut self, meanwhile: Meanwhile) -> Self {
        self.meanwhile = Some(meanwhile);
        self
    }
}

impl From<Preset> for ConvexDecomposition {
    fn from(preset: Preset) -> Self {
        let bounded = BoundedParameters { preset, ..BoundedParameters::default() };
        Self::new(Parameters { bounded, ..Parameters::default() })
    }
}

/// What stands in for a collider until it is ready.
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[reflect(Default, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Meanwhile {
    /// Nothing.
    #[default]
    Nothing,
    /// The convex hull of the mesh, made in the background too, but soon.
    ConvexHull,
    /// The box along the mesh's axes.
    BoundingBox,
}

/// Keeps the entity and all below it out of every decomposition.
#[derive(Component, Reflect, Debug, Clone, Copy, PartialEq, Eq, Default)]
#[reflect(Component, Default, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct NoConvexDecomposition;

/// Where the player is: when more wait than run, those nearest to such an entity go first.
#[derive(Component, Reflect, Debug, Clone, Copy, PartialEq, Eq, Default)]
#[reflect(Component, Default, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DecompositionFocus;

#[cfg(all(test, feature = "serde", feature = "io"))]
mod tests {
    use super::*;
    use crate::Unit;

    #[test]
    fn a_tag_is_written_and_read() {
        let mut tag = ConvexDecomposition::from(Preset::Fine).with_density(3.0);
        tag.parameters.bounded.max_error = Unit::Absolute(0.02);
        tag.parameters.bounded.max_hulls = Some(7);
        let text = serde_json::to_string(&tag).unwrap();
        assert_eq!(serde_json::from_str::<ConvexDecomposition>(&text).unwrap(), tag);
    }

    #[test]
    fn tags_without_fields_are_written_and_read() {
        let text = serde_json::to_string(&NoConvexDecomposition).unwrap();
        assert!(serde_json::from_str::<NoConvexDecomposition>(&text).is_ok());
        let text = serde_json::to_string(&DecompositionFocus).unwrap();
        assert!(serde_json::from_str::<DecompositionFocus>(&text).is_ok());
    }

    #[test]
    fn what_is_left_out_has_its_default() {
        let tag: ConvexDecomposition = serde_json::from_str(r#"{"density": 2.0}"#).unwrap();
        assert_eq!(tag, ConvexDecomposition::default().with_density(2.0));
    }
}
