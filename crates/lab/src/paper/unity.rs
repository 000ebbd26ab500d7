//! The simplifier that the paper used, Unity Mesh Simplifier with its default options, to see what
//! of Table 1 hangs on it: edges below a threshold that rises from pass to pass are collapsed in
//! the order of the triangles, to where the quadric error is least (Garland and Heckbert 1997).

use std::array::from_fn;

use hullwright::TriangleMesh;

use crate::shapes::Vector;

/// Its values: passes, the threshold of each, passes between two rebuilds, and what a collapse may
/// do to the triangles around it.
const MOST_PASSES: u32 = 100;
const LEAST_THRESHOLD: f64 = 1e-9;
const FIRST_PASS: u32 = 3;
const AGGRESSIVENESS: i32 = 7;
const PASSES_PER_REBUILD: u32 = 5;
const MOST_COSINE_OF_SIDES: f64 = 0.999;
const LEAST_COSINE_OF_NORMALS: f64 = 0.2;

/// A quadric error: a symmetric matrix of 4 by 4, row by row from the diagonal on.
type Quadric = [f64; 10];

#[derive(Clone)]
struct Vertex {
    point: Vector,
    quadric: Quadric,
    /// The triangles at it, and which of their corners it is.
    corners: Vec<(usize, usize)>,
    is_border: bool,
}

#[derive(Clone)]
struct Triangle {
    vertices: [usize; 3],
    normal: Vector,
    errors: [f64; 3],
    is_deleted: bool,
    is_dirty: bool,
}

struct Simplifier {
    vertices: Vec<Vertex>,
    triangles: Vec<Triangle>,
}

/// The mesh with a share of its triangles, in single precision as Unity has it.
pub fn simplify(mesh: &TriangleMesh, quality: f64) -> TriangleMesh {
    let mut simplifier = Simplifier::new(mesh);
    let start = mesh.triangles.len();
    let target = (start as f64 * quality).round() as usize;
    let mut deleted = 0;
    for pass in 0..MOST_PASSES {
        if start - deleted <= target {
            break;
        }
        if pass % PASSES_PER_REBUILD == 0 {
            simplifier.rebuild();
        }
        simplifier.triangles.iter_mut().for_each(|triangle| triangle.is_dirty = false);
        let threshold = LEAST_THRESHOLD * f64::from(pass + FIRST_PASS).powi(AGGRESSIVENESS);
        simplifier.collapse_below(threshold, start - target, &mut deleted);
    }
    simplifier.mesh()
}

impl Simplifier {
    fn new(mesh: &TriangleMesh) -> Self {
        let vertex = |&point: &[f64; 3]| Vertex {
            point: Vector::from(point.map(|x| f64::from(x as f32))),
            quadric: [0.0; 10],
            corners: Vec::new(),
            is_border: false,
        };
        let triangle = |corners: &[u32; 3]| Triangle {
            vertices: corners.map(|vertex| vertex as usize),
            normal: Vector::ZERO,
            errors: [0.0; 3],
            is_deleted: false,
            is_dirty: false,
        };
        let mut all = Self {
            vertices: mesh.positions.iter().map(vertex).collect(),
            triangles: mesh.triangles.iter().map(triangle).collect(),
        };
        all.rebuild();
        all.find_border();
        for index in 0..all.triangles.len() {
            let vertices = all.triangles[index].vertices;
            let [a, b, c] = vertices.map(|vertex| all.vertices[vertex].point);
            let normal = normalized((b - a).cross(c - a));
            all.triangles[index].normal = normal;
            let plane = [normal.x, normal.y, normal.z, -normal.dot(a)];
            for vertex in vertices {
                let products = (0..4).flat_map(|i| (i..4).map(move |j| plane[i] * plane[j]));
                all.vertices[vertex]
                    .quadric
                    .iter_mut()
                    .zip(products)
                    .for_each(|(sum, x)| *sum += x);
            }
        }
        (0..all.triangles.len()).for_each(|index| all.set_errors(index));
        all
    }

    /// Deleted triangles go, and vertices list their corners anew.
    fn rebuild(&mut self) {
        self.triangles.retain(|triangle| !triangle.is_deleted);
        self.vertices.iter_mut().for_each(|vertex| vertex.corners.clear());
        for (index, triangle) in self.triangles.iter().enumerate() {
            for (corner, &vertex) in triangle.vertices.iter().enumerate() {
                self.vertices[vertex].corners.push((index, corner));
            }
        }
    }

    /// A vertex that only one triangle at another shares with it is on the border.
    fn find_border(&mut self) {
        for vertex in 0..self.vertices.len() {
            let around = self.vertices[vertex].corners.iter();
            let mut around: Vec<usize> =
                around.flat_map(|&(index, _)| self.triangles[index].vertices).collect();
            around.sort_unstable();
            for same in around.chunk_by(|a, b| a == b).filter(|same| same.len() == 1) {
                self.vertices[same[0]].is_border = true;
            }
        }
    }

    fn set_errors(&mut self, index: usize) {
        let [a, b, c] = self.triangles[index].vertices;
        self.triangles[index].errors =
            [(a, b), (b, c), (c, a)].map(|(from, to)| self.best_place(from, to).1);
    }

    /// Where an edge collapses to, and the error there.
    fn best_place(&self, from: usize, to: usize) -> (Vector, f64) {
        let [from, to] = [from, to].map(|vertex| &self.vertices[vertex]);
        let q: Quadric = from_fn(|k| from.quadric[k] + to.quadric[k]);
        let error = |Vector { x, y, z }: Vector| {
            q[0] * x * x
                + 2.0 * q[1] * x * y
                + 2.0 * q[2] * x * z
                + 2.0 * q[3] * x
                + q[4] * y * y
                + 2.0 * q[5] * y * z
                + 2.0 * q[6] * y
                + q[7] * z * z
                + 2.0 * q[8] * z
                + q[9]
        };
        let determinant = determinant(&q, [0, 1, 2, 1, 4, 5, 2, 5, 7]);
        let place = if determinant != 0.0 && !(from.is_border && to.is_border) {
            Vector::new(
                -1.0 / determinant * self::determinant(&q, [1, 2, 3, 4, 5, 6, 5, 7, 8]),
                1.0 / determinant * self::determinant(&q, [0, 2, 3, 1, 5, 6, 2, 7, 8]),
                -1.0 / determinant * self::determinant(&q, [0, 1, 3, 1, 4, 6, 2, 5, 8]),
            )
        } else {
            let middle = (from.point + to.point) * 0.5;
            let [start, end, halfway] = [from.point, to.point, middle].map(error);
            if start < end {
                if start < halfway { from.point } else { middle }
            } else if end < halfway {
                to.point
            } else {
                middle
            }
        };
        (place, error(place))
    }

    /// Collapses edges in the order of the triangles until enough triangles are deleted.
    fn collapse_below(&mut self, threshold: f64, enough: usize, deleted: &mut usize) {
        for index in 0..self.triangles.len() {
            let Triangle { vertices, errors, is_deleted, is_dirty, .. } = self.triangles[index];
            if is_deleted || is_dirty {
                continue;
            }
            for side in (0..3).filter(|&side| errors[side] <= threshold) {
                let (from, to) = (vertices[side], vertices[(side + 1) % 3]);
                if self.vertices[from].is_border != self.vertices[to].is_border {
                    continue;
                }
                let (place, _) = self.best_place(from, to);
                if !self.flips(place, from, to) && !self.flips(place, to, from) {
                    *deleted += self.collapse(from, to, place);
                    break;
                }
            }
            if *deleted >= enough {
                return;
            }
        }
    }

    /// Whether a triangle at a vertex would turn or become a sliver, other than those at both.
    fn flips(&self, place: Vector, vertex: usize, other: usize) -> bool {
        self.vertices[vertex].corners.iter().any(|&(index, corner)| {
            let Triangle { vertices, normal, is_deleted, .. } = &self.triangles[index];
            let next = [1, 2].map(|step| vertices[(corner + step) % 3]);
            if *is_deleted || next.contains(&other) {
                return false;
            }
            let [a, b] = next.map(|next| normalized(self.vertices[next].point - place));
            a.dot(b).abs() > MOST_COSINE_OF_SIDES
                || normalized(a.cross(b)).dot(*normal) < LEAST_COSINE_OF_NORMALS
        })
    }

    /// Moves an edge to a place. How many triangles are gone.
    fn collapse(&mut self, from: usize, to: usize, place: Vector) -> usize {
        let added = self.vertices[to].quadric;
        let kept = &mut self.vertices[from];
        kept.point = place;
        kept.quadric.iter_mut().zip(added).for_each(|(sum, x)| *sum += x);
        let mut corners = std::mem::take(&mut kept.corners);
        corners.extend(&self.vertices[to].corners);
        corners.retain(|&(index, _)| !self.triangles[index].is_deleted);
        let mut gone = 0;
        corners.retain(|&(index, corner)| {
            let triangle = &mut self.triangles[index];
            let others = [1, 2].map(|step| triangle.vertices[(corner + step) % 3]);
            if others.contains(&from) || others.contains(&to) {
                gone += usize::from(!triangle.is_deleted);
                triangle.is_deleted = true;
                return false;
            }
            triangle.vertices[corner] = from;
            triangle.is_dirty = true;
            true
        });
        corners.iter().for_each(|&(index, _)| self.set_errors(index));
        self.vertices[from].corners = corners;
        gone
    }

    fn mesh(&self) -> TriangleMesh {
        let kept = || self.triangles.iter().filter(|triangle| !triangle.is_deleted);
        let mut numbers = vec![None; self.vertices.len()];
        kept().flat_map(|triangle| triangle.vertices).for_each(|vertex| numbers[vertex] = Some(0));
        let mut mesh = TriangleMesh::default();
        for (number, vertex) in numbers.iter_mut().zip(&self.vertices) {
            if let Some(number) = number {
                *number = mesh.positions.len() as u32;
                let point = vertex.point.to_array();
                mesh.positions.push(point.map(|x| f64::from(x as f32)));
            }
        }
        let triangle = |triangle: &Triangle| {
            triangle.vertices.map(|vertex| numbers[vertex].unwrap_or_default())
        };
        mesh.triangles = kept().map(triangle).collect();
        mesh
    }
}

/// Of 3 by 3 entries, row by row; terms in its order, since near zero rounding decides.
fn determinant(q: &Quadric, entries: [usize; 9]) -> f64 {
    let [a, b, c, d, e, f, g, h, i] = entries.map(|entry| q[entry]);
    a * e * i + c * d * h + b * f * g - c * e * g - a * f * h - b * d * i
}

fn normalized(vector: Vector) -> Vector {
    let length = vector.length();
    if length > 0.0 { vector / length } else { Vector::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::uv_sphere;

    #[test]
    fn a_sphere_loses_a_fifth_of_its_triangles_and_stays_a_sphere() {
        let sphere = uv_sphere(20, 1.0);
        let simplified = simplify(&sphere, 0.8);
        assert_eq!(simplified.triangles.len(), sphere.triangles.len() * 4 / 5);
        let radii = simplified.positions.iter().map(|&point| Vector::from(point).length());
        assert!(radii.into_iter().all(|radius| (0.95..1.05).contains(&radius)));
    }
}
