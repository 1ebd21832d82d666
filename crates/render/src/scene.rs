//! What the author wrote: plain arrays and typed ids, in any order, not yet traceable.
//!
//! A [`Scene`] is built by hand or read from a file, checked by
//! [`Scene::validate`] and made traceable by [`Prepared::new`](crate::Prepared::new).

use crate::camera::Camera;
use crate::image::Image;
use crate::light::{Environment, Light};
use crate::material::Material;
use crate::shape::{Mesh, Object};
use std::fmt;
use std::ops::RangeInclusive;

/// Everything that can be seen or gives light, and the eye that sees it.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The eye.
    pub camera: Camera,
    /// Light from infinitely far away, in all directions; none is black.
    pub environment: Option<Environment>,
    /// How surfaces look; [`MaterialId`] counts in this array.
    pub materials: Vec<Material>,
    /// Triangle meshes that objects share; [`MeshId`] counts in this array.
    pub meshes: Vec<Mesh>,
    /// Pictures that environments use; [`ImageId`] counts in this array.
    pub images: Vec<Image>,
    /// Shapes that stand in the world, each with its material.
    pub objects: Vec<Object>,
    /// Lights without a surface. Objects with an emitting material are lights as well.
    pub lights: Vec<Light>,
}

/// A place in [`Scene::materials`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct MaterialId(pub u32);

/// A place in [`Scene::meshes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct MeshId(pub u32);

/// A place in [`Scene::images`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ImageId(pub u32);

impl Scene {
    /// A scene with nothing in it but a camera.
    pub fn new(camera: impl Into<Camera>) -> Self {
        Self {
            camera: camera.into(),
            environment: None,
            materials: Vec::new(),
            meshes: Vec::new(),
            images: Vec::new(),
            objects: Vec::new(),
            lights: Vec::new(),
        }
    }

    /// Adds a material and returns its id.
    pub fn add_material(&mut self, material: impl Into<Material>) -> MaterialId {
        self.materials.push(material.into());
        MaterialId(last_index(&self.materials))
    }

    /// Adds a mesh and returns its id.
    pub fn add_mesh(&mut self, mesh: Mesh) -> MeshId {
        self.meshes.push(mesh);
        MeshId(last_index(&self.meshes))
    }

    /// Adds an image and returns its id.
    pub fn add_image(&mut self, image: Image) -> ImageId {
        self.images.push(image);
        ImageId(last_index(&self.images))
    }

    /// The first thing in this scene that cannot be rendered, if there is one.
    ///
    /// # Errors
    /// Numbers that are not finite or out of their range, ids that lead
    /// nowhere, meshes whose arrays do not fit together, mixes that contain
    /// themselves.
    pub fn validate(&self) -> Result<(), SceneProblem> {
        self.camera.validate()?;
        if let Some(environment) = &self.environment {
            environment.validate(&self.images)?;
        }
        for (i, material) in self.materials.iter().enumerate() {
            material.validate(i, &self.materials)?;
        }
        for (i, mesh) in self.meshes.iter().enumerate() {
            mesh.validate(i)?;
        }
        for (i, object) in self.objects.iter().enumerate() {
            object.validate(i, self)?;
        }
        for (i, light) in self.lights.iter().enumerate() {
            light.validate(i)?;
        }
        Ok(())
    }
}

/// Scenes hold at most 2³² − 1 of each kind; the reader's limits stop far earlier.
fn last_index<T>(items: &[T]) -> u32 {
    u32::try_from(items.len() - 1).expect("fewer than 2^32 items of a kind")
}

/// Why a scene cannot be rendered, and which of its parts is to blame.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{place}: {what}")]
pub struct SceneProblem {
    /// The part of the scene.
    pub place: Place,
    /// The property of that part, by the name of its key in the native scene format.
    pub key: &'static str,
    /// What is wrong, what would be right.
    pub what: String,
}

/// A part of a scene. The numbers count in the arrays of [`Scene`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "each is named after the part it means")]
pub enum Place {
    Settings,
    Camera,
    Environment,
    Material(usize),
    Mesh(usize),
    Object(usize),
    Light(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Settings => write!(f, "render settings"),
            Self::Camera => write!(f, "camera"),
            Self::Environment => write!(f, "environment"),
            Self::Material(i) => write!(f, "material {i}"),
            Self::Mesh(i) => write!(f, "mesh {i}"),
            Self::Object(i) => write!(f, "object {i}"),
            Self::Light(i) => write!(f, "light {i}"),
        }
    }
}

impl Place {
    /// A problem here: `what` is wrong with `key`.
    pub(crate) fn problem(self, key: &'static str, what: impl Into<String>) -> SceneProblem {
        SceneProblem { place: self, key, what: what.into() }
    }

    /// Checks that every number lies in `range`, which NaN never does.
    pub(crate) fn check(
        self,
        key: &'static str,
        values: impl IntoIterator<Item = f32>,
        range: RangeInclusive<f32>,
    ) -> Result<(), SceneProblem> {
        let (least, most) = (*range.start(), *range.end());
        match values.into_iter().find(|v| !range.contains(v)) {
            None => Ok(()),
            Some(v) if !v.is_finite() => {
                Err(self.problem(key, format!("{key} is {v}, but must be a finite number")))
            }
            Some(v) if most == f32::MAX && least == f32::MIN_POSITIVE => {
                Err(self.problem(key, format!("{key} is {v}, but must be more than 0")))
            }
            Some(v) if least == f32::MIN_POSITIVE => {
                Err(self
                    .problem(key, format!("{key} is {v}, but must be more than 0, up to {most}")))
            }
            Some(v) if most == f32::MAX => {
                Err(self.problem(key, format!("{key} is {v}, but must be {least} or more")))
            }
            Some(v) => {
                Err(self
                    .problem(key, format!("{key} is {v}, but must lie between {least} and {most}")))
            }
        }
    }
}

/// Any finite number.
pub(crate) const FINITE: RangeInclusive<f32> = f32::MIN..=f32::MAX;
/// Zero or more.
pub(crate) const NOT_NEGATIVE: RangeInclusive<f32> = 0.0..=f32::MAX;
/// More than zero.
pub(crate) const POSITIVE: RangeInclusive<f32> = f32::MIN_POSITIVE..=f32::MAX;
/// A part of a whole.
pub(crate) const UNIT: RangeInclusive<f32> = 0.0..=1.0;
