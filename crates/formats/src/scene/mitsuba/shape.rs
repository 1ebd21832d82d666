//! What stands in a scene: meshes from files, and bodies that formulas tell.
//!
//! Spheres, disks, rectangles and cubes stay what they are where they may; those that are textured,
//! turned inside out or stretched become triangles, and cylinders always do.

use super::bsdf::Look;
use super::document::{Class, Content, View};
use super::scene::Maker;
use super::serialized;
use crate::error::{SceneError, SceneErrorKind};
use crate::scene::affine::{Affine, single};
use crate::scene::{called, obj, ply, round};
use rutilant::scene::{MaterialId, MeshId};
use rutilant::shape::{Mesh, Object, Shape};
use rutilant_geom::{DVec3, Vec2, Vec3, real};
use std::collections::HashMap;
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::Arc;

/// All that are read.
const KNOWN: &[&str] = &[
    "obj",
    "ply",
    "serialized",
    "rectangle",
    "disk",
    "cube",
    "sphere",
    "cylinder",
    "shapegroup",
    "instance",
];

/// Meshes that are the same wherever they stand.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct MeshKey {
    from: From,
    flat: bool,
    flip_v: bool,
    inside_out: bool,
}

/// What a mesh is made of.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum From {
    /// The file, the same for every name of it, and which of its meshes.
    File(PathBuf, u32),
    Sphere,
    Cube,
    Cylinder,
}

/// A shape with its material, to be put where its group stands.
pub(super) struct Ready {
    name: Arc<str>,
    material: MaterialId,
    /// What it is made of, and where each body stands in the group.
    bodies: Vec<(Shape, Affine)>,
}

/// The numbers of a shape and of its group, and whether that is stretched where it stands.
pub(super) type ReadyKey = (usize, usize, bool);

impl Maker<'_, '_> {
    /// Puts a shape where `world_from_group` says; a `group` is what it stands in.
    pub(super) fn place(
        &mut self,
        shape: View<'_, '_>,
        world_from_group: &Affine,
        group: Option<View<'_, '_>>,
    ) -> Result<(), SceneError> {
        match shape.plugin() {
            // What stands in it is placed by its instances.
            "shapegroup" => {
                shape.pass_over_parts();
                return Ok(());
            }
            "instance" => return self.instance(shape, world_from_group, group),
            _ if !KNOWN.contains(&shape.plugin()) => return Err(shape.unknown(KNOWN)),
            _ => {}
        }
        let stretched = world_from_group.uniform_scale().is_none();
        let ready = match group {
            None => Rc::new(self.ready(shape, stretched, None)?),
            // However often it stands, it is looked at once.
            Some(group) => {
                let key = (shape.number, group.number, stretched);
                match self.ready.get(&key) {
                    Some(ready) => Rc::clone(ready),
                    None => {
                        let ready = Rc::new(self.ready(shape, stretched, Some(group))?);
                        self.ready.insert(key, Rc::clone(&ready));
                        ready
                    }
                }
            }
        };
        let world_from_group = self.turn * *world_from_group;
        for (body, placed) in &ready.bodies {
            let asked = self.scene.objects.len() as u64 + 1;
            self.check_objects(asked, shape)?;
            let world = world_from_group * *placed;
            let object = rutilant::scene::Place::Object(self.scene.objects.len());
            self.remember(object, shape.place());
            let Some(world_from_object) = world.to_transform() else {
                let what = "here the numbers of its place grow beyond all bounds";
                return Err(shape.document.invalid(shape.place(), what));
            };
            let (name, object) =
                (Arc::clone(&ready.name), Object::new(body.clone(), ready.material));
            self.scene.objects.push(Object { name, world_from_object, ..object });
        }
        Ok(())
    }

    fn check_objects(&self, asked: u64, at: View<'_, '_>) -> Result<(), SceneError> {
        let allowed = self.options.limits.objects;
        if asked <= allowed {
            return Ok(());
        }
        let kind = SceneErrorKind::Limit { what: "objects", asked, allowed };
        Err(at.document.error(at.place(), kind))
    }

    /// Refuses more objects than there may be before any takes memory: few lines can ask for very
    /// many. A shape counts as one here.
    pub(super) fn count(&self, scene: View<'_, '_>) -> Result<(), SceneError> {
        let mut count = 0_u64;
        let mut groups = HashMap::<usize, u64>::new();
        for shape in scene.parts(Class::Shape) {
            count += match shape.plugin() {
                "shapegroup" => 0,
                "instance" => shape.only(Class::Shape).map_or(0, |group| {
                    let parts = || group.parts(Class::Shape).count() as u64;
                    *groups.entry(group.number).or_insert_with(parts)
                }),
                _ => 1,
            };
            self.check_objects(count, shape)?;
        }
        Ok(())
    }

    /// A shape in its group, with its own `to_world` in the places of its bodies. Whether the group
    /// is `stretched` tells what a sphere can be.
    fn ready(
        &mut self,
        shape: View<'_, '_>,
        stretched: bool,
        group: Option<View<'_, '_>>,
    ) -> Result<Ready, SceneError> {
        let to_world = shape.transform("to_world")?;
        let flipped = shape.boolean("flip_normals", false)?;
        shape.pass_over(&["silhouette_sampling_weight", "name"]);
        let bsdf = shape.only(Class::Bsdf);
        let emission =
            shape.only(Class::Emitter).map(|emitter| self.emission(emitter)).transpose()?;
        let mut look = match (bsdf, emission) {
            (Some(bsdf), _) => self.look_of(bsdf)?,
            (None, None) => Look::grey(),
            (None, Some(_)) => Look::black(),
        };
        if look.opacity.is_some() && !self.scene.lights.is_empty() {
            let what = "a mask lets the light of points, spots and directions through; Mitsuba's \
                        casts a black shadow in it";
            shape.note(what, what);
        }
        look.textured |= emission.is_some_and(|emission| emission.texture.is_some());
        let material = self.material(shape, bsdf, &look, emission)?;
        let mut shapes: Vec<(Shape, Affine)> = Vec::new();
        let own = |shape: Shape, matrix: Affine| vec![(shape, matrix)];
        let as_mesh = flipped || look.textured;
        let meshes =
            |ids: Vec<MeshId>| ids.into_iter().map(|id| (Shape::Mesh(id), Affine::IDENTITY));
        match shape.plugin() {
            "rectangle" => {
                shapes = own(Shape::Rectangle { size: Vec2::splat(2.0) }, inside_out(flipped));
            }
            "disk" => {
                if look.textured {
                    let what = "a picture lies on a disk from side to side, not around its middle";
                    shape.note(what, what);
                }
                shapes = own(Shape::Disk { radius: 1.0 }, inside_out(flipped));
            }
            "cube" if as_mesh => shapes.extend(meshes(self.made(From::Cube, flipped))),
            "cube" => shapes = own(Shape::Box { size: Vec3::splat(2.0) }, Affine::IDENTITY),
            "sphere" => {
                let center = DVec3::from(shape.vector("center")?.unwrap_or_default());
                let radius = f64::from(shape.number("radius", 1.0)?);
                let placed = Affine { translation: center, ..Affine::IDENTITY };
                let round = to_world.uniform_scale().is_some();
                if as_mesh || !round || stretched {
                    let what = "spheres that are textured, stretched or turned inside out become \
                                triangles";
                    shape.note(what, what);
                    if !round || stretched {
                        let what =
                            "spheres that are stretched are shown so; Mitsuba keeps them round";
                        shape.note(what, what);
                    }
                    let sized = placed * Affine::scale(DVec3::splat(radius));
                    let made = self.made(From::Sphere, flipped);
                    shapes.extend(meshes(made).map(|(shape, _)| (shape, sized)));
                } else {
                    shapes = own(Shape::Sphere { radius: radius as f32 }, placed);
                }
            }
            "cylinder" => {
                let bottom = DVec3::from(shape.vector("p0")?.unwrap_or_default());
                let top = DVec3::from(shape.vector("p1")?.unwrap_or([0.0, 0.0, 1.0]));
                let radius = f64::from(shape.number("radius", 1.0)?);
                let axis = top - bottom;
                let Some(along) = axis.try_normalize() else {
                    let what = "a cylinder needs two ends that are not the same point";
                    return Err(shape.document.invalid(shape.place(), what));
                };
                let (across, third) = along.any_orthonormal_pair();
                let columns = [across * radius, third * radius, axis];
                let placed = Affine { linear: columns, translation: bottom };
                let made = self.made(From::Cylinder, flipped);
                shapes.extend(meshes(made).map(|(shape, _)| (shape, placed)));
            }
            _ => shapes.extend(meshes(self.meshes_of(shape, flipped)?)),
        }

        let is_file = matches!(shape.plugin(), "obj" | "ply" | "serialized");
        let name = match (shape.id(), shapes.first()) {
            ("", Some((Shape::Mesh(id), _))) if is_file => &self.scene.meshes[id.0 as usize].name,
            ("", _) => &self.scene.materials[material.0 as usize].name,
            (id, _) => id,
        };
        let name = match group {
            Some(group) => called::part_of(group.id(), called::shortened(name)),
            None => called::shortened(name).into(),
        };
        let bodies = shapes.into_iter().map(|(body, placed)| (body, to_world * placed)).collect();
        Ok(Ready { name, material, bodies })
    }

    fn instance(
        &mut self,
        shape: View<'_, '_>,
        world_from_group: &Affine,
        within: Option<View<'_, '_>>,
    ) -> Result<(), SceneError> {
        let Some(group) = shape.only(Class::Shape).filter(|group| group.plugin() == "shapegroup")
        else {
            let what = "an instance needs a shapegroup";
            return Err(shape.document.invalid(shape.place(), what));
        };
        if within.is_some() {
            // Mitsuba has no instances of groups of instances either.
            let what = "an instance cannot stand within a shapegroup";
            return Err(shape.document.invalid(shape.place(), what));
        }
        let world = *world_from_group * shape.transform("to_world")?;
        group.parts(Class::Shape).try_for_each(|part| self.place(part, &world, Some(group)))
    }

    /// The meshes of a file; one for each material that it has.
    fn meshes_of(&mut self, shape: View<'_, '_>, flipped: bool) -> Result<Vec<MeshId>, SceneError> {
        let (name, place) = shape.file_name()?;
        let number = match shape.plugin() {
            "serialized" => shape.count("shape_index", 0..=u32::MAX)?.unwrap_or(0),
            _ => 0,
        };
        let flat = shape.boolean("face_normals", false)?;
        // OBJ files have v upwards, and Mitsuba downwards.
        let flip_v = shape.boolean("flip_tex_coords", shape.plugin() == "obj")?;
        shape.pass_over(&["shape_index", "max_smooth_angle", "srgb"]);
        let identity = match self.document.files.embedded(name) {
            Some(_) => self.document.files.path(name),
            None => self.document.find(name, place)?.identity,
        };
        let from = From::File(identity.clone(), number);
        let key = MeshKey { from, flat, flip_v, inside_out: flipped };
        if let Some(known) = self.meshes.get(&key) {
            return Ok(known.clone());
        }
        let file = match self.bytes.get(&identity) {
            Some(file) => Arc::clone(file),
            None => {
                let file = Arc::new(self.document.content(name, place)?);
                // Only these are read again for another mesh.
                if shape.plugin() == "serialized" {
                    serialized::check_order(&file.bytes, &file.path)?;
                    self.bytes.insert(identity, Arc::clone(&file));
                }
                file
            }
        };
        let Content { bytes, path, .. } = &*file;
        let limits = self.limits_left();
        let (meshes, notes) = match shape.plugin() {
            "obj" => {
                let read = obj::read_bytes(bytes, path, &limits)?;
                (read.meshes.into_iter().map(|(mesh, _)| mesh).collect(), read.notes)
            }
            "ply" => {
                let (mesh, notes) = ply::read_bytes(bytes, path, &limits)?;
                (vec![mesh], notes)
            }
            _ => {
                let mesh = serialized::read_bytes(bytes, number, path, &limits)?;
                (vec![mesh], Vec::new())
            }
        };
        self.notes.extend(notes);
        let title = match shape.id() {
            "" => path.file_stem().map(|stem| stem.to_string_lossy().into_owned()),
            id => Some(id.to_owned()),
        };
        let mut ids = Vec::new();
        for mut mesh in meshes {
            if flip_v {
                mesh.uvs.iter_mut().for_each(|uv| uv.y = 1.0 - uv.y);
            }
            if flat {
                mesh.normals.clear();
            } else if mesh.normals.is_empty() {
                mesh.normals = smooth_normals(&mesh);
            }
            if flipped {
                turn_inside_out(&mut mesh);
            }
            mesh.name = title.clone().unwrap_or_default();
            ids.push(self.add_mesh(mesh));
        }
        self.meshes.insert(key, ids.clone());
        Ok(ids)
    }

    /// A body as triangles.
    fn made(&mut self, from: From, flipped: bool) -> Vec<MeshId> {
        let mesh = match from {
            From::Cube => cube(),
            From::Cylinder => cylinder(),
            From::Sphere | From::File(..) => sphere(),
        };
        let key = MeshKey { from, flat: false, flip_v: false, inside_out: flipped };
        if let Some(known) = self.meshes.get(&key) {
            return known.clone();
        }
        let mut mesh = mesh;
        if flipped {
            turn_inside_out(&mut mesh);
        }
        let ids = vec![self.add_mesh(mesh)];
        self.meshes.insert(key, ids.clone());
        ids
    }
}

/// What turns a flat thing over, so that its front is below.
fn inside_out(flipped: bool) -> Affine {
    if flipped { Affine::scale(DVec3::new(1.0, 1.0, -1.0)) } else { Affine::IDENTITY }
}

fn turn_inside_out(mesh: &mut Mesh) {
    mesh.normals.iter_mut().for_each(|normal| *normal = -*normal);
    mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
}

/// Normals for a mesh without: the mean around each vertex, by angle. Unlike
/// [`Mesh::smoothed`], only triangles that name the same vertex are smoothed over their edge: where a
/// file has a vertex twice, Mitsuba shows an edge.
fn smooth_normals(mesh: &Mesh) -> Vec<Vec3> {
    let mut sums = vec![DVec3::ZERO; mesh.positions.len()];
    for triangle in &mesh.triangles {
        let corner = |i: usize| mesh.positions.get(triangle[i] as usize).map(|p| p.as_dvec3());
        let [Some(a), Some(b), Some(c)] = [corner(0), corner(1), corner(2)] else { continue };
        let Some(normal) = (b - a).cross(c - a).try_normalize() else { continue };
        for (vertex, [at, before, after]) in triangle.iter().zip([[a, c, b], [b, a, c], [c, b, a]])
        {
            let sides = (before - at).try_normalize().zip((after - at).try_normalize());
            let Some((one, other)) = sides else { continue };
            // The angle by half of it, which is exact for narrow ones as well.
            let half = real::atan2((one - other).length() as f32, (one + other).length() as f32);
            if normal.is_finite() {
                sums[*vertex as usize] += normal * f64::from(2.0 * half);
            }
        }
    }
    sums.into_iter().map(|sum| sum.try_normalize().map_or(Vec3::Y, single)).collect()
}

/// A sphere of radius 1 with its poles on the z axis; u is longitude, v begins at +z.
fn sphere() -> Mesh {
    Mesh { name: "sphere".to_owned(), ..round::sphere(1.0, [90.0, -90.0], 360.0) }
}

/// The side of a cylinder of radius 1 around z from 0 to 1, without its ends; u goes around, v up.
fn cylinder() -> Mesh {
    Mesh { name: "cylinder".to_owned(), ..round::cylinder(1.0, [0.0, 1.0], 360.0) }
}

/// A cube from −1 to 1 with the texture coordinates that Mitsuba's has.
fn cube() -> Mesh {
    // Each side, and where u and v grow on it.
    let sides = [
        (Vec3::NEG_Y, Vec3::Z, Vec3::X),
        (Vec3::Y, Vec3::NEG_X, Vec3::NEG_Z),
        (Vec3::X, Vec3::Y, Vec3::NEG_Z),
        (Vec3::Z, Vec3::Y, Vec3::X),
        (Vec3::NEG_X, Vec3::Y, Vec3::Z),
        (Vec3::NEG_Z, Vec3::NEG_Y, Vec3::X),
    ];
    let mut mesh = Mesh { name: "cube".to_owned(), ..Mesh::default() };
    for (i, (normal, u, v)) in (0..).zip(sides) {
        for (x, y) in [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
            mesh.positions.push(normal + u * x + v * y);
            mesh.normals.push(normal);
            mesh.uvs.push(Vec2::new(0.5 + 0.5 * x, 0.5 + 0.5 * y));
        }
        let first = 4 * i;
        mesh.triangles.extend([[first, first + 1, first + 2], [first + 3, first, first + 2]]);
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bodies have their fronts outside, and normals that say so.
    #[test]
    fn bodies_look_outwards() {
        for mesh in [sphere(), cylinder(), cube()] {
            let middle = mesh.positions.iter().sum::<Vec3>() / mesh.positions.len() as f32;
            for triangle in &mesh.triangles {
                let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
                let front = (b - a).cross(c - a);
                assert!(front.length() > 1e-7, "{}", mesh.name);
                let out = (a + b + c) / 3.0 - middle;
                assert!(front.dot(out) > 0.0, "{}: {a} {b} {c}", mesh.name);
                for i in triangle {
                    assert!(mesh.normals[*i as usize].dot(front) > 0.0, "{}", mesh.name);
                }
            }
        }
    }

    /// The corners of Mitsuba's cube, and where pictures lie on it (`cube.cpp` tells them as a list).
    #[test]
    fn cubes_are_painted_alike() {
        let mesh = cube();
        let find = |p: [f32; 3], n: [f32; 3]| {
            let at = (0..24)
                .find(|&i| mesh.positions[i] == Vec3::from(p) && mesh.normals[i] == Vec3::from(n));
            mesh.uvs[at.expect("a corner")].to_array()
        };
        assert_eq!(find([1.0, -1.0, -1.0], [0.0, -1.0, 0.0]), [0.0, 1.0]);
        assert_eq!(find([1.0, -1.0, 1.0], [0.0, -1.0, 0.0]), [1.0, 1.0]);
        assert_eq!(find([1.0, 1.0, -1.0], [0.0, 1.0, 0.0]), [0.0, 1.0]);
        assert_eq!(find([-1.0, 1.0, -1.0], [0.0, 1.0, 0.0]), [1.0, 1.0]);
        assert_eq!(find([1.0, -1.0, -1.0], [1.0, 0.0, 0.0]), [0.0, 1.0]);
        assert_eq!(find([1.0, 1.0, -1.0], [1.0, 0.0, 0.0]), [1.0, 1.0]);
        assert_eq!(find([1.0, -1.0, 1.0], [0.0, 0.0, 1.0]), [0.0, 1.0]);
        assert_eq!(find([1.0, 1.0, 1.0], [0.0, 0.0, 1.0]), [1.0, 1.0]);
        assert_eq!(find([-1.0, -1.0, 1.0], [-1.0, 0.0, 0.0]), [0.0, 1.0]);
        assert_eq!(find([-1.0, 1.0, 1.0], [-1.0, 0.0, 0.0]), [1.0, 1.0]);
        assert_eq!(find([1.0, 1.0, -1.0], [0.0, 0.0, -1.0]), [0.0, 1.0]);
        assert_eq!(find([1.0, -1.0, -1.0], [0.0, 0.0, -1.0]), [1.0, 1.0]);
    }
}
