//! What a single bounce between facets loses, and the lobe that gives it back.
//!
//! Light that a facet sends into its neighbours is lost to the microfacet
//! formulas: two fifths of it at worst. A second lobe brings it back: with E(μ)
//! the part that single scattering sends on, it is
//! (1 - E(μo)) (1 - E(μi)) / (π (1 - Ē)), which is reciprocal and adds up to
//! exactly what is missing.
//!
//! `1 - E` is tabulated over roughness and angle, for dielectrics over the index
//! as well, in `energy.bin`: 16-bit fractions in little-endian order, index by
//! index, roughness by roughness, angle by angle. `examples/bake_energy.rs`
//! wrote it and can write it again; a test below computes entries another way.
//!
//! Angles are stepped evenly in μ (1 + β) / (μ + β) with β = α / (1 + 2 α²): facets
//! hide each other where μ is about α, and in these steps all small roughnesses
//! look the same. Inside the denser medium they end at the critical angle, which
//! leaves a crease in what is lost, and the rest is stepped evenly beyond it.
//!
//! Source: Kulla and Conty, "Revisiting Physically Based Shading at Imageworks",
//! SIGGRAPH course, 2017, for the idea; Hill, "A Multi-Faceted Exploration", 2018.

use rutilant_geom::{Vec2, Vec3, real};
use std::f32::consts::{FRAC_1_PI, PI};

/// What single scattering loses, for light from one side of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Loss {
    alpha: f32,
    /// β: the cosine at half of the steps, nearly.
    half_way: f32,
    /// The cosine up to which everything is reflected; 1 where there is none.
    critical: f32,
    /// Steps up to there, of all: this times μ / (μ + β).
    below_critical: f32,
    /// Where in the table: which angles, and how much of those at the next roughness and index.
    first: u32,
    table: Table,
    rougher: f32,
    denser: f32,
    /// The mean over the cosine-weighted hemisphere, 1 - Ē.
    pub(super) mean: f32,
    /// The density of the cosines drawn is this times μ / (μ² + α²), over a circle.
    density: f32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Table {
    /// Nothing is lost, or nothing given back.
    None,
    Conductor,
    Dielectric,
}

/// How many roughnesses, angles and indices there are.
struct Shape {
    start: usize,
    angles: usize,
    roughnesses: usize,
    indices: usize,
}

const CONDUCTOR: Shape = Shape { start: 0, angles: 64, roughnesses: 32, indices: 1 };
/// From outside the denser medium; from inside follows.
const OUTSIDE: Shape = Shape { start: 64 * 32, angles: 49, roughnesses: 24, indices: 30 };
const INSIDE: Shape = Shape { start: OUTSIDE.start + 49 * 24 * 30, ..OUTSIDE };

/// The part of the steps up to the critical angle, where there is one.
const UP_TO_CRITICAL: f32 = 0.625;

/// The indices of refraction in the table, stepped evenly in the logarithm of index - 1.
const INDICES: std::ops::RangeInclusive<f32> = 1.04..=10.0;

const LOST: &[u8] = include_bytes!("energy.bin");

impl Loss {
    /// Nothing is given back.
    pub(super) const NONE: Self = Self {
        alpha: 1.0,
        half_way: 0.0,
        critical: 1.0,
        below_critical: 1.0,
        first: 0,
        table: Table::None,
        rougher: 0.0,
        denser: 0.0,
        // Of no meaning, but lobes divide by it, and by 1 less it.
        mean: 0.5,
        density: 0.0,
    };

    /// For facets that reflect everything; `roughness` from 0 to 1.
    pub(super) fn conductor(roughness: f32) -> Self {
        Self::metal(roughness).averaged()
    }

    /// The same with a [`mean`](Self::mean) that is still to be found.
    pub(super) fn metal(roughness: f32) -> Self {
        Self::new(roughness, Table::Conductor, &CONDUCTOR, 0.0, 1.0)
    }

    /// For clear facets, with the index beyond over that before them.
    pub(super) fn dielectric(roughness: f32, eta: f32) -> Self {
        Self::glass(roughness, eta).averaged()
    }

    /// The same with a [`mean`](Self::mean) that is still to be found.
    pub(super) fn glass(roughness: f32, eta: f32) -> Self {
        let (shape, index) = if eta > 1.0 { (OUTSIDE, eta) } else { (INSIDE, 1.0 / eta) };
        let (least, most) = (*INDICES.start(), *INDICES.end());
        let log = |index: f32| real::ln(index.clamp(least, most) - 1.0);
        let step = (log(index) - log(least)) / (log(most) - log(least));
        let critical = if eta < 1.0 { (1.0 - eta * eta).sqrt() } else { 1.0 };
        let index = step * (shape.indices - 1) as f32;
        Self::new(roughness, Table::Dielectric, &shape, index, critical)
    }

    fn new(roughness: f32, table: Table, shape: &Shape, index: f32, critical: f32) -> Self {
        let alpha = roughness * roughness;
        let half_way = alpha / (1.0 + 2.0 * alpha * alpha);
        let up_to = if critical < 1.0 { UP_TO_CRITICAL } else { 1.0 };
        let row = roughness * (shape.roughnesses - 1) as f32;
        let whole = |x: f32, n: usize| (x as usize).min(n.saturating_sub(2));
        let (i, r) = (whole(index, shape.indices), whole(row, shape.roughnesses));
        Self {
            alpha,
            half_way,
            critical,
            below_critical: up_to * (critical + half_way) / critical,
            first: (shape.start + (i * shape.roughnesses + r) * shape.angles) as u32,
            table,
            rougher: row - r as f32,
            denser: index - i as f32,
            mean: 0.0,
            density: FRAC_1_PI / real::ln(1.0 + 1.0 / (alpha * alpha)),
        }
    }

    /// The same with a mean from elsewhere.
    pub(super) fn with_mean(self, mean: f32) -> Self {
        Self { mean, ..self }
    }

    /// The same with a mean that is good to three percent, and less at the
    /// least roughness: quickly found, for what is made at every hit.
    pub(super) fn roughly_averaged(self) -> Self {
        // As below, but each step is the last one grown by the same factor.
        const STEPS: u32 = 40;
        let step = real::ln(1.0 + 1.0 / self.alpha) / STEPS as f32;
        let (mut grown, growth) = (self.alpha * real::exp(0.5 * step), real::exp(step));
        let mut mean = 0.0;
        for _ in 0..STEPS {
            let mu = (grown - self.alpha).clamp(0.0, 1.0);
            mean += 2.0 * mu * self.at(mu) * grown * step;
            grown *= growth;
        }
        self.with_mean(mean)
    }

    /// The same with its mean.
    fn averaged(self) -> Self {
        let (mut loss, alpha) = (self, self.alpha);
        // Steps that are even in the logarithm of μ + α: most is lost at small angles.
        const STEPS: u32 = 512;
        let range = real::ln(1.0 + 1.0 / alpha);
        for k in 0..STEPS {
            let grown = alpha * real::exp(range * (k as f32 + 0.5) / STEPS as f32);
            let mu = (grown - alpha).clamp(0.0, 1.0);
            loss.mean += 2.0 * mu * loss.at(mu) * grown * (range / STEPS as f32);
        }
        loss
    }

    /// The part lost, 0 to 1, of light that leaves or arrives under the cosine `mu`, which rounding
    /// may leave a little above 1.
    pub(super) fn at(&self, mu: f32) -> f32 {
        let mu = mu.min(1.0);
        let (shape, layers) = match self.table {
            Table::None => return 0.0,
            Table::Conductor => (&CONDUCTOR, 1),
            Table::Dielectric => (&OUTSIDE, 2),
        };
        let step = if mu <= self.critical {
            self.below_critical * mu / (mu + self.half_way)
        } else {
            let beyond = (mu - self.critical) / (1.0 - self.critical);
            UP_TO_CRITICAL + (1.0 - UP_TO_CRITICAL) * beyond
        };
        let step = step * (shape.angles - 1) as f32;
        let angle = (step as usize).min(shape.angles - 2);
        let along = step - angle as f32;
        let entry = |i: usize| {
            LOST.get(2 * i..2 * i + 2).map_or(0.0, |b| f32::from(u16::from_le_bytes([b[0], b[1]])))
        };
        let between = |a: f32, b: f32, t: f32| a + (b - a) * t;
        let row = |i: usize| between(entry(i), entry(i + 1), along);
        let layer = |i: usize| between(row(i), row(i + shape.angles), self.rougher);
        let first = self.first as usize + angle;
        let lost = if layers == 1 {
            layer(first)
        } else {
            let next = first + shape.angles * shape.roughnesses;
            between(layer(first), layer(next), self.denser)
        };
        lost * (1.0 / f32::from(u16::MAX))
    }

    /// Draws a direction with positive z about as often as it is lost, times its cosine.
    pub(super) fn sample(&self, u: Vec2) -> Vec3 {
        // ∫ μ / (μ² + α²) is a logarithm: even steps of it.
        let alpha2 = self.alpha * self.alpha;
        let grown = real::exp(u.y * real::ln(1.0 + 1.0 / alpha2));
        let mu = (alpha2 * (grown - 1.0)).clamp(0.0, 1.0).sqrt();
        let sin = ((1.0 - mu) * (1.0 + mu)).sqrt();
        let (s, c) = real::sin_cos(2.0 * PI * u.x);
        Vec3::new(sin * c, sin * s, mu)
    }

    /// The density of [`sample`](Self::sample), in 1/sr, under the cosine `mu`.
    pub(super) fn pdf(&self, mu: f32) -> f32 {
        self.density * mu / (mu * mu + self.alpha * self.alpha)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::fresnel::Fresnel;

    /// The part lost, by an integral over all facets and not only those seen, even in their slope:
    /// tan θ = α t / (1 - t). Λ is Heitz 2014, equation 72, as it is printed.
    fn lost(alpha: f64, mu: f64, eta: Option<f64>) -> f64 {
        let lambda = |z: f64| {
            let tan2 = (1.0 - z * z).max(0.0) / (z * z);
            0.5 * ((1.0 + alpha * alpha * tan2).sqrt() - 1.0)
        };
        let x = (1.0 - mu * mu).sqrt();
        let (slopes, turns) = (1200, 400);
        let mut sent_on = 0.0;
        for i in 0..slopes {
            let t = (f64::from(i) + 0.5) / f64::from(slopes);
            let tan = alpha * t / (1.0 - t);
            // D cos θ dω = 2 tan / (α² (1 + tan² / α²)²) d tan, over a turn.
            let scaled = 1.0 + tan * tan / (alpha * alpha);
            let area = 2.0 * tan / (alpha * alpha * scaled * scaled) * alpha
                / ((1.0 - t) * (1.0 - t))
                / f64::from(slopes);
            let cos = 1.0 / (1.0 + tan * tan).sqrt();
            for k in 0..turns {
                let turn = std::f32::consts::PI * (k as f32 + 0.5) / turns as f32;
                let mx = tan * cos * f64::from(real::cos(turn));
                let facing = x * mx + mu * cos;
                if facing <= 0.0 {
                    continue;
                }
                let (reflected, cos_t) = match eta {
                    Some(eta) => {
                        let sin2 = (1.0 - facing * facing) / (eta * eta);
                        let (f, _) = Fresnel::Exact.dielectric(facing as f32, eta as f32);
                        (f64::from(f), (1.0 - sin2).max(0.0).sqrt())
                    }
                    None => (1.0, 0.0),
                };
                let up = 2.0 * facing * cos - mu;
                let mut goes = 0.0;
                if up > 0.0 {
                    goes += reflected / (1.0 + lambda(mu) + lambda(up));
                }
                if let (Some(eta), true) = (eta, reflected < 1.0) {
                    let down = mu / eta - (facing / eta - cos_t) * cos;
                    if down > 0.0 {
                        goes += (1.0 - reflected) / (1.0 + lambda(mu)) / (1.0 + lambda(down));
                    }
                }
                sent_on += goes * area * facing / (mu * cos) / f64::from(turns);
            }
        }
        1.0 - sent_on
    }

    /// The table is what it says, at entries and between them: baked and integrated are two ways.
    #[test]
    fn tables_hold_what_is_lost() {
        for roughness in [0.1_f32, 0.35, 0.6, 0.83, 1.0] {
            for mu in [0.02_f32, 0.15, 0.5, 0.9, 1.0] {
                let alpha = f64::from(roughness * roughness);
                let metal = lost(alpha, f64::from(mu), None);
                let got = Loss::conductor(roughness).at(mu);
                assert!((f64::from(got) - metal).abs() < 3e-3, "{roughness} {mu}: {got} {metal}");
                for eta in [1.05_f32, 1.33, 1.5, 2.4, 1.0 / 1.05, 1.0 / 1.5, 1.0 / 2.4] {
                    let glass = lost(alpha, f64::from(mu), Some(f64::from(eta)));
                    let got = Loss::dielectric(roughness, eta).at(mu);
                    assert!(
                        (f64::from(got) - glass).abs() < 4e-3,
                        "{roughness} {mu} {eta}: {got} {glass}"
                    );
                }
            }
        }
    }

    /// Means for every hit are those for every material; where facets are less rough than this,
    /// so little is lost that they hardly count.
    #[test]
    fn quick_means_are_near_the_others() {
        for roughness in [0.1, 0.23, 0.3, 0.45, 0.72, 1.0] {
            for eta in [1.05, 1.33, 1.5, 2.4, 1.0 / 1.05, 1.0 / 1.5, 1.0 / 2.4] {
                let (got, expected) = (
                    Loss::glass(roughness, eta).roughly_averaged().mean,
                    Loss::dielectric(roughness, eta).mean,
                );
                assert!((got / expected - 1.0).abs() < 0.03, "{roughness} {eta}: {got} {expected}");
            }
            let (got, expected) =
                (Loss::metal(roughness).roughly_averaged().mean, Loss::conductor(roughness).mean);
            assert!((got / expected - 1.0).abs() < 0.03, "{roughness}: {got} {expected}");
        }
    }

    /// What is given back is drawn about as often as it is worth, down to the least roughness,
    /// where nearly all of it is near grazing. There the table's straight lines lie above the
    /// curve, at a hundred-thousandth of the light; even there no sample is precious.
    #[test]
    fn what_is_given_back_is_drawn_evenly() {
        for roughness in [0.020_001, 0.05, 0.2, 0.5, 1.0] {
            for loss in [
                Loss::conductor(roughness),
                Loss::dielectric(roughness, 1.5),
                Loss::dielectric(roughness, 1.0 / 1.5),
            ] {
                let (mut sum, mut squares, n) = (0.0, 0.0, 4096);
                for i in 0..n {
                    let wi = loss.sample(Vec2::new(0.3, (i as f32 + 0.5) / n as f32));
                    let value = loss.at(wi.z) * wi.z * FRAC_1_PI / loss.mean;
                    let weight = value / loss.pdf(wi.z);
                    sum += weight;
                    squares += weight * weight;
                }
                let mean = sum / n as f32;
                assert!((mean - 1.0).abs() < 0.01, "{roughness}: {mean}");
                let mean_square = squares / n as f32;
                assert!(mean_square < 10.0, "{roughness}: {mean_square}");
            }
        }
    }
}
