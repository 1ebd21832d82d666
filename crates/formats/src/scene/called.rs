//! What mattes call things that a file names only together with others.
//!
//! What stands in one thing is a part of it, as "tree/bark" is of "tree": see
//! `rutilant::cryptomatte`. Many parts can share a name, so that only its
//! beginning is taken: memory does not grow with their product.

use std::sync::Arc;

/// So many characters of a name that others may have as well.
const LONGEST: usize = 64;

/// The beginning of a name.
pub(super) fn shortened(name: &str) -> &str {
    name.char_indices().nth(LONGEST).map_or(name, |(end, _)| &name[..end])
}

/// A part called `own` of the asset `whole`; either may be empty.
pub(super) fn part_of(whole: &str, own: &str) -> Arc<str> {
    let whole: String = whole.chars().filter(|c| *c != '/').take(LONGEST).collect();
    match (&*whole, own) {
        ("", own) => own.into(),
        (whole, "") => whole.into(),
        (whole, own) => format!("{whole}/{own}").into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A name has the slash that makes it a part, and no other before it.
    #[test]
    fn parts_are_behind_what_they_are_of() {
        for (whole, own, name) in [
            ("tree", "bark", "tree/bark"),
            ("a/b", "c/d", "ab/c/d"),
            ("", "bark", "bark"),
            ("tree", "", "tree"),
            ("/", "bark", "bark"),
            ("", "", ""),
        ] {
            assert_eq!(&*part_of(whole, own), name);
        }
    }

    /// Characters are counted, and none is cut in two.
    #[test]
    fn long_names_are_cut() {
        let long = "ü".repeat(100);
        assert_eq!(shortened(&long), "ü".repeat(64));
        assert_eq!(shortened("short"), "short");
        assert_eq!(&*part_of(&long, "x"), format!("{}/x", "ü".repeat(64)));
    }
}
