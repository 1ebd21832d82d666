//! What bounds the light of an emitter: where it is, how bright, which way it shines.
//!
//! Its surface normals lie within a cone around an axis, and it shines from each of them into
//! another: all around for a sphere, a hemisphere around one normal for a triangle.
//!
//! Source: Conty Estevez, Kulla, "Importance Sampling of Many Lights with Adaptive Tree
//! Splitting", HPG 2018, section 4.1.

use rutilant_geom::{DVec3, Vec3};

/// Bounds of one emitter within the scene.
#[derive(Clone, Copy, Debug)]
pub(super) struct EmitterBounds {
    /// The corner of its box with the smallest coordinates. In double precision, in which sums
    /// and squares of what single precision holds are finite.
    pub(super) low: DVec3,
    /// The corner with the largest coordinates.
    pub(super) high: DVec3,
    /// The middle of its normals, a unit vector; any where they point everywhere.
    pub(super) axis: Vec3,
    /// Cosine of the angle θ_o to the axis within which its normals lie.
    pub(super) cos_normals: f32,
    /// Cosine of the angle θ_e, at most a right one, to a normal within which it shines from there.
    pub(super) cos_shines: f32,
    /// It shines along the negative axis as well.
    pub(super) two_sided: bool,
    /// The luminance, in W/sr, with which it shines where it shines most, seen from afar.
    pub(super) intensity: f64,
    /// The mean over all directions of what it sends there, in parts of that.
    pub(super) mean: f32,
}

impl EmitterBounds {
    /// A flat lamp that shines from its front.
    pub(super) fn flat(low: DVec3, high: DVec3, normal: Vec3, intensity: f64) -> Self {
        let (cos_normals, cos_shines, two_sided) = (1.0, 0.0, false);
        let mean = 0.25;
        Self { low, high, axis: normal, cos_normals, cos_shines, two_sided, intensity, mean }
    }

    /// The same lamp shining from its back as well, if it does.
    pub(super) fn shining_back(self, two_sided: bool) -> Self {
        Self { two_sided, mean: if two_sided { 2.0 * self.mean } else { self.mean }, ..self }
    }

    /// A lamp that is the same from everywhere.
    pub(super) fn round(low: DVec3, high: DVec3, intensity: f64) -> Self {
        Self { cos_normals: -1.0, mean: 1.0, ..Self::flat(low, high, Vec3::Z, intensity) }
    }

    /// True where it gives light from a place that is known.
    pub(super) fn is_sound(&self) -> bool {
        self.low.is_finite()
            && self.high.is_finite()
            && self.axis.is_finite()
            && self.intensity > 0.0
            && self.intensity.is_finite()
    }
}
