//! The key `group`: with which others a light is told apart in a picture.

use super::said::{self, Group};
use super::table::Table;
use crate::error::SceneError;
use rutilant::light::LightGroup;

/// The group that a table names, if it does.
pub(super) fn of(table: &Table<'_>) -> Result<Option<LightGroup>, SceneError> {
    table.maybe("group", |value| {
        LightGroup::new(value.text()?).map_err(|problem| value.invalid(problem.to_string()))
    })
}

/// The key that says it.
pub(super) fn key_of(group: Option<LightGroup>) -> Group {
    Group::maybe(&["group"], group.map(|group| said::text(group.name())))
}
