//! Affine maps in double precision: what a `<transform>` is made of.
//!
//! Steps follow each other as they are written: each is applied after those before it. A camera's
//! `lookat` has its x to the left and looks along +z.

use rutilant_geom::{DVec3, Mat3, Transform, Vec3, real};

/// Points go to `linear p + translation`; columns are where the axes go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Matrix {
    pub(super) columns: [DVec3; 3],
    pub(super) translation: DVec3,
}

impl Matrix {
    pub(super) const IDENTITY: Self =
        Self { columns: [DVec3::X, DVec3::Y, DVec3::Z], translation: DVec3::ZERO };

    pub(super) fn translate(translation: DVec3) -> Self {
        Self { translation, ..Self::IDENTITY }
    }

    pub(super) fn scale(factors: DVec3) -> Self {
        let [x, y, z] = factors.to_array();
        Self { columns: [DVec3::X * x, DVec3::Y * y, DVec3::Z * z], ..Self::IDENTITY }
    }

    /// Turns around an axis, counter-clockwise when it points to the viewer; `None` for an axis
    /// without length. Quarter turns are exact.
    pub(super) fn rotate(axis: DVec3, degrees: f64) -> Option<Self> {
        let a = axis.try_normalize()?;
        // The same on every machine, which those of the standard library are not.
        let (s, c) = real::sin_cos_degrees(degrees as f32);
        let (s, c) = (f64::from(s), f64::from(c));
        let column = |e: DVec3| e * c + a.cross(e) * s + a * (a.dot(e) * (1.0 - c));
        Some(Self { columns: [DVec3::X, DVec3::Y, DVec3::Z].map(column), ..Self::IDENTITY })
    }

    /// Stands at `origin` and looks at `target`; `None` where these are the same. Where `up` is
    /// missing or along the view, another is chosen.
    pub(super) fn look_at(origin: DVec3, target: DVec3, up: Option<DVec3>) -> Option<Self> {
        let ahead = (target - origin).try_normalize()?;
        let left = up.and_then(DVec3::try_normalize).map(|up| up.cross(ahead));
        let left = left.filter(|left| left.length() > 1e-9).and_then(DVec3::try_normalize);
        let left = left.unwrap_or_else(|| ahead.any_orthonormal_vector());
        Some(Self { columns: [left, ahead.cross(left), ahead], translation: origin })
    }

    /// First `self`, then `then`.
    pub(super) fn followed_by(&self, then: &Self) -> Self {
        Self {
            columns: self.columns.map(|column| then.vector(column)),
            translation: then.point(self.translation),
        }
    }

    pub(super) fn point(&self, p: DVec3) -> DVec3 {
        self.vector(p) + self.translation
    }

    pub(super) fn vector(&self, v: DVec3) -> DVec3 {
        let [x, y, z] = self.columns;
        x * v.x + y * v.y + z * v.z
    }

    pub(super) fn determinant(&self) -> f64 {
        let [x, y, z] = self.columns;
        x.cross(y).dot(z)
    }

    /// The factor by which all lengths grow, if it is the same in all directions within one part in
    /// 10⁴.
    pub(super) fn uniform_scale(&self) -> Option<f64> {
        let [x, y, z] = self.columns;
        let size = x.length();
        let near = |a: f64, b: f64, scale: f64| (a - b).abs() <= 1e-4 * scale;
        let even = near(y.length(), size, size) && near(z.length(), size, size);
        let square = [x.dot(y), y.dot(z), z.dot(x)].iter().all(|d| near(*d, 0.0, size * size));
        (even && square && size > 0.0).then_some(size)
    }

    pub(super) fn is_finite(&self) -> bool {
        self.to_transform().linear().is_finite() && self.to_transform().translation().is_finite()
    }

    pub(super) fn to_transform(self) -> Transform {
        let [x, y, z] = self.columns.map(single);
        Transform::new(Mat3::from_cols(x, y, z), single(self.translation))
    }
}

/// In single precision.
pub(super) fn single(v: DVec3) -> Vec3 {
    Vec3::new(v.x as f32, v.y as f32, v.z as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Looking along +z with y up is no turn at all: x is to the left then.
    #[test]
    fn cameras_look_along_z() {
        let here = Matrix::look_at(DVec3::ZERO, DVec3::Z, Some(DVec3::Y)).unwrap();
        assert_eq!(here, Matrix::IDENTITY);
        // Without an up, and with one along the view, there is some view.
        for up in [None, Some(DVec3::Z), Some(DVec3::ZERO)] {
            let here = Matrix::look_at(DVec3::ZERO, DVec3::Z, up).unwrap();
            assert!((here.determinant() - 1.0).abs() < 1e-12);
            assert_eq!(here.columns[2], DVec3::Z);
        }
        assert_eq!(Matrix::look_at(DVec3::X, DVec3::X, None), None);
    }

    /// What is written first is done first.
    #[test]
    fn steps_follow_each_other() {
        let moved = Matrix::translate(DVec3::X);
        let turned = Matrix::rotate(DVec3::Z, 90.0).unwrap();
        assert_eq!(moved.followed_by(&turned).point(DVec3::ZERO), DVec3::Y);
        assert_eq!(turned.followed_by(&moved).point(DVec3::ZERO), DVec3::X);
    }
}
