//! The surfaces that eight paths met.

use super::paths::PathPacket;
use crate::bsdf::{BsdfSamples, Scattering};
use crate::color::Spectrum;
use crate::integrator::Caustics;
use crate::integrator::emission::SeenEmission;
use crate::integrator::first::{First, View};
use crate::interaction::SurfaceInteraction;
use crate::lanes::bits;
use crate::medium::{Border, Media};
use crate::prepare::{Prepared, PreparedMaterial};
use crate::sampler::Sampler;
use crate::texture::ColorInput;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, u32x8};
use rutilant_geom::lanes::{LANES, Xyz8, at, each_lane};
use rutilant_geom::{Frames, HitPacket, RayPacket, Vec3};

/// Eight surface points.
pub(super) struct Surface<S: Simd> {
    pub(super) position: Xyz8<S>,
    /// Where diffusely scattered rays start.
    pub(super) smooth: Xyz8<S>,
    pub(super) normal: Xyz8<S>,
    pub(super) frame: Frames<S>,
    pub(super) wo: Xyz8<S>,
    pub(super) wo_local: Xyz8<S>,
}

/// Where eight paths met surfaces. Arrays are (coordinate, path); sets have a bit for each path.
pub(super) struct MetPacket<'p> {
    hits: &'p HitPacket,
    shading_normal: [[f32; LANES]; 3],
    smooth_position: [[f32; LANES]; 3],
    /// The way to the surface; infinite to the sky.
    pub(super) distance: [f32; LANES],
    pub(super) materials: [Option<&'p PreparedMaterial>; LANES],
    emitters: [Option<u32>; LANES],
    /// What absorbs on the side that the path comes from, in 1/m.
    pub(super) absorption: [[f32; LANES]; 3],
    pub(super) albedo: [[f32; LANES]; 3],
    pub(super) eta: [f32; LANES],
    /// Paths that left the scene.
    pub(super) sky: u32,
    /// Surfaces that look smoother than they are.
    smoothed: u32,
    /// Surfaces that are lights.
    pub(super) glows: u32,
    pub(super) black: u32,
    pub(super) lambert: u32,
    pub(super) dielectric: u32,
    pub(super) other: u32,
    /// Surfaces on which light sampling makes sense.
    pub(super) spread: u32,
    /// Of these the ones through which light may come.
    pub(super) translucent: u32,
}

/// A material that varies, `made` as it is where it was hit. Apart, so that the common way stays
/// short.
#[inline(never)]
fn varied_at<'p>(
    scene: &Prepared,
    hits: &HitPacket,
    lane: usize,
    direction: Vec3,
    smoothed: Option<SurfaceInteraction>,
    material: &'p PreparedMaterial,
    made: &'p mut Option<PreparedMaterial>,
) -> &'p PreparedMaterial {
    let Some(hit) = hits.hit(lane) else { return material };
    let at = smoothed.unwrap_or_else(|| scene.interaction(&hit, direction));
    match scene.varied_at(&hit, &at, material) {
        Some(varied) => made.insert(varied),
        None => material,
    }
}

impl<'p> MetPacket<'p> {
    #[inline(always)]
    pub(super) fn new(
        scene: &'p Prepared,
        rays: &RayPacket,
        hits: &'p HitPacket,
        there: u32,
        made: &'p mut [Option<PreparedMaterial>; LANES],
    ) -> Self {
        let mut met = Self {
            hits,
            shading_normal: hits.normal,
            smooth_position: hits.position,
            distance: hits.t,
            materials: [None; LANES],
            emitters: [None; LANES],
            absorption: [[0.0; LANES]; 3],
            albedo: [[0.0; LANES]; 3],
            eta: [1.0; LANES],
            sky: 0,
            smoothed: 0,
            glows: 0,
            black: 0,
            lambert: 0,
            dielectric: 0,
            other: 0,
            spread: 0,
            translucent: 0,
        };
        let mut painted = [None; LANES];
        for (lane, made) in made.iter_mut().enumerate() {
            let bit = 1 << lane;
            if there & bit == 0 {
                continue;
            }
            let primitive = hits.primitive[lane];
            if primitive == HitPacket::NOTHING {
                met.sky |= bit;
                met.distance[lane] = f32::INFINITY;
                continue;
            }
            let surface = scene.surface_of(hits.instance(lane), primitive);
            let direction = at(&rays.direction, lane);
            let mut smoothed = None;
            if surface.smoothed
                && let Some(hit) = hits.hit(lane)
            {
                met.smoothed |= bit;
                let at = smoothed.insert(scene.interaction(&hit, direction));
                met.smooth(lane, at);
            }
            met.emitters[lane] = surface.emitter;
            met.glows |= u32::from(surface.emitter.is_some()) << lane;
            let material = match surface.material {
                plain if !plain.varies() => plain,
                varying => {
                    painted[lane] = scene.painted_lambert(varying);
                    if painted[lane].is_some() {
                        met.materials[lane] = Some(varying);
                        continue;
                    }
                    varied_at(scene, hits, lane, direction, smoothed, varying, made)
                }
            };
            met.materials[lane] = Some(material);
            match material.bsdf.scattering() {
                Scattering::Black => met.black |= bit,
                Scattering::Lambert(albedo) => met.set_lambert(lane, albedo),
                Scattering::Dielectric(eta) => {
                    met.dielectric |= bit;
                    met.eta[lane] = eta;
                }
                Scattering::Other => {
                    met.other |= bit;
                    met.spread |= u32::from(!material.bsdf.is_delta()) << lane;
                    met.translucent |= u32::from(material.bsdf.is_translucent()) << lane;
                }
            }
        }
        if painted.iter().any(Option::is_some) {
            met.paint(scene, &painted);
        }
        met
    }

    /// Looks up the albedos of surfaces that are matte and vary.
    #[inline(never)]
    fn paint(&mut self, scene: &Prepared, painted: &[Option<&ColorInput>; LANES]) {
        let mut sought = [None; LANES];
        for (lane, sought) in sought.iter_mut().enumerate() {
            if let (Some(albedo), Some(hit)) = (painted[lane], self.hits.hit(lane)) {
                *sought = Some(scene.seek_color(albedo, &hit));
            }
        }
        for (lane, sought) in sought.iter().enumerate() {
            let Some(sought) = sought else { continue };
            let albedo = sought.reflectance();
            match albedo.max_channel() > 0.0 {
                true => self.set_lambert(lane, albedo),
                false => self.black |= 1 << lane,
            }
        }
    }

    #[inline(always)]
    fn set_lambert(&mut self, lane: usize, albedo: Spectrum) {
        self.lambert |= 1 << lane;
        self.spread |= 1 << lane;
        let [r, g, b] = albedo.channels();
        (self.albedo[0][lane], self.albedo[1][lane], self.albedo[2][lane]) = (r, g, b);
    }

    /// A point on a triangle with vertex normals.
    #[inline(never)]
    fn smooth(&mut self, lane: usize, at: &SurfaceInteraction) {
        for axis in 0..3 {
            self.shading_normal[axis][lane] = at.shading.z[axis];
            self.smooth_position[axis][lane] = at.smooth_position()[axis];
        }
    }

    /// About what part of white light a surface sends on.
    pub(super) fn albedo_of(&self, lane: usize) -> Option<Spectrum> {
        if self.lambert >> lane & 1 == 1 {
            return Some(at(&self.albedo, lane).to_array().into());
        }
        Some(self.materials[lane]?.albedo())
    }

    /// Tells what the camera rays `there` met first, and more of it where there is a bit in `looks`.
    #[inline(never)]
    #[expect(clippy::too_many_arguments, reason = "the state of the paths, and nothing else")]
    pub(super) fn tell_firsts(
        &self,
        scene: &Prepared,
        view: &View,
        looks: u32,
        rays: &RayPacket,
        there: u32,
        slot: &[u32; LANES],
        objects: &mut [u32],
        firsts: &mut Vec<(u32, First)>,
    ) {
        let met = there & !self.sky;
        for lane in each_lane(met) {
            if let Some(object) = objects.get_mut(slot[lane] as usize) {
                *object = scene.object_of(self.hits.instance(lane), self.hits.primitive[lane]);
            }
        }
        if looks & met == 0 || !view.looks() {
            return;
        }
        for lane in each_lane(met & looks) {
            let Some(hit) = self.hits.hit(lane) else { continue };
            let black = self.black >> lane & 1 == 1;
            let albedo = || match self.albedo_of(lane) {
                Some(albedo) if !black => albedo,
                Some(_) | None => Spectrum::BLACK,
            };
            let (normal, wo) = (at(&self.shading_normal, lane), -at(&rays.direction, lane));
            firsts.push((slot[lane], view.first(scene, &hit, normal, wo, albedo)));
        }
    }

    /// The points themselves, seen along the directions of `rays`.
    #[inline(always)]
    pub(super) fn surface<S: Simd>(&self, simd: S, rays: &RayPacket) -> Surface<S> {
        let frame = Frames::around(Xyz8::load(simd, &self.shading_normal));
        let wo = Xyz8::load(simd, &rays.direction).negated();
        Surface {
            position: Xyz8::load(simd, &self.hits.position),
            smooth: Xyz8::load(simd, &self.smooth_position),
            normal: Xyz8::load(simd, &self.hits.normal),
            frame,
            wo,
            wo_local: frame.to_local(wo),
        }
    }

    /// The normal of [`SurfaceInteraction::shading_point`].
    #[inline(always)]
    pub(super) fn lit_normal<S: Simd>(&self, lane: usize, surface: &Surface<S>) -> Vec3 {
        let normal = at(&self.shading_normal, lane);
        match self.translucent >> lane & 1 {
            1 => Vec3::ZERO,
            _ if surface.wo_local.z[lane] > 0.0 => normal,
            _ => -normal,
        }
    }

    /// The surfaces that rays do not meet again: they start on this side of them and go there.
    #[inline(always)]
    pub(super) fn left<S: Simd>(
        &self,
        normal: Xyz8<S>,
        side: Xyz8<S>,
        direction: Xyz8<S>,
    ) -> [u32; LANES] {
        /// A direction nearer to the surface than this may be on either side of it.
        const CLEARLY: f32 = 1e-5;
        let simd = normal.x.token();
        let cos = normal.dot(direction);
        let up = (normal.dot(side) * cos).simd_gt(f32x8::splat(simd, 0.0));
        let leaves = up & cos.abs().simd_gt(f32x8::splat(simd, CLEARLY));
        let nothing = u32x8::splat(simd, HitPacket::NOTHING);
        // Numbers within instances are not those of triangles that stand alone.
        let instance: u32x8<S> = self.hits.instance.simd_into(simd);
        let leaves = leaves & instance.simd_eq(nothing);
        leaves.select(self.hits.primitive.simd_into(simd), nothing).into()
    }

    /// Light that starts at a surface, towards `wo`.
    #[inline(always)]
    pub(super) fn emission(&self, scene: &Prepared, lane: usize, wo: Vec3) -> Option<SeenEmission> {
        let (position, normal) = (at(&self.hits.position, lane), at(&self.hits.normal, lane));
        let seen = SeenEmission::of_emitter(scene, self.emitters[lane]?, position, normal, wo)?;
        match self.hits.hit(lane).and_then(|hit| scene.glow_at(&hit)) {
            Some(glow) => seen.painted(glow),
            None => Some(seen),
        }
    }

    #[inline(always)]
    fn border(&self, lane: usize) -> Option<&Border> {
        self.materials[lane]?.border.as_ref()
    }

    /// Notes that the paths have come to borders, and what absorbs on the way to them.
    #[inline(always)]
    pub(super) fn arrive<S: Simd>(
        &mut self,
        there: u32,
        cos: &f32x8<S>,
        slot: &[u32; LANES],
        media: &mut [Media],
    ) {
        for lane in each_lane(there) {
            let Some(media) = media.get_mut(slot[lane] as usize) else { continue };
            if let Some(border) = self.border(lane) {
                media.arrive_declared(border, cos[lane] > 0.0);
            }
            let [r, g, b] = media.absorption.channels();
            let all = &mut self.absorption;
            (all[0][lane], all[1][lane], all[2][lane]) = (r, g, b);
        }
    }

    /// What absorbs on the other side of a surface, in 1/m.
    #[inline(always)]
    pub(super) fn absorption_beyond(
        &self,
        lane: usize,
        from_front: bool,
        media: &Media,
    ) -> Spectrum {
        match self.border(lane) {
            Some(border) => media.beyond_declared(border, from_front),
            None => media.absorption,
        }
    }

    /// Notes in `media` that a path has gone through the surface.
    #[inline(always)]
    pub(super) fn cross(&self, lane: usize, from_front: bool, media: &mut Media) {
        if let Some(border) = self.border(lane) {
            media.pass_declared(border, from_front);
        }
    }

    /// Notes how paths that go on as `sample` says can be found by light paths: see
    /// [`Caustics::lead`].
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "the state of the paths, and nothing else")]
    pub(super) fn lead<S: Simd, N: Sampler>(
        &self,
        scene: &Prepared,
        caustics: &Caustics<'_>,
        paths: &mut PathPacket<N>,
        surface: &Surface<S>,
        sample: &BsdfSamples<S>,
        which: u32,
        depth: u32,
    ) {
        let delta = bits(sample.delta);
        if depth == 1 {
            for lane in each_lane(which & !delta & !self.smoothed) {
                let (normal, wo) = (surface.normal.lane(lane), surface.wo.lane(lane));
                let wi = at(&paths.rays.direction, lane);
                let distance = self.distance[lane];
                paths.lead[lane] = caustics.lead_at(normal, wo, distance, wi, sample.pdf[lane]);
            }
            return;
        }
        let led =
            paths.lead.iter().enumerate().fold(0, |all, (i, l)| all | u32::from(*l > 0.0) << i);
        let one_sided = |lane: usize| self.materials[lane].is_some_and(|m| m.one_sided);
        let onward = each_lane(led & delta)
            .filter(|&lane| !one_sided(lane))
            .fold(0, |all, lane| all | 1 << lane);
        for lane in each_lane(which & led & !onward) {
            paths.lead[lane] = 0.0;
        }
        for lane in each_lane(which & onward & self.smoothed) {
            let came = surface.wo.negated().lane(lane);
            let squeeze = self.hits.hit(lane).and_then(|hit| {
                scene.interaction(&hit, came).squeeze(at(&paths.rays.direction, lane))
            });
            paths.lead[lane] *= squeeze.unwrap_or(0.0);
        }
    }
}
