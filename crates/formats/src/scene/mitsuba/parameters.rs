//! `$names` in attributes: what `<default>` and the command line say they stand for.

use super::document::Document;
use crate::error::{SceneError, SceneErrorKind};
use crate::scene::nearest::nearest;
use crate::shown::shown;
use std::path::Path;

/// All that are known.
pub(super) struct Parameters {
    known: Vec<Parameter>,
    /// Bytes that replacing has made.
    made: usize,
}

struct Parameter {
    name: String,
    value: String,
    /// Whether the command line says it.
    given: bool,
    /// Whether the scene has a default for it.
    declared: bool,
    used: bool,
}

/// Defaults may be made of others, over and over: so much text is made of them at most.
const MOST_MADE: usize = 16 << 20;

impl Parameters {
    pub(super) fn new(given: &[(String, String)]) -> Self {
        let mut known: Vec<Parameter> = Vec::new();
        for (name, value) in given {
            // The last word counts.
            known.retain(|parameter| parameter.name != *name);
            let (name, value) = (name.clone(), value.clone());
            known.push(Parameter { name, value, given: true, declared: false, used: false });
        }
        Self { known, made: 0 }
    }

    /// What a name stands for where nothing else was said before.
    pub(super) fn declare(&mut self, name: &str, value: String) {
        match self.known.iter_mut().find(|parameter| parameter.name == name) {
            Some(parameter) => parameter.declared = true,
            None => {
                let name = name.to_owned();
                self.known.push(Parameter {
                    name,
                    value,
                    given: false,
                    declared: true,
                    used: false,
                });
            }
        }
    }

    /// A text with all names replaced. Of names that begin alike the longest counts.
    pub(super) fn replace(&mut self, text: &str) -> Result<String, SceneErrorKind> {
        let mut made = String::new();
        let mut rest = text;
        while let Some(at) = rest.find('$') {
            made.push_str(&rest[..at]);
            rest = &rest[at + 1..];
            let fits = self.known.iter_mut().filter(|parameter| rest.starts_with(&parameter.name));
            let Some(parameter) = fits.max_by_key(|parameter| parameter.name.len()) else {
                return Err(self.unknown(rest));
            };
            parameter.used = true;
            made.push_str(&parameter.value);
            rest = &rest[parameter.name.len()..];
            self.made += parameter.value.len();
            if self.made > MOST_MADE {
                let (asked, allowed) = (self.made as u64, MOST_MADE as u64);
                let what = "bytes of text made of parameters in all";
                return Err(SceneErrorKind::Limit { what, asked, allowed });
            }
        }
        made.push_str(rest);
        Ok(made)
    }

    fn unknown(&self, rest: &str) -> SceneErrorKind {
        let is_part = |c: char| c.is_alphanumeric() || c == '_';
        let end = rest.find(|c: char| !is_part(c)).unwrap_or(rest.len());
        let name = &rest[..end];
        let closest = nearest(name, self.known.iter().map(|parameter| &*parameter.name)).map(shown);
        match closest {
            Some(_) => SceneErrorKind::Unknown { what: "parameter", name: shown(name), closest },
            None => SceneErrorKind::Invalid(format!(
                "no parameter \"{0}\": it has no <default>; give it with -D {0}=VALUE",
                shown(name)
            )),
        }
    }

    /// What the command line says must have a meaning.
    pub(super) fn finish(&self, path: &Path, document: &Document<'_>) -> Result<(), SceneError> {
        for parameter in self.known.iter().filter(|parameter| parameter.given && !parameter.used) {
            let name = shown(&parameter.name);
            if parameter.declared {
                let what = format!("nothing in it uses the parameter \"{name}\"");
                document.note(Default::default(), &what, &what);
                continue;
            }
            let others = self.known.iter().filter(|other| other.declared || other.used);
            let others: Vec<&str> = others.map(|other| &*other.name).collect();
            let closest = nearest(&parameter.name, others.iter().copied()).map(shown);
            let kind = match (closest, &others[..]) {
                (Some(closest), _) => {
                    SceneErrorKind::Unknown { what: "parameter", name, closest: Some(closest) }
                }
                (None, []) => {
                    SceneErrorKind::Invalid(format!("no parameter \"{name}\": it has none"))
                }
                (None, others) => {
                    let known: Vec<_> = others.iter().take(20).map(|other| shown(other)).collect();
                    let known = known.join(", ");
                    SceneErrorKind::Invalid(format!("no parameter \"{name}\"; there are {known}"))
                }
            };
            return Err(SceneError::in_file(path, kind));
        }
        Ok(())
    }
}
