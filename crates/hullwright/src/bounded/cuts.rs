//! Cuts: triangles are split along the curve in which a plane meets the surface, as far as the
//! curve is connected with a notch and no earlier cut stops it.

use std::collections::{BTreeMap, BTreeSet};

use crate::geometry::vector::{Vector, area_normal};
use crate::mesh::TriangleMesh;
use crate::mesh::refine::edge;

/// Squared area of a corner, as a share of the largest, that is rounding.
const FLAT: f64 = 1e-16;

/// A mesh that is being cut.
pub(super) struct CutMesh {
    pub mesh: TriangleMesh,
    /// For each triangle the original one that it is a part of.
    pub parents: Vec<u32>,
    /// For each triangle its planar group.
    pub labels: Vec<u32>,
    /// Edges that cuts run along, the smaller vertex first.
    pub walls: BTreeSet<(u32, u32)>,
}

impl CutMesh {
    pub(super) fn new(mesh: TriangleMesh, labels: Vec<u32>) -> Self {
        let parents = (0..mesh.triangles.len() as u32).collect();
        Self { mesh, parents, labels, walls: BTreeSet::new() }
    }
}

/// Where the curve enters or leaves a triangle: a crossed edge, or a vertex, twice.
type Port = (u32, u32);

/// A part of the curve: across a triangle, or along an edge in the plane.
struct Segment {
    ports: [Port; 2],
    /// The triangle that it crosses.
    triangle: Option<u32>,
}

/// Cuts along a plane, given by heights over it, from the edges of notches on. O(n) for n
/// triangles, and O(m log m) for m of them in the plane.
pub(super) fn cut(
    mesh: &mut CutMesh,
    height: impl Fn(Vector) -> f64,
    starts: impl Iterator<Item = (u32, u32)>,
    flatness: f64,
) {
    let side = |point: &Vector| {
        let height = height(*point);
        if height.abs() <= flatness { 0.0 } else { height }
    };
    let heights: Vec<f64> = mesh.mesh.points().iter().map(side).collect();
    let segments = segments(&mesh.mesh.triangles, &heights);
    let reached = reached(&segments, starts, &mesh.walls);
    let mut middles: BTreeMap<(u32, u32), u32> = BTreeMap::new();
    let mut chords: BTreeMap<u32, [u32; 2]> = BTreeMap::new();
    for (segment, _) in segments.iter().zip(reached).filter(|&(_, is_reached)| is_reached) {
        let ends =
            segment.ports.map(|port| vertex_at(port, &heights, &mut mesh.mesh, &mut middles));
        mesh.walls.insert(edge(ends[0], ends[1]));
        if let Some(triangle) = segment.triangle {
            chords.insert(triangle, ends);
        }
    }
    if !middles.is_empty() {
        split_walls(&mut mesh.walls, &middles);
    }
    if !chords.is_empty() || !middles.is_empty() {
        split(mesh, &chords, &middles);
    }
}

/// The segments of the whole curve. Edges in the plane come once for each triangle beside them.
fn segments(triangles: &[[u32; 3]], heights: &[f64]) -> Vec<Segment> {
    let mut segments = Vec::new();
    for (index, &triangle) in (0_u32..).zip(triangles) {
        let sides = triangle.map(|vertex| heights[vertex as usize]);
        let zeros = sides.iter().filter(|&&side| side == 0.0).count();
        let is_crossed = sides.iter().any(|&s| s > 0.0) && sides.iter().any(|&s| s < 0.0);
        if !(is_crossed || zeros == 2) {
            continue;
        }
        let mut ports: Vec<Port> = Vec::with_capacity(2);
        for k in 0..3 {
            let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
            let (from, to) = (sides[k], sides[(k + 1) % 3]);
            if from == 0.0 {
                ports.push((a, a));
            }
            if from * to < 0.0 {
                ports.push(edge(a, b));
            }
        }
        if let [first, second] = ports[..] {
            let triangle = is_crossed.then_some(index);
            segments.push(Segment { ports: [first, second], triangle });
        }
    }
    segments
}

/// Which segments are connected with an edge of `starts`, without passing walls.
fn reached(
    segments: &[Segment],
    starts: impl Iterator<Item = (u32, u32)>,
    walls: &BTreeSet<(u32, u32)>,
) -> Vec<bool> {
    let stops: BTreeSet<Port> = walls.iter().flat_map(|&(a, b)| [(a, a), (b, b), (a, b)]).collect();
    let mut at_port: Vec<(Port, u32)> = (0_u32..)
        .zip(segments)
        .flat_map(|(index, segment)| segment.ports.map(|port| (port, index)))
        .collect();
    at_port.sort_unstable();
    let mut reached = vec![false; segments.len()];
    let mut seen: BTreeSet<Port> = BTreeSet::new();
    let mut stack: Vec<Port> = starts.flat_map(|(a, b)| [(a, a), (b, b)]).collect();
    seen.extend(&stack);
    while let Some(port) = stack.pop() {
        let first = at_port.partition_point(|entry| entry.0 < port);
        for &(_, index) in at_port[first..].iter().take_while(|entry| entry.0 == port) {
            reached[index as usize] = true;
            for next in segments[index as usize].ports {
                if !stops.contains(&next) && seen.insert(next) {
                    stack.push(next);
                }
            }
        }
    }
    reached
}

/// The vertex at a port: a new one on a crossed edge.
fn vertex_at(
    port: Port,
    heights: &[f64],
    mesh: &mut TriangleMesh,
    middles: &mut BTreeMap<(u32, u32), u32>,
) -> u32 {
    let (a, b) = port;
    if a == b {
        return a;
    }
    *middles.entry(port).or_insert_with(|| {
        let [p, q] = [a, b].map(|vertex| mesh.points()[vertex as usize]);
        let share = heights[a as usize] / (heights[a as usize] - heights[b as usize]);
        mesh.positions.push((p + (q - p) * share).to_array());
        mesh.positions.len() as u32 - 1
    })
}

/// Divides walls at new vertices.
fn split_walls(walls: &mut BTreeSet<(u32, u32)>, middles: &BTreeMap<(u32, u32), u32>) {
    for (&(a, b), &middle) in middles {
        if walls.remove(&(a, b)) {
            walls.insert(edge(a, middle));
            walls.insert(edge(middle, b));
        }
    }
}

/// Splits triangles along their chord, and at new vertices on their edges.
fn split(cut: &mut CutMesh, chords: &BTreeMap<u32, [u32; 2]>, middles: &BTreeMap<(u32, u32), u32>) {
    let mut triangles = Vec::with_capacity(cut.mesh.triangles.len() + 2 * chords.len());
    let (mut parents, mut labels) = (Vec::new(), Vec::new());
    for (index, &triangle) in (0_u32..).zip(&cut.mesh.triangles) {
        let before = triangles.len();
        let mut outline = Vec::with_capacity(6);
        for k in 0..3 {
            outline.push(triangle[k]);
            outline.extend(middles.get(&edge(triangle[k], triangle[(k + 1) % 3])));
        }
        let places = chords
            .get(&index)
            .map(|ends| ends.map(|end| outline.iter().position(|&vertex| vertex == end)));
        match places {
            Some([Some(first), Some(second)]) => {
                let (first, second) = (first.min(second), first.max(second));
                let inner = outline[first..=second].to_vec();
                let outer = [&outline[second..], &outline[..=first]].concat();
                fill(inner, cut.mesh.points(), &mut triangles);
                fill(outer, cut.mesh.points(), &mut triangles);
            }
            _ if outline.len() > 3 => fill(outline, cut.mesh.points(), &mut triangles),
            _ => triangles.push(triangle),
        }
        let parts = triangles.len() - before;
        parents.extend(std::iter::repeat_n(cut.parents[index as usize], parts));
        labels.extend(std::iter::repeat_n(cut.labels[index as usize], parts));
    }
    cut.mesh.triangles = triangles;
    cut.parents = parents;
    cut.labels = labels;
}

/// Triangulates a convex polygon that may have vertices on its sides, by cutting off its smallest
/// corner that has an area.
fn fill(mut outline: Vec<u32>, positions: &[Vector], triangles: &mut Vec<[u32; 3]>) {
    while outline.len() > 3 {
        let count = outline.len();
        let corner =
            |k: usize| [outline[(k + count - 1) % count], outline[k], outline[(k + 1) % count]];
        let area = |triangle: [u32; 3]| {
            let [a, b, c] = triangle.map(|vertex| positions[vertex as usize]);
            area_normal(a, b, c).length_squared()
        };
        let largest = (0..count).map(|k| area(corner(k))).fold(0.0, f64::max);
        let best = (0..count)
            .map(|k| (area(corner(k)), k))
            .filter(|&(area, _)| area > FLAT * largest)
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let k = best.map_or(0, |best| best.1);
        triangles.push(corner(k));
        outline.remove(k);
    }
    if let [a, b, c] = outline[..] {
        triangles.push([a, b, c]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::join;

    const FLATNESS: f64 = 1e-3;

    /// Three triangles that cover a rectangle of 2 by 1, with a vertex in the middle of its lower
    /// side only.
    fn rectangle() -> CutMesh {
        let positions = [[0, 0], [1, 0], [2, 0], [2, 1], [0, 1]];
        let positions = positions.map(|[x, y]| [f64::from(x), f64::from(y), 0.0]).to_vec();
        let triangles = vec![[0, 1, 4], [1, 3, 4], [1, 2, 3]];
        CutMesh::new(TriangleMesh::new(positions, triangles), vec![5, 6, 7])
    }

    /// Four unit squares of two triangles. Vertex number is x + 3 y.
    fn squares() -> CutMesh {
        let positions = (0..9).map(|v| [f64::from(v % 3), f64::from(v / 3), 0.0]).collect();
        let two = |v: u32| [[v, v + 1, v + 4], [v, v + 4, v + 3]];
        let triangles: Vec<[u32; 3]> = [0, 1, 3, 4].into_iter().flat_map(two).collect();
        let labels = vec![0; triangles.len()];
        CutMesh::new(TriangleMesh::new(positions, triangles), labels)
    }

    fn areas(mesh: &TriangleMesh) -> Vec<f64> {
        let area = |&triangle: &[u32; 3]| {
            let [a, b, c] = mesh.corners(triangle);
            0.5 * area_normal(a, b, c).z
        };
        mesh.triangles.iter().map(area).collect()
    }

    #[test]
    fn a_cut_splits_the_triangles_that_it_crosses_and_no_others() {
        let mut cut_mesh = rectangle();
        cut(&mut cut_mesh, |point| point.x - 1.0, [(1, 1)].into_iter(), FLATNESS);
        assert_eq!(cut_mesh.parents, [0, 1, 1, 2]);
        assert_eq!(cut_mesh.labels, [5, 6, 6, 7]);
        assert_eq!(cut_mesh.mesh.positions[5..], [[1.0, 1.0, 0.0]]);
        assert_eq!(Vec::from_iter(cut_mesh.walls), [(1, 5)]);
        // None is turned over, and nothing is lost.
        let areas = areas(&cut_mesh.mesh);
        assert!(areas.iter().all(|&area| area > 0.0));
        assert_eq!(areas.iter().sum::<f64>(), 2.0);
    }

    #[test]
    fn a_cut_along_edges_splits_nothing() {
        let mut cut_mesh = squares();
        let before = cut_mesh.mesh.clone();
        cut(&mut cut_mesh, |point| point.x - 1.0, [(1, 4)].into_iter(), FLATNESS);
        assert!(cut_mesh.mesh == before);
        assert_eq!(Vec::from_iter(cut_mesh.walls), [(1, 4), (4, 7)]);
    }

    #[test]
    fn a_cut_ends_at_an_earlier_one() {
        let mut cut_mesh = squares();
        cut(&mut cut_mesh, |point| point.y - 1.0, [(3, 4)].into_iter(), FLATNESS);
        cut(&mut cut_mesh, |point| point.x - 1.0, [(1, 1)].into_iter(), FLATNESS);
        assert_eq!(Vec::from_iter(cut_mesh.walls), [(1, 4), (3, 4), (4, 5)]);
    }

    #[test]
    fn a_cut_stays_in_the_component_where_it_begins() {
        let CutMesh { mesh: first, .. } = rectangle();
        let mesh = join(&[first.clone(), first]);
        let mut cut_mesh = CutMesh::new(mesh, vec![0; 6]);
        cut(&mut cut_mesh, |point| point.x - 1.0, [(6, 6)].into_iter(), FLATNESS);
        assert_eq!(cut_mesh.parents, [0, 1, 2, 3, 4, 4, 5]);
    }

    #[test]
    fn a_vertex_within_the_flatness_is_in_the_plane() {
        for (offset, triangles) in [(0.5 * FLATNESS, 4), (2.0 * FLATNESS, 3)] {
            let mut cut_mesh = rectangle();
            let height = |point: Vector| point.x - 1.0 + offset;
            cut(&mut cut_mesh, height, [(1, 1)].into_iter(), FLATNESS);
            assert_eq!(cut_mesh.mesh.triangles.len(), triangles);
        }
    }

    #[test]
    fn a_cut_runs_on_across_the_edges_between_triangles() {
        let mut cut_mesh = rectangle();
        cut(&mut cut_mesh, |point| point.x - point.y, [(0, 0)].into_iter(), FLATNESS);
        assert_eq!(cut_mesh.parents, [0, 0, 1, 1, 1, 2]);
        assert_eq!(Vec::from_iter(cut_mesh.walls), [(0, 5), (5, 6)]);
        let areas = areas(&cut_mesh.mesh);
        assert!(areas.iter().all(|&area| area > 0.0), "{areas:?}");
        assert!((areas.iter().sum::<f64>() - 2.0).abs() < 1e-12);
    }

    #[test]
    fn a_wall_that_is_crossed_is_two_walls() {
        let mut walls = BTreeSet::from([(0, 3), (3, 4)]);
        split_walls(&mut walls, &BTreeMap::from([((0, 3), 9), ((1, 2), 10)]));
        assert_eq!(Vec::from_iter(walls), [(0, 9), (3, 4), (3, 9)]);
    }

    #[test]
    fn a_polygon_with_vertices_on_its_sides_has_no_triangle_without_area() {
        let outline = [[0, 0], [1, 0], [2, 0], [3, 0], [3, 3], [1, 3], [0, 3], [0, 2]];
        let positions = outline.map(|[x, y]| Vector::new(f64::from(x), f64::from(y), 0.0));
        let mut triangles = Vec::new();
        fill((0..8).collect(), &positions, &mut triangles);
        assert_eq!(triangles.len(), 6);
        let positions = positions.map(|point| point.to_array()).to_vec();
        let areas = areas(&TriangleMesh::new(positions, triangles));
        assert!(areas.iter().all(|&area| area > 0.1), "{areas:?}");
        assert_eq!(areas.iter().sum::<f64>(), 9.0);
    }
}
