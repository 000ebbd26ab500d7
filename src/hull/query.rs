//! What can be asked of a hull that has been built: its faces, its volume, what lies outside.

use super::builder::HullBuilder;
use super::face::{Face, NONE, Plane};
use super::simplex::Shape;
use crate::geometry::vector::{Vector, cubed};

/// Points that are compared with a face at once.
const LANES: usize = 4;

impl HullBuilder {
    /// The farthest that one of the points lies in front of a face, in their units; negative if
    /// all are inside.
    pub(crate) fn farthest_outside(&self, points: &[[f64; 3]]) -> f64 {
        let mut farthest = f64::NEG_INFINITY;
        let (blocks, rest) = points.as_chunks::<LANES>();
        for &block in blocks {
            farthest = farthest.max(self.farthest_of(block));
        }
        let (pairs, rest) = rest.as_chunks::<2>();
        for &pair in pairs {
            farthest = farthest.max(self.farthest_of(pair));
        }
        for &point in rest {
            farthest = farthest.max(self.farthest_of([point; 2]));
        }
        farthest / self.factor
    }

    /// The same in the scaled space, for a few points side by side.
    #[inline]
    fn farthest_of<const N: usize>(&self, points: [Vector; N]) -> f64 {
        let points = points.map(|point| self.inward(point));
        let [x, y, z] = [0, 1, 2].map(|axis| points.map(|point| point[axis]));
        let mut farthest = [f64::NEG_INFINITY; N];
        for face in &self.faces {
            let Face { plane: Plane { normal, offset }, inverse, .. } = *face;
            for lane in 0..N {
                let height = normal[0] * x[lane] + normal[1] * y[lane] + normal[2] * z[lane];
                let distance = (height - offset) * inverse;
                farthest[lane] = if distance > farthest[lane] { distance } else { farthest[lane] };
            }
        }
        farthest.into_iter().fold(f64::NEG_INFINITY, f64::max)
    }

    /// Whether no point lies farther than `tolerance`, in the points' units, in front of a face.
    /// False if there is no hull. O(faces) for a point inside, far less for most others.
    ///
    /// ```
    /// let mut builder = hullwright::hull::HullBuilder::new();
    /// builder.build(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    /// assert!(builder.contains_all(&[[0.1; 3]], 0.0));
    /// assert!(!builder.contains_all(&[[1.0; 3]], 0.1));
    /// ```
    pub fn contains_all(&self, points: &[[f64; 3]], tolerance: f64) -> bool {
        let limit = tolerance * self.factor;
        !self.faces.is_empty()
            && points.iter().all(|&point| {
                let point = self.inward(point);
                self.faces.iter().all(|face| face.distance(point) <= limit)
            })
    }

    /// The faces that the last insertion made; all faces after `build`.
    pub(super) fn newest(&self) -> impl Iterator<Item = &Face> + '_ {
        let faces = self.faces.iter().zip(&self.waiting);
        faces.filter(|(_, waiting)| waiting.generation == self.generation).map(|(face, _)| face)
    }

    /// The corners of the faces that the last insertion made; of all faces after `build`.
    pub(crate) fn new_faces(&self) -> impl Iterator<Item = [Vector; 3]> + '_ {
        self.newest().map(|face| face.vertices.map(|vertex| self.originals[vertex as usize]))
    }

    /// The vertices of those faces, with repetitions.
    pub(super) fn newest_vertices(&self) -> impl Iterator<Item = u32> + '_ {
        self.newest().flat_map(|face| face.vertices)
    }

    /// Corners of all faces.
    pub(crate) fn all_faces(&self) -> impl Iterator<Item = [Vector; 3]> + '_ {
        self.faces.iter().map(|face| face.vertices.map(|vertex| self.originals[vertex as usize]))
    }

    /// Enclosed volume, in cubed units of the points.
    pub(crate) fn volume(&self) -> f64 {
        // Six times the tetrahedron between a face and the centre is the height of the centre.
        let six: f64 = self.faces.iter().map(|face| face.plane.offset).sum();
        six / (6.0 * cubed(self.factor))
    }

    /// Number of triangles of the hull; 0 if there is none.
    ///
    /// ```
    /// let mut builder = hullwright::hull::HullBuilder::new();
    /// builder.build(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    /// assert_eq!(builder.triangle_count(), 4);
    /// ```
    pub fn triangle_count(&self) -> usize {
        self.faces.len()
    }

    /// The hull's vertices, as given, and its triangles; both empty if there is no hull.
    ///
    /// ```
    /// let mut builder = hullwright::hull::HullBuilder::new();
    /// builder.build(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    /// let (points, triangles) = builder.extract();
    /// assert_eq!((points.len(), triangles.len()), (4, builder.triangle_count()));
    /// ```
    pub fn extract(&mut self) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
        self.marks.clear();
        self.marks.resize(self.points.len(), NONE);
        let mut vertices = Vec::with_capacity(self.faces.len() / 2 + 2);
        let mut triangles = Vec::with_capacity(self.faces.len());
        for face in &self.faces {
            let mut triangle = face.vertices;
            for corner in &mut triangle {
                let vertex = *corner as usize;
                let mut mark = self.marks[vertex];
                if mark == NONE {
                    mark = vertices.len() as u32;
                    self.marks[vertex] = mark;
                    vertices.push(self.originals[vertex]);
                }
                *corner = mark;
            }
            triangles.push(triangle);
        }
        (vertices, triangles)
    }

    /// Builds the hull of points, for its vertices alone; `None` if there is no hull.
    pub(crate) fn vertices_of(&mut self, points: &[[f64; 3]]) -> Option<Vec<[f64; 3]>> {
        (self.build(points) == Shape::Solid).then(|| self.extract().0)
    }

    /// For each of the points, if all were finite, a triangle of `extract` that it is a corner of.
    pub(crate) fn faces_of_points(&self, faces: &mut Vec<Option<u32>>) {
        faces.clear();
        faces.resize(self.points.len(), None);
        for (index, face) in (0..).zip(&self.faces) {
            for vertex in face.vertices {
                faces[vertex as usize] = Some(index);
            }
        }
    }

    /// The smallest distance between a face and the vertex farthest behind it, with that face's
    /// outward normal: the width of the hull, in the units of the points.
    pub(super) fn width(&self) -> Option<(f64, Vector)> {
        let mut used: Vec<u32> = self.faces.iter().flat_map(|face| face.vertices).collect();
        used.sort_unstable();
        used.dedup();
        let depth = |face: &Face| {
            used.iter().map(|&v| -face.distance(self.points[v as usize])).fold(0.0, f64::max)
        };
        let widths =
            self.faces.iter().filter(|face| face.inverse > 0.0).map(|face| {
                (depth(face) / self.factor, face.plane.normal.map(|x| x * face.inverse))
            });
        widths.min_by(|a, b| a.0.total_cmp(&b.0))
    }
}
