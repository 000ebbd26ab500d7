//! What a hull's triangles say about it: are they those of a convex body?

use super::edges;
use crate::geometry::vector::{
    Vector, add, area_normal, cross, cubed, dot, length, length_squared, scale, subtract,
};

/// A hull on its own.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct HullCheck {
    /// Its points.
    pub vertices: usize,
    /// Its triangles.
    pub triangles: usize,
    /// The farthest that one of its points lies in front of one of its triangles, as a share of
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
/// points that are corners of the convex hull are asked, by climbing.
const MOST_PAIRS: usize = 100_000_000;

/// The average of points; the origin where there is none.
pub(super) fn average(points: &[Vector]) -> Vector {
    let sum = points.iter().fold([0.0; 3], |sum, &point| add(sum, point));
    scale(sum, 1.0 / points.len().max(1) as f64)
}

/// Checks a hull in normalised coordinates whose indices all exist. `corners` are those of the
/// convex hull of the points, with its triangles, where there is one.
pub(super) fn check(
    points: &[Vector],
    triangles: &[[u32; 3]],
    hull: Option<(&[Vector], &[[u32; 3]])>,
    diagonal: f64,
    mesh_diagonal: f64,
) -> HullCheck {
    let middle = average(points);
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
            dot(normal, climber.points[start])
        }
        None => points.iter().map(|&point| dot(normal, point)).fold(f64::NEG_INFINITY, f64::max),
    };
    let mut six_volumes = 0.0;
    let mut concavity = 0.0_f64;
    for triangle in triangles {
        let [a, b, c] = triangle.map(|index| subtract(points[index as usize], middle));
        six_volumes += dot(a, cross(b, c));
        let normal = area_normal(a, b, c);
        let area = length(normal);
        let sides = [subtract(b, a), subtract(c, b), subtract(a, c)].map(length_squared);
        let longest = sides[0].max(sides[1]).max(sides[2]).sqrt();
        if area <= SLIVER * diagonal * longest || area == 0.0 {
            continue;
        }
        let towards_outside = if dot(normal, a) < 0.0 { -1.0 } else { 1.0 };
        let normal = scale(normal, towards_outside / area);
        let height = dot(normal, points[triangle[0] as usize]);
        concavity = concavity.max(farthest(normal) - height);
    }
    HullCheck {
        vertices: points.len(),
        triangles: triangles.len(),
        concavity,
        volume: six_volumes / 6.0 * cubed(mesh_diagonal),
        is_closed: edges::is_closed(points, triangles),
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
        let mut height = dot(direction, self.points[vertex]);
        loop {
            let before = vertex;
            for &next in &self.neighbours[self.starts[before]..self.starts[before + 1]] {
                let next_height = dot(direction, self.points[next as usize]);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hull::convex_hull;

    #[test]
    fn climbing_finds_the_farthest_corner() {
        // Spread over a sphere along a spiral, stretched.
        let points: Vec<Vector> = (0..300)
            .map(|index| {
                let z = 1.0 - (f64::from(index) + 0.5) / 150.0;
                let angle = 2.4 * f64::from(index);
                let radius = (1.0 - z * z).sqrt();
                [3.0 * radius * angle.cos(), radius * angle.sin(), 0.2 * z]
            })
            .collect();
        let hull = convex_hull(&points).unwrap();
        let climber = Climber::new(&hull.points, &hull.triangles);
        let mut start = 0;
        for &direction in &points {
            start = climber.climb(direction, start);
            let farthest = points.iter().map(|&point| dot(direction, point)).fold(0.0, f64::max);
            assert!((dot(direction, hull.points[start]) - farthest).abs() < 1e-6);
        }
    }
}
