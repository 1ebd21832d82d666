//! Brushed surfaces are scratched along the directions that texture coordinates and pictures tell.

mod common;

use common::{mean, render, small};
use rutilant::bsdf;
use rutilant::camera::Orthographic;
use rutilant::color::Rgb;
use rutilant::geom::{Transform, Vec2, Vec3, real};
use rutilant::light::Light;
use rutilant::material::{Principled, PrincipledTextures};
use rutilant::scene::{Scene, TextureId};
use rutilant::settings::Settings;
use rutilant::shape::{Mesh, Object, Shape};
use rutilant::texture::{Bitmap, Channel, Encoding, ImageTexture, Texels};

/// Where light comes from.
const LIGHT: Vec3 = Vec3::new(0.36, 0.48, 0.8);

fn brushed() -> Principled {
    Principled {
        base_color: Rgb::new(0.9, 0.6, 0.3),
        metallic: 1.0,
        roughness: 0.3,
        anisotropy: 0.8,
        ..Principled::default()
    }
}

/// What the middle of a shape sends along z to the eye, of light from [`LIGHT`].
fn sent(metal: Principled, textures: &[[f32; 3]], shape: &Looks, place: Transform) -> f64 {
    let camera = Orthographic::look_at(3.0 * Vec3::Z, Vec3::ZERO, 1e-4).unwrap();
    let mut scene = Scene::new(camera);
    scene.lights.push(Light::Directional {
        direction: -LIGHT,
        irradiance: Rgb::WHITE,
        group: None,
    });
    for texel in textures {
        let bitmap = Bitmap::new(1, 1, 3, Texels::Float(texel.to_vec())).unwrap();
        let bitmap = scene.add_bitmap(bitmap);
        scene.add_texture(ImageTexture { encoding: Encoding::Linear, ..ImageTexture::new(bitmap) });
    }
    let shape = match shape {
        Looks::Shape(shape) => shape.clone(),
        Looks::Mesh(mesh) => Shape::Mesh(scene.add_mesh(mesh.clone())),
    };
    let material = scene.add_material(metal);
    scene.objects.push(Object::new(shape, material).transformed(&place));
    mean(&render(&scene, Settings { max_depth: Some(2), ..small(1) }), "G").0
}

enum Looks {
    Shape(Shape),
    Mesh(Mesh),
}

/// A square at right angles to z, whose u grows along `u` and whose v along `v`.
fn square(u: Vec2, v: Vec2) -> Mesh {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    Mesh {
        positions: corners.map(|[x, y]| Vec3::new(x, y, 0.0)).to_vec(),
        normals: vec![Vec3::Z; 4],
        uvs: corners.map(|at| Vec2::new(u.dot(at.into()), v.dot(at.into()))).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

/// What a surface with the tangent `u` and the bitangent `v` sends along its normal z.
fn expected(metal: &Principled, u: Vec3, v: Vec3) -> f64 {
    let wi = Vec3::new(u.dot(LIGHT), v.dot(LIGHT), LIGHT.z);
    let value = bsdf::Principled::new(metal.parameters()).eval_cos_pdf(Vec3::Z, wi).0;
    f64::from(value.channels()[1])
}

fn assert_near(found: f64, expected: f64, what: &str) {
    assert!((found / expected - 1.0).abs() < 2e-3, "{what}: {found}, expected {expected}");
}

fn turned(degrees: f32) -> (Vec2, Vec2) {
    let turn = Vec2::from_angle(degrees.to_radians());
    (turn, turn.perp())
}

/// The tangent of scratches is where u grows, on meshes with and without tangents, however their
/// picture lies, mirrored ones and mirrored places; and so it is on rectangles, disks and spheres.
#[test]
fn scratches_follow_texture_coordinates() {
    let metal = brushed();
    // A frame that is not turned would be off by a factor.
    let [along, across] = [0.0, 90.0].map(|degrees| {
        let (u, v) = turned(degrees);
        expected(&metal, u.extend(0.0), v.extend(0.0))
    });
    assert!((along / across).max(across / along) > 1.3, "{along} {across}");

    for degrees in [0.0, 30.0, 90.0, 200.0] {
        let (u, v) = turned(degrees);
        for v in [v, -v] {
            for mirrored in [false, true] {
                let place = Vec3::new(if mirrored { -1.0 } else { 1.0 }, 1.0, 1.0);
                for with_tangents in [false, true] {
                    let mesh = square(u, v);
                    let mesh = if with_tangents { mesh.with_tangents(0) } else { mesh };
                    let what = format!("{u} {v} {mirrored} {with_tangents}");
                    let found = sent(metal, &[], &Looks::Mesh(mesh), Transform::scale(place));
                    let [u, v] = [u, v].map(|w| w.extend(0.0) * place);
                    assert_near(found, expected(&metal, u, v), &what);
                }
            }
        }
    }
    let usual = expected(&metal, Vec3::X, Vec3::Y);
    for (what, shape, height) in [
        ("rectangle", Shape::Rectangle { size: Vec2::ONE }, 0.0),
        ("box", Shape::Box { size: Vec3::ONE }, 0.0),
        ("disk", Shape::Disk { radius: 1.0 }, 0.0),
        ("sphere", Shape::Sphere { radius: 1.0 }, -1.0),
    ] {
        let place = Transform::translate(height * Vec3::Z);
        assert_near(sent(metal, &[], &Looks::Shape(shape), place), usual, what);
    }
}

/// The rotation turns the tangent from u towards v, also where the picture is mirrored; so does a
/// picture of directions, before the rotation, and one of strengths is a factor.
#[test]
fn pictures_turn_scratches() {
    let (u, v) = turned(25.0);
    let bits = |w: f32| 0.5 * w + 0.5;
    for v in [v, -v] {
        for (rotation, direction) in [(0.7, None), (0.0, Some(1.1_f32)), (0.7, Some(1.1))] {
            let turn = rotation + direction.unwrap_or(0.0);
            let (s, c) = real::sin_cos(turn);
            let texel = direction.map(|angle| {
                let (s, c) = real::sin_cos(angle);
                [bits(c), bits(s), 0.5]
            });
            let mut metal = Principled { anisotropy_rotation: rotation, ..brushed() };
            let mut plain = brushed();
            let mut textures = vec![];
            if let Some(texel) = texel {
                let id = TextureId(0);
                metal.textures = PrincipledTextures {
                    anisotropy: Some((id, Channel::Blue)),
                    anisotropy_direction: Some(id),
                    ..PrincipledTextures::default()
                };
                plain.anisotropy *= 0.5;
                textures.push(texel);
            }
            let found = sent(metal, &textures, &Looks::Mesh(square(u, v)), Transform::IDENTITY);
            let (along, across) = (u * c + v * s, v * c - u * s);
            let expected = expected(&plain, along.extend(0.0), across.extend(0.0));
            assert_near(found, expected, &format!("{v} {rotation} {direction:?}"));
        }
    }
}
