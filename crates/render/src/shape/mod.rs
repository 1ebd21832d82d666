//! What stands in a scene: shapes, and objects that give them a place and a material.

mod mesh;
mod smooth;
mod tangents;

pub use mesh::Mesh;
pub use rutilant_geom::custom::{CustomHit, CustomRay, CustomShape};

use crate::id::{MaterialId, MeshId};
use crate::light::LightGroup;
use crate::material::{Emission, EmittedLight, Material};
use crate::problem::{FINITE, POSITIVE, Place, SceneProblem};
use rutilant_geom::{Transform, Vec2, Vec3};
use std::sync::Arc;

/// A shape with a place in the world and a material.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// What the author calls it; may be empty. What comes before a first slash is the asset that it
    /// belongs to. Mattes go by this name, or else by the mesh's: see [`crate::cryptomatte`].
    pub name: Arc<str>,
    /// What it is.
    pub shape: Shape,
    /// How it looks.
    pub material: MaterialId,
    /// Where it stands. Spheres need a uniform scale; everything else takes any map but a flattening one.
    pub world_from_object: Transform,
    /// Where its light, if it gives any, counts in a picture of light groups; where its material's
    /// emission says if `None`.
    pub group: Option<LightGroup>,
}

/// A shape around the origin of its own space.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A triangle mesh.
    Mesh(MeshId),
    /// A sphere of this radius in metres; normals point outwards.
    Sphere {
        /// More than 0.
        radius: f32,
    },
    /// A rectangle in the x-y plane around the origin; its normal is +z.
    Rectangle {
        /// Width along x and height along y, in metres.
        size: Vec2,
    },
    /// A disk in the x-y plane around the origin; its normal is +z.
    Disk {
        /// More than 0, in metres.
        radius: f32,
    },
    /// A box around the origin; normals point outwards.
    Box {
        /// Its sides along x, y and z, in metres.
        size: Vec3,
    },
    /// A shape of others' making: see [`rutilant_geom::custom`]. Where it glows, its light is
    /// found by rays that run into it; it is never chosen by light sampling.
    Custom(Arc<dyn CustomShape>),
}

impl Object {
    /// A shape as it is, with a material and no name.
    pub fn new(shape: Shape, material: MaterialId) -> Self {
        let (name, world_from_object) = (Arc::default(), Transform::IDENTITY);
        Self { name, shape, material, world_from_object, group: None }
    }

    /// The same with a name.
    #[must_use]
    pub fn named(self, name: impl Into<Arc<str>>) -> Self {
        Self { name: name.into(), ..self }
    }

    /// The same with its light in this group.
    #[must_use]
    pub fn in_group(self, group: LightGroup) -> Self {
        Self { group: Some(group), ..self }
    }

    /// The same object somewhere else: `transform` applied after what it had.
    #[must_use]
    pub fn transformed(mut self, transform: &Transform) -> Self {
        self.world_from_object = *transform * self.world_from_object;
        self
    }

    pub(crate) fn validate(
        &self,
        index: usize,
        materials: &[Material],
        meshes: usize,
    ) -> Result<(), SceneProblem> {
        let place = Place::Object(index);
        let Some(material) = materials.get(self.material.0 as usize) else {
            return Err(place
                .problem("material", format!("there is no material number {}", self.material.0)));
        };
        match &self.shape {
            Shape::Mesh(id) if id.0 as usize >= meshes => {
                return Err(place.problem("file", format!("there is no mesh number {}", id.0)));
            }
            Shape::Mesh(_) => {}
            Shape::Sphere { radius } | Shape::Disk { radius } => {
                place.check("radius", [*radius], POSITIVE)?;
            }
            Shape::Rectangle { size } => place.check("size", size.to_array(), POSITIVE)?,
            Shape::Box { size } => place.check("size", size.to_array(), POSITIVE)?,
            Shape::Custom(_) => {
                if let Some(Emission { light: EmittedLight::Power(_), .. }) = material.emission {
                    return Err(place.problem(
                        "material",
                        "the area of a custom shape is not known, so no power can be spread over \
                         it: give a radiance",
                    ));
                }
            }
        }
        let world_from_object = &self.world_from_object;
        let linear = world_from_object.linear().to_cols_array();
        place.check(
            "transform",
            linear.into_iter().chain(world_from_object.translation().to_array()),
            FINITE,
        )?;
        if world_from_object.inverse().is_none() {
            let volume = world_from_object.linear().as_dmat3().determinant().abs();
            let what = if volume > 1.0 {
                "transform makes the shape too large: a scale is beyond some 1e12"
            } else {
                "transform flattens the shape: a scale is 0, or too close to it"
            };
            return Err(place.problem("transform", what));
        }
        if matches!(self.shape, Shape::Sphere { .. }) && world_from_object.uniform_scale().is_none()
        {
            return Err(place.problem(
                "transform",
                "a sphere needs the same scale in all directions; use a mesh for an ellipsoid",
            ));
        }
        Ok(())
    }
}
