//! The proofs of this crate with as many rays as you like, on all cores.
//!
//! ```text
//! cargo run --release -p rutilant-geom --example verify -- [RAYS] [LEAK_RAYS]
//! ```
//!
//! `RAYS` (default 10⁶) go into each of eight hard scenes and are compared with the
//! textbook's formulas, every primitive in turn; each must also be blocked exactly
//! where it hits. `LEAK_RAYS` (default 10⁷; 10⁸ take some minutes) go from inside
//! closed meshes exactly at vertices and edges; each must hit. The first wrong answer
//! ends the run with a panic that names the ray.

#[path = "../tests/common/mod.rs"]
mod common;

use common::{Random, aimed_ray, brute, meshes};
use rayon::prelude::*;
use rutilant_geom::lanes::LANES;
use rutilant_geom::{Ray, RayPacket};

fn main() {
    let mut counts = std::env::args().skip(1).map(|argument| {
        argument.parse::<u64>().unwrap_or_else(|_| panic!("{argument} is not a number of rays"))
    });
    let rays = counts.next().unwrap_or(1_000_000);
    let leak_rays = counts.next().unwrap_or(10_000_000);

    for (name, scene) in meshes::hard_scenes() {
        let [hits, unsure] = (0..rays)
            .into_par_iter()
            .map(|i| {
                let ray = aimed_ray(&scene, &mut Random(i << 20));
                let hit = scene.closest(&ray);
                let sure = brute::check(name, &scene, &ray, hit.as_ref());
                assert_eq!(scene.occluded(&ray), hit.is_some(), "{name}: {ray:?} {hit:?}");
                // The same ray among others that go elsewhere.
                let others: [Ray; LANES] = std::array::from_fn(|lane| match lane {
                    0 => ray,
                    _ => aimed_ray(&scene, &mut Random((i << 20) + lane as u64)),
                });
                let packet = RayPacket::new(&others);
                assert_eq!(scene.closest_packet(&packet).hit(0), hit, "{name}: {ray:?}");
                let blocked = scene.occluded_packet(&packet) & 1 == 1;
                assert_eq!(blocked, hit.is_some(), "{name}: {ray:?}");
                [u64::from(hit.is_some()), u64::from(!sure)]
            })
            .reduce(|| [0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
        println!(
            "{name}: {rays} rays, {hits} hits, none wrong, {unsure} within rounding of an edge"
        );
    }

    let closed = meshes::closed_meshes();
    let each = leak_rays / closed.len() as u64;
    for (name, mesh, middle, half) in closed {
        let scene = meshes::surfaces(mesh);
        let leaks = (0..each)
            .into_par_iter()
            .filter(|&i| {
                let ray = meshes::ray_at_an_edge(&scene, middle, half, &mut Random(i << 20));
                !scene.occluded(&ray)
            })
            .count();
        println!("{name}: {each} rays at vertices and edges, {leaks} leaks");
        assert_eq!(leaks, 0);
    }
}
