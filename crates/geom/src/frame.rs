//! An orthonormal frame around a direction.

use crate::Vec3;
use crate::lanes::{Xyz, Xyz8};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8};

/// Three unit vectors at right angles; `z` is the direction it was built around.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// First tangent.
    pub x: Vec3,
    /// Second tangent.
    pub y: Vec3,
    /// The direction itself, for shading the normal.
    pub z: Vec3,
}

impl Frame {
    /// A right-handed frame around the unit vector `z`, without branches on its direction.
    ///
    /// Source: Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017.
    pub fn around(z: Vec3) -> Self {
        let sign = 1.0_f32.copysign(z.z);
        let a = -1.0 / (sign + z.z);
        let b = z.x * z.y * a;
        Self {
            x: Vec3::new(1.0 + sign * z.x * z.x * a, sign * b, -sign * z.x),
            y: Vec3::new(b, sign + z.y * z.y * a, -z.y),
            z,
        }
    }

    /// World coordinates to this frame's.
    pub fn to_local(&self, v: Vec3) -> Vec3 {
        Vec3::new(self.x.dot(v), self.y.dot(v), self.z.dot(v))
    }

    /// This frame's coordinates to the world's.
    pub fn to_world(&self, v: Vec3) -> Vec3 {
        self.x * v.x + self.y * v.y + self.z * v.z
    }
}

/// A frame in each lane.
#[derive(Clone, Copy)]
pub struct Frames<S: Simd> {
    /// First tangents.
    pub x: Xyz8<S>,
    /// Second tangents.
    pub y: Xyz8<S>,
    /// The directions themselves.
    pub z: Xyz8<S>,
}

impl<S: Simd> Frames<S> {
    /// [`Frame::around`] in each lane.
    #[inline(always)]
    pub fn around(z: Xyz8<S>) -> Self {
        let simd = z.x.token();
        let one = f32x8::splat(simd, 1.0);
        let sign = one.copysign(z.z);
        let a = -one / (sign + z.z);
        let b = z.x * z.y * a;
        Self {
            x: Xyz { x: one + sign * z.x * z.x * a, y: sign * b, z: -sign * z.x },
            y: Xyz { x: b, y: sign + z.y * z.y * a, z: -z.y },
            z,
        }
    }

    /// World coordinates to each frame's.
    #[inline(always)]
    pub fn to_local(&self, v: Xyz8<S>) -> Xyz8<S> {
        Xyz { x: self.x.dot(v), y: self.y.dot(v), z: self.z.dot(v) }
    }

    /// Each frame's coordinates to the world's.
    #[inline(always)]
    pub fn to_world(&self, v: Xyz8<S>) -> Xyz8<S> {
        self.x.scaled(v.x) + self.y.scaled(v.y) + self.z.scaled(v.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Also at the poles, where the naive construction divides by zero.
    #[test]
    fn frames_are_orthonormal_and_right_handed() {
        for i in 0..2000u32 {
            let z = match i {
                0 => Vec3::Z,
                1 => Vec3::NEG_Z,
                2 => Vec3::new(1e-20, 0.0, -1.0),
                _ => {
                    let [a, b, c] = [1_u32, 7, 13].map(|k| {
                        (i.wrapping_mul(2_654_435_761).rotate_left(k) >> 8) as f32
                            / (1 << 23) as f32
                            - 1.0
                    });
                    Vec3::new(a, b, c).normalize()
                }
            };
            let f = Frame::around(z);
            assert!((f.x.cross(f.y) - f.z).length() < 1e-6, "{z:?}");
            assert!(f.x.dot(f.y).abs() < 1e-6 && (f.x.length() - 1.0).abs() < 1e-6, "{z:?}");
            assert!((f.to_world(f.to_local(Vec3::ONE)) - Vec3::ONE).length() < 1e-6, "{z:?}");
        }
    }
}
