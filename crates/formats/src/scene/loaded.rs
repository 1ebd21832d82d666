//! What reading a scene gives.

use super::nearest::nearest;
use super::origins::{Origins, PictureOrigin};
use crate::camera::AuthoredCamera;
use crate::error::{SceneError, SceneErrorKind};
use crate::options::{CameraChoice, ReadOptions, SkyChoice};
use crate::shown::shown;
use crate::{file, image};
use rutilant::display::Display;
use rutilant::light::{Environment, Projection};
use rutilant::scene::{Note, Place, Scene};
use rutilant::settings::Settings;
use std::collections::{HashMap, HashSet};
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
    /// Every camera in its author's words, one at least: where the scene has none, the one that
    /// was chosen.
    pub cameras: Vec<AuthoredCamera>,
    /// Which of them the scene's camera is made of.
    pub camera: usize,
    /// The names of the scene's images, as its file writes them, by
    /// [`ImageId`](rutilant::scene::ImageId).
    pub image_names: Vec<String>,
    /// What the scene's own text calls its textures, by
    /// [`TextureId`](rutilant::scene::TextureId); those of mesh files, which follow, have no names.
    pub texture_names: Vec<TextureName>,
    /// Where its pictures and meshes come from.
    pub origins: Origins,
    /// What a person should know: what was missing, and what stands in for it. One line each,
    /// which begins with the file, and with the place in it where one is meant.
    pub notes: Vec<String>,
    /// The files beside its own that the scene is made of, symbolic links followed.
    pub files: Vec<PathBuf>,
    /// The line of the scene's own file that each of its parts comes from, where that is known.
    pub lines: HashMap<Place, u32>,
}

/// What a scene's text calls a texture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TextureName {
    /// The name of its own table.
    Named(String),
    /// The file of its picture, named by the material itself.
    Image(String),
}

impl LoadedScene {
    /// How its cameras are asked for: each by its name, or by its number where it has no name of its
    /// own.
    pub fn camera_labels(&self) -> Vec<String> {
        labels(&self.cameras)
    }

    /// A note on the scene, which was read from `file`, in one line that begins with the place.
    pub fn locate(&self, note: &Note, file: &Path) -> String {
        let line = note.place.and_then(|place| self.lines.get(&place));
        match line {
            Some(line) => format!("{}:{line}: {}", file.display(), note.what),
            None => format!("{}: {note}", file.display()),
        }
    }
}

impl LoadedScene {
    /// The same scene, which was read from `file`: of a format that has neither variants nor animations.
    pub(crate) fn without_variants(
        mut self,
        file: &Path,
        options: &ReadOptions<'_>,
    ) -> Result<Self, SceneError> {
        if let Some(name) = options.variant {
            let what = format!("no variant \"{}\": only glTF files have variants", shown(name));
            return Err(SceneError::invalid_file(file, what));
        }
        if options.at_time.is_some() {
            self.notes.push(format!("{}: {NOTHING_MOVES}", file.display()));
        }
        Ok(self)
    }

    /// The same scene, which was read from `file`, under the sky that is asked for.
    pub(crate) fn under(
        mut self,
        file: &Path,
        options: &ReadOptions<'_>,
    ) -> Result<Self, SceneError> {
        let sky = match options.sky {
            SkyChoice::Own => return Ok(self),
            SkyChoice::None => None,
            SkyChoice::Even(radiance) => Some(Environment::constant(*radiance)),
            SkyChoice::Picture(path) => {
                let picture = image::read(path, &options.limits)
                    .map_err(|error| SceneError::invalid_file(path, error.what))?;
                let projection = Projection::likely([picture.width(), picture.height()]);
                if let Ok(whole) = path.canonicalize() {
                    self.files.push(whole.clone());
                    self.origins.images.push(PictureOrigin::File(whole));
                }
                self.image_names.push(file::named_from(file::folder(file), path));
                Some(Environment::map(self.scene.add_image(picture), projection))
            }
        };
        // The new sky's light goes where that of the old one went.
        let group = self.scene.environment.and_then(|old| old.group);
        self.scene.environment = sky.map(|sky| Environment { group, ..sky });
        self.lines.remove(&Place::Environment);
        self.scene.validate().map_err(|problem| {
            // All else was as it should be before.
            match options.sky {
                SkyChoice::Picture(path) => SceneError::invalid_file(path, problem.what),
                SkyChoice::Own | SkyChoice::None | SkyChoice::Even(_) => {
                    let what = format!("the sky that is asked for: {}", problem.what);
                    SceneError::invalid_file(file, what)
                }
            }
        })?;
        Ok(self)
    }
}

/// How cameras are asked for: by their names, or, where those are missing or not the first of their
/// kind, by their numbers.
fn labels(cameras: &[AuthoredCamera]) -> Vec<String> {
    let mut known = HashSet::from([""]);
    let numbered = cameras.iter().zip(1_usize..);
    let label = numbered.map(|(AuthoredCamera { name, .. }, number)| match known.insert(name) {
        true => shown(name),
        false => format!("number {number}"),
    });
    label.collect()
}

/// What is said where a time is asked for in vain.
pub(super) const NOTHING_MOVES: &str = "nothing in it moves, whatever time is asked for";

/// Which camera is meant by `name`: the one called so, or else the one of this number, from 1 on.
pub(super) fn position_of<'n>(
    name: &str,
    mut names: impl ExactSizeIterator<Item = &'n str>,
) -> Option<usize> {
    let count = names.len();
    let called = names.position(|own| own == name);
    called.or_else(|| (0..count).find(|at| (at + 1).to_string() == name))
}

/// Which of the cameras `options` ask for, by its name or number, or else the first one.
pub(super) fn camera_named(
    cameras: &[AuthoredCamera],
    file: &Path,
    options: &ReadOptions<'_>,
) -> Result<usize, SceneError> {
    let name = match options.camera {
        CameraChoice::First | CameraChoice::Auto => return Ok(0),
        CameraChoice::Named(name) => name,
    };
    if let Some(at) = position_of(name, cameras.iter().map(|camera| &*camera.name)) {
        return Ok(at);
    }
    let names = cameras.iter().map(|camera| camera.name.as_str()).filter(|name| !name.is_empty());
    let kind = match nearest(name, names.clone()) {
        Some(closest) => SceneErrorKind::Unknown {
            what: "camera",
            name: shown(name),
            closest: Some(shown(closest)),
        },
        None => {
            let there_are = match &labels(cameras)[..] {
                [] => "there is none".to_owned(),
                [only] => format!("there is only {only}"),
                known => format!("there are {}", known[..known.len().min(20)].join(", ")),
            };
            SceneErrorKind::Invalid(format!("no camera \"{}\"; {there_are}", shown(name)))
        }
    };
    Err(SceneError::in_file(file, kind))
}
