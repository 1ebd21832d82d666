//! A scene as its statements tell it, before anything is made of it.

use super::lexer::Place;
use super::parameters::Parameters;
use super::state::State;
use crate::scene::affine::Affine;
use rutilant::shape::Mesh;
use std::collections::HashMap;
use std::path::PathBuf;

/// Everything that was said.
#[derive(Default)]
pub(super) struct Description {
    /// Statements before `WorldBegin`; the last of each kind counts.
    pub(super) camera: Option<Eye>,
    pub(super) film: Option<Named>,
    pub(super) filter: Option<Named>,
    pub(super) sampler: Option<Named>,
    pub(super) integrator: Option<Named>,
    /// Whether something was said as only pbrt-v3 does, or before it.
    pub(super) is_old: bool,

    pub(super) textures: Vec<TextureStatement>,
    /// Those of `MakeNamedMaterial`.
    pub(super) named_materials: Vec<Named>,
    /// Those of `Material`.
    pub(super) own_materials: Vec<Named>,
    pub(super) media: HashMap<String, Parameters>,
    pub(super) lights: Vec<LightStatement>,
    /// All shapes, those of objects among them.
    pub(super) shapes: Vec<Placed>,
    /// Those that stand in the world by themselves.
    pub(super) free: Vec<usize>,
    /// The shapes of each object.
    pub(super) objects: HashMap<String, Vec<usize>>,
    pub(super) instances: Vec<Instance>,
    /// The files of the scene beside its own.
    pub(super) files: Vec<PathBuf>,
}

/// A statement with the name of what it makes.
pub(super) struct Named {
    /// The kind of it: "perspective", "diffuse"; of named materials their own name.
    pub(super) name: String,
    pub(super) parameters: Parameters,
}

/// A camera.
pub(super) struct Eye {
    pub(super) kind: String,
    pub(super) parameters: Parameters,
    /// Camera from world.
    pub(super) map: Affine,
}

/// A texture.
pub(super) struct TextureStatement {
    pub(super) name: String,
    /// Whether it gives colours; else numbers.
    pub(super) colors: bool,
    /// "imagemap", "scale" …
    pub(super) kind: String,
    pub(super) parameters: Parameters,
}

/// A light without a surface.
pub(super) struct LightStatement {
    pub(super) kind: String,
    pub(super) parameters: Parameters,
    /// World from light.
    pub(super) map: Affine,
}

/// A shape with all that it found.
pub(super) struct Placed {
    pub(super) form: Form,
    pub(super) state: State,
    /// For its opacity.
    pub(super) parameters: Parameters,
    /// In how many parts pbrt takes it: each of them is a light of its own.
    pub(super) parts: usize,
}

/// What a shape is.
pub(super) enum Form {
    Mesh(Mesh),
    /// A PLY file, by its number among those to be read.
    File(usize),
    /// A whole sphere around the origin.
    Sphere {
        radius: f32,
    },
    /// A whole disk around the z axis.
    Disk {
        radius: f32,
        height: f32,
    },
}

/// An object that is placed.
pub(super) struct Instance {
    pub(super) name: String,
    pub(super) map: Affine,
    pub(super) place: Place,
}
