//! An axis-aligned bounding box.

use crate::Vec3;
use glam::DVec3;

/// The box of all points between two corners, both included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// The corner with the smallest coordinates.
    pub min: Vec3,
    /// The corner with the largest coordinates.
    pub max: Vec3,
}

impl Aabb {
    /// The box of no points at all: the neutral element of [`union`](Self::union).
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The smallest box around some points. A NaN coordinate is not seen by
    /// the minimum; check `is_finite` on the points where that matters.
    pub fn around(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, Self::grown)
    }

    /// This box, grown to hold `point`.
    pub fn grown(self, point: Vec3) -> Self {
        Self { min: self.min.min(point), max: self.max.max(point) }
    }

    /// Whether there are points that lie in both, be it on their sides.
    pub fn overlaps(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }

    /// The smallest box that holds both.
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// True for the box of no points.
    pub fn is_empty(&self) -> bool {
        !(self.min.cmple(self.max)).all()
    }

    /// True if no coordinate is NaN or infinite.
    pub fn is_finite(&self) -> bool {
        self.min.is_finite() && self.max.is_finite()
    }

    /// The middle. Halves are added so that huge boxes do not overflow.
    pub fn center(&self) -> Vec3 {
        self.min * 0.5 + self.max * 0.5
    }

    /// Side lengths; negative infinity for the empty box.
    pub fn extent(&self) -> Vec3 {
        self.max - self.min
    }

    /// Half the surface area, which is all that a ratio of areas needs. Zero for the empty box.
    pub fn half_area(&self) -> f32 {
        if self.is_empty() {
            return 0.0;
        }
        let e = self.extent();
        e.x * e.y + e.y * e.z + e.z * e.x
    }
}

/// The next single-precision numbers below, so that a box surely holds `p`.
pub(crate) fn rounded_down(p: DVec3) -> Vec3 {
    Vec3::new((p.x as f32).next_down(), (p.y as f32).next_down(), (p.z as f32).next_down())
}

/// The next single-precision numbers above, so that a box surely holds `p`.
#[inline(always)]
pub(crate) fn rounded_up(p: DVec3) -> Vec3 {
    Vec3::new((p.x as f32).next_up(), (p.y as f32).next_up(), (p.z as f32).next_up())
}
