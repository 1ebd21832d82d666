//! WebP: small pictures for the web, with or without loss. Of a moving one the first is read.
//!
//! Source: Zern, Massimino, Alakuijala, *WebP Image Format*, RFC 9649, 2024.

use super::check;
use super::codes::{Codes, Samples};
use crate::limits::Limits;
use ::image::codecs::webp::WebPDecoder;
use ::image::{ColorType, ImageDecoder};
use std::io::Cursor;

/// A picture of one colour takes some thirty bytes, whatever its size; more than 4096 pixels on each
/// side of nothing else are not believed.
const EXPANSION: u64 = 1 << 21;

pub(super) fn read(bytes: &[u8], limits: &Limits) -> Result<Codes, String> {
    let mut decoder = WebPDecoder::new(Cursor::new(bytes)).map_err(|e| e.to_string())?;
    let (width, height) = decoder.dimensions();
    check::size(width.into(), height.into(), limits, 3, bytes.len(), EXPANSION)?;
    let mut allowed = ::image::Limits::no_limits();
    allowed.max_alloc = Some((64 << 20) + u64::from(width) * u64::from(height) * 16);
    decoder.set_limits(allowed).map_err(|e| e.to_string())?;
    let channels = match decoder.color_type() {
        ColorType::Rgb8 => 3,
        ColorType::Rgba8 => 4,
        other => return Err(format!("pixels of type {other:?} are not read")),
    };
    let total = usize::try_from(decoder.total_bytes()).map_err(|e| e.to_string())?;
    let mut buffer = vec![0; total];
    decoder.read_image(&mut buffer).map_err(|e| e.to_string())?;
    Ok(Codes { width, height, channels, samples: Samples::Eight(buffer) })
}
