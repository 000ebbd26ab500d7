//! A final hull: of some patches, or of a part of one, with thickness, few vertices, and verified.
//!
//! Takes what the hull owns, gives the hull with its errors. Lengths are fractions of the diagonal. Where it does not keep the bound,
//! the caller divides it.

use std::ops::Range;

use super::hull_simplification::{FinalizeContext, Original, Simplified, simplify_hull};
use crate::bounded::patch::{PatchSet, Patches, Piece};
use crate::bounded::search::Search;
use crate::bounded::settings::Settings;
use crate::bounded::uncovered::{PointBuckets, distance_outside};
use crate::error::Error;
use crate::geometry::vector::{Vector, area_normal, as_arrays};
use crate::hull::growing_hull::GrowingHull;
use crate::hull::{ConvexHull, HullBuilder, LEAST_THICKNESS, solid_hull};

/// Numbers of points for which building their hull pays before computing how far they are outside
/// another one. For fewer the distances are as fast; of more, the hull has thousands of vertices.
const WORTH_A_HULL: Range<usize> = 64..8192;

/// The hull of very many points is built of those that protrude by more than this share of what may
/// be left uncovered: of all it would have thousands of vertices that do not matter.
const TOLERANCE_OF_MANY: f64 = 0.25;

/// What a hull owns: patches, or triangles of them where it was divided.
#[derive(Clone)]
pub(crate) struct Owned {
    pub patches: PatchSet,
    /// The triangles of [`Patches::surface`] that it owns, where it owns its patches only in part.
    pub part: Option<Vec<u32>>,
    /// Points inside the solid that it contains too, so that no gap opens between it and the other
    /// parts of a hull that was divided.
    pub inner_points: Vec<Vector>,
}

impl Owned {
    /// What several hulls own together.
    pub(in crate::bounded) fn union(parts: &[&Self], patches: &Patches) -> Self {
        let mut set = PatchSet::empty(patches.count());
        parts.iter().for_each(|part| set.union_with(&part.patches));
        // Another hull may own the rest of a divided patch.
        let triangles = || parts.iter().flat_map(|part| part.triangles(patches)).collect();
        let has_part = parts.iter().any(|part| part.part.is_some());
        Self {
            patches: set,
            part: has_part.then(triangles),
            inner_points: parts.iter().flat_map(|part| &part.inner_points).copied().collect(),
        }
    }

    /// The triangles of [`Patches::surface`].
    pub(in crate::bounded) fn triangles<'a>(
        &'a self,
        patches: &'a Patches,
    ) -> impl Iterator<Item = u32> + 'a {
        let whole = self.part.is_none().then_some(&self.patches);
        let of_patches = whole.into_iter().flat_map(PatchSet::iter);
        let of_patches = of_patches.flat_map(|patch| &patches[patch].triangles);
        of_patches.chain(self.part.iter().flatten()).copied()
    }

    /// The vertices of the surface, which the hull must contain.
    pub(super) fn surface_points(&self, patches: &Patches) -> Vec<Vector> {
        let set = &self.patches;
        let has_points = |patch| !patches[patch].surface_points.is_empty();
        if self.part.is_none() && set.iter().any(has_points) {
            return set.iter().flat_map(|patch| &patches[patch].surface_points).copied().collect();
        }
        patches.surface.positions_of(self.triangles(patches))
    }
}

/// A hull of the result, and what was verified about it.
pub(crate) struct FinalHull {
    pub hull: ConvexHull,
    pub owned: Owned,
    /// Thickness that a flat hull was given.
    pub added_thickness: f64,
    /// How far hull simplification made it grow.
    pub simplification_growth: f64,
    /// No point of its surface is farther than this from the solid. While it may yet be divided, any value above
    /// the bound if that is exceeded.
    pub protrusion: f64,
    /// No point of the surface that it owns is farther than this outside it.
    pub uncovered: f64,
    /// The component of the source that its first patch lies in.
    pub component: u32,
}

impl FinalHull {
    /// Whether it may be returned.
    pub(super) fn keeps_bound(&self, settings: &Settings) -> bool {
        self.protrusion <= settings.bound.verified()
            && self.uncovered <= settings.bound.max_uncovered_under_limit()
    }
}

/// The hulls of the result.
pub(crate) struct FinalHulls {
    pub hulls: Vec<FinalHull>,
    /// No point of the surface is farther than this outside all hulls.
    pub uncovered: f64,
}

impl FinalHulls {
    /// The larger of protrusion and uncovered distance.
    pub(crate) fn error(&self) -> f64 {
        self.hulls.iter().map(|hull| hull.protrusion).fold(self.uncovered, f64::max)
    }
}

/// The hull of patches, or of triangles that are a part of them, as far as it can keep the bound: see
/// [`FinalHull::keeps_bound`].
pub(super) fn make_hull(
    context: &FinalizeContext<'_>,
    owned: Owned,
    builder: &mut HullBuilder,
) -> Result<FinalHull, Error> {
    let patches = context.search.patches;
    let Owned { patches: set, part, inner_points } = &owned;
    let mut hull = match part {
        None => Piece::new(patches, set).hull,
        Some(triangles) => hull_of_triangles(patches, triangles),
    };
    hull.insert(inner_points, Vector::ZERO);
    let mut required = owned.surface_points(patches);
    required.extend_from_slice(inner_points);
    let required = extreme_points(builder, required);
    let (original, added_thickness) = full_hull(context, &mut hull, required, builder)?;
    let component = set.iter().next().map_or(0, |patch| patches[patch].component);
    let Simplified { hull, growth, protrusion, uncovered } =
        simplify_hull(context, original, builder)?;
    Ok(FinalHull {
        hull,
        owned,
        added_thickness,
        simplification_growth: growth,
        protrusion,
        uncovered,
        component,
    })
}

fn hull_of_triangles(Patches { surface, .. }: &Patches, triangles: &[u32]) -> GrowingHull {
    let corners = |&triangle: &u32| {
        surface.triangles[triangle as usize].map(|vertex| surface.points()[vertex as usize])
    };
    let points: Vec<Vector> = triangles.iter().flat_map(corners).collect();
    let normals = triangles.iter().map(corners).map(|[a, b, c]| area_normal(a, b, c));
    GrowingHull::new(&points, normals.fold(Vector::ZERO, |a, b| a + b))
}

/// The hull with all vertices that are needed to cover the `required` points, and the thickness
/// that it was given.
fn full_hull(
    context: &FinalizeContext<'_>,
    hull: &mut GrowingHull,
    required: Vec<Vector>,
    builder: &mut HullBuilder,
) -> Result<(Original, f64), Error> {
    let &Search { settings, control, .. } = &context.search;
    let max_uncovered = settings.bound.max_uncovered();
    let outward = hull.outward;
    let points = PointBuckets::new(&required);
    let thick =
        |builder: &mut HullBuilder, points: &[Vector]| -> Result<(ConvexHull, f64), Error> {
            control.check()?;
            solid_hull(builder, as_arrays(points), outward.to_array(), LEAST_THICKNESS)
        };
    let (mut full, mut added_thickness) = thick(builder, &hull.vertices())?;
    let mut uncovered = distance_outside(&full, &points, max_uncovered, control)?;
    if uncovered > max_uncovered && required.len() > WORTH_A_HULL.end {
        let mut reducer =
            HullBuilder::new().with_least_tolerance(TOLERANCE_OF_MANY * max_uncovered);
        if let Some(reduced) = reducer.vertices_of(&required) {
            (full, added_thickness) = thick(builder, &reduced)?;
            uncovered = distance_outside(&full, &points, max_uncovered, control)?;
        }
    }
    if uncovered > max_uncovered {
        // Beyond a sharp edge, a point that is hardly in front of any face can be far away.
        (full, added_thickness) = thick(builder, &required)?;
        uncovered = distance_outside(&full, &points, f64::INFINITY, control)?;
    }
    Ok((Original { hull: full, uncovered, points, outward }, added_thickness))
}

/// Points that are as far outside any hull as all are: the vertices of their own hull, since the
/// distance to a convex set is a convex function.
fn extreme_points(builder: &mut HullBuilder, points: Vec<Vector>) -> Vec<Vector> {
    let vertices = WORTH_A_HULL.contains(&points.len()).then(|| builder.vertices_of(&points));
    vertices.flatten().unwrap_or(points)
}
