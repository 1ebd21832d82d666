//! The command line of Rutilant: a table of modes.
//!
//! Each mode is a file with its options, called `Args`, and a function `run`.
//! Results that were asked for go to standard output, everything else to
//! standard error. Only here does the process end.

mod bench;
mod check;
mod command;
mod compare;
mod convert;
mod failure;
mod focus;
mod info;
mod interrupt;
mod load;
mod options;
mod output;
mod progress;
mod render;
mod say;
mod tev;
mod text;
#[cfg(feature = "window")]
mod view;

use clap::{Parser, Subcommand};
use failure::Failure;
use say::tell;
use std::process::ExitCode;

#[derive(Parser)]
#[command(
    name = "rutilant",
    version,
    about = "Rutilant takes a scene and gives the picture that light would make.",
    after_help = EXAMPLES,
    args_conflicts_with_subcommands = true,
    max_term_width = 100
)]
struct Cli {
    #[command(subcommand)]
    mode: Option<Mode>,
    /// Without a mode: render.
    #[command(flatten)]
    render: render::Args,
}

#[derive(Subcommand)]
enum Mode {
    /// Render a scene; this is what happens when no command is named
    #[command(after_help = render::EXAMPLES)]
    Render(render::Args),
    /// Open a window on a scene: move, look and edit while the picture clears up
    #[cfg(feature = "window")]
    #[command(after_help = view::EXAMPLES)]
    View(view::Args),
    /// Read, validate and prepare scenes, render nothing
    Check(check::Args),
    /// Say what is in a scene: triangles, materials, lights, bounds, ray tree
    Info(info::Args),
    /// Write any scene as a native one, to go on with: a text, and the files that it needs
    #[command(after_help = convert::EXAMPLES)]
    Convert(convert::Args),
    /// Say how far an image is from a reference: RMSE, relMSE, PSNR, SSIM, FLIP
    #[command(after_help = compare::EXAMPLES)]
    Compare(compare::Args),
    /// Measure speed
    #[command(subcommand, arg_required_else_help = false)]
    Bench(bench::Mode),
}

const EXAMPLES: &str = "\
Examples:
  rutilant                                  the built-in glass cube, into glass-cube.png
  rutilant kitchen.toml                     render a scene into kitchen.png
  rutilant kitchen.toml -o a.exr -o a.png   full radiance for editing, and a picture to look at
  rutilant kitchen.toml --time 60s          as many samples as a minute allows, one pass at least
  rutilant dragon.ply --size 1920x1080      a bare mesh, under an even sky
  rutilant box.xml -D spp=256               a Mitsuba scene, with another $spp than its own
  rutilant check kitchen.toml               is the scene all right?
  rutilant compare a.exr reference.exr      how far is it from the truth?
  rutilant convert model.glb model.toml     as a scene in text, to go on with

Scenes: .toml (docs/scene-format.md), .gltf, .glb (docs/gltf.md), .pbrt (docs/pbrt.md), .xml (Mitsuba; docs/mitsuba.md), .obj, .ply, .stl. Images: .exr, .hdr, .pfm, .png, .jpg; .webp and .tga are only read.
Exit status: 0 done, 1 failed, 2 bad usage or bad scene, 130 interrupted.";

fn main() -> ExitCode {
    let cli = match command::parse() {
        Ok(cli) => cli,
        Err(Failure { exit, line }) => {
            tell(&line);
            return exit.into();
        }
    };
    let end = match &cli.mode {
        None => render::run(&cli.render),
        Some(Mode::Render(args)) => render::run(args),
        #[cfg(feature = "window")]
        Some(Mode::View(args)) => view::run(args),
        Some(Mode::Check(args)) => check::run(args),
        Some(Mode::Info(args)) => info::run(args),
        Some(Mode::Convert(args)) => convert::run(args),
        Some(Mode::Compare(args)) => compare::run(args),
        Some(Mode::Bench(mode)) => bench::run(mode),
    };
    match end {
        Ok(exit) => exit.into(),
        Err(Failure { exit, line }) => {
            tell(&line);
            exit.into()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    /// Options that contradict each other would only show when somebody uses them.
    #[test]
    fn the_table_of_options_is_sound() {
        Cli::command().debug_assert();
    }

    /// A scene may stand without the word `render`, with options on both sides.
    #[test]
    fn rendering_needs_no_word() {
        for line in ["rutilant", "rutilant a.toml", "rutilant --spp 4 a.toml -o b.png"] {
            let cli = Cli::try_parse_from(line.split(' ')).unwrap();
            assert!(cli.mode.is_none(), "{line}");
        }
        let cli = Cli::try_parse_from(["rutilant", "render", "a.toml", "--spp", "4"]).unwrap();
        assert!(matches!(cli.mode, Some(Mode::Render(_))));
        let wrong = Cli::try_parse_from(["rutilant", "a.toml", "--ssp", "4"]);
        assert!(wrong.err().unwrap().to_string().contains("--spp"));
    }
}
