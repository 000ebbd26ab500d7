//! Conversion to the public types and back: final hulls in the input's units, and public hulls as input.

use super::finalize::final_hull::{FinalHull, FinalHulls};
use super::patch::Patches;
use crate::decomposition::{GroupedMesh, Hull, HullErrors, ProbeReport, Provenance, Report};
use crate::error::Error;
use crate::hull::ConvexHull;
use crate::mesh::{CAP, Normalization, PreparedMesh};
use crate::parallel;

/// Hulls in the input's units, and what was verified about them.
pub(crate) struct BoundedResult {
    pub hulls: Vec<Hull>,
    pub grouped: GroupedMesh,
    pub report: Report,
}

impl BoundedResult {
    /// `bound`: as a fraction of the diagonal. `probe` is in units.
    pub(crate) fn new(
        prepared: &PreparedMesh,
        patches: &Patches,
        FinalHulls { hulls, uncovered }: &FinalHulls,
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
            patches: patches.count(),
            polygons: patches.mesh.triangles.len(),
            probe,
        };
        let grouped = grouped(patches, hulls, &normalization);
        let hulls = parallel::map(hulls, |hull| {
            let source =
                |triangle| prepared.source_triangles[patches.parents[triangle as usize] as usize];
            NormalizedHull {
                hull: &hull.hull,
                component: hull.component,
                source_triangles: hull
                    .owned
                    .triangles(patches)
                    .map(source)
                    .filter(|&triangle| triangle != CAP)
                    .collect(),
                added_thickness: hull.added_thickness,
                simplification_growth: hull.simplification_growth,
                protrusion: hull.protrusion,
            }
            .restored(&normalization)
        });
        Self { hulls, grouped, report }
    }
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
