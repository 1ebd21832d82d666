//! A rough border between two clear media: frosted glass, ground edges, ice.
//!
//! Facets reflect and refract like smooth glass. What those of the GGX
//! distribution send into each other comes back by two more lobes, one on each
//! side, that together give back what is lost and are reciprocal.
//!
//! Facets are drawn as often as they are seen, and reflect as often as the
//! Fresnel equations say; the other lobes as often as light is lost to them.
//!
//! Not for indices that are almost equal: facets that hardly bend light still
//! hide each other, so that this model would make a diffuse surface of what is
//! hardly there. [`RoughDielectric::new`] leaves those to the smooth border.
//!
//! Source: Walter et al., "Microfacet Models for Refraction through Rough
//! Surfaces", EGSR 2007; `microfacet.rs` and `energy.rs`.

use super::energy::Loss;
use super::fresnel::Fresnel;
use super::microfacet::{Distribution, Facets};
use super::sample::BsdfSample;
use crate::color::Spectrum;
use rutilant_geom::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

/// A rough border. The interior is below: where z is negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughDielectric {
    /// Index of refraction below over that above.
    eta: f32,
    facets: Facets,
    above: Side,
    below: Side,
}

/// What is lost and given back, seen from one side.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Side {
    loss: Loss,
    /// The part of what is lost that crosses the border when it is given back.
    crossing: f32,
}

/// The way that light goes on.
enum Way {
    Reflected,
    Refracted,
}

impl RoughDielectric {
    /// The least ratio of indices at which facets matter.
    pub const LEAST_RATIO: f32 = 1.04;

    /// With facets of GGX: see [`with`](Self::with).
    pub fn new(eta: f32, roughness: f32) -> Option<Self> {
        Self::with(Distribution::Ggx, eta, roughness)
    }

    /// A border with the index `eta` below over that above, and a `roughness` between 0 and 1; α
    /// is its square. `None` where it cannot be told from a smooth one: hardly rough, or hardly
    /// there.
    pub fn with(distribution: Distribution, eta: f32, roughness: f32) -> Option<Self> {
        let facets = Facets::new(distribution, roughness)?;
        if eta.max(1.0 / eta) < Self::LEAST_RATIO {
            return None;
        }
        let above = facets.glass_loss(eta);
        let below = facets.glass_loss(1.0 / eta);
        // Of what is lost as much crosses as of diffuse light on smooth glass, as far as both
        // sides can take it: reciprocity ties the two ways together.
        let most = above.mean.max(below.mean);
        let through = mean_transmittance(eta) / most;
        Some(Self {
            eta,
            facets,
            above: Side { loss: above, crossing: through * below.mean },
            below: Side { loss: below, crossing: through * above.mean / (eta * eta) },
        })
    }

    /// The same border with another index; `None` where that is hardly there.
    pub(super) fn with_eta(&self, eta: f32) -> Option<Self> {
        Self::with(self.facets.distribution(), eta, self.facets.roughness())
    }

    /// Draws the direction the light came from. `choice` and `u` hold numbers in [0, 1). `None`
    /// where the facet sends light into its neighbours.
    #[inline(never)]
    pub fn sample(&self, wo: Vec3, choice: f32, u: Vec2) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let (side, beyond, eta) = self.seen_from(wo);
        let up = Vec3::new(wo.x, wo.y, wo.z.abs());
        let lost = side.loss.at(up.z);
        let (wi, way) = if choice < lost {
            // Given back, on one side or the other.
            if choice < lost * side.crossing {
                (-beyond.loss.sample(u), Way::Refracted)
            } else {
                (side.loss.sample(u), Way::Reflected)
            }
        } else {
            // By a single facet.
            let facet = self.facets.sample_seen(up, u);
            let cos = up.dot(facet);
            let (reflected, cos_t) = Fresnel::Exact.dielectric(cos.clamp(0.0, 1.0), eta);
            if choice - lost < reflected * (1.0 - lost) {
                (2.0 * cos * facet - up, Way::Reflected)
            } else {
                ((cos / eta - cos_t) * facet - up / eta, Way::Refracted)
            }
        };
        let (eta, wi) = match way {
            Way::Reflected if wi.z > 0.0 => (1.0, wi.normalize()),
            Way::Refracted if wi.z < 0.0 => (eta, wi.normalize()),
            Way::Reflected | Way::Refracted => return None,
        };
        let wi = if wo.z < 0.0 { Vec3::new(wi.x, wi.y, -wi.z) } else { wi };
        let (value, pdf) = self.eval_cos_pdf(wo, wi);
        let weight = value / pdf;
        (pdf > 0.0).then_some(BsdfSample { wi, weight, pdf, delta: false, eta })
    }

    /// BSDF value times cosine, `f(wo, wi) |cos θi|`, and the density of [`sample`](Self::sample),
    /// both in 1/sr.
    #[inline(never)]
    pub fn eval_cos_pdf(&self, wo: Vec3, wi: Vec3) -> (Spectrum, f32) {
        let (o, i) = (wo.z.abs(), wi.z.abs());
        if o == 0.0 || i == 0.0 {
            return (Spectrum::BLACK, 0.0);
        }
        let (side, beyond, eta) = self.seen_from(wo);
        let lost = side.loss.at(o);
        let (length_o, length_i) =
            (self.facets.squeezed_length(wo), self.facets.squeezed_length(wi));
        if wo.z * wi.z > 0.0 {
            // Given back on this side.
            let returning = 1.0 - side.crossing;
            let mut value = returning * lost * side.loss.at(i) * i * (FRAC_1_PI / side.loss.mean);
            let mut pdf = lost * returning * side.loss.pdf(i);
            // Reflected by a facet, hidden from both sides at once. The half vector is twice as
            // long as the cosine on the facet.
            let half = wo + wi;
            let length = half.length();
            let hidden = o * length_i + i * length_o;
            if length > 0.0 && hidden > 0.0 {
                let density = self.facets.density(half * (half.z.signum() / length));
                let (reflected, _) = Fresnel::Exact.dielectric((0.5 * length).min(1.0), eta);
                value += reflected * density * 0.5 * i / hidden;
                pdf += (1.0 - lost) * reflected * density * 0.5 / (o + length_o);
            }
            (Spectrum::splat(value), pdf)
        } else {
            // Given back beyond. Radiance is less here by the square of the index.
            let mut value =
                side.crossing * lost * beyond.loss.at(i) * i * (FRAC_1_PI / beyond.loss.mean)
                    / (eta * eta);
            let mut pdf = lost * side.crossing * beyond.loss.pdf(i);
            // Refracted by the facet between. Written with the index of each side, so that the
            // way back has the same bits.
            let (index_o, index_i) = if wo.z > 0.0 { (1.0, self.eta) } else { (self.eta, 1.0) };
            let half = wo * index_o + wi * index_i;
            let length2 = half.length_squared();
            let facet = half * (half.z.signum() / length2.sqrt());
            let (cos_o, cos_i) = (wo.dot(facet) * wo.z.signum(), wi.dot(facet) * wi.z.signum());
            if length2 > 0.0 && cos_o > 0.0 && cos_i > 0.0 {
                let cos_above = if wo.z > 0.0 { cos_o } else { cos_i };
                let (reflected, _) = Fresnel::Exact.dielectric(cos_above.min(1.0), self.eta);
                // Walter 2007, equations 17 and 21, with separate masking: what hides a facet
                // from above does not hide it from below.
                let once = (1.0 - reflected) * self.facets.density(facet) * cos_o * cos_i / length2
                    * (2.0 / (o + length_o));
                value += once * index_o * index_o * 2.0 * i / (i + length_i);
                pdf += (1.0 - lost) * once * index_i * index_i;
            }
            (Spectrum::splat(value), pdf)
        }
    }

    /// The side of `wo`, the other one, and the index of that over this.
    fn seen_from(&self, wo: Vec3) -> (&Side, &Side, f32) {
        if wo.z > 0.0 {
            (&self.above, &self.below, self.eta)
        } else {
            (&self.below, &self.above, 1.0 / self.eta)
        }
    }
}

/// The part of diffuse light from above that crosses a smooth border.
fn mean_transmittance(eta: f32) -> f32 {
    const STEPS: u32 = 512;
    let cosines = (0..STEPS).map(|n| ((n as f32 + 0.5) / STEPS as f32).sqrt());
    cosines.map(|cos| 1.0 - Fresnel::Exact.dielectric(cos, eta).0).sum::<f32>() / STEPS as f32
}
