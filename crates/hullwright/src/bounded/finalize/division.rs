//! Division: a piece whose hull does not keep the bound is halved until each part does, at last
//! down to triangles of the source. Those do, unless a hull has to be thicker than the bound. Each
//! halving costs a final hull.

use super::final_hull::{FinalHull, Owned, make_hull};
use super::hull_simplification::FinalizeContext;
use crate::bounded::patch::{Patch, PatchSet, Piece};
use crate::bounded::search::Search;
use crate::error::Error;
use crate::geometry::vector::{Vector, as_arrays, centre, halves};
use crate::hull::{HullBuilder, LEAST_THICKNESS, solid_hull};
use crate::solid::protrusion;

/// What has become of a piece.
pub(super) struct PieceHulls {
    /// Each keeps the bound, except single triangles whose hull has to be thicker.
    pub hulls: Vec<FinalHull>,
    /// Whether only the limit on vertices divides it.
    pub fits_without_limit: bool,
}

/// The hulls of a piece. `None` where there are so many that the search is given up.
pub(super) fn hulls_of_piece(
    context: &FinalizeContext<'_>,
    piece: &Piece,
) -> Result<Option<PieceHulls>, Error> {
    let owned = Owned { patches: piece.patches.clone(), part: None, inner_points: Vec::new() };
    let open = vec![Open { owned, may_fill: true }];
    let mut division = Division {
        context,
        builder: HullBuilder::new(),
        open,
        done: Vec::new(),
        fits_without_limit: false,
    };
    let is_whole = division.run()?;
    let Division { done, fits_without_limit, .. } = division;
    Ok(is_whole.then_some(PieceHulls { hulls: done, fits_without_limit }))
}

/// A part that is to become a hull.
struct Open {
    owned: Owned,
    /// Whether it may contain points inside; not once they have turned out to be in a cavity.
    may_fill: bool,
}

struct Division<'a> {
    context: &'a FinalizeContext<'a>,
    builder: HullBuilder,
    open: Vec<Open>,
    done: Vec<FinalHull>,
    fits_without_limit: bool,
}

impl Division<'_> {
    /// Divides until nothing is open. Whether it was not given up before.
    fn run(&mut self) -> Result<bool, Error> {
        let &Search { settings, control, .. } = &self.context.search;
        let mut is_first = true;
        while let Some(Open { owned, may_fill }) = self.open.pop() {
            control.check()?;
            let is_first = std::mem::take(&mut is_first);
            let contains_middle = !owned.inner_points.is_empty();
            let hull = make_hull(self.context, owned, &mut self.builder)?;
            if hull.keeps_bound(settings) {
                self.done.push(hull);
                continue;
            }
            if contains_middle && hull.protrusion > settings.bound.verified() {
                let owned = Owned { inner_points: Vec::new(), ..hull.owned };
                self.open.push(Open { owned, may_fill: false });
                continue;
            }
            let mut inner_points = hull.owned.inner_points.clone();
            if (may_fill || is_first) && inner_points.is_empty() {
                let middle = self.middle(&hull)?;
                self.fits_without_limit |= is_first && middle.is_some();
                // If all parts of the hull contain it, they fill the hull; parts of the surface
                // alone would leave it hollow.
                let is_filled = may_fill && self.context.search.exact_solid.is_closed();
                inner_points.extend(middle.filter(|_| is_filled));
            }
            self.divide(hull, may_fill, inner_points)?;
            if settings.gives_up(self.done.len() + self.open.len()) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Halves a hull's patches; of a single patch its triangles. The halves contain the inner
    /// points.
    fn divide(
        &mut self,
        mut hull: FinalHull,
        may_fill: bool,
        inner_points: Vec<Vector>,
    ) -> Result<(), Error> {
        let &Search { patches, exact_solid: solid, settings, control, .. } = &self.context.search;
        let mut push = |patches: PatchSet, part: Option<Vec<u32>>| {
            let inner_points = inner_points.clone();
            let owned = Owned { patches, part, inner_points };
            self.open.push(Open { owned, may_fill });
        };
        let set = &hull.owned.patches;
        let mut members: Vec<u32> = set.iter().collect();
        if members.len() > 1 {
            let box_centre = |&patch: &u32| {
                let Patch { min, max, .. } = patches[patch];
                (min + max) * 0.5
            };
            let (first, second) = halves(&mut members, box_centre);
            for half in [second, first] {
                push(PatchSet::new(patches.count(), half.iter().copied()), None);
            }
            return Ok(());
        }
        let mut triangles: Vec<u32> = hull.owned.triangles(patches).collect();
        if triangles.len() < 2 {
            // The patch mesh's triangle may protrude where the source's does not. A patch that
            // owns nothing of the source can be dropped.
            if hull.owned.part.is_some() {
                let bound = settings.bound.verified();
                hull.protrusion = protrusion(&hull.hull, solid, bound, f64::INFINITY, control)?;
                self.done.push(hull);
            } else if !triangles.is_empty() {
                push(set.clone(), Some(triangles));
            }
            return Ok(());
        }
        let surface = &patches.surface;
        let triangle_centre = |&triangle: &u32| {
            let corners = surface.triangles[triangle as usize];
            centre(corners.map(|vertex| surface.points()[vertex as usize]))
        };
        let (first, second) = halves(&mut triangles, triangle_centre);
        for half in [second, first] {
            push(set.clone(), Some(half.to_vec()));
        }
        Ok(())
    }

    /// The middle of a hull that would keep the bound without the limit on vertices; `None` of
    /// another one.
    fn middle(&mut self, hull: &FinalHull) -> Result<Option<Vector>, Error> {
        let &Search { patches, exact_solid: solid, settings, control, .. } = &self.context.search;
        let Some(max_vertices) = settings.max_vertices else { return Ok(None) };
        let points = hull.owned.surface_points(patches);
        if points.len() <= max_vertices {
            return Ok(None);
        }
        let (unlimited, _) =
            solid_hull(&mut self.builder, as_arrays(&points), [0.0; 3], LEAST_THICKNESS)?;
        let (count, bound) = (unlimited.points.len(), settings.bound.verified());
        if count <= max_vertices || protrusion(&unlimited, solid, bound, bound, control)? > bound {
            return Ok(None);
        }
        let sum = unlimited.points().iter().fold(Vector::ZERO, |sum, &point| sum + point);
        Ok(Some(sum * (1.0 / count as f64)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounded::fixture::{Fixture, cubes, l_prism, times_in, u_prism};
    use crate::mesh::shapes::{cuboid, uv_sphere};
    use crate::parameters::{Length, Parameters};

    fn context(fixture: &Fixture) -> FinalizeContext<'_> {
        FinalizeContext { search: fixture.search(), volume_per_vertex: 0.0 }
    }

    /// The hulls of a piece of all patches.
    fn divided(fixture: &Fixture) -> Option<PieceHulls> {
        let piece = fixture.piece(0..fixture.patches.count() as u32);
        hulls_of_piece(&context(fixture), &piece).unwrap()
    }

    #[test]
    fn a_piece_that_keeps_the_bound_is_not_divided() {
        let fixture = Fixture::new(&cuboid([0.0; 3], [1.0; 3]), 0.02);
        let PieceHulls { hulls, fits_without_limit } = divided(&fixture).unwrap();
        assert_eq!(hulls.len(), 1);
        assert!(!fits_without_limit);
    }

    #[test]
    fn a_piece_over_a_notch_is_divided_until_each_part_keeps_the_bound() {
        for mesh in [l_prism(), u_prism(), cubes([0.0, 1.5, 3.0])] {
            let fixture = Fixture::new(&mesh, 0.02);
            let PieceHulls { hulls, fits_without_limit } = divided(&fixture).unwrap();
            assert!(hulls.len() > 1 && !fits_without_limit);
            assert!(hulls.iter().all(|hull| hull.keeps_bound(&fixture.settings)));
            let count = fixture.patches.count();
            let sets = hulls.iter().map(|hull| &hull.owned.patches);
            assert_eq!(times_in(count, sets), vec![1; count]);
            assert!(fixture.owners(&hulls).iter().all(|&owners| owners == 1));
        }
    }

    #[test]
    fn a_single_patch_is_divided_into_its_triangles() {
        // A ball is one patch, which needs far more vertices than the limit allows.
        let parameters =
            Parameters::default().with_max_error(Length::share(0.01)).with_max_vertices(Some(12));
        let fixture = Fixture::with(&uv_sphere(12, [0.0; 3], 1.0), &parameters);
        assert_eq!(fixture.patches.count(), 1);
        let PieceHulls { hulls, fits_without_limit } = divided(&fixture).unwrap();
        assert!(hulls.len() > 1 && fits_without_limit);
        for hull in &hulls {
            assert!(hull.hull.points.len() <= 12 && hull.owned.part.is_some());
            // Its middle stays within all of them, so that no gap opens there.
            assert_eq!(hull.owned.inner_points.len(), 1);
        }
        assert!(fixture.owners(&hulls).iter().all(|&owners| owners == 1));
    }

    #[test]
    fn a_division_into_more_hulls_than_the_limit_is_given_up() {
        let parameters = Parameters::default().with_max_hulls(1);
        let mut fixture = Fixture::with(&l_prism(), &parameters);
        assert!(divided(&fixture).is_some());
        fixture.settings = fixture.settings.with_bound(0.02);
        assert!(divided(&fixture).is_none());
    }

    #[test]
    fn items_are_halved_along_the_axis_on_which_they_lie_farthest_apart() {
        let places = [[0.0, 5.0, 0.0], [1.0, 0.0, 1.0], [2.0, 9.0, 0.0], [0.0, 2.0, 3.0]];
        let mut items = [0, 1, 2, 3];
        let (first, second) = halves(&mut items, |&item| Vector::from(places[item as usize]));
        assert_eq!((first, second), (&[1, 3][..], &[0, 2][..]));
    }

    #[test]
    fn of_three_items_at_one_place_neither_half_is_empty() {
        let mut items = [4, 2, 3];
        let (first, second) = halves(&mut items, |_| Vector::ZERO);
        assert_eq!((first, second), (&[2][..], &[3, 4][..]));
    }
}
