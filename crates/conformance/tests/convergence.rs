//! How fast noise falls: as theory says for each sampler.

use rutilant::Prepared;
use rutilant::image::Image;
use rutilant::sampler::{Independent, Sampler, Sobol};
use rutilant::settings::{Crop, SamplerKind, Settings, Strategy};
use rutilant_conformance::matrix::render;
use rutilant_conformance::{references, scenes};
use rutilant_formats::{ReadOptions, parse_native};
use std::f64::consts::PI;
use std::sync::Arc;

/// The slope of the straight line through the points, by least squares.
fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let sum = |f: fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>();
    let (x, y) = (sum(|p| p.0) / n, sum(|p| p.1) / n);
    sum(|p| p.0 * p.1) / n - x * y
}

/// The slope of log error over log count.
fn log_log_slope(errors: &[(u64, f64)]) -> f64 {
    let points: Vec<_> = errors.iter().map(|&(n, e)| ((n as f64).log2(), e.log2())).collect();
    let spread: Vec<_> = points.iter().map(|p| (p.0, p.0)).collect();
    slope(&points) / slope(&spread)
}

/// Mean squared error of the mean of `f` over 2^from to 2^to points, over many pixels.
fn errors<S: Sampler>(
    powers: std::ops::RangeInclusive<u32>,
    expected: f64,
    f: impl Fn(f64, f64) -> f64,
) -> Vec<(u64, f64)> {
    const PIXELS: u32 = 400;
    powers
        .map(|power| {
            let n = 1_u64 << power;
            let error = |pixel: u32| {
                let value = |i| {
                    let u = S::new(5, [pixel % 20, pixel / 20], i).d2(3);
                    f(f64::from(u.x), f64::from(u.y))
                };
                let mean = (0..n).map(value).sum::<f64>() / n as f64;
                (mean - expected) * (mean - expected)
            };
            (n, (0..PIXELS).map(error).sum::<f64>() / f64::from(PIXELS))
        })
        .collect()
}

/// Owen's points integrate a smooth function with a variance of n⁻³ log n, which looks like a
/// slope between −2.8 and −3 at these counts, and the inside of a circle with n⁻¹·⁵ (Owen,
/// "Scrambled Net Variance for Integrals of Smooth Functions", 1997; He and Wang, "On the
/// Convergence Rate of Randomized Quasi–Monte Carlo for Discontinuous Functions", 2015);
/// independent points give n⁻¹ for both. A scramble that is not Owen's, or points that are no
/// net, loses the gain.
#[test]
fn variance_falls_as_theory_says() {
    let smooth = |x: f64, y: f64| (x + y).exp();
    let smooth_integral = (1.0_f64.exp() - 1.0).powi(2);
    let circle = |x: f64, y: f64| f64::from(u8::from(x * x + y * y < 1.0));
    let slopes = [
        log_log_slope(&errors::<Independent>(4..=11, smooth_integral, smooth)),
        log_log_slope(&errors::<Independent>(4..=11, PI / 4.0, circle)),
        log_log_slope(&errors::<Sobol>(4..=11, smooth_integral, smooth)),
        log_log_slope(&errors::<Sobol>(4..=11, PI / 4.0, circle)),
    ];
    println!("{slopes:?}");
    for (slope, expected) in slopes.into_iter().zip([-1.0, -1.0, -2.9, -1.5]) {
        assert!((slope - expected).abs() < 0.1, "{slopes:?}");
    }
}

/// relMSE of a picture: half the squared difference of two renderings with seeds of their own,
/// which is unbiased without any reference, over the squares of the better `means`.
fn relative_mse(a: &Image, b: &Image, means: &[[f32; 3]]) -> f64 {
    let (a, b) = (a.rgb().unwrap(), b.rgb().unwrap());
    let pairs = a.iter().flatten().zip(b.iter().flatten()).zip(means.iter().flatten());
    let term = |((a, b), m): ((&f32, &f32), &f32)| {
        let [a, b, m] = [a, b, m].map(|&v| f64::from(v));
        0.5 * (a - b) * (a - b) / (m * m + 0.01)
    };
    pairs.map(term).sum::<f64>() / (3 * means.len()) as f64
}

/// The error of a picture falls with the number of samples: relMSE with slope −1 for independent
/// ones, however long it runs (a sum in single precision would level off), and at least as
/// steeply, from less, for Sobol's.
#[test]
fn pictures_converge_at_the_right_rate() {
    let cornell = scenes::all().swap_remove(0);
    let scene = Arc::new(Prepared::new(&cornell.scene).unwrap());
    let picture = |sampler, spp, seed| {
        let settings = Settings { size: [32; 2], spp, seed, sampler, ..Settings::default() };
        render(&scene, settings, 2).unwrap()
    };
    let counts = [4, 8, 16, 32, 64, 128, 256, 512_u64];
    let best = picture(SamplerKind::Sobol, 1024, 77).rgb().unwrap();
    let errors = |sampler| {
        let error = |n| relative_mse(&picture(sampler, n, 1), &picture(sampler, n, 2), &best);
        counts.map(|n| (n, error(n)))
    };
    let (independent, sobol) = (errors(SamplerKind::Independent), errors(SamplerKind::Sobol));
    let slopes = [log_log_slope(&independent), log_log_slope(&sobol)];
    println!("{slopes:?} {independent:?} {sobol:?}");
    assert!((slopes[0] + 1.0).abs() < 0.05, "{slopes:?} {independent:?}");
    assert!(slopes[1] < -1.05, "{slopes:?} {sobol:?}");
    for ((n, plain), (_, spread)) in independent.into_iter().zip(sobol).skip(2) {
        assert!(spread < plain, "{n} samples: {spread} is no better than {plain}");
    }
}

/// On each of Veach's plates both ways of finding light together are hardly noisier than the
/// better of the two, and over all plates much quieter than either: by the balance heuristic the
/// variance exceeds the least by at most half the squared mean (Veach 1997, theorem 9.2), which
/// is little where noise matters. Weights that do not sum to one, or densities that are not those
/// of the samples, cost more than that.
#[test]
fn both_ways_are_hardly_noisier_than_the_better_one() {
    let veach = references::ALL.iter().find(|r| r.name == "bitterli-veach-mis").unwrap();
    let loaded = parse_native(veach.scene, "veach.toml".as_ref(), &ReadOptions::default()).unwrap();
    let scene = Arc::new(Prepared::new(&loaded.scene).unwrap());
    // Rows of a picture of 160 × 90 that hold nothing but one plate between these columns.
    let plates = [(34, 46), (48, 56), (61, 67), (73, 79)];
    let variance = |strategy, (from, to): (u32, u32)| {
        let settings = Settings {
            size: [160, 90],
            crop: Some(Crop { x: 50, y: from, width: 60, height: to - from }),
            spp: 1024,
            max_depth: Some(2),
            sampler: SamplerKind::Independent,
            strategy,
            ..Settings::default()
        };
        let image = render(&scene, settings, 2).unwrap();
        let values = image.channel("variance.G").unwrap();
        values.iter().map(|&v| f64::from(v)).sum::<f64>()
    };
    let mut sums = [0.0; 3];
    for plate in plates {
        let each =
            [Strategy::Both, Strategy::LightOnly, Strategy::BsdfOnly].map(|s| variance(s, plate));
        println!("{plate:?}: {each:?}");
        let [both, light, bsdf] = each;
        assert!(both <= 1.1 * light.min(bsdf), "{plate:?}: {each:?}");
        sums = [sums[0] + both, sums[1] + light, sums[2] + bsdf];
    }
    println!("{sums:?}");
    assert!(sums[0] < 0.5 * sums[1].min(sums[2]), "{sums:?}");
}
