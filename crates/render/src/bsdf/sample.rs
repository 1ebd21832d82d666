//! What every BSDF draws.

use crate::color::Spectrum;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, mask32x8};
use rutilant_geom::Vec3;
use rutilant_geom::lanes::Xyz8;

/// A direction that light may have come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// The direction, a unit vector in the shading frame.
    pub wi: Vec3,
    /// `f(wo, wi) |cos θi| / pdf`: what the light from `wi` is worth.
    pub weight: Spectrum,
    /// The density of `wi` in 1/sr; for a delta, the probability of having chosen it.
    pub pdf: f32,
    /// True when no other method could have found this direction.
    pub delta: bool,
    /// Index of refraction on the side of `wi` over that on the side of `wo`; 1 for reflection.
    pub eta: f32,
}

impl BsdfSample {
    /// True when the light crossed the surface.
    pub fn is_transmission(&self, wo: Vec3) -> bool {
        self.wi.z * wo.z < 0.0
    }
}

/// Eight of [`BsdfSample`](BsdfSample); directions are in the shading frame.
#[derive(Clone, Copy)]
pub(crate) struct BsdfSamples<S: Simd> {
    pub(crate) wi: Xyz8<S>,
    pub(crate) weight: Xyz8<S>,
    pub(crate) pdf: f32x8<S>,
    pub(crate) eta: f32x8<S>,
    pub(crate) delta: mask32x8<S>,
    /// False where nothing is scattered.
    pub(crate) valid: mask32x8<S>,
}

impl<S: Simd> BsdfSamples<S> {
    /// Nothing is scattered.
    #[inline(always)]
    pub(crate) fn none(simd: S) -> Self {
        let one = f32x8::splat(simd, 1.0);
        Self {
            wi: Xyz8::splat(simd, [0.0, 0.0, 1.0]),
            weight: Xyz8::splat(simd, [0.0; 3]),
            pdf: one,
            eta: one,
            delta: mask32x8::splat(simd, false),
            valid: mask32x8::splat(simd, false),
        }
    }

    /// `self` where the mask is true.
    #[inline(always)]
    pub(crate) fn or(self, mask: mask32x8<S>, other: Self) -> Self {
        Self {
            wi: self.wi.or(mask, other.wi),
            weight: self.weight.or(mask, other.weight),
            pdf: mask.select(self.pdf, other.pdf),
            eta: mask.select(self.eta, other.eta),
            delta: mask.select(self.delta, other.delta),
            valid: mask.select(self.valid, other.valid),
        }
    }
}
