//! Nodes: the hierarchy that places meshes, cameras and lights.
//!
//! Every node has at most one parent, and no node is below itself; both are
//! checked when the document is read, and parents then come before their
//! children in one list. Nothing walks the hierarchy by recursion, so it may be
//! as deep as it likes.
//!
//! Sources: Khronos Group, *glTF 2.0 Specification*, 2021, sections 3.5, 3.7.3
//! and 3.10; `KHR_lights_punctual`; `EXT_mesh_gpu_instancing`;
//! `KHR_node_visibility`.

use super::accessor::{Accessors, Whole};
use super::entry::{Entry, Result};
use super::mesh::{self, Mesh};
use crate::scene::affine::Affine;
use rutilant::light::MIN_CONE;
use rutilant::scene::MOST_LIGHT;
use rutilant_geom::{DVec3, Vec3};
use std::collections::HashMap;
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use std::sync::Arc;

/// Where something stands, in parts that can be animated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parts {
    /// Moves last.
    pub translation: Vec3,
    /// Turns by a quaternion (x, y, z, w) of any length but zero.
    pub rotation: [f32; 4],
    /// Scales first; may mirror.
    pub scale: Vec3,
}

impl Parts {
    /// Leaves everything where it is.
    pub const IDENTITY: Self =
        Self { translation: Vec3::ZERO, rotation: [0.0, 0.0, 0.0, 1.0], scale: Vec3::ONE };

    /// As one map.
    pub fn to_affine(&self) -> Affine {
        Affine::from_parts(self.translation, self.rotation, self.scale)
    }
}

/// Where a node stands in the space of its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Placement {
    /// In parts.
    Parts(Parts),
    /// As a matrix, which is never animated.
    Matrix(Affine),
}

impl Placement {
    /// As one map.
    pub fn to_affine(&self) -> Affine {
        match self {
            Self::Parts(parts) => parts.to_affine(),
            Self::Matrix(affine) => *affine,
        }
    }
}

/// A place in the hierarchy.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// What the author calls it; may be empty.
    pub name: String,
    /// The node above; `None` for a root.
    pub parent: Option<usize>,
    /// Where it stands in the space of the node above.
    pub placement: Placement,
    /// Its mesh in [`Document::meshes`](super::Document::meshes).
    pub mesh: Option<usize>,
    /// What bends the mesh, in [`Document::skins`](super::Document::skins).
    pub skin: Option<usize>,
    /// How much each morph target of the mesh counts here; `None` for the mesh's own weights.
    pub weights: Option<Vec<f32>>,
    /// Its camera in [`Document::cameras`](super::Document::cameras); it looks along -z.
    pub camera: Option<usize>,
    /// Its light in [`Document::lights`](super::Document::lights); it shines along -z.
    pub light: Option<usize>,
    /// Where copies of the mesh stand, in the node's space; `None` for one at its origin.
    pub instances: Option<Arc<Vec<Affine>>>,
    /// Whether it is seen; what is below an unseen node is not seen either.
    pub visible: bool,
}

/// The hierarchy.
pub(super) struct Nodes {
    pub(super) nodes: Vec<Node>,
    /// Every node once, parents first.
    pub(super) order: Vec<usize>,
}

/// How much of other parts of a document there is.
pub(super) struct Counts<'m> {
    pub(super) meshes: &'m [Mesh],
    pub(super) skins: usize,
    pub(super) cameras: usize,
    pub(super) lights: usize,
}

/// The nodes of a document.
pub(super) fn nodes(
    root: &Entry<'_, '_>,
    accessors: &mut Accessors<'_>,
    counts: &Counts<'_>,
) -> Result<Nodes> {
    let count = root.count("nodes")?;
    let mut instances = HashMap::new();
    let mut nodes = root.each("nodes", |entry| node(entry, accessors, counts, &mut instances))?;

    // Who is above whom.
    let mut children: Vec<Vec<usize>> = Vec::with_capacity(count);
    if let Some(list) = root.get("nodes")? {
        for (i, entry) in list.items()?.enumerate() {
            let below = entry.each("children", |child| {
                let node = child.index("node", count)?;
                match nodes[node].parent.replace(i) {
                    None => Ok(node),
                    Some(other) => Err(child.wrong(format_args!(
                        "names node {node}, which nodes[{other}] has as a child already"
                    ))),
                }
            })?;
            children.push(below);
        }
    }

    // Parents first. What no root leads to goes round in a circle.
    let mut order: Vec<usize> = (0..count).filter(|&i| nodes[i].parent.is_none()).collect();
    let mut at = 0;
    while let Some(&node) = order.get(at) {
        order.append(&mut children[node]);
        at += 1;
    }
    if order.len() < count {
        let mut reached = vec![false; count];
        order.iter().for_each(|&node| reached[node] = true);
        let lost = reached.iter().position(|reached| !reached).unwrap_or(0);
        // From there up, as many steps as there are nodes, is on the circle for certain; once
        // around, and the first of the circle is found.
        let up = |node: usize| nodes[node].parent.unwrap_or(node);
        let on_circle = (0..count).fold(lost, |node, _| up(node));
        let around = std::iter::successors(Some(up(on_circle)), |&node| Some(up(node)));
        let first = around.take_while(|&node| node != on_circle).fold(on_circle, usize::min);
        let what = format!("nodes[{first}] is below itself");
        return Err(crate::error::SceneErrorKind::Invalid(what));
    }
    Ok(Nodes { nodes, order })
}

/// Instances by the accessors of their translations, rotations and scales.
type Instances = HashMap<[Option<usize>; 3], Arc<Vec<Affine>>>;

fn node(
    entry: &Entry<'_, '_>,
    accessors: &mut Accessors<'_>,
    counts: &Counts<'_>,
    known: &mut Instances,
) -> Result<Node> {
    let mesh = entry.index_of("mesh", "mesh", counts.meshes.len())?;
    let skin = entry.index_of("skin", "skin", counts.skins)?;
    let targets = mesh.map_or(0, |mesh| counts.meshes[mesh].weights.len());
    let light = match entry.extension("KHR_lights_punctual")? {
        Some(extension) => Some(extension.need("light")?.index("light", counts.lights)?),
        None => None,
    };
    let visible = match entry.extension("KHR_node_visibility")? {
        Some(extension) => extension.flag("visible", true)?,
        None => true,
    };
    let instances = match entry.extension("EXT_mesh_gpu_instancing")? {
        Some(extension) if mesh.is_some() => Some(self::instances(&extension, accessors, known)?),
        Some(_) | None => None,
    };
    Ok(Node {
        name: entry.name()?,
        parent: None,
        placement: placement(entry)?,
        mesh,
        skin: skin.filter(|_| mesh.is_some()),
        weights: mesh::weights(entry, targets)?,
        camera: entry.index_of("camera", "camera", counts.cameras)?,
        light,
        instances,
        visible,
    })
}

fn placement(entry: &Entry<'_, '_>) -> Result<Placement> {
    let parts = ["translation", "rotation", "scale"];
    if let Some(matrix) = entry.get("matrix")? {
        let numbers = matrix.numbers::<16>()?;
        let Some(affine) = Affine::from_columns(&numbers) else {
            let row = [numbers[3], numbers[7], numbers[11], numbers[15]];
            let what = format!("has a last row {row:?}, but must have [0, 0, 0, 1]");
            return Err(matrix.wrong(what));
        };
        for key in parts {
            if entry.get(key)?.is_some() {
                return Err(entry.wrong(format_args!("has both a \"matrix\" and a \"{key}\"")));
            }
        }
        return Ok(Placement::Matrix(affine));
    }
    let [translation, rotation, scale] = parts;
    let turn = entry.numbers_or(rotation, Parts::IDENTITY.rotation)?;
    if turn == [0.0; 4] {
        return Err(entry.wrong("has a rotation of length 0, but must have one of length 1"));
    }
    Ok(Placement::Parts(Parts {
        translation: entry.numbers_or(translation, [0.0; 3])?.into(),
        rotation: turn,
        scale: entry.numbers_or(scale, [1.0; 3])?.into(),
    }))
}

fn instances(
    extension: &Entry<'_, '_>,
    accessors: &mut Accessors<'_>,
    known: &mut Instances,
) -> Result<Arc<Vec<Affine>>> {
    let attributes = extension.need("attributes")?;
    let [translation, rotation, scale] =
        [attributes.get("TRANSLATION")?, attributes.get("ROTATION")?, attributes.get("SCALE")?];
    let mut key = [None; 3];
    let mut count = None;
    for (slot, at) in key.iter_mut().zip([&translation, &rotation, &scale]) {
        let Some(at) = at else { continue };
        *slot = Some(accessors.index(at)?);
        let length = accessors.count(at)?;
        if count.is_some_and(|count| count != length) {
            return Err(at.wrong(format_args!("has {length} elements, others have another number")));
        }
        count = Some(length);
    }
    if let Some(known) = known.get(&key) {
        return Ok(known.clone());
    }
    let Some(count) = count else {
        return Err(attributes.wrong("has none of TRANSLATION, ROTATION and SCALE"));
    };
    accessors.store.budget.take(count, size_of::<Affine>(), &attributes)?;
    let translation = translation.map(|at| accessors.vec3(&at)).transpose()?;
    let rotation = rotation.map(|at| accessors.vec4(&at, Whole::Parts)).transpose()?;
    let scale = scale.map(|at| accessors.vec3(&at)).transpose()?;
    let mut places = Vec::with_capacity(count);
    for i in 0..count {
        let identity = Parts::IDENTITY;
        let parts = Parts {
            translation: translation.as_ref().map_or(identity.translation, |all| all[i]),
            rotation: rotation.as_ref().map_or(identity.rotation, |all| all[i]),
            scale: scale.as_ref().map_or(identity.scale, |all| all[i]),
        };
        let affine = parts.to_affine();
        if parts.rotation == [0.0; 4] || affine.to_transform().is_none() {
            let what = format!("has an instance {i} that stands nowhere: {parts:?}");
            return Err(attributes.wrong(what));
        }
        places.push(affine);
    }
    let places = Arc::new(places);
    known.insert(key, places.clone());
    Ok(places)
}

/// What bends a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Skin {
    /// What the author calls it; may be empty.
    pub name: String,
    /// The nodes that it follows.
    pub joints: Vec<usize>,
    /// For each joint, the map from the mesh at rest to the joint's space.
    pub joint_from_mesh: Vec<Affine>,
}

/// The skins of a document with so many nodes.
pub(super) fn skins(
    root: &Entry<'_, '_>,
    accessors: &mut Accessors<'_>,
    nodes: usize,
) -> Result<Vec<Skin>> {
    root.each("skins", |entry| {
        let joints = entry.need("joints")?;
        let joints = joints.items()?.map(|joint| joint.index("node", nodes));
        let joints = joints.collect::<Result<Vec<_>>>()?;
        let joint_from_mesh = match entry.get("inverseBindMatrices")? {
            None => vec![Affine::IDENTITY; joints.len()],
            Some(at) => {
                if !accessors.is(&at, "MAT4")? {
                    return Err(at.wrong("names an accessor that does not hold MAT4"));
                }
                if accessors.count(&at)? < joints.len() {
                    let (count, joints) = (accessors.count(&at)?, joints.len());
                    return Err(at.wrong(format_args!("has {count} matrices for {joints} joints")));
                }
                let numbers = accessors.scalars(&at)?;
                let matrices = numbers.as_chunks::<16>().0.iter().take(joints.len());
                let affine = |(i, matrix): (usize, &[f32; 16])| {
                    let affine = Affine::from_columns(matrix);
                    affine.filter(|affine| affine.to_transform().is_some()).ok_or_else(|| {
                        at.wrong(format_args!("has a matrix {i} that is no affine map"))
                    })
                };
                matrices.enumerate().map(affine).collect::<Result<_>>()?
            }
        };
        Ok(Skin { name: entry.name()?, joints, joint_from_mesh })
    })
}

/// How a camera sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// From a point.
    Perspective {
        /// Vertical field of view in radians, more than 0 and less than π.
        vertical: f32,
        /// Width by height of what the author saw; `None` for that of the picture.
        aspect: Option<f32>,
        /// Distance at which seeing begins, more than 0.
        near: f32,
        /// Distance at which it ends; infinite where it does not.
        far: f32,
    },
    /// In parallel.
    Orthographic {
        /// Half the width and half the height of what is seen; neither is 0, and either may be
        /// negative, which mirrors.
        half: [f32; 2],
        /// Distance at which seeing begins, at least 0.
        near: f32,
        /// Distance at which it ends.
        far: f32,
    },
}

/// A camera. It stands at its node's origin, looks along -z, and +y is up.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// What the author calls it; may be empty.
    pub name: String,
    /// How it sees.
    pub projection: Projection,
}

/// The cameras of a document.
pub(super) fn cameras(root: &Entry<'_, '_>) -> Result<Vec<Camera>> {
    root.each("cameras", |entry| {
        let kind = entry.need("type")?;
        let projection = match kind.text()? {
            "perspective" => {
                let entry = entry.need("perspective")?;
                let yfov = entry.need("yfov")?;
                let vertical = yfov.number()?;
                if !(vertical > 0.0 && vertical < PI) {
                    return Err(yfov.wrong(format_args!(
                        "is {vertical}, but must lie between 0 and π: it is an angle in radians"
                    )));
                }
                let aspect = entry.get("aspectRatio")?.map(|aspect| above(&aspect, 0.0));
                let near = above(&entry.need("znear")?, 0.0)?;
                let far = entry.get("zfar")?.map(|far| above(&far, near)).transpose()?;
                let far = far.unwrap_or(f32::INFINITY);
                Projection::Perspective { vertical, aspect: aspect.transpose()?, near, far }
            }
            "orthographic" => {
                let entry = entry.need("orthographic")?;
                let half = |key| {
                    let half = entry.need(key)?;
                    match half.number()? {
                        0.0 => Err(half.wrong("is 0, but must not be")),
                        number => Ok(number),
                    }
                };
                let half = [half("xmag")?, half("ymag")?];
                let near = entry.need("znear")?;
                let near = match near.number()? {
                    number if number >= 0.0 => number,
                    number => {
                        return Err(near.wrong(format_args!("is {number}, but must be at least 0")));
                    }
                };
                Projection::Orthographic { half, near, far: above(&entry.need("zfar")?, near)? }
            }
            other => {
                let other = crate::shown::shown(other);
                return Err(kind.wrong(format_args!(
                    "is \"{other}\", but must be perspective or orthographic"
                )));
            }
        };
        Ok(Camera { name: entry.name()?, projection })
    })
}

fn above(entry: &Entry<'_, '_>, least: f32) -> Result<f32> {
    match entry.number()? {
        number if number > least => Ok(number),
        number => Err(entry.wrong(format_args!("is {number}, but must be more than {least}"))),
    }
}

/// What kind of light it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// From infinitely far, along -z.
    Directional,
    /// From a point to all sides.
    Point,
    /// From a point, in a cone around -z.
    Spot {
        /// Radians from the axis to where it begins to fall off; less than `outer`.
        inner: f32,
        /// Radians from the axis to where it ends, at most π/2.
        outer: f32,
    },
}

/// A light of `KHR_lights_punctual`. The scale of its node does not matter.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// What the author calls it; may be empty.
    pub name: String,
    /// Where its light goes.
    pub kind: LightKind,
    /// Scene-linear colour, each at least 0.
    pub color: [f32; 3],
    /// In lux for directional lights, in candela for the others; at least 0.
    pub intensity: f32,
    /// Where the author's renderer may stop looking for its light; infinite if it may not. Light
    /// itself does not stop.
    pub range: f32,
}

/// The lights of a document.
pub(super) fn lights(root: &Entry<'_, '_>) -> Result<Vec<Light>> {
    let Some(extension) = root.extension("KHR_lights_punctual")? else { return Ok(Vec::new()) };
    extension.each("lights", |entry| {
        let kind = entry.need("type")?;
        let kind = match kind.text()? {
            "directional" => LightKind::Directional,
            "point" => LightKind::Point,
            "spot" => match entry.get("spot")? {
                None => LightKind::Spot { inner: 0.0, outer: FRAC_PI_4 },
                Some(spot) => {
                    let outer = spot.factor("outerConeAngle", FRAC_PI_4, [MIN_CONE, FRAC_PI_2])?;
                    // As large as the outer one it may not be by the letter, but is where Blender's
                    // exporter writes a hard edge.
                    let inner = spot.factor("innerConeAngle", 0.0, [0.0, outer])?;
                    LightKind::Spot { inner, outer }
                }
            },
            other => {
                let other = crate::shown::shown(other);
                return Err(kind.wrong(format_args!(
                    "is \"{other}\", but must be directional, point or spot"
                )));
            }
        };
        let range = entry.get("range")?.map(|range| above(&range, 0.0)).transpose()?;
        Ok(Light {
            name: entry.name()?,
            kind,
            color: entry.factors("color", [1.0; 3], [0.0, MOST_LIGHT])?,
            intensity: entry.factor("intensity", 1.0, [0.0, MOST_LIGHT])?,
            range: range.unwrap_or(f32::INFINITY),
        })
    })
}

/// A direction of length 1, or nothing where there is none.
pub(super) fn direction(v: DVec3) -> DVec3 {
    let length = v.length();
    if length > 0.0 && length.is_finite() { v / length } else { DVec3::ZERO }
}
