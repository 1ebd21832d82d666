//! Wavefront OBJ: vertices, faces, and the names of materials from MTL files.
//!
//! The bytes are walked once. Faces are cut into triangles where they stand and
//! collected per material; groups (`g`, `o`) and smoothing groups (`s`) do not
//! split meshes. In the end each material's corners become a mesh, in which a
//! corner that comes again is stored once.
//!
//! Where only some faces of a material have normals, the others are shaded
//! flat, by the normal of each triangle. Where only some have texture
//! coordinates, the others get (0, 0). Points, lines, free-form curves and
//! surfaces are left out, with a note; vertex colours and weights too.
//!
//! Source: Wavefront, *Advanced Visualizer Manual*, Appendix B1, 1992.

use super::files::{Fence, find_mentioned, why_not_found};
use super::mtl;
use super::pictures::{self, Pictures, Wanted};
use super::polygon::Triangulator;
use super::text::{Cursor, place, word_at};
use crate::error::{SceneError, SceneErrorKind};
use crate::file;
use crate::limits::Limits;
use crate::shown::{few, quoted, shown};
use rutilant::material::{Material, MaterialKind};
use rutilant::scene::{BitmapId, MaterialId};
use rutilant::shape::Mesh;
use rutilant::texture::ImageTexture;
use rutilant_geom::{Vec2, Vec3};
use std::collections::{HashMap, HashSet};
use std::path::{Display, Path, PathBuf};

/// What an OBJ file holds.
#[derive(Clone, Debug, Default)]
pub struct ObjScene {
    /// The mesh of each material, in the order of their first faces, with the material's name;
    /// `None` for faces before the first `usemtl`.
    pub meshes: Vec<(Mesh, Option<String>)>,
    /// The materials of all MTL files, with their names. Some meshes may name others. The parts
    /// of a mix follow it, without a name; it counts them in this list.
    pub materials: Vec<Material>,
    /// The textures that these use, which count their bitmaps in `pictures`.
    pub textures: Vec<ImageTexture>,
    /// The pictures that these show, found beside the MTL files that name them.
    pub(crate) pictures: Pictures,
    /// What was left out or changed, for people: one line each.
    pub notes: Vec<String>,
}

/// The meshes in the OBJ file at `path` and the materials in the MTL files it names.
///
/// MTL files are looked for in the folder of the OBJ file and below, never
/// above, symbolic links followed. A missing one is a note, not an error: the
/// meshes keep the names of their materials.
///
/// # Errors
/// A file that cannot be read, breaks the format or exceeds the `limits`.
pub fn read(path: &Path, limits: &Limits) -> Result<ObjScene, SceneError> {
    read_within(path, limits, &Fence::around(path))
}

/// As [`read`], with MTL files from anywhere inside the `fence`: that of the scene which names
/// the OBJ file.
pub(super) fn read_within(
    path: &Path,
    limits: &Limits,
    fence: &Fence,
) -> Result<ObjScene, SceneError> {
    let bytes = file::scene_bytes(path, limits)?;
    let mut parsed = parse(&bytes, path, limits)?;
    // What follows needs memory, and the text no more.
    drop(bytes);

    parsed.read_libraries(fence)?;
    parsed.build()
}

/// As [`read`], for the content of a file, without its MTL files; `path` is only for messages.
///
/// # Errors
/// As [`read`].
pub fn read_bytes(bytes: &[u8], path: &Path, limits: &Limits) -> Result<ObjScene, SceneError> {
    parse(bytes, path, limits)?.build()
}

/// An OBJ file names at most so many MTL files: a hostile one might name the same over and over.
const MOST_LIBRARIES: usize = 256;

fn too_many_libraries() -> SceneErrorKind {
    let (asked, allowed) = (MOST_LIBRARIES as u64 + 1, MOST_LIBRARIES as u64);
    SceneErrorKind::Limit { what: "MTL files", asked, allowed }
}

/// No vertex, texture coordinate or normal.
const NONE: u32 = u32::MAX;

/// A corner of a face: numbers of its vertex, texture coordinate and normal.
#[derive(Clone, Copy, PartialEq)]
struct Corner {
    v: u32,
    vt: u32,
    vn: u32,
}

/// The triangles of one material, three corners each.
#[derive(Default)]
struct Group {
    material: Option<usize>,
    v: Vec<u32>,
    /// As long as `v`, or empty where no corner has a texture coordinate.
    vt: Vec<u32>,
    /// As long as `v`, or empty where no corner has a normal.
    vn: Vec<u32>,
}

impl Group {
    fn push(&mut self, corner: Corner) {
        push_sparse(&mut self.vt, self.v.len(), corner.vt);
        push_sparse(&mut self.vn, self.v.len(), corner.vn);
        self.v.push(corner.v);
    }
}

/// Appends to an array that stays empty until the first value is not [`NONE`].
fn push_sparse(array: &mut Vec<u32>, length: usize, value: u32) {
    if value != NONE && array.is_empty() {
        array.resize(length, NONE);
    }
    if value != NONE || !array.is_empty() {
        array.push(value);
    }
}

/// A file that has been walked through.
struct Parsed<'p> {
    path: &'p Path,
    limits: &'p Limits,
    positions: Vec<Vec3>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
    groups: Vec<Group>,
    /// The names of `usemtl`, each once.
    materials: Vec<String>,
    /// The names of `mtllib`, each once.
    libraries: Vec<String>,
    scene: ObjScene,
}

fn parse<'p>(bytes: &[u8], path: &'p Path, limits: &'p Limits) -> Result<Parsed<'p>, SceneError> {
    let mut parser = Parser {
        bytes,
        cursor: Cursor::new(bytes),
        out: Parsed {
            path,
            limits,
            positions: Vec::new(),
            uvs: Vec::new(),
            normals: Vec::new(),
            groups: Vec::new(),
            materials: Vec::new(),
            libraries: Vec::new(),
            scene: ObjScene::default(),
        },
        face: Vec::new(),
        corners: Vec::new(),
        cuts: Triangulator::new(),
        triangles: 0,
        group: None,
        group_of: HashMap::new(),
        material: None,
        material_of: HashMap::new(),
        left_out: LeftOut::default(),
    };
    parser.lines()?;
    Ok(parser.out)
}

struct Parser<'b, 'p> {
    bytes: &'b [u8],
    cursor: Cursor<'b>,
    out: Parsed<'p>,
    /// Scratch: the corners of a face, and their positions.
    face: Vec<Corner>,
    corners: Vec<Vec3>,
    cuts: Triangulator,
    triangles: u64,
    /// Where faces go; `None` until the first one after a `usemtl`.
    group: Option<usize>,
    group_of: HashMap<Option<usize>, usize>,
    material: Option<usize>,
    material_of: HashMap<String, usize>,
    left_out: LeftOut,
}

/// What was left out: how often, and where it stood first.
#[derive(Default)]
struct LeftOut {
    points_and_lines: Count,
    free_form: Count,
    small_faces: Count,
    unknown: Count,
}

#[derive(Default)]
struct Count {
    count: u64,
    first: usize,
}

impl Count {
    fn add(&mut self, at: usize) {
        if self.count == 0 {
            self.first = at;
        }
        self.count += 1;
    }
}

impl Parser<'_, '_> {
    fn lines(&mut self) -> Result<(), SceneError> {
        let mut known = false;
        while let Some((at, keyword)) = self.cursor.statement() {
            match keyword {
                b"v" => {
                    let [x, y, z] = self.numbers("v", 3)?;
                    self.check_count(self.out.positions.len(), at)?;
                    self.out.positions.push(Vec3::new(x, y, z));
                }
                b"vn" => {
                    let [x, y, z] = self.numbers("vn", 3)?;
                    self.check_count(self.out.normals.len(), at)?;
                    self.out.normals.push(Vec3::new(x, y, z));
                }
                b"vt" => {
                    let [u, v, _] = self.numbers("vt", 1)?;
                    self.check_count(self.out.uvs.len(), at)?;
                    self.out.uvs.push(Vec2::new(u, v));
                }
                // `fo` is the name that versions before 3.0 used.
                b"f" | b"fo" => self.face(at)?,
                b"usemtl" => self.use_material(),
                b"mtllib" => {
                    let name = self.cursor.name();
                    let libraries = &mut self.out.libraries;
                    if !name.is_empty() && !libraries.contains(&name) {
                        if libraries.len() == MOST_LIBRARIES {
                            return Err(self.error(at, too_many_libraries()));
                        }
                        libraries.push(name);
                    }
                }
                // Names, smoothing, and hints for other renderers.
                b"o" | b"g" | b"s" | b"mg" | b"lod" | b"shadow_obj" | b"trace_obj" | b"usemap"
                | b"maplib" | b"bevel" | b"c_interp" | b"d_interp" => {}
                b"p" | b"l" => self.left_out.points_and_lines.add(at),
                b"vp" | b"cstype" | b"deg" | b"bmat" | b"step" | b"curv" | b"curv2" | b"surf"
                | b"parm" | b"trim" | b"hole" | b"scrv" | b"sp" | b"end" | b"con" | b"ctech"
                | b"stech" | b"bzp" | b"bsp" | b"cdc" | b"cdp" | b"res" => {
                    self.left_out.free_form.add(at);
                }
                _ => self.left_out.unknown.add(at),
            }
            known |= self.left_out.unknown.count == 0;
            self.cursor.skip_line();
        }
        if !known && self.left_out.unknown.count > 0 {
            let at = self.left_out.unknown.first;
            let word = word_at(self.bytes, at);
            return Err(self.invalid(at, format!("{word} begins no OBJ statement")));
        }
        self.write_notes();
        Ok(())
    }

    /// The numbers of a `v`, `vn` or `vt`: at least `least`, at most three; those missing are 0.
    #[inline]
    fn numbers(&mut self, keyword: &str, least: usize) -> Result<[f32; 3], SceneError> {
        let mut numbers = [0.0; 3];
        for (i, number) in numbers.iter_mut().enumerate() {
            if self.cursor.line_is_done() {
                if i < least {
                    let what = match (least, i) {
                        (1, _) => format!("{keyword} needs a number"),
                        (_, 0) => format!("{keyword} needs {least} numbers"),
                        _ => format!("{keyword} needs {least} numbers, but there are only {i}"),
                    };
                    return Err(self.invalid(self.cursor.at, what));
                }
                return Ok(numbers);
            }
            *number = match self.cursor.number() {
                Some(number) => number,
                None => return Err(self.not_a_number()),
            };
        }
        // What follows, weights and colours, is not used, but must be numbers.
        while !self.cursor.line_is_done() {
            if self.cursor.number().is_none() {
                return Err(self.not_a_number());
            }
        }
        Ok(numbers)
    }

    #[inline]
    fn check_count(&self, count: usize, at: usize) -> Result<(), SceneError> {
        let allowed = self.out.limits.vertices.min(u64::from(NONE - 1));
        if (count as u64) < allowed {
            return Ok(());
        }
        let asked = count as u64 + 1;
        Err(self.error(at, SceneErrorKind::Limit { what: "vertices", asked, allowed }))
    }

    fn use_material(&mut self) {
        let name = self.cursor.name();
        let materials = &mut self.out.materials;
        self.material = (!name.is_empty()).then(|| {
            *self.material_of.entry(name).or_insert_with_key(|name| {
                materials.push(name.clone());
                materials.len() - 1
            })
        });
        self.group = self.group_of.get(&self.material).copied();
    }

    fn face(&mut self, at: usize) -> Result<(), SceneError> {
        self.face.clear();
        while !self.cursor.line_is_done() {
            let start = self.cursor.at;
            let corner = self.corner()?;
            if let Some(first) = self.face.first()
                && ((first.vt == NONE) != (corner.vt == NONE)
                    || (first.vn == NONE) != (corner.vn == NONE))
            {
                let word = word_at(self.bytes, start);
                let what = format!("{word} is not of the form of the face's first corner");
                return Err(self.invalid(start, what));
            }
            self.face.push(corner);
        }
        if self.face.len() < 3 {
            self.left_out.small_faces.add(at);
            return Ok(());
        }

        let group = match self.group {
            Some(group) => group,
            None => {
                let group = self.out.groups.len();
                self.out.groups.push(Group { material: self.material, ..Group::default() });
                self.group_of.insert(self.material, group);
                self.group = Some(group);
                group
            }
        };
        let group = &mut self.out.groups[group];
        self.triangles += self.face.len() as u64 - 2;
        if let [a, b, c] = *self.face {
            group.push(a);
            group.push(b);
            group.push(c);
        } else {
            self.corners.clear();
            self.corners.extend(self.face.iter().map(|c| self.out.positions[c.v as usize]));
            self.cuts.triangulate(&self.corners, |triangle| {
                for corner in triangle {
                    group.push(self.face[corner as usize]);
                }
            });
        }
        let allowed = self.out.limits.triangles;
        if self.triangles > allowed {
            let asked = self.triangles;
            return Err(self.error(at, SceneErrorKind::Limit { what: "triangles", asked, allowed }));
        }
        Ok(())
    }

    /// One of `v`, `v/vt`, `v//vn` and `v/vt/vn`. Slashes with nothing behind them, which some
    /// exporters write, are accepted.
    #[inline]
    fn corner(&mut self) -> Result<Corner, SceneError> {
        let start = self.cursor.at;
        let mut corner = Corner { v: NONE, vt: NONE, vn: NONE };
        corner.v = self.index("vertex", self.out.positions.len())?;
        if self.cursor.take(b'/') {
            if !self.at_slash_or_end() {
                corner.vt = self.index("texture coordinate", self.out.uvs.len())?;
            }
            if self.cursor.take(b'/') && !self.at_slash_or_end() {
                corner.vn = self.index("normal", self.out.normals.len())?;
            }
        }
        if self.cursor.word_is_done() {
            return Ok(corner);
        }
        let word = word_at(self.bytes, start);
        let what = format!("{word} is not a corner; those are v, v/vt, v//vn or v/vt/vn");
        Err(self.invalid(start, what))
    }

    fn at_slash_or_end(&self) -> bool {
        self.cursor.peek() == Some(b'/') || self.cursor.word_is_done()
    }

    /// A reference to one of `count` things: from 1, or from −1 backwards.
    #[inline]
    fn index(&mut self, what: &str, count: usize) -> Result<u32, SceneError> {
        let start = self.cursor.at;
        let Some(index) = self.cursor.whole_number() else {
            let word = word_at(self.bytes, start);
            return Err(self.invalid(start, format!("{word} is not a {what} number")));
        };
        // Counts fit 32 bits, so nothing here overflows.
        let from_zero = if index > 0 { index - 1 } else { index.saturating_add(count as i64) };
        if index != 0 && (0..count as i64).contains(&from_zero) {
            return Ok(from_zero as u32);
        }
        let is_zero = index == 0;
        // As it is written: it may be larger than any number.
        let index = String::from_utf8_lossy(&self.bytes[start..self.cursor.at]);
        let index = shown(&index);
        let why = match count {
            _ if is_zero => "they are numbered from 1 (or from -1 backwards)".to_owned(),
            0 => "none is declared so far".to_owned(),
            1 => "only 1 is declared so far".to_owned(),
            _ => format!("only {count} are declared so far"),
        };
        Err(self.invalid(start, format!("face names {what} {index}, but {why}")))
    }

    #[cold]
    fn not_a_number(&self) -> SceneError {
        let word = word_at(self.bytes, self.cursor.at);
        self.invalid(self.cursor.at, format!("{word} is not a number"))
    }

    #[cold]
    fn invalid(&self, at: usize, what: String) -> SceneError {
        self.error(at, SceneErrorKind::Invalid(what))
    }

    #[cold]
    fn error(&self, at: usize, kind: SceneErrorKind) -> SceneError {
        SceneError { at: place(self.out.path, self.bytes, at), kind }
    }

    fn write_notes(&mut self) {
        let left_out = std::mem::take(&mut self.left_out);
        let unknown = word_at(self.bytes, left_out.unknown.first);
        let kinds = [
            (left_out.points_and_lines, "points and lines".to_owned()),
            (left_out.free_form, "statements of free-form curves and surfaces".to_owned()),
            (left_out.small_faces, "faces with fewer than 3 corners".to_owned()),
            (left_out.unknown, format!("unknown statements like {unknown}")),
        ];
        for (Count { count, first }, what) in kinds {
            if count > 0 {
                let source = place(self.out.path, self.bytes, first);
                self.out.scene.notes.push(format!("{source}: {what}, left out: {count}"));
            }
        }
        if self.cuts.cut_short > 0 {
            self.out.note(&format!(
                "faces with very many corners, cut into fans: {}",
                self.cuts.cut_short
            ));
        }
        if self.out.groups.is_empty() {
            self.out.note("there are no faces in it, so nothing of it can be seen");
        }
    }
}

impl Parsed<'_> {
    fn note(&mut self, what: &str) {
        self.scene.notes.push(format!("{}: {what}", self.path.display()));
    }

    /// Adds the materials of all MTL files.
    fn read_libraries(&mut self, fence: &Fence) -> Result<(), SceneError> {
        let mut known = HashSet::new();
        let mut paths = Vec::new();
        for name in std::mem::take(&mut self.libraries) {
            self.find_libraries(&name, fence, &mut paths);
        }
        if paths.len() > MOST_LIBRARIES {
            return Err(SceneError::in_file(self.path, too_many_libraries()));
        }
        let none = paths.is_empty();
        for path in paths {
            let library = mtl::read(&path, self.limits)?;
            self.scene.notes.extend(library.notes);
            let pictures: Vec<BitmapId> = library
                .pictures
                .into_iter()
                .map(|picture| self.scene.pictures.want(find_picture(&path, picture, fence)))
                .collect();
            let first = self.scene.textures.len() as u32;
            self.scene.textures.extend(library.textures.into_iter().map(|texture| ImageTexture {
                bitmap: pictures[texture.bitmap.0 as usize],
                ..texture
            }));
            let mut wanted = false;
            for mut material in library.materials {
                // The first file that has a material of some name is the one that counts. What
                // has no name is part of the mix before it.
                wanted = match material.name.is_empty() {
                    true => wanted,
                    false => known.insert(material.name.clone()),
                };
                if wanted {
                    let next = self.scene.materials.len() as u32 + 1;
                    if let MaterialKind::Mix(mix) = &mut material.kind {
                        (mix.first, mix.second) = (MaterialId(next), MaterialId(next + 1));
                    }
                    material.each_texture_mut(|id| id.0 += first);
                    self.scene.materials.push(material);
                }
            }
        }
        let mut unknown = self.materials.iter().filter(|name| !known.contains(*name));
        if let Some(first) = unknown.next().filter(|_| !none) {
            let first = quoted(first.as_bytes());
            let count = 1 + unknown.count();
            self.note(&format!("materials that are in no MTL file: {count} (first {first})"));
        }
        Ok(())
    }

    /// Finds the MTL files of one statement. It may name several, and a name may hold blanks: if
    /// there is no file of the whole name, its words are tried.
    fn find_libraries(&mut self, name: &str, fence: &Fence, found: &mut Vec<PathBuf>) {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        if let Some(path) = find_mentioned(folder, name, fence) {
            found.push(path);
            return;
        }
        let words = name.split_ascii_whitespace().take(MOST_LIBRARIES);
        match words.map(|word| find_mentioned(folder, word, fence)).collect::<Option<Vec<_>>>() {
            Some(paths) => found.extend(paths),
            None => {
                let mut names = std::iter::once(name).chain(name.split_ascii_whitespace());
                let why = names.find_map(|name| why_not_found(folder, name, fence));
                let name = quoted(name.as_bytes());
                self.note(&match why {
                    Some(why) => format!("MTL file {name} {why}: its materials are missing"),
                    None => format!("no MTL file {name} in its folder: its materials are missing"),
                });
            }
        }
    }

    /// Makes meshes of the groups.
    fn build(mut self) -> Result<ObjScene, SceneError> {
        let groups = std::mem::take(&mut self.groups);
        let mut scene = std::mem::take(&mut self.scene);

        // The most common case needs no work: every corner is a vertex, and they are all in one mesh.
        if let [group] = &*groups
            && group.vt.is_empty()
            && group.vn.is_empty()
        {
            let (triangles, _) = group.v.as_chunks::<3>();
            let name = group.material.map(|m| self.materials[m].clone());
            // How many there would be was not known before.
            self.positions.shrink_to_fit();
            let mesh = Mesh {
                name: name.clone().unwrap_or_default(),
                positions: self.positions,
                triangles: triangles.to_vec(),
                ..Mesh::default()
            };
            scene.meshes.push((mesh, name));
            return Ok(scene);
        }

        let mut welder = Welder::new(self.positions.len());
        let mut notes = [Vec::new(), Vec::new()];
        for group in groups {
            let name = group.material.map(|m| self.materials[m].clone());
            let mut mesh = self.mesh(&group, &mut welder, &mut notes)?;
            mesh.name = name.clone().unwrap_or_default();
            scene.meshes.push((mesh, name));
        }
        let [no_uv, no_normal] = notes;
        let what = "materials with triangles without texture coordinates, given (0, 0)";
        scene.notes.extend(few(&no_uv, what));
        let what = "materials with triangles without normals, shaded flat";
        scene.notes.extend(few(&no_normal, what));
        Ok(scene)
    }

    /// The mesh of one group; notes on triangles without texture coordinates, and without normals.
    fn mesh<'s>(
        &'s self,
        group: &Group,
        welder: &mut Welder,
        notes: &mut [Vec<(Display<'s>, String)>; 2],
    ) -> Result<Mesh, SceneError> {
        let (has_uvs, has_normals) = (!group.vt.is_empty(), !group.vn.is_empty());
        let mut mesh = Mesh::default();
        mesh.triangles.reserve_exact(group.v.len() / 3);
        let mut without = [0_u64; 2];
        let corner = |i: usize| Corner {
            v: group.v[i],
            vt: group.vt.get(i).copied().unwrap_or(NONE),
            vn: group.vn.get(i).copied().unwrap_or(NONE),
        };
        for first in (0..group.v.len()).step_by(3) {
            let corners = [corner(first), corner(first + 1), corner(first + 2)];
            without[0] += u64::from(has_uvs && corners[0].vt == NONE);
            let flat = has_normals && corners[0].vn == NONE;
            without[1] += u64::from(flat);
            let flat_normal = if flat { self.flat_normal(&corners) } else { Vec3::ZERO };
            mesh.triangles.push(corners.map(|corner| {
                // A vertex with the triangle's own normal is nobody else's.
                let (vertex, new) = if flat { welder.add_alone() } else { welder.add(corner) };
                if new {
                    mesh.positions.push(self.positions[corner.v as usize]);
                    if has_uvs {
                        mesh.uvs
                            .push(self.uvs.get(corner.vt as usize).copied().unwrap_or_default());
                    }
                    if has_normals {
                        let normal = self.normals.get(corner.vn as usize).copied();
                        mesh.normals.push(normal.unwrap_or(flat_normal));
                    }
                }
                vertex
            }));
        }
        welder.forget(&group.v);
        mesh.positions.shrink_to_fit();
        mesh.uvs.shrink_to_fit();
        mesh.normals.shrink_to_fit();

        let asked = mesh.positions.len() as u64;
        let allowed = self.limits.vertices;
        if asked > allowed {
            let kind = SceneErrorKind::Limit { what: "vertices", asked, allowed };
            return Err(SceneError::in_file(self.path, kind));
        }
        let material = match group.material {
            Some(material) => format!("material {}", quoted(self.materials[material].as_bytes())),
            None => "no material".to_owned(),
        };
        let all = mesh.triangles.len();
        let [no_uv, no_normal] = without;
        if no_uv > 0 {
            let what = "without texture coordinates, given (0, 0)";
            notes[0].push((
                self.path.display(),
                format!("triangles of {material} {what}: {no_uv} of {all}"),
            ));
        }
        if no_normal > 0 {
            let what = "without normals, shaded flat";
            notes[1].push((
                self.path.display(),
                format!("triangles of {material} {what}: {no_normal} of {all}"),
            ));
        }
        Ok(mesh)
    }

    fn flat_normal(&self, corners: &[Corner; 3]) -> Vec3 {
        let [a, b, c] =
            corners.map(|corner| self.positions[corner.v as usize].to_array().map(f64::from));
        let side = |p: [f64; 3], q: [f64; 3]| [q[0] - p[0], q[1] - p[1], q[2] - p[2]];
        let (u, v) = (side(a, b), side(a, c));
        let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
        Vec3::from_array(n.map(|n| if length > 0.0 { (n / length) as f32 } else { 0.0 }))
    }
}

/// Gives equal corners of a mesh the same number.
///
/// All corners with the same vertex form a chain, which in real files is a few
/// links long: a hash table without collisions.
struct Welder {
    /// The newest corner of each vertex.
    newest: Vec<u32>,
    corners: Vec<Link>,
}

struct Link {
    vt: u32,
    vn: u32,
    /// The next corner with the same vertex.
    older: u32,
}

/// A chain is searched this far; corners behind are stored again. That costs a few vertices at
/// the pole of a finely divided sphere, and keeps a hostile file from asking for the square of
/// its size.
const LONGEST_SEARCH: usize = 64;

impl Welder {
    fn new(vertices: usize) -> Self {
        Self { newest: vec![NONE; vertices], corners: Vec::new() }
    }

    /// The number of a corner, and whether it is new.
    #[inline]
    fn add(&mut self, corner: Corner) -> (u32, bool) {
        let newest = self.newest[corner.v as usize];
        let mut link = newest;
        for _ in 0..LONGEST_SEARCH {
            let Some(known) = self.corners.get(link as usize) else { break };
            if (known.vt, known.vn) == (corner.vt, corner.vn) {
                return (link, false);
            }
            link = known.older;
        }
        let number = self.corners.len() as u32;
        self.corners.push(Link { vt: corner.vt, vn: corner.vn, older: newest });
        self.newest[corner.v as usize] = number;
        (number, true)
    }

    /// The number of a corner that no other will share.
    fn add_alone(&mut self) -> (u32, bool) {
        let number = self.corners.len() as u32;
        self.corners.push(Link { vt: NONE, vn: NONE, older: NONE });
        (number, true)
    }

    /// Begins a new mesh; the last one used the vertices `used`.
    fn forget(&mut self, used: &[u32]) {
        for &vertex in used {
            self.newest[vertex as usize] = NONE;
        }
        self.corners.clear();
    }
}

/// The picture that an MTL file at `path` names.
fn find_picture(path: &Path, picture: mtl::Picture, fence: &Fence) -> Wanted {
    let mtl::Picture { name, at } = picture;
    let folder = path.parent().unwrap_or(Path::new(""));
    let from = match find_mentioned(folder, &name, fence) {
        Some(path) => {
            let identity = path.canonicalize().unwrap_or_else(|_| path.clone());
            pictures::From::File { path, identity }
        }
        None => {
            let quoted = quoted(name.as_bytes());
            let why = why_not_found(folder, &name, fence);
            let what = match why {
                Some(why) => format!("picture {quoted} {why}"),
                None => format!("there is no picture {quoted} beside the MTL file"),
            };
            pictures::From::Nowhere { name, what }
        }
    };
    Wanted { from, at }
}
