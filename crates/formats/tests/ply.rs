//! PLY: every spelling of the same mesh is the same mesh, and lies are refused.

mod common;

use common::cut_everywhere;
use rutilant::geom::{Vec2, Vec3};
use rutilant::shape::Mesh;
use rutilant_formats::Limits;
use rutilant_formats::scene::ply;
use std::path::Path;

fn read(bytes: &[u8]) -> (Mesh, Vec<String>) {
    ply::read_bytes(bytes, Path::new("a.ply"), &Limits::default())
        .unwrap_or_else(|error| panic!("{error}"))
}

fn refusal(bytes: &[u8]) -> String {
    let result = ply::read_bytes(bytes, Path::new("a.ply"), &Limits::default());
    result.map(|(mesh, _)| mesh).expect_err("refused").to_string()
}

/// A header of lines, and a body.
fn file(header: &str, body: &[u8]) -> Vec<u8> {
    let mut bytes = format!("ply\n{header}end_header\n").into_bytes();
    bytes.extend(body);
    bytes
}

const TRIANGLE: &str = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
    element face 1\nproperty list uchar int vertex_indices\n";

fn ascii_triangle() -> Vec<u8> {
    file(&format!("format ascii 1.0\n{TRIANGLE}"), b"0 0 0\n1 0 0\n0 1.5 0\n3 0 1 2\n")
}

fn binary_triangle(big: bool) -> Vec<u8> {
    let name = if big { "big" } else { "little" };
    let mut body = Vec::new();
    for value in [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.5_f32, 0.0] {
        body.extend(if big { value.to_be_bytes() } else { value.to_le_bytes() });
    }
    body.push(3);
    for index in [0, 1, 2_i32] {
        body.extend(if big { index.to_be_bytes() } else { index.to_le_bytes() });
    }
    file(&format!("format binary_{name}_endian 1.0\n{TRIANGLE}"), &body)
}

/// What a file "a.ply" that has nothing would be: meshes are named after their files.
fn empty() -> Mesh {
    Mesh { name: "a".to_owned(), ..Mesh::default() }
}

fn triangle() -> Mesh {
    Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(0.0, 1.5, 0.0)],
        triangles: vec![[0, 1, 2]],
        ..empty()
    }
}

/// ASCII, little and big endian, with the three line ends, with comments: one mesh.
#[test]
fn formats_agree() {
    let text = String::from_utf8(ascii_triangle()).expect("text");
    let files = [
        ascii_triangle(),
        binary_triangle(false),
        binary_triangle(true),
        text.replace('\n', "\r\n").into_bytes(),
        text.replace('\n', "\r").into_bytes(),
        text.replace("element face", "comment it's a face\nobj_info x\n\nelement face")
            .into_bytes(),
        text.replace("ascii 1.0", "ascii 1.0   ").trim_end().as_bytes().to_vec(),
        text.replace("1 0 0\n0", "1\n0 0 0").into_bytes(),
    ];
    for bytes in files {
        let (mesh, notes) = read(&bytes);
        assert_eq!((mesh, notes), (triangle(), vec![]), "{}", String::from_utf8_lossy(&bytes));
    }
}

/// Every number type, under both of its names, gives its value.
#[test]
fn all_number_types_are_read() {
    let types: [(&str, &str, &[u8]); 8] = [
        ("char", "int8", &[0xfe]),
        ("uchar", "uint8", &[0xfe]),
        ("short", "int16", &[0xfe, 0xff]),
        ("ushort", "uint16", &[0xfe, 0xff]),
        ("int", "int32", &[0xfe, 0xff, 0xff, 0xff]),
        ("uint", "uint32", &[0xfe, 0xff, 0xff, 0xff]),
        ("float", "float32", &(-2.0_f32).to_le_bytes()),
        ("double", "float64", &(-2.0_f64).to_le_bytes()),
    ];
    let expected = [-2.0, 254.0, -2.0, 65534.0, -2.0, 4_294_967_294.0_f32, -2.0, -2.0];
    for ((old, new, bytes), expected) in types.into_iter().zip(expected) {
        for name in [old, new] {
            let header = format!(
                "format binary_little_endian 1.0\nelement vertex 1\nproperty uchar x\n\
                 property uchar y\nproperty {name} z\n"
            );
            let (mesh, _) = read(&file(&header, &[&[1, 2], bytes].concat()));
            assert_eq!(mesh.positions, [Vec3::new(1.0, 2.0, expected)], "{name}");
        }
    }
}

/// Normals and all names of texture coordinates, in any order, between properties and elements
/// that are stepped over exactly, lists included.
#[test]
fn properties_are_found_among_others() {
    for [u, v] in [["u", "v"], ["s", "t"], ["texture_u", "texture_v"], ["texture_s", "texture_t"]] {
        let header = format!(
            "format ascii 1.0\nelement camera 2\nproperty list int float path\nproperty int id\n\
             element empty 4000000000\n\
             element vertex 3\nproperty uchar red\nproperty float {v}\nproperty float nz\n\
             property float ny\nproperty float nx\nproperty list uchar short weights\n\
             property double z\nproperty double y\nproperty double x\nproperty float {u}\n\
             element face 1\nproperty uchar flag\nproperty list uchar float texcoord\n\
             property list ushort uint vertex_index\n"
        );
        let body = b"2 0.5 0.25 1\n0 2\n\
            255 .2 1 0 0 2 7 8 3 2 1 .1\n255 .4 0 1 0 0 6 5 4 .3\n255 .6 0 0 1 1 9 9 8 7 .5\n\
            1 6 0 0 0 0 0 0 3 2 1 0\n";
        let (mesh, notes) = read(&file(&header, body));
        let expected = Mesh {
            positions: [[1., 2., 3.], [4., 5., 6.], [7., 8., 9.]].map(Vec3::from).to_vec(),
            normals: vec![Vec3::Z, Vec3::Y, Vec3::X],
            uvs: [[0.1, 0.2], [0.3, 0.4], [0.5, 0.6]].map(Vec2::from).to_vec(),
            triangles: vec![[2, 1, 0]],
            ..empty()
        };
        assert_eq!(mesh, expected);
        assert_eq!(
            notes,
            [
                "a.ply: properties of \"vertex\" left out: weights",
                "a.ply: properties of \"face\" left out: flag, texcoord"
            ]
        );
    }
}

/// Lists of any types, as text and in both byte orders: a size mistaken for another loses its
/// place in all that follows.
#[test]
fn lists_of_all_types_are_read() {
    let types = [
        ("char", 1),
        ("uchar", 1),
        ("short", 2),
        ("ushort", 2),
        ("int", 4),
        ("uint", 4),
        ("float", 4),
        ("double", 8),
    ];
    // A small number in as many bytes as its type has.
    let number = |(name, size): (&str, usize), value: u8, big: bool| {
        let bytes = match name {
            "float" => f32::from(value).to_le_bytes().to_vec(),
            "double" => f64::from(value).to_le_bytes().to_vec(),
            _ => u64::from(value).to_le_bytes()[..size].to_vec(),
        };
        if big { bytes.into_iter().rev().collect() } else { bytes }
    };
    let header = |format: &str, count: &str, item: &str| {
        format!(
            "format {format} 1.0\nelement vertex 4\nproperty uchar x\n\
             property list {count} {item} other\nproperty uchar y\nproperty uchar z\n\
             element face 1\nproperty list {count} {item} other\n\
             property list {count} uint vertex_indices\n"
        )
    };
    // Vertices with lists of 0 to 3 numbers; the face has a list of two, and four corners.
    let positions = [[0, 0, 0], [9, 0, 0], [9, 9, 0], [0, 9, 0]];
    let expected: Vec<_> = positions.iter().map(|p| Vec3::from(p.map(f32::from))).collect();
    let mut checked = 0;
    for count in &types[..6] {
        for item in types {
            let text = "0 0 0 0\n9 1 5 0 0\n9 2 5 6 9 0\n0 3 5 6 7 9 0\n2 7 7 4 0 1 2 3\n";
            let mut files = vec![file(&header("ascii", count.0, item.0), text.as_bytes())];
            for (format, big) in [("binary_little_endian", false), ("binary_big_endian", true)] {
                let mut body = Vec::new();
                for (i, [x, y, z]) in (0..).zip(positions) {
                    body.push(x);
                    body.extend(number(*count, i, big));
                    (0..i).for_each(|k| body.extend(number(item, 5 + k, big)));
                    body.extend([y, z]);
                }
                body.extend(number(*count, 2, big));
                (0..2).for_each(|_| body.extend(number(item, 7, big)));
                body.extend(number(*count, 4, big));
                (0..4).for_each(|v| body.extend(number(("uint", 4), v, big)));
                files.push(file(&header(format, count.0, item.0), &body));
            }
            for bytes in files {
                let (mesh, _) = read(&bytes);
                assert_eq!(mesh.positions, expected, "{count:?} {item:?}");
                assert_eq!(mesh.triangles.len(), 2, "{count:?} {item:?}");
                checked += 1;
            }
        }
    }
    assert_eq!(checked, 6 * 8 * 3);
}

/// Most scans have colours, and a scan is no reason to complain.
#[test]
fn colors_are_no_reason_to_complain() {
    let header = "format ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
        property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n\
        property uchar alpha\nproperty uchar diffuse_red\nelement face 1\n\
        property list uchar int vertex_indices\nproperty uchar red\n";
    let body = b"0 0 0 1 2 3 4 5\n1 0 0 1 2 3 4 5\n0 1 0 1 2 3 4 5\n3 0 1 2 255\n";
    let (mesh, notes) = read(&file(header, body));
    assert_eq!((mesh.triangles, notes), (vec![[0, 1, 2]], vec![]));
}

/// Igea is one long strip over a closed surface without handles: by Euler, 2V - 4 triangles,
/// and every edge has two of them, once in each direction.
#[test]
fn a_real_strip_is_a_closed_surface() {
    let Some(data) = std::env::var_os("RUTILANT_DATA") else {
        eprintln!("skipped: RUTILANT_DATA names no folder with meshes/igea.ply");
        return;
    };
    let path = Path::new(&data).join("meshes/igea.ply");
    let (mesh, notes) = ply::read(&path, &Limits::default()).expect("igea");
    assert_eq!(notes, [""; 0]);
    assert_eq!(mesh.positions.len(), 134_345);
    assert_eq!(mesh.triangles.len(), 2 * mesh.positions.len() - 4);
    let mut edges: Vec<_> =
        mesh.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
    edges.sort_unstable();
    assert!(edges.windows(2).all(|pair| pair[0] != pair[1]), "no edge twice in one direction");
    assert!(edges.iter().all(|&(a, b)| edges.binary_search(&(b, a)).is_ok()), "closed");
}

/// Polygons become triangles, concave ones too, even where faces stand before their vertices.
#[test]
fn polygons_are_cut() {
    let header = "format ascii 1.0\n\
        element face 3\nproperty list uchar int vertex_indices\n\
        element vertex 6\nproperty float x\nproperty float y\nproperty float z\n";
    // An arrow head whose fourth corner points inwards, an L, and a line.
    let body = b"4 0 1 2 3\n6 0 1 4 3 5 2\n2 0 1\n0 0 0\n4 2 0\n0 4 0\n1 2 0\n3 3 0\n0 9 0\n";
    let (mesh, notes) = read(&file(header, body));
    assert_eq!(mesh.triangles[..2], [[0, 1, 3], [1, 2, 3]]);
    assert_eq!(mesh.triangles.len(), 2 + 4);
    assert_eq!(notes, ["a.ply: faces with fewer than 3 vertices, left out: 1 (first face 2)"]);
}

/// Strips: every second triangle is turned, −1 begins anew, and stitches are left out.
#[test]
fn strips_are_read() {
    let header = "format ascii 1.0\n\
        element vertex 6\nproperty float x\nproperty float y\nproperty float z\n\
        element tristrips 1\nproperty list int int vertex_indices\n";
    let points = "0 0 0\n".repeat(6);
    let body = format!("{points}12 0 1 2 3 -1 3 4 5 5 2 1 0\n");
    let (mesh, _) = read(&file(header, body.as_bytes()));
    assert_eq!(mesh.triangles, [[0, 1, 2], [2, 1, 3], [3, 4, 5], [2, 5, 1], [2, 1, 0]]);
}

/// NaN and infinite vertices are the renderer's to leave out, and -0 stays what it is.
#[test]
fn numbers_are_kept_as_they_are() {
    let body = b"nan inf -inf\n-0 1e-45 1e39\n16777217 0.1 3.4028235e38\n3 0 1 2\n";
    let (mesh, _) = read(&file(&format!("format ascii 1.0\n{TRIANGLE}"), body));
    assert!(mesh.positions[0].x.is_nan());
    let bits = |v: Vec3| v.to_array().map(f32::to_bits);
    let expected = [-0.0_f32, 1e-45, f32::INFINITY].map(f32::to_bits);
    assert_eq!(bits(mesh.positions[1]), expected);
    assert_eq!(mesh.positions[2], Vec3::new(16_777_216.0, 0.1, f32::MAX));
}

/// A cloud of points is a mesh in which nothing can be seen, and that is said.
#[test]
fn point_clouds_are_noted() {
    let header = "format ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
    let (mesh, notes) = read(&file(header, b"1 2 3\n4"));
    assert_eq!(mesh.positions.len(), 1);
    assert_eq!(
        notes,
        [
            "a.ply: bytes after the last element, left out: 2",
            "a.ply: there are no faces in it, so nothing of it can be seen"
        ]
    );
}

/// One line for each way to be wrong, with the place where there are lines.
#[test]
fn errors_name_the_place() {
    let text = String::from_utf8(ascii_triangle()).expect("text");
    let with = |from: &str, to: &str| refusal(text.replacen(from, to, 1).as_bytes());
    assert_eq!(refusal(b""), "a.ply: this is not a PLY file: it does not begin with \"ply\"");
    assert_eq!(refusal(b"solid"), "a.ply: this is not a PLY file: it does not begin with \"ply\"");
    assert_eq!(refusal(b"ply\nformat ascii 1.0\n"), "a.ply:3:1: the header has no \"end_header\"");
    assert_eq!(
        with("ascii", "asci"),
        "a.ply:2:8: no format \"asci\"; there are ascii, binary_little_endian and binary_big_endian"
    );
    assert_eq!(with("1.0", "2.0"), "a.ply:2:14: PLY version \"2.0\", but only 1.0 is known");
    assert_eq!(with("format ascii 1.0\n", ""), "a.ply:8:11: the header has no \"format\" line");
    assert_eq!(
        with("element vertex 3", "element vertex -3"),
        "a.ply:3:16: \"-3\" is not a count of elements"
    );
    assert_eq!(with("element vertex 3\n", ""), "a.ply:3:1: a property before the first element");
    assert_eq!(
        with("float y", "real y"),
        "a.ply:5:10: no type \"real\"; there are char, uchar, short, ushort, int, uint, float and double"
    );
    assert_eq!(with("float y", "float"), "a.ply:5:15: the property has no name");
    assert_eq!(
        with("list uchar", "list float"),
        "a.ply:8:15: the count of a list must be of an integer type"
    );
    assert_eq!(
        with("list uchar int", "list uchar float"),
        "a.ply:8:1: \"vertex_indices\" must be of an integer type"
    );
    assert_eq!(
        with("vertex_indices", "corners"),
        "a.ply:7:1: element \"face\" has no list \"vertex_indices\""
    );
    assert_eq!(with("float z", "float w"), "a.ply:3:1: element \"vertex\" has no property \"z\"");
    assert_eq!(
        with("element vertex", "element point"),
        "a.ply: the header has no element \"vertex\""
    );
    assert_eq!(
        with("element face", "element vertex"),
        "a.ply:7:9: element \"vertex\" is declared twice"
    );
    assert_eq!(
        with("element face", "elephant face"),
        "a.ply:7:1: no header keyword \"elephant\"; there are format, comment, obj_info, element, property and end_header"
    );
    assert_eq!(
        with("0 1.5 0", "0 x1.5 0"),
        "a.ply:12:3: \"x1.5\" in vertex 2 is not a number of its type"
    );
    assert_eq!(
        with("3 0 1 2", "3 0 1.0 2"),
        "a.ply:13:5: \"1.0\" in face 0 is not a number of its type"
    );
    assert_eq!(
        with("3 0 1 2", "3 0 3 2"),
        "a.ply:13:5: face 0 names vertex 3, but there are only 3 (numbered from 0)"
    );
    assert_eq!(
        with("3 0 1 2", "3 0 -1 2"),
        "a.ply:13:5: face 0 names vertex -1, but there are only 3 (numbered from 0)"
    );
    assert_eq!(with("3 0 1 2\n", "3 0 1\n"), "a.ply:14:1: the file ends in face 0 of 1");
    assert_eq!(
        with("3 0 1 2\n", "9 0 1\n"),
        "a.ply:13:1: face 0 has a list \"vertex_indices\" of 9 numbers, but only 5 bytes are left"
    );

    let mut binary = binary_triangle(false);
    let at = binary.len() - 4;
    binary[at] = 77;
    assert_eq!(
        refusal(&binary),
        "a.ply: face 0 names vertex 77, but there are only 3 (numbered from 0)"
    );
    assert_eq!(refusal(&binary[..at + 3]), "a.ply: the file ends in face 0 of 1");
    assert_eq!(
        refusal(&binary[..at - 4]),
        "a.ply: face 0 has a list \"vertex_indices\" of 3 numbers, but only 4 bytes are left"
    );
}

/// Counts that the bytes cannot back are refused before memory is taken for them: were it taken,
/// these would need up to 2^64 bytes. The caller's limits end what is merely large.
#[test]
fn lying_counts_take_no_memory() {
    let all = Limits { vertices: u64::MAX, triangles: u64::MAX, ..Limits::default() };
    let refusal = |bytes: &[u8]| {
        let result = ply::read_bytes(bytes, Path::new("a.ply"), &all);
        result.map(|(mesh, _)| mesh).expect_err("refused").to_string()
    };
    for bytes in [ascii_triangle(), binary_triangle(false)] {
        let header_end = bytes.windows(11).position(|w| w == b"end_header\n").expect("a header");
        let (header, body) = bytes.split_at(header_end);
        let header = String::from_utf8(header.to_vec()).expect("text");
        for (element, count) in [
            ("vertex 3", "vertex 4000000000"),
            ("vertex 3", "vertex 99999999999999999999999999"),
            ("face 1", "face 4000000000"),
        ] {
            let lie = header.replace(element, count);
            let text = refusal(&[lie.as_bytes(), body].concat());
            assert!(text.contains("are declared, which take at least"), "{text}");
        }
        let lie = header.replace("list uchar", "list uint");
        let mut body = body.to_vec();
        if header.contains("ascii") {
            body = String::from_utf8(body).expect("text").replace("3 0 1", "4000000000 0 1").into();
        } else {
            let count = body.len() - 13;
            body[count..count + 4].copy_from_slice(&[0xff; 4]);
        }
        let text = refusal(&[lie.as_bytes(), &body].concat());
        assert!(text.contains("has a list \"vertex_indices\" of 4"), "{text}");
    }
    let tight = Limits { vertices: 2, ..Limits::default() };
    let error = ply::read_bytes(&ascii_triangle(), Path::new("a.ply"), &tight).expect_err("tight");
    assert_eq!(
        error.to_string(),
        "a.ply:3:1: 3 vertices, but at most 2 are allowed; allow more with --limit vertices=N"
    );
    let tight = Limits { triangles: 0, ..Limits::default() };
    let error = ply::read_bytes(&ascii_triangle(), Path::new("a.ply"), &tight).expect_err("tight");
    assert_eq!(
        error.to_string(),
        "a.ply:7:1: 1 triangle, but at most 0 are allowed; allow more with --limit triangles=N"
    );
}

/// A mesh that uses all of the format, for damaging.
fn rich(format: &str) -> Vec<u8> {
    let header = format!(
        "format {format} 1.0\ncomment all of it\n\
         element face 2\nproperty uchar flag\nproperty list uchar short vertex_index\n\
         element vertex 5\nproperty float x\nproperty double y\nproperty short z\n\
         property float nx\nproperty float ny\nproperty float nz\nproperty float s\n\
         property float t\nproperty list uchar int more\n\
         element tristrips 1\nproperty list int int vertex_indices\n"
    );
    let mut body = Vec::new();
    let ascii = format == "ascii";
    let mut put = |value: f64, bytes: &[u8]| {
        if ascii { body.extend(format!("{value} ").bytes()) } else { body.extend(bytes) }
    };
    let short = |v: i16| v.to_le_bytes();
    for face in [&[0, 1, 2][..], &[0, 1, 2, 3, 4]] {
        put(1.0, &[1]);
        put(face.len() as f64, &[face.len() as u8]);
        face.iter().for_each(|&v| put(f64::from(v), &short(v)));
    }
    for i in 0..5_i16 {
        let v = f32::from(i);
        put(v.into(), &v.to_le_bytes());
        put((v * v).into(), &f64::from(v * v).to_le_bytes());
        put(7.0, &short(7));
        (0..5).for_each(|_| put(0.5, &0.5_f32.to_le_bytes()));
        put(1.0, &[1]);
        put(9.0, &9_i32.to_le_bytes());
    }
    put(4.0, &4_i32.to_le_bytes());
    [0, 1, -1, 2].iter().for_each(|&v: &i32| put(v.into(), &v.to_le_bytes()));
    file(&header, &body)
}

/// A file cut short anywhere is refused; an ASCII one may lose the blank at its end.
#[test]
fn files_cut_short_are_refused() {
    for format in ["ascii", "binary_little_endian"] {
        let bytes = rich(format);
        let (whole, _) = read(&bytes);
        assert_eq!((whole.positions.len(), whole.triangles.len()), (5, 4));
        cut_everywhere(&bytes, |cut| {
            let result = ply::read_bytes(cut, Path::new("a.ply"), &Limits::default());
            assert!(
                result.is_err() || (format == "ascii" && cut.len() + 1 == bytes.len()),
                "{format} was read from {} of {} bytes",
                cut.len(),
                bytes.len()
            );
        });
    }
}

/// What materials can use is read by the names that other programs give it, or by ours where they have
/// none; what is not whole is left out with a note, and colours in whole numbers without one.
#[test]
fn further_properties_of_vertices_are_read() {
    let vertex = |properties: &str, values: &str| {
        let header = format!(
            "format ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n\
             property float z\n{properties}element face 0\nproperty list uchar int vertex_indices\n"
        );
        read(&file(&header, format!("1 2 3 {values}\n").as_bytes()))
    };
    let floats = |names: &str| -> String {
        names.split(' ').map(|name| format!("property float {name}\n")).collect()
    };
    let faceless = "a.ply: there are no faces in it, so nothing of it can be seen";

    let names = "t1 s1 tw red alpha s t tx tz ty blue green u3 v3";
    let (mesh, notes) = vertex(&floats(names), "1 2 -1 0.25 4 5 6 7 8 9 10 11 12 13");
    assert_eq!(notes, [faceless]);
    assert_eq!(mesh.uvs, [Vec2::new(5.0, 6.0)]);
    let sets = vec![vec![Vec2::new(2.0, 1.0)], vec![], vec![Vec2::new(12.0, 13.0)]];
    assert_eq!(mesh.more_uvs, sets);
    assert_eq!(mesh.tangents, [[7.0, 9.0, 8.0, -1.0]]);
    assert_eq!(mesh.colors, [[0.25, 11.0, 10.0, 4.0]]);

    // Without a side a tangent says nothing; without alpha a colour covers all.
    let (mesh, notes) =
        vertex(&floats("tx ty tz bx by bz red green blue"), "1 0 0 0 1 0 0.1 0.2 0.3");
    let left_out = "a.ply: properties of \"vertex\" left out: tx, ty, tz, bx, by, bz";
    assert_eq!(notes, [left_out, faceless]);
    assert!(mesh.tangents.is_empty());
    assert_eq!(mesh.colors, [[0.1, 0.2, 0.3, 1.0]]);

    // A scan.
    let colors: String =
        ["red", "green", "blue", "alpha"].map(|name| format!("property uchar {name}\n")).concat();
    let (mesh, notes) = vertex(&colors, "255 128 0 255");
    assert_eq!(notes, [faceless]);
    assert_eq!(mesh, Mesh { positions: vec![Vec3::new(1.0, 2.0, 3.0)], ..empty() });
}
