//! Boxes, coordinates, vectors, and triangle meshes: one that is borrowed, which every function
//! takes, and one that is owned.

pub(crate) mod blocks;
pub(crate) mod plane;
pub mod vector;

use crate::error::Error;
use vector::{Vector, area_normal, as_vectors, six_volumes};

pub(crate) use vector::Turns;

/// A coordinate: `f32` or `f64`.
pub trait Coordinate: Copy + Into<f64> + sealed::Sealed {
    /// The same number in double precision.
    #[inline]
    fn to_f64(self) -> f64 {
        self.into()
    }
}

impl Coordinate for f32 {}

impl Coordinate for f64 {}

/// Positions of one of the two types, so that what takes them needs no type parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Positions<'a> {
    /// In single precision.
    Single(&'a [[f32; 3]]),
    /// In double precision.
    Double(&'a [[f64; 3]]),
}

impl Positions<'_> {
    fn len(&self) -> usize {
        match self {
            Self::Single(positions) => positions.len(),
            Self::Double(positions) => positions.len(),
        }
    }

    #[inline]
    fn get(&self, vertex: usize) -> Option<[f64; 3]> {
        match self {
            Self::Single(positions) => positions.get(vertex).map(|point| point.map(f64::from)),
            Self::Double(positions) => positions.get(vertex).copied(),
        }
    }
}

mod sealed {
    use super::Positions;

    pub trait Sealed: Sized {
        fn positions(positions: &[[Self; 3]]) -> Positions<'_>;
    }

    impl Sealed for f32 {
        fn positions(positions: &[[Self; 3]]) -> Positions<'_> {
            Positions::Single(positions)
        }
    }

    impl Sealed for f64 {
        fn positions(positions: &[[Self; 3]]) -> Positions<'_> {
            Positions::Double(positions)
        }
    }
}

/// An axis-aligned box, in the input's units.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Bounds {
    /// The least coordinates.
    pub min: [f64; 3],
    /// The greatest coordinates.
    pub max: [f64; 3],
}

/// Which sides of a triangle a renderer draws. Files say so by material.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Sidedness {
    /// The side from which its corners run counter-clockwise.
    #[default]
    One,
    /// Both sides.
    Two,
}

/// A mesh that is borrowed: positions in `f32` or `f64`, and triangles that index them.
///
/// Every function that takes a mesh takes `impl Into<MeshView>`: a `MeshView`, a reference to a
/// [`TriangleMesh`], to a [`Hull`](crate::Hull) or a [`ConvexHull`](crate::ConvexHull), or to what
/// a reader of files returns. It is free to copy. Nothing is checked before a function uses it.
///
/// ```
/// use hullwright::MeshView;
///
/// let positions = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let triangles = [[0, 1, 2]];
/// let mesh = MeshView::new(&positions, &triangles);
/// assert_eq!(mesh.vertex_count(), 3);
/// assert_eq!(mesh.position(1), Some([1.0, 0.0, 0.0]));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshView<'a> {
    positions: Positions<'a>,
    triangles: &'a [[u32; 3]],
    sidedness: &'a [Sidedness],
}

impl<'a> MeshView<'a> {
    /// Positions in `f32` or `f64`, in any unit, and triangles that index them.
    pub fn new<C: Coordinate>(positions: &'a [[C; 3]], triangles: &'a [[u32; 3]]) -> Self {
        Self { positions: C::positions(positions), triangles, sidedness: &[] }
    }

    /// The same mesh with a sidedness for each triangle; empty where it is not known.
    #[must_use]
    pub fn with_sidedness(self, sidedness: &'a [Sidedness]) -> Self {
        Self { sidedness, ..self }
    }

    /// Number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.positions.len()
    }

    /// A vertex, or `None` where there is none of this index.
    #[inline]
    pub fn position(&self, vertex: u32) -> Option<[f64; 3]> {
        self.positions.get(vertex as usize)
    }

    /// All vertices, in double precision.
    pub fn positions(&self) -> impl ExactSizeIterator<Item = [f64; 3]> + Clone + use<'a> {
        let positions = self.positions;
        (0..positions.len()).map(move |vertex| positions.get(vertex).unwrap_or_default())
    }

    /// All vertices.
    pub(crate) fn points(&self) -> impl ExactSizeIterator<Item = Vector> + Clone + use<'a> {
        self.positions().map(Vector::from)
    }

    /// The triangles.
    pub fn triangles(&self) -> &'a [[u32; 3]] {
        self.triangles
    }

    /// Whether all vertices of triangles are there.
    ///
    /// # Errors
    /// [`Error::IndexOutOfRange`] for the first triangle with one that is not.
    pub(crate) fn check_indices(&self) -> Result<(), Error> {
        let vertices = self.vertex_count();
        for (triangle, corners) in self.triangles.iter().enumerate() {
            if let Some(&index) = corners.iter().find(|&&index| index as usize >= vertices) {
                return Err(Error::IndexOutOfRange { triangle, index, vertices });
            }
        }
        Ok(())
    }

    /// Which sides of a triangle are drawn, where that is known.
    pub fn sidedness(&self, triangle: u32) -> Option<Sidedness> {
        self.sidedness.get(triangle as usize).copied()
    }

    /// For how many triangles it is known which sides are drawn.
    pub(crate) fn sidedness_count(&self) -> usize {
        self.sidedness.len()
    }

    /// A copy that owns what it holds. O(size).
    pub fn to_owned(&self) -> TriangleMesh {
        TriangleMesh {
            positions: self.positions().collect(),
            triangles: self.triangles.to_vec(),
            sidedness: self.sidedness.to_vec(),
        }
    }

    /// A vertex that is known to exist; the origin where it does not.
    #[inline]
    pub(crate) fn at(&self, vertex: u32) -> Vector {
        self.position(vertex).unwrap_or_default().into()
    }
}

/// A mesh that is owned: vertices in double precision, and triangles that index them.
#[derive(Debug, Clone, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TriangleMesh {
    /// Vertices, in any unit.
    pub positions: Vec<[f64; 3]>,
    /// Triangles; each index should be below the number of positions.
    pub triangles: Vec<[u32; 3]>,
    /// Which sides of each triangle are drawn; empty where that is not known.
    pub sidedness: Vec<Sidedness>,
}

impl TriangleMesh {
    /// A mesh for which it is unknown which sides are drawn.
    pub fn new(positions: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> Self {
        Self { positions, triangles, sidedness: Vec::new() }
    }

    /// A mesh of any points that turn into arrays: those of glam, mint and nalgebra do. O(size).
    ///
    /// ```
    /// use hullwright::TriangleMesh;
    ///
    /// let points = [glam::Vec3::ZERO, glam::Vec3::X, glam::Vec3::Y];
    /// let mesh = TriangleMesh::from_points::<f32, _>(points, vec![[0, 1, 2]]);
    /// assert_eq!(mesh.positions[1], [1.0, 0.0, 0.0]);
    /// ```
    pub fn from_points<C: Coordinate, P: Into<[C; 3]>>(
        points: impl IntoIterator<Item = P>,
        triangles: Vec<[u32; 3]>,
    ) -> Self {
        let positions = points.into_iter().map(|point| point.into().map(Coordinate::to_f64));
        Self::new(positions.collect(), triangles)
    }

    /// The vertices as vectors.
    #[inline]
    pub(crate) fn points(&self) -> &[Vector] {
        as_vectors(&self.positions)
    }

    /// The mesh as every function takes it.
    pub fn view(&self) -> MeshView<'_> {
        MeshView::new(&self.positions, &self.triangles).with_sidedness(&self.sidedness)
    }

    /// Where the vertices of some triangles are, each once, in their order.
    pub(crate) fn positions_of(&self, triangles: impl Iterator<Item = u32>) -> Vec<Vector> {
        let corners = |triangle: u32| self.triangles[triangle as usize];
        let mut vertices: Vec<u32> = triangles.flat_map(corners).collect();
        vertices.sort_unstable();
        vertices.dedup();
        vertices.iter().map(|&vertex| self.points()[vertex as usize]).collect()
    }

    /// Where the corners of a triangle are, whose indices all exist.
    #[inline]
    pub(crate) fn corners(&self, triangle: [u32; 3]) -> [Vector; 3] {
        triangle.map(|vertex| self.points()[vertex as usize])
    }

    /// Twice the area of a triangle times its unit normal.
    #[inline]
    pub(crate) fn area_normal(&self, triangle: u32) -> Vector {
        let [a, b, c] = self.corners(self.triangles[triangle as usize]);
        area_normal(a, b, c)
    }

    /// The area of the surface.
    pub(crate) fn area(&self) -> f64 {
        let triangles = 0..self.triangles.len() as u32;
        triangles.map(|triangle| 0.5 * self.area_normal(triangle).length()).sum()
    }

    /// Whether the signed volume under the surface, seen from the origin, is not positive.
    pub(crate) fn encloses_nothing(&self) -> bool {
        let corners = self.triangles.iter().map(|&triangle| self.corners(triangle));
        six_volumes(corners) <= 0.0
    }
}

impl<'a> From<&'a TriangleMesh> for MeshView<'a> {
    fn from(mesh: &'a TriangleMesh) -> Self {
        mesh.view()
    }
}

impl<'a> From<&MeshView<'a>> for MeshView<'a> {
    fn from(mesh: &MeshView<'a>) -> Self {
        *mesh
    }
}

impl<'a, C: Coordinate> From<(&'a [[C; 3]], &'a [[u32; 3]])> for MeshView<'a> {
    fn from((positions, triangles): (&'a [[C; 3]], &'a [[u32; 3]])) -> Self {
        Self::new(positions, triangles)
    }
}
