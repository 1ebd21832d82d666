//! Mitsuba's scenes: what they mean by number, and one line for what is wrong with them.

mod common;

use rutilant::Session;
use rutilant::camera::Camera;
use rutilant::color::Rgb;
use rutilant::cryptomatte;
use rutilant::film::Filter;
use rutilant::geom::Vec3;
use rutilant::light::{EnvironmentLight, Light, SpotLight};
use rutilant::material::{EmittedLight, MaterialKind};
use rutilant::scene::Place;
use rutilant::settings::Settings;
use rutilant::shape::Shape;
use rutilant::texture::Texture;
use rutilant_formats::scene::mitsuba::serialized;
use rutilant_formats::{
    CameraChoice, Limits, LoadedScene, ReadOptions, SceneError, image, parse_mitsuba, read_scene,
};
use std::fs;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A sky of two pixels.
const SKY: &[u8] = b"#?RADIANCE\n\n-Y 1 +X 2\n\x80\x80\x80\x81\x20\x40\x60\x84";

fn try_read(body: &str, parameters: &[(String, String)]) -> Result<LoadedScene, SceneError> {
    let text = format!("<scene version=\"3.0.0\">\n{body}\n</scene>");
    let options =
        ReadOptions { embedded: &[("sky.hdr", SKY)], parameters, ..ReadOptions::default() };
    parse_mitsuba(text.as_bytes().to_vec(), Path::new("nowhere/a.xml"), &options)
}

fn read(body: &str) -> LoadedScene {
    try_read(body, &[]).unwrap_or_else(|error| panic!("{error}"))
}

fn refusal(body: &str) -> String {
    let error = try_read(body, &[]).map(|_| ()).expect_err("refused").to_string();
    assert!(!error.contains('\n'));
    error.strip_prefix("nowhere/").unwrap_or(&error).to_owned()
}

const BALL: &str = "<shape type=\"sphere\"/>";

/// Each mistake with its one line: where, what, and what would be right.
#[test]
fn errors_name_the_place() {
    let mut wrong = Vec::new();
    for (body, said) in [
        ("<shape type=\"spere\"/>", "a.xml:2:1: no shape \"spere\"; did you mean \"sphere\"?"),
        (
            "<shape type=\"hair\"/>",
            "a.xml:2:1: shape \"hair\" is not read; there are obj, ply, serialized, rectangle, disk, \
             cube, sphere, cylinder, shapegroup, instance",
        ),
        ("<shape/>", "a.xml:2:1: type is missing"),
        ("<shap type=\"sphere\"/>", "a.xml:2:1: no element \"shap\"; did you mean \"shape\"?"),
        (
            "<shape type=\"sphere\"><float name=\"radius\" value=\"a\"/></shape>",
            "a.xml:2:50: \"a\" is not a number",
        ),
        (
            "<shape type=\"sphere\"><float name=\"radius\" value=\"1e99\"/></shape>",
            "a.xml:2:50: \"1e99\" is not a finite number, or too large for one",
        ),
        (
            "<shape type=\"sphere\"><float name=\"radius\" value=\"-1\"/></shape>",
            "a.xml:2:1: radius is -1, but must be more than 0",
        ),
        (
            "<shape type=\"sphere\"><float nam=\"radius\" value=\"1\"/></shape>",
            "a.xml:2:34: no attribute \"nam\"; did you mean \"name\"?",
        ),
        (
            "<shape type=\"sphere\"><string name=\"radius\" value=\"1\"/></shape>",
            "a.xml:2:22: radius is a string, but must be a number",
        ),
        (
            "<shape type=\"sphere\"><ref id=\"gry\"/></shape><bsdf type=\"diffuse\" id=\"grey\"/>",
            "a.xml:2:22: no object with the id \"gry\"; did you mean \"grey\"?",
        ),
        (
            "<bsdf type=\"diffuse\" id=\"a\"/><bsdf type=\"null\" id=\"a\"/>",
            "a.xml:2:30: there is another object with the id \"a\"",
        ),
        (
            "<shape type=\"sphere\"><bsdf type=\"diffuse\"><rgb name=\"reflectance\" \
             value=\"1.5\"/></bsdf></shape>",
            "a.xml:2:22: albedo is 1.5, but must lie between 0 and 1",
        ),
        (
            "<shape type=\"sphere\"><bsdf type=\"dielectric\"><string name=\"int_ior\" \
             value=\"wather\"/></bsdf></shape>",
            "a.xml:2:46: no medium \"wather\"; did you mean \"water\"?",
        ),
        (
            "<shape type=\"sphere\"><bsdf type=\"conductor\"><string name=\"material\" \
             value=\"Xx\"/></bsdf></shape>",
            "a.xml:2:45: the metal \"Xx\" is not known here; there are Au, Cu, Ag, Al, CuZn, MgO, TiO2, or give its eta \
             and k",
        ),
        (
            "<shape type=\"obj\"><string name=\"filename\" value=\"a.obj\"/></shape>",
            "a.xml:2:19: there is no file \"a.obj\" beside the scene",
        ),
        (
            "<shape type=\"obj\"><string name=\"filename\" value=\"../a.obj\"/></shape>",
            "a.xml:2:19: \"../a.obj\" leads out of the scene's folder; move the file beside the \
             scene, or allow this with --allow-path",
        ),
        ("<shape type=\"obj\"/>", "a.xml:2:1: shape \"obj\" needs a filename"),
        (
            "<shape type=\"sphere\"><transform name=\"to_world\"><matrix value=\"1 2 3\"/>\
             </transform></shape>",
            "a.xml:2:64: \"1 2 3\" is not a matrix: 16 numbers, or 9",
        ),
        (
            "<shape type=\"sphere\"><transform name=\"to_world\"><rotate angle=\"3\"/>\
             </transform></shape>",
            "a.xml:2:49: the axis to turn around has no length",
        ),
        (
            "<shape type=\"sphere\"><transform name=\"to_world\"><scale value=\"0\"/>\
             </transform></shape>",
            "a.xml:2:1: transform flattens the shape: a scale is 0, or too close to it",
        ),
        (
            "<integrator type=\"path\"><integer name=\"max_depth\" value=\"0\"/></integrator>",
            "a.xml:2:25: max_depth is 0, with which nothing is seen: it must be 1 or more, or -1",
        ),
        (
            "<float name=\"$x\" value=\"1\"/>",
            "a.xml:2:14: no parameter \"x\": it has no <default>; give it with -D x=VALUE",
        ),
        ("<emitter type=\"envmap\"/>", "a.xml:2:1: emitter \"envmap\" needs a filename"),
        (
            "<emitter type=\"constant\"/><emitter type=\"constant\"/>",
            "a.xml:2:27: there is more than one sky; a scene has one",
        ),
        ("hello", "a.xml:2:1: \"hello\" stands between elements, where nothing has a meaning"),
        (
            "<shape type=\"sphere\">",
            "a.xml:3:1: ill-formed document: expected `</shape>`, but \
            `</scene>` was found",
        ),
        ("<shape type=\"sphere\" type=\"disk\"/>", "a.xml:2:28: type comes twice"),
        ("<scene/>", "a.xml:2:1: a <scene> cannot stand within another"),
    ] {
        let is = refusal(body);
        if is != said {
            wrong.push(format!("{body}\n  says {is}\nnot {said}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// What asks for more than its bytes can back is refused in one line, and soon.
#[test]
fn bombs_are_refused() {
    let deep = format!("{}{}", "<bsdf type=\"a\">".repeat(100_000), "</bsdf>".repeat(100_000));
    assert_eq!(
        refusal(&deep),
        "a.xml:2:946: 65 levels of nesting, but at most 64 are allowed; allow more with --limit \
         nesting=N"
    );
    // Few lines that ask for very many objects, and are counted before any is made.
    let group = format!("<shape type=\"shapegroup\" id=\"g\">{}</shape>", BALL.repeat(5000));
    let many = "<shape type=\"instance\"><ref id=\"g\"/></shape>".repeat(5000);
    let start = Instant::now();
    assert!(refusal(&(group + &many)).contains("objects, but at most 3000000"));
    assert!(start.elapsed() < Duration::from_secs(1), "{:?}", start.elapsed());

    // Whatever the limit, calls within calls end.
    let text = format!("<scene version=\"3.0.0\">{deep}</scene>");
    let limits = Limits { nesting: u64::MAX, ..Limits::default() };
    let options = ReadOptions { limits, ..ReadOptions::default() };
    let error = parse_mitsuba(text.as_bytes().to_vec(), Path::new("a.xml"), &options);
    assert!(error.map(|_| ()).expect_err("refused").to_string().contains("501 levels"));

    let bomb = "<!DOCTYPE scene [<!ENTITY a \"aaaa\"><!ENTITY b \"&a;&a;&a;&a;\">]>\n<scene \
                version=\"3.0.0\"/>";
    let error =
        parse_mitsuba(bomb.as_bytes().to_vec(), Path::new("a.xml"), &ReadOptions::default());
    let said = error.map(|_| ()).expect_err("refused").to_string();
    assert!(said.starts_with("a.xml:1:1: a document type, and entities with it"), "{said}");
    assert!(refusal("<string name=\"a\" value=\"&b;\"/>").contains("a.xml:2:25: "));

    // Defaults made of defaults.
    let mut doubling = "<default name=\"a0\" value=\"aaaaaaaaaaaaaaaa\"/>".to_owned();
    for i in 1..60 {
        let one = format!("$a{}", i - 1);
        doubling += &format!("<default name=\"a{i}\" value=\"{one}{one}\"/>");
    }
    assert!(refusal(&doubling).contains("bytes of text made of parameters in all"));

    for circle in [
        "<bsdf type=\"twosided\" id=\"a\"><ref id=\"a\"/></bsdf><shape type=\"disk\"><ref id=\"a\"/>\
         </shape>",
        "<texture type=\"scale\" id=\"a\"><ref id=\"a\"/></texture><shape type=\"disk\"><bsdf \
         type=\"diffuse\"><ref name=\"reflectance\" id=\"a\"/></bsdf></shape>",
        "<shape type=\"shapegroup\" id=\"a\"><shape type=\"instance\"><ref id=\"a\"/></shape>\
         </shape><shape type=\"instance\"><ref id=\"a\"/></shape>",
    ] {
        refusal(circle);
    }
}

/// The command line stands before defaults; of names that begin alike the longest counts.
#[test]
fn parameters_stand_for_values() {
    let body = "<default name=\"r\" value=\"2\"/><default name=\"res\" value=\"32\"/>\
                <sensor type=\"perspective\"><float name=\"fov\" value=\"4$r\"/><film type=\"hdrfilm\">\
                <integer name=\"width\" value=\"$res\"/><integer name=\"height\" value=\"$res\"/></film>\
                </sensor><shape type=\"sphere\"/>";
    let pair = |name: &str, value: &str| (name.to_owned(), value.to_owned());
    assert_eq!(read(body).settings.size, [32, 32]);
    let given = [pair("res", "8"), pair("res", "64")];
    assert_eq!(try_read(body, &given).expect("read").settings.size, [64, 64]);
    let said = |given| try_read(body, &[given]).map(|_| ()).expect_err("refused").to_string();
    assert_eq!(
        said(pair("ress", "1")),
        "nowhere/a.xml: no parameter \"ress\"; did you mean \"res\"?"
    );
    assert_eq!(said(pair("x", "1")), "nowhere/a.xml: no parameter \"x\"; there are r, res");
    let unused =
        try_read("<default name=\"q\" value=\"1\"/><shape type=\"sphere\"/>", &[pair("q", "2")]);
    let notes = unused.expect("read").notes;
    assert!(notes.iter().any(|note| note.ends_with("nothing in it uses the parameter \"q\"")));
    // Others have none.
    let file = tempfile::Builder::new().suffix(".obj").tempfile().expect("a file");
    fs::write(file.path(), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").expect("written");
    let options = ReadOptions { parameters: &[pair("a", "b")], ..ReadOptions::default() };
    let said = read_scene(file.path(), &options).map(|_| ()).expect_err("refused").to_string();
    assert!(said.ends_with(": no parameter \"a\": only Mitsuba scenes have parameters"), "{said}");
}

/// Included files are parts of the scene, and their paths are counted from the scene's own folder;
/// circles of them end.
#[test]
fn files_are_included() {
    let folder = tempfile::tempdir().expect("a folder");
    let write =
        |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("written");
    fs::create_dir(folder.path().join("parts")).expect("a folder");
    write(
        "a.xml",
        "<scene version=\"3.0.0\"><default name=\"r\" value=\"3\"/><include \
         filename=\"parts/b.xml\"/></scene>",
    );
    write("parts/b.xml", "<scene version=\"3.0.0\"><include filename=\"parts/c.xml\"/></scene>");
    write("parts/c.xml", "<shape type=\"sphere\"><float name=\"radius\" value=\"$r\"/></shape>");
    let a = folder.path().join("a.xml");
    let loaded = read_scene(&a, &ReadOptions::default()).expect("read");
    assert_eq!(loaded.scene.objects[0].shape, Shape::Sphere { radius: 3.0 });
    assert_eq!(loaded.files.len(), 2);

    write("parts/c.xml", "<scene version=\"3.0.0\"><include filename=\"parts/b.xml\"/></scene>");
    let said =
        read_scene(&a, &ReadOptions::default()).map(|_| ()).expect_err("refused").to_string();
    assert!(
        said.ends_with("c.xml:1:24: \"parts/b.xml\" includes itself, by itself or by others"),
        "{said}"
    );
    write("parts/c.xml", "<scene version=\"3.0.0\">\n<shape type=\"x\"/></scene>");
    let said =
        read_scene(&a, &ReadOptions::default()).map(|_| ()).expect_err("refused").to_string();
    assert!(said.contains("c.xml:2:1: "), "{said}");
    // Twice the same, over and over, but never a circle: two to the power of fourteen files.
    for i in 0..15 {
        let next = format!("<include filename=\"i{}.xml\"/>", i + 1);
        write(&format!("i{i}.xml"), &format!("<scene version=\"3.0.0\">{next}{next}</scene>"));
    }
    write("i15.xml", "<scene version=\"3.0.0\"/>");
    let said = read_scene(&folder.path().join("i0.xml"), &ReadOptions::default());
    let said = said.map(|_| ()).expect_err("refused").to_string();
    assert!(said.contains("257 included files, but at most 256 are allowed"), "{said}");
}

fn camera(body: &str) -> Camera {
    read(&format!("{body}{BALL}")).scene.camera
}

/// Angles of view by trigonometry, whatever side they are measured along; poses with x to the left.
#[test]
fn cameras_see_what_they_should() {
    let sensor = |more: &str| {
        camera(&format!(
            "<sensor type=\"perspective\">{more}<transform name=\"to_world\"><lookat \
             origin=\"1, 2, 3\" target=\"1, 2, 13\" up=\"0, 1, 0\"/></transform><film \
             type=\"hdrfilm\"><integer name=\"width\" value=\"200\"/><integer name=\"height\" \
             value=\"100\"/></film></sensor>"
        ))
    };
    let degrees = |more: &str| match sensor(more) {
        Camera::Perspective(camera) => f64::from(camera.fov_y).to_degrees(),
        other => panic!("{other:?}"),
    };
    let fov = "<float name=\"fov\" value=\"60\"/>";
    let axis = |name: &str| format!("{fov}<string name=\"fov_axis\" value=\"{name}\"/>");
    let half = 30.0_f64.to_radians().tan();
    for (more, wanted) in [
        (fov.to_owned(), 2.0 * (half / 2.0).atan().to_degrees()),
        (axis("x"), 2.0 * (half / 2.0).atan().to_degrees()),
        (axis("y"), 60.0),
        (axis("smaller"), 60.0),
        (axis("larger"), 2.0 * (half / 2.0).atan().to_degrees()),
        (axis("diagonal"), 2.0 * (half / 5.0_f64.sqrt()).atan().to_degrees()),
        // Half the diagonal of 36 x 24 mm is 21.63 mm.
        (
            "<string name=\"focal_length\" value=\"50mm\"/>".to_owned(),
            2.0 * (21.633_307_652_783_94 / 50.0 / 5.0_f64.sqrt()).atan().to_degrees(),
        ),
    ] {
        assert!((degrees(&more) - wanted).abs() < 1e-4, "{more}: {}", degrees(&more));
    }
    // It looks along +z, so +x is to the left.
    let pose = *sensor(fov).world_from_camera();
    assert!((pose.vector(Vec3::NEG_Z) - Vec3::Z).length() < 1e-6);
    assert!((pose.vector(Vec3::X) - Vec3::NEG_X).length() < 1e-6);
    assert!((pose.point(Vec3::ZERO) - Vec3::new(1.0, 2.0, 3.0)).length() < 1e-6);

    // Two units wide, times the scale.
    let plan = camera(
        "<sensor type=\"orthographic\"><transform name=\"to_world\"><scale x=\"3\" y=\"3\"/>\
         </transform><film type=\"hdrfilm\"><integer name=\"width\" value=\"200\"/><integer \
         name=\"height\" value=\"100\"/></film></sensor>",
    );
    assert!(
        matches!(plan, Camera::Orthographic(plan) if (plan.height - 3.0).abs() < 1e-6),
        "{plan:?}"
    );
}

/// What is said of the picture; and Mitsuba's own numbers where nothing is.
#[test]
fn settings_are_read() {
    let plain = read(&format!(
        "<sensor type=\"perspective\"><float name=\"fov\" value=\"40\"/></sensor>{BALL}"
    ));
    let Settings { size, spp, filter, max_depth, .. } = plain.settings;
    assert_eq!((size, spp, max_depth), ([768, 576], 4, None));
    assert_eq!(filter, Filter::Gaussian { radius: 2.0, sigma: 0.5 });
    for (integrator, depth) in [("path", Some(7)), ("direct", Some(2)), ("volpath", Some(7))] {
        let body = format!(
            "<integrator type=\"{integrator}\"><integer name=\"max_depth\" value=\"7\"/></integrator>{BALL}"
        );
        let loaded = read(&body);
        assert_eq!(loaded.settings.max_depth, depth, "{integrator}");
    }
}

/// Cameras have names, and the chosen one says how large the picture is.
#[test]
fn cameras_are_chosen_by_name() {
    let sensor = |id: &str, width: u32| {
        format!(
            "<sensor type=\"perspective\" id=\"{id}\"><float name=\"fov\" value=\"40\"/><film \
             type=\"hdrfilm\"><integer name=\"width\" value=\"{width}\"/><integer name=\"height\" \
             value=\"10\"/></film></sensor>"
        )
    };
    let text =
        format!("<scene version=\"3.0.0\">{}{}{BALL}</scene>", sensor("a", 20), sensor("b", 30));
    let of = |choice: &CameraChoice| {
        let options = ReadOptions { camera: choice, ..ReadOptions::default() };
        let loaded = parse_mitsuba(text.as_bytes().to_vec(), Path::new("a.xml"), &options);
        loaded.map(|loaded| (loaded.camera, loaded.settings.size[0])).map_err(|e| e.to_string())
    };
    assert_eq!(of(&CameraChoice::First), Ok((0, 20)));
    assert_eq!(of(&CameraChoice::Named("b".to_owned())), Ok((1, 30)));
    assert_eq!(of(&CameraChoice::Auto), Ok((2, 20)));
    assert!(of(&CameraChoice::Named("c".to_owned())).is_err());
}

/// Lights by their numbers; a sky that stands on its side turns the scene, not the sky.
#[test]
fn lights_shine_as_they_should() {
    let lights = read(&format!(
        "<emitter type=\"point\"><transform name=\"to_world\"><translate x=\"1\"/></transform>\
         <rgb name=\"intensity\" value=\"1 2 3\"/></emitter>\
         <emitter type=\"spot\"><float name=\"cutoff_angle\" value=\"40\"/><transform \
         name=\"to_world\"><lookat origin=\"0 3 0\" target=\"0 0 0\" up=\"1 0 0\"/></transform>\
         </emitter>\
         <emitter type=\"directional\"><transform name=\"to_world\"><rotate x=\"1\" angle=\"90\"/>\
         </transform><spectrum name=\"irradiance\" value=\"5\"/></emitter>{BALL}"
    ))
    .scene
    .lights;
    let point = Light::Point { position: Vec3::X, intensity: Rgb::new(1.0, 2.0, 3.0), group: None };
    assert_eq!(lights[0], point);
    match lights[1] {
        Light::Spot { position, direction, light, inner, outer, group: None } => {
            assert_eq!(position, Vec3::new(0.0, 3.0, 0.0));
            assert!((direction - Vec3::NEG_Y).length() < 1e-6);
            assert_eq!(light, SpotLight::Intensity(Rgb::WHITE));
            assert_eq!([inner, outer], [30.0_f32, 40.0].map(f32::to_radians));
        }
        other => panic!("{other:?}"),
    }
    match lights[2] {
        Light::Directional { direction, irradiance, group: None } => {
            assert!((direction - Vec3::NEG_Y).length() < 1e-6);
            // Light that is the same at every wavelength, as the CIE's observer sees it, in sRGB.
            for (is, wanted) in irradiance.0.into_iter().zip([6.024, 4.741, 4.545]) {
                assert!((is - wanted).abs() < 0.05, "{irradiance:?}");
            }
        }
        other => panic!("{other:?}"),
    }

    let under = |transform: &str| {
        read(&format!(
            "<emitter type=\"envmap\"><string name=\"filename\" value=\"sky.hdr\"/><float \
             name=\"scale\" value=\"2\"/><transform name=\"to_world\">{transform}</transform>\
             </emitter><shape type=\"sphere\"><point name=\"center\" x=\"1\" y=\"2\" z=\"3\"/></shape>"
        ))
    };
    // Mitsuba's middle of the picture is at +z, ours at −z.
    for (transform, degrees, center) in [
        ("", 180.0, Vec3::new(1.0, 2.0, 3.0)),
        ("<rotate y=\"1\" angle=\"50\"/>", 230.0, Vec3::new(1.0, 2.0, 3.0)),
        // Its up is +z; what was there is up now.
        ("<rotate x=\"1\" angle=\"90\"/>", 180.0, Vec3::new(1.0, 3.0, -2.0)),
    ] {
        let scene = under(transform).scene;
        let sky = scene.environment.expect("a sky");
        assert!(matches!(sky.light, EnvironmentLight::Image { .. }) && sky.scale == 2.0);
        assert!(
            (sky.rotation.to_degrees() - degrees).abs() < 1e-3,
            "{transform}: {}",
            sky.rotation
        );
        let there = scene.objects[0].world_from_object.translation();
        assert!((there - center).length() < 1e-5, "{transform}: {there}");
    }
}

/// Mattes go by ids: a shape's own, else its BSDF's; what a group holds is a part of it.
#[test]
fn things_go_by_their_ids() {
    let loaded = read(
        "<bsdf type=\"diffuse\" id=\"oak\"/>\
         <shape type=\"sphere\" id=\"ball\"/>\
         <shape type=\"disk\"><ref id=\"oak\"/></shape>\
         <shape type=\"shapegroup\" id=\"garden/tree\"><shape type=\"disk\" id=\"leaf\"/>\
         <shape type=\"rectangle\"><ref id=\"oak\"/></shape></shape>\
         <shape type=\"instance\" id=\"one\"><ref id=\"garden/tree\"/></shape>",
    );
    let scene = &loaded.scene;
    let names: Vec<_> =
        (0..scene.objects.len()).map(|i| cryptomatte::object_name(scene, i)).collect();
    assert_eq!(names, ["ball", "oak", "gardentree/leaf", "gardentree/oak"]);
}

/// Lamps glow on their front; those that name no BSDF are black, other shapes grey.
#[test]
fn lamps_are_black() {
    let scene = read(
        "<shape type=\"rectangle\"><emitter type=\"area\"><rgb name=\"radiance\" value=\"3\"/>\
         </emitter></shape><shape type=\"rectangle\"/>",
    )
    .scene;
    assert_eq!(scene.materials[0].kind, MaterialKind::Black);
    let emission = scene.materials[0].emission.expect("light");
    assert_eq!(emission.light, EmittedLight::Radiance(Rgb::grey(3.0)));
    assert!(!emission.two_sided);
    assert!(
        matches!(&scene.materials[1].kind, MaterialKind::Matte(matte) if matte.albedo.factor == Rgb::grey(0.5))
    );
}

/// A picture's first row is where v is 0, in Mitsuba; here it is the last one.
#[test]
fn pictures_stand_as_they_should() {
    let scene = read(
        "<shape type=\"rectangle\"><bsdf type=\"diffuse\"><texture type=\"bitmap\" \
         name=\"reflectance\"><string name=\"filename\" value=\"sky.hdr\"/><transform \
         name=\"to_uv\"><scale x=\"2\" y=\"4\"/></transform></texture></bsdf></shape>",
    )
    .scene;
    let Texture::Image(picture) = &scene.textures[0] else { panic!("a picture") };
    // v goes to 1 − 4 v.
    assert_eq!(picture.mapping.scale.to_array(), [2.0, -4.0]);
    assert_eq!(picture.mapping.offset.to_array(), [0.0, 1.0]);
}

/// What has no meaning is told once for each kind.
#[test]
fn what_is_left_out_is_told() {
    let ball = "<shape type=\"sphere\"><float name=\"colour\" value=\"1\"/></shape>";
    let notes = read(&ball.repeat(3)).notes;
    let told = notes.iter().filter(|note| note.contains("\"colour\" of shape \"sphere\""));
    assert_eq!(told.count(), 1, "{notes:?}");
}

/// Serialized meshes of both versions; what they say is held against their bytes.
#[test]
fn serialized_meshes_are_read() {
    let corpus = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/corpus/serialized/");
    let (path, limits) = (Path::new("a.serialized"), Limits::default());
    for version in ["v3", "v4"] {
        let bytes = fs::read(format!("{corpus}{version}.serialized")).expect("a file");
        assert_eq!(serialized::count(&bytes, path).expect("a count"), 2);
        let quad = serialized::read_bytes(&bytes, 1, path, &limits).expect("read");
        assert_eq!(quad.positions[2], Vec3::new(1.0, 1.0, 0.0));
        assert_eq!(quad.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(quad.uvs[3].to_array(), [0.0, 1.0]);
        assert_eq!(quad.name, if version == "v4" { "quad" } else { "" });
        let said = |number| {
            let read = serialized::read_bytes(&bytes, number, path, &limits);
            read.map(|_| ()).expect_err("refused").to_string()
        };
        assert_eq!(said(2), "a.serialized: there is no mesh number 2; they go from 0 to 1");
        common::cut_everywhere(&bytes, |cut| {
            let _ = serialized::read_bytes(cut, 0, path, &limits);
        });
        let few = Limits { vertices: 3, ..limits };
        assert!(serialized::read_bytes(&bytes, 0, path, &few).is_ok());
        let said = serialized::read_bytes(&bytes, 1, path, &few).map(|_| ()).expect_err("refused");
        assert!(said.to_string().contains("4 vertices, but at most 3"), "{said}");
    }
    let liar = fs::read(format!("{corpus}bad-liar.serialized")).expect("a file");
    let said = serialized::read_bytes(&liar, 0, path, &limits).map(|_| ()).expect_err("refused");
    assert!(said.to_string().ends_with("for which its bytes are too few"), "{said}");
}

/// A file of serialized meshes that begin at these places.
fn serialized_file(packed: &[&[u8]], begin: &[u64]) -> Vec<u8> {
    let mut file = Vec::new();
    for packed in packed {
        file.extend([0x1c, 0x04, 4, 0]);
        file.extend(*packed);
    }
    begin.iter().for_each(|at| file.extend(at.to_le_bytes()));
    file.extend((begin.len() as u32).to_le_bytes());
    file
}

/// What packs a thousandfold is no mesh; and meshes do not lie in each other, so that a file becomes
/// no more than its bytes can hold.
#[test]
fn serialized_bombs_stay_packed() {
    let pack = |vertices: u64| {
        let mut packer = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
        packer.write_all(&0x1000_u32.to_le_bytes()).expect("flags: single precision");
        packer.write_all(&[0]).expect("no name");
        packer.write_all(&vertices.to_le_bytes()).expect("vertices");
        packer.write_all(&0_u64.to_le_bytes()).expect("no triangles");
        packer.write_all(&vec![0; 12 * vertices as usize]).expect("points");
        packer.finish().expect("packed")
    };
    let bomb = pack(1_000_000);
    assert!(bomb.len() < 20_000);
    let limits = Limits::default();
    let file = serialized_file(&[&bomb], &[0]);
    let read = serialized::read_bytes(&file, 0, Path::new("a.serialized"), &limits);
    let said = read.map(|_| ()).expect_err("refused").to_string();
    assert!(said.ends_with("for which its bytes are too few"), "{said}");

    let small = pack(3);
    let second = 4 + small.len() as u64;
    for (begin, fine) in [([0, second], true), ([second, 0], false)] {
        let file = serialized_file(&[&small, &small], &begin);
        let options =
            ReadOptions { embedded: &[("m.serialized", &file)], ..ReadOptions::default() };
        let text = "<scene version=\"3.0.0\"><shape type=\"serialized\"><string \
                    name=\"filename\" value=\"m.serialized\"/></shape></scene>";
        let read = parse_mitsuba(text.into(), Path::new("a.xml"), &options);
        let said = read.map(|_| ()).map_err(|error| error.to_string());
        let order = said.as_ref().is_err_and(|said| said.contains("one behind the other"));
        assert_eq!(order, !fine, "{said:?}");
    }
}

/// Film and sampler are those of the camera that is shown, by name or by number; nothing is said of
/// the others'. A size that is asked for cuts the same part out of the film.
#[test]
fn the_camera_that_is_shown_has_its_film() {
    let sensor = |id: &str, width: u32, samples: u32| {
        format!(
            "<sensor type=\"perspective\" id=\"{id}\"><film type=\"hdrfilm\"><integer name=\"width\" \
             value=\"{width}\"/><integer name=\"height\" value=\"10\"/><integer \
             name=\"crop_offset_x\" value=\"{}\"/><integer name=\"crop_width\" value=\"{}\"/></film>\
             <sampler type=\"independent\"><integer name=\"sample_count\" value=\"{samples}\"/>\
             </sampler></sensor>",
            width / 2,
            width / 4
        )
    };
    let text = format!(
        "<scene version=\"3.0.0\">{}{}{BALL}<emitter type=\"constant\"/></scene>",
        sensor("a", 40, 2),
        sensor("b", 20, 7)
    );
    for (camera, size, samples, width, crop) in [
        ("a", None, 2, 40, [20, 10]),
        ("1", None, 2, 40, [20, 10]),
        ("b", None, 7, 20, [10, 5]),
        ("2", None, 7, 20, [10, 5]),
        ("2", Some([80, 40]), 7, 80, [40, 20]),
    ] {
        let camera = &CameraChoice::Named(camera.to_owned());
        let options = ReadOptions { camera, size, ..ReadOptions::default() };
        let loaded = parse_mitsuba(text.clone().into_bytes(), Path::new("a.xml"), &options);
        let loaded = loaded.unwrap_or_else(|error| panic!("{error}"));
        let settings = &loaded.settings;
        let cut = settings.crop.expect("a part");
        assert_eq!((settings.spp, settings.size[0], [cut.x, cut.width]), (samples, width, crop));
        assert!(!loaded.notes.iter().any(|n| n.contains("left out")), "{:?}", loaded.notes);
    }
}

/// Nothing that would change the picture is shown otherwise without a word.
#[test]
fn differences_are_told() {
    for (body, note) in [
        (
            "<integrator type=\"direct\"><boolean name=\"hide_emitters\" value=\"true\"/></integrator>",
            "lamps are not hidden: hide_emitters is left out",
        ),
        (
            "<integrator type=\"path\"/><integrator type=\"direct\"/>",
            "there is more than one integrator: the first one counts",
        ),
        (
            "<sensor type=\"orthographic\"><transform name=\"to_world\"><scale x=\"3\" y=\"2\"/></transform>\
             </sensor>",
            "how an orthographic camera is scaled along its x counts for its y as well",
        ),
        (
            "<emitter type=\"point\"/><shape type=\"disk\"><bsdf type=\"mask\"><bsdf type=\"diffuse\"/></bsdf>\
             </shape>",
            "a mask lets the light of points, spots and directions through; Mitsuba's casts a black \
             shadow in it",
        ),
        (
            "<shape type=\"sphere\"><transform name=\"to_world\"><scale x=\"3\"/></transform></shape>",
            "spheres that are stretched are shown so; Mitsuba keeps them round",
        ),
    ] {
        let notes = read(&format!("{body}{BALL}")).notes;
        assert!(notes.iter().any(|said| said.ends_with(note)), "{body}: {notes:?}");
    }
    let look = |up: &str| {
        format!(
            "<sensor type=\"perspective\"><transform name=\"to_world\"><lookat origin=\"0,0,5\" \
             target=\"0,0,0\" up=\"{up}\"/></transform></sensor>{BALL}"
        )
    };
    assert!(refusal(&look("0,0,1")).ends_with("up is parallel to the view"));
    read(&look("0,0,0"));
}

/// However much of a scene is not known, the notes on it can be read.
#[test]
fn notes_are_limited() {
    let shape = |names: std::ops::Range<u32>| {
        let each = names.map(|i| format!("<float name=\"a{i}\" value=\"1\"/>"));
        format!("<shape type=\"sphere\">{}</shape>", each.collect::<String>())
    };
    let notes = read(&(0..10).map(|i| shape(500 * i..500 * (i + 1))).collect::<String>()).notes;
    assert!(notes.len() <= 103, "{}", notes.len());
    assert!(notes.iter().any(|note| note.ends_with(" more of the kind")), "{notes:?}");
    let said = refusal(&shape(0..5000));
    assert!(said.contains("1001 properties of one object, but at most 1000"), "{said}");
}

/// A group that stands twice is looked at once, but a sphere in it is a sphere only where it stays
/// round; each object knows its line.
#[test]
fn groups_are_placed_as_they_stand() {
    let loaded = read(
        "<shape type=\"shapegroup\" id=\"g\"><shape type=\"sphere\"/></shape>\n\
         <shape type=\"instance\"><ref id=\"g\"/></shape>\n\
         <shape type=\"instance\"><ref id=\"g\"/><transform name=\"to_world\"><scale x=\"2\"/>\
         </transform></shape>\n<shape type=\"instance\"><ref id=\"g\"/></shape>\n\
         <shape type=\"disk\"/>",
    );
    let shapes: Vec<_> = loaded.scene.objects.iter().map(|object| &object.shape).collect();
    assert!(
        matches!(
            shapes[..],
            [Shape::Sphere { .. }, Shape::Mesh(_), Shape::Sphere { .. }, Shape::Disk { .. }]
        ),
        "{shapes:?}"
    );
    let line = |number| loaded.lines[&Place::Object(number)];
    assert_eq!([0, 1, 2, 3].map(line), [2, 2, 2, 6]);
}

/// Benedikt Bitterli's Cornell box looks as Tungsten shows it: the means of squares are within what
/// 64 samples for a pixel leave of noise.
#[test]
fn a_real_scene_looks_as_it_should() {
    let Some(data) = std::env::var_os("RUTILANT_DATA") else {
        eprintln!("skipped: RUTILANT_DATA names no folder");
        return;
    };
    let folder = Path::new(&data).join("mitsuba/bitterli-cornell-box");
    if !folder.is_dir() {
        eprintln!("skipped: RUTILANT_DATA has no Cornell box");
        return;
    }
    let reference =
        image::read(&folder.join("TungstenRender.exr"), &Limits::default()).expect("read");
    let loaded = read_scene(&folder.join("scene.xml"), &ReadOptions::default()).expect("read");
    assert_eq!(loaded.settings.size, [1024, 1024]);
    let settings = Settings {
        size: [64, 64],
        spp: 64,
        filter: Filter::Box { radius: 0.5 },
        ..loaded.settings
    };
    let prepared = Arc::new(rutilant::Prepared::new(&loaded.scene).expect("prepared"));
    let session = Session::start(prepared, settings, 2).expect("started");
    assert!(session.wait(Duration::from_secs(120)), "no end");
    let ours = session.snapshot();

    // Means of squares: 8 x 8 of them.
    let squares = |picture: &rutilant::image::Image| -> Vec<[f64; 3]> {
        let (width, height) = (picture.width() as usize, picture.height() as usize);
        let pixels = picture.rgb().expect("colours");
        let mut sums = vec![[0.0; 3]; 64];
        for y in 0..height {
            for x in 0..width {
                let square = &mut sums[y * 8 / height * 8 + x * 8 / width];
                for (sum, channel) in square.iter_mut().zip(pixels[y * width + x]) {
                    *sum += f64::from(channel) * 64.0 / (width * height) as f64;
                }
            }
        }
        sums
    };
    for (i, (ours, theirs)) in squares(&ours).iter().zip(squares(&reference)).enumerate() {
        for (a, b) in ours.iter().zip(theirs) {
            assert!((a - b).abs() < 0.06 * b + 0.004, "square {i}: {a} instead of {b}");
        }
    }
}
