//! The path tracer of `path.rs`, eight paths at a time.
//!
//! The story is the same, sentence by sentence, and so are the bits: a test
//! compares them. What most surfaces need (matte and smooth clear ones, lamps
//! made of triangles) is done for eight paths at once; where a path meets
//! something else, that is done for it alone, by the functions that `path.rs`
//! calls as well, and the eight go on together.
//!
//! Many paths are on their way at once, so that those that ended can be
//! replaced by others: see [`Paths`].
//!
//! Source: Laine, Karras, Aila, "Megakernels Considered Harmful", HPG 2013, for
//! paths that advance together; Lee et al., "Vectorized Production Path
//! Tracing", HPG 2017.

mod light;
mod met;
mod paths;
mod scatter;

pub(crate) use paths::Starts;

use super::Path;
use super::path::{ENDLESS_FROM, ENDLESS_SURVIVAL, ROULETTE_FROM, SURE_FROM};
use crate::color::Spectrum;
use crate::integrator::dimension::Bounce;
use crate::integrator::emission::SeenEmission;
use crate::integrator::estimate::Found;
use crate::integrator::first::View;
use crate::lanes::{bits, mask, transmittances};
use crate::medium::Media;
use crate::prepare::Prepared;
use crate::sampler::Sampler;
use crate::settings::Roulette;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, mask32x8};
use met::{MetPacket, Surface};
use paths::{PathPacket, Paths, add};
use rutilant_geom::lanes::{LANES, Xyz8, each_lane};
use rutilant_geom::offset_origins;

impl Path<'_> {
    /// What each start brings, eight for each packet, in their order.
    #[inline(always)]
    pub(super) fn trace_all<S: Simd, N: Sampler>(
        &self,
        simd: S,
        scene: &Prepared,
        starts: &[Starts<N>],
        view: Option<&View>,
        found: &mut Found,
        rays: &mut u64,
    ) {
        let mut paths = Paths::new(starts, scene);
        for depth in 1..=self.max_depth {
            for (i, packet) in paths.packets.iter_mut().enumerate() {
                // The first surfaces are those of the starts, in their order.
                let view = view.filter(|_| depth == 1).map(|view| (view, starts[i].looks));
                self.advance(simd, scene, packet, depth, view, found, &mut paths.media, rays);
            }
            if depth == 1 {
                // Of paths that have ended already there will be no more, and of others what they
                // see next.
                if !found.direct.is_empty() {
                    found.direct.copy_from_slice(&found.radiance);
                }
            }
            paths.close_ranks();
            if paths.packets.is_empty() {
                break;
            }
        }
    }

    /// Takes eight paths from one surface to the next. Those that end are no longer there then. With a
    /// `view` tells what they met, and more of it where there is a bit for the path.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "the state of the paths, and nothing else")]
    fn advance<S: Simd, N: Sampler>(
        &self,
        simd: S,
        scene: &Prepared,
        paths: &mut PathPacket<N>,
        depth: u32,
        view: Option<(&View, u32)>,
        found: &mut Found,
        media: &mut [Media],
        rays: &mut u64,
    ) {
        let Found { radiance, emission, direct, groups, objects, firsts, .. } = found;
        let there = paths.rays.there();
        *rays += u64::from(there.count_ones());

        // Find the next surfaces, or leave the scene, and lose what the media on the way take.
        let hits = scene.closest_packet(&paths.rays);
        let mut made = [None; LANES];
        let mut met = MetPacket::new(scene, &paths.rays, &hits, there, &mut made);
        let surface = met.surface(simd, &paths.rays);
        let Surface { normal, frame, wo, wo_local, .. } = surface;
        let mut throughput = Xyz8::load(simd, &paths.throughput);
        if scene.has_borders() {
            met.arrive(there, &wo_local.z, &paths.slot, media);
            throughput = throughput.times(transmittances(
                Xyz8::load(simd, &met.absorption),
                met.distance.simd_into(simd),
            ));
        }

        if let Some((view, looks)) = view {
            met.tell_firsts(scene, view, looks, &paths.rays, there, &paths.slot, objects, firsts);
        }

        // Light of the sky and of surfaces, weighted against having been chosen by light sampling.
        for lane in each_lane(met.sky | met.glows) {
            let ray = paths.rays.ray(lane);
            let seen = if met.sky >> lane & 1 == 1 {
                SeenEmission::of_sky(scene, &ray)
            } else {
                met.emission(scene, lane, -ray.direction)
            };
            if let Some(seen) = seen {
                let emitter = seen.emitter;
                let (previous, lead) = (paths.previous(lane), paths.lead(lane));
                let seen = self.weighted(scene, &seen, &ray, previous.as_ref(), lead, &mut ());
                let through = Spectrum::from(throughput.lane(lane).to_array());
                let slot = paths.slot[lane];
                add(radiance, slot, through * seen);
                if groups.are_told() {
                    groups.add(slot, scene.groups().of(emitter), through * seen);
                }
                let part = match depth {
                    1 => emission.get_mut(slot as usize),
                    2 => direct.get_mut(slot as usize),
                    _ => None,
                };
                if let Some(part) = part {
                    *part = radiance[slot as usize];
                }
            }
        }
        let alive = there & !met.sky & !met.black;
        if depth == self.max_depth || alive == 0 {
            paths.rays.keep(0);
            return;
        }

        // Light that arrives here directly from one light.
        let bounce = Bounce::at(depth);
        if met.spread & alive != 0 {
            self.direct_lights(
                simd, scene, paths, &met, &surface, alive, bounce, throughput, radiance, groups,
                media, rays,
            );
        }

        // Continue in directions drawn from the BSDFs.
        let sample = scatter::scatter(simd, &paths.samplers, &met, &surface, alive, bounce);
        throughput = throughput.times(sample.weight);
        let crossed = sample.valid & (sample.wi.z * wo_local.z).simd_lt(f32x8::splat(simd, 0.0));
        let on_surface = crossed | sample.delta | mask(simd, met.translucent);
        let side = wo.negated().or(crossed, wo);
        let origin = offset_origins(surface.position.or(on_surface, surface.smooth), normal, side);
        let direction = frame.to_world(sample.wi).normalized();
        paths.rays.leaves = met.left(normal, side, direction);
        paths.rays.origin = origin.store();
        paths.rays.direction = direction.store();
        paths.rays.t_min = [0.0; LANES];
        paths.rays.t_max = [f32::INFINITY; LANES];
        let unfindable = f32x8::splat(simd, PathPacket::<N>::UNFINDABLE);
        paths.pdf = sample.delta.select(unfindable, sample.pdf).into();
        if let Some(caustics) = &self.caustics {
            let valid = bits(sample.valid) & alive;
            met.lead(scene, caustics, paths, &surface, &sample, valid, depth);
        }
        let mut gain: f32x8<S> = paths.density_gain.simd_into(simd);
        for lane in each_lane(bits(crossed)) {
            if let Some(media) = media.get_mut(paths.slot[lane] as usize) {
                met.cross(lane, wo_local.z[lane] > 0.0, media);
            }
        }
        gain = crossed.select(gain * (sample.eta * sample.eta), gain);
        paths.density_gain = gain.into();

        // End dim paths by roulette; the survivors stand in for the ended.
        let mut alive = alive & bits(sample.valid);
        let worth = throughput.scaled(gain);
        let survival = self.survivals(depth, worth, &met, sample.delta);
        let one = f32x8::splat(simd, 1.0);
        let risky = survival.simd_lt(one);
        if bits(risky) & alive != 0 {
            let drawn = N::d1_of(simd, &paths.samplers, bounce.roulette());
            let ends = risky & drawn.simd_ge(survival);
            alive &= !bits(ends);
            let stands_for = risky.select(one / survival, one);
            throughput = throughput.scaled(stands_for);
        }
        paths.throughput = throughput.store();
        paths.rays.keep(alive);
    }

    /// The probabilities with which paths go on after their `depth`-th segment.
    #[inline(always)]
    fn survivals<S: Simd>(
        &self,
        depth: u32,
        worth: Xyz8<S>,
        met: &MetPacket<'_>,
        delta: mask32x8<S>,
    ) -> f32x8<S> {
        let simd = worth.x.token();
        let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
        let survival = match self.roulette {
            Roulette::Off => return one,
            Roulette::Throughput if depth < ROULETTE_FROM => one,
            Roulette::Throughput => (worth.largest() * (1.0 / SURE_FROM)).max(zero).min(one),
            Roulette::Albedo => {
                let mut albedo = [1.0; LANES];
                for (lane, albedo) in albedo.iter_mut().enumerate() {
                    if let Some(sent_back) = met.albedo_of(lane) {
                        *albedo = sent_back.max_channel().clamp(0.1, 1.0);
                    }
                }
                delta.select(one, albedo.simd_into(simd))
            }
        };
        let most = if depth < ENDLESS_FROM { 1.0 } else { ENDLESS_SURVIVAL };
        survival.min(f32x8::splat(simd, most))
    }
}
