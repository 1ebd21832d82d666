//! From what the author wrote to what can be traced: slow, once, and the last place that can fail.
//!
//! A [`Prepared`] scene is flat: arrays that point into each other by number.
//! Shapes become triangles, spheres, disks and custom surfaces in the world under one tree,
//! materials become BSDFs, everything that shines becomes an emitter.

mod assembly;
mod casters;
mod casting;
mod material;
mod prepared;

pub(crate) use casters::{Aim, Casting, Outlook};
pub(crate) use material::PreparedMaterial;
pub use prepared::{PrepareReport, Prepared};

use crate::scene::{Scene, SceneProblem};
use assembly::Assembly;
use rutilant_geom::{BuildOptions, Simd};

impl Prepared {
    /// Makes a scene traceable.
    ///
    /// # Errors
    /// What [`Scene::validate`] finds. Broken triangles are no error: they are left out, counted
    /// and reported.
    pub fn new(scene: &Scene) -> Result<Self, SceneProblem> {
        Self::with_options(scene, &BuildOptions::default())
    }

    /// The same with a say in how the tree is built.
    ///
    /// # Errors
    /// As for [`new`](Self::new).
    pub fn with_options(scene: &Scene, options: &BuildOptions) -> Result<Self, SceneProblem> {
        scene.validate()?;
        Ok(Assembly::default().finish(scene, options))
    }

    /// The same, its rays traced with other instructions of the processor: no picture changes by a
    /// bit. `None` where the processor has none of these.
    pub fn with_simd(self, simd: Simd) -> Option<Self> {
        Some(Self { surfaces: self.surfaces.with_simd(simd)?, ..self })
    }
}
