//! Where files come to stand, and what happens where they cannot.

use crate::builder::Builder;
use crate::{assert_same, converted, read};
use image::{ExtendedColorType, ImageEncoder};
use rutilant::geom::Vec3;
use rutilant::material::{CustomMaterial, Material, SurfacePoint};
use rutilant_formats::{
    Asset, Content, ConvertOptions, Converted, ReadOptions, SceneErrorKind, convert, read_scene,
};
use serde_json::json;
use std::fs;
use std::path::Path;
use std::sync::Arc;

fn png() -> Vec<u8> {
    let mut png = Vec::new();
    let encoder = image::codecs::png::PngEncoder::new(&mut png);
    encoder.write_image(&[250, 100, 50], 1, 1, ExtendedColorType::Rgb8).expect("encoded");
    png
}

/// A triangle whose material shows the picture of a file.
fn with_picture(name: &str) -> String {
    let mut document = Builder::triangle();
    document.push("images", json!({"uri": name}));
    document.push("textures", json!({"source": 0}));
    document.push("materials", json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}));
    document.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    document.text()
}

/// A picture is named where the new scene may name it: from its own folder down. Else it comes along,
/// as it does where that is wanted.
#[test]
fn pictures_are_named_or_come_along() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    fs::create_dir_all(at("in/pictures")).expect("folders");
    fs::create_dir_all(at("elsewhere")).expect("folders");
    fs::write(at("in/pictures/a b.png"), png()).expect("written");
    fs::write(at("in/old.gltf"), with_picture("pictures/a%20b.png")).expect("written");
    for (to, copy, name) in [
        ("in/new.toml", false, "pictures/a b.png"),
        ("new.toml", false, "in/pictures/a b.png"),
        ("elsewhere/new.toml", false, "new_assets/a_b.png"),
        ("in/pictures/new.toml", false, "a b.png"),
        ("in/copy.toml", true, "copy_assets/a_b.png"),
    ] {
        let (before, new) = converted(&at("in/old.gltf"), &at(to), copy);
        assert!(new.text.contains(&format!("image = \"{name}\"")), "{to}: {}", new.text);
        let copied = new.assets.iter().any(|asset| asset.name == name);
        assert_eq!(copied, name.contains("_assets/"), "{to}");
        new.write(&at(to), false).expect("written");
        assert_same(&before, &read(&at(to)), to);
        if copied {
            let copy = at(to).with_file_name(name);
            assert_eq!(fs::read(copy).expect("a copy"), png());
        }
    }
}

/// Links lead where they lead: what lies outside comes along.
#[cfg(unix)]
#[test]
fn pictures_behind_links_come_along() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    fs::create_dir_all(at("in")).expect("folders");
    fs::write(at("out.png"), png()).expect("written");
    std::os::unix::fs::symlink(at("out.png"), at("in/a.png")).expect("a link");
    fs::write(at("in/old.gltf"), with_picture("a.png")).expect("written");
    let options = ReadOptions { allow_outside: true, ..ReadOptions::default() };
    let before = read_scene(&at("in/old.gltf"), &options).expect("a scene");
    let to = at("in/new.toml");
    let new = convert(&before, &at("in/old.gltf"), &to, &ConvertOptions::default()).expect("new");
    assert!(new.text.contains("image = \"new_assets/out.png\""), "{}", new.text);
    new.write(&to, false).expect("written");
    assert_same(&before, &read(&to), "link");

    // A folder that leads away would not be read again, so nothing is put there.
    fs::create_dir_all(at("away")).expect("folders");
    std::os::unix::fs::symlink(at("away"), at("in/b_assets")).expect("a link");
    let to = at("in/b.toml");
    let new = convert(&before, &at("in/old.gltf"), &to, &ConvertOptions::default()).expect("new");
    let error = new.write(&to, true).expect_err("refused").to_string();
    assert!(error.ends_with("its folder leads out of the scene's folder"), "{error}");
    assert!(!to.exists() && fs::read_dir(at("away")).expect("a folder").next().is_none());
}

/// A picture that is not there stays one that is not there, under a name that leads nowhere else.
#[test]
fn missing_pictures_stay_missing() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    for (name, written) in [
        ("lost.png", "lost.png"),
        ("../../etc/lost.png", "new_assets/lost.png"),
        ("C:\\lost\\b.jpg", "new_assets/b.jpg"),
        ("", "new_assets/picture."),
    ] {
        fs::write(at("old.gltf"), with_picture(name)).expect("written");
        let Ok(before) = read_scene(&at("old.gltf"), &ReadOptions::default()) else {
            assert_eq!(name, "", "only a name that is none may be refused");
            continue;
        };
        let to = at("new.toml");
        let new = convert(&before, &at("old.gltf"), &to, &ConvertOptions::default()).expect("new");
        assert!(new.text.contains(&format!("image = \"{written}")), "{name}: {}", new.text);
        new.write(&to, true).expect("written");
        assert_same(&before, &read(&to), name);
    }
}

/// What comes along stands in the scene's folder or in one below it, whoever named it; nothing is
/// written else.
#[test]
fn assets_stay_beside_their_scene() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::create_dir(folder.path().join("in")).expect("a folder");
    let to = folder.path().join("in/new.toml");
    for name in [
        "../a.ply",
        "a/../../b.ply",
        "/tmp/a.ply",
        "a//b.ply",
        "a/b/c.ply",
        "a\\b.ply",
        "c:a.ply",
        "",
        ".",
        "..",
        "./a.ply",
        "a/",
        "a\0",
    ] {
        let content = Content::Bytes(Arc::new(vec![1]));
        let assets = vec![Asset { name: name.to_owned(), content }];
        let new = Converted { text: "version = 1".to_owned(), assets, notes: Vec::new() };
        let error = new.write(&to, true).expect_err(name).to_string();
        assert!(error.ends_with("is no name of a file beside the scene"), "{error}");
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1);
        assert_eq!(fs::read_dir(folder.path().join("in")).expect("a folder").count(), 0);
    }
}

/// Nothing that was there is written over unless that is asked for; where a file cannot be written,
/// nothing new stays behind.
#[test]
fn files_are_written_together_or_not_at_all() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    fs::write(at("old.glb"), Builder::triangle().binary()).expect("written");
    let (_, new) = converted(&at("old.glb"), &at("new.toml"), false);
    assert_eq!(new.assets.len(), 1);
    let names = || {
        let entries = fs::read_dir(folder.path()).expect("a folder");
        let mut names: Vec<_> = entries
            .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    };

    // The scene itself, then one of its files.
    fs::write(at("new.toml"), "mine").expect("written");
    let error = new.write(&at("new.toml"), false).expect_err("refused");
    assert!(error.to_string().contains("new.toml: there is such a file already"), "{error}");
    assert_eq!(names(), ["new.toml", "old.glb"]);
    assert_eq!(fs::read_to_string(at("new.toml")).expect("text"), "mine");
    fs::remove_file(at("new.toml")).expect("removed");
    let asset = at(&new.assets[0].name);
    fs::create_dir(at("new_assets")).expect("a folder");
    fs::write(&asset, "mine").expect("written");
    assert!(new.write(&at("new.toml"), false).is_err());
    assert_eq!(fs::read_to_string(&asset).expect("text"), "mine");
    assert_eq!(names(), ["new_assets", "old.glb"]);
    assert_eq!(new.write(&at("new.toml"), true).expect("written"), [asset, at("new.toml")]);
    assert_same(&read(&at("old.glb")), &read(&at("new.toml")), "written over");

    // A file where the folder should be, and a folder where the scene should be.
    let (_, new) = converted(&at("old.glb"), &at("b.toml"), false);
    fs::write(at("b_assets"), "mine").expect("written");
    let error = new.write(&at("b.toml"), true).expect_err("refused");
    assert!(matches!(error.kind, SceneErrorKind::Io(_)), "{error}");
    assert!(!at("b.toml").exists());
    let (_, new) = converted(&at("old.glb"), &at("c.toml"), false);
    fs::create_dir(at("c.toml")).expect("a folder");
    let error = new.write(&at("c.toml"), true).expect_err("refused");
    assert!(error.to_string().ends_with("c.toml: this is a folder, not a file"), "{error}");
    assert!(!at("c_assets").exists(), "nothing new stays");

    // No folder at all.
    let before = read(&at("old.glb"));
    let options = ConvertOptions::default();
    let error = convert(&before, &at("old.glb"), &at("nowhere/d.toml"), &options);
    let error = error.expect_err("refused");
    assert!(matches!(error.kind, SceneErrorKind::Io(_)), "{error}");
}

#[derive(Debug)]
struct Mine;

impl CustomMaterial for Mine {
    fn bsdf(&self, _: &SurfacePoint) -> rutilant::bsdf::Bsdf {
        unreachable!("nobody renders it")
    }
}

/// What no file can say is refused by its name, in one line.
#[test]
fn custom_parts_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let from = folder.path().join("a.glb");
    fs::write(&from, Builder::triangle().binary()).expect("written");
    let mut loaded = read(&from);
    let custom: Arc<dyn CustomMaterial> = Arc::new(Mine);
    loaded.scene.add_material(Material::from(custom).named("mine"));
    let to = folder.path().join("b.toml");
    let options = ConvertOptions::default();
    let error = convert(&loaded, &from, &to, &options).expect_err("refused").to_string();
    assert!(
        error.ends_with("material \"mine\" (number 1) is custom, which no file can say"),
        "{error}"
    );
    assert_eq!(error.lines().count(), 1);

    // A picture that somebody put into the scene lies in no file.
    let mut loaded = read(&from);
    let bitmap = loaded.scene.add_bitmap(rutilant::texture::Bitmap::solid([1, 2, 3, 4]));
    let texture = loaded.scene.add_texture(rutilant::texture::ImageTexture::new(bitmap));
    loaded.scene.materials[0].each_texture_mut(|_| {});
    let matte = rutilant::material::Matte {
        albedo: rutilant::texture::ColorInput {
            texture: Some(texture),
            factor: rutilant::color::Rgb::WHITE,
            vertex_colors: false,
        },
        ..rutilant::material::Matte::new(rutilant::color::Rgb::WHITE)
    };
    loaded.scene.add_material(Material::from(matte).named("x"));
    let error = convert(&loaded, &from, &to, &options).expect_err("refused").to_string();
    assert!(error.ends_with("picture 0 comes from no file, so none can be named"), "{error}");
}

/// Meshes, places and pictures that need no disk are found by the names that a text says.
#[test]
fn files_of_a_text_may_be_in_memory() {
    // A mesh is named after its file.
    let mesh = rutilant::shape::Mesh {
        name: "y".to_owned(),
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        triangles: vec![[0, 1, 2]],
        ..Default::default()
    };
    let ply = rutilant_formats::scene::ply::to_bytes(&mesh);
    let text = "version = 1\n[[material]]\nname = \"a\"\ntype = \"matte\"\n[[shape]]\ntype = \"mesh\"\n\
                file = \"x/y.ply\"\nmaterial = \"a\"\ninstances = \"places.txt\"\n";
    let embedded: [(&str, &[u8]); 2] = [("x/y.ply", &ply), ("places.txt", b"0 0 0\n1 0 0\n")];
    let options = ReadOptions { embedded: &embedded, ..ReadOptions::default() };
    let loaded = rutilant_formats::parse_native(text, Path::new("nowhere/a.toml"), &options);
    let loaded = loaded.unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((loaded.scene.objects.len(), &loaded.scene.meshes[0]), (2, &mesh));
    assert!(loaded.files.is_empty());
}
