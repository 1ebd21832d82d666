//! Names that differ: for people, and for every file system.

use std::collections::{HashMap, HashSet};

/// Names in place of others, so that none is empty and no two are the same. A name that is there
/// once stays; of several that are the same the first stays, and the others are numbered. What has
/// none gets its `stand_in`.
pub(super) fn unique(names: &[&str], stand_in: impl Fn(usize) -> String) -> Vec<String> {
    let mut taken: HashSet<String> = names.iter().map(|name| (*name).to_owned()).collect();
    let mut seen = HashSet::new();
    let mut numbers = HashMap::new();
    let each = names.iter().enumerate();
    each.map(|(i, name)| {
        if name.is_empty() {
            let wanted = stand_in(i);
            match taken.insert(wanted.clone()) {
                true => wanted,
                false => numbered(&wanted, " ", &mut taken, &mut numbers),
            }
        } else if seen.insert(*name) {
            (*name).to_owned()
        } else {
            numbered(name, " ", &mut taken, &mut numbers)
        }
    })
    .collect()
}

/// The first of `name 2`, `name 3` and so on that is free; it is taken then.
fn numbered(
    name: &str,
    joint: &str,
    taken: &mut HashSet<String>,
    numbers: &mut HashMap<String, u64>,
) -> String {
    let number = numbers.entry(name.to_owned()).or_insert(1);
    loop {
        *number += 1;
        let numbered = format!("{name}{joint}{number}");
        if taken.insert(numbered.clone()) {
            return numbered;
        }
    }
}

/// Names of files without their extensions, none of which any file system takes for another.
#[derive(Default)]
pub(super) struct FileNames {
    taken: HashSet<String>,
    numbers: HashMap<String, u64>,
}

impl FileNames {
    /// Keeps a name from being given away.
    pub(super) fn keep(&mut self, name: &str) {
        self.taken.insert(name.to_lowercase());
    }

    /// A free name with this extension, as near to `wanted` as may be; near to `other` where nothing
    /// is left of that.
    pub(super) fn free(&mut self, wanted: &str, other: &str, extension: &str) -> String {
        let mut stem = safe(wanted);
        if stem.is_empty() {
            other.clone_into(&mut stem);
        }
        // The part that is the same whatever the case of its letters.
        let key = stem.to_lowercase();
        let mut end = String::new();
        while !self.taken.insert(format!("{key}{end}.{extension}")) {
            let number = self.numbers.entry(format!("{key}.{extension}")).or_insert(1);
            *number += 1;
            end = format!("_{number}");
        }
        format!("{stem}{end}.{extension}")
    }
}

/// Longer names are cut.
const LONGEST: usize = 48;

/// What Windows takes for devices, whatever their extensions.
const DEVICES: [&str; 4] = ["con", "prn", "aux", "nul"];

/// What is left of a name if only what every file system takes may stay: letters and digits of
/// ASCII, `-` and `_`, at most 48 of them, and no name of a device. May be empty.
pub(super) fn safe(name: &str) -> String {
    let mut safe = String::new();
    for c in name.chars() {
        if c.is_ascii_alphanumeric() || c == '-' {
            safe.push(c);
        } else if !safe.ends_with('_') {
            safe.push('_');
        }
        if safe.len() >= LONGEST {
            break;
        }
    }
    let safe = safe.trim_matches(['-', '_']);
    let lower = safe.to_ascii_lowercase();
    let port = ["com", "lpt"].iter().find_map(|port| lower.strip_prefix(port));
    let is_port = port.is_some_and(|rest| rest.len() == 1 && rest.as_bytes()[0].is_ascii_digit());
    if DEVICES.contains(&&*lower) || is_port { format!("{safe}_") } else { safe.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whoever has a name of his own keeps it, also from those that are numbered.
    #[test]
    fn names_differ() {
        let names = unique(&["a", "", "a", "a 2", "", "a", "thing"], |_| "thing".to_owned());
        assert_eq!(names, ["a", "thing 2", "a 3", "a 2", "thing 3", "a 4", "thing"]);
    }

    /// Nothing that leads anywhere, that is a device, or that is too long is left of a name.
    #[test]
    fn names_of_files_are_safe() {
        for (name, left) in [
            ("../x", "x"),
            ("a/b\\c", "a_b_c"),
            ("", ""),
            ("...", ""),
            ("con", "con_"),
            ("CON.png", "CON_png"),
            ("Lpt1", "Lpt1_"),
            ("COM\u{b9}", "COM"),
            ("com12", "com12"),
            ("Körper \u{1f600} 1", "K_rper_1"),
            ("木", ""),
            ("-rf", "rf"),
            ("a\0b\nc", "a_b_c"),
        ] {
            assert_eq!(safe(name), left, "{name:?}");
        }
        assert_eq!(safe(&"x".repeat(300)), "x".repeat(48));
    }

    /// Names that differ only in their case are the same file to some.
    #[test]
    fn files_differ_in_more_than_case() {
        let mut names = FileNames::default();
        names.keep("body_2.ply");
        let given = ["Body", "body", "BODY", "body_2"].map(|name| names.free(name, "x", "ply"));
        assert_eq!(given, ["Body.ply", "body_3.ply", "BODY_4.ply", "body_2_2.ply"]);
        assert_eq!(names.free("木", "mesh", "ply"), "mesh.ply");
        assert_eq!(names.free("?", "mesh", "ply"), "mesh_2.ply");
        assert_eq!(names.free("body", "mesh", "png"), "body.png");
    }
}
