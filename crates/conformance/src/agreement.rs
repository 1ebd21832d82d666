//! Whether two noisy pictures are estimates of the same one.
//!
//! Every pixel and channel gives a z-score: the difference of the two means
//! over its standard error, from the variance that each rendering measured.
//! Three questions are asked of these scores. Is the largest larger than chance
//! makes the largest of so many (a wrong place)? Is the difference of the whole
//! pictures' means larger than its standard error allows (a small bias
//! everywhere, which no single pixel shows)? Are all scores together as wide as
//! normal ones, the mean of z² being 1 (wrong variances, or many small biases of
//! both signs)? No tolerance needs to be chosen, and more samples make all
//! three stricter.
//!
//! Not for pictures of few samples, or where rare bright samples carry the
//! mean: there scores are not normal.
//!
//! Source: Subr and Arvo, "Statistical Hypothesis Testing for Assessing Monte
//! Carlo Estimators", PG 2007; Jung, Hanika, Dachsbacher, "Detecting Bias in
//! Monte Carlo Renderers using Welch's t-test", JCGT 9(2), 2020; Šidák,
//! "Rectangular Confidence Regions for the Means of Multivariate Normal
//! Distributions", JASA 62, 1967; Wilson and Hilferty, "The Distribution of
//! Chi-Square", PNAS 17, 1931.

use rutilant::image::Image;

/// The pixel in which two pictures disagree most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disagreement {
    /// Column and row of the pixel.
    pub pixel: [u32; 2],
    /// `R`, `G` or `B`.
    pub channel: &'static str,
    /// The two means there.
    pub means: [f64; 2],
    /// Their difference in standard errors.
    pub z: f64,
}

/// How two pictures differ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Where they differ most.
    pub worst: Disagreement,
    /// Mean of the first picture over that of the second, over all pixels and channels.
    pub mean_ratio: f64,
    /// The difference of the two pictures' means in standard errors: the channel where it is largest.
    pub mean_z: f64,
    /// The mean of z² over all pixels that are noisy: the channel where it is farthest from 1.
    pub spread: f64,
    /// Mean of (a − b)² / (b² + 0.01), noise of both included.
    pub relative_mse: f64,
    /// The probability that chance alone makes two estimates of the same picture differ as much.
    pub p: f64,
}

/// What the variance channels of a picture hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variance {
    /// The variance of each pixel's mean.
    Measured,
    /// As much or more: samples are better spread than independent ones.
    UpperBound,
}

/// Compares two pictures of the same size, made with different seeds. `variance` is
/// [`Variance::Measured`] only if it is for both. `None` where a channel or its variance is missing.
pub fn compare(a: &Image, b: &Image, variance: Variance) -> Option<Comparison> {
    let mut worst: Option<Disagreement> = None;
    let (mut mean_z, mut spread, mut spread_z) = (0.0_f64, 1.0, 0.0_f64);
    let (mut sums, mut squares, mut scores) = ([0.0; 2], 0.0, 0);
    for channel in ["R", "G", "B"] {
        let name = format!("variance.{channel}");
        let (a_means, b_means) = (a.channel(channel)?, b.channel(channel)?);
        let (a_variances, b_variances) = (a.channel(&name)?, b.channel(&name)?);
        let (mut difference_sum, mut variance_sum) = (0.0, 0.0);
        let (mut z_squared_sum, mut noisy) = (0.0, 0.0);
        for i in 0..a_means.len() {
            let means = [a_means[i], b_means[i]].map(f64::from);
            let difference = means[0] - means[1];
            // Two pictures without noise may still differ in the last bits of their sums.
            let rounding = 1e-6 * means[0].abs().max(means[1].abs());
            let noise = f64::from(a_variances[i]) + f64::from(b_variances[i]);
            let error = (noise + rounding * rounding).sqrt();
            let z = if difference == 0.0 { 0.0 } else { difference.abs() / error };
            if worst.is_none_or(|w| z > w.z) {
                let pixel = [i as u32 % a.width(), i as u32 / a.width()];
                worst = Some(Disagreement { pixel, channel, means, z });
            }
            if noise > rounding * rounding {
                z_squared_sum += z * z;
                noisy += 1.0;
            }
            difference_sum += difference;
            variance_sum += error * error;
            sums = [sums[0] + means[0], sums[1] + means[1]];
            squares += difference * difference / (means[1] * means[1] + 0.01);
        }
        scores += a_means.len();
        if difference_sum != 0.0 {
            mean_z = mean_z.max(difference_sum.abs() / variance_sum.sqrt());
        }
        if noisy > 0.0 {
            let wide = chi_square_z(noisy, z_squared_sum);
            let counts = match variance {
                Variance::Measured => wide.abs(),
                Variance::UpperBound => wide.max(0.0),
            };
            if counts >= spread_z {
                (spread, spread_z) = (z_squared_sum / noisy, counts);
            }
        }
    }
    let worst = worst?;
    let questions = [
        any_of(two_sided(worst.z), scores),
        any_of(two_sided(mean_z), 3),
        any_of(two_sided(spread_z), 3),
    ];
    let least = questions.into_iter().fold(1.0, f64::min);
    Some(Comparison {
        worst,
        mean_ratio: if sums == [0.0; 2] { 1.0 } else { sums[0] / sums[1] },
        mean_z,
        spread,
        relative_mse: squares / scores as f64,
        p: any_of(least, questions.len()),
    })
}

/// The probability that the least of `tests` independent probabilities is at most `p` by chance.
pub fn any_of(p: f64, tests: usize) -> f64 {
    -f64::exp_m1(tests as f64 * f64::ln_1p(-p))
}

/// The probability of a normal score at least this far from zero.
fn two_sided(z: f64) -> f64 {
    libm::erfc(z * std::f64::consts::FRAC_1_SQRT_2)
}

/// The normal score that is as rare as this sum of `n` squared normal scores: Wilson and
/// Hilferty's cube root.
fn chi_square_z(n: f64, sum: f64) -> f64 {
    let spread = 2.0 / (9.0 * n);
    ((sum / n).cbrt() - (1.0 - spread)) / spread.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rutilant::image::Channel;
    use rutilant::sampler::{Independent, Sampler, Sequence};

    /// A picture of 32 × 32 pixels that scatter around 1 by `deviation`, and say so.
    fn picture(seed: u64, mean: impl Fn(usize) -> f64, deviation: f64, said: f64) -> Image {
        // The sum of twelve even numbers less six: a normal score, near enough.
        let score = |i: usize, stream| {
            let sampler = Independent::new(&Sequence::new(seed, 1), [i as u32, stream], 0);
            (0..12).map(|k| f64::from(sampler.d1(k))).sum::<f64>() - 6.0
        };
        let channel = |name: &str, stream| Channel {
            name: name.to_owned(),
            values: (0..1024).map(|i| (mean(i) + deviation * score(i, stream)) as f32).collect(),
        };
        let variance = |name: &str| Channel {
            name: format!("variance.{name}"),
            values: vec![(said * said) as f32; 1024],
        };
        let mut channels: Vec<Channel> =
            ["R", "G", "B"].iter().zip(0..).map(|(name, stream)| channel(name, stream)).collect();
        channels.extend(["R", "G", "B"].map(variance));
        Image::new(32, 32, channels).expect("channels of one size")
    }

    fn p(a: &Image, b: &Image) -> f64 {
        compare(a, b, Variance::Measured).expect("all channels").p
    }

    /// Of a hundred pairs of equal pictures about one is as far apart as one in a hundred is: a
    /// test that always passes, or one that often raises false alarms, shows here.
    #[test]
    fn equal_pictures_pass_as_often_as_they_should() {
        let same = |seed| picture(seed, |_| 1.0, 0.1, 0.1);
        let ps: Vec<f64> = (0..200).map(|i| p(&same(2 * i), &same(2 * i + 1))).collect();
        let below = |level: f64| ps.iter().filter(|&&p| p < level).count();
        assert!(below(0.01) <= 8, "{}", below(0.01));
        assert!((40..=160).contains(&below(0.5)), "{}", below(0.5));
    }

    /// Each of the three questions finds what the others cannot.
    #[test]
    fn each_kind_of_difference_is_found() {
        let truth = picture(1, |_| 1.0, 0.1, 0.1);
        // One wrong pixel, by seven of its standard errors.
        let spot = picture(2, |i| if i == 500 { 2.0 } else { 1.0 }, 0.1, 0.1);
        // All pixels wrong by a fifth of theirs.
        let veil = picture(3, |_| 1.03, 0.1, 0.1);
        // Half of them too bright and half too dark, by about one.
        let grain = picture(4, |i| if i % 2 == 0 { 1.1 } else { 0.9 }, 0.1, 0.1);
        // Right, but noisier than it says.
        let boast = picture(5, |_| 1.0, 0.13, 0.1);
        for (name, image) in [("spot", spot), ("veil", veil), ("grain", grain), ("boast", boast)] {
            let p = p(&image, &truth);
            assert!(p < 1e-3, "{name}: {p}");
        }
    }

    /// One score of 2.576 is one in a hundred, as in every table; so is the largest of a thousand
    /// at 4.416, and a chi-square of 135.81 with 100 degrees of freedom.
    #[test]
    fn probabilities_are_those_of_the_tables() {
        let near = |p: f64, expected: f64, within: f64| {
            assert!((p / expected - 1.0).abs() < within, "{p}, expected {expected}");
        };
        near(two_sided(2.5758), 0.01, 1e-3);
        near(any_of(two_sided(4.41609), 1000), 0.01, 1e-3);
        // The cube root is an approximation: good to half a per cent here.
        near(two_sided(chi_square_z(100.0, 135.807)) / 2.0, 0.01, 5e-3);
    }
}
