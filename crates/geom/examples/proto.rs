//! Scratch.
use rutilant_geom::*;
use std::time::Instant;
fn read<const N: usize>(p: &str) -> Vec<[f32; N]> {
    let b = std::fs::read(p).unwrap();
    let f: Vec<f32> = b.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
    f.as_chunks::<N>().0.to_vec()
}
fn main() {
    let d = format!("/tmp/peers/rays/{}", std::env::args().nth(1).unwrap());
    let tris = read::<9>(&format!("{d}.tris"));
    let positions: Vec<Vec3> = tris.iter().flat_map(|c| [0, 3, 6].map(|i| Vec3::new(c[i], c[i + 1], c[i + 2]))).collect();
    let idx = (0..positions.len() as u32).step_by(3).map(|i| [i, i + 1, i + 2]).collect();
    let s = Surfaces::new(positions, idx, vec![], vec![], &BuildOptions::default());
    for set in ["primary", "bounce", "shadow", "glass"] { if !std::path::Path::new(&format!("{d}.{set}")).exists() || std::env::var("SET").is_ok_and(|s| s != set) { continue; }
        let rays: Vec<Ray> = read::<8>(&format!("{d}.{set}")).into_iter().map(|r| Ray { origin: Vec3::new(r[0], r[1], r[2]), direction: Vec3::new(r[4], r[5], r[6]), t_min: r[3], t_max: r[7] }).collect();
        let (mut best1, mut best8) = (f64::MAX, f64::MAX);
        let (mut h1, mut h8, mut s1, mut s8) = (0, 0, 0.0, 0.0);
        for _ in 0..std::env::var("REPS").map_or(3, |r| r.parse().unwrap()) {
            let t = Instant::now();
            h1 = 0; s1 = 0.0;
            for r in &rays { if let Some(h) = s.closest(r) { h1 += 1; s1 += h.t as f64; } }
            best1 = best1.min(t.elapsed().as_secs_f64());
            let t = Instant::now();
            h8 = 0; s8 = 0.0;
            for r in rays.chunks(8) { let p = s.closest_packet(&RayPacket::new(r)); for i in 0..8 { if p.primitive[i] != HitPacket::NOTHING { h8 += 1; s8 += p.t[i] as f64; } } }
            best8 = best8.min(t.elapsed().as_secs_f64());
        }
        let (mut a1, mut a8, mut o1, mut o8) = (f64::MAX, f64::MAX, 0, 0);
        for _ in 0..std::env::var("REPS").map_or(3, |r| r.parse().unwrap()) {
            let t = Instant::now();
            o1 = rays.iter().filter(|r| s.occluded(r)).count();
            a1 = a1.min(t.elapsed().as_secs_f64());
            let t = Instant::now();
            o8 = rays.chunks(8).map(|r| s.occluded_packet(&RayPacket::new(r)).count_ones()).sum();
            a8 = a8.min(t.elapsed().as_secs_f64());
        }
        println!("         any: single {:.2} packet {:.2}   {o1} {o8}", rays.len() as f64 / a1 * 1e-6, rays.len() as f64 / a8 * 1e-6);
        if std::env::var("SET").is_ok_and(|s| s != set) { }
        println!("{set:8} single {:.2} packet {:.2} Mrays/s   {h1} {h8} {s1} {s8}", rays.len() as f64 / best1 * 1e-6, rays.len() as f64 / best8 * 1e-6);
        if std::env::args().nth(2).is_some() {
            for r in rays.chunks(8) { let q = RayPacket::new(r); let (p, o) = (s.closest_packet(&q), s.occluded_packet(&q)); for (i, r) in r.iter().enumerate() { assert_eq!(s.closest(r), p.hit(i)); assert_eq!(s.occluded(r), p.hit(i).is_some()); assert_eq!(s.occluded(r), o >> i & 1 == 1);  } }
        }
    }
}
