//! From one surface to the next: what every integrator, and the focus, does with a ray.
//!
//! Surfaces inside a medium of higher priority are no borders; the ray goes
//! straight on through them, and that counts as one way. Shadow rays do not
//! know this and are blocked: light that is found beyond such a surface counts
//! as light behind glass does, in full. Surfaces that glow and do not scatter
//! are passed as well, by shadow rays too; their light is told on the way.

use crate::color::Spectrum;
use crate::interaction::SurfaceInteraction;
use crate::medium::Media;
use crate::prepare::{Prepared, PreparedMaterial};
use rutilant_geom::{Hit, Ray, offset_origin, real};

/// The way of a ray to the next surface.
pub(crate) struct Way<'p> {
    /// The part of the light that is left after it.
    pub(crate) through: Spectrum,
    /// True when the ray went through surfaces that are no borders.
    pub(crate) passed: bool,
    /// The surface; `None` for the sky.
    pub(crate) met: Option<Met<'p>>,
}

/// A surface that glows and lets rays pass, on the way of one.
pub(crate) struct Glowing<'a> {
    pub(crate) at: &'a SurfaceInteraction,
    /// The part of its light that is left at the start of the ray.
    pub(crate) through: Spectrum,
    /// True when there are surfaces before it that are no borders.
    pub(crate) beyond_passed: bool,
}

/// A surface, and how it scatters where it was met.
pub(crate) struct Met<'p> {
    pub(crate) hit: Hit,
    pub(crate) at: SurfaceInteraction,
    pub(crate) material: &'p PreparedMaterial,
    /// What a ray is inside of that goes through, where that is more than the border's far side.
    beyond: Option<&'p Media>,
}

/// Room for a material that is made for one hit. It belongs to the caller, so that the many
/// materials that are not need not be moved about.
pub(crate) struct Made {
    material: PreparedMaterial,
    beyond: Option<Media>,
}

/// After so many surfaces that it passes, or that are not there for it, a ray is given up and brings
/// no light: only shapes that contradict themselves have more in one direction, and they might have
/// them without end.
pub(crate) const MOST_PASSES: u32 = 10_000;

/// Follows `ray` to the next surface that does something to light. `ray` becomes its last,
/// straight piece; `media` becomes what is on this side of the surface. Counts the rays it traces,
/// and tells `glowing` what shines on the way.
#[inline(always)]
pub(crate) fn follow<'p>(
    scene: &'p Prepared,
    ray: &mut Ray,
    media: &mut Media,
    made: &'p mut Option<Made>,
    rays: &mut u64,
    glowing: &mut dyn FnMut(&Glowing<'_>),
) -> Way<'p> {
    *rays += 1;
    let Some(hit) = scene.closest(ray) else { return to_the_sky(media) };
    let at = scene.interaction(&hit, ray.direction);
    let material = scene.material(&at);
    if material.depends_on_place() {
        return follow_through(scene, hit, at, ray, media, made, rays, glowing);
    }
    if let Some(border) = &material.border {
        media.arrive_declared(border, at.wo_local().z > 0.0);
    }
    let through = transmittance(media.absorption, hit.t);
    Way { through, passed: false, met: Some(Met { hit, at, material, beyond: None }) }
}

/// The same from the first surface on, whatever it is. Apart, so that the common way stays short.
#[inline(never)]
#[expect(clippy::too_many_arguments, reason = "the state of `follow`, and nothing else")]
fn follow_through<'p>(
    scene: &'p Prepared,
    mut hit: Hit,
    mut at: SurfaceInteraction,
    ray: &mut Ray,
    media: &mut Media,
    made: &'p mut Option<Made>,
    rays: &mut u64,
    glowing: &mut dyn FnMut(&Glowing<'_>),
) -> Way<'p> {
    let (mut through, mut passed) = (Spectrum::WHITE, false);
    for _ in 0..MOST_PASSES {
        let material = scene.material(&at);
        let next = if material.passes {
            let left = through * transmittance(media.absorption, hit.t);
            glowing(&Glowing { at: &at, through: left, beyond_passed: passed });
            // Every step leaves this surface behind, but none that is in the same place.
            scene.closest_after(ray, &hit)
        } else {
            let from_front = at.wo_local().z > 0.0;
            let ranked = material.border.and_then(|b| b.rank.map(|rank| (b, rank)));
            let Some((border, rank)) = ranked else {
                if let Some(border) = &material.border {
                    media.arrive_declared(border, from_front);
                }
                through *= transmittance(media.absorption, hit.t);
                let varied = scene.varied_at(&hit, &at, material);
                let material = match varied {
                    None => material,
                    Some(material) => &made.insert(Made { material, beyond: None }).material,
                };
                return Way { through, passed, met: Some(Met { hit, at, material, beyond: None }) };
            };

            // What fills the place on both sides.
            let across = |direction| offset_origin(at.position, at.normal, direction);
            let ends = [across(at.wo), across(-at.wo)];
            let also = |media: &mut Media| {
                scene.each_that_touches(ray, &hit, ends, |rank, front| media.pass(rank, front));
            };
            let table = scene.ranked_media();
            let (here, beyond) = media.arrive(&border, rank, from_front, also, table);
            through *= transmittance(media.absorption, hit.t);
            if !here.interior.bends_like(&here.exterior) {
                let varied = scene.varied_at(&hit, &at, material);
                let material = varied.as_ref().unwrap_or(material).between(here);
                let Made { material, beyond } =
                    made.insert(Made { material, beyond: Some(beyond) });
                let met = Met { hit, at, material, beyond: beyond.as_ref() };
                return Way { through, passed, met: Some(met) };
            }

            // No border here: straight on.
            *media = beyond;
            passed = true;
            *ray = Ray::new(ends[1], ray.direction);
            scene.closest(ray)
        };
        *rays += 1;
        let Some(next) = next else {
            let sky = to_the_sky(media);
            return Way { through: through * sky.through, passed, met: None };
        };
        (hit, at) = (next, scene.interaction(&next, ray.direction));
    }
    Way { through: Spectrum::BLACK, passed, met: None }
}

/// The way to where there is no surface any more.
fn to_the_sky<'p>(media: &Media) -> Way<'p> {
    Way { through: transmittance(media.absorption, f32::INFINITY), passed: false, met: None }
}

impl Met<'_> {
    /// What is absorbed on the other side of the surface, in 1/m.
    pub(crate) fn absorption_beyond(&self, media: &Media) -> Spectrum {
        match (self.beyond, &self.material.border) {
            (Some(beyond), _) => beyond.absorption,
            (None, Some(border)) => media.beyond_declared(border, self.at.wo_local().z > 0.0),
            (None, None) => media.absorption,
        }
    }

    /// Notes in `media` that a scattered ray has gone through the surface.
    pub(crate) fn cross(&self, media: &mut Media) {
        match (self.beyond, &self.material.border) {
            (Some(beyond), _) => media.go_on(beyond),
            (None, Some(border)) => media.pass_declared(border, self.at.wo_local().z > 0.0),
            (None, None) => {}
        }
    }
}

/// The part of light that is left after `distance` metres: exp(−σ d), Beer's law.
pub(crate) fn transmittance(absorption: Spectrum, distance: f32) -> Spectrum {
    if absorption.is_black() {
        return Spectrum::WHITE;
    }
    absorption.map(|sigma| if sigma > 0.0 { real::exp(-sigma * distance) } else { 1.0 })
}
