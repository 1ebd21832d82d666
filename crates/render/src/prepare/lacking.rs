//! What materials ask of shapes that do not have it: it is left out, and told.

use crate::id::MaterialId;
use crate::material::{Material, MaterialKind};
use crate::problem::{Note, Place};
use crate::scene::Scene;
use crate::shape::Shape;
use crate::texture::Texture;

/// What a material asks of shapes.
#[derive(Clone, Copy, Debug, Default)]
struct Asked {
    /// The highest number of a set of texture coordinates, counted from 0.
    set: u32,
    bumps: bool,
}

/// One note at most on each material and each thing that some of its shapes lack.
pub(super) fn notes(scene: &Scene) -> Vec<Note> {
    let mut asked: Vec<Asked> = scene.materials.iter().map(|m| asked(m, &scene.textures)).collect();
    for (i, material) in scene.materials.iter().enumerate() {
        let MaterialKind::Mix(mix) = &material.kind else { continue };
        let part = |MaterialId(part)| asked[part as usize].set;
        asked[i].set = asked[i].set.max(part(mix.first)).max(part(mix.second));
    }
    let mut notes = Vec::new();
    for object in &scene.objects {
        let number = object.material.0 as usize;
        let wanted = &mut asked[number];
        let (sets, shows_bumps) = match &object.shape {
            Shape::Mesh(mesh) => (1 + scene.meshes[mesh.0 as usize].more_uvs.len(), true),
            Shape::Rectangle { .. } | Shape::Box { .. } => (1, true),
            Shape::Sphere { .. } | Shape::Disk { .. } | Shape::Custom(_) => (1, false),
        };
        if wanted.set as usize >= sets {
            notes.push(Place::Material(number).note(format!(
                "set {} of texture coordinates is missing on a shape, whose first is taken",
                wanted.set
            )));
            wanted.set = 0;
        }
        if wanted.bumps && !shows_bumps {
            let what = "spheres, disks and custom shapes are shown without its bumps";
            notes.push(Place::Material(number).note(what));
            wanted.bumps = false;
        }
    }
    notes
}

fn asked(material: &Material, textures: &[Texture]) -> Asked {
    let coat = match &material.kind {
        MaterialKind::Principled(layers) => layers.coat_normal_map,
        MaterialKind::Black
        | MaterialKind::Null
        | MaterialKind::Matte(_)
        | MaterialKind::Mirror(_)
        | MaterialKind::Conductor(_)
        | MaterialKind::Dielectric(_)
        | MaterialKind::ThinDielectric(_)
        | MaterialKind::Mix(_)
        | MaterialKind::Custom(_) => None,
    };
    let mut set = 0;
    material.clone().each_texture_mut(|id| set = set.max(textures[id.0 as usize].mapping().set));
    Asked { set, bumps: material.normal_map.is_some() || coat.is_some() }
}
