//! Scenes from files: one file here for each kind.

mod affine;
pub(crate) mod bare;
mod called;
mod disney;
mod files;
mod framing;
pub mod gltf;
pub(crate) mod loaded;
mod mesh_file;
pub mod mitsuba;
pub mod mtl;
pub(crate) mod native;
mod nearest;
mod notes;
pub mod obj;
pub(crate) mod origins;
pub(crate) mod pbrt;
pub(crate) mod pictures;
pub mod ply;
mod polygon;
mod round;
pub(crate) mod spectrum;
pub mod stl;
mod text;
