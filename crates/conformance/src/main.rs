//! The report: every way of finding light in every scene, and other people's pictures.
//!
//! ```text
//! cargo run --release -p rutilant-conformance -- [REPORT] [SAMPLES]
//! ```
//!
//! `REPORT` is the file to write (default `conformance.md`), `SAMPLES` the number per pixel of
//! the small scenes (default 8192). The exit status is 1 when something disagrees. The references
//! are looked for in the folder that the environment variable `RUTILANT_DATA` names; without it
//! they are skipped, and the report says so.

use rutilant_conformance::{matrix, references, report, scenes};
use std::path::PathBuf;
use std::process::ExitCode;

fn main() -> ExitCode {
    match run() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => {
            eprintln!("DISAGREEMENT: see the report");
            ExitCode::from(1)
        }
        Err(what) => {
            eprintln!("error: {what}");
            ExitCode::from(2)
        }
    }
}

fn run() -> Result<bool, String> {
    let mut arguments = std::env::args_os().skip(1);
    let path = arguments.next().map_or_else(|| "conformance.md".into(), PathBuf::from);
    let spp = match arguments.next() {
        None => 8192,
        Some(text) => text
            .to_str()
            .and_then(|t| t.parse().ok())
            .filter(|&n| n > 0)
            .ok_or_else(|| format!("{} is not a number of samples", text.display()))?,
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);

    let ways = matrix::ways(spp);
    let told = |name: &str| eprintln!("{name}");
    let pairs =
        matrix::agreement(&scenes::all(), &ways, threads, told).map_err(|e| e.to_string())?;

    let data = references::data();
    let mut checked = Vec::new();
    for reference in references::ALL {
        eprintln!("{}", reference.name);
        let measured = match &data {
            Some(data) => reference.measure(data, reference.spp, 1, threads)?,
            None => None,
        };
        if measured.is_none() {
            eprintln!("SKIPPED: set RUTILANT_DATA to the folder with {}", reference.picture);
        }
        checked.push((*reference, measured));
    }

    let (page, agrees) = report::page(&ways, &pairs, &checked);
    std::fs::write(&path, page).map_err(|e| format!("{}: {e}", path.display()))?;
    eprintln!("wrote {}", path.display());
    Ok(agrees)
}
