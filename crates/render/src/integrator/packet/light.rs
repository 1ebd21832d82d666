//! Light that arrives directly from lights, at eight surfaces.

use super::met::{MetPacket, Surface};
use super::paths::{PathPacket, add};
use crate::color::Spectrum;
use crate::integrator::Path;
use crate::integrator::dimension::Bounce;
use crate::integrator::estimate::GroupLight;
use crate::lanes::{bits, mask, put, transmittances};
use crate::light::{EmitterSelection, FlatEmitter, ShadingPoint};
use crate::medium::Media;
use crate::prepare::Prepared;
use crate::sampler::Sampler;
use crate::settings::{Heuristic, Strategy};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8};
use rutilant_geom::lanes::{LANES, Xyz8, each_lane};
use rutilant_geom::{RayPacket, Vec2, offset_origins};
use std::f32::consts::FRAC_1_PI;

/// Ways to lights, as in [`EmitterSample`](crate::light::EmitterSample).
struct Ways<S: Simd> {
    wi: Xyz8<S>,
    radiance: Xyz8<S>,
    /// Of choosing the light and the point on it.
    pdf: f32x8<S>,
    /// The numbers of the lights.
    emitters: [u32; LANES],
    /// Where light arrives, a bit for each.
    some: u32,
    delta: u32,
    /// Lights at infinity.
    endless: u32,
    end: Xyz8<S>,
}

impl Path<'_> {
    /// Adds to `radiance`, and to its `groups`, what arrives at each of the surfaces from one light.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "the state of the paths, and nothing else")]
    pub(super) fn direct_lights<S: Simd, N: Sampler>(
        &self,
        simd: S,
        scene: &Prepared,
        paths: &mut PathPacket<N>,
        met: &MetPacket<'_>,
        surface: &Surface<S>,
        alive: u32,
        bounce: Bounce,
        throughput: Xyz8<S>,
        radiance: &mut [Spectrum],
        groups: &mut GroupLight,
        media: &[Media],
        rays: &mut u64,
    ) {
        let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
        let translucent = mask(simd, met.translucent);
        // Light may arrive on either side of a clear surface: seen from the surface itself.
        let reflected = offset_origins(surface.smooth, surface.normal, surface.wo);
        let from = surface.position.or(translucent, reflected);
        let wanted = alive & met.spread;
        let ways = self.ways(simd, scene, paths, met, surface, from, wanted, bounce);
        if ways.some == 0 {
            return;
        }

        // How the surfaces scatter it.
        let wi = surface.frame.to_local(ways.wi);
        let same_side = (surface.wo_local.z * wi.z).simd_gt(zero);
        let cos = wi.z.abs();
        let none = Xyz8::splat(simd, [0.0; 3]);
        let albedo = Xyz8::load(simd, &met.albedo);
        let mut scattered = albedo.scaled(cos * FRAC_1_PI).or(same_side, none);
        let mut bsdf_pdf = same_side.select(cos * FRAC_1_PI, zero);
        for lane in each_lane(ways.some & met.other) {
            let Some(material) = met.materials[lane] else { continue };
            let (wo, wi) = (surface.wo_local.lane(lane), wi.lane(lane));
            let (value, pdf) = material.bsdf.eval_cos_pdf(wo, wi);
            put(&mut scattered, lane, value.channels().into());
            bsdf_pdf[lane] = pdf;
        }
        let delta = mask(simd, ways.delta);
        let share = match self.strategy {
            Strategy::LightOnly => one,
            Strategy::BsdfOnly => delta.select(one, zero),
            Strategy::Both => {
                let ratio = bsdf_pdf / ways.pdf;
                let share = match self.heuristic {
                    Heuristic::Balance | Heuristic::Optimal => one / (one + ratio),
                    Heuristic::Power => one / (one + ratio * ratio),
                };
                delta.select(one, share)
            }
        };
        let unshadowed = scattered.times(ways.radiance).scaled(share / ways.pdf);
        let worth_it = ways.some & !bits(unshadowed.is_zero());
        if worth_it == 0 {
            return;
        }

        // Nothing may be in its way, on the side that it comes from.
        let beyond = (surface.wo_local.z * wi.z).simd_lt(zero);
        let mut origin = from;
        let side = surface.wo.negated().or(translucent & beyond, surface.wo);
        if met.translucent & worth_it != 0 {
            let on_surface = offset_origins(surface.position, surface.normal, side);
            origin = on_surface.or(translucent, from);
        }
        let endless = mask(simd, ways.endless);
        let way = ways.end - origin;
        let infinity = f32x8::splat(simd, f32::INFINITY);
        let asked = mask(simd, worth_it);
        let shadow = RayPacket {
            origin: origin.store(),
            direction: ways.wi.or(endless, way).store(),
            t_min: [0.0; LANES],
            t_max: asked.select(endless.select(infinity, one), -one).into(),
            leaves: met.left(surface.normal, side, ways.wi),
        };
        *rays += u64::from(worth_it.count_ones());
        let free = worth_it & !scene.occluded_packet(&shadow);
        let mut arrives = unshadowed;
        if scene.has_borders() {
            let mut sides = met.absorption;
            for lane in each_lane(free & bits(beyond)) {
                let Some(media) = media.get(paths.slot[lane] as usize) else { continue };
                let front = surface.wo_local.z[lane] > 0.0;
                let beyond = met.absorption_beyond(lane, front, media).channels();
                for (side, beyond) in sides.iter_mut().zip(beyond) {
                    side[lane] = beyond;
                }
            }
            let distance = endless.select(infinity, way.dot(way).sqrt());
            arrives = arrives.times(transmittances(Xyz8::load(simd, &sides), distance));
        }
        let light = throughput.times(arrives);
        for lane in each_lane(free) {
            let (slot, light) = (paths.slot[lane], light.lane(lane).to_array().into());
            add(radiance, slot, light);
            if groups.are_told() {
                groups.add(slot, scene.groups().of(ways.emitters[lane] as usize), light);
            }
        }
    }

    /// Chooses a light for each of the points `from`, and a point on it.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "the state of the paths, and nothing else")]
    fn ways<S: Simd, N: Sampler>(
        &self,
        simd: S,
        scene: &Prepared,
        paths: &mut PathPacket<N>,
        met: &MetPacket<'_>,
        surface: &Surface<S>,
        from: Xyz8<S>,
        wanted: u32,
        bounce: Bounce,
    ) -> Ways<S> {
        let mut chosen = [(0, 1.0); LANES];
        let mut some = wanted;
        if self.selection.chooses() {
            let u = N::d1_of(simd, &paths.samplers, bounce.light());
            let looks = self.selection.looks();
            let fine = if looks {
                N::d1_of(simd, &paths.samplers, bounce.light_finely())
            } else {
                f32x8::splat(simd, 0.0)
            };
            for lane in each_lane(wanted) {
                let mut point = ShadingPoint::open(from.lane(lane));
                if looks {
                    point.normal = met.lit_normal(lane, surface);
                    paths.light(lane, &point);
                }
                match self.selection.select(&point, u[lane], fine[lane]) {
                    Some(choice) => chosen[lane] = choice,
                    None => some &= !(1 << lane),
                }
            }
        } else if matches!(self.selection, EmitterSelection::None) {
            some = 0;
        }
        let [ux, uy] = N::d2_of(simd, &paths.samplers, bounce.light_point());

        // Points on glowing triangles and parallelograms far away; all other lights one by one.
        let mut lights = [&FlatEmitter::NONE; LANES];
        let mut others = 0;
        let mut pmf = [1.0; LANES];
        for lane in each_lane(some) {
            let (number, probability) = chosen[lane];
            pmf[lane] = probability;
            match scene.emitters()[number].flat() {
                Some(light) if !light.is_near(from.lane(lane)) => lights[lane] = light,
                _ => others |= 1 << lane,
            }
        }
        let flat = FlatEmitter::sample_all(simd, &lights, from, [ux, uy]);
        let mut ways = Ways {
            wi: flat.wi,
            radiance: flat.radiance,
            pdf: flat.pdf,
            emitters: chosen.map(|(number, _)| number as u32),
            end: flat.end,
            some: some & !others & bits(flat.some),
            delta: 0,
            endless: 0,
        };
        for lane in each_lane(some & others) {
            let (point, u) = (from.lane(lane), Vec2::new(ux[lane], uy[lane]));
            let Some(way) = scene.emitters()[chosen[lane].0].sample(point, u) else { continue };
            let bit = 1 << lane;
            ways.some |= bit;
            put(&mut ways.wi, lane, way.wi);
            put(&mut ways.radiance, lane, way.radiance.channels().into());
            ways.pdf[lane] = way.pdf;
            ways.delta |= u32::from(way.delta) << lane;
            match way.end {
                Some(end) => put(&mut ways.end, lane, end),
                None => ways.endless |= bit,
            }
        }
        let pmf: f32x8<S> = pmf.simd_into(simd);
        ways.pdf = pmf * ways.pdf;
        ways
    }
}
