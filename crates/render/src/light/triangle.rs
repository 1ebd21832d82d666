//! Glowing triangles and parallelograms: sampled evenly over their area from afar, over the solid
//! angle that they fill from nearby.
//!
//! Points are combined in double precision and rounded once, so that they lie
//! as close to the surface as a hit does.

use super::bounds::EmitterBounds;
use super::sample::{EmitterSample, Glow, LampPoint, area_to_solid_angle};
use crate::color::Spectrum;
use crate::lanes::mask;
use crate::math::{SphericalTriangle, warp};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, mask32x8};
use rutilant_geom::lanes::{LANES, Xyz8, narrow, widen};
use rutilant_geom::{DVec3, Vec2, Vec3, each, offset_ends};

/// A glowing triangle; its front is where the corners run counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleEmitter {
    flat: FlatEmitter,
}

impl TriangleEmitter {
    /// A triangle without area gives no light.
    pub fn new(corners: [Vec3; 3], glow: Glow) -> Self {
        Self { flat: FlatEmitter::new(corners, glow, true) }
    }

    /// Its light.
    pub fn glow(&self) -> &Glow {
        &self.flat.glow
    }

    /// What it is.
    pub(super) fn flat(&self) -> &FlatEmitter {
        &self.flat
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
        Self { flat: FlatEmitter::new(corners, glow, false) }
    }

    /// Its light.
    pub fn glow(&self) -> &Glow {
        &self.flat.glow
    }

    /// What it is.
    pub(super) fn flat(&self) -> &FlatEmitter {
        &self.flat
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
    middle: Vec3,
    /// The square of the distance from there within which it counts as near: that of its longest
    /// side. From farther off, even density over its area is as good, and costs less.
    near2: f32,
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
        middle: Vec3::ZERO,
        near2: 0.0,
    };

    fn new(corners: [Vec3; 3], glow: Glow, is_triangle: bool) -> Self {
        let [a, b, c] = corners;
        let (normal, parallelogram) = normal_and_size(corners);
        let area = if is_triangle { 0.5 * parallelogram } else { parallelogram };
        let part = if is_triangle { 1.0 / 3.0 } else { 0.5 };
        let sides2 = (b - a).length_squared().max((c - a).length_squared());
        Self {
            corners,
            normal,
            area,
            glow,
            is_triangle,
            middle: combine(corners, Vec2::splat(part)),
            near2: if is_triangle { sides2.max((c - b).length_squared()) } else { sides2 },
        }
    }

    pub(super) fn area(&self) -> f32 {
        self.area
    }

    pub(super) fn power(&self) -> Spectrum {
        self.glow.power(self.area)
    }

    pub(super) fn bounds(&self) -> EmitterBounds {
        let [a, b, c] = self.corners.map(Vec3::as_dvec3);
        let fourth = if self.is_triangle { a } else { b + c - a };
        let (low, high) = (a.min(b).min(c).min(fourth), a.max(b).max(c).max(fourth));
        let intensity = self.glow.intensity(f64::from(self.area));
        EmitterBounds::flat(low, high, self.normal, intensity).shining_back(self.glow.two_sided)
    }

    pub(super) fn point(&self, u: Vec2) -> LampPoint {
        let at = if self.is_triangle { warp::uniform_triangle(u) } else { u };
        LampPoint { position: combine(self.corners, at), normal: self.normal }
    }

    /// Whether it is so near that it is sampled by solid angle.
    pub(crate) fn is_near(&self, from: Vec3) -> bool {
        self.middle.distance_squared(from) < self.near2
    }

    /// The triangles that it is on the sphere of directions around `from`, where it is near, and
    /// their solid angle together, in sr.
    fn seen(&self, from: Vec3) -> Option<([SphericalTriangle; 2], f32)> {
        if !self.is_near(from) {
            return None;
        }
        let from = from.as_dvec3();
        let [a, b, c] = self.corners.map(|corner| corner.as_dvec3() - from);
        let first = SphericalTriangle::seen([a, b, c]);
        let second = if self.is_triangle {
            SphericalTriangle::NONE
        } else {
            SphericalTriangle::seen([b + c - a, c, b])
        };
        let all = first.solid_angle + second.solid_angle;
        // Not edge-on, nor from a corner.
        (all > 1e-4).then_some(([first, second], all))
    }

    pub(super) fn sample(&self, from: Vec3, u: Vec2) -> Option<EmitterSample> {
        let Some(([first, second], all)) = self.seen(from) else {
            let LampPoint { position, normal } = self.point(u);
            return self.glow.sample_at(from, position, normal, self.area);
        };
        let beyond = u.x * all - first.solid_angle;
        let wi = if beyond < 0.0 || second.solid_angle == 0.0 {
            first.sample(Vec2::new(u.x * all / first.solid_angle, u.y))
        } else {
            second.sample(Vec2::new(beyond / second.solid_angle, u.y))
        };
        let position = combine(self.corners, self.meet(from, wi)?);
        let way = self.glow.sample_at(from, position, self.normal, self.area)?;
        Some(EmitterSample { pdf: 1.0 / all, ..way })
    }

    /// Where its plane is met along `wi`: the parts of the way from the first corner to the others.
    fn meet(&self, from: Vec3, wi: DVec3) -> Option<Vec2> {
        let [a, b, c] = self.corners.map(Vec3::as_dvec3);
        let (across, along, way) = (b - a, c - a, from.as_dvec3() - a);
        let side = wi.cross(along);
        let parts = [way.dot(side), wi.dot(way.cross(across))].map(|x| x / across.dot(side));
        let at = Vec2::from(parts.map(|x| x as f32));
        at.is_finite().then(|| at.clamp(Vec2::ZERO, Vec2::ONE))
    }

    pub(super) fn pdf(&self, from: Vec3, wi: Vec3, position: Vec3, normal: Vec3) -> f32 {
        match self.seen(from) {
            Some((_, solid_angle)) => 1.0 / solid_angle,
            None => area_to_solid_angle(1.0 / self.area, position - from, wi, normal),
        }
    }

    /// Draws ways to these lights, none of them near, from eight points.
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
