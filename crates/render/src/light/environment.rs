//! Light from infinitely far away, in all directions: a sky.

use crate::color::Rgb;
use crate::image::Image;
use crate::scene::{FINITE, ImageId, NOT_NEGATIVE, Place, SceneProblem};

/// A sky as the author describes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Environment {
    /// Its radiance.
    pub light: EnvironmentLight,
    /// A factor on the radiance, 0 or more.
    pub scale: f32,
    /// Turns the sky around +y, in radians, counter-clockwise seen from above.
    pub rotation: f32,
}

/// The radiance of a sky in W/(m² sr).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EnvironmentLight {
    /// The same in every direction.
    Constant(Rgb),
    /// A latitude-longitude map: its upper edge is +y, its middle −z, +x lies to the right of that.
    Image(ImageId),
}

impl Environment {
    /// The same radiance in every direction.
    pub fn constant(radiance: Rgb) -> Self {
        Self { light: EnvironmentLight::Constant(radiance), scale: 1.0, rotation: 0.0 }
    }

    /// A latitude-longitude map as it is.
    pub fn image(id: ImageId) -> Self {
        Self { light: EnvironmentLight::Image(id), scale: 1.0, rotation: 0.0 }
    }

    pub(crate) fn validate(&self, images: &[Image]) -> Result<(), SceneProblem> {
        let place = Place::Environment;
        place.check("scale", [self.scale], NOT_NEGATIVE)?;
        place.check("rotation_degrees", [self.rotation], FINITE)?;
        match self.light {
            EnvironmentLight::Constant(rgb) => place.check("color", rgb.0, NOT_NEGATIVE),
            EnvironmentLight::Image(id) => match images.get(id.0 as usize) {
                None => Err(place.problem("image", format!("there is no image number {}", id.0))),
                Some(image) if image.width() == 0 || image.height() == 0 => {
                    Err(place.problem("image", "the image has no pixels"))
                }
                Some(image) if image.rgb().is_none() => {
                    Err(place.problem("image", "the image has no channels R, G, B (or Y)"))
                }
                Some(_) => Ok(()),
            },
        }
    }
}
