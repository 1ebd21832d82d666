//! What is done for eight paths at once, beside geometry.

use crate::color::Spectrum;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, mask32x8};
use rutilant_geom::lanes::Xyz8;
use rutilant_geom::{Vec3, each, real};

/// A set as a mask.
#[inline(always)]
pub(crate) fn mask<S: Simd>(simd: S, bits: u32) -> mask32x8<S> {
    mask32x8::from_bitmask(simd, u64::from(bits))
}

/// A mask as a set.
#[inline(always)]
pub(crate) fn bits<S: Simd>(mask: mask32x8<S>) -> u32 {
    mask.to_bitmask() as u32
}

/// Writes one lane.
#[inline(always)]
pub(crate) fn put<S: Simd>(v: &mut Xyz8<S>, lane: usize, new: Vec3) {
    v.x[lane] = new.x;
    v.y[lane] = new.y;
    v.z[lane] = new.z;
}

/// The part of light that is left after each distance in metres: exp(−σ d), Beer's law, as in
/// [`transmittance`](crate::follow::transmittance).
#[inline(always)]
pub(crate) fn transmittances<S: Simd>(absorption: Xyz8<S>, distance: f32x8<S>) -> Xyz8<S> {
    let simd = distance.token();
    if absorption.is_zero().all_true() {
        return Xyz8::splat(simd, Spectrum::WHITE.channels());
    }
    each!(absorption, sigma => {
        let some = sigma.simd_gt(f32x8::splat(simd, 0.0));
        some.select(real::exp_lanes(-sigma * distance), f32x8::splat(simd, 1.0))
    })
}
