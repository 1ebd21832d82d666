//! Which side of a mesh of glass is inside.
//!
//! The winding of its triangles says where the glass is. A closed mesh that is
//! wound the wrong way round encloses a negative volume; its triangles are to
//! be turned. An open sheet, a water surface for example, encloses nothing: its
//! areas do not cancel, and it is believed.
//!
//! A file with several materials becomes an object for each. They follow each
//! other and stand in the same place; the open ones among them are looked at
//! together.

use crate::material::MaterialKind;
use crate::scene::Scene;
use crate::shape::{Mesh, Object, Shape};
use rutilant_geom::{DVec3, Vec3};
use std::collections::HashMap;

/// What an object encloses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Enclosure {
    /// It encloses a space by itself.
    pub(crate) closed: bool,
    /// Its triangles have to be turned for glass to be inside.
    pub(crate) inside_out: bool,
}

/// For each object of a valid scene what it encloses, as far as light can go into it.
pub(crate) fn enclosures(scene: &Scene) -> Vec<Enclosure> {
    let mut enclosures = Vec::with_capacity(scene.objects.len());
    // A mesh may stand in many places.
    let mut known = HashMap::new();
    let same_place = |a: &Object, b: &Object| {
        a.world_from_object == b.world_from_object
            && glass_mesh(a, scene).is_some()
            && glass_mesh(b, scene).is_some()
    };
    for group in scene.objects.chunk_by(same_place) {
        let meshes = group.iter().map(|object| glass_mesh(object, scene));
        let origin = meshes.clone().flatten().find_map(|id| scene.meshes[id].positions.first());
        let origin = origin.copied().unwrap_or(Vec3::ZERO);
        let windings: Vec<Option<Winding>> =
            meshes.map(|mesh| mesh.map(|id| winding(id, origin, scene, &mut known))).collect();
        let open = windings.iter().flatten().filter(|winding| !winding.is_closed());
        let together = open.fold(Winding::default(), Winding::and);
        enclosures.extend(group.iter().zip(&windings).map(|(object, winding)| match winding {
            Some(winding) => {
                let closed = winding.is_closed();
                let decides = if closed { winding } else { &together };
                let inside_out = decides.is_closed() && decides.volume < 0.0;
                Enclosure { closed, inside_out }
            }
            None => Enclosure { closed: is_closed_shape(&object.shape), inside_out: false },
        }));
    }
    enclosures
}

/// What the mesh of this number encloses, its positions as seen from `origin`; reckoned once.
fn winding(
    mesh: usize,
    origin: Vec3,
    scene: &Scene,
    known: &mut HashMap<(usize, [u32; 3]), Winding>,
) -> Winding {
    let key = (mesh, origin.to_array().map(f32::to_bits));
    *known.entry(key).or_insert_with(|| Winding::of(&scene.meshes[mesh], origin))
}

/// True for shapes that are no meshes and have an inside.
fn is_closed_shape(shape: &Shape) -> bool {
    match shape {
        Shape::Sphere { .. } | Shape::Box { .. } | Shape::Custom(_) => true,
        Shape::Rectangle { .. } | Shape::Disk { .. } | Shape::Mesh(_) => false,
    }
}

/// The number of the mesh of an object that light can go into.
fn glass_mesh(object: &Object, scene: &Scene) -> Option<usize> {
    let material = &scene.materials[object.material.0 as usize];
    match (&object.shape, &material.kind) {
        (Shape::Mesh(id), MaterialKind::Dielectric(_)) => Some(id.0 as usize),
        (Shape::Mesh(id), MaterialKind::Principled(p)) if p.has_inside() => Some(id.0 as usize),
        _ => None,
    }
}

/// What the triangles of a mesh enclose, and how far they do.
#[derive(Clone, Copy, Debug, Default)]
struct Winding {
    /// Six times the volume.
    volume: f64,
    /// Twice the areas as vectors, added up: zero for a closed mesh.
    area: DVec3,
    /// Twice their lengths, added up.
    area_sum: f64,
}

impl Winding {
    /// Of a mesh, its positions as seen from `origin`. Triangles that are no numbers do not count.
    fn of(mesh: &Mesh, origin: Vec3) -> Self {
        mesh.triangles.iter().fold(Self::default(), |sum, t| {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize].as_dvec3() - origin.as_dvec3());
            let cross = (b - a).cross(c - a);
            let one = Self { volume: a.dot(cross), area: cross, area_sum: cross.length() };
            if cross.is_finite() { sum.and(&one) } else { sum }
        })
    }

    fn and(self, other: &Self) -> Self {
        Self {
            volume: self.volume + other.volume,
            area: self.area + other.area,
            area_sum: self.area_sum + other.area_sum,
        }
    }

    fn is_closed(&self) -> bool {
        self.area.length() < 0.1 * self.area_sum
    }
}
