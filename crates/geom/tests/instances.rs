//! What stands in many places is met as if each place had a copy of its own, to the bit.

mod common;

use common::meshes::{self, Mesh};
use common::{Random, aimed_ray};
use rayon::prelude::*;
use rutilant_geom::lanes::LANES;
use rutilant_geom::{
    BuildOptions, Contents, Hit, Instance, Mat3, Quality, Ray, RayPacket, SharedMesh, Simd, Sphere,
    Surfaces, Transform, Vec3,
};
use std::sync::Arc;

/// A mesh in one place.
#[derive(Clone, Copy)]
struct Placed {
    mesh: usize,
    turned: bool,
    world_from_mesh: Transform,
    /// Whether it becomes a copy in both worlds.
    alone: bool,
}

/// The same world twice: with copies, and with instances. And what each number there stands for,
/// as the number of the place and of the triangle.
struct Both {
    name: &'static str,
    copies: Surfaces,
    instances: Surfaces,
    copied: Vec<(u32, u32)>,
    alone: Vec<(u32, u32)>,
    places: Vec<u32>,
}

impl Both {
    fn new(name: &'static str, all: &[Mesh], places: &[Placed], options: &BuildOptions) -> Self {
        let shared = |(positions, triangles): &Mesh| {
            SharedMesh::new(positions.clone(), triangles.clone(), options).map(Arc::new)
        };
        let shared: Option<Vec<_>> = all.iter().map(shared).collect();
        let ball = Sphere { center: Vec3::new(0.4, 0.1, -0.2), radius: 0.3 };
        let world = || Contents { spheres: vec![ball], ..Contents::default() };
        let (mut flat, mut deep) = (world(), world());
        deep.meshes = shared.expect("coordinates of a usual size");
        let (mut copied, mut alone, mut numbers) = (vec![], vec![], vec![]);
        for (place, placed) in (0..).zip(places) {
            let (positions, triangles) = &all[placed.mesh];
            let copy = |contents: &mut Contents, known: &mut Vec<(u32, u32)>| {
                let first = contents.positions.len() as u32;
                let moved = positions.iter().map(|p| placed.world_from_mesh.point(*p));
                contents.positions.extend(moved);
                for (i, [a, b, c]) in (0..).zip(triangles) {
                    let triangle = if placed.turned { [a, c, b] } else { [a, b, c] };
                    contents.triangles.push(triangle.map(|v| v + first));
                    known.push((place, i));
                }
            };
            copy(&mut flat, &mut copied);
            if placed.alone {
                copy(&mut deep, &mut alone);
                continue;
            }
            let bounds = deep.meshes[placed.mesh].bounds();
            assert!(Instance::can_place(&placed.world_from_mesh, &bounds), "{name}");
            deep.instances.push(Instance {
                mesh: placed.mesh as u32,
                turned: placed.turned,
                after: deep.triangles.len() as u32,
                world_from_mesh: placed.world_from_mesh,
            });
            numbers.push(place);
        }
        let (copies, instances) = (Surfaces::of(flat, options), Surfaces::of(deep, options));
        assert_eq!(copies.bounds(), instances.bounds(), "{name}");
        Self { name, copies, instances, copied, alone, places: numbers }
    }

    /// What was met, in words that both worlds share.
    fn told(&self, hit: Option<Hit>, in_copies: bool) -> Option<(Option<(u32, u32)>, Hit)> {
        let hit = hit?;
        let what = self.what(hit.instance, hit.primitive, in_copies);
        Some((what, Hit { instance: None, primitive: 0, ..hit }))
    }

    fn what(&self, instance: Option<u32>, primitive: u32, in_copies: bool) -> Option<(u32, u32)> {
        let known = if in_copies { &self.copied } else { &self.alone };
        match instance {
            Some(instance) => Some((self.places[instance as usize], primitive)),
            None => known.get(primitive as usize).copied(),
        }
    }

    /// A ray from around everything, from close to one place or from very far away, aimed at a
    /// vertex, an edge or the inside of a triangle, or anywhere.
    fn ray(&self, random: &mut Random) -> Ray {
        let mut ray = aimed_ray(&self.copies, random);
        if random.unit() < 0.5 {
            let target = ray.origin + ray.direction;
            let [a, b, _] = self.copies.triangle(random.below(self.copied.len()) as u32);
            let sizes = if random.below(4) == 0 { random.size(3, 10) } else { random.size(-3, 2) };
            ray.origin = target + random.direction() * ((a - b).length() * sizes);
            ray.direction = target - ray.origin;
        }
        ray
    }
}

/// Worlds whose places are hard in different ways.
fn worlds() -> Vec<Both> {
    let mut random = Random(21);
    let r = &mut random;
    let options = BuildOptions::default();
    let soup = meshes::soup((0..60).map(|_| {
        let p = r.point();
        [p, p + r.point() * 0.3, p + r.point() * 0.3]
    }));
    let needles = meshes::soup((0..60).map(|_| {
        let (p, way) = (r.point(), r.point());
        [p, p + way, p + way * r.unit() + r.point() * r.size(-7, -1)]
    }));
    let flat = meshes::soup((0..40).map(|_| {
        let p = r.point();
        // Some have no area, until they are mapped and rounded.
        if r.below(3) == 0 { [p, p * 0.5, p * 2.0] } else { [p, r.point(), r.point()] }
    }));
    let far = meshes::moved(meshes::icosphere(2), |p| p + Vec3::new(512.3, -77.7, 1024.9));
    let all = [meshes::icosphere(2), soup, needles, meshes::cube(), flat, far];
    let linear = |r: &mut Random| Mat3::from_cols(r.point(), r.point(), r.point());
    let place = |r: &mut Random, mesh: usize, linear: Mat3, translation: Vec3| Placed {
        mesh,
        turned: linear.determinant() < 0.0 || r.below(5) == 0,
        world_from_mesh: Transform::new(linear, translation),
        alone: r.below(6) == 0,
    };
    let mut worlds = vec![];
    let mut add = |name, all: &[Mesh], places: &[Placed]| {
        let proper = |p: &&Placed| {
            let (positions, _) = &all[p.mesh];
            let bounds = rutilant_geom::Aabb::around(positions.iter().copied());
            Instance::can_place(&p.world_from_mesh, &bounds)
        };
        let places: Vec<Placed> = places.iter().filter(proper).copied().collect();
        assert!(places.len() >= 10, "{name}");
        worlds.push(Both::new(name, all, &places, &options));
    };

    // Sheared and mirrored, one through the other.
    let some: Vec<_> = (0..40)
        .map(|i| {
            let (map, to) = (linear(r) * 0.4, r.point());
            place(r, i % 5, map, to)
        })
        .collect();
    add("sheared", &all, &some);

    // Scales that have nothing to do with each other, and so far away that little is left of them.
    let some: Vec<_> = (0..40)
        .map(|i| {
            let scale = Vec3::new(r.size(-6, 6), r.size(-6, 6), -r.size(-6, 6));
            let to = r.point() * r.size(-6, 6);
            place(r, i % 5, Mat3::from_diagonal(scale), to)
        })
        .collect();
    add("scaled by 1e-6 to 1e6", &all, &some);

    // Turned, squeezed, and turned back.
    let some: Vec<_> = (0..40)
        .map(|i| {
            let turn = |r: &mut Random| {
                Transform::rotate_degrees(r.direction(), r.between(-180.0, 180.0)).linear()
            };
            let squeeze = Mat3::from_diagonal(Vec3::new(r.size(-2, 0), 1.0, r.size(-1, 1)));
            let (map, to) = (turn(r) * squeeze * turn(r), r.point());
            place(r, i % 5, map, to)
        })
        .collect();
    add("squeezed along any axis", &all, &some);

    // Far from the scene's origin, where coordinates are coarse; and far from its own.
    let away = Vec3::new(100_003.0, -20_011.0, 49_757.0);
    let some: Vec<_> = (0..40)
        .map(|i| {
            let (map, to) = (linear(r) * r.size(-2, 1), away + r.point() * 3.0);
            place(r, i % 6, map, to)
        })
        .collect();
    add("far", &all, &some);

    // Each stands several times at the very same place: which of them counts?
    let some: Vec<_> = (0..10)
        .flat_map(|i| {
            let (map, to) = (linear(r) * 0.5, r.point());
            [(); 4].map(|()| place(r, i % 5, map, to))
        })
        .collect();
    add("duplicates", &all, &some);

    // A wall of cubes whose sides touch.
    let some: Vec<_> = (0..36)
        .map(|i| {
            let to = Vec3::new((i % 6) as f32, (i / 6) as f32, 0.0) * 0.2;
            place(r, 3, Mat3::IDENTITY * 0.1, to)
        })
        .collect();
    add("wall", &all, &some);
    worlds
}

/// The same surfaces met with all instructions that this processor has.
fn at_every_level(scene: &Surfaces) -> Vec<Surfaces> {
    let levels = [Simd::Auto, Simd::Scalar, Simd::Sse4, Simd::Avx2];
    levels.into_iter().filter_map(|simd| scene.clone().with_simd(simd)).collect()
}

/// Closest hits, those after them, blocked rays and packets have the bits that copies of the mesh give, ties
/// included: a vertex mapped otherwise, too little room for rounding, a lost side of a mirrored
/// triangle, a wrong end of a ray all show here.
#[test]
fn instances_are_met_as_copies_are() {
    for both in worlds() {
        let levels = at_every_level(&both.instances);
        let met: usize = (0..6_000_u64)
            .into_par_iter()
            .map(|i| {
                let mut random = Random(i << 20);
                let ray = both.ray(&mut random);
                let expected = both.told(both.copies.closest(&ray), true);
                let blocked = both.copies.occluded(&ray);
                for level in &levels {
                    let found = both.told(level.closest(&ray), false);
                    assert_eq!(found, expected, "{}: {ray:?}", both.name);
                    assert_eq!(level.occluded(&ray), blocked, "{}: {ray:?}", both.name);
                }
                // And all that comes after it, one by one.
                let (mut copy, mut place) =
                    (both.copies.closest(&ray), both.instances.closest(&ray));
                while let (Some(met), Some(there)) = (copy, place) {
                    copy = both.copies.closest_after(&ray, &met);
                    place = both.instances.closest_after(&ray, &there);
                    let (copied, placed) = (both.told(copy, true), both.told(place, false));
                    assert_eq!(placed, copied, "{}: {ray:?}", both.name);
                }
                usize::from(expected.is_some())
            })
            .sum();
        // One world is so wide that most rays meet nothing.
        assert!(met > 500, "{}: {met}", both.name);
    }
}

/// Eight rays at once find what each finds alone.
#[test]
fn packets_meet_instances_as_single_rays_do() {
    for both in worlds() {
        for scene in at_every_level(&both.instances) {
            (0..1_200_u64).into_par_iter().for_each(|i| {
                let mut random = Random(i << 20);
                let first = both.ray(&mut random);
                let rays: [Ray; LANES] = std::array::from_fn(|_| {
                    let other = both.ray(&mut random);
                    let turned = first.direction + (other.direction - first.direction) * 1e-3;
                    if i % 2 == 0 { other } else { Ray { direction: turned, ..first } }
                });
                let packet = RayPacket::new(&rays);
                let (hits, blocked) =
                    (scene.closest_packet(&packet), scene.occluded_packet(&packet));
                for (lane, ray) in rays.iter().enumerate() {
                    let expected = both.told(both.copies.closest(ray), true);
                    let found = both.told(hits.hit(lane), false);
                    assert_eq!(found, expected, "{}: {ray:?}", both.name);
                    assert_eq!(blocked >> lane & 1 == 1, expected.is_some(), "{}", both.name);
                }
            });
        }
    }
}

/// From inside a closed mesh every ray meets it, wherever it stands.
#[test]
fn closed_instances_have_no_cracks() {
    let mut random = Random(5);
    for (name, (positions, triangles), middle, half) in meshes::closed_meshes() {
        let options = BuildOptions::default();
        let mesh = SharedMesh::new(positions, triangles, &options).expect("usual coordinates");
        let linear = Mat3::from_cols(random.point(), random.point(), random.point());
        let world_from_mesh = Transform::new(linear, random.point() * 10.0);
        let instance = Instance { mesh: 0, turned: false, after: 0, world_from_mesh };
        let count = mesh.triangles().len();
        let (meshes, instances) = (vec![Arc::new(mesh)], vec![instance]);
        let contents = Contents { meshes, instances, ..Contents::default() };
        let scene = Surfaces::of(contents, &options);
        let leaks = (0..50_000_u64)
            .into_par_iter()
            .filter(|&i| {
                let mut random = Random(i << 20);
                let [a, b, c] = scene.triangle_of_instance(0, random.below(count) as u32);
                let target = match random.below(4) {
                    0 => a,
                    1 => (b + c) * 0.5,
                    _ => a + (b - a) * random.unit(),
                };
                let origin = world_from_mesh.point(middle + half * random.point());
                let ray = Ray::new(origin, target - origin);
                scene.closest(&ray).is_none() || !scene.occluded(&ray)
            })
            .count();
        assert_eq!(leaks, 0, "{name}");
    }
}

/// Surfaces that touch are told of, whether they are copies or not.
#[test]
fn what_touches_is_told_of() {
    for both in worlds().into_iter().filter(|both| ["duplicates", "wall"].contains(&both.name)) {
        let mut touching = 0;
        for i in 0..3_000_u64 {
            let ray = both.ray(&mut Random(i << 20));
            let Some(hit) = both.copies.closest(&ray) else { continue };
            let ends = [-ray.direction, ray.direction]
                .map(|to| rutilant_geom::offset_origin(hit.position, hit.normal, to));
            let told = |surfaces: &Surfaces, in_copies| {
                let hit = surfaces.closest(&ray).expect("both meet it");
                let mut all = vec![];
                surfaces.at_the_same_place(&ray, &hit, ends, |instance, primitive, front| {
                    all.push((both.what(instance, primitive, in_copies), front));
                });
                all.sort_unstable();
                all
            };
            let expected = told(&both.copies, true);
            touching += usize::from(expected.len() > 1);
            assert_eq!(told(&both.instances, false), expected, "{}: {ray:?}", both.name);
        }
        assert!(touching > 200, "{}: {touching}", both.name);
    }
}

/// How much time the trees took changes nothing; a tree of instances alone, one of a single one and
/// one of none can be built.
#[test]
fn the_quality_of_the_tree_changes_no_bit() {
    let all = [meshes::icosphere(2)];
    let mut random = Random(9);
    for count in [0, 1, 200] {
        let places: Vec<Placed> = (0..count)
            .map(|_| Placed {
                mesh: 0,
                turned: false,
                world_from_mesh: Transform::new(Mat3::IDENTITY * 0.2, random.point()),
                alone: false,
            })
            .collect();
        for quality in [Quality::Fast, Quality::Default, Quality::High] {
            let both = Both::new("many", &all, &places, &quality.into());
            assert_eq!(both.instances.report().left_out.count, 0);
            for i in 0..3_000_u64 {
                let ray = aimed_ray(&both.copies, &mut Random(i << 20));
                let expected = both.told(both.copies.closest(&ray), true);
                assert_eq!(both.told(both.instances.closest(&ray), false), expected);
            }
        }
    }
}

/// What cannot be placed exactly enough is refused, and left out where it is placed all the same.
#[test]
fn maps_that_lose_too_much_are_refused() {
    let bounds = rutilant_geom::Aabb::around([Vec3::splat(-1.0), Vec3::ONE]);
    let can = |linear: Mat3, translation: Vec3| {
        Instance::can_place(&Transform::new(linear, translation), &bounds)
    };
    assert!(can(Mat3::IDENTITY, Vec3::ZERO));
    assert!(can(Mat3::from_diagonal(Vec3::new(1e-6, 1e6, -1.0)), Vec3::splat(1e6)));
    let flat = Mat3::from_cols(Vec3::X, Vec3::Y, Vec3::X + Vec3::Y);
    assert!(!can(flat, Vec3::ZERO));
    // Three directions that are nearly one: the determinant is what little is left of large numbers.
    let near = 1.0 + f32::EPSILON;
    let columns = [Vec3::new(near, 1.0, 1.0), Vec3::new(1.0, near, 1.0), Vec3::new(1.0, 1.0, near)];
    assert!(!can(Mat3::from_cols_array_2d(&columns.map(|c| c.to_array())), Vec3::ZERO));
    assert!(!can(Mat3::IDENTITY, Vec3::X * 1e20));
    assert!(!can(Mat3::from_diagonal(Vec3::new(f32::NAN, 1.0, 1.0)), Vec3::ZERO));
    assert!(!can(Mat3::IDENTITY, Vec3::new(0.0, f32::INFINITY, 0.0)));

    let (positions, triangles) = meshes::cube();
    let mesh = SharedMesh::new(positions, triangles, &BuildOptions::default()).expect("a cube");
    let instance = |linear| Instance {
        mesh: 0,
        turned: false,
        after: 0,
        world_from_mesh: Transform::new(linear, Vec3::ZERO),
    };
    let instances =
        vec![instance(flat), instance(Mat3::IDENTITY), Instance { mesh: 7, ..instance(flat) }];
    let contents = Contents { meshes: vec![Arc::new(mesh)], instances, ..Contents::default() };
    let scene = Surfaces::of(contents, &BuildOptions::default());
    assert_eq!(scene.report().left_out.count, 2);
    let hit = scene.closest(&Ray::new(Vec3::Z * 5.0, Vec3::NEG_Z)).expect("the cube");
    assert_eq!((hit.instance, hit.t), (Some(1), 4.0));
}
