//! What statements change and others heed: the current transformation, material, light and media.

use super::lexer::Place;
use super::parameters::{Parameter, Parameters};
use crate::scene::affine::Affine;
use std::rc::Rc;

/// Which material a shape has.
#[derive(Clone, Debug)]
pub(super) enum Chosen {
    /// None was named: grey.
    Default,
    /// The one of a `Material` statement, by its number.
    Own(usize),
    /// The one of a name, among so many materials that had been named before.
    Named { name: Rc<str>, place: Place, before: usize },
}

/// All that a statement finds.
#[derive(Clone, Debug)]
pub(super) struct State {
    /// World from object; before `WorldBegin` camera from world.
    pub(super) map: Affine,
    /// Whether surfaces are turned inside out.
    pub(super) reversed: bool,
    pub(super) material: Chosen,
    /// What shapes glow with.
    pub(super) area_light: Option<Rc<AreaLight>>,
    /// What is inside of surfaces; nothing if empty.
    pub(super) inside: Rc<str>,
    /// What is outside of them.
    pub(super) outside: Rc<str>,
    /// What `Attribute` statements said, by target.
    pub(super) defaults: Rc<[Vec<Rc<Parameter>>; 5]>,
    /// Whether transformations count for the moment at which the shutter opens, the only one that
    /// is shown.
    pub(super) at_start: bool,
}

/// The statement of an area light.
#[derive(Debug)]
pub(super) struct AreaLight {
    /// Its number, by which materials that glow are told apart.
    pub(super) number: usize,
    pub(super) kind: String,
    pub(super) parameters: Parameters,
}

/// What `Attribute` may speak of, in the order of [`State::defaults`].
pub(super) const TARGETS: [&str; 5] = ["shape", "light", "material", "medium", "texture"];

impl Default for State {
    fn default() -> Self {
        Self {
            map: Affine::IDENTITY,
            reversed: false,
            material: Chosen::Default,
            area_light: None,
            inside: "".into(),
            outside: "".into(),
            defaults: Rc::default(),
            at_start: true,
        }
    }
}

/// What `…End` brings back.
pub(super) enum Saved {
    Attributes(Box<State>),
    Transform(Affine),
    /// An object has been described.
    Object(Box<State>),
}

impl Saved {
    /// What began it, for messages.
    pub(super) fn begun_by(&self) -> &'static str {
        match self {
            Self::Attributes(_) => "AttributeBegin",
            Self::Transform(_) => "TransformBegin",
            Self::Object(_) => "ObjectBegin",
        }
    }
}
