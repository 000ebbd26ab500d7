//! What the stages take, made from small meshes of known shape.

use super::finalize::final_hull::{FinalHull, Owned};
use super::patch::{PatchSet, Patches, Piece};
use super::patch_mesh::PatchMesh;
use super::patches::divide_into_patches;
use super::search::Search;
use super::settings::Settings;
use super::surfaces::{Solids, Surfaces, simplify, solids};
use crate::control::Control;
use crate::geometry::TriangleMesh;
use crate::geometry::vector::as_arrays;
use crate::hull::convex_hull;
use crate::mesh::PreparedMesh;
use crate::mesh::canonical_order::MeshOrder;
use crate::mesh::repair::prepare;
use crate::mesh::shapes::{cuboid, join};
use crate::parameters::{Length, Parameters};

/// All that a search looks at.
pub(super) struct Fixture {
    pub prepared: PreparedMesh,
    pub surfaces: Surfaces,
    pub solids: Solids,
    pub patches: Patches,
    pub settings: Settings,
    pub control: Control,
}

impl Fixture {
    /// The patches of a mesh under a bound, as a fraction of the diagonal.
    pub fn new(mesh: &TriangleMesh, bound: f64) -> Self {
        Self::with(mesh, &Parameters::default().with_max_error(Length::share(bound)))
    }

    pub fn with(mesh: &TriangleMesh, parameters: &Parameters) -> Self {
        let control = Control::new();
        let prepared = prepare(mesh.view(), MeshOrder::Place, &control).unwrap();
        let settings = &Settings::of_preset(parameters, &prepared.normalization)[0];
        let surfaces = simplify(&prepared, None, settings, &control).unwrap();
        let settings = settings.for_surface(surfaces.exact.mesh.triangles.len());
        let solids = solids(&surfaces, None, &settings, &control).unwrap();
        let divided =
            PatchMesh::new(&surfaces.coarse, &solids.coarse, &settings, &control).unwrap();
        let solid = &solids.coarse;
        let patches = divide_into_patches(divided, &surfaces, solid, &settings, &control).unwrap();
        Self { prepared, surfaces, solids, patches, settings, control }
    }

    pub fn search(&self) -> Search<'_> {
        Search::new(&self.surfaces, &self.solids, &self.patches, &self.settings, &self.control)
    }

    pub fn set(&self, patches: impl IntoIterator<Item = u32>) -> PatchSet {
        PatchSet::new(self.patches.count(), patches)
    }

    pub fn piece(&self, patches: impl IntoIterator<Item = u32>) -> Piece {
        Piece::new(&self.patches, &self.set(patches))
    }

    /// For each patch its hull, as if it was verified. The patches have volume.
    pub fn hulls_of_patches(&self) -> Vec<FinalHull> {
        let hull = |(index, patch): (u32, &super::patch::Patch)| FinalHull {
            hull: convex_hull(as_arrays(&patch.points)).unwrap(),
            owned: Owned { patches: self.set([index]), part: None, inner_points: Vec::new() },
            added_thickness: 0.0,
            simplification_growth: 0.0,
            protrusion: 0.0,
            uncovered: 0.0,
            component: patch.component,
        };
        (0..).zip(&self.patches.patches).map(hull).collect()
    }

    /// How often each triangle of the surface is owned by hulls.
    pub fn owners(&self, hulls: &[FinalHull]) -> Vec<u32> {
        let mut owners = vec![0; self.patches.surface.triangles.len()];
        for hull in hulls {
            let own = hull.owned.triangles(&self.patches);
            own.for_each(|triangle| owners[triangle as usize] += 1);
        }
        owners
    }
}

/// How often each of some patches is in sets.
pub(super) fn times_in<'a>(count: usize, sets: impl Iterator<Item = &'a PatchSet>) -> Vec<u32> {
    let mut times = vec![0; count];
    sets.flat_map(PatchSet::iter).for_each(|patch| times[patch as usize] += 1);
    times
}

/// Unit cubes in a row along the x-axis, given by where they begin. Each is one patch.
pub(super) fn cubes<const N: usize>(at: [f64; N]) -> TriangleMesh {
    join(&at.map(|x| cuboid([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0])))
}

/// An outline, counter-clockwise and covered by convex quadrilaterals, extruded from z = 0 to 1.
fn prism(outline: &[[f64; 2]], quadrilaterals: &[[u32; 4]]) -> TriangleMesh {
    let count = outline.len() as u32;
    let at_height = |z: f64| outline.iter().map(move |&[x, y]| [x, y, z]);
    let positions = at_height(0.0).chain(at_height(1.0)).collect();
    let lids = quadrilaterals.iter().flat_map(|quadrilateral| {
        let [a, b, c, d] = quadrilateral.map(|vertex| vertex + count);
        let [p, q, r, s] = *quadrilateral;
        [[a, b, c], [a, c, d], [p, r, q], [p, s, r]]
    });
    let sides = (0..count).flat_map(|a| {
        let b = (a + 1) % count;
        [[a, b, b + count], [a, b + count, a + count]]
    });
    TriangleMesh::new(positions, lids.chain(sides).collect())
}

/// A square of side 2 without one of its four unit squares, extruded by 1: one notch, of depth
/// 1/√2 and length 1. The diagonal is 3.
pub(super) fn l_prism() -> TriangleMesh {
    let outline = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
    prism(&outline, &[[0, 1, 2, 3], [0, 3, 4, 5]])
}

/// Three unit squares in a row, with another one on the first and on the last, extruded by 1: two
/// notches with one face between them.
pub(super) fn u_prism() -> TriangleMesh {
    let upper = [[2.0, 2.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0]];
    let outline = [&[[0.0, 0.0], [3.0, 0.0], [3.0, 2.0]], &upper[..], &[[0.0, 2.0]]].concat();
    prism(&outline, &[[0, 1, 4, 5], [1, 2, 3, 4], [0, 5, 6, 7]])
}
