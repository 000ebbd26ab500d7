//! Facets: the surface of a coarse mesh, divided where its shape requires it.
//!
//! A facet is a planar part of the surface. Where faces meet at a reflex edge (a notch), no hull
//! that fits holds both sides of it. The solid is cut along the plane of one of the faces
//! (Chazelle, "Convex partitions of polyhedra", 1984: one plane resolves a notch), and the cut's
//! curve on the surface bounds facets. So hulls end where the shape does, at any bound.
//!
//! 1. Triangles in one plane form a group.
//! 2. Reflex edges between groups are notches, each with its depth.
//! 3. Triangles are split along planes, those that resolve the most notches first.
//!
//! O(n log n) for n triangles and each plane.

use super::cuts::{CutMesh, cut};
use super::settings::Settings;
use crate::geometry::plane::Plane;
use crate::geometry::vector::Vector;
use crate::mesh::TriangleMesh;
use crate::mesh::adjacency::{Adjacency, NO_NEIGHBOUR};
use crate::mesh::refine::edge;
use crate::sorting::{sort_by, sort_by_number};

/// Vertices this near to a plane are in it, as a fraction of the bound. A hull may leave as much
/// uncovered.
const FLATNESS: f64 = 0.05;

/// A notch that is less deep needs no cut: a hull across it protrudes by its depth at most. As a
/// fraction of the bound.
const LEAST_DEPTH: f64 = 1.5;

/// Planes that a mesh is cut along at most, those of the most important notches: curved concave
/// surfaces have a notch at each edge, and their facets are small without cuts.
const MAX_PLANES: usize = 48;

/// No cut once there are this many triangles for each of the mesh's own, and [`MAX_ADDED`] more:
/// the time of the stages after this one grows with the triangles.
const MAX_GROWTH: usize = 3;

/// Small meshes may grow by more, a box with many notches above all.
const MAX_ADDED: usize = 1000;

/// Notches beyond this number are left out, the least important first: they make a surface that
/// its own small facets divide well, and comparing planes is quadratic.
const MAX_NOTCHES: usize = 512;

/// Cosine of the greatest angle between a triangle and its group's plane. Slivers are in the plane
/// by their vertices, whatever their normal; of others the distance of their vertices from the
/// plane decides first.
const MIN_COSINE: f64 = 0.9;

/// A triangle of a height below this multiple of the flatness is a sliver: its vertices may be off
/// by the flatness on either side, so its normal means nothing.
const SLIVER: f64 = 2.0;

/// A surface divided into facets.
pub(super) struct Facets {
    pub mesh: TriangleMesh,
    /// For each triangle the original one that it is a part of.
    pub parents: Vec<u32>,
    /// For each triangle its planar group.
    pub planes: Vec<u32>,
    /// For each triangle its facet: the part of its planar group between cuts that it is in.
    pub facets: Vec<u32>,
}

/// Divides a surface into facets.
pub(super) fn facets(mesh: &TriangleMesh, settings: &Settings) -> Facets {
    let bound = settings.bound.verified();
    let flatness = FLATNESS * bound;
    let adjacency = Adjacency::new(mesh);
    let groups = planar_groups(mesh, &adjacency, flatness);
    let notches = notches(mesh, &adjacency, &groups, LEAST_DEPTH * bound);
    let mut cut_mesh = CutMesh::new(mesh.clone(), groups.labels.clone());
    cut_along(&mut cut_mesh, &groups, notches);
    let CutMesh { mesh, parents, labels: planes, walls } = cut_mesh;
    let is_wall = |triangle: u32, k: usize, other: u32| {
        let corners = mesh.triangles[triangle as usize];
        planes[triangle as usize] != planes[other as usize]
            || walls.contains(&edge(corners[k], corners[(k + 1) % 3]))
    };
    let facets = components(&Adjacency::new(&mesh), is_wall);
    Facets { mesh, parents, planes, facets }
}

/// Cuts along the planes that resolve the most notches, by length times depth, until each notch is
/// resolved.
fn cut_along(mesh: &mut CutMesh, groups: &PlanarGroups, mut notches: Vec<Notch>) {
    let most_triangles = MAX_GROWTH * mesh.mesh.triangles.len() + MAX_ADDED;
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
        let (resolved, open): (Vec<Notch>, Vec<Notch>) =
            notches.into_iter().partition(|notch| notch.planes.contains(&plane));
        notches = open;
        let starts = resolved.iter().map(|notch| notch.edge);
        let plane = groups.planes[plane as usize];
        cut(mesh, |position| plane.height(position), starts, groups.flatness);
        if mesh.mesh.triangles.len() > most_triangles {
            return;
        }
    }
}

/// For each triangle the connected part of the surface that it is in. Parts end where `is_wall`
/// holds for a triangle, its edge, and the neighbour there. They count up in the order of their
/// first triangles.
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

/// Groups, and their planes.
struct PlanarGroups {
    /// For each triangle its group.
    labels: Vec<u32>,
    /// For each group its plane, with the normal outward.
    planes: Vec<Plane>,
    /// For each group its vertices.
    vertices: Vec<Vec<u32>>,
    /// Vertices this near to a plane are in it.
    flatness: f64,
}

/// Groups triangles by planes. O(n log n).
fn planar_groups(mesh: &TriangleMesh, adjacency: &Adjacency, flatness: f64) -> PlanarGroups {
    let count = mesh.triangles.len();
    let corners = |t: usize| mesh.triangles[t].map(|vertex| mesh.points()[vertex as usize]);
    let normals: Vec<Vector> = (0..count as u32).map(|t| mesh.area_normal(t)).collect();
    let areas: Vec<f64> = normals.iter().map(|&normal| normal.length()).collect();
    let mut order: Vec<(f64, usize)> = areas.iter().map(|area| -area).zip(0..).collect();
    sort_by_number(&mut order);
    let (labels, planes, vertices) = (vec![u32::MAX; count], Vec::new(), Vec::new());
    let mut groups = PlanarGroups { labels, planes, vertices, flatness };
    let mut stack = Vec::new();
    for start in order.into_iter().map(|(_, start)| start as u32) {
        if groups.labels[start as usize] != u32::MAX {
            continue;
        }
        let label = groups.planes.len() as u32;
        let normal = normals[start as usize] * (1.0 / areas[start as usize].max(f64::MIN_POSITIVE));
        let [a, ..] = corners(start as usize);
        let plane = Plane { normal, offset: normal.dot(a) };
        let mut vertices = Vec::new();
        groups.labels[start as usize] = label;
        stack.push(start);
        while let Some(triangle) = stack.pop() {
            vertices.extend(mesh.triangles[triangle as usize]);
            for other in adjacency.triangle_neighbours(triangle) {
                if other == NO_NEIGHBOUR || groups.labels[other as usize] != u32::MAX {
                    continue;
                }
                let points = corners(other as usize);
                let is_flat = points.iter().all(|&point| plane.height(point).abs() <= flatness);
                let cosine_by_area = normals[other as usize].dot(normal);
                let area = areas[other as usize];
                if is_flat
                    && (cosine_by_area >= MIN_COSINE * area || is_sliver(points, area, flatness))
                {
                    groups.labels[other as usize] = label;
                    stack.push(other);
                }
            }
        }
        vertices.sort_unstable();
        vertices.dedup();
        groups.planes.push(plane);
        groups.vertices.push(vertices);
    }
    groups
}

/// Whether a triangle's height over its longest side is so small that its normal means little.
fn is_sliver([a, b, c]: [Vector; 3], doubled_area: f64, flatness: f64) -> bool {
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    doubled_area <= SLIVER * flatness * longest
}

/// A reflex edge.
struct Notch {
    edge: (u32, u32),
    /// Groups in whose planes a cut resolves it. Of groups in one plane the same one.
    planes: [u32; 2],
    /// Its length times its depth: how far a hull across it is from the edge.
    weight: f64,
}

/// The notches deeper than `least_depth`.
///
/// A hull of both groups bridges the notch. The notch's depth is the height of the triangle that
/// the edge forms with the far ends of both groups: how far the bridge is from the edge.
fn notches(
    mesh: &TriangleMesh,
    adjacency: &Adjacency,
    groups: &PlanarGroups,
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
                let [a, b] = ends.map(|vertex| mesh.points()[vertex as usize]);
                let weight = depth * b.distance(a);
                notches.push(Notch { edge: edge(ends[0], ends[1]), planes: pair, weight });
            }
        }
    }
    sort_by(&mut notches, |a, b| b.weight.total_cmp(&a.weight).then(a.edge.cmp(&b.edge)));
    notches.truncate(MAX_NOTCHES);
    unify_planes(mesh, groups, &mut notches);
    notches
}

/// The depth of the notch at an edge of the first group's outline; `None` if the edge is convex.
fn depth(
    mesh: &TriangleMesh,
    groups: &PlanarGroups,
    pair: [u32; 2],
    ends: [u32; 2],
) -> Option<f64> {
    let [from, to] = ends.map(|vertex| mesh.points()[vertex as usize]);
    let along = (to - from).normalize_or_zero();
    let normals = pair.map(|group| groups.planes[group as usize].normal);
    // Into each face, at right angles to the edge.
    let inward = [normals[0].cross(along), along.cross(normals[1])];
    // Reflex where the second face rises in front of the first.
    if normals[0].dot(inward[1]) <= 0.0 && normals[1].dot(inward[0]) <= 0.0 {
        return None;
    }
    let width = |side: usize| {
        let extent = |&vertex: &u32| inward[side].dot(mesh.points()[vertex as usize] - from);
        groups.vertices[pair[side] as usize].iter().map(extent).fold(0.0, f64::max)
    };
    let widths = [width(0), width(1)];
    let far = [0, 1].map(|side| inward[side].map(|x| widths[side] * x));
    let doubled_area = far[0].cross(far[1]).length();
    let chord = far[0].distance(far[1]);
    Some(if chord > 0.0 { doubled_area / chord } else { widths[0] })
}

/// Names planes by the first group that has them, whichever way it faces.
fn unify_planes(mesh: &TriangleMesh, groups: &PlanarGroups, notches: &mut [Notch]) {
    let mut used: Vec<u32> = notches.iter().flat_map(|notch| notch.planes).collect();
    used.sort_unstable();
    used.dedup();
    // For each group that is used its name. Groups count up by falling area.
    let mut names: Vec<u32> = Vec::with_capacity(used.len());
    for (place, &group) in used.iter().enumerate() {
        let is_in = |other: u32| {
            let plane = groups.planes[other as usize];
            let near = |position: Vector| plane.height(position).abs() <= groups.flatness;
            groups.vertices[group as usize].iter().all(|&v| near(mesh.points()[v as usize]))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounded::fixture::{l_prism, u_prism};
    use crate::mesh::Normalization;
    use crate::mesh::shapes::cuboid;
    use crate::parameters::{Length, Parameters};

    /// The mesh is divided as it is: its own unit is that of the bound.
    fn divided(mesh: &TriangleMesh, bound: f64) -> Facets {
        let parameters = Parameters::default().with_max_error(Length::share(bound));
        facets(mesh, &Settings::of_preset(&parameters, &Normalization::UNIT)[0])
    }

    fn count(labels: &[u32]) -> usize {
        let mut labels = labels.to_vec();
        labels.sort_unstable();
        labels.dedup();
        labels.len()
    }

    fn notches_of(mesh: &TriangleMesh, least_depth: f64) -> Vec<Notch> {
        let adjacency = Adjacency::new(mesh);
        let groups = planar_groups(mesh, &adjacency, 1e-3);
        notches(mesh, &adjacency, &groups, least_depth)
    }

    #[test]
    fn a_box_is_not_cut_and_has_a_facet_for_each_face() {
        let mesh = cuboid([0.0; 3], [1.0, 2.0, 3.0]);
        let Facets { mesh: cut_mesh, parents, planes, facets } = divided(&mesh, 0.02);
        assert!(cut_mesh == mesh);
        assert_eq!(parents, Vec::from_iter(0..12));
        assert_eq!([count(&planes), count(&facets)], [6, 6]);
    }

    #[test]
    fn the_notch_of_an_l_prism_is_cut_along_the_plane_of_one_of_its_faces() {
        let mesh = l_prism();
        let Facets { mesh: cut_mesh, parents, planes, facets } = divided(&mesh, 0.02);
        // The plane divides both lids and one side.
        assert_eq!([count(&planes), count(&facets)], [8, 11]);
        assert!((cut_mesh.area() - mesh.area()).abs() < 1e-12);
        assert!(parents.is_sorted() && count(&parents) == mesh.triangles.len());
    }

    #[test]
    fn of_three_planes_at_two_notches_the_one_that_resolves_both_is_cut_along() {
        let Facets { mesh, facets, .. } = divided(&u_prism(), 0.02);
        // The floor of the U divides both lids in three, and the two outer sides.
        assert_eq!(count(&facets), 10 + 2 * 2 + 2);
        let is_at_floor = |k: usize| mesh.positions[k][1] == 1.0;
        assert!((16..mesh.positions.len()).all(is_at_floor));
    }

    #[test]
    fn a_notch_less_deep_than_one_and_a_half_bounds_is_not_cut() {
        let depth = 0.5_f64.sqrt();
        for (multiple, facets) in [(1.51, 11), (1.49, 8)] {
            assert_eq!(count(&divided(&l_prism(), depth / multiple).facets), facets);
        }
    }

    #[test]
    fn a_notch_weighs_its_length_times_its_depth() {
        assert!(notches_of(&cuboid([0.0; 3], [1.0; 3]), 0.0).is_empty());
        let notches = notches_of(&l_prism(), 0.0);
        let [notch] = &notches[..] else { panic!("{} notches", notches.len()) };
        assert!((notch.weight - 0.5_f64.sqrt()).abs() < 1e-12);
        // Vertex 3 of the outline, in both lids.
        assert_eq!(notch.edge, (3, 9));
        assert_eq!(notches_of(&u_prism(), 0.0).len(), 2);
    }

    #[test]
    fn faces_in_one_plane_have_one_name_at_all_notches() {
        // Two ridges on a plate: four notches, all beside the plane between and beside the ridges.
        let heights = [0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0];
        let widths = [0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 5.0];
        let rows = widths.into_iter().zip(heights);
        let positions = rows.flat_map(|(x, z)| [[x, 0.0, z], [x, 1.0, z]]).collect();
        let strip = (0..9).flat_map(|k| {
            let [a, b, c, d] = [2 * k, 2 * k + 2, 2 * k + 3, 2 * k + 1];
            [[a, b, c], [a, c, d]]
        });
        let mesh = TriangleMesh::new(positions, strip.collect());
        let notches = notches_of(&mesh, 0.1);
        assert_eq!(notches.len(), 4);
        let common = |plane| notches.iter().all(|notch| notch.planes.contains(plane));
        assert!(notches[0].planes.iter().any(common));
    }

    #[test]
    fn a_face_that_is_bent_by_less_than_the_flatness_is_one_group() {
        for (bend, groups) in [(0.5e-3, 6), (0.2, 7)] {
            let mut mesh = cuboid([0.0; 3], [1.0; 3]);
            mesh.positions[7][2] += bend;
            let labels = planar_groups(&mesh, &Adjacency::new(&mesh), 1e-3).labels;
            assert_eq!(count(&labels), groups, "{bend}");
        }
    }

    #[test]
    fn a_sliver_is_lower_than_twice_the_flatness() {
        let with_height = |height| [Vector::ZERO, Vector::X, Vector::new(0.4, height, 0.0)];
        for (height, expected) in [(0.019, true), (0.021, false)] {
            assert_eq!(is_sliver(with_height(height), height, 0.01), expected);
        }
    }

    #[test]
    fn components_end_at_walls_and_count_up_by_their_first_triangles() {
        let adjacency = Adjacency::new(&cuboid([0.0; 3], [1.0; 3]));
        assert_eq!(components(&adjacency, |_, _, _| false), [0; 12]);
        // Two triangles to a side.
        let is_wall = |triangle: u32, _: usize, other: u32| triangle / 2 != other / 2;
        let sides = components(&adjacency, is_wall);
        assert_eq!(sides, [0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5]);
    }
}
