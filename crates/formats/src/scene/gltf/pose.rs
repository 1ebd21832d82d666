//! Poses: where everything stands at a moment, and how meshes are bent there.
//!
//! A pose holds the place of every node in the world, by which meshes that have
//! joints are bent vertex by vertex. Bent meshes stand in the world: their own
//! node's place does not count, as the specification has it.
//!
//! Source: Khronos Group, *glTF 2.0 Specification*, 2021, sections 3.7.2.2
//! (morph targets) and 3.7.3 (skins).

use super::animation::Target;
use super::document::Document;
use super::mesh::{MorphTarget, Primitive};
use super::node::{Parts, Placement, direction};
use crate::error::{SceneError, SceneErrorKind};
use crate::scene::affine::{Affine, double, single};
use rutilant_geom::{DVec3, Transform, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

/// A time of an animation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// The number of the animation in [`Document::animations`].
    pub animation: usize,
    /// Its time. Before its beginning and after its end it stands still.
    pub seconds: f32,
}

/// Where everything stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    /// For each node.
    world_from_node: Vec<Affine>,
    /// Weights of morph targets, for those nodes whose weights are animated.
    weights: HashMap<usize, Vec<f32>>,
}

/// Something that a node places in the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Placed {
    /// The node.
    pub node: usize,
    /// Where the node stands. It may mirror, or flatten space: a scale of 0 is how animations
    /// hide things.
    pub world_from_node: Transform,
    /// Where its mesh stands, by [`Document::bent`]: where the node does, or in the world if a
    /// skin bends it.
    pub world_from_mesh: Transform,
    /// Its mesh in [`Document::meshes`].
    pub mesh: Option<usize>,
    /// What bends the mesh, in [`Document::skins`].
    pub skin: Option<usize>,
    /// Its camera in [`Document::cameras`].
    pub camera: Option<usize>,
    /// Its light in [`Document::lights`].
    pub light: Option<usize>,
    /// Where copies of the mesh stand, in the space of the node; `None` for the one mesh. Each
    /// `world_from_node * node_from_copy` is finite.
    pub copies: Option<Arc<Vec<Affine>>>,
}

/// The vertices of a primitive in a pose: those of the primitive itself where nothing bends it.
#[derive(Clone, Debug, PartialEq)]
pub struct Bent {
    /// In the space that [`Placed::world_from_mesh`] leads from.
    pub positions: Arc<Vec<Vec3>>,
    /// Of any length.
    pub normals: Option<Arc<Vec<Vec3>>>,
    /// As in [`Primitive::tangents`]; the direction of any length.
    pub tangents: Option<Arc<Vec<[f32; 4]>>>,
}

impl Document {
    /// Where everything stands at a moment, or, for `None`, where no animation has moved it.
    /// An animation that does not exist moves nothing.
    pub fn pose(&self, moment: Option<Moment>) -> Pose {
        // What the animation says of each node.
        let mut parts: HashMap<usize, Parts> = HashMap::new();
        let mut weights = HashMap::new();
        let animation = moment.and_then(|moment| self.animations.get(moment.animation));
        let seconds = moment.map_or(0.0, |moment| moment.seconds);
        for channel in animation.iter().flat_map(|animation| &animation.channels) {
            let value = channel.at(seconds);
            let moved = match self.nodes[channel.node].placement {
                Placement::Parts(own) => parts.entry(channel.node).or_insert(own),
                // No channel moves such a node: they are left out when a document is read.
                Placement::Matrix(_) => &mut Parts { ..Parts::IDENTITY },
            };
            match (channel.target, &value[..]) {
                (Target::Translation, &[x, y, z]) => moved.translation = Vec3::new(x, y, z),
                (Target::Scale, &[x, y, z]) => moved.scale = Vec3::new(x, y, z),
                // Splines may go through nothing: the node's own rotation stands in.
                (Target::Rotation, &[x, y, z, w]) if [x, y, z, w] != [0.0; 4] => {
                    moved.rotation = [x, y, z, w];
                }
                (Target::Weights, _) => drop(weights.insert(channel.node, value)),
                (Target::Translation | Target::Scale | Target::Rotation, _) => {}
            }
        }

        // Parents come first.
        let mut world_from_node = vec![Affine::IDENTITY; self.nodes.len()];
        for &i in &self.order {
            let node = &self.nodes[i];
            let own = match parts.get(&i) {
                Some(parts) => parts.to_affine(),
                None => node.placement.to_affine(),
            };
            world_from_node[i] = match node.parent {
                Some(parent) => world_from_node[parent] * own,
                None => own,
            };
        }
        Pose { world_from_node, weights }
    }

    /// Everything that a scene's nodes place in the world: parents before their children.
    /// `scene` is its number in [`Document::scenes`]; for `None`, the document's own choice, or
    /// its first scene, or all nodes where it has none.
    ///
    /// # Errors
    /// A place that single precision cannot hold.
    pub fn placed(&self, scene: Option<usize>, pose: &Pose) -> Result<Vec<Placed>, SceneError> {
        let scene = scene.or(self.scene).or((!self.scenes.is_empty()).then_some(0));
        let mut seen = vec![false; self.nodes.len()];
        match scene.and_then(|scene| self.scenes.get(scene)) {
            Some(scene) => scene.nodes.iter().for_each(|&root| seen[root] = true),
            None => self.order.iter().for_each(|&i| seen[i] = self.nodes[i].parent.is_none()),
        }
        let mut placed = Vec::new();
        for &i in &self.order {
            let node = &self.nodes[i];
            seen[i] |= node.parent.is_some_and(|parent| seen[parent]);
            seen[i] &= node.visible;
            if !seen[i] || (node.mesh, node.camera, node.light) == (None, None, None) {
                continue;
            }
            let world = pose.world_from_node[i];
            let too_large = |what: String| {
                let what = format!("nodes[{i}]{what} stands where single precision cannot hold it");
                SceneError::in_file(&self.file, SceneErrorKind::Invalid(what))
            };
            let world_from_node = world.to_transform().ok_or_else(|| too_large(String::new()))?;
            let copies = node.instances.clone().filter(|_| node.skin.is_none());
            for (k, copy) in copies.iter().flat_map(|copies| copies.iter()).enumerate() {
                if (world * *copy).to_transform().is_none() {
                    return Err(too_large(format!(", copy {k},")));
                }
            }
            let world_from_mesh = match node.skin {
                Some(_) => Transform::IDENTITY,
                None => world_from_node,
            };
            placed.push(Placed {
                node: i,
                world_from_node,
                world_from_mesh,
                mesh: node.mesh,
                skin: node.skin,
                camera: node.camera,
                light: node.light,
                copies,
            });
        }
        Ok(placed)
    }

    /// The vertices of a primitive of a node's mesh: morphed by the weights that the node has in
    /// a pose, and bent by its skin.
    ///
    /// Weights of joints need not sum to one: they are divided by their sum. A vertex that no
    /// joint holds follows the first.
    pub fn bent(&self, pose: &Pose, node: usize, primitive: &Primitive) -> Bent {
        let mut bent = self.morphed(pose, node, primitive);
        let Some(skin) = self.nodes[node].skin else { return bent };
        let skin = &self.skins[skin];
        let world = &pose.world_from_node;
        let joints: Vec<Affine> = skin
            .joints
            .iter()
            .zip(&skin.joint_from_mesh)
            .map(|(&joint, joint_from_mesh)| world[joint] * *joint_from_mesh)
            .collect();
        // What no joint can hold stands where its node does.
        let rigid = match primitive.skinning.is_empty() {
            true => world[node],
            false => joints.first().copied().unwrap_or(world[node]),
        };
        let place = |i: usize| {
            let sets = primitive
                .skinning
                .iter()
                .filter_map(|set| Some(set.joints.get(i)?.iter().zip(set.weights.get(i)?)));
            let (mut sum, mut total) = (Affine::ZERO, 0.0);
            for (joint, weight) in sets.flatten().filter(|(_, weight)| **weight > 0.0) {
                if let Some(joint) = joints.get(usize::from(*joint)) {
                    sum = sum.plus(&joint.scaled(f64::from(*weight)));
                    total += f64::from(*weight);
                }
            }
            if total > 0.0 { sum.scaled(1.0 / total) } else { rigid }
        };
        let places: Vec<Affine> = (0..bent.positions.len()).map(place).collect();

        let moved = |(p, place): (&Vec3, &Affine)| single(place.point(double(*p)));
        bent.positions = Arc::new(bent.positions.iter().zip(&places).map(moved).collect());
        let turned =
            |(n, place): (&Vec3, &Affine)| single(direction(place.normal(direction(double(*n)))));
        bent.normals = bent.normals.map(|n| Arc::new(n.iter().zip(&places).map(turned).collect()));
        let turned = |(&[x, y, z, w], place): (&[f32; 4], &Affine)| {
            let along = direction(place.vector(DVec3::new(x.into(), y.into(), z.into())));
            let [x, y, z] = single(along).to_array();
            // Where left becomes right, the bitangent does too.
            let [a, b, c] = place.linear;
            [x, y, z, if a.dot(b.cross(c)) < 0.0 { -w } else { w }]
        };
        bent.tangents =
            bent.tangents.map(|t| Arc::new(t.iter().zip(&places).map(turned).collect()));
        bent
    }

    /// Whether the vertices of a node's primitive are others than the primitive's own.
    pub(super) fn is_bent(&self, pose: &Pose, node: usize, primitive: &Primitive) -> bool {
        self.nodes[node].skin.is_some() || self.morphing(pose, node, primitive).next().is_some()
    }

    /// The morph targets that change anything, and their weights.
    fn morphing<'a>(
        &'a self,
        pose: &'a Pose,
        node: usize,
        primitive: &'a Primitive,
    ) -> impl Iterator<Item = (&'a MorphTarget, f32)> {
        let own = self.nodes[node].weights.as_deref();
        let mesh = self.nodes[node].mesh.and_then(|mesh| self.meshes.get(mesh));
        let weights = pose.weights.get(&node).map(Vec::as_slice).or(own);
        let weights = weights.or(mesh.map(|mesh| &mesh.weights[..])).unwrap_or_default();
        let counts = |(target, weight): &(&MorphTarget, f32)| {
            let MorphTarget { positions, normals, tangents } = target;
            let changes = positions.is_some() || normals.is_some() || tangents.is_some();
            changes && *weight != 0.0
        };
        primitive.targets.iter().zip(weights.iter().copied()).filter(counts)
    }

    /// The vertices with what morph targets add.
    fn morphed(&self, pose: &Pose, node: usize, primitive: &Primitive) -> Bent {
        let mut bent = Bent {
            positions: primitive.positions.clone(),
            normals: primitive.normals.clone(),
            tangents: primitive.tangents.clone(),
        };
        for (target, weight) in self.morphing(pose, node, primitive) {
            let add = |to: &mut Arc<Vec<Vec3>>, change: &Option<Arc<Vec<Vec3>>>| {
                let Some(change) = change else { return };
                let pairs = Arc::make_mut(to).iter_mut().zip(change.iter());
                pairs.for_each(|(value, change)| *value += weight * *change);
            };
            add(&mut bent.positions, &target.positions);
            if let Some(normals) = &mut bent.normals {
                add(normals, &target.normals);
            }
            if let (Some(tangents), Some(change)) = (&mut bent.tangents, &target.tangents) {
                let pairs = Arc::make_mut(tangents).iter_mut().zip(change.iter());
                pairs.for_each(|([x, y, z, _], change)| {
                    *x += weight * change.x;
                    *y += weight * change.y;
                    *z += weight * change.z;
                });
            }
        }
        bent
    }
}
