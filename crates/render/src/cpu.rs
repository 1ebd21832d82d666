//! Passes over the film: tiles shared out among threads, the same bits for any number of them.

use crate::camera::PreparedCamera;
use crate::film::{Film, FilterSampler, Tile};
use crate::integrator::{
    Albedo, AmbientOcclusion, Depth, Direct, Integrator, Naive, Normals, Optimal, Path, Start, dimension,
};
use crate::light::EmitterSelection;
use crate::prepare::Prepared;
use crate::sampler::{Independent, Sampler, Sequence, Sobol};
use crate::settings::{IntegratorKind, SamplerKind, Settings};
use rutilant_geom::Vec2;
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

/// So many samples of a tile's pixels are on their way together.
const SAMPLES_AT_ONCE: u64 = 4;

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
        let selection = || {
            EmitterSelection::new(
                settings.light_selection,
                self.scene.emitters(),
                self.scene.radius(),
            )
        };
        match settings.integrator {
            IntegratorKind::Path => {
                let path = Path {
                    selection: selection(),
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
            IntegratorKind::Direct => self.run_with(next_pass, &Direct { selection: selection() }),
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
        let (mut starts, mut places, mut found) = (Vec::new(), Vec::new(), Vec::new());
        while tile.next_sample < until_sample {
            starts.clear();
            places.clear();
            found.clear();
            let run = tile.next_sample..until_sample.min(tile.next_sample + SAMPLES_AT_ONCE);
            for sample in run.clone() {
                for y in area.y..area.y + area.height {
                    for x in area.x..area.x + area.width {
                        let sampler = S::new(&sequence, [x, y], sample);
                        let (offset, weight) = filter.sample(sampler.d2(dimension::FILM));
                        let film = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) + offset;
                        let ray = camera.ray(film, sampler.d2(dimension::LENS));
                        starts.push(Start { ray, sampler });
                        places.push(([x, y], sample, weight));
                    }
                }
            }
            integrator.estimates(self.scene, &starts, &mut found, &mut rays);
            for (&(pixel, sample, weight), &(radiance, control)) in places.iter().zip(&found) {
                self.film.add(tile, pixel, sample, radiance * weight, control * weight);
            }
            paths += starts.len() as u64;
            tile.next_sample = run.end;
        }
        self.counters.rays.fetch_add(rays, Ordering::Relaxed);
        self.counters.paths.fetch_add(paths, Ordering::Relaxed);
    }
}
