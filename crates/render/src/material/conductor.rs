//! Smooth metal, with the reflection that its complex index of refraction gives.

use crate::color::Rgb;
use crate::problem::{NOT_NEGATIVE, Place, SceneProblem};

/// A smooth metal seen from a medium of index 1. The index is `eta + i k`, per channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conductor {
    /// Real part of the index of refraction, 0 or more.
    pub eta: Rgb,
    /// Imaginary part (extinction), 0 or more.
    pub k: Rgb,
}

impl Conductor {
    pub(super) fn validate(&self, place: Place) -> Result<(), SceneProblem> {
        place.check("eta", self.eta.0, NOT_NEGATIVE)?;
        place.check("k", self.k.0, NOT_NEGATIVE)
    }
}
