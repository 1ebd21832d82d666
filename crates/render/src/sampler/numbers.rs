//! What every sampler gives, and the hashes that they are made of.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, u32x8};
use rutilant_geom::Vec2;
use rutilant_geom::lanes::LANES;

/// What all numbers of a picture have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sequence {
    /// So many samples of a pixel, as a power of two, are planned. With as many, neighbouring
    /// pixels share out what is there between them.
    pub planned_log2: u32,
    /// The seed, mixed well.
    pub(super) root: u64,
}

impl Sequence {
    /// For a picture of `spp` samples per pixel. Another seed gives another, equally good one.
    pub fn new(seed: u64, spp: u64) -> Self {
        let planned_log2 = spp.max(1).next_power_of_two().ilog2().min(Self::MOST_LOG2);
        Self { planned_log2, root: mix(seed.wrapping_add(GOLDEN)) }
    }

    /// More samples than two to this power are not planned as one.
    const MOST_LOG2: u32 = 31;
}

/// The numbers of one sample of one pixel.
pub trait Sampler: Copy + Send + Sync {
    /// The numbers that belong to `sample` of `pixel` (column, row). All 2⁶⁴ samples differ.
    fn new(sequence: &Sequence, pixel: [u32; 2], sample: u64) -> Self;

    /// The number of this dimension, in [0, 1).
    fn d1(&self, dimension: u32) -> f32;

    /// The pair of this dimension, each in [0, 1). Not related to `d1` of the same dimension.
    fn d2(&self, dimension: u32) -> Vec2;

    /// [`d1`](Self::d1) of eight samples.
    #[inline(always)]
    fn d1_of<S: Simd>(simd: S, samplers: &[Self; LANES], dimension: u32) -> f32x8<S> {
        one_by_one(simd, samplers, dimension)
    }

    /// [`d2`](Self::d2) of eight samples.
    #[inline(always)]
    fn d2_of<S: Simd>(simd: S, samplers: &[Self; LANES], dimension: u32) -> [f32x8<S>; 2] {
        pairs_one_by_one(simd, samplers, dimension)
    }
}

#[inline(always)]
pub(super) fn one_by_one<S: Simd, N: Sampler>(
    simd: S,
    samplers: &[N; LANES],
    dimension: u32,
) -> f32x8<S> {
    let mut all = [0.0; LANES];
    for (number, sampler) in all.iter_mut().zip(samplers) {
        *number = sampler.d1(dimension);
    }
    all.simd_into(simd)
}

#[inline(always)]
pub(super) fn pairs_one_by_one<S: Simd, N: Sampler>(
    simd: S,
    samplers: &[N; LANES],
    dimension: u32,
) -> [f32x8<S>; 2] {
    let (mut x, mut y) = ([0.0; LANES], [0.0; LANES]);
    for (lane, sampler) in samplers.iter().enumerate() {
        let pair = sampler.d2(dimension);
        (x[lane], y[lane]) = (pair.x, pair.y);
    }
    [x.simd_into(simd), y.simd_into(simd)]
}

/// 24 bits of a random word as a number in [0, 1): never 1, and zero no more often than others.
pub(super) fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / (1 << 24) as f32)
}

/// The same in each lane.
#[inline(always)]
pub(super) fn units<S: Simd>(bits: u32x8<S>) -> f32x8<S> {
    // What is left fits into a signed number, which is quicker to convert.
    let whole: fearless_simd::i32x8<S> = (bits >> 8).bitcast();
    let number: f32x8<S> = whole.to_float();
    number * (1.0 / (1 << 24) as f32)
}

/// A bijection of 64-bit words in which every input bit changes every output bit half the time.
///
/// Source: Steele, Lea, Flood, "Fast Splittable Pseudorandom Number Generators", OOPSLA 2014,
/// with the constants of Stafford's thirteenth variant.
pub(crate) fn mix(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// The golden ratio's fractional part: distinct multiples of it lie far apart.
pub(crate) const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;
