//! A surface of tiny facets, each a mirror or a pane: how they lean, and how they hide each other.
//!
//! The slopes follow the GGX distribution (Trowbridge and Reitz 1975), which is
//! an ellipsoid's: stretched along z by 1/α it becomes a sphere, and everything
//! here is that stretch. Facets hide each other as Smith has it, as if their
//! heights and slopes had nothing to do with one another.
//! Metal and glass may follow Beckmann's distribution instead: see `beckmann.rs`.
//!
//! The functions take vectors and not cosines, so that a surface that is rougher
//! one way than the other needs no other callers.
//!
//! Source: Walter et al., "Microfacet Models for Refraction through Rough
//! Surfaces", EGSR 2007; Heitz, "Understanding the Masking-Shadowing Function in
//! Microfacet-Based BRDFs", JCGT 3(2), 2014; Dupuy and Benyoub, "Sampling Visible
//! GGX Normals with Spherical Caps", CGF 42(8), 2023.

use super::beckmann::Beckmann;
use super::energy::Loss;
use rutilant_geom::{Vec2, Vec3, real};
use std::f32::consts::PI;

/// How the slopes of facets are distributed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Distribution {
    /// With long tails, as most rough surfaces have them. What facets send into each other is given
    /// back.
    #[default]
    Ggx,
    /// Normally, as in many older scenes. What facets send into each other is lost, as there.
    Beckmann,
}

/// The facets of a surface that is as rough one way as the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Facets {
    Ggx(Ggx),
    Beckmann(Beckmann),
}

impl Facets {
    /// `roughness` lies between 0 and 1; α is its square. `None` where it is too smooth to tell.
    pub(super) fn new(distribution: Distribution, roughness: f32) -> Option<Self> {
        let alpha = roughness * roughness;
        if alpha < Ggx::LEAST_ALPHA {
            return None;
        }
        Some(match distribution {
            Distribution::Ggx => Self::Ggx(Ggx { alpha }),
            Distribution::Beckmann => Self::Beckmann(Beckmann { alpha }),
        })
    }

    pub(super) fn distribution(self) -> Distribution {
        match self {
            Self::Ggx(_) => Distribution::Ggx,
            Self::Beckmann(_) => Distribution::Beckmann,
        }
    }

    /// How rough they are, 0 to 1.
    pub(super) fn roughness(self) -> f32 {
        match self {
            Self::Ggx(Ggx { alpha }) | Self::Beckmann(Beckmann { alpha }) => alpha.sqrt(),
        }
    }

    /// What facets that reflect everything lose and give back.
    pub(super) fn metal_loss(self) -> Loss {
        match self {
            Self::Ggx(_) => Loss::conductor(self.roughness()),
            Self::Beckmann(_) => Loss::NONE,
        }
    }

    /// What clear facets lose and give back; `eta` is the index beyond over that before them.
    pub(super) fn glass_loss(self, eta: f32) -> Loss {
        match self {
            Self::Ggx(_) => Loss::dielectric(self.roughness(), eta),
            Self::Beckmann(_) => Loss::NONE,
        }
    }

    /// As [`Ggx::density`].
    #[inline]
    pub(super) fn density(self, m: Vec3) -> f32 {
        match self {
            Self::Ggx(facets) => facets.density(m),
            Self::Beckmann(facets) => facets.density(m),
        }
    }

    /// As [`Ggx::squeezed_length`]: `|w.z| (1 + 2 Λ(w))`.
    #[inline]
    pub(super) fn squeezed_length(self, w: Vec3) -> f32 {
        match self {
            Self::Ggx(facets) => facets.squeezed_length(w),
            Self::Beckmann(facets) => facets.squeezed_length(w),
        }
    }

    /// As [`Ggx::sample_seen`].
    #[inline]
    pub(super) fn sample_seen(self, wo: Vec3, u: Vec2) -> Vec3 {
        match self {
            Self::Ggx(facets) => facets.sample_seen(wo, u),
            Self::Beckmann(facets) => facets.sample_seen(wo, u),
        }
    }
}

/// The GGX distribution of facet normals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ggx {
    /// The root mean square slope, had it one: 0 is smooth, 1 very rough.
    pub alpha: f32,
}

impl Ggx {
    /// The least α that single precision resolves. A half vector is known to a few 10⁻⁷, a small
    /// part of this; the highlight of anything smoother is smaller than a pixel.
    pub const LEAST_ALPHA: f32 = 4e-4;

    /// Area of facets with normal `m` (unit) per area of surface and solid angle, in 1/sr. Zero
    /// where z is not positive.
    pub fn density(self, m: Vec3) -> f32 {
        if m.z <= 0.0 {
            return 0.0;
        }
        // Not through 1 - z²: near the pole that would be all rounding.
        let alpha2 = self.alpha * self.alpha;
        let stretched = (m.x * m.x + m.y * m.y) / alpha2 + m.z * m.z;
        1.0 / (PI * alpha2 * stretched * stretched)
    }

    /// `|w.z| (1 + 2 Λ(w))` for Smith's Λ (Heitz 2014, equation 72): the length of `w`, squeezed
    /// to where the facets are a sphere. No smaller than |w.z|.
    pub fn squeezed_length(self, w: Vec3) -> f32 {
        (self.alpha * self.alpha * (w.x * w.x + w.y * w.y) + w.z * w.z).sqrt()
    }

    /// The part of the facets facing `w` that is seen from there: G1 = 1 / (1 + Λ).
    pub fn seen(self, w: Vec3) -> f32 {
        let z = w.z.abs();
        if z == 0.0 { 0.0 } else { 2.0 * z / (z + self.squeezed_length(w)) }
    }

    /// Draws a facet normal as often as it is seen from `wo`, whose z must be positive: with
    /// density G1(wo) max(0, wo·m) D(m) / wo.z. `u` holds two numbers in [0, 1).
    pub fn sample_seen(self, wo: Vec3, u: Vec2) -> Vec3 {
        let squeeze = |v: Vec3| Vec3::new(self.alpha * v.x, self.alpha * v.y, v.z);
        let seen_from = squeeze(wo).normalize();
        squeeze(cap_normal(seen_from, u)).normalize_or(Vec3::Z)
    }
}

/// The GGX distribution of facets that are steeper one way than the other, as brushing leaves them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StretchedGgx {
    /// α along x.
    pub(super) along: f32,
    /// α along y.
    pub(super) across: f32,
}

impl StretchedGgx {
    /// As [`Ggx::density`].
    pub(super) fn density(self, m: Vec3) -> f32 {
        if m.z <= 0.0 {
            return 0.0;
        }
        let (x, y) = (m.x / self.along, m.y / self.across);
        let stretched = x * x + y * y + m.z * m.z;
        1.0 / (PI * self.along * self.across * stretched * stretched)
    }

    /// As [`Ggx::squeezed_length`].
    pub(super) fn squeezed_length(self, w: Vec3) -> f32 {
        self.squeeze(w).length()
    }

    /// As [`Ggx::sample_seen`].
    pub(super) fn sample_seen(self, wo: Vec3, u: Vec2) -> Vec3 {
        self.squeeze(cap_normal(self.squeeze(wo).normalize(), u)).normalize_or(Vec3::Z)
    }

    /// To where the facets are a sphere.
    fn squeeze(self, v: Vec3) -> Vec3 {
        Vec3::new(self.along * v.x, self.across * v.y, v.z)
    }
}

/// A normal, of any length, of a sphere's facet as often as it is seen from the unit vector
/// `seen_from` above ground: a cap of the sphere reflects that into all directions above ground.
fn cap_normal(seen_from: Vec3, u: Vec2) -> Vec3 {
    let z = (1.0 - u.y) * (1.0 + seen_from.z) - seen_from.z;
    let sin = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
    let (s, c) = real::sin_cos(2.0 * PI * u.x);
    Vec3::new(sin * c, sin * s, z) + seen_from
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ∫ f(m) dm over the upper hemisphere, by steps that are even in slope where it counts:
    /// tan θ = α t / (1 - t).
    fn integrate(alpha: f64, f: impl Fn(Vec3) -> f64) -> f64 {
        let n = 1500;
        let mut sum = 0.0;
        for i in 0..n {
            let t = (f64::from(i) + 0.5) / f64::from(n);
            let tan = alpha * t / (1.0 - t);
            let cos = 1.0 / (1.0 + tan * tan).sqrt();
            let sin = tan * cos;
            // dω = sin θ dθ dφ, dθ = cos² θ d tan.
            let weight = sin * cos * cos * alpha / ((1.0 - t) * (1.0 - t)) / f64::from(n);
            for k in 0..64 {
                let turn = std::f32::consts::TAU * (k as f32 + 0.5) / 64.0;
                let (s, c) = real::sin_cos(turn);
                let m = Vec3::new(sin as f32 * c, sin as f32 * s, cos as f32);
                sum += f(m) * weight * std::f64::consts::TAU / 64.0;
            }
        }
        sum
    }

    const ALPHAS: [f32; 6] = [Ggx::LEAST_ALPHA, 0.01, 0.1, 0.3, 0.7, 1.0];

    /// α, and both kinds of facets.
    fn all() -> impl Iterator<Item = (f32, Facets)> {
        ALPHAS.into_iter().flat_map(|alpha| {
            [Facets::Ggx(Ggx { alpha }), Facets::Beckmann(Beckmann { alpha })]
                .map(|facets| (alpha, facets))
        })
    }

    /// Facets seen from above cover the surface once: ∫ D cos = 1.
    #[test]
    fn facets_cover_the_surface() {
        for (alpha, facets) in all() {
            let area = integrate(f64::from(alpha), |m| f64::from(facets.density(m) * m.z));
            assert!((area - 1.0).abs() < 1e-4, "{facets:?}: {area}");
        }
    }

    /// The facets seen from a direction fill what is seen of the surface from there (Heitz 2014,
    /// equation 14): ∫ G1 max(0, w·m) D = cos θ. It fixes Λ without any formula for it.
    #[test]
    fn seen_facets_fill_the_view() {
        for (alpha, facets) in all() {
            for cos in [1.0_f32, 0.9, 0.5, 0.2, 0.05] {
                let w = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
                let facing = integrate(f64::from(alpha), |m| {
                    f64::from(w.dot(m).max(0.0) * facets.density(m))
                });
                let seen = f64::from(cos) / facing;
                let got = f64::from(2.0 * cos / (cos + facets.squeezed_length(w)));
                assert!((got - seen).abs() < 2e-3, "{facets:?} {cos}: {got}, not {seen}");
                if let Facets::Ggx(ggx) = facets {
                    assert!((f64::from(ggx.seen(w)) - got).abs() < 1e-6);
                }
            }
        }
    }

    /// Beckmann's slopes are normally distributed: their mean square is α², and at four times that
    /// the density has fallen to e⁻⁴ of what it is for level facets, per slope.
    #[test]
    fn slopes_are_normal() {
        for alpha in ALPHAS {
            let facets = Beckmann { alpha };
            let slope2 = integrate(f64::from(alpha), |m| {
                f64::from(facets.density(m) * m.z) * f64::from(1.0 / (m.z * m.z) - 1.0)
            });
            let expected = f64::from(alpha * alpha);
            // 1/z² - 1 is rounded to some 10⁻⁷.
            assert!((slope2 / expected - 1.0).abs() < 1e-3 + 1e-7 / expected, "{alpha}: {slope2}");
            let steep = Vec3::new(2.0 * alpha, 0.0, 1.0).normalize();
            let per_slope = |m: Vec3| f64::from(facets.density(m) * m.z * m.z * m.z * m.z);
            let fallen = per_slope(steep) / per_slope(Vec3::Z);
            assert!((fallen - f64::from(real::exp(-4.0))).abs() < 1e-5, "{alpha}: {fallen}");
        }
    }
}
