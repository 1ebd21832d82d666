//! Scenes and meshes from files: one file here for each kind.

pub(crate) mod bare;
pub(crate) mod files;
mod framing;
mod mesh_file;
pub(crate) mod native;
mod nearest;
pub mod obj;
pub mod ply;

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
    pub display: DisplayDefaults,
    /// What a person should know: what was missing, and what stands in for it. One sentence each.
    pub notes: Vec<String>,
}

/// How scene-linear radiance becomes a picture for eyes. Files that keep radiance ignore it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DisplayDefaults {
    /// In stops: each doubles the brightness.
    pub exposure: f32,
    /// What becomes of values above white.
    pub curve: Curve,
}

/// How bright values end at white.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Curve {
    /// Everything above white is white; what is below stays exact.
    #[default]
    Clip,
    /// A soft shoulder, as film has it.
    Filmic,
}
