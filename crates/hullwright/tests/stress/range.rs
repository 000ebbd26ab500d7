//! Coordinates of any size, anywhere.

use hullwright::{Error, convex_hull};

use crate::common::{Mesh, cuboid, torus, u_prism};
use crate::independent::exact::{Faults, faults};
use crate::{assert_sound, decomposed, placed};

/// Squares and cubes of lengths leave the range of `f32` at 1e±13, and thresholds in absolute units
/// show.
#[test]
fn from_a_trillionth_of_a_micrometre_to_beyond_light_years_the_hulls_are_as_many() {
    let expected = assert_sound("1", &torus()).hulls.len();
    for exponent in [-18, -12, -6, -3, 3, 6, 12, 18] {
        let name = format!("1e{exponent}");
        let scaled = placed(&torus(), |point| point.map(|x| x * 10_f64.powi(exponent)));
        assert_eq!(assert_sound(&name, &scaled).hulls.len(), expected, "{name}");
    }
}

/// A million sizes from the origin `f32` has an eighth of a unit left; whole numbers lose nothing.
#[test]
fn a_million_sizes_away_whole_numbers_have_the_same_hulls() {
    for exponent in [0, 10, 20, 22] {
        let offset = f64::from(1 << exponent);
        let moved = placed(&u_prism(), |point| point.map(|x| x + offset));
        let found = assert_sound(&format!("{offset}"), &moved);
        assert_eq!(found.hulls.len(), 3, "{offset}");
        let volume: f64 = found.hulls.iter().map(|hull| hull.shape.volume()).sum();
        assert!((5.0 - 1e-6..8.0).contains(&volume), "{offset}: {volume}");
    }
}

/// Where rounding to `f32` has made steps of a smooth surface, the steps are the shape.
#[test]
fn a_torus_that_rounding_far_from_the_origin_has_dented_keeps_the_promise() {
    for sizes in [1e2, 1e3, 1e4, 1e5, 1e6] {
        let moved = placed(&torus(), |[x, y, z]| [x + 2.6 * sizes, y - 2.6 * sizes, z]);
        assert_sound(&format!("{sizes} sizes"), &moved);
    }
}

/// The largest numbers: sums of two of them are infinite in single precision.
#[test]
fn a_box_over_all_of_single_precision_is_one_hull_of_its_corners() {
    let most = f64::from(f32::MAX);
    let found = assert_sound("all", &cuboid([-most; 3], [most; 3]));
    assert_eq!(found.hulls.len(), 1);
    let (points, _) = found.hulls[0].shape.to_single_precision().unwrap();
    assert!(points.iter().flatten().all(|x| x.abs() == f32::MAX), "{points:?}");
}

/// The smallest: below 1.2e-38 numbers lose digits, and at 1.4e-45 one is all there is.
#[test]
fn boxes_of_subnormal_numbers_are_one_hull() {
    for size in [1e-37_f32, 1e-40, 1e-43, f32::from_bits(3), f32::from_bits(1)] {
        let found = assert_sound(&format!("{size:e}"), &cuboid([0.0; 3], [f64::from(size); 3]));
        assert_eq!(found.hulls.len(), 1, "{size:e}");
    }
}

fn u_with_an_outlier(distance: f64) -> Mesh {
    let (mut positions, mut triangles) = u_prism();
    positions.push([distance, 0.0, 0.0]);
    triangles.push([0, 1, positions.len() as u32 - 1]);
    (positions, triangles)
}

/// One vertex far away makes all others small, as seen from there.
#[test]
fn a_far_outlier_does_not_break_the_rest() {
    for distance in [1e2, 1e4, 1e6] {
        assert_sound(&format!("{distance:e}"), &u_with_an_outlier(distance));
    }
}

/// Still farther away it makes them one spot, and the whole a line.
#[test]
fn an_outlier_that_leaves_only_a_line_is_a_typed_error() {
    for distance in [1e12, 1e30, 3e38] {
        let result = decomposed(&u_with_an_outlier(distance));
        assert!(matches!(result, Err(Error::NothingUsable { .. })), "{distance:e}: {result:?}");
    }
}

/// Double precision reaches beyond what engines can hold: that is an error, not rounded to
/// infinity.
#[test]
fn what_is_beyond_single_precision_has_hulls_whose_rounding_is_an_error() {
    for scale in [1e39, 1e150, 1e300] {
        let found = decomposed(&cuboid([0.0; 3], [scale; 3])).unwrap();
        let shape = &found.hulls[0].shape;
        assert_eq!(faults(&shape.points, &shape.triangles), Faults::default(), "{scale:e}");
        assert!(matches!(shape.to_single_precision(), Err(Error::NoHull { .. })), "{scale:e}");
    }
}

/// Below the least normal number of double precision there is no inverse: refused, not divided by.
#[test]
fn what_is_below_double_precision_is_a_typed_error_or_a_hull() {
    for scale in [1e-290, 1e-300, 1e-307, 1e-310, 5e-324] {
        let mesh = cuboid([0.0; 3], [scale; 3]);
        match decomposed(&mesh) {
            Ok(found) => assert_eq!(found.hulls.len(), 1, "{scale:e}"),
            Err(error) => {
                assert!(matches!(error, Error::NothingUsable { .. }), "{scale:e}: {error}")
            }
        }
        let _ = convex_hull(&mesh.0);
    }
}
