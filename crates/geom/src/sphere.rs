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
use crate::{Aabb, Ray, Vec3};
use glam::DVec3;

/// All points at distance `radius` from `center`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// The middle.
    pub center: Vec3,
    /// Greater than zero; otherwise there is no sphere, and nothing meets it.
    pub radius: f32,
}

impl Sphere {
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
        let (first, second) = if t0 < t1 { (t0, t1) } else { (t1, t0) };
        let inside = |t: &f64| *t > f64::from(ray.t_min) && *t < f64::from(ray.t_max);
        Some(first).filter(inside).or(Some(second).filter(inside))
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
