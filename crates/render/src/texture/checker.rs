//! Squares of two colours, as on a chess board.

use super::mapping::UvMapping;
use crate::color::Rgb;
use crate::problem::{LIGHT, Place, SceneProblem};
use rutilant_geom::Vec2;

/// Two colours in turn. Each unit of the mapped texture coordinates holds two squares along either
/// axis; the one at the lower left has the `first` colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Checker {
    /// The colour at (0, 0).
    pub first: Rgb,
    /// The colour beside it.
    pub second: Rgb,
    /// From the surface's texture coordinates to those of the board.
    pub mapping: UvMapping,
}

impl Checker {
    pub(super) fn validate(&self, place: Place) -> Result<(), SceneProblem> {
        place.check("first", self.first.0, LIGHT)?;
        place.check("second", self.second.0, LIGHT)?;
        self.mapping.validate(place)
    }

    /// The part of the second colour at a place of the board.
    pub(crate) fn amount(&self, uv: Vec2) -> f32 {
        let Vec2 { x, y } = (2.0 * uv).floor();
        // Half of an even number has no fraction.
        let half = 0.5 * (x + y);
        if half == half.floor() { 0.0 } else { 1.0 }
    }
}
