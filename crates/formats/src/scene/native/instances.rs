//! `instances`: the places of a shape that stands in several.
//!
//! Either a list of tables that move, turn and scale, or a file with a place in each line: twelve
//! numbers, the upper three rows of a matrix, or three, how far to move.

use super::draft::Draft;
use super::table::{Table, Value};
use super::{keys, placing};
use crate::error::{SceneError, SceneErrorKind};
use crate::file;
use crate::scene::text::{Cursor, place, word_at};
use rutilant_geom::{Mat3, Transform, Vec3};
use std::path::Path;

/// Where a shape stands, beyond what its own keys say: each place with the table that is to answer
/// for it. A shape without `instances` stands once.
pub(super) fn places<'d>(
    table: &Table<'d>,
    draft: &mut Draft<'d>,
) -> Result<Vec<(Table<'d>, Transform)>, SceneError> {
    let Some(value) = table.get("instances") else {
        return Ok(vec![(*table, Transform::IDENTITY)]);
    };
    let places: Vec<(Table<'d>, Transform)> = if value.text().is_err() {
        let all = value.tables("[[shape.instances]]")?.into_iter();
        let read = |instance: Table<'d>| {
            instance.only(&[keys::INSTANCE])?;
            Ok((instance, placing::transform(&instance)?))
        };
        all.map(read).collect::<Result<_, SceneError>>()?
    } else {
        let all = from_file(&value, draft)?;
        all.into_iter().map(|transform| (*table, transform)).collect()
    };
    if places.is_empty() {
        draft.notes.push(table.note("there are no instances of it, so nothing of it can be seen"));
    }
    Ok(places)
}

/// The places in the file that a value names.
fn from_file<'d>(value: &Value<'d>, draft: &mut Draft<'d>) -> Result<Vec<Transform>, SceneError> {
    let name = value.text()?;
    if let Some(bytes) = draft.files.embedded(name) {
        return parse(bytes, Path::new(name));
    }
    let found = draft.files.find(name).map_err(|what| value.invalid(what))?;
    let bytes = file::scene_bytes(&found.path, &draft.left)?;
    let places = parse(&bytes, &found.path)?;
    draft.read.push(found.identity);
    Ok(places)
}

fn parse(bytes: &[u8], path: &Path) -> Result<Vec<Transform>, SceneError> {
    let refused = |at: usize, what: String| SceneError {
        at: place(path, bytes, at),
        kind: SceneErrorKind::Invalid(what),
    };
    let mut cursor = Cursor::new(bytes);
    let mut places = Vec::new();
    loop {
        // Empty lines and comments.
        while cursor.line_is_done() {
            if cursor.peek().is_none() {
                return Ok(places);
            }
            cursor.skip_line();
        }
        let start = cursor.at;
        let (mut numbers, mut count) = ([0.0; 12], 0);
        while !cursor.line_is_done() {
            let at = cursor.at;
            let Some(number) = cursor.number().filter(|n| n.is_finite()) else {
                return Err(refused(at, format!("{} is no finite number", word_at(bytes, at))));
            };
            if let Some(place) = numbers.get_mut(count) {
                *place = number;
            }
            count += 1;
        }
        let [a, b, c, x, d, e, f, y, g, h, i, z] = numbers;
        let transform = match count {
            3 => Transform::translate(Vec3::new(a, b, c)),
            12 => {
                let columns = [Vec3::new(a, d, g), Vec3::new(b, e, h), Vec3::new(c, f, i)];
                let [p, q, r] = columns;
                Transform::new(Mat3::from_cols(p, q, r), Vec3::new(x, y, z))
            }
            _ => {
                return Err(refused(
                    start,
                    format!(
                        "an instance has 12 numbers, the upper three rows of its matrix, or 3, how \
                         far it is moved, but here are {count}"
                    ),
                ));
            }
        };
        if transform.inverse().is_none() {
            let what = "the matrix flattens the shape, or makes it too large".to_owned();
            return Err(refused(start, what));
        }
        places.push(transform);
    }
}
