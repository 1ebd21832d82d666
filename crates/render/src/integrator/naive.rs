//! Path tracing at its plainest: scatter, and see what comes.
//!
//! No light sampling, no multiple importance sampling, roulette by a constant
//! chance. It is written apart from [`Path`](super::Path) on purpose: the two must agree.
//! Lights without a surface are never found.

use super::dimension::{BAND, Bounce};
use super::emission::SeenEmission;
use super::estimate::Integrator;
use crate::color::Spectrum;
use crate::follow::follow;
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
        let mut media = scene.camera_media();
        let mut ray = camera_ray;
        for depth in 1..=self.max_depth {
            let mut made = None;
            let way = follow(scene, &mut ray, &mut media, &mut made, rays, &mut |glowing| {
                if let Some(emission) = SeenEmission::of_surface(scene, glowing.at) {
                    radiance += throughput * glowing.through * emission.radiance;
                }
            });
            throughput *= way.through;
            let Some(met) = way.met else {
                if let Some(sky) = SeenEmission::of_sky(scene, &ray) {
                    radiance += throughput * sky.radiance;
                }
                break;
            };
            if let Some(emission) = SeenEmission::of_surface(scene, &met.at) {
                radiance += throughput * emission.radiance;
            }

            let mut room = None;
            let u = || sampler.d1(BAND);
            let (worth, material) = scene.in_one_band(met.material, &mut media, u, &mut room);
            throughput *= worth;
            let (wo, bounce) = (met.at.wo_local(), Bounce::at(depth));
            let Some(sample) = bounce.scatter(&material.bsdf, wo, sampler) else { break };
            throughput *= sample.weight;
            let crossed = sample.is_transmission(wo);
            if crossed {
                met.cross(&mut media);
            }
            ray = met.at.scattered_ray(&material.bsdf, &sample, crossed);

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
