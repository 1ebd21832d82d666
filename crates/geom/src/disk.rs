//! A ray meets a disk, round or stretched.
//!
//! The plane through the centre first, then the place in the disk's own two
//! axes. Any affine image of a disk is again one, also an ellipse.

use crate::aabb::{rounded_down, rounded_up};
use crate::{Aabb, Ray, Vec3};
use glam::DVec3;

/// All points `center + a u + b v` with a² + b² <= 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disk {
    /// The middle.
    pub center: Vec3,
    /// From the middle to the rim.
    pub u: Vec3,
    /// From the middle to the rim; not parallel to `u`, but at any other angle.
    /// The front is where `u × v` points to.
    pub v: Vec3,
}

/// Where a ray met a disk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiskHit {
    /// Distance along the ray, in lengths of its direction.
    pub t: f64,
    /// The hit is at `center + a u + b v`.
    pub a: f64,
    /// See `a`.
    pub b: f64,
}

impl Disk {
    /// The smallest box that surely holds the disk.
    pub fn bounds(&self) -> Aabb {
        let (u, v) = (self.u.as_dvec3(), self.v.as_dvec3());
        let squared = u * u + v * v;
        let reach = DVec3::new(squared.x.sqrt(), squared.y.sqrt(), squared.z.sqrt());
        let center = self.center.as_dvec3();
        Aabb { min: rounded_down(center - reach), max: rounded_up(center + reach) }
    }

    /// True if it has an area and all its numbers are finite.
    pub fn is_proper(&self) -> bool {
        self.center.is_finite()
            && self.u.is_finite()
            && self.v.is_finite()
            && self.normal() != DVec3::ZERO
    }

    /// `u × v`, not of unit length; exact but for one rounding per coordinate.
    pub fn normal(&self) -> DVec3 {
        self.u.as_dvec3().cross(self.v.as_dvec3())
    }

    /// Where the ray meets the disk, from either side, with `t_min < t < t_max`.
    ///
    /// The rim belongs to the disk. A disk without area is never met, nor one in
    /// whose plane the origin lies to within the rounding of double precision.
    pub fn intersect(&self, ray: &Ray) -> Option<DiskHit> {
        let n = self.normal();
        let d = ray.direction.as_dvec3();
        let to_center = self.center.as_dvec3() - ray.origin.as_dvec3();
        let height = n.dot(to_center);
        if height.abs() <= 16.0 * f64::EPSILON * n.abs().dot(to_center.abs()) {
            return None;
        }
        let t = height / n.dot(d);
        if !(t > f64::from(ray.t_min) && t < f64::from(ray.t_max)) {
            return None;
        }

        // The place in the plane, by Cramer's rule.
        let p = d * t - to_center;
        let n2 = n.dot(n);
        let a = p.cross(self.v.as_dvec3()).dot(n) / n2;
        let b = self.u.as_dvec3().cross(p).dot(n) / n2;
        (a * a + b * b <= 1.0).then_some(DiskHit { t, a, b })
    }

    /// The point at `center + a u + b v`.
    pub fn point(&self, a: f64, b: f64) -> DVec3 {
        self.center.as_dvec3() + self.u.as_dvec3() * a + self.v.as_dvec3() * b
    }
}
