//! What emitters have in common: a way to a light, and the light of a glowing surface.

use crate::color::Spectrum;
use rutilant_geom::{Ray, Vec3, offset_end};

/// A way to a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmitterSample {
    /// The direction to the light, a unit vector.
    pub wi: Vec3,
    /// Radiance arriving from there if nothing is in the way, W/(m² sr); for a delta already
    /// divided by its density: an irradiance on a surface facing it.
    pub radiance: Spectrum,
    /// Density of `wi` in 1/sr; 1 for a delta.
    pub pdf: f32,
    /// True when no ray could have found this light by chance.
    pub delta: bool,
    /// The point that shines; `None` for infinitely far away. A ray up to there does not meet
    /// the light itself.
    pub end: Option<Vec3>,
}

impl EmitterSample {
    /// The ray that must be free for the light to arrive at `origin`.
    pub fn shadow_ray(&self, origin: Vec3) -> Ray {
        match self.end {
            Some(end) => Ray::between(origin, end),
            None => Ray::new(origin, self.wi),
        }
    }
}

/// A point of a glowing surface, drawn evenly over its area.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LampPoint {
    pub(crate) position: Vec3,
    /// The unit normal there, on its front.
    pub(crate) normal: Vec3,
}

/// The light of a glowing surface: the same at every point and in every direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glow {
    /// Radiance in W/(m² sr).
    pub radiance: Spectrum,
    /// Whether the back glows as well.
    pub two_sided: bool,
}

impl Glow {
    /// Radiance that leaves along `wo` from a surface with geometric normal `normal`.
    pub fn towards(&self, wo: Vec3, normal: Vec3) -> Spectrum {
        if self.two_sided || wo.dot(normal) > 0.0 { self.radiance } else { Spectrum::BLACK }
    }

    /// Emitted power in W of a surface of `area` m².
    pub fn power(&self, area: f32) -> Spectrum {
        let sides = if self.two_sided { 2.0 } else { 1.0 };
        self.radiance * (std::f32::consts::PI * area * sides)
    }

    /// The luminance in W/sr that a flat piece of `area` m² sends where it sends most.
    pub(super) fn intensity(&self, area: f64) -> f64 {
        f64::from(self.radiance.luminance()) * area
    }

    /// The sample that stands for `point` on the surface, drawn with density `1 / area`, seen
    /// from `from`. `None` where no light arrives.
    pub(super) fn sample_at(
        &self,
        from: Vec3,
        point: Vec3,
        normal: Vec3,
        area: f32,
    ) -> Option<EmitterSample> {
        let way = point - from;
        let wi = way.try_normalize()?;
        let radiance = self.towards(-wi, normal);
        let pdf = area_to_solid_angle(1.0 / area, way, wi, normal);
        (!radiance.is_black() && pdf > 0.0 && pdf.is_finite()).then(|| EmitterSample {
            wi,
            radiance,
            pdf,
            delta: false,
            end: Some(offset_end(point, normal, from)),
        })
    }
}

/// A density per m² on a surface as a density per sr, seen over the vector `way` of direction `wi`.
pub(super) fn area_to_solid_angle(pdf_area: f32, way: Vec3, wi: Vec3, normal: Vec3) -> f32 {
    let cos = wi.dot(normal).abs();
    if cos > 0.0 { pdf_area * way.length_squared() / cos } else { 0.0 }
}
