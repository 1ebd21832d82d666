//! Passes over the film: tiles shared out among threads, the same bits for any number of them.

use crate::camera::PreparedCamera;
use crate::film::{Crop, Film, FilterSampler, Layers, Sample, Splat, Splats, Tile};
use crate::integrator::{
    Albedo, AmbientOcclusion, Caustics, Depth, Direct, Found, Integrator, Naive, Normals, Optimal,
    Path, Starts, View, dimension,
};
use crate::light::EmitterSelection;
use crate::math::{from_morton, morton};
use crate::prepare::Prepared;
use crate::sampler::{Independent, Sampler, Sequence, Sobol};
use crate::settings::{IntegratorKind, SamplerKind, Settings, Strategy};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8};
use rutilant_geom::lanes::LANES;
use rutilant_geom::{RayPacket, Vec2, with_vectors};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};

/// What has been done so far, counted by all threads.
#[derive(Debug, Default)]
pub(crate) struct Counters {
    /// Camera paths.
    pub(crate) paths: AtomicU64,
    /// Rays traced.
    pub(crate) rays: AtomicU64,
}

impl Counters {
    /// Camera paths and rays.
    pub(crate) fn so_far(&self) -> (u64, u64) {
        (self.paths.load(Ordering::Relaxed), self.rays.load(Ordering::Relaxed))
    }
}

/// What sees, and how samples of its film count.
#[derive(Clone, Copy)]
struct Eye<'a> {
    camera: &'a PreparedCamera,
    filter: &'a FilterSampler,
    /// What is asked about its paths beside their light.
    view: Option<&'a View>,
}

/// So many samples of a tile's pixels are on their way together. Those of a pixel follow each other:
/// a packet's rays begin nearly as one.
const SAMPLES_AT_ONCE: u64 = 8;

/// Of a tile of light paths so many samples are on their way together: four thousand paths, so that
/// eight can go together for long.
const LIGHT_SAMPLES_AT_ONCE: u64 = 16;

/// Everything that a rendering reads and writes.
pub(crate) struct Rendering<'a> {
    pub(crate) scene: &'a Prepared,
    pub(crate) settings: &'a Settings,
    pub(crate) film: &'a Film,
    pub(crate) threads: usize,
    /// Set from outside to leave the rest of a pass undone.
    pub(crate) stop: &'a AtomicBool,
    pub(crate) counters: &'a Counters,
}

impl Rendering<'_> {
    /// Renders pass after pass. `next_pass` tells to how many samples the next one brings every
    /// pixel; `None` ends. Integrator and sampler are chosen once and compiled into one loop.
    pub(crate) fn run(&self, next_pass: impl FnMut() -> Option<u64>) {
        let settings = self.settings;
        let max_depth = settings.max_depth.unwrap_or(u32::MAX);
        let (kind, emitters) = (settings.light_selection, self.scene.emitters());
        let radius = self.scene.radius();
        let tree = || Some((self.scene.light_tree()?, self.scene.surfaces().level()));
        let camera = self.scene.focused_camera(settings.size);
        let filter = FilterSampler::new(&settings.filter);
        let layers = settings.kept_layers();
        let groups = self.scene.told_groups(layers);
        let view = (layers != Layers::NONE).then(|| View::new(&self.scene.camera, layers, groups));
        let eye = Eye { camera: &camera, filter: &filter, view: view.as_ref() };
        match settings.integrator {
            IntegratorKind::Path => {
                let path = Path {
                    selection: match settings.strategy {
                        Strategy::Both => {
                            EmitterSelection::beside_scattering(kind, emitters, radius, tree)
                        }
                        Strategy::BsdfOnly | Strategy::LightOnly => {
                            EmitterSelection::with_tree(kind, emitters, radius, tree)
                        }
                    },
                    strategy: settings.strategy,
                    heuristic: settings.heuristic,
                    roulette: settings.roulette,
                    max_depth,
                    caustics: self.film.splats().and_then(|_| {
                        let (size, roulette) = (settings.size, settings.roulette);
                        Caustics::new(self.scene, &camera, &filter, size, max_depth, roulette)
                    }),
                };
                if settings.learns() {
                    self.run_with(next_pass, &Optimal(path), eye);
                } else {
                    self.run_with(next_pass, &path, eye);
                }
            }
            IntegratorKind::Naive => self.run_with(next_pass, &Naive { max_depth }, eye),
            IntegratorKind::Direct => self.run_with(
                next_pass,
                &Direct { selection: EmitterSelection::with_tree(kind, emitters, radius, tree) },
                eye,
            ),
            IntegratorKind::AmbientOcclusion => {
                self.run_with(next_pass, &AmbientOcclusion, eye);
            }
            IntegratorKind::Normals => self.run_with(next_pass, &Normals, eye),
            IntegratorKind::Albedo => self.run_with(next_pass, &Albedo, eye),
            IntegratorKind::Depth => self.run_with(next_pass, &Depth, eye),
        }
    }

    fn run_with<I: Integrator>(
        &self,
        next_pass: impl FnMut() -> Option<u64>,
        integrator: &I,
        eye: Eye<'_>,
    ) {
        match self.settings.sampler {
            SamplerKind::Independent => {
                self.run_passes::<Independent, I>(next_pass, integrator, eye);
            }
            SamplerKind::Sobol => {
                self.run_passes::<Sobol, I>(next_pass, integrator, eye);
            }
        }
    }

    fn run_passes<S: Sampler, I: Integrator>(
        &self,
        mut next_pass: impl FnMut() -> Option<u64>,
        integrator: &I,
        eye: Eye<'_>,
    ) {
        let tiles = self.film.tile_count();
        let blocks = self.film.splats().map_or(0, Splats::block_count);
        while let Some(until_sample) = next_pass() {
            let next = AtomicUsize::new(0);
            let work = || {
                while !self.stop.load(Ordering::Relaxed) {
                    let ticket = next.fetch_add(1, Ordering::Relaxed);
                    if ticket < tiles {
                        self.render_tile::<S, I>(ticket, until_sample, integrator, eye);
                    } else if let (Some(caustics), Some(splats)) =
                        (integrator.caustics(), self.film.splats())
                        && ticket < tiles + blocks
                    {
                        self.trace_light::<S>(ticket - tiles, until_sample, caustics, splats);
                    } else {
                        break;
                    }
                }
            };
            std::thread::scope(|scope| {
                for _ in 1..self.threads.min(tiles + blocks) {
                    scope.spawn(work);
                }
                work();
            });
        }
    }

    /// Traces a block of light paths until there are `until_sample` for each of its pixels, or until
    /// it is to stop.
    fn trace_light<S: Sampler>(
        &self,
        block: usize,
        until_sample: u64,
        caustics: &Caustics<'_>,
        shown: &Splats,
    ) {
        /// Keeps their numbers apart from those of paths from the camera.
        const ANOTHER: u64 = 0x9b1d_5c3a_8f27_e641;
        let settings = self.settings;
        let planned = settings.planned_spp.unwrap_or(settings.spp);
        let sequence = Sequence::new(settings.seed ^ ANOTHER, planned.div_ceil(Caustics::EVERY));
        let (mut rays, mut found) = (0, Vec::new());
        let mut sample = shown.next_sample(block);
        while sample < until_sample && !self.stop.load(Ordering::Relaxed) {
            // Samples that are told together are the same ones, wherever passes end.
            let first = sample - sample % LIGHT_SAMPLES_AT_ONCE;
            let until = until_sample.min(first + LIGHT_SAMPLES_AT_ONCE);
            // Pixels take turns.
            let places = shown.tiles(block).flat_map(|tile| pixels_of(&tile));
            let places = places.flat_map(|pixel @ [x, y]| {
                let turn = morton(x, y) % Caustics::EVERY;
                let of_pixel = |s: u64| (s + Caustics::EVERY - 1 - turn) / Caustics::EVERY;
                (of_pixel(sample)..of_pixel(until)).map(move |number| (pixel, number))
            });
            let mut paths = 0;
            let samplers = places.map(|(pixel, number)| S::new(&sequence, pixel, number));
            let samplers = samplers.inspect(|_| paths += 1);
            caustics.trace(samplers, shown, &mut found, &mut rays);
            let (splats, bad): (Vec<Splat>, Vec<Splat>) =
                found.drain(..).partition(|splat| splat.value.is_finite());
            for splat in bad {
                self.film.drop_sample(splat.pixel, first);
            }
            let groups = self.scene.groups();
            shown.add(block, until, paths, &splats, |emitter| groups.of(emitter));
            sample = until;
        }
        self.counters.rays.fetch_add(rays, Ordering::Relaxed);
    }

    /// Renders a tile until its pixels have `until_sample` samples, or until it is to stop. It is
    /// locked only for what is added, so that whoever looks at the film never waits for rays.
    fn render_tile<S: Sampler, I: Integrator>(
        &self,
        index: usize,
        until_sample: u64,
        integrator: &I,
        Eye { camera, filter, view }: Eye<'_>,
    ) {
        let settings = self.settings;
        let Tile { area, next_sample: mut next, .. } = *self.film.tile(index);
        let sequence = Sequence::new(settings.seed, settings.planned_spp.unwrap_or(settings.spp));
        let (mut rays, mut paths) = (0, 0);
        let mut starts = Vec::<Starts<S>>::new();
        let (mut weights, mut found) = (Vec::new(), Found::default());
        while next < until_sample && !self.stop.load(Ordering::Relaxed) {
            let until = until_sample.min(next + SAMPLES_AT_ONCE);
            let samples = next..until;
            let places = pixels_of(&area)
                .flat_map(|pixel| samples.clone().map(move |sample| (pixel, sample)));
            let places: Vec<([u32; 2], u64)> = places.collect();
            starts.clear();
            weights.clear();
            with_vectors!(
                self.scene.surfaces().level(),
                simd => for places in places.chunks(LANES) {
                    let (start, weight) = starts_of(simd, &sequence, camera, filter, places);
                    starts.push(start);
                    weights.push(weight);
                },
                else for places in places.chunks(LANES) {
                    let (start, weight) = starts_one_by_one(&sequence, camera, filter, places);
                    starts.push(start);
                    weights.push(weight);
                }
            );
            integrator.estimates(self.scene, &starts, view, &mut found, &mut rays);
            let weights = weights.as_flattened();
            let mut tile = self.film.tile(index);
            for (i, (&(pixel, number), &weight)) in places.iter().zip(weights).enumerate() {
                let sample = Sample { pixel, number, weight };
                if !self.film.add(&mut tile, &sample, found.radiance[i], found.controls[i]) {
                    found.drop_parts(i);
                }
            }
            tell(&mut tile, &places, next..until, weights, &found);
            paths += places.len() as u64;
            tile.next_sample = until;
            self.film.publish(index, &tile);
            next = until;
        }
        self.counters.rays.fetch_add(rays, Ordering::Relaxed);
        self.counters.paths.fetch_add(paths, Ordering::Relaxed);
    }
}

/// The pixels of an area, along a curve on which those that follow each other are near each other.
fn pixels_of(area: &Crop) -> impl Iterator<Item = [u32; 2]> + use<> {
    let &Crop { x, y, width, height } = area;
    let side = width.max(height).next_power_of_two();
    let places = (0..side * side).map(from_morton);
    places.filter(move |&[i, j]| i < width && j < height).map(move |[i, j]| [x + i, y + j])
}

/// Where the paths of up to eight samples of pixels start, and how much each counts.
#[inline(always)]
fn starts_of<V: Simd, S: Sampler>(
    simd: V,
    sequence: &Sequence,
    camera: &PreparedCamera,
    filter: &FilterSampler,
    places: &[([u32; 2], u64)],
) -> (Starts<S>, [f32; LANES]) {
    let ([x, y], samplers) = samplers_of(sequence, places);
    let (offset, weight) = filter.sample_all(S::d2_of(simd, &samplers, dimension::FILM));
    let (x, y): (f32x8<V>, f32x8<V>) = (x.simd_into(simd), y.simd_into(simd));
    let lens = if camera.has_lens() {
        S::d2_of(simd, &samplers, dimension::LENS)
    } else {
        [f32x8::splat(simd, 0.0); 2]
    };
    let mut rays = camera.rays([x + offset[0], y + offset[1]], lens);
    for lane in places.len()..LANES {
        rays.t_max[lane] = RayPacket::NONE.t_max[lane];
    }
    (Starts { rays, samplers, looks: looks_of(places) }, weight)
}

/// The same without vector instructions.
fn starts_one_by_one<S: Sampler>(
    sequence: &Sequence,
    camera: &PreparedCamera,
    filter: &FilterSampler,
    places: &[([u32; 2], u64)],
) -> (Starts<S>, [f32; LANES]) {
    let ([x, y], samplers) = samplers_of::<S>(sequence, places);
    let (mut rays, mut weights) = (RayPacket::NONE, [0.0; LANES]);
    for lane in 0..places.len() {
        let sampler = &samplers[lane];
        let (offset, weight) = filter.sample(sampler.d2(dimension::FILM));
        let lens = if camera.has_lens() { sampler.d2(dimension::LENS) } else { Vec2::ZERO };
        rays.set(lane, &camera.ray(Vec2::new(x[lane], y[lane]) + offset, lens));
        weights[lane] = weight;
    }
    (Starts { rays, samplers, looks: looks_of(places) }, weights)
}

/// Adds to a tile what these `samples` of its pixels, which stand in `places`, found beside light.
fn tell(
    tile: &mut Tile,
    places: &[([u32; 2], u64)],
    samples: Range<u64>,
    weights: &[f32],
    found: &Found,
) {
    let looked = samples.clone().filter(|number| looks_at(*number)).count() as u64;
    let each = (samples.end - samples.start) as usize;
    for (start, (pixel, _)) in places.iter().enumerate().step_by(each) {
        let its = start..start + each;
        if let (Some(emission), Some(direct)) =
            (found.emission.get(its.clone()), found.direct.get(its.clone()))
        {
            tile.add_parts(*pixel, [emission, direct], &weights[its.clone()]);
        }
        if found.groups.are_told() {
            tile.add_groups(*pixel, found.groups.of(its.clone()), &weights[its.clone()]);
        }
        if let Some(objects) = found.objects.get(its) {
            tile.count(*pixel, objects, looked);
        }
    }
    for (start, first) in &found.firsts {
        let start = *start as usize;
        tile.add_first(places[start].0, first);
    }
}

/// The samples of which is asked what they meet, a bit for each.
#[inline(always)]
fn looks_of(places: &[([u32; 2], u64)]) -> u32 {
    let each = places.iter().enumerate().take(LANES);
    each.fold(0, |all, (lane, &(_, number))| all | u32::from(looks_at(number)) << lane)
}

/// Whether a sample of a pixel is looked at: the first, and from then on one run in four, which is
/// well spread itself, and one packet.
#[inline(always)]
fn looks_at(number: u64) -> bool {
    /// So many samples tell nearly all of it.
    const ENOUGH: u64 = 16;
    number < ENOUGH || (number / SAMPLES_AT_ONCE).is_multiple_of(4)
}

/// The middles of the pixels, and the numbers of their samples.
#[inline(always)]
fn samplers_of<S: Sampler>(
    sequence: &Sequence,
    places: &[([u32; 2], u64)],
) -> ([[f32; LANES]; 2], [S; LANES]) {
    let mut middles = [[0.0; LANES]; 2];
    let (first, sample) = places[0];
    let mut samplers = [S::new(sequence, first, sample); LANES];
    for (lane, &(pixel, sample)) in places.iter().enumerate().take(LANES) {
        for (middle, at) in middles.iter_mut().zip(pixel) {
            middle[lane] = at as f32 + 0.5;
        }
        samplers[lane] = S::new(sequence, pixel, sample);
    }
    (middles, samplers)
}
