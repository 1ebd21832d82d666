//! Rutilant: a physically based path tracer.
//!
//! Scene → Prepared → Integrator → Film → Image, inside a Session.
//!
//! A [`Scene`](scene::Scene) is what an author wrote. [`Prepared`] is the same
//! made traceable. A [`Session`] lets an integrator estimate the light that
//! reaches each pixel, sample by sample, and the film keeps the sums until
//! somebody asks for an [`Image`](image::Image).
//!
//! ```
//! use rutilant::camera::Perspective;
//! use rutilant::color::Rgb;
//! use rutilant::geom::Vec3;
//! use rutilant::light::Environment;
//! use rutilant::material::Matte;
//! use rutilant::scene::Scene;
//! use rutilant::settings::Settings;
//! use rutilant::shape::{Object, Shape};
//! use rutilant::{Prepared, Session};
//! use std::{sync::Arc, time::Duration};
//!
//! // A grey ball under a white sky sends back half of the light, everywhere.
//! let eye = Vec3::new(0.0, 0.0, 3.0);
//! let mut scene = Scene::new(Perspective::look_at(eye, Vec3::ZERO, 0.5).unwrap());
//! scene.environment = Some(Environment::constant(Rgb::WHITE));
//! let grey = scene.add_material(Matte::new(Rgb::grey(0.5)));
//! scene.objects.push(Object::new(Shape::Sphere { radius: 1.0 }, grey));
//!
//! let prepared = Arc::new(Prepared::new(&scene)?);
//! let settings = Settings { size: [8, 8], spp: 16, ..Settings::default() };
//! let session = Session::start(prepared, settings, 2)?;
//! while !session.wait(Duration::from_secs(1)) {}
//!
//! let image = session.snapshot();
//! let middle = image.channel("G").unwrap()[4 * 8 + 4];
//! assert!((middle - 0.5).abs() < 0.01);
//! # Ok::<(), rutilant::scene::SceneProblem>(())
//! ```

pub mod bsdf;
pub mod camera;
pub mod color;
mod cpu;
pub mod cryptomatte;
mod dispersion;
pub mod display;
pub mod false_color;
pub mod film;
pub mod focus;
mod follow;
mod groups;
mod id;
pub mod image;
mod integrator;
pub mod interaction;
mod lanes;
pub mod light;
pub mod material;
pub mod math;
mod medium;
pub mod prepare;
mod problem;
pub mod sampler;
pub mod scene;
pub mod session;
pub mod settings;
pub mod shape;
mod sharing;
pub mod texture;
mod winding;

pub use prepare::Prepared;
pub use rutilant_geom as geom;
pub use session::{Progress, Session};
