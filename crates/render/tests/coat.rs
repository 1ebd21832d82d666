//! A coat has normals of its own: it lies smoothly over bumps, or is bumpy over what is smooth.

mod common;

use common::{mean, render, small};
use rutilant::bsdf;
use rutilant::camera::Orthographic;
use rutilant::color::Rgb;
use rutilant::geom::{Frame, Vec2, Vec3, real};
use rutilant::light::{Environment, Light};
use rutilant::material::{Bumps, Material, NormalMap, Principled};
use rutilant::scene::{Scene, TextureId};
use rutilant::settings::Settings;
use rutilant::shape::{Object, Shape};
use rutilant::texture::{Bitmap, Encoding, ImageTexture, Texels};

/// Where light comes from.
const LIGHT: Vec3 = Vec3::new(0.48, 0.36, 0.8);

/// A normal that leans by this towards x.
fn leaning(degrees: f32) -> Vec3 {
    let (s, c) = real::sin_cos(degrees.to_radians());
    Vec3::new(s, 0.0, c)
}

/// A square of this material, seen from `wo`; its textures are maps of these normals.
fn scene(material: Material, normals: &[Vec3], wo: Vec3) -> Scene {
    let camera = Orthographic::look_at(3.0 * wo, Vec3::ZERO, 1e-2).unwrap();
    let mut scene = Scene::new(camera);
    for normal in normals {
        let texel = (0.5 * *normal + 0.5).to_array().to_vec();
        let bitmap = scene.add_bitmap(Bitmap::new(1, 1, 3, Texels::Float(texel)).unwrap());
        scene.add_texture(ImageTexture { encoding: Encoding::Linear, ..ImageTexture::new(bitmap) });
    }
    let material = scene.add_material(material);
    scene.objects.push(Object::new(Shape::Rectangle { size: Vec2::splat(2.0) }, material));
    scene
}

fn map(texture: u32) -> Option<NormalMap> {
    Some(NormalMap { texture: TextureId(texture), scale: 1.0, shows: Bumps::Normals })
}

/// Under a directional light every layer shines as it does on a surface that leans as its own map
/// says: a black body under a coat by the coat's map alone, whatever the other one is, and metal
/// below by the other one, dimmed by what the coat takes in its own frame.
#[test]
fn each_layer_has_its_own_normal() {
    let coat = Principled {
        base_color: Rgb::BLACK,
        specular: 0.0,
        coat: 1.0,
        coat_roughness: 0.5,
        ..Principled::default()
    };
    let wo = leaning(-20.0);
    let sent = |layers: &Principled, normal: Vec3| {
        let frame = Frame::around(normal);
        let bsdf = bsdf::Principled::new(layers.parameters());
        let (wo, wi) = (frame.to_local(wo), frame.to_local(LIGHT));
        f64::from(bsdf.eval_cos_pdf(wo, wi).0.channels()[1])
    };
    let (base, own) = (leaning(15.0), leaning(-8.0));
    for coat_normal_map in [None, map(1)] {
        let coat_normal = if coat_normal_map.is_some() { own } else { Vec3::Z };
        for normal_map in [None, map(0)] {
            let normal = if normal_map.is_some() { base } else { Vec3::Z };
            let found = |layers: Principled| {
                let layers = Principled { coat_normal_map, ..layers };
                let mut scene = scene(Material { normal_map, ..layers.into() }, &[base, own], wo);
                scene.lights.push(Light::Directional {
                    direction: -LIGHT,
                    irradiance: Rgb::WHITE,
                    group: None,
                });
                mean(&render(&scene, Settings { max_depth: Some(2), ..small(1) }), "G").0
            };
            let what = format!("{coat_normal} over {normal}");
            let (seen, expected) = (found(coat), sent(&coat, coat_normal));
            assert!((seen / expected - 1.0).abs() < 2e-3, "{what}: {seen}, expected {expected}");

            // Metal below: less what the coat takes on the way out.
            let bare = Principled { metallic: 1.0, base_color: Rgb::WHITE, coat: 0.0, ..coat };
            let taken = {
                let cos = coat_normal.dot(wo);
                let up = Vec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
                let white = bsdf::Principled::new(coat.parameters());
                f64::from(albedo(&white, up))
            };
            let (seen, expected) = (
                found(Principled { coat: 1.0, ..bare }) - sent(&coat, coat_normal),
                sent(&bare, normal) * (1.0 - taken),
            );
            assert!((seen / expected - 1.0).abs() < 0.02, "{what}: {seen}, expected {expected}");
        }
    }
}

/// The part of light that is sent to `wo`, by samples.
fn albedo(layers: &bsdf::Principled, wo: Vec3) -> f32 {
    const SAMPLES: u64 = 20_000;
    let drawn = (0..SAMPLES).filter_map(|i| {
        let (choice, u) = common::well_spread(i);
        Some(layers.sample(wo, choice, u)?.weight.channels()[1])
    });
    drawn.sum::<f32>() / SAMPLES as f32
}

/// A coat over black bumps shines as it does over a plane, also where light comes from below the
/// plane that a bump describes.
#[test]
fn a_coat_shines_the_same_over_bumps() {
    for coat_roughness in [0.0, 0.1, 0.3] {
        for degrees in [0.0, 30.0, 45.0] {
            for wo in [leaning(degrees), leaning(-degrees)] {
                let seen = |normal_map| {
                    let layers = Principled {
                        base_color: Rgb::BLACK,
                        specular: 0.0,
                        coat: 1.0,
                        coat_roughness,
                        ..Principled::default()
                    };
                    let material = Material { normal_map, ..layers.into() };
                    let mut scene = scene(material, &[leaning(53.0)], wo);
                    scene.environment = Some(Environment::constant(Rgb::WHITE));
                    mean(&render(&scene, small(256)), "G")
                };
                let ((flat, flat_error), (bumpy, error)) = (seen(None), seen(map(0)));
                let error = 1e-5 + 4.0 * (error * error + flat_error * flat_error).sqrt();
                let what =
                    format!("{coat_roughness} {wo}: {bumpy} ± {error}, {flat} without bumps");
                assert!((bumpy - flat).abs() < error, "{what}");
            }
        }
    }
}

/// White bumps under a clear coat send back nearly all light, from wherever they are seen, and no
/// more than there is: no black halos where both normals part.
#[test]
fn bumps_under_a_coat_stay_white() {
    for coat_roughness in [0.0, 0.3] {
        for degrees in [0.0, 40.0, 70.0, 85.0] {
            for (normals, maps) in [
                ([leaning(25.0), Vec3::Z], [map(0), None]),
                ([Vec3::Z, leaning(-25.0)], [None, map(1)]),
                ([leaning(25.0), leaning(-20.0)], [map(0), map(1)]),
            ] {
                let coated = Principled {
                    base_color: Rgb::WHITE,
                    coat: 1.0,
                    coat_roughness,
                    coat_normal_map: maps[1],
                    ..Principled::default()
                };
                let thin = Principled { thin_walled: true, ..coated };
                for (base, layers) in [
                    ("metal", Principled { metallic: 1.0, roughness: 0.1, ..coated }),
                    ("paper", Principled { specular: 0.0, diffuse_transmission: 0.7, ..thin }),
                    ("pane", Principled { transmission: 1.0, roughness: 0.3, ..thin }),
                    ("clear pane", Principled { transmission: 1.0, roughness: 0.0, ..thin }),
                ] {
                    let material = Material { normal_map: maps[0], ..layers.into() };
                    for wo in [leaning(degrees), leaning(-degrees)] {
                        let mut scene = scene(material.clone(), &normals, wo);
                        scene.environment = Some(Environment::constant(Rgb::WHITE));
                        let (seen, error) = mean(&render(&scene, small(64)), "G");
                        let what =
                            format!("{base} {coat_roughness} {maps:?} {wo}: {seen} ± {error}");
                        assert!(seen < 1.001 + 4.0 * error && seen > 0.97 - 4.0 * error, "{what}");
                    }
                }
            }
        }
    }
}
