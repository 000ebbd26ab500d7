//! OFF, the Object File Format of Geomview: text, with or without colours and normals.
//!
//! The first line may lack the keyword, have it in lower case, or run into the counts (`OFF490 518
//! 0`), as in files that are around. Vertices and faces are read line by line, since what follows
//! them on their line is not always announced. Where that fails, numbers may stand on lines as they
//! like, and nothing else may follow them.

use super::mesh_file::{MeshFile, next_index};
use super::text::{
    Triangulator, at_line, coordinates, known_vertex, lines, number, quote, without_comment, words,
};

/// A vertex is at least `0 0 0` and the line's end, a face at least `0` and the line's end.
const SHORTEST_VERTEX: usize = 6;
const SHORTEST_FACE: usize = 2;

pub(super) fn read(bytes: &[u8]) -> Result<MeshFile, String> {
    read_lines(bytes).or_else(|reason| read_words(bytes).map_err(|_| reason))
}

/// Lines with content, without comments.
fn content(bytes: &[u8]) -> impl Iterator<Item = (usize, &[u8])> {
    let lines = lines(bytes).map(|(line, text)| (line, without_comment(text).trim_ascii()));
    lines.filter(|(_, text)| !text.is_empty())
}

fn read_lines(bytes: &[u8]) -> Result<MeshFile, String> {
    let mut lines = content(bytes);
    let (mut line, first) = lines.next().ok_or("it is empty, and `OFF` would be read")?;
    let (_, mut counts) = split_keyword(first).map_err(at_line(line))?;
    if counts.is_empty() {
        (line, counts) = lines.next().ok_or("the counts are missing after the keyword")?;
    }
    let counts = read_counts(&mut words(counts), bytes.len()).map_err(at_line(line))?;
    let [vertices, faces] = counts;

    let mut builder = Builder::new(counts);
    for vertex in 0..vertices {
        let (line, text) =
            lines.next().ok_or_else(|| format!("it ends after {vertex} of {vertices} vertices"))?;
        builder.add_vertex(&mut words(text)).map_err(at_line(line))?;
    }
    for face in 0..faces {
        let (line, text) =
            lines.next().ok_or_else(|| format!("it ends after {face} of {faces} faces"))?;
        builder.add_face(&mut words(text)).map_err(at_line(line))?;
    }
    builder.finish()
}

/// The same, whatever lines the numbers stand on. All of them must be used, without colours of
/// faces, whose number nothing announces.
fn read_words(bytes: &[u8]) -> Result<MeshFile, String> {
    let mut lines = content(bytes).map(|(_, text)| text);
    let (after_coordinates, mut first) = split_keyword(lines.next().unwrap_or_default())?;
    if first.is_empty() {
        first = lines.next().unwrap_or_default();
    }
    // The number of edges may be missing where a line holds nothing but the other two.
    let has_edges = words(first).count() != 2;
    let mut words = words(first).chain(lines.flat_map(words));
    let counts = read_counts(&mut words, bytes.len())?;
    if has_edges {
        words.next();
    }
    let [vertices, faces] = counts;
    let mut builder = Builder::new(counts);
    for _ in 0..vertices {
        builder.add_vertex(&mut words)?;
        words.by_ref().take(after_coordinates).for_each(drop);
    }
    for _ in 0..faces {
        builder.add_face(&mut words)?;
    }
    match words.next() {
        Some(word) => Err(format!("{} follows the last face", quote(word))),
        None => builder.finish(),
    }
}

/// How many numbers the keyword announces after the coordinates of a vertex, and what follows it in
/// the first line. Without a keyword that is the whole line.
fn split_keyword(first: &[u8]) -> Result<(usize, &[u8]), String> {
    if words(first).flatten().all(u8::is_ascii_digit) {
        return Ok((0, first));
    }
    let not_off = || format!("{} stands where `OFF` would be read", quote(first));
    let is_keyword = |word: &[u8]| word.eq_ignore_ascii_case(b"OFF");
    let at = first.windows(3).position(is_keyword).ok_or_else(not_off)?;
    let (prefix, rest) = first.split_at(at);
    let (keyword, rest) = rest.split_at(3);
    let rest = rest.trim_ascii();
    // Upper and lower `n` differ: normals and dimensions. In a keyword of lower case it is normals.
    let is_lower = keyword == b"off";
    let prefix = if is_lower { prefix.to_ascii_uppercase() } else { prefix.to_vec() };
    if prefix.iter().any(|letter| matches!(letter, b'4' | b'n')) {
        return Err("its vertices have four or more dimensions, and three would be read".into());
    }
    if !prefix.iter().all(|letter| b"STCN".contains(letter)) {
        return Err(not_off());
    }
    if rest.to_ascii_uppercase().starts_with(b"BINARY") {
        return Err("it is binary OFF, and text would be read".into());
    }
    let numbers = [(b'S', 2), (b'C', 4), (b'N', 3)];
    let announced = numbers.iter().filter(|(letter, _)| prefix.contains(letter));
    Ok((announced.map(|(_, count)| count).sum(), rest))
}

/// The numbers of vertices and faces; a number of edges may follow.
fn read_counts<'a>(
    words: &mut impl Iterator<Item = &'a [u8]>,
    file_length: usize,
) -> Result<[usize; 2], String> {
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

/// Takes vertices, then faces.
struct Builder {
    file: MeshFile,
    vertices: usize,
    triangulator: Triangulator,
    corners: Vec<u32>,
}

impl Builder {
    fn new([vertices, _]: [usize; 2]) -> Self {
        let mut file = MeshFile::default();
        file.mesh.positions.reserve_exact(vertices);
        Self { file, vertices, triangulator: Triangulator::new(), corners: Vec::new() }
    }

    fn add_vertex<'a>(&mut self, words: &mut impl Iterator<Item = &'a [u8]>) -> Result<(), String> {
        next_index(&self.file.mesh.positions, 1)?;
        self.file.mesh.positions.push(coordinates(words)?);
        Ok(())
    }

    /// A face is its number of corners, and the corners; a colour may follow.
    fn add_face<'a>(&mut self, words: &mut impl Iterator<Item = &'a [u8]>) -> Result<(), String> {
        let count: usize = number(words.next().unwrap_or_default())?;
        self.corners.clear();
        for found in 0..count {
            let word = words.next().ok_or_else(|| {
                format!("the face should have {count} vertices, here are {found}")
            })?;
            self.corners.push(known_vertex(number(word)?, self.vertices)?);
        }
        self.triangulator.append(&mut self.file.mesh, &self.corners);
        Ok(())
    }

    fn finish(mut self) -> Result<MeshFile, String> {
        self.file.close_object("", 0);
        Ok(self.file)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BODY: &str = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

    #[test]
    fn every_form_of_the_header_is_read() {
        for header in [
            "OFF\n3 1 0\n",
            "OFF 3 1 0\n",
            "OFF3 1\n",
            "3 1 0\n",
            "# x\nOFF # y\n\n3 1\n",
            "off\n3 1 0\n",
            "cnoff\n3 1\n",
        ] {
            let file = read(format!("{header}{BODY}").as_bytes()).expect(header);
            assert_eq!(file.mesh.triangles, [[0, 1, 2]], "{header}");
        }
    }

    #[test]
    fn numbers_may_stand_on_lines_as_they_like() {
        for text in [
            "OFF 3 2 0 0 0 0 1 0 0 0 1 0 3 0 1 2 3 2 1 0",
            "OFF\n3\n2\n0\n0 0 0 1 0\n0 0 1 0\n3 0 1 2 3\n2 1 0",
            "off\n3 2\n0 0\n0 1 0 0 0 1 0\n3 0\n1 2\n3 2 1 0 # end\n",
            "NOFF\n3 2 0\n0 0 0 9 9\n9 1 0 0 9 9 9 0 1 0 9 9 9\n3 0 1 2\n3 2 1 0\n",
        ] {
            let file = read(text.as_bytes()).expect(text);
            assert_eq!(file.mesh.positions, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
            assert_eq!(file.mesh.triangles, [[0, 1, 2], [2, 1, 0]], "{text}");
        }
        // What is left over is no colour, so the count of some face is wrong.
        let error = read(b"OFF 3 1 0 0 0 0 1 0 0 0 1 0 3 0 1 2 3 2 1 0").unwrap_err();
        assert_eq!(error, "it ends after 0 of 3 vertices");
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
                "line 6: the face uses vertex 3, but the file's vertices are 0 to 2",
            ),
        ] {
            let error = read(text.as_bytes()).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
        assert!(read(b"\xff\xd8\xff\xe0 JFIF").unwrap_err().contains("where `OFF` would be read"));
    }
}
