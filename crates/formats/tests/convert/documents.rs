//! glTF documents with everything that a native scene must not lose.

use crate::builder::Builder;
use crate::everything::{everything, png};
use crate::{assert_same, converted, read};
use rutilant::light::Light;
use rutilant::shape::Shape;
use rutilant_formats::{CameraChoice, ConvertOptions, ReadOptions, convert, read_scene};
use serde_json::json;
use std::collections::HashSet;
use std::fs;

/// All of it is there again, in text that shows the same picture to the bit, whichever form the document
/// has; names are those of the document as far as names can be, and pictures keep their bytes.
#[test]
fn documents_survive() {
    for file in ["model.glb", "model.gltf"] {
        let folder = tempfile::tempdir().expect("a folder");
        let (from, to) = (folder.path().join(file), folder.path().join("new.toml"));
        let document = everything();
        match file {
            "model.glb" => fs::write(&from, document.binary()),
            _ => fs::write(&from, document.text()),
        }
        .expect("written");
        let (before, new) = converted(&from, &to, false);
        assert_eq!(before.notes, [""; 0]);
        let paths = new.write(&to, false).expect("written");
        assert_eq!(paths.last(), Some(&to));
        let after = read(&to);
        assert_same(&before, &after, file);
        assert_eq!(after.notes, [""; 0]);

        // Names; with and without vertex colours a material is two.
        let names: Vec<_> = after.scene.materials.iter().map(|m| m.name.as_str()).collect();
        let faces = "\u{1f600} \"quoted\"\n";
        assert_eq!(
            names,
            ["skin", "skin 2", "material", faces, "material 2", "skin 3", "material 3"]
        );
        let cameras: Vec<_> = after.cameras.iter().map(|camera| camera.name.as_str()).collect();
        assert_eq!(cameras, ["eye", "eye 2"]);
        let mut seen = HashSet::new();
        for asset in &new.assets {
            let name = asset.name.strip_prefix("new_assets/").expect("in the folder");
            let (stem, extension) = name.split_once('.').expect("an extension");
            let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
            assert!(!stem.is_empty() && stem.len() < 60 && stem.chars().all(plain), "{name}");
            assert!(["ply", "png"].contains(&extension), "{name}");
            assert!(!stem.eq_ignore_ascii_case("con"), "{name}");
            assert!(seen.insert(name.to_lowercase()), "{name}");
        }
        for shade in [7, 31, 93] {
            let same = |path: &std::path::PathBuf| fs::read(path).expect("a file") == png(shade);
            assert_eq!(paths.iter().filter(|path| same(path)).count(), 1, "{shade}");
        }

        let stem = |stem: &str| seen.iter().filter(|name| name.starts_with(stem)).count();
        let stems = ["body.", "body_2.", "x.", "a_b.", "material_2.", "con_.", "nnnnn"].map(stem);
        // Two of them are those of pictures as well.
        assert_eq!(stems, [1, 1, 2, 2, 1, 1, 1], "{seen:?}");

        // A mesh that stands in three places is one shape, and its picture in two roles one texture.
        assert_eq!(new.text.matches("Body.ply").count(), 1, "{}", new.text);
        assert_eq!(new.text.matches("\n  {").count(), 6, "{}", new.text);
        assert_eq!(new.text.matches("[[texture]]").count(), 5, "{}", new.text);
    }
}

/// What was asked for when the document was read is what is written: the camera that sees it comes
/// first.
#[test]
fn the_chosen_camera_comes_first() {
    let folder = tempfile::tempdir().expect("a folder");
    let (from, to) = (folder.path().join("a.glb"), folder.path().join("a.toml"));
    let mut document = everything();
    document.json["cameras"][1]["name"] = json!("plan");
    fs::write(&from, document.binary()).expect("written");
    let camera = CameraChoice::Named("plan".to_owned());
    let options = ReadOptions { camera: &camera, ..ReadOptions::default() };
    let before = read_scene(&from, &options).expect("a scene");
    let new = convert(&before, &from, &to, &ConvertOptions::default()).expect("converted");
    new.write(&to, false).expect("written");
    let after = read(&to);
    assert_same(&before, &after, "plan");
    let names: Vec<_> = after.cameras.iter().map(|camera| camera.name.as_str()).collect();
    assert_eq!((names, after.camera), (vec!["plan", "eye"], 0));
}

/// Angles in radians come through degrees unchanged, all of them.
#[test]
fn angles_survive() {
    let folder = tempfile::tempdir().expect("a folder");
    let (from, to) = (folder.path().join("a.glb"), folder.path().join("a.toml"));
    let mut document = Builder::triangle();
    let mut random = crate::common::Random(5);
    let lights: Vec<_> = (0..200)
        .map(|_| {
            let outer = 0.01 + 1.5 * random.unit();
            let cone = json!({"innerConeAngle": outer * random.unit(), "outerConeAngle": outer});
            json!({"type": "spot", "spot": cone})
        })
        .collect();
    for i in 0..lights.len() {
        document.push("nodes", json!({"extensions": {"KHR_lights_punctual": {"light": i}}}));
    }
    document.json["scenes"] = json!([{"nodes": (0..201).collect::<Vec<_>>()}]);
    document.json["extensions"] = json!({"KHR_lights_punctual": {"lights": lights}});
    fs::write(&from, document.binary()).expect("written");
    let (before, new) = converted(&from, &to, false);
    new.write(&to, false).expect("written");
    let after = read(&to);
    for (light, (was, wanted)) in
        after.scene.lights.iter().zip(before.scene.lights.iter().zip(&lights))
    {
        assert_eq!(light, was);
        let Light::Spot { outer, .. } = light else { panic!("{light:?}") };
        let wanted = wanted["spot"]["outerConeAngle"].as_f64().expect("a number");
        assert!((f64::from(*outer) - wanted).abs() < 2e-7, "{outer} for {wanted}");
    }
}

/// Many places of one mesh stand in a file of their own, with few numbers where it is only moved.
#[test]
fn forests_survive() {
    for turned in [false, true] {
        let folder = tempfile::tempdir().expect("a folder");
        let (from, to) = (folder.path().join("a.glb"), folder.path().join("a.toml"));
        let mut document = Builder::triangle();
        for i in 1..40 {
            let turn =
                if turned && i % 2 == 0 { [0.0, 0.6, 0.0, 0.8] } else { [0.0, 0.0, 0.0, 1.0] };
            document.push(
                "nodes",
                json!({"mesh": 0, "translation": [i % 7, i / 7, 0.1], "rotation": turn}),
            );
        }
        document.json["scenes"] = json!([{"nodes": (0..40).collect::<Vec<_>>()}]);
        fs::write(&from, document.binary()).expect("written");
        let (before, new) = converted(&from, &to, false);
        new.write(&to, false).expect("written");
        let after = read(&to);
        assert_same(&before, &after, "a forest");
        assert_eq!((new.text.matches("[[shape]]").count(), after.scene.meshes.len()), (1, 1));
        let places = new.assets.iter().find(|asset| asset.name.ends_with(".txt")).expect("places");
        let places = places.content.bytes().expect("bytes").into_owned();
        let text = String::from_utf8(places).expect("text");
        assert_eq!(text.lines().count(), 40);
        let numbers = if turned { 12 } else { 3 };
        assert!(text.lines().all(|line| line.split(' ').count() == numbers), "{text}");
        assert!(after.scene.objects.iter().all(|object| matches!(object.shape, Shape::Mesh(_))));
    }
}
