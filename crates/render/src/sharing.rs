//! Which objects are instances of a mesh that is stored once, and which are copied into the world.
//!
//! A copy takes some 90 bytes for each triangle; an instance takes some 150 for the whole mesh, and
//! a ray that comes to one has to be mapped into the mesh's space first. So meshes that need few
//! copies are copied, as long as all copies together are few; the rest is stored once. The scene
//! alone decides, and no picture changes by a bit.

use crate::scene::Scene;
use crate::shape::{Mesh, Object, Shape};
use rutilant_geom::instance::can_be_shared;
use rutilant_geom::{Aabb, Instance, Vec3};

/// A mesh of fewer triangles is always copied: as an instance it would save little, and rays would
/// spend more on the way into it than in it.
const FEW: usize = 16;

/// For each object whether it is an instance, where meshes that stand in several places may be
/// copied as long as these copies have no more than so many triangles. For a scene whose ids lead
/// somewhere.
pub(crate) fn instances(scene: &Scene, copies: u32) -> Vec<bool> {
    // How often each mesh stands, and how many triangles its copies would have.
    let mut places = vec![0_u64; scene.meshes.len()];
    for id in scene.objects.iter().filter_map(mesh_of) {
        places[id] += 1;
    }
    let copied = |id: usize| (places[id] - 1) * scene.meshes[id].triangles.len() as u64;
    let several = |id: &usize| places[*id] > 1 && scene.meshes[*id].triangles.len() >= FEW;
    let mut candidates: Vec<usize> = (0..scene.meshes.len()).filter(several).collect();
    candidates.sort_by_key(|id| copied(*id));

    // Those that need fewest copies are copied.
    let mut left = u64::from(copies);
    let mut bounds = vec![None; scene.meshes.len()];
    for id in candidates {
        match left.checked_sub(copied(id)) {
            Some(less) => left = less,
            None => bounds[id] = shareable(&scene.meshes[id]),
        }
    }
    let is_instance = |object: &Object| {
        let bounds = mesh_of(object).and_then(|id| bounds[id]);
        bounds.is_some_and(|b| Instance::can_place(&object.world_from_object, &b))
    };
    scene.objects.iter().map(is_instance).collect()
}

/// The place of an object's mesh among all.
fn mesh_of(object: &Object) -> Option<usize> {
    match object.shape {
        Shape::Mesh(id) => Some(id.0 as usize),
        Shape::Sphere { .. }
        | Shape::Rectangle { .. }
        | Shape::Disk { .. }
        | Shape::Box { .. }
        | Shape::Custom(_) => None,
    }
}

/// The box around a mesh, if it can be stored once.
fn shareable(mesh: &Mesh) -> Option<Aabb> {
    let finite = |p: &Vec3| p.is_finite();
    let bounds = Aabb::around(mesh.positions.iter().copied().filter(finite));
    (can_be_shared(&mesh.positions) && !bounds.is_empty()).then_some(bounds)
}
