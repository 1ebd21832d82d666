//! Small scenes that between them use every shape, material and light.
//!
//! Lamps are large and near what they light, so that scattered rays find them often enough for
//! the mean of some thousand samples to be normally distributed: what the z-test assumes.

use rutilant::camera::{Camera, Equirectangular, Orthographic, Perspective};
use rutilant::color::Rgb;
use rutilant::geom::{Transform, Vec2, Vec3};
use rutilant::image::Image;
use rutilant::light::{Environment, Projection};
use rutilant::material::{
    Absorption, Conductor, Dielectric, Emission, Material, MaterialKind, Matte, Metal, Mirror, Mix,
    ThinDielectric,
};
use rutilant::scene::{MaterialId, Scene};
use rutilant::shape::{Mesh, Object, Shape};
use std::f32::consts::FRAC_PI_2;

/// A scene and its name.
pub struct Named {
    /// What to call it in a report.
    pub name: &'static str,
    /// The scene.
    pub scene: Scene,
}

/// All of them.
pub fn all() -> Vec<Named> {
    let named = |name, scene| Named { name, scene };
    vec![
        named("cornell box", cornell_box()),
        named("half mirrors", half_mirrors()),
        named("glass and caustic", glass_and_caustic()),
        named("sky map", sky_map()),
        named("many lamps", many_lamps()),
        named("ten lamps", small_lamps(10)),
        named("ten thousand lamps", small_lamps(10_000)),
        named("lamps all around", lamps_all_around()),
        named("balls in balls", balls_in_balls()),
        named("sky and lamps", sky_and_lamps()),
        named("coloured water", coloured_water()),
        named("metals under a sky", metals()),
        named("smooth mesh", smooth_mesh()),
        named("glowing box", glowing_box()),
        named("lens", lens()),
        named("nested media", nested_media()),
        named("rough metals and clay", rough_metals()),
        named("frosted glass", frosted_glass()),
        named("panes and flames", panes_and_flames()),
        named("caustics on a plan", caustics_on_a_plan()),
        named("caustics all around", caustics_all_around()),
        named("caustics under water", caustics_under_water()),
        named("caustics of a sun", caustics_of_a_sun()),
    ]
}

fn at(x: f32, y: f32, z: f32) -> Transform {
    Transform::translate(Vec3::new(x, y, z))
}

/// A rectangle's transform: lying at height `y`, facing up.
fn floor_at(y: f32) -> Transform {
    at(0.0, y, 0.0) * Transform::rotate(Vec3::X, -FRAC_PI_2)
}

/// Facing down.
fn ceiling_at(y: f32) -> Transform {
    at(0.0, y, 0.0) * Transform::rotate(Vec3::X, FRAC_PI_2)
}

fn looking(from: [f32; 3], to: [f32; 3]) -> Scene {
    let camera = Perspective::look_at(from.into(), to.into(), 0.8).expect("two different points");
    Scene::new(camera)
}

fn matte(scene: &mut Scene, r: f32, g: f32, b: f32) -> MaterialId {
    scene.add_material(Matte::new(Rgb::new(r, g, b)))
}

fn lamp(scene: &mut Scene, radiance: f32) -> MaterialId {
    scene.add_material(Emission::radiance(Rgb::new(radiance, 0.9 * radiance, 0.7 * radiance)))
}

fn green_glass(scene: &mut Scene) -> MaterialId {
    let mut green = Dielectric::new(1.5);
    green.interior.absorption = Absorption::Coefficient(Rgb::new(0.9, 0.2, 0.9));
    scene.add_material(green)
}

fn put(scene: &mut Scene, shape: Shape, material: MaterialId, place: Transform) {
    scene.objects.push(Object::new(shape, material).transformed(&place));
}

fn rectangle(x: f32, y: f32) -> Shape {
    Shape::Rectangle { size: Vec2::new(x, y) }
}

fn ball(radius: f32) -> Shape {
    Shape::Sphere { radius }
}

/// Five walls, two boxes, a lamp.
fn cornell_box() -> Scene {
    let mut s = looking([0.0, 1.0, 3.6], [0.0, 1.0, 0.0]);
    let white = matte(&mut s, 0.73, 0.71, 0.68);
    let red = matte(&mut s, 0.63, 0.07, 0.05);
    let green = matte(&mut s, 0.14, 0.45, 0.09);
    let light = lamp(&mut s, 6.0);
    let turned = |angle| Transform::rotate(Vec3::Y, angle);
    put(&mut s, rectangle(2.0, 2.0), white, floor_at(0.0));
    put(&mut s, rectangle(2.0, 2.0), white, ceiling_at(2.0));
    put(&mut s, rectangle(2.0, 2.0), white, at(0.0, 1.0, -1.0));
    put(&mut s, rectangle(2.0, 2.0), red, at(-1.0, 1.0, 0.0) * turned(FRAC_PI_2));
    put(&mut s, rectangle(2.0, 2.0), green, at(1.0, 1.0, 0.0) * turned(-FRAC_PI_2));
    put(&mut s, Shape::Box { size: Vec3::splat(0.6) }, white, at(0.35, 0.3, 0.35) * turned(-0.3));
    put(
        &mut s,
        Shape::Box { size: Vec3::new(0.6, 1.2, 0.6) },
        white,
        at(-0.35, 0.6, -0.3) * turned(0.3),
    );
    put(&mut s, rectangle(1.0, 1.0), light, ceiling_at(1.98));
    s
}

/// The report's specular component at several proportions, on a floor and on balls.
fn half_mirrors() -> Scene {
    let mut s = looking([0.0, 1.5, 5.0], [0.0, 0.4, 0.0]);
    let grey = matte(&mut s, 0.9, 0.8, 0.7);
    let mirror = s.add_material(Mirror { reflectance: Rgb::new(0.9, 0.95, 1.0) });
    let light = lamp(&mut s, 4.0);
    for (i, amount) in [0.2, 0.5, 0.9].into_iter().enumerate() {
        let mix = s.add_material(Mix { first: grey, second: mirror, amount });
        put(&mut s, ball(0.6), mix, at(1.5 * (i as f32 - 1.0), 0.6, 0.0));
        if amount == 0.5 {
            put(&mut s, rectangle(12.0, 12.0), mix, floor_at(0.0));
        }
    }
    put(&mut s, rectangle(3.0, 3.0), light, ceiling_at(3.0));
    s
}

/// Light that reaches the floor only through glass, and a ball seen through more of it.
fn glass_and_caustic() -> Scene {
    let mut s = looking([0.5, 1.6, 4.0], [0.0, 0.5, 0.0]);
    let white = matte(&mut s, 0.8, 0.8, 0.8);
    let glass = s.add_material(Dielectric::new(1.5));
    let green = green_glass(&mut s);
    let light = lamp(&mut s, 5.0);
    put(&mut s, rectangle(10.0, 10.0), white, floor_at(0.0));
    put(&mut s, ball(0.7), glass, at(-0.7, 0.8, 0.0));
    put(
        &mut s,
        Shape::Box { size: Vec3::splat(1.0) },
        green,
        at(0.8, 0.6, -0.3) * Transform::rotate(Vec3::Y, 0.5),
    );
    put(&mut s, ball(0.3), white, at(-0.7, 0.3, -1.5));
    put(&mut s, Shape::Disk { radius: 1.6 }, light, ceiling_at(3.0));
    s
}

/// A sky with a bright patch, turned.
fn sunny_sky(s: &mut Scene) {
    let (width, height) = (32_u32, 16_u32);
    let pixels: Vec<[f32; 3]> = (0..width * height)
        .map(|i| {
            let (x, y) = (i % width, i / width);
            let sun = (18..22).contains(&x) && (3..6).contains(&y);
            if sun { [30.0, 25.0, 15.0] } else { [0.2, 0.3, 0.05 * (height - y) as f32] }
        })
        .collect();
    let image = Image::from_rgb(width, height, &pixels).expect("as many pixels as the size says");
    let image = s.add_image(image);
    s.environment = Some(Environment { rotation: 1.0, scale: 0.8, ..Environment::image(image) });
}

/// Balls under a sunny sky.
fn sky_map() -> Scene {
    let mut s = looking([0.0, 1.0, 4.0], [0.0, 0.4, 0.0]);
    sunny_sky(&mut s);
    let white = matte(&mut s, 0.8, 0.8, 0.8);
    let mirror = s.add_material(Mirror { reflectance: Rgb::WHITE });
    put(&mut s, rectangle(10.0, 10.0), white, floor_at(0.0));
    put(&mut s, ball(0.5), white, at(-0.6, 0.5, 0.0));
    put(&mut s, ball(0.5), mirror, at(0.6, 0.5, 0.0));
    s
}

/// A glowing triangle, rectangle, disk, ellipse and ball, one of them two-sided, over a floor.
fn many_lamps() -> Scene {
    let mut s = looking([0.0, 2.0, 5.0], [0.0, 0.5, 0.0]);
    let white = matte(&mut s, 0.7, 0.7, 0.7);
    put(&mut s, rectangle(5.0, 5.0), white, floor_at(0.0));
    let dim = lamp(&mut s, 2.0);
    let bright = lamp(&mut s, 6.0);
    let both =
        s.add_material(Emission { two_sided: true, ..Emission::radiance(Rgb::new(1.0, 2.0, 4.0)) });
    let triangle = s.add_mesh(Mesh {
        positions: vec![
            Vec3::new(-1.0, 2.5, 0.0),
            Vec3::new(1.0, 2.5, 0.0),
            Vec3::new(0.0, 2.0, -1.5),
        ],
        triangles: vec![[0, 2, 1]],
        ..Mesh::default()
    });
    put(&mut s, Shape::Mesh(triangle), dim, Transform::IDENTITY);
    put(&mut s, ball(0.5), dim, at(-1.8, 0.7, 0.0));
    put(
        &mut s,
        Shape::Disk { radius: 0.6 },
        bright,
        at(1.8, 1.2, -0.5) * Transform::rotate(Vec3::Y, -FRAC_PI_2),
    );
    put(&mut s, rectangle(1.0, 1.4), both, at(0.3, 0.8, 0.2) * Transform::rotate(Vec3::Y, 0.9));
    let squeezed = Transform::scale(Vec3::new(1.0, 0.4, 1.0));
    put(&mut s, Shape::Disk { radius: 0.8 }, bright, at(-0.5, 1.5, -2.0) * squeezed);
    s
}

/// A ceiling of small lamps of one size and different brightness, some of them two-sided,
/// that shine on a floor, a ball and, a little, on what is above them.
fn small_lamps(count: u32) -> Scene {
    let mut s = looking([0.0, 1.2, 4.0], [0.0, 0.7, 0.0]);
    let white = matte(&mut s, 0.7, 0.7, 0.7);
    put(&mut s, rectangle(6.0, 6.0), white, floor_at(0.0));
    put(&mut s, rectangle(6.0, 6.0), white, ceiling_at(2.5));
    put(&mut s, ball(0.5), white, at(0.0, 0.5, 0.0));
    let lamps: Vec<MaterialId> = (0..7_u8)
        .map(|i| {
            let brightness = 0.5 + f32::from(i * i) / 6.0;
            let radiance = Rgb::new(brightness, 0.8 * brightness, 0.6 + 0.2 * f32::from(i));
            s.add_material(Emission { two_sided: i % 3 == 0, ..Emission::radiance(radiance) })
        })
        .collect();
    // Half of the ceiling's middle glows, however many lamps it is divided among.
    let columns = count.isqrt().max(2);
    let rows = count.div_ceil(columns);
    let (width, depth) = (3.0 / columns as f32, 3.0 / rows as f32);
    for i in 0..count {
        let x = ((i % columns) as f32 + 0.5) * width - 1.5;
        let z = ((i / columns) as f32 + 0.5) * depth - 1.5;
        // A step of 4 through 7 kinds meets all of them.
        let lamp = lamps[(4 * i as usize + i as usize / 10) % lamps.len()];
        let size = rectangle(0.7 * width, 0.7 * depth);
        put(&mut s, size, lamp, at(x, 0.0, z) * ceiling_at(2.0));
    }
    s
}

/// Forty lamps of every shape that can be met, turned every way, some of them two-sided and some
/// much brighter than others, around frosted glass, a half mirror and a box, under a sky map.
fn lamps_all_around() -> Scene {
    let mut s = looking([0.0, 1.3, 3.6], [0.0, 0.6, 0.0]);
    let pixels: Vec<[f32; 3]> = (0..8_u8).map(|i| [0.2, 0.1 * f32::from(i), 0.4]).collect();
    let sky = Image::from_rgb(4, 2, &pixels).expect("as many pixels as the size says");
    let sky = s.add_image(sky);
    s.environment = Some(Environment::image(sky));
    let white = matte(&mut s, 0.7, 0.7, 0.7);
    let red = matte(&mut s, 0.7, 0.3, 0.2);
    let mirror = s.add_material(Mirror { reflectance: Rgb::grey(0.9) });
    let half = s.add_material(Mix { first: red, second: mirror, amount: 0.4 });
    let frosted = s.add_material(Dielectric { roughness: 0.6, ..Dielectric::new(1.5) });
    put(&mut s, rectangle(7.0, 7.0), white, floor_at(0.0));
    put(&mut s, ball(0.45), frosted, at(-0.9, 0.5, 0.3));
    put(&mut s, ball(0.45), half, at(0.9, 0.5, 0.3));
    put(&mut s, Shape::Box { size: Vec3::new(0.5, 1.0, 0.5) }, red, at(0.0, 0.5, -0.6));
    let tetrahedron = s.add_mesh(Mesh {
        positions: [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]]
            .map(|corner| 0.15 * Vec3::from(corner))
            .to_vec(),
        triangles: vec![[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]],
        ..Mesh::default()
    });
    for i in 0..40_u16 {
        let (number, turn) = (f32::from(i), 2.4 * f32::from(i));
        let brightness = if i % 7 == 0 { 9.0 } else { 0.8 + f32::from(i % 5) };
        let tint = Rgb::new(brightness, 0.8 * brightness, 0.1 * f32::from(i % 10));
        let lamp = Emission { two_sided: i % 3 == 0, ..Emission::radiance(tint) };
        let lamp = s.add_material(lamp);
        let shape = match i % 4 {
            0 => rectangle(0.4, 0.3),
            1 => ball(0.15),
            2 => Shape::Disk { radius: 0.2 },
            _ => Shape::Mesh(tetrahedron),
        };
        // Along a spiral that climbs to above the middle.
        let radius = 2.3 - 0.02 * number;
        let (x, z) = (radius * libm::cosf(turn), radius * libm::sinf(turn));
        let place =
            at(x, 0.25 + 0.05 * number, z) * Transform::rotate(Vec3::new(1.0, 0.3, z), turn);
        put(&mut s, shape, lamp, place);
    }
    s
}

/// Balls in a shell of glass that is hollow, a glowing core in coloured glass, and a matte ball
/// around a smaller one that nothing sees.
fn balls_in_balls() -> Scene {
    let mut s = looking([0.0, 1.2, 4.5], [0.0, 0.6, 0.0]);
    s.environment = Some(Environment::constant(Rgb::new(0.3, 0.4, 0.5)));
    let white = matte(&mut s, 0.8, 0.7, 0.6);
    let glass = s.add_material(Dielectric::new(1.5));
    let mut hollow = Dielectric::new(1.0);
    hollow.exterior.ior = 1.5;
    let hollow = s.add_material(hollow);
    let mut amber = Dielectric::new(1.5);
    amber.interior.absorption = Absorption::Coefficient(Rgb::new(0.3, 1.0, 2.5));
    let amber = s.add_material(amber);
    let glow = s.add_material(Emission::radiance(Rgb::new(6.0, 5.0, 4.0)));
    put(&mut s, rectangle(10.0, 10.0), white, floor_at(0.0));
    put(&mut s, ball(0.6), glass, at(-1.3, 0.65, 0.0));
    put(&mut s, ball(0.5), hollow, at(-1.3, 0.65, 0.0));
    put(&mut s, ball(0.3), white, at(-1.3, 0.65, 0.0));
    put(&mut s, ball(0.6), amber, at(0.0, 0.65, 0.0));
    put(&mut s, ball(0.3), glow, at(0.0, 0.65, 0.0));
    put(&mut s, ball(0.6), white, at(1.3, 0.65, 0.0));
    put(&mut s, ball(0.5), white, at(1.3, 0.65, 0.0));
    s
}

/// A sky on a cube, laid out as a cross, and lamps that shine to both sides under it.
fn sky_and_lamps() -> Scene {
    let mut s = looking([0.0, 1.0, 4.0], [0.0, 0.5, 0.0]);
    let (width, height) = (16_u32, 12_u32);
    let pixels: Vec<[f32; 3]> = (0..width * height)
        .map(|i| {
            let (x, y) = ((i % width) as f32, (i / width) as f32);
            [0.1 * x, 0.4, 0.15 * (12.0 - y)]
        })
        .collect();
    let image = Image::from_rgb(width, height, &pixels).expect("as many pixels as the size says");
    let image = s.add_image(image);
    s.environment = Some(Environment { scale: 0.4, ..Environment::map(image, Projection::Cube) });
    let white = matte(&mut s, 0.8, 0.8, 0.8);
    let mirror = s.add_material(Mirror { reflectance: Rgb::grey(0.9) });
    let both =
        s.add_material(Emission { two_sided: true, ..Emission::radiance(Rgb::new(3.0, 2.0, 1.0)) });
    let papery = rutilant::material::Material::from(Matte::new(Rgb::grey(0.6)));
    let papery = s.add_material(
        papery
            .emitting(Emission { two_sided: true, ..Emission::radiance(Rgb::new(0.5, 1.0, 1.5)) }),
    );
    put(&mut s, rectangle(8.0, 8.0), white, floor_at(0.0));
    put(
        &mut s,
        Shape::Disk { radius: 0.6 },
        both,
        at(-1.2, 0.7, 0.0) * Transform::rotate(Vec3::Y, 0.8),
    );
    put(&mut s, rectangle(1.0, 1.0), papery, at(1.2, 0.6, -0.2) * Transform::rotate(Vec3::Y, -0.6));
    put(&mut s, ball(0.5), mirror, at(0.0, 0.5, 0.3));
    put(&mut s, ball(0.25), both, at(0.0, 1.6, -0.5));
    s
}

/// Balls and a lamp inside coloured water of index 1.33.
fn coloured_water() -> Scene {
    let mut s = looking([0.0, 1.0, 7.0], [0.0, 0.0, 0.0]);
    let mut water = Dielectric::new(1.33);
    let color = Rgb::new(0.5, 0.8, 0.9);
    water.interior.absorption = Absorption::ColorAtDistance { color, distance: 2.0 };
    let water = s.add_material(water);
    let white = matte(&mut s, 0.8, 0.8, 0.8);
    let light = lamp(&mut s, 5.0);
    s.environment = Some(Environment::constant(Rgb::new(0.1, 0.2, 0.3)));
    put(&mut s, Shape::Box { size: Vec3::new(4.0, 3.0, 3.0) }, water, Transform::IDENTITY);
    put(&mut s, ball(0.6), white, at(-0.9, -0.5, 0.0));
    put(&mut s, ball(0.6), light, at(0.9, 0.6, 0.0));
    s
}

/// Gold and copper under a grey sky with a lamp.
fn metals() -> Scene {
    let mut s = looking([0.0, 1.2, 4.0], [0.0, 0.5, 0.0]);
    s.environment = Some(Environment::constant(Rgb::new(0.5, 0.6, 0.7)));
    let white = matte(&mut s, 0.6, 0.6, 0.6);
    let gold = s.add_material(Conductor::new(
        Rgb::new(0.143, 0.375, 1.442),
        Rgb::new(3.983, 2.386, 1.603),
        0.0,
    ));
    let copper = s.add_material(Conductor::new(
        Rgb::new(0.200, 0.924, 1.102),
        Rgb::new(3.912, 2.452, 2.142),
        0.0,
    ));
    let light = lamp(&mut s, 3.0);
    put(&mut s, rectangle(8.0, 8.0), white, floor_at(0.0));
    put(&mut s, ball(0.6), gold, at(-0.7, 0.6, 0.0));
    put(
        &mut s,
        Shape::Box { size: Vec3::splat(0.9) },
        copper,
        at(0.8, 0.45, 0.0) * Transform::rotate(Vec3::Y, 0.6),
    );
    put(&mut s, rectangle(2.0, 2.0), light, at(0.0, 2.0, -2.0) * Transform::rotate(Vec3::X, 0.6));
    s
}

/// A coarse ball with vertex normals, matte and glass: shading normals differ much from true ones.
fn smooth_mesh() -> Scene {
    let mut s = looking([0.0, 1.2, 4.0], [0.0, 0.6, 0.0]);
    let white = matte(&mut s, 0.8, 0.7, 0.6);
    let glass = s.add_material(Dielectric::new(1.5));
    let light = lamp(&mut s, 4.0);
    let mesh = s.add_mesh(coarse_ball());
    put(&mut s, rectangle(8.0, 8.0), white, floor_at(0.0));
    put(&mut s, Shape::Mesh(mesh), white, at(-0.8, 0.7, 0.0));
    put(&mut s, Shape::Mesh(mesh), glass, at(0.8, 0.7, 0.0));
    put(&mut s, rectangle(3.0, 3.0), light, ceiling_at(3.0));
    s
}

/// An octahedron, each face cut in four, with normals from its centre.
fn coarse_ball() -> Mesh {
    let mut mesh = Mesh { name: "coarse ball".into(), ..Mesh::default() };
    let axes = [Vec3::X, Vec3::Y, Vec3::Z];
    for octant in 0..8 {
        let sign = |axis: usize| if octant >> axis & 1 == 1 { -1.0 } else { 1.0 };
        let [a, b, c] = [0, 1, 2].map(|axis| axes[axis] * sign(axis));
        let corners = [a, b, c, (a + b).normalize(), (b + c).normalize(), (c + a).normalize()];
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(corners.map(|p| p * 0.7));
        mesh.normals.extend(corners);
        let outward = sign(0) * sign(1) * sign(2) > 0.0;
        mesh.triangles.extend([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]].map(|[i, j, k]| {
            let t = if outward { [i, j, k] } else { [i, k, j] };
            t.map(|v: u32| v + first)
        }));
    }
    mesh
}

/// A matte box that glows on its outside, and a closed room around it.
fn glowing_box() -> Scene {
    let mut s = looking([0.0, 0.3, 1.9], [0.0, 0.0, 0.0]);
    let wall = matte(&mut s, 0.6, 0.5, 0.4);
    let glow = Emission::radiance(Rgb::new(1.0, 1.5, 2.0));
    let core = s.add_material(Material::from(Matte::new(Rgb::grey(0.5))).emitting(glow));
    put(&mut s, Shape::Box { size: Vec3::splat(4.0) }, wall, Transform::IDENTITY);
    put(&mut s, Shape::Box { size: Vec3::splat(0.9) }, core, Transform::rotate(Vec3::ONE, 0.7));
    s
}

/// Balls in and out of focus.
fn lens() -> Scene {
    let mut camera = Perspective::look_at(Vec3::new(0.0, 1.0, 4.0), Vec3::new(0.0, 0.5, 0.0), 0.8)
        .expect("two different points");
    camera.lens.aperture_radius = 0.2;
    let mut s = Scene::new(camera);
    let white = matte(&mut s, 0.8, 0.8, 0.8);
    let red = matte(&mut s, 0.8, 0.2, 0.1);
    let light = lamp(&mut s, 4.0);
    put(&mut s, rectangle(10.0, 10.0), white, floor_at(0.0));
    put(&mut s, ball(0.5), red, at(-0.7, 0.5, 1.5));
    put(&mut s, ball(0.5), red, at(0.7, 0.5, -1.5));
    put(&mut s, rectangle(5.0, 5.0), light, ceiling_at(3.0));
    s
}

/// A lamp and a ball in water that overlaps the glass before it, ice half in the water, and a
/// second body of water: surfaces that are borders here and none there, before and behind lamps.
fn nested_media() -> Scene {
    let mut s = looking([0.6, 1.0, 6.0], [0.0, 0.0, 0.0]);
    s.environment = Some(Environment::constant(Rgb::new(0.3, 0.3, 0.4)));
    let mut medium = |ior, absorption: [f32; 3], priority| {
        let mut medium = Dielectric { priority: Some(priority), ..Dielectric::new(ior) };
        medium.interior.absorption = Absorption::Coefficient(Rgb(absorption));
        s.add_material(medium)
    };
    let water = medium(1.33, [0.4, 0.15, 0.1], 1);
    let ice = medium(1.31, [0.0, 0.0, 0.0], 2);
    let glass = medium(1.52, [0.1, 0.05, 0.1], 3);
    let white = matte(&mut s, 0.8, 0.8, 0.8);
    let light = lamp(&mut s, 4.0);
    put(&mut s, Shape::Box { size: Vec3::new(3.2, 2.0, 2.0) }, water, Transform::IDENTITY);
    put(&mut s, Shape::Box { size: Vec3::new(3.6, 2.4, 0.3) }, glass, at(0.0, 0.0, 1.1));
    put(&mut s, ball(0.5), ice, at(0.1, 1.0, 0.2));
    put(&mut s, Shape::Box { size: Vec3::new(0.8, 1.4, 1.6) }, water, at(0.0, -0.2, 0.0));
    put(&mut s, ball(0.55), white, at(-0.9, -0.3, 0.0));
    put(&mut s, ball(0.5), light, at(1.0, 0.1, 0.0));
    s
}

/// Rough gold, aluminium and clay, one of them partly gilded, under a lamp and a sky.
fn rough_metals() -> Scene {
    let mut s = looking([0.0, 1.4, 4.5], [0.0, 0.4, 0.0]);
    s.environment = Some(Environment::constant(Rgb::new(0.3, 0.4, 0.5)));
    let clay = s.add_material(Matte { roughness: 0.9, ..Matte::new(Rgb::new(0.8, 0.6, 0.5)) });
    let gold = s.add_material(Metal::Gold.conductor(0.4));
    let aluminium = s.add_material(Metal::Aluminium.conductor(0.8));
    let gilded = s.add_material(Mix { first: clay, second: gold, amount: 0.5 });
    let light = lamp(&mut s, 4.0);
    put(&mut s, rectangle(8.0, 8.0), clay, floor_at(0.0));
    for (i, material) in [gold, aluminium, gilded].into_iter().enumerate() {
        put(&mut s, ball(0.55), material, at(1.3 * (i as f32 - 1.0), 0.55, 0.0));
    }
    put(&mut s, rectangle(2.5, 2.5), light, ceiling_at(2.5));
    s
}

/// A lamp behind frosted glass, another one inside coloured frosted glass, and a smooth mesh of it.
fn frosted_glass() -> Scene {
    let mut s = looking([0.0, 1.3, 4.5], [0.0, 0.6, 0.0]);
    let white = matte(&mut s, 0.7, 0.7, 0.7);
    let frosted = s.add_material(Dielectric { roughness: 0.75, ..Dielectric::new(1.5) });
    let mut green = Dielectric { roughness: 0.8, ..Dielectric::new(1.3) };
    green.interior.absorption = Absorption::Coefficient(Rgb::new(1.5, 0.3, 1.0));
    let green = s.add_material(green);
    let light = lamp(&mut s, 3.0);
    put(&mut s, rectangle(8.0, 8.0), white, floor_at(0.0));
    put(&mut s, Shape::Box { size: Vec3::new(1.0, 1.4, 0.2) }, frosted, at(-0.9, 0.75, 0.4));
    put(&mut s, ball(0.4), light, at(-0.9, 0.8, -0.5));
    put(&mut s, ball(0.6), green, at(0.5, 0.65, 0.0));
    put(&mut s, ball(0.2), light, at(0.5, 0.65, 0.0));
    let mesh = s.add_mesh(coarse_ball());
    put(&mut s, Shape::Mesh(mesh), frosted, at(1.6, 0.75, 0.0));
    put(&mut s, rectangle(2.0, 2.0), light, ceiling_at(2.8));
    s
}

/// A grey pane before a lamp, gauze that is half a hole, and a flame that light passes.
fn panes_and_flames() -> Scene {
    let mut s = looking([0.0, 1.3, 4.5], [0.0, 0.6, 0.0]);
    let white = matte(&mut s, 0.7, 0.7, 0.7);
    let nothing = s.add_material(Material::new(MaterialKind::Null));
    let gauze = s.add_material(Mix { first: white, second: nothing, amount: 0.4 });
    let pane = s.add_material(ThinDielectric { ior: 1.5, color: Rgb::new(0.5, 0.7, 0.9) });
    let glow = Emission { two_sided: true, ..Emission::radiance(Rgb::new(2.0, 1.0, 0.3)) };
    let flame = s.add_material(Material::new(MaterialKind::Null).emitting(glow));
    let light = lamp(&mut s, 3.0);
    put(&mut s, rectangle(8.0, 8.0), white, floor_at(0.0));
    put(&mut s, rectangle(1.2, 1.2), pane, at(-0.9, 0.7, 0.6));
    put(&mut s, rectangle(1.0, 1.0), gauze, at(0.4, 0.6, 0.5));
    put(&mut s, rectangle(0.7, 1.0), flame, at(1.4, 0.6, 0.0));
    put(&mut s, Shape::Disk { radius: 0.3 }, flame, at(1.4, 0.6, -0.2));
    put(&mut s, ball(0.3), white, at(1.4, 0.3, -0.8));
    put(&mut s, rectangle(3.0, 1.0), light, at(0.0, 0.7, -1.0));
    put(&mut s, Shape::Box { size: Vec3::splat(20.0) }, nothing, Transform::IDENTITY);
    s
}

/// A glass ball, a mirror and a tinted pane throw the light of a lamp that shines to both sides,
/// and of one of many triangles, on a floor that mirrors in part, seen without perspective through
/// a lens of five blades.
fn caustics_on_a_plan() -> Scene {
    let (eye, target) = (Vec3::new(0.5, 4.0, 3.0), Vec3::new(0.0, 0.3, 0.0));
    let mut camera = Orthographic::look_at(eye, target, 4.0).expect("two different points");
    (camera.lens.aperture_radius, camera.lens.blades, camera.lens.focus_distance) = (0.3, 5, 4.0);
    let mut s = Scene::new(Camera::from(camera));
    s.environment = Some(Environment::constant(Rgb::new(0.3, 0.4, 0.5)));
    let grey = matte(&mut s, 0.8, 0.7, 0.6);
    let mirror = s.add_material(Mirror { reflectance: Rgb::new(0.9, 0.8, 0.7) });
    let polished = s.add_material(Mix { first: grey, second: mirror, amount: 0.3 });
    let glass = s.add_material(Dielectric::new(1.5));
    let pane = s.add_material(ThinDielectric { ior: 1.5, color: Rgb::new(0.4, 0.9, 0.5) });
    let both = Emission { two_sided: true, ..Emission::radiance(Rgb::new(2.0, 1.5, 1.0)) };
    let both = s.add_material(Material::new(MaterialKind::Black).emitting(both));
    let light = lamp(&mut s, 5.0);
    let mesh = s.add_mesh(coarse_ball());
    put(&mut s, rectangle(8.0, 8.0), polished, floor_at(0.0));
    put(&mut s, ball(0.6), glass, at(-0.8, 0.7, 0.2));
    put(&mut s, rectangle(1.4, 1.2), mirror, at(0.2, 0.7, -1.0));
    put(&mut s, rectangle(1.2, 1.2), pane, at(1.0, 0.7, 0.6) * Transform::rotate(Vec3::Y, 1.2));
    put(&mut s, rectangle(4.0, 3.0), both, at(-2.2, 1.5, 0.0) * Transform::rotate(Vec3::Y, 1.5));
    put(&mut s, Shape::Mesh(mesh), light, at(2.0, 1.0, 0.8));
    s
}

/// A room seen all around: a lamp in a ball of tinted glass, a lamp that shines on a smooth coarse
/// ball of glass, and a frosted block for its light to come down on.
fn caustics_all_around() -> Scene {
    let camera = Equirectangular::look_at(Vec3::new(0.1, 1.2, 1.0), Vec3::new(0.0, 0.8, 0.0));
    let mut s = Scene::new(Camera::from(camera.expect("two different points")));
    let wall = matte(&mut s, 0.6, 0.6, 0.5);
    let mut tinted = Dielectric::new(1.5);
    tinted.interior.absorption = Absorption::Coefficient(Rgb::new(0.2, 0.9, 1.4));
    let tinted = s.add_material(tinted);
    let glass = s.add_material(Dielectric::new(1.5));
    let frosted = s.add_material(Dielectric { roughness: 0.5, ..Dielectric::new(1.4) });
    let light = lamp(&mut s, 4.0);
    let mesh = s.add_mesh(coarse_ball());
    put(&mut s, Shape::Box { size: Vec3::new(5.0, 3.0, 5.0) }, wall, at(0.0, 1.5, 0.0));
    put(&mut s, ball(0.6), tinted, at(1.2, 0.9, -0.6));
    put(&mut s, ball(0.4), light, at(1.2, 0.9, -0.6));
    put(&mut s, Shape::Mesh(mesh), glass, at(-1.0, 1.1, -0.7));
    put(&mut s, Shape::Box { size: Vec3::new(1.4, 0.4, 1.4) }, frosted, at(-1.0, 0.2, -0.7));
    put(&mut s, Shape::Disk { radius: 1.0 }, light, at(-1.0, 2.9, -0.7) * ceiling_at(0.0));
    s
}

/// All of it in coloured water: a lamp, a ball of glass, a bubble, and a camera that stretches what
/// it sees.
fn caustics_under_water() -> Scene {
    let eye = Transform::look_at(Vec3::new(0.3, 0.6, 2.8), Vec3::ZERO, Vec3::Y);
    let stretched = eye.expect("two different points") * Transform::scale(Vec3::new(1.3, 0.8, 1.1));
    let mut camera = Perspective::look_at(Vec3::ZERO, Vec3::NEG_Z, 0.8).expect("two points");
    camera.world_from_camera = stretched;
    let mut s = Scene::new(camera);
    s.environment = Some(Environment::constant(Rgb::new(0.9, 0.8, 0.6)));
    let mut water = Dielectric::new(1.33);
    water.interior.absorption = Absorption::Coefficient(Rgb::new(0.3, 0.1, 0.05));
    let water = s.add_material(water);
    let in_water = |ior: f32| {
        let mut medium = Dielectric::new(ior);
        medium.exterior.ior = 1.33;
        medium
    };
    let mut glass = in_water(1.6);
    glass.interior.absorption = Absorption::Coefficient(Rgb::new(0.1, 0.5, 0.4));
    let (glass, bubble) = (s.add_material(glass), s.add_material(in_water(1.0)));
    let white = matte(&mut s, 0.8, 0.8, 0.8);
    let light = lamp(&mut s, 5.0);
    put(&mut s, Shape::Box { size: Vec3::new(8.0, 6.0, 8.0) }, water, Transform::IDENTITY);
    put(&mut s, rectangle(6.0, 6.0), white, floor_at(-0.7));
    put(&mut s, ball(0.5), glass, at(-0.6, -0.1, 0.0));
    put(&mut s, ball(0.4), bubble, at(0.7, -0.2, 0.2));
    put(&mut s, rectangle(2.0, 2.0), light, ceiling_at(1.6));
    s
}

/// A ball and a block of glass, one coloured, that throw the light of a sunny sky and of a lamp.
fn caustics_of_a_sun() -> Scene {
    let mut s = looking([0.5, 2.2, 4.0], [0.0, 0.3, 0.0]);
    sunny_sky(&mut s);
    let white = matte(&mut s, 0.8, 0.8, 0.8);
    let glass = s.add_material(Dielectric::new(1.5));
    let green = green_glass(&mut s);
    let light = lamp(&mut s, 4.0);
    put(&mut s, rectangle(10.0, 10.0), white, floor_at(0.0));
    put(&mut s, ball(0.6), glass, at(-0.9, 0.7, 0.0));
    put(&mut s, Shape::Box { size: Vec3::splat(0.9) }, green, at(0.7, 0.6, 0.2));
    put(&mut s, ball(0.7), light, at(0.3, 2.0, -1.6));
    s
}
