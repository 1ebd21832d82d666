//! Maps from the unit square to where samples are wanted, with their densities.
//!
//! Every map takes two numbers in [0, 1) and keeps near points near, so that
//! well-spread samples stay well spread.
//!
//! Source: Shirley and Chiu 1997 (disk); Pharr, Jakob, Humphreys, *Physically
//! Based Rendering*, 4th ed., appendix A.5.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8};
use rutilant_geom::lanes::{Xyz, Xyz8};
use rutilant_geom::{Vec2, Vec3, real};
use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4, PI};

/// A point on the unit disk, uniform over its area.
pub fn concentric_disk(u: Vec2) -> Vec2 {
    let (radius, angle) = concentric_polar(u);
    let (sin, cos) = real::sin_cos(angle);
    radius * Vec2::new(cos, sin)
}

/// A point in the regular polygon with `corners` corners (three or more) on the unit circle,
/// uniform over its area. One corner points up, to (0, 1).
///
/// The disk's radius and angle become the polygon's: the square of the radius is as even in each
/// of its triangles as it is in the disk, and the angle is spent evenly along each edge.
pub fn concentric_polygon(u: Vec2, corners: u32) -> Vec2 {
    let (radius, angle) = concentric_polar(u);
    // A negative radius is a positive one on the other side.
    let angle = if radius < 0.0 { angle + PI } else { angle };
    let wedge = 2.0 * PI / corners as f32;
    let turns = angle / wedge;
    let which = turns.floor();
    // From the middle of an edge: −1 at one corner, 1 at the next.
    let along = 2.0 * (turns - which) - 1.0;
    let (half_edge, apothem) = real::sin_cos(0.5 * wedge);
    let (sin, cos) = real::sin_cos(FRAC_PI_2 + (which + 0.5) * wedge);
    let (x, y) = (apothem, along * half_edge);
    radius.abs() * Vec2::new(x * cos - y * sin, x * sin + y * cos)
}

/// Radius (which may be negative) and angle of the point of the unit disk that `u` stands for.
fn concentric_polar(u: Vec2) -> (f32, f32) {
    let p = 2.0 * u - Vec2::ONE;
    if p == Vec2::ZERO {
        (0.0, 0.0)
    } else if p.x.abs() > p.y.abs() {
        (p.x, FRAC_PI_4 * (p.y / p.x))
    } else {
        (p.y, FRAC_PI_2 - FRAC_PI_4 * (p.x / p.y))
    }
}

/// A direction with z ≥ 0, in proportion to its cosine with +z.
pub fn cosine_hemisphere(u: Vec2) -> Vec3 {
    let d = concentric_disk(u);
    Vec3::new(d.x, d.y, (1.0 - d.length_squared()).max(0.0).sqrt())
}

/// [`concentric_disk`] for eight.
#[inline(always)]
pub(crate) fn concentric_disks<S: Simd>([x, y]: [f32x8<S>; 2]) -> [f32x8<S>; 2] {
    let simd = x.token();
    let zero = f32x8::splat(simd, 0.0);
    let (px, py) = (x * 2.0 - 1.0, y * 2.0 - 1.0);
    let flat = px.abs().simd_gt(py.abs());
    let radius = flat.select(px, py);
    let centre = px.simd_eq(zero) & py.simd_eq(zero);
    let part = flat.select(py, px) / radius * FRAC_PI_4;
    let angle = flat.select(part, f32x8::splat(simd, FRAC_PI_2) - part);
    let angle = centre.select(zero, angle);
    let (sin, cos) = real::sin_cos_lanes(angle);
    [radius * cos, radius * sin]
}

/// [`cosine_hemisphere`] for eight.
#[inline(always)]
pub(crate) fn cosine_hemispheres<S: Simd>(u: [f32x8<S>; 2]) -> Xyz8<S> {
    let [x, y] = concentric_disks(u);
    let zero = f32x8::splat(x.token(), 0.0);
    let z = (f32x8::splat(x.token(), 1.0) - (x * x + y * y)).max(zero).sqrt();
    Xyz { x, y, z }
}

/// [`uniform_triangle`] for eight.
#[inline(always)]
pub(crate) fn uniform_triangles<S: Simd>([x, y]: [f32x8<S>; 2]) -> [f32x8<S>; 2] {
    let upper = y.simd_gt(x);
    let (half_x, half_y) = (x * 0.5, y * 0.5);
    [upper.select(half_x, x - half_y), upper.select(y - half_x, half_y)]
}

/// The density of [`cosine_hemisphere`] in 1/sr, where `cos` is the direction's z.
pub fn cosine_hemisphere_pdf(cos: f32) -> f32 {
    cos.max(0.0) * FRAC_1_PI
}

/// A direction, uniform over the sphere.
pub fn uniform_sphere(u: Vec2) -> Vec3 {
    from_cosine(1.0 - 2.0 * u.x, 2.0 * (u.x * (1.0 - u.x)).max(0.0).sqrt(), u.y)
}

/// The density of [`uniform_sphere`] in 1/sr.
pub const UNIFORM_SPHERE_PDF: f32 = 0.25 * FRAC_1_PI;

/// A direction with z ≥ 0, uniform over the hemisphere.
pub fn uniform_hemisphere(u: Vec2) -> Vec3 {
    from_cosine(u.x, (1.0 - u.x * u.x).max(0.0).sqrt(), u.y)
}

/// The density of [`uniform_hemisphere`] in 1/sr.
pub const UNIFORM_HEMISPHERE_PDF: f32 = 0.5 * FRAC_1_PI;

/// Barycentric coordinates of the second and third vertex, uniform over a triangle.
///
/// Source: Heitz, "A Low-Distortion Map Between Triangle and Square", 2019.
pub fn uniform_triangle(u: Vec2) -> Vec2 {
    if u.y > u.x {
        let x = 0.5 * u.x;
        Vec2::new(x, u.y - x)
    } else {
        let y = 0.5 * u.y;
        Vec2::new(u.x - y, y)
    }
}

/// A direction from the sine and cosine of its angle with +z, turned around it by `turn` of a circle.
fn from_cosine(cos: f32, sin: f32, turn: f32) -> Vec3 {
    let (s, c) = real::sin_cos(2.0 * PI * turn);
    Vec3::new(sin * c, sin * s, cos)
}
