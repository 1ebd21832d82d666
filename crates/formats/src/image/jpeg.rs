//! JPEG: photographs, with loss.
//!
//! The decoder's variants for particular processors are switched off, so that
//! a texture has the same bits on every machine. Colour profiles and the
//! orientation in EXIF data are not looked at.
//!
//! Source: ITU-T T.81, 1992; JFIF 1.02.

use super::check;
use super::codes::{Codes, Samples};
use crate::limits::Limits;
use ::image::ExtendedColorType;
use ::image::codecs::jpeg::JpegEncoder;
use zune_core::bytestream::ZCursor;
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;
use zune_jpeg::JpegDecoder;

/// What is seen of a picture, not what is measured: little is lost, at a tenth of the size.
const QUALITY: u8 = 92;

/// A block of 8x8 samples takes a bit and a half at least, with coefficients in runs of blocks;
/// chroma stored at a quarter of the size makes that many more pixels of it.
const EXPANSION: u64 = 4096;

pub(super) fn read(bytes: &[u8], limits: &Limits) -> Result<Codes, String> {
    // Decoders fill in grey for what is missing. A scan must be followed by the end of the image;
    // neither marker can occur within one.
    let last = |marker: u8| bytes.windows(2).rposition(|pair| pair == [0xff, marker]);
    let (scan, end) = (last(0xda), last(0xd9));
    if scan.is_none() || end < scan {
        return Err("the file ends before its picture does".to_owned());
    }

    let options = DecoderOptions::default()
        .set_use_unsafe(false)
        .set_strict_mode(false)
        .set_max_width(usize::from(u16::MAX))
        .set_max_height(usize::from(u16::MAX));
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(|e| e.to_string())?;
    let (width, height) = decoder.dimensions().ok_or("the header has no size")?;
    check::size(width as u64, height as u64, limits, 3, bytes.len(), EXPANSION)?;
    let (color, channels) = match decoder.input_colorspace() {
        Some(ColorSpace::Luma) => (ColorSpace::Luma, 1),
        _ => (ColorSpace::RGB, 3),
    };
    decoder.set_options(options.jpeg_set_out_colorspace(color));
    let pixels = decoder.decode().map_err(|e| e.to_string())?;
    let (width, height) = (width as u32, height as u32);
    Ok(Codes { width, height, channels, samples: Samples::Eight(pixels) })
}

/// Refuses sizes that the format has no room for.
pub(super) fn check_size(width: u32, height: u32) -> Result<(), String> {
    let most = u32::from(u16::MAX);
    if width > most || height > most {
        return Err(format!("{width}x{height} is too large for a JPEG, which ends at {most}"));
    }
    Ok(())
}

pub(super) fn write(width: u32, height: u32, rgb8: &[u8]) -> Result<Vec<u8>, String> {
    check_size(width, height)?;
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, QUALITY)
        .encode(rgb8, width, height, ExtendedColorType::Rgb8)
        .map_err(|e| e.to_string())?;
    Ok(bytes)
}
