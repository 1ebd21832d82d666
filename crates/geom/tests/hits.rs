//! Hits are right: they equal those found by other means, closed meshes have no
//! cracks, and the tree changes nothing.

mod common;

use common::{Random, aimed_ray, brute, meshes};
use rayon::prelude::*;
use rutilant_geom::lanes::LANES;
use rutilant_geom::triangle::TriangleRay;
use rutilant_geom::{
    BuildOptions, Disk, HitPacket, Quality, Ray, RayPacket, Simd, Sphere, Surfaces, Vec3,
    offset_origin,
};

/// Textbook formulas, every primitive in turn. A box left out wrongly, a wrong
/// sign, a lost needle, a nearer hit replaced by a farther one: all show here.
///
/// Rays on an edge are for nobody to tell but by rounding; those in which the
/// textbook is unsure are counted, and fewer than one in ten, though three in eight
/// are aimed at an edge or a vertex of something.
/// `cargo run --release -p rutilant-geom --example verify` takes many more rays.
#[test]
fn hits_equal_the_textbook() {
    for (name, scene) in meshes::hard_scenes() {
        let rays = 50_000_u64;
        let unsure = (0..rays)
            .into_par_iter()
            .filter(|&i| {
                let ray = aimed_ray(&scene, &mut Random(i << 20));
                !brute::check(name, &scene, &ray, scene.closest(&ray).as_ref())
            })
            .count();
        assert!(unsure as u64 * 10 < rays, "{name}: unsure about {unsure}");
    }
}

/// The tree only leaves out what is missed: the answer is that of the triangle test
/// alone, to the bit, ties included, with any instructions of the processor.
#[test]
fn the_tree_changes_no_bit() {
    for (name, scene) in meshes::hard_scenes() {
        let levels = at_every_level(&scene);
        (0..20_000_u64).into_par_iter().for_each(|i| {
            let ray = aimed_ray(&scene, &mut Random(i << 20));
            let triangle_ray = TriangleRay::new(&ray);
            let triangles = (0..scene.triangles().len() as u32).filter_map(|i| {
                let [a, b, c] = scene.triangle(i);
                triangle_ray.intersect(a, b, c).map(|hit| (hit.t, i))
            });
            let first = scene.triangles().len() as u32;
            let spheres = scene.spheres().iter().zip(first..);
            let spheres = spheres.filter_map(|(s, i)| s.intersect(&ray).map(|t| (t, i)));
            let first = first + scene.spheres().len() as u32;
            let disks = scene.disks().iter().zip(first..);
            let disks = disks.filter_map(|(d, i)| d.intersect(&ray).map(|hit| (hit.t, i)));
            let all = triangles.chain(spheres).chain(disks);
            let first = all.min_by(|a, b| a.partial_cmp(b).expect("no NaN leaves"));
            let got = scene.closest(&ray).map(|hit| (hit.t, hit.primitive));
            assert_eq!(got, first.map(|(t, i)| (t as f32, i)), "{name}: {ray:?}");
            for other in &levels {
                assert_eq!(other.closest(&ray), scene.closest(&ray), "{name}: {ray:?}");
                assert_eq!(other.occluded(&ray), got.is_some(), "{name}: {ray:?}");
            }
        });
    }
}

/// From one hit to the next a ray comes to every surface on its way once, in the order of their
/// distances and numbers, also to those in the same place: triangles, disks and spheres that are
/// there three times, and all that the hard scenes have. Stepping on by the distance alone loses
/// two of three; the order in which the tree is built, or a hit that is found twice, shows as well.
#[test]
fn one_after_the_other_all_surfaces_are_met() {
    let mut random = Random(17);
    let r = &mut random;
    let corners: Vec<[Vec3; 3]> = (0..30).map(|_| [r.point(), r.point(), r.point()]).collect();
    let turned = corners.iter().map(|[a, b, c]| [*a, *c, *b]);
    let (positions, triangles) = meshes::soup(corners.iter().copied().chain(turned));
    let again = triangles[..30].to_vec();
    let spheres = (0..5).map(|_| Sphere { center: r.point(), radius: r.unit() }).collect();
    let disks = (0..5).map(|_| Disk { center: r.point(), u: r.point(), v: r.point() }).collect();
    let (spheres, disks) = (thrice(spheres), thrice(disks));
    let options = BuildOptions::default();
    let thrice = Surfaces::new(positions, [triangles, again].concat(), spheres, disks, &options);
    for (name, scene) in meshes::hard_scenes().into_iter().chain([("thrice", thrice)]) {
        let levels = at_every_level(&scene);
        (0..2_000_u64).into_par_iter().for_each(|i| {
            let ray = aimed_ray(&scene, &mut Random(i << 20));
            let all = on_the_way(&scene, &ray);
            for level in &levels {
                let (mut hit, mut found) = (level.closest(&ray), Vec::new());
                while let Some(met) = hit
                    && found.len() < 1000
                {
                    found.push((met.t, met.primitive));
                    hit = level.closest_after(&ray, &met);
                }
                assert_eq!(wide(&scene, &found), all, "{name}: {ray:?}");
            }
        });
    }
}

/// Without the far sides of spheres that are met within a rounding of their near sides: `t_min`
/// cannot tell the two apart, and so the test cannot.
fn wide(scene: &Surfaces, all: &[(f32, u32)]) -> Vec<(f32, u32)> {
    let first = scene.triangles().len() as u32;
    let spheres = first..first + scene.spheres().len() as u32;
    let is_far_side = |&(place, (t, i)): &(usize, (f32, u32))| {
        let near = |other: &(f32, u32)| other.1 == i && other.0.next_up() >= t;
        spheres.contains(&i) && all[..place].iter().any(near)
    };
    let kept = all.iter().copied().enumerate().filter(|hit| !is_far_side(hit));
    kept.map(|(_, hit)| hit).collect()
}

fn thrice<T: Copy>(some: Vec<T>) -> Vec<T> {
    [some.clone(), some.clone(), some].concat()
}

/// Everything that a ray meets, by trying everything: distances and numbers, in their order.
fn on_the_way(scene: &Surfaces, ray: &Ray) -> Vec<(f32, u32)> {
    let triangle_ray = TriangleRay::new(ray);
    let mut all: Vec<(f64, u32)> = (0..scene.triangles().len() as u32)
        .filter_map(|i| {
            let [a, b, c] = scene.triangle(i);
            triangle_ray.intersect(a, b, c).map(|hit| (hit.t, i))
        })
        .collect();
    let first = scene.triangles().len() as u32;
    for (sphere, i) in scene.spheres().iter().zip(first..) {
        let Some(t) = sphere.intersect(ray) else { continue };
        all.push((t, i));
        let beyond = Ray { t_min: (t as f32).next_up(), ..*ray };
        all.extend(sphere.intersect(&beyond).map(|t| (t, i)));
    }
    let first = first + scene.spheres().len() as u32;
    for (disk, i) in scene.disks().iter().zip(first..) {
        all.extend(disk.intersect(ray).map(|hit| (hit.t, i)));
    }
    all.sort_by(|a, b| a.partial_cmp(b).expect("no NaN leaves"));
    wide(scene, &all.iter().map(|&(t, i)| (t as f32, i)).collect::<Vec<_>>())
}

/// Eight rays at once find what each finds alone, to the bit, with any instructions: rays that go
/// everywhere, rays that go nearly together, those with and without an end, and places where there
/// is no ray, or none that can be traced.
#[test]
fn packets_find_what_each_ray_finds() {
    for (name, scene) in meshes::hard_scenes().into_iter().chain([meshes::large_scene()]) {
        let levels = at_every_level(&scene);
        (0..6_000_u64).into_par_iter().for_each(|i| {
            let mut random = Random(i << 20);
            let first = aimed_ray(&scene, &mut random);
            let rays: [Ray; LANES] = std::array::from_fn(|lane| {
                let other = aimed_ray(&scene, &mut random);
                let turned = first.direction + (other.direction - first.direction) * 1e-3;
                let ray = if i % 2 == 0 { other } else { Ray { direction: turned, ..first } };
                match (i as usize + 3 * lane) % 11 {
                    0 => Ray { t_max: f32::INFINITY, ..ray },
                    1 => Ray { t_max: ray.t_min, ..ray },
                    2 => Ray { direction: Vec3::new(f32::NAN, 0.0, 1.0), ..ray },
                    3 => Ray { origin: Vec3::splat(f32::INFINITY), ..ray },
                    4 => Ray { t_max: random.unit(), ..ray },
                    _ => ray,
                }
            });
            let some = 1 + i as usize % LANES;
            let packet = RayPacket::new(&rays[..some]);
            for surfaces in &levels {
                let (hits, blocked) =
                    (surfaces.closest_packet(&packet), surfaces.occluded_packet(&packet));
                for (lane, ray) in rays.iter().enumerate() {
                    let expected = scene.closest(ray).filter(|_| lane < some);
                    assert_eq!(hits.hit(lane), expected, "{name}: {ray:?}");
                    assert_eq!(blocked >> lane & 1 == 1, expected.is_some(), "{name}: {ray:?}");
                }
            }
        });
    }
}

/// To know which triangle a ray leaves saves a test and changes nothing.
#[test]
fn what_a_ray_leaves_need_not_be_met() {
    for (name, scene) in meshes::hard_scenes().into_iter().chain([meshes::large_scene()]) {
        let triangles = scene.triangles().len() as u32;
        (0..6_000_u64).into_par_iter().for_each(|i| {
            let mut random = Random(i << 20);
            let mut packet = RayPacket::NONE;
            let mut known = packet;
            for lane in 0..LANES {
                let Some(hit) = scene.closest(&aimed_ray(&scene, &mut random)) else { continue };
                let direction = aimed_ray(&scene, &mut random).direction.normalize();
                if hit.normal.dot(direction).abs() < 1e-5 {
                    continue;
                }
                let origin = offset_origin(hit.position, hit.normal, direction);
                packet.set(lane, &Ray::new(origin, direction));
                known.set(lane, &Ray::new(origin, direction));
                known.leaves[lane] =
                    if hit.primitive < triangles { hit.primitive } else { HitPacket::NOTHING };
            }
            let (all, without) = (scene.closest_packet(&packet), scene.closest_packet(&known));
            for lane in 0..LANES {
                assert_eq!(all.hit(lane), without.hit(lane), "{name}: {:?}", packet.ray(lane));
            }
            assert_eq!(scene.occluded_packet(&packet), scene.occluded_packet(&known), "{name}");
        });
    }
}

/// From inside a closed mesh every ray meets it, also one aimed exactly at a vertex
/// or an edge.
#[test]
fn closed_meshes_have_no_cracks() {
    for (name, mesh, middle, half) in meshes::closed_meshes() {
        for scene in at_every_level(&meshes::surfaces(mesh)) {
            let leaks = (0..200_000_u64)
                .into_par_iter()
                .filter(|&i| {
                    let ray = meshes::ray_at_an_edge(&scene, middle, half, &mut Random(i << 20));
                    scene.closest(&ray).is_none()
                })
                .count();
            assert_eq!(leaks, 0, "{name}");
        }
    }
}

/// The same surfaces met with all instructions that this processor has.
fn at_every_level(scene: &Surfaces) -> Vec<Surfaces> {
    let levels = [Simd::Auto, Simd::Scalar, Simd::Sse4, Simd::Avx2];
    levels.into_iter().filter_map(|simd| scene.clone().with_simd(simd)).collect()
}

/// A shadow ray is blocked exactly if the closest hit lies before its end. The old
/// program let things behind the light block it.
#[test]
fn a_ray_is_blocked_exactly_before_its_end() {
    for (name, scene) in meshes::hard_scenes() {
        (0..20_000_u64).into_par_iter().for_each(|i| {
            let mut random = Random(i << 20);
            let ray = Ray { t_min: 0.0, t_max: f32::INFINITY, ..aimed_ray(&scene, &mut random) };
            let hit = scene.closest(&ray);
            assert_eq!(scene.occluded(&ray), hit.is_some(), "{name}: {ray:?}");
            let Some(hit) = hit else { return };
            let until = |t_max: f32| scene.occluded(&Ray { t_max, ..ray });
            assert!(until(hit.t.next_up()), "{name}: {ray:?} {hit:?}");
            assert!(!until(hit.t.next_down()), "{name}: {ray:?} {hit:?}");
            let t_max = random.unit() * 2.0;
            assert_eq!(until(t_max), scene.closest(&Ray { t_max, ..ray }).is_some());
            if t_max != hit.t {
                assert_eq!(until(t_max), hit.t < t_max, "{name}: {ray:?} {hit:?}");
            }
        });
    }
}

/// Naming the triangles in another order changes only their names.
#[test]
fn the_order_of_primitives_does_not_matter() {
    for (name, scene) in meshes::hard_scenes() {
        let mut random = Random(3);
        let n = scene.triangles().len();
        let mut order: Vec<usize> = (0..n).collect();
        for i in (1..n).rev() {
            order.swap(i, random.below(i + 1));
        }
        let shuffled = Surfaces::new(
            scene.positions().to_vec(),
            order.iter().map(|&i| scene.triangles()[i]).collect(),
            scene.spheres().to_vec(),
            scene.disks().to_vec(),
            &BuildOptions::default(),
        );
        for i in 0..20_000_u64 {
            let ray = aimed_ray(&scene, &mut Random(i << 20));
            let (one, other) = (scene.closest(&ray), shuffled.closest(&ray));
            let t = |hit: Option<rutilant_geom::Hit>| hit.map(|hit| hit.t.to_bits());
            assert_eq!(t(one), t(other), "{name}: {ray:?}");
            if let (Some(one), Some(other)) = (one, other) {
                // On a shared edge the smaller number wins, and that one may differ.
                let back =
                    order.get(other.primitive as usize).map_or(other.primitive, |&i| i as u32);
                let tie = || {
                    let [a, b, c] = scene.triangle(back);
                    TriangleRay::new(&ray).intersect(a, b, c).is_some_and(|h| h.t as f32 == one.t)
                };
                assert!(one.primitive == back || tie(), "{name}: {one:?} {other:?}");
                assert!((one.position - other.position).length() <= 1e-3, "{one:?} {other:?}");
            }
        }
    }
}

/// How much time a tree took does not change a bit of what is found in it, and the report counts
/// the same primitives.
#[test]
fn the_quality_of_the_tree_changes_no_bit() {
    for (name, scene) in meshes::hard_scenes() {
        for quality in [Quality::Fast, Quality::High] {
            let other = Surfaces::new(
                scene.positions().to_vec(),
                scene.triangles().to_vec(),
                scene.spheres().to_vec(),
                scene.disks().to_vec(),
                &quality.into(),
            );
            let counted = |scene: &Surfaces| (scene.report().primitives, scene.report().left_out);
            assert_eq!(counted(&other), counted(&scene), "{name}, {quality:?}");
            for i in 0..20_000_u64 {
                let ray = aimed_ray(&scene, &mut Random(i << 20));
                assert_eq!(
                    other.closest(&ray),
                    scene.closest(&ray),
                    "{name}, {quality:?}: {ray:?}"
                );
                assert_eq!(
                    other.occluded(&ray),
                    scene.occluded(&ray),
                    "{name}, {quality:?}: {ray:?}"
                );
            }
        }
    }
}

/// Of many parallel walls the nearest is met, in whichever order they are given, and
/// however small or large walls and direction are.
/// In the old program a later, farther triangle replaced a nearer one.
#[test]
fn a_farther_triangle_never_replaces_a_nearer_one() {
    let mut random = Random(11);
    for (size, speed) in [(1.0_f32, 1.0_f32), (1e-20, 1e30), (1e20, 1e-20), (1e-10, 1e-30)] {
        let wall = |z: f32| {
            [[-9.0, -9.0, z], [9.0, -9.0, z], [0.0, 9.0, z]].map(|p| Vec3::from_array(p) * size)
        };
        for walls in 1..40 {
            let mut depths: Vec<f32> = (1..=walls).map(|i| i as f32).collect();
            for i in (1..depths.len()).rev() {
                depths.swap(i, random.below(i + 1));
            }
            let scene = meshes::surfaces(meshes::soup(depths.iter().map(|&z| wall(z))));
            let forth = Ray::new(Vec3::ZERO, Vec3::Z * speed);
            let back = Ray::new(Vec3::new(0.0, 0.0, 50.0) * size, Vec3::NEG_Z * speed);
            let depth_of = |ray| depths[scene.closest(ray).expect("a wall").primitive as usize];
            assert_eq!((depth_of(&forth), depth_of(&back)), (1.0, walls as f32));
        }
    }
}

/// A segment ends before the light: neither the light nor a wall behind it blocks
/// it, at any distance. The old program took 1e-6 off the distance, which is
/// nothing beyond four metres.
#[test]
fn a_light_does_not_block_its_own_ray() {
    for distance in [1e-3_f32, 0.1, 1.0, 4.0, 5.0, 33.0, 1e4, 1e6] {
        let lamp = |z: f32| [Vec3::new(-z, -z, z), Vec3::new(z, -z, z), Vec3::new(0.0, z, z)];
        let scene = meshes::surfaces(meshes::soup([lamp(distance), lamp(distance * 1.1)]));
        let ray = Ray::between(Vec3::ZERO, Vec3::new(0.0, 0.0, distance));
        assert!(!scene.occluded(&ray), "{distance}");
        assert!(scene.occluded(&Ray { t_max: 1.0_f32.next_up(), ..ray }), "{distance}");
    }
}

/// Triangles are met at any size. In the old program those with edges below 3.5e-4
/// fell below an absolute epsilon and vanished.
#[test]
fn small_triangles_do_not_vanish() {
    for size in [1e-30_f32, 1e-12, 1e-5, 3e-4, 1.0, 1e12, 1e30] {
        let scene = meshes::surfaces(meshes::soup([[
            Vec3::ZERO,
            Vec3::new(size, 0.0, 0.0),
            Vec3::new(0.0, size, 0.0),
        ]]));
        let origin = Vec3::new(0.25, 0.25, 1.0) * size;
        for direction in [Vec3::NEG_Z, Vec3::NEG_Z * size, Vec3::NEG_Z * 1e-20] {
            let hit = scene.closest(&Ray::new(origin, direction)).expect("the triangle");
            assert_eq!((hit.u, hit.v, hit.normal), (0.25, 0.25, Vec3::Z));
            assert_eq!(hit.position, Vec3::new(0.25 * size, 0.25 * size, 0.0));
        }
    }
}

/// What a hit says fits together: the point is on the ray, on the surface, at the
/// stated coordinates, and the normal has length one.
#[test]
fn a_hit_is_consistent() {
    for (name, scene) in meshes::hard_scenes() {
        for i in 0..20_000_u64 {
            let ray = aimed_ray(&scene, &mut Random(i << 20));
            let Some(hit) = scene.closest(&ray) else { continue };
            assert!((hit.normal.length() - 1.0).abs() < 1e-6, "{name}: {hit:?}");
            let size = ray.origin.length() + (ray.direction * hit.t).length();
            assert!((ray.at(hit.t) - hit.position).length() < 1e-6 * size, "{name}: {hit:?}");
            let (triangles, spheres) = (scene.triangles().len(), scene.spheres().len());
            let i = hit.primitive as usize;
            let there = if i < triangles {
                let [a, b, c] = scene.triangle(hit.primitive);
                a + (b - a) * hit.u + (c - a) * hit.v
            } else if i < triangles + spheres {
                let sphere = scene.spheres()[i - triangles];
                let (longitude, latitude) =
                    ((hit.u - 0.5) * std::f32::consts::TAU, (hit.v - 0.5) * std::f32::consts::PI);
                let (s, c) = rutilant_geom::real::sin_cos(longitude);
                let (up, out) = rutilant_geom::real::sin_cos(latitude);
                sphere.center + Vec3::new(s * out, up, c * out) * sphere.radius
            } else {
                let disk = scene.disks()[i - triangles - spheres];
                disk.center + disk.u * hit.u + disk.v * hit.v
            };
            assert!((there - hit.position).length() < 2e-6 * size, "{name}: {hit:?} {there}");
        }
    }
}
