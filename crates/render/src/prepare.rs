//! From what the author wrote to what can be traced: slow, once, and the last place that can fail.
//!
//! A [`Prepared`] scene is flat: arrays that point into each other by number.
//! Shapes become triangles, spheres and disks in the world under one tree,
//! materials become BSDFs, everything that shines becomes an emitter.

use crate::bsdf::{
    Bsdf, Fresnel, Lambert, Lobe, OrenNayar, PerfectMirror, RoughConductor, RoughDielectric,
    SmoothConductor, SmoothDielectric, ThinDielectric,
};
use crate::camera::Camera;
use crate::color::{Rgb, Spectrum};
use crate::interaction::SurfaceInteraction;
use crate::light::{
    DiskEmitter, Emitter, EnvironmentEmitter, Glow, Light, ParallelogramEmitter, SphereEmitter,
    TriangleEmitter,
};
use crate::material::{Emission, EmittedLight, Material, MaterialKind};
use crate::scene::{MaterialId, Scene, SceneProblem};
use crate::shape::{Mesh, Object, Shape};
use rutilant_geom::{
    Aabb, BuildOptions, BuildReport, DVec3, Disk, Hit, Ray, Sphere, Surfaces, Transform, Vec2,
    Vec3, offset_origin,
};
use std::f32::consts::PI;

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
    emitters: Vec<Emitter>,
    /// The emitter that is the sky.
    environment: Option<u32>,
    /// Whether there is a surface that rays pass.
    some_pass: bool,
    /// What the medium around the camera absorbs, in 1/m.
    camera_absorption: Spectrum,
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
    /// True where rays go on as if there were nothing.
    pub(crate) passes: bool,
}

/// What fills the space on both sides of a clear surface: absorption coefficients in 1/m.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Border {
    interior: Spectrum,
    exterior: Spectrum,
}

impl Border {
    /// The absorption in front of the surface, or behind it.
    pub(crate) fn absorption(&self, in_front: bool) -> Spectrum {
        if in_front { self.exterior } else { self.interior }
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

    /// Texture coordinates at a hit: interpolated where the mesh has some, else the hit's own
    /// parameters (barycentric weights for triangles).
    pub fn uv(&self, hit: &Hit) -> Vec2 {
        let object = self.object(hit);
        let Some(first_uv) = object.first_uv else { return Vec2::new(hit.u, hit.v) };
        let vertices = self.surfaces.triangles()[hit.primitive as usize];
        let [a, b, c] = vertices.map(|v| self.uvs[(v - object.first_vertex + first_uv) as usize]);
        a * (1.0 - hit.u - hit.v) + b * hit.u + c * hit.v
    }

    /// Whether there is a surface that rays pass.
    pub(crate) fn some_pass(&self) -> bool {
        self.some_pass
    }

    /// What the medium around the camera absorbs, in 1/m.
    pub(crate) fn camera_absorption(&self) -> Spectrum {
        self.camera_absorption
    }

    /// What the medium at the ray's origin absorbs: that on this side of the first border on its
    /// way, seen through everything that is none. Nothing where there is no border.
    fn absorption_at(&self, mut ray: Ray) -> Spectrum {
        /// Behind so many surfaces nothing is looked for any more.
        const SURFACES: usize = 1000;
        for _ in 0..SURFACES {
            let Some(hit) = self.closest(&ray) else { break };
            let material = &self.materials[self.object(&hit).material as usize];
            if let Some(border) = &material.border {
                return border.absorption(hit.normal.dot(ray.direction) < 0.0);
            }
            ray.origin = offset_origin(hit.position, hit.normal, ray.direction);
        }
        Spectrum::BLACK
    }

    pub(crate) fn material(&self, interaction: &SurfaceInteraction) -> &PreparedMaterial {
        &self.materials[interaction.material as usize]
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
            | Emitter::Distant(_)
            | Emitter::Triangle(_)
            | Emitter::Parallelogram(_)
            | Emitter::Disk(_)
            | Emitter::Sphere(_) => None,
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
    /// The objects of the triangles, of the spheres and of the disks, in their order.
    objects_of: [Vec<u32>; 3],
    objects: Vec<PreparedObject>,
    normals: Vec<Vec3>,
    uvs: Vec<Vec2>,
    emitters: Vec<Emitter>,
    some_pass: bool,
    notes: Vec<String>,
}

impl Assembly {
    fn finish(mut self, scene: &Scene, options: &BuildOptions) -> Prepared {
        for (number, object) in scene.objects.iter().enumerate() {
            self.add(number, object, scene);
        }
        self.emitters.extend(scene.lights.iter().map(Light::prepare));
        let environment = scene.environment.as_ref().map(|environment| {
            let (sky, mended) = EnvironmentEmitter::new(environment, &scene.images);
            if mended > 0 {
                self.notes.push(format!(
                    "environment: {mended} pixels are negative, infinite or no numbers; they give no light"
                ));
            }
            self.add_emitter(Emitter::Environment(sky))
        });

        let (triangles, spheres, disks) =
            (self.triangles.len(), self.spheres.len(), self.disks.len());
        let surfaces =
            Surfaces::new(self.positions, self.triangles, self.spheres, self.disks, options);
        let left_out = surfaces.report().left_out;
        if left_out.count > 0 {
            let (count, first) = (left_out.count, left_out.first.unwrap_or(0));
            self.notes.push(format!(
                "{count} of the surfaces are left out: without area, infinite or no numbers (the first is number {first})"
            ));
        }
        let radius = radius_of(&surfaces.bounds());
        if self.emitters.iter().all(|e| e.power(radius).is_black()) {
            self.notes.push("nothing gives light: the picture will be black".to_owned());
        }
        let report = PrepareReport {
            triangles: triangles as u64,
            spheres: spheres as u64,
            disks: disks as u64,
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
            materials: scene
                .materials
                .iter()
                .map(|m| prepare_material(m, &scene.materials))
                .collect(),
            emitters: self.emitters,
            environment,
            some_pass: self.some_pass,
            camera_absorption: Spectrum::BLACK,
            report,
        };
        prepared.camera_absorption = prepared.absorption_at(scene.camera.axis());
        prepared
    }

    fn add(&mut self, number: usize, object: &Object, scene: &Scene) {
        let material = &scene.materials[object.material.0 as usize];
        let world_from_object = &object.world_from_object;
        let mut prepared = PreparedObject {
            material: object.material.0,
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
        match object.shape {
            Shape::Mesh(id) => {
                let mesh = &scene.meshes[id.0 as usize];
                self.add_mesh(mesh, number, object, material, &mut prepared);
            }
            Shape::Box { size } => {
                self.add_mesh(&box_mesh(size), number, object, material, &mut prepared);
            }
            Shape::Rectangle { size } => {
                let corners = self.add_rectangle(size, world_from_object, number);
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
                let sphere = Sphere { center, radius: radius * scale };
                self.spheres.push(sphere);
                self.objects_of[1].push(number as u32);
                let area = 4.0 * PI * sphere.radius * sphere.radius;
                if let Some(glow) = self.glow(number, material, area) {
                    prepared.emitters = ObjectEmitters::One(
                        self.add_emitter(Emitter::Sphere(SphereEmitter { sphere, glow })),
                    );
                }
            }
            Shape::Disk { radius } => {
                let axis = |v: Vec3| world_from_object.vector(v * radius);
                // The normal keeps its side when the transform mirrors.
                let (u, v) = if world_from_object.mirrors() {
                    (axis(Vec3::Y), axis(Vec3::X))
                } else {
                    (axis(Vec3::X), axis(Vec3::Y))
                };
                let disk = Disk { center: world_from_object.translation(), u, v };
                self.disks.push(disk);
                self.objects_of[2].push(number as u32);
                let area = PI * u.cross(v).length();
                if let Some(glow) = self.glow(number, material, area) {
                    let emitter = Emitter::Disk(DiskEmitter::new(disk, glow));
                    prepared.emitters = ObjectEmitters::One(self.add_emitter(emitter));
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
        if is_border(material) && self.is_inside_out(first_triangle) {
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
        let area = area.filter(|a| a.is_finite()).map(f64::from).sum::<f64>() as f32;
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
    fn glow(&mut self, number: usize, material: &Material, area: f32) -> Option<Glow> {
        let Emission { light, two_sided } = material.emission?;
        let sides = if two_sided { 2.0 } else { 1.0 };
        let (EmittedLight::Radiance(light_rgb) | EmittedLight::Power(light_rgb)) = light;
        let radiance = match light {
            EmittedLight::Radiance(rgb) => Spectrum::from(rgb),
            EmittedLight::Power(rgb) => Spectrum::from(rgb) / (PI * area * sides),
        };
        if light_rgb == Rgb::BLACK {
            return None;
        }
        let shines = radiance.is_finite() && !radiance.is_black() && area > 0.0;
        if !shines {
            self.notes.push(format!(
                "object {number} is a lamp of {area} m², which no power can be spread over: it gives no light"
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

    /// True when the triangles from `first` on enclose a space and face into it. An open sheet,
    /// a water surface for example, encloses nothing: its areas do not cancel.
    fn is_inside_out(&self, first: usize) -> bool {
        let origin =
            self.triangles.get(first).map_or(Vec3::ZERO, |t| self.positions[t[0] as usize]);
        let (mut volume, mut area, mut area_sum) = (0.0, DVec3::ZERO, 0.0);
        for t in &self.triangles[first..] {
            let [a, b, c] = t.map(|v| (self.positions[v as usize] - origin).as_dvec3());
            let cross = (b - a).cross(c - a);
            if cross.is_finite() {
                volume += a.dot(cross);
                area += cross;
                area_sum += cross.length();
            }
        }
        volume < 0.0 && area.length() < 0.1 * area_sum
    }
}

/// Half the diagonal, in metres; 1 for a scene without surfaces.
fn radius_of(bounds: &Aabb) -> f32 {
    if bounds.is_empty() { 1.0 } else { 0.5 * bounds.extent().length() }
}

fn triangle_area([a, b, c]: [Vec3; 3]) -> f32 {
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

fn is_border(material: &Material) -> bool {
    matches!(material.kind, MaterialKind::Dielectric(_))
}

/// True where rays go on as if there were no surface.
fn passes(material: &Material) -> bool {
    matches!(material.kind, MaterialKind::Null)
}

fn prepare_material(material: &Material, all: &[Material]) -> PreparedMaterial {
    let bsdf = match &material.kind {
        MaterialKind::Mix(mix) => {
            let part = |id: MaterialId, share: f32| lobe(&all[id.0 as usize]).map(|l| (share, l));
            let parts = [part(mix.first, 1.0 - mix.amount), part(mix.second, mix.amount)];
            Bsdf::sum(parts.into_iter().flatten())
        }
        MaterialKind::Black
        | MaterialKind::Null
        | MaterialKind::Matte(_)
        | MaterialKind::Mirror(_)
        | MaterialKind::Conductor(_)
        | MaterialKind::Dielectric(_)
        | MaterialKind::ThinDielectric(_) => lobe(material).map_or(Bsdf::BLACK, Bsdf::from),
    };
    let border = match &material.kind {
        MaterialKind::Dielectric(d) => Some(Border {
            interior: d.interior.absorption.coefficient(),
            exterior: d.exterior.absorption.coefficient(),
        }),
        MaterialKind::Black
        | MaterialKind::Null
        | MaterialKind::Matte(_)
        | MaterialKind::Mirror(_)
        | MaterialKind::Conductor(_)
        | MaterialKind::ThinDielectric(_)
        | MaterialKind::Mix(_) => None,
    };
    PreparedMaterial { bsdf, border, passes: passes(material) }
}

/// The lobe of a material that has just one.
fn lobe(material: &Material) -> Option<Lobe> {
    match material.kind {
        MaterialKind::Black | MaterialKind::Mix(_) => None,
        // What passes unscattered crosses a border between equal media.
        MaterialKind::Null => {
            Some(Lobe::Dielectric(SmoothDielectric { eta: 1.0, fresnel: Fresnel::Exact }))
        }
        MaterialKind::Matte(m) if m.roughness == 0.0 => {
            Some(Lobe::Lambert(Lambert { albedo: m.albedo.into() }))
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
