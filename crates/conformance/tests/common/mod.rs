//! Rendering small pictures and holding them against each other.

#![allow(dead_code, reason = "each test file uses a part of this")]

use rutilant::image::Image;
use rutilant::scene::Scene;
use rutilant::settings::{IntegratorKind, SamplerKind, Settings};
use rutilant::{Prepared, Session};
use rutilant_conformance::agreement::{Variance, any_of, compare};
use std::sync::Arc;
use std::time::Duration;

const SIZE: u32 = 14;

/// What a small picture for the z-test is rendered with.
pub fn settings(integrator: IntegratorKind, max_depth: Option<u32>, seed: u64) -> Settings {
    Settings {
        size: [SIZE; 2],
        spp: 2048,
        sampler: SamplerKind::Independent,
        integrator,
        max_depth,
        seed,
        ..Settings::default()
    }
}

pub fn render(
    scene: &Scene,
    integrator: IntegratorKind,
    max_depth: Option<u32>,
    seed: u64,
) -> Image {
    render_with(scene, settings(integrator, max_depth, seed))
}

pub fn render_with(scene: &Scene, settings: Settings) -> Image {
    let scene = Arc::new(Prepared::new(scene).expect("a sound scene"));
    let session = Session::start(scene, settings, 2).expect("sound settings");
    while !session.wait(Duration::from_secs(3600)) {}
    assert_eq!(session.progress().dropped.count, 0, "samples were no numbers");
    session.snapshot()
}

/// How two pictures differ, if chance alone would not make them differ as much in one of a hundred
/// families of `pairs` pairs of pictures.
pub fn disagreement(a: &Image, b: &Image, pairs: usize) -> Option<String> {
    let comparison = compare(a, b, Variance::Measured).expect("colour and variance");
    println!("p = {:.4}", comparison.p);
    (any_of(comparison.p, pairs) < 0.01).then(|| format!("{comparison:?}"))
}
