//! A matte surface: paper, plaster, chalk.

use crate::color::Rgb;
use crate::problem::{Place, SceneProblem, UNIT};

/// Scatters light diffusely, on both sides. See [`Lambert`](crate::bsdf::Lambert) and, for rough
/// surfaces, [`OrenNayar`](crate::bsdf::OrenNayar).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Matte {
    /// The part of the light sent back, 0 to 1 per channel.
    pub albedo: Rgb,
    /// How rough it is, 0 to 1: from paper, equally bright from everywhere, to the moon.
    pub roughness: f32,
}

impl Matte {
    /// Without roughness.
    pub fn new(albedo: Rgb) -> Self {
        Self { albedo, roughness: 0.0 }
    }

    pub(super) fn validate(&self, place: Place) -> Result<(), SceneProblem> {
        place.check("albedo", self.albedo.0, UNIT)?;
        place.check("roughness", [self.roughness], UNIT)
    }
}
