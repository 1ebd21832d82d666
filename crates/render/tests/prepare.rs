//! Proofs of how scenes are made traceable: sides are kept, broken parts are left out.

mod common;

use common::{mean, render, render_prepared, small};
use rutilant::Prepared;
use rutilant::camera::Perspective;
use rutilant::color::Rgb;
use rutilant::geom::{Ray, Transform, Vec2, Vec3};
use rutilant::image::Image;
use rutilant::light::{Environment, Light};
use rutilant::material::{
    Absorption, Bumps, Dielectric, Emission, Material, Matte, Mix, NormalMap,
};
use rutilant::scene::{MaterialId, MeshId, Place, Scene};
use rutilant::settings::{IntegratorKind, Settings, Strategy};
use rutilant::shape::{Mesh, Object, Shape};
use rutilant::texture::{Bitmap, ColorInput, ImageTexture};

fn scene() -> Scene {
    let camera = Perspective::look_at(Vec3::new(0.3, 0.7, 4.0), Vec3::ZERO, 0.6).unwrap();
    Scene::new(camera)
}

/// A cube of side 1 whose triangles face outwards.
fn cube() -> Mesh {
    let positions = (0..8)
        .map(|i| Vec3::from([0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 0.5 } else { -0.5 })))
        .collect();
    let faces =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = faces.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh { name: "cube".into(), positions, triangles, ..Mesh::default() }
}

fn inside_out(mut mesh: Mesh) -> Mesh {
    mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    mesh
}

fn coloured_glass(mesh: Mesh, place: Transform) -> Scene {
    let mut scene = scene();
    scene.environment = Some(Environment::constant(Rgb::WHITE));
    let mut glass = Dielectric::new(1.5);
    glass.interior.absorption = Absorption::Coefficient(Rgb::new(0.2, 1.0, 3.0));
    let glass = scene.add_material(glass);
    let mesh = scene.add_mesh(mesh);
    scene.objects.push(Object::new(Shape::Mesh(mesh), glass).transformed(&place));
    scene
}

#[track_caller]
fn assert_same(a: &Image, b: &Image) {
    for channel in ["R", "G", "B"] {
        let ((a, ea), (b, eb)) = (mean(a, channel), mean(b, channel));
        assert!(
            (a - b).abs() < 4.0 * (ea * ea + eb * eb).sqrt(),
            "{channel}: {a} ± {ea}, {b} ± {eb}"
        );
    }
}

/// Glass is inside its mesh whichever way the mesh is wound, and when it is mirrored: a mesh with
/// flipped winding silently swapped the indices of the old program.
#[test]
fn glass_is_inside_however_it_is_wound() {
    let turned = Transform::rotate(Vec3::ONE, 0.5);
    let right = coloured_glass(cube(), turned);
    let expected = render(&right, small(256));
    assert!(Prepared::new(&right).unwrap().report().notes.is_empty());

    let wrong = coloured_glass(inside_out(cube()), turned);
    let notes = Prepared::new(&wrong).unwrap().report().notes.clone();
    assert_eq!(notes.len(), 1, "{notes:?}");
    assert_eq!(notes[0].place, Some(Place::Object(0)));
    assert!(notes[0].to_string().starts_with("object 0: cube is wound inside out"), "{notes:?}");
    assert_same(&render(&wrong, small(256)), &expected);

    let mirrored = coloured_glass(cube(), turned * Transform::scale(Vec3::new(-1.0, 1.0, 1.0)));
    assert!(Prepared::new(&mirrored).unwrap().report().notes.is_empty());
    assert_same(&render(&mirrored, small(256)), &expected);
}

/// An open sheet encloses nothing, so that its winding alone says what is below it.
#[test]
fn open_sheets_are_never_turned() {
    for wound in [|m: Mesh| m, inside_out] {
        let wave = |x: f32, z: f32| Vec3::new(x, 0.1 * (x * z), z);
        let sheet = wound(Mesh {
            positions: vec![wave(-1.0, -1.0), wave(1.0, -1.0), wave(1.0, 1.0), wave(-1.0, 1.0)],
            triangles: vec![[0, 2, 1], [0, 3, 2]],
            ..Mesh::default()
        });
        let prepared = Prepared::new(&coloured_glass(sheet, Transform::IDENTITY)).unwrap();
        let notes = &prepared.report().notes;
        assert!(notes.iter().all(|note| !note.what.contains("inside out")), "{notes:?}");
    }
}

/// Every flat or solid shape that is mirrored, sheared or turned shines on the side it shone on.
#[test]
fn lamps_keep_their_lit_side_through_any_transform() {
    let triangle = Mesh {
        positions: vec![
            Vec3::new(-1.0, -1.0, 0.0),
            Vec3::new(1.0, -1.0, 0.0),
            Vec3::new(0.0, 1.0, 0.0),
        ],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    let shapes = [
        Shape::Rectangle { size: Vec2::splat(1.5) },
        Shape::Disk { radius: 0.8 },
        Shape::Mesh(MeshId(0)),
        Shape::Box { size: Vec3::ONE },
    ];
    let maps = [
        Transform::IDENTITY,
        Transform::scale(Vec3::new(-1.0, 1.0, 1.0)),
        Transform::scale(Vec3::new(1.0, -2.0, 0.5)),
        Transform::scale(Vec3::new(-1.0, -1.0, 1.0)),
    ];
    for shape in &shapes {
        for map in &maps {
            let mut scene = scene();
            scene.add_mesh(triangle.clone());
            let lamp = scene.add_material(Emission::radiance(Rgb::WHITE));
            scene.objects.push(Object::new(shape.clone(), lamp).transformed(map));
            let prepared = Prepared::new(&scene).unwrap();
            for (from, lit) in
                [(Vec3::new(0.1, 0.1, 5.0), true), (Vec3::new(0.1, 0.1, -5.0), false)]
            {
                let direction = Vec3::new(0.0, 0.0, -from.z.signum());
                let hit = prepared.closest(&Ray::new(from, direction)).expect("the lamp is there");
                let at = prepared.interaction(&hit, direction);
                let emitter = &prepared.emitters()[at.emitter.expect("it is a lamp") as usize];
                let seen = !emitter
                    .glow()
                    .expect("a glowing surface")
                    .towards(at.wo, at.normal)
                    .is_black();
                let lit = lit || matches!(shape, Shape::Box { .. });
                assert_eq!(seen, lit, "{shape:?} seen from {from} under {map:?}");
                let sampled = emitter.sample(from, Vec2::splat(0.3)).is_some();
                assert_eq!(sampled, lit, "{shape:?} sampled from {from} under {map:?}");
            }
        }
    }
}

/// Triangles that are no numbers, or have no area, are left out and counted; all others stay as
/// they are, and lamps among them give finite light.
#[test]
fn broken_triangles_are_left_out_and_counted() {
    let mut mesh = cube();
    mesh.positions.extend([Vec3::NAN, Vec3::INFINITY, Vec3::splat(0.5)]);
    mesh.triangles.extend([[0, 1, 8], [9, 2, 3], [4, 4, 5], [7, 10, 7]]);
    let mut scene = scene();
    let glow = rutilant::material::EmittedLight::Power(Rgb::grey(6.0));
    let lamp = scene.add_material(Emission { light: glow, ..Emission::radiance(Rgb::WHITE) });
    let id = scene.add_mesh(mesh);
    scene.objects.push(Object::new(Shape::Mesh(id), lamp));
    let prepared = Prepared::new(&scene).unwrap();
    assert_eq!(prepared.report().bvh.left_out.count, 4);
    let notes = &prepared.report().notes;
    assert!(
        notes.iter().any(|n| n.what.starts_with("4 of the surfaces are left out")),
        "{notes:?}"
    );
    // 6 W over 6 m² of front: 1/π of radiance.
    let image = render(&scene, rutilant::settings::Settings { max_depth: Some(1), ..small(16) });
    let brightest = image.channel("R").unwrap().iter().copied().fold(0.0, f32::max);
    assert!((brightest - std::f32::consts::FRAC_1_PI).abs() < 1e-4, "{brightest}");
}

/// Vertex normals are interpolated; where a file's normals point inwards, the winding decides.
#[test]
fn normals_are_interpolated_on_the_front() {
    for sign in [1.0, -1.0] {
        let mut scene = scene();
        let matte = scene.add_material(Matte::new(Rgb::grey(0.5)));
        let lean = 0.3;
        let mesh = scene.add_mesh(Mesh {
            positions: vec![
                Vec3::new(-1.0, -1.0, 0.0),
                Vec3::new(1.0, -1.0, 0.0),
                Vec3::new(0.0, 1.0, 0.0),
            ],
            normals: vec![
                Vec3::new(-lean, 0.0, 1.0) * sign * 7.0,
                Vec3::new(lean, 0.0, 1.0) * sign,
                Vec3::new(0.0, lean, 1.0) * sign * 0.1,
            ],
            uvs: vec![Vec2::ZERO, Vec2::new(4.0, 0.0), Vec2::new(2.0, 8.0)],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        });
        scene.objects.push(Object::new(Shape::Mesh(mesh), matte));
        let prepared = Prepared::new(&scene).unwrap();
        let look = |x: f32, y: f32| {
            let ray = Ray::new(Vec3::new(x, y, 3.0), Vec3::NEG_Z);
            let hit = prepared.closest(&ray).unwrap();
            (prepared.interaction(&hit, ray.direction), prepared.uv(&hit))
        };
        let (middle, uv) = look(0.0, -1.0 / 3.0);
        let n = 1.0 / (1.0_f32 + lean * lean).sqrt();
        let expected = Vec3::new(0.0, lean * n / 3.0, n).normalize();
        assert!((middle.shading.z - expected).length() < 1e-5, "{:?}", middle.shading.z);
        assert!((uv - Vec2::new(2.0, 8.0 / 3.0)).length() < 1e-5, "{uv}");
        assert!((look(-0.999, -0.9999).0.shading.z - Vec3::new(-lean * n, 0.0, n)).length() < 1e-2);
    }
}

/// A mesh without texture coordinates has its triangles' own.
#[test]
fn texture_coordinates_are_computed_where_absent() {
    let mut scene = scene();
    let matte = scene.add_material(Matte::new(Rgb::grey(0.5)));
    let mesh = scene.add_mesh(cube());
    scene.objects.push(Object::new(Shape::Mesh(mesh), matte));
    let prepared = Prepared::new(&scene).unwrap();
    let hit = prepared.closest(&Ray::new(Vec3::new(0.2, 0.1, 3.0), Vec3::NEG_Z)).unwrap();
    let uv = prepared.uv(&hit);
    assert!(uv.x >= 0.0 && uv.y >= 0.0 && uv.x + uv.y <= 1.0, "{uv}");
}

/// What cannot be rendered is refused, with the part and the key that are to blame.
#[test]
fn unsound_scenes_are_refused_by_name() {
    let refused = |change: &dyn Fn(&mut Scene)| {
        let mut scene = scene();
        let matte = scene.add_material(Matte::new(Rgb::grey(0.5)));
        scene.objects.push(Object::new(Shape::Sphere { radius: 1.0 }, matte));
        change(&mut scene);
        Prepared::new(&scene).map(|_| ()).unwrap_err().to_string()
    };
    let matte = |albedo| Matte::new(Rgb::grey(albedo));
    assert_eq!(
        refused(&|s| s.materials[0] = matte(1.7).into()),
        "material 0: albedo is 1.7, but must lie between 0 and 1"
    );
    assert_eq!(
        refused(&|s| s.materials[0] = matte(f32::NAN).into()),
        "material 0: albedo is NaN, but must be a finite number"
    );
    assert_eq!(
        refused(&|s| s.objects[0].shape = Shape::Sphere { radius: 0.0 }),
        "object 0: radius is 0, but must be more than 0"
    );
    assert!(refused(&|s| s.objects[0].shape = Shape::Mesh(MeshId(3))).contains("no mesh number 3"));
    assert!(
        refused(&|s| s.objects[0].world_from_object = Transform::scale(Vec3::new(1.0, 2.0, 1.0)))
            .contains("same scale")
    );
    assert!(
        refused(&|s| s.objects[0].world_from_object = Transform::scale(Vec3::new(1.0, 0.0, 1.0)))
            .contains("flattens")
    );
}

/// A scene in the dark says so, and so does a lamp that has no area to shine from.
#[test]
fn darkness_is_announced() {
    let mut scene = scene();
    let power = rutilant::material::EmittedLight::Power(Rgb::WHITE);
    let lamp = scene.add_material(Emission { light: power, ..Emission::radiance(Rgb::WHITE) });
    scene.objects.push(Object::new(Shape::Sphere { radius: 1e-30 }, lamp));
    let notes = Prepared::new(&scene).unwrap().report().notes.clone();
    let lamp = "object 0: a lamp of 1.257e-59 m² that gives no light";
    assert!(notes.iter().any(|n| n.to_string().starts_with(lamp)), "{notes:?}");
    assert!(notes.iter().any(|n| n.what.starts_with("nothing gives light")), "{notes:?}");
}

/// Where rays alone look for light, lights that no ray can meet are missed, which is said: a
/// picture once was black without a word.
#[test]
fn lights_that_rays_never_meet_are_announced() {
    let mut scene = scene();
    let direction = Vec3::NEG_Y;
    scene.lights.push(Light::Directional { direction, irradiance: Rgb::WHITE, group: None });
    let notes = |scene: &Scene, integrator, strategy| {
        let settings = Settings { integrator, strategy, ..Settings::default() };
        Prepared::new(scene).unwrap().notes_for(&settings)
    };
    let (naive, path) = (IntegratorKind::Naive, IntegratorKind::Path);
    let [black] = &notes(&scene, naive, Strategy::Both)[..] else { panic!("one note") };
    assert!(black.what.contains("\"naive\"") && black.what.contains("will be black"), "{black}");
    let [black] = &notes(&scene, path, Strategy::BsdfOnly)[..] else { panic!("one note") };
    assert!(black.what.contains("\"bsdf\"") && black.what.contains("will be black"), "{black}");
    assert_eq!(notes(&scene, path, Strategy::Both), []);
    assert_eq!(notes(&scene, IntegratorKind::Direct, Strategy::BsdfOnly), []);

    scene.environment = Some(Environment::constant(Rgb::WHITE));
    let [less] = &notes(&scene, naive, Strategy::Both)[..] else { panic!("one note") };
    assert!(less.what.contains("give no light here"), "{less}");
    scene.lights.clear();
    assert_eq!(notes(&scene, naive, Strategy::Both), []);
}

/// Glass of two materials is two objects, each of them open; wound inside out together, both are
/// turned. Otherwise the camera would be taken to stand in glass, and the whole picture be black.
#[test]
fn glass_of_several_materials_is_turned_as_one() {
    let mut scene = scene();
    let whole = inside_out(cube());
    for half in [0..6, 6..12] {
        let mesh = Mesh { triangles: whole.triangles[half].to_vec(), ..whole.clone() };
        let mesh = scene.add_mesh(mesh);
        let glass = scene.add_material(Dielectric::new(1.5));
        scene.objects.push(Object::new(Shape::Mesh(mesh), glass));
    }
    let prepared = Prepared::new(&scene).unwrap();
    let turned = prepared.report().notes.iter().filter(|n| n.what.contains("inside out")).count();
    assert_eq!(turned, 2, "{:?}", prepared.report().notes);
    let seen = Ray::new(Vec3::new(0.1, 0.2, 5.0), Vec3::NEG_Z);
    assert!(prepared.closest(&seen).unwrap().normal.z > 0.0);

    // An open sheet is believed: half of the faces alone.
    scene.objects.pop();
    assert!(
        Prepared::new(&scene)
            .unwrap()
            .report()
            .notes
            .iter()
            .all(|n| !n.what.contains("inside out"))
    );
}

/// A lamp shines at any scale: areas of 1e-24 m² and of 1e24 m² are areas.
#[test]
fn lamps_of_any_size_shine() {
    for size in [1e-12_f32, 1e-6, 1.0, 1e6, 1e12] {
        for shape in [
            Shape::Rectangle { size: Vec2::splat(size) },
            Shape::Disk { radius: size },
            Shape::Box { size: Vec3::splat(size) },
            Shape::Sphere { radius: size },
        ] {
            let mut scene = scene();
            let lamp = scene.add_material(Emission::radiance(Rgb::WHITE));
            scene.objects.push(Object::new(shape.clone(), lamp));
            let prepared = Prepared::new(&scene).unwrap();
            assert!(!prepared.emitters().is_empty(), "{size:e} {shape:?}");
            assert_eq!(prepared.report().notes, [], "{size:e} {shape:?}");
        }
    }
}

/// An edited scene looks, bit by bit, as if it had been made traceable anew: with another material,
/// a lamp more, another camera, a body moved.
#[test]
fn an_edited_scene_looks_as_if_it_were_new() {
    let mut scene = coloured_glass(cube(), Transform::rotate(Vec3::Y, 0.4));
    let mut prepared = Prepared::new(&scene).unwrap();
    let edits: [fn(&mut Scene); 4] = [
        |scene| scene.materials[0] = Matte::new(Rgb::new(0.2, 0.7, 0.4)).into(),
        |scene| {
            let lamp = scene.add_material(Emission::radiance(Rgb::grey(4.0)));
            scene.objects[0].material = lamp;
        },
        |scene| {
            scene.camera = Perspective::look_at(Vec3::ONE * 3.0, Vec3::ZERO, 0.6).unwrap().into();
        },
        |scene| scene.objects[0].world_from_object = Transform::translate(Vec3::X * 0.3),
    ];
    for edit in edits {
        edit(&mut scene);
        prepared = prepared.edited(&scene).unwrap();
        let looks = render_prepared(prepared.clone(), small(4));
        assert_eq!(looks.hash(), render(&scene, small(4)).hash());
    }
}

/// Texture coordinates that a mesh has not, bumps on a sphere and on parts of a mix: told, once each,
/// and nothing about those that have what is asked for.
#[test]
fn what_shapes_lack_is_told() {
    let mut scene = scene();
    scene.environment = Some(Environment::constant(Rgb::WHITE));
    let bitmap = scene.add_bitmap(Bitmap::solid([9; 4]));
    let mut image = ImageTexture::new(bitmap);
    let plain = scene.add_texture(image);
    image.mapping.set = 1;
    let second = scene.add_texture(image);
    let albedo = |texture| ColorInput { texture: Some(texture), ..Rgb::WHITE.into() };
    let asks = scene.add_material(Matte::new(albedo(second)));
    let map = NormalMap { texture: plain, scale: 1.0, shows: Bumps::Normals };
    let bumpy = Material { normal_map: Some(map), ..Matte::new(albedo(plain)).into() };
    let bumpy = scene.add_material(bumpy);
    let half = scene.add_material(Mix { first: bumpy, second: asks, amount: 0.5 });
    let without = scene.add_mesh(cube());
    let two_sets = Mesh { uvs: vec![Vec2::ZERO; 8], more_uvs: vec![vec![Vec2::ONE; 8]], ..cube() };
    let (two_sets, one_set) =
        (scene.add_mesh(two_sets), scene.add_mesh(Mesh { uvs: vec![Vec2::ZERO; 8], ..cube() }));
    let notes = |shapes: &[(Shape, MaterialId)]| {
        let mut scene = scene.clone();
        let objects = shapes.iter().map(|(shape, material)| Object::new(shape.clone(), *material));
        scene.objects.extend(objects);
        let prepared = Prepared::new(&scene).expect("a scene");
        prepared.report().notes.iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    let sphere = Shape::Sphere { radius: 1.0 };
    let of_mix = "material 2: bumps of the parts of a mix are not shown: it has its own normal_map";
    assert_eq!(notes(&[(Shape::Mesh(two_sets), asks), (Shape::Mesh(one_set), bumpy)]), [of_mix]);
    let none = [(Shape::Mesh(without), asks), (Shape::Mesh(without), half)];
    let [_, first, second] = &notes(&none)[..] else { panic!("three notes") };
    assert!(first.starts_with("material 0: a mesh has no texture coordinates"), "{first}");
    assert!(second.starts_with("material 2: a mesh has no texture coordinates"), "{second}");
    let twice = [(Shape::Mesh(one_set), asks), (sphere.clone(), asks), (sphere.clone(), bumpy)];
    assert_eq!(
        notes(&[&twice[..], &twice[..]].concat()),
        [
            of_mix,
            "material 0: set 1 of texture coordinates is missing on a shape, whose first is taken",
            "material 1: spheres, disks and custom shapes are shown without its bumps",
        ]
    );
}
