//! Judges hulls without any code of the crate: by exact predicates, and by distances and winding
//! numbers of brute force. Tests, fuzz targets and the laboratory share it.
//!
//! Only what the solid is, is the crate's to say: the repaired mesh with its openings closed.

pub mod exact;
pub mod nearest;
pub mod oracle;
pub mod paths;
pub mod sampling;
