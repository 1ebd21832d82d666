//! Stand-in until the OBJ reader is merged: this whole file is to be replaced.
use crate::{Limits, SceneError, SceneErrorKind, Source};
use rutilant::{material::Material, shape::Mesh};
use std::path::Path;

pub(crate) struct ObjScene {
    pub(crate) meshes: Vec<(Mesh, Option<String>)>,
    pub(crate) materials: Vec<Material>,
    pub(crate) notes: Vec<String>,
}

pub(crate) fn read(path: &Path, _limits: &Limits) -> Result<ObjScene, SceneError> {
    let kind = SceneErrorKind::Unsupported("OBJ files are not read yet".to_owned());
    Err(SceneError { at: Source::file(path), kind })
}
