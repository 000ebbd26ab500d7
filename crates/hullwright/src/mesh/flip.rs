//! Diagonals within planes, flipped until they are those of the Delaunay triangulation (Lawson,
//! "Software for C¹ surface interpolation", 1977): however a planar face was cut into triangles,
//! the same ones are left, and no slivers that better ones could replace.
//!
//! Where four corners are on one circle, as those of a rectangle are, the diagonal with the least
//! vertex is taken.

use super::adjacency::{Adjacency, NO_NEIGHBOUR};
use super::collapse::{Collapsed, FLAT};
use crate::geometry::TriangleMesh;
use crate::geometry::vector::{Vector, area_normal, larger, squared};

/// Flips for each triangle, at most: Delaunay flips end, but rounding may make ties go round in
/// circles.
const MAX_FLIPS: usize = 16;

/// A corner this near to the circle through three others is on it, as a fraction of the circle's
/// scale.
const ON_CIRCLE: f64 = 1e-9;

/// Least height of a new triangle over its longest side, as a fraction of that.
const LEAST_HEIGHT: f64 = 1e-6;

/// Triangles around a vertex that are looked at before a diagonal to it. Beyond that it does not
/// flip.
const MAX_AROUND: usize = 256;

/// Flips diagonals between triangles in one plane that `may_flip` allows, as long as nothing moves
/// by more than the tolerance. O(n), except for long chains of flips. Returns how many were
/// flipped.
pub(crate) fn flip_diagonals(
    mesh: &mut Collapsed,
    points: &[Vector],
    tolerance: f64,
    may_flip: impl Fn(u32, u32) -> bool,
) -> usize {
    let positions = points.iter().map(|point| point.to_array()).collect();
    let whole = TriangleMesh::new(positions, std::mem::take(&mut mesh.triangles));
    let neighbours = Adjacency::new(&whole).neighbours;
    let triangles = whole.triangles;
    let (moved, flatness) = (&mut mesh.moved, FLAT * tolerance);
    let mut flips = Flips { points, triangles, neighbours, moved, flatness, tolerance };
    let most = MAX_FLIPS * flips.triangles.len();
    let mut stack: Vec<u32> = (0..flips.neighbours.len() as u32).rev().collect();
    let mut count = 0;
    while let Some(half_edge) = stack.pop() {
        if count == most {
            break;
        }
        let triangle = half_edge / 3;
        let other = flips.neighbours[half_edge as usize];
        if other == NO_NEIGHBOUR || !may_flip(triangle, other) {
            continue;
        }
        if let Some(quad) = flips.quad(half_edge)
            && flips.is_better(&quad)
        {
            flips.flip(&quad);
            count += 1;
            stack.extend(
                (0..3).flat_map(|k| [3 * quad.triangles[0] + k, 3 * quad.triangles[1] + k]),
            );
        }
    }
    mesh.triangles = flips.triangles;
    count
}

struct Flips<'a> {
    points: &'a [Vector],
    triangles: Vec<[u32; 3]>,
    /// See [`Adjacency::neighbours`].
    neighbours: Vec<u32>,
    moved: &'a mut [f64],
    flatness: f64,
    tolerance: f64,
}

/// Two triangles `a b c` and `b a d`.
struct Quad {
    triangles: [u32; 2],
    corners: [u32; 4],
    /// The half-edges `a b` and `b a`, as places in their triangles.
    places: [usize; 2],
    /// How far what the flipped triangles stand for has moved then.
    moved: f64,
}

impl Flips<'_> {
    /// The two triangles at a half-edge, if they run along it in opposite directions and lie in one
    /// plane.
    fn quad(&self, half_edge: u32) -> Option<Quad> {
        let (first, place) = (half_edge / 3, half_edge as usize % 3);
        let second = self.neighbours[half_edge as usize];
        let corners = self.triangles[first as usize];
        let [a, b, c] = [0, 1, 2].map(|step| corners[(place + step) % 3]);
        let others = self.triangles[second as usize];
        let other = (0..3).find(|&k| others[k] == b && others[(k + 1) % 3] == a)?;
        let d = others[(other + 2) % 3];
        // The other triangle may take this one for a neighbour across another edge alone.
        if self.neighbours[3 * second as usize + other] != first || c == d {
            return None;
        }
        let [pa, pb, pc, pd] = [a, b, c, d].map(|vertex| self.points[vertex as usize]);
        // Most pairs end here.
        let normal = area_normal(pa, pb, pc);
        if squared(normal.dot(pd - pa)) > squared(self.flatness) * normal.length_squared() {
            return None;
        }
        let [up, beside] = [normal, area_normal(pb, pa, pd)].map(Vector::normalize_or_zero);
        let height = up.dot(pd - pa).abs().max(beside.dot(pc - pa).abs());
        let before = larger(self.moved[first as usize], self.moved[second as usize]);
        let moved = before + height;
        (height <= self.flatness && moved <= self.tolerance && up.dot(beside) > 0.0).then_some(
            Quad {
                triangles: [first, second],
                corners: [a, b, c, d],
                places: [place, other],
                moved,
            },
        )
    }

    /// Whether the other diagonal of a convex quad is the Delaunay one, or, of corners on one
    /// circle, has the least vertex.
    fn is_better(&self, quad: &Quad) -> bool {
        let [a, b, c, d] = quad.corners;
        let [pa, pb, pc, pd] = quad.corners.map(|vertex| self.points[vertex as usize]);
        let up = area_normal(pa, pb, pc);
        for [p, q, r] in [[pc, pd, pb], [pd, pc, pa]] {
            let normal = area_normal(p, q, r);
            let longest =
                p.distance_squared(q).max(q.distance_squared(r)).max(r.distance_squared(p));
            if normal.dot(up) <= 0.0 || normal.length() <= LEAST_HEIGHT * longest {
                return false;
            }
        }
        // Opposite angles of a Delaunay diagonal add up to at most half a turn: sin(α + β) ≥ 0.
        let angle = |apex: Vector, p: Vector, q: Vector| {
            let (p, q) = (p - apex, q - apex);
            let scale = (p.length_squared() * q.length_squared()).sqrt();
            (p.dot(q) / scale, p.cross(q).length() / scale)
        };
        let (cos_c, sin_c) = angle(pc, pa, pb);
        let (cos_d, sin_d) = angle(pd, pa, pb);
        let excess = sin_c * cos_d + cos_c * sin_d;
        if excess.abs() <= ON_CIRCLE {
            c.min(d) < a.min(b) && !self.has_edge(c, d, quad)
        } else {
            excess < 0.0 && !self.has_edge(c, d, quad)
        }
    }

    /// Whether an edge from the third corner to the fourth may exist already.
    fn has_edge(&self, from: u32, to: u32, quad: &Quad) -> bool {
        // Around `from`, in both directions: the surface may end there.
        for turns_back in [false, true] {
            let mut triangle = quad.triangles[0];
            for _ in 0..MAX_AROUND {
                let corners = self.triangles[triangle as usize];
                if corners.contains(&to) {
                    return true;
                }
                let Some(at) = corners.iter().position(|&corner| corner == from) else { break };
                let edge = if turns_back { at } else { (at + 2) % 3 };
                let next = self.neighbours[3 * triangle as usize + edge];
                if next == quad.triangles[0] {
                    return false;
                }
                if next == NO_NEIGHBOUR {
                    break;
                }
                triangle = next;
            }
        }
        false
    }

    /// `a b c` and `b a d` become `c d b` and `d c a`.
    fn flip(&mut self, quad: &Quad) {
        let Quad { triangles: [first, second], corners: [a, b, c, d], places, moved } = *quad;
        let across = |flips: &Self, triangle: u32, place: usize| {
            flips.neighbours[3 * triangle as usize + place % 3]
        };
        let [bc, ca] = [1, 2].map(|step| across(self, first, places[0] + step));
        let [ad, db] = [1, 2].map(|step| across(self, second, places[1] + step));
        self.triangles[first as usize] = [c, d, b];
        self.triangles[second as usize] = [d, c, a];
        self.set_neighbours(first, [second, db, bc]);
        self.set_neighbours(second, [first, ca, ad]);
        self.redirect(db, second, first, [d, b]);
        self.redirect(ca, first, second, [c, a]);
        self.moved[first as usize] = moved;
        self.moved[second as usize] = moved;
    }

    fn set_neighbours(&mut self, triangle: u32, neighbours: [u32; 3]) {
        self.neighbours[3 * triangle as usize..][..3].copy_from_slice(&neighbours);
    }

    /// Tells a neighbour across an edge that another triangle is there now.
    fn redirect(&mut self, neighbour: u32, from: u32, to: u32, edge: [u32; 2]) {
        if neighbour == NO_NEIGHBOUR {
            return;
        }
        let corners = self.triangles[neighbour as usize];
        for k in 0..3 {
            let ends = [corners[k], corners[(k + 1) % 3]];
            let entry = &mut self.neighbours[3 * neighbour as usize + k];
            if *entry == from && ends.iter().all(|end| edge.contains(end)) {
                *entry = to;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::canonical_order::rotated;

    const TOLERANCE: f64 = 0.01;

    /// Flipped; how many flips, and the triangles with their least vertices first, sorted.
    fn flipped_where(
        points: &[Vector],
        triangles: &[[u32; 3]],
        may_flip: impl Fn(u32, u32) -> bool,
    ) -> (usize, Vec<[u32; 3]>) {
        let mut mesh = Collapsed::unchanged(triangles);
        let count = flip_diagonals(&mut mesh, points, TOLERANCE, may_flip);
        assert!(mesh.moved.iter().all(|&moved| moved <= TOLERANCE));
        (count, sorted(&mesh.triangles))
    }

    fn flipped(points: &[Vector], triangles: &[[u32; 3]]) -> (usize, Vec<[u32; 3]>) {
        flipped_where(points, triangles, |_, _| true)
    }

    fn sorted(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
        let mut sorted: Vec<[u32; 3]> =
            triangles.iter().map(|&triangle| rotated(triangle)).collect();
        sorted.sort_unstable();
        sorted
    }

    const LENGTH: u32 = 8;

    /// Two rows of points, from 0 and from `LENGTH + 1` on, in a slanted plane. The upper row is
    /// shifted.
    fn rows(shift: f64) -> Vec<Vector> {
        let place = |x: f64, y: f64| Vector::new(x + y * shift, y, 0.3 * x + 0.2 * y);
        let row = |y: f64| (0..=LENGTH).map(move |i| place(f64::from(i), y));
        row(0.0).chain(row(1.0)).collect()
    }

    /// The strip between them, as two fans of long triangles.
    fn fans() -> Vec<[u32; 3]> {
        let upper = LENGTH + 1;
        let below = (0..LENGTH).map(|i| [upper, i, i + 1]);
        below.chain((0..LENGTH).map(|i| [LENGTH, upper + i + 1, upper + i])).collect()
    }

    #[test]
    fn a_badly_cut_strip_becomes_delaunay() {
        for shift in [0.3, -0.4, 0.7, 1.45] {
            let points = rows(shift);
            let (count, triangles) = flipped(&points, &fans());
            assert!(count > 0 && triangles.len() == fans().len());
            for triangle in triangles {
                let [a, b, c] = triangle.map(|vertex| points[vertex as usize]);
                let (u, v) = (b - a, c - a);
                let normal = u.cross(v);
                assert!(normal.z > 0.0);
                let middle = (v * u.length_squared() - u * v.length_squared()).cross(normal)
                    * (0.5 / normal.length_squared());
                let radius = middle.length();
                assert!((a + middle).distance(b) - radius < 1e-9);
                assert!(points.iter().all(|&point| point.distance(a + middle) > radius - 1e-9));
            }
        }
    }

    #[test]
    fn the_order_in_which_a_strip_is_cut_does_not_matter() {
        for shift in [0.0, 0.3] {
            let points = rows(shift);
            let (_, first) = flipped(&points, &fans());
            let mut reversed = fans();
            reversed.reverse();
            let upper = LENGTH + 1;
            let even: Vec<[u32; 3]> = (0..LENGTH)
                .flat_map(|i| [[i, i + 1, upper + i], [i + 1, upper + i + 1, upper + i]])
                .collect();
            assert_eq!(flipped(&points, &reversed).1, first);
            assert_eq!(flipped(&points, &even).1, first);
        }
    }

    #[test]
    fn of_four_corners_on_a_circle_the_diagonal_has_the_least_vertex() {
        for first in 0..4 {
            // Vertex 0 is at each corner of a rectangle in turn.
            let corner = |k: usize| {
                Vector::from([[0.0; 3], [3.0, 0.0, 0.0], [3.0, 1.0, 0.5], [0.0, 1.0, 0.5]][k % 4])
            };
            let points = [0, 1, 2, 3].map(|k| corner(first + k));
            let expected = vec![[0, 1, 2], [0, 2, 3]];
            assert_eq!(flipped(&points, &[[0, 1, 2], [0, 2, 3]]), (0, expected.clone()));
            assert_eq!(flipped(&points, &[[1, 2, 3], [1, 3, 0]]), (1, expected));
        }
    }

    /// A quad that is cut along its longer diagonal, bent there so that its last corner is that
    /// high.
    fn bent(height: f64) -> [Vector; 4] {
        [[-1.0, 0.0, 0.0], [0.0, -0.5, 0.0], [1.0, 0.0, 0.0], [0.0, 0.5, height]].map(Vector::from)
    }

    const ALONG: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

    #[test]
    fn only_what_is_in_one_plane_is_flipped() {
        for (height, flips) in [(0.0, 1), (0.0005, 1), (0.003, 0), (0.5, 0), (-0.003, 0)] {
            assert_eq!(flipped(&bent(height), &ALONG).0, flips, "{height}");
        }
        // Folded flat.
        let mut points = bent(0.0);
        points[3] = Vector::new(0.1, -0.4, 0.0);
        assert_eq!(flipped(&points, &ALONG).0, 0);
    }

    #[test]
    fn what_has_moved_by_the_tolerance_stays() {
        for (moved, flips) in [(0.9994 * TOLERANCE, 0), (0.5 * TOLERANCE, 1)] {
            let mut mesh = Collapsed::unchanged(&ALONG);
            mesh.moved[1] = moved;
            let count = flip_diagonals(&mut mesh, &bent(0.0005), TOLERANCE, |_, _| true);
            assert_eq!(count, flips);
            let most = mesh.moved.iter().copied().fold(0.0, larger);
            assert!(if flips == 0 { most == moved } else { most > moved && most <= TOLERANCE });
        }
    }

    #[test]
    fn nothing_is_flipped_across_edges_where_it_may_not() {
        let points = rows(0.3);
        let (count, triangles) = flipped_where(&points, &fans(), |_, _| false);
        assert_eq!((count, triangles), (0, sorted(&fans())));
        // Below and above the middle diagonal.
        let is_above = |triangle: u32| triangle >= LENGTH;
        let (_, triangles) = flipped_where(&points, &fans(), |a, b| is_above(a) == is_above(b));
        let middle = triangles.iter().filter(|t| t.contains(&LENGTH) && t.contains(&(LENGTH + 1)));
        assert_eq!(middle.count(), 2);
    }

    #[test]
    fn no_edge_is_made_twice() {
        // A tetrahedron without height: the other diagonal is that of its other side.
        let points =
            [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0; 3], [1.0, 1.0, 0.0]].map(Vector::from);
        let triangles = [[2, 3, 0], [3, 2, 1], [0, 3, 1], [0, 1, 2]];
        assert_eq!(flipped(&points, &triangles), (0, sorted(&triangles)));
    }
}
