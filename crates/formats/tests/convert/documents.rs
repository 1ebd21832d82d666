//! glTF documents with everything that a native scene must not lose.

use crate::builder::Builder;
use crate::{assert_same, converted, read};
use image::{ExtendedColorType, ImageEncoder};
use rutilant::light::Light;
use rutilant::shape::Shape;
use rutilant_formats::{ConvertOptions, ReadOptions, convert, read_scene};
use serde_json::json;
use std::collections::HashSet;
use std::fs;

/// A picture of four texels.
fn png(shade: u8) -> Vec<u8> {
    let mut png = Vec::new();
    let encoder = image::codecs::png::PngEncoder::new(&mut png);
    let texels: Vec<u8> = (0..16).map(|i| shade.wrapping_mul(i + 3) | 64).collect();
    encoder.write_image(&texels, 2, 2, ExtendedColorType::Rgba8).expect("encoded");
    png
}

/// A slanted square with normals, tangents, two sets of coordinates (the second in a way of its own)
/// and colours; two materials with pictures in all roles; lights, cameras, and seven nodes.
pub(crate) fn everything() -> Builder {
    let mut b = Builder::new();
    let normal = b.floats("VEC3", &[0., 0., 1., 0., 0.1, 0.9, 0.1, 0., 1., 0., 0., 1.]);
    let tangent =
        b.floats("VEC4", &[1., 0., 0., 1., 1., 0., 0., 1., 1., 0.1, 0., 1., 1., 0., 0., -1.]);
    let uv = b.floats("VEC2", &[0., 0., 1., 0., 1., 1., 0., 1.]);
    let other = b.floats("VEC2", &[0.5, 0., 1.5, 0.2, 1., 1., 0., 0.9]);
    let color =
        b.floats("VEC4", &[1., 0.5, 0.2, 1., 0.3, 1., 1., 0.7, 1., 1., 1., 0.9, 1., 0., 1., 1.]);
    let index = b.shorts("SCALAR", 6, &[0, 1, 2, 0, 2, 3]);
    // Each mesh differs a little from the others, in its last corner.
    let names = ["Body", "../x", "a/b", "", "con", &"n".repeat(300), "木 body"];
    for (i, name) in names.into_iter().enumerate() {
        let corner = 1.0 + 0.01 * i as f32;
        let place = b.floats("VEC3", &[-1., -1., 0., 1., -1., 0.2, 1., 1., 0., -1., corner, -0.1]);
        let plain = json!({"POSITION": place, "NORMAL": normal, "TEXCOORD_0": uv});
        let full = json!({"POSITION": place, "NORMAL": normal, "TANGENT": tangent,
            "TEXCOORD_0": uv, "TEXCOORD_2": other, "COLOR_0": color});
        let part = |attributes: &serde_json::Value, material: Option<u32>| {
            let mut part = json!({"attributes": attributes, "indices": index});
            if let Some(material) = material {
                part["material"] = json!(material);
            }
            part
        };
        let parts = match i {
            0 => vec![part(&full, Some(0)), part(&plain, Some(1))],
            1 => vec![part(&plain, Some(2))],
            2 => vec![part(&plain, Some(3))],
            3 => vec![part(&plain, None)],
            _ => vec![part(&full, Some(i as u32 - 4))],
        };
        b.push("meshes", json!({"name": name, "primitives": parts}));
    }
    for (shade, name) in [(7, "../x"), (31, "a\"b\n"), (93, "")] {
        let view = b.view(&png(shade));
        b.push("images", json!({"bufferView": view, "mimeType": "image/png", "name": name}));
    }
    b.json["samplers"] = json!([{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728}]);
    b.json["textures"] =
        json!([{"source": 0}, {"source": 1, "sampler": 0}, {"source": 2}, {"source": 0}]);
    let turned = json!({"KHR_texture_transform": {"offset": [0.3, -0.7], "rotation": 0.61,
        "scale": [2.0, -1.5], "texCoord": 2}});
    b.json["materials"] = json!([
        {"name": "skin", "alphaMode": "MASK", "alphaCutoff": 0.37, "doubleSided": true,
         "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "baseColorFactor": [1, 0.5, 0.25, 0.9],
            "metallicRoughnessTexture": {"index": 1, "texCoord": 2}, "metallicFactor": 0.7},
         "normalTexture": {"index": 2, "scale": 0.8},
         "emissiveTexture": {"index": 3, "extensions": turned}, "emissiveFactor": [0.1, 0.2, 0.3]},
        {"name": "skin", "alphaMode": "BLEND",
         "pbrMetallicRoughness": {"baseColorFactor": [0.2, 0.3, 0.4, 0.5]},
         "extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 0.3,
            "clearcoatTexture": {"index": 2}}, "KHR_materials_anisotropy":
            {"anisotropyStrength": 0.4, "anisotropyRotation": 0.77}}},
        {"name": "", "pbrMetallicRoughness": {"baseColorTexture": {"index": 2}},
         "extensions": {"KHR_materials_unlit": {}}, "alphaMode": "BLEND"},
        {"name": "\u{1f600} \"quoted\"\n", "extensions": {"KHR_materials_volume":
            {"thicknessFactor": 0.2, "attenuationDistance": 0.7, "attenuationColor": [0.2, 0.9, 0.4]},
            "KHR_materials_transmission": {"transmissionFactor": 1.0},
            "KHR_materials_ior": {"ior": 1.33}, "KHR_materials_sheen":
            {"sheenColorFactor": [0.1, 0.2, 0.3], "sheenRoughnessFactor": 0.6}},
         "pbrMetallicRoughness": {"roughnessFactor": 0.0, "metallicFactor": 0.0}},
    ]);
    b.json["cameras"] = json!([
        {"name": "eye", "type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}},
        {"name": "eye", "type": "orthographic",
         "orthographic": {"xmag": 2, "ymag": 1.5, "zfar": 10, "znear": 0.1}},
    ]);
    b.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    b.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "point", "intensity": 30, "color": [1, 0.9, 0.8]},
        {"type": "directional", "intensity": 2},
        {"type": "spot", "intensity": 90,
         "spot": {"innerConeAngle": 0.301, "outerConeAngle": 0.5077}},
    ]}});
    let light = |i: u32| json!({"KHR_lights_punctual": {"light": i}});
    let half = std::f32::consts::FRAC_1_SQRT_2;
    b.json["nodes"] = json!([
        {"mesh": 0}, {"mesh": 0, "translation": [2.5, 0, 0]},
        {"mesh": 0, "rotation": [0, half, 0, half], "translation": [-2, 0, 0]},
        {"mesh": 1, "scale": [-1, 1, 2], "translation": [0, -2.5, 0]},
        {"mesh": 2, "translation": [0, 2.5, 0]}, {"mesh": 3, "translation": [2.5, 2.5, 0]},
        {"mesh": 4, "translation": [-2.5, 2.5, 0]}, {"mesh": 5, "translation": [2.5, -2.5, 0]},
        {"mesh": 6, "matrix": [0.8, 0.1, 0, 0, -0.1, 0.7, 0, 0, 0, 0.2, 1, 0, -2.5, -2.5, -0.0, 1]},
        {"camera": 0, "translation": [0, 0, 9]}, {"camera": 1, "translation": [0, 1, 9]},
        {"extensions": light(0), "translation": [1, 2, 4]}, {"extensions": light(1)},
        {"extensions": light(2), "translation": [0, 0, 6]},
    ]);
    b.json["scenes"] = json!([{"nodes": (0..14).collect::<Vec<_>>()}]);
    b
}

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
    let options = ReadOptions { camera: Some("plan"), ..ReadOptions::default() };
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
