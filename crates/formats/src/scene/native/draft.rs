//! A scene while it is being read.

use super::table::Table;
use crate::error::{SceneError, SceneErrorKind};
use crate::limits::Limits;
use crate::options::ReadOptions;
use crate::scene::bare;
use crate::scene::files::Files;
use crate::scene::loaded::TextureName;
use crate::scene::origins::{MeshOrigin, Origins};
use crate::scene::pictures::Pictures;
use crate::shown::shown;
use rutilant::material::Material;
use rutilant::scene::{MaterialId, MeshId, Place, Scene, SceneProblem, TextureId};
use rutilant::shape::{Mesh, Object};
use rutilant::texture::Texture;
use rutilant_geom::{Aabb, Transform};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

/// The scene so far, and what is needed to go on.
pub(super) struct Draft<'d> {
    /// What has been read.
    pub(super) scene: Scene,
    /// The table that each part of the scene came from.
    pub(super) places: HashMap<Place, Table<'d>>,
    /// What a person should know.
    pub(super) notes: Vec<String>,
    /// Materials by name.
    pub(super) materials: HashMap<&'d str, MaterialId>,
    /// Textures by name.
    pub(super) textures: HashMap<&'d str, TextureId>,
    /// What the text calls them.
    pub(super) texture_names: Vec<TextureName>,
    /// The pictures that they show.
    pub(super) pictures: Pictures,
    /// Which materials came from mesh files.
    pub(super) mesh_materials: Vec<usize>,
    /// Mesh files that have been read, by file and crease angle.
    pub(super) mesh_files: HashMap<(PathBuf, Option<u32>), Rc<MeshFile>>,
    /// The matte grey for faces without a material, once one needed it.
    grey: Option<MaterialId>,
    /// Where files are looked for.
    pub(super) files: Files<'d>,
    /// What the scene calls its images.
    pub(super) image_names: Vec<String>,
    /// Where pictures and meshes come from.
    pub(super) origins: Origins,
    /// The files that were read.
    pub(super) read: Vec<PathBuf>,
    /// What may be read in all.
    limits: Limits,
    /// What may still be read.
    pub(super) left: Limits,
}

/// What a mesh file brought into the scene.
pub(super) struct MeshFile {
    /// What it is made of.
    pub(super) parts: Vec<Part>,
    /// The box around all of it.
    pub(super) bounds: Aabb,
    /// What has no material, for people; `None` where everything has one or nothing has.
    pub(super) without_material: Option<String>,
}

/// A part of a mesh file.
pub(super) struct Part {
    /// What the file calls it beside its mesh; may be empty.
    pub(super) name: Arc<str>,
    pub(super) mesh: MeshId,
    /// The material that the file gives it.
    pub(super) own: Option<MaterialId>,
    /// What it has where neither the file nor the shape gives it one.
    pub(super) stand_in: Option<MaterialId>,
    /// Where it stands in the file.
    pub(super) file_from_part: Transform,
}

impl Part {
    /// One that stands where its numbers say.
    pub(super) fn new(mesh: MeshId, own: Option<MaterialId>) -> Self {
        let (name, file_from_part) = (Arc::default(), Transform::IDENTITY);
        Self { name, mesh, own, stand_in: None, file_from_part }
    }
}

impl<'d> Draft<'d> {
    pub(super) fn new(file: &Path, options: &'d ReadOptions<'d>) -> Self {
        Self {
            scene: bare::empty(),
            places: HashMap::new(),
            notes: Vec::new(),
            materials: HashMap::new(),
            textures: HashMap::new(),
            texture_names: Vec::new(),
            pictures: Pictures::default(),
            mesh_materials: Vec::new(),
            mesh_files: HashMap::new(),
            grey: None,
            files: Files::beside(file, options),
            image_names: Vec::new(),
            origins: Origins::default(),
            read: Vec::new(),
            limits: options.limits,
            left: options.limits,
        }
    }

    /// Adds a material that `table` is to answer for.
    pub(super) fn add_material(&mut self, table: &Table<'d>, material: Material) -> MaterialId {
        self.places.insert(Place::Material(self.scene.materials.len()), *table);
        self.scene.add_material(material)
    }

    /// Adds a texture that `table` is to answer for.
    pub(super) fn add_texture(
        &mut self,
        table: &Table<'d>,
        name: TextureName,
        texture: impl Into<Texture>,
    ) -> TextureId {
        self.places.insert(Place::Texture(self.scene.textures.len()), *table);
        self.texture_names.push(name);
        self.scene.add_texture(texture)
    }

    /// Adds a mesh that `table` is to answer for, unless there are too many triangles by now.
    pub(super) fn add_mesh(
        &mut self,
        table: &Table<'d>,
        mesh: Mesh,
        origin: MeshOrigin,
    ) -> Result<MeshId, SceneErrorKind> {
        let (left, limits) = (&mut self.left, &self.limits);
        let (vertices, triangles) = (mesh.positions.len() as u64, mesh.triangles.len() as u64);
        spend("vertices", &mut left.vertices, vertices, limits.vertices)?;
        spend("triangles", &mut left.triangles, triangles, limits.triangles)?;
        self.places.insert(Place::Mesh(self.scene.meshes.len()), *table);
        self.origins.meshes.push(origin);
        Ok(self.scene.add_mesh(mesh))
    }

    /// Adds an object that `table` is to answer for, unless there are too many by now.
    pub(super) fn add_object(
        &mut self,
        table: &Table<'d>,
        object: Object,
    ) -> Result<(), SceneError> {
        spend("objects", &mut self.left.objects, 1, self.limits.objects)
            .map_err(|kind| table.error(kind))?;
        self.places.insert(Place::Object(self.scene.objects.len()), *table);
        self.scene.objects.push(object);
        Ok(())
    }

    /// The matte grey that stands in where there is no material.
    pub(super) fn grey(&mut self) -> MaterialId {
        *self.grey.get_or_insert_with(|| self.scene.add_material(bare::grey()))
    }

    /// A problem of the finished scene, at the place in the text that it came from.
    pub(super) fn locate(&self, root: &Table<'d>, problem: &SceneProblem) -> SceneError {
        let Some(table) = self.places.get(&problem.place) else {
            return root.invalid(problem.to_string());
        };
        let (at, own) = table.place_of(problem.key);
        // What came from a file is not to be seen in the text: say what part of it is meant.
        let part = match problem.place {
            Place::Material(i) => self.scene.materials.get(i).map(|m| ("material", &m.name)),
            Place::Mesh(i) => self.scene.meshes.get(i).map(|m| ("mesh", &m.name)),
            Place::Settings
            | Place::Camera
            | Place::Environment
            | Place::Texture(_)
            | Place::Object(_)
            | Place::Light(_) => None,
        };
        let rounded = table.rounded(problem.key).unwrap_or_default();
        let what = format!("{}{rounded}", problem.what);
        table.invalid_at(
            at,
            match part {
                Some((kind, name)) if !own => format!("{kind} \"{}\": {what}", shown(name)),
                Some(_) | None => what,
            },
        )
    }
}

/// Takes `asked` from what is `left` of what is `allowed`.
fn spend(
    what: &'static str,
    left: &mut u64,
    asked: u64,
    allowed: u64,
) -> Result<(), SceneErrorKind> {
    match left.checked_sub(asked) {
        Some(rest) => {
            *left = rest;
            Ok(())
        }
        None => {
            let asked = (allowed - *left).saturating_add(asked);
            Err(SceneErrorKind::Limit { what, asked, allowed })
        }
    }
}
