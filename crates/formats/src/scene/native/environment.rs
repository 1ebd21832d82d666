//! `[environment]`: the sky.

use super::draft::Draft;
use super::keys;
use super::light_group;
use super::said::{self, Group, Said, color, degrees, number};
use super::table::{Table, Value};
use crate::error::SceneError;
use crate::scene::origins::PictureOrigin;
use crate::scene::pictures::sky_picture;
use rutilant::light::{Environment, EnvironmentLight, Projection};
use rutilant::scene::Place;

const PROJECTIONS: &[(&str, Projection)] = &[
    ("equirectangular", Projection::Equirectangular),
    ("octahedral", Projection::Octahedral),
    ("cube", Projection::Cube),
];

pub(super) fn read<'d>(table: &Table<'d>, draft: &mut Draft<'d>) -> Result<(), SceneError> {
    table.only(&[keys::ENVIRONMENT])?;
    let light = match table.either(["image", "color"])? {
        "image" => {
            let image = table.must("image", |value| read_image(value, draft))?;
            let projection = table.or(
                "projection",
                |value| value.one_of("projection", PROJECTIONS),
                Projection::default(),
            )?;
            draft.image_names.push(table.must("image", Value::text)?.to_owned());
            EnvironmentLight::Image { image: draft.scene.add_image(image), projection }
        }
        _ => {
            if let Some(value) = table.get("projection") {
                return Err(value.invalid("projection needs an image"));
            }
            EnvironmentLight::Constant(table.must("color", Value::color)?)
        }
    };
    draft.scene.environment = Some(Environment {
        light,
        scale: table.or("scale", Value::number, 1.0)?,
        rotation: table.or("rotation_degrees", Value::number, 0.0)?.to_radians(),
        group: light_group::of(table)?,
    });
    draft.places.insert(Place::Environment, *table);
    Ok(())
}

fn read_image(
    value: &Value<'_>,
    draft: &mut Draft<'_>,
) -> Result<rutilant::image::Image, SceneError> {
    let name = value.text()?;
    let find = || draft.files.find(name).map_err(|what| value.invalid(what));
    let (image, origin) = sky_picture(&draft.files, name, &draft.left, find)?;
    if let PictureOrigin::File(file) = &origin {
        draft.read.push(file.clone());
    }
    draft.origins.images.push(origin);
    image.map_err(|error| value.invalid(error.to_string()))
}

/// The keys that say all of a sky; `image_names` are those of the scene's images.
pub(super) fn keys_of(sky: &Environment, image_names: &[String]) -> Vec<Group> {
    let light = match sky.light {
        EnvironmentLight::Constant(rgb) => vec![Said::new("color", color(rgb))],
        EnvironmentLight::Image { image, projection } => {
            let name = image_names.get(image.0 as usize).map_or("", String::as_str);
            let usual = said::name(PROJECTIONS, &Projection::default());
            vec![
                Said::new("image", said::text(name)),
                Said::or("projection", said::name(PROJECTIONS, &projection), &usual),
            ]
        }
    };
    vec![
        Group::of(&["image", "projection", "color"], light),
        Group::or(&["scale"], number(sky.scale), "1"),
        Group::or(&["rotation_degrees"], degrees(sky.rotation), "0"),
        light_group::key_of(sky.group),
    ]
}
