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
