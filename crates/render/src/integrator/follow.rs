//! From one surface to the next: what every integrator does with a ray.
//!
//! Surfaces inside a medium of higher priority are no borders; the ray goes
//! straight on through them, and that counts as one way. Shadow rays do not
//! know this and are blocked: light that is found beyond such a surface counts
//! as light behind glass does, in full.

use crate::color::Spectrum;
use crate::interaction::SurfaceInteraction;
use crate::medium::Media;
use crate::prepare::{Prepared, PreparedMaterial};
use rutilant_geom::{Ray, offset_origin, real};
use std::borrow::Cow;

/// The way of a ray to the next surface.
pub(super) struct Way<'s> {
    /// The part of the light that is left after it.
    pub(super) through: Spectrum,
    /// True when the ray went through surfaces that are no borders.
    pub(super) passed: bool,
    /// The surface; `None` for the sky.
    pub(super) met: Option<Met<'s>>,
}

/// A surface, and how it scatters where it was met.
pub(super) struct Met<'s> {
    pub(super) at: SurfaceInteraction,
    pub(super) material: Cow<'s, PreparedMaterial>,
}

/// After so many surfaces that are no borders a ray is given up as black: only shapes that
/// contradict themselves have more in one direction.
const PASSES: u32 = 10_000;

/// Follows `ray` to the next surface that does something to light. `ray` becomes its last,
/// straight piece; `media` becomes what is on this side of the surface. Counts the rays it traces.
#[inline]
pub(super) fn follow<'s>(
    scene: &'s Prepared,
    ray: &mut Ray,
    media: &mut Media,
    rays: &mut u64,
) -> Way<'s> {
    let (mut through, mut passed) = (Spectrum::WHITE, false);
    for _ in 0..PASSES {
        *rays += 1;
        let Some(hit) = scene.closest(ray) else {
            through *= transmittance(media.absorption, f32::INFINITY);
            return Way { through, passed, met: None };
        };
        let at = scene.interaction(&hit, ray.direction);
        let mut material = scene.material(&hit, &at);

        // A border knows what is on the side we come from.
        if let Some(border) = &material.border {
            let from_front = at.wo_local().z > 0.0;
            let here = media.arrive(border, from_front);
            if border.rank.is_some() {
                if here.interior.ior == here.exterior.ior {
                    through *= transmittance(media.absorption, hit.t);
                    media.cross(border, &here, from_front);
                    ray.origin = offset_origin(at.position, at.normal, -at.wo);
                    passed = true;
                    continue;
                }
                material = Cow::Owned(material.between(here));
            }
        }
        through *= transmittance(media.absorption, hit.t);
        return Way { through, passed, met: Some(Met { at, material }) };
    }
    Way { through: Spectrum::BLACK, passed, met: None }
}

impl Met<'_> {
    /// Notes in `media` that a scattered ray has gone through the surface.
    pub(super) fn cross(&self, media: &mut Media) {
        if let Some(border) = &self.material.border {
            media.cross(border, border, self.at.wo_local().z > 0.0);
        }
    }
}

/// The part of light that is left after `distance` metres: exp(−σ d), Beer's law.
pub(super) fn transmittance(absorption: Spectrum, distance: f32) -> Spectrum {
    if absorption.is_black() {
        return Spectrum::WHITE;
    }
    absorption.map(|sigma| if sigma > 0.0 { real::exp(-sigma * distance) } else { 1.0 })
}
