//! Light as a scattered ray finds it, with the density that light sampling would have had.

use super::caustics::Caustics;
use crate::color::Spectrum;
use crate::interaction::SurfaceInteraction;
use crate::light::{EmitterSelection, ShadingPoint};
use crate::prepare::Prepared;
use rutilant_geom::{Ray, Vec3};

/// Emitted light that a ray ran into.
pub(super) struct SeenEmission {
    /// Radiance towards where the ray came from.
    pub(super) radiance: Spectrum,
    /// The number of the emitter.
    pub(super) emitter: usize,
    /// Where the ray met it, and the normal there; of the sky only a point on the ray is known.
    position: Vec3,
    normal: Vec3,
}

impl SeenEmission {
    /// The sky as `ray` sees it.
    pub(super) fn of_sky(scene: &Prepared, ray: &Ray) -> Option<Self> {
        let (emitter, sky) = scene.environment()?;
        let radiance = sky.radiance(ray.direction);
        Some(Self { radiance, emitter, position: ray.origin, normal: Vec3::ZERO })
    }

    /// A glowing surface.
    pub(super) fn of_surface(scene: &Prepared, at: &SurfaceInteraction) -> Option<Self> {
        let seen = Self::of_emitter(scene, at.emitter?, at.position, at.normal, at.wo)?;
        seen.painted(at.glow)
    }

    /// The surface of this emitter at `position`, with its `normal` there, towards `wo`.
    pub(super) fn of_emitter(
        scene: &Prepared,
        emitter: u32,
        position: Vec3,
        normal: Vec3,
        wo: Vec3,
    ) -> Option<Self> {
        let emitter = emitter as usize;
        let radiance = scene.emitters()[emitter].glow()?.towards(wo, normal);
        (!radiance.is_black()).then_some(Self { radiance, emitter, position, normal })
    }

    /// The same where a picture leaves so much of it.
    pub(super) fn painted(mut self, glow: Spectrum) -> Option<Self> {
        self.radiance *= glow;
        (!self.radiance.is_black()).then_some(self)
    }

    /// The share in this light of a path from the camera, which found it along `ray`; light
    /// paths find the rest, where there is a `lead`.
    pub(super) fn caustic_share(&self, caustics: &Caustics<'_>, lead: f32, ray: &Ray) -> f32 {
        caustics.share(lead, self.emitter, self.position, self.normal, ray)
    }

    /// The density, in 1/sr, with which light sampling would have chosen `wi` from `from`, where a
    /// light was chosen for `point`.
    pub(super) fn light_pdf(
        &self,
        scene: &Prepared,
        selection: &EmitterSelection,
        point: &ShadingPoint,
        from: Vec3,
        wi: Vec3,
    ) -> f32 {
        selection.pmf(point, self.emitter)
            * scene.emitters()[self.emitter].pdf(from, wi, self.position, self.normal)
    }
}
