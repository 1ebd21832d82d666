//! A matte surface: paper, plaster, chalk.

use crate::problem::{Place, SceneProblem, UNIT};
use crate::texture::ColorInput;

/// Scatters light diffusely, on both sides. See [`Lambert`](crate::bsdf::Lambert) and, for rough
/// surfaces, [`OrenNayar`](crate::bsdf::OrenNayar).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Matte {
    /// The part of the light sent back, 0 to 1 per channel.
    pub albedo: ColorInput,
    /// How rough it is, 0 to 1: from paper, equally bright from everywhere, to the moon.
    pub roughness: f32,
    /// How scattered directions are drawn. The picture is the same, its noise is not.
    pub sampling: HemisphereSampling,
}

/// How directions are drawn from the half of the sphere that a matte surface scatters to.
///
/// A matter of the material and not of a rendering's settings: the density is part of how a
/// surface scatters, all that samples it then agrees on it, and no other surface pays for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum HemisphereSampling {
    /// In proportion to the cosine and what roughness makes of it.
    Cosine,
    /// Evenly; without roughness only. See [`UniformLambert`](crate::bsdf::UniformLambert).
    Uniform,
}

impl Matte {
    /// Without roughness.
    pub fn new(albedo: impl Into<ColorInput>) -> Self {
        Self { albedo: albedo.into(), roughness: 0.0, sampling: HemisphereSampling::Cosine }
    }

    pub(super) fn validate(&self, place: Place, textures: usize) -> Result<(), SceneProblem> {
        self.albedo.validate(place, "albedo", UNIT, textures)?;
        place.check("roughness", [self.roughness], UNIT)?;
        if self.sampling == HemisphereSampling::Uniform && self.roughness != 0.0 {
            let what = "sampling \"uniform\" is for smooth surfaces; rough ones take \"cosine\"";
            return Err(place.problem("sampling", what));
        }
        Ok(())
    }
}
