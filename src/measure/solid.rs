//! Hulls as convex solids, and their union.

use super::check::{HullCheck, check};
use crate::geometry::MeshView;
use crate::geometry::vector::{Vector, area_normal, bounds, distance, dot, length, scale, squared};
use crate::hull::convex_hull;
use crate::mesh::Normalization;

/// Points this far outside count as in a hull, and only points farther inside than this as
/// inside it: hulls that share a face do so only up to rounding, to `f32` in many files.
pub(crate) const TOLERANCE: f64 = 1e-6;

/// A face whose squared sine at a corner is below this has no normal to speak of in double
/// precision, and its neighbours bound the solid just as well.
const NEEDLE: f64 = 1e-20;

/// In diagonals of the mesh. A hull farther away has lost its shape to rounding.
const FARTHEST: f64 = 1e9;

/// A hull in normalised coordinates.
pub(crate) struct Part {
    pub check: HullCheck,
    pub min: Vector,
    pub max: Vector,
    /// The convex hull of its points, or its own triangles where that has no volume.
    pub points: Vec<Vector>,
    pub triangles: Vec<[u32; 3]>,
    /// Outward unit normal and height of each face; empty without volume.
    planes: Vec<(Vector, f64)>,
}

impl Part {
    /// `None` if there are no triangles, or if an index or a coordinate can't be used.
    pub(crate) fn new(hull: &MeshView<'_>, normalization: &Normalization) -> Option<Self> {
        let points: Vec<Vector> =
            hull.positions().map(|point| normalization.normalize(point)).collect();
        let exists = |&index: &u32| (index as usize) < points.len();
        let is_usable = !hull.triangles().is_empty()
            && hull.triangles().iter().flatten().all(exists)
            && points.iter().flatten().all(|x| x.abs() < FARTHEST);
        if !is_usable {
            return None;
        }
        let (min, max) = bounds(points.iter().copied());
        let convex = convex_hull(&points).ok();
        let check = check(
            &points,
            hull.triangles(),
            convex.as_ref().map(|convex| (&convex.points[..], &convex.triangles[..])),
            distance(min, max),
            normalization.diagonal,
        );
        let Some(convex) = convex else {
            let (triangles, planes) = (hull.triangles().to_vec(), Vec::new());
            return Some(Self { check, min, max, points, triangles, planes });
        };
        let planes = convex.corners().filter_map(plane).collect();
        let (points, triangles) = (convex.points, convex.triangles);
        Some(Self { check, min, max, points, triangles, planes })
    }

    /// Whether `point` lies behind all faces moved outward by `margin`.
    pub(crate) fn holds(&self, point: Vector, margin: f64) -> bool {
        !self.planes.is_empty()
            && (0..3).all(|axis| {
                point[axis] >= self.min[axis] - margin && point[axis] <= self.max[axis] + margin
            })
            && self.planes.iter().all(|&(normal, height)| dot(normal, point) <= height + margin)
    }
}

fn plane([a, b, c]: [Vector; 3]) -> Option<(Vector, f64)> {
    let normal = area_normal(a, b, c);
    let area = length(normal);
    let longest = distance(a, b).max(distance(b, c)).max(distance(c, a));
    (area * area > NEEDLE * squared(squared(longest))).then(|| {
        let normal = scale(normal, 1.0 / area);
        (normal, dot(normal, a))
    })
}

/// All hulls together.
pub(crate) struct Union {
    parts: Vec<Part>,
    points: Vec<Vector>,
    triangles: Vec<[u32; 3]>,
    /// The part of each triangle.
    owners: Vec<u32>,
}

impl Union {
    pub(crate) fn new(parts: Vec<Part>) -> Self {
        let (mut points, mut triangles, mut owners) = (Vec::new(), Vec::new(), Vec::new());
        for (owner, part) in parts.iter().enumerate() {
            let first = points.len() as u32;
            points.extend_from_slice(&part.points);
            triangles.extend(part.triangles.iter().map(|triangle| triangle.map(|i| first + i)));
            owners.resize(triangles.len(), owner as u32);
        }
        Self { parts, points, triangles, owners }
    }

    pub(super) fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// The surfaces of all hulls.
    pub(crate) fn surface(&self) -> (&[Vector], &[[u32; 3]]) {
        (&self.points, &self.triangles)
    }

    /// In how many hulls the point is.
    pub(crate) fn multiplicity(&self, point: Vector) -> usize {
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
