use hullwright::{MeshView, TriangleMesh};
use hullwright_formats::palette;

use super::*;

const RED: Colour = [220, 40, 30];

/// A box from the origin, 12 triangles.
fn box_mesh(size: [f64; 3]) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let positions = (0..8_u32)
        .map(|corner| [0, 1, 2].map(|axis| f64::from((corner >> axis) & 1) * size[axis]))
        .collect();
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
    (positions, triangles.collect())
}

fn panel(mesh: &(Vec<[f64; 3]>, Vec<[u32; 3]>), colour: Colour) -> Panel {
    let mut panel = Panel::mesh(MeshView::new(&mesh.0, &mesh.1));
    panel.parts[0].colour = colour;
    panel
}

fn is_background(picture: &Picture, columns: std::ops::Range<usize>) -> bool {
    columns.into_iter().all(|column| {
        (0..picture.height()).all(|row| picture.pixel(column, row) == Some(BACKGROUND))
    })
}

#[test]
fn nothing_is_drawn_as_background() {
    let picture = render(&[], 40, 30).unwrap();
    assert!(is_background(&picture, 0..40));
    let picture =
        render(&[Panel::default(), Panel::mesh(&TriangleMesh::default())], 40, 30).unwrap();
    assert!(is_background(&picture, 0..40));
}

#[test]
fn a_red_box_covers_the_centre_and_leaves_the_corners_free() {
    let mesh = box_mesh([1.0; 3]);
    let picture = render(&[panel(&mesh, RED)], 90, 90).unwrap();
    let [red, green, blue] = picture.pixel(45, 45).unwrap();
    assert!(red > 120 && green < 80 && blue < 80);
    for corner in [(0, 0), (89, 0), (0, 89), (89, 89)] {
        assert_eq!(picture.pixel(corner.0, corner.1), Some(BACKGROUND));
    }
    assert_eq!(picture.pixel(90, 0), None);
}

#[test]
fn no_pixel_of_a_lit_box_is_nearly_black() {
    let mesh = box_mesh([1.0, 0.4, 2.0]);
    let picture = render(&[panel(&mesh, palette::CLAY)], 120, 90).unwrap();
    assert!(picture.pixels().iter().all(|pixel| pixel.iter().all(|channel| *channel > 70)));
}

#[test]
fn the_three_faces_of_a_box_have_three_shades() {
    let mesh = box_mesh([1.0; 3]);
    let picture = render(&[panel(&mesh, palette::CLAY)], 120, 120).unwrap();
    let mut shades: Vec<Colour> = picture.pixels().to_vec();
    shades.sort_unstable();
    let frequent = shades.chunk_by(|a, b| a == b).filter(|same| same.len() > 600);
    // Three faces and the background.
    assert_eq!(frequent.count(), 4);
}

#[test]
fn edges_within_a_face_are_drawn_on_demand() {
    let mesh = box_mesh([1.0; 3]);
    let dark = |wires: bool| {
        let layout = Layout { wires, ..Layout::default() };
        let picture = render_with(&[panel(&mesh, palette::CLAY)], 120, 120, &layout).unwrap();
        let light = |pixel: &Colour| pixel.iter().map(|&channel| u64::from(channel)).sum::<u64>();
        picture.pixels().iter().map(light).sum::<u64>()
    };
    assert!(dark(true) < dark(false));
}

#[test]
fn panels_stand_side_by_side() {
    let mesh = box_mesh([1.0; 3]);
    let picture = render(&[Panel::default(), panel(&mesh, RED)], 120, 60).unwrap();
    assert!(is_background(&picture, 0..60));
    assert_ne!(picture.pixel(90, 30), Some(BACKGROUND));
}

#[test]
fn columns_break_panels_into_rows() {
    let mesh = box_mesh([1.0; 3]);
    let layout = Layout { columns: Some(1), ..Layout::default() };
    let picture = render_with(&[panel(&mesh, RED), Panel::default()], 60, 120, &layout).unwrap();
    assert_ne!(picture.pixel(30, 30), Some(BACKGROUND));
    assert_eq!(picture.pixel(30, 90), Some(BACKGROUND));
}

#[test]
fn panels_share_a_scale_unless_asked_otherwise() {
    let (small, large) = (box_mesh([1.0; 3]), box_mesh([4.0; 3]));
    let panels = [panel(&small, RED), panel(&large, RED)];
    let drawn = |layout: &Layout| {
        let picture = render_with(&panels, 160, 80, layout).unwrap();
        let mut counts = [0, 0];
        for row in 0..80 {
            for column in 0..160 {
                if picture.pixel(column, row) != Some(BACKGROUND) {
                    counts[column / 80] += 1;
                }
            }
        }
        counts
    };
    let [small_shared, large_shared] = drawn(&Layout::default());
    assert!(large_shared > 8 * small_shared);
    let separate = Layout { separate_frames: true, ..Layout::default() };
    let [small_own, large_own] = drawn(&separate);
    assert_eq!(small_own, large_own);
}

#[test]
fn an_exploded_panel_moves_its_parts_apart() {
    let (positions, mut triangles) = box_mesh([1.0; 3]);
    let mut moved = positions.clone();
    moved.iter_mut().for_each(|position| position[0] += 1.0);
    let offset = positions.len() as u32;
    let all: Vec<[f64; 3]> = positions.into_iter().chain(moved).collect();
    triangles.extend(triangles.clone().iter().map(|t| t.map(|index| index + offset)));
    let labels: Vec<u32> = (0..24).map(|triangle| triangle / 12).collect();
    let panel = Panel::labelled(MeshView::new(&all, &triangles), &labels);
    let front = Layout {
        view: View { azimuth: 0.0, elevation: 0.0, ..View::default() },
        ..Layout::default()
    };
    let middle_of = |panel: Panel| {
        let picture = render_with(&[panel], 121, 61, &front).unwrap();
        picture.pixel(60, 30).unwrap()
    };
    assert_ne!(middle_of(panel.clone()), BACKGROUND);
    assert_eq!(middle_of(panel.exploded(0.5)), BACKGROUND);
}

#[test]
fn labels_and_hulls_have_the_same_colours() {
    let (positions, triangles) = box_mesh([1.0; 3]);
    let labels = [3; 12];
    let panel = Panel::labelled(MeshView::new(&positions, &triangles), &labels);
    assert_eq!(panel.parts.len(), 1);
    assert_eq!(panel.parts[0].colour, palette::colour(3));
}

#[test]
fn bad_triangles_are_left_out_and_do_not_spoil_the_frame() {
    let (mut positions, mut triangles) = box_mesh([1.0; 3]);
    let clean = positions.clone();
    let clean_triangles = triangles.clone();
    positions.extend([[f64::NAN; 3], [f64::INFINITY; 3], [1e300; 3], [1e9; 3]]);
    triangles.extend([[0, 1, 8], [0, 1, 9], [0, 1, 10], [0, 1, 99], [u32::MAX; 3]]);
    let picture = render(&[Panel::mesh(MeshView::new(&positions, &triangles))], 60, 60).unwrap();
    let expected = render(&[Panel::mesh(MeshView::new(&clean, &clean_triangles))], 60, 60).unwrap();
    assert_eq!(picture, expected);
}

#[test]
fn size_and_place_of_a_mesh_do_not_change_its_picture_much() {
    let mesh = box_mesh([1.0, 2.0, 0.5]);
    let expected = render(&[panel(&mesh, RED)], 60, 60).unwrap();
    for factor in [1e-6, 1e6] {
        let mut other = mesh.clone();
        for position in &mut other.0 {
            *position = position.map(|value| (value + 1000.0) * factor);
        }
        let picture = render(&[panel(&other, RED)], 60, 60).unwrap();
        for (pixel, expected) in picture.pixels().iter().zip(expected.pixels()) {
            assert!((0..3).all(|channel| pixel[channel].abs_diff(expected[channel]) <= 2));
        }
    }
}

#[test]
fn the_same_scene_gives_the_same_png() {
    let mesh = box_mesh([1.0, 2.0, 0.5]);
    let png = || render(&[panel(&mesh, RED)], 64, 48).unwrap().to_png().unwrap();
    assert_eq!(png(), png());
}

#[test]
fn a_png_holds_the_pixels_of_the_picture() {
    let mesh = box_mesh([1.0, 2.0, 0.5]);
    let picture = render(&[panel(&mesh, RED)], 64, 48).unwrap();
    let bytes = picture.to_png().unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert_eq!((info.width, info.height), (64, 48));
    assert_eq!(pixels, picture.pixels().as_flattened());
}

#[test]
fn a_side_of_no_or_too_many_pixels_is_an_error() {
    for (width, height) in [(0, 10), (10, 0), (LARGEST_SIDE + 1, 10), (10, usize::MAX)] {
        let error = render(&[], width, height).unwrap_err();
        assert!(matches!(error, Error::InvalidParameter { .. }));
    }
}

#[test]
fn more_panels_than_pixels_leave_the_picture_empty() {
    let mesh = box_mesh([1.0; 3]);
    let panels = vec![panel(&mesh, RED); 9];
    let picture = render(&panels, 8, 8).unwrap();
    assert!(is_background(&picture, 0..8));
}

#[test]
fn an_unwritable_path_is_an_error_that_names_it() {
    let picture = render(&[], 4, 4).unwrap();
    let error = picture.write_png("no such folder/picture.png").unwrap_err();
    assert!(error.to_string().contains("no such folder/picture.png"));
}
