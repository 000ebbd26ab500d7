//! Cells: the surface of a coarse mesh, divided where its shape asks for it.
//!
//! A cell is a planar part of the surface. Where faces meet at a reflex edge, no hull that fits
//! holds both sides of the notch. The solid is cut along the plane of one of the faces (Chazelle,
//! "Convex partitions of polyhedra", 1984: one plane resolves a notch), and the cut's curve on the
//! surface bounds cells. So hulls end where the shape does, at any bound.
//!
//! | file | step |
//! |---|---|
//! | `planar_groups` | triangles in one plane form a group |
//! | `notches` | reflex edges between groups, and how deep they are |
//! | `cut` | triangles are split along a plane, from its notches on |

mod cut;
mod notches;
mod planar_groups;

use super::refine::refine;
use super::settings::Settings;
use crate::mesh::TriangleMesh;
use crate::mesh::adjacency::{Adjacency, NO_NEIGHBOUR};
use cut::{CutMesh, cut};
use notches::{Notch, notches};
use planar_groups::{PlanarGroups, planar_groups};

/// Vertices this near to a plane, in bounds, are in it. A hull may leave as much uncovered.
const FLATNESS: f64 = 0.05;

/// A notch that is less deep, in bounds, does not ask for a cut: a hull across it protrudes by its
/// depth at most. With 0.5, 19 hard props had 303 hulls instead of 309, in 16 % more time.
const LEAST_DEPTH: f64 = 1.5;

/// Notches up to this deep, in bounds, may be bridged in part: hulls that end between them are
/// fewer than the pieces between cuts. Where there are such notches, each is cut along both of its
/// planes, and cells are divided further.
const SHALLOW: f64 = 2.0;

/// The weight of a notch's second plane: all notches are resolved by one plane first.
const SECOND_WEIGHT: f64 = 0.3;

/// Longest edge in diagonals where there are shallow notches. With 0.15 the same 19 props had 288
/// hulls instead of 289, in 36 % more time.
const LONGEST_EDGE: f64 = 0.25;

/// Planes that a mesh is cut along at most, those of the most important notches: curved concave
/// surfaces have a notch at each edge, and their cells are small without cuts.
const MAX_PLANES: usize = 48;

/// No cut once there are this many triangles for each of the mesh's own, and some.
const MAX_GROWTH: usize = 3;
const MAX_ADDED: usize = 1000;

/// A surface divided into cells.
pub(super) struct Cells {
    pub mesh: TriangleMesh,
    /// For each triangle the original one that it is a part of.
    pub parents: Vec<u32>,
    /// For each triangle its planar group.
    pub planes: Vec<u32>,
    /// For each triangle the part of its planar group between cuts that it is in.
    pub parts: Vec<u32>,
    /// For each triangle its cell: the whole part, or the triangle alone where cells were divided.
    pub cells: Vec<u32>,
}

/// Divides a surface into cells. O(n log n) for n triangles and each plane.
pub(super) fn cells(mesh: &TriangleMesh, settings: &Settings) -> Cells {
    let flatness = FLATNESS * settings.bound.protrusion();
    let adjacency = Adjacency::new(mesh);
    let groups = planar_groups(mesh, &adjacency, flatness);
    let deepest = SHALLOW * settings.bound.protrusion();
    let notches =
        notches(mesh, &adjacency, &groups, flatness, LEAST_DEPTH * settings.bound.protrusion());
    let is_shallow = notches.iter().any(|notch| notch.depth <= deepest);
    let mut cut_mesh = CutMesh::new(mesh.clone(), groups.labels.clone());
    let most = MAX_GROWTH * mesh.triangles.len() + MAX_ADDED;
    cut_along(&mut cut_mesh, &groups, notches, flatness, most, is_shallow);
    let CutMesh { mut mesh, mut parents, labels: mut planes, walls } = cut_mesh;
    let is_wall = |triangle: u32, k: usize, other: u32| {
        let corners = mesh.triangles[triangle as usize];
        planes[triangle as usize] != planes[other as usize]
            || walls.contains(&edge(corners[k], corners[(k + 1) % 3]))
    };
    let mut parts = components(&Adjacency::new(&mesh), is_wall);
    let mut cells = parts.clone();
    if is_shallow {
        let origins = refine(&mut mesh, LONGEST_EDGE);
        for labels in [&mut parents, &mut planes, &mut parts] {
            *labels = origins.iter().map(|&origin| labels[origin as usize]).collect();
        }
        cells = (0..mesh.triangles.len() as u32).collect();
    }
    Cells { mesh, parents, planes, parts, cells }
}

/// Cuts along the planes that resolve the most notches, by length times depth, until each notch is
/// resolved.
fn cut_along(
    mesh: &mut CutMesh,
    groups: &PlanarGroups,
    mut notches: Vec<Notch>,
    flatness: f64,
    most_triangles: usize,
    is_shallow: bool,
) {
    for _ in 0..MAX_PLANES {
        // Ascending by plane, so that equal sums do not depend on the order of notches.
        let mut sums: Vec<(u32, f64)> = Vec::new();
        for notch in &notches {
            for plane in notch.planes {
                match sums.binary_search_by_key(&plane, |entry| entry.0) {
                    Ok(place) => sums[place].1 += notch.weight,
                    Err(place) => sums.insert(place, (plane, notch.weight)),
                }
            }
        }
        let best = sums.into_iter().max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
        let Some((plane, _)) = best else { return };
        let (resolved, mut open): (Vec<Notch>, Vec<Notch>) =
            notches.into_iter().partition(|notch| notch.planes.contains(&plane));
        if is_shallow {
            open.extend(resolved.iter().filter_map(|notch| notch.without(plane, SECOND_WEIGHT)));
        }
        notches = open;
        let starts = resolved.iter().map(|notch| notch.edge);
        cut(mesh, groups.planes[plane as usize], starts, flatness);
        if mesh.mesh.triangles.len() > most_triangles {
            return;
        }
    }
}

/// For each triangle the connected part of the surface that it is in, where `is_wall` tells of a
/// triangle, its edge and the neighbour there whether parts end. Parts count up in the order of
/// their first triangles.
pub(super) fn components(
    adjacency: &Adjacency,
    is_wall: impl Fn(u32, usize, u32) -> bool,
) -> Vec<u32> {
    let triangles = adjacency.normals.len();
    let mut components = vec![u32::MAX; triangles];
    let mut count = 0;
    let mut stack = Vec::new();
    for start in 0..triangles {
        if components[start] != u32::MAX {
            continue;
        }
        components[start] = count;
        stack.push(start as u32);
        while let Some(triangle) = stack.pop() {
            for (k, other) in adjacency.triangle_neighbours(triangle).into_iter().enumerate() {
                if other != NO_NEIGHBOUR
                    && components[other as usize] == u32::MAX
                    && !is_wall(triangle, k, other)
                {
                    components[other as usize] = count;
                    stack.push(other);
                }
            }
        }
        count += 1;
    }
    components
}

/// An edge as the key of a map: the smaller vertex first.
fn edge(a: u32, b: u32) -> (u32, u32) {
    (a.min(b), a.max(b))
}
