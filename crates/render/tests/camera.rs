//! What lenses blur and what they are focused on, in pictures and in closed forms.

#![expect(clippy::disallowed_methods, reason = "expected values are computed in f64")]

mod common;

use common::{mean, random, render, small};
use rutilant::Prepared;
use rutilant::camera::{Camera, Equirectangular, Lens, Orthographic, Perspective};
use rutilant::color::Rgb;
use rutilant::film::Filter;
use rutilant::geom::{Transform, Vec2, Vec3};
use rutilant::image::Image;
use rutilant::light::Environment;
use rutilant::material::{Dielectric, Emission, Material, Matte, Mirror};
use rutilant::scene::{ImageId, Scene};
use rutilant::settings::{Crop, IntegratorKind, SamplerKind, Settings};
use rutilant::shape::{Mesh, Object, Shape};
use std::f64::consts::PI;

const SIZE: [u32; 2] = [101, 101];
const MIDDLE: Vec2 = Vec2::splat(0.5);

fn at(x: f64, y: f64, z: f64) -> Transform {
    Transform::translate(Vec3::new(x as f32, y as f32, z as f32))
}

fn put(scene: &mut Scene, shape: Shape, material: impl Into<Material>, place: Transform) {
    let material = scene.add_material(material);
    scene.objects.push(Object::new(shape, material).transformed(&place));
}

fn screen() -> Shape {
    Shape::Rectangle { size: Vec2::splat(40.0) }
}

// ---- blur ----

/// A camera at the origin that looks along −z.
enum View {
    Perspective,
    Orthographic,
}

/// The blur of a small lamp on the axis.
struct Spot {
    /// Second moments along both axes about the middle of the picture, in pixels², those of the
    /// lamp and of a pixel taken off.
    moments: [f64; 2],
    /// Third moments along both axes, in pixels³; those of lamp and pixel are 0.
    skews: [f64; 2],
    /// The part of the light within each distance of the middle, in pixels.
    light: Vec<(f64, f64)>,
}

/// Half the angle of view.
const HALF_FOV: f64 = 0.1;

fn spot(view: &View, lens: Lens, distance: f64, source: f64) -> Spot {
    let (size, middle) = (256_u32, 104_u32);
    let camera: Camera = match view {
        View::Perspective => {
            let fov = 2.0 * HALF_FOV as f32;
            let camera = Perspective::look_at(Vec3::ZERO, Vec3::NEG_Z, fov).unwrap();
            Perspective { lens, ..camera }.into()
        }
        View::Orthographic => {
            let camera = Orthographic::look_at(Vec3::ZERO, Vec3::NEG_Z, 1.0).unwrap();
            Orthographic { lens, ..camera }.into()
        }
    };
    let mut scene = Scene::new(camera);
    let lamp = Emission::radiance(Rgb::WHITE);
    put(&mut scene, Shape::Disk { radius: source as f32 }, lamp, at(0.0, 0.0, -distance));
    let first = (size - middle) / 2;
    let settings = Settings {
        size: [size; 2],
        crop: Some(Crop { x: first, y: first, width: middle, height: middle }),
        spp: 512,
        max_depth: Some(1),
        filter: Filter::Box { radius: 0.5 },
        ..Settings::default()
    };
    let image = render(&scene, settings);
    let from_middle = |i: usize| {
        let to = |k: usize| k as f64 + 0.5 - 0.5 * f64::from(middle);
        (to(i % middle as usize), -to(i / middle as usize))
    };
    let values = image.channel("R").unwrap();
    let lit: Vec<_> =
        values.iter().enumerate().map(|(i, &v)| (from_middle(i), f64::from(v))).collect();
    let total: f64 = lit.iter().map(|(_, v)| v).sum();
    let own = source * pixels_per_metre(view, distance);
    let moment = |f: fn(f64, f64) -> f64| {
        let sum: f64 = lit.iter().map(|&((x, y), v)| v * f(x, y) * f(x, y)).sum();
        sum / total - 1.0 / 12.0 - 0.25 * own * own
    };
    let skew = |f: fn(f64, f64) -> f64| {
        lit.iter().map(|&((x, y), v)| v * f(x, y).powi(3)).sum::<f64>() / total
    };
    Spot {
        moments: [moment(|x, _| x), moment(|_, y| y)],
        skews: [skew(|x, _| x), skew(|_, y| y)],
        light: lit.iter().map(|&((x, y), v)| (x.hypot(y), v / total)).collect(),
    }
}

fn pixels_per_metre(view: &View, distance: f64) -> f64 {
    match view {
        View::Perspective => 128.0 / (HALF_FOV.tan() * distance),
        View::Orthographic => 256.0,
    }
}

/// The blur of a point off the focal plane has the radius that the thin-lens formula says,
/// A |d − f| / (f d) on a film at distance 1, within 1 %; and along each axis the second moment of
/// the aperture: R²/4 for a disk, R²/4 (1 − ⅔ sin²(π/n)) for a polygon of n corners, a quarter of
/// that where an anamorphic lens is half as wide. A square, which the old program sampled, would
/// give s²/12.
#[test]
fn blur_has_the_size_and_the_shape_of_the_aperture() {
    let polygon = |n: f64| 1.0 - 2.0 / 3.0 * (PI / n).sin().powi(2);
    // A triangle of circumradius 1 has sides √3 and the moment s²/24 = 1/8 about each axis.
    assert!((polygon(3.0) / 4.0 - 1.0 / 8.0).abs() < 1e-12);
    let shapes: [(u32, f32, f32, [f64; 2]); 7] = [
        (0, 0.0, 1.0, [1.0, 1.0]),
        (3, 0.0, 1.0, [polygon(3.0); 2]),
        (5, 0.7, 1.0, [polygon(5.0); 2]),
        (6, 0.3, 1.0, [polygon(6.0); 2]),
        (100, 0.0, 1.0, [polygon(100.0); 2]),
        (0, 0.0, 2.0, [0.25, 1.0]),
        (6, 1.0, 0.5, [4.0 * polygon(6.0), polygon(6.0)]),
    ];
    let (aperture, focus, source) = (0.05, 2.0, 0.01);
    for (view, distances) in [(View::Perspective, &[1.2, 4.0][..]), (View::Orthographic, &[3.0])] {
        for &distance in distances {
            for (blades, blade_rotation, aperture_ratio, moments) in shapes {
                let lens = Lens {
                    aperture_radius: aperture as f32,
                    blades,
                    blade_rotation,
                    aperture_ratio,
                    ..Lens::pinhole(focus as f32)
                };
                let spot = spot(&view, lens, distance, source);
                let on_the_lens = aperture * (distance - focus).abs() / focus;
                let radius = on_the_lens * pixels_per_metre(&view, distance);
                for (got, factor) in spot.moments.into_iter().zip(moments) {
                    let measured = (4.0 * got / factor).sqrt();
                    assert!(
                        (measured / radius - 1.0).abs() < 0.01,
                        "{lens:?} at {distance}: radius {measured}, expected {radius}"
                    );
                }
                // A round one is evenly bright: its inner pixels hold their share of the light.
                if (blades, aperture_ratio) == (0, 1.0) {
                    let inner = spot.light.iter().filter(|(r, _)| *r < 0.5 * radius);
                    let (pixels, light) =
                        inner.fold((0.0, 0.0), |(n, sum), (_, v)| (n + 1.0, sum + v));
                    let expected = pixels / (PI * radius * radius);
                    assert!((light - expected).abs() < 0.01, "{light}, expected {expected}");
                }
            }
        }
    }
}

/// A corner of the aperture points up behind the focus and down before it; it is turned
/// counter-clockwise. A triangle's third moment along an axis is a thirtieth of the sum of its
/// corners' cubes there: 1/40 towards a corner, none across.
#[test]
fn blades_point_where_they_should() {
    let (aperture, focus, source) = (0.05, 2.0_f64, 0.01);
    let far = 4.0;
    for (degrees, distance, expected) in [
        (0.0_f32, far, [0.0, 0.025]),
        (0.0, 1.2, [0.0, -0.025]),
        (90.0, far, [-0.025, 0.0]),
        (30.0, far, [0.025, 0.0]),
    ] {
        let lens = Lens {
            aperture_radius: aperture as f32,
            blades: 3,
            blade_rotation: degrees.to_radians(),
            ..Lens::pinhole(focus as f32)
        };
        let radius = aperture * (distance - focus).abs() / focus;
        let radius = radius * pixels_per_metre(&View::Perspective, distance);
        let skews = spot(&View::Perspective, lens, distance, source).skews;
        let skews = skews.map(|s| s / radius.powi(3));
        for (got, expected) in skews.into_iter().zip(expected) {
            assert!((got - expected).abs() < 0.002, "{degrees}° at {distance}: {skews:?}");
        }
    }
}

// ---- focus ----

/// A camera at the origin that looks along −z, its subjects to come.
fn looking(lens: Lens) -> Scene {
    let camera = Perspective::look_at(Vec3::ZERO, Vec3::NEG_Z, 0.6).unwrap();
    Scene::new(Perspective { lens, ..camera })
}

fn stage() -> Scene {
    looking(Lens::pinhole(1.0))
}

fn wall() -> Material {
    Matte::new(Rgb::grey(0.5)).into()
}

fn mirror() -> Material {
    Mirror { reflectance: Rgb::WHITE }.into()
}

#[track_caller]
fn assert_near(got: f32, expected: f64, tolerance: f64) {
    let error = (f64::from(got) / expected - 1.0).abs();
    assert!(error <= tolerance, "{got}, expected {expected}: {error:e} off");
}

/// A plane is sharp all over when any point of it is focused on: distances are measured along the
/// view, not along the ray.
#[test]
fn a_plane_at_a_known_depth_is_exact() {
    for depth in [0.3, 7.0, 1234.5] {
        let mut scene = stage();
        let whole = Shape::Rectangle { size: Vec2::splat(depth * 4.0) };
        put(&mut scene, whole, wall(), at(0.0, 0.0, -f64::from(depth)));
        let cameras: [Camera; 2] =
            [scene.camera, Orthographic::look_at(Vec3::ZERO, Vec3::NEG_Z, depth).unwrap().into()];
        for camera in cameras {
            scene.camera = camera;
            let scene = Prepared::new(&scene).unwrap();
            for place in [MIDDLE, Vec2::new(0.1, 0.9), Vec2::new(0.99, 0.4)] {
                let focus = scene.focus_on(SIZE, place).unwrap();
                assert_near(focus.distance, f64::from(depth), 3e-7);
                let way = match camera {
                    Camera::Orthographic(_) => f64::from(depth),
                    Camera::Perspective(_) | Camera::Equirectangular(_) => {
                        focus.point.as_dvec3().length()
                    }
                };
                assert_near(focus.path_length, way, 1e-6);
                assert_eq!(focus.bounces, 0);
            }
        }
    }
}

/// A slab of thickness t and index n brings what is behind it nearer by t (1 − 1/n).
#[test]
fn glass_brings_things_nearer() {
    for (thickness, ior) in [(0.5, 1.5_f32), (2.0, 1.33), (1.0, 2.4)] {
        let mut scene = stage();
        let slab = Shape::Box { size: Vec3::new(20.0, 20.0, thickness as f32) };
        put(&mut scene, slab, Dielectric::new(ior), at(0.0, 0.0, -3.0));
        put(&mut scene, screen(), wall(), at(0.0, 0.0, -6.0));
        let scene = Prepared::new(&scene).unwrap();
        let focus = scene.focus_on(SIZE, MIDDLE).unwrap();
        let expected = 6.0 - thickness * (1.0 - 1.0 / f64::from(ior));
        assert_near(focus.distance, expected, 1e-6);
        assert_near(focus.path_length, 6.0, 1e-6);
        assert_eq!(focus.bounces, 2);

        // From inside a medium, what is in the air beyond it seems further away.
        let mut scene = stage();
        let water = Shape::Box { size: Vec3::splat(4.0) };
        put(&mut scene, water, Dielectric::new(ior), Transform::IDENTITY);
        put(&mut scene, screen(), wall(), at(0.0, 0.0, -5.0));
        let focus = Prepared::new(&scene).unwrap().focus_on(SIZE, MIDDLE).unwrap();
        assert_near(focus.distance, 2.0 + 3.0 * f64::from(ior), 1e-6);
    }
}

/// Seen at an angle, what is under water has two images, at d cos²r / (n cos²i) … of the way for
/// rays side by side and one above the other; the focus lies between them.
#[test]
fn glass_at_an_angle_is_focused_between_its_two_images() {
    let (incidence, ior, before, within) = (0.7_f64, 1.5_f64, 2.0_f64, 1.0_f64);
    let mut scene = stage();
    // A thick slab that the axis enters at the angle; inside it a wall across the refracted ray.
    let refracted = (incidence.sin() / ior).asin();
    let slab = Shape::Box { size: Vec3::new(60.0, 60.0, 20.0) };
    let turn = Transform::rotate(Vec3::Y, incidence as f32);
    put(
        &mut scene,
        slab,
        Dielectric::new(ior as f32),
        at(0.0, 0.0, -before) * turn * at(0.0, 0.0, -10.0),
    );
    let bent = incidence - refracted;
    let end = at(-within * bent.sin(), 0.0, -before - within * bent.cos());
    let end = end * Transform::rotate(Vec3::Y, bent as f32);
    put(&mut scene, Shape::Disk { radius: 0.1 }, wall(), end);
    let focus = Prepared::new(&scene).unwrap().focus_on(SIZE, MIDDLE).unwrap();
    assert_eq!(focus.bounces, 1);
    assert_near(focus.path_length, before + within, 1e-5);
    let sagittal = before + within / ior;
    let tangential = before + within / ior * (incidence.cos() / refracted.cos()).powi(2);
    let (nearest, farthest) = (tangential.min(sagittal), tangential.max(sagittal));
    let got = f64::from(focus.distance);
    assert!(nearest + 0.05 < got && got < farthest - 0.05, "{nearest} {got} {farthest}");
}

/// Behind a flat mirror the way is unfolded; a total reflection is a mirror as well.
#[test]
fn mirrors_unfold_the_way() {
    let mut scene = stage();
    let turned = at(0.0, 0.0, -4.0) * Transform::rotate(Vec3::Y, std::f32::consts::FRAC_PI_4);
    put(&mut scene, Shape::Rectangle { size: Vec2::splat(2.0) }, mirror(), turned);
    let side = at(5.0, 0.0, 0.0) * Transform::rotate(Vec3::Y, -std::f32::consts::FRAC_PI_2);
    put(&mut scene, screen(), wall(), side);
    let prepared = Prepared::new(&scene).unwrap();
    let focus = prepared.focus_on(SIZE, MIDDLE).unwrap();
    assert_near(focus.distance, 9.0, 1e-6);
    assert_near(focus.path_length, 9.0, 1e-6);
    assert_eq!(focus.bounces, 1);
    assert!(focus.point.distance(Vec3::new(5.0, 0.0, -4.0)) < 1e-5);
    // Off the axis the way is longer, but the mirror image of the wall is as far along the view.
    let off = prepared.focus_on(SIZE, Vec2::new(0.6, 0.3)).unwrap();
    assert_near(off.distance, 9.0, 1e-6);
    let (x, y) = (0.2 * 0.3_f64.tan(), 0.4 * 0.3_f64.tan());
    assert_near(off.path_length, 9.0 * (1.0 + x * x + y * y).sqrt(), 1e-6);

    // A prism of index 1.5 in the mirror's place: 1 m of glass before and after the turn.
    let corners = [(-1.0, -1.0), (1.0, 1.0), (1.0, -1.0)];
    let positions =
        corners.iter().flat_map(|&(x, z)| [-3.0, 3.0].map(|y| Vec3::new(x, y, -z - 4.0))).collect();
    let triangles =
        [[0, 4, 2], [1, 3, 5], [0, 2, 3], [0, 3, 1], [2, 4, 5], [2, 5, 3], [4, 0, 1], [4, 1, 5]];
    let mesh = Mesh { positions, triangles: triangles.to_vec(), ..Mesh::default() };
    let mesh = scene.add_mesh(mesh);
    scene.objects[0].shape = Shape::Mesh(mesh);
    scene.objects[0].world_from_object = Transform::IDENTITY;
    scene.materials[0] = Dielectric::new(1.5).into();
    let focus = Prepared::new(&scene).unwrap().focus_on(SIZE, MIDDLE).unwrap();
    assert_near(focus.path_length, 9.0, 1e-5);
    assert_near(focus.distance, 7.0 + 2.0 / 1.5, 1e-5);
    assert_eq!(focus.bounces, 3);
}

/// A ball as true as f32 allows, and one of triangles that looks like it.
fn balls() -> [(&'static str, Option<Mesh>, f64); 2] {
    let (rings, segments) = (200_u32, 400_u32);
    let mut mesh = Mesh::default();
    for i in 0..=rings {
        for j in 0..segments {
            let (theta, phi) = (
                PI * f64::from(i) / f64::from(rings),
                2.0 * PI * f64::from(j) / f64::from(segments),
            );
            let around = Vec3::new(
                (theta.sin() * phi.cos()) as f32,
                theta.cos() as f32,
                (theta.sin() * phi.sin()) as f32,
            );
            mesh.positions.push(around);
            mesh.normals.push(around);
        }
    }
    for i in 0..rings {
        for j in 0..segments {
            let at = |i: u32, j: u32| i * segments + j % segments;
            let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    [("sphere", None, 1e-5), ("smooth mesh", Some(mesh), 0.01)]
}

/// Curved surfaces make pictures of their own: a convex mirror at 1 / (1/s + 2/R) behind itself,
/// a glass ball where n₁/s + n₂/s′ = (n₂ − n₁)/R says, twice. The length of the way says neither.
#[test]
fn curved_mirrors_and_balls_of_glass_are_focused_on_their_images() {
    let (radius, before, ior) = (1.0, 4.0, 1.5);
    for (name, mesh, tolerance) in balls() {
        let ball = |material: Material, wall_at: Transform| {
            let mut scene = stage();
            let shape = match &mesh {
                Some(mesh) => Shape::Mesh(scene.add_mesh(mesh.clone())),
                None => Shape::Sphere { radius: radius as f32 },
            };
            // A turn puts no vertex on the axis.
            let turn = Transform::rotate(Vec3::new(1.0, 2.0, 3.0), 0.321);
            put(&mut scene, shape, material, at(0.0, 0.0, -before - radius) * turn);
            put(&mut scene, screen(), wall(), wall_at);
            Prepared::new(&scene).unwrap().focus_on(SIZE, MIDDLE).expect(name)
        };
        // The wall is behind the camera, 6 m from the mirror.
        let focus = ball(mirror(), at(0.0, 0.0, 6.0 - before));
        assert_near(focus.distance, before + 1.0 / (1.0 / 6.0 + 2.0 / radius), tolerance);
        assert_near(focus.path_length, before + 6.0, tolerance);

        // 3 m behind the ball. The second border first: light comes from there.
        let focus = ball(Dielectric::new(ior as f32).into(), at(0.0, 0.0, -before - 2.0 - 3.0));
        let inside = ior / ((ior - 1.0) / radius - 1.0 / 3.0);
        let object = 2.0 * radius - inside;
        let image = 1.0 / ((ior - 1.0) / radius - ior / object);
        assert!(image > 0.0 && image < before, "a real image before the ball: {image}");
        assert_near(focus.distance, before - image, 2.0 * tolerance);
        assert_near(focus.path_length, before + 5.0, tolerance);
        assert_eq!(focus.bounces, 2);
    }
}

/// What is focused on is sharp in the picture: seen through a glass ball, a small lamp is a point
/// at the distance found, and a large spot at the length of the way.
#[test]
fn what_is_focused_on_is_sharp_in_the_picture() {
    let moment = |lens: Lens| {
        let camera = Perspective::look_at(Vec3::ZERO, Vec3::NEG_Z, 0.06).unwrap();
        let mut scene = Scene::new(Perspective { lens, ..camera });
        put(&mut scene, Shape::Sphere { radius: 1.0 }, Dielectric::new(1.5), at(0.0, 0.0, -5.0));
        let lamp = Emission::radiance(Rgb::WHITE);
        put(&mut scene, Shape::Disk { radius: 0.005 }, lamp, at(0.0, 0.0, -9.0));
        let image = render(&scene, Settings { size: SIZE, ..small(256) });
        let lit = image.channel("R").unwrap().iter().enumerate().map(|(i, &v)| {
            let (x, y) = ((i % 101) as f64 - 50.0, (i / 101) as f64 - 50.0);
            (x * x + y * y, f64::from(v))
        });
        // What the ball mirrors is elsewhere.
        let near: Vec<_> = lit.filter(|(r2, _)| *r2 < 900.0).collect();
        let light: f64 = near.iter().map(|(_, v)| v).sum();
        near.iter().map(|(r2, v)| r2 * v).sum::<f64>() / light
    };
    let open = Lens { aperture_radius: 0.03, ..Lens::pinhole(9.0) };
    let focused = moment(Lens { focus_on: Some(MIDDLE), ..open });
    let (by_path, pinhole) = (moment(open), moment(Lens::pinhole(9.0)));
    assert!(focused < 1.3 * pinhole + 0.1, "{focused} {pinhole}");
    assert!(by_path > 5.0 * focused, "{by_path} {focused}");
}

/// Where there is nothing to focus on the lens stays as it was.
#[test]
fn nothing_to_focus_on_changes_nothing() {
    let mut sky = stage();
    sky.environment = Some(Environment::constant(Rgb::WHITE));
    assert_eq!(Prepared::new(&sky).unwrap().focus_on(SIZE, MIDDLE), None);

    // Two mirrors that face each other.
    let mut hall = stage();
    put(&mut hall, screen(), mirror(), at(0.0, 0.0, -2.0));
    put(&mut hall, screen(), mirror(), at(0.0, 0.0, 2.0));
    assert_eq!(Prepared::new(&hall).unwrap().focus_on(SIZE, MIDDLE), None);

    // In a hollow mirror of focal length 1, 1.1 m before it: what is 1.2 m before it has its
    // image at 6 m, behind the camera.
    let mut bowl = stage();
    put(&mut bowl, Shape::Sphere { radius: 2.0 }, mirror(), at(0.0, 0.0, 0.9));
    put(&mut bowl, Shape::Disk { radius: 0.5 }, wall(), at(0.0, 0.0, 0.1));
    assert_eq!(Prepared::new(&bowl).unwrap().focus_on(SIZE, MIDDLE), None);

    let mut around = stage();
    put(&mut around, screen(), wall(), at(0.0, 0.0, -2.0));
    around.camera = Equirectangular::look_at(Vec3::ZERO, Vec3::NEG_Z).unwrap().into();
    assert_eq!(Prepared::new(&around).unwrap().focus_on(SIZE, MIDDLE), None);

    let open = Lens { aperture_radius: 0.1, ..Lens::pinhole(3.0) };
    let picture = |lens| {
        let mut scene = looking(lens);
        let lamp = Emission::radiance(Rgb::WHITE);
        put(&mut scene, Shape::Disk { radius: 0.1 }, lamp, at(0.5, 0.0, -4.0));
        render(&scene, small(4)).hash()
    };
    assert_eq!(picture(Lens { focus_on: Some(MIDDLE), ..open }), picture(open));
}

// ---- other cameras ----

/// On an orthographic picture a thing has the same size at any depth: its own.
#[test]
fn orthographic_sizes_do_not_depend_on_depth() {
    for depth in [0.5, 50.0] {
        let camera = Orthographic::look_at(Vec3::ZERO, Vec3::NEG_Z, 4.0).unwrap();
        let mut scene = Scene::new(camera);
        let lamp = Emission::radiance(Rgb::WHITE);
        let shape = Shape::Rectangle { size: Vec2::new(2.0, 1.0) };
        put(&mut scene, shape, lamp, at(1.0, 0.5, -depth));
        let settings = Settings {
            size: [32, 16],
            filter: Filter::Box { radius: 0.5 },
            max_depth: Some(1),
            ..small(16)
        };
        let image = render(&scene, settings);
        for (i, &v) in image.channel("G").unwrap().iter().enumerate() {
            // Four pixels a metre; the lamp reaches from (0, 0) to (2, 1), up is up.
            let (x, y) = (i % 32, i / 32);
            let lit = (16..24).contains(&x) && (4..8).contains(&y);
            assert_eq!(v, if lit { 1.0 } else { 0.0 }, "pixel {x},{y} at {depth} m");
        }
    }
}

/// A panorama of a sky is the sky's map, and so is that of a camera that is turned with its sky.
#[test]
fn an_equirectangular_picture_of_a_sky_is_its_map() {
    let (width, height) = (24_u32, 12_u32);
    let pixels: Vec<[f32; 3]> = (0..u64::from(width * height))
        .map(|i| {
            let (r, gb) = random(91, i);
            [1.0 + r, 1.0 + gb.x, 1.0 + gb.y]
        })
        .collect();
    let map = Image::from_rgb(width, height, &pixels).unwrap();
    // Interpolated between its neighbours' centres, a texel has 3/4 of itself along each axis and
    // 1/8 of each neighbour; beyond a pole lies the other side.
    let texel = |x: i64, y: i64| match y {
        -1 => pixels[(x + 12).rem_euclid(24) as usize],
        12 => pixels[((x + 12).rem_euclid(24) + 24 * 11) as usize],
        _ => pixels[(x.rem_euclid(24) + 24 * y) as usize],
    };
    let texel_mean = |x: i64, y: i64| -> [f32; 3] {
        std::array::from_fn(|c| {
            let weights = [(-1, 0.125), (0, 0.75), (1, 0.125)];
            let across = |y| weights.map(|(dx, w)| w * texel(x + dx, y)[c]).iter().sum::<f32>();
            weights.map(|(dy, w)| w * across(y + dy)).iter().sum()
        })
    };
    let towards_x = Equirectangular::look_at(Vec3::ZERO, Vec3::X).unwrap();
    for (camera, rotation) in [
        (Equirectangular::look_at(Vec3::ZERO, Vec3::NEG_Z).unwrap(), 0.0),
        // The sky is turned counter-clockwise, so that its middle is at −x, then clockwise to +x.
        (towards_x, -std::f32::consts::FRAC_PI_2),
    ] {
        let mut scene = Scene::new(camera);
        scene.add_image(map.clone());
        scene.environment = Some(Environment { rotation, ..Environment::image(ImageId(0)) });
        for integrator in [IntegratorKind::Path, IntegratorKind::Direct] {
            let settings = Settings {
                size: [width, height],
                filter: Filter::Box { radius: 0.5 },
                integrator,
                sampler: SamplerKind::Sobol,
                ..small(1024)
            };
            let seen = render(&scene, settings).rgb().unwrap();
            for (i, seen) in seen.iter().enumerate() {
                let expected = texel_mean(i as i64 % 24, i as i64 / 24);
                for (s, t) in seen.iter().zip(expected) {
                    assert!((s - t).abs() < 2e-3, "texel {i}: {seen:?} {expected:?}");
                }
            }
        }
    }
}

/// The panorama of an even sky is even up to its edges and poles, whatever the filter reaches.
#[test]
fn panoramas_go_on_beyond_their_edges() {
    let mut scene = Scene::new(Equirectangular::look_at(Vec3::ZERO, Vec3::X).unwrap());
    scene.environment = Some(Environment::constant(Rgb::WHITE));
    let wide = Settings { filter: Filter::Gaussian { radius: 16.0, sigma: 8.0 }, ..small(64) };
    let (mean, _) = mean(&render(&scene, wide), "G");
    assert!((mean - 1.0).abs() < 1e-5, "{mean}");
}
