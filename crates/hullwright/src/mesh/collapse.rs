//! Edge collapses under a bound on how far the surface moves, both ways.
//!
//! A vertex collapses onto a neighbour: its star, the triangles around it, gives way to a fan
//! around the neighbour.
//!
//! ```text
//!      ╱╲                ╱╲
//!    ╱ │  ╲            ╱    ╲        u collapses onto v; the ring around u stays. Star and fan are graphs over one
//!   v──u───•          v──────•       plane: each point of one is above or below a point of the other.
//!    ╲ │  ╱            ╲    ╱
//!      ╲╱                ╲╱
//! ```
//!
//! The difference in height is linear between u, the ring, and the places where an edge of the star
//! crosses one of the fan, so that its maximum is at one of those (Cohen, Manocha, Olano,
//! "Successive mappings", 2003). Along a chain of collapses these distances add up. The sum bounds
//! the distance between the two surfaces in both directions, and since one is deformed into the
//! other, a point farther from the surface than that keeps its winding number.
//!
//! No collapse changes the topology: closed components stay closed, no two are joined, none
//! vanishes. Vertices on edges of more than two triangles stay. Each vertex of the result is one of
//! the source.
//!
//! Each pass visits all vertices once, and collapses those whose neighbourhood no earlier collapse
//! of the pass has changed. O(n) a pass for n triangles; a pass removes about a fifth of what can
//! go.

use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, area_normal, larger};

/// A vertex of more triangles stays until collapses around it have left fewer: the check is
/// quadratic in them.
const MAX_STAR: usize = 32;

/// Neighbours that are tried for a vertex, those nearest to the planes around it first.
const MAX_TRIED: usize = 3;

/// What is this near to a plane, as a fraction of what may move, is in it.
pub(super) const FLAT: f64 = 0.1;

/// A neighbour farther from a plane around the vertex than this multiple of what the surface may
/// still move is not tried: on a smooth surface the fan is about a quarter as far from the star as
/// that.
const HOPELESS: f64 = 4.0;

/// Cosine of the greatest angle between the normal of a triangle and the direction of the graph:
/// heights over steeper triangles are long.
const LEAST_COSINE: f64 = 0.05;

/// Least height of a new triangle over its longest side, as a fraction of the diagonal: the normal
/// of a thinner one is rounding.
const LEAST_HEIGHT: f64 = 1e-6;

/// Steps that look for a direction in which a star with a sharp edge is a graph.
const DIRECTION_STEPS: usize = 8;

/// Vertices between two checks for cancellation.
const VERTICES_PER_CHECK: usize = 4096;

/// What collapses have left.
pub(crate) struct Collapsed {
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle the one of the source whose place it has taken.
    pub origins: Vec<u32>,
    /// For each triangle of the source one that stands for the place where it was, or is next to
    /// that.
    pub owners: Vec<u32>,
    /// For each triangle how far what it stands for has moved at most.
    pub moved: Vec<f64>,
}

impl Collapsed {
    /// Before any collapse.
    pub(crate) fn unchanged(triangles: &[[u32; 3]]) -> Self {
        let count = triangles.len() as u32;
        Self {
            triangles: triangles.to_vec(),
            origins: (0..count).collect(),
            owners: (0..count).collect(),
            moved: vec![0.0; triangles.len()],
        }
    }
}

/// Collapses vertices, except locked ones, as long as nothing moves by more than the tolerance: at
/// first by no more than the first of its `shares`. A pass that removes no more than the fraction
/// `least` of the triangles is the last under its share. `points` are of a mesh with a diagonal of
/// about 1.
///
/// # Errors
/// [`Error::Cancelled`].
pub(crate) fn collapse(
    mesh: &mut Collapsed,
    points: &[Vector],
    is_locked: &[bool],
    tolerance: f64,
    (shares, least): (&[f64], f64),
    control: &Control,
) -> Result<(), Error> {
    let mut scratch = Scratch::new(points.len());
    for &share in shares {
        // Vertices that are visited: at first all, then those around which something has changed.
        let mut is_open: Vec<bool> = is_locked.iter().map(|locked| !locked).collect();
        loop {
            let before = mesh.triangles.len();
            let mut pass = Pass::new(points, mesh, &is_open, share * tolerance, &mut scratch);
            pass.run(control)?;
            let next = pass.next();
            keep_left(mesh, &next);
            let removed = before - mesh.triangles.len();
            if (removed as f64) <= least * before as f64 {
                break;
            }
            for (vertex, is_open) in is_open.iter_mut().enumerate() {
                *is_open = scratch.is_frozen[vertex] && !is_locked[vertex];
            }
        }
    }
    Ok(())
}

/// Stands for a triangle that is gone in a list of what becomes of triangles.
const GONE: u32 = u32::MAX;

/// Drops the triangles that are gone. `next`: see [`Pass::next`].
fn keep_left(mesh: &mut Collapsed, next: &[(u32, bool)]) {
    let mut kept = next.iter();
    mesh.triangles.retain(|_| kept.next().is_some_and(|&(_, is_left)| is_left));
    let mut kept = next.iter();
    mesh.origins.retain(|_| kept.next().is_some_and(|&(_, is_left)| is_left));
    let mut kept = next.iter();
    mesh.moved.retain(|_| kept.next().is_some_and(|&(_, is_left)| is_left));
    for owner in &mut mesh.owners {
        *owner = next[*owner as usize].0;
    }
}

/// Memory that passes share.
struct Scratch {
    /// For each vertex, where its triangles begin in `around`.
    starts: Vec<u32>,
    around: Vec<u32>,
    /// Vertices whose stars a collapse of this pass has changed.
    is_frozen: Vec<bool>,
    /// Those that have more triangles than `around` says.
    has_grown: Vec<bool>,
    /// For each triangle the one that takes its place, if it is gone.
    gone_to: Vec<u32>,
    star: Star,
    candidates: Vec<(f64, u32, usize)>,
}

impl Scratch {
    fn new(vertices: usize) -> Self {
        Self {
            starts: vec![0; vertices + 1],
            around: Vec::new(),
            is_frozen: Vec::new(),
            has_grown: Vec::new(),
            gone_to: Vec::new(),
            star: Star::default(),
            candidates: Vec::new(),
        }
    }

    /// The triangles at each vertex, by counting.
    fn begin(&mut self, triangles: &[[u32; 3]], vertices: usize) {
        let Self { starts, around, is_frozen, has_grown, gone_to, .. } = self;
        starts.clear();
        starts.resize(vertices + 1, 0);
        for &vertex in triangles.as_flattened() {
            starts[vertex as usize] += 1;
        }
        let mut sum = 0;
        for start in starts.iter_mut() {
            sum += *start;
            *start = sum;
        }
        around.clear();
        around.resize(3 * triangles.len(), 0);
        for (triangle, corners) in triangles.iter().enumerate().rev() {
            for &vertex in corners {
                let start = &mut starts[vertex as usize];
                *start -= 1;
                around[*start as usize] = triangle as u32;
            }
        }
        is_frozen.clear();
        is_frozen.resize(vertices, false);
        has_grown.clear();
        has_grown.resize(vertices, false);
        gone_to.clear();
        gone_to.resize(triangles.len(), GONE);
    }

    fn around(&self, vertex: u32) -> &[u32] {
        let vertex = vertex as usize;
        &self.around[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }
}

/// The triangles around a vertex, in order.
#[derive(Default)]
struct Star {
    triangles: Vec<u32>,
    /// Triangle `i` has the vertices `ring[i]` and the one after it. One more than there are
    /// triangles where the surface ends at the vertex.
    ring: Vec<u32>,
    /// The ring, relative to the place of the vertex.
    places: Vec<Vector>,
    /// Unit normals of the triangles.
    normals: Vec<Vector>,
    is_border: bool,
    /// How far the vertex moves to be on the line between its neighbours on the border.
    straightened: f64,
    /// The ring in the plane of the graph, and its heights.
    flat: Vec<[f64; 3]>,
}

/// One visit of all vertices.
struct Pass<'a> {
    points: &'a [Vector],
    mesh: &'a mut Collapsed,
    is_open: &'a [bool],
    tolerance: f64,
    scratch: &'a mut Scratch,
}

impl<'a> Pass<'a> {
    fn new(
        points: &'a [Vector],
        mesh: &'a mut Collapsed,
        is_open: &'a [bool],
        tolerance: f64,
        scratch: &'a mut Scratch,
    ) -> Self {
        scratch.begin(&mesh.triangles, points.len());
        Self { points, mesh, is_open, tolerance, scratch }
    }

    fn run(&mut self, control: &Control) -> Result<(), Error> {
        let mut star = std::mem::take(&mut self.scratch.star);
        for vertex in 0..self.points.len() as u32 {
            if (vertex as usize).is_multiple_of(VERTICES_PER_CHECK) {
                control.check()?;
            }
            if self.is_open[vertex as usize]
                && !self.scratch.is_frozen[vertex as usize]
                && self.find_star(vertex, &mut star)
                && let Some((onto, moved)) = self.best_neighbour(&mut star)
            {
                self.collapse(vertex, &star, onto, moved);
            }
        }
        self.scratch.star = star;
        Ok(())
    }

    /// For each triangle its index after the pass, or that of the one that takes its place, and
    /// whether it is left.
    fn next(&self) -> Vec<(u32, bool)> {
        let gone_to = &self.scratch.gone_to;
        let mut left = 0;
        let mut next: Vec<(u32, bool)> = Vec::with_capacity(gone_to.len());
        for &gone in gone_to {
            next.push((left, gone == GONE));
            left += u32::from(gone == GONE);
        }
        for (triangle, &gone) in gone_to.iter().enumerate() {
            if gone != GONE {
                next[triangle].0 = next[gone as usize].0;
            }
        }
        next
    }

    /// Finds the star of a vertex. `false` if it is not one disc, or half of one, or is too large.
    fn find_star(&self, vertex: u32, star: &mut Star) -> bool {
        let around = self.scratch.around(vertex);
        if around.len() > MAX_STAR || around.len() < 2 {
            return false;
        }
        // Each triangle as its edge across from the vertex.
        let mut edges = [(0_u32, 0_u32, 0_u32); MAX_STAR];
        let edges = &mut edges[..around.len()];
        for (edge, &triangle) in edges.iter_mut().zip(around) {
            let [a, b, c] = self.mesh.triangles[triangle as usize];
            *edge = match vertex {
                v if v == a => (b, c, triangle),
                v if v == b => (c, a, triangle),
                _ => (a, b, triangle),
            };
        }
        // A closed ring begins with its least vertex, whatever order the triangles have; an open
        // one where nothing comes before.
        let least = (0..edges.len()).min_by_key(|&index| edges[index].0).unwrap_or_default();
        edges.swap(0, least);
        let mut end = edges[0].1;
        let mut chained = 1;
        while let Some(next) = edges[chained..].iter().position(|edge| edge.0 == end) {
            edges.swap(chained, chained + next);
            end = edges[chained].1;
            chained += 1;
        }
        star.is_border = end != edges[0].0;
        while star.is_border
            && let Some(before) = edges[chained..].iter().position(|edge| edge.1 == edges[0].0)
        {
            edges[..=chained + before].rotate_right(1);
            chained += 1;
        }
        if chained < edges.len() {
            return false;
        }
        star.triangles.clear();
        star.triangles.extend(edges.iter().map(|edge| edge.2));
        star.ring.clear();
        star.ring.extend(edges.iter().map(|edge| edge.0));
        if star.is_border {
            star.ring.push(end);
        }
        let ring = &star.ring;
        if (1..ring.len()).any(|index| ring[..index].contains(&ring[index])) {
            return false;
        }
        self.place(vertex, star)
    }

    /// Where the ring is, relative to the vertex, and the normals of the star.
    fn place(&self, vertex: u32, star: &mut Star) -> bool {
        let point = |vertex: u32| self.points[vertex as usize];
        let Star { ring, places, normals, triangles, .. } = star;
        let mut origin = point(vertex);
        star.straightened = 0.0;
        if star.is_border {
            let (from, to) = (point(ring[0]), point(ring[ring.len() - 1]));
            let along = to - from;
            let share = (origin - from).dot(along) / along.length_squared();
            if !(share > 0.0 && share < 1.0) {
                return false;
            }
            let on_line = from + along * share;
            star.straightened = on_line.distance(origin);
            if star.straightened > self.tolerance {
                return false;
            }
            origin = on_line;
        }
        places.clear();
        places.extend(ring.iter().map(|&vertex| point(vertex) - origin));
        normals.clear();
        for index in 0..triangles.len() {
            let normal = places[index].cross(places[(index + 1) % places.len()]);
            let length = normal.length();
            if length <= 0.0 {
                return false;
            }
            normals.push(normal * (1.0 / length));
        }
        true
    }

    /// The vertex of the ring, by its place there, onto which the star collapses with the surface
    /// moving within the tolerance, and how far what the star stands for has moved then.
    fn best_neighbour(&mut self, star: &mut Star) -> Option<(usize, f64)> {
        let moved = star.triangles.iter().map(|&triangle| self.mesh.moved[triangle as usize]);
        let before = moved.fold(0.0, larger) + star.straightened;
        let rest = self.tolerance - before;
        if rest < 0.0 {
            return None;
        }
        let candidates = &mut self.scratch.candidates;
        candidates.clear();
        let last = star.ring.len() - 1;
        for (index, &place) in star.places.iter().enumerate() {
            if star.is_border && index != 0 && index != last {
                continue;
            }
            let heights = star.normals.iter().map(|normal| normal.dot(place).abs());
            let height = heights.fold(0.0, larger);
            if height <= HOPELESS * rest {
                candidates.push((height, star.ring[index], index));
            }
        }
        candidates.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let candidates = std::mem::take(&mut self.scratch.candidates);
        // In a plane all are as near, and those that come first may all lie on one line with
        // others.
        let in_plane = FLAT * self.tolerance;
        let is_tried = |&(tried, candidate): &(usize, &(f64, u32, usize))| {
            tried < MAX_TRIED || candidate.0 <= in_plane
        };
        let tried = candidates.iter().enumerate().take_while(is_tried);
        let found = tried.map(|(_, candidate)| candidate).find_map(|&(_, _, onto)| {
            let deviation = star.deviation(onto, rest)?;
            self.keeps_topology(star, onto).then_some((onto, before + deviation))
        });
        self.scratch.candidates = candidates;
        found
    }

    /// Whether the edge to a vertex of the ring can collapse: no other vertex of the ring is its
    /// neighbour, and no two triangles end with the same vertices.
    fn keeps_topology(&self, star: &Star, onto: usize) -> bool {
        let (ring, target) = (&star.ring, star.ring[onto]);
        if self.scratch.has_grown[target as usize] {
            return false;
        }
        let count = ring.len();
        let is_beside = |index: usize| match star.is_border {
            true => index.abs_diff(onto) == 1,
            false => index == (onto + 1) % count || onto == (index + 1) % count,
        };
        let others = (0..count).filter(|&index| index != onto && !is_beside(index));
        if others.into_iter().any(|index| self.are_neighbours(ring[index], target)) {
            return false;
        }
        // A ring of three around the vertex may be a triangle already.
        star.is_border
            || count > 3
            || !self.left_around(target).any(|triangle| {
                let corners = self.mesh.triangles[triangle as usize];
                ring.iter().all(|vertex| corners.contains(vertex))
            })
    }

    fn left_around(&self, vertex: u32) -> impl Iterator<Item = u32> + '_ {
        let is_left = |triangle: &u32| self.scratch.gone_to[*triangle as usize] == GONE;
        self.scratch.around(vertex).iter().copied().filter(is_left)
    }

    /// Whether an edge connects two vertices, of which the second has not grown.
    fn are_neighbours(&self, first: u32, second: u32) -> bool {
        let scratch = &self.scratch;
        let is_shorter = scratch.around(first).len() < scratch.around(second).len();
        let (from, to) = match is_shorter && !scratch.has_grown[first as usize] {
            true => (first, second),
            false => (second, first),
        };
        self.left_around(from).any(|triangle| self.mesh.triangles[triangle as usize].contains(&to))
    }

    /// Replaces the star by a fan.
    fn collapse(&mut self, vertex: u32, star: &Star, onto: usize, moved: f64) {
        let Star { triangles, ring, .. } = star;
        let (target, count) = (ring[onto], triangles.len());
        // The triangles beside the edge vanish. Their neighbours on the other side take their
        // place.
        let before = match onto.checked_sub(1) {
            Some(before) => Some(before),
            None => (!star.is_border).then_some(count - 1),
        };
        let after = (onto < count).then_some(onto);
        let beyond = |index: usize, step: usize| triangles[(index + step) % count];
        if let Some(before) = before {
            self.scratch.gone_to[triangles[before] as usize] = beyond(before, count - 1);
        }
        if let Some(after) = after {
            self.scratch.gone_to[triangles[after] as usize] = beyond(after, 1);
        }
        for (index, &triangle) in triangles.iter().enumerate() {
            if Some(index) != before && Some(index) != after {
                let corners = &mut self.mesh.triangles[triangle as usize];
                *corners = corners.map(|corner| if corner == vertex { target } else { corner });
                self.mesh.moved[triangle as usize] = moved;
            }
        }
        self.scratch.is_frozen[vertex as usize] = true;
        for &vertex in ring {
            self.scratch.is_frozen[vertex as usize] = true;
        }
        self.scratch.has_grown[target as usize] = true;
    }
}

impl Star {
    /// How far the fan around a vertex of the ring is from the star; `None` if that is more than
    /// `most`, or if they are no graphs over a common plane.
    fn deviation(&mut self, onto: usize, most: f64) -> Option<f64> {
        let count = self.triangles.len();
        let last = self.places.len();
        let new = (0..count)
            .map(|index| (index, (index + 1) % last))
            .filter(|&(from, to)| from != onto && to != onto);
        let mut fan_normals = [Vector::ZERO; MAX_STAR];
        let mut fans = 0;
        let apex = self.places[onto];
        for (from, to) in new.clone() {
            let (a, b) = (self.places[from], self.places[to]);
            let normal = area_normal(apex, a, b);
            let longest = a.distance_squared(b).max(a.distance_squared(apex));
            let longest = longest.max(b.distance_squared(apex)).sqrt();
            let length = normal.length();
            if length <= LEAST_HEIGHT * longest {
                return None;
            }
            fan_normals[fans] = normal * (1.0 / length);
            fans += 1;
        }
        if fans == 0 {
            return None;
        }
        let up = self.direction(&fan_normals[..fans])?;
        self.flatten(up);
        let heights = self.heights(onto, new, most)?;
        (heights <= most).then_some(heights)
    }

    /// A direction in which star and fan are graphs.
    fn direction(&self, fan: &[Vector]) -> Option<Vector> {
        let all = || self.normals.iter().chain(fan);
        let mut sum = all().fold(Vector::ZERO, |sum, &normal| sum + normal);
        for _ in 0..DIRECTION_STEPS {
            let up = sum.normalize_or_zero();
            let (cosine, worst) = all().map(|&normal| (up.dot(normal), normal)).fold(
                (f64::INFINITY, Vector::ZERO),
                |least, other| {
                    if other.0 < least.0 { other } else { least }
                },
            );
            if cosine >= LEAST_COSINE {
                return Some(up);
            }
            // Sharp edges with few triangles on one side: that side counts more.
            sum = up + worst;
        }
        None
    }

    /// The ring in a plane, and its heights over it.
    fn flatten(&mut self, up: Vector) {
        let across = up.any_orthonormal_vector();
        let other = up.cross(across);
        let Self { flat, places, .. } = self;
        flat.clear();
        flat.extend(
            places.iter().map(|place| [place.dot(across), place.dot(other), place.dot(up)]),
        );
    }

    /// The greatest difference in height between star and fan; `None` if it is more than `most`.
    fn heights(
        &self,
        onto: usize,
        new: impl Iterator<Item = (usize, usize)>,
        most: f64,
    ) -> Option<f64> {
        let flat = &self.flat;
        let cross = |a: [f64; 3], b: [f64; 3]| a[0] * b[1] - a[1] * b[0];
        let from = |a: [f64; 3], b: [f64; 3]| [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
        let apex = flat[onto];
        // At the vertex itself: the triangle of the fan that contains it, as far as rounding lets
        // one.
        let mut at_vertex = (f64::NEG_INFINITY, 0.0);
        for (a, b) in new {
            let (a, b) = (flat[a], flat[b]);
            let parts = [cross(a, b), cross(b, apex), cross(apex, a)];
            let whole = parts[0] + parts[1] + parts[2];
            let least = parts[0].min(parts[1]).min(parts[2]) / whole;
            if least > at_vertex.0 {
                let height = (parts[0] * apex[2] + parts[1] * a[2] + parts[2] * b[2]) / whole;
                at_vertex = (least, height.abs());
            }
        }
        let mut greatest = at_vertex.1;
        if greatest > most {
            return None;
        }
        let count = flat.len();
        let is_beside = |index: usize| match self.is_border {
            true => index.abs_diff(onto) <= 1,
            false => index == onto || index == (onto + 1) % count || onto == (index + 1) % count,
        };
        for (k, &end) in flat.iter().enumerate().filter(|&(k, _)| !is_beside(k)) {
            let spoke = from(apex, end);
            for (i, &old) in flat.iter().enumerate() {
                if i == k || i == onto {
                    continue;
                }
                // old * s = apex + spoke * t
                let turn = cross(old, spoke);
                let (s, t) = (cross(apex, spoke) / turn, cross(apex, old) / turn);
                if s > 0.0 && s < 1.0 && t > 0.0 && t < 1.0 {
                    let difference = (s * old[2] - apex[2] - t * spoke[2]).abs();
                    if difference > most {
                        return None;
                    }
                    greatest = larger(greatest, difference);
                }
            }
        }
        Some(greatest)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use crate::bvh::Bvh;
    use crate::bvh::closest_point::closest_point_on_triangle;
    use crate::geometry::TriangleMesh;
    use crate::mesh::canonical_order::rotated;
    use crate::mesh::shapes::{cuboid, hemisphere, join, torus, uv_sphere};

    /// Collapsed, within the tolerance, and with owners of all triangles on both sides.
    fn collapsed_but(source: &TriangleMesh, is_locked: &[bool], tolerance: f64) -> Collapsed {
        let mut mesh = Collapsed::unchanged(&source.triangles);
        let passes: (&[f64], f64) = (&[0.25, 1.0], 0.0);
        let control = Control::new();
        collapse(&mut mesh, source.points(), is_locked, tolerance, passes, &control).unwrap();
        assert!(mesh.moved.iter().all(|&moved| moved <= tolerance));
        assert_eq!(mesh.moved.len(), mesh.triangles.len());
        assert_eq!(mesh.owners.len(), source.triangles.len());
        for (triangle, &origin) in (0_u32..).zip(&mesh.origins) {
            assert_eq!(mesh.owners[origin as usize], triangle);
        }
        assert!(mesh.owners.iter().all(|&owner| (owner as usize) < mesh.triangles.len()));
        mesh
    }

    fn collapsed(source: &TriangleMesh, tolerance: f64) -> Collapsed {
        collapsed_but(source, &vec![false; source.positions.len()], tolerance)
    }

    fn half_edges(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
        triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect()
    }

    fn vertices(triangles: &[[u32; 3]]) -> HashSet<u32> {
        triangles.as_flattened().iter().copied().collect()
    }

    /// Half-edges without an opposite one.
    fn border(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
        let mut border = half_edges(triangles);
        let all: HashSet<[u32; 2]> = border.iter().copied().collect();
        assert_eq!(all.len(), border.len());
        border.retain(|&[a, b]| !all.contains(&[b, a]));
        border
    }

    /// Vertices less edges plus triangles of a closed mesh.
    fn euler_characteristic(triangles: &[[u32; 3]]) -> i64 {
        assert_eq!(border(triangles), [[0; 2]; 0]);
        vertices(triangles).len() as i64 - triangles.len() as i64 / 2
    }

    fn has_twins(triangles: &[[u32; 3]]) -> bool {
        let mut sets = HashSet::new();
        triangles.iter().any(|&(mut triangle)| {
            triangle.sort_unstable();
            !sets.insert(triangle)
        })
    }

    /// Points of a triangle, evenly.
    fn samples([a, b, c]: [Vector; 3]) -> impl Iterator<Item = Vector> {
        let share = |i: u32| f64::from(i) / 8.0;
        let pairs = (0..=8).flat_map(move |i| (0..=8 - i).map(move |j| (share(i), share(j))));
        pairs.map(move |(u, v)| a + (b - a) * u + (c - a) * v)
    }

    /// A square of `2 n n` triangles over the unit square.
    fn sheet(n: u32, place: impl Fn(f64, f64) -> [f64; 3]) -> TriangleMesh {
        let at = |i: u32, j: u32| i * (n + 1) + j;
        let share = |i: u32| f64::from(i) / f64::from(n);
        let mut mesh = TriangleMesh::default();
        for i in 0..=n {
            mesh.positions.extend((0..=n).map(|j| place(share(i), share(j))));
        }
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            mesh.triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            mesh.triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
        mesh
    }

    /// A square whose rim goes in and out by 0.02.
    fn zigzag() -> TriangleMesh {
        let rim = |x: f64, other: f64| match x {
            0.0 | 1.0 => 0.01 * (other * 12.0 * std::f64::consts::PI).cos(),
            _ => 0.0,
        };
        sheet(12, |x, y| [x + rim(x, y), y + rim(y, x), 0.0])
    }

    fn stretched(mut mesh: TriangleMesh, factors: [f64; 3]) -> TriangleMesh {
        for position in &mut mesh.positions {
            *position = [0, 1, 2].map(|axis| position[axis] * factors[axis]);
        }
        mesh
    }

    fn tetrahedron() -> TriangleMesh {
        TriangleMesh::new(
            vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
        )
    }

    /// Closed meshes, and tolerances for them.
    fn closed() -> Vec<(TriangleMesh, f64)> {
        vec![
            (uv_sphere(40, [0.0; 3], 1.0), 0.03),
            (torus(60, 30), 0.03),
            (torus(32, 16), 0.5),
            (cuboid([0.0; 3], [1.0; 3]), 1e-3),
            // All of it is smaller than the tolerance.
            (stretched(tetrahedron(), [1e-3; 3]), 0.01),
            (uv_sphere(4, [0.0; 3], 1e-3), 0.01),
            (uv_sphere(12, [0.0; 3], 1e-3), 0.01),
            (torus(8, 5), 10.0),
            // Thinner than that.
            (stretched(uv_sphere(16, [0.0; 3], 1.0), [1.0, 1.0, 1e-4]), 0.01),
            (stretched(uv_sphere(16, [0.0; 3], 1.0), [1.0, 1e-4, 1.0]), 0.01),
            (stretched(uv_sphere(16, [0.0; 3], 1.0), [1.0, 1e-4, 1e-4]), 0.01),
            (stretched(torus(32, 16), [1.0, 1.0, 1e-4]), 0.01),
        ]
    }

    #[test]
    fn the_surface_moves_by_no_more_than_is_said_both_ways() {
        for (source, tolerance) in closed().into_iter().chain([(hemisphere(40), 0.03)]) {
            let mesh = collapsed(&source, tolerance);
            let points = source.points();
            let corners = |triangle: &[u32; 3]| triangle.map(|vertex| points[vertex as usize]);
            let [before, after] = [&source.triangles, &mesh.triangles].map(|t| Bvh::new(points, t));
            let distance = |to: &Bvh, point: Vector| to.closest_point(point, 1e9).unwrap().distance;
            let most = mesh.moved.iter().copied().fold(0.0, larger);
            for point in source.triangles.iter().flat_map(|t| samples(corners(t)).step_by(7)) {
                assert!(distance(&after, point) <= most + 1e-12);
            }
            for (triangle, moved) in mesh.triangles.iter().zip(&mesh.moved) {
                for point in samples(corners(triangle)) {
                    assert!(distance(&before, point) <= moved + 1e-12);
                }
            }
        }
    }

    #[test]
    fn more_than_half_of_a_finely_cut_surface_goes() {
        for source in [uv_sphere(40, [0.0; 3], 1.0), torus(60, 30), hemisphere(40), zigzag()] {
            let left = collapsed(&source, 0.03).triangles.len();
            assert!(2 * left < source.triangles.len(), "{left} of {}", source.triangles.len());
        }
    }

    #[test]
    fn what_is_closed_stays_closed_and_keeps_its_handles() {
        for (source, tolerance) in closed() {
            let mesh = collapsed(&source, tolerance);
            let [before, after] = [&source.triangles, &mesh.triangles];
            assert_eq!(euler_characteristic(after), euler_characteristic(before));
        }
    }

    #[test]
    fn nothing_collapses_into_two_triangles_back_to_back() {
        for (source, tolerance) in closed() {
            assert!(!has_twins(&collapsed(&source, tolerance).triangles));
        }
    }

    #[test]
    fn parts_stay_apart_and_none_vanishes() {
        let part = |x: f64| uv_sphere(6, [x, 0.0, 0.0], 1e-3);
        let source = join(&[part(0.0), part(2e-3), part(4e-3)]);
        let mesh = collapsed(&source, 0.01);
        assert_eq!(euler_characteristic(&mesh.triangles), 6);
        let of_part = source.triangles.len() as u32 / 3;
        for (triangle, &owner) in (0_u32..).zip(&mesh.owners) {
            assert_eq!(mesh.origins[owner as usize] / of_part, triangle / of_part);
        }
    }

    #[test]
    fn locked_vertices_stay() {
        for source in [uv_sphere(16, [0.0; 3], 1.0), hemisphere(16), zigzag()] {
            let used = vertices(&source.triangles);
            let is_locked: Vec<bool> = (0..source.positions.len()).map(|v| v % 5 == 0).collect();
            let mesh = collapsed_but(&source, &is_locked, 0.2);
            let left = vertices(&mesh.triangles);
            assert!(used.iter().all(|v| v % 5 != 0 || left.contains(v)));
            assert!(left.len() < used.len());
        }
    }

    #[test]
    fn vertices_on_edges_of_three_triangles_stay() {
        // Three pages at one spine.
        let page = |angle: f64| sheet(8, |x, y| [y * angle.cos(), y * angle.sin(), x]);
        let mut source = join(&[page(0.0), page(2.0), page(4.0)]);
        let first = source.positions.iter().map(|a| source.positions.iter().position(|b| a == b));
        let first: Vec<u32> = first.map(|first| first.unwrap() as u32).collect();
        source
            .triangles
            .iter_mut()
            .for_each(|triangle| *triangle = triangle.map(|v| first[v as usize]));
        let left = vertices(&collapsed(&source, 0.1).triangles);
        let spine = (0..81).filter(|v| v % 9 == 0);
        assert_eq!(spine.clone().filter(|v| left.contains(v)).count(), 9);
        assert_eq!(spine.count(), 9);
        assert!(left.len() < 40, "{}", left.len());
    }

    #[test]
    fn a_border_moves_by_no_more_than_the_tolerance() {
        for (source, tolerance) in [(hemisphere(40), 0.03), (zigzag(), 0.021), (zigzag(), 0.005)] {
            let mesh = collapsed(&source, tolerance);
            let ends = |[a, b]: [u32; 2]| [a, b].map(|v| source.points()[v as usize]);
            let [before, after] = [&source.triangles, &mesh.triangles].map(|t| border(t));
            assert!(after.len() < before.len() || tolerance < 0.01);
            for (from, to) in [(&before, &after), (&after, &before)] {
                for [a, b] in from.iter().map(|&edge| ends(edge)) {
                    for point in (0..=10).map(|i| a + (b - a) * (0.1 * f64::from(i))) {
                        let distance = to.iter().map(|&edge| {
                            let [a, b] = ends(edge).map(|end| end - point);
                            closest_point_on_triangle(a, b, b).length()
                        });
                        assert!(distance.fold(f64::INFINITY, f64::min) <= tolerance + 1e-12);
                    }
                }
            }
        }
    }

    #[test]
    fn the_order_of_triangles_and_of_their_corners_does_not_matter() {
        let open = [(hemisphere(40), 0.03), (zigzag(), 0.021)];
        for (source, tolerance) in closed().into_iter().chain(open) {
            let sorted = |mesh: Collapsed| {
                let triangles = mesh.triangles.into_iter().map(rotated);
                let mut pairs: Vec<_> = triangles.zip(mesh.moved).collect();
                pairs.sort_unstable_by_key(|pair| pair.0);
                pairs
            };
            let mut other = source.clone();
            let half = other.triangles.len() / 2;
            other.triangles[half..].reverse();
            other.triangles.rotate_left(half / 3);
            for (turns, triangle) in other.triangles.iter_mut().enumerate() {
                triangle.rotate_left(turns % 3);
            }
            assert_eq!(sorted(collapsed(&source, tolerance)), sorted(collapsed(&other, tolerance)));
        }
    }
}
