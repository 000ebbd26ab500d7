//! Requests of entities, and the components that record what became of them.

use std::sync::Arc;

use bevy::asset::AssetId;
use bevy::math::Affine3A;
use bevy::prelude::*;
use bevy_rapier3d::prelude::RigidBody;

use crate::bevy::collider::placement::{MapKey, Stretch};
use crate::bevy::jobs::baked::{BakedDecomposition, BakedHulls};
use crate::bevy::jobs::baked_scene::BakedScene;
use crate::bevy::jobs::mesh_data::MeshPart;
use crate::bevy::tag::components::{ConvexDecomposition, NoConvexDecomposition};
use crate::bevy::tag::error::DecompositionError;
use crate::bevy::tag::parameters::{Goal, has_absolute_length};
use crate::bevy::tag::status::SkipReason;

/// Names what a collider is made from without looking into it.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) enum InputId {
    Meshes {
        parts: Vec<(AssetId<Mesh>, MapKey)>,
        /// Hash of what to make of them.
        goal: [u8; 32],
        /// Applied before the work.
        map_before: MapKey,
    },
    Baked(AssetId<BakedHulls>),
}

impl InputId {
    pub(crate) fn uses_mesh(&self, id: AssetId<Mesh>) -> bool {
        match self {
            Self::Meshes { parts, .. } => parts.iter().any(|(mesh, _)| *mesh == id),
            Self::Baked(_) => false,
        }
    }
}

/// What has any of these is left out of the input above it, with all below it.
pub(crate) type InputBoundary = Or<(
    With<ConvexDecomposition>,
    With<BakedDecomposition>,
    With<RigidBody>,
    With<NoConvexDecomposition>,
)>;

/// The collider that an entity requests.
#[derive(Debug)]
pub(crate) struct ColliderRequest {
    pub input: Arc<InputId>,
    pub parts: Vec<MeshPart>,
    /// `None` for baked hulls.
    pub goal: Option<Goal>,
    /// Where its hulls may be found.
    pub scene: Option<AssetId<BakedScene>>,
    /// Baked into the mesh before the work.
    pub map_before: Affine3A,
    /// Baked into the result.
    pub map: Affine3A,
    pub stretch: Stretch,
}

impl ColliderRequest {
    /// Why it is for triangles instead of hulls.
    pub(crate) fn why_triangles(&self) -> Option<SkipReason> {
        self.goal.as_ref()?.why_triangles()
    }

    pub(crate) fn map_key(&self) -> MapKey {
        MapKey::new(&self.map)
    }
}

/// On entities with a collider of the plugin's: what it was made from.
#[derive(Component, Debug, Clone)]
pub(crate) struct AttachedCollider {
    pub input: Arc<InputId>,
    pub stretch: Stretch,
    /// From the entity's space to the collider's.
    #[cfg_attr(
        not(feature = "debug"),
        expect(dead_code, reason = "drawn with the feature `debug`")
    )]
    pub map: Affine3A,
    /// Why it is a triangle mesh instead of hulls.
    pub why_triangles: Option<SkipReason>,
    /// Whether the plugin set the mass properties, or found them set.
    pub owns_mass: bool,
}

/// On entities that have their fallback collider.
#[derive(Component, Debug, Clone, Copy)]
pub(crate) struct AttachedFallback {
    /// Whether the plugin set the mass properties, or found them set.
    pub owns_mass: bool,
}

/// On entities that failed: their request, to detect when another attempt may succeed.
#[derive(Component, Debug, Clone)]
pub(crate) struct FailedRequest {
    pub request: Arc<ColliderRequest>,
    pub error: DecompositionError,
}

impl FailedRequest {
    /// Whether it may succeed when an asset is there.
    pub(crate) fn lacks_asset(&self) -> bool {
        self.error == DecompositionError::NotLoaded
    }

    /// Whether it may succeed at another scale. A mesh that is bad in itself stays so.
    pub(crate) fn depends_on_scale(&self) -> bool {
        let is_of_shape = matches!(self.error, DecompositionError::Collider(_));
        let parameters = self.request.goal.as_ref().and_then(Goal::parameters);
        is_of_shape || parameters.is_some_and(has_absolute_length)
    }
}
