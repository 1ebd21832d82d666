//! A scene is put together: shapes become surfaces in the world, and what shines emitters.

use super::lacking;
use super::material::{disperse, passes, prepare_materials};
use super::prepared::{ObjectEmitters, PrepareReport, Prepared, PreparedObject};
use super::texture::{Eye, PreparedTextures};
use crate::color::{Rgb, Spectrum};
use crate::cryptomatte::Ids;
use crate::groups::Groups;
use crate::light::{
    DiskEmitter, Emitter, EnvironmentEmitter, Glow, Light, LightGroup, ParallelogramEmitter,
    SphereEmitter, TriangleEmitter,
};
use crate::material::{Emission, EmittedLight, Material};
use crate::medium::{Border, Media};
use crate::problem::{LIGHT, Note, Place};
use crate::scene::Scene;
use crate::shape::{Mesh, Object, Shape};
use crate::sharing;
use crate::winding::{Enclosure, enclosures};
use rutilant_geom::{
    BuildOptions, Contents, Custom, Disk, Instance, SharedMesh, Sphere, Surfaces, Transform, Vec2,
    Vec3,
};
use std::collections::HashMap;
use std::f64::consts::PI;
use std::sync::Arc;

/// A scene on its way to being prepared.
#[derive(Default)]
pub(super) struct Assembly {
    /// How trees are built.
    options: BuildOptions,
    /// Meshes that are stored once already.
    known: Vec<Arc<SharedMesh>>,
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    spheres: Vec<Sphere>,
    disks: Vec<Disk>,
    customs: Vec<Custom>,
    /// The objects of the triangles, the spheres, the disks and the custom shapes, in their order.
    objects_of: [Vec<u32>; 4],
    /// Which objects are instances.
    are_instances: Vec<bool>,
    meshes: Vec<Arc<SharedMesh>>,
    /// What is stored of the meshes that are stored once, by the number of each in the scene.
    stored: HashMap<u32, Stored>,
    instances: Vec<Instance>,
    objects_of_instances: Vec<u32>,
    objects: Vec<PreparedObject>,
    normals: Vec<Vec3>,
    uvs: Vec<Vec2>,
    colors: Vec<[f32; 4]>,
    tangents: Vec<[f32; 4]>,
    emitters: Vec<Emitter>,
    /// The group of each.
    groups: Vec<Option<LightGroup>>,
    some_pass: bool,
    /// Whether the object that is being added is there from its front alone.
    one_sided: bool,
    /// What each object encloses.
    enclosures: Vec<Enclosure>,
    notes: Vec<Note>,
}

/// A mesh that is stored once.
#[derive(Clone, Copy)]
struct Stored {
    number: u32,
    first_normal: Option<u32>,
    painting: Painting,
}

/// What textures need of a mesh: where it stands in the common arrays.
#[derive(Clone, Copy, Default)]
struct Painting {
    vertices: u32,
    first_uv: Option<u32>,
    uv_sets: u32,
    first_color: Option<u32>,
    first_tangent: Option<u32>,
}

impl Painting {
    fn give(self, object: &mut PreparedObject) {
        let Self { vertices, first_uv, uv_sets, first_color, first_tangent } = self;
        (object.vertices, object.first_uv) = (vertices, first_uv);
        (object.uv_sets, object.first_color) = (uv_sets, first_color);
        object.first_tangent = first_tangent;
    }
}

impl Assembly {
    /// Puts everything together; takes over of the scene `before` its tree, and what follows from
    /// that alone, where it fits.
    pub(super) fn finish(
        mut self,
        scene: &Scene,
        options: &BuildOptions,
        before: Option<&Prepared>,
    ) -> Prepared {
        self.options = *options;
        self.known = before.map_or(Vec::new(), |before| before.surfaces.meshes().to_vec());
        self.enclosures = enclosures(scene);
        self.are_instances = sharing::instances(scene, options.copies);
        for (number, object) in scene.objects.iter().enumerate() {
            self.add(number, object, scene);
            let emission = scene.materials[object.material.0 as usize].emission;
            let group = object.group.or_else(|| emission.and_then(|emission| emission.group));
            self.groups.resize(self.emitters.len(), group);
        }
        self.emitters.extend(scene.lights.iter().map(Light::prepare));
        self.groups.extend(scene.lights.iter().map(Light::group));
        let environment = scene.environment.as_ref().map(|environment| {
            let (sky, mended) = EnvironmentEmitter::new(environment, &scene.images);
            if mended > 0 {
                self.notes.push(Place::Environment.note(format!(
                    "{mended} of its pixels, negative, infinite or no numbers, give no light"
                )));
            }
            self.groups.push(environment.group);
            self.add_emitter(Emitter::Environment(sky))
        });

        let (spheres, disks, customs) = (self.spheres.len(), self.disks.len(), self.customs.len());
        let stored =
            self.triangles.len() + self.meshes.iter().map(|m| m.triangles().len()).sum::<usize>();
        let of = |i: &Instance| self.meshes[i.mesh as usize].triangles().len() as u64;
        let triangles = self.triangles.len() as u64 + self.instances.iter().map(of).sum::<u64>();
        let (meshes, instances) = (self.meshes.len(), self.instances.len());
        let contents = Contents {
            positions: std::mem::take(&mut self.positions),
            triangles: std::mem::take(&mut self.triangles),
            spheres: std::mem::take(&mut self.spheres),
            disks: std::mem::take(&mut self.disks),
            customs: std::mem::take(&mut self.customs),
            meshes: std::mem::take(&mut self.meshes),
            instances: std::mem::take(&mut self.instances),
        };
        let object_of_primitive: Arc<[u32]> = self.objects_of.concat().into();
        let object_of_instance: Arc<[u32]> = std::mem::take(&mut self.objects_of_instances).into();
        let (surfaces, extents) =
            if let Some(before) = before.filter(|before| before.surfaces.are_of(&contents)) {
                let same_objects = before.object_of_primitive == object_of_primitive
                    && before.object_of_instance == object_of_instance
                    && before.objects.len() == self.objects.len();
                let extents = same_objects.then(|| Arc::clone(&before.extents));
                (Arc::clone(&before.surfaces), extents.unwrap_or_default())
            } else {
                let built = Surfaces::of(contents, options);
                let surfaces = match before {
                    Some(before) => built.at_level_of(&before.surfaces),
                    None => built,
                };
                (Arc::new(surfaces), Arc::default())
            };
        let left_out = surfaces.report().left_out;
        if left_out.count > 0 {
            let (count, first) = (left_out.count, left_out.first.unwrap_or(0));
            let are = if count == 1 { "is" } else { "are" };
            self.notes.push(format!(
                "{count} of the surfaces {are} left out: without area, infinite or no numbers (the first is number {first})"
            ).into());
        }
        // Whether light from infinitely far away is none does not depend on the scene's size.
        let dark = |e: &Emitter| !e.is_custom() && e.power(1.0).is_black();
        if self.emitters.iter().all(dark) {
            self.notes.push("nothing gives light: the picture will be black".to_owned().into());
        }
        self.notes.extend(lacking::notes(scene));
        let known = before.map(|before| &*before.textures);
        let textures = PreparedTextures::new(scene, known, &mut self.notes);
        let (mut materials, varying, opacities) = prepare_materials(&scene.materials, &textures);
        let (bands, dispersed) = disperse(&mut materials).unzip();
        let some_open = !opacities.is_empty() || materials.iter().any(|m| m.one_sided);
        let mut ranked: Vec<Border> = materials.iter().filter_map(|m| m.border).collect();
        ranked.retain(|b| b.rank.is_some());
        ranked.sort_unstable_by_key(|b| b.rank);
        let ranked_media: Vec<_> = ranked.into_iter().map(|b| b.interior).collect();
        if ranked_media.len() > Media::MOST {
            self.notes.push(format!(
                "{} materials have a priority; where more than {} overlap, the weakest are overlooked",
                ranked_media.len(),
                Media::MOST
            ).into());
        }
        let report = PrepareReport {
            triangles,
            stored_triangles: stored as u64,
            shared_meshes: meshes as u64,
            instances: instances as u64,
            spheres: spheres as u64,
            disks: disks as u64,
            customs: customs as u64,
            materials: scene.materials.len() as u64,
            textures: scene.textures.len() as u64,
            texture_bytes: textures.bytes(),
            emitters: self.emitters.len() as u64,
            bounds: surfaces.bounds(),
            bvh: *surfaces.report(),
            notes: self.notes,
        };
        let has_borders = materials.iter().any(|m| m.border.is_some());
        let is_plain = !materials.iter().any(crate::prepare::PreparedMaterial::bends_the_way);
        let mut prepared = Prepared {
            camera: scene.camera,
            surfaces,
            build: *options,
            object_of_primitive,
            object_of_instance,
            objects: self.objects.into(),
            normals: self.normals.into(),
            uvs: self.uvs.into(),
            colors: self.colors.into(),
            tangents: self.tangents.into(),
            textures: Arc::new(textures),
            materials: materials.into(),
            opacities: opacities.into(),
            varying: varying.into(),
            bands: bands.map(Arc::new),
            dispersed: dispersed.unwrap_or_default().into(),
            light_beyond_sampling: !ranked_media.is_empty()
                || self.emitters.iter().any(Emitter::is_custom),
            ranked_media: ranked_media.into(),
            emitters: self.emitters.into(),
            groups: Groups::new(scene, &self.groups),
            light_tree: Arc::default(),
            environment,
            eye: Eye::default(),
            camera_media: Media::NONE,
            some_pass: self.some_pass,
            some_open,
            has_borders,
            is_plain,
            casting: None,
            ids: Ids::new(scene),
            extents,
            report,
        };
        prepared.casting = prepared.find_casting().map(Arc::new);
        prepared.look_through(scene.camera);
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
            vertices: 0,
            first_normal: None,
            first_uv: None,
            uv_sets: 0,
            first_color: None,
            first_tangent: None,
            axes: None,
        };
        // What neither scatters nor glows is left out.
        if passes(material) && !material.gives_light() {
            self.objects.push(prepared);
            return;
        }
        self.some_pass |= passes(material);
        self.one_sided = material.is_one_sided(&scene.materials);
        match &object.shape {
            Shape::Mesh(id) => {
                let mesh = &scene.meshes[id.0 as usize];
                if self.are_instances[number]
                    && let Some(stored) = self.store(id.0, mesh)
                {
                    self.add_instance(stored, number, object, mesh, material, &mut prepared);
                    self.objects.push(prepared);
                    return;
                }
                self.add_mesh(mesh, number, object, material, &mut prepared);
            }
            Shape::Box { size } => {
                self.add_mesh(&box_mesh(*size), number, object, material, &mut prepared);
            }
            Shape::Rectangle { size } => {
                let corners = self.add_rectangle(*size, world_from_object, number, &mut prepared);
                let area = 2.0 * triangle_area(corners);
                if let Some(glow) = self.glow(number, material, area) {
                    let emitter = ParallelogramEmitter::new(corners, glow);
                    prepared.emitters = ObjectEmitters::One(self.add_lamp(
                        material,
                        glow,
                        Emitter::Parallelogram(emitter),
                    ));
                }
            }
            Shape::Sphere { radius } => {
                let scale = world_from_object.uniform_scale().unwrap_or(1.0);
                let center = world_from_object.translation();
                let axes = Vec3::AXES.map(|axis| world_from_object.vector(axis) / scale);
                prepared.axes = (axes != Vec3::AXES).then(|| Box::new(axes));
                let sphere = Sphere { center, radius: *radius * scale };
                self.spheres.push(sphere);
                self.objects_of[1].push(number as u32);
                let radius = f64::from(sphere.radius);
                let area = 4.0 * PI * radius * radius;
                if let Some(glow) = self.glow(number, material, area) {
                    let emitter = Emitter::Sphere(SphereEmitter { sphere, glow });
                    prepared.emitters = ObjectEmitters::One(self.add_lamp(material, glow, emitter));
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
                    prepared.emitters = ObjectEmitters::One(self.add_lamp(material, glow, emitter));
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
            self.note_inside_out(mesh, number);
        }

        if !mesh.normals.is_empty() {
            prepared.first_normal = Some(self.normals.len() as u32);
            let normals = mesh.normals.iter();
            self.normals.extend(normals.map(|&n| transform.normal(n).normalize_or_zero()));
        }
        self.add_painting(mesh, transform).give(prepared);
        let corners = |t: &[u32; 3]| t.map(|v| self.positions[v as usize]);
        if material.emission.is_some() {
            let corners = self.triangles[first_triangle..].iter().map(corners).collect();
            self.add_triangle_emitters(corners, number, material, prepared);
        }
    }

    /// Takes over what textures need of a mesh, its tangents transformed.
    fn add_painting(&mut self, mesh: &Mesh, transform: &Transform) -> Painting {
        let vertices = mesh.positions.len();
        let mut painting = Painting { vertices: vertices as u32, ..Painting::default() };
        let sets = std::iter::once(&mesh.uvs).chain(&mesh.more_uvs);
        if sets.clone().any(|uvs| !uvs.is_empty()) {
            painting.first_uv = Some(self.uvs.len() as u32);
            for uvs in sets {
                self.uvs.extend_from_slice(uvs);
                let missing = if uvs.is_empty() { vertices } else { 0 };
                self.uvs.resize(self.uvs.len() + missing, Vec2::ZERO);
                painting.uv_sets += 1;
            }
        }
        if !mesh.colors.is_empty() {
            painting.first_color = Some(self.colors.len() as u32);
            self.colors.extend_from_slice(&mesh.colors);
        }
        if !mesh.tangents.is_empty() {
            painting.first_tangent = Some(self.tangents.len() as u32);
            let turn = if transform.mirrors() { -1.0 } else { 1.0 };
            self.tangents.extend(mesh.tangents.iter().map(|&[x, y, z, hand]| {
                let along = transform.vector(Vec3::new(x, y, z)).normalize_or_zero();
                [along.x, along.y, along.z, hand * turn]
            }));
        }
        painting
    }

    fn note_inside_out(&mut self, mesh: &Mesh, number: usize) {
        let name = if mesh.name.is_empty() { "a mesh" } else { &mesh.name };
        self.notes.push(Place::Object(number).note(format!(
            "{name} is wound inside out; its triangles are turned, so that glass is inside"
        )));
    }

    /// Stores a mesh for its instances, if it can be; once. Its normals stay in its own space.
    fn store(&mut self, id: u32, mesh: &Mesh) -> Option<Stored> {
        if let Some(stored) = self.stored.get(&id) {
            return Some(*stored);
        }
        let number = self.meshes.len();
        let known = self.known.get(number).filter(|m| m.is_of(&mesh.positions, &mesh.triangles));
        let shared = match known {
            Some(known) => Arc::clone(known),
            None => {
                let (positions, triangles) = (mesh.positions.clone(), mesh.triangles.clone());
                Arc::new(SharedMesh::new(positions, triangles, &self.options)?)
            }
        };
        self.meshes.push(shared);
        let first = |values: &[Vec3]| (!values.is_empty()).then_some(self.normals.len() as u32);
        let first_normal = first(&mesh.normals);
        self.normals.extend_from_slice(&mesh.normals);
        let painting = self.add_painting(mesh, &Transform::IDENTITY);
        let stored = Stored { number: number as u32, first_normal, painting };
        self.stored.insert(id, stored);
        Some(stored)
    }

    fn add_instance(
        &mut self,
        stored: Stored,
        number: usize,
        object: &Object,
        mesh: &Mesh,
        material: &Material,
        prepared: &mut PreparedObject,
    ) {
        let Stored { number: in_order, first_normal, painting } = stored;
        let inside_out = self.enclosures[number].inside_out;
        let instance = Instance {
            mesh: in_order,
            turned: object.world_from_object.mirrors() != inside_out,
            after: self.triangles.len() as u32,
            world_from_mesh: object.world_from_object,
        };
        // Of one mesh that is told once.
        let again = |i: &Instance| i.mesh == in_order;
        if inside_out && !self.instances.iter().rev().any(again) {
            self.note_inside_out(mesh, number);
        }
        self.instances.push(instance);
        self.objects_of_instances.push(number as u32);
        *prepared = PreparedObject {
            first_primitive: 0,
            first_vertex: 0,
            first_normal,
            ..prepared.clone()
        };
        painting.give(prepared);
        if material.emission.is_some() {
            let corners = |t: &[u32; 3]| instance.placed(t.map(|v| mesh.positions[v as usize]));
            let corners = mesh.triangles.iter().map(corners).collect();
            self.add_triangle_emitters(corners, number, material, prepared);
        }
    }

    /// Makes triangles shine, if the material does.
    fn add_triangle_emitters(
        &mut self,
        triangles: Vec<[Vec3; 3]>,
        number: usize,
        material: &Material,
        prepared: &mut PreparedObject,
    ) {
        // Triangles that are no numbers give no light.
        let area = triangles.iter().copied().map(triangle_area).filter(|a| a.is_finite()).sum();
        let Some(glow) = self.glow(number, material, area) else { return };
        if is_uneven(material) {
            prepared.emitters = ObjectEmitters::One(self.add_emitter(Emitter::Custom(glow)));
            return;
        }
        let emitter = |corners| Emitter::Triangle(TriangleEmitter::new(corners, glow));
        prepared.emitters = ObjectEmitters::Each(self.emitters.len() as u32);
        self.emitters.extend(triangles.into_iter().map(emitter));
    }

    /// Adds two triangles; returns the corner and its two neighbours.
    fn add_rectangle(
        &mut self,
        size: Vec2,
        transform: &Transform,
        number: usize,
        prepared: &mut PreparedObject,
    ) -> [Vec3; 3] {
        let (x, y) = (0.5 * size.x, 0.5 * size.y);
        let mut corners = [(-x, -y), (x, -y), (x, y), (-x, y)]
            .map(|(x, y)| transform.point(Vec3::new(x, y, 0.0)));
        let mut uvs = SQUARE;
        if transform.mirrors() {
            corners.swap(1, 3);
            uvs.swap(1, 3);
        }
        (prepared.first_uv, prepared.uv_sets) = (Some(self.uvs.len() as u32), 1);
        prepared.vertices = 4;
        self.uvs.extend(uvs);
        let first = self.positions.len() as u32;
        self.positions.extend(corners);
        self.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t: [u32; 3]| t.map(|v| v + first)));
        self.objects_of[0].resize(self.triangles.len(), number as u32);
        [corners[0], corners[1], corners[3]]
    }

    /// The light of object `number`, of `area` m², with this material.
    fn glow(&mut self, number: usize, material: &Material, area: f64) -> Option<Glow> {
        let Emission { light, two_sided, .. } = material.emission?;
        // Rays never meet the back of what has only a front.
        let two_sided = two_sided && !self.one_sided;
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
        let bearable = LIGHT.contains(&radiance.max_channel());
        let shines = measurable && bearable && !radiance.is_black();
        if !shines {
            let why = if measurable {
                "its power cannot be spread over it"
            } else {
                "that is too little or too much to measure"
            };
            self.notes.push(
                Place::Object(number)
                    .note(format!("a lamp of {area:.3e} m² that gives no light: {why}")),
            );
        }
        shines.then_some(Glow { radiance, two_sided })
    }

    /// Adds the emitter of a shape, as one that is not sampled where its light is not even.
    fn add_lamp(&mut self, material: &Material, glow: Glow, emitter: Emitter) -> u32 {
        self.add_emitter(if is_uneven(material) { Emitter::Custom(glow) } else { emitter })
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

/// True where a lamp is brighter in some places than in others, or has holes: its light is found by
/// scattered rays alone.
fn is_uneven(material: &Material) -> bool {
    material.opacity.is_some() || material.emission.is_some_and(|e| e.variation().is_some())
}

/// In m².
fn triangle_area(corners: [Vec3; 3]) -> f64 {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    0.5 * (b - a).cross(c - a).length()
}

/// Texture coordinates of a rectangle, counter-clockwise from its lower left corner.
const SQUARE: [Vec2; 4] = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];

/// A box around the origin with outward normals. Each side has four vertices for its texture
/// coordinates; those of other sides are at the same points, so no ray slips through.
fn box_mesh(size: Vec3) -> Mesh {
    let half = 0.5 * size;
    let corner = |i: u32| {
        half * Vec3::from([0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 1.0 } else { -1.0 }))
    };
    let faces =
        [[0, 4, 6, 2], [5, 1, 3, 7], [0, 1, 5, 4], [6, 7, 3, 2], [1, 0, 2, 3], [4, 5, 7, 6]];
    let positions = faces.as_flattened().iter().map(|&i| corner(i)).collect();
    let uvs = faces.iter().flat_map(|_| SQUARE).collect();
    let first = (0..).step_by(4).take(faces.len());
    let triangles = first.flat_map(|i| [[i, i + 1, i + 2], [i, i + 2, i + 3]]).collect();
    Mesh { name: "box".into(), positions, uvs, triangles, ..Mesh::default() }
}
