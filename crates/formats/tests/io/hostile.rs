//! Readers never panic, whatever the bytes: valid files of every format with bytes changed,
//! inserted, dropped or cut off, by a fixed seed.

use hullwright::Error;
use hullwright_formats::{Format, MeshFile, read_mesh, read_mesh_from_bytes, write_hulls};

use crate::glb::parts;
use crate::writers::tetrahedron;

/// Damaged files per valid file.
const ATTEMPTS: u64 = 4_000;

/// Xorshift (Marsaglia 2003): damage needs no better randomness.
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % end.max(1) as u64) as usize
    }
}

/// Bytes that matter to some format: signs, digits, separators, extremes.
const SPECIAL: &[u8] = b"-+.eE0129 \n\r\t/\\#\"{}[],:\x00\x01\x7f\x80\xff";

fn damage(valid: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = valid.to_vec();
    for _ in 0..=random.below(4) {
        let at = random.below(bytes.len());
        match random.below(7) {
            0 => bytes.truncate(at),
            1 if at < bytes.len() => bytes[at] ^= 1 << random.below(8),
            2 if at < bytes.len() => bytes[at] = SPECIAL[random.below(SPECIAL.len())],
            3 => bytes.insert(at, SPECIAL[random.below(SPECIAL.len())]),
            4 => {
                let end = (at + 1 + random.below(8)).min(bytes.len());
                bytes.drain(at.min(end)..end);
            }
            5 => {
                let end = (at + random.below(40)).min(bytes.len());
                let copy = bytes[at..end].to_vec();
                bytes.splice(at..at, copy);
            }
            _ => {
                for byte in bytes.iter_mut().skip(at).take(4) {
                    *byte = 0xff;
                }
            }
        }
    }
    bytes
}

fn assert_indices_name_vertices(file: &MeshFile) {
    let vertices = file.mesh.positions.len();
    assert!(file.mesh.triangles.iter().flatten().all(|vertex| (*vertex as usize) < vertices));
    let mut end = 0;
    for object in &file.objects {
        assert_eq!(object.triangles.start, end);
        assert!(object.triangles.end > end);
        end = object.triangles.end;
    }
    assert_eq!(end, file.mesh.triangles.len());
}

/// Whether damaged bytes are refused as a file; what is read has sound indices.
fn is_refused(format: Format, bytes: &[u8]) -> bool {
    match read_mesh_from_bytes(format, bytes) {
        Ok(file) => {
            assert_indices_name_vertices(&file);
            false
        }
        Err(Error::File { source, .. }) => {
            assert!(!source.to_string().is_empty());
            true
        }
        Err(error) => panic!("unexpected kind of error: {error}"),
    }
}

fn torture(format: Format, valid: &[u8]) {
    let file = read_mesh_from_bytes(format, valid).expect("the file is valid before it is damaged");
    assert!(!file.mesh.triangles.is_empty());
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    for _ in 0..ATTEMPTS {
        is_refused(format, &damage(valid, &mut random));
    }
}

#[test]
fn obj() {
    let text = "# a house\no wall\nv 0 0 0\nv 1 0 0 1.0\nv 1 1 0 0.1 0.2 0.3\nv 0 1 0\n\
                vt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1 4/1/1\ng roof\nv 0.5 1.5 -1e-3\n\
                f -1 -2 -3\nl 1 2 \\\n3\nf 1 \\\n2 5 4 3\n";
    torture(Format::Obj, text.as_bytes());
}

#[test]
fn a_mark_before_the_text_hides_no_line_and_utf_16_is_read() {
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n";
    let off = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    for (format, text) in [(Format::Obj, obj), (Format::Off, off)] {
        let marked = [b"\xEF\xBB\xBF", text.as_bytes()].concat();
        let units = || std::iter::once(0xfeff).chain(text.encode_utf16());
        let little = units().flat_map(u16::to_le_bytes).collect();
        let big = units().flat_map(u16::to_be_bytes).collect();
        let expected = read_mesh_from_bytes(format, text.as_bytes()).unwrap();
        for bytes in [marked, little, big] {
            assert_eq!(read_mesh_from_bytes(format, &bytes).unwrap(), expected);
        }
    }
}

#[test]
fn off() {
    let text = "COFF\n# five corners\n5 3 0\n0 0 0 255 0 0\n1 0 0\n1.0 1 0\n0 1e0 0\n0.5 .5 1\n\
                4 0 1 2 3\n3 0 1 4 0.5 0.5 0.5\n5 4 3 2 1 0\n";
    torture(Format::Off, text.as_bytes());
}

const PLY_VERTICES: [[f32; 3]; 5] =
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.5, 1.0]];
const PLY_FACES: [&[i32]; 3] = [&[0, 1, 2, 3], &[0, 1, 4], &[4, 3, 2, 1, 0]];

fn ply_header(format: &str) -> String {
    format!(
        "ply\nformat {format} 1.0\ncomment small\nelement vertex 5\nproperty float x\n\
         property float y\nproperty float z\nelement face 3\n\
         property list uchar int vertex_indices\nproperty uchar flags\nend_header\n"
    )
}

#[test]
fn ply_text() {
    let mut text = ply_header("ascii");
    for [x, y, z] in PLY_VERTICES {
        text += &format!("{x} {y} {z}\n");
    }
    for face in PLY_FACES {
        let corners: Vec<String> = face.iter().map(i32::to_string).collect();
        text += &format!("{} {} 0\n", face.len(), corners.join(" "));
    }
    torture(Format::Ply, text.as_bytes());
}

#[test]
fn ply_binary() {
    for is_little in [true, false] {
        let endian = if is_little { "little" } else { "big" };
        let mut bytes = ply_header(&format!("binary_{endian}_endian")).into_bytes();
        let in_order =
            |number: u32| if is_little { number.to_le_bytes() } else { number.to_be_bytes() };
        bytes.extend(PLY_VERTICES.iter().flatten().flat_map(|x| in_order(x.to_bits())));
        for face in PLY_FACES {
            bytes.push(face.len() as u8);
            bytes.extend(face.iter().flat_map(|&corner| in_order(corner as u32)));
            bytes.push(0);
        }
        torture(Format::Ply, &bytes);
    }
}

#[test]
fn stl_text() {
    let facet = "facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n\
                 \x20 vertex 0 1e0 -0.5\n endloop\nendfacet\n";
    let text = format!("solid one\n{facet}{facet}endsolid one\nsolid two\n{facet}endsolid two\n");
    torture(Format::Stl, text.as_bytes());
}

#[test]
fn stl_binary() {
    let mut bytes = b"solid but binary".to_vec();
    bytes.resize(80, b' ');
    bytes.extend(3_u32.to_le_bytes());
    bytes.extend((0..150_u8).map(|byte| byte.wrapping_mul(7)));
    torture(Format::Stl, &bytes);
}

fn glb() -> Vec<u8> {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("hulls.glb");
    write_hulls(&path, &[tetrahedron([0.0; 3], 1.0), tetrahedron([0.0; 3], 1.0)]).unwrap();
    std::fs::read(path).unwrap()
}

#[test]
fn glb_bytes() {
    torture(Format::Gltf, &glb());
}

/// Damage to random bytes of JSON mostly breaks its syntax. Here numbers are replaced by others,
/// so that what comes after the syntax is reached.
#[test]
fn glb_with_other_numbers() {
    with_other_numbers(&glb());
    for file in COMPRESSED {
        with_other_numbers(&compressed(file));
    }
}

fn with_other_numbers(whole: &[u8]) {
    let json_end = whole.len() - parts(whole).1.len() - 8;
    let numbers: Vec<usize> = (20..json_end)
        .filter(|at| whole[*at].is_ascii_digit() && !whole[at - 1].is_ascii_digit())
        .collect();
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    for _ in 0..ATTEMPTS {
        let mut bytes = whole.to_vec();
        for _ in 0..=random.below(2) {
            let start = numbers[random.below(numbers.len())];
            for byte in bytes[start..json_end].iter_mut().take_while(|byte| byte.is_ascii_digit()) {
                *byte = b"0123456789"[random.below(10)];
            }
            // A number may not begin with a zero.
            bytes[start] = bytes[start].max(b'1');
        }
        is_refused(Format::Gltf, &bytes);
    }
}

/// What other programs compressed.
const COMPRESSED: [&str; 6] = [
    "leaf_draco_sequential.glb",
    "mug_draco.glb",
    "mug_draco_quantized.glb",
    "mug_draco_valence.glb",
    "mug_meshopt_ext.glb",
    "mug_meshopt_khr.glb",
];

fn compressed(file: &str) -> Vec<u8> {
    let directory = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data");
    std::fs::read(directory.join(file)).unwrap()
}

/// Only the streams are damaged, so that what decodes them is reached each time.
#[test]
fn compressed_streams() {
    for file in COMPRESSED {
        let whole = compressed(file);
        let chunk = whole.len() - parts(&whole).1.len();
        let mut random = Random(0x2545_f491_4f6c_dd1d);
        let mut refused = 0;
        for _ in 0..ATTEMPTS {
            let mut bytes = whole.clone();
            let mut stream = damage(&whole[chunk..], &mut random);
            // The description stays true to the length.
            stream.resize(whole.len() - chunk, 0);
            bytes[chunk..].copy_from_slice(&stream);
            refused += u64::from(is_refused(Format::Gltf, &bytes));
        }
        assert!(refused > ATTEMPTS / 10, "{file}: only {refused} damaged streams were refused");
    }
}

#[test]
fn compressed_bytes() {
    for file in COMPRESSED {
        torture(Format::Gltf, &compressed(file));
    }
}

#[test]
fn files_that_are_not_there_or_of_no_known_format_are_errors_with_their_path() {
    for (path, expected) in [
        ("missing.obj", "missing.obj: "),
        ("missing.xyz", "suffix"),
        ("missing", "suffix"),
        (".", "folder"),
    ] {
        let error = read_mesh(path).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
}
