//! Directions on a square that is folded from an octahedron, every part of it in proportion to its
//! solid angle.
//!
//! The middle of the square is +z, the middles of its right and lower edges are +x and +y, and all
//! four corners are −z: the coordinates of pbrt-v4's maps. Each edge is folded in its middle, and
//! meets itself.
//!
//! Source: Clarberg, "Fast Equal-Area Mapping of the (Hemi)Sphere using SIMD", Journal of Graphics
//! Tools 13(3), 2008.

use rutilant_geom::{Vec2, Vec3, real};
use std::f32::consts::{FRAC_1_PI, FRAC_2_PI, FRAC_PI_2};

/// How much of the square a unit of solid angle covers, everywhere.
pub const UV_PER_SOLID_ANGLE: f32 = 0.25 * FRAC_1_PI;

/// The point of the square that shows a unit direction; both coordinates in [0, 1).
pub fn uv_from_direction(d: Vec3) -> Vec2 {
    let [x, y, z] = d.abs().to_array();
    // √(1 − |z|) without its cancellation near the poles.
    let radius = ((x * x + y * y) / (1.0 + z)).sqrt().min(1.0);
    // The angle from the x axis, as a part of a quarter turn, is spent evenly along |u| + |v| = r.
    let v = radius * (FRAC_2_PI * real::atan2(y, x));
    let upper = Vec2::new(radius - v, v);
    let folded = if d.z < 0.0 { Vec2::ONE - Vec2::new(upper.y, upper.x) } else { upper };
    const LAST: f32 = 1.0 - 0.5 * f32::EPSILON;
    let signed = Vec2::new(folded.x.copysign(d.x), folded.y.copysign(d.y));
    (0.5 * signed + 0.5).clamp(Vec2::ZERO, Vec2::splat(LAST))
}

/// The unit direction that a point of the square shows.
pub fn direction_from_uv(uv: Vec2) -> Vec3 {
    let signed = 2.0 * uv - Vec2::ONE;
    let [u, v] = signed.abs().to_array();
    // Inside the diamond |u| + |v| = 1 is the upper half, the corners are the lower one.
    let inside = 1.0 - (u + v);
    let radius = 1.0 - inside.abs();
    let along = if inside >= 0.0 { v } else { 1.0 - u };
    let quarter = if radius > 0.0 { (along / radius).clamp(0.0, 1.0) } else { 0.0 };
    let (sin, cos) = real::sin_cos(FRAC_PI_2 * quarter);
    let away = radius * (2.0 - radius * radius).max(0.0).sqrt();
    Vec3::new(
        (away * cos).copysign(signed.x),
        (away * sin).copysign(signed.y),
        (1.0 - radius * radius).copysign(inside),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Places of pbrt's square and their directions, worked out by hand from |u| + |v| = r,
    /// z = 1 − r²: the middle, the edges, the corners, and points half way.
    #[test]
    fn places_are_those_of_pbrt() {
        let half = 0.5_f32.sqrt();
        // r = ½: z = ¾, and √7 / 4 is left for the others.
        let side = 7.0_f32.sqrt() / 4.0;
        for (uv, d) in [
            ([0.5, 0.5], [0.0, 0.0, 1.0]),
            ([1.0, 0.5], [1.0, 0.0, 0.0]),
            ([0.0, 0.5], [-1.0, 0.0, 0.0]),
            ([0.5, 1.0], [0.0, 1.0, 0.0]),
            ([0.5, 0.0], [0.0, -1.0, 0.0]),
            ([0.0, 0.0], [0.0, 0.0, -1.0]),
            ([1.0, 1.0], [0.0, 0.0, -1.0]),
            ([0.75, 0.75], [half, half, 0.0]),
            ([0.25, 0.75], [-half, half, 0.0]),
            ([0.75, 0.5], [side, 0.0, 0.75]),
            ([0.5, 0.25], [0.0, -side, 0.75]),
            ([1.0, 0.75], [side, 0.0, -0.75]),
            ([0.75, 0.0], [0.0, -side, -0.75]),
        ] {
            let (uv, d) = (Vec2::from(uv), Vec3::from(d));
            let found = direction_from_uv(uv);
            assert!((found - d).length() < 1e-6, "{uv}: {found}, expected {d}");
            let back = uv_from_direction(d);
            // An edge is folded onto itself, and the corners are one point.
            let seen = direction_from_uv(back);
            assert!((seen - d).length() < 1e-6, "{d}: {back}, expected {uv}");
            if uv.cmpgt(Vec2::ZERO).all() && uv.cmplt(Vec2::ONE).all() {
                assert!((back - uv).length() < 1e-6, "{d}: {back}, expected {uv}");
            }
        }
    }

    /// There and back again, all over the square; directions have length 1.
    #[test]
    fn directions_lead_back() {
        for i in 0..63 * 63 {
            let uv = Vec2::new((i % 63) as f32 + 0.5, (i / 63) as f32 + 0.5) / 63.0;
            let d = direction_from_uv(uv);
            assert!((d.length() - 1.0).abs() < 1e-6, "{uv}: {d}");
            let back = uv_from_direction(d);
            assert!((back - uv).length() < 2e-6, "{uv}: {d} leads to {back}");
        }
    }
}
