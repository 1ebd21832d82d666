//! A ray meets a sphere, robust for spheres near and far, tiny and huge.
//!
//! The usual quadratic formula loses its digits when the sphere is small and
//! far (the discriminant is a small difference) or when one root is near zero
//! (so is the numerator). Here the discriminant comes from the distance of the
//! centre to the ray, and the small root from the product of the roots.
//!
//! Source: Haines, Günther, Akenine-Möller, "Precision Improvements for
//! Ray/Sphere Intersection", *Ray Tracing Gems*, 2019, chapter 7.

use crate::aabb::{rounded_down, rounded_up};
use crate::{Aabb, Ray, Vec3, real};
use glam::DVec3;
use std::f32::consts::{FRAC_1_PI, PI};

/// All points at distance `radius` from `center`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// The middle.
    pub center: Vec3,
    /// Greater than zero; otherwise there is no sphere, and nothing meets it.
    pub radius: f32,
}

impl Sphere {
    /// Longitude and latitude of where this unit vector points, as [`Hit::u`](crate::Hit::u) and
    /// [`Hit::v`](crate::Hit::v) are.
    pub fn uv(normal: Vec3) -> [f32; 2] {
        let Vec3 { x, y, z } = normal;
        [0.5 + 0.5 * FRAC_1_PI * real::atan2(x, z), real::acos(-y.clamp(-1.0, 1.0)) / PI]
    }

    /// The smallest box that surely holds the sphere.
    pub fn bounds(&self) -> Aabb {
        let (center, radius) = (self.center.as_dvec3(), DVec3::splat(f64::from(self.radius)));
        Aabb { min: rounded_down(center - radius), max: rounded_up(center + radius) }
    }

    /// True if it has an area and all its numbers are finite.
    pub fn is_proper(&self) -> bool {
        self.radius > 0.0 && self.radius.is_finite() && self.center.is_finite()
    }

    /// The first `t` with `t_min < t < t_max` at which the ray meets the sphere,
    /// from outside or from inside.
    ///
    /// An origin that lies on the sphere to within the rounding of double
    /// precision does not meet it there, only on the other side.
    pub fn intersect(&self, ray: &Ray) -> Option<f64> {
        self.crossings(ray)?
            .into_iter()
            .find(|t| *t > f64::from(ray.t_min) && *t < f64::from(ray.t_max))
    }

    /// Both places where the line of a ray crosses the sphere, the lesser `t` first; both may lie
    /// before the ray's start or beyond its end.
    #[inline]
    pub(crate) fn crossings(&self, ray: &Ray) -> Option<[f64; 2]> {
        let r = f64::from(self.radius);
        let d = ray.direction.as_dvec3();
        let f = ray.origin.as_dvec3() - self.center.as_dvec3();
        let a = d.dot(d);
        let b = -f.dot(d);
        if !(r > 0.0 && a > 0.0) {
            return None;
        }

        // Where the origin lies: outside above zero, inside below. Within the
        // rounding of this and of the hit the ray may start from, it is on the sphere.
        let c = f.dot(f) - r * r;
        let c = if c.abs() <= 16.0 * f64::EPSILON * r * r { 0.0 } else { c };

        // The distance of the centre to the ray decides; from inside there is no doubt.
        let nearest = f + d * (b / a);
        let discriminant = r * r - nearest.dot(nearest);
        let discriminant = if c <= 0.0 { discriminant.max(0.0) } else { discriminant };
        if discriminant < 0.0 {
            return None;
        }

        // a t² - 2 b t + c = 0; the root of larger size first, the other from c.
        let q = b + (a * discriminant).sqrt().copysign(b);
        let (t0, t1) = (c / q, q / a);
        Some(if t0 < t1 { [t0, t1] } else { [t1, t0] })
    }

    /// The point of the sphere at `t` on the ray, a hit, and the outward unit normal there.
    ///
    /// The point is moved onto the sphere in double precision.
    pub fn surface_at(&self, ray: &Ray, t: f64) -> (DVec3, DVec3) {
        let center = self.center.as_dvec3();
        let normal = ((ray.origin.as_dvec3() - center) + ray.direction.as_dvec3() * t)
            .normalize_or(DVec3::Y);
        (center + normal * f64::from(self.radius), normal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tiny sphere far away and a huge one close by: where the formula of school is
    /// off by whole radii, this one is right to a part in 10⁶ of the radius or of `t`.
    #[test]
    fn spheres_near_and_far_tiny_and_huge() {
        for (distance, radius) in [(1e7, 1e-3), (1e6, 0.5), (2e6_f32, 1e6_f32), (1.0, 1e-7)] {
            let sphere = Sphere { center: Vec3::new(0.0, 0.0, distance), radius };
            let surface = f64::from(distance) - f64::from(radius);
            let t = sphere.intersect(&Ray::new(Vec3::ZERO, Vec3::Z)).expect("a hit");
            assert!((t - surface).abs() <= 1e-6 * f64::from(radius), "{distance} {radius}: {t}");
            let beside = Vec3::new(radius * 1.000_01, 0.0, 0.0);
            assert_eq!(sphere.intersect(&Ray::new(beside, Vec3::Z)), None);
            let within = Vec3::new(radius * 0.999_99, 0.0, 0.0);
            assert!(sphere.intersect(&Ray::new(within, Vec3::Z)).is_some());
        }
    }

    /// From inside the far side is met, from the surface only the other one, and the
    /// ends of the ray do not count.
    #[test]
    fn the_first_point_ahead_is_met() {
        let sphere = Sphere { center: Vec3::ZERO, radius: 2.0 };
        let from = |z: f32| Ray::new(Vec3::new(0.0, 0.0, z), Vec3::Z * 2.0);
        let met = [-4.0, -2.0, 0.0, 1.0, 2.0, 3.0].map(|z| sphere.intersect(&from(z)));
        assert_eq!(met, [Some(1.0), Some(2.0), Some(1.0), Some(0.5), None, None]);
        let ray = from(-4.0);
        let t_of = |t_min, t_max| sphere.intersect(&Ray { t_min, t_max, ..ray });
        assert_eq!([t_of(0.0, 1.0), t_of(1.0, 3.0), t_of(1.0, 3.1)], [None, None, Some(3.0)]);
    }
}
