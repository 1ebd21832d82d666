//! What properties say: numbers, words, points, colours, transforms.

use super::xml::Wrong;
use crate::error::SceneErrorKind;
use crate::scene::affine::Affine;
use crate::scene::nearest::nearest;
use crate::scene::spectrum::Sampled;
use crate::shown::shown;
use rutilant::color::Rgb;
use rutilant::display::linear_from_srgb;
use rutilant_geom::DVec3;

/// The value of a property.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    Float(f64),
    Integer(i64),
    Boolean(bool),
    Text(String),
    Vector([f64; 3]),
    Color(Color),
    Transform(Affine),
}

/// A colour, or a spectrum.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Color {
    /// Linear red, green and blue.
    Rgb(Rgb),
    /// The same at every wavelength.
    Even(f32),
    Sampled(Sampled),
    /// The name of a file of samples.
    File(String),
    /// The light of a body of so many kelvin, and a factor on it.
    BlackBody(f32, f32),
}

/// An attribute of an element.
pub(super) struct Word {
    pub(super) name: String,
    pub(super) value: String,
    /// The byte at which its value begins.
    pub(super) at: usize,
}

/// The tags of properties.
pub(super) const TAGS: &[&str] = &[
    "float",
    "integer",
    "boolean",
    "string",
    "vector",
    "point",
    "rgb",
    "srgb",
    "color",
    "spectrum",
    "blackbody",
    "transform",
];

impl Value {
    /// What it is, for people.
    pub(super) fn kind(&self) -> &'static str {
        match self {
            Self::Float(_) | Self::Integer(_) => "a number",
            Self::Boolean(_) => "true or false",
            Self::Text(_) => "a string",
            Self::Vector(_) => "a point or a vector",
            Self::Color(_) => "a colour",
            Self::Transform(_) => "a transform",
        }
    }
}

/// The value of a property, by its tag, its attributes, and the steps of a transform.
pub(super) fn read(
    tag: &str,
    at: usize,
    words: &[Word],
    steps: &[(&str, Vec<Word>, usize)],
) -> Result<Value, Wrong> {
    let words = Words { at, words };
    if let (true, Some((step, _, at))) = (tag != "transform", steps.first()) {
        let what = format!("<{}> cannot stand within <{tag}>", shown(step));
        return Err((*at, SceneErrorKind::Invalid(what)));
    }
    match tag {
        "float" => {
            words.known(&["name", "value"])?;
            let (text, at) = words.needed("value")?;
            number(text, at).map(Value::Float)
        }
        "integer" => {
            words.known(&["name", "value"])?;
            let (text, at) = words.needed("value")?;
            let whole = text.trim().parse::<i64>();
            whole.map(Value::Integer).map_err(|_| not(at, text, "a whole number"))
        }
        "boolean" => {
            words.known(&["name", "value"])?;
            let (text, at) = words.needed("value")?;
            match text.trim().to_ascii_lowercase().as_str() {
                "true" => Ok(Value::Boolean(true)),
                "false" => Ok(Value::Boolean(false)),
                _ => Err(not(at, text, "true or false")),
            }
        }
        "string" => {
            words.known(&["name", "value"])?;
            words.needed("value").map(|(text, _)| Value::Text(text.to_owned()))
        }
        "vector" | "point" => {
            words.known(&["name", "value", "x", "y", "z"])?;
            words.triple(0.0).map(|v| Value::Vector(v.to_array()))
        }
        "rgb" | "srgb" | "color" => {
            words.known(&["name", "value"])?;
            let (text, at) = words.needed("value")?;
            color(text, at, tag == "srgb").map(|rgb| Value::Color(Color::Rgb(rgb)))
        }
        "spectrum" => {
            words.known(&["name", "value", "filename", "intent"])?;
            words.spectrum().map(Value::Color)
        }
        "blackbody" => {
            words.known(&["name", "temperature", "scale"])?;
            let (text, at) = words.needed("temperature")?;
            // 0.6 allows a K behind it.
            let kelvin = number(text.trim().trim_end_matches(['K', 'k']), at)? as f32;
            let scale = match words.find("scale") {
                Some((text, at)) => number(text, at)? as f32,
                None => 1.0,
            };
            Ok(Value::Color(Color::BlackBody(kelvin, scale)))
        }
        _ => {
            words.known(&["name"])?;
            transform(steps).map(Value::Transform)
        }
    }
}

struct Words<'w> {
    at: usize,
    words: &'w [Word],
}

impl<'w> Words<'w> {
    fn find(&self, name: &str) -> Option<(&'w str, usize)> {
        let word = self.words.iter().find(|word| word.name == name)?;
        Some((&word.value, word.at))
    }

    fn needed(&self, name: &str) -> Result<(&'w str, usize), Wrong> {
        let missing = || (self.at, SceneErrorKind::Invalid(format!("{name} is missing")));
        self.find(name).ok_or_else(missing)
    }

    /// Other attributes must not be there.
    fn known(&self, names: &[&str]) -> Result<(), Wrong> {
        let Some(other) = self.words.iter().find(|word| !names.contains(&&*word.name)) else {
            return Ok(());
        };
        let closest = nearest(&other.name, names.iter().copied()).map(str::to_owned);
        let name = shown(&other.name);
        Err((other.at, SceneErrorKind::Unknown { what: "attribute", name, closest }))
    }

    /// Three numbers in `value`, or in `x`, `y` and `z`; those that are missing are `default`.
    fn triple(&self, default: f64) -> Result<DVec3, Wrong> {
        if let Some((text, at)) = self.find("value") {
            return triple(text, at);
        }
        let [x, y, z] = ["x", "y", "z"].map(|name| match self.find(name) {
            Some((text, at)) => number(text, at),
            None => Ok(default),
        });
        Ok(DVec3::new(x?, y?, z?))
    }

    fn spectrum(&self) -> Result<Color, Wrong> {
        if let Some((name, _)) = self.find("filename") {
            return Ok(Color::File(name.to_owned()));
        }
        let (text, at) = self.needed("value")?;
        if !text.contains(':') {
            let values = numbers(text, at)?;
            return match values[..] {
                [value] => Ok(Color::Even(value as f32)),
                // 0.6 has linear RGB here as well.
                [r, g, b] => Ok(Color::Rgb(Rgb([r, g, b].map(|c| c as f32)))),
                _ => Err(not(at, text, "one number, or pairs like 400:0.3, 500:0.5")),
            };
        }
        let mut points = Vec::new();
        for pair in split(text) {
            let (nm, value) =
                pair.split_once(':').ok_or_else(|| not(at, pair, "a pair like 400:0.3"))?;
            points.push((number(nm, at)? as f32, number(value, at)? as f32));
        }
        let ascend = || {
            let what = "its wavelengths do not ascend".to_owned();
            (at, SceneErrorKind::Invalid(what))
        };
        Sampled::new(points).map(Color::Sampled).ok_or_else(ascend)
    }
}

fn not(at: usize, text: &str, wanted: &str) -> Wrong {
    (at, SceneErrorKind::Invalid(format!("\"{}\" is not {wanted}", shown(text))))
}

/// A finite number, in single precision as well.
fn number(text: &str, at: usize) -> Result<f64, Wrong> {
    match text.trim().parse::<f64>() {
        Ok(number) if (number as f32).is_finite() => Ok(number),
        Ok(_) => Err(not(at, text, "a finite number, or too large for one")),
        Err(_) => Err(not(at, text, "a number")),
    }
}

/// Pieces between blanks and commas.
fn split(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| c.is_whitespace() || c == ',').filter(|piece| !piece.is_empty())
}

fn numbers(text: &str, at: usize) -> Result<Vec<f64>, Wrong> {
    split(text).map(|piece| number(piece, at)).collect()
}

fn triple(text: &str, at: usize) -> Result<DVec3, Wrong> {
    match numbers(text, at)?[..] {
        [x, y, z] => Ok(DVec3::new(x, y, z)),
        _ => Err(not(at, text, "three numbers")),
    }
}

/// Three numbers, one for all channels, or `#rrggbb`, which is encoded as sRGB.
fn color(text: &str, at: usize, encoded: bool) -> Result<Rgb, Wrong> {
    if let Some(digits) = text.trim().strip_prefix('#') {
        let value = u32::from_str_radix(digits, 16).ok().filter(|_| digits.len() == 6);
        let value = value.ok_or_else(|| not(at, text, "a colour like #ff8000"))?;
        let [_, r, g, b] = value.to_be_bytes();
        return Ok(Rgb([r, g, b].map(|code| linear_from_srgb(f64::from(code) / 255.0) as f32)));
    }
    let rgb = match numbers(text, at)?[..] {
        [r, g, b] => [r, g, b],
        [grey] => [grey; 3],
        _ => return Err(not(at, text, "one number or three")),
    };
    Ok(Rgb(rgb.map(|c| (if encoded { linear_from_srgb(c) } else { c }) as f32)))
}

fn transform(steps: &[(&str, Vec<Word>, usize)]) -> Result<Affine, Wrong> {
    let mut all = Affine::IDENTITY;
    for (tag, words, at) in steps {
        let words = Words { at: *at, words };
        let none = |what: &str| (*at, SceneErrorKind::Invalid(what.to_owned()));
        let step = match *tag {
            "translate" => {
                words.known(&["value", "x", "y", "z"])?;
                Affine::translate(words.triple(0.0)?)
            }
            "scale" => {
                words.known(&["value", "x", "y", "z"])?;
                match words.find("value").map(|(text, at)| (numbers(text, at), text, at)) {
                    Some((Ok(factors), text, at)) => match factors[..] {
                        [all] => Affine::scale(DVec3::splat(all)),
                        [x, y, z] => Affine::scale(DVec3::new(x, y, z)),
                        _ => return Err(not(at, text, "one number or three")),
                    },
                    Some((Err(wrong), _, _)) => return Err(wrong),
                    None => Affine::scale(words.triple(1.0)?),
                }
            }
            "rotate" => {
                words.known(&["value", "x", "y", "z", "angle"])?;
                let (angle, at) = words.needed("angle")?;
                let degrees = number(angle, at)?;
                let turned = Affine::rotate(degrees as f32, words.triple(0.0)?);
                turned.ok_or_else(|| none("the axis to turn around has no length"))?
            }
            "lookat" | "lookAt" => {
                words.known(&["origin", "target", "up"])?;
                let [origin, target] = ["origin", "target"].map(|name| {
                    let (text, at) = words.needed(name)?;
                    triple(text, at)
                });
                let up = words.find("up").map(|(text, at)| triple(text, at)).transpose()?;
                look_at(origin?, target?, up).map_err(none)?
            }
            "matrix" => {
                words.known(&["value"])?;
                let (text, at) = words.needed("value")?;
                matrix(text, at)?
            }
            _ => {
                let known = ["translate", "scale", "rotate", "lookat", "matrix"];
                let closest = nearest(tag, known).map(str::to_owned);
                let name = shown(tag);
                return Err((*at, SceneErrorKind::Unknown { what: "transform", name, closest }));
            }
        };
        all = step * all;
        if all.to_transform().is_none() {
            return Err(none("up to here numbers grow beyond all bounds"));
        }
    }
    Ok(all)
}

/// A camera at `origin` that looks at `target`, with its x to the left, or why there is none. Where
/// `up` is missing or nought, another is chosen.
fn look_at(origin: DVec3, target: DVec3, up: Option<DVec3>) -> Result<Affine, &'static str> {
    let Some(ahead) = (target - origin).try_normalize() else {
        return Err("origin and target are the same point");
    };
    let up = up.filter(|up| *up != DVec3::ZERO).unwrap_or_else(|| ahead.any_orthonormal_vector());
    Affine::look_at(origin, target, up).ok_or("up is parallel to the view")
}

/// Sixteen numbers row by row, or the nine of the linear part.
fn matrix(text: &str, at: usize) -> Result<Affine, Wrong> {
    let all = numbers(text, at)?;
    let width = match all.len() {
        16 => 4,
        9 => 3,
        _ => return Err(not(at, text, "a matrix: 16 numbers, or 9")),
    };
    let column = |j: usize| DVec3::new(all[j], all[width + j], all[2 * width + j]);
    let columns = [column(0), column(1), column(2)];
    if width == 4 && all[12..] != [0.0, 0.0, 0.0, 1.0] {
        let what = "the last row of a matrix must be 0 0 0 1: others would be a projection";
        return Err((at, SceneErrorKind::Unsupported(what.to_owned())));
    }
    let translation = if width == 4 { column(3) } else { DVec3::ZERO };
    Ok(Affine { linear: columns, translation })
}
