//! Lambertian reflection whose directions are drawn evenly, whatever their cosine.
//!
//! It looks as [`Lambert`](super::Lambert) does. A sample weighs `2 albedo cos θ`: under an even
//! sky of radiance L a single one varies by `albedo² L² / 3`, where cosine sampling does not vary
//! at all. It is there to show that, and for comparison.
//!
//! Not for pictures: they take more samples for the same noise.
//!
//! Source: Pharr, Jakob, Humphreys, *Physically Based Rendering*, 4th ed.,
//! sections 2.3 and 9.2.

use super::sample::BsdfSample;
use crate::color::Spectrum;
use crate::math::warp;
use rutilant_geom::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

/// A matte surface, sampled evenly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UniformLambert {
    /// The part of the light sent back, 0 to 1.
    pub albedo: Spectrum,
}

impl UniformLambert {
    /// BSDF value times cosine, `f(wo, wi) |cos θi|`, in 1/sr.
    pub fn eval_cos(&self, wo: Vec3, wi: Vec3) -> Spectrum {
        if wo.z * wi.z > 0.0 { self.albedo * (FRAC_1_PI * wi.z.abs()) } else { Spectrum::BLACK }
    }

    /// The density of [`sample`](Self::sample), in 1/sr.
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        if wo.z * wi.z > 0.0 { warp::UNIFORM_HEMISPHERE_PDF } else { 0.0 }
    }

    /// Draws the direction the light came from, given `wo`, where it leaves to.
    ///
    /// `u` holds two numbers in [0, 1). Returns `None` for a direction in the surface itself,
    /// which scatters nothing.
    pub fn sample(&self, wo: Vec3, u: Vec2) -> Option<BsdfSample> {
        let up = warp::uniform_hemisphere(u);
        let wi = if wo.z < 0.0 { -up } else { up };
        (wi.z != 0.0 && wo.z != 0.0).then(|| BsdfSample {
            wi,
            weight: self.albedo * (2.0 * wi.z.abs()),
            pdf: warp::UNIFORM_HEMISPHERE_PDF,
            delta: false,
            eta: 1.0,
        })
    }
}
