//! PLY, the format of scanned models: ASCII, binary little endian and binary big endian.
//!
//! The header says which elements follow and what each is made of; the reader
//! takes positions, normals and texture coordinates from `vertex`, triangles
//! and polygons from `face` or strips from `tristrips`, and steps over
//! everything else exactly. The header is not believed: before anything is
//! allocated for a count, so many bytes must be there.
//!
//! Point clouds come out as a mesh without triangles. Per-face texture
//! coordinates and other properties are left out, with a note; colours in whole
//! numbers, which most scans have, without one. [`to_bytes`] writes what is
//! read here.
//!
//! Source: Turk, *The PLY Polygon File Format*, 1994. The names of texture
//! coordinates are those that Blender, MeshLab, pbrt and LuxCore write.

mod faces;
mod header;
mod numbers;
mod reader;
mod write;

pub use write::to_bytes;

use crate::error::SceneError;
use crate::file;
use crate::limits::Limits;
use crate::scene::text::Cursor;
use header::{Format, Header};
use numbers::{Ascii, Binary};
use reader::Reader;
use rutilant::shape::Mesh;
use std::path::Path;

/// The mesh in the PLY file at `path`, named after it, and notes on what was left out.
///
/// # Errors
/// A file that cannot be read, breaks the format, ends early or exceeds the `limits`.
pub fn read(path: &Path, limits: &Limits) -> Result<(Mesh, Vec<String>), SceneError> {
    read_bytes(&file::scene_bytes(path, limits)?, path, limits)
}

/// As [`read`], for the content of a file; `path` is for messages and the mesh's name.
///
/// # Errors
/// As [`read`].
pub fn read_bytes(
    bytes: &[u8],
    path: &Path,
    limits: &Limits,
) -> Result<(Mesh, Vec<String>), SceneError> {
    let header = Header::read(bytes, path)?;
    let format = header.format;
    let mut reader = Reader::new(bytes, path, limits);
    match format {
        Format::Ascii => reader.body(&header, &mut Ascii(Cursor::at(bytes, header.end)))?,
        Format::Little => reader.body(&header, &mut Binary::<true> { bytes, at: header.end })?,
        Format::Big => reader.body(&header, &mut Binary::<false> { bytes, at: header.end })?,
    }
    let mesh = Mesh { name: file::title(path), ..reader.mesh };
    Ok((mesh, reader.notes))
}
