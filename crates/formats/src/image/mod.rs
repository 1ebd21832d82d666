//! Images from files and to files.
//!
//! | extension       | read                          | written                             |
//! |-----------------|-------------------------------|-------------------------------------|
//! | `.exr`          | half, float, uint; any channels | float or half, counts as uint, any channels, text |
//! | `.hdr`          | RGBE, plain or run-length coded | RGBE, run-length coded            |
//! | `.pfm`          | grey or RGB, either byte order | float                              |
//! | `.png`          | 1 to 16 bits, grey to RGBA    | RGB of 8 or 16 bits                 |
//! | `.jpg`, `.jpeg` | grey, YCbCr, CMYK             | quality 92                          |
//! | `.webp`         | with and without loss, RGB and RGBA | no                            |
//! | `.tga`          | 8 bits, grey, RGB and RGBA, with palettes and runs | no             |
//!
//! The first three hold light; what is read from the others is decoded from
//! sRGB to light, or kept as it is for textures ([`read_bitmap`]). Values are kept as they are, NaN, infinite and negative ones
//! included. Pixels are counted from the header, and held against the bytes
//! that are there, before memory is taken for them.

mod check;
mod codes;
mod exr;
mod format;
mod hdr;
mod jpeg;
mod options;
mod pfm;
mod png;
mod tga;
mod webp;

pub use format::Format;
pub use options::{Pixels, Precision, WriteOptions};

use crate::error::ImageError;
use crate::file;
use crate::limits::Limits;
use crate::replace::{replace_file, target, temporary};
use codes::Codes;
use rutilant::image::Image;
use rutilant::texture::Bitmap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

/// The image in the file at `path`.
///
/// The first bytes say which format it is, whatever the file is called.
///
/// # Errors
/// A file that cannot be read, breaks its format, ends early or exceeds the `limits`.
pub fn read(path: &Path, limits: &Limits) -> Result<Image, ImageError> {
    read_bytes(&file::image_bytes(path, limits)?, path, limits)
}

/// As [`read`], for the content of a file. `name` is for messages, and its extension names the
/// format where the bytes do not.
///
/// # Errors
/// As [`read`].
pub fn read_bytes(bytes: &[u8], name: &Path, limits: &Limits) -> Result<Image, ImageError> {
    let light = |codes: Codes| codes.light().ok_or_else(wrong_size);
    decoded(bytes, name, limits, Ok, light)
}

/// The image in the file at `path`, for a texture: codes of 8 and 16 bits stay as they are.
///
/// # Errors
/// As for [`read`], and an image without colour.
pub fn read_bitmap(path: &Path, limits: &Limits) -> Result<Bitmap, ImageError> {
    read_bitmap_bytes(&file::image_bytes(path, limits)?, path, limits)
}

/// As [`read_bitmap`], for the content of a file; `name` as for [`read_bytes`].
///
/// # Errors
/// As [`read_bitmap`].
pub fn read_bitmap_bytes(bytes: &[u8], name: &Path, limits: &Limits) -> Result<Bitmap, ImageError> {
    let light = |image: Image| {
        let colorless = || "the image has no pixels of channels R, G, B (or Y)".to_owned();
        codes::bitmap_of(&image).ok_or_else(colorless)
    };
    let coded = |codes: Codes| codes.bitmap().ok_or_else(wrong_size);
    decoded(bytes, name, limits, light, coded)
}

fn wrong_size() -> String {
    "the decoder gave another size than the header".to_owned()
}

/// What `light` or `coded` make of the image in some bytes, by what it holds.
fn decoded<T>(
    bytes: &[u8],
    name: &Path,
    limits: &Limits,
    light: impl FnOnce(Image) -> Result<T, String>,
    coded: impl FnOnce(Codes) -> Result<T, String>,
) -> Result<T, ImageError> {
    let format = match Format::from_bytes(bytes) {
        Some(format) => format,
        None => Format::from_path(name)?,
    };
    guarded(|| match format {
        Format::Exr => exr::read(bytes, limits).and_then(light),
        Format::Hdr => hdr::read(bytes, limits).and_then(light),
        Format::Pfm => pfm::read(bytes, limits).and_then(light),
        Format::Png => png::read(bytes, limits).and_then(coded),
        Format::Jpeg => jpeg::read(bytes, limits).and_then(coded),
        Format::WebP => webp::read(bytes, limits).and_then(coded),
        Format::Tga => tga::read(bytes, limits).and_then(coded),
    })
    .map_err(|what| {
        // Decoders below may say it in several lines.
        let what = what.split_ascii_whitespace().collect::<Vec<_>>().join(" ");
        ImageError::new(name, what)
    })
}

/// Writes an image to the file at `path`, in the format that its extension names.
///
/// `pixels` is an [`Image`] for the formats that hold light, and
/// [`Pixels::Display`] for those that hold colours for a display; see
/// [`Format::is_for_display`]. The file appears as a whole or not at all: it is
/// written under another name in the same folder, brought to the disk, and
/// renamed. Where anything fails, what was there before is still there.
///
/// # Errors
/// An extension that is not known, pixels of the wrong kind for the format, a
/// disk that does not take the file.
pub fn write<'a>(
    path: &Path,
    pixels: impl Into<Pixels<'a>>,
    options: &WriteOptions,
) -> Result<(), ImageError> {
    let error = |what: String| ImageError::new(path, what);
    let format = Format::to_write(path)?;
    let pixels = pixels.into();
    let (width, height) = pixels.size();
    if width == 0 || height == 0 {
        return Err(error(format!("an image of {width}x{height} has no pixels to write")));
    }
    let extension = file::extension(path);
    let must_fit = |count: usize, what: &str| match count as u128
        == 3 * u128::from(width) * u128::from(height)
    {
        true => Ok(()),
        false => Err(format!("{count} {what} are not 3 for each of {width}x{height} pixels")),
    };
    let bytes = guarded(|| match (format, pixels) {
        (Format::Exr, Pixels::Light(image)) => exr::write(image, options),
        (Format::Hdr, Pixels::Light(image)) => hdr::write(image, options),
        (Format::Pfm, Pixels::Light(image)) => pfm::write(image),
        (Format::Png, Pixels::Display { rgb8, .. }) => {
            must_fit(rgb8.len(), "bytes").and_then(|()| png::write(width, height, rgb8))
        }
        (Format::Png, Pixels::Display16 { rgb16, .. }) => {
            must_fit(rgb16.len(), "words").and_then(|()| png::write_16(width, height, rgb16))
        }
        (Format::Jpeg, Pixels::Display { rgb8, .. }) => {
            must_fit(rgb8.len(), "bytes").and_then(|()| jpeg::write(width, height, rgb8))
        }
        (Format::Jpeg, Pixels::Display16 { .. }) => {
            Err(format!(".{extension} holds 8 bits a colour, but these pixels have 16: write .png"))
        }
        (Format::WebP | Format::Tga, _) => Err(format!(".{extension} is not written")),
        (Format::Png | Format::Jpeg, Pixels::Light(_)) => Err(format!(
            ".{extension} holds colours for a display, but these pixels are light: encode them \
             first, or write .exr"
        )),
        (
            Format::Exr | Format::Hdr | Format::Pfm,
            Pixels::Display { .. } | Pixels::Display16 { .. },
        ) => Err(format!(
            ".{extension} holds light, but these pixels are encoded for a display: write .png, \
             or give the light itself"
        )),
    })
    .map_err(error)?;
    replace_file(path, &bytes).map_err(|e| error(format!("cannot write: {e}")))
}

/// Checks that [`write()`] to `path` will most likely succeed, so that nobody waits for a picture
/// that cannot be kept. Touches nothing that is there.
///
/// # Errors
/// An extension that is not known; a folder that does not exist or takes no
/// files; a folder or a read-only file of that name.
pub fn check_writable(path: &Path) -> Result<(), ImageError> {
    let error = |what: String| ImageError::new(path, what);
    Format::to_write(path)?;
    let target = target(path).map_err(|e| error(format!("cannot write: {e}")))?;
    // A file is made there and taken away: permissions alone do not tell.
    temporary(&target).map_err(|e| error(format!("cannot write: {e}")))?;
    Ok(())
}

/// The bytes of a file that holds an image of light.
pub(crate) fn to_exr(image: &Image) -> Result<Vec<u8>, String> {
    guarded(|| exr::write(image, &WriteOptions::default()))
}

/// The bytes of a file that holds a bitmap, value by value: PNG for codes, EXR for light.
pub(crate) fn encoded(bitmap: &Bitmap) -> Result<Vec<u8>, String> {
    match codes::image_of(bitmap) {
        Some(image) => to_exr(&image),
        None => guarded(|| png::of_bitmap(bitmap)),
    }
}

/// Whether a picture of this size has room in the format of `path`.
///
/// # Errors
/// Where it has none, or the format is not known.
pub fn check_size(path: &Path, width: u32, height: u32) -> Result<(), ImageError> {
    match Format::to_write(path)? {
        Format::Jpeg => jpeg::check_size(width, height).map_err(|what| ImageError::new(path, what)),
        Format::Exr | Format::Hdr | Format::Pfm | Format::Png | Format::WebP | Format::Tga => {
            Ok(())
        }
    }
}

/// Runs a decoder or an encoder, and makes an error of a panic.
///
/// Our own do not panic, and the libraries below them hardly do: in millions of
/// damaged files one assertion was seen to fail, in debug builds, in a tiled
/// EXR. But they are large and read what strangers wrote. This is the last
/// net, so that a picture never takes the program with it. What the panicking
/// code had in its hands is dropped, so nothing broken is seen afterwards.
fn guarded<T>(work: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|_| {
        Err("the decoder stumbled over this file; please report it as a bug".to_owned())
    })
}
