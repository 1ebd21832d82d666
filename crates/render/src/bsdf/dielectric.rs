//! A smooth border between two clear media: glass, water.
//!
//! Light is reflected with the probability that the Fresnel equations give and
//! refracted by Snell's law otherwise, so that every sample weighs the same.
//! Radiance that enters a denser medium is squeezed into a smaller cone and
//! grows by the square of the index; it loses as much when it leaves.
//!
//! Source: Pharr, Jakob, Humphreys, *Physically Based Rendering*, 4th ed.,
//! sections 9.3 and 9.5; Veach 1997, section 5.2.

use super::fresnel::Fresnel;
use super::mirror::reflection;
use super::sample::{BsdfSample, BsdfSamples};
use crate::color::Spectrum;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, mask32x8};
use rutilant_geom::Vec3;
use rutilant_geom::lanes::{Xyz, Xyz8};

/// A smooth border. The interior is below: where z is negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothDielectric {
    /// Index of refraction below over that above.
    pub eta: f32,
    /// How the reflected part is computed.
    pub fresnel: Fresnel,
}

impl SmoothDielectric {
    /// Draws reflection or refraction; `choice` in [0, 1) decides. `None` for a direction in the
    /// surface itself.
    pub fn sample(&self, wo: Vec3, choice: f32) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        // Equal indices: there is no border, to the last bit.
        if self.eta == 1.0 {
            let weight = Spectrum::WHITE;
            return Some(BsdfSample { wi: -wo, weight, pdf: 1.0, delta: true, eta: 1.0 });
        }
        let eta = if wo.z > 0.0 { self.eta } else { 1.0 / self.eta };
        let (reflected, cos_t) = self.fresnel.dielectric(wo.z.abs(), eta);
        if choice < reflected {
            return Some(BsdfSample { pdf: reflected, ..reflection(wo, Spectrum::WHITE)? });
        }
        let along = -1.0 / eta;
        let wi = Vec3::new(wo.x * along, wo.y * along, -cos_t.copysign(wo.z)).normalize();
        let weight = Spectrum::splat(1.0 / (eta * eta));
        (wi.z != 0.0).then_some(BsdfSample { wi, weight, pdf: 1.0 - reflected, delta: true, eta })
    }

    /// [`sample`](Self::sample) for eight surfaces of relative indices `eta`, with exact Fresnel
    /// equations.
    #[inline(always)]
    pub(crate) fn samples<S: Simd>(eta: f32x8<S>, wo: Xyz8<S>, choice: f32x8<S>) -> BsdfSamples<S> {
        let simd = wo.z.token();
        let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
        let white = Xyz8::splat(simd, [1.0; 3]);
        let straight = eta.simd_eq(one);
        let eta = wo.z.simd_gt(zero).select(eta, one / eta);
        let (reflected, cos_t) = Fresnel::dielectrics(wo.z.abs(), eta);
        let mirrored = choice.simd_lt(reflected);
        let along = -one / eta;
        let refracted =
            Xyz { x: wo.x * along, y: wo.y * along, z: -cos_t.copysign(wo.z) }.normalized();
        let back = Xyz { x: -wo.x, y: -wo.y, z: wo.z };
        let part = one / (eta * eta);
        let delta = mask32x8::splat(simd, true);
        let through = BsdfSamples {
            wi: refracted,
            weight: Xyz { x: part, y: part, z: part },
            pdf: one - reflected,
            eta,
            delta,
            valid: refracted.z.simd_ne(zero) & wo.z.simd_ne(zero),
        };
        let seen = wo.z.simd_ne(zero);
        let reflection =
            BsdfSamples { wi: back, weight: white, pdf: reflected, eta: one, delta, valid: seen };
        let on =
            BsdfSamples { wi: wo.negated(), weight: white, pdf: one, eta: one, delta, valid: seen };
        on.or(straight, reflection.or(mirrored, through))
    }
}
