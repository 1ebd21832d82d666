//! PLY, the format of scanned models: ASCII, binary little endian and binary big endian.
//!
//! The header says which elements follow and what each is made of; the reader
//! takes positions, normals and texture coordinates from `vertex`, triangles
//! and polygons from `face` or strips from `tristrips`, and steps over
//! everything else exactly. The header is not believed: before anything is
//! allocated for a count, so many bytes must be there.
//!
//! Point clouds come out as a mesh without triangles. Per-face texture
//! coordinates and other properties are left out, with a note; colours, which
//! most scans have, without one.
//!
//! Source: Turk, *The PLY Polygon File Format*, 1994. The names of texture
//! coordinates are those that Blender, MeshLab, pbrt and LuxCore write.

use super::polygon::Triangulator;
use super::text::{self, Cursor, place, word_at};
use crate::error::{SceneError, SceneErrorKind, Source};
use crate::file;
use crate::limits::Limits;
use crate::shown::{decode, quoted, shown};
use rutilant::shape::Mesh;
use rutilant_geom::{Vec2, Vec3};
use std::path::Path;

/// The mesh in the PLY file at `path`, and notes on what was left out.
///
/// # Errors
/// A file that cannot be read, breaks the format, ends early or exceeds the `limits`.
pub fn read(path: &Path, limits: &Limits) -> Result<(Mesh, Vec<String>), SceneError> {
    read_bytes(&file::scene_bytes(path, limits)?, path, limits)
}

/// As [`read`], for the content of a file; `path` is only for messages.
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
    let mut reader = Reader {
        bytes,
        path,
        limits,
        mesh: Mesh::default(),
        notes: Vec::new(),
        cuts: Triangulator::new(),
        too_small: None,
    };
    match format {
        Format::Ascii => reader.body(&header, &mut Ascii(Cursor::at(bytes, header.end)))?,
        Format::Little => reader.body(&header, &mut Binary::<true> { bytes, at: header.end })?,
        Format::Big => reader.body(&header, &mut Binary::<false> { bytes, at: header.end })?,
    }
    Ok((reader.mesh, reader.notes))
}

#[derive(Clone, Copy, PartialEq)]
enum Format {
    Ascii,
    Little,
    Big,
}

/// The type of a number in a file.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn from_name(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes in a binary file.
    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }
}

struct Property {
    name: String,
    /// The type of the count, if this is a list.
    count: Option<Scalar>,
    scalar: Scalar,
    /// Where in the header it is declared.
    at: usize,
}

struct Element {
    name: String,
    count: u64,
    properties: Vec<Property>,
    /// Where in the header it is declared.
    at: usize,
}

impl Element {
    /// The fewest bytes that one of it takes.
    fn least_size(&self, format: Format) -> u64 {
        let each = self.properties.iter().map(|p| match format {
            // A digit and a blank.
            Format::Ascii => 2,
            Format::Little | Format::Big => p.count.unwrap_or(p.scalar).size() as u64,
        });
        each.sum()
    }

    fn find(&self, name: &str) -> Option<usize> {
        self.properties.iter().position(|p| p.name == name && p.count.is_none())
    }
}

struct Header {
    format: Format,
    elements: Vec<Element>,
    /// Where the body begins.
    end: usize,
}

impl Header {
    fn read(bytes: &[u8], path: &Path) -> Result<Self, SceneError> {
        let mut cursor = Cursor::new(bytes);
        if cursor.word() != b"ply" {
            let what = "this is not a PLY file: it does not begin with \"ply\"";
            return Err(SceneError::invalid_file(path, what));
        }
        let mut reader = HeaderReader { bytes, path, cursor };
        let mut format = None;
        let mut elements: Vec<Element> = Vec::new();
        loop {
            reader.next_line()?;
            let (at, keyword) = reader.word();
            match keyword {
                b"" | b"comment" | b"obj_info" => {}
                b"format" => format = Some(reader.format()?),
                b"element" => {
                    let element = reader.element(at, &elements)?;
                    elements.push(element);
                }
                b"property" => {
                    let Some(element) = elements.last_mut() else {
                        return Err(reader.invalid(at, "a property before the first element"));
                    };
                    element.properties.push(reader.property(at)?);
                }
                b"end_header" => break,
                _ => {
                    let what = format!(
                        "no header keyword {}; there are format, comment, obj_info, element, \
                         property and end_header",
                        quoted(keyword)
                    );
                    return Err(reader.invalid(at, what));
                }
            }
        }
        let Some(format) = format else {
            return Err(reader.invalid(reader.cursor.at, "the header has no \"format\" line"));
        };
        reader.skip_line();
        Ok(Self { format, elements, end: reader.cursor.at })
    }
}

/// Reads the lines of a header, word by word.
struct HeaderReader<'a> {
    bytes: &'a [u8],
    path: &'a Path,
    cursor: Cursor<'a>,
}

impl<'a> HeaderReader<'a> {
    /// Goes to the next line, which there must be.
    fn next_line(&mut self) -> Result<(), SceneError> {
        let before = self.cursor.at;
        self.skip_line();
        if self.cursor.peek().is_none() && self.cursor.at == before {
            return Err(self.invalid(before, "the header has no \"end_header\""));
        }
        Ok(())
    }

    /// To the beginning of the next line. Nothing but its own end is taken: the body may begin
    /// there.
    fn skip_line(&mut self) {
        let rest = self.cursor.rest();
        let length = rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(rest.len());
        self.cursor.at += length;
        self.cursor.take(b'\r');
        self.cursor.take(b'\n');
    }

    /// The next word of the line, and its place; an empty one where the line has no more.
    fn word(&mut self) -> (usize, &'a [u8]) {
        while self.cursor.peek().is_some_and(text::is_blank) {
            self.cursor.at += 1;
        }
        (self.cursor.at, self.cursor.word())
    }

    /// What follows the keyword `format`.
    fn format(&mut self) -> Result<Format, SceneError> {
        let (at, name) = self.word();
        let format = match name {
            b"ascii" => Format::Ascii,
            b"binary_little_endian" => Format::Little,
            b"binary_big_endian" => Format::Big,
            _ => {
                let what = format!(
                    "no format {}; there are ascii, binary_little_endian and binary_big_endian",
                    quoted(name)
                );
                return Err(self.invalid(at, what));
            }
        };
        match self.word() {
            (_, b"1.0") => Ok(format),
            (at, version) => {
                let what = format!("PLY version {}, but only 1.0 is known", quoted(version));
                Err(self.invalid(at, what))
            }
        }
    }

    /// What follows the keyword `element`, which stands at `at`.
    fn element(&mut self, at: usize, others: &[Element]) -> Result<Element, SceneError> {
        let (name_at, name) = self.word();
        let name = decode(name);
        if others.iter().any(|e| e.name == name) {
            let what = format!("element {} is declared twice", quoted(name.as_bytes()));
            return Err(self.invalid(name_at, what));
        }
        let (count_at, count) = self.word();
        let Some(count) = count_of(count) else {
            let what = format!("{} is not a count of elements", quoted(count));
            return Err(self.invalid(count_at, what));
        };
        Ok(Element { name, count, properties: Vec::new(), at })
    }

    /// What follows the keyword `property`, which stands at `at`.
    fn property(&mut self, at: usize) -> Result<Property, SceneError> {
        let first = self.word();
        let (count, scalar) = if first.1 == b"list" {
            let (count_at, count) = self.word();
            let count = self.scalar((count_at, count))?;
            if !count.is_integer() {
                let what = "the count of a list must be of an integer type";
                return Err(self.invalid(count_at, what));
            }
            let of = self.word();
            (Some(count), self.scalar(of)?)
        } else {
            (None, self.scalar(first)?)
        };
        let (name_at, name) = self.word();
        if name.is_empty() {
            return Err(self.invalid(name_at, "the property has no name"));
        }
        Ok(Property { name: decode(name), count, scalar, at })
    }

    /// The type that a word names.
    fn scalar(&self, (at, word): (usize, &[u8])) -> Result<Scalar, SceneError> {
        Scalar::from_name(word).ok_or_else(|| {
            let what = format!(
                "no type {}; there are char, uchar, short, ushort, int, uint, float and double",
                quoted(word)
            );
            self.invalid(at, what)
        })
    }

    fn invalid(&self, at: usize, what: impl Into<String>) -> SceneError {
        let kind = SceneErrorKind::Invalid(what.into());
        SceneError { at: place(self.path, self.bytes, at), kind }
    }
}

/// A number without sign, and nothing else; one too large comes out as the largest.
fn count_of(word: &[u8]) -> Option<u64> {
    word.first().filter(|byte| byte.is_ascii_digit())?;
    let mut cursor = Cursor::at(word, 0);
    let count = cursor.whole_number()?;
    u64::try_from(count).ok().filter(|_| cursor.rest().is_empty())
}

/// Why a number could not be read.
enum Trouble {
    /// The bytes are used up.
    End,
    /// What stands there is not a number of the declared type.
    NotANumber,
}

/// The body of a file: numbers, one after the other.
trait Body {
    /// Where the next number begins, more or less: for messages and for coming back.
    fn at(&self) -> usize;
    /// Goes to where [`at`](Self::at) once was.
    fn go_to(&mut self, at: usize);
    /// Bytes from here to the end of the file.
    fn left(&self) -> usize;
    /// The fewest bytes that a number takes.
    fn least_size(scalar: Scalar) -> usize;
    /// The next number, rounded to f32 if need be.
    fn float(&mut self, scalar: Scalar) -> Result<f32, Trouble>;
    /// The next number, of an integer type.
    fn integer(&mut self, scalar: Scalar) -> Result<i64, Trouble>;
    /// Steps over `count` numbers.
    fn skip(&mut self, scalar: Scalar, count: usize) -> Result<(), Trouble>;
    /// The position of the next number in the lines of the file; `None` if it has no lines.
    fn place(&self, path: &Path, bytes: &[u8]) -> Option<Source>;
    /// Whether nothing but blanks is left.
    fn is_done(&self) -> bool;
}

/// Numbers as text. Line ends are blanks like any other.
struct Ascii<'a>(Cursor<'a>);

impl Ascii<'_> {
    fn trouble(&self) -> Trouble {
        if self.0.peek().is_none() { Trouble::End } else { Trouble::NotANumber }
    }
}

impl Body for Ascii<'_> {
    fn at(&self) -> usize {
        self.0.at
    }

    fn go_to(&mut self, at: usize) {
        self.0.at = at;
    }

    fn left(&self) -> usize {
        self.0.rest().len()
    }

    fn least_size(_: Scalar) -> usize {
        2
    }

    #[inline]
    fn float(&mut self, _: Scalar) -> Result<f32, Trouble> {
        self.0.skip_space();
        self.0.number().ok_or_else(|| self.trouble())
    }

    #[inline]
    fn integer(&mut self, _: Scalar) -> Result<i64, Trouble> {
        self.0.skip_space();
        let start = self.0.at;
        match self.0.whole_number() {
            Some(value) if self.0.peek().is_none_or(text::is_space) => Ok(value),
            _ => {
                self.0.at = start;
                Err(self.trouble())
            }
        }
    }

    fn skip(&mut self, _: Scalar, count: usize) -> Result<(), Trouble> {
        for _ in 0..count {
            self.0.skip_space();
            if self.0.word().is_empty() {
                return Err(Trouble::End);
            }
        }
        Ok(())
    }

    fn place(&self, path: &Path, bytes: &[u8]) -> Option<Source> {
        let mut here = self.0;
        here.skip_space();
        Some(place(path, bytes, here.at))
    }

    fn is_done(&self) -> bool {
        self.0.rest().iter().all(|&byte| text::is_space(byte))
    }
}

/// Numbers as bytes, the lowest first if `LITTLE`.
struct Binary<'a, const LITTLE: bool> {
    bytes: &'a [u8],
    at: usize,
}

impl<const LITTLE: bool> Binary<'_, LITTLE> {
    #[inline]
    fn take<const N: usize>(&mut self) -> Result<[u8; N], Trouble> {
        let bytes = self.bytes.get(self.at..).and_then(|rest| rest.first_chunk::<N>());
        let mut bytes = *bytes.ok_or(Trouble::End)?;
        self.at += N;
        if !LITTLE {
            bytes.reverse();
        }
        Ok(bytes)
    }
}

impl<const LITTLE: bool> Body for Binary<'_, LITTLE> {
    fn at(&self) -> usize {
        self.at
    }

    fn go_to(&mut self, at: usize) {
        self.at = at;
    }

    fn left(&self) -> usize {
        self.bytes.len().saturating_sub(self.at)
    }

    fn least_size(scalar: Scalar) -> usize {
        scalar.size()
    }

    #[inline]
    fn float(&mut self, scalar: Scalar) -> Result<f32, Trouble> {
        match scalar {
            Scalar::F32 => Ok(f32::from_le_bytes(self.take()?)),
            Scalar::F64 => Ok(f64::from_le_bytes(self.take()?) as f32),
            _ => Ok(self.integer(scalar)? as f32),
        }
    }

    #[inline]
    fn integer(&mut self, scalar: Scalar) -> Result<i64, Trouble> {
        Ok(match scalar {
            Scalar::I8 => i8::from_le_bytes(self.take()?).into(),
            Scalar::U8 => u8::from_le_bytes(self.take()?).into(),
            Scalar::I16 => i16::from_le_bytes(self.take()?).into(),
            Scalar::U16 => u16::from_le_bytes(self.take()?).into(),
            Scalar::I32 => i32::from_le_bytes(self.take()?).into(),
            Scalar::U32 => u32::from_le_bytes(self.take()?).into(),
            Scalar::F32 | Scalar::F64 => return Err(Trouble::NotANumber),
        })
    }

    fn skip(&mut self, scalar: Scalar, count: usize) -> Result<(), Trouble> {
        match scalar.size().checked_mul(count) {
            Some(size) if size <= self.left() => {
                self.at += size;
                Ok(())
            }
            _ => Err(Trouble::End),
        }
    }

    fn place(&self, _: &Path, _: &[u8]) -> Option<Source> {
        None
    }

    fn is_done(&self) -> bool {
        self.left() == 0
    }
}

struct Reader<'a> {
    bytes: &'a [u8],
    path: &'a Path,
    limits: &'a Limits,
    mesh: Mesh,
    notes: Vec<String>,
    cuts: Triangulator,
    /// How many faces have fewer than three corners, and the number of the first.
    too_small: Option<(u64, u64)>,
}

impl Reader<'_> {
    fn body<B: Body>(&mut self, header: &Header, body: &mut B) -> Result<(), SceneError> {
        if !header.elements.iter().any(|e| e.name == "vertex") {
            let what = "the header has no element \"vertex\"";
            return Err(SceneError::invalid_file(self.path, what));
        }

        // Elements in their order; faces that come before the vertices they name wait.
        let mut waiting = None;
        let mut vertices = None;
        for element in &header.elements {
            self.must_fit(header, element, body)?;
            match &*element.name {
                "vertex" => {
                    self.vertices(element, body)?;
                    vertices = Some(element.count);
                }
                "face" | "tristrips" if vertices.is_none() => {
                    waiting.get_or_insert(body.at());
                    self.skip(element, body)?;
                }
                "face" => self.faces(element, body)?,
                "tristrips" => self.strips(element, body)?,
                _ => self.skip(element, body)?,
            }
        }
        if !body.is_done() {
            let left = body.left();
            self.note(&format!("bytes after the last element, left out: {left}"));
        }
        if let Some(at) = waiting {
            body.go_to(at);
            let first = |e: &Element| e.name == "face" || e.name == "tristrips";
            let elements = header.elements.iter().skip_while(|e| !first(e));
            for element in elements.take_while(|e| e.name != "vertex") {
                match &*element.name {
                    "face" => self.faces(element, body)?,
                    "tristrips" => self.strips(element, body)?,
                    _ => self.skip(element, body)?,
                }
            }
        }

        // What the caller should know.
        if let Some((count, first)) = self.too_small {
            self.note(&format!(
                "faces with fewer than 3 vertices, left out: {count} (first face {first})"
            ));
        }
        if self.cuts.cut_short > 0 {
            let count = self.cuts.cut_short;
            self.note(&format!("faces with very many vertices, cut into fans: {count}"));
        }
        if self.mesh.triangles.is_empty() {
            self.note("there are no faces in it, so nothing of it can be seen");
        }
        Ok(())
    }

    /// Refuses a count that the bytes present cannot hold, before anything is allocated for it.
    fn must_fit<B: Body>(
        &self,
        header: &Header,
        element: &Element,
        body: &B,
    ) -> Result<(), SceneError> {
        // The last number of a text needs no blank behind it.
        let left = body.left() as u64 + u64::from(header.format == Format::Ascii);
        let least = element.count.saturating_mul(element.least_size(header.format));
        if least <= left {
            return Ok(());
        }
        Err(self.invalid_at(
            element.at,
            format!(
                "{} elements \"{}\" are declared, which take at least {least} bytes, but only {} \
                 are left",
                element.count,
                shown(&element.name),
                body.left()
            ),
        ))
    }

    fn vertices<B: Body>(&mut self, element: &Element, body: &mut B) -> Result<(), SceneError> {
        let allowed = self.limits.vertices.min(u64::from(u32::MAX));
        if element.count > allowed {
            let kind = SceneErrorKind::Limit { what: "vertices", asked: element.count, allowed };
            return Err(self.error_at(element.at, kind));
        }
        // The properties wanted: x y z, then a normal, then texture coordinates.
        const NONE: usize = usize::MAX;
        let mut wanted = [NONE; 8];
        for (slot, name) in ["x", "y", "z"].into_iter().enumerate() {
            wanted[slot] = element.find(name).ok_or_else(|| {
                let what = format!("element \"vertex\" has no property \"{name}\"");
                self.invalid_at(element.at, what)
            })?;
        }
        let normal = ["nx", "ny", "nz"].map(|name| element.find(name));
        if let [Some(x), Some(y), Some(z)] = normal {
            wanted[3..6].copy_from_slice(&[x, y, z]);
        }
        const UV_NAMES: [[&str; 2]; 4] =
            [["u", "v"], ["s", "t"], ["texture_u", "texture_v"], ["texture_s", "texture_t"]];
        for names in UV_NAMES {
            if let [Some(u), Some(v)] = names.map(|name| element.find(name)) {
                wanted[6..8].copy_from_slice(&[u, v]);
                break;
            }
        }
        self.note_unread(element, |i| wanted.contains(&i));

        // The bytes for them are there: `must_fit` has counted.
        let count = element.count as usize;
        let (has_normals, has_uvs) = (wanted[3] != NONE, wanted[6] != NONE);
        self.mesh.positions.reserve_exact(count);
        self.mesh.normals.reserve_exact(if has_normals { count } else { 0 });
        self.mesh.uvs.reserve_exact(if has_uvs { count } else { 0 });
        let mut slots = vec![NONE; element.properties.len()];
        for (slot, &property) in wanted.iter().enumerate() {
            if property != NONE {
                slots[property] = slot;
            }
        }
        if element.properties.is_empty() {
            return Ok(());
        }
        for i in 0..element.count {
            let mut values = [0.0; 8];
            for (property, &slot) in element.properties.iter().zip(&slots) {
                if slot != NONE && property.count.is_none() {
                    values[slot] = body
                        .float(property.scalar)
                        .map_err(|trouble| self.trouble(&trouble, element, i, body))?;
                } else {
                    self.skip_property(property, element, i, body)?;
                }
            }
            let [x, y, z, nx, ny, nz, u, v] = values;
            self.mesh.positions.push(Vec3::new(x, y, z));
            if has_normals {
                self.mesh.normals.push(Vec3::new(nx, ny, nz));
            }
            if has_uvs {
                self.mesh.uvs.push(Vec2::new(u, v));
            }
        }
        Ok(())
    }

    fn faces<B: Body>(&mut self, element: &Element, body: &mut B) -> Result<(), SceneError> {
        let indices = self.index_list(element)?;
        self.note_unread(element, |i| i == indices);
        self.check_triangles(element.count, element)?;
        self.mesh.triangles.reserve(element.count as usize);
        let (mut face, mut corners) = (Vec::new(), Vec::new());
        for i in 0..element.count {
            for (j, property) in element.properties.iter().enumerate() {
                match property.count {
                    Some(_) if j == indices => {
                        self.index_list_of(property, element, i, body, &mut face)?;
                    }
                    _ => self.skip_property(property, element, i, body)?,
                }
            }
            // Its indices are in range, and a triangle is a triangle.
            let triangles = &mut self.mesh.triangles;
            match *face {
                [a, b, c] => triangles.push([a, b, c]),
                [] | [_] | [_, _] => {
                    let (count, _) = self.too_small.get_or_insert((0, i));
                    *count += 1;
                }
                _ => {
                    corners.clear();
                    corners.extend(face.iter().map(|&v| self.mesh.positions[v as usize]));
                    self.cuts.triangulate(&corners, |t| {
                        triangles.push(t.map(|corner| face[corner as usize]));
                    });
                    self.check_triangles(self.mesh.triangles.len() as u64, element)?;
                }
            }
        }
        Ok(())
    }

    /// Strips: each further vertex makes a triangle with the two before it, every second one
    /// turned; −1 begins a new strip.
    fn strips<B: Body>(&mut self, element: &Element, body: &mut B) -> Result<(), SceneError> {
        let indices = self.index_list(element)?;
        self.note_unread(element, |i| i == indices);
        for i in 0..element.count {
            for (j, property) in element.properties.iter().enumerate() {
                let Some(count) = property.count.filter(|_| j == indices) else {
                    self.skip_property(property, element, i, body)?;
                    continue;
                };
                let length = self.list_length(property, count, element, i, body)?;
                self.mesh.triangles.reserve(length);
                let mut strip: [Option<u32>; 2] = [None; 2];
                let mut turned = false;
                for _ in 0..length {
                    let start = body.at();
                    let index = body
                        .integer(property.scalar)
                        .map_err(|trouble| self.trouble(&trouble, element, i, body))?;
                    if index == -1 {
                        strip = [None; 2];
                        turned = false;
                        continue;
                    }
                    let c = self.checked_index(index, element, i, body, start)?;
                    if let [Some(a), Some(b)] = strip {
                        // Triangles with a corner twice only lead from one part to the next.
                        if a != b && b != c && c != a {
                            let triangle = if turned { [b, a, c] } else { [a, b, c] };
                            self.mesh.triangles.push(triangle);
                        }
                        turned = !turned;
                    }
                    strip = [strip[1], Some(c)];
                }
                self.check_triangles(self.mesh.triangles.len() as u64, element)?;
            }
        }
        Ok(())
    }

    fn check_triangles(&self, asked: u64, element: &Element) -> Result<(), SceneError> {
        let allowed = self.limits.triangles;
        if asked <= allowed {
            return Ok(());
        }
        let kind = SceneErrorKind::Limit { what: "triangles", asked, allowed };
        Err(self.error_at(element.at, kind))
    }

    /// Which property of a face names its vertices.
    fn index_list(&self, element: &Element) -> Result<usize, SceneError> {
        let name = |p: &Property| p.name == "vertex_indices" || p.name == "vertex_index";
        let found = element.properties.iter().position(|p| p.count.is_some() && name(p));
        let Some(found) = found else {
            return Err(self.invalid_at(
                element.at,
                format!("element \"{}\" has no list \"vertex_indices\"", shown(&element.name)),
            ));
        };
        let property = &element.properties[found];
        if !property.scalar.is_integer() {
            let what = format!("\"{}\" must be of an integer type", shown(&property.name));
            return Err(self.invalid_at(property.at, what));
        }
        Ok(found)
    }

    /// The vertices that a list names, into `face`.
    fn index_list_of<B: Body>(
        &self,
        property: &Property,
        element: &Element,
        i: u64,
        body: &mut B,
        face: &mut Vec<u32>,
    ) -> Result<(), SceneError> {
        let Some(count) = property.count else { return Ok(()) };
        let length = self.list_length(property, count, element, i, body)?;
        face.clear();
        for _ in 0..length {
            let start = body.at();
            let index = body
                .integer(property.scalar)
                .map_err(|trouble| self.trouble(&trouble, element, i, body))?;
            face.push(self.checked_index(index, element, i, body, start)?);
        }
        Ok(())
    }

    /// An index as a vertex number, if there is such a vertex; it was read at `start`.
    #[inline]
    fn checked_index<B: Body>(
        &self,
        index: i64,
        element: &Element,
        i: u64,
        body: &mut B,
        start: usize,
    ) -> Result<u32, SceneError> {
        let count = self.mesh.positions.len();
        match u32::try_from(index) {
            Ok(vertex) if (vertex as usize) < count => Ok(vertex),
            _ => {
                body.go_to(start);
                let what = format!(
                    "{} {i} names vertex {index}, but there are only {count} (numbered from 0)",
                    singular(&element.name)
                );
                Err(self.error_in_body(what, body))
            }
        }
    }

    /// How many numbers a list has; so many bytes are there.
    #[inline]
    fn list_length<B: Body>(
        &self,
        property: &Property,
        count: Scalar,
        element: &Element,
        i: u64,
        body: &mut B,
    ) -> Result<usize, SceneError> {
        let start = body.at();
        let length =
            body.integer(count).map_err(|trouble| self.trouble(&trouble, element, i, body))?;
        // The last number of a text needs no blank behind it.
        let most = (body.left() + 1) / B::least_size(property.scalar);
        match usize::try_from(length) {
            Ok(length) if length <= most => Ok(length),
            _ => {
                let left = body.left();
                body.go_to(start);
                let what = format!(
                    "{} {i} has a list \"{}\" of {length} numbers, but only {left} bytes are left",
                    singular(&element.name),
                    shown(&property.name)
                );
                Err(self.error_in_body(what, body))
            }
        }
    }

    fn skip<B: Body>(&self, element: &Element, body: &mut B) -> Result<(), SceneError> {
        if element.properties.is_empty() {
            return Ok(());
        }
        for i in 0..element.count {
            for property in &element.properties {
                self.skip_property(property, element, i, body)?;
            }
        }
        Ok(())
    }

    fn skip_property<B: Body>(
        &self,
        property: &Property,
        element: &Element,
        i: u64,
        body: &mut B,
    ) -> Result<(), SceneError> {
        let count = match property.count {
            None => 1,
            Some(count) => self.list_length(property, count, element, i, body)?,
        };
        body.skip(property.scalar, count)
            .map_err(|trouble| self.trouble(&trouble, element, i, body))
    }

    /// One note for all properties of an element that nobody reads.
    fn note_unread(&mut self, element: &Element, read: impl Fn(usize) -> bool) {
        let mut unread = element
            .properties
            .iter()
            .enumerate()
            .filter(|(i, property)| !read(*i) && !is_color(&property.name));
        let names: Vec<_> = unread.by_ref().take(8).map(|(_, p)| shown(&p.name)).collect();
        if !names.is_empty() {
            let dots = if unread.next().is_some() { ", …" } else { "" };
            let names = names.join(", ");
            let element = shown(&element.name);
            self.note(&format!("properties of \"{element}\" left out: {names}{dots}"));
        }
    }

    fn note(&mut self, what: &str) {
        self.notes.push(format!("{}: {what}", self.path.display()));
    }

    /// A mistake in the header.
    fn invalid_at(&self, at: usize, what: String) -> SceneError {
        self.error_at(at, SceneErrorKind::Invalid(what))
    }

    /// An error in the header.
    fn error_at(&self, at: usize, kind: SceneErrorKind) -> SceneError {
        SceneError { at: place(self.path, self.bytes, at), kind }
    }

    /// An error at the next number of the body.
    #[cold]
    fn error_in_body<B: Body>(&self, what: String, body: &B) -> SceneError {
        let at = body.place(self.path, self.bytes).unwrap_or_else(|| Source::file(self.path));
        SceneError { at, kind: SceneErrorKind::Invalid(what) }
    }

    #[cold]
    fn trouble<B: Body>(
        &self,
        trouble: &Trouble,
        element: &Element,
        i: u64,
        body: &B,
    ) -> SceneError {
        let (name, count) = (singular(&element.name), element.count);
        let what = match trouble {
            Trouble::End => format!("the file ends in {name} {i} of {count}"),
            Trouble::NotANumber => {
                let mut there = Cursor::at(self.bytes, body.at());
                there.skip_space();
                let word = word_at(self.bytes, there.at);
                format!("{word} in {name} {i} is not a number of its type")
            }
        };
        self.error_in_body(what, body)
    }
}

/// Whether a property is part of a colour, by the names that scanners and modelling programs
/// give them: a colour is the material's business.
fn is_color(name: &str) -> bool {
    let part =
        ["diffuse_", "ambient_", "specular_"].iter().find_map(|kind| name.strip_prefix(kind));
    matches!(part.unwrap_or(name), "red" | "green" | "blue" | "alpha" | "r" | "g" | "b" | "a")
}

/// An element's name for one of them.
fn singular(name: &str) -> String {
    match name {
        "tristrips" => "strip".to_owned(),
        name => shown(name),
    }
}
