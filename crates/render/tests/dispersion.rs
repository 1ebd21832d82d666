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
use rutilant::settings::{IntegratorKind, SamplerKind, Settings, Strategy};
use rutilant::shape::{Mesh, Object, Shape};

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

/// A wedge that is 0.9 m thick on its left and nothing on its right: it bends light to the left.
fn wedge() -> Mesh {
    let corners = [(-0.9, 0.0), (0.9, 0.0), (-0.9, -0.9)];
    let at = |y: f32| corners.map(|(x, z)| Vec3::new(x, y, z));
    let sides = [[0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5]];
    let sides = sides.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
    Mesh {
        positions: [at(-0.9), at(0.9)].concat(),
        triangles: sides.chain([[0, 2, 1], [3, 4, 5]]).collect(),
        ..Mesh::default()
    }
}

/// Glass of all kinds, in a row before a sky that changes slowly from place to place.
fn row(glass: impl Fn(f32) -> [Material; 4]) -> Scene {
    let camera = Orthographic::look_at(Vec3::Z * 9.0, Vec3::ZERO, 2.0).unwrap();
    let mut scene = Scene::new(camera);
    // From light to dark, eight times around.
    let pixel = |i: u32| [(i * 8 % 64) as f32 / 16.0; 3];
    let pixels: Vec<[f32; 3]> = (0..64 * 32).map(pixel).collect();
    let map = scene.add_image(Image::from_rgb(64, 32, &pixels).unwrap());
    scene.environment = Some(Environment::image(map));
    let mesh = scene.add_mesh(wedge());
    for (i, material) in glass(1.5).into_iter().enumerate() {
        let material = scene.add_material(material);
        let place = Transform::translate(Vec3::new(2.0 * i as f32 - 3.0, 0.0, 0.0));
        scene.objects.push(Object::new(Shape::Mesh(mesh), material).transformed(&place));
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

/// A picture of dispersive glass is the sum of pictures of glass of one index each, as far as each
/// band of the spectrum is seen as each channel: by the path tracer and by chance alone. A band that
/// is chosen more often than it says, a second choice, light that keeps its other channels, or an
/// index of another wavelength shows here.
#[test]
fn colours_go_their_own_ways() {
    let settings = |spp| Settings { size: [24, 6], ..small(spp) };
    // The mean of each channel of each glass, and the square of its error.
    let means = |picture: &Image| -> [[(f64, f64); 3]; 4] {
        let mean = |glass: usize, channel: &str| {
            let sum = |name: &str| {
                let values = picture.channel(name).unwrap().iter().enumerate();
                let own = values.filter(|(i, _)| i % 24 / 6 == glass);
                own.map(|(_, &v)| f64::from(v)).sum::<f64>()
            };
            (sum(channel) / 36.0, sum(&format!("variance.{channel}")) / (36.0 * 36.0))
        };
        [0, 1, 2, 3].map(|glass| ["R", "G", "B"].map(|channel| mean(glass, channel)))
    };
    let mut expected = [[(0.0_f64, 0.0_f64); 3]; 4];
    for (seed, (nm, part)) in (1..).zip(bands()) {
        let scene = row(|ior| glass(0.0, index(f64::from(ior), nm) as f32));
        // Of independent pictures variances add up.
        let found = means(&render(&scene, Settings { seed, ..settings(256) }));
        for (all, found) in expected.iter_mut().zip(found) {
            for c in 0..3 {
                all[c].0 += part[c] * found[c].0;
                all[c].1 += part[c] * part[c] * found[c].1;
            }
        }
    }
    // How far from that every kind of glass is, or each of so many, at most in standard errors.
    let off = |picture: &Image, step: usize| {
        let mut most = 0.0_f64;
        for (found, expected) in means(picture).iter().zip(&expected).step_by(step) {
            for (a, b) in found.iter().zip(expected) {
                // A thousandth for what the Abbe number leaves to how lines are rounded.
                let error = (a.1 + b.1).sqrt() + 1e-3 * b.0;
                most = most.max((a.0 - b.0).abs() / error);
            }
        }
        most
    };
    let dispersive = row(|ior| glass(DISPERSION, ior));
    let ways = [
        (Settings { seed: 99, ..settings(2048) }, 1),
        (Settings { strategy: Strategy::BsdfOnly, seed: 99, ..settings(2048) }, 1),
        // Rough glass holds light for longer than this one has patience.
        (Settings { integrator: IntegratorKind::Naive, seed: 99, ..settings(2048) }, 3),
    ];
    for (settings, step) in ways {
        let found = off(&render(&dispersive, settings.clone()), step);
        println!("{found} by {:?}, {:?}", settings.integrator, settings.strategy);
        // Of 30 numbers one is by chance above this once in five hundred.
        assert!(found < 4.0, "{found}: {settings:?}");
    }
    let plain = off(&render(&row(|ior| glass(0.0, ior)), settings(2048)), 1);
    assert!(plain > 10.0, "nobody would see it: {plain}");
}

/// White glass is white, whatever it does to colours: it cannot be seen under a white sky.
#[test]
fn dispersive_glass_vanishes_in_the_furnace() {
    let mut scene = row(|ior| glass(DISPERSION, ior));
    scene.environment = Some(Environment::constant(Rgb::WHITE));
    for integrator in [IntegratorKind::Path, IntegratorKind::Naive] {
        let settings = Settings { size: [24, 6], integrator, ..small(512) };
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
    let settings = Settings { size: [16, 16], sampler: SamplerKind::Sobol, ..small(2048) };
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
