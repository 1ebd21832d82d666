//! What the author wrote: plain arrays and typed ids, in any order, not yet traceable.
//!
//! A [`Scene`] is built by hand or read from a file, checked by
//! [`Scene::validate`] and made traceable by [`Prepared::new`](crate::Prepared::new).

pub use crate::id::{BitmapId, ImageId, MaterialId, MeshId, TextureId};
pub use crate::problem::{MOST_GROUPS, MOST_LIGHT, Note, Place, SceneProblem};

use crate::camera::Camera;
use crate::groups::check_groups;
use crate::image::Image;
use crate::light::{Environment, Light};
use crate::material::Material;
use crate::shape::{Mesh, Object, Shape};
use crate::sharing;
use crate::texture::{Bitmap, Texture};
use rutilant_geom::BuildOptions;
use std::sync::Arc;

/// Everything that can be seen or gives light, and the eye that sees it.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The eye.
    pub camera: Camera,
    /// Light from infinitely far away, in all directions; none is black.
    pub environment: Option<Environment>,
    /// Pixels that textures use; [`BitmapId`] counts in this array.
    pub bitmaps: Vec<Arc<Bitmap>>,
    /// What varies over surfaces; [`TextureId`] counts in this array.
    pub textures: Vec<Texture>,
    /// How surfaces look; [`MaterialId`] counts in this array.
    pub materials: Vec<Material>,
    /// Triangle meshes that objects share; [`MeshId`] counts in this array.
    pub meshes: Vec<Mesh>,
    /// Pictures that environments use; [`ImageId`] counts in this array.
    pub images: Vec<Arc<Image>>,
    /// Shapes that stand in the world, each with its material.
    pub objects: Vec<Object>,
    /// Lights without a surface. Objects with an emitting material are lights as well.
    pub lights: Vec<Light>,
}

impl Scene {
    /// A scene with nothing in it but a camera.
    pub fn new(camera: impl Into<Camera>) -> Self {
        Self {
            camera: camera.into(),
            environment: None,
            bitmaps: Vec::new(),
            textures: Vec::new(),
            materials: Vec::new(),
            meshes: Vec::new(),
            images: Vec::new(),
            objects: Vec::new(),
            lights: Vec::new(),
        }
    }

    /// Adds pixels and returns their id.
    pub fn add_bitmap(&mut self, bitmap: impl Into<Arc<Bitmap>>) -> BitmapId {
        self.bitmaps.push(bitmap.into());
        BitmapId(last_index(&self.bitmaps))
    }

    /// Adds a texture and returns its id.
    pub fn add_texture(&mut self, texture: impl Into<Texture>) -> TextureId {
        self.textures.push(texture.into());
        TextureId(last_index(&self.textures))
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
    pub fn add_image(&mut self, image: impl Into<Arc<Image>>) -> ImageId {
        self.images.push(image.into());
        ImageId(last_index(&self.images))
    }

    /// The first thing in this scene that cannot be rendered, if there is one.
    ///
    /// # Errors
    /// Numbers that are not finite or out of their range, ids that lead
    /// nowhere, meshes whose arrays do not fit together, mixes that contain
    /// themselves, more light groups than [`MOST_GROUPS`].
    pub fn validate(&self) -> Result<(), SceneProblem> {
        self.camera.validate()?;
        if let Some(environment) = &self.environment {
            environment.validate(&self.images)?;
        }
        for (i, texture) in self.textures.iter().enumerate() {
            texture.validate(i, &self.bitmaps)?;
        }
        for (i, material) in self.materials.iter().enumerate() {
            material.validate(i, &self.materials, self.textures.len())?;
        }
        for (i, mesh) in self.meshes.iter().enumerate() {
            mesh.validate(i)?;
        }
        for (i, object) in self.objects.iter().enumerate() {
            object.validate(i, &self.materials, self.meshes.len())?;
        }
        for (i, light) in self.lights.iter().enumerate() {
            light.validate(i)?;
        }
        check_groups(self)?;
        self.check_size(BuildOptions::default().copies)
    }

    /// All vertices, triangles and shapes that will be stored are numbered by 32 bits, and so are
    /// lights. What an instance of a mesh places is not stored; `copies` as in [`BuildOptions`].
    pub(crate) fn check_size(&self, copies: u32) -> Result<(), SceneProblem> {
        let (mut vertices, mut primitives, mut lights) = (0_u64, 0_u64, 0_u64);
        let instances = sharing::instances(self, copies);
        let mut stored = vec![false; self.meshes.len()];
        for (i, object) in self.objects.iter().enumerate() {
            let (v, p) = match &object.shape {
                Shape::Mesh(id) => {
                    let mesh = &self.meshes[id.0 as usize];
                    (mesh.positions.len() as u64, mesh.triangles.len() as u64)
                }
                Shape::Box { .. } => (24, 12),
                Shape::Rectangle { .. } => (4, 2),
                Shape::Sphere { .. } | Shape::Disk { .. } | Shape::Custom(_) => (0, 1),
            };
            if self.materials[object.material.0 as usize].gives_light() {
                lights += p;
            }
            let again = match object.shape {
                Shape::Mesh(id) if instances[i] => {
                    primitives += 1;
                    std::mem::replace(&mut stored[id.0 as usize], true)
                }
                Shape::Mesh(_)
                | Shape::Box { .. }
                | Shape::Rectangle { .. }
                | Shape::Sphere { .. }
                | Shape::Disk { .. }
                | Shape::Custom(_) => false,
            };
            if !again {
                vertices += v;
                primitives += p;
            }
            if vertices.max(primitives).max(lights) > MAX_PRIMITIVES {
                return Err(Place::Object(i).problem(
                    "type",
                    format!("this and what comes before it have more than {MAX_PRIMITIVES} vertices or triangles"),
                ));
            }
        }
        Ok(())
    }
}

/// The most vertices, the most triangles and other shapes, and the most lights that may be stored.
const MAX_PRIMITIVES: u64 = 1 << 31;

/// Scenes hold at most 2³² − 1 of each kind; the reader's limits stop far earlier.
fn last_index<T>(items: &[T]) -> u32 {
    u32::try_from(items.len() - 1).expect("fewer than 2^32 items of a kind")
}
