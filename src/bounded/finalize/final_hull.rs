//! A hull of the result, in diagonals.

use crate::bounded::patch_set::PatchSet;
use crate::bounded::patches::patch::Patches;
use crate::bounded::settings::{MAX_UNCOVERED_UNDER_CAP, Settings};
use crate::geometry::vector::Vector;
use crate::hull::ConvexHull;

/// A hull of the result, and what was verified about it. Lengths are in diagonals.
pub(crate) struct FinalHull {
    pub hull: ConvexHull,
    /// The patches that it represents.
    pub patches: PatchSet,
    /// Where it represents its patches only in part: that part's triangles of the surface.
    pub part: Option<Vec<u32>>,
    /// Points inside the solid that it contains too, so that no gap opens between it and the other
    /// parts of a hull that was divided.
    pub inner_points: Vec<Vector>,
    /// Thickness that a flat hull was given.
    pub added_thickness: f64,
    /// How far hull simplification made it grow.
    pub simplification_growth: f64,
    /// No point of its surface is farther than this from the solid. While it may yet be divided, any value above
    /// the bound if that is exceeded.
    pub protrusion: f64,
    /// No point of the surface that it represents is farther than this outside it.
    pub uncovered: f64,
    /// The component of the source that its first patch lies in.
    pub component: u32,
}

impl FinalHull {
    /// The triangles of [`Patches::surface`] that it represents.
    pub(in crate::bounded) fn triangles<'a>(
        &'a self,
        patches: &'a Patches,
    ) -> impl Iterator<Item = u32> + 'a {
        let of_patches = self
            .part
            .is_none()
            .then(|| self.patches.iter().flat_map(|patch| &patches[patch].triangles).copied());
        of_patches.into_iter().flatten().chain(self.part.iter().flatten().copied())
    }

    /// Whether it may be returned.
    pub(super) fn keeps_bound(&self, settings: &Settings) -> bool {
        self.protrusion <= settings.bound.protrusion()
            && self.uncovered <= MAX_UNCOVERED_UNDER_CAP * settings.bound.uncovered()
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
