//! The elements of a PLY file in their order: vertices, and steps over what nobody reads.
//!
//! How faces become triangles stands in `faces.rs`.

use super::header::{Element, Format, Header, Property, Scalar};
use super::numbers::{Body, Trouble};
use crate::error::{SceneError, SceneErrorKind, Source};
use crate::limits::Limits;
use crate::scene::polygon::Triangulator;
use crate::scene::text::{Cursor, place, word_at};
use crate::shown::shown;
use rutilant::shape::Mesh;
use rutilant_geom::{Vec2, Vec3};
use std::path::Path;

/// Where further sets of texture coordinates begin among the properties wanted.
const FIRST_SET: usize = 16;

/// At most so many sets of texture coordinates are read beside the first one.
pub(super) const MORE_SETS: usize = 15;

/// The direction in which u grows, and the side to which v does.
pub(super) const TANGENT: [&str; 4] = ["tx", "ty", "tz", "tw"];

/// Scene-linear, where they are floating-point numbers.
pub(super) const COLOR: [&str; 4] = ["red", "green", "blue", "alpha"];

/// A mesh on its way out of a file.
pub(super) struct Reader<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) path: &'a Path,
    pub(super) limits: &'a Limits,
    pub(super) mesh: Mesh,
    pub(super) notes: Vec<String>,
    pub(super) cuts: Triangulator,
    /// How many faces have fewer than three corners, and the number of the first.
    pub(super) too_small: Option<(u64, u64)>,
}

impl<'a> Reader<'a> {
    pub(super) fn new(bytes: &'a [u8], path: &'a Path, limits: &'a Limits) -> Self {
        Self {
            bytes,
            path,
            limits,
            mesh: Mesh::default(),
            notes: Vec::new(),
            cuts: Triangulator::new(),
            too_small: None,
        }
    }

    pub(super) fn body<B: Body>(
        &mut self,
        header: &Header,
        body: &mut B,
    ) -> Result<(), SceneError> {
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
        // The properties wanted: x y z, a normal, texture coordinates, a tangent, a colour, then
        // further sets of texture coordinates.
        const NONE: usize = usize::MAX;
        let mut wanted = vec![NONE; FIRST_SET];
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
        if let [Some(x), Some(y), Some(z), Some(w)] = TANGENT.map(|name| element.find(name)) {
            wanted[8..12].copy_from_slice(&[x, y, z, w]);
        }
        // Whole numbers are what scanners and photographs saw: not light, and not read.
        let float = |name| {
            let is_float = |i: &usize| !element.properties[*i].scalar.is_integer();
            element.find(name).filter(is_float)
        };
        let [red, green, blue, alpha] = COLOR.map(float);
        if let [Some(red), Some(green), Some(blue)] = [red, green, blue] {
            wanted[12..16].copy_from_slice(&[red, green, blue, alpha.unwrap_or(NONE)]);
        }
        for set in 1..=MORE_SETS {
            let pair = |u: &str, v: &str| [u, v].map(|name| element.find(&format!("{name}{set}")));
            let found = [pair("s", "t"), pair("u", "v")].into_iter().find_map(|pair| match pair {
                [Some(u), Some(v)] => Some([u, v]),
                [_, _] => None,
            });
            wanted.extend(found.unwrap_or([NONE; 2]));
        }
        let used = wanted.iter().rposition(|&property| property != NONE).unwrap_or(0) + 1;
        wanted.truncate(used.next_multiple_of(2).max(FIRST_SET));
        self.note_unread(element, |i| wanted.contains(&i));

        // The bytes for them are there: `must_fit` has counted.
        let count = element.count as usize;
        let (has_normals, has_uvs) = (wanted[3] != NONE, wanted[6] != NONE);
        self.mesh.positions.reserve_exact(count);
        self.mesh.normals.reserve_exact(if has_normals { count } else { 0 });
        self.mesh.uvs.reserve_exact(if has_uvs { count } else { 0 });
        let (has_tangents, has_colors) = (wanted[8] != NONE, wanted[12] != NONE);
        self.mesh.tangents.reserve_exact(if has_tangents { count } else { 0 });
        self.mesh.colors.reserve_exact(if has_colors { count } else { 0 });
        let has_set: Vec<bool> =
            wanted[FIRST_SET..].chunks(2).map(|pair| pair[0] != NONE).collect();
        let sets = has_set.iter().map(|has| Vec::with_capacity(if *has { count } else { 0 }));
        self.mesh.more_uvs = sets.collect();
        let mut slots = vec![NONE; element.properties.len()];
        for (slot, &property) in wanted.iter().enumerate() {
            if property != NONE {
                slots[property] = slot;
            }
        }
        if element.properties.is_empty() {
            return Ok(());
        }
        let mut values = vec![0.0; wanted.len()];
        values[15] = 1.0;
        for i in 0..element.count {
            for (property, &slot) in element.properties.iter().zip(&slots) {
                if slot != NONE && property.count.is_none() {
                    values[slot] = body
                        .float(property.scalar)
                        .map_err(|trouble| self.trouble(&trouble, element, i, body))?;
                } else {
                    self.skip_property(property, element, i, body)?;
                }
            }
            let Some((&[x, y, z, nx, ny, nz, u, v], rest)) = values.split_first_chunk() else {
                continue;
            };
            self.mesh.positions.push(Vec3::new(x, y, z));
            if has_normals {
                self.mesh.normals.push(Vec3::new(nx, ny, nz));
            }
            if has_uvs {
                self.mesh.uvs.push(Vec2::new(u, v));
            }
            let (fours, _) = rest.as_chunks::<4>();
            if let (true, Some(tangent)) = (has_tangents, fours.first()) {
                self.mesh.tangents.push(*tangent);
            }
            if let (true, Some(color)) = (has_colors, fours.get(1)) {
                self.mesh.colors.push(*color);
            }
            let (pairs, _) = values[FIRST_SET..].as_chunks::<2>();
            for ((set, has), &uv) in self.mesh.more_uvs.iter_mut().zip(&has_set).zip(pairs) {
                if *has {
                    set.push(Vec2::from_array(uv));
                }
            }
        }
        Ok(())
    }

    /// How many numbers a list has; so many bytes are there.
    #[inline]
    pub(super) fn list_length<B: Body>(
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

    pub(super) fn skip_property<B: Body>(
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
    pub(super) fn note_unread(&mut self, element: &Element, read: impl Fn(usize) -> bool) {
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
    pub(super) fn invalid_at(&self, at: usize, what: String) -> SceneError {
        self.error_at(at, SceneErrorKind::Invalid(what))
    }

    /// An error in the header.
    pub(super) fn error_at(&self, at: usize, kind: SceneErrorKind) -> SceneError {
        SceneError { at: place(self.path, self.bytes, at), kind }
    }

    /// An error at the next number of the body.
    #[cold]
    pub(super) fn error_in_body<B: Body>(&self, what: String, body: &B) -> SceneError {
        let at = body.place(self.path, self.bytes).unwrap_or_else(|| Source::file(self.path));
        SceneError { at, kind: SceneErrorKind::Invalid(what) }
    }

    #[cold]
    pub(super) fn trouble<B: Body>(
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
pub(super) fn singular(name: &str) -> String {
    match name {
        "tristrips" => "strip".to_owned(),
        name => shown(name),
    }
}
