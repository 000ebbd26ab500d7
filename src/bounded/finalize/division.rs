//! Division: a piece whose hull does not keep the bound is halved until each part does, at last
//! down to triangles of the source, which always do.

use super::context::FinalizeContext;
use super::final_hull::FinalHull;
use super::make_hull::{make_hull, surface_points};
use super::verify::protrusion::protrusion;
use crate::bounded::containment::triangle::centre;
use crate::bounded::patch_set::PatchSet;
use crate::bounded::patches::patch::Patch;
use crate::bounded::piece::Piece;
use crate::error::Error;
use crate::geometry::vector::{Vector, add, bounds, scale};
use crate::hull::{HullBuilder, LEAST_THICKNESS, solid_hull};

/// A part that is still to be made a hull.
struct Open {
    set: PatchSet,
    /// Triangles, where it is only a part of its patches.
    part: Option<Vec<u32>>,
    /// Points inside that parts contain too; `None` once they have turned out to be in a cavity.
    inner_points: Option<Vec<Vector>>,
}

/// The hulls of a piece, each of which keeps the bound.
///
/// # Errors
/// [`Error::Cancelled`].
pub(super) fn hulls_of_piece(
    context: &FinalizeContext<'_>,
    piece: &Piece,
) -> Result<Vec<FinalHull>, Error> {
    let mut done = Vec::new();
    let set = piece.patches.clone();
    let inner_points = Some(piece.inner_points.clone());
    let mut open = vec![Open { set, part: None, inner_points }];
    let mut builder = HullBuilder::new();
    let mut is_first = true;
    while let Some(Open { set, part, inner_points }) = open.pop() {
        context.control.check()?;
        let is_first = std::mem::take(&mut is_first);
        let may_fill = inner_points.is_some();
        let inner_points = inner_points.unwrap_or_default();
        let is_filling = !inner_points.is_empty();
        // Points in a hollow are many. If its halves had to hold them too, they would break the cap on
        // vertices again, down to single triangles.
        let extends_over_hollow = inner_points.len() > 1;
        let hull = make_hull(context, set, part, inner_points, &mut builder)?;
        if hull.keeps_bound(context.settings) {
            done.push(hull);
            continue;
        }
        if is_filling
            && (extends_over_hollow || hull.protrusion > context.settings.bound.protrusion())
        {
            // A piece that extends over a hollow does without it first.
            let inner_points = is_first.then(Vec::new);
            open.push(Open { set: hull.patches, part: hull.part, inner_points });
            continue;
        }
        let mut inner_points = may_fill.then(|| hull.inner_points.clone());
        if let Some(inner_points) = &mut inner_points
            && inner_points.is_empty()
        {
            inner_points.extend(middle(context, &hull, &mut builder)?);
        }
        divide(context, hull, inner_points, &mut open, &mut done)?;
    }
    Ok(done)
}

/// Halves a hull's patches; of a single patch its triangles.
///
/// # Errors
/// [`Error::Cancelled`].
fn divide(
    context: &FinalizeContext<'_>,
    mut hull: FinalHull,
    inner_points: Option<Vec<Vector>>,
    open: &mut Vec<Open>,
    done: &mut Vec<FinalHull>,
) -> Result<(), Error> {
    let &FinalizeContext { patches, solid, settings, control, .. } = context;
    let mut members: Vec<u32> = hull.patches.iter().collect();
    if members.len() > 1 {
        let box_centre = |&patch: &u32| {
            let Patch { min, max, .. } = patches[patch];
            scale(add(min, max), 0.5)
        };
        let (first, second) = halves(&mut members, box_centre);
        for half in [second, first] {
            let set = PatchSet::of(patches.count(), half.iter().copied());
            open.push(Open { set, part: None, inner_points: inner_points.clone() });
        }
        return Ok(());
    }
    let mut triangles: Vec<u32> = hull.triangles(patches).collect();
    if triangles.len() < 2 {
        // The patch mesh's triangle may protrude where the source's does not. A patch that
        // represents nothing of the source can be dropped.
        if hull.part.is_some() {
            hull.protrusion =
                protrusion(&hull.hull, solid, settings.bound.protrusion(), f64::INFINITY, control)?;
            done.push(hull);
        } else if !triangles.is_empty() {
            open.push(Open { set: hull.patches, part: Some(triangles), inner_points });
        }
        return Ok(());
    }
    let surface = &patches.surface;
    let centre_of = |&triangle: &u32| {
        let corners = surface.triangles[triangle as usize];
        centre(corners.map(|vertex| surface.positions[vertex as usize]))
    };
    let (first, second) = halves(&mut triangles, centre_of);
    for half in [second, first] {
        let part = Some(half.to_vec());
        open.push(Open { set: hull.patches.clone(), part, inner_points: inner_points.clone() });
    }
    Ok(())
}

/// The middle of a hull that would keep the bound without the cap on vertices. If all parts of the
/// hull contain it, they fill the hull; parts of the surface alone would leave it hollow.
fn middle(
    context: &FinalizeContext<'_>,
    hull: &FinalHull,
    builder: &mut HullBuilder,
) -> Result<Option<Vector>, Error> {
    let &FinalizeContext { patches, solid, settings, control, .. } = context;
    let Some(max_vertices) = settings.max_vertices else { return Ok(None) };
    let points = surface_points(patches, &hull.patches, hull.part.as_deref());
    if !solid.is_closed() || points.len() <= max_vertices {
        return Ok(None);
    }
    let (uncapped, _) = solid_hull(builder, &points, [0.0; 3], LEAST_THICKNESS)?;
    let (count, bound) = (uncapped.points.len(), settings.bound.protrusion());
    if count <= max_vertices || protrusion(&uncapped, solid, bound, bound, control)? > bound {
        return Ok(None);
    }
    let sum = uncapped.points.iter().fold([0.0; 3], |sum, &point| add(sum, point));
    Ok(Some(scale(sum, 1.0 / count as f64)))
}

/// Two halves along the axis of greatest extent.
fn halves(items: &mut [u32], centre: impl Fn(&u32) -> Vector) -> (&[u32], &[u32]) {
    let (min, max) = bounds(items.iter().map(&centre));
    let extent = |axis: &usize| max[*axis] - min[*axis];
    let axis = (0..3).max_by(|a, b| extent(a).total_cmp(&extent(b))).unwrap_or(0);
    items.sort_by(|a, b| centre(a)[axis].total_cmp(&centre(b)[axis]).then(a.cmp(b)));
    items.split_at(items.len() / 2)
}
