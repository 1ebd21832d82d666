//! What can be wrong with a scene, and the ranges that its numbers must keep to.

use std::fmt;
use std::ops::RangeInclusive;

/// Why a scene cannot be rendered, and which of its parts is to blame.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{place}: {what}")]
pub struct SceneProblem {
    /// The part of the scene.
    pub place: Place,
    /// The property of that part, by the name of its key in the native scene format.
    pub key: &'static str,
    /// What is wrong, what would be right.
    pub what: String,
}

/// What a person should know about a scene that is rendered all the same.
#[derive(Clone, Debug, PartialEq)]
pub struct Note {
    /// The part of the scene, if it is about one.
    pub place: Option<Place>,
    /// What was mended, or is lost.
    pub what: String,
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.place {
            Some(place) => write!(f, "{place}: {}", self.what),
            None => write!(f, "{}", self.what),
        }
    }
}

impl From<String> for Note {
    fn from(what: String) -> Self {
        Self { place: None, what }
    }
}

/// A part of a scene. The numbers count in the arrays of [`Scene`](crate::scene::Scene).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "each is named after the part it means")]
pub enum Place {
    Settings,
    Camera,
    Environment,
    Texture(usize),
    Material(usize),
    Mesh(usize),
    Object(usize),
    Light(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Settings => write!(f, "render settings"),
            Self::Camera => write!(f, "camera"),
            Self::Environment => write!(f, "environment"),
            Self::Texture(i) => write!(f, "texture {i}"),
            Self::Material(i) => write!(f, "material {i}"),
            Self::Mesh(i) => write!(f, "mesh {i}"),
            Self::Object(i) => write!(f, "object {i}"),
            Self::Light(i) => write!(f, "light {i}"),
        }
    }
}

impl Place {
    /// A problem here: `what` is wrong with `key`.
    pub(crate) fn problem(self, key: &'static str, what: impl Into<String>) -> SceneProblem {
        SceneProblem { place: self, key, what: what.into() }
    }

    /// A note about this.
    pub(crate) fn note(self, what: impl Into<String>) -> Note {
        Note { place: Some(self), what: what.into() }
    }

    /// Checks that every number lies in `range`, which NaN never does.
    pub(crate) fn check(
        self,
        key: &'static str,
        values: impl IntoIterator<Item = f32>,
        range: RangeInclusive<f32>,
    ) -> Result<(), SceneProblem> {
        let Some(wrong) = values.into_iter().find(|v| !range.contains(v)) else { return Ok(()) };
        let (least, most) = (*range.start(), *range.end());
        let [v, from, to] = [wrong, least, most].map(number);
        let must = match (least == f32::MIN_POSITIVE, most == f32::MAX) {
            _ if !wrong.is_finite() => "be a finite number".to_owned(),
            (true, _) if wrong > 0.0 && wrong < least => format!("be at least {from}"),
            (true, true) => "be more than 0".to_owned(),
            (true, false) => format!("be more than 0, up to {to}"),
            (false, true) => format!("be {from} or more"),
            (false, false) => format!("lie between {from} and {to}"),
        };
        Err(self.problem(key, format!("{key} is {v}, but must {must}")))
    }
}

/// A number for people: with an exponent where it would be all zeros without.
pub(crate) fn number(v: f32) -> String {
    let plain = v == 0.0 || !v.is_finite() || (1e-5..1e7).contains(&v.abs());
    if plain { v.to_string() } else { format!("{v:e}") }
}

/// Any finite number.
pub(crate) const FINITE: RangeInclusive<f32> = f32::MIN..=f32::MAX;
/// Zero or more.
pub(crate) const NOT_NEGATIVE: RangeInclusive<f32> = 0.0..=f32::MAX;
/// The most light that a scene may ask for, whatever its unit. What is computed from it stays a
/// finite number, its square among them, of which variances are made.
pub const MOST_LIGHT: f32 = 1e18;
/// The most light groups that a scene may have: each takes room in every pixel.
pub const MOST_GROUPS: usize = 64;
/// An amount of light.
pub(crate) const LIGHT: RangeInclusive<f32> = 0.0..=MOST_LIGHT;
/// More than zero.
pub(crate) const POSITIVE: RangeInclusive<f32> = f32::MIN_POSITIVE..=f32::MAX;
/// A part of a whole.
pub(crate) const UNIT: RangeInclusive<f32> = 0.0..=1.0;
