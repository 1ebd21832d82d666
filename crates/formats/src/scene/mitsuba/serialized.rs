//! Mitsuba's own mesh files: several meshes one behind the other, each compressed, and where they
//! begin at the end of the file.
//!
//! A mesh is unpacked piece by piece as its arrays need it, and what its counts ask for is first held
//! against what so many compressed bytes can become; so a small file takes little memory whatever
//! it says.
//!
//! Source: *Mitsuba documentation*, version 0.6, section 8.1.6: the format of serialized meshes.

use crate::error::{SceneError, SceneErrorKind};
use crate::limits::Limits;
use flate2::read::ZlibDecoder;
use rutilant::shape::Mesh;
use rutilant_geom::{Vec2, Vec3};
use std::io::Read;
use std::path::Path;

const MAGIC: u16 = 0x041c;

/// What a mesh has, by bits of a number in front of it.
const NORMALS: u32 = 0x0001;
const UVS: u32 = 0x0002;
const COLORS: u32 = 0x0008;
const FACE_NORMALS: u32 = 0x0010;
const SINGLE: u32 = 0x1000;
const DOUBLE: u32 = 0x2000;

/// Numbers of a mesh hardly shrink to a twentieth; what would grow more than so many times is not
/// believed, as with meshes that are packed by gzip.
const MOST_PER_BYTE: u64 = 200;
/// What a small mesh may become whatever it is.
const FREE: u64 = 4 << 10;

/// How many meshes a file holds.
///
/// # Errors
/// A file whose end says nothing that can be.
pub fn count(bytes: &[u8], path: &Path) -> Result<u32, SceneError> {
    Ok(Contents::read(bytes, path)?.count)
}

/// Whether the meshes of a file lie one behind the other: those that share bytes could become far
/// more than the file can hold. Asked once, before any is read.
pub(super) fn check_order(bytes: &[u8], path: &Path) -> Result<(), SceneError> {
    let contents = Contents::read(bytes, path)?;
    let offsets = (0..contents.count).map(|number| contents.offset(number));
    if offsets.is_sorted() {
        return Ok(());
    }
    Err(SceneError::invalid_file(path, "its meshes do not lie one behind the other"))
}

/// The mesh of a number, from 0 on, of the content of a file; `path` is only for messages. Textures
/// have their v as the file has it.
///
/// # Errors
/// Content that breaks the format, ends early or exceeds the `limits`; a number that there is not.
pub fn read_bytes(
    bytes: &[u8],
    number: u32,
    path: &Path,
    limits: &Limits,
) -> Result<Mesh, SceneError> {
    let contents = Contents::read(bytes, path)?;
    let packed = contents.mesh(number)?;
    let mut unpacked =
        Unpacked { from: ZlibDecoder::new(packed), packed: packed.len() as u64, path, number };

    // What there is of it.
    let flags = u32::from_le_bytes(unpacked.array()?);
    let double = match (flags & SINGLE != 0, flags & DOUBLE != 0) {
        (_, false) => false,
        (false, true) => true,
        (true, true) => return Err(unpacked.invalid("its numbers are single and double at once")),
    };
    let name = if contents.version >= 4 { unpacked.name()? } else { String::new() };
    let [vertices, triangles] = [(); 2].map(|()| unpacked.array().map(u64::from_le_bytes));
    let (vertices, triangles) = (vertices?, triangles?);
    for (what, asked, allowed) in [
        ("vertices", vertices, limits.vertices.min(u64::from(u32::MAX))),
        ("triangles", triangles, limits.triangles),
    ] {
        if asked > allowed {
            let kind = SceneErrorKind::Limit { what, asked, allowed };
            return Err(SceneError::in_file(path, kind));
        }
    }

    // Whether so much can be in so few bytes.
    let has = |bit: u32| u64::from(flags & bit != 0);
    let numbers = 3 + 3 * has(NORMALS) + 2 * has(UVS) + 3 * has(COLORS);
    let size = if double { 8 } else { 4 };
    let needed = u128::from(vertices) * u128::from(numbers * size) + u128::from(triangles) * 12;
    if needed > u128::from(unpacked.packed) * u128::from(MOST_PER_BYTE) + u128::from(FREE) {
        let what = format!(
            "it says that it has {vertices} vertices and {triangles} triangles, for which its bytes \
             are too few"
        );
        return Err(unpacked.invalid(&what));
    }

    // Its arrays.
    let positions = unpacked.numbers(vertices, double, Vec3::from_array)?;
    let mut mesh = Mesh { name, positions, ..Mesh::default() };
    if flags & NORMALS != 0 {
        let normals = unpacked.numbers(vertices, double, Vec3::from_array)?;
        if flags & FACE_NORMALS == 0 {
            mesh.normals = normals;
        }
    }
    if flags & UVS != 0 {
        mesh.uvs = unpacked.numbers(vertices, double, Vec2::from_array)?;
    }
    if flags & COLORS != 0 {
        mesh.colors = unpacked.numbers(vertices, double, |[r, g, b]| [r, g, b, 1.0])?;
    }
    mesh.triangles.reserve_exact(triangles as usize);
    unpacked.pieces(triangles * 12, |bytes| {
        mesh.triangles.extend(bytes.chunks_exact(12).map(|corners| {
            let corner = |i: usize| corners[4 * i..].first_chunk().copied().unwrap_or_default();
            [corner(0), corner(1), corner(2)].map(u32::from_le_bytes)
        }));
    })?;
    let wrong = mesh.triangles.iter().flatten().find(|&&v| u64::from(v) >= vertices);
    if let Some(v) = wrong {
        let what = format!("a triangle names vertex {v}, but there are only {vertices}");
        return Err(unpacked.invalid(&what));
    }
    Ok(mesh)
}

/// What the end of a file says of it.
struct Contents<'b> {
    bytes: &'b [u8],
    path: &'b Path,
    version: u16,
    count: u32,
}

impl<'b> Contents<'b> {
    fn read(bytes: &'b [u8], path: &'b Path) -> Result<Self, SceneError> {
        let invalid = |what: &str| Err(SceneError::invalid_file(path, what));
        let word = |at: usize| bytes.get(at..)?.first_chunk().map(|b| u16::from_le_bytes(*b));
        let (Some(MAGIC), Some(version)) = (word(0), word(2)) else {
            return invalid("this is no serialized mesh: it does not begin with 1c 04");
        };
        if !matches!(version, 3 | 4) {
            let what = format!("version {version} of serialized meshes; there are 3 and 4");
            return Err(SceneError::in_file(path, SceneErrorKind::Unsupported(what)));
        }
        let Some(count) = bytes.last_chunk().map(|b| u32::from_le_bytes(*b)) else {
            return invalid("the file ends before it has begun");
        };
        let contents = Self { bytes, path, version, count };
        match contents.table() {
            Some(_) if count > 0 => Ok(contents),
            _ => invalid(&format!(
                "its end says that it holds {count} meshes, but there is no room for a list of them"
            )),
        }
    }

    /// Bytes of an entry of the list, and where the list begins.
    fn table(&self) -> Option<(usize, usize)> {
        let size = if self.version >= 4 { 8 } else { 4 };
        let length = (self.count as usize).checked_mul(size)?.checked_add(4)?;
        Some((size, self.bytes.len().checked_sub(length)?))
    }

    /// Where a mesh is said to begin.
    fn offset(&self, number: u32) -> Option<usize> {
        let (size, table) = self.table()?;
        let entry = self.bytes.get(table + number as usize * size..)?;
        match size {
            8 => usize::try_from(u64::from_le_bytes(*entry.first_chunk()?)).ok(),
            _ => usize::try_from(u32::from_le_bytes(*entry.first_chunk()?)).ok(),
        }
    }

    /// The compressed bytes of a mesh.
    fn mesh(&self, number: u32) -> Result<&'b [u8], SceneError> {
        let invalid = |what: String| Err(SceneError::invalid_file(self.path, what));
        if number >= self.count {
            let last = self.count - 1;
            return invalid(format!("there is no mesh number {number}; they go from 0 to {last}"));
        }
        let Some((_, table)) = self.table() else {
            return invalid("there is no list of meshes".to_owned());
        };
        let start = self.offset(number).filter(|start| *start < table);
        let end = if number + 1 < self.count { self.offset(number + 1) } else { Some(table) };
        let Some((start, end)) = start.zip(end.filter(|end| *end <= table)) else {
            return invalid(format!("mesh {number} is said to begin outside of the file"));
        };
        match self.bytes.get(start..end) {
            Some([a, b, _, _, packed @ ..]) if u16::from_le_bytes([*a, *b]) == MAGIC => Ok(packed),
            Some(_) | None => invalid(format!("mesh {number} does not begin where it is said to")),
        }
    }
}

/// A mesh that is being unpacked.
struct Unpacked<'b> {
    from: ZlibDecoder<&'b [u8]>,
    packed: u64,
    path: &'b Path,
    number: u32,
}

impl Unpacked<'_> {
    #[cold]
    fn invalid(&self, what: &str) -> SceneError {
        SceneError::invalid_file(self.path, format!("mesh {}: {what}", self.number))
    }

    fn fill(&mut self, into: &mut [u8]) -> Result<(), SceneError> {
        let read = self.from.read_exact(into);
        read.map_err(|error| match error.kind() {
            std::io::ErrorKind::UnexpectedEof => self.invalid("it ends before its arrays do"),
            _ => self.invalid("its bytes are not compressed as zlib does it"),
        })
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], SceneError> {
        let mut bytes = [0; N];
        self.fill(&mut bytes)?;
        Ok(bytes)
    }

    /// A name, up to a byte of nought.
    fn name(&mut self) -> Result<String, SceneError> {
        /// No name is longer.
        const LONGEST: usize = 4096;
        let mut name = Vec::new();
        loop {
            match self.array()? {
                [0] => return Ok(crate::shown::decode(&name)),
                _ if name.len() == LONGEST => return Err(self.invalid("its name never ends")),
                [byte] => name.push(byte),
            }
        }
    }

    /// So many bytes, by and by; each piece holds whole numbers and triangles.
    fn pieces(&mut self, bytes: u64, mut each: impl FnMut(&[u8])) -> Result<(), SceneError> {
        const PIECE: usize = 48 << 10;
        let mut buffer = vec![0; PIECE.min(usize::try_from(bytes).unwrap_or(PIECE))];
        let mut left = bytes;
        while left > 0 {
            let now = (buffer.len() as u64).min(left) as usize;
            self.fill(&mut buffer[..now])?;
            each(&buffer[..now]);
            left -= now as u64;
        }
        Ok(())
    }

    /// So many things of `N` numbers each.
    fn numbers<const N: usize, T>(
        &mut self,
        count: u64,
        double: bool,
        make: impl Fn([f32; N]) -> T,
    ) -> Result<Vec<T>, SceneError> {
        let mut all = Vec::with_capacity(count as usize);
        let size = if double { 8 } else { 4 };
        self.pieces(count * (N * size) as u64, |bytes| {
            let number = |bytes: &[u8]| match bytes {
                &[a, b, c, d] => f32::from_le_bytes([a, b, c, d]),
                _ => bytes.first_chunk().map_or(0.0, |b| f64::from_le_bytes(*b) as f32),
            };
            all.extend(bytes.chunks_exact(N * size).map(|some| {
                make(std::array::from_fn(|i| number(&some[i * size..(i + 1) * size])))
            }));
        })?;
        Ok(all)
    }
}
