//! Words from strangers' files, made fit for a message.

use std::fmt::Display;

/// A longer word is cut: a message is a line, not a page.
const LONGEST: usize = 64;

/// A word for a message: short, and without anything that moves the cursor.
pub(crate) fn shown(word: &str) -> String {
    let mut text: String = word.chars().take(LONGEST).flat_map(char::escape_debug).collect();
    if word.chars().nth(LONGEST).is_some() {
        text.push('…');
    }
    text
}

/// The same in quotes, for a word whose bytes may be anything.
pub(crate) fn quoted(word: &[u8]) -> String {
    // More than is shown whatever the encoding, and no walk along a word that fills the file.
    let head = &word[..word.len().min(8 * LONGEST)];
    // A character that this cut in two is no reason to take the word for Latin-1.
    let head = match std::str::from_utf8(head) {
        Err(error) if error.error_len().is_none() && head.len() < word.len() => {
            &head[..error.valid_up_to()]
        }
        Ok(_) | Err(_) => head,
    };
    format!("\"{}\"", shown(&decode(head)))
}

/// Bytes as text: UTF-8, or else the Latin-1 that older exporters write.
pub(crate) fn decode(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect(),
    }
}

/// More notes of one kind than this are counted: nobody reads them all.
const MOST_ALIKE: usize = 16;

/// Notes of one kind as lines, each behind its place: the first ones, and of more how many `what`
/// there are.
pub(crate) fn few<P: Display>(notes: &[(P, String)], what: &str) -> Vec<String> {
    // No line to say that there is one line more.
    let told = if notes.len() > MOST_ALIKE + 1 { MOST_ALIKE } else { notes.len() };
    let mut lines: Vec<_> =
        notes[..told].iter().map(|(place, text)| format!("{place}: {text}")).collect();
    if let [(place, _), more @ ..] = &notes[told..] {
        lines.push(format!("{place}: … and {} more {what}", more.len() + 1));
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A message stays one short line, whatever the word; a cut between the bytes of a letter
    /// does not turn the others into other letters.
    #[test]
    fn words_become_short_lines() {
        assert_eq!(quoted(b"f\x1b[2J\n\""), r#""f\u{1b}[2J\n\"""#);
        assert_eq!(quoted("é".as_bytes()), "\"é\"");
        assert_eq!(quoted(b"\xe9"), "\"é\"");
        let long = quoted(format!("a{}", "é".repeat(100_000)).as_bytes());
        assert_eq!(long, format!("\"a{}…\"", "é".repeat(LONGEST - 1)));
    }

    /// Seventeen notes are seventeen lines, and so are five thousand.
    #[test]
    fn notes_come_to_an_end() {
        let notes = |count: usize| {
            few(&(0..count).map(|i| (i, "lost".to_owned())).collect::<Vec<_>>(), "cups")
        };
        assert_eq!(notes(0), [""; 0]);
        assert_eq!((notes(17).len(), &*notes(17)[16]), (17, "16: lost"));
        assert_eq!((notes(5000).len(), &*notes(5000)[15]), (17, "15: lost"));
        assert_eq!(notes(5000)[16], "16: … and 4984 more cups");
    }
}
