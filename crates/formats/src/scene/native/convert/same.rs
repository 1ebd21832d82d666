//! Whether a scene that was read is the one that was meant: bit by bit, but for the names of meshes,
//! and for the numbers of textures, pictures and meshes.

use crate::camera::AuthoredCamera;
use crate::scene::loaded::{LoadedScene, TextureName};
use crate::scene::native::placing;
use crate::shown::shown;
use rutilant::light::EnvironmentLight;
use rutilant::material::Material;
use rutilant::scene::{BitmapId, ImageId, MeshId, Scene, TextureId};
use rutilant::settings::Settings;
use rutilant::shape::{Mesh, Shape};
use rutilant::texture::{Bitmap, Texels, Texture};
use rutilant_geom::{Vec2, Vec3};
use std::collections::HashSet;
use std::fmt::Debug;

/// A scene as it was meant to be written.
pub(super) struct Meant<'m> {
    pub(super) loaded: &'m LoadedScene,
    /// In their order in the text.
    pub(super) cameras: &'m [AuthoredCamera],
    /// Under their new names.
    pub(super) materials: &'m [Material],
    /// The names of those textures that have a table.
    pub(super) textures: &'m [TextureName],
    /// The numbers of the objects in their new order.
    pub(super) objects: Vec<usize>,
}

/// What of a scene is not as it was meant, for people; `None` if it is the same.
pub(super) fn difference(read: &LoadedScene, meant: &Meant<'_>) -> Option<String> {
    let (was, is) = (&meant.loaded.scene, &read.scene);

    // How it is rendered and seen. How many samples are planned is no file's business.
    let settings = Settings { planned_spp: None, ..meant.loaded.settings.clone() };
    if !alike(&read.settings, &settings) || !alike(&read.display, &meant.loaded.display) {
        return Some("what [render] says".to_owned());
    }
    if !alike(&read.cameras.as_slice(), &meant.cameras) || !alike(&is.camera, &was.camera) {
        return Some("a camera".to_owned());
    }

    // Light.
    let without_image = |scene: &Scene| {
        let mut sky = scene.environment;
        let image = match sky.as_mut().map(|sky| &mut sky.light) {
            Some(EnvironmentLight::Image { image, .. }) => {
                Some(std::mem::replace(image, ImageId(0)))
            }
            Some(EnvironmentLight::Constant(_)) | None => None,
        };
        (sky, image)
    };
    let ((sky, image), (old_sky, old_image)) = (without_image(is), without_image(was));
    let pixels = |scene: &Scene, id: Option<ImageId>| {
        let image = &scene.images[id?.0 as usize];
        let channels = image.channels().iter();
        let channels = channels.map(|c| (c.name.clone(), bits(c.values.iter().copied())));
        Some(([image.width(), image.height()], channels.collect::<Vec<_>>()))
    };
    if !alike(&sky, &old_sky) || pixels(is, image) != pixels(was, old_image) {
        return Some("the environment".to_owned());
    }
    if is.lights.len() != was.lights.len() {
        return Some("the list of lights".to_owned());
    }
    if let Some(i) = is.lights.iter().zip(&was.lights).position(|(a, b)| !alike(a, b)) {
        return Some(format!("light {i}"));
    }

    // What things look like.
    let mut compared = Compared::default();
    for (id, name) in (0..).map(TextureId).zip(meant.textures) {
        let TextureName::Named(_) = name else { continue };
        let there = read.texture_names.iter().position(|read| read == name);
        let there = there.map(|at| TextureId(at as u32));
        if !there.is_some_and(|there| compared.textures(is, there, was, id)) {
            return Some(format!("texture {}", id.0));
        }
    }
    if is.materials.len() != meant.materials.len() {
        return Some("the list of materials".to_owned());
    }
    for (material, meant) in is.materials.iter().zip(meant.materials) {
        if !compared.materials(is, material, was, meant) {
            return Some(format!("material \"{}\"", shown(&meant.name)));
        }
    }

    // What stands where.
    if is.objects.len() != meant.objects.len() {
        return Some("the list of shapes".to_owned());
    }
    for (object, &number) in is.objects.iter().zip(&meant.objects) {
        let old = &was.objects[number];
        let same_shape = match (&object.shape, &old.shape) {
            (Shape::Mesh(a), Shape::Mesh(b)) => compared.meshes(is, *a, was, *b),
            (a, b) => alike(a, b),
        };
        let same_place = placing::is_same(&object.world_from_object, &old.world_from_object);
        let same_look = object.material == old.material && object.group == old.group;
        if !same_shape || !same_place || !same_look {
            return Some(format!("shape {number}"));
        }
    }
    None
}

/// Words in Rust have all digits of a number, and tell −0 from 0.
fn alike<T: Debug>(one: &T, other: &T) -> bool {
    format!("{one:?}") == format!("{other:?}")
}

fn bits(numbers: impl IntoIterator<Item = f32>) -> Vec<u32> {
    numbers.into_iter().map(f32::to_bits).collect()
}

/// What was found to be the same already.
#[derive(Default)]
struct Compared {
    meshes: HashSet<(MeshId, MeshId)>,
    bitmaps: HashSet<(BitmapId, BitmapId)>,
}

impl Compared {
    fn materials(&mut self, is: &Scene, one: &Material, was: &Scene, other: &Material) -> bool {
        let bare = |material: &Material| {
            let (mut bare, mut ids) = (material.clone(), Vec::new());
            bare.each_texture_mut(|id| ids.push(std::mem::replace(id, TextureId(0))));
            (bare, ids)
        };
        let ((one, ones), (other, others)) = (bare(one), bare(other));
        alike(&one, &other)
            && ones.len() == others.len()
            && ones.iter().zip(others).all(|(&one, other)| self.textures(is, one, was, other))
    }

    fn textures(&mut self, is: &Scene, one: TextureId, was: &Scene, other: TextureId) -> bool {
        let of = |scene: &Scene, id: TextureId| scene.textures.get(id.0 as usize).cloned();
        match (of(is, one), of(was, other)) {
            (Some(Texture::Image(mut one)), Some(Texture::Image(mut other))) => {
                let ids = [&mut one.bitmap, &mut other.bitmap]
                    .map(|id| std::mem::replace(id, BitmapId(0)));
                alike(&one, &other) && self.bitmaps(is, was, ids)
            }
            (Some(Texture::Checker(one)), Some(Texture::Checker(other))) => alike(&one, &other),
            (Some(Texture::Bricks(one)), Some(Texture::Bricks(other))) => alike(&one, &other),
            (Some(Texture::Noise(one)), Some(Texture::Noise(other))) => alike(&one, &other),
            (_, _) => false,
        }
    }

    fn bitmaps(&mut self, is: &Scene, was: &Scene, [one, other]: [BitmapId; 2]) -> bool {
        if self.bitmaps.contains(&(one, other)) {
            return true;
        }
        let same = match (is.bitmaps.get(one.0 as usize), was.bitmaps.get(other.0 as usize)) {
            (Some(one), Some(other)) => same_bitmaps(one, other),
            (_, _) => false,
        };
        if same {
            self.bitmaps.insert((one, other));
        }
        same
    }

    fn meshes(&mut self, is: &Scene, one: MeshId, was: &Scene, other: MeshId) -> bool {
        if self.meshes.contains(&(one, other)) {
            return true;
        }
        let same = match (is.meshes.get(one.0 as usize), was.meshes.get(other.0 as usize)) {
            (Some(one), Some(other)) => same_meshes(one, other),
            (_, _) => false,
        };
        if same {
            self.meshes.insert((one, other));
        }
        same
    }
}

fn same_bitmaps(one: &Bitmap, other: &Bitmap) -> bool {
    let size = |bitmap: &Bitmap| (bitmap.width(), bitmap.height(), bitmap.channels());
    size(one) == size(other)
        && match (one.texels(), other.texels()) {
            (Texels::Float(one), Texels::Float(other)) => same_numbers(one, other),
            (one, other) => one == other,
        }
}

fn same_numbers(one: &[f32], other: &[f32]) -> bool {
    one.len() == other.len() && one.iter().zip(other).all(|(a, b)| a.to_bits() == b.to_bits())
}

/// Bit by bit, but for the name. Sets of texture coordinates behind the last that has any say nothing.
fn same_meshes(one: &Mesh, other: &Mesh) -> bool {
    let points = |one: &[Vec3], other: &[Vec3]| {
        let same = |(a, b): (&Vec3, &Vec3)| same_numbers(&a.to_array(), &b.to_array());
        one.len() == other.len() && one.iter().zip(other).all(same)
    };
    let pairs = |one: &[Vec2], other: &[Vec2]| {
        let same = |(a, b): (&Vec2, &Vec2)| same_numbers(&a.to_array(), &b.to_array());
        one.len() == other.len() && one.iter().zip(other).all(same)
    };
    let fours = |one: &[[f32; 4]], other: &[[f32; 4]]| {
        same_numbers(one.as_flattened(), other.as_flattened())
    };
    let sets = one.more_uvs.len().max(other.more_uvs.len());
    let more = |i: usize| {
        let [one, other] = [one, other].map(|mesh| mesh.more_uvs.get(i));
        pairs(one.map_or(&[], Vec::as_slice), other.map_or(&[], Vec::as_slice))
    };
    points(&one.positions, &other.positions)
        && points(&one.normals, &other.normals)
        && pairs(&one.uvs, &other.uvs)
        && (0..sets).all(more)
        && fours(&one.tangents, &other.tangents)
        && fours(&one.colors, &other.colors)
        && one.triangles == other.triangles
}
