//! The pictures of the gallery, and those of docs/gltf.md, are what their commands make.
//!
//! Quickly: every scene at an eighth of its size (small ones at a quarter), against the stored picture
//! made smaller. At length, every command as it stands, its pictures left in `target/gallery`:
//!
//! ```text
//! cargo test --release -p rutilant-cli --test gallery -- --ignored --nocapture
//! ```
//!
//! Meshes that may not be shipped are looked for in the folder that `RUTILANT_DATA` names.

use rutilant::image::Image;
use rutilant_formats::Limits;
use rutilant_formats::image::{self, Pixels};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// One picture, as its command says.
struct Entry {
    scene: String,
    /// The options, without `-o`.
    options: Vec<String>,
    picture: PathBuf,
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().expect("the repository")
}

/// Pages with commands, the folders of their pictures, and how many bytes one may have.
const PAGES: [(&str, &str, u64); 2] =
    [("docs/gallery/README.md", "docs/gallery", 300_000), ("docs/gltf.md", "docs/gltf", 20_000)];

/// All commands of all pages.
fn entries() -> Vec<Entry> {
    PAGES.into_iter().flat_map(|(page, folder, _)| entries_of(page, folder)).collect()
}

fn entries_of(page: &str, folder: &str) -> Vec<Entry> {
    let page = fs::read_to_string(root().join(page)).expect("the page");
    let commands = page.lines().filter_map(|line| line.strip_prefix("rutilant "));
    commands
        .map(|command| {
            let words: Vec<_> = command.split('#').next().unwrap_or(command).split(' ').collect();
            let words: Vec<_> = words.into_iter().filter(|w| !w.is_empty()).collect();
            let [scene, options @ .., "-o", picture] = &words[..] else {
                panic!("a command of another form: {command}");
            };
            Entry {
                scene: (*scene).to_owned(),
                options: options.iter().map(|w| (*w).to_owned()).collect(),
                picture: root().join(folder).join(picture),
            }
        })
        .collect()
}

/// Every picture in the folders has its command, and none is too large.
#[test]
fn every_picture_has_its_command() {
    for (page, folder, most) in PAGES {
        let entries = entries_of(page, folder);
        let mut pictures = 0;
        for file in fs::read_dir(root().join(folder)).expect("a folder") {
            let path = file.expect("an entry").path();
            if path.extension().is_some_and(|e| e == "jpg") {
                let shown = path.display();
                assert!(entries.iter().any(|e| e.picture == path), "{shown} has no command");
                assert!(fs::metadata(&path).expect("a file").len() < most, "{shown}");
                pictures += 1;
            }
        }
        assert_eq!(pictures, entries.len(), "{page}");
    }
}

/// A place where the scene's meshes are, or `None` where there are none.
fn stage(entry: &Entry) -> Option<(tempfile::TempDir, PathBuf)> {
    let scene = root().join(&entry.scene);
    let text = fs::read_to_string(&scene).expect("a scene");
    let folder = scene.parent().expect("a folder");
    let stage = tempfile::tempdir().expect("a folder");
    let file_keys = text.lines().filter_map(|line| {
        let (key, rest) = line.split_once('=')?;
        matches!(key.trim(), "file" | "image" | "instances")
            .then(|| rest.split('"').nth(1))
            .flatten()
    });
    // A document's buffers that are files.
    let uris = text.split("\"uri\": \"").skip(1).filter_map(|rest| rest.split('"').next());
    let uris = uris.filter(|uri| !uri.starts_with("data:"));
    for file in file_keys.chain(uris) {
        let (shipped, to) = (folder.join(file), stage.path().join(file));
        fs::create_dir_all(to.parent().expect("a folder")).expect("a folder");
        let from = if shipped.exists() { shipped } else { elsewhere(file)? };
        fs::copy(from, to).expect("a copy");
    }
    let path = stage.path().join(scene.file_name().expect("a name"));
    fs::write(&path, text).expect("a scene");
    Some((stage, path))
}

/// A mesh that is not shipped.
fn elsewhere(file: &str) -> Option<PathBuf> {
    let data = PathBuf::from(std::env::var_os("RUTILANT_DATA")?).join("stanford");
    let name = match file {
        "happy_buddha.obj" => "happy_buddha_decimated.obj",
        name => name,
    };
    Some(data.join(name)).filter(|path| path.exists())
}

fn rutilant(arguments: &[&str]) -> Vec<u8> {
    let output =
        Command::new(env!("CARGO_BIN_EXE_rutilant")).args(arguments).output().expect("a run");
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {error}");
    output.stdout
}

fn text(path: &Path) -> &str {
    path.to_str().expect("a path of characters")
}

/// One number of the comparison of two files.
fn compared(picture: &Path, reference: &Path, number: &str) -> f64 {
    let json = rutilant(&["compare", text(picture), text(reference), "--json"]);
    let json: Value = serde_json::from_slice(&json).expect("JSON");
    json[number].as_f64().expect("a number")
}

/// What a command says of a scene beside the size and the samples of its picture.
fn ways_to_see(entry: &Entry) -> impl Iterator<Item = &str> {
    let pairs = entry.options.as_chunks::<2>().0.iter();
    let kept = pairs.filter(|[name, _]| !["--size", "--spp"].contains(&&**name));
    kept.flatten().map(String::as_str)
}

/// Every scene at an eighth or a quarter of its size looks like its picture. A scene that was changed without
/// its picture, a display curve or a camera that is no longer what it was, show here.
#[test]
fn scenes_look_like_their_pictures() {
    let mut skipped = vec![];
    let mut before: Option<(tempfile::TempDir, String)> = None;
    for entry in entries() {
        let Some((stage, scene)) = stage(&entry) else {
            skipped.push(entry.scene);
            continue;
        };
        let stored = image::read(&entry.picture, &Limits::default()).expect("the stored picture");
        // By how much smaller, and with how many samples for each of the few pixels.
        let (by, spp) = if stored.width() < 400 { (4, "32") } else { (8, "128") };
        let small = smaller(&stored, by);
        let reference = stage.path().join("reference.exr");
        let size = format!("{}x{}", small.width(), small.height());
        image::write(&reference, Pixels::Light(&small), &Default::default()).expect("a file");

        let picture = stage.path().join("picture.png");
        let mut arguments = vec![text(&scene), "--size", &size, "--spp", spp, "--quiet"];
        arguments.extend(["-o", text(&picture)].into_iter().chain(ways_to_see(&entry)));
        rutilant(&arguments);
        let ssim = compared(&picture, &reference, "ssim");
        println!("{}: SSIM {ssim:.4}", entry.scene);
        // What is missing is noise; another picture has far less in common with it.
        assert!(ssim > 0.75, "{}: SSIM {ssim}", entry.scene);
        if let Some((stage, _)) = before.filter(|(_, before)| *before == size) {
            // Even one of the same things in the same colours.
            let other = compared(&picture, &stage.path().join("reference.exr"), "ssim");
            assert!(
                1.0 - other > 2.0 * (1.0 - ssim),
                "{}: SSIM {ssim}, and {other} with the picture before it",
                entry.scene
            );
        }
        before = Some((stage, size));
    }
    if !skipped.is_empty() {
        println!("skipped, for RUTILANT_DATA names no folder with their meshes: {skipped:?}");
    }
}

/// Every command makes its picture.
#[test]
#[ignore = "takes a quarter of an hour"]
fn commands_make_the_pictures() {
    let made = root().join("target/gallery");
    fs::create_dir_all(&made).expect("a folder");
    for entry in entries() {
        let Some((_stage, scene)) = stage(&entry) else {
            println!("{}: skipped, for RUTILANT_DATA names no folder with its mesh", entry.scene);
            continue;
        };
        let picture = made.join(entry.picture.file_name().expect("a name"));
        let mut arguments = vec![text(&scene)];
        arguments.extend(entry.options.iter().map(String::as_str));
        arguments.extend(["-o", text(&picture), "--quiet"]);
        rutilant(&arguments);
        let ssim = compared(&picture, &entry.picture, "ssim");
        println!("{}: SSIM {ssim:.4}", entry.scene);
        assert!(ssim > 0.95, "{}: SSIM {ssim}", entry.scene);
    }
}

/// The 2017 program's spheres are those that Mitsuba 3.9 shows (8192 samples per pixel, box filter).
/// Its half mirrors are of rough metal of width 0.0005, because its smooth ones are too dark in
/// blends.
#[test]
fn seven_spheres_are_those_of_another_renderer() {
    let folder = tempfile::tempdir().expect("a folder");
    let picture = folder.path().join("picture.exr");
    let scene = root().join("scenes/seven-spheres.toml");
    rutilant(&[text(&scene), "--size", "200x150", "--spp", "256", "-o", text(&picture), "--quiet"]);
    let reference =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/references/seven-spheres.exr");
    let flip = compared(&picture, &reference, "flip");
    let bias =
        compared(&picture, &reference, "bias") / compared(&picture, &reference, "reference_mean");
    println!("FLIP {flip:.4}, bias {:.3} %", 100.0 * bias);
    assert!(flip < 0.02, "FLIP {flip}");
    assert!(bias.abs() < 0.002, "bias {bias}");
}

/// The mean light of every `by` times `by` pixels.
fn smaller(image: &Image, by: u32) -> Image {
    let (width, height) = (image.width() / by, image.height() / by);
    let colors = image.rgb().expect("colours");
    let mean = |x: u32, y: u32| {
        let mut sum = [0.0_f32; 3];
        let places = (0..by * by).map(|i| (by * y + i / by) * image.width() + by * x + i % by);
        for place in places {
            for (sum, c) in sum.iter_mut().zip(colors[place as usize]) {
                *sum += c / (by * by) as f32;
            }
        }
        sum
    };
    let pixels: Vec<_> = (0..height).flat_map(|y| (0..width).map(move |x| mean(x, y))).collect();
    Image::from_rgb(width, height, &pixels).expect("a picture")
}
