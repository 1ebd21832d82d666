//! The light tree: whom it chooses, how often, and what that is worth.

mod common;

use common::random;
use rutilant::Prepared;
use rutilant::camera::Perspective;
use rutilant::color::Rgb;
use rutilant::geom::{Transform, Vec2, Vec3, real};
use rutilant::light::{Emitter, EmitterSelection, Environment, Light, ShadingPoint, SpotLight};
use rutilant::material::Emission;
use rutilant::scene::Scene;
use rutilant::settings::LightSelection;
use rutilant::shape::{Mesh, Object, Shape};

fn empty() -> Scene {
    Scene::new(Perspective::look_at(Vec3::ZERO, Vec3::NEG_Z, 1.0).unwrap())
}

/// Eight numbers in [0, 1).
fn eight(stream: u64, i: u64) -> [f32; 8] {
    let pairs = [0, 1, 2, 3].map(|k| random(stream, 4 * i + k).1);
    [pairs[0].x, pairs[0].y, pairs[1].x, pairs[1].y, pairs[2].x, pairs[2].y, pairs[3].x, pairs[3].y]
}

/// Lamps of every kind in a room of some size, turned in all directions, of brightnesses that
/// differ by so many powers of ten.
fn lamps(count: u64, size: f32, decades: f32) -> Scene {
    let mut scene = empty();
    let triangle = scene.add_mesh(Mesh {
        positions: vec![Vec3::ZERO, 0.1 * size * Vec3::X, 0.07 * size * Vec3::Y],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    });
    for i in 0..count {
        let [x, y, z, turn, bright, a, b, c] = eight(51, i);
        let position = size * Vec3::new(2.0 * x - 1.0, y, 2.0 * z - 1.0);
        let axis = Vec3::new(a - 0.5, b - 0.5, c - 0.5 + 1e-3).normalize();
        let light = Rgb::new(1.0, 0.9, 0.7);
        let light = Rgb(light.0.map(|l| l * real::pow(10.0, decades * (bright - 0.5))));
        // Surfaces as bright as points of these intensities.
        let radiance = Rgb(light.0.map(|l| l * 50.0 / (size * size)));
        let glow = Emission { two_sided: i % 3 == 0, ..Emission::radiance(radiance) };
        let shape = match i % 7 {
            0 => Shape::Mesh(triangle),
            1 => Shape::Rectangle { size: size * Vec2::new(0.05, 0.2) },
            2 => Shape::Disk { radius: 0.05 * size },
            3 => Shape::Sphere { radius: 0.03 * size },
            4 => Shape::Sphere { radius: 0.01 * size },
            5 => {
                scene.lights.push(Light::Point { position, intensity: light, group: None });
                continue;
            }
            _ => {
                let (inner, outer) = (0.9 * a, 1e-3 + 3.1 * a);
                let light = SpotLight::Intensity(light);
                scene.lights.push(Light::Spot {
                    position,
                    direction: axis,
                    light,
                    inner,
                    outer,
                    group: None,
                });
                continue;
            }
        };
        let lamp = scene.add_material(glow);
        let place = Transform::translate(position) * Transform::rotate(axis, 6.0 * turn);
        scene.objects.push(Object::new(shape, lamp).transformed(&place));
    }
    scene
}

/// Points among such lamps, beside them and far off, with and without a normal.
fn points(size: f32) -> Vec<ShadingPoint> {
    let mut points: Vec<ShadingPoint> = (0..6)
        .flat_map(|i| {
            let [x, y, z, a, b, c, ..] = eight(52, i);
            let position = size * Vec3::new(2.0 * x - 1.0, y, 2.0 * z - 1.0);
            let normal = Vec3::new(a - 0.5, b - 0.5, c - 0.5).normalize();
            [ShadingPoint { position, normal }, ShadingPoint::open(position)]
        })
        .collect();
    for position in [Vec3::new(0.0, -0.1, 0.0), Vec3::new(50.0, 3.0, -20.0), 1e6 * Vec3::ONE] {
        points.push(ShadingPoint { position: size * position, normal: Vec3::Y });
        points.push(ShadingPoint { position: size * position, normal: -Vec3::Y });
        points.push(ShadingPoint::open(size * position));
    }
    points
}

fn tree(emitters: &[Emitter]) -> EmitterSelection {
    EmitterSelection::new(LightSelection::Tree, emitters, 1.0)
}

/// How often each emitter is chosen for evenly spaced numbers, and how often none. Asserts that
/// every choice states the probability that the emitter has by itself, to the bit.
fn frequencies(
    selection: &EmitterSelection,
    point: &ShadingPoint,
    emitters: usize,
    count: u32,
) -> (Vec<f64>, f64) {
    let (mut chosen, mut none) = (vec![0.0; emitters], 0.0);
    let share = 1.0 / f64::from(count);
    for i in 0..count {
        let place = f64::from(1 << 24) * (f64::from(i) + 0.5) * share;
        let u = place.floor() as f32 / (1 << 24) as f32;
        match selection.select(point, u, place.fract() as f32) {
            Some((emitter, pmf)) => {
                let alone = selection.pmf(point, emitter);
                assert_eq!(pmf.to_bits(), alone.to_bits(), "{point:?}, {emitter}: {pmf} {alone}");
                chosen[emitter] += share;
            }
            None => none += share,
        }
    }
    (chosen, none)
}

/// Emitters are chosen as often as their probabilities say, which add up to 1 with those choices
/// that come to nothing: by numbers that are evenly spaced, to within the numbers at the two ends
/// of each emitter's two intervals. A step down the tree that is stretched wrongly, or a probability
/// of another way than the one taken, shows here; so does a lamp that is given up where it shines.
#[test]
fn choices_follow_their_probabilities() {
    for (count, size) in [(1, 1.0), (2, 1.0), (9, 1.0), (70, 1e-7), (1000, 1.0), (1000, 1e7)] {
        let scene = Prepared::new(&lamps(count, size, 4.0)).unwrap();
        let (emitters, selection) = (scene.emitters(), tree(scene.emitters()));
        assert_eq!(emitters.len() as u64, count);
        for point in points(size) {
            let n = 1 << 16;
            let (chosen, none) = frequencies(&selection, &point, emitters.len(), n);
            let mut sum = 0.0;
            for (i, often) in chosen.iter().enumerate() {
                let pmf = f64::from(selection.pmf(&point, i));
                sum += pmf;
                let off = (often - pmf).abs();
                assert!(off < 4.0 / f64::from(n) + 1e-5 * pmf, "{point:?}, {i}: {often} {pmf}");
            }
            let most = 4.0 * (count.min(200) as f64) / f64::from(n) + 1e-5;
            assert!((sum + none - 1.0).abs() < most, "{point:?}: {sum} + {none}");
        }
    }
}

/// What `emitter` sends to a point at most, of a few places on it, times the cosine there.
fn arrives(emitter: &Emitter, point: &ShadingPoint) -> f64 {
    let places = [[0.5, 0.5], [0.1, 0.1], [0.9, 0.1], [0.1, 0.9], [0.9, 0.9]].map(Vec2::from);
    let light = |u| {
        let Some(s) = emitter.sample(point.position, u) else { return 0.0 };
        let cos = if point.normal == Vec3::ZERO { 1.0 } else { s.wi.dot(point.normal) };
        f64::from(s.radiance.luminance()) / f64::from(s.pdf) * f64::from(cos.max(0.0))
    };
    places.map(light).into_iter().fold(0.0, f64::max)
}

/// Whatever lights a point may be chosen for it, by the tree itself and not only by the part of all
/// choices that takes any lamp: bounds that are too tight would leave it to that part, and the
/// picture to specks.
#[test]
fn no_lamp_that_lights_a_point_is_overlooked() {
    for size in [1e-7, 1.0, 1e7] {
        // All of about the same brightness: what is too dim beside others is rounded away.
        let scene = Prepared::new(&lamps(700, size, 2.0)).unwrap();
        let selection = tree(scene.emitters());
        let least = 1.0 / (64.0 * 700.0);
        let (mut lit, mut dark) = (0, 0);
        for point in points(size) {
            for (i, emitter) in scene.emitters().iter().enumerate() {
                let pmf = selection.pmf(&point, i);
                assert!(pmf >= least * 0.999, "{point:?}, {i}: {pmf}");
                if arrives(emitter, &point) > 0.0 {
                    lit += 1;
                    dark += u32::from(pmf <= least * (1.0 + 1e-6));
                }
            }
        }
        assert!(lit > 5000 && dark == 0, "{dark} of {lit}");
    }
}

/// Lamps of one brightness but one that is 10³⁶ times as dim, all in one place, along a line, or
/// along a line in ever larger steps: every one can be chosen, the dim one by the numbers that stand
/// for it. No tree is too deep for its ways, and no number too coarse.
#[test]
fn every_lamp_can_be_chosen() {
    let crowd = |position: &dyn Fn(u32) -> f32, count: u32| {
        let mut scene = empty();
        for i in 0..count {
            let position = Vec3::new(position(i), 0.0, 0.0);
            let intensity = Rgb::grey(if i == 7 { 1e-18 } else { 1e18 });
            scene.lights.push(Light::Point { position, intensity, group: None });
        }
        Prepared::new(&scene).unwrap()
    };
    for scene in [
        crowd(&|_| 3.0, 1000),
        crowd(&|i| i as f32, 100_000),
        // Each group that is split leaves one lamp behind.
        crowd(&|i| real::pow(1.9, (i % 100) as f32), 100_000),
    ] {
        let (emitters, selection) = (scene.emitters(), tree(scene.emitters()));
        let count = emitters.len();
        for point in [Vec3::ZERO, Vec3::new(3.0, 0.0, 0.0), Vec3::new(3.0, 1e20, 0.0)] {
            let point = ShadingPoint::open(point);
            let pmfs = (0..count).map(|i| f64::from(selection.pmf(&point, i)));
            let (sum, least) = pmfs.fold((0.0, 1.0_f64), |(sum, least), p| (sum + p, least.min(p)));
            assert!((sum - 1.0).abs() < 1e-3, "{point:?}: {sum}");
            assert!(least * count as f64 > 0.0156, "{point:?}: {least}");
            // The first 64th of all numbers takes them in turn.
            let place = (7.5 / count as f64) / 64.0 * f64::from(1 << 24);
            let (u, fine) = (place.floor() as f32 / (1 << 24) as f32, place.fract() as f32);
            assert_eq!(selection.select(&point, u, fine).map(|(i, _)| i), Some(7));
        }
    }
}

/// Each light at infinity is chosen as often as all lamps together, and so it is said.
#[test]
fn lights_at_infinity_are_chosen_as_often_as_all_lamps_together() {
    let mut scene = lamps(50, 1.0, 4.0);
    scene.environment = Some(Environment::constant(Rgb::WHITE));
    let irradiance = Rgb::grey(3.0);
    scene.lights.push(Light::Directional { direction: Vec3::NEG_Y, irradiance, group: None });
    scene.lights.push(Light::Directional {
        direction: Vec3::X,
        irradiance: Rgb::BLACK,
        group: None,
    });
    let scene = Prepared::new(&scene).unwrap();
    let (emitters, selection) = (scene.emitters(), tree(scene.emitters()));
    let point = ShadingPoint::open(Vec3::new(0.1, 0.2, 0.3));
    let (chosen, none) = frequencies(&selection, &point, emitters.len(), 1 << 16);
    let mut lamps = none;
    for (i, emitter) in emitters.iter().enumerate() {
        let expected = match emitter {
            Emitter::Distant(sun) if sun.irradiance.is_black() => 0.0,
            Emitter::Distant(_) | Emitter::Environment(_) => 1.0 / 3.0,
            _ => {
                lamps += chosen[i];
                continue;
            }
        };
        assert!((chosen[i] - expected).abs() < 1e-4, "{emitter:?}: {}", chosen[i]);
        assert!((f64::from(selection.pmf(&point, i)) - expected).abs() < 1e-6, "{emitter:?}");
    }
    assert!((lamps - 1.0 / 3.0).abs() < 1e-3, "{lamps}");
}

/// Among a thousand lamps in a room, of powers that differ by a factor of 100, what a choice of the
/// tree brings differs from the mean by less than three quarters of it (root mean square, for the
/// median point); what a choice by power brings, by more than 1.7 times the mean. Nothing is in the
/// way.
#[test]
fn the_tree_knows_what_lamps_bring() {
    let scene = Prepared::new(&lamps(1000, 1.0, 2.0)).unwrap();
    let emitters = scene.emitters();
    let spread = |kind| {
        let selection = EmitterSelection::new(kind, emitters, 1.0);
        let points = points(1.0).into_iter().filter(|point| point.normal != Vec3::ZERO);
        let mut spreads: Vec<f64> = points
            .map(|point| {
                let all = emitters.iter().enumerate();
                let (sum, squares) = all.fold((0.0, 0.0), |(sum, squares), (i, emitter)| {
                    let light = arrives(emitter, &point);
                    let pmf = f64::from(selection.pmf(&point, i));
                    (sum + light, squares + light * light / pmf)
                });
                (squares / (sum * sum) - 1.0).sqrt()
            })
            .collect();
        spreads.sort_by(f64::total_cmp);
        spreads[spreads.len() / 2]
    };
    let [tree, power] = [LightSelection::Tree, LightSelection::Power].map(spread);
    println!("the tree {tree:.2}, by power {power:.2}");
    assert!(tree < 0.75 && power > 1.7, "{tree} {power}");
}

/// The tree of enough lamps for several threads is the same for any number of them.
#[test]
fn any_number_of_threads_builds_the_same_tree() {
    let mut scene = empty();
    for i in 0..40_000 {
        let [x, y, z, bright, ..] = eight(53, i);
        let position = Vec3::new(x, y * y, z);
        scene.lights.push(Light::Point {
            position,
            intensity: Rgb::grey(0.1 + bright),
            group: None,
        });
    }
    let scene = Prepared::new(&scene).unwrap();
    let built = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let selection = pool.install(|| tree(scene.emitters()));
        let point = ShadingPoint { position: Vec3::splat(0.4), normal: Vec3::Y };
        let pmf = |i| selection.pmf(&point, i).to_bits();
        (0..scene.emitters().len()).map(pmf).collect::<Vec<u32>>()
    };
    let one = built(1);
    assert!((0..40_000).any(|i| one[i] != one[0]));
    for threads in [2, 7] {
        assert!(built(threads) == one, "{threads} threads");
    }
}

/// Lamps that shine on both sides do so whichever side their triangles call the front: the tree is
/// the same, and so is whom it chooses.
#[test]
fn two_sided_lamps_have_no_front() {
    let room = |turned: bool| {
        let mut scene = empty();
        let glow = Emission { two_sided: true, ..Emission::radiance(Rgb::WHITE) };
        let lamp = scene.add_material(glow);
        for i in 0..300 {
            let [x, y, z, a, b, c, tilt, _] = eight(54, i);
            let at = 4.0 * Vec3::new(x, y, z);
            // Upright plates that face one axis or the other, more or less.
            let side = if i % 2 == 0 { Vec3::Z } else { Vec3::X };
            let positions =
                vec![at, at + Vec3::new(0.1 * a, 0.3, 0.1 * tilt), at + side * (0.1 + 0.2 * b)];
            let back = turned && c < 0.5;
            let triangles = vec![if back { [0, 2, 1] } else { [0, 1, 2] }];
            let mesh = scene.add_mesh(Mesh { positions, triangles, ..Mesh::default() });
            scene.objects.push(Object::new(Shape::Mesh(mesh), lamp));
        }
        Prepared::new(&scene).unwrap()
    };
    let rooms = [room(false), room(true)];
    let [one, other] = [0, 1].map(|k| tree(rooms[k].emitters()));
    for point in points(4.0) {
        for i in 0..300 {
            let [p, q] = [&one, &other].map(|tree| tree.pmf(&point, i));
            assert!((p - q).abs() <= 1e-5 * p, "{point:?}, {i}: {p} {q}");
        }
    }
}
