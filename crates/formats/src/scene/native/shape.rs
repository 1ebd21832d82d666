//! `[[shape]]`: what stands in the scene.

use super::draft::{Draft, MeshFile, Part};
use super::table::{Table, Value};
use super::{instances, keys, light_group, material, placing};
use crate::error::SceneError;
use crate::file;
use crate::options::ReadOptions;
use crate::scene::framing::bounds_of;
use crate::scene::gltf::scene::{self as gltf, Model};
use crate::scene::mesh_file;
use crate::scene::obj::ObjScene;
use crate::scene::origins::MeshOrigin;
use rutilant::scene::Place;
use rutilant::shape::{Mesh, Object, Shape};
use rutilant_geom::{Aabb, Transform};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

#[derive(Clone, Copy)]
enum Type {
    Mesh,
    Sphere,
    Rectangle,
    Disk,
    Box,
}

const TYPES: &[(&str, Type)] = &[
    ("mesh", Type::Mesh),
    ("sphere", Type::Sphere),
    ("rectangle", Type::Rectangle),
    ("disk", Type::Disk),
    ("box", Type::Box),
];

pub(super) fn read<'d>(table: &Table<'d>, draft: &mut Draft<'d>) -> Result<(), SceneError> {
    let allow = |table: &Table<'d>, keys| table.only(&[keys::ANY_SHAPE, keys::CENTERED, keys]);
    let (table, shape) = match table.must("type", |v| v.one_of("shape type", TYPES))? {
        Type::Mesh => return read_mesh(&table.named("a mesh"), draft),
        Type::Sphere => {
            let table = table.named("a sphere");
            allow(&table, keys::ROUND)?;
            (table, Shape::Sphere { radius: table.must("radius", Value::number)? })
        }
        Type::Disk => {
            let table = table.named("a disk");
            allow(&table, keys::ROUND)?;
            (table, Shape::Disk { radius: table.must("radius", Value::number)? })
        }
        Type::Rectangle => {
            let table = table.named("a rectangle");
            allow(&table, keys::SIZED)?;
            (table, Shape::Rectangle { size: table.must("size", Value::pair)? })
        }
        Type::Box => {
            let table = table.named("a box");
            allow(&table, keys::SIZED)?;
            (table, Shape::Box { size: table.must("size", Value::triple)? })
        }
    };
    let material = table.must("material", |v| material::named(v, &draft.materials))?;
    let (name, group) = (name_of(&table)?, light_group::of(&table)?);
    let world_from_object = placing::transform(&table)?;
    for (place, moved) in instances::places(&table, draft)? {
        let world_from_object = placing::after(moved, world_from_object);
        let shape = shape.clone();
        let name = Arc::clone(&name);
        draft.add_object(&place, Object { name, shape, material, world_from_object, group })?;
    }
    Ok(())
}

fn read_mesh<'d>(table: &Table<'d>, draft: &mut Draft<'d>) -> Result<(), SceneError> {
    table.only(&[keys::ANY_SHAPE, keys::MESH])?;
    let given = table.maybe("material", |v| material::named(v, &draft.materials))?;
    let mesh = match table.either(["file", "positions"])? {
        "file" => table.must("file", |value| from_file(value, table, draft))?,
        _ => Rc::new(inline(table, draft)?),
    };

    // The file's own materials are used; where it has none, the one given here.
    let backup = match &mesh.without_material {
        None => given,
        Some(without) => {
            let stand_in = if given.is_some() { "the shape's own material" } else { "matte grey" };
            draft.notes.push(table.note(&format!("{without}: {stand_in} stands in")));
            Some(given.unwrap_or_else(|| draft.grey()))
        }
    };

    let (name, group) = (name_of(table)?, light_group::of(table)?);
    let fitted = table.maybe("fit", |value| placing::fit(value, mesh.bounds))?;
    let fitted = fitted.unwrap_or(Transform::IDENTITY);
    let world_from_object = placing::after(placing::transform(table)?, fitted);
    for (place, moved) in instances::places(table, draft)? {
        for part in &mesh.parts {
            let material = part.own.or(backup).or(part.stand_in);
            let material = material.ok_or_else(|| table.missing("material"))?;
            let world_from_file = placing::after(moved, world_from_object);
            let world_from_object = placing::after(world_from_file, part.file_from_part);
            let shape = Shape::Mesh(part.mesh);
            let name = if name.is_empty() { &part.name } else { &name };
            let name = Arc::clone(name);
            draft.add_object(&place, Object { name, shape, material, world_from_object, group })?;
        }
    }
    Ok(())
}

/// What the author calls the shape, empty where he does not.
fn name_of(table: &Table<'_>) -> Result<Arc<str>, SceneError> {
    table.or("name", |name| Ok(name.text()?.into()), Arc::default())
}

/// A mesh written out in the scene itself.
fn inline<'d>(table: &Table<'d>, draft: &mut Draft<'d>) -> Result<MeshFile, SceneError> {
    let points = |value: &Value<'_>| all(value, "points [[x, y, z], ..]", Value::triple);
    let positions = table.must("positions", points)?;
    let mesh = Mesh {
        name: String::new(),
        triangles: table.must("triangles", |value| triangles(value, positions.len()))?,
        normals: table.or("normals", points, Vec::new())?,
        uvs: table.or("uvs", |value| all(value, "pairs [[u, v], ..]", Value::pair), Vec::new())?,
        positions,
        ..Mesh::default()
    };
    if mesh.triangles.is_empty() {
        draft.notes.push(table.note("there are no faces in it, so nothing of it can be seen"));
    }
    let bounds = bounds_of(&mesh.positions);
    let mesh = smoothed(mesh, crease(table)?, table, &mut draft.notes);
    let id = draft.add_mesh(table, mesh, MeshOrigin::Text).map_err(|kind| table.error(kind))?;
    Ok(MeshFile { parts: vec![Part::new(id, None)], bounds, without_material: None })
}

fn triangles(value: &Value<'_>, vertices: usize) -> Result<Vec<[u32; 3]>, SceneError> {
    const EXPECTED: &str = "three vertex numbers each [[a, b, c], ..]";
    all(value, EXPECTED, |entry| {
        let triangle = entry.wholes(EXPECTED)?;
        match triangle.iter().find(|v| **v as usize >= vertices) {
            None => Ok(triangle),
            Some(v) => Err(entry.invalid(format!(
                "the triangle names vertex {v}, but there are only {vertices} (numbered from 0)"
            ))),
        }
    })
}

/// What `read` makes of each entry of an array.
fn all<'d, T>(
    value: &Value<'d>,
    expected: &str,
    read: impl Fn(&Value<'d>) -> Result<T, SceneError>,
) -> Result<Vec<T>, SceneError> {
    value.entries(expected)?.map(|entry| read(&entry)).collect()
}

/// The crease angle asked for, in radians.
fn crease(table: &Table<'_>) -> Result<Option<f32>, SceneError> {
    table.maybe("smooth_degrees", |value| {
        let degrees = value.number()?;
        if (0.0..=180.0).contains(&degrees) {
            Ok(degrees.to_radians())
        } else {
            let what = format!("smooth_degrees is {degrees}, but must lie between 0 and 180");
            Err(value.invalid(what))
        }
    })
}

/// The mesh with normals: its own, or smooth ones if `table` asks for them.
fn smoothed(mesh: Mesh, crease: Option<f32>, table: &Table<'_>, notes: &mut Vec<String>) -> Mesh {
    match crease {
        Some(crease) if mesh.normals.is_empty() => mesh.smoothed(crease),
        Some(_) => {
            let note =
                table.note("smooth_degrees changes nothing where a mesh has normals of its own");
            // A file may have many such meshes.
            if notes.last() != Some(&note) {
                notes.push(note);
            }
            mesh
        }
        None => mesh,
    }
}

/// The mesh file that a value names, read once however often it is named.
fn from_file<'d>(
    value: &Value<'d>,
    table: &Table<'d>,
    draft: &mut Draft<'d>,
) -> Result<Rc<MeshFile>, SceneError> {
    for key in ["triangles", "normals", "uvs"] {
        table.at_most_one(&["file", key])?;
    }
    let name = value.text()?;
    let embedded = draft.files.embedded(name);
    let (path, identity) = match embedded {
        Some(_) => (draft.files.path(name), PathBuf::from(name)),
        None => {
            let found = draft.files.find(name).map_err(|what| value.invalid(what))?;
            (found.path, found.identity)
        }
    };
    let crease = crease(table)?;
    let key = (identity, crease.map(f32::to_bits));
    if let Some(known) = draft.mesh_files.get(&key) {
        return Ok(Rc::clone(known));
    }
    if mesh_file::is_document(&path) {
        let options = ReadOptions {
            limits: draft.left,
            allow_outside: draft.files.fence.is_open(),
            ..ReadOptions::default()
        };
        let model = match embedded {
            Some(bytes) => gltf::model(bytes, &path, &options)?,
            None => {
                draft.read.push(key.0.clone());
                gltf::model(&file::scene_bytes(&path, &draft.left)?, &path, &options)?
            }
        };
        let read = Rc::new(take_in_model(model, crease, value, table, draft)?);
        draft.mesh_files.insert(key, Rc::clone(&read));
        return Ok(read);
    }
    let misnamed = |kind| value.error(kind);
    let file = match embedded {
        Some(bytes) => mesh_file::read_bytes(bytes, &path, &draft.left, misnamed)?,
        None => {
            draft.read.push(key.0.clone());
            mesh_file::read(&path, &draft.left, &draft.files.fence, misnamed)?
        }
    };
    let read = Rc::new(take_in(file, &key.0, crease, value, table, draft)?);
    draft.mesh_files.insert(key, Rc::clone(&read));
    Ok(read)
}

/// Takes the contents of a mesh file into the scene.
fn take_in<'d>(
    mut file: ObjScene,
    identity: &Path,
    crease: Option<f32>,
    value: &Value<'d>,
    table: &Table<'d>,
    draft: &mut Draft<'d>,
) -> Result<MeshFile, SceneError> {
    let first = [draft.scene.materials.len(), draft.scene.textures.len()];
    let materials = mesh_file::adopt(&mut file, &mut draft.scene, &mut draft.pictures);
    answer_for(first, table, draft);
    draft.mesh_materials.extend(first[0]..draft.scene.materials.len());
    draft.notes.extend(file.notes);
    let without_material = mesh_file::without_material(&file.meshes, &materials);

    let origin = match (&file.meshes[..], materials.is_empty()) {
        ([(mesh, _)], true) => {
            let crease = crease.filter(|_| mesh.normals.is_empty());
            MeshOrigin::File { path: identity.to_owned(), crease }
        }
        (_, _) => MeshOrigin::Made,
    };
    let mut bounds = Aabb::EMPTY;
    let mut parts = Vec::with_capacity(file.meshes.len());
    for (mesh, name) in file.meshes {
        bounds = bounds.union(bounds_of(&mesh.positions));
        let mesh = smoothed(mesh, crease, table, &mut draft.notes);
        let origin = origin.clone();
        let id = draft.add_mesh(table, mesh, origin).map_err(|kind| value.error(kind))?;
        parts.push(Part::new(id, name.and_then(|name| materials.get(&name).copied())));
    }
    Ok(MeshFile { parts, bounds, without_material })
}

/// Materials and textures from the `first` ones on come from a file that `table` names.
fn answer_for<'d>([materials, textures]: [usize; 2], table: &Table<'d>, draft: &mut Draft<'d>) {
    for i in textures..draft.scene.textures.len() {
        draft.places.insert(Place::Texture(i), *table);
    }
    for i in materials..draft.scene.materials.len() {
        draft.places.insert(Place::Material(i), *table);
    }
}

/// Takes the things of a document into the scene.
fn take_in_model<'d>(
    mut model: Model,
    crease: Option<f32>,
    value: &Value<'d>,
    table: &Table<'d>,
    draft: &mut Draft<'d>,
) -> Result<MeshFile, SceneError> {
    let first = [draft.scene.materials.len(), draft.scene.textures.len()];
    let materials = mesh_file::adopt_model(&mut model, &mut draft.scene, &mut draft.pictures);
    answer_for(first, table, draft);
    draft.notes.extend(model.notes);
    draft.read.extend(model.files);

    let mut bounds = Aabb::EMPTY;
    for object in &model.scene.objects {
        let Shape::Mesh(id) = object.shape else { continue };
        let positions = &model.scene.meshes[id.0 as usize].positions;
        let placed = positions.iter().map(|&point| object.world_from_object.point(point));
        bounds = bounds.union(bounds_of(&placed.collect::<Vec<_>>()));
    }
    let mut meshes = Vec::with_capacity(model.scene.meshes.len());
    for mesh in model.scene.meshes {
        let mesh = smoothed(mesh, crease, table, &mut draft.notes);
        let id = draft.add_mesh(table, mesh, MeshOrigin::Made).map_err(|kind| value.error(kind))?;
        meshes.push(id);
    }
    let parts = model.scene.objects.into_iter().filter_map(|object| {
        let Shape::Mesh(id) = object.shape else { return None };
        let material = Some(materials[object.material.0 as usize]);
        let is_stand_in = model.stand_ins.contains(&object.material);
        let (own, stand_in) = if is_stand_in { (None, material) } else { (material, None) };
        let file_from_part = object.world_from_object;
        let (name, mesh) = (object.name, meshes[id.0 as usize]);
        Some(Part { name, mesh, own, stand_in, file_from_part })
    });
    Ok(MeshFile { parts: parts.collect(), bounds, without_material: None })
}
