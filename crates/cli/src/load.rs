//! Scenes from the command line, timed.

use crate::failure::Failure;
use crate::options;
use clap::Args;
use rutilant::Prepared;
use rutilant::settings::Settings;
use rutilant_formats::{
    CameraChoice, Limits, LoadedScene, ReadOptions, SkyChoice, parse_native, read_scene,
};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The scene that is rendered when none is named.
pub(crate) const BUILT_IN: &str = "glass-cube";
pub(crate) const BUILT_IN_FILE: &str = "glass-cube.toml";
pub(crate) const BUILT_IN_TEXT: &str = include_str!("../../../scenes/glass-cube.toml");
/// The images it uses, by the names it uses.
pub(crate) const BUILT_IN_IMAGES: &[(&str, &[u8])] =
    &[("skies/overcast_sea.hdr", include_bytes!("../../../scenes/skies/overcast_sea.hdr"))];

/// How scenes are read.
#[derive(Args, Clone, Debug)]
pub(crate) struct Reading {
    /// Let the scene name files outside its own folder
    #[arg(long, help_heading = READING)]
    pub allow_path: bool,
    /// Refuse textures that are missing or broken, which are magenta else; fail where samples were
    /// no numbers
    #[arg(long, help_heading = READING)]
    pub strict: bool,
    /// Show the materials of this variant (glTF)
    #[arg(long, value_name = "NAME", help_heading = READING)]
    pub variant: Option<String>,
    /// Show the first animation at this time (glTF)
    #[arg(long, value_name = "SECONDS", help_heading = READING, allow_hyphen_values = true,
          value_parser = options::finite)]
    pub at_time: Option<f32>,
    /// Let $NAME stand for this value (Mitsuba); may be repeated
    #[arg(short = 'D', long = "define", value_name = "NAME=VALUE", help_heading = READING,
          value_parser = options::parameter)]
    pub parameters: Vec<(String, String)>,
    /// See the scene by the camera of this name or number, not by the first one; "auto" is one that
    /// sees everything
    #[arg(long, value_name = "NAME|N|auto", help_heading = READING, value_parser = options::camera)]
    pub camera: Option<CameraChoice>,
    /// Light the scene by another sky: a picture of one, a radiance like 1 or 0.8,0.9,1, or none
    #[arg(long, value_name = "FILE|COLOR|none", help_heading = READING,
          allow_hyphen_values = true, value_parser = options::sky)]
    pub environment: Option<SkyChoice>,
    #[command(flatten)]
    pub limited: Limited,
}

/// How much files may ask for.
#[derive(Args, Clone, Debug)]
pub(crate) struct Limited {
    /// The most that is read: bytes (of a file), pixels (of an image), textures (bytes of all their
    /// pictures), picture (pixels that the scene asks for), vertices, triangles, objects or nesting,
    /// like pixels=500M; may be repeated
    #[arg(long = "limit", value_name = "NAME=N", help_heading = READING, value_parser = options::limit)]
    changes: Vec<(&'static str, u64)>,
}

const READING: &str = "Reading";

impl Limited {
    pub(crate) fn limits(&self) -> Limits {
        let mut limits = Limits::default();
        for &(name, most) in &self.changes {
            if let Some(limit) = limits.by_name(name) {
                *limit = most;
            }
        }
        limits
    }
}

/// Reads a scene, or the built-in one.
///
/// `size` is that of the picture if the command line says it: a camera that is chosen fits it.
pub(crate) fn read(
    scene: Option<&Path>,
    reading: &Reading,
    size: Option<[u32; 2]>,
) -> Result<LoadedScene, Failure> {
    let options = ReadOptions {
        limits: reading.limited.limits(),
        allow_outside: reading.allow_path,
        strict: reading.strict,
        variant: reading.variant.as_deref(),
        at_time: reading.at_time,
        parameters: &reading.parameters,
        size,
        camera: reading.camera.as_ref().unwrap_or_default(),
        sky: reading.environment.as_ref().unwrap_or_default(),
        ..ReadOptions::default()
    };
    let loaded = match scene {
        Some(path) => read_scene(path, &options)?,
        None => {
            let options = ReadOptions { embedded: BUILT_IN_IMAGES, ..options };
            parse_native(BUILT_IN_TEXT, Path::new(BUILT_IN_FILE), &options)?
        }
    };
    Ok(loaded)
}

/// A scene's name without folder and extension.
pub(crate) fn stem(scene: Option<&Path>) -> PathBuf {
    scene.and_then(Path::file_stem).map_or_else(|| BUILT_IN.into(), PathBuf::from)
}

/// Makes a scene traceable.
pub(crate) fn prepare(
    loaded: &LoadedScene,
    build: options::Build,
    simd: options::SimdLevel,
) -> Result<Arc<Prepared>, Failure> {
    let prepared = Prepared::with_options(&loaded.scene, &build.into())?.with_simd(simd.into());
    prepared.map(Arc::new).ok_or_else(|| simd.missing())
}

/// What was said about a scene when it was read and prepared, and what its rendering with
/// `settings` misses. Each note begins with the file, and with the line where it is about one.
pub(crate) fn notes(
    loaded: &LoadedScene,
    prepared: &Prepared,
    settings: &Settings,
    scene: Option<&Path>,
) -> Vec<String> {
    let file = scene.unwrap_or(Path::new(BUILT_IN_FILE));
    let mended = prepared.report().notes.iter().map(|note| loaded.locate(note, file));
    let missed = prepared.notes_for(settings);
    let missed = missed.into_iter().map(|note| loaded.locate(&note, file));
    loaded.notes.iter().cloned().chain(mended).chain(missed).collect()
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
