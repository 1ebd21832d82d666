//! Scenes of every kind, written as native ones and read again: nothing is lost, and nothing is
//! written where it should not be.

#[path = "../gltf/builder.rs"]
#[allow(dead_code, reason = "each test file uses its part")]
mod builder;
#[path = "../common/mod.rs"]
mod common;
mod documents;
#[path = "../gltf/everything.rs"]
mod everything;
mod files;
mod parts;
mod scenes;

use rutilant::light::{Light, LightGroup};
use rutilant::settings::Settings;
use rutilant::{Prepared, Session};
use rutilant_formats::{ConvertOptions, Converted, LoadedScene, ReadOptions, convert, read_scene};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

fn read(path: &Path) -> LoadedScene {
    read_scene(path, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// Reads a scene, and makes another one of it that is to stand at `to`.
fn converted(from: &Path, to: &Path, copy: bool) -> (LoadedScene, Converted) {
    let loaded = read(from);
    let options = ConvertOptions { copy, ..ConvertOptions::default() };
    let converted = convert(&loaded, from, to, &options).unwrap_or_else(|error| panic!("{error}"));
    (loaded, converted)
}

/// The hash of a small picture of a scene: one number that every part of it has a hand in.
fn hash(loaded: &LoadedScene) -> u64 {
    let prepared = Arc::new(Prepared::new(&loaded.scene).expect("sound"));
    let settings = Settings { size: [24, 16], crop: None, spp: 4, ..loaded.settings.clone() };
    let session = Session::start(prepared, settings, 1).expect("settings");
    while !session.wait(Duration::from_secs(1)) {}
    session.snapshot().hash()
}

/// The light groups of everything in a scene that may have one, by what has it.
fn groups(loaded: &LoadedScene) -> [Vec<Option<LightGroup>>; 4] {
    let scene = &loaded.scene;
    let materials = scene.materials.iter().map(|m| m.emission.and_then(|emission| emission.group));
    let objects = scene.objects.iter().map(|object| object.group);
    [
        materials.collect(),
        objects.collect(),
        scene.lights.iter().map(Light::group).collect(),
        scene.environment.iter().map(|sky| sky.group).collect(),
    ]
}

/// The same picture, and as much of everything.
fn assert_same(was: &LoadedScene, is: &LoadedScene, what: &str) {
    let counts = |loaded: &LoadedScene| {
        let scene = &loaded.scene;
        [scene.objects.len(), scene.materials.len(), scene.lights.len(), loaded.cameras.len()]
    };
    assert_eq!(counts(is), counts(was), "{what}");
    assert_eq!(groups(is), groups(was), "{what}");
    assert_eq!(is.settings, was.settings, "{what}");
    assert_eq!(is.display, was.display, "{what}");
    assert_eq!(hash(is), hash(was), "{what}");
}
