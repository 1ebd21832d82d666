//! Pictures that explain a scene: normals, albedo, depth, ambient occlusion.

use super::dimension::Bounce;
use super::estimate::Integrator;
use crate::color::Spectrum;
use crate::math::warp;
use crate::prepare::Prepared;
use crate::sampler::Sampler;
use rutilant_geom::{Frame, Ray};

/// Shading normals on the front, from −1..1 to 0..1; black where nothing is.
pub(crate) struct Normals;

impl Integrator for Normals {
    fn radiance<S: Sampler>(&self, scene: &Prepared, ray: Ray, _: &S, rays: &mut u64) -> Spectrum {
        *rays += 1;
        scene.closest(&ray).map_or(Spectrum::BLACK, |hit| {
            let normal = scene.interaction(&hit, ray.direction).shading.z;
            (normal * 0.5 + 0.5).to_array().into()
        })
    }
}

/// The part of white light that surfaces send back; black where nothing is.
pub(crate) struct Albedo;

impl Integrator for Albedo {
    fn radiance<S: Sampler>(&self, scene: &Prepared, ray: Ray, _: &S, rays: &mut u64) -> Spectrum {
        *rays += 1;
        scene.closest(&ray).map_or(Spectrum::BLACK, |hit| {
            let at = scene.interaction(&hit, ray.direction);
            let material = scene.material(&at);
            scene.varied_at(&hit, &at, material).as_ref().unwrap_or(material).bsdf.albedo()
        })
    }
}

/// Distance along the ray in metres; 0 where nothing is.
pub(crate) struct Depth;

impl Integrator for Depth {
    fn radiance<S: Sampler>(&self, scene: &Prepared, ray: Ray, _: &S, rays: &mut u64) -> Spectrum {
        *rays += 1;
        scene.closest(&ray).map_or(Spectrum::BLACK, |hit| Spectrum::splat(hit.t))
    }
}

/// The part of the sky that a surface sees, weighted by the cosine; white where nothing is.
pub(crate) struct AmbientOcclusion;

impl Integrator for AmbientOcclusion {
    fn radiance<S: Sampler>(
        &self,
        scene: &Prepared,
        ray: Ray,
        sampler: &S,
        rays: &mut u64,
    ) -> Spectrum {
        *rays += 1;
        let Some(hit) = scene.closest(&ray) else { return Spectrum::WHITE };
        let at = scene.interaction(&hit, ray.direction);
        let side = if at.wo_local().z < 0.0 { -at.shading.z } else { at.shading.z };
        let up = warp::cosine_hemisphere(sampler.d2(Bounce::at(1).direction()));
        *rays += 1;
        let way = Ray::new(at.reflected_origin(), Frame::around(side).to_world(up));
        if scene.occluded(&way) { Spectrum::BLACK } else { Spectrum::WHITE }
    }
}
