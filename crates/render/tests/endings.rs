//! How paths end: roulette changes no mean, and a depth limit loses what theory says.

#![expect(clippy::disallowed_methods, reason = "expected values are computed in f64")]

mod common;

use common::{mean, render, small};
use rutilant::camera::Perspective;
use rutilant::color::Rgb;
use rutilant::geom::Vec3;
use rutilant::light::Environment;
use rutilant::material::{Dielectric, Emission, Material, Matte};
use rutilant::scene::Scene;
use rutilant::settings::{IntegratorKind, Roulette, Settings, Strategy};
use rutilant::shape::{Object, Shape};
use rutilant::{Prepared, Session};
use std::sync::Arc;
use std::time::Duration;

/// A closed glowing room of this albedo, seen from inside.
fn room(albedo: f32) -> Scene {
    let eye = Vec3::new(0.1, 0.2, 0.3);
    let mut scene = Scene::new(Perspective::look_at(eye, Vec3::X, 1.0).unwrap());
    let glow = Emission { two_sided: true, ..Emission::radiance(Rgb::WHITE) };
    let wall = Material::from(Matte::new(Rgb::grey(albedo))).emitting(glow);
    let wall = scene.add_material(wall);
    scene.objects.push(Object::new(Shape::Box { size: Vec3::new(4.0, 3.0, 2.0) }, wall));
    scene
}

/// A ball of glass in a white furnace, met where this is the sine of the angle of incidence.
fn ball_met_at(sine: f32) -> Scene {
    let eye = Vec3::new(sine, 0.0, 10.0);
    let mut scene = Scene::new(Perspective::look_at(eye, eye - Vec3::Z, 1e-4).unwrap());
    scene.environment = Some(Environment::constant(Rgb::WHITE));
    let glass = scene.add_material(Dielectric::new(1.5));
    scene.objects.push(Object::new(Shape::Sphere { radius: 1.0 }, glass));
    scene
}

/// With and without roulette, of either kind, the mean of a furnace is the same: a z-test of
/// 3 σ each on top of the closed form 1 / (1 − a). The old program's survival could exceed 1.
#[test]
fn roulette_changes_no_mean() {
    for albedo in [0.3, 0.8] {
        // What is left beyond 200 segments is less than 0.8²⁰⁰ = 4e-20.
        let off = Settings { roulette: Roulette::Off, max_depth: Some(200), ..small(192) };
        let without = mean(&render(&room(albedo), off), "G");
        for roulette in [Roulette::Throughput, Roulette::Albedo] {
            let with = mean(&render(&room(albedo), Settings { roulette, ..small(192) }), "G");
            let z = (with.0 - without.0) / with.1.hypot(without.1);
            assert!(z.abs() < 3.0, "{roulette:?} at {albedo}: z = {z}, {with:?}, {without:?}");
            let exact = 1.0 / (1.0 - f64::from(albedo));
            assert!((with.0 - exact).abs() < 4.0 * with.1, "{roulette:?}: {with:?}, {exact}");
        }
    }
}

/// Roulette by albedo lets a path in a closed room live for 1 / (1 − a) segments on average, as
/// the progress tells; survival below the report's 0.1 is not taken.
#[test]
fn paths_are_as_long_as_their_survival_says() {
    for (albedo, survival) in [(0.8_f32, 0.8_f64), (0.5, 0.5), (0.02, 0.1)] {
        let scene = Arc::new(Prepared::new(&room(albedo)).unwrap());
        // Light samples would count as rays, too.
        let strategy = Strategy::BsdfOnly;
        let settings = Settings { roulette: Roulette::Albedo, strategy, ..small(256) };
        let session = Session::start(scene, settings, 2).unwrap();
        while !session.wait(Duration::from_secs(3600)) {}
        let progress = session.progress();
        let length = progress.rays as f64 / progress.paths as f64;
        let expected = 1.0 / (1.0 - survival);
        // The length is geometrically distributed.
        let sigma = survival.sqrt() / (1.0 - survival) / (progress.paths as f64).sqrt();
        assert!((length - expected).abs() < 4.0 * sigma, "{albedo}: {length}, not {expected}");
    }
}

/// A glass ball in a furnace has the same angle at every bounce, so the part (1 − R) R^(d−2) of
/// the light needs more than d segments: that much is lost to a depth limit, no less, no more.
#[test]
fn a_depth_limit_loses_what_theory_says() {
    let sine = 0.9962_f64; // about 85°
    let cos = |s: f64| (1.0 - s * s).sqrt();
    let (i, t) = (cos(sine), cos(sine / 1.5));
    let s = (i - 1.5 * t) / (i + 1.5 * t);
    let p = (1.5 * i - t) / (1.5 * i + t);
    let r = 0.5 * (s * s + p * p);
    for depth in [1_u32, 2, 3, 4, 6, 10, 20] {
        let lost = if depth == 1 { 1.0 } else { (1.0 - r) * r.powi(depth as i32 - 2) };
        for integrator in [IntegratorKind::Path, IntegratorKind::Naive] {
            let settings = Settings { integrator, max_depth: Some(depth), ..small(1024) };
            let (seen, error) = mean(&render(&ball_met_at(sine as f32), settings), "G");
            println!("{integrator:?}, depth {depth}: {:.4} lost, {lost:.4} expected", 1.0 - seen);
            assert!(
                (1.0 - seen - lost).abs() < 4.0 * error + 2e-4,
                "{integrator:?} at depth {depth}: {} ± {error} lost, expected {lost}",
                1.0 - seen
            );
        }
    }
}
