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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounded::fixture::Fixture;
    use crate::mesh::refine::refine;
    use crate::mesh::shapes::{cuboid, torus, uv_sphere};
    use crate::parameters::{Length, Parameters};

    #[test]
    fn a_box_has_twelve_triangles_however_finely_it_is_cut() {
        let mut mesh = cuboid([0.0; 3], [1.0; 3]);
        refine(&mut mesh, 0.1);
        assert!(mesh.triangles.len() > 1000);
        let Fixture { surfaces, .. } = Fixture::new(&mesh, 0.02);
        assert_eq!(surfaces.exact.mesh.triangles.len(), 12);
        assert!(surfaces.are_one());
        assert_eq!(
            (0..12).map(|t| surfaces.coarse_of(t)).collect::<Vec<u32>>(),
            Vec::from_iter(0..12)
        );
    }

    #[test]
    fn surfaces_and_solids_without_detail_are_made_once() {
        let Fixture { surfaces, solids, .. } = Fixture::new(&cuboid([0.0; 3], [1.0; 3]), 0.02);
        assert!(Arc::ptr_eq(&surfaces.exact, &surfaces.coarse));
        assert!(Arc::ptr_eq(&solids.exact, &solids.coarse));
    }

    #[test]
    fn the_coarse_surface_has_moved_by_no_more_than_its_fraction_of_the_bound() {
        for mesh in [uv_sphere(40, [0.0; 3], 1.0), torus(60, 30)] {
            let Fixture { surfaces, settings, .. } = Fixture::new(&mesh, 0.02);
            let Surfaces { exact, coarse, .. } = &surfaces;
            assert!(exact.most_moved() <= settings.bound.exact());
            assert!(coarse.most_moved() <= settings.bound.coarse());
            assert!(!surfaces.are_one());
            assert!(coarse.mesh.triangles.len() < exact.mesh.triangles.len());
            let last = (0..exact.mesh.triangles.len() as u32).map(|t| surfaces.coarse_of(t)).max();
            assert!(last.unwrap() < coarse.mesh.triangles.len() as u32);
        }
    }

    #[test]
    fn a_pass_under_the_same_bound_takes_surfaces_and_solids_as_they_are() {
        let fixture = Fixture::new(&uv_sphere(40, [0.0; 3], 1.0), 0.02);
        let Fixture { prepared, surfaces, solids: first, settings, control, .. } = &fixture;
        let again = simplify(prepared, Some(surfaces), settings, control).unwrap();
        assert!(Arc::ptr_eq(&again.coarse, &surfaces.coarse));
        let second = solids(&again, Some(first), settings, control).unwrap();
        assert!(Arc::ptr_eq(&second.exact, &first.exact));
        assert!(Arc::ptr_eq(&second.coarse, &first.coarse));
    }

    #[test]
    fn a_pass_under_a_larger_bound_keeps_the_exact_surface_and_has_a_coarser_one() {
        let fixture = Fixture::new(&uv_sphere(40, [0.0; 3], 1.0), 0.02);
        let Fixture { prepared, surfaces, solids: first, settings, control, .. } = &fixture;
        let settings = &settings.with_bound(0.05);
        let other = simplify(prepared, Some(surfaces), settings, control).unwrap();
        assert!(Arc::ptr_eq(&other.exact, &surfaces.exact));
        assert!(other.coarse.mesh.triangles.len() < surfaces.coarse.mesh.triangles.len());
        let second = solids(&other, Some(first), settings, control).unwrap();
        assert_eq!([second.exact.bound, second.coarse.bound], [0.05; 2]);
    }

    #[test]
    fn the_probe_in_the_search_is_smaller_by_what_the_surface_has_moved() {
        let mesh = torus(60, 30);
        let with_probe = |radius| {
            let parameters = Parameters::default().with_max_error(Length::share(0.05));
            Fixture::with(&mesh, &parameters.with_probe_radius(Length::share(radius)))
        };
        let Fixture { surfaces, solids, .. } = with_probe(0.1);
        let radius = |solid: &Solid| solid.probe.as_ref().map(|probe| probe.radius);
        let moved = surfaces.coarse.most_moved();
        assert!(moved > 0.0);
        assert_eq!(radius(&solids.exact), Some(0.1));
        assert_eq!(radius(&solids.coarse), Some(0.1 - moved));
        // What is left of a smaller one would be less than what the surface has moved by.
        let small = 1.9 * moved;
        let Fixture { solids, .. } = with_probe(small);
        assert_eq!(radius(&solids.exact), Some(small));
        assert_eq!(radius(&solids.coarse), None);
    }
}
