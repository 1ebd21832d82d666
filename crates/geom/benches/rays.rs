//! How long rays and trees take: `cargo bench -p rutilant-geom`.
//!
//! The surface is a sphere with waves on it, large enough for its tree not to fit the inner caches.

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use rutilant_geom::lanes::LANES;
use rutilant_geom::{Quality, Ray, RayPacket, Surfaces, Vec3, real};
use std::f32::consts::PI;
use std::hint::black_box;

/// Corners around the sphere, and from pole to pole half as many.
const AROUND: u32 = 512;

const RAYS: u32 = 4096;

fn wavy_sphere() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let (columns, rows) = (AROUND, AROUND / 2);
    let corner = |column: u32, row: u32| {
        let (sin_phi, cos_phi) = real::sin_cos(2.0 * PI * column as f32 / columns as f32);
        let (sin_theta, cos_theta) = real::sin_cos(PI * row as f32 / rows as f32);
        let waves = real::sin(20.0 * sin_phi * sin_theta) * real::sin(17.0 * cos_theta);
        Vec3::new(sin_theta * cos_phi, cos_theta, sin_theta * sin_phi) * (1.0 + 0.05 * waves)
    };
    let corners = (0..=rows).flat_map(|row| (0..columns).map(move |column| corner(column, row)));
    let number = |column: u32, row: u32| row * columns + column % columns;
    let triangles = (0..rows).flat_map(|row| {
        (0..columns).flat_map(move |column| {
            let [a, b] = [number(column, row), number(column + 1, row)];
            let [c, d] = [number(column, row + 1), number(column + 1, row + 1)];
            [[a, c, b], [b, c, d]]
        })
    });
    (corners.collect(), triangles.collect())
}

fn surfaces(quality: Quality) -> Surfaces {
    let (positions, triangles) = wavy_sphere();
    Surfaces::new(positions, triangles, Vec::new(), Vec::new(), &quality.into())
}

/// Numbers in [0, 1) without any order.
fn scattered(i: u32) -> [f32; 2] {
    [0x9e37_79b9_u32, 0x85eb_ca6b].map(|factor| {
        let mixed = (i + 1).wrapping_mul(factor);
        ((mixed ^ mixed >> 15).wrapping_mul(0x2c1b_3c6d) >> 8) as f32 / (1 << 24) as f32
    })
}

/// Rays of a camera, neighbours side by side, and rays from everywhere to everywhere.
fn sets() -> [(&'static str, Vec<Ray>); 2] {
    let side = RAYS.isqrt();
    let camera = (0..RAYS).map(|i| {
        let [x, y] = [i % side, i / side].map(|k| 0.6 * (k as f32 / side as f32 - 0.5));
        Ray::new(Vec3::new(0.0, 0.0, 3.0), Vec3::new(x, y, -1.0).normalize())
    });
    let point = |i: u32| {
        let ([u, v], [w, _]) = (scattered(2 * i), scattered(2 * i + 1));
        Vec3::new(u, v, w) * 3.0 - 1.5
    };
    let all_over = (0..RAYS).map(|i| {
        let (from, to) = (point(2 * i), point(2 * i + 1));
        Ray::new(from, (to - from).normalize())
    });
    [("camera", camera.collect()), ("scattered", all_over.collect())]
}

fn rays(c: &mut Criterion) {
    let surfaces = surfaces(Quality::Default);
    let mut group = c.benchmark_group("rays");
    group.throughput(Throughput::Elements(RAYS.into()));
    for (name, rays) in sets() {
        let packets: Vec<RayPacket> = rays.chunks(LANES).map(RayPacket::new).collect();
        group.bench_function(format!("{name}, closest, by eight"), |b| {
            b.iter(|| packets.iter().map(|p| surfaces.closest_packet(p).t[0]).sum::<f32>());
        });
        group.bench_function(format!("{name}, closest, alone"), |b| {
            b.iter(|| rays.iter().filter_map(|r| surfaces.closest(r)).map(|h| h.t).sum::<f32>());
        });
        group.bench_function(format!("{name}, any, by eight"), |b| {
            b.iter(|| packets.iter().fold(0, |all, p| all ^ surfaces.occluded_packet(p)));
        });
        group.bench_function(format!("{name}, any, alone"), |b| {
            b.iter(|| rays.iter().filter(|r| surfaces.occluded(r)).count());
        });
    }
    group.finish();
}

fn builds(c: &mut Criterion) {
    let mut group = c.benchmark_group("build");
    group.throughput(Throughput::Elements((AROUND * AROUND).into())).sample_size(10);
    for (name, quality) in
        [("fast", Quality::Fast), ("default", Quality::Default), ("high", Quality::High)]
    {
        group.bench_function(name, |b| {
            b.iter_batched(
                wavy_sphere,
                |(positions, triangles)| {
                    Surfaces::new(positions, triangles, Vec::new(), Vec::new(), &quality.into())
                },
                BatchSize::LargeInput,
            );
        });
    }
    group.finish();
}

fn functions(c: &mut Criterion) {
    let mut group = c.benchmark_group("real");
    for (name, function) in [
        ("sin", real::sin as fn(f32) -> f32),
        ("acos", real::acos),
        ("exp", real::exp),
        ("ln", real::ln),
    ] {
        group.bench_function(name, |b| b.iter(|| function(black_box(0.7))));
    }
    group.bench_function("atan2", |b| b.iter(|| real::atan2(black_box(0.7), black_box(-0.3))));
    group.bench_function("pow", |b| b.iter(|| real::pow(black_box(0.7), black_box(2.2))));
    group.finish();
}

criterion_group!(benches, rays, builds, functions);
criterion_main!(benches);
