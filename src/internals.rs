//! What the command and the laboratory print.
//!
//! There is no promise of stability: any version may change or drop what is here.

#[cfg(feature = "io")]
pub mod terminal;
