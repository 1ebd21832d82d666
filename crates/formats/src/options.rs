//! What a caller may ask of reading.

use crate::Limits;

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
    /// The name of the variant whose materials are shown, of a glTF file that has some.
    pub variant: Option<&'a str>,
    /// The time, in seconds, of the first animation of a glTF file at which all stands; where no
    /// animation has moved it if `None`.
    pub at_time: Option<f32>,
    /// The name of the camera that sees the scene; the first one if `None`.
    pub camera: Option<&'a str>,
}
