//! A picture is a function of scene and settings, bit by bit: not of threads, crops or pauses.

mod common;

use rutilant::camera::Perspective;
use rutilant::color::Rgb;
use rutilant::geom::{Transform, Vec2, Vec3};
use rutilant::image::Image;
use rutilant::light::Environment;
use rutilant::material::{Dielectric, Emission, Matte};
use rutilant::scene::Scene;
use rutilant::settings::{Crop, Heuristic, SamplerKind, Settings};
use rutilant::shape::{Object, Shape};
use rutilant::{Prepared, Session};
use std::sync::Arc;
use std::time::Duration;

/// Some of everything: glass, a lamp, a sky, a floor, a lens.
fn scene() -> Arc<Prepared> {
    let mut camera = Perspective::look_at(Vec3::new(0.0, 1.0, 4.0), Vec3::ZERO, 0.8).unwrap();
    camera.lens.aperture_radius = 0.05;
    let mut scene = Scene::new(camera);
    scene.environment = Some(Environment::constant(Rgb::new(0.2, 0.3, 0.5)));
    let floor = scene.add_material(Matte::new(Rgb::new(0.7, 0.6, 0.5)));
    let glass = scene.add_material(Dielectric::new(1.5));
    let lamp = scene.add_material(Emission::radiance(Rgb::grey(9.0)));
    let at = |x, y, z| Transform::translate(Vec3::new(x, y, z));
    let flat = at(0.0, -0.8, 0.0) * Transform::rotate(Vec3::X, -std::f32::consts::FRAC_PI_2);
    scene
        .objects
        .push(Object::new(Shape::Rectangle { size: Vec2::splat(20.0) }, floor).transformed(&flat));
    scene
        .objects
        .push(Object::new(Shape::Sphere { radius: 0.8 }, glass).transformed(&at(-1.0, 0.0, 0.0)));
    scene
        .objects
        .push(Object::new(Shape::Box { size: Vec3::ONE }, floor).transformed(&at(1.0, 0.0, 0.0)));
    scene
        .objects
        .push(Object::new(Shape::Sphere { radius: 0.3 }, lamp).transformed(&at(0.0, 2.0, 0.0)));
    Arc::new(Prepared::new(&scene).unwrap())
}

fn settings(spp: u64) -> Settings {
    Settings { size: [101, 97], spp, ..Settings::default() }
}

/// Pixels that only add, and pixels that learn from each sample for the next.
const HEURISTICS: [Heuristic; 2] = [Heuristic::Power, Heuristic::Optimal];

fn finish(session: &Session) -> Image {
    while !session.wait(Duration::from_secs(3600)) {}
    session.snapshot()
}

fn render(scene: &Arc<Prepared>, settings: Settings, threads: usize) -> Image {
    finish(&Session::start(Arc::clone(scene), settings, threads).unwrap())
}

/// The old program cut its buffer by the number of threads: 7 left rows undrawn, 16 shifted bands.
#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let scene = scene();
    for (sampler, heuristic) in [
        (SamplerKind::Sobol, Heuristic::Power),
        (SamplerKind::Independent, Heuristic::Power),
        (SamplerKind::Sobol, Heuristic::Optimal),
    ] {
        let settings = Settings { sampler, heuristic, ..settings(4) };
        let one = render(&scene, settings.clone(), 1).hash();
        for threads in [2, 3, 5, 7, 16, 61] {
            assert_eq!(render(&scene, settings.clone(), threads).hash(), one, "{threads} threads");
        }
    }
}

/// Four continued passes of 16 samples are 64 samples in one go.
#[test]
fn continued_renderings_are_those_in_one_go() {
    let scene = scene();
    for heuristic in HEURISTICS {
        let settings = |spp| Settings { heuristic, ..settings(spp) };
        let whole = render(&scene, settings(64), 2);
        let mut session = Session::start(Arc::clone(&scene), settings(16), 3).unwrap();
        for spp in [32, 48, 64] {
            finish(&session);
            session.extend(spp);
        }
        assert_eq!(finish(&session).hash(), whole.hash());
    }
}

/// Stopped at any moment, in the middle of a pass, and continued: no sample is lost or taken twice.
#[test]
fn cancelled_renderings_continue_to_the_same_bits() {
    let scene = scene();
    for heuristic in HEURISTICS {
        let settings = Settings { heuristic, ..settings(32) };
        let whole = render(&scene, settings.clone(), 2);
        let mut session = Session::start(Arc::clone(&scene), settings, 2).unwrap();
        for pause in 0..12 {
            session.wait(Duration::from_millis(pause * 5));
            session.cancel();
            finish(&session);
            session.extend(32);
        }
        let image = finish(&session);
        assert_eq!(session.progress().samples, 32);
        assert_eq!(image.hash(), whole.hash());
    }
}

/// Windows of the picture, put together, are the picture.
#[test]
fn crops_compose() {
    for heuristic in HEURISTICS {
        assert_crops_compose(&Settings { heuristic, ..settings(4) });
    }
}

fn assert_crops_compose(settings: &Settings) {
    let scene = scene();
    let whole = render(&scene, settings.clone(), 2);
    let (columns, rows) = ([0, 16, 17, 70, 101], [0, 31, 97]);
    for (x, x_end) in columns.into_iter().zip(columns.into_iter().skip(1)) {
        for (y, y_end) in rows.into_iter().zip(rows.into_iter().skip(1)) {
            let crop = Crop { x, y, width: x_end - x, height: y_end - y };
            let part = render(&scene, Settings { crop: Some(crop), ..settings.clone() }, 2);
            for (channel, whole) in part.channels().iter().zip(whole.channels()) {
                for (i, value) in channel.values.iter().enumerate() {
                    let (px, py) = (x + i as u32 % crop.width, y + i as u32 / crop.width);
                    let expected = whole.values[(py * 101 + px) as usize];
                    assert_eq!(
                        value.to_bits(),
                        expected.to_bits(),
                        "{} at {px},{py}",
                        channel.name
                    );
                }
            }
        }
    }
}

/// A finished session can be looked at, asked to end and continued in any order without harm.
#[test]
fn sessions_end_cleanly() {
    let scene = scene();
    let mut session = Session::start(Arc::clone(&scene), settings(1_000_000), 2).unwrap();
    session.finish_pass();
    let image = finish(&session);
    let progress = session.progress();
    assert!(progress.finished && progress.samples < 1_000_000);
    assert_eq!(image.hash(), session.snapshot().hash());
    session.cancel();
    session.extend(1);
    session.finish_pass();
    finish(&session);

    // Without waiting in between: an edit in a window is just this.
    let target = session.progress().samples + 3;
    for _ in 0..20 {
        session.extend(1_000_000);
        session.cancel();
        session.extend(target);
        session.finish_pass();
        session.extend(target);
    }
    session.cancel();
    session.extend(target);
    session.cancel();
    finish(&session);
    drop(Session::start(scene, settings(1_000_000), 2).unwrap());
}
