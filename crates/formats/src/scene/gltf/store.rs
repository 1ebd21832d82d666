//! Buffers, the views into them, and how much may be made of their bytes.
//!
//! Ranges are checked once, when the document is opened: a view lies inside its
//! buffer, an accessor inside its view. What arrays are unpacked is charged
//! against the bytes that are present, so that a small file that points at the
//! same bytes over and over cannot ask for a large machine.

use super::entry::{Entry, Result};
use super::meshopt;
use super::uri::{self, Meant};
use crate::error::SceneErrorKind;
use crate::file;
use crate::limits::Limits;
use crate::scene::files::{Files, Found};
use crate::shown::shown;
use std::collections::HashMap;
use std::path::PathBuf;
use std::rc::Rc;

/// Bytes in arrays for each byte of the files. Bytes that are widened to numbers of 4 bytes and
/// colours without alpha grow to 16/3, strips of one-byte indices to 12 times their size, and
/// what is compressed to ten times more.
const GROWTH: u64 = 128;

/// Bytes in arrays that any file may have.
const FREE: u64 = 1 << 20;

/// Bytes in copies of meshes that skins and morph targets bend, beside [`GROWTH`] for each byte of
/// the files: each node has a copy of its own, and is told in a few bytes.
const FREE_BENT: u64 = 32 << 20;

/// How many bytes arrays may still take.
pub(super) struct Budget {
    used: u64,
    all: u64,
    present: u64,
}

impl Budget {
    fn for_bytes(present: u64) -> Self {
        Self { used: 0, all: present.saturating_mul(GROWTH).saturating_add(FREE), present }
    }

    /// How many are left.
    pub(super) fn left(&self) -> u64 {
        self.all.saturating_sub(self.used)
    }

    /// Bytes that copies of bent meshes may take, beside the arrays.
    pub(super) fn bendable(&self) -> u64 {
        self.present.saturating_mul(GROWTH).saturating_add(FREE_BENT)
    }

    /// Charges `count` things of `size` bytes each.
    pub(super) fn take(&mut self, count: usize, size: usize, at: &Entry<'_, '_>) -> Result<()> {
        self.used = (count as u64)
            .checked_mul(size as u64)
            .and_then(|bytes| self.used.checked_add(bytes))
            .unwrap_or(u64::MAX);
        if self.used <= self.all {
            return Ok(());
        }
        let (used, present) = (self.used, self.present);
        Err(at.wrong(format_args!(
            "unpacks, with what was read before, to {used} bytes, too many for files of {present}"
        )))
    }
}

/// A file of bytes, or the chunk of a binary file.
enum Bytes<'b> {
    Borrowed(&'b [u8]),
    Owned(Rc<Vec<u8>>),
    /// Nothing says where they are: they stand in for compressed ones, or should not be used.
    Absent,
}

struct Buffer<'b> {
    length: usize,
    bytes: Bytes<'b>,
}

impl Buffer<'_> {
    fn bytes(&self) -> Option<&[u8]> {
        match &self.bytes {
            Bytes::Borrowed(bytes) => Some(bytes),
            Bytes::Owned(bytes) => Some(bytes),
            Bytes::Absent => None,
        }
    }
}

/// A range of a buffer, or bytes unpacked from one.
struct View {
    buffer: usize,
    start: usize,
    length: usize,
    stride: Option<usize>,
    unpacked: Option<Vec<u8>>,
}

/// All buffers and views of a document.
pub(super) struct Store<'b> {
    buffers: Vec<Buffer<'b>>,
    views: Vec<View>,
    /// How many of them the document has.
    told: usize,
    pub(super) budget: Budget,
    /// The files that buffers are, symbolic links followed.
    pub(super) files: Vec<PathBuf>,
}

impl<'b> Store<'b> {
    /// The buffers and views of a document whose text has `text_bytes` bytes. `binary` is the
    /// chunk behind it in a binary file.
    pub(super) fn read(
        root: &Entry<'_, '_>,
        text_bytes: usize,
        binary: Option<&'b [u8]>,
        files: &Files<'_>,
        limits: &Limits,
    ) -> Result<Self> {
        let mut opened = Opened { files, limits, by_file: HashMap::new() };
        let mut buffers = Vec::new();
        if let Some(list) = root.get("buffers")? {
            for (i, entry) in list.items()?.enumerate() {
                let chunk = binary.filter(|_| i == 0);
                buffers.push(opened.buffer(&entry, chunk)?);
            }
        }
        let files_bytes: u64 = opened.by_file.values().map(|bytes| bytes.len() as u64).sum();
        let own = text_bytes as u64 + binary.map_or(0, |bytes| bytes.len() as u64);
        let mut files: Vec<_> = opened.by_file.into_keys().collect();
        files.sort();
        let budget = Budget::for_bytes(own.saturating_add(files_bytes));
        let mut store = Self { buffers, views: Vec::new(), told: 0, budget, files };
        if let Some(list) = root.get("bufferViews")? {
            for entry in list.items()? {
                let view = store.view(&entry)?;
                store.views.push(view);
            }
        }
        store.told = store.views.len();
        Ok(store)
    }

    /// How many views the document has.
    pub(super) fn views(&self) -> usize {
        self.told
    }

    /// Adds a view of bytes that were unpacked from others; its number.
    pub(super) fn add(&mut self, bytes: Vec<u8>) -> usize {
        let length = bytes.len();
        let view = View { buffer: 0, start: 0, length, stride: None, unpacked: Some(bytes) };
        self.views.push(view);
        self.views.len() - 1
    }

    /// The bytes of a view, named at `at`.
    pub(super) fn bytes(&self, view: usize, at: &Entry<'_, '_>) -> Result<&[u8]> {
        let view = &self.views[view];
        if let Some(unpacked) = &view.unpacked {
            return Ok(unpacked);
        }
        let bytes = self.buffers[view.buffer].bytes();
        let range = bytes.and_then(|bytes| bytes.get(view.start..view.start + view.length));
        range.ok_or_else(|| {
            at.wrong(format_args!("needs buffers[{}], which has no bytes", view.buffer))
        })
    }

    /// How many bytes a view has.
    pub(super) fn length(&self, view: usize) -> usize {
        self.views[view].length
    }

    /// How far apart elements begin, where the view says so.
    pub(super) fn stride(&self, view: usize) -> Option<usize> {
        self.views[view].stride
    }

    fn view(&mut self, entry: &Entry<'_, '_>) -> Result<View> {
        let (buffer, start, length) = self.range(entry)?;
        let stride = entry.get("byteStride")?;
        let stride = stride.map(|stride| stride.whole(u64::from(u32::MAX))).transpose()?;
        let stride = stride.map(|stride| stride as usize);
        let mut view = View { buffer, start, length, stride, unpacked: None };
        for name in meshopt::NAMES {
            if let Some(packed) = entry.extension(name)? {
                view.unpacked = Some(self.unpack(&packed, length)?);
            }
        }
        Ok(view)
    }

    /// The buffer, offset and length that `entry` tells, checked against each other.
    fn range(&self, entry: &Entry<'_, '_>) -> Result<(usize, usize, usize)> {
        let buffer = entry.need("buffer")?.index("buffer", self.buffers.len())?;
        let start = entry.size_or_zero("byteOffset")?;
        let length = entry.need("byteLength")?.size()?;
        let whole = self.buffers[buffer].length;
        match start.checked_add(length) {
            Some(end) if end <= whole => Ok((buffer, start, length)),
            Some(_) | None => Err(entry.wrong(format_args!(
                "has {length} bytes from {start} on, but buffers[{buffer}] has only {whole}"
            ))),
        }
    }

    /// The bytes of a compressed view, of which there must be `length`.
    fn unpack(&mut self, packed: &Entry<'_, '_>, length: usize) -> Result<Vec<u8>> {
        let (buffer, start, size) = self.range(packed)?;
        let layout = meshopt::Layout::read(packed)?;
        if layout.count.checked_mul(layout.stride) != Some(length) {
            return Err(packed.wrong(format_args!(
                "has {} elements of {} bytes, which are not the {length} of its view",
                layout.count, layout.stride
            )));
        }
        self.budget.take(layout.count, layout.stride, packed)?;
        let bytes = self.buffers[buffer].bytes().and_then(|bytes| bytes.get(start..start + size));
        let Some(bytes) = bytes else {
            return Err(packed.wrong(format_args!("needs buffers[{buffer}], which has no bytes")));
        };
        meshopt::decode(&layout, bytes).map_err(|what| packed.wrong(what))
    }
}

/// What opens buffers, each file once.
struct Opened<'f> {
    files: &'f Files<'f>,
    limits: &'f Limits,
    by_file: HashMap<PathBuf, Rc<Vec<u8>>>,
}

impl Opened<'_> {
    fn buffer<'b>(&mut self, entry: &Entry<'_, '_>, chunk: Option<&'b [u8]>) -> Result<Buffer<'b>> {
        let length = entry.need("byteLength")?.size()?;
        let bytes = match (entry.get("uri")?, chunk) {
            (None, Some(chunk)) => Bytes::Borrowed(chunk),
            (None, None) => Bytes::Absent,
            (Some(uri), _) => {
                match uri::understand(uri.text()?).map_err(|what| uri.wrong(what))? {
                    Meant::Bytes(bytes, _) => Bytes::Owned(Rc::new(bytes)),
                    Meant::File(name) => Bytes::Owned(self.file(name, &uri)?),
                }
            }
        };
        let buffer = Buffer { length, bytes };
        match buffer.bytes() {
            Some(bytes) if bytes.len() < length => Err(entry.wrong(format_args!(
                "is to have {length} bytes, but there are only {}",
                bytes.len()
            ))),
            Some(_) | None => Ok(buffer),
        }
    }

    fn file(&mut self, name: &str, uri: &Entry<'_, '_>) -> Result<Rc<Vec<u8>>> {
        let found = find(self.files, name).map_err(|what| uri.trouble(what))?;
        if let Some(bytes) = self.by_file.get(&found.identity) {
            return Ok(bytes.clone());
        }
        let bytes = file::scene_bytes(&found.path, self.limits).map_err(|error| {
            let name = shown(name);
            uri.trouble(format_args!("\"{name}\": {}", error.kind))
        })?;
        let bytes = Rc::new(bytes);
        self.by_file.insert(found.identity, bytes.clone());
        Ok(bytes)
    }
}

/// The file that a URI without a scheme means: with its escapes undone, or, since many exporters
/// write none, as it stands.
pub(super) fn find(files: &Files<'_>, uri: &str) -> std::result::Result<Found, String> {
    match uri::file_name(uri) {
        Some(name) if name != uri => match files.find(&name) {
            Ok(found) => Ok(found),
            Err(what) => files.find(uri).map_err(|_| what),
        },
        Some(_) | None => files.find(uri),
    }
}

/// That something legal is not done here, at a place.
pub(super) fn unsupported(at: &Entry<'_, '_>, what: impl std::fmt::Display) -> SceneErrorKind {
    SceneErrorKind::Unsupported(format!("{} {what}", at.place))
}
