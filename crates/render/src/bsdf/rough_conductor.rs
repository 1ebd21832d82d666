//! Rough metal: brushed, cast, worn.
//!
//! Facets reflect like smooth metal. What those of the GGX distribution send into
//! each other comes back by the lobe of `energy.rs`, deeper in colour for every
//! bounce: a metal that reflects everything is as bright rough as polished, a
//! coloured one darker and more colourful.
//!
//! Facets are drawn as often as they are seen; the second lobe as often as light
//! is lost to it.
//!
//! Source: as for `microfacet.rs` and `energy.rs`.

use super::energy::Loss;
use super::fresnel;
use super::microfacet::{Distribution, Facets};
use super::sample::BsdfSample;
use crate::color::Spectrum;
use rutilant_geom::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

/// A rough metal of index `eta + i k`, seen from a medium of index 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughConductor {
    eta: Spectrum,
    k: Spectrum,
    facets: Facets,
    loss: Loss,
    /// What is given back, over the two losses, in 1/sr.
    many: Spectrum,
}

impl RoughConductor {
    /// With facets of GGX: see [`with`](Self::with).
    pub fn new(eta: Spectrum, k: Spectrum, roughness: f32) -> Option<Self> {
        Self::with(Distribution::Ggx, eta, k, roughness)
    }

    /// `None` where it is too smooth to tell from smooth metal. `roughness` lies between 0 and 1;
    /// α is its square.
    pub fn with(
        distribution: Distribution,
        eta: Spectrum,
        k: Spectrum,
        roughness: f32,
    ) -> Option<Self> {
        let facets = Facets::new(distribution, roughness)?;
        let loss = facets.metal_loss();
        // The geometric series over the bounces: each reflects the mean and loses the mean.
        let series = |f: f32| f * f * (1.0 - loss.mean) / (1.0 - f * loss.mean);
        let many = mean_reflectance(eta, k).map(series) * (FRAC_1_PI / loss.mean);
        Some(Self { eta, k, facets, loss, many })
    }

    /// Draws the direction the light came from. `choice` and `u` hold numbers in [0, 1). `None`
    /// where the facet reflects into its neighbours.
    #[inline(never)]
    pub fn sample(&self, wo: Vec3, choice: f32, u: Vec2) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let above = Vec3::new(wo.x, wo.y, wo.z.abs());
        let mut wi = if choice < self.loss.at(above.z) {
            self.loss.sample(u)
        } else {
            let facet = self.facets.sample_seen(above, u);
            (2.0 * above.dot(facet) * facet - above).normalize()
        };
        if wi.z <= 0.0 {
            return None;
        }
        if wo.z < 0.0 {
            wi.z = -wi.z;
        }
        let (value, pdf) = self.eval_cos_pdf(wo, wi);
        (pdf > 0.0).then(|| BsdfSample { wi, weight: value / pdf, pdf, delta: false, eta: 1.0 })
    }

    /// The part reflected at normal incidence.
    pub fn albedo(&self) -> Spectrum {
        self.reflectance(1.0)
    }

    /// BSDF value times cosine, `f(wo, wi) |cos θi|`, and the density of [`sample`](Self::sample),
    /// both in 1/sr.
    #[inline(never)]
    pub fn eval_cos_pdf(&self, wo: Vec3, wi: Vec3) -> (Spectrum, f32) {
        if wo.z * wi.z <= 0.0 {
            return (Spectrum::BLACK, 0.0);
        }
        let (o, i) = (wo.z.abs(), wi.z.abs());
        let (lost_o, lost_i) = (self.loss.at(o), self.loss.at(i));
        let mut value = self.many * (lost_o * lost_i * i);
        let mut pdf = lost_o * self.loss.pdf(i);

        // Its length is twice the cosine on the facet.
        let half = wo + wi;
        let length = half.length();
        let (length_o, length_i) =
            (self.facets.squeezed_length(wo), self.facets.squeezed_length(wi));
        // Height-correlated G2 / (4 o i) (Heitz 2014, equation 99).
        let hidden = o * length_i + i * length_o;
        if length > 0.0 && hidden > 0.0 {
            let density = self.facets.density(half * (half.z.signum() / length));
            let once = density * 0.5 * i / hidden;
            value += self.reflectance((0.5 * length).min(1.0)) * once;
            pdf += (1.0 - lost_o) * density * 0.5 / (o + length_o);
        }
        (value, pdf)
    }

    fn reflectance(&self, cos: f32) -> Spectrum {
        reflectance(self.eta, self.k, cos)
    }
}

fn reflectance(eta: Spectrum, k: Spectrum, cos: f32) -> Spectrum {
    let (eta, k) = (eta.channels(), k.channels());
    Spectrum::from(std::array::from_fn(|i| fresnel::conductor(cos, eta[i], k[i])))
}

/// The mean over the cosine-weighted hemisphere.
fn mean_reflectance(eta: Spectrum, k: Spectrum) -> Spectrum {
    const STEPS: u32 = 256;
    let cosines = (0..STEPS).map(|n| ((n as f32 + 0.5) / STEPS as f32).sqrt());
    cosines.fold(Spectrum::BLACK, |sum, c| sum + reflectance(eta, k, c)) / STEPS as f32
}
