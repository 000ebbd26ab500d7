//! Hull simplification: as many vertices are saved as a small volume allows, and as many as the
//! limit requires, within the bound. Physics engines pay for each vertex of a hull.
//!
//! A hull that can hardly keep the limit is divided at once. Of another one, the first
//! attempt that keeps the bound is taken:
//!
//! 1. the hull without vertices that hardly protrude, its edges collapsed outward, or as it is;
//! 2. the full hull with edges collapsed;
//! 3. the full hull, unless it exceeds the limit;
//! 4. as 1, leaving out vertices that protrude more;
//! 5. the hull grown to the limit, and that hull shrunk a little.
//!
//! If all fail, the most prominent vertices remain. They may violate the bound: then the hull is
//! divided.

use crate::bounded::search::Search;
use crate::bounded::settings::MAX_UNCOVERED;
use crate::bounded::uncovered::{PointBuckets, distance_outside};
use crate::error::Error;
use crate::geometry::vector::Vector;
use crate::hull::{
    ConvexHull, HullBuilder, LEAST_THICKNESS, collapse_edges, limit_vertices, most_prominent,
    prominent, solid_hull,
};
use crate::solid::Scratch;
use crate::solid::protrusion;

/// A hull without vertices that hardly protrude must keep at least this share of its volume: of a
/// thin plate hardly any vertex protrudes, and what is left can be a tetrahedron.
const MIN_VOLUME_SHARE: f64 = 0.95;

/// Where the limit cannot be kept otherwise, vertices that protrude by less than these fractions of
/// the bound are left out: more than [`MAX_UNCOVERED`]. A hull that then leaves more than
/// `MAX_UNCOVERED_UNDER_LIMIT` uncovered is refused.
const COARSER: [f64; 2] = [0.1, 0.2];

/// By these fractions of the bound a hull that was grown to the limit shrinks again. It was larger
/// than what it must contain: one that leaves more than `MAX_UNCOVERED_UNDER_LIMIT` uncovered is
/// refused.
const SHRINKING: [f64; 2] = [0.2, 0.4];

/// A hull of more vertices does not collapse from the full hull to keep a limit once the hull of
/// prominent vertices has failed: collapsing is quadratic in the vertices and hardly gives another
/// result.
const MAX_COLLAPSIBLE: usize = 256;

/// A hull is divided at once if it needs more than this multiple of the limit: the fewest of its
/// vertices from which no other protrudes by more than may be uncovered and may protrude together,
/// taken greedily. Of 41 such hulls, parts of a sphere and of scans, none could keep the limit;
/// whole spheres could at up to 1.17.
const MOST_NEEDED: f64 = 1.2;

/// The search, and what is finalize's own.
#[derive(Clone, Copy)]
pub(super) struct FinalizeContext<'a> {
    pub search: Search<'a>,
    /// Volume that saving a vertex may add, as a fraction of the cubed diagonal.
    pub volume_per_vertex: f64,
}

/// A hull before simplification.
pub(super) struct Original {
    pub hull: ConvexHull,
    /// How far the points that it must contain are outside it.
    pub uncovered: f64,
    /// The points that it must contain.
    pub points: PointBuckets,
    /// On which side a flat hull is outside.
    pub outward: Vector,
}

/// A hull after simplification.
pub(super) struct Simplified {
    pub hull: ConvexHull,
    /// How far it grew.
    pub growth: f64,
    /// See [`protrusion`]. If it exceeds the bound, any value above the bound.
    pub protrusion: f64,
    pub uncovered: f64,
}

/// Saves vertices of a hull: see the module.
pub(super) fn simplify_hull(
    context: &FinalizeContext<'_>,
    original: Original,
    builder: &mut HullBuilder,
) -> Result<Simplified, Error> {
    let max_vertices = context.search.settings.max_vertices.unwrap_or(usize::MAX);
    let mut attempts = Attempts {
        context,
        original: &original,
        builder,
        scratch: Scratch::default(),
        max_vertices,
    };
    if attempts.needs_more_vertices() {
        // Nothing says that it protrudes.
        let hull = original.hull;
        return Ok(Simplified { hull, growth: 0.0, protrusion: 0.0, uncovered: f64::INFINITY });
    }
    if let Some(simplified) = attempts.saving_vertices()? {
        return Ok(simplified);
    }
    if original.hull.points.len() > max_vertices {
        return attempts.within_limit();
    }
    let &Search { exact_solid: solid, settings, control, .. } = &context.search;
    let bound = settings.bound.verified();
    let protrusion = protrusion(&original.hull, solid, bound, bound, control)?;
    let Original { hull, uncovered, .. } = original;
    Ok(Simplified { hull, growth: 0.0, protrusion, uncovered })
}

/// Attempts to simplify a hull.
struct Attempts<'a> {
    context: &'a FinalizeContext<'a>,
    original: &'a Original,
    builder: &'a mut HullBuilder,
    scratch: Scratch,
    max_vertices: usize,
}

impl Attempts<'_> {
    /// Whether the hull can hardly keep the limit on vertices: see [`MOST_NEEDED`].
    fn needs_more_vertices(&self) -> bool {
        let points = self.original.hull.points();
        if points.len() <= self.max_vertices {
            return false;
        }
        let bound = self.context.search.settings.bound;
        let band = bound.verified() + bound.max_uncovered_under_limit();
        let mut reducer = HullBuilder::new().with_least_tolerance(band);
        let most = MOST_NEEDED * self.max_vertices as f64;
        reducer.vertices_of(points).is_some_and(|needed| needed.len() as f64 > most)
    }

    /// Attempts 1 and 2: as far as little volume is added and little surface left out.
    fn saving_vertices(&mut self) -> Result<Option<Simplified>, Error> {
        let original = self.original;
        let max_uncovered =
            self.context.search.settings.bound.max_uncovered().max(original.uncovered);
        let prominent = self.without_small(MAX_UNCOVERED)?;
        let has_prominent = prominent.is_some();
        if let Some(prominent) = prominent
            && let Some(simplified) = self.collapsed_or_as_is(prominent, max_uncovered)?
        {
            return Ok(Some(simplified));
        }
        let count = original.hull.points.len();
        let is_hopeless = has_prominent && count > self.max_vertices && count > MAX_COLLAPSIBLE;
        if is_hopeless { Ok(None) } else { self.collapsed(&original.hull, max_uncovered) }
    }

    /// Attempts 4 and 5, for a hull that only exceeds the limit.
    fn within_limit(&mut self) -> Result<Simplified, Error> {
        let (original, max_vertices) = (self.original, self.max_vertices);
        let &Search { exact_solid: solid, settings, control, .. } = &self.context.search;
        let (bound, requested) = (settings.bound.verified(), settings.bound.requested());
        let max_uncovered = settings.bound.max_uncovered().max(original.uncovered);
        let max_under_limit = settings.bound.max_uncovered_under_limit().max(original.uncovered);
        for share in COARSER {
            let Some(prominent) = self.without_small(share)? else { continue };
            if let Some(simplified) = self.collapsed_or_as_is(prominent, max_under_limit)? {
                return Ok(simplified);
            }
        }
        let (grown, growth) =
            limit_vertices(self.builder, original.hull.clone(), max_vertices, control)?;
        if let Some(simplified) = self.accepted(grown.clone(), growth, max_uncovered)? {
            return Ok(simplified);
        }
        for share in SHRINKING {
            let Some(smaller) = shrunk(&grown, share * requested) else { break };
            if let Some(simplified) = self.accepted(smaller, growth, max_under_limit)? {
                return Ok(simplified);
            }
        }
        let inner = most_prominent(self.builder, original.hull.points(), max_vertices, control)?;
        let hull = inner.unwrap_or_else(|| original.hull.clone());
        let protrusion = protrusion(&hull, solid, bound, bound, control)?;
        let uncovered = distance_outside(&hull, &original.points, f64::INFINITY, control)?;
        Ok(Simplified { hull, growth: 0.0, protrusion, uncovered })
    }

    /// The hull without vertices that protrude by less than a share of the bound, if it keeps its
    /// thickness and most of its volume.
    fn without_small(&mut self, share: f64) -> Result<Option<ConvexHull>, Error> {
        self.context.search.control.check()?;
        let original = self.original;
        let tolerance = share * self.context.search.settings.bound.requested();
        let Some(prominent) = prominent(&original.hull, tolerance) else { return Ok(None) };
        let (_, added) = solid_hull(
            self.builder,
            &prominent.points,
            original.outward.to_array(),
            LEAST_THICKNESS,
        )?;
        let min_volume = MIN_VOLUME_SHARE * original.hull.volume();
        Ok((added == 0.0 && prominent.volume() >= min_volume).then_some(prominent))
    }

    fn collapsed_or_as_is(
        &mut self,
        hull: ConvexHull,
        max_uncovered: f64,
    ) -> Result<Option<Simplified>, Error> {
        match self.collapsed(&hull, max_uncovered)? {
            Some(simplified) => Ok(Some(simplified)),
            None => self.accepted(hull, 0.0, max_uncovered),
        }
    }

    /// The hull with edges collapsed outward.
    fn collapsed(
        &mut self,
        hull: &ConvexHull,
        max_uncovered: f64,
    ) -> Result<Option<Simplified>, Error> {
        let &FinalizeContext { search, volume_per_vertex } = self.context;
        let Search { solid, settings, control, .. } = search;
        let scratch = &mut self.scratch;
        let mut fits = |face| {
            control.check()?;
            let bound = settings.bound.search();
            Ok(solid.face_fits(face, bound, scratch))
        };
        match collapse_edges(hull, volume_per_vertex, self.max_vertices, control, &mut fits)? {
            Some((collapsed, growth)) => self.accepted(collapsed, growth, max_uncovered),
            None => Ok(None),
        }
    }

    /// A hull, if it keeps the limit and the bound.
    fn accepted(
        &self,
        hull: ConvexHull,
        growth: f64,
        max_uncovered: f64,
    ) -> Result<Option<Simplified>, Error> {
        let &Search { exact_solid: solid, settings, control, .. } = &self.context.search;
        if hull.points.len() > self.max_vertices {
            return Ok(None);
        }
        let uncovered = distance_outside(&hull, &self.original.points, max_uncovered, control)?;
        if uncovered > max_uncovered {
            return Ok(None);
        }
        let bound = settings.bound.verified();
        let protrusion = protrusion(&hull, solid, bound, bound, control)?;
        let simplified = Simplified { hull, growth, protrusion, uncovered };
        Ok((protrusion <= bound).then_some(simplified))
    }
}

/// A hull with its vertices moved towards its centre, the farthest by `by`; `None` if nothing would
/// be left.
fn shrunk(hull: &ConvexHull, by: f64) -> Option<ConvexHull> {
    let sum = hull.points().iter().fold(Vector::ZERO, |sum, &point| sum + point);
    let centre = sum * (1.0 / hull.points.len() as f64);
    let farthest = hull.points().iter().map(|&point| point.distance(centre)).fold(0.0, f64::max);
    let factor = 1.0 - by / farthest;
    let moved = |&point: &Vector| centre + (point - centre) * factor;
    (farthest > by).then(|| ConvexHull {
        points: hull.points().iter().map(moved).map(Into::into).collect(),
        triangles: hull.triangles.clone(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounded::fixture::Fixture;
    use crate::geometry::TriangleMesh;
    use crate::hull::convex_hull;
    use crate::mesh::shapes::{cuboid, uv_sphere};
    use crate::parameters::{Length, Parameters};

    /// The hull of all points of a mesh, simplified.
    fn simplified(
        mesh: &TriangleMesh,
        parameters: &Parameters,
        saving: f64,
    ) -> (Fixture, Simplified) {
        let fixture = Fixture::with(mesh, parameters);
        let points = fixture.prepared.mesh.points();
        let hull = convex_hull(&fixture.prepared.mesh.positions).unwrap();
        let points = PointBuckets::new(points);
        let original = Original { hull, uncovered: 0.0, points, outward: Vector::ZERO };
        let context = FinalizeContext { search: fixture.search(), volume_per_vertex: saving };
        let simplified = simplify_hull(&context, original, &mut HullBuilder::new()).unwrap();
        (fixture, simplified)
    }

    fn ball() -> TriangleMesh {
        uv_sphere(24, [0.0; 3], 1.0)
    }

    fn parameters(bound: f64) -> Parameters {
        Parameters::default().with_max_error(Length::share(bound))
    }

    #[test]
    fn a_box_keeps_its_eight_vertices() {
        let (_, found) = simplified(&cuboid([0.0; 3], [1.0; 3]), &parameters(0.02), 0.0);
        assert_eq!(found.hull.points.len(), 8);
        assert_eq!([found.growth, found.uncovered], [0.0; 2]);
    }

    #[test]
    fn without_a_limit_only_vertices_go_that_add_little_volume_or_hardly_protrude() {
        let parameters = &parameters(0.05).with_max_vertices(None);
        let (fixture, found) = simplified(&ball(), parameters, 0.0);
        let (_, saving) = simplified(&ball(), parameters, 1e-4);
        let (all, kept, fewer) = (
            fixture.prepared.mesh.positions.len(),
            found.hull.points.len(),
            saving.hull.points.len(),
        );
        assert!(all > kept && kept > fewer && fewer >= 8, "{all}, {kept}, {fewer}");
        for found in [found, saving] {
            assert!(found.protrusion <= fixture.settings.bound.verified());
            assert!(found.uncovered <= fixture.settings.bound.max_uncovered());
        }
    }

    #[test]
    fn a_ball_with_more_vertices_than_the_limit_is_replaced_within_both_bounds() {
        for most in [64, 40, 32] {
            let (fixture, found) =
                simplified(&ball(), &parameters(0.05).with_max_vertices(most), 0.0);
            let bound = fixture.settings.bound;
            assert!(found.hull.points.len() <= most);
            assert!(found.protrusion <= bound.verified(), "{most}: {}", found.protrusion);
            assert!(found.uncovered <= bound.max_uncovered_under_limit(), "{most}");
        }
    }

    #[test]
    fn a_hull_that_can_hardly_keep_the_limit_is_returned_as_uncovered_to_be_divided() {
        let (fixture, found) = simplified(&ball(), &parameters(0.005).with_max_vertices(16), 0.0);
        assert_eq!(found.uncovered, f64::INFINITY);
        assert_eq!(found.hull.points.len(), fixture.prepared.mesh.positions.len());
    }

    #[test]
    fn a_hull_that_needs_a_few_more_vertices_than_the_limit_is_not_divided_at_once() {
        let fixture = Fixture::new(&ball(), 0.05);
        let hull = convex_hull(&fixture.prepared.mesh.positions).unwrap();
        let points = PointBuckets::new(&[]);
        let original = Original { hull, uncovered: 0.0, points, outward: Vector::ZERO };
        let bound = fixture.settings.bound;
        let band = bound.verified() + bound.max_uncovered_under_limit();
        let mut reducer = HullBuilder::new().with_least_tolerance(band);
        let needed = reducer.vertices_of(original.hull.points()).unwrap().len() as f64;
        for (share, expected) in [(1.3, true), (1.1, false)] {
            let context = FinalizeContext { search: fixture.search(), volume_per_vertex: 0.0 };
            let attempts = Attempts {
                context: &context,
                original: &original,
                builder: &mut HullBuilder::new(),
                scratch: Scratch::default(),
                max_vertices: (needed / share).round() as usize,
            };
            assert_eq!(attempts.needs_more_vertices(), expected, "{needed} / {share}");
        }
    }

    #[test]
    fn a_hull_shrinks_towards_its_centre_and_no_vertex_moves_farther_than_it_may() {
        let hull = convex_hull(&cuboid([1.0; 3], [3.0; 3]).positions).unwrap();
        let by = 0.1;
        let smaller = shrunk(&hull, by).unwrap();
        let mut moved: f64 = 0.0;
        for (point, before) in smaller.points().iter().zip(hull.points()) {
            moved = moved.max(point.distance(*before));
            assert!(point.distance(Vector::splat(2.0)) < before.distance(Vector::splat(2.0)));
        }
        assert!((moved - by).abs() < 1e-12);
        assert_eq!(smaller.triangles, hull.triangles);
        // The corners are √3 from the centre.
        assert!(shrunk(&hull, 1.74).is_none() && shrunk(&hull, 1.73).is_some());
    }
}
