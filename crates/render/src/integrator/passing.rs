//! Surfaces that glow and do not scatter: rays pass them as if they were not there.

use super::emission::SeenEmission;
use crate::color::Spectrum;
use crate::prepare::Prepared;
use rutilant_geom::Ray;

/// The light of what glows without scattering before the first surface that scatters, each times
/// what `share` gives for it and its distance. The ray then starts behind all of it.
pub(super) fn light_passed(
    scene: &Prepared,
    ray: &mut Ray,
    share: impl Fn(&SeenEmission, f32) -> Spectrum,
) -> Spectrum {
    let mut sum = Spectrum::BLACK;
    while let Some(hit) = scene.closest(ray) {
        let at = scene.interaction(&hit, ray.direction);
        if !scene.material(&at).passes {
            break;
        }
        if let Some(glow) = SeenEmission::of_surface(scene, &at) {
            sum += share(&glow, hit.t);
        }
        // Every step leaves at least this surface behind.
        ray.t_min = hit.t.next_up();
    }
    sum
}
