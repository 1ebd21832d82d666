//! From scene-linear light to what a screen shows.
//!
//! Exposure first, then a curve that fits bright light into what a screen can
//! show, then the sRGB transfer function, rounded to 8 or 16 bits. Files that
//! hold light (EXR, HDR, PFM) never pass through here.
//!
//! Source: IEC 61966-2-1 (sRGB); Narkowicz, "ACES Filmic Tone Mapping Curve", 2016.

use rutilant_geom::real;

/// How light is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Display {
    /// In stops: each doubles the light.
    pub exposure: f32,
    /// How bright light is made to fit.
    pub curve: Curve,
}

/// How light beyond what a screen can show is made to fit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Curve {
    /// Not at all: what is brighter than 1 is 1.
    #[default]
    Clip,
    /// A filmic curve with a soft shoulder and deeper darks.
    Filmic,
}

impl Display {
    /// The sRGB bytes for a scene-linear colour. What is no number shows as black.
    pub fn encode(&self, rgb: [f32; 3]) -> [u8; 3] {
        // `as` saturates, and turns NaN into 0.
        self.shown(rgb).map(|c| (255.0 * c + 0.5) as u8)
    }

    /// The same in 16 bits, 0 to 65535: for pictures that are to be edited further.
    pub fn encode_16(&self, rgb: [f32; 3]) -> [u16; 3] {
        self.shown(rgb).map(|c| (65535.0 * c + 0.5) as u16)
    }

    /// Encoded as sRGB, 0 to 1.
    fn shown(&self, rgb: [f32; 3]) -> [f32; 3] {
        let gain = real::exp2(self.exposure);
        rgb.map(|c| srgb_from_linear(self.curve.apply(c * gain)))
    }
}

impl Curve {
    /// What of scene-linear light is shown, 0 to 1.
    fn apply(self, light: f32) -> f32 {
        // Also sends NaN to 0.
        let light = light.max(0.0);
        match self {
            Self::Clip => light.min(1.0),
            // Beyond a few hundred the quotient is the limit, and its terms overflow.
            Self::Filmic => {
                let x = light.min(1e6);
                (x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)).min(1.0)
            }
        }
    }
}

/// The sRGB transfer function: linear 0 to 1 to encoded 0 to 1.
pub fn srgb_from_linear(linear: f32) -> f32 {
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * real::pow(linear, 1.0 / 2.4) - 0.055
    }
}

/// Its inverse: encoded 0 to 1 to linear 0 to 1.
///
/// In double precision, so that the light of an 8- or 16-bit code, `code / 255` or
/// `code / 65535`, is the nearest single-precision number once it is rounded to that.
/// `libm` is plain arithmetic: the same bits on every machine.
pub fn linear_from_srgb(encoded: f64) -> f64 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAIN: Display = Display { exposure: 0.0, curve: Curve::Clip };

    /// Grey 0.18 is 118 on screen; the old program's square root and hidden factor 1.5 made it 133.
    #[test]
    fn middle_grey_is_118() {
        assert_eq!(PLAIN.encode([0.18; 3]), [118; 3]);
        assert_eq!(PLAIN.encode([0.0, 1.0, 7.0]), [0, 255, 255]);
        assert_eq!(Display { exposure: 1.0, ..PLAIN }.encode([0.09; 3]), [118; 3]);
    }

    /// One pixel that is no number must not shine: the old program showed NaN as white.
    #[test]
    fn what_is_no_number_is_black() {
        for curve in [Curve::Clip, Curve::Filmic] {
            let display = Display { curve, ..PLAIN };
            assert_eq!(display.encode([f32::NAN, f32::NEG_INFINITY, -1.0]), [0; 3]);
            assert_eq!(display.encode([f32::INFINITY; 3]), [255; 3]);
            assert_eq!(display.encode_16([f32::NAN, -1.0, f32::INFINITY]), [0, 0, 65535]);
        }
    }

    /// More light never shows darker, over all half-precision values.
    #[test]
    fn brighter_light_is_never_darker() {
        for curve in [Curve::Clip, Curve::Filmic] {
            let display = Display { curve, ..PLAIN };
            let mut last = 0;
            for half in 0..0x7c00_u32 {
                // A positive half in single precision: exponent and mantissa moved over.
                let value = f32::from_bits(half << 13) * f32::from_bits(0x7780_0000);
                let [shown, ..] = display.encode([value; 3]);
                assert!(shown >= last, "{curve:?} {value}");
                last = shown;
            }
            assert_eq!(last, 255);
        }
    }

    /// All 256 bytes, and all 65536 words, survive decoding and encoding.
    #[test]
    fn codes_survive_the_round_trip() {
        for byte in 0..=255_u8 {
            let linear = linear_from_srgb(f64::from(byte) / 255.0) as f32;
            assert_eq!(PLAIN.encode([linear; 3]), [byte; 3]);
        }
        for word in 0..=u16::MAX {
            let linear = linear_from_srgb(f64::from(word) / 65535.0) as f32;
            assert_eq!(PLAIN.encode_16([linear; 3]), [word; 3]);
        }
    }

    /// The standard's own formula, with the power taken another way: x^2.4 is x² times the fifth
    /// root of x². A table, or single precision on the way, would be off by more.
    #[test]
    fn codes_decode_as_the_standard_says() {
        // Newton's method from above; 16 steps are enough for all of 0.008 to 1.
        let fifth_root =
            |a: f64| (0..16).fold(1.0, |y: f64, _| (4.0 * y + a / (y * y * y * y)) / 5.0);
        for code in 0..=u16::MAX {
            let encoded = f64::from(code) / f64::from(u16::MAX);
            let expected = if encoded <= 0.04045 {
                encoded / 12.92
            } else {
                let square = ((encoded + 0.055) / 1.055) * ((encoded + 0.055) / 1.055);
                square * fifth_root(square)
            };
            assert!((linear_from_srgb(encoded) - expected).abs() <= 1e-14 * expected, "{code}");
        }
        assert_eq!((linear_from_srgb(0.0), linear_from_srgb(1.0)), (0.0, 1.0));
    }
}
