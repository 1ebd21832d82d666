//! What every integrator does.

use super::packet::Starts;
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

    /// What [`controlled`](Self::controlled) gives for each start, eight for each packet, in their
    /// order.
    fn estimates<S: Sampler>(
        &self,
        scene: &Prepared,
        starts: &[Starts<S>],
        found: &mut Vec<(Spectrum, f32)>,
        rays: &mut u64,
    ) {
        for starts in starts {
            for (lane, sampler) in starts.samplers.iter().enumerate() {
                let there = starts.rays.is_there(lane);
                let ray = starts.rays.ray(lane);
                found.push(if there {
                    self.controlled(scene, ray, sampler, rays)
                } else {
                    (Spectrum::BLACK, 0.0)
                });
            }
        }
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
