//! PNG: colours for displays, without loss.
//!
//! Everything is taken as sRGB, as nearly all files are; `gAMA`, `cHRM` and
//! colour profiles are not looked at.
//!
//! Source: *Portable Network Graphics Specification*, 3rd ed., W3C, 2025.

use super::check;
use super::srgb::{self, Samples};
use crate::limits::Limits;
use ::image::codecs::png::{CompressionType, FilterType, PngDecoder, PngEncoder};
use ::image::{ColorType, ExtendedColorType, ImageDecoder, ImageEncoder};
use rutilant::image::Image;
use std::io::Cursor;

/// Deflate makes at most 1032 bytes of one; a bit per pixel becomes a byte.
const EXPANSION: u64 = 8 * 1032;

/// What the decoder may take for text, profiles and rows beside the pixels.
const WORKSPACE: u64 = 64 << 20;

pub(super) fn read(bytes: &[u8], limits: &Limits) -> Result<Image, String> {
    // The size stands at a fixed place, so it is checked before any decoder runs.
    let size = |at: usize| {
        let bytes = bytes.get(at..at + 4)?.first_chunk::<4>()?;
        Some(u64::from(u32::from_be_bytes(*bytes)))
    };
    let (Some(width), Some(height)) = (size(16), size(20)) else {
        return Err("the file ends in its header".to_owned());
    };
    check::size(width, height, limits, 1, bytes.len(), EXPANSION)?;

    let mut allowed = ::image::Limits::no_limits();
    allowed.max_alloc = Some(WORKSPACE.saturating_add(width * height * 8));
    let decoder =
        PngDecoder::with_limits(Cursor::new(bytes), allowed).map_err(|e| e.to_string())?;
    let (width, height) = decoder.dimensions();
    let color = decoder.color_type();
    check::size(width.into(), height.into(), limits, 1, bytes.len(), EXPANSION)?;
    let channels = usize::from(color.channel_count());
    let total = usize::try_from(decoder.total_bytes()).map_err(|e| e.to_string())?;
    let mut buffer = vec![0; total];
    decoder.read_image(&mut buffer).map_err(|e| e.to_string())?;

    let words: Vec<u16>;
    let samples = match color {
        ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8 => {
            Samples::Eight(&buffer)
        }
        ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => {
            words = buffer.as_chunks::<2>().0.iter().map(|&w| u16::from_ne_bytes(w)).collect();
            Samples::Sixteen(&words)
        }
        _ => return Err(format!("pixels of type {color:?} are not read")),
    };
    srgb::image(width, height, channels, samples).ok_or_else(|| "no such channels".to_owned())
}

pub(super) fn write(width: u32, height: u32, rgb8: &[u8]) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive)
        .write_image(rgb8, width, height, ExtendedColorType::Rgb8)
        .map_err(|e| e.to_string())?;
    Ok(bytes)
}
