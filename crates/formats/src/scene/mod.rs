//! Scenes from files: one file here for each kind.

pub(crate) mod bare;
pub(crate) mod files;
mod framing;
mod mesh_file;
mod mtl;
pub(crate) mod native;
mod nearest;
pub mod obj;
pub mod ply;
mod polygon;
mod text;

use rutilant::display::Display;
use rutilant::scene::Scene;
use rutilant::settings::Settings;

/// A scene as its file describes it: what there is, how to render it, how to look at it.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    /// What there is. It has passed [`Scene::validate`].
    pub scene: Scene,
    /// How to render it. They have passed [`Settings::validate`].
    pub settings: Settings,
    /// How to show the picture.
    pub display: Display,
    /// What a person should know: what was missing, and what stands in for it. One sentence each.
    pub notes: Vec<String>,
}
