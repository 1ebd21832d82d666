//! The native scene format: TOML, written by people. See docs/scene-format.md.
//!
//! The text becomes a tree of tables in which every value knows its place.
//! Each section below maps one kind of table to the authored scene. What the
//! numbers may be is decided by the scene's and the settings' own `validate`
//! alone: a problem they find is traced back to the key it came from.

pub(crate) mod camera;
pub(crate) mod convert;
mod document;
mod draft;
mod edit;
mod environment;
mod hex;
mod instances;
mod keys;
mod layout;
mod light;
mod light_group;
mod material;
mod placing;
mod render;
pub(crate) mod rewrite;
mod said;
mod shape;
mod table;
mod texture;

use super::framing::{TOO_LARGE, Unseen, frame_all};
use super::loaded::LoadedScene;
use super::mesh_file;
use super::text::in_utf8;
use crate::error::{SceneError, SceneErrorKind};
use crate::file;
use crate::limits::Limits;
use crate::options::{CameraChoice, ReadOptions};
use document::Document;
use draft::Draft;
use rutilant::scene::Place;
use std::path::Path;
use std::thread;
use table::Table;

/// Reads a scene from a `.toml` file.
pub(crate) fn read(path: &Path, options: &ReadOptions<'_>) -> Result<LoadedScene, SceneError> {
    parse(&text(path, &options.limits)?, path, options)
}

/// The text of a `.toml` file.
pub(crate) fn text(path: &Path, limits: &Limits) -> Result<String, SceneError> {
    let bytes = file::scene_bytes(path, limits)?;
    let is_binary = bytes.contains(&0);
    in_utf8(bytes, path).map_err(|error| match is_binary {
        true => {
            let what = "this is no text, so no scene in TOML";
            SceneError { kind: SceneErrorKind::Invalid(what.to_owned()), ..error }
        }
        false => error,
    })
}

/// Stack for taking apart the deepest tree that gets through the TOML parser's limits: 80 tables
/// in each other, each behind a key of 80 parts, at some 250 bytes for each level.
const STACK: usize = 16 << 20;

/// Reads a scene from text that stands, or would stand, in `file`.
///
/// Trees are taken apart by recursion, inside the TOML parser as well. This happens on a thread
/// with room for it, so that no caller's stack can be too small.
pub(crate) fn parse(
    text: &str,
    file: &Path,
    options: &ReadOptions<'_>,
) -> Result<LoadedScene, SceneError> {
    with_room(file, || parse_here(text, file, options))
}

/// Runs something on a thread with room for the deepest tree.
fn with_room<T: Send>(
    file: &Path,
    run: impl FnOnce() -> Result<T, SceneError> + Send,
) -> Result<T, SceneError> {
    thread::scope(|scope| {
        thread::Builder::new()
            .stack_size(STACK)
            .spawn_scoped(scope, run)
            .map_err(|error| SceneError::in_file(file, SceneErrorKind::Io(error)))?
            .join()
            .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}

fn parse_here(
    text: &str,
    file: &Path,
    options: &ReadOptions<'_>,
) -> Result<LoadedScene, SceneError> {
    let document = Document::new(text, file);
    let tree = document.parse()?;
    document.must_be_shallow(tree.get_ref(), options.limits.nesting)?;
    let root = Table::root(&document, tree.get_ref());
    check_version(&root)?;
    root.only(&[keys::ROOT])?;

    let mut draft = Draft::new(file, options);

    // How to render, and who sees it: checked first, because files can take long to read.
    let render = root.maybe("render", |v| v.table("[render]"))?;
    let (settings, display) =
        render.as_ref().map_or_else(|| Ok(Default::default()), render::read)?;
    if let Some(table) = &render
        && options.size.is_none()
    {
        render::check_size(table, settings.size, options.limits.picture)?;
    }
    draft.places.extend(render.map(|table| (Place::Settings, table)));
    settings.validate().map_err(|problem| draft.locate(&root, &problem))?;
    let (mut cameras, mut camera) =
        camera::read_all(&root, settings.size, file, options, &mut draft)?;

    // What there is. Textures come before the materials that name them, these before the shapes.
    for table in root.or("texture", |v| v.tables("[[texture]]"), Vec::new())? {
        texture::read(&table, &mut draft)?;
    }
    let materials = root.or("material", |v| v.tables("[[material]]"), Vec::new())?;
    material::read_all(&materials, &mut draft)?;
    for table in root.or("light", |v| v.tables("[[light]]"), Vec::new())? {
        light::read(&table, &mut draft)?;
    }
    if let Some(table) = root.maybe("environment", |v| v.table("[environment]"))? {
        environment::read(&table, &mut draft)?;
    }
    for table in root.or("shape", |v| v.tables("[[shape]]"), Vec::new())? {
        shape::read(&table, &mut draft)?;
    }
    let auto = *options.camera == CameraChoice::Auto;
    if cameras.is_empty() || auto {
        let size = options.size.unwrap_or(settings.size);
        let missing = if auto { "no camera can be chosen: " } else { "there is no [camera], and " };
        let chosen = frame_all(&draft.scene, size).map_err(|why| {
            root.invalid(match why {
                Unseen::Nothing => format!("{missing}no shape that one could be turned to"),
                Unseen::TooLarge => format!("{missing}what is there cannot have one: {TOO_LARGE}"),
            })
        })?;
        draft.scene.camera = chosen.camera;
        draft.places.remove(&Place::Camera);
        camera = cameras.len();
        cameras.push(chosen.authored);
        if !auto {
            let note = root.note("there is no [camera]: one was chosen that sees all shapes");
            draft.notes.push(note);
        }
    }

    // Whether all of it makes sense. Pictures come last, because they can take long to read.
    draft.scene.bitmaps = draft.pictures.bare();
    draft.scene.validate().map_err(|problem| draft.locate(&root, &problem))?;
    draft.scene.bitmaps = draft.pictures.read(&draft.left, options.strict, &mut draft.notes)?;
    draft.read.extend(draft.pictures.files());
    let from_meshes = std::mem::take(&mut draft.mesh_materials);
    for (i, what) in mesh_file::tell_normals_from_heights(&mut draft.scene, from_meshes) {
        draft.notes.extend(draft.places.get(&Place::Material(i)).map(|table| table.note(&what)));
    }
    let lines = draft.places.iter().map(|(place, table)| (*place, table.line())).collect();
    draft.origins.bitmaps = draft.pictures.origins();
    let Draft { scene, notes, read: files, image_names, texture_names, origins, .. } = draft;
    Ok(LoadedScene {
        scene,
        settings,
        display,
        cameras,
        camera,
        image_names,
        texture_names,
        origins,
        notes,
        files,
        lines,
    })
}

/// The version of the format that is read here.
const VERSION: u32 = 1;

fn check_version(root: &Table<'_>) -> Result<(), SceneError> {
    root.must("version", |value| match value.whole()? {
        VERSION => Ok(()),
        other => {
            let what = format!("version {other} of the scene format is not known; {VERSION} is");
            Err(value.error(SceneErrorKind::Unsupported(what)))
        }
    })
}
