//! What reading a scene gives.

use rutilant::display::Display;
use rutilant::scene::{Note, Place, Scene};
use rutilant::settings::Settings;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// A scene as its file describes it: what there is, how to render it, how to look at it.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    /// What there is. It has passed [`Scene::validate`].
    pub scene: Scene,
    /// How to render it. They have passed [`Settings::validate`].
    pub settings: Settings,
    /// How to show the picture.
    pub display: Display,
    /// What a person should know: what was missing, and what stands in for it. One line each,
    /// which begins with the file, and with the place in it where one is meant.
    pub notes: Vec<String>,
    /// The files beside its own that the scene is made of, symbolic links followed.
    pub files: Vec<PathBuf>,
    /// The line of the scene's own file that each of its parts comes from, where that is known.
    pub lines: HashMap<Place, u32>,
}

impl LoadedScene {
    /// A note on the scene, which was read from `file`, in one line that begins with the place.
    pub fn locate(&self, note: &Note, file: &Path) -> String {
        let line = note.place.and_then(|place| self.lines.get(&place));
        match line {
            Some(line) => format!("{}:{line}: {}", file.display(), note.what),
            None => format!("{}: {note}", file.display()),
        }
    }
}
