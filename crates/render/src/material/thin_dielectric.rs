//! A pane of glass without an inside: windows, bottles for the background, cling film.

use super::dielectric::MAX_IOR;
use crate::color::Rgb;
use crate::problem::{Place, SceneProblem, UNIT};

/// A thin pane. Light passes it straight on; see [`bsdf::ThinDielectric`](crate::bsdf::ThinDielectric).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinDielectric {
    /// Index of refraction, 1 to 10.
    pub ior: f32,
    /// What is left of white light after one pass at normal incidence, 0 to 1 per channel,
    /// without what the faces reflect.
    pub color: Rgb,
}

impl ThinDielectric {
    pub(super) fn validate(&self, place: Place) -> Result<(), SceneProblem> {
        place.check("ior", [self.ior], 1.0..=MAX_IOR)?;
        place.check("color", self.color.0, UNIT)
    }
}
