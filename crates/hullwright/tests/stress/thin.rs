//! Needles and plates: what is thin has normals that are all noise.

use hullwright::Error;

use crate::common::{cuboid, join, lathe, u_prism};
use crate::{assert_sound, decomposed, placed};

fn askew([x, y, z]: [f64; 3]) -> [f64; 3] {
    [0.6 * x - 0.8 * y, 0.48 * x + 0.36 * y - 0.8 * z, 0.64 * x + 0.48 * y + 0.6 * z]
}

/// Needles a few millionths as wide as long are near the hull's tolerance, and thinner than engines
/// can hold.
#[test]
fn needles_of_millionths_in_any_direction_are_bodies() {
    for [a, b] in [[1e-4, 1e-4], [1e-5, 2e-6], [2e-6, 2e-6]] {
        let needle = cuboid([0.0; 3], [1.0, a, b]);
        assert_sound(&format!("along an axis, {a} {b}"), &needle);
        assert_sound(&format!("askew, {a} {b}"), &placed(&needle, askew));
    }
}

/// Below a millionth of the diagonal welding makes a line of it, and a line has no surface.
#[test]
fn a_needle_that_welding_makes_a_line_is_a_typed_error() {
    for width in [5e-7, 1e-7, 1e-12] {
        let result = decomposed(&placed(&cuboid([0.0; 3], [1.0, width, width]), askew));
        assert!(matches!(result, Err(Error::NothingUsable { .. })), "{width}: {result:?}");
    }
}

/// A plate a ten-millionth as thick as wide is at the rounding of `f32`, so that its sides cross.
#[test]
fn plates_of_a_ten_millionth_are_bodies() {
    for thickness in [1e-5, 1e-6, 1e-7, 1e-8, 0.0] {
        assert_sound(&format!("{thickness}"), &cuboid([0.0; 3], [1.0, 1.0, thickness]));
        let askew = placed(&u_prism(), |[x, y, z]| [x, y, 0.3 * x + 0.2 * y + thickness * z]);
        assert_sound(&format!("askew, {thickness}"), &askew);
    }
}

/// Blades that taper to nothing: no step from thick to thin.
#[test]
fn a_cone_to_a_point_a_thousand_times_as_long_as_wide_is_one_body() {
    for width in [1e-1, 1e-3, 1e-5] {
        let cone = lathe(&[[1e-9, 0.0], [width, 0.0], [1e-9, 1.0]], 24);
        assert_sound(&format!("{width}"), &cone);
    }
}

/// Many at once, of all widths: what is found for one must not be lost among the others.
#[test]
fn a_brush_of_needles_on_a_plate_keeps_the_promise() {
    let mut parts = vec![cuboid([0.0; 3], [1.0, 1.0, 1e-4])];
    for i in 0..36 {
        let width = 10_f64.powi(-2 - i % 6);
        let (x, y) = (f64::from(i % 6) / 6.0 + 0.05, f64::from(i / 6) / 6.0 + 0.05);
        parts.push(cuboid([x, y, 1e-4], [x + width, y + width, 0.8]));
    }
    assert_sound("brush", &join(&parts));
}
