//! What it costs to store meshes once, and what it saves: renders a scene with a say in how many
//! triangles may be copied.
//!
//! ```sh
//! cargo run --release -p rutilant-formats --example copies -- SCENE WIDTH HEIGHT SPP COPIES PNG
//! ```
//!
//! With COPIES of 0 every mesh that stands in several places is stored once, with 4000000000 none
//! is. Tells the time, the rays per second, the bytes of the trees, the most memory that the process
//! ever had (on Linux), and the hash of the picture, which is the same for any COPIES.

use rutilant::geom::BuildOptions;
use rutilant::settings::Settings;
use rutilant::{Prepared, Session};
use rutilant_formats::image::{self, Pixels, WriteOptions};
use rutilant_formats::{ReadOptions, read_scene};
use std::error::Error;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::thread::available_parallelism;
use std::time::{Duration, Instant};

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [scene, width, height, spp, copies, png] = &words[..] else {
        eprintln!("copies SCENE WIDTH HEIGHT SPP COPIES PNG");
        return ExitCode::from(2);
    };
    match run(Path::new(scene), [width, height, spp, copies], Path::new(png)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("{problem}");
            ExitCode::FAILURE
        }
    }
}

fn run(scene: &Path, numbers: [&String; 4], png: &Path) -> Result<(), Box<dyn Error>> {
    let [width, height, spp, copies] = numbers.map(|word| word.parse::<u32>());
    let (width, height, spp, copies) = (width?, height?, spp?, copies?);
    let begun = Instant::now();
    let seconds = || begun.elapsed().as_secs_f64();
    let loaded = read_scene(scene, &ReadOptions::default())?;
    let read = seconds();
    let options = BuildOptions { copies, ..BuildOptions::default() };
    let prepared = Prepared::with_options(&loaded.scene, &options)?;
    let ready = seconds();
    let report = prepared.report();
    println!("read {read:.2} s, prepared {:.2} s", ready - read);
    println!(
        "{} triangles, {} stored; {} instances of {} meshes; {} bytes",
        report.triangles,
        report.stored_triangles,
        report.instances,
        report.shared_meshes,
        report.bvh.bytes
    );
    let settings =
        Settings { size: [width, height], spp: u64::from(spp), crop: None, ..loaded.settings };
    let threads = available_parallelism().map_or(1, usize::from);
    let session = Session::start(Arc::new(prepared), settings, threads)?;
    while !session.wait(Duration::from_secs(3600)) {}
    let (progress, rendering) = (session.progress(), seconds() - ready);
    println!(
        "rendered {rendering:.2} s, {:.3} million rays per second",
        progress.rays as f64 / rendering * 1e-6
    );
    let picture = session.snapshot();
    println!("hash {:016x}", picture.hash());
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    if let Some(peak) = status.lines().find(|line| line.starts_with("VmHWM")) {
        println!("{peak}");
    }
    let channel = |name| picture.channel(name).unwrap_or_default();
    let colors = channel("R").iter().zip(channel("G")).zip(channel("B"));
    let rgb8: Vec<u8> =
        colors.flat_map(|((r, g), b)| loaded.display.encode([*r, *g, *b])).collect();
    image::write(png, Pixels::Display { width, height, rgb8: &rgb8 }, &WriteOptions::default())?;
    Ok(())
}
