//! What must be true before pixels are made of a file, or a file of pixels.

use crate::limits::Limits;
use rutilant::image::Image;

/// Checks the size that a header states, before memory is taken for it.
///
/// `bytes` are present for the pixels, and the format's best compression makes
/// `expansion` of one. `pixel_bytes` is what a pixel takes when decoded.
pub(super) fn size(
    width: u64,
    height: u64,
    limits: &Limits,
    pixel_bytes: u64,
    bytes: usize,
    expansion: u64,
) -> Result<(), String> {
    if width == 0 || height == 0 {
        return Err(format!("the image has {width}x{height} pixels"));
    }
    let pixels = width.saturating_mul(height);
    if pixels > limits.pixels {
        let allowed = limits.pixels;
        return Err(format!(
            "{width}x{height} are {pixels} pixels, but at most {allowed} are allowed{}",
            Limits::hint("pixels")
        ));
    }
    // What small files gain by tables and headers is not worth counting.
    const FREE: u64 = 1 << 16;
    let most = (bytes as u64).saturating_mul(expansion).saturating_add(FREE);
    if pixels.saturating_mul(pixel_bytes) > most {
        return Err(format!("{width}x{height} pixels are declared, but only {bytes} bytes follow"));
    }
    Ok(())
}

/// The image's colours, for formats that hold nothing else.
pub(super) fn colors(image: &Image) -> Result<Vec<[f32; 3]>, String> {
    image.rgb().ok_or_else(|| "the image has no channels R, G and B, nor Y".to_owned())
}
