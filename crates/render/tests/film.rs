//! Reconstruction filters in pictures: edges have the profile of the filter's integral.

#![expect(clippy::disallowed_methods, reason = "expected values are computed in f64")]

mod common;

use common::{render, small};
use rutilant::camera::Orthographic;
use rutilant::color::Rgb;
use rutilant::film::Filter;
use rutilant::geom::{Transform, Vec2, Vec3};
use rutilant::light::Environment;
use rutilant::material::Emission;
use rutilant::scene::Scene;
use rutilant::settings::{SamplerKind, Settings};
use rutilant::shape::{Object, Shape};
use std::f64::consts::PI;

fn all() -> Vec<Filter> {
    vec![
        Filter::Box { radius: 0.5 },
        Filter::Box { radius: 1.3 },
        Filter::Tent { radius: 1.0 },
        Filter::Gaussian { radius: 1.5, sigma: 0.5 },
        Filter::Mitchell { radius: 2.0, b: 1.0 / 3.0, c: 1.0 / 3.0 },
        Filter::Mitchell { radius: 2.0, b: 0.0, c: 0.5 },
        Filter::BlackmanHarris { radius: 1.5 },
    ]
}

/// The value at `x` along one axis, in f64, from the papers; any factor will do.
fn value(filter: &Filter, x: f64) -> f64 {
    let x = x.abs();
    let part = |radius: f32| x / f64::from(radius);
    match *filter {
        Filter::Box { radius } => f64::from(u8::from(part(radius) < 1.0)),
        Filter::Tent { radius } => (1.0 - part(radius)).max(0.0),
        Filter::Gaussian { radius, sigma } => {
            let bell = |x: f64| (-0.5 * (x / f64::from(sigma)).powi(2)).exp();
            (bell(x) - bell(f64::from(radius))).max(0.0)
        }
        Filter::Mitchell { radius, b, c } => {
            let (x, b, c) = (2.0 * part(radius), f64::from(b), f64::from(c));
            let cubic = |k: [f64; 4]| k[0] + x * (k[1] + x * (k[2] + x * k[3]));
            match x {
                x if x < 1.0 => cubic([
                    6.0 - 2.0 * b,
                    0.0,
                    -18.0 + 12.0 * b + 6.0 * c,
                    12.0 - 9.0 * b - 6.0 * c,
                ]),
                x if x < 2.0 => cubic([
                    8.0 * b + 24.0 * c,
                    -12.0 * b - 48.0 * c,
                    6.0 * b + 30.0 * c,
                    -b - 6.0 * c,
                ]),
                _ => 0.0,
            }
        }
        Filter::BlackmanHarris { radius } => {
            let t = part(radius);
            if t >= 1.0 {
                return 0.0;
            }
            // Harris 1978, the four-term window of 92 dB, its middle at 0.
            let terms = [0.35875, 0.48829, 0.14128, 0.01168];
            terms.iter().enumerate().map(|(k, a)| a * (PI * k as f64 * t).cos()).sum()
        }
    }
}

/// How bright a pixel is whose centre lies `distance` pixels inside a bright half plane with the
/// inner normal (cos, sin): the filter integrated over the half plane, over its whole integral.
fn over_half_plane(filter: &Filter, distance: f64, angle: f64) -> f64 {
    let reach = f64::from(filter.radius());
    let n = 600;
    let step = 2.0 * reach / f64::from(n);
    let offset = |i: i32| -reach + (f64::from(i) + 0.5) * step;
    let weights: Vec<f64> = (0..n).map(|i| value(filter, offset(i))).collect();
    // Sums up to each border, so that a row's part up to anywhere is one look-up.
    let mut sums = vec![0.0];
    sums.extend(weights.iter().scan(0.0, |sum, w| {
        *sum += w;
        Some(*sum)
    }));
    let total = sums[n as usize];
    let up_to = |x: f64| {
        let at = ((x + reach) / step).clamp(0.0, f64::from(n));
        let whole = (at as usize).min(n as usize - 1);
        sums[whole] + (at - whole as f64) * weights[whole]
    };
    // Inside: x cos + y sin + distance > 0.
    let (sin, cos) = angle.sin_cos();
    let row = |i: i32| {
        let border = -(distance + offset(i) * sin) / cos;
        weights[i as usize] * (total - up_to(border))
    };
    (0..n).map(row).sum::<f64>() / (total * total)
}

/// A slanted edge: every pixel near it has the brightness that the filter's own integral over the
/// bright side gives, within a hundredth at 4096 samples. A filter of the wrong width, a shift by
/// half a pixel, or negative lobes that are lost, would be far off.
#[test]
fn slanted_edges_have_the_filters_profile() {
    let [width, height] = [16_u32, 12];
    let angle = 0.12_f64;
    for filter in all() {
        let mut scene =
            Scene::new(Orthographic::look_at(Vec3::ZERO, Vec3::NEG_Z, height as f32).unwrap());
        let lamp = scene.add_material(Emission::radiance(Rgb::WHITE));
        // A square of 200 m whose left edge runs through the middle of the picture.
        let place = Transform::translate(Vec3::new(0.0, 0.0, -1.0))
            * Transform::rotate(Vec3::Z, angle as f32)
            * Transform::translate(Vec3::new(100.0, 0.0, 0.0));
        let square = Shape::Rectangle { size: Vec2::splat(200.0) };
        scene.objects.push(Object::new(square, lamp).transformed(&place));
        let settings = Settings {
            size: [width, height],
            spp: 4096,
            max_depth: Some(1),
            filter,
            ..Settings::default()
        };
        let image = render(&scene, settings);
        let (mut worst, mut between) = (0.0_f64, 0);
        for (i, &seen) in image.channel("G").unwrap().iter().enumerate() {
            let x = (i as u32 % width) as f64 + 0.5 - f64::from(width) / 2.0;
            let y = f64::from(height) / 2.0 - (i as u32 / width) as f64 - 0.5;
            let distance = x * angle.cos() + y * angle.sin();
            let expected = over_half_plane(&filter, distance, angle);
            worst = worst.max((f64::from(seen) - expected).abs());
            between += u32::from((0.05..0.95).contains(&expected));
        }
        assert!(between >= 8, "{filter:?}: the edge is seen in {between} pixels");
        assert!(worst < 1e-2, "{filter:?}: {worst} off");
    }
}

/// The weights of all samples of a pixel add up to one: an even sky is as bright through every
/// filter, exactly where no weight is negative.
#[test]
fn weights_add_up_to_one() {
    for filter in all() {
        let mut scene = Scene::new(Orthographic::look_at(Vec3::ZERO, Vec3::NEG_Z, 1.0).unwrap());
        scene.environment = Some(Environment::constant(Rgb::WHITE));
        let settings =
            Settings { filter, sampler: SamplerKind::Sobol, size: [8, 8], ..small(4096) };
        let image = render(&scene, settings);
        let variance = image.channel("variance.G").unwrap();
        for (&seen, variance) in image.channel("G").unwrap().iter().zip(variance) {
            // Without negative weights there is no variance at all. With them,
            // five standard errors: chance alone breaks that in one of 27,000 pictures.
            let tolerance = 1e-6 + 5.0 * variance.sqrt();
            assert!(
                (seen - 1.0).abs() <= tolerance && variance.sqrt() < 0.02,
                "{filter:?}: {seen}"
            );
        }
    }
}
