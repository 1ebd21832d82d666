//! Files that scenes include, and meshes in files, packed or not.

use crate::TRIANGLE;
use flate2::Compression;
use flate2::write::GzEncoder;
use rutilant::geom::Vec3;
use rutilant_formats::{MeshOrigin, ReadOptions, read_scene};
use std::fs;
use std::io::Write as _;

fn packed(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(bytes).expect("memory");
    encoder.finish().expect("memory")
}

/// Statements of other files count where they are included, files are named from the scene's folder
/// wherever that stands, and packed ones are unpacked. What an imported file does to the state ends
/// with it.
#[test]
fn files_are_included() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("parts")).expect("a folder");
    fs::write(at("parts/mesh.ply.gz"), packed(TRIANGLE)).expect("written");
    fs::write(at("mesh.ply"), TRIANGLE).expect("written");
    fs::write(at("parts/a.pbrt"), "Translate 1 0 0\nInclude \"parts/b.pbrt.gz\"").expect("written");
    let shape = "Shape \"plymesh\" \"string filename\" \"parts/mesh.ply.gz\"";
    fs::write(at("parts/b.pbrt.gz"), packed(shape.as_bytes())).expect("written");
    let scene = "WorldBegin\nInclude \"parts/a.pbrt\"\nTranslate 0 1 0\n\
                 Import \"parts/a.pbrt\"\nShape \"plymesh\" \"string filename\" \"mesh.ply\"\n\
                 Shape \"plymesh\" \"string filename\" \"./mesh.ply\"";
    fs::write(at("scene.pbrt"), scene).expect("written");
    let loaded = read_scene(&at("scene.pbrt"), &ReadOptions::default()).expect("a scene");
    let places: Vec<_> =
        loaded.scene.objects.iter().map(|o| o.world_from_object.translation()).collect();
    // Without a camera that mirrors it, a left-handed world is mirrored.
    assert_eq!(
        places,
        [Vec3::X, Vec3::new(2.0, 1.0, 0.0), Vec3::new(1.0, 1.0, 0.0), Vec3::new(1.0, 1.0, 0.0)]
    );
    assert_eq!(loaded.scene.meshes.len(), 2, "each file is read once");
    assert_eq!(loaded.origins.meshes[0], MeshOrigin::Made);
    assert!(
        matches!(&loaded.origins.meshes[1], MeshOrigin::File { path, crease: None } if path.ends_with("mesh.ply"))
    );
    assert_eq!(loaded.files.len(), 4);
}

/// Circles end, and so do files that include each other twice over and over.
#[test]
fn circles_end() {
    let folder = tempfile::tempdir().expect("a folder");
    let write =
        |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("written");
    let said = |name: &str| {
        let error = read_scene(&folder.path().join(name), &ReadOptions::default());
        let text = error.expect_err("a circle").to_string();
        text.replace(&format!("{}/", folder.path().display()), "")
    };
    write("self.pbrt", "Include \"self.pbrt\"");
    assert_eq!(said("self.pbrt"), "self.pbrt:1:1: \"self.pbrt\" includes itself");
    write("a.pbrt", "\nInclude \"b.pbrt\"");
    write("b.pbrt", " Include \"./a.pbrt\"");
    assert_eq!(said("a.pbrt"), "b.pbrt:1:2: \"./a.pbrt\" includes itself");
    for i in 0..40 {
        let next = i + 1;
        write(&format!("{i}.pbrt"), &format!("Include \"{next}.pbrt\" Include \"{next}.pbrt\""));
    }
    write("40.pbrt", "");
    let text = said("0.pbrt");
    assert!(text.ends_with("100001 included files, but at most 100000 are allowed"), "{text}");
}

/// What unpacks to far more than text and numbers do is refused before it fills the memory.
#[test]
fn bombs_stay_packed() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bomb.pbrt");
    fs::write(&path, packed(&vec![b' '; 64 << 20])).expect("written");
    let error = read_scene(&path, &ReadOptions::default()).expect_err("a bomb").to_string();
    assert!(error.contains("bytes unpack to more than"), "{error}");
    fs::write(&path, &packed(b"WorldBegin")[..12]).expect("written");
    let error = read_scene(&path, &ReadOptions::default()).expect_err("cut short").to_string();
    assert!(error.contains("cannot be unpacked"), "{error}");
}
