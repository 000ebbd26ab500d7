//! What a position may be made of: `f32` or `f64`.

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// A coordinate: `f32` or `f64`.
pub trait Coordinate: Copy + sealed::Sealed {
    /// The same number in double precision.
    fn to_f64(self) -> f64;
}

impl Coordinate for f32 {
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
}

impl Coordinate for f64 {
    fn to_f64(self) -> f64 {
        self
    }
}
