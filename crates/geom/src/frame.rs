//! An orthonormal frame around a direction.

use crate::Vec3;

/// Three unit vectors at right angles; `z` is the direction it was built around.
#[derive(Clone, Copy, Debug)]
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
