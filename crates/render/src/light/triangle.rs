//! Glowing triangles and parallelograms, sampled uniformly over their area.
//!
//! Points are combined in double precision and rounded once, so that they lie
//! as close to the surface as a hit does.

use super::sample::{EmitterSample, Glow, area_to_solid_angle};
use crate::color::Spectrum;
use crate::math::warp;
use rutilant_geom::{Vec2, Vec3};

/// A glowing triangle; its front is where the corners run counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleEmitter {
    corners: [Vec3; 3],
    normal: Vec3,
    area: f32,
    glow: Glow,
}

impl TriangleEmitter {
    /// A triangle without area gives no light.
    pub fn new(corners: [Vec3; 3], glow: Glow) -> Self {
        let (normal, doubled) = normal_and_size(corners);
        Self { corners, normal, area: 0.5 * doubled, glow }
    }

    /// Its light.
    pub fn glow(&self) -> &Glow {
        &self.glow
    }

    pub(super) fn sample(&self, from: Vec3, u: Vec2) -> Option<EmitterSample> {
        let point = combine(self.corners, warp::uniform_triangle(u));
        self.glow.sample_at(from, point, self.normal, self.area)
    }

    pub(super) fn pdf(&self, from: Vec3, wi: Vec3, position: Vec3, normal: Vec3) -> f32 {
        area_to_solid_angle(1.0 / self.area, position - from, wi, normal)
    }

    pub(super) fn power(&self) -> Spectrum {
        self.glow.power(self.area)
    }
}

/// A glowing parallelogram: a corner and its two neighbours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParallelogramEmitter {
    corners: [Vec3; 3],
    normal: Vec3,
    area: f32,
    glow: Glow,
}

impl ParallelogramEmitter {
    /// A parallelogram without area gives no light.
    pub fn new(corners: [Vec3; 3], glow: Glow) -> Self {
        let (normal, area) = normal_and_size(corners);
        Self { corners, normal, area, glow }
    }

    /// Its light.
    pub fn glow(&self) -> &Glow {
        &self.glow
    }

    pub(super) fn sample(&self, from: Vec3, u: Vec2) -> Option<EmitterSample> {
        self.glow.sample_at(from, combine(self.corners, u), self.normal, self.area)
    }

    pub(super) fn pdf(&self, from: Vec3, wi: Vec3, position: Vec3, normal: Vec3) -> f32 {
        area_to_solid_angle(1.0 / self.area, position - from, wi, normal)
    }

    pub(super) fn power(&self) -> Spectrum {
        self.glow.power(self.area)
    }
}

/// The unit normal of the plane through three points, and the area of their parallelogram: 0
/// where it is none, or no number.
fn normal_and_size([a, b, c]: [Vec3; 3]) -> (Vec3, f32) {
    let (a, b, c) = (a.as_dvec3(), b.as_dvec3(), c.as_dvec3());
    let cross = (b - a).cross(c - a);
    let area = cross.length() as f32;
    let area = if area.is_finite() { area } else { 0.0 };
    (cross.normalize_or_zero().as_vec3(), area)
}

/// The point at the given parts of the way from the first corner to the others.
fn combine([a, b, c]: [Vec3; 3], at: Vec2) -> Vec3 {
    let (a, b, c) = (a.as_dvec3(), b.as_dvec3(), c.as_dvec3());
    (a + (b - a) * f64::from(at.x) + (c - a) * f64::from(at.y)).as_vec3()
}
