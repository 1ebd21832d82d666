//! From scene-linear light to what a screen shows.
//!
//! Exposure first, then a curve that fits bright light into what a screen can
//! show, then the sRGB transfer function, rounded to 8 or 16 bits. Files that
//! hold light (EXR, HDR, PFM) never pass through here.
//!
//! All curves keep grey grey, to the last bit, and black black; more light of a
//! grey never shows darker.
//!
//! Source: IEC 61966-2-1 (sRGB); the curves name theirs.

use rutilant_geom::real;
use std::sync::LazyLock;

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
    /// Not at all: what is brighter than 1 is 1, everything below is exact. For comparing
    /// pictures, and for scenes that are lit to fit.
    #[default]
    Clip,
    /// Each channel over a curve with a soft shoulder and deeper darks: contrast, with colours
    /// that shift where they are bright. For a look like film, quickly.
    Filmic,
    /// Luminance compressed, colour kept: nothing shifts, and a luminance of 8 is white. For
    /// plain pictures of scenes with some highlights.
    Reinhard,
    /// The reference look of the Academy's system: strong contrast, bright colours turn towards
    /// white. For pictures that stand beside film; darker than the others, so often with half a
    /// stop of exposure.
    Aces,
    /// Sixteen stops in a gentle curve that bleaches colours on their way to white: lamps and
    /// fire keep their form. Grey 0.18 stays as it is. For bright scenes of all kinds.
    Agx,
}

impl Curve {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Clip, Self::Filmic, Self::Reinhard, Self::Aces, Self::Agx];

    /// What of scene-linear light is shown, each channel 0 to 1.
    fn apply(self, light: [f32; 3]) -> [f32; 3] {
        // Beyond a million every curve has long reached white, and the terms of some would overflow.
        let light = light.map(|c| if c > 0.0 { c.min(BRIGHTEST) } else { 0.0 });
        let shown = match self {
            Self::Clip => light,
            Self::Filmic => light.map(filmic),
            Self::Reinhard => reinhard(light),
            Self::Aces => ACES_OUTPUT.apply(ACES_INPUT.apply(light).map(aces_fit)),
            Self::Agx => {
                let encoded = AGX_INSET.apply(light).map(agx_sigmoid);
                let outset = AGX_OUTSET.apply(encoded);
                outset.map(|c| real::pow(c.clamp(0.0, 1.0), AGX_POWER))
            }
        };
        shown.map(|c| c.clamp(0.0, 1.0))
    }
}

const BRIGHTEST: f32 = 1e6;

impl Display {
    /// The sRGB bytes for a scene-linear colour. What is no number shows as black.
    pub fn encode(&self, rgb: [f32; 3]) -> [u8; 3] {
        self.lit(rgb).map(byte_from_linear)
    }

    /// The same in 16 bits, 0 to 65535: for pictures that are to be edited further.
    pub fn encode_16(&self, rgb: [f32; 3]) -> [u16; 3] {
        self.lit(rgb).map(|c| (65535.0 * srgb_from_linear(c) + 0.5) as u16)
    }

    /// What of it is shown, linear, 0 to 1.
    fn lit(&self, rgb: [f32; 3]) -> [f32; 3] {
        let gain = real::exp2(self.exposure);
        self.curve.apply(rgb.map(|c| c * gain))
    }
}

/// The byte for linear light from 0 to 1: 255 times its sRGB encoding, rounded. Looked up, because a
/// window shows millions of pixels a second.
fn byte_from_linear(linear: f32) -> u8 {
    /// Parts of an octave: each holds at most one step from a byte to the next.
    const PARTS: u32 = 7;
    /// What is darker than this is 0.
    const DARKEST: f32 = 1.0 / 8192.0;
    const FIRST: u32 = DARKEST.to_bits() >> (23 - PARTS);
    const COUNT: usize = ((1.0_f32.to_bits() >> (23 - PARTS)) - FIRST + 1) as usize;
    struct Table {
        /// The byte at the beginning of each part.
        begins: [u8; COUNT],
        /// The least light of each byte, and one that there is not beyond the last.
        least: [f32; 257],
    }
    static TABLE: LazyLock<Table> = LazyLock::new(|| {
        let byte = |linear: f32| (255.0 * srgb_from_linear(linear) + 0.5) as u8;
        // Floats from 0 to 1 are ordered as their bits are.
        let least = |code: u8| {
            let (mut low, mut high) = (0.0_f32.to_bits(), 1.0_f32.to_bits());
            while low < high {
                let middle = low.midpoint(high);
                if byte(f32::from_bits(middle)) < code { low = middle + 1 } else { high = middle }
            }
            f32::from_bits(low)
        };
        Table {
            begins: std::array::from_fn(|i| {
                byte(f32::from_bits((FIRST + i as u32) << (23 - PARTS)))
            }),
            least: std::array::from_fn(|c| u8::try_from(c).map_or(f32::INFINITY, least)),
        }
    });
    if linear.is_nan() || linear < DARKEST {
        return 0;
    }
    let Table { begins, least } = &*TABLE;
    let part = (linear.min(1.0).to_bits() >> (23 - PARTS)) - FIRST;
    let byte = begins[part as usize];
    byte + u8::from(linear >= least[usize::from(byte) + 1])
}

/// Source: Narkowicz, "ACES Filmic Tone Mapping Curve", 2016.
fn filmic(x: f32) -> f32 {
    x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)
}

/// The extended operator on luminance, L (1 + L / white²) / (1 + L); colours are scaled along.
///
/// Source: Reinhard et al., "Photographic Tone Reproduction for Digital Images", SIGGRAPH 2002,
/// eq. 4.
fn reinhard(rgb: [f32; 3]) -> [f32; 3] {
    /// The least luminance that is white: three stops above a white wall.
    const WHITE: f32 = 8.0;
    let [r, g, b] = rgb;
    // Rec. 709. Written so that a grey's luminance is that grey, to the last bit.
    let luminance = g + 0.2126 * (r - g) + 0.0722 * (b - g);
    let scale = (1.0 + luminance / (WHITE * WHITE)) / (1.0 + luminance);
    rgb.map(|c| c * scale)
}

/// A 3×3 matrix whose rows add up to 1, by what lies off its diagonal: row by row, (red from
/// green, red from blue), (green from red, green from blue), (blue from red, blue from green).
/// Written as differences from the diagonal, it maps a grey to the same grey, to the last bit.
struct Mixing([[f32; 2]; 3]);

impl Mixing {
    fn apply(&self, [r, g, b]: [f32; 3]) -> [f32; 3] {
        let [red, green, blue] = self.0;
        [
            r + red[0] * (g - r) + red[1] * (b - r),
            g + green[0] * (r - g) + green[1] * (b - g),
            b + blue[0] * (r - b) + blue[1] * (g - b),
        ]
    }
}

// The fit of ACES 1.0 (reference rendering transform and that for sRGB displays) by Stephen Hill,
// 2015: into a space near its rendering primaries with a little less saturation, over a rational
// curve, and back.
const ACES_INPUT: Mixing =
    Mixing([[0.354_58, 0.048_23], [0.076_00, 0.015_66], [0.028_40, 0.133_83]]);
const ACES_OUTPUT: Mixing =
    Mixing([[-0.531_08, -0.073_67], [-0.102_08, -0.006_05], [-0.003_27, -0.072_76]]);

fn aces_fit(x: f32) -> f32 {
    (x * (x + 0.024_578_6) - 0.000_090_537) / (x * (0.983_729 * x + 0.432_951) + 0.238_081)
}

// AgX: Troy Sobotka, 2022. Colours are drawn towards grey, so that the curve does not pin them to
// the edge of what can be shown; each channel goes over a sigmoid of its logarithm; then colours
// are drawn out again. Inset for Rec. 709 and outset, its inverse, as in Benjamin Wrensch,
// "Minimal AgX Implementation", 2023.
const AGX_INSET: Mixing = Mixing([
    [0.078_433_6, 0.079_223_745],
    [0.042_328_242, 0.079_166_13],
    [0.042_375_655, 0.078_433_6],
]);
const AGX_OUTSET: Mixing = Mixing([
    [-0.098_020_88, -0.099_029_74],
    [-0.052_896_85, -0.098_961_18],
    [-0.052_971_636, -0.098_043_45],
]);

/// What the sigmoid gives is light to the power of 1 / 2.4.
const AGX_POWER: f32 = 2.4;

/// Over stops from −10 to 6.5 around grey 0.18, both mapped to 0 to 1: a straight line of slope
/// 2.4 through grey, bent to the corners (0, 0) and (1, 1) by x / (1 + x^1.5)^(2/3) on both sides.
/// Slope and powers are those of Eary Chow's AgX for Blender, 2023.
fn agx_sigmoid(light: f32) -> f32 {
    const GREY: f32 = 0.18;
    const STOPS: [f32; 2] = [-10.0, 6.5];
    const SLOPE: f32 = 2.4;
    /// Grey before and after the curve: 10 / 16.5, and 0.18 to the power of 1 / 2.4.
    const PIVOT: [f32; 2] = [0.606_060_6, 0.489_437_1];
    /// How high the bend reaches above and below grey, such that the corners are met.
    const SHOULDER: f32 = 0.715_198_3;
    const TOE: f32 = 0.565_675_6;

    // Zero has no logarithm; what is as dark as this is black.
    let stops = real::log2(light.max(1e-6) / GREY).clamp(STOPS[0], STOPS[1]);
    let x = (stops - STOPS[0]) / (STOPS[1] - STOPS[0]);
    let rise = SLOPE * (x - PIVOT[0]);
    let height = if rise >= 0.0 { SHOULDER } else { TOE };
    let t = rise.abs() / height;
    PIVOT[1] + rise / real::pow(1.0 + t * t.sqrt(), 2.0 / 3.0)
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

    /// Looked up or computed, bytes are the same: at every step from one to the next and for a
    /// thousand numbers on both sides of it, in the middle of every part of the table, and beyond
    /// both ends.
    #[test]
    fn bytes_are_those_of_the_transfer_function() {
        let computed = |linear: f32| (255.0 * srgb_from_linear(linear) + 0.5) as u8;
        let mut last = 0;
        for bits in (0..=1.0_f32.to_bits()).step_by(997) {
            let byte = byte_from_linear(f32::from_bits(bits));
            assert_eq!(byte, computed(f32::from_bits(bits)), "{}", f32::from_bits(bits));
            if byte != last {
                for near in bits - 1994..bits + 997 {
                    let linear = f32::from_bits(near).min(1.0);
                    assert_eq!(byte_from_linear(linear), computed(linear), "{linear}");
                }
            }
            last = byte;
        }
        assert_eq!(last, 255);
        for (linear, byte) in [(f32::NAN, 0), (-1.0, 0), (-0.0, 0), (1.0, 255), (2.0, 255)] {
            assert_eq!(byte_from_linear(linear), byte, "{linear}");
        }
    }

    /// All 65,536 half-precision numbers, negative ones, infinities and those that are none
    /// included, by what IEEE 754 says of their bits.
    fn halves() -> impl Iterator<Item = f32> {
        (0..=u16::MAX).map(|bits| {
            let (exponent, fraction) = (bits >> 10 & 0x1f, f32::from(bits & 0x3ff));
            let magnitude = match exponent {
                0 => fraction * f32::from_bits(0x3380_0000),
                0x1f if fraction == 0.0 => f32::INFINITY,
                0x1f => f32::NAN,
                _ => (1.0 + fraction / 1024.0) * real::exp2(f32::from(exponent) - 15.0),
            };
            if bits >> 15 == 1 { -magnitude } else { magnitude }
        })
    }

    /// One pixel that is no number must not shine: the old program showed NaN as white.
    #[test]
    fn what_is_no_number_is_black() {
        for curve in Curve::ALL {
            let display = Display { curve, ..PLAIN };
            assert_eq!(display.encode([f32::NAN, f32::NEG_INFINITY, -1.0]), [0; 3], "{curve:?}");
            assert_eq!(display.encode([f32::INFINITY; 3]), [255; 3], "{curve:?}");
            assert_eq!(display.encode([0.0; 3]), [0; 3], "{curve:?}");
            assert_eq!(display.encode_16([f32::NAN, f32::NEG_INFINITY, -1.0]), [0; 3], "{curve:?}");
            assert_eq!(display.encode_16([f32::INFINITY; 3]), [65535; 3], "{curve:?}");
        }
    }

    /// More light never shows darker, grey stays grey to the last bit, and whatever comes in, in
    /// whatever mixture, a number between 0 and 1 goes out: over all half-precision values.
    #[test]
    fn every_curve_is_monotone_grey_and_finite_over_all_halves() {
        for curve in Curve::ALL {
            let mut last = 0.0;
            for value in halves() {
                let rising = value.is_sign_positive();
                let [r, g, b] = curve.apply([value; 3]);
                assert!(r == g && g == b, "{curve:?} of {value}: {r} {g} {b}");
                if rising && !value.is_nan() {
                    // The curves' own arithmetic is good to a few units in the last place.
                    assert!(r >= last - 3e-7, "{curve:?} {value}: {r} after {last}");
                    last = r.max(last);
                }
                for mixture in [[value, 0.0, 1.0], [0.2, value, f32::MAX], [f32::NAN, 5.0, value]] {
                    let shown = curve.apply(mixture);
                    assert!(
                        shown.iter().all(|c| (0.0..=1.0).contains(c)),
                        "{mixture:?}: {shown:?}"
                    );
                }
            }
            assert_eq!(curve.apply([65504.0; 3]), [1.0; 3], "{curve:?}");
        }
    }

    /// Bytes never fall as light rises.
    #[test]
    fn brighter_light_is_never_darker() {
        for curve in Curve::ALL {
            let display = Display { curve, ..PLAIN };
            let shown = halves().take(0x7c01).map(|value| display.encode([value; 3])[0]);
            let shown: Vec<u8> = shown.collect();
            assert!(shown.is_sorted(), "{curve:?}");
            assert_eq!((shown[0], shown[0x7c00]), (0, 255), "{curve:?}");
        }
    }

    /// The examples in docs/conventions.md are true.
    #[test]
    fn documented_examples_are_true() {
        let docs = include_str!("../../../docs/conventions.md");
        let (_, table) = docs.split_once("| Light | Exposure | Curve | Byte |").expect("a table");
        let rows = table.lines().skip(2).take_while(|line| line.starts_with('|'));
        let mut count = 0;
        for row in rows {
            let cells: Vec<&str> = row.split('|').map(str::trim).collect();
            let [_, light, exposure, curve, byte, ..] = cells[..] else { panic!("{row}") };
            let name = |c: &Curve| format!("{c:?}").to_lowercase() == curve;
            let curve = Curve::ALL.into_iter().find(name).expect(row);
            let display = Display { exposure: exposure.parse().expect(row), curve };
            let byte: u8 = byte.parse().expect(row);
            assert_eq!(display.encode([light.parse().expect(row); 3]), [byte; 3], "{row}");
            count += 1;
        }
        assert_eq!(count, 10);
    }

    /// The curves go where their definitions, written out in f64 with the full matrices, say.
    #[test]
    #[expect(clippy::disallowed_methods, reason = "expected values are computed in f64")]
    fn curves_have_the_values_of_their_definitions() {
        let times = |m: [[f64; 3]; 3], v: [f64; 3]| {
            m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
        };
        let aces = |v: [f64; 3]| {
            let v = times(
                [
                    [0.59719, 0.35458, 0.04823],
                    [0.076, 0.90834, 0.01566],
                    [0.0284, 0.13383, 0.83777],
                ],
                v,
            );
            let v = v.map(|x| {
                (x * (x + 0.0245786) - 0.000090537) / (x * (0.983729 * x + 0.432951) + 0.238081)
            });
            times(
                [
                    [1.60475, -0.53108, -0.07367],
                    [-0.10208, 1.10813, -0.00605],
                    [-0.00327, -0.07276, 1.07602],
                ],
                v,
            )
        };
        // Each side of the sigmoid on its own: s such that slope X / (1 + (slope X / s)^p)^(1/p) = Y.
        let agx = |v: [f64; 3]| {
            let inset = [
                [0.842479062253094, 0.0784335999999992, 0.0792237451477643],
                [0.0423282422610123, 0.878468636469772, 0.0791661274605434],
                [0.0423756549057051, 0.0784336, 0.879142973793104],
            ];
            let (slope, p, grey_in, grey_out) = (2.4, 1.5, 10.0 / 16.5, 0.18_f64.powf(1.0 / 2.4));
            let curve = |x: f64| {
                let x = ((x / 0.18).log2().clamp(-10.0, 6.5) + 10.0) / 16.5;
                let (sign, far, high) = if x > grey_in {
                    (1.0, 1.0 - grey_in, 1.0 - grey_out)
                } else {
                    (-1.0, grey_in, grey_out)
                };
                let s = slope * far / ((slope * far / high).powf(p) - 1.0).powf(1.0 / p);
                let t = slope * (x - grey_in).abs();
                grey_out + sign * t / (1.0 + (t / s).powf(p)).powf(1.0 / p)
            };
            let outset = [
                [1.19687900512017, -0.0980208811401368, -0.0990297440797205],
                [-0.0528968517574562, 1.15190312990417, -0.0989611768448433],
                [-0.0529716355144438, -0.0980434501171241, 1.15107367264116],
            ];
            times(outset, times(inset, v).map(curve)).map(|c| c.clamp(0.0, 1.0).powf(2.4))
        };
        let reinhard = |v: [f64; 3]| {
            let l = 0.2126 * v[0] + 0.7152 * v[1] + 0.0722 * v[2];
            v.map(|c| c * (l * (1.0 + l / 64.0) / (1.0 + l)) / l)
        };
        for rgb in
            [[0.18; 3], [1.0, 0.5, 0.1], [0.01, 0.02, 0.9], [4.0, 3.0, 0.5], [30.0, 1.0, 2.0]]
        {
            let wide = rgb.map(f64::from);
            let cases = [
                (Curve::Reinhard, reinhard(wide)),
                (Curve::Aces, aces(wide)),
                (Curve::Agx, agx(wide)),
            ];
            for (curve, expected) in cases {
                for (got, expected) in curve.apply(rgb).into_iter().zip(expected) {
                    let expected = expected.clamp(0.0, 1.0);
                    // The published matrices' rows add up to 1 to four digits only.
                    assert!(
                        (f64::from(got) - expected).abs() < 5e-4,
                        "{curve:?} {rgb:?}: {got} {expected}"
                    );
                }
            }
        }
        // What people look for: middle grey, and where white is.
        assert_eq!(Display { curve: Curve::Agx, ..PLAIN }.encode([0.18; 3]), [118; 3]);
        assert_eq!(Display { curve: Curve::Reinhard, ..PLAIN }.encode([8.0; 3]), [255; 3]);
        for (light, end) in [(0.18 * 90.6, 1.0), (0.0, 0.0), (0.18, 0.489_437_1)] {
            assert!((agx_sigmoid(light) - end).abs() < 1e-6, "{light}: {}", agx_sigmoid(light));
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
