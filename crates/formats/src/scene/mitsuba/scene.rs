//! From a document to a scene of the renderer.

use super::bsdf::Look;
use super::document::{self, Class, Content, Document, View, plain_text};
use super::emitter::upright;
use super::shape::{MeshKey, Ready, ReadyKey};
use super::texture::{Paint, Use};
use crate::camera::AuthoredCamera;
use crate::error::{SceneError, SceneErrorKind};
use crate::file;
use crate::limits::Limits;
use crate::options::{CameraChoice, ReadOptions};
use crate::scene::affine::Affine;
use crate::scene::bare;
use crate::scene::framing::seen_whole;
use crate::scene::loaded::{LoadedScene, camera_named, position_of};
use crate::scene::origins::{Origins, PictureOrigin};
use crate::scene::pictures::Pictures;
use rutilant::color::Rgb;
use rutilant::material::{Absorption, Dielectric, Emission, Material, MaterialKind, Medium};
use rutilant::scene::{MaterialId, MeshId, Place, Scene, SceneProblem};
use rutilant::settings::Settings;
use rutilant::shape::Mesh;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

/// Reads a `.xml` file as a scene.
pub(crate) fn read(path: &Path, options: &ReadOptions<'_>) -> Result<LoadedScene, SceneError> {
    read_bytes(file::scene_bytes(path, &options.limits)?, path, options)
}

/// The scene that a text says; `path` is where it would stand.
pub(crate) fn read_bytes(
    bytes: Vec<u8>,
    path: &Path,
    options: &ReadOptions<'_>,
) -> Result<LoadedScene, SceneError> {
    let document = Document::parse(plain_text(bytes, path)?, path, options)?;
    let scene = document.object(0);
    let mut maker = Maker {
        document: &document,
        options,
        scene: bare::empty(),
        pictures: Pictures::default(),
        turn: upright(scene)?.unwrap_or(Affine::IDENTITY),
        looks: HashMap::new(),
        materials: HashMap::new(),
        paints: HashMap::new(),
        meshes: HashMap::new(),
        ready: HashMap::new(),
        bytes: HashMap::new(),
        image_names: Vec::new(),
        image_origins: Vec::new(),
        places: HashMap::new(),
        notes: Vec::new(),
        vertices: 0,
        triangles: 0,
    };
    // Definitions are looked at where they are used.
    scene.pass_over_parts();
    for emitter in scene.parts(Class::Emitter) {
        maker.emitter(emitter)?;
    }
    maker.count(scene)?;
    for shape in scene.parts(Class::Shape) {
        maker.place(shape, &Affine::IDENTITY, None)?;
    }
    maker.finish(scene, path)
}

/// A scene that is being made.
pub(super) struct Maker<'d, 'o> {
    pub(super) document: &'d Document<'o>,
    pub(super) options: &'o ReadOptions<'o>,
    pub(super) scene: Scene,
    pub(super) pictures: Pictures,
    /// What all of the scene is turned by.
    pub(super) turn: Affine,
    looks: HashMap<usize, Look>,
    materials: HashMap<MaterialKey, MaterialId>,
    pub(super) paints: HashMap<(usize, Use), Paint>,
    pub(super) meshes: HashMap<MeshKey, Vec<MeshId>>,
    /// The parts of groups that have been placed.
    pub(super) ready: HashMap<ReadyKey, Rc<Ready>>,
    /// Files of which more than one mesh is wanted.
    pub(super) bytes: HashMap<PathBuf, Arc<Content>>,
    pub(super) image_names: Vec<String>,
    pub(super) image_origins: Vec<PictureOrigin>,
    /// Where the parts of the scene are written.
    places: HashMap<Place, document::Place>,
    /// Of mesh files.
    pub(super) notes: Vec<String>,
    vertices: u64,
    triangles: u64,
}

/// The numbers of a BSDF, an emitter and a medium.
type MaterialKey = [Option<usize>; 3];

impl Maker<'_, '_> {
    /// Remembers where a part of the scene is written.
    pub(super) fn remember(&mut self, part: Place, place: document::Place) {
        self.places.insert(part, place);
    }

    /// How a BSDF looks; each is looked at once.
    pub(super) fn look_of(&mut self, bsdf: View<'_, '_>) -> Result<Look, SceneError> {
        if let Some(look) = self.looks.get(&bsdf.number) {
            return Ok(look.clone());
        }
        let look = self.look(bsdf, 0)?;
        self.looks.insert(bsdf.number, look.clone());
        Ok(look)
    }

    /// The material of a shape: how it looks, what it gives, and what is in it.
    pub(super) fn material(
        &mut self,
        shape: View<'_, '_>,
        bsdf: Option<View<'_, '_>>,
        look: &Look,
        emission: Option<Emission>,
    ) -> Result<MaterialId, SceneError> {
        let emitter = shape.only(Class::Emitter);
        let inside = shape.part("interior");
        if shape.part("exterior").is_some() {
            let what = "the exterior medium of a shape is left out: what is around it is around it";
            shape.note(what, what);
        }
        let key = [bsdf, emitter, inside].map(|view| view.map(|view| view.number));
        if let Some(id) = self.materials.get(&key) {
            return Ok(*id);
        }
        let mut look = look.clone();
        if let Some(inside) = inside {
            let absorption = self.absorption(inside)?;
            match &mut look.kind {
                MaterialKind::Dielectric(Dielectric { interior, .. }) => {
                    *interior = Medium { absorption, ..*interior };
                }
                MaterialKind::Principled(layers) if layers.has_inside() => {
                    layers.absorption = absorption;
                }
                MaterialKind::Null => {
                    let clear = Medium { absorption, ..Medium::AIR };
                    let border = Dielectric { interior: clear, ..Dielectric::new(1.0) };
                    look.kind = MaterialKind::Dielectric(border);
                }
                MaterialKind::Black
                | MaterialKind::Matte(_)
                | MaterialKind::Mirror(_)
                | MaterialKind::Conductor(_)
                | MaterialKind::ThinDielectric(_)
                | MaterialKind::Principled(_)
                | MaterialKind::Mix(_)
                | MaterialKind::Custom(_) => {}
            }
        }
        let black_behind = !look.two_sided && look.opacity.is_none() && !is_through(&look.kind);
        if black_behind {
            let what = "surfaces that are not \"twosided\", whose backs are black in Mitsuba, look the \
                        same from behind here";
            shape.note(what, what);
        }
        let material = Material { emission, ..look.material() };
        let id = self.scene.add_material(material);
        let place = bsdf.map_or(shape.place(), |bsdf| bsdf.place());
        self.remember(Place::Material(id.0 as usize), place);
        self.materials.insert(key, id);
        Ok(id)
    }

    /// How light fades in a medium.
    fn absorption(&mut self, medium: View<'_, '_>) -> Result<Absorption, SceneError> {
        if medium.class() != Class::Medium || medium.plugin() != "homogeneous" {
            let what = format!(
                "only homogeneous media are read, not \"{}\"",
                crate::shown::shown(medium.plugin())
            );
            return Err(medium.document.unsupported(medium.place(), what));
        }
        medium.pass_over_parts();
        medium.pass_over(&["has_spectral_extinction", "sample_emitters"]);
        let scale = medium.number("scale", 1.0)?;
        let total = self.even_color(medium, "sigma_t", Use::Number)?;
        let own = self.even_color(medium, "sigma_a", Use::Number)?;
        let scattered = self.even_color(medium, "sigma_s", Use::Number)?;
        let albedo = self.even_color(medium, "albedo", Use::Number)?;
        let albedo = albedo.unwrap_or(Rgb::grey(if own.is_some() { 0.0 } else { 0.75 }));
        if albedo != Rgb::BLACK || scattered.is_some_and(|sigma| sigma != Rgb::BLACK) {
            let what = "media do not scatter light here: only what they absorb is shown";
            medium.note(what, what);
        }
        let sigma = match (own, total) {
            (Some(own), _) => own,
            (None, total) => {
                let total = total.unwrap_or(Rgb::WHITE);
                Rgb([0, 1, 2].map(|i| total.0[i] * (1.0 - albedo.0[i])))
            }
        };
        let sigma = sigma.0.map(|c| (c * scale).max(0.0));
        Ok(if sigma == [0.0; 3] { Absorption::None } else { Absorption::Coefficient(Rgb(sigma)) })
    }

    /// What may still be read of meshes.
    pub(super) fn limits_left(&self) -> Limits {
        let limits = self.options.limits;
        Limits {
            vertices: limits.vertices.saturating_sub(self.vertices),
            triangles: limits.triangles.saturating_sub(self.triangles),
            ..limits
        }
    }

    pub(super) fn add_mesh(&mut self, mesh: Mesh) -> MeshId {
        self.vertices += mesh.positions.len() as u64;
        self.triangles += mesh.triangles.len() as u64;
        self.scene.add_mesh(mesh)
    }

    /// Adds eyes, and what is said of the picture.
    fn finish(mut self, scene: View<'_, '_>, path: &Path) -> Result<LoadedScene, SceneError> {
        let options = self.options;
        let sensors: Vec<View<'_, '_>> = scene.parts(Class::Sensor).collect();
        let named = match options.camera {
            CameraChoice::Named(name) => position_of(name, sensors.iter().map(View::id)),
            CameraChoice::First | CameraChoice::Auto => None,
        };
        let mut settings = Settings::default();
        let shown_by = sensors.get(named.unwrap_or(0)).copied();
        // Film and sampler of the others do not count.
        sensors.iter().for_each(View::pass_over_parts);
        self.film(shown_by, &mut settings)?;
        self.integrator(scene, &mut settings)?;
        let size = options.size.unwrap_or(settings.size);

        let mut cameras: Vec<AuthoredCamera> = Vec::new();
        for sensor in &sensors {
            cameras.push(self.camera(*sensor, size)?);
        }
        let mut camera = camera_named(&cameras, path, options)?;
        let auto = *options.camera == CameraChoice::Auto;
        self.scene.bitmaps =
            self.pictures.read(&options.limits, options.strict, &mut self.notes)?;
        if cameras.is_empty() || auto {
            // What is wrong with the things comes before that they cannot be seen.
            self.scene.validate().map_err(|problem| self.blame(problem, path))?;
            camera = cameras.len();
            cameras.push(seen_whole(&self.scene, size, path)?);
            if !auto {
                let what = "there is no sensor in it: a camera was chosen that sees everything";
                self.notes.push(format!("{}: {what}", path.display()));
            }
        }
        if let Some(sensor) = sensors.get(camera) {
            self.remember(Place::Camera, sensor.place());
            self.remember(Place::Settings, sensor.place());
        }
        let made = cameras[camera].camera(size);
        self.scene.camera = made.map_err(|problem| self.blame(problem, path))?;
        self.scene.validate().map_err(|problem| self.blame(problem, path))?;
        settings.validate().map_err(|problem| self.blame(problem, path))?;

        let mut notes = self.document.finish(path);
        notes.append(&mut self.notes);
        let mut files = std::mem::take(&mut *self.document.found.borrow_mut());
        for file in self.pictures.files() {
            if !files.contains(&file) {
                files.push(file);
            }
        }
        let lines = self.document.lines(&self.places);
        Ok(LoadedScene {
            scene: self.scene,
            settings,
            display: Default::default(),
            cameras,
            camera,
            image_names: self.image_names,
            texture_names: Vec::new(),
            origins: Origins {
                bitmaps: self.pictures.origins(),
                images: self.image_origins,
                ..Origins::default()
            },
            notes,
            files,
            lines,
        })
    }

    /// What is wrong with a part of the scene, at the place where it is written.
    fn blame(&self, problem: SceneProblem, path: &Path) -> SceneError {
        match self.places.get(&problem.place) {
            Some(place) => self.document.invalid(*place, problem.what),
            None => SceneError::in_file(path, SceneErrorKind::Invalid(problem.to_string())),
        }
    }
}

/// Whether light goes through, so that there is no black back.
fn is_through(kind: &MaterialKind) -> bool {
    match kind {
        MaterialKind::Null
        | MaterialKind::Dielectric(_)
        | MaterialKind::ThinDielectric(_)
        | MaterialKind::Black
        | MaterialKind::Custom(_) => true,
        MaterialKind::Principled(layers) => {
            layers.transmission > 0.0 || layers.diffuse_transmission > 0.0
        }
        MaterialKind::Matte(_)
        | MaterialKind::Mirror(_)
        | MaterialKind::Conductor(_)
        | MaterialKind::Mix(_) => false,
    }
}
