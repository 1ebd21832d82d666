//! A perfect mirror: all light from one direction goes to one other.

use super::sample::BsdfSample;
use crate::color::Spectrum;
use rutilant_geom::Vec3;

/// Reflects the same part of the light at every angle, on both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PerfectMirror {
    /// The part reflected, 0 to 1.
    pub reflectance: Spectrum,
}

impl PerfectMirror {
    /// The one direction there is. `None` for a direction in the surface itself.
    pub fn sample(&self, wo: Vec3) -> Option<BsdfSample> {
        reflection(wo, self.reflectance)
    }
}

/// The mirrored direction with some weight, chosen with certainty.
pub(super) fn reflection(wo: Vec3, weight: Spectrum) -> Option<BsdfSample> {
    let wi = Vec3::new(-wo.x, -wo.y, wo.z);
    (wo.z != 0.0).then_some(BsdfSample { wi, weight, pdf: 1.0, delta: true, eta: 1.0 })
}
