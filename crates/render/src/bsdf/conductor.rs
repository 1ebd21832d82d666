//! Smooth metal: a mirror that brightens and loses its colour towards grazing angles.
//!
//! The reflected part follows from the metal's complex index of refraction by
//! the Fresnel equations, channel by channel.

use super::fresnel;
use super::mirror::reflection;
use super::sample::BsdfSample;
use crate::color::Spectrum;
use rutilant_geom::Vec3;

/// A smooth metal of index `eta + i k`, seen from a medium of index 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothConductor {
    /// Real part of the index of refraction.
    pub eta: Spectrum,
    /// Imaginary part of the index of refraction.
    pub k: Spectrum,
}

impl SmoothConductor {
    /// The one direction there is. `None` for a direction in the surface itself.
    pub fn sample(&self, wo: Vec3) -> Option<BsdfSample> {
        reflection(wo, self.reflectance(wo.z.abs()))
    }

    /// The part reflected at normal incidence.
    pub fn albedo(&self) -> Spectrum {
        self.reflectance(1.0)
    }

    fn reflectance(&self, cos: f32) -> Spectrum {
        let (eta, k) = (self.eta.channels(), self.k.channels());
        Spectrum::from(std::array::from_fn(|i| fresnel::conductor(cos, eta[i], k[i])))
    }
}
