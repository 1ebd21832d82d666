//! Light that a surface gives by itself.

use crate::color::Rgb;
use crate::problem::{LIGHT, Place, SceneProblem};

/// The light of a lamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emission {
    /// How much.
    pub light: EmittedLight,
    /// Whether the back, where the normal points away from, gives light as well.
    pub two_sided: bool,
}

/// An amount of light, the same in every direction and at every point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EmittedLight {
    /// Radiance in W/(m² sr), per channel.
    Radiance(Rgb),
    /// Power in W, per channel, of each object with the material as a whole (both sides together).
    Power(Rgb),
}

impl Emission {
    /// A radiance, on the front only.
    pub fn radiance(radiance: Rgb) -> Self {
        Self { light: EmittedLight::Radiance(radiance), two_sided: false }
    }

    pub(super) fn validate(&self, place: Place) -> Result<(), SceneProblem> {
        match self.light {
            EmittedLight::Radiance(rgb) => place.check("radiance", rgb.0, LIGHT),
            EmittedLight::Power(rgb) => place.check("power", rgb.0, LIGHT),
        }
    }
}
