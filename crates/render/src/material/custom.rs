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
//! /// White paper and half mirrors in turn, a tenth of a metre each way.
//! #[derive(Debug)]
//! struct Checker;
//!
//! impl CustomMaterial for Checker {
//!     fn bsdf(&self, point: &SurfacePoint) -> Bsdf {
//!         let tile = (point.position * 10.0).floor();
//!         if (tile.x + tile.y + tile.z) % 2.0 == 0.0 {
//!             Lobe::Lambert(Lambert { albedo: Spectrum::splat(0.8) }).into()
//!         } else {
//!             Lobe::Mirror(PerfectMirror { reflectance: Spectrum::splat(0.5) }).into()
//!         }
//!     }
//! }
//!
//! use rutilant::camera::Perspective;
//! use rutilant::color::Rgb;
//! use rutilant::geom::{Transform, Vec2, Vec3};
//! use rutilant::light::Environment;
//! use rutilant::scene::Scene;
//! use rutilant::settings::Settings;
//! use rutilant::shape::{Object, Shape};
//! use rutilant::{Prepared, Session};
//! use std::{sync::Arc, time::Duration};
//!
//! // A board of it under a white sky, seen from above a border of two squares: every square fills half of the
//! // picture and sends back its part of the light.
//! let target = Vec3::new(0.1, 0.05, 0.05);
//! let mut scene = Scene::new(Perspective::look_at(target + 0.1 * Vec3::Z, target, 0.5).unwrap());
//! scene.environment = Some(Environment::constant(Rgb::WHITE));
//! let checker: Arc<dyn CustomMaterial> = Arc::new(Checker);
//! let checker = scene.add_material(checker);
//! let board = Object::new(Shape::Rectangle { size: Vec2::ONE }, checker);
//! scene.objects.push(board.transformed(&Transform::translate(0.05 * Vec3::Z)));
//!
//! let prepared = Arc::new(Prepared::new(&scene)?);
//! let settings = Settings { size: [8, 8], spp: 64, ..Settings::default() };
//! let session = Session::start(prepared, settings, 2)?;
//! while !session.wait(Duration::from_secs(1)) {}
//!
//! let image = session.snapshot();
//! let row = &image.channel("G").unwrap()[4 * 8..5 * 8];
//! assert!((row[1] - 0.8).abs() < 0.01, "paper on the left");
//! assert!((row[6] - 0.5).abs() < 0.01, "a mirror on the right");
//! # Ok::<(), rutilant::scene::SceneProblem>(())
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
