//! Colours, light and indices of refraction as parameters tell them.
//!
//! Source: Pharr, Jakob, Humphreys, *pbrt-v4 input file format*, pbrt.org/fileformat-v4: "Spectra".

use super::lexer::Texts;
use super::parameters::{Parameter, Parameters, Values};
use crate::error::SceneError;
use crate::file;
use crate::limits::Limits;
use crate::scene::files::Files;
use crate::scene::nearest::nearest;
use crate::scene::spectrum::{self, Clear, METALS, Sampled};
use crate::shown::shown;
use rutilant::color::Rgb;

/// A spectrum in its author's words.
#[derive(Clone, Debug)]
pub(super) enum Told {
    Rgb(Rgb),
    Sampled(Sampled),
    /// Real or imaginary part of the index of a metal.
    Metal(Rgb),
    Glass(Clear),
    /// With the luminance 1.
    Illuminant(Rgb),
    /// A body of a temperature in kelvin; in pbrt-v3 with a factor on light whose largest value is 1.
    Body {
        kelvin: f32,
        factor: Option<f32>,
    },
}

impl Told {
    /// As what a surface reflects.
    pub(super) fn reflectance(&self) -> Rgb {
        match self {
            Self::Rgb(rgb) | Self::Metal(rgb) | Self::Illuminant(rgb) => *rgb,
            Self::Sampled(sampled) => sampled.reflectance(),
            Self::Glass(glass) => Rgb::grey(glass.ior),
            Self::Body { .. } => self.light(false),
        }
    }

    /// As light. pbrt-v4 brings each spectrum that is told by wavelengths to the luminance 1; before
    /// that they were taken as they are.
    pub(super) fn light(&self, as_before: bool) -> Rgb {
        match self {
            Self::Rgb(rgb) | Self::Metal(rgb) | Self::Illuminant(rgb) => *rgb,
            Self::Sampled(sampled) if as_before => sampled.light(),
            Self::Sampled(sampled) => spectrum::of_luminance_one(sampled.light()),
            Self::Glass(glass) => Rgb::grey(glass.ior),
            Self::Body { kelvin, factor: None } => spectrum::black_body(*kelvin),
            Self::Body { kelvin, factor: Some(factor) } => {
                if kelvin.is_nan() || *kelvin <= 0.0 {
                    return Rgb::BLACK;
                }
                let body = Sampled::black_body(kelvin.max(300.0));
                // Wien: the wavelength of the most, in nanometres.
                let most =
                    Sampled::black_body_at(2.897_771_955e6 / kelvin.max(300.0), kelvin.max(300.0));
                Rgb(body.light().0.map(|c| if most > 0.0 { c / most * factor } else { 0.0 }))
            }
        }
    }

    /// As numbers that are no colours.
    pub(super) fn numbers(&self) -> Rgb {
        match self {
            Self::Rgb(rgb) | Self::Metal(rgb) | Self::Illuminant(rgb) => *rgb,
            Self::Sampled(sampled) => sampled.clone().held().mean(),
            Self::Glass(glass) => Rgb::grey(glass.ior),
            Self::Body { .. } => self.light(false),
        }
    }
}

/// Where spectra are looked for.
#[derive(Clone, Copy)]
pub(super) struct Library<'a> {
    pub(super) texts: &'a Texts,
    pub(super) files: &'a Files<'a>,
    pub(super) limits: &'a Limits,
}

/// The spectrum of a parameter, `None` where it is a texture.
pub(super) fn told(
    parameters: &Parameters,
    parameter: &Parameter,
    library: Library<'_>,
) -> Result<Option<Told>, SceneError> {
    let texts = library.texts;
    let wrong = |must: &str| parameters.wrong(parameter, &parameter.values, must, texts);
    let told = match (&*parameter.kind, &parameter.values) {
        ("texture", _) => return Ok(None),
        ("blackbody", Values::Numbers(values)) => match values[..] {
            [kelvin] if kelvin.is_finite() => Told::Body { kelvin, factor: None },
            [kelvin, factor] if kelvin.is_finite() && factor.is_finite() => {
                Told::Body { kelvin, factor: Some(factor) }
            }
            _ => return Err(wrong("a temperature in kelvin")),
        },
        ("spectrum", Values::Texts(values)) => match &values[..] {
            [name] => named(name, parameter, library)?,
            _ => return Err(wrong("one name of a spectrum or a file")),
        },
        ("spectrum", Values::Numbers(values)) => {
            let (pairs, rest) = values.as_chunks::<2>();
            let pairs = pairs.iter().map(|&[nm, value]| (nm, value)).collect();
            let sampled = Sampled::new(pairs).filter(|_| rest.is_empty());
            Told::Sampled(
                sampled.ok_or_else(|| wrong("pairs of ascending wavelengths and values"))?,
            )
        }
        ("xyz", Values::Numbers(values)) => match values[..] {
            [x, y, z] if values.iter().all(|v| v.is_finite()) => {
                Told::Rgb(spectrum::rgb_from_xyz([x, y, z]))
            }
            _ => return Err(wrong("3 numbers")),
        },
        (_, Values::Numbers(values)) => match values[..] {
            [r, g, b] if values.iter().all(|v| v.is_finite()) => Told::Rgb(Rgb::new(r, g, b)),
            [grey] if grey.is_finite() => Told::Rgb(Rgb::grey(grey)),
            _ => return Err(wrong("3 numbers")),
        },
        (_, Values::Whole(values)) if values.len() == 1 => Told::Rgb(Rgb::grey(values[0] as f32)),
        (_, Values::Whole(_) | Values::Truths(_) | Values::Texts(_)) => {
            return Err(wrong("a colour or a spectrum"));
        }
    };
    Ok(Some(told))
}

/// A spectrum by its name, or in a file.
fn named(name: &str, parameter: &Parameter, library: Library<'_>) -> Result<Told, SceneError> {
    let texts = library.texts;
    let known = name.strip_prefix("metal-").and_then(|rest| {
        let (symbol, part) = rest.rsplit_once('-')?;
        let [eta, k] = spectrum::metal(symbol)?;
        match part {
            "eta" => Some(Told::Metal(eta)),
            "k" => Some(Told::Metal(k)),
            _ => None,
        }
    });
    let glass = |name: &str| {
        let name = match name {
            "F5" => "SF5",
            "F10" => "SF10",
            "F11" => "SF11",
            other => other,
        };
        spectrum::clear(name).map(Told::Glass)
    };
    let known = known
        .or_else(|| name.strip_prefix("glass-").and_then(glass))
        .or_else(|| spectrum::illuminant(name.strip_prefix("stdillum-")?).map(Told::Illuminant))
        .or_else(|| spectrum::illuminant(name.strip_prefix("illum-aces")?).map(Told::Illuminant));
    if let Some(told) = known {
        return Ok(told);
    }
    let found = library.files.find(name).map_err(|what| {
        let metals =
            METALS.map(|symbol| [format!("metal-{symbol}-eta"), format!("metal-{symbol}-k")]);
        let hint = nearest(name, metals.as_flattened().iter().map(String::as_str));
        let hint = hint.map(|name| format!("; did you mean \"{name}\"?")).unwrap_or_default();
        let name = shown(name);
        texts.invalid(parameter.place, format!("no spectrum \"{name}\" is known{hint}, and {what}"))
    })?;
    let bytes = file::scene_bytes(&found.path, library.limits)?;
    let sampled = Sampled::parse(&String::from_utf8_lossy(&bytes))
        .map_err(|what| SceneError::invalid_file(&found.path, what))?;
    Ok(Told::Sampled(sampled.held()))
}
