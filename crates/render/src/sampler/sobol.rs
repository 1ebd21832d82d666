//! Owen-scrambled Sobol points: numbers that leave no gaps, neither in a pixel nor between pixels.
//!
//! Each dimension of a path uses the first one or two dimensions of Sobol's
//! sequence, shuffled and scrambled by a hash of its own, so that any 2^m
//! samples of a pixel are stratified in every elementary interval of every
//! pair, and different dimensions know nothing of each other.
//!
//! All pixels share one sequence: they stand along a curve that fills the
//! screen, and each takes the next run of as many points as samples are
//! planned. Shuffling keeps aligned runs together, so that what a block of
//! pixels takes is a net again: their errors cancel in each other's
//! neighbourhood, and what noise is left is of high frequency, which eyes and
//! denoisers forgive.
//!
//! Source: Burley, "Practical Hash-based Owen Scrambling", JCGT 9(4), 2020;
//! Ahmed and Wonka, "Screen-Space Blue-Noise Diffusion of Monte Carlo Sampling
//! Error via Hierarchical Ordering of Pixels", SIGGRAPH Asia 2020; the hash is
//! that of Vegdahl, "Building a Better LK Hash", 2021; the second dimension by
//! butterflies as in Ahmed, "An Implementation Algorithm of 2D Sobol Sequence
//! Fast, Elegant, and Compact", EGSR 2024.

use super::numbers::{GOLDEN, Sampler, Sequence, mix, one_by_one, pairs_one_by_one, unit, units};
use crate::math::morton;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, u32x8};
use rutilant_geom::Vec2;
use rutilant_geom::lanes::LANES;

/// Stratified numbers.
#[derive(Clone, Copy, Debug)]
pub struct Sobol {
    /// The same for all samples that share a sequence.
    key: u64,
    /// The place in the sequence, its lowest bit first.
    reversed: u32,
}

impl Sampler for Sobol {
    fn new(sequence: &Sequence, [x, y]: [u32; 2], sample: u64) -> Self {
        // Beyond what is planned a new sequence begins: there is no end.
        let run = sequence.planned_log2;
        let (block, within) = (sample >> run, sample & ((1 << run) - 1));
        let place = u128::from(morton(x, y)) << run | u128::from(within);
        // A sequence has 2³² points; large pictures are made of several.
        let part = (place >> 32) as u64;
        let key = mix(sequence.root ^ part);
        let key = mix(key ^ block.wrapping_mul(GOLDEN));
        Self { key, reversed: (place as u32).reverse_bits() }
    }

    fn d1(&self, dimension: u32) -> f32 {
        let word = self.word(dimension, 1);
        let index = permuted(self.reversed, word as u32).reverse_bits();
        unit(permuted(index, (word >> 32) as u32).reverse_bits())
    }

    fn d2(&self, dimension: u32) -> Vec2 {
        let word = self.word(dimension, 2);
        let scramble = mix(word);
        let index = permuted(self.reversed, word as u32).reverse_bits();
        let x = permuted(index, scramble as u32);
        let y = permuted(second_dimension(index), (scramble >> 32) as u32);
        Vec2::new(unit(x.reverse_bits()), unit(y.reverse_bits()))
    }

    #[inline(always)]
    fn d1_of<S: Simd>(simd: S, samplers: &[Self; LANES], dimension: u32) -> f32x8<S> {
        if !of_one_sequence(samplers) {
            return one_by_one(simd, samplers, dimension);
        }
        let word = samplers[0].word(dimension, 1);
        let index = reversed(permuted_lanes(places(simd, samplers), word as u32));
        units(reversed(permuted_lanes(index, (word >> 32) as u32)))
    }

    #[inline(always)]
    fn d2_of<S: Simd>(simd: S, samplers: &[Self; LANES], dimension: u32) -> [f32x8<S>; 2] {
        if !of_one_sequence(samplers) {
            return pairs_one_by_one(simd, samplers, dimension);
        }
        let word = samplers[0].word(dimension, 2);
        let scramble = mix(word);
        let index = reversed(permuted_lanes(places(simd, samplers), word as u32));
        let x = permuted_lanes(index, scramble as u32);
        let y = permuted_lanes(second_dimension_lanes(index), (scramble >> 32) as u32);
        [units(reversed(x)), units(reversed(y))]
    }
}

impl Sobol {
    fn word(&self, dimension: u32, width: u64) -> u64 {
        mix(self.key ^ (u64::from(dimension) << 2 | width).wrapping_mul(GOLDEN))
    }
}

#[inline(always)]
fn of_one_sequence(samplers: &[Sobol; LANES]) -> bool {
    let mut same = true;
    for sampler in samplers {
        same &= sampler.key == samplers[0].key;
    }
    same
}

#[inline(always)]
fn places<S: Simd>(simd: S, samplers: &[Sobol; LANES]) -> u32x8<S> {
    let mut all = [0; LANES];
    for (place, sampler) in all.iter_mut().zip(samplers) {
        *place = sampler.reversed;
    }
    all.simd_into(simd)
}

/// An Owen scramble of a binary fraction that is stored lowest bit first: each bit flips
/// depending on those below it.
fn permuted(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// Sobol's second dimension, lowest bit first: bit j is the parity of all bits i of the index
/// for which the binomial coefficient (i over j) is odd, which by Lucas' theorem are the
/// supersets of j. (The first dimension, lowest bit first, is the index itself.)
fn second_dimension(mut x: u32) -> u32 {
    x ^= (x >> 16) & 0x0000_ffff;
    x ^= (x >> 8) & 0x00ff_00ff;
    x ^= (x >> 4) & 0x0f0f_0f0f;
    x ^= (x >> 2) & 0x3333_3333;
    x ^ (x >> 1) & 0x5555_5555
}

#[inline(always)]
fn permuted_lanes<S: Simd>(mut x: u32x8<S>, seed: u32) -> u32x8<S> {
    x ^= x * 0x3d20_adea;
    x += seed;
    x *= (seed >> 16) | 1;
    x ^= x * 0x0552_6c56;
    x ^ (x * 0x53a2_2864)
}

#[inline(always)]
fn second_dimension_lanes<S: Simd>(mut x: u32x8<S>) -> u32x8<S> {
    x ^= (x >> 16) & 0x0000_ffff;
    x ^= (x >> 8) & 0x00ff_00ff;
    x ^= (x >> 4) & 0x0f0f_0f0f;
    x ^= (x >> 2) & 0x3333_3333;
    x ^ (x >> 1) & 0x5555_5555
}

/// The lowest bit first.
#[inline(always)]
fn reversed<S: Simd>(x: u32x8<S>) -> u32x8<S> {
    let x = (x >> 16) | (x << 16);
    let x = ((x >> 8) & 0x00ff_00ff) | ((x & 0x00ff_00ff) << 8);
    let x = ((x >> 4) & 0x0f0f_0f0f) | ((x & 0x0f0f_0f0f) << 4);
    let x = ((x >> 2) & 0x3333_3333) | ((x & 0x3333_3333) << 2);
    ((x >> 1) & 0x5555_5555) | ((x & 0x5555_5555) << 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every aligned run of 2^m samples has exactly one point in each elementary interval of
    /// area 2^-m: the definition of a (0, m, 2)-net. A wrong matrix or scramble breaks it.
    #[test]
    fn pairs_form_nets_at_every_power_of_two() {
        for m in 0..=10_u32 {
            for run in [0_u64, 5, (1 << (40 - m)) - 1] {
                for dimension in 0..5 {
                    let points: Vec<Vec2> = (0..1_u64 << m)
                        .map(|i| {
                            Sobol::new(&Sequence::new(9, 1 << 20), [11, 12], (run << m) + i)
                                .d2(dimension)
                        })
                        .collect();
                    for a in 0..=m {
                        let mut seen = vec![false; 1 << m];
                        for p in &points {
                            let (x, y) = (
                                (p.x * (1 << a) as f32) as usize,
                                (p.y * (1 << (m - a)) as f32) as usize,
                            );
                            let cell = (y << a) + x;
                            assert!(
                                !std::mem::replace(&mut seen[cell], true),
                                "m {m} run {run} interval {a}"
                            );
                        }
                    }
                }
            }
        }
    }

    /// What a block of pixels takes together is a net again: neighbours share out what there is.
    #[test]
    fn blocks_of_pixels_form_nets() {
        for (planned, [columns, rows]) in [(1_u64, [4_u32, 4]), (4, [2, 2]), (16, [4, 2])] {
            let sequence = Sequence::new(3, planned);
            let all = u64::from(columns * rows) * planned;
            for (left, top, dimension) in [(0, 0, 0), (8, 12, 3), (100 * columns, 64 * rows, 7)] {
                let pixels = (0..rows).flat_map(|y| (0..columns).map(move |x| [left + x, top + y]));
                let samples = pixels.flat_map(|p| (0..planned).map(move |s| (p, s)));
                let points: Vec<Vec2> =
                    samples.map(|(p, s)| Sobol::new(&sequence, p, s).d2(dimension)).collect();
                for a in 0..=all.ilog2() {
                    let (wide, high) = ((1 << a) as f32, (all >> a) as f32);
                    let cell = |p: &Vec2| ((p.x * wide) as u64, (p.y * high) as u64);
                    let cells: std::collections::BTreeSet<_> = points.iter().map(cell).collect();
                    assert_eq!(cells.len() as u64, all, "{planned} at {left}, {top}: {a}");
                }
            }
        }
    }

    /// Eight at a time are those of one at a time, also where two sequences meet.
    #[test]
    fn lanes_have_the_numbers_of_one() {
        let level = fearless_simd::Level::new();
        for planned in [4, 1 << 31] {
            let sequence = Sequence::new(1, planned);
            let samplers = [0, 1, 2, 3, 4, 5, 6, 7].map(|i| Sobol::new(&sequence, [i, 9], 3));
            for dimension in 0..20 {
                let (one, two): ([f32; LANES], [[f32; LANES]; 2]) = fearless_simd::dispatch!(level, simd => {
                    let pair = Sobol::d2_of(simd, &samplers, dimension);
                    (Sobol::d1_of(simd, &samplers, dimension).into(), pair.map(Into::into))
                });
                for (lane, sampler) in samplers.iter().enumerate() {
                    assert_eq!(sampler.d1(dimension), one[lane]);
                    assert_eq!(sampler.d2(dimension), Vec2::new(two[0][lane], two[1][lane]));
                }
            }
        }
    }

    /// Sobol's second dimension by its definition: direction numbers from the recurrence of the
    /// polynomial x + 1 (Sobol 1967), m₁ = 1 and mₖ = 2 mₖ₋₁ ⊕ mₖ₋₁, one for each bit of the
    /// index. The butterflies must give the same points.
    #[test]
    fn the_second_dimension_is_that_of_direction_numbers() {
        let mut directions = [0_u32; 32];
        let mut m = 1_u32;
        for (k, direction) in directions.iter_mut().enumerate() {
            *direction = m << (31 - k);
            m ^= m << 1;
        }
        let defined = |index: u32| {
            let chosen = directions.iter().enumerate().filter(|(k, _)| index >> k & 1 == 1);
            chosen.fold(0, |point, (_, direction)| point ^ direction)
        };
        // The first points by hand: 0, 1/2, 3/4, 1/4.
        assert_eq!([0, 1, 2, 3].map(|i| defined(i) >> 30), [0, 2, 3, 1]);
        for i in (0..5000).chain((0..5000).map(|i| u32::MAX - i * 856_437)) {
            assert_eq!(second_dimension(i).reverse_bits(), defined(i), "{i}");
        }
    }

    /// The same in one dimension.
    #[test]
    fn single_numbers_are_stratified() {
        let mut seen = [false; 256];
        for i in 256..512 {
            let x = Sobol::new(&Sequence::new(1, 512), [0, 0], i).d1(3);
            assert!(!std::mem::replace(&mut seen[(x * 256.0) as usize], true));
        }
    }
}
