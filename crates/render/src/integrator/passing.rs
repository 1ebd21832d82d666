//! Surfaces that glow and do not scatter: rays pass them as if they were not there.

use super::emission::SeenEmission;
use crate::interaction::SurfaceInteraction;
use crate::prepare::Prepared;
use rutilant_geom::{Hit, Ray};

/// The first surface on a ray's way that scatters. What glows before it without scattering is
/// handed to `passed`, with its distance from the ray's origin.
pub(super) fn next_surface(
    scene: &Prepared,
    ray: &Ray,
    mut passed: impl FnMut(&SeenEmission, f32),
) -> Option<(Hit, SurfaceInteraction)> {
    let mut ahead = *ray;
    loop {
        let hit = scene.closest(&ahead)?;
        let at = scene.interaction(&hit, ray.direction);
        if !scene.material(&at).passes {
            return Some((hit, at));
        }
        if let Some(glow) = SeenEmission::of_surface(scene, &at) {
            passed(&glow, hit.t);
        }
        // Every step leaves at least this surface behind.
        ahead.t_min = hit.t.next_up();
    }
}
