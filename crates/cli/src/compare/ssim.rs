//! SSIM: how much of the structure of a picture is in another.
//!
//! Around each pixel the brightness of both pictures is compared by its mean,
//! its spread and its correlation. The result is one number per pixel, 1 where
//! both are equal, about 0 where they have nothing to do with each other, and
//! negative where one is the other's opposite.
//!
//! Colours count by their luma alone: see `flip.rs` for what a viewer would
//! notice.
//!
//! Source: Wang, Bovik, Sheikh, Simoncelli, "Image Quality Assessment: From
//! Error Visibility to Structural Similarity", IEEE TIP 13(4), 2004.

use super::pixels::Pixels;
use super::plane::{Plane, taps};

/// The similarity at each pixel of two pictures of one size, of what a display shows
/// (sRGB, 0 to 1).
pub(crate) fn map(test: &Pixels, reference: &Pixels) -> Vec<f32> {
    // The paper's window: a Gaussian of 1.5 pixels, 11 pixels wide.
    let mut window = taps(5.0, |x| (-x * x / (2.0 * 1.5 * 1.5)).exp());
    let sum: f32 = window.iter().sum();
    window.iter_mut().for_each(|w| *w /= sum);

    let (a, b) = (luma(test), luma(reference));
    let mean = |value: &dyn Fn(f32, f32) -> f32| {
        let values = a.iter().zip(&b).map(|(a, b)| value(*a, *b)).collect();
        Plane { width: test.width, values }.convolved(&window, &window).values
    };
    let means = [mean(&|a, _| a), mean(&|_, b| b)];
    let products = [mean(&|a, _| a * a), mean(&|_, b| b * b), mean(&|a, b| a * b)];
    (0..a.len())
        .map(|i| {
            similarity([means[0][i], means[1][i]], [products[0][i], products[1][i], products[2][i]])
        })
        .collect()
}

/// Equation 13, from the means of a and b, and of a², b² and ab.
fn similarity([a, b]: [f32; 2], [aa, bb, ab]: [f32; 3]) -> f32 {
    /// These keep the ratios stable where there is nothing to compare, for values up to 1.
    const C: [f32; 2] = [0.01 * 0.01, 0.03 * 0.03];
    let (spread_a, spread_b, together) = (aa - a * a, bb - b * b, ab - a * b);
    (2.0 * a * b + C[0]) * (2.0 * together + C[1])
        / ((a * a + b * b + C[0]) * (spread_a + spread_b + C[1]))
}

/// Rec. 709 luma.
fn luma(picture: &Pixels) -> Vec<f32> {
    picture.values.iter().map(|[r, g, b]| 0.2126 * r + 0.7152 * g + 0.0722 * b).collect()
}

#[cfg(test)]
mod tests {
    use super::super::testing::{checker, noise, noisy, ramp, shifted};
    use super::*;

    /// The mean over all pixels that have their whole window inside the picture.
    fn inside(test: &Pixels, reference: &Pixels) -> f64 {
        let (map, width) = (map(test, reference), test.width);
        let height = map.len() / width;
        let mut sum = 0.0;
        for y in 5..height - 5 {
            sum +=
                map[y * width + 5..(y + 1) * width - 5].iter().copied().map(f64::from).sum::<f64>();
        }
        sum / ((width - 10) * (height - 10)) as f64
    }

    /// Against scikit-image 0.26's `structural_similarity(a, b, gaussian_weights=True, sigma=1.5,
    /// use_sample_covariance=False, data_range=1)` of the same pictures' luma.
    #[test]
    fn values_are_those_of_another_program() {
        let size = (41, 33);
        let (ramp, checker) = (ramp(size), checker(size, 4));
        for (name, test, reference, expected) in [
            ("noisy ramp", noisy(&ramp, 3, 0.2), ramp.clone(), 0.674_204_7),
            ("shifted checker", shifted(&checker), checker, 0.493_258_4),
            ("noise", noise(size, 1), noise(size, 2), -0.028_655_8),
        ] {
            let got = inside(&test, &reference);
            assert!((got - expected).abs() < 1e-5, "{name}: {got} instead of {expected}");
        }
    }

    /// A picture is all of itself, however small.
    #[test]
    fn equal_pictures_are_one() {
        for size in [(1, 1), (3, 2), (20, 20)] {
            assert!(map(&noise(size, 4), &noise(size, 4)).iter().all(|s| (s - 1.0).abs() < 1e-5));
        }
    }
}
