//! What a caller may ask of reading.

use crate::Limits;
use rutilant::color::Rgb;
use std::path::PathBuf;

/// How to read a scene. The default is right for files from strangers.
#[derive(Clone, Copy, Debug, Default)]
pub struct ReadOptions<'a> {
    /// How much the files may ask for.
    pub limits: Limits,
    /// Whether a scene may name files outside its own folder.
    pub allow_outside: bool,
    /// The size that the picture will have whatever the file says: for a camera that is chosen
    /// to see everything.
    pub size: Option<[u32; 2]>,
    /// Files that need no disk, by the name that a native scene uses: found before any other.
    /// Pictures, meshes and places of instances can be such.
    pub embedded: &'a [(&'a str, &'a [u8])],
    /// Whether a picture of a texture that is missing or cannot be read is an error; else it is
    /// magenta, with a note.
    pub strict: bool,
    /// The name of the variant whose materials are shown, of a glTF file that has some; for others it
    /// is an error.
    pub variant: Option<&'a str>,
    /// The time, in seconds, of the first animation of a glTF file at which all stands; where no
    /// animation has moved it if `None`. Where there is none, a note says so.
    pub at_time: Option<f32>,
    /// Names and values of a Mitsuba scene's parameters, which stand before its own defaults; the last
    /// of a name counts. One that the scene does not know is an error.
    pub parameters: &'a [(String, String)],
    /// Which camera sees the scene.
    pub camera: &'a CameraChoice,
    /// The sky.
    pub sky: &'a SkyChoice,
}

/// Which camera sees a scene.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum CameraChoice {
    /// The first one of the scene; where it has none, one that sees everything.
    #[default]
    First,
    /// The one of this name; where none is called so, the one of this number, counted from 1.
    Named(String),
    /// One that sees everything, whatever cameras the scene has. It comes after these.
    Auto,
}

/// Which sky a scene has.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum SkyChoice {
    /// Its own. Meshes, and glTF documents without a light, have an even white one.
    #[default]
    Own,
    /// None: it is black.
    None,
    /// The same radiance everywhere, in W/(m² sr).
    Even(Rgb),
    /// The picture in a file, counted from the folder that the program runs in; how directions lie
    /// on it is [likely](rutilant::light::Projection::likely) by its proportions. It comes after
    /// the scene's own images.
    Picture(PathBuf),
}

impl Default for &CameraChoice {
    fn default() -> Self {
        static FIRST: CameraChoice = CameraChoice::First;
        &FIRST
    }
}

impl Default for &SkyChoice {
    fn default() -> Self {
        static OWN: SkyChoice = SkyChoice::Own;
        &OWN
    }
}
