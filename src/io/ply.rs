//! PLY: text and binary of both byte orders.
//!
//! Read are the element `vertex` with the properties `x`, `y`, `z` of any type, and the element
//! `face` with the list `vertex_indices` or `vertex_index`. A file without faces is a point cloud.
//!
//! The crate `ply-rs-bw` (4.0) reads the header and binary elements, one at a time. Two things
//! are done here instead. First, counts are compared with the file's size before anything is
//! read: an element without properties takes no bytes, so that a count could cause any amount
//! of work. Second, text elements are read here, since the crate's grammar refuses numbers like
//! `.5`, `1.` and `nan` that other programs write, and its `float` properties would round text
//! to `f32`.

use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType,
    ScalarType,
};

use super::mesh_file::{MeshFile, next_index};
use super::text::{Triangulator, at_line, known_vertex, lines, name, number, quote, words};

const AXES: [&str; 3] = ["x", "y", "z"];
const CORNER_LISTS: [&str; 2] = ["vertex_indices", "vertex_index"];

pub(super) fn read(bytes: &[u8]) -> Result<MeshFile, String> {
    let mut reader = Reader::new(bytes);
    if !bytes.starts_with(b"ply") {
        return Err("line 1: it does not begin with `ply`".into());
    }
    let header = Parser::<Element>::new().read_header(&mut reader);
    let header = header.map_err(|error| match in_one_line(error) {
        reason if reason.starts_with("line ") => reason,
        reason => format!("line {}: {reason}", reader.line()),
    })?;
    let header_lines = reader.line().saturating_sub(1);
    let payload = reader.into_inner();
    check_header(&header, payload.len())?;

    let mut mesh = MeshBuilder::new(&header);
    match header.encoding {
        Encoding::Ascii => read_text(payload, header_lines, &header, &mut mesh)?,
        Encoding::BinaryBigEndian | Encoding::BinaryLittleEndian => {
            read_binary(payload, &header, &mut mesh)?;
        }
    }
    mesh.finish()
}

/// The crate's messages go over several lines: what is wrong, the file's text without limit,
/// and sometimes the cause.
fn in_one_line(error: ParseError) -> String {
    let message = error.to_string();
    let mut lines = message.lines();
    let first = lines.next().unwrap_or_default().trim_end_matches('.');
    let reason = match first.split_once("Line ") {
        Some(("", reason)) => format!("line {reason}"),
        _ => name(first.as_bytes()),
    };
    match lines.next().and_then(|text| text.trim().strip_prefix("String: ")) {
        Some(text) => format!("{reason}: {}", quote(text.trim_matches('\'').as_bytes())),
        None => reason,
    }
}

/// Refuses what can't be a mesh, and counts that the rest of the file is too short for.
fn check_header(header: &Header, payload_length: usize) -> Result<(), String> {
    let mut least_length: usize = 0;
    for element in header.elements.values() {
        let length_each = match header.encoding {
            // A character and the line's end, or a space, for each property.
            Encoding::Ascii => element.properties.len().saturating_mul(2),
            _ => element.properties.values().map(|p| least_size(&p.data_type)).sum(),
        };
        if length_each == 0 && element.count > 0 {
            return Err(format!("the element `{}` has no properties", element.name));
        }
        least_length = least_length.saturating_add(element.count.saturating_mul(length_each));
        // The last line of a text may lack its end.
        if least_length > payload_length.saturating_add(1) {
            return Err(format!(
                "the header announces {} of the element `{}`, but only {payload_length} bytes \
                 follow it",
                element.count, element.name
            ));
        }
    }
    let Some(vertex) = header.elements.get("vertex") else {
        return Err("the header has no element `vertex`".into());
    };
    for axis in AXES {
        let scalar = vertex.properties.get(axis).map(|property| &property.data_type);
        if !matches!(scalar, Some(PropertyType::Scalar(_))) {
            return Err(format!("the element `vertex` has no number `{axis}`"));
        }
    }
    if let Some(face) = header.elements.get("face")
        && face.count > 0
        && corner_list(face).is_none()
    {
        return Err("the element `face` has no list `vertex_indices` or `vertex_index`".into());
    }
    if header.elements.get("tristrips").is_some_and(|strips| strips.count > 0) {
        return Err("triangle strips (`tristrips`) can't be read, only faces".into());
    }
    Ok(())
}

/// The list of a face's corners, if it has one.
fn corner_list(face: &ElementDef) -> Option<&'static str> {
    CORNER_LISTS.into_iter().find(|name| {
        let list = face.properties.get(*name).map(|property| &property.data_type);
        matches!(list, Some(PropertyType::List(..)))
    })
}

/// The fewest bytes that a property takes in a binary file; of a list that is its length.
fn least_size(data_type: &PropertyType) -> usize {
    let (PropertyType::Scalar(scalar) | PropertyType::List(scalar, _)) = data_type;
    match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}

/// The part of an element that makes the mesh: a vertex's position or a face's corners.
#[derive(Default)]
struct Element {
    position: [f64; 3],
    /// `None` where an index is negative or no integer.
    corners: Option<Vec<u32>>,
}

impl PropertyAccess for Element {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if let Some(axis) = AXES.iter().position(|axis| *axis == name) {
            self.position[axis] = scalar(&property);
        } else if CORNER_LISTS.contains(&name) {
            self.corners = property.to_u32_list();
        }
        PropertyAccessResult::Set
    }
}

fn scalar(property: &Property) -> f64 {
    match property {
        Property::Char(value) => f64::from(*value),
        Property::UChar(value) => f64::from(*value),
        Property::Short(value) => f64::from(*value),
        Property::UShort(value) => f64::from(*value),
        Property::Int(value) => f64::from(*value),
        Property::UInt(value) => f64::from(*value),
        Property::Float(value) => f64::from(*value),
        Property::Double(value) => *value,
        // By the header it is a number, so that it can't be a list.
        _ => f64::NAN,
    }
}

fn read_binary(mut payload: &[u8], header: &Header, mesh: &mut MeshBuilder) -> Result<(), String> {
    let parser = Parser::<Element>::new();
    for definition in header.elements.values() {
        for index in 0..definition.count {
            let element = if header.encoding == Encoding::BinaryBigEndian {
                parser.read_big_endian_element(&mut payload, definition)
            } else {
                parser.read_little_endian_element(&mut payload, definition)
            };
            element
                .map_err(in_one_line)
                .and_then(|element| mesh.add(&definition.name, element))
                .map_err(|reason| format!("element `{}` {index}: {reason}", definition.name))?;
        }
    }
    Ok(())
}

fn read_text(
    payload: &[u8],
    header_lines: usize,
    header: &Header,
    mesh: &mut MeshBuilder,
) -> Result<(), String> {
    let mut lines = lines(payload).filter(|(_, text)| !text.trim_ascii().is_empty());
    for definition in header.elements.values() {
        for index in 0..definition.count {
            let (line, text) = lines.next().ok_or_else(|| {
                let ElementDef { name, count, .. } = definition;
                format!("it ends after {index} of {count} of the element `{name}`")
            })?;
            read_element(text, definition)
                .and_then(|element| mesh.add(&definition.name, element))
                .map_err(at_line(header_lines + line))?;
        }
    }
    Ok(())
}

fn read_element(text: &[u8], definition: &ElementDef) -> Result<Element, String> {
    let mut words = words(text);
    let mut next = |name: &str| words.next().ok_or_else(|| format!("`{name}` is missing"));
    let mut element = Element::default();
    for (name, property) in &definition.properties {
        match property.data_type {
            PropertyType::Scalar(_) => {
                let word = next(name)?;
                if let Some(axis) = AXES.iter().position(|axis| axis == name) {
                    element.position[axis] = number(word)?;
                }
            }
            PropertyType::List(..) => {
                let length: usize = number(next(name)?)?;
                let mut corners = Vec::new();
                for _ in 0..length {
                    let word = next(name)?;
                    if CORNER_LISTS.contains(&name.as_str()) {
                        corners.push(number(word)?);
                    }
                }
                if CORNER_LISTS.contains(&name.as_str()) {
                    element.corners = Some(corners);
                }
            }
        }
    }
    Ok(element)
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
            vertices: header.elements.get("vertex").map_or(0, |vertex| vertex.count),
        }
    }

    fn add(&mut self, kind: &str, element: Element) -> Result<(), String> {
        match kind {
            "vertex" => self.file.mesh.positions.push(element.position),
            "face" => {
                let corners =
                    element.corners.ok_or("the corners of a face must be whole numbers from 0")?;
                for &corner in &corners {
                    known_vertex(corner, self.vertices)?;
                }
                if self.file.mesh.positions.len() == self.vertices {
                    self.triangulator.append(&mut self.file.mesh, &corners);
                } else {
                    self.early_faces.push(corners);
                }
            }
            _ => {}
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
    fn a_point_cloud_has_no_triangles_and_strips_are_refused() {
        let cloud = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n\
                     property float y\nproperty float z\nend_header\n1 2 3\n";
        let file = read(cloud.as_bytes()).unwrap();
        assert_eq!((file.mesh.positions.len(), file.objects.len()), (1, 0));
        let strips = cloud.replace(
            "end_header",
            "element tristrips 1\nproperty list int int vertex_indices\nend_header",
        );
        assert!(read((strips + "3 0 0 0\n").as_bytes()).unwrap_err().contains("tristrips"));
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
        assert!(error.starts_with("line 3: Couldn't parse line: `element"), "{error}");
        assert!(!error.contains('\n') && error.len() < 200, "{error}");
        assert!(read(b"").is_err());
        assert!(read(b"ply\n").is_err());
    }
}
