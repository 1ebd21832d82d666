//! Truevision TGA: pictures of older programs, with runs of equal pixels or without.
//!
//! Source: Truevision, *TGA File Format Specification*, version 2.0, 1991.

use super::check;
use super::codes::Codes;
use crate::limits::Limits;
use ::image::ImageDecoder;
use ::image::codecs::tga::TgaDecoder;
use std::io::Cursor;

/// A run of 128 pixels takes two bytes where a pixel has one.
const EXPANSION: u64 = 64;

pub(super) fn read(bytes: &[u8], limits: &Limits) -> Result<Codes, String> {
    // The size stands at a fixed place, so it is checked before any decoder runs.
    let side =
        |at: usize| Some(u64::from(u16::from_le_bytes(*bytes.get(at..at + 2)?.first_chunk()?)));
    let (Some(width), Some(height)) = (side(12), side(14)) else {
        return Err("the file ends in its header".to_owned());
    };
    check::size(width, height, limits, 1, bytes.len(), EXPANSION)?;
    let mut decoder = TgaDecoder::new(Cursor::new(bytes)).map_err(|e| e.to_string())?;
    let mut allowed = ::image::Limits::no_limits();
    allowed.max_alloc = Some((1 << 20) + width * height * 16);
    decoder.set_limits(allowed).map_err(|e| e.to_string())?;
    Codes::decoded(decoder)
}
