//! What a person should know of what was left out: each kind of thing once.

use std::collections::HashSet;

/// More kinds of things are counted, and not told.
const MOST: usize = 100;

/// What was said so far.
#[derive(Default)]
pub(super) struct Notes {
    said: HashSet<String>,
    list: Vec<String>,
    more: usize,
}

impl Notes {
    /// Takes a line of a kind, the first time.
    pub(super) fn once(&mut self, kind: &str, line: impl FnOnce() -> String) {
        if self.said.contains(kind) {
            return;
        }
        if self.list.len() >= MOST {
            self.more += 1;
            return;
        }
        self.list.push(line());
        self.said.insert(kind.to_owned());
    }

    /// Says what another reader has said, with its place.
    pub(super) fn repeat(&mut self, note: &str) {
        if self.list.len() < MOST {
            self.list.push(note.to_owned());
        } else {
            self.more += 1;
        }
    }

    /// All that was said, in its order.
    pub(super) fn into_list(self, file: &std::path::Path) -> Vec<String> {
        let mut list = self.list;
        if self.more > 0 {
            list.push(format!("{}: and {} more of the kind", file.display(), self.more));
        }
        list
    }
}
