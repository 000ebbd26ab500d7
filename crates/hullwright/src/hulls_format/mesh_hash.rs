//! The content of a mesh as one number.

use std::fmt;
use std::str::FromStr;

use sha2::{Digest, Sha256};

use crate::geometry::MeshView;
use crate::parameters::ParseError;

/// Hash of the corners of a mesh's triangles, in single precision, in the file's order.
///
/// It does not depend on how vertices are shared, numbered or left over, nor on the corner that a
/// triangle begins with: readers of files differ in that, and a decomposition does not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct MeshHash([u8; 32]);

/// Hashes of other things never equal these.
const CONTEXT: &str = "hullwright 2026-11 corners of triangles in f32";

/// Triangles that are hashed at once.
const TRIANGLES_AT_ONCE: usize = 256;

/// Of a triangle.
const BYTES: usize = 3 * 3 * size_of::<f32>();

impl MeshHash {
    /// Hashes a mesh. O(triangles).
    ///
    /// ```
    /// use hullwright::{MeshView, hulls_format::MeshHash};
    ///
    /// let positions = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [9.0, 9.0, 9.0]];
    /// let hash = MeshHash::of(MeshView::new(&positions, &[[0, 1, 2]]));
    /// assert_eq!(hash, MeshHash::of(MeshView::new(&positions[..3], &[[1, 2, 0]])));
    /// assert_ne!(hash, MeshHash::of(MeshView::new(&positions[..3], &[[1, 0, 2]])));
    /// ```
    pub fn of<'a>(mesh: impl Into<MeshView<'a>>) -> Self {
        let mut hasher = Sha256::new();
        give_bytes(mesh.into(), |bytes| hasher.update(bytes));
        Self(hasher.finalize().into())
    }

    /// What is hashed by SHA-256. O(triangles).
    pub fn message<'a>(mesh: impl Into<MeshView<'a>>) -> Vec<u8> {
        let mesh = mesh.into();
        let mut message = Vec::with_capacity(CONTEXT.len() + BYTES * mesh.triangles().len());
        give_bytes(mesh, |bytes| message.extend(bytes));
        message
    }

    /// From the bytes of a hash.
    pub const fn from_bytes(bytes: [u8; 32]) -> Self {
        Self(bytes)
    }

    /// The bytes of the hash.
    pub const fn as_bytes(&self) -> &[u8; 32] {
        &self.0
    }
}

/// Gives the bytes of a mesh that are hashed, some triangles at a time.
fn give_bytes(mesh: MeshView<'_>, mut take: impl FnMut(&[u8])) {
    take(CONTEXT.as_bytes());
    let mut bytes = Vec::with_capacity(BYTES * TRIANGLES_AT_ONCE);
    for triangles in mesh.triangles().chunks(TRIANGLES_AT_ONCE) {
        bytes.clear();
        for triangle in triangles {
            // The negative zero is the same place.
            let coordinate = |x: f64| (x as f32 + 0.0).to_le_bytes();
            let mut corners = triangle.map(|v| mesh.at(v).to_array().map(coordinate));
            // Beginning with the least corner, wound as before.
            let least = (0..3).min_by_key(|&index| corners[index]).unwrap_or_default();
            corners.rotate_left(least);
            bytes.extend(corners.as_flattened().as_flattened());
        }
        take(&bytes);
    }
}

/// In hexadecimal digits.
impl fmt::Display for MeshHash {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(formatter, "{byte:02x}"))
    }
}

impl FromStr for MeshHash {
    type Err = ParseError;

    /// Reads what [`Display`](fmt::Display) writes, in digits of either case.
    fn from_str(text: &str) -> Result<Self, ParseError> {
        let digit = |c: u8| (c as char).to_digit(16).map(|digit| digit as u8);
        let (pairs, rest) = text.as_bytes().as_chunks::<2>();
        let bytes: Option<Vec<u8>> =
            pairs.iter().map(|[high, low]| Some(digit(*high)? << 4 | digit(*low)?)).collect();
        let bytes = bytes.filter(|_| rest.is_empty()).and_then(|bytes| bytes.try_into().ok());
        bytes.map(Self).ok_or_else(|| ParseError::new(text, "64 hexadecimal digits"))
    }
}
