//! Media that overlap give the picture of the same bodies with every border declared.

mod common;

use common::{disagreement, render};
use rutilant::camera::Perspective;
use rutilant::color::Rgb;
use rutilant::geom::{Transform, Vec2, Vec3};
use rutilant::light::Environment;
use rutilant::material::{Absorption, Dielectric, Emission, Matte, Medium};
use rutilant::scene::{MaterialId, Scene};
use rutilant::settings::IntegratorKind;
use rutilant::shape::{Mesh, Object, Shape};

const GLASS: Medium =
    Medium { ior: 1.5, absorption: Absorption::Coefficient(Rgb::new(0.6, 0.2, 0.6)) };
const WATER: Medium =
    Medium { ior: 1.33, absorption: Absorption::Coefficient(Rgb::new(0.7, 0.3, 0.1)) };

/// A lamp, a floor and a ball in water, and an eye.
fn surroundings() -> Scene {
    let camera = Perspective::look_at(Vec3::new(1.8, 1.0, 3.2), Vec3::new(0.0, 0.0, -0.3), 0.6);
    let mut s = Scene::new(camera.expect("two different points"));
    s.environment = Some(Environment::constant(Rgb::new(0.2, 0.25, 0.3)));
    let white = s.add_material(Matte::new(Rgb::grey(0.7)));
    let lamp = s.add_material(Emission::radiance(Rgb::grey(3.0)));
    let place = |x, y, z| Transform::translate(Vec3::new(x, y, z));
    let down = Transform::rotate_degrees(Vec3::X, 90.0);
    let up = Transform::rotate_degrees(Vec3::X, -90.0);
    let square = |side| Shape::Rectangle { size: Vec2::splat(side) };
    s.objects.extend([
        Object::new(square(8.0), white).transformed(&(place(0.0, -1.3, 0.0) * up)),
        Object::new(square(4.0), lamp).transformed(&(place(0.0, 2.5, 0.0) * down)),
        Object::new(Shape::Sphere { radius: 0.3 }, white).transformed(&place(0.1, 0.0, -0.5)),
    ]);
    s
}

/// A pane of glass with water behind it that reaches a little into the pane.
fn overlapping() -> Scene {
    let mut s = surroundings();
    let medium = |interior, priority| Dielectric {
        interior,
        priority: Some(priority),
        ..Dielectric::new(1.0)
    };
    let glass = s.add_material(medium(GLASS, 2));
    let water = s.add_material(medium(WATER, 1));
    let mut slab = |material, side, from: f32, to: f32| {
        let shape = Shape::Box { size: Vec3::new(side, side, to - from) };
        let place = Transform::translate(Vec3::new(0.0, 0.0, 0.5 * (from + to)));
        s.objects.push(Object::new(shape, material).transformed(&place));
    };
    slab(glass, 2.0, 0.0, 0.4);
    slab(water, 1.4, -1.0, 0.1);
    s
}

/// The same, every border with the two media that meet there, by hand.
fn declared() -> Scene {
    let mut s = surroundings();
    let border = |interior, exterior| Dielectric { interior, exterior, ..Dielectric::new(1.0) };
    let glass = s.add_material(border(GLASS, Medium::AIR));
    let water = s.add_material(border(WATER, Medium::AIR));
    let between = s.add_material(border(GLASS, WATER));

    // Squares of corners, counter-clockwise seen from +z.
    let square = |half: f32, z: f32| {
        [(-half, -half), (half, -half), (half, half), (-half, half)]
            .map(|(x, y)| Vec3::new(x, y, z))
    };
    let positions: Vec<Vec3> =
        [square(1.0, 0.4), square(1.0, 0.0), square(0.7, 0.0), square(0.7, -1.0)].concat();
    let quads = |quads: &[[u32; 4]]| -> Vec<[u32; 3]> {
        quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect()
    };
    // A band between two squares that begin at these corners, facing outwards from the axis.
    let band = |front: u32, back: u32| -> Vec<[u32; 4]> {
        (0..4).map(|i| [front + i, back + i, back + (i + 1) % 4, front + (i + 1) % 4]).collect()
    };
    let mut add = |material: MaterialId, faces: Vec<[u32; 4]>| {
        let triangles = quads(&faces);
        let mesh = Mesh { positions: positions.clone(), triangles, ..Mesh::default() };
        let mesh = s.add_mesh(mesh);
        s.objects.push(Object::new(Shape::Mesh(mesh), material));
    };
    let faces = [vec![[0, 1, 2, 3]], band(0, 4), band(4, 8)].concat();
    add(glass, faces);
    add(between, vec![[11, 10, 9, 8]]);
    add(water, [band(8, 12), vec![[15, 14, 13, 12]]].concat());
    s
}

/// In every pixel, for both path tracers. A border with the wrong index on one side, a medium
/// that absorbs where a stronger one is, or a surface that is counted where there is none shows.
#[test]
fn overlapping_media_are_the_same_as_declared_borders() {
    for integrator in [IntegratorKind::Path, IntegratorKind::Naive] {
        let a = render(&overlapping(), integrator, None, 1);
        let b = render(&declared(), integrator, None, 2);
        if let Some(worst) = disagreement(&a, &b, 2) {
            panic!("{integrator:?}: {worst}");
        }
    }
}
