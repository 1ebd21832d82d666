//! Caustics: light of lamps and skies that glass and mirrors throw on other surfaces.
//!
//! A path from the camera finds it only when it happens to leave a matte surface in just the
//! direction that leads through the glass to the lamp. A light path finds it with ease: it starts
//! at the lamp, is aimed at what throws light, follows that while it is sent on in single
//! directions, and looks from where it comes down on anything else whether the camera sees it.
//!
//! Both ways are weighted against each other by the balance heuristic. Along a chain of clear
//! surfaces n² dA cos θ dω stays what it is, so the densities of both compare where the chain ends,
//! without a word about what happened on it: both choose alike between reflection and refraction.
//!
//! Not for what the camera sees through glass, nor for what comes by way of rough surfaces: that is
//! left to paths from the camera, as is all light in scenes where `Prepared::casting` is none.
//!
//! Source: Arvo, "Backward Ray Tracing", SIGGRAPH 1986 course notes; Veach 1997, sections 5.2,
//! 5.3 and 10.2.

use super::dimension::{Bounce, light_path};
use super::path::survival;
use crate::camera::PreparedCamera;
use crate::color::Spectrum;
use crate::film::{FilterSampler, Splat, Splats};
use crate::follow::transmittance;
use crate::interaction::SurfaceInteraction;
use crate::light::{EmitterSample, Glow};
use crate::medium::Media;
use crate::prepare::{Casting, Outlook, Prepared, PreparedMaterial};
use crate::sampler::Sampler;
use crate::settings::Roulette;
use rutilant_geom::lanes::LANES;
use rutilant_geom::{Hit, Ray, RayPacket, Vec2, Vec3, offset_origin};

/// How light paths and paths from the camera share caustics.
#[derive(Clone, Copy)]
pub(crate) struct Caustics<'a> {
    scene: &'a Prepared,
    camera: &'a PreparedCamera,
    casting: &'a Casting,
    filter: &'a FilterSampler,
    /// Of the whole picture.
    pixels: f32,
    /// Light paths for each sample of all pixels, as far as pixels see where they come down.
    paths: f32,
    /// The longest path in segments.
    max_depth: u32,
    roulette: Roulette,
}

/// A light path on its way.
struct LightPath<S> {
    ray: Ray,
    /// Light sent along it over the density with which it was chosen, per projected area and solid
    /// angle.
    weight: Spectrum,
    /// That density, as it is here.
    density: f32,
    /// The part of its light that is left.
    left: Spectrum,
    /// Segments so far.
    depth: u32,
    media: Media,
    sampler: S,
}

impl<S> LightPath<S> {
    /// `None` where it could not have been chosen.
    fn new(ray: Ray, radiance: Spectrum, density: f32, media: Media, sampler: S) -> Option<Self> {
        let (left, depth) = (Spectrum::WHITE, 0);
        let weight = radiance / density;
        (density > 0.0 && density.is_finite()).then_some(Self {
            ray,
            weight,
            density,
            left,
            depth,
            media,
            sampler,
        })
    }
}

/// What would come to the camera if nothing were in its way.
struct Arrival {
    shadow_ray: Ray,
    splat: Splat,
}

impl<'a> Caustics<'a> {
    /// There is a light path for so many paths from the camera: more would find little more, and
    /// take longer.
    pub(crate) const EVERY: u64 = 16;

    /// `None` where there are none that light paths could find.
    pub(crate) fn new(
        scene: &'a Prepared,
        camera: &'a PreparedCamera,
        filter: &'a FilterSampler,
        size: [u32; 2],
        max_depth: u32,
        roulette: Roulette,
    ) -> Option<Self> {
        let casting = scene.casting()?;
        let pixels: f32 = size.into_iter().map(|side| side as f32).product();
        let paths = filter.coverage() * pixels / Self::EVERY as f32;
        Some(Self { scene, camera, casting, filter, pixels, paths, max_depth, roulette })
    }

    /// How dense light paths are at the surface `at`, which a path from the camera saw over
    /// `distance` metres and left along `wi` with density `pdf`, in units of that path's own
    /// density: for each unit of density, per projected area and solid angle, with which they set
    /// out. 0 where light paths do not look.
    ///
    /// The path takes this along. Clear surfaces change it only by [`SurfaceInteraction::squeeze`]
    /// and by the squares of their indices, and where it ends on a light, [`share`](Self::share)
    /// knows how light paths set out there.
    pub(super) fn lead(&self, at: &SurfaceInteraction, distance: f32, wi: Vec3, pdf: f32) -> f32 {
        if !at.is_flat() {
            return 0.0;
        }
        self.lead_at(at.normal, at.wo, distance, wi, pdf)
    }

    /// The same of a surface whose normal is what it looks like.
    #[inline]
    pub(super) fn lead_at(&self, normal: Vec3, wo: Vec3, distance: f32, wi: Vec3, pdf: f32) -> f32 {
        let seen = self.camera.pixels_per_area(-wo, distance) * normal.dot(wo).abs() * pdf;
        self.paths * normal.dot(wi).abs() / seen
    }

    /// The share that a path from the camera has in light that it met along `direction`, after a
    /// chain of clear surfaces, at `position` on the emitter of this number. `lead` is what the
    /// path brought along. Of the sky, `position` is any point on the ray.
    pub(super) fn share(
        &self,
        lead: f32,
        emitter: usize,
        position: Vec3,
        normal: Vec3,
        direction: Vec3,
    ) -> f32 {
        let density = match self.scene.emitters()[emitter].glow() {
            Some(Glow { two_sided, .. }) => {
                let from = Outlook { position, normal, two_sided: *two_sided };
                self.density(emitter, &from, -direction)
            }
            None => self.sky_density(position, direction),
        };
        if density > 0.0 { 1.0 / (1.0 + lead * density) } else { 1.0 }
    }

    /// The density of light paths, per projected area and solid angle, where they leave a lamp.
    fn density(&self, emitter: usize, from: &Outlook, direction: Vec3) -> f32 {
        let (_, sky_pmf) = self.casting.sky().unwrap_or((0, 0.0));
        let pmf = (1.0 - sky_pmf) * self.casting.lamps().pmf(from.position, emitter);
        if pmf == 0.0 {
            return 0.0;
        }
        let pdf_area = pmf / self.scene.emitters()[emitter].area();
        pdf_area * self.casting.casters().pdf(from, direction) / from.normal.dot(direction).abs()
    }

    /// The density of light paths that come from the sky in direction `wi`, on the line through
    /// `point`.
    fn sky_density(&self, point: Vec3, wi: Vec3) -> f32 {
        self.casting.sky().map_or(0.0, |(sky, pmf)| {
            // The sky has no place and no normal.
            let pdf = self.scene.emitters()[sky].pdf(point, wi, point, wi);
            pmf * pdf * self.casting.casters().pdf_disk(wi, point)
        })
    }

    /// Traces light paths with these random numbers, and gives what they bring to the pixels that `splats`
    /// shows. Counts the rays it traces.
    pub(crate) fn trace<S: Sampler>(
        &self,
        samplers: impl Iterator<Item = S>,
        shown: &Splats,
        splats: &mut Vec<Splat>,
        rays: &mut u64,
    ) {
        let starts = samplers.filter_map(|sampler| self.start(sampler));
        let mut paths: Vec<LightPath<S>> = starts.collect();
        // Those on their way, by number; they are too large to be moved about.
        let mut alive: Vec<usize> = (0..paths.len()).collect();
        let mut arrivals = Vec::new();
        while !alive.is_empty() {
            let mut packets = Vec::with_capacity(alive.len().div_ceil(LANES));
            for some in alive.chunks(LANES) {
                let mut packet = RayPacket::NONE;
                for (lane, &path) in some.iter().enumerate() {
                    packet.set(lane, &paths[path].ray);
                }
                *rays += some.len() as u64;
                packets.push(self.scene.surfaces().closest_packet(&packet));
            }
            let mut place = 0;
            alive.retain(|&path| {
                let hit = packets[place / LANES].hit(place % LANES);
                place += 1;
                hit.is_some_and(|hit| self.advance(&mut paths[path], &hit, shown, &mut arrivals))
            });
            for some in arrivals.chunks(LANES) {
                let mut packet = RayPacket::NONE;
                for (lane, arrival) in some.iter().enumerate() {
                    packet.set(lane, &arrival.shadow_ray);
                }
                *rays += some.len() as u64;
                let blocked = self.scene.surfaces().occluded_packet(&packet);
                let free = some.iter().enumerate().filter(|(lane, _)| blocked >> lane & 1 == 0);
                splats.extend(free.map(|(_, arrival)| arrival.splat));
            }
            arrivals.clear();
        }
    }

    /// Sends a path from a light towards something that throws its light on.
    fn start<S: Sampler>(&self, sampler: S) -> Option<LightPath<S>> {
        let mut u = sampler.d1(light_path::LAMP);
        let choice = sampler.d1(light_path::CASTER);
        if let Some((sky, pmf)) = self.casting.sky() {
            if u < pmf {
                return self.start_from_sky(sky, choice, sampler);
            }
            // What is left is as good as new.
            u = (u - pmf) / (1.0 - pmf);
        }
        let (lamp, _) = self.casting.lamps().select(Vec3::ZERO, u)?;
        let emitter = &self.scene.emitters()[lamp];
        let Glow { radiance, two_sided } = *emitter.glow()?;
        let point = emitter.point(sampler.d2(light_path::POINT))?;
        let from = Outlook { position: point.position, normal: point.normal, two_sided };
        let u = sampler.d2(light_path::DIRECTION);
        let direction = self.casting.casters().sample(&from, choice, u)?;
        if !two_sided && from.normal.dot(direction) <= 0.0 {
            return None;
        }
        let ray = Ray::new(offset_origin(from.position, from.normal, direction), direction);
        let density = self.density(lamp, &from, direction);
        LightPath::new(ray, radiance, density, self.casting.media(lamp as u32), sampler)
    }

    /// The same from the sky.
    fn start_from_sky<S: Sampler>(
        &self,
        sky: usize,
        choice: f32,
        sampler: S,
    ) -> Option<LightPath<S>> {
        let EmitterSample { wi, radiance, .. } =
            self.scene.emitters()[sky].sample(Vec3::ZERO, sampler.d2(light_path::POINT))?;
        let u = sampler.d2(light_path::DIRECTION);
        let point = self.casting.casters().sample_disk(wi, choice, u);
        let density = self.sky_density(point, wi);
        // From outside of everything.
        let (middle, radius) = (self.scene.report().bounds.center(), self.scene.radius());
        let origin = point + wi * (2.0 * radius + middle.distance(point));
        LightPath::new(Ray::new(origin, -wi), radiance, density, Media::NONE, sampler)
    }

    /// Takes a path to where it `hit` something, notes what arrives at the camera from there, and
    /// sends it on. False when it ends.
    fn advance<S: Sampler>(
        &self,
        path: &mut LightPath<S>,
        hit: &Hit,
        shown: &Splats,
        arrivals: &mut Vec<Arrival>,
    ) -> bool {
        let at = self.scene.interaction(hit, path.ray.direction);
        let material = self.scene.material(&at);
        let (wo, from_front) = (at.wo_local(), at.wo_local().z > 0.0);
        path.depth += 1;
        if let Some(border) = &material.border {
            path.media.arrive_declared(border, from_front);
        }
        path.left *= transmittance(path.media.absorption, hit.t);

        // What was thrown here may be seen by the camera.
        let thrown = path.depth > 1 && path.depth < self.max_depth;
        if thrown && at.is_flat() && !material.bsdf.is_delta() {
            arrivals.extend(self.arrival(path, &at, hit, material, shown));
        }

        // On in a single direction, or not at all.
        if path.depth + 2 > self.max_depth || !material.bsdf.has_delta() {
            return false;
        }
        let bounce = Bounce::of_light(path.depth);
        let Some(sample) = bounce.scatter(&material.bsdf, wo, &path.sampler).filter(|s| s.delta)
        else {
            return false;
        };
        let crossed = sample.is_transmission(wo);
        let ray = at.scattered_ray(&material.bsdf, &sample, crossed);
        let Some(squeeze) = at.squeeze(ray.direction) else { return false };
        if let Some(border) = material.border.filter(|_| crossed) {
            path.media.pass_declared(&border, from_front);
        }
        // Light is not radiance: what enters a denser medium is no more than it was, but denser.
        let squared = sample.eta * sample.eta;
        path.left *= sample.weight * squared;
        path.weight *= squeeze;
        path.density *= squared / squeeze;
        path.ray = ray;

        // End dim paths by roulette; the survivors stand in for the ended.
        let survival = survival(self.roulette, path.depth, path.left, material, true);
        if survival < 1.0 {
            if path.sampler.d1(bounce.roulette()) >= survival {
                return false;
            }
            path.left *= 1.0 / survival;
        }
        true
    }

    /// What the camera sees of a path that has come down on a surface.
    fn arrival<S: Sampler>(
        &self,
        path: &LightPath<S>,
        lit: &SurfaceInteraction,
        hit: &Hit,
        material: &PreparedMaterial,
        shown: &Splats,
    ) -> Option<Arrival> {
        // Where on the film, and for which pixel.
        let lens =
            if self.camera.has_lens() { path.sampler.d2(light_path::LENS) } else { Vec2::ZERO };
        let seen = self.camera.seen(hit.position, lens)?;
        let (pixel, filtered) =
            self.filter.pixel_of(seen.film, path.sampler.d2(light_path::PIXEL))?;
        let pixel = shown.shows(pixel)?;

        // The surface as the camera sees it.
        let way = hit.position - seen.eye;
        let (direction, distance) = (way.try_normalize()?, way.length());
        let at = self.scene.interaction(hit, direction);
        let wi = at.shading.to_local(lit.wo);
        let (scattered, pdf) = material.bsdf.eval_cos_pdf(at.wo_local(), wi);
        let per_area = self.camera.pixels_per_area(direction, distance);
        let sides = (at.normal.dot(at.wo) / at.normal.dot(lit.wo)).abs();
        let lead = self.lead(&at, distance, lit.wo, pdf);
        let share = 1.0 - 1.0 / (1.0 + lead * path.density);
        let mut media = self.scene.camera_media();
        if let Some(border) = &material.border {
            media.arrive_declared(border, at.wo_local().z > 0.0);
        }
        let value = scattered
            * path.weight
            * path.left
            * transmittance(media.absorption, distance)
            * (share * filtered * sides * per_area / self.pixels);
        let origin = at.surface_origin(false);
        (!value.is_black()).then(|| Arrival {
            shadow_ray: Ray::between(origin, seen.eye),
            splat: Splat { pixel, value, rounding: path.sampler.d1(light_path::ROUNDING) },
        })
    }
}
