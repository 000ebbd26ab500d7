//! The first tetrahedron of a hull, or the reason why there is none.

use super::columns::Columns;
use crate::geometry::vector::{
    Vector, area_normal, cross, distance, dot, length_squared, normalize, subtract,
};

/// In how many dimensions points extend, up to the hull's tolerance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// They span a volume and have a hull.
    Solid,
    /// They lie in a plane.
    Flat,
    /// They lie on a line.
    Linear,
    /// They lie on one spot, or there are none.
    Point,
}

/// Four points, far apart, that span a tetrahedron. For a lesser shape as many of them as it has
/// are meaningful. `columns` holds the same points. O(n).
pub(super) fn first_simplex(
    points: &[Vector],
    columns: &Columns,
    threshold: f64,
) -> (Shape, [u32; 4]) {
    let [a, b] = farthest_extremes(points, columns);
    let corner = |index: u32| points[index as usize];
    if points.is_empty() || distance(corner(a), corner(b)) <= threshold {
        return (Shape::Point, [a; 4]);
    }
    let direction = normalize(subtract(corner(b), corner(a)));
    let (c, from_line) =
        columns.farthest(|point| length_squared(cross(direction, subtract(point, corner(a)))));
    if from_line.sqrt() <= threshold {
        return (Shape::Linear, [a, b, a, a]);
    }
    let normal = normalize(area_normal(corner(a), corner(b), corner(c)));
    let (d, from_plane) = columns.farthest(|point| dot(normal, subtract(point, corner(a))).abs());
    if from_plane <= threshold {
        return (Shape::Flat, [a, b, c, a]);
    }
    (Shape::Solid, [a, b, c, d])
}

/// Of the six points that reach farthest along the axes the two that are farthest apart.
fn farthest_extremes(points: &[Vector], columns: &Columns) -> [u32; 2] {
    let extremes = columns.extremes();
    let mut best = (0.0, [0, 0]);
    for (place, &first) in extremes.iter().enumerate() {
        for &second in &extremes[place + 1..] {
            let Some((p, q)) = points.get(first as usize).zip(points.get(second as usize)) else {
                continue;
            };
            let apart = length_squared(subtract(*p, *q));
            if apart > best.0 {
                best = (apart, [first, second]);
            }
        }
    }
    best.1
}
