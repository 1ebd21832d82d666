//! Caustics: light paths and paths from the camera find the same light, and the former with ease.

mod common;

use common::{mean, render, render_prepared, small};
use rutilant::Prepared;
use rutilant::camera::{Camera, Equirectangular, Orthographic, Perspective};
use rutilant::color::Rgb;
use rutilant::film::Filter;
use rutilant::geom::{Transform, Vec2, Vec3};
use rutilant::image::Image;
use rutilant::light::Environment;
use rutilant::material::{Absorption, Dielectric, Emission, Matte, Mirror};
use rutilant::scene::{MaterialId, Scene};
use rutilant::settings::{Crop, SamplerKind, Settings, Strategy};
use rutilant::shape::{Mesh, Object, Shape};
use std::f32::consts::{FRAC_PI_2, PI};

fn put(scene: &mut Scene, shape: Shape, material: MaterialId, place: Transform) {
    scene.objects.push(Object::new(shape, material).transformed(&place));
}

fn at(x: f32, y: f32, z: f32) -> Transform {
    Transform::translate(Vec3::new(x, y, z))
}

fn rectangle(side: f32) -> Shape {
    Shape::Rectangle { size: Vec2::splat(side) }
}

/// A matte floor, and a lamp above it that faces along z, `side` 1, or against it, −1: none of its
/// light comes to what lies behind it.
fn floor_and_lamp(camera: Camera, radiance: Rgb, z: f32, side: f32) -> Scene {
    let mut scene = Scene::new(camera);
    let floor = scene.add_material(Matte::new(Rgb::new(0.8, 0.6, 0.4)));
    let lamp = scene.add_material(Emission::radiance(radiance));
    put(&mut scene, rectangle(40.0), floor, Transform::rotate(Vec3::X, -FRAC_PI_2));
    let turned = Transform::rotate(Vec3::Y, if side < 0.0 { PI } else { 0.0 });
    put(&mut scene, rectangle(0.5), lamp, at(0.2, 1.3, z) * turned);
    scene
}

/// Cameras that see nothing but the floor behind the lamp; of a map of everything around, in its
/// middle.
fn cameras() -> Vec<Camera> {
    let (eye, target) = (Vec3::new(0.1, 1.0, 1.1), Vec3::new(0.0, 0.0, 0.9));
    let mut perspective = Perspective::look_at(eye, target, 0.6).unwrap();
    let mut plan = Orthographic::look_at(eye, target, 0.6).unwrap();
    for lens in [&mut perspective.lens, &mut plan.lens] {
        (lens.aperture_radius, lens.focus_distance) = (0.05, 0.7);
    }
    let all_around = Equirectangular::look_at(eye, target).unwrap();
    vec![perspective.into(), plan.into(), all_around.into()]
}

/// A lamp that shines on a wide mirror lights what lies behind it as its image would: pixel by pixel
/// the caustic is the direct light of a lamp behind the wall. So every camera, filter and lens puts light where
/// it belongs, and all of it.
#[test]
fn a_mirror_lights_as_the_image_in_it() {
    for camera in cameras() {
        let all_around = matches!(camera, Camera::Equirectangular(_));
        let crop = all_around.then_some(Crop { x: 28, y: 14, width: 8, height: 4 });
        let (size, spp) = if all_around { ([64, 32], 32_768) } else { ([16, 12], 65_536) };
        for filter in
            [Filter::Box { radius: 0.5 }, Filter::Mitchell { radius: 2.0, b: 0.3, c: 0.3 }]
        {
            let settings = |spp| Settings { size, crop, filter, max_depth: Some(3), ..small(spp) };
            let radiance = Rgb::new(5.0, 6.0, 7.0);
            let mut mirrored = floor_and_lamp(camera, radiance, 0.35, -1.0);
            let mirror = mirrored.add_material(Mirror { reflectance: Rgb::new(1.0, 0.9, 0.5) });
            put(&mut mirrored, rectangle(60.0), mirror, Transform::IDENTITY);
            let image = floor_and_lamp(camera, Rgb::new(5.0, 6.0 * 0.9, 7.0 * 0.5), -0.35, 1.0);
            let (found, expected) =
                (render(&mirrored, settings(spp)), render(&image, settings(4096)));
            assert_same(&found, &expected, &format!("{camera:?} {filter:?}"));
        }
    }
}

/// Pixels differ no more than their noise, and all together by less than a part in two hundred.
fn assert_same(found: &Image, expected: &Image, what: &str) {
    let mut sum = 0.0;
    let mut count = 0.0;
    for channel in ["R", "G", "B"] {
        let (a, b) = (found.channel(channel).unwrap(), expected.channel(channel).unwrap());
        let variance = format!("variance.{channel}");
        let (va, vb) = (found.channel(&variance).unwrap(), expected.channel(&variance).unwrap());
        for i in 0..a.len() {
            let z = f64::from(a[i] - b[i]) / f64::from(va[i] + vb[i]).sqrt();
            assert!(z.abs() < 5.0, "{what}: pixel {i} of {channel}: {} for {}", a[i], b[i]);
            (sum, count) = (sum + z * z, count + 1.0);
        }
        assert_near(mean(found, channel), mean(expected, channel), 0.005, what);
    }
    // Channels of a pixel are nearly the same: a third as many independent numbers.
    assert!((sum / count - 1.0).abs() < 5.0 * (6.0 / count).sqrt(), "{what}: χ² {}", sum / count);
}

/// A ball of glass under a small lamp, and the floor around its shadow.
fn ball_of_glass() -> Scene {
    let camera = Perspective::look_at(Vec3::new(0.0, 1.6, 2.0), Vec3::new(0.1, 0.0, 0.1), 0.6);
    let mut scene = Scene::new(camera.unwrap());
    let floor = scene.add_material(Matte::new(Rgb::grey(0.7)));
    let glass = scene.add_material(Dielectric::new(1.5));
    let lamp = scene.add_material(Emission::radiance(Rgb::grey(10.0)));
    put(&mut scene, rectangle(40.0), floor, Transform::rotate(Vec3::X, -FRAC_PI_2));
    put(&mut scene, Shape::Sphere { radius: 0.3 }, glass, at(0.0, 0.5, 0.0));
    put(&mut scene, Shape::Sphere { radius: 0.2 }, lamp, at(-0.9, 2.4, -0.8));
    scene
}

/// The caustic of a ball of glass: as bright as chance finds it in the end, to half a percent, with
/// less than a twentieth of the variance that chance leaves with as many samples.
#[test]
fn a_caustic_is_bright_and_clean() {
    let scene = ball_of_glass();
    let settings = |spp| Settings { size: [24, 24], ..small(spp) };
    let with = render(&scene, settings(1024));
    let without = render(&scene, Settings { caustics: false, ..settings(1024) });
    // The scatter of what counts, the caustic; glass itself is left out.
    let noise = |image: &Image| {
        let pixels = image.channel("variance.G").unwrap().iter().enumerate();
        let floor = pixels.filter(|(i, _)| i / 24 > 14);
        floor.map(|(_, &v)| f64::from(v)).sum::<f64>()
    };
    let ratio = noise(&without) / noise(&with);
    assert!(ratio > 20.0, "{ratio} times as noisy");

    let chance = Settings { strategy: Strategy::BsdfOnly, ..settings(120_000) };
    let (chance, light) = (render(&scene, chance), render(&scene, settings(6000)));
    let ((a, a_error), (b, b_error)) = (mean(&chance, "G"), mean(&light, "G"));
    let error = (a_error * a_error + b_error * b_error).sqrt();
    assert!(error < 0.0025 * a, "too noisy to tell: {a} ± {error}");
    assert!((a - b).abs() < 0.005 * a && (a - b).abs() < 3.5 * error, "{b} for {a} ± {error}");
}

/// The variance that a picture tells is that of its pixels over many seeds, light paths included.
#[test]
fn the_told_variance_is_that_of_many_pictures() {
    let scene = Prepared::new(&ball_of_glass()).map(std::sync::Arc::new).unwrap();
    let seeds = 400;
    let pixels = 12 * 12;
    let (mut sums, mut squares, mut told) =
        (vec![0.0; pixels], vec![0.0; pixels], vec![0.0; pixels]);
    for seed in 0..seeds {
        let settings = Settings { size: [12, 12], seed, ..small(32) };
        let image = render_prepared(scene.clone(), settings);
        let (values, variances) =
            (image.channel("G").unwrap(), image.channel("variance.G").unwrap());
        for i in 0..pixels {
            let v = f64::from(values[i]);
            (sums[i], squares[i]) = (sums[i] + v, squares[i] + v * v);
            told[i] += f64::from(variances[i]);
        }
    }
    let n = seeds as f64;
    let seen = |i: usize| (squares[i] - sums[i] * sums[i] / n) / (n - 1.0);
    // The caustic, where most of the scatter is that of light paths.
    let caustic: Vec<usize> = (0..pixels).filter(|i| i / 12 > 7).collect();
    let (seen, told) = (
        caustic.iter().map(|&i| seen(i)).sum::<f64>(),
        caustic.iter().map(|&i| told[i] / n).sum::<f64>(),
    );
    assert!((told / seen - 1.0).abs() < 0.15, "{told} told, {seen} seen");
}

/// Where light paths have no part, nothing changes: without lamps, without clear surfaces, where
/// paths are too short, or where one way of finding light is asked for.
#[test]
fn nothing_else_changes() {
    let camera = cameras()[0];
    let plain = floor_and_lamp(camera, Rgb::WHITE, 0.5, 1.0);
    let glass = ball_of_glass();
    let sobol = |spp| Settings { sampler: SamplerKind::Sobol, ..small(spp) };
    for (scene, settings) in [
        (&plain, sobol(4)),
        (&glass, Settings { max_depth: Some(2), ..sobol(4) }),
        (&glass, Settings { strategy: Strategy::BsdfOnly, ..sobol(4) }),
        (&glass, Settings { strategy: Strategy::LightOnly, ..sobol(4) }),
    ] {
        let without = Settings { caustics: false, ..settings.clone() };
        assert_eq!(render(scene, settings).hash(), render(scene, without).hash());
    }
}

/// A small crop takes all light paths of the picture, and one is told so.
#[test]
fn a_small_crop_is_told_what_it_costs() {
    let scene = Prepared::new(&ball_of_glass()).unwrap();
    let crop = |side| Some(Crop { x: 0, y: 0, width: side, height: side });
    let notes = |side, caustics| {
        let settings = Settings { size: [100, 100], crop: crop(side), caustics, ..small(1) };
        scene.notes_for(&settings).len()
    };
    assert_eq!([notes(20, true), notes(20, false), notes(40, true)], [1, 0, 0]);
}

/// The glass ball and its floor, under a sky map with a small sun or under a lamp as large as that in
/// the sky, `distance` metres away, with a floor of this side.
fn lit_from_afar(distance: Option<f32>, side: f32) -> Scene {
    let mut scene = ball_of_glass();
    scene.objects.retain(|object| object.material != MaterialId(2));
    let floor = Object::new(rectangle(side), MaterialId(0));
    scene.objects[0] = floor.transformed(&Transform::rotate(Vec3::X, -FRAC_PI_2));
    if let Some(distance) = distance {
        let towards = Vec3::new(-0.36, 0.8, -0.48) * distance;
        let lamp = Shape::Sphere { radius: 0.05 * distance };
        put(&mut scene, lamp, MaterialId(2), Transform::translate(towards));
    } else {
        let pixel = |i| if (20..22).contains(&(i % 64)) && i / 64 == 6 { 60.0 } else { 0.05 };
        let pixels: Vec<[f32; 3]> = (0..64 * 32).map(|i| [pixel(i); 3]).collect();
        let map = scene.add_image(Image::from_rgb(64, 32, &pixels).unwrap());
        scene.environment = Some(Environment::image(map));
    }
    scene
}

/// Light from far away, by the numbers that a single-precision place has there, throws the caustic
/// that it throws from near by; under a sky map the floor may be as large as a country.
#[test]
fn light_from_far_away_throws_the_same_caustic() {
    let found = |distance, side| {
        mean(
            &render(&lit_from_afar(distance, side), Settings { size: [24, 24], ..small(4096) }),
            "G",
        )
    };
    let lamp = found(Some(100.0), 40.0);
    for distance in [1e5, 1e7, 1e9] {
        assert_near(found(Some(distance), 40.0), lamp, 0.002, &format!("{distance} m"));
    }
    let sky = found(None, 40.0);
    for side in [1e3, 1e6] {
        assert_near(found(None, side), sky, 0.002, &format!("a floor of {side} m"));
    }
}

/// Two means with their errors are the same; both together are known to this part of them.
fn assert_near((a, a_error): (f64, f64), (b, b_error): (f64, f64), known: f64, what: &str) {
    let error = (a_error * a_error + b_error * b_error).sqrt();
    assert!(error < known * b, "{what}: too noisy to tell: {a} for {b} ± {error}");
    assert!((a - b).abs() < 3.5 * error, "{what}: {a} for {b} ± {error}");
}

/// Beside a tiny lamp of enormous radiance, as people make point lights, the sums of light paths
/// are still fine enough for the light of the others: rounding makes no sparks.
#[test]
fn a_tiny_lamp_leaves_the_others_their_caustics() {
    let brightest = |scene: &Scene| {
        let image = render(scene, Settings { size: [24, 24], ..small(256) });
        image.channel("G").unwrap().iter().copied().fold(0.0, f32::max)
    };
    let mut scene = ball_of_glass();
    let alone = brightest(&scene);
    let tiny = scene.add_material(Emission::radiance(Rgb::grey(2e12)));
    put(&mut scene, Shape::Sphere { radius: 1e-8 }, tiny, at(0.5, 1.5, -0.3));
    let both = brightest(&scene);
    assert!(both < 2.0 * alone, "{both} {alone}");
}

/// Caustics change no mean: that of the scene with them is that without, but for this part of it.
fn assert_mean_stays(scene: &Scene, size: [u32; 2], spp: u64, part: f64) {
    let settings = Settings { size, sampler: SamplerKind::Sobol, ..small(spp) };
    let with = mean(&render(scene, settings.clone()), "G");
    let without = mean(&render(scene, Settings { caustics: false, ..settings }), "G");
    assert!((with.0 / without.0 - 1.0).abs() < part, "{with:?} {without:?}");
}

/// An eye that lies in the plane of the floor, as one at height 0 does, sees the caustics on a wall:
/// the floor that it lies on is not in their way.
#[test]
fn an_eye_on_the_floor_sees_caustics() {
    let camera = Perspective::look_at(Vec3::Z * 3.0, Vec3::new(0.0, 0.8, -2.0), 0.87).unwrap();
    let mut scene = Scene::new(camera);
    let white = scene.add_material(Matte::new(Rgb::grey(0.7)));
    let mirror = scene.add_material(Mirror { reflectance: Rgb::grey(0.9) });
    let lamp = scene.add_material(Emission::radiance(Rgb::grey(10.0)));
    let (up, down) =
        (Transform::rotate(Vec3::X, -FRAC_PI_2), Transform::rotate(Vec3::X, FRAC_PI_2));
    // A turned rectangle is rounded off the plane.
    let corners = [[-3.0, 3.0], [3.0, 3.0], [3.0, -3.0], [-3.0, -3.0]];
    let floor = scene.add_mesh(Mesh {
        positions: corners.map(|[x, z]| Vec3::new(x, 0.0, z)).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    });
    put(&mut scene, Shape::Mesh(floor), white, Transform::IDENTITY);
    put(&mut scene, rectangle(4.0), white, at(0.0, 1.5, -2.0));
    put(&mut scene, rectangle(1.5), mirror, at(0.0, 0.01, -0.8) * up);
    put(&mut scene, rectangle(0.6), lamp, at(0.0, 2.0, 0.5) * down);
    assert_mean_stays(&scene, [16, 12], 16_384, 0.015);
}

/// A lamp that goes through the wall of dark glass shines into the glass and out into the open: each
/// of its points knows what it stands in.
#[test]
fn a_lamp_may_stand_half_in_dark_glass() {
    let camera = Perspective::look_at(Vec3::new(0.3, 1.5, 3.0), Vec3::new(0.3, 0.3, 0.0), 0.8);
    let mut scene = Scene::new(camera.unwrap());
    let floor = scene.add_material(Matte::new(Rgb::grey(0.7)));
    let glass = scene.add_material(Dielectric::new(1.5));
    let mut dark = Dielectric::new(1.5);
    dark.interior.absorption = Absorption::Coefficient(Rgb::grey(5.0));
    let dark = scene.add_material(dark);
    let lamp = scene.add_material(Emission::radiance(Rgb::grey(40.0)));
    let down = Transform::rotate(Vec3::X, FRAC_PI_2);
    put(&mut scene, rectangle(20.0), floor, Transform::rotate(Vec3::X, -FRAC_PI_2));
    let block = Shape::Box { size: Vec3::new(2.0, 1.0, 1.0) };
    put(&mut scene, block, dark, at(-1.0, 0.9, 0.0));
    put(&mut scene, Shape::Sphere { radius: 0.3 }, glass, at(0.8, 0.5, 0.0));
    let strip = Shape::Rectangle { size: Vec2::new(1.6, 0.3) };
    put(&mut scene, strip, lamp, at(0.0, 1.2, 0.0) * down);
    assert_mean_stays(&scene, [16, 12], 32_768, 0.015);
}

/// A ball of dark glass just touches the middle of a lamp's beam. It is not taken to be around the
/// lamp: what it mirrors is as bright as chance finds it.
#[test]
fn glass_beside_a_lamp_is_not_around_it() {
    let camera = Perspective::look_at(Vec3::new(0.0, 1.5, 3.0), Vec3::new(0.0, 0.3, 0.0), 0.7);
    let mut scene = Scene::new(camera.unwrap());
    let floor = scene.add_material(Matte::new(Rgb::grey(0.7)));
    let mut dark = Dielectric::new(1.5);
    dark.interior.absorption = Absorption::Coefficient(Rgb::grey(1e6));
    let dark = scene.add_material(dark);
    let lamp = scene.add_material(Emission::radiance(Rgb::grey(10.0)));
    put(&mut scene, rectangle(20.0), floor, Transform::rotate(Vec3::X, -FRAC_PI_2));
    put(&mut scene, Shape::Sphere { radius: 0.5 }, dark, at(0.0, 0.7, 0.0));
    let downward = Transform::rotate(Vec3::X, FRAC_PI_2);
    put(&mut scene, rectangle(1.0), lamp, at(0.5, 3.0, 0.0) * downward);
    assert_mean_stays(&scene, [48, 36], 1024, 0.003);
}
