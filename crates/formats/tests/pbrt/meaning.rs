//! What scenes of pbrt mean: pictures whose values are known, and materials worked out by hand.

use crate::sound;
use rutilant::color::Rgb;
use rutilant::cryptomatte;
use rutilant::film::Filter;
use rutilant::geom::{Vec2, Vec3};
use rutilant::light::{EnvironmentLight, Light, SpotLight};
use rutilant::material::{Absorption, EmittedLight, Material, MaterialKind, Principled};
use rutilant::settings::{Crop, IntegratorKind, SamplerKind, Settings};
use rutilant::shape::Shape;
use rutilant::texture::{Checker, Texture};
use rutilant::{Prepared, Session};
use rutilant_formats::camera::{AngleOfView, CameraKind};
use rutilant_formats::{LoadedScene, PictureOrigin, ReadOptions, parse_pbrt};
use std::f32::consts::PI;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// A picture of so many pixels, (height, width), row 0 on top.
fn picture(loaded: &LoadedScene, size: [u32; 2], spp: u64) -> Vec<[f32; 3]> {
    let prepared = Arc::new(Prepared::new(&loaded.scene).expect("sound"));
    let filter = Filter::Box { radius: 0.5 };
    let settings = Settings { size, crop: None, spp, filter, ..loaded.settings.clone() };
    let session = Session::start(prepared, settings, 2).expect("sound settings");
    assert!(session.wait(Duration::from_secs(60)), "no end");
    session.snapshot().rgb().expect("colours")
}

/// The mean of a small picture.
fn seen(text: &str) -> [f32; 3] {
    let pixels = picture(&sound(text), [4, 4], 64);
    let count = pixels.len() as f32;
    pixels.into_iter().fold([0.0; 3], |sum, p| std::array::from_fn(|i| sum[i] + p[i] / count))
}

fn near(a: [f32; 3], b: [f32; 3], part: f32) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() <= part * b.abs().max(1e-3))
}

/// The material that a statement makes.
fn material(statements: &str) -> Material {
    let mut loaded = sound(&format!("{statements} Shape \"sphere\""));
    let number = loaded.scene.objects[0].material.0 as usize;
    loaded.scene.materials.swap_remove(number)
}

fn layers(statements: &str) -> Principled {
    match material(statements).kind {
        MaterialKind::Principled(layers) => *layers,
        other => panic!("{statements}: {other:?}"),
    }
}

const FLOOR: &str = "Material \"diffuse\" \"rgb reflectance\" [ 1 1 1 ] Shape \"bilinearmesh\" \
                     \"point3 P\" [ -99 -99 0  99 -99 0  -99 99 0  99 99 0 ]\n";
const FROM_ABOVE: &str = "LookAt 0 0 1  0 0 0  0 1 0  Camera \"perspective\" \"float fov\" 1\n";

/// Light has the values in the picture that the film's exposure makes of them: a sky of [1 1 1] is
/// 1, and told by its spectrum it has the luminance 1.
#[test]
fn film_shows_light_as_it_is_told() {
    let sky = |before: &str, light: &str| {
        seen(&format!("{before} WorldBegin LightSource \"infinite\" {light}"))
    };
    assert!(near(sky("", "\"rgb L\" [ 1 2 3 ]"), [1.0, 2.0, 3.0], 1e-5));
    assert!(near(sky("", "\"rgb L\" [ 1 2 3 ] \"float scale\" 2"), [2.0, 4.0, 6.0], 1e-5));
    let half = "Camera \"perspective\" \"float shutterclose\" .5 Film \"rgb\" \"float iso\" 300";
    assert!(near(sky(half, "\"rgb L\" [ 1 1 1 ]"), [1.5; 3], 1e-5));
    let old = "Film \"image\" \"float scale\" 3";
    assert!(near(sky(old, "\"rgb L\" [ 1 2 3 ] \"rgb scale\" [ 2 1 1 ]"), [6.0, 6.0, 9.0], 1e-5));
    for light in [
        "",
        "\"blackbody L\" 3000",
        "\"spectrum L\" \"stdillum-A\"",
        "\"spectrum L\" [ 300 5 800 9 ]",
    ] {
        let [r, g, b] = sky("", light);
        let luminance = 0.2127 * r + 0.7152 * g + 0.0722 * b;
        assert!((luminance - 1.0).abs() < 2e-3, "{light}: {luminance}");
    }
    assert!(near(sky("", ""), [1.0; 3], 1e-5));
    let [r, _, b] = sky("", "\"blackbody L\" 3000");
    assert!(r > 2.0 * b, "3000 K is red: {r} {b}");
}

/// A white floor under each kind of light sends back 1 / π of what falls onto it, which follows from
/// the definitions of power, illuminance and intensity alone.
#[test]
fn lights_are_as_bright_as_they_say() {
    let floor = |light: &str| seen(&format!("{FROM_ABOVE} WorldBegin {FLOOR} {light}"));
    let all_same = |value: f32| [value / PI; 3];
    for (light, illuminance) in [
        // A sky of radiance 1 gives π, one of an illuminance what it says.
        ("LightSource \"infinite\"", PI),
        ("LightSource \"infinite\" \"float illuminance\" 5", 5.0),
        // From straight above.
        (
            "LightSource \"distant\" \"point3 from\" [ 0 0 1 ] \"point3 to\" [ 0 0 0 ] \"rgb L\" [ 3 3 3 ]",
            3.0,
        ),
        (
            "LightSource \"distant\" \"point3 from\" [ 0 0 9 ] \"point3 to\" [ 0 0 0 ] \"float illuminance\" 7",
            7.0,
        ),
        // From 2 away: a fourth of the intensity.
        ("LightSource \"point\" \"point3 from\" [ 0 0 2 ] \"rgb I\" [ 8 8 8 ]", 2.0),
        ("Translate 0 0 2 LightSource \"point\" \"float power\" 16", 16.0 / (4.0 * PI) / 4.0),
        (
            "LightSource \"spot\" \"point3 from\" [ 0 0 2 ] \"point3 to\" [ 0 0 0 ] \"rgb I\" [ 8 8 8 ]",
            2.0,
        ),
        // A cone of 60° to each side without an edge is a quarter of the sphere: half of its half.
        (
            "LightSource \"spot\" \"point3 from\" [ 0 0 2 ] \"point3 to\" [ 0 0 0 ] \"float power\" 8 \
          \"float coneangle\" 60 \"float conedeltaangle\" 0",
            8.0 / PI / 4.0,
        ),
        // A disk of radius 3 at 4 fills sin² = 9 / 25 of what the whole sky would give.
        (
            "Translate 0 0 4 Scale 1 1 -1 AreaLightSource \"diffuse\" \"rgb L\" [ 2 2 2 ] Material \"interface\" \
          Shape \"disk\" \"float radius\" 3",
            2.0 * PI * 9.0 / 25.0,
        ),
    ] {
        let seen = floor(light);
        assert!(
            near(seen, all_same(illuminance), 0.02),
            "{light}: {seen:?}, not {illuminance} / π"
        );
    }
    // Of the power of a lamp each of pbrt's parts has all: 4 W over π times an area of 2, twice.
    let loaded = sound(
        "AreaLightSource \"diffuse\" \"float power\" 4 Shape \"trianglemesh\" \"point3 P\" \
         [ 0 0 0 2 0 0 2 1 0 0 1 0 ] \"integer indices\" [ 0 1 2 0 2 3 ]",
    );
    let emission = loaded.scene.materials[0].emission.expect("a lamp");
    assert_eq!(emission.light, EmittedLight::Power(Rgb::grey(8.0)));
}

/// The illuminance of a picture of the sky is pbrt-v4's: each of n pixels of equal area that stands
/// above the ground counts for 2π / n, not 4π / n. Of 4 × 4 pixels four do, and stand at a sine of
/// 3/4 (Clarberg, *Fast Equal-Area Mapping of the (Hemi)Sphere using SIMD*, 2008), so that they
/// make 4 · 3/4 · 2π / 16 = 3π / 8 of a radiance of 1.
#[test]
fn skies_have_the_illuminance_of_pbrt() {
    let sky = [&b"#?RADIANCE\n\n-Y 4 +X 4\n"[..], &[0x80, 0x80, 0x80, 0x81].repeat(16)].concat();
    let options = ReadOptions { embedded: &[("sky.hdr", &sky)], ..ReadOptions::default() };
    let text = "LightSource \"infinite\" \"string filename\" \"sky.hdr\" \"float illuminance\" 6";
    let loaded = parse_pbrt(text.into(), Path::new("a.pbrt"), &options).expect("sound");
    let scale = loaded.scene.environment.expect("a sky").scale;
    assert!((scale / (6.0 / (3.0 * PI / 8.0)) - 1.0).abs() < 0.01, "{scale}");
}

/// What the caller asks for is the film's size: what is seen follows from its shape, cut out parts
/// stay the same parts, and a window beside the middle is as large as asked for.
#[test]
fn sizes_that_are_asked_for_are_the_films() {
    let read = |camera: &str, film: &str, size| {
        let text = format!(
            "Camera \"perspective\" \"float fov\" 40 {camera} Film \"rgb\" {film} \"integer xresolution\" 60 \
             \"integer yresolution\" 30 WorldBegin Shape \"sphere\""
        );
        let options = ReadOptions { size, ..ReadOptions::default() };
        parse_pbrt(text.into(), Path::new("a.pbrt"), &options).expect("sound")
    };
    let degrees = |loaded: &LoadedScene| match loaded.cameras[0].kind {
        CameraKind::Perspective { view: AngleOfView::FovDegrees(degrees), .. } => degrees,
        other => panic!("{other:?}"),
    };
    // The angle is the shorter side's: of an upright picture the tangent from bottom to top doubles.
    let upright = degrees(&read("", "", Some([30, 60])));
    let expected = 2.0 * (2.0 * 20_f32.to_radians().tan()).atan().to_degrees();
    assert_eq!(degrees(&read("", "", None)), 40.0);
    assert!((upright - expected).abs() < 1e-3, "{upright}, not {expected}");
    for (camera, film, size, whole, crop) in [
        ("", "\"float cropwindow\" [ 0 .5 0 .5 ]", [30, 30], [30, 30], [0, 0, 15, 15]),
        ("", "\"integer pixelbounds\" [ 20 40 0 10 ]", [30, 30], [30, 30], [10, 0, 10, 10]),
        ("\"float screenwindow\" [ 0 2 -1 1 ]", "", [60, 30], [120, 30], [60, 0, 60, 30]),
        (
            "",
            "\"integer xresolution\" 60000 \"integer yresolution\" 60000",
            [20, 20],
            [20, 20],
            [0, 0, 20, 20],
        ),
    ] {
        let settings = read(camera, film, Some(size)).settings;
        let crop_is =
            settings.crop.map_or([0, 0, whole[0], whole[1]], |c| [c.x, c.y, c.width, c.height]);
        assert_eq!((settings.size, crop_is), (whole, crop), "{camera} {film}");
    }
}

/// A surface glows on its front: where its vertices run counter-clockwise, or where its normals
/// point if it has some; mirrored or not, the same side of the thing; turned round by
/// `ReverseOrientation`.
#[test]
fn fronts_are_those_of_pbrt() {
    let front = |before: &str, shape: &str| {
        let text = format!(
            "LookAt 0 0 5  0 0 0  0 1 0  Camera \"perspective\" \"float fov\" 1 WorldBegin \
             AreaLightSource \"diffuse\" \"rgb L\" [ 1 1 1 ] Material \"diffuse\" \"rgb reflectance\" \
             [ 0 0 0 ] {before} {shape}"
        );
        let [value, ..] = seen(&text);
        assert!(!(1e-3..=0.999).contains(&value), "{text}: {value}");
        value > 0.5
    };
    let triangle = "Shape \"trianglemesh\" \"point3 P\" [ -9 -9 0  9 -9 0  0 9 0 ]";
    let away = "\"normal N\" [ 0 0 -1 0 0 -1 0 0 -1 ]";
    let inside = "Shape \"sphere\" \"float radius\" 50";
    for (before, shape, is_front) in [
        ("", triangle.to_owned(), true),
        ("ReverseOrientation", triangle.to_owned(), false),
        ("ReverseOrientation ReverseOrientation", triangle.to_owned(), true),
        ("Rotate 180 1 0 0", triangle.to_owned(), false),
        ("Scale -1 1 1", triangle.to_owned(), true),
        ("", format!("{triangle} {away}"), false),
        ("ReverseOrientation", format!("{triangle} {away}"), true),
        ("", "Shape \"disk\" \"float radius\" 2".to_owned(), true),
        ("ReverseOrientation", "Shape \"disk\" \"float radius\" 2".to_owned(), false),
        ("", "Shape \"disk\" \"float radius\" 2 \"float phimax\" 359".to_owned(), true),
        ("", "Shape \"sphere\" \"float radius\" 2".to_owned(), true),
        ("", inside.to_owned(), false),
        ("ReverseOrientation", inside.to_owned(), true),
        ("Scale 1 1 2", inside.to_owned(), false),
        ("Rotate 90 1 0 0", "Shape \"cylinder\" \"float zmin\" -1".to_owned(), true),
        (
            "",
            "Shape \"bilinearmesh\" \"point3 P\" [ -9 -9 0  9 -9 0  -9 9 0  9 9 0 ]".to_owned(),
            true,
        ),
    ] {
        assert_eq!(front(before, &shape), is_front, "{before} {shape}");
    }
}

/// What lies to the right of pbrt's eye lies to the right in the picture, what is above it above;
/// with a mirror before the camera, to the left.
#[test]
fn eyes_see_what_pbrts_do() {
    for (mirror, right) in [("", false), ("Scale -1 1 1", true)] {
        // Left-handed: right is up × ahead, z × y = −x.
        let loaded = sound(&format!(
            "{mirror} LookAt 0 -10 0  0 0 0  0 0 1  Camera \"perspective\" \"float fov\" 90 WorldBegin \
             Translate 1 0 3 Shape \"sphere\" \"float radius\" .5"
        ));
        let camera = loaded.scene.camera.world_from_camera();
        let at = loaded.scene.objects[0].world_from_object.translation();
        let back = camera.inverse().expect("a pose");
        let place = back.point(at);
        assert!((place.y - 3.0).abs() < 1e-4 && (place.z + 10.0).abs() < 1e-4, "{place}");
        assert!((place.x - if right { 1.0 } else { -1.0 }).abs() < 1e-4, "{mirror}: {place}");
        assert!(!camera.mirrors());
    }
    // The angle is that of the shorter side.
    let fov = |film: &str, camera: &str| {
        let text = format!(
            "Film \"rgb\" {film} Camera \"perspective\" \"float fov\" 90 {camera} WorldBegin \
             LightSource \"infinite\""
        );
        let loaded = sound(&text);
        let rutilant::camera::Camera::Perspective(camera) = loaded.scene.camera else { panic!() };
        ((0.5 * camera.fov_y).tan(), loaded.settings.size, loaded.settings.crop)
    };
    let sides = |x, y| format!("\"integer xresolution\" {x} \"integer yresolution\" {y}");
    let close = |a: f32, b: f32| (a - b).abs() < 1e-5;
    let (half, size, crop) = fov(&sides(200, 100), "");
    assert!(close(half, 1.0) && size == [200, 100] && crop.is_none());
    assert!(close(fov(&sides(100, 200), "").0, 2.0));
    let (half, size, crop) = fov(&sides(100, 100), "\"float screenwindow\" [ 0 1 0 1 ]");
    assert!(close(half, 1.0) && size == [200, 200]);
    assert_eq!(crop, Some(Crop { x: 100, y: 0, width: 100, height: 100 }));
    let cut = sides(100, 200) + " \"float cropwindow\" [ 0 .5 .25 1 ]";
    assert_eq!(fov(&cut, "").2, Some(Crop { x: 0, y: 50, width: 50, height: 150 }));
    // A lens, in the units of the world where the camera is scaled.
    let loaded = sound(
        "Scale 2 2 2 Camera \"perspective\" \"float lensradius\" .5 \"float focaldistance\" 6 WorldBegin Shape \"sphere\"",
    );
    let lens = loaded.scene.camera.lens().expect("a lens");
    assert!(close(lens.aperture_radius, 0.25) && close(lens.focus_distance, 3.0));
}

/// Skies of pbrt-v3 begin at +x and go on to +y around +z; whatever the camera mirrors, the same
/// directions have the same light.
#[test]
fn skies_stand_where_pbrt_has_them() {
    // The left pixel, which is the half of the sky with y > 0, is grey, the other one is not.
    let [left, right] = [[0.502, 0.502, 0.502], [0.125, 0.25, 0.391]];
    for mirror in ["", "Scale -1 1 1"] {
        for light in ["", "Scale -1 -1 1", "Rotate 180 0 0 1"] {
            for y in [1.0, -1.0] {
                let text = format!(
                    "{mirror} LookAt 0 0 0  0 {y} 0  0 0 1  Camera \"perspective\" \"float fov\" 1 \
                     WorldBegin {light} LightSource \"infinite\" \"string mapname\" \"sky.hdr\""
                );
                let expected = if (y > 0.0) == light.is_empty() { left } else { right };
                let seen = seen(&text);
                let ratio = seen[0] / seen[2];
                assert!((ratio - expected[0] / expected[2]).abs() < 0.05, "{text}: {seen:?}");
            }
        }
        // Towards +x, +y is to the right, unless mirrored.
        let loaded = sound(&format!(
            "{mirror} LookAt 0 0 0  1 0 0  0 0 1  Camera \"perspective\" \"float fov\" 170 \
             WorldBegin LightSource \"infinite\" \"string mapname\" \"sky.hdr\""
        ));
        let pixels = picture(&loaded, [8, 1], 64);
        let grey = |p: [f32; 3]| (p[0] / p[2] - 1.0).abs() < 0.1;
        assert_eq!([grey(pixels[0]), grey(pixels[7])], [!mirror.is_empty(), mirror.is_empty()]);
        // What was mirrored is a picture of its own.
        let made = matches!(loaded.origins.images[0], PictureOrigin::Bytes { .. });
        assert!(made);
    }
}

/// Materials, worked out by hand: α is the square of what is called roughness here, and pbrt's square
/// where it remaps; a body under a surface has the light that goes to and fro in its colour.
#[test]
fn materials_are_what_they_say() {
    let close = |a: f32, b: f32| (a - b).abs() < 2e-3;
    let MaterialKind::Conductor(metal) =
        material("Material \"conductor\" \"float roughness\" .0081").kind
    else {
        panic!()
    };
    // α = √0.0081 = 0.09 = 0.3².
    assert!(close(metal.roughness, 0.3) && close(metal.k.0[0], 5.047), "{metal:?}");
    let MaterialKind::Conductor(metal) =
        material("Material \"conductor\" \"float uroughness\" .01 \"float vroughness\" .04 \"bool remaproughness\" false \
                  \"rgb reflectance\" [ .5 .5 .5 ]").kind
    else { panic!() };
    // α² = (0.01² + 0.04²) / 2. An index of 1 + 2i reflects 4 / 8.
    assert!(
        close(metal.roughness, 0.000_85_f32.sqrt().sqrt()) && close(metal.k.0[1], 2.0),
        "{metal:?}"
    );
    // 0.5 (1 − 0.596) / (1 − 0.5 · 0.596).
    let coated = layers("Material \"coateddiffuse\" \"rgb reflectance\" [ .5 0 1 ]");
    assert!(
        close(coated.base_color.0[0], 0.2876)
            && coated.base_color.0[1] == 0.0
            && close(coated.base_color.0[2], 1.0)
    );
    assert_eq!((coated.roughness, coated.ior), (0.0, 1.5));
    let MaterialKind::Dielectric(glass) =
        material("Material \"dielectric\" \"spectrum eta\" \"glass-BK7\"").kind
    else {
        panic!()
    };
    assert_eq!((glass.interior.ior, glass.dispersion), (1.5168, 20.0 / 64.17));
    let MaterialKind::Dielectric(bubble) =
        material("Material \"dielectric\" \"float eta\" .5").kind
    else {
        panic!()
    };
    assert_eq!((bubble.interior.ior, bubble.exterior.ior), (1.0, 2.0));
    // Reflects 0.2 and passes 0.3 on: of half of them 0.5 · 0.4 and 0.5 · 0.6.
    let leaf = layers(
        "Material \"diffusetransmission\" \"rgb reflectance\" [ .2 .1 0 ] \"rgb transmittance\" [ .3 0 0 ]",
    );
    let (share, back, on) =
        (leaf.diffuse_transmission, leaf.base_color.0, leaf.diffuse_transmission_color.0);
    assert!(
        close((1.0 - share) * back[0], 0.2)
            && close((1.0 - share) * back[1], 0.1)
            && close(share * on[0], 0.3)
    );
    assert!(leaf.thin_walled && leaf.specular == 0.0);
    // A medium that only absorbs.
    let tea = "MakeNamedMedium \"tea\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [ 1 2 3 ] \
               \"rgb sigma_s\" [ 0 0 0 ] \"float scale\" 2 MediumInterface \"tea\" \"\" Material";
    for kind in ["dielectric", "interface"] {
        let MaterialKind::Dielectric(glass) = material(&format!("{tea} \"{kind}\"")).kind else {
            panic!()
        };
        assert_eq!(glass.interior.absorption, Absorption::Coefficient(Rgb::new(2.0, 4.0, 6.0)));
        assert_eq!(glass.exterior.absorption, Absorption::None);
    }
    // Mixtures: of the amount there is the second, before pbrt-v4 the first.
    let two = "MakeNamedMaterial \"a\" \"string type\" \"diffuse\" MakeNamedMaterial \"b\" \"string type\" \"conductor\" Material \"mix\" \"float amount\" .25";
    let MaterialKind::Mix(mix) =
        material(&format!("{two} \"string materials\" [ \"a\" \"b\" ]")).kind
    else {
        panic!()
    };
    assert_eq!(mix.amount, 0.25);
    let MaterialKind::Mix(mix) =
        material(&format!("{two} \"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"b\""))
            .kind
    else {
        panic!()
    };
    assert_eq!(mix.amount, 0.75);
    let holes = material(&format!("{two} \"string materials\" [ \"a\" \"interface\" ]"));
    assert_eq!(holes.opacity.expect("holes").amount.factor, 0.75);
    // Those of pbrt-v3: Ks is what a substrate reflects straight on, 0.04 for an index of 1.5.
    let paint = layers(
        "Material \"substrate\" \"rgb Ks\" [ .04 .04 .04 ] \"rgb Kd\" [ .1 .2 .3 ] \"bool remaproughness\" \"false\" \"float uroughness\" .04 \"float vroughness\" .04",
    );
    assert!(
        close(paint.specular_color.0[0], 1.0)
            && close(paint.roughness, 0.2)
            && paint.base_color.0 == [0.1, 0.2, 0.3]
    );
    assert!(
        matches!(material("Material \"mirror\"").kind, MaterialKind::Mirror(m) if m.reflectance == Rgb::grey(0.9))
    );
    let MaterialKind::Matte(matte) = material("Material \"matte\" \"float sigma\" 45").kind else {
        panic!()
    };
    assert!(close(matte.roughness, 0.5));
    assert!(matches!(
        material("Material \"diffuse\" \"rgb reflectance\" [ 0 0 0 ]").kind,
        MaterialKind::Black
    ));
    assert!(matches!(material("Material \"none\"").kind, MaterialKind::Null));
}

/// Names mean what was declared last before them; shapes keep the material that they found.
#[test]
fn names_mean_the_last_before() {
    let loaded = sound(
        "MakeNamedMaterial \"a\" \"string type\" \"diffuse\" \"rgb reflectance\" .1 NamedMaterial \"a\" \
         Shape \"sphere\" MakeNamedMaterial \"a\" \"string type\" \"diffuse\" \"rgb reflectance\" .2 \
         Shape \"sphere\" NamedMaterial \"a\" Shape \"sphere\" NamedMaterial \"b\" Shape \"sphere\" \
         AttributeBegin Material \"mirror\" AttributeEnd Shape \"sphere\" \
         MakeNamedMaterial \"b\" \"string type\" \"thindielectric\" Attribute \"shape\" \"float radius\" 3 Shape \"sphere\"",
    );
    let color = |i: usize| match &loaded.scene.materials
        [loaded.scene.objects[i].material.0 as usize]
        .kind
    {
        MaterialKind::Matte(matte) => Some(matte.albedo.factor.0[0]),
        _ => None,
    };
    assert_eq!([color(0), color(1), color(2)], [Some(0.1), Some(0.1), Some(0.2)]);
    assert_eq!(color(3), None);
    assert_eq!(loaded.scene.objects[4].material, loaded.scene.objects[3].material);
    assert_eq!(loaded.scene.objects[5].shape, Shape::Sphere { radius: 3.0 });
}

/// Textures come down to a factor and a picture or a checker.
#[test]
fn textures_come_down_to_factors() {
    let of = |texture: &str| {
        let loaded = sound(&format!(
            "Texture \"board\" \"spectrum\" \"checkerboard\" \"rgb tex1\" [ .2 .4 .6 ] \"rgb tex2\" .5 \
             \"float uscale\" 8 \"float vscale\" 4 \"float udelta\" 1 \
             Texture \"half\" \"spectrum\" \"constant\" \"rgb value\" .5 \
             Texture \"sky\" \"spectrum\" \"imagemap\" \"string filename\" \"sky.hdr\" \"float scale\" .5 \
             Texture \"t\" \"spectrum\" {texture} Material \"diffuse\" \"texture reflectance\" \"t\" Shape \"sphere\""
        ));
        let id = loaded.scene.objects[0].material.0 as usize;
        let MaterialKind::Matte(matte) = loaded.scene.materials[id].kind.clone() else {
            panic!("{texture}")
        };
        let texture = matte.albedo.texture.map(|id| loaded.scene.textures[id.0 as usize].clone());
        (matte.albedo.factor, texture, loaded)
    };
    let (factor, texture, _) = of("\"scale\" \"texture tex\" \"board\" \"float scale\" .5");
    assert_eq!(factor, Rgb::grey(0.5));
    let Some(Texture::Checker(Checker { first, second, mapping })) = texture else { panic!() };
    assert_eq!((first, second), (Rgb::new(0.2, 0.4, 0.6), Rgb::grey(0.5)));
    // Two of our squares are as long as one of pbrt's.
    assert_eq!((mapping.scale, mapping.offset), (Vec2::new(4.0, 2.0), Vec2::new(0.5, 0.0)));
    let (factor, texture, _) = of("\"mix\" \"rgb tex1\" .2 \"rgb tex2\" .6 \"float amount\" .75");
    assert!((factor.0[0] - 0.5).abs() < 1e-6 && texture.is_none());
    let (factor, texture, _) = of("\"scale\" \"texture tex\" \"sky\" \"float scale\" .5");
    assert!(factor == Rgb::grey(0.25) && matches!(texture, Some(Texture::Image(_))));
    let (factor, texture, _) = of("\"scale\" \"texture tex1\" \"half\" \"texture tex2\" \"board\"");
    assert!(factor == Rgb::grey(0.5) && matches!(texture, Some(Texture::Checker(_))));
    let (_, texture, loaded) = of("\"marble\"");
    assert!(
        texture.is_none()
            && loaded.notes.iter().any(|note| note.contains("\"marble\" are not made"))
    );
}

/// A picture below a surface is changed value by value as a colour is; it has bytes of its own.
#[test]
fn pictures_below_surfaces_are_changed() {
    let loaded = sound(
        "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"sky.hdr\" Material \"coateddiffuse\" \
         \"texture reflectance\" \"t\" Shape \"sphere\"",
    );
    let rutilant::texture::Texels::Float(values) = loaded.scene.bitmaps[1].texels() else {
        panic!()
    };
    let rutilant::texture::Texels::Float(before) = loaded.scene.bitmaps[0].texels() else {
        panic!()
    };
    for (value, before) in values.iter().zip(before) {
        let before = before.min(1.0);
        // What a surface of index 1.5 sends back of diffuse light from inside is 0.5964.
        let expected = before * (1.0 - 0.5964) / (1.0 - 0.5964 * before);
        assert!((value - expected).abs() < 1e-3, "{value} {expected}");
    }
    assert!(
        matches!(&loaded.origins.bitmaps[1], PictureOrigin::Bytes { title, .. } if title == "sky-changed")
    );
}

/// Objects stand where their instances are, each mesh once; what glows does not as an object.
#[test]
fn objects_are_placed() {
    let loaded = sound(
        "ObjectBegin \"a\" Translate 1 0 0 AreaLightSource \"diffuse\" Shape \"trianglemesh\" \"point3 P\" \
         [ 0 0 0 1 0 0 0 1 0 ] ObjectEnd Scale 2 2 2 ObjectInstance \"a\" Translate 0 5 0 ObjectInstance \"a\"",
    );
    assert_eq!((loaded.scene.meshes.len(), loaded.scene.objects.len()), (1, 2));
    let at = |i: usize| loaded.scene.objects[i].world_from_object.translation();
    assert_eq!([at(0), at(1)], [Vec3::new(2.0, 0.0, 0.0), Vec3::new(2.0, 10.0, 0.0)]);
    assert!(loaded.scene.materials.iter().all(|material| material.emission.is_none()));
    assert!(loaded.notes.iter().any(|note| note.contains("does not glow")));
}

/// How pictures are made.
#[test]
fn settings_are_read() {
    let settings = |text: &str| sound(&format!("{text} LightSource \"infinite\"")).settings;
    let usual = settings("");
    assert_eq!((usual.size, usual.spp, usual.max_depth), ([1280, 720], 16, Some(6)));
    assert_eq!(usual.filter, Filter::Gaussian { radius: 1.5, sigma: 0.5 });
    let old = settings("WorldBegin WorldEnd");
    assert_eq!((old.size, old.filter), ([640, 480], Filter::Box { radius: 0.5 }));
    let all = settings(
        "Sampler \"stratified\" \"integer xsamples\" 3 \"integer ysamples\" 5 Integrator \"ao\" \
         PixelFilter \"gaussian\" \"float alpha\" 2 \"float xwidth\" 3 \"float ywidth\" 3",
    );
    assert_eq!((all.spp, all.integrator), (15, IntegratorKind::AmbientOcclusion));
    assert_eq!(all.filter, Filter::Gaussian { radius: 3.0, sigma: 0.5 });
    let random = settings(
        "Sampler \"independent\" \"integer pixelsamples\" 7 Integrator \"path\" \"integer maxdepth\" 0",
    );
    assert_eq!(
        (random.spp, random.sampler, random.max_depth),
        (7, SamplerKind::Independent, Some(1))
    );
}

/// Lights stand where they are told.
#[test]
fn lights_stand_in_the_world() {
    let loaded = sound(
        "Scale -1 1 1 Camera \"perspective\" WorldBegin Translate 1 2 3 LightSource \"spot\" \"point3 from\" \
         [ 0 0 1 ] \"point3 to\" [ 0 5 1 ] \"float coneangle\" 40 \"float conedeltaangle\" 10 \
         LightSource \"infinite\" \"rgb L\" .5 LightSource \"infinite\" \"rgb L\" [ 1 2 3 ]",
    );
    let Light::Spot { position, direction, light, inner, outer, group: None } =
        loaded.scene.lights[0]
    else {
        panic!()
    };
    assert_eq!((position, direction), (Vec3::new(1.0, 2.0, 4.0), Vec3::Y));
    assert_eq!(light, SpotLight::Intensity(Rgb::WHITE));
    assert_eq!((inner, outer), (30_f32.to_radians(), 40_f32.to_radians()));
    let sky = loaded.scene.environment.expect("a sky");
    assert_eq!(sky.light, EnvironmentLight::Constant(Rgb::new(1.5, 2.5, 3.5)));
}

/// Mattes go by names that people gave: a shape goes by its material, a part of an object behind that
/// of the object, which is its asset; slashes within a name make no further asset.
#[test]
fn things_go_by_the_names_they_were_given() {
    let loaded = sound(
        "MakeNamedMaterial \"oak\" \"string type\" \"diffuse\" Material \"diffuse\" Shape \"disk\" \
         NamedMaterial \"oak\" Shape \"sphere\" \
         ObjectBegin \"garden/tree\" Shape \"sphere\" Material \"diffuse\" Shape \"disk\" ObjectEnd \
         ObjectInstance \"garden/tree\" Translate 3 0 0 ObjectInstance \"garden/tree\"",
    );
    let scene = &loaded.scene;
    let names: Vec<_> =
        (0..scene.objects.len()).map(|i| cryptomatte::object_name(scene, i)).collect();
    let tree = ["gardentree/oak", "gardentree"];
    let expected = ["object 1", "oak", tree[0], tree[1], tree[0], tree[1]];
    assert_eq!(names, expected);
    let assets: Vec<_> = names.iter().map(|name| cryptomatte::asset_of(name)).collect();
    assert_eq!(assets[2..], ["gardentree"; 4]);
}
