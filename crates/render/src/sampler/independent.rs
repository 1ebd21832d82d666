//! Every number drawn on its own, by hashing its coordinates.
//!
//! The plainest sampler: its error falls with the square root of the sample
//! count, whatever is integrated. [`Sobol`](super::Sobol) is better nearly
//! everywhere; this one is the yardstick, and what statistical tests assume.

use super::numbers::{GOLDEN, Sampler, Sequence, mix, unit};
use rutilant_geom::Vec2;

/// Independent numbers.
#[derive(Clone, Copy, Debug)]
pub struct Independent {
    key: u64,
}

impl Sampler for Independent {
    fn new(sequence: &Sequence, [x, y]: [u32; 2], sample: u64) -> Self {
        let pixel = mix(sequence.root ^ (u64::from(y) << 32 | u64::from(x)));
        Self { key: mix(pixel ^ sample.wrapping_mul(GOLDEN)) }
    }

    fn d1(&self, dimension: u32) -> f32 {
        unit((self.word(dimension, 1) >> 32) as u32)
    }

    fn d2(&self, dimension: u32) -> Vec2 {
        let word = self.word(dimension, 2);
        Vec2::new(unit((word >> 32) as u32), unit(word as u32))
    }
}

impl Independent {
    fn word(&self, dimension: u32, width: u64) -> u64 {
        mix(self.key ^ (u64::from(dimension) << 2 | width).wrapping_mul(GOLDEN))
    }
}
