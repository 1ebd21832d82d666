//! Passes over the film: tiles shared out among threads, the same bits for any number of them.

use crate::camera::PreparedCamera;
use crate::film::{Film, FilterSampler, Tile};
use crate::integrator::{
    Albedo, AmbientOcclusion, Depth, Direct, Integrator, Naive, Normals, Optimal, Path, Starts,
    dimension,
};
use crate::light::EmitterSelection;
use crate::prepare::Prepared;
use crate::sampler::{Independent, Sampler, Sequence, Sobol};
use crate::settings::{IntegratorKind, SamplerKind, Settings, Strategy};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8};
use rutilant_geom::lanes::LANES;
use rutilant_geom::{RayPacket, Vec2, with_vectors};
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

/// So many samples of a tile's pixels are on their way together. Those of a pixel follow each other:
/// a packet's rays begin nearly as one.
const SAMPLES_AT_ONCE: u64 = 8;

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
        match settings.integrator {
            IntegratorKind::Path => {
                let path = Path {
                    selection: match settings.strategy {
                        Strategy::Both => {
                            EmitterSelection::beside_scattering(kind, emitters, radius)
                        }
                        Strategy::BsdfOnly | Strategy::LightOnly => {
                            EmitterSelection::new(kind, emitters, radius)
                        }
                    },
                    strategy: settings.strategy,
                    heuristic: settings.heuristic,
                    roulette: settings.roulette,
                    max_depth,
                };
                if settings.learns() {
                    self.run_with(next_pass, &Optimal(path));
                } else {
                    self.run_with(next_pass, &path);
                }
            }
            IntegratorKind::Naive => self.run_with(next_pass, &Naive { max_depth }),
            IntegratorKind::Direct => self.run_with(
                next_pass,
                &Direct { selection: EmitterSelection::new(kind, emitters, radius) },
            ),
            IntegratorKind::AmbientOcclusion => self.run_with(next_pass, &AmbientOcclusion),
            IntegratorKind::Normals => self.run_with(next_pass, &Normals),
            IntegratorKind::Albedo => self.run_with(next_pass, &Albedo),
            IntegratorKind::Depth => self.run_with(next_pass, &Depth),
        }
    }

    fn run_with<I: Integrator>(&self, next_pass: impl FnMut() -> Option<u64>, integrator: &I) {
        match self.settings.sampler {
            SamplerKind::Independent => self.run_passes::<Independent, I>(next_pass, integrator),
            SamplerKind::Sobol => self.run_passes::<Sobol, I>(next_pass, integrator),
        }
    }

    fn run_passes<S: Sampler, I: Integrator>(
        &self,
        mut next_pass: impl FnMut() -> Option<u64>,
        integrator: &I,
    ) {
        let camera = self.scene.focused_camera(self.settings.size);
        let filter = FilterSampler::new(&self.settings.filter);
        while let Some(until_sample) = next_pass() {
            let next = AtomicUsize::new(0);
            let work = || {
                while !self.stop.load(Ordering::Relaxed) {
                    let ticket = next.fetch_add(1, Ordering::Relaxed);
                    if ticket >= self.film.tile_count() {
                        break;
                    }
                    let mut tile = self.film.tile(ticket);
                    self.render_tile::<S, I>(&mut tile, until_sample, integrator, &camera, &filter);
                    self.film.publish(ticket, &tile);
                }
            };
            std::thread::scope(|scope| {
                for _ in 1..self.threads.min(self.film.tile_count()) {
                    scope.spawn(work);
                }
                work();
            });
        }
    }

    fn render_tile<S: Sampler, I: Integrator>(
        &self,
        tile: &mut Tile,
        until_sample: u64,
        integrator: &I,
        camera: &PreparedCamera,
        filter: &FilterSampler,
    ) {
        let (area, settings) = (tile.area, self.settings);
        let sequence = Sequence::new(settings.seed, settings.planned_spp.unwrap_or(settings.spp));
        let (mut rays, mut paths) = (0, 0);
        let mut starts = Vec::<Starts<S>>::new();
        let (mut weights, mut found) = (Vec::new(), Vec::new());
        while tile.next_sample < until_sample {
            let until = until_sample.min(tile.next_sample + SAMPLES_AT_ONCE);
            let samples = tile.next_sample..until;
            let rows = area.y..area.y + area.height;
            let pixels = rows.flat_map(|y| (area.x..area.x + area.width).map(move |x| [x, y]));
            let places =
                pixels.flat_map(|pixel| samples.clone().map(move |sample| (pixel, sample)));
            let places: Vec<([u32; 2], u64)> = places.collect();
            starts.clear();
            weights.clear();
            found.clear();
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
            integrator.estimates(self.scene, &starts, &mut found, &mut rays);
            let weights = weights.iter().flatten();
            for ((&(pixel, sample), &(radiance, control)), &weight) in
                places.iter().zip(&found).zip(weights)
            {
                self.film.add(tile, pixel, sample, radiance * weight, control * weight);
            }
            paths += places.len() as u64;
            tile.next_sample = until;
        }
        self.counters.rays.fetch_add(rays, Ordering::Relaxed);
        self.counters.paths.fetch_add(paths, Ordering::Relaxed);
    }
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
    (Starts { rays, samplers }, weight)
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
    (Starts { rays, samplers }, weights)
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
