//! `rutilant render`: from a scene to image files.

use crate::failure::{Exit, Failure};
use crate::focus::{self, Focus};
use crate::interrupt::Interrupt;
use crate::load::{self, Reading, timed};
use crate::options::{self, Bits, Channels, DisplayCurve, Integrator, Sampler};
use crate::output::{self, Detail};
use crate::progress::{Goal, Reporter, Spinner, Style};
use crate::say::{print_json, print_line, tell};
use crate::tev;
use crate::text::{scaled, several, time};
use rutilant::cryptomatte;
use rutilant::display::Display;
use rutilant::image::Image;
use rutilant::settings::{Crop, Layer, Layers, Settings};
use rutilant::{Prepared, Progress, Session};
use rutilant_formats::LoadedScene;
use rutilant_formats::image::{check_size, check_writable};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

pub(crate) const EXAMPLES: &str = "\
Examples:
  rutilant render kitchen.toml                          into kitchen.png, as the scene says
  rutilant render kitchen.toml --spp 1024 -o out.exr    scene-linear radiance, with variance
  rutilant render kitchen.toml --time 5m --progress json
  rutilant render kitchen.toml --size 3840x2160 --crop 1600,900,640,360
                                                        a window of a large picture, the same pixels
  rutilant render kitchen.toml --integrator normals     what the camera sees, without light
  rutilant render kitchen.toml --layers all -o out.exr  albedo, normals, depth, mattes … beside light
  rutilant render kitchen.toml --focus-on 400,300       what is in this pixel becomes sharp
  rutilant render kitchen.toml --tev localhost          watch it in tev, while it is rendered

Ctrl-C finishes the pass and writes the image; a second Ctrl-C stops at once.";

#[derive(clap::Args)]
pub(crate) struct Args {
    /// A scene: .toml, .gltf, .glb, .pbrt, .xml, .obj, .ply, .stl; the built-in glass cube if none is named
    scene: Option<PathBuf>,
    /// An image to write: .exr, .hdr, .pfm (scene-linear), .png, .jpg (for eyes); may be repeated
    /// [default: the scene's name with .png, in the current folder]
    #[arg(short, long = "output", value_name = "FILE")]
    outputs: Vec<PathBuf>,

    /// Samples per pixel
    #[arg(long, value_name = "N", help_heading = PICTURE, value_parser = options::count::<u64>, allow_hyphen_values = true)]
    spp: Option<u64>,
    /// Stop after this time, like 60s, 5m or 1h30m, but not before every pixel has a sample;
    /// without --spp, take all samples it allows
    #[arg(long, value_name = "TIME", help_heading = PICTURE, value_parser = options::duration, allow_hyphen_values = true)]
    time: Option<Duration>,
    /// Width and height in pixels, like 800x600
    #[arg(long, value_name = "WxH", help_heading = PICTURE, value_parser = options::size)]
    size: Option<[u32; 2]>,
    /// Render only this window of the picture, in pixels from its upper left corner
    #[arg(long, value_name = "X,Y,W,H", help_heading = PICTURE, value_parser = options::crop)]
    crop: Option<Crop>,
    /// Focus on what is seen in this pixel, through glass and in mirrors
    #[arg(long, value_name = "X,Y", help_heading = PICTURE, value_parser = options::pixel, allow_hyphen_values = true)]
    focus_on: Option<[u32; 2]>,
    /// Another seed gives another, equally good picture
    #[arg(long, value_name = "N", help_heading = PICTURE, value_parser = options::seed, allow_hyphen_values = true)]
    seed: Option<u64>,

    /// What is computed along each path
    #[arg(long, value_name = "NAME", help_heading = LIGHT, value_enum)]
    integrator: Option<Integrator>,
    /// Where random numbers come from
    #[arg(long, value_name = "NAME", help_heading = LIGHT, value_enum)]
    sampler: Option<Sampler>,
    /// The longest path in segments: 1 is emission seen directly, 2 direct light; for path and naive
    #[arg(long, value_name = "N", help_heading = LIGHT, value_parser = options::count::<u32>, allow_hyphen_values = true)]
    max_depth: Option<u32>,
    /// Trace no paths from lights: what glass and mirrors throw on other surfaces is left to chance
    #[arg(long, help_heading = LIGHT)]
    no_caustics: bool,

    /// Brightness in stops: each doubles it. Scene-linear files keep radiance as it is
    #[arg(long, value_name = "STOPS", help_heading = DISPLAY, value_parser = options::finite, allow_hyphen_values = true)]
    exposure: Option<f32>,
    /// What becomes of values above white
    #[arg(long, value_name = "NAME", help_heading = DISPLAY, value_enum)]
    curve: Option<DisplayCurve>,

    /// Bits of a number; each format takes the nearest it has
    /// [default: 32 in .exr, 8 in .png]
    #[arg(long, value_name = "BITS", help_heading = FILES, value_enum)]
    bits: Option<Bits>,
    /// Which channels .exr files hold
    #[arg(long, value_name = "NAME", help_heading = FILES, value_enum, default_value_t = Channels::All)]
    channels: Channels,
    /// What .exr files hold beside light: all, none, or some of albedo, normal, depth, position, uv,
    /// object, material, light, groups, cryptomatte, with commas between [default: what the scene
    /// asks for]
    #[arg(long, value_name = "NAMES", help_heading = FILES, value_parser = options::layers)]
    layers: Option<Layers>,

    #[command(flatten)]
    reading: Reading,

    /// Threads; any number gives the same picture [default: one for each core]
    #[arg(long, value_name = "N", help_heading = RUNNING, value_parser = options::threads, default_value_t = options::all_threads(), hide_default_value = true)]
    threads: usize,
    /// Instructions that rays are traced with; any give the same picture
    #[arg(long, value_name = "NAME", help_heading = RUNNING, value_enum, default_value_t = options::SimdLevel::Auto)]
    simd: options::SimdLevel,
    /// How much time the tree that rays go through is worth; any gives the same picture
    #[arg(long, value_name = "NAME", help_heading = RUNNING, value_enum, default_value_t = options::Build::Default)]
    build: options::Build,
    /// How progress is shown
    #[arg(long, value_name = "STYLE", help_heading = RUNNING, value_enum, default_value_t = Style::Bar)]
    progress: Style,
    /// Show the picture as it goes on in the image viewer tev, which listens there; without a port
    /// at 14158
    #[arg(long, value_name = "HOST:PORT", help_heading = RUNNING, value_parser = tev::Address::parse, allow_hyphen_values = true)]
    tev: Option<tev::Address>,
    /// Say nothing but results and errors
    #[arg(short, long, help_heading = RUNNING)]
    quiet: bool,
    /// Print the result as one line of JSON
    #[arg(long, help_heading = RUNNING)]
    json: bool,
}

const PICTURE: &str = "Picture";
const LIGHT: &str = "Light transport";
const DISPLAY: &str = "Display (.png, .jpg)";
const FILES: &str = "Files";
const RUNNING: &str = "Running";

/// What came of a rendering.
#[derive(Serialize)]
struct Outcome {
    event: &'static str,
    scene: PathBuf,
    outputs: Vec<PathBuf>,
    /// Fingerprint of all pixels: equal for equal pictures, on every machine.
    hash: String,
    size: [u32; 2],
    /// Column, row, width, height.
    crop: Option<[u32; 4]>,
    spp: u64,
    interrupted: bool,
    paths: u64,
    rays: u64,
    dropped: u64,
    first_dropped: Option<Dropped>,
    paths_per_second: f64,
    rays_per_second: f64,
    threads: usize,
    seconds: Seconds,
    /// What the camera is focused on, where it was told to find that out.
    focus: Option<Focus>,
    notes: Vec<String>,
}

/// A sample that was not a number.
#[derive(Clone, Copy, Serialize)]
struct Dropped {
    x: u32,
    y: u32,
    sample: u64,
}

/// Where the time went.
#[derive(Serialize)]
struct Seconds {
    read: f64,
    prepare: f64,
    render: f64,
    write: f64,
}

pub(crate) fn run(args: &Args) -> Result<Exit, Failure> {
    // What cannot end well does not begin.
    let interrupt = Interrupt::install()?;
    // Whether a file can be written is found out by making one.
    let outputs = interrupt.while_writing(|| outputs(args))?;
    let viewer = args.tev.as_ref().map(tev::Address::connect).transpose()?;
    load::use_threads(args.threads)?;
    let style = if args.quiet && args.progress == Style::Bar { Style::None } else { args.progress };

    // Read, and let the command line have the last word.
    let spinner = Spinner::start(style, "reading");
    let (loaded, reading) = timed(|| load::read(args.scene.as_deref(), &args.reading, args.size));
    let mut loaded = loaded?;
    let settings = settings(args, &loaded.settings);
    settings.validate()?;
    check_outputs(&outputs, &settings, &loaded)?;
    if let Some(pixel) = args.focus_on {
        focus::ask(&mut loaded.scene, pixel, settings.size)?;
    }
    let display = Display {
        exposure: args.exposure.unwrap_or(loaded.display.exposure),
        curve: args.curve.map_or(loaded.display.curve, Into::into),
    };
    drop(spinner);

    // Prepare.
    let spinner = Spinner::start(style, "preparing");
    let (prepared, preparing) = timed(|| load::prepare(&loaded, args.build, args.simd));
    let prepared = prepared?;
    let mut notes = load::notes(&loaded, &prepared, &settings, args.scene.as_deref());
    let (focus, no_focus) = focus::find(&loaded.scene, &prepared, settings.size);
    notes.extend(no_focus);
    let integrator = Integrator::from(settings.integrator);
    if args.max_depth.is_some() && !integrator.heeds_max_depth() {
        let name = options::name(&integrator);
        notes.push(format!("--max-depth changes nothing: the integrator \"{name}\" ignores it"));
    }
    let kept = args.channels == Channels::All && outputs.iter().any(|to| output::holds_layers(to));
    if args.layers.is_some_and(|layers| layers != Layers::NONE) && !kept {
        let what = "only .exr files with all their channels hold layers";
        notes.push(format!("--layers changes nothing: {what}"));
    }
    let mattes = settings.layers.has(Layer::Cryptomatte) && args.channels == Channels::All;
    let mattes = if mattes { cryptomatte::metadata(&loaded.scene) } else { Vec::new() };
    drop(loaded.scene);
    drop(spinner);
    if !args.quiet {
        notes.iter().for_each(|note| tell(&format!("note: {note}")));
        if let Some(focus) = &focus {
            tell(&format!("focus: {}", focus.describe()));
        }
    }

    // Render.
    let mut rendered = render(args, style, &prepared, &settings, &interrupt, viewer)?;
    notes.append(&mut rendered.notes);

    // Write. A file that fails must not take the others with it.
    let hash = format!("{:016x}", rendered.image.hash());
    let detail = Detail { bits: args.bits, channels: args.channels };
    let metadata = metadata(&settings, rendered.progress.samples, args.focus_on, args.no_caustics);
    let write = |path: &PathBuf| {
        let mut metadata = metadata.clone();
        if output::holds_layers(path) {
            metadata.extend(mattes.iter().cloned());
        }
        output::write(path, &rendered.image, &display, detail, metadata)
    };
    let (written, writing) =
        timed(|| interrupt.while_writing(|| outputs.iter().map(write).collect::<Vec<_>>()));
    if let Some(trouble) = rendered.viewer.take().and_then(tev::Viewer::finish) {
        if !args.quiet {
            tell(&format!("note: {trouble}"));
        }
        notes.push(trouble);
    }
    if written.iter().any(Result::is_err) {
        for (output, _) in outputs.iter().zip(&written).filter(|(_, result)| result.is_ok()) {
            tell(&format!("wrote {}", output.display()));
        }
    }
    let mut failures = written.into_iter().filter_map(Result::err).map(Failure::failed);
    if let Some(first) = failures.next() {
        failures.for_each(|failure| tell(&failure.line));
        return Err(first);
    }

    // Tell.
    let Progress { samples, paths, rays, dropped, .. } = rendered.progress;
    let per_second = |n: u64| n as f64 / rendered.time.as_secs_f64().max(1e-9);
    let outcome = Outcome {
        event: "done",
        scene: args.scene.clone().unwrap_or_else(|| load::BUILT_IN.into()),
        outputs,
        hash,
        size: settings.size,
        crop: settings.crop.map(|c| [c.x, c.y, c.width, c.height]),
        spp: samples,
        interrupted: interrupt.requested(),
        paths,
        rays,
        dropped: dropped.count,
        first_dropped: dropped.first.map(|d| Dropped { x: d.x, y: d.y, sample: d.sample }),
        paths_per_second: per_second(paths),
        rays_per_second: per_second(rays),
        threads: args.threads,
        seconds: Seconds {
            read: reading.as_secs_f64(),
            prepare: preparing.as_secs_f64(),
            render: rendered.time.as_secs_f64(),
            write: writing.as_secs_f64(),
        },
        focus,
        notes,
    };
    if !args.quiet {
        summarize(&outcome, args.scene.is_none());
    }
    if args.json || style == Style::Json {
        print_json(&outcome)?;
    } else {
        print_line(&format!("hash {}", outcome.hash))?;
    }
    if args.reading.strict && outcome.dropped > 0 {
        return Err(Failure::failed(format!(
            "{} dropped, and --strict allows none",
            several(outcome.dropped, "sample was", "samples were")
        )));
    }
    Ok(if outcome.interrupted { Exit::Interrupted } else { Exit::Done })
}

/// Where to write, all of it writable.
fn outputs(args: &Args) -> Result<Vec<PathBuf>, Failure> {
    let outputs = if args.outputs.is_empty() {
        // Not `with_extension`: a scene called `v1.2.toml` becomes `v1.2.png`.
        let mut name = load::stem(args.scene.as_deref()).into_os_string();
        name.push(".png");
        vec![PathBuf::from(name)]
    } else {
        args.outputs.clone()
    };
    for output in &outputs {
        let same = |scene: &Path| match (scene.canonicalize(), output.canonicalize()) {
            (Ok(scene), Ok(output)) => scene == output,
            _ => false,
        };
        // A picture that is given as a scene is told so when it is read.
        if !args.outputs.is_empty() && args.scene.as_deref().is_some_and(same) {
            return Err(Failure::usage(format!("{} is the scene itself", output.display())));
        }
        check_writable(output)?;
    }
    Ok(outputs)
}

/// Refuses to render what could not be written, or would be written over what the scene is made of.
fn check_outputs(
    outputs: &[PathBuf],
    settings: &Settings,
    loaded: &LoadedScene,
) -> Result<(), Failure> {
    let Crop { width, height, .. } = settings.window();
    for output in outputs {
        check_size(output, width, height)?;
        if output.canonicalize().is_ok_and(|output| loaded.files.contains(&output)) {
            let what = format!("{} is a file that the scene reads", output.display());
            return Err(Failure::usage(what));
        }
    }
    Ok(())
}

/// The settings of the scene, and what the command line says instead.
fn settings(args: &Args, scene: &Settings) -> Settings {
    // Without a number of samples, time alone decides.
    let spp = args.spp.or(args.time.map(|_| UNBOUNDED)).unwrap_or(scene.spp);
    // What is seen through a window beside the middle is a part of a larger picture, and already as
    // large as is asked for.
    let is_part = |size: [u32; 2]| {
        let beside = |c: &Crop| (c.x, c.y) != (0, 0) && [c.width, c.height] == size;
        scene.crop.as_ref().is_some_and(beside)
    };
    Settings {
        size: args.size.filter(|size| !is_part(*size)).unwrap_or(scene.size),
        crop: args.crop.or(scene.crop),
        spp,
        // Without a number, what the scene asks for is a better guess than none.
        planned_spp: args.spp.is_none().then_some(scene.spp),
        max_depth: args.max_depth.or(scene.max_depth),
        integrator: args.integrator.map_or(scene.integrator, Into::into),
        sampler: args.sampler.map_or(scene.sampler, Into::into),
        seed: args.seed.unwrap_or(scene.seed),
        caustics: scene.caustics && !args.no_caustics,
        layers: args.layers.unwrap_or(scene.layers),
        ..scene.clone()
    }
}

/// More samples than any time allows.
const UNBOUNDED: u64 = 1 << 32;

/// What is kept with the picture: all that the command line can say about it, in the words of
/// the command line, so that with the scene it can be made again. No times and no file names,
/// so that equal pictures are equal files.
pub(crate) fn metadata(
    settings: &Settings,
    samples: u64,
    focus_on: Option<[u32; 2]>,
    no_caustics: bool,
) -> Vec<(String, String)> {
    let [width, height] = settings.size;
    let crop = settings.crop.map(|c| format!("{},{},{},{}", c.x, c.y, c.width, c.height));
    [
        ("spp", Some(samples.to_string())),
        ("seed", Some(settings.seed.to_string())),
        ("size", Some(format!("{width}x{height}"))),
        ("crop", crop),
        ("focus_on", focus_on.map(|[x, y]| format!("{x},{y}"))),
        ("integrator", Some(options::name(&Integrator::from(settings.integrator)))),
        ("sampler", Some(options::name(&Sampler::from(settings.sampler)))),
        ("max_depth", settings.max_depth.map(|depth| depth.to_string())),
        ("no_caustics", no_caustics.then(|| "true".to_owned())),
    ]
    .into_iter()
    .filter_map(|(name, value)| Some((name.to_owned(), value?)))
    .collect()
}

/// A picture, and how it came about.
struct Rendered {
    image: Arc<Image>,
    progress: Progress,
    time: Duration,
    /// Where the image is on its way to.
    viewer: Option<tev::Viewer>,
    /// What was said on the way.
    notes: Vec<String>,
}

/// Renders until the samples are taken, the time is over, or the user has seen enough.
fn render(
    args: &Args,
    style: Style,
    prepared: &Arc<Prepared>,
    settings: &Settings,
    interrupt: &Interrupt,
    viewer: Option<tev::Connection>,
) -> Result<Rendered, Failure> {
    /// How often to look.
    const PERIOD: Duration = Duration::from_millis(50);
    let Crop { width, height, .. } = settings.window();
    let pixels = u64::from(width) * u64::from(height);
    let spp = (settings.spp != UNBOUNDED).then_some(settings.spp);
    let mut reporter = Reporter::start(style, Goal { pixels, spp, time: args.time });
    let session = Arc::new(Session::start(Arc::clone(prepared), settings.clone(), args.threads)?);
    let name = load::stem(args.scene.as_deref()).to_string_lossy().into_owned();
    let mut viewer = viewer.map(|viewer| viewer.show(name, &session, args.threads)).transpose()?;
    interrupt.rendering_starts();

    let (mut stopping, mut notes) = (false, Vec::new());
    let progress = loop {
        let finished = session.wait(PERIOD);
        let progress = session.progress();
        reporter.update(&progress)?;
        if let Some(trouble) = viewer.as_mut().and_then(tev::Viewer::trouble) {
            if !args.quiet {
                reporter.say(&format!("note: {trouble}; the rendering goes on"));
            }
            notes.push(trouble);
        }
        if finished {
            break progress;
        }
        // Before the first path there is no pass that could be finished, and no picture.
        if stopping || progress.paths == 0 {
            continue;
        }
        if interrupt.requested() {
            reporter.say("finishing this pass to write the image; again to stop at once");
        }
        if interrupt.requested()
            || args.time.is_some_and(|t| is_over(t, &reporter, &progress, pixels))
        {
            session.finish_pass();
            stopping = true;
        }
    };
    let time = reporter.elapsed();
    reporter.finish();
    if progress.samples < settings.spp && !stopping {
        return Err(Failure::failed("the rendering broke off; this is a bug in the renderer"));
    }
    let image = Arc::new(session.snapshot());
    if let Some(viewer) = &viewer {
        viewer.show_last(Arc::clone(&image));
    }
    Ok(Rendered { image, progress, time, viewer, notes })
}

/// True when the pass in flight should be the last one: the time is over, or another pass
/// would take much longer than what is left of it.
fn is_over(limit: Duration, reporter: &Reporter, progress: &Progress, pixels: u64) -> bool {
    /// So much later than asked for is as good as on time.
    const TOLERANCE: f64 = 0.25;
    let (limit, elapsed) = (limit.as_secs_f64(), reporter.elapsed().as_secs_f64());
    let seconds_per_path = elapsed / progress.paths.max(1) as f64;
    let left_of_this_pass =
        (progress.pass * pixels).saturating_sub(progress.paths) as f64 * seconds_per_path;
    let another_pass = pixels as f64 * seconds_per_path;
    elapsed >= limit || elapsed + left_of_this_pass + another_pass > limit + TOLERANCE
}

/// What came of it, for people.
fn summarize(outcome: &Outcome, built_in: bool) {
    let Outcome { size: [width, height], spp, dropped, .. } = outcome;
    let seconds = |s: f64| time(Duration::from_secs_f64(s));
    let window = outcome.crop.map(|[x, y, w, h]| format!(" (window {w}×{h} at {x},{y})"));
    tell(&format!(
        "{}: {width}×{height}{}, {}, {}samples/s, {}rays/s",
        outcome.scene.display(),
        window.unwrap_or_default(),
        several(*spp, "sample per pixel", "samples per pixel"),
        scaled(outcome.paths_per_second),
        scaled(outcome.rays_per_second),
    ));
    let took = &outcome.seconds;
    tell(&format!(
        "read {}, prepared {}, rendered {}, wrote {}",
        seconds(took.read),
        seconds(took.prepare),
        seconds(took.render),
        seconds(took.write),
    ));
    if let Some(Dropped { x, y, sample }) = outcome.first_dropped {
        tell(&format!(
            "note: {} not a number and left out; the first in pixel {x},{y}, sample {sample}",
            several(*dropped, "sample was", "samples were"),
        ));
    }
    for output in &outcome.outputs {
        tell(&format!("wrote {}", output.display()));
    }
    if built_in {
        for line in [
            "",
            "This is the built-in scene. Next, try",
            "  rutilant --spp 1024 -o glass-cube.exr     less noise, scene-linear",
            "  rutilant model.obj                        a mesh of your own, or a scene in TOML",
            "  rutilant --help                           everything else",
        ] {
            tell(line);
        }
    }
}
