//! A mesh file on its own, made a scene: grey where it has no material, under an even sky.

use super::files::Fence;
use super::framing::{TOO_LARGE, Unseen, frame_all};
use super::loaded::{self, LoadedScene};
use super::mesh_file;
use super::origins::{MeshOrigin, Origins};
use super::pictures::Pictures;
use crate::error::SceneError;
use crate::options::{CameraChoice, ReadOptions, SkyChoice};
use rutilant::camera::{Lens, Perspective};
use rutilant::color::Rgb;
use rutilant::light::Environment;
use rutilant::material::{Material, Matte};
use rutilant::scene::Scene;
use rutilant::settings::Settings;
use rutilant::shape::{Object, Shape};
use rutilant_geom::Transform;
use std::path::Path;

/// Reads a mesh file of any kind.
pub(crate) fn read(path: &Path, options: &ReadOptions<'_>) -> Result<LoadedScene, SceneError> {
    let mut file = mesh_file::read(path, &options.limits, &Fence::asked(path, options), |kind| {
        SceneError::in_file(path, kind)
    })?;
    let (mut scene, settings) = (empty(), Settings::default());
    let mut notes = std::mem::take(&mut file.notes);
    let note = |what: &str| format!("{}: {what}", path.display());

    // The file's materials, and grey for what has none.
    let mut pictures = Pictures::default();
    let materials = mesh_file::adopt(&mut file, &mut scene, &mut pictures);
    scene.bitmaps = pictures.read(&options.limits, options.strict, &mut notes)?;
    let all = 0..scene.materials.len();
    let changed = mesh_file::tell_normals_from_heights(&mut scene, all);
    notes.extend(changed.iter().map(|(_, what)| note(what)));
    let no_faces = file.meshes.is_empty();
    let bare = |name: &Option<String>| name.as_ref().is_none_or(|n| !materials.contains_key(n));
    let some_bare = file.meshes.iter().any(|(_, name)| bare(name));
    if let Some(without) = mesh_file::without_material(&file.meshes, &materials) {
        notes.push(note(&format!("{without}: matte grey stands in")));
    } else if some_bare {
        notes.push(note("the file has no materials: matte grey stands in"));
    }
    let backup = some_bare.then(|| scene.add_material(grey()));
    let mut origins = Origins { bitmaps: pictures.origins(), ..Origins::default() };
    if let ([_], true) = (&file.meshes[..], materials.is_empty()) {
        let path = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        origins.meshes.push(MeshOrigin::File { path, crease: None });
    }
    for (mesh, name) in file.meshes {
        let own = name.and_then(|name| materials.get(&name).copied());
        let Some(material) = own.or(backup) else { continue };
        let shape = Shape::Mesh(scene.add_mesh(mesh));
        scene.objects.push(Object::new(shape, material));
    }

    // Light and a camera.
    let own_sky = *options.sky == SkyChoice::Own;
    scene.environment = own_sky.then(|| Environment::constant(Rgb::WHITE));
    let chosen = frame_all(&scene, options.size.unwrap_or(settings.size)).map_err(|why| {
        let why = match why {
            Unseen::Nothing if no_faces => "there is nothing to see: there are no faces",
            Unseen::Nothing => "there is nothing to see: no vertex is a finite point",
            Unseen::TooLarge => TOO_LARGE,
        };
        SceneError::invalid_file(path, why)
    })?;
    scene.camera = chosen.camera;
    let cameras = vec![chosen.authored];
    let camera = loaded::camera_named(&cameras, path, options)?;
    let own_camera = *options.camera != CameraChoice::Auto;
    notes.extend(match (own_sky, own_camera) {
        (true, true) => Some(note(
            "a mesh has no sky and no camera: an even white sky lights it, and the camera was \
             chosen to see all of it",
        )),
        (true, false) => Some(note("a mesh has no sky: an even white one lights it")),
        (false, true) => Some(note("a mesh has no camera: one was chosen that sees all of it")),
        (false, false) => None,
    });

    scene.validate().map_err(|problem| SceneError::invalid_file(path, problem.to_string()))?;
    Ok(LoadedScene {
        scene,
        settings,
        display: Default::default(),
        cameras,
        camera,
        image_names: Vec::new(),
        texture_names: Vec::new(),
        origins,
        notes,
        files: pictures.files().collect(),
        lines: Default::default(),
    })
}

/// A matte grey that shows form: neither white nor dark.
pub(super) fn grey() -> Material {
    Material::from(Matte::new(Rgb::grey(0.5))).named("grey")
}

/// A scene with nothing in it, seen by a camera that is to be replaced.
pub(super) fn empty() -> Scene {
    Scene::new(Perspective {
        world_from_camera: Transform::IDENTITY,
        fov_y: 1.0,
        lens: Lens::pinhole(1.0),
    })
}
