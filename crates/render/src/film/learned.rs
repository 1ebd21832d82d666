//! What a pixel learns from its samples, to make those to come less noisy.
//!
//! A sample F comes with a number C whose mean is known to be zero. The variance of F + δ C is
//! least at δ = −Cov(F, C) / Var(C), per channel. Each sample takes the δ that all samples before
//! it suggest: as it had no part in that, it stays unbiased. The number of the sample decides what
//! came before it, and nothing else.
//!
//! Not unbiased where samples of a pixel depend on each other, as Sobol's do: a sample then knows
//! of the δ that it takes. What is measured is up to a fifth of the noise that is left.
//!
//! Source: Owen, *Monte Carlo Theory, Methods and Examples*, 2013, chapter 8, for control variates
//! by regression.

use crate::color::Spectrum;

/// Sums over the samples of one pixel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Learned {
    control: f64,
    control_squared: f64,
    /// Of value and control, per channel.
    products: [f64; 3],
}

impl Learned {
    /// `value` with the noise that `control` tells of taken out. `mean` is that of the pixel so far.
    pub(super) fn corrected(&self, value: Spectrum, control: f32, mean: [f64; 3]) -> Spectrum {
        let (control, mut corrected) = (f64::from(control), value.channels().map(f64::from));
        for ((value, product), mean) in corrected.iter_mut().zip(self.products).zip(mean) {
            let covariance = product - mean * self.control;
            *value -= covariance / (self.control_squared + DOUBT) * control;
        }
        corrected.map(|v| v as f32).into()
    }

    /// Learns from a sample, as it was before it was corrected.
    pub(super) fn add(&mut self, value: Spectrum, control: f32) {
        let control = f64::from(control);
        self.control += control;
        self.control_squared += control * control;
        for (product, v) in self.products.iter_mut().zip(value.channels()) {
            *product += f64::from(v) * control;
        }
    }
}

/// As if one sample had been seen whose control was as large as it usually gets, 1, and told
/// nothing: a few samples with hardly any control suggest a δ that a large one would blow up.
const DOUBT: f64 = 1.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::{Independent, Sampler, Sequence};

    /// Mean and mean square of a thousand corrected samples, less what they should be on average.
    fn corrected(stream: u32, value: impl Fn(f32, f32) -> f32) -> [f64; 2] {
        let (mut learned, mut sum, mut squares) = (Learned::default(), 0.0, 0.0);
        for i in 0..1000 {
            let u = Independent::new(&Sequence::new(9, 1), [stream, 0], i).d2(0);
            let control = 2.0 * u.x - 1.0;
            let value = Spectrum::splat(value(control, u.y));
            let mean = sum / f64::from(i.max(1) as u32);
            let better = f64::from(learned.corrected(value, control, [mean; 3]).channels()[1]);
            learned.add(value, control);
            sum += better;
            squares += better * better;
        }
        [sum, squares].map(|s| s / 1000.0)
    }

    /// Noise that the control tells of goes, all of it in the end, and the mean stays where it is,
    /// with steep and with falling slopes.
    #[test]
    fn noise_that_the_control_tells_of_goes() {
        for slope in [-30.0, 0.5, 4.0_f32] {
            let [mean, squares] = corrected(1, |control, _| 7.0 + slope * control);
            let left = (squares - mean * mean) / (f64::from(slope * slope) / 3.0);
            assert!((mean - 7.0).abs() < 0.01 * f64::from(slope.abs()), "{slope}: {mean}");
            assert!(left < 0.02, "{slope}: {left} of the variance is left");
        }
    }

    /// Noise that it does not tell of stays as it is: learning costs a hundredth. And over many
    /// pixels the mean of few samples is right, which it would not be if a sample had a part in
    /// its own correction.
    #[test]
    fn other_noise_is_left_alone_and_no_mean_shifts() {
        let (mut variance, mut shift, pixels) = (0.0, 0.0, 400);
        for pixel in 0..pixels {
            // Large where the control is large, on either side: bait for a biased slope.
            let [mean, squares] = corrected(pixel, |control, u| u * control * control * 6.0);
            variance += squares - mean * mean;
            shift += mean - 1.0;
        }
        // E v² = 36 / 3 / 5 = 12 / 5, less the squared mean, 1.
        let (expected, pixels) = (1.4_f64, f64::from(pixels));
        let ratio = variance / pixels / expected;
        assert!((0.98..1.02).contains(&ratio), "{ratio}");
        let z = shift / pixels / (expected / (1000.0 * pixels)).sqrt();
        assert!(z.abs() < 3.3, "{z} standard errors");
    }
}
