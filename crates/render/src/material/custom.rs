//! Materials of others' making: the stranger's door.
//!
//! Whoever can say how a surface scatters at a place, as a [`Bsdf`] made of the
//! lobes there are, writes one function and has a material like the built-in
//! ones: light sampling, roulette and pictures of albedo follow from the lobes.
//!
//! Not for light that a surface gives (that is the [`Material`](super::Material)'s
//! emission, the same everywhere) nor for bodies with an inside: light may cross
//! the surface, but what is behind it absorbs as what is in front.
//!
//! ```
//! use rutilant::bsdf::{Bsdf, Lambert, Lobe, PerfectMirror};
//! use rutilant::color::Spectrum;
//! use rutilant::material::{CustomMaterial, SurfacePoint};
//!
//! /// White paper and mirrors in turn, a tenth of a metre each way.
//! #[derive(Debug)]
//! struct Checker;
//!
//! impl CustomMaterial for Checker {
//!     fn bsdf(&self, point: &SurfacePoint) -> Bsdf {
//!         let tile = (point.position * 10.0).floor();
//!         let white = Spectrum::splat(0.8);
//!         if (tile.x + tile.y + tile.z) % 2.0 == 0.0 {
//!             Lobe::Lambert(Lambert { albedo: white }).into()
//!         } else {
//!             Lobe::Mirror(PerfectMirror { reflectance: white }).into()
//!         }
//!     }
//! }
//!
//! use rutilant::camera::Perspective;
//! use rutilant::geom::Vec3;
//! use rutilant::scene::Scene;
//! use std::sync::Arc;
//!
//! let camera = Perspective::look_at(Vec3::Z, Vec3::ZERO, 0.5).unwrap();
//! let mut scene = Scene::new(camera);
//! let checker: Arc<dyn CustomMaterial> = Arc::new(Checker);
//! let checker = scene.add_material(checker);
//! # let _ = checker;
//! ```

use crate::bsdf::Bsdf;
use rutilant_geom::{Vec2, Vec3};
use std::fmt;

/// How a surface scatters, place by place.
///
/// The same question must always get the same answer, on every machine: use
/// [`real`](rutilant_geom::real) instead of the standard library's sine and its kin.
pub trait CustomMaterial: fmt::Debug + Send + Sync {
    /// How it scatters at this point. Lobes that send back more than they get make light out of
    /// nothing; samples that are no numbers are dropped, counted and located.
    fn bsdf(&self, point: &SurfacePoint) -> Bsdf;
}

/// A point on a surface, for a material to look at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Where it is in the world.
    pub position: Vec3,
    /// The unit normal of the true surface there, on its front.
    pub normal: Vec3,
    /// Texture coordinates: see [`Prepared::uv`](crate::Prepared::uv).
    pub uv: Vec2,
}

/// The same if it is the very same material.
impl PartialEq for dyn CustomMaterial {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::addr_eq(self, other)
    }
}
