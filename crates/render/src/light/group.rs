//! Light groups: names for lights that belong together, whose light a picture can tell apart.
//!
//! A name is part of the names of channels in an EXR file, as in `Combined_key.R`. What every reader
//! of such files takes fits a name of 31 bytes, of which a group has 20.

use std::fmt;

/// The name of lights that belong together: 1 to 20 letters and digits of ASCII, `_` and `-`.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct LightGroup {
    /// Zeros behind its end.
    bytes: [u8; Self::MOST_BYTES],
}

/// What is wrong with the name of a light group, and what would be right.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct GroupNameProblem(String);

impl LightGroup {
    /// The longest name, in bytes.
    pub const MOST_BYTES: usize = 20;

    /// What the lights without a group are called together; no group has this name.
    pub const REST: &'static str = "rest";

    /// A group by its name.
    ///
    /// # Errors
    /// A name that is empty or too long, that has other characters than letters and digits of ASCII,
    /// `_` and `-`, or that is [`REST`](Self::REST).
    pub fn new(name: &str) -> Result<Self, GroupNameProblem> {
        let problem = |what: String| Err(GroupNameProblem(what));
        let most = Self::MOST_BYTES;
        if name.is_empty() {
            return problem("the name of a light group is empty".to_owned());
        }
        let fits = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        if let Some(wrong) = name.chars().find(|c| !fits(*c)) {
            return problem(format!(
                "the name of a light group has a {wrong:?}, but takes letters and digits of ASCII, _ \
                 and - only: channels of files are called by it"
            ));
        }
        if name.len() > most {
            return problem(format!(
                "the name of a light group has {} characters, but must have at most {most}: channels \
                 of files are called by it",
                name.len()
            ));
        }
        if name == Self::REST {
            return problem(format!(
                "no light group can be called \"{name}\": that is what the lights without a group \
                 are called"
            ));
        }
        let mut bytes = [0; Self::MOST_BYTES];
        bytes[..name.len()].copy_from_slice(name.as_bytes());
        Ok(Self { bytes })
    }

    /// Its name.
    pub fn name(&self) -> &str {
        let end = self.bytes.iter().position(|b| *b == 0).unwrap_or(Self::MOST_BYTES);
        std::str::from_utf8(&self.bytes[..end]).unwrap_or_default()
    }
}

impl fmt::Debug for LightGroup {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}", self.name())
    }
}

impl fmt::Display for LightGroup {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every name that fits comes back as it was; every other is refused with a reason.
    #[test]
    fn names_are_kept_or_refused() {
        for name in ["k", "key", "Key_2", "-", "a-b", "12345678901234567890"] {
            assert_eq!(LightGroup::new(name).map(|group| group.to_string()), Ok(name.to_owned()));
        }
        for (name, why) in [
            ("", "empty"),
            ("a.b", "'.'"),
            ("a/b", "'/'"),
            ("a b", "' '"),
            ("a\n", "'\\n'"),
            ("a\0", "'\\0'"),
            ("schlüssel", "'ü'"),
            ("123456789012345678901", "21 characters"),
            ("rest", "without a group"),
        ] {
            let told = LightGroup::new(name).expect_err(name).to_string();
            assert!(told.contains(why), "{name:?}: {told}");
        }
        assert_ne!(LightGroup::new("key"), LightGroup::new("Key"));
    }
}
