//! Where random numbers come from.
//!
//! A sample's numbers are a function of (pixel, sample, dimension, seed) and
//! of nothing else: not of threads, of passes, or of which numbers were asked
//! for before. A dimension names one decision along a path; it stands for one
//! number or for a pair.

mod independent;
mod sobol;

pub use independent::Independent;
pub use sobol::Sobol;

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
fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / (1 << 24) as f32)
}

/// A bijection of 64-bit words in which every input bit changes every output bit half the time.
///
/// Source: Steele, Lea, Flood, "Fast Splittable Pseudorandom Number Generators", OOPSLA 2014,
/// with the constants of Stafford's thirteenth variant.
fn mix(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// The golden ratio's fractional part: distinct multiples of it lie far apart.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// A word for each seed and pixel.
fn pixel_key(seed: u64, [x, y]: [u32; 2]) -> u64 {
    mix(mix(seed.wrapping_add(GOLDEN)) ^ (u64::from(y) << 32 | u64::from(x)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 24 bits or more of resolution at both ends of [0, 1), and never 1 itself: a sample of
    /// exactly 1 gave a cosine of 0 and 0/0 in the old program.
    #[test]
    fn numbers_stay_below_one() {
        assert_eq!(unit(0), 0.0);
        assert_eq!(unit(u32::MAX), 1.0 - 0.5 * f32::EPSILON);
    }

    /// Neighbouring pixels, samples, dimensions and seeds give unrelated numbers.
    #[test]
    fn every_coordinate_matters() {
        fn all_different<S: Sampler>() {
            let base = S::new(1, [2, 3], 4);
            let others = [
                S::new(0, [2, 3], 4),
                S::new(1, [3, 2], 4),
                S::new(1, [2, 3], 5),
                S::new(1, [2, 3], 4 + (1 << 32)),
            ];
            for other in others {
                assert_ne!(base.d1(7), other.d1(7));
                assert_ne!(base.d2(7), other.d2(7));
            }
            assert_ne!(base.d1(7), base.d1(8));
            assert_ne!(base.d2(7), base.d2(8));
            assert_ne!(base.d1(7), base.d2(7).x);
        }
        all_different::<Independent>();
        all_different::<Sobol>();
    }
}
