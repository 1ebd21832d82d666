//! Affine maps in double precision, for long products of them.
//!
//! A hierarchy multiplies as many maps as it is deep, so products are rounded
//! to single precision once, at their end.

use rutilant_geom::{DVec3, Mat3, Transform, Vec3};

/// Points go to `linear * p + translation`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine {
    /// The images of the three axes.
    pub linear: [DVec3; 3],
    /// The image of the origin.
    pub translation: DVec3,
}

impl Affine {
    /// Leaves everything where it is.
    pub const IDENTITY: Self =
        Self { linear: [DVec3::X, DVec3::Y, DVec3::Z], translation: DVec3::ZERO };

    /// Everything to the origin: what sums of [`scaled`](Self::scaled) maps begin with.
    pub(crate) const ZERO: Self = Self { linear: [DVec3::ZERO; 3], translation: DVec3::ZERO };

    /// From 16 numbers, column by column. `None` where the last row is not 0 0 0 1, within what
    /// exporters round.
    pub(crate) fn from_columns(m: &[f32; 16]) -> Option<Self> {
        let is_affine = [m[3], m[7], m[11], m[15] - 1.0].iter().all(|x| x.abs() <= 1e-5);
        let column = |i: usize| DVec3::new(m[i].into(), m[i + 1].into(), m[i + 2].into());
        is_affine
            .then(|| Self { linear: [column(0), column(4), column(8)], translation: column(12) })
    }

    /// Scales, then turns by a quaternion (x, y, z, w) of any length but zero, then moves.
    pub(crate) fn from_parts(translation: Vec3, rotation: [f32; 4], scale: Vec3) -> Self {
        let [x, y, z, w] = rotation.map(f64::from);
        let twice = 2.0 / (x * x + y * y + z * z + w * w);
        // The matrix of a quaternion: Shoemake, *Animating Rotation with Quaternion Curves*,
        // 1985, by columns.
        let [sx, sy, sz] = [x, y, z].map(|part| twice * part);
        let columns = [
            DVec3::new(1.0 - (sy * y + sz * z), sx * y + sz * w, sx * z - sy * w),
            DVec3::new(sx * y - sz * w, 1.0 - (sx * x + sz * z), sy * z + sx * w),
            DVec3::new(sx * z + sy * w, sy * z - sx * w, 1.0 - (sx * x + sy * y)),
        ];
        let [x, y, z] = columns;
        let scale = double(scale);
        Self { linear: [x * scale.x, y * scale.y, z * scale.z], translation: double(translation) }
    }

    /// Where a direction goes; lengths change with the scale.
    pub fn vector(&self, v: DVec3) -> DVec3 {
        let [x, y, z] = self.linear;
        x * v.x + y * v.y + z * v.z
    }

    /// Where a point goes.
    pub fn point(&self, p: DVec3) -> DVec3 {
        self.vector(p) + self.translation
    }

    /// Where a normal goes: the cofactor matrix applied, so that it stays perpendicular to the
    /// surface and on its side; not normalised.
    pub fn normal(&self, n: DVec3) -> DVec3 {
        let [x, y, z] = self.linear;
        let (yz, zx, xy) = (y.cross(z), z.cross(x), x.cross(y));
        let cofactor = yz * n.x + zx * n.y + xy * n.z;
        if x.dot(yz) < 0.0 { -cofactor } else { cofactor }
    }

    /// All numbers times `factor`.
    pub(crate) fn scaled(&self, factor: f64) -> Self {
        Self {
            linear: self.linear.map(|axis| axis * factor),
            translation: self.translation * factor,
        }
    }

    /// The sum, number by number.
    pub(crate) fn plus(&self, other: &Self) -> Self {
        let [x, y, z] = self.linear;
        let [ox, oy, oz] = other.linear;
        Self { linear: [x + ox, y + oy, z + oz], translation: self.translation + other.translation }
    }

    /// In single precision; `None` where that cannot hold it.
    pub fn to_transform(&self) -> Option<Transform> {
        let [x, y, z] = self.linear.map(single);
        let translation = single(self.translation);
        let is_finite = [x, y, z, translation].iter().all(|v| v.is_finite());
        is_finite.then(|| Transform::new(Mat3::from_cols(x, y, z), translation))
    }
}

/// `a_from_b * b_from_c` is `a_from_c`: the right one first.
impl std::ops::Mul for Affine {
    type Output = Self;

    fn mul(self, first: Self) -> Self {
        Self {
            linear: first.linear.map(|axis| self.vector(axis)),
            translation: self.point(first.translation),
        }
    }
}

pub(crate) fn double(v: Vec3) -> DVec3 {
    DVec3::new(v.x.into(), v.y.into(), v.z.into())
}

pub(crate) fn single(v: DVec3) -> Vec3 {
    Vec3::new(v.x as f32, v.y as f32, v.z as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quarter turn around each axis, from a quaternion of length 5, then a scale of its own
    /// for each axis: a wrong sign or a transposed matrix shows.
    #[test]
    fn quaternions_turn_counter_clockwise() {
        let h = 5.0 * std::f32::consts::FRAC_1_SQRT_2;
        for (axis, from, to) in [
            ([h, 0.0, 0.0, h], DVec3::Y, DVec3::Z),
            ([0.0, h, 0.0, h], DVec3::Z, DVec3::X),
            ([0.0, 0.0, h, h], DVec3::X, DVec3::Y),
        ] {
            let turn = Affine::from_parts(Vec3::X, axis, Vec3::new(2.0, 3.0, 4.0));
            let length = from.dot(DVec3::new(2.0, 3.0, 4.0));
            assert!((turn.vector(from) - length * to).length() < 1e-6, "{axis:?}");
            assert!((turn.point(from) - length * to - DVec3::X).length() < 1e-6, "{axis:?}");
        }
    }
}
