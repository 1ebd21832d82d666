//! What an eye makes of pure light.
//!
//! Source: Wyman, Sloan, Shirley, "Simple Analytic Approximations to the CIE XYZ Color Matching
//! Functions", JCGT 2(2), 2013, listing 1.

use rutilant_geom::real;

/// The CIE 1931 observer: X, Y and Z of light of one wavelength, in nanometres. Y is 1 at its most, and
/// all are nearly 0 below 380 nm and above 780 nm.
pub fn color_matching(wavelength_nm: f32) -> [f32; 3] {
    let bell = |middle: f32, below: f32, above: f32| {
        let t = (wavelength_nm - middle) * if wavelength_nm < middle { below } else { above };
        real::exp(-0.5 * t * t)
    };
    [
        1.056 * bell(599.8, 0.0264, 0.0323) + 0.362 * bell(442.0, 0.0624, 0.0374)
            - 0.065 * bell(501.1, 0.0490, 0.0382),
        0.821 * bell(568.8, 0.0213, 0.0247) + 0.286 * bell(530.9, 0.0613, 0.0322),
        1.217 * bell(437.0, 0.0845, 0.0278) + 0.681 * bell(459.0, 0.0385, 0.0725),
    ]
}
