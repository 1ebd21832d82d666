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
    /// How many sets of texture coordinates; none where there are no textures.
    sets: usize,
    bumps: bool,
}

/// One note at most on each material and each thing that some of its shapes lack.
pub(super) fn notes(scene: &Scene) -> Vec<Note> {
    let mut notes = Vec::new();
    let mut asked: Vec<Asked> = scene.materials.iter().map(|m| asked(m, &scene.textures)).collect();
    for (i, material) in scene.materials.iter().enumerate() {
        let MaterialKind::Mix(mix) = &material.kind else { continue };
        let [first, second] = [mix.first, mix.second].map(|MaterialId(part)| asked[part as usize]);
        asked[i].sets = asked[i].sets.max(first.sets).max(second.sets);
        if first.bumps || second.bumps {
            let what = "bumps of the parts of a mix are not shown: it has its own normal_map";
            notes.push(Place::Material(i).note(what));
        }
    }
    for object in &scene.objects {
        let number = object.material.0 as usize;
        let wanted = &mut asked[number];
        let (sets, shows_bumps) = match &object.shape {
            Shape::Mesh(mesh) => {
                let mesh = &scene.meshes[mesh.0 as usize];
                let more = mesh.more_uvs.len();
                (if more == 0 { usize::from(!mesh.uvs.is_empty()) } else { 1 + more }, true)
            }
            Shape::Rectangle { .. } | Shape::Box { .. } => (1, true),
            Shape::Sphere { .. } | Shape::Disk { .. } | Shape::Custom(_) => (1, false),
        };
        if wanted.sets > sets {
            notes.push(Place::Material(number).note(match sets {
                0 => "a mesh has no texture coordinates for its textures: each triangle shows a half \
                      of their pictures"
                    .to_owned(),
                _ => format!(
                    "set {} of texture coordinates is missing on a shape, whose first is taken",
                    wanted.sets - 1
                ),
            }));
            wanted.sets = 0;
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
    let mut sets = 0;
    material.clone().each_texture_mut(|id| {
        sets = sets.max(1 + textures[id.0 as usize].mapping().set as usize);
    });
    Asked { sets, bumps: material.normal_map.is_some() || coat.is_some() }
}
