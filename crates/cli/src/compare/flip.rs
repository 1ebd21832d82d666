//! ꟻLIP: how strongly a viewer who flips between two pictures sees them differ.
//!
//! Both pictures are blurred as the eye blurs them at a given viewing distance,
//! and their colours are compared in a space of even steps. That difference is
//! then raised where one picture has an edge or a dot that the other has not.
//! The result is one number per pixel, from 0 (no difference) to 1 (the
//! greatest that a display can show).
//!
//! [`ldr`] compares what a display shows. [`hdr`] compares scene-linear
//! pictures: it shows both at a row of exposures and keeps the worst.
//!
//! Sources: Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild,
//! "FLIP: A Difference Evaluator for Alternating Images", Proc. ACM CGIT 3(2)
//! (HPG), 2020; Andersson, Nilsson, Shirley, Akenine-Möller, "Visualizing
//! Errors in Rendered High Dynamic Range Images", Eurographics short papers,
//! 2021. Written from the papers; agreement with the authors' program is tested
//! below.

use super::pixels::Pixels;
use super::plane::{Plane, taps};
use rayon::prelude::*;
use std::f32::consts::PI;

/// The papers' viewing conditions: a display 0.7 m wide with 3840 pixels, seen from 0.7 m.
pub(crate) const PIXELS_PER_DEGREE: f32 = 0.7 * (3840.0 / 0.7) * (PI / 180.0);

/// The difference at each pixel of two pictures on a display, 0 to 1.
///
/// Values are linear light, 0 (black) to 1 (the display's white); others are
/// clamped. Both pictures must have the same size.
pub(crate) fn ldr(reference: &Pixels, test: &Pixels, pixels_per_degree: f32) -> Vec<f32> {
    let reference = Seen::new(reference, pixels_per_degree);
    let test = Seen::new(test, pixels_per_degree);

    let color = reference.color.par_iter().zip(&test.color);
    let feature = reference.feature.par_iter().zip(&test.feature);
    color
        .zip(feature)
        .map(|((&ca, &cb), (&fa, &fb))| {
            // Section 4.3: the colour difference, raised by the feature difference.
            color_difference(ca, cb).powf(1.0 - feature_difference(fa, fb))
        })
        .collect()
}

/// The difference at each pixel of two scene-linear pictures, 0 to 1: the
/// greatest [`ldr`] difference over all exposures at which the reference shows something.
pub(crate) fn hdr(reference: &Pixels, test: &Pixels, pixels_per_degree: f32) -> Vec<f32> {
    let exposures = exposures(reference);
    let mut worst = vec![0.0_f32; reference.values.len()];
    for exposure in exposures {
        let shown = |p: &Pixels| p.map(|rgb| rgb.map(|c| tone_map(c * exposure.exp2())));
        let here = ldr(&shown(reference), &shown(test), pixels_per_degree);
        worst.par_iter_mut().zip(here).for_each(|(w, h)| *w = w.max(h));
    }
    worst
}

/// What the eye makes of a picture.
struct Seen {
    /// Hunt-adjusted L*a*b* of the blurred picture.
    color: Vec<[f32; 3]>,
    /// Strength of edges and of points.
    feature: Vec<[f32; 2]>,
}

impl Seen {
    fn new(picture: &Pixels, pixels_per_degree: f32) -> Self {
        let (width, opponent) = (picture.width, picture.map(|rgb| ycc(rgb.map(clamp_unit))));
        let plane = |i: usize| Plane {
            width,
            values: opponent.values.iter().map(|p| p[i]).collect::<Vec<_>>(),
        };
        let [y, cx, cz] = [plane(0), plane(1), plane(2)];

        let [sy, sx, sz] = contrast_sensitivity(pixels_per_degree);
        let (by, bx, bz) = (blurred(&y, &sy), blurred(&cx, &sx), blurred(&cz, &sz));
        let color = (by.values.par_iter().zip(bx.values).zip(bz.values))
            .map(|((&y, cx), cz)| hunt_lab(rgb_of_ycc([y, cx, cz]).map(clamp_unit)))
            .collect();

        // Features are found in achromatic values from 0 to 1 (section 4.2).
        let y = Plane { width, values: y.values.iter().map(|y| (y + 16.0) / 116.0).collect() };
        let Detector { smooth, edge, point } = Detector::new(pixels_per_degree);
        let strength = |kernel: &[f32]| {
            let (dx, dy) = (y.convolved(kernel, &smooth), y.convolved(&smooth, kernel));
            (dx.values.into_par_iter().zip(dy.values)).map(|(x, y)| x.hypot(y)).collect::<Vec<_>>()
        };
        let feature =
            strength(&edge).into_iter().zip(strength(&point)).map(|(e, p)| [e, p]).collect();
        Self { color, feature }
    }
}

// ---- colour (section 4.1) ----

/// The colour difference of two Hunt-adjusted L*a*b* colours, 0 to 1.
fn color_difference(a: [f32; 3], b: [f32; 3]) -> f32 {
    /// The exponent that evens out large differences.
    const QC: f32 = 0.7;
    /// Differences up to this part of the greatest …
    const PC: f32 = 0.4;
    /// … take this part of the result's range.
    const PT: f32 = 0.95;
    // The greatest difference in the display's gamut is between its green and its blue.
    let greatest = hyab(hunt_lab([0.0, 1.0, 0.0]), hunt_lab([0.0, 0.0, 1.0])).powf(QC);
    let difference = hyab(a, b).powf(QC);
    let knee = PC * greatest;
    if difference < knee {
        PT / knee * difference
    } else {
        PT + (difference - knee) / (greatest - knee) * (1.0 - PT)
    }
}

/// HyAB distance: Abasi, Amani Tehran, Fairchild, "Distance metrics for very
/// large color differences", Color Research & Application 45(2), 2020.
fn hyab(a: [f32; 3], b: [f32; 3]) -> f32 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

/// L*a*b* of a linear colour, its chroma scaled by its lightness: the duller
/// the light, the less colour is seen in it (Hunt).
fn hunt_lab(rgb: [f32; 3]) -> [f32; 3] {
    let f = |t: f32| {
        const DELTA: f32 = 6.0 / 29.0;
        if t > DELTA * DELTA * DELTA { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    };
    let [x, y, z] = relative_xyz(rgb).map(f);
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
}

/// Linear sRGB to CIE XYZ (IEC 61966-2-1).
const XYZ_OF_RGB: [[f32; 3]; 3] = [
    [0.412_390_8, 0.357_584_34, 0.180_480_79],
    [0.212_639_01, 0.715_168_68, 0.072_192_315],
    [0.019_330_818, 0.119_194_78, 0.950_532_15],
];

/// The inverse.
const RGB_OF_XYZ: [[f32; 3]; 3] = [
    [3.240_97, -1.537_383_2, -0.498_610_76],
    [-0.969_243_64, 1.875_967_5, 0.041_555_06],
    [0.055_630_08, -0.203_976_96, 1.056_971_5],
];

fn times(m: &[[f32; 3]; 3], v: [f32; 3]) -> [f32; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// The display's white in XYZ.
fn white() -> [f32; 3] {
    times(&XYZ_OF_RGB, [1.0; 3])
}

/// XYZ in parts of white.
fn relative_xyz(rgb: [f32; 3]) -> [f32; 3] {
    let (xyz, white) = (times(&XYZ_OF_RGB, rgb), white());
    [0, 1, 2].map(|i| xyz[i] / white[i])
}

/// YyCxCz: a linear opponent space (achromatic, red–green, blue–yellow).
fn ycc(rgb: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = relative_xyz(rgb);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Back from YyCxCz.
fn rgb_of_ycc([yy, cx, cz]: [f32; 3]) -> [f32; 3] {
    let y = (yy + 16.0) / 116.0;
    let (relative, white) = ([y + cx / 500.0, y, y - cz / 200.0], white());
    times(&RGB_OF_XYZ, [0, 1, 2].map(|i| relative[i] * white[i]))
}

/// NaN becomes 0.
fn clamp_unit(x: f32) -> f32 {
    x.clamp(0.0, 1.0).max(0.0)
}

/// A sum of separable kernels, all weights together 1: factor and shape.
type Blur = Vec<(f32, Vec<f32>)>;

/// The contrast sensitivity of the eye as blurs of Yy, Cx and Cz, each a sum of
/// two Gaussians `a √(π/b) exp(−π² x²/b)` of the visual angle x in degrees (table 1).
fn contrast_sensitivity(pixels_per_degree: f32) -> [Blur; 3] {
    const ACHROMATIC: [(f32, f32); 1] = [(1.0, 0.0047)];
    const RED_GREEN: [(f32, f32); 1] = [(1.0, 0.0053)];
    const BLUE_YELLOW: [(f32, f32); 2] = [(34.1, 0.04), (13.5, 0.025)];
    // Three standard deviations of the widest: σ² = b / (2π²).
    let radius = (3.0 * (0.04 / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil();
    let blur = |gaussians: &[(f32, f32)]| -> Blur {
        let mut terms: Blur = gaussians
            .iter()
            .map(|&(a, b)| {
                let shape = taps(radius, |x| (-(PI * x / pixels_per_degree).powi(2) / b).exp());
                (a * (PI / b).sqrt(), shape)
            })
            .collect();
        let all: f32 = terms.iter().map(|(a, shape)| a * shape.iter().sum::<f32>().powi(2)).sum();
        terms.iter_mut().for_each(|(a, _)| *a /= all);
        terms
    };
    [blur(&ACHROMATIC), blur(&RED_GREEN), blur(&BLUE_YELLOW)]
}

/// The sum of all separable terms of `blur`.
fn blurred(plane: &Plane, blur: &Blur) -> Plane {
    let mut sum = vec![0.0; plane.values.len()];
    for (factor, shape) in blur {
        let term = plane.convolved(shape, shape);
        sum.iter_mut().zip(term.values).for_each(|(s, t)| *s += factor * t);
    }
    Plane { width: plane.width, values: sum }
}

// ---- features (section 4.2) ----

/// How much two (edge, point) strengths differ, 0 to 1.
fn feature_difference(a: [f32; 2], b: [f32; 2]) -> f32 {
    /// The exponent that raises small differences.
    const QF: f32 = 0.5;
    let most = (a[0] - b[0]).abs().max((a[1] - b[1]).abs());
    (most * std::f32::consts::FRAC_1_SQRT_2).powf(QF).min(1.0)
}

/// Derivatives of a Gaussian along one axis, and the Gaussian across it.
struct Detector {
    smooth: Vec<f32>,
    /// First derivative: its positive weights sum to 1, its negative ones to −1.
    edge: Vec<f32>,
    /// Second derivative, in the same way.
    point: Vec<f32>,
}

impl Detector {
    fn new(pixels_per_degree: f32) -> Self {
        /// The width of the smallest edge that the eye finds, in degrees.
        const EDGE_WIDTH: f32 = 0.082;
        let sigma = 0.5 * EDGE_WIDTH * pixels_per_degree;
        let radius = (3.0 * sigma).ceil();
        let gaussian = |x: f32| (-x * x / (2.0 * sigma * sigma)).exp();
        let mut smooth = taps(radius, gaussian);
        let sum: f32 = smooth.iter().sum();
        smooth.iter_mut().for_each(|w| *w /= sum);
        let balanced = |mut taps: Vec<f32>| {
            let positive: f32 = taps.iter().filter(|w| **w > 0.0).sum();
            let negative: f32 = taps.iter().filter(|w| **w < 0.0).map(|w| -w).sum();
            for w in &mut taps {
                *w /= if *w > 0.0 { positive } else { negative };
            }
            taps
        };
        Self {
            smooth,
            edge: balanced(taps(radius, |x| -x * gaussian(x))),
            point: balanced(taps(radius, |x| (x * x / (sigma * sigma) - 1.0) * gaussian(x))),
        }
    }
}

// ---- exposures (2021, section 3) ----

/// The exposures in stops at which the reference is worth looking at: from
/// where its brightest pixel is just below white to where its median is.
fn exposures(reference: &Pixels) -> Vec<f32> {
    /// The displayed value that counts as bright.
    const BRIGHT: f32 = 0.85;
    /// All normal numbers lie within 254 stops, so this only guards against mistakes above.
    const MOST_EXPOSURES: u32 = 300;
    // The value that the tone curve takes to BRIGHT: (k0 − t k3) x² + (k1 − t k4) x − t k5 = 0.
    let [k0, k1, k3, k4, k5] = CURVE;
    let (a, b, c) = (k0 - BRIGHT * k3, k1 - BRIGHT * k4, -BRIGHT * k5);
    let bright = (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a);

    // What is too dark for a normal number is black: no exposure would show it, and the way
    // there is infinite. What is too bright for a number is the greatest one.
    let luminance = |rgb: [f32; 3]| match times(&XYZ_OF_RGB, rgb)[1] {
        l if l >= f32::MIN_POSITIVE => l.min(f32::MAX),
        _ => 0.0,
    };
    let mut luminances: Vec<f32> = reference.values.iter().copied().map(luminance).collect();
    luminances.sort_unstable_by(f32::total_cmp);
    // A picture that is mostly black is judged by its lit part: its median says nothing.
    let median = match luminances[luminances.len() / 2] {
        m if m > 0.0 => m,
        _ => {
            let lit = &luminances[luminances.partition_point(|l| *l <= 0.0)..];
            lit.get(lit.len() / 2).copied().unwrap_or(1.0)
        }
    };
    let most = luminances.last().copied().filter(|m| *m > 0.0).unwrap_or(1.0);
    let (start, stop) = ((bright / most).log2(), (bright / median).log2());
    let count = ((stop - start).ceil() as u32).clamp(2, MOST_EXPOSURES);
    (0..count).map(|i| start + (stop - start) * i as f32 / (count - 1) as f32).collect()
}

/// Coefficients k0, k1, k3, k4, k5 of the rational curve (k2 is 0). Narkowicz's fit of the
/// ACES curve (2016) with its usual exposure of 0.6 multiplied in.
const CURVE: [f32; 5] = [0.36 * 2.51, 0.6 * 0.03, 0.36 * 2.43, 0.6 * 0.59, 0.14];

fn tone_map(x: f32) -> f32 {
    let [k0, k1, k3, k4, k5] = CURVE;
    let x = x.max(0.0);
    // Beyond this the curve has long reached white, and x² would overflow.
    let x = x.min(1e6);
    clamp_unit((k0 * x + k1) * x / ((k3 * x + k4) * x + k5))
}

#[cfg(test)]
mod tests {
    use super::super::testing::{checker, noise, noisy, ramp, shifted};
    use super::*;

    fn mean(map: &[f32]) -> f64 {
        map.iter().map(|v| f64::from(*v)).sum::<f64>() / map.len() as f64
    }

    const SIZE: (usize, usize) = (61, 47);

    /// Mean differences computed by the authors' own program, flip-evaluator
    /// 1.7 for Python, on the same pictures. Catches every wrong constant.
    #[test]
    fn means_agree_with_the_authors_program() {
        let hash = [noise(SIZE, 1), noise(SIZE, 2)];
        let ramp = ramp(SIZE);
        let grainy = noisy(&ramp, 3, 0.4);
        let board = checker(SIZE, 8);
        let cases = [
            ("noise", ldr(&hash[0], &hash[1], PIXELS_PER_DEGREE), 0.405_097_81),
            ("grain", ldr(&ramp, &grainy, PIXELS_PER_DEGREE), 0.189_478_90),
            ("shift", ldr(&board, &shifted(&board), PIXELS_PER_DEGREE), 0.285_415_62),
            ("board", ldr(&ramp, &checker(SIZE, 5), PIXELS_PER_DEGREE), 0.729_133_84),
            ("20 pixels per degree", ldr(&ramp, &grainy, 20.0), 0.428_993_82),
        ];
        for (name, map, expected) in cases {
            let mean = mean(&map);
            assert!((mean - expected).abs() < 1e-4, "{name}: {mean} instead of {expected}");
        }
    }

    /// The same for scene-linear pictures of values up to 20.
    #[test]
    fn hdr_means_agree_with_the_authors_program() {
        let bright = |p: &Pixels| p.map(|rgb| rgb.map(|c| c * c * 20.0));
        let ramp = ramp(SIZE);
        let cases = [
            ("grain", bright(&ramp), bright(&noisy(&ramp, 3, 0.4)), 0.275_107_86),
            ("noise", bright(&noise(SIZE, 1)), bright(&noise(SIZE, 2)), 0.464_687_41),
        ];
        for (name, reference, test, expected) in cases {
            let mean = mean(&hdr(&reference, &test, PIXELS_PER_DEGREE));
            assert!((mean - expected).abs() < 1e-4, "{name}: {mean} instead of {expected}");
        }
    }

    /// A picture does not differ from itself, and green and blue differ as much as can be.
    #[test]
    fn the_scale_runs_from_zero_to_one() {
        let ramp = ramp(SIZE);
        assert!(ldr(&ramp, &ramp, PIXELS_PER_DEGREE).iter().all(|d| *d == 0.0));
        let [green, blue] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|c| ramp.map(|_| c));
        for d in ldr(&green, &blue, PIXELS_PER_DEGREE) {
            assert!((d - 1.0).abs() < 1e-4, "{d}");
        }
    }

    /// Any finite picture is shown at a few hundred finite exposures at most. A median below
    /// the normal numbers once asked for four billion.
    #[test]
    fn exposures_are_few_and_finite() {
        for dark in [0.0, -1.0, f32::from_bits(1), 1e-41, f32::MIN_POSITIVE, 1e-30] {
            for bright in [0.0, f32::from_bits(1), 1e-41, 1.0, f32::MAX] {
                let mut picture = ramp((16, 12)).map(|_| [dark; 3]);
                picture.values[100] = [bright; 3];
                let exposures = exposures(&picture);
                assert!((2..=300).contains(&exposures.len()), "{dark} {bright}: {exposures:?}");
                // Neither 0 nor infinity as a factor.
                let sound = |stops: &f32| stops.exp2().is_normal() || stops.exp2().is_subnormal();
                assert!(exposures.iter().all(sound), "{dark} {bright}: {exposures:?}");
            }
        }
        // What is nearly nothing is nothing.
        let lamp = |dark: f32| {
            let mut picture = ramp((16, 12)).map(|_| [dark; 3]);
            picture.values[100] = [1.0; 3];
            picture
        };
        assert_eq!(exposures(&lamp(1e-41)), exposures(&lamp(0.0)));
        assert!(hdr(&lamp(1e-41), &lamp(1e-41), PIXELS_PER_DEGREE).iter().all(|d| *d == 0.0));
    }

    /// Black, tiny, one-pixel and absurdly bright pictures give numbers from 0 to 1.
    #[test]
    fn odd_pictures_give_numbers() {
        for size in [(1, 1), (3, 1), (1, 5), SIZE] {
            let ramp = ramp(size);
            for factor in [0.0, 1e-41, 1e-30, 1.0, 3e38, f32::MAX] {
                let scaled = ramp.map(|rgb| rgb.map(|c| c * factor));
                for (a, b) in [(&ramp, &scaled), (&scaled, &ramp)] {
                    for map in [ldr(a, b, PIXELS_PER_DEGREE), hdr(a, b, PIXELS_PER_DEGREE)] {
                        assert!(map.iter().all(|d| (0.0..=1.001).contains(d)), "{factor}: {map:?}");
                    }
                }
            }
        }
    }
}
