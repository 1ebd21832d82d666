//! `[render]`: how to make the picture.

use super::keys;
use super::said::{self, Group, Said, number, numbers};
use super::table::{Table, Value};
use crate::error::{SceneError, SceneErrorKind};
use rutilant::display::{Curve, Display};
use rutilant::film::Filter;
use rutilant::settings::{
    Crop, Heuristic, IntegratorKind, Layer, Layers, LightSelection, Roulette, SamplerKind,
    Settings, Strategy,
};

const INTEGRATORS: &[(&str, IntegratorKind)] = &[
    ("path", IntegratorKind::Path),
    ("naive", IntegratorKind::Naive),
    ("direct", IntegratorKind::Direct),
    ("ao", IntegratorKind::AmbientOcclusion),
    ("normals", IntegratorKind::Normals),
    ("albedo", IntegratorKind::Albedo),
    ("depth", IntegratorKind::Depth),
];
const SAMPLERS: &[(&str, SamplerKind)] =
    &[("sobol", SamplerKind::Sobol), ("independent", SamplerKind::Independent)];
const STRATEGIES: &[(&str, Strategy)] =
    &[("both", Strategy::Both), ("light", Strategy::LightOnly), ("bsdf", Strategy::BsdfOnly)];
const HEURISTICS: &[(&str, Heuristic)] = &[
    ("power", Heuristic::Power),
    ("balance", Heuristic::Balance),
    ("optimal", Heuristic::Optimal),
];
const ROULETTES: &[(&str, Roulette)] =
    &[("throughput", Roulette::Throughput), ("albedo", Roulette::Albedo), ("off", Roulette::Off)];
const LIGHT_SELECTIONS: &[(&str, LightSelection)] = &[
    ("auto", LightSelection::Auto),
    ("tree", LightSelection::Tree),
    ("power", LightSelection::Power),
    ("uniform", LightSelection::Uniform),
];
const CURVES: &[(&str, Curve)] = &[
    ("clip", Curve::Clip),
    ("filmic", Curve::Filmic),
    ("reinhard", Curve::Reinhard),
    ("aces", Curve::Aces),
    ("agx", Curve::Agx),
];
/// Each with its usual width.
const FILTERS: &[(&str, Filter)] = &[
    ("box", Filter::Box { radius: 0.5 }),
    ("tent", Filter::Tent { radius: 1.0 }),
    ("gaussian", Filter::Gaussian { radius: 1.5, sigma: 0.5 }),
    ("mitchell", Filter::Mitchell { radius: 2.0, b: 1.0 / 3.0, c: 1.0 / 3.0 }),
    ("blackman-harris", Filter::BlackmanHarris { radius: 1.5 }),
];

/// A scene may not ask for more than `allowed` pixels.
pub(super) fn check_size(
    table: &Table<'_>,
    [width, height]: [u32; 2],
    allowed: u64,
) -> Result<(), SceneError> {
    let asked = u64::from(width) * u64::from(height);
    let kind = || SceneErrorKind::Limit { what: "pixels of the picture", asked, allowed };
    table.maybe("size", |v| if asked > allowed { Err(v.error(kind())) } else { Ok(()) })?;
    Ok(())
}

pub(super) fn read(table: &Table<'_>) -> Result<(Settings, Display), SceneError> {
    table.only(&[keys::RENDER])?;
    let usual = Settings::default();
    let settings = Settings {
        size: table.or("size", |v| v.wholes("two whole numbers [width, height]"), usual.size)?,
        crop: table.maybe("crop", crop)?,
        spp: table.or("spp", Value::whole, usual.spp)?,
        planned_spp: None,
        max_depth: table.maybe("max_depth", Value::whole)?,
        integrator: table.or(
            "integrator",
            |v| v.one_of("integrator", INTEGRATORS),
            usual.integrator,
        )?,
        sampler: table.or("sampler", |v| v.one_of("sampler", SAMPLERS), usual.sampler)?,
        seed: table.or("seed", Value::whole, usual.seed)?,
        filter: filter(table)?,
        strategy: table.or("strategy", |v| v.one_of("strategy", STRATEGIES), usual.strategy)?,
        heuristic: table.or("heuristic", |v| v.one_of("heuristic", HEURISTICS), usual.heuristic)?,
        roulette: table.or("roulette", |v| v.one_of("roulette", ROULETTES), usual.roulette)?,
        light_selection: table.or(
            "light_selection",
            |v| v.one_of("light selection", LIGHT_SELECTIONS),
            usual.light_selection,
        )?,
        caustics: table.or("caustics", Value::flag, usual.caustics)?,
        layers: table.or("layers", layers, usual.layers)?,
    };
    let display = Display {
        exposure: table.or("exposure", Value::number, 0.0)?,
        curve: table.or("curve", |v| v.one_of("curve", CURVES), Curve::default())?,
    };
    Ok((settings, display))
}

fn crop(value: &Value<'_>) -> Result<Crop, SceneError> {
    let [x, y, width, height] = value.wholes("four whole numbers [x, y, width, height]")?;
    Ok(Crop { x, y, width, height })
}

fn layers(value: &Value<'_>) -> Result<Layers, SceneError> {
    let names = value.entries("names of layers [\"albedo\", \"normal\", ..]")?;
    names.map(|name| name.one_of("layer", &Layer::ALL)).collect()
}

fn filter(table: &Table<'_>) -> Result<Filter, SceneError> {
    let mut filter = table.or("filter", |v| v.one_of("filter", FILTERS), Filter::default())?;
    if let Some(given) = table.maybe("filter_radius", Value::number)? {
        match &mut filter {
            Filter::Box { radius }
            | Filter::Tent { radius }
            | Filter::Gaussian { radius, .. }
            | Filter::Mitchell { radius, .. }
            | Filter::BlackmanHarris { radius } => *radius = given,
        }
    }
    if let Some(value) = table.get("filter_sigma") {
        let Filter::Gaussian { sigma, .. } = &mut filter else {
            return Err(value.invalid("filter_sigma is for filter = \"gaussian\" only"));
        };
        *sigma = value.number()?;
    }
    if let Some(value) = table.get("filter_bc") {
        let Filter::Mitchell { b, c, .. } = &mut filter else {
            return Err(value.invalid("filter_bc is for filter = \"mitchell\" only"));
        };
        [*b, *c] = value.numbers("two numbers [B, C]")?;
    }
    Ok(filter)
}

/// The keys that say all of a rendering.
pub(super) fn keys_of(settings: &Settings, display: &Display) -> Vec<Group> {
    let usual = Settings::default();
    let name = |key, text: String, usual: String| Group::or(key, text, &usual);
    let crop = settings.crop.map(|c| numbers([c.x, c.y, c.width, c.height]));
    vec![
        Group::or(&["size"], numbers(settings.size), &numbers(usual.size)),
        Group::maybe(&["crop"], crop),
        Group::or(&["spp"], settings.spp.to_string(), &usual.spp.to_string()),
        Group::maybe(&["max_depth"], settings.max_depth.map(|depth| depth.to_string())),
        name(
            &["integrator"],
            said::name(INTEGRATORS, &settings.integrator),
            said::name(INTEGRATORS, &usual.integrator),
        ),
        name(
            &["sampler"],
            said::name(SAMPLERS, &settings.sampler),
            said::name(SAMPLERS, &usual.sampler),
        ),
        Group::or(&["seed"], settings.seed.to_string(), &usual.seed.to_string()),
        keys_of_filter(&settings.filter),
        name(
            &["strategy"],
            said::name(STRATEGIES, &settings.strategy),
            said::name(STRATEGIES, &usual.strategy),
        ),
        name(
            &["heuristic"],
            said::name(HEURISTICS, &settings.heuristic),
            said::name(HEURISTICS, &usual.heuristic),
        ),
        name(
            &["roulette"],
            said::name(ROULETTES, &settings.roulette),
            said::name(ROULETTES, &usual.roulette),
        ),
        name(
            &["light_selection"],
            said::name(LIGHT_SELECTIONS, &settings.light_selection),
            said::name(LIGHT_SELECTIONS, &usual.light_selection),
        ),
        Group::or(&["caustics"], settings.caustics.to_string(), &usual.caustics.to_string()),
        Group::or(&["layers"], names_of(settings.layers), &names_of(usual.layers)),
        Group::or(&["exposure"], number(display.exposure), "0"),
        name(&["curve"], said::name(CURVES, &display.curve), said::name(CURVES, &Curve::default())),
    ]
}

fn names_of(layers: Layers) -> String {
    let names: Vec<_> = layers.names().map(said::text).collect();
    format!("[{}]", names.join(", "))
}

fn keys_of_filter(filter: &Filter) -> Group {
    let kind = |filter: &Filter| std::mem::discriminant(filter);
    let listed = FILTERS.iter().find(|(_, listed)| kind(listed) == kind(filter));
    let (name, usual) = listed.copied().unwrap_or(("", Filter::default()));
    let default = FILTERS.iter().find(|(_, listed)| kind(listed) == kind(&Filter::default()));
    let default = default.map_or("", |(name, _)| name);
    let says = |filter: &Filter| match *filter {
        Filter::Box { radius } | Filter::Tent { radius } | Filter::BlackmanHarris { radius } => {
            vec![("filter_radius", number(radius))]
        }
        Filter::Gaussian { radius, sigma } => {
            vec![("filter_radius", number(radius)), ("filter_sigma", number(sigma))]
        }
        Filter::Mitchell { radius, b, c } => {
            vec![("filter_radius", number(radius)), ("filter_bc", numbers([b, c].map(number)))]
        }
    };
    let mut all = vec![Said::or("filter", said::text(name), &said::text(default))];
    let usual = says(&usual).into_iter().map(|(_, value)| value);
    all.extend(
        says(filter).into_iter().zip(usual).map(|((key, v), usual)| Said::or(key, v, &usual)),
    );
    Group::of(&["filter", "filter_radius", "filter_sigma", "filter_bc"], all)
}
