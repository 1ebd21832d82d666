//! Glowing triangles and parallelograms, sampled uniformly over their area.
//!
//! Points are combined in double precision and rounded once, so that they lie
//! as close to the surface as a hit does.

use super::sample::{EmitterSample, Glow, LampPoint, area_to_solid_angle};
use crate::color::Spectrum;
use crate::lanes::mask;
use crate::math::warp;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, mask32x8};
use rutilant_geom::lanes::{LANES, Xyz8, narrow, widen};
use rutilant_geom::{Vec2, Vec3, each, offset_ends};

/// A glowing triangle; its front is where the corners run counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleEmitter {
    flat: FlatEmitter,
}

impl TriangleEmitter {
    /// A triangle without area gives no light.
    pub fn new(corners: [Vec3; 3], glow: Glow) -> Self {
        let (normal, doubled) = normal_and_size(corners);
        let area = 0.5 * doubled;
        Self { flat: FlatEmitter { corners, normal, area, glow, is_triangle: true } }
    }

    /// Its light.
    pub fn glow(&self) -> &Glow {
        &self.flat.glow
    }

    pub(super) fn sample(&self, from: Vec3, u: Vec2) -> Option<EmitterSample> {
        self.flat.sample(from, u)
    }

    pub(super) fn pdf(&self, from: Vec3, wi: Vec3, position: Vec3, normal: Vec3) -> f32 {
        area_to_solid_angle(1.0 / self.flat.area, position - from, wi, normal)
    }

    /// What it is.
    pub(super) fn flat(&self) -> &FlatEmitter {
        &self.flat
    }

    pub(super) fn power(&self) -> Spectrum {
        self.flat.glow.power(self.flat.area)
    }
}

/// A glowing parallelogram: a corner and its two neighbours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParallelogramEmitter {
    flat: FlatEmitter,
}

impl ParallelogramEmitter {
    /// A parallelogram without area gives no light.
    pub fn new(corners: [Vec3; 3], glow: Glow) -> Self {
        let (normal, area) = normal_and_size(corners);
        Self { flat: FlatEmitter { corners, normal, area, glow, is_triangle: false } }
    }

    /// Its light.
    pub fn glow(&self) -> &Glow {
        &self.flat.glow
    }

    pub(super) fn sample(&self, from: Vec3, u: Vec2) -> Option<EmitterSample> {
        self.flat.sample(from, u)
    }

    pub(super) fn pdf(&self, from: Vec3, wi: Vec3, position: Vec3, normal: Vec3) -> f32 {
        area_to_solid_angle(1.0 / self.flat.area, position - from, wi, normal)
    }

    /// What it is.
    pub(super) fn flat(&self) -> &FlatEmitter {
        &self.flat
    }

    pub(super) fn power(&self) -> Spectrum {
        self.flat.glow.power(self.flat.area)
    }
}

/// What both have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FlatEmitter {
    corners: [Vec3; 3],
    normal: Vec3,
    area: f32,
    glow: Glow,
    is_triangle: bool,
}

/// Ways to eight lights, as in [`EmitterSample`].
pub(crate) struct WaysToFlat<S: Simd> {
    pub(crate) wi: Xyz8<S>,
    pub(crate) radiance: Xyz8<S>,
    pub(crate) pdf: f32x8<S>,
    pub(crate) end: Xyz8<S>,
    /// False where no light arrives.
    pub(crate) some: mask32x8<S>,
}

impl FlatEmitter {
    /// For lanes that have none.
    pub(crate) const NONE: Self = Self {
        corners: [Vec3::ZERO; 3],
        normal: Vec3::ZERO,
        area: 0.0,
        glow: Glow { radiance: Spectrum::BLACK, two_sided: false },
        is_triangle: false,
    };

    pub(super) fn area(&self) -> f32 {
        self.area
    }

    pub(super) fn point(&self, u: Vec2) -> LampPoint {
        let at = if self.is_triangle { warp::uniform_triangle(u) } else { u };
        LampPoint { position: combine(self.corners, at), normal: self.normal }
    }

    fn sample(&self, from: Vec3, u: Vec2) -> Option<EmitterSample> {
        let LampPoint { position, normal } = self.point(u);
        self.glow.sample_at(from, position, normal, self.area)
    }

    /// Draws ways to these lights from eight points.
    #[inline(always)]
    pub(crate) fn sample_all<S: Simd>(
        simd: S,
        lights: &[&Self; LANES],
        from: Xyz8<S>,
        u: [f32x8<S>; 2],
    ) -> WaysToFlat<S> {
        let mut corners = [[[0.0; LANES]; 3]; 3];
        let (mut normal, mut radiance) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
        let mut area = [0.0; LANES];
        let (mut triangles, mut two_sided) = (0, 0);
        for (lane, light) in lights.iter().enumerate() {
            let emitted = light.glow.radiance.channels();
            for (lanes, corner) in corners.iter_mut().zip(light.corners) {
                for axis in 0..3 {
                    lanes[axis][lane] = corner[axis];
                }
            }
            for axis in 0..3 {
                normal[axis][lane] = light.normal[axis];
                radiance[axis][lane] = emitted[axis];
            }
            area[lane] = light.area;
            triangles |= u32::from(light.is_triangle) << lane;
            two_sided |= u32::from(light.glow.two_sided) << lane;
        }
        let (normal, radiance) = (Xyz8::load(simd, &normal), Xyz8::load(simd, &radiance));
        let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
        let infinity = f32x8::splat(simd, f32::INFINITY);

        // A point on each, combined in double precision and rounded once.
        let [tx, ty] = warp::uniform_triangles(u);
        let triangle = mask(simd, triangles);
        let x = widen(triangle.select(tx, u[0]));
        let y = widen(triangle.select(ty, u[1]));
        let [a, b, c] = corners;
        let (a, b, c) = (Xyz8::load(simd, &a), Xyz8::load(simd, &b), Xyz8::load(simd, &c));
        let (a, b, c) = (each!(a, v => widen(v)), each!(b, v => widen(v)), each!(c, v => widen(v)));
        let point = a + (b - a).scaled(x) + (c - a).scaled(y);
        let point = each!(point, v => narrow(v));

        // Seen from there.
        let way = point - from;
        let per_length = one / way.dot(way).sqrt();
        let wi = way.scaled(per_length);
        let front = wi.negated().dot(normal).simd_gt(zero) | mask(simd, two_sided);
        let cos = wi.dot(normal).abs();
        let area: f32x8<S> = area.simd_into(simd);
        let pdf = (one / area) * way.dot(way) / cos;
        let some = per_length.simd_gt(zero)
            & per_length.simd_lt(infinity)
            & front
            & !radiance.is_zero()
            & cos.simd_gt(zero)
            & pdf.simd_gt(zero)
            & pdf.simd_lt(infinity);
        WaysToFlat { wi, radiance, pdf, end: offset_ends(point, normal, from), some }
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
