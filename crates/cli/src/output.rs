//! Image files: light as it is, or what a display shows of it.

use crate::options::{Bits, Channels};
use rayon::prelude::*;
use rutilant::display::Display;
use rutilant::image::Image;
use rutilant_formats::ImageError;
use rutilant_formats::image::{self, Format, Pixels, Precision, WriteOptions};
use std::path::Path;

/// What is stored of a picture, and how finely.
#[derive(Clone, Copy, Default)]
pub(crate) struct Detail {
    /// Bits of a number, where it is asked for. Each format takes the nearest it has.
    pub bits: Option<Bits>,
    /// Channels, where a format holds any.
    pub channels: Channels,
}

/// Writes `light` in the format that the extension of `path` names; `display` counts where that
/// format is for eyes.
pub(crate) fn write(
    path: &Path,
    light: &Image,
    display: &Display,
    detail: Detail,
    metadata: Vec<(String, String)>,
) -> Result<(), ImageError> {
    let format = Format::from_path(path)?;
    let precision = match detail.bits {
        Some(Bits::Eight | Bits::Sixteen) => Precision::Half,
        Some(Bits::ThirtyTwo) | None => Precision::Float,
    };
    let is_fine = format == Format::Png
        && match detail.bits {
            Some(Bits::Sixteen | Bits::ThirtyTwo) => true,
            Some(Bits::Eight) | None => false,
        };
    let options = WriteOptions { precision, metadata };
    let [width, height] = [light.width(), light.height()];
    let colors = if format.is_for_display() { light.rgb() } else { None };
    match (colors, detail.channels) {
        (Some(colors), _) if is_fine => {
            let rgb16: Vec<u16> =
                colors.par_iter().flat_map_iter(|c| display.encode_16(*c)).collect();
            image::write(path, Pixels::Display16 { width, height, rgb16: &rgb16 }, &options)
        }
        (Some(colors), _) => {
            let rgb8: Vec<u8> = colors.par_iter().flat_map_iter(|c| display.encode(*c)).collect();
            image::write(path, Pixels::Display { width, height, rgb8: &rgb8 }, &options)
        }
        (None, Channels::All) => image::write(path, light, &options),
        (None, Channels::Color) => {
            image::write(path, &light.only(|name| !name.contains('.')), &options)
        }
    }
}

/// True for files that hold more channels than those of a colour.
pub(crate) fn holds_layers(path: &Path) -> bool {
    Format::from_path(path).is_ok_and(Format::holds_layers)
}

/// True for files that hold light rather than what a display shows.
pub(crate) fn holds_light(path: &Path) -> bool {
    Format::from_path(path).is_ok_and(|format| !format.is_for_display())
}
