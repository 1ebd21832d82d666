//! From what the author wrote to what can be traced: slow, once, and the last place that can fail.
//!
//! A [`Prepared`] scene is flat: arrays that point into each other by number.
//! Shapes become triangles, spheres, disks and custom surfaces in the world under one tree,
//! materials become BSDFs, everything that shines becomes an emitter.

use crate::bsdf::{
    Bsdf, Fresnel, Lambert, Lobe, OrenNayar, PerfectMirror, RoughConductor, RoughDielectric,
    SmoothConductor, SmoothDielectric, ThinDielectric, UniformLambert,
};
use crate::camera::Camera;
use crate::color::{Rgb, Spectrum};
use crate::interaction::SurfaceInteraction;
use crate::light::{
    DiskEmitter, Emitter, EnvironmentEmitter, Glow, Light, ParallelogramEmitter, SphereEmitter,
    TriangleEmitter,
};
use crate::material::{
    CustomMaterial, Dielectric, Emission, EmittedLight, HemisphereSampling, Material, MaterialKind,
    SurfacePoint,
};
use crate::medium::{Border, Media, PreparedMedium};
use crate::scene::{MaterialId, Scene, SceneProblem};
use crate::shape::{Mesh, Object, Shape};
use crate::winding::{Enclosure, enclosures};
use rutilant_geom::{
    Aabb, BuildOptions, BuildReport, Custom, DVec3, Disk, Hit, Ray, Sphere, Surfaces, Transform,
    Vec2, Vec3, offset_origin,
};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::sync::Arc;

/// A scene that rays can be traced through. It does not change any more.
#[derive(Clone, Debug)]
pub struct Prepared {
    pub(crate) camera: Camera,
    surfaces: Surfaces,
    /// The object of each primitive.
    object_of_primitive: Vec<u32>,
    objects: Vec<PreparedObject>,
    normals: Vec<Vec3>,
    uvs: Vec<Vec2>,
    materials: Vec<PreparedMaterial>,
    custom_materials: Vec<Arc<dyn CustomMaterial>>,
    /// Those with a priority, the strongest first.
    ranked_media: Vec<PreparedMedium>,
    emitters: Vec<Emitter>,
    /// The emitter that is the sky.
    environment: Option<u32>,
    /// What the camera stands in.
    camera_media: Media,
    /// True where scattered rays may find light that light sampling cannot.
    light_beyond_sampling: bool,
    /// Whether there is a surface that rays pass.
    some_pass: bool,
    report: PrepareReport,
}

/// What came of a scene.
#[derive(Clone, Debug)]
pub struct PrepareReport {
    /// Triangles that stand in the world.
    pub triangles: u64,
    /// Spheres.
    pub spheres: u64,
    /// Disks.
    pub disks: u64,
    /// Custom shapes.
    pub customs: u64,
    /// Materials.
    pub materials: u64,
    /// Emitters: lights, glowing triangles and shapes, the sky.
    pub emitters: u64,
    /// The smallest box around everything.
    pub bounds: Aabb,
    /// The tree.
    pub bvh: BuildReport,
    /// What was mended on the way, in words for the author.
    pub notes: Vec<String>,
}

/// An object in the world.
#[derive(Clone, Debug)]
struct PreparedObject {
    material: u32,
    /// It encloses a space by itself.
    closed: bool,
    emitters: ObjectEmitters,
    first_primitive: u32,
    first_vertex: u32,
    /// Where its vertex normals start in the common array, if it has some.
    first_normal: Option<u32>,
    /// Where its texture coordinates start in the common array, if it has some.
    first_uv: Option<u32>,
}

/// Which emitters an object is.
#[derive(Clone, Copy, Debug)]
enum ObjectEmitters {
    None,
    /// The object as a whole.
    One(u32),
    /// Each primitive its own, from this number on.
    Each(u32),
}

/// A material as it meets light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PreparedMaterial {
    pub(crate) bsdf: Bsdf,
    /// Set where light can cross the surface.
    pub(crate) border: Option<Border>,
    /// The number of the custom material that tells the BSDF of each place.
    custom: Option<u32>,
    /// True where rays go on as if there were nothing.
    pub(crate) passes: bool,
}

impl From<Bsdf> for PreparedMaterial {
    /// A surface that light does not cross.
    fn from(bsdf: Bsdf) -> Self {
        Self { bsdf, border: None, custom: None, passes: false }
    }
}

impl PreparedMaterial {
    /// The number of its medium among those with a priority.
    fn rank(&self) -> Option<u32> {
        self.border.and_then(|b| b.rank)
    }

    /// True where more than the material decides what the surface does to light.
    pub(crate) fn depends_on_place(&self) -> bool {
        self.custom.is_some() || self.passes || self.rank().is_some()
    }

    /// The same as a border between the media that it lies between at some place.
    pub(crate) fn between(&self, here: Border) -> Self {
        let eta = here.interior.ior / here.exterior.ior;
        Self { bsdf: self.bsdf.with_eta(eta), border: Some(here), ..*self }
    }
}

impl Prepared {
    /// Makes a scene traceable.
    ///
    /// # Errors
    /// What [`Scene::validate`] finds. Broken triangles are no error: they are left out, counted
    /// and reported.
    pub fn new(scene: &Scene) -> Result<Self, SceneProblem> {
        Self::with_options(scene, &BuildOptions::default())
    }

    /// The same with a say in how the tree is built.
    ///
    /// # Errors
    /// As for [`new`](Self::new).
    pub fn with_options(scene: &Scene, options: &BuildOptions) -> Result<Self, SceneProblem> {
        scene.validate()?;
        Ok(Assembly::default().finish(scene, options))
    }

    /// What came of the scene.
    pub fn report(&self) -> &PrepareReport {
        &self.report
    }

    /// The surface that a ray meets first.
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        self.surfaces.closest(ray)
    }

    /// Whether anything is in a ray's way that rays do not pass.
    #[inline]
    pub fn occluded(&self, ray: &Ray) -> bool {
        if self.some_pass { self.occluded_behind_flames(ray) } else { self.surfaces.occluded(ray) }
    }

    fn occluded_behind_flames(&self, ray: &Ray) -> bool {
        let mut ahead = *ray;
        while let Some(hit) = self.closest(&ahead) {
            if !self.materials[self.object(&hit).material as usize].passes {
                return true;
            }
            ahead.t_min = hit.t.next_up();
        }
        false
    }

    /// What a ray that came along the unit vector `direction` finds at `hit`.
    pub fn interaction(&self, hit: &Hit, direction: Vec3) -> SurfaceInteraction {
        let object = self.object(hit);
        let emitter = match object.emitters {
            ObjectEmitters::None => None,
            ObjectEmitters::One(emitter) => Some(emitter),
            ObjectEmitters::Each(first) => Some(first + (hit.primitive - object.first_primitive)),
        };
        let flat =
            SurfaceInteraction::new(hit.position, hit.normal, -direction, object.material, emitter);
        let Some(first_normal) = object.first_normal else { return flat };
        let vertices = self.surfaces.triangles()[hit.primitive as usize];
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        let corners = std::array::from_fn(|i| {
            let normal = self.normals[(vertices[i] - object.first_vertex + first_normal) as usize];
            (self.surfaces.positions()[vertices[i] as usize], normal, weights[i])
        });
        let normal = corners.iter().fold(Vec3::ZERO, |sum, (_, n, w)| sum + *n * *w);
        flat.smoothed(normal, corners)
    }

    /// How much the shading normal at `hit` changes over a `step` along the surface, times the
    /// step's length: zero where the surface is flat and looks it.
    pub(crate) fn normal_change(&self, hit: &Hit, step: DVec3) -> DVec3 {
        let triangles = self.surfaces.triangles();
        let Some(vertices) = triangles.get(hit.primitive as usize) else {
            let sphere = self.surfaces.spheres().get(hit.primitive as usize - triangles.len());
            return sphere.map_or(DVec3::ZERO, |sphere| step / f64::from(sphere.radius));
        };
        let object = self.object(hit);
        let Some(first_normal) = object.first_normal else { return DVec3::ZERO };
        let [a, b, c] = vertices.map(|v| {
            let normal = self.normals[(v - object.first_vertex + first_normal) as usize];
            (self.surfaces.positions()[v as usize].as_dvec3(), normal.as_dvec3())
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

    /// Texture coordinates at a hit: interpolated where the mesh has some, else the hit's own
    /// parameters (barycentric weights for triangles).
    pub fn uv(&self, hit: &Hit) -> Vec2 {
        let object = self.object(hit);
        let Some(first_uv) = object.first_uv else { return Vec2::new(hit.u, hit.v) };
        let vertices = self.surfaces.triangles()[hit.primitive as usize];
        let [a, b, c] = vertices.map(|v| self.uvs[(v - object.first_vertex + first_uv) as usize]);
        a * (1.0 - hit.u - hit.v) + b * hit.u + c * hit.v
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
    fn media_at(&self, mut ray: Ray) -> Media {
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
        let object_of = |primitive: u32| self.object_of_primitive[primitive as usize];
        // More objects than this do not touch at one place.
        let mut known = [(object_of(hit.primitive), None); 2 * Media::MOST];
        let mut count = 1;
        self.surfaces.at_the_same_place(ray, hit, ends, |primitive, from_front| {
            let object = object_of(primitive);
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

    /// A custom material as it is where it was hit; `None` for all others.
    pub(crate) fn custom_at(
        &self,
        hit: &Hit,
        material: &PreparedMaterial,
    ) -> Option<PreparedMaterial> {
        let custom = &self.custom_materials[material.custom? as usize];
        let point = SurfacePoint { position: hit.position, normal: hit.normal, uv: self.uv(hit) };
        Some(PreparedMaterial { bsdf: custom.bsdf(&point), ..*material })
    }

    /// Everything that shines.
    pub fn emitters(&self) -> &[Emitter] {
        &self.emitters
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

    fn object(&self, hit: &Hit) -> &PreparedObject {
        &self.objects[self.object_of_primitive[hit.primitive as usize] as usize]
    }
}

/// A scene on its way to being prepared.
#[derive(Default)]
struct Assembly {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    spheres: Vec<Sphere>,
    disks: Vec<Disk>,
    customs: Vec<Custom>,
    /// The objects of the triangles, the spheres, the disks and the custom shapes, in their order.
    objects_of: [Vec<u32>; 4],
    objects: Vec<PreparedObject>,
    normals: Vec<Vec3>,
    uvs: Vec<Vec2>,
    emitters: Vec<Emitter>,
    some_pass: bool,
    /// What each object encloses.
    enclosures: Vec<Enclosure>,
    notes: Vec<String>,
}

impl Assembly {
    fn finish(mut self, scene: &Scene, options: &BuildOptions) -> Prepared {
        self.enclosures = enclosures(scene);
        for (number, object) in scene.objects.iter().enumerate() {
            self.add(number, object, scene);
        }
        self.emitters.extend(scene.lights.iter().map(Light::prepare));
        let environment = scene.environment.as_ref().map(|environment| {
            let (sky, mended) = EnvironmentEmitter::new(environment, &scene.images);
            if mended > 0 {
                self.notes.push(format!(
                    "environment: {mended} of its pixels, negative, infinite or no numbers, give no light"
                ));
            }
            self.add_emitter(Emitter::Environment(sky))
        });

        let (triangles, spheres, disks, customs) =
            (self.triangles.len(), self.spheres.len(), self.disks.len(), self.customs.len());
        let surfaces = Surfaces::with_custom(
            self.positions,
            self.triangles,
            self.spheres,
            self.disks,
            self.customs,
            options,
        );
        let left_out = surfaces.report().left_out;
        if left_out.count > 0 {
            let (count, first) = (left_out.count, left_out.first.unwrap_or(0));
            let are = if count == 1 { "is" } else { "are" };
            self.notes.push(format!(
                "{count} of the surfaces {are} left out: without area, infinite or no numbers (the first is number {first})"
            ));
        }
        // Whether light from infinitely far away is none does not depend on the scene's size.
        let dark = |e: &Emitter| !e.is_custom() && e.power(1.0).is_black();
        if self.emitters.iter().all(dark) {
            self.notes.push("nothing gives light: the picture will be black".to_owned());
        }
        let (materials, custom_materials) = prepare_materials(&scene.materials);
        let mut ranked: Vec<Border> = materials.iter().filter_map(|m| m.border).collect();
        ranked.retain(|b| b.rank.is_some());
        ranked.sort_unstable_by_key(|b| b.rank);
        let ranked_media: Vec<_> = ranked.into_iter().map(|b| b.interior).collect();
        if ranked_media.len() > Media::MOST {
            self.notes.push(format!(
                "{} materials have a priority; where more than {} overlap, the weakest are overlooked",
                ranked_media.len(),
                Media::MOST
            ));
        }
        let report = PrepareReport {
            triangles: triangles as u64,
            spheres: spheres as u64,
            disks: disks as u64,
            customs: customs as u64,
            materials: scene.materials.len() as u64,
            emitters: self.emitters.len() as u64,
            bounds: surfaces.bounds(),
            bvh: *surfaces.report(),
            notes: self.notes,
        };
        let mut prepared = Prepared {
            camera: scene.camera,
            surfaces,
            object_of_primitive: self.objects_of.concat(),
            objects: self.objects,
            normals: self.normals,
            uvs: self.uvs,
            materials,
            custom_materials,
            light_beyond_sampling: !ranked_media.is_empty()
                || self.emitters.iter().any(Emitter::is_custom),
            ranked_media,
            emitters: self.emitters,
            environment,
            camera_media: Media::NONE,
            some_pass: self.some_pass,
            report,
        };
        prepared.camera_media = prepared.media_at(scene.camera.axis());
        if !prepared.camera_media.absorption.is_black() {
            prepared.report.notes.push(
                "the camera stands inside of something that absorbs light: behind the first \
                 surface in front of it, which is seen from its back"
                    .to_owned(),
            );
        }
        prepared
    }

    fn add(&mut self, number: usize, object: &Object, scene: &Scene) {
        let material = &scene.materials[object.material.0 as usize];
        let world_from_object = &object.world_from_object;
        let mut prepared = PreparedObject {
            material: object.material.0,
            closed: self.enclosures[number].closed,
            emitters: ObjectEmitters::None,
            first_primitive: self.triangles.len() as u32,
            first_vertex: self.positions.len() as u32,
            first_normal: None,
            first_uv: None,
        };
        // What neither scatters nor glows is left out.
        if passes(material) && !material.gives_light() {
            self.objects.push(prepared);
            return;
        }
        self.some_pass |= passes(material);
        match &object.shape {
            Shape::Mesh(id) => {
                let mesh = &scene.meshes[id.0 as usize];
                self.add_mesh(mesh, number, object, material, &mut prepared);
            }
            Shape::Box { size } => {
                self.add_mesh(&box_mesh(*size), number, object, material, &mut prepared);
            }
            Shape::Rectangle { size } => {
                let corners = self.add_rectangle(*size, world_from_object, number);
                let area = 2.0 * triangle_area(corners);
                if let Some(glow) = self.glow(number, material, area) {
                    let emitter = ParallelogramEmitter::new(corners, glow);
                    prepared.emitters =
                        ObjectEmitters::One(self.add_emitter(Emitter::Parallelogram(emitter)));
                }
            }
            Shape::Sphere { radius } => {
                let scale = world_from_object.uniform_scale().unwrap_or(1.0);
                let center = world_from_object.translation();
                let sphere = Sphere { center, radius: *radius * scale };
                self.spheres.push(sphere);
                self.objects_of[1].push(number as u32);
                let radius = f64::from(sphere.radius);
                let area = 4.0 * PI * radius * radius;
                if let Some(glow) = self.glow(number, material, area) {
                    prepared.emitters = ObjectEmitters::One(
                        self.add_emitter(Emitter::Sphere(SphereEmitter { sphere, glow })),
                    );
                }
            }
            Shape::Disk { radius } => {
                let axis = |v: Vec3| world_from_object.vector(v * *radius);
                // The normal keeps its side when the transform mirrors.
                let (u, v) = if world_from_object.mirrors() {
                    (axis(Vec3::Y), axis(Vec3::X))
                } else {
                    (axis(Vec3::X), axis(Vec3::Y))
                };
                let disk = Disk { center: world_from_object.translation(), u, v };
                self.disks.push(disk);
                self.objects_of[2].push(number as u32);
                let area = PI * u.as_dvec3().cross(v.as_dvec3()).length();
                if let Some(glow) = self.glow(number, material, area) {
                    let emitter = Emitter::Disk(DiskEmitter::new(disk, glow));
                    prepared.emitters = ObjectEmitters::One(self.add_emitter(emitter));
                }
            }
            Shape::Custom(shape) => {
                self.customs.push(Custom::new(Arc::clone(shape), world_from_object));
                self.objects_of[3].push(number as u32);
                // The area is of no account: only a radiance is accepted.
                if let Some(glow) = self.glow(number, material, 1.0) {
                    let emitter = self.add_emitter(Emitter::Custom(glow));
                    prepared.emitters = ObjectEmitters::One(emitter);
                }
            }
        }
        self.objects.push(prepared);
    }

    fn add_mesh(
        &mut self,
        mesh: &Mesh,
        number: usize,
        object: &Object,
        material: &Material,
        prepared: &mut PreparedObject,
    ) {
        let transform = &object.world_from_object;
        let first = prepared.first_vertex;
        let first_triangle = self.triangles.len();
        self.positions.extend(mesh.positions.iter().map(|&p| transform.point(p)));
        self.triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| v + first)));
        self.objects_of[0].resize(self.triangles.len(), number as u32);

        // The winding says what is outside. A mirrored mesh is turned back, and so is glass that
        // is wound inside out.
        if transform.mirrors() {
            self.turn(first_triangle);
        }
        if self.enclosures[number].inside_out {
            self.turn(first_triangle);
            let name = if mesh.name.is_empty() { "a mesh" } else { &mesh.name };
            self.notes.push(format!(
                "{name} is wound inside out; its triangles are turned, so that glass is inside"
            ));
        }

        if !mesh.normals.is_empty() {
            prepared.first_normal = Some(self.normals.len() as u32);
            let normals = mesh.normals.iter();
            self.normals.extend(normals.map(|&n| transform.normal(n).normalize_or_zero()));
        }
        if !mesh.uvs.is_empty() {
            prepared.first_uv = Some(self.uvs.len() as u32);
            self.uvs.extend_from_slice(&mesh.uvs);
        }
        self.add_triangle_emitters(first_triangle, number, material, prepared);
    }

    /// Makes the triangles from `first` on shine, if the material does.
    fn add_triangle_emitters(
        &mut self,
        first: usize,
        number: usize,
        material: &Material,
        prepared: &mut PreparedObject,
    ) {
        let corners = |t: &[u32; 3]| t.map(|v| self.positions[v as usize]);
        let area = self.triangles[first..].iter().map(|t| triangle_area(corners(t)));
        // Triangles that are no numbers give no light.
        let area = area.filter(|a| a.is_finite()).sum();
        let Some(glow) = self.glow(number, material, area) else { return };
        let corners = |t: &[u32; 3]| t.map(|v| self.positions[v as usize]);
        let emitters = self.triangles[first..]
            .iter()
            .map(|t| Emitter::Triangle(TriangleEmitter::new(corners(t), glow)));
        let emitters: Vec<Emitter> = emitters.collect();
        prepared.emitters = ObjectEmitters::Each(self.emitters.len() as u32);
        self.emitters.extend(emitters);
    }

    /// Adds two triangles; returns the corner and its two neighbours.
    fn add_rectangle(&mut self, size: Vec2, transform: &Transform, number: usize) -> [Vec3; 3] {
        let (x, y) = (0.5 * size.x, 0.5 * size.y);
        let mut corners = [(-x, -y), (x, -y), (x, y), (-x, y)]
            .map(|(x, y)| transform.point(Vec3::new(x, y, 0.0)));
        if transform.mirrors() {
            corners.swap(1, 3);
        }
        let first = self.positions.len() as u32;
        self.positions.extend(corners);
        self.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t: [u32; 3]| t.map(|v| v + first)));
        self.objects_of[0].resize(self.triangles.len(), number as u32);
        [corners[0], corners[1], corners[3]]
    }

    /// The light of object `number`, of `area` m², with this material.
    fn glow(&mut self, number: usize, material: &Material, area: f64) -> Option<Glow> {
        let Emission { light, two_sided } = material.emission?;
        let sides = if two_sided { 2.0 } else { 1.0 };
        let (light_rgb, radiance) = match light {
            EmittedLight::Radiance(rgb) => (rgb, Spectrum::from(rgb)),
            EmittedLight::Power(rgb) => {
                let per_radiance = PI * area * sides;
                (rgb, Spectrum::from(rgb).map(|power| (f64::from(power) / per_radiance) as f32))
            }
        };
        if light_rgb == Rgb::BLACK {
            return None;
        }
        // Emitters keep their areas in single precision.
        let measurable = area as f32 > 0.0 && (area as f32).is_finite();
        let shines = measurable && radiance.is_finite() && !radiance.is_black();
        if !shines {
            let why = if measurable {
                "its power cannot be spread over it"
            } else {
                "that is too little or too much to measure"
            };
            self.notes.push(format!(
                "object {number} is a lamp of {area:.3e} m² and gives no light: {why}"
            ));
        }
        shines.then_some(Glow { radiance, two_sided })
    }

    fn add_emitter(&mut self, emitter: Emitter) -> u32 {
        self.emitters.push(emitter);
        (self.emitters.len() - 1) as u32
    }

    /// Turns the triangles from `first` on: their backs become their fronts.
    fn turn(&mut self, first: usize) {
        self.triangles[first..].iter_mut().for_each(|t| t.swap(1, 2));
    }
}

/// Half the diagonal, in metres; 1 for a scene without surfaces.
fn radius_of(bounds: &Aabb) -> f32 {
    if bounds.is_empty() { 1.0 } else { 0.5 * bounds.extent().length() }
}

/// In m².
fn triangle_area(corners: [Vec3; 3]) -> f64 {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    0.5 * (b - a).cross(c - a).length()
}

/// A box around the origin with outward normals, its corners shared so that no ray slips through.
fn box_mesh(size: Vec3) -> Mesh {
    let half = 0.5 * size;
    let positions = (0..8)
        .map(|i| {
            half * Vec3::from([0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 1.0 } else { -1.0 }))
        })
        .collect();
    let faces =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = faces.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh { name: "box".into(), positions, triangles, ..Mesh::default() }
}

/// True where rays go on as if there were no surface.
fn passes(material: &Material) -> bool {
    matches!(material.kind, MaterialKind::Null)
}

/// All materials as they meet light, and the custom ones among them.
fn prepare_materials(all: &[Material]) -> (Vec<PreparedMaterial>, Vec<Arc<dyn CustomMaterial>>) {
    // The strongest first; of equally strong ones the first.
    let priority = |m: &Material| match &m.kind {
        MaterialKind::Dielectric(Dielectric { priority, .. }) => *priority,
        MaterialKind::Black
        | MaterialKind::Matte(_)
        | MaterialKind::Mirror(_)
        | MaterialKind::Conductor(_)
        | MaterialKind::ThinDielectric(_)
        | MaterialKind::Null
        | MaterialKind::Mix(_)
        | MaterialKind::Custom(_) => None,
    };
    let mut ranked: Vec<(u32, usize)> = all
        .iter()
        .enumerate()
        .filter_map(|(i, m)| priority(m).map(|p| (u32::MAX - p, i)))
        .collect();
    ranked.sort_unstable();
    let ranks: BTreeMap<usize, u32> =
        ranked.iter().zip(0..).map(|((_, i), rank)| (*i, rank)).collect();

    let mut customs = Vec::new();
    let prepare = |(i, material): (usize, &Material)| {
        let mut prepared = PreparedMaterial::from(lobe(material).map_or(Bsdf::BLACK, Bsdf::from));
        match &material.kind {
            MaterialKind::Black
            | MaterialKind::Matte(_)
            | MaterialKind::Mirror(_)
            | MaterialKind::Conductor(_)
            | MaterialKind::ThinDielectric(_) => {}
            MaterialKind::Null => prepared.passes = true,
            MaterialKind::Dielectric(d) => {
                let medium = |m: &crate::material::Medium| PreparedMedium {
                    ior: m.ior,
                    absorption: m.absorption.coefficient(),
                };
                let (interior, exterior) = (medium(&d.interior), medium(&d.exterior));
                let rank = ranks.get(&i).copied();
                prepared.border = Some(Border { interior, exterior, material: i as u32, rank });
            }
            MaterialKind::Mix(mix) => {
                let part =
                    |id: MaterialId, share: f32| lobe(&all[id.0 as usize]).map(|l| (share, l));
                let parts = [part(mix.first, 1.0 - mix.amount), part(mix.second, mix.amount)];
                prepared.bsdf = Bsdf::sum(parts.into_iter().flatten());
            }
            MaterialKind::Custom(custom) => {
                prepared.custom = Some(customs.len() as u32);
                customs.push(Arc::clone(custom));
            }
        }
        prepared
    };
    let materials = all.iter().enumerate().map(prepare).collect();
    (materials, customs)
}

/// The lobe of a material that has just one.
fn lobe(material: &Material) -> Option<Lobe> {
    match &material.kind {
        MaterialKind::Black | MaterialKind::Mix(_) | MaterialKind::Custom(_) => None,
        // What passes unscattered crosses a border between equal media.
        MaterialKind::Null => {
            Some(Lobe::Dielectric(SmoothDielectric { eta: 1.0, fresnel: Fresnel::Exact }))
        }
        MaterialKind::Matte(m) if m.roughness == 0.0 => {
            let albedo = m.albedo.into();
            Some(match m.sampling {
                HemisphereSampling::Cosine => Lobe::Lambert(Lambert { albedo }),
                HemisphereSampling::Uniform => Lobe::UniformLambert(UniformLambert { albedo }),
            })
        }
        MaterialKind::Matte(m) => {
            Some(Lobe::OrenNayar(OrenNayar::new(m.albedo.into(), m.roughness)))
        }
        MaterialKind::Mirror(m) => {
            Some(Lobe::Mirror(PerfectMirror { reflectance: m.reflectance.into() }))
        }
        MaterialKind::Conductor(m) => {
            let (eta, k) = (m.eta.into(), m.k.into());
            let rough = RoughConductor::new(eta, k, m.roughness).map(Lobe::RoughConductor);
            Some(rough.unwrap_or(Lobe::Conductor(SmoothConductor { eta, k })))
        }
        MaterialKind::Dielectric(m) => {
            let eta = m.interior.ior / m.exterior.ior;
            let rough = RoughDielectric::new(eta, m.roughness).map(Lobe::RoughDielectric);
            let fresnel = m.fresnel;
            Some(rough.unwrap_or(Lobe::Dielectric(SmoothDielectric { eta, fresnel })))
        }
        MaterialKind::ThinDielectric(m) => {
            Some(Lobe::ThinDielectric(ThinDielectric::new(m.ior, m.color.into())))
        }
    }
}
