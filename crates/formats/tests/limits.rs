//! Every limit can be set, holds to the last one, and is told in one line that says how to raise it.

use rutilant_formats::{Limits, ReadOptions, read_scene};
use std::fs;
use std::path::Path;

const SCENE: &str = r#"version = 1
[camera]
position = [0, 0, 5]
look_at = [0, 0, 0]
[environment]
image = "sky.pfm"
[[material]]
name = "grey"
type = "matte"
[[shape]]
type = "mesh"
file = "square.obj"
material = "grey"
[[shape]]
type = "mesh"
file = "triangle.ply"
material = "grey"
[[shape]]
type = "sphere"
radius = 1
material = "grey"
"#;
const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
const TRIANGLE: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n\
    property float y\nproperty float z\nelement face 1\n\
    property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

/// A folder with three objects of 7 vertices and 3 triangles, under a sky of 2x1 pixels.
fn desk() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).expect(name);
    write("scene.toml", SCENE.as_bytes());
    write("square.obj", SQUARE.as_bytes());
    write("triangle.ply", TRIANGLE.as_bytes());
    write("sky.pfm", &[b"Pf 2 1 -1\n".as_slice(), &[0; 8]].concat());
    folder
}

/// What is said of the scene in `folder` when a limit is set; `None` where it is read.
fn said(folder: &Path, name: &str, most: u64) -> Option<String> {
    let mut limits = Limits::default();
    *limits.by_name(name).expect(name) = most;
    let options = ReadOptions { limits, ..ReadOptions::default() };
    let error = read_scene(&folder.join("scene.toml"), &options).err()?;
    Some(error.to_string().replace(&format!("{}/", folder.display()), ""))
}

#[test]
fn limits_hold_to_the_last_one() {
    let folder = desk();
    let allow = "; allow more with --limit";
    for (name, needed, expected) in [
        (
            "bytes",
            SCENE.len() as u64,
            format!("scene.toml: 317 bytes, but at most 316 are allowed{allow} bytes=N"),
        ),
        (
            "vertices",
            7,
            // What the first mesh took is not left for the second.
            format!("triangle.ply:3:1: 3 vertices, but at most 2 are allowed{allow} vertices=N"),
        ),
        (
            "triangles",
            3,
            format!("triangle.ply:7:1: 1 triangle, but at most 0 are allowed{allow} triangles=N"),
        ),
        (
            "pixels",
            2,
            format!(
                "scene.toml:6:9: sky.pfm: 2x1 are 2 pixels, but at most 1 are allowed{allow} \
                 pixels=N"
            ),
        ),
        (
            "objects",
            3,
            format!("scene.toml:18:1: 3 objects, but at most 2 are allowed{allow} objects=N"),
        ),
        (
            "nesting",
            2,
            format!(
                "scene.toml:4:11: 2 levels of nesting, but at most 1 are allowed{allow} nesting=N"
            ),
        ),
    ] {
        assert_eq!(said(folder.path(), name, needed), None, "{name}");
        assert_eq!(said(folder.path(), name, needed - 1), Some(expected), "{name}");
    }
}

/// Bytes are counted for every file that a scene names, not for the scene alone.
#[test]
fn every_file_is_counted() {
    let folder = desk();
    for (file, place) in [
        ("square.obj", "square.obj"),
        ("triangle.ply", "triangle.ply"),
        ("square.mtl", "square.mtl"),
        ("sky.pfm", "scene.toml:6:9: sky.pfm"),
    ] {
        let path = folder.path().join(file);
        fs::write(folder.path().join("square.obj"), format!("mtllib square.mtl\n{SQUARE}"))
            .expect("a mesh");
        let before = fs::read(&path).unwrap_or_default();
        let mut long = before.clone();
        long.resize(1000, b'\n');
        fs::write(&path, &long).expect("a file");
        let expected = format!(
            "{place}: 1000 bytes, but at most 999 are allowed; allow more with --limit bytes=N"
        );
        assert_eq!(said(folder.path(), "bytes", 999), Some(expected));
        fs::write(&path, before).expect("a file");
    }
}
