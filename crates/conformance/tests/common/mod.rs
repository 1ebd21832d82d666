//! Rendering small pictures and holding them against each other.

#![allow(dead_code, reason = "each test file uses a part of this")]

use rutilant::image::Image;
use rutilant::scene::Scene;
use rutilant::settings::{IntegratorKind, SamplerKind, Settings};
use rutilant::{Prepared, Session};
use rutilant_conformance::agreement::{critical_z, largest_disagreement};
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

/// The worst pixel, if chance alone would not make one as bad in a hundred such families of
/// `pairs` pairs of pictures.
pub fn disagreement(a: &Image, b: &Image, pairs: usize) -> Option<String> {
    let critical = critical_z(pairs * (SIZE * SIZE * 3) as usize, 0.01);
    let worst = largest_disagreement(a, b).expect("colour and variance");
    println!("z = {:.2} of {critical:.2}", worst.z);
    (worst.z > critical).then(|| format!("{worst:?}, beyond z = {critical:.2}"))
}
