//! Owen-scrambled Sobol points: numbers that leave no gaps.
//!
//! Each dimension of a path uses the first one or two dimensions of Sobol's
//! sequence, shuffled and scrambled by a hash of its own, so that any 2^m
//! samples of a pixel are stratified in every elementary interval of every
//! pair, and different dimensions know nothing of each other. After 2³²
//! samples the scrambling changes and a new sequence begins: there is no end.
//!
//! Source: Burley, "Practical Hash-based Owen Scrambling", JCGT 9(4), 2020;
//! the hash is that of Vegdahl, "Building a Better LK Hash", 2021; the second
//! dimension by butterflies as in Ahmed, "An Implementation Algorithm of 2D
//! Sobol Sequence Fast, Elegant, and Compact", EGSR 2024.

use super::numbers::{GOLDEN, Sampler, mix, pixel_key, unit};
use rutilant_geom::Vec2;

/// Stratified numbers.
#[derive(Clone, Copy, Debug)]
pub struct Sobol {
    key: u64,
    /// The sample's number, its lowest bit first.
    reversed: u32,
}

impl Sampler for Sobol {
    fn new(seed: u64, pixel: [u32; 2], sample: u64) -> Self {
        let block = (sample >> 32).wrapping_mul(GOLDEN);
        Self { key: mix(pixel_key(seed, pixel) ^ block), reversed: (sample as u32).reverse_bits() }
    }

    fn d1(&self, dimension: u32) -> f32 {
        let word = self.word(dimension, 1);
        let index = self.shuffled(word as u32);
        unit(permuted(index, (word >> 32) as u32).reverse_bits())
    }

    fn d2(&self, dimension: u32) -> Vec2 {
        let word = self.word(dimension, 2);
        let scramble = mix(word);
        let index = self.shuffled(word as u32);
        let x = permuted(index, scramble as u32);
        let y = permuted(second_dimension(index), (scramble >> 32) as u32);
        Vec2::new(unit(x.reverse_bits()), unit(y.reverse_bits()))
    }
}

impl Sobol {
    fn word(&self, dimension: u32, width: u64) -> u64 {
        mix(self.key ^ (u64::from(dimension) << 2 | width).wrapping_mul(GOLDEN))
    }

    /// The sample's number where the sequence is reordered so that every aligned run of 2^m
    /// samples stays one.
    fn shuffled(&self, seed: u32) -> u32 {
        permuted(self.reversed, seed).reverse_bits()
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Every aligned run of 2^m samples has exactly one point in each elementary interval of
    /// area 2^-m: the definition of a (0, m, 2)-net. A wrong matrix or scramble breaks it.
    #[test]
    fn pairs_form_nets_at_every_power_of_two() {
        for m in 0..=10_u32 {
            for run in [0_u64, 5, (1 << (32 - m)) - 1] {
                for dimension in 0..5 {
                    let points: Vec<Vec2> = (0..1_u64 << m)
                        .map(|i| Sobol::new(9, [11, 12], (run << m) + i).d2(dimension))
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
            let x = Sobol::new(1, [0, 0], i).d1(3);
            assert!(!std::mem::replace(&mut seen[(x * 256.0) as usize], true));
        }
    }
}
