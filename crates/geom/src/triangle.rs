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
    /// The axis along which the ray goes most.
    longest: Axis,
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
        let longest = if size.x > size.y && size.x > size.z {
            Axis::X
        } else if size.y > size.z {
            Axis::Y
        } else {
            Axis::Z
        };
        let d = longest.turned_to_z(direction);
        Self {
            origin,
            direction,
            longest,
            sx: d.x / d.z,
            sy: d.y / d.z,
            sz: 1.0 / d.z,
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
    #[inline(always)]
    pub fn intersect(&self, a: Vec3, b: Vec3, c: Vec3) -> Option<TriangleHit> {
        // The vertices seen from the origin, sheared so that the ray runs along z.
        let (a, b, c) = (a.as_dvec3(), b.as_dvec3(), c.as_dvec3());
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
        let normal = (b - a).cross(c - a);
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
            let from_origin = a - self.origin;
            let height = normal.dot(from_origin);
            if height.abs() <= 16.0 * f64::EPSILON * normal.abs().dot(from_origin.abs()) {
                return None;
            }
            height / normal.dot(self.direction)
        };
        // False also for NaN.
        (t > self.t_min && t < self.t_max).then(|| TriangleHit { t, u: v / det, v: w / det })
    }

    #[inline(always)]
    fn shear(&self, p: DVec3) -> [f64; 3] {
        let p = self.longest.turned_to_z(p - self.origin);
        [p.x - self.sx * p.z, p.y - self.sy * p.z, p.z]
    }
}

#[derive(Clone, Copy, Debug)]
enum Axis {
    X,
    Y,
    Z,
}

impl Axis {
    /// The coordinates in turn, so that this axis becomes the third.
    #[inline(always)]
    fn turned_to_z(self, p: DVec3) -> DVec3 {
        match self {
            Self::X => DVec3::new(p.y, p.z, p.x),
            Self::Y => DVec3::new(p.z, p.x, p.y),
            Self::Z => p,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn some_point(i: u32) -> Vec3 {
        let hash = |k: u32| {
            let x = (i ^ k.wrapping_mul(0x85eb_ca6b)).wrapping_mul(0x9e37_79b9);
            let x = (x ^ (x >> 15)).wrapping_mul(0x2c1b_3c6d);
            (x ^ (x >> 13)).wrapping_mul(0x297a_2d39) >> 8
        };
        Vec3::from_array([1, 2, 3].map(|k| hash(k) as f32 / (1 << 23) as f32 - 1.0))
    }

    /// A ray at the shared edge of two triangles meets at least one of them: no crack.
    #[test]
    fn two_triangles_share_their_edge() {
        for i in 0..100_000 {
            let [a, b, c, o] = [0, 1, 2, 3].map(|k| some_point(4 * i + k));
            let target = a + (b - a) * (0.001 * (1 + i % 999) as f32);
            // The other corner stands opposite, however the edge is seen.
            let d = target * 2.0 - c;
            let ray = TriangleRay::new(&Ray::new(o, target - o));
            let met = ray.intersect(a, b, c).or(ray.intersect(b, a, d));
            assert!(met.is_some(), "{i}: {a} {b} {c} {d} from {o}");
        }
    }

    /// Corners and edges count, from both sides, and the weights say where.
    #[test]
    fn corners_and_edges_belong_to_the_triangle() {
        let [a, b, c] = [Vec3::ZERO, Vec3::X, Vec3::Y];
        for (target, u, v) in
            [(a, 0.0, 0.0), (b, 1.0, 0.0), (c, 0.0, 1.0), ((b + c) * 0.5, 0.5, 0.5)]
        {
            for z in [3.0, -3.0] {
                let ray =
                    TriangleRay::new(&Ray::between(target + Vec3::Z * z, target - Vec3::Z * z));
                let hit = ray.intersect(a, b, c);
                assert_eq!(hit, Some(TriangleHit { t: 0.5, u, v }));
                assert_eq!(ray.intersect(a, c, b), Some(TriangleHit { t: 0.5, u: v, v: u }));
            }
        }
    }

    /// Points and lines have no area to meet, NaN and infinity no place.
    #[test]
    fn degenerate_triangles_are_never_met() {
        let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
        for i in 0..20_000 {
            let [p, q, o] = [0, 1, 2].map(|k| some_point(3 * i + k));
            // Multiples by powers of two: three points exactly on a line.
            for [a, b, c] in [[p, p, p], [p, q, q], [p, q, p], [p * 0.5, p, p * 2.0]] {
                let ray = TriangleRay::new(&Ray::new(o, a - o));
                assert_eq!(ray.intersect(a, b, c), None, "{a} {b} {c} from {o}");
            }
            let ray = TriangleRay::new(&Ray::new(o, p - o));
            let broken = Vec3::new(bad[i as usize % 3], q.y, q.z);
            for [a, b, c] in [[broken, p, q], [p, broken, q], [p, q, broken]] {
                assert_eq!(ray.intersect(a, b, c), None);
            }
        }
    }

    /// Both ends of a ray are outside of it.
    #[test]
    fn ends_do_not_count() {
        let [a, b, c] = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let ray = Ray::new(Vec3::new(0.25, 0.25, 2.0), Vec3::NEG_Z);
        for (t_min, t_max, met) in [(0.0, 2.0, false), (2.0, 3.0, false), (1.9, 2.1, true)] {
            let ray = TriangleRay::new(&Ray { t_min, t_max, ..ray });
            assert_eq!(ray.intersect(a, b, c).is_some(), met);
        }
    }
}
