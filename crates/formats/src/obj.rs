//! Wavefront OBJ: vertices, faces, objects and groups.
//!
//! Positive and negative indices, polygons, faces before their vertices, continued lines and any
//! text encoding are read; texture coordinates, normals, colours, weights, materials, points,
//! lines and curves are skipped.

use std::borrow::Cow;

use super::mesh_file::{MeshFile, Object, next_index};
use super::text::{
    Triangulator, at_line, coordinates, lines, name, number, without_comment, words,
};

pub(super) fn read(bytes: &[u8]) -> Result<MeshFile, String> {
    let mut file = MeshFile::default();
    file.mesh.positions = read_vertices(bytes)?;
    let mut triangulator = Triangulator::new();
    let mut vertices_so_far = 0;
    let mut corners = Vec::new();
    let mut objects = Vec::new();
    let mut groups = Vec::new();
    for (line, text) in logical_lines(bytes) {
        let mut words = words(&text);
        match words.next() {
            Some(b"v") => vertices_so_far += 1,
            Some(b"f") => {
                corners.clear();
                for word in words {
                    let corner = corner(word, vertices_so_far, file.mesh.positions.len());
                    corners.push(corner.map_err(at_line(line))?);
                }
                triangulator.append(&mut file.mesh, &corners);
            }
            Some(b"o") => objects.push((text_after_keyword(&text), file.mesh.triangles.len())),
            Some(b"g") => groups.push((text_after_keyword(&text), file.mesh.triangles.len())),
            _ => {}
        }
    }
    let parts = if objects.is_empty() { groups } else { objects };
    divide(&mut file, parts);
    Ok(file)
}

fn read_vertices(bytes: &[u8]) -> Result<Vec<[f64; 3]>, String> {
    let mut positions = Vec::new();
    for (line, text) in logical_lines(bytes) {
        let mut words = words(&text);
        if words.next() == Some(b"v") {
            positions.push(coordinates(words).map_err(at_line(line))?);
        }
    }
    if positions.is_empty() {
        // Any text is an OBJ file without vertices.
        return Err("it holds no vertices, and lines such as `v 0 0 0` would be read".into());
    }
    next_index(&positions, 0)?;
    Ok(positions)
}

/// The vertex that a corner like `3`, `-1/2` or `3//7` names, counted from 0.
fn corner(word: &[u8], vertices_so_far: i64, vertices: usize) -> Result<u32, String> {
    let index = word.split(|byte| *byte == b'/').next().unwrap_or_default();
    let index: i64 = number(index)?;
    let from_zero = if index < 0 { vertices_so_far.saturating_add(index) } else { index - 1 };
    match u32::try_from(from_zero) {
        Ok(vertex) if (vertex as usize) < vertices => Ok(vertex),
        _ if index < 0 => {
            Err(format!("the face uses vertex {index}, but only {vertices_so_far} come before it"))
        }
        _ => Err(format!(
            "the face uses vertex {index}, but the file's vertices are 1 to {vertices}"
        )),
    }
}

fn text_after_keyword(text: &[u8]) -> String {
    name(text.trim_ascii_start().get(1..).unwrap_or_default())
}

/// Makes objects of names and the triangles before which they stand.
fn divide(file: &mut MeshFile, parts: Vec<(String, usize)>) {
    let mut start = 0;
    let mut current = String::new();
    let end = (String::new(), file.mesh.triangles.len());
    for (name, next_start) in parts.into_iter().chain([end]) {
        let triangles = start..next_start;
        let name = std::mem::replace(&mut current, name);
        if !triangles.is_empty() {
            file.objects.push(Object { name, triangles });
        }
        start = next_start;
    }
}

/// Lines of vertices and faces may end with a comment, or go on after a backslash. A comment's or a
/// name's backslash is left alone, since it may end a Windows path.
fn logical_lines(bytes: &[u8]) -> impl Iterator<Item = (usize, Cow<'_, [u8]>)> {
    let mut lines = lines(bytes);
    std::iter::from_fn(move || {
        let (number, first) = lines.next()?;
        if !matches!(first.trim_ascii_start().first(), Some(b'v' | b'f')) {
            return Some((number, Cow::Borrowed(first)));
        }
        let first = without_comment(first);
        let Some(begun) = first.trim_ascii_end().strip_suffix(b"\\") else {
            return Some((number, Cow::Borrowed(first)));
        };
        let mut text = begun.to_vec();
        for (_, next) in lines.by_ref() {
            let next = without_comment(next).trim_ascii_end();
            let begun = next.strip_suffix(b"\\");
            text.push(b' ');
            text.extend(begun.unwrap_or(next));
            if begun.is_none() {
                break;
            }
        }
        Some((number, Cow::Owned(text)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const FOUR_VERTICES: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";

    fn read_faces(faces: &str) -> Result<Vec<[u32; 3]>, String> {
        read(format!("{FOUR_VERTICES}{faces}").as_bytes()).map(|file| file.mesh.triangles)
    }

    #[test]
    fn every_way_to_name_a_corner_means_the_position() {
        for face in ["f 1 2 3", "f 1/9 2/9 3/9", "f 1//9 2//9 3//9", "f 1/8/9 2// 3/"] {
            assert_eq!(read_faces(face), Ok(vec![[0, 1, 2]]), "{face}");
        }
        assert_eq!(read_faces("f -4 -3 -2\nv 9 9 9\nf -1 -2 -3"), Ok(vec![[0, 1, 2], [4, 3, 2]]));
        let early = read(format!("f 1 2 3\n{FOUR_VERTICES}").as_bytes()).unwrap();
        assert_eq!(early.mesh.triangles, [[0, 1, 2]], "before its vertices");
    }

    #[test]
    fn indices_that_name_no_vertex_are_errors_with_their_line() {
        let far = "f 1 2 99999999999999999999";
        let least = format!("f 1 2 {}", i64::MIN);
        for (face, index) in [
            ("f 1 2 5", "5"),
            ("f 1 2 0", "0"),
            ("f -5 1 2", "-5"),
            (&least, &least[6..]),
            (far, &far[6..]),
            ("f 1 2 x", "`x`"),
        ] {
            let error = read_faces(face).unwrap_err();
            assert!(error.starts_with("line 5: ") && error.contains(index), "{error}");
        }
    }

    #[test]
    fn points_lines_and_curves_are_no_surface() {
        assert_eq!(read_faces("l 1 2 3\np 1 2 3\nl 1 2 3 4\nf 1 2\nf\n"), Ok(vec![]));
    }

    #[test]
    fn continued_lines_windows_paths_and_other_encodings_are_read() {
        let text = b"# C:\\models\\\nmtllib caf\xe9.mtl\nv 0 0 \\\n0\r\nv 1 0 0 0.5 0.5 0.5\n\
                     v 0 1 0 1.0\nf 1 \\\n 2 \\\n3 \\";
        let file = read(text).unwrap();
        assert_eq!(file.mesh.positions, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        assert_eq!(file.mesh.triangles, [[0, 1, 2]]);
    }

    #[test]
    fn lines_that_go_on_without_end_take_time_in_proportion() {
        let text = [FOUR_VERTICES.as_bytes(), b"f 1 2 3 ", &b"\\\n".repeat(1 << 20)].concat();
        assert_eq!(read(&text).unwrap().mesh.triangles, [[0, 1, 2]]);
    }

    #[test]
    fn a_comment_may_end_a_line_of_a_vertex_or_a_face() {
        let text =
            b"v 0 0 0 # 1\nv 1 0 0#2\nv 0 1 -1.#IND # C:\\meshes\\\nf 3 2 1 # C:\\meshes\\\n\
                     f 1 \\ # a\n2 3 # b\nf 2 1 3#c";
        let file = read(text).unwrap();
        assert!(file.mesh.positions[2][2].is_nan());
        assert_eq!(file.mesh.triangles, [[2, 1, 0], [0, 1, 2], [1, 0, 2]]);
    }

    #[test]
    fn objects_come_before_groups_and_empty_ones_are_left_out() {
        let named = |text: &str| {
            let file = read(format!("{FOUR_VERTICES}{text}").as_bytes()).unwrap();
            let part = |object: super::super::Object| (object.name, object.triangles);
            file.objects.into_iter().map(part).collect::<Vec<_>>()
        };
        let face = "f 1 2 3\n";
        assert_eq!(named(face), [(String::new(), 0..1)]);
        assert_eq!(
            named(&format!("{face}g a b\n{face}{face}g\ng c\n{face}")),
            [(String::new(), 0..1), ("a b".into(), 1..3), ("c".into(), 3..4)]
        );
        assert_eq!(
            named(&format!("o x\ng a\n{face}g b\n{face}o y\no z\n{face}")),
            [("x".into(), 0..2), ("z".into(), 2..3)]
        );
    }

    #[test]
    fn a_short_or_unreadable_vertex_is_an_error_with_its_line() {
        assert_eq!(
            read(b"v 0 0 0\n\nv 1 2\n").unwrap_err(),
            "line 3: a vertex needs three coordinates, here are 2"
        );
        assert!(read(b"v 0 0 1,5").unwrap_err().contains("`1,5`"));
        assert_eq!(
            read(b"\x89PNG\r\n\x1a\n").unwrap_err(),
            "it holds no vertices, and lines such as `v 0 0 0` would be read"
        );
    }
}
