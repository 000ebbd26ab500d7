//! What the stages of a search share.

use std::sync::Arc;

use super::patch::Patches;
use super::patch_mesh::PatchMesh;
use super::settings::Settings;
use crate::clustering::{Clustered, cluster};
use crate::control::Control;
use crate::error::Error;
use crate::mesh::PreparedMesh;
use crate::parallel;
use crate::solid::{Solid, SolidSettings};

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
        None => clustered(prepared, settings, control)?,
    };
    let (solid, patch_mesh) = parallel::join(
        || match solid {
            Some(solid) => Ok(solid),
            None => solid_of(prepared, clustered.clone(), settings, control).map(Arc::new),
        },
        || PatchMesh::new(prepared, clustered.as_deref(), settings, control),
    );
    Ok((solid?, patch_mesh?))
}

/// The reduced mesh of a prepared one that needs it. Where cavities are kept there is none: a
/// narrow cavity could close.
fn clustered(
    prepared: &PreparedMesh,
    settings: &Settings,
    control: &Control,
) -> Result<Option<Arc<Clustered>>, Error> {
    let Settings { bound, keep_cavities, .. } = settings;
    match keep_cavities {
        true => Ok(None),
        false => cluster(prepared, bound.verified(), bound.longest_edge(), control),
    }
}

/// The solid of a prepared mesh alone.
///
/// # Errors
/// [`Error::Cancelled`].
pub(crate) fn solid(
    prepared: &PreparedMesh,
    settings: &Settings,
    control: &Control,
) -> Result<Solid, Error> {
    solid_of(prepared, clustered(prepared, settings, control)?, settings, control)
}

fn solid_of(
    prepared: &PreparedMesh,
    clustered: Option<Arc<Clustered>>,
    settings: &Settings,
    control: &Control,
) -> Result<Solid, Error> {
    let &Settings { bound, keep_cavities, ref probe, .. } = settings;
    let settings = SolidSettings { bound: bound.verified(), keep_cavities, probe: probe.as_ref() };
    Solid::new(prepared, clustered, &settings, control)
}
