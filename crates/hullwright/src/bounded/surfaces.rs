//! The surfaces that a search works with, and their solids: the exact one, which all results are
//! verified against, and the coarse one, which the search sees.

use std::sync::Arc;

use super::settings::Settings;
use crate::control::Control;
use crate::error::Error;
use crate::mesh::PreparedMesh;
use crate::mesh::simplification::Simplification;
use crate::parallel;
use crate::probe::ProbeSettings;
use crate::solid::{Solid, SolidSettings};

/// The exact surface and the coarse one.
#[derive(Clone)]
pub(crate) struct Surfaces {
    /// Stands for the repaired mesh.
    pub exact: Arc<Simplification>,
    /// Stands for the exact surface.
    pub coarse: Arc<Simplification>,
    /// The bound below which detail is gone.
    bound: f64,
}

impl Surfaces {
    /// Whether there is no detail: one surface serves as both.
    pub(super) fn are_one(&self) -> bool {
        Arc::ptr_eq(&self.exact, &self.coarse)
    }

    /// The coarse triangle that stands for an exact one.
    pub(super) fn coarse_of(&self, exact: u32) -> u32 {
        if self.are_one() { exact } else { self.coarse.owners[exact as usize] }
    }
}

/// Merges what lies in planes, and removes the detail below the bound. A pass of the same bound has
/// the same surfaces, one of another bound another coarse one.
///
/// # Errors
/// [`Error::Cancelled`].
pub(crate) fn simplify(
    prepared: &PreparedMesh,
    earlier: Option<&Surfaces>,
    settings: &Settings,
    control: &Control,
) -> Result<Surfaces, Error> {
    let exact = match earlier {
        Some(earlier) if earlier.bound == settings.bound.verified() => return Ok(earlier.clone()),
        Some(earlier) => Arc::clone(&earlier.exact),
        None => Arc::new(Simplification::exact(prepared, settings.bound.exact(), control)?),
    };
    let bound = settings.for_surface(exact.mesh.triangles.len()).bound;
    let coarse = exact.coarser(bound.coarse(), control)?;
    let is_same = coarse.is_unchanged();
    let coarse = if is_same { Arc::clone(&exact) } else { Arc::new(coarse) };
    Ok(Surfaces { exact, coarse, bound: bound.verified() })
}

/// The solids of the two surfaces; where these are the same, the same.
#[derive(Clone)]
pub(crate) struct Solids {
    pub exact: Arc<Solid>,
    pub coarse: Arc<Solid>,
}

/// Makes the solids. What an earlier pass has made is not made again.
///
/// # Errors
/// [`Error::Cancelled`], and [`Error::InvalidParameter`] where a probe can't start.
pub(crate) fn solids(
    surfaces: &Surfaces,
    earlier: Option<&Solids>,
    settings: &Settings,
    control: &Control,
) -> Result<Solids, Error> {
    let wanted = settings.solid();
    if let Some(earlier) = earlier.filter(|earlier| earlier.exact.bound == wanted.bound) {
        return Ok(earlier.clone());
    }
    let make_exact = || match earlier.map(|earlier| &earlier.exact) {
        Some(solid) => solid.with_settings(&surfaces.exact, &wanted, control).map(Arc::new),
        None => Solid::new(&surfaces.exact, &wanted, control).map(Arc::new),
    };
    if surfaces.are_one() {
        let exact = make_exact()?;
        return Ok(Solids { coarse: Arc::clone(&exact), exact });
    }
    // A ball that passes the source passes the coarse surface if it is smaller by what that has
    // moved. One that is no larger than that itself decides nothing, since what it can't reach is
    // within the bound of the surface, and tiny ones take seconds.
    let moved = surfaces.coarse.most_moved();
    let smaller =
        |probe: &ProbeSettings| ProbeSettings { radius: probe.radius - moved, ..probe.clone() };
    let probe = wanted.probe.map(smaller).filter(|probe| probe.radius > moved);
    let (exact, coarse) = parallel::join(make_exact, || {
        let wanted = SolidSettings { probe: probe.as_ref(), keep_cavities: false, ..wanted };
        Solid::new(&surfaces.coarse, &wanted, control)
    });
    let (exact, mut coarse) = (exact?, coarse?);
    coarse.cavities.clone_from(&exact.cavities);
    Ok(Solids { exact, coarse: Arc::new(coarse) })
}
