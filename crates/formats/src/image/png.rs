//! PNG: colours for displays, without loss.
//!
//! Everything is taken as sRGB unless a texture says otherwise, as nearly all files are; `gAMA`, `cHRM` and
//! colour profiles are not looked at. Nor are texts: compressed ones can be
//! bombs.
//!
//! Source: *Portable Network Graphics Specification*, 3rd ed., W3C, 2025.

use super::check;
use super::codes::{Codes, Samples};
use crate::limits::Limits;
use ::image::codecs::png::{CompressionType, FilterType, PngDecoder, PngEncoder};
use ::image::{DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder};
use rutilant::texture::{Bitmap, Texels};
use std::io::Cursor;

/// Deflate makes at most 1032 bytes of one; a bit per pixel becomes a byte.
const EXPANSION: u64 = 8 * 1032;

/// What the decoder may take for rows beside the pixels.
const WORKSPACE: u64 = 64 << 20;

pub(super) fn read(bytes: &[u8], limits: &Limits) -> Result<Codes, String> {
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
    let plain = without_extras(bytes);
    let decoder =
        PngDecoder::with_limits(Cursor::new(plain), allowed).map_err(|e| e.to_string())?;
    let (width, height) = decoder.dimensions();
    let color = decoder.color_type();
    check::size(width.into(), height.into(), limits, 1, bytes.len(), EXPANSION)?;
    let channels = usize::from(color.channel_count());

    // Unpacked to where they stay: there may be gigabytes.
    let samples = match DynamicImage::from_decoder(decoder).map_err(|e| e.to_string())? {
        DynamicImage::ImageLuma8(codes) => Samples::Eight(codes.into_raw()),
        DynamicImage::ImageLumaA8(codes) => Samples::Eight(codes.into_raw()),
        DynamicImage::ImageRgb8(codes) => Samples::Eight(codes.into_raw()),
        DynamicImage::ImageRgba8(codes) => Samples::Eight(codes.into_raw()),
        DynamicImage::ImageLuma16(codes) => Samples::Sixteen(codes.into_raw()),
        DynamicImage::ImageLumaA16(codes) => Samples::Sixteen(codes.into_raw()),
        DynamicImage::ImageRgb16(codes) => Samples::Sixteen(codes.into_raw()),
        DynamicImage::ImageRgba16(codes) => Samples::Sixteen(codes.into_raw()),
        _ => return Err(format!("pixels of type {color:?} are not read")),
    };
    Ok(Codes { width, height, channels, samples })
}

/// The file without chunks that its pixels do not need. Some of them are compressed, and a few
/// bytes of those can fill a machine: what nobody asks for is not unpacked.
fn without_extras(bytes: &[u8]) -> Vec<u8> {
    let (signature, mut rest) = bytes.split_at(bytes.len().min(8));
    let mut kept = Vec::with_capacity(bytes.len());
    kept.extend(signature);
    // A length, a name of four letters, so many bytes, a checksum.
    while let Some((length, after)) = rest.split_first_chunk::<4>() {
        let length = u32::from_be_bytes(*length) as usize;
        let Some((name, _)) = after.split_first_chunk::<4>() else { break };
        let Some((chunk, after)) = rest.split_at_checked(length.saturating_add(12)) else { break };
        // A capital letter first means that a picture cannot be made without it.
        if name[0].is_ascii_uppercase() || name == b"tRNS" {
            kept.extend(chunk);
        }
        rest = after;
    }
    // What is cut off is for the decoder to complain about.
    kept.extend(rest);
    kept
}

pub(super) fn write(width: u32, height: u32, rgb8: &[u8]) -> Result<Vec<u8>, String> {
    encode(width, height, rgb8, ExtendedColorType::Rgb8)
}

pub(super) fn write_16(width: u32, height: u32, rgb16: &[u16]) -> Result<Vec<u8>, String> {
    // The encoder wants the machine's byte order, and writes the file's.
    let bytes: Vec<u8> = rgb16.iter().flat_map(|word| word.to_ne_bytes()).collect();
    encode(width, height, &bytes, ExtendedColorType::Rgb16)
}

/// All values of a bitmap of codes, opacity among them.
pub(super) fn of_bitmap(bitmap: &Bitmap) -> Result<Vec<u8>, String> {
    let words: Vec<u8>;
    let (samples, colors): (&[u8], _) = match bitmap.texels() {
        Texels::Eight(codes) => {
            use ExtendedColorType::{L8, La8, Rgb8, Rgba8};
            (codes, [L8, La8, Rgb8, Rgba8])
        }
        Texels::Sixteen(codes) => {
            use ExtendedColorType::{L16, La16, Rgb16, Rgba16};
            words = codes.iter().flat_map(|word| word.to_ne_bytes()).collect();
            (&words, [L16, La16, Rgb16, Rgba16])
        }
        Texels::Float(_) => return Err("a PNG file holds no light".to_owned()),
    };
    let color = *colors.get(bitmap.channels().wrapping_sub(1)).ok_or("no such channels")?;
    encode(bitmap.width(), bitmap.height(), samples, color)
}

fn encode(
    width: u32,
    height: u32,
    samples: &[u8],
    color: ExtendedColorType,
) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive)
        .write_image(samples, width, height, color)
        .map_err(|e| e.to_string())?;
    Ok(bytes)
}
