//! What every BSDF draws.

use crate::color::Spectrum;
use rutilant_geom::Vec3;

/// A direction that light may have come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// The direction, a unit vector in the shading frame.
    pub wi: Vec3,
    /// `f(wo, wi) |cos θi| / pdf`: what the light from `wi` is worth.
    pub weight: Spectrum,
    /// The density of `wi` in 1/sr; for a delta, the probability of having chosen it.
    pub pdf: f32,
    /// True when no other method could have found this direction.
    pub delta: bool,
    /// Index of refraction on the side of `wi` over that on the side of `wo`; 1 for reflection.
    pub eta: f32,
}

impl BsdfSample {
    /// True when the light crossed the surface.
    pub fn is_transmission(&self, wo: Vec3) -> bool {
        self.wi.z * wo.z < 0.0
    }
}
