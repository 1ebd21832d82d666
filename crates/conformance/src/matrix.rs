//! Every way of finding light, in every scene, held against every other.

use crate::agreement::{Comparison, Variance, any_of, compare};
use crate::scenes::Named;
use rutilant::image::Image;
use rutilant::scene::SceneProblem;
use rutilant::settings::{
    Heuristic, IntegratorKind, LightSelection, Roulette, SamplerKind, Settings, Strategy,
};
use rutilant::{Prepared, Session};
use std::sync::Arc;
use std::time::Duration;

/// The side of the pictures, in pixels.
const SIZE: u32 = 14;

/// Longer paths bring less light than any noise here: without roulette they end there.
const LONGEST: u32 = 100;

/// A way of finding light, and what to call it.
#[derive(Clone, Debug)]
pub struct Way {
    /// What to call it in a report.
    pub name: &'static str,
    /// How it is done; each way has a seed of its own.
    pub settings: Settings,
}

/// All ways there are, at `spp` samples per pixel. All give the same picture in the end.
pub fn ways(spp: u64) -> Vec<Way> {
    let base =
        Settings { size: [SIZE; 2], spp, sampler: SamplerKind::Independent, ..Settings::default() };
    let all = [
        ("both", base.clone()),
        ("both, balance", Settings { heuristic: Heuristic::Balance, ..base.clone() }),
        ("light", Settings { strategy: Strategy::LightOnly, ..base.clone() }),
        ("bsdf", Settings { strategy: Strategy::BsdfOnly, ..base.clone() }),
        ("naive", Settings { integrator: IntegratorKind::Naive, ..base.clone() }),
        ("roulette by albedo", Settings { roulette: Roulette::Albedo, ..base.clone() }),
        (
            "no roulette",
            Settings { roulette: Roulette::Off, max_depth: Some(LONGEST), ..base.clone() },
        ),
        ("lights uniformly", Settings { light_selection: LightSelection::Uniform, ..base.clone() }),
        ("lights by a tree", Settings { light_selection: LightSelection::Tree, ..base.clone() }),
        ("sobol", Settings { sampler: SamplerKind::Sobol, ..base.clone() }),
        ("both, optimal", Settings { heuristic: Heuristic::Optimal, ..base.clone() }),
        ("no light paths", Settings { caustics: false, ..base }),
    ];
    let named = |((name, settings), seed)| Way { name, settings: Settings { seed, ..settings } };
    all.into_iter().zip(1..).map(named).collect()
}

/// Two ways of rendering one scene.
#[derive(Clone, Debug)]
pub struct Pair {
    /// Which scene.
    pub scene: &'static str,
    /// Which ways.
    pub ways: [&'static str; 2],
    /// How they differ.
    pub comparison: Comparison,
    /// The probability that chance makes any of all pairs differ as much.
    pub p: f64,
}

impl Pair {
    /// False where the two ways differ more than chance makes any pair differ in one of a hundred reports.
    pub fn agrees(&self) -> bool {
        self.p >= 0.01
    }
}

/// Renders every scene in every way and compares all pairs. `told` hears each scene's name
/// before it is rendered.
///
/// # Errors
/// A scene that cannot be prepared, or settings that cannot be used.
pub fn agreement(
    scenes: &[Named],
    ways: &[Way],
    threads: usize,
    mut told: impl FnMut(&str),
) -> Result<Vec<Pair>, SceneProblem> {
    let mut pairs = Vec::new();
    for Named { name, scene } in scenes {
        told(name);
        let scene = Arc::new(Prepared::new(scene)?);
        let images: Result<Vec<Image>, _> =
            ways.iter().map(|way| render(&scene, way.settings.clone(), threads)).collect();
        let images = images?;
        for (i, a) in ways.iter().enumerate() {
            for (j, b) in ways.iter().enumerate().skip(i + 1) {
                let independent =
                    [a, b].iter().all(|way| way.settings.sampler == SamplerKind::Independent);
                let variance = if independent { Variance::Measured } else { Variance::UpperBound };
                let comparison = compare(&images[i], &images[j], variance)
                    .expect("renderings have colour and variance");
                pairs.push(Pair { scene: name, ways: [a.name, b.name], comparison, p: 1.0 });
            }
        }
    }
    let family = pairs.len();
    for pair in &mut pairs {
        pair.p = any_of(pair.comparison.p, family);
    }
    Ok(pairs)
}

/// Renders to the end.
///
/// # Errors
/// Settings that cannot be used.
///
/// # Panics
/// If a sample is no number: that is a bug in the renderer.
pub fn render(
    scene: &Arc<Prepared>,
    settings: Settings,
    threads: usize,
) -> Result<Image, SceneProblem> {
    let session = Session::start(Arc::clone(scene), settings, threads)?;
    while !session.wait(Duration::from_secs(3600)) {}
    let dropped = session.progress().dropped;
    assert_eq!(dropped.count, 0, "samples were no numbers: {dropped:?}");
    Ok(session.snapshot())
}
