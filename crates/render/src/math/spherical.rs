//! Triangles on the unit sphere: how large they are, and points drawn evenly from them.
//!
//! Source: Van Oosterom and Strackee, "The Solid Angle of a Plane Triangle", IEEE Trans. Biomed.
//! Eng. 30(2), 1983; Arvo, "Stratified Sampling of Spherical Triangles", SIGGRAPH 1995.

use rutilant_geom::{DVec3, Vec2, real};

/// The triangle between three directions, less than a half-sphere.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SphericalTriangle {
    /// Unit vectors.
    corners: [DVec3; 3],
    /// In sr.
    pub(crate) solid_angle: f32,
}

impl SphericalTriangle {
    /// No triangle.
    pub(crate) const NONE: Self = Self { corners: [DVec3::ZERO; 3], solid_angle: 0.0 };

    /// As a triangle is seen from the origin. Its solid angle is no number where that is a corner.
    pub(crate) fn seen(corners: [DVec3; 3]) -> Self {
        let [a, b, c] = corners.map(|corner| corner / corner.length());
        // The tangent of half of it, as two legs.
        let (height, base) = (a.dot(b.cross(c)).abs(), 1.0 + a.dot(b) + b.dot(c) + c.dot(a));
        Self { corners: [a, b, c], solid_angle: 2.0 * real::atan2(height as f32, base as f32) }
    }

    /// The direction that stands for `u` in [0, 1)²: all have the same density.
    ///
    /// Arvo's map, by half angles: no small number is the difference of large ones, so that slivers
    /// are drawn from as evenly as all others.
    pub(crate) fn sample(&self, u: Vec2) -> DVec3 {
        let [a, b, c] = self.corners;
        // The angle α at the first corner, between its two sides.
        let (side, other) = (a.cross(b), a.cross(c));
        let per_length = 1.0 / (side.length_squared() * other.length_squared()).sqrt();
        let cos_alpha = side.dot(other) * per_length;
        let sin_alpha = side.cross(other).length() * per_length;
        // How far towards c the side from b must end for the part `u.x` of the triangle to be left:
        // the tangent of half that arc.
        let (sin, cos) = real::sin_cos(0.5 * u.x * self.solid_angle);
        let (sin, cos) = (f64::from(sin), f64::from(cos));
        let half_side = side.length() / (1.0 + a.dot(b));
        let tan = sin / (half_side * (sin_alpha * cos - cos_alpha * sin));
        let half = tan / (1.0 + tan * tan).sqrt();
        let end = along(a, c, half);
        // A point on the arc from b to there.
        along(b, end, 0.5 * (end - b).length() * f64::from(u.y).sqrt())
    }
}

/// The unit vector on the arc from `from` towards `to`, so far that the sine of half the way is
/// `half`.
fn along(from: DVec3, to: DVec3, half: f64) -> DVec3 {
    let half = half.clamp(0.0, 1.0);
    let across = (to - from * to.dot(from)).normalize_or_zero();
    from * (1.0 - 2.0 * half * half) + across * (2.0 * half * (1.0 - half * half).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::PI;

    /// An eighth of the sphere; a thin sliver by its area; a triangle that nearly fills a half.
    #[test]
    fn solid_angles_are_those_of_known_triangles() {
        let seen =
            |corners: [[f64; 3]; 3]| SphericalTriangle::seen(corners.map(DVec3::from)).solid_angle;
        let eighth = seen([[2.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 0.5]]);
        assert!((eighth - 0.5 * PI).abs() < 1e-6, "{eighth}");
        let sliver = seen([[0.0, 0.0, 100.0], [0.01, 0.0, 100.0], [0.0, 1.0, 100.0]]);
        assert!((sliver / (0.5 * 0.01 * 1e-4) - 1.0).abs() < 1e-3, "{sliver}");
        let half = seen([[1e3, 0.0, 0.1], [-1e3, 1e3, 0.1], [-1e3, -1e3, 0.1]]);
        assert!((half - 2.0 * PI).abs() < 1e-2, "{half}");
        assert!(seen([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]).is_nan());
    }

    /// Samples fall inside, and their even density shows in the means of what is known over the
    /// triangle by its flat surface: ∫ cos θ / d² dA for several functions of the point.
    #[test]
    fn samples_are_even() {
        let triangles = [
            [[0.2, -0.3, 0.5], [1.7, 0.1, 0.6], [0.3, 2.0, 0.4]],
            [[-2.0, -1.0, 0.2], [3.0, -1.0, 0.2], [0.0, 4.0, 0.2]],
            [[0.0, 0.0, 1.0], [0.05, 0.0, 1.0], [0.0, 3.0, 1.0]],
            // Slivers, from each of their corners, and one seen nearly edge-on.
            [[0.0, 0.0, 0.5], [2e-4, 0.0, 0.5], [0.0, 3.0, 0.5]],
            [[2e-4, 0.0, 0.5], [0.0, 3.0, 0.5], [0.0, 0.0, 0.5]],
            [[0.0, 3.0, 0.5], [0.0, 0.0, 0.5], [2e-4, 0.0, 0.5]],
            [[-1.5, 0.0, 0.5], [1.5, 0.0, 0.5], [1.5, 3e-4, 0.5]],
            [[0.3, -1.0, 1e-3], [0.5, 1.0, 2e-3], [1.5, 0.2, 1e-3]],
        ];
        for corners in triangles.map(|t| t.map(DVec3::from)) {
            let [a, b, c] = corners;
            let triangle = SphericalTriangle::seen(corners);
            let normal = (b - a).cross(c - a);
            let functions = |d: DVec3| [1.0, d.x, d.y, d.z * d.z, d.x * d.y];
            let (mut expected, n) = ([0.0; 5], 2000);
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let mut at = [i, j].map(|k| (f64::from(k) + 0.5) / f64::from(n));
                if at[0] + at[1] > 1.0 {
                    at = at.map(|x| 1.0 - x);
                }
                let p = a + (b - a) * at[0] + (c - a) * at[1];
                let distance3 = p.length_squared() * p.length();
                let weight = p.dot(normal).abs() / distance3 / (2.0 * f64::from(n * n));
                for (sum, f) in expected.iter_mut().zip(functions(p.normalize())) {
                    *sum += f * weight;
                }
            }
            let (mut found, m) = ([0.0; 5], 500);
            for (i, j) in (0..m).flat_map(|i| (0..m).map(move |j| (i, j))) {
                let d = triangle.sample((Vec2::new(i as f32, j as f32) + 0.5) / m as f32);
                assert!((d.length() - 1.0).abs() < 1e-9);
                // Inside, by the part that each corner has in it.
                let parts = [(a, b, c), (b, c, a), (c, a, b)]
                    .map(|(corner, x, y)| d.dot(x.cross(y)) / corner.dot(x.cross(y)));
                let least = parts.into_iter().fold(f64::INFINITY, f64::min);
                assert!(least > -1e-5 * parts.iter().sum::<f64>(), "{corners:?}: {parts:?}");
                let part = f64::from(triangle.solid_angle) / f64::from(m * m);
                for (sum, f) in found.iter_mut().zip(functions(d)) {
                    *sum += f * part;
                }
            }
            for (found, expected) in found.into_iter().zip(expected) {
                let error = (found - expected) / f64::from(triangle.solid_angle);
                assert!(error.abs() < 2e-3, "{corners:?}: {found} for {expected}");
            }
        }
    }
}
