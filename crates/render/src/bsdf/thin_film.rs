//! A film so thin that light interferes in it: soap, oil on water, tempered steel.
//!
//! What both faces of the film reflect comes together with a phase that depends
//! on wavelength, thickness and angle. Summed over the spectrum it would be a
//! long integral; the sensitivities of the eye are taken as bell curves, whose
//! Fourier transforms are known, so that each order of reflection needs a few
//! cosines only. Two orders suffice; more are too fine to be seen.
//!
//! Below the film is what reflects some colour at normal incidence, taken as a
//! medium that does not absorb.
//!
//! Source: Belcour and Barla, "A Practical Extension to Microfacet Theory for
//! the Modeling of Varying Iridescence", ACM TOG 36(4), 2017, equations 6 to 10
//! and the supplemental fit of the sensitivities; glTF extension
//! `KHR_materials_iridescence`.

use super::fresnel::Fresnel;
use crate::color::Spectrum;
use rutilant_geom::real;
use std::f32::consts::PI;

/// A film in air.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ThinFilm {
    /// How much of the surface has it, 0 to 1.
    pub(super) strength: f32,
    ior: f32,
    thickness_nm: f32,
}

impl ThinFilm {
    /// `None` where there is none. `ior` is at least 1.
    pub(super) fn new(strength: f32, ior: f32, thickness_nm: f32) -> Option<Self> {
        // Films that vanish do so without a step.
        let t = (thickness_nm / 30.0).clamp(0.0, 1.0);
        let ior = 1.0 + (ior - 1.0) * t * t * (3.0 - 2.0 * t);
        (strength > 0.0).then_some(Self { strength, ior, thickness_nm })
    }

    /// The part reflected under the cosine `cos` in air, 0 to 1, where `normal` is what the border
    /// below would reflect in air at normal incidence.
    pub(super) fn reflectance(&self, cos: f32, normal: Spectrum) -> Spectrum {
        let sin2 = (1.0 - cos * cos).max(0.0) / (self.ior * self.ior);
        let cos_inside = (1.0 - sin2).max(0.0).sqrt();
        let (upper, _) = Fresnel::Exact.dielectric(cos, self.ior);
        let passed = 1.0 - upper;
        let way = 2.0 * self.ior * self.thickness_nm * cos_inside;
        let (first, second) = (sensed(way), sensed(2.0 * way));
        let (first, second) = (first.channels(), second.channels());
        let normal = normal.channels();
        let channel = |k: usize| {
            let root = normal[k].clamp(0.0, 0.9999).sqrt();
            let base = (1.0 + root) / (1.0 - root);
            let lower = schlick(face(base / self.ior), cos_inside);
            // Half a wave is lost where the medium beyond is denser: always at the upper face from
            // below, and at the lower one where the base is thinner than the film.
            let sign = if base < self.ior { 1.0 } else { -1.0 };
            let product = (upper * lower).clamp(1e-5, 0.9999);
            let to_and_fro = passed * passed * lower / (1.0 - product);
            let amplitude = product.sqrt();
            let swing = 2.0 * (to_and_fro - passed) * amplitude;
            upper + to_and_fro + swing * (sign * first[k] + amplitude * second[k])
        };
        Spectrum::from(std::array::from_fn(channel)).map(|c| c.clamp(0.0, 1.0))
    }
}

/// What a face between media of this relative index reflects at normal incidence.
fn face(eta: f32) -> f32 {
    let r = (eta - 1.0) / (eta + 1.0);
    r * r
}

fn schlick(normal: f32, cos: f32) -> f32 {
    let m = 1.0 - cos;
    normal + (1.0 - normal) * (m * m) * (m * m) * m
}

/// What the three channels see of a cosine over the spectrum, for a way of so many nanometres: 1
/// for no way, nearly 0 for long ones.
fn sensed(way_nm: f32) -> Spectrum {
    /// Weight, place (1/m) and variance (1/m²) of the bell curves: x, y, z, and x again.
    const BELLS: [[f32; 3]; 4] = [
        [5.4856e-13, 1.6810e6, 4.3278e9],
        [4.4201e-13, 1.7953e6, 9.3046e9],
        [5.2481e-13, 2.2084e6, 6.6121e9],
        [9.7470e-14, 2.2399e6, 4.5282e9],
    ];
    /// What all of y amounts to.
    const WHOLE: f32 = 1.0685e-7;
    let phase = 2.0 * PI * way_nm * 1e-9;
    let [x, y, z, x2] = BELLS.map(|[weight, place, variance]| {
        weight
            * (2.0 * PI * variance).sqrt()
            * real::cos(place * phase)
            * real::exp(-variance * phase * phase)
            / WHOLE
    });
    let x = x + x2;
    // To linear sRGB.
    Spectrum::from([
        3.240_454 * x - 1.537_138 * y - 0.498_531 * z,
        -0.969_266 * x + 1.876_011 * y + 0.041_556 * z,
        0.055_643 * x - 0.204_026 * y + 1.057_225 * z,
    ])
}

#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "expected values are computed in f64")]
mod tests {
    use super::*;

    /// The brightness of a film seen straight on is Airy's sum over all ways to and fro (Born and
    /// Wolf, section 7.6), wavelength by wavelength, as the eye weighs it (Wyman et al. 2013).
    #[test]
    fn films_are_as_bright_as_airy_says() {
        let eye = |nm: f64| {
            let bell = |at: f64, below: f64, above: f64| {
                let t = (nm - at) / if nm < at { below } else { above };
                (-0.5 * t * t).exp()
            };
            0.821 * bell(568.8, 46.9, 40.5) + 0.286 * bell(530.9, 16.3, 31.1)
        };
        for (ior, base, thickness) in [
            (1.33_f64, 1.0_f64, 110.0_f64),
            (1.33, 1.0, 300.0),
            (1.33, 1.5, 100.0),
            (1.38, 1.5, 250.0),
            (2.0, 1.5, 70.0),
            (1.5, 3.0, 500.0),
        ] {
            let r12 = (1.0 - ior) / (1.0 + ior);
            let r23 = (ior - base) / (ior + base);
            let (mut sum, mut total) = (0.0, 0.0);
            for i in 0..400 {
                let nm = 380.0 + f64::from(i);
                let phase = 4.0 * std::f64::consts::PI * ior * thickness / nm;
                let product = r12 * r23;
                let up = r12 * r12 + r23 * r23 + 2.0 * product * phase.cos();
                let down = 1.0 + product * product + 2.0 * product * phase.cos();
                sum += eye(nm) * up / down;
                total += eye(nm);
            }
            let film = ThinFilm::new(1.0, ior as f32, thickness as f32).expect("a film");
            let normal = ((base - 1.0) / (base + 1.0)).powi(2) as f32;
            let got = f64::from(film.reflectance(1.0, Spectrum::splat(normal)).luminance());
            let expected = sum / total;
            assert!((got - expected).abs() < 0.02, "{ior} {base} {thickness}: {got} {expected}");
        }
    }

    /// A film without thickness is not there.
    #[test]
    fn no_film_reflects_what_the_base_does() {
        let film = ThinFilm::new(1.0, 1.4, 0.0).expect("a film");
        for normal in [0.04_f32, 0.3, 0.9] {
            for cos in [1.0_f32, 0.7, 0.2] {
                let got = film.reflectance(cos, Spectrum::splat(normal)).max_channel();
                let bare = schlick(normal, cos);
                assert!((got - bare).abs() < 0.01, "{normal} {cos}: {got} {bare}");
            }
        }
    }
}
