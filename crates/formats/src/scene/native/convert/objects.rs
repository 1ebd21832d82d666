//! Which objects of a scene one `[[shape]]` places.
//!
//! A mesh that stands in many places is one shape with instances, whatever stands between them in
//! the list. Lamps keep their order, because the numbers of lamps decide which random number
//! chooses which; so pictures keep their bits. Other shapes are taken together only where many
//! follow each other.

use rutilant::light::LightGroup;
use rutilant::scene::{MaterialId, Scene};
use rutilant::shape::Shape;
use std::collections::HashMap;

/// From so many on, shapes that are no meshes are instances of one.
const MANY: usize = 4;

/// The kind of a shape, the bits of its sizes, its material, and its light group: what one
/// `[[shape]]` says of all its places.
type Key = (u8, [u32; 3], MaterialId, Option<LightGroup>);

/// The numbers of objects that are to be placed by one shape each, in the order in which they are to
/// be written. Custom shapes are left out.
pub(super) fn grouped(scene: &Scene) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    let mut latest: HashMap<Key, usize> = HashMap::new();
    let (mut previous, mut glowing) = (None, None);
    for (i, object) in scene.objects.iter().enumerate() {
        let bits = f32::to_bits;
        let (is_mesh, kind, sizes) = match &object.shape {
            Shape::Mesh(id) => (true, 0, [id.0, 0, 0]),
            Shape::Sphere { radius } => (false, 1, [bits(*radius), 0, 0]),
            Shape::Rectangle { size } => (false, 2, [bits(size.x), bits(size.y), 0]),
            Shape::Disk { radius } => (false, 3, [bits(*radius), 0, 0]),
            Shape::Box { size } => (false, 4, size.to_array().map(bits)),
            Shape::Custom(_) => continue,
        };
        let material = scene.materials.get(object.material.0 as usize);
        let glows = material.is_some_and(|material| material.emission.is_some());
        let key = (kind, sizes, object.material, object.group);
        let known = latest.get(&key).copied().filter(|&group| {
            let follows = previous == Some(group);
            follows || (is_mesh && (!glows || glowing == Some(group)))
        });
        let group = known.unwrap_or_else(|| {
            groups.push(Vec::new());
            groups.len() - 1
        });
        groups[group].push(i);
        latest.insert(key, group);
        previous = Some(group);
        if glows {
            glowing = Some(group);
        }
    }
    let is_mesh = |i: &usize| matches!(scene.objects[*i].shape, Shape::Mesh(_));
    groups
        .into_iter()
        .flat_map(|group| {
            if group.len() < MANY && !group.iter().all(is_mesh) {
                group.into_iter().map(|i| vec![i]).collect()
            } else {
                vec![group]
            }
        })
        .collect()
}
