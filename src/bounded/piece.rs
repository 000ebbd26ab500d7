//! Pieces.
use super::solid::Solid;
use crate::hull::{HullBuilder, Shape, solid_hull};
use crate::vector::{Vector, add, area_normal, cross, dot, length_squared, maximum, minimum, scale, subtract};

#[derive(Debug, Clone, Default)]
pub(crate) struct Piece {
    /// Vertices of the hull of what the piece covers.
    pub points: Vec<Vector>,
    /// Faces over `points`; empty if they have no volume.
    pub triangles: Vec<[u32; 3]>,
    pub volume: f64,
    pub min: Vector,
    pub max: Vector,
    /// Sum of area normals of its surface.
    pub outward: Vector,
    pub area: f64,
    pub seeds: Vec<u32>,
}

pub(crate) struct Workshop<'a> {
    pub solid: &'a Solid,
    pub bound: f64,
    pub builder: HullBuilder,
    pub reducer: HullBuilder,
    pub stack: Vec<[Vector; 3]>,
    pub scratch: Vec<Vector>,
    pub built: usize,
    pub tested: usize,
}

pub(crate) fn volume_of(points: &[Vector], triangles: &[[u32; 3]]) -> f64 {
    let Some(&apex) = points.first() else { return 0.0 };
    triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|i| subtract(points[i as usize], apex));
            dot(a, cross(b, c))
        })
        .sum::<f64>()
        / 6.0
}

impl<'a> Workshop<'a> {
    pub fn new(solid: &'a Solid, bound: f64) -> Self {
        Self { solid, bound, builder: HullBuilder::new().with_least_tolerance(1e-5), reducer: HullBuilder::new().with_least_tolerance(super::env("REDUCE", 0.0005)), stack: Vec::new(), scratch: Vec::new(), built: 0, tested: 0 }
    }

    /// A hull of fewer points that leaves out none by more than the reduction.
    pub fn reduced(&mut self, points: &[Vector], outward: Vector, area: f64) -> Piece {
        std::mem::swap(&mut self.builder, &mut self.reducer);
        let piece = self.hull(points, outward, area);
        std::mem::swap(&mut self.builder, &mut self.reducer);
        piece
    }

    /// The hull of points, whether it fits or not.
    pub fn hull(&mut self, points: &[Vector], outward: Vector, area: f64) -> Piece {
        self.built += 1;
        let (points, triangles) = match self.builder.build(points) {
            Shape::Solid => self.builder.extract(),
            _ => (points.to_vec(), Vec::new()),
        };
        let (mut min, mut max) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for &p in &points {
            min = minimum(min, p);
            max = maximum(max, p);
        }
        let volume = volume_of(&points, &triangles);
        Piece { points, triangles, volume, min, max, outward, area, seeds: Vec::new() }
    }

    pub fn fits(&mut self, piece: &Piece) -> bool {
        self.tested += 1;
        if piece.triangles.is_empty() {
            let Ok((hull, _)) = solid_hull(&mut self.builder, &piece.points, piece.outward, 1e-6) else {
                return true;
            };
            return self.faces_fit(&hull.points, &hull.triangles);
        }
        self.faces_fit(&piece.points, &piece.triangles)
    }

    fn faces_fit(&mut self, points: &[Vector], triangles: &[[u32; 3]]) -> bool {
        let mut order: Vec<(f64, [Vector; 3])> = triangles
            .iter()
            .map(|t| {
                let f = t.map(|i| points[i as usize]);
                (length_squared(area_normal(f[0], f[1], f[2])), f)
            })
            .collect();
        order.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
        // A quick refusal by the centres of the largest faces.
        for (_, f) in order.iter().take(6) {
            let centre = scale(add(add(f[0], f[1]), f[2]), 1.0 / 3.0);
            if !self.solid.holds(centre, self.bound) {
                return false;
            }
        }
        order.iter().all(|(_, f)| self.solid.face_fits(*f, self.bound, &mut self.stack))
    }

    /// The joint hull, if it fits.
    pub fn joint(&mut self, a: &Piece, b: &Piece) -> Piece {
        let mut points = std::mem::take(&mut self.scratch);
        points.clear();
        points.extend_from_slice(&a.points);
        points.extend_from_slice(&b.points);
        let mut piece = self.hull(&points, add(a.outward, b.outward), a.area + b.area);
        self.scratch = points;
        piece.seeds.extend_from_slice(&a.seeds);
        piece.seeds.extend_from_slice(&b.seeds);
        piece
    }
}
