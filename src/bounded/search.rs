//! What the stages of a search share.

use std::sync::Arc;

use super::clustering::cluster;
use super::containment::solid::Solid;
use super::patches::patch::Patches;
use super::patches::patch_mesh::PatchMesh;
use super::settings::Settings;
use crate::control::Control;
use crate::error::Error;
use crate::mesh::PreparedMesh;
use crate::parallel;

/// The solid, the patches of its surface, and what they are searched under.
#[derive(Clone, Copy)]
pub(crate) struct Search<'a> {
    pub(crate) solid: &'a Solid,
    pub(crate) patches: &'a Patches,
    pub(crate) settings: &'a Settings,
    pub(crate) control: &'a Control,
}

/// The solid, unless an earlier pass has built it, and beside it the mesh that is divided into patches.
///
/// # Errors
/// [`Error::Cancelled`], and [`Error::Simplification`] where memory is short.
pub(crate) fn solid_and_patch_mesh(
    prepared: &PreparedMesh,
    solid: Option<Arc<Solid>>,
    settings: &Settings,
    control: &Control,
) -> Result<(Arc<Solid>, PatchMesh), Error> {
    let clustered = match &solid {
        Some(solid) => solid.clustered.clone(),
        None => cluster(prepared, settings, control)?,
    };
    let (solid, patch_mesh) = parallel::join(
        || match solid {
            Some(solid) => Ok(solid),
            None => Solid::new(prepared, clustered.clone(), settings, control).map(Arc::new),
        },
        || PatchMesh::new(prepared, clustered.as_deref(), settings, control),
    );
    Ok((solid?, patch_mesh?))
}
