//! A light infinitely far away in one direction: the sun, made small.

use super::sample::EmitterSample;
use crate::color::Spectrum;
use rutilant_geom::Vec3;
use std::f32::consts::PI;

/// Parallel light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistantEmitter {
    /// The direction it is seen in, a unit vector.
    pub towards: Vec3,
    /// Irradiance in W/m² on a surface that faces it.
    pub irradiance: Spectrum,
}

impl DistantEmitter {
    pub(super) fn sample(&self) -> EmitterSample {
        EmitterSample {
            wi: self.towards,
            radiance: self.irradiance,
            pdf: 1.0,
            delta: true,
            end: None,
        }
    }

    pub(super) fn power(&self, scene_radius: f32) -> Spectrum {
        self.irradiance * (PI * scene_radius * scene_radius)
    }
}
