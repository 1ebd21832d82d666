//! Pictures on surfaces.

use super::mapping::UvMapping;
use crate::id::BitmapId;
use crate::problem::{Place, SceneProblem};

/// A picture on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageTexture {
    /// Its pixels.
    pub bitmap: BitmapId,
    /// What their codes mean.
    pub encoding: Encoding,
    /// What there is beyond the picture's edges, along u and along v.
    pub wrap: [Wrap; 2],
    /// What there is between its pixels.
    pub interpolation: Interpolation,
    /// From the surface's texture coordinates to the picture's.
    pub mapping: UvMapping,
}

/// What codes of 8 or 16 bits mean. Opacity is never encoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Encoding {
    /// Colours, encoded as sRGB. Floating-point pixels are light already.
    Srgb,
    /// Numbers: roughness, normals, heights.
    Linear,
}

/// What there is beyond the edges of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// The picture again.
    Repeat,
    /// The picture mirrored, and again as it is.
    Mirror,
    /// Its edge.
    Clamp,
}

/// What there is between the pixels of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Interpolation {
    /// What the four around it say.
    Bilinear,
    /// What the nearest one says, however near one looks: squares.
    Nearest,
}

impl ImageTexture {
    /// A picture of colours, repeated.
    pub fn new(bitmap: BitmapId) -> Self {
        Self {
            bitmap,
            encoding: Encoding::Srgb,
            wrap: [Wrap::Repeat; 2],
            interpolation: Interpolation::Bilinear,
            mapping: UvMapping::default(),
        }
    }

    pub(super) fn validate(&self, place: Place, bitmaps: usize) -> Result<(), SceneProblem> {
        if self.bitmap.0 as usize >= bitmaps {
            let what = format!("there is no bitmap number {}", self.bitmap.0);
            return Err(place.problem("image", what));
        }
        self.mapping.validate(place)
    }
}

impl Wrap {
    /// A coordinate of any size within the picture, 0 to 1. What is no number is 0.
    pub(super) fn within(self, x: f32) -> f32 {
        let x = if x.is_finite() { x } else { 0.0 };
        match self {
            Self::Repeat => x - x.floor(),
            Self::Mirror => {
                let back = x - 2.0 * (0.5 * x).floor();
                if back > 1.0 { 2.0 - back } else { back }
            }
            Self::Clamp => x.clamp(0.0, 1.0),
        }
    }

    /// The texels, of `count` in a row, whose middles are before and after `x`, 0 to `count`, and
    /// how far it is from the first to the second.
    #[inline]
    pub(super) fn neighbours(self, x: f32, count: u32) -> ([u32; 2], f32) {
        let last = count - 1;
        let x = x - 0.5;
        let (before, after) = match self {
            Self::Repeat => (last, 0),
            Self::Mirror | Self::Clamp => (0, last),
        };
        if x < 0.0 {
            return ([before, 0], x + 1.0);
        }
        let i = (x as u32).min(last);
        ([i, if i < last { i + 1 } else { after }], x - i as f32)
    }
}
