//! `rutilant check`: is a scene all right?

use crate::failure::{Exit, Failure};
use crate::load::{self, Reading};
use crate::options;
use crate::say::{one_line, print_json, print_line, tell};
use crate::text::several;
use rutilant::scene::Scene;
use rutilant::shape::Shape;
use serde::Serialize;
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
pub(crate) struct Args {
    /// Scenes to read: .toml, .gltf, .glb, .pbrt, .xml, .obj, .ply, .stl
    #[arg(required = true, value_name = "SCENE")]
    scenes: Vec<PathBuf>,
    #[command(flatten)]
    reading: Reading,
    /// Print one line of JSON for each scene
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Verdict<'a> {
    scene: &'a Path,
    ok: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
    notes: Vec<String>,
}

/// Examines every scene, even after a bad one; the exit status tells whether all were good.
pub(crate) fn run(args: &Args) -> Result<Exit, Failure> {
    let mut exit = Exit::Done;
    for path in &args.scenes {
        let (error, notes) = match examine(path, &args.reading) {
            Ok((contents, notes)) => {
                if !args.json {
                    print_line(&one_line(&format!("{}: ok: {contents}", path.display())))?;
                }
                (None, notes)
            }
            Err(failure) => {
                tell(&failure.line);
                exit = failure.exit;
                (Some(failure.line), Vec::new())
            }
        };
        for note in &notes {
            tell(&format!("note: {note}"));
        }
        if args.json {
            print_json(&Verdict { scene: path, ok: error.is_none(), error, notes })?;
        }
    }
    Ok(exit)
}

/// Reads and prepares a scene as for rendering. Gives what it holds, and notes that say by
/// themselves which file they are about.
fn examine(path: &Path, reading: &Reading) -> Result<(String, Vec<String>), Failure> {
    let loaded = load::read(Some(path), reading, None)?;
    let prepared = load::prepare(&loaded, options::Build::Default, options::SimdLevel::Auto)?;
    let notes = load::notes(&loaded, &prepared, &loaded.settings, Some(path));
    Ok((contents(&loaded.scene), notes))
}

/// A line about what a scene holds.
pub(crate) fn contents(scene: &Scene) -> String {
    [
        several(scene.objects.len() as u64, "object", "objects"),
        several(triangles(scene), "triangle", "triangles"),
        several(scene.materials.len() as u64, "material", "materials"),
        several(lamps(scene), "light", "lights"),
    ]
    .join(", ")
}

/// Triangles of all objects, each counted as often as it stands in the scene.
pub(crate) fn triangles(scene: &Scene) -> u64 {
    let of = |shape: &Shape| match shape {
        Shape::Mesh(id) => scene.meshes.get(id.0 as usize).map_or(0, |m| m.triangles.len() as u64),
        Shape::Sphere { .. } | Shape::Disk { .. } | Shape::Custom(_) => 0,
        Shape::Rectangle { .. } => 2,
        Shape::Box { .. } => 12,
    };
    scene.objects.iter().map(|object| of(&object.shape)).sum()
}

/// Everything that gives light: glowing objects, lights without a surface, the sky.
pub(crate) fn lamps(scene: &Scene) -> u64 {
    let glows = |id: usize| scene.materials.get(id).is_some_and(|m| m.emission.is_some());
    let glowing = scene.objects.iter().filter(|o| glows(o.material.0 as usize)).count();
    (glowing + scene.lights.len() + usize::from(scene.environment.is_some())) as u64
}
