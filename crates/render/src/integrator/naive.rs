//! Path tracing at its plainest: scatter, and see what comes.
//!
//! No light sampling, no multiple importance sampling, roulette by throughput
//! only. It is written apart from [`Path`](super::Path) on purpose: the two must agree.
//! Lights without a surface are never found.

use super::dimension::Bounce;
use super::emission::SeenEmission;
use super::estimate::Integrator;
use super::passing::light_passed;
use super::path::transmittance;
use crate::color::Spectrum;
use crate::prepare::Prepared;
use crate::sampler::Sampler;
use rutilant_geom::Ray;

/// Finds light by chance.
pub(crate) struct Naive {
    /// The longest path in segments.
    pub(crate) max_depth: u32,
}

/// From this many segments on, a path goes on with this probability.
const SURVIVAL: (u32, f32) = (6, 0.7);

impl Integrator for Naive {
    fn radiance<S: Sampler>(
        &self,
        scene: &Prepared,
        camera_ray: Ray,
        sampler: &S,
        rays: &mut u64,
    ) -> Spectrum {
        let mut radiance = Spectrum::BLACK;
        let mut throughput = Spectrum::WHITE;
        let mut absorption = scene.camera_absorption();
        let mut ray = camera_ray;
        for depth in 1..=self.max_depth {
            *rays += 1;
            if scene.some_pass() {
                let passed = light_passed(scene, &mut ray, |glow, distance| {
                    glow.radiance * transmittance(absorption, distance)
                });
                radiance += throughput * passed;
            }
            let Some(hit) = scene.closest(&ray) else {
                if let Some(sky) = SeenEmission::of_sky(scene, ray.direction) {
                    radiance +=
                        throughput * transmittance(absorption, f32::INFINITY) * sky.radiance;
                }
                break;
            };
            let at = scene.interaction(&hit, ray.direction);
            let material = scene.material(&at);
            let wo = at.wo_local();
            if let Some(border) = &material.border {
                absorption = border.absorption(wo.z > 0.0);
            }
            throughput *= transmittance(absorption, hit.t);
            if let Some(emission) = SeenEmission::of_surface(scene, &at) {
                radiance += throughput * emission.radiance;
            }

            let bounce = Bounce::at(depth);
            let Some(sample) =
                material.bsdf.sample(wo, sampler.d1(bounce.lobe()), sampler.d2(bounce.direction()))
            else {
                break;
            };
            throughput *= sample.weight;
            let crossed = sample.is_transmission(wo);
            if let (true, Some(border)) = (crossed, &material.border) {
                absorption = border.absorption(wo.z < 0.0);
            }
            ray = at.scattered_ray(&material.bsdf, &sample, crossed);

            let (from, survival) = SURVIVAL;
            if depth >= from {
                if sampler.d1(bounce.roulette()) >= survival {
                    break;
                }
                throughput *= 1.0 / survival;
            }
        }
        radiance
    }
}
