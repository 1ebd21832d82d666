//! A document with everything that a scene must not lose.

use crate::builder::Builder;
use image::{ExtendedColorType, ImageEncoder};
use serde_json::json;

/// A picture of four texels.
pub(crate) fn png(shade: u8) -> Vec<u8> {
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
