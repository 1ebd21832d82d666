//! Scenes whose light is known in closed form, for every integrator, sampler and setting.

#![expect(clippy::disallowed_methods, reason = "expected values are computed in f64")]

mod common;

use common::{assert_mean, mean, render, small};
use rutilant::bsdf::Fresnel;
use rutilant::camera::Perspective;
use rutilant::color::Rgb;
use rutilant::film::Filter;
use rutilant::geom::{Transform, Vec2, Vec3};
use rutilant::light::{Environment, Light, SpotLight};
use rutilant::material::{
    Absorption, Conductor, Dielectric, Emission, HemisphereSampling, Material, MaterialKind, Matte,
    Mirror, Mix, ThinDielectric,
};
use rutilant::scene::Scene;
use rutilant::settings::{
    Heuristic, IntegratorKind, LightSelection, Roulette, SamplerKind, Settings, Strategy,
};
use rutilant::shape::{Mesh, Object, Shape};
use std::f64::consts::PI;

const GREY: Rgb = Rgb::grey(0.5);

fn seen_from(position: Vec3, target: Vec3, fov_y: f32) -> Scene {
    Scene::new(Perspective::look_at(position, target, fov_y).unwrap())
}

/// Every way there is to compute all light.
fn all_ways(spp: u64) -> Vec<Settings> {
    let mut ways = Vec::new();
    for sampler in [SamplerKind::Independent, SamplerKind::Sobol] {
        let base = Settings { sampler, ..small(spp) };
        for strategy in [Strategy::Both, Strategy::LightOnly, Strategy::BsdfOnly] {
            for heuristic in [Heuristic::Balance, Heuristic::Power] {
                if strategy == Strategy::Both || heuristic == Heuristic::Power {
                    ways.push(Settings { strategy, heuristic, ..base.clone() });
                }
            }
        }
        ways.push(Settings { integrator: IntegratorKind::Naive, ..base.clone() });
        ways.push(Settings { roulette: Roulette::Albedo, ..base.clone() });
        ways.push(Settings { light_selection: LightSelection::Uniform, ..base.clone() });
        ways.push(Settings { light_selection: LightSelection::Tree, ..base });
    }
    ways
}

/// A closed grey room that glows: L = e + a e + a² e + … = e / (1 - a). Lost or doubled light of
/// any bounce shows here: one-sided lights, roulette that is not made up for, a depth limit.
#[test]
fn closed_room_sums_the_series() {
    for albedo in [0.2, 0.5, 0.8] {
        for shape in [Shape::Sphere { radius: 2.0 }, Shape::Box { size: Vec3::new(4.0, 3.0, 2.0) }]
        {
            let mut scene = seen_from(Vec3::new(0.1, 0.2, 0.3), Vec3::new(1.0, 0.0, 0.0), 1.0);
            let glow = Emission { two_sided: true, ..Emission::radiance(Rgb::WHITE) };
            let wall = Material::from(Matte::new(Rgb::grey(albedo))).emitting(glow);
            let wall = scene.add_material(wall);
            scene.objects.push(Object::new(shape, wall));
            for way in all_ways(48) {
                let image = render(&scene, way.clone());
                let (mean, error) = mean(&image, "G");
                let expected = 1.0 / (1.0 - f64::from(albedo));
                assert!(
                    (mean - expected).abs() < 4.0 * error + 1e-4 * expected,
                    "{way:?}: {mean} ± {error}, expected {expected}"
                );
            }
        }
    }
}

/// A convex body under a constant sky sends back its albedo, at every point.
#[test]
fn convex_bodies_show_their_albedo_under_a_constant_sky() {
    for shape in [Shape::Sphere { radius: 10.0 }, Shape::Box { size: Vec3::splat(20.0) }] {
        let mut scene = seen_from(Vec3::new(3.0, 2.0, 30.0), Vec3::ZERO, 0.1);
        scene.environment = Some(Environment::constant(Rgb::WHITE));
        let grey = scene.add_material(Matte::new(Rgb::grey(0.6)));
        scene.objects.push(Object::new(shape, grey));
        for way in all_ways(64) {
            assert_mean(&render(&scene, way), 0.6, 4.0);
        }
    }
}

/// Glass that absorbs nothing vanishes in the furnace, in every pixel, seen from outside and
/// from inside, where radiance is larger by the square of the index and all of it is lost again.
#[test]
fn clear_glass_vanishes_in_the_furnace() {
    let shapes = [Shape::Sphere { radius: 1.0 }, Shape::Box { size: Vec3::splat(1.5) }];
    for shape in shapes {
        for fresnel in [Fresnel::Exact, Fresnel::Schlick] {
            let mut scene = seen_from(Vec3::new(0.4, 1.0, 4.0), Vec3::ZERO, 0.7);
            scene.environment = Some(Environment::constant(Rgb::WHITE));
            let glass = scene.add_material(Dielectric { fresnel, ..Dielectric::new(1.5) });
            scene.objects.push(Object::new(shape.clone(), glass));
            for integrator in [IntegratorKind::Path, IntegratorKind::Naive] {
                let image = render(&scene, Settings { integrator, ..small(64) });
                let tolerance = if integrator == IntegratorKind::Path {
                    1e-3
                } else {
                    4.0 * mean(&image, "R").1 + 1e-3
                };
                assert!(
                    (mean(&image, "R").0 - 1.0).abs() < tolerance,
                    "{shape:?} {:?}",
                    mean(&image, "R")
                );
            }
        }
    }
}

/// So does rough glass, however often light is thrown to and fro inside: what one bounce lost
/// would be lost many times.
#[test]
fn rough_glass_vanishes_in_the_furnace() {
    for (ior, roughness) in [(1.33, 1.0), (1.5, 0.3), (1.5, 0.6), (1.5, 1.0), (1.8, 1.0)] {
        let mut scene = seen_from(Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO, 0.35);
        scene.environment = Some(Environment::constant(Rgb::WHITE));
        let glass = scene.add_material(Dielectric { roughness, ..Dielectric::new(ior) });
        scene.objects.push(Object::new(Shape::Sphere { radius: 1.0 }, glass));
        let (mean, error) = mean(&render(&scene, small(2048)), "G");
        assert!((mean - 1.0).abs() < 4.0 * error + 2e-3, "{ior} {roughness}: {mean} ± {error}");
        assert!(error < 3e-3, "{ior} {roughness}: {error}");
    }
}

/// Even where vertex normals point anywhere, no light is lost in glass or in a mirror: the path
/// always knows what it is in.
#[test]
fn glass_with_wild_normals_vanishes_in_the_furnace() {
    let mut mesh = Mesh::default();
    let rings = 12_u32;
    for i in 0..=rings {
        for j in 0..2 * rings {
            let (theta, phi) = (PI * f64::from(i) / 12.0, PI * f64::from(j) / 12.0);
            let (s, c) = theta.sin_cos();
            mesh.positions.push(Vec3::new(
                (s * phi.cos()) as f32,
                c as f32,
                (s * phi.sin()) as f32,
            ));
            let (a, u) = common::random(77, u64::from(i * 64 + j));
            mesh.normals.push(Vec3::new(a - 0.5, u.x - 0.5, u.y - 0.5));
        }
    }
    // The poles are single points, so that the mesh is closed.
    for j in 0..2 * rings {
        mesh.positions[j as usize] = Vec3::Y;
        mesh.positions[(rings * 2 * rings + j) as usize] = Vec3::NEG_Y;
    }
    for i in 0..rings {
        for j in 0..2 * rings {
            let at = |i: u32, j: u32| i * 2 * rings + j % (2 * rings);
            let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    for (name, material) in [
        ("glass", Material::from(Dielectric::new(1.5))),
        ("mirror", Material::from(Mirror { reflectance: Rgb::WHITE })),
    ] {
        let mut scene = seen_from(Vec3::new(0.4, 1.0, 4.0), Vec3::ZERO, 0.5);
        scene.environment = Some(Environment::constant(Rgb::WHITE));
        let material = scene.add_material(material);
        let mesh = scene.add_mesh(mesh.clone());
        scene.objects.push(Object::new(Shape::Mesh(mesh), material));
        // Some paths take thousands of bounces to get out; roulette would only add noise.
        let patient = Settings { roulette: Roulette::Off, max_depth: Some(1_000_000), ..small(64) };
        let (mean, _) = mean(&render(&scene, patient), "G");
        assert!((mean - 1.0).abs() < 1e-3, "{name}: {mean}");
    }
}

/// Half mirror, half white: nothing is lost at any proportion. The old program multiplied its
/// light samples by min(1 − s, 0), which is nothing.
#[test]
fn mixes_of_white_and_mirror_vanish_in_the_furnace() {
    for amount in [0.0, 0.3, 0.5, 1.0] {
        let mut scene = seen_from(Vec3::new(0.4, 1.0, 4.0), Vec3::ZERO, 0.3);
        scene.environment = Some(Environment::constant(Rgb::WHITE));
        let first = scene.add_material(Matte::new(Rgb::WHITE));
        let second = scene.add_material(Mirror { reflectance: Rgb::WHITE });
        let mix = scene.add_material(Mix { first, second, amount });
        scene.objects.push(Object::new(Shape::Sphere { radius: 1.0 }, mix));
        for way in all_ways(64) {
            assert_mean(&render(&scene, way), 1.0, 4.0);
        }
    }
}

/// What evenly drawn directions cost: under an even sky of radiance L a sample of a plane of albedo
/// a is 2 a L cos θ with cos θ even in 0..1, of variance a² L² / 3; one whose directions are drawn
/// by the cosine is a L, always. A density that is not that of the directions, or a weight that
/// has lost its cosine, shows here even where the mean is right.
#[test]
fn uniform_sampling_has_its_variance_and_cosine_sampling_none() {
    let (albedo, sky, spp) = (0.6_f32, 1.75_f32, 1024_u32);
    let with = |sampling, integrator| {
        let mut scene = seen_from(Vec3::new(0.0, 2.0, 0.1), Vec3::ZERO, 0.5);
        scene.environment = Some(Environment::constant(Rgb::grey(sky)));
        let plane = scene.add_material(Matte { sampling, ..Matte::new(Rgb::grey(albedo)) });
        let flat = Transform::rotate(Vec3::X, -std::f32::consts::FRAC_PI_2);
        let shape = Shape::Rectangle { size: Vec2::splat(100.0) };
        scene.objects.push(Object::new(shape, plane).transformed(&flat));
        let filter = Filter::Box { radius: 0.5 };
        let strategy = Strategy::BsdfOnly;
        render(&scene, Settings { integrator, strategy, filter, ..small(spp.into()) })
    };
    let sent_back = f64::from(albedo * sky);
    for integrator in [IntegratorKind::Path, IntegratorKind::Naive] {
        let even = with(HemisphereSampling::Uniform, integrator);
        assert_mean(&even, sent_back, 4.0);
        let variances = even.channel("variance.G").unwrap();
        let pixels = variances.len() as f64;
        let mean = variances.iter().map(|&v| f64::from(v)).sum::<f64>() / pixels;
        let (variance, expected) = (mean * f64::from(spp), sent_back * sent_back / 3.0);
        // The estimated variance of n even numbers scatters by sqrt(0.8 / n) of itself: their
        // fourth moment is 9/5 of the squared variance.
        let error = expected * (0.8 / (pixels * f64::from(spp))).sqrt();
        assert!(
            (variance - expected).abs() < 4.0 * error,
            "{integrator:?}: {variance} ± {error}, expected {expected}"
        );

        let by_cosine = with(HemisphereSampling::Cosine, integrator);
        assert!(by_cosine.channel("G").unwrap().iter().all(|&v| v == albedo * sky));
        // Nothing but the rounding of the sums of squares.
        let rounding = sent_back * sent_back * f64::EPSILON;
        let variances = by_cosine.channel("variance.G").unwrap();
        assert!(variances.iter().all(|&v| f64::from(v) <= rounding), "{variances:?}");
    }
}

/// Squares of a checkerboard along each side, and the side of one in metres.
const SQUARES: (usize, f64) = (8, 0.5);

/// Its lower left corner, as it is seen from its front; it lies in a plane of constant z.
const CHECKERS_AT: [f64; 3] = [-1.7, -0.8, 3.0];

/// The light of the square in this column and row: none, or one that no other square has.
fn square_radiance(column: usize, row: usize) -> f64 {
    if (column + row).is_multiple_of(2) { (1 + column + SQUARES.0 * row) as f64 } else { 0.0 }
}

/// A camera that sees nothing but a leaning mirror, and behind the camera a board of squares that
/// glow and squares that are dark.
struct Checkers {
    scene: Scene,
    /// Where the camera is and what it looks at.
    eye: [f64; 3],
    target: [f64; 3],
    fov_y: f64,
    /// The mirror's normal and a point on it.
    normal: [f64; 3],
    mirror_at: [f64; 3],
}

impl Checkers {
    /// `amount` is the mirror's share; the rest is black.
    fn new(amount: f32) -> Self {
        let (eye, target, mirror_at) = ([0.3, 0.4, 1.0], [0.1, 0.1, -1.0], [0.2, -0.1, -1.2]);
        let (turn, lean, fov_y) = (0.09_f32, -0.21_f32, 0.7_f32);
        let vec = |p: [f64; 3]| Vec3::from(p.map(|x| x as f32));
        let mut scene = seen_from(vec(eye), vec(target), fov_y);
        let first = scene.add_material(Matte::new(Rgb::BLACK));
        let second = scene.add_material(Mirror { reflectance: Rgb::WHITE });
        let mix = scene.add_material(Mix { first, second, amount });
        let place = Transform::translate(vec(mirror_at))
            * Transform::rotate(Vec3::X, lean)
            * Transform::rotate(Vec3::Y, turn);
        let wall = Shape::Rectangle { size: Vec2::splat(40.0) };
        scene.objects.push(Object::new(wall, mix).transformed(&place));
        let ((turn_sin, turn_cos), (lean_sin, lean_cos)) =
            (f64::from(turn).sin_cos(), f64::from(lean).sin_cos());
        let normal = [turn_sin, -lean_sin * turn_cos, lean_cos * turn_cos];

        let (count, side) = SQUARES;
        for (row, column) in (0..count).flat_map(|row| (0..count).map(move |c| (row, c))) {
            let radiance = square_radiance(column, row);
            let glow = Emission::radiance(Rgb::grey(radiance as f32));
            let material = if radiance > 0.0 {
                Material::from(Emission { two_sided: true, ..glow })
            } else {
                Material::new(MaterialKind::Black)
            };
            let material = scene.add_material(material);
            let [x, y, z] = CHECKERS_AT;
            let center = [x + side * (column as f64 + 0.5), y + side * (row as f64 + 0.5), z];
            let square = Shape::Rectangle { size: Vec2::splat(side as f32) };
            let place = Transform::translate(vec(center));
            scene.objects.push(Object::new(square, material).transformed(&place));
        }
        let fov_y = f64::from(fov_y);
        Self { scene, eye, target, fov_y, normal, mirror_at }
    }

    /// Where on the board, in squares from its corner, a place on the film of a picture of this
    /// size shows it: the straight way through the mirror to the board's image behind it.
    fn seen_at(&self, [x, y]: [f64; 2], [width, height]: [u32; 2]) -> [f64; 2] {
        let sub = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|i| a[i] - b[i]);
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let unit = |a: [f64; 3]| a.map(|x| x / dot(a, a).sqrt());
        let mirrored = |v: [f64; 3]| {
            let twice = 2.0 * dot(v, self.normal);
            [0, 1, 2].map(|i| v[i] - twice * self.normal[i])
        };

        // The camera's ray.
        let forward = unit(sub(self.target, self.eye));
        let right = unit(cross(forward, [0.0, 1.0, 0.0]));
        let up = cross(right, forward);
        let scale = 2.0 * (0.5 * self.fov_y).tan() / f64::from(height);
        let (across, above) =
            (scale * (x - 0.5 * f64::from(width)), scale * (0.5 * f64::from(height) - y));
        let direction = [0, 1, 2].map(|i| forward[i] + across * right[i] + above * up[i]);

        // The image of the board: its corner and its axes, beyond the mirror's plane.
        let from_mirror = mirrored(sub(CHECKERS_AT, self.mirror_at));
        let corner = [0, 1, 2].map(|i| from_mirror[i] + self.mirror_at[i]);
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(mirrored);
        let distance = dot(sub(corner, self.eye), axes[2]) / dot(direction, axes[2]);
        assert!(distance > 0.0, "the board's image is before the camera");
        let on_board = sub([0, 1, 2].map(|i| self.eye[i] + distance * direction[i]), corner);
        [0, 1].map(|i| dot(on_board, axes[i]) / SQUARES.1)
    }

    /// The square that shows at a place on the film, if it is on the board.
    fn square_at(&self, film: [f64; 2], size: [u32; 2]) -> Option<[usize; 2]> {
        let [column, row] = self.seen_at(film, size).map(f64::floor);
        let inside = |v: f64| (0.0..SQUARES.0 as f64).contains(&v);
        (inside(column) && inside(row)).then_some([column as usize, row as usize])
    }
}

/// A mirror shows a checkerboard where the straight way to its mirrored image meets it: to the bit
/// in all pixels that one square fills, in any way of finding light and at any share of the
/// mirror. Each glowing square has a light of its own, so an image that is not turned round, or
/// shifted by two squares, shows.
#[test]
fn mirrors_show_checkers_where_unfolding_says() {
    let size = [64, 48];
    for amount in [0.0, 0.5, 1.0_f32] {
        let checkers = Checkers::new(amount);
        let mut whole = Vec::new();
        for (y, x) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (y, x))) {
            let corner = |dx: u32, dy: u32| [f64::from(x + dx), f64::from(y + dy)];
            let corners = [corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)];
            // A film is mapped to a plane, so that what holds for the corners holds between them.
            let squares = corners.map(|film| checkers.square_at(film, size));
            if let [Some(first), ..] = squares
                && squares.iter().all(|square| *square == squares[0])
            {
                let expected = amount * square_radiance(first[0], first[1]) as f32;
                whole.push(((y * size[0] + x) as usize, expected));
            }
        }
        let bright = whole.iter().filter(|(_, expected)| *expected > 0.0).count();
        assert!(
            whole.len() > 500 && (bright > 200 || amount == 0.0),
            "{bright} of {}",
            whole.len()
        );
        let mut ways = all_ways(9);
        ways.push(Settings { integrator: IntegratorKind::Direct, ..small(9) });
        for way in ways {
            let way = Settings { size, filter: Filter::Box { radius: 0.5 }, ..way };
            let image = render(&checkers.scene, way.clone());
            for (channel, (pixel, expected)) in
                ["R", "G", "B"].into_iter().flat_map(|c| whole.iter().map(move |w| (c, *w)))
            {
                let shown = image.channel(channel).unwrap()[pixel];
                assert_eq!(shown, expected, "{way:?}, pixel {pixel}");
            }
        }
    }
}

/// The edges between the squares run through their pixels where they should: each pixel's mean is
/// that of the board over its area, and all together deviate as much as chance lets them. An image
/// that is shifted by a fiftieth of a pixel shows.
#[test]
fn edges_of_mirrored_checkers_are_where_unfolding_says() {
    let (size, spp) = ([64, 48], 1024_u32);
    let checkers = Checkers::new(0.5);
    let way = Settings { size, filter: Filter::Box { radius: 0.5 }, ..small(spp.into()) };
    let image = render(&checkers.scene, way);
    let shown = image.channel("G").unwrap();
    // The board over each pixel, by points in rows that are finer than any noise here.
    const FINE: u32 = 128;
    let points = f64::from(FINE * FINE);
    let (mut edges, mut statistic) = (0.0, 0.0);
    for (y, x) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (y, x))) {
        let (mut sum, mut squares, mut bright) = (0.0, 0.0, 0.0);
        for i in 0..FINE * FINE {
            let within = |k: u32| (f64::from(k) + 0.5) / f64::from(FINE);
            let film = [f64::from(x) + within(i % FINE), f64::from(y) + within(i / FINE)];
            let square = checkers.square_at(film, size);
            let value = square.map_or(0.0, |[column, row]| 0.5 * square_radiance(column, row));
            sum += value;
            squares += value * value;
            bright += f64::from(u8::from(value > 0.0));
        }
        let (mean, share) = (sum / points, bright / points);
        // Scores are normal where both bright and dark are seen often enough.
        if f64::from(spp) * share.min(1.0 - share) >= 20.0 {
            let variance = (squares / points - mean * mean) / f64::from(spp);
            let difference = f64::from(shown[(y * size[0] + x) as usize]) - mean;
            statistic += difference * difference / variance;
            edges += 1.0;
        }
    }
    assert!(edges > 500.0, "{edges}");
    let p = common::chi_square_tail(edges, statistic);
    assert!(p > 0.01, "{statistic} over {edges} pixels: p = {p:e}");
}

/// A sphere light over a plane: E = π L (R/d)², and a matte plane shows a E / π of it. The old
/// program's shadow rays hit the light itself and what lay behind it.
#[test]
fn sphere_light_over_a_plane() {
    let mut scene = seen_from(Vec3::new(1.0, 0.5, 1.0), Vec3::ZERO, 0.002);
    let floor = scene.add_material(Matte::new(GREY));
    let lamp = scene.add_material(Emission::radiance(Rgb::grey(10.0)));
    let flat = Transform::rotate(Vec3::X, -std::f32::consts::FRAC_PI_2);
    scene
        .objects
        .push(Object::new(Shape::Rectangle { size: Vec2::splat(4.0) }, floor).transformed(&flat));
    scene.objects.push(
        Object::new(Shape::Sphere { radius: 0.5 }, lamp)
            .transformed(&Transform::translate(Vec3::new(0.0, 2.0, 0.0))),
    );
    // Something behind the light must not shade what is before it.
    scene.objects.push(
        Object::new(Shape::Sphere { radius: 0.5 }, floor)
            .transformed(&Transform::translate(Vec3::new(0.0, 4.0, 0.0))),
    );
    let expected = 0.5 * 10.0 * (0.5_f64 / 2.0).powi(2);
    for way in all_ways(256) {
        let way = Settings { max_depth: Some(2), ..way };
        assert_mean(&render(&scene, way), expected, 4.0);
    }
    assert_mean(
        &render(&scene, Settings { integrator: IntegratorKind::Direct, ..small(256) }),
        expected,
        4.0,
    );
}

/// A point light over a plane: E = I cos θ / d². So too from the distant light.
#[test]
fn lights_without_surface_over_a_plane() {
    let spot = Light::Spot {
        position: Vec3::new(0.0, 2.0, 0.0),
        direction: Vec3::NEG_Y,
        light: SpotLight::Power(Rgb::grey(24.0)),
        inner: 0.0,
        outer: std::f32::consts::PI,
        group: None,
    };
    let lights = [
        // A smoothstep over the whole sphere is a half on average: 24 W are 24 / 2π W/sr ahead.
        (spot, 24.0 / (2.0 * PI) / 4.0),
        (
            Light::Point {
                position: Vec3::new(0.0, 2.0, 0.0),
                intensity: Rgb::grey(8.0),
                group: None,
            },
            2.0,
        ),
        (
            Light::Directional {
                direction: Vec3::new(3.0, -4.0, 0.0),
                irradiance: Rgb::grey(5.0),
                group: None,
            },
            4.0,
        ),
        (
            Light::Directional {
                direction: Vec3::new(3e-25, -4e-25, 0.0),
                irradiance: Rgb::grey(5.0),
                group: None,
            },
            4.0,
        ),
    ];
    for (light, irradiance) in lights {
        let mut scene = seen_from(Vec3::new(1.0, 0.5, 1.0), Vec3::ZERO, 0.002);
        let floor = scene.add_material(Matte::new(GREY));
        let flat = Transform::rotate(Vec3::X, -std::f32::consts::FRAC_PI_2);
        scene.objects.push(
            Object::new(Shape::Rectangle { size: Vec2::splat(4.0) }, floor).transformed(&flat),
        );
        scene.lights.push(light);
        for strategy in [Strategy::Both, Strategy::LightOnly, Strategy::BsdfOnly] {
            let image = render(&scene, Settings { strategy, ..small(16) });
            assert_mean(&image, 0.5 / PI * irradiance, 4.0);
        }
    }
}

/// A rectangle's light behind glass, looked at head on.
fn behind_glass(shape: Shape, absorption: Absorption, lamp_at: Transform) -> Scene {
    let mut scene = seen_from(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, 0.001);
    let mut glass = Dielectric::new(1.5);
    glass.interior.absorption = absorption;
    let glass = scene.add_material(glass);
    let lamp = scene.add_material(Emission::radiance(Rgb::WHITE));
    scene.objects.push(Object::new(shape, glass));
    scene
        .objects
        .push(Object::new(Shape::Rectangle { size: Vec2::splat(1.0) }, lamp).transformed(&lamp_at));
    scene
}

/// A slab of glass lets through (1 − R)² e^(−σt) / (1 − R² e^(−2σt)), all inner reflections
/// included; σ may well be above 1 (the old program's was 1 − colour).
#[test]
fn slab_transmits_by_fresnel_and_beer() {
    let thickness = 0.5_f32;
    let sigmas = [0.0, 0.9, 5.0_f32];
    let [r, g, b] = sigmas;
    let fading = |s: f32| rutilant::geom::real::exp(-s * 0.1);
    let slab = Shape::Box { size: Vec3::new(50.0, 50.0, thickness) };
    let ways = [
        Absorption::Coefficient(Rgb::new(r, g, b)),
        Absorption::ColorAtDistance {
            color: Rgb::new(fading(r), fading(g), fading(b)),
            distance: 0.1,
        },
    ];
    for absorption in ways {
        let scene =
            behind_glass(slab.clone(), absorption, Transform::translate(Vec3::new(0.0, 0.0, -2.0)));
        let image = render(&scene, small(4096));
        for (channel, sigma) in ["R", "G", "B"].into_iter().zip(sigmas.map(f64::from)) {
            let inside = (-sigma * f64::from(thickness)).exp();
            let expected = 0.96_f64 * 0.96 * inside / (1.0 - 0.04 * 0.04 * inside * inside);
            let (mean, error) = mean(&image, channel);
            assert!(
                (mean - expected).abs() < 4.0 * error + 1e-3 * expected,
                "σ {sigma}: {mean} ± {error}, expected {expected}"
            );
        }
    }
}

/// A right-angled prism of 1.5 turns light by 90° with nothing lost at the hypotenuse.
#[test]
fn prism_reflects_totally_at_45_degrees() {
    let (a, h) = (1.0, 5.0);
    let corners = [(-a, -a), (a, -a), (-a, a)];
    let positions =
        corners.iter().flat_map(|&(x, z)| [Vec3::new(x, -h, -z), Vec3::new(x, h, -z)]).collect();
    let triangles = vec![
        [0, 2, 4],
        [1, 5, 3],
        [0, 1, 3],
        [0, 3, 2],
        [2, 3, 5],
        [2, 5, 4],
        [4, 5, 1],
        [4, 1, 0],
    ];
    let prism = Mesh { positions, triangles, ..Mesh::default() };
    // Light enters through the face at +z, meets the hypotenuse and leaves through that at −x.
    let lamp_at = Transform::translate(Vec3::new(-3.0, 0.0, 0.0))
        * Transform::rotate(Vec3::Y, std::f32::consts::FRAC_PI_2);
    let mut scene = behind_glass(Shape::Sphere { radius: 1e-3 }, Absorption::None, lamp_at);
    let mesh = scene.add_mesh(prism);
    scene.objects[0].shape = Shape::Mesh(mesh);
    let expected = 0.96 * 0.96 / (1.0 - 0.04 * 0.04);
    assert_mean(&render(&scene, small(1024)), expected, 4.0);
}

/// What glass reflects on its outside has not been inside: it takes no colour.
#[test]
fn outer_reflections_are_not_tinted() {
    let mut scene = seen_from(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, 0.001);
    scene.environment = Some(Environment::constant(Rgb::WHITE));
    let mut glass = Dielectric::new(1.5);
    glass.interior.absorption = Absorption::Coefficient(Rgb::new(100.0, 200.0, 300.0));
    let glass = scene.add_material(glass);
    scene.objects.push(Object::new(Shape::Sphere { radius: 1.0 }, glass));
    assert_mean(&render(&scene, small(4096)), 0.04, 4.0);
}

/// Inside coloured glass, light that is chosen and light that is met fade alike.
#[test]
fn both_ways_of_finding_light_fade_in_a_medium() {
    let mut scene = seen_from(Vec3::new(0.0, 0.5, 3.0), Vec3::ZERO, 0.6);
    let mut water = Dielectric::new(1.0);
    water.interior.absorption = Absorption::Coefficient(Rgb::new(0.4, 0.8, 1.6));
    let water = scene.add_material(water);
    let floor = scene.add_material(Matte::new(GREY));
    let lamp = scene.add_material(Emission::radiance(Rgb::grey(5.0)));
    scene.objects.push(Object::new(Shape::Box { size: Vec3::splat(8.0) }, water));
    scene.objects.push(Object::new(Shape::Sphere { radius: 0.5 }, floor));
    scene.objects.push(
        Object::new(Shape::Sphere { radius: 0.4 }, lamp)
            .transformed(&Transform::translate(Vec3::new(0.0, 1.5, 0.5))),
    );
    let by = |strategy| render(&scene, Settings { strategy, ..small(512) });
    let [light, bsdf] = [by(Strategy::LightOnly), by(Strategy::BsdfOnly)];
    for channel in ["R", "G", "B"] {
        let ((a, ea), (b, eb)) = (mean(&light, channel), mean(&bsdf, channel));
        assert!((a - b).abs() < 4.0 * ea.hypot(eb), "{channel}: {a} ± {ea}, {b} ± {eb}");
    }
}

/// A camera inside coloured glass sees through it from the first metre on.
#[test]
fn cameras_stand_in_media_as_well() {
    let mut scene = seen_from(Vec3::ZERO, Vec3::NEG_Z, 0.1);
    let mut glass = Dielectric::new(1.5);
    glass.interior.absorption = Absorption::Coefficient(Rgb::grey(1.0));
    let glass = scene.add_material(glass);
    let lamp = scene.add_material(Emission::radiance(Rgb::WHITE));
    scene.objects.push(Object::new(Shape::Box { size: Vec3::splat(10.0) }, glass));
    let before = Transform::translate(Vec3::new(0.0, 0.0, -0.5));
    scene
        .objects
        .push(Object::new(Shape::Rectangle { size: Vec2::splat(1.0) }, lamp).transformed(&before));
    for integrator in [IntegratorKind::Path, IntegratorKind::Naive, IntegratorKind::Direct] {
        let image = render(&scene, Settings { integrator, ..small(16) });
        let (mean, _) = mean(&image, "G");
        assert!((mean - (-0.5_f64).exp()).abs() < 1e-3, "{integrator:?}: {mean}");
    }
}

/// Depth counts segments: 1 is emission alone, 2 direct light, which a separate integrator gives too.
#[test]
fn depth_counts_segments() {
    let mut scene = seen_from(Vec3::new(0.0, 1.0, 4.0), Vec3::ZERO, 0.8);
    scene.environment = Some(Environment::constant(Rgb::grey(0.3)));
    let matte = scene.add_material(Matte::new(GREY));
    let glass = scene.add_material(Dielectric::new(1.5));
    let lamp = scene.add_material(Emission::radiance(Rgb::grey(4.0)));
    let at = |x, y, z| Transform::translate(Vec3::new(x, y, z));
    for (material, place) in
        [(matte, at(-1.1, 0.0, 0.0)), (glass, at(1.1, 0.0, 0.0)), (lamp, at(0.0, 1.6, 0.0))]
    {
        scene
            .objects
            .push(Object::new(Shape::Sphere { radius: 0.8 }, material).transformed(&place));
    }
    let with =
        |integrator, max_depth| render(&scene, Settings { integrator, max_depth, ..small(512) });
    let (emission, mut black) = (with(IntegratorKind::Path, Some(1)), scene.clone());
    for material in &mut black.materials[..2] {
        material.kind = rutilant::material::MaterialKind::Black;
    }
    assert_eq!(emission.rgb(), render(&black, Settings { max_depth: Some(1), ..small(512) }).rgb());
    let (path, direct) = (with(IntegratorKind::Path, Some(2)), with(IntegratorKind::Direct, None));
    let ((a, ea), (b, eb)) = (mean(&path, "G"), mean(&direct, "G"));
    assert!((a - b).abs() < 4.0 * ea.hypot(eb), "{a} ± {ea}, {b} ± {eb}");
    assert!(mean(&emission, "G").0 < a - 10.0 * ea, "direct light adds to emission");
}

/// What absorbs nothing cannot be seen under an even sky, however rough and from inside as well.
/// Rough surfaces may err by what their table does: half a percent.
#[test]
fn white_balls_vanish_under_an_even_sky() {
    let glass = |roughness| Material::from(Dielectric { roughness, ..Dielectric::new(1.5) });
    let metal = |roughness| Material::from(Conductor::new(Rgb::BLACK, Rgb::WHITE, roughness));
    let clay = Material::from(Matte { roughness: 1.0, ..Matte::new(Rgb::WHITE) });
    let even =
        Material::from(Matte { sampling: HemisphereSampling::Uniform, ..Matte::new(Rgb::WHITE) });
    let film = Material::from(ThinDielectric { ior: 1.33, color: Rgb::WHITE });
    let hole = Material::new(MaterialKind::Null);
    let materials =
        [glass(0.3), glass(0.7), glass(1.0), metal(0.5), metal(1.0), clay, even, film, hole];
    for material in materials {
        let mut scene = seen_from(Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO, 0.55);
        scene.environment = Some(Environment::constant(Rgb::WHITE));
        let kind = format!("{:?}", material.kind);
        let material = scene.add_material(material);
        scene.objects.push(Object::new(Shape::Sphere { radius: 1.0 }, material));
        for integrator in [IntegratorKind::Path, IntegratorKind::Naive] {
            let image = render(&scene, Settings { integrator, ..small(256) });
            let (mean, error) = mean(&image, "G");
            assert!((mean - 1.0).abs() < 5e-3 + 4.0 * error, "{kind}: {mean} ± {error}");
        }
    }
}

/// Surfaces that do not scatter are not there: not for the camera, not for light, not for the tree.
#[test]
fn null_surfaces_change_no_bit() {
    let mut scene = seen_from(Vec3::new(0.0, 1.0, 3.0), Vec3::ZERO, 0.8);
    let floor = scene.add_material(Matte::new(GREY));
    let flat = Transform::rotate(Vec3::X, -std::f32::consts::FRAC_PI_2);
    scene
        .objects
        .push(Object::new(Shape::Rectangle { size: Vec2::splat(4.0) }, floor).transformed(&flat));
    scene.lights.push(Light::Point { position: Vec3::Y, intensity: Rgb::WHITE, group: None });
    let without = render(&scene, small(4)).hash();
    let nothing = scene.add_material(Material::new(MaterialKind::Null));
    for shape in [
        Shape::Sphere { radius: 0.5 },
        Shape::Box { size: Vec3::splat(9.0) },
        Shape::Disk { radius: 3.0 },
        Shape::Rectangle { size: Vec2::splat(5.0) },
    ] {
        scene.objects.insert(0, Object::new(shape, nothing));
    }
    assert_eq!(render(&scene, small(4)).hash(), without);
}

/// What glows and does not scatter adds its light to what is behind it, and throws no shadow:
/// two flames of radiance 0.5 and 0.25 before a sky of 1 make 1.75, and a floor behind the flames
/// has the light of its lamp.
#[test]
fn flames_add_light_and_hide_nothing() {
    let flame = |scene: &mut Scene, radiance: f32, z: f32, turned: f32| {
        let glow = Emission::radiance(Rgb::grey(radiance));
        let glow = Emission { two_sided: true, ..glow };
        let flame = scene.add_material(Material::new(MaterialKind::Null).emitting(glow));
        let place = Transform::translate(Vec3::new(0.0, 0.0, z));
        scene.objects.push(
            Object::new(Shape::Rectangle { size: Vec2::splat(9.0) }, flame)
                .transformed(&(place * Transform::rotate(Vec3::Y, turned))),
        );
    };
    let mut sky = seen_from(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, 0.5);
    sky.environment = Some(Environment::constant(Rgb::WHITE));
    flame(&mut sky, 0.5, 0.0, 0.3);
    flame(&mut sky, 0.25, 1.0, 3.0);
    for integrator in [IntegratorKind::Path, IntegratorKind::Naive, IntegratorKind::Direct] {
        // Passing is no bounce: one segment is enough.
        let settings = Settings { integrator, max_depth: Some(1), ..small(4) };
        assert_mean(&render(&sky, settings), 1.75, 0.0);
    }

    // Straight below a lamp, 2 m away, through a flame that gives next to nothing.
    let mut shadow = seen_from(Vec3::new(0.0, 0.0, 1.0), Vec3::new(0.0, 0.0, -1.0), 0.002);
    let wall = shadow.add_material(Matte::new(GREY));
    shadow.objects.push(
        Object::new(Shape::Rectangle { size: Vec2::splat(4.0) }, wall)
            .transformed(&Transform::translate(Vec3::new(0.0, 0.0, -1.0))),
    );
    let position = Vec3::new(0.0, 0.0, 1.0);
    shadow.lights.push(Light::Point { position, intensity: Rgb::grey(8.0), group: None });
    flame(&mut shadow, 1e-9, 0.0, 0.0);
    for integrator in [IntegratorKind::Path, IntegratorKind::Direct] {
        let image = render(&shadow, Settings { integrator, ..small(64) });
        assert_mean(&image, 0.5 / PI * 2.0, 4.0);
    }
}
