//! A glowing sphere.
//!
//! From outside, directions are drawn uniformly over the cone that the sphere
//! fills, so that none misses. From inside, where it fills every direction,
//! points are drawn uniformly over its area.
//!
//! Source: Pharr, Jakob, Humphreys, *Physically Based Rendering*, 4th ed.,
//! section 6.2.4.

use super::bounds::EmitterBounds;
use super::sample::{EmitterSample, Glow, LampPoint, area_to_solid_angle};
use crate::color::Spectrum;
use crate::math::warp;
use rutilant_geom::{Frame, Sphere, Vec2, Vec3, offset_end, real};
use std::f32::consts::PI;

/// A glowing sphere; its front is outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereEmitter {
    /// Its shape.
    pub sphere: Sphere,
    /// Its light.
    pub glow: Glow,
}

impl SphereEmitter {
    pub(super) fn area(&self) -> f32 {
        4.0 * PI * self.sphere.radius * self.sphere.radius
    }

    pub(super) fn bounds(&self) -> EmitterBounds {
        let (center, radius) = (self.sphere.center.as_dvec3(), f64::from(self.sphere.radius));
        // From everywhere it looks like a disk.
        let intensity = self.glow.intensity(f64::from(PI) * radius * radius);
        EmitterBounds::round(center - radius, center + radius, intensity)
    }

    pub(super) fn point(&self, u: Vec2) -> LampPoint {
        let normal = warp::uniform_sphere(u);
        LampPoint { position: self.surface_point(normal), normal }
    }

    pub(super) fn sample(&self, from: Vec3, u: Vec2) -> Option<EmitterSample> {
        let Some(cone) = Cone::seen_from(from, &self.sphere) else {
            let LampPoint { position, normal } = self.point(u);
            return self.glow.sample_at(from, position, normal, self.area());
        };
        if self.glow.radiance.is_black() {
            return None;
        }

        // A direction within the cone, by its angle θ with the axis.
        let one_minus_cos = u.x * cone.one_minus_cos;
        let sin2 = one_minus_cos * (2.0 - one_minus_cos);
        let cos = 1.0 - one_minus_cos;
        let (s, c) = real::sin_cos(2.0 * PI * u.y);
        let frame = Frame::around(cone.axis);
        let sin = sin2.max(0.0).sqrt();
        let wi = frame.to_world(Vec3::new(sin * c, sin * s, cos)).normalize();

        // Where it first meets the sphere, as the normal there: the angle α at the centre.
        let cos_alpha =
            sin2 / cone.sin + cos * (1.0 - sin2 / (cone.sin * cone.sin)).max(0.0).sqrt();
        let sin_alpha = (1.0 - cos_alpha * cos_alpha).max(0.0).sqrt();
        let normal = -frame.to_world(Vec3::new(-sin_alpha * c, -sin_alpha * s, cos_alpha));
        let normal = normal.normalize();
        let end = offset_end(self.surface_point(normal), normal, from);
        Some(EmitterSample {
            wi,
            radiance: self.glow.radiance,
            pdf: cone.pdf(),
            delta: false,
            end: Some(end),
        })
    }

    pub(super) fn pdf(&self, from: Vec3, wi: Vec3, position: Vec3, normal: Vec3) -> f32 {
        match Cone::seen_from(from, &self.sphere) {
            // Light samples end where the sphere is met first. Through one that rays pass, its far
            // wall is found by scattered rays alone.
            Some(_) if wi.dot(normal) > 0.0 => 0.0,
            Some(cone) => cone.pdf(),
            None => area_to_solid_angle(1.0 / self.area(), position - from, wi, normal),
        }
    }

    pub(super) fn power(&self) -> Spectrum {
        self.glow.power(self.area())
    }

    fn surface_point(&self, normal: Vec3) -> Vec3 {
        let Sphere { center, radius } = self.sphere;
        (center.as_dvec3() + normal.as_dvec3().normalize() * f64::from(radius)).as_vec3()
    }
}

/// All directions in which a sphere is seen.
struct Cone {
    axis: Vec3,
    /// Sine of the half angle.
    sin: f32,
    /// 1 − cosine of the half angle, exact for small angles as well.
    one_minus_cos: f32,
}

impl Cone {
    /// `None` from inside the sphere or from its surface.
    fn seen_from(from: Vec3, sphere: &Sphere) -> Option<Self> {
        let way = (sphere.center - from).as_dvec3();
        let (distance2, radius) = (way.length_squared(), f64::from(sphere.radius));
        let sin2 = radius * radius / distance2;
        if sin2 >= 0.999_99 {
            return None;
        }
        // 1 - cos = sin² / (1 + cos) does not cancel.
        let one_minus_cos = sin2 / (1.0 + (1.0 - sin2).sqrt());
        let axis = (way / distance2.sqrt()).as_vec3();
        (one_minus_cos as f32 > 0.0).then(|| Self {
            axis,
            sin: sin2.sqrt() as f32,
            one_minus_cos: one_minus_cos as f32,
        })
    }

    fn pdf(&self) -> f32 {
        1.0 / (2.0 * PI * self.one_minus_cos)
    }
}
