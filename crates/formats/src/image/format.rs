//! The formats of images, and how a file shows which one it has.

use crate::error::ImageError;
use crate::file;
use std::path::Path;

/// One extension of each format, for people.
const KNOWN: [&str; 7] = ["exr", "hdr", "pfm", "png", "jpg", "webp", "tga"];

/// Those that are read, and not written.
const ONLY_READ: [&str; 2] = ["webp", "tga"];

/// An image format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// OpenEXR.
    Exr,
    /// Radiance RGBE.
    Hdr,
    /// Portable float map.
    Pfm,
    /// Portable network graphics.
    Png,
    /// JPEG.
    Jpeg,
    /// WebP, which is only read.
    WebP,
    /// Truevision TGA, which is only read. Nothing at the beginning of a file shows it.
    Tga,
}

impl Format {
    /// The format that the extension of `path` names.
    ///
    /// # Errors
    /// An extension that is not known.
    pub fn from_path(path: &Path) -> Result<Self, ImageError> {
        Ok(match &*file::extension(path) {
            "exr" => Self::Exr,
            "hdr" | "rgbe" | "pic" => Self::Hdr,
            "pfm" => Self::Pfm,
            "png" => Self::Png,
            "jpg" | "jpeg" => Self::Jpeg,
            "webp" => Self::WebP,
            "tga" => Self::Tga,
            _ => {
                let what = file::unknown_format("image", path, KNOWN);
                return Err(ImageError::new(path, what));
            }
        })
    }

    /// The same for a file that is to be written.
    pub(super) fn to_write(path: &Path) -> Result<Self, ImageError> {
        let format = Self::from_path(path);
        if let Ok(format @ (Self::WebP | Self::Tga)) = format {
            let what = format!(".{} is read, but not written: write .png", format.extension());
            return Err(ImageError::new(path, what));
        }
        format.map_err(|_| {
            let written = KNOWN.into_iter().filter(|name| !ONLY_READ.contains(name));
            ImageError::new(path, file::unknown_format("image", path, written))
        })
    }

    /// The usual extension of its files.
    pub(crate) fn extension(self) -> &'static str {
        match self {
            Self::Exr => "exr",
            Self::Hdr => "hdr",
            Self::Pfm => "pfm",
            Self::Png => "png",
            Self::Jpeg => "jpg",
            Self::WebP => "webp",
            Self::Tga => "tga",
        }
    }

    /// Whether files of this format hold colours encoded for a display rather than light: what
    /// [`write()`](super::write()) wants as [`Pixels::Display`](super::Pixels::Display).
    pub fn is_for_display(self) -> bool {
        match self {
            Self::Exr | Self::Hdr | Self::Pfm => false,
            Self::Png | Self::Jpeg | Self::WebP | Self::Tga => true,
        }
    }

    /// Whether files of this format hold more channels than those of a colour.
    pub fn holds_layers(self) -> bool {
        self == Self::Exr
    }

    /// The format that the first bytes of a file show.
    pub(crate) fn from_bytes(bytes: &[u8]) -> Option<Self> {
        Some(match bytes {
            [0x76, 0x2f, 0x31, 0x01, ..] => Self::Exr,
            [b'#', b'?', ..] => Self::Hdr,
            [b'P', b'F' | b'f', b'\n' | b'\r' | b' ' | b'\t', ..] => Self::Pfm,
            [0x89, b'P', b'N', b'G', ..] => Self::Png,
            [0xff, 0xd8, 0xff, ..] => Self::Jpeg,
            [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Self::WebP,
            _ => return None,
        })
    }
}
