//! Directions on a latitude-longitude picture, for sky maps and for cameras that see all around.
//!
//! `u = ½ (1 + atan2(x, −z) / π)` runs to the right, `v = acos(y) / π` downwards: +y is the upper
//! edge, −z the middle, +x lies to the right of that.

use rutilant_geom::{Vec2, Vec3, real};
use std::f32::consts::{FRAC_1_PI, PI};

/// The point of the picture that shows a direction of any length but 0; both coordinates in [0, 1).
pub fn uv_from_direction(d: Vec3) -> Vec2 {
    let turn = 0.5 + (0.5 * FRAC_1_PI) * real::atan2(d.x, -d.z);
    // The angle from +y by both legs: an arc cosine would be blind near the poles.
    let (height, away) = (d.y, (d.x * d.x + d.z * d.z).sqrt());
    let down = FRAC_1_PI * real::atan2(away, height);
    const LAST: f32 = 1.0 - 0.5 * f32::EPSILON;
    // A full turn is no turn: the seam belongs to the left edge.
    Vec2::new(if turn >= 1.0 { 0.0 } else { turn.max(0.0) }, down.clamp(0.0, LAST))
}

/// The unit direction that a point of the picture shows. Beyond the left and right edges the
/// picture goes on at the other one, beyond a pole on the other side of it.
pub fn direction_from_uv(uv: Vec2) -> Vec3 {
    let (sin_phi, cos_phi) = real::sin_cos(PI * (2.0 * uv.x - 1.0));
    let (sin_theta, cos_theta) = real::sin_cos(PI * uv.y);
    Vec3::new(sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi)
}

/// How much of the picture a unit of solid angle covers around a unit direction: 1 / (2 π² sin θ).
pub fn uv_per_solid_angle(d: Vec3) -> f32 {
    let sin_theta = (d.x * d.x + d.z * d.z).sqrt();
    0.5 * FRAC_1_PI * FRAC_1_PI / sin_theta
}
