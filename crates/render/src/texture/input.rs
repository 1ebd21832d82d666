//! What a material takes: a number or a colour, the same everywhere or varied by a texture.

use crate::color::Rgb;
use crate::id::TextureId;
use crate::problem::{Place, SceneProblem};
use std::ops::RangeInclusive;

/// A colour for each place of a surface: the product of what it is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColorInput {
    /// The same everywhere.
    pub factor: Rgb,
    /// Varies over the surface.
    pub texture: Option<TextureId>,
    /// The colours of the mesh's vertices count as well; white where it has none.
    pub vertex_colors: bool,
}

impl ColorInput {
    /// Whether it is another in different places.
    pub fn varies(&self) -> bool {
        self.texture.is_some() || self.vertex_colors
    }

    pub(crate) fn validate(
        &self,
        place: Place,
        key: &'static str,
        range: RangeInclusive<f32>,
        textures: usize,
    ) -> Result<(), SceneProblem> {
        place.check(key, self.factor.0, range)?;
        check_texture(place, key, self.texture, textures)
    }
}

impl From<Rgb> for ColorInput {
    fn from(factor: Rgb) -> Self {
        Self { factor, texture: None, vertex_colors: false }
    }
}

impl From<TextureId> for ColorInput {
    fn from(texture: TextureId) -> Self {
        Self { factor: Rgb::WHITE, texture: Some(texture), vertex_colors: false }
    }
}

/// A number for each place of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScalarInput {
    /// The same everywhere.
    pub factor: f32,
    /// Varies over the surface: a texture's channel.
    pub texture: Option<(TextureId, Channel)>,
}

impl ScalarInput {
    pub(crate) fn validate(
        &self,
        place: Place,
        key: &'static str,
        range: RangeInclusive<f32>,
        textures: usize,
    ) -> Result<(), SceneProblem> {
        place.check(key, [self.factor], range)?;
        check_texture(place, key, self.texture.map(|(id, _)| id), textures)
    }
}

impl From<f32> for ScalarInput {
    fn from(factor: f32) -> Self {
        Self { factor, texture: None }
    }
}

/// A channel of a texture. A grey picture has the same value in red, green and blue; one without
/// opacity is opaque.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "each is named after what it is")]
pub enum Channel {
    Red,
    Green,
    Blue,
    Alpha,
    /// What red lacks to 1; so with the others: gloss as roughness, transparency as opacity.
    InverseRed,
    InverseGreen,
    InverseBlue,
    InverseAlpha,
}

impl Channel {
    /// Its value of `rgba`.
    pub(crate) fn of(self, rgba: [f32; 4]) -> f32 {
        let [r, g, b, a] = rgba;
        match self {
            Self::Red => r,
            Self::Green => g,
            Self::Blue => b,
            Self::Alpha => a,
            Self::InverseRed => 1.0 - r,
            Self::InverseGreen => 1.0 - g,
            Self::InverseBlue => 1.0 - b,
            Self::InverseAlpha => 1.0 - a,
        }
    }
}

fn check_texture(
    place: Place,
    key: &'static str,
    texture: Option<TextureId>,
    textures: usize,
) -> Result<(), SceneProblem> {
    match texture {
        Some(id) if id.0 as usize >= textures => {
            Err(place.problem(key, format!("there is no texture number {}", id.0)))
        }
        Some(_) | None => Ok(()),
    }
}
