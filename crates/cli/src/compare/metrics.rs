//! How far two pictures are apart, in numbers: mean errors over pixels and channels.
//!
//! These judge light, not eyes: see `flip.rs` for what a viewer would notice.

use super::pixels::Pixels;
use serde::Serialize;

/// What relMSE adds to the squared reference, so that black pixels do not
/// divide by zero. The literature on Monte Carlo rendering uses 0.01.
pub(crate) const EPSILON: f64 = 0.01;

/// Errors of a picture against a reference. Every mean runs over all finite
/// pixels and their three channels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Errors {
    /// Root of the mean squared difference.
    pub rmse: f64,
    /// Mean of (a − b)² / (b² + 0.01), b the reference.
    pub relmse: f64,
    /// The same without the worst 0.1 % of pixels.
    pub relmse_999: f64,
    /// Mean of a − b: shows a picture that is too bright or too dark as a whole.
    pub bias: f64,
    /// Mean of b.
    pub reference_mean: f64,
}

/// Compares finite pixels. `None` where there are none.
pub(crate) fn errors(test: &Pixels, reference: &Pixels) -> Option<Errors> {
    let mut relative = Vec::with_capacity(reference.values.len());
    let (mut squares, mut bias, mut sum) = (0.0, 0.0, 0.0);
    for (a, b) in finite_pairs(test, reference) {
        let mut pixel = 0.0;
        for (a, b) in a.map(f64::from).into_iter().zip(b.map(f64::from)) {
            let difference = a - b;
            squares += difference * difference;
            bias += difference;
            sum += b;
            pixel += difference * difference / (b * b + EPSILON);
        }
        relative.push(pixel / 3.0);
    }
    if relative.is_empty() {
        return None;
    }
    let pixels = relative.len() as f64;
    relative.sort_unstable_by(f64::total_cmp);
    let kept = (relative.len() * 999 / 1000).max(1);
    Some(Errors {
        rmse: (squares / (3.0 * pixels)).sqrt(),
        relmse: relative.iter().sum::<f64>() / pixels,
        relmse_999: relative[..kept].iter().sum::<f64>() / kept as f64,
        bias: bias / (3.0 * pixels),
        reference_mean: sum / (3.0 * pixels),
    })
}

/// Peak signal-to-noise ratio in decibels of values whose peak is 1; infinite
/// for equal pictures. Only the pixels that `counts` names take part.
pub(crate) fn psnr(test: &Pixels, reference: &Pixels, counts: &[bool]) -> f64 {
    let pairs = test.values.iter().zip(&reference.values).zip(counts);
    let (mut squares, mut count) = (0.0, 0);
    for ((a, b), _) in pairs.filter(|(_, counts)| **counts) {
        squares += a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>();
        count += 3;
    }
    -10.0 * (squares / f64::from(count.max(1))).log10()
}

/// How many pixels have a NaN or an infinite channel.
pub(crate) fn not_finite(picture: &Pixels) -> usize {
    picture.values.iter().filter(|rgb| !finite(rgb)).count()
}

/// The pixels that are finite in both pictures.
fn finite_pairs<'a>(
    test: &'a Pixels,
    reference: &'a Pixels,
) -> impl Iterator<Item = ([f32; 3], [f32; 3])> + 'a {
    let pairs = test.values.iter().copied().zip(reference.values.iter().copied());
    pairs.filter(|(a, b)| finite(a) && finite(b))
}

/// True when every channel is a number.
pub(crate) fn finite(rgb: &[f32; 3]) -> bool {
    rgb.iter().all(|c| c.is_finite())
}

#[cfg(test)]
mod tests {
    use super::super::testing::{noise, ramp};
    use super::*;

    fn flat(value: f32, count: usize) -> Pixels {
        Pixels { width: count, values: vec![[value; 3]; count] }
    }

    /// Constant pictures: every mean is the one pixel's value, known by hand.
    #[test]
    fn constant_pictures_have_known_errors() {
        let e = errors(&flat(0.7, 2000), &flat(0.5, 2000)).unwrap();
        let relative = 0.04 / 0.26;
        for (got, expected) in [
            (e.rmse, 0.2),
            (e.relmse, relative),
            (e.relmse_999, relative),
            (e.bias, 0.2),
            (e.reference_mean, 0.5),
        ] {
            assert!((got - expected).abs() < 1e-6, "{got} instead of {expected}");
        }
    }

    /// One firefly in a thousand pixels is all of relMSE and nothing of its trimmed form.
    #[test]
    fn the_worst_pixel_of_a_thousand_is_left_out() {
        let reference = flat(0.0, 1000);
        let mut test = reference.clone();
        test.values[123] = [10.0; 3];
        let e = errors(&test, &reference).unwrap();
        assert!((e.relmse - 100.0 / EPSILON / 1000.0).abs() < 1e-9);
        assert_eq!(e.relmse_999, 0.0);
    }

    /// A tenth of the peak everywhere is 20 dB; a picture and itself are infinitely close.
    #[test]
    fn psnr_is_in_decibels_of_the_peak() {
        let db = psnr(&flat(0.6, 50), &flat(0.5, 50), &[true; 50]);
        assert!((db - 20.0).abs() < 1e-4, "{db}");
        let ramp = ramp((20, 30));
        assert_eq!(psnr(&ramp, &ramp, &[true; 600]), f64::INFINITY);
    }

    /// A NaN is counted and takes no part; a picture of nothing else has no error at all.
    #[test]
    fn nan_is_counted_and_left_out() {
        let reference = noise((16, 16), 1);
        let mut test = reference.clone();
        test.values[7][1] = f32::NAN;
        test.values[9][0] = f32::INFINITY;
        assert_eq!(not_finite(&test), 2);
        assert_eq!(errors(&test, &reference).unwrap().rmse, 0.0);
        let nothing = flat(f32::NAN, 10);
        assert_eq!(errors(&nothing, &nothing), None);
    }
}
