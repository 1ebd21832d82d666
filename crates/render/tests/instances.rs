//! A mesh that is stored once gives the very picture that copies of it give.

use rutilant::bsdf::{Bsdf, Lambert, Lobe};
use rutilant::camera::Perspective;
use rutilant::color::Rgb;
use rutilant::color::Spectrum;
use rutilant::geom::{BuildOptions, Mat3, Ray, Simd, Transform, Vec2, Vec3, real};
use rutilant::light::{Environment, Light};
use rutilant::material::{
    CustomMaterial, Dielectric, Emission, EmittedLight, Matte, Mirror, Mix, SurfacePoint,
};
use rutilant::material::{Material, MaterialKind};
use rutilant::scene::Scene;
use rutilant::settings::{IntegratorKind, LightSelection, Settings, Strategy};
use rutilant::shape::{Mesh, Object, Shape};
use rutilant::{Prepared, Session};
use std::f32::consts::TAU;
use std::sync::Arc;
use std::time::Duration;

/// A closed, dented ball of 2 · around · (up - 1) triangles, with texture coordinates.
fn dented(around: u32, up: u32) -> Mesh {
    let mut mesh = Mesh { name: "dented".into(), ..Mesh::default() };
    let point = |i: u32, j: u32| {
        let (s, c) = real::sin_cos(TAU * i as f32 / around as f32);
        let (sin, cos) = real::sin_cos(0.5 * TAU * j as f32 / up as f32);
        let r = 1.0 - 0.2 * ((i + 2 * j) % 3) as f32 / 3.0;
        Vec3::new(sin * c, cos, -sin * s) * r
    };
    mesh.positions.extend([Vec3::Y, Vec3::NEG_Y]);
    for j in 1..up {
        mesh.positions.extend((0..around).map(|i| point(i, j)));
    }
    let at = |i: u32, j: u32| match j {
        0 => 0,
        _ if j == up => 1,
        _ => 2 + (j - 1) * around + i % around,
    };
    for (i, j) in (0..up).flat_map(|j| (0..around).map(move |i| (i, j))) {
        let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
        mesh.triangles.extend(
            [[a, b, c], [a, c, d]].into_iter().filter(|[a, b, c]| a != b && b != c && a != c),
        );
    }
    mesh.uvs = mesh.positions.iter().map(|p| Vec2::new(p.x, p.y)).collect();
    mesh
}

/// Coloured by the texture coordinates.
#[derive(Debug)]
struct Chart;

impl CustomMaterial for Chart {
    fn bsdf(&self, point: &SurfacePoint) -> Bsdf {
        let albedo = Rgb::new(point.uv.x.abs().min(1.0), point.uv.y.abs().min(1.0), 0.3);
        Lobe::Lambert(Lambert { albedo: Spectrum::from(albedo) }).into()
    }
}

/// Meshes, flat and smooth, open and closed, in glass, mirror, matte and light, in many places:
/// turned, sheared, mirrored, one in the other. `custom` says whether there are materials of others'
/// making, which only `path.rs` knows; `ranked` whether glass has a priority.
fn scene(custom: bool, ranked: bool) -> Scene {
    let camera = Perspective::look_at(Vec3::new(0.3, 1.1, 5.0), Vec3::ZERO, 0.8).unwrap();
    let mut scene = Scene::new(camera);
    scene.environment = Some(Environment::constant(Rgb::new(0.2, 0.3, 0.5)));
    scene.lights.push(Light::Point {
        position: Vec3::new(0.0, 4.0, 2.0),
        intensity: Rgb::grey(9.0),
        group: None,
    });
    let red = scene.add_material(Matte::new(Rgb::new(0.7, 0.2, 0.1)));
    let mut clear = Dielectric::new(1.5);
    clear.priority = ranked.then_some(1);
    let glass = scene.add_material(clear);
    let mirror = scene.add_material(Mirror { reflectance: Rgb::grey(0.9) });
    let mixed = scene.add_material(Mix { first: red, second: mirror, amount: 0.4 });
    let lamp = scene.add_material(Emission::radiance(Rgb::new(4.0, 3.0, 2.0)));
    let spread = scene.add_material(Emission {
        light: EmittedLight::Power(Rgb::grey(6.0)),
        two_sided: true,
        ..Emission::radiance(Rgb::WHITE)
    });
    let chart = Material {
        kind: MaterialKind::Custom(Arc::new(Chart)),
        ..Material::from(Matte::new(Rgb::BLACK))
    };
    let chart = if custom { scene.add_material(chart) } else { red };
    let flat = dented(7, 5);
    let smooth = dented(9, 6).smoothed(TAU);
    // Wound inside out; of glass it is turned.
    let mut wrong = smooth.clone();
    wrong.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    let mut open = flat.clone();
    open.triangles.truncate(20);
    let meshes = [flat, smooth, wrong, open].map(|mesh| scene.add_mesh(mesh));
    let floor = Object::new(Shape::Rectangle { size: Vec2::splat(20.0) }, red);
    let down = Transform::translate(Vec3::Y * -1.0) * Transform::rotate_degrees(Vec3::X, -90.0);
    scene.objects.push(floor.transformed(&down));
    let looks = [red, glass, mixed, lamp, chart, glass, mirror, spread];
    for i in 0..48_usize {
        let part = |k: u32| {
            let word =
                (i as u32 + 1).wrapping_mul(0x9e37_79b9).rotate_left(k).wrapping_mul(0x85eb_ca6b);
            (word >> 8) as f32 / (1 << 23) as f32 - 1.0
        };
        let shear = Mat3::from_cols(
            Vec3::new(0.4, 0.2 * part(1), 0.1 * part(2)),
            Vec3::new(0.1 * part(3), 0.3 + 0.1 * part(4), 0.2 * part(5)),
            Vec3::new(0.2 * part(6), 0.1 * part(7), if i % 5 == 0 { -0.3 } else { 0.35 }),
        );
        let to = Vec3::new(2.2 * part(9), 1.2 * part(11), 1.5 * part(13));
        let object = Object::new(Shape::Mesh(meshes[i % 4]), looks[i / 2 % looks.len()]);
        scene.objects.push(object.transformed(&Transform::new(shear, to)));
        if i % 9 == 0 {
            let ball = Object::new(Shape::Sphere { radius: 0.2 }, glass);
            scene.objects.push(ball.transformed(&Transform::translate(to)));
        }
    }
    // The very same place twice: which of them is met?
    let twin = scene.objects[5].clone();
    scene.objects.push(Object { material: mirror, ..twin });
    scene
}

/// The scene with copies of all meshes, and with each of them stored once.
fn both(scene: &Scene) -> [Arc<Prepared>; 2] {
    [u32::MAX, 0].map(|copies| {
        let options = BuildOptions { copies, ..BuildOptions::default() };
        Arc::new(Prepared::with_options(scene, &options).unwrap())
    })
}

fn hash(prepared: &Arc<Prepared>, settings: &Settings) -> u64 {
    let session = Session::start(Arc::clone(prepared), settings.clone(), 2).unwrap();
    while !session.wait(Duration::from_secs(3600)) {}
    session.snapshot().hash()
}

/// Every way of rendering gives the same bits, with smooth normals, glass and caustics, lamps,
/// priorities, texture coordinates; with eight paths at once and alone, at every SIMD level. A
/// number that is taken for another's, a normal or an emitter of another place, a mirrored triangle
/// that is not turned: all show here.
#[test]
fn instances_give_the_picture_that_copies_give() {
    let ways: Vec<Settings> = {
        let base = Settings { size: [61, 47], spp: 8, ..Settings::default() };
        let integrator = |integrator| Settings { integrator, ..base.clone() };
        vec![
            base.clone(),
            Settings { strategy: Strategy::LightOnly, ..base.clone() },
            Settings { light_selection: LightSelection::Uniform, ..base.clone() },
            integrator(IntegratorKind::Naive),
            integrator(IntegratorKind::Direct),
            integrator(IntegratorKind::Normals),
        ]
    };
    for (custom, ranked) in [(false, false), (true, false), (false, true)] {
        let [copies, instances] = both(&scene(custom, ranked));
        assert_eq!((copies.report().instances, copies.report().shared_meshes), (0, 0));
        assert_eq!((instances.report().instances, instances.report().shared_meshes), (49, 4));
        for settings in &ways {
            assert_eq!(hash(&instances, settings), hash(&copies, settings), "{settings:?}");
        }
        let expected = hash(&copies, &ways[0]);
        for simd in [Simd::Scalar, Simd::Sse4, Simd::Avx2] {
            if let Some(other) = Prepared::clone(&instances).with_simd(simd) {
                assert_eq!(hash(&Arc::new(other), &ways[0]), expected, "{simd:?}");
            }
        }
    }
}

/// What is said about the scene is the same, but for what is stored; and all lamps are.
#[test]
fn instances_are_told_of_as_copies_are() {
    let [copies, instances] = both(&scene(false, false));
    let (one, other) = (copies.report(), instances.report());
    assert_eq!(one.triangles, other.triangles);
    assert_eq!(one.triangles, one.stored_triangles);
    assert!(other.stored_triangles * 5 < one.stored_triangles, "{other:?}");
    assert!(other.bvh.bytes * 3 < one.bvh.bytes, "{} {}", other.bvh.bytes, one.bvh.bytes);
    assert_eq!(one.bounds, other.bounds);
    let [lamps, others] = [&copies, &instances].map(|p| format!("{:?}", p.emitters()));
    assert_eq!(lamps, others);
    // Of a mesh that is wound inside out it is told once.
    let about = |prepared: &Prepared| {
        prepared.report().notes.iter().filter(|n| n.what.contains("inside out")).count()
    };
    assert!(about(&copies) > 1);
    assert_eq!(about(&instances), 1);
}

/// A ray meets the same, and finds the same surface there.
#[test]
fn interactions_are_those_of_copies() {
    let [copies, instances] = both(&scene(true, false));
    let mut met = 0;
    for i in 0..20_000_u32 {
        let part = |k: u32| {
            let word = (i + 1).wrapping_mul(0x9e37_79b9).rotate_left(k).wrapping_mul(0x85eb_ca6b);
            (word >> 8) as f32 / (1 << 23) as f32 - 1.0
        };
        let origin = Vec3::new(part(1), part(3), part(5)) * 4.0;
        let direction = (Vec3::new(part(7), part(9), part(11)) - origin).normalize_or(Vec3::X);
        let ray = Ray::new(origin, direction);
        let (one, other) = (copies.closest(&ray), instances.closest(&ray));
        assert_eq!(one.map(|h| h.position), other.map(|h| h.position), "{ray:?}");
        let (Some(one), Some(other)) = (one, other) else { continue };
        met += usize::from(other.instance.is_some());
        assert_eq!(copies.uv(&one), instances.uv(&other), "{ray:?}");
        let told = |prepared: &Prepared, hit| format!("{:?}", prepared.interaction(hit, direction));
        assert_eq!(told(&copies, &one), told(&instances, &other), "{ray:?}");
    }
    assert!(met > 4_000, "{met}");
}

/// Edits go on working: a material, a place, one less.
#[test]
fn edited_instances_are_those_of_a_new_scene() {
    let mut scene = scene(false, false);
    let options = BuildOptions { copies: 0, ..BuildOptions::default() };
    let mut prepared = Prepared::with_options(&scene, &options).unwrap();
    let settings = Settings { size: [31, 23], spp: 4, ..Settings::default() };
    let edits: [fn(&mut Scene); 4] = [
        |scene| scene.objects[7].material = scene.objects[3].material,
        |scene| scene.objects[9].world_from_object = scene.objects[10].world_from_object,
        |scene| drop(scene.objects.remove(12)),
        |scene| scene.meshes[0].positions[4] *= 1.5,
    ];
    for edit in edits {
        edit(&mut scene);
        prepared = prepared.edited(&scene).unwrap();
        let anew = Arc::new(Prepared::with_options(&scene, &options).unwrap());
        let copied = Arc::new(Prepared::new(&scene).unwrap());
        let edited = Arc::new(prepared.clone());
        assert_eq!(hash(&edited, &settings), hash(&anew, &settings));
        assert_eq!(hash(&edited, &settings), hash(&copied, &settings));
    }
}

/// The scene alone decides what is copied: meshes that need few copies, as long as these are few,
/// and those that stand once or are small. More places than 32 bits can number are no error.
#[test]
fn only_meshes_that_need_many_copies_are_stored_once() {
    let camera = Perspective::look_at(Vec3::Z * 3.0, Vec3::ZERO, 0.7).unwrap();
    let mut scene = Scene::new(camera);
    let matte = scene.add_material(Matte::new(Rgb::grey(0.5)));
    // Of 2 · 64 · 31 = 3968, 2 · 16 · 7 = 224 and 2 · 3 · 2 = 12 triangles.
    let [large, middle, tiny] =
        [(64, 32), (16, 8), (3, 3)].map(|(around, up)| scene.add_mesh(dented(around, up)));
    let stand = |scene: &mut Scene, mesh, times: usize| {
        scene.objects.extend((0..times).map(|_| Object::new(Shape::Mesh(mesh), matte)));
    };
    let told = |scene: &Scene, copies: u32| {
        let options = BuildOptions { copies, ..BuildOptions::default() };
        let prepared = Prepared::with_options(scene, &options).unwrap();
        let report = prepared.report();
        (report.shared_meshes, report.instances, report.stored_triangles)
    };
    stand(&mut scene, large, 1);
    stand(&mut scene, middle, 3);
    stand(&mut scene, tiny, 50);
    assert_eq!(told(&scene, 0), (1, 3, 3968 + 224 + 50 * 12));
    assert_eq!(told(&scene, 2 * 224 - 1), (1, 3, 3968 + 224 + 50 * 12));
    assert_eq!(told(&scene, 2 * 224), (0, 0, 3968 + 3 * 224 + 50 * 12));
    stand(&mut scene, large, 1);
    // The middle one is copied first.
    assert_eq!(told(&scene, 2 * 224), (1, 2, 3968 + 3 * 224 + 50 * 12));
    assert_eq!(told(&scene, 2 * 224 + 3968), (0, 0, 2 * 3968 + 3 * 224 + 50 * 12));

    // 1.2 million places, 4.8 · 10⁹ triangles, of which two copies would be as many as may be made.
    let all = 1_200_000;
    scene.objects.truncate(0);
    stand(&mut scene, large, all);
    scene.validate().unwrap();
    // Each a light, they would be too many.
    let lamp = scene.add_material(Emission::radiance(Rgb::WHITE));
    scene.objects.iter_mut().for_each(|object| object.material = lamp);
    let problem = scene.validate().unwrap_err();
    assert!(problem.what.contains("2147483648"), "{problem}");
}
