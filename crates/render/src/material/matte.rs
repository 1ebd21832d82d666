//! A matte surface: paper, plaster, chalk.

use crate::color::Rgb;
use crate::problem::{Place, SceneProblem, UNIT};

/// Equally bright from everywhere, on both sides. See [`Lambert`](crate::bsdf::Lambert).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Matte {
    /// The part of the light sent back, 0 to 1 per channel.
    pub albedo: Rgb,
}

impl Matte {
    pub(super) fn validate(&self, place: Place) -> Result<(), SceneProblem> {
        place.check("albedo", self.albedo.0, UNIT)
    }
}
