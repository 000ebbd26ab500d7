//! STL, binary and text, distinguished by more than the first word.
//!
//! A file whose length is exactly what its binary header announces is binary, even if it begins
//! with `solid` as many do. Otherwise it is text if it begins with `solid` and soon has a facet
//! or an end, and else binary.
//!
//! STL has no shared vertices: each triangle brings three of its own.

use super::mesh_file::{MeshFile, next_index};
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
    if announced != Some(bytes.len() as u64) && looks_like_text(bytes) {
        return read_text(bytes);
    }
    match announced {
        None => Err(format!(
            "its {} bytes are neither text with the word `solid` nor a binary header",
            bytes.len()
        )),
        Some(length) if length > bytes.len() as u64 => Err(format!(
            "it should have {length} bytes for the {} triangles that the header announces, but \
             has only {}",
            (length - HEADER as u64) / TRIANGLE as u64,
            bytes.len()
        )),
        Some(length) => read_binary(&bytes[HEADER..length as usize]),
    }
}

/// The length of a binary file with this header.
fn announced_length(bytes: &[u8]) -> Option<u64> {
    let count = bytes.get(COMMENT..HEADER)?.first_chunk::<4>()?;
    Some(HEADER as u64 + u64::from(u32::from_le_bytes(*count)) * TRIANGLE as u64)
}

fn looks_like_text(bytes: &[u8]) -> bool {
    let beginning = bytes.get(..BEGINNING).unwrap_or(bytes);
    let beginning = beginning.trim_ascii_start().to_ascii_lowercase();
    let contains = |word: &[u8]| beginning.windows(word.len()).any(|at| at == word);
    beginning.starts_with(b"solid") && (contains(b"facet") || contains(b"endsolid"))
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

fn read_text(bytes: &[u8]) -> Result<MeshFile, String> {
    let mut file = MeshFile::default();
    let mut triangulator = Triangulator::new();
    let mut corners: Vec<u32> = Vec::new();
    // The name and first triangle of the solid that is being read.
    let mut solid: Option<(String, usize)> = None;
    let mut is_in_facet = false;
    for (line, text) in lines(bytes) {
        let mut words = words(text);
        let Some(keyword) = words.next() else {
            continue;
        };
        let misplaced = || Err(at_line(line)(format!("{} can't stand here", quote(text))));
        match keyword.to_ascii_lowercase().as_slice() {
            b"solid" if solid.is_none() => {
                let solid_name = &text.trim_ascii_start()[keyword.len()..];
                solid = Some((name(solid_name), file.mesh.triangles.len()));
            }
            b"facet" if solid.is_some() && !is_in_facet => {
                is_in_facet = true;
                corners.clear();
            }
            b"vertex" if is_in_facet => {
                corners.push(next_index(&file.mesh.positions, 1)?);
                file.mesh.positions.push(coordinates(words).map_err(at_line(line))?);
            }
            b"outer" | b"endloop" if is_in_facet => {}
            b"endfacet" if is_in_facet => {
                if corners.len() < 3 {
                    let reason = format!("the facet has only {} vertices", corners.len());
                    return Err(at_line(line)(reason));
                }
                triangulator.append(&mut file.mesh, &corners);
                is_in_facet = false;
            }
            b"endsolid" if !is_in_facet => match solid.take() {
                Some((name, start)) => file.close_object(name, start),
                None => return misplaced(),
            },
            _ => return misplaced(),
        }
    }
    match solid {
        Some((name, _)) => Err(format!(
            "it ends inside of solid {}, after {} triangles",
            quote(name.as_bytes()),
            file.mesh.triangles.len()
        )),
        None => Ok(file),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        assert_eq!(read(&followed_by_more).unwrap().mesh.triangles.len(), 1);
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
        let error = read(&whole.as_bytes()[..cut]).unwrap_err();
        assert_eq!(error, "it ends inside of solid `a`, after 1 triangles");
        let error = read(whole.replace("endfacet\n", "").as_bytes()).unwrap_err();
        assert!(error.starts_with("line 8: "), "{error}");
        let error = read(whole.replace("vertex 0 0 0\n", "").as_bytes()).unwrap_err();
        assert_eq!(error, "line 7: the facet has only 2 vertices");
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
