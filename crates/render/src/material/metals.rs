//! Metals whose indices of refraction have been measured.
//!
//! A measured index n + i k at every wavelength becomes one number per channel
//! like this. What the metal reflects at normal incidence under daylight (D65)
//! is turned into linear sRGB, as an eye would see it; gold's red lies outside
//! of sRGB and becomes the most that gold reflects anywhere in the visible.
//! `eta` is the mean of n over what the channel is sensitive to, and `k` follows
//! from both, so that the colour at normal incidence is right. A test below does
//! all that again from the measurements.
//!
//! Source: Johnson and Christy, "Optical Constants of the Noble Metals", Physical
//! Review B 6, 1972 (gold, copper, silver); Rakić, "Algorithm for the
//! Determination of Intrinsic Optical Constants of Metal Films: Application to
//! Aluminum", Applied Optics 34, 1995; as tabulated by refractiveindex.info.

use super::conductor::Conductor;
use crate::color::Rgb;

/// A measured metal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "each is named after what it is")]
pub enum Metal {
    Gold,
    Copper,
    Silver,
    Aluminium,
}

impl Metal {
    /// A conductor of this metal; `roughness` from 0 to 1.
    pub fn conductor(self, roughness: f32) -> Conductor {
        let (eta, k) = match self {
            Self::Gold => ([0.301, 0.554, 1.350], [6.738, 2.407, 1.726]),
            Self::Copper => ([0.506, 1.027, 1.246], [5.047, 2.612, 2.320]),
            Self::Silver => ([0.054, 0.054, 0.044], [4.367, 3.510, 2.621]),
            Self::Aluminium => ([1.272, 0.975, 0.647], [7.063, 6.511, 5.534]),
        };
        Conductor::new(Rgb(eta), Rgb(k), roughness)
    }
}

#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "expected values are computed in f64")]
mod tests {
    use super::*;

    /// Wavelength in µm, n, k.
    type Measured = &'static [(f64, f64, f64)];

    const GOLD: Measured = &[
        (0.3815, 1.46, 1.933),
        (0.3974, 1.47, 1.952),
        (0.4133, 1.46, 1.958),
        (0.4305, 1.45, 1.948),
        (0.4509, 1.38, 1.914),
        (0.4714, 1.31, 1.849),
        (0.4959, 1.04, 1.833),
        (0.5209, 0.62, 2.081),
        (0.5486, 0.43, 2.455),
        (0.5821, 0.29, 2.863),
        (0.6168, 0.21, 3.272),
        (0.6595, 0.14, 3.697),
        (0.7045, 0.13, 4.103),
        (0.7560, 0.14, 4.542),
    ];
    const COPPER: Measured = &[
        (0.3815, 1.33, 2.045),
        (0.3974, 1.32, 2.116),
        (0.4133, 1.28, 2.207),
        (0.4305, 1.25, 2.305),
        (0.4509, 1.24, 2.397),
        (0.4714, 1.25, 2.483),
        (0.4959, 1.22, 2.564),
        (0.5209, 1.18, 2.608),
        (0.5486, 1.02, 2.577),
        (0.5821, 0.70, 2.704),
        (0.6168, 0.30, 3.205),
        (0.6595, 0.22, 3.747),
        (0.7045, 0.21, 4.205),
        (0.7560, 0.24, 4.665),
    ];
    const SILVER: Measured = &[
        (0.3815, 0.05, 1.864),
        (0.3974, 0.05, 2.070),
        (0.4133, 0.05, 2.275),
        (0.4305, 0.04, 2.462),
        (0.4509, 0.04, 2.657),
        (0.4714, 0.05, 2.869),
        (0.4959, 0.05, 3.093),
        (0.5209, 0.05, 3.324),
        (0.5486, 0.06, 3.586),
        (0.5821, 0.05, 3.858),
        (0.6168, 0.06, 4.152),
        (0.6595, 0.05, 4.483),
        (0.7045, 0.04, 4.838),
        (0.7560, 0.03, 5.242),
    ];
    const ALUMINIUM: Measured = &[
        (0.36466, 0.39877, 4.3957),
        (0.41328, 0.52135, 5.0008),
        (0.44280, 0.60790, 5.3676),
        (0.47687, 0.72780, 5.7781),
        (0.51660, 0.87340, 6.2418),
        (0.56357, 1.0728, 6.7839),
        (0.61993, 1.3660, 7.4052),
        (0.65225, 1.5724, 7.7354),
        (0.68881, 1.8301, 8.0601),
        (0.72932, 2.1606, 8.3565),
        (0.77491, 2.6154, 8.4914),
    ];

    /// Daylight from 380 to 780 nm in steps of 20 (CIE standard illuminant D65).
    const D65: [f64; 21] = [
        49.98, 82.75, 93.43, 104.86, 117.81, 115.92, 109.35, 104.79, 104.41, 100.0, 95.79, 90.01,
        87.70, 83.70, 80.21, 78.28, 71.61, 61.60, 75.09, 46.42, 63.38,
    ];

    fn at(nm: f64, measured: Measured) -> [f64; 2] {
        let um = 0.001 * nm;
        let i = measured.partition_point(|m| m.0 < um).clamp(1, measured.len() - 1);
        let (a, b) = (measured[i - 1], measured[i]);
        let t = ((um - a.0) / (b.0 - a.0)).clamp(0.0, 1.0);
        [a.1 + (b.1 - a.1) * t, a.2 + (b.2 - a.2) * t]
    }

    fn daylight(nm: f64) -> f64 {
        let x = (nm - 380.0) / 20.0;
        let i = (x as usize).min(19);
        D65[i] + (D65[i + 1] - D65[i]) * (x - i as f64)
    }

    /// What linear sRGB's channels are sensitive to: the CIE 1931 observer, as Wyman, Sloan and
    /// Shirley fit it ("Simple Analytic Approximations to the CIE XYZ Color Matching Functions",
    /// JCGT 2(2), 2013), through the matrix of IEC 61966-2-1.
    fn sensitivity(nm: f64) -> [f64; 3] {
        let lobe = |middle: f64, left: f64, right: f64| {
            let t = (nm - middle) * if nm < middle { left } else { right };
            (-0.5 * t * t).exp()
        };
        let x = 0.362 * lobe(442.0, 0.0624, 0.0374) + 1.056 * lobe(599.8, 0.0264, 0.0323)
            - 0.065 * lobe(501.1, 0.0490, 0.0382);
        let y = 0.821 * lobe(568.8, 0.0213, 0.0247) + 0.286 * lobe(530.9, 0.0613, 0.0322);
        let z = 1.217 * lobe(437.0, 0.0845, 0.0278) + 0.681 * lobe(459.0, 0.0385, 0.0725);
        [
            3.240_454_2 * x - 1.537_138_5 * y - 0.498_531_4 * z,
            -0.969_266 * x + 1.876_010_8 * y + 0.041_556 * z,
            0.055_643_4 * x - 0.204_025_9 * y + 1.057_225_2 * z,
        ]
    }

    fn reflected([n, k]: [f64; 2]) -> f64 {
        ((n - 1.0).powi(2) + k * k) / ((n + 1.0).powi(2) + k * k)
    }

    /// The built-in numbers are what the measurements come to. A digit that is wrong, or a
    /// channel that is another's, shows here.
    #[test]
    fn metals_are_as_measured() {
        for (metal, measured) in [
            (Metal::Gold, GOLD),
            (Metal::Copper, COPPER),
            (Metal::Silver, SILVER),
            (Metal::Aluminium, ALUMINIUM),
        ] {
            let wavelengths = || (380..=780).map(f64::from);
            let most = wavelengths().map(|nm| reflected(at(nm, measured))).fold(0.0, f64::max);
            let built_in = metal.conductor(0.0);
            for channel in 0..3 {
                let mean = |weight: &dyn Fn(f64) -> f64, value: &dyn Fn(f64) -> f64| {
                    let total: f64 = wavelengths().map(weight).sum();
                    wavelengths().map(|nm| weight(nm) * value(nm)).sum::<f64>() / total
                };
                let seen = |nm: f64| sensitivity(nm)[channel] * daylight(nm);
                let r = mean(&seen, &|nm| reflected(at(nm, measured))).min(most);
                let n = mean(&|nm| seen(nm).max(0.0), &|nm| at(nm, measured)[0]);
                let k = ((r * (n + 1.0).powi(2) - (n - 1.0).powi(2)) / (1.0 - r)).sqrt();
                let got = [built_in.eta.0[channel], built_in.k.0[channel]].map(f64::from);
                assert!(
                    (got[0] - n).abs() < 2e-3 && (got[1] - k).abs() < 2e-3,
                    "{metal:?}, channel {channel}: {got:?}, not {n:.4} {k:.4}"
                );
                assert!((reflected(got) - r).abs() < 5e-4, "{metal:?}, channel {channel}");
            }
        }
    }
}
