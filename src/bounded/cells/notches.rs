//! Notches: reflex edges between planar groups that are deep enough to matter.

use super::edge;
use super::planar_groups::PlanarGroups;
use crate::geometry::vector::{Vector, cross, dot, length, normalize, subtract};
use crate::mesh::TriangleMesh;
use crate::mesh::adjacency::{Adjacency, NO_NEIGHBOUR};

/// Notches beyond this number are left out, the least important first: they make a surface that
/// its own small cells divide well, and comparing planes is quadratic.
const MAX_NOTCHES: usize = 512;

/// A reflex edge.
pub(super) struct Notch {
    pub edge: (u32, u32),
    /// Groups in whose planes a cut resolves it. Of groups in one plane the same one.
    pub planes: [u32; 2],
    /// How far a hull across it is from the edge.
    pub depth: f64,
    /// Its length times its depth.
    pub weight: f64,
}

impl Notch {
    /// The notch as its other plane resolves it, with a share of the weight; `None` if both planes
    /// are the same.
    pub(super) fn without(&self, plane: u32, share: f64) -> Option<Self> {
        let other = self.planes.into_iter().find(|&other| other != plane)?;
        Some(Self { planes: [other; 2], weight: share * self.weight, ..*self })
    }
}

/// The notches deeper than `least_depth`.
///
/// A hull of both groups bridges the notch. The notch's depth is the height of the triangle that
/// the edge forms with the far ends of both groups: how far the bridge is from the edge.
pub(super) fn notches(
    mesh: &TriangleMesh,
    adjacency: &Adjacency,
    groups: &PlanarGroups,
    flatness: f64,
    least_depth: f64,
) -> Vec<Notch> {
    let mut notches = Vec::new();
    for (triangle, corners) in (0_u32..).zip(&mesh.triangles) {
        for (k, other) in adjacency.triangle_neighbours(triangle).into_iter().enumerate() {
            if other == NO_NEIGHBOUR || other < triangle {
                continue;
            }
            let pair = [triangle, other].map(|t| groups.labels[t as usize]);
            let ends = [corners[k], corners[(k + 1) % 3]];
            if pair[0] == pair[1] {
                continue;
            }
            let Some(depth) = depth(mesh, groups, pair, ends) else { continue };
            if depth > least_depth {
                let [a, b] = ends.map(|vertex| mesh.positions[vertex as usize]);
                let weight = depth * length(subtract(b, a));
                notches.push(Notch { edge: edge(ends[0], ends[1]), planes: pair, depth, weight });
            }
        }
    }
    notches.sort_by(|a, b| b.weight.total_cmp(&a.weight).then(a.edge.cmp(&b.edge)));
    notches.truncate(MAX_NOTCHES);
    unify_planes(mesh, groups, &mut notches, flatness);
    notches
}

/// The depth of the notch at an edge of the first group's outline; `None` if the edge is convex.
fn depth(
    mesh: &TriangleMesh,
    groups: &PlanarGroups,
    pair: [u32; 2],
    ends: [u32; 2],
) -> Option<f64> {
    let [from, to] = ends.map(|vertex| mesh.positions[vertex as usize]);
    let along = normalize(subtract(to, from));
    let normals = pair.map(|group| groups.planes[group as usize].normal);
    // Into each face, at right angles to the edge.
    let inward = [cross(normals[0], along), cross(along, normals[1])];
    // Reflex where the second face rises in front of the first.
    if dot(normals[0], inward[1]) <= 0.0 && dot(normals[1], inward[0]) <= 0.0 {
        return None;
    }
    let width = |side: usize| {
        let reach =
            |&vertex: &u32| dot(inward[side], subtract(mesh.positions[vertex as usize], from));
        groups.vertices[pair[side] as usize].iter().map(reach).fold(0.0, f64::max)
    };
    let widths = [width(0), width(1)];
    let far = [0, 1].map(|side| inward[side].map(|x| widths[side] * x));
    let doubled_area = length(cross(far[0], far[1]));
    let chord = length(subtract(far[0], far[1]));
    Some(if chord > 0.0 { doubled_area / chord } else { widths[0] })
}

/// Names planes by the first group that has them, whichever way it faces.
fn unify_planes(mesh: &TriangleMesh, groups: &PlanarGroups, notches: &mut [Notch], flatness: f64) {
    let mut used: Vec<u32> = notches.iter().flat_map(|notch| notch.planes).collect();
    used.sort_unstable();
    used.dedup();
    // For each group that is used its name. Groups count up by falling area.
    let mut names: Vec<u32> = Vec::with_capacity(used.len());
    for (place, &group) in used.iter().enumerate() {
        let is_in = |other: u32| {
            let plane = groups.planes[other as usize];
            let near = |position: Vector| plane.height(position).abs() <= flatness;
            groups.vertices[group as usize].iter().all(|&v| near(mesh.positions[v as usize]))
        };
        let same = (0..place).find(|&other| names[other] == used[other] && is_in(used[other]));
        names.push(same.map_or(group, |other| used[other]));
    }
    for plane in notches.iter_mut().flat_map(|notch| &mut notch.planes) {
        if let Ok(place) = used.binary_search(plane) {
            *plane = names[place];
        }
    }
}
