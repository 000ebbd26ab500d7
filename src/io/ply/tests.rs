//! Tests of `ply`.

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
    assert_eq!(read(text.as_bytes()).unwrap_err(), "it ends after 1 of 2 of the element `vertex`");
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
