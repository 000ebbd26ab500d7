//! The way in: `decompose`, and `Decomposer` which does the same in slices.

use crate::{Control, Decomposition, Error, Parameters};

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

/// Decomposes a triangle mesh into convex hulls.
///
/// # Errors
/// See [`Error`]. It never panics.
pub fn decompose<C: Coordinate>(
    positions: &[[C; 3]],
    triangles: &[[u32; 3]],
    parameters: &Parameters,
    control: &Control,
) -> Result<Decomposition, Error> {
    let mut decomposer = Decomposer::new(positions, triangles, parameters)?;
    loop {
        if let Some(decomposition) = decomposer.step(control)? {
            return Ok(decomposition);
        }
    }
}

/// The same work as [`decompose`], in slices.
pub struct Decomposer {}

impl Decomposer {
    /// Checks the input and the parameters and takes a copy of them.
    ///
    /// # Errors
    /// See [`Error`].
    pub fn new<C: Coordinate>(
        positions: &[[C; 3]],
        triangles: &[[u32; 3]],
        parameters: &Parameters,
    ) -> Result<Self, Error> {
        parameters.validate()?;
        if positions.is_empty() || triangles.is_empty() {
            return Err(Error::EmptyMesh { vertices: positions.len(), triangles: triangles.len() });
        }
        Ok(Self {})
    }

    /// Does the next slice of work. `None` while there is more to do.
    ///
    /// # Errors
    /// See [`Error`].
    pub fn step(&mut self, control: &Control) -> Result<Option<Decomposition>, Error> {
        control.check()?;
        Err(Error::NoHull { reason: "the method is not connected yet" })
    }
}
