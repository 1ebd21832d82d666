//! Every mistake in a file of any format: one line that leads to its place, exit status 2, and
//! nothing on standard output.
//!
//! The lines are read as somebody reads them who made the mistake. More mistakes in native scenes
//! stand in the tests of `rutilant-formats`; here the program is asked, with files on a disk.

use std::fs;
use std::path::Path;
use std::process::Command;

/// The least that a scene needs, and a material. Text after it starts in line 8.
const HEAD: &str = "version = 1\ncamera.position = [0, 0, 5]\ncamera.look_at = [0, 0, 0]\n\
    [[material]]\nname = \"grey\"\ntype = \"matte\"\n\n";

/// A native scene and what is said about it, behind the file's name.
const SCENES: &[(&str, &str)] = &[
    ("", r#":1:1: the scene needs "version": begin it with "version = 1""#),
    ("version = 1", ":1:1: there is no [camera], and no shape that one could be turned to"),
    ("version = 2", ":1:11: version 2 of the scene format is not known; 1 is"),
    ("Version = 1", r#":1:1: no key "Version"; did you mean "version"?"#),
    ("version = 1\n[camera", ":2:8: unclosed table, expected `]`"),
    ("version = 1\nspp = 4", r#":2:1: no key "spp" in the scene, only in [render]"#),
    ("version = 1\ncamera = 5", ":2:10: camera must be a table, not the number 5"),
    (
        "version = 1\n[camera]\nposition = [0, 0, 0]\nlook_at = [0, 0, 0]",
        ":2:1: the camera has no direction: position and look_at are the same point, or too far apart",
    ),
    (
        "{ \"version\": 1 }",
        ":1:1: invalid key-value pair, expected key; scenes are written in TOML: see docs/scene-format.md",
    ),
    (
        "<scene version=\"3.0.0\"/>",
        ":1:8: key with no value, expected `=`; scenes are written in TOML: see docs/scene-format.md",
    ),
    (
        "version = 1\nrender.size = [99999999999999999999, 1]",
        ":2:16: size holds 99999999999999999999, which is too large",
    ),
    // A byte order mark and the line ends of other systems move no place.
    ("\u{feff}version = 1\n[render]\nspp = 0\n", ":3:7: spp is 0, but must be 1 or more"),
    (
        "version = 1\r\n[render]\r\nspp = -4\r\n",
        ":3:7: spp must be a whole number, 0 or more, not the number -4",
    ),
    (
        "version = 1\n\0",
        ":2:2: key with no value, expected `=`; the line holds bytes that are no text",
    ),
];

/// The same, for text that stands after [`HEAD`].
const AFTER_HEAD: &[(&str, &str)] = &[
    (
        "[render]\nspp = \"many\"",
        r#":9:7: spp must be a whole number, 0 or more, not the text "many""#,
    ),
    ("[render]\nfilter = \"triangle\"", r#":9:10: no filter "triangle"; did you mean "tent"?"#),
    (
        "[render]\nsampler = \"halton\"",
        r#":9:11: no sampler "halton"; there are sobol, independent"#,
    ),
    (
        "[render]\nfilter = \"box\"\nfilter_sigma = 1",
        r#":10:16: filter_sigma is for filter = "gaussian" only"#,
    ),
    (
        "[render]\nexposure = 1e999",
        ":9:12: exposure holds the number 1e999, but must be finite, at most 3.4028235e38",
    ),
    (
        "[[shape]]\ntype = \"sphere\"\nradius = -1\nmaterial = \"grey\"",
        ":10:10: radius is -1, but must be more than 0",
    ),
    (
        "[[shape]]\ntype = \"cube\"\nsize = 1\nmaterial = \"grey\"",
        r#":9:8: no shape type "cube"; did you mean "box"?"#,
    ),
    (
        "[[shape]]\ntype = \"box\"\nsize = 1\nmaterial = \"grey\"",
        ":10:8: size must be three numbers [x, y, z], not the number 1",
    ),
    (
        "[[shape]]\ntype = \"sphere\"\nradius = 1\nmaterial = \"gold\"",
        r#":11:12: no material "gold"; there is only grey"#,
    ),
    (
        "[[material]]\nname = \"g\"\ntype = \"conductor\"",
        r#":8:1: a conductor needs "metal" or "eta""#,
    ),
    (
        "[[material]]\nname = \"m\"\ntype = \"mix\"\nfirst = \"grey\"\nsecond = \"grey\"\namount = 2",
        ":13:10: amount is 2, but must lie between 0 and 1",
    ),
    ("[[light]]\ntype = \"sun\"", r#":9:8: no light type "sun"; did you mean "directional"?"#),
    (
        "[[light]]\ntype = \"point\"\nposition = [0, 0]\nintensity = 1",
        ":10:12: position must be three numbers [x, y, z], not an array with 2 entries",
    ),
    ("[environment]\ncolor = -1", ":9:9: color is -1, but must lie between 0 and 1e18"),
    // Files that a scene names.
    (
        "[[shape]]\ntype = \"mesh\"\nfile = \"../secret.obj\"\nmaterial = \"grey\"",
        r#":10:8: "../secret.obj" leads out of the scene's folder; move the file beside the scene, or allow this with --allow-path"#,
    ),
    (
        "[[shape]]\ntype = \"mesh\"\nfile = \"/etc/passwd\"\nmaterial = \"grey\"",
        r#":10:8: "/etc/passwd" leads out of the scene's folder; move the file beside the scene, or allow this with --allow-path"#,
    ),
    (
        "[[shape]]\ntype = \"mesh\"\nfile = \"none.obj\"\nmaterial = \"grey\"",
        r#":10:8: there is no file "none.obj" beside the scene"#,
    ),
    (
        "[[shape]]\ntype = \"mesh\"\nfile = \"a.off\"\nmaterial = \"grey\"",
        ":10:8: no mesh format .off; there are .obj, .ply, .stl, .gltf, .glb",
    ),
    (
        "[[shape]]\ntype = \"mesh\"\nfile = \"folder.obj\"\nmaterial = \"grey\"",
        r#":10:8: "folder.obj" is a folder, not a file"#,
    ),
    (
        "[environment]\nimage = \"none.hdr\"",
        r#":9:9: there is no file "none.hdr" beside the scene"#,
    ),
    (
        "[environment]\nimage = \"bad.hdr\"",
        r#":9:9: bad.hdr: "-Y 5" is not a resolution like "-Y 512 +X 1024""#,
    ),
    (
        "[environment]\nimage = \"sky.gif\"",
        ":9:9: sky.gif: no image format .gif; there are .exr, .hdr, .pfm, .png, .jpg, .webp, .tga",
    ),
    ("[environment]\nimage = \"bad.pfm\"", r#":9:9: bad.pfm: "x" is not a height"#),
    ("[environment]\nimage = \"cut.png\"", ":9:9: cut.png: the file ends in its header"),
    ("[environment]\nimage = \"cut.exr\"", ":9:9: cut.exr: the file ends early"),
    ("[environment]\nimage = \"cut.jpg\"", ":9:9: cut.jpg: the file ends before its picture does"),
    // The mistake of a file that is named stands in that file.
    (
        "[[shape]]\ntype = \"mesh\"\nfile = \"bad.obj\"\nmaterial = \"grey\"",
        "bad.obj:4:7: face names vertex 9, but only 3 are declared so far",
    ),
];

/// Three vertices; text after them starts in line 4.
const VERTICES: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

/// An OBJ file after [`VERTICES`], and what is said about it.
const OBJ: &[(&str, &str)] = &[
    ("", ": there is nothing to see: there are no faces"),
    (
        "v 1e38 0 0\nf 1 2 4\n",
        ": it is too large: a camera that sees all of it would be farther away than single \
         precision reaches",
    ),
    ("f 1 2 4\n", ":4:7: face names vertex 4, but only 3 are declared so far"),
    ("f 0 1 2\n", ":4:3: face names vertex 0, but they are numbered from 1 (or from -1 backwards)"),
    ("f -4 1 2\n", ":4:3: face names vertex -4, but only 3 are declared so far"),
    ("f 1/1 2/1 3/1\n", ":4:5: face names texture coordinate 1, but none is declared so far"),
    ("f 1//1 2 3\n", ":4:6: face names normal 1, but none is declared so far"),
    ("f 1 2 x\n", r#":4:7: "x" is not a vertex number"#),
    ("f 1,2,3\n", r#":4:3: "1,2,3" is not a corner; those are v, v/vt, v//vn or v/vt/vn"#),
    ("f 1 2 3/a\n", r#":4:9: "a" is not a texture coordinate number"#),
    (
        "f 1 2 99999999999999999999\n",
        ":4:7: face names vertex 99999999999999999999, but only 3 are declared so far",
    ),
    ("f 1 2 \0\n", r#":4:7: "\0" is not a vertex number"#),
    ("v 1 1\n", ":4:6: v needs 3 numbers, but there are only 2"),
    ("v 0 0 zero\n", r#":4:7: "zero" is not a number"#),
    ("v 0 0 1,5\n", r#":4:7: "1,5" is not a number"#),
    ("vt\n", ":4:3: vt needs a number"),
    ("f 1 2 \\\r\n 7\r\n", ":5:2: face names vertex 7, but only 3 are declared so far"),
    // Its MTL file has the mistake.
    ("mtllib first.mtl\nf 1 2 3\n", r#"first.mtl:1:1: "Kd" stands before the first newmtl"#),
    ("mtllib name.mtl\nf 1 2 3\n", "name.mtl:1:1: newmtl needs a name"),
    ("mtllib number.mtl\nf 1 2 3\n", r#"number.mtl:2:4: "red" is not a number"#),
    ("mtllib infinite.mtl\nf 1 2 3\n", "infinite.mtl:2:4: Ni is inf, but must be finite"),
];

/// A PLY file with a triangle.
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n\
    property float y\nproperty float z\nelement face 1\n\
    property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

/// What in [`PLY`] is replaced by what, and what is said about the result.
const PLY_MISTAKES: &[(&str, &str, &str)] = &[
    ("ply\n", "plx\n", r#": this is not a PLY file: it does not begin with "ply""#),
    (
        "ascii",
        "binary",
        r#":2:8: no format "binary"; there are ascii, binary_little_endian and binary_big_endian"#,
    ),
    ("1.0", "2.0", r#":2:14: PLY version "2.0", but only 1.0 is known"#),
    ("format ascii 1.0\n", "", r#":8:11: the header has no "format" line"#),
    ("vertex 3", "vertex many", r#":3:16: "many" is not a count of elements"#),
    ("vertex 3", "vertex -3", r#":3:16: "-3" is not a count of elements"#),
    (
        "vertex 3",
        "vertex 3000000000",
        r#":3:1: 3000000000 elements "vertex" are declared, which take at least 18000000000 bytes, but only 26 are left"#,
    ),
    (
        "face 1",
        "face 4000000000",
        r#":7:1: 4000000000 elements "face" are declared, which take at least 8000000000 bytes, but only 9 are left"#,
    ),
    ("vertex 3", "vertices 3", r#": the header has no element "vertex""#),
    (
        "float x",
        "flaot x",
        r#":4:10: no type "flaot"; there are char, uchar, short, ushort, int, uint, float and double"#,
    ),
    ("float z", "float w", r#":3:1: element "vertex" has no property "z""#),
    ("float z", "float", ":6:15: the property has no name"),
    ("uchar int", "float int", ":8:15: the count of a list must be of an integer type"),
    ("uchar int", "uchar float", r#":8:1: "vertex_indices" must be of an integer type"#),
    ("vertex_indices", "corners", r#":7:1: element "face" has no list "vertex_indices""#),
    (
        "element vertex 3\n",
        "property float x\nelement vertex 3\n",
        ":3:1: a property before the first element",
    ),
    (
        "element face",
        "element vertex 1\nelement face",
        r#":7:9: element "vertex" is declared twice"#,
    ),
    (
        "element face",
        "elemnt face",
        r#":7:1: no header keyword "elemnt"; there are format, comment, obj_info, element, property and end_header"#,
    ),
    (
        "end_header",
        "end",
        r#":9:1: no header keyword "end"; there are format, comment, obj_info, element, property and end_header"#,
    ),
    ("0 0 0\n1", "a 0 0\n1", r#":10:1: "a" in vertex 0 is not a number of its type"#),
    ("3 0 1 2", "3 0 one 2", r#":13:5: "one" in face 0 is not a number of its type"#),
    ("3 0 1 2", "3 0 1 3", ":13:7: face 0 names vertex 3, but there are only 3 (numbered from 0)"),
    (
        "3 0 1 2",
        "3 0 1 -1",
        ":13:7: face 0 names vertex -1, but there are only 3 (numbered from 0)",
    ),
    (
        "3 0 1 2\n",
        "3 0 1",
        r#":13:1: face 0 has a list "vertex_indices" of 3 numbers, but only 4 bytes are left"#,
    ),
    (
        "3 0 1 2",
        "9 0 1 2",
        r#":13:1: face 0 has a list "vertex_indices" of 9 numbers, but only 7 bytes are left"#,
    ),
    (
        "format ascii",
        "format binary_big_endian",
        r#":3:1: 3 elements "vertex" are declared, which take at least 36 bytes, but only 26 are left"#,
    ),
];

/// What the program says about a file of the given name in `folder`.
fn said(folder: &Path, name: &str) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rutilant"));
    let ran = command.current_dir(folder).args(["check", name]).output().unwrap();
    let text = String::from_utf8(ran.stderr).unwrap();
    assert_eq!((ran.status.code(), &*ran.stdout), (Some(2), &b""[..]), "{name}: {text}");
    text
}

/// Lines of every mistake, with exit status 2; and enough of them.
#[test]
fn every_mistake_is_one_line_and_status_2() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).unwrap();
    fs::create_dir(folder.path().join("folder.obj")).unwrap();
    write("bad.obj", format!("{VERTICES}f 1 2 9\n").as_bytes());
    write("first.mtl", b"Kd 1 1 1\n");
    write("name.mtl", b"newmtl\n");
    write("number.mtl", b"newmtl a\nKd red\n");
    write("infinite.mtl", b"newmtl a\nNi 1e99\n");
    write("a.off", b"OFF\n");
    write("sky.gif", b"GIF89a");
    write("bad.hdr", b"#?RADIANCE\n\n-Y 5\n");
    write("bad.pfm", b"PF\n2 x\n");
    write("cut.png", b"\x89PNG\r\n\x1a\n");
    write("cut.exr", b"\x76\x2f\x31\x01\x02\0\0\0chan");
    write("cut.jpg", b"\xff\xd8\xff\xe0");

    let mut cases: Vec<(&str, Vec<u8>, &str)> = Vec::new();
    cases.extend(SCENES.iter().map(|&(text, said)| ("a.toml", text.into(), said)));
    let after = AFTER_HEAD.iter().map(|&(text, said)| (format!("{HEAD}{text}"), said));
    cases.extend(after.map(|(text, said)| ("a.toml", text.into(), said)));
    let after = OBJ.iter().map(|&(text, said)| (format!("{VERTICES}{text}"), said));
    cases.extend(after.map(|(text, said)| ("a.obj", text.into(), said)));
    for &(from, to, said) in PLY_MISTAKES {
        assert!(PLY.contains(from), "{from}");
        cases.push(("a.ply", PLY.replacen(from, to, 1).into(), said));
    }
    for (name, bytes, said) in [
        (
            "a.toml",
            &b"version = 1\n# \xe4"[..],
            ":2:3: the text is not UTF-8 here; save the file as UTF-8",
        ),
        ("a.obj", b"hello\n", r#":1:1: "hello" begins no OBJ statement"#),
        ("a.obj", b"f 1 2 3\nv 0 0 0\n", ":1:3: face names vertex 1, but none is declared so far"),
        ("a.ply", b"ply\nformat ascii 1.0\n", r#":3:1: the header has no "end_header""#),
        (
            "a.xyz",
            b"",
            ": no scene format .xyz; there are .toml, .gltf, .glb, .pbrt, .xml, .obj, .ply, .stl",
        ),
        (
            "a",
            b"",
            ": no extension, so no scene format; there are .toml, .gltf, .glb, .pbrt, .xml, .obj, .ply, .stl",
        ),
    ] {
        cases.push((name, bytes.to_vec(), said));
    }

    assert!(cases.len() >= 60, "{} mistakes", cases.len());
    let mut wrong = Vec::new();
    for (name, bytes, expected) in cases {
        write(name, &bytes);
        // What is said names this file, or that of which it speaks.
        let expected = match expected.starts_with(':') {
            true => format!("{name}{expected}\n"),
            false => format!("{expected}\n"),
        };
        let said = said(folder.path(), name);
        if said != expected {
            wrong.push(format!(
                "{}\n  says {said}  not  {expected}",
                String::from_utf8_lossy(&bytes)
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    for (name, expected) in [
        ("none.toml", "none.toml: No such file or directory (os error 2)\n"),
        ("folder.obj", "folder.obj: this is a folder, not a file\n"),
    ] {
        assert_eq!(said(folder.path(), name), expected);
    }
}
