//! A hull of the result, what it represents, and what it is made with. Lengths are in diagonals.

use crate::bounded::patch::{PatchSet, Patches};
use crate::bounded::search::Search;
use crate::bounded::settings::{MAX_UNCOVERED_UNDER_CAP, Settings};
use crate::geometry::vector::Vector;
use crate::hull::ConvexHull;

/// The search, and what is finalize's own.
#[derive(Clone, Copy)]
pub(super) struct FinalizeContext<'a> {
    pub search: Search<'a>,
    /// Volume that saving a vertex may add, in cubed diagonals.
    pub volume_per_vertex: f64,
}

/// What a hull represents.
#[derive(Clone)]
pub(crate) struct Represented {
    pub patches: PatchSet,
    /// The triangles of [`Patches::surface`] that it represents, where it represents its patches only in part.
    pub part: Option<Vec<u32>>,
    /// Points inside the solid that it contains too, so that no gap opens between it and the other
    /// parts of a hull that was divided.
    pub inner_points: Vec<Vector>,
}

impl Represented {
    /// What several hulls represent together.
    pub(in crate::bounded) fn union(parts: &[&Self], patches: &Patches) -> Self {
        let mut set = PatchSet::empty(patches.count());
        parts.iter().for_each(|part| set.union_with(&part.patches));
        // Another hull may represent the rest of a divided patch.
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
    pub represents: Represented,
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
    pub(in crate::bounded) fn error(&self) -> f64 {
        self.hulls.iter().map(|hull| hull.protrusion).fold(self.uncovered, f64::max)
    }
}
