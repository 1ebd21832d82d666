//! Cameras in their author's words: several in a scene, and the way to text and back.

use crate::parse;
use rutilant::camera::Camera;
use rutilant::geom::Vec3;
use rutilant_formats::camera::{
    AngleOfView, Aperture, AuthoredCamera, AuthoredLens, CameraKind, FocusOn,
};
use rutilant_formats::{CameraChoice, LoadedScene, ReadOptions, SceneError, parse_native};
use std::path::Path;

#[path = "../common/mod.rs"]
mod common;
use common::Random;

const TWO: &str = r#"version = 1
[[camera]]
name = "front"
position = [0, 0, 5]
look_at = [0, 0, 0]
[[camera]]
name = "top"
position = [0, 5, 0]
look_at = [0, 0, 0]
type = "orthographic"
height = 3
"#;

fn seen_by(text: &str, camera: Option<&str>) -> Result<LoadedScene, SceneError> {
    let choice = camera.map(|name| CameraChoice::Named(name.to_owned())).unwrap_or_default();
    let options = ReadOptions { camera: &choice, ..ReadOptions::default() };
    parse_native(text, Path::new("scene.toml"), &options)
}

/// A chosen camera comes after those of the scene, which stay, and sees everything; nothing is
/// said, for nothing is missing.
#[test]
fn a_camera_is_chosen_for_all_shapes() {
    let balls = "[[material]]\nname = \"m\"\ntype = \"matte\"\n\
        [[shape]]\ntype = \"sphere\"\nmaterial = \"m\"\nradius = 1\ncenter = [-70, 3, 9]\n\
        [[shape]]\ntype = \"sphere\"\nmaterial = \"m\"\nradius = 2\ncenter = [40, 8, -5]\n";
    let options = ReadOptions { camera: &CameraChoice::Auto, ..ReadOptions::default() };
    let text = format!("{TWO}{balls}");
    let loaded = parse_native(&text, Path::new("scene.toml"), &options).expect("a scene");
    let names: Vec<_> = loaded.cameras.iter().map(|camera| camera.name.as_str()).collect();
    assert_eq!((loaded.camera, &names[..]), (2, &["front", "top", ""][..]));
    assert_eq!(loaded.notes, [""; 0]);
    let [width, height] = loaded.settings.size;
    let Camera::Perspective(camera) = loaded.scene.camera else { panic!("no perspective") };
    let up = (0.5 * camera.fov_y).tan();
    let across = up * width as f32 / height as f32;
    let view = camera.world_from_camera.inverse().expect("an inverse");
    for (center, radius) in [([-70.0, 3.0, 9.0], 1.0), ([40.0, 8.0, -5.0], 2.0)] {
        let center = view.point(center.into());
        assert!(center.x.abs() + radius < across * (-center.z - radius), "{center}");
        assert!(center.y.abs() + radius < up * (-center.z - radius), "{center}");
    }
    let error = parse_native(TWO, Path::new("scene.toml"), &options).expect_err("no shape");
    let said = "scene.toml:1:1: no camera can be chosen: no shape that one could be turned to";
    assert_eq!(error.to_string(), said);
}

/// The first camera sees the scene, or the one that is asked for; all are there either way.
#[test]
fn a_camera_is_chosen_by_its_name() {
    for (asked, used) in [(None, 0), (Some("front"), 0), (Some("top"), 1), (Some("2"), 1)] {
        let loaded = seen_by(TWO, asked).expect("a scene");
        let names: Vec<_> = loaded.cameras.iter().map(|camera| camera.name.as_str()).collect();
        assert_eq!((loaded.camera, &names[..]), (used, &["front", "top"][..]));
        let camera = loaded.cameras[used].camera(loaded.settings.size).expect("a camera");
        assert_eq!(loaded.scene.camera, camera);
    }
}

/// What is not there is said with what is.
#[test]
fn unknown_cameras_are_explained() {
    let one = TWO.split("[[camera]]").take(2).collect::<Vec<_>>().join("[[camera]]");
    let nameless = one.replace("name = \"front\"\n", "");
    for (text, asked, said) in [
        (TWO, "frnt", r#"scene.toml: no camera "frnt"; did you mean "front"?"#),
        (TWO, "left side", r#"scene.toml: no camera "left side"; there are front, top"#),
        (&one, "left side", r#"scene.toml: no camera "left side"; there is only front"#),
        (&nameless, "02", r#"scene.toml: no camera "02"; there is only number 1"#),
        (TWO, "3", r#"scene.toml: no camera "3"; there are front, top"#),
    ] {
        let error = seen_by(text, Some(asked)).expect_err(asked).to_string();
        assert_eq!(error, said);
    }
}

/// Whichever camera sees the scene, a mistake in any of them is one of the scene.
#[test]
fn every_camera_must_be_sound() {
    for (from, to, said) in [
        ("height = 3", "height = 0", "11:10: height is 0, but must be more than 0"),
        ("height = 3", "heigt = 3", r#"11:1: no key "heigt"; did you mean "height"?"#),
        ("\"top\"", "\"front\"", r#"7:8: there is another camera "front"; names must differ"#),
        (
            "\"top\"",
            "\"\"",
            "7:8: name is empty, but where there are several cameras each needs one",
        ),
        ("name = \"top\"\n", "", r#"6:1: [[camera]] needs "name""#),
        ("position = [0, 5, 0]", "", r#"6:1: an orthographic [camera] needs "position""#),
        (
            "position = [0, 5, 0]",
            "position = [0, 0, 0]",
            "6:1: the camera has no direction: position and look_at are the same point, or too far apart",
        ),
    ] {
        let text = TWO.replacen(from, to, 1);
        for asked in [None, Some("front")] {
            let error = seen_by(&text, asked).expect_err(to).to_string();
            assert_eq!(error, format!("scene.toml:{said}"));
        }
    }
    let error = parse("version = 1\ncamera = [5]").expect_err("no table").to_string();
    assert_eq!(error, "scene.toml:2:11: camera must be a table, not the number 5");
}

/// Any finite number, of any size, with all its digits.
fn any(random: &mut Random) -> f32 {
    let scale = 10.0_f32.powi(random.below(9) as i32 - 4);
    let number = (random.unit() * 2.0 - 1.0) * scale;
    if random.below(4) == 0 { number.round() } else { number }
}

fn point(random: &mut Random) -> Vec3 {
    Vec3::new(any(random), any(random), any(random))
}

fn lens(random: &mut Random, perspective: bool) -> AuthoredLens {
    AuthoredLens {
        aperture: match random.below(3) {
            0 => Aperture::Radius(0.0),
            1 if perspective => Aperture::FNumber(0.5 + 20.0 * random.unit()),
            _ => Aperture::Radius(random.unit() * 0.01),
        },
        focus: match random.below(4) {
            0 => FocusOn::LookAt,
            1 => FocusOn::Distance(0.1 + any(random).abs()),
            2 => FocusOn::Point(point(random)),
            _ => FocusOn::Pixel([random.below(800) as u32, random.below(600) as u32]),
        },
        blades: [0, 0, 3, 6, 100][random.below(5)],
        blade_rotation_degrees: [0.0, -0.0, any(random)][random.below(3)],
        aperture_ratio: [1.0, 0.5 + random.unit()][random.below(2)],
    }
}

fn camera(random: &mut Random) -> AuthoredCamera {
    AuthoredCamera {
        name: ["", "front", "a \"b\"\n\\ é"][random.below(3)].to_owned(),
        position: point(random),
        look_at: point(random),
        up: [Vec3::Y, Vec3::Z * 1e30, point(random)][random.below(3)],
        kind: match random.below(4) {
            0 => CameraKind::Equirectangular,
            1 => CameraKind::Orthographic {
                height: 0.1 + any(random).abs(),
                lens: lens(random, false),
            },
            _ => CameraKind::Perspective {
                view: match random.below(3) {
                    0 => AngleOfView::FovDegrees(45.0),
                    1 => AngleOfView::FovDegrees(1.0 + 170.0 * random.unit()),
                    _ => AngleOfView::FocalLengthMm(5.0 + 200.0 * random.unit()),
                },
                sensor_height_mm: [24.0, 5.0 + 30.0 * random.unit()][random.below(2)],
                lens: lens(random, true),
            },
        },
    }
}

/// A camera that is written and read is the same camera, in words and in bits.
#[test]
fn cameras_survive_the_way_through_text() {
    let mut random = Random(11);
    let mut count = 0;
    for _ in 0..6000 {
        let camera = camera(&mut random).meant();
        // A point that is not in front of the camera is no focus.
        let Ok(expected) = camera.camera([800, 600]) else { continue };
        let text = format!("version = 1\n\n{}", camera.to_toml());
        let loaded = match parse(&text) {
            Ok(loaded) => loaded,
            Err(error) => {
                assert!(error.to_string().contains("the lens has a radius"), "{error}\n{text}");
                continue;
            }
        };
        count += 1;
        // Their words in Rust tell −0 from 0.
        assert_eq!(format!("{:?}", loaded.cameras), format!("{:?}", [camera]), "{text}");
        assert_eq!(format!("{:?}", loaded.scene.camera), format!("{expected:?}"), "{text}");
    }
    assert!(count > 4000, "{count}");
}

/// What goes without saying is not said.
#[test]
fn written_cameras_are_short() {
    let camera = AuthoredCamera::perspective(Vec3::new(0.0, 1.2, 4.0), Vec3::ZERO, 35.0);
    let text = "[camera]\nposition = [0, 1.2, 4]\nlook_at = [0, 0, 0]\nfov_degrees = 35\n";
    assert_eq!(camera.to_toml(), text);
}
