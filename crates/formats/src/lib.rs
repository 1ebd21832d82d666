//! Scenes and images from files, and images to files.
//!
//! This crate is the only door for untrusted bytes: whatever they are, it
//! returns a value or an error and never panics.

mod error;
mod file;
pub mod image;
mod limits;
pub mod scene;

pub use error::{ImageError, SceneError, SceneErrorKind, Source};
pub use limits::Limits;
