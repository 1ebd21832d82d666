//! Meshes: what their primitives hold, as triangles.
//!
//! Lists, strips and fans become triangles with indices. Points and lines are
//! left out with a note; a document that has nothing else is refused. Numbers
//! of vertices that are not finite stay as they are, as in all mesh files: such
//! triangles are left out when a scene is prepared.
//!
//! Source: Khronos Group, *glTF 2.0 Specification*, 2021, section 3.7.

use super::accessor::{Accessors, Mode, Whole};
use super::draco;
use super::entry::{Entry, Result};
use super::texture::numbered;
use crate::error::SceneErrorKind;
use crate::limits::Limits;
use rutilant_geom::{Vec2, Vec3};
use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::Arc;

/// What is added to vertices, times a weight.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MorphTarget {
    /// Added to positions; `None` for nothing.
    pub positions: Option<Arc<Vec<Vec3>>>,
    /// Added to normals; `None` for nothing.
    pub normals: Option<Arc<Vec<Vec3>>>,
    /// Added to the directions of tangents; `None` for nothing.
    pub tangents: Option<Arc<Vec<Vec3>>>,
}

/// Four joints for each vertex.
#[derive(Clone, Debug, PartialEq)]
pub struct Skinning {
    /// Their numbers in [`Skin::joints`](super::Skin::joints).
    pub joints: Arc<Vec<[u16; 4]>>,
    /// How much each of them counts. Only what is more than 0 does.
    pub weights: Arc<Vec<[f32; 4]>>,
}

/// Triangles of one material.
///
/// All arrays with values for vertices are as long as `positions`. They are
/// shared with other primitives that name the same accessors:
/// [`Arc::unwrap_or_clone`] takes them without a copy where they are not.
#[derive(Clone, Debug, PartialEq)]
pub struct Primitive {
    /// In the mesh's own space. May be infinite or no numbers.
    pub positions: Arc<Vec<Vec3>>,
    /// For smooth shading, of any length; `None` for flat triangles.
    pub normals: Option<Arc<Vec<Vec3>>>,
    /// Direction in which u grows (x, y, z), and 1 or -1 (w): the bitangent is
    /// `cross(normal, tangent) * w`.
    pub tangents: Option<Arc<Vec<[f32; 4]>>>,
    /// Texture coordinates by the number of their set, v downwards from the top of the image.
    pub uvs: BTreeMap<u32, Arc<Vec<Vec2>>>,
    /// Scene-linear factors to the base colour and alpha, by the number of their set; only set 0
    /// has a meaning.
    pub colors: BTreeMap<u32, Arc<Vec<[f32; 4]>>>,
    /// Which joints hold the vertices, in sets of four; empty where none do.
    pub skinning: Vec<Skinning>,
    /// One more than the largest joint that counts for anything.
    pub joints_end: usize,
    /// As many as the mesh has weights.
    pub targets: Vec<MorphTarget>,
    /// Three vertex numbers each, counter-clockwise seen from the front.
    pub triangles: Arc<Vec<[u32; 3]>>,
    /// Its material in [`Document::materials`](super::Document::materials); `None` for the
    /// default one.
    pub material: Option<usize>,
    /// Other materials (second) for variants of the document (first): `KHR_materials_variants`.
    pub variants: Vec<(usize, usize)>,
}

/// Primitives that move together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// What the author calls it; may be empty.
    pub name: String,
    /// Empty where all of them were points or lines.
    pub primitives: Vec<Primitive>,
    /// How much each morph target counts, if nothing else says so.
    pub weights: Vec<f32>,
}

/// How much of other parts of a document there is.
pub(super) struct Counts {
    pub(super) materials: usize,
    pub(super) variants: usize,
}

/// The meshes of a document.
pub(super) fn meshes(
    root: &Entry<'_, '_>,
    accessors: &mut Accessors<'_>,
    counts: &Counts,
    limits: &Limits,
) -> Result<Vec<Mesh>> {
    let (mut vertices, mut triangles, mut left_out) = (0_u64, 0_u64, None);
    let meshes = root.each("meshes", |entry| {
        let mut mesh = Mesh { name: entry.name()?, ..Mesh::default() };
        let primitives = entry.need("primitives")?;
        let mut targets = None;
        for primitive in primitives.items()? {
            let count = primitive.count("targets")?;
            if targets.is_some_and(|targets| targets != count) {
                let what = "has another number of \"targets\" than those before it";
                return Err(primitive.wrong(what));
            }
            targets = Some(count);
            match self::primitive(&primitive, accessors, counts)? {
                Some(read) => {
                    let added = (read.positions.len() as u64, read.triangles.len() as u64);
                    vertices += added.0;
                    triangles += added.1;
                    for (what, asked, allowed) in [
                        ("vertices", vertices, limits.vertices.min(u64::from(u32::MAX))),
                        ("triangles", triangles, limits.triangles),
                    ] {
                        if asked > allowed {
                            return Err(SceneErrorKind::Limit { what, asked, allowed });
                        }
                    }
                    mesh.primitives.push(read);
                }
                None => left_out = left_out.take().or(Some(primitive.place.to_string())),
            }
        }
        let targets = targets.unwrap_or(0);
        mesh.weights = weights(entry, targets)?.unwrap_or_else(|| vec![0.0; targets]);
        Ok(mesh)
    })?;
    match left_out {
        Some(first) if meshes.iter().all(|mesh| mesh.primitives.is_empty()) => {
            let what = format!("there are only points and lines in it (first {first})");
            Err(SceneErrorKind::Unsupported(what))
        }
        Some(_) | None => Ok(meshes),
    }
}

/// Weights of so many morph targets, where `entry` has any.
pub(super) fn weights(entry: &Entry<'_, '_>, targets: usize) -> Result<Option<Vec<f32>>> {
    let Some(list) = entry.get("weights")? else { return Ok(None) };
    let weights = list.items()?.map(|item| item.number()).collect::<Result<Vec<_>>>()?;
    // Some exporters write weights for targets that were optimised away.
    match weights.len() == targets {
        true => Ok(Some(weights)),
        false if targets == 0 => Ok(None),
        false => {
            let what = format!("has {} numbers for {targets} morph targets", weights.len());
            Err(list.wrong(what))
        }
    }
}

/// A primitive; `None` for points, lines and what has no positions, which is noted.
fn primitive(
    entry: &Entry<'_, '_>,
    accessors: &mut Accessors<'_>,
    counts: &Counts,
) -> Result<Option<Primitive>> {
    let mode = match entry.get("mode")?.map(|mode| mode.whole(6)).transpose()? {
        Some(0..=3) => {
            entry.notes.add("points and lines, left out", || entry.place.to_string());
            return Ok(None);
        }
        None | Some(4) => Mode::List,
        Some(5) => Mode::Strip,
        Some(_) => Mode::Fan,
    };
    let attributes = entry.need("attributes")?;
    let Some(position) = attributes.get("POSITION")? else {
        entry.notes.add("primitives without POSITION, left out", || entry.place.to_string());
        return Ok(None);
    };
    if let Some(compressed) = entry.extension(draco::NAME)? {
        draco::unpack(entry, &compressed, accessors)?;
    }
    let positions = accessors.vec3(&position)?;
    let count = positions.len();
    let check = |at: &Entry<'_, '_>, length: usize| match length == count {
        true => Ok(()),
        false => Err(at.wrong(format_args!("has {length} elements, but POSITION has {count}"))),
    };

    // What vertices have beside a position.
    let mut read = Primitive {
        positions,
        normals: None,
        tangents: None,
        uvs: BTreeMap::new(),
        colors: BTreeMap::new(),
        skinning: Vec::new(),
        joints_end: 0,
        targets: Vec::new(),
        triangles: Arc::default(),
        material: entry.index_of("material", "material", counts.materials)?,
        variants: variants(entry, counts)?,
    };
    let by_name = attributes.by_key()?;
    // In the order of the document, so that of several mistakes always the same is told.
    for (name, _) in attributes.object()? {
        let Some(&at) = by_name.get(&**name) else { continue };
        if name == "NORMAL" {
            check(&at, accessors.count(&at)?)?;
            read.normals = Some(accessors.vec3(&at)?);
        } else if name == "TANGENT" {
            check(&at, accessors.count(&at)?)?;
            // With three numbers, as some exporters write them, the fourth is 1.
            read.tangents = Some(accessors.vec4(&at, Whole::AsTold)?);
        } else if let Some(set) = numbered(name, "TEXCOORD_") {
            check(&at, accessors.count(&at)?)?;
            read.uvs.insert(set, accessors.vec2(&at)?);
        } else if let Some(set) = numbered(name, "COLOR_") {
            check(&at, accessors.count(&at)?)?;
            read.colors.insert(set, accessors.vec4(&at, Whole::Parts)?);
        }
    }
    skinning(&attributes, &by_name, accessors, &mut read, &check)?;

    // What morph targets add to them.
    if let Some(targets) = entry.get("targets")? {
        for target in targets.items()? {
            let mut array = |key| match target.get(key)? {
                None => Ok(None),
                Some(at) => {
                    check(&at, accessors.count(&at)?)?;
                    accessors.vec3(&at).map(Some)
                }
            };
            read.targets.push(MorphTarget {
                positions: array("POSITION")?,
                normals: array("NORMAL")?,
                tangents: array("TANGENT")?,
            });
        }
    }

    // How they make triangles.
    let corners;
    read.triangles = match entry.get("indices")? {
        Some(at) => {
            corners = accessors.count(&at)?;
            let (triangles, largest) = accessors.triangles(&at, mode)?;
            if corners > 0 && largest as usize >= count {
                return Err(at.wrong(format_args!(
                    "names an accessor with vertex {largest}, but there are only {count} \
                     (numbered from 0)"
                )));
            }
            triangles
        }
        None => {
            corners = count;
            accessors.unindexed(count, mode, &position)?
        }
    };
    if mode == Mode::List && !corners.is_multiple_of(3) {
        entry
            .notes
            .add("triangles without all three corners, left out", || entry.place.to_string());
    }
    Ok(Some(read))
}

/// Joints and weights, set by set.
fn skinning(
    attributes: &Entry<'_, '_>,
    by_name: &HashMap<&str, Entry<'_, '_>>,
    accessors: &mut Accessors<'_>,
    read: &mut Primitive,
    check: &impl Fn(&Entry<'_, '_>, usize) -> Result<()>,
) -> Result<()> {
    for set in 0.. {
        let names = [format!("JOINTS_{set}"), format!("WEIGHTS_{set}")];
        let [joints, weights] = names.each_ref().map(|name| by_name.get(&**name).copied());
        let (joints, weights) = match (joints, weights) {
            (Some(joints), Some(weights)) => (joints, weights),
            (None, None) => break,
            (Some(_), None) | (None, Some(_)) => {
                let [joints, weights] = names;
                let what = format!("has only one of {joints} and {weights}");
                return Err(attributes.wrong(what));
            }
        };
        check(&joints, accessors.count(&joints)?)?;
        check(&weights, accessors.count(&weights)?)?;
        let (joints, weights) =
            (accessors.joints(&joints)?, accessors.vec4(&weights, Whole::Parts)?);
        read.skinning.push(Skinning { joints, weights });
    }
    let pairs = read
        .skinning
        .iter()
        .flat_map(|set| set.joints.as_flattened().iter().zip(set.weights.as_flattened()));
    let ends = pairs.filter(|(_, weight)| **weight > 0.0).map(|(joint, _)| usize::from(*joint) + 1);
    read.joints_end = ends.max().unwrap_or(0);
    Ok(())
}

/// Which materials variants give a primitive.
fn variants(entry: &Entry<'_, '_>, counts: &Counts) -> Result<Vec<(usize, usize)>> {
    let (mut all, mut seen) = (Vec::new(), HashSet::new());
    let Some(extension) = entry.extension("KHR_materials_variants")? else { return Ok(all) };
    let mappings = extension.need("mappings")?;
    for mapping in mappings.items()? {
        let material = mapping.need("material")?.index("material", counts.materials)?;
        let variants = mapping.need("variants")?;
        for variant in variants.items()? {
            let number = variant.index("variant", counts.variants)?;
            if !seen.insert(number) {
                return Err(variant.wrong(format_args!("names variant {number} once more")));
            }
            all.push((number, material));
        }
    }
    Ok(all)
}
