//! Affine maps in double precision, for long products of them.
//!
//! A hierarchy multiplies as many maps as it is deep, so products are rounded
//! to single precision once, at their end.

use rutilant_geom::{DVec3, Mat3, Transform, Vec3, real};

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

    /// Moves.
    pub(crate) fn translate(by: DVec3) -> Self {
        Self { translation: by, ..Self::IDENTITY }
    }

    /// A factor for each axis.
    pub(crate) fn scale(by: DVec3) -> Self {
        let linear = [DVec3::X * by.x, DVec3::Y * by.y, DVec3::Z * by.z];
        Self { linear, translation: DVec3::ZERO }
    }

    /// A turn around an axis, in degrees, counter-clockwise for whom it points to; quarter turns
    /// around coordinate axes are exact. `None` where the axis has no length.
    pub(crate) fn rotate(degrees: f32, axis: DVec3) -> Option<Self> {
        let axis = axis.try_normalize()?;
        let (s, c) = real::sin_cos_degrees(degrees);
        let (s, c) = (f64::from(s), f64::from(c));
        let column = |e: DVec3| e * c + axis.cross(e) * s + axis * (axis.dot(e) * (1.0 - c));
        let linear = [column(DVec3::X), column(DVec3::Y), column(DVec3::Z)];
        Some(Self { linear, translation: DVec3::ZERO })
    }

    /// World from camera, for an eye that looks at a point along its +z, with +y up; +x is
    /// `up × forward`. `None` where there is no such direction.
    pub(crate) fn look_at(eye: DVec3, at: DVec3, up: DVec3) -> Option<Self> {
        let forward = (at - eye).try_normalize()?;
        let aside = up.try_normalize()?.cross(forward);
        let aside = aside.try_normalize().filter(|_| aside.length() > 1e-9)?;
        Some(Self { linear: [aside, forward.cross(aside), forward], translation: eye })
    }

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

    /// The map back; `None` where space is flattened.
    pub(crate) fn inverse(&self) -> Option<Self> {
        let [x, y, z] = self.linear;
        let volume = self.determinant();
        let rows = [y.cross(z) / volume, z.cross(x) / volume, x.cross(y) / volume];
        let linear = [
            DVec3::new(rows[0].x, rows[1].x, rows[2].x),
            DVec3::new(rows[0].y, rows[1].y, rows[2].y),
            DVec3::new(rows[0].z, rows[1].z, rows[2].z),
        ];
        let back = Self { linear, translation: DVec3::ZERO };
        let inverse = Self { linear, translation: -back.vector(self.translation) };
        inverse.is_finite().then_some(inverse)
    }

    /// By what volumes grow; negative where left becomes right.
    fn determinant(&self) -> f64 {
        let [x, y, z] = self.linear;
        x.cross(y).dot(z)
    }

    /// Whether left becomes right.
    pub(crate) fn mirrors(&self) -> bool {
        self.determinant() < 0.0
    }

    pub(crate) fn is_finite(&self) -> bool {
        self.linear.iter().chain([&self.translation]).all(|v| v.is_finite())
    }

    /// The factor by which all lengths grow, where it is the same in all directions within 1 in 10⁴.
    pub(crate) fn uniform_scale(&self) -> Option<f64> {
        let [x, y, z] = self.linear;
        let s = x.length();
        let off = 1e-4 * s;
        let round = (y.length() - s).abs() <= off
            && (z.length() - s).abs() <= off
            && [x.dot(y), y.dot(z), z.dot(x)].iter().all(|d| d.abs() <= off * s);
        (s > 0.0 && s.is_finite() && round).then_some(s)
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

    fn near(a: DVec3, b: DVec3) -> bool {
        (a - b).length() < 1e-6
    }

    /// What an eye looks at lies on its +z and what is above it on +y; an eye at the origin that
    /// looks along +z turns nothing.
    #[test]
    fn eyes_look_along_z() {
        let eye = DVec3::new(1.0, 2.0, 3.0);
        let world = Affine::look_at(eye, eye + DVec3::X, DVec3::Y).expect("a view");
        let camera = world.inverse().expect("a way back");
        assert!(near(camera.point(eye + DVec3::X * 5.0), DVec3::Z * 5.0));
        assert!(near(camera.vector(DVec3::Y), DVec3::Y));
        assert!(near(camera.vector(DVec3::Y.cross(DVec3::X)), DVec3::X));
        assert_eq!(Affine::look_at(DVec3::ZERO, DVec3::Z, DVec3::Y), Some(Affine::IDENTITY));
        assert!(Affine::look_at(eye, eye, DVec3::Y).is_none());
        assert!(Affine::look_at(eye, eye + DVec3::Y, DVec3::Y).is_none());
    }

    /// There and back again is nothing; a turn follows the right hand; flat maps have no way back.
    #[test]
    fn maps_have_inverses() {
        let turn = Affine::rotate(30.0, DVec3::new(1.0, 2.0, -0.5)).expect("an axis");
        let moved = Affine::translate(DVec3::new(1.0, -2.0, 3.0));
        let map = moved * turn * Affine::scale(DVec3::new(2.0, -3.0, 0.5));
        let back = map.inverse().expect("an inverse");
        for point in [DVec3::ZERO, DVec3::X, DVec3::new(0.3, -7.0, 2.0)] {
            assert!(near(back.point(map.point(point)), point));
        }
        assert!(map.mirrors() && !turn.mirrors());
        assert!(Affine::scale(DVec3::new(1.0, 0.0, 1.0)).inverse().is_none());
        let quarter = Affine::rotate(90.0, DVec3::Z).expect("an axis");
        assert_eq!(quarter.vector(DVec3::X), DVec3::Y);
    }
}
