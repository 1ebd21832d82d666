//! Values that vary over a surface.
//!
//! A [`Texture`] gives a colour and an opacity for a place on a surface; materials take it as a
//! factor by a [`ColorInput`] or a [`ScalarInput`]. Images are averaged into ever smaller ones
//! beforehand (`pyramid.rs`), and the one is looked at whose texels are about as large as what a
//! pixel sees of the surface.
//!
//! Texture coordinates run from (0, 0) at the lower left corner of an image to (1, 1) at the upper
//! right one, as in OBJ, Blender and Mitsuba.

mod bitmap;
mod bricks;
mod checker;
mod image;
mod input;
mod mapping;
mod noise;
mod pyramid;

pub use bitmap::{Bitmap, Texels};
pub use bricks::Bricks;
pub use checker::Checker;
pub use image::{Encoding, ImageTexture, Interpolation, Wrap};
pub use input::{Channel, ColorInput, ScalarInput};
pub(crate) use mapping::PreparedMapping;
pub use mapping::UvMapping;
pub use noise::Noise;
pub(crate) use pyramid::{Footprint, Pyramid};

use crate::problem::{Place, SceneProblem};
use std::sync::Arc;

/// A value that varies over a surface.
#[derive(Clone, Debug, PartialEq)]
pub enum Texture {
    /// From a picture.
    Image(ImageTexture),
    /// Squares of two colours.
    Checker(Checker),
    /// Bricks between joints.
    Bricks(Bricks),
    /// A random pattern.
    Noise(Noise),
}

impl Texture {
    /// How it lies on a surface.
    pub(crate) fn mapping(&self) -> &UvMapping {
        match self {
            Self::Image(image) => &image.mapping,
            Self::Checker(checker) => &checker.mapping,
            Self::Bricks(bricks) => &bricks.mapping,
            Self::Noise(noise) => &noise.mapping,
        }
    }

    pub(crate) fn validate(
        &self,
        index: usize,
        bitmaps: &[Arc<Bitmap>],
    ) -> Result<(), SceneProblem> {
        let place = Place::Texture(index);
        match self {
            Self::Image(image) => image.validate(place, bitmaps.len()),
            Self::Checker(checker) => checker.validate(place),
            Self::Bricks(bricks) => bricks.validate(place),
            Self::Noise(noise) => noise.validate(place),
        }
    }
}

impl From<ImageTexture> for Texture {
    fn from(image: ImageTexture) -> Self {
        Self::Image(image)
    }
}

impl From<Checker> for Texture {
    fn from(checker: Checker) -> Self {
        Self::Checker(checker)
    }
}

impl From<Bricks> for Texture {
    fn from(bricks: Bricks) -> Self {
        Self::Bricks(bricks)
    }
}

impl From<Noise> for Texture {
    fn from(noise: Noise) -> Self {
        Self::Noise(noise)
    }
}
