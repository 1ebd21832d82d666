//! What to write, and how.

use rutilant::image::Image;

/// What to write.
#[derive(Clone, Copy, Debug)]
pub enum Pixels<'a> {
    /// Scene-linear light, in named channels: for `.exr`, `.hdr` and `.pfm`.
    Light(&'a Image),
    /// Colours encoded for a display: for `.png` and `.jpg`.
    Display {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
        /// (height, width, 3): red, green and blue, row 0 on top, encoded as sRGB.
        rgb8: &'a [u8],
    },
    /// The same in 16 bits: for `.png`.
    Display16 {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
        /// (height, width, 3): red, green and blue, row 0 on top, encoded as sRGB.
        rgb16: &'a [u16],
    },
}

impl Pixels<'_> {
    pub(super) fn size(&self) -> (u32, u32) {
        match *self {
            Self::Light(image) => (image.width(), image.height()),
            Self::Display { width, height, .. } | Self::Display16 { width, height, .. } => {
                (width, height)
            }
        }
    }
}

impl<'a> From<&'a Image> for Pixels<'a> {
    fn from(image: &'a Image) -> Self {
        Self::Light(image)
    }
}

/// How to write.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct WriteOptions {
    /// How `.exr` stores numbers.
    pub precision: Precision,
    /// Names and texts to keep with the image, "spp" and "64" for example. `.exr` stores each as
    /// an attribute, `.hdr` as a comment, the others not at all.
    pub metadata: Vec<(String, String)>,
}

/// How `.exr` stores numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// 32 bits: every value as it is.
    #[default]
    Float,
    /// 16 bits: about three digits. Finite values beyond ±65504 become that. Channels of the
    /// layers `variance`, `depth`, `position` and `uv`, ids and Cryptomatte keep 32: they would lose
    /// what they are for.
    Half,
}
