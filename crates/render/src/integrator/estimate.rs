//! What every integrator does.

use crate::color::Spectrum;
use crate::prepare::Prepared;
use super::packet::Start;
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

    /// The radiance that each start brings, in their order, and a number as from
    /// [`controlled`](Self::controlled).
    fn estimates<S: Sampler>(
        &self,
        scene: &Prepared,
        starts: &[Start<S>],
        found: &mut Vec<(Spectrum, f32)>,
        rays: &mut u64,
    ) {
        let all = starts.iter().map(|s| self.controlled(scene, s.ray, &s.sampler, rays));
        found.extend(all);
    }

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
