//! Colours for hulls, in GLB files and pictures: as many as wanted, each unlike the ones before
//! it, always the same.

/// A colour in sRGB, 8 bits per channel.
pub type Colour = [u8; 3];

/// The neutral colour of a source mesh: warm grey, like unfired clay.
pub const CLAY: Colour = [201, 196, 188];

/// The colour of caps that close openings: a warm red that no clay has.
pub const CAP: Colour = [214, 92, 66];

/// The colour of what a probe does not reach: water, which lies in no palette of clay.
pub const FILLED: Colour = [58, 134, 200];

/// The colour of a ball as large as the probe: brass, which is seen before water and clay.
pub const BALL: Colour = [240, 190, 90];

/// The golden angle in degrees: multiples of it stay as far from each other as they can, however
/// many there are.
const GOLDEN_ANGLE: f64 = 137.507_764_050_037_85;

/// The first hue, a blue that differs from most people's idea of an error.
const FIRST_HUE: f64 = 250.0;

/// OKLCH lightness and chroma, taken in turn: hulls whose hues come close still differ. Four, since
/// hues come back after 21, 34, 55 and 89 hulls, none of them a multiple of 4. All are
/// light enough for shading to stay readable and dark enough to stand out from a light background.
const TONES: [(f64, f64); 4] = [(0.74, 0.125), (0.66, 0.135), (0.82, 0.105), (0.62, 0.13)];

/// Step by which chroma is lowered until a colour exists in sRGB.
const CHROMA_STEP: f64 = 0.005;

/// The colour of hull or group number `index`. Deterministic, and O(1).
pub fn colour(index: usize) -> Colour {
    let (lightness, mut chroma) = TONES[index % TONES.len()];
    let hue = (FIRST_HUE + GOLDEN_ANGLE * index as f64).rem_euclid(360.0);
    loop {
        let rgb = oklch_to_linear(lightness, chroma, hue);
        if chroma <= 0.0 || rgb.iter().all(|channel| (0.0..=1.0).contains(channel)) {
            return rgb.map(encode);
        }
        chroma -= CHROMA_STEP;
    }
}

/// A colour's channels in linear light, 0 to 1, as glTF has them.
pub fn linear(colour: Colour) -> [f32; 3] {
    colour.map(decode)
}

/// Linear light, 0 to 1, of an sRGB channel.
fn decode(channel: u8) -> f32 {
    let value = f64::from(channel) / 255.0;
    let light = if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) };
    light as f32
}

/// The sRGB channel of linear light, 0 to 1; what is out of range is clamped.
pub fn encode(light: f64) -> u8 {
    let light = light.clamp(0.0, 1.0);
    let value =
        if light <= 0.003_130_8 { light * 12.92 } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 };
    (value * 255.0).round() as u8
}

/// Björn Ottosson's OKLab, in its polar form, to linear sRGB (bottosson.github.io/posts/oklab).
fn oklch_to_linear(lightness: f64, chroma: f64, hue: f64) -> [f64; 3] {
    let (sine, cosine) = hue.to_radians().sin_cos();
    let (a, b) = (chroma * cosine, chroma * sine);
    let l = (lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
    let m = (lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
    let s = (lightness - 0.089_484_177_5 * a - 1.291_485_548 * b).powi(3);
    [
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701 * s,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_hundred_colours_are_all_different() {
        let mut colours: Vec<Colour> = (0..100).map(colour).collect();
        colours.sort_unstable();
        colours.dedup();
        assert_eq!(colours.len(), 100);
    }

    #[test]
    fn any_two_of_forty_hulls_look_different() {
        for first in 0..40 {
            for second in 0..first {
                let (a, b) = (colour(first), colour(second));
                let difference: u32 = a.iter().zip(b).map(|(a, b)| u32::from(a.abs_diff(b))).sum();
                assert!(difference > 12, "{first} {a:?} and {second} {b:?}");
            }
        }
    }

    #[test]
    fn colours_far_down_the_line_are_still_bright() {
        for index in [1_000, 1_000_000, usize::MAX] {
            let brightest = colour(index).into_iter().max();
            assert!(brightest > Some(120), "{index}");
        }
    }

    #[test]
    fn no_colour_is_near_black_or_near_white() {
        for index in 0..500 {
            let light: f32 = linear(colour(index)).iter().sum::<f32>() / 3.0;
            assert!((0.15..0.85).contains(&light), "{index}: {light}");
        }
    }

    #[test]
    fn linear_light_and_back_is_the_same_colour() {
        for channel in 0..=255 {
            assert_eq!(encode(f64::from(decode(channel))), channel);
        }
    }
}
