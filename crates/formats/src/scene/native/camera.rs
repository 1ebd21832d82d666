//! `[camera]`: who sees the scene.

use super::draft::Draft;
use super::keys;
use super::said::{self, Group, Said, number, triple};
use super::table::{Table, Value};
use crate::camera::{
    AngleOfView, Aperture, AuthoredCamera, AuthoredLens, CameraKind, FOV_DEGREES, FocusOn,
    SENSOR_HEIGHT_MM, sizable,
};
use crate::error::SceneError;
use crate::options::ReadOptions;
use crate::scene::loaded;
use crate::shown::shown;
use rutilant::scene::{Place, Scene};
use rutilant_geom::Vec3;
use std::collections::HashSet;
use std::path::Path;

#[derive(Clone, Copy)]
enum Type {
    Perspective,
    Orthographic,
    Equirectangular,
}

const TYPES: &[(&str, Type)] = &[
    ("perspective", Type::Perspective),
    ("orthographic", Type::Orthographic),
    ("equirectangular", Type::Equirectangular),
];

/// Reads every camera, and gives the number of the one that sees the scene, which becomes the
/// draft's. There are none where the scene has none.
pub(super) fn read_all<'d>(
    root: &Table<'d>,
    size: [u32; 2],
    file: &Path,
    options: &ReadOptions<'_>,
    draft: &mut Draft<'d>,
) -> Result<(Vec<AuthoredCamera>, usize), SceneError> {
    let tables = root.maybe("camera", |value| {
        if value.is_array() {
            value.tables("[[camera]]")
        } else {
            value.table("[camera]").map(|table| vec![table])
        }
    })?;
    let tables = tables.unwrap_or_default();
    let mut cameras: Vec<AuthoredCamera> = Vec::with_capacity(tables.len());
    let mut names = HashSet::new();
    let mut prepared = Vec::with_capacity(tables.len());
    for table in &tables {
        let authored = read(table)?;
        if tables.len() > 1 {
            table.must("name", |value| {
                let name = shown(&authored.name);
                if authored.name.is_empty() {
                    Err(value.invalid(
                        "name is empty, but where there are several cameras each needs one",
                    ))
                } else if !names.insert(authored.name.clone()) {
                    let what = format!("there is another camera \"{name}\"; names must differ");
                    Err(value.invalid(what))
                } else {
                    Ok(())
                }
            })?;
        }
        let camera = authored.camera(size).map_err(|problem| match problem.key {
            "look_at" => table.invalid(problem.what),
            key => table.invalid_at(table.place_of(key).0, problem.what),
        })?;
        // Those that do not see the scene must be sound as well.
        draft.places.insert(Place::Camera, *table);
        Scene::new(camera).validate().map_err(|problem| draft.locate(root, &problem))?;
        cameras.push(authored);
        prepared.push(camera);
    }
    let chosen = loaded::camera_named(&cameras, file, options)?;
    if let (Some(camera), Some(table)) = (prepared.get(chosen), tables.get(chosen)) {
        draft.scene.camera = *camera;
        draft.places.insert(Place::Camera, *table);
    }
    Ok((cameras, chosen))
}

/// What a table says of a camera.
pub(super) fn read(table: &Table<'_>) -> Result<AuthoredCamera, SceneError> {
    let kind = table.or("type", |v| v.one_of("camera type", TYPES), Type::Perspective)?;
    let table = table.named(match kind {
        Type::Perspective => "[camera]",
        Type::Orthographic => "an orthographic [camera]",
        Type::Equirectangular => "an equirectangular [camera]",
    });
    table.only(&[
        keys::ANY_CAMERA,
        match kind {
            Type::Perspective | Type::Orthographic => keys::LENS,
            Type::Equirectangular => &[],
        },
        match kind {
            Type::Perspective => keys::PERSPECTIVE,
            Type::Orthographic => keys::ORTHOGRAPHIC,
            Type::Equirectangular => &[],
        },
    ])?;
    Ok(AuthoredCamera {
        name: table.or("name", Value::text, "")?.to_owned(),
        position: table.must("position", Value::triple)?,
        look_at: table.must("look_at", Value::triple)?,
        up: table.or("up", Value::triple, Vec3::Y)?,
        kind: match kind {
            Type::Perspective => {
                let (view, sensor_height_mm) = film(&table)?;
                let aperture = match table.at_most_one(&["aperture_radius", "f_number"])? {
                    Some("f_number") => {
                        Some(Aperture::FNumber(table.must("f_number", Value::positive)?))
                    }
                    Some(_) | None => aperture_radius(&table)?,
                };
                CameraKind::Perspective { view, sensor_height_mm, lens: lens(&table, aperture)? }
            }
            Type::Orthographic => CameraKind::Orthographic {
                height: table.must("height", Value::number)?,
                lens: lens(&table, aperture_radius(&table)?)?,
            },
            Type::Equirectangular => CameraKind::Equirectangular,
        },
    })
}

/// Three numbers that are not all zero. Those whose squares are no numbers any more are brought to
/// length 1.
pub(super) fn direction(value: &Value<'_>) -> Result<Vec3, SceneError> {
    sizable(value.triple()?)
        .ok_or_else(|| value.invalid("it points nowhere: all three numbers are 0"))
}

/// How much a perspective camera sees, and on which height of film.
fn film(table: &Table<'_>) -> Result<(AngleOfView, f32), SceneError> {
    let given = table.at_most_one(&["fov_degrees", "focal_length_mm"])?;
    if let Some(value) = table.get("sensor_height_mm")
        && table.get("focal_length_mm").is_none()
        && table.get("f_number").is_none()
    {
        return Err(value.invalid("sensor_height_mm needs a focal_length_mm or an f_number"));
    }
    let height_mm = table.or("sensor_height_mm", Value::positive, SENSOR_HEIGHT_MM)?;
    let view = match given {
        Some("focal_length_mm") => {
            AngleOfView::FocalLengthMm(table.must("focal_length_mm", Value::positive)?)
        }
        Some(_) | None => {
            AngleOfView::FovDegrees(table.or("fov_degrees", Value::number, FOV_DEGREES)?)
        }
    };
    Ok((view, height_mm))
}

fn aperture_radius(table: &Table<'_>) -> Result<Option<Aperture>, SceneError> {
    Ok(table.maybe("aperture_radius", Value::number)?.map(Aperture::Radius))
}

/// The lens; `aperture` is there where the author gave it a size.
fn lens(table: &Table<'_>, aperture: Option<Aperture>) -> Result<AuthoredLens, SceneError> {
    for key in ["blades", "blade_rotation_degrees", "aperture_ratio"] {
        if let (Some(value), None) = (table.get(key), aperture) {
            return Err(value.invalid(format!("{key} needs an aperture_radius or an f_number")));
        }
    }
    let blades = table.or("blades", Value::whole, 0)?;
    if let (Some(value), 0) = (table.get("blade_rotation_degrees"), blades) {
        return Err(
            value.invalid("blade_rotation_degrees needs blades: a round lens has no corners")
        );
    }
    let focus = match table.at_most_one(&["focus_distance", "focus_at", "focus_on"])? {
        Some("focus_at") => FocusOn::Point(table.must("focus_at", Value::triple)?),
        Some("focus_on") => {
            FocusOn::Pixel(table.must("focus_on", |v| v.wholes("two whole numbers [x, y]"))?)
        }
        Some(_) => FocusOn::Distance(table.must("focus_distance", Value::number)?),
        None => FocusOn::LookAt,
    };
    Ok(AuthoredLens {
        aperture: aperture.unwrap_or(Aperture::Radius(0.0)),
        focus,
        blades,
        blade_rotation_degrees: table.or("blade_rotation_degrees", Value::number, 0.0)?,
        aperture_ratio: table.or("aperture_ratio", Value::number, 1.0)?,
    })
}

/// The keys that say all of a camera.
pub(super) fn keys_of(camera: &AuthoredCamera) -> Vec<Group> {
    let (kind, lens) = (&camera.kind, camera.kind.lens());
    let type_name = match kind {
        CameraKind::Perspective { .. } => "perspective",
        CameraKind::Orthographic { .. } => "orthographic",
        CameraKind::Equirectangular => "equirectangular",
    };
    let mut groups = vec![
        Group::or(&["name"], said::text(&camera.name), "\"\""),
        Group::or(&["type"], said::text(type_name), "\"perspective\""),
        Group::one(&["position"], triple(camera.position)),
        Group::one(&["look_at"], triple(camera.look_at)),
        Group::or(&["up"], triple(camera.up), &triple(Vec3::Y)),
    ];
    match *kind {
        CameraKind::Perspective { view, sensor_height_mm, lens } => {
            let film =
                Said::or("sensor_height_mm", number(sensor_height_mm), &number(SENSOR_HEIGHT_MM));
            let (view, by_film) = match view {
                AngleOfView::FovDegrees(degrees) => {
                    (Said::or("fov_degrees", number(degrees), &number(FOV_DEGREES)), false)
                }
                AngleOfView::FocalLengthMm(length) => {
                    (Said::new("focal_length_mm", number(length)), true)
                }
            };
            let by_film = by_film || matches!(lens.aperture, Aperture::FNumber(_));
            groups.push(Group::of(&["fov_degrees", "focal_length_mm"], [view]));
            let film = if by_film { vec![film] } else { Vec::new() };
            groups.push(Group::of(&["sensor_height_mm"], film));
        }
        CameraKind::Orthographic { height, .. } => {
            groups.push(Group::one(&["height"], number(height)));
        }
        CameraKind::Equirectangular => {}
    }
    groups.extend(lens.into_iter().flat_map(keys_of_lens));
    groups
}

fn keys_of_lens(lens: &AuthoredLens) -> [Group; 5] {
    let round = lens.blades == 0 && lens.aperture_ratio.to_bits() == 1.0_f32.to_bits();
    let aperture = match lens.aperture {
        Aperture::FNumber(f_number) => Said::new("f_number", number(f_number)),
        Aperture::Radius(radius) => {
            let said = Said::or("aperture_radius", number(radius), "0");
            // Whoever speaks of an aperture's form must give it a size.
            Said { usual: said.usual && round, ..said }
        }
    };
    let focus = match lens.focus {
        FocusOn::LookAt => None,
        FocusOn::Distance(distance) => Some(Said::new("focus_distance", number(distance))),
        FocusOn::Point(point) => Some(Said::new("focus_at", triple(point))),
        FocusOn::Pixel(pixel) => Some(Said::new("focus_on", said::numbers(pixel))),
    };
    let turn = Said::or("blade_rotation_degrees", number(lens.blade_rotation_degrees), "0");
    let turn = if lens.blades == 0 { Vec::new() } else { vec![turn] };
    [
        Group::of(&["aperture_radius", "f_number"], [aperture]),
        Group::of(
            &["focus_distance", "focus_at", "focus_on"],
            focus.into_iter().collect::<Vec<_>>(),
        ),
        Group::or(&["blades"], lens.blades.to_string(), "0"),
        Group::of(&["blade_rotation_degrees"], turn),
        Group::or(&["aperture_ratio"], number(lens.aperture_ratio), "1"),
    ]
}

/// A complete table for a camera.
pub(crate) fn table(header: &str, camera: &AuthoredCamera) -> String {
    said::table(header, &keys_of(camera))
}
