//! Wavefront OBJ: vertices, faces, objects and groups.
//!
//! Positive and negative indices, polygons, faces before their vertices, continued lines and any
//! text encoding are read, and names of materials; texture coordinates, normals, colours, weights,
//! points, lines and curves are skipped.

use std::borrow::Cow;
use std::collections::HashMap;

use hullwright::hulls_format::MeshPart;

use super::mesh_file::{MeshFile, Object, name_of_part, next_index};
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
    let mut materials = Vec::new();
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
            Some(keyword @ (b"o" | b"g" | b"usemtl")) => {
                let named = match keyword {
                    b"o" => &mut objects,
                    b"g" => &mut groups,
                    _ => &mut materials,
                };
                named.push((text_after_keyword(&text, keyword), file.mesh.triangles.len()));
            }
            _ => {}
        }
    }
    let parts = if objects.is_empty() { groups } else { objects };
    divide(&mut file, parts);
    add_parts(&mut file, &materials);
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

fn text_after_keyword(text: &[u8], keyword: &[u8]) -> String {
    name(text.trim_ascii_start().get(keyword.len()..).unwrap_or_default())
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

/// Makes a part of each material of an object, if any of the two has a name.
fn add_parts(file: &mut MeshFile, materials: &[(String, usize)]) {
    let MeshFile { objects, parts, .. } = file;
    if materials.is_empty() && objects.iter().all(|object| object.name.is_empty()) {
        return;
    }
    let (mut known, mut counts) = (HashMap::new(), HashMap::new());
    for Object { name, triangles } in objects.iter() {
        let mesh = name_of_part(name);
        let mut start = triangles.start;
        while start < triangles.end {
            let next = materials.partition_point(|(_, first)| *first <= start);
            let (before, after) = materials.split_at(next);
            let material = before.last().map_or("", |(name, _)| name_of_part(name));
            let part = *known.entry((mesh, material)).or_insert_with(|| {
                let count = counts.entry(mesh).or_insert(0);
                *count += 1;
                parts.add(MeshPart::new(mesh, *count - 1, material))
            });
            start = after.first().map_or(triangles.end, |(_, first)| triangles.end.min(*first));
            parts.of_triangles.resize(start, part);
        }
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
    fn a_part_is_a_material_of_an_object_however_often_it_is_taken_up() {
        let parts = |text: &str| {
            let parts = read(format!("{FOUR_VERTICES}{text}").as_bytes()).unwrap().parts;
            let named = |part: MeshPart| (part.mesh, part.primitive, part.material);
            (parts.list.into_iter().map(named).collect::<Vec<_>>(), parts.of_triangles)
        };
        let face = "f 1 2 3\n";
        assert_eq!(parts(face), (vec![], vec![]));
        let steel_twice = format!("usemtl steel \n{face}usemtl oak\n{face}usemtl steel\n{face}");
        let of = |mesh: &str, primitive, material: &str| (mesh.into(), primitive, material.into());
        let two = vec![of("", 0, "steel"), of("", 1, "oak")];
        assert_eq!(parts(&steel_twice), (two, vec![0, 1, 0]));
        let chairs = format!("o a\n{face}{steel_twice}o b\n{face}{face}");
        let four =
            vec![of("a", 0, ""), of("a", 1, "steel"), of("a", 2, "oak"), of("b", 0, "steel")];
        assert_eq!(parts(&chairs), (four, vec![0, 1, 2, 1, 3, 3]));
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
