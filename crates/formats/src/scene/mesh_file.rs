//! Mesh files of any format, alone or named by a scene.

use super::files::Fence;
use super::gltf::scene::Model;
use super::obj::{self, ObjScene};
use super::pictures::Pictures;
use super::ply;
use super::stl;
use crate::error::{SceneError, SceneErrorKind};
use crate::file;
use crate::limits::Limits;
use crate::shown::shown;
use rutilant::material::{Bumps, Material, MaterialKind};
use rutilant::scene::{MaterialId, Scene};
use rutilant::shape::Mesh;
use rutilant::texture::{Bitmap, ImageTexture, Texels, Texture};
use rutilant_geom::Vec3;
use std::collections::HashMap;
use std::path::Path;

/// Meshes with the names of their materials, the materials, and what a person should know.
type MeshReader = fn(&Path, &Limits, &Fence) -> Result<ObjScene, SceneError>;
/// The same for the content of a file, without those that it names in turn.
type BytesReader = fn(&[u8], &Path, &Limits) -> Result<ObjScene, SceneError>;

/// Every kind of mesh file, by its extension.
const MESHES: &[(&str, MeshReader, BytesReader)] = &[
    ("obj", obj::read_within, obj::read_bytes),
    ("ply", read_ply, read_ply_bytes),
    ("stl", read_stl, read_stl_bytes),
];

/// Whole scenes, of which a shape takes the things.
const DOCUMENTS: [&str; 2] = ["gltf", "glb"];

/// Whether a file holds a whole scene: it is for [`model`](super::gltf::scene::model) to read.
pub(super) fn is_document(path: &Path) -> bool {
    DOCUMENTS.contains(&&*file::extension(path))
}

/// What reads the mesh file at `path`; or what is wrong with its name.
fn reader(path: &Path) -> Result<(MeshReader, BytesReader), SceneErrorKind> {
    let extension = file::extension(path);
    let reader = MESHES.iter().find(|(name, _, _)| *name == extension);
    reader.map(|&(_, file, bytes)| (file, bytes)).ok_or_else(|| {
        let known = MESHES.iter().map(|(name, _, _)| *name).chain(DOCUMENTS);
        let what = file::unknown_format("mesh", path, known);
        SceneErrorKind::Unsupported(what)
    })
}

/// Reads a mesh file of any kind. What it names in turn must lie inside the `fence`. An unknown
/// kind is the mistake of whoever named it: `misnamed` knows where that stands.
pub(super) fn read(
    path: &Path,
    limits: &Limits,
    fence: &Fence,
    misnamed: impl FnOnce(SceneErrorKind) -> SceneError,
) -> Result<ObjScene, SceneError> {
    reader(path).map_err(misnamed)?.0(path, limits, fence)
}

/// As [`read`], for the content of a file that carries all it needs; `path` is its name.
pub(super) fn read_bytes(
    bytes: &[u8],
    path: &Path,
    limits: &Limits,
    misnamed: impl FnOnce(SceneErrorKind) -> SceneError,
) -> Result<ObjScene, SceneError> {
    reader(path).map_err(misnamed)?.1(bytes, path, limits)
}

/// A PLY file is an OBJ file with one mesh and no materials.
fn read_ply(path: &Path, limits: &Limits, _: &Fence) -> Result<ObjScene, SceneError> {
    Ok(alone(ply::read(path, limits)?))
}

fn read_ply_bytes(bytes: &[u8], path: &Path, limits: &Limits) -> Result<ObjScene, SceneError> {
    Ok(alone(ply::read_bytes(bytes, path, limits)?))
}

/// So is an STL file.
fn read_stl(path: &Path, limits: &Limits, _: &Fence) -> Result<ObjScene, SceneError> {
    Ok(alone(stl::read(path, limits)?))
}

fn read_stl_bytes(bytes: &[u8], path: &Path, limits: &Limits) -> Result<ObjScene, SceneError> {
    Ok(alone(stl::read_bytes(bytes, path, limits)?))
}

fn alone((mesh, notes): (Mesh, Vec<String>)) -> ObjScene {
    ObjScene { meshes: vec![(mesh, None)], notes, ..ObjScene::default() }
}

/// Takes a file's materials, with their textures, into a scene, and gives them by name. The pictures
/// of these are asked for.
pub(super) fn adopt(
    file: &mut ObjScene,
    scene: &mut Scene,
    pictures: &mut Pictures,
) -> HashMap<String, MaterialId> {
    let bitmaps = pictures.adopt(std::mem::take(&mut file.pictures));
    let first_texture = scene.textures.len() as u32;
    for texture in std::mem::take(&mut file.textures) {
        let bitmap = bitmaps[texture.bitmap.0 as usize];
        scene.add_texture(ImageTexture { bitmap, ..texture });
    }
    // The file counts its materials from 0; in the scene they follow those already there.
    let first = scene.materials.len() as u32;
    let mut ids = HashMap::new();
    for mut material in std::mem::take(&mut file.materials) {
        let name = material.name.clone();
        material.each_texture_mut(|id| id.0 += first_texture);
        let id = scene.add_material(renumbered(material, first));
        ids.entry(name).or_insert(id);
    }
    ids
}

/// What MTL files call heights is taken for normals where the picture looks like one of them, as
/// exporters of modelling programs write it. `which` are materials of the scene; those that were
/// changed are given back, with a note for each.
pub(super) fn tell_normals_from_heights(
    scene: &mut Scene,
    which: impl IntoIterator<Item = usize>,
) -> Vec<(usize, String)> {
    let Scene { materials, textures, bitmaps, .. } = scene;
    let change = |i: usize| {
        let material = &mut materials[i];
        let map = material.normal_map.as_mut().filter(|map| map.shows == Bumps::Heights)?;
        let Texture::Image(image) = &textures[map.texture.0 as usize] else { return None };
        if !looks_like_normals(&bitmaps[image.bitmap.0 as usize]) {
            return None;
        }
        map.shows = Bumps::Normals;
        let name = shown(&material.name);
        Some((i, format!("material \"{name}\": its bump looks like normals, and is read as such")))
    };
    which.into_iter().filter_map(change).collect()
}

/// Whether colours are directions out of a surface, most of them nearly straight: red and green are
/// about a half in the mean, and all vectors have length 1.
fn looks_like_normals(bitmap: &Bitmap) -> bool {
    /// So many texels tell.
    const SEEN: usize = 4096;
    /// Multiples of the golden ratio, of which only what is behind the point counts, are spread
    /// evenly over any whole, whatever its rows are long: here as a part of 2⁶⁴.
    const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;
    let channels = bitmap.channels();
    let count = bitmap.width() as usize * bitmap.height() as usize;
    let value = |i: usize| match bitmap.texels() {
        Texels::Eight(codes) => f32::from(codes[i]) / f32::from(u8::MAX),
        Texels::Sixteen(codes) => f32::from(codes[i]) / f32::from(u16::MAX),
        Texels::Float(values) => values[i],
    };
    if channels < 3 {
        return false;
    }
    let spread = |k: u64| ((u128::from(k.wrapping_mul(GOLDEN)) * count as u128) >> 64) as usize;
    let vectors: Vec<Vec3> = (0..SEEN as u64)
        .map(spread)
        .map(|i| i * channels)
        .map(|i| 2.0 * Vec3::new(value(i), value(i + 1), value(i + 2)) - Vec3::ONE)
        .collect();
    let mean = vectors.iter().sum::<Vec3>() / vectors.len() as f32;
    let is_unit = |v: &&Vec3| v.z > 0.0 && (0.8..1.2).contains(&v.length());
    let units = vectors.iter().filter(is_unit).count();
    mean.z > 0.5 && mean.truncate().length() < 0.2 && 10 * units > 9 * vectors.len()
}

/// Takes a document's materials and textures into a scene, and gives the material of each of its
/// numbers. The pictures are asked for.
pub(super) fn adopt_model(
    model: &mut Model,
    scene: &mut Scene,
    pictures: &mut Pictures,
) -> Vec<MaterialId> {
    let bitmaps = pictures.adopt(std::mem::take(&mut model.pictures));
    let first_texture = scene.textures.len() as u32;
    for texture in std::mem::take(&mut model.scene.textures) {
        scene.add_texture(match texture {
            Texture::Image(image) => {
                let bitmap = bitmaps[image.bitmap.0 as usize];
                Texture::Image(ImageTexture { bitmap, ..image })
            }
            other @ (Texture::Checker(_) | Texture::Bricks(_) | Texture::Noise(_)) => other,
        });
    }
    let first = scene.materials.len() as u32;
    let materials = std::mem::take(&mut model.scene.materials).into_iter();
    let added = materials.map(|mut material| {
        material.each_texture_mut(|id| id.0 += first_texture);
        scene.add_material(renumbered(material, first))
    });
    added.collect()
}

/// A material whose parts are counted from `first` on.
fn renumbered(mut material: Material, first: u32) -> Material {
    if let MaterialKind::Mix(mix) = &mut material.kind {
        for part in [&mut mix.first, &mut mix.second] {
            part.0 = part.0.saturating_add(first);
        }
    }
    material
}

/// How much of a file has no material although the file has some, for people. `None` where
/// everything has one, or where the file never speaks of materials.
pub(super) fn without_material(
    meshes: &[(Mesh, Option<String>)],
    ids: &HashMap<String, MaterialId>,
) -> Option<String> {
    let declared = |name: &Option<String>| name.as_ref().is_some_and(|n| ids.contains_key(n));
    let mut bare = meshes.iter().filter(|(_, name)| !declared(name)).peekable();
    bare.peek()?;
    if ids.is_empty() && meshes.iter().all(|(_, name)| name.is_none()) {
        return None;
    }
    let undeclared = bare.clone().find_map(|(_, name)| name.as_ref());
    let count: usize = bare.map(|(mesh, _)| mesh.triangles.len()).sum();
    let have = if count == 1 { "triangle has" } else { "triangles have" };
    Some(match undeclared {
        Some(name) => {
            let name = shown(name);
            format!("{count} {have} no material (\"{name}\" is named but not declared)")
        }
        None => format!("{count} {have} no material"),
    })
}
