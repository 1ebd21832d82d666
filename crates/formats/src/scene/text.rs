//! Words and numbers out of text, byte by byte, and the way back from a byte to its line.
//!
//! Nothing here copies or decodes the text. A reader remembers byte positions;
//! only an error asks which line and column one of them is.

use crate::error::{SceneError, SceneErrorKind, Source};
use crate::shown::{decode, quoted};
use std::path::Path;

/// The content of the file at `path` as text.
pub(super) fn in_utf8(bytes: Vec<u8>, path: &Path) -> Result<String, SceneError> {
    String::from_utf8(bytes).map_err(|error| {
        let at = place(path, error.as_bytes(), error.utf8_error().valid_up_to());
        let what = "the text is not UTF-8 here; save the file as UTF-8";
        SceneError { at, kind: SceneErrorKind::Invalid(what.to_owned()) }
    })
}

/// A place in a text that moves forward.
#[derive(Clone, Copy)]
pub(super) struct Cursor<'a> {
    bytes: &'a [u8],
    /// The position of the next byte.
    pub at: usize,
}

impl<'a> Cursor<'a> {
    /// The beginning of a text, behind the byte order mark if there is one.
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 } }
    }

    /// The same text from byte `at` on.
    pub(super) fn at(bytes: &'a [u8], at: usize) -> Self {
        Self { bytes, at: at.min(bytes.len()) }
    }

    /// The next byte; `None` at the end of the text.
    #[inline]
    pub(super) fn peek(&self) -> Option<u8> {
        self.bytes.get(self.at).copied()
    }

    /// Everything from here on.
    #[inline]
    pub(super) fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.at..).unwrap_or_default()
    }

    /// Takes the next byte if it is `byte`.
    #[inline]
    pub(super) fn take(&mut self, byte: u8) -> bool {
        let there = self.peek() == Some(byte);
        self.at += usize::from(there);
        there
    }

    /// Skips blanks of this line. A `\` at the end of a line counts as one, so the line goes on.
    #[inline]
    pub(super) fn skip_blanks(&mut self) {
        while let Some(byte) = self.peek() {
            if is_blank(byte) {
                self.at += 1;
            } else if self.continues(self.at) {
                self.at += 1 + self.line_end_length(self.at + 1);
            } else {
                break;
            }
        }
    }

    /// Skips blanks and line ends.
    #[inline]
    pub(super) fn skip_space(&mut self) {
        while self.peek().is_some_and(is_space) {
            self.at += 1;
        }
    }

    /// Skips blanks, and says whether nothing else stands on this line.
    #[inline]
    pub(super) fn line_is_done(&mut self) -> bool {
        self.skip_blanks();
        self.peek().is_none_or(|byte| matches!(byte, b'\n' | b'\r' | b'#'))
    }

    /// Skips empty lines and comments, and takes the first word of the next statement; with its
    /// place. `None` at the end of the text.
    #[inline]
    pub(super) fn statement(&mut self) -> Option<(usize, &'a [u8])> {
        while self.line_is_done() {
            self.peek()?;
            self.skip_line();
        }
        Some((self.at, self.word()))
    }

    /// Skips the rest of this line and its end, continuations included.
    pub(super) fn skip_line(&mut self) {
        let mut comment = false;
        while let Some(byte) = self.peek() {
            let line_end = self.line_end_length(self.at);
            if line_end > 0 {
                // A comment ends with its line, whatever its last byte.
                let continues =
                    !comment && self.at > 0 && self.bytes.get(self.at - 1) == Some(&b'\\');
                self.at += line_end;
                if !continues {
                    return;
                }
            } else {
                comment |= byte == b'#';
                self.at += 1;
            }
        }
    }

    /// The bytes up to the next blank or line end; empty where one stands here.
    #[inline]
    pub(super) fn word(&mut self) -> &'a [u8] {
        let word = &self.rest()[..self.word_length()];
        self.at += word.len();
        word
    }

    fn word_length(&self) -> usize {
        let rest = self.rest();
        let length = rest.iter().position(|&byte| is_space(byte)).unwrap_or(rest.len());
        // A continuation may follow without a blank.
        length - usize::from(length > 0 && self.continues(self.at + length - 1))
    }

    /// Whether a word that began before ends here.
    #[inline]
    pub(super) fn word_is_done(&self) -> bool {
        self.peek().is_none_or(|byte| is_space(byte) || self.continues(self.at))
    }

    /// Whether the byte at `at` is a `\` at the end of a line.
    #[inline]
    fn continues(&self, at: usize) -> bool {
        self.bytes.get(at) == Some(&b'\\') && self.line_end_length(at + 1) > 0
    }

    /// The rest of the line as a name: blanks inside belong to it, blanks around it do not.
    pub(super) fn name(&mut self) -> String {
        self.skip_blanks();
        let rest = self.rest();
        let length =
            rest.iter().position(|byte| matches!(byte, b'\n' | b'\r')).unwrap_or(rest.len());
        self.at += length;
        decode(rest[..length].trim_ascii())
    }

    /// The number that starts here, ended by a blank, a line end or the end of the text.
    /// The value is that of `str::parse`; `None`, and no step forward, where that fails.
    #[inline]
    pub(super) fn number(&mut self) -> Option<f32> {
        let start = self.at;
        if let Some((value, length)) = simple_number(self.rest()) {
            self.at += length;
            if self.word_is_done() {
                return Some(value);
            }
            self.at = start;
        }
        let value = std::str::from_utf8(self.word()).ok().and_then(|word| word.parse().ok());
        if value.is_none() {
            self.at = start;
        }
        value
    }

    /// The whole number that starts here, with a sign or not; what stands behind it is not
    /// looked at. `None`, and no step forward, where there is none; too large ones come out as
    /// the largest.
    #[inline]
    pub(super) fn whole_number(&mut self) -> Option<i64> {
        let start = self.at;
        let negative = self.take(b'-');
        if !negative {
            self.take(b'+');
        }
        let digits = self.at;
        let mut value = 0_i64;
        while let Some(digit) = self.peek().map(|byte| byte.wrapping_sub(b'0'))
            && digit < 10
        {
            value = value.saturating_mul(10).saturating_add(i64::from(digit));
            self.at += 1;
        }
        if self.at == digits {
            self.at = start;
            return None;
        }
        Some(if negative { -value } else { value })
    }

    /// Bytes of the line end at `at`; 0 where there is none.
    #[inline]
    fn line_end_length(&self, at: usize) -> usize {
        match self.bytes.get(at) {
            Some(b'\n') => 1,
            Some(b'\r') => 1 + usize::from(self.bytes.get(at + 1) == Some(&b'\n')),
            _ => 0,
        }
    }
}

#[inline]
pub(super) fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | 0x0b | 0x0c)
}

#[inline]
pub(super) fn is_space(byte: u8) -> bool {
    is_blank(byte) || matches!(byte, b'\n' | b'\r')
}

/// The decimal number that `bytes` start with, and its length, where one division of exact
/// numbers gives it (Clinger, *How to Read Floating Point Numbers Accurately*, 1990).
///
/// `None` does not mean that there is no number, only that this is not the way to read it.
#[inline]
fn simple_number(bytes: &[u8]) -> Option<(f32, usize)> {
    let mut at = 0;
    let negative = bytes.first() == Some(&b'-');
    at += usize::from(negative);

    let mut mantissa = 0_u64;
    let mut eat_digits = |at: &mut usize| {
        let start = *at;
        while let Some(digit) = bytes.get(*at).map(|byte| byte.wrapping_sub(b'0'))
            && digit < 10
        {
            mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit));
            *at += 1;
        }
        *at - start
    };
    let whole = eat_digits(&mut at);
    let mut fraction = 0;
    if bytes.get(at) == Some(&b'.') {
        at += 1;
        fraction = eat_digits(&mut at);
    }
    // Twenty digits may not fit into 64 bits.
    if whole + fraction == 0 || whole + fraction > 19 {
        return None;
    }

    let mut exponent = 0 - fraction as i32;
    if let Some(b'e' | b'E') = bytes.get(at) {
        let negative = bytes.get(at + 1) == Some(&b'-');
        at += 1 + usize::from(negative || bytes.get(at + 1) == Some(&b'+'));
        let digits = bytes[at..].iter().take_while(|byte| byte.is_ascii_digit()).count();
        if digits == 0 || digits > 3 {
            return None;
        }
        let written = bytes[at..at + digits].iter().fold(0, |e, d| e * 10 + i32::from(d - b'0'));
        exponent += if negative { -written } else { written };
        at += digits;
    }

    // Both operands are exact, so the result is the one f64 nearest to the number …
    if mantissa > 1 << 53 {
        return None;
    }
    let power = *POWERS_OF_TEN.get(exponent.unsigned_abs() as usize)?;
    let value = if exponent < 0 { mantissa as f64 / power } else { mantissa as f64 * power };
    // … and rounding that to f32 is right, but where it lies half-way between two of them: the
    // number itself may lie to either side. Subnormal f32 have their half-ways elsewhere.
    let halfway = value.to_bits() & 0x1fff_ffff == 0x1000_0000;
    if halfway || (value < f64::from(f32::MIN_POSITIVE) && mantissa != 0) {
        return None;
    }
    let value = value as f32;
    Some((if negative { -value } else { value }, at))
}

/// The powers of ten that an f64 holds exactly.
const POWERS_OF_TEN: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// The word at byte `at`, for a message.
pub(super) fn word_at(bytes: &[u8], at: usize) -> String {
    quoted(Cursor::at(bytes, at).word())
}

/// The last byte of each line end, in their order.
pub(super) fn line_ends(bytes: &[u8]) -> impl Iterator<Item = usize> {
    (0..bytes.len()).filter(|&i| ends_line(bytes, i))
}

/// Whether a line ends with this byte.
#[inline]
fn ends_line(bytes: &[u8], at: usize) -> bool {
    match bytes[at] {
        b'\n' => true,
        b'\r' => bytes.get(at + 1) != Some(&b'\n'),
        _ => false,
    }
}

/// The place of byte `at` in the text `bytes` of `file`.
pub(super) fn place(file: &Path, bytes: &[u8], at: usize) -> Source {
    Places::default().place(file, bytes, at)
}

/// Tells places of one file one after the other: each byte is looked at once, as long as they come
/// in the order of the file.
#[derive(Default)]
pub(super) struct Places {
    /// Before which byte lines are counted.
    at: usize,
    /// Lines that have ended.
    ended: u32,
    /// Where the last line begins.
    start: usize,
}

impl Places {
    /// As [`place`].
    pub(super) fn place(&mut self, file: &Path, bytes: &[u8], at: usize) -> Source {
        let at = at.min(bytes.len());
        if at < self.at {
            *self = Self::default();
        }
        for end in (self.at..at).filter(|&i| ends_line(bytes, i)) {
            self.ended = self.ended.saturating_add(1);
            self.start = end + 1;
        }
        self.at = at;
        let line = &bytes[self.start..at];
        let line =
            if self.start == 0 { line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line) } else { line };
        // In UTF-8 every character has one byte that is not of the form 10xxxxxx.
        let column = line.iter().filter(|&&byte| byte & 0xc0 != 0x80).count() + 1;
        let column = u32::try_from(column).unwrap_or(u32::MAX);
        Source::at(file, self.ended.saturating_add(1), column)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(text: &str) -> Option<f32> {
        Cursor::new(text.as_bytes()).number()
    }

    /// Numbers are those of `str::parse`, to the last bit. The list holds the border cases of
    /// both ways to read: many digits, half-way cases, subnormals, overflow, signs, words.
    #[test]
    fn numbers_are_those_of_the_standard_library() {
        let mut texts: Vec<String> = [
            "0",
            "-0",
            "+1",
            "1.",
            ".5",
            "-.5e1",
            "1e5",
            "1E+5",
            "1e-5",
            "16777217",
            "16777219",
            "33554433",
            "0.1",
            "3.4028235e38",
            "3.4028236e38",
            "1e39",
            "-1e999",
            "1e-45",
            "7e-46",
            "1.1754944e-38",
            "1.17549428e-38",
            "8388608.5",
            "8388609.5",
            "9007199791611905",
            "9007199791611904",
            "9007199791611903",
            "0.000000000000000000001",
            "1e22",
            "1e23",
            "123456789012345678901234567890",
            "nan",
            "inf",
            "-inf",
            "NaN",
            "infinity",
            "1e0005",
            "00000000000000000000000001",
            "1.00000017881393421514957253748434595763683319091796875001",
        ]
        .map(str::to_owned)
        .to_vec();
        let mut state = 1_u64;
        for _ in 0..200_000 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let float = f32::from_bits((state >> 32) as u32);
            let digits = (state >> 8) as usize % 12;
            texts.push(format!("{float}"));
            texts.push(format!("{float:e}"));
            texts.push(format!("{:.digits$}", (float % 4096.0) * 0.37));
            texts.push(format!("{:.digits$e}", f64::from(float) * 1.000_000_03));
            // Half-way between two neighbours, and just beside.
            let half = (f64::from(float) + f64::from(f32::from_bits(float.to_bits() + 1))) * 0.5;
            texts.push(format!("{half:e}"));
        }
        for text in texts {
            let expected: f32 = text.parse().expect("a number");
            let read = number(&text).unwrap_or_else(|| panic!("{text} is a number"));
            assert!(
                read.to_bits() == expected.to_bits() || read.is_nan() && expected.is_nan(),
                "{text}: {read:e}, but the standard library reads {expected:e}"
            );
        }
    }

    /// What the standard library does not read is no number here either.
    #[test]
    fn words_are_not_numbers() {
        for text in ["", "-", "+", ".", "e5", "1e", "1e+", "1.2.3", "1,5", "0x10", "1-2", "--1"] {
            assert_eq!(number(text), None, "{text}");
            assert!(text.parse::<f32>().is_err());
        }
    }

    /// Lines end with any of the three line ends; columns count characters, not bytes.
    #[test]
    fn places_count_lines_and_characters() {
        let text = "a\nb\r\nc\rdé f".as_bytes();
        for (at, line, column) in [(0, 1, 1), (2, 2, 1), (5, 3, 1), (7, 4, 1), (11, 4, 4)] {
            assert_eq!(place(Path::new("x"), text, at), Source::at("x", line, column), "byte {at}");
        }
    }

    /// Places told one after the other are those that are counted from the beginning, with every
    /// end of a line, and backwards as well.
    #[test]
    fn places_told_in_turn_are_those_told_alone() {
        let text = "\u{feff}a\r\nb\rc\n\n dé\r\r\ne".as_bytes();
        let file = Path::new("a.mtl");
        let mut places = Places::default();
        for at in (0..=text.len()).chain((0..=text.len()).rev().step_by(3)) {
            assert_eq!(places.place(file, text, at), place(file, text, at), "byte {at}");
        }
        for (at, line, column) in
            [(3, 1, 1), (6, 2, 1), (8, 3, 1), (12, 5, 2), (15, 5, 4), (18, 7, 1)]
        {
            assert_eq!(place(file, text, at), Source::at(file, line, column), "byte {at}");
        }
    }
}
