//! What the proofs share: a counter-based random sequence, a chi-square test, a furnace, and a
//! way to render small scenes to their means.

#![expect(clippy::disallowed_methods, reason = "expected values are computed in f64")]
#![allow(dead_code, reason = "each test file uses a part of this")]

use rutilant::color::Spectrum;
use rutilant::geom::{Vec2, Vec3, real};
use rutilant::image::Image;
use rutilant::sampler::{Independent, Sampler};
use rutilant::scene::Scene;
use rutilant::settings::{SamplerKind, Settings};
use rutilant::{Prepared, Session};
use std::f64::consts::PI;
use std::sync::Arc;
use std::time::Duration;

/// Number `i` of a fixed random sequence: a number and a pair, all in [0, 1).
pub fn random(stream: u64, i: u64) -> (f32, Vec2) {
    let sampler = Independent::new(stream, [0, 0], i);
    (sampler.d1(0), sampler.d2(0))
}

/// Directions `wo` over a range of angles with +z, each at a few angles around it.
pub fn directions(degrees: &[f32]) -> Vec<Vec3> {
    let around = [0.3_f32, 2.5];
    let pairs = degrees.iter().flat_map(|&d| around.map(|phi| (d, phi)));
    pairs
        .map(|(d, phi)| {
            let ((st, ct), (sp, cp)) = (real::sin_cos(d.to_radians()), real::sin_cos(phi));
            Vec3::new(st * cp, st * sp, ct)
        })
        .collect()
}

/// The probability of a chi-square value at least this large by chance alone.
///
/// The regularised upper incomplete gamma function by series and continued fraction (Abramowitz
/// and Stegun, 6.5.29 and 6.5.31).
pub fn chi_square_tail(degrees_of_freedom: f64, value: f64) -> f64 {
    let (a, x) = (0.5 * degrees_of_freedom, 0.5 * value);
    if x <= 0.0 {
        return 1.0;
    }
    let scale = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        let (mut sum, mut term, mut n) = (1.0 / a, 1.0 / a, a);
        while term > sum * 1e-15 {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        return (1.0 - sum * scale).max(0.0);
    }
    let (mut b, mut c, mut d) = (x + 1.0 - a, 1e300, 1.0 / (x + 1.0 - a));
    let mut fraction = d;
    for i in 1..10_000 {
        let n = -f64::from(i) * (f64::from(i) - a);
        b += 2.0;
        d = 1.0 / (n * d + b);
        c = b + n / c;
        fraction *= d * c;
        if (d * c - 1.0).abs() < 1e-14 {
            break;
        }
    }
    fraction * scale
}

/// Stirling's series after shifting the argument up.
fn ln_gamma(mut x: f64) -> f64 {
    let mut shift = 0.0;
    while x < 10.0 {
        shift -= x.ln();
        x += 1.0;
    }
    let i = 1.0 / (x * x);
    shift + (x - 0.5) * x.ln() - x
        + 0.5 * (2.0 * PI).ln()
        + (1.0 / 12.0 - i * (1.0 / 360.0 - i * (1.0 / 1260.0 - i / 1680.0))) / x
}

/// The level for each of `tests` independent tests at which all of them together raise a false
/// alarm with a probability of 1 % (Šidák 1967).
pub fn family_wise(tests: usize) -> f64 {
    1.0 - 0.99_f64.powf(1.0 / tests as f64)
}

/// Pearson's test that directions drawn by `sample` follow `pdf` (per sr), over the whole sphere.
/// Samples that are `None` are expected as often as the density lacks from 1.
/// Returns the p-value; panics where a direction is drawn at which the density is zero.
pub fn chi_square(
    stream: u64,
    sample: impl Fn(f32, Vec2) -> Option<Vec3>,
    pdf: impl Fn(Vec3) -> f32,
) -> f64 {
    // Odd numbers, so that cells do not end where the hemispheres do by luck.
    const ROWS: usize = 25;
    const COLUMNS: usize = 48;
    const SAMPLES: u64 = 200_000;

    // What is drawn.
    let mut counts = vec![0.0; ROWS * COLUMNS + 1];
    for i in 0..SAMPLES {
        let (choice, u) = random(stream, i);
        let cell = sample(choice, u).map_or(ROWS * COLUMNS, |d| {
            let row = ((0.5 - 0.5 * f64::from(d.z)) * ROWS as f64) as usize;
            let turn = (f64::from(d.y).atan2(f64::from(d.x)) / (2.0 * PI)).rem_euclid(1.0);
            let column = (turn * COLUMNS as f64) as usize;
            row.min(ROWS - 1) * COLUMNS + column.min(COLUMNS - 1)
        });
        counts[cell] += 1.0;
    }

    // What is expected: the density integrated over each cell, finely where it jumps.
    let over_cell = |cell: usize, steps: usize| {
        let fine =
            |i: usize, k: usize, n: usize| (i as f64 + (k as f64 + 0.5) / steps as f64) / n as f64;
        let (mut sum, mut least, mut most) = (0.0, f32::INFINITY, 0.0_f32);
        for k in 0..steps * steps {
            let z = 1.0 - 2.0 * fine(cell / COLUMNS, k / steps, ROWS);
            let r = (1.0 - z * z).sqrt();
            let (s, c) = (2.0 * PI * fine(cell % COLUMNS, k % steps, COLUMNS)).sin_cos();
            let density = pdf(Vec3::new((r * c) as f32, (r * s) as f32, z as f32));
            assert!(density >= 0.0 && density.is_finite(), "a density of {density}");
            sum += f64::from(density);
            (least, most) = (least.min(density), most.max(density));
        }
        let solid_angle = 4.0 * PI / (ROWS * COLUMNS) as f64;
        (sum / (steps * steps) as f64 * solid_angle * SAMPLES as f64, most > 1.5 * least)
    };
    let mut expected: Vec<f64> = (0..ROWS * COLUMNS)
        .map(|cell| match over_cell(cell, 12) {
            (expected, false) if expected > 0.0 || counts[cell] == 0.0 => expected,
            _ => over_cell(cell, 200).0,
        })
        .collect();
    let total: f64 = expected.iter().sum();
    assert!(total < SAMPLES as f64 * 1.005, "the density integrates to {}", total / SAMPLES as f64);
    expected.push((SAMPLES as f64 - total).max(0.0));

    // Cells with few expected samples are pooled: the statistic is normal only from five on.
    let (mut statistic, mut cells) = (0.0, 0.0);
    let (mut pooled_count, mut pooled_expected) = (0.0, 0.0);
    let mut term = |count: f64, expected: f64| {
        statistic += (count - expected) * (count - expected) / expected;
        cells += 1.0;
    };
    for (&count, &expected) in counts.iter().zip(&expected) {
        if expected >= 20.0 {
            term(count, expected);
        } else {
            pooled_count += count;
            pooled_expected += expected;
        }
    }
    if pooled_expected >= 5.0 {
        term(pooled_count, pooled_expected);
    } else {
        // Hardly any are expected; a few may have been rounded over a border of the density.
        assert!(
            pooled_count <= 60.0,
            "{pooled_count} samples where {pooled_expected} are expected"
        );
    }
    if cells > 1.0 { chi_square_tail(cells - 1.0, statistic) } else { 1.0 }
}

/// The mean of `f` over the directions of a sphere, weighted by solid angle: ∫ f dω, by stratified points.
pub fn integrate_sphere(f: impl Fn(Vec3) -> Spectrum) -> [f64; 3] {
    let n = 400;
    let mut sum = [0.0; 3];
    for i in 0..n * n {
        let (x, y) =
            ((f64::from(i % n) + 0.5) / f64::from(n), (f64::from(i / n) + 0.5) / f64::from(n));
        let z = 1.0 - 2.0 * y;
        let (s, c) = (2.0 * PI * x).sin_cos();
        let r = (1.0 - z * z).sqrt();
        let value = f(Vec3::new((r * c) as f32, (r * s) as f32, z as f32));
        for (sum, v) in sum.iter_mut().zip(value.channels()) {
            *sum += f64::from(v) * 4.0 * PI / f64::from(n * n);
        }
    }
    sum
}

/// Renders `scene` with some settings.
pub fn render(scene: &Scene, settings: Settings) -> Image {
    let prepared = Arc::new(Prepared::new(scene).expect("a sound scene"));
    let session = Session::start(prepared, settings, 2).expect("sound settings");
    while !session.wait(Duration::from_secs(3600)) {}
    assert_eq!(session.progress().dropped.count, 0, "samples were no numbers");
    session.snapshot()
}

/// Mean of a channel over the whole image, and the standard error of that mean.
pub fn mean(image: &Image, channel: &str) -> (f64, f64) {
    let values = image.channel(channel).expect("such a channel");
    let variances = image.channel(&format!("variance.{channel}")).expect("its variance");
    let n = values.len() as f64;
    let sum = |v: &[f32]| v.iter().map(|&x| f64::from(x)).sum::<f64>();
    (sum(values) / n, sum(variances).sqrt() / n)
}

/// A small picture with independent samples, as statistical tests want it.
pub fn small(spp: u64) -> Settings {
    Settings { size: [16, 16], spp, sampler: SamplerKind::Independent, ..Settings::default() }
}

/// Asserts that every channel's mean is `expected`, within `sigmas` standard errors and one part in 10⁴.
#[track_caller]
pub fn assert_mean(image: &Image, expected: f64, sigmas: f64) {
    for channel in ["R", "G", "B"] {
        let (mean, error) = mean(image, channel);
        let tolerance = sigmas * error + 1e-4 * expected;
        assert!(
            (mean - expected).abs() <= tolerance,
            "{channel}: {mean} ± {error}, expected {expected}"
        );
    }
}
