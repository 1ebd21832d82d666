//! `[camera]`: who sees the scene.

use super::keys;
use super::table::{Table, Value};
use crate::error::SceneError;
use rutilant::camera::{Camera, Equirectangular, Lens, Orthographic, Perspective};
use rutilant_geom::{Transform, Vec2, Vec3, real};

/// The vertical angle of view where none is given.
const FOV_DEGREES: f32 = 45.0;

/// The height of the film where none is given, in millimetres: that of small-format film and of
/// "full frame" digital cameras, which photographers mean when they name a focal length.
const SENSOR_HEIGHT_MM: f32 = 24.0;

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

/// The camera of a picture of `size` pixels.
pub(super) fn read(table: &Table<'_>, size: [u32; 2]) -> Result<Camera, SceneError> {
    let kind = table.or("type", |v| v.one_of("camera type", TYPES), Type::Perspective)?;
    let table = table.named(match kind {
        Type::Perspective => "[camera]",
        Type::Orthographic => "an orthographic [camera]",
        Type::Equirectangular => "an equirectangular [camera]",
    });
    Ok(match kind {
        Type::Perspective => {
            table.only(&[keys::ANY_CAMERA, keys::LENS, keys::PERSPECTIVE])?;
            let pose = Pose::read(&table)?;
            let Film { fov_y, height } = film(&table)?;
            let aperture = table.at_most_one(&["aperture_radius", "f_number"])?;
            let aperture_radius = match aperture {
                Some("f_number") => table.must("f_number", |value| {
                    let f_number = value.positive()?;
                    let focal_length = 0.5 * height / real::tan(0.5 * fov_y);
                    let radius = 0.5 * focal_length / f_number;
                    // An angle of view that is none has the first word.
                    if radius.is_finite() || !focal_length.is_finite() {
                        Ok(radius)
                    } else {
                        let what = format!("f_number is {f_number:e}, too little for any lens");
                        Err(value.invalid(what))
                    }
                })?,
                Some(_) | None => table.or("aperture_radius", Value::number, 0.0)?,
            };
            let lens = lens(&table, &pose, aperture_radius, aperture.is_some(), size)?;
            Perspective { world_from_camera: pose.world_from_camera, fov_y, lens }.into()
        }
        Type::Orthographic => {
            table.only(&[keys::ANY_CAMERA, keys::LENS, keys::ORTHOGRAPHIC])?;
            let pose = Pose::read(&table)?;
            let height = table.must("height", Value::number)?;
            let aperture_radius = table.maybe("aperture_radius", Value::number)?;
            let opened = aperture_radius.is_some();
            let lens = lens(&table, &pose, aperture_radius.unwrap_or(0.0), opened, size)?;
            Orthographic { world_from_camera: pose.world_from_camera, height, lens }.into()
        }
        Type::Equirectangular => {
            table.only(&[keys::ANY_CAMERA])?;
            Equirectangular { world_from_camera: Pose::read(&table)?.world_from_camera }.into()
        }
    })
}

/// Where the camera stands and looks.
struct Pose {
    world_from_camera: Transform,
    target: Vec3,
}

impl Pose {
    fn read(table: &Table<'_>) -> Result<Self, SceneError> {
        let position = table.must("position", Value::triple)?;
        let target = table.must("look_at", Value::triple)?;
        let up = table.or("up", direction, Vec3::Y)?;
        let world_from_camera = Transform::look_at(position, target, up).ok_or_else(|| {
            table.invalid("the camera has no direction: position and look_at are the same point, or too far apart")
        })?;
        Ok(Self { world_from_camera, target })
    }

    /// How far away a point is, along the view.
    fn along_view(&self, point: Vec3) -> f32 {
        let offset = point - self.world_from_camera.translation();
        offset.dot(self.world_from_camera.vector(Vec3::NEG_Z))
    }
}

/// Three numbers that are not all zero. Those whose squares are no numbers any more are brought to
/// length 1.
pub(super) fn direction(value: &Value<'_>) -> Result<Vec3, SceneError> {
    let direction = value.triple()?;
    if direction.try_normalize().is_some() {
        return Ok(direction);
    }
    let largest = direction.abs().max_element();
    (direction / largest)
        .try_normalize()
        .ok_or_else(|| value.invalid("it points nowhere: all three numbers are 0"))
}

/// How much a perspective camera sees.
struct Film {
    /// The angle from top to bottom, in radians.
    fov_y: f32,
    /// The height of the film, in metres.
    height: f32,
}

fn film(table: &Table<'_>) -> Result<Film, SceneError> {
    let given = table.at_most_one(&["fov_degrees", "focal_length_mm"])?;
    if let Some(value) = table.get("sensor_height_mm")
        && table.get("focal_length_mm").is_none()
        && table.get("f_number").is_none()
    {
        return Err(value.invalid("sensor_height_mm needs a focal_length_mm or an f_number"));
    }
    let height_mm = table.or("sensor_height_mm", Value::positive, SENSOR_HEIGHT_MM)?;
    let fov_y = match given {
        Some("focal_length_mm") => {
            let focal_length = table.must("focal_length_mm", Value::positive)?;
            2.0 * real::atan2(0.5 * height_mm, focal_length)
        }
        Some(_) | None => table.or("fov_degrees", Value::number, FOV_DEGREES)?.to_radians(),
    };
    Ok(Film { fov_y, height: 1e-3 * height_mm })
}

/// The lens; `opened` tells whether the author gave it a size.
fn lens(
    table: &Table<'_>,
    pose: &Pose,
    aperture_radius: f32,
    opened: bool,
    size: [u32; 2],
) -> Result<Lens, SceneError> {
    for key in ["blades", "blade_rotation_degrees", "aperture_ratio"] {
        if let (Some(value), false) = (table.get(key), opened) {
            return Err(value.invalid(format!("{key} needs an aperture_radius or an f_number")));
        }
    }
    let blades = table.or("blades", Value::whole, 0)?;
    if let (Some(value), 0) = (table.get("blade_rotation_degrees"), blades) {
        return Err(
            value.invalid("blade_rotation_degrees needs blades: a round lens has no corners")
        );
    }
    let given = table.at_most_one(&["focus_distance", "focus_at", "focus_on"])?;
    let focus_distance = match given {
        Some("focus_at") => table.must("focus_at", |value| {
            let distance = pose.along_view(value.triple()?);
            if distance > 0.0 {
                Ok(distance)
            } else {
                Err(value.invalid("focus_at lies behind the camera, or beside it"))
            }
        })?,
        Some("focus_distance") => table.must("focus_distance", Value::number)?,
        Some(_) | None => pose.along_view(pose.target),
    };
    Ok(Lens {
        aperture_radius,
        focus_distance,
        focus_on: table.maybe("focus_on", |value| pixel(value, size))?,
        blades,
        blade_rotation: table.or("blade_rotation_degrees", Value::number, 0.0)?.to_radians(),
        aperture_ratio: table.or("aperture_ratio", Value::number, 1.0)?,
    })
}

/// The middle of a pixel as a place in the picture.
fn pixel(value: &Value<'_>, size: [u32; 2]) -> Result<Vec2, SceneError> {
    let at: [u32; 2] = value.wholes("two whole numbers [x, y]")?;
    Lens::place_of_pixel(at, size).ok_or_else(|| {
        let ([x, y], [width, height]) = (at, size);
        value.invalid(format!(
            "focus_on is {x},{y}, but the picture has {width}x{height} pixels, from 0,0 on"
        ))
    })
}
