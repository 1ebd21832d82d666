//! Whether two noisy pictures are estimates of the same one.
//!
//! Every pixel and channel gives a z-score: the difference of the two means
//! over its standard error, from the variance that each rendering measured.
//! The largest of many scores is held against the level at which chance alone
//! would exceed it in one family of tests out of a hundred (Šidák 1967). No
//! tolerance needs to be chosen, and more samples make the test stricter.
//!
//! Source: Subr and Arvo, "Statistical Hypothesis Testing for Assessing Monte
//! Carlo Estimators", PG 2007; Jung, Hanika, Dachsbacher, "Detecting Bias in
//! Monte Carlo Renderers using Welch's t-test", JCGT 9(2), 2020.

use rutilant::image::Image;

/// The most that two pictures disagree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disagreement {
    /// Column and row of the pixel.
    pub pixel: [u32; 2],
    /// `R`, `G` or `B`.
    pub channel: &'static str,
    /// The two means there.
    pub means: [f32; 2],
    /// Their difference in standard errors.
    pub z: f64,
}

/// The largest z-score between two pictures of the same size, over all pixels and colour channels.
/// `None` where a channel or its variance is missing.
pub fn largest_disagreement(a: &Image, b: &Image) -> Option<Disagreement> {
    let mut largest: Option<Disagreement> = None;
    for channel in ["R", "G", "B"] {
        let variance = format!("variance.{channel}");
        let means = a.channel(channel)?.iter().zip(b.channel(channel)?);
        let variances = a.channel(&variance)?.iter().zip(b.channel(&variance)?);
        for (i, ((&a_mean, &b_mean), (&a_var, &b_var))) in means.zip(variances).enumerate() {
            let difference = f64::from(a_mean) - f64::from(b_mean);
            // Two pictures without noise may still differ in the last bits of their sums.
            let rounding = 1e-6 * f64::from(a_mean.abs().max(b_mean.abs()));
            let error = (f64::from(a_var) + f64::from(b_var) + rounding * rounding).sqrt();
            let z = if difference == 0.0 { 0.0 } else { difference.abs() / error };
            if largest.is_none_or(|l| z > l.z) {
                let pixel = [i as u32 % a.width(), i as u32 / a.width()];
                largest = Some(Disagreement { pixel, channel, means: [a_mean, b_mean], z });
            }
        }
    }
    largest
}

/// The z-score that chance alone exceeds in a family of `tests` independent scores with a
/// probability of `false_alarms`.
pub fn critical_z(tests: usize, false_alarms: f64) -> f64 {
    let level = -libm::expm1(libm::log1p(-false_alarms) / tests as f64);
    // The two-sided tail falls steadily: halve the interval.
    let (mut low, mut high) = (0.0, 40.0);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if libm::erfc(middle * std::f64::consts::FRAC_1_SQRT_2) > level {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One score: 2.576 at 1 %, as in every table. A thousand: 4.42.
    #[test]
    fn critical_scores_are_those_of_the_tables() {
        assert!((critical_z(1, 0.01) - 2.5758).abs() < 1e-4);
        assert!((critical_z(1000, 0.01) - 4.4164).abs() < 1e-3);
    }
}
