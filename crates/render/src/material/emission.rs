//! Light that a surface gives by itself.

use crate::color::Rgb;
use crate::id::TextureId;
use crate::light::LightGroup;
use crate::problem::{LIGHT, Place, SceneProblem};
use crate::texture::ColorInput;

/// The light of a lamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emission {
    /// How much.
    pub light: EmittedLight,
    /// Varies over the surface, and is a factor on it. Light that varies is found by scattered rays
    /// alone, not by light sampling.
    pub texture: Option<TextureId>,
    /// The colours of the mesh's vertices are a factor on it as well; white where it has none. Such
    /// light counts as light that varies.
    pub vertex_colors: bool,
    /// Whether the back, where the normal points away from, gives light as well.
    pub two_sided: bool,
    /// Where its light counts in a picture of light groups, but for objects that have a group of
    /// their own.
    pub group: Option<LightGroup>,
}

/// An amount of light, the same in every direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EmittedLight {
    /// Radiance in W/(m² sr), per channel.
    Radiance(Rgb),
    /// Power in W, per channel, of each object with the material as a whole (both sides together);
    /// with a texture or vertex colours it is that of white ones.
    Power(Rgb),
}

impl Emission {
    /// A radiance, on the front only.
    pub fn radiance(radiance: Rgb) -> Self {
        Self {
            light: EmittedLight::Radiance(radiance),
            texture: None,
            vertex_colors: false,
            two_sided: false,
            group: None,
        }
    }

    /// The same as one of this group.
    #[must_use]
    pub fn in_group(self, group: LightGroup) -> Self {
        Self { group: Some(group), ..self }
    }

    /// What its light varies by, if it does.
    pub(crate) fn variation(&self) -> Option<ColorInput> {
        let (texture, vertex_colors) = (self.texture, self.vertex_colors);
        let by = ColorInput { factor: Rgb::WHITE, texture, vertex_colors };
        by.varies().then_some(by)
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
