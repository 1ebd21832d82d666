//! `rutilant convert`: any scene as a native one, for people to go on with.

use crate::failure::{Exit, Failure};
use crate::load::{self, Reading};
use crate::say::tell;
use rutilant_formats::{ConvertOptions, SceneError, SceneErrorKind, convert};
use std::path::{Path, PathBuf};

pub(crate) const EXAMPLES: &str = "\
Examples:
  rutilant convert model.glb model.toml             a glTF file as a scene in text; meshes and pictures
                                                    go to model_assets
  rutilant convert dragon.ply dragon.toml           the scene names dragon.ply, which stays where it is
  rutilant convert model.glb sent/a.toml --copy     a folder that has all it needs
  rutilant convert model.glb night.toml --variant night --at-time 1.5

Nothing is written before the new scene has been read and found to be the same as the old one.
Exit status: 0 done, 1 the disk does not take the files, 2 bad usage or a scene that cannot be written.";

#[derive(clap::Args)]
pub(crate) struct Args {
    /// The scene to read: .toml, .gltf, .glb, .pbrt, .xml, .obj, .ply, .stl
    scene: PathBuf,
    /// The scene to write: .toml; its folder must be there
    to: PathBuf,
    /// Write over files that are there already
    #[arg(long)]
    force: bool,
    /// Copy files that could be named where they are as well
    #[arg(long)]
    copy: bool,
    #[command(flatten)]
    reading: Reading,
}

pub(crate) fn run(args: &Args) -> Result<Exit, Failure> {
    let to = &args.to;
    if !to.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml")) {
        let what = "scenes are written as .toml; give the new scene that extension";
        return Err(Failure::usage(format!("{}: {what}", to.display())));
    }
    if is_same_file(&args.scene, to) {
        let what = "this is the scene itself; write the new one to another file";
        return Err(Failure::usage(format!("{}: {what}", to.display())));
    }
    // Said before a large scene is read.
    if to.symlink_metadata().is_ok() && !args.force {
        let what = "there is such a file already; --force writes over it";
        return Err(Failure::usage(format!("{}: {what}", to.display())));
    }
    let loaded = load::read(Some(&args.scene), &args.reading, None)?;
    for note in &loaded.notes {
        tell(&format!("note: {note}"));
    }
    if loaded.files.iter().any(|file| is_same_file(file, to)) {
        let what = "the scene is made of this file; write the new one to another";
        return Err(Failure::usage(format!("{}: {what}", to.display())));
    }
    let options = ConvertOptions { copy: args.copy, limits: args.reading.limited.limits() };
    let converted = convert(&loaded, &args.scene, to, &options).map_err(|error| failure(&error))?;
    for note in &converted.notes {
        tell(&format!("note: {note}"));
    }
    let written = converted.write(to, args.force).map_err(|error| {
        let failure = failure(&error);
        // The disk's failures are not to be forced.
        let hint = if failure.exit == Exit::Usage { "; --force writes over it" } else { "" };
        Failure { line: failure.line + hint, ..failure }
    });
    for path in written? {
        tell(&format!("wrote {}", path.display()));
    }
    Ok(Exit::Done)
}

fn is_same_file(one: &Path, other: &Path) -> bool {
    match (one.canonicalize(), other.canonicalize()) {
        (Ok(one), Ok(other)) => one == other,
        (_, _) => false,
    }
}

/// The disk's failures are told apart from those of the scene.
fn failure(error: &SceneError) -> Failure {
    let exit = match error.kind {
        SceneErrorKind::Io(_) => Exit::Failed,
        _ => Exit::Usage,
    };
    Failure { exit, line: error.to_string() }
}
