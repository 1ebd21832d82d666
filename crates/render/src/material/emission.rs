//! Light that a surface gives by itself.

use crate::color::Rgb;
use crate::id::TextureId;
use crate::problem::{LIGHT, Place, SceneProblem};

/// The light of a lamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emission {
    /// How much.
    pub light: EmittedLight,
    /// Varies over the surface, and is a factor on it. Light that varies is found by scattered rays
    /// alone, not by light sampling.
    pub texture: Option<TextureId>,
    /// Whether the back, where the normal points away from, gives light as well.
    pub two_sided: bool,
}

/// An amount of light, the same in every direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EmittedLight {
    /// Radiance in W/(m² sr), per channel.
    Radiance(Rgb),
    /// Power in W, per channel, of each object with the material as a whole (both sides together);
    /// with a texture it is that of a white one.
    Power(Rgb),
}

impl Emission {
    /// A radiance, on the front only.
    pub fn radiance(radiance: Rgb) -> Self {
        Self { light: EmittedLight::Radiance(radiance), texture: None, two_sided: false }
    }

    pub(super) fn validate(&self, place: Place, textures: usize) -> Result<(), SceneProblem> {
        if let Some(id) = self.texture.filter(|id| id.0 as usize >= textures) {
            return Err(place.problem("texture", format!("there is no texture number {}", id.0)));
        }
        match self.light {
            EmittedLight::Radiance(rgb) => place.check("radiance", rgb.0, LIGHT),
            EmittedLight::Power(rgb) => place.check("power", rgb.0, LIGHT),
        }
    }
}
