//! How a run ends, and what it says when it cannot go on.

use rutilant::scene::SceneProblem;
use rutilant_formats::{ImageError, SceneError};
use std::process::ExitCode;

/// What the process tells its caller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Exit {
    /// Everything was done.
    Done = 0,
    /// Something went wrong on the way.
    Failed = 1,
    /// What was given cannot be used; nothing was done with it.
    Usage = 2,
    /// The user, or the system, asked to stop.
    Interrupted = 130,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

/// Why a run ended early: one line for people, one number for scripts.
#[derive(Debug)]
pub(crate) struct Failure {
    pub exit: Exit,
    /// The line on standard error, as it stands there.
    pub line: String,
}

impl Failure {
    /// What was given cannot be used.
    pub(crate) fn usage(what: impl std::fmt::Display) -> Self {
        Self { exit: Exit::Usage, line: format!("error: {what}") }
    }

    /// Something went wrong on the way.
    pub(crate) fn failed(what: impl std::fmt::Display) -> Self {
        Self { exit: Exit::Failed, line: format!("error: {what}") }
    }
}

impl From<SceneError> for Failure {
    /// A scene that cannot be used. Its line starts with the place, as compilers do it, so that
    /// editors can jump there.
    fn from(error: SceneError) -> Self {
        Self { exit: Exit::Usage, line: error.to_string() }
    }
}

impl From<SceneProblem> for Failure {
    fn from(problem: SceneProblem) -> Self {
        Self::usage(problem)
    }
}

impl From<ImageError> for Failure {
    fn from(error: ImageError) -> Self {
        Self::usage(error)
    }
}
