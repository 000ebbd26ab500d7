//! From groups to hulls [3.6]: small groups merge; then the hull of each group, and the source
//! triangles that it stands for.
//!
//! Group merging: groups of one or two polygons join a neighbour that they share two or
//! three sides with, unless they are large.
//!
//! Where the paper is silent: it is the polygon that is moved (of a group of two each for
//! itself), sides towards the polygon's own group don't count for a neighbour, three sides count
//! before two by nature (there are only three), the receiving group must be larger than the one
//! that gives, and the bounding box that guards is that of the small group, against a share of
//! the diagonal of the mesh.

use std::borrow::Cow;

use crate::bvh::{Bvh, closest_labels};
use crate::control::{Control, Stage};
use crate::decomposition::{GroupedMesh, Hull, HullErrors, Provenance};
use crate::error::Error;
use crate::geometry::vector::{Vector, area_normal, as_arrays, as_vectors, diagonal};
use crate::hull::{ConvexHull, HullBuilder, LEAST_THICKNESS, limit_vertices, solid_hull};
use crate::mesh::adjacency::{Adjacency, NO_NEIGHBOUR};
use crate::mesh::grouping::{Grouping, corners, group_vertices, members};
use crate::mesh::{Normalization, PreparedMesh, TriangleMesh};
use crate::stages::Stages;

/// Groups of at most this many polygons may be merged away.
const SMALL: usize = 2;

/// Merges small groups until nothing changes; labels stay in order, without gaps. A group whose
/// diagonal is at least `significant` stays.
pub fn merge_groups(
    mesh: &TriangleMesh,
    adjacency: &Adjacency,
    grouping: &Grouping,
    significant: f64,
) -> Grouping {
    let mut labels = grouping.labels.clone();
    let mut groups = members(&labels, grouping.count);
    loop {
        let mut changed = false;
        for group in 0..groups.len() {
            if groups[group].is_empty() || groups[group].len() > SMALL {
                continue;
            }
            let extent = groups[group].iter().flat_map(|&triangle| corners(mesh, triangle));
            if diagonal(extent) >= significant {
                continue;
            }
            for triangle in groups[group].clone() {
                let Some(target) = enclosing_group(adjacency, &labels, &groups, triangle) else {
                    continue;
                };
                groups[group].retain(|&other| other != triangle);
                groups[target as usize].push(triangle);
                labels[triangle as usize] = target;
                changed = true;
            }
        }
        if !changed {
            break;
        }
    }
    without_gaps(&labels, groups.len())
}

/// The larger group that a polygon shares at least two sides with.
fn enclosing_group(
    adjacency: &Adjacency,
    labels: &[u32],
    groups: &[Vec<u32>],
    triangle: u32,
) -> Option<u32> {
    let own = labels[triangle as usize];
    let across = adjacency
        .triangle_neighbours(triangle)
        .map(|neighbour| if neighbour == NO_NEIGHBOUR { own } else { labels[neighbour as usize] });
    let larger = |group: u32| groups[group as usize].len() > groups[own as usize].len();
    across.into_iter().find(|&group| {
        let shared = across.iter().filter(|&&other| other == group).count();
        group != own && shared >= 2 && larger(group)
    })
}

/// Numbers the labels that are in use from 0 up, in their order.
fn without_gaps(labels: &[u32], count: usize) -> Grouping {
    let mut numbers = vec![0; count];
    for &label in labels {
        numbers[label as usize] = 1;
    }
    let mut next = 0;
    for number in &mut numbers {
        let used = *number;
        *number = next;
        next += used;
    }
    let labels = labels.iter().map(|&label| numbers[label as usize]).collect();
    Grouping { labels, count: next as usize }
}

/// A mesh whose triangles are grouped: each group is a piece, and becomes a hull.
#[derive(Debug, Clone, Copy)]
pub struct Pieces<'a> {
    /// The prepared mesh, or a simplified one, in normalised coordinates.
    pub mesh: &'a TriangleMesh,
    /// For each triangle its component.
    pub components: &'a [u32],
    /// For each triangle its group.
    pub grouping: &'a Grouping,
}

impl Pieces<'_> {
    /// The hull of each group, in the input's units, without its source triangles.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn hulls(
        &self,
        normalization: &Normalization,
        max_vertices: Option<usize>,
        control: &Control,
    ) -> Result<Vec<Hull>, Error> {
        let mesh = self.mesh;
        let mut builder = HullBuilder::new();
        let groups = members(&self.grouping.labels, self.grouping.count);
        let mut hulls = Vec::with_capacity(groups.len());
        for group in &groups {
            control.check()?;
            let vertices = group_vertices(mesh, group);
            let points: Vec<Vector> =
                vertices.iter().map(|&vertex| mesh.points()[vertex as usize]).collect();
            let outward = group.iter().fold(Vector::ZERO, |sum, &triangle| {
                let [a, b, c] = corners(mesh, triangle);
                sum + area_normal(a, b, c)
            });
            let (solid, added) =
                solid_hull(&mut builder, as_arrays(&points), outward.to_array(), LEAST_THICKNESS)?;
            let (solid, growth) = match max_vertices {
                Some(most) => limit_vertices(&mut builder, solid, most, control)?,
                None => (solid, 0.0),
            };
            let component = group.first().map_or(0, |&triangle| self.components[triangle as usize]);
            let points =
                solid.points().iter().map(|&point| normalization.restore(point).into()).collect();
            hulls.push(Hull {
                shape: ConvexHull { points, triangles: solid.triangles },
                provenance: Provenance { component, source_triangles: Vec::new() },
                errors: HullErrors {
                    added_thickness: added * normalization.diagonal,
                    simplification_growth: growth * normalization.diagonal,
                    protrusion_max: None,
                },
            });
        }
        Ok(hulls)
    }

    /// Gives each source triangle to the hull whose group holds the simplified triangle nearest to
    /// its centre, for no more triangles than `closest_labels` compares. O(n log m) for n source
    /// and m simplified triangles.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn assign_source_triangles(
        &self,
        prepared: &PreparedMesh,
        hulls: &mut [Hull],
        control: &Control,
    ) -> Result<(), Error> {
        let labels = if self.mesh.triangles == prepared.mesh.triangles {
            Cow::Borrowed(&self.grouping.labels)
        } else {
            let bvh = Bvh::new(self.mesh.points(), &self.mesh.triangles);
            let TriangleMesh { positions, triangles, .. } = &prepared.mesh;
            let grouped = &self.grouping.labels;
            Cow::Owned(closest_labels(as_vectors(positions), triangles, &bvh, grouped, control)?)
        };
        for (&label, &source) in labels.iter().zip(&prepared.source_triangles) {
            if let Some(hull) = hulls.get_mut(label as usize) {
                hull.provenance.source_triangles.push(source);
            }
        }
        for hull in hulls {
            hull.provenance.source_triangles.sort_unstable();
            // A triangle that repair split in two is still one of the source.
            hull.provenance.source_triangles.dedup();
        }
        Ok(())
    }

    /// Both of the above, as the last stages of a method.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub(crate) async fn finish(
        &self,
        prepared: &PreparedMesh,
        max_vertices: Option<usize>,
        stages: &mut Stages,
    ) -> Result<Vec<Hull>, Error> {
        let control = &stages.control();
        let make = || self.hulls(&prepared.normalization, max_vertices, control);
        let mut hulls = stages.run(Stage::Hulls, make).await?;
        let assign = || self.assign_source_triangles(prepared, &mut hulls, control);
        stages.run(Stage::Assign, assign).await?;
        Ok(hulls)
    }

    /// The mesh and its groups, in the input's units.
    pub(crate) fn grouped_mesh(&self, normalization: &Normalization) -> GroupedMesh {
        let positions = self.mesh.points().iter();
        GroupedMesh {
            positions: positions.map(|&point| normalization.restore(point).into()).collect(),
            triangles: self.mesh.triangles.clone(),
            groups: self.grouping.labels.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fan of triangles around vertex 0.
    fn fan(count: u32) -> TriangleMesh {
        let rim = (0..count).map(|i| {
            let angle = f64::from(i) * std::f64::consts::TAU / f64::from(count);
            [angle.cos(), angle.sin(), 0.0]
        });
        let positions = std::iter::once([0.0; 3]).chain(rim).collect();
        let triangles = (0..count).map(|i| [0, 1 + i, 1 + (i + 1) % count]).collect();
        TriangleMesh::new(positions, triangles)
    }

    fn merged(labels: &[u32], significant: f64) -> Grouping {
        let mesh = fan(labels.len() as u32);
        let count = labels.iter().max().map_or(0, |&label| label as usize + 1);
        let grouping = Grouping { labels: labels.to_vec(), count };
        merge_groups(&mesh, &Adjacency::new(&mesh), &grouping, significant)
    }

    #[test]
    fn a_polygon_with_two_sides_at_a_larger_group_joins_it() {
        assert_eq!(merged(&[0, 0, 1, 0, 0, 0], 10.0), Grouping { labels: vec![0; 6], count: 1 });
    }

    #[test]
    fn a_polygon_between_two_groups_stays() {
        assert_eq!(merged(&[0, 0, 0, 1, 2, 2, 2], 10.0).count, 3);
    }

    #[test]
    fn a_small_group_that_is_large_in_space_stays() {
        assert_eq!(merged(&[0, 0, 1, 0, 0, 0], 0.1).count, 2);
    }

    #[test]
    fn groups_of_three_stay() {
        assert_eq!(merged(&[0, 0, 1, 1, 1, 0, 0], 10.0).count, 2);
    }

    #[test]
    fn merging_repeats_until_nothing_changes_and_leaves_no_gaps() {
        let grouping = merged(&[0, 1, 0, 2, 0, 3, 3, 3], 10.0);
        assert_eq!(grouping.labels, [0, 0, 0, 2, 0, 1, 1, 1].map(|l| if l == 2 { 0 } else { l }));
        assert_eq!(grouping.count, 2);
    }
}
