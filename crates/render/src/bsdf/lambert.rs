//! Lambertian reflection: a surface that looks equally bright from everywhere.
//!
//! Its value is `albedo / π` on the side the light came from, zero on the other.
//! Directions are drawn in proportion to the cosine; every sample then weighs
//! exactly `albedo`, and no choice of `wi` is wasted.
//!
//! Source: Lambert, *Photometria*, 1760; Pharr, Jakob, Humphreys, *Physically
//! Based Rendering*, 4th ed., section 9.2.

use super::sample::{BsdfSample, BsdfSamples};
use crate::color::Spectrum;
use crate::math::warp;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, mask32x8};
use rutilant_geom::lanes::Xyz8;
use rutilant_geom::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

/// A matte surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lambert {
    /// The part of the light sent back, 0 to 1.
    pub albedo: Spectrum,
}

impl Lambert {
    /// BSDF value times cosine, `f(wo, wi) |cos θi|`, in 1/sr.
    pub fn eval_cos(&self, wo: Vec3, wi: Vec3) -> Spectrum {
        if wo.z * wi.z > 0.0 { self.albedo * (FRAC_1_PI * wi.z.abs()) } else { Spectrum::BLACK }
    }

    /// The density of [`sample`](Self::sample), in 1/sr.
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        if wo.z * wi.z > 0.0 { warp::cosine_hemisphere_pdf(wi.z.abs()) } else { 0.0 }
    }

    /// Draws the direction the light came from, given `wo`, where it leaves to.
    ///
    /// `u` holds two numbers in [0, 1). Returns `None` for a direction in the surface itself,
    /// which scatters nothing.
    pub fn sample(&self, wo: Vec3, u: Vec2) -> Option<BsdfSample> {
        let up = warp::cosine_hemisphere(u);
        let wi = if wo.z < 0.0 { -up } else { up };
        (wi.z != 0.0 && wo.z != 0.0).then(|| BsdfSample {
            wi,
            weight: self.albedo,
            pdf: self.pdf(wo, wi),
            delta: false,
            eta: 1.0,
        })
    }

    /// [`sample`](Self::sample) for eight surfaces.
    #[inline(always)]
    pub(crate) fn samples<S: Simd>(
        albedo: Xyz8<S>,
        wo: Xyz8<S>,
        u: [f32x8<S>; 2],
    ) -> BsdfSamples<S> {
        let simd = wo.z.token();
        let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
        let up = warp::cosine_hemispheres(u);
        let wi = up.negated().or(wo.z.simd_lt(zero), up);
        let same_side = (wo.z * wi.z).simd_gt(zero);
        BsdfSamples {
            wi,
            weight: albedo,
            pdf: same_side.select(wi.z.abs() * FRAC_1_PI, zero),
            eta: one,
            delta: mask32x8::splat(simd, false),
            valid: wi.z.simd_ne(zero) & wo.z.simd_ne(zero),
        }
    }
}
