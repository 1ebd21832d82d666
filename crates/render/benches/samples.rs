//! How long the steps of a sample take, and small pictures: `cargo bench -p rutilant`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use rutilant::bsdf::{
    Bsdf, Fresnel, Lambert, Lobe, OrenNayar, RoughConductor, RoughDielectric, SmoothDielectric,
};
use rutilant::camera::Perspective;
use rutilant::color::{Rgb, Spectrum};
use rutilant::geom::{Transform, Vec2, Vec3};
use rutilant::material::{Conductor, Dielectric, Emission, Material, Matte};
use rutilant::sampler::{Independent, Sampler, Sequence, Sobol};
use rutilant::scene::Scene;
use rutilant::settings::{SamplerKind, Settings};
use rutilant::shape::{Object, Shape};
use rutilant::{Prepared, Session};
use std::f32::consts::FRAC_PI_2;
use std::hint::black_box;
use std::sync::Arc;
use std::time::Duration;

fn samplers(c: &mut Criterion) {
    let mut group = c.benchmark_group("a pair of random numbers");
    let sequence = Sequence::new(1, 64);
    let (sobol, independent) =
        (Sobol::new(&sequence, [3, 5], 7), Independent::new(&sequence, [3, 5], 7));
    group.bench_function("sobol", |b| b.iter(|| sobol.d2(black_box(9))));
    group.bench_function("independent", |b| b.iter(|| independent.d2(black_box(9))));
    group.finish();
}

fn scattering(c: &mut Criterion) {
    let mut group = c.benchmark_group("scattering");
    let white = Spectrum::from([0.8; 3]);
    let lobes = [
        ("matte", Some(Lobe::Lambert(Lambert { albedo: white }))),
        ("rough matte", Some(Lobe::OrenNayar(OrenNayar::new(white, 0.5)))),
        ("rough metal", RoughConductor::new(white, white, 0.4).map(Lobe::RoughConductor)),
        ("rough glass", RoughDielectric::new(1.5, 0.4).map(Lobe::RoughDielectric)),
        ("glass", Some(Lobe::Dielectric(SmoothDielectric { eta: 1.5, fresnel: Fresnel::Exact }))),
    ];
    let (wo, wi) = (Vec3::new(0.3, 0.4, 0.866).normalize(), Vec3::new(-0.5, 0.1, 0.86).normalize());
    for (name, lobe) in lobes.into_iter().filter_map(|(name, lobe)| Some((name, lobe?))) {
        let bsdf = Bsdf::from(lobe);
        group.bench_function(format!("{name}, sample"), |b| {
            b.iter(|| bsdf.sample(black_box(wo), 0.4, Vec2::new(0.3, 0.6)));
        });
        group.bench_function(format!("{name}, evaluate"), |b| {
            b.iter(|| bsdf.eval_cos_pdf(black_box(wo), wi));
        });
    }
    group.finish();
}

/// A room with a lamp of each kind that glows, seen from near and from afar.
fn lights(c: &mut Criterion) {
    let mut group = c.benchmark_group("a way to a light");
    for (name, shape) in [
        ("rectangle", Shape::Rectangle { size: Vec2::new(1.0, 0.7) }),
        ("disk", Shape::Disk { radius: 0.5 }),
        ("sphere", Shape::Sphere { radius: 0.5 }),
    ] {
        let mut scene = room();
        let lamp = scene.add_material(Emission::radiance(Rgb::WHITE));
        scene.objects = vec![Object::new(shape, lamp)];
        let scene = Prepared::new(&scene).expect("a lamp in a room");
        for (place, from) in [("near", Vec3::new(0.3, 0.2, 0.6)), ("far", Vec3::new(1.0, 2.0, 5.0))]
        {
            group.bench_function(format!("{name}, {place}"), |b| {
                b.iter(|| scene.emitters()[0].sample(black_box(from), Vec2::new(0.3, 0.6)));
            });
        }
    }
    group.finish();
}

/// A matte room with a lamp under its ceiling.
fn room() -> Scene {
    let eye = Perspective::look_at(Vec3::new(0.0, 1.0, 3.9), Vec3::Y, 0.7)
        .expect("it looks at another place");
    let mut scene = Scene::new(eye);
    let white = scene.add_material(Matte::new(Rgb::grey(0.7)));
    let lamp = scene.add_material(Emission::radiance(Rgb::grey(15.0)));
    let at = |x, y, z| Transform::translate(Vec3::new(x, y, z));
    let turn = |axis, angle| Transform::rotate(axis, angle);
    let wall = || Shape::Rectangle { size: Vec2::splat(2.0) };
    for place in [
        at(0.0, 0.0, 0.0) * turn(Vec3::X, -FRAC_PI_2),
        at(0.0, 2.0, 0.0) * turn(Vec3::X, FRAC_PI_2),
        at(0.0, 1.0, -1.0),
        at(-1.0, 1.0, 0.0) * turn(Vec3::Y, FRAC_PI_2),
        at(1.0, 1.0, 0.0) * turn(Vec3::Y, -FRAC_PI_2),
    ] {
        scene.objects.push(Object::new(wall(), white).transformed(&place));
    }
    let small = Shape::Rectangle { size: Vec2::splat(0.5) };
    let below = at(0.0, 1.99, 0.0) * turn(Vec3::X, FRAC_PI_2);
    scene.objects.push(Object::new(small, lamp).transformed(&below));
    scene
}

/// Whole pictures, on one thread: a room with two balls of one material.
fn pictures(c: &mut Criterion) {
    const SIDE: u32 = 64;
    const SPP: u64 = 8;
    let mut group = c.benchmark_group("pictures");
    group.throughput(Throughput::Elements(u64::from(SIDE * SIDE) * SPP)).sample_size(20);
    let gold = Conductor::new(Rgb::grey(0.2), Rgb::grey(3.0), 0.3);
    let materials: [(&str, Material); 3] = [
        ("matte", Matte::new(Rgb::grey(0.5)).into()),
        ("glass", Dielectric::new(1.5).into()),
        ("rough metal", gold.into()),
    ];
    for (name, material) in materials {
        let mut scene = room();
        let material = scene.add_material(material);
        for (x, radius) in [(-0.4, 0.4), (0.5, 0.3)] {
            let place = Transform::translate(Vec3::new(x, radius, 0.0));
            scene.objects.push(Object::new(Shape::Sphere { radius }, material).transformed(&place));
        }
        let scene = Arc::new(Prepared::new(&scene).expect("balls in a room"));
        group.bench_function(name, |b| {
            b.iter(|| {
                let settings = Settings {
                    size: [SIDE, SIDE],
                    spp: SPP,
                    sampler: SamplerKind::Sobol,
                    ..Settings::default()
                };
                let session = Session::start(Arc::clone(&scene), settings, 1);
                session.map(|session| session.wait(Duration::from_secs(60)))
            });
        });
    }
    group.finish();
}

criterion_group!(benches, samplers, scattering, lights, pictures);
criterion_main!(benches);
