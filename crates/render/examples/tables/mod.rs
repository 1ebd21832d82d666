//! What the programs that bake tables have in common.

use std::process::ExitCode;

/// Where step `i` of `n` lies between 0 and 1.
pub fn part(i: usize, n: usize) -> f64 {
    i as f64 / (n - 1) as f64
}

/// Writes a table, and says what went wrong if it cannot.
pub fn write(path: &str, bytes: &[u8]) -> ExitCode {
    match std::fs::write(path, bytes) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{path}: {error}");
            ExitCode::FAILURE
        }
    }
}
