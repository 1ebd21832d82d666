//! Metal, polished or rough, with the reflection that its complex index of refraction gives.

use crate::bsdf::Distribution;
use crate::color::Rgb;
use crate::problem::{Place, SceneProblem, UNIT};

/// A metal seen from a medium of index 1. The index is `eta + i k`, per channel.
///
/// Measured ones are in [`Metal`](super::Metal).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conductor {
    /// Real part of the index of refraction, 0 to 1000.
    pub eta: Rgb,
    /// Imaginary part (extinction), 0 to 1000.
    pub k: Rgb,
    /// How rough it is, 0 (a mirror) to 1. The α of its facets is the square.
    pub roughness: f32,
    /// How its facets are distributed.
    pub distribution: Distribution,
}

/// The largest part of an index accepted; metals stay below 100 even in the infrared.
const MAX_INDEX: f32 = 1000.0;

impl Conductor {
    /// A metal with facets of GGX.
    pub fn new(eta: Rgb, k: Rgb, roughness: f32) -> Self {
        Self { eta, k, roughness, distribution: Distribution::Ggx }
    }

    pub(super) fn validate(&self, place: Place) -> Result<(), SceneProblem> {
        place.check("eta", self.eta.0, 0.0..=MAX_INDEX)?;
        place.check("k", self.k.0, 0.0..=MAX_INDEX)?;
        place.check("roughness", [self.roughness], UNIT)
    }
}
