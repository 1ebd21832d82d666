//! Images from files and to files.
//!
//! | extension       | read                          | written                             |
//! |-----------------|-------------------------------|-------------------------------------|
//! | `.exr`          | half, float, uint; any channels | float or half, any channels, text |
//! | `.hdr`          | RGBE, plain or run-length coded | RGBE, run-length coded            |
//! | `.pfm`          | grey or RGB, either byte order | float                              |
//! | `.png`          | 1 to 16 bits, grey to RGBA    | 8-bit RGB                           |
//! | `.jpg`, `.jpeg` | grey, YCbCr, CMYK             | quality 92                          |
//!
//! The first three hold light; what is read from the last two is decoded from
//! sRGB to light. Values are kept as they are, NaN, infinite and negative ones
//! included. Pixels are counted from the header, and held against the bytes
//! that are there, before memory is taken for them.

mod exr;
mod hdr;
mod jpeg;
mod pfm;
mod png;
mod srgb;

use crate::{ImageError, Limits, file};
use rutilant::image::Image;
use std::fs::{self, File};
use std::io::{self, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

/// The image in the file at `path`.
///
/// The first bytes say which format it is, whatever the file is called.
///
/// # Errors
/// A file that cannot be read, breaks its format, ends early or exceeds the `limits`.
pub fn read(path: &Path, limits: &Limits) -> Result<Image, ImageError> {
    let bytes = file::bytes(path, limits)
        .map_err(|refused| ImageError { file: path.to_owned(), what: refused.to_string() })?;
    read_bytes(&bytes, path, limits)
}

/// As [`read`], for the content of a file. `name` is for messages, and its extension names the
/// format where the bytes do not.
///
/// # Errors
/// As [`read`].
pub fn read_bytes(bytes: &[u8], name: &Path, limits: &Limits) -> Result<Image, ImageError> {
    let format = match Format::from_bytes(bytes) {
        Some(format) => format,
        None => Format::from_path(name)?,
    };
    let decode = match format {
        Format::Exr => exr::read,
        Format::Hdr => hdr::read,
        Format::Pfm => pfm::read,
        Format::Png => png::read,
        Format::Jpeg => jpeg::read,
    };
    guarded(|| decode(bytes, limits)).map_err(|what| {
        // Decoders below may say it in several lines.
        let what = what.split_ascii_whitespace().collect::<Vec<_>>().join(" ");
        ImageError { file: name.to_owned(), what }
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
    let error = |what: String| ImageError { file: path.to_owned(), what };
    let format = Format::from_path(path)?;
    let pixels = pixels.into();
    let (width, height) = pixels.size();
    if width == 0 || height == 0 {
        return Err(error(format!("an image of {width}x{height} has no pixels to write")));
    }
    let extension = extension(path);
    let bytes = guarded(|| match (format, pixels) {
        (Format::Exr, Pixels::Light(image)) => exr::write(image, options),
        (Format::Hdr, Pixels::Light(image)) => hdr::write(image, options),
        (Format::Pfm, Pixels::Light(image)) => pfm::write(image),
        (Format::Png | Format::Jpeg, Pixels::Display { rgb8, .. })
            if rgb8.len() as u128 != 3 * u128::from(width) * u128::from(height) =>
        {
            Err(format!("{} bytes are not 3 for each of {width}x{height} pixels", rgb8.len()))
        }
        (Format::Png, Pixels::Display { rgb8, .. }) => png::write(width, height, rgb8),
        (Format::Jpeg, Pixels::Display { rgb8, .. }) => jpeg::write(width, height, rgb8),
        (Format::Png | Format::Jpeg, Pixels::Light(_)) => Err(format!(
            ".{extension} holds colours for a display, but these pixels are light: encode them \
             first, or write .exr"
        )),
        (Format::Exr | Format::Hdr | Format::Pfm, Pixels::Display { .. }) => Err(format!(
            ".{extension} holds light, but these pixels are encoded for a display: write .png, \
             or give the light itself"
        )),
    })
    .map_err(error)?;
    replace(path, &bytes).map_err(|e| error(format!("cannot write: {e}")))
}

/// Checks that [`write()`] to `path` will most likely succeed, so that nobody waits for a picture
/// that cannot be kept. Touches nothing that is there.
///
/// # Errors
/// An extension that is not known; a folder that does not exist or takes no
/// files; a folder or a read-only file of that name.
pub fn check_writable(path: &Path) -> Result<(), ImageError> {
    Format::from_path(path)?;
    let error = |what: String| ImageError { file: path.to_owned(), what };
    let target = target(path).map_err(|e| error(format!("cannot write: {e}")))?;
    // A file is made there and taken away: permissions alone do not tell.
    temporary(&target).map_err(|e| error(format!("cannot write: {e}")))?;
    Ok(())
}

/// What to write.
#[derive(Clone, Copy, Debug)]
pub enum Pixels<'a> {
    /// Scene-linear light, in named channels: for `.exr`, `.hdr` and `.pfm`.
    Light(&'a Image),
    /// Colours encoded for a display: for `.png` and `.jpg`.
    Display {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
        /// (height, width, 3): red, green and blue, row 0 on top, encoded as sRGB.
        rgb8: &'a [u8],
    },
}

impl Pixels<'_> {
    fn size(&self) -> (u32, u32) {
        match *self {
            Self::Light(image) => (image.width(), image.height()),
            Self::Display { width, height, .. } => (width, height),
        }
    }
}

impl<'a> From<&'a Image> for Pixels<'a> {
    fn from(image: &'a Image) -> Self {
        Self::Light(image)
    }
}

/// How to write.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct WriteOptions {
    /// How `.exr` stores numbers.
    pub precision: Precision,
    /// Names and texts to keep with the image, "spp" and "64" for example. `.exr` stores each as
    /// an attribute, `.hdr` as a comment, the others not at all.
    pub metadata: Vec<(String, String)>,
}

/// How `.exr` stores numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// 32 bits: every value as it is.
    #[default]
    Float,
    /// 16 bits: about three digits. Finite values beyond ±65504 become that.
    Half,
}

/// An image format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// OpenEXR.
    Exr,
    /// Radiance RGBE.
    Hdr,
    /// Portable float map.
    Pfm,
    /// Portable network graphics.
    Png,
    /// JPEG.
    Jpeg,
}

impl Format {
    /// The format that the extension of `path` names.
    ///
    /// # Errors
    /// An extension that is not known.
    pub fn from_path(path: &Path) -> Result<Self, ImageError> {
        const KNOWN: &str = "known are .exr, .hdr, .pfm, .png, .jpg";
        let extension = extension(path);
        Ok(match &*extension {
            "exr" => Self::Exr,
            "hdr" | "rgbe" | "pic" => Self::Hdr,
            "pfm" => Self::Pfm,
            "png" => Self::Png,
            "jpg" | "jpeg" => Self::Jpeg,
            _ => {
                let what = if extension.is_empty() {
                    format!("no extension, so no image format; {KNOWN}")
                } else {
                    format!("no image format .{}; {KNOWN}", extension.escape_debug())
                };
                return Err(ImageError { file: path.to_owned(), what });
            }
        })
    }

    /// Whether files of this format hold colours encoded for a display, 8 bits each, rather than
    /// light: what [`write()`] wants as [`Pixels::Display`].
    pub fn is_for_display(self) -> bool {
        match self {
            Self::Exr | Self::Hdr | Self::Pfm => false,
            Self::Png | Self::Jpeg => true,
        }
    }

    /// The format that the first bytes of a file show.
    fn from_bytes(bytes: &[u8]) -> Option<Self> {
        Some(match bytes {
            [0x76, 0x2f, 0x31, 0x01, ..] => Self::Exr,
            [b'#', b'?', ..] => Self::Hdr,
            [b'P', b'F' | b'f', b'\n' | b'\r' | b' ' | b'\t', ..] => Self::Pfm,
            [0x89, b'P', b'N', b'G', ..] => Self::Png,
            [0xff, 0xd8, 0xff, ..] => Self::Jpeg,
            _ => return None,
        })
    }
}

fn extension(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase()
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

/// Checks the size that a header states, before memory is taken for it.
///
/// `bytes` are present for the pixels, and the format's best compression makes
/// `expansion` of one. `pixel_bytes` is what a pixel takes when decoded.
fn check_size(
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
            "{width}x{height} are {pixels} pixels, but at most {allowed} are allowed"
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
fn colors(image: &Image) -> Result<Vec<[f32; 3]>, String> {
    image.rgb().ok_or_else(|| "the image has no channels R, G and B, nor Y".to_owned())
}

/// Puts `bytes` where `path` is, as a whole or not at all.
fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let target = target(path)?;
    let mut file = temporary(&target)?;
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    if let Ok(old) = fs::metadata(&target) {
        file.as_file().set_permissions(old.permissions())?;
    }
    file.persist(&target).map_err(|e| e.error)?;
    // The new name is safe once its folder is on the disk. Not every system can do that.
    if let Ok(folder) = File::open(folder(&target)) {
        let _ = folder.sync_all();
    }
    Ok(())
}

/// The file that `path` means: symbolic links are followed, so that they stay what they are.
fn target(path: &Path) -> io::Result<PathBuf> {
    let target = match path.canonicalize() {
        Ok(there) => there,
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(path.to_owned()),
        Err(e) => return Err(e),
    };
    let metadata = fs::metadata(&target)?;
    if metadata.is_dir() {
        return Err(io::Error::new(io::ErrorKind::IsADirectory, "this is a folder"));
    }
    if !metadata.is_file() {
        return Err(io::Error::other("this is a pipe or a device"));
    }
    if metadata.permissions().readonly() {
        return Err(io::Error::new(io::ErrorKind::PermissionDenied, "the file is read-only"));
    }
    Ok(target)
}

/// A new file next to `target`, which is gone again if it is dropped.
fn temporary(target: &Path) -> io::Result<tempfile::NamedTempFile> {
    let folder = folder(target);
    if !folder.is_dir() {
        let what = format!("there is no folder {}", folder.display());
        return Err(io::Error::new(io::ErrorKind::NotFound, what));
    }
    let mut builder = tempfile::Builder::new();
    builder.prefix(".rutilant-").suffix(".tmp");
    #[cfg(unix)]
    {
        // As for any new file: what the user's umask leaves of this.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}
