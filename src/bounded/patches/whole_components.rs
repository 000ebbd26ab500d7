//! Components whose hull fits are one patch each, above all convex ones.

use super::patch::{Patch, far_pair};
use super::patch_mesh::PatchMesh;
use crate::bounded::containment::fit_tester::FitTester;
use crate::bounded::containment::solid::Solid;
use crate::bounded::growing_hull::GrowingHull;
use crate::bounded::settings::Settings;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, length_squared, subtract};
use crate::hull::HullBuilder;
use crate::mesh::grouping::members;
use crate::parallel;

/// Points of a whole component nearer to its hull than this share of its thickness are left out.
/// With the patch tolerance alone, a thin plate would keep hardly more than four corners.
const TOLERANCE_OF_THICKNESS: f64 = 0.02;

/// The components that are one patch.
pub(super) struct WholeComponents {
    /// For each component whether it is one.
    pub is_whole: Vec<bool>,
    pub patches: Vec<Patch>,
    /// For each triangle its patch, if its component is whole.
    pub labels: Vec<u32>,
}

impl WholeComponents {
    /// # Errors
    /// [`Error::Cancelled`].
    pub(super) fn find(
        mesh: &PatchMesh,
        solid: &Solid,
        settings: &Settings,
        control: &Control,
    ) -> Result<Self, Error> {
        let count = mesh.components.iter().max().map_or(0, |&last| last as usize + 1);
        let components = members(&mesh.components, count);
        let patches = parallel::map_largest_first(&components, Vec::len, |triangles| {
            control.check()?;
            Ok(whole_patch(mesh, triangles, solid, settings))
        });
        let mut whole = Self {
            is_whole: vec![false; count],
            patches: Vec::new(),
            labels: vec![0_u32; mesh.mesh.triangles.len()],
        };
        for (component, (triangles, patch)) in components.iter().zip(patches).enumerate() {
            let Some(patch) = patch? else { continue };
            whole.is_whole[component] = true;
            for &triangle in triangles {
                whole.labels[triangle as usize] = whole.patches.len() as u32;
            }
            whole.patches.push(patch);
        }
        Ok(whole)
    }
}

/// The patch of a component, if its hull fits.
fn whole_patch(
    mesh: &PatchMesh,
    triangles: &[u32],
    solid: &Solid,
    settings: &Settings,
) -> Option<Patch> {
    let mut vertices: Vec<Vector> =
        triangles.iter().flat_map(|&triangle| mesh.corners(triangle)).collect();
    vertices.dedup();
    // Two far points rule out most components that do not fit.
    let pair = far_pair(&vertices);
    let is_separated =
        |pair: &[Vector]| matches!(pair, &[a, b] if solid.separates(a, b, settings.bound.search()));
    if triangles.is_empty() || is_separated(&pair) {
        return None;
    }
    let mut tester = FitTester::new(solid, settings.bound.search());
    let coarse = GrowingHull::new(&vertices, [0.0; 3]);
    if coarse.is_solid && !tester.fits(&coarse, false) {
        return None;
    }
    let thickness = coarse.volume / length_squared(subtract(coarse.max, coarse.min));
    let tolerance = match coarse.is_solid {
        true => settings.bound.tolerance().min(TOLERANCE_OF_THICKNESS * thickness),
        false => settings.bound.tolerance(),
    };
    let mut reducer = HullBuilder::new().with_least_tolerance(tolerance);
    let patch = mesh.patch(triangles, &mut reducer);
    tester.fits(&GrowingHull::new(&patch.points, patch.outward), false).then_some(patch)
}
