//! Conversion to the public types and back: final hulls in the input's units, and public hulls as
//! input.

use super::detail::Parts;
use super::finalize::final_hull::{FinalHull, FinalHulls};
use super::patch::Patches;
use super::surfaces::Surfaces;
use crate::decomposition::{GroupedMesh, Hull, HullErrors, ProbeReport, Provenance, Report};
use crate::error::Error;
use crate::geometry::vector::centre;
use crate::hull::ConvexHull;
use crate::mesh::{CAP, Normalization, PreparedMesh};

/// Hulls in the input's units, and what was verified about them.
pub(crate) struct BoundedResult {
    pub hulls: Vec<Hull>,
    pub grouped: GroupedMesh,
    pub report: Report,
}

impl BoundedResult {
    /// `bound`: as a fraction of the diagonal. `probe` is in units.
    pub(crate) fn new(
        (prepared, surfaces): (&PreparedMesh, &Surfaces),
        patches: &Patches,
        FinalHulls { hulls, uncovered, without_vertex_limit }: &FinalHulls,
        bound: f64,
        probe: Option<ProbeReport>,
    ) -> Self {
        let normalization = prepared.normalization;
        let diagonal = normalization.diagonal;
        let protrusion = hulls.iter().map(|hull| hull.protrusion).fold(0.0, f64::max);
        let report = Report {
            bound: bound * diagonal,
            protrusion_max: protrusion * diagonal,
            uncovered_max: uncovered * diagonal,
            hulls_without_vertex_limit: *without_vertex_limit,
            patches: patches.count(),
            patches_across_folds: patches.are_across_folds,
            polygons: patches.mesh.triangles.len(),
            probe,
        };
        let grouped = grouped(patches, hulls, &normalization);
        let sources = sources(prepared, surfaces, patches, hulls);
        let hulls = hulls.iter().zip(sources).map(|(hull, source_triangles)| {
            NormalizedHull {
                hull: &hull.hull,
                component: hull.component,
                source_triangles,
                added_thickness: hull.added_thickness,
                simplification_growth: hull.simplification_growth,
                protrusion: hull.protrusion,
            }
            .restored(&normalization)
        });
        Self { hulls: hulls.collect(), grouped, report }
    }
}

/// For each hull the source's triangles that it is made of: those closest to a part of the coarse
/// surface that it owns, and of a part to which none is closest the one whose centre is.
fn sources(
    prepared: &PreparedMesh,
    surfaces: &Surfaces,
    patches: &Patches,
    hulls: &[FinalHull],
) -> Vec<Vec<u32>> {
    let (mesh, count) = (&prepared.mesh, surfaces.coarse.mesh.triangles.len());
    let middle = |triangle: u32| centre(mesh.corners(mesh.triangles[triangle as usize]));
    let finder = Parts::new(&patches.surface, &patches.parents, count);
    // For each part what is closest to it, and for each coarse triangle all that it stands for.
    let mut of_part: Vec<Vec<u32>> = vec![Vec::new(); patches.surface.triangles.len()];
    let mut of_triangle: Vec<Vec<u32>> = vec![Vec::new(); count];
    for (triangle, &exact) in (0..).zip(&surfaces.exact.owners) {
        let parent = surfaces.coarse_of(exact);
        of_part[finder.closest(parent, || middle(triangle)) as usize].push(triangle);
        if finder.of(parent).len() > 1 {
            of_triangle[parent as usize].push(triangle);
        }
    }
    for (part, own) in (0..).zip(&mut of_part).filter(|(_, own)| own.is_empty()) {
        let all = &of_triangle[patches.parents[part as usize] as usize];
        let at = centre(patches.surface.corners(patches.surface.triangles[part as usize]));
        let distance = |&triangle: &u32| middle(triangle).distance_squared(at);
        own.extend(all.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))));
    }
    let source = |&triangle: &u32| prepared.source_triangles[triangle as usize];
    let of_hull = |hull: &FinalHull| {
        let own = hull.owned.triangles(patches).flat_map(|part| &of_part[part as usize]);
        own.map(source).filter(|&triangle| triangle != CAP).collect()
    };
    hulls.iter().map(of_hull).collect()
}

/// The patch mesh, its triangles labelled by hulls.
fn grouped(patches: &Patches, hulls: &[FinalHull], normalization: &Normalization) -> GroupedMesh {
    let mut groups = vec![0; patches.count()];
    for (index, hull) in (0_u32..).zip(hulls) {
        for patch in hull.owned.patches.iter() {
            groups[patch as usize] = index;
        }
    }
    let positions = patches.mesh.points().iter();
    GroupedMesh {
        positions: positions.map(|&point| normalization.restore(point).into()).collect(),
        triangles: patches.mesh.triangles.clone(),
        groups: patches.labels.iter().map(|&patch| groups[patch as usize]).collect(),
    }
}

/// What a public hull is made from. Lengths are fractions of the diagonal.
pub(crate) struct NormalizedHull<'a> {
    pub hull: &'a ConvexHull,
    pub component: u32,
    /// In any order, repeated or not.
    pub source_triangles: Vec<u32>,
    pub added_thickness: f64,
    pub simplification_growth: f64,
    pub protrusion: f64,
}

impl NormalizedHull<'_> {
    /// The hull in the input's units.
    pub(crate) fn restored(self, normalization: &Normalization) -> Hull {
        let points =
            self.hull.points().iter().map(|&point| normalization.restore(point).into()).collect();
        let mut source_triangles = self.source_triangles;
        source_triangles.sort_unstable();
        source_triangles.dedup();
        let diagonal = normalization.diagonal;
        Hull {
            shape: ConvexHull { points, triangles: self.hull.triangles.clone() },
            provenance: Provenance { component: self.component, source_triangles },
            errors: HullErrors {
                added_thickness: self.added_thickness * diagonal,
                simplification_growth: self.simplification_growth * diagonal,
                protrusion_max: Some(self.protrusion * diagonal),
            },
        }
    }
}

/// A public hull scaled by the diagonal, and its protrusion if that was verified.
///
/// # Errors
/// [`Error::UnusableHull`] if it is inconsistent, since its fields are public. `index`: its place
/// among the others.
pub(super) fn normalized(
    hull: &Hull,
    index: usize,
    normalization: &Normalization,
) -> Result<(ConvexHull, Option<f64>), Error> {
    let Hull { shape, errors, .. } = hull;
    let is_inconsistent = |&vertex: &u32| vertex as usize >= shape.points.len();
    if shape.triangles.as_flattened().iter().any(is_inconsistent) {
        let reason = "a triangle names a point that it does not have";
        return Err(Error::UnusableHull { hull: index, reason });
    }
    let points =
        shape.points().iter().map(|&point| normalization.normalize(point).into()).collect();
    let protrusion = errors.protrusion_max.map(|protrusion| protrusion / normalization.diagonal);
    Ok((ConvexHull { points, triangles: shape.triangles.clone() }, protrusion))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounded::fixture::{Fixture, cubes};
    use crate::geometry::vector::Vector;
    use crate::hull::convex_hull;
    use crate::mesh::shapes::cuboid;

    fn cube() -> ConvexHull {
        convex_hull(&cuboid([-0.2; 3], [0.3; 3]).positions).unwrap()
    }

    fn normalization() -> Normalization {
        Normalization { centre: Vector::new(5.0, -7.0, 100.0), diagonal: 8.0 }
    }

    fn restored(hull: &ConvexHull) -> Hull {
        let made = NormalizedHull {
            hull,
            component: 3,
            source_triangles: vec![7, 2, 7, 5, 2],
            added_thickness: 0.25,
            simplification_growth: 0.5,
            protrusion: 0.125,
        };
        made.restored(&normalization())
    }

    #[test]
    fn errors_of_a_hull_are_in_units() {
        let errors = restored(&cube()).errors;
        assert_eq!(errors.added_thickness, 2.0);
        assert_eq!(errors.simplification_growth, 4.0);
        assert_eq!(errors.protrusion_max, Some(1.0));
    }

    #[test]
    fn source_triangles_ascend_and_are_named_once() {
        let Provenance { component, source_triangles } = restored(&cube()).provenance;
        assert_eq!((component, source_triangles), (3, vec![2, 5, 7]));
    }

    #[test]
    fn a_hull_in_units_becomes_the_one_that_it_was_made_from() {
        let hull = cube();
        let (again, protrusion) = normalized(&restored(&hull), 0, &normalization()).unwrap();
        assert_eq!(protrusion, Some(0.125));
        assert_eq!(again.triangles, hull.triangles);
        for (a, b) in again.points().iter().zip(hull.points()) {
            assert!(a.distance(*b) < 1e-12);
        }
    }

    #[test]
    fn a_hull_with_a_triangle_that_names_no_point_is_refused_by_its_place() {
        let mut hull = restored(&cube());
        hull.shape.triangles[1][2] = hull.shape.points.len() as u32;
        let refused = normalized(&hull, 4, &normalization()).err();
        assert!(matches!(refused, Some(Error::UnusableHull { hull: 4, .. })), "{refused:?}");
    }

    #[test]
    fn a_result_names_for_each_triangle_the_hull_of_its_component() {
        let fixture = Fixture::new(&cubes([0.0, 3.0]), 0.02);
        let mut hulls = fixture.hulls_of_patches();
        hulls[1].protrusion = 0.001;
        let found = FinalHulls { hulls, uncovered: 0.002, without_vertex_limit: 2 };
        let Fixture { prepared, surfaces, patches, .. } = &fixture;
        let result = BoundedResult::new((prepared, surfaces), patches, &found, 0.02, None);
        let [left, right] = &result.hulls[..] else { panic!("{} hulls", result.hulls.len()) };
        // The first twelve triangles of the mesh are those of the left cube.
        assert_eq!(left.provenance.source_triangles, Vec::from_iter(0..12));
        assert_eq!(right.provenance.source_triangles, Vec::from_iter(12..24));
        let GroupedMesh { positions, triangles, groups } = &result.grouped;
        assert_eq!([triangles.len(), groups.len()], [24; 2]);
        for (corners, &group) in triangles.iter().zip(groups) {
            assert!(corners.iter().all(|&v| (positions[v as usize][0] > 2.0) == (group == 1)));
        }
        let report = &result.report;
        let diagonal = 18.0_f64.sqrt();
        for (value, fraction) in
            [(report.bound, 0.02), (report.protrusion_max, 0.001), (report.uncovered_max, 0.002)]
        {
            assert!((value - fraction * diagonal).abs() < 1e-12, "{value}");
        }
        assert_eq!([report.patches, report.polygons], [2, 24]);
    }
}
