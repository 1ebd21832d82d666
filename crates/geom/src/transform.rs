//! An affine map from one space to another, with its inverse.

use crate::{Mat3, Vec3, real};

/// Points go to `linear * p + translation`.
///
/// Named by the spaces it joins, target first: `world_from_object`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    linear: Mat3,
    translation: Vec3,
}

impl Transform {
    /// Leaves everything where it is.
    pub const IDENTITY: Self = Self { linear: Mat3::IDENTITY, translation: Vec3::ZERO };

    /// From the images of the three axes (the columns) and of the origin.
    pub fn new(linear: Mat3, translation: Vec3) -> Self {
        Self { linear, translation }
    }

    /// Moves by `offset`.
    pub fn translate(offset: Vec3) -> Self {
        Self { linear: Mat3::IDENTITY, translation: offset }
    }

    /// Scales each axis by its factor.
    pub fn scale(factors: Vec3) -> Self {
        Self { linear: Mat3::from_diagonal(factors), translation: Vec3::ZERO }
    }

    /// Turns by `angle` radians around `axis` (any length but zero), counter-clockwise when the
    /// axis points to the viewer.
    pub fn rotate(axis: Vec3, angle: f32) -> Self {
        Self::turn(axis, real::sin_cos(angle))
    }

    /// The same in degrees. Quarter turns around a coordinate axis are exact.
    pub fn rotate_degrees(axis: Vec3, degrees: f32) -> Self {
        Self::turn(axis, real::sin_cos_degrees(degrees))
    }

    fn turn(axis: Vec3, (s, c): (f32, f32)) -> Self {
        let a = axis.normalize_or(Vec3::Y);
        let one_c = 1.0 - c;
        let column = |e: Vec3| e * c + a.cross(e) * s + a * (a.dot(e) * one_c);
        Self {
            linear: Mat3::from_cols(column(Vec3::X), column(Vec3::Y), column(Vec3::Z)),
            translation: Vec3::ZERO,
        }
    }

    /// Stands at `position`, looks along −z towards `target`, with +y as near to `up` as can be.
    ///
    /// `None` when `target` is `position`, or nothing is finite. When `up` is parallel to the
    /// view, another up is chosen: looking straight down is not an error.
    pub fn look_at(position: Vec3, target: Vec3, up: Vec3) -> Option<Self> {
        let z = (position - target).try_normalize()?;
        let x = up
            .cross(z)
            .try_normalize()
            .filter(|x| x.is_finite() && up.cross(z).length() > 1e-6 * up.length())
            .unwrap_or_else(|| z.any_orthonormal_vector());
        let y = z.cross(x);
        position
            .is_finite()
            .then(|| Self { linear: Mat3::from_cols(x, y, z), translation: position })
    }

    /// The map back, or `None` where this one flattens space or is not finite.
    pub fn inverse(&self) -> Option<Self> {
        let determinant = self.linear.determinant();
        let linear = (determinant != 0.0).then(|| self.linear.inverse())?;
        let translation = -(linear * self.translation);
        (linear.is_finite() && translation.is_finite()).then_some(Self { linear, translation })
    }

    /// Where a point goes.
    pub fn point(&self, p: Vec3) -> Vec3 {
        self.linear * p + self.translation
    }

    /// Where a direction goes; lengths change with the scale.
    pub fn vector(&self, v: Vec3) -> Vec3 {
        self.linear * v
    }

    /// Where a surface normal goes (the cofactor matrix applied), not normalised.
    /// It stays perpendicular to the surface, mirrored or squeezed, and keeps its side:
    /// what was outside stays outside.
    pub fn normal(&self, n: Vec3) -> Vec3 {
        let Mat3 { x_axis: x, y_axis: y, z_axis: z } = self.linear;
        let cofactor = y.cross(z) * n.x + z.cross(x) * n.y + x.cross(y) * n.z;
        if self.mirrors() { -cofactor } else { cofactor }
    }

    /// Whether left becomes right.
    pub fn mirrors(&self) -> bool {
        self.linear.determinant() < 0.0
    }

    /// The linear part: the images of the three axes, as columns.
    pub fn linear(&self) -> Mat3 {
        self.linear
    }

    /// Where the origin goes.
    pub fn translation(&self) -> Vec3 {
        self.translation
    }

    /// The factor by which all lengths grow, if it is the same in all directions
    /// within one part in 10⁴: then spheres stay spheres.
    pub fn uniform_scale(&self) -> Option<f32> {
        let Mat3 { x_axis: x, y_axis: y, z_axis: z } = self.linear;
        let s = x.length();
        let tolerance = 1e-4 * s;
        let round = (y.length() - s).abs() <= tolerance
            && (z.length() - s).abs() <= tolerance
            && [x.dot(y), y.dot(z), z.dot(x)].iter().all(|d| d.abs() <= tolerance * s);
        (s > 0.0 && s.is_finite() && round).then_some(s)
    }
}

/// `a_from_b * b_from_c` is `a_from_c`: the right one first.
impl std::ops::Mul for Transform {
    type Output = Self;

    fn mul(self, first: Self) -> Self {
        Self { linear: self.linear * first.linear, translation: self.point(first.translation) }
    }
}
