//! Portable float map: three words of header, then floats, bottom row first.
//!
//! The sign of the header's last number is the byte order. Its size is a scale
//! that programs disagree about; it is not applied.
//!
//! Source: Debevec, *PFM Portable FloatMap Image Format*; Netpbm's `pfm(5)`.

use super::check;
use crate::limits::Limits;
use crate::shown::shown;
use rutilant::image::{Channel, Image};

pub(super) fn read(bytes: &[u8], limits: &Limits) -> Result<Image, String> {
    let mut at = 0;
    let mut word = |what: &str| {
        let rest = bytes.get(at..).unwrap_or_default();
        let start = rest.iter().take_while(|b| b.is_ascii_whitespace()).count();
        let word = rest[start..].split(u8::is_ascii_whitespace).next().unwrap_or_default();
        at += start + word.len();
        match std::str::from_utf8(word) {
            Ok(text) if !text.is_empty() => Ok(text),
            _ => Err(format!("the header has no {what}")),
        }
    };
    let names: &[&str] = match word("\"PF\" or \"Pf\"")? {
        "PF" => &["R", "G", "B"],
        "Pf" => &["Y"],
        _ => return Err("this is not a PFM file: it begins with neither PF nor Pf".to_owned()),
    };
    let mut number = |what: &str| {
        let word = word(what)?;
        word.parse::<u32>().map_err(|_| format!("\"{}\" is not a {what}", shown(word)))
    };
    let (width, height) = (number("width")?, number("height")?);
    let scale = word("scale")?;
    let scale = match scale.parse::<f32>() {
        Ok(scale) if scale != 0.0 && scale.is_finite() => scale,
        _ => return Err(format!("\"{}\" is not a scale", shown(scale))),
    };
    // Exactly one blank, and the floats begin.
    let floats = bytes.get(at + 1..).unwrap_or_default();
    let pixel_bytes = 4 * names.len() as u64;
    check::size(width.into(), height.into(), limits, 0, 0, 0)?;
    let needed = (u64::from(width) * u64::from(height)).saturating_mul(pixel_bytes);
    if (floats.len() as u64) < needed {
        let (there, row) = (floats.len() as u64, u64::from(width) * pixel_bytes);
        return Err(format!("the file ends after {} of {height} rows", there / row));
    }

    let (width, height) = (width as usize, height as usize);
    let (floats, _) = floats.as_chunks::<4>();
    let channel = |(c, name): (usize, &&str)| Channel {
        name: (*name).to_owned(),
        values: (0..height)
            .rev()
            .flat_map(|row| (0..width).map(move |x| (row * width + x) * names.len() + c))
            .map(|i| {
                if scale < 0.0 {
                    f32::from_le_bytes(floats[i])
                } else {
                    f32::from_be_bytes(floats[i])
                }
            })
            .collect(),
    };
    let channels = names.iter().enumerate().map(channel).collect();
    Image::new(width as u32, height as u32, channels).ok_or_else(|| "too large".to_owned())
}

pub(super) fn write(image: &Image) -> Result<Vec<u8>, String> {
    let (width, height) = (image.width(), image.height());
    let is_grey = image.channel("Y").is_some();
    let pixels = check::colors(image)?;
    let kind = if is_grey { "Pf" } else { "PF" };
    let mut bytes = format!("{kind}\n{width} {height}\n-1.0\n").into_bytes();
    for row in pixels.chunks_exact(width as usize).rev() {
        for pixel in row {
            let values = if is_grey { &pixel[..1] } else { pixel };
            bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
        }
    }
    Ok(bytes)
}
