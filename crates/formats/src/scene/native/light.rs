//! `[[light]]`: lights without a surface.

use super::draft::Draft;
use super::keys;
use super::table::{Table, Value};
use crate::error::SceneError;
use rutilant::light::Light;
use rutilant::scene::Place;

#[derive(Clone, Copy)]
enum Type {
    Point,
    Directional,
}

const TYPES: &[(&str, Type)] = &[("point", Type::Point), ("directional", Type::Directional)];

pub(super) fn read<'d>(table: &Table<'d>, draft: &mut Draft<'d>) -> Result<(), SceneError> {
    let light = match table.must("type", |v| v.one_of("light type", TYPES))? {
        Type::Point => {
            let table = table.named("a point light");
            table.only(&[keys::ANY_LIGHT, keys::POINT])?;
            Light::Point {
                position: table.must("position", Value::triple)?,
                intensity: table.must("intensity", Value::color)?,
            }
        }
        Type::Directional => {
            let table = table.named("a directional light");
            table.only(&[keys::ANY_LIGHT, keys::DIRECTIONAL])?;
            Light::Directional {
                direction: table.must("direction", Value::triple)?,
                irradiance: table.must("irradiance", Value::color)?,
            }
        }
    };
    draft.places.insert(Place::Light(draft.scene.lights.len()), *table);
    draft.scene.lights.push(light);
    Ok(())
}
