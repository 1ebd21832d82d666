//! A glowing disk or ellipse, sampled uniformly over its area.

use super::bounds::EmitterBounds;
use super::sample::{EmitterSample, Glow, LampPoint, area_to_solid_angle};
use crate::color::Spectrum;
use crate::math::warp;
use rutilant_geom::{Disk, Vec2, Vec3};
use std::f32::consts::PI;

/// All points `center + a u + b v` with `a² + b² ≤ 1`; the front is where `u × v` points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiskEmitter {
    disk: Disk,
    normal: Vec3,
    area: f32,
    glow: Glow,
}

impl DiskEmitter {
    /// A disk without area gives no light.
    pub fn new(disk: Disk, glow: Glow) -> Self {
        let cross = disk.u.as_dvec3().cross(disk.v.as_dvec3());
        let area = cross.length() as f32 * PI;
        let normal = cross.normalize_or_zero().as_vec3();
        Self { disk, normal, area: if area.is_finite() { area } else { 0.0 }, glow }
    }

    /// Its light.
    pub fn glow(&self) -> &Glow {
        &self.glow
    }

    pub(super) fn area(&self) -> f32 {
        self.area
    }

    pub(super) fn bounds(&self) -> EmitterBounds {
        let Disk { center, u, v } = self.disk;
        let (center, u, v) = (center.as_dvec3(), u.as_dvec3(), v.as_dvec3());
        // How far an ellipse extends along an axis.
        let reach = (u * u + v * v).map(f64::sqrt);
        let intensity = self.glow.intensity(f64::from(self.area));
        EmitterBounds::flat(center - reach, center + reach, self.normal, intensity)
            .shining_back(self.glow.two_sided)
    }

    pub(super) fn point(&self, u: Vec2) -> LampPoint {
        let at = warp::concentric_disk(u).as_dvec2();
        let Disk { center, u, v } = self.disk;
        let point = center.as_dvec3() + u.as_dvec3() * at.x + v.as_dvec3() * at.y;
        LampPoint { position: point.as_vec3(), normal: self.normal }
    }

    pub(super) fn sample(&self, from: Vec3, u: Vec2) -> Option<EmitterSample> {
        let LampPoint { position, normal } = self.point(u);
        self.glow.sample_at(from, position, normal, self.area)
    }

    pub(super) fn pdf(&self, from: Vec3, wi: Vec3, position: Vec3, normal: Vec3) -> f32 {
        area_to_solid_angle(1.0 / self.area, position - from, wi, normal)
    }

    pub(super) fn power(&self) -> Spectrum {
        self.glow.power(self.area)
    }
}
