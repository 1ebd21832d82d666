//! What the program says: results on standard output, everything for people on standard error.

use crate::failure::Failure;
use std::borrow::Cow;
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
    let _ = writeln!(stderr(), "{}", one_line(line));
}

/// Without line breaks and whatever else moves the cursor: names of files may hold anything.
pub(crate) fn one_line(text: &str) -> Cow<'_, str> {
    if !text.contains(char::is_control) {
        return text.into();
    }
    let escaped = |c: char| if c.is_control() { c.escape_default().to_string() } else { c.into() };
    text.chars().map(escaped).collect::<String>().into()
}

#[cfg(test)]
mod tests {
    use super::one_line;

    /// A name with a line break does not make two messages of one; all letters stay.
    #[test]
    fn a_message_is_one_line() {
        assert_eq!(one_line("né \"a\\b\""), "né \"a\\b\"");
        assert_eq!(one_line("a\nb\x1b[2J"), "a\\nb\\u{1b}[2J");
    }
}
