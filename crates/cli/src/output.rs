//! Image files: light as it is, or what a display shows of it.

use rayon::prelude::*;
use rutilant::display::Display;
use rutilant::image::Image;
use rutilant_formats::ImageError;
use rutilant_formats::image::{self, Format, Pixels, WriteOptions};
use std::path::Path;

/// Writes `light` in the format that the extension of `path` names; `display` counts where that
/// format is for eyes.
pub(crate) fn write(
    path: &Path,
    light: &Image,
    display: &Display,
    options: &WriteOptions,
) -> Result<(), ImageError> {
    let colors = if Format::from_path(path)?.is_for_display() { light.rgb() } else { None };
    match colors {
        Some(colors) => {
            let rgb8: Vec<u8> = colors.par_iter().flat_map_iter(|c| display.encode(*c)).collect();
            let [width, height] = [light.width(), light.height()];
            image::write(path, Pixels::Display { width, height, rgb8: &rgb8 }, options)
        }
        None => image::write(path, light, options),
    }
}

/// True for files that hold light rather than what a display shows.
pub(crate) fn holds_light(path: &Path) -> bool {
    Format::from_path(path).is_ok_and(|format| !format.is_for_display())
}
