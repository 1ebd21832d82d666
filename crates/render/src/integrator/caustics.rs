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

use super::dimension::{BAND, Bounce, light_path};
use super::path::survival;
use crate::camera::PreparedCamera;
use crate::color::Spectrum;
use crate::film::{FilterSampler, Splat, Splats};
use crate::follow::{MOST_PASSES, transmittance};
use crate::interaction::SurfaceInteraction;
use crate::light::{EmitterSample, Glow, ShadingPoint};
use crate::medium::Media;
use crate::prepare::{Aim, Casting, Outlook, Prepared, PreparedMaterial};
use crate::sampler::Sampler;
use crate::settings::Roulette;
use rutilant_geom::lanes::LANES;
use rutilant_geom::{Hit, Ray, RayPacket, Vec2, Vec3, offset_end, offset_origin};

/// How light paths and paths from the camera share caustics.
#[derive(Clone, Copy)]
pub(crate) struct Caustics<'a> {
    scene: &'a Prepared,
    camera: &'a PreparedCamera,
    casting: &'a Casting,
    filter: &'a FilterSampler,
    /// The size in pixels of a picture whose edges join.
    map: Option<[u32; 2]>,
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
    /// The number of the light, and the place on it; the sky has none.
    emitter: usize,
    from: Option<Outlook>,
    /// Light sent along it over the density with which it was chosen, per projected area and solid
    /// angle; until it first meets something only the light.
    weight: Spectrum,
    /// That density, as it is here.
    density: f32,
    /// The part of its light that is left.
    left: Spectrum,
    /// Segments so far.
    depth: u32,
    /// How often it went on behind surfaces that have only a front.
    passes: u32,
    media: Media,
    sampler: S,
}

/// Which surfaces with only one side a path has met in one place.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
struct Passed {
    front: bool,
    back: bool,
}

/// How a path goes on.
enum Next {
    End,
    On,
    /// With another surface in the same place.
    Here(Hit),
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
        let map = camera.sees_all_around().then_some(size);
        Some(Self { scene, camera, casting, filter, map, pixels, paths, max_depth, roulette })
    }

    /// How dense light paths are at the surface `at`, which a path from the camera saw over
    /// `distance` metres and left along `wi` with density `pdf`, in units of that path's own
    /// density: for each unit of density, per projected area and solid angle, with which they set
    /// out. 0 where light paths do not look; no number, or without end, where the camera sees no
    /// area.
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

    /// The share that a path from the camera has in light that it met along `ray`, after a chain of
    /// clear surfaces, at `position` on the emitter of this number; of the sky neither `position` nor
    /// `normal` is looked at. `lead` is what the path brought along.
    pub(super) fn share(
        &self,
        lead: f32,
        emitter: usize,
        position: Vec3,
        normal: Vec3,
        ray: &Ray,
    ) -> f32 {
        let glow = self.scene.emitters()[emitter].glow();
        let from = glow.map(|&Glow { two_sided, .. }| Outlook { position, normal, two_sided });
        let others = lead * self.density(emitter, from.as_ref(), -ray.direction, ray.origin);
        // Where numbers end, no light path starts.
        if others.is_finite() { 1.0 / (1.0 + others) } else { 1.0 }
    }

    /// The density, per projected area and solid angle, of light paths that leave a lamp, or the sky,
    /// along the unit vector `direction` and first meet something at `point`.
    fn density(&self, emitter: usize, from: Option<&Outlook>, direction: Vec3, point: Vec3) -> f32 {
        let Casting { casters, lamps, .. } = self.casting;
        let sky_pmf = self.casting.sky().map_or(0.0, |(_, pmf)| pmf);
        let light = &self.scene.emitters()[emitter];
        let Some(from) = from else {
            // The sky has no place and no normal.
            let pdf = light.pdf(point, -direction, point, direction);
            return sky_pmf * pdf * casters.pdf_from_sky(-direction, point);
        };
        let pmf = (1.0 - sky_pmf) * lamps.pmf(&ShadingPoint::open(from.position), emitter);
        if pmf == 0.0 {
            return 0.0;
        }
        let towards = casters.pdf(from, direction, point) / from.normal.dot(direction).abs();
        pmf / light.area() * towards
    }

    /// Traces light paths with these random numbers, and adds to `splats` what they bring to the
    /// pixels that are `shown`. Counts the rays it traces.
    pub(crate) fn trace<S: Sampler>(
        &self,
        samplers: impl Iterator<Item = S>,
        shown: &Splats,
        splats: &mut Vec<Splat>,
        rays: &mut u64,
    ) {
        let (mut paths, ways): (Vec<LightPath<S>>, Vec<Option<Ray>>) =
            samplers.filter_map(|sampler| self.start(sampler)).unzip();
        // Those on their way, by number; they are too large to be moved about.
        let mut alive = self.free(&ways, |way| *way, rays);
        let mut arrivals = Vec::new();
        while !alive.is_empty() {
            let mut packets = Vec::with_capacity(alive.len().div_ceil(LANES));
            for some in alive.chunks(LANES) {
                let mut packet = RayPacket::NONE;
                for (lane, &path) in some.iter().enumerate() {
                    packet.set(lane, &paths[path].ray);
                }
                *rays += some.len() as u64;
                packets.push(self.scene.closest_packet_of_light(&packet));
            }
            let mut place = 0;
            alive.retain(|&path| {
                let hit = packets[place / LANES].hit(place % LANES);
                place += 1;
                hit.is_some_and(|hit| self.advance(&mut paths[path], hit, shown, &mut arrivals))
            });
            let seen = self.free(&arrivals, |arrival: &Arrival| Some(arrival.shadow_ray), rays);
            splats.extend(seen.into_iter().map(|i| arrivals[i].splat));
            arrivals.clear();
        }
    }

    /// The numbers of those `items` whose `way` nothing blocks, or that have none. Counts the rays it
    /// traces.
    fn free<T>(&self, items: &[T], way: impl Fn(&T) -> Option<Ray>, rays: &mut u64) -> Vec<usize> {
        let mut free = Vec::with_capacity(items.len());
        for (some, first) in items.chunks(LANES).zip((0..).step_by(LANES)) {
            let mut packet = RayPacket::NONE;
            for (lane, item) in some.iter().enumerate() {
                if let Some(ray) = way(item) {
                    packet.set(lane, &ray);
                    *rays += 1;
                }
            }
            let blocked = self.scene.occluded_packet(&packet);
            free.extend((0..some.len()).filter(|lane| blocked >> lane & 1 == 0).map(|i| first + i));
        }
        free
    }

    /// Sends a path from a light towards something that throws its light on: with a ray for what it
    /// has behind it before it sets out, where it starts far from the light.
    fn start<S: Sampler>(&self, sampler: S) -> Option<(LightPath<S>, Option<Ray>)> {
        let mut u = sampler.d1(light_path::LAMP);
        let choice = sampler.d1(light_path::CASTER);
        let [place, aim] = [light_path::POINT, light_path::DIRECTION].map(|d| sampler.d2(d));
        let path = |emitter, from, radiance, ray, left, media| LightPath {
            ray,
            emitter,
            from,
            weight: radiance,
            density: 0.0,
            left,
            depth: 0,
            passes: 0,
            media,
            sampler,
        };
        let casters = &self.casting.casters;
        if let Some((sky, pmf)) = self.casting.sky() {
            if u < pmf {
                let EmitterSample { wi, radiance, .. } =
                    self.scene.emitters()[sky].sample(Vec3::ZERO, place)?;
                let Aim { entry, direction } = casters.aim_from_sky(wi, choice, aim)?;
                let ray = Ray::new(entry?, direction);
                let path = path(sky, None, radiance, ray, Spectrum::WHITE, Media::NONE);
                return Some((path, Some(Ray::new(ray.origin, wi))));
            }
            // What is left is as good as new.
            u = (u - pmf) / (1.0 - pmf);
        }
        let (lamp, _) = self.casting.lamps.select(&ShadingPoint::open(Vec3::ZERO), u, 0.0)?;
        let emitter = &self.scene.emitters()[lamp];
        let Glow { radiance, two_sided } = *emitter.glow()?;
        let point = emitter.point(place)?;
        let from = Outlook { position: point.position, normal: point.normal, two_sided };
        let Aim { entry, direction } = casters.aim(&from, choice, aim)?;
        if !two_sided && from.normal.dot(direction) <= 0.0 {
            return None;
        }
        let media = self.scene.lamp_media(self.casting, lamp as u32, &point);
        let way =
            entry.map(|entry| Ray::between(entry, offset_end(from.position, from.normal, entry)));
        let origin = entry.unwrap_or_else(|| offset_origin(from.position, from.normal, direction));
        let left = transmittance(media.absorption, from.position.distance(origin));
        let path = path(lamp, Some(from), radiance, Ray::new(origin, direction), left, media);
        Some((path, way))
    }

    /// Takes a path to where it `hit` something, notes what arrives at the camera from there, and
    /// sends it on. False when it ends.
    ///
    /// Of several surfaces in one place the camera sees the first that is there from its side. It
    /// sees what the light falls on from there, and from the other side what the light comes through.
    fn advance<S: Sampler>(
        &self,
        path: &mut LightPath<S>,
        hit: Hit,
        shown: &Splats,
        arrivals: &mut Vec<Arrival>,
    ) -> bool {
        let (mut hit, mut before) = (hit, Passed::default());
        loop {
            match self.arrive(path, &hit, &mut before, shown, arrivals) {
                Next::End => return false,
                Next::On => return true,
                Next::Here(next) => hit = next,
            }
        }
    }

    /// The same for one surface, before which the path met `before` in the same place.
    fn arrive<S: Sampler>(
        &self,
        path: &mut LightPath<S>,
        hit: &Hit,
        before: &mut Passed,
        shown: &Splats,
        arrivals: &mut Vec<Arrival>,
    ) -> Next {
        let at = self.scene.interaction(hit, path.ray.direction);
        let material = self.scene.material(&at);
        let varied = self.scene.varied_at(hit, &at, material);
        let material = varied.as_ref().unwrap_or(material);
        let (wo, from_front) = (at.wo_local(), at.wo_local().z > 0.0);
        let first = *before == Passed::default();
        if material.one_sided && at.normal.dot(at.wo) < 0.0 {
            // The camera would see its front.
            before.back = true;
            if first {
                path.left *= transmittance(path.media.absorption, hit.t);
            }
            return self.beyond(path, hit, &at, *before);
        }
        path.depth += 1;
        if path.depth == 1 && !material.one_sided {
            path.density =
                self.density(path.emitter, path.from.as_ref(), path.ray.direction, hit.position);
            // One that could not have been chosen.
            if !(path.density > 0.0 && path.density.is_finite()) {
                return Next::End;
            }
            path.weight = path.weight / path.density;
        }
        if let Some(border) = &material.border {
            path.media.arrive_declared(border, from_front);
        }
        if first {
            path.left *= transmittance(path.media.absorption, hit.t);
        }

        // Of colours that are bent differently here only one goes on.
        let mut room = None;
        let u = || path.sampler.d1(BAND);
        let media = &mut path.media;
        let (worth, material) = self.scene.in_one_band(material, media, u, &mut room);
        path.left *= worth;

        // What was thrown here may be seen by the camera.
        let thrown = path.depth > 1 && path.depth < self.max_depth && !before.front;
        if thrown && at.is_flat() && !material.bsdf.is_delta() {
            arrivals.extend(self.arrival(path, &at, hit, material, shown));
        }

        // The camera passes what it sees from behind, and so does this path, without a segment.
        if material.one_sided {
            path.depth -= 1;
            before.front = true;
            return self.beyond(path, hit, &at, *before);
        }

        // On in a single direction, or not at all.
        if path.depth + 2 > self.max_depth || !material.bsdf.has_delta() {
            return Next::End;
        }
        let bounce = Bounce::of_light(path.depth);
        let Some(sample) = bounce.scatter(&material.bsdf, wo, &path.sampler).filter(|s| s.delta)
        else {
            return Next::End;
        };
        let crossed = sample.is_transmission(wo);
        if if crossed { before.back } else { before.front } {
            return Next::End;
        }
        let ray = at.scattered_ray(&material.bsdf, &sample, crossed);
        let Some(squeeze) = at.squeeze(ray.direction) else { return Next::End };
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
                return Next::End;
            }
            path.left *= 1.0 / survival;
        }
        Next::On
    }

    /// Behind a surface that has only one side: to the next in the same place, or on.
    fn beyond<S: Sampler>(
        &self,
        path: &mut LightPath<S>,
        hit: &Hit,
        at: &SurfaceInteraction,
        met: Passed,
    ) -> Next {
        path.passes += 1;
        if path.passes >= MOST_PASSES {
            return Next::End;
        }
        if let Some(next) = self.scene.also_met_by_light(&path.ray, hit) {
            return Next::Here(next);
        }
        if met.back {
            return Next::End;
        }
        path.ray = Ray::new(at.surface_origin(true), path.ray.direction);
        Next::On
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
            self.filter.pixel_of(seen.film, self.map, path.sampler.d2(light_path::PIXEL))?;
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
        // From the eye, as the camera looks: what the eye itself stands on is not in its way.
        let end = offset_end(hit.position, at.normal, seen.eye);
        (!value.is_black()).then(|| Arrival {
            shadow_ray: Ray::between(seen.eye, end),
            splat: Splat {
                pixel,
                value,
                rounding: path.sampler.d1(light_path::ROUNDING),
                emitter: path.emitter as u32,
            },
        })
    }
}
