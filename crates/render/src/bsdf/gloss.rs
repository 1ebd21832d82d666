//! What a glossy layer reflects in all, and what its facets lose, from tables.
//!
//! A layer over another must know how much light it leaves to it. That is an
//! integral over all directions, and by roughness, angle and index a smooth
//! function: `gloss.bin` holds it in 16-bit fractions in little-endian order.
//! `examples/bake_gloss.rs` wrote it and can write it again; a test below
//! computes entries another way.
//!
//! Reflection by Fresnel's equations is split into what is there at normal
//! incidence and how it rises towards grazing. The first is 1 minus the loss of
//! `energy.rs`, the second is tabulated here as a mean over what facets send
//! on, so that any colour at normal incidence follows from the two. Under thin
//! films it goes up and down, and facets that are steeper one way than the
//! other have too many shapes for such a table: for these it is tabulated under
//! which cosines facets see the light that they send on. Means over all
//! directions are tabulated as well: a layer must be cheap to make, because
//! textures make one at every hit.
//!
//! Between its entries a table tells at least what is reflected, and at most what
//! is lost: what is left for other layers, or given back, is never too much.
//!
//! Source: as for `energy.rs`; OpenPBR Surface specification 1.1, 2024, section
//! on albedo scaling.

use super::fresnel::Fresnel;
use rutilant_geom::{Vec3, real};

/// Indices, roughnesses and angles of the rise; then the means.
const RISE: [usize; 3] = [16, 24, 41];
const RISE_MEANS: usize = 16 * 24 * 41;
/// Roughnesses and angles of sheen.
const SHEEN: [usize; 2] = [16, 32];
const SHEEN_START: usize = RISE_MEANS + 16 * 24;
/// Roughnesses and angles of the cosines under which facets are seen, then what is to be added
/// for the steepest rise, then the means of both.
const SEEN: [usize; 2] = [24, 32];
const SEEN_START: usize = SHEEN_START + 16 * 32;
const SEEN_MORE: usize = SEEN_START + 24 * 32 * SEEN_COSINES;
const SEEN_MEANS: usize = SEEN_MORE + 24 * 32;
/// Roughnesses, anisotropies, directions around the normal and angles of the same for facets that
/// are steeper along x, and what they lose; then the means.
const STRETCHED: [usize; 4] = [10, 9, 7, 18];
const STRETCHED_START: usize = SEEN_MEANS + 24 * (SEEN_COSINES + 1);
const STRETCHED_MORE: usize = STRETCHED_START + 10 * 9 * 7 * 18 * FEW_COSINES;
const STRETCHED_LOST: usize = STRETCHED_MORE + 10 * 9 * 7 * 18;
const STRETCHED_MEANS: usize = STRETCHED_LOST + 10 * 9 * 7 * 18;
const STRETCHED_LOST_MEANS: usize = STRETCHED_MEANS + 10 * 9 * (FEW_COSINES + 1);

/// How many cosines a reflection is told at.
pub(super) const COSINES: usize = 33;
/// How many of them the tables use: every second one.
const SEEN_COSINES: usize = 17;
/// The same where facets are steeper one way than the other: every fourth one.
const FEW_COSINES: usize = 9;

/// The least roughness of sheen in the table.
pub(super) const LEAST_SHEEN: f32 = 0.3;

/// The indices of refraction in the tables, stepped evenly in the logarithm of index - 1.
const INDICES: std::ops::RangeInclusive<f32> = 1.04..=10.0;

const TABLES: &[u8] = include_bytes!("gloss.bin");

fn entry(i: usize) -> f32 {
    let bytes = TABLES.get(2 * i..2 * i + 2);
    bytes.map_or(0.0, |b| f32::from(u16::from_le_bytes([b[0], b[1]])) * (1.0 / 65535.0))
}

/// Where a number lies between two steps of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Step {
    first: u32,
    /// How far on the way to the next step, 0 to 1.
    along: f32,
}

impl Step {
    /// Of `part` (0 to 1) of the way over `n` steps.
    fn at(part: f32, n: usize) -> Self {
        let place = part.clamp(0.0, 1.0) * (n - 1) as f32;
        let first = (place as usize).min(n - 2);
        Self { first: first as u32, along: place - first as f32 }
    }

    /// Of an index of refraction, above 1 or below.
    fn of_index(eta: f32, n: usize) -> Self {
        let (least, most) = (*INDICES.start(), *INDICES.end());
        let log = |index: f32| real::ln(index.clamp(least, most) - 1.0);
        Self::at((log(eta.max(1.0 / eta)) - log(least)) / (log(most) - log(least)), n)
    }

    /// Between what is at the two steps.
    fn between(self, at: impl Fn(usize) -> f32) -> f32 {
        let first = self.first as usize;
        let (a, b) = (at(first), at(first + 1));
        a + (b - a) * self.along
    }
}

/// How the reflection of a dielectric rises from 0 at normal incidence to 1 at grazing, as a mean
/// over facets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rise {
    index: Step,
    roughness: Step,
    /// The mean over the cosine-weighted hemisphere, of all light and not of what is sent on.
    pub(super) mean: f32,
}

impl Rise {
    /// Of an index of refraction, above 1 or below, and a roughness from 0 to 1.
    pub(super) fn new(eta: f32, roughness: f32) -> Self {
        let [indices, roughnesses, _] = RISE;
        let (index, roughness) = (Step::of_index(eta, indices), Step::at(roughness, roughnesses));
        let entry = |n, r| entry(RISE_MEANS + n * roughnesses + r);
        let mean = index.between(|n| roughness.between(|r| entry(n, r)));
        Self { index, roughness, mean }
    }

    /// The mean over what facets send on of the light that leaves under the cosine `mu`.
    pub(super) fn at(&self, mu: f32) -> f32 {
        let [_, roughnesses, angles] = RISE;
        let angle = Step::at(mu.sqrt(), angles);
        let entry = |n, r, a| entry((n * roughnesses + r) * angles + a);
        self.index.between(|n| self.roughness.between(|r| angle.between(|a| entry(n, r, a))))
    }

    /// The same of a smooth surface: how far `reflected`, which Fresnel's equations say for some
    /// angle, has risen from what they say at normal incidence.
    pub(super) fn of_smooth(reflected: f32, eta: f32) -> f32 {
        let normal = normal_reflectance(eta);
        ((reflected - normal) / (1.0 - normal)).clamp(0.0, 1.0)
    }

    /// The part of diffuse light from the thinner side that crosses a smooth border of index `eta`.
    pub(super) fn mean_transmittance(eta: f32) -> f32 {
        (1.0 - normal_reflectance(eta)) * (1.0 - Self::new(eta, 0.0).mean)
    }
}

/// What some gloss reflects at cosines that are denser towards grazing: see [`Reflection::cosines`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reflection([f32; COSINES]);

impl Reflection {
    /// The cosines at which it is told.
    pub(super) fn cosines() -> [f32; COSINES] {
        std::array::from_fn(|k| {
            let part = k as f32 / (COSINES - 1) as f32;
            part * part
        })
    }

    /// What is reflected at each of the [`cosines`](Self::cosines).
    pub(super) fn new(reflected: [f32; COSINES]) -> Self {
        Self(reflected)
    }

    /// The same with a little more where it bends down, so that straight lines between every
    /// `step`th of the cosines nowhere tell less than there is.
    pub(super) fn raised(&self, step: usize) -> Self {
        let (cosines, mut raised) = (Self::cosines(), *self);
        for first in (0..COSINES - step).step_by(step) {
            let next = first + step;
            let most = (first + 1..next).fold(0.0_f32, |most, k| {
                let along = (cosines[k] - cosines[first]) / (cosines[next] - cosines[first]);
                let line = self.0[first] + (self.0[next] - self.0[first]) * along;
                most.max(self.0[k] - line)
            });
            // Beside the places that are looked at a little more may be missing.
            for k in [first, next] {
                raised.0[k] = raised.0[k].max(self.0[k] + 1.3 * most).min(1.0);
            }
        }
        raised
    }

    /// The mean over the cosine-weighted hemisphere, where the surface is smooth.
    ///
    /// By Simpson's rule in the root of the cosine.
    pub(super) fn mean(&self) -> f32 {
        let step = 1.0 / (COSINES - 1) as f32;
        let parts = self.0.iter().enumerate().map(|(k, reflected)| {
            let weight = match k {
                0 => 1.0,
                k if k == COSINES - 1 => 1.0,
                k if k % 2 == 1 => 4.0,
                _ => 2.0,
            };
            // μ = t², so 2 μ dμ = 4 t³ dt.
            let root = k as f32 * step;
            reflected * 4.0 * root * root * root * weight * (step / 3.0)
        });
        parts.sum()
    }

    /// The mean where entries of the tables from `parts` on say how often every `step`th cosine is
    /// seen, and the entry `more` what is to be added for the steepest rise.
    fn seen(&self, step: usize, parts: usize, more: usize) -> f32 {
        let told = self.0.iter().step_by(step).enumerate();
        told.map(|(k, reflected)| reflected * entry(parts + k)).sum::<f32>() + entry(more)
    }
}

/// Under which cosines facets see the light that they send on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SeenFacets {
    roughness: Step,
}

impl SeenFacets {
    /// The step from one of the cosines of a [`Reflection`] that is used to the next one.
    pub(super) const STEP: usize = (COSINES - 1) / (SEEN_COSINES - 1);

    /// Of a roughness from 0 to 1.
    pub(super) fn new(roughness: f32) -> Self {
        Self { roughness: Step::at(roughness, SEEN[0]) }
    }

    /// The mean of what is `reflected` over what facets send on of the light that leaves under the
    /// cosine `mu`.
    pub(super) fn at(&self, mu: f32, reflected: &Reflection) -> f32 {
        let [_, angles] = SEEN;
        let angle = Step::at(mu.sqrt(), angles);
        self.roughness.between(|r| {
            angle.between(|a| {
                let place = r * angles + a;
                reflected.seen(Self::STEP, SEEN_START + place * SEEN_COSINES, SEEN_MORE + place)
            })
        })
    }

    /// The mean over the cosine-weighted hemisphere, of all light and not of what is sent on.
    pub(super) fn mean(&self, reflected: &Reflection) -> f32 {
        self.roughness.between(|r| {
            let start = SEEN_MEANS + r * (SEEN_COSINES + 1);
            reflected.seen(Self::STEP, start, start + SEEN_COSINES)
        })
    }
}

/// What Fresnel's equations say at normal incidence.
pub(super) fn normal_reflectance(eta: f32) -> f32 {
    Fresnel::Exact.dielectric(1.0, eta).0
}

/// What facets that are steeper along x than along y lose, and under which cosines they see what
/// they send on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StretchedFacets {
    roughness: Step,
    anisotropy: Step,
    along: f32,
    across: f32,
    /// What is lost, as a mean over the cosine-weighted hemisphere.
    pub(super) mean_lost: f32,
}

/// Where a direction stands in the tables of stretched facets.
struct Turned {
    turn: Step,
    angle: Step,
}

impl StretchedFacets {
    /// The step from one of the cosines of a [`Reflection`] that is used to the next one.
    pub(super) const STEP: usize = (COSINES - 1) / (FEW_COSINES - 1);

    /// `along` and `across` are α along x and y: the second is the square of `roughness`, the
    /// first lies between it and 1 in proportion to the square of `anisotropy`.
    pub(super) fn new(roughness: f32, anisotropy: f32, [along, across]: [f32; 2]) -> Self {
        let [roughnesses, anisotropies, ..] = STRETCHED;
        let roughness = Step::at(roughness.sqrt(), roughnesses);
        let anisotropy = Step::at(anisotropy.sqrt(), anisotropies);
        let facets = Self { roughness, anisotropy, along, across, mean_lost: 0.0 };
        let mean_lost = facets.between(|row| squared(entry(STRETCHED_LOST_MEANS + row)));
        Self { mean_lost, ..facets }
    }

    /// α of facets alike in all directions that do to light along `w` nearly what these do: what
    /// they have in that direction where it is grazing, and the mean of both ways from above.
    pub(super) fn equal_alpha(&self, w: Vec3) -> f32 {
        let (along2, across2) = (self.along * self.along, self.across * self.across);
        let mean = 0.5 * (along2 + across2);
        (mean * w.z * w.z + along2 * w.x * w.x + across2 * w.y * w.y).sqrt().min(1.0)
    }

    /// The part lost of light that leaves or arrives along `w`.
    pub(super) fn lost(&self, w: Vec3) -> f32 {
        let place = Turned::new(w);
        self.between(|row| place.between(row, |place| squared(entry(STRETCHED_LOST + place))))
    }

    /// The mean of what is `reflected` over what facets send on of the light that leaves along `w`.
    pub(super) fn at(&self, w: Vec3, reflected: &Reflection) -> f32 {
        let place = Turned::new(w);
        self.between(|row| {
            place.between(row, |place| {
                let parts = STRETCHED_START + place * FEW_COSINES;
                reflected.seen(Self::STEP, parts, STRETCHED_MORE + place)
            })
        })
    }

    /// The mean over the cosine-weighted hemisphere, of all light and not of what is sent on.
    pub(super) fn mean(&self, reflected: &Reflection) -> f32 {
        self.between(|row| {
            let start = STRETCHED_MEANS + row * (FEW_COSINES + 1);
            reflected.seen(Self::STEP, start, start + FEW_COSINES)
        })
    }

    /// Between what is in the rows of both roughnesses and anisotropies.
    fn between(&self, of: impl Fn(usize) -> f32) -> f32 {
        let [_, anisotropies, ..] = STRETCHED;
        self.roughness.between(|r| self.anisotropy.between(|s| of(r * anisotropies + s)))
    }
}

impl Turned {
    fn new(w: Vec3) -> Self {
        let [.., turns, angles] = STRETCHED;
        let across = (w.x * w.x + w.y * w.y).sqrt();
        let cos = if across > 0.0 { w.x.abs() / across } else { 0.0 };
        let mu = w.z.abs();
        let root = if mu > 0.0 { real::pow(mu, 1.0 / 3.0) } else { 0.0 };
        Self { turn: Step::at(cos.sqrt(), turns), angle: Step::at(root, angles) }
    }

    /// Between what is at the places of a row.
    fn between(&self, row: usize, of: impl Fn(usize) -> f32) -> f32 {
        let [.., turns, angles] = STRETCHED;
        self.turn.between(|t| self.angle.between(|a| of((row * turns + t) * angles + a)))
    }
}

/// Small numbers are stored as their roots.
fn squared(root: f32) -> f32 {
    root * root
}

/// Where sheen of some roughness stands in its table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SheenAlbedo {
    roughness: Step,
}

impl SheenAlbedo {
    /// `roughness` from [`LEAST_SHEEN`] to 1.
    pub(super) fn new(roughness: f32) -> Self {
        let [roughnesses, _] = SHEEN;
        Self { roughness: Step::at((roughness - LEAST_SHEEN) / (1.0 - LEAST_SHEEN), roughnesses) }
    }

    /// What white sheen sends back of the light that leaves under the cosine `mu`.
    pub(super) fn at(&self, mu: f32) -> f32 {
        let [_, angles] = SHEEN;
        let angle = Step::at(mu.sqrt(), angles);
        self.roughness.between(|r| angle.between(|a| entry(SHEEN_START + r * angles + a)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::energy::Loss;
    use crate::bsdf::sheen::Sheen;
    use crate::color::Spectrum;
    use crate::math::warp;
    use rutilant_geom::Vec2;

    /// What facets reflect, each of them some part of the light, by an integral over all facets
    /// and not only those seen, even in their slopes: the slope is α t / (1 - t) along each axis
    /// of the stretch. Λ is Heitz 2014, equation 72, as it is printed.
    fn sent_on([along, across]: [f64; 2], wo: Vec3, reflects: impl Fn(f64) -> f64) -> f64 {
        let wo = wo.to_array().map(f64::from);
        let lambda = |w: [f64; 3]| {
            let (x, y) = (along * w[0], across * w[1]);
            let slopes = x * x + y * y;
            0.5 * ((1.0 + slopes / (w[2] * w[2])).sqrt() - 1.0)
        };
        let (slopes, turns) = (800, 400);
        let mut sum = 0.0;
        for i in 0..slopes {
            let t = (f64::from(i) + 0.5) / f64::from(slopes);
            let tan = t / (1.0 - t);
            // D cos θ dω of a stretched slope, over a turn.
            let (scaled, left) = (1.0 + tan * tan, 1.0 - t);
            let area = 2.0 * tan / (scaled * scaled) / (left * left);
            for k in 0..turns {
                let turn = std::f32::consts::TAU * (k as f32 + 0.5) / turns as f32;
                let (s, c) = real::sin_cos(turn);
                let m = [along * tan * f64::from(c), across * tan * f64::from(s), 1.0];
                let length = (m[0] * m[0] + m[1] * m[1] + 1.0).sqrt();
                let m = m.map(|x| x / length);
                let cos = wo[0] * m[0] + wo[1] * m[1] + wo[2] * m[2];
                let wi = [0, 1, 2].map(|k| 2.0 * cos * m[k] - wo[k]);
                if cos > 0.0 && wi[2] > 0.0 {
                    let seen = cos / (wo[2] * m[2]) / (1.0 + lambda(wo) + lambda(wi));
                    sum += reflects(cos) * seen * area / f64::from(slopes * turns);
                }
            }
        }
        sum
    }

    fn direction(mu: f32, turn: f32) -> Vec3 {
        let (s, c) = real::sin_cos(turn);
        let sin = (1.0 - mu * mu).sqrt();
        Vec3::new(sin * c, sin * s, mu)
    }

    /// The file ends where the last table does: who wrote it and who reads it mean the same sizes.
    #[test]
    fn tables_fill_the_file() {
        assert_eq!(TABLES.len(), 2 * (STRETCHED_LOST_MEANS + 10 * 9));
    }

    /// The table of the rise is what it says, at entries and between them.
    #[test]
    fn tables_hold_what_gloss_reflects() {
        for eta in [1.1_f32, 1.5, 2.2] {
            for roughness in [0.2_f32, 0.5, 0.93] {
                for mu in [0.05_f32, 0.3, 0.9] {
                    let alpha = f64::from(roughness * roughness);
                    let expected = sent_on([alpha; 2], direction(mu, 0.0), |cos| {
                        let (f, _) = Fresnel::Exact.dielectric((cos as f32).min(1.0), eta);
                        f64::from(Rise::of_smooth(f, eta))
                    });
                    let lost = Loss::conductor(roughness).at(mu);
                    let got = (1.0 - lost) * Rise::new(eta, roughness).at(mu);
                    assert!(
                        (f64::from(got) - expected).abs() < 6e-3,
                        "{eta} {roughness} {mu}: {got} {expected}"
                    );
                }
            }
        }
    }

    /// So is the mean over facets of what rises and falls with the cosine, and that over all light.
    #[test]
    fn tables_hold_what_facets_see() {
        // As a film of half a wave does.
        let film = |cos: f32| 0.5 + 0.3 * real::cos(4.0 * cos);
        let told = Reflection::new(Reflection::cosines().map(film));
        for roughness in [0.1_f32, 0.35, 0.7, 1.0] {
            let (seen, alpha) = (SeenFacets::new(roughness), f64::from(roughness * roughness));
            let sent_on = |mu: f32| {
                let part = |of: &dyn Fn(f64) -> f64| sent_on([alpha; 2], direction(mu, 0.0), of);
                [part(&|cos| f64::from(film(cos as f32))), part(&|_| 1.0)]
            };
            for mu in [0.05_f32, 0.3, 0.9] {
                let [expected, all] = sent_on(mu);
                let got = f64::from(seen.at(mu, &told));
                let expected = expected / all;
                assert!((got - expected).abs() < 0.012, "{roughness} {mu}: {got} {expected}");
            }
            let steps = 12;
            let means = (0..steps).map(|i| {
                let mu = ((i as f32 + 0.5) / steps as f32).sqrt();
                sent_on(mu)[0] / f64::from(steps)
            });
            let (got, expected) = (f64::from(seen.mean(&told)), means.sum::<f64>());
            assert!((got - expected).abs() < 0.012, "{roughness}: {got} {expected}");
        }
        // ∫ μ 2 μ dμ = 2/3, and of Schlick's rise it is 1/21.
        let mean = |of: &dyn Fn(f32) -> f32| Reflection::new(Reflection::cosines().map(of)).mean();
        assert!((mean(&|cos| cos) - 2.0 / 3.0).abs() < 1e-4);
        let schlick = |cos: f32| {
            let m = 1.0 - cos;
            (m * m) * (m * m) * m
        };
        assert!((mean(&schlick) - 1.0 / 21.0).abs() < 1e-4);
    }

    /// That of stretched facets, too; without stretch it is that of the others.
    #[test]
    fn tables_hold_what_stretched_facets_lose() {
        for (roughness, anisotropy) in [(0.2_f32, 0.5_f32), (0.5, 0.9), (0.7, 0.35)] {
            let across = roughness * roughness;
            let along = across + (1.0 - across) * anisotropy * anisotropy;
            let table = StretchedFacets::new(roughness, anisotropy, [along, across]);
            for mu in [0.1, 0.4, 1.0] {
                for turn in [0.0, 0.6, 1.5] {
                    let w = direction(mu, turn);
                    let lost = 1.0 - sent_on([along, across].map(f64::from), w, |_| 1.0);
                    let got = f64::from(table.lost(w));
                    assert!(
                        (got - lost).abs() < 0.012,
                        "{roughness} {anisotropy} {mu} {turn}: {got} {lost}"
                    );
                }
            }
        }
    }

    /// Sheen sends back what its table says, and never more than there is.
    #[test]
    fn tables_hold_what_sheen_sends_back() {
        for roughness in [0.3, 0.55, 1.0] {
            let sheen = Sheen::new(Spectrum::WHITE, roughness).expect("sheen");
            for mu in [0.02, 0.2, 0.7, 1.0] {
                let (wo, n) = (direction(mu, 0.0), 40_000);
                let mut sum = 0.0;
                for i in 0..n {
                    let u = Vec2::new((i as f32 * 0.618_034).fract(), (i as f32 + 0.5) / n as f32);
                    let wi = warp::uniform_hemisphere(u);
                    sum += sheen.eval_cos(wo, wi).max_channel() / warp::UNIFORM_HEMISPHERE_PDF;
                }
                let (got, expected) = (sheen.taken(mu), sum / n as f32);
                assert!((got - expected).abs() < 0.012, "{roughness} {mu}: {got} {expected}");
            }
        }
        for roughness in [0.0, 0.3, 0.31, 0.5, 1.0] {
            let albedo = SheenAlbedo::new(roughness);
            assert!((0..=100).all(|i| albedo.at(i as f32 / 100.0) <= 1.0), "{roughness}");
        }
    }
}
