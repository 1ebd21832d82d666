//! Scenes of pbrt: what they mean, and what is said of mistakes in them.

mod errors;
mod files;
mod meaning;

use rutilant_formats::{LoadedScene, ReadOptions, SceneError, parse_pbrt};
use std::path::Path;

/// A sky of two pixels, and a triangle: files that need no disk.
pub(crate) const SKY: &[u8] = b"#?RADIANCE\n\n-Y 1 +X 2\n\x80\x80\x80\x81\x20\x40\x60\x84";
pub(crate) const TRIANGLE: &[u8] = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n\
    property float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\n\
    end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

pub(crate) fn read(text: &str) -> Result<LoadedScene, SceneError> {
    let embedded: &[(&str, &[u8])] = &[("sky.hdr", SKY), ("a.ply", TRIANGLE)];
    let options = ReadOptions { embedded, ..ReadOptions::default() };
    parse_pbrt(text.into(), Path::new("nowhere/a.pbrt"), &options)
}

/// A sound scene.
pub(crate) fn sound(text: &str) -> LoadedScene {
    read(text).unwrap_or_else(|error| panic!("{text}\n{error}"))
}

/// What is said of a scene, without its folder.
pub(crate) fn said(text: &str) -> String {
    match read(text) {
        Ok(_) => panic!("no error: {text}"),
        Err(error) => error.to_string().replace("nowhere/", ""),
    }
}
