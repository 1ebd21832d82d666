//! A light in one point.

use super::bounds::EmitterBounds;
use super::sample::EmitterSample;
use crate::color::Spectrum;
use rutilant_geom::Vec3;
use std::f32::consts::PI;

/// Shines equally in all directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointEmitter {
    /// Where it is.
    pub position: Vec3,
    /// Intensity in W/sr.
    pub intensity: Spectrum,
}

impl PointEmitter {
    pub(super) fn sample(&self, from: Vec3) -> Option<EmitterSample> {
        let way = self.position - from;
        let wi = way.try_normalize()?;
        let radiance = self.intensity / way.length_squared();
        Some(EmitterSample { wi, radiance, pdf: 1.0, delta: true, end: Some(self.position) })
    }

    pub(super) fn bounds(&self) -> EmitterBounds {
        let at = self.position.as_dvec3();
        EmitterBounds::round(at, at, f64::from(self.intensity.luminance()))
    }

    pub(super) fn power(&self) -> Spectrum {
        self.intensity * (4.0 * PI)
    }
}
