//! The film, and how it is exposed: size, crop, brightness, filter, samples, length of paths.
//!
//! pbrt multiplies what its sensor measures; here all lights are brighter instead, so that pictures
//! agree. Source: Pharr, Jakob, Humphreys, *Physically Based Rendering*, 4th ed., section 5.4.2, and
//! *pbrt-v4 input file format*: "Film", "Filters", "Samplers", "Integrators".

use super::description::{Description, Named};
use super::lexer::{Place, Texts};
use super::parameters::Parameters;
use crate::error::{SceneError, SceneErrorKind};
use crate::options::ReadOptions;
use crate::scene::framing::rescaled;
use crate::scene::notes::Notes;
use crate::shown::shown;
use rutilant::film::Filter;
use rutilant::settings::{Crop, IntegratorKind, SamplerKind, Settings};

/// What is known of the film.
pub(super) struct Film {
    /// Width and height of what is asked for, before any crop: by the caller, or else by the scene.
    pub(super) size: [u32; 2],
    /// The part of it that is rendered.
    pub(super) crop: Option<Crop>,
    /// What all light is multiplied by.
    pub(super) exposure: f32,
}

impl Film {
    /// The film of a scene.
    pub(super) fn read(
        description: &Description,
        texts: &Texts,
        notes: &mut Notes,
        options: &ReadOptions<'_>,
    ) -> Result<Self, SceneError> {
        let usual = if description.is_old { [640, 480] } else { [1280, 720] };
        // How long the shutter is open is said by the camera.
        let mut open = 1.0;
        if let Some(camera) = &description.camera {
            let at = |name: &str, usual| camera.parameters.number_or(name, usual, texts);
            let (from, to) = (at("shutteropen", 0.0)?, at("shutterclose", 1.0)?);
            if !description.is_old {
                open = to - from;
                if open.is_nan() || open <= 0.0 {
                    let what = format!(
                        "the shutter opens at {from} and closes at {to}: it must be open for a while"
                    );
                    return Err(texts.invalid(camera.parameters.place, what));
                }
            }
        }
        let Some(Named { name, parameters }) = &description.film else {
            return Ok(Self { size: options.size.unwrap_or(usual), crop: None, exposure: open });
        };
        let place = parameters.place;
        if !matches!(&**name, "rgb" | "image" | "gbuffer" | "spectral") {
            let what = format!("Film \"{}\" is taken as \"rgb\"", shown(name));
            notes.say(texts, place, what);
        }
        let mut size = usual;
        for (name, side) in ["xresolution", "yresolution"].into_iter().zip(&mut size) {
            if let Some(asked) = parameters.whole(name, texts)? {
                let most = Settings::MAX_SIDE;
                *side = u32::try_from(asked).ok().filter(|s| (1..=most).contains(s)).ok_or_else(
                    || {
                        texts.invalid(
                            parameters.place_of(name),
                            format!("{name} is {asked}, but must lie between 1 and {most}"),
                        )
                    },
                )?;
            }
        }
        // What the caller asks for has the film's shape, as if the scene had said it.
        let own = size;
        size = options.size.unwrap_or(own);
        let crop = crop(parameters, size, own, texts)?;
        let mut exposure = open;
        let iso = parameters.number_or("iso", 100.0, texts)?;
        exposure *= iso / 100.0;
        // Older ways to say the same.
        exposure *= parameters.number_or("exposuretime", 1.0, texts)?;
        exposure *= parameters.number_or("scale", 1.0, texts)?;
        if !(exposure >= 0.0 && exposure.is_finite()) {
            let what = format!("the film is exposed {exposure} times, but that must be 0 or more");
            return Err(texts.invalid(place, what));
        }
        if let Some(sensor) = parameters.text("sensor", texts)?.filter(|name| *name != "cie1931") {
            let what = format!("sensor \"{}\" sees as the eye does, \"cie1931\"", shown(sensor));
            notes.say(texts, place, what);
        }
        if parameters.number_or("whitebalance", 0.0, texts)? != 0.0 {
            notes.say(texts, place, "the white balance of the film is left out");
        }
        if parameters.number("maxcomponentvalue", texts)?.is_some_and(f32::is_finite) {
            notes.say(
                texts,
                place,
                "\"maxcomponentvalue\" is left out: bright samples are not cut",
            );
        }
        parameters.ignore(&[
            "filename",
            "diagonal",
            "savefp16",
            "coordinatesystem",
            "nbuckets",
            "lambdamin",
            "lambdamax",
            "display",
        ]);
        parameters.tell_unused(texts, notes);
        let (asked, allowed) = (u64::from(size[0]) * u64::from(size[1]), options.limits.picture);
        if asked > allowed && options.size.is_none() {
            let kind = SceneErrorKind::Limit { what: "pixels of the picture", asked, allowed };
            return Err(texts.error(place, kind));
        }
        Ok(Self { size, crop, exposure })
    }
}

/// The part of the film that is rendered; `own` is the size that the scene's numbers are for.
fn crop(
    parameters: &Parameters,
    [width, height]: [u32; 2],
    own: [u32; 2],
    texts: &Texts,
) -> Result<Option<Crop>, SceneError> {
    let pixels = match (parameters.get("pixelbounds"), parameters.some::<4>("cropwindow", texts)?) {
        (Some(_), _) => {
            let bounds = parameters.wholes("pixelbounds", texts)?.unwrap_or_default();
            match *bounds {
                [x0, x1, y0, y1] => {
                    let at = |pixel: i32, i: usize| {
                        rescaled(pixel.max(0) as u32, own[i], [width, height][i])
                    };
                    [at(x0, 0), at(x1, 0), at(y0, 1), at(y1, 1)]
                }
                _ => {
                    let what = "\"pixelbounds\" must be 4 whole numbers";
                    return Err(texts.invalid(parameters.place_of("pixelbounds"), what));
                }
            }
        }
        (None, Some([x0, x1, y0, y1])) => {
            let at = |part: f32, side: u32| (part.clamp(0.0, 1.0) * side as f32).ceil() as u32;
            [at(x0, width), at(x1, width), at(y0, height), at(y1, height)]
        }
        (None, None) => return Ok(None),
    };
    let [x0, x1, y0, y1] = pixels;
    let (x0, x1) = (x0.min(x1), x0.max(x1).min(width));
    let (y0, y1) = (y0.min(y1), y0.max(y1).min(height));
    if x0 >= x1 || y0 >= y1 {
        return Err(
            texts.invalid(parameters.place, "the part of the film that is cut out has no pixels")
        );
    }
    let crop = Crop { x: x0, y: y0, width: x1 - x0, height: y1 - y0 };
    Ok((crop != Crop { x: 0, y: 0, width, height }).then_some(crop))
}

/// How to render, but for the film.
pub(super) fn settings(
    description: &Description,
    texts: &Texts,
    notes: &mut Notes,
) -> Result<Settings, SceneError> {
    let mut settings =
        Settings { filter: filter(description, texts, notes)?, ..Settings::default() };
    let place = |named: &Named| named.parameters.place;

    // Samples for each pixel.
    settings.spp = 16;
    if let Some(Named { name, parameters }) = &description.sampler {
        let count = |name: &str| parameters.whole(name, texts);
        let asked = match (count("xsamples")?, count("ysamples")?) {
            (None, None) => count("pixelsamples")?.map(i64::from),
            (x, y) => Some(i64::from(x.unwrap_or(4)) * i64::from(y.unwrap_or(4))),
        };
        if let Some(asked) = asked {
            settings.spp = u64::try_from(asked).ok().filter(|spp| *spp > 0).ok_or_else(|| {
                let place = parameters.place_of("pixelsamples");
                texts.invalid(place, format!("{asked} samples for each pixel are too few"))
            })?;
        }
        if matches!(&**name, "independent" | "random") {
            settings.sampler = SamplerKind::Independent;
        }
        if let Some(seed) = count("seed")? {
            settings.seed = seed.max(0) as u64;
        }
        parameters.ignore(&["randomization", "jitter", "scramble", "dimensions"]);
        parameters.tell_unused(texts, notes);
    }

    // How long paths are. pbrt counts what scatters, not the ways between.
    settings.max_depth = Some(6);
    if let Some(integrator @ Named { name, parameters }) = &description.integrator {
        if let Some(depth) = parameters.whole("maxdepth", texts)? {
            settings.max_depth = match u32::try_from(depth) {
                Ok(depth) => Some(depth.saturating_add(1)),
                Err(_) => {
                    let what = format!("maxdepth is {depth}, but must be 0 or more");
                    return Err(texts.invalid(parameters.place_of("maxdepth"), what));
                }
            };
        }
        match &**name {
            "path" | "volpath" => {}
            "ao" | "ambientocclusion" => settings.integrator = IntegratorKind::AmbientOcclusion,
            "directlighting" => settings.max_depth = settings.max_depth.map(|depth| depth.min(2)),
            other => {
                let what = format!(
                    "paths are traced where the scene asks for Integrator \"{}\"",
                    shown(other)
                );
                notes.say(texts, place(integrator), what);
            }
        }
        parameters.ignore(&[
            "rrthreshold",
            "lightsampler",
            "lightsamplestrategy",
            "regularize",
            "strategy",
        ]);
        if !matches!(&**name, "path" | "volpath") {
            parameters.ignore(&[
                "cossample",
                "numiterations",
                "iterations",
                "photonsperiteration",
                "radius",
                "bootstrapsamples",
                "chains",
                "mutationsperpixel",
                "largestepprobability",
                "sigma",
                "visualizestrategies",
                "visualizeweights",
                "samplebsdf",
                "samplelights",
                "nsamples",
                "imagewritefrequency",
            ]);
        }
        parameters.tell_unused(texts, notes);
    }
    Ok(settings)
}

fn filter(
    description: &Description,
    texts: &Texts,
    notes: &mut Notes,
) -> Result<Filter, SceneError> {
    let none = Parameters::none("PixelFilter", Place { text: 0, at: 0, line: 1 });
    let (name, parameters) = match &description.filter {
        Some(Named { name, parameters }) => (&**name, parameters),
        None if description.is_old => ("box", &none),
        None => ("gaussian", &none),
    };
    let number = |name: &str, usual| parameters.number_or(name, usual, texts);
    let mut uneven = false;
    let mut radius = |usual: f32| -> Result<f32, SceneError> {
        let older = [number("xwidth", usual)?, number("ywidth", usual)?];
        let [x, y] = [number("xradius", older[0])?, number("yradius", older[1])?];
        uneven = x != y;
        Ok((0.5 * (x + y)).clamp(0.01, 16.0))
    };
    let filter = match name {
        "box" => Filter::Box { radius: radius(0.5)? },
        "triangle" => Filter::Tent { radius: radius(2.0)? },
        "gaussian" => {
            let radius = radius(if description.is_old { 2.0 } else { 1.5 })?;
            let sigma = match parameters.number("alpha", texts)? {
                // exp(−α x²) is a Gaussian of σ = 1 / √(2 α).
                Some(alpha) if alpha > 0.0 => 1.0 / (2.0 * alpha).sqrt(),
                Some(_) | None => number("sigma", 0.5)?,
            };
            Filter::Gaussian { radius, sigma: sigma.clamp(0.01, 16.0) }
        }
        "mitchell" => {
            let third = 1.0 / 3.0;
            let [b, c] = [number("B", third)?, number("C", third)?].map(|v| v.clamp(0.0, 1.0));
            Filter::Mitchell { radius: radius(2.0)?, b, c }
        }
        other => {
            let what = format!(
                "PixelFilter \"{}\" is not there: a smooth one of radius 1.5 stands in",
                shown(other)
            );
            notes.say(texts, parameters.place, what);
            parameters.ignore(&["tau", "xradius", "yradius", "xwidth", "ywidth"]);
            Filter::BlackmanHarris { radius: 1.5 }
        }
    };
    if uneven {
        notes.say(texts, parameters.place, "the filter is as wide as high: the mean of both");
    }
    parameters.tell_unused(texts, notes);
    Ok(filter)
}
