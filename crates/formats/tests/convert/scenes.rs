//! The scenes of the repository, and meshes without a scene.

use crate::{assert_same, converted, read};
use rutilant::geom::{Vec2, Vec3};
use rutilant::shape::Mesh;
use rutilant_formats::scene::ply;
use rutilant_formats::{ConvertOptions, ReadOptions, convert, read_scene};
use std::fs;
use std::path::{Path, PathBuf};

/// The scenes of the repository, as far as their files are there.
fn repository() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let entries = fs::read_dir(folder).expect("scenes");
    let mut scenes: Vec<_> = entries.map(|entry| entry.expect("an entry").path()).collect();
    scenes.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
    scenes.sort();
    scenes
}

/// Written elsewhere with all that they need, and read from there, they give the same pictures, bit by
/// bit. Written a second time, nothing changes any more.
#[test]
fn scenes_of_the_repository_survive() {
    let [folder, again] = [(); 2].map(|()| tempfile::tempdir().expect("a folder"));
    let mut count = 0;
    for path in repository() {
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        // Scans that are too large for the repository may not be there.
        let Ok(before) = read_scene(&path, &ReadOptions::default()) else { continue };
        let to = folder.path().join(&name);
        let first = convert(&before, &path, &to, &ConvertOptions::default());
        let first = first.unwrap_or_else(|error| panic!("{error}"));
        first.write(&to, false).unwrap_or_else(|error| panic!("{error}"));
        let after = read(&to);
        assert_same(&before, &after, &name);

        let there = again.path().join(&name);
        let second = convert(&after, &path, &there, &ConvertOptions::default()).expect("once more");
        assert_eq!(second.text, first.text, "{name}");
        count += 1;
    }
    assert!(count >= 12, "only {count} scenes were there");
}

/// Light groups come along, of places of one mesh that are of different groups too.
#[test]
fn light_groups_survive() {
    let folder = tempfile::tempdir().expect("a folder");
    let [from, to] = ["a.toml", "b.toml"].map(|name| folder.path().join(name));
    let square = |place: &str, group: &str| {
        format!(
            "[[shape]]\ntype = \"mesh\"\nfile = \"m.ply\"\nmaterial = \"lamp\"\n\
             translate = {place}\n{group}\n"
        )
    };
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let mesh = Mesh { positions: corners.to_vec(), triangles: vec![[0, 1, 2]], ..Mesh::default() };
    fs::write(folder.path().join("m.ply"), ply::to_bytes(&mesh)).expect("written");
    let text = [
        "version = 1\n[environment]\ncolor = 1\ngroup = \"sky\"\n\
         [[material]]\nname = \"lamp\"\ntype = \"emissive\"\nradiance = 1\ngroup = \"key\"\n\
         [[light]]\ntype = \"point\"\nposition = [0, 1, 0]\nintensity = 1\ngroup = \"point\"\n",
        &square("[0, 0, 0]", "group = \"left\""),
        &square("[2, 0, 0]", "group = \"left\""),
        &square("[4, 0, 0]", "group = \"right\""),
        &square("[6, 0, 0]", ""),
    ]
    .concat();
    fs::write(&from, text).expect("written");
    let (before, new) = converted(&from, &to, false);
    new.write(&to, false).expect("written");
    let after = read(&to);
    assert_same(&before, &after, "converted");
    let objects: Vec<_> =
        after.scene.objects.iter().map(|o| o.group.map(|group| group.to_string())).collect();
    let [left, right] = ["left", "right"].map(|name| Some(name.to_owned()));
    assert_eq!(objects, [left.clone(), left, right, None]);
    assert_eq!(new.text.matches("[[shape]]").count(), 3, "{}", new.text);
}

/// Beside the old scene all files stay where they are, and small numbers stay in the text.
#[test]
fn files_beside_a_scene_are_named() {
    for path in repository().into_iter().filter(|path| {
        ["principled", "glass-cube", "nested-dielectrics"]
            .iter()
            .any(|name| path.ends_with(format!("{name}.toml")))
    }) {
        let (_, new) = converted(&path, &path.with_file_name("new.toml"), false);
        let names: Vec<_> = new.assets.iter().map(|asset| &asset.name).collect();
        assert!(names.is_empty(), "{}: {names:?}", path.display());
    }
}

/// Patterns that nothing shows yet stay as their author wrote them.
#[test]
fn patterns_stay() {
    const PATTERNS: &str = r#"
[[texture]]
name = "wall"
type = "bricks"
first = 0.4
joint = [0.1, 0.2]
shift = 0.25

[[texture]]
name = "clouds"
type = "noise"
second = [0.5, 0.6, 0.7]
octaves = 3
gain = 0.75
"#;
    let folder = tempfile::tempdir().expect("a folder");
    let from = folder.path().join("old.toml");
    let camera = "camera = { position = [0, 0, 5], look_at = [0, 0, 0] }";
    fs::write(&from, format!("version = 1\n{camera}\n{PATTERNS}")).expect("written");
    let (_, new) = converted(&from, &folder.path().join("new.toml"), false);
    assert!(new.text.contains(PATTERNS), "{}", new.text);
}

/// What a person reads: the author's words in the order of the documentation, in the fewest digits.
#[test]
fn texts_are_pleasant() {
    let folder = tempfile::tempdir().expect("a folder");
    let from = folder.path().join("old scene.toml");
    let text = r#"
version = 1
render.spp = 16
light = [{ type = "point", position = [0, 1.50, 0], intensity = [3, 3, 3] }]
[camera]
position = [0, 0, 5]
look_at = [0, 0, 0]
[environment]
color = 0.10
[[shape]]
type = "rectangle"
size = [2.0, 2.0]
rotate = { axis = [1, 0, 0], degrees = -90 }
translate = [0, -1, 0]
material = "floor"
[[shape]]
type = "sphere"
radius = 0.25
material = "red"
instances = [{ translate = [1, 0, 0] }, { translate = [2, 0, 0] }]
[[shape]]
type = "mesh"
positions = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
triangles = [[0, 1, 2]]
uvs = [[0, 0], [1, 0], [0, 1]]
material = "red"
instances = [{ scale = 2 }, { translate = [3, 0, 0] }]
[[material]]
name = "floor"
type = "matte"
albedo = { texture = "squares" }
[[material]]
name = "red"
type = "matte"
albedo = [0.5, 0.1, 0.1]
[[texture]]
name = "squares"
type = "checker"
uv_scale = 4
"#;
    fs::write(&from, text).expect("written");
    let (_, new) = converted(&from, &folder.path().join("new.toml"), false);
    assert!(new.assets.is_empty());
    let expected = r#"# Written by `rutilant convert` from old scene.toml.
# Render it with `rutilant new.toml`, move and edit it with `rutilant view new.toml`;
# docs/scene-format.md says what can stand here.
version = 1

[render]
spp = 16

[camera]
position = [0, 0, 5]
look_at = [0, 0, 0]

[environment]
color = 0.1

[[texture]]
name = "squares"
type = "checker"
uv_scale = 4

[[material]]
name = "floor"
type = "matte"
albedo = { texture = "squares" }

[[material]]
name = "red"
type = "matte"
albedo = [0.5, 0.1, 0.1]

[[shape]]
type = "rectangle"
size = [2, 2]
material = "floor"
rotate_degrees = [-90, 0, 0]
center = [0, -1, 0]

[[shape]]
type = "sphere"
radius = 0.25
material = "red"
center = [1, 0, 0]

[[shape]]
type = "sphere"
radius = 0.25
material = "red"
center = [2, 0, 0]

[[shape]]
type = "mesh"
positions = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
triangles = [[0, 1, 2]]
uvs = [[0, 0], [1, 0], [0, 1]]
material = "red"
instances = [
  { scale = 2 },
  { translate = [3, 0, 0] },
]

[[light]]
type = "point"
position = [0, 1.5, 0]
intensity = 3
"#;
    assert_eq!(new.text, expected);
}

/// A bare mesh stays the file that it is. One of several materials comes apart, so that these can be
/// edited.
#[test]
fn bare_meshes_become_scenes() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let mesh = Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z],
        triangles: vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]],
        ..Mesh::default()
    };
    fs::write(at("a.ply"), ply::to_bytes(&mesh)).expect("written");
    let (before, new) = converted(&at("a.ply"), &at("a.toml"), false);
    assert!(new.assets.is_empty() && new.text.contains("file = \"a.ply\""), "{}", new.text);
    new.write(&at("a.toml"), false).expect("written");
    assert_same(&before, &read(&at("a.toml")), "a.ply");

    // Gloss over matte is a mix, whose parts have no names.
    let mtl =
        "newmtl a\nKd 0.5 0.2 0.1\nKs 0.3 0.3 0.3\nNs 100\nnewmtl b\nKd 0.1 0.2 0.3\nKe 1 2 3\n";
    let obj = "mtllib b.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl a\nf 1 2 3\nf 1 3 4\nusemtl b\n\
               f 1 4 2\nf 2 4 3\n";
    fs::write(at("b.mtl"), mtl).expect("written");
    fs::write(at("b.obj"), obj).expect("written");
    let (before, new) = converted(&at("b.obj"), &at("b.toml"), false);
    let names: Vec<_> = new.assets.iter().map(|asset| asset.name.as_str()).collect();
    assert_eq!(names, ["b_assets/a.ply", "b_assets/b.ply"]);
    assert!(new.text.contains("name = \"a part\"") && new.text.contains("name = \"a part 2\""));
    new.write(&at("b.toml"), false).expect("written");
    assert_same(&before, &read(&at("b.toml")), "b.obj");
}

/// Flat and smooth meshes, in a file and in the text: a file stays a file with its angle, and what is
/// too long for a text becomes one with the normals that it got.
#[test]
fn smoothed_meshes_survive() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let grid = |n: usize| {
        let point =
            |i: usize| Vec3::new((i % n) as f32, (i / n) as f32, ((i * i) % 5) as f32 * 0.3);
        let corner = |i: usize| (i / (n - 1) * n + i % (n - 1)) as u32;
        let faces = (0..(n - 1) * (n - 1)).map(corner);
        let n = n as u32;
        let cut = |c: u32| [[c, c + 1, c + n], [c + 1, c + n + 1, c + n]];
        let positions: Vec<Vec3> = (0..(n * n) as usize).map(point).collect();
        Mesh { positions, triangles: faces.flat_map(cut).collect(), ..Mesh::default() }
    };
    fs::write(at("grid.ply"), ply::to_bytes(&grid(6))).expect("written");
    let long = grid(7);
    let points: Vec<_> = long.positions.iter().map(Vec3::to_array).collect();
    let text = format!(
        "version = 1\n[environment]\ncolor = 1\n[[material]]\nname = \"m\"\ntype = \"matte\"\n\
         [[shape]]\ntype = \"mesh\"\nfile = \"grid.ply\"\nsmooth_degrees = 33.3\nmaterial = \"m\"\n\
         [[shape]]\ntype = \"mesh\"\nfile = \"grid.ply\"\nmaterial = \"m\"\ntranslate = [0, 0, 4]\n\
         [[shape]]\ntype = \"mesh\"\npositions = {points:?}\ntriangles = {:?}\nsmooth_degrees = 80\n\
         material = \"m\"\ntranslate = [0, 0, 8]\n",
        long.triangles
    );
    fs::write(at("old.toml"), text).expect("written");
    let (before, new) = converted(&at("old.toml"), &at("new.toml"), false);
    assert_eq!(new.text.matches("file = \"grid.ply\"").count(), 2, "{}", new.text);
    assert_eq!(new.text.matches("smooth_degrees = 33.3").count(), 1, "{}", new.text);
    let names: Vec<_> = new.assets.iter().map(|asset| asset.name.as_str()).collect();
    assert_eq!(names, ["new_assets/m.ply"]);
    new.write(&at("new.toml"), false).expect("written");
    let after = read(&at("new.toml"));
    assert_same(&before, &after, "smoothed");
    for (object, was) in after.scene.meshes.iter().zip(&before.scene.meshes) {
        assert_eq!(object.normals, was.normals);
    }
}

/// Whatever a mesh has comes back from a PLY file to the same bits: numbers that are none, zeros with
/// signs, any of its arrays without the others.
#[test]
fn ply_files_carry_all_of_a_mesh() {
    let mut random = crate::common::Random(11);
    for which in 0..64_u32 {
        let count = 1 + random.below(9);
        let mut number = || f32::from_bits(random.next() as u32);
        let mut pairs = |there: bool| -> Vec<Vec2> {
            let count = if there { count } else { 0 };
            (0..count).map(|_| Vec2::new(number(), number())).collect()
        };
        let has = |bit: u32| which >> bit & 1 == 1;
        let uvs = pairs(has(0));
        let mut more_uvs = vec![pairs(has(1)), pairs(has(2))];
        while more_uvs.last().is_some_and(Vec::is_empty) {
            more_uvs.pop();
        }
        let triples = |there: bool, random: &mut crate::common::Random| -> Vec<Vec3> {
            let mut number = || f32::from_bits(random.next() as u32);
            let count = if there { count } else { 0 };
            (0..count).map(|_| Vec3::new(number(), number(), number())).collect()
        };
        let fours = |there: bool, random: &mut crate::common::Random| -> Vec<[f32; 4]> {
            let count = if there { count } else { 0 };
            (0..count).map(|_| [(); 4].map(|()| f32::from_bits(random.next() as u32))).collect()
        };
        let mesh = Mesh {
            name: String::new(),
            positions: triples(true, &mut random),
            normals: triples(has(3), &mut random),
            uvs,
            more_uvs,
            tangents: fours(has(4), &mut random),
            colors: fours(has(5), &mut random),
            triangles: (0..5).map(|_| [(); 3].map(|()| random.below(count) as u32)).collect(),
        };
        let bytes = ply::to_bytes(&mesh);
        let limits = rutilant_formats::Limits::default();
        let (read, notes) = ply::read_bytes(&bytes, Path::new("a.ply"), &limits).expect("a mesh");
        assert_eq!(notes, [""; 0]);
        // Written again it is the same file, so every bit has come back.
        assert_eq!(ply::to_bytes(&read), bytes, "{which:b}");
        assert_eq!(read.triangles, mesh.triangles);
        let lengths = |mesh: &Mesh| {
            let sets: Vec<usize> = mesh.more_uvs.iter().map(Vec::len).collect();
            (mesh.normals.len(), mesh.uvs.len(), sets, mesh.tangents.len(), mesh.colors.len())
        };
        assert_eq!(lengths(&read), lengths(&mesh), "{which:b}");
        let first = read.positions[0].to_array().map(f32::to_bits);
        assert_eq!(first, mesh.positions[0].to_array().map(f32::to_bits));
    }
}
