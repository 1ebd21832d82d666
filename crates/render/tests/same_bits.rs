//! A picture is a function of scene and settings, bit by bit: not of threads, crops or pauses.

mod common;

use rutilant::camera::Perspective;
use rutilant::color::Rgb;
use rutilant::film::Filter;
use rutilant::geom::{Simd, Transform, Vec2, Vec3};
use rutilant::image::Image;
use rutilant::light::{Environment, Light, LightGroup};
use rutilant::material::{
    Absorption, Dielectric, Emission, Material, Matte, Medium, Mirror, Mix, Opacity, OpacityMode,
    Principled, Sides,
};
use rutilant::scene::Scene;
use rutilant::settings::{
    Crop, Heuristic, Layer, Layers, LightSelection, Roulette, SamplerKind, Settings, Strategy,
};
use rutilant::shape::{Mesh, Object, Shape};
use rutilant::texture::{Bitmap, Channel, Checker, ImageTexture, ScalarInput, Texels, UvMapping};
use rutilant::{Prepared, Session};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Some of everything: glass, a lamp, a sky, a floor, a lens.
fn scene() -> Arc<Prepared> {
    Arc::new(Prepared::new(&open_scene()).unwrap())
}

fn open_scene() -> Scene {
    let mut camera = Perspective::look_at(Vec3::new(0.0, 1.0, 4.0), Vec3::ZERO, 0.8).unwrap();
    camera.lens.aperture_radius = 0.05;
    let mut scene = Scene::new(camera);
    let [sky, key] = ["sky", "key"].map(|name| LightGroup::new(name).unwrap());
    scene.environment = Some(Environment::constant(Rgb::new(0.2, 0.3, 0.5)).in_group(sky));
    let floor = scene.add_material(Matte::new(Rgb::new(0.7, 0.6, 0.5)));
    let glass = scene.add_material(Dielectric::new(1.5));
    let lamp = scene.add_material(Emission::radiance(Rgb::grey(9.0)).in_group(key));
    let at = |x, y, z| Transform::translate(Vec3::new(x, y, z));
    let flat = at(0.0, -0.8, 0.0) * Transform::rotate(Vec3::X, -std::f32::consts::FRAC_PI_2);
    scene
        .objects
        .push(Object::new(Shape::Rectangle { size: Vec2::splat(20.0) }, floor).transformed(&flat));
    scene
        .objects
        .push(Object::new(Shape::Sphere { radius: 0.8 }, glass).transformed(&at(-1.0, 0.0, 0.0)));
    scene
        .objects
        .push(Object::new(Shape::Box { size: Vec3::ONE }, floor).transformed(&at(1.0, 0.0, 0.0)));
    scene
        .objects
        .push(Object::new(Shape::Sphere { radius: 0.3 }, lamp).transformed(&at(0.0, 2.0, 0.0)));
    scene
}

/// With every layer: what is true of the light shall be true of them.
fn settings(spp: u64) -> Settings {
    Settings { size: [101, 97], spp, layers: Layers::all(), ..Settings::default() }
}

/// Pixels that only add, and pixels that learn from each sample for the next.
const HEURISTICS: [Heuristic; 2] = [Heuristic::Power, Heuristic::Optimal];

fn finish(session: &Session) -> Image {
    while !session.wait(Duration::from_secs(3600)) {}
    session.snapshot()
}

fn render(scene: &Arc<Prepared>, settings: Settings, threads: usize) -> Image {
    finish(&Session::start(Arc::clone(scene), settings, threads).unwrap())
}

/// The old program cut its buffer by the number of threads: 7 left rows undrawn, 16 shifted bands.
#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let scene = scene();
    for (sampler, heuristic) in [
        (SamplerKind::Sobol, Heuristic::Power),
        (SamplerKind::Independent, Heuristic::Power),
        (SamplerKind::Sobol, Heuristic::Optimal),
    ] {
        let settings = Settings { sampler, heuristic, ..settings(4) };
        let one = render(&scene, settings.clone(), 1).hash();
        for threads in [2, 3, 5, 7, 16, 61] {
            assert_eq!(render(&scene, settings.clone(), threads).hash(), one, "{threads} threads");
        }
    }
}

/// Eight paths at once are the paths that each is alone: the scalar level traces them one by one.
/// All that differs must be noticed: lenses, skies, spheres, glass with colour in it, rough,
/// layered and textured materials, veils, smooth meshes, every strategy, heuristic, roulette and way to choose lights.
#[test]
fn paths_together_are_those_alone() {
    let even = scene_of_everything();
    let mut sunny = even.clone();
    let pixels: Vec<[f32; 3]> =
        (0..32).map(|i| if i == 11 { [40.0, 30.0, 20.0] } else { [0.2, 0.3, 0.5] }).collect();
    let sky = sunny.add_image(Image::from_rgb(8, 4, &pixels).unwrap());
    let map = Environment::image(sky).in_group(LightGroup::new("sky").unwrap());
    sunny.environment = Some(map);
    for scene in [even, sunny] {
        assert_together_as_alone(&scene);
    }
}

fn assert_together_as_alone(scene: &Scene) {
    let prepared = |simd| Prepared::new(scene).unwrap().with_simd(simd).map(Arc::new);
    let alone = prepared(Simd::Scalar).expect("no instructions are needed");
    let usual = Settings { size: [37, 23], ..settings(6) };
    let mut cases = vec![usual.clone()];
    for strategy in [Strategy::BsdfOnly, Strategy::LightOnly, Strategy::Both] {
        for heuristic in [Heuristic::Balance, Heuristic::Power] {
            cases.push(Settings { strategy, heuristic, ..usual.clone() });
        }
    }
    for roulette in [Roulette::Off, Roulette::Albedo] {
        cases.push(Settings { roulette, max_depth: Some(9), ..usual.clone() });
    }
    for light_selection in [LightSelection::Uniform, LightSelection::Power, LightSelection::Tree] {
        cases.push(Settings {
            light_selection,
            sampler: SamplerKind::Independent,
            ..usual.clone()
        });
    }
    cases.push(Settings { filter: Filter::Box { radius: 0.5 }, ..usual.clone() });
    for simd in [Simd::Sse4, Simd::Avx2, Simd::Auto] {
        let Some(together) = prepared(simd) else { continue };
        for settings in &cases {
            let (one, all) =
                (render(&alone, settings.clone(), 1), render(&together, settings.clone(), 1));
            assert_eq!(one.hash(), all.hash(), "{simd:?} {settings:?}");
        }
    }
}

fn mirror_of(reflectance: f32) -> Material {
    Mirror { reflectance: Rgb::grey(reflectance) }.into()
}

/// What eight paths do at once, and what each does for itself.
fn scene_of_everything() -> Scene {
    let mut scene = open_scene();
    let sphere = || Shape::Sphere { radius: 0.4 };
    let add = |scene: &mut Scene, shape: Shape, material, [x, y, z]: [f32; 3]| {
        let at = Transform::translate(Vec3::new(x, y, z));
        scene.objects.push(Object::new(shape, material).transformed(&at));
    };
    let green = Dielectric {
        interior: Medium { ior: 1.5, absorption: Absorption::Coefficient(Rgb::new(2.0, 0.1, 2.0)) },
        ..Dielectric::new(1.5)
    };
    let green = scene.add_material(green);
    add(&mut scene, Shape::Box { size: Vec3::splat(0.7) }, green, [0.4, -0.4, 1.2]);
    let frosted = scene.add_material(Dielectric { roughness: 0.3, ..Dielectric::new(1.4) });
    add(&mut scene, sphere(), frosted, [-0.2, -0.4, 1.5]);
    let clay = scene.add_material(Matte { roughness: 0.8, ..Matte::new(Rgb::new(0.6, 0.3, 0.2)) });
    add(&mut scene, sphere(), clay, [1.6, -0.4, 1.0]);
    let mirror = scene.add_material(Mirror { reflectance: Rgb::grey(0.9) });
    add(&mut scene, sphere(), mirror, [-1.6, -0.4, 1.0]);
    let mixed = scene.add_material(Mix { first: clay, second: mirror, amount: 0.4 });
    add(&mut scene, sphere(), mixed, [0.9, 0.6, -0.5]);
    // Six corners with normals that point away from the middle.
    let corners = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| [axis, -axis]).concat();
    let octahedron = scene.add_mesh(Mesh {
        name: "octahedron".into(),
        positions: corners.iter().map(|&corner| 0.4 * corner).collect(),
        normals: corners,
        triangles: (0..8)
            .map(|i| [i & 1, 2 + (i >> 1 & 1), 4 + (i >> 2)])
            .map(|[a, b, c]| if (a + b + c) % 2 == 0 { [a, b, c] } else { [a, c, b] })
            .collect(),
        ..Mesh::default()
    });
    let glass = scene.add_material(Dielectric::new(1.5));
    add(&mut scene, Shape::Mesh(octahedron), glass, [-0.7, -0.3, 2.0]);
    add(&mut scene, Shape::Mesh(octahedron), clay, [0.9, -0.3, 2.0]);
    let codes = (0..6 * 5 * 3_u32).map(|i| (i * 89 % 251) as u8).collect();
    let bitmap = scene.add_bitmap(Bitmap::new(6, 5, 3, Texels::Eight(codes)).unwrap());
    let picture = scene.add_texture(ImageTexture::new(bitmap));
    let (first, second, mapping) = (Rgb::BLACK, Rgb::grey(0.8), UvMapping::default());
    let board = scene.add_texture(Checker { first, second, mapping });
    for (x, texture) in [(-0.4, picture), (0.5, board)] {
        let smooth = scene.add_material(Matte::new(texture));
        let rough = scene.add_material(Matte { roughness: 0.6, ..Matte::new(texture) });
        let amount = ScalarInput { factor: 1.0, texture: Some((texture, Channel::Red)) };
        for (mode, y) in [(OpacityMode::Blend, 0.5), (OpacityMode::Mask { cutoff: 0.3 }, 0.8)] {
            let opacity = Some(Opacity { amount, vertex_colors: false, mode });
            let veil = scene.add_material(Material { opacity, ..Matte::new(texture).into() });
            add(&mut scene, Shape::Rectangle { size: Vec2::splat(0.8) }, veil, [x, y, 1.6]);
        }
        let half = scene.add_material(Mix { first: smooth, second: mirror, amount: 0.3 });
        add(&mut scene, sphere(), smooth, [x, 1.0, -0.6]);
        add(&mut scene, Shape::Box { size: Vec3::splat(0.3) }, rough, [x, -0.6, 2.4]);
        add(&mut scene, Shape::Disk { radius: 0.2 }, half, [x, 0.2, 1.0]);
    }
    // Some of these are seen from behind.
    for (x, material) in [(-1.2, Material::from(Matte::new(board))), (1.2, mirror_of(0.6))] {
        let front = scene.add_material(Material { sides: Sides::Front, ..material });
        add(&mut scene, Shape::Box { size: Vec3::splat(0.5) }, front, [x, 0.4, 0.4]);
        add(&mut scene, Shape::Rectangle { size: Vec2::splat(0.4) }, front, [x, -0.2, 2.2]);
        add(&mut scene, Shape::Sphere { radius: 9.0 }, front, [x, 0.0, 0.0]);
    }
    let metal = Principled { metallic: 1.0, anisotropy: 0.8, ..Principled::default() };
    let brushed = scene.add_material(metal);
    add(&mut scene, sphere(), brushed, [0.2, -0.4, 2.1]);
    add(&mut scene, Shape::Mesh(octahedron), brushed, [-1.5, 0.3, 1.6]);
    let panel = scene.add_material(Emission::radiance(Rgb::new(3.0, 5.0, 8.0)));
    add(&mut scene, Shape::Rectangle { size: Vec2::splat(0.7) }, panel, [0.0, 0.8, -1.0]);
    scene.lights.push(Light::Point {
        position: Vec3::new(0.0, 1.0, 2.0),
        intensity: Rgb::grey(2.0),
        group: LightGroup::new("point").ok(),
    });
    scene
}

/// Four continued passes of 16 samples are 64 samples in one go, if as many were planned.
#[test]
fn continued_renderings_are_those_in_one_go() {
    let scene = scene();
    for heuristic in HEURISTICS {
        let settings = |spp| Settings { heuristic, planned_spp: Some(64), ..settings(spp) };
        let whole = render(&scene, settings(64), 2);
        let mut session = Session::start(Arc::clone(&scene), settings(16), 3).unwrap();
        for spp in [32, 48, 64] {
            finish(&session);
            session.extend(spp);
        }
        assert_eq!(finish(&session).hash(), whole.hash());
    }
}

/// Stopped at any moment, in the middle of a pass, and continued: no sample is lost or taken twice.
#[test]
fn cancelled_renderings_continue_to_the_same_bits() {
    let scene = scene();
    for heuristic in HEURISTICS {
        let settings = Settings { heuristic, ..settings(32) };
        let whole = render(&scene, settings.clone(), 2);
        let mut session = Session::start(Arc::clone(&scene), settings, 2).unwrap();
        for pause in 0..12 {
            session.wait(Duration::from_millis(pause * 5));
            session.cancel();
            finish(&session);
            session.extend(32);
        }
        let image = finish(&session);
        assert_eq!(session.progress().samples, 32);
        assert_eq!(image.hash(), whole.hash());
    }
}

/// Layers are looked at beside the light, which stays what it is, to the bit: for eight paths at
/// once, for each alone, and where pixels learn.
#[test]
fn layers_leave_the_light_as_it_is() {
    let scene = scene_of_everything();
    for (simd, heuristic) in [
        (Simd::Auto, Heuristic::Power),
        (Simd::Scalar, Heuristic::Power),
        (Simd::Auto, Heuristic::Optimal),
    ] {
        let prepared = Prepared::new(&scene).unwrap().with_simd(simd).map(Arc::new).unwrap();
        let settings = Settings { size: [37, 23], heuristic, ..settings(6) };
        let plain = render(&prepared, Settings { layers: Layers::NONE, ..settings.clone() }, 2);
        let all = render(&prepared, settings.clone(), 2);
        let light = all.only(|name| plain.channel(name).is_some());
        assert_eq!(light.hash(), plain.hash(), "{simd:?} {heuristic:?}");
        // Nor does one layer change another.
        for (name, layer) in Layer::ALL {
            let one = render(
                &prepared,
                Settings { layers: [layer].into_iter().collect(), ..settings.clone() },
                2,
            );
            let same = all.only(|name| one.channel(name).is_some());
            let of_light = layer == Layer::Light || layer == Layer::Groups;
            let learns = heuristic == Heuristic::Optimal && of_light;
            assert_eq!(one.channels().len() == plain.channels().len(), learns, "{name}");
            assert_eq!(same.hash(), one.hash(), "{name}");
        }
    }
}

/// Windows of the picture, put together, are the picture.
#[test]
fn crops_compose() {
    for heuristic in HEURISTICS {
        assert_crops_compose(&Settings { heuristic, ..settings(4) });
    }
}

fn assert_crops_compose(settings: &Settings) {
    let scene = scene();
    let whole = render(&scene, settings.clone(), 2);
    let (columns, rows) = ([0, 16, 17, 70, 101], [0, 31, 97]);
    for (x, x_end) in columns.into_iter().zip(columns.into_iter().skip(1)) {
        for (y, y_end) in rows.into_iter().zip(rows.into_iter().skip(1)) {
            let crop = Crop { x, y, width: x_end - x, height: y_end - y };
            let part = render(&scene, Settings { crop: Some(crop), ..settings.clone() }, 2);
            assert!(part.channels().iter().all(|channel| whole.channel(&channel.name).is_some()));
            for whole in whole.channels() {
                // Ranks that no pixel of the part needs are left out.
                let Some(values) = part.channel(&whole.name) else {
                    assert!(whole.name.starts_with("Crypto"), "{}", whole.name);
                    continue;
                };
                for (i, value) in values.iter().enumerate() {
                    let (px, py) = (x + i as u32 % crop.width, y + i as u32 / crop.width);
                    let expected = whole.values[(py * 101 + px) as usize];
                    assert_eq!(value.to_bits(), expected.to_bits(), "{} at {px},{py}", whole.name);
                }
            }
        }
    }
}

/// A finished session can be looked at, asked to end and continued in any order without harm.
#[test]
fn sessions_end_cleanly() {
    let scene = scene();
    let mut session = Session::start(Arc::clone(&scene), settings(1_000_000), 2).unwrap();
    session.finish_pass();
    let image = finish(&session);
    let progress = session.progress();
    assert!(progress.finished && progress.samples < 1_000_000);
    assert_eq!(image.hash(), session.snapshot().hash());
    session.cancel();
    session.extend(1);
    session.finish_pass();
    finish(&session);

    // Without waiting in between: an edit in a window is just this.
    let target = session.progress().samples + 3;
    for _ in 0..20 {
        session.extend(1_000_000);
        session.cancel();
        session.extend(target);
        session.finish_pass();
        session.extend(target);
    }
    session.cancel();
    session.extend(target);
    session.cancel();
    finish(&session);
    drop(Session::start(scene, settings(1_000_000), 2).unwrap());
}

/// Who looks does not wait for rays, and who wants to end does not wait for a pass: not even where
/// all of the picture is one tile, on which a thread is always at work.
#[test]
fn nobody_waits_for_a_tile() {
    // Without light paths, during which nobody is at the tile.
    let small = Settings { size: [9, 7], caustics: false, ..settings(1 << 32) };
    let session = Session::start(scene(), small, 1).unwrap();
    let least = |image: &Image| {
        let counts = image.channel("samples.Y").unwrap().iter();
        counts.copied().fold(f32::INFINITY, f32::min)
    };
    while least(&session.snapshot()) < 1000.0 {}
    let (begin, before) = (Instant::now(), least(&session.snapshot()));
    for _ in 0..30 {
        session.snapshot();
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(least(&session.snapshot()) > before);
    session.cancel();
    finish(&session);
    let took = begin.elapsed();
    assert!(took < Duration::from_secs(3), "{took:?}");
}
