//! Vectors: glam's inside, arrays at the public surface. Sums of angles.

use std::f64::consts::TAU;

use crate::sorting::sort_by_number;

/// A point or a direction.
pub type Vector = glam::DVec3;

/// Irrational steps of a low-discrepancy sequence in three dimensions (Roberts, "The unreasonable
/// effectiveness of quasirandom sequences", 2018).
const STEPS: Vector =
    Vector::new(0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_9);

/// Evenly spread points of a box.
pub fn spread_in_box(index: usize, min: Vector, max: Vector) -> Vector {
    let share = (Vector::splat(0.5) + STEPS * index as f64).map(f64::fract);
    min + share * (max - min)
}

/// `x * x`. Unlike `powi`, whose rounding is left to the compiler, the same everywhere.
#[inline]
pub fn squared(x: f64) -> f64 {
    x * x
}

/// `x * x * x`, likewise.
#[inline]
pub fn cubed(x: f64) -> f64 {
    x * x * x
}

/// The smaller of two numbers; the second if one is not a number. A single instruction, where
/// `f64::min` handles that first and is a call in WebAssembly.
#[inline(always)]
pub fn smaller<T: PartialOrd>(a: T, b: T) -> T {
    if a < b { a } else { b }
}

/// The larger of two numbers, likewise.
#[inline(always)]
pub fn larger<T: PartialOrd>(a: T, b: T) -> T {
    if a > b { a } else { b }
}

/// Arrays of coordinates as vectors, in place.
#[inline]
pub fn as_vectors(points: &[[f64; 3]]) -> &[Vector] {
    bytemuck::cast_slice(points)
}

/// Vectors as arrays of coordinates, in place.
#[inline]
pub fn as_arrays(points: &[Vector]) -> &[[f64; 3]] {
    bytemuck::cast_slice(points)
}

/// Arrays of coordinates as vectors, in the same memory.
#[inline]
pub fn into_vectors(points: Vec<[f64; 3]>) -> Vec<Vector> {
    bytemuck::cast_vec(points)
}

/// Vectors as arrays of coordinates, in the same memory.
#[inline]
pub fn into_arrays(points: Vec<Vector>) -> Vec<[f64; 3]> {
    bytemuck::cast_vec(points)
}

/// The least and the greatest corner of points' bounding box; inside out without any.
#[inline]
pub fn bounds(points: impl IntoIterator<Item = Vector>) -> (Vector, Vector) {
    let nothing = (Vector::INFINITY, Vector::NEG_INFINITY);
    // In this order, coordinates that are not numbers are passed over.
    let with = |(min, max), point: Vector| (point.min(min), point.max(max));
    points.into_iter().fold(nothing, with)
}

/// Diagonal of points' bounding box; 0 where that is not finite.
pub fn diagonal(points: impl IntoIterator<Item = Vector>) -> f64 {
    let (min, max) = bounds(points);
    let diagonal = min.distance(max);
    if diagonal.is_finite() { diagonal } else { 0.0 }
}

/// The average of points; the origin where there is none.
pub fn mean(points: &[Vector]) -> Vector {
    let sum = points.iter().fold(Vector::ZERO, |sum, &point| sum + point);
    sum * (1.0 / points.len().max(1) as f64)
}

/// The distance from a point to the segment between two others.
#[inline]
pub fn distance_to_segment(point: Vector, [start, end]: [Vector; 2]) -> f64 {
    let (arm, along) = (point - start, end - start);
    let squared = along.dot(along);
    let share = if squared > 0.0 { (arm.dot(along) / squared).clamp(0.0, 1.0) } else { 0.0 };
    arm.distance(along * share)
}

/// The centre of a triangle.
#[inline]
pub fn centre([a, b, c]: [Vector; 3]) -> Vector {
    (a + b + c) * (1.0 / 3.0)
}

/// The halves of a triangle across its longest side.
#[inline]
pub fn halves_of_triangle([a, b, c]: [Vector; 3]) -> [[Vector; 3]; 2] {
    let squared = |a: Vector, b: Vector| a.distance_squared(b);
    let (ab, bc, ca) = (squared(a, b), squared(b, c), squared(c, a));
    if ab >= bc && ab >= ca {
        let middle = (a + b) * 0.5;
        [[a, middle, c], [middle, b, c]]
    } else if bc >= ca {
        let middle = (b + c) * 0.5;
        [[a, b, middle], [a, middle, c]]
    } else {
        let middle = (c + a) * 0.5;
        [[a, b, middle], [middle, b, c]]
    }
}

/// Twice the area of a triangle times its unit normal.
#[inline]
pub fn area_normal(a: Vector, b: Vector, c: Vector) -> Vector {
    (b - a).cross(c - a)
}

/// Two halves of indices along the axis on which their centres extend the most.
pub fn halves(items: &mut [u32], centre: impl Fn(&u32) -> Vector) -> (&[u32], &[u32]) {
    let centres: Vec<Vector> = items.iter().map(centre).collect();
    sort_along_extent(items, &centres);
    items.split_at(items.len() / 2)
}

fn sort_along_extent(items: &mut [u32], centres: &[Vector]) {
    let (min, max) = bounds(centres.iter().copied());
    let extent = max - min;
    let axis = (0..3).max_by(|&a, &b| extent[a].total_cmp(&extent[b])).unwrap_or(0);
    let places = centres.iter().map(|centre| centre[axis]);
    let mut order: Vec<(f64, usize)> =
        places.zip(items.iter().map(|&item| item as usize)).collect();
    sort_by_number(&mut order);
    for (item, (_, sorted)) in items.iter_mut().zip(order) {
        *item = sorted as u32;
    }
}

/// Six times the signed volume between triangles and the origin.
pub fn six_volumes(triangles: impl Iterator<Item = [Vector; 3]>) -> f64 {
    triangles.map(|[a, b, c]| a.dot(b.cross(c))).sum()
}

/// The whole turn that the argument of a product of complex numbers does not show, by the signs of
/// the factors' imaginary parts and of the product's.
#[inline(always)]
pub fn whole_turn<T: PartialOrd + Default>(before: T, added: T, next: T) -> i32 {
    let zero = T::default();
    i32::from((before >= zero) & (added >= zero) & (next < zero))
        - i32::from((before < zero) & (added < zero) & (next >= zero))
}

/// A sum of angles as the argument of a product of complex numbers: one arc tangent serves for
/// all.
#[derive(Clone, Copy)]
pub(crate) struct Turns {
    real: f64,
    imaginary: f64,
    /// Whole turns, which the argument of the product does not show.
    whole: i32,
}

impl Turns {
    pub const NONE: Self = Self { real: 1.0, imaginary: 0.0, whole: 0 };

    /// The argument of a complex number, and whole turns.
    pub fn new(real: f64, imaginary: f64, whole: i32) -> Self {
        Self { real, imaginary, whole }
    }

    /// Adds the argument of a complex number, between -π and π. After a few,
    /// [`rescale`](Self::rescale).
    #[inline(always)]
    pub fn add(&mut self, real: f64, imaginary: f64) {
        let before = self.imaginary;
        let next_real = self.real * real - before * imaginary;
        let next = self.real * imaginary + before * real;
        self.whole += whole_turn(before, imaginary, next);
        (self.real, self.imaginary) = (next_real, next);
    }

    /// The sum of two sums.
    pub fn joined(mut self, other: Self) -> Self {
        self.add(other.real, other.imaginary);
        self.whole += other.whole;
        self
    }

    /// Keeps the product from becoming too large or too small.
    #[inline(always)]
    pub fn rescale(&mut self) {
        let size = self.real.abs() + self.imaginary.abs();
        self.real /= size;
        self.imaginary /= size;
    }

    /// The sum, in turns.
    pub fn total(self) -> f64 {
        libm::atan2(self.imaginary, self.real) / TAU + f64::from(self.whole)
    }
}
