//! What every sampler gives, and the hashes that they are made of.

use rutilant_geom::Vec2;

/// The numbers of one sample of one pixel.
pub trait Sampler: Copy {
    /// The numbers that belong to `sample` of `pixel` (column, row). All 2⁶⁴ samples differ.
    fn new(seed: u64, pixel: [u32; 2], sample: u64) -> Self;

    /// The number of this dimension, in [0, 1).
    fn d1(&self, dimension: u32) -> f32;

    /// The pair of this dimension, each in [0, 1). Not related to `d1` of the same dimension.
    fn d2(&self, dimension: u32) -> Vec2;
}

/// 24 bits of a random word as a number in [0, 1): never 1, and zero no more often than others.
pub(super) fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / (1 << 24) as f32)
}

/// A bijection of 64-bit words in which every input bit changes every output bit half the time.
///
/// Source: Steele, Lea, Flood, "Fast Splittable Pseudorandom Number Generators", OOPSLA 2014,
/// with the constants of Stafford's thirteenth variant.
pub(super) fn mix(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// The golden ratio's fractional part: distinct multiples of it lie far apart.
pub(super) const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// A word for each seed and pixel.
pub(super) fn pixel_key(seed: u64, [x, y]: [u32; 2]) -> u64 {
    mix(mix(seed.wrapping_add(GOLDEN)) ^ (u64::from(y) << 32 | u64::from(x)))
}
