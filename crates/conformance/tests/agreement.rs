//! Every way of finding light gives the same picture.

use rutilant::image::Image;
use rutilant::settings::{IntegratorKind, Roulette, SamplerKind, Settings, Strategy};
use rutilant::{Prepared, Session};
use rutilant_conformance::agreement::{critical_z, largest_disagreement};
use rutilant_conformance::scenes;
use std::sync::Arc;
use std::time::Duration;

const SIZE: u32 = 14;

fn render(scene: &Arc<Prepared>, settings: Settings) -> Image {
    let session = Session::start(Arc::clone(scene), settings, 2).expect("sound settings");
    while !session.wait(Duration::from_secs(3600)) {}
    assert_eq!(session.progress().dropped.count, 0, "samples were no numbers");
    session.snapshot()
}

/// Light samples alone, scattered rays alone, both by multiple importance sampling, and a
/// separately written integrator agree in every pixel. A strategy that loses or doubles what
/// another finds, a wrong density or a missing selection probability shows here: the 2017
/// program kept 2.8 % of its direct light.
#[test]
fn all_strategies_agree_in_every_pixel() {
    let base = Settings {
        size: [SIZE; 2],
        spp: 2048,
        sampler: SamplerKind::Independent,
        ..Settings::default()
    };
    let way = |strategy, seed| Settings { strategy, seed, ..base.clone() };
    let ways = [
        ("both", way(Strategy::Both, 1)),
        ("light", way(Strategy::LightOnly, 2)),
        ("bsdf", way(Strategy::BsdfOnly, 3)),
        ("naive", Settings { integrator: IntegratorKind::Naive, ..way(Strategy::Both, 4) }),
        ("roulette by albedo", Settings { roulette: Roulette::Albedo, ..way(Strategy::Both, 5) }),
    ];
    let scenes = scenes::all();
    let pairs = ways.len() * (ways.len() - 1) / 2;
    let scores = scenes.len() * pairs * (SIZE * SIZE * 3) as usize;
    let critical = critical_z(scores, 0.01);
    let mut failures = Vec::new();
    for scenes::Named { name, scene } in &scenes {
        let scene = Arc::new(Prepared::new(scene).expect("a sound scene"));
        let images: Vec<Image> = ways.iter().map(|(_, s)| render(&scene, s.clone())).collect();
        for (i, a) in images.iter().enumerate() {
            for (j, b) in images.iter().enumerate().skip(i + 1) {
                let worst = largest_disagreement(a, b).expect("colour and variance");
                println!("{name}: {} against {}: z = {:.2}", ways[i].0, ways[j].0, worst.z);
                if worst.z > critical {
                    failures
                        .push(format!("{name}: {} against {}: {worst:?}", ways[i].0, ways[j].0));
                }
            }
        }
    }
    assert!(failures.is_empty(), "beyond z = {critical:.2}:\n{}", failures.join("\n"));
}

/// Emission and direct light are what paths of two segments bring, by an integrator of its own.
#[test]
fn direct_light_is_paths_of_two_segments() {
    let base = Settings {
        size: [SIZE; 2],
        spp: 2048,
        sampler: SamplerKind::Independent,
        ..Settings::default()
    };
    let scenes = scenes::all();
    let critical = critical_z(scenes.len() * (SIZE * SIZE * 3) as usize, 0.01);
    for scenes::Named { name, scene } in &scenes {
        let scene = Arc::new(Prepared::new(scene).expect("a sound scene"));
        let direct = Settings { integrator: IntegratorKind::Direct, ..base.clone() };
        let paths = Settings { max_depth: Some(2), seed: 1, ..base.clone() };
        let (direct, paths) = (render(&scene, direct), render(&scene, paths));
        let worst = largest_disagreement(&direct, &paths).expect("colour and variance");
        assert!(worst.z <= critical, "{name}: {worst:?}, beyond z = {critical:.2}");
    }
}
