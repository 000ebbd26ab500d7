//! A mesh cut by a plane in two, each closed where the whole is.
//!
//! A point where the plane meets an edge is made once for all triangles at that edge, so no crack
//! opens. What is left of edges in the plane forms loops, and polygons over these close both sides.

use std::collections::{BTreeMap, HashMap};

use super::cap::{Loop, cover};
use crate::geometry::plane::Plane;
use crate::geometry::vector::{Vector, area_normal};

/// Where a triangle is from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Origin {
    /// Part of this triangle of the mesh.
    Source(u32),
    /// Part of what would close an opening of the mesh, and is not drawn.
    Opening,
    /// Part of what closes this cut.
    Cut(u32),
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Face {
    pub corners: [u32; 3],
    pub origin: Origin,
}

/// A mesh that is cut: its vertices, and those that cuts add.
pub(super) struct Cutter {
    pub points: Vec<Vector>,
    /// For each vertex the connected part of the mesh that it belongs to.
    pub components: Vec<u32>,
    /// Vertices nearer to a plane lie in it.
    pub tolerance: f64,
    /// For each vertex of the mesh the one that stands for it.
    pub welded: Vec<u32>,
    /// What reaches no farther over a plane is not cut off: it would be a sliver.
    pub thinnest: f64,
    /// Whether triangles run clockwise seen from outside.
    pub is_inside_out: bool,
    /// Whether no edge was open before the first cut.
    pub is_closed: bool,
    pub cuts: u32,
}

/// A corner of a polygon, and whether it lies in the plane.
type Corner = (u32, bool);

/// A part of a mesh on one side of a plane.
#[derive(Default)]
struct Half {
    faces: Vec<Face>,
    /// Directed edges in the plane.
    edges: Vec<[u32; 2]>,
}

impl Half {
    /// Adds a triangle, or a polygon of four corners by its shorter diagonal.
    fn push(&mut self, polygon: &[Corner], origin: Origin, points: &[Vector]) {
        for (index, &(a, a_is_on)) in polygon.iter().enumerate() {
            let (b, b_is_on) = polygon[(index + 1) % polygon.len()];
            if a_is_on && b_is_on {
                self.edges.push([a, b]);
            }
        }
        let triangles: &[[usize; 3]] = match polygon {
            [_, _, _] => &[[0, 1, 2]],
            [a, b, c, d] => {
                let squared = |from: &Corner, to: &Corner| {
                    points[from.0 as usize].distance_squared(points[to.0 as usize])
                };
                match squared(a, c) <= squared(b, d) {
                    true => &[[0, 1, 2], [0, 2, 3]],
                    false => &[[0, 1, 3], [1, 2, 3]],
                }
            }
            _ => &[],
        };
        let face = |of: &[usize; 3]| Face { corners: of.map(|index| polygon[index].0), origin };
        self.faces.extend(triangles.iter().map(face));
    }
}

impl Cutter {
    /// The faces below and above a plane. O(n log n) for the n faces that it meets, apart from the
    /// polygons that close them.
    pub(super) fn cut(&mut self, faces: Vec<Face>, plane: &Plane) -> [Vec<Face>; 2] {
        let (mut below, mut above) = (Half::default(), Half::default());
        let mut crossings = HashMap::new();
        for Face { corners, origin } in faces {
            let heights = corners.map(|corner| {
                let height = plane.height(self.points[corner as usize]);
                if height.abs() <= self.tolerance { 0.0 } else { height }
            });
            let whole = [0, 1, 2].map(|k| (corners[k], heights[k] == 0.0));
            let reaches = |side: f64| heights.iter().any(|height| height * side > 0.0);
            match (reaches(-1.0), reaches(1.0)) {
                (true, false) => below.push(&whole, origin, &self.points),
                (false, true) => above.push(&whole, origin, &self.points),
                // Of a face in the plane the solid is behind.
                (false, false) => {
                    let [a, b, c] = corners.map(|corner| self.points[corner as usize]);
                    let faces_up = area_normal(a, b, c).dot(plane.normal) > 0.0;
                    let half = if faces_up != self.is_inside_out { &mut below } else { &mut above };
                    half.push(&whole, origin, &self.points);
                }
                (true, true) => {
                    let [low, high] = self.split(corners, heights, &mut crossings);
                    below.push(&low, origin, &self.points);
                    above.push(&high, origin, &self.points);
                }
            }
        }
        let origin = Origin::Cut(self.cuts);
        self.cuts += 1;
        let loops = loops(&rim(&below.edges, &above.edges));
        let loops: Vec<Loop> = loops.into_iter().map(|own| self.in_plane(own, plane)).collect();
        for [a, b, c] in cover(&loops) {
            below.faces.push(Face { corners: [a, b, c], origin });
            above.faces.push(Face { corners: [a, c, b], origin });
        }
        [below.faces, above.faces]
    }

    /// The polygons below and above a plane of a triangle on both sides of it.
    fn split(
        &mut self,
        corners: [u32; 3],
        heights: [f64; 3],
        crossings: &mut HashMap<[u32; 2], u32>,
    ) -> [Vec<Corner>; 2] {
        let [mut below, mut above] = [Vec::with_capacity(4), Vec::with_capacity(4)];
        for (k, next) in [(0, 1), (1, 2), (2, 0)] {
            let (corner, height) = (corners[k], heights[k]);
            if height <= 0.0 {
                below.push((corner, height == 0.0));
            }
            if height >= 0.0 {
                above.push((corner, height == 0.0));
            }
            if height * heights[next] < 0.0 {
                let ends = [(corner, height), (corners[next], heights[next])];
                let crossing = (self.crossing(ends, crossings), true);
                below.push(crossing);
                above.push(crossing);
            }
        }
        [below, above]
    }

    /// The vertex where an edge meets the plane, from its lower to its higher end, so that it does
    /// not depend on the triangle.
    fn crossing(&mut self, ends: [(u32, f64); 2], known: &mut HashMap<[u32; 2], u32>) -> u32 {
        let [mut low, mut high] = ends;
        if low.1 > high.1 {
            (low, high) = (high, low);
        }
        *known.entry([low.0, high.0]).or_insert_with(|| {
            let share = low.1 / (low.1 - high.1);
            let (from, to) = (self.points[low.0 as usize], self.points[high.0 as usize]);
            let vertex = self.points.len() as u32;
            self.points.push(from + (to - from) * share);
            self.components.push(self.components[low.0 as usize]);
            vertex
        })
    }

    /// A loop, seen from above the plane, so that it runs counter-clockwise around the solid.
    fn in_plane(&self, vertices: Vec<u32>, plane: &Plane) -> Loop {
        let (mut x, mut y) = plane.normal.any_orthonormal_pair();
        if self.is_inside_out {
            (x, y) = (y, x);
        }
        let flat = |&vertex: &u32| {
            let point = self.points[vertex as usize];
            [x.dot(point), y.dot(point)]
        };
        let component = vertices.first().map_or(0, |&first| self.components[first as usize]);
        Loop { points: vertices.iter().map(flat).collect(), vertices, component }
    }
}

/// The edges that a cap over the lower half has: where its faces end in the plane, and those of the
/// upper half go on.
fn rim(below: &[[u32; 2]], above: &[[u32; 2]]) -> Vec<[u32; 2]> {
    let mut counts: BTreeMap<[u32; 2], [i32; 2]> = BTreeMap::new();
    for (half, edges) in [below, above].into_iter().enumerate() {
        for &[a, b] in edges {
            counts.entry([a.min(b), a.max(b)]).or_default()[half] += if a < b { 1 } else { -1 };
        }
    }
    let mut rim = Vec::new();
    for ([a, b], [below, above]) in counts {
        if below.signum() != -above.signum() {
            continue;
        }
        let edge = if below > 0 { [b, a] } else { [a, b] };
        rim.extend((0..below.abs().min(above.abs())).map(|_| edge));
    }
    rim
}

/// The loops of directed edges, each of which meets each vertex once. Edges that lead nowhere, as
/// in an open mesh, are in none.
fn loops(edges: &[[u32; 2]]) -> Vec<Vec<u32>> {
    let mut from: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for &[a, b] in edges {
        from.entry(a).or_default().push(b);
    }
    let mut found = Vec::new();
    while let Some((&start, _)) = from.first_key_value() {
        let mut path = vec![start];
        let mut places = HashMap::from([(start, 0)]);
        while let Some(&last) = path.last() {
            let next = from.get_mut(&last).and_then(Vec::pop);
            if from.get(&last).is_some_and(Vec::is_empty) {
                from.remove(&last);
            }
            let Some(next) = next else {
                path.pop();
                places.remove(&last);
                continue;
            };
            match places.get(&next) {
                Some(&place) => {
                    let of_loop = path.split_off(place + 1);
                    of_loop.iter().for_each(|vertex| _ = places.remove(vertex));
                    found.push([next].into_iter().chain(of_loop).collect());
                }
                None => {
                    places.insert(next, path.len());
                    path.push(next);
                }
            }
        }
    }
    found
}
