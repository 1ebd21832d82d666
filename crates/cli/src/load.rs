//! Scenes from the command line, timed.

use crate::failure::Failure;
use clap::Args;
use rutilant::Prepared;
use rutilant_formats::{LoadedScene, ReadOptions, parse_native, read_scene};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The scene that is rendered when none is named, and the images it uses.
pub(crate) const BUILT_IN: &str = "glass-cube";
const BUILT_IN_TEXT: &str = r#"
version = 1

[render]
size = [640, 480]
spp = 64

[camera]
position = [2.2, 1.6, 2.6]
look_at = [0, 0.35, 0]
fov_degrees = 35

[environment]
color = [0.35, 0.45, 0.6]

[[material]]
name = "floor"
type = "matte"
albedo = 0.7

[[material]]
name = "glass"
type = "dielectric"
ior = 1.5

[[material]]
name = "lamp"
type = "emissive"
radiance = [40, 36, 30]

[[shape]]
type = "rectangle"
size = [12, 12]
rotate_degrees = [-90, 0, 0]
material = "floor"

[[shape]]
type = "box"
size = [1, 1, 1]
rotate_degrees = [0, 30, 0]
translate = [0, 0.501, 0]
material = "glass"

[[shape]]
type = "sphere"
radius = 0.3
center = [-1.5, 3, 1]
material = "lamp"
"#;
const BUILT_IN_IMAGES: &[(&str, &[u8])] = &[];

/// How scenes are read.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct Reading {
    /// Let the scene name files outside its own folder
    #[arg(long, help_heading = "Reading")]
    pub allow_path: bool,
}

/// Reads a scene, or the built-in one.
pub(crate) fn read(scene: Option<&Path>, reading: Reading) -> Result<LoadedScene, Failure> {
    let options = ReadOptions { allow_outside: reading.allow_path, ..ReadOptions::default() };
    let loaded = match scene {
        Some(path) => read_scene(path, &options)?,
        None => {
            let options = ReadOptions { embedded: BUILT_IN_IMAGES, ..options };
            parse_native(BUILT_IN_TEXT, Path::new("glass-cube.toml"), &options)?
        }
    };
    Ok(loaded)
}

/// A scene's name without folder and extension.
pub(crate) fn stem(scene: Option<&Path>) -> PathBuf {
    scene.and_then(Path::file_stem).map_or_else(|| BUILT_IN.into(), PathBuf::from)
}

/// Makes a scene traceable.
pub(crate) fn prepare(loaded: &LoadedScene) -> Result<Arc<Prepared>, Failure> {
    Ok(Arc::new(Prepared::new(&loaded.scene)?))
}

/// Runs something and says how long it took.
pub(crate) fn timed<T>(f: impl FnOnce() -> T) -> (T, Duration) {
    let start = Instant::now();
    let result = f();
    (result, start.elapsed())
}

/// Makes `count` threads do the work that is shared out by `rayon`: building trees, comparing.
pub(crate) fn use_threads(count: usize) -> Result<(), Failure> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(count);
    pool.build_global().map_err(|error| Failure::failed(format!("cannot start threads: {error}")))
}
