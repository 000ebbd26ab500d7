//! STL, binary and text, distinguished by more than the first word.
//!
//! A file whose length is exactly what its binary header announces is binary, even if it begins
//! with `solid` as many do. Otherwise it is text if it begins with `solid` or `facet` and soon has
//! a facet or an end, and else binary. No text has a byte of zero, which the triangles of a binary
//! file have.
//!
//! STL has no shared vertices: each triangle brings three of its own.
//!
//! In text, `solid` and `endsolid` may be doubled or missing, and ends may be two words, as some
//! programs write them.

use super::mesh_file::{MeshFile, next_index};
use super::notes::NoteKind;
use super::text::{Triangulator, at_line, coordinates, lines, name, quote, words};

/// A binary file begins with a comment of this length, and the number of triangles as `u32`.
const COMMENT: usize = 80;
const HEADER: usize = COMMENT + 4;
/// A triangle is its normal, its three vertices (each three `f32`), and two bytes.
const TRIANGLE: usize = 50;
const NORMAL: usize = 12;

/// How far into a text the first facet or end may be: there is only a name before it.
const BEGINNING: usize = 4096;

pub(super) fn read(bytes: &[u8]) -> Result<MeshFile, String> {
    let announced = announced_length(bytes);
    let available = bytes.len() as u64;
    let is_whole = announced.is_some_and(|length| length <= available);
    let is_text = looks_like_text(bytes) && !(is_whole && beginning(bytes).contains(&0));
    if announced != Some(available) && is_text {
        return Text::default().read(bytes);
    }
    match announced {
        None => Err(format!(
            "its {} bytes are neither text that begins with `solid` nor a binary header of {HEADER} bytes",
            bytes.len()
        )),
        Some(length) if length > available => Err(format!(
            "it should have {length} bytes for the {} triangles that the header announces, but \
             has only {available}; text would begin with `solid`",
            (length - HEADER as u64) / TRIANGLE as u64
        )),
        Some(length) => {
            let mut file = read_binary(&bytes[HEADER..length as usize])?;
            file.note(NoteKind::TrailingBytes, (available - length) as usize);
            Ok(file)
        }
    }
}

/// The length of a binary file with this header.
fn announced_length(bytes: &[u8]) -> Option<u64> {
    let count = bytes.get(COMMENT..HEADER)?.first_chunk::<4>()?;
    Some(HEADER as u64 + u64::from(u32::from_le_bytes(*count)) * TRIANGLE as u64)
}

fn beginning(bytes: &[u8]) -> &[u8] {
    bytes.get(..BEGINNING).unwrap_or(bytes)
}

fn looks_like_text(bytes: &[u8]) -> bool {
    let beginning = beginning(bytes).trim_ascii_start().to_ascii_lowercase();
    let contains = |word: &[u8]| beginning.windows(word.len()).any(|at| at == word);
    let is_solid = beginning.starts_with(b"solid")
        && (contains(b"facet") || contains(b"endsolid") || contains(b"end solid"));
    is_solid || beginning.starts_with(b"facet") && contains(b"vertex")
}

fn read_binary(records: &[u8]) -> Result<MeshFile, String> {
    let (records, _) = records.as_chunks::<TRIANGLE>();
    let mut file = MeshFile::default();
    file.mesh.positions.reserve_exact(records.len() * 3);
    file.mesh.triangles.reserve_exact(records.len());
    for record in records {
        let first = next_index(&file.mesh.positions, 3)?;
        let (numbers, _) = record[NORMAL..].as_chunks::<4>();
        let (vertices, _) = numbers.as_chunks::<3>();
        let position =
            |vertex: &[[u8; 4]; 3]| vertex.map(|bytes| f64::from(f32::from_le_bytes(bytes)));
        file.mesh.positions.extend(vertices.iter().map(position));
        file.mesh.triangles.push([first, first + 1, first + 2]);
    }
    file.close_object("", 0);
    Ok(file)
}

/// Where in a text the reader is.
#[derive(Clone, Copy, PartialEq)]
enum Place {
    Outside,
    Solid,
    Facet,
}

impl Place {
    /// The lines that would be read here.
    fn expected(self) -> &'static str {
        match self {
            Self::Outside => "`solid` or `facet`",
            Self::Solid => "`facet` or `endsolid`",
            Self::Facet => "`outer loop`, `vertex`, `endloop` or `endfacet`",
        }
    }
}

/// A text while it is read.
struct Text {
    file: MeshFile,
    triangulator: Triangulator,
    place: Place,
    /// The name and first triangle of the solid.
    solid: (String, usize),
    corners: Vec<u32>,
}

impl Default for Text {
    fn default() -> Self {
        Self {
            file: MeshFile::default(),
            triangulator: Triangulator::new(),
            place: Place::Outside,
            solid: Default::default(),
            corners: Vec::new(),
        }
    }
}

impl Text {
    fn read(mut self, bytes: &[u8]) -> Result<MeshFile, String> {
        for (line, text) in lines(bytes) {
            self.read_line(text).map_err(at_line(line))?;
        }
        match self.place {
            Place::Outside => {}
            Place::Solid => {
                self.file.note(NoteKind::UnpairedSolids, 1);
                self.close();
            }
            Place::Facet => {
                return Err(format!(
                    "it ends inside of a facet, after {} triangles",
                    self.file.mesh.triangles.len()
                ));
            }
        }
        Ok(self.file)
    }

    fn read_line(&mut self, text: &[u8]) -> Result<(), String> {
        let mut words = words(text);
        let Some(first) = words.next() else { return Ok(()) };
        let mut keyword = first.to_ascii_lowercase();
        if keyword == b"end" {
            keyword.extend(words.next().unwrap_or_default().to_ascii_lowercase());
            self.file.note(NoteKind::DividedEnds, 1);
        }
        match (keyword.as_slice(), self.place) {
            (b"solid", Place::Outside) => self.open(&text.trim_ascii_start()[first.len()..]),
            (b"solid", Place::Solid) => {
                self.file.note(NoteKind::UnpairedSolids, 1);
                self.close();
                self.open(&text.trim_ascii_start()[first.len()..]);
            }
            (b"facet", Place::Outside) => {
                self.file.note(NoteKind::UnpairedSolids, 1);
                self.open(b"");
                self.place = Place::Facet;
            }
            (b"facet", Place::Solid) => self.place = Place::Facet,
            (b"vertex", Place::Facet) => {
                self.corners.push(next_index(&self.file.mesh.positions, 1)?);
                self.file.mesh.positions.push(coordinates(words)?);
            }
            (b"outer" | b"endloop", Place::Facet) => {}
            (b"endfacet", Place::Facet) => self.close_facet()?,
            (b"endsolid", Place::Solid) => self.close(),
            (b"endsolid", Place::Outside) => self.file.note(NoteKind::UnpairedSolids, 1),
            _ => {
                let expected = self.place.expected();
                return Err(format!("{} stands where {expected} would be read", quote(text)));
            }
        }
        Ok(())
    }

    fn open(&mut self, solid_name: &[u8]) {
        self.solid = (name(solid_name), self.file.mesh.triangles.len());
        self.place = Place::Solid;
    }

    fn close(&mut self) {
        let (name, start) = std::mem::take(&mut self.solid);
        self.file.close_object(name, start);
        self.place = Place::Outside;
    }

    fn close_facet(&mut self) -> Result<(), String> {
        if self.corners.len() < 3 {
            return Err(format!(
                "the facet has only {} vertices, and three would be read",
                self.corners.len()
            ));
        }
        self.triangulator.append(&mut self.file.mesh, &self.corners);
        self.corners.clear();
        self.place = Place::Solid;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::notes::Note;

    const FACET: &str = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0.1 0 0\n\
                         vertex 0 1e-1 0\nendloop\nendfacet\n";

    fn binary(comment: &[u8], announced: u32, triangles: usize) -> Vec<u8> {
        let mut bytes = comment.to_vec();
        bytes.resize(COMMENT, 0);
        bytes.extend(announced.to_le_bytes());
        for _ in 0..triangles {
            bytes.extend([0; NORMAL]);
            for number in [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.5, 0.0] {
                bytes.extend(number.to_le_bytes());
            }
            bytes.extend([0; 2]);
        }
        bytes
    }

    #[test]
    fn a_binary_file_that_begins_with_solid_is_binary() {
        for comment in [&b"exported"[..], b"solid part", b"solid facet endsolid", b""] {
            let file = read(&binary(comment, 2, 2)).unwrap();
            assert_eq!(file.mesh.triangles, [[0, 1, 2], [3, 4, 5]]);
            assert_eq!(file.mesh.positions[5], [0.0, 0.5, 0.0]);
        }
        let mut followed_by_more = binary(b"solid part", 1, 1);
        followed_by_more.extend(b"more");
        let file = read(&followed_by_more).unwrap();
        assert_eq!(file.mesh.triangles.len(), 1);
        assert_eq!(file.notes, [Note { kind: NoteKind::TrailingBytes, count: 4 }]);
    }

    #[test]
    fn a_binary_header_that_reads_as_text_is_binary_with_bytes_after_its_triangles() {
        for header in ["solid facet", "solid a\nfacet normal\nvertex 0 0 0\nendsolid"] {
            let mut bytes = binary(header.as_bytes(), 1, 1);
            bytes.push(0);
            let file = read(&bytes).unwrap();
            assert_eq!(file.mesh.triangles.len(), 1);
            assert_eq!(file.notes, [Note { kind: NoteKind::TrailingBytes, count: 1 }]);
        }
    }

    #[test]
    fn ends_may_be_two_words_and_solids_may_lack_their_lines() {
        let unpaired = |count| Note { kind: NoteKind::UnpairedSolids, count };
        let divided = |count| Note { kind: NoteKind::DividedEnds, count };
        let spaced = FACET.replace("endl", "end l").replace("endf", "end F");
        for (text, notes) in [
            (format!("solid a\n{FACET}{FACET}"), vec![unpaired(1)]),
            (format!("solid a\n{FACET}{FACET}end solid a"), vec![divided(1)]),
            (format!("solid a\n{spaced}{spaced}end SOLID"), vec![divided(5)]),
            (format!("solid\nsolid a\n{FACET}{FACET}endsolid a\nendsolid\n"), vec![unpaired(2)]),
            (format!("{FACET}{FACET}endsolid"), vec![unpaired(1)]),
            (format!("{FACET}{FACET}"), vec![unpaired(2)]),
        ] {
            let file = read(text.as_bytes()).expect(&text);
            assert_eq!(file.mesh.triangles, [[0, 1, 2], [3, 4, 5]], "{text}");
            assert_eq!(file.objects.len(), 1, "{text}");
            assert_eq!(file.notes, notes, "{text}");
        }
        let two = format!("solid a\n{FACET}solid b\n{FACET}endsolid b");
        let names: Vec<String> =
            read(two.as_bytes()).unwrap().objects.into_iter().map(|object| object.name).collect();
        assert_eq!(names, ["a", "b"]);
        assert!(read(b"solid\nend\nfacet").unwrap_err().contains("`end`"));
    }

    #[test]
    fn a_binary_header_that_announces_too_much_is_an_error_at_once() {
        let error = read(&binary(b"", u32::MAX, 2)).unwrap_err();
        assert!(error.contains("4294967295 triangles"), "{error}");
        assert!(read(&binary(b"solid part", 3, 2)).is_err());
        assert!(read(&binary(b"", 1, 1)[..100]).is_err());
    }

    #[test]
    fn text_keeps_all_solids_and_all_digits() {
        for start in ["solid a\n", "solid\ta\n", "\n SOLID a\r\n", "solid a\r"] {
            let text =
                format!("{start}{FACET}endsolid a\nsolid\nendsolid\nsolid b\n{FACET}endsolid");
            let file = read(text.as_bytes()).unwrap();
            assert_eq!(file.mesh.positions[1], [0.1, 0.0, 0.0]);
            let names: Vec<_> = file.objects.iter().map(|object| object.name.as_str()).collect();
            assert_eq!(names, ["a", "b"]);
        }
    }

    #[test]
    fn cut_off_or_disordered_text_is_an_error() {
        let whole = format!("solid a\n{FACET}endsolid a\n");
        assert!(read(whole.as_bytes()).is_ok());
        let cut = whole.find("endsolid").unwrap();
        let error = read(&whole.as_bytes()[..cut - 2]).unwrap_err();
        assert_eq!(
            error,
            "line 8: `endface` stands where `outer loop`, `vertex`, `endloop` or `endfacet` would be read"
        );
        let error = read(&whole.as_bytes()[..whole.find("endloop").unwrap()]).unwrap_err();
        assert_eq!(error, "it ends inside of a facet, after 0 triangles");
        let error = read(whole.replace("endfacet\n", "").as_bytes()).unwrap_err();
        assert!(error.starts_with("line 8: "), "{error}");
        let error = read(whole.replace("vertex 0 0 0\n", "").as_bytes()).unwrap_err();
        assert_eq!(error, "line 7: the facet has only 2 vertices, and three would be read");
        let error = read(whole.replace("0.1", "0,1").as_bytes()).unwrap_err();
        assert!(error.starts_with("line 5: `0,1`"), "{error}");
    }

    #[test]
    fn what_is_no_stl_is_refused() {
        assert!(read(b"").is_err());
        assert!(read(b"solid").is_err());
        assert!(read(b"hello").unwrap_err().contains("5 bytes"));
    }
}
