//! `[camera]`: who sees the scene.

use super::keys;
use super::table::{Table, Value};
use crate::error::SceneError;
use rutilant::camera::Perspective;
use rutilant_geom::{Transform, Vec3, real};

/// The vertical angle of view where none is given.
const FOV_DEGREES: f32 = 45.0;

/// The height of the film behind an `f_number`, in metres: that of small-format film and of
/// "full frame" digital cameras, which photographers mean when they name a focal length.
const FILM_HEIGHT: f32 = 0.024;

pub(super) fn read(table: &Table<'_>) -> Result<Perspective, SceneError> {
    table.only(&[keys::CAMERA])?;
    let position = table.must("position", Value::triple)?;
    let target = table.must("look_at", Value::triple)?;
    let up = table.or("up", direction, Vec3::Y)?;
    let fov_y = table.or("fov_degrees", Value::number, FOV_DEGREES)?.to_radians();
    let world_from_camera = Transform::look_at(position, target, up).ok_or_else(|| {
        table.invalid("the camera has no direction: position and look_at are the same point, or too far apart")
    })?;
    Ok(Perspective {
        world_from_camera,
        fov_y,
        aperture_radius: aperture_radius(table, fov_y)?,
        focus_distance: focus_distance(table, &world_from_camera, target)?,
    })
}

/// Three numbers that are not all zero.
pub(super) fn direction(value: &Value<'_>) -> Result<Vec3, SceneError> {
    let direction = value.triple()?;
    direction
        .try_normalize()
        .map(|_| direction)
        .ok_or_else(|| value.invalid("[0, 0, 0] points nowhere"))
}

fn aperture_radius(table: &Table<'_>, fov_y: f32) -> Result<f32, SceneError> {
    match table.at_most_one(&["aperture_radius", "f_number"])? {
        None => Ok(0.0),
        Some("f_number") => {
            let f_number = table.must("f_number", Value::positive)?;
            let focal_length = 0.5 * FILM_HEIGHT / real::tan(0.5 * fov_y);
            Ok(0.5 * focal_length / f_number)
        }
        Some(_) => table.must("aperture_radius", Value::number),
    }
}

fn focus_distance(
    table: &Table<'_>,
    world_from_camera: &Transform,
    target: Vec3,
) -> Result<f32, SceneError> {
    let along_view = |point: Vec3| {
        let offset = point - world_from_camera.translation();
        offset.dot(world_from_camera.vector(Vec3::NEG_Z))
    };
    match table.at_most_one(&["focus_distance", "focus_at"])? {
        None => Ok(along_view(target)),
        Some("focus_at") => table.must("focus_at", |value| {
            let distance = along_view(value.triple()?);
            if distance > 0.0 {
                Ok(distance)
            } else {
                Err(value.invalid("focus_at lies behind the camera, or beside it"))
            }
        }),
        Some(_) => table.must("focus_distance", Value::number),
    }
}
