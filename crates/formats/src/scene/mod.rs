//! Scenes and meshes from files.

mod mtl;
pub mod obj;
pub mod ply;
mod polygon;
mod text;
