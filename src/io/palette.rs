//! Colours that tell hulls apart.
//!
//! Hues follow each other by the golden angle, so that any number of first colours is spread
//! about evenly around the circle, in OKLCH, where equal steps look equally large. Lightness
//! alternates too, since neighbours in hue come back after some turns.

/// 360° divided by the square of the golden ratio.
const GOLDEN_ANGLE: f64 = 137.507_764_050_037_85;

/// Hue of the first hull, in degrees: a blue.
const FIRST_HUE: f64 = 250.0;

/// Light enough to show shading, dark enough to stand before a white background.
const LIGHTNESS: [f64; 4] = [0.72, 0.60, 0.80, 0.66];

/// Clear, but not glaring.
const CHROMA: f64 = 0.13;

/// Where a colour lies outside of sRGB, chroma is lowered in these steps until it lies inside.
const CHROMA_STEP: f64 = 0.95;

/// The colour of the hull with this index, as sRGB. The same on every machine.
pub fn srgb(index: usize) -> [u8; 3] {
    let hue = (FIRST_HUE + GOLDEN_ANGLE * index as f64) % 360.0;
    let lightness = LIGHTNESS[index % LIGHTNESS.len()];
    let mut chroma = CHROMA;
    let mut linear = linear_from_oklch(lightness, chroma, hue);
    while !linear.iter().all(|part| (0.0..=1.0).contains(part)) && chroma > 1e-3 {
        chroma *= CHROMA_STEP;
        linear = linear_from_oklch(lightness, chroma, hue);
    }
    linear.map(|part| (encode(part.clamp(0.0, 1.0)) * 255.0).round() as u8)
}

/// The same colour as linear RGB from 0 to 1, as glTF wants it.
pub fn linear_rgb(index: usize) -> [f32; 3] {
    srgb(index).map(|part| decode(f64::from(part) / 255.0) as f32)
}

/// Björn Ottosson's Oklab (2020), hue in degrees.
fn linear_from_oklch(lightness: f64, chroma: f64, hue: f64) -> [f64; 3] {
    let (sin, cos) = hue.to_radians().sin_cos();
    let (a, b) = (chroma * cos, chroma * sin);
    let l = (lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
    let m = (lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
    let s = (lightness - 0.089_484_177_5 * a - 1.291_485_548_0 * b).powi(3);
    [
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701_0 * s,
    ]
}

/// The transfer function of sRGB (IEC 61966-2-1) and its inverse.
fn encode(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

fn decode(encoded: f64) -> f64 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_colours_are_as_documented() {
        assert_eq!(srgb(0), [96, 170, 243]);
    }

    #[test]
    fn any_two_of_forty_hulls_look_different() {
        for first in 0..40 {
            for second in 0..first {
                let (a, b) = (srgb(first), srgb(second));
                let difference: u32 = a.iter().zip(b).map(|(a, b)| u32::from(a.abs_diff(b))).sum();
                assert!(difference > 12, "{first} {a:?} and {second} {b:?}");
            }
        }
    }

    #[test]
    fn colours_far_down_the_line_are_still_bright() {
        for index in [1_000, 1_000_000, usize::MAX] {
            let brightest = srgb(index).into_iter().max();
            assert!(brightest > Some(120), "{index}");
        }
    }
}
