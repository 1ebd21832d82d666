//! The command line as a whole: which mode is meant.
//!
//! A scene may stand where a command may stand, so a mistyped command looks
//! like a scene, and the scene after it like a command. The parser's own words
//! for that lead astray; here stand better ones.

use crate::Cli;
use crate::failure::{Exit, Failure};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Command, CommandFactory, Parser};
use std::ffi::OsString;
use std::path::Path;

/// Reads the command line. Ends the process where help or the version was asked for.
pub(crate) fn parse() -> Result<Cli, Failure> {
    let line: Vec<OsString> = std::env::args_os().collect();
    if let Some(word) = line.get(1).and_then(|word| word.to_str())
        && is_meant_as_command(word)
        && !is_command(word)
        && !Path::new(word).is_file()
    {
        return Err(Failure::usage(unknown(word)));
    }
    Cli::try_parse_from(line).map_err(|error| match misplaced(&error) {
        Some(what) => Failure::usage(what),
        None if error.use_stderr() => Failure { exit: Exit::Usage, line: in_a_line(&error) },
        None => error.exit(),
    })
}

/// The parser's words in one line: what is wrong, the values that there are, its hint.
fn in_a_line(error: &clap::Error) -> String {
    let text = error.render().to_string();
    let lines = text.lines().map(str::trim);
    let said = lines
        .take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more information"))
        .map(|line| line.trim_start_matches("error: ").trim_matches(['[', ']']))
        .filter(|line| !line.is_empty());
    let joined = said.fold(String::new(), |all, line| match all.chars().last() {
        None => line.to_owned(),
        Some(':') => format!("{all} {line}"),
        Some(_) => format!("{all}; {line}"),
    });
    let joined: String = joined.chars().filter(|c| !c.is_control()).collect();
    format!("rutilant: {joined}; see --help")
}

/// True for one word without dots, as no path of a scene is.
fn is_meant_as_command(word: &str) -> bool {
    word.starts_with(char::is_alphanumeric)
        && word.chars().all(|c| c.is_alphanumeric() || matches!(c, '-' | '_'))
}

/// What is said of a word that is no command.
fn unknown(word: &str) -> String {
    if cfg!(not(feature = "window")) && word == "view" {
        return "this program was built without the window".to_owned();
    }
    match nearest(word) {
        Some(name) => format!("no command \"{word}\"; did you mean \"{name}\"?"),
        None => format!(
            "no command \"{word}\"; commands are {}; scenes end in .toml, .gltf, .glb, .pbrt, .xml, .obj, .ply or .stl",
            names().join(", ")
        ),
    }
}

/// What is said of a second scene, or of a command behind something else: the parser takes
/// what comes after a scene, or the command itself, for the wrong one of the two.
fn misplaced(error: &clap::Error) -> Option<String> {
    match (error.kind(), error.get(ContextKind::InvalidSubcommand)) {
        (ErrorKind::ArgumentConflict, Some(ContextValue::String(word))) => Some(format!(
            "\"{word}\" is one too many: one scene is rendered at a time, and a command comes first"
        )),
        _ => None,
    }
}

fn names() -> Vec<String> {
    let names = Cli::command().get_subcommands().map(|c| c.get_name().to_owned()).collect();
    // The parser adds this one by itself.
    [names, vec!["help".to_owned()]].concat()
}

fn is_command(word: &str) -> bool {
    names().iter().any(|name| name == word)
}

/// The command that `word` is nearest to, in the parser's judgement, if any is near.
fn nearest(word: &str) -> Option<String> {
    // Without places for anything but a command.
    let bare = Command::new("rutilant").subcommands(Cli::command().get_subcommands().cloned());
    let error = bare.try_get_matches_from(["rutilant", word]).err()?;
    match error.get(ContextKind::SuggestedSubcommand)? {
        ContextValue::String(name) => Some(name.clone()),
        // The nearest one comes last.
        ContextValue::Strings(names) => names.last().cloned(),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A hint must help: slips lead to the command, other words to the list of all.
    #[test]
    fn only_near_commands_are_suggested() {
        for (word, name) in [
            ("rendr", "render"),
            ("rneder", "render"),
            ("chekc", "check"),
            ("comapre", "compare"),
            ("infos", "info"),
            ("hlep", "help"),
        ] {
            assert_eq!(nearest(word).as_deref(), Some(name), "{word}");
        }
        for word in ["paint", "kitchen", "x", "denoise"] {
            assert_eq!(nearest(word), None, "{word}");
            for name in ["render", "check", "info", "compare", "bench"] {
                assert!(unknown(word).contains(name), "{word}");
            }
        }
    }

    /// Whatever could be a path or an option is left to those who know paths and options.
    #[test]
    fn paths_and_options_are_no_commands() {
        for word in ["a.toml", "./a", "a/b", "C:\\a", "--spp", "-o", "", "..", "kitchen.scene"] {
            assert!(!is_meant_as_command(word), "{word}");
        }
    }
}
