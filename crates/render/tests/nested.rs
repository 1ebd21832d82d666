//! Media that overlap, sorted out by priority: ice in water in glass.

#![expect(clippy::disallowed_methods, reason = "expected values are computed in f64")]

mod common;

use common::{mean, render, small};
use rutilant::Prepared;
use rutilant::camera::{Orthographic, Perspective};
use rutilant::color::Rgb;
use rutilant::geom::{Transform, Vec2, Vec3, real};
use rutilant::light::Environment;
use rutilant::material::{Absorption, Dielectric, Emission, Material, Matte, Medium};
use rutilant::scene::{MaterialId, Scene};
use rutilant::settings::{IntegratorKind, Settings, Strategy};
use rutilant::shape::{Mesh, Object, Shape};
use std::f32::consts::{PI, TAU};

/// A medium with a priority.
fn medium(ior: f32, sigma: f32, priority: u32) -> Dielectric {
    let absorption = Absorption::Coefficient(Rgb::grey(sigma));
    let interior = Medium { ior, absorption };
    Dielectric { interior, priority: Some(priority), ..Dielectric::new(ior) }
}

fn seen_from(position: Vec3, target: Vec3, fov_y: f32) -> Scene {
    Scene::new(Perspective::look_at(position, target, fov_y).unwrap())
}

fn put(scene: &mut Scene, shape: Shape, material: MaterialId, place: Vec3) {
    scene.objects.push(Object::new(shape, material).transformed(&Transform::translate(place)));
}

/// A very wide slab from `from` to `to` along z.
fn slab(scene: &mut Scene, from: f32, to: f32, material: impl Into<Material>) {
    let material = scene.add_material(material);
    let shape = Shape::Box { size: Vec3::new(80.0, 80.0, to - from) };
    put(scene, shape, material, Vec3::new(0.0, 0.0, 0.5 * (from + to)));
}

/// The part of unpolarised light that a border reflects: by amplitudes, in f64.
fn reflected(sine: f64, from: f64, to: f64) -> f64 {
    let cos = |n: f64| (1.0 - (sine / n) * (sine / n)).sqrt();
    let (i, t) = (cos(from), cos(to));
    let s = (from * i - to * t) / (from * i + to * t);
    let p = (to * i - from * t) / (to * i + from * t);
    0.5 * (s * s + p * p)
}

/// Three slabs that overlap, listed in any order: glass of 1.5 to z = 0, water of 1.33 poking
/// into it from behind, oil of 1.8 poking into the water. A slanting ray must come out where
/// Snell's chain through the three layers says, to a fiftieth of a layer, and as bright as the
/// four borders let it: a border that is drawn where a stronger medium hides it, or one with
/// air's index on its far side, moves the light and dims it.
#[test]
fn light_leaves_overlapping_slabs_where_snells_chain_says() {
    // sin θ · n is the same in all layers.
    let sine = 40.0_f64.to_radians().sin();
    let along = |n: f64, thickness: f64| thickness * sine / (n * n - sine * sine).sqrt();
    let layers = [(1.5, 0.4), (1.33, 0.6), (1.8, 0.5)];
    let (front, back) = (0.4_f64, -1.1_f64);
    let start = 3.0_f64;
    let shift: f64 = along(1.0, start - front)
        + layers.iter().map(|&(n, d)| along(n, d)).sum::<f64>()
        + along(1.0, back + 2.0);
    let borders = [(1.0, 1.5), (1.5, 1.33), (1.33, 1.8), (1.8, 1.0)];
    let expected: f64 = borders.iter().map(|&(a, b)| 1.0 - reflected(sine, a, b)).product();

    let glass = |s: &mut Scene| slab(s, 0.0, 0.4, medium(1.5, 0.0, 30));
    let water = |s: &mut Scene| slab(s, -0.6, 0.1, medium(1.33, 0.0, 20));
    let oil = |s: &mut Scene| slab(s, -1.1, -0.5, medium(1.8, 0.0, 10));
    type Put = fn(&mut Scene);
    let orders: [[Put; 3]; 3] = [[glass, water, oil], [oil, water, glass], [water, oil, glass]];
    for order in orders {
        for (offset, lit) in [(0.0, true), (0.02, false), (-0.02, false)] {
            let eye = Vec3::new(0.0, 0.0, start as f32);
            let way = Vec3::new(sine as f32, 0.0, -(1.0 - sine * sine).sqrt() as f32);
            let mut scene = seen_from(eye, eye + way, 1e-4);
            order.iter().for_each(|put| put(&mut scene));
            let lamp = scene.add_material(Emission::radiance(Rgb::WHITE));
            let strip = Shape::Rectangle { size: Vec2::new(0.02, 1.0) };
            let strip_at = Vec3::new((shift + offset) as f32, 0.0, -2.0);
            put(&mut scene, strip, lamp, strip_at);
            for integrator in [IntegratorKind::Path, IntegratorKind::Naive] {
                // Depth 5 has exactly the straight way; longer ones come out elsewhere.
                let settings = Settings { integrator, max_depth: Some(5), ..small(256) };
                let (mean, error) = mean(&render(&scene, settings), "G");
                let expected = if lit { expected } else { 0.0 };
                assert!(
                    (mean - expected).abs() <= 4.0 * error + 1e-4,
                    "{integrator:?} {offset}: {mean} ± {error}, expected {expected}"
                );
            }
        }
    }
}

/// What a stack of layers lets through, seen head on, all reflections between them included:
/// layers are added one by one (Stokes 1862).
fn stack(layers: &[(f64, f64, f64)]) -> f64 {
    // Transmittance, and reflectance seen from the far side.
    let (mut through, mut back) = (1.0, 0.0);
    let mut n = 1.0;
    for &(next, sigma, thickness) in layers.iter().chain([&(1.0, 0.0, 0.0)]) {
        let r = reflected(0.0, n, next);
        let bounces = 1.0 / (1.0 - back * r);
        through *= (1.0 - r) * bounces;
        back = r + (1.0 - r) * (1.0 - r) * back * bounces;
        let left = (-sigma * thickness).exp();
        through *= left;
        back *= left * left;
        n = next;
    }
    through
}

/// Overlapping slabs that absorb transmit by Fresnel and Beer, each layer as thick as its
/// stronger neighbours leave it, from both sides, for every integrator that sees that far.
/// Absorption counted for a medium that is overlapped, or twice where two overlap, shows here.
#[test]
fn stacks_of_slabs_transmit_by_fresnel_and_beer() {
    let layers = [(1.5, 0.8, 0.4), (1.33, 2.0, 0.6), (1.31, 0.3, 0.5)];
    let expected = stack(&layers);
    for from_behind in [false, true] {
        let (eye, lamp_at) = if from_behind { (-4.0, 2.0) } else { (3.0, -3.0) };
        let mut scene = seen_from(Vec3::new(0.0, 0.0, eye), Vec3::ZERO, 1e-3);
        slab(&mut scene, -0.6, 0.25, medium(1.33, 2.0, 5));
        slab(&mut scene, 0.0, 0.4, medium(1.5, 0.8, 9));
        slab(&mut scene, -1.1, 0.1, medium(1.31, 0.3, 1));
        let lamp =
            scene.add_material(Emission { two_sided: true, ..Emission::radiance(Rgb::WHITE) });
        put(&mut scene, Shape::Rectangle { size: Vec2::splat(1.0) }, lamp, Vec3::Z * lamp_at);
        for integrator in [IntegratorKind::Path, IntegratorKind::Naive] {
            let image = render(&scene, Settings { integrator, ..small(2048) });
            let (mean, error) = mean(&image, "G");
            assert!(
                (mean - expected).abs() < 4.0 * error + 1e-3 * expected,
                "{integrator:?}: {mean} ± {error}, expected {expected}"
            );
        }
    }
}

/// A camera where two media overlap stands in the stronger one, and the weaker is still around
/// when that one ends: light fades by both in turn, and grows by the square of the index.
#[test]
fn cameras_stand_in_several_media() {
    let mut scene = seen_from(Vec3::new(0.01, 0.02, 0.0), Vec3::new(0.01, 0.02, -1.0), 1e-3);
    // So thick behind the camera that nothing comes back from there.
    slab(&mut scene, -1.0, 40.0, medium(1.33, 3.0, 1));
    slab(&mut scene, -0.5, 40.0, medium(1.5, 1.0, 2));
    let lamp = scene.add_material(Emission::radiance(Rgb::WHITE));
    put(&mut scene, Shape::Rectangle { size: Vec2::splat(4.0) }, lamp, Vec3::Z * -1.2);
    let (a, b) = (reflected(0.0, 1.5, 1.33), reflected(0.0, 1.33, 1.0));
    let between = (-3.0_f64 * 0.5).exp();
    let expected = 1.5 * 1.5 * (-0.5_f64).exp() * (1.0 - a) * between * (1.0 - b)
        / (1.0 - a * b * between * between);
    for integrator in [IntegratorKind::Path, IntegratorKind::Naive] {
        let image = render(&scene, Settings { integrator, ..small(1024) });
        let (mean, error) = mean(&image, "G");
        assert!(
            (mean - expected).abs() < 4.0 * error + 1e-3 * expected,
            "{integrator:?}: {mean} ± {error}, expected {expected}"
        );
    }
}

/// A body of the same index as what it lies in is not seen: with the same random numbers the
/// picture is the same, whichever of the two is stronger, for two bodies of one material that
/// overlap, and for one that surrounds everything with the index of air.
#[test]
fn bodies_of_equal_index_are_invisible() {
    let scene_with = |add: &dyn Fn(&mut Scene)| {
        let mut scene = seen_from(Vec3::new(0.4, 1.0, 5.0), Vec3::ZERO, 0.5);
        scene.environment = Some(Environment::constant(Rgb::new(0.2, 0.5, 1.0)));
        let lamp = scene.add_material(Emission::radiance(Rgb::grey(3.0)));
        put(&mut scene, Shape::Sphere { radius: 0.7 }, lamp, Vec3::new(1.0, 1.0, -3.0));
        let glass = scene.add_material(medium(1.5, 0.3, 5));
        put(&mut scene, Shape::Box { size: Vec3::splat(1.6) }, glass, Vec3::ZERO);
        add(&mut scene);
        scene
    };
    // Few bounces: two ways of rounding drift apart over many.
    let settings = Settings { max_depth: Some(6), ..small(64) };
    let alone = render(&scene_with(&|_| {}), settings.clone());
    let ball = |scene: &mut Scene, material: MaterialId, radius: f32| {
        put(scene, Shape::Sphere { radius }, material, Vec3::new(0.1, 0.2, 0.0));
    };
    type Add<'a> = (&'a str, &'a dyn Fn(&mut Scene));
    let additions: [Add<'_>; 4] = [
        ("weaker", &|s| {
            let other = s.add_material(medium(1.5, 0.3, 1));
            ball(s, other, 0.5);
        }),
        ("stronger", &|s| {
            let other = s.add_material(medium(1.5, 0.3, 9));
            ball(s, other, 0.5);
        }),
        ("the same", &|s| ball(s, MaterialId(1), 0.5)),
        ("air around all", &|s| {
            let air = s.add_material(medium(1.0, 0.0, 0));
            ball(s, air, 20.0);
        }),
    ];
    for (name, add) in additions {
        let with = render(&scene_with(add), settings.clone());
        let pairs = alone.rgb().unwrap().into_iter().zip(with.rgb().unwrap());
        let far = |(a, b): ([f32; 3], [f32; 3])| {
            a.iter().zip(b).any(|(a, b)| (a - b).abs() > 1e-3 * a.max(0.1))
        };
        // A ray at an edge may go the other way for a different last digit.
        let differing = pairs.filter(|pair| far(*pair)).count();
        assert!(differing <= 2, "{name}: {differing} of 256 pixels differ");
    }
}

/// Light that lies beyond surfaces which are no borders is found in full by every strategy:
/// shadow rays are blocked there, and what they cannot find must not be weighed against them.
#[test]
fn light_beyond_what_is_no_border_is_found_in_full() {
    let expected = 0.5 * 10.0 * (0.5_f64 / 2.0).powi(2);
    let mut scene = seen_from(Vec3::new(1.0, 0.5, 1.0), Vec3::ZERO, 0.002);
    let floor = scene.add_material(Matte::new(Rgb::grey(0.5)));
    let lamp = scene.add_material(Emission::radiance(Rgb::grey(10.0)));
    let flat = Transform::rotate(Vec3::X, -std::f32::consts::FRAC_PI_2);
    scene
        .objects
        .push(Object::new(Shape::Rectangle { size: Vec2::splat(4.0) }, floor).transformed(&flat));
    put(&mut scene, Shape::Sphere { radius: 0.5 }, lamp, Vec3::Y * 2.0);
    // Half of the way to the lamp, and half of the lamp's disk seen from the floor, is veiled.
    let veil = scene.add_material(medium(1.0, 0.0, 3));
    let size = Vec3::new(1.0, 0.3, 3.0);
    put(&mut scene, Shape::Box { size }, veil, Vec3::new(-0.5, 0.7, 0.0));
    let base = Settings { max_depth: Some(2), ..small(1024) };
    for settings in [
        Settings { strategy: Strategy::Both, ..base.clone() },
        Settings { strategy: Strategy::LightOnly, ..base.clone() },
        Settings { strategy: Strategy::BsdfOnly, ..base.clone() },
        Settings { integrator: IntegratorKind::Naive, ..base.clone() },
        Settings { integrator: IntegratorKind::Direct, ..base.clone() },
    ] {
        let (mean, error) = mean(&render(&scene, settings.clone()), "G");
        assert!(
            (mean - expected).abs() < 4.0 * error + 1e-4,
            "{:?} {:?}: {mean} ± {error}, expected {expected}",
            settings.integrator,
            settings.strategy
        );
    }
}

/// Clear media that overlap vanish in the furnace as one body does: no light is lost or made
/// where surfaces are passed.
#[test]
fn overlapping_clear_media_vanish_in_the_furnace() {
    let mut scene = seen_from(Vec3::new(0.4, 1.0, 4.0), Vec3::ZERO, 0.7);
    scene.environment = Some(Environment::constant(Rgb::WHITE));
    for (i, ior) in [1.5, 1.33, 1.31, 1.7].into_iter().enumerate() {
        let place = Vec3::new(0.3 * i as f32 - 0.4, 0.2 * (i % 2) as f32, 0.1 * i as f32);
        let material = scene.add_material(medium(ior, 0.0, i as u32 % 3));
        put(&mut scene, Shape::Sphere { radius: 0.6 }, material, place);
        put(&mut scene, Shape::Box { size: Vec3::splat(0.7) }, material, -place);
    }
    let (overlapping, _) = mean(&render(&scene, small(256)), "G");
    assert!((overlapping - 1.0).abs() < 2e-3, "{overlapping}");

    // Shells within shells, as many as a list holds and more, weaker and weaker or stronger and
    // stronger: those overlooked take no light and make none.
    for (inwards, shells) in [(false, 8), (true, 8), (false, 12), (true, 12)] {
        scene.objects.clear();
        for i in 0..shells {
            let priority = if inwards { i } else { shells - i };
            let shell = scene.add_material(medium(1.2 + 0.05 * (i % 4) as f32, 0.0, priority));
            let radius = 1.2 - 0.08 * i as f32;
            put(&mut scene, Shape::Sphere { radius }, shell, Vec3::ZERO);
        }
        let (shells, _) = mean(&render(&scene, small(64)), "G");
        assert!((shells - 1.0).abs() < 2e-3, "{shells}");
    }
}

/// Bodies that are open, wound inside out, or both break nothing: every sample is a number, and
/// none is brighter than radiance can grow within these indices.
#[test]
fn broken_bodies_break_nothing() {
    let mut cube = Mesh::default();
    for i in 0..8 {
        cube.positions.push(Vec3::from([0, 1, 2].map(|a| (i >> a & 1) as f32 * 1.4 - 0.7)));
    }
    let faces =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = |faces: &[[u32; 4]]| -> Vec<[u32; 3]> {
        faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect()
    };
    cube.triangles = triangles(&faces);
    let open = Mesh { triangles: triangles(&faces[..4]), ..cube.clone() };
    let sheet = Mesh { triangles: triangles(&faces[3..4]), ..cube.clone() };
    let mut mixed = cube.clone();
    mixed.triangles.iter_mut().step_by(3).for_each(|t| t.swap(1, 2));
    let twice = Mesh { triangles: [&*cube.triangles, &*cube.triangles].concat(), ..cube.clone() };
    for (i, mesh) in [open, sheet, mixed, twice].into_iter().enumerate() {
        for eye in [Vec3::new(0.4, 1.0, 4.0), Vec3::new(0.1, 0.2, 0.3)] {
            let mut scene = seen_from(eye, Vec3::ZERO, 0.7);
            scene.environment = Some(Environment::constant(Rgb::WHITE));
            let glass = scene.add_material(medium(1.5, 0.1, 1));
            let water = scene.add_material(medium(1.33, 0.2, 2));
            let mesh = scene.add_mesh(mesh.clone());
            put(&mut scene, Shape::Mesh(mesh), glass, Vec3::ZERO);
            put(&mut scene, Shape::Mesh(mesh), water, Vec3::splat(0.3));
            put(&mut scene, Shape::Sphere { radius: 0.5 }, water, Vec3::splat(-0.2));
            for integrator in [IntegratorKind::Path, IntegratorKind::Naive, IntegratorKind::Direct]
            {
                // `render` sees to it that no sample is dropped. Direct light may find nothing.
                let image = render(&scene, Settings { integrator, ..small(32) });
                let (mean, _) = mean(&image, "G");
                let least = if integrator == IntegratorKind::Direct { 0.0 } else { 0.01 };
                assert!(mean >= least && mean < 1.5 * 1.5, "mesh {i}, {integrator:?}: {mean}");
            }
        }
    }
}

/// More media at one point than a list holds break nothing, and are told of.
#[test]
fn too_many_media_break_nothing() {
    let mut scene = seen_from(Vec3::new(0.4, 1.0, 4.0), Vec3::ZERO, 0.7);
    scene.environment = Some(Environment::constant(Rgb::WHITE));
    for i in 0..30 {
        let shell = scene.add_material(medium(1.2 + 0.02 * (i % 7) as f32, 0.1, i));
        put(&mut scene, Shape::Sphere { radius: 1.2 - 0.03 * i as f32 }, shell, Vec3::ZERO);
    }
    let prepared = Prepared::new(&scene).unwrap();
    let notes = &prepared.report().notes;
    assert!(
        notes[0].what.starts_with("30 materials have a priority; where more than 8"),
        "{notes:?}"
    );
    let (shells, _) = mean(&render(&scene, small(64)), "G");
    assert!(shells > 0.1 && shells < 2.0, "{shells}");
}

/// Where equal media are nested with one index each, no depth is spent on surfaces that are no
/// borders: at a depth of 3 a lamp is seen through as many of them as there are.
#[test]
fn passing_through_costs_no_depth() {
    let mut scene = seen_from(Vec3::Z * 3.0, Vec3::ZERO, 1e-3);
    for i in 0..6 {
        slab(&mut scene, -0.5 + 0.05 * i as f32, 0.5 - 0.05 * i as f32, medium(1.5, 0.0, 9 - i));
    }
    let lamp = scene.add_material(Emission::radiance(Rgb::WHITE));
    put(&mut scene, Shape::Rectangle { size: Vec2::splat(1.0) }, lamp, Vec3::Z * -2.0);
    let settings = Settings { max_depth: Some(3), ..small(512) };
    let (mean, error) = mean(&render(&scene, settings), "G");
    let expected = 0.96 * 0.96;
    assert!((mean - expected).abs() < 4.0 * error + 1e-4, "{mean} ± {error}");
}

/// The focus goes through overlapping media as light does: seen head on, each metre of a layer
/// counts 1/n, and a layer ends where a stronger one begins.
#[test]
fn the_focus_goes_through_overlapping_media() {
    let mut scene = seen_from(Vec3::Z * 3.0, Vec3::ZERO, 0.5);
    slab(&mut scene, -0.6, 0.1, medium(1.33, 0.0, 1));
    slab(&mut scene, 0.0, 0.4, medium(1.5, 0.0, 2));
    let wall = scene.add_material(Matte::new(Rgb::grey(0.5)));
    put(&mut scene, Shape::Rectangle { size: Vec2::splat(9.0) }, wall, Vec3::Z * -2.0);
    let focus = Prepared::new(&scene).unwrap().focus_on([64, 64], Vec2::splat(0.5)).unwrap();
    let expected = 2.6 + 0.4 / 1.5 + 0.6 / 1.33 + 1.4;
    assert!((f64::from(focus.distance) - expected).abs() < 1e-5, "{focus:?}, not {expected}");
    assert!((focus.path_length - 5.0).abs() < 1e-5);
    assert_eq!(focus.bounces, 3);
}

/// Bodies that touch face to face, instead of overlapping, meet each other and nothing else: two
/// halves of glass are one block, and water stands against glass, in whichever order they are
/// listed. Only one of two coincident faces can be hit; the other must not be forgotten, or the
/// path believes itself in water for ever after.
#[test]
fn bodies_that_touch_meet_each_other() {
    let layers = [(1.5, 0.8, 0.4), (1.33, 2.0, 0.6)];
    type Put = fn(&mut Scene);
    let front: Put = |s| slab(s, 0.2, 0.4, medium(1.5, 0.8, 7));
    let back: Put = |s| slab(s, 0.0, 0.2, medium(1.5, 0.8, 3));
    let water: Put = |s| slab(s, -0.6, 0.0, medium(1.33, 2.0, 5));
    let orders = [[front, back, water], [water, back, front], [back, water, front]];
    for order in orders {
        for from_behind in [false, true] {
            let (eye, lamp_at) = if from_behind { (-4.0, 2.0) } else { (3.0, -3.0) };
            let mut scene = seen_from(Vec3::new(0.3, 0.1, eye), Vec3::new(0.3, 0.1, 0.0), 1e-3);
            order.iter().for_each(|put| put(&mut scene));
            let glow = Emission { two_sided: true, ..Emission::radiance(Rgb::WHITE) };
            let lamp = scene.add_material(glow);
            put(&mut scene, Shape::Rectangle { size: Vec2::splat(4.0) }, lamp, Vec3::Z * lamp_at);
            let (mean, error) = mean(&render(&scene, small(1024)), "G");
            let expected = stack(&layers);
            assert!(
                (mean - expected).abs() < 4.0 * error + 1e-3 * expected,
                "{mean} ± {error}, expected {expected}"
            );
        }
    }
}

/// Without a priority a border declares the indices on its sides; what absorbs around it is what
/// absorbed before it was met. A hollow in coloured glass, clear glass in coloured water, and a
/// camera in such a hollow: no layer loses its colour in front of what lies in it. All indices are
/// 1 here, so that what is left is e to the metres of colour.
#[test]
fn what_lies_in_a_coloured_medium_leaves_it_its_colour() {
    let clear = |sigma: f32| {
        let absorption = Absorption::Coefficient(Rgb::grey(sigma));
        Dielectric { interior: Medium { ior: 1.0, absorption }, ..Dielectric::new(1.0) }
    };
    // Where the slabs are, what each absorbs, where the eye is, how thick all the colour is.
    type Slab = (f32, f32, f32);
    let cases: [(&str, &[Slab], f32, f64); 5] = [
        ("coloured", &[(-1.0, 1.0, 1.0)], 3.0, 2.0),
        ("a hollow", &[(-1.0, 1.0, 1.0), (-0.5, 0.5, 0.0)], 3.0, 1.0),
        (
            "two, one in the other",
            &[(-1.0, 1.0, 1.0), (-0.6, 0.6, 0.5), (-0.2, 0.2, 0.0)],
            3.0,
            1.2,
        ),
        ("seen from the hollow", &[(-1.0, 1.0, 1.0), (-0.5, 0.5, 0.0)], 0.1, 0.5),
        ("seen from the colour", &[(-1.0, 1.0, 1.0), (-0.5, 0.5, 0.0)], 0.75, 0.75),
    ];
    for (name, slabs, eye, metres) in cases {
        let mut scene = seen_from(Vec3::new(0.0, 0.0, eye), Vec3::NEG_Z * 9.0, 1e-3);
        for &(from, to, sigma) in slabs {
            slab(&mut scene, from, to, clear(sigma));
        }
        let lamp = scene.add_material(Emission::radiance(Rgb::WHITE));
        put(&mut scene, Shape::Rectangle { size: Vec2::splat(4.0) }, lamp, Vec3::Z * -3.0);
        for integrator in [IntegratorKind::Path, IntegratorKind::Naive] {
            let image = render(&scene, Settings { integrator, ..small(1024) });
            let (mean, error) = mean(&image, "G");
            let expected = (-metres).exp();
            assert!(
                (mean - expected).abs() < 4.0 * error + 1e-4,
                "{name}, {integrator:?}: {mean} ± {error}, expected {expected}"
            );
        }
    }
}

/// A matte floor in coloured water, under a hollow, and a small lamp beside it in the water: what
/// the lamp sends to the floor fades as much as what the floor sends up.
#[test]
fn direct_light_fades_under_a_hollow() {
    let water = Dielectric {
        interior: Medium { ior: 1.0, absorption: Absorption::Coefficient(Rgb::grey(1.0)) },
        ..Dielectric::new(1.0)
    };
    let picture = |coloured: bool| {
        let mut scene = seen_from(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, 1e-3);
        if coloured {
            slab(&mut scene, -1.0, 1.0, water);
            slab(&mut scene, -0.2, 0.6, Dielectric::new(1.0));
        }
        let floor = scene.add_material(Matte::new(Rgb::grey(0.8)));
        put(&mut scene, Shape::Rectangle { size: Vec2::splat(4.0) }, floor, Vec3::Z * -0.9);
        let lamp = scene.add_material(Emission::radiance(Rgb::grey(1e4)));
        let down = Transform::rotate_degrees(Vec3::X, 180.0);
        let at = Transform::translate(Vec3::new(0.5, 0.0, -0.4)) * down;
        let shape = Shape::Rectangle { size: Vec2::splat(1e-2) };
        scene.objects.push(Object::new(shape, lamp).transformed(&at));
        // Enough for both slabs and the floor, and no light between floor and lamp.
        mean(&render(&scene, Settings { max_depth: Some(6), ..small(4096) }), "G")
    };
    let ((clear, clear_error), (faded, error)) = (picture(false), picture(true));
    // Half a metre down and across to the floor; 0.7 m of water under the hollow, 0.4 m above it.
    let kept = (-(0.5_f64.hypot(0.5) + 1.1)).exp();
    let expected = clear * kept;
    let error = error.hypot(clear_error * kept);
    assert!(
        clear > 0.0 && (faded - expected).abs() < 4.0 * error + 2e-3 * expected,
        "{faded} ± {error}, expected {expected}"
    );
}

/// A pane of glass with water behind it, modelled by its borders alone: air to glass, glass to
/// water, water to air, each a sheet. A camera in the air sees the sky beside it as it is,
/// although the water is left on the axis by a border that was never entered.
#[test]
fn borders_modelled_one_by_one_leave_the_camera_in_the_air() {
    let sheet = |scene: &mut Scene, z: f32, interior: Medium, exterior: Medium, turned: bool| {
        let material =
            scene.add_material(Dielectric { interior, exterior, ..Dielectric::new(1.0) });
        let turn = Transform::rotate_degrees(Vec3::Y, if turned { 180.0 } else { 0.0 });
        let place = Transform::translate(Vec3::new(0.0, 0.0, z)) * turn;
        let shape = Shape::Rectangle { size: Vec2::splat(2.0) };
        scene.objects.push(Object::new(shape, material).transformed(&place));
    };
    let coloured =
        |ior, sigma| Medium { ior, absorption: Absorption::Coefficient(Rgb::grey(sigma)) };
    let (glass, water) = (coloured(1.5, 1.0), coloured(1.33, 2.0));
    // As scenes in files say it: an exterior has an index, and no colour.
    let water_unsaid = coloured(1.33, 0.0);
    for exterior in [water, water_unsaid] {
        let mut scene = seen_from(Vec3::Z * 3.0, Vec3::ZERO, 1.5);
        scene.environment = Some(Environment::constant(Rgb::WHITE));
        sheet(&mut scene, 0.4, glass, Medium::AIR, false);
        sheet(&mut scene, 0.0, glass, exterior, true);
        sheet(&mut scene, -1.0, water, Medium::AIR, true);
        let image = render(&scene, small(16));
        assert_eq!(image.channel("G").unwrap()[0], 1.0, "{exterior:?}");
    }
}

/// A white ball of triangles that looks round, in a shell of glass that lies nearer to it than the
/// ball's triangles to what they stand for. What sends on all light shows as much of an even sky as
/// there is. Rays that start on the ball as it looks, and not as it is, would be inside of the glass
/// without having come in, and most of them never get out: a third of the light would be left.
#[test]
fn a_white_ball_close_under_glass_vanishes_in_the_furnace() {
    let ball = |radius: f32, turned: bool| {
        let (rings, segments) = (10_u32, 20_u32);
        let mut mesh = Mesh::default();
        for i in 0..=rings {
            let (ring, height) = real::sin_cos(PI * i as f32 / rings as f32);
            for j in 0..segments {
                let (y, x) = real::sin_cos(TAU * j as f32 / segments as f32);
                let out = Vec3::new(ring * x, ring * y, height);
                mesh.positions.push(radius * out);
                mesh.normals.push(out);
            }
        }
        for i in 0..rings {
            for j in 0..segments {
                let at = |i: u32, j: u32| i * segments + j % segments;
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        if turned {
            mesh.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        }
        mesh
    };
    let camera = Orthographic::look_at(3.0 * Vec3::Z, Vec3::ZERO, 1.2).unwrap();
    let mut scene = Scene::new(camera);
    scene.environment = Some(Environment::constant(Rgb::WHITE));
    let white = scene.add_material(Matte::new(Rgb::WHITE));
    let glass = scene.add_material(Dielectric::new(1.5));
    let flat = |mesh: Mesh| Mesh { normals: Vec::new(), ..mesh };
    let within = (ball(1.0, false), white);
    let shell = [(1.002, true), (1.05, false)].map(|(r, turned)| (flat(ball(r, turned)), glass));
    for (mesh, material) in std::iter::once(within).chain(shell) {
        let mesh = scene.add_mesh(mesh);
        scene.objects.push(Object::new(Shape::Mesh(mesh), material));
    }
    let settings = Settings { max_depth: Some(300), ..small(256) };
    let (seen, _) = mean(&render(&scene, settings), "G");
    assert!((seen - 1.0).abs() < 0.02, "{seen}");
}
