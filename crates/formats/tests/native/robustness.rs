//! No text makes the reader fail in any way but with an error.

use crate::{HEAD, documented_example, parse};
use rutilant_formats::{Limits, ReadOptions, SceneErrorKind, parse_native};
use std::path::Path;

/// A file that was cut off anywhere.
#[test]
fn cut_off_scenes_give_errors() {
    let text = documented_example();
    for end in (0..text.len()).filter(|end| text.is_char_boundary(*end)) {
        if let Err(error) = parse(&text[..end]) {
            let error = error.to_string();
            assert!(error.starts_with("scene.toml:") && !error.contains('\n'), "{error}");
        }
    }
}

/// Tables in tables in tables: TOML's own limits hold, dotted keys multiply them, and the stack
/// of whoever reads does not matter.
#[test]
fn deep_nesting_ends() {
    let dots = |n: usize| vec!["a"; n].join(".");
    let mut texts = Vec::new();
    for depth in [10, 79, 1000, 10_000] {
        let nested =
            |open: &str, close: &str| format!("{}1{}", open.repeat(depth), close.repeat(depth));
        let inline = nested(&format!("{{ {} = ", dots(79)), "}");
        texts.extend([
            format!("render = {}", nested("[", "]")),
            format!("render = {}", "[".repeat(depth)),
            format!("render = {}", nested("{ a = ", "}")),
            format!("[{}]", dots(depth)),
            format!("{} = 1", dots(depth)),
            format!("{} = {inline}", dots(79)),
            format!("a = {inline}\na = {inline}"),
            format!("[{}]\n{} = {inline}", dots(79), dots(79)),
        ]);
    }
    let read = move || texts.iter().all(|text| parse(&format!("version = 1\n{text}")).is_err());
    let small = std::thread::Builder::new().stack_size(128 << 10).spawn(read).expect("a thread");
    assert!(small.join().expect("no panic"));
}

/// Long names take no more time than their length is worth, and do not fill the screen.
#[test]
fn long_names_are_cut() {
    let long = "a".repeat(1 << 20);
    for text in [
        format!("{long} = 1"),
        format!("[[shape]]\ntype = \"{long}\""),
        format!("[[shape]]\ntype = \"disk\"\nradius = 1\nmaterial = \"{long}\""),
        format!("[render]\nspp = \"{long}\""),
        format!("[render]\nexposure = {}", "9".repeat(1 << 20)),
        format!("[[shape]]\ntype = \"mesh\"\nfile = \"{long}\""),
    ] {
        let error = parse(&format!("{HEAD}{text}")).expect_err("an error").to_string();
        assert!(error.len() < 500, "{} bytes", error.len());
    }
}

/// Limits hold for everything that the text asks for, together.
#[test]
fn limits_hold() {
    let mesh = "[[shape]]\ntype = \"mesh\"\nmaterial = \"grey\"
        positions = [[0, 0, 0], [1, 0, 0], [1, 1, 0]]\ntriangles = [[0, 1, 2]]\n";
    let disk = "[[shape]]\ntype = \"disk\"\nmaterial = \"grey\"\nradius = 1\n";
    let many = Limits::default();
    for (limits, shape, fits) in [
        (Limits { vertices: 8, ..many }, mesh, 2),
        (Limits { triangles: 3, ..many }, mesh, 3),
        (Limits { objects: 4, ..many }, disk, 4),
    ] {
        let options = ReadOptions { limits, ..ReadOptions::default() };
        let read = |n| {
            let text = format!("{HEAD}{}", shape.repeat(n));
            parse_native(&text, Path::new("scene.toml"), &options)
        };
        assert!(read(fits).is_ok());
        let kind = read(fits + 1).expect_err("too many").kind;
        assert!(matches!(kind, SceneErrorKind::Limit { .. }), "{kind}");
    }
}
