//! Group merging [3.6]: groups of one or two polygons join a neighbour that they share two or
//! three sides with, unless they are large.
//!
//! Where the paper is silent: it is the polygon that is moved (of a group of two each for
//! itself), sides towards the polygon's own group don't count for a neighbour, three sides count
//! before two by nature (there are only three), the receiving group must be larger than the one
//! that gives, and the bounding box that guards is that of the small group, against a share of
//! the diagonal of the mesh.

use crate::geometry::vector::diagonal;
use crate::mesh::TriangleMesh;
use crate::mesh::adjacency::{Adjacency, NO_NEIGHBOUR};
use crate::mesh::grouping::{Grouping, corners, members};

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
