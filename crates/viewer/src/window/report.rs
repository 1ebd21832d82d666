//! What the window tells whoever opened it.

use crate::frames::FrameTimes;
use std::path::PathBuf;

/// Something that happened in the window that somebody outside may want to know.
#[derive(Clone, Debug)]
pub enum Happened {
    /// A scene was opened.
    Opened {
        /// What people call it.
        name: String,
    },
    /// A picture is on the screen.
    Picture {
        /// Pixels of the picture, reduced or not.
        size: [u32; 2],
        /// Whether it has its full size.
        full: bool,
    },
    /// The user asked where the camera stands: a `[camera]` table.
    Pose {
        /// The table.
        toml: String,
    },
    /// Something was written.
    Wrote {
        /// The file.
        file: PathBuf,
        /// The fingerprint of the picture, where it was one.
        hash: Option<String>,
    },
    /// The window was closed.
    Closed {
        /// How long the interface took for its frames.
        frames: FrameTimes,
        /// The fingerprint of the last picture, and how many samples each of its pixels has.
        picture: Option<(String, u64)>,
    },
    /// Something went wrong; the window says so as well.
    Trouble {
        /// One line.
        what: String,
    },
}

/// Tells what happens in a window.
pub type Report = Box<dyn FnMut(Happened)>;
