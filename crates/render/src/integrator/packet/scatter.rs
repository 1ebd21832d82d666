//! Eight paths go on in directions drawn from BSDFs.

use super::met::{MetPacket, Surface};
use crate::bsdf::{BsdfSamples, Lambert, SmoothDielectric};
use crate::integrator::dimension::Bounce;
use crate::lanes::{mask, put};
use crate::sampler::Sampler;
use fearless_simd::Simd;
use fearless_simd::prelude::*;
use rutilant_geom::lanes::{LANES, Xyz8, each_lane};

/// Draws the directions of those that are `alive`.
#[inline(always)]
pub(super) fn scatter<S: Simd, N: Sampler>(
    simd: S,
    samplers: &[N; LANES],
    met: &MetPacket<'_>,
    surface: &Surface<S>,
    alive: u32,
    bounce: Bounce,
) -> BsdfSamples<S> {
    let mut samples = BsdfSamples::none(simd);
    if met.lambert & alive != 0 {
        let u = N::d2_of(simd, samplers, bounce.direction());
        let albedo = Xyz8::load(simd, &met.albedo);
        samples =
            Lambert::samples(albedo, surface.wo_local, u).or(mask(simd, met.lambert), samples);
    }
    if met.dielectric & alive != 0 {
        let choice = N::d1_of(simd, samplers, bounce.lobe());
        let eta = met.eta.simd_into(simd);
        let clear = SmoothDielectric::samples(eta, surface.wo_local, choice);
        samples = clear.or(mask(simd, met.dielectric), samples);
    }
    for lane in each_lane(met.other & alive) {
        let Some(material) = met.materials[lane] else { continue };
        let wo = surface.wo_local.lane(lane);
        let Some(sample) = bounce.scatter(&material.bsdf, wo, &samplers[lane]) else { continue };
        put(&mut samples.wi, lane, sample.wi);
        put(&mut samples.weight, lane, sample.weight.channels().into());
        samples.pdf[lane] = sample.pdf;
        samples.eta[lane] = sample.eta;
        samples.delta.set(lane, sample.delta);
        samples.valid.set(lane, true);
    }
    samples
}
