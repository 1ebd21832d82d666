//! Where everything stands in the text of a scene, byte by byte.
//!
//! The TOML parser tells what a text means; to change one value of it and leave
//! every other byte as it is, one must know which bytes that value, its key and
//! its line are. The text has been parsed before, so this scanner only finds
//! borders; where it meets what it does not know it gives up.
//!
//! A document model that prints itself would not do: line ends, byte order
//! marks and whole numbers beyond 64 bits do not survive it.

use std::ops::Range;

/// A text taken apart.
pub(super) struct Layout {
    /// What stands before the first header, and each header with what follows.
    pub(super) sections: Vec<Section>,
}

/// `[a.b]` or `[[a.b]]`, and the lines below.
pub(super) struct Section {
    /// The header; empty for what stands before the first.
    pub(super) header: Range<usize>,
    pub(super) path: Vec<String>,
    /// Whether its brackets are double.
    pub(super) is_array: bool,
    pub(super) entries: Vec<Entry>,
}

/// `a.b = value`.
pub(super) struct Entry {
    pub(super) path: Vec<String>,
    /// From the first byte of the first key.
    pub(super) start: usize,
    /// The last part of the key.
    pub(super) key: Range<usize>,
    pub(super) value: Node,
}

/// A value.
pub(super) struct Node {
    pub(super) at: Range<usize>,
    pub(super) kind: NodeKind,
}

pub(super) enum NodeKind {
    Scalar,
    Array(Vec<Node>),
    Inline(Vec<Entry>),
}

/// Deeper values are not looked into; the reader allows less.
const DEEPEST: usize = 100;

impl Layout {
    pub(super) fn of(text: &str) -> Option<Self> {
        let mut scanner = Scanner { bytes: text.as_bytes(), text, at: 0 };
        if text.starts_with('\u{feff}') {
            scanner.at = 3;
        }
        let at = scanner.at;
        let root =
            Section { header: at..at, path: Vec::new(), is_array: false, entries: Vec::new() };
        let mut sections = vec![root];
        loop {
            scanner.skip_lines();
            match scanner.peek() {
                None => return Some(Self { sections }),
                Some(b'[') => sections.push(scanner.header()?),
                Some(_) => {
                    let entry = scanner.entry(0)?;
                    sections.last_mut()?.entries.push(entry);
                }
            }
        }
    }
}

struct Scanner<'t> {
    text: &'t str,
    bytes: &'t [u8],
    at: usize,
}

impl Scanner<'_> {
    fn peek(&self) -> Option<u8> {
        self.bytes.get(self.at).copied()
    }

    fn take(&mut self, byte: u8) -> Option<()> {
        (self.peek()? == byte).then(|| self.at += 1)
    }

    fn starts_with(&self, what: &[u8]) -> bool {
        self.bytes.get(self.at..).is_some_and(|rest| rest.starts_with(what))
    }

    fn skip_while(&mut self, skip: impl Fn(u8) -> bool) {
        while self.peek().is_some_and(&skip) {
            self.at += 1;
        }
    }

    fn skip_blanks(&mut self) {
        self.skip_while(|byte| matches!(byte, b' ' | b'\t'));
    }

    /// Skips blanks, line ends and comments.
    fn skip_lines(&mut self) {
        loop {
            self.skip_while(|byte| matches!(byte, b' ' | b'\t' | b'\r' | b'\n'));
            if self.peek() != Some(b'#') {
                return;
            }
            self.skip_while(|byte| byte != b'\n');
        }
    }

    fn header(&mut self) -> Option<Section> {
        let start = self.at;
        self.take(b'[')?;
        let is_array = self.take(b'[').is_some();
        let (path, _) = self.path()?;
        self.take(b']')?;
        if is_array {
            self.take(b']')?;
        }
        Some(Section { header: start..self.at, path, is_array, entries: Vec::new() })
    }

    /// The parts of a key, and the last one's place.
    fn path(&mut self) -> Option<(Vec<String>, Range<usize>)> {
        let mut path = Vec::new();
        loop {
            self.skip_blanks();
            let start = self.at;
            let name = match self.peek()? {
                b'"' | b'\'' => {
                    self.string()?;
                    self.text.get(start + 1..self.at.checked_sub(1)?)?
                }
                _ => {
                    self.skip_while(|byte| byte.is_ascii_alphanumeric() || b"_-".contains(&byte));
                    self.text.get(start..self.at).filter(|name| !name.is_empty())?
                }
            };
            let key = start..self.at;
            path.push(name.to_owned());
            self.skip_blanks();
            if self.take(b'.').is_none() {
                return Some((path, key));
            }
        }
    }

    fn entry(&mut self, depth: usize) -> Option<Entry> {
        let start = self.at;
        let (path, key) = self.path()?;
        self.take(b'=')?;
        self.skip_blanks();
        let value = self.value(depth + 1)?;
        Some(Entry { path, start, key, value })
    }

    fn value(&mut self, depth: usize) -> Option<Node> {
        if depth > DEEPEST {
            return None;
        }
        let start = self.at;
        let kind = match self.peek()? {
            b'"' | b'\'' => {
                self.string()?;
                NodeKind::Scalar
            }
            b'[' => NodeKind::Array(self.list(b']', |scanner| scanner.value(depth + 1))?),
            b'{' => NodeKind::Inline(self.list(b'}', |scanner| scanner.entry(depth + 1))?),
            _ => {
                self.skip_while(|byte| !matches!(byte, b',' | b']' | b'}' | b'#' | b'\n' | b'\r'));
                let end = self.text.get(start..self.at)?.trim_end().len();
                self.at = start + end;
                if end == 0 {
                    return None;
                }
                NodeKind::Scalar
            }
        };
        Some(Node { at: start..self.at, kind })
    }

    fn list<T>(&mut self, end: u8, item: impl Fn(&mut Self) -> Option<T>) -> Option<Vec<T>> {
        self.at += 1;
        let mut items = Vec::new();
        loop {
            self.skip_lines();
            if self.take(end).is_some() {
                return Some(items);
            }
            items.push(item(self)?);
            self.skip_lines();
            if self.take(b',').is_none() {
                self.take(end)?;
                return Some(items);
            }
        }
    }

    fn string(&mut self) -> Option<()> {
        let quote = self.peek()?;
        let long = [quote; 3];
        let is_long = self.starts_with(&long);
        self.at += if is_long { 3 } else { 1 };
        loop {
            match self.peek()? {
                b'\\' if quote == b'"' => self.at += 2,
                _ if is_long && self.starts_with(&long) => {
                    self.at += 3;
                    // Up to two quotes may stand before the last three.
                    for _ in 0..2 {
                        let _ = self.take(quote);
                    }
                    return Some(());
                }
                byte => {
                    self.at += 1;
                    if byte == quote && !is_long {
                        return Some(());
                    }
                }
            }
        }
    }
}
