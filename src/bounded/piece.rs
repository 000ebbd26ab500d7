//! A piece: a set of patches and their hull, which can go on growing.

use super::growing_hull::GrowingHull;
use super::patch_set::PatchSet;
use super::patches::patch::Patches;
use crate::geometry::vector::{Vector, add};

/// Patches and their hull.
#[derive(Debug, Clone)]
pub(crate) struct Piece {
    pub patches: PatchSet,
    pub hull: GrowingHull,
    /// Vertices of the hull, where other pieces are going to join it; empty otherwise.
    pub vertices: Vec<Vector>,
    /// Points inside the solid that its hull contains, too, so that the solid is not left hollow.
    pub inner_points: Vec<Vector>,
}

impl Piece {
    /// The hull of some patches.
    pub(super) fn new(patches: &Patches, set: &PatchSet) -> Self {
        let mut points = Vec::new();
        let mut outward = [0.0; 3];
        for patch in set.iter() {
            let patch = &patches[patch];
            points.extend_from_slice(&patch.points);
            outward = add(outward, patch.outward);
        }
        let hull = GrowingHull::new(&points, outward);
        Self { patches: set.clone(), hull, vertices: Vec::new(), inner_points: Vec::new() }
    }
}
