//! Division: a piece whose hull does not keep the bound is halved until each part does, at last
//! down to triangles of the source, which always do.
//!
//! Takes a piece, gives verified hulls. Each halving costs a final hull.

use super::final_hull::{FinalHull, FinalizeContext, Represented};
use super::make_hull::make_hull;
use super::verify::protrusion::protrusion;
use crate::bounded::containment::triangle::centre;
use crate::bounded::patch::{Patch, PatchSet, Piece};
use crate::bounded::search::Search;
use crate::error::Error;
use crate::geometry::vector::{Vector, add, bounds, scale};
use crate::hull::{HullBuilder, LEAST_THICKNESS, solid_hull};

/// The hulls of a piece, each of which keeps the bound.
pub(super) fn hulls_of_piece(
    context: &FinalizeContext<'_>,
    piece: &Piece,
) -> Result<Vec<FinalHull>, Error> {
    let Piece { patches, inner_points, .. } = piece;
    let represents =
        Represented { patches: patches.clone(), part: None, inner_points: inner_points.clone() };
    let open = vec![Open { represents, may_fill: true }];
    let mut division = Division { context, builder: HullBuilder::new(), open, done: Vec::new() };
    division.run()?;
    Ok(division.done)
}

/// A part that is to become a hull.
struct Open {
    represents: Represented,
    /// Whether it may contain points inside; not once they have turned out to be in a cavity.
    may_fill: bool,
}

struct Division<'a> {
    context: &'a FinalizeContext<'a>,
    builder: HullBuilder,
    open: Vec<Open>,
    done: Vec<FinalHull>,
}

impl Division<'_> {
    fn run(&mut self) -> Result<(), Error> {
        let &Search { settings, control, .. } = &self.context.search;
        let mut is_first = true;
        while let Some(Open { represents, may_fill }) = self.open.pop() {
            control.check()?;
            let is_first = std::mem::take(&mut is_first);
            let points = represents.inner_points.len();
            let hull = make_hull(self.context, represents, &mut self.builder)?;
            if hull.keeps_bound(settings) {
                self.done.push(hull);
                continue;
            }
            // Points in a hollow are many. If its halves had to hold them too, they would break the cap on
            // vertices again, down to single triangles.
            let extends_over_hollow = points > 1;
            let protrudes = hull.protrusion > settings.bound.protrusion();
            if points > 0 && (extends_over_hollow || protrudes) {
                // A piece that extends over a hollow does without it first.
                let represents = Represented { inner_points: Vec::new(), ..hull.represents };
                self.open.push(Open { represents, may_fill: is_first });
                continue;
            }
            let mut inner_points = hull.represents.inner_points.clone();
            if may_fill && inner_points.is_empty() {
                inner_points.extend(self.middle(&hull)?);
            }
            self.divide(hull, may_fill, inner_points)?;
        }
        Ok(())
    }

    /// Halves a hull's patches; of a single patch its triangles. The halves contain the inner points.
    fn divide(
        &mut self,
        mut hull: FinalHull,
        may_fill: bool,
        inner_points: Vec<Vector>,
    ) -> Result<(), Error> {
        let &Search { patches, solid, settings, control } = &self.context.search;
        let mut push = |patches: PatchSet, part: Option<Vec<u32>>| {
            let inner_points = inner_points.clone();
            let represents = Represented { patches, part, inner_points };
            self.open.push(Open { represents, may_fill });
        };
        let set = &hull.represents.patches;
        let mut members: Vec<u32> = set.iter().collect();
        if members.len() > 1 {
            let box_centre = |&patch: &u32| {
                let Patch { min, max, .. } = patches[patch];
                scale(add(min, max), 0.5)
            };
            let (first, second) = halves(&mut members, box_centre);
            for half in [second, first] {
                push(PatchSet::new(patches.count(), half.iter().copied()), None);
            }
            return Ok(());
        }
        let mut triangles: Vec<u32> = hull.represents.triangles(patches).collect();
        if triangles.len() < 2 {
            // The patch mesh's triangle may protrude where the source's does not. A patch that
            // represents nothing of the source can be dropped.
            if hull.represents.part.is_some() {
                let bound = settings.bound.protrusion();
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
            centre(corners.map(|vertex| surface.positions[vertex as usize]))
        };
        let (first, second) = halves(&mut triangles, triangle_centre);
        for half in [second, first] {
            push(set.clone(), Some(half.to_vec()));
        }
        Ok(())
    }

    /// The middle of a hull that would keep the bound without the cap on vertices. If all parts of the
    /// hull contain it, they fill the hull; parts of the surface alone would leave it hollow.
    fn middle(&mut self, hull: &FinalHull) -> Result<Option<Vector>, Error> {
        let &Search { patches, solid, settings, control } = &self.context.search;
        let Some(max_vertices) = settings.max_vertices else { return Ok(None) };
        let points = hull.represents.surface_points(patches);
        if !solid.is_closed() || points.len() <= max_vertices {
            return Ok(None);
        }
        let (uncapped, _) = solid_hull(&mut self.builder, &points, [0.0; 3], LEAST_THICKNESS)?;
        let (count, bound) = (uncapped.points.len(), settings.bound.protrusion());
        if count <= max_vertices || protrusion(&uncapped, solid, bound, bound, control)? > bound {
            return Ok(None);
        }
        let sum = uncapped.points.iter().fold([0.0; 3], |sum, &point| add(sum, point));
        Ok(Some(scale(sum, 1.0 / count as f64)))
    }
}

/// Two halves along the axis of greatest extent.
fn halves(items: &mut [u32], centre: impl Fn(&u32) -> Vector) -> (&[u32], &[u32]) {
    let (min, max) = bounds(items.iter().map(&centre));
    let extent = |axis: &usize| max[*axis] - min[*axis];
    let axis = (0..3).max_by(|a, b| extent(a).total_cmp(&extent(b))).unwrap_or(0);
    items.sort_by(|a, b| centre(a)[axis].total_cmp(&centre(b)[axis]).then(a.cmp(b)));
    items.split_at(items.len() / 2)
}
