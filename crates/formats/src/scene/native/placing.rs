//! Where a shape stands: the keys that move, turn and scale it.

use super::camera::direction;
use super::keys;
use super::said::{self, Group, Said, number, triple};
use super::table::{Table, Value};
use crate::error::SceneError;
use rutilant_geom::{Aabb, Mat3, Transform, Vec3};

/// Where a shape stands: scaled, then turned, then moved; or by a matrix.
pub(super) fn transform(table: &Table<'_>) -> Result<Transform, SceneError> {
    for key in ["scale", "rotate", "rotate_degrees", "translate", "center"] {
        table.at_most_one(&["matrix", key])?;
    }
    if let Some(matrix) = table.maybe("matrix", matrix)? {
        return Ok(matrix);
    }
    let scale = table.or("scale", scale, Vec3::ONE)?;
    let rotation = match table.at_most_one(&["rotate", "rotate_degrees"])? {
        None => Transform::IDENTITY,
        Some("rotate") => table.must("rotate", around_axis)?,
        Some(_) => about_axes(table.must("rotate_degrees", Value::triple)?),
    };
    let translation = match table.at_most_one(&["translate", "center"])? {
        None => Vec3::ZERO,
        Some(key) => table.must(key, Value::triple)?,
    };
    Ok(placed(scale, rotation, translation))
}

fn placed(scale: Vec3, rotation: Transform, translation: Vec3) -> Transform {
    Transform::translate(translation) * rotation * Transform::scale(scale)
}

/// The keys by which the reader above finds `world_from_object`, bit by bit: a few that people think
/// in where these do, else a matrix. A shape that is `centered` says where its middle stands.
pub(super) fn keys_of(world_from_object: &Transform, centered: bool) -> Group {
    let moved = world_from_object.translation();
    let (place, of) = (if centered { "center" } else { "translate" }, world_from_object);
    let is_meant = |scale: Vec3, rotation: Transform| is_same(of, &placed(scale, rotation, moved));
    let translate = || (moved != Vec3::ZERO).then(|| Said::new(place, triple(moved)));
    let Mat3 { x_axis, y_axis, z_axis } = of.linear();
    let scale = Vec3::new(x_axis.x, y_axis.y, z_axis.z);
    if is_meant(scale, Transform::IDENTITY) {
        let one = scale.x.to_bits() == scale.y.to_bits() && scale.y.to_bits() == scale.z.to_bits();
        let scale = if one { number(scale.x) } else { triple(scale) };
        let scale = Some(Said::or("scale", scale, "1"));
        return Group::of(PLACING, [scale, translate()].into_iter().flatten().collect::<Vec<_>>());
    }
    for degrees in (-11..=12).map(|step| 15.0 * step as f32) {
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            // Without signs before zeros.
            let turn = axis * degrees + Vec3::ZERO;
            if is_meant(Vec3::ONE, about_axes(turn)) {
                let turn = Some(Said::new("rotate_degrees", triple(turn)));
                let says = [turn, translate()].into_iter().flatten().collect::<Vec<_>>();
                return Group::of(PLACING, says);
            }
        }
    }
    let row = |i: usize| {
        let row = [x_axis[i], y_axis[i], z_axis[i], moved[i]];
        said::numbers(row.map(number))
    };
    Group::of(PLACING, [Said::new("matrix", said::numbers([row(0), row(1), row(2)]))])
}

/// Every key that moves, turns or scales.
const PLACING: &[&str] = &["matrix", "scale", "rotate", "rotate_degrees", "translate", "center"];

/// One placing after another. What stays where it is changes no bit of the other, not even the sign
/// of a zero.
pub(super) fn after(then: Transform, first: Transform) -> Transform {
    if is_same(&then, &Transform::IDENTITY) {
        first
    } else if is_same(&first, &Transform::IDENTITY) {
        then
    } else {
        then * first
    }
}

/// Whether two maps have the same bits.
pub(super) fn is_same(one: &Transform, other: &Transform) -> bool {
    bits(one) == bits(other)
}

fn bits(transform: &Transform) -> [[u32; 3]; 4] {
    let Mat3 { x_axis, y_axis, z_axis } = transform.linear();
    [x_axis, y_axis, z_axis, transform.translation()].map(|v| v.to_array().map(f32::to_bits))
}

fn scale(value: &Value<'_>) -> Result<Vec3, SceneError> {
    if value.is_number() {
        value.number().map(Vec3::splat)
    } else {
        value.numbers("a number, or three [x, y, z]").map(Vec3::from_array)
    }
}

/// About the world's x axis first, then its y axis, then its z axis.
fn about_axes(degrees: Vec3) -> Transform {
    let turn = Transform::rotate_degrees;
    turn(Vec3::Z, degrees.z) * turn(Vec3::Y, degrees.y) * turn(Vec3::X, degrees.x)
}

fn around_axis(value: &Value<'_>) -> Result<Transform, SceneError> {
    let table = value.table("rotate")?;
    table.only(&[keys::ROTATE])?;
    let axis = table.must("axis", direction)?;
    let degrees = table.must("degrees", Value::number)?;
    Ok(Transform::rotate_degrees(axis, degrees))
}

fn matrix(value: &Value<'_>) -> Result<Transform, SceneError> {
    const EXPECTED: &str = "3 or 4 rows of 4 numbers, or those 12 or 16 numbers in one array";
    let mut numbers = Vec::with_capacity(16);
    let entries = value.entries(EXPECTED)?;
    if entries.len() > 16 {
        return Err(value.must_be(EXPECTED));
    }
    for entry in entries {
        if entry.is_array() {
            numbers.extend(entry.numbers::<4>("rows of 4 numbers")?);
        } else {
            numbers.extend([entry.number()?]);
        }
    }
    let (rows, rest) = numbers.as_chunks::<4>();
    match *rows {
        [_, _, _] | [_, _, _, [0.0, 0.0, 0.0, 1.0]] if rest.is_empty() => {}
        [_, _, _, _] => return Err(value.invalid("the last row of matrix must be 0, 0, 0, 1")),
        _ => return Err(value.must_be(EXPECTED)),
    }
    let column = |i: usize| Vec3::new(rows[0][i], rows[1][i], rows[2][i]);
    Ok(Transform::new(Mat3::from_cols(column(0), column(1), column(2)), column(3)))
}

#[derive(Clone, Copy)]
enum Extent {
    Longest,
    X,
    Y,
    Z,
}

const AXES: &[(&str, Extent)] =
    &[("longest", Extent::Longest), ("x", Extent::X), ("y", Extent::Y), ("z", Extent::Z)];

#[derive(Clone, Copy)]
enum Up {
    Y,
    Z,
}

const UPS: &[(&str, Up)] = &[("y", Up::Y), ("z", Up::Z)];

/// Turns what points up in a mesh to where up is here, with the box around the mesh.
fn upright(up: Up, Aabb { min, max }: Aabb) -> (Transform, Aabb) {
    match up {
        Up::Y => (Transform::IDENTITY, Aabb { min, max }),
        Up::Z => (
            Transform::rotate_degrees(Vec3::X, -90.0),
            Aabb { min: Vec3::new(min.x, min.z, -max.y), max: Vec3::new(max.x, max.z, -min.y) },
        ),
    }
}

/// Brings a mesh of any size, anywhere, to a given size at a given place.
pub(super) fn fit(value: &Value<'_>, bounds: Aabb) -> Result<Transform, SceneError> {
    let table = value.table("fit")?;
    table.only(&[keys::FIT])?;
    if bounds.is_empty() {
        return Err(value.invalid("the mesh has no point that could be fitted"));
    }
    let up = table.or("up", |v| v.one_of("direction", UPS), Up::Y)?;
    let (upright, bounds) = upright(up, bounds);
    let extent = bounds.extent();
    let now = match table.or("axis", |v| v.one_of("axis", AXES), Extent::Longest)? {
        Extent::Longest => extent.max_element(),
        Extent::X => extent.x,
        Extent::Y => extent.y,
        Extent::Z => extent.z,
    };
    let factor = match table.maybe("size", Value::positive)? {
        None => 1.0,
        Some(size) if now > 0.0 => size / now,
        Some(_) => return Err(value.invalid("the mesh is flat along that axis; name another")),
    };
    let middle = bounds.center();
    let (from, to) = match table.at_most_one(&["on_floor", "center"])? {
        Some("center") => (middle, table.must("center", Value::triple)?),
        _ => (
            Vec3::new(middle.x, bounds.min.y, middle.z),
            Vec3::Y * table.or("on_floor", Value::number, 0.0)?,
        ),
    };
    Ok(Transform::translate(to)
        * Transform::scale(Vec3::splat(factor))
        * Transform::translate(-from)
        * upright)
}
