//! Stand-in until the PLY reader is merged: this whole file is to be replaced.
#![allow(missing_docs, clippy::missing_errors_doc)]
use crate::{Limits, SceneError, SceneErrorKind, Source};
use rutilant::shape::Mesh;
use std::path::Path;

pub fn read(path: &Path, _limits: &Limits) -> Result<(Mesh, Vec<String>), SceneError> {
    let kind = SceneErrorKind::Unsupported("PLY files are not read yet".to_owned());
    Err(SceneError { at: Source::file(path), kind })
}
