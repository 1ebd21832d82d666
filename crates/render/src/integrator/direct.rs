//! Emission and direct light: one light sampled at the first surface.
//!
//! Written apart from [`Path`](super::Path), which gives the same picture at a depth of 2: light
//! samples alone on rough surfaces, scattered rays alone on mirrors and glass.

use super::dimension::Bounce;
use super::emission::SeenEmission;
use super::estimate::Integrator;
use super::passing::light_passed;
use super::path::transmittance;
use crate::color::Spectrum;
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
        mut ray: Ray,
        sampler: &S,
        rays: &mut u64,
    ) -> Spectrum {
        *rays += 1;
        let here = scene.camera_absorption();
        let passed = light_passed(scene, &mut ray, |glow, distance| {
            glow.radiance * transmittance(here, distance)
        });
        let Some(hit) = scene.closest(&ray) else {
            let through = transmittance(here, f32::INFINITY);
            return SeenEmission::of_sky(scene, ray.direction)
                .map_or(passed, |s| passed + s.radiance * through);
        };
        let at = scene.interaction(&hit, ray.direction);
        let bsdf = &scene.material(&at).bsdf;
        let wo = at.wo_local();
        let bounce = Bounce::at(1);

        // The ray's way to here, through whatever fills the side it came from.
        let border = scene.material(&at).border;
        let side = |front| border.map_or(here, |b| b.absorption(front));
        let way = transmittance(side(wo.z > 0.0), hit.t);
        let mut radiance =
            SeenEmission::of_surface(scene, &at).map_or(Spectrum::BLACK, |e| e.radiance);

        // Rough lobes: one light, anywhere on it, and for clear surfaces on either side.
        let translucent = bsdf.is_translucent();
        let from = if translucent { at.position } else { at.reflected_origin() };
        if let Some((emitter, pmf)) = self.selection.select(from, sampler.d1(bounce.light()))
            && !bsdf.is_delta()
            && let Some(light) =
                scene.emitters()[emitter].sample(from, sampler.d2(bounce.light_point()))
        {
            let wi = at.shading.to_local(light.wi);
            let beyond = wo.z * wi.z < 0.0;
            let origin = if translucent { at.surface_origin(beyond) } else { from };
            *rays += 1;
            if !scene.occluded(&light.shadow_ray(origin)) {
                let scattered = bsdf.eval_cos(wo, wi);
                let distance = light.end.map_or(f32::INFINITY, |end| origin.distance(end));
                let through = transmittance(side((wo.z > 0.0) != beyond), distance);
                radiance += scattered * light.radiance * through * (1.0 / (pmf * light.pdf));
            }
        }

        // Mirrors and glass: the light seen in them.
        let sample = bsdf.sample(wo, sampler.d1(bounce.lobe()), sampler.d2(bounce.direction()));
        if let Some(sample) = sample.filter(|s| s.delta) {
            let crossed = sample.is_transmission(wo);
            let mut ray = at.scattered_ray(bsdf, &sample, crossed);
            let medium = side((wo.z > 0.0) != crossed);
            *rays += 1;
            let passed = light_passed(scene, &mut ray, |glow, distance| {
                glow.radiance * transmittance(medium, distance)
            });
            radiance += passed * sample.weight;
            let (seen, distance) = match scene.closest(&ray) {
                Some(hit) => (
                    SeenEmission::of_surface(scene, &scene.interaction(&hit, ray.direction)),
                    hit.t,
                ),
                None => (SeenEmission::of_sky(scene, ray.direction), f32::INFINITY),
            };
            radiance += seen.map_or(Spectrum::BLACK, |s| {
                s.radiance * sample.weight * transmittance(medium, distance)
            });
        }
        passed + way * radiance
    }
}
