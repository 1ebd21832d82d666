//! Small pictures may take so many instructions and no more: `cargo bench -p rutilant-cli`.
//!
//! Seconds differ from run to run by more than a change of the code is worth; instructions, as
//! valgrind's callgrind counts them, do so by less than a thousandth. What got dearer on purpose has
//! its budget raised together with the change; what got cheaper, lowered. The budgets are those of
//! AVX2, which valgrind knows; on other processors nothing is counted.

use std::path::Path;
use std::process::{Command, ExitCode};

/// A scene, and the most million instructions that one sample of 64 × 64 pixels may take, the start
/// of the program and reading the scene included: a twentieth more than it took when it was written
/// down.
const BUDGETS: [(&str, f64); 4] = [
    ("cornell-box.toml", 27.5),
    ("glass-cube.toml", 39.0),
    ("materials.toml", 40.7),
    ("seven-spheres.toml", 20.5),
];

const SPP: u32 = 8;

fn main() -> ExitCode {
    // Tests build this as well, without what makes it fast.
    if !std::env::args().any(|argument| argument == "--bench") {
        println!("not counted: only `cargo bench` does");
        return ExitCode::SUCCESS;
    }
    let mut failed = false;
    for (scene, budget) in BUDGETS {
        match million_instructions(scene) {
            Ok(all) => {
                let taken = all / f64::from(SPP);
                let over = taken > budget;
                let verdict = if over { "too many" } else { "within budget" };
                println!(
                    "{scene}: {taken:.1} of {budget:.1} million instructions a sample: {verdict}"
                );
                failed |= over;
            }
            Err(problem) => {
                println!("{scene}: not counted: {problem}");
                return ExitCode::from(2);
            }
        }
    }
    if failed { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

/// All that rendering a scene takes on one thread.
fn million_instructions(scene: &str) -> Result<f64, String> {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let picture =
        std::env::temp_dir().join(format!("rutilant-instructions-{}.exr", std::process::id()));
    let output = Command::new("valgrind")
        .args([
            "--tool=callgrind",
            "--callgrind-out-file=/dev/null",
            env!("CARGO_BIN_EXE_rutilant"),
        ])
        .args(["render", "--size", "64x64", "--threads", "1", "--simd", "avx2", "--quiet"])
        .args(["--spp", &SPP.to_string(), "--output"])
        .arg(&picture)
        .arg(scenes.join(scene))
        .output()
        .map_err(|error| format!("valgrind does not start: {error}"))?;
    let told = String::from_utf8_lossy(&output.stderr);
    if !output.status.success() {
        return Err(told.into_owned());
    }
    std::fs::remove_file(&picture).map_err(|error| error.to_string())?;
    let counted = told.lines().find_map(|line| line.split("Collected :").nth(1));
    let counted = counted.and_then(|number| number.trim().parse::<f64>().ok());
    counted.map(|n| n * 1e-6).ok_or_else(|| format!("no count in:\n{told}"))
}
