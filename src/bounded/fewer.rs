//! Fewer hulls than the bound asks for: the cap on hulls, and the tree of joins that is made on demand, in
//! the input's units.

use super::certify;
use super::finish::Finished;
use super::seed_set::SeedSet;
use super::seeds::Seeds;
use super::solid::Solid;
use super::tree::Tree;
use super::{BALANCED, Tuning, clustered, solid};
use crate::control::Control;
use crate::decomposition::{Hull, HullErrors, Provenance};
use crate::error::Error;
use crate::geometry::MeshView;
use crate::hull::ConvexHull;
use crate::mesh::Normalization;
use crate::parallel;
use crate::parameters::Parameters;

/// Joins hulls until no more than `most` are left.
pub(super) fn fewer(
    hulls: &[Finished],
    most: usize,
    seeds: &Seeds,
    solid: &Solid,
    tuning: &Tuning,
    control: &Control,
) -> Result<Vec<Finished>, Error> {
    let leaves = hulls.iter().map(|hull| (hull.hull.clone(), hull.phantom)).collect();
    let tree = Tree::new(leaves, most, solid, tuning, control)?;
    let mut fewer = Vec::new();
    for index in tree.state(tree.joins()) {
        let leaves = tree.leaves_of(index);
        let members: Vec<&Finished> = leaves.iter().filter_map(|&leaf| hulls.get(leaf)).collect();
        let Some(first) = members.first() else { continue };
        let node = &tree.nodes[index];
        let largest = |value: fn(&Finished) -> f64| {
            members.iter().map(|&hull| value(hull)).fold(0.0, f64::max)
        };
        let mut set = SeedSet::none(seeds.count());
        members.iter().for_each(|hull| set.unite(&hull.seeds));
        // Of a divided seed another hull may stand for the rest.
        let has_parts = members.iter().any(|hull| hull.part.is_some());
        let part =
            has_parts.then(|| members.iter().flat_map(|hull| hull.triangles(seeds)).collect());
        fewer.push(Finished {
            hull: node.hull.clone(),
            seeds: set,
            part,
            inner: Vec::new(),
            added_thickness: largest(|hull| hull.added_thickness),
            cap_growth: node.growth.max(largest(|hull| hull.cap_growth)),
            phantom: node.phantom,
            left_out: largest(|hull| hull.left_out),
            component: first.component,
        });
    }
    Ok(fewer)
}

/// The tree of joins of hulls that were returned, in the input's units.
#[derive(Debug, Clone)]
pub(crate) struct Merging {
    tree: Tree,
    normalization: Normalization,
    surface: crate::mesh::TriangleMesh,
    /// Surface less far outside, in diagonals, does not matter.
    enough: f64,
}

impl Merging {
    pub(crate) fn new(
        mesh: MeshView<'_>,
        hulls: &[Hull],
        parameters: &Parameters,
        control: &Control,
    ) -> Result<Self, Error> {
        let prepared = crate::mesh::repair::prepare(mesh, control)?;
        let tuning = Tuning::new(parameters, prepared.normalization.diagonal, &BALANCED);
        let normalization = prepared.normalization;
        let tree = parallel::with(control.is_parallel(), || {
            let clustered = clustered(&prepared, &tuning, control)?;
            let solid = solid(&prepared, clustered, &tuning, control)?;
            let mut leaves = Vec::with_capacity(hulls.len());
            for (index, Hull { shape: hull, errors, .. }) in hulls.iter().enumerate() {
                let points: Vec<[f64; 3]> =
                    hull.points.iter().map(|&point| normalization.normalize(point)).collect();
                if hull.triangles.as_flattened().iter().any(|&v| v as usize >= points.len()) {
                    let reason = "a triangle names a point that it does not have";
                    return Err(Error::UnusableHull { hull: index, reason });
                }
                let convex = ConvexHull { points, triangles: hull.triangles.clone() };
                let phantom = match errors.protrusion_max {
                    Some(phantom) => phantom / normalization.diagonal,
                    None => {
                        certify::phantom(&convex, &solid, tuning.bound, f64::INFINITY, control)?
                    }
                };
                leaves.push((convex, phantom));
            }
            Tree::new(leaves, 1, &solid, &tuning, control)
        })?;
        Ok(Self { tree, normalization, surface: prepared.mesh, enough: tuning.enough })
    }

    pub(crate) fn joins(&self) -> usize {
        self.tree.joins()
    }

    /// The farthest that a hull stands out after some joins, in the input's units.
    pub(crate) fn phantom(&self, joins: usize) -> f64 {
        let state = self.tree.state(joins);
        let phantoms = state.iter().map(|&index| self.tree.nodes[index].phantom);
        phantoms.fold(0.0, f64::max) * self.normalization.diagonal
    }

    /// How far the surface lies outside all hulls, in the input's units.
    pub(crate) fn exposed(&self, hulls: &[Hull], control: &Control) -> Result<f64, Error> {
        let outsides: Vec<certify::Outside<'_>> = self.tree.nodes
            [..self.tree.leaves.min(hulls.len())]
            .iter()
            .map(|node| certify::Outside::new(&node.hull))
            .collect();
        let owners = vec![0; self.surface.triangles.len()];
        let exposed = certify::exposed(&self.surface, &owners, &outsides, self.enough, control)?;
        Ok(exposed * self.normalization.diagonal)
    }

    /// The hulls after some joins, in the input's units.
    pub(crate) fn hulls(&self, joins: usize, leaves: &[Hull]) -> Vec<Hull> {
        let state = self.tree.state(joins);
        let hulls = state.into_iter().filter_map(|index| {
            let members = self.tree.leaves_of(index);
            let first = leaves.get(*members.first()?)?;
            let node = &self.tree.nodes[index];
            if node.children.is_none() {
                return Some(first.clone());
            }
            let points =
                node.hull.points.iter().map(|&point| self.normalization.restore(point)).collect();
            let of = |value: fn(&Hull) -> f64| {
                members.iter().filter_map(|&m| leaves.get(m)).map(value).fold(0.0, f64::max)
            };
            let mut source_triangles: Vec<u32> = members
                .iter()
                .filter_map(|&member| leaves.get(member))
                .flat_map(|leaf| leaf.provenance.source_triangles.iter().copied())
                .collect();
            source_triangles.sort_unstable();
            source_triangles.dedup();
            Some(Hull {
                shape: ConvexHull { points, triangles: node.hull.triangles.clone() },
                provenance: Provenance { component: first.provenance.component, source_triangles },
                errors: HullErrors {
                    added_thickness: of(|hull| hull.errors.added_thickness),
                    simplification_growth: (node.growth * self.normalization.diagonal)
                        .max(of(|hull| hull.errors.simplification_growth)),
                    protrusion_max: Some(node.phantom * self.normalization.diagonal),
                },
            })
        });
        hulls.collect()
    }
}
