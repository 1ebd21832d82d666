//! A scene as rays find it: what they meet, what that is made of, what gives light.

use super::casting::{Casting, Extent};
use super::material::PreparedMaterial;
use super::texture::{Eye, PreparedTextures};
use super::varying::Varying;
use crate::bsdf::Bsdf;
use crate::camera::Camera;
use crate::color::Spectrum;
use crate::cryptomatte::Ids;
use crate::dispersion::{BANDS, Bands};
use crate::groups::Groups;
use crate::interaction::SurfaceInteraction;
use crate::light::{Emitter, EnvironmentEmitter, LightTree};
use crate::material::Opacity;
use crate::medium::{Border, Media, PreparedMedium};
use crate::problem::{Note, Place};
use crate::settings::{IntegratorKind, Layer, Layers, Settings, Strategy};
use crate::texture::ColorInput;
use rutilant_geom::{
    Aabb, BuildOptions, BuildReport, DVec3, Hit, Ray, Sphere, Surfaces, Vec2, Vec3, offset_origin,
};
use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

/// A scene that rays can be traced through. It does not change any more; its copies share what is in
/// it, so that another view of it costs nothing ([`seen_by`](Self::seen_by)).
#[derive(Clone, Debug)]
pub struct Prepared {
    pub(crate) camera: Camera,
    pub(super) surfaces: Arc<Surfaces>,
    /// How their tree was built.
    pub(super) build: BuildOptions,
    /// The object of each primitive.
    pub(super) object_of_primitive: Arc<[u32]>,
    /// The object of each instance of a mesh that is stored once.
    pub(super) object_of_instance: Arc<[u32]>,
    pub(super) objects: Arc<[PreparedObject]>,
    /// In the world; of meshes that are stored once in their own space, of any length.
    pub(super) normals: Arc<[Vec3]>,
    pub(super) uvs: Arc<[Vec2]>,
    pub(super) colors: Arc<[[f32; 4]]>,
    /// In the world; of meshes that are stored once in their own space.
    pub(super) tangents: Arc<[[f32; 4]]>,
    pub(super) textures: Arc<PreparedTextures>,
    pub(super) materials: Arc<[PreparedMaterial]>,
    /// How much is there of the surfaces that are not everywhere.
    pub(super) opacities: Arc<[Opacity]>,
    /// What tells more of materials that vary.
    pub(super) varying: Arc<[Varying]>,
    /// The bands of the spectrum, where some material bends them differently.
    pub(super) bands: Option<Arc<Bands>>,
    /// How materials that do so scatter each band.
    pub(super) dispersed: Arc<[[Bsdf; BANDS]]>,
    /// Those with a priority, the strongest first.
    pub(super) ranked_media: Arc<[PreparedMedium]>,
    pub(super) emitters: Arc<[Emitter]>,
    /// The light groups that they are of.
    pub(super) groups: Groups,
    /// The tree of those within the scene, once it is asked for.
    pub(super) light_tree: Arc<OnceLock<Option<Arc<LightTree>>>>,
    /// The emitter that is the sky.
    pub(super) environment: Option<u32>,
    /// How much of it a pixel shows, once the film is known.
    pub(super) eye: Eye,
    /// What the camera stands in.
    pub(super) camera_media: Media,
    /// True where scattered rays may find light that light sampling cannot.
    pub(super) light_beyond_sampling: bool,
    /// Whether there is a surface that rays pass.
    pub(super) some_pass: bool,
    /// Whether there is a surface that is not everywhere.
    pub(super) some_open: bool,
    /// Whether there is a surface that light can cross.
    pub(super) has_borders: bool,
    /// Whether materials alone decide what surfaces do to light.
    pub(super) is_plain: bool,
    /// What caustics come from, where there can be some.
    pub(super) casting: Option<Arc<Casting>>,
    /// What mattes call its objects and materials.
    pub(super) ids: Ids,
    /// How far each object extends, once that is known.
    pub(super) extents: Arc<OnceLock<Vec<Extent>>>,
    pub(super) report: PrepareReport,
}

/// What came of a scene.
#[derive(Clone, Debug)]
pub struct PrepareReport {
    /// Triangles that stand in the world.
    pub triangles: u64,
    /// Triangles that are stored: those of instances once.
    pub stored_triangles: u64,
    /// Meshes that are stored once, however often they stand in the world.
    pub shared_meshes: u64,
    /// How often those stand in the world, all together.
    pub instances: u64,
    /// Spheres.
    pub spheres: u64,
    /// Disks.
    pub disks: u64,
    /// Custom shapes.
    pub customs: u64,
    /// Materials.
    pub materials: u64,
    /// Textures.
    pub textures: u64,
    /// Bytes that their pictures take, with the smaller versions made of them.
    pub texture_bytes: u64,
    /// Emitters: lights, glowing triangles and shapes, the sky.
    pub emitters: u64,
    /// The smallest box around everything.
    pub bounds: Aabb,
    /// The tree of the world; its `bytes` are those of all trees, and of what is in them.
    pub bvh: BuildReport,
    /// What was mended on the way, in words for the author.
    pub notes: Vec<Note>,
}

/// An object in the world.
#[derive(Clone, Debug)]
pub(super) struct PreparedObject {
    pub(super) material: u32,
    /// It encloses a space by itself.
    pub(super) closed: bool,
    pub(super) emitters: ObjectEmitters,
    /// Where its triangles and their vertices start among all: zero for an instance, which has those
    /// of its mesh.
    pub(super) first_primitive: u32,
    pub(super) first_vertex: u32,
    pub(super) vertices: u32,
    /// Where its vertex normals start in the common array, if it has some.
    pub(super) first_normal: Option<u32>,
    /// Where its texture coordinates start in the common array, if it has some.
    pub(super) first_uv: Option<u32>,
    /// How many sets of them there are, one after the other.
    pub(super) uv_sets: u32,
    /// Where its vertex colours start in the common array, if it has some.
    pub(super) first_color: Option<u32>,
    /// Where its tangents start in the common array, if it has some.
    pub(super) first_tangent: Option<u32>,
    /// Where the axes of a sphere go that is turned.
    pub(super) axes: Option<Box<[Vec3; 3]>>,
}

/// Which emitters an object is.
#[derive(Clone, Copy, Debug)]
pub(super) enum ObjectEmitters {
    None,
    /// The object as a whole.
    One(u32),
    /// Each primitive its own, from this number on.
    Each(u32),
}

impl PreparedObject {
    #[inline(always)]
    pub(super) fn emitter_of(&self, primitive: u32) -> Option<u32> {
        match self.emitters {
            ObjectEmitters::None => None,
            ObjectEmitters::One(emitter) => Some(emitter),
            ObjectEmitters::Each(first) => Some(first + (primitive - self.first_primitive)),
        }
    }
}

/// A vertex of a triangle in the world.
#[derive(Clone, Copy)]
pub(super) struct Vertex {
    /// Its number in the object's mesh.
    pub(super) number: u32,
    pub(super) position: Vec3,
}

/// A surface, as far as it is the same everywhere.
pub(crate) struct SurfaceOf<'p> {
    pub(crate) material: &'p PreparedMaterial,
    /// The number of the emitter that it is.
    pub(crate) emitter: Option<u32>,
    /// It has vertex normals, or a picture of normals.
    pub(crate) smoothed: bool,
}

/// The normal between the corners of a triangle, of any length.
#[inline]
pub(super) fn interpolated(corners: &[(Vec3, Vec3, f32); 3]) -> Vec3 {
    corners.iter().fold(Vec3::ZERO, |sum, (_, normal, weight)| sum + *normal * *weight)
}

impl Prepared {
    /// What came of the scene.
    pub fn report(&self) -> &PrepareReport {
        &self.report
    }

    /// What a person should know about a rendering of this scene with these settings.
    pub fn notes_for(&self, settings: &Settings) -> Vec<Note> {
        let mut notes = self.notes_on_unmet(settings);
        notes.extend(self.note_on_crop(settings));
        let left_out = [Layer::Light, Layer::Groups].map(|layer| {
            let is_there = settings.layers.has(layer) && !settings.kept_layers().has(layer);
            is_there && (layer == Layer::Light || !self.groups.names().is_empty())
        });
        let layers = match left_out {
            [false, false] => None,
            [true, false] => Some("the layer \"light\" is"),
            [false, true] => Some("the layer \"groups\" is"),
            [true, true] => Some("the layers \"light\" and \"groups\" are"),
        };
        notes.extend(layers.map(|layers| {
            format!(
                "{layers} left out: only the integrator \"path\" knows parts of light, and not with the \
                 heuristic \"optimal\""
            )
            .into()
        }));
        // Whoever asks for all layers asks for those that there are.
        let asked = settings.layers.has(Layer::Groups) && settings.layers != Layers::all();
        if asked && self.groups.names().is_empty() {
            let what = "the layer \"groups\" is left out: no light of the scene has a group";
            notes.push(what.to_owned().into());
        }
        notes
    }

    /// Where most of the work for a small crop is done outside of it.
    fn note_on_crop(&self, settings: &Settings) -> Option<Note> {
        let area = |[width, height]: [u32; 2]| u64::from(width) * u64::from(height);
        let window = settings.window();
        let small = 8 * area([window.width, window.height]) < area(settings.size);
        let traced = settings.traces_light() && self.casting.is_some();
        (small && traced).then(|| {
            "all light paths of the whole picture are traced for its caustics, however small the \
             crop; without caustics it is faster"
                .to_owned()
                .into()
        })
    }

    fn notes_on_unmet(&self, settings: &Settings) -> Vec<Note> {
        let meets = match (settings.integrator, settings.strategy) {
            (IntegratorKind::Naive, _) => "the integrator \"naive\"",
            (IntegratorKind::Path, Strategy::BsdfOnly) => "the strategy \"bsdf\"",
            (IntegratorKind::Path, Strategy::Both | Strategy::LightOnly)
            | (
                IntegratorKind::Direct
                | IntegratorKind::AmbientOcclusion
                | IntegratorKind::Normals
                | IntegratorKind::Albedo
                | IntegratorKind::Depth,
                _,
            ) => return Vec::new(),
        };
        let unmet = self.emitters.iter().filter(|e| !e.can_be_met()).count();
        let what = match self.emitters.len() - unmet {
            _ if unmet == 0 => return Vec::new(),
            0 => "there are no others: the picture will be black",
            _ => "these give no light here",
        };
        vec![
            format!(
                "{meets} finds only what rays meet, which point, spot and directional lights are \
                 not; {what}"
            )
            .into(),
        ]
    }

    /// What rays meet.
    pub(crate) fn surfaces(&self) -> &Surfaces {
        &self.surfaces
    }

    /// Whether light can cross some of the surfaces.
    pub(crate) fn has_borders(&self) -> bool {
        self.has_borders
    }

    /// Whether every surface does to light what its material says, and nothing more.
    pub(crate) fn is_plain(&self) -> bool {
        self.is_plain
    }

    /// What stands behind the number of a primitive, and of the instance that it is of.
    #[inline(always)]
    pub(crate) fn surface_of(&self, instance: Option<u32>, primitive: u32) -> SurfaceOf<'_> {
        let object = &self.objects[self.object_of(instance, primitive) as usize];
        let material = &self.materials[object.material as usize];
        SurfaceOf {
            material,
            emitter: object.emitter_of(primitive),
            smoothed: object.first_normal.is_some()
                || material.normal_map.is_some()
                || material.own_coat,
        }
    }

    /// What a ray that came along the unit vector `direction` finds at `hit`.
    pub fn interaction(&self, hit: &Hit, direction: Vec3) -> SurfaceInteraction {
        let object = self.object(hit);
        let emitter = object.emitter_of(hit.primitive);
        let flat =
            SurfaceInteraction::new(hit.position, hit.normal, -direction, object.material, emitter);
        if self.materials[object.material as usize].is_painted() {
            let at = self.kept_in_front(self.painted(hit, object, flat));
            // A coat mirrors by another normal, which is bent for the camera's way.
            let own_coat = self.materials[object.material as usize].own_coat;
            return if own_coat { at.seen_by_the_camera_alone() } else { at };
        }
        let Some(vertices) = self.vertices(hit, object) else { return flat };
        if object.first_normal.is_none() {
            return flat;
        }
        let corners = self.corners(hit, object, &vertices);
        self.kept_in_front(flat.smoothed(interpolated(&corners), corners))
    }

    /// The same where scattered rays do not start beyond another surface: one that is lifted off a
    /// label behind glass would be inside of the glass without having come in.
    #[inline]
    fn kept_in_front(&self, at: SurfaceInteraction) -> SurfaceInteraction {
        let opaque = self.has_borders && self.material(&at).border.is_none();
        if opaque && at.is_lifted() && self.occluded(&at.lift()) { at.unlifted() } else { at }
    }

    /// The corners of the triangle that was hit: where each is, its normal, which is the triangle's
    /// where vertices have none, and its barycentric weight.
    #[inline]
    pub(super) fn corners(
        &self,
        hit: &Hit,
        object: &PreparedObject,
        vertices: &[Vertex; 3],
    ) -> [(Vec3, Vec3, f32); 3] {
        let weights = hit.weights();
        std::array::from_fn(|i| {
            let Vertex { number, position } = vertices[i];
            let own = object.first_normal.map(|first| self.normal_at(hit, first + number));
            (position, own.unwrap_or(hit.normal), weights[i])
        })
    }

    /// How much the shading normal at `hit` changes over a `step` along the surface, times the
    /// step's length: zero where the surface is flat and looks it.
    pub(crate) fn normal_change(&self, hit: &Hit, step: DVec3) -> DVec3 {
        let object = self.object(hit);
        let Some(vertices) = self.vertices(hit, object) else {
            let number = hit.primitive as usize - self.surfaces.triangles().len();
            let sphere = self.surfaces.spheres().get(number);
            return sphere.map_or(DVec3::ZERO, |sphere| step / f64::from(sphere.radius));
        };
        let Some(first_normal) = object.first_normal else { return DVec3::ZERO };
        let [a, b, c] = vertices.map(|Vertex { number, position }| {
            let normal = self.normal_at(hit, first_normal + number);
            (position.as_dvec3(), normal.as_dvec3())
        });

        // The step as parts of two edges.
        let (p, q) = (b.0 - a.0, c.0 - a.0);
        let (pp, pq, qq) = (p.dot(p), p.dot(q), q.dot(q));
        let (sp, sq, area2) = (step.dot(p), step.dot(q), pp * qq - pq * pq);
        let (u, v) = ((qq * sp - pq * sq) / area2, (pp * sq - pq * sp) / area2);
        let (along_p, along_q) = (b.1 - a.1, c.1 - a.1);
        let normal = a.1 + along_p * f64::from(hit.u) + along_q * f64::from(hit.v);
        let change = along_p * u + along_q * v;

        // What of it turns the unit normal.
        let length = normal.length();
        if length == 0.0 {
            return DVec3::ZERO;
        }
        let unit = normal / length;
        let front = if unit.dot(hit.normal.as_dvec3()) < 0.0 { -1.0 } else { 1.0 };
        (change - unit * change.dot(unit)) * (front / length)
    }

    /// Texture coordinates at a hit: interpolated where the mesh has some, else barycentric weights.
    /// On a sphere its own longitude and latitude, on a disk and a rectangle from one side to the other, each
    /// from 0 to 1; on a custom shape its own.
    pub fn uv(&self, hit: &Hit) -> Vec2 {
        let own = Vec2::new(hit.u, hit.v);
        let object = self.object(hit);
        let Some(vertices) = self.vertices(hit, object) else {
            if let Some(axes) = &object.axes {
                return Sphere::uv(axes.map(|axis| axis.dot(hit.normal)).into()).into();
            }
            let disks = self.surfaces.triangles().len() + self.surfaces.spheres().len();
            let number = (hit.primitive as usize).checked_sub(disks);
            let on_a_disk = number.is_some_and(|n| n < self.surfaces.disks().len());
            return if on_a_disk { 0.5 + 0.5 * own } else { own };
        };
        let [a, b, c] = self.uvs_of(object, &vertices, 0);
        let [r, s, t] = hit.weights();
        a * r + b * s + c * t
    }

    /// The same scene as a film of this size sees it.
    pub(crate) fn on_film(self, size: [u32; 2]) -> Self {
        let eye = Eye::new(&self.camera.prepare(size), &self.camera.axis());
        Self { eye, ..self }
    }

    /// Lets `camera`, a valid one, see the scene.
    pub(super) fn look_through(&mut self, camera: Camera) {
        self.camera = camera;
        self.camera_media = self.media_at(camera.axis());
        self.report.notes.retain(|note| note.place != Some(Place::Camera));
        if !self.camera_media.absorption.is_black() {
            self.report.notes.push(Place::Camera.note(
                "it stands inside of something that absorbs light: behind the first \
                 surface in front of it, which is seen from its back",
            ));
        }
    }

    /// What the camera stands in.
    pub(crate) fn camera_media(&self) -> Media {
        self.camera_media
    }

    /// True where scattered rays may find light that light sampling cannot: beyond surfaces that
    /// are no borders, and on custom shapes.
    pub(crate) fn light_beyond_sampling(&self) -> bool {
        self.light_beyond_sampling
    }

    /// What the ray's origin is inside of, seen through everything on its way: the bodies that it
    /// leaves more often than it enters them. The first border has the last word on what absorbs.
    pub(super) fn media_at(&self, mut ray: Ray) -> Media {
        /// Behind so many surfaces nothing is looked for any more.
        const SURFACES: usize = 1000;
        let (mut media, mut first) = (Media::NONE, None);
        let mut entered = BTreeMap::<u32, u32>::new();
        // Without a priority: how often each material was entered, and what is left by its back
        // without having been entered, the innermost first. Open sheets enclose nothing; the
        // first of them tells where it stands.
        let (mut entered_declared, mut around) = (BTreeMap::<u32, u32>::new(), Vec::new());
        for _ in 0..SURFACES {
            let Some(hit) = self.closest(&ray) else { break };
            let &PreparedObject { material: number, closed, .. } = self.object(&hit);
            let material = &self.materials[number as usize];
            let from_front = hit.normal.dot(ray.direction) < 0.0;
            let across = |direction| offset_origin(hit.position, hit.normal, direction);
            let ends = [across(-ray.direction), across(ray.direction)];
            if let Some(border) = material.border {
                first = first.or(Some((border, from_front)));
                if border.rank.is_none() && closed {
                    let entered = entered_declared.entry(number).or_default();
                    match (from_front, *entered) {
                        (true, _) => *entered += 1,
                        (false, 0) => around.push(border),
                        (false, _) => *entered -= 1,
                    }
                }
            }
            // How often it is entered and left between here and there.
            let mut note = |rank: u32, from_front: bool| {
                let entered = entered.entry(rank).or_default();
                match (from_front, *entered) {
                    (true, _) => *entered += 1,
                    (false, 0) => media.pass(rank, true),
                    (false, _) => *entered -= 1,
                }
            };
            if let Some(rank) = material.rank() {
                note(rank, from_front);
                self.each_that_touches(&ray, &hit, ends, note);
            }
            ray.origin = ends[1];
        }
        for border in around.iter().rev() {
            media.arrive_declared(border, true);
            media.pass_declared(border, true);
        }
        match first {
            None => {}
            Some((Border { rank: Some(_), exterior, .. }, _)) => {
                media.fill(&exterior, self.ranked_media());
            }
            Some((border, from_front)) => media.arrive_declared(&border, from_front),
        }
        media
    }

    /// The media with a priority, the strongest first.
    pub(crate) fn ranked_media(&self) -> &[PreparedMedium] {
        &self.ranked_media
    }

    /// The ranks of all bodies with a priority whose surfaces touch the one that was hit, that is,
    /// lie between `ends` as well; and whether the ray comes from their fronts. Each object counts
    /// once from each side, for a ray may run through an edge of two triangles; the object that
    /// was hit is left out.
    pub(crate) fn each_that_touches(
        &self,
        ray: &Ray,
        hit: &Hit,
        ends: [Vec3; 2],
        mut touches: impl FnMut(u32, bool),
    ) {
        let hit_object = self.object_of(hit.instance, hit.primitive);
        // More objects than this do not touch at one place.
        let mut known = [(hit_object, None); 2 * Media::MOST];
        let mut count = 1;
        self.surfaces.at_the_same_place(ray, hit, ends, |instance, primitive, from_front| {
            let object = self.object_of(instance, primitive);
            let material = self.objects[object as usize].material;
            let Some(rank) = self.materials[material as usize].rank() else { return };
            let side = Some(from_front);
            let counted = |k: &(u32, Option<bool>)| k.0 == object && (k.1.is_none() || k.1 == side);
            if count < known.len() && !known[..count].iter().any(counted) {
                known[count] = (object, side);
                count += 1;
                touches(rank, from_front);
            }
        });
    }

    /// The material of a surface, as far as it is the same everywhere.
    pub(crate) fn material(&self, interaction: &SurfaceInteraction) -> &PreparedMaterial {
        &self.materials[interaction.material as usize]
    }

    /// A material that varies, as it is where it was hit and seen from `at`; `None` for all others.
    pub(crate) fn varied_at(
        &self,
        hit: &Hit,
        at: &SurfaceInteraction,
        material: &PreparedMaterial,
    ) -> Option<PreparedMaterial> {
        let bsdf = self.varied_bsdf(material.varying?, hit, at, material.own_coat);
        Some(PreparedMaterial { bsdf, albedo: None, dispersed: None, ..*material })
    }

    /// Whether some material bends bands of the spectrum differently.
    pub(crate) fn disperses(&self) -> bool {
        self.bands.is_some()
    }

    /// How a material that bends bands of the spectrum differently scatters the band that a path is
    /// left with, and what that is worth. If it has none yet, `u`, in [0, 1), chooses it. `room` is
    /// for the material; all others are given back as they are.
    #[inline(always)]
    pub(crate) fn in_one_band<'m>(
        &self,
        material: &'m PreparedMaterial,
        media: &mut Media,
        u: impl FnOnce() -> f32,
        room: &'m mut Option<PreparedMaterial>,
    ) -> (Spectrum, &'m PreparedMaterial) {
        match &self.bands {
            None => (Spectrum::WHITE, material),
            Some(bands) => self.in_band_of(bands, material, media, u, room),
        }
    }

    /// The same, apart, so that the common way stays short.
    #[inline(never)]
    fn in_band_of<'m>(
        &self,
        bands: &Bands,
        material: &'m PreparedMaterial,
        media: &mut Media,
        u: impl FnOnce() -> f32,
        room: &'m mut Option<PreparedMaterial>,
    ) -> (Spectrum, &'m PreparedMaterial) {
        let Some(border) = material.border.filter(Border::disperses) else {
            return (Spectrum::WHITE, material);
        };
        let (band, worth) = match media.band {
            Some(band) => (band, Spectrum::WHITE),
            None => {
                let band = bands.choose(u());
                (band, bands.get(band).worth)
            }
        };
        media.band = Some(band);
        let bsdf = match material.dispersed {
            Some(number) => self.dispersed[number as usize][band as usize],
            None => material.bsdf.with_eta(border.eta_at(bands.get(band).wavelength_nm)),
        };
        (worth, room.insert(PreparedMaterial { bsdf, albedo: None, ..*material }))
    }

    /// The albedo of a material that varies and is nothing but Lambert's; `None` for all others.
    #[inline]
    pub(crate) fn painted_lambert(&self, material: &PreparedMaterial) -> Option<&ColorInput> {
        self.varied_lambert(material.varying?)
    }

    /// Everything that shines.
    pub fn emitters(&self) -> &[Emitter] {
        &self.emitters
    }

    /// The light groups that they are of.
    #[inline(always)]
    pub(crate) fn groups(&self) -> &Groups {
        &self.groups
    }

    /// How many light groups a picture with `layers` tells.
    pub(crate) fn told_groups(&self, layers: Layers) -> usize {
        if layers.has(Layer::Groups) { self.groups.names().len() } else { 0 }
    }

    /// The tree of all emitters within the scene, which is built when it is first asked for.
    pub(crate) fn light_tree(&self) -> Option<Arc<LightTree>> {
        self.light_tree.get_or_init(|| LightTree::new(&self.emitters).map(Arc::new)).clone()
    }

    /// The sky's number among the emitters, and the sky.
    pub(crate) fn environment(&self) -> Option<(usize, &EnvironmentEmitter)> {
        let number = self.environment? as usize;
        match &self.emitters[number] {
            Emitter::Environment(sky) => Some((number, sky)),
            Emitter::Point(_)
            | Emitter::Spot(_)
            | Emitter::Distant(_)
            | Emitter::Triangle(_)
            | Emitter::Parallelogram(_)
            | Emitter::Disk(_)
            | Emitter::Sphere(_)
            | Emitter::Custom(_) => None,
        }
    }

    /// Half the diagonal of the scene's bounds, in metres; 1 for a scene without surfaces.
    pub(crate) fn radius(&self) -> f32 {
        radius_of(&self.report.bounds)
    }

    /// What caustics come from, where there can be some that light paths find.
    pub(crate) fn casting(&self) -> Option<&Casting> {
        self.casting.as_deref()
    }

    pub(super) fn object(&self, hit: &Hit) -> &PreparedObject {
        &self.objects[self.object_of(hit.instance, hit.primitive) as usize]
    }

    /// What mattes call its objects and materials.
    pub(crate) fn ids(&self) -> &Ids {
        &self.ids
    }

    /// The number of the object that a primitive, or an instance, belongs to.
    #[inline(always)]
    pub(crate) fn object_of(&self, instance: Option<u32>, primitive: u32) -> u32 {
        match instance {
            None => self.object_of_primitive[primitive as usize],
            Some(instance) => self.object_of_instance[instance as usize],
        }
    }

    /// The vertices of the triangle that was hit, in the order of their weights; `None` if it is no
    /// triangle. `object` is the one that was hit.
    pub(super) fn vertices(&self, hit: &Hit, object: &PreparedObject) -> Option<[Vertex; 3]> {
        let Some(number) = hit.instance else {
            let vertices = self.surfaces.triangles().get(hit.primitive as usize)?;
            return Some(vertices.map(|v| Vertex {
                number: v - object.first_vertex,
                position: self.surfaces.positions()[v as usize],
            }));
        };
        let instance = self.surfaces.instances().get(number as usize)?;
        let mesh = self.surfaces.mesh_of(instance);
        let [a, b, c] = (*mesh.triangles().get(hit.primitive as usize)?).map(|v| Vertex {
            number: v,
            position: instance.world_from_mesh.point(mesh.positions()[v as usize]),
        });
        Some(if instance.turned { [a, c, b] } else { [a, b, c] })
    }

    /// The vertex normal number `i`, of unit length in the world, of the object that was hit.
    pub(super) fn normal_at(&self, hit: &Hit, i: u32) -> Vec3 {
        let normal = self.normals[i as usize];
        match hit.instance {
            None => normal,
            Some(instance) => {
                let placed = &self.surfaces.instances()[instance as usize];
                placed.world_from_mesh.normal(normal).normalize_or_zero()
            }
        }
    }
}

/// Half the diagonal, in metres; 1 for a scene without surfaces.
fn radius_of(bounds: &Aabb) -> f32 {
    if bounds.is_empty() { 1.0 } else { 0.5 * bounds.extent().length() }
}
