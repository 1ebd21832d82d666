//! Ctrl-C at any moment leaves whole pictures, or none and a word about it, and nothing else.

#![cfg(unix)]

use rutilant_formats::{Limits, image};
use std::fs;
use std::io::Read;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Many small triangles to read, and a large picture to write: every stage takes a while.
fn write_scene(folder: &Path) {
    let n = 120;
    let point = |i: usize| format!("[{}, {}, {}]", i % n, (i * 7 % 5) as f32 * 0.1, i / n);
    let points: Vec<String> = (0..n * n).map(point).collect();
    let squares = (0..n * (n - 1)).filter(|i| i % n != n - 1);
    let square = |i| format!("[{i}, {}, {}]", i + n, i + 1);
    let triangles: Vec<String> = squares.map(square).collect();
    let scene = format!(
        "version = 1\n\
         [camera]\nposition = [60, 40, 160]\nlook_at = [60, 0, 60]\n\
         [environment]\ncolor = 1\n\
         [[material]]\nname = \"grey\"\ntype = \"matte\"\n\
         [[shape]]\ntype = \"mesh\"\nmaterial = \"grey\"\npositions = [{}]\ntriangles = [{}]\n",
        points.join(", "),
        triangles.join(", ")
    );
    fs::write(folder.join("hills.toml"), scene).unwrap();
}

fn start(folder: &Path, arguments: &str) -> Child {
    Command::new(env!("CARGO_BIN_EXE_rutilant"))
        .current_dir(folder)
        .args(arguments.split_whitespace())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

fn interrupt(child: &Child) {
    let status = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(status.success());
}

/// The exit status as a shell tells it, and what was said on standard error.
fn end(mut child: Child) -> (i32, String) {
    let mut said = String::new();
    child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
    let status = child.wait().unwrap();
    (status.code().or(status.signal().map(|s| 128 + s)).unwrap(), said)
}

fn files(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> =
        entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// A hash of a counter: the same moments every time.
fn unit(i: u64) -> f64 {
    let mut z = (i + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// Twelve moments over the whole life of a run, from before it listens until it writes its second
/// file: the status is 130, the pictures are whole or absent, absent only with a word about it,
/// and no temporary file is left.
#[test]
fn an_interrupt_at_any_moment_leaves_whole_pictures_or_none() {
    const MOMENTS: u64 = 12;
    let size = [900, 700];
    let arguments = "hills.toml --size 900x700 --spp 2 --quiet -o a.exr -o b.png";
    let folder = TempDir::new().unwrap();
    write_scene(folder.path());
    // The first run waits for the disk, too.
    let run = || {
        let started = Instant::now();
        assert_eq!(end(start(folder.path(), arguments)).0, 0);
        started.elapsed()
    };
    let mut life = run().min(run());

    let (mut interrupted, mut pictures) = (0, 0);
    let mut moment = 0;
    for _ in 0..3 * MOMENTS {
        if moment == MOMENTS {
            break;
        }
        let folder = TempDir::new().unwrap();
        write_scene(folder.path());
        let mut child = start(folder.path(), arguments);
        let part = (moment as f64 + unit(moment)) / MOMENTS as f64;
        std::thread::sleep(life.mul_f64(part));
        if child.try_wait().unwrap().is_some() {
            // It ran faster than the first ones did, on a machine that has more time now.
            assert_eq!(end(child).0, 0);
            life = life.mul_f64(part);
            continue;
        }
        moment += 1;
        interrupt(&child);
        let (status, said) = end(child);
        let names = files(folder.path());
        let whole = |name: &str| {
            let image = image::read(&folder.path().join(name), &Limits::default()).unwrap();
            assert_eq!([image.width(), image.height()], size, "{name} at {part}");
        };
        match &names.iter().map(String::as_str).collect::<Vec<_>>()[..] {
            ["a.exr", "b.png", "hills.toml"] => {
                whole("a.exr");
                whole("b.png");
                pictures += 1;
                // What was done when the signal came is done.
                assert!(status == 130 || (status == 0 && part > 0.8), "{status} at {part}: {said}");
            }
            ["hills.toml"] => {
                // Before the program listens the system ends it, and the shell has the word.
                assert!(said.contains("interrupted") || (said.is_empty() && part < 0.2), "{said}");
                assert_eq!(status, 130, "at {part}: {said}");
            }
            other => panic!("at {part}: {other:?} is left, {status}: {said}"),
        }
        interrupted += u64::from(status == 130);
    }
    assert!(interrupted >= MOMENTS / 2 && pictures > 0, "{interrupted}, {pictures} with pictures");
}

/// The second Ctrl-C, whenever it follows but as an echo of the first, ends the program soon, with
/// whole pictures or none.
#[test]
fn a_second_interrupt_at_any_moment_ends_it_at_once() {
    for round in 0..5 {
        let folder = TempDir::new().unwrap();
        write_scene(folder.path());
        let child = start(folder.path(), "hills.toml --size 2000x1500 --time 1h --quiet -o a.exr");
        std::thread::sleep(Duration::from_secs_f64(0.3 + unit(100 + round)));
        interrupt(&child);
        std::thread::sleep(Duration::from_secs_f64(0.25 + 0.4 * unit(200 + round)));
        let asked = Instant::now();
        // It may have ended by the first.
        let _ = Command::new("kill")
            .args(["-INT", &child.id().to_string()])
            .stderr(Stdio::null())
            .status();
        let (status, said) = end(child);
        assert!(asked.elapsed() < Duration::from_secs(4), "{:?}", asked.elapsed());
        assert_eq!(status, 130, "{said}");
        match &files(folder.path())[..] {
            [scene] => assert_eq!(scene, "hills.toml"),
            [image, scene] => {
                assert_eq!((&**image, &**scene), ("a.exr", "hills.toml"));
                let image = image::read(&folder.path().join("a.exr"), &Limits::default()).unwrap();
                assert_eq!([image.width(), image.height()], [2000, 1500]);
            }
            other => panic!("{other:?} is left: {said}"),
        }
    }
}
