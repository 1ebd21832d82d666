//! How long large meshes take to read, and how much memory, held against a budget.
//!
//! ```sh
//! cargo run --release -p rutilant-formats --example load -- 1000000
//! ```
//!
//! Writes a mesh of so many triangles in each format into the folder for temporary files, reads
//! it in a process of its own, prepares it for rendering, and takes it away again. Exit status 1
//! when reading costs more than the budget.

#[path = "../tests/common/load.rs"]
mod load;

use load::{BUDGETS, Budget, memory, write_hills};
use rutilant::Prepared;
use rutilant_formats::{ReadOptions, read_scene};
use std::path::Path;
use std::process::{Command, ExitCode};
use std::time::Instant;

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    match &words[..] {
        [word, path, triangles] if word == "--alone" => {
            measure(Path::new(path), triangles.parse().unwrap_or(1))
        }
        [count] if count.parse::<f64>().is_ok_and(|n| (2.0..=4e8).contains(&n)) => {
            all(count.parse().unwrap_or(0.0))
        }
        _ => {
            eprintln!("load TRIANGLES, from 2 to 400000000");
            ExitCode::from(2)
        }
    }
}

fn all(count: f64) -> ExitCode {
    println!(
        "format    triangles     file  read, s/M  peak, B/triangle  prepare, s/M  all, B/triangle"
    );
    let mut within = true;
    for Budget { format, .. } in BUDGETS {
        let name = format!("rutilant-hills-{}.{format}", std::process::id());
        let path = std::env::temp_dir().join(name);
        let side = (count / 2.0).sqrt().ceil() as u32;
        let triangles = write_hills(&path, side).expect("room for the mesh");
        let program = std::env::current_exe().expect("this program");
        let words = ["--alone".as_ref(), path.as_os_str(), triangles.to_string().as_ref()]
            .map(std::ffi::OsStr::to_owned);
        within &= Command::new(program).args(words).status().expect("started").success();
        std::fs::remove_file(&path).expect("taken away");
    }
    ExitCode::from(u8::from(!within))
}

fn measure(path: &Path, triangles: u64) -> ExitCode {
    let file = std::fs::metadata(path).map_or(0, |metadata| metadata.len());
    let before = memory("VmHWM");
    let each = |bytes: Option<u64>| match (bytes, before) {
        (Some(bytes), Some(before)) => bytes.saturating_sub(before) as f64 / triangles as f64,
        _ => f64::NAN,
    };
    let millions = triangles as f64 / 1e6;

    let start = Instant::now();
    let loaded = read_scene(path, &ReadOptions::default()).expect("a mesh");
    let read = start.elapsed().as_secs_f64() / millions;
    let peak = each(memory("VmHWM"));
    let start = Instant::now();
    let prepared = Prepared::new(&loaded.scene).expect("a scene");
    let prepare = start.elapsed().as_secs_f64() / millions;
    let all = each(memory("VmHWM"));
    drop(prepared);

    let format = path.extension().unwrap_or_default().to_string_lossy().into_owned();
    let budget = BUDGETS.into_iter().find(|b| b.format == format).expect("a format of the list");
    let over = peak > budget.bytes || read > budget.seconds;
    println!(
        "{format:6} {triangles:12} {:5.1} MB {read:10.3} {peak:17.1} {prepare:13.3} {all:16.1}{}",
        file as f64 / 1e6,
        if over { "  over budget" } else { "" },
    );
    ExitCode::from(u8::from(over))
}
