//! Path tracing: where a ray becomes a colour.
//!
//! A path runs from the camera from surface to surface. At each it looks for
//! light in two ways, by choosing a point on a light and by following the
//! direction that the surface scatters, and weighs both by multiple importance
//! sampling. Dim paths end at random; survivors stand in for them.
//!
//! Caustics from small lights a path meets only by chance; `caustics.rs` helps with those.
//!
//! Source: Kajiya, "The Rendering Equation", SIGGRAPH 1986; Veach, *Robust
//! Monte Carlo Methods for Light Transport Simulation*, 1997, chapters 8 to 10.

use super::caustics::Caustics;
use super::control::Control;
use super::dimension::{BAND, Bounce};
use super::emission::SeenEmission;
use super::estimate::{Found, Integrator, Watched};
use super::first::View;
use super::packet::Starts;
use super::witness::Witness;
use crate::color::Spectrum;
use crate::follow::{follow, transmittance};
use crate::interaction::SurfaceInteraction;
use crate::light::{EmitterSelection, ShadingPoint};
use crate::prepare::{Prepared, PreparedMaterial};
use crate::sampler::Sampler;
use crate::settings::{Heuristic, Roulette, Strategy};
use rutilant_geom::{Ray, Vec3, with_vectors};

/// Path tracing with light and BSDF sampling.
pub(crate) struct Path<'a> {
    pub(crate) selection: EmitterSelection,
    pub(crate) strategy: Strategy,
    pub(crate) heuristic: Heuristic,
    pub(crate) roulette: Roulette,
    /// The longest path in segments.
    pub(crate) max_depth: u32,
    /// How light paths help with caustics, if they do.
    pub(crate) caustics: Option<Caustics<'a>>,
}

/// The surface that a path last left, where light sampling could have found what is met next.
pub(super) struct Previous {
    /// Where the ray started.
    pub(super) position: Vec3,
    /// For what a light was chosen there.
    pub(super) point: ShadingPoint,
    /// The density of the direction taken, in 1/sr.
    pub(super) pdf: f32,
}

impl Integrator for Path<'_> {
    fn radiance<S: Sampler>(
        &self,
        scene: &Prepared,
        camera_ray: Ray,
        sampler: &S,
        rays: &mut u64,
    ) -> Spectrum {
        self.trace(scene, camera_ray, sampler, rays, &mut ())
    }

    fn trace_together<S: Sampler>(
        &self,
        scene: &Prepared,
        starts: &[Starts<S>],
        view: Option<&View>,
        found: &mut Found,
        rays: &mut u64,
    ) -> bool {
        scene.is_plain()
            && !scene.disperses()
            && with_vectors!(scene.surfaces().level(), simd => {
                self.trace_all(simd, scene, starts, view, found, rays);
                true
            }, else false)
    }

    fn watched<S: Sampler>(
        &self,
        scene: &Prepared,
        ray: Ray,
        sampler: &S,
        (view, look): (&View, bool),
        groups: &mut [Spectrum],
        rays: &mut u64,
    ) -> Watched {
        let mut witness = Witness::new(scene, view, look, groups);
        let radiance = self.trace(scene, ray, sampler, rays, &mut witness);
        witness.told(radiance, 0.0)
    }

    fn caustics(&self) -> Option<&Caustics<'_>> {
        self.caustics.as_ref()
    }
}

impl Path<'_> {
    /// The radiance along `camera_ray`. Tells `control` how light was found.
    pub(super) fn trace<S: Sampler, C: Control>(
        &self,
        scene: &Prepared,
        camera_ray: Ray,
        sampler: &S,
        rays: &mut u64,
        control: &mut C,
    ) -> Spectrum {
        let mut radiance = Spectrum::BLACK;
        let mut throughput = Spectrum::WHITE;
        let mut ray = camera_ray;
        let mut previous: Option<Previous> = None;
        // What the path is inside of.
        let mut media = scene.camera_media();
        // Radiance is larger inside a dense medium by this factor; it will be lost on leaving.
        let mut density_gain = 1.0;
        // Set where light paths could have found what is met next: see `Caustics::lead`.
        let mut lead = 0.0;

        for depth in 1..=self.max_depth {
            // Find the next surface, or leave the scene, and lose what the media on the way take.
            let sent = ray;
            let mut made = None;
            let way = follow(scene, &mut ray, &mut media, &mut made, rays, &mut |glowing| {
                if let Some(emission) = SeenEmission::of_surface(scene, glowing.at) {
                    let previous = previous.as_ref().filter(|_| !glowing.beyond_passed);
                    control.carries(throughput * glowing.through);
                    let seen = self.weighted(scene, &emission, &sent, previous, 0.0, control);
                    radiance += throughput * glowing.through * seen;
                }
            });
            throughput *= way.through;
            control.carries(throughput);
            if way.passed {
                // Light sampling could not have come through.
                previous = None;
            }
            let Some(met) = way.met else {
                if let Some(sky) = SeenEmission::of_sky(scene, &ray) {
                    let (previous, lead) = (previous.as_ref(), lead / density_gain);
                    radiance +=
                        throughput * self.weighted(scene, &sky, &sent, previous, lead, control);
                }
                control.seen(depth, radiance);
                break;
            };
            let (at, material) = (&met.at, met.material);
            control.met(depth, &met);
            let wo = at.wo_local();

            // Light that starts here, weighted against having been chosen by light sampling.
            if let Some(emission) = SeenEmission::of_surface(scene, at) {
                let (previous, lead) = (previous.as_ref(), lead / density_gain);
                radiance +=
                    throughput * self.weighted(scene, &emission, &sent, previous, lead, control);
            }
            control.seen(depth, radiance);
            if depth == self.max_depth {
                break;
            }

            // Of colours that are bent differently here only one goes on.
            let mut room = None;
            let u = || sampler.d1(BAND);
            let (worth, material) = scene.in_one_band(material, &mut media, u, &mut room);
            throughput *= worth;
            control.carries(throughput);

            // Light that arrives here directly from one light.
            let bounce = Bounce::at(depth);
            let point = at.shading_point(&material.bsdf);
            if !material.bsdf.is_delta() {
                let beyond = met.absorption_beyond(&media);
                let sides = [media.absorption, beyond];
                radiance += throughput
                    * self.direct_light(
                        scene, at, &point, material, sides, sampler, bounce, rays, control,
                    );
            }

            // Continue in a direction drawn from the BSDF.
            let Some(sample) = bounce.scatter(&material.bsdf, wo, sampler) else { break };
            throughput *= sample.weight;
            let crossed = sample.is_transmission(wo);
            ray = at.scattered_ray(&material.bsdf, &sample, crossed);
            previous = (!sample.delta).then_some(Previous {
                position: ray.origin,
                point,
                pdf: sample.pdf,
            });
            lead = match &self.caustics {
                Some(caustics) if depth == 1 && !sample.delta => {
                    caustics.lead(at, met.hit.t, ray.direction, sample.pdf)
                }
                Some(_) if sample.delta && !material.one_sided => {
                    lead * at.squeeze(ray.direction).unwrap_or(0.0)
                }
                _ => 0.0,
            };
            if crossed {
                met.cross(&mut media);
                density_gain *= sample.eta * sample.eta;
            }

            // End dim paths by roulette; the survivors stand in for the ended.
            let worth = throughput * density_gain;
            let survival = survival(self.roulette, depth, worth, material, sample.delta);
            if survival < 1.0 {
                if sampler.d1(bounce.roulette()) >= survival {
                    break;
                }
                throughput *= 1.0 / survival;
                control.survived(1.0 / survival);
            }
        }
        radiance
    }

    /// Emission that this ray ran into, times the share that BSDF sampling has in
    /// finding it. Without a `previous` surface that is all of it, less what light paths find where
    /// there is a `lead`.
    pub(super) fn weighted<C: Control>(
        &self,
        scene: &Prepared,
        seen: &SeenEmission,
        ray: &Ray,
        previous: Option<&Previous>,
        lead: f32,
        control: &mut C,
    ) -> Spectrum {
        let share = match previous {
            None => match &self.caustics {
                Some(caustics) if lead > 0.0 => seen.caustic_share(caustics, lead, ray),
                _ => 1.0,
            },
            Some(p) => {
                let light_pdf =
                    || seen.light_pdf(scene, &self.selection, &p.point, p.position, ray.direction);
                match self.strategy {
                    Strategy::BsdfOnly => 1.0,
                    // What no light sample finds counts in full.
                    Strategy::LightOnly if light_pdf() == 0.0 => 1.0,
                    Strategy::LightOnly => 0.0,
                    Strategy::Both => {
                        let share = self.heuristic.share(p.pdf, light_pdf());
                        control.scattered(seen.radiance, 1.0 - share);
                        share
                    }
                }
            }
        };
        let light = seen.radiance * share;
        control.found(seen.emitter, light);
        light
    }

    /// Light from one light that is chosen for `point`, as `at` is seen by lights, times the share
    /// that light sampling has in finding it, scattered towards `wo`. `sides` are the absorptions on
    /// the side of `wo` and beyond the surface.
    #[expect(clippy::too_many_arguments, reason = "the state of the path, and nothing else")]
    fn direct_light<S: Sampler, C: Control>(
        &self,
        scene: &Prepared,
        at: &SurfaceInteraction,
        point: &ShadingPoint,
        material: &PreparedMaterial,
        sides: [Spectrum; 2],
        sampler: &S,
        bounce: Bounce,
        rays: &mut u64,
        control: &mut C,
    ) -> Spectrum {
        control.surface();
        let (translucent, from) = (material.bsdf.is_translucent(), point.position);
        let Some((emitter, pmf)) = bounce.select(&self.selection, point, sampler) else {
            return Spectrum::BLACK;
        };
        let light_point = sampler.d2(bounce.light_point());
        let Some(light) = scene.emitters()[emitter].sample(from, light_point) else {
            return Spectrum::BLACK;
        };
        let (wo, wi) = (at.wo_local(), at.shading.to_local(light.wi));
        let (scattered, bsdf_pdf) = material.bsdf.eval_cos_pdf(wo, wi);
        let pdf = pmf * light.pdf;
        let share = match self.strategy {
            _ if light.delta => 1.0,
            Strategy::LightOnly => 1.0,
            Strategy::BsdfOnly => 0.0,
            Strategy::Both => self.heuristic.share(pdf, bsdf_pdf),
        };
        let unshadowed = scattered * light.radiance * (share / pdf);
        if unshadowed.is_black() {
            return Spectrum::BLACK;
        }

        // Nothing may be in its way, on the side that it comes from.
        let beyond = wo.z * wi.z < 0.0;
        let origin = if translucent { at.surface_origin(beyond) } else { from };
        *rays += 1;
        if scene.occluded(&light.shadow_ray(origin)) {
            return Spectrum::BLACK;
        }
        let distance = light.end.map_or(f32::INFINITY, |end| origin.distance(end));
        let arrives = unshadowed * transmittance(sides[usize::from(beyond)], distance);
        control.light(arrives, 1.0 - share);
        control.found(emitter, arrives);
        arrives
    }
}

/// The probability with which a path goes on after its `depth`-th segment.
pub(super) fn survival(
    roulette: Roulette,
    depth: u32,
    worth: Spectrum,
    material: &PreparedMaterial,
    delta: bool,
) -> f32 {
    let survival = match roulette {
        Roulette::Off => return 1.0,
        Roulette::Albedo if delta => 1.0,
        Roulette::Albedo => material.albedo().max_channel().clamp(0.1, 1.0),
        Roulette::Throughput if depth < ROULETTE_FROM => 1.0,
        Roulette::Throughput => (worth.max_channel() * (1.0 / SURE_FROM)).clamp(0.0, 1.0),
    };
    // What is no number goes on, to be counted in the picture: `min` gives the other one.
    survival.min(if depth < ENDLESS_FROM { 1.0 } else { ENDLESS_SURVIVAL })
}

/// Segments before roulette by throughput may end a path. The first bounces carry most of the
/// picture; ending them saves few rays and adds much noise.
pub(super) const ROULETTE_FROM: u32 = 4;

/// Paths that are worth this much always go on, dimmer ones in proportion. To end those worth less
/// than 1 saves a twentieth of the rays of a Cornell box, and takes a fifth more samples to make up
/// for.
pub(super) const SURE_FROM: f32 = 0.5;

/// Segments after which even paths that lose nothing may end: light trapped in glass by total
/// reflection would go round for ever.
pub(super) const ENDLESS_FROM: u32 = 128;

/// How often such a path goes on. Less would end them sooner and make the survivors of light that
/// only takes long to get out too precious: their variance would not be finite.
pub(super) const ENDLESS_SURVIVAL: f32 = 0.98;

impl Heuristic {
    /// The share of a strategy of density `own` in what another of density `other` can find as well.
    pub(crate) fn share(self, own: f32, other: f32) -> f32 {
        // Ratios first: squares of large densities overflow.
        let ratio = other / own;
        match self {
            Self::Balance | Self::Optimal => 1.0 / (1.0 + ratio),
            Self::Power => 1.0 / (1.0 + ratio * ratio),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::{Bsdf, Lambert, Lobe};

    /// Whatever a path is worth, it survives with a probability: more than 1 would lose energy,
    /// as the 2017 program did, and less than 0 or NaN would be no roulette.
    #[test]
    fn survival_is_a_probability() {
        for roulette in [Roulette::Off, Roulette::Albedo, Roulette::Throughput] {
            for albedo in [0.0, 0.05, 0.7, 1.0, 3.0, f32::INFINITY, f32::NAN] {
                let lobe = Lambert { albedo: Spectrum::splat(albedo) };
                let material = Bsdf::from(Lobe::Lambert(lobe)).into();
                for worth in [0.0, 1e-30, 0.5, 1.0, 7.0, f32::INFINITY] {
                    for (depth, delta) in [1, 3, 4, 127, 128, u32::MAX].map(|d| (d, d % 2 == 0)) {
                        let worth = Spectrum::splat(worth);
                        let survival = survival(roulette, depth, worth, &material, delta);
                        assert!((0.0..=1.0).contains(&survival), "{roulette:?} {survival}");
                    }
                }
            }
        }
    }
}
