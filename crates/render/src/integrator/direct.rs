//! Emission and direct light: one light sampled at the first surface.
//!
//! Written apart from [`Path`](super::Path), which gives the same picture at a depth of 2: light
//! samples alone on rough surfaces, scattered rays alone on mirrors and glass and for light that
//! no sample can find.

use super::dimension::{BAND, Bounce};
use super::emission::SeenEmission;
use super::estimate::Integrator;
use crate::color::Spectrum;
use crate::follow::{follow, transmittance};
use crate::light::EmitterSelection;
use crate::prepare::Prepared;
use crate::sampler::Sampler;
use rutilant_geom::Ray;

/// Direct light only.
pub(crate) struct Direct {
    pub(crate) selection: EmitterSelection,
}

impl Integrator for Direct {
    fn radiance<S: Sampler>(
        &self,
        scene: &Prepared,
        ray: Ray,
        sampler: &S,
        rays: &mut u64,
    ) -> Spectrum {
        let (mut ray, mut media) = (ray, scene.camera_media());
        let mut radiance = Spectrum::BLACK;
        let mut made = None;
        let way = follow(scene, &mut ray, &mut media, &mut made, rays, &mut |glowing| {
            radiance += emitted(SeenEmission::of_surface(scene, glowing.at)) * glowing.through;
        });
        let Some(met) = way.met else {
            return radiance + emitted(SeenEmission::of_sky(scene, &ray)) * way.through;
        };
        let at = &met.at;
        let wo = at.wo_local();
        let bounce = Bounce::at(1);
        radiance += emitted(SeenEmission::of_surface(scene, at)) * way.through;

        // Of colours that are bent differently here only one goes on.
        let mut room = None;
        let u = || sampler.d1(BAND);
        let (worth, material) = scene.in_one_band(met.material, &mut media, u, &mut room);
        let (bsdf, left) = (&material.bsdf, way.through * worth);

        // Rough lobes: one light, anywhere on it, and for clear surfaces on either side.
        let translucent = bsdf.is_translucent();
        let point = at.shading_point(bsdf);
        let from = point.position;
        if let Some((emitter, pmf)) = bounce.select(&self.selection, &point, sampler)
            && !bsdf.is_delta()
            && let Some(light) =
                scene.emitters()[emitter].sample(from, sampler.d2(bounce.light_point()))
        {
            let wi = at.shading.to_local(light.wi);
            let beyond = wo.z * wi.z < 0.0;
            let origin = if translucent { at.surface_origin(beyond) } else { from };
            *rays += 1;
            if !scene.occluded(&light.shadow_ray(origin)) {
                let sides = [media.absorption, met.absorption_beyond(&media)];
                let distance = light.end.map_or(f32::INFINITY, |end| origin.distance(end));
                let through = left * transmittance(sides[usize::from(beyond)], distance);
                let scattered = bsdf.eval_cos(wo, wi) * (1.0 / (pmf * light.pdf));
                radiance += scattered * light.radiance * through;
            }
        }

        // Mirrors and glass: the light seen in them. So too where light samples cannot find it.
        let sample = bounce.scatter(bsdf, wo, sampler);
        if let Some(sample) = sample.filter(|s| s.delta || scene.light_beyond_sampling()) {
            let crossed = sample.is_transmission(wo);
            if crossed {
                met.cross(&mut media);
            }
            let mut ray = at.scattered_ray(bsdf, &sample, crossed);
            let (from, direction, weight) = (ray.origin, ray.direction, left * sample.weight);
            let unsampled = |seen: Option<SeenEmission>, beyond_passed: bool| {
                emitted(seen.filter(|seen| {
                    sample.delta
                        || beyond_passed
                        || seen.light_pdf(scene, &self.selection, &point, from, direction) == 0.0
                }))
            };
            let mut made = None;
            let onward = follow(scene, &mut ray, &mut media, &mut made, rays, &mut |glowing| {
                let seen = SeenEmission::of_surface(scene, glowing.at);
                radiance += unsampled(seen, glowing.beyond_passed) * weight * glowing.through;
            });
            let seen = match &onward.met {
                Some(met) => SeenEmission::of_surface(scene, &met.at),
                None => SeenEmission::of_sky(scene, &ray),
            };
            radiance += unsampled(seen, onward.passed) * weight * onward.through;
        }
        radiance
    }
}

fn emitted(seen: Option<SeenEmission>) -> Spectrum {
    seen.map_or(Spectrum::BLACK, |seen| seen.radiance)
}
