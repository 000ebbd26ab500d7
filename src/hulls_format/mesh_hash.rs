//! Names a mesh by its content.

use std::fmt;

use sha2::{Digest, Sha256};

use crate::geometry::MeshView;

/// Hash of the corners of a mesh's triangles, in single precision, in the file's order.
///
/// It does not depend on how vertices are shared, numbered or left over, nor on the corner that a
/// triangle begins with: readers of files differ in that, and a decomposition does not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct MeshHash([u8; 32]);

/// Hashes of other things never equal these.
const CONTEXT: &str = "hullwright 2026-11 corners of triangles in f32";

/// A corner's bytes.
const CORNER: usize = 12;

/// Triangles that are handed to the hasher at once.
const TRIANGLES_AT_ONCE: usize = 256;

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
        let mesh = mesh.into();
        let mut hasher = Sha256::new_with_prefix(CONTEXT);
        let mut bytes = Vec::with_capacity(3 * CORNER * TRIANGLES_AT_ONCE);
        for triangles in mesh.triangles().chunks(TRIANGLES_AT_ONCE) {
            bytes.clear();
            for triangle in triangles {
                let corners = triangle.map(|vertex| corner(mesh.at(vertex)));
                rotated(corners).iter().for_each(|corner| bytes.extend(corner));
            }
            hasher.update(&bytes);
        }
        Self(hasher.finalize().into())
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

/// In hexadecimal digits.
impl fmt::Display for MeshHash {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(formatter, "{byte:02x}"))
    }
}

fn corner(point: [f64; 3]) -> [u8; CORNER] {
    let mut bytes = [0; CORNER];
    for (bytes, x) in bytes.as_chunks_mut::<4>().0.iter_mut().zip(point) {
        // The negative zero is the same place.
        *bytes = (x as f32 + 0.0).to_le_bytes();
    }
    bytes
}

/// Beginning with the least corner, wound as before.
fn rotated([a, b, c]: [[u8; CORNER]; 3]) -> [[u8; CORNER]; 3] {
    if a <= b && a <= c {
        [a, b, c]
    } else if b <= c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}
