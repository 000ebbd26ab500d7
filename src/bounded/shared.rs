//! The first stage: the solid, and beside it the mesh that is divided into patches.

use std::sync::Arc;

use super::patch_mesh::PatchMesh;
use super::settings::Settings;
use crate::clustering::Clustered;
use crate::control::Control;
use crate::error::Error;
use crate::mesh::PreparedMesh;
use crate::parallel;
use crate::solid::Solid;

/// What passes share.
pub(crate) struct Shared {
    /// Passes of another bound share its surface.
    pub(crate) solid: Arc<Solid>,
    /// The reduced mesh of a very dense source: of the first pass, which has the least bound.
    pub(super) clustered: Option<Arc<Clustered>>,
}

/// The solid, and beside it the mesh that is divided into patches. What an earlier pass has made is not made again.
///
/// # Errors
/// [`Error::Cancelled`], [`Error::Simplification`] where memory is short, and [`Error::InvalidParameter`] where a probe
/// can't start.
pub(crate) fn solid_and_patch_mesh(
    prepared: &PreparedMesh,
    earlier: Option<&Shared>,
    settings: &Settings,
    control: &Control,
) -> Result<(Shared, PatchMesh), Error> {
    let bound = settings.bound;
    let (solid, meshes) = parallel::join(
        || match earlier.map(|earlier| &earlier.solid) {
            Some(solid) if solid.bound == bound.verified() => Ok(Arc::clone(solid)),
            Some(solid) => solid.with_settings(prepared, &settings.solid(), control).map(Arc::new),
            None => Solid::new(prepared, &settings.solid(), control).map(Arc::new),
        },
        || {
            let clustered = match earlier {
                Some(earlier) => earlier.clustered.clone(),
                None => Clustered::new(prepared, bound.verified(), bound.longest_edge(), control)?
                    .map(Arc::new),
            };
            let patch_mesh = PatchMesh::new(prepared, clustered.as_deref(), settings, control)?;
            Ok::<_, Error>((clustered, patch_mesh))
        },
    );
    let (clustered, patch_mesh) = meshes?;
    Ok((Shared { solid: solid?, clustered }, patch_mesh))
}
