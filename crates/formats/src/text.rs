//! What the readers of text formats share: lines, words, numbers, and polygons into triangles.

use std::str::FromStr;

use earcut::{Earcut, Refiner};
use hullwright::TriangleMesh;

use crate::vector::Vector;

/// Longest piece of a file that an error message repeats, in characters.
const LONGEST_QUOTE: usize = 40;

/// The lines of a text with their numbers from 1. Lines end with LF, CR LF, or CR alone as on
/// old Macs.
pub(super) fn lines(mut rest: &[u8]) -> impl Iterator<Item = (usize, &[u8])> {
    let mut number = 0;
    std::iter::from_fn(move || {
        if rest.is_empty() {
            return None;
        }
        number += 1;
        let is_end = |byte: &u8| matches!(byte, b'\n' | b'\r');
        let (line, others) = rest.split_at(rest.iter().position(is_end).unwrap_or(rest.len()));
        rest = others.strip_prefix(b"\r\n").or_else(|| others.get(1..)).unwrap_or_default();
        Some((number, line))
    })
}

/// The words of a line.
pub(super) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

/// The line without a comment that begins with `#`. That of a number such as `1.#IND` begins none.
pub(super) fn without_comment(line: &[u8]) -> &[u8] {
    let begins = |at: usize| {
        let is_number = at.checked_sub(1).and_then(|before| line.get(before)) == Some(&b'.');
        !is_number || !matches!(line.get(at + 1), Some(b'I' | b'N' | b'Q' | b'S'))
    };
    let marks = line.iter().enumerate().filter(|(_, byte)| **byte == b'#');
    match marks.map(|(at, _)| at).find(|at| begins(*at)) {
        Some(at) => line.get(..at).unwrap_or(line),
        None => line,
    }
}

/// A piece of a file as it may stand in an error message.
pub(super) fn quote(piece: &[u8]) -> String {
    let text = String::from_utf8_lossy(piece);
    let text = text.trim();
    let mut quoted: String = text
        .chars()
        .take(LONGEST_QUOTE)
        .map(|c| if c.is_control() { '\u{fffd}' } else { c })
        .collect();
    if text.chars().nth(LONGEST_QUOTE).is_some() {
        quoted.push('…');
    }
    format!("`{quoted}`")
}

/// The text as a name: trimmed, and readable even where it is not UTF-8.
pub(super) fn name(text: &[u8]) -> String {
    String::from_utf8_lossy(text).trim().to_owned()
}

/// A type of number that files hold as text.
pub(super) trait Number: FromStr {
    /// What a word should be, for a message.
    const EXPECTED: &str;

    /// What a word means that Rust does not read.
    fn of_other_programs(_: &str) -> Option<Self> {
        None
    }
}

impl Number for f64 {
    const EXPECTED: &str = "a number such as -0.5";

    /// C libraries print what is not finite as `-nan(ind)`, `nan(0x8000)`, `1.#IND`, `-1.#QNAN` or
    /// `1.#INF00`.
    fn of_other_programs(word: &str) -> Option<Self> {
        let unsigned = word.trim_start_matches(['+', '-']).to_ascii_lowercase();
        let is_in = |start: &str| unsigned.starts_with(start);
        match () {
            () if is_in("nan(") && unsigned.ends_with(')') => Some(Self::NAN),
            () if is_in("1.#ind") || is_in("1.#qnan") || is_in("1.#snan") => Some(Self::NAN),
            () if is_in("1.#inf") && word.starts_with('-') => Some(Self::NEG_INFINITY),
            () if is_in("1.#inf") => Some(Self::INFINITY),
            () => None,
        }
    }
}

impl Number for i64 {
    const EXPECTED: &str = "a whole number";
}

impl Number for usize {
    const EXPECTED: &str = "a whole number from 0";
}

/// A number; for `f64` also `nan` and `inf`.
pub(super) fn number<T: Number>(word: &[u8]) -> Result<T, String> {
    let text = std::str::from_utf8(word).ok();
    text.and_then(|text| text.parse().ok().or_else(|| T::of_other_programs(text)))
        .ok_or_else(|| format!("{} stands where {} would be read", quote(word), T::EXPECTED))
}

/// Three coordinates; words after them are ignored.
pub(super) fn coordinates<'a>(words: impl Iterator<Item = &'a [u8]>) -> Result<[f64; 3], String> {
    let mut coordinates = [0.0; 3];
    let mut found = 0;
    for (coordinate, word) in coordinates.iter_mut().zip(words) {
        *coordinate = number(word)?;
        found += 1;
    }
    if found < 3 {
        return Err(format!("a vertex needs three coordinates, here are {found}"));
    }
    Ok(coordinates)
}

/// A face's corner, counted from 0, if there are so many vertices.
pub(super) fn known_vertex(corner: i64, vertices: usize) -> Result<u32, String> {
    match (u32::try_from(corner), vertices) {
        (Ok(known), _) if (known as usize) < vertices => Ok(known),
        (_, 0) => Err(format!("the face uses vertex {corner}, but the file has none")),
        _ => Err(format!(
            "the face uses vertex {corner}, but the file's vertices are 0 to {}",
            vertices - 1
        )),
    }
}

/// Puts the line's number before the reason.
pub(super) fn at_line(line: usize) -> impl Fn(String) -> String {
    move |reason| format!("line {line}: {reason}")
}

// Polygons: a triangle stays as it is. A quadrilateral is cut along the diagonal from its first
// vertex, or along the other one where the first does not lie inside. Larger polygons are seen
// along the axis that their normal is closest to and go through ear clipping and Delaunay
// refinement (crate `earcut`), which handles concave ones and makes no slivers at vertices in the
// middle of a straight side. A polygon for which that finds nothing (no area, a coordinate that is
// not finite), or with more than [`LARGEST_CLIPPED`] vertices, becomes a fan.

/// Ear clipping may take the square of the number of vertices on polygons made to that end.
const LARGEST_CLIPPED: usize = 10_000;

/// The other diagonal is tried where a half has less than this share of a quadrilateral's area,
/// which is what rounding makes of three vertices on a straight line.
const LEAST_HALF: f64 = 1e-6;

/// Triangulates polygons, one after the other, with the same scratch memory.
pub(super) struct Triangulator {
    earcut: Earcut<f64>,
    refiner: Refiner,
    flat: Vec<[f64; 2]>,
    found: Vec<u32>,
}

impl Triangulator {
    pub(super) fn new() -> Self {
        Self { earcut: Earcut::new(), refiner: Refiner::new(), flat: Vec::new(), found: Vec::new() }
    }

    /// Appends the triangles of the polygon with these corners, wound as it is. Fewer than three
    /// corners give none. All corners must be below the number of positions.
    pub(super) fn append(&mut self, mesh: &mut TriangleMesh, corners: &[u32]) {
        let TriangleMesh { positions, triangles, .. } = mesh;
        let positions: &[Vector] = bytemuck::cast_slice(positions);
        match *corners {
            [a, b, c] => triangles.push([a, b, c]),
            [a, b, c, d] => triangles.extend(cut_quadrilateral(positions, [a, b, c, d])),
            _ if self.clip_ears(positions, corners) => {
                let (found, _) = self.found.as_chunks::<3>();
                triangles.extend(found.iter().map(|found| found.map(|i| corners[i as usize])));
            }
            [first, ref others @ ..] => {
                triangles.extend(others.windows(2).map(|pair| [first, pair[0], pair[1]]));
            }
            [] => {}
        }
    }

    /// Whether it found triangles, which then stand in `found`.
    fn clip_ears(&mut self, positions: &[Vector], corners: &[u32]) -> bool {
        if corners.len() < 3 || corners.len() > LARGEST_CLIPPED {
            return false;
        }
        let origin = positions[corners[0] as usize];
        let local = |corner: u32| positions[corner as usize] - origin;
        let normal = normal(corners.iter().map(|corner| local(*corner)));
        if !normal.is_finite() {
            return false;
        }
        let size = normal.map(f64::abs);
        let axes = if size[0] > size[1] && size[0] > size[2] {
            [1, 2]
        } else if size[1] > size[2] {
            [2, 0]
        } else {
            [0, 1]
        };
        self.flat.clear();
        self.flat.extend(corners.iter().map(|corner| axes.map(|axis| local(*corner)[axis])));
        self.earcut.earcut_slice(&self.flat, &[], &mut self.found);
        self.refiner.refine(&mut self.found, &self.flat);
        self.wind_as(normal[3 - axes[0] - axes[1]] > 0.0);
        !self.found.is_empty()
    }

    /// Ear clipping winds its triangles its own way: turns them counter-clockwise or clockwise.
    fn wind_as(&mut self, counter_clockwise: bool) {
        let (found, _) = self.found.as_chunks_mut::<3>();
        let area: f64 = found
            .iter()
            .map(|triangle| {
                let [a, b, c] = triangle.map(|corner| self.flat[corner as usize]);
                (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
            })
            .sum();
        if (area > 0.0) != counter_clockwise {
            found.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
    }
}

/// Twice the vector area of a closed polygon (Newell), which only needs to begin near the origin
/// to be precise.
fn normal(points: impl Iterator<Item = Vector> + Clone) -> Vector {
    let following = points.clone().skip(1);
    points.zip(following).fold(Vector::ZERO, |sum, (a, b)| sum + a.cross(b))
}

fn cut_quadrilateral(positions: &[Vector], corners: [u32; 4]) -> [[u32; 3]; 2] {
    let [a, b, c, d] = corners;
    let area = |corners: [u32; 3]| {
        let [a, b, c] = corners.map(|corner| positions[corner as usize]);
        (b - a).cross(c - a)
    };
    let by_first = [[a, b, c], [a, c, d]];
    let by_second = [[a, b, d], [b, c, d]];
    let whole = area(by_first[0]) + area(by_first[1]);
    // Negative where a part of the cut lies outside.
    let smaller_half = |cut: [[u32; 3]; 2]| {
        let [first, second] = cut.map(|half| area(half).dot(whole));
        first.min(second)
    };
    let sliver = LEAST_HALF * whole.dot(whole);
    if smaller_half(by_first) < sliver && smaller_half(by_second) > smaller_half(by_first) {
        by_second
    } else {
        by_first
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_line_endings_count_once() {
        let found: Vec<_> = lines(b"a\nb\r\nc\rd\n\ne").collect();
        let expected: Vec<(usize, &[u8])> =
            vec![(1, b"a"), (2, b"b"), (3, b"c"), (4, b"d"), (5, b""), (6, b"e")];
        assert_eq!(found, expected);
    }

    #[test]
    fn numbers_keep_all_digits_of_a_double() {
        assert_eq!(number::<f64>(b"0.1234567890123456789"), Ok(0.12345678901234568));
        assert!(number::<f64>(b"-nan").is_ok_and(f64::is_nan));
    }

    #[test]
    fn what_c_libraries_print_of_numbers_that_are_not_finite_is_read() {
        for word in ["-nan(ind)", "nan(0x8000)", "-1.#IND", "1.#IND00", "1.#QNAN", "-1.#SNAN"] {
            assert!(number::<f64>(word.as_bytes()).is_ok_and(f64::is_nan), "{word}");
        }
        assert_eq!(number(b"1.#INF"), Ok(f64::INFINITY));
        assert_eq!(number(b"-1.#INF00"), Ok(f64::NEG_INFINITY));
        for word in ["1.#", "nan(", "1,5", "0x10", "", "1.#ABC"] {
            assert!(number::<f64>(word.as_bytes()).is_err(), "{word}");
        }
        assert!(number::<i64>(b"1.#IND").is_err());
    }

    #[test]
    fn a_comment_ends_a_line_but_not_within_a_number() {
        for (line, kept) in [
            ("3 0 1 2 # red", "3 0 1 2 "),
            ("3 0 1 2#red", "3 0 1 2"),
            ("# all", ""),
            ("1. #x", "1. "),
            ("1.#comment", "1."),
            ("0 -1.#IND 1.#QNAN # y", "0 -1.#IND 1.#QNAN "),
            ("0 1", "0 1"),
        ] {
            assert_eq!(without_comment(line.as_bytes()), kept.as_bytes());
        }
    }

    #[test]
    fn a_long_or_binary_word_is_quoted_in_short() {
        let error = number::<f64>(&[0xff; 1000]).unwrap_err();
        assert!(error.chars().count() < 100, "{error}");
        assert!(!quote(b"a\nb\0c").contains(['\n', '\0']));
    }

    fn triangulate(positions: &[Vector]) -> Vec<[u32; 3]> {
        let corners: Vec<u32> = (0..positions.len() as u32).collect();
        let mut mesh =
            TriangleMesh::new(positions.iter().map(|point| point.to_array()).collect(), Vec::new());
        Triangulator::new().append(&mut mesh, &corners);
        mesh.triangles
    }

    fn areas(positions: &[Vector]) -> Vec<Vector> {
        let corners = |t: &[u32; 3]| t.map(|corner| positions[corner as usize]);
        let triangles = triangulate(positions);
        triangles.iter().map(corners).map(|[a, b, c]| (b - a).cross(c - a)).collect()
    }

    /// The same outline in a plane along no axis.
    fn tilted(outline: &[[f64; 2]]) -> Vec<Vector> {
        let place =
            |[x, y]: &[f64; 2]| Vector::new(x + 0.3 * y, y - 0.2 * x, 0.7 * x - 0.4 * y + 1000.0);
        outline.iter().map(place).collect()
    }

    /// Corners by their two coordinates, each a digit.
    fn outline<const N: usize>(corners: [&str; N]) -> [[f64; 2]; N] {
        corners.map(|corner| [0, 1].map(|axis| f64::from(corner.as_bytes()[axis] - b'0')))
    }

    fn assert_tiles(outline: &[[f64; 2]], expected_triangles: usize) {
        for mirrored in [false, true] {
            let mut points = tilted(outline);
            if mirrored {
                points.reverse();
            }
            let areas = areas(&points);
            assert_eq!(areas.len(), expected_triangles);
            let whole = normal(points.iter().map(|point| *point - points[0]));
            let total: f64 = areas.iter().map(|area| area.length()).sum();
            assert!((total - whole.length()).abs() < 1e-9 * total, "pieces overlap");
            for area in &areas {
                assert!(area.dot(whole) > 1e-6, "turned around or without area");
            }
        }
    }

    #[test]
    fn a_concave_polygon_is_tiled_without_overlap_and_keeps_its_winding() {
        let letter_e = ["00", "60", "62", "22", "24", "44", "46", "26", "28", "68", "69", "09"];
        assert_tiles(&outline(letter_e), 10);
    }

    #[test]
    fn vertices_on_straight_sides_are_all_used_and_make_no_slivers() {
        assert_tiles(&outline(["00", "10", "20", "21", "22", "12", "02", "01"]), 6);
        assert_tiles(&outline(["00", "10", "20", "22"]), 2);
        assert_tiles(&outline(["10", "20", "22", "00"]), 2);
    }

    #[test]
    fn a_concave_quadrilateral_is_cut_inside() {
        let dart = outline(["00", "40", "11", "04"]);
        for shift in 0..4 {
            let mut turned = dart;
            turned.rotate_left(shift);
            assert_tiles(&turned, 2);
        }
    }

    #[test]
    fn what_has_no_inside_becomes_a_fan() {
        let line: Vec<Vector> = (0..6).map(|i| Vector::new(f64::from(i), 0.0, 0.0)).collect();
        assert_eq!(triangulate(&line).len(), 4);
        assert_eq!(triangulate(&[Vector::NAN; 5]).len(), 3);
        assert_eq!(triangulate(&[Vector::new(1e300, -1e300, 1e300); 7]).len(), 5);
        assert!(triangulate(&line[..2]).is_empty());
        assert!(triangulate(&[]).is_empty());
    }
}
