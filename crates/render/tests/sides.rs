//! Surfaces that have only a front: what rays, lamps and light paths make of them.

mod common;

use common::{assert_mean, mean, render, small};
use rutilant::Prepared;
use rutilant::camera::{Orthographic, Perspective};
use rutilant::color::Rgb;
use rutilant::geom::{BuildOptions, Transform, Vec2, Vec3};
use rutilant::light::Environment;
use rutilant::material::{
    Dielectric, Emission, EmittedLight, Material, MaterialKind, Matte, Mirror, Principled, Sides,
    ThinDielectric,
};
use rutilant::scene::{MaterialId, Scene};
use rutilant::settings::{SamplerKind, Settings, Strategy};
use rutilant::shape::{Mesh, Object, Shape};
use std::f32::consts::{FRAC_PI_2, PI};

const WIDE: Shape = Shape::Rectangle { size: Vec2::splat(4000.0) };

fn one_sided(material: impl Into<Material>) -> Material {
    Material { sides: Sides::Front, ..material.into() }
}

fn black() -> Material {
    Material::new(MaterialKind::Black)
}

fn put(scene: &mut Scene, shape: Shape, material: MaterialId, place: Transform) {
    scene.objects.push(Object::new(shape, material).transformed(&place));
}

fn at(z: f32) -> Transform {
    Transform::translate(z * Vec3::Z)
}

/// Turns a rectangle, whose front is along z, over.
fn over() -> Transform {
    Transform::rotate(Vec3::Y, PI)
}

/// Before a white sky a black surface is black from its front and not there from behind: a wall, one
/// that is mirrored, and a ball around the eye. What lets light through is there from both sides.
#[test]
fn a_surface_with_only_a_front_is_not_there_from_behind() {
    let seen = |shape: Shape, material: Material, place: Transform, expected: f64| {
        let camera = Orthographic::look_at(3.0 * Vec3::Z, Vec3::ZERO, 1.0).unwrap();
        let mut scene = Scene::new(camera);
        scene.environment = Some(Environment::constant(Rgb::WHITE));
        let material = scene.add_material(material);
        put(&mut scene, shape, material, place);
        assert_mean(&render(&scene, small(4)), expected, 0.0);
    };
    let mirrored = Transform::scale(Vec3::new(-1.0, 1.0, 1.0));
    seen(WIDE, one_sided(black()), Transform::IDENTITY, 0.0);
    seen(WIDE, one_sided(black()), mirrored, 0.0);
    seen(WIDE, one_sided(black()), over(), 1.0);
    seen(WIDE, one_sided(black()), mirrored * over(), 1.0);
    seen(WIDE, black(), over(), 0.0);
    seen(Shape::Sphere { radius: 2.0 }, one_sided(black()), Transform::IDENTITY, 0.0);
    seen(Shape::Sphere { radius: 9.0 }, one_sided(black()), Transform::IDENTITY, 1.0);
    let pane = ThinDielectric { ior: 1.0, color: Rgb::BLACK };
    seen(WIDE, one_sided(pane), over(), 0.0);
    let (base_color, transmission) = (Rgb::BLACK, 0.5);
    let layers = Principled { base_color, transmission, specular: 0.0, ..Principled::default() };
    seen(WIDE, one_sided(Principled { thin_walled: true, ..layers }), over(), 0.0);

    // A body of glass is met from within.
    let glass = |material: Material| {
        let camera = Orthographic::look_at(3.0 * Vec3::Z, Vec3::ZERO, 1.0).unwrap();
        let mut scene = Scene::new(camera);
        scene.environment = Some(Environment::constant(Rgb::WHITE));
        let [glass, floor] = [material, black()].map(|m| scene.add_material(m));
        put(&mut scene, Shape::Sphere { radius: 0.4 }, glass, Transform::IDENTITY);
        put(&mut scene, Shape::Rectangle { size: Vec2::ONE }, floor, at(-0.6));
        render(&scene, small(4)).hash()
    };
    assert_eq!(glass(one_sided(Dielectric::new(1.5))), glass(Dielectric::new(1.5).into()));
}

/// A floor under an endless lamp, seen from between the two, with something at half the height.
fn floor_and_lamp(between: Material, turn: Transform, lamp: Material) -> Scene {
    let camera = Orthographic::look_at(0.5 * Vec3::Z, Vec3::ZERO, 1.0).unwrap();
    let mut scene = Scene::new(camera);
    let floor = scene.add_material(Matte::new(Rgb::WHITE));
    let between = scene.add_material(between);
    let lamp = scene.add_material(lamp);
    put(&mut scene, Shape::Rectangle { size: Vec2::splat(2.0) }, floor, Transform::IDENTITY);
    put(&mut scene, WIDE, between, at(1.0) * turn);
    put(&mut scene, WIDE, lamp, at(2.0) * over());
    scene
}

/// A wall keeps light from a floor if its front faces the floor, and not if its back does: by light
/// sampling, by scattered rays, and by both.
#[test]
fn light_comes_through_backs() {
    for (turn, expected) in [(Transform::IDENTITY, 1.0), (over(), 0.0)] {
        for strategy in [Strategy::Both, Strategy::LightOnly, Strategy::BsdfOnly] {
            let lamp = Emission::radiance(Rgb::WHITE).into();
            let scene = floor_and_lamp(one_sided(black()), turn, lamp);
            let settings = Settings { strategy, max_depth: Some(2), ..small(256) };
            assert_mean(&render(&scene, settings), expected, 4.5);
        }
    }
}

/// A face that is there twice, once for each side, is a face with two sides: whichever of the two
/// comes first, in one mesh, in two, in meshes that are stored once; for the eye on both sides, and
/// for the light that it keeps from a floor. Where the back is met first the front must not be lost.
#[test]
fn faces_wound_both_ways_have_two_sides() {
    let (a, b, c, d) = ([0, 1, 2], [0, 2, 3], [2, 1, 0], [3, 2, 0]);
    let corner = |x, y| 2000.0 * Vec3::new(x, y, 0.0);
    let positions = vec![corner(-1., -1.), corner(1., -1.), corner(1., 1.), corner(-1., 1.)];
    let mesh = |triangles: &[[u32; 3]]| Mesh {
        positions: positions.clone(),
        triangles: triangles.to_vec(),
        ..Mesh::default()
    };
    for meshes in [
        vec![mesh(&[a, b, c, d])],
        vec![mesh(&[c, d, a, b])],
        vec![mesh(&[a, d, b, c])],
        vec![mesh(&[a, b]), mesh(&[d, c])],
        vec![mesh(&[c, d]), mesh(&[b, a])],
    ] {
        let add = |scene: &mut Scene, material: Material, place: Transform| {
            let material = scene.add_material(material);
            for mesh in &meshes {
                let shape = Shape::Mesh(scene.add_mesh(mesh.clone()));
                put(scene, shape, material, place);
            }
        };
        let assert_mean = |scene: &Scene, settings: Settings, expected, sigmas| {
            for copies in [u32::MAX, 0] {
                let options = BuildOptions { copies, ..BuildOptions::default() };
                let prepared = Prepared::with_options(scene, &options).unwrap();
                assert_mean(&common::render_prepared(prepared, settings.clone()), expected, sigmas);
            }
        };
        for turn in [Transform::IDENTITY, over()] {
            let camera = Orthographic::look_at(3.0 * Vec3::Z, Vec3::ZERO, 1.0).unwrap();
            let mut scene = Scene::new(camera);
            scene.environment = Some(Environment::constant(Rgb::WHITE));
            add(&mut scene, one_sided(Matte::new(Rgb::grey(0.5))), turn);
            assert_mean(&scene, small(4), 0.5, 0.0);
        }
        for strategy in [Strategy::Both, Strategy::LightOnly, Strategy::BsdfOnly] {
            let mut scene = floor_and_lamp(black(), at(0.0), Emission::radiance(Rgb::WHITE).into());
            scene.objects.remove(1);
            add(&mut scene, one_sided(black()), at(1.0));
            let settings = Settings { strategy, max_depth: Some(2), ..small(16) };
            assert_mean(&scene, settings, 0.0, 0.0);
        }
    }
}

/// The back of a lamp that has only a front gives no light, even where both its sides should: its
/// power is that of its front, and what lies behind it stays dark by every strategy.
#[test]
fn the_back_of_a_lamp_gives_no_light() {
    let glow = |sides| {
        let light = EmittedLight::Power(Rgb::grey(PI * 16e6));
        let lamp =
            Emission { two_sided: true, ..Emission { light, ..Emission::radiance(Rgb::WHITE) } };
        Material { sides, ..lamp.into() }
    };
    for strategy in [Strategy::Both, Strategy::LightOnly, Strategy::BsdfOnly] {
        let settings = Settings { strategy, max_depth: Some(2), ..small(256) };
        // Both sides share the power; a front has all of it.
        for (sides, expected) in [(Sides::Both, 0.5), (Sides::Front, 1.0)] {
            let scene = floor_and_lamp(Material::new(MaterialKind::Null), at(0.0), glow(sides));
            assert_mean(&render(&scene, settings.clone()), expected, 4.5);
        }
        // The lamp's back is towards the floor.
        let mut dark =
            floor_and_lamp(Material::new(MaterialKind::Null), at(0.0), glow(Sides::Front));
        dark.objects[2].world_from_object = at(2.0);
        assert_mean(&render(&dark, settings), 0.0, 0.0);
    }
}

/// Caustics stay what chance finds where surfaces with only a front stand in the way of light: a
/// sheet between glass and floor, either way up and both in one place, a mirror, and a floor that is
/// itself one. Light
/// that is stopped where the camera sees it, or counted twice behind a front, shows here.
#[test]
fn caustics_agree_on_fronts() {
    let camera = Perspective::look_at(Vec3::new(0.0, 1.6, 2.0), Vec3::new(0.1, 0.0, 0.1), 0.6);
    let rectangle = |side| Shape::Rectangle { size: Vec2::splat(side) };
    let (up, down) =
        (Transform::rotate(Vec3::X, -FRAC_PI_2), Transform::rotate(Vec3::X, FRAC_PI_2));
    let place = |x, y, z| Transform::translate(Vec3::new(x, y, z));
    let (matte, mirror) = (Matte::new(Rgb::grey(0.5)), Mirror { reflectance: Rgb::grey(0.9) });
    for (sheet, turns) in [
        (one_sided(matte), vec![up]),
        (one_sided(matte), vec![down]),
        (one_sided(matte), vec![up, down]),
        (one_sided(matte), vec![down, up]),
        (one_sided(mirror), vec![up]),
        (one_sided(mirror), vec![down]),
    ] {
        let mut scene = Scene::new(camera.unwrap());
        let floor = scene.add_material(one_sided(Matte::new(Rgb::grey(0.7))));
        let glass = scene.add_material(one_sided(Dielectric::new(1.5)));
        let lamp = scene.add_material(Emission::radiance(Rgb::grey(10.0)));
        let sheet = scene.add_material(sheet);
        put(&mut scene, rectangle(40.0), floor, up);
        put(&mut scene, Shape::Sphere { radius: 0.3 }, glass, place(0.0, 0.5, 0.0));
        put(&mut scene, Shape::Sphere { radius: 0.3 }, lamp, place(-0.9, 2.4, -0.8));
        for turn in turns {
            put(&mut scene, rectangle(0.5), sheet, place(0.15, 0.12, 0.2) * turn);
            put(&mut scene, rectangle(1.0), sheet, place(-0.45, 1.45, -0.4) * turn);
        }
        let settings = Settings { size: [16, 16], sampler: SamplerKind::Sobol, ..small(1024) };
        let with = mean(&render(&scene, settings.clone()), "G").0;
        let without = mean(&render(&scene, Settings { caustics: false, ..settings }), "G").0;
        println!("{with} for {without}");
        assert!((with / without - 1.0).abs() < 0.01, "{with} for {without}");
    }
}
