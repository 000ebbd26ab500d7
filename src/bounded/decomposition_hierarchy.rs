//! The hierarchy of a finished decomposition, in the input's units. The solid is built anew: a
//! decomposition does not keep it.

use super::clustering::cluster;
use super::containment::solid::Solid;
use super::finalize::verify::hull_distance::HullDistance;
use super::finalize::verify::protrusion::protrusion;
use super::finalize::verify::uncovered::uncovered_distance;
use super::hierarchy::Hierarchy;
use super::output::{HullInDiagonals, normalized};
use super::settings::Settings;
use crate::control::Control;
use crate::decomposition::Hull;
use crate::error::Error;
use crate::mesh::{Normalization, PreparedMesh, TriangleMesh};
use crate::parameters::Parameters;

/// The joins of hulls that were returned.
#[derive(Debug, Clone)]
pub(crate) struct DecompositionHierarchy {
    hierarchy: Hierarchy,
    normalization: Normalization,
    surface: TriangleMesh,
    /// Uncovered surface nearer to a hull than this, in diagonals, counts as covered.
    cover_tolerance: f64,
}

impl DecompositionHierarchy {
    /// Joins hulls down to one. See [`Hierarchy::new`].
    ///
    /// # Errors
    /// [`Error::Cancelled`], and [`Error::UnusableHull`] for an inconsistent hull.
    pub(crate) fn new(
        prepared: PreparedMesh,
        hulls: &[Hull],
        parameters: &Parameters,
        control: &Control,
    ) -> Result<Self, Error> {
        let normalization = prepared.normalization;
        let settings = Settings::after_search(parameters, normalization.diagonal);
        let clustered = cluster(&prepared, &settings, control)?;
        let solid = Solid::new(&prepared, clustered, &settings, control)?;
        let mut leaves = Vec::with_capacity(hulls.len());
        for (index, hull) in hulls.iter().enumerate() {
            let (hull, verified) = normalized(hull, index, &normalization)?;
            let protrusion = match verified {
                Some(protrusion) => protrusion,
                None => {
                    protrusion(&hull, &solid, settings.bound.protrusion(), f64::INFINITY, control)?
                }
            };
            leaves.push((hull, protrusion));
        }
        Ok(Self {
            hierarchy: Hierarchy::new(leaves, 1, &solid, &settings, control)?,
            normalization,
            surface: prepared.mesh,
            cover_tolerance: settings.bound.tolerance(),
        })
    }

    /// The number of joins down to one hull.
    pub(crate) fn joins(&self) -> usize {
        self.hierarchy.joins()
    }

    /// The greatest protrusion of a hull after some joins, in the input's units.
    pub(crate) fn protrusion(&self, joins: usize) -> f64 {
        let state = self.hierarchy.state(joins);
        let protrusions = state.iter().map(|&index| self.hierarchy.nodes[index].protrusion);
        protrusions.fold(0.0, f64::max) * self.normalization.diagonal
    }

    /// The uncovered distance of the original hulls, in the input's units.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub(crate) fn uncovered(&self, control: &Control) -> Result<f64, Error> {
        let leaves = &self.hierarchy.nodes[..self.hierarchy.leaves];
        let distances: Vec<HullDistance<'_>> =
            leaves.iter().map(|node| HullDistance::new(&node.hull)).collect();
        let owners = vec![0; self.surface.triangles.len()];
        let uncovered =
            uncovered_distance(&self.surface, &owners, &distances, self.cover_tolerance, control)?;
        Ok(uncovered * self.normalization.diagonal)
    }

    /// The hulls after some joins, in the input's units. `originals` are those of
    /// [`new`](Self::new).
    pub(crate) fn hulls(&self, joins: usize, originals: &[Hull]) -> Vec<Hull> {
        let state = self.hierarchy.state(joins);
        state.into_iter().filter_map(|index| self.hull(index, originals)).collect()
    }

    /// For each join the two hulls that it joins, and the joint one. Hulls are numbered: the
    /// originals, then the joint ones.
    pub(crate) fn joint_hulls(
        &self,
        originals: &[Hull],
    ) -> impl Iterator<Item = ([usize; 2], Hull)> {
        let joints = self.hierarchy.leaves..self.hierarchy.nodes.len();
        joints.filter_map(|index| {
            let (first, second) = self.hierarchy.nodes[index].children?;
            Some(([first, second], self.hull(index, originals)?))
        })
    }

    /// An original or joint hull in the input's units.
    fn hull(&self, index: usize, originals: &[Hull]) -> Option<Hull> {
        let leaves = self.hierarchy.leaves_of(index);
        let members: Vec<&Hull> = leaves.iter().filter_map(|&leaf| originals.get(leaf)).collect();
        let first = *members.first()?;
        let node = &self.hierarchy.nodes[index];
        if node.children.is_none() {
            return Some(first.clone());
        }
        let largest =
            |value: fn(&Hull) -> f64| members.iter().map(|&hull| value(hull)).fold(0.0, f64::max);
        let source_triangles = members
            .iter()
            .flat_map(|hull| hull.provenance.source_triangles.iter().copied())
            .collect();
        let joint = HullInDiagonals {
            hull: &node.hull,
            component: first.provenance.component,
            source_triangles,
            added_thickness: 0.0,
            simplification_growth: node.growth,
            protrusion: node.protrusion,
        };
        let mut joint = joint.restored(&self.normalization);
        let errors = &mut joint.errors;
        errors.added_thickness = largest(|hull| hull.errors.added_thickness);
        errors.simplification_growth =
            errors.simplification_growth.max(largest(|hull| hull.errors.simplification_growth));
        Some(joint)
    }
}
