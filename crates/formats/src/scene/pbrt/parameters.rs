//! What statements are told in: `"float radius" [ 2 ]`, each with its type, its name and its place.

use super::lexer::{Kind, Lexer, Place, Texts, number, whole};
use crate::error::{SceneError, SceneErrorKind};
use crate::scene::notes::Notes;
use crate::shown::shown;
use std::cell::Cell;
use std::rc::Rc;

/// The values of a parameter.
#[derive(Clone, Debug)]
pub(super) enum Values {
    Whole(Vec<i32>),
    Numbers(Vec<f32>),
    Truths(Vec<bool>),
    Texts(Vec<String>),
}

/// A parameter of a statement.
#[derive(Clone, Debug)]
pub(super) struct Parameter {
    /// "float", "rgb", "texture" …
    pub(super) kind: String,
    pub(super) name: String,
    pub(super) values: Values,
    pub(super) place: Place,
    /// Whether anybody has asked for it.
    used: Cell<bool>,
}

/// The types there are, with what their values are.
const KINDS: [(&str, Form); 17] = [
    ("integer", Form::Whole),
    ("float", Form::Numbers),
    ("point", Form::Numbers),
    ("point2", Form::Numbers),
    ("point3", Form::Numbers),
    ("vector", Form::Numbers),
    ("vector2", Form::Numbers),
    ("vector3", Form::Numbers),
    ("normal", Form::Numbers),
    ("rgb", Form::Numbers),
    ("color", Form::Numbers),
    ("xyz", Form::Numbers),
    ("blackbody", Form::Numbers),
    ("spectrum", Form::Either),
    ("bool", Form::Truths),
    ("string", Form::Texts),
    ("texture", Form::Texts),
];

#[derive(Clone, Copy, PartialEq, Eq)]
enum Form {
    Whole,
    Numbers,
    Truths,
    Texts,
    /// Numbers or texts.
    Either,
}

/// All parameters of a statement.
#[derive(Clone, Debug)]
pub(super) struct Parameters {
    /// What they belong to, for messages: `Shape "sphere"`.
    pub(super) of: String,
    /// Where that stands.
    pub(super) place: Place,
    list: Vec<Rc<Parameter>>,
    /// How many textures and materials had been declared before.
    pub(super) before: Before,
}

/// How much has been declared before a statement: names mean the last thing of that name.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Before {
    pub(super) textures: usize,
    pub(super) materials: usize,
}

impl Parameters {
    /// None, for `of`.
    pub(super) fn none(of: impl Into<String>, place: Place) -> Self {
        Self { of: of.into(), place, list: Vec::new(), before: Before::default() }
    }

    /// All that follow in a text.
    pub(super) fn read(
        of: String,
        place: Place,
        lexer: &mut Lexer,
        texts: &Texts,
    ) -> Result<Self, SceneError> {
        let mut list = Vec::new();
        while let Some(token) = lexer.peek(texts)?.filter(|token| token.kind == Kind::Text) {
            lexer.take(texts)?;
            let declared = lexer.string(&token);
            let mut words = declared.split_ascii_whitespace();
            let (Some(kind), Some(name), None) = (words.next(), words.next(), words.next()) else {
                let what = format!(
                    "{} is no parameter: it must be a type and a name, as \"float radius\"",
                    lexer.shown(&token)
                );
                return Err(texts.invalid(token.place, what));
            };
            let Some((_, form)) = KINDS.into_iter().find(|(known, _)| *known == kind) else {
                let closest = crate::scene::nearest::nearest(kind, KINDS.map(|(known, _)| known));
                return Err(texts.error(
                    token.place,
                    SceneErrorKind::Unknown {
                        what: "type of parameters",
                        name: shown(kind),
                        closest: closest.map(str::to_owned),
                    },
                ));
            };
            let values = values(form, name, lexer, texts)?;
            let (kind, name) = (kind.to_owned(), name.to_owned());
            let used = Cell::new(false);
            list.push(Rc::new(Parameter { kind, name, values, place: token.place, used }));
        }
        Ok(Self { of, place, list, before: Before::default() })
    }

    /// Those of this list that stand in for what others do not say.
    pub(super) fn with_defaults(mut self, defaults: &[Rc<Parameter>]) -> Self {
        let missing: Vec<_> = defaults
            .iter()
            .filter(|default| self.list.iter().all(|own| own.name != default.name))
            .map(|default| {
                // What one statement has no use for another may have.
                default.used.set(true);
                Rc::clone(default)
            })
            .collect();
        self.list.extend(missing);
        self
    }

    /// All of them, to stand in for others.
    pub(super) fn into_list(self) -> Vec<Rc<Parameter>> {
        self.list
    }

    /// The one of a name.
    pub(super) fn get(&self, name: &str) -> Option<&Parameter> {
        let found = self.list.iter().find(|parameter| parameter.name == name)?;
        found.used.set(true);
        Some(found)
    }

    /// Where the one of a name stands; else where the statement does.
    pub(super) fn place_of(&self, name: &str) -> Place {
        self.get(name).map_or(self.place, |parameter| parameter.place)
    }

    /// Nobody need be told that these change nothing.
    pub(super) fn ignore(&self, names: &[&str]) {
        for name in names {
            self.get(name);
        }
    }

    /// Tells which of them nobody asked for.
    pub(super) fn tell_unused(&self, texts: &Texts, notes: &mut Notes) {
        for parameter in self.list.iter().filter(|parameter| !parameter.used.get()) {
            let what = format!("\"{}\" of {} is left out", shown(&parameter.name), self.of);
            notes.say(texts, parameter.place, what);
            parameter.used.set(true);
        }
    }

    /// The only number of a name.
    pub(super) fn number(&self, name: &str, texts: &Texts) -> Result<Option<f32>, SceneError> {
        let Some(parameter) = self.get(name) else { return Ok(None) };
        match &parameter.values {
            Values::Numbers(values) if values.len() == 1 => finite(values[0], parameter, texts),
            Values::Whole(values) if values.len() == 1 => Ok(Some(values[0] as f32)),
            other => Err(self.wrong(parameter, other, "one number", texts)),
        }
    }

    /// The only number of a name, or `default`.
    pub(super) fn number_or(
        &self,
        name: &str,
        default: f32,
        texts: &Texts,
    ) -> Result<f32, SceneError> {
        Ok(self.number(name, texts)?.unwrap_or(default))
    }

    /// The only whole number of a name.
    pub(super) fn whole(&self, name: &str, texts: &Texts) -> Result<Option<i32>, SceneError> {
        let Some(parameter) = self.get(name) else { return Ok(None) };
        match &parameter.values {
            Values::Whole(values) if values.len() == 1 => Ok(Some(values[0])),
            Values::Numbers(values) if values.len() == 1 && values[0].fract() == 0.0 => {
                Ok(Some(values[0] as i32))
            }
            other => Err(self.wrong(parameter, other, "one whole number", texts)),
        }
    }

    /// The only truth of a name, or `default`.
    pub(super) fn truth_or(
        &self,
        name: &str,
        default: bool,
        texts: &Texts,
    ) -> Result<bool, SceneError> {
        let Some(parameter) = self.get(name) else { return Ok(default) };
        match &parameter.values {
            Values::Truths(values) if values.len() == 1 => Ok(values[0]),
            other => Err(self.wrong(parameter, other, "true or false", texts)),
        }
    }

    /// The only text of a name.
    pub(super) fn text(&self, name: &str, texts: &Texts) -> Result<Option<&str>, SceneError> {
        let Some(parameter) = self.get(name) else { return Ok(None) };
        match &parameter.values {
            Values::Texts(values) if values.len() == 1 => Ok(Some(&values[0])),
            other => Err(self.wrong(parameter, other, "one text", texts)),
        }
    }

    /// All numbers of a name.
    pub(super) fn numbers(&self, name: &str, texts: &Texts) -> Result<Option<&[f32]>, SceneError> {
        let Some(parameter) = self.get(name) else { return Ok(None) };
        match &parameter.values {
            Values::Numbers(values) => Ok(Some(values)),
            other => Err(self.wrong(parameter, other, "numbers", texts)),
        }
    }

    /// All whole numbers of a name.
    pub(super) fn wholes(&self, name: &str, texts: &Texts) -> Result<Option<&[i32]>, SceneError> {
        let Some(parameter) = self.get(name) else { return Ok(None) };
        match &parameter.values {
            Values::Whole(values) => Ok(Some(values)),
            other => Err(self.wrong(parameter, other, "whole numbers", texts)),
        }
    }

    /// As many numbers of a name, all finite.
    pub(super) fn some<const N: usize>(
        &self,
        name: &str,
        texts: &Texts,
    ) -> Result<Option<[f32; N]>, SceneError> {
        let Some(parameter) = self.get(name) else { return Ok(None) };
        match &parameter.values {
            Values::Numbers(values) => match <[f32; N]>::try_from(&values[..]) {
                Ok(values) if values.iter().all(|v| v.is_finite()) => Ok(Some(values)),
                _ => Err(self.wrong(parameter, &parameter.values, &format!("{N} numbers"), texts)),
            },
            other => Err(self.wrong(parameter, other, &format!("{N} numbers"), texts)),
        }
    }

    /// A parameter has other values than it must.
    pub(super) fn wrong(
        &self,
        parameter: &Parameter,
        values: &Values,
        must: &str,
        texts: &Texts,
    ) -> SceneError {
        let has = match values {
            Values::Whole(v) if v.len() == 1 => "one whole number".to_owned(),
            Values::Whole(v) => format!("{} whole numbers", v.len()),
            Values::Numbers(v) if v.iter().any(|v| !v.is_finite()) => {
                "numbers that are not finite".to_owned()
            }
            Values::Numbers(v) if v.len() == 1 => "one number".to_owned(),
            Values::Numbers(v) => format!("{} numbers", v.len()),
            Values::Truths(v) if v.len() == 1 => "true or false".to_owned(),
            Values::Truths(v) => format!("{} truths", v.len()),
            Values::Texts(v) if v.len() == 1 => "one text".to_owned(),
            Values::Texts(v) => format!("{} texts", v.len()),
        };
        let name = shown(&parameter.name);
        texts.invalid(parameter.place, format!("\"{name}\" is {has}, but must be {must}"))
    }
}

fn finite(value: f32, of: &Parameter, texts: &Texts) -> Result<Option<f32>, SceneError> {
    if value.is_finite() {
        return Ok(Some(value));
    }
    let what = format!("\"{}\" is {value}, but must be finite", shown(&of.name));
    Err(texts.invalid(of.place, what))
}

/// What stands behind the declaration of a parameter: one value, or many in brackets.
fn values(form: Form, name: &str, lexer: &mut Lexer, texts: &Texts) -> Result<Values, SceneError> {
    let ends = |lexer: &Lexer| {
        let what = format!("the values of \"{}\" are missing", shown(name));
        texts.invalid(lexer.place(), what)
    };
    let Some(mut token) = lexer.take(texts)? else { return Err(ends(lexer)) };
    let many = token.kind == Kind::Open;
    let mut values = match form {
        Form::Whole => Values::Whole(Vec::new()),
        Form::Numbers => Values::Numbers(Vec::new()),
        Form::Truths => Values::Truths(Vec::new()),
        Form::Texts => Values::Texts(Vec::new()),
        Form::Either => {
            let first = if many { lexer.peek(texts)? } else { Some(token) };
            match first.map(|token| token.kind) {
                Some(Kind::Text) => Values::Texts(Vec::new()),
                Some(Kind::Word | Kind::Open | Kind::Close) | None => Values::Numbers(Vec::new()),
            }
        }
    };
    loop {
        if many {
            let Some(next) = lexer.take(texts)? else {
                let what = format!("there is no ] behind the values of \"{}\"", shown(name));
                return Err(texts.invalid(token.place, what));
            };
            if next.kind == Kind::Close {
                return Ok(values);
            }
            // The bracket is what is told of where the end is missing.
            if next.kind == Kind::Open {
                return Err(texts.invalid(next.place, "a [ within brackets"));
            }
            push(&mut values, &next, lexer, texts)?;
        } else {
            if matches!(token.kind, Kind::Close) {
                return Err(ends(lexer));
            }
            push(&mut values, &token, lexer, texts)?;
            return Ok(values);
        }
        token.kind = Kind::Open;
    }
}

fn push(
    values: &mut Values,
    token: &super::lexer::Token,
    lexer: &Lexer,
    texts: &Texts,
) -> Result<(), SceneError> {
    let letters = lexer.letters(token);
    let word = token.kind == Kind::Word;
    let pushed = match values {
        Values::Whole(list) => {
            let value = whole(letters).filter(|_| word).and_then(|v| i32::try_from(v).ok());
            value.map(|value| list.push(value)).ok_or("a whole number")
        }
        Values::Numbers(list) => {
            number(letters).filter(|_| word).map(|value| list.push(value)).ok_or("a number")
        }
        Values::Truths(list) => {
            let truth = match letters {
                b"true" => Some(true),
                b"false" => Some(false),
                _ => None,
            };
            truth.map(|truth| list.push(truth)).ok_or("true or false")
        }
        Values::Texts(list) => {
            (!word).then(|| list.push(lexer.string(token))).ok_or("a text between \"\"")
        }
    };
    pushed
        .map_err(|must| texts.invalid(token.place, format!("{} is not {must}", lexer.shown(token))))
}
