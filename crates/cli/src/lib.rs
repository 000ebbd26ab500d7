//! What the command `hullwright` and the laboratory share: [printing](terminal), [pages](viewer)
//! that show a mesh and its hulls in a browser, and [pictures](render) of them.
//!
//! There is no promise of stability beyond the command's: whoever draws from Rust pins the version.

#[cfg(feature = "command")]
pub mod render;
#[cfg(feature = "command")]
pub mod terminal;
pub mod viewer;

/// A point or a direction.
type Vector = glam::DVec3;

/// The least and the greatest corner of points' bounding box; inside out without any.
fn bounds(points: impl IntoIterator<Item = Vector>) -> (Vector, Vector) {
    let nothing = (Vector::INFINITY, Vector::NEG_INFINITY);
    // In this order, coordinates that are not numbers are passed over.
    let with = |(min, max), point: Vector| (point.min(min), point.max(max));
    points.into_iter().fold(nothing, with)
}

/// An error about what can't be written.
fn unwritable(what: &str, reason: impl std::fmt::Display) -> hullwright::Error {
    let source = hullwright::FileError::Content(reason.to_string());
    hullwright::Error::File { path: what.into(), source }
}
