//! `[[light]]`: lights without a surface.

use super::draft::Draft;
use super::keys;
use super::light_group;
use super::said::{self, Group, Said, color, degrees, triple};
use super::table::{Table, Value};
use crate::error::SceneError;
use rutilant::light::{Light, SpotLight};
use rutilant::scene::Place;
use rutilant_geom::Vec3;

#[derive(Clone, Copy)]
enum Type {
    Point,
    Spot,
    Directional,
}

const TYPES: &[(&str, Type)] =
    &[("point", Type::Point), ("spot", Type::Spot), ("directional", Type::Directional)];

/// Half angles of a spot where none are given: those of glTF.
const OUTER_DEGREES: f32 = 45.0;
const INNER_DEGREES: f32 = 0.0;

pub(super) fn read<'d>(table: &Table<'d>, draft: &mut Draft<'d>) -> Result<(), SceneError> {
    let group = light_group::of(table)?;
    let light = match table.must("type", |v| v.one_of("light type", TYPES))? {
        Type::Point => {
            let table = table.named("a point light");
            table.only(&[keys::ANY_LIGHT, keys::POINT])?;
            Light::Point {
                position: table.must("position", Value::triple)?,
                intensity: table.must("intensity", Value::color)?,
                group,
            }
        }
        Type::Spot => {
            let table = table.named("a spot");
            table.only(&[keys::ANY_LIGHT, keys::SPOT])?;
            let position = table.must("position", Value::triple)?;
            let direction = match table.either(["direction", "look_at"])? {
                "look_at" => table.must("look_at", |value| match value.triple()? - position {
                    Vec3::ZERO => Err(value.invalid("look_at is where the light itself is")),
                    direction => Ok(direction),
                })?,
                _ => table.must("direction", Value::triple)?,
            };
            let light = match table.either(["intensity", "power"])? {
                "power" => SpotLight::Power(table.must("power", Value::color)?),
                _ => SpotLight::Intensity(table.must("intensity", Value::color)?),
            };
            let degrees = |key, default| table.or(key, Value::number, default);
            let outer = degrees("outer_degrees", OUTER_DEGREES)?.to_radians();
            let inner = degrees("inner_degrees", INNER_DEGREES)?.to_radians();
            Light::Spot { position, direction, light, inner, outer, group }
        }
        Type::Directional => {
            let table = table.named("a directional light");
            table.only(&[keys::ANY_LIGHT, keys::DIRECTIONAL])?;
            Light::Directional {
                direction: table.must("direction", Value::triple)?,
                irradiance: table.must("irradiance", Value::color)?,
                group,
            }
        }
    };
    draft.places.insert(Place::Light(draft.scene.lights.len()), *table);
    draft.scene.lights.push(light);
    Ok(())
}

/// The keys that say all of a light.
pub(super) fn keys_of(light: &Light) -> Vec<Group> {
    let kind = |name: &str| Group::one(&["type"], said::text(name));
    let mut groups = match *light {
        Light::Point { position, intensity, group: _ } => vec![
            kind("point"),
            Group::of(AIM, [Said::new("position", triple(position))]),
            Group::of(LIGHT, [Said::new("intensity", color(intensity))]),
        ],
        Light::Spot { position, direction, light, inner, outer, group: _ } => vec![
            kind("spot"),
            // What a spot looks at is a direction from where it is.
            Group::of(
                AIM,
                [
                    Said::new("position", triple(position)),
                    Said::new("direction", triple(direction)),
                ],
            ),
            Group::of(
                LIGHT,
                [match light {
                    SpotLight::Intensity(rgb) => Said::new("intensity", color(rgb)),
                    SpotLight::Power(rgb) => Said::new("power", color(rgb)),
                }],
            ),
            Group::or(&["outer_degrees"], degrees(outer), &said::number(OUTER_DEGREES)),
            Group::or(&["inner_degrees"], degrees(inner), &said::number(INNER_DEGREES)),
        ],
        Light::Directional { direction, irradiance, group: _ } => vec![
            kind("directional"),
            Group::of(AIM, [Said::new("direction", triple(direction))]),
            Group::one(&["irradiance"], color(irradiance)),
        ],
    };
    groups.push(light_group::key_of(light.group()));
    groups
}

const AIM: &[&str] = &["position", "direction", "look_at"];
const LIGHT: &[&str] = &["intensity", "power"];
