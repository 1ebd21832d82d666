//! What readers make of other people's files, held against what was found right before.
//!
//! Each file becomes a few lines: what it says of cameras, textures, materials and lights in the words of
//! the native format, how large its meshes are, and hashes of their arrays. Where a reader
//! changes, the lines that change tell of what; they are then to be compared with the file itself, not
//! with the reader. `RUTILANT_BLESS=1 cargo test -p rutilant-formats --test golden` writes them anew.
//!
//! The files of the repository are always read; those of other people are where `RUTILANT_DATA`
//! names a folder that has `gltf`, `mitsuba`, `obj-mtl` and `pbrt`.

#[path = "../gltf/builder.rs"]
#[allow(dead_code, reason = "each test file uses its part")]
mod builder;
#[path = "../gltf/everything.rs"]
mod everything;

use rutilant::geom::{Vec2, Vec3};
use rutilant::shape::Shape;
use rutilant_formats::{
    ConvertOptions, LoadedScene, PictureOrigin, ReadOptions, convert, read_scene,
};
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// 64-bit FNV-1a.
fn hash(bytes: impl IntoIterator<Item = u8>) -> String {
    let start = 0xcbf2_9ce4_8422_2325_u64;
    let each = |hash: u64, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
    format!("{:016x}", bytes.into_iter().fold(start, each))
}

/// The hash of numbers, each as its four bytes, the lowest first.
fn hash_of(numbers: impl IntoIterator<Item = f32>) -> String {
    hash(numbers.into_iter().flat_map(f32::to_le_bytes))
}

fn bounds(points: impl IntoIterator<Item = Vec3>) -> String {
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for point in points {
        (low, high) = (low.min(point), high.max(point));
    }
    format!("{:?} to {:?}", low.to_array(), high.to_array())
}

/// A scene in lines.
fn dump(path: &Path, loaded: &LoadedScene) -> String {
    let scene = &loaded.scene;
    let folder = path.parent().expect("a folder").display().to_string();
    let mut text = String::new();
    for note in &loaded.notes {
        let note = note.replace(&format!("{folder}/"), "");
        writeln!(text, "note: {note}").expect("text");
    }

    // What a text would say, a line for each table.
    let to = path.with_file_name("golden.toml");
    let converted = convert(loaded, path, &to, &ConvertOptions::default());
    let converted = converted.unwrap_or_else(|error| panic!("{error}"));
    for table in converted.text.split("\n\n").skip(1) {
        if !table.starts_with("[[shape]]") {
            writeln!(text, "{}", table.trim_end().replacen('\n', " ", 1).replace('\n', ", "))
                .expect("text");
        }
    }

    // Pictures, as they are stored.
    for (bitmap, origin) in scene.bitmaps.iter().zip(&loaded.origins.bitmaps) {
        let stored = match origin {
            PictureOrigin::File(path) => hash(fs::read(path).expect("a picture")),
            PictureOrigin::Bytes { bytes, .. } => hash(bytes.iter().copied()),
            PictureOrigin::Missing(name) => format!("missing: {name:?}"),
        };
        let (width, height, channels) = (bitmap.width(), bitmap.height(), bitmap.channels());
        writeln!(text, "picture: {width} x {height} x {channels}, file {stored}").expect("text");
    }

    // Meshes, and where they stand.
    for mesh in &scene.meshes {
        let (vertices, triangles) = (mesh.positions.len(), mesh.triangles.len());
        let points = mesh.positions.iter().flat_map(Vec3::to_array);
        write!(
            text,
            "mesh {:?}: {vertices} vertices {}, {triangles} triangles {}, {}",
            mesh.name,
            hash_of(points),
            hash(mesh.triangles.iter().flatten().flat_map(|v| v.to_le_bytes())),
            bounds(mesh.positions.iter().copied())
        )
        .expect("text");
        let mut part = |name: &str, numbers: Vec<f32>| {
            if !numbers.is_empty() {
                write!(text, ", {name} {}", hash_of(numbers)).expect("text");
            }
        };
        part("normals", mesh.normals.iter().flat_map(Vec3::to_array).collect());
        part("uvs", mesh.uvs.iter().flat_map(Vec2::to_array).collect());
        for (i, uvs) in (1..).zip(&mesh.more_uvs) {
            part(&format!("uvs {i}"), uvs.iter().flat_map(Vec2::to_array).collect());
        }
        part("tangents", mesh.tangents.as_flattened().to_vec());
        part("colors", mesh.colors.as_flattened().to_vec());
        text.push('\n');
    }
    let mut triangles = 0;
    let mut points = Vec::new();
    for object in &scene.objects {
        let Shape::Mesh(id) = object.shape else { continue };
        let mesh = &scene.meshes[id.0 as usize];
        triangles += mesh.triangles.len();
        points.extend(mesh.positions.iter().map(|p| object.world_from_object.point(*p)));
    }
    let number = scene.objects.len();
    let objects = if number == 1 { "object" } else { "objects" };
    writeln!(text, "{number} {objects} of {triangles} triangles, {}", bounds(points))
        .expect("text");
    text
}

/// All scene files below a folder, by their ways from there.
fn files(folder: &Path) -> Vec<(String, PathBuf)> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).expect("a folder") {
            let path = entry.expect("an entry").path();
            let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
            if path.is_dir() {
                folders.push(path);
            } else if ["gltf", "glb", "obj", "ply", "stl", "toml", "pbrt", "xml"]
                .contains(&&*extension)
            {
                let name = path.strip_prefix(folder).expect("within").to_string_lossy();
                found.push((name.replace('\\', "/"), path));
            }
        }
    }
    found.sort();
    found
}

/// What scenes of the corpus name.
const EMBEDDED: &[(&str, &[u8])] = &[
    ("sky.hdr", b"#?RADIANCE\n\n-Y 1 +X 2\n\x80\x80\x80\x81\x20\x40\x60\x84"),
    ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n"),
    ("a.ply", include_bytes!("../../../../fuzz/corpus/ply/little.ply")),
    ("a.serialized", include_bytes!("../../../../fuzz/corpus/serialized/v4.serialized")),
];

/// Holds what is made of all files of a folder against the lines in `golden`.
fn compare(files: &[(String, PathBuf)], golden: &str) {
    let mut text = String::new();
    for (name, path) in files {
        let folder = path.parent().expect("a folder").display().to_string();
        // Where files of our own name others, these need no disk.
        let embedded = if golden == "own.txt" { EMBEDDED } else { &[] };
        let options = ReadOptions { embedded, ..ReadOptions::default() };
        let said = match read_scene(path, &options) {
            Ok(loaded) => dump(path, &loaded),
            Err(error) => format!("{}\n", error.to_string().replace(&format!("{folder}/"), "")),
        };
        write!(text, "== {name}\n{said}\n").expect("text");
    }
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(golden);
    if std::env::var_os("RUTILANT_BLESS").is_some() {
        fs::write(&file, text).expect("written");
        return;
    }
    let expected = fs::read_to_string(&file).expect("golden lines");
    let parts = |text: &str| -> Vec<String> { text.split("== ").map(str::to_owned).collect() };
    for (is, was) in parts(&text).iter().zip(parts(&expected)) {
        for (is, was) in is.lines().zip(was.lines()) {
            assert_eq!(is, was, "in {}", was.lines().next().unwrap_or_default());
        }
    }
    assert_eq!(text, expected, "{golden}");
}

/// Materials of every kind that an .mtl file has, polygons, points from the end, and what is left out.
const OBJ: &str = "mtllib room.mtl
v -1 0 -1
v 1 0 -1
v 1 0 1
v -1 0 1
v 0 1.5 0
vt 0 0
vt 1 0
vt 1 1
vt 0 1
vn 0 1 0
usemtl floor
f 1/1/1 4/4/1 3/3/1 2/2/1
usemtl gloss
f 1/1 2/2 5/3
usemtl glass
f -4 -3 -1
usemtl metal
f 3 4 5
usemtl lamp
f 4 1 5
usemtl mirror
f 1 5 4
l 1 2
usemtl nothing
f 2 1 5
";

const MTL: &str = "newmtl floor
Kd 0.8 0.7 0.6
map_Kd -s 2 3 1 -o 0.5 0 0 -clamp on squares.png
newmtl gloss
Kd 0.1 0.2 0.3
Ks 0.4 0.4 0.4
Ns 98
illum 2
newmtl glass
d 0.1
Ni 1.4
Tf 0.9 0.5 0.5
newmtl metal
Kd 0.9 0.6 0.3
Pm 1
Pr 0.25
aniso 0.5
anisor 0.125
newmtl lamp
Ke 5 4 3
map_Bump bumps.png
newmtl mirror
Ks 0.9 0.9 0.9
illum 5
map_Kd lost.png
";

/// Files of our own: each feature is in one of them.
#[test]
fn own_files_are_what_they_were() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    fs::write(at("model.glb"), everything::everything().binary()).expect("written");
    fs::write(at("model.gltf"), everything::everything().text()).expect("written");
    fs::write(at("room.obj"), OBJ).expect("written");
    fs::write(at("room.mtl"), MTL).expect("written");
    fs::write(at("squares.png"), everything::png(7)).expect("written");
    fs::write(at("sky.hdr"), SKY).expect("written");
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus");
    for name in ["everything.pbrt", "older.pbrt"] {
        fs::copy(corpus.join("pbrt").join(name), at(name)).expect("copied");
    }
    let mut all = files(&corpus);
    // Those that are broken on purpose say little.
    all.retain(|(name, _)| {
        ["gltf/", "mitsuba/", "obj/", "ply/", "stl/"].iter().any(|kind| name.starts_with(kind))
            && !name.contains("everything")
    });
    all.extend(files(folder.path()));
    assert!(all.len() >= 15, "{all:?}");
    compare(&all, "own.txt");
}

/// A sky of two pixels.
const SKY: &[u8] = b"#?RADIANCE\n\n-Y 1 +X 2\n\x80\x80\x80\x81\x20\x40\x60\x84";

/// Other people's files.
#[test]
fn other_files_are_what_they_were() {
    for kind in ["gltf", "mitsuba", "obj-mtl", "pbrt"] {
        let data = std::env::var_os("RUTILANT_DATA").map(|data| Path::new(&data).join(kind));
        let Some(folder) = data.filter(|folder| folder.is_dir()) else {
            eprintln!("skipped: RUTILANT_DATA names no folder with {kind}");
            continue;
        };
        let mut files = files(&folder);
        // The meshes of scenes are in the scenes.
        files.retain(|(name, _)| kind != "pbrt" || name.ends_with(".pbrt"));
        compare(&files, &format!("{kind}.txt"));
    }
}
