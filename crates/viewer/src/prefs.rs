//! What the window remembers between two uses: recent files and changed keys.
//!
//! A small TOML file in the user's folder for settings. It may be missing,
//! broken or read-only: then the window starts as new, and forgets. A broken one
//! is left as it is.

use crate::keys::KeyMap;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Recent files kept.
const MOST_RECENT: usize = 10;

/// What is remembered.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(default)]
pub(crate) struct Preferences {
    /// The newest first.
    pub(crate) recent: Vec<PathBuf>,
    /// Keys that are not the usual ones.
    pub(crate) keys: BTreeMap<String, String>,
}

impl Preferences {
    /// Where they are kept, if there is such a place.
    pub(crate) fn usual_file() -> Option<PathBuf> {
        let folders = directories::ProjectDirs::from("", "", "rutilant")?;
        Some(folders.config_dir().join("window.toml"))
    }

    /// Those in a file; the usual ones where there are none. Where it is broken, one line that says
    /// so.
    pub(crate) fn read(file: &Path) -> Result<Self, String> {
        let text = std::fs::read_to_string(file).unwrap_or_default();
        toml::from_str(&text).map_err(|error| {
            let what = error.message().lines().next().unwrap_or_default();
            let line = error.span().map_or(1, |span| 1 + text[..span.start].matches('\n').count());
            format!(
                "{}:{line}: {what}; until it is mended or removed, chosen keys and recent files are \
                 not kept",
                file.display()
            )
        })
    }

    /// Keeps them in a file, as far as that can be done.
    pub(crate) fn write(&self, file: &Path) -> std::io::Result<()> {
        let text = toml::to_string(self).map_err(std::io::Error::other)?;
        if let Some(folder) = file.parent() {
            std::fs::create_dir_all(folder)?;
        }
        rutilant_formats::replace_file(file, text.as_bytes())
    }

    /// A file that was opened is the newest.
    pub(crate) fn opened(&mut self, file: &Path) {
        let file = file.canonicalize().unwrap_or_else(|_| file.to_owned());
        self.recent.retain(|other| *other != file);
        self.recent.insert(0, file);
        self.recent.truncate(MOST_RECENT);
    }

    /// The keys, and the lines that mean nothing.
    pub(crate) fn key_map(&self) -> (KeyMap, Vec<String>) {
        KeyMap::from_names(&self.keys)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is written comes back; nonsense costs nothing but itself.
    #[test]
    fn they_are_remembered() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("deep/er/window.toml");
        assert_eq!(Preferences::read(&file), Ok(Preferences::default()));
        let mut preferences = Preferences::default();
        for i in 0..15 {
            preferences.opened(Path::new(&format!("/scenes/{i}.toml")));
        }
        preferences.opened(Path::new("/scenes/9.toml"));
        assert_eq!(preferences.recent.len(), MOST_RECENT);
        assert_eq!(preferences.recent[0], Path::new("/scenes/9.toml"));
        preferences.keys.insert("forward".into(), "I".into());
        preferences.write(&file).unwrap();
        assert_eq!(Preferences::read(&file), Ok(preferences));
        std::fs::write(&file, "recent = []\nkeys = 3").unwrap();
        let what = Preferences::read(&file).unwrap_err();
        assert!(what.contains("window.toml:2: "), "{what}");
    }
}
