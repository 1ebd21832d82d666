//! A ray meets a triangle, watertight.
//!
//! The ray is sheared so that it runs along one axis; the triangle becomes a
//! flat one around the origin, and three edge functions tell whether the origin
//! lies inside. All in double precision from single-precision vertices.
//!
//! Why no ray slips through between two triangles: a vertex is sheared alone,
//! so that both triangles see the same flat point. An edge function is a
//! difference of two rounded products; rounding keeps order, so its sign is the
//! exact sign of those flat points or zero, and the other triangle sees the
//! same number negated. Zero counts as inside. A point of the plane that lies
//! in the mesh of flat points is therefore inside at least one of them. A fused
//! multiply-add would break this.
//!
//! Source: Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection",
//! JCGT 2(1), 2013.

use crate::{Ray, Vec3};
use glam::DVec3;

/// What all triangles ask of one ray: made once, used for every test.
#[derive(Clone, Copy, Debug)]
pub struct TriangleRay {
    origin: DVec3,
    direction: DVec3,
    /// The axis along which the ray goes most, and the other two.
    kz: usize,
    kx: usize,
    ky: usize,
    /// The shear that turns the ray onto the axis, and the scale along it.
    sx: f64,
    sy: f64,
    sz: f64,
    t_min: f64,
    t_max: f64,
}

/// Where a ray met a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// Distance along the ray, in lengths of its direction.
    pub t: f64,
    /// Barycentric weight of the second vertex, 0 to 1.
    pub u: f64,
    /// Barycentric weight of the third vertex, 0 to 1.
    pub v: f64,
}

impl TriangleRay {
    /// Prepares a ray. A ray with a NaN, an infinite or a zero direction meets nothing.
    pub fn new(ray: &Ray) -> Self {
        let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let size = direction.abs();
        let kz = if size.x > size.y {
            if size.x > size.z { 0 } else { 2 }
        } else if size.y > size.z {
            1
        } else {
            2
        };
        let (kx, ky) = ((kz + 1) % 3, (kz + 2) % 3);
        Self {
            origin,
            direction,
            kz,
            kx,
            ky,
            sx: direction[kx] / direction[kz],
            sy: direction[ky] / direction[kz],
            sz: 1.0 / direction[kz],
            t_min: f64::from(ray.t_min),
            t_max: f64::from(ray.t_max),
        }
    }

    /// Where the ray meets the triangle `a b c`, from either side, with `t_min < t < t_max`.
    ///
    /// Edges and vertices belong to the triangle. A triangle without area is
    /// never met, nor one with a NaN or an infinite vertex, nor one in whose
    /// plane the origin lies to within the rounding of double precision.
    /// No NaN ever leaves.
    #[inline]
    pub fn intersect(&self, a: Vec3, b: Vec3, c: Vec3) -> Option<TriangleHit> {
        // The vertices seen from the origin, sheared so that the ray runs along z.
        let [ax, ay, az] = self.shear(a);
        let [bx, by, bz] = self.shear(b);
        let [cx, cy, cz] = self.shear(c);

        // Edge functions: twice the areas between the ray and two vertices each.
        let u = cx * by - cy * bx;
        let v = ax * cy - ay * cx;
        let w = bx * ay - by * ax;
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let det = u + v + w;
        if det == 0.0 {
            return None;
        }

        // A triangle without area can still look as if it had one, by rounding.
        let (pa, pb, pc) = (a.as_dvec3(), b.as_dvec3(), c.as_dvec3());
        let normal = (pb - pa).cross(pc - pa);
        if normal == DVec3::ZERO {
            return None;
        }

        let t = if az * self.sz > 0.0 && bz * self.sz > 0.0 && cz * self.sz > 0.0 {
            // All in front: a mean of positive numbers, which no rounding makes negative.
            self.sz * ((u * az + v * bz + w * cz) / det)
        } else {
            // Around the origin: the height over the plane tells the side more
            // exactly, above all for needles. One part in 2⁴⁹ is what rounding
            // can do to the height here and to the hit the ray may start from.
            let from_origin = pa - self.origin;
            let height = normal.dot(from_origin);
            if height.abs() <= 16.0 * f64::EPSILON * normal.abs().dot(from_origin.abs()) {
                return None;
            }
            height / normal.dot(self.direction)
        };
        // False also for NaN.
        (t > self.t_min && t < self.t_max).then(|| TriangleHit { t, u: v / det, v: w / det })
    }

    #[inline]
    fn shear(&self, p: Vec3) -> [f64; 3] {
        let p = p.to_array();
        let z = f64::from(p[self.kz]) - self.origin[self.kz];
        [
            (f64::from(p[self.kx]) - self.origin[self.kx]) - self.sx * z,
            (f64::from(p[self.ky]) - self.origin[self.ky]) - self.sy * z,
            z,
        ]
    }
}
