//! Emission and direct light: one light sampled at the first surface.
//!
//! Written apart from [`Path`](super::Path), which gives the same picture at a depth of 2: light
//! samples alone on rough surfaces, scattered rays alone on mirrors and glass and for light that
//! no sample can find.

use super::dimension::Bounce;
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
        let way = follow(scene, &mut ray, &mut media, rays);
        let Some(met) = way.met else {
            return SeenEmission::of_sky(scene, ray.direction)
                .map_or(Spectrum::BLACK, |s| s.radiance * way.through);
        };
        let (at, bsdf) = (&met.at, &met.material.bsdf);
        let wo = at.wo_local();
        let bounce = Bounce::at(1);
        let mut radiance =
            SeenEmission::of_surface(scene, at).map_or(Spectrum::BLACK, |e| e.radiance);

        // Rough lobes: one light, anywhere on it.
        let origin = at.reflected_origin();
        if let Some((emitter, pmf)) = self.selection.select(origin, sampler.d1(bounce.light()))
            && !bsdf.is_delta()
            && let Some(light) =
                scene.emitters()[emitter].sample(origin, sampler.d2(bounce.light_point()))
        {
            *rays += 1;
            if !scene.occluded(&light.shadow_ray(origin)) {
                let scattered = bsdf.eval_cos(wo, at.shading.to_local(light.wi));
                let distance = light.end.map_or(f32::INFINITY, |end| origin.distance(end));
                let through = transmittance(media.absorption, distance);
                radiance += scattered * light.radiance * through * (1.0 / (pmf * light.pdf));
            }
        }

        // Mirrors and glass: the light seen in them. So too where light samples cannot find it.
        let sample = bsdf.sample(wo, sampler.d1(bounce.lobe()), sampler.d2(bounce.direction()));
        if let Some(sample) = sample.filter(|s| s.delta || scene.light_beyond_sampling()) {
            let crossed = sample.is_transmission(wo);
            if crossed {
                met.cross(&mut media);
            }
            let mut ray = at.scattered_ray(&sample, crossed);
            let from = ray.origin;
            let onward = follow(scene, &mut ray, &mut media, rays);
            let seen = match &onward.met {
                Some(met) => SeenEmission::of_surface(scene, &met.at),
                None => SeenEmission::of_sky(scene, ray.direction),
            };
            if let Some(seen) = seen
                && (sample.delta
                    || onward.passed
                    || seen.light_pdf(scene, &self.selection, from, ray.direction) == 0.0)
            {
                radiance += seen.radiance * sample.weight * onward.through;
            }
        }
        radiance * way.through
    }
}
