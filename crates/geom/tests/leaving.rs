//! A ray that leaves a surface leaves it: it neither meets it again nor slips through.

mod common;

use common::{Random, meshes};
use rayon::prelude::*;
use rutilant_geom::{BuildOptions, Disk, Hit, Ray, Sphere, Surfaces, Vec3, offset_origin};

/// Some direction on the side of `normal`, often close to the surface.
fn outwards(normal: Vec3, random: &mut Random) -> Vec3 {
    let flat = random.size(-5, 0).min(1.0);
    loop {
        let d = random.direction();
        let along = d - normal * d.dot(normal);
        let d = along.normalize_or_zero() + normal * flat;
        // Nearer to the surface the rounded normal cannot tell the sides apart.
        if normal.dot(d) > 1e-6 {
            return d * random.size(-3, 3);
        }
    }
}

/// A ray onto some point of the only surface, and its hit.
fn hit_of(scene: &Surfaces, target: Vec3, size: f32, random: &mut Random) -> Option<Hit> {
    let origin = target + random.direction() * size * random.size(-1, 2);
    scene.closest(&Ray::new(origin, target - origin))
}

/// Triangles of all sizes at all places: near the scene's origin, where positions are
/// exact but edges are long, and far away, where they are rounded coarsely.
#[test]
fn a_ray_never_meets_the_triangle_it_leaves() {
    let found: usize = (0..300_000_u64)
        .into_par_iter()
        .map(|i| {
            let random = &mut Random(i << 20);
            let size = random.size(-6, 6);
            let place = random.point() * size * random.size(-9, 4);
            let corner = |random: &mut Random| place + random.point() * size;
            let mut triangle = [corner(random), corner(random), corner(random)];
            match random.below(5) {
                // In a plane through the scene's origin: along two axes, aslant, or any.
                0 => triangle = triangle.map(|p| Vec3::new(p.x, 0.0, p.z)),
                1 => triangle = triangle.map(|p| Vec3::new(p.x, p.z, p.z)),
                2 => triangle[1] = -triangle[0],
                3 => {
                    // A needle.
                    let foot = triangle[0].lerp(triangle[1], 0.3);
                    triangle[2] = foot + random.point() * size * 1e-5;
                }
                _ => {}
            }
            let scene = meshes::surfaces(meshes::soup([triangle]));
            let target = if random.below(3) == 0 {
                Vec3::ZERO
            } else {
                let (u, v) = (random.unit(), random.unit());
                let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                triangle[0] + (triangle[1] - triangle[0]) * u + (triangle[2] - triangle[0]) * v
            };
            let Some(hit) = hit_of(&scene, target, size, random) else { return 0 };
            for side in [hit.normal, -hit.normal] {
                let direction = outwards(side, random);
                let origin = offset_origin(hit.position, hit.normal, direction);
                let again = scene.closest(&Ray::new(origin, direction));
                assert!(again.is_none(), "{i}: {triangle:?} {hit:?} {again:?}");
            }
            1
        })
        .sum();
    assert!(found > 100_000, "only {found} tried");
}

/// Spheres from far smaller than a unit in the last place of their centre to huge.
#[test]
fn a_ray_never_meets_the_sphere_it_leaves() {
    let found: usize = (0..300_000_u64)
        .into_par_iter()
        .map(|i| {
            let random = &mut Random(i << 20);
            let radius = random.size(-6, 6);
            let mut center = random.point() * radius * random.size(-9, 6);
            let mut target = center + random.point() * radius * 0.5;
            if i % 4 == 0 {
                // Through the scene's origin, where no rounding of positions gives room.
                center = [Vec3::X, Vec3::NEG_Y, Vec3::Z][random.below(3)] * radius;
                target = Vec3::ZERO;
            }
            let spheres = vec![Sphere { center, radius }];
            let scene = Surfaces::new(vec![], vec![], spheres, vec![], &BuildOptions::default());
            let Some(hit) = hit_of(&scene, target, radius, random) else { return 0 };
            let direction = outwards(hit.normal, random);
            let origin = offset_origin(hit.position, hit.normal, direction);
            let again = scene.closest(&Ray::new(origin, direction));
            assert!(again.is_none(), "{i}: {center} {radius} {hit:?} {again:?}");

            // Inwards it meets the other side, if numbers are fine enough to be inside at all.
            if center.length() < 1e4 * radius {
                let direction = outwards(-hit.normal, random);
                let origin = offset_origin(hit.position, hit.normal, direction);
                let across = scene.closest(&Ray::new(origin, direction));
                let across = across.expect("the other side");
                let flatness = -hit.normal.dot(direction.normalize());
                let far = (across.position - hit.position).length() / radius;
                assert!(far > flatness && far < 2.001, "{i}: {hit:?} {across:?}");
            }
            1
        })
        .sum();
    assert!(found > 100_000, "only {found} tried");
}

/// Disks, round and stretched.
#[test]
fn a_ray_never_meets_the_disk_it_leaves() {
    let found: usize = (0..100_000_u64)
        .into_par_iter()
        .map(|i| {
            let random = &mut Random(i << 20);
            let size = random.size(-6, 6);
            let mut center = random.point() * size * random.size(-9, 4);
            let (u, v) = (random.point() * size, random.point() * size);
            let mut target = center + u * random.between(-0.7, 0.7) + v * random.between(-0.7, 0.7);
            if i % 4 == 0 {
                (center, target) = (u * -0.5, Vec3::ZERO);
            }
            let disks = vec![Disk { center, u, v }];
            let scene = Surfaces::new(vec![], vec![], vec![], disks, &BuildOptions::default());
            let Some(hit) = hit_of(&scene, target, size, random) else { return 0 };
            for side in [hit.normal, -hit.normal] {
                let direction = outwards(side, random);
                let origin = offset_origin(hit.position, hit.normal, direction);
                let again = scene.closest(&Ray::new(origin, direction));
                assert!(again.is_none(), "{i}: {center} {u} {v} {hit:?} {again:?}");
            }
            1
        })
        .sum();
    assert!(found > 50_000, "only {found} tried");
}

/// From a closed mesh inwards every ray meets the mesh; outwards from a convex one none does.
///
/// From a vertex or an edge, where inwards of one triangle may be outwards of the next,
/// inwards means towards a point inside.
#[test]
fn a_ray_never_slips_through_the_mesh_it_leaves() {
    for (name, mesh, middle, half) in meshes::closed_meshes() {
        let scene = meshes::surfaces(mesh);
        (0..200_000_u64).into_par_iter().for_each(|i| {
            let random = &mut Random(i << 20);
            let at_an_edge = i % 2 == 0;
            let ray = meshes::ray_at_an_edge(&scene, middle, half, random);
            let ray =
                if at_an_edge { ray } else { Ray::new(ray.origin, random.direction() * half) };
            let hit = scene.closest(&ray).expect("a wall");
            let inwards = if at_an_edge {
                middle + half * random.point() - hit.position
            } else {
                outwards(-hit.normal, random)
            };
            let origin = offset_origin(hit.position, hit.normal, inwards);
            let next = scene.closest(&Ray::new(origin, inwards));
            assert!(next.is_some(), "{name} {i}: {hit:?} {origin} {inwards}");
            if name == "cube" {
                let out = outwards(hit.normal, random);
                let origin = offset_origin(hit.position, hit.normal, out);
                assert!(!scene.occluded(&Ray::new(origin, out)), "{name} {i}: {hit:?}");
            }
        });
    }
}

/// Of surfaces that touch a ray meets one, and is told of the others: the same triangle turned
/// round or shared by a larger one, at any scale and through the scene's origin; but not of one
/// that lies apart by more than the next ray's origin is moved.
#[test]
fn surfaces_that_touch_are_told_of() {
    let found: usize = (0..100_000_u64)
        .into_par_iter()
        .map(|i| {
            let random = &mut Random(i << 20);
            let size = random.size(-3, 3);
            // Every fourth lies in a plane through the scene's origin.
            let (axis, flat) = (random.below(3), i % 4 == 0);
            let mut far = random.point() * size * random.size(-3, 2);
            let mut side = || random.point() * size;
            let (mut u, mut v) = (side(), side());
            if flat {
                (far[axis], u[axis], v[axis]) = (0.0, 0.0, 0.0);
            }
            let [a, b, c] = [far, far + u, far + v];
            let normal = u.cross(v).normalize_or_zero();
            // Apart by a hundred times what numbers of this size may lose.
            let lift = normal * 1e-5 * far.abs().max_element().max(size);
            let positions = vec![a, b, c, a + lift, b + lift, c + lift];
            let triangles = vec![[0, 1, 2], [2, 1, 0], [3, 4, 5]];
            let options = BuildOptions::default();
            let scene = Surfaces::new(positions, triangles, vec![], vec![], &options);
            let target = (a + b + c) / 3.0;
            let way = random.direction() * size * 3.0;
            // From behind, so that the lifted one is met last; and not nearly in the surface.
            let way = if way.dot(normal) < 0.0 { -way } else { way };
            if way.normalize().dot(normal) < 0.05 {
                return 0;
            }
            let ray = Ray::new(target - way, way);
            let Some(hit) = scene.closest(&ray) else { return 0 };
            assert!(hit.primitive < 2, "{i}: {hit:?}");
            let ends = [-way, way].map(|way| offset_origin(hit.position, hit.normal, way));
            let mut met = vec![];
            scene.at_the_same_place(&ray, &hit, ends, |_, primitive, front| {
                met.push((primitive, front));
            });
            met.sort_unstable();
            assert_eq!(met, [(0, false), (1, true)], "{i}: {a} {b} {c} {hit:?}");
            1
        })
        .sum();
    assert!(found > 50_000, "only {found} tried");
}
