//! Layers say what is seen: closed forms of places, normals and coverage, and light in parts.

mod common;

use common::render;
use rutilant::camera::{Camera, Equirectangular, Orthographic, Perspective};
use rutilant::color::Rgb;
use rutilant::cryptomatte;
use rutilant::film::Filter;
use rutilant::geom::{Transform, Vec2, Vec3};
use rutilant::image::Image;
use rutilant::light::{Environment, Light};
use rutilant::material::{Dielectric, Emission, Material, MaterialKind, Matte, Mirror};
use rutilant::scene::Scene;
use rutilant::settings::{Crop, IntegratorKind, Layers, SamplerKind, Settings, Strategy};
use rutilant::shape::{Mesh, Object, Shape};
use rutilant::texture::{Checker, UvMapping};
use std::collections::BTreeMap;

/// The middles of pixels, but for less than anything here can tell.
const SHARP: Filter = Filter::Box { radius: 0.01 };

fn settings(size: [u32; 2]) -> Settings {
    Settings { size, spp: 2, filter: SHARP, layers: Layers::all(), ..Settings::default() }
}

fn at<const N: usize>(image: &Image, names: [&str; N], pixel: usize) -> [f64; N] {
    names.map(|name| f64::from(image.channel(name).expect(name)[pixel]))
}

fn near(found: &[f64], expected: &[f64], tolerance: f64, what: &str) {
    assert_eq!(found.len(), expected.len());
    let off = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off <= tolerance, "{what}: {found:?} for {expected:?}");
}

const NORMAL: [&str; 3] = ["normal.X", "normal.Y", "normal.Z"];
const POSITION: [&str; 3] = ["position.X", "position.Y", "position.Z"];

/// A ball seen from outside and from inside, by a camera with a plane film and by one that sees all
/// around: where it is, how far that is, and a normal on the camera's side. Distances along the ray
/// instead of the axis, normals that stay outside, and rays that are told as places show here.
#[test]
fn a_ball_is_where_it_is() {
    let side = 33;
    for (eye, target) in [(Vec3::new(0.4, 0.2, 3.0), Vec3::ZERO), (Vec3::ZERO, Vec3::X)] {
        let fov = 0.9_f32;
        let perspective = Perspective::look_at(eye, target, fov).unwrap();
        let around = Equirectangular::look_at(eye, target).unwrap();
        for camera in [Camera::from(perspective), Camera::from(around)] {
            let mut scene = Scene::new(camera);
            let grey = scene.add_material(Matte::new(Rgb::grey(0.5)));
            scene.objects.push(Object::new(Shape::Sphere { radius: 1.0 }, grey));
            scene.environment = Some(Environment::constant(Rgb::WHITE));
            let image = render(&scene, settings([side, side]));
            let (mut met, mut missed) = (0, 0);
            for pixel in 0..(side * side) as usize {
                let place = at(&image, POSITION, pixel);
                let length = place.iter().map(|x| x * x).sum::<f64>().sqrt();
                let [depth] = at(&image, ["depth.Z"], pixel);
                let normal = at(&image, NORMAL, pixel);
                let [object, material] = at(&image, ["object.id", "material.id"], pixel);
                if object == 0.0 {
                    missed += 1;
                    near(&normal, &[0.0; 3], 0.0, "nothing has no normal");
                    near(&[depth, length, material], &[0.0; 3], 0.0, "nothing is nowhere");
                    continue;
                }
                met += 1;
                assert_eq!([object, material], [1.0; 2]);
                // Half the filter's width may be over the rim.
                near(&[length], &[1.0], 2e-3, "on the ball");
                let outwards = if eye == Vec3::ZERO { -1.0 } else { 1.0 };
                near(&normal, &place.map(|x| x * outwards), 2e-2, "normal");
                let from_eye: Vec<f64> =
                    place.iter().zip(eye.to_array()).map(|(p, e)| p - f64::from(e)).collect();
                let forward = (target - eye).normalize().to_array().map(f64::from);
                let along: f64 = from_eye.iter().zip(forward).map(|(p, f)| p * f).sum();
                let distance = from_eye.iter().map(|x| x * x).sum::<f64>().sqrt();
                let expected = match camera {
                    Camera::Perspective(_) | Camera::Orthographic(_) => along,
                    Camera::Equirectangular(_) => distance,
                };
                near(&[depth], &[expected], 2e-3, "depth");
            }
            assert_eq!(missed == 0, eye == Vec3::ZERO);
            assert!(met > 10, "{met}");
        }
    }
}

/// A square that fills the picture: texture coordinates grow as the picture's do, and the albedo is
/// the board's there. A swapped axis, a colour of the mean, or an albedo of the light shows here.
#[test]
fn a_board_has_its_colours() {
    let camera = Orthographic::look_at(Vec3::Z, Vec3::ZERO, 2.0).unwrap();
    let mut scene = Scene::new(camera);
    let (first, second) = (Rgb::new(0.8, 0.2, 0.1), Rgb::new(0.1, 0.3, 0.6));
    let board = scene.add_texture(Checker { first, second, mapping: UvMapping::default() });
    let matte = scene.add_material(Matte::new(board));
    scene.objects.push(Object::new(Shape::Rectangle { size: Vec2::splat(2.0) }, matte));
    scene.lights.push(Light::Point { position: Vec3::Z, intensity: Rgb::grey(7.0), group: None });
    let side = 16;
    let image = render(&scene, settings([side, side]));
    for (y, x) in (0..side).flat_map(|y| (0..side).map(move |x| (y, x))) {
        let pixel = (y * side + x) as usize;
        let part = |i: u32| (f64::from(i) + 0.5) / f64::from(side);
        let uv = [part(x), 1.0 - part(y)];
        near(&at(&image, ["uv.U", "uv.V"], pixel), &uv, 1e-3, "uv");
        let odd = uv.map(|c| (2.0 * c).floor()).iter().sum::<f64>() % 2.0 == 1.0;
        let color = if odd { second } else { first }.0.map(f64::from);
        near(&at(&image, ["albedo.R", "albedo.G", "albedo.B"], pixel), &color, 1e-6, "albedo");
    }
}

/// What is asked of glass, mirrors and lamps: glass is white, a mirror is what it reflects, a lamp
/// sends nothing back; a flame that rays pass is not what is met.
#[test]
fn clear_things_are_told_as_they_are() {
    let camera = Orthographic::look_at(Vec3::Z * 5.0, Vec3::ZERO, 2.0).unwrap();
    let gold = Rgb::new(0.9, 0.7, 0.3);
    let flame = Emission { two_sided: true, ..Emission::radiance(Rgb::WHITE) };
    let flame = Material::new(MaterialKind::Null).emitting(flame);
    for (material, before, expected) in [
        (Material::from(Dielectric::new(1.5)), false, Rgb::WHITE),
        (Mirror { reflectance: gold }.into(), false, gold),
        (Mirror { reflectance: gold }.into(), true, gold),
        (Emission::radiance(gold).into(), false, Rgb::BLACK),
    ] {
        let mut scene = Scene::new(camera);
        let id = scene.add_material(material);
        let flame = scene.add_material(flame.clone());
        let wall = Shape::Rectangle { size: Vec2::splat(3.0) };
        if before {
            let nearer = Transform::translate(Vec3::Z);
            scene.objects.push(Object::new(wall.clone(), flame).transformed(&nearer));
        }
        scene.objects.push(Object::new(wall, id));
        scene.environment = Some(Environment::constant(Rgb::WHITE));
        let image = render(&scene, settings([2, 2]));
        let expected = expected.0.map(f64::from);
        near(&at(&image, ["albedo.R", "albedo.G", "albedo.B"], 1), &expected, 1e-6, "albedo");
        near(&at(&image, NORMAL, 1), &[0.0, 0.0, 1.0], 1e-6, "normal");
        near(&at(&image, ["depth.Z"], 1), &[5.0], 1e-5, "depth");
        let number = if before { 2.0 } else { 1.0 };
        near(&at(&image, ["object.id", "material.id"], 1), &[number, 1.0], 0.0, "ids");
    }
}

/// A room with a lamp, a mirror, glass and a sky.
fn room() -> Scene {
    let eye = Vec3::new(0.0, 1.0, 4.0);
    let mut scene = Scene::new(Perspective::look_at(eye, Vec3::ZERO, 0.8).unwrap());
    scene.environment = Some(Environment::constant(Rgb::new(0.2, 0.3, 0.5)));
    let floor = scene.add_material(Matte::new(Rgb::new(0.7, 0.6, 0.5)));
    let glass = scene.add_material(Dielectric::new(1.5));
    let mirror = scene.add_material(Mirror { reflectance: Rgb::grey(0.8) });
    let lamp = scene.add_material(Emission::radiance(Rgb::grey(9.0)));
    for (shape, material, place) in [
        (Shape::Box { size: Vec3::new(9.0, 0.1, 9.0) }, floor, Vec3::new(0.0, -0.85, 0.0)),
        (Shape::Sphere { radius: 0.8 }, glass, Vec3::new(-1.0, 0.0, 0.0)),
        (Shape::Box { size: Vec3::ONE }, mirror, Vec3::new(1.0, -0.3, 0.0)),
        (Shape::Sphere { radius: 0.3 }, lamp, Vec3::new(0.0, 1.5, 0.0)),
    ] {
        scene.objects.push(Object::new(shape, material).transformed(&Transform::translate(place)));
    }
    scene
}

/// Parts of light add up to it, and they are those of pictures whose paths end sooner: of one
/// segment, and of two. Both ways of tracing paths are tried, and each way of finding light.
#[test]
fn parts_of_light_are_those_of_shorter_paths() {
    let flame = Emission { two_sided: true, ..Emission::radiance(Rgb::new(2.0, 1.0, 0.2)) };
    let mut burning = room();
    let flame = burning.add_material(Material::new(MaterialKind::Null).emitting(flame));
    let veil = Object::new(Shape::Sphere { radius: 0.4 }, flame);
    burning.objects.push(veil.transformed(&Transform::translate(Vec3::new(0.0, 0.2, 1.0))));
    for (scene, strategy) in [
        (room(), Strategy::Both),
        (room(), Strategy::BsdfOnly),
        (room(), Strategy::LightOnly),
        (burning, Strategy::Both),
    ] {
        let usual = Settings {
            size: [24, 24],
            spp: 16,
            strategy,
            layers: Layers::all(),
            ..Settings::default()
        };
        let whole = render(&scene, usual.clone());
        let ended = |depth| render(&scene, Settings { max_depth: Some(depth), ..usual.clone() });
        let (one, two) = (ended(1), ended(2));
        let mut brightest = [0.0_f64; 3];
        for (pixel, c) in (0..24 * 24).flat_map(|pixel| ["R", "G", "B"].map(|c| (pixel, c))) {
            let parts = ["emission", "direct", "indirect"].map(|part| format!("{part}.{c}"));
            let parts = at(&whole, parts.each_ref().map(|name| &**name), pixel);
            let [light] = at(&whole, [c], pixel);
            let close = |found: f64, expected: f64| {
                near(&[found], &[expected], 1e-6 * expected.abs().max(1e-3), c);
            };
            close(parts.iter().sum(), light);
            close(parts[0], at(&one, [c], pixel)[0]);
            close(parts[0] + parts[1], at(&two, [c], pixel)[0]);
            assert!(parts.iter().all(|part| *part >= 0.0), "{parts:?}");
            for (most, part) in brightest.iter_mut().zip(parts) {
                *most = most.max(part);
            }
        }
        assert!(brightest.iter().all(|part| *part > 0.01), "{brightest:?}");
    }
}

/// In a furnace of radiance 1 a ball of albedo a sends back a after one bounce, and nothing else.
#[test]
fn a_ball_in_a_furnace_has_direct_light_alone() {
    let mut scene = Scene::new(Perspective::look_at(Vec3::Z * 3.0, Vec3::ZERO, 0.4).unwrap());
    let grey = scene.add_material(Matte::new(Rgb::new(0.25, 0.5, 0.75)));
    scene.objects.push(Object::new(Shape::Sphere { radius: 1.0 }, grey));
    scene.environment = Some(Environment::constant(Rgb::WHITE));
    let image = render(&scene, Settings { spp: 64, ..settings([9, 9]) });
    let middle = 4 * 9 + 4;
    let direct = at(&image, ["direct.R", "direct.G", "direct.B"], middle);
    near(&direct, &[0.25, 0.5, 0.75], 1e-4, "direct");
    near(&at(&image, ["emission.R", "indirect.R"], middle), &[0.0; 2], 0.0, "nothing else");
}

/// Light in parts is left out where it is not known, and that is said.
#[test]
fn what_knows_no_parts_of_light_says_so() {
    let scene = rutilant::Prepared::new(&room()).unwrap();
    let usual = Settings { size: [4, 4], spp: 1, layers: Layers::all(), ..Settings::default() };
    for integrator in [IntegratorKind::Path, IntegratorKind::Naive, IntegratorKind::Direct] {
        let settings = Settings { integrator, ..usual.clone() };
        let notes = scene.notes_for(&settings);
        let said = notes.iter().any(|note| note.what.contains("the layer \"light\" is left out"));
        let image = common::render_prepared(scene.clone(), settings);
        let is_there = image.channel("direct.R").is_some();
        assert_eq!((said, is_there), (!is_there, integrator == IntegratorKind::Path));
        assert!(image.channel("albedo.R").is_some());
    }
}

/// The ids of a pixel with their coverages, rank by rank, as a reader of files finds them.
fn ranks(image: &Image, layer: &str, pixel: usize) -> Vec<(u32, f32)> {
    let mut ranks = Vec::new();
    for (level, [id, coverage]) in
        (0..).flat_map(|level| [["R", "G"], ["B", "A"]].map(|pair| (level, pair)))
    {
        let value = |last: &str| image.channel(&format!("{layer}{level:02}.{last}"));
        let (Some(id), Some(coverage)) = (value(id), value(coverage)) else { break };
        ranks.push((id[pixel].to_bits(), coverage[pixel]));
    }
    ranks
}

/// Checks what is true of every pixel's ranks: the largest come first, they add up to 1, and no id
/// is told twice. Returns them by id.
fn covered(image: &Image, layer: &str, pixel: usize) -> BTreeMap<u32, f32> {
    let ranks = ranks(image, layer, pixel);
    assert!(ranks.len() >= 6 && ranks.is_sorted_by(|a, b| a.1 >= b.1), "{ranks:?}");
    let sum: f32 = ranks.iter().map(|(_, coverage)| coverage).sum();
    assert!((sum - 1.0).abs() < 1e-5, "{sum}");
    let there: Vec<_> = ranks.into_iter().filter(|(_, coverage)| *coverage > 0.0).collect();
    let by_id: BTreeMap<u32, f32> = there.iter().copied().collect();
    assert_eq!(by_id.len(), there.len());
    by_id
}

/// The edge of a half plane through a pixel covers as much of it as the filter's integral says, for
/// filters of every shape that has no negative lobes. Coverage by pixels' squares, and ids of the
/// middle alone, show here.
#[test]
fn an_edge_covers_what_the_filter_says() {
    let spp = 4096;
    let integral = |filter: Filter, to: f64| {
        let (radius, steps) = (f64::from(filter.radius()), 2000);
        let to = to.clamp(-radius, radius);
        let step = (to + radius) / f64::from(steps);
        let value = |i: i32| f64::from(filter.eval((-radius + (f64::from(i) + 0.5) * step) as f32));
        (0..steps).map(value).sum::<f64>() * step
    };
    for filter in [
        Filter::Box { radius: 0.5 },
        Filter::Tent { radius: 1.0 },
        Filter::Gaussian { radius: 1.5, sigma: 0.5 },
        Filter::BlackmanHarris { radius: 1.5 },
    ] {
        let camera = Orthographic::look_at(Vec3::Z, Vec3::ZERO, 1.0).unwrap();
        let mut scene = Scene::new(camera);
        let grey = scene.add_material(Material::from(Matte::new(Rgb::grey(0.5))).named("grey"));
        // One pixel a metre wide: the plane ends 0.2 to the right of its middle.
        let wall = Object::new(Shape::Rectangle { size: Vec2::splat(20.0) }, grey);
        let place = Transform::translate(Vec3::X * -9.8);
        scene.objects.push(wall.named("house/wall").transformed(&place));
        let settings = Settings {
            size: [1, 1],
            spp,
            filter,
            sampler: SamplerKind::Independent,
            layers: Layers::all(),
            ..Settings::default()
        };
        let image = render(&scene, settings);
        let expected = integral(filter, 0.2) / integral(filter, 100.0);
        // Four standard errors: one run in 16 000 is further off by chance.
        let tolerance = 4.0 * (expected * (1.0 - expected) / spp as f64).sqrt();
        for (layer, name) in
            [("CryptoObject", "house/wall"), ("CryptoMaterial", "grey"), ("CryptoAsset", "house")]
        {
            let by_id = covered(&image, layer, 0);
            let of = |id| f64::from(by_id.get(&id).copied().unwrap_or(0.0));
            near(&[of(cryptomatte::id(name))], &[expected], tolerance, layer);
            near(&[of(0)], &[1.0 - expected], tolerance, "nothing");
            assert_eq!(by_id.len(), 2, "{layer}");
        }
    }
}

/// Twenty things in one pixel are all told, at the price of more ranks, also with a filter of
/// negative lobes; things of one name are one, and what has no name has its number's.
#[test]
fn no_id_is_lost() {
    let camera = Orthographic::look_at(Vec3::Z, Vec3::ZERO, 1.0).unwrap();
    let mut scene = Scene::new(camera);
    let grey = scene.add_material(Matte::new(Rgb::grey(0.5)));
    let corners = [[-0.5, -9.0], [0.5, -9.0], [0.5, 9.0], [-0.5, 9.0]];
    let strip = scene.add_mesh(Mesh {
        name: "strip".into(),
        positions: corners.map(|[x, y]| Vec3::new(x * 0.05, y, 0.0)).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    });
    let rectangle = Shape::Rectangle { size: Vec2::new(0.05, 18.0) };
    for i in 0..20 {
        let shape = if i < 3 { Shape::Mesh(strip) } else { rectangle.clone() };
        let name = if i == 3 { "ü/\"\\" } else { "" };
        let place = Transform::translate(Vec3::X * (0.05 * (i as f32 - 9.5)));
        scene.objects.push(Object::new(shape, grey).named(name).transformed(&place));
    }
    let filter = Filter::Mitchell { radius: 2.0, b: 0.0, c: 0.5 };
    let settings =
        Settings { size: [1, 1], spp: 4096, filter, layers: Layers::all(), ..Settings::default() };
    let image = render(&scene, settings.clone());
    let objects = covered(&image, "CryptoObject", 0);
    let mut names = vec!["strip".to_owned(), "ü/\"\\".to_owned()];
    names.extend((5..=20).map(|i| format!("object {i}")));
    let mut ids: Vec<u32> = names.iter().map(|name| cryptomatte::id(name)).chain([0]).collect();
    ids.sort_unstable();
    assert_eq!(objects.into_keys().collect::<Vec<_>>(), ids);
    assert!(image.channel("CryptoObject09.A").is_some());
    assert!(image.channel("CryptoMaterial03.R").is_none());
    assert_eq!(covered(&image, "CryptoMaterial", 0).len(), 2);
    assert!(covered(&image, "CryptoAsset", 0).contains_key(&cryptomatte::id("ü")));

    // The header knows every name.
    let said = cryptomatte::metadata(&scene);
    let manifest = &said.iter().find(|(key, _)| key == "cryptomatte/3ae39a5/manifest").unwrap().1;
    for name in names.iter().filter(|name| name.is_ascii() && !name.contains('"')) {
        let entry = format!("\"{name}\":\"{:08x}\"", cryptomatte::id(name));
        assert!(manifest.contains(&entry), "{entry} in {manifest}");
    }
    assert_eq!(said.len(), 12);
    assert!(said.iter().all(|(key, text)| key.len() <= 31 && text.is_ascii()));
}

/// Of what covers a pixel the largest gives it its number.
#[test]
fn ids_are_of_what_covers_most() {
    let mut scene = room();
    scene.objects.swap(0, 3);
    let usual = Settings { filter: Filter::default(), spp: 64, ..settings([20, 20]) };
    let image = render(&scene, usual.clone());
    let crop = Crop { x: 3, y: 4, width: 12, height: 9 };
    let part = render(&scene, Settings { crop: Some(crop), ..usual });
    let ids: BTreeMap<u32, usize> = (0..scene.objects.len())
        .map(|i| (cryptomatte::id(&cryptomatte::object_name(&scene, i)), i + 1))
        .chain([(0, 0)])
        .collect();
    for pixel in 0..20 * 20 {
        let [number, material] = at(&image, ["object.id", "material.id"], pixel);
        let ranks = ranks(&image, "CryptoObject", pixel);
        let most: Vec<usize> =
            ranks.iter().filter(|r| r.1 == ranks[0].1).map(|(id, _)| ids[id]).collect();
        assert!(most.contains(&(number as usize)), "{number} of {most:?}");
        if number > 0.0 && ranks[0].1 > 0.5 {
            let of = scene.objects[number as usize - 1].material.0 + 1;
            assert_eq!(material, f64::from(of));
        }
    }
    assert_eq!(part.channel("object.id").unwrap()[0], image.channel("object.id").unwrap()[83]);
}

/// Filters with negative lobes ring in light, but no albedo is below 0 or above what there is, and no
/// normal longer than 1.
#[test]
fn features_do_not_ring() {
    let filter = Filter::Mitchell { radius: 2.0, b: 0.0, c: 0.5 };
    let image = render(&room(), Settings { filter, spp: 16, ..settings([20, 20]) });
    for pixel in 0..20 * 20 {
        let albedo = at(&image, ["albedo.R", "albedo.G", "albedo.B"], pixel);
        assert!(albedo.iter().all(|a| (0.0..=1.0).contains(a)), "{albedo:?}");
        let [x, y, z] = at(&image, ["normal.X", "normal.Y", "normal.Z"], pixel);
        let length = (x * x + y * y + z * z).sqrt();
        assert!(length < 1.0 + 1e-5, "{length}");
    }
}
