//! Sums of angles.

use std::f64::consts::TAU;

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

    /// Adds the argument of a complex number, between -π and π. After a few, [`rescale`](Self::rescale).
    #[inline(always)]
    pub fn add(&mut self, real: f64, imaginary: f64) {
        let before = self.imaginary;
        let next_real = self.real * real - before * imaginary;
        let next = self.real * imaginary + before * real;
        self.whole += i32::from((before >= 0.0) & (imaginary >= 0.0) & (next < 0.0));
        self.whole -= i32::from((before < 0.0) & (imaginary < 0.0) & (next >= 0.0));
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
