//! Facets whose slopes are normally distributed, as Beckmann and many after him had it.
//!
//! Their highlights end sooner than those of GGX: take them for pictures that are to agree with
//! others made so, and GGX for everything else. What these facets send into each other is lost here,
//! as it is in renderers that use them: the tables of `energy.rs` are those of GGX.
//!
//! Source: Beckmann and Spizzichino, *The Scattering of Electromagnetic Waves from Rough Surfaces*,
//! 1963; Walter et al., "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007; for
//! drawing facets Heitz and d'Eon, "Importance Sampling Microfacet-Based BSDFs using the
//! Distribution of Visible Normals", EGSR 2014, and Jakob, "An Improved Visible Normal Sampling
//! Routine for the Beckmann Distribution", 2014.

use rutilant_geom::{Vec2, Vec3, real};
use std::f32::consts::{FRAC_2_SQRT_PI, PI};

/// Beckmann's distribution of facet normals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Beckmann {
    /// The root mean square slope: 0 is smooth, 1 very rough.
    pub(super) alpha: f32,
}

impl Beckmann {
    /// As [`Ggx::density`](super::Ggx::density): Walter 2007, equation 25.
    pub(super) fn density(self, m: Vec3) -> f32 {
        if m.z <= 0.0 {
            return 0.0;
        }
        let (alpha2, z2) = (self.alpha * self.alpha, m.z * m.z);
        let slope2 = (m.x * m.x + m.y * m.y) / z2;
        real::exp(-slope2 / alpha2) / (PI * alpha2 * z2 * z2)
    }

    /// As [`Ggx::squeezed_length`](super::Ggx::squeezed_length).
    pub(super) fn squeezed_length(self, w: Vec3) -> f32 {
        facing(w.z.abs(), self.alpha * (w.x * w.x + w.y * w.y).sqrt())
    }

    /// As [`Ggx::sample_seen`](super::Ggx::sample_seen).
    pub(super) fn sample_seen(self, wo: Vec3, u: Vec2) -> Vec3 {
        // Where α is 1, and wo lies above the x axis.
        let (x, y) = (self.alpha * wo.x, self.alpha * wo.y);
        let side = (x * x + y * y).sqrt();
        let (c, s) = if side > 0.0 { (x / side, y / side) } else { (1.0, 0.0) };
        let size = (side * side + wo.z * wo.z).sqrt();
        let along = seen_slope(wo.z / size, side / size, u.y);
        let across = any_slope(u.x);

        // Normals lean to where slopes fall.
        let (slope_x, slope_y) = (c * along - s * across, s * along + c * across);
        Vec3::new(-self.alpha * slope_x, -self.alpha * slope_y, 1.0).normalize()
    }
}

/// How much of facets of α = 1 faces the direction (`side`, 0, `up`), less how much faces away; times
/// the area of the surface. It is `up` (1 + 2 Λ) for the Λ that follows from Walter 2007, equation 26,
/// multiplied out so that nothing is divided by small numbers.
fn facing(up: f32, side: f32) -> f32 {
    let a = up / side.max(f32::MIN_POSITIVE);
    up * real::erf(a) + side * bell(a)
}

/// exp(−x²) / √π, the density of slopes.
fn bell(x: f32) -> f32 {
    0.5 * FRAC_2_SQRT_PI * real::exp(-x * x)
}

/// Draws the slope, along x, of a facet of α = 1 as often as it is seen from the unit vector (`side`,
/// 0, `up`): with a density in proportion to (`up` − x `side`) exp(−x²) where that is positive. `u`
/// lies in [0, 1).
fn seen_slope(up: f32, side: f32, u: f32) -> f32 {
    let steepest = up / side.max(f32::MIN_POSITIVE);
    // The distribution function is (up (1 + erf x) + side exp(−x²) / √π) / 2, over all of it.
    let sought = u * (up + facing(up, side));
    let missing = |x: f32, erf: f32| up * (1.0 + erf) + side * bell(x) - sought;
    let slope_at = |erf: f32| inverse_erf(erf).min(steepest);

    // Seen from above it is u, up to a factor, as a function of erf x, and bent like 1 - (1 - u)²
    // from the side: between these a power is within a few percent.
    let highest = real::erf(steepest);
    let first = 1.0 - real::pow(1.0 - u, 1.0 / (1.0 + side));
    let mut x = slope_at(first * (1.0 + highest) - 1.0);
    // Newton's method, twice for erf x and once more for x itself: no error of u above 10⁻⁵ is left.
    for _ in 0..2 {
        let erf = real::erf(x);
        let rise = (up - side * x).max(1e-6);
        x = slope_at((erf - missing(x, erf) / rise).clamp(-1.0, highest));
    }
    let rise = 2.0 * bell(x) * (up - side * x);
    let step = missing(x, real::erf(x)) / rise.max(1e-6);
    (x - step).clamp(-STEEPEST, steepest)
}

/// Draws a slope across, which does not matter for what is seen. `u` lies in [0, 1).
fn any_slope(u: f32) -> f32 {
    let erf = 2.0 * u - 1.0;
    let x = inverse_erf(erf);
    (x - (real::erf(x) - erf) / (2.0 * bell(x))).clamp(-STEEPEST, STEEPEST)
}

/// No facet is drawn that is steeper, with α = 1: one in twenty million is.
const STEEPEST: f32 = 3.8;

/// About the number that has this [`real::erf`]: within a fifth of a percent, and ±[`STEEPEST`].
///
/// Source: Winitzki, "A handy approximation for the error function and its inverse", 2008.
fn inverse_erf(erf: f32) -> f32 {
    const A: f32 = 0.147;
    let ln = real::ln((1.0 - erf) * (1.0 + erf)).max(-20.0);
    let half = 2.0 / (PI * A) + 0.5 * ln;
    let x = (-ln / A / ((half * half - ln / A).sqrt() + half)).sqrt();
    x.min(STEEPEST).copysign(erf)
}
