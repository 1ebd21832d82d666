//! Colours for numbers: black, violet, orange, pale yellow, as a glowing body might show them.
//!
//! Lightness grows evenly, so that the map reads the same in print and to the colour-blind.
//!
//! Source: "magma" by Stéfan van der Walt and Nathaniel Smith, 2015, dedicated
//! to the public domain (CC0); here 17 of its colours with straight lines
//! between them, which is never more than 0.011 off.

use crate::display::linear_from_srgb;

/// sRGB bytes at 0, 1/16, …, 1.
const MAGMA: [[u8; 3]; 17] = [
    [0, 0, 4],
    [10, 8, 34],
    [29, 17, 70],
    [54, 16, 106],
    [80, 18, 124],
    [105, 28, 129],
    [130, 38, 129],
    [156, 46, 127],
    [182, 55, 121],
    [207, 65, 112],
    [230, 81, 99],
    [245, 105, 92],
    [251, 135, 97],
    [254, 165, 113],
    [254, 195, 135],
    [253, 224, 162],
    [252, 253, 191],
];

/// The colour of a value from 0 to 1 (others are clamped, NaN is 0), as linear
/// light from 0 to 1.
pub fn magma(value: f32) -> [f32; 3] {
    let at = value.clamp(0.0, 1.0).max(0.0) * (MAGMA.len() - 1) as f32;
    let (low, part) = (at as usize, at.fract());
    let high = (low + 1).min(MAGMA.len() - 1);
    [0, 1, 2].map(|i| {
        let (a, b) = (f32::from(MAGMA[low][i]), f32::from(MAGMA[high][i]));
        linear_from_srgb(f64::from(a + (b - a) * part) / 255.0) as f32
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// More is lighter, from nearly black to nearly white.
    #[test]
    fn luminance_rises_with_the_value() {
        let luminance = |v: f32| {
            let [r, g, b] = magma(v);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        let all: Vec<f32> = (0..=256).map(|i| luminance(i as f32 / 256.0)).collect();
        assert!(all.windows(2).all(|w| w[0] < w[1]), "{all:?}");
        assert!(all[0] < 0.001 && all[256] > 0.9);
    }

    /// Out of range and NaN are colours as well.
    #[test]
    fn any_number_has_a_colour() {
        assert_eq!(magma(-1.0), magma(0.0));
        assert_eq!(magma(f32::NAN), magma(0.0));
        assert_eq!(magma(7.0), magma(1.0));
    }
}
