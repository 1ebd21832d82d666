//! From the texture coordinates of a surface to those of a texture.

use crate::problem::{FINITE, Place, SceneProblem};
use rutilant_geom::{Vec2, real};

/// Scales, then turns, then moves texture coordinates, as KHR_texture_transform does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvMapping {
    /// Which of the mesh's sets of texture coordinates; where it has fewer, the first.
    pub set: u32,
    /// A factor for each coordinate: with 2 a texture is repeated twice as often.
    pub scale: Vec2,
    /// Turns the coordinates, in radians, counter-clockwise: the picture turns clockwise.
    pub rotation: f32,
    /// Is added at the end.
    pub offset: Vec2,
}

impl Default for UvMapping {
    fn default() -> Self {
        Self { set: 0, scale: Vec2::ONE, rotation: 0.0, offset: Vec2::ZERO }
    }
}

impl UvMapping {
    pub(super) fn validate(&self, place: Place) -> Result<(), SceneProblem> {
        place.check("scale", self.scale.to_array(), FINITE)?;
        place.check("rotation_degrees", [self.rotation], FINITE)?;
        place.check("offset", self.offset.to_array(), FINITE)
    }

    pub(crate) fn prepare(&self) -> PreparedMapping {
        let (s, c) = real::sin_cos(self.rotation);
        let Vec2 { x, y } = self.scale;
        PreparedMapping {
            set: self.set,
            u: Vec2::new(c * x, -s * y),
            v: Vec2::new(s * x, c * y),
            offset: self.offset,
            scale: (x * y).abs().sqrt(),
        }
    }
}

/// The same as an affine map.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PreparedMapping {
    pub(crate) set: u32,
    /// The rows of its linear part.
    u: Vec2,
    v: Vec2,
    offset: Vec2,
    /// How much longer a step becomes in the mean: the root of what areas are multiplied by.
    pub(crate) scale: f32,
}

impl PreparedMapping {
    pub(crate) fn apply(&self, uv: Vec2) -> Vec2 {
        Vec2::new(self.u.dot(uv), self.v.dot(uv)) + self.offset
    }
}
