//! Distances and winding numbers by brute force, without any code of the crate: what its answers
//! are checked against, in tests and in the laboratory.

pub type Point = [f64; 3];

pub fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub fn norm(a: Point) -> f64 {
    dot(a, a).sqrt()
}

pub fn middle(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|k| 0.5 * (a[k] + b[k]))
}

/// A triangle, with a ball around it by which most triangles are known not to be the nearest.
#[derive(Clone, Copy)]
pub struct Triangle {
    pub corners: [Point; 3],
    pub centre: Point,
    pub radius: f64,
}

impl Triangle {
    pub fn new(corners: [Point; 3]) -> Self {
        let centre = [0, 1, 2].map(|k| corners.iter().map(|corner| corner[k]).sum::<f64>() / 3.0);
        let radius = corners.iter().map(|&corner| norm(minus(corner, centre))).fold(0.0, f64::max);
        Self { corners, centre, radius }
    }

    /// The triangles of a mesh.
    pub fn all(positions: &[Point], triangles: &[[u32; 3]]) -> Vec<Self> {
        let corners = triangles.iter().map(|triangle| triangle.map(|v| positions[v as usize]));
        corners.map(Self::new).collect()
    }

    pub fn quarters(&self) -> [Self; 4] {
        let [a, b, c] = self.corners;
        let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]].map(Self::new)
    }

    /// No point of it is nearer than this.
    pub fn least_distance(&self, point: Point) -> f64 {
        norm(minus(point, self.centre)) - self.radius
    }

    /// The distance to a point: to the inside where the point is above it, else to an edge.
    pub fn distance(&self, point: Point) -> f64 {
        let [a, b, c] = self.corners;
        let normal = cross(minus(b, a), minus(c, a));
        let edges = [(a, b), (b, c), (c, a)];
        let is_above = edges
            .iter()
            .all(|&(from, to)| dot(cross(normal, minus(to, from)), minus(point, from)) >= 0.0);
        let area = norm(normal);
        if is_above && area > 0.0 {
            return (dot(normal, minus(point, a)) / area).abs();
        }
        let to_edge = |&(from, to): &(Point, Point)| {
            let (along, offset) = (minus(to, from), minus(point, from));
            let squared = dot(along, along);
            let share =
                if squared > 0.0 { (dot(offset, along) / squared).clamp(0.0, 1.0) } else { 0.0 };
            norm([0, 1, 2].map(|k| offset[k] - share * along[k]))
        };
        edges.iter().map(to_edge).fold(f64::INFINITY, f64::min)
    }

    /// The solid angle under which a point sees it, positive from inside (van Oosterom and
    /// Strackee).
    pub fn solid_angle(&self, point: Point) -> f64 {
        let [a, b, c] = self.corners.map(|corner| minus(corner, point));
        let lengths = [a, b, c].map(norm);
        let below = lengths[0] * lengths[1] * lengths[2]
            + dot(a, b) * lengths[2]
            + dot(b, c) * lengths[0]
            + dot(c, a) * lengths[1];
        2.0 * dot(a, cross(b, c)).atan2(below)
    }
}

/// The least distance of a point to any of some triangles; infinite without any.
pub fn distance_to<'a>(triangles: impl IntoIterator<Item = &'a Triangle>, point: Point) -> f64 {
    triangles.into_iter().fold(f64::INFINITY, |least, triangle| {
        let may_be_nearer = triangle.least_distance(point) < least;
        if may_be_nearer { least.min(triangle.distance(point)) } else { least }
    })
}

/// How often a surface goes around a point.
pub fn winding_number(surface: &[Triangle], point: Point) -> f64 {
    let angle: f64 = surface.iter().map(|triangle| triangle.solid_angle(point)).sum();
    angle / (4.0 * std::f64::consts::PI)
}

/// A hull as planes that face outward, and faces, with a ball around it.
pub struct Convex {
    planes: Vec<(Point, f64)>,
    pub faces: Vec<Triangle>,
    centre: Point,
    radius: f64,
}

impl Convex {
    pub fn new(points: &[Point], triangles: &[[u32; 3]]) -> Self {
        let faces = Triangle::all(points, triangles);
        let planes = faces.iter().map(|face| {
            let [a, b, c] = face.corners;
            let normal = cross(minus(b, a), minus(c, a));
            (normal, dot(normal, a))
        });
        let planes = planes.collect();
        let centre = faces[0].centre;
        let far = |face: &Triangle| norm(minus(face.centre, centre)) + face.radius;
        let radius = faces.iter().map(far).fold(0.0, f64::max);
        Self { planes, faces, centre, radius }
    }

    /// No point of it is nearer than this.
    pub fn least_distance(&self, point: Point) -> f64 {
        norm(minus(point, self.centre)) - self.radius
    }

    /// The distance of a point outside the hull.
    pub fn outside(&self, point: Point) -> f64 {
        let is_inside = self.planes.iter().all(|&(normal, offset)| dot(normal, point) <= offset);
        if is_inside { 0.0 } else { distance_to(&self.faces, point) }
    }
}
