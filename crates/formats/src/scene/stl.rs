//! STL, the format of 3D printing and machining: triangles and nothing else, in ASCII or binary.
//!
//! A file is binary where its length is what the count behind its first 80 bytes says; many binary
//! files begin with `solid` as those in ASCII do, so that word decides only where the length does
//! not. Corners at the same place become one vertex. The normals of facets are left out: they tell
//! nothing that the order of the corners does not, and many programs write nought.
//!
//! Lengths have no unit and no axis is up: numbers are taken as metres, and nothing is turned.
//! Colours, which some programs hide in the last two bytes of a facet, are left out.
//!
//! Source: 3D Systems, *StereoLithography Interface Specification*, 1988.

use super::polygon::Triangulator;
use super::text::{Cursor, place, word_at};
use crate::error::{SceneError, SceneErrorKind};
use crate::file;
use crate::limits::Limits;
use rutilant::shape::Mesh;
use rutilant_geom::Vec3;
use std::collections::HashMap;
use std::path::Path;

/// The mesh in the STL file at `path`, and notes on what was left out.
///
/// # Errors
/// A file that cannot be read, breaks the format, ends early or exceeds the `limits`.
pub fn read(path: &Path, limits: &Limits) -> Result<(Mesh, Vec<String>), SceneError> {
    read_bytes(&file::scene_bytes(path, limits)?, path, limits)
}

/// As [`read`], for the content of a file; `path` is for messages and the name of a mesh without one.
///
/// # Errors
/// As [`read`].
pub fn read_bytes(
    bytes: &[u8],
    path: &Path,
    limits: &Limits,
) -> Result<(Mesh, Vec<String>), SceneError> {
    let mut reader = Reader {
        path,
        bytes,
        limits,
        mesh: Mesh::default(),
        vertices: HashMap::new(),
        notes: Vec::new(),
    };
    match facets(bytes) {
        Some(count) if is_exact(bytes, count) => reader.binary(count)?,
        counted => {
            let mut words = Cursor::new(bytes);
            words.skip_space();
            match counted {
                Some(count) if !is_text(bytes) => reader.binary(count)?,
                _ if words.word().eq_ignore_ascii_case(b"solid") => reader.text()?,
                _ => {
                    let what = "this is no STL file: it neither begins with \"solid\" nor has as \
                                many bytes as a binary one";
                    return Err(SceneError::invalid_file(path, what));
                }
            }
        }
    }
    if reader.mesh.name.is_empty() {
        reader.mesh.name = file::title(path);
    }
    Ok((reader.mesh, reader.notes))
}

/// The first bytes of a binary file, which say nothing.
const HEADER: usize = 80;
/// Bytes of a facet: its normal and three corners of three numbers, and two more.
const FACET: usize = 50;

/// How many facets a binary file says that it has; `None` where it is too short to say.
fn facets(bytes: &[u8]) -> Option<u32> {
    bytes.get(HEADER..)?.first_chunk().map(|count| u32::from_le_bytes(*count))
}

/// Whether a file is as long as so many facets are.
fn is_exact(bytes: &[u8], count: u32) -> bool {
    (HEADER + 4) as u64 + u64::from(count) * FACET as u64 == bytes.len() as u64
}

/// Whether the beginning of a file is text.
fn is_text(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(512)];
    head.iter().all(|&byte| byte >= 0x20 || matches!(byte, b'\t' | b'\n' | b'\r' | 0x0c))
}

struct Reader<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    limits: &'a Limits,
    mesh: Mesh,
    /// The number of the vertex with these bits.
    vertices: HashMap<[u32; 3], u32>,
    notes: Vec<String>,
}

impl Reader<'_> {
    fn binary(&mut self, count: u32) -> Result<(), SceneError> {
        let facets = self.bytes[HEADER + 4..].chunks_exact(FACET);
        let there = facets.len() as u64;
        if there < u64::from(count) {
            let what = format!("the file ends in facet {there} of {count}");
            return Err(SceneError::invalid_file(self.path, what));
        }
        if !is_exact(self.bytes, count) {
            let more = self.bytes.len() - HEADER - 4 - count as usize * FACET;
            let path = self.path.display();
            self.notes.push(format!("{path}: {more} bytes behind the last facet are left out"));
        }
        for facet in facets.take(count as usize) {
            let number = |i: usize| {
                let bytes = facet.get(12 + 4 * i..).and_then(|rest| rest.first_chunk());
                f32::from_le_bytes(*bytes.unwrap_or(&[0; 4]))
            };
            let corner = |i: usize| Vec3::new(number(3 * i), number(3 * i + 1), number(3 * i + 2));
            self.triangle([corner(0), corner(1), corner(2)], None)?;
        }
        Ok(())
    }

    /// Solids one behind the other; how their words are spread over lines has no meaning.
    fn text(&mut self) -> Result<(), SceneError> {
        let mut cursor = Cursor::new(self.bytes);
        let mut cuts = Triangulator::new();
        let mut corners = Vec::new();
        let mut solids = 0_u64;
        loop {
            cursor.skip_space();
            if cursor.peek().is_none() {
                break;
            }
            self.expect(&mut cursor, "solid")?;
            let name = cursor.name();
            if solids == 0 {
                self.mesh.name = name;
            }
            solids += 1;
            while self.either(&mut cursor, "facet", "endsolid")? {
                self.expect(&mut cursor, "normal")?;
                for _ in 0..3 {
                    self.number(&mut cursor)?;
                }
                self.expect(&mut cursor, "outer")?;
                self.expect(&mut cursor, "loop")?;
                let at = cursor.at;
                corners.clear();
                while self.either(&mut cursor, "vertex", "endloop")? {
                    let [x, y, z] = [(); 3].map(|()| self.number(&mut cursor));
                    corners.push(Vec3::new(x?, y?, z?));
                }
                if corners.len() < 3 {
                    let what = format!("a facet has {} corners, but needs 3", corners.len());
                    return Err(self.invalid(at, what));
                }
                let mut result = Ok(());
                cuts.triangulate(&corners, |triangle| {
                    let triangle = triangle.map(|i| corners[i as usize]);
                    if result.is_ok() {
                        result = self.triangle(triangle, Some(at));
                    }
                });
                result?;
                self.expect(&mut cursor, "endfacet")?;
            }
            cursor.name();
        }
        if solids > 1 {
            let path = self.path.display();
            self.notes.push(format!("{path}: its {solids} solids are taken together as one mesh"));
        }
        Ok(())
    }

    fn triangle(&mut self, corners: [Vec3; 3], at: Option<usize>) -> Result<(), SceneError> {
        let too_many = |what: &'static str, allowed: u64| {
            let kind = SceneErrorKind::Limit { what, asked: allowed.saturating_add(1), allowed };
            match at {
                Some(at) => SceneError { at: place(self.path, self.bytes, at), kind },
                None => SceneError::in_file(self.path, kind),
            }
        };
        if self.mesh.triangles.len() as u64 >= self.limits.triangles {
            return Err(too_many("triangles", self.limits.triangles));
        }
        let most = self.limits.vertices.min(u64::from(u32::MAX));
        let mut triangle = [0; 3];
        for (vertex, corner) in triangle.iter_mut().zip(corners) {
            // −0 is where 0 is.
            let bits = corner.to_array().map(|c| (c + 0.0).to_bits());
            *vertex = match self.vertices.get(&bits) {
                Some(known) => *known,
                None => {
                    let next = self.mesh.positions.len();
                    if next as u64 >= most {
                        return Err(too_many("vertices", most));
                    }
                    self.mesh.positions.push(corner);
                    self.vertices.insert(bits, next as u32);
                    next as u32
                }
            };
        }
        self.mesh.triangles.push(triangle);
        Ok(())
    }

    /// Takes a word that must come next, in letters of any size.
    fn expect(&self, cursor: &mut Cursor<'_>, word: &str) -> Result<(), SceneError> {
        cursor.skip_space();
        let at = cursor.at;
        if cursor.word().eq_ignore_ascii_case(word.as_bytes()) {
            return Ok(());
        }
        Err(self.instead(at, &format!("\"{word}\"")))
    }

    /// Takes one of two words; whether it was the first.
    fn either(&self, cursor: &mut Cursor<'_>, one: &str, other: &str) -> Result<bool, SceneError> {
        cursor.skip_space();
        let at = cursor.at;
        let word = cursor.word();
        if word.eq_ignore_ascii_case(one.as_bytes()) {
            return Ok(true);
        }
        if word.eq_ignore_ascii_case(other.as_bytes()) {
            return Ok(false);
        }
        Err(self.instead(at, &format!("\"{one}\" or \"{other}\"")))
    }

    fn number(&self, cursor: &mut Cursor<'_>) -> Result<f32, SceneError> {
        cursor.skip_space();
        let at = cursor.at;
        cursor.number().ok_or_else(|| self.instead(at, "a number"))
    }

    #[cold]
    fn instead(&self, at: usize, wanted: &str) -> SceneError {
        if at >= self.bytes.len() {
            return self.invalid(at, format!("the file ends where {wanted} should stand"));
        }
        self.invalid(at, format!("{} instead of {wanted}", word_at(self.bytes, at)))
    }

    #[cold]
    fn invalid(&self, at: usize, what: String) -> SceneError {
        let at = place(self.path, self.bytes, at);
        SceneError { at, kind: SceneErrorKind::Invalid(what) }
    }
}
