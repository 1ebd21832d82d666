//! Bricks, tiles and planks between joints.

use super::mapping::UvMapping;
use crate::color::Rgb;
use crate::problem::{LIGHT, Place, SceneProblem, UNIT};
use rutilant_geom::Vec2;

/// Rows of bricks, each one unit of the mapped texture coordinates wide and high: the scale of the
/// `mapping` gives them their form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bricks {
    /// The colour of the joints.
    pub first: Rgb,
    /// The colour of the bricks.
    pub second: Rgb,
    /// How much of a brick's width and height a joint takes, 0 to 1. Half of it lies on either side.
    pub joint: Vec2,
    /// How far each row is moved against the one below, in widths of a brick: ½ for walls, 0 for
    /// tiles.
    pub shift: f32,
    /// From the surface's texture coordinates to those of the wall.
    pub mapping: UvMapping,
}

impl Bricks {
    pub(super) fn validate(&self, place: Place) -> Result<(), SceneProblem> {
        place.check("first", self.first.0, LIGHT)?;
        place.check("second", self.second.0, LIGHT)?;
        place.check("joint", self.joint.to_array(), UNIT)?;
        place.check("shift", [self.shift], UNIT)?;
        self.mapping.validate(place)
    }

    /// The part of the second colour at a place of the wall.
    pub(crate) fn amount(&self, uv: Vec2) -> f32 {
        let row = uv.y.floor();
        // Of as many rows as make a whole, so that far rows keep their digits.
        let moved = (row * self.shift).rem_euclid(1.0);
        let within = Vec2::new(uv.x - moved, uv.y);
        let from_edge = within - within.floor();
        let to_edge = from_edge.min(1.0 - from_edge);
        let inside = to_edge.x >= 0.5 * self.joint.x && to_edge.y >= 0.5 * self.joint.y;
        f32::from(u8::from(inside))
    }

    /// The same in the mean.
    pub(crate) fn mean_amount(&self) -> f32 {
        (1.0 - self.joint.x) * (1.0 - self.joint.y)
    }
}
