//! Direct light is what an integral over the lamps says, computed apart from the renderer in
//! double precision.

use rutilant::Prepared;
use rutilant::camera::Perspective;
use rutilant::color::Rgb;
use rutilant::geom::{DVec3, Transform, Vec2, Vec3};
use rutilant::image::Image;
use rutilant::material::{Emission, Matte};
use rutilant::scene::Scene;
use rutilant::settings::{LightSelection, SamplerKind, Settings, Strategy};
use rutilant::shape::{Mesh, Object, Shape};
use rutilant_conformance::matrix::render;
use std::f64::consts::PI;
use std::sync::Arc;

/// A one-sided triangular lamp.
struct Lamp {
    corners: [DVec3; 3],
    radiance: f64,
}

impl Lamp {
    /// Its triangle in n² equal parts: the middle of each, and its area.
    fn parts(&self, n: u32) -> impl Iterator<Item = (DVec3, f64)> {
        let [a, b, c] = self.corners;
        let (e1, e2) = ((b - a) / f64::from(n), (c - a) / f64::from(n));
        let area = 0.5 * e1.cross(e2).length();
        (0..n)
            .flat_map(move |i| {
                (0..n - i).flat_map(move |j| {
                    let corner = a + e1 * f64::from(i) + e2 * f64::from(j);
                    // A square of the grid holds two triangles, but for those along the third side.
                    let second = (i + j + 1 < n).then(|| corner + (e1 + e2) * (2.0 / 3.0));
                    [Some(corner + (e1 + e2) / 3.0), second].into_iter().flatten()
                })
            })
            .map(move |middle| (middle, area))
    }

    /// The integral of `f(cosine below, density in 1/sr of choosing a point on the lamp evenly)`
    /// over the solid angle that the lamp takes for `point`, whose normal is +y.
    fn integral(&self, point: DVec3, n: u32, f: impl Fn(f64, f64) -> f64) -> f64 {
        let [a, b, c] = self.corners;
        let normal = (b - a).cross(c - a);
        let (area, normal) = (0.5 * normal.length(), normal.normalize());
        self.parts(n)
            .map(|(middle, part)| {
                let way = middle - point;
                let (distance2, wi) = (way.length_squared(), way.normalize());
                let cos_lamp = (-wi.dot(normal)).max(0.0);
                let solid_angle = part * cos_lamp / distance2;
                if cos_lamp == 0.0 {
                    0.0
                } else {
                    f(wi.y.max(0.0), distance2 / (cos_lamp * area)) * solid_angle
                }
            })
            .sum()
    }

    /// The irradiance at `point`.
    fn irradiance(&self, point: DVec3, n: u32) -> f64 {
        self.radiance * self.integral(point, n, |cos, _| cos)
    }
}

/// A floor of some albedo at height `y` under lamps, seen in a single point.
fn floor_under(lamps: &[Lamp], albedo: f32, point: DVec3) -> Scene {
    let target = point.as_vec3();
    let camera = Perspective::look_at(target + Vec3::new(-1.0, 0.5, -0.7), target, 1e-3).unwrap();
    let mut scene = Scene::new(camera);
    let floor = scene.add_material(Matte::new(Rgb::grey(albedo)));
    let lying = Transform::translate(Vec3::Y * target.y)
        * Transform::rotate(Vec3::X, -std::f32::consts::FRAC_PI_2);
    let size = Vec2::splat(400.0);
    scene.objects.push(Object::new(Shape::Rectangle { size }, floor).transformed(&lying));
    for Lamp { corners, radiance } in lamps {
        let positions = corners.map(DVec3::as_vec3).to_vec();
        let mesh =
            scene.add_mesh(Mesh { positions, triangles: vec![[0, 1, 2]], ..Mesh::default() });
        let lamp = scene.add_material(Emission::radiance(Rgb::grey(*radiance as f32)));
        scene.objects.push(Object::new(Shape::Mesh(mesh), lamp));
    }
    scene
}

/// Mean of the green channel over the picture, and the standard error of that mean.
fn mean(image: &Image) -> (f64, f64) {
    let sum = |name| image.channel(name).unwrap().iter().map(|&v| f64::from(v)).sum::<f64>();
    let n = f64::from(image.width() * image.height());
    (sum("G") / n, sum("variance.G").sqrt() / n)
}

/// Asserts that every strategy and every choice of lamps gives `expected`. Each must know it to
/// 1 %, and the one that finds lamps only by chance to 4 %.
fn assert_all_ways(name: &str, scene: &Scene, expected: f64) {
    let scene = Arc::new(Prepared::new(scene).unwrap());
    for strategy in [Strategy::Both, Strategy::LightOnly, Strategy::BsdfOnly] {
        for light_selection in
            [LightSelection::Uniform, LightSelection::Power, LightSelection::Tree]
        {
            let settings = Settings {
                size: [16; 2],
                spp: 1024,
                max_depth: Some(2),
                sampler: SamplerKind::Independent,
                strategy,
                light_selection,
                ..Settings::default()
            };
            let (got, error) = mean(&render(&scene, settings, 2).unwrap());
            let noise = if strategy == Strategy::BsdfOnly { 0.04 } else { 0.01 };
            assert!(error < noise * expected, "{name}, {strategy:?}: {error} on {expected}");
            assert!(
                (got - expected).abs() < 3.0 * error + 1e-5 * expected,
                "{name}, {strategy:?}, {light_selection:?}: {got} ± {error}, expected {expected}"
            );
        }
    }
}

/// The 2017 program weighted what scattered rays found of its lamp by multiple importance
/// sampling, and lost the light samples that should have brought the rest: of all direct light
/// 2.8 % was left under the lamp, 0.7 % below the origin, 0.3 % at (4, 4). Ours keeps all of it,
/// at the same places, under the same lamp.
#[test]
fn all_light_of_the_2017_lamp_arrives() {
    let corners = [[2.0, 2.0, 2.0], [1.0, 2.0, 2.0], [2.0, 2.0, 1.0]].map(DVec3::from_array);
    let lamp = Lamp { corners, radiance: 1.7 };
    let albedo = 0.9;
    for (name, x, z, old_share) in [
        ("under the lamp", 5.0 / 3.0, 5.0 / 3.0, 0.028),
        ("at the origin", 0.0, 0.0, 0.007),
        ("at (4, 4)", 4.0, 4.0, 0.003),
    ] {
        let point = DVec3::new(x, -0.3, z);
        let irradiance = lamp.irradiance(point, 64);
        // What was left of it, by the same integral: the balance heuristic's share of scattered rays.
        let left = lamp.integral(point, 64, |cos, pdf| cos * (cos / PI) / (cos / PI + pdf));
        let left = left * lamp.radiance / irradiance;
        assert!((left - old_share).abs() < 0.001, "{name}: {left}");

        let expected = f64::from(albedo) / PI * irradiance;
        let lamps = std::slice::from_ref(&lamp);
        assert_all_ways(name, &floor_under(lamps, albedo, point), expected);
    }
}

/// One lamp, ten or ten thousand, of different brightness: choosing one of them loses nothing,
/// whether all are chosen equally often, by power or by a tree. A selection probability that is missing,
/// or not that of the choice made, shows here.
#[test]
fn choosing_one_of_many_lamps_loses_no_light() {
    for (columns, rows) in [(1, 1), (5, 2), (100, 100)] {
        let (width, depth) = (3.0 / f64::from(columns), 3.0 / f64::from(rows));
        let lamps: Vec<Lamp> = (0..columns * rows)
            .map(|i| {
                let corner = DVec3::new(
                    f64::from(i % columns) * width - 1.3,
                    2.0,
                    f64::from(i / columns) * depth - 1.6,
                );
                let corners = [corner, corner + DVec3::X * width * 0.9, corner + DVec3::Z * depth];
                Lamp { corners, radiance: f64::from(1 + (i * 5) % 8) }
            })
            .collect();
        let point = DVec3::new(0.1, 0.0, 0.2);
        // Small lamps are known well enough from a few points each.
        let n = (200 / columns).max(4);
        let expected = lamps.iter().map(|lamp| lamp.irradiance(point, n)).sum::<f64>() * 0.5 / PI;
        let name = format!("{} lamps", lamps.len());
        assert_all_ways(&name, &floor_under(&lamps, 0.5, point), expected);
    }
}
