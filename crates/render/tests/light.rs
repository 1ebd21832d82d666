//! Proofs over all emitters. A new one joins by a line in `all`.

#![expect(clippy::disallowed_methods, reason = "expected values are computed in f64")]

mod common;

use common::{
    chi_square_of_steps, family_wise, integrate_sphere, mean, random, render, small, well_spread,
};
use rutilant::Prepared;
use rutilant::camera::Perspective;
use rutilant::color::{Rgb, Spectrum};
use rutilant::geom::{DVec3, Ray, Transform, Vec2, Vec3};
use rutilant::image::Image;
use rutilant::light::{Emitter, Environment, Light, Projection, SpotLight};
use rutilant::material::{Emission, EmittedLight, Matte};
use rutilant::math::warp;
use rutilant::scene::{ImageId, Scene};
use rutilant::settings::{SamplerKind, Settings, Strategy};
use rutilant::shape::{Mesh, Object, Shape};
use std::sync::Arc;

fn empty() -> Scene {
    Scene::new(Perspective::look_at(Vec3::ZERO, Vec3::NEG_Z, 1.0).unwrap())
}

/// A scene whose only emitters are one glowing shape's.
fn glowing(shape: Shape, place: Transform, two_sided: bool) -> Scene {
    let mut scene = empty();
    let glow = Emission { two_sided, ..Emission::radiance(Rgb::new(1.0, 2.0, 3.0)) };
    let lamp = scene.add_material(glow);
    if shape == Shape::Mesh(rutilant::scene::MeshId(0)) {
        scene.add_mesh(Mesh {
            positions: vec![
                Vec3::new(-0.5, -0.3, 0.0),
                Vec3::new(0.9, 0.0, 0.2),
                Vec3::new(0.1, 0.8, -0.1),
            ],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        });
    }
    scene.objects.push(Object::new(shape, lamp).transformed(&place));
    scene
}

/// A map with a few bright texels, a dark row, and light at both poles and on the seam.
fn sky(width: u32, height: u32) -> Image {
    let pixels: Vec<[f32; 3]> = (0..width * height)
        .map(|i| match (i % width, i / width) {
            (x, y) if (x, y) == (width / 3, height / 4) => [40.0, 30.0, 20.0],
            (0, y) if y == height / 2 => [0.0, 0.0, 8.0],
            (_, 0) => [1.0, 0.5, 0.2],
            (_, y) if y == height - 1 => [0.3; 3],
            (_, y) if y == 2 * height / 3 => [0.0; 3],
            (x, y) => [0.1 + 0.01 * x as f32, 0.2, 0.02 * y as f32],
        })
        .collect();
    Image::from_rgb(width, height, &pixels).unwrap()
}

fn under(mut environment: Environment, rotation: f32, image: Option<Image>) -> Scene {
    let mut scene = empty();
    environment.rotation = rotation;
    scene.images.extend(image.map(Arc::new));
    scene.environment = Some(environment);
    scene
}

/// Every way to lay a sky on a picture, with sizes of the picture.
fn projections() -> [(&'static str, Projection, [u32; 2]); 10] {
    [
        ("latitude and longitude", Projection::Equirectangular, [24, 12]),
        ("uneven latitude and longitude", Projection::Equirectangular, [7, 5]),
        ("one pixel of latitude", Projection::Equirectangular, [1, 1]),
        ("octahedron", Projection::Octahedral, [16, 16]),
        ("uneven octahedron", Projection::Octahedral, [7, 7]),
        ("lying cross", Projection::Cube, [32, 24]),
        ("upright cross", Projection::Cube, [24, 32]),
        ("strip", Projection::Cube, [42, 7]),
        ("upright strip", Projection::Cube, [8, 48]),
        ("six pixels of a cube", Projection::Cube, [6, 1]),
    ]
}

/// A sky from a picture, on its own.
fn mapped(projection: Projection, image: Image, rotation: f32) -> Scene {
    under(Environment::map(ImageId(0), projection), rotation, Some(image))
}

fn sky_of(scene: &Prepared) -> &rutilant::light::EnvironmentEmitter {
    match &scene.emitters()[0] {
        Emitter::Environment(sky) => sky,
        other => panic!("the sky is the only emitter, not {other:?}"),
    }
}

/// The direction that a place of a picture shows, in f64; in pixels from the upper left corner.
/// `None` where a cross is empty.
fn shown(projection: Projection, [width, height]: [u32; 2], at: [f64; 2]) -> Option<DVec3> {
    let pi = std::f64::consts::PI;
    let [u, v] = [at[0] / f64::from(width), at[1] / f64::from(height)];
    match projection {
        Projection::Equirectangular => {
            let (theta, phi) = (pi * v, pi * (2.0 * u - 1.0));
            let away = theta.sin();
            Some(DVec3::new(away * phi.sin(), theta.cos(), -away * phi.cos()))
        }
        Projection::Octahedral => {
            // Rings of |x| + |y| = r around the middle, each part of them in proportion to its
            // angle, and the area within in proportion to the solid angle.
            let (x, y) = (2.0 * u - 1.0, 2.0 * v - 1.0);
            let upper = x.abs() + y.abs() <= 1.0;
            let (x1, y1) = if upper { (x.abs(), y.abs()) } else { (1.0 - y.abs(), 1.0 - x.abs()) };
            let r = x1 + y1;
            let phi = if r > 0.0 { 0.5 * pi * y1 / r } else { 0.0 };
            let up = if upper { 1.0 - r * r } else { r * r - 1.0 };
            let away = (1.0 - up * up).max(0.0).sqrt();
            let (sx, sy) = (x.signum(), y.signum());
            Some(DVec3::new(away * phi.cos() * sx, up, away * phi.sin() * sy))
        }
        Projection::Cube => {
            let places: &[&str] = match (3 * width).cmp(&(4 * height)) {
                std::cmp::Ordering::Equal => &[" T  ", "LFRB", " D  "],
                _ if 4 * width == 3 * height => &[" T ", "LFR", " D ", " U "],
                std::cmp::Ordering::Greater => &["RLTDFB"],
                std::cmp::Ordering::Less => &["R", "L", "T", "D", "F", "B"],
            };
            let side = f64::from(width) / places[0].len() as f64;
            let place = at.map(|a| (a / side).floor());
            let (s, t) =
                (2.0 * (at[0] / side - place[0]) - 1.0, 2.0 * (at[1] / side - place[1]) - 1.0);
            let d = match places[place[1] as usize].as_bytes()[place[0] as usize] {
                b'R' => DVec3::new(1.0, -t, -s),
                b'L' => DVec3::new(-1.0, -t, s),
                b'T' => DVec3::new(s, 1.0, t),
                b'D' => DVec3::new(s, -1.0, -t),
                b'F' => DVec3::new(s, -t, 1.0),
                b'B' => DVec3::new(-s, -t, -1.0),
                // The same face on its head.
                b'U' => DVec3::new(s, t, -1.0),
                _ => return None,
            };
            Some(d.normalize())
        }
    }
}

/// A picture of `size` pixels of what `light` is in each direction.
fn painted(projection: Projection, size: [u32; 2], light: impl Fn(DVec3) -> [f64; 3]) -> Image {
    let center = |i: u32| [f64::from(i % size[0]) + 0.5, f64::from(i / size[0]) + 0.5];
    let pixel = |i| shown(projection, size, center(i)).map_or([0.0; 3], &light).map(|c| c as f32);
    let pixels: Vec<[f32; 3]> = (0..size[0] * size[1]).map(pixel).collect();
    Image::from_rgb(size[0], size[1], &pixels).unwrap()
}

/// What a single pixel of radiance 1 adds to an integral over all directions, of one of `values`
/// each: its bilinear tent, integrated in f64. The pixels around it lie in the same chart.
fn of_one_pixel<const N: usize>(
    projection: Projection,
    size: [u32; 2],
    [column, row]: [u32; 2],
    values: impl Fn(DVec3) -> [f64; N],
) -> [f64; N] {
    let (steps, h) = (400, 1e-4);
    let mut sum = [0.0; N];
    for i in 0..steps * steps {
        let offset =
            [i % steps, i / steps].map(|i| 2.0 * (f64::from(i) + 0.5) / f64::from(steps) - 1.0);
        let at = [f64::from(column) + 0.5 + offset[0], f64::from(row) + 0.5 + offset[1]];
        let near = |dx, dy| shown(projection, size, [at[0] + dx, at[1] + dy]).unwrap();
        let (along_x, along_y) = (near(h, 0.0) - near(-h, 0.0), near(0.0, h) - near(0.0, -h));
        let solid_angle = along_x.cross(along_y).length() / (4.0 * h * h);
        let tent = (1.0 - offset[0].abs()) * (1.0 - offset[1].abs());
        let share = tent * solid_angle * 4.0 / f64::from(steps * steps);
        for (sum, value) in sum.iter_mut().zip(values(near(0.0, 0.0))) {
            *sum += share * value;
        }
    }
    sum
}

/// Every kind of emitter with a density, as a scene in which it is emitter 0, and a point it shines on.
fn all() -> Vec<(&'static str, Scene, Vec3)> {
    let at = |x, y, z| Transform::translate(Vec3::new(x, y, z));
    let tilted = at(0.2, 1.0, -1.5) * Transform::rotate(Vec3::new(1.0, 0.5, 0.2), 1.0);
    let mesh = Shape::Mesh(rutilant::scene::MeshId(0));
    let rectangle = || Shape::Rectangle { size: Vec2::new(0.8, 1.4) };
    let turned = |(name, projection, [width, height]): (_, _, [u32; 2])| {
        (name, mapped(projection, sky(width, height), 2.0), Vec3::ZERO)
    };
    let mut all = vec![
        ("triangle", glowing(mesh.clone(), at(0.0, 0.0, -1.0), false), Vec3::new(0.1, 0.2, 0.3)),
        (
            "triangle from behind",
            glowing(mesh.clone(), at(0.0, 0.0, -1.0), true),
            Vec3::new(0.1, 0.2, -3.0),
        ),
        ("rectangle", glowing(rectangle(), tilted, true), Vec3::ZERO),
        (
            "sheared rectangle",
            glowing(rectangle(), tilted * Transform::scale(Vec3::new(2.0, -0.5, 1.0)), true),
            Vec3::ZERO,
        ),
        ("near triangle", glowing(mesh, at(0.1, 0.2, -0.1), false), Vec3::new(0.1, 0.2, 0.05)),
        ("near rectangle", glowing(rectangle(), tilted, true), Vec3::new(0.0, 0.6, -1.2)),
        ("rectangle edge-on", glowing(rectangle(), at(0.1, 0.0, -0.02), false), Vec3::X),
        (
            "near tube",
            glowing(Shape::Rectangle { size: Vec2::new(3.0, 0.04) }, at(0.8, 0.1, -0.1), false),
            Vec3::ZERO,
        ),
        (
            "near sheared rectangle",
            glowing(rectangle(), tilted * Transform::scale(Vec3::new(2.0, -0.5, 1.0)), true),
            Vec3::new(0.3, 0.8, -1.4),
        ),
        ("disk", glowing(Shape::Disk { radius: 0.7 }, tilted, true), Vec3::ZERO),
        (
            "ellipse",
            glowing(
                Shape::Disk { radius: 0.7 },
                tilted * Transform::scale(Vec3::new(-2.0, 0.5, 1.0)),
                true,
            ),
            Vec3::ZERO,
        ),
        ("sphere", glowing(Shape::Sphere { radius: 1.0 }, at(0.0, 0.5, -2.0), false), Vec3::ZERO),
        (
            "near sphere",
            glowing(Shape::Sphere { radius: 1.0 }, at(0.0, 0.0, -1.01), false),
            Vec3::ZERO,
        ),
        (
            "sphere from inside",
            glowing(Shape::Sphere { radius: 1.0 }, at(0.0, 0.3, -0.5), true),
            Vec3::ZERO,
        ),
        ("constant sky", under(Environment::constant(Rgb::WHITE), 0.0, None), Vec3::ZERO),
        ("sky map", mapped(Projection::Equirectangular, sky(24, 12), 0.0), Vec3::ZERO),
    ];
    all.extend(projections().map(turned));
    all
}

/// The density of the direction `wi` from `from`: that of the emitter where the ray meets it.
fn pdf(scene: &Prepared, from: Vec3, wi: Vec3) -> f32 {
    let emitter = &scene.emitters()[0];
    if matches!(emitter, Emitter::Environment(_)) {
        return emitter.pdf(from, wi, Vec3::ZERO, Vec3::ZERO);
    }
    scene
        .closest(&Ray::new(from, wi))
        .map_or(0.0, |hit| emitter.pdf(from, wi, hit.position, hit.normal))
}

/// Directions to lights follow the density that scattered rays are weighted against: a lost
/// selection probability or a wrong area (the old program's ½(1 − cos θ) a b) shows here.
#[test]
fn samples_follow_the_density() {
    let all = all();
    let level = family_wise(all.len());
    for (stream, (name, scene, from)) in all.iter().enumerate() {
        let scene = Prepared::new(scene).unwrap();
        let sample = |_, u| scene.emitters()[0].sample(*from, u).map(|s| s.wi);
        let p = chi_square_of_steps(100 + stream as u64, sample, |wi| pdf(&scene, *from, wi));
        assert!(p > level, "{name}: p = {p:e}");
    }
}

/// What sampling says of a direction, its radiance and its density, is what a ray finds there.
/// The end of the shadow ray lies short of the light, so that the light does not shade itself.
#[test]
fn rays_find_what_sampling_promised() {
    for (name, scene, from) in all() {
        let prepared = Prepared::new(&scene).unwrap();
        let mut bent = 0;
        for i in 0..2000 {
            let (_, u) = random(21, i);
            let Some(s) = prepared.emitters()[0].sample(from, u) else { continue };
            assert!(!prepared.occluded(&s.shadow_ray(from)), "{name}: {s:?} shades itself");
            let there = pdf(&prepared, from, s.wi);
            // At the very rim a ray may just miss, and a texel's border may be rounded across.
            bent += usize::from((there - s.pdf).abs() > 2e-3 * s.pdf);
        }
        assert!(bent <= 12, "{name}: {bent} of 2000 densities differ");
    }
}

/// From nearby, where a lamp's parts are seen at all angles and from all distances, triangles and
/// rectangles are sampled evenly over the solid angle that they fill: what arrives at a surface has
/// the noise of its cosine alone.
#[test]
fn near_lamps_are_sampled_evenly() {
    let names = ["near triangle", "near rectangle", "near tube", "near sheared rectangle"];
    for (name, scene, from) in all().into_iter().filter(|(name, ..)| names.contains(name)) {
        let scene = Prepared::new(&scene).unwrap();
        let pdfs = (0..1000).filter_map(|i| scene.emitters()[0].sample(from, random(23, i).1));
        let pdfs: Vec<f32> = pdfs.map(|s| s.pdf).collect();
        assert!(pdfs.len() > 990, "{name}: {} of 1000", pdfs.len());
        assert!(pdfs.iter().all(|pdf| *pdf == pdfs[0]), "{name}: {pdfs:?}");
    }
}

/// Seen from afar no lamp stands in its own light, wherever it and the lit point are: the way to
/// it is rounded at the scale of the distance, which may be much more than that of the lamp's own
/// coordinates. A lamp at the scene's origin once lost up to half of its light.
#[test]
fn no_lamp_shades_itself_at_any_distance() {
    let at = |x, y, z| Transform::translate(Vec3::new(x, y, z));
    let tilted = Transform::rotate(Vec3::new(1.0, 0.5, 0.2), 1.0);
    let ball = |radius| Shape::Sphere { radius };
    let screen = || Shape::Rectangle { size: Vec2::new(6.0, 4.0) };
    let lamps = [
        (ball(0.1), Transform::IDENTITY),
        (ball(1.0), Transform::IDENTITY),
        (ball(0.15), at(0.0, 3.0, 0.0)),
        (ball(0.15), at(1.0, 3.0, 1.0)),
        (ball(1e-3), at(0.0, 0.01, 0.0)),
        (screen(), tilted),
        (Shape::Disk { radius: 2.0 }, tilted),
        (Shape::Mesh(rutilant::scene::MeshId(0)), tilted),
        (screen(), at(500.0, 0.1, -300.0) * tilted),
    ];
    let points = [[3.0, 2.0, 1.0], [7.0, -5.0, 5.0], [70.0, -50.0, 50.0], [10.0, 0.0, 7.0]];
    let far_points = [[40.0, 0.0, 27.0], [100.0, 0.0, 97.0], [-3e3, 1e3, 2e3], [1e6, 3e5, -1e6]];
    for (shape, place) in lamps {
        let scene = Prepared::new(&glowing(shape.clone(), place, true)).unwrap();
        for from in points.into_iter().chain(far_points).map(Vec3::from) {
            for i in 0..2000 {
                let (choice, u) = random(41, i);
                let emitters = scene.emitters();
                let emitter = &emitters[(choice * emitters.len() as f32) as usize];
                let Some(s) = emitter.sample(from, u) else { continue };
                let ray = s.shadow_ray(from);
                assert!(!scene.occluded(&ray), "{shape:?} from {from}: {s:?}");
            }
        }
    }
}

/// The irradiance of every light whose closed form is known, within 0.1 %.
#[test]
fn irradiance_has_its_closed_form() {
    let pi = std::f64::consts::PI;
    let facing = |z: f32| {
        Transform::translate(Vec3::new(0.0, 0.0, z))
            * Transform::rotate(Vec3::X, std::f32::consts::PI)
    };
    let point = |light| {
        let mut scene = empty();
        scene.lights.push(light);
        scene
    };
    let spot = |[inner, outer]: [f32; 2]| Light::Spot {
        position: Vec3::new(0.0, 0.0, 3.0),
        direction: Vec3::new(0.0, 0.0, -5.0),
        light: SpotLight::Intensity(Rgb::WHITE),
        inner,
        outer,
        group: None,
    };
    // Turned so that the origin is where the cosine is the mean of those of 0.2 and 0.6.
    let lean = (0.5 * (0.2_f64.cos() + 0.6_f64.cos())).acos();
    let leaning = Light::Spot {
        position: Vec3::new(3.0 * lean.sin() as f32, 0.0, 3.0 * lean.cos() as f32),
        direction: Vec3::NEG_Z,
        light: SpotLight::Intensity(Rgb::WHITE),
        inner: 0.2,
        outer: 0.6,
        group: None,
    };
    // A rectangle of sides 2a, 2b at distance 1, seen from below its centre: four quarters of the
    // textbook form factor.
    let quarter = |a: f64, b: f64| {
        let (x, y) = ((1.0 + a * a).sqrt(), (1.0 + b * b).sqrt());
        (a / x * (b / x).atan() + b / y * (a / y).atan()) / (2.0 * pi)
    };
    let even = |(name, projection, [width, height]): (_, _, [u32; 2])| {
        let white = vec![[1.0; 3]; (width * height) as usize];
        (name, mapped(projection, Image::from_rgb(width, height, &white).unwrap(), 1.0), pi)
    };
    let cases = [
        ("sphere", glowing(Shape::Sphere { radius: 0.5 }, facing(2.0), false), pi * 0.0625),
        ("tiny sphere", glowing(Shape::Sphere { radius: 1e-3 }, facing(2.0), false), pi * 0.25e-6),
        ("huge sphere", glowing(Shape::Sphere { radius: 1e4 }, facing(1.25e4), false), pi * 0.64),
        ("disk", glowing(Shape::Disk { radius: 0.5 }, facing(1.0), false), pi * 0.2),
        (
            "rectangle",
            glowing(Shape::Rectangle { size: Vec2::new(2.0, 1.0) }, facing(1.0), false),
            4.0 * pi * quarter(1.0, 0.5),
        ),
        (
            "point",
            point(Light::Point {
                position: Vec3::new(0.0, 0.0, 3.0),
                intensity: Rgb::WHITE,
                group: None,
            }),
            1.0 / 9.0,
        ),
        (
            "directional",
            point(Light::Directional {
                direction: Vec3::new(0.0, 3.0, -4.0),
                irradiance: Rgb::WHITE,
                group: None,
            }),
            0.8,
        ),
        ("sky", under(Environment::constant(Rgb::WHITE), 0.0, None), pi),
        ("spot on its axis", point(spot([0.1, 0.4])), 1.0 / 9.0),
        ("spot at its edge", point(leaning), 0.5 * lean.cos() / 9.0),
    ];
    for (name, scene, expected) in cases.into_iter().chain(projections().map(even)) {
        let scene = Prepared::new(&scene).unwrap();
        let n = 1000_u32;
        let mut sum = 0.0;
        for i in 0..n * n {
            let (_, u) = well_spread(u64::from(i));
            if let Some(s) = scene.emitters()[0].sample(Vec3::ZERO, u) {
                let [red, ..] = s.radiance.channels();
                sum += f64::from(red * s.wi.z.max(0.0) / s.pdf);
            }
        }
        let irradiance = sum / f64::from(n * n);
        assert!(
            (irradiance / expected - 1.0).abs() < 1e-3,
            "{name}: {irradiance}, expected {expected}"
        );
    }
}

/// One bright texel of any map shines from its own direction with its own solid angle: a mirrored
/// or turned map, or a density that lacks its Jacobian, shows here.
#[test]
fn one_texel_shines_from_its_place() {
    for (projection, size, texel) in [
        (Projection::Equirectangular, [64, 32], [40, 5]),
        (Projection::Octahedral, [64, 64], [37, 22]),
        (Projection::Octahedral, [64, 64], [9, 6]),
        (Projection::Cube, [64, 48], [42, 19]),
        (Projection::Cube, [48, 64], [20, 57]),
        (Projection::Cube, [96, 16], [39, 3]),
        (Projection::Cube, [16, 96], [12, 88]),
    ] {
        let mut pixels = vec![[0.0; 3]; (size[0] * size[1]) as usize];
        pixels[(texel[1] * size[0] + texel[0]) as usize] = [100.0; 3];
        let image = Image::from_rgb(size[0], size[1], &pixels).unwrap();
        let scene = Prepared::new(&mapped(projection, image, 0.0)).unwrap();
        let n = 200_000;
        let (mut sum, mut mean) = (0.0, DVec3::ZERO);
        for i in 0..n {
            let (_, u) = random(31, i);
            let Some(s) = scene.emitters()[0].sample(Vec3::ZERO, u) else { continue };
            let [red, ..] = s.radiance.channels();
            sum += f64::from(red / s.pdf) / n as f64;
            mean += s.wi.as_dvec3() * f64::from(red / s.pdf);
        }
        let [x, y, z, solid_angle] =
            of_one_pixel(projection, size, texel, |d| [d.x, d.y, d.z, 1.0]);
        let (expected, center) = (100.0 * solid_angle, DVec3::new(x, y, z).normalize());
        assert!((sum / expected - 1.0).abs() < 0.01, "{projection:?} {texel:?}: {sum} {expected}");
        let off = mean.normalize().dot(center);
        assert!(off > 0.9999, "{projection:?} {texel:?}: {} {center}", mean.normalize());
    }
}

/// The same smooth sky in every projection looks the same in every direction, on seams, edges and
/// corners as well: a face in the wrong place, a border from the wrong neighbour, or half a pixel
/// of shift shows here. Interpolation is off by the square of a pixel's angle, but where lines of
/// pixels have a kink it is by a part of half a pixel's: 9e-3 at the folds of these octahedra,
/// 4e-3 (along the edge) at the edges of these cubes, times a slope below 1.
#[test]
fn every_projection_shows_the_same_sky() {
    let light = |d: DVec3| [1.0 + 0.6 * d.x + 0.3 * d.y * d.z, 1.0 + 0.7 * d.y, 1.0 - 0.5 * d.z];
    for (projection, size, most) in [
        (Projection::Equirectangular, [256, 128], 1e-3),
        (Projection::Octahedral, [192, 192], 1e-2),
        (Projection::Octahedral, [193, 193], 1e-2),
        (Projection::Cube, [256, 192], 4e-3),
        (Projection::Cube, [192, 256], 4e-3),
        (Projection::Cube, [390, 65], 4e-3),
        (Projection::Cube, [64, 384], 4e-3),
    ] {
        let image = painted(projection, size, light);
        let scene = Prepared::new(&mapped(projection, image, 0.0)).unwrap();
        let error = |d: Vec3| {
            let seen = sky_of(&scene).radiance(d).channels().map(f64::from);
            let errors = seen.into_iter().zip(light(d.as_dvec3())).map(|(s, l)| (s - l).abs());
            errors.fold(0.0, f64::max)
        };
        let n = 20_000;
        let anywhere = (0..n).map(|i| warp::uniform_sphere(random(81, i).1));
        let rms = (anywhere.map(|d| error(d).powi(2)).sum::<f64>() / n as f64).sqrt();
        println!("{projection:?} {size:?}: {rms:.1e}");
        assert!(rms < 5e-4, "{projection:?} {size:?}: {rms}");
        // Between any two of 26 directions to a cube's corners, edges and faces.
        let sign = |i: u8| f32::from(i % 3) - 1.0;
        let corners = || (0..27).map(move |i| Vec3::new(sign(i), sign(i / 3), sign(i / 9)));
        let lines = corners().flat_map(|a| corners().map(move |b| a + 0.37 * b));
        for d in corners().chain(lines).filter_map(Vec3::try_normalize) {
            assert!(error(d) < most, "{projection:?} {size:?} {d}: {}", error(d));
        }
    }
}

/// The map's directions: up is the first row, −z the middle, +x right of it; nothing is read
/// outside the map at the seam and at the poles, where the old program's index was one too far.
#[test]
fn directions_meet_their_texels_at_seam_and_poles() {
    let (width, height) = (8, 4);
    let pixels: Vec<[f32; 3]> =
        (0..width * height).map(|i| [(i % width) as f32, (i / width) as f32, 1.0]).collect();
    let image = Image::from_rgb(width, height, &pixels).unwrap();
    let scene = under(Environment::image(rutilant::scene::ImageId(0)), 0.0, Some(image));
    let scene = Prepared::new(&scene).unwrap();
    let Emitter::Environment(sky) = &scene.emitters()[0] else {
        panic!("the sky is the only emitter")
    };
    let look = |x: f32, y: f32, z: f32| sky.radiance(Vec3::new(x, y, z).normalize()).channels();
    let near = |got: [f32; 3], column: f32, row: f32| {
        (got[0] - column).abs() < 1e-3 && (got[1] - row).abs() < 1e-3
    };
    assert!(near(look(0.0, 0.0, -1.0), 3.5, 1.5), "{:?}", look(0.0, 0.0, -1.0));
    assert!(near(look(1.0, 0.0, 0.0), 5.5, 1.5), "{:?}", look(1.0, 0.0, 0.0));
    assert!(near(look(-1.0, 0.0, 0.0), 1.5, 1.5), "{:?}", look(-1.0, 0.0, 0.0));
    // The seam: half way between the last column and the first.
    assert!(near(look(0.0, 0.0, 1.0), 3.5, 1.5), "{:?}", look(0.0, 0.0, 1.0));
    assert!(near(look(-0.0, 0.0, 1.0), 3.5, 1.5), "{:?}", look(-0.0, 0.0, 1.0));
    assert!(near(look(-1e-30, 0.0, 1.0), 3.5, 1.5), "{:?}", look(-1e-30, 0.0, 1.0));
    // The poles: the mean of opposite columns of the first and last row.
    let (top, bottom) = (look(0.0, 1.0, 0.0), look(0.0, -1.0, 0.0));
    assert!(
        top[1] == 0.0 && bottom[1] == 3.0 && top[2] == 1.0 && bottom[2] == 1.0,
        "{top:?} {bottom:?}"
    );
    for d in [Vec3::new(1e-30, 1.0, 0.0), Vec3::new(0.0, -1.0, 1e-38), Vec3::new(-1e-7, 1.0, 1e-7)]
    {
        assert!(sky.radiance(d).is_finite() && sky.pdf(d).is_finite());
    }
}

/// Broken pixels of a map give no light and spoil nothing; they are counted.
#[test]
fn broken_pixels_are_mended_and_counted() {
    let pixels = [[1.0; 3], [f32::NAN, 1.0, 1.0], [f32::INFINITY; 3], [-5.0, 1.0, 1.0]];
    let image = Image::from_rgb(2, 2, &pixels).unwrap();
    let scene = under(Environment::image(rutilant::scene::ImageId(0)), 0.0, Some(image));
    let scene = Prepared::new(&scene).unwrap();
    assert!(
        scene
            .report()
            .notes
            .iter()
            .any(|n| n.to_string().starts_with("environment: 3 of its pixels")),
        "{:?}",
        scene.report().notes
    );
    for i in 0..1000 {
        let s = scene.emitters()[0].sample(Vec3::ZERO, random(1, i).1);
        assert!(s.is_none_or(
            |s| s.radiance.is_finite() && s.radiance.channels().iter().all(|&c| c >= 0.0)
        ));
    }
}

/// The power of a lamp is what it was given, however it is scaled and on how many sides it shines.
#[test]
fn power_is_what_was_asked_for() {
    for two_sided in [false, true] {
        for shape in [
            Shape::Sphere { radius: 0.3 },
            Shape::Box { size: Vec3::new(1.0, 2.0, 3.0) },
            Shape::Rectangle { size: Vec2::ONE },
        ] {
            let mut scene = empty();
            let light = EmittedLight::Power(Rgb::new(60.0, 50.0, 40.0));
            let lamp =
                scene.add_material(Emission { light, two_sided, ..Emission::radiance(Rgb::WHITE) });
            scene.objects.push(
                Object::new(shape.clone(), lamp).transformed(&Transform::scale(Vec3::splat(3.0))),
            );
            let scene = Prepared::new(&scene).unwrap();
            let total = scene.emitters().iter().fold(Spectrum::BLACK, |sum, e| sum + e.power(1.0));
            for (got, expected) in total.channels().into_iter().zip([60.0, 50.0, 40.0]) {
                assert!((got / expected - 1.0).abs() < 1e-4, "{shape:?}: {total:?}");
            }
        }
    }
}

/// Every light within a scene, as a scene whose emitters are that light alone.
fn all_finite() -> Vec<(&'static str, Scene)> {
    let with = |light| {
        let mut scene = empty();
        scene.lights.push(light);
        scene
    };
    let spot = |light, inner: f32, outer: f32| Light::Spot {
        position: Vec3::new(0.1, -0.2, 0.3),
        direction: Vec3::new(1.0, 2.0, -0.5),
        light,
        inner: inner.to_radians(),
        outer: outer.to_radians(),
        group: None,
    };
    let intensity = || SpotLight::Intensity(Rgb::new(1.0, 2.0, 3.0));
    let power = SpotLight::Power(Rgb::new(10.0, 20.0, 30.0));
    let infinite = |e: &Scene| Prepared::new(e).unwrap().emitters()[0].is_infinite();
    let mut lights: Vec<_> = all()
        .into_iter()
        .map(|(name, scene, _)| (name, scene))
        .filter(|(_, s)| !infinite(s))
        .collect();
    let tilted = Transform::rotate(Vec3::new(1.0, 0.5, 0.2), 1.0);
    let size = Vec3::new(0.5, 1.0, 0.2);
    lights.extend([
        ("box", glowing(Shape::Box { size }, tilted, false)),
        (
            "point",
            with(Light::Point {
                position: Vec3::Y,
                intensity: Rgb::new(1.0, 2.0, 3.0),
                group: None,
            }),
        ),
        ("soft spot", with(spot(intensity(), 0.0, 45.0))),
        ("narrow spot", with(spot(power, 4.0, 10.0))),
        ("hard spot", with(spot(intensity(), 60.0, 60.0))),
        ("spot all around", with(spot(intensity(), 100.0, 180.0))),
    ]);
    lights
}

/// The power of every light is the light that arrives on a sphere around it, integrated
/// numerically. A wrong area (the old program's sphere had πr², its triangles ½ (1 − cos θ) a b)
/// or a forgotten side shows here, as well as a spot whose falloff does not have its integral.
#[test]
fn power_is_the_light_that_arrives_around() {
    let radius = 30.0_f32;
    for (name, scene) in all_finite() {
        let scene = Prepared::new(&scene).unwrap();
        let index = std::cell::Cell::new(0);
        let flux = integrate_sphere(|direction| {
            index.set(index.get() + 1);
            let from = direction * radius;
            let arriving = |e: &Emitter| {
                let sample = e.sample(from, random(51, index.get()).1);
                sample.map_or(Spectrum::BLACK, |s| {
                    let cos = s.wi.dot(-direction).max(0.0);
                    s.radiance * (cos / s.pdf * radius * radius)
                })
            };
            scene.emitters().iter().map(arriving).fold(Spectrum::BLACK, |sum, s| sum + s)
        });
        let power = scene.emitters().iter().fold(Spectrum::BLACK, |sum, e| sum + e.power(1.0));
        // What the inside of a sphere gives stays there.
        let leaving = if name == "sphere from inside" { 0.5 } else { 1.0 };
        let power = power * leaving;
        for (arrived, given) in flux.into_iter().zip(power.channels().map(f64::from)) {
            assert!((arrived / given - 1.0).abs() < 3e-3, "{name}: {flux:?}, expected {power:?}");
        }
    }
}

/// A spot that was given a power has that power, whatever its cone.
#[test]
fn spots_have_the_power_they_were_given() {
    for [inner, outer] in [[0.0, 0.2], [0.1, 0.1], [0.5, 3.0], [0.0, 1e-3]] {
        let mut scene = empty();
        let light = SpotLight::Power(Rgb::new(60.0, 50.0, 40.0));
        let (position, direction) = (Vec3::ZERO, Vec3::Y);
        scene.lights.push(Light::Spot { position, direction, light, inner, outer, group: None });
        let power = Prepared::new(&scene).unwrap().emitters()[0].power(1.0);
        for (got, expected) in power.channels().into_iter().zip([60.0, 50.0, 40.0]) {
            assert!((got / expected - 1.0).abs() < 1e-5, "{inner} {outer}: {power:?}");
        }
    }
}

/// Lights at infinity: what arrives from all around, through a disk as large as the scene.
#[test]
fn power_from_infinity_is_what_crosses_the_scene() {
    let map = Environment::image(rutilant::scene::ImageId(0));
    for (name, scene) in [
        ("even sky", under(Environment::constant(Rgb::new(1.0, 2.0, 3.0)), 0.0, None)),
        ("sky map", under(map, 1.0, Some(sky(64, 32)))),
    ] {
        let scene = Prepared::new(&scene).unwrap();
        let Emitter::Environment(sky) = &scene.emitters()[0] else { panic!("{name}") };
        let around = integrate_sphere(|direction| sky.radiance(direction));
        let power = scene.emitters()[0].power(2.0).channels().map(f64::from);
        for (around, power) in around.into_iter().zip(power) {
            let expected = around * 4.0 * std::f64::consts::PI;
            assert!((power / expected - 1.0).abs() < 2e-3, "{name}: {power}, expected {expected}");
        }
    }
    let mut scene = empty();
    let direction = Vec3::new(1.0, 2.0, 3.0);
    scene.lights.push(Light::Directional { direction, irradiance: Rgb::grey(5.0), group: None });
    let power = Prepared::new(&scene).unwrap().emitters()[0].power(2.0).channels()[0];
    assert!((power / (5.0 * std::f32::consts::PI * 4.0) - 1.0).abs() < 1e-6, "{power}");
}

/// The solid angle that light samples cover, the mean of 1 / pdf, is the one that rays find; from
/// afar it is the projected area over the square of the distance.
#[test]
fn samples_cover_the_solid_angle_that_rays_find() {
    let covered = |scene: &Prepared, from: Vec3, n: u64| {
        let samples = (0..n).filter_map(|i| scene.emitters()[0].sample(from, random(61, i).1));
        samples.map(|s| 1.0 / f64::from(s.pdf)).sum::<f64>() / n as f64
    };
    for (name, scene, from) in all() {
        let scene = Prepared::new(&scene).unwrap();
        let [seen, ..] = integrate_sphere(|direction| {
            let emitter = &scene.emitters()[0];
            let hit = scene.closest(&Ray::new(from, direction));
            let light = match (emitter, hit) {
                (Emitter::Environment(sky), _) => sky.radiance(direction),
                (_, Some(hit)) => emitter.glow().unwrap().towards(-direction, hit.normal),
                (_, None) => Spectrum::BLACK,
            };
            if light.is_black() { Spectrum::BLACK } else { Spectrum::WHITE }
        });
        let sampled = covered(&scene, from, 200_000);
        // A map with black texels in it is not sampled there at all.
        assert!((sampled / seen - 1.0).abs() < 0.015, "{name}: {sampled}, expected {seen}");
    }
    let pi = std::f64::consts::PI;
    for (shape, cosine_area) in [
        (Shape::Sphere { radius: 0.5 }, pi * 0.25),
        (Shape::Disk { radius: 0.5 }, pi * 0.25 * 0.6),
        (Shape::Rectangle { size: Vec2::new(2.0, 0.5) }, 0.6),
    ] {
        // The normal has the cosine 0.6 with the way there.
        let tilt = Transform::rotate(Vec3::X, 0.6_f32.acos());
        let scene = Prepared::new(&glowing(shape.clone(), tilt, true)).unwrap();
        let distance = 1000.0;
        let area = covered(&scene, Vec3::Z * distance, 10_000) * f64::from(distance).powi(2);
        assert!((area / cosine_area - 1.0).abs() < 1e-3, "{shape:?}: {area} {cosine_area}");
    }
}

/// Points on a glowing triangle are spread evenly: each barycentric weight is a third on average.
/// The old program's were 1/2, 1/4, 1/4.
#[test]
fn points_on_triangles_are_spread_evenly() {
    let scene = glowing(Shape::Mesh(rutilant::scene::MeshId(0)), Transform::IDENTITY, true);
    let [a, b, c] = [0, 1, 2].map(|i| scene.meshes[0].positions[i]);
    let scene = Prepared::new(&scene).unwrap();
    let n = 100_000;
    let mut mean = [0.0_f64; 3];
    for i in 0..n {
        let from = Vec3::new(0.2, 0.1, 50.0);
        let end = scene.emitters()[0].sample(from, random(71, i).1).unwrap().end.unwrap();
        let area2 = (b - a).cross(c - a);
        let weight = |p: Vec3, q: Vec3| {
            f64::from((p - end).cross(q - end).dot(area2) / area2.length_squared())
        };
        for (sum, w) in mean.iter_mut().zip([weight(b, c), weight(c, a), weight(a, b)]) {
            *sum += w / n as f64;
        }
    }
    let three_sigma = 3.0 * (1.0 / 18.0 / n as f64).sqrt();
    assert!(mean.iter().all(|m| (m - 1.0 / 3.0).abs() < three_sigma), "{mean:?}");
}

/// A single bright texel, high or low, left or right: a floor under it has the irradiance
/// L · ω · cos θ of its solid angle.
#[test]
fn a_bright_texel_lights_a_floor_by_its_solid_angle() {
    let pi = std::f64::consts::PI;
    for (projection, size, texel) in [
        (Projection::Equirectangular, [64, 32], [40, 5]),
        (Projection::Equirectangular, [64, 32], [0, 12]),
        (Projection::Equirectangular, [64, 32], [63, 3]),
        (Projection::Equirectangular, [64, 32], [20, 14]),
        (Projection::Octahedral, [40, 40], [24, 17]),
        (Projection::Octahedral, [40, 40], [8, 18]),
        (Projection::Cube, [64, 48], [20, 10]),
        (Projection::Cube, [48, 64], [40, 18]),
        (Projection::Cube, [96, 16], [69, 3]),
        (Projection::Cube, [16, 96], [9, 37]),
    ] {
        let mut pixels = vec![[0.0; 3]; (size[0] * size[1]) as usize];
        pixels[(texel[1] * size[0] + texel[0]) as usize] = [100.0; 3];
        let map = Image::from_rgb(size[0], size[1], &pixels).unwrap();
        let mut scene = mapped(projection, map, 0.0);
        let matte = scene.add_material(Matte::new(Rgb::grey(0.5)));
        let flat = Transform::rotate(Vec3::X, -std::f32::consts::FRAC_PI_2);
        let floor = Shape::Rectangle { size: Vec2::splat(10.0) };
        scene.objects.push(Object::new(floor, matte).transformed(&flat));
        scene.camera =
            Perspective::look_at(Vec3::new(0.0, 1.0, 1.0), Vec3::ZERO, 0.2).unwrap().into();
        let [cosine, solid_angle] = of_one_pixel(projection, size, texel, |d| [d.y, 1.0]);
        let irradiance = 100.0 * cosine;
        // As one direction without interpolation: no more than the tent's curvature away.
        let center = shown(projection, size, texel.map(|i| f64::from(i) + 0.5)).unwrap();
        let about = 100.0 * solid_angle * center.y;
        assert!((irradiance / about - 1.0).abs() < 0.015, "{irradiance} {about}");
        let (got, error) = mean(&render(&scene, small(256)), "G");
        let expected = 0.5 / pi * irradiance;
        assert!(
            (got - expected).abs() < 4.0 * error + 1e-3 * expected,
            "{projection:?} {texel:?}: {got} ± {error}, expected {expected}"
        );
    }
}

/// One step of rounding to either side of any edge of any map changes next to nothing: seams of a
/// map, folds of an octahedron, edges and corners of a cube.
#[test]
fn a_step_of_rounding_across_an_edge_is_harmless() {
    for (name, projection, [width, height]) in projections() {
        let scene = Prepared::new(&mapped(projection, sky(width, height), 0.0)).unwrap();
        let sky = sky_of(&scene);
        // Corners, edges and faces of a cube, and points on the lines that join them.
        for i in 0..27 * 5_u32 {
            let sign = |i: u32| (i % 3) as f32 - 1.0;
            let part = [1.0, 0.77, 0.5, 0.3, 0.01][(i / 27) as usize];
            let d = Vec3::new(sign(i), sign(i / 3), sign(i / 9)) * Vec3::new(1.0, part, 1.0);
            for d in [d, Vec3::new(d.y, d.z, d.x), Vec3::new(d.z, d.x, d.y)] {
                let Some(d) = d.try_normalize() else { continue };
                // Where all columns meet, a step may turn half around: the mean of opposite
                // texels is the same, but others are not.
                let at_pole = projection == Projection::Equirectangular && d.y.abs() == 1.0;
                let here = sky.radiance(d).channels();
                for j in 0..27_u32 {
                    let step = |c: f32, j: u32| match j % 3 {
                        0 => c.next_down(),
                        1 => c,
                        _ => c.next_up(),
                    };
                    let near = Vec3::new(step(d.x, j), step(d.y, j / 3), step(d.z, j / 9));
                    let there = sky.radiance(near).channels();
                    for (a, b) in here.into_iter().zip(there) {
                        let same = (a - b).abs() < 1e-3 || at_pole && b.is_finite() && b >= 0.0;
                        assert!(same, "{name}: {a} at {d}, {b} at {near}");
                    }
                    assert!(sky.pdf(near).is_finite() && sky.pdf(near) >= 0.0, "{name}: {near}");
                }
            }
        }
    }
}

/// One step of rounding to either side of the seam and of the poles changes next to nothing, and
/// nothing is read outside the map: the old program's indices ran over there.
#[test]
fn a_step_of_rounding_at_seam_and_poles_is_harmless() {
    let scene = under(Environment::image(rutilant::scene::ImageId(0)), 0.0, Some(sky(24, 12)));
    let scene = Prepared::new(&scene).unwrap();
    let Emitter::Environment(sky) = &scene.emitters()[0] else { panic!("a sky") };
    let ulps = [-1.0_f32, -f32::MIN_POSITIVE, -f32::from_bits(1), -0.0, 0.0]
        .into_iter()
        .flat_map(|x| [x, -x])
        .filter(|x| x.abs() < 1.0);
    for tiny in ulps.chain([f32::EPSILON, -f32::EPSILON]) {
        for unit in [1.0_f32.next_down(), 1.0, 1.0_f32.next_up()] {
            for (exact, near) in [
                (Vec3::Z, Vec3::new(tiny, 0.0, unit)),
                (Vec3::NEG_Z, Vec3::new(tiny, tiny, -unit)),
                (Vec3::Y, Vec3::new(tiny, unit, -tiny)),
                (Vec3::NEG_Y, Vec3::new(-tiny, -unit, tiny)),
            ] {
                let (a, b) = (sky.radiance(exact), sky.radiance(near));
                // At a pole all columns meet: there a step may turn half around, over opposite
                // texels whose mean it always is.
                let at_pole = exact.y != 0.0;
                for (a, b) in a.channels().into_iter().zip(b.channels()) {
                    assert!(
                        at_pole && b.is_finite() && b >= 0.0 || (a - b).abs() < 1e-4,
                        "{near}: {a} {b}"
                    );
                }
                assert!(sky.pdf(near).is_finite() && sky.pdf(near) >= 0.0, "{near}");
            }
        }
    }
}

/// Choosing bright directions of the sky is worth it: at equal samples the error under a map with
/// a small sun is a hundredth of that of finding the sun by chance (measured: relMSE 0.028 against
/// 3.8; `--show-output` prints it).
#[test]
fn importance_sampling_the_sky_pays() {
    let (width, height) = (64_u32, 32_u32);
    let mut pixels = vec![[0.2, 0.3, 0.5]; (width * height) as usize];
    pixels[(6 * width + 40) as usize] = [4000.0, 3500.0, 3000.0];
    let map = Image::from_rgb(width, height, &pixels).unwrap();
    let mut scene = under(Environment::image(rutilant::scene::ImageId(0)), 0.0, Some(map));
    let matte = scene.add_material(Matte::new(Rgb::grey(0.5)));
    let flat = Transform::rotate(Vec3::X, -std::f32::consts::FRAC_PI_2);
    let floor = Shape::Rectangle { size: Vec2::splat(20.0) };
    scene.objects.push(Object::new(floor, matte).transformed(&flat));
    let place = Transform::translate(Vec3::new(0.0, 0.5, 0.0));
    scene.objects.push(Object::new(Shape::Sphere { radius: 0.5 }, matte).transformed(&place));
    scene.camera = Perspective::look_at(Vec3::new(0.0, 1.5, 4.0), Vec3::new(0.0, 0.4, 0.0), 0.5)
        .unwrap()
        .into();
    let with = |strategy, spp, seed| {
        let sampler = SamplerKind::Independent;
        let settings = Settings { size: [32, 24], spp, seed, strategy, sampler, ..small(1) };
        render(&scene, settings).rgb().unwrap()
    };
    let reference = with(Strategy::Both, 16_384, 1);
    let rel_mse = |strategy| {
        let picture = with(strategy, 64, 2);
        let error = picture.iter().flatten().zip(reference.iter().flatten());
        let error = error.map(|(x, r)| f64::from((x - r) * (x - r) / (r * r + 0.01)));
        error.sum::<f64>() / (3 * reference.len()) as f64
    };
    let (chosen, by_chance) = (rel_mse(Strategy::Both), rel_mse(Strategy::BsdfOnly));
    println!("relMSE at 64 samples: {chosen:.2e} chosen, {by_chance:.2e} by chance");
    assert!(by_chance > 100.0 * chosen, "{by_chance} {chosen}");
}
