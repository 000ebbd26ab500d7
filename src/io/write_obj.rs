//! Hulls as Wavefront OBJ.

use std::fmt::Write;

use crate::geometry::MeshView;

/// Hulls as [`write_hulls`](super::write_hulls) describes.
pub(super) fn obj_from_hulls<'a, H: Into<MeshView<'a>>>(
    hulls: impl IntoIterator<Item = H>,
) -> String {
    let mut text = String::new();
    let mut first_vertex = 1;
    for (index, hull) in hulls.into_iter().enumerate() {
        let hull = hull.into();
        // Writing to a string can't fail.
        let _ = writeln!(text, "o hull_{index}");
        for [x, y, z] in hull.positions() {
            let _ = writeln!(text, "v {x:?} {y:?} {z:?}");
        }
        for triangle in hull.triangles() {
            let [a, b, c] = triangle.map(|vertex| first_vertex + vertex as usize);
            let _ = writeln!(text, "f {a} {b} {c}");
        }
        first_vertex += hull.vertex_count();
    }
    text
}
