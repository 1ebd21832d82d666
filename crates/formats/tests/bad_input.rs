//! What other renderers broke on, from the file to the picture. The classes stand in
//! `tests/README.md`, each with the tests that hold it.

use rutilant::image::Image;
use rutilant::{Prepared, Session};
use rutilant_formats::{ReadOptions, read_scene};
use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// A scene of 24x16 pixels that shows `mesh.obj`, or `mesh.ply`, and a ball.
fn scene(mesh: &str) -> String {
    format!(
        r#"version = 1
render = {{ size = [24, 16], spp = 4, max_depth = 4 }}
camera = {{ position = [0, 0, 6], look_at = [0, 0, 0], fov_degrees = 30 }}
environment = {{ color = [0.5, 0.7, 0.9] }}
[[material]]
name = "m"
type = "matte"
albedo = [0.6, 0.4, 0.2]
[[shape]]
type = "mesh"
file = "{mesh}"
material = "m"
[[shape]]
type = "sphere"
radius = 0.4
center = [0, 0, 1]
material = "m"
"#
    )
}

/// What came of a scene.
struct Rendered {
    image: Image,
    /// What was said about it while it was read and prepared.
    notes: Vec<String>,
}

/// Renders a scene file. Nothing in it may make a sample that is no number.
fn render(path: &Path) -> Rendered {
    let loaded =
        read_scene(path, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    let prepared = Prepared::new(&loaded.scene).unwrap_or_else(|problem| panic!("{problem}"));
    let mended = prepared.report().notes.iter().map(ToString::to_string);
    let notes = loaded.notes.into_iter().chain(mended).collect();
    let session = Session::start(Arc::new(prepared), loaded.settings, 1).expect("settings");
    assert!(session.wait(Duration::from_secs(60)), "no end");
    let progress = session.progress();
    assert_eq!((progress.samples, progress.dropped.count), (progress.target, 0));
    let image = session.snapshot();
    assert!(image.channels().iter().all(|c| c.values.iter().all(|v| v.is_finite())));
    Rendered { image, notes }
}

/// Renders [`scene`] with a mesh file of this name and content.
fn render_mesh(name: &str, mesh: &str) -> Rendered {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join(name), mesh).expect("a mesh");
    fs::write(folder.path().join("scene.toml"), scene(name)).expect("a scene");
    render(&folder.path().join("scene.toml"))
}

/// Four triangles that fill most of the picture.
const GOOD: &str = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv 0 0 0.5\n\
    f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";

/// NaN and infinite vertices made others loop for ever, or poisoned the box of all. Here they
/// cost their own triangles, with one note, and change no bit of anything else; no area and
/// duplicates change none either.
#[test]
fn broken_triangles_change_no_other_pixel() {
    let good = render_mesh("mesh.obj", GOOD);
    assert_eq!(good.notes.iter().filter(|note| note.contains("left out")).count(), 0);
    for (broken, is_told) in [
        ("v nan 0 3\nf 1 2 6\nf 6 6 6\n", true),
        ("v 0 0 inf\nv 0 -inf 3\nf 1 2 6\nf 3 7 6\n", true),
        ("v 1e39 0 3\nf 1 2 -1\n", true),
        ("v nan nan nan\nv inf inf inf\nv 0 0 3\nf -1 -2 -3\nf -3 -2 -1\n", true),
        // Without area: one point, two points, three on a line.
        ("f 1 1 1\nf 1 1 2\nf 2 1 2\n", true),
        ("v 0 0 2\nv 0 0 3\nv 0 0 4\nf 6 7 8\n", true),
        // The same again: whichever is met, it is the same surface.
        ("f 1 2 5\nf 1 2 5\nf 2 3 5\n", false),
        // A needle far thinner than a pixel, and one out of sight, a million times longer than
        // all the rest.
        ("v 0 9 0\nv 1e6 9 0\nv 1e6 9 1e-30\nf 6 7 8\n", false),
    ] {
        let bad = render_mesh("mesh.obj", &format!("{GOOD}{broken}"));
        assert!(bad.image == good.image, "{broken}");
        let told = bad.notes.iter().filter(|note| note.contains("left out")).count();
        assert_eq!(told, usize::from(is_told), "{broken}: {:?}", bad.notes);
    }
}

/// Normals and texture coordinates that are no numbers, or nought, or point into the surface:
/// the picture is finite, no sample is dropped, and something is seen.
#[test]
fn broken_normals_and_uvs_give_a_picture() {
    for attributes in [
        "nan nan nan 0 0",
        "0 0 inf 0 0",
        "0 0 0 0 0",
        "1e-45 0 0 0 0",
        "3e38 3e38 3e38 0 0",
        "0 0 -1 0 0",
        "1 0 0 nan inf",
        "0 0 1 -1e38 1e38",
    ] {
        let corner = |point: &str| format!("{point} {attributes}\n");
        let ply = format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
             property float z\nproperty float nx\nproperty float ny\nproperty float nz\n\
             property float u\nproperty float v\nelement face 1\n\
             property list uchar int vertex_indices\nend_header\n{}{}{}3 0 1 2\n",
            corner("-1 -1 0"),
            corner("1 -1 0"),
            corner("0 1 0"),
        );
        let image = render_mesh("mesh.ply", &ply).image;
        // Beside the ball, inside the triangle: what is seen there is no sky.
        let seen = image.channel("B").expect("B")[10 * 24 + 9];
        assert!(seen < 0.5, "{attributes}: {seen}");
    }
}

/// Trees of no, one, two, and a few triangles: others asked an empty tree for its first node,
/// or looped below five. Each triangle fills a column of its own, in front of nothing.
#[test]
fn few_primitives_are_all_seen() {
    for count in 0..=6_usize {
        let folder = tempfile::tempdir().expect("a folder");
        let mut ply = format!(
            "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
             property float z\nelement face {count}\nproperty list uchar int vertex_indices\n\
             end_header\n",
            3 * count
        );
        for i in 0..count {
            let x = i as f32 - 3.0;
            ply.push_str(&format!("{} -9 0\n{} -9 0\n{} 9 0\n", x + 0.1, x + 0.9, x + 0.5));
        }
        for i in 0..count {
            ply.push_str(&format!("3 {} {} {}\n", 3 * i, 3 * i + 1, 3 * i + 2));
        }
        fs::write(folder.path().join("mesh.ply"), ply).expect("a mesh");
        // Six units are seen, four pixels each.
        let text = "version = 1\n\
            render = { size = [24, 1], spp = 1, integrator = \"albedo\", filter_radius = 0.01 }\n\
            camera = { position = [0, 0, 1000], look_at = [0, 0, 0], fov_degrees = 0.0143239 }\n\
            material = [{ name = \"m\", type = \"matte\", albedo = 1 }]\n\
            shape = [{ type = \"mesh\", file = \"mesh.ply\", material = \"m\" }]\n";
        fs::write(folder.path().join("scene.toml"), text).expect("a scene");
        let image = render(&folder.path().join("scene.toml")).image;
        let row = image.channel("R").expect("R");
        // The middle of a column is its triangle, wherever the sample falls in these pixels.
        let seen = (0..6).filter(|i| row[4 * i + 1] > 0.0 && row[4 * i + 2] > 0.0).count();
        assert_eq!(seen, count, "{row:?}");
    }
}

/// A convex matte body under an even sky sends back its albedo, exactly, whatever its size: from
/// a micrometre to ten thousand kilometres, and far from the origin as well. A constant for
/// "close enough" anywhere in the renderer shows here as darkness or as light from inside.
#[test]
fn size_and_place_do_not_matter() {
    for scale in [1e-6, 1e-3, 1.0, 1e3, 1e7] {
        for offset in [0.0, 100.0] {
            let folder = tempfile::tempdir().expect("a folder");
            let at = |x: f64| x * scale + offset * scale;
            let text = format!(
                "version = 1\n\
                 render = {{ size = [16, 16], spp = 8, strategy = \"bsdf\" }}\n\
                 camera = {{ position = [{c}, {c}, {z}], look_at = [{c}, {c}, {c}], fov_degrees = 40 }}\n\
                 environment = {{ color = 1 }}\n\
                 material = [{{ name = \"m\", type = \"matte\", albedo = 0.25 }}]\n\
                 shape = [{{ type = \"sphere\", radius = {r}, center = [{c}, {c}, {c}], material = \"m\" }},\n\
                 {{ type = \"box\", size = [{r}, {r}, {r}], center = [{far}, {c}, {c}], material = \"m\" }}]\n",
                c = at(0.0),
                z = at(4.0),
                r = scale,
                far = at(50.0),
            );
            fs::write(folder.path().join("scene.toml"), text).expect("a scene");
            let image = render(&folder.path().join("scene.toml")).image;
            let green = image.channel("G").expect("G");
            // The middle of the picture is the ball.
            for y in 6..10 {
                for x in 6..10 {
                    assert_eq!(green[y * 16 + x], 0.25, "scale {scale}, offset {offset}");
                }
            }
            assert_eq!(green[0], 1.0, "the sky, at scale {scale}");
        }
    }
}

/// Skies with pixels that are negative, infinite or no numbers made whole pictures white or
/// black. They give no light, are counted, and all others shine.
#[test]
fn broken_pixels_of_a_sky_give_no_light() {
    let folder = tempfile::tempdir().expect("a folder");
    let values = [f32::NAN, -1.0, f32::INFINITY, f32::NEG_INFINITY, -0.0, 1.0, 1.0, 1.0];
    let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    fs::write(folder.path().join("sky.pfm"), [b"Pf 4 2 -1\n".as_slice(), &bytes].concat())
        .expect("a sky");
    let text = "version = 1\nrender = { size = [8, 8], spp = 16 }\n\
        camera = { position = [0, 0, 4], look_at = [0, 0, 0] }\n\
        environment = { image = \"sky.pfm\" }\n\
        material = [{ name = \"m\", type = \"matte\" }]\n\
        shape = [{ type = \"sphere\", radius = 1, material = \"m\" }]\n";
    fs::write(folder.path().join("scene.toml"), text).expect("a scene");
    let Rendered { image, notes } = render(&folder.path().join("scene.toml"));
    assert!(notes.iter().any(|note| note.contains("4 of its pixels")), "{notes:?}");
    let red = image.channel("R").expect("R");
    assert!(red.iter().all(|v| (0.0..=1.001).contains(v)), "{red:?}");
    assert!(red.iter().any(|v| *v > 0.1), "the good pixels shine");
}

/// Lines of a megabyte, words of a megabyte, and a million empty lines: read in no time, and
/// shown in a short message where they are wrong.
#[test]
fn huge_lines_are_only_lines() {
    use rutilant_formats::scene::obj::read_bytes;
    let read = |text: &str| {
        let start = std::time::Instant::now();
        let result = read_bytes(text.as_bytes(), Path::new("a.obj"), &Default::default());
        assert!(start.elapsed() < Duration::from_secs(2), "{:?}", start.elapsed());
        result.map_err(|error| error.to_string())
    };
    let vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let blanks = " ".repeat(1 << 20);
    let scene = read(&format!("{vertices}f 1{blanks}2{blanks}3{blanks}\n")).expect("read");
    assert_eq!(scene.meshes[0].0.triangles, [[0, 1, 2]]);
    let continued = format!("{vertices}f 1 {}2 3\n", "\\\n".repeat(1 << 19));
    assert_eq!(read(&continued).expect("read").meshes[0].0.triangles, [[0, 1, 2]]);
    let comment = format!("#{}\n{vertices}{}f 1 2 3\n", "x".repeat(1 << 20), "\n".repeat(1 << 20));
    assert_eq!(read(&comment).expect("read").meshes[0].0.triangles, [[0, 1, 2]]);
    // A polygon of a hundred thousand corners.
    let polygon = format!("{vertices}f{}\n", " 1 2 3".repeat(33_333));
    let triangles = read(&polygon).expect("read").meshes[0].0.triangles.len();
    assert_eq!(triangles, 99_997);
    let said = read(&format!("{vertices}f 1 2 {}\n", "9".repeat(1 << 20))).expect_err("no vertex");
    assert!(said.len() < 200, "{said}");
}
