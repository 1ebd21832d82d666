//! Glass that bends each colour differently is, on average, what its colours are one by one.

#![expect(clippy::disallowed_methods, reason = "expected values are computed in f64")]

mod common;

use common::{assert_mean, mean, render, small};
use rutilant::camera::{Orthographic, Perspective};
use rutilant::color::Rgb;
use rutilant::geom::{Transform, Vec2, Vec3};
use rutilant::image::Image;
use rutilant::light::Environment;
use rutilant::material::{Dielectric, Emission, Material, Matte, Medium, Principled};
use rutilant::scene::Scene;
use rutilant::settings::{IntegratorKind, SamplerKind, Settings};
use rutilant::shape::{Object, Shape};

const DISPERSION: f32 = 6.0;

/// The index for a wavelength, by Cauchy's equation through the lines d, and F and C.
fn index(ior: f64, nm: f64) -> f64 {
    let [f, d, c] = [486.13, 587.56, 656.27].map(|line: f64| 1.0 / (line * line));
    ior + (ior - 1.0) * f64::from(DISPERSION) / 20.0 * (1.0 / (nm * nm) - d) / (f - c)
}

/// The wavelengths of bands of 20 nm, and the part of each channel that they make: colour matching
/// functions as Wyman et al. 2013 fit them, in sRGB, without what is negative.
fn bands() -> Vec<(f64, [f64; 3])> {
    let seen = |nm: f64| {
        let bell = |middle: f64, below: f64, above: f64| {
            let t = (nm - middle) * if nm < middle { below } else { above };
            (-0.5 * t * t).exp()
        };
        let x = 0.362 * bell(442.0, 0.0624, 0.0374) + 1.056 * bell(599.8, 0.0264, 0.0323)
            - 0.065 * bell(501.1, 0.049, 0.0382);
        let y = 0.821 * bell(568.8, 0.0213, 0.0247) + 0.286 * bell(530.9, 0.0613, 0.0322);
        let z = 1.217 * bell(437.0, 0.0845, 0.0278) + 0.681 * bell(459.0, 0.0385, 0.0725);
        let red = 3.2406 * x - 1.5372 * y - 0.4986 * z;
        let green = -0.9689 * x + 1.8758 * y + 0.0415 * z;
        let blue = 0.0557 * x - 0.2040 * y + 1.0570 * z;
        [red, green, blue].map(|c| c.max(0.0))
    };
    let bands: Vec<_> =
        (0..15).map(|i| 410.0 + 20.0 * f64::from(i)).map(|nm| (nm, seen(nm))).collect();
    let sum = |c: usize| bands.iter().map(|(_, rgb)| rgb[c]).sum::<f64>();
    let all = [0, 1, 2].map(sum);
    bands.iter().map(|(nm, rgb)| (*nm, [0, 1, 2].map(|c| rgb[c] / all[c]))).collect()
}

/// Glass of all kinds, in a row before a sky that changes slowly from place to place.
fn row(glass: impl Fn(f32) -> [Material; 4]) -> Scene {
    let camera = Orthographic::look_at(Vec3::Z * 9.0, Vec3::ZERO, 2.0).unwrap();
    let mut scene = Scene::new(camera);
    let pixel = |i: u32| {
        let (x, y) = (i % 64, i / 64);
        [(x * 4 % 64) as f32 / 16.0, (64 - x) as f32 / 40.0, y as f32 / 16.0]
    };
    let pixels: Vec<[f32; 3]> = (0..64 * 32).map(pixel).collect();
    let map = scene.add_image(Image::from_rgb(64, 32, &pixels).unwrap());
    scene.environment = Some(Environment::image(map));
    for (i, material) in glass(1.5).into_iter().enumerate() {
        let material = scene.add_material(material);
        let place = Transform::translate(Vec3::new(2.0 * i as f32 - 3.0, 0.0, 0.0));
        let sphere = Object::new(Shape::Sphere { radius: 0.9 }, material);
        scene.objects.push(sphere.transformed(&place));
    }
    scene
}

/// Smooth, rough, layered, and with a priority.
fn glass(dispersion: f32, ior: f32) -> [Material; 4] {
    let smooth = Dielectric { dispersion, ..Dielectric::new(ior) };
    let layered = Principled {
        base_color: Rgb::WHITE,
        transmission: 1.0,
        roughness: 0.2,
        ior,
        dispersion,
        ..Principled::default()
    };
    [
        smooth.into(),
        Dielectric { roughness: 0.3, ..smooth }.into(),
        layered.into(),
        Dielectric { priority: Some(1), ..smooth }.into(),
    ]
}

/// Pixel by pixel a picture of dispersive glass is the sum of pictures of glass of one index each,
/// as far as each band of the spectrum is seen as each channel: by the path tracer and by chance
/// alone. A band that is chosen more often than it says, a second choice, light that keeps its
/// other channels, or an index of another wavelength shows here.
#[test]
fn colours_go_their_own_ways() {
    let size = [24, 6];
    let settings = |spp| Settings { size, ..small(spp) };
    let pixels = (size[0] * size[1]) as usize;
    let mut expected = vec![[0.0_f64; 3]; pixels];
    let mut variance = vec![[0.0_f64; 3]; pixels];
    for (seed, (nm, part)) in (1..).zip(bands()) {
        // Of independent pictures variances add up.
        let scene = row(|ior| glass(0.0, index(f64::from(ior), nm) as f32));
        let picture = render(&scene, Settings { seed, ..settings(256) });
        for (c, channel) in ["R", "G", "B"].into_iter().enumerate() {
            let values = picture.channel(channel).unwrap();
            let variances = picture.channel(&format!("variance.{channel}")).unwrap();
            for i in 0..pixels {
                expected[i][c] += part[c] * f64::from(values[i]);
                variance[i][c] += part[c] * part[c] * f64::from(variances[i]);
            }
        }
    }
    // How far a picture is from that, as a mean square in standard errors.
    let off = |picture: &Image| {
        let mut sum = 0.0;
        for (c, channel) in ["R", "G", "B"].into_iter().enumerate() {
            let values = picture.channel(channel).unwrap();
            let variances = picture.channel(&format!("variance.{channel}")).unwrap();
            for i in 0..pixels {
                let error2 = variance[i][c] + f64::from(variances[i]) + 1e-9;
                let z2 = (f64::from(values[i]) - expected[i][c]).powi(2) / error2;
                sum += z2 / (3 * pixels) as f64;
            }
        }
        sum
    };
    let dispersive = row(|ior| glass(DISPERSION, ior));
    for integrator in [IntegratorKind::Path, IntegratorKind::Naive] {
        let found = off(&render(&dispersive, Settings { integrator, ..settings(2048) }));
        println!("{integrator:?}: {found}");
        // Of 432 numbers, a third of which are independent: 1 ± 0.12, by chance above this once in
        // a hundred thousand pictures.
        assert!(found < 1.6, "{integrator:?}: {found}");
    }
    let plain = off(&render(&row(|ior| glass(0.0, ior)), settings(2048)));
    assert!(plain > 20.0, "nobody would see it: {plain}");
}

/// White glass is white, whatever it does to colours: it cannot be seen under a white sky.
#[test]
fn dispersive_glass_vanishes_in_the_furnace() {
    let mut scene = row(|ior| glass(DISPERSION, ior));
    scene.environment = Some(Environment::constant(Rgb::WHITE));
    for integrator in [IntegratorKind::Path, IntegratorKind::Naive] {
        let settings = Settings { size: [24, 6], integrator, ..small(1024) };
        let image = render(&scene, settings);
        for channel in ["R", "G", "B"] {
            let (mean, error) = mean(&image, channel);
            // Rough layers keep their balance to within a hundredth.
            assert!((mean - 1.0).abs() < 4.0 * error + 2e-3, "{channel}: {mean} ± {error}");
        }
    }
}

/// A rainbow on a floor is as bright, in every channel, with light paths as without; and it is
/// there: red and blue fall on different places.
#[test]
fn light_paths_take_the_same_colours() {
    let camera = Perspective::look_at(Vec3::new(0.0, 1.6, 2.0), Vec3::new(0.1, 0.0, 0.1), 0.6);
    let mut scene = Scene::new(camera.unwrap());
    let floor = scene.add_material(Matte::new(Rgb::grey(0.7)));
    let glass = scene.add_material(Dielectric { dispersion: DISPERSION, ..Dielectric::new(1.5) });
    let lamp = scene.add_material(Emission::radiance(Rgb::grey(10.0)));
    let turn = Transform::rotate(Vec3::X, -std::f32::consts::FRAC_PI_2);
    let at = |x, y, z| Transform::translate(Vec3::new(x, y, z));
    let mut put = |shape, material, place: Transform| {
        scene.objects.push(Object::new(shape, material).transformed(&place));
    };
    put(Shape::Rectangle { size: Vec2::splat(40.0) }, floor, turn);
    put(Shape::Sphere { radius: 0.3 }, glass, at(0.0, 0.5, 0.0));
    put(Shape::Sphere { radius: 0.3 }, lamp, at(-0.9, 2.4, -0.8));
    let settings = Settings { size: [16, 16], sampler: SamplerKind::Sobol, ..small(4096) };
    let with = render(&scene, settings.clone());
    let without = render(&scene, Settings { caustics: false, ..settings });
    for channel in ["R", "G", "B"] {
        let ratio = mean(&with, channel).0 / mean(&without, channel).0;
        println!("{channel}: {ratio}");
        assert!((ratio - 1.0).abs() < 0.01, "{channel}: {ratio}");
    }
    let [red, blue] = ["R", "B"].map(|channel| with.channel(channel).unwrap());
    let ratios = red.iter().zip(blue).map(|(r, b)| r / b);
    let (least, most) = ratios.fold((f32::MAX, 0.0_f32), |(a, b), x| (a.min(x), b.max(x)));
    assert!(least < 0.9 && most > 1.1, "{least} {most}");
}

/// Paths that meet nothing dispersive have the bits that they have without it.
#[test]
fn other_paths_stay_as_they_are() {
    let picture = |dispersive: bool| {
        let mut scene = row(|ior| glass(0.0, ior));
        if dispersive {
            let glass = scene.add_material(Dielectric { dispersion: 1.0, ..Dielectric::new(1.5) });
            // In a black box behind the eye.
            let place = Transform::translate(Vec3::Z * 99.0);
            let black = scene.add_material(Material::new(rutilant::material::MaterialKind::Black));
            for (shape, material) in
                [(Shape::Sphere { radius: 0.1 }, glass), (Shape::Box { size: Vec3::ONE }, black)]
            {
                scene.objects.push(Object::new(shape, material).transformed(&place));
            }
        } else {
            let black = scene.add_material(Material::new(rutilant::material::MaterialKind::Black));
            let place = Transform::translate(Vec3::Z * 99.0);
            let cube = Object::new(Shape::Box { size: Vec3::ONE }, black);
            scene.objects.push(cube.transformed(&place));
        }
        render(&scene, Settings { size: [24, 6], caustics: false, ..small(16) }).hash()
    };
    assert_eq!(picture(true), picture(false));
}

/// Nothing bends no light, of whatever colour: a medium of index 1 does not disperse.
#[test]
fn nothing_does_not_disperse() {
    let camera = Orthographic::look_at(Vec3::Z * 9.0, Vec3::ZERO, 0.1).unwrap();
    let mut scene = Scene::new(camera);
    scene.environment = Some(Environment::constant(Rgb::WHITE));
    let air = Dielectric { dispersion: DISPERSION, interior: Medium::AIR, ..Dielectric::new(1.0) };
    let air = scene.add_material(air);
    scene.objects.push(Object::new(Shape::Sphere { radius: 0.9 }, air));
    assert_mean(&render(&scene, small(4096)), 1.0, 4.5);
}
