//! Where random numbers come from.
//!
//! A sample's numbers are a function of (pixel, sample, dimension, seed) and
//! of nothing else: not of threads, of passes, or of which numbers were asked
//! for before. A dimension names one decision along a path; it stands for one
//! number or for a pair.

mod independent;
mod numbers;
mod sobol;

pub use independent::Independent;
pub(crate) use numbers::{GOLDEN, mix};
pub use numbers::{Sampler, Sequence};
pub use sobol::Sobol;

#[cfg(test)]
mod tests {
    use super::numbers::unit;
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
            let base = S::new(&Sequence::new(1, 16), [2, 3], 4);
            let others = [
                S::new(&Sequence::new(0, 16), [2, 3], 4),
                S::new(&Sequence::new(1, 16), [3, 2], 4),
                S::new(&Sequence::new(1, 16), [2, 3], 5),
                S::new(&Sequence::new(1, 16), [2, 3], 4 + (1 << 32)),
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
