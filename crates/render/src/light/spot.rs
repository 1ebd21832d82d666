//! A light in one point that shines into a cone: a theatre lamp, a torch.
//!
//! Inside the inner cone it is evenly bright, outside the outer one dark;
//! between them its intensity falls as a smoothstep of the angle's cosine. That
//! is a polynomial in the cosine, so that the power has a closed form.
//!
//! Source: Pharr, Jakob, Humphreys, *Physically Based Rendering*, 4th ed.,
//! section 12.2.1; the cones are those of Khronos, *KHR_lights_punctual*, 2018.

use super::bounds::EmitterBounds;
use super::sample::EmitterSample;
use crate::color::Spectrum;
use rutilant_geom::{Vec3, real};
use std::f32::consts::PI;

/// Shines around one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpotEmitter {
    position: Vec3,
    /// Where its light goes, a unit vector.
    axis: Vec3,
    /// Intensity inside the inner cone, in W/sr.
    intensity: Spectrum,
    /// 1 − cosine of the half angles; exact for narrow beams, unlike the cosine.
    inner: f32,
    outer: f32,
}

impl SpotEmitter {
    /// A spot of `intensity` W/sr that shines from `position` along the unit vector `axis`. Half
    /// angles in radians, `0 ≤ inner ≤ outer ≤ π` and `outer > 0`.
    pub fn new(position: Vec3, axis: Vec3, intensity: Spectrum, [inner, outer]: [f32; 2]) -> Self {
        Self { position, axis, intensity, inner: one_minus_cos(inner), outer: one_minus_cos(outer) }
    }

    /// The solid angle in sr that would have the same power if it were evenly bright: all of the
    /// inner cone, and half of what lies between it and the outer one, because a smoothstep is a
    /// half on average.
    pub(super) fn solid_angle([inner, outer]: [f32; 2]) -> f32 {
        PI * (one_minus_cos(inner) + one_minus_cos(outer))
    }

    pub(super) fn sample(&self, from: Vec3) -> Option<EmitterSample> {
        let way = self.position - from;
        let wi = way.try_normalize()?;
        let radiance = self.intensity * self.falloff(-wi) / way.length_squared();
        (!radiance.is_black()).then_some(EmitterSample {
            wi,
            radiance,
            pdf: 1.0,
            delta: true,
            end: Some(self.position),
        })
    }

    /// Around each direction of its inner cone it shines as far as the outer one reaches, or a
    /// right angle if that is less; then the cone around which it does is wider.
    pub(super) fn bounds(&self) -> EmitterBounds {
        let (at, intensity) = (self.position.as_dvec3(), f64::from(self.intensity.luminance()));
        let [(cos_inner, sin_inner), (cos_outer, sin_outer)] =
            [self.inner, self.outer].map(|x| (1.0 - x, (x * (2.0 - x)).max(0.0).sqrt()));
        let cos_between = cos_outer * cos_inner + sin_outer * sin_inner;
        let (cos_normals, cos_shines) =
            if cos_between >= 0.0 { (cos_inner, cos_between) } else { (sin_outer, 0.0) };
        let round = EmitterBounds::round(at, at, intensity);
        let mean = 0.25 * (self.inner + self.outer);
        EmitterBounds { axis: self.axis, cos_normals, cos_shines, mean, ..round }
    }

    pub(super) fn power(&self) -> Spectrum {
        self.intensity * (PI * (self.inner + self.outer))
    }

    /// The part of the intensity that shines along the unit vector `direction`, 0 to 1.
    fn falloff(&self, direction: Vec3) -> f32 {
        // 1 − cos of the angle between two unit vectors, without the cancellation.
        let off_axis = 0.5 * (direction - self.axis).length_squared();
        if off_axis <= self.inner {
            return 1.0;
        }
        if off_axis >= self.outer {
            return 0.0;
        }
        let x = (self.outer - off_axis) / (self.outer - self.inner);
        x * x * (3.0 - 2.0 * x)
    }
}

/// 1 − cos x, without cancellation.
fn one_minus_cos(x: f32) -> f32 {
    let sin_half = real::sin(0.5 * x);
    2.0 * sin_half * sin_half
}
