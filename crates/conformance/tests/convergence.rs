//! How fast noise falls: as theory says for each sampler.

use rutilant::Prepared;
use rutilant::camera::Perspective;
use rutilant::color::Rgb;
use rutilant::film::Filter;
use rutilant::geom::{Transform, Vec2, Vec3};
use rutilant::image::{Channel, Image};
use rutilant::light::{Environment, Projection};
use rutilant::material::Matte;
use rutilant::sampler::{Independent, Sampler, Sequence, Sobol};
use rutilant::scene::Scene;
use rutilant::settings::{Crop, Heuristic, SamplerKind, Settings, Strategy};
use rutilant::shape::{Object, Shape};
use rutilant_conformance::matrix::render;
use rutilant_conformance::{references, scenes};
use rutilant_formats::{ReadOptions, parse_native};
use std::f64::consts::PI;
use std::sync::{Arc, LazyLock};

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
                // Pixels that share a sequence would share its luck.
                let sequence = Sequence::new(pixel.into(), n);
                let value = |i| {
                    let u = S::new(&sequence, [pixel % 20, pixel / 20], i).d2(3);
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

/// Root mean squared error against `truth`, over all pixels and channels.
fn rmse(picture: &[[f32; 3]], truth: &[[f32; 3]]) -> f64 {
    let pairs = picture.iter().flatten().zip(truth.iter().flatten());
    let squares: f64 = pairs.map(|(a, b)| f64::from(a - b).powi(2)).sum();
    (squares / (3 * truth.len()) as f64).sqrt()
}

/// A picture of so many columns, seen through a Gaussian of a standard deviation of two pixels.
fn blurred(picture: &[[f32; 3]], columns: u32) -> Vec<[f32; 3]> {
    const REACH: i32 = 6;
    let weight = |d: i32| f32::exp(-0.5 * (d * d) as f32 / 4.0);
    let sum: f32 = (-REACH..=REACH).map(weight).sum();
    let columns = columns as i32;
    let rows = picture.len() as i32 / columns;
    let along = |from: &[[f32; 3]], [right, down]: [i32; 2]| -> Vec<[f32; 3]> {
        let at = |i: i32, channel: usize| {
            let tap = |d: i32| {
                let x = (i % columns + d * right).clamp(0, columns - 1);
                let y = (i / columns + d * down).clamp(0, rows - 1);
                weight(d) / sum * from[(y * columns + x) as usize][channel]
            };
            (-REACH..=REACH).map(tap).sum()
        };
        (0..columns * rows).map(|i| [at(i, 0), at(i, 1), at(i, 2)]).collect()
    };
    along(&along(picture, [1, 0]), [0, 1])
}

/// Part of the back wall of the Cornell box in a picture of 128 × 128 pixels: no edge, no shadow.
const BACK_WALL: Crop = Crop { x: 32, y: 32, width: 48, height: 16 };

/// Direct light there.
fn direct_light(sampler: SamplerKind, spp: u64, seed: u64) -> Vec<[f32; 3]> {
    static BOX: LazyLock<Arc<Prepared>> =
        LazyLock::new(|| prepared(include_str!("../../../scenes/cornell-box.toml")));
    let settings = Settings {
        size: [128; 2],
        crop: Some(BACK_WALL),
        max_depth: Some(2),
        spp,
        seed,
        sampler,
        ..Settings::default()
    };
    render(&BOX, settings, 2).unwrap().rgb().unwrap()
}

/// Where no edge and no shadow is, sixteen stratified samples are worth many more independent
/// ones: in Burley's detail of such a box (2020, figure 1a) these have 11.8 times the error.
#[test]
fn stratified_samples_of_direct_light_are_worth_many() {
    let truth = direct_light(SamplerKind::Sobol, 4096, 99);
    let error = |sampler| rmse(&direct_light(sampler, 16, 1), &truth);
    let [independent, sobol] = [SamplerKind::Independent, SamplerKind::Sobol].map(error);
    println!("{independent} / {sobol} = {}", independent / sobol);
    assert!(independent > 8.0 * sobol, "{independent} {sobol}");
}

/// The noise of few samples cancels in a pixel's neighbourhood, since neighbours share out what one
/// sequence has between them. Pixels whose numbers know nothing of each other's are here those of
/// pictures of different seeds, each pixel from any of these.
#[test]
fn neighbours_cancel_each_others_noise() {
    const SEEDS: u64 = 16;
    let truth = blurred(&direct_light(SamplerKind::Sobol, 2048, 99), BACK_WALL.width);
    for spp in [1, 2, 4] {
        let picture = |seed| direct_light(SamplerKind::Sobol, spp, seed);
        let pictures: Vec<_> = (0..SEEDS).map(picture).collect();
        let drawn = Sequence::new(5, 1);
        let from = |i: usize| (16.0 * Independent::new(&drawn, [i as u32, 0], 0).d1(0)) as usize;
        let strangers: Vec<_> = (0..truth.len()).map(|i| pictures[from(i)][i]).collect();
        let error = |picture: &Vec<_>| rmse(&blurred(picture, BACK_WALL.width), &truth);
        let neighbours = pictures.iter().map(error).sum::<f64>() / SEEDS as f64;
        let strangers = error(&strangers);
        println!("{spp} spp: {strangers} / {neighbours} = {}", strangers / neighbours);
        assert!(strangers > 1.5 * neighbours, "{spp} spp: {strangers} {neighbours}");
    }
}

/// Four glossy plates under four lamps.
fn veachs_plates() -> Arc<Prepared> {
    let veach = references::ALL.iter().find(|r| r.name == "bitterli-veach-mis").unwrap();
    prepared(veach.scene)
}

fn prepared(scene: &str) -> Arc<Prepared> {
    let loaded = parse_native(scene, "scene.toml".as_ref(), &ReadOptions::default()).unwrap();
    Arc::new(Prepared::new(&loaded.scene).unwrap())
}

/// Rows of a picture of 160 × 90 that hold nothing but one plate between the columns of
/// [`one_plate`].
const PLATES: [(u32, u32); 4] = [(34, 46), (48, 56), (61, 67), (73, 79)];

/// Direct light on one plate.
fn one_plate((from, to): (u32, u32)) -> Settings {
    Settings {
        size: [160, 90],
        crop: Some(Crop { x: 50, y: from, width: 60, height: to - from }),
        spp: 1024,
        max_depth: Some(2),
        sampler: SamplerKind::Independent,
        ..Settings::default()
    }
}

/// The variances of all pixels' means, added up.
fn variance(scene: &Arc<Prepared>, settings: Settings) -> f64 {
    let image = render(scene, settings, 2).unwrap();
    image.channel("variance.G").unwrap().iter().map(|&v| f64::from(v)).sum()
}

/// On each of Veach's plates both ways of finding light together are hardly noisier than the
/// better of the two, and over all plates much quieter than either: by the balance heuristic the
/// variance exceeds the least by at most half the squared mean (Veach 1997, theorem 9.2), which
/// is little where noise matters. Weights that do not sum to one, or densities that are not those
/// of the samples, cost more than that.
#[test]
fn both_ways_are_hardly_noisier_than_the_better_one() {
    let scene = veachs_plates();
    let mut sums = [0.0; 3];
    for plate in PLATES {
        let each = [Strategy::Both, Strategy::LightOnly, Strategy::BsdfOnly]
            .map(|strategy| variance(&scene, Settings { strategy, ..one_plate(plate) }));
        println!("{plate:?}: {each:?}");
        let [both, light, bsdf] = each;
        assert!(both <= 1.1 * light.min(bsdf), "{plate:?}: {each:?}");
        sums = [sums[0] + both, sums[1] + light, sums[2] + bsdf];
    }
    println!("{sums:?}");
    assert!(sums[0] < 0.5 * sums[1].min(sums[2]), "{sums:?}");
}

/// Optimal weights are no noisier than balance and power on any of the plates, but for what
/// learning costs: a number learnt from i samples adds about 1/i of the variance to the next, which
/// over 1024 are ln 1024 / 1024 = 0.7 %, and some more where few samples carry most noise.
#[test]
fn optimal_weights_are_no_noisier_than_the_better_heuristic() {
    let scene = veachs_plates();
    for plate in PLATES {
        let each = [Heuristic::Optimal, Heuristic::Balance, Heuristic::Power]
            .map(|heuristic| variance(&scene, Settings { heuristic, ..one_plate(plate) }));
        println!("{plate:?}: {each:?}");
        let [optimal, balance, power] = each;
        assert!(optimal <= 1.02 * balance.min(power), "{plate:?}: {each:?}");
    }
}

/// The radiance of the even skies here, and how white the plane under them is.
const SKY: f32 = 1.5;
const ALBEDO: f32 = 0.8;

/// What the plane sends back, a L.
const SENT_BACK: f64 = (ALBEDO * SKY) as f64;

/// A matte plane.
fn plane_under(sky: impl FnOnce(&mut Scene) -> Environment) -> Arc<Prepared> {
    let camera = Perspective::look_at(Vec3::new(0.0, 2.0, 0.1), Vec3::ZERO, 0.5).unwrap();
    let mut scene = Scene::new(camera);
    scene.environment = Some(sky(&mut scene));
    let plane = scene.add_material(Matte::new(Rgb::grey(ALBEDO)));
    let flat = Transform::rotate(Vec3::X, -std::f32::consts::FRAC_PI_2);
    let shape = Shape::Rectangle { size: Vec2::splat(100.0) };
    scene.objects.push(Object::new(shape, plane).transformed(&flat));
    Arc::new(Prepared::new(&scene).unwrap())
}

/// An even sky as a map, of equal pixels on equal areas: a plain colour would be left to
/// scattered rays.
fn even_map(scene: &mut Scene) -> Environment {
    let channel = |name: &str| Channel { name: name.to_owned(), values: vec![SKY; 64] };
    let map = scene.add_image(Image::new(8, 8, ["R", "G", "B"].map(channel).into()).unwrap());
    Environment::map(map, Projection::Octahedral)
}

/// One heuristic's picture of it.
fn picture_of_the_plane(
    scene: &Arc<Prepared>,
    sampler: SamplerKind,
    spp: u64,
    heuristic: Heuristic,
    seed: u64,
) -> Image {
    let (size, filter) = ([24; 2], Filter::Box { radius: 0.5 });
    let settings = Settings { size, spp, sampler, filter, heuristic, seed, ..Settings::default() };
    render(scene, settings, 2).unwrap()
}

/// A matte plane under an even sky: what it sends back, a L, is in proportion to the density of
/// its scattered directions. With that density and the sky's, 1/4π, the balance heuristic gives
/// a L (1 + C), where C = w_bsdf(x) − w_light(y) has mean 0 and variance m (1 − 2 m) with
/// m = (1 − ln 5 / 4) / 2. So its noise is known, and optimal weights leave none but that of
/// learning δ = −a L: the doubt of one sample among n leaves 1 / (n Var C), 0.8 %, and the first
/// few samples, which cannot know yet, hardly more.
#[test]
fn optimal_weights_leave_no_noise_under_an_even_sky() {
    let (scene, sent_back) = (plane_under(even_map), SENT_BACK);
    let spp = 1024_u32;
    let m = 0.5 * (1.0 - 0.25 * 5.0_f64.ln());
    let expected = sent_back * sent_back * m * (1.0 - 2.0 * m);
    let [optimal, balance, power] =
        [Heuristic::Optimal, Heuristic::Balance, Heuristic::Power].map(|heuristic| {
            let independent = SamplerKind::Independent;
            let image = picture_of_the_plane(&scene, independent, spp.into(), heuristic, 0);
            let variances = image.channel("variance.G").unwrap().iter().map(|&v| f64::from(v));
            let variance = variances.sum::<f64>() * f64::from(spp) / (24.0 * 24.0);
            let values = image.channel("G").unwrap().iter().map(|&v| f64::from(v));
            let mean = values.sum::<f64>() / (24.0 * 24.0);
            let error = (variance / f64::from(spp)).sqrt() / 24.0;
            assert!(
                (mean - sent_back).abs() < 4.0 * error + 1e-6,
                "{heuristic:?}: {mean} ± {error}"
            );
            variance
        });
    println!("{optimal} {balance} {power}, expected {expected}");
    // A variance from 590,000 samples: of itself it scatters by less than 0.3 %.
    assert!((balance / expected - 1.0).abs() < 0.01, "{balance}, expected {expected}");
    assert!(optimal < 0.015 * balance && optimal < 0.05 * power, "{optimal}, {balance}, {power}");
}

/// Of an even sky that is told to be one nothing is left to light sampling: directions are drawn in
/// proportion to what they bring, and there is no noise at all.
#[test]
fn an_even_sky_makes_no_noise() {
    let scene = plane_under(|_| Environment::constant(Rgb::grey(SKY)));
    let image = picture_of_the_plane(&scene, SamplerKind::Independent, 4, Heuristic::Power, 0);
    for value in image.channel("G").unwrap() {
        assert!((f64::from(*value) - SENT_BACK).abs() < 1e-6, "{value}");
    }
}

/// With Sobol's points, which depend on each other, what pixels learn leans a little; the error
/// with that and all is still well below that of the balance heuristic. Pixels share one sequence
/// and its luck, so several pictures tell of the lean.
#[test]
fn with_sobols_points_optimal_weights_lean_little() {
    const PICTURES: u64 = 8;
    let scene = plane_under(even_map);
    let [[optimal, lean], [balance, _]] = [Heuristic::Optimal, Heuristic::Balance].map(|h| {
        let (mut sum, mut squares) = (0.0, 0.0);
        for seed in 0..PICTURES {
            let image = picture_of_the_plane(&scene, SamplerKind::Sobol, 64, h, seed);
            for value in image.channel("G").unwrap() {
                let error = f64::from(*value) / SENT_BACK - 1.0;
                sum += error;
                squares += error * error;
            }
        }
        let values = PICTURES as f64 * 24.0 * 24.0;
        [(squares / values).sqrt(), sum / values]
    });
    println!("{optimal} with a lean of {lean}, {balance}");
    assert!(lean.abs() < 0.2 * optimal && lean.abs() < 1e-3, "{lean}, {optimal}");
    assert!(optimal < 0.75 * balance, "{optimal}, {balance}");
}
