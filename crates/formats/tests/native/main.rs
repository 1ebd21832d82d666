//! The native scene format: what scenes mean, what is said about bad ones, which files they reach.

mod cameras;
mod errors;
mod files;
mod meaning;
mod meshes;
mod robustness;
mod skies;

use rutilant_formats::{LoadedScene, ReadOptions, SceneError, parse_native};
use std::path::Path;

/// The least that a scene needs, and a material. Text after it starts in line 8.
pub(crate) const HEAD: &str = r#"version = 1
camera.position = [0, 0, 5]
camera.look_at = [0, 0, 0]
[[material]]
name = "grey"
type = "matte"

"#;

/// Reads a scene from text.
pub(crate) fn parse(text: &str) -> Result<LoadedScene, SceneError> {
    parse_native(text, Path::new("scene.toml"), &ReadOptions::default())
}

const DOCUMENTATION: &str = include_str!("../../../../docs/scene-format.md");

/// The complete example of the documentation.
pub(crate) fn documented_example() -> &'static str {
    let (_, example) = DOCUMENTATION.split_once("```toml\n").expect("an example");
    example.split_once("```").expect("the end of the example").0
}
