//! What a limit on the length of paths costs in light, and how long paths are.
//!
//! ```sh
//! cargo run --release -p rutilant-formats --example depth -- scenes/glass-cube.toml 64
//! ```
//!
//! Renders a scene, in small and with so many samples per pixel, at longer and longer `max_depth`
//! and without one. For each: the mean luminance, what is missing of that without a limit, the
//! standard error of both, and the mean number of rays for each path, shadow rays included.

use rutilant::settings::Settings;
use rutilant::{Prepared, Session};
use rutilant_formats::{ReadOptions, read_scene};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

/// Width and height of the small picture, at most.
const SIDE: u32 = 200;

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let (scene, spp) = match &words[..] {
        [scene] => (scene, Some(64)),
        [scene, spp] => (scene, spp.parse::<u64>().ok().filter(|n| *n > 0)),
        _ => (&String::new(), None),
    };
    let Some(spp) = spp else {
        eprintln!("depth SCENE [SAMPLES]");
        return ExitCode::from(2);
    };
    match report(scene, spp) {
        Ok(()) => ExitCode::SUCCESS,
        Err(what) => {
            eprintln!("{what}");
            ExitCode::FAILURE
        }
    }
}

fn report(scene: &str, spp: u64) -> Result<(), Box<dyn std::error::Error>> {
    let loaded = read_scene(scene.as_ref(), &ReadOptions::default())?;
    let prepared = Arc::new(Prepared::new(&loaded.scene)?);
    let [width, height] = loaded.settings.size;
    let scale = f64::from(SIDE) / f64::from(width.max(height));
    let size = [width, height].map(|side| ((f64::from(side) * scale) as u32).max(1));
    let render = |max_depth| -> Result<Measured, Box<dyn std::error::Error>> {
        let settings = Settings { size, crop: None, spp, max_depth, ..loaded.settings.clone() };
        measure(&Session::start(Arc::clone(&prepared), settings, 2)?)
    };
    let all = render(None)?;
    println!("max_depth  luminance       lost   error of both  rays per path");
    let limits = [1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 128];
    for limit in limits.map(Some).into_iter().chain([None]) {
        let this = if limit.is_some() { render(limit)? } else { all };
        let name = limit.map_or("none".to_owned(), |l: u32| l.to_string());
        let lost = 100.0 * (1.0 - this.mean / all.mean);
        let error = 100.0 * this.error.hypot(all.error) / all.mean;
        println!(
            "{name:>9}  {:>9.5}  {lost:>8.3} %  {error:>12.3} %  {:>13.2}",
            this.mean, this.rays_per_path
        );
    }
    Ok(())
}

#[derive(Clone, Copy)]
struct Measured {
    mean: f64,
    error: f64,
    rays_per_path: f64,
}

fn measure(session: &Session) -> Result<Measured, Box<dyn std::error::Error>> {
    while !session.wait(Duration::from_secs(3600)) {}
    let (image, progress) = (session.snapshot(), session.progress());
    let channel = |name: String| image.channel(&name).ok_or(name + " is missing");
    let (mut mean, mut variance) = (0.0, 0.0);
    let pixels = f64::from(image.width()) * f64::from(image.height());
    for (name, share) in [("R", 0.212_671), ("G", 0.715_160), ("B", 0.072_169)] {
        let sum = |values: &[f32]| values.iter().map(|&v| f64::from(v)).sum::<f64>();
        mean += share * sum(channel(name.to_owned())?) / pixels;
        // As if the channels had their noise in common: an upper bound.
        variance += share * sum(channel(format!("variance.{name}"))?);
    }
    let rays_per_path = progress.rays as f64 / progress.paths as f64;
    Ok(Measured { mean, error: variance.sqrt() / pixels, rays_per_path })
}
