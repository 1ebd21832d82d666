//! Surfaces that are not everywhere: what rays meet of them.
//!
//! Whether a ray meets a surface that is there in part is decided by chance,
//! by a number made of the place and the ray's direction: the same ray meets
//! the same surface, whoever asks, alone or among others.
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
use rutilant_geom::{Hit, HitPacket, Ray, RayPacket};

impl Prepared {
    /// The surface that a ray meets first.
    #[inline]
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        let hit = self.surfaces.closest(ray);
        if self.some_open { self.closest_there(ray, hit) } else { hit }
    }

    /// The same for eight rays.
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
                let there = self.closest_for(&ray, hit, |hit| self.is_whole(&ray, hit));
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
        self.closest_for(ray, hit, |hit| self.is_there(ray, hit))
    }

    /// The same where `is_there` says what is.
    fn closest_for(
        &self,
        ray: &Ray,
        mut hit: Option<Hit>,
        is_there: impl Fn(&Hit) -> bool,
    ) -> Option<Hit> {
        let mut ahead = *ray;
        for _ in 0..MOST_PASSES {
            let met = hit?;
            if is_there(&met) {
                return hit;
            }
            ahead.t_min = met.t.next_up();
            hit = self.surfaces.closest(&ahead);
        }
        hit
    }

    /// Whether a ray is stopped although it passes some surfaces.
    #[inline(never)]
    fn occluded_beyond(&self, ray: &Ray) -> bool {
        let mut ahead = *ray;
        for _ in 0..MOST_PASSES {
            let Some(hit) = self.surfaces.closest(&ahead) else { return false };
            if !self.material_at(&hit).passes && self.is_there(ray, &hit) {
                return true;
            }
            ahead.t_min = hit.t.next_up();
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

    /// Whether there is something where a ray meets a surface.
    fn is_there(&self, ray: &Ray, hit: &Hit) -> bool {
        let only_behind = self.material_at(hit).one_sided && comes_from_behind(ray, hit);
        !only_behind && self.is_whole(ray, hit)
    }

    /// Whether there is no hole where a ray meets a surface.
    fn is_whole(&self, ray: &Ray, hit: &Hit) -> bool {
        let object = self.object(hit);
        let Some(number) = self.materials[object.material as usize].opacity else { return true };
        let opacity = &self.opacities[number as usize];
        let amount = self.opacity_at(opacity, hit);
        match opacity.mode {
            OpacityMode::Mask { cutoff } => amount >= cutoff,
            OpacityMode::Blend => chance(ray, hit) < amount,
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

/// A number in [0, 1) for a ray at a surface, as good as drawn at random.
fn chance(ray: &Ray, hit: &Hit) -> f32 {
    let words = ray.direction.to_array().into_iter().chain(hit.position.to_array());
    let hash = words
        .chain([hit.t])
        .fold(0_u64, |hash, word| mix((hash ^ u64::from(word.to_bits())).wrapping_add(GOLDEN)));
    (hash >> 40) as f32 / (1 << 24) as f32
}
