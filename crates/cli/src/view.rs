//! `rutilant view`: a window on a scene.

use crate::failure::{Exit, Failure};
use crate::load::{self, Reading};
use crate::options::{self, Integrator};
use crate::render::metadata;
use crate::say::{print_json, print_line, tell};
use rutilant::settings::Settings;
use rutilant_viewer::{BuiltIn, FrameTimes, Happened, Options};
use serde::Serialize;
use std::path::PathBuf;
use std::sync::{Arc, mpsc};
use std::time::Instant;

pub(crate) const EXAMPLES: &str = "\
Examples:
  rutilant view                          the built-in glass cube
  rutilant view kitchen.toml             a scene; its file is watched while you edit it
  rutilant view dragon.ply --size 1280x720

F1 shows the keys, P prints the camera as TOML, Escape closes the window.";

#[derive(clap::Args)]
pub(crate) struct Args {
    /// A scene: .toml, .gltf, .glb, .pbrt, .xml, .obj, .ply, .stl; the built-in glass cube if none is named
    scene: Option<PathBuf>,
    /// Samples per pixel after which the picture is done
    #[arg(long, value_name = "N", help_heading = PICTURE, value_parser = options::count::<u64>, allow_hyphen_values = true)]
    spp: Option<u64>,
    /// Width and height of the picture in pixels, like 800x600
    #[arg(long, value_name = "WxH", help_heading = PICTURE, value_parser = options::size)]
    size: Option<[u32; 2]>,
    /// Another seed gives another, equally good picture
    #[arg(long, value_name = "N", help_heading = PICTURE, value_parser = options::seed, allow_hyphen_values = true)]
    seed: Option<u64>,
    /// What is computed along each path
    #[arg(long, value_name = "NAME", help_heading = PICTURE, value_enum)]
    integrator: Option<Integrator>,

    #[command(flatten)]
    reading: Reading,

    /// Threads that render; any number gives the same picture [default: one for each core]
    #[arg(long, value_name = "N", help_heading = RUNNING, value_parser = options::threads, default_value_t = options::all_threads(), hide_default_value = true)]
    threads: usize,
    /// Print what happens in the window, a line of JSON each
    #[arg(long, help_heading = RUNNING)]
    json: bool,
}

const PICTURE: &str = "Picture";
const RUNNING: &str = "Running";

/// What happened, and how many seconds after the program began.
#[derive(Serialize)]
#[serde(tag = "event", rename_all = "kebab-case")]
enum Line {
    Opened { at: f64, scene: String },
    Picture { at: f64, size: [u32; 2], full: bool },
    Pose { at: f64, toml: String },
    Wrote { at: f64, file: PathBuf, hash: Option<String> },
    Trouble { at: f64, what: String },
    Closed { at: f64, hash: Option<String>, samples: Option<u64>, frames: Frames },
}

/// How long the interface took for its frames, painting included.
#[derive(Serialize)]
struct Frames {
    count: u64,
    median_ms: f64,
    ms_of_99_percent: f64,
    longest_ms: f64,
}

impl From<&FrameTimes> for Frames {
    fn from(times: &FrameTimes) -> Self {
        let ms = |time: std::time::Duration| 1e3 * time.as_secs_f64();
        Self {
            count: times.count(),
            median_ms: ms(times.quantile(0.5)),
            ms_of_99_percent: ms(times.quantile(0.99)),
            longest_ms: ms(times.longest()),
        }
    }
}

pub(crate) fn run(args: &Args) -> Result<Exit, Failure> {
    let start = Instant::now();
    load::use_threads(args.threads)?;
    let &Args { spp, size, seed, integrator, json, .. } = args;
    let adjust = move |settings: &mut Settings| {
        settings.spp = spp.unwrap_or(settings.spp);
        settings.seed = seed.unwrap_or(settings.seed);
        settings.integrator = integrator.map_or(settings.integrator, Into::into);
    };
    let reading = rutilant_viewer::Reading {
        built_in: BuiltIn {
            file: load::BUILT_IN_FILE,
            text: load::BUILT_IN_TEXT,
            images: load::BUILT_IN_IMAGES,
        },
        limits: args.reading.limited.limits(),
        allow_outside: args.reading.allow_path,
        strict: args.reading.strict,
        variant: args.reading.variant.clone(),
        at_time: args.reading.at_time,
        parameters: args.reading.parameters.clone(),
        camera: args.reading.camera.clone().unwrap_or_default(),
        sky: args.reading.environment.clone().unwrap_or_default(),
        size,
        adjust: Arc::new(adjust),
    };
    // Printed on a thread of its own: somebody who reads slowly does not hold up the window.
    let (sender, receiver) = mpsc::channel();
    let printing = std::thread::spawn(move || {
        for (happened, at) in receiver {
            // Somebody who no longer listens is no reason to close the window.
            drop(if json { print_json(&line(happened, at)) } else { say(happened) });
        }
    });
    let report = move |happened: Happened| {
        drop(sender.send((happened, start.elapsed().as_secs_f64())));
    };
    let (scene, threads) = (args.scene.clone(), args.threads);
    let describe: rutilant_viewer::Describe =
        Arc::new(|settings, samples| metadata(settings, samples, None, !settings.caustics));
    rutilant_viewer::run(Options { scene, reading, threads, describe, report: Box::new(report) })
        .map_err(|error| Failure::failed(error.to_string()))?;
    drop(printing.join());
    Ok(Exit::Done)
}

fn line(happened: Happened, at: f64) -> Line {
    match happened {
        Happened::Opened { name } => Line::Opened { at, scene: name },
        Happened::Picture { size, full } => Line::Picture { at, size, full },
        Happened::Pose { toml } => Line::Pose { at, toml },
        Happened::Wrote { file, hash } => Line::Wrote { at, file, hash },
        Happened::Closed { frames, picture } => {
            let (hash, samples) = picture.unzip();
            Line::Closed { at, hash, samples, frames: Frames::from(&frames) }
        }
        Happened::Trouble { what } => Line::Trouble { at, what },
    }
}

/// For people: only what was asked for, and what went wrong.
fn say(happened: Happened) -> Result<(), Failure> {
    match happened {
        Happened::Pose { toml } => print_line(&toml),
        Happened::Wrote { file, .. } => {
            tell(&format!("wrote {}", file.display()));
            Ok(())
        }
        Happened::Trouble { what } => {
            tell(&what);
            Ok(())
        }
        Happened::Opened { .. } | Happened::Picture { .. } | Happened::Closed { .. } => Ok(()),
    }
}
