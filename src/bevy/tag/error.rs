//! Why an entity gets no collider.

use bevy::prelude::*;

use crate::Error;
use crate::rapier::ColliderError;

/// Why there is no collider.
#[non_exhaustive]
#[derive(Reflect, Debug, Clone, PartialEq, thiserror::Error)]
#[reflect(opaque)]
#[reflect(Debug, Clone, PartialEq)]
#[type_path = "hullwright"]
pub enum DecompositionError {
    /// The asset server could not load the mesh or the baked hulls.
    #[error("the asset could not be loaded")]
    NotLoaded,
    /// The mesh's data is gone: it was uploaded and not kept.
    #[error(
        "the mesh is on the GPU only; load it with RenderAssetUsages::default(), which keeps \
         MAIN_WORLD"
    )]
    RenderWorldOnly,
    /// The mesh has no positions, or not as three `f32`.
    #[error("the mesh has no positions of three f32")]
    NoPositions,
    /// The mesh is made of points or lines.
    #[error("the mesh consists of {0} instead of triangles")]
    NotTriangles(&'static str),
    /// The mesh could not be decomposed or weighed.
    #[error("{0}")]
    Mesh(Error),
    /// Its hulls could not be made a collider.
    #[error("{0}")]
    Collider(ColliderError),
    /// The background task panicked. The panic is contained to that task.
    #[error("the background task panicked")]
    Panicked,
}

impl From<ColliderError> for DecompositionError {
    fn from(error: ColliderError) -> Self {
        match error {
            ColliderError::Mesh(error) => Self::Mesh(error),
            error => Self::Collider(error),
        }
    }
}

impl From<Error> for DecompositionError {
    fn from(error: Error) -> Self {
        Self::Mesh(error)
    }
}
