//! Radiance HDR: three mantissas and a common exponent, a byte each.
//!
//! A pixel `r g b e` is `(r, g, b) · 2^(e − 136)`, as most programs read it
//! (Radiance itself adds half a step). `EXPOSURE` and `COLORCORR` are not
//! applied, as in most programs.
//!
//! Source: Ward, *Real Pixels*, Graphics Gems II, 1991; Radiance's
//! `src/common/color.c` for the two run-length codes.

use super::check;
use super::options::WriteOptions;
use crate::limits::Limits;
use crate::shown::quoted;
use rutilant::image::{Channel, Image};

type Rgbe = [u8; 4];

/// Runs of runs make the most of a byte: a scanline of 32767 equal pixels takes twelve.
const EXPANSION: u64 = 16384;

pub(super) fn read(bytes: &[u8], limits: &Limits) -> Result<Image, String> {
    // Lines of text up to an empty one, then the resolution.
    let mut lines = Lines { rest: bytes };
    let first = lines.next().ok_or("the header has no end")?;
    if !first.starts_with(b"#?") {
        return Err("this is not a Radiance file: it does not begin with \"#?\"".to_owned());
    }
    loop {
        let line = lines.next().ok_or("the header has no end")?;
        if line.is_empty() {
            break;
        }
        if let Some(format) = line.strip_prefix(b"FORMAT=")
            && format.trim_ascii() != b"32-bit_rle_rgbe"
        {
            let format = quoted(format.trim_ascii());
            return Err(format!("pixels in format {format} are not read, only 32-bit_rle_rgbe"));
        }
    }
    let line = lines.next().ok_or("the header has no resolution")?;
    let layout = Layout::parse(line)
        .ok_or_else(|| format!("{} is not a resolution like \"-Y 512 +X 1024\"", quoted(line)))?;
    let (width, height) = layout.size();
    check::size(width.into(), height.into(), limits, 4, lines.rest.len(), EXPANSION)?;

    // Scanlines, each of which may be coded in its own way. Memory grows with what is decoded.
    let mut rest = lines.rest;
    let mut pixels: Vec<Rgbe> = Vec::new();
    for i in 0..layout.lines {
        scanline(&mut rest, layout.length, &mut pixels).map_err(|trouble| match trouble {
            Trouble::End => format!("the file ends after {i} of {} scanlines", layout.lines),
            Trouble::Invalid => format!("scanline {i} of {} is not coded rightly", layout.lines),
        })?;
    }

    let mut channels = ["R", "G", "B"]
        .map(|name| Channel { name: name.to_owned(), values: Vec::with_capacity(pixels.len()) });
    for i in 0..pixels.len() {
        let pixel = if layout.is_usual() { pixels[i] } else { pixels[layout.source(i)] };
        for (channel, value) in channels.iter_mut().zip(decode(pixel)) {
            channel.values.push(value);
        }
    }
    Image::new(width, height, channels.into()).ok_or_else(|| "too large".to_owned())
}

pub(super) fn write(image: &Image, options: &WriteOptions) -> Result<Vec<u8>, String> {
    let (width, height) = (image.width(), image.height());
    let pixels = check::colors(image)?;
    let version = env!("CARGO_PKG_VERSION");
    let mut text = format!("#?RADIANCE\nSOFTWARE=Rutilant {version}\n");
    for (name, value) in &options.metadata {
        // A line end inside would end the header.
        let plain = |text: &str| text.replace(['\n', '\r'], " ");
        text.push_str(&format!("# {}: {}\n", plain(name), plain(value)));
    }
    text.push_str(&format!("FORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n"));
    let mut bytes = text.into_bytes();

    let mut line = Vec::new();
    for row in pixels.chunks_exact(width as usize) {
        line.clear();
        line.extend(row.iter().map(|&pixel| encode(pixel)));
        if RUN_LENGTH_CODED.contains(&width) {
            bytes.extend([2, 2, (width >> 8) as u8, width as u8]);
            for component in 0..4 {
                encode_runs(&line, component, &mut bytes);
            }
        } else {
            bytes.extend(line.iter().flatten());
        }
    }
    Ok(bytes)
}

/// The widths that the newer run-length code is for.
const RUN_LENGTH_CODED: std::ops::RangeInclusive<u32> = 8..=0x7fff;

/// The colour that a pixel stands for.
fn decode([r, g, b, e]: Rgbe) -> [f32; 3] {
    if e == 0 {
        return [0.0; 3];
    }
    // A power of two, exact in f64 for every exponent; the product fits f32 but for rounding
    // of what is subnormal there.
    let step = f64::from_bits((u64::from(e) + 1023 - 136) << 52);
    [r, g, b].map(|mantissa| (f64::from(mantissa) * step) as f32)
}

/// The nearest pixel. What has no place in it, negative values and NaN, becomes 0; too large ones
/// become the largest.
fn encode(color: [f32; 3]) -> Rgbe {
    let color = color.map(|c| if c > 0.0 { f64::from(c.min(f32::MAX)) } else { 0.0 });
    let largest = color[0].max(color[1]).max(color[2]);
    if largest < f64::from(f32::MIN_POSITIVE) {
        return [0; 4];
    }
    // The exponent with which the largest lies in 128 to 256.
    let mut exponent = (largest.to_bits() >> 52) as i32 - 1023 + 129;
    let mantissa = |c: f64, exponent: i32| {
        // Adding a half and cutting rounds to nearest.
        (c * f64::from_bits(((1023 + 136 - exponent) as u64) << 52) + 0.5) as u32
    };
    // Rounding may have carried it to 256.
    exponent += i32::from(mantissa(largest, exponent) > 255);
    if exponent < 1 {
        return [0; 4];
    }
    if exponent > 255 {
        exponent = 255;
    }
    let [r, g, b] = color.map(|c| mantissa(c, exponent).min(255) as u8);
    [r, g, b, exponent as u8]
}

enum Trouble {
    /// The bytes are used up.
    End,
    /// A run that is empty, too long, or of nothing.
    Invalid,
}

/// Appends one scanline of `length` pixels.
fn scanline(rest: &mut &[u8], length: u32, pixels: &mut Vec<Rgbe>) -> Result<(), Trouble> {
    let start: Rgbe = *rest.first_chunk().ok_or(Trouble::End)?;
    let is_new = RUN_LENGTH_CODED.contains(&length) && start[..2] == [2, 2] && start[2] < 128;
    if !is_new {
        return old_scanline(rest, length as usize, pixels);
    }
    if u32::from(start[2]) << 8 | u32::from(start[3]) != length {
        return Err(Trouble::Invalid);
    }
    // The four components one after the other: runs of equal bytes, and plain bytes.
    *rest = &rest[4..];
    // A run of 127 takes two bytes: so many must be there before the line is made room for.
    if rest.len() < 4 * 2 * (length as usize).div_ceil(127) {
        return Err(Trouble::End);
    }
    let line_start = pixels.len();
    pixels.resize(line_start + length as usize, [0; 4]);
    let line = &mut pixels[line_start..];
    for component in 0..4 {
        let mut x = 0;
        while x < line.len() {
            let code = usize::from(take(rest)?);
            let (count, run) = if code > 128 { (code - 128, true) } else { (code, false) };
            let run = if run { Some(take(rest)?) } else { None };
            if count == 0 || count > line.len() - x {
                return Err(Trouble::Invalid);
            }
            for pixel in &mut line[x..x + count] {
                pixel[component] = match run {
                    Some(byte) => byte,
                    None => take(rest)?,
                };
            }
            x += count;
        }
    }
    Ok(())
}

/// Plain pixels, and `1 1 1 n`, which repeats the last one n times; directly after another such,
/// 256 n times, and so on.
fn old_scanline(rest: &mut &[u8], length: usize, pixels: &mut Vec<Rgbe>) -> Result<(), Trouble> {
    let end = pixels.len() + length;
    let start = pixels.len();
    let mut shift = 0;
    while pixels.len() < end {
        let (pixel, after) = rest.split_first_chunk::<4>().ok_or(Trouble::End)?;
        *rest = after;
        if pixel[..3] != [1, 1, 1] {
            pixels.push(*pixel);
            shift = 0;
            continue;
        }
        let count = usize::from(pixel[3]).checked_shl(shift).ok_or(Trouble::Invalid)?;
        let last = *pixels.last().filter(|_| pixels.len() > start).ok_or(Trouble::Invalid)?;
        if count > end - pixels.len() || shift > 24 {
            return Err(Trouble::Invalid);
        }
        pixels.resize(pixels.len() + count, last);
        shift += 8;
    }
    Ok(())
}

/// One component of a line as runs.
fn encode_runs(line: &[Rgbe], component: usize, out: &mut Vec<u8>) {
    // Shorter runs cost as much as they save.
    const SHORTEST_RUN: usize = 4;
    let at = |x: usize| line[x][component];
    let run_at = |x: usize| {
        let longest = (line.len() - x).min(127);
        (1..longest).take_while(|i| at(x + i) == at(x)).count() + 1
    };
    let mut x = 0;
    while x < line.len() {
        let mut plain = 0;
        let mut run = run_at(x);
        while run < SHORTEST_RUN && x + plain < line.len() && plain < 128 {
            plain += 1;
            run = if x + plain < line.len() { run_at(x + plain) } else { 0 };
        }
        if plain > 0 {
            out.push(plain as u8);
            out.extend((x..x + plain).map(at));
            x += plain;
        } else {
            out.extend([128 + run as u8, at(x)]);
            x += run;
        }
    }
}

fn take(rest: &mut &[u8]) -> Result<u8, Trouble> {
    let (&byte, after) = rest.split_first().ok_or(Trouble::End)?;
    *rest = after;
    Ok(byte)
}

/// The lines of the header.
struct Lines<'a> {
    rest: &'a [u8],
}

impl<'a> Lines<'a> {
    fn next(&mut self) -> Option<&'a [u8]> {
        let end = self.rest.iter().position(|&byte| byte == b'\n')?;
        let line = &self.rest[..end];
        self.rest = &self.rest[end + 1..];
        Some(line.strip_suffix(b"\r").unwrap_or(line))
    }
}

/// How scanlines lie in the image: `-Y 512 +X 1024` means 512 rows, the top one first, each of
/// 1024 pixels, the left one first.
struct Layout {
    /// How many scanlines, and how long.
    lines: u32,
    length: u32,
    /// Whether scanlines are columns.
    columns: bool,
    /// Whether scanlines, and the pixels in them, run from right to left or from bottom to top.
    lines_back: bool,
    pixels_back: bool,
}

impl Layout {
    fn parse(line: &[u8]) -> Option<Self> {
        let mut words = std::str::from_utf8(line).ok()?.split_ascii_whitespace();
        let mut axis = || Some((words.next()?, words.next()?.parse::<u32>().ok()?));
        let ((first, lines), (second, length)) = (axis()?, axis()?);
        if words.next().is_some() {
            return None;
        }
        // X counts to the right and Y upwards, so -Y is the way of reading.
        let back = |axis| matches!(axis, "-X" | "+Y");
        let (columns, known) = match (first, second) {
            ("-Y" | "+Y", "-X" | "+X") => (false, true),
            ("-X" | "+X", "-Y" | "+Y") => (true, true),
            _ => (false, false),
        };
        known.then_some(Self {
            lines,
            length,
            columns,
            lines_back: back(first),
            pixels_back: back(second),
        })
    }

    /// Width and height.
    fn size(&self) -> (u32, u32) {
        if self.columns { (self.lines, self.length) } else { (self.length, self.lines) }
    }

    fn is_usual(&self) -> bool {
        !self.columns && !self.lines_back && !self.pixels_back
    }

    /// Where in the file pixel `i` of the image stands.
    fn source(&self, i: usize) -> usize {
        let (width, _) = self.size();
        let (x, y) = (i % width as usize, i / width as usize);
        let (line, pixel) = if self.columns { (x, y) } else { (y, x) };
        let turned = |at: usize, count: u32, back: bool| {
            if back { count as usize - 1 - at } else { at }
        };
        turned(line, self.lines, self.lines_back) * self.length as usize
            + turned(pixel, self.length, self.pixels_back)
    }
}
