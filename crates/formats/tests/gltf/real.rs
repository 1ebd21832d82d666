//! Documents of other people, as far as they are there: `RUTILANT_DATA` names the folder that has
//! them in `gltf`.

use rutilant::Prepared;
use rutilant::camera::Orthographic;
use rutilant::color::Rgb;
use rutilant::light::Environment;
use rutilant::scene::Scene;
use rutilant::session::Session;
use rutilant::settings::Settings;
use rutilant::shape::{Object, Shape};
use rutilant_formats::ReadOptions;
use rutilant_formats::scene::gltf::{self, Document};
use rutilant_geom::{Vec2, Vec3};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

/// The folder of documents; `None`, said aloud, where there is none.
fn folder() -> Option<PathBuf> {
    let data = std::env::var_os("RUTILANT_DATA").map(|data| Path::new(&data).join("gltf"));
    let folder = data.filter(|folder| folder.is_dir());
    if folder.is_none() {
        eprintln!("skipped: RUTILANT_DATA names no folder with gltf");
    }
    folder
}

/// The document as its author wrote it.
fn json(bytes: &[u8]) -> Value {
    let text = match bytes {
        [b'g', b'l', b'T', b'F', ..] => {
            let length = u32::from_le_bytes([bytes[12], bytes[13], bytes[14], bytes[15]]);
            &bytes[20..20 + length as usize]
        }
        _ => bytes,
    };
    serde_json::from_slice(text).expect("JSON")
}

/// Meshes, triangles, materials, textures, and what the scene places; triangles by the counts of
/// their accessors.
fn counts(document: &Document) -> [usize; 5] {
    let primitives = document.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let placed = document.placed(None, &document.pose(None)).expect("finite");
    [
        document.meshes.len(),
        primitives.map(|primitive| primitive.triangles.len()).sum(),
        document.materials.len(),
        document.textures.len(),
        placed.len(),
    ]
}

/// The same, as the document itself tells them.
fn told(json: &Value) -> [usize; 4] {
    let list = |key: &str| json[key].as_array().map_or(0, Vec::len);
    let accessors = &json["accessors"];
    let count = |primitive: &Value| {
        let by = primitive.get("indices").unwrap_or(&primitive["attributes"]["POSITION"]);
        accessors[by.as_u64().expect("a number") as usize]["count"].as_u64().expect("a count") / 3
    };
    let meshes = json["meshes"].as_array().expect("meshes");
    let primitives = meshes.iter().flat_map(|mesh| mesh["primitives"].as_array().expect("some"));
    let triangles: u64 = primitives.map(count).sum();
    [list("meshes"), triangles as usize, list("materials"), list("textures")]
}

/// How far the positions of each primitive reach is what the accessor's author says of them:
/// strides, quantised numbers and decompression are right. Exponential filters round, so a
/// thousandth of the size is allowed.
fn bounds_agree(document: &Document, json: &Value, file: &str) {
    for (mesh, read) in json["meshes"].as_array().expect("meshes").iter().zip(&document.meshes) {
        let primitives = mesh["primitives"].as_array().expect("primitives");
        for (primitive, read) in primitives.iter().zip(&read.primitives) {
            let position = primitive["attributes"]["POSITION"].as_u64().expect("a number");
            let accessor = &json["accessors"][position as usize];
            // Bounds are those of the stored numbers, before they become parts of the largest.
            if accessor["normalized"] == true {
                continue;
            }
            let bound = |key: &str| -> Vec3 {
                let numbers = accessor[key].as_array().expect("bounds");
                let number = |i: usize| numbers[i].as_f64().expect("a number") as f32;
                Vec3::new(number(0), number(1), number(2))
            };
            let (low, high) = (bound("min"), bound("max"));
            let near = 1e-3 * (high - low).length();
            let least = read.positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
            let most = read.positions.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
            let agree = (least - low).length() <= near && (most - high).length() <= near;
            assert!(agree, "{file}: {least} to {most}, not {low} to {high}");
        }
    }
}

#[test]
fn real_documents_are_what_they_say() {
    let Some(folder) = folder() else { return };
    for (file, placed) in REAL {
        let path = folder.join(file);
        let document = gltf::read(&path, &ReadOptions::default());
        let document = document.unwrap_or_else(|error| panic!("{error}"));
        let json = json(&fs::read(&path).expect("a file"));
        let [meshes, triangles, materials, textures, things] = counts(&document);
        assert_eq!([meshes, triangles, materials, textures], told(&json), "{file}");
        assert_eq!(things, *placed, "{file}");
        bounds_agree(&document, &json, file);
        assert_eq!(document.notes, [""; 0], "{file}");
    }
}

/// Documents, and how many meshes, cameras and lights their scenes place, by counting the nodes
/// that have any.
const REAL: &[(&str, usize)] = &[
    ("2CylinderEngine/glTF/2CylinderEngine.gltf", 68),
    ("AlphaBlendModeTest.glb", 10),
    ("AnisotropyStrengthTest.glb", 50),
    ("AttenuationTest.glb", 23),
    ("BoxInterleaved/glTF/BoxInterleaved.gltf", 1),
    ("BoxTextured.glb", 1),
    ("BoxTexturedNonPowerOfTwo/glTF/BoxTexturedNonPowerOfTwo.gltf", 1),
    ("BoxVertexColors/glTF/BoxVertexColors.gltf", 1),
    ("Cameras/glTF/Cameras.gltf", 3),
    ("ClearCoatTest.glb", 27),
    ("Cube/glTF/Cube.gltf", 1),
    ("DamagedHelmet.glb", 1),
    ("Duck-Draco/Duck.gltf", 2),
    ("Duck-Quantized/Duck.gltf", 2),
    ("Duck.glb", 2),
    ("Lights.glb", 6),
    ("MorphStressTest.glb", 1),
    ("NormalTangentTest/glTF/NormalTangentTest.gltf", 1),
    ("PalmTree/PalmTree.gltf", 10),
    ("SimpleMeshes/glTF/SimpleMeshes.gltf", 2),
    ("SimpleSparseAccessor/glTF/SimpleSparseAccessor.gltf", 1),
    ("SpecularTest.glb", 24),
    ("SunglassesKhronos.glb", 8),
    ("Suzanne/glTF/Suzanne.gltf", 1),
    ("TextureCoordinateTest/glTF/TextureCoordinateTest.gltf", 5),
    ("TextureSettingsTest/glTF/TextureSettingsTest.gltf", 10),
    ("TransmissionRoughnessTest.glb", 9),
    ("Triangle/glTF/Triangle.gltf", 1),
    ("TriangleWithoutIndices/glTF/TriangleWithoutIndices.gltf", 1),
    ("TwoSidedPlane.glb", 1),
    ("dispersion-test.glb", 27),
    ("glass-table.glb", 5),
    ("japanese-bridge-garden/scene.glb", 1),
    ("low-poly-tree.glb", 1),
    ("simple-instancing.glb", 1),
    ("usd-shader-ball/usd-shaderball-ball.glb", 4),
];

/// The last row of balls has specular colours above 1. In each a white sky is reflected, where one looks
/// straight on, as much as the extension says of the numbers in the file: min(0.04 c, 1).
#[test]
fn bright_gloss_is_bright() {
    let Some(folder) = folder() else { return };
    let path = folder.join("SpecularTest.glb");
    let loaded = rutilant_formats::read_scene(&path, &ReadOptions::default()).expect("a scene");
    let json = json(&fs::read(&path).expect("a file"));
    let mut row = 0;
    for written in json["materials"].as_array().expect("materials") {
        let name = written["name"].as_str().expect("a name");
        if !name.ends_with("HDR") {
            continue;
        }
        let factor = &written["extensions"]["KHR_materials_specular"]["specularColorFactor"][0];
        let expected = (0.04 * factor.as_f64().expect("a number")).min(1.0);
        let material = loaded.scene.materials.iter().find(|m| m.name == name).expect("it");
        let camera = Orthographic::look_at(Vec3::Z, Vec3::ZERO, 1.0).expect("a camera");
        let mut scene = Scene::new(camera);
        scene.environment = Some(Environment::constant(Rgb::WHITE));
        let material = scene.add_material(material.clone());
        scene.objects.push(Object::new(Shape::Rectangle { size: Vec2::splat(20.0) }, material));
        let prepared = Arc::new(Prepared::new(&scene).expect("sound"));
        let settings = Settings { size: [1, 1], spp: 4, ..Settings::default() };
        let session = Session::start(prepared, settings, 1).expect("settings");
        while !session.wait(Duration::from_secs(60)) {}
        let [found, ..] = session.snapshot().rgb().expect("colours")[0];
        assert!((f64::from(found) - expected).abs() < 1e-4, "{name}: {found}, not {expected}");
        row += 1;
    }
    assert_eq!(row, 5);
}

/// The same duck three times, placed in the world: with numbers of 16 bits, or compressed by Draco,
/// it is where the first one is.
#[test]
fn ducks_agree() {
    let Some(folder) = folder() else { return };
    let bounds = |file: &str| {
        let document = gltf::read(&folder.join(file), &ReadOptions::default()).expect(file);
        let placed = document.placed(None, &document.pose(None)).expect("finite");
        let mut points = Vec::new();
        for placed in placed {
            let Some(mesh) = placed.mesh else { continue };
            for primitive in &document.meshes[mesh].primitives {
                let world = primitive.positions.iter().map(|&p| placed.world_from_mesh.point(p));
                points.extend(world);
            }
        }
        let low = points.iter().copied().fold(Vec3::INFINITY, Vec3::min);
        let high = points.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
        (low, high)
    };
    let (low, high) = bounds("Duck.glb");
    for file in ["Duck-Quantized/Duck.gltf", "Duck-Draco/Duck.gltf"] {
        let (other_low, other_high) = bounds(file);
        let near = 1e-3 * (high - low).length();
        let agree = (low - other_low).length() < near && (high - other_high).length() < near;
        assert!(agree, "{file}: {other_low} to {other_high}");
    }
}
