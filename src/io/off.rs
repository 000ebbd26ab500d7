//! OFF, the Object File Format of Geomview: text, with or without colours and normals.
//!
//! The first line may lack the keyword, or run into the counts (`OFF490 518 0`), as in files that
//! are around.

use super::mesh_file::{MeshFile, next_index};
use super::text::{
    Triangulator, at_line, coordinates, known_vertex, lines, number, quote, without_comment, words,
};

/// A vertex is at least `0 0 0` and the line's end, a face at least `0` and the line's end.
const SHORTEST_VERTEX: usize = 6;
const SHORTEST_FACE: usize = 2;

pub(super) fn read(bytes: &[u8]) -> Result<MeshFile, String> {
    let mut lines = lines(bytes)
        .map(|(line, text)| (line, without_comment(text).trim_ascii()))
        .filter(|(_, text)| !text.is_empty());

    let (mut line, first) = lines.next().ok_or("it is empty")?;
    let mut counts = after_keyword(first).map_err(at_line(line))?;
    if counts.is_empty() {
        (line, counts) = lines.next().ok_or("the counts are missing")?;
    }
    let [vertices, faces] = read_counts(counts, bytes.len()).map_err(at_line(line))?;

    let mut file = MeshFile::default();
    file.mesh.positions.reserve_exact(vertices);
    for vertex in 0..vertices {
        let (line, text) =
            lines.next().ok_or_else(|| format!("it ends after {vertex} of {vertices} vertices"))?;
        let position = coordinates(words(text)).map_err(at_line(line))?;
        file.mesh.positions.push(position);
    }
    next_index(&file.mesh.positions, 0)?;

    let mut triangulator = Triangulator::new();
    let mut corners = Vec::new();
    for face in 0..faces {
        let (line, text) =
            lines.next().ok_or_else(|| format!("it ends after {face} of {faces} faces"))?;
        read_face(text, vertices, &mut corners).map_err(at_line(line))?;
        triangulator.append(&mut file.mesh, &corners);
    }
    file.close_object("", 0);
    Ok(file)
}

/// What follows the keyword in the first line. Without a keyword that is the whole line.
fn after_keyword(first: &[u8]) -> Result<&[u8], String> {
    if words(first).flatten().all(u8::is_ascii_digit) {
        return Ok(first);
    }
    let not_off = || format!("{} stands where OFF should", quote(first));
    let at = first.windows(3).position(|word| word == b"OFF").ok_or_else(not_off)?;
    let (prefix, rest) = first.split_at(at);
    let rest = rest[3..].trim_ascii();
    if prefix.iter().any(|letter| matches!(letter, b'4' | b'n')) {
        return Err("vertices of four or more dimensions can't be read".into());
    }
    if !prefix.iter().all(|letter| b"STCN".contains(letter)) {
        return Err(not_off());
    }
    if rest.starts_with(b"BINARY") {
        return Err("binary OFF can't be read, only text".into());
    }
    Ok(rest)
}

/// The numbers of vertices and faces; a number of edges may follow.
fn read_counts(text: &[u8], file_length: usize) -> Result<[usize; 2], String> {
    let mut words = words(text);
    let mut count = |what| -> Result<usize, String> {
        number(words.next().ok_or_else(|| format!("the number of {what} is missing"))?)
    };
    let counts = [count("vertices")?, count("faces")?];
    let [vertices, faces] = counts;
    let least = vertices
        .saturating_mul(SHORTEST_VERTEX)
        .saturating_add(faces.saturating_mul(SHORTEST_FACE));
    if least > file_length {
        return Err(format!(
            "{vertices} vertices and {faces} faces are announced, but the file has only \
             {file_length} bytes"
        ));
    }
    Ok(counts)
}

/// A face is its number of corners, the corners, and perhaps a colour.
fn read_face(text: &[u8], vertices: usize, corners: &mut Vec<u32>) -> Result<(), String> {
    let mut words = words(text);
    let count: usize = number(words.next().unwrap_or_default())?;
    corners.clear();
    for found in 0..count {
        let word = words
            .next()
            .ok_or_else(|| format!("the face should have {count} vertices, here are {found}"))?;
        corners.push(known_vertex(number(word)?, vertices)?);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const BODY: &str = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

    #[test]
    fn every_form_of_the_header_is_read() {
        for header in
            ["OFF\n3 1 0\n", "OFF 3 1 0\n", "OFF3 1\n", "3 1 0\n", "# x\nOFF # y\n\n3 1\n"]
        {
            let file = read(format!("{header}{BODY}").as_bytes()).expect(header);
            assert_eq!(file.mesh.triangles, [[0, 1, 2]], "{header}");
        }
    }

    #[test]
    fn normals_and_colours_are_skipped() {
        let text = b"CNOFF\n3 2 0\n0 0 0 0 0 1 255 0 0 255\n1 0 0 0 0 1 1 1 1 1 # red\n\
                     0 1 0 0 0 1 0 0 0 0\n3 0 1 2 0.5 0.5 0.5\n2 0 1 7\n";
        let file = read(text).unwrap();
        assert_eq!(file.mesh.positions[1], [1.0, 0.0, 0.0]);
        assert_eq!(file.mesh.triangles, [[0, 1, 2]]);
    }

    #[test]
    fn lying_counts_and_what_is_no_text_off_are_errors_before_memory_is_taken() {
        let most = usize::MAX;
        for (text, expected) in [
            (String::new(), "it is empty"),
            ("OFF\n".into(), "the counts are missing"),
            ("OFF BINARY\n\x01\0\0\0".into(), "binary OFF"),
            ("4OFF\n1 0 0\n".into(), "dimensions"),
            ("OFF\n3\n".into(), "the number of faces is missing"),
            ("OFF\n3 -1 0\n".into(), "`-1`"),
            (format!("OFF\n4000000000 1 0\n{BODY}"), "line 2: 4000000000 vertices"),
            (format!("OFF\n3 {most} 0\n{BODY}"), "faces are announced"),
            (format!("OFF\n3 2 0\n{BODY}"), "it ends after 1 of 2 faces"),
            ("OFF\n3 1 0\n0 0 0\n1 0 0\n4294967295 0 1 2\n".into(), "it ends after 0 of 1 faces"),
            (
                format!("OFF\n3 1 0\n{}", BODY.replace("3 0", "9 0")),
                "line 6: the face should have 9 vertices, here are 3",
            ),
            (
                format!("OFF\n3 1 0\n{}", BODY.replace("1 2\n", "1 3\n")),
                "line 6: the face uses vertex 3",
            ),
        ] {
            let error = read(text.as_bytes()).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
        assert!(read(b"\xff\xd8\xff\xe0 JFIF").unwrap_err().contains("where OFF should"));
    }
}
