//! STL: ASCII and binary, told apart whatever they begin with.

mod common;

use rutilant::geom::Vec3;
use rutilant::shape::Mesh;
use rutilant_formats::scene::stl;
use rutilant_formats::{Limits, ReadOptions, read_scene};
use std::fs;
use std::path::Path;

fn try_read(bytes: &[u8]) -> Result<(Mesh, Vec<String>), String> {
    stl::read_bytes(bytes, Path::new("a.stl"), &Limits::default()).map_err(|e| e.to_string())
}

fn corpus(name: &str) -> Vec<u8> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/corpus/stl/");
    fs::read(format!("{folder}{name}")).expect("a file")
}

/// The same tetrahedron in ASCII, in binary, and in binary that begins with `solid`: four corners,
/// each stored once, and fronts outside.
#[test]
fn kinds_agree() {
    let (ascii, notes) = try_read(&corpus("ascii.stl")).expect("read");
    assert!(notes.is_empty());
    assert_eq!(ascii.name, "tetra hedron");
    assert_eq!(ascii.positions.len(), 4);
    assert_eq!(ascii.triangles, [[0, 1, 2], [0, 2, 3], [0, 3, 1], [2, 1, 3]]);
    assert!(ascii.normals.is_empty());
    for binary in ["binary.stl", "solid.stl"] {
        let (mesh, notes) = try_read(&corpus(binary)).expect("read");
        assert!(notes.is_empty());
        assert_eq!(
            (mesh.positions, mesh.triangles),
            (ascii.positions.clone(), ascii.triangles.clone())
        );
    }
    // Six times the volume of the corner of a cube is 1, if all fronts are outside.
    let corner = |i: u32| ascii.positions[i as usize];
    let volume: f32 =
        ascii.triangles.iter().map(|[a, b, c]| corner(*a).dot(corner(*b).cross(corner(*c)))).sum();
    assert_eq!(volume, 1.0);
}

/// Letters of any size, words on any lines, several solids, a facet of four corners, −0 and 0.
#[test]
fn spellings_agree() {
    let text = b"SOLID\nFacet Normal 0 0 1 Outer Loop\r\nvertex 0 0 0 vertex 1 0 0\rvertex 1 1 0 \
        vertex -0 1 -0 endloop EndFacet endsolid\nsolid b\nfacet normal nan 0 0 outer loop vertex 0 0 0 \
        vertex 1 1 0 vertex 0 0 1 endloop endfacet\nendsolid b c\n";
    let (mesh, notes) = try_read(text).expect("read");
    assert_eq!((mesh.positions.len(), mesh.triangles.len()), (5, 3));
    assert_eq!(mesh.positions[4], Vec3::Z);
    assert_eq!(notes, ["a.stl: its 2 solids are taken together as one mesh"]);
    assert_eq!(try_read(b"solid\nendsolid\n").expect("read").0.triangles.len(), 0);
}

/// Each mistake with its one line.
#[test]
fn errors_name_the_place() {
    let binary = corpus("binary.stl");
    let mut short = binary.clone();
    short.truncate(200);
    let mut long = binary.clone();
    long.extend(b"more");
    let (mesh, notes) = try_read(&long).expect("read");
    assert_eq!(mesh.triangles.len(), 4);
    assert_eq!(notes, ["a.stl: 4 bytes behind the last facet are left out"]);
    for (bytes, said) in [
        (&short[..], "a.stl: the file ends in facet 2 of 4"),
        (
            b"",
            "a.stl: this is no STL file: it neither begins with \"solid\" nor has as many bytes as a \
               binary one",
        ),
        (b"solid a\nfacet normal 0 0\n", "a.stl:3:1: the file ends where a number should stand"),
        (b"solid a\nfacet normal 0 0 x", "a.stl:2:18: \"x\" instead of a number"),
        (b"solid a\n  face", "a.stl:2:3: \"face\" instead of \"facet\" or \"endsolid\""),
        (
            b"solid\nfacet normal 0 0 0 outer loop vertex 0 0 0 endloop",
            "a.stl:2:30: a facet has 1 corners, but needs 3",
        ),
        (b"solid\nendsolid\nx", "a.stl:3:1: \"x\" instead of \"solid\""),
    ] {
        assert_eq!(try_read(bytes).map(|_| ()).expect_err("refused"), said);
    }
    // A count that the bytes do not back takes no memory.
    let mut liar = binary;
    liar[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    assert_eq!(
        try_read(&liar).map(|_| ()).expect_err("refused"),
        "a.stl: the file ends in facet 4 of 4294967295"
    );
    let limits = Limits { triangles: 3, ..Limits::default() };
    for name in ["binary.stl", "ascii.stl"] {
        let read = stl::read_bytes(&corpus(name), Path::new("a.stl"), &limits);
        let said = read.map(|_| ()).expect_err("refused").to_string();
        assert!(said.contains("4 triangles, but at most 3 are allowed"), "{said}");
    }
    common::cut_everywhere(&corpus("ascii.stl"), |cut| drop(try_read(cut)));
}

/// A bare STL file is a scene, as other meshes are.
#[test]
fn bare_meshes_are_scenes() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("part.STL");
    fs::write(&path, corpus("solid.stl")).expect("written");
    let loaded = read_scene(&path, &ReadOptions::default()).expect("read");
    assert_eq!(loaded.scene.objects.len(), 1);
    assert!(loaded.scene.environment.is_some());
}
