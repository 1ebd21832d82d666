//! What each way to choose lights is worth: a city at night, rendered in the same time by each.
//!
//! `cargo run --release -p rutilant --example many_lights -- 10000 20` renders a city of ten
//! thousand lamps for about twenty seconds with each selection, one after the other, and tells the
//! relative error of what surfaces send back against a longer rendering. Houses are in the way of
//! most lamps. Lamps differ in brightness by a factor of a thousand, and a few floodlights are ten
//! times brighter again.
//!
//! `… --example many_lights -- build 1000000` tells how long the tree of a million glowing
//! triangles takes, `… -- few 4` what the choices cost in time and noise with four lamps in a room.

use rutilant::camera::Perspective;
use rutilant::color::Rgb;
use rutilant::geom::{Transform, Vec2, Vec3, real};
use rutilant::light::{EmitterSelection, Light, SpotLight};
use rutilant::material::{Emission, EmittedLight, Matte};
use rutilant::scene::Scene;
use rutilant::settings::{LightSelection, Settings};
use rutilant::shape::{Mesh, Object, Shape};
use rutilant::{Prepared, Session};
use std::f32::consts::{FRAC_PI_2, PI};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Random numbers that are the same every time.
struct Random(u64);

impl Random {
    /// In [0, 1).
    fn unit(&mut self) -> f32 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }

    fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    /// As often in each octave from 1 to 1000.
    fn octaves(&mut self) -> f32 {
        real::pow(1000.0, self.unit())
    }
}

/// A lamp of some power in W.
fn shining(power: Rgb) -> Emission {
    Emission { light: EmittedLight::Power(power), ..Emission::radiance(Rgb::WHITE) }
}

/// Houses along streets, lit windows on their walls, lamps over the streets, floodlights on a few
/// roofs; seen from above the roofs.
fn city(lamps: u32) -> Scene {
    const BLOCK: f32 = 24.0;
    let mut random = Random(7);
    let blocks = (lamps as f32 / 25.0).sqrt().ceil().max(2.0) as u32;
    let side = blocks as f32 * BLOCK;
    let eye = Vec3::new(-0.05 * side, 45.0, 0.13 * side);
    let camera = Perspective::look_at(eye, Vec3::new(0.3 * side, 0.0, 0.42 * side), 0.8).unwrap();
    let mut scene = Scene::new(camera);
    let stone = scene.add_material(Matte::new(Rgb::new(0.5, 0.45, 0.4)));
    let street = scene.add_material(Matte::new(Rgb::grey(0.2)));
    let at = |x, y, z| Transform::translate(Vec3::new(x, y, z));
    let lying = Transform::rotate(Vec3::X, -FRAC_PI_2);
    let ground = Shape::Rectangle { size: Vec2::splat(3.0 * side) };
    scene.objects.push(Object::new(ground, street).transformed(&(at(0.0, 0.0, 0.0) * lying)));
    let mut houses = Vec::new();
    for i in 0..blocks * blocks {
        let (x, z) = ((i % blocks) as f32 * BLOCK, (i / blocks) as f32 * BLOCK);
        let size = Vec3::new(
            random.between(8.0, 16.0),
            random.between(6.0, 14.0) * random.between(1.0, 2.5),
            random.between(8.0, 16.0),
        );
        let middle = Vec3::new(x, 0.5 * size.y, z);
        houses.push((middle, size));
        let house = Object::new(Shape::Box { size }, stone);
        scene.objects.push(house.transformed(&Transform::translate(middle)));
    }
    for i in 0..lamps {
        let power = 0.4 * random.octaves();
        let tint =
            Rgb::new(power, power * random.between(0.6, 1.0), power * random.between(0.3, 1.0));
        let (middle, size) = houses[(random.unit() * houses.len() as f32) as usize];
        let lamp = scene.add_material(shining(tint));
        let mut put = |shape, place: Transform| {
            scene.objects.push(Object::new(shape, lamp).transformed(&place));
        };
        match i % 8 {
            // A window on one of four walls.
            0..=3 => {
                let turn = Transform::rotate(Vec3::Y, FRAC_PI_2 * (i % 4) as f32);
                let (wide, deep) = if i % 2 == 0 { (size.x, size.z) } else { (size.z, size.x) };
                let along = random.between(-0.4, 0.4) * wide;
                let up = random.between(-0.45, 0.45) * size.y;
                let window = Shape::Rectangle { size: Vec2::new(0.8, 1.2) };
                put(window, Transform::translate(middle) * turn * at(along, up, 0.5 * deep + 0.02));
            }
            // A lamp over the street, shaded from above.
            4 | 5 => {
                let corner = Vec3::new(0.5 * BLOCK, 5.0, random.between(-0.5, 0.5) * BLOCK);
                let down = Transform::rotate(Vec3::X, FRAC_PI_2);
                let place = Vec3::new(middle.x, 0.0, middle.z) + corner;
                put(Shape::Disk { radius: 0.2 }, Transform::translate(place) * down);
            }
            // A ball over the door.
            6 => {
                let place = Vec3::new(middle.x + 0.5 * size.x + 0.3, 2.5, middle.z);
                put(Shape::Sphere { radius: 0.15 }, Transform::translate(place));
            }
            // A bare bulb or a spot.
            _ => {
                let position = Vec3::new(middle.x, 3.0, middle.z + 0.5 * size.z + 0.5);
                let light = SpotLight::Power(tint);
                let direction = Vec3::new(random.between(-1.0, 1.0), -1.0, 0.3);
                scene.lights.push(if i % 16 == 7 {
                    Light::Point {
                        position,
                        intensity: Rgb(tint.0.map(|c| c / (4.0 * PI))),
                        group: None,
                    }
                } else {
                    Light::Spot { position, direction, light, inner: 0.4, outer: 0.7, group: None }
                });
            }
        }
    }
    for i in 0..(lamps / 2500).max(1) {
        let (middle, size) = houses[(i as usize * 37 + houses.len() / 3) % houses.len()];
        let position = middle + Vec3::Y * (0.5 * size.y + 4.0);
        let (direction, light) = (Vec3::new(0.4, -1.0, 0.7), SpotLight::Power(Rgb::grey(4e3)));
        scene.lights.push(Light::Spot {
            position,
            direction,
            light,
            inner: 0.2,
            outer: 0.5,
            group: None,
        });
    }
    scene
}

/// A closed room with some lamps under its ceiling.
fn room(lamps: u32) -> Scene {
    let mut random = Random(11);
    let camera = Perspective::look_at(Vec3::new(0.0, 1.5, 3.5), Vec3::new(0.0, 1.0, 0.0), 0.9);
    let mut scene = Scene::new(camera.unwrap());
    let white = scene.add_material(Matte::new(Rgb::grey(0.7)));
    let at = |x, y, z| Transform::translate(Vec3::new(x, y, z));
    scene.objects.push(
        Object::new(Shape::Box { size: Vec3::new(8.0, 3.0, 8.0) }, white)
            .transformed(&at(0.0, 1.5, 0.0)),
    );
    for i in 0..6 {
        let size = Vec3::new(0.5, random.between(0.5, 1.5), 0.5);
        let place = at(i as f32 - 2.5, 0.5 * size.y, random.between(-2.0, 1.0));
        scene.objects.push(Object::new(Shape::Box { size }, white).transformed(&place));
    }
    for _ in 0..lamps {
        let power = 10.0 * random.octaves().sqrt();
        let lamp = scene.add_material(shining(Rgb::grey(power)));
        let place = at(random.between(-3.5, 3.5), 2.9, random.between(-3.5, 2.5));
        let down = Transform::rotate(Vec3::X, FRAC_PI_2);
        let shape = Shape::Rectangle { size: Vec2::splat(0.3) };
        scene.objects.push(Object::new(shape, lamp).transformed(&(place * down)));
    }
    scene
}

/// What surfaces send back, by channels, and the seconds that the picture took: lamps that are seen
/// themselves are left out, for the same samples without light see them at the same places. Small
/// as they are far off, their noise would hide that of all else, and no choice changes it.
fn render(
    scene: &Arc<Prepared>,
    selection: LightSelection,
    depth: u32,
    spp: u64,
    seed: u64,
) -> (Vec<f64>, f64) {
    let (mut picture, seconds) = picture(scene, selection, depth, spp, seed);
    let (lamps, _) = self::picture(scene, selection, 1, spp, seed);
    for (all, seen) in picture.iter_mut().zip(lamps) {
        *all -= seen;
    }
    (picture, seconds)
}

/// A picture's channels, and the seconds that it took.
fn picture(
    scene: &Arc<Prepared>,
    selection: LightSelection,
    depth: u32,
    spp: u64,
    seed: u64,
) -> (Vec<f64>, f64) {
    let settings = Settings {
        size: [320, 240],
        spp,
        seed,
        max_depth: Some(depth),
        light_selection: selection,
        caustics: false,
        ..Settings::default()
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let begin = Instant::now();
    let session = Session::start(Arc::clone(scene), settings, threads).unwrap();
    while !session.wait(Duration::from_secs(3600)) {}
    let seconds = begin.elapsed().as_secs_f64();
    let pixels = session.snapshot().rgb().unwrap();
    (pixels.into_iter().flatten().map(f64::from).collect(), seconds)
}

/// The mean of (x − r)² / (r² + ε), ε a hundredth of the squared mean; and without the worst
/// thousandth of all pixels.
fn relative_error(picture: &[f64], reference: &[f64]) -> [f64; 2] {
    let mean = reference.iter().sum::<f64>() / reference.len() as f64;
    let error = |(x, r): (&f64, &f64)| (x - r) * (x - r) / (r * r + 0.01 * mean * mean);
    let mut errors: Vec<f64> = picture.iter().zip(reference).map(error).collect();
    errors.sort_by(f64::total_cmp);
    let most = errors.len() - errors.len() / 1000;
    let mean_of = |errors: &[f64]| errors.iter().sum::<f64>() / errors.len() as f64;
    [mean_of(&errors), mean_of(&errors[..most])]
}

fn compare(scene: &Scene, seconds: f64, depth: u32, reference_spp: u64) {
    let begin = Instant::now();
    let scene = Arc::new(Prepared::new(scene).unwrap());
    let prepared = begin.elapsed().as_secs_f64();
    println!("{} emitters, prepared in {prepared:.2} s", scene.emitters().len());
    let ways = [LightSelection::Uniform, LightSelection::Power, LightSelection::Tree];
    let (reference, took) = render(&scene, LightSelection::Tree, depth, reference_spp, 99);
    println!("reference: {reference_spp} samples, {took:.1} s");
    for way in ways {
        let (_, trial) = render(&scene, way, depth, 8, 5);
        let spp = ((8.0 * seconds / trial).round() as u64).max(1);
        let (picture, took) = render(&scene, way, depth, spp, 1);
        let [all, most] = relative_error(&picture, &reference);
        let mean = picture.iter().sum::<f64>() / picture.len() as f64;
        println!(
            "{way:?}: {spp} samples in {took:.2} s, relMSE {all:.3e}, without the worst {most:.3e}, \
             times seconds {:.3e}, {:.3e}; mean {mean:.5}",
            all * took,
            most * took
        );
    }
}

/// Glowing triangles of a bumpy sphere, and how long their tree takes.
fn build(triangles: u32) {
    let mut random = Random(3);
    let rings = ((triangles / 4) as f32).sqrt().ceil() as u32;
    let mut mesh = Mesh::default();
    for i in 0..=rings {
        for j in 0..2 * rings {
            let (theta, phi) = (PI * i as f32 / rings as f32, PI * j as f32 / rings as f32);
            let radius = random.between(0.9, 1.1);
            let (sin, cos) = real::sin_cos(theta);
            mesh.positions
                .push(radius * Vec3::new(sin * real::cos(phi), cos, sin * real::sin(phi)));
        }
    }
    for i in 0..rings {
        for j in 0..2 * rings {
            let corner = |i: u32, j: u32| i * 2 * rings + j % (2 * rings);
            let [a, b, c, d] =
                [corner(i, j), corner(i, j + 1), corner(i + 1, j), corner(i + 1, j + 1)];
            mesh.triangles.extend([[a, b, c], [b, d, c]]);
        }
    }
    let mut scene = Scene::new(Perspective::look_at(Vec3::Z, Vec3::ZERO, 1.0).unwrap());
    let lamp = scene.add_material(Emission::radiance(Rgb::WHITE));
    let mesh = scene.add_mesh(mesh);
    scene.objects.push(Object::new(Shape::Mesh(mesh), lamp));
    let begin = Instant::now();
    let scene = Prepared::new(&scene).unwrap();
    println!(
        "{} emitters, prepared in {:.2} s",
        scene.emitters().len(),
        begin.elapsed().as_secs_f64()
    );
    for _ in 0..3 {
        let begin = Instant::now();
        let selection = EmitterSelection::new(LightSelection::Tree, scene.emitters(), 1.0);
        println!("light tree in {:.3} s", begin.elapsed().as_secs_f64());
        drop(selection);
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize, usual: f64| {
        arguments.get(i).map_or(usual, |word| word.parse().expect("a number"))
    };
    match arguments.first().map(String::as_str) {
        Some("build") => build(number(1, 1e6) as u32),
        Some("few") => {
            compare(&room(number(1, 4.0) as u32), number(2, 5.0), number(3, 2.0) as u32, 256);
        }
        _ => compare(
            &city(number(0, 1e4) as u32),
            number(1, 20.0),
            number(2, 2.0) as u32,
            number(3, 1024.0) as u64,
        ),
    }
}
