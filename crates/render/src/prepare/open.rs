//! Surfaces that are not everywhere: what rays meet of them.
//!
//! Whether a ray meets a surface that is there in part is decided by chance,
//! by a number made of the place and the ray's direction: the same ray meets
//! the same surface, whoever asks, alone or among others. Of surfaces in one
//! place each has its own chance, by how many the ray meets before it there.
//!
//! Surfaces that have only a front are not there for rays that come from behind. Light goes the
//! other way: what comes from behind is stopped, for the camera sees the front, and what comes
//! from the front goes on to whatever is behind, and lights the front as well
//! ([`Prepared::closest_packet_of_light`]).

use super::material::PreparedMaterial;
use super::prepared::Prepared;
use super::texture::TexturePlace;
use crate::follow::MOST_PASSES;
use crate::material::{Opacity, OpacityMode};
use crate::sampler::{GOLDEN, mix};
use rutilant_geom::lanes::each_lane;
use rutilant_geom::{Hit, HitPacket, Ray, RayPacket, Vec3};

/// Of more surfaces than that in one place, to the last bit, the others are not met: to look through
/// all of them again and again would take for ever.
const MOST_IN_ONE_PLACE: u32 = 16;

impl Prepared {
    /// The surface that a ray meets first.
    #[inline]
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        let hit = self.surfaces.closest(ray);
        if self.some_open { self.closest_there(ray, hit) } else { hit }
    }

    /// The surface that a ray meets next after `hit`, maybe in the same place.
    pub(crate) fn closest_after(&self, ray: &Ray, hit: &Hit) -> Option<Hit> {
        let next = self.surfaces.closest_after(ray, hit);
        if !self.some_open {
            return next;
        }
        let (next, before) = self.counted(ray, hit, next);
        self.closest_for(ray, next, before, |hit, before| self.is_there(ray, hit, before))
    }

    /// The same for eight rays, from their start on.
    #[inline(always)]
    pub(crate) fn closest_packet(&self, rays: &RayPacket) -> HitPacket {
        let mut hits = self.surfaces.closest_packet(rays);
        if self.some_open {
            self.see_past(rays, &mut hits);
        }
        hits
    }

    /// The same for eight rays of light: surfaces that have only a front are met from both sides,
    /// for whoever follows the light to decide.
    pub(crate) fn closest_packet_of_light(&self, rays: &RayPacket) -> HitPacket {
        let mut hits = self.surfaces.closest_packet(rays);
        if self.some_open {
            self.see_past_holes(rays, &mut hits);
        }
        hits
    }

    /// What a ray of light meets next in the very place of `hit`, if there is more.
    pub(crate) fn also_met_by_light(&self, ray: &Ray, hit: &Hit) -> Option<Hit> {
        let here = Ray { t_max: ray.t_max.min(hit.t.next_up()), ..*ray };
        let next = self.surfaces.closest_after(&here, hit);
        let (next, before) = self.counted(&here, hit, next);
        let is_whole = |hit: &Hit, before| self.is_whole(ray, hit, before);
        self.closest_for(&here, next, before, is_whole).filter(|next| next.t == hit.t)
    }

    /// Whether anything is in a ray's way that rays do not pass.
    #[inline]
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.surfaces.occluded(ray)
            && (!(self.some_pass || self.some_open) || self.occluded_beyond(ray))
    }

    /// The same for eight rays, a bit for each.
    #[inline(always)]
    pub(crate) fn occluded_packet(&self, rays: &RayPacket) -> u32 {
        let blocked = self.surfaces.occluded_packet(rays);
        if self.some_open { self.still_occluded(rays, blocked) } else { blocked }
    }

    #[inline(never)]
    fn see_past(&self, rays: &RayPacket, hits: &mut HitPacket) {
        for lane in each_lane(rays.there()) {
            let hit = hits.hit(lane);
            if hit.as_ref().is_some_and(|hit| self.may_be_open(&rays.ray(lane), hit)) {
                hits.set(lane, self.closest_there(&rays.ray(lane), hit).as_ref());
            }
        }
    }

    #[inline(never)]
    fn see_past_holes(&self, rays: &RayPacket, hits: &mut HitPacket) {
        for lane in each_lane(rays.there()) {
            let hit = hits.hit(lane);
            if hit.as_ref().is_some_and(|hit| self.material_at(hit).opacity.is_some()) {
                let ray = rays.ray(lane);
                let is_whole = |hit: &Hit, before| self.is_whole(&ray, hit, before);
                let there = self.closest_for(&ray, hit, 0, is_whole);
                hits.set(lane, there.as_ref());
            }
        }
    }

    #[inline(never)]
    fn still_occluded(&self, rays: &RayPacket, blocked: u32) -> u32 {
        each_lane(blocked)
            .filter(|&lane| self.occluded_beyond(&rays.ray(lane)))
            .fold(0, |all, lane| all | 1 << lane)
    }

    /// What a ray meets first of what is there, if the first surface on its way is `hit`.
    #[inline(never)]
    fn closest_there(&self, ray: &Ray, hit: Option<Hit>) -> Option<Hit> {
        self.closest_for(ray, hit, 0, |hit, before| self.is_there(ray, hit, before))
    }

    /// The same where `is_there` says what is, and the ray has met so many surfaces `before` in the
    /// same place.
    fn closest_for(
        &self,
        ray: &Ray,
        mut hit: Option<Hit>,
        mut before: u32,
        is_there: impl Fn(&Hit, u32) -> bool,
    ) -> Option<Hit> {
        for _ in 0..MOST_PASSES {
            let met = hit?;
            if is_there(&met, before) {
                return hit;
            }
            (hit, before) = self.next_of(ray, &met, self.surfaces.closest_after(ray, &met), before);
        }
        hit
    }

    /// The surface that a ray meets after `hit`, if `next` is the next one there may be, with how many
    /// the ray has met before it in the same place; `before` is that number for `hit`.
    fn next_of(&self, ray: &Ray, hit: &Hit, next: Option<Hit>, before: u32) -> (Option<Hit>, u32) {
        match next {
            Some(next) if next.t == hit.t && before + 1 < MOST_IN_ONE_PLACE => {
                (Some(next), before + 1)
            }
            Some(next) if next.t == hit.t => {
                let beyond = Ray { t_min: hit.t.next_up(), ..*ray };
                (self.surfaces.closest(&beyond), 0)
            }
            next => (next, 0),
        }
    }

    /// The same where nobody has counted.
    fn counted(&self, ray: &Ray, hit: &Hit, next: Option<Hit>) -> (Option<Hit>, u32) {
        if next.is_none_or(|next| next.t != hit.t) {
            return (next, 0);
        }
        let t_min = ray.t_min.max(hit.t.next_down());
        let here = Ray { t_min, t_max: ray.t_max.min(hit.t.next_up()), ..*ray };
        let first = self.surfaces.closest(&here);
        let all = std::iter::successors(first, |met| self.surfaces.closest_after(&here, met));
        let here = all.take(MOST_IN_ONE_PLACE as usize).filter(|met| met.t == hit.t);
        self.next_of(ray, hit, next, here.take_while(|met| met != hit).count() as u32)
    }

    /// Whether a ray is stopped although it passes some surfaces.
    #[inline(never)]
    fn occluded_beyond(&self, ray: &Ray) -> bool {
        let (mut hit, mut before) = (self.surfaces.closest(ray), 0);
        for _ in 0..MOST_PASSES {
            let Some(met) = hit else { return false };
            if !self.material_at(&met).passes && self.is_there(ray, &met, before) {
                return true;
            }
            (hit, before) = self.next_of(ray, &met, self.surfaces.closest_after(ray, &met), before);
        }
        true
    }

    fn material_at(&self, hit: &Hit) -> &PreparedMaterial {
        &self.materials[self.object(hit).material as usize]
    }

    fn may_be_open(&self, ray: &Ray, hit: &Hit) -> bool {
        let material = self.material_at(hit);
        material.opacity.is_some() || material.one_sided && comes_from_behind(ray, hit)
    }

    /// Whether there is something where a ray meets a surface, after so many `before` in that place.
    fn is_there(&self, ray: &Ray, hit: &Hit, before: u32) -> bool {
        let only_behind = self.material_at(hit).one_sided && comes_from_behind(ray, hit);
        !only_behind && self.is_whole(ray, hit, before)
    }

    /// Whether there is no hole where a ray meets a surface, after so many `before` in that place.
    fn is_whole(&self, ray: &Ray, hit: &Hit, before: u32) -> bool {
        let object = self.object(hit);
        let Some(number) = self.materials[object.material as usize].opacity else { return true };
        let opacity = &self.opacities[number as usize];
        let amount = self.opacity_at(opacity, hit);
        match opacity.mode {
            OpacityMode::Mask { cutoff } => amount >= cutoff,
            OpacityMode::Blend => chance(ray, hit, before) < amount,
        }
    }

    /// How much of a surface is there.
    fn opacity_at(&self, opacity: &Opacity, hit: &Hit) -> f32 {
        let place = TexturePlace::new(self, self.object(hit), hit);
        let own = if opacity.vertex_colors { place.vertex_color()[3] } else { 1.0 };
        self.textures.scalar(&opacity.amount, &place) * own
    }
}

/// Whether a ray meets the back of a surface.
fn comes_from_behind(ray: &Ray, hit: &Hit) -> bool {
    hit.normal.dot(ray.direction) > 0.0
}

/// A number in [0, 1) for a ray at a surface, after so many `before` in that place, as good as drawn
/// at random. Numbers of surfaces and objects do not tell: they depend on what is stored how.
fn chance(ray: &Ray, hit: &Hit, before: u32) -> f32 {
    let vectors = [ray.direction, hit.position];
    let words = vectors.iter().flat_map(Vec3::to_array).chain([hit.t]).map(f32::to_bits);
    let words = words.chain((before > 0).then_some(before));
    let hash = words.fold(0_u64, |hash, word| mix((hash ^ u64::from(word)).wrapping_add(GOLDEN)));
    (hash >> 40) as f32 / (1 << 24) as f32
}
