//! From a description to a scene of the renderer.

use super::camera;
use super::description::{Description, Form, Placed};
use super::film::{self, Film};
use super::lexer::{Place, Texts};
use super::lights::{self, World};
use super::materials::Which;
use super::parser::Parser;
use super::shapes::{self, PlyFiles};
use super::spectra::{Library, told};
use super::textures::{Change, Texel};
use crate::camera::AuthoredCamera;
use crate::error::{SceneError, SceneErrorKind, Source};
use crate::file;
use crate::image;
use crate::options::{CameraChoice, ReadOptions, SkyChoice};
use crate::scene::affine::Affine;
use crate::scene::bare;
use crate::scene::called;
use crate::scene::files::Files;
use crate::scene::framing::seen_whole;
use crate::scene::loaded::{LoadedScene, TextureName, camera_named};
use crate::scene::nearest::nearest;
use crate::scene::notes::Notes;
use crate::scene::origins::{MeshOrigin, Origins, PictureOrigin};
use crate::scene::pictures::Pictures;
use crate::scene::round;
use crate::shown::shown;
use rayon::prelude::*;
use rutilant::color::Rgb;
use rutilant::light::Environment;
use rutilant::material::{Absorption, Material};
use rutilant::scene::{self, MaterialId, MeshId, Scene, TextureId};
use rutilant::shape::{Mesh, Object, Shape};
use rutilant::texture::{Bitmap, Encoding, Texels, Texture};
use rutilant_geom::DVec3;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Textures of textures and mixtures of mixtures are followed by calls within calls: deeper ones are
/// refused whatever the limits say. So many of both fit into the 2 MB of stack that a thread has.
const DEEPEST: u64 = 100;

/// Reads a `.pbrt` file as a scene.
pub(crate) fn read(path: &Path, options: &ReadOptions<'_>) -> Result<LoadedScene, SceneError> {
    read_bytes(file::scene_bytes(path, &options.limits)?, path, options)
}

/// As [`read`], for the content of a file that would stand at `path`.
pub(crate) fn read_bytes(
    bytes: Vec<u8>,
    path: &Path,
    options: &ReadOptions<'_>,
) -> Result<LoadedScene, SceneError> {
    let bytes = super::gzip::unpacked(bytes, path, &options.limits)?;
    let files = Files::beside(path, options);
    let mut parser = Parser::new(&files, options);
    parser.read(bytes, path)?;
    let Parser { texts, mut notes, mut description, ply, vertices_left, triangles_left, .. } =
        parser;

    // What the film and the camera say; the world is turned as the camera and the sky need it.
    let mut film = Film::read(&description, &texts, &mut notes, options)?;
    let mut settings = film::settings(&description, &texts, &mut notes)?;
    let eye = description.camera.as_ref().map_or(Affine::IDENTITY, |eye| eye.map);
    let mirrored = (camera::ours_from_theirs(&description) * eye).mirrors();
    let world = World::of(lights::sky_statement(&description.lights), mirrored);
    let authored = camera::read(&description, &mut film, &world.map, &texts, &mut notes)?;
    (settings.size, settings.crop) = (film.size, film.crop);

    let mut limits = options.limits;
    (limits.vertices, limits.triangles) = (vertices_left, triangles_left);
    let read = ply.read(&limits, &texts)?;

    let forms: Vec<Form> = description
        .shapes
        .iter_mut()
        .map(|placed| std::mem::replace(&mut placed.form, Form::File(0)))
        .collect();
    let names = Names::of(&description);
    limits = options.limits;
    limits.nesting = limits.nesting.min(DEEPEST);
    let options = &ReadOptions { limits, ..*options };
    let mut maker = Maker {
        description: &description,
        texts: &texts,
        notes,
        files: &files,
        options,
        names,
        exposure: film.exposure,
        world,
        scene: bare::empty(),
        pictures: Pictures::default(),
        texels: HashMap::new(),
        depth: 0,
        texture_ids: HashMap::new(),
        texture_names: Vec::new(),
        changed: Vec::new(),
        media: HashMap::new(),
        making: Vec::new(),
        mixed_parts: 0,
        material_ids: HashMap::new(),
        looks: HashMap::new(),
        mesh_origins: Vec::new(),
        image_names: Vec::new(),
        image_origins: Vec::new(),
        read_files: Vec::new(),
        lines: HashMap::new(),
    };
    maker.media()?;
    let shapes = maker.shapes(forms, read, &ply)?;
    maker.place(&shapes)?;
    maker.lights()?;
    maker.finish(path, authored, settings, &ply)
}

/// What names mean.
pub(super) struct Names {
    textures: HashMap<(String, bool), Vec<usize>>,
    materials: HashMap<String, Vec<usize>>,
}

impl Names {
    fn of(description: &Description) -> Self {
        let mut textures = HashMap::<_, Vec<usize>>::new();
        for (i, texture) in description.textures.iter().enumerate() {
            textures.entry((texture.name.clone(), texture.colors)).or_default().push(i);
        }
        let mut materials = HashMap::<_, Vec<usize>>::new();
        for (i, named) in description.named_materials.iter().enumerate() {
            materials.entry(named.name.clone()).or_default().push(i);
        }
        Self { textures, materials }
    }

    /// The last one before `before`, or else the first one behind.
    fn last(numbers: &[usize], before: usize) -> Option<usize> {
        let count = numbers.partition_point(|&number| number < before);
        count.checked_sub(1).map(|i| numbers[i]).or(numbers.first().copied())
    }

    pub(super) fn texture(&self, name: &str, colors: bool, before: usize) -> Option<usize> {
        let of = |colors: bool| {
            let numbers = self.textures.get(&(name.to_owned(), colors))?;
            Self::last(numbers, before)
        };
        of(colors).or_else(|| of(!colors))
    }

    pub(super) fn material(&self, name: &str, before: usize) -> Option<usize> {
        Self::last(self.materials.get(name)?, before)
    }
}

/// Which material of the scene a shape has: the statement, what stands on both sides, the number of
/// its area light and the parts of that, and how much of it there is.
type MaterialKey = (Which, [String; 2], Option<(usize, usize)>, String);

/// A scene that is being made.
pub(super) struct Maker<'d> {
    pub(super) description: &'d Description,
    pub(super) texts: &'d Texts,
    pub(super) notes: Notes,
    pub(super) files: &'d Files<'d>,
    pub(super) options: &'d ReadOptions<'d>,
    pub(super) names: Names,
    /// What all light is multiplied by.
    pub(super) exposure: f32,
    pub(super) world: World,
    pub(super) scene: Scene,
    pub(super) pictures: Pictures,
    /// By number; `None` while it is being made.
    pub(super) texels: HashMap<usize, Option<Texel>>,
    pub(super) depth: u64,
    /// By what they are, in words.
    pub(super) texture_ids: HashMap<String, TextureId>,
    /// The file of the picture of each, if it has one.
    pub(super) texture_names: Vec<String>,
    /// Those whose pictures are changed.
    pub(super) changed: Vec<(TextureId, Vec<Change>)>,
    /// What absorbs, by name.
    pub(super) media: HashMap<String, Absorption>,
    /// What is being made, the outermost first.
    pub(super) making: Vec<Which>,
    pub(super) mixed_parts: usize,
    material_ids: HashMap<MaterialKey, MaterialId>,
    looks: HashMap<(Which, [String; 2]), Material>,
    mesh_origins: Vec<MeshOrigin>,
    pub(super) image_names: Vec<String>,
    pub(super) image_origins: Vec<PictureOrigin>,
    pub(super) read_files: Vec<PathBuf>,
    pub(super) lines: HashMap<scene::Place, u32>,
}

/// A shape that can be placed.
struct Ready {
    /// What mattes call it: its material, where that has a name. Meshes of files have their own.
    name: Arc<str>,
    shape: Shape,
    material: MaterialId,
    /// From the shape's own space to that in which it was told.
    own: Affine,
}

impl<'d> Maker<'d> {
    pub(super) fn note(&mut self, place: Place, what: impl Into<String>) {
        self.notes.say(self.texts, place, what);
    }

    /// Where spectra are looked for.
    pub(super) fn library(&self) -> Library<'d> {
        Library { texts: self.texts, files: self.files, limits: &self.options.limits }
    }

    /// What absorbs of all media that have names.
    fn media(&mut self) -> Result<(), SceneError> {
        let description = self.description;
        let mut named: Vec<_> = description.media.iter().collect();
        named.sort_by_key(|(_, parameters)| (parameters.place.text, parameters.place.at));
        for (name, parameters) in named {
            let of = |key: &str, usual: [f32; 3]| match parameters.get(key) {
                Some(parameter) => {
                    let told = told(parameters, parameter, self.library())?;
                    Ok::<_, SceneError>(told.map_or(Rgb::BLACK, |told| told.numbers()))
                }
                None => Ok(Rgb(usual)),
            };
            // Per millimetre, of the medium that pbrt takes where nothing is said.
            let absorbs = of("sigma_a", [0.0011, 0.0024, 0.014])?;
            let scatters = of("sigma_s", [2.55, 3.21, 3.77])?;
            let kind = parameters.text("type", self.texts)?.unwrap_or("homogeneous");
            let scale = parameters.number_or("scale", 1.0, self.texts)?;
            let preset = parameters.text("preset", self.texts)?;
            let absorption = if kind != "homogeneous" || preset.is_some() {
                let what =
                    format!("{} is left out: only even media that absorb are made", parameters.of);
                self.note(parameters.place, what);
                Absorption::None
            } else {
                if scatters != Rgb::BLACK {
                    let what = format!("{} does not scatter light: it only absorbs", parameters.of);
                    self.note(parameters.place, what);
                }
                parameters.ignore(&["g"]);
                parameters.tell_unused(self.texts, &mut self.notes);
                let sigma = absorbs.0.map(|c| (c * scale).clamp(0.0, 1e9));
                match Rgb(sigma) {
                    Rgb::BLACK => Absorption::None,
                    sigma => Absorption::Coefficient(sigma),
                }
            };
            self.media.insert(name.clone(), absorption);
        }
        Ok(())
    }

    /// All shapes, with their meshes and materials.
    fn shapes(
        &mut self,
        forms: Vec<Form>,
        read: Vec<shapes::Read>,
        ply: &PlyFiles,
    ) -> Result<Vec<Ready>, SceneError> {
        let description = self.description;
        let mut files: Vec<_> = read.into_iter().map(Some).collect();
        // By file, and whether it is turned inside out.
        let mut known = HashMap::<(usize, bool), MeshId>::new();
        let mut ready = Vec::with_capacity(forms.len());
        for (placed, form) in description.shapes.iter().zip(forms) {
            let material = self.material(placed)?;
            let name = match form {
                Form::File(_) => "",
                Form::Mesh(_) | Form::Sphere { .. } | Form::Disk { .. } => {
                    called::shortened(&self.scene.materials[material.0 as usize].name)
                }
            };
            let name = name.into();
            let (shape, own) = match form {
                Form::Mesh(mesh) => {
                    let mesh = shapes::oriented(mesh, placed.state.reversed).0;
                    (Shape::Mesh(self.mesh(mesh, MeshOrigin::Made)), Affine::IDENTITY)
                }
                Form::File(number) => {
                    let key = (number, placed.state.reversed);
                    let id = match (known.get(&key), known.get(&(number, !placed.state.reversed))) {
                        (Some(id), _) => *id,
                        (None, Some(other)) => {
                            let other = self.scene.meshes[other.0 as usize].clone();
                            self.mesh(shapes::oriented(other, true).0, MeshOrigin::Made)
                        }
                        (None, None) => {
                            let Some(read) = files[number].take() else { continue };
                            self.notes_of_file(&read.notes);
                            let origin = ply
                                .file(number)
                                .filter(|_| read.as_it_is && !placed.state.reversed);
                            let origin = origin.map_or(MeshOrigin::Made, |path| MeshOrigin::File {
                                path,
                                crease: None,
                            });
                            let mesh = match placed.state.reversed {
                                true => shapes::oriented(read.mesh, true).0,
                                false => read.mesh,
                            };
                            self.mesh(mesh, origin)
                        }
                    };
                    known.insert(key, id);
                    (Shape::Mesh(id), Affine::IDENTITY)
                }
                Form::Sphere { radius } => {
                    let round = placed.state.map.uniform_scale().is_some();
                    if round && !placed.state.reversed {
                        // pbrt's poles lie on z, and its longitude begins at +x.
                        let linear = [DVec3::NEG_Y, DVec3::Z, DVec3::NEG_X];
                        let turned = Affine { linear, translation: DVec3::ZERO };
                        let plain = description.textures.is_empty();
                        (Shape::Sphere { radius }, if plain { Affine::IDENTITY } else { turned })
                    } else {
                        let mesh = round::sphere(radius, [-90.0, 90.0], 360.0);
                        let mesh = shapes::oriented(mesh, placed.state.reversed).0;
                        (Shape::Mesh(self.mesh(mesh, MeshOrigin::Made)), Affine::IDENTITY)
                    }
                }
                Form::Disk { radius, height } => {
                    let mut textured = false;
                    let look = &mut self.scene.materials[material.0 as usize];
                    look.each_texture_mut(|_| textured = true);
                    if textured {
                        let what = "a picture lies on a whole disk from side to side, not around \
                                    its middle";
                        self.note(placed.parameters.place, what);
                    }
                    let mut own = Affine::translate(DVec3::Z * f64::from(height));
                    if placed.state.reversed {
                        own = own * Affine::scale(DVec3::new(1.0, -1.0, -1.0));
                    }
                    (Shape::Disk { radius }, own)
                }
            };
            placed.parameters.tell_unused(self.texts, &mut self.notes);
            ready.push(Ready { name, shape, material, own: placed.state.map * own });
        }
        Ok(ready)
    }

    fn notes_of_file(&mut self, notes: &[String]) {
        for note in notes {
            self.notes.repeat(note);
        }
    }

    fn mesh(&mut self, mesh: Mesh, origin: MeshOrigin) -> MeshId {
        self.mesh_origins.push(origin);
        self.scene.add_mesh(mesh)
    }

    /// The scene's material for a shape.
    fn material(&mut self, placed: &Placed) -> Result<MaterialId, SceneError> {
        let which = self.which(&placed.state.material)?;
        let media = [&placed.state.inside, &placed.state.outside].map(ToString::to_string);
        let alpha = self.alpha(placed)?;
        let parts = placed.state.area_light.as_ref().map(|light| {
            let told = light.parameters.get("power").is_some();
            (light.number, if told { placed.parts } else { 1 })
        });
        let opaque = alpha == Texel::number(1.0);
        let key = (which, media, parts, if opaque { String::new() } else { format!("{alpha:?}") });
        if let Some(id) = self.material_ids.get(&key) {
            return Ok(*id);
        }
        let look = (which, key.1.clone());
        let mut material = match self.looks.get(&look) {
            Some(material) => material.clone(),
            None => {
                let made = self.look(which, [&placed.state.inside, &placed.state.outside])?;
                self.looks.insert(look, made.clone());
                made
            }
        };
        if !opaque {
            self.open(&mut material, &alpha);
        }
        if let (Some(light), Some((_, parts))) = (&placed.state.area_light, parts) {
            material.emission = self.emission(light, parts)?;
        }
        let place = match which {
            Which::Default => placed.parameters.place,
            Which::Own(number) => self.description.own_materials[number].parameters.place,
            Which::Named(number) => self.description.named_materials[number].parameters.place,
        };
        let id = self.scene.add_material(material);
        if place.text == 0 {
            self.lines.insert(scene::Place::Material(id.0 as usize), place.line);
        }
        self.material_ids.insert(key, id);
        Ok(id)
    }

    /// Puts everything where it stands.
    fn place(&mut self, shapes: &[Ready]) -> Result<(), SceneError> {
        let description = self.description;
        for &number in &description.free {
            let place = description.shapes[number].parameters.place;
            let name = Arc::clone(&shapes[number].name);
            self.object(name, &shapes[number], &Affine::IDENTITY, place);
        }
        // Few lines can ask for very many: all are counted before any takes memory.
        let mut count = self.scene.objects.len() as u64;
        let mut placed = Vec::with_capacity(description.instances.len());
        for instance in &description.instances {
            let Some(parts) = description.objects.get(&instance.name) else {
                let known = description.objects.keys().map(String::as_str);
                let kind = SceneErrorKind::Unknown {
                    what: "object",
                    name: shown(&instance.name),
                    closest: nearest(&instance.name, known).map(shown),
                };
                return Err(self.texts.error(instance.place, kind));
            };
            count += parts.len() as u64;
            let allowed = self.options.limits.objects;
            if count > allowed {
                let kind = SceneErrorKind::Limit { what: "objects", asked: count, allowed };
                return Err(self.texts.error(instance.place, kind));
            }
            placed.push((instance, parts));
        }
        self.scene.objects.reserve(count as usize - self.scene.objects.len());
        // The names of the parts of each object: however often it stands, they stand once.
        let mut known = HashMap::<&str, Vec<Arc<str>>>::new();
        for (instance, parts) in placed {
            let names = known.entry(&instance.name).or_insert_with(|| {
                let each =
                    parts.iter().map(|&number| self.part_of(&instance.name, &shapes[number]));
                each.collect()
            });
            for (&number, name) in parts.iter().zip(names) {
                self.object(Arc::clone(name), &shapes[number], &instance.map, instance.place);
            }
        }
        Ok(())
    }

    /// What mattes call a part of an object: an object is an asset.
    fn part_of(&self, object: &str, part: &Ready) -> Arc<str> {
        let of_mesh = match part.shape {
            Shape::Mesh(id) => &*self.scene.meshes[id.0 as usize].name,
            Shape::Sphere { .. }
            | Shape::Rectangle { .. }
            | Shape::Disk { .. }
            | Shape::Box { .. }
            | Shape::Custom(_) => "",
        };
        let own = if part.name.is_empty() { of_mesh } else { &*part.name };
        called::part_of(object, called::shortened(own))
    }

    fn object(&mut self, name: Arc<str>, ready: &Ready, map: &Affine, place: Place) {
        let world = self.world.map * *map * ready.own;
        let found = world.to_transform().filter(|transform| transform.inverse().is_some());
        let Some(world_from_object) = found else {
            self.note(place, "what stands here is flattened or too large: it is left out");
            return;
        };
        if place.text == 0 {
            let number = self.scene.objects.len();
            self.lines.insert(scene::Place::Object(number), place.line);
        }
        let object = Object::new(ready.shape.clone(), ready.material);
        self.scene.objects.push(Object { name, world_from_object, ..object });
    }

    /// Reads pictures, and holds everything against what a scene must be.
    fn finish(
        mut self,
        path: &Path,
        authored: AuthoredCamera,
        settings: rutilant::settings::Settings,
        ply: &PlyFiles,
    ) -> Result<LoadedScene, SceneError> {
        let options = self.options;
        let invalid = |what: String| SceneError::invalid_file(path, what);
        let lit = self.scene.environment.is_some()
            || !self.scene.lights.is_empty()
            || self.scene.materials.iter().any(Material::gives_light);
        if !lit && self.scene.objects.is_empty() {
            return Err(invalid("there is nothing to see in it".to_owned()));
        }
        if !lit && *options.sky == SkyChoice::Own {
            self.scene.environment = Some(Environment::constant(Rgb::WHITE));
            let start = Place { text: 0, at: 0, line: 1 };
            self.note(start, "there is no light in it: an even white sky stands in");
        }
        let mut cameras = vec![authored];
        let mut camera = camera_named(&cameras, path, options)?;
        if *options.camera == CameraChoice::Auto {
            let size = options.size.unwrap_or(settings.size);
            camera = cameras.len();
            cameras.push(seen_whole(&self.scene, size, path)?);
        }
        let size = options.size.unwrap_or(settings.size);
        self.scene.camera = cameras[camera].camera(size).map_err(|problem| {
            let place = self.description.camera.as_ref().map(|eye| eye.parameters.place);
            match place {
                Some(place) => self.texts.invalid(place, problem.what),
                None => invalid(problem.what),
            }
        })?;
        settings.validate().map_err(|problem| {
            let place = self.description.film.as_ref().map(|film| film.parameters.place);
            match place {
                Some(place) => self.texts.invalid(place, problem.what),
                None => invalid(problem.what),
            }
        })?;

        // Before pictures are read, which can take long.
        self.scene.bitmaps = self.pictures.bare();
        self.check(path)?;
        let mut notes = std::mem::take(&mut self.notes).into_list(path);
        let mut bitmaps = self.pictures.read(&options.limits, options.strict, &mut notes)?;
        let mut origins = self.pictures.origins();
        self.change(&mut bitmaps, &mut origins)?;
        self.scene.bitmaps = bitmaps;
        self.check(path)?;

        let mut files = self.description.files.clone();
        files.extend(ply.files());
        files.extend(self.read_files);
        files.extend(self.pictures.files());
        let texture_names = self.texture_names.into_iter().map(TextureName::Image).collect();
        Ok(LoadedScene {
            scene: self.scene,
            settings,
            display: Default::default(),
            cameras,
            camera,
            image_names: self.image_names,
            texture_names,
            origins: Origins {
                bitmaps: origins,
                images: self.image_origins,
                meshes: self.mesh_origins,
            },
            notes,
            files,
            lines: self.lines,
        })
    }

    /// What is wrong with the scene as a whole, at the line of the part that is to blame.
    fn check(&self, path: &Path) -> Result<(), SceneError> {
        self.scene.validate().map_err(|problem| {
            let line = self.lines.get(&problem.place).copied();
            let what = SceneErrorKind::Invalid(problem.to_string());
            let at = match line {
                Some(line) => Source::at(path, line, 0),
                None => Source::file(path),
            };
            SceneError { at, kind: what }
        })
    }

    /// Makes the pictures whose values are changed. The same change of the same picture is made once.
    fn change(
        &mut self,
        bitmaps: &mut Vec<Arc<Bitmap>>,
        origins: &mut Vec<PictureOrigin>,
    ) -> Result<(), SceneError> {
        let mut wanted: Vec<(usize, Encoding, Vec<Change>, String)> = Vec::new();
        let mut known = HashMap::<String, usize>::new();
        let mut of_texture = Vec::new();
        for (id, changes) in std::mem::take(&mut self.changed) {
            let Texture::Image(image) = &self.scene.textures[id.0 as usize] else { continue };
            let source = image.bitmap.0 as usize;
            // What stands in for a picture is nothing to be changed.
            if matches!(origins.get(source), Some(PictureOrigin::Missing(_))) {
                continue;
            }
            let key = format!("{source} {:?} {changes:?}", image.encoding);
            let next = wanted.len();
            let number = *known.entry(key).or_insert(next);
            if number == next {
                let name = self.texture_names[id.0 as usize].clone();
                wanted.push((source, image.encoding, changes, name));
            }
            of_texture.push((id, number));
        }
        let first = bitmaps.len();
        let mut left = self.options.limits.texture_bytes;
        for bitmap in &*bitmaps {
            left = left.saturating_sub(bitmap.bytes());
        }
        let made: Vec<_> = wanted
            .par_iter()
            .map(|(source, encoding, changes, name)| {
                let bitmap = changed(&bitmaps[*source], *encoding, changes);
                let bytes = image::encoded(&bitmap);
                let stem = Path::new(name).file_stem().unwrap_or_default().to_string_lossy();
                (bitmap, bytes.map(|bytes| (format!("{stem}-changed"), bytes)))
            })
            .collect();
        for (bitmap, bytes) in made {
            left = left.checked_sub(bitmap.bytes()).ok_or_else(|| {
                let allowed = self.options.limits.texture_bytes;
                let asked = (allowed - left).saturating_add(bitmap.bytes());
                let kind = SceneErrorKind::Limit { what: "bytes of textures", asked, allowed };
                let start = Place { text: 0, at: 0, line: 1 };
                self.texts.error(start, kind)
            })?;
            bitmaps.push(Arc::new(bitmap));
            origins.push(match bytes {
                Ok((title, bytes)) => PictureOrigin::Bytes { title, bytes: Arc::new(bytes) },
                Err(what) => PictureOrigin::Missing(what),
            });
        }
        for (id, number) in of_texture {
            if let Texture::Image(image) = &mut self.scene.textures[id.0 as usize] {
                image.bitmap = scene::BitmapId((first + number) as u32);
            }
        }
        Ok(())
    }
}

/// A picture with each of its values changed, but for opacity.
fn changed(bitmap: &Bitmap, encoding: Encoding, changes: &[Change]) -> Bitmap {
    let change = |value: f32| {
        let value = changes.iter().fold(value, |value, change| change.apply(value));
        if value.is_finite() { value.max(0.0) } else { 0.0 }
    };
    // A code as what it stands for, and back; both from 0 to 1.
    let decode = |code: f64| match encoding {
        Encoding::Srgb => rutilant::display::linear_from_srgb(code) as f32,
        Encoding::Linear => code as f32,
    };
    let encode = |value: f32| match encoding {
        Encoding::Srgb => rutilant::display::srgb_from_linear(value.min(1.0)),
        Encoding::Linear => value.min(1.0),
    };
    let channels = bitmap.channels();
    let is_color = |i: usize| !bitmap.has_alpha() || i % channels != channels - 1;
    let texels = match bitmap.texels() {
        Texels::Eight(codes) => {
            let table: Vec<u8> = (0..=u8::MAX)
                .map(|code| (255.0 * encode(change(decode(f64::from(code) / 255.0))) + 0.5) as u8)
                .collect();
            let each = codes.iter().enumerate();
            let map = |(i, code): (usize, &u8)| {
                if is_color(i) { table[usize::from(*code)] } else { *code }
            };
            Texels::Eight(each.map(map).collect())
        }
        Texels::Sixteen(codes) => {
            let table: Vec<u16> = (0..=u16::MAX)
                .map(|code| {
                    (65535.0 * encode(change(decode(f64::from(code) / 65535.0))) + 0.5) as u16
                })
                .collect();
            let each = codes.iter().enumerate();
            let map = |(i, code): (usize, &u16)| {
                if is_color(i) { table[usize::from(*code)] } else { *code }
            };
            Texels::Sixteen(each.map(map).collect())
        }
        Texels::Float(values) => {
            let each = values.iter().enumerate();
            let map = |(i, value): (usize, &f32)| if is_color(i) { change(*value) } else { *value };
            Texels::Float(each.map(map).collect())
        }
    };
    let made = Bitmap::new(bitmap.width(), bitmap.height(), channels, texels);
    made.unwrap_or_else(|| bitmap.clone())
}
