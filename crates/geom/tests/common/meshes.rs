//! Closed meshes, and scenes that are hard to trace.

use super::Random;
use rutilant_geom::{BuildOptions, Disk, Ray, Sphere, Surfaces, Vec3};
use std::collections::HashMap;

/// Vertices, and triangles counter-clockwise from outside.
pub(crate) type Mesh = (Vec<Vec3>, Vec<[u32; 3]>);

/// A unit sphere of 20 · 4^levels triangles.
pub(crate) fn icosphere(levels: u32) -> Mesh {
    let g = 1.618_034_f32;
    let mut positions: Vec<Vec3> = [
        [-1.0, g, 0.0],
        [1.0, g, 0.0],
        [-1.0, -g, 0.0],
        [1.0, -g, 0.0],
        [0.0, -1.0, g],
        [0.0, 1.0, g],
        [0.0, -1.0, -g],
        [0.0, 1.0, -g],
        [g, 0.0, -1.0],
        [g, 0.0, 1.0],
        [-g, 0.0, -1.0],
        [-g, 0.0, 1.0],
    ]
    .map(|p| Vec3::from_array(p).normalize())
    .to_vec();
    let mut triangles = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    for _ in 0..levels {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                positions.push((positions[a as usize] + positions[b as usize]).normalize());
                positions.len() as u32 - 1
            })
        };
        let divide = |&[a, b, c]: &[u32; 3]| {
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        triangles = triangles.iter().flat_map(divide).collect();
    }
    (positions, triangles)
}

/// The cube from -1 to 1, two triangles a side.
pub(crate) fn cube() -> Mesh {
    let corner = |i: u32, bit: u32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
    let positions = (0..8).map(|i| Vec3::new(corner(i, 0), corner(i, 1), corner(i, 2))).collect();
    let sides =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    (positions, triangles)
}

pub(crate) fn moved((positions, triangles): Mesh, map: impl FnMut(Vec3) -> Vec3) -> Mesh {
    (positions.into_iter().map(map).collect(), triangles)
}

/// Closed meshes that contain all points near their middle, each with its name, its
/// middle, and half the size of a box in it.
pub(crate) fn closed_meshes() -> Vec<(&'static str, Mesh, Vec3, Vec3)> {
    let mut random = Random(7);
    let far = Vec3::new(4097.3, -8201.7, 16411.1);
    let thin = Vec3::new(1000.0, 0.001, 1.0);
    let third = Vec3::splat(0.3);
    vec![
        ("sphere", icosphere(4), Vec3::ZERO, third),
        ("cube", cube(), Vec3::ZERO, third),
        (
            "blob",
            moved(icosphere(4), |p| p * random.between(0.6, 1.6)),
            Vec3::ZERO,
            Vec3::splat(0.2),
        ),
        ("far sphere", moved(icosphere(4), |p| p + far), far, third),
        ("long thin sphere", moved(icosphere(4), |p| p * thin), Vec3::ZERO, thin * 0.3),
    ]
}

pub(crate) fn surfaces((positions, triangles): Mesh) -> Surfaces {
    Surfaces::new(positions, triangles, vec![], vec![], &BuildOptions::default())
}

/// Triangles that share no vertices.
pub(crate) fn soup(triangles: impl IntoIterator<Item = [Vec3; 3]>) -> Mesh {
    let positions: Vec<Vec3> = triangles.into_iter().flatten().collect();
    let triangles = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
    let triangles = triangles.collect();
    (positions, triangles)
}

/// Triangles, spheres and disks under a tree that is too large for the nearer caches.
pub(crate) fn large_scene() -> (&'static str, Surfaces) {
    let mut random = Random(2);
    let r = &mut random;
    let triangles = (0..150_000).map(|_| {
        let p = r.point();
        [p, p + r.point() * 0.02, p + r.point() * 0.02]
    });
    let (positions, triangles) = soup(triangles);
    let spheres = (0..1000).map(|_| Sphere { center: r.point(), radius: 0.005 }).collect();
    let disks = (0..1000)
        .map(|_| Disk { center: r.point(), u: r.point() * 0.01, v: r.point() * 0.01 })
        .collect();
    let large = Surfaces::new(positions, triangles, spheres, disks, &BuildOptions::default());
    assert!(large.report().nodes > 4096);
    ("large", large)
}

/// Eight scenes of a few hundred primitives, each hard in its own way.
pub(crate) fn hard_scenes() -> Vec<(&'static str, Surfaces)> {
    let mut random = Random(1);
    let r = &mut random;
    let some = (0..400).map(|_| {
        let p = r.point();
        [p, p + r.point() * 0.3, p + r.point() * 0.3]
    });
    let some = surfaces(soup(some));

    let round = surfaces(icosphere(2));

    // One side long, the others as short as the numbers allow.
    let needles = (0..400).map(|_| {
        let p = r.point();
        let along = p + r.point();
        let width = r.size(-7, -1);
        [p, along, p + (along - p) * r.unit() + r.point() * width]
    });
    let needles = surfaces(soup(needles));

    let far = Vec3::new(1003.0, -2011.0, 497.0);
    let triangles: Vec<_> = (0..200)
        .map(|_| {
            let p = far + r.point() * 100.0;
            let size = r.size(-3, 2);
            [p, p + r.point() * size, p + r.point() * size]
        })
        .collect();
    let spheres = (0..100)
        .map(|_| Sphere { center: far + r.point() * 100.0, radius: r.size(-3, 1) })
        .collect();
    let disks = (0..100)
        .map(|_| {
            let size = r.size(-3, 2);
            Disk { center: far + r.point() * 100.0, u: r.point() * size, v: r.point() * size }
        })
        .collect();
    let (positions, triangles) = soup(triangles);
    let mixed = Surfaces::new(positions, triangles, spheres, disks, &BuildOptions::default());

    // Each triangle four times, turned and flipped, some with a neighbour in the same plane:
    // whatever is hit first is hit several times at the same place.
    let copies = (0..80).flat_map(|_| {
        let [a, b, c] = [(); 3].map(|()| r.point());
        [[a, b, c], [b, c, a], [a, c, b], [a, b, c], [a, (a + b) * 0.5, c]]
    });
    let copies = surfaces(soup(copies));

    // From a hair's breadth to a mountain range around the same point, in everything there is.
    let size = |r: &mut Random| r.size(-6, 3);
    let triangles: Vec<_> = (0..200)
        .map(|_| {
            let (size, p) = (size(r), r.point());
            [p, p + r.point(), p + r.point()].map(|p| p * size)
        })
        .collect();
    let spheres = (0..100)
        .map(|_| {
            let size = size(r);
            Sphere { center: r.point() * size, radius: size * r.size(-3, 0) }
        })
        .collect();
    let disks = (0..100)
        .map(|_| {
            let size = size(r);
            Disk { center: r.point() * size, u: r.point() * size, v: r.point() * size }
        })
        .collect();
    let (positions, triangles) = soup(triangles);
    let scales = Surfaces::new(positions, triangles, spheres, disks, &BuildOptions::default());

    // Open: a hilly field on an even grid, so that many rays aim along columns of shared edges.
    let side = 15_u32;
    let positions = (0..side * side)
        .map(|i| Vec3::new((i % side) as f32, (r.unit() * 4.0).floor(), (i / side) as f32))
        .collect();
    let squares = (0..side * (side - 1)).filter(|i| i % side != side - 1);
    let field = squares.flat_map(|i| [[i, i + side, i + 1], [i + 1, i + side, i + side + 1]]);
    let field = surfaces((positions, field.collect()));

    // Closed: shells one inside the other, a hair apart, with balls and disks between and in them.
    let mut shells = (vec![], vec![]);
    for radius in [1.0_f32, 1.000_001, 1.001, 1.1] {
        let (positions, triangles) = moved(icosphere(1), |p| p * radius);
        let first = shells.0.len() as u32;
        shells.0.extend(positions);
        shells.1.extend(triangles.iter().map(|t| t.map(|v| v + first)));
    }
    let ball = |radius| Sphere { center: Vec3::ZERO, radius };
    let spheres = vec![ball(0.5), ball(0.5 + 1e-6), ball(1.05), ball(1.2)];
    let lid = |z| Disk { center: Vec3::Z * z, u: Vec3::X * 0.6, v: Vec3::Y * 0.6 };
    let disks = vec![lid(0.5), lid(-0.5), lid(0.0), lid(0.0)];
    let (positions, triangles) = shells;
    let shells = Surfaces::new(positions, triangles, spheres, disks, &BuildOptions::default());

    vec![
        ("soup", some),
        ("round", round),
        ("needles", needles),
        ("mixed and far", mixed),
        ("duplicates", copies),
        ("mixed scales", scales),
        ("hilly field", field),
        ("shells", shells),
    ]
}

/// From within the box `middle ± half`, exactly at a vertex, at the middle of an
/// edge, or at any place on one.
pub(crate) fn ray_at_an_edge(
    scene: &Surfaces,
    middle: Vec3,
    half: Vec3,
    random: &mut Random,
) -> Ray {
    let [a, b, c] = scene.triangle(random.below(scene.triangles().len()) as u32);
    let target = match random.below(4) {
        0 => a,
        1 => (b + c) * 0.5,
        2 => a + (b - a) * random.unit(),
        _ => c + (a - c) * random.unit(),
    };
    let origin = middle + half * random.point();
    Ray::new(origin, target - origin)
}
