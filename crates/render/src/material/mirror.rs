//! A perfect mirror that reflects the same part at every angle.

use crate::color::Rgb;
use crate::problem::{Place, SceneProblem, UNIT};

/// Smooth and opaque, on both sides. Real metals brighten towards grazing
/// angles: see [`Conductor`](super::Conductor).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mirror {
    /// The part of the light reflected, 0 to 1 per channel.
    pub reflectance: Rgb,
}

impl Mirror {
    pub(super) fn validate(&self, place: Place) -> Result<(), SceneProblem> {
        place.check("reflectance", self.reflectance.0, UNIT)
    }
}
