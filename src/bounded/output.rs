//! The border to the public types: final hulls in the input's units, and public hulls as input.

use super::finalize::final_hull::{FinalHull, FinalHulls};
use super::patches::patch::Patches;
use crate::decomposition::{BoundedReport, GroupedMesh, Hull};
use crate::error::Error;
use crate::geometry::bounds::Bounds;
use crate::hull::ConvexHull;
use crate::mesh::{Normalization, PreparedMesh};
use crate::parallel;

/// Hulls in the input's units, and what was verified about them.
pub(crate) struct BoundedResult {
    pub prepared: PreparedMesh,
    pub hulls: Vec<Hull>,
    pub grouped: GroupedMesh,
    pub report: BoundedReport,
}

impl BoundedResult {
    /// `bound` in diagonals.
    pub(super) fn new(
        prepared: PreparedMesh,
        patches: &Patches,
        FinalHulls { hulls, uncovered }: &FinalHulls,
        bound: f64,
    ) -> Self {
        let normalization = prepared.normalization;
        let diagonal = normalization.diagonal;
        let protrusion = hulls.iter().map(|hull| hull.protrusion).fold(0.0, f64::max);
        let report = BoundedReport {
            bound: bound * diagonal,
            phantom_max: protrusion * diagonal,
            exposed_max: uncovered * diagonal,
            seeds: patches.count(),
            polygons: patches.mesh.triangles.len(),
        };
        let grouped = grouped(patches, hulls, &normalization);
        let hulls = parallel::map(hulls, |hull| {
            let source =
                |triangle| prepared.source_triangles[patches.parents[triangle as usize] as usize];
            HullInDiagonals {
                hull: &hull.hull,
                component: hull.component,
                source_triangles: hull.triangles(patches).map(source).collect(),
                added_thickness: hull.added_thickness,
                cap_growth: hull.cap_growth,
                protrusion: hull.protrusion,
            }
            .restored(&normalization)
        });
        Self { prepared, hulls, grouped, report }
    }
}

/// The patch mesh, its triangles labelled by hulls.
fn grouped(patches: &Patches, hulls: &[FinalHull], normalization: &Normalization) -> GroupedMesh {
    let mut groups = vec![0; patches.count()];
    for (index, hull) in (0_u32..).zip(hulls) {
        for patch in hull.patches.iter() {
            groups[patch as usize] = index;
        }
    }
    let positions = patches.mesh.positions.iter();
    GroupedMesh {
        positions: positions.map(|&point| normalization.restore(point)).collect(),
        triangles: patches.mesh.triangles.clone(),
        groups: patches.labels.iter().map(|&patch| groups[patch as usize]).collect(),
    }
}

/// What a public hull is made from. Lengths are in diagonals.
pub(super) struct HullInDiagonals<'a> {
    pub hull: &'a ConvexHull,
    pub component: u32,
    /// In any order, repeated or not.
    pub source_triangles: Vec<u32>,
    pub added_thickness: f64,
    pub cap_growth: f64,
    pub protrusion: f64,
}

impl HullInDiagonals<'_> {
    /// The hull in the input's units.
    pub(super) fn restored(self, normalization: &Normalization) -> Hull {
        let points = self.hull.points.iter().map(|&point| normalization.restore(point)).collect();
        let hull = ConvexHull { points, triangles: self.hull.triangles.clone() };
        let mut source_triangles = self.source_triangles;
        source_triangles.sort_unstable();
        source_triangles.dedup();
        let diagonal = normalization.diagonal;
        Hull {
            volume: hull.volume(),
            bounds: hull.bounds().unwrap_or(Bounds { min: [0.0; 3], max: [0.0; 3] }),
            points: hull.points,
            triangles: hull.triangles,
            component: self.component,
            source_triangles,
            added_thickness: self.added_thickness * diagonal,
            cap_growth: self.cap_growth * diagonal,
            phantom_max: Some(self.protrusion * diagonal),
        }
    }
}

/// A public hull in diagonals, and its protrusion if that was verified.
///
/// # Errors
/// [`Error::NoHull`] if it is inconsistent, since its fields are public.
pub(super) fn normalized(
    hull: &Hull,
    normalization: &Normalization,
) -> Result<(ConvexHull, Option<f64>), Error> {
    if hull.triangles.as_flattened().iter().any(|&v| v as usize >= hull.points.len()) {
        let reason = "a triangle of a hull names a point that the hull does not have";
        return Err(Error::NoHull { reason });
    }
    let points = hull.points.iter().map(|&point| normalization.normalize(point)).collect();
    let protrusion = hull.phantom_max.map(|protrusion| protrusion / normalization.diagonal);
    Ok((ConvexHull { points, triangles: hull.triangles.clone() }, protrusion))
}
