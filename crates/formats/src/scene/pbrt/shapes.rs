//! Shapes: meshes as they are, round ones whole or cut up into triangles.
//!
//! In pbrt a triangle's front is where its vertices run counter-clockwise, but where a mesh has
//! normals, these tell: such triangles are turned round here. `ReverseOrientation` turns both.

use super::description::Form;
use super::gzip;
use super::lexer::{Place, Texts};
use super::parameters::Parameters;
use super::parser::Parser;
use crate::error::{SceneError, SceneErrorKind};
use crate::file;
use crate::limits::Limits;
use crate::scene::nearest::nearest;
use crate::scene::{ply, round};
use crate::shown::shown;
use rayon::prelude::*;
use rutilant::shape::Mesh;
use rutilant_geom::{Vec2, Vec3, real};
use std::collections::HashMap;
use std::path::PathBuf;

/// Kinds that are read.
const KINDS: [&str; 7] =
    ["bilinearmesh", "cylinder", "disk", "plymesh", "quad", "sphere", "trianglemesh"];

/// Kinds that are known, and not read.
const REFUSED: [(&str, &str); 8] = [
    ("loopsubdiv", "subdivide it, and give the triangles as a trianglemesh or a PLY file"),
    ("curve", "give its surface as a trianglemesh or a PLY file"),
    ("nurbs", "give its surface as a trianglemesh or a PLY file"),
    ("heightfield", "give its surface as a trianglemesh or a PLY file"),
    ("heightfield2", "give its surface as a trianglemesh or a PLY file"),
    ("cone", "give its surface as a trianglemesh or a PLY file"),
    ("paraboloid", "give its surface as a trianglemesh or a PLY file"),
    ("hyperboloid", "give its surface as a trianglemesh or a PLY file"),
];

/// The PLY files of a scene, each once.
#[derive(Default)]
pub(super) struct PlyFiles {
    list: Vec<PlyFile>,
    known: HashMap<PathBuf, usize>,
}

struct PlyFile {
    path: PathBuf,
    /// The same for every name of the file.
    identity: PathBuf,
    /// Its content, where no disk is needed.
    embedded: Option<Vec<u8>>,
    place: Place,
}

/// A mesh that was read from a file.
pub(super) struct Read {
    /// With its fronts where pbrt has them.
    pub(super) mesh: Mesh,
    /// Whether that is how the file has it.
    pub(super) as_it_is: bool,
    pub(super) notes: Vec<String>,
}

impl PlyFiles {
    /// The files on the disk.
    pub(super) fn files(&self) -> impl Iterator<Item = PathBuf> {
        self.list.iter().filter(|ply| ply.embedded.is_none()).map(|ply| ply.identity.clone())
    }

    /// The file that a mesh comes from, where it is one on the disk that holds the mesh as it is.
    pub(super) fn file(&self, number: usize) -> Option<PathBuf> {
        let ply = &self.list[number];
        let plain = ply.embedded.is_none() && file::extension(&ply.path) == "ply";
        plain.then(|| ply.identity.clone())
    }

    /// Reads all of them, as many at once as there are threads.
    pub(super) fn read(&self, limits: &Limits, texts: &Texts) -> Result<Vec<Read>, SceneError> {
        let (mut vertices, mut triangles) = (0_u64, 0_u64);
        let mut all = Vec::with_capacity(self.list.len());
        for some in self.list.chunks(4 * rayon::current_num_threads()) {
            let read: Vec<_> = some.par_iter().map(|ply| ply.read(limits)).collect();
            for (read, ply) in read.into_iter().zip(some) {
                let read = read?;
                vertices += read.mesh.positions.len() as u64;
                triangles += read.mesh.triangles.len() as u64;
                for (what, asked, allowed) in [
                    ("vertices", vertices, limits.vertices),
                    ("triangles", triangles, limits.triangles),
                ] {
                    if asked > allowed {
                        let kind = SceneErrorKind::Limit { what, asked, allowed };
                        return Err(texts.error(ply.place, kind));
                    }
                }
                all.push(read);
            }
        }
        Ok(all)
    }
}

impl PlyFile {
    fn read(&self, limits: &Limits) -> Result<Read, SceneError> {
        let bytes = match &self.embedded {
            Some(bytes) => bytes.clone(),
            None => file::scene_bytes(&self.path, limits)?,
        };
        let bytes = gzip::unpacked(bytes, &self.path, limits)?;
        let (mesh, notes) = ply::read_bytes(&bytes, &self.path, limits)?;
        let (mesh, as_it_is) = oriented(mesh, false);
        Ok(Read { mesh, as_it_is, notes })
    }
}

/// The shape of a statement, and in how many parts pbrt takes it.
pub(super) fn read(
    kind: &str,
    parameters: &Parameters,
    parser: &mut Parser<'_>,
) -> Result<(Form, usize), SceneError> {
    let texts = &parser.texts;
    let place = parameters.place;
    let form = match kind {
        "trianglemesh" => triangles(parameters, texts)?,
        "bilinearmesh" => patches(parameters, texts)?,
        "plymesh" => {
            let name = parameters.text("filename", texts)?.unwrap_or_default().to_owned();
            parameters.ignore(&["edgelength"]);
            let number = wanted(&name, parameters.place_of("filename"), parser)?;
            return Ok((Form::File(number), 1));
        }
        "sphere" => {
            let radius = positive("radius", 1.0, parameters, texts)?;
            let low = parameters.number_or("zmin", -radius, texts)?.clamp(-radius, radius);
            let high = parameters.number_or("zmax", radius, texts)?.clamp(-radius, radius);
            let (low, high) = (low.min(high), low.max(high));
            let turn = turn(parameters, texts)?;
            if low <= -radius && high >= radius && turn >= 360.0 {
                Form::Sphere { radius }
            } else {
                let [south, north] = [low, high].map(|z| latitude(z / radius));
                Form::Mesh(round::sphere(radius, [south, north], turn))
            }
        }
        "disk" => {
            let radius = positive("radius", 1.0, parameters, texts)?;
            let inner = parameters.number_or("innerradius", 0.0, texts)?.clamp(0.0, radius);
            let height = parameters.number_or("height", 0.0, texts)?;
            let turn = turn(parameters, texts)?;
            if inner == 0.0 && turn >= 360.0 {
                Form::Disk { radius, height }
            } else {
                Form::Mesh(round::ring(radius, inner, height, turn))
            }
        }
        "cylinder" => {
            let radius = positive("radius", 1.0, parameters, texts)?;
            let low = parameters.number_or("zmin", -1.0, texts)?;
            let high = parameters.number_or("zmax", 1.0, texts)?;
            Form::Mesh(round::cylinder(
                radius,
                [low.min(high), low.max(high)],
                turn(parameters, texts)?,
            ))
        }
        other => {
            return Err(match REFUSED.iter().find(|(name, _)| *name == other) {
                Some((_, hint)) => texts
                    .unsupported(place, format!("shapes of type \"{other}\" are not read: {hint}")),
                None => texts.error(
                    place,
                    SceneErrorKind::Unknown {
                        what: "type of shapes",
                        name: shown(other),
                        closest: nearest(other, KINDS).map(str::to_owned),
                    },
                ),
            });
        }
    };
    let parts = match &form {
        Form::Mesh(mesh) => {
            for (what, asked, left, allowed) in [
                (
                    "vertices",
                    mesh.positions.len(),
                    &mut parser.vertices_left,
                    parser.limits.vertices,
                ),
                (
                    "triangles",
                    mesh.triangles.len(),
                    &mut parser.triangles_left,
                    parser.limits.triangles,
                ),
            ] {
                *left = left.checked_sub(asked as u64).ok_or_else(|| {
                    let asked = (allowed - *left).saturating_add(asked as u64);
                    parser.texts.error(place, SceneErrorKind::Limit { what, asked, allowed })
                })?;
            }
            match kind {
                "trianglemesh" => mesh.triangles.len(),
                "bilinearmesh" => mesh.triangles.len() / 2,
                _ => 1,
            }
        }
        Form::File(_) | Form::Sphere { .. } | Form::Disk { .. } => 1,
    };
    Ok((form, parts))
}

/// The number of a PLY file that is to be read.
fn wanted(name: &str, place: Place, parser: &mut Parser<'_>) -> Result<usize, SceneError> {
    let ply = match parser.files.embedded(name) {
        Some(bytes) => PlyFile {
            path: parser.files.path(name),
            identity: PathBuf::from(name),
            embedded: Some(bytes.to_owned()),
            place,
        },
        None => {
            let found = parser.files.find(name);
            let found = found.map_err(|what| parser.texts.invalid(place, what))?;
            PlyFile { path: found.path, identity: found.identity, embedded: None, place }
        }
    };
    let plies = &mut parser.ply;
    let next = plies.list.len();
    let number = *plies.known.entry(ply.identity.clone()).or_insert(next);
    if number == next {
        plies.list.push(ply);
    }
    Ok(number)
}

/// The latitude of a height above the equator of a sphere of radius 1, in degrees; exact at the poles.
fn latitude(height: f32) -> f32 {
    if height.abs() >= 1.0 { 90.0 * height.signum() } else { real::asin(height).to_degrees() }
}

fn positive(
    name: &str,
    default: f32,
    parameters: &Parameters,
    texts: &Texts,
) -> Result<f32, SceneError> {
    let value = parameters.number_or(name, default, texts)?;
    if value > 0.0 {
        return Ok(value);
    }
    let what = format!("{name} is {value}, but must be more than 0");
    Err(texts.invalid(parameters.place_of(name), what))
}

/// How much of the full turn there is, in degrees.
fn turn(parameters: &Parameters, texts: &Texts) -> Result<f32, SceneError> {
    Ok(parameters.number_or("phimax", 360.0, texts)?.clamp(0.0, 360.0))
}

/// The numbers of a name, `N` to each, as what they stand for; nothing where there are none.
fn each<const N: usize, T>(
    name: &str,
    make: impl Fn([f32; N]) -> T,
    parameters: &Parameters,
    texts: &Texts,
) -> Result<Vec<T>, SceneError> {
    let Some(numbers) = parameters.numbers(name, texts)? else { return Ok(Vec::new()) };
    let (parts, rest) = numbers.as_chunks::<N>();
    if !rest.is_empty() {
        let what = format!("{} numbers of \"{name}\" are not {N} for each vertex", numbers.len());
        return Err(texts.invalid(parameters.place_of(name), what));
    }
    Ok(parts.iter().map(|part| make(*part)).collect())
}

/// The vertices of a mesh: positions, and normals and texture coordinates where there are some.
fn vertices(parameters: &Parameters, texts: &Texts) -> Result<Mesh, SceneError> {
    let positions = each("P", Vec3::from_array, parameters, texts)?;
    let normals = each("N", Vec3::from_array, parameters, texts)?;
    let uvs = each("uv", Vec2::from_array, parameters, texts)?;
    // Older scenes call them so.
    let older = each("st", Vec2::from_array, parameters, texts)?;
    let uvs = if uvs.is_empty() { older } else { uvs };
    // Tangents, and numbers for the faces of Ptex: nothing here needs them.
    parameters.ignore(&["S", "faceIndices"]);
    let count = positions.len();
    for (name, length) in [("N", normals.len()), ("uv", uvs.len())] {
        if length != 0 && length != count {
            let what =
                format!("{length} of \"{name}\" for {count} of \"P\": give one each, or none");
            return Err(texts.invalid(parameters.place_of(name), what));
        }
    }
    Ok(Mesh { positions, normals, uvs, ..Mesh::default() })
}

/// The numbers of vertices, `N` to a part.
fn corners<const N: usize>(
    parameters: &Parameters,
    count: usize,
    texts: &Texts,
) -> Result<Vec<[u32; N]>, SceneError> {
    let Some(indices) = parameters.wholes("indices", texts)? else {
        if count == N {
            return Ok(vec![std::array::from_fn(|i| i as u32)]);
        }
        let what = format!("there are no \"indices\", and {count} vertices are not {N}");
        return Err(texts.invalid(parameters.place, what));
    };
    if let Some(wrong) = indices.iter().find(|&&i| i < 0 || i as usize >= count) {
        let what =
            format!("\"indices\" has {wrong}, but there are only {count} vertices, from 0 on");
        return Err(texts.invalid(parameters.place_of("indices"), what));
    }
    let (parts, rest) = indices.as_chunks::<N>();
    if !rest.is_empty() {
        let what = format!("{} \"indices\" are not {N} for each part", indices.len());
        return Err(texts.invalid(parameters.place_of("indices"), what));
    }
    Ok(parts.iter().map(|part| part.map(|i| i as u32)).collect())
}

fn triangles(parameters: &Parameters, texts: &Texts) -> Result<Form, SceneError> {
    let mut mesh = vertices(parameters, texts)?;
    mesh.triangles = corners::<3>(parameters, mesh.positions.len(), texts)?;
    Ok(Form::Mesh(mesh))
}

/// Bilinear patches as two triangles each. Their corners stand in rows: (0, 0), (1, 0), (0, 1), (1, 1).
fn patches(parameters: &Parameters, texts: &Texts) -> Result<Form, SceneError> {
    let shared = vertices(parameters, texts)?;
    let patches = corners::<4>(parameters, shared.positions.len(), texts)?;
    let mut mesh = Mesh::default();
    for patch in patches {
        let first = mesh.positions.len() as u32;
        let corner = [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE];
        for (i, uv) in patch.map(|i| i as usize).into_iter().zip(corner) {
            mesh.positions.push(shared.positions[i]);
            mesh.uvs.push(shared.uvs.get(i).copied().unwrap_or(uv));
            mesh.normals.extend(shared.normals.get(i));
        }
        mesh.triangles.extend([[first, first + 1, first + 3], [first, first + 3, first + 2]]);
    }
    Ok(Form::Mesh(mesh))
}

/// A mesh whose triangles have their fronts where pbrt has them, and whether that is how they were.
pub(super) fn oriented(mut mesh: Mesh, reversed: bool) -> (Mesh, bool) {
    let mut as_it_is = !reversed;
    if !mesh.normals.is_empty() {
        for [a, b, c] in &mut mesh.triangles {
            let [p, q, r] = [*a, *b, *c].map(|i| mesh.positions[i as usize].as_dvec3());
            let front = (q - p).cross(r - p);
            let normal = [*a, *b, *c].map(|i| mesh.normals[i as usize].as_dvec3());
            if front.dot(normal[0] + normal[1] + normal[2]) < 0.0 {
                std::mem::swap(b, c);
                as_it_is = false;
            }
        }
    }
    if reversed {
        mesh.triangles.iter_mut().for_each(|[_, b, c]| std::mem::swap(b, c));
        mesh.normals.iter_mut().for_each(|normal| *normal = -*normal);
    }
    (mesh, as_it_is)
}
