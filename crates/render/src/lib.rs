//! Rutilant: a physically based path tracer.

pub mod bsdf;
pub mod camera;
pub mod color;
pub mod film;
pub mod image;
pub mod light;
pub mod material;
pub mod math;
pub mod scene;
pub mod settings;
pub mod shape;

pub use rutilant_geom as geom;
