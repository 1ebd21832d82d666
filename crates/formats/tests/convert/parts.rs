//! Documents as meshes of a native scene.

use crate::builder::Builder;
use crate::everything::everything;
use crate::{assert_same, converted, hash, read};
use rutilant::geom::{Transform, Vec3};
use rutilant::shape::{Object, Shape};
use rutilant_formats::LoadedScene;
use serde_json::json;
use std::fs;

/// The document without its lights, under an even sky, as one of its cameras sees it.
fn unlit() -> Builder {
    let mut document = everything();
    let nodes = document.json["nodes"].as_array_mut().expect("nodes");
    nodes.truncate(11);
    document.json["scenes"] = json!([{"nodes": (0..11).collect::<Vec<_>>()}]);
    document
}

fn scene(loaded: &LoadedScene, shape: &str) -> String {
    let camera = loaded.cameras[0].to_toml();
    format!(
        "version = 1\n{camera}\n[environment]\ncolor = 1\n[[shape]]\ntype = \"mesh\"\n\
         file = \"m.glb\"\n{shape}\n"
    )
}

/// A file that a shape names shows what it shows alone, bit by bit: places, materials, pictures. Its
/// cameras and lights are left out, and said so.
#[test]
fn a_document_is_a_mesh() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    fs::write(at("m.glb"), unlit().binary()).expect("written");
    let alone = read(&at("m.glb"));
    fs::write(at("a.toml"), scene(&alone, "")).expect("written");
    let within = read(&at("a.toml"));
    assert_eq!(hash(&within), hash(&alone));
    assert_eq!(within.scene.objects, alone.scene.objects);
    assert_eq!(within.scene.materials, alone.scene.materials);
    let file = at("m.glb");
    let note = format!("{}: as a mesh it has no cameras, left out: 2", file.display());
    assert_eq!(within.notes, [note]);
    assert!(within.files.contains(&file.canonicalize().expect("a file")));

    // With lights as well; and such a scene can be converted again.
    fs::write(at("m.glb"), everything().binary()).expect("written");
    assert!(read(&at("a.toml")).notes.iter().any(|note| note.ends_with("no lights, left out: 3")));
    let (before, new) = converted(&at("a.toml"), &at("b.toml"), false);
    new.write(&at("b.toml"), false).expect("written");
    assert_same(&before, &read(&at("b.toml")), "converted");
}

/// Every instance holds all parts, each moved by what moves the whole; and a document can be fitted.
#[test]
fn documents_stand_in_many_places() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    fs::write(at("m.glb"), unlit().binary()).expect("written");
    let alone = read(&at("m.glb"));
    let shape =
        "scale = 2\ninstances = [{ translate = [1, 2, 3] }, { rotate_degrees = [0, 90, 0] }]";
    fs::write(at("a.toml"), scene(&alone, shape)).expect("written");
    let within = read(&at("a.toml"));
    let count = alone.scene.objects.len();
    assert_eq!(within.scene.objects.len(), 2 * count);
    assert_eq!(within.scene.meshes, alone.scene.meshes);
    let moves =
        [Transform::translate(Vec3::new(1.0, 2.0, 3.0)), Transform::rotate_degrees(Vec3::Y, 90.0)];
    for (i, object) in within.scene.objects.iter().enumerate() {
        let was = &alone.scene.objects[i % count];
        let whole = moves[i / count] * Transform::scale(Vec3::splat(2.0));
        let expected = whole * was.world_from_object;
        for point in [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z] {
            let apart = object.world_from_object.point(point) - expected.point(point);
            assert!(apart.length() < 1e-5, "{i}: {apart}");
        }
        assert_eq!((&object.shape, object.material), (&was.shape, was.material));
    }

    // The box around all of it, whatever stands turned in it, is as large as it should be.
    let shape = "fit = { size = 3, axis = \"x\", on_floor = 1 }";
    fs::write(at("a.toml"), scene(&alone, shape)).expect("written");
    let within = read(&at("a.toml"));
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for Object { shape, world_from_object, .. } in &within.scene.objects {
        let Shape::Mesh(id) = shape else { panic!("{shape:?}") };
        for &point in &within.scene.meshes[id.0 as usize].positions {
            let point = world_from_object.point(point);
            (low, high) = (low.min(point), high.max(point));
        }
    }
    assert!((high.x - low.x - 3.0).abs() < 1e-4, "{low} {high}");
    assert!((low.y - 1.0).abs() < 1e-4 && (high.x + low.x).abs() < 1e-4, "{low} {high}");
}

/// A part without a material gets the shape's; the document's own stay.
#[test]
fn the_shape_gives_what_the_document_does_not() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let mut document = Builder::triangle();
    document.push("materials", json!({"name": "own"}));
    let other = json!({"attributes": {"POSITION": 0}, "material": 0});
    document.json["meshes"][0]["primitives"].as_array_mut().expect("a list").push(other);
    fs::write(at("m.glb"), document.binary()).expect("written");
    let material = "[[material]]\nname = \"mine\"\ntype = \"mirror\"\n";
    for (given, expected) in [("", ["", "own"]), ("material = \"mine\"", ["mine", "own"])] {
        let text = format!(
            "version = 1\n{material}[[shape]]\ntype = \"mesh\"\nfile = \"m.glb\"\n{given}\n"
        );
        fs::write(at("a.toml"), text).expect("written");
        let scene = read(&at("a.toml")).scene;
        let names =
            scene.objects.iter().map(|o| scene.materials[o.material.0 as usize].name.as_str());
        assert_eq!(names.collect::<Vec<_>>(), expected);
    }
}

/// What is wrong with a document is told with its place in it.
#[test]
fn mistakes_in_documents_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let mut document = Builder::triangle();
    document.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(7);
    fs::write(at("m.gltf"), document.text()).expect("written");
    let text = "version = 1\n[[shape]]\ntype = \"mesh\"\nfile = \"m.gltf\"\n";
    fs::write(at("a.toml"), text).expect("written");
    let error = rutilant_formats::read_scene(&at("a.toml"), &Default::default());
    let error = error.expect_err("a mistake").to_string();
    let expected = "m.gltf: meshes[0].primitives[0].attributes.POSITION names accessor 7, but there \
                    is only one (number 0)";
    assert!(error.ends_with(expected), "{error}");
}
