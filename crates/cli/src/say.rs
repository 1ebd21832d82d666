//! What the program says: results on standard output, everything for people on standard error.

use crate::failure::Failure;
use std::io::{ErrorKind, Write, stderr, stdout};

/// A result as one line of JSON on standard output.
pub(crate) fn print_json(result: &impl serde::Serialize) -> Result<(), Failure> {
    let line = serde_json::to_string(result).map_err(Failure::failed)?;
    print_line(&line)
}

/// A result as lines on standard output. A reader that has seen enough is no failure.
pub(crate) fn print_line(text: &str) -> Result<(), Failure> {
    match writeln!(stdout(), "{text}").and_then(|()| stdout().flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::failed(format!("standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// A line for people on standard error. Whether anybody listens changes nothing.
pub(crate) fn tell(line: &str) {
    let _ = writeln!(stderr(), "{line}");
}
