//! What is painted on a surface is what it sends back.

mod common;

use common::{mean, render, small};
use rutilant::Prepared;
use rutilant::camera::{Orthographic, Perspective};
use rutilant::color::Rgb;
use rutilant::film::Filter;
use rutilant::geom::{BuildOptions, Ray, Transform, Vec2, Vec3, real};
use rutilant::image::Image;
use rutilant::light::{Environment, Light};
use rutilant::material::{
    Bumps, Emission, Material, MaterialKind, Matte, Mirror, Mix, NormalMap, Opacity, OpacityMode,
    Principled, PrincipledTextures,
};
use rutilant::scene::{MaterialId, Scene, TextureId};
use rutilant::settings::{IntegratorKind, LightSelection, Settings, Strategy};
use rutilant::shape::{Mesh, Object, Shape};
use rutilant::texture::{
    Bitmap, Bricks, Channel, Checker, ColorInput, Encoding, ImageTexture, Interpolation, Noise,
    ScalarInput, Texels, Texture, UvMapping, Wrap,
};
use std::sync::Arc;

/// Under a white sky, looked at along −z, two metres wide and high.
fn scene() -> Scene {
    let camera = Orthographic::look_at(3.0 * Vec3::Z, Vec3::ZERO, 2.0).unwrap();
    let mut scene = Scene::new(camera);
    scene.environment = Some(Environment::constant(Rgb::WHITE));
    scene
}

/// Four pixels: red and green above, blue and white below.
fn colors(scene: &mut Scene) -> ImageTexture {
    let codes = vec![255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255];
    let bitmap = scene.add_bitmap(Bitmap::new(2, 2, 3, Texels::Eight(codes)).unwrap());
    ImageTexture { interpolation: Interpolation::Nearest, ..ImageTexture::new(bitmap) }
}

const SQUARE: Shape = Shape::Rectangle { size: Vec2::splat(2.0) };

fn show(scene: &mut Scene, shape: Shape, texture: TextureId) -> Image {
    let material = scene.add_material(Matte::new(texture));
    scene.objects.push(Object::new(shape, material));
    picture(scene)
}

fn picture(scene: &Scene) -> Image {
    render(scene, Settings { size: [2, 2], filter: PIXEL, ..small(64) })
}

/// A pixel is the mean of itself.
const PIXEL: Filter = Filter::Box { radius: 0.5 };

/// The pixels as colours, rounded to tenths.
fn tenths(image: &Image) -> Vec<[i32; 3]> {
    let pixels = image.rgb().unwrap();
    pixels.iter().map(|p| p.map(|c| (c * 10.0).round() as i32)).collect()
}

const RED: [i32; 3] = [10, 0, 0];
const GREEN: [i32; 3] = [0, 10, 0];
const BLUE: [i32; 3] = [0, 0, 10];
const WHITE: [i32; 3] = [10; 3];

/// A convex white surface under a white sky shows its albedo: each quarter of a square has its
/// pixel's colour, upright and not mirrored, on rectangles, boxes and meshes alike.
#[test]
fn pictures_stand_upright() {
    let expected = vec![RED, GREEN, BLUE, WHITE];
    for shape in [SQUARE, Shape::Box { size: Vec3::splat(2.0) }] {
        let mut scene = scene();
        let image = colors(&mut scene);
        let texture = scene.add_texture(image);
        assert_eq!(tenths(&show(&mut scene, shape, texture)), expected);
    }
    // A mirrored square shows a mirrored picture.
    let mut scene = scene();
    let image = colors(&mut scene);
    let texture = scene.add_texture(image);
    let material = scene.add_material(Matte::new(texture));
    let mirrored = Transform::scale(Vec3::new(-1.0, 1.0, 1.0));
    scene.objects.push(Object::new(SQUARE, material).transformed(&mirrored));
    assert_eq!(tenths(&picture(&scene)), [GREEN, RED, WHITE, BLUE]);
}

/// Scale, then turn, then move: what KHR_texture_transform says, with v upwards.
#[test]
fn mappings_move_the_picture() {
    let cases: [(UvMapping, [[i32; 3]; 4]); 3] = [
        (
            UvMapping { offset: Vec2::new(0.5, 0.0), ..UvMapping::default() },
            [GREEN, RED, WHITE, BLUE],
        ),
        (
            UvMapping { scale: Vec2::new(1.0, -1.0), ..UvMapping::default() },
            [BLUE, WHITE, RED, GREEN],
        ),
        // (u, v) becomes (−v, u): the lower right pixel, around (3/4, 1/4), shows what is around
        // (−1/4, 3/4), and once more around (3/4, 3/4).
        (
            UvMapping { rotation: std::f32::consts::FRAC_PI_2, ..UvMapping::default() },
            [BLUE, RED, WHITE, GREEN],
        ),
    ];
    for (mapping, expected) in cases {
        let mut scene = scene();
        let image = colors(&mut scene);
        let texture = scene.add_texture(ImageTexture { mapping, ..image });
        let shown = tenths(&show(&mut scene, SQUARE, texture));
        assert_eq!(shown, expected, "{mapping:?}");
    }
}

/// Codes are sRGB for colours and linear for numbers: 188 is half of the light, or 0.737.
#[test]
fn codes_are_decoded() {
    for (encoding, expected) in [(Encoding::Srgb, 0.5029), (Encoding::Linear, 188.0 / 255.0)] {
        for texels in
            [Texels::Eight(vec![188]), Texels::Sixteen(vec![188 * 257]), Texels::Float(vec![0.0])]
        {
            let expected = if matches!(texels, Texels::Float(_)) { 0.0 } else { expected };
            let mut scene = scene();
            let bitmap = scene.add_bitmap(Bitmap::new(1, 1, 1, texels).unwrap());
            let texture = scene.add_texture(ImageTexture { encoding, ..ImageTexture::new(bitmap) });
            let (value, _) = mean(&show(&mut scene, SQUARE, texture), "G");
            assert!((value - expected).abs() < 1e-3, "{value} {expected}");
        }
    }
}

/// Whatever a picture holds, no surface sends back more light than it gets, and what is no number
/// sends back none.
#[test]
fn no_surface_makes_light() {
    let values = vec![7.0, -3.0, f32::NAN, f32::INFINITY];
    let mut scene = scene();
    let bitmap = scene.add_bitmap(Bitmap::new(2, 2, 1, Texels::Float(values)).unwrap());
    let interpolation = Interpolation::Nearest;
    let texture = scene.add_texture(ImageTexture { interpolation, ..ImageTexture::new(bitmap) });
    let shown = show(&mut scene, SQUARE, texture);
    assert_eq!(tenths(&shown), [WHITE, [0; 3], [0; 3], [0; 3]]);
    let notes = Prepared::new(&scene).unwrap().report().notes.clone();
    let note = notes.iter().map(ToString::to_string).find(|n| n.contains("texture 0"));
    assert_eq!(note.unwrap(), "texture 0: 2 of its values, above 1e18 or no numbers, count as 0");
    // However many textures show the picture, it is told once.
    for encoding in [Encoding::Srgb, Encoding::Linear] {
        for wrap in [Wrap::Mirror, Wrap::Clamp] {
            let wrap = [wrap; 2];
            scene.add_texture(ImageTexture { encoding, wrap, ..ImageTexture::new(bitmap) });
        }
    }
    assert_eq!(Prepared::new(&scene).unwrap().report().notes, notes);
}

/// A channel's inverse is what it lacks to 1: a veil by it lets through what one by the channel stops.
#[test]
fn channels_have_inverses() {
    let channels = [
        (Channel::Red, Channel::InverseRed, 0.2),
        (Channel::Green, Channel::InverseGreen, 0.4),
        (Channel::Blue, Channel::InverseBlue, 0.7),
        (Channel::Alpha, Channel::InverseAlpha, 0.9),
    ];
    for (channel, inverse, value) in channels {
        for (channel, there) in [(channel, value), (inverse, 1.0 - value)] {
            let mut scene = scene();
            let texels = Texels::Float(vec![0.2, 0.4, 0.7, 0.9]);
            let bitmap = scene.add_bitmap(Bitmap::new(1, 1, 4, texels).unwrap());
            let texture = Some((scene.add_texture(ImageTexture::new(bitmap)), channel));
            let amount = ScalarInput { factor: 1.0, texture };
            for (cutoff, seen) in [(there - 1e-3, 0.0), (there + 1e-3, 1.0)] {
                let mode = OpacityMode::Mask { cutoff };
                let opacity = Some(Opacity { amount, vertex_colors: false, mode });
                let black = Material { opacity, ..Material::new(MaterialKind::Black) };
                scene.materials = vec![black];
                scene.objects = vec![Object::new(SQUARE, MaterialId(0))];
                let (value, _) = mean(&picture(&scene), "G");
                assert!((value - seen).abs() < 1e-6, "{channel:?} {cutoff}: {value}");
            }
        }
    }
}

/// What a material has no texture for is told at the key that names it.
#[test]
fn missing_textures_are_told_where_they_are_named() {
    let gone = TextureId(7);
    let red = Some((gone, Channel::Red));
    let none = PrincipledTextures::default();
    for (key, textures) in [
        ("base_color", PrincipledTextures { base_color: Some(gone), ..none }),
        ("sheen_color", PrincipledTextures { sheen_color: Some(gone), ..none }),
        ("anisotropy_direction", PrincipledTextures { anisotropy_direction: Some(gone), ..none }),
        ("roughness", PrincipledTextures { roughness: red, ..none }),
        ("coat_roughness", PrincipledTextures { coat_roughness: red, ..none }),
        ("iridescence_thickness_nm", PrincipledTextures { iridescence_thickness_nm: red, ..none }),
    ] {
        let mut scene = scene();
        scene.add_material(Principled { textures, ..Principled::default() });
        let problem = scene.validate().unwrap_err();
        assert_eq!((problem.key, &*problem.what), (key, "there is no texture number 7"));
    }
}

/// A board so fine that thousands of squares fall in a pixel is an even grey, in the first sample:
/// its average was made beforehand, as light and not as codes.
#[test]
fn what_is_finer_than_a_pixel_is_averaged() {
    let mut scene = scene();
    let codes = (0..256_u32).flat_map(|y| (0..256).map(move |x| ((x + y) % 2) as u8 * 255));
    let bitmap = Bitmap::new(256, 256, 1, Texels::Eight(codes.collect())).unwrap();
    let bitmap = scene.add_bitmap(bitmap);
    let mapping = UvMapping { scale: Vec2::splat(40.0), ..UvMapping::default() };
    let texture = scene.add_texture(ImageTexture { mapping, ..ImageTexture::new(bitmap) });
    let material = scene.add_material(Matte::new(texture));
    scene.objects.push(Object::new(SQUARE, material));
    let settings = Settings { size: [16, 16], spp: 1, filter: PIXEL, ..Settings::default() };
    let settings = Settings { integrator: IntegratorKind::Albedo, ..settings };
    let image = render(&scene, settings.clone());
    for value in image.channel("G").unwrap() {
        assert!((value - 0.5).abs() < 3e-3, "{value}");
    }
    // Seen from so near that a square fills many pixels, it is black and white.
    scene.camera = Orthographic::look_at(3.0 * Vec3::Z, Vec3::ZERO, 4e-4).unwrap().into();
    let near = render(&scene, settings);
    let values = near.channel("G").unwrap();
    assert!(values.iter().any(|&v| v < 0.2) && values.iter().any(|&v| v > 0.8));
}

/// A pixel of a panorama, of a plan and of a perspective view looks at textures over half its
/// width: at twice the distance in perspective over twice as much, in a plan over as much.
#[test]
fn pixels_grow_with_distance_in_perspective() {
    let level = |camera: rutilant::camera::Camera| {
        let mut scene = scene();
        scene.camera = camera;
        // White for one texel in 4096: a level's texel over it holds 4^level / 4096 of white.
        let mut values = vec![0.0; 64 * 64];
        values[32 * 64 + 32] = 1.0;
        let bitmap = scene.add_bitmap(Bitmap::new(64, 64, 1, Texels::Float(values)).unwrap());
        let interpolation = Interpolation::Nearest;
        let texture =
            scene.add_texture(ImageTexture { interpolation, ..ImageTexture::new(bitmap) });
        let material = scene.add_material(Matte::new(texture));
        scene.objects.push(Object::new(SQUARE, material));
        let settings = Settings { size: [64, 64], filter: PIXEL, ..small(64) };
        let image = render(&scene, Settings { integrator: IntegratorKind::Albedo, ..settings });
        let brightest = image.channel("G").unwrap().iter().copied().fold(0.0, f32::max);
        // The brightest pixel is twice as wide, and shows a quarter of that.
        (-real::log2(brightest) / 2.0).round() as i32 - 1
    };
    let plan = |height| Orthographic::look_at(3.0 * Vec3::Z, Vec3::ZERO, height).unwrap().into();
    // A texel is 1/32 m; half a pixel of a plan `height` m high is height / 128 m.
    assert_eq!([4.0, 8.1, 16.1, 32.1].map(|height| level(plan(height))), [0, 1, 2, 3]);
    let eye = |distance: f32| {
        let height_at_one = 2.0_f32;
        let fov = 2.0 * real::atan(height_at_one / 2.0);
        Perspective::look_at(distance * Vec3::Z, Vec3::ZERO, fov).unwrap().into()
    };
    assert_eq!([2.0, 4.1, 8.2, 16.4].map(|distance| level(eye(distance))), [0, 1, 2, 3]);
}

/// Colours of vertices are interpolated between them, and count where the material says so.
#[test]
fn vertices_have_colours() {
    let mut scene = scene();
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let mesh = scene.add_mesh(Mesh {
        positions: corners.map(|[x, y]| Vec3::new(x, y, 0.0)).to_vec(),
        colors: [0.0, 1.0, 1.0, 0.0].map(|r| [r, 0.5, 0.0, 1.0]).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    });
    let albedo = ColorInput { vertex_colors: true, ..Rgb::new(0.8, 1.0, 1.0).into() };
    let material = scene.add_material(Matte::new(albedo));
    scene.objects.push(Object::new(Shape::Mesh(mesh), material));
    let [left, right] = [0, 1].map(|i| picture(&scene).rgb().unwrap()[i]);
    for (pixel, red) in [(left, 0.2), (right, 0.6)] {
        assert!((pixel[0] - red).abs() < 0.02, "{pixel:?}");
        assert!((pixel[1] - 0.5).abs() < 1e-3 && pixel[2] == 0.0, "{pixel:?}");
    }
    // Without them it is even; a mesh that has none is white.
    scene.materials[0] = Matte::new(Rgb::grey(0.5)).into();
    assert!((picture(&scene).rgb().unwrap()[0][0] - 0.5).abs() < 1e-3);
    scene.meshes[0].colors.clear();
    scene.materials[0] = Matte::new(ColorInput { vertex_colors: true, ..Rgb::WHITE.into() }).into();
    assert!((picture(&scene).rgb().unwrap()[0][2] - 1.0).abs() < 1e-3);
}

/// A lamp of coloured corners shows its colour between them, times its own: what is unlit in glTF.
/// At (x, y) of the square from (−1, −1) to (1, 1) red is (1 + x)/2 and green (1 + y)/2, so that a
/// quarter of it has a quarter or three quarters of each. 4096 samples err by 0.0023; chance alone
/// breaks a bound of five times that in no run of a million.
#[test]
fn lamps_have_the_colours_of_their_vertices() {
    let mut scene = scene();
    scene.environment = None;
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let mesh = scene.add_mesh(Mesh {
        positions: corners.map(|[x, y]| Vec3::new(x, y, 0.0)).to_vec(),
        colors: corners
            .map(|c| c.map(|c: f32| 0.5 + 0.5 * c))
            .map(|[r, g]| [r, g, 0.5, 1.0])
            .to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    });
    let own = Rgb::new(2.0, 1.0, 4.0);
    let lamp = Emission { vertex_colors: true, ..Emission::radiance(own) };
    let lamp = scene.add_material(lamp);
    scene.objects.push(Object::new(Shape::Mesh(mesh), lamp));
    let settings = Settings { size: [2, 2], filter: PIXEL, ..small(4096) };
    let found = render(&scene, settings.clone()).rgb().unwrap();
    let expected = [[0.25, 0.75], [0.75, 0.75], [0.25, 0.25], [0.75, 0.25]];
    for (pixel, [red, green]) in found.into_iter().zip(expected) {
        for (found, expected) in pixel.into_iter().zip([2.0 * red, green, 2.0]) {
            assert!((found - expected).abs() < 0.023, "{pixel:?}");
        }
    }
    // Where there are no colours they are white, and where they do not count as well.
    scene.meshes[0].colors.clear();
    assert_eq!(render(&scene, settings.clone()).rgb().unwrap()[0], own.0);
    scene.meshes[0].colors = vec![[0.0, 0.0, 0.0, 1.0]; 4];
    scene.materials[0] = Emission::radiance(own).into();
    assert_eq!(render(&scene, settings).rgb().unwrap()[0], own.0);
}

/// A second set of texture coordinates is another place on the same picture.
#[test]
fn meshes_have_several_sets_of_coordinates() {
    for (set, expected) in [(0, RED), (1, GREEN), (2, BLUE), (7, RED)] {
        let mut scene = scene();
        let image = colors(&mut scene);
        let mapping = UvMapping { set, ..UvMapping::default() };
        let texture = scene.add_texture(ImageTexture { mapping, ..image });
        let at = |u: f32, v: f32| vec![Vec2::new(u, v); 3];
        let mesh = scene.add_mesh(Mesh {
            positions: vec![Vec3::new(-9.0, -9.0, 0.0), Vec3::X * 9.0, Vec3::Y * 9.0],
            uvs: at(0.2, 0.8),
            more_uvs: vec![at(0.8, 0.8), at(0.2, 0.2)],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        });
        let shown = show(&mut scene, Shape::Mesh(mesh), texture);
        assert_eq!(tenths(&shown)[0], expected, "{set}");
    }
}

/// Where textures lie on round shapes: a sphere as a globe, a disk as a picture is cut round.
#[test]
fn round_shapes_have_coordinates() {
    let mut scene = scene();
    let matte = scene.add_material(Matte::new(Rgb::WHITE));
    scene.objects.push(Object::new(Shape::Disk { radius: 2.0 }, matte));
    let prepared = Prepared::new(&scene).unwrap();
    for (x, y) in [(0.0, 0.0), (1.9, 0.0), (-1.0, 0.5), (0.3, -1.7)] {
        let ray = Ray::new(Vec3::new(x, y, 1.0), Vec3::NEG_Z);
        let uv = prepared.uv(&prepared.closest(&ray).unwrap());
        assert!((uv - (0.5 + 0.25 * Vec2::new(x, y))).length() < 1e-6, "{uv}");
    }
    scene.objects[0].shape = Shape::Sphere { radius: 0.5 };
    let prepared = Prepared::new(&scene).unwrap();
    let hit = prepared.closest(&Ray::new(Vec3::new(0.0, 0.0, 1.0), Vec3::NEG_Z)).unwrap();
    assert!((prepared.uv(&hit) - Vec2::splat(0.5)).length() < 1e-6);
}

/// A sphere's map turns with it, and lies the other way round in a mirror.
#[test]
fn a_globe_turns() {
    let mut scene = scene();
    let matte = scene.add_material(Matte::new(Rgb::WHITE));
    let globe = Object::new(Shape::Sphere { radius: 0.5 }, matte);
    for world_from_globe in [
        Transform::rotate_degrees(Vec3::X, 90.0),
        Transform::rotate(Vec3::new(1.0, -2.0, 0.5).normalize(), 2.2),
        Transform::rotate(Vec3::Y, 0.7) * Transform::scale(Vec3::new(-2.0, 2.0, 2.0)),
    ] {
        let at = |transform: &Transform, outward: Vec3| {
            let mut scene = scene.clone();
            scene.objects.push(globe.clone().transformed(transform));
            let prepared = Prepared::new(&scene).unwrap();
            let ray = Ray::new(5.0 * outward, -outward);
            prepared.uv(&prepared.closest(&ray).unwrap())
        };
        for outward in [Vec3::new(0.1, 0.2, 0.9), Vec3::new(-0.5, 0.7, 0.3), Vec3::Z] {
            let outward = outward.normalize();
            let turned = world_from_globe.vector(outward).normalize();
            let (own, seen) = (at(&Transform::IDENTITY, outward), at(&world_from_globe, turned));
            assert!((own - seen).length() < 1e-5, "{world_from_globe:?}: {own} {seen}");
        }
    }
}

/// Part of a mix may be textured: the shares of both show.
#[test]
fn mixes_are_textured() {
    let mut scene = scene();
    let image = colors(&mut scene);
    let texture = scene.add_texture(image);
    let first = scene.add_material(Matte::new(texture));
    let second = scene.add_material(Mirror { reflectance: Rgb::WHITE });
    let mix = scene.add_material(Mix { first, second, amount: 0.5 });
    scene.objects.push(Object::new(SQUARE, mix));
    let expected = [[10, 5, 5], [5, 10, 5], [5, 5, 10], [10; 3]];
    assert_eq!(tenths(&picture(&scene)), expected);
}

/// Squares are as large as their mapping says, and a picture of albedo shows them exactly.
#[test]
fn boards_have_squares() {
    let mut scene = scene();
    let (first, second) = (Rgb::new(1.0, 0.0, 0.0), Rgb::new(0.0, 0.0, 1.0));
    let mapping = UvMapping { scale: Vec2::splat(2.0), ..UvMapping::default() };
    let texture = scene.add_texture(Checker { first, second, mapping });
    let material = scene.add_material(Matte::new(texture));
    scene.objects.push(Object::new(SQUARE, material));
    let integrator = IntegratorKind::Albedo;
    let image = render(&scene, Settings { size: [4, 4], filter: PIXEL, integrator, ..small(16) });
    let row = |first| if first { [BLUE, RED, BLUE, RED] } else { [RED, BLUE, RED, BLUE] };
    assert_eq!(tenths(&image), [true, false, true, false].map(row).concat());
}

/// Bricks lie in rows, each moved against the one below, between joints of the width that is said.
#[test]
fn bricks_lie_in_rows() {
    let mut scene = scene();
    let (first, second) = (Rgb::new(1.0, 0.0, 0.0), Rgb::new(0.0, 0.0, 1.0));
    // Two bricks wide and two high on the square; with a joint of half a brick along x, each has a
    // quarter of joint on either side.
    let mapping = UvMapping { scale: Vec2::splat(2.0), ..UvMapping::default() };
    let bricks = Bricks { first, second, joint: Vec2::new(0.5, 0.0), shift: 0.5, mapping };
    let texture = scene.add_texture(bricks);
    let material = scene.add_material(Matte::new(texture));
    scene.objects.push(Object::new(SQUARE, material));
    let integrator = IntegratorKind::Albedo;
    let image = render(&scene, Settings { size: [8, 8], filter: PIXEL, integrator, ..small(4) });
    // The lower row begins with a joint, the upper one with the second half of a brick.
    let (upper, lower) = ([BLUE, RED, RED, BLUE], [RED, BLUE, BLUE, RED]);
    let row = |row: [[i32; 3]; 4]| [row, row].concat();
    let rows = [vec![row(upper); 4], vec![row(lower); 4]].concat();
    assert_eq!(tenths(&image), rows.concat());
}

/// A rough picture of noise, of which each pixel sees much, is its mean; so is what light sampling
/// and roulette take for it.
#[test]
fn noise_fades_to_its_mean() {
    let mut scene = scene();
    let (first, second) = (Rgb::new(0.2, 0.0, 1.0), Rgb::new(0.6, 1.0, 0.0));
    let mapping = UvMapping { scale: Vec2::splat(1000.0), ..UvMapping::default() };
    let texture = scene.add_texture(Noise { first, second, octaves: 5, gain: 0.7, mapping });
    let material = scene.add_material(Matte::new(texture));
    scene.objects.push(Object::new(SQUARE, material));
    let integrator = IntegratorKind::Albedo;
    let image = render(&scene, Settings { size: [4, 4], filter: PIXEL, integrator, ..small(4) });
    assert_eq!(tenths(&image), [[4, 5, 5]; 16]);
}

/// Coordinates beyond the edges wrap as the texture says.
#[test]
fn pictures_wrap() {
    let cases = [
        (Wrap::Repeat, [RED, GREEN, BLUE, WHITE]),
        (Wrap::Clamp, [GREEN, GREEN, WHITE, WHITE]),
        (Wrap::Mirror, [GREEN, RED, WHITE, BLUE]),
    ];
    for (wrap, expected) in cases {
        let mut scene = scene();
        let image = colors(&mut scene);
        let mapping = UvMapping { offset: Vec2::X, ..UvMapping::default() };
        let texture = scene.add_texture(ImageTexture { mapping, wrap: [wrap; 2], ..image });
        assert_eq!(tenths(&show(&mut scene, SQUARE, texture)), expected, "{wrap:?}");
    }
}

/// A black veil of opacity a leaves 1 − a of the light behind it, whichever way rays go.
#[test]
fn veils_let_rays_through() {
    for (amount, mode) in [
        (0.0, OpacityMode::Blend),
        (0.3, OpacityMode::Blend),
        (1.0, OpacityMode::Blend),
        (0.3, OpacityMode::Mask { cutoff: 0.3 }),
        (0.3, OpacityMode::Mask { cutoff: 0.31 }),
    ] {
        let there = match mode {
            OpacityMode::Blend => f64::from(amount),
            OpacityMode::Mask { cutoff } => f64::from(u8::from(amount >= cutoff)),
        };
        let veil = Material {
            opacity: Some(Opacity { amount: amount.into(), vertex_colors: false, mode }),
            ..Material::new(MaterialKind::Black)
        };
        // Before a white sky, for rays from the eye …
        let mut seen = scene();
        let material = seen.add_material(veil.clone());
        let wide = Shape::Rectangle { size: Vec2::splat(9.0) };
        seen.objects.push(Object::new(wide.clone(), material));
        common::assert_mean(&render(&seen, small(256)), 1.0 - there, 4.0);

        // … and for the light that falls on a floor behind it: by light sampling, by scattered
        // rays, and by both. The camera looks between the two.
        for strategy in [Strategy::Both, Strategy::LightOnly, Strategy::BsdfOnly] {
            let mut lit = scene();
            lit.environment = None;
            let floor = lit.add_material(Matte::new(Rgb::WHITE));
            let material = lit.add_material(veil.clone());
            let lamp = lit.add_material(Emission::radiance(Rgb::WHITE));
            let at = |z| Transform::translate(z * Vec3::Z);
            lit.objects.push(Object::new(SQUARE, floor));
            let very_wide = Shape::Rectangle { size: Vec2::splat(4000.0) };
            lit.objects.push(Object::new(very_wide.clone(), material).transformed(&at(1.0)));
            let down = Transform::rotate(Vec3::X, std::f32::consts::PI);
            lit.objects.push(Object::new(very_wide, lamp).transformed(&(at(2.0) * down)));
            lit.camera = Orthographic::look_at(0.5 * Vec3::Z, Vec3::ZERO, 1.0).unwrap().into();
            let settings = Settings { strategy, max_depth: Some(2), ..small(1024) };
            common::assert_mean(&render(&lit, settings), 1.0 - there, 4.5);
        }
    }
}

/// Of three veils in one place each lets its part through, whatever they are made of and stored
/// how: for the eye, and for the light on a floor, by shadow rays and by scattered ones. Veils that
/// decide alike, or of which a ray meets only the first, let more through.
#[test]
fn veils_in_one_place_all_count() {
    let corners = [-2000.0, 2000.0].map(|x| [-2000.0, 2000.0].map(|y| Vec3::new(x, y, 0.0)));
    let faces = [[0, 2, 3], [0, 3, 1]];
    let mesh = |faces: Vec<[u32; 3]>| Mesh {
        positions: corners.concat(),
        triangles: faces,
        ..Mesh::default()
    };
    let wide = Shape::Rectangle { size: Vec2::splat(4000.0) };
    let amounts = [0.3, 0.5, 0.2];
    for kind in 0..4 {
        let add = |scene: &mut Scene, z: f32| {
            let shapes = match kind {
                0 => vec![wide.clone(); 3],
                1 => vec![Shape::Disk { radius: 2000.0 }; 3],
                2 => vec![Shape::Mesh(scene.add_mesh(mesh(faces.repeat(3))))],
                _ => vec![Shape::Mesh(scene.add_mesh(mesh(faces.to_vec()))); 3],
            };
            for (i, shape) in shapes.iter().enumerate() {
                let opacity = Some(Opacity {
                    amount: if shapes.len() == 3 { amounts[i] } else { amounts[0] }.into(),
                    vertex_colors: false,
                    mode: OpacityMode::Blend,
                });
                let material =
                    scene.add_material(Material { opacity, ..Material::new(MaterialKind::Black) });
                let place = Transform::translate(z * Vec3::Z);
                scene.objects.push(Object::new(shape.clone(), material).transformed(&place));
            }
        };
        let through = if kind == 2 { 0.7 * 0.7 * 0.7 } else { 0.7 * 0.5 * 0.8 };
        let assert_mean = |scene: &Scene, settings: Settings, expected: f64| {
            let [copies, stored] = [u32::MAX, 0].map(|copies| {
                let options = BuildOptions { copies, ..BuildOptions::default() };
                let prepared = Prepared::with_options(scene, &options).unwrap();
                common::render_prepared(prepared, settings.clone())
            });
            assert_eq!(copies.hash(), stored.hash());
            common::assert_mean(&copies, expected, 4.5);
        };
        let mut seen = scene();
        add(&mut seen, 0.0);
        assert_mean(&seen, small(256), through);
        for strategy in [Strategy::LightOnly, Strategy::BsdfOnly] {
            let mut lit = scene();
            lit.environment = None;
            let floor = lit.add_material(Matte::new(Rgb::WHITE));
            let lamp = lit.add_material(Emission::radiance(Rgb::WHITE));
            lit.objects.push(Object::new(SQUARE, floor));
            add(&mut lit, 1.0);
            let down = Transform::translate(2.0 * Vec3::Z)
                * Transform::rotate(Vec3::X, std::f32::consts::PI);
            lit.objects.push(Object::new(wide.clone(), lamp).transformed(&down));
            lit.camera = Orthographic::look_at(0.5 * Vec3::Z, Vec3::ZERO, 1.0).unwrap().into();
            let settings = Settings { strategy, max_depth: Some(2), ..small(1024) };
            assert_mean(&lit, settings, through);
        }
    }
}

/// What glows and lets rays pass hides nothing that is in the same place.
#[test]
fn a_glow_on_a_wall_hides_no_wall() {
    let mut scene = scene();
    let glow = scene.add_material(Emission::radiance(Rgb::WHITE));
    scene.materials[glow.0 as usize].kind = MaterialKind::Null;
    let wall = scene.add_material(Material::new(MaterialKind::Black));
    for material in [glow, wall] {
        scene.objects.push(Object::new(SQUARE, material));
    }
    common::assert_mean(&render(&scene, small(4)), 1.0, 0.0);
}

/// A hole in a surface has the shape that the picture says, and what is seen through it is what is
/// behind: in a picture of albedo as in one of distance.
#[test]
fn holes_show_what_is_behind() {
    let mut scene = scene();
    let codes = vec![0, 255, 255, 0];
    let bitmap = scene.add_bitmap(Bitmap::new(2, 2, 1, Texels::Eight(codes)).unwrap());
    let interpolation = Interpolation::Nearest;
    let texture = scene.add_texture(ImageTexture { interpolation, ..ImageTexture::new(bitmap) });
    let amount = ScalarInput { factor: 1.0, texture: Some((texture, Channel::Green)) };
    let mode = OpacityMode::Mask { cutoff: 0.5 };
    let opacity = Some(Opacity { amount, vertex_colors: false, mode });
    let front = Material { opacity, ..Matte::new(Rgb::new(1.0, 0.0, 0.0)).into() };
    let front = scene.add_material(front);
    let back = scene.add_material(Matte::new(Rgb::new(0.0, 0.0, 1.0)));
    let behind = Transform::translate(-0.001 * Vec3::Z);
    scene.objects.push(Object::new(SQUARE, front));
    scene.objects.push(Object::new(SQUARE, back).transformed(&behind));
    let settings = Settings { size: [2, 2], filter: PIXEL, ..small(64) };
    let albedo = Settings { integrator: IntegratorKind::Albedo, ..settings.clone() };
    assert_eq!(tenths(&render(&scene, albedo)), [BLUE, RED, RED, BLUE]);
    let depth = Settings { integrator: IntegratorKind::Depth, ..settings };
    for (i, value) in render(&scene, depth).channel("R").unwrap().iter().enumerate() {
        let expected = if [0, 3].contains(&i) { 3.001 } else { 3.0 };
        assert!((value - expected).abs() < 1e-5, "{i}: {value}");
    }
}

/// A picture of slopes shades a flat surface like the tilted one that it tells: under a directional
/// light, as cosines say; and the same on a mirrored copy, where tangents are mirrored too.
#[test]
fn normal_maps_tilt_surfaces() {
    // Normals that lean to the right by 0.6, and up by nothing: (0.6, 0, 0.8).
    let texel = [0.6_f32, 0.0, 0.8].map(|n| 0.5 * n + 0.5).to_vec();
    for (mirrored, with_tangents) in [(false, false), (true, false), (false, true), (true, true)] {
        let mut scene = scene();
        scene.environment = None;
        let bitmap = scene.add_bitmap(Bitmap::new(1, 1, 3, Texels::Float(texel.clone())).unwrap());
        let texture = scene
            .add_texture(ImageTexture { encoding: Encoding::Linear, ..ImageTexture::new(bitmap) });
        let normal_map = Some(NormalMap { texture, scale: 1.0, shows: Bumps::Normals });
        let bumpy = Material { normal_map, ..Matte::new(Rgb::WHITE).into() };
        let bumpy = scene.add_material(bumpy);
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let mesh = Mesh {
            positions: corners.map(|[x, y]| Vec3::new(x, y, 0.0)).to_vec(),
            normals: vec![Vec3::Z; 4],
            uvs: corners.map(|[x, y]| Vec2::new(0.5 * x + 0.5, 0.5 * y + 0.5)).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        };
        let mesh = scene.add_mesh(if with_tangents { mesh.with_tangents(0) } else { mesh });
        let turn = if mirrored { Vec3::new(-1.0, 1.0, 1.0) } else { Vec3::ONE };
        let square = Object::new(Shape::Mesh(mesh), bumpy);
        scene.objects.push(square.transformed(&Transform::scale(turn)));
        // From the right, at 30 degrees to the surface's own normal.
        let from = Vec3::new(0.5, 0.0, 0.75_f32.sqrt());
        let irradiance = Rgb::WHITE;
        scene.lights.push(Light::Directional { direction: -from, irradiance, group: None });
        let slope = if mirrored { -0.6 } else { 0.6 };
        let cosine = slope * from.x + 0.8 * from.z;
        let expected = f64::from(cosine) / std::f64::consts::PI;
        let settings = Settings { size: [4, 4], filter: PIXEL, ..small(16) };
        let (value, _) = mean(&render(&scene, settings), "G");
        assert!((value - expected).abs() < 2e-3, "{mirrored} {with_tangents}: {value} {expected}");
    }
}

/// Where a normal map lies on another set of texture coordinates, its normals lean along those.
#[test]
fn normal_maps_follow_their_set() {
    let texel = [0.6_f32, 0.0, 0.8].map(|n| 0.5 * n + 0.5).to_vec();
    // The second set is turned: its u runs up.
    for (set, up) in [(0, 0.0_f32), (1, 0.6)] {
        let mut scene = scene();
        scene.environment = None;
        let bitmap = scene.add_bitmap(Bitmap::new(1, 1, 3, Texels::Float(texel.clone())).unwrap());
        let mapping = UvMapping { set, ..UvMapping::default() };
        let linear = ImageTexture { encoding: Encoding::Linear, ..ImageTexture::new(bitmap) };
        let texture = scene.add_texture(ImageTexture { mapping, ..linear });
        let normal_map = Some(NormalMap { texture, scale: 1.0, shows: Bumps::Normals });
        let bumpy = scene.add_material(Material { normal_map, ..Matte::new(Rgb::WHITE).into() });
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let mesh = scene.add_mesh(Mesh {
            positions: corners.map(|[x, y]| Vec3::new(x, y, 0.0)).to_vec(),
            uvs: corners.map(|[x, y]| Vec2::new(x, y)).to_vec(),
            more_uvs: vec![corners.map(|[x, y]| Vec2::new(y, -x)).to_vec()],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        });
        scene.objects.push(Object::new(Shape::Mesh(mesh), bumpy));
        let from = Vec3::new(0.0, 0.5, 0.75_f32.sqrt());
        let irradiance = Rgb::WHITE;
        scene.lights.push(Light::Directional { direction: -from, irradiance, group: None });
        let expected = f64::from(up * from.y + 0.8 * from.z) / std::f64::consts::PI;
        let settings = Settings { size: [4, 4], filter: PIXEL, ..small(16) };
        let (value, _) = mean(&render(&scene, settings), "G");
        assert!((value - expected).abs() < 2e-3, "{set}: {value} {expected}");
    }
}

/// A picture of a ramp shades a flat surface like the ramp: heights are metres of the world, however
/// the surface is mirrored, scaled, or its picture laid onto it.
#[test]
fn heights_tilt_surfaces() {
    const SIDE: u32 = 64;
    let row = (0..SIDE).map(|i| (i as f32 + 0.5) / SIDE as f32);
    let ramp: Vec<f32> = (0..SIDE).flat_map(|_| row.clone()).collect();
    for (scale, flipped, size) in [
        (Vec3::ONE, false, 1.0_f32),
        (Vec3::new(-1.0, 1.0, 1.0), false, 1.0),
        (Vec3::ONE, true, 1.0),
        (Vec3::splat(2.0), false, 2.0),
    ] {
        let mut scene = scene();
        scene.environment = None;
        let ramp = Bitmap::new(SIDE, SIDE, 1, Texels::Float(ramp.clone())).unwrap();
        let bitmap = scene.add_bitmap(ramp);
        let texture = scene
            .add_texture(ImageTexture { encoding: Encoding::Linear, ..ImageTexture::new(bitmap) });
        // A quarter of the ramp for each metre: up by half a metre.
        let normal_map = Some(NormalMap { texture, scale: 2.0, shows: Bumps::Heights });
        let bumpy = Material { normal_map, ..Matte::new(Rgb::WHITE).into() };
        let bumpy = scene.add_material(bumpy);
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let across = if flipped { -0.25 } else { 0.25 };
        let mesh = scene.add_mesh(Mesh {
            positions: corners.map(|[x, y]| Vec3::new(x, y, 0.0)).to_vec(),
            normals: vec![Vec3::Z; 4],
            uvs: corners.map(|[x, y]| Vec2::new(0.5 + across * x, 0.5 + 0.25 * y)).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        });
        let square = Object::new(Shape::Mesh(mesh), bumpy);
        scene.objects.push(square.transformed(&Transform::scale(scale)));
        let from = Vec3::new(0.5, 0.0, 0.75_f32.sqrt());
        let irradiance = Rgb::WHITE;
        scene.lights.push(Light::Directional { direction: -from, irradiance, group: None });
        let slope = if flipped || scale.x < 0.0 { -0.5 } else { 0.5 } / size;
        let normal = Vec3::new(-slope, 0.0, 1.0).normalize();
        let expected = f64::from(normal.dot(from)) / std::f64::consts::PI;
        let settings = Settings { size: [4, 4], filter: PIXEL, ..small(16) };
        let (value, _) = mean(&render(&scene, settings), "G");
        assert!((value - expected).abs() < 1e-3, "{scale} {flipped}: {value} {expected}");
    }
}

/// A screen that glows in parts: seen as the picture says, and its light falls on things as that of
/// as many small lamps, by every strategy.
#[test]
fn screens_glow_as_their_picture_says() {
    let mut scene = scene();
    scene.environment = None;
    let codes = vec![255, 0, 0, 0, 255, 0, 0, 0, 255, 0, 0, 0];
    let bitmap = scene.add_bitmap(Bitmap::new(2, 2, 3, Texels::Eight(codes)).unwrap());
    let interpolation = Interpolation::Nearest;
    let texture = scene.add_texture(ImageTexture { interpolation, ..ImageTexture::new(bitmap) });
    let emission = Emission { texture: Some(texture), ..Emission::radiance(Rgb::WHITE) };
    let screen = scene.add_material(emission);
    scene.objects.push(Object::new(SQUARE, screen));
    assert_eq!(tenths(&picture(&scene)), [RED, GREEN, BLUE, [0; 3]]);

    // A floor below all of a wide one gets a quarter of the light in each channel.
    scene.objects[0].shape = Shape::Rectangle { size: Vec2::splat(4000.0) };
    let mapping = UvMapping { scale: Vec2::splat(4000.0), ..UvMapping::default() };
    let Texture::Image(image) = scene.textures[0] else { panic!() };
    scene.textures[0] = Texture::Image(ImageTexture { mapping, ..image });
    let floor = scene.add_material(Matte::new(Rgb::WHITE));
    let down = Transform::rotate(Vec3::X, std::f32::consts::PI);
    scene.objects[0] =
        scene.objects[0].clone().transformed(&(Transform::translate(Vec3::Z) * down));
    scene.objects.push(Object::new(SQUARE, floor));
    scene.camera = Orthographic::look_at(0.5 * Vec3::Z, Vec3::ZERO, 1.0).unwrap().into();
    for strategy in [Strategy::Both, Strategy::LightOnly, Strategy::BsdfOnly] {
        let settings = Settings { strategy, max_depth: Some(2), ..small(1024) };
        common::assert_mean(&render(&scene, settings), 0.25, 4.5);
    }
}

/// Among plain lamps one with a picture, and one with holes, give the light that chance finds, however
/// lamps are chosen and whatever else finds them. A lamp that takes a share of the choice and is not
/// drawn, or is drawn and found, shows here.
#[test]
fn lamps_with_pictures_lose_no_light() {
    let mut scene = scene();
    scene.environment = None;
    let codes = vec![255, 0, 0, 0, 255, 0, 0, 0, 255, 0, 0, 0];
    let bitmap = scene.add_bitmap(Bitmap::new(2, 2, 3, Texels::Eight(codes)).unwrap());
    let texture = scene.add_texture(ImageTexture::new(bitmap));
    let lamp = Emission::radiance(Rgb::grey(2.0));
    let screen = scene.add_material(Emission { texture: Some(texture), ..lamp });
    let opacity =
        Some(Opacity { amount: 0.5.into(), vertex_colors: false, mode: OpacityMode::Blend });
    let veiled = scene.add_material(Material { opacity, ..lamp.into() });
    let plain = scene.add_material(lamp);
    let floor = scene.add_material(Matte::new(Rgb::grey(0.5)));
    scene.objects.push(Object::new(SQUARE, floor));
    let down = Transform::rotate(Vec3::X, std::f32::consts::PI);
    for (i, material) in
        [screen, veiled, plain, screen, plain, plain, plain].into_iter().enumerate()
    {
        let place = Vec3::new((i % 3) as f32 - 1.0, (i / 3) as f32 - 1.0, 0.8 + 0.1 * i as f32);
        let shape = Shape::Rectangle { size: Vec2::splat(0.8) };
        let place = Transform::translate(place) * down;
        scene.objects.push(Object::new(shape, material).transformed(&place));
    }
    scene.camera = Orthographic::look_at(0.5 * Vec3::Z, Vec3::ZERO, 1.0).unwrap().into();
    let prepared = Arc::new(Prepared::new(&scene).unwrap());
    let of = |settings: Settings| {
        let settings = Settings { max_depth: Some(3), ..settings };
        let image = common::render_prepared(Arc::clone(&prepared), settings);
        ["R", "G", "B"].map(|channel| mean(&image, channel))
    };
    let naive = of(Settings { integrator: IntegratorKind::Naive, ..small(1024) });
    let selections = [LightSelection::Uniform, LightSelection::Power, LightSelection::Tree];
    let strategies = [Strategy::Both, Strategy::LightOnly, Strategy::BsdfOnly];
    // Of 27 numbers chance takes one so far once in five thousand times.
    for (light_selection, strategy) in
        selections.into_iter().flat_map(|s| strategies.map(|t| (s, t)))
    {
        let found = of(Settings { light_selection, strategy, ..small(256) });
        for ((a, a_error), (b, b_error)) in found.into_iter().zip(naive) {
            let off = (a - b) / (a_error * a_error + b_error * b_error).sqrt();
            assert!(off.abs() < 4.5, "{light_selection:?} {strategy:?}: {a} for {b}, {off} σ");
        }
    }
}

/// A principled surface takes its numbers from pictures: metal on one half and a white body without
/// gloss on the other are as bright as without any picture.
#[test]
fn principled_surfaces_are_textured() {
    let plain = |metallic: f32| {
        let mut scene = scene();
        let base_color = Rgb::new(0.9, 0.5, 0.2);
        scene.camera = Orthographic::look_at(3.0 * Vec3::Z, Vec3::ZERO, 1.0).unwrap().into();
        let kind = Principled { base_color, metallic, roughness: 0.5, ..Principled::default() };
        let material = scene.add_material(Material::new(MaterialKind::Principled(Box::new(kind))));
        scene.objects.push(Object::new(SQUARE, material));
        render(&scene, Settings { size: [2, 1], filter: PIXEL, ..small(4096) })
    };
    let mut scene = scene();
    let bitmap = scene.add_bitmap(Bitmap::new(2, 1, 1, Texels::Eight(vec![255, 0])).unwrap());
    let image = ImageTexture { interpolation: Interpolation::Nearest, ..ImageTexture::new(bitmap) };
    let texture = scene.add_texture(ImageTexture { encoding: Encoding::Linear, ..image });
    let color = scene.add_bitmap(Bitmap::new(1, 1, 3, Texels::Float(vec![0.9, 0.5, 0.2])).unwrap());
    let color = scene.add_texture(ImageTexture::new(color));
    let textures = PrincipledTextures {
        base_color: Some(color),
        metallic: Some((texture, Channel::Red)),
        ..PrincipledTextures::default()
    };
    let kind = Principled {
        base_color: Rgb::WHITE,
        metallic: 1.0,
        roughness: 0.5,
        textures,
        ..Principled::default()
    };
    let material = scene.add_material(Material::new(MaterialKind::Principled(Box::new(kind))));
    scene.objects.push(Object::new(SQUARE, material));
    // Twice as wide as high: the square fills the middle.
    scene.camera = Orthographic::look_at(3.0 * Vec3::Z, Vec3::ZERO, 1.0).unwrap().into();
    let both = render(&scene, Settings { size: [2, 1], filter: PIXEL, ..small(4096) });
    for (i, metallic) in [(0, 1.0), (1, 0.0)] {
        let (expected, found) = (plain(metallic).rgb().unwrap()[0], both.rgb().unwrap()[i]);
        for c in 0..3 {
            assert!((expected[c] - found[c]).abs() < 0.02, "{metallic}: {expected:?} {found:?}");
        }
    }
}
