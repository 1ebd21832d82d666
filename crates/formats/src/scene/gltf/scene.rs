//! From a document to a scene of the renderer.
//!
//! Every material becomes a principled one, or a matte one that glows where it
//! is unlit. Texture coordinates have v downwards in the document and upwards
//! in a scene: meshes are turned over as they are taken in, and what textures
//! do to coordinates with them. Meshes are taken in once, however often they
//! stand somewhere.

use super::document::Document;
use super::material::{Alpha, Material as Written};
use super::mesh::Primitive;
use super::node::{LightKind, Projection};
use super::pose::{Moment, Placed, Pose};
use super::texture::{Filter, ImageBytes, TextureRef, UvTransform, Wrap as WrittenWrap};
use super::uri;
use crate::camera::{AuthoredCamera, CameraKind};
use crate::error::{SceneError, SceneErrorKind, Source};
use crate::limits::Limits;
use crate::options::{CameraChoice, ReadOptions, SkyChoice};
use crate::scene::bare;
use crate::scene::called;
use crate::scene::files::Files;
use crate::scene::framing::seen_whole;
use crate::scene::loaded::{LoadedScene, NOTHING_MOVES, camera_named};
use crate::scene::origins::Origins;
use crate::scene::pictures::{self, Pictures, Wanted};
use crate::scene::spectrum::normal_reflectance;
use crate::shown::shown;
use rutilant::color::Rgb;
use rutilant::light::{Environment, Light, SpotLight};
use rutilant::material::{
    Absorption, Bumps, Emission, EmittedLight, MAX_IOR, MAX_SPECULAR_COLOR, MOST_ROUGH_RATIO,
    Material, MaterialKind, NormalMap, Opacity, OpacityMode, Principled, PrincipledTextures, Sides,
    most_rough_dispersion,
};
use rutilant::scene::{BitmapId, MOST_LIGHT, MaterialId, MeshId, Scene, TextureId};
use rutilant::settings::Settings;
use rutilant::shape::{Mesh, Object, Shape};
use rutilant::texture::{
    Channel, Encoding, ImageTexture, Interpolation, ScalarInput, Texture, UvMapping, Wrap,
};
use rutilant_geom::{Transform, Vec2, Vec3, real};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Reads a `.gltf` or `.glb` file as a scene.
pub(crate) fn read(path: &Path, options: &ReadOptions<'_>) -> Result<LoadedScene, SceneError> {
    if let Some(seconds) = options.at_time.filter(|seconds| !seconds.is_finite()) {
        let what = format!("the time that is asked for is {seconds} s, but must be finite");
        return Err(SceneError::invalid_file(path, what));
    }
    let document = super::read(path, options)?;
    let variant = options.variant.map(|name| document.variant(name)).transpose()?;
    let moment = options.at_time.map(|seconds| Moment { animation: 0, seconds });
    let pose = document.pose(moment);
    let placed = document.placed(None, &pose)?;
    let mut maker = Maker::new(&document, path, variant, options);
    if moment.is_some() && document.animations.is_empty() {
        maker.notes.push(format!("{}: {NOTHING_MOVES}", path.display()));
    }
    for placed in &placed {
        maker.place(placed, &pose)?;
    }
    for light in placed.iter().filter_map(|p| Some((p.light?, &p.world_from_node))) {
        maker.add_light(light.0, light.1);
    }
    maker.finish(&placed, options)
}

/// What a document shows of things, to be put into another scene.
pub(crate) struct Model {
    /// Its meshes, materials, textures and objects; nothing else counts.
    pub(crate) scene: Scene,
    /// The pictures that the textures show.
    pub(crate) pictures: Pictures,
    /// Materials that stand in where the document names none.
    pub(crate) stand_ins: Vec<MaterialId>,
    /// What a person should know.
    pub(crate) notes: Vec<String>,
    /// The files that it is made of, beside those of pictures.
    pub(crate) files: Vec<PathBuf>,
}

/// What the content of a `.gltf` or `.glb` file at `path` shows of things.
pub(crate) fn model(
    bytes: &[u8],
    path: &Path,
    options: &ReadOptions<'_>,
) -> Result<Model, SceneError> {
    let document = super::read_bytes(bytes, path, options)?;
    let pose = document.pose(None);
    let placed = document.placed(None, &pose)?;
    let mut maker = Maker::new(&document, path, None, options);
    for placed in &placed {
        maker.place(placed, &pose)?;
    }
    let lights = placed.iter().filter(|placed| placed.light.is_some()).count();
    let cameras = placed.iter().filter(|placed| placed.camera.is_some()).count();
    let mut notes = maker.notes;
    let mut left_out = |count: usize, what: &str| {
        if count > 0 {
            let path = path.display();
            notes.push(format!("{path}: as a mesh it has no {what}, left out: {count}"));
        }
    };
    left_out(lights, "lights");
    left_out(cameras, "cameras");
    if maker.scene.objects.is_empty() {
        let path = path.display();
        notes.push(format!("{path}: there are no faces in it, so nothing of it can be seen"));
    }
    let mut stand_ins: Vec<_> = maker
        .materials
        .iter()
        .filter_map(|((number, _), id)| number.is_none().then_some(*id))
        .collect();
    stand_ins.sort_unstable();
    let Maker { scene, pictures, .. } = maker;
    let files = document.files.clone();
    Ok(Model { scene, pictures, stand_ins, notes, files })
}

/// What mattes call the things of each node: its name, behind that of the root that it is below. A
/// node without a name leaves it to its mesh.
fn names_of(document: &Document) -> Vec<Arc<str>> {
    let mut roots: Vec<usize> = (0..document.nodes.len()).collect();
    for &node in &document.order {
        if let Some(parent) = document.nodes[node].parent {
            roots[node] = roots[parent];
        }
    }
    let each = document.nodes.iter().enumerate().zip(roots);
    each.map(|((number, node), root)| {
        let above = &document.nodes[root].name;
        if root == number || node.name.is_empty() || above.is_empty() {
            return node.name.as_str().into();
        }
        called::part_of(above, &node.name)
    })
    .collect()
}

/// A texture of the document, the set of coordinates, the bits of what is done to them, and what
/// codes mean.
type TextureKey = (usize, u32, [u32; 5], Encoding);

/// A scene that is being made.
struct Maker<'d> {
    document: &'d Document,
    path: &'d Path,
    variant: Option<usize>,
    scene: Scene,
    pictures: Pictures,
    files: Files<'d>,
    /// What mattes call the things of each node.
    names: Vec<Arc<str>>,
    /// By their numbers in the document.
    images: HashMap<usize, BitmapId>,
    textures: HashMap<TextureKey, TextureId>,
    /// By number, and whether vertex colours count.
    materials: HashMap<(Option<usize>, bool), MaterialId>,
    /// By mesh, primitive, and the set of coordinates that tangents are wanted for.
    meshes: HashMap<(usize, usize, Option<u32>), MeshId>,
    limits: &'d Limits,
    /// What the meshes of the scene take.
    taken: Taken,
    notes: Vec<String>,
}

/// What has been taken of all that a document may take.
#[derive(Default)]
struct Taken {
    vertices: u64,
    triangles: u64,
    /// Bytes of meshes that are bent.
    bent: u64,
}

impl<'d> Maker<'d> {
    fn new(
        document: &'d Document,
        path: &'d Path,
        variant: Option<usize>,
        options: &'d ReadOptions<'d>,
    ) -> Self {
        Self {
            document,
            path,
            variant,
            scene: bare::empty(),
            pictures: Pictures::default(),
            files: Files::beside(path, options),
            names: names_of(document),
            images: HashMap::new(),
            textures: HashMap::new(),
            materials: HashMap::new(),
            meshes: HashMap::new(),
            limits: &options.limits,
            taken: Taken::default(),
            notes: document.notes.clone(),
        }
    }

    /// Puts a node's mesh into the scene.
    fn place(&mut self, placed: &Placed, pose: &Pose) -> Result<(), SceneError> {
        let Some(number) = placed.mesh else { return Ok(()) };
        let document = self.document;
        for (i, primitive) in document.meshes[number].primitives.iter().enumerate() {
            let written = document.material(primitive, self.variant);
            let material = self.material(written, primitive.colors.contains_key(&0));
            let wanted = written.and_then(|m| tangents_of(&document.materials[m]));
            let tangents = wanted.filter(|_| primitive.tangents.is_none());
            // What is bent is another mesh at every node.
            let bends = document.is_bent(pose, placed.node, primitive);
            let key = (number, i, tangents);
            let mesh = match self.meshes.get(&key).filter(|_| !bends) {
                Some(known) => *known,
                None => {
                    self.take(placed.node, primitive, bends)?;
                    let bent = document.bent(pose, placed.node, primitive);
                    let mut mesh = mesh_of(primitive, &document.meshes[number].name);
                    mesh.positions = Arc::unwrap_or_clone(bent.positions);
                    mesh.normals = bent.normals.map(Arc::unwrap_or_clone).unwrap_or_default();
                    mesh.tangents = bent.tangents.map(Arc::unwrap_or_clone).unwrap_or_default();
                    if let Some(set) = tangents {
                        mesh = mesh.with_tangents(set as usize);
                    }
                    let id = self.scene.add_mesh(mesh);
                    if !bends {
                        self.meshes.insert(key, id);
                    }
                    id
                }
            };
            let copies = placed.copies.as_deref();
            let each = copies.map_or(1, Vec::len);
            for k in 0..each {
                let own = copies.and_then(|copies| copies[k].to_transform());
                let world_from_object = match own {
                    Some(node_from_copy) => placed.world_from_node * node_from_copy,
                    None => placed.world_from_mesh,
                };
                // A scale of nothing hides.
                if world_from_object.inverse().is_some() {
                    let shape = Shape::Mesh(mesh);
                    let name = Arc::clone(&self.names[placed.node]);
                    let object = Object::new(shape, material);
                    self.scene.objects.push(Object { name, world_from_object, ..object });
                }
            }
        }
        Ok(())
    }

    /// Counts a mesh that the scene gets for a node, before it is made.
    fn take(&mut self, node: usize, primitive: &Primitive, bends: bool) -> Result<(), SceneError> {
        let (taken, limits) = (&mut self.taken, self.limits);
        let vertices = primitive.positions.len() as u64;
        let triangles = primitive.triangles.len() as u64;
        taken.vertices = taken.vertices.saturating_add(vertices);
        taken.triangles = taken.triangles.saturating_add(triangles);
        let refused = |kind| Err(SceneError::in_file(self.path, kind));
        for (what, asked, allowed) in [
            ("vertices", taken.vertices, limits.vertices.min(u64::from(u32::MAX))),
            ("triangles", taken.triangles, limits.triangles),
        ] {
            if asked > allowed {
                return refused(SceneErrorKind::Limit { what, asked, allowed });
            }
        }
        if bends {
            // A position, a normal and a tangent, perhaps a colour, and texture coordinates.
            let each = 12 + 12 + 16 + 16 * primitive.colors.len().min(1) + 8 * primitive.uvs.len();
            let bytes = vertices.saturating_mul(each as u64).saturating_add(12 * triangles);
            taken.bent = taken.bent.saturating_add(bytes);
            let (bent, allowed) = (taken.bent, self.document.bendable);
            if bent > allowed {
                return refused(SceneErrorKind::Invalid(format!(
                    "nodes[{node}] bends its mesh, which makes, with those before it, copies of \
                     {bent} bytes, but for files of this size at most {allowed} are allowed"
                )));
            }
        }
        Ok(())
    }

    fn add_light(&mut self, number: usize, world: &Transform) {
        let light = &self.document.lights[number];
        let rgb = Rgb(light.color.map(|c| (c * light.intensity).min(MOST_LIGHT)));
        let position = world.translation();
        let direction = world.vector(Vec3::NEG_Z).normalize_or(Vec3::NEG_Z);
        self.scene.lights.push(match light.kind {
            LightKind::Directional => {
                Light::Directional { direction, irradiance: rgb, group: None }
            }
            LightKind::Point => Light::Point { position, intensity: rgb, group: None },
            LightKind::Spot { inner, outer } => {
                let [inner, outer] = [inner, outer].map(in_degrees);
                Light::Spot {
                    position,
                    direction,
                    light: SpotLight::Intensity(rgb),
                    inner,
                    outer,
                    group: None,
                }
            }
        });
    }

    /// The scene's material for one of the document.
    fn material(&mut self, number: Option<usize>, vertex_colors: bool) -> MaterialId {
        let key = (number, vertex_colors);
        if let Some(id) = self.materials.get(&key) {
            return *id;
        }
        let material = match number {
            Some(i) => self.made(&self.document.materials[i], vertex_colors),
            None => {
                // White, rough metal, by the specification; viewers and authors mean what is grey.
                let textures = PrincipledTextures { vertex_colors, ..Default::default() };
                let kind = Principled { roughness: 1.0, textures, ..Principled::default() };
                Material { sides: Sides::Front, ..Material::from(kind) }
            }
        };
        let id = self.scene.add_material(material);
        self.materials.insert(key, id);
        id
    }

    fn made(&mut self, written: &Written, vertex_colors: bool) -> Material {
        let [r, g, b, alpha] = written.base_color;
        let color = Rgb([r, g, b]);
        let base = self.color(written.base_color_texture.as_ref());
        let opacity = match written.alpha {
            Alpha::Opaque => None,
            Alpha::Mask { cutoff } if cutoff > 1.0 => Some((0.0, OpacityMode::Blend)),
            Alpha::Mask { cutoff } => Some((alpha, OpacityMode::Mask { cutoff })),
            Alpha::Blend => Some((alpha, OpacityMode::Blend)),
        };
        let opacity = opacity.map(|(factor, mode)| Opacity {
            amount: ScalarInput { factor, texture: base.map(|id| (id, Channel::Alpha)) },
            vertex_colors,
            mode,
        });
        let opacity = opacity.filter(|o| {
            let always = o.amount.factor >= 1.0 && o.amount.texture.is_none() && !vertex_colors;
            !always
        });
        let name = written.name.clone();
        let sides = if written.double_sided { Sides::Both } else { Sides::Front };
        if written.unlit {
            let light = EmittedLight::Radiance(color);
            let two_sided = written.double_sided;
            let emission =
                Some(Emission { light, texture: base, vertex_colors, two_sided, group: None });
            return Material {
                emission,
                opacity,
                sides,
                ..Material::new(MaterialKind::Black).named(name)
            };
        }
        let strength = written.emissive_strength;
        let radiance = Rgb(written.emissive.map(|e| (e * strength).min(MOST_LIGHT)));
        let emission = (radiance != Rgb::BLACK).then(|| Emission {
            light: EmittedLight::Radiance(radiance),
            texture: self.color(written.emissive_texture.as_ref()),
            vertex_colors: false,
            two_sided: written.double_sided,
            group: None,
        });
        let normal_map = written.normal_texture.as_ref().map(|map| NormalMap {
            texture: self.texture(map, Encoding::Linear),
            scale: written.normal_scale,
            shows: Bumps::Normals,
        });
        let kind = MaterialKind::Principled(Box::new(self.principled(
            written,
            color,
            base,
            vertex_colors,
        )));
        Material { emission, opacity, normal_map, sides, ..Material::new(kind).named(name) }
    }

    /// Tells what of a material is shown otherwise than it is written.
    fn tell(&mut self, material: &Written, what: &str) {
        let (file, name) = (self.path.display(), shown(&material.name));
        self.notes.push(format!("{file}: material \"{name}\": {what}"));
    }

    fn principled(
        &mut self,
        written: &Written,
        base_color: Rgb,
        base: Option<TextureId>,
        vertex_colors: bool,
    ) -> Principled {
        let rough = written.metallic_roughness_texture.as_ref();
        let of = PrincipledTextures {
            base_color: base,
            vertex_colors,
            metallic: self.scalar(rough, Channel::Blue),
            roughness: self.scalar(rough, Channel::Green),
            specular: self.scalar(written.specular.strength_texture.as_ref(), Channel::Alpha),
            specular_color: self.color(written.specular.color_texture.as_ref()),
            ..PrincipledTextures::default()
        };
        // An index of 0 stands for one so large that everything is reflected, but for the specular
        // colour: this makes up for what the largest one lets through.
        let endless = written.ior == 0.0;
        let ior = if endless { MAX_IOR } else { written.ior };
        let reflected = if endless { normal_reflectance(MAX_IOR, 0.0) } else { 1.0 };
        let specular_color =
            Rgb(written.specular.color.map(|c| (c / reflected).min(MAX_SPECULAR_COLOR)));
        let mut made = Principled {
            base_color,
            metallic: written.metallic,
            roughness: written.roughness,
            specular: written.specular.strength,
            specular_color,
            ior,
            thin_walled: true,
            textures: of,
            ..Principled::default()
        };
        if let Some((gloss, texture)) =
            written.specular_glossiness.and_then(|s| Some((s, s.texture?)))
        {
            // Roughness is 1 − g f for gloss g from the picture: a product only where f is 1.
            if gloss.glossiness == 1.0 {
                made.roughness = 1.0;
                made.textures.roughness = self.scalar(Some(&texture), Channel::InverseAlpha);
            } else {
                self.tell(written, "the gloss in its specularGlossinessTexture is left out");
            }
        }
        if let Some(transmission) = &written.transmission {
            made.transmission = transmission.factor;
            made.textures.transmission = self.scalar(transmission.texture.as_ref(), Channel::Red);
        }
        if let Some(volume) = written.volume.as_ref().filter(|volume| volume.thickness > 0.0) {
            made.thin_walled = false;
            let color = Rgb(volume.attenuation_color.map(|c| c.clamp(LEAST_LEFT, 1.0)));
            if volume.attenuation_distance.is_finite() && color != Rgb::WHITE {
                let distance = volume.attenuation_distance;
                made.absorption = Absorption::ColorAtDistance { color, distance };
            }
        }
        if let Some(coat) = &written.clearcoat {
            (made.coat, made.coat_roughness) = (coat.factor, coat.roughness);
            made.coat_normal_map = coat.normal_texture.as_ref().map(|map| NormalMap {
                texture: self.texture(map, Encoding::Linear),
                scale: coat.normal_scale,
                shows: Bumps::Normals,
            });
            made.textures.coat = self.scalar(coat.texture.as_ref(), Channel::Red);
            made.textures.coat_roughness =
                self.scalar(coat.roughness_texture.as_ref(), Channel::Green);
        }
        if let Some(sheen) = &written.sheen {
            (made.sheen_color, made.sheen_roughness) = (Rgb(sheen.color), sheen.roughness);
            made.textures.sheen_color = self.color(sheen.color_texture.as_ref());
            made.textures.sheen_roughness =
                self.scalar(sheen.roughness_texture.as_ref(), Channel::Alpha);
        }
        if let Some(film) = &written.iridescence {
            (made.iridescence, made.iridescence_ior) = (film.factor, film.ior);
            made.iridescence_thickness_nm = film.thickness_maximum_nm;
            made.iridescence_thickness_minimum_nm = film.thickness_minimum_nm;
            made.textures.iridescence = self.scalar(film.texture.as_ref(), Channel::Red);
            made.textures.iridescence_thickness_nm =
                self.scalar(film.thickness_texture.as_ref(), Channel::Green);
        }
        if let Some(through) = &written.diffuse_transmission {
            made.diffuse_transmission = through.factor;
            made.diffuse_transmission_color = Rgb(through.color);
            made.textures.diffuse_transmission =
                self.scalar(through.texture.as_ref(), Channel::Alpha);
            made.textures.diffuse_transmission_color = self.color(through.color_texture.as_ref());
        }
        if let Some(anisotropy) = &written.anisotropy {
            made.anisotropy = anisotropy.strength;
            made.anisotropy_rotation = in_degrees(anisotropy.rotation);
            let texture = anisotropy.texture.as_ref();
            made.textures.anisotropy = self.scalar(texture, Channel::Blue);
            made.textures.anisotropy_direction =
                texture.map(|texture| self.texture(texture, Encoding::Linear));
        }
        if made.has_inside() {
            made.dispersion = written.dispersion;
            if made.roughness > 0.0 || made.anisotropy > 0.0 {
                if ior > MOST_ROUGH_RATIO {
                    made.ior = MOST_ROUGH_RATIO;
                    let most = format!(
                        "glass that is not smooth has an ior of {MOST_ROUGH_RATIO} at most"
                    );
                    self.tell(written, &most);
                }
                // Violet light, which is bent most, must get out of rough glass as well.
                let most = most_rough_dispersion(made.ior);
                if written.dispersion > most {
                    made.dispersion = most;
                    self.tell(written, &format!("as rough glass it has a dispersion of {most}"));
                }
            }
        }
        made
    }

    fn color(&mut self, texture: Option<&TextureRef>) -> Option<TextureId> {
        texture.map(|texture| self.texture(texture, Encoding::Srgb))
    }

    fn scalar(
        &mut self,
        texture: Option<&TextureRef>,
        channel: Channel,
    ) -> Option<(TextureId, Channel)> {
        texture.map(|texture| (self.texture(texture, Encoding::Linear), channel))
    }

    /// The scene's texture for one that a material uses.
    fn texture(&mut self, used: &TextureRef, encoding: Encoding) -> TextureId {
        let UvTransform { offset: [u, v], rotation, scale: [across, along] } = used.transform;
        let transform = [u, v, rotation, across, along].map(f32::to_bits);
        let key = (used.texture, used.set, transform, encoding);
        if let Some(id) = self.textures.get(&key) {
            return *id;
        }
        let written = &self.document.textures[used.texture];
        let wrap = written.wrap.map(|wrap| match wrap {
            WrittenWrap::Repeat => Wrap::Repeat,
            WrittenWrap::Mirror => Wrap::Mirror,
            WrittenWrap::Clamp => Wrap::Clamp,
        });
        let interpolation = match written.filter {
            Filter::Linear => Interpolation::Bilinear,
            Filter::Nearest => Interpolation::Nearest,
        };
        let bitmap = self.bitmap(written.image);
        let mapping = mapping_of(used);
        let image = ImageTexture { bitmap, encoding, wrap, interpolation, mapping };
        let id = self.scene.add_texture(Texture::from(image));
        self.textures.insert(key, id);
        id
    }

    /// The picture of an image, to be read later.
    fn bitmap(&mut self, number: usize) -> BitmapId {
        if let Some(id) = self.images.get(&number) {
            return *id;
        }
        let image = &self.document.images[number];
        let at = Source::file(self.path);
        let id = match &image.bytes {
            ImageBytes::File(written) => {
                // With escapes, or with what looks like some in its name.
                let plain = uri::file_name(written);
                let plain = plain.filter(|plain| self.files.find(plain).is_ok());
                let name = plain.as_deref().unwrap_or(written);
                self.pictures.want_named(name, &self.files, at)
            }
            ImageBytes::Here(bytes) => {
                let name = format!("images[{number}]");
                let title = if image.name.is_empty() { &name } else { &image.name }.clone();
                let bytes = Arc::clone(bytes);
                let from = pictures::From::Bytes { name, title, bytes };
                self.pictures.want(Wanted { from, at })
            }
        };
        self.images.insert(number, id);
        id
    }

    /// Adds light where there is none, and eyes.
    fn finish(
        mut self,
        placed: &[Placed],
        options: &ReadOptions<'_>,
    ) -> Result<LoadedScene, SceneError> {
        let settings = Settings::default();
        let size = options.size.unwrap_or(settings.size);
        let invalid = |what: &str| SceneError::invalid_file(self.path, what);
        self.scene.bitmaps =
            self.pictures.read(&options.limits, options.strict, &mut self.notes)?;
        // What glows is shown glowing, and is no lamp to those who made the file.
        if self.scene.lights.is_empty() && *options.sky == SkyChoice::Own {
            self.scene.environment = Some(Environment::constant(Rgb::WHITE));
            self.notes.push(format!(
                "{}: there is no light in it: an even white sky stands in",
                self.path.display()
            ));
        }
        let mut cameras = Vec::new();
        for (number, world) in placed.iter().filter_map(|p| Some((p.camera?, &p.world_from_node))) {
            cameras.extend(self.camera(number, world));
        }
        let mut camera = camera_named(&cameras, self.path, options)?;
        let auto = *options.camera == CameraChoice::Auto;
        if cameras.is_empty() || auto {
            camera = cameras.len();
            cameras.push(seen_whole(&self.scene, size, self.path)?);
            if !auto {
                self.notes.push(format!(
                    "{}: there is no camera in it: one was chosen that sees everything",
                    self.path.display()
                ));
            }
        }
        self.scene.camera = cameras[camera].camera(size).map_err(|e| invalid(&e.to_string()))?;
        self.scene.validate().map_err(|e| invalid(&e.to_string()))?;
        let mut files = self.document.files.clone();
        files.extend(self.pictures.files());
        Ok(LoadedScene {
            scene: self.scene,
            settings,
            display: Default::default(),
            cameras,
            camera,
            image_names: Vec::new(),
            texture_names: Vec::new(),
            origins: Origins { bitmaps: self.pictures.origins(), ..Origins::default() },
            notes: self.notes,
            files,
            lines: Default::default(),
        })
    }

    /// A camera in words.
    fn camera(&self, number: usize, world: &Transform) -> Option<AuthoredCamera> {
        let camera = &self.document.cameras[number];
        let position = world.translation();
        let direction = world.vector(Vec3::NEG_Z).try_normalize()?;
        let up = world.vector(Vec3::Y).try_normalize()?;
        let kind = match camera.projection {
            Projection::Perspective { vertical, .. } => {
                CameraKind::perspective(vertical.to_degrees())
            }
            Projection::Orthographic { half: [_, height], .. } => {
                CameraKind::Orthographic { height: 2.0 * height.abs(), lens: Default::default() }
            }
        };
        // Far enough for the direction to be told by the difference of two points.
        let distance = position.abs().max_element().max(1.0);
        let look_at = position + direction * distance;
        let name = camera.name.clone();
        Some(AuthoredCamera { name, position, look_at, up, kind })
    }
}

/// What is left of light at least, for there to be a coefficient.
const LEAST_LEFT: f32 = 1e-4;

/// The set of coordinates whose tangents a material needs, if it needs some: those that its normals
/// are told in, which are those of its scratches as well.
fn tangents_of(written: &Written) -> Option<u32> {
    let scratched = written.anisotropy.as_ref().filter(|anisotropy| anisotropy.strength > 0.0);
    let scratches = scratched.map(|anisotropy| anisotropy.texture.map_or(0, |map| map.set));
    let coat = written.clearcoat.as_ref().and_then(|coat| coat.normal_texture);
    let map = written.normal_texture.or(coat);
    map.map(|map| map.set).or(scratches)
}

/// A primitive without what bends.
fn mesh_of(primitive: &Primitive, name: &str) -> Mesh {
    let turned = |uvs: &Arc<Vec<Vec2>>| uvs.iter().map(|uv| Vec2::new(uv.x, 1.0 - uv.y)).collect();
    let last = primitive.uvs.keys().next_back().copied();
    let mut sets = (0..=last.unwrap_or(0))
        .take(MOST_SETS)
        .map(|set| primitive.uvs.get(&set).map(turned).unwrap_or_default());
    let uvs = sets.next().unwrap_or_default();
    Mesh {
        name: name.to_owned(),
        uvs,
        more_uvs: sets.collect(),
        colors: primitive.colors.get(&0).map(|c| c.to_vec()).unwrap_or_default(),
        triangles: primitive.triangles.to_vec(),
        ..Mesh::default()
    }
}

/// More sets of texture coordinates than this are not taken.
const MOST_SETS: usize = 16;

/// The angle that stands nearest to one in radians, among those that are a number of degrees: so
/// that a native scene can say it, to the bit.
fn in_degrees(radians: f32) -> f32 {
    radians.to_degrees().to_radians()
}

/// What a texture does to coordinates, with v turned over before and after. With F(u, v) = (u, 1 − v),
/// a turn by −θ as [`UvTransform`] has it becomes one by θ.
fn mapping_of(used: &TextureRef) -> UvMapping {
    let transform = &used.transform;
    let rotation = in_degrees(transform.rotation);
    let (s, c) = real::sin_cos(rotation);
    let [scale_u, scale_v] = transform.scale;
    let [u, v] = transform.offset;
    // Where (0, 1), the document's lower left corner, goes.
    let corner = Vec2::new(s * scale_v + u, c * scale_v + v);
    UvMapping {
        set: used.set,
        scale: Vec2::new(scale_u, scale_v),
        rotation,
        offset: Vec2::new(corner.x, 1.0 - corner.y),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Turning v over, doing what the scene does, and turning it back is what the document does.
    #[test]
    fn mappings_agree() {
        let transform = UvTransform { offset: [0.3, -0.7], rotation: 0.6, scale: [2.0, -1.5] };
        let used = TextureRef { texture: 0, set: 3, transform };
        let mapping = mapping_of(&used);
        assert_eq!(mapping.set, 3);
        let (s, c) = mapping.rotation.sin_cos();
        for uv in [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::new(0.3, 0.9)] {
            let flipped = Vec2::new(uv.x, 1.0 - uv.y) * mapping.scale;
            let turned = Vec2::new(c * flipped.x - s * flipped.y, s * flipped.x + c * flipped.y);
            let there = turned + mapping.offset;
            let expected = transform.apply(uv);
            assert!((Vec2::new(there.x, 1.0 - there.y) - expected).length() < 1e-6);
        }
    }
}
