//! What the gloss of a principled surface is told to reflect.

mod common;

use common::{render, small};
use rutilant::camera::Orthographic;
use rutilant::color::Rgb;
use rutilant::geom::{Vec2, Vec3};
use rutilant::light::Environment;
use rutilant::material::{MAX_SPECULAR_COLOR, Principled, PrincipledTextures};
use rutilant::scene::Scene;
use rutilant::settings::Settings;
use rutilant::shape::{Object, Shape};
use rutilant::texture::{Bitmap, ImageTexture, Texels};

/// A smooth black surface under a white sky, seen straight on, where a picture of `texel` is a factor
/// on the specular colour.
fn seen(layers: Principled, texel: f32) -> [f32; 3] {
    let camera = Orthographic::look_at(3.0 * Vec3::Z, Vec3::ZERO, 1.0).unwrap();
    let mut scene = Scene::new(camera);
    scene.environment = Some(Environment::constant(Rgb::WHITE));
    let bitmap = scene.add_bitmap(Bitmap::new(1, 1, 1, Texels::Float(vec![texel])).unwrap());
    let specular_color = Some(scene.add_texture(ImageTexture::new(bitmap)));
    let textures = PrincipledTextures { specular_color, ..PrincipledTextures::default() };
    let layers = Principled { base_color: Rgb::BLACK, roughness: 0.0, textures, ..layers };
    let material = scene.add_material(layers);
    scene.objects.push(Object::new(Shape::Rectangle { size: Vec2::splat(20.0) }, material));
    render(&scene, Settings { size: [1, 1], ..small(16) }).rgb().unwrap()[0]
}

/// Straight on a dielectric reflects min(((n − 1)/(n + 1))² c, 1) w: `KHR_materials_specular`. Colours
/// above 1 are no less than they say, their pictures count before they are bounded, and nothing
/// reflects more than there is.
#[test]
fn specular_colours_exceed_one() {
    for (ior, color, texel, weight) in [
        (1.5_f32, Rgb::new(1.184, 5.441, 13.276), 1.0_f32, 1.0_f32),
        (1.5, Rgb::new(25.0, 26.0, 1000.0), 1.0, 1.0),
        (1.5, Rgb::new(4.0, 10.0, 40.0), 0.5, 0.7),
        (1.5, Rgb::new(1.0, 0.5, 0.0), 7.0, 1.0),
        (1.1, Rgb::grey(100.0), 1.0, 1.0),
        (1.003, Rgb::grey(MAX_SPECULAR_COLOR), 1e18, 0.5),
        (1.0, Rgb::grey(MAX_SPECULAR_COLOR), 1.0, 1.0),
    ] {
        let layers =
            Principled { ior, specular_color: color, specular: weight, ..Principled::default() };
        let normal = (ior - 1.0) / (ior + 1.0);
        let expected = color.0.map(|c| (normal * normal * c * texel).min(1.0) * weight);
        let found = seen(layers, texel);
        for (found, expected) in found.into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-4, "{ior} {color:?}: {found}, not {expected}");
        }
    }
}
