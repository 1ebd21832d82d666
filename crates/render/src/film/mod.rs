//! Where samples become pixels.
//!
//! The film is cut into tiles, each with its own sums, so that threads never
//! meet. A pixel adds its samples in the order of their numbers; how the
//! samples were spread over passes and threads leaves no trace in the sums.
//! Light paths find pixels by themselves, in any order: see `splats.rs`.

mod crop;
mod features;
mod filter;
mod layers;
mod learned;
mod splats;

pub use crop::Crop;
pub use filter::Filter;
pub(crate) use filter::FilterSampler;
pub use layers::{Layer, Layers};
pub(crate) use splats::{Splat, Splats};

use crate::color::Spectrum;
use crate::cryptomatte::Ids;
use crate::image::{Channel, Image};
use crate::integrator::First;
use crate::math::morton;
use features::{Features, Seen};
use learned::Learned;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Side of a tile in pixels.
const TILE: u32 = 16;

/// The sums of one pixel, in double precision: after 10⁶ samples they are still exact to 1e-10.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Pixel {
    sum: [f64; 3],
    sum_of_squares: [f64; 3],
    count: u64,
}

impl Pixel {
    /// Adds a sample.
    fn add(&mut self, value: Spectrum) {
        let sums = self.sum.iter_mut().zip(&mut self.sum_of_squares);
        for ((sum, sum_of_squares), v) in sums.zip(value.channels().map(f64::from)) {
            *sum += v;
            *sum_of_squares += v * v;
        }
        self.count += 1;
    }

    /// The mean of all samples, 0 before the first.
    fn mean(&self) -> [f32; 3] {
        self.sum.map(|s| if self.count > 0 { (s / self.count as f64) as f32 } else { 0.0 })
    }

    /// The mean in parts: what was seen without a bounce, after one, and after more, where `added` is
    /// what light paths bring. `sums` are those of the first, and of the first two together.
    fn parted(&self, sums: &[[f64; 3]; 2], added: [f64; 3]) -> [[f32; 3]; 3] {
        let [emission, direct] = sums;
        let n = self.count.max(1) as f64;
        let part = |of: &dyn Fn(usize) -> f64| std::array::from_fn(|c| of(c) as f32);
        [
            part(&|c| emission[c] / n),
            part(&|c| (direct[c] - emission[c]) / n),
            part(&|c| (self.sum[c] - direct[c]) / n + added[c]),
        ]
    }

    /// The variance of that mean if samples were independent, 0 before the second. For
    /// stratified samplers it is an upper estimate.
    fn variance_of_mean(&self) -> [f32; 3] {
        let n = self.count as f64;
        std::array::from_fn(|c| {
            let spread = self.sum_of_squares[c] - self.sum[c] * self.sum[c] / n;
            if self.count > 1 { (spread.max(0.0) / (n * (n - 1.0))) as f32 } else { 0.0 }
        })
    }
}

/// A square of pixels and how far it has come.
#[derive(Debug)]
pub(crate) struct Tile {
    /// Where it lies on the whole picture.
    pub(crate) area: Crop,
    /// The number of the first sample that it still lacks, the same for all its pixels.
    pub(crate) next_sample: u64,
    /// (height, width) sums.
    pixels: Vec<Pixel>,
    /// What each pixel has learnt of its noise; empty where samples tell nothing of it.
    learned: Vec<Learned>,
    /// What each pixel sees; empty where no layer asks for it.
    features: Vec<Features>,
    /// Which objects; empty where no layer asks for it.
    seen: Vec<Seen>,
    /// Of the sums of each pixel what was seen without a bounce, and that with what came after one;
    /// empty where no layer asks for it.
    parts: Vec<[[f64; 3]; 2]>,
    /// Of the sums of each pixel what started from the lights of each group: (height, width, group).
    groups: Vec<[f64; 3]>,
    /// How many groups are told.
    group_count: usize,
}

/// A sample of a pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    /// The pixel's column and row on the whole picture.
    pub(crate) pixel: [u32; 2],
    pub(crate) number: u64,
    /// How much it counts, 1 on average.
    pub(crate) weight: f32,
}

/// Samples that were no numbers. They are left out of the mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dropped {
    /// How many.
    pub count: u64,
    /// Column, row and number of the first of them: least sample, then row, then column.
    pub first: Option<DroppedSample>,
}

/// Where a sample was dropped. Ordered by sample number, then row, then column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct DroppedSample {
    /// The number of the sample within its pixel.
    pub sample: u64,
    /// The pixel's row.
    pub y: u32,
    /// The pixel's column.
    pub x: u32,
}

impl Dropped {
    fn add(&mut self, at: DroppedSample) {
        self.count += 1;
        self.first = Some(self.first.map_or(at, |first| first.min(at)));
    }
}

impl Tile {
    /// Where the pixel at (`x`, `y`) of the whole picture is kept.
    fn index(&self, [x, y]: [u32; 2]) -> usize {
        ((y - self.area.y) * self.area.width + (x - self.area.x)) as usize
    }

    /// Adds a sample of pixel `i`. Returns false, and does nothing, where it is not finite.
    fn add(&mut self, i: usize, value: Spectrum, control: f32) -> bool {
        let value = if self.learned.is_empty() { value } else { self.learn(i, value, control) };
        let finite = value.is_finite();
        if finite {
            self.pixels[i].add(value);
        }
        finite
    }

    /// Adds of samples of a pixel, with their weights, what was found without a bounce, and that with
    /// what was found after one. What was dropped is black.
    pub(crate) fn add_parts(
        &mut self,
        pixel: [u32; 2],
        [emission, direct]: [&[Spectrum]; 2],
        weights: &[f32],
    ) {
        let i = self.index(pixel);
        let mut sums = self.parts[i];
        for (weight, parts) in weights.iter().zip(emission.iter().zip(direct)) {
            for (sums, part) in sums.iter_mut().zip([parts.0, parts.1]) {
                for (sum, value) in sums.iter_mut().zip((*part * *weight).channels()) {
                    *sum += f64::from(value);
                }
            }
        }
        self.parts[i] = sums;
    }

    /// Adds of samples of a pixel, with their weights, what started from the lights of each group:
    /// (sample, group). What was dropped is black.
    pub(crate) fn add_groups(&mut self, pixel: [u32; 2], light: &[Spectrum], weights: &[f32]) {
        let (i, each) = (self.index(pixel), self.group_count);
        let sums = &mut self.groups[i * each..(i + 1) * each];
        for (weight, light) in weights.iter().zip(light.chunks_exact(each)) {
            for (sums, light) in sums.iter_mut().zip(light) {
                for (sum, value) in sums.iter_mut().zip((*light * *weight).channels()) {
                    *sum += f64::from(value);
                }
            }
        }
    }

    /// Counts the objects that samples of a pixel met first; `looked` of them are looked at.
    pub(crate) fn count(&mut self, pixel: [u32; 2], objects: &[u32], looked: u64) {
        let i = self.index(pixel);
        self.seen[i].count(objects);
        if looked > 0 {
            self.features[i].expect(looked);
        }
    }

    /// Adds what a sample met first that is looked at.
    pub(crate) fn add_first(&mut self, pixel: [u32; 2], first: &First) {
        let i = self.index(pixel);
        self.features[i].add(first);
    }

    /// A sample of pixel `i` as those before it correct it; those after it learn from it. Apart,
    /// so that the common way stays short.
    #[inline(never)]
    fn learn(&mut self, i: usize, value: Spectrum, control: f32) -> Spectrum {
        let (pixel, learned) = (&self.pixels[i], &mut self.learned[i]);
        let n = pixel.count.max(1) as f64;
        let corrected = learned.corrected(value, control, pixel.sum.map(|sum| sum / n));
        if corrected.is_finite() {
            learned.add(value, control);
        }
        corrected
    }
}

/// All pixels of a window, in tiles that threads lock one at a time.
#[derive(Debug)]
pub(crate) struct Film {
    window: Crop,
    /// In Morton order: neighbours in time are neighbours on the picture.
    tiles: Vec<Mutex<Tile>>,
    /// Samples that each tile has; read without waiting for the tile.
    samples: Vec<AtomicU64>,
    dropped: Mutex<Dropped>,
    /// What light paths bring, where there are any.
    splats: Option<Splats>,
    layers: Layers,
    /// The names of the groups of lights that are told.
    groups: Vec<Arc<str>>,
}

impl Film {
    /// A black film with `layers`, and with the light of these `groups`. With `learns`, samples bring a
    /// control that its pixels learn to use; with `splats`, light paths add to it.
    pub(crate) fn new(
        window: Crop,
        learns: bool,
        splats: Option<Splats>,
        layers: Layers,
        groups: &[Arc<str>],
    ) -> Self {
        let (columns, rows) = (window.width.div_ceil(TILE), window.height.div_ceil(TILE));
        let mut places: Vec<(u32, u32)> =
            (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row))).collect();
        places.sort_unstable_by_key(|&(column, row)| morton(column, row));
        let tiles = places
            .into_iter()
            .map(|(column, row)| {
                let (x, y) = (column * TILE, row * TILE);
                let (width, height) = (TILE.min(window.width - x), TILE.min(window.height - y));
                let pixels = (width * height) as usize;
                let [seen, parted] = [layers.tell_firsts(), layers.has(Layer::Light)]
                    .map(|wanted| if wanted { pixels } else { 0 });
                Mutex::new(Tile {
                    area: Crop { x: window.x + x, y: window.y + y, width, height },
                    next_sample: 0,
                    pixels: vec![Pixel::default(); pixels],
                    learned: vec![Learned::default(); if learns { pixels } else { 0 }],
                    features: vec![Features::default(); seen],
                    seen: vec![Seen::default(); seen],
                    parts: vec![[[0.0; 3]; 2]; parted],
                    groups: vec![[0.0; 3]; pixels * groups.len()],
                    group_count: groups.len(),
                })
            })
            .collect();
        let samples = std::iter::repeat_with(AtomicU64::default);
        let samples = samples.take(columns as usize * rows as usize).collect();
        let (dropped, groups) = (Mutex::default(), groups.to_vec());
        Self { window, tiles, samples, dropped, splats, layers, groups }
    }

    pub(crate) fn tile_count(&self) -> usize {
        self.tiles.len()
    }

    /// What light paths bring, where there are any.
    pub(crate) fn splats(&self) -> Option<&Splats> {
        self.splats.as_ref()
    }

    /// Counts sample number `sample` of a pixel, which is no number.
    pub(crate) fn drop_sample(&self, [x, y]: [u32; 2], sample: u64) {
        locked(&self.dropped).add(DroppedSample { sample, y, x });
    }

    /// Adds the radiance that a sample brought to its tile, with a `control` whose mean is zero and
    /// whose noise it may share. A value that is not finite is dropped and counted, and false is
    /// given back.
    pub(crate) fn add(
        &self,
        tile: &mut Tile,
        sample: &Sample,
        radiance: Spectrum,
        control: f32,
    ) -> bool {
        let &Sample { pixel, number, weight } = sample;
        let i = tile.index(pixel);
        let added = tile.add(i, radiance * weight, control * weight);
        if !added {
            self.drop_sample(pixel, number);
        }
        added
    }

    /// Locks a tile.
    pub(crate) fn tile(&self, index: usize) -> MutexGuard<'_, Tile> {
        locked(&self.tiles[index])
    }

    /// Makes known how far a tile has come.
    pub(crate) fn publish(&self, index: usize, tile: &Tile) {
        self.samples[index].store(tile.next_sample, Ordering::Relaxed);
    }

    /// Samples that every pixel has.
    pub(crate) fn samples(&self) -> u64 {
        let tiles = self.samples.iter().map(|s| s.load(Ordering::Relaxed)).min().unwrap_or(0);
        self.splats.as_ref().map_or(tiles, |splats| tiles.min(splats.samples()))
    }

    pub(crate) fn dropped(&self) -> Dropped {
        *locked(&self.dropped)
    }

    /// The picture so far: `R`, `G`, `B`, the variances of these means as `variance.R` and so on,
    /// how many samples each pixel has as `samples.Y`, and the layers; mattes go by `ids`.
    pub(crate) fn image(&self, ids: &Ids) -> Image {
        let Crop { width, height, .. } = self.window;
        let pixels = width as usize * height as usize;
        let black = |name: &str| Channel { name: name.to_owned(), values: vec![0.0; pixels] };
        let parts: &[&str] = if self.layers.has(Layer::Light) { &PARTS } else { &[] };
        let mut channels: Vec<Channel> =
            COLORS.iter().chain(parts).map(|name| black(name)).collect();
        let mut groups: Vec<Channel> = self
            .groups
            .iter()
            .flat_map(|name| group_channels(name))
            .map(|name| black(&name))
            .collect();
        let mut layers = Vec::<Channel>::new();
        for i in 0..self.tile_count() {
            let tile = self.tile(i);
            let area = tile.area;
            let at = |k: usize| {
                let (x, y) = (k % area.width as usize, k / area.width as usize);
                let x = x + (area.x - self.window.x) as usize;
                let y = y + (area.y - self.window.y) as usize;
                y * width as usize + x
            };
            for (k, pixel) in tile.pixels.iter().enumerate() {
                let at = at(k);
                let (mut mean, mut variance) = (pixel.mean(), pixel.variance_of_mean());
                let added = self.splats.as_ref().map(|splats| splats.added(at));
                if let Some(added) = &added {
                    for c in 0..3 {
                        mean[c] = (f64::from(mean[c]) + added.mean[c]) as f32;
                        variance[c] = (f64::from(variance[c]) + added.variance[c]) as f32;
                    }
                }
                let both = mean.into_iter().chain(variance);
                // Exact up to 2²⁴ samples, and to seven digits beyond.
                let all = both.chain([pixel.count as f32]);
                let parts = tile.parts.get(k).map(|parts| {
                    // Light paths bounce twice at least.
                    pixel.parted(parts, added.map_or([0.0; 3], |added| added.mean))
                });
                let all = all.chain(parts.into_iter().flatten().flatten());
                for (channel, value) in channels.iter_mut().zip(all) {
                    channel.values[at] = value;
                }
                let added = self.splats.as_ref().map(|splats| splats.added_groups(at));
                let mut added = added.into_iter().flatten();
                let sums = tile.groups.get(k * tile.group_count..).unwrap_or_default();
                for (sums, three) in sums.iter().zip(groups.chunks_exact_mut(3)) {
                    let added = added.next().unwrap_or_default();
                    for (c, channel) in three.iter_mut().enumerate() {
                        let mean = sums[c] / pixel.count.max(1) as f64;
                        channel.values[at] = (mean + added[c]) as f32;
                    }
                }
            }
            for Channel { name, values } in
                features::channels(self.layers, &tile.features, &tile.seen, ids)
            {
                // Some tiles may need more ranks than others.
                let known = layers.iter().position(|layer| layer.name == name);
                let number = known.unwrap_or_else(|| {
                    layers.push(black(&name));
                    layers.len() - 1
                });
                for (k, value) in values.into_iter().enumerate() {
                    layers[number].values[at(k)] = value;
                }
            }
        }
        channels.extend(groups);
        channels.extend(layers);
        Image::new(width, height, channels).expect("every channel has the window's size")
    }
}

/// What every picture has.
const COLORS: [&str; 7] = ["R", "G", "B", "variance.R", "variance.G", "variance.B", "samples.Y"];

/// The light of [`Layer::Light`].
const PARTS: [&str; 9] = [
    "emission.R",
    "emission.G",
    "emission.B",
    "direct.R",
    "direct.G",
    "direct.B",
    "indirect.R",
    "indirect.G",
    "indirect.B",
];

/// The channels of a light group, as Blender calls its passes.
fn group_channels(name: &str) -> [String; 3] {
    ["R", "G", "B"].map(|c| format!("Combined_{name}.{c}"))
}

/// Locks. What is locked here is whole between samples, so a thread that died did no harm.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// After a million samples one more still counts in full. A single-precision sum loses
    /// increments from 2²⁴ on.
    #[test]
    fn a_million_samples_keep_their_mean() {
        let mut pixel = Pixel::default();
        for i in 0..1_000_000_u32 {
            pixel.add(Spectrum::splat(if i % 2 == 0 { 100.1 } else { 0.1 }));
        }
        assert_eq!(pixel.mean(), [50.1; 3]);
        let expected = 50.0 * 50.0 / 999_999.0;
        assert!((pixel.variance_of_mean()[0] - expected).abs() < 1e-6 * expected);
    }

    /// One bad sample must not spoil its pixel: it is dropped, counted and located.
    #[test]
    fn samples_that_are_no_numbers_are_dropped_and_located() {
        let window = Crop { x: 5, y: 6, width: 20, height: 20 };
        let film = Film::new(window, false, None, Layers::NONE, &[]);
        let mut tile = film.tile(0);
        for (pixel, number, value) in [
            ([7, 8], 0, Spectrum::WHITE),
            ([7, 8], 2, Spectrum::splat(f32::INFINITY)),
            ([9, 8], 1, Spectrum::from([0.0, f32::NAN, 0.0])),
        ] {
            film.add(&mut tile, &Sample { pixel, number, weight: 1.0 }, value, 0.0);
        }
        drop(tile);
        let first = Some(DroppedSample { sample: 1, y: 8, x: 9 });
        assert_eq!(film.dropped(), Dropped { count: 2, first });
        let image = film.image(&Ids::default());
        assert_eq!(image.channel("G").unwrap()[2 * 20 + 2], 1.0);
        // Only samples that count are counted.
        let samples = image.channel("samples.Y").unwrap();
        assert_eq!((samples[2 * 20 + 2], samples[2 * 20 + 4]), (1.0, 0.0));
    }

    /// Tiles cover every pixel of any window exactly once.
    #[test]
    fn tiles_cover_the_window() {
        for (width, height) in [(1, 1), (101, 97), (16, 33), (1, 1000)] {
            let window = Crop { x: 3, y: 4, width, height };
            let film = Film::new(window, false, None, Layers::NONE, &[]);
            let mut seen = vec![0; (width * height) as usize];
            for i in 0..film.tile_count() {
                let area = film.tile(i).area;
                for y in area.y..area.y + area.height {
                    for x in area.x..area.x + area.width {
                        seen[((y - 4) * width + x - 3) as usize] += 1;
                    }
                }
            }
            assert!(seen.iter().all(|&n| n == 1), "{width}x{height}");
        }
    }
}
