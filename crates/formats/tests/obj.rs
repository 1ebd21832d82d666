//! OBJ and MTL: every legal spelling is understood, everything else is refused at its place.

use rutilant::color::Rgb;
use rutilant::geom::{Vec2, Vec3};
use rutilant::material::{
    Absorption, Dielectric, Emission, Material, MaterialKind, Matte, Medium, Mirror,
};
use rutilant::shape::Mesh;
use rutilant_formats::Limits;
use rutilant_formats::scene::obj::{self, ObjScene};
use std::fs;
use std::path::Path;

fn read(text: impl AsRef<[u8]>) -> ObjScene {
    obj::read_bytes(text.as_ref(), Path::new("a.obj"), &Limits::default())
        .unwrap_or_else(|error| panic!("{error}"))
}

/// The only mesh of a file.
fn mesh(text: impl AsRef<[u8]>) -> Mesh {
    let scene = read(text);
    assert_eq!(scene.notes, [""; 0]);
    let [(mesh, _)] = &*scene.meshes else { panic!("one mesh: {scene:?}") };
    mesh.clone()
}

fn refusal(text: impl AsRef<[u8]>) -> String {
    let result = obj::read_bytes(text.as_ref(), Path::new("a.obj"), &Limits::default());
    result.map(|scene| scene.meshes).expect_err("refused").to_string()
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

/// The corners of each triangle, as positions: what is seen, however it is indexed.
fn seen(mesh: &Mesh) -> Vec<[Vec3; 3]> {
    mesh.triangles.iter().map(|t| t.map(|v| mesh.positions[v as usize])).collect()
}

/// Line ends, continuations, comments, a byte order mark, tabs, an extra weight or colour: all
/// say the same.
#[test]
fn spellings_agree() {
    let plain = format!("{SQUARE}f 1 2 3\nf 1 3 4\n");
    let expected = mesh(&plain);
    assert_eq!(expected.positions.len(), 4);
    assert_eq!(expected.triangles, [[0, 1, 2], [0, 2, 3]]);
    let spellings = [
        plain.replace('\n', "\r\n"),
        plain.replace('\n', "\r"),
        plain.replace(" 1 0 0", " \\\n1\t0 \\\r\n 0").replace("f 1 2 3", "f 1\\\n 2 3"),
        format!("\u{feff}# a comment \\\n{}", plain.replace('\n', "  # more \\\n\n")),
        plain.replace("v 1 1 0", "v 1 1 0 1.0").replace("v 0 1 0", "v 0 1 0 0.5 0.25 1 1"),
        plain.replace("v 1 1 0", "v 1e0 +1.0 -.0").replace("f 1 2 3", "f +1 2 3"),
        plain.replace("f ", "  f\t").trim_end().to_owned(),
        plain.replace("f 1 2 3", "g one two\no thing\ns 1\nf 1 2 3\ns off\ng"),
        plain.replace("f 1 2 3", "f 1/ 2// 3/"),
    ];
    for text in spellings {
        assert_eq!(mesh(&text), expected, "{text:?}");
    }
}

/// Negative indices count back from the last one declared at that point; declarations and faces
/// may take turns.
#[test]
fn negative_indices_count_from_here() {
    let text =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 5 0 0\nv 6 0 0\nv 5 1 0\nf -3 -2 -1\nf 1 2 -1\n";
    assert_eq!(mesh(text).triangles, [[0, 1, 2], [3, 4, 5], [0, 1, 5]]);
    let text = format!(
        "{SQUARE}vt 0 0\nvn 0 0 1\nf -4/-1/-1 -3/-1/-1 -2/-1/-1\nvt .5 .5\nvn 0 1 0\n\
         f -4/-1/-1 -3/-1/-1 -2/-2/-2\n"
    );
    let mesh = mesh(text);
    assert_eq!(mesh.uvs[..3], [Vec2::ZERO; 3]);
    assert_eq!(mesh.triangles, [[0, 1, 2], [3, 4, 2]]);
    assert_eq!(mesh.normals[3], Vec3::Y);
}

/// All four forms of a corner. A corner that comes again is stored once; one that differs in any
/// of the three is another vertex.
#[test]
fn corners_are_shared_where_they_are_equal() {
    let data = format!("{SQUARE}vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\nvn 0 0 -1\n");
    let both = mesh(format!("{data}f 1/1/1 2/2/1 3/3/1\nf 1/1/1 3/3/1 4/4/1\n"));
    assert_eq!((both.positions.len(), both.normals.len(), both.uvs.len()), (4, 4, 4));
    assert_eq!(both.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(both.uvs[2], Vec2::ONE);
    let only_uv = mesh(format!("{data}f 1/1 2/2 3/3\nf 1/1 3/1 4/4\n"));
    assert_eq!((only_uv.positions.len(), only_uv.normals.len()), (5, 0));
    let only_normal = mesh(format!("{data}f 1//1 2//1 3//1\nf 1//2 3//2 4//2\n"));
    assert_eq!((only_normal.positions.len(), only_normal.uvs.len()), (6, 0));
    assert_eq!(only_normal.normals[..3], [Vec3::Z; 3]);
    assert_eq!(only_normal.normals[3..], [-Vec3::Z; 3]);
    // One number is a texture coordinate too; the third is not used.
    let short = mesh(format!("{SQUARE}vt .5\nvt 1 2 3\nf 1/1 2/2 3/2\n"));
    assert_eq!(short.uvs, [Vec2::new(0.5, 0.0), Vec2::new(1.0, 2.0), Vec2::new(1.0, 2.0)]);
}

/// A vertex with very many different corners, the pole of a fine sphere, is read in time that
/// grows with the file, and every triangle keeps its corners.
#[test]
fn a_pole_of_many_corners_is_fine() {
    let mut text = String::from("v 0 0 1\nv 1 0 0\nv 0 1 0\n");
    let count = 20_000;
    for i in 0..count {
        text.push_str(&format!("vt {i} 0\n"));
    }
    for _ in 0..2 {
        for i in 1..=count {
            text.push_str(&format!("f 1/{i} 2/1 3/1\n"));
        }
    }
    let mesh = mesh(&text);
    assert_eq!(mesh.triangles.len(), 2 * count);
    for (i, [pole, ..]) in mesh.triangles.iter().enumerate() {
        assert_eq!(mesh.uvs[*pole as usize].x, (i % count) as f32);
    }
}

/// Polygons are cut into triangles that cover them once, concave ones too, in any direction of
/// view; quadrilaterals along the diagonal that lies inside, or the shorter one.
#[test]
fn polygons_are_cut() {
    assert_eq!(mesh(format!("{SQUARE}f 1 2 3 4\n")).triangles, [[0, 1, 2], [0, 2, 3]]);
    let arrow = "v 0 0 0\nv 4 2 0\nv 0 4 0\nv 1 2 0\nf 1 2 3 4\n";
    assert_eq!(mesh(arrow).triangles, [[0, 1, 3], [1, 2, 3]]);
    let kite = "v 0 0 0\nv 1 -1 0\nv 9 0 0\nv 1 1 0\nf 1 2 3 4\n";
    assert_eq!(mesh(kite).triangles, [[0, 1, 3], [1, 2, 3]]);

    // A U, seen along x, y, z and from below: its area is 7, and no triangle fills its gap.
    let outline = [[0, 0], [3, 0], [3, 3], [2, 3], [2, 1], [1, 1], [1, 3], [0, 3]];
    for axes in [[0, 1, 2], [1, 2, 0], [2, 0, 1], [1, 0, 2]] {
        let mut text = String::new();
        for [u, v] in outline {
            let mut p = [5; 3];
            p[axes[0]] = u;
            p[axes[1]] = v;
            text.push_str(&format!("v {} {} {}\n", p[0], p[1], p[2]));
        }
        let mesh = mesh(format!("{text}f 1 2 3 4 5 6 7 8\n"));
        assert_eq!(mesh.triangles.len(), 6);
        let areas = seen(&mesh).into_iter().map(|[a, b, c]| 0.5 * (b - a).cross(c - a));
        let sum = areas.clone().fold(Vec3::ZERO, |sum, area| sum + area);
        assert_eq!(sum.length(), 7.0);
        assert!(areas.clone().all(|area| area.dot(sum) >= 0.0), "{:?}", areas.collect::<Vec<_>>());
    }
}

/// Meshes are split by material, not by group, in the order of their first faces; a material
/// that comes again continues its mesh.
#[test]
fn materials_split_and_groups_do_not() {
    let scene = read(format!(
        "{SQUARE}g a\nf 1 2 3\nusemtl shiny red\ng b\nf 1 3 4\nusemtl unused\nusemtl blue\n\
         f 1 2 4\nusemtl  shiny red \nf 2 3 4\n"
    ));
    let names: Vec<_> = scene.meshes.iter().map(|(_, name)| name.as_deref()).collect();
    assert_eq!(names, [None, Some("shiny red"), Some("blue")]);
    let counts: Vec<_> =
        scene.meshes.iter().map(|(m, _)| (m.positions.len(), m.triangles.len())).collect();
    assert_eq!(counts, [(3, 1), (4, 2), (3, 1)]);
    let [a, b, c] = seen(&scene.meshes[1].0)[1];
    assert_eq!([a, b, c], [Vec3::X, Vec3::new(1., 1., 0.), Vec3::Y]);
    assert_eq!(scene.meshes[1].0.name, "shiny red");
}

/// Where only some faces have normals, the others are flat; where only some have texture
/// coordinates, the others get (0, 0). Both are said.
#[test]
fn missing_normals_are_flat() {
    let scene = read(format!(
        "{SQUARE}vt .5 .5\nvn 1 0 0\nf 1/1/1 2/1/1 3/1/1\nf 1 3 4\nusemtl m\nf 1 2 3\n"
    ));
    let mesh = &scene.meshes[0].0;
    assert_eq!(mesh.normals, [Vec3::X, Vec3::X, Vec3::X, Vec3::Z, Vec3::Z, Vec3::Z]);
    assert_eq!(mesh.uvs[2..4], [Vec2::new(0.5, 0.5), Vec2::ZERO]);
    assert_eq!(
        scene.notes,
        [
            "a.obj: triangles of no material without texture coordinates, given (0, 0): 1 of 2",
            "a.obj: triangles of no material without normals, shaded flat: 1 of 2",
        ]
    );
    let other = &scene.meshes[1].0;
    assert!(other.normals.is_empty() && other.uvs.is_empty());
}

/// Statements for what is not rendered are left out with one note each.
#[test]
fn what_is_left_out_is_said_once() {
    let scene = read(format!(
        "{SQUARE}l 1 2\np 1\nl 3 4\nf 1 2\nf\ncstype bezier\ncurv 0 1 1 2\nfrob 1\nfrob 2\nf 1 2 3\n"
    ));
    assert_eq!(
        scene.notes,
        [
            "a.obj:5:1: points and lines, left out: 3",
            "a.obj:10:1: statements of free-form curves and surfaces, left out: 2",
            "a.obj:8:1: faces with fewer than 3 corners, left out: 2",
            "a.obj:12:1: unknown statements like \"frob\", left out: 2",
        ]
    );
    let empty = read("# nothing\n");
    assert_eq!(empty.notes, ["a.obj: there are no faces in it, so nothing of it can be seen"]);
    assert!(empty.meshes.is_empty());
}

/// NaN and infinite vertices are the renderer's to leave out.
#[test]
fn numbers_are_kept_as_they_are() {
    let mesh = mesh("v nan 1e999 -inf\nv 1e-45 0.1 16777217\nv 0 0 0\nf 1 2 3\n");
    assert!(mesh.positions[0].x.is_nan());
    assert_eq!(mesh.positions[0].y, f32::INFINITY);
    assert_eq!(mesh.positions[1], Vec3::new(1e-45, 0.1, 16_777_216.0));
}

/// One line for each way to be wrong, at its line and column.
#[test]
fn errors_name_the_place() {
    let after = |line: &str| refusal(format!("{SQUARE}vt 0 0\nvn 0 0 1\n{line}\n"));
    let cases = [
        ("f 1 2 12", "a.obj:7:7: face names vertex 12, but only 4 are declared so far"),
        ("f 1 2 -5", "a.obj:7:7: face names vertex -5, but only 4 are declared so far"),
        (
            "f 1 0 2",
            "a.obj:7:5: face names vertex 0, but they are numbered from 1 (or from -1 backwards)",
        ),
        (
            "f 1 2 99999999999999999999",
            "a.obj:7:7: face names vertex 99999999999999999999, but only 4 are declared so far",
        ),
        (
            "f 1/1 2/2 3/1",
            "a.obj:7:9: face names texture coordinate 2, but only 1 is declared so far",
        ),
        ("f 1//1 2//-2 3//1", "a.obj:7:11: face names normal -2, but only 1 is declared so far"),
        ("f 1 2 x", "a.obj:7:7: \"x\" is not a vertex number"),
        ("f 1 2 3.0", "a.obj:7:7: \"3.0\" is not a corner; those are v, v/vt, v//vn or v/vt/vn"),
        (
            "f 1/1/1/1 2 3",
            "a.obj:7:3: \"1/1/1/1\" is not a corner; those are v, v/vt, v//vn or v/vt/vn",
        ),
        ("f 1/a 2 3", "a.obj:7:5: \"a\" is not a texture coordinate number"),
        ("f 1//1 2 3", "a.obj:7:8: \"2\" is not of the form of the face's first corner"),
        ("f 1 2 3/1", "a.obj:7:7: \"3/1\" is not of the form of the face's first corner"),
        ("v 1 2", "a.obj:7:6: v needs 3 numbers, but there are only 2"),
        ("v", "a.obj:7:2: v needs 3 numbers"),
        ("vn 1", "a.obj:7:5: vn needs 3 numbers, but there are only 1"),
        ("vt", "a.obj:7:3: vt needs a number"),
        ("v 1 2 1,5", "a.obj:7:7: \"1,5\" is not a number"),
        ("v 1 2 3 red", "a.obj:7:9: \"red\" is not a number"),
        ("v \u{e9} 2 3", "a.obj:7:3: \"\u{e9}\" is not a number"),
        ("f 1 \\\n 2 \\\n 77", "a.obj:9:2: face names vertex 77, but only 4 are declared so far"),
    ];
    for (line, expected) in cases {
        assert_eq!(after(line), expected);
    }
    assert_eq!(
        refusal(b"\x89PNG\r\n\x1a\n\0\0"),
        "a.obj:1:1: \"\\u{89}PNG\" begins no OBJ statement"
    );
    let missing = obj::read(Path::new("no/such.obj"), &Limits::default()).expect_err("missing");
    assert!(missing.to_string().starts_with("no/such.obj: No such file"), "{missing}");
    let folder = tempfile::tempdir().expect("a folder");
    let error = obj::read(folder.path(), &Limits::default()).expect_err("a folder");
    assert!(error.to_string().ends_with(": this is a folder, not a file"), "{error}");
}

/// What is legal but more than the caller allows is refused by number.
#[test]
fn limits_are_kept() {
    let text = format!("{SQUARE}vt 0 0\nvt 1 1\nf 1/1 2/1 3/1 4/1\nf 1/2 2/2 3/2\n");
    let with = |limits: &Limits| {
        let result = obj::read_bytes(text.as_bytes(), Path::new("a.obj"), limits);
        result.map(|scene| scene.meshes).expect_err("refused").to_string()
    };
    let all = Limits::default();
    assert_eq!(
        with(&Limits { vertices: 3, ..all }),
        "a.obj:4:1: 4 vertices, but at most 3 are allowed; allow more with --limit vertices=N"
    );
    assert_eq!(
        with(&Limits { vertices: 4, ..all }),
        "a.obj: 7 vertices, but at most 4 are allowed; allow more with --limit vertices=N"
    );
    assert_eq!(
        with(&Limits { triangles: 1, ..all }),
        "a.obj:7:1: 2 triangles, but at most 1 are allowed; allow more with --limit triangles=N"
    );
}

/// Reads `obj` with files beside it.
fn read_with(obj: &str, others: &[(&str, &str)]) -> Result<ObjScene, String> {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in others {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("made");
        fs::write(path, text).expect("written");
    }
    let path = folder.path().join("a.obj");
    fs::write(&path, obj).expect("written");
    // Messages without the name of the folder.
    let plain = |text: &str| text.replace(&format!("{}/", folder.path().display()), "");
    match obj::read(&path, &Limits::default()) {
        Ok(mut scene) => {
            scene.notes.iter_mut().for_each(|note| *note = plain(note));
            Ok(scene)
        }
        Err(error) => Err(plain(&error.to_string())),
    }
}

const FACE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// The materials of an MTL file, and its notes.
fn mtl(text: &str) -> (Vec<Material>, Vec<String>) {
    let scene = read_with(&format!("mtllib a.mtl\n{FACE}"), &[("a.mtl", text)]);
    let scene = scene.unwrap_or_else(|error| panic!("{error}"));
    (scene.materials, scene.notes)
}

/// The only material of an MTL file that has the statements of `body` in it, without notes.
fn material(body: &str) -> Material {
    let (materials, notes) = mtl(&format!("newmtl m\n{body}\n"));
    assert_eq!(notes, [""; 0], "{body}");
    let [material] = &*materials else { panic!("one material: {materials:?}") };
    assert_eq!(material.name, "m");
    material.clone()
}

fn matte(r: f32, g: f32, b: f32) -> MaterialKind {
    MaterialKind::Matte(Matte::new(Rgb::new(r, g, b)))
}

fn glass(ior: f32, tint: Option<[f32; 3]>) -> MaterialKind {
    let absorption = match tint {
        Some(color) => Absorption::ColorAtDistance { color: Rgb(color), distance: 1.0 },
        None => Absorption::None,
    };
    let interior = Medium { ior, absorption };
    MaterialKind::Dielectric(Dielectric { interior, ..Dielectric::new(ior) })
}

/// What each combination of statements becomes. `Ns` in particular is the width of a highlight
/// and never makes a mirror; a colour of one number is grey.
#[test]
fn materials_mean_what_they_say() {
    let cases = [
        ("Kd 0.5", matte(0.5, 0.5, 0.5)),
        ("Kd 0.5 0.25 0.125 # grey-blue", matte(0.5, 0.25, 0.125)),
        ("", matte(0.8, 0.8, 0.8)),
        ("Kd .1 .2 .3\nKs 1 1 1\nNs 1000\nillum 1", matte(0.1, 0.2, 0.3)),
        ("Kd 0 0 0\nKs .95 .9 .85\nillum 5", mirror(0.95, 0.9, 0.85)),
        ("Kd .1 .1 .1\nKs 0 0 0\nillum 5", matte(0.1, 0.1, 0.1)),
        ("Kd 0 0 0\nKs .9 .9 .9\nillum 3", mirror(0.9, 0.9, 0.9)),
        ("Kd .01\nKs 1\nTf 1 1 1\nNs 200\nNi 1.8\nillum 7", glass(1.8, None)),
        ("Kd .01\nTf 0.8 0.9 1\nNi 1.33\nillum 7", glass(1.33, Some([0.8, 0.9, 1.0]))),
        ("Kd .5\nillum 6", glass(1.5, None)),
        ("Kd .5\nNi 1.4\nillum 4", glass(1.4, None)),
        ("Kd 0\nillum 4", glass(1.5, None)),
        ("Kd .5\nillum 9\nd 1", glass(1.5, None)),
        ("Kd .5\nd 0.5\nillum 2\nNi 2.4", glass(2.4, None)),
        ("Kd .5\nTr 0.25", glass(1.5, None)),
        ("Kd .5\nTr 0\nd 1\nNi 1.45", matte(0.5, 0.5, 0.5)),
        ("Kd .5\nKs .5\nillum 5\nd .5", glass(1.5, None)),
        ("Kd .1\nKd .2", matte(0.2, 0.2, 0.2)),
        ("  Ka 1 1 1\r\n\tKd .1 \\\r\n .2 .3\r\n", matte(0.1, 0.2, 0.3)),
    ];
    for (body, expected) in cases {
        assert_eq!(material(body).kind, expected, "{body}");
    }
    let lamp = material("Kd 0.5\nKe 17 12 4");
    assert_eq!(lamp.emission, Some(Emission::radiance(Rgb::new(17.0, 12.0, 4.0))));
    assert_eq!(lamp.kind, matte(0.5, 0.5, 0.5));
    assert_eq!(material("Kd 0.5\nKe 0 0 0").emission, None);
}

fn mirror(r: f32, g: f32, b: f32) -> MaterialKind {
    MaterialKind::Mirror(Mirror { reflectance: Rgb::new(r, g, b) })
}

/// What is changed or left out is said, with its line.
#[test]
fn changes_to_materials_are_noted() {
    let cases = [
        (
            "Kd 1.5 0.5 -1",
            matte(1.0, 0.5, 0.0),
            "a.mtl:1: material \"m\": Kd 1.5 0.5 -1 is brought into the range 0 to 1",
        ),
        (
            "Kd spectral file.rfl 2",
            matte(0.8, 0.8, 0.8),
            "a.mtl:2: Kd by spectrum or xyz is not read",
        ),
        ("Kd xyz .1 .2 .3", matte(0.8, 0.8, 0.8), "a.mtl:2: Kd by spectrum or xyz is not read"),
        (
            "Kd 1\nd 0.5\nTr 0.9",
            glass(1.5, None),
            "a.mtl:1: material \"m\": d 0.5 and Tr 0.9 disagree; d counts",
        ),
        ("d 0.5\nNi 1", glass(1.5, None), "a.mtl:1: material \"m\": Ni 1 is taken as 1.5"),
        ("d 0.5\nNi 40", glass(10.0, None), "a.mtl:1: material \"m\": Ni 40 is taken as 10"),
        (
            "Kd .5\nillum 4\nTf 1 1 1\nNi 1",
            matte(0.5, 0.5, 0.5),
            "a.mtl:1: material \"m\": illum 4 without d or Ni is taken as matte",
        ),
        ("d -halo 0.5", glass(1.5, None), "a.mtl:2: \"d -halo\" is not read"),
        (
            "map_Ns -s 1 1 1 a b.png\nmap_Ns c.png",
            matte(0.8, 0.8, 0.8),
            "a.mtl:2: textures of other kinds are not read: 2 (map_Ns; first \"a b.png\")",
        ),
        (
            "newmtl m\nKd 0",
            matte(0.8, 0.8, 0.8),
            "a.mtl:2: materials that come again, left out: 1 (first \"m\")",
        ),
        (
            "Ke -1 0 0",
            matte(0.8, 0.8, 0.8),
            "a.mtl:1: material \"m\": Ke -1 0 0 is brought into the range 0 to 1e18",
        ),
        (
            "Ke 3e20 0 0",
            matte(0.8, 0.8, 0.8),
            "a.mtl:1: material \"m\": Ke 300000000000000000000 0 0 is brought into the range 0 to 1e18",
        ),
    ];
    for (body, kind, note) in cases {
        let (materials, notes) = mtl(&format!("newmtl m\n{body}\n"));
        assert_eq!(notes, [note], "{body}");
        assert_eq!(materials[0].kind, kind, "{body}");
    }
    // Nothing is fully black inside: its absorption would be infinite.
    let (materials, notes) = mtl("newmtl m\nd 0\nTf 0 .5 2\n");
    assert_eq!(materials[0].kind, glass(1.5, Some([f32::MIN_POSITIVE, 0.5, 1.0])));
    let said = "Tf 0 0.5 2 is brought into the range 1.1754944e-38 to 1";
    assert_eq!(notes, [format!("a.mtl:1: material \"m\": {said}")]);
}

/// Errors in an MTL file name that file.
#[test]
fn errors_in_materials_name_the_place() {
    let cases = [
        ("Kd 1 1 1\n", "a.mtl:1:1: \"Kd\" stands before the first newmtl"),
        ("newmtl\n", "a.mtl:1:1: newmtl needs a name"),
        ("newmtl m\nKd\n", "a.mtl:2:3: Kd needs a number"),
        ("newmtl m\nKd 1 x 1\n", "a.mtl:2:6: \"x\" is not a number"),
        ("newmtl m\nKe 1 1e99 1\n", "a.mtl:2:6: Ke is inf, but must be finite"),
        ("newmtl m\n\n  Ni glass\n", "a.mtl:3:6: \"glass\" is not a number"),
        ("newmtl m\nd -halo\n", "a.mtl:2:8: d needs a number"),
    ];
    for (text, expected) in cases {
        let result = read_with(&format!("mtllib a.mtl\n{FACE}"), &[("a.mtl", text)]);
        assert_eq!(result.map(|scene| scene.materials).expect_err("refused"), expected);
    }
}

/// MTL files are found with blanks in their names, several on a line, in folders below, with
/// other systems' slashes and by their last part, but never above.
#[test]
fn material_files_are_found() {
    let a = ("my materials.mtl", "newmtl a\nKd 0.1\n");
    let b = ("b.mtl", "newmtl b\nKd 0.2\nnewmtl a\nKd 0.9\n");
    let c = ("below/c.mtl", "newmtl c\nKd 0.3\n");
    for (line, expected) in [
        ("mtllib my materials.mtl", &["a"][..]),
        ("mtllib \"my materials.mtl\"", &["a"]),
        ("mtllib b.mtl below/c.mtl", &["b", "a", "c"]),
        ("mtllib my materials.mtl\nmtllib b.mtl\nmtllib b.mtl", &["a", "b"]),
        ("mtllib .\\below\\c.mtl", &["c"]),
        ("mtllib C:\\Users\\me\\b.mtl", &["b", "a"]),
        ("mtllib ../elsewhere/b.mtl", &["b", "a"]),
        ("mtllib /b.mtl", &["b", "a"]),
    ] {
        let scene = read_with(&format!("{line}\n{FACE}"), &[a, b, c]).expect("read");
        let names: Vec<_> = scene.materials.iter().map(|m| &*m.name).collect();
        assert_eq!((names, scene.notes), (expected.to_vec(), vec![]), "{line}");
    }
    let scene = read_with(&format!("mtllib my materials.mtl\nmtllib b.mtl\n{FACE}"), &[a, b]);
    assert_eq!(
        scene.expect("read").materials[0].kind,
        matte(0.1, 0.1, 0.1),
        "the first one counts"
    );

    let missing = format!("mtllib none.mtl\nusemtl x\n{FACE}");
    let scene = read_with(&missing, &[b]).expect("a note, not an error");
    assert_eq!(scene.meshes[0].1.as_deref(), Some("x"));
    assert_eq!(
        scene.notes,
        ["a.obj: no MTL file \"none.mtl\" in its folder: its materials are missing"]
    );
    for name in ["../../etc/passwd", "/etc/passwd", "below/../../none.mtl", "none.mtl ../x.mtl"] {
        let scene = read_with(&format!("mtllib {name}\n{FACE}"), &[c]).expect("a note");
        let said = format!(
            "a.obj: MTL file \"{name}\" leads out of the folder; move the file beside the scene, \
             or allow this with --allow-path: its materials are missing"
        );
        assert_eq!(scene.notes, [said]);
    }
    let scene = read_with(&format!("mtllib below/\n{FACE}"), &[c]).expect("a note");
    let said = "a.obj: MTL file \"below/\" is a folder, not a file: its materials are missing";
    assert_eq!(scene.notes, [said]);
    let unknown = format!("mtllib b.mtl\nusemtl x\n{FACE}usemtl b\nusemtl y\n");
    let scene = read_with(&unknown, &[b]).expect("a note, not an error");
    assert_eq!(scene.notes, ["a.obj: materials that are in no MTL file: 2 (first \"x\")"]);
}

/// A symbolic link must not lead out of the folder of the scene.
#[cfg(unix)]
#[test]
fn material_files_stay_in_the_folder() {
    let outside = tempfile::tempdir().expect("a folder");
    fs::write(outside.path().join("secret.mtl"), "newmtl secret\n").expect("written");
    let folder = tempfile::tempdir().expect("a folder");
    std::os::unix::fs::symlink(outside.path().join("secret.mtl"), folder.path().join("a.mtl"))
        .expect("linked");
    let path = folder.path().join("a.obj");
    for name in ["a.mtl".to_owned(), outside.path().join("secret.mtl").display().to_string()] {
        fs::write(&path, format!("mtllib {name}\n{FACE}")).expect("written");
        let scene = obj::read(&path, &Limits::default()).expect("read");
        assert!(scene.materials.is_empty(), "{name}");
        assert_eq!(scene.notes.len(), 1);
    }
}
