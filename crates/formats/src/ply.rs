//! PLY: text and binary of both byte orders.
//!
//! Read are the element `vertex` with the properties `x`, `y`, `z` of any type, and the elements
//! `face` and `tristrips` with the list `vertex_indices` or `vertex_index`. A file without them is
//! a point cloud. Where a property is there twice the first one counts that is of a kind that makes
//! sense.
//!
//! Counts are compared with the file's size before anything is read: an element without properties
//! takes no bytes, so that a count could cause any amount of work.

use super::mesh_file::{MeshFile, next_index};
use super::notes::NoteKind;
use super::ply_header::{Element, Encoding, Header, Kind, Property, Scalar};
use super::text::{Triangulator, at_line, known_vertex, lines, number, quote, words};

const AXES: [&str; 3] = ["x", "y", "z"];
const CORNER_LISTS: [&str; 2] = ["vertex_indices", "vertex_index"];

/// Ends a strip within a list of strips.
const END_OF_STRIP: i64 = -1;

pub(super) fn read(bytes: &[u8]) -> Result<MeshFile, String> {
    let (header, payload) = Header::split(bytes)?;
    check_header(&header, payload.len())?;
    let mut builder = MeshBuilder::new(&header);
    match header.encoding {
        Encoding::Text => read_text(payload, &header, &mut builder)?,
        Encoding::BigEndian => read_binary(payload, true, &header, &mut builder)?,
        Encoding::LittleEndian => read_binary(payload, false, &header, &mut builder)?,
    }
    let mut file = builder.finish()?;
    file.note(NoteKind::RepeatedProperties, header.repeated_properties());
    Ok(file)
}

/// Refuses what can't be a mesh, and counts that the rest of the file is too short for.
fn check_header(header: &Header, payload_length: usize) -> Result<(), String> {
    let mut least_length: usize = 0;
    for element in &header.elements {
        let length_each = match header.encoding {
            // A character and the line's end, or a space, for each property.
            Encoding::Text => element.properties.len().saturating_mul(2),
            _ => element.properties.iter().map(|property| least_size(property.kind)).sum(),
        };
        let quoted = quote(element.name.as_bytes());
        if length_each == 0 && element.count > 0 {
            return Err(format!("the element {quoted} has no properties"));
        }
        least_length = least_length.saturating_add(element.count.saturating_mul(length_each));
        // The last line of a text may lack its end.
        if least_length > payload_length.saturating_add(1) {
            return Err(format!(
                "the header announces {} of the element {quoted}, but only {payload_length} bytes follow it",
                element.count
            ));
        }
    }
    for known in ["vertex", "face", "tristrips"] {
        if header.elements.iter().filter(|element| element.name == known).count() > 1 {
            return Err(format!(
                "the header has the element `{known}` twice, and one would be read"
            ));
        }
    }
    let vertex = header.element("vertex").ok_or("the header has no element `vertex`")?;
    for axis in AXES {
        if !vertex.properties.iter().any(|property| is_number(property, axis)) {
            return Err(format!("the element `vertex` has no number `{axis}`"));
        }
    }
    for name in ["face", "tristrips"] {
        let unreadable = |element: &&Element| {
            element.count > 0 && !element.properties.iter().any(is_corner_list)
        };
        if header.element(name).filter(unreadable).is_some() {
            return Err(format!(
                "the element `{name}` has no list `vertex_indices` or `vertex_index`"
            ));
        }
    }
    Ok(())
}

fn is_number(property: &Property, axis: &str) -> bool {
    property.name == axis && matches!(property.kind, Kind::Number(_))
}

fn is_corner_list(property: &Property) -> bool {
    CORNER_LISTS.contains(&property.name.as_str()) && matches!(property.kind, Kind::List { .. })
}

/// The fewest bytes that a property takes in a binary file; of a list that is its length.
fn least_size(kind: Kind) -> usize {
    let (Kind::Number(scalar) | Kind::List { length: scalar, .. }) = kind;
    scalar.size()
}

/// What a property is to the mesh.
#[derive(Clone, Copy)]
enum Role {
    Axis(usize),
    Corners,
    Nothing,
}

/// The role of each property of an element.
fn roles(element: &Element) -> Vec<Role> {
    let mut roles = vec![Role::Nothing; element.properties.len()];
    let mut give = |role: Role, fits: &dyn Fn(&Property) -> bool| {
        let first = element.properties.iter().position(fits);
        if let Some(slot) = first.and_then(|first| roles.get_mut(first)) {
            *slot = role;
        }
    };
    match element.name.as_str() {
        "vertex" => {
            for (axis, name) in AXES.into_iter().enumerate() {
                give(Role::Axis(axis), &|property| is_number(property, name));
            }
        }
        "face" | "tristrips" => give(Role::Corners, &is_corner_list),
        _ => {}
    }
    roles
}

/// The part of an element that makes the mesh: a vertex's position, or the corners of a face or of
/// strips.
#[derive(Default)]
struct Values {
    position: [f64; 3],
    corners: Vec<i64>,
}

fn read_binary(
    payload: &[u8],
    is_big: bool,
    header: &Header,
    builder: &mut MeshBuilder,
) -> Result<(), String> {
    let mut numbers = Numbers { rest: payload, is_big };
    let mut values = Values::default();
    for element in &header.elements {
        let roles = roles(element);
        for index in 0..element.count {
            numbers
                .read_element(element, &roles, &mut values)
                .and_then(|()| builder.add(&element.name, &values))
                .map_err(|reason| {
                    format!("element {} {index}: {reason}", quote(element.name.as_bytes()))
                })?;
        }
    }
    Ok(())
}

/// The numbers of a binary file.
struct Numbers<'a> {
    rest: &'a [u8],
    is_big: bool,
}

impl Numbers<'_> {
    fn read_element(
        &mut self,
        element: &Element,
        roles: &[Role],
        values: &mut Values,
    ) -> Result<(), String> {
        for (property, role) in element.properties.iter().zip(roles) {
            let is_read = match (property.kind, *role) {
                (Kind::Number(scalar), Role::Axis(axis)) => {
                    self.next(scalar).map(|number| values.position[axis] = number)
                }
                (Kind::Number(scalar), _) => self.skip(1, scalar),
                (Kind::List { length, of }, role) => {
                    let length = match self.next(length) {
                        Some(length) => whole(length)?,
                        None => return Err(ends_within(property)),
                    };
                    let length = usize::try_from(length)
                        .map_err(|_| format!("{length} is no length of a list"))?;
                    match role {
                        Role::Corners => self.read_corners(length, of, &mut values.corners)?,
                        _ => self.skip(length, of),
                    }
                }
            };
            is_read.ok_or_else(|| ends_within(property))?;
        }
        Ok(())
    }

    /// `None` if the file ends first.
    fn read_corners(
        &mut self,
        length: usize,
        of: Scalar,
        corners: &mut Vec<i64>,
    ) -> Result<Option<()>, String> {
        corners.clear();
        if length.checked_mul(of.size()).is_none_or(|bytes| bytes > self.rest.len()) {
            return Ok(None);
        }
        for _ in 0..length {
            let Some(number) = self.next(of) else { return Ok(None) };
            corners.push(whole(number)?);
        }
        Ok(Some(()))
    }

    fn skip(&mut self, count: usize, of: Scalar) -> Option<()> {
        self.rest = self.rest.get(count.checked_mul(of.size())?..)?;
        Some(())
    }

    fn next(&mut self, scalar: Scalar) -> Option<f64> {
        match scalar {
            Scalar::I8 => self.bytes().map(i8::from_le_bytes).map(f64::from),
            Scalar::U8 => self.bytes().map(u8::from_le_bytes).map(f64::from),
            Scalar::I16 => self.bytes().map(i16::from_le_bytes).map(f64::from),
            Scalar::U16 => self.bytes().map(u16::from_le_bytes).map(f64::from),
            Scalar::I32 => self.bytes().map(i32::from_le_bytes).map(f64::from),
            Scalar::U32 => self.bytes().map(u32::from_le_bytes).map(f64::from),
            Scalar::F32 => self.bytes().map(f32::from_le_bytes).map(f64::from),
            Scalar::F64 => self.bytes().map(f64::from_le_bytes),
        }
    }

    /// The bytes of a number, in little-endian order.
    fn bytes<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (bytes, rest) = self.rest.split_first_chunk::<N>()?;
        self.rest = rest;
        let mut bytes = *bytes;
        if self.is_big {
            bytes.reverse();
        }
        Some(bytes)
    }
}

fn ends_within(property: &Property) -> String {
    format!("the file ends within its {}", quote(property.name.as_bytes()))
}

/// A number as an integer: doubles hold all of these.
fn whole(number: f64) -> Result<i64, String> {
    const MOST: f64 = (1_u64 << 53) as f64;
    if number.fract() == 0.0 && number.abs() <= MOST {
        Ok(number as i64)
    } else {
        Err(format!("{number} stands where a whole number would be read"))
    }
}

fn read_text(payload: &[u8], header: &Header, builder: &mut MeshBuilder) -> Result<(), String> {
    let mut lines = lines(payload).filter(|(_, text)| !text.trim_ascii().is_empty());
    let mut values = Values::default();
    for element in &header.elements {
        let roles = roles(element);
        for index in 0..element.count {
            let (line, text) = lines.next().ok_or_else(|| {
                let quoted = quote(element.name.as_bytes());
                format!("it ends after {index} of {} of the element {quoted}", element.count)
            })?;
            read_text_element(text, element, &roles, &mut values)
                .and_then(|()| builder.add(&element.name, &values))
                .map_err(at_line(header.lines + line))?;
        }
    }
    Ok(())
}

fn read_text_element(
    text: &[u8],
    element: &Element,
    roles: &[Role],
    values: &mut Values,
) -> Result<(), String> {
    let mut words = words(text);
    for (property, role) in element.properties.iter().zip(roles) {
        let mut next = || {
            let missing = || format!("{} is missing", quote(property.name.as_bytes()));
            words.next().ok_or_else(missing)
        };
        match (property.kind, *role) {
            (Kind::Number(_), Role::Axis(axis)) => values.position[axis] = number(next()?)?,
            (Kind::Number(_), _) => drop(next()?),
            (Kind::List { .. }, role) => {
                let length: usize = number(next()?)?;
                let is_read = matches!(role, Role::Corners);
                if is_read {
                    values.corners.clear();
                }
                for _ in 0..length {
                    let word = next()?;
                    if is_read {
                        values.corners.push(number(word)?);
                    }
                }
            }
        }
    }
    Ok(())
}

/// Takes elements in the order of the file.
struct MeshBuilder {
    file: MeshFile,
    triangulator: Triangulator,
    /// Faces that stand in the file before its vertices.
    early_faces: Vec<Vec<u32>>,
    vertices: usize,
}

impl MeshBuilder {
    fn new(header: &Header) -> Self {
        Self {
            file: MeshFile::default(),
            triangulator: Triangulator::new(),
            early_faces: Vec::new(),
            vertices: header.element("vertex").map_or(0, |vertex| vertex.count),
        }
    }

    fn add(&mut self, name: &str, values: &Values) -> Result<(), String> {
        match name {
            "vertex" => self.file.mesh.positions.push(values.position),
            "face" => self.add_face(&values.corners)?,
            "tristrips" => {
                for strip in values.corners.split(|corner| *corner == END_OF_STRIP) {
                    for (number, corners) in strip.windows(3).enumerate() {
                        // Every other triangle of a strip is wound the other way.
                        let (second, third) = if number % 2 == 0 { (1, 2) } else { (2, 1) };
                        self.add_face(&[corners[0], corners[second], corners[third]])?;
                    }
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn add_face(&mut self, corners: &[i64]) -> Result<(), String> {
        let known = corners.iter().map(|corner| known_vertex(*corner, self.vertices));
        let corners: Vec<u32> = known.collect::<Result<_, _>>()?;
        if self.file.mesh.positions.len() == self.vertices {
            self.triangulator.append(&mut self.file.mesh, &corners);
        } else {
            self.early_faces.push(corners);
        }
        Ok(())
    }

    fn finish(mut self) -> Result<MeshFile, String> {
        next_index(&self.file.mesh.positions, 0)?;
        for corners in &self.early_faces {
            self.triangulator.append(&mut self.file.mesh, corners);
        }
        self.file.close_object("", 0);
        Ok(self.file)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::notes::Note;

    fn header(format: &str, vertices: usize, faces: usize) -> String {
        format!(
            "ply\nformat {format} 1.0\ncomment made by hand\nelement vertex {vertices}\n\
             property float x\nproperty uchar red\nproperty double y\nproperty short z\n\
             element face {faces}\nproperty uchar flags\n\
             property list uchar int vertex_indices\nend_header\n"
        )
    }

    fn binary(is_big_endian: bool, vertices: usize, corners: &[i32]) -> Vec<u8> {
        let format = ["binary_little_endian", "binary_big_endian"][usize::from(is_big_endian)];
        let mut bytes = header(format, vertices, 1).into_bytes();
        let mut push = |little: &[u8]| {
            let mut number = little.to_vec();
            if is_big_endian {
                number.reverse();
            }
            bytes.extend(number);
        };
        for [x, y, z] in [[0.0_f32, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, -3.0]] {
            push(&x.to_le_bytes());
            push(&[255]);
            push(&f64::from(y).to_le_bytes());
            push(&(z as i16).to_le_bytes());
        }
        push(&[7]);
        push(&[corners.len() as u8]);
        for corner in corners {
            push(&corner.to_le_bytes());
        }
        bytes
    }

    #[test]
    fn both_byte_orders_and_all_number_types_are_read() {
        for is_big_endian in [false, true] {
            let file = read(&binary(is_big_endian, 3, &[0, 1, 2])).unwrap();
            let third = [0.0, f64::from(0.1_f32), -3.0];
            assert_eq!(file.mesh.positions, [[0.0; 3], [f64::from(0.1_f32), 0.0, 0.0], third]);
            assert_eq!(file.mesh.triangles, [[0, 1, 2]]);
        }
    }

    #[test]
    fn text_keeps_all_digits_and_reads_what_other_programs_write() {
        let text = header("ascii", 4, 1)
            + "0.1 9 -.5 1\n\n 1. 9 nan 2\r\n1e3 9 -inf 3\n0 0 0 0\n\
                                            5 4 0 1 2 3";
        let file = read(text.as_bytes()).unwrap();
        assert_eq!(file.mesh.positions[0], [0.1, -0.5, 1.0]);
        assert!(file.mesh.positions[1][1].is_nan() && file.mesh.positions[2][1].is_infinite());
        assert_eq!(file.mesh.triangles.len(), 2);
    }

    #[test]
    fn lying_counts_are_errors_before_memory_is_taken() {
        for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
            for count in [4_000_000_000, usize::MAX] {
                for text in [header(format, count, 1), header(format, 0, count)] {
                    let error = read((text + "0 0 0 0\n").as_bytes()).unwrap_err();
                    assert!(error.contains(&count.to_string()), "{error}");
                }
            }
        }
        let nothing = "ply\nformat ascii 1.0\nelement vertex 9999999999\nend_header\n";
        assert!(read(nothing.as_bytes()).unwrap_err().contains("no properties"));
        let long_list = header("ascii", 1, 1) + "0 0 0 0\n0 18446744073709551615 0 0 0\n";
        assert!(read(long_list.as_bytes()).unwrap_err().contains("`vertex_indices` is missing"));
    }

    #[test]
    fn cut_off_files_are_errors() {
        let whole = binary(false, 3, &[0, 1, 2]);
        assert!(read(&whole[..whole.len() - 1]).unwrap_err().contains("element `face` 0"));
        assert!(read(&whole[..40]).is_err());
        let text = header("ascii", 2, 0) + "0 0 0 0            \n";
        assert_eq!(
            read(text.as_bytes()).unwrap_err(),
            "it ends after 1 of 2 of the element `vertex`"
        );
    }

    #[test]
    fn indices_that_name_no_vertex_are_errors() {
        for corner in [3, -1] {
            assert!(read(&binary(true, 3, &[0, 1, corner])).is_err());
            let text = header("ascii", 3, 1) + "0 0 0 0\n0 0 0 0\n0 0 0 0\n";
            let error = read(format!("{text}0 3 0 1 {corner}\n").as_bytes()).unwrap_err();
            assert!(error.starts_with("line 16: "), "{error}");
        }
    }

    #[test]
    fn a_point_cloud_has_no_triangles() {
        let cloud = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n\
                     property float y\nproperty float z\nend_header\n1 2 3\n";
        let file = read(cloud.as_bytes()).unwrap();
        assert_eq!((file.mesh.positions.len(), file.objects.len()), (1, 0));
        let strips = cloud.replace(
            "end_header",
            "element tristrips 1\nproperty list int int vertex_indices\nend_header",
        );
        let file = read((strips + "3 0 0 0\n").as_bytes()).unwrap();
        assert_eq!(file.mesh.triangles, [[0; 3]]);
        assert!(read(cloud.replace("float z", "float w").as_bytes()).unwrap_err().contains("`z`"));
    }

    #[test]
    fn faces_may_come_before_their_vertices() {
        let text = "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_index\n\
                    element vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                    end_header\n3 0 1 2\n0 0 0\n1 0 0\n0 1 0\n";
        assert_eq!(read(text.as_bytes()).unwrap().mesh.triangles, [[0, 1, 2]]);
    }

    #[test]
    fn errors_stay_on_one_line() {
        let error = read(b"ply\nformat ascii 1.0\nelement vertex\0\n").unwrap_err();
        assert!(error.starts_with("line 3: `element vertex\u{fffd}` stands where"), "{error}");
        assert!(!error.contains('\n') && error.len() < 200, "{error}");
        assert!(read(b"").is_err());
        assert!(read(b"ply\n").is_err());
    }

    /// Three vertices and a triangle, with a header's lines as they are given.
    fn triangle(vertex_properties: &str, vertices: [&str; 3]) -> String {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 3\n{vertex_properties}element face 1\n\
             property list uchar int vertex_index\nend_header\n{}\n3 0 1 2\n",
            vertices.join("\n")
        )
    }

    const POSITIONS: [[f64; 3]; 3] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    #[test]
    fn a_property_that_is_named_twice_shifts_no_other() {
        let xyz = "property float x\nproperty float y\nproperty float z\n";
        let pads = "property float pad\nproperty float pad\n";
        let padded = triangle(&format!("{pads}{xyz}"), ["5 7 0 0 0", "5 7 1 0 0", "5 7 0 1 0"]);
        let twice = triangle(
            &format!("property list uchar int x\n{xyz}property double x\n"),
            ["1 9 0 0 0 8", "2 9 9 1 0 0 8", "0 0 1 0 8"],
        );
        for (text, count) in [(padded, 1), (twice, 2)] {
            let file = read(text.as_bytes()).unwrap();
            assert_eq!(file.mesh.positions, POSITIONS);
            assert_eq!(file.notes, [Note { kind: NoteKind::RepeatedProperties, count }]);
        }
        let twice = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n\
                     property float z\nelement vertex 1\nproperty float x\nend_header\n1 2 3\n4\n";
        assert!(read(twice.as_bytes()).unwrap_err().contains("the element `vertex` twice"));
    }

    #[test]
    fn a_property_that_is_named_twice_shifts_no_other_in_binary() {
        let mut bytes =
            b"ply\nformat binary_big_endian 1.0\nelement vertex 1\nproperty uchar pad\n\
                          property list uchar short pad\nproperty float x\nproperty float y\n\
                          property float z\nend_header\n\x07\x01\0\x09"
                .to_vec();
        bytes.extend([1.0_f32, 2.0, 3.0].iter().flat_map(|number| number.to_be_bytes()));
        let file = read(&bytes).unwrap();
        assert_eq!(file.mesh.positions, [[1.0, 2.0, 3.0]]);
        assert_eq!(file.notes.len(), 1);
    }

    #[test]
    fn other_lists_of_a_face_are_skipped_before_and_after_its_corners() {
        let text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                    property float z\nelement face 2\nproperty list uchar int flags\n\
                    property list uchar int vertex_indices\nproperty list uchar float texcoord\n\
                    property list uchar int vertex_index\nend_header\n0 0 0\n1 0 0\n0 1 0\n\
                    1 9 3 0 1 2 2 0.5 0.5 1 7\n0 3 2 1 0 0 0\n";
        let file = read(text.as_bytes()).unwrap();
        assert_eq!(file.mesh.triangles, [[0, 1, 2], [2, 1, 0]]);
    }

    #[test]
    fn lines_of_a_header_may_end_with_cr_or_be_indented_or_empty() {
        let text = triangle(
            "  property float x\n\tproperty float y\n\nproperty float z\n",
            ["0 0 0", "1 0 0", "0 1 0"],
        );
        for end in ["\n", "\r\n", "\r"] {
            let file = read(text.replace('\n', end).as_bytes()).unwrap();
            assert_eq!(file.mesh.positions, POSITIONS, "{end:?}");
        }
        // The first byte after the header's last CR is a line feed by chance.
        let mut bytes = b"ply\rformat binary_little_endian 1.0\relement vertex 1\rproperty int x\r\
                          property uchar y\rproperty uchar z\rend_header\r"
            .to_vec();
        bytes.extend([10, 0, 0, 0, 2, 3]);
        assert_eq!(read(&bytes).unwrap().mesh.positions, [[10.0, 2.0, 3.0]]);
    }

    #[test]
    fn strips_become_triangles_of_one_winding_and_end_at_minus_one() {
        let text = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n\
                    property float z\nelement tristrips 1\nproperty list int int vertex_indices\n\
                    end_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n9 0 1 2 3 -1 2 3 4 -1\n";
        let file = read(text.as_bytes()).unwrap();
        assert_eq!(file.mesh.triangles, [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
        let error = read(text.replace("-1 2", "-2 2").as_bytes()).unwrap_err();
        assert!(error.contains("vertex -2, but the file's vertices are 0 to 4"), "{error}");
        assert!(read(text.replace("-1 2", "5 2").as_bytes()).is_err());
    }
}
