//! The hulls: each on its own, and all together.

use crate::geometry::MeshView;
use crate::geometry::vector::{
    Vector, area_normal, as_arrays, bounds, cubed, into_vectors, mean, squared,
};
use crate::hull::convex_hull;
use crate::mesh::Normalization;
use crate::mesh::adjacency::{SortedHalfEdges, ascends};
use crate::sorting::sort_by_key;

/// The edges of triangles with three different corners, vertices welded by position.
pub(super) struct Edges {
    /// Share of them that only one triangle uses.
    pub open_share: f64,
    /// Whether each has exactly two triangles, in opposite directions, and there is one.
    pub is_closed: bool,
}

impl Edges {
    /// O(n log n).
    pub fn of(positions: &[Vector], triangles: &[[u32; 3]]) -> Self {
        // Adding zero turns -0 into 0.
        let key = |point: Vector| point.to_array().map(|x| (x + 0.0).to_bits());
        let mut places: Vec<[u64; 3]> = positions.iter().map(|&point| key(point)).collect();
        sort_by_key(&mut places, |place| *place);
        places.dedup();
        let place =
            |vertex: u32| places.partition_point(|place| *place < key(positions[vertex as usize]));
        let welded = triangles.iter().map(|triangle| triangle.map(|vertex| place(vertex) as u32));
        let triangles: Vec<[u32; 3]> =
            welded.filter(|&[a, b, c]| a != b && b != c && c != a).collect();
        let (mut all, mut open, mut is_closed) = (0, 0, !triangles.is_empty());
        SortedHalfEdges::new(&triangles, places.len()).for_each_edge(|edge| {
            all += 1;
            open += usize::from(edge.len() == 1);
            let ascending = edge.half_edges().filter(|&half_edge| ascends(&triangles, half_edge));
            is_closed &= edge.len() == 2 && ascending.count() == 1;
        });
        let open_share = if all == 0 { 0.0 } else { open as f64 / f64::from(all) };
        Self { open_share, is_closed }
    }
}

/// A hull on its own.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct HullCheck {
    /// Its points.
    pub vertices: usize,
    /// Its triangles.
    pub triangles: usize,
    /// The farthest that one of its points lies in front of one of its triangles, as a fraction of
    /// the mesh's diagonal. In front is where the average of its points is not, so winding does
    /// not matter. Slivers, whose height over the longest side is below 1e-4 of the hull's
    /// diagonal, are left out, since their normals are noise.
    pub concavity: f64,
    /// Volume within its triangles as they are wound, in cubed units of the mesh: negative if they
    /// face inward.
    pub volume: f64,
    /// Whether each edge, its vertices welded by position, has exactly two triangles in opposite
    /// directions.
    pub is_closed: bool,
    /// Whether its points lie in a plane, on a line, or on a spot, up to 2e-7 of their extent. Such
    /// a hull holds nothing, but its triangles still count as boundary.
    pub is_flat: bool,
}

/// A triangle is a sliver if its height over its longest side is below this share of the hull's
/// diagonal.
const SLIVER: f64 = 1e-4;

/// Above this number of pairs of a triangle and a point, which takes a tenth of a second, only the
/// corners of the convex hull are compared, by climbing.
const MOST_PAIRS: usize = 100_000_000;

/// Checks a hull in normalised coordinates whose indices all exist. `corners` are those of the
/// convex hull of the points, with its triangles, where there is one.
pub(super) fn check(
    points: &[Vector],
    triangles: &[[u32; 3]],
    hull: Option<(&[Vector], &[[u32; 3]])>,
    diagonal: f64,
    mesh_diagonal: f64,
) -> HullCheck {
    let middle = mean(points);
    let climber = match hull {
        Some((corners, faces)) if points.len().saturating_mul(triangles.len()) > MOST_PAIRS => {
            Some(Climber::new(corners, faces))
        }
        _ => None,
    };
    let mut start = 0;
    let mut farthest = |normal: Vector| match &climber {
        Some(climber) => {
            start = climber.climb(normal, start);
            normal.dot(climber.points[start])
        }
        None => points.iter().map(|&point| normal.dot(point)).fold(f64::NEG_INFINITY, f64::max),
    };
    let mut six_volumes = 0.0;
    let mut concavity = 0.0_f64;
    for triangle in triangles {
        let [a, b, c] = triangle.map(|index| points[index as usize] - middle);
        six_volumes += a.dot(b.cross(c));
        let normal = area_normal(a, b, c);
        let area = normal.length();
        let sides = [b - a, c - b, a - c].map(Vector::length_squared);
        let longest = sides[0].max(sides[1]).max(sides[2]).sqrt();
        if area <= SLIVER * diagonal * longest || area == 0.0 {
            continue;
        }
        let towards_outside = if normal.dot(a) < 0.0 { -1.0 } else { 1.0 };
        let normal = normal * (towards_outside / area);
        let height = normal.dot(points[triangle[0] as usize]);
        concavity = concavity.max(farthest(normal) - height);
    }
    HullCheck {
        vertices: points.len(),
        triangles: triangles.len(),
        concavity,
        volume: six_volumes / 6.0 * cubed(mesh_diagonal),
        is_closed: Edges::of(points, triangles).is_closed,
        is_flat: hull.is_none(),
    }
}

/// Finds the point of a convex polyhedron that is farthest in a direction, by going to a better
/// neighbour as long as there is one.
struct Climber<'a> {
    points: &'a [Vector],
    /// Neighbours of all vertices, one vertex after the other.
    neighbours: Vec<u32>,
    /// Where each vertex's neighbours begin, and the end of all.
    starts: Vec<usize>,
}

impl<'a> Climber<'a> {
    fn new(points: &'a [Vector], triangles: &[[u32; 3]]) -> Self {
        let mut edges: Vec<(u32, u32)> =
            triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
        edges.sort_unstable();
        let starts = (0..=points.len())
            .map(|vertex| edges.partition_point(|&(from, _)| (from as usize) < vertex))
            .collect();
        Self { points, neighbours: edges.into_iter().map(|(_, to)| to).collect(), starts }
    }

    fn climb(&self, direction: Vector, mut vertex: usize) -> usize {
        let mut height = direction.dot(self.points[vertex]);
        loop {
            let before = vertex;
            for &next in &self.neighbours[self.starts[before]..self.starts[before + 1]] {
                let next_height = direction.dot(self.points[next as usize]);
                if next_height > height {
                    (vertex, height) = (next as usize, next_height);
                }
            }
            if vertex == before {
                return vertex;
            }
        }
    }
}

/// Points this far outside count as in a hull, and only points farther inside than this as
/// inside it: hulls that share a face do so only up to rounding, to `f32` in many files.
const TOLERANCE: f64 = 1e-6;

/// A face whose squared sine at a corner is below this has no normal to speak of in double
/// precision, and its neighbours bound the solid just as well.
const NEEDLE: f64 = 1e-20;

/// As a multiple of the mesh's diagonal. A hull farther away has lost its shape to rounding.
const FARTHEST: f64 = 1e9;

/// Why the first hull is refused where none can be judged.
pub(super) const NONE_USABLE: &str = "like all others, it has no triangles, an index out of range, or a \
                           coordinate that is not finite";

/// A hull in normalised coordinates.
pub(super) struct MeasuredHull {
    pub check: HullCheck,
    pub min: Vector,
    pub max: Vector,
    /// The convex hull of its points, or its own triangles where that has no volume.
    pub points: Vec<Vector>,
    pub triangles: Vec<[u32; 3]>,
    /// Outward unit normal and height of each face; empty without volume.
    planes: Vec<(Vector, f64)>,
}

impl MeasuredHull {
    /// `None` if there are no triangles, or if an index or a coordinate can't be used.
    pub(super) fn new(hull: &MeshView<'_>, normalization: &Normalization) -> Option<Self> {
        let points: Vec<Vector> =
            hull.points().map(|point| normalization.normalize(point)).collect();
        let exists = |&index: &u32| (index as usize) < points.len();
        let is_usable = !hull.triangles().is_empty()
            && hull.triangles().iter().flatten().all(exists)
            && points.iter().all(|point| point.abs().cmplt(Vector::splat(FARTHEST)).all());
        if !is_usable {
            return None;
        }
        let (min, max) = bounds(points.iter().copied());
        let convex = convex_hull(as_arrays(&points)).ok();
        let check = check(
            &points,
            hull.triangles(),
            convex.as_ref().map(|convex| (convex.points(), &convex.triangles[..])),
            min.distance(max),
            normalization.diagonal,
        );
        let Some(convex) = convex else {
            let (triangles, planes) = (hull.triangles().to_vec(), Vec::new());
            return Some(Self { check, min, max, points, triangles, planes });
        };
        let planes = convex.faces().filter_map(plane).collect();
        let (points, triangles) = (convex.points, convex.triangles);
        Some(Self { check, min, max, points: into_vectors(points), triangles, planes })
    }

    /// Whether `point` lies behind all faces moved outward by `margin`.
    pub(super) fn holds(&self, point: Vector, margin: f64) -> bool {
        !self.planes.is_empty()
            && (0..3).all(|axis| {
                point[axis] >= self.min[axis] - margin && point[axis] <= self.max[axis] + margin
            })
            && self.planes.iter().all(|&(normal, height)| normal.dot(point) <= height + margin)
    }
}

fn plane([a, b, c]: [Vector; 3]) -> Option<(Vector, f64)> {
    let normal = area_normal(a, b, c);
    let area = normal.length();
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    (area * area > NEEDLE * squared(squared(longest))).then(|| {
        let normal = normal * (1.0 / area);
        (normal, normal.dot(a))
    })
}

/// All hulls together.
pub(super) struct Union {
    parts: Vec<MeasuredHull>,
    points: Vec<Vector>,
    triangles: Vec<[u32; 3]>,
    /// The part of each triangle.
    owners: Vec<u32>,
}

impl Union {
    pub(super) fn new(parts: Vec<MeasuredHull>) -> Self {
        let (mut points, mut triangles, mut owners) = (Vec::new(), Vec::new(), Vec::new());
        for (owner, part) in parts.iter().enumerate() {
            let first = points.len() as u32;
            points.extend_from_slice(&part.points);
            triangles.extend(part.triangles.iter().map(|triangle| triangle.map(|i| first + i)));
            owners.resize(triangles.len(), owner as u32);
        }
        Self { parts, points, triangles, owners }
    }

    pub(super) fn parts(&self) -> &[MeasuredHull] {
        &self.parts
    }

    /// The surfaces of all hulls.
    pub(super) fn surface(&self) -> (&[Vector], &[[u32; 3]]) {
        (&self.points, &self.triangles)
    }

    /// In how many hulls the point is.
    pub(super) fn multiplicity(&self, point: Vector) -> usize {
        self.parts.iter().filter(|part| part.holds(point, TOLERANCE)).count()
    }

    /// Whether a point on a triangle of [`surface`](Self::surface) is inside a hull that is not
    /// the triangle's own.
    pub(super) fn is_inside_another(&self, point: Vector, triangle: usize) -> bool {
        let owner = self.owners[triangle] as usize;
        self.parts
            .iter()
            .enumerate()
            .any(|(index, part)| index != owner && part.holds(point, -TOLERANCE))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hull::convex_hull;

    const POSITIONS: [Vector; 5] =
        [Vector::ZERO, Vector::X, Vector::Y, Vector::Z, Vector::new(-0.0, 0.0, 0.0)];
    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 4, 3]];

    #[test]
    fn edges_are_open_that_only_one_triangle_uses_and_closed_with_two_in_opposite_directions() {
        let mut flipped = TETRAHEDRON;
        flipped[2].swap(0, 1);
        for (name, triangles, is_closed, open_share) in [
            ("a split corner", &TETRAHEDRON[..], true, 0.0),
            ("three of six edges without a second face", &TETRAHEDRON[1..], false, 0.5),
            ("a flipped face", &flipped, false, 0.0),
            ("no three corners", &[[0, 4, 1]], false, 0.0),
        ] {
            let edges = Edges::of(&POSITIONS, triangles);
            assert_eq!((edges.is_closed, edges.open_share), (is_closed, open_share), "{name}");
        }
    }

    #[test]
    fn climbing_finds_the_farthest_corner() {
        // Spread over a sphere along a spiral, stretched.
        let points: Vec<Vector> = (0..300)
            .map(|index| {
                let z = 1.0 - (f64::from(index) + 0.5) / 150.0;
                let angle = 2.4 * f64::from(index);
                let radius = (1.0 - z * z).sqrt();
                Vector::new(3.0 * radius * angle.cos(), radius * angle.sin(), 0.2 * z)
            })
            .collect();
        let hull = convex_hull(as_arrays(&points)).unwrap();
        let climber = Climber::new(hull.points(), &hull.triangles);
        let mut start = 0;
        for &direction in &points {
            start = climber.climb(direction, start);
            let farthest = points.iter().map(|&point| direction.dot(point)).fold(0.0, f64::max);
            assert!((direction.dot(hull.points()[start]) - farthest).abs() < 1e-6);
        }
    }
}
