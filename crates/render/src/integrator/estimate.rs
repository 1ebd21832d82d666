//! What every integrator does.

use crate::color::Spectrum;
use crate::prepare::Prepared;
use crate::sampler::Sampler;
use rutilant_geom::Ray;

/// Gives the radiance that one ray brings, estimated once.
pub(crate) trait Integrator: Sync {
    /// The radiance arriving along `ray` (of unit direction), in W/(m² sr), or what else the
    /// integrator shows. Counts the rays it traces.
    fn radiance<S: Sampler>(
        &self,
        scene: &Prepared,
        ray: Ray,
        sampler: &S,
        rays: &mut u64,
    ) -> Spectrum;

    /// The same radiance, and a number whose mean is zero and whose noise the radiance may share,
    /// which the film then takes out. 0 for integrators that know of none.
    fn controlled<S: Sampler>(
        &self,
        scene: &Prepared,
        ray: Ray,
        sampler: &S,
        rays: &mut u64,
    ) -> (Spectrum, f32) {
        (self.radiance(scene, ray, sampler, rays), 0.0)
    }
}
