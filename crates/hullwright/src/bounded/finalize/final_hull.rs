//! A final hull: of some patches, or of a part of one, with thickness, few vertices, and verified.
//!
//! Takes what the hull owns, gives the hull with its errors. Lengths are fractions of the diagonal.
//! Where it does not keep the bound, the caller divides it.

use super::hull_simplification::{FinalizeContext, Original, Simplified, simplify_hull};
use crate::bounded::patch::{PatchSet, Patches};
use crate::bounded::search::Search;
use crate::bounded::settings::Settings;
use crate::bounded::uncovered::{PointBuckets, distance_outside};
use crate::error::Error;
use crate::geometry::vector::{Vector, as_arrays, bounds};
use crate::hull::{ConvexHull, HullBuilder, LEAST_THICKNESS, solid_hull};

/// A hull is built of the points that protrude by more than this fraction of what may be left
/// uncovered: of all it would have hundreds of vertices that do not matter.
const TOLERANCE: f64 = 0.5;

/// Of a hull that is thinner than the tolerance over this the vertices all count: of a plate hardly
/// any protrudes.
const LEAST_SHARE_OF_THICKNESS: f64 = 0.05;

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
        let mut points = patches.surface.positions_of(self.triangles(patches));
        let detail = &patches.detail.points;
        let own = self.triangles(patches).filter_map(|triangle| detail.get(triangle as usize));
        points.extend(own.flatten());
        points
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
    /// No point of its surface is farther than this from the solid. While it may yet be divided,
    /// any value above the bound if that is exceeded.
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
    /// How many of them there would be without the limit on vertices, at most.
    pub without_vertex_limit: usize,
}

impl FinalHulls {
    /// The larger of protrusion and uncovered distance.
    pub(crate) fn error(&self) -> f64 {
        self.hulls.iter().map(|hull| hull.protrusion).fold(self.uncovered, f64::max)
    }
}

/// The hull of patches, or of triangles that are a part of them, as far as it can keep the bound:
/// see [`FinalHull::keeps_bound`].
pub(super) fn make_hull(
    context: &FinalizeContext<'_>,
    owned: Owned,
    builder: &mut HullBuilder,
) -> Result<FinalHull, Error> {
    let patches = context.search.patches;
    let Owned { patches: set, part, inner_points } = &owned;
    let outward = match part {
        None => set.iter().fold(Vector::ZERO, |sum, patch| sum + patches[patch].outward),
        Some(triangles) => {
            let mesh = &patches.surface;
            let normals = triangles.iter().map(|&triangle| mesh.area_normal(triangle));
            normals.fold(Vector::ZERO, |a, b| a + b)
        }
    };
    let mut required = owned.surface_points(patches);
    required.extend_from_slice(inner_points);
    if required.is_empty() {
        // Patches to which nothing of the surface is closest.
        required.extend(set.iter().flat_map(|patch| &patches[patch].points));
    }
    let (original, added_thickness) = full_hull(context, outward, required, builder)?;
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

/// The hull of the vertices that are needed to cover the `required` points, and the thickness that
/// it was given.
fn full_hull(
    context: &FinalizeContext<'_>,
    outward: Vector,
    required: Vec<Vector>,
    builder: &mut HullBuilder,
) -> Result<(Original, f64), Error> {
    let &Search { settings, control, .. } = &context.search;
    let max_uncovered = settings.bound.max_uncovered();
    let thick =
        |builder: &mut HullBuilder, points: &[Vector]| -> Result<(ConvexHull, f64), Error> {
            control.check()?;
            solid_hull(builder, as_arrays(points), outward.to_array(), LEAST_THICKNESS)
        };
    let points = PointBuckets::new(&required);
    let mut reducer = HullBuilder::new().with_least_tolerance(TOLERANCE * max_uncovered);
    if let Some(reduced) = reducer.vertices_of(&required) {
        let (hull, added_thickness) = thick(builder, &reduced)?;
        let uncovered = distance_outside(&hull, &points, max_uncovered, control)?;
        if uncovered <= max_uncovered && is_thick(&hull, TOLERANCE * max_uncovered) {
            return Ok((Original { hull, uncovered, points, outward }, added_thickness));
        }
    }
    // Beyond a sharp edge, a point that is hardly in front of any face can be far away.
    let (hull, added_thickness) = thick(builder, &required)?;
    let uncovered = distance_outside(&hull, &points, f64::INFINITY, control)?;
    Ok((Original { hull, uncovered, points, outward }, added_thickness))
}

/// Whether a hull is so thick that leaving out vertices within the tolerance hardly changes it.
fn is_thick(hull: &ConvexHull, tolerance: f64) -> bool {
    let (min, max) = bounds(hull.points().iter().copied());
    tolerance * max.distance_squared(min) <= LEAST_SHARE_OF_THICKNESS * hull.volume()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounded::fixture::{Fixture, cubes, l_prism};
    use crate::bounded::patch::Patch;
    use crate::hull::convex_hull;
    use crate::mesh::shapes::cuboid;

    fn whole(fixture: &Fixture, patches: &[u32]) -> Owned {
        let patches = fixture.set(patches.iter().copied());
        Owned { patches, part: None, inner_points: Vec::new() }
    }

    fn made(fixture: &Fixture, owned: Owned) -> FinalHull {
        let context = FinalizeContext { search: fixture.search(), volume_per_vertex: 0.0 };
        make_hull(&context, owned, &mut HullBuilder::new()).unwrap()
    }

    #[test]
    fn whole_patches_together_are_whole() {
        let fixture = Fixture::new(&cubes([0.0, 2.0]), 0.02);
        let (mut first, second) = (whole(&fixture, &[0]), whole(&fixture, &[1]));
        first.inner_points.push(Vector::X);
        let both = Owned::union(&[&first, &second], &fixture.patches);
        assert_eq!(both.patches, fixture.patches.all());
        assert!(both.part.is_none());
        assert_eq!(both.inner_points, [Vector::X]);
        assert_eq!(both.triangles(&fixture.patches).count(), 24);
    }

    #[test]
    fn with_a_part_of_a_patch_all_triangles_are_listed() {
        let fixture = Fixture::new(&cubes([0.0, 2.0]), 0.02);
        let [own, other] = [0, 1].map(|patch| &fixture.patches[patch].triangles);
        let part = Owned { part: Some(own[..3].to_vec()), ..whole(&fixture, &[0]) };
        let both = Owned::union(&[&part, &whole(&fixture, &[1])], &fixture.patches);
        assert_eq!(both.part, Some([&own[..3], &other[..]].concat()));
    }

    #[test]
    fn a_hull_must_contain_the_detail_of_the_triangles_that_it_owns_alone() {
        let mut fixture = Fixture::new(&cubes([0.0, 2.0]), 0.02);
        let triangles = fixture.patches[0].triangles.clone();
        let mut points = vec![Vec::new(); fixture.patches.surface.triangles.len()];
        points[triangles[0] as usize] = vec![Vector::X];
        points[triangles[1] as usize] = vec![Vector::Y];
        fixture.patches.detail.points = points;
        let part = Owned { part: Some(vec![triangles[1]]), ..whole(&fixture, &[0]) };
        let points = part.surface_points(&fixture.patches);
        assert!(points.contains(&Vector::Y) && !points.contains(&Vector::X));
        assert_eq!(points.len(), 4);
    }

    #[test]
    fn the_hull_of_a_box_is_the_box_without_an_error() {
        let fixture = Fixture::new(&cuboid([0.0; 3], [1.0, 2.0, 2.0]), 0.02);
        let hull = made(&fixture, whole(&fixture, &[0]));
        assert_eq!(hull.hull.points.len(), 8);
        assert!((hull.hull.volume() * 27.0 - 4.0).abs() < 1e-9);
        assert_eq!([hull.added_thickness, hull.simplification_growth], [0.0; 2]);
        assert!(hull.uncovered < 1e-9 && hull.protrusion < fixture.settings.bound.verified());
        assert!(hull.keeps_bound(&fixture.settings));
    }

    #[test]
    fn a_flat_patch_becomes_a_thin_hull_within_the_solid() {
        let fixture = Fixture::new(&l_prism(), 0.02);
        let solid = &fixture.solids.exact;
        let is_flat = |&patch: &u32| {
            let Patch { min, max, .. } = fixture.patches[patch];
            (max - min).min_element() < 1e-9
        };
        let flat: Vec<u32> = (0..fixture.patches.count() as u32).filter(is_flat).collect();
        assert!(!flat.is_empty());
        for patch in flat {
            let hull = made(&fixture, whole(&fixture, &[patch]));
            assert!(hull.added_thickness > 0.0 && hull.keeps_bound(&fixture.settings));
            // Towards the outside it would protrude by all of its thickness.
            let least = 0.1 * hull.added_thickness;
            let is_outside = |&point: &Vector| solid.outside(point, least).is_some();
            assert!(!hull.hull.points().iter().any(is_outside), "{patch}");
        }
    }

    #[test]
    fn a_hull_over_a_notch_does_not_keep_the_bound() {
        let fixture = Fixture::new(&l_prism(), 0.02);
        let all: Vec<u32> = (0..fixture.patches.count() as u32).collect();
        let hull = made(&fixture, whole(&fixture, &all));
        assert!(hull.protrusion > fixture.settings.bound.verified());
        assert!(!hull.keeps_bound(&fixture.settings));
    }

    #[test]
    fn a_hull_contains_its_inner_points() {
        let fixture = Fixture::new(&l_prism(), 0.02);
        // The origin is the middle of the notch, which the patch is away from.
        let inner = Vector::ZERO;
        let owned = Owned { inner_points: vec![inner], ..whole(&fixture, &[0]) };
        let hull = made(&fixture, owned).hull;
        let planes = hull.face_planes();
        assert!(planes.iter().all(|plane| plane.height(inner) <= 1e-9));
    }

    #[test]
    fn a_hull_may_be_returned_up_to_the_bound_and_what_may_stay_uncovered_under_the_limit() {
        let fixture = Fixture::new(&cubes([0.0, 2.0]), 0.02);
        let mut hull = fixture.hulls_of_patches().remove(0);
        let bound = fixture.settings.bound;
        (hull.protrusion, hull.uncovered) = (bound.verified(), bound.max_uncovered_under_limit());
        assert!(hull.keeps_bound(&fixture.settings));
        hull.protrusion *= 1.001;
        assert!(!hull.keeps_bound(&fixture.settings));
        hull.protrusion = 0.0;
        hull.uncovered *= 1.001;
        assert!(!hull.keeps_bound(&fixture.settings));
    }

    #[test]
    fn the_error_of_hulls_is_the_largest_protrusion_or_what_is_uncovered() {
        let fixture = Fixture::new(&cubes([0.0, 2.0]), 0.02);
        let mut hulls = fixture.hulls_of_patches();
        hulls[1].protrusion = 0.01;
        let mut found = FinalHulls { hulls, uncovered: 0.003, without_vertex_limit: 2 };
        assert_eq!(found.error(), 0.01);
        found.uncovered = 0.02;
        assert_eq!(found.error(), 0.02);
    }

    #[test]
    fn a_plate_is_thin_and_a_cube_is_not() {
        let plate = |thickness| convex_hull(&cuboid([0.0; 3], [1.0, 1.0, thickness]).positions);
        let is_thick = |thickness| is_thick(&plate(thickness).unwrap(), 5e-4);
        assert!(is_thick(1.0) && is_thick(0.03) && !is_thick(0.01));
    }
}
