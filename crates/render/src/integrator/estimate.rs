//! What every integrator does.

use super::caustics::Caustics;
use super::packet::Starts;
use crate::color::Spectrum;
use crate::prepare::Prepared;
use crate::sampler::Sampler;
use rutilant_geom::Ray;
use rutilant_geom::lanes::LANES;

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
        let mut radiance = vec![Spectrum::BLACK; starts.len() * LANES];
        if self.trace_together(scene, starts, &mut radiance, rays) {
            found.extend(radiance.into_iter().map(|radiance| (radiance, 0.0)));
            return;
        }
        for Starts { rays: first, samplers } in starts {
            found.extend(samplers.iter().enumerate().map(|(lane, sampler)| {
                if first.is_there(lane) {
                    self.controlled(scene, first.ray(lane), sampler, rays)
                } else {
                    (Spectrum::BLACK, 0.0)
                }
            }));
        }
    }

    /// Finds the radiance of all starts at once, if the integrator can do that in this scene, with
    /// the bits that each would bring alone; false if it cannot.
    fn trace_together<S: Sampler>(
        &self,
        _: &Prepared,
        _: &[Starts<S>],
        _: &mut [Spectrum],
        _: &mut u64,
    ) -> bool {
        false
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

    /// How light paths share the work, if they do.
    fn caustics(&self) -> Option<&Caustics<'_>> {
        None
    }
}
