//! Every way of finding light gives the same picture.

use rutilant::Prepared;
use rutilant::settings::{IntegratorKind, Settings};
use rutilant_conformance::agreement::{Variance, any_of, compare};
use rutilant_conformance::{matrix, scenes};
use std::sync::Arc;

/// Light samples alone, scattered rays alone, both by multiple importance sampling, a separately
/// written integrator, each roulette, each choice of lights and each sampler agree in every
/// pixel, on the whole and in their scatter. A strategy that loses or doubles what another finds,
/// a wrong density or a missing selection probability shows here: the 2017 program kept 2.8 % of
/// its direct light. `cargo run --release -p rutilant-conformance` takes many more samples.
#[test]
fn all_ways_agree_in_every_pixel() {
    let pairs = matrix::agreement(&scenes::all(), &matrix::ways(1024), 2, |_| ()).unwrap();
    let failures: Vec<_> = pairs.iter().filter(|pair| !pair.agrees()).collect();
    assert!(failures.is_empty(), "{failures:#?}");
}

/// Emission and direct light are what paths of two segments bring, by an integrator of its own.
#[test]
fn direct_light_is_paths_of_two_segments() {
    let scenes = scenes::all();
    let [both, ..] = &matrix::ways(2048)[..] else { panic!("there are ways") };
    for scenes::Named { name, scene } in &scenes {
        let scene = Arc::new(Prepared::new(scene).unwrap());
        let with = |settings| matrix::render(&scene, settings, 2).unwrap();
        let direct = with(Settings { integrator: IntegratorKind::Direct, ..both.settings.clone() });
        let paths = with(Settings { max_depth: Some(2), seed: 99, ..both.settings.clone() });
        let comparison = compare(&direct, &paths, Variance::Measured).unwrap();
        assert!(any_of(comparison.p, scenes.len()) >= 0.01, "{name}: {comparison:?}");
    }
}
