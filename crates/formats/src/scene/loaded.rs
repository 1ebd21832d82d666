//! What reading a scene gives.

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
    /// What a person should know: what was missing, and what stands in for it. One line each,
    /// which begins with the file, and with the place in it where one is meant.
    pub notes: Vec<String>,
}
