//! Which vertices are merged: those in the same cell of a grid whose normals point into the same
//! octant (Rossignac and Borrel 1993, with octants so that the two sides of a wall stay apart).

use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, add, area_normal, bounds, dot, length_squared, subtract};
use crate::mesh::TriangleMesh;

/// A cell and an octant (3 bits) share a 32-bit key.
const MAX_CELLS: f64 = (1_u64 << 29) as f64;

/// Octants are bounded by the planes normal to these axes. The axes are oblique: many meshes have
/// sides along the coordinate axes, and noise in their normals would divide each side.
const AXES: [Vector; 3] = [[0.51, 0.71, 0.48], [-0.83, 0.27, 0.49], [0.22, -0.65, 0.73]];

/// Which vertices become one.
pub(super) struct VertexClusters {
    /// For each vertex its cluster.
    pub of: Vec<u32>,
    pub count: usize,
}

impl VertexClusters {
    /// By grid cells of side `size` and by octants of normals; `None` if there are too many cells.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub(super) fn new(
        surface: &TriangleMesh,
        size: f64,
        control: &Control,
    ) -> Result<Option<Self>, Error> {
        let (min, max) = bounds(surface.positions.iter().copied());
        let counts = subtract(max, min).map(|extent| (extent / size).floor() + 1.0);
        if counts.iter().product::<f64>() > MAX_CELLS {
            return Ok(None);
        }
        let [width, height, _] = counts.map(|count| count as u64);
        let mut normals = vec![[0.0; 3]; surface.positions.len()];
        for triangle in &surface.triangles {
            let [a, b, c] = triangle.map(|vertex| surface.positions[vertex as usize]);
            let normal = area_normal(a, b, c);
            for &vertex in triangle {
                normals[vertex as usize] = add(normals[vertex as usize], normal);
            }
        }
        control.check()?;
        let vertices = (0_u64..).zip(surface.positions.iter().zip(&normals));
        let mut keys: Vec<u64> = vertices
            .map(|(vertex, (&position, &normal))| {
                let [x, y, z] = subtract(position, min).map(|x| (x / size) as u64);
                let cell = (z * height + y) * width + x;
                let octant = AXES
                    .iter()
                    .fold(0, |octant, &axis| 2 * octant + u64::from(dot(axis, normal) > 0.0));
                (cell * 8 + octant) << 32 | vertex
            })
            .collect();
        control.check()?;
        keys.sort_unstable();
        control.check()?;
        let mut of = vec![0; keys.len()];
        let mut count = 0;
        for cluster in keys.chunk_by(|a, b| a >> 32 == b >> 32) {
            for &key in cluster {
                of[(key & u64::from(u32::MAX)) as usize] = count;
            }
            count += 1;
        }
        Ok(Some(Self { of, count: count as usize }))
    }

    /// Separates the corners of triangles that would collapse although a side is longer than
    /// `longest`, such as the tip of a needle.
    pub(super) fn separate_long(&mut self, surface: &TriangleMesh, longest: f64) {
        let is_long = |&[a, b, c]: &[u32; 3]| {
            let squared = |from: u32, to: u32| {
                let [from, to] = [from, to].map(|vertex| surface.positions[vertex as usize]);
                length_squared(subtract(to, from))
            };
            squared(a, b).max(squared(b, c)).max(squared(c, a)) > longest * longest
        };
        let mut is_separate = vec![false; self.of.len()];
        for triangle in surface.triangles.iter().filter(|&triangle| !self.keeps(triangle)) {
            if is_long(triangle) {
                triangle.iter().for_each(|&vertex| is_separate[vertex as usize] = true);
            }
        }
        for (cluster, _) in
            self.of.iter_mut().zip(is_separate).filter(|(_, is_separate)| *is_separate)
        {
            *cluster = self.count as u32;
            self.count += 1;
        }
        self.renumber();
    }

    /// Separates the vertices of clusters that would keep no triangle, as those of a narrow ribbon.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub(super) fn separate_lost(
        &mut self,
        surface: &TriangleMesh,
        control: &Control,
    ) -> Result<(), Error> {
        loop {
            control.check()?;
            let mut has_triangle = vec![false; self.count];
            for triangle in surface.triangles.iter().filter(|&triangle| self.keeps(triangle)) {
                triangle.iter().for_each(|&v| has_triangle[self.of[v as usize] as usize] = true);
            }
            let before = self.count;
            let mut is_taken = vec![false; before];
            for cluster in &mut self.of {
                if !has_triangle[*cluster as usize] {
                    if is_taken[*cluster as usize] {
                        *cluster = self.count as u32;
                        self.count += 1;
                    } else {
                        is_taken[*cluster as usize] = true;
                    }
                }
            }
            if self.count == before {
                return Ok(());
            }
        }
    }

    /// Whether a triangle does not collapse: its corners are in three clusters.
    pub(super) fn keeps(&self, triangle: &[u32; 3]) -> bool {
        let [a, b, c] = triangle.map(|vertex| self.of[vertex as usize]);
        a != b && b != c && c != a
    }

    /// Removes gaps in the numbering; the order stays.
    fn renumber(&mut self) {
        let mut numbers = vec![0_u32; self.count];
        self.of.iter().for_each(|&cluster| numbers[cluster as usize] = 1);
        let mut count = 0;
        for number in numbers.iter_mut().filter(|number| **number == 1) {
            *number = count;
            count += 1;
        }
        self.of.iter_mut().for_each(|cluster| *cluster = numbers[*cluster as usize]);
        self.count = count as usize;
    }
}
