//! How much light a smooth border reflects.
//!
//! Source: Pharr, Jakob, Humphreys, *Physically Based Rendering*, 4th ed.,
//! sections 9.3.5 and 9.3.6; Schlick, "An Inexpensive BRDF Model for
//! Physically-based Rendering", CGF 13(3), 1994.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8};

/// Which formula gives the reflected part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Fresnel {
    /// The Fresnel equations for unpolarised light.
    Exact,
    /// Schlick's approximation. Inside the denser medium it takes the cosine of the
    /// *transmitted* ray; with the incident one it would miss nearly all reflection up to the
    /// critical angle.
    Schlick,
}

impl Fresnel {
    /// The part of light reflected between two clear media, and the cosine of the refracted ray.
    ///
    /// `cos_i` (0 to 1) is the incident ray's cosine with the normal, `eta` (> 0) the index of
    /// refraction beyond the border over that before it. All is reflected, and the cosine is 0,
    /// where Snell's law has no solution.
    pub fn dielectric(self, cos_i: f32, eta: f32) -> (f32, f32) {
        let sin2_t = (1.0 - cos_i * cos_i).max(0.0) / (eta * eta);
        if sin2_t >= 1.0 {
            return (1.0, 0.0);
        }
        let cos_t = (1.0 - sin2_t).sqrt();
        let reflected = match self {
            Self::Exact => {
                let parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
                let perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
                0.5 * (parallel * parallel + perpendicular * perpendicular)
            }
            Self::Schlick => {
                let r0 = (eta - 1.0) / (eta + 1.0);
                let r0 = r0 * r0;
                let m = 1.0 - if eta > 1.0 { cos_i } else { cos_t };
                r0 + (1.0 - r0) * (m * m) * (m * m) * m
            }
        };
        (reflected, cos_t)
    }

    /// The same for eight surfaces, exactly.
    #[inline(always)]
    pub(super) fn dielectrics<S: Simd>(cos_i: f32x8<S>, eta: f32x8<S>) -> (f32x8<S>, f32x8<S>) {
        let simd = eta.token();
        let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
        let sin2_t = (one - cos_i * cos_i).max(zero) / (eta * eta);
        let total = sin2_t.simd_ge(one);
        let cos_t = (one - sin2_t).sqrt();
        let parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
        let perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
        let reflected = (parallel * parallel + perpendicular * perpendicular) * 0.5;
        (total.select(one, reflected), total.select(zero, cos_t))
    }
}

/// The part of light that a metal of index `eta + i k` reflects; `cos_i` from 0 to 1.
///
/// The complex refracted cosine squared is `1 - sin² / (eta + ik)²`; what follows is its modulus
/// and real part written out (Born and Wolf, *Principles of Optics*, section 14.2).
pub(super) fn conductor(cos_i: f32, eta: f32, k: f32) -> f32 {
    let cos2 = cos_i * cos_i;
    let sin2 = (1.0 - cos2).max(0.0);
    let (eta2, k2) = (eta * eta, k * k);
    let difference = eta2 - k2 - sin2;
    let a2_plus_b2 = (difference * difference + 4.0 * eta2 * k2).sqrt();
    let a = (0.5 * (a2_plus_b2 + difference)).max(0.0).sqrt();
    let (sum, twice) = (a2_plus_b2 + cos2, 2.0 * a * cos_i);
    let perpendicular = ratio(sum - twice, sum + twice);
    let (sum, twice) = (cos2 * a2_plus_b2 + sin2 * sin2, twice * sin2);
    let parallel = perpendicular * ratio(sum - twice, sum + twice);
    (0.5 * (perpendicular + parallel)).clamp(0.0, 1.0)
}

/// `a / b`, and 1 for `0 / 0`: a grazing ray is reflected whole.
fn ratio(a: f32, b: f32) -> f32 {
    if b == 0.0 { 1.0 } else { a / b }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cosine(degrees: f64) -> f32 {
        rutilant_geom::real::cos(degrees.to_radians() as f32)
    }

    /// The textbook table for glass of 1.5: 4 % head on, 8.92 % at 60° (Schlick says 7.0 %).
    #[test]
    fn glass_reflects_what_the_tables_say() {
        // Independent route: amplitudes by the sines and tangents of the two angles, in f64.
        for (from, to) in [(1.0_f64, 1.5_f64), (1.5, 1.0)] {
            for degrees in [0.5_f64, 30.0, 41.0, 45.0, 60.0, 75.0, 85.0] {
                let i = degrees.to_radians();
                #[expect(clippy::disallowed_methods, reason = "the reference is computed in f64")]
                let expected = {
                    let sin_t = from / to * i.sin();
                    if sin_t >= 1.0 {
                        1.0
                    } else {
                        let t = sin_t.asin();
                        let rs = ((i - t).sin() / (i + t).sin()).powi(2);
                        let rp = ((i - t).tan() / (i + t).tan()).powi(2);
                        0.5 * (rs + rp)
                    }
                };
                let (got, _) = Fresnel::Exact.dielectric(cosine(degrees), (to / from) as f32);
                assert!(
                    (f64::from(got) - expected).abs() < 2e-5,
                    "{from}->{to} at {degrees}: {got} {expected}"
                );
            }
        }
        let at_60 = |f: Fresnel| f.dielectric(0.5, 1.5).0;
        assert!((at_60(Fresnel::Exact) - 0.0892).abs() < 5e-5);
        assert!((at_60(Fresnel::Schlick) - 0.0700).abs() < 5e-5);
        assert!((Fresnel::Exact.dielectric(1.0, 1.5).0 - 0.04).abs() < 1e-7);
    }

    /// Inside glass near the critical angle nearly all is reflected. The old program fed Schlick
    /// the incident cosine there and got 0.041 at 41.8° where the truth is 0.891.
    #[test]
    fn schlick_rises_to_total_reflection_inside() {
        let inside = |degrees| Fresnel::Schlick.dielectric(cosine(degrees), 1.0 / 1.5).0;
        assert!(inside(41.8) > 0.7, "{}", inside(41.8));
        assert_eq!(inside(42.0), 1.0);
        let exact = |degrees| Fresnel::Exact.dielectric(cosine(degrees), 1.0 / 1.5).0;
        assert!((exact(41.0) - 0.380).abs() < 5e-3 && (exact(41.8) - 0.891).abs() < 5e-3);
    }

    /// Averaged over a diffuse sky: 0.0918 exact, 0.0857 by Schlick.
    #[test]
    fn hemispherical_averages() {
        for (fresnel, expected) in [(Fresnel::Exact, 0.0918), (Fresnel::Schlick, 0.0857)] {
            let n = 100_000;
            let sum: f64 = (0..n)
                .map(|i| {
                    let cos2 = (f64::from(i) + 0.5) / f64::from(n);
                    f64::from(fresnel.dielectric(cos2.sqrt() as f32, 1.5).0)
                })
                .sum();
            assert!(
                (sum / f64::from(n) - expected).abs() < 5e-5,
                "{fresnel:?}: {}",
                sum / f64::from(n)
            );
        }
    }

    /// Without extinction a conductor is a dielectric seen from outside.
    #[test]
    fn conductor_without_extinction_is_a_dielectric() {
        for i in 0..=100 {
            let cos = i as f32 / 100.0;
            let (dielectric, _) = Fresnel::Exact.dielectric(cos, 1.5);
            assert!((conductor(cos, 1.5, 0.0) - dielectric).abs() < 1e-5, "{cos}");
        }
        let gold_red = ((0.143 - 1.0_f32) * (0.143 - 1.0) + 3.98 * 3.98)
            / ((0.143 + 1.0) * (0.143 + 1.0) + 3.98 * 3.98);
        assert!((conductor(1.0, 0.143, 3.98) - gold_red).abs() < 1e-6);
    }

    /// Edge values stay numbers between 0 and 1.
    #[test]
    fn edges_are_finite() {
        for cos in [0.0, f32::MIN_POSITIVE, 1e-6, 0.5, 1.0] {
            for eta in [0.1, 1.0, 1.5, 10.0] {
                for f in [Fresnel::Exact, Fresnel::Schlick] {
                    let (r, t) = f.dielectric(cos, eta);
                    assert!(
                        (0.0..=1.0).contains(&r) && (0.0..=1.0).contains(&t),
                        "{cos} {eta} {r} {t}"
                    );
                }
                for k in [0.0, 1e-3, 3.0, 100.0] {
                    assert!((0.0..=1.0).contains(&conductor(cos, eta, k)), "{cos} {eta} {k}");
                }
            }
            assert!((0.0..=1.0).contains(&conductor(cos, 0.0, 0.0)));
        }
    }
}
