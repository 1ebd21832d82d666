//! Light groups: what each lamp brings is told apart, adds up to the picture, and is what the lamp would
//! bring alone.

mod common;

use common::{render, render_prepared};
use rutilant::bsdf::{Bsdf, Lambert, Lobe};
use rutilant::camera::{Orthographic, Perspective};
use rutilant::color::{Rgb, Spectrum};
use rutilant::film::Filter;
use rutilant::geom::{BuildOptions, Simd, Transform, Vec2, Vec3};
use rutilant::image::Image;
use rutilant::light::{Environment, Light, LightGroup, SpotLight};
use rutilant::material::{
    CustomMaterial, Dielectric, Emission, EmittedLight, Material, MaterialKind, Matte, Mirror,
    SurfacePoint,
};
use rutilant::scene::{MOST_GROUPS, Place, Scene};
use rutilant::settings::{
    Heuristic, IntegratorKind, Layer, Layers, LightSelection, Settings, Strategy,
};
use rutilant::shape::{Mesh, Object, Shape};
use rutilant::texture::{Checker, UvMapping};
use rutilant::{Prepared, Session};
use std::sync::Arc;
use std::time::Duration;

const GROUPS: [&str; 4] = ["key", "fill", "sky", "rest"];
const SIDE: u32 = 20;

fn group(name: &str) -> LightGroup {
    LightGroup::new(name).expect(name)
}

fn told() -> Layers {
    Layers::NONE.with(Layer::Groups)
}

fn settings(spp: u64) -> Settings {
    Settings { size: [SIDE; 2], spp, layers: told(), ..Settings::default() }
}

/// A floor with glass and a mirror on it, in the light of two glowing meshes and a ball ("key"), a
/// point and a spot ("fill"), a sky ("sky"), and a disk and a picture that shines (the rest). Each group
/// is as bright as `strengths` say.
fn stage(strengths: [f32; 4]) -> Scene {
    let [key, fill, sky, rest] = strengths;
    let times = |rgb: Rgb, by: f32| Rgb(rgb.0.map(|c| c * by));
    let eye = Vec3::new(0.0, 1.4, 4.0);
    let mut scene = Scene::new(Perspective::look_at(eye, Vec3::ZERO, 0.8).unwrap());
    let even = Environment::constant(times(Rgb::new(0.2, 0.3, 0.5), sky));
    scene.environment = Some(even.in_group(group("sky")));
    let point = Light::Point {
        position: Vec3::new(-2.0, 2.0, 2.0),
        intensity: times(Rgb::new(6.0, 4.0, 2.0), fill),
        group: Some(group("fill")),
    };
    scene.lights.push(point);
    let (position, direction) = (Vec3::new(2.0, 3.0, 1.0), Vec3::new(-2.0, -3.0, -1.0));
    let light = SpotLight::Intensity(times(Rgb::grey(9.0), fill));
    let spot = Light::Spot { position, direction, light, inner: 0.2, outer: 0.4, group: None };
    scene.lights.push(spot.in_group(group("fill")));

    let floor = scene.add_material(Matte::new(Rgb::new(0.7, 0.6, 0.5)));
    let glass = scene.add_material(Dielectric::new(1.5));
    let mirror = scene.add_material(Mirror { reflectance: Rgb::grey(0.8) });
    let glowing = Emission::radiance(times(Rgb::new(9.0, 8.0, 6.0), key)).in_group(group("key"));
    let lamp = scene.add_material(glowing);
    let panel = scene.add_material(Emission::radiance(times(Rgb::new(2.0, 3.0, 4.0), rest)));
    let (first, second, mapping) = (Rgb::grey(0.1), Rgb::WHITE, UvMapping::default());
    let board = scene.add_texture(Checker { first, second, mapping });
    let light = EmittedLight::Radiance(times(Rgb::new(1.0, 2.0, 1.0), rest));
    let shown = Emission { light, texture: Some(board), ..Emission::radiance(Rgb::WHITE) };
    let screen = scene.add_material(Material::new(MaterialKind::Black).emitting(shown));
    let corners = [[-0.5, -0.5], [0.5, -0.5], [0.0, 0.7]];
    let triangle = scene.add_mesh(Mesh {
        name: "triangle".into(),
        positions: corners.map(|[x, y]| Vec3::new(x, y, 0.0)).to_vec(),
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    });
    let down = Transform::rotate(Vec3::X, std::f32::consts::FRAC_PI_2);
    let at = |x, y, z| Transform::translate(Vec3::new(x, y, z));
    for (shape, material, place) in [
        (Shape::Box { size: Vec3::new(9.0, 0.1, 9.0) }, floor, at(0.0, -0.85, 0.0)),
        (Shape::Sphere { radius: 0.7 }, glass, at(-0.9, -0.1, 0.2)),
        (Shape::Box { size: Vec3::ONE }, mirror, at(1.2, -0.3, -0.2)),
        (Shape::Mesh(triangle), lamp, at(-0.8, 2.4, 0.0) * down),
        (Shape::Mesh(triangle), lamp, at(0.9, 2.0, 0.5) * down),
        (Shape::Sphere { radius: 0.15 }, lamp, at(0.1, 1.0, -0.5)),
        (Shape::Disk { radius: 0.4 }, panel, at(0.3, 0.6, -1.6)),
        (Shape::Rectangle { size: Vec2::splat(0.6) }, screen, at(-1.6, 0.8, -1.2)),
    ] {
        scene.objects.push(Object::new(shape, material).transformed(&place));
    }
    scene
}

/// The same with something that only one path at a time knows: a flame that rays pass, of the key.
fn burning(strengths: [f32; 4]) -> Scene {
    let mut scene = stage(strengths);
    let glow = Emission::radiance(Rgb(Rgb::new(2.0, 1.0, 0.2).0.map(|c| c * strengths[0])));
    let glow = Emission { two_sided: true, ..glow.in_group(group("key")) };
    let flame = scene.add_material(Material::new(MaterialKind::Null).emitting(glow));
    let veil = Object::new(Shape::Sphere { radius: 0.4 }, flame);
    scene.objects.push(veil.transformed(&Transform::translate(Vec3::new(0.3, -0.2, 1.2))));
    scene
}

fn channel<'i>(image: &'i Image, group: &str, c: &str) -> &'i [f32] {
    let name = format!("Combined_{group}.{c}");
    image.channel(&name).unwrap_or_else(|| panic!("no {name}"))
}

/// Every value of `c` as the light of all groups together, each this strong.
fn relit(image: &Image, strengths: [f32; 4], c: &str) -> Vec<f64> {
    let each = GROUPS.map(|name| channel(image, name, c));
    let all = each.iter().zip(strengths);
    let sum = |i: usize| all.clone().map(|(l, s)| f64::from(l[i]) * f64::from(s)).sum();
    (0..each[0].len()).map(sum).collect()
}

/// How far apart they are at most, for 1 being the brightest expected.
fn off(found: &[f64], expected: &[f32]) -> f64 {
    let brightest = f64::from(expected.iter().copied().fold(0.0, f32::max));
    let apart = found.iter().zip(expected).map(|(a, b)| (a - f64::from(*b)).abs());
    // What is no number is apart from everything.
    apart.fold(0.0, |most, d| if d <= most { most } else { d }) / brightest
}

/// The groups of every pixel add up to its light, up to rounding in single precision: whichever way
/// light is found, also by light paths, eight paths at a time and one by one. Light that is forgotten,
/// counted twice, or given to a group without its weight shows here.
#[test]
fn groups_add_up_to_the_light() {
    for (scene, strategy, caustics) in [
        (stage([1.0; 4]), Strategy::Both, true),
        (stage([1.0; 4]), Strategy::Both, false),
        (stage([1.0; 4]), Strategy::BsdfOnly, true),
        (stage([1.0; 4]), Strategy::LightOnly, true),
        (burning([1.0; 4]), Strategy::Both, true),
    ] {
        let image = render(&scene, Settings { strategy, caustics, ..settings(16) });
        for c in ["R", "G", "B"] {
            let apart = off(&relit(&image, [1.0; 4], c), image.channel(c).unwrap());
            assert!(apart < 1e-6, "{strategy:?} {c}: {apart}");
            // A point cannot be met by scattered rays.
            let unmet = strategy == Strategy::BsdfOnly;
            for name in GROUPS.into_iter().filter(|name| !unmet || *name != "fill") {
                let light = channel(&image, name, c);
                let most = light.iter().copied().fold(0.0, f32::max);
                assert!(light.iter().all(|v| *v >= 0.0) && most > 0.01, "{name}.{c}");
            }
        }
        let named = image.channels().iter().filter(|c| c.name.starts_with("Combined_"));
        assert_eq!(named.count(), 3 * GROUPS.len());
    }
}

/// A picture whose lamps are dimmed is the sum of the groups that are dimmed, on the very same paths:
/// where all lamps are chosen equally often, no path knows how bright they are. Also where one group is
/// all there is to see. Weights that depend on light, and light of others in a group, show here.
#[test]
fn dimmed_lamps_are_dimmed_groups() {
    for (scene, simd) in
        [(stage as fn([f32; 4]) -> Scene, Simd::Auto), (stage, Simd::Scalar), (burning, Simd::Auto)]
    {
        let usual =
            Settings { light_selection: LightSelection::Uniform, caustics: false, ..settings(8) };
        let shown = |strengths, settings: Settings| {
            let scene = Prepared::new(&scene(strengths)).unwrap().with_simd(simd).unwrap();
            render_prepared(scene, settings)
        };
        let told = shown([1.0; 4], usual.clone());
        // Black lamps would be none, and the choice of others another one.
        const NEARLY_OFF: f32 = 1e-12;
        for strengths in [
            [2.0, 1.0, 0.5, 1.0],
            [1.0, NEARLY_OFF, NEARLY_OFF, NEARLY_OFF],
            [NEARLY_OFF, 1.0, NEARLY_OFF, NEARLY_OFF],
            [NEARLY_OFF, NEARLY_OFF, 1.0, NEARLY_OFF],
            [NEARLY_OFF, NEARLY_OFF, NEARLY_OFF, 1.0],
        ] {
            let dimmed = shown(strengths, Settings { layers: Layers::NONE, ..usual.clone() });
            for c in ["R", "G", "B"] {
                let apart = off(&relit(&told, strengths, c), dimmed.channel(c).unwrap());
                assert!(apart < 1e-6, "{strengths:?} {c}: {apart}");
            }
        }
    }
}

/// Asserts that each group of a scene is what its lamps bring when there are no others at all, in the
/// mean over quarters of the picture. Of 16 renderings on each side a difference of six standard errors
/// comes by chance in one of 700 000.
fn assert_each_as_alone(whole: &Scene, groups: &[(&str, Scene)], usual: &Settings) {
    const RUNS: u64 = 16;
    let quarters = |light: &[f32]| {
        let mut sums = [0.0; 4];
        for (i, v) in light.iter().enumerate() {
            let (x, y) = (i as u32 % SIDE, i as u32 / SIDE);
            sums[(2 * (y / (SIDE / 2)) + x / (SIDE / 2)) as usize] += f64::from(*v);
        }
        sums
    };
    let mean = |runs: &[[f64; 4]], q: usize| {
        let n = runs.len() as f64;
        let mean = runs.iter().map(|run| run[q]).sum::<f64>() / n;
        let spread = runs.iter().map(|run| (run[q] - mean) * (run[q] - mean)).sum::<f64>();
        (mean, spread / (n * (n - 1.0)))
    };
    let shown = |scene: &Scene, first: u64| -> Vec<Image> {
        let prepared = Arc::new(Prepared::new(scene).unwrap());
        let seeds = first..first + RUNS;
        let settings = |seed| Settings { seed, ..usual.clone() };
        seeds.map(|seed| render_prepared(Arc::clone(&prepared), settings(seed))).collect()
    };
    let whole = shown(whole, 0);
    for (name, alone) in groups {
        let alone = shown(alone, 100);
        for c in ["R", "G", "B"] {
            let told: Vec<_> =
                whole.iter().map(|image| quarters(channel(image, name, c))).collect();
            let found: Vec<_> =
                alone.iter().map(|image| quarters(image.channel(c).unwrap())).collect();
            for q in 0..4 {
                let ((a, a_error), (b, b_error)) = (mean(&told, q), mean(&found, q));
                let z = (a - b) / (a_error + b_error).sqrt();
                assert!(a > 0.0 && z.abs() < 6.0, "{name}.{c}, quarter {q}: {a} and {b}, z = {z}");
            }
        }
    }
}

/// With lamps chosen by what they bring, paths are not those of a scene with fewer lamps; means are.
#[test]
fn a_group_is_what_its_lamps_bring_alone() {
    let alone = GROUPS.map(|name| {
        let mut alone = stage(GROUPS.map(|other| if other == name { 1.0 } else { 0.0 }));
        if name != "sky" {
            alone.environment = None;
        }
        if name != "fill" {
            alone.lights.clear();
        }
        (name, alone)
    });
    assert_each_as_alone(&stage([1.0; 4]), &alone, &settings(8));
}

/// The same of light that a glass ball throws on the floor, from small lamps and from a small sun in the
/// sky, so that nearly all of it is found by light paths. Light of those in the group of another lamp
/// shows here.
#[test]
fn caustics_are_of_the_lamps_that_throw_them() {
    let scene = |on: [bool; 3]| {
        let eye = Vec3::new(0.0, 4.0, 0.01);
        let mut scene = Scene::new(Perspective::look_at(eye, Vec3::ZERO, 0.7).unwrap());
        let floor = scene.add_material(Matte::new(Rgb::grey(0.8)));
        let glass = scene.add_material(Dielectric::new(1.5));
        let board = Shape::Box { size: Vec3::new(9.0, 0.1, 9.0) };
        let at = |x, y, z| Transform::translate(Vec3::new(x, y, z));
        scene.objects.push(Object::new(board, floor).transformed(&at(0.0, -0.6, 0.0)));
        let ball = Object::new(Shape::Sphere { radius: 0.4 }, glass);
        scene.objects.push(ball.transformed(&at(0.0, 0.0, 0.0)));
        for (on, name, x, radiance) in [
            (on[0], "left", -1.5, [900.0, 300.0, 90.0]),
            (on[1], "right", 1.5, [90.0, 300.0, 900.0]),
        ] {
            let lamp = Emission::radiance(Rgb(radiance)).in_group(group(name));
            let lamp = scene.add_material(lamp);
            let bulb = Object::new(Shape::Sphere { radius: 0.03 }, lamp);
            if on {
                scene.objects.push(bulb.transformed(&at(x, 1.0, 0.3)));
            }
        }
        let pixels: Vec<[f32; 3]> =
            (0..64 * 32).map(|i| if i == 64 * 5 + 20 { [300.0; 3] } else { [0.1; 3] }).collect();
        let map = scene.add_image(Image::from_rgb(64, 32, &pixels).unwrap());
        scene.environment = on[2].then(|| Environment::image(map).in_group(group("sky")));
        scene
    };
    let alone = [
        ("left", scene([true, false, false])),
        ("right", scene([false, true, false])),
        ("sky", scene([false, false, true])),
    ];
    assert_each_as_alone(&scene([true; 3]), &alone, &settings(16));
}

/// A floor that is no number in some places.
#[derive(Debug)]
struct Broken;

impl CustomMaterial for Broken {
    fn bsdf(&self, point: &SurfacePoint) -> Bsdf {
        let broken = (point.position.x * 40.0).floor() % 4.0 == 0.0;
        let albedo = Spectrum::splat(if broken { f32::NAN } else { 0.5 });
        Lobe::Lambert(Lambert { albedo }).into()
    }
}

/// A sample that is dropped is dropped from its groups as well: they stay numbers, and still add up.
#[test]
fn dropped_samples_are_in_no_group() {
    let mut scene = stage([1.0; 4]);
    let broken: Arc<dyn CustomMaterial> = Arc::new(Broken);
    scene.objects[0].material = scene.add_material(broken);
    for simd in [Simd::Auto, Simd::Scalar] {
        let prepared = Arc::new(Prepared::new(&scene).unwrap().with_simd(simd).unwrap());
        let session = Session::start(prepared, settings(16), 2).unwrap();
        while !session.wait(Duration::from_secs(3600)) {}
        assert!(session.progress().dropped.count > 100);
        let image = session.snapshot();
        for c in ["R", "G", "B"] {
            let apart = off(&relit(&image, [1.0; 4], c), image.channel(c).unwrap());
            assert!(apart < 1e-6, "{simd:?} {c}: {apart}");
        }
    }
}

/// Closed forms: an open plane of albedo ½ under a sky of radiance 1 sends back ½, and under a sun of
/// irradiance 2π straight above 1; a panel of radiance 3 that is seen shows 3. A missing weight, a lamp
/// in another's group, and light that is scattered twice show here.
#[test]
fn a_plane_tells_sky_and_sun_apart() {
    let camera = Orthographic::look_at(Vec3::Z * 5.0, Vec3::ZERO, 2.0).unwrap();
    let mut scene = Scene::new(camera);
    scene.environment = Some(Environment::constant(Rgb::WHITE).in_group(group("sky")));
    let irradiance = Rgb::grey(2.0 * std::f32::consts::PI);
    let sun = Light::Directional { direction: Vec3::NEG_Z, irradiance, group: None };
    scene.lights.push(sun.in_group(group("sun")));
    let grey = scene.add_material(Matte::new(Rgb::grey(0.5)));
    scene.objects.push(Object::new(Shape::Rectangle { size: Vec2::splat(20.0) }, grey));
    let image = render(&scene, Settings { size: [4, 4], ..settings(4) });
    for (name, expected) in [("sky", 0.5), ("sun", 1.0)] {
        for c in ["R", "G", "B"] {
            let light = channel(&image, name, c);
            assert!(light.iter().all(|v| (v - expected).abs() < 1e-5), "{name}.{c}: {light:?}");
        }
    }
    // Every light is of a group: there is no rest.
    assert!(image.channel("Combined_rest.R").is_none());

    let lamp = scene.add_material(Emission::radiance(Rgb::grey(3.0)));
    scene.objects[0].material = lamp;
    let image = render(&scene, Settings { size: [4, 4], ..settings(4) });
    for (name, expected) in [("sky", 0.0), ("sun", 0.0), ("rest", 3.0)] {
        assert!(channel(&image, name, "G").iter().all(|v| *v == expected), "{name}");
    }
}

/// An object's own group counts before that of its material, also where both places share one mesh.
/// Groups by material or by mesh, and numbers of triangles taken for those of lamps, show here.
#[test]
fn places_of_one_mesh_may_be_of_two_groups() {
    let camera = Orthographic::look_at(Vec3::Z * 5.0, Vec3::ZERO, 2.0).unwrap();
    let mut scene = Scene::new(camera);
    let lamp = Emission::radiance(Rgb::grey(3.0)).in_group(group("usual"));
    let lamp = scene.add_material(lamp);
    // Enough triangles to be stored once: a ladder of eight squares.
    let rungs = (0..9).flat_map(|i| [-0.4, 0.4].map(|x| Vec3::new(x, 0.5 * i as f32 - 2.0, 0.0)));
    let strip = scene.add_mesh(Mesh {
        positions: rungs.collect(),
        triangles: (0..16)
            .step_by(2)
            .flat_map(|i| [[i, i + 1, i + 3], [i, i + 3, i + 2]])
            .collect(),
        ..Mesh::default()
    });
    for (x, name) in [(-0.5, "left"), (0.5, "")] {
        let mut object = Object::new(Shape::Mesh(strip), lamp);
        if !name.is_empty() {
            object = object.in_group(group(name));
        }
        scene.objects.push(object.transformed(&Transform::translate(Vec3::X * x)));
    }
    for copies in [0, 1_000_000] {
        let options = BuildOptions { copies, ..BuildOptions::default() };
        let prepared = Prepared::with_options(&scene, &options).unwrap();
        assert_eq!(prepared.report().instances, if copies == 0 { 2 } else { 0 });
        let filter = Filter::Box { radius: 0.1 };
        let image = render_prepared(prepared, Settings { size: [4, 2], filter, ..settings(4) });
        for pixel in [1, 5] {
            assert_eq!(channel(&image, "left", "R")[pixel], 3.0);
            assert_eq!(channel(&image, "usual", "R")[pixel], 0.0);
            assert_eq!(channel(&image, "left", "R")[pixel + 1], 0.0);
            assert_eq!(channel(&image, "usual", "R")[pixel + 1], 3.0);
        }
    }
}

/// Where groups are not known, or there are none, that is said, and the picture goes without.
#[test]
fn what_tells_no_groups_says_so() {
    let groups =
        |image: &Image| image.channels().iter().filter(|c| c.name.starts_with("Combined_")).count();
    let told_by = |scene: &Scene, settings: &Settings| {
        let scene = Prepared::new(scene).unwrap();
        let notes = scene.notes_for(settings).into_iter().map(|note| note.what);
        let notes: Vec<String> = notes.filter(|what| what.contains("groups")).collect();
        (groups(&render_prepared(scene, settings.clone())), notes)
    };
    let scene = stage([1.0; 4]);
    let (path, none) = (settings(1), Vec::<String>::new());
    assert_eq!(told_by(&scene, &path), (12, none.clone()));
    for settings in [
        Settings { integrator: IntegratorKind::Naive, ..path.clone() },
        Settings { integrator: IntegratorKind::Direct, ..path.clone() },
        Settings { heuristic: Heuristic::Optimal, ..path.clone() },
    ] {
        let (channels, notes) = told_by(&scene, &settings);
        assert!(channels == 0 && notes.len() == 1, "{notes:?}");
        assert!(notes[0].starts_with("the layer \"groups\" is left out: only"), "{notes:?}");
    }
    let mut plain = Scene::new(scene.camera);
    plain.environment = Some(Environment::constant(Rgb::WHITE));
    let (channels, notes) = told_by(&plain, &path);
    assert_eq!((channels, notes.len()), (0, 1));
    assert!(notes[0].contains("no light of the scene has a group"), "{notes:?}");
    // All there are is none.
    assert_eq!(told_by(&plain, &Settings { layers: Layers::all(), ..path }), (0, none));
}

/// As many groups as there may be are told; one more is refused at the light that names it, and so are
/// pictures for whose groups there is no room.
#[test]
fn groups_are_bounded() {
    let mut scene = Scene::new(Perspective::look_at(Vec3::Z, Vec3::ZERO, 0.5).unwrap());
    let lamp = |i: usize| Light::Point {
        position: Vec3::ZERO,
        intensity: Rgb::WHITE,
        group: Some(group(&format!("lamp-{i}"))),
    };
    scene.lights.extend((0..MOST_GROUPS).map(lamp));
    // Of a name that is there already.
    scene.lights.push(lamp(3));
    let image = render(&scene, Settings { size: [2, 2], ..settings(1) });
    let told = image.channels().iter().filter(|c| c.name.starts_with("Combined_lamp-"));
    assert_eq!(told.count(), 3 * MOST_GROUPS);
    let large = Settings { size: [4096, 4096], ..settings(1) };
    let prepared = Arc::new(Prepared::new(&scene).unwrap());
    let problem = Session::start(prepared, large, 1).unwrap_err();
    assert_eq!((problem.place, problem.key), (Place::Settings, "layers"));
    assert!(problem.what.contains("at most 8388608 are"), "{}", problem.what);

    scene.lights.push(lamp(MOST_GROUPS));
    let problem = scene.validate().unwrap_err();
    assert_eq!((problem.place, problem.key), (Place::Light(MOST_GROUPS + 1), "group"));
    assert!(problem.what.contains("\"lamp-64\" is one too many"), "{}", problem.what);
}
