//! WebP: small pictures for the web, with or without loss. Of a moving one the first is read.
//!
//! Source: Zern, Massimino, Alakuijala, *WebP Image Format*, RFC 9649, 2024.

use super::check;
use super::codes::Codes;
use crate::limits::Limits;
use ::image::ImageDecoder;
use ::image::codecs::webp::WebPDecoder;
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
    Codes::decoded(decoder)
}
