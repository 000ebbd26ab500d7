//! The final hull of some patches, or of a part of one: with thickness, few vertices, and verified.

use std::ops::Range;

use super::context::FinalizeContext;
use super::final_hull::FinalHull;
use super::hull_simplification::{Original, Simplified, simplify_hull};
use super::verify::point_groups::{PointGroups, distance_outside};
use crate::bounded::growing_hull::GrowingHull;
use crate::bounded::patch_set::PatchSet;
use crate::bounded::patches::patch::Patches;
use crate::bounded::piece::Piece;
use crate::bounded::settings::MAX_UNCOVERED;
use crate::error::Error;
use crate::geometry::vector::{Vector, add, area_normal};
use crate::hull::{ConvexHull, HullBuilder, LEAST_THICKNESS, solid_hull};

/// Numbers of points for which building their hull pays before computing how far they are outside
/// another one. For fewer the distances are as fast; of more, the hull has thousands of vertices.
const WORTH_A_HULL: Range<usize> = 64..8192;

/// The hull of very many points is built of those that protrude by more than this share of what may
/// be left uncovered: of all it would have thousands of vertices that do not matter.
const TOLERANCE_OF_MANY: f64 = 0.25;

/// The hull of patches, or of triangles that are a part of them, as far as it can keep the bound;
/// [`FinalHull::keeps_bound`] tells.
///
/// # Errors
/// [`Error::Cancelled`].
pub(super) fn make_hull(
    context: &FinalizeContext<'_>,
    set: PatchSet,
    part: Option<Vec<u32>>,
    inner_points: Vec<Vector>,
    builder: &mut HullBuilder,
) -> Result<FinalHull, Error> {
    let patches = context.patches;
    let mut hull = match &part {
        None => Piece::new(patches, &set).hull,
        Some(triangles) => hull_of_triangles(patches, triangles),
    };
    hull.insert(&inner_points, [0.0; 3]);
    let mut required = surface_points(patches, &set, part.as_deref());
    required.extend_from_slice(&inner_points);
    let required = extreme_points(builder, required);
    let (original, added_thickness) = full_hull(context, &mut hull, required, builder)?;
    let component = set.iter().next().map_or(0, |patch| patches[patch].component);
    let Simplified { hull, growth, protrusion, uncovered } =
        simplify_hull(context, original, builder)?;
    Ok(FinalHull {
        hull,
        patches: set,
        part,
        inner_points,
        added_thickness,
        simplification_growth: growth,
        protrusion,
        uncovered,
        component,
    })
}

fn hull_of_triangles(Patches { surface, .. }: &Patches, triangles: &[u32]) -> GrowingHull {
    let corners = |&triangle: &u32| {
        surface.triangles[triangle as usize].map(|vertex| surface.positions[vertex as usize])
    };
    let points: Vec<Vector> = triangles.iter().flat_map(corners).collect();
    let normals = triangles.iter().map(corners).map(|[a, b, c]| area_normal(a, b, c));
    GrowingHull::new(&points, normals.fold([0.0; 3], add))
}

/// The hull with all vertices that are needed to cover the `required` points, and the thickness
/// that it was given.
fn full_hull(
    context: &FinalizeContext<'_>,
    hull: &mut GrowingHull,
    required: Vec<Vector>,
    builder: &mut HullBuilder,
) -> Result<(Original, f64), Error> {
    let max_uncovered = MAX_UNCOVERED * context.settings.bound.uncovered();
    let outward = hull.outward;
    let points = PointGroups::new(&required);
    let thick = |builder: &mut HullBuilder, of: &[Vector]| -> Result<(ConvexHull, f64), Error> {
        context.control.check()?;
        solid_hull(builder, of, outward, LEAST_THICKNESS)
    };
    let (mut full, mut added_thickness) = thick(builder, &hull.vertices())?;
    let mut uncovered = distance_outside(&full, &points, max_uncovered, context.control)?;
    if uncovered > max_uncovered && required.len() > WORTH_A_HULL.end {
        let mut reducer =
            HullBuilder::new().with_least_tolerance(TOLERANCE_OF_MANY * max_uncovered);
        if let Some(reduced) = reducer.vertices_of(&required) {
            (full, added_thickness) = thick(builder, &reduced)?;
            uncovered = distance_outside(&full, &points, max_uncovered, context.control)?;
        }
    }
    if uncovered > max_uncovered {
        // Beyond a sharp edge, a point that is hardly in front of any face can be far away.
        (full, added_thickness) = thick(builder, &required)?;
        uncovered = distance_outside(&full, &points, f64::INFINITY, context.control)?;
    }
    Ok((Original { hull: full, uncovered, points, outward }, added_thickness))
}

/// The vertices of the surface that a hull of patches, or of a part of them, must contain.
pub(super) fn surface_points(
    patches: &Patches,
    set: &PatchSet,
    part: Option<&[u32]>,
) -> Vec<Vector> {
    if let Some(triangles) = part {
        return patches.surface.positions_of(triangles.iter().copied());
    }
    if set.iter().any(|patch| !patches[patch].surface_points.is_empty()) {
        return set.iter().flat_map(|patch| &patches[patch].surface_points).copied().collect();
    }
    let triangles = set.iter().flat_map(|patch| &patches[patch].triangles);
    patches.surface.positions_of(triangles.copied())
}

/// Points that are as far outside any hull as all are: the vertices of their own hull, since the
/// distance to a convex set is a convex function.
fn extreme_points(builder: &mut HullBuilder, points: Vec<Vector>) -> Vec<Vector> {
    let vertices = WORTH_A_HULL.contains(&points.len()).then(|| builder.vertices_of(&points));
    vertices.flatten().unwrap_or(points)
}
