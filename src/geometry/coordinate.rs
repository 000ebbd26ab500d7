//! What a position may be made of: `f32` or `f64`.

/// A coordinate: `f32` or `f64`.
pub trait Coordinate: Copy + sealed::Sealed {
    /// The same number in double precision.
    fn to_f64(self) -> f64;
}

impl Coordinate for f32 {
    #[inline]
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
}

impl Coordinate for f64 {
    #[inline]
    fn to_f64(self) -> f64 {
        self
    }
}

/// Positions of one of the two types, so that what takes them needs no type parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Positions<'a> {
    /// In single precision.
    Single(&'a [[f32; 3]]),
    /// In double precision.
    Double(&'a [[f64; 3]]),
}

impl Positions<'_> {
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Single(positions) => positions.len(),
            Self::Double(positions) => positions.len(),
        }
    }

    #[inline]
    pub(super) fn get(&self, vertex: usize) -> Option<[f64; 3]> {
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
