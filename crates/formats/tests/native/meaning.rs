//! A scene in the native format means what its documentation says.

use crate::{HEAD, documented_example, parse};
use rutilant::bsdf::Fresnel;
use rutilant::camera::{Camera, Lens};
use rutilant::color::Rgb;
use rutilant::display::{Curve, Display};
use rutilant::film::Filter;
use rutilant::light::{EnvironmentLight, Light, LightGroup, SpotLight};
use rutilant::material::{
    Absorption, EmittedLight, HemisphereSampling, MaterialKind, Matte, Metal, Principled,
};
use rutilant::scene::{MaterialId, Scene};
use rutilant::settings::{
    Crop, Heuristic, IntegratorKind, LightSelection, Roulette, SamplerKind, Settings, Strategy,
};
use rutilant::shape::Shape;
use rutilant_formats::LoadedScene;
use rutilant_geom::{Vec2, Vec3};

/// What stands after [`HEAD`], read.
fn read(text: &str) -> LoadedScene {
    parse(&format!("{HEAD}{text}")).expect(text)
}

fn near(a: Vec3, b: [f32; 3]) -> bool {
    a.distance(Vec3::from(b)) < 1e-5
}

/// Where the origin and the tips of the axes of the first object go.
fn corners(scene: &Scene) -> [Vec3; 4] {
    let transform = scene.objects[0].world_from_object;
    [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z].map(|p| transform.point(p))
}

/// The documentation's example uses most keys; each must arrive where it belongs.
#[test]
fn the_documented_example_means_what_it_says() {
    let LoadedScene { scene, settings, display, notes, .. } =
        parse(documented_example()).expect("a scene");
    assert_eq!(notes, [] as [&str; 0]);
    assert_eq!(display, Display { exposure: 0.5, curve: Curve::Filmic });
    let expected = Settings {
        size: [640, 480],
        spp: 256,
        max_depth: Some(16),
        seed: 7,
        filter: Filter::Gaussian { radius: 1.5, sigma: 0.5 },
        ..Settings::default()
    };
    assert_eq!(settings, expected);

    let Camera::Perspective(camera) = scene.camera else { panic!("{:?}", scene.camera) };
    assert!(near(camera.world_from_camera.translation(), [0.0, 1.2, 4.0]));
    assert_eq!(camera.fov_y, 35_f32.to_radians());
    // Half of 24 mm over tan 17.5° is 38.06 mm; a quarter of that is the lens, half again its radius.
    assert!(
        (camera.lens.aperture_radius - 0.038_06 / 8.0).abs() < 1e-6,
        "{}",
        camera.lens.aperture_radius
    );
    assert_eq!((camera.lens.blades, camera.lens.aperture_ratio), (7, 1.0));
    // (0, -0.7, -3.5) projected on (0, -0.7, -4) / √16.49.
    assert!((camera.lens.focus_distance - 14.49 / 16.49_f32.sqrt()).abs() < 1e-5);

    let sky = scene.environment.expect("a sky");
    let EnvironmentLight::Constant(Rgb([r, g, b])) = sky.light else { panic!("{sky:?}") };
    assert!(
        (r - 0.502_886).abs() < 1e-5
            && (g - 0.658_375).abs() < 1e-5
            && (b - 0.854_993).abs() < 1e-5
    );
    assert_eq!((sky.scale, sky.rotation), (0.5, 0.0));

    let names: Vec<_> = scene.materials.iter().map(|m| &*m.name).collect();
    assert_eq!(names, ["floor", "varnish", "red", "coat", "gold", "bottle", "lamp", "embers"]);
    let MaterialKind::Mix(mix) = scene.materials[1].kind else { panic!("no mix") };
    assert_eq!((mix.first, mix.second, mix.amount), (MaterialId(2), MaterialId(3), 0.1));
    let MaterialKind::Dielectric(bottle) = scene.materials[5].kind else { panic!("no glass") };
    assert_eq!((bottle.interior.ior, bottle.exterior.ior), (1.52, 1.0));
    assert_eq!((bottle.fresnel, bottle.priority), (Fresnel::Exact, None));
    assert_eq!(
        bottle.interior.absorption,
        Absorption::ColorAtDistance { color: Rgb::new(0.3, 0.8, 0.4), distance: 0.1 }
    );
    let lamp = scene.materials[6].emission.expect("light");
    assert_eq!(lamp.light, EmittedLight::Power(Rgb::new(60.0, 55.0, 45.0)));
    assert!(!lamp.two_sided);
    let embers = scene.materials[7].emission.expect("light");
    assert_eq!(embers.light, EmittedLight::Radiance(Rgb::new(3.0, 0.6, 0.1)));
    assert!(embers.two_sided);

    assert_eq!(scene.objects.len(), 5);
    let floor = &scene.objects[0];
    assert_eq!(
        (floor.shape.clone(), floor.material),
        (Shape::Rectangle { size: [10.0; 2].into() }, MaterialId(0))
    );
    assert!(near(floor.world_from_object.normal(Vec3::Z), [0.0, 1.0, 0.0]));
    let lamp = &scene.objects[3];
    assert!(near(lamp.world_from_object.normal(Vec3::Z), [0.0, -1.0, 0.0]));
    // The pyramid is 1 high and 2 wide; fitted it is 0.5 high.
    let pyramid = &scene.objects[4].world_from_object;
    assert!(near(pyramid.point(Vec3::Y), [0.0, 0.5, 1.0]));
    assert!(near(pyramid.point(Vec3::new(1.0, 0.0, 1.0)), [0.5, 0.0, 1.5]));
    let Light::Directional { irradiance, .. } = scene.lights[0] else { panic!("no sun") };
    assert_eq!(irradiance, Rgb::grey(1.5));
    let Light::Spot { light, direction, .. } = scene.lights[1] else { panic!("no spot") };
    assert_eq!(light, SpotLight::Power(Rgb::grey(40.0)));
    assert!(near(direction, [1.3, -2.5, -2.0]));
}

/// What is not said has the documented default.
#[test]
fn an_almost_empty_scene_has_the_defaults() {
    let LoadedScene { scene, settings, display, notes, .. } =
        parse("version = 1\n[camera]\nposition = [0, 0, 5]\nlook_at = [0, 0, 0]").expect("a scene");
    assert_eq!(settings, Settings::default());
    assert_eq!(display, Display { exposure: 0.0, curve: Curve::Clip });
    let Camera::Perspective(camera) = scene.camera else { panic!("{:?}", scene.camera) };
    assert_eq!(camera.fov_y, 45_f32.to_radians());
    assert_eq!((camera.lens.aperture_radius, camera.lens.focus_distance), (0.0, 5.0));
    assert!(scene.environment.is_none() && scene.objects.is_empty() && notes.is_empty());
}

/// Cameras of every type, with lenses as photographers describe them.
#[test]
fn cameras_have_types_and_lenses() {
    let camera = |lines: &str| {
        let head = "version = 1\nrender.size = [640, 480]\n[camera]\nposition = [0, 0, 5]\nlook_at = [0, 0, 0]\n";
        parse(&format!("{head}{lines}")).expect(lines).scene.camera
    };
    let perspective = |lines: &str| match camera(lines) {
        Camera::Perspective(camera) => camera,
        other => panic!("{other:?}"),
    };
    // The report's camera: tan of half the angle is a half.
    assert!((perspective("fov_degrees = 53.13").fov_y - 2.0 * 0.5_f32.atan()).abs() < 1e-5);
    // 24 mm of film, and 15.6 mm of a smaller sensor, behind 50 mm.
    for (sensor, height) in [("", 24.0_f32), ("\nsensor_height_mm = 15.6", 15.6)] {
        let camera = perspective(&format!("focal_length_mm = 50\nf_number = 2{sensor}"));
        assert!((camera.fov_y - 2.0 * (0.5 * height / 50.0).atan()).abs() < 1e-6, "{camera:?}");
        assert!((camera.lens.aperture_radius - 0.0125).abs() < 1e-7, "{camera:?}");
    }
    let lens = "aperture_radius = 0.1\nblades = 6\nblade_rotation_degrees = 90\naperture_ratio = 2\nfocus_on = [639, 0]";
    let expected = Lens {
        aperture_radius: 0.1,
        focus_distance: 5.0,
        focus_on: Some(Vec2::new(639.5 / 640.0, 0.5 / 480.0)),
        blades: 6,
        blade_rotation: std::f32::consts::FRAC_PI_2,
        aperture_ratio: 2.0,
    };
    assert_eq!(perspective(lens).lens, expected);
    match camera(&format!("type = \"orthographic\"\nheight = 3\n{lens}")) {
        Camera::Orthographic(camera) => assert_eq!((camera.height, camera.lens), (3.0, expected)),
        other => panic!("{other:?}"),
    }
    assert!(matches!(camera("type = \"equirectangular\""), Camera::Equirectangular(_)));
}

/// Everything that shines can be of a group; what names none is of none.
#[test]
fn lights_are_of_groups() {
    let group = |name: &str| LightGroup::new(name).ok();
    let scene = read(
        "[environment]\ncolor = 1\ngroup = \"sky\"\n\
         [[material]]\nname = \"lamp\"\ntype = \"emissive\"\nradiance = 1\ngroup = \"key\"\n\
         [[material]]\nname = \"ember\"\ntype = \"matte\"\n\
         emission = { power = 1, group = \"Fill_2\" }\n\
         [[material]]\nname = \"plain\"\ntype = \"emissive\"\nradiance = 1\n\
         [[light]]\ntype = \"point\"\nposition = [0, 1, 0]\nintensity = 1\ngroup = \"a\"\n\
         [[light]]\ntype = \"spot\"\nposition = [0, 1, 0]\ndirection = [0, -1, 0]\npower = 1\n\
         group = \"b-2\"\n\
         [[light]]\ntype = \"directional\"\ndirection = [0, -1, 0]\nirradiance = 1\ngroup = \"a\"\n\
         [[light]]\ntype = \"point\"\nposition = [0, 1, 0]\nintensity = 1\n\
         [[shape]]\ntype = \"disk\"\nradius = 1\nmaterial = \"lamp\"\ngroup = \"own\"\n\
         instances = [{ translate = [1, 0, 0] }, { translate = [2, 0, 0] }]\n\
         [[shape]]\ntype = \"mesh\"\nmaterial = \"lamp\"\ngroup = \"own\"\n\
         positions = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\ntriangles = [[0, 1, 2]]\n\
         [[shape]]\ntype = \"disk\"\nradius = 1\nmaterial = \"lamp\"",
    )
    .scene;
    assert_eq!(scene.environment.and_then(|sky| sky.group), group("sky"));
    let emissions = scene.materials.iter().filter_map(|material| material.emission);
    let emissions: Vec<_> = emissions.map(|emission| emission.group).collect();
    assert!(emissions.ends_with(&[group("key"), group("Fill_2"), None]), "{emissions:?}");
    let lights: Vec<_> = scene.lights.iter().map(Light::group).collect();
    assert_eq!(lights, [group("a"), group("b-2"), group("a"), None]);
    let objects: Vec<_> = scene.objects.iter().map(|object| object.group).collect();
    assert_eq!(objects, [group("own"), group("own"), group("own"), None]);
}

/// Spots shine where they are told, into the cones of glTF where none are given.
#[test]
fn spots_have_cones() {
    let spot = |lines: &str| {
        let text = format!("[[light]]\ntype = \"spot\"\nposition = [1, 2, 3]\n{lines}");
        read(&text).scene.lights[0]
    };
    let expected = |direction: [f32; 3], light, degrees: [f32; 2]| {
        let [inner, outer] = degrees.map(f32::to_radians);
        let (position, direction) = (Vec3::new(1.0, 2.0, 3.0), direction.into());
        Light::Spot { position, direction, light, inner, outer, group: None }
    };
    assert_eq!(
        spot("look_at = [1, 0, 3]\nintensity = [1, 2, 3]"),
        expected([0.0, -2.0, 0.0], SpotLight::Intensity(Rgb::new(1.0, 2.0, 3.0)), [0.0, 45.0])
    );
    assert_eq!(
        spot("direction = [1, 0, 3]\npower = 5\nouter_degrees = 30\ninner_degrees = 20"),
        expected([1.0, 0.0, 3.0], SpotLight::Power(Rgb::grey(5.0)), [20.0, 30.0])
    );
}

/// Every name of every setting.
#[test]
fn settings_have_names() {
    let get = |line: &str| read(&format!("[render]\nmax_depth = 5\n{line}")).settings;
    for (name, kind) in [
        ("path", IntegratorKind::Path),
        ("naive", IntegratorKind::Naive),
        ("direct", IntegratorKind::Direct),
        ("ao", IntegratorKind::AmbientOcclusion),
        ("normals", IntegratorKind::Normals),
        ("albedo", IntegratorKind::Albedo),
        ("depth", IntegratorKind::Depth),
    ] {
        assert_eq!(get(&format!("integrator = \"{name}\"")).integrator, kind);
    }
    for (line, filter) in [
        ("filter = \"box\"", Filter::Box { radius: 0.5 }),
        ("filter = \"tent\"\nfilter_radius = 2", Filter::Tent { radius: 2.0 }),
        ("filter = \"gaussian\"\nfilter_sigma = 1", Filter::Gaussian { radius: 1.5, sigma: 1.0 }),
        (
            "filter = \"mitchell\"\nfilter_bc = [0, 1]",
            Filter::Mitchell { radius: 2.0, b: 0.0, c: 1.0 },
        ),
        ("filter_radius = 3", Filter::BlackmanHarris { radius: 3.0 }),
    ] {
        assert_eq!(get(line).filter, filter);
    }
    for (name, curve) in [
        ("clip", Curve::Clip),
        ("filmic", Curve::Filmic),
        ("reinhard", Curve::Reinhard),
        ("aces", Curve::Aces),
        ("agx", Curve::Agx),
    ] {
        let text = format!("[render]\ncurve = \"{name}\"");
        assert_eq!(read(&text).display.curve, curve);
    }
    assert_eq!(get("sampler = \"independent\"").sampler, SamplerKind::Independent);
    assert_eq!(get("strategy = \"light\"").strategy, Strategy::LightOnly);
    assert_eq!(get("strategy = \"bsdf\"").strategy, Strategy::BsdfOnly);
    assert_eq!(get("heuristic = \"balance\"").heuristic, Heuristic::Balance);
    assert_eq!(get("heuristic = \"optimal\"").heuristic, Heuristic::Optimal);
    assert_eq!(get("roulette = \"albedo\"").roulette, Roulette::Albedo);
    assert_eq!(get("roulette = \"off\"").roulette, Roulette::Off);
    for (name, selection) in [
        ("auto", LightSelection::Auto),
        ("tree", LightSelection::Tree),
        ("power", LightSelection::Power),
        ("uniform", LightSelection::Uniform),
    ] {
        let line = format!("light_selection = \"{name}\"");
        assert_eq!(get(&line).light_selection, selection);
    }
    assert_eq!(get("").light_selection, LightSelection::Auto);
    assert_eq!(get("seed = 0xffff_ffff_ffff_ffff").seed, u64::MAX);
    assert_eq!(
        get("size = [64, 32]\ncrop = [1, 2, 3, 4]").crop,
        Some(Crop { x: 1, y: 2, width: 3, height: 4 })
    );
}

/// Roughness, measured metals and panes arrive where they belong.
#[test]
fn rough_and_thin_materials_mean_what_they_say() {
    let kind = |lines: &str| {
        let text = format!("[[material]]\nname = \"a\"\n{lines}");
        read(&text).scene.materials[1].kind.clone()
    };
    let MaterialKind::Matte(clay) = kind("type = \"matte\"\nroughness = 0.7") else { panic!() };
    assert_eq!((clay.albedo.factor, clay.roughness), (Rgb::grey(0.5), 0.7));
    for (lines, sampling) in [
        ("", HemisphereSampling::Cosine),
        ("sampling = \"cosine\"", HemisphereSampling::Cosine),
        ("sampling = \"uniform\"", HemisphereSampling::Uniform),
    ] {
        let paper = Matte { sampling, ..Matte::new(Rgb::grey(0.5)) };
        assert_eq!(kind(&format!("type = \"matte\"\n{lines}")), MaterialKind::Matte(paper));
    }
    for (name, metal) in [
        ("gold", Metal::Gold),
        ("copper", Metal::Copper),
        ("silver", Metal::Silver),
        ("aluminium", Metal::Aluminium),
    ] {
        let lines = format!("type = \"conductor\"\nmetal = \"{name}\"\nroughness = 0.2");
        assert_eq!(kind(&lines), MaterialKind::Conductor(metal.conductor(0.2)));
    }
    let MaterialKind::Dielectric(ice) = kind("type = \"dielectric\"\nroughness = 0.4") else {
        panic!()
    };
    assert_eq!((ice.interior.ior, ice.roughness), (1.5, 0.4));
    let MaterialKind::ThinDielectric(pane) = kind("type = \"thin-dielectric\"") else { panic!() };
    assert_eq!((pane.ior, pane.color), (1.5, Rgb::WHITE));
    assert_eq!(kind("type = \"null\""), MaterialKind::Null);
}

/// Scale, then rotation, then translation; and about x before y before z.
#[test]
fn transforms_apply_in_the_documented_order() {
    let disk = |lines: &str| {
        let text = format!("[[shape]]\ntype = \"disk\"\nradius = 1\nmaterial = \"grey\"\n{lines}");
        corners(&read(&text).scene)
    };
    let [o, x, y, z] =
        disk("scale = [2, 3, 4]\nrotate_degrees = [0, 0, 90]\ntranslate = [1, 0, 0]");
    assert!(near(o, [1.0, 0.0, 0.0]) && near(x, [1.0, 2.0, 0.0]));
    assert!(near(y, [-2.0, 0.0, 0.0]) && near(z, [1.0, 0.0, 4.0]));
    // About x: y goes to z. Then about y: z goes to x.
    let [_, x, y, z] = disk("rotate_degrees = [90, 90, 0]");
    assert!(near(x, [0.0, 0.0, -1.0]) && near(y, [1.0, 0.0, 0.0]) && near(z, [0.0, -1.0, 0.0]));
    let [_, x, ..] = disk("rotate = { axis = [0, 0, 5], degrees = 90 }");
    assert!(near(x, [0.0, 1.0, 0.0]));
    assert_eq!(disk("center = [1, 2, 3]"), disk("translate = [1, 2, 3]"));
    let rows = "[1, 2, 3, 10], [4, 5, 7, 20], [7, 8, 10, 30]";
    let flat = rows.replace("], [", ", ");
    let matrix = disk(&format!("matrix = [{rows}]"));
    assert!(near(matrix[0], [10.0, 20.0, 30.0]) && near(matrix[1], [11.0, 24.0, 37.0]));
    assert_eq!(matrix, disk(&format!("matrix = [{rows}, [0, 0, 0, 1]]")));
    assert_eq!(matrix, disk(&format!("matrix = {flat}")));
    assert_eq!(matrix, disk(&format!("matrix = {}", flat.replace(']', ", 0, 0, 0, 1]"))));
}

/// A fitted mesh has the size and the place asked for, whatever it had before.
#[test]
fn fitting_gives_size_and_place() {
    let mesh = |fit: &str| {
        let text = format!(
            "[[shape]]\ntype = \"mesh\"\nmaterial = \"grey\"\nfit = {fit}
            positions = [[10, 10, 10], [14, 10, 10], [10, 12, 11]]\ntriangles = [[0, 1, 2]]"
        );
        let scene = read(&text).scene;
        scene.meshes[0]
            .positions
            .iter()
            .map(|p| scene.objects[0].world_from_object.point(*p))
            .collect::<Vec<_>>()
    };
    let longest = mesh("{ size = 1 }");
    assert!(near(longest[0], [-0.5, 0.0, -0.125]) && near(longest[2], [-0.5, 0.5, 0.125]));
    let tall = mesh("{ size = 1, axis = \"y\", on_floor = 2 }");
    assert!(near(tall[1], [1.0, 2.0, -0.25]) && near(tall[2], [-1.0, 3.0, 0.25]));
    let there = mesh("{ center = [0, 1, 0] }");
    assert!(near(there[0], [-2.0, 0.0, -0.5]));
    // A mesh with z up: its y runs into the picture, which is -z, and nothing is mirrored.
    let upright = mesh("{ up = \"z\" }");
    assert!(near(upright[0], [-2.0, 0.0, 1.0]) && near(upright[2], [-2.0, 1.0, -1.0]));
    let tall = mesh("{ up = \"z\", size = 2, axis = \"y\" }");
    assert!(near(tall[1], [4.0, 0.0, 2.0]) && near(tall[2], [-4.0, 2.0, -2.0]));
}

/// A mesh in the scene itself, with everything that it can have.
#[test]
fn inline_meshes_keep_their_arrays() {
    let quad = "[[shape]]\ntype = \"mesh\"\nmaterial = \"grey\"
        positions = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
        triangles = [[0, 1, 2], [0, 2, 3]]\n";
    let full = read(&format!(
        "{quad}normals = [[0, 0, 1], [0, 0, 1], [0, 0, 1], [0, 0, 2]]
        uvs = [[0, 0], [1, 0], [1, 1], [0, 1]]\nsmooth_degrees = 30"
    ));
    let mesh = &full.scene.meshes[0];
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(mesh.positions[2], Vec3::new(1.0, 1.0, 0.0));
    assert_eq!(mesh.uvs[1].to_array(), [1.0, 0.0]);
    assert_eq!(mesh.normals[3], Vec3::new(0.0, 0.0, 2.0), "own normals are kept");
    assert_eq!(full.notes.len(), 1, "and that is said: {:?}", full.notes);
    let smooth = read(&format!("{quad}smooth_degrees = 30"));
    assert_eq!(smooth.scene.meshes[0].normals, [Vec3::Z; 4]);
    assert_eq!(read(quad).scene.meshes[0].normals, []);
}

/// Tables can be written in any way that TOML knows.
#[test]
fn toml_has_many_spellings() {
    let inline = parse(
        "version = 1\ncamera = { position = [0, 0, 5], look_at = [0, 0, 0] }
        material = [{ name = \"grey\", type = \"matte\" }]",
    );
    let dotted = parse(HEAD);
    let windows = parse(&format!("\u{feff}{}", HEAD.replace('\n', "\r\n")));
    for scene in [inline, dotted, windows] {
        assert_eq!(scene.expect("a scene").scene.materials[0].name, "grey");
    }
    let emission =
        read("[[material]]\nname = \"a\"\ntype = \"black\"\n[material.emission]\nradiance = 1");
    assert!(emission.scene.materials[1].emission.is_some());
}

/// Zero has a sign, numbers have digits without end, and columns count characters.
#[test]
fn odd_texts_keep_their_meaning() {
    let exposure = |number: &str| read(&format!("[render]\nexposure = {number}")).display.exposure;
    assert_eq!(exposure("-0.0"), 0.0);
    assert_eq!(exposure("1e-999"), 0.0);
    assert_eq!(exposure("0x10"), 16.0);
    assert_eq!(exposure("1_000"), 1000.0);
    assert_eq!(exposure(&format!("1{}", "0".repeat(30))), 1e30);
    assert_eq!(exposure(&format!("0.{}1", "0".repeat(100_000))), 0.0);
    for (text, place) in [
        ("\u{feff}verson = 1", "1:1"),
        ("version = 1\r\n[rendr]", "2:2"),
        ("version = 1 # ä\n\"ä\" = { \"ö\" = 1, \"ü\" = 2 } x", "2:28"),
    ] {
        let error = parse(text).expect_err(text).to_string();
        assert!(error.starts_with(&format!("scene.toml:{place}: ")), "{error}");
    }
}

/// Without a camera there is one that sees everything, and a note says so.
#[test]
fn a_missing_camera_is_chosen() {
    let scene = |size: &str| {
        parse(&format!(
            "version = 1\nrender.size = {size}
            material = [{{ name = \"grey\", type = \"matte\" }}]
            [[shape]]\ntype = \"box\"\nsize = [2, 8, 2]\ncenter = [100, 0, 0]\nmaterial = \"grey\""
        ))
        .expect("a scene")
    };
    for size in ["[400, 300]", "[300, 400]"] {
        let LoadedScene { scene, settings, notes, .. } = scene(size);
        assert_eq!(notes.len(), 1, "{notes:?}");
        let Camera::Perspective(camera) = scene.camera else { panic!("{:?}", scene.camera) };
        let camera_from_world = camera.world_from_camera.inverse().expect("a pose");
        let half_height = (0.5 * camera.fov_y).tan();
        let half_width = half_height * settings.size[0] as f32 / settings.size[1] as f32;
        let mut most = 0.0_f32;
        for i in 0..8 {
            let corner = Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) - 0.5;
            let corner = Vec3::new(100.0, 0.0, 0.0) + corner * Vec3::new(2.0, 8.0, 2.0);
            let seen = camera_from_world.point(corner);
            most = most.max(seen.x.abs() / (half_width * -seen.z));
            most = most.max(seen.y.abs() / (half_height * -seen.z));
        }
        assert!((0.5..1.0).contains(&most), "{size}: {most}");
    }
}

/// What a mix leaves out is said.
#[test]
fn lost_emission_is_noted() {
    let text = "[[material]]\nname = \"lamp\"\ntype = \"emissive\"\nradiance = 1
        [[material]]\nname = \"both\"\ntype = \"mix\"\nfirst = \"grey\"\nsecond = \"lamp\"";
    let notes = read(text).notes;
    assert_eq!(notes.len(), 1);
    assert!(notes[0].contains("\"both\" does not glow as its part \"lamp\" does"), "{notes:?}");
}

/// Priorities are whole numbers, the largest that is documented among them, and 0 is one.
#[test]
fn priorities_are_numbers_and_none_is_none() {
    for (line, expected) in
        [("", None), ("priority = 0", Some(0)), ("priority = 4294967295", Some(u32::MAX))]
    {
        let loaded = read(&format!("[[material]]\nname = \"a\"\ntype = \"dielectric\"\n{line}"));
        let glass = &loaded.scene.materials.last().expect("a material").kind;
        let MaterialKind::Dielectric(glass) = glass else { panic!("{glass:?}") };
        assert_eq!(glass.priority, expected);
    }
}

/// A direction of any length but 0 points somewhere, even where the square of its length is no
/// number any more; it once became [0, 0, 0].
#[test]
fn directions_have_any_length() {
    let axes = |length: &str, key: &str| {
        let text = match key {
            "up" => format!("camera.up = [{length}, 0, 0]"),
            _ => format!(
                "[[shape]]\ntype = \"disk\"\nradius = 1\nmaterial = \"grey\"\n\
                 rotate = {{ axis = [{length}, 0, 0], degrees = 90 }}"
            ),
        };
        let scene = match key {
            "up" => parse(&HEAD.replacen("camera.look_at", &format!("{text}\ncamera.look_at"), 1)),
            _ => parse(&format!("{HEAD}{text}")),
        };
        let scene = scene.expect(&text).scene;
        match key {
            "up" => {
                let Camera::Perspective(camera) = scene.camera else { panic!("{text}") };
                camera.world_from_camera.vector(Vec3::Y)
            }
            _ => scene.objects[0].world_from_object.vector(Vec3::Z),
        }
    };
    for length in ["1", "1e-30", "1e-44", "1e30", "3e38"] {
        let (up, normal) = (axes(length, "up"), axes(length, "axis"));
        assert!(near(up, [1.0, 0.0, 0.0]), "{length}: {up}");
        assert!(near(normal, [0.0, -1.0, 0.0]), "{length}: {normal}");
    }
}

/// What preparing a scene finds is told with the line that it comes from.
#[test]
fn notes_lead_to_their_lines() {
    let lamp = "[[material]]\nname = \"lamp\"\ntype = \"emissive\"\npower = 1\n\
                [[shape]]\ntype = \"disk\"\nradius = 1e-30\nmaterial = \"lamp\"";
    let loaded = read(lamp);
    let prepared = rutilant::Prepared::new(&loaded.scene).expect("a sound scene");
    let notes = prepared.report().notes.iter();
    let said: Vec<_> = notes.map(|note| loaded.locate(note, "scene.toml".as_ref())).collect();
    assert!(said[0].starts_with("scene.toml:12: a lamp of 3.142e-60 m²"), "{said:?}");
    assert!(said[1].starts_with("scene.toml: nothing gives light"), "{said:?}");
}

/// Every key of a principled material arrives where it belongs, and those that are not there mean
/// what the documentation says.
#[test]
fn principled_materials_mean_what_they_say() {
    let material = |keys: &str| {
        let text = format!("[[material]]\nname = \"a\"\ntype = \"principled\"\n{keys}\n");
        let MaterialKind::Principled(p) = read(&text).scene.materials.remove(1).kind else {
            panic!("{text}")
        };
        *p
    };
    assert_eq!(material(""), Principled::default());
    let expected = Principled {
        base_color: Rgb([0.1, 0.2, 0.3]),
        metallic: 0.11,
        roughness: 0.12,
        diffuse_roughness: 0.13,
        anisotropy: 0.14,
        anisotropy_rotation: 30_f32.to_radians(),
        specular: 0.15,
        specular_color: Rgb::grey(0.16),
        ior: 1.7,
        dispersion: 0.0,
        transmission: 0.18,
        thin_walled: true,
        diffuse_transmission: 0.19,
        diffuse_transmission_color: Rgb::grey(0.2),
        absorption: Absorption::ColorAtDistance { color: Rgb::grey(0.21), distance: 2.0 },
        priority: None,
        coat: 0.22,
        coat_color: Rgb::grey(0.23),
        coat_roughness: 0.24,
        coat_ior: 1.25,
        coat_normal_map: None,
        sheen_color: Rgb::grey(0.26),
        sheen_roughness: 0.27,
        iridescence: 0.28,
        iridescence_ior: 1.29,
        iridescence_thickness_nm: 300.0,
        iridescence_thickness_minimum_nm: 200.0,
        textures: Default::default(),
    };
    let all = "base_color = [0.1, 0.2, 0.3]\nmetallic = 0.11\nroughness = 0.12\n\
               diffuse_roughness = 0.13\nanisotropy = 0.14\nanisotropy_rotation_degrees = 30\n\
               specular = 0.15\nspecular_color = 0.16\nior = 1.7\ntransmission = 0.18\n\
               thin_walled = true\ndiffuse_transmission = 0.19\n\
               diffuse_transmission_color = 0.2\nabsorption_color = 0.21\n\
               absorption_distance = 2\ncoat = 0.22\ncoat_color = 0.23\ncoat_roughness = 0.24\n\
               coat_ior = 1.25\nsheen_color = 0.26\nsheen_roughness = 0.27\niridescence = 0.28\n\
               iridescence_ior = 1.29\niridescence_thickness_nm = 300\niridescence_thickness_minimum_nm = 200";
    assert_eq!(material(all), expected);
    assert_eq!(material("transmission = 1\npriority = 3").priority, Some(3));
    assert_eq!(material("transmission = 1\ndispersion = 0.5").dispersion, 0.5);

    // A lamp's strength is a factor.
    let lamp = read(
        "[[material]]\nname = \"a\"\ntype = \"principled\"\n\
         emission = { radiance = [1, 2, 3], strength = 2 }\n",
    );
    let light = lamp.scene.materials[1].emission.map(|e| e.light);
    assert_eq!(light, Some(EmittedLight::Radiance(Rgb([2.0, 4.0, 6.0]))));
}
