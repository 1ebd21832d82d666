//! A smooth border between two clear media: glass, water.
//!
//! Light is reflected with the probability that the Fresnel equations give and
//! refracted by Snell's law otherwise, so that every sample weighs the same.
//! Radiance that enters a denser medium is squeezed into a smaller cone and
//! grows by the square of the index; it loses as much when it leaves.
//!
//! Source: Pharr, Jakob, Humphreys, *Physically Based Rendering*, 4th ed.,
//! sections 9.3 and 9.5; Veach 1997, section 5.2.

use super::fresnel::Fresnel;
use super::mirror::reflection;
use super::sample::BsdfSample;
use crate::color::Spectrum;
use rutilant_geom::Vec3;

/// A smooth border. The interior is below: where z is negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothDielectric {
    /// Index of refraction below over that above.
    pub eta: f32,
    /// How the reflected part is computed.
    pub fresnel: Fresnel,
}

impl SmoothDielectric {
    /// Draws reflection or refraction; `choice` in [0, 1) decides. `None` for a direction in the
    /// surface itself.
    pub fn sample(&self, wo: Vec3, choice: f32) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        // Equal indices: there is no border, to the last bit.
        if self.eta == 1.0 {
            let weight = Spectrum::WHITE;
            return Some(BsdfSample { wi: -wo, weight, pdf: 1.0, delta: true, eta: 1.0 });
        }
        let eta = if wo.z > 0.0 { self.eta } else { 1.0 / self.eta };
        let (reflected, cos_t) = self.fresnel.dielectric(wo.z.abs(), eta);
        if choice < reflected {
            return Some(BsdfSample { pdf: reflected, ..reflection(wo, Spectrum::WHITE)? });
        }
        let along = -1.0 / eta;
        let wi = Vec3::new(wo.x * along, wo.y * along, -cos_t.copysign(wo.z)).normalize();
        let weight = Spectrum::splat(1.0 / (eta * eta));
        (wi.z != 0.0).then_some(BsdfSample { wi, weight, pdf: 1.0 - reflected, delta: true, eta })
    }
}
