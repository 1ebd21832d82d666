//! Stand-in until the OBJ reader is merged: this whole file is to be replaced.
#![allow(missing_docs, clippy::missing_errors_doc)]
use crate::{Limits, SceneError, SceneErrorKind, Source};
use rutilant::{material::Material, shape::Mesh};
use std::path::Path;

pub struct ObjScene {
    pub meshes: Vec<(Mesh, Option<String>)>,
    pub materials: Vec<Material>,
    pub notes: Vec<String>,
}

pub fn read(path: &Path, _limits: &Limits) -> Result<ObjScene, SceneError> {
    let kind = SceneErrorKind::Unsupported("OBJ files are not read yet".to_owned());
    Err(SceneError { at: Source::file(path), kind })
}
