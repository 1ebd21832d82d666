//! Light that finds its pixels, instead of being found by them.
//!
//! Light paths come down on pixels in any order, from any thread. For the
//! picture not to depend on that, what they bring is counted in whole numbers:
//! their sums have no order. Numbers are rounded at random, so that the mean
//! stays what it is.

use super::crop::Crop;
use crate::color::Spectrum;
use std::sync::atomic::{AtomicI64, AtomicU64, Ordering};

/// Side, in pixels, of the tiles that light paths are shared out in.
const TILE: u32 = 64;

/// More blocks of tiles than this there are not; in larger pictures they have more tiles.
const MOST_BLOCKS: u64 = 1 << 16;

/// As many parts as the brightest light gives in all planned samples of a pixel together. A sum has
/// room for eight times as many.
const PARTS_IN_ALL: f64 = (1_u64 << 60) as f64;

/// The least and the most samples that sums are made for, whatever is planned: fewer may become
/// more, and for more what a sample gives would be too few parts.
const SAMPLES: [u64; 2] = [1 << 16, 1 << 24];

/// What one light path brings to one pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Splat {
    /// Column and row on the whole picture.
    pub(crate) pixel: [u32; 2],
    /// What it counts for the pixel, if there is one light path for each pixel of the picture.
    pub(crate) value: Spectrum,
    /// A number in [0, 1) that decides how it is rounded.
    pub(crate) rounding: f32,
    /// The number of the light that it started from.
    pub(crate) emitter: u32,
}

/// The sums of all pixels of a window.
#[derive(Debug)]
pub(crate) struct Splats {
    window: Crop,
    /// Of the whole picture, in pixels.
    size: [u32; 2],
    /// So many parts make what the brightest light gives in one sample.
    most: f64,
    /// A value as a number of parts.
    parts: f64,
    /// Light paths that were traced.
    paths: AtomicU64,
    /// How many samples each block of light paths has come to.
    blocks: Vec<AtomicU64>,
    /// (height, width).
    sums: Vec<Sums>,
    /// How many groups of lights are told apart.
    groups: usize,
    /// Of the values of the sums what started from the lights of each: (height, width, group).
    of_groups: Vec<[AtomicI64; 3]>,
}

/// The sums of one pixel, in parts and in squares of them.
#[derive(Debug, Default)]
struct Sums {
    values: [AtomicI64; 3],
    squares: [AtomicU64; 3],
}

/// Mean and variance that light paths add to those of a pixel.
pub(super) struct Added {
    pub(super) mean: [f64; 3],
    pub(super) variance: [f64; 3],
}

impl Splats {
    /// None yet, for the `window` of a picture of `size` pixels, from lights of no more radiance
    /// than `brightest`, when so many samples of each pixel are planned. So many `groups` of lights are
    /// told apart.
    pub(crate) fn new(
        window: Crop,
        size: [u32; 2],
        brightest: f32,
        planned: u64,
        groups: usize,
    ) -> Self {
        let most = PARTS_IN_ALL / planned.clamp(SAMPLES[0], SAMPLES[1]) as f64;
        let pixels = window.width as usize * window.height as usize;
        let [columns, rows] = tile_grid(size);
        let blocks = (columns * rows).div_ceil(tiles_each(size)) as usize;
        Self {
            window,
            size,
            most,
            parts: most / f64::from(brightest),
            paths: AtomicU64::new(0),
            blocks: std::iter::repeat_with(AtomicU64::default).take(blocks).collect(),
            sums: std::iter::repeat_with(Sums::default).take(pixels).collect(),
            groups,
            of_groups: std::iter::repeat_with(Default::default).take(pixels * groups).collect(),
        }
    }

    /// How many blocks of light paths there are.
    pub(crate) fn block_count(&self) -> usize {
        self.blocks.len()
    }

    /// The tiles of a block: a run of those of the whole picture, for wherever a path starts it may
    /// come down in any window.
    pub(crate) fn tiles(&self, block: usize) -> impl Iterator<Item = Crop> {
        let ([columns, rows], each) = (tile_grid(self.size), tiles_each(self.size));
        let (first, [width, height]) = (block as u64 * each, self.size);
        (first..(first + each).min(columns * rows)).map(move |tile| {
            let [x, y] = [tile % columns, tile / columns].map(|t| t as u32 * TILE);
            Crop { x, y, width: TILE.min(width - x), height: TILE.min(height - y) }
        })
    }

    /// The first sample that a block still lacks.
    pub(crate) fn next_sample(&self, block: usize) -> u64 {
        self.blocks[block].load(Ordering::Relaxed)
    }

    /// Whether a pixel lies in the window.
    pub(crate) fn shows(&self, [x, y]: [i64; 2]) -> Option<[u32; 2]> {
        let Crop { x: left, y: top, width, height } = self.window;
        let inside = |at: i64, first: u32, count: u32| {
            let (first, count) = (i64::from(first), i64::from(count));
            (first..first + count).contains(&at).then_some(at as u32)
        };
        Some([inside(x, left, width)?, inside(y, top, height)?])
    }

    /// Adds what `paths` light paths of a block have brought, all of it finite and in the window;
    /// the block has come to `sample` now. Where groups are told apart, an emitter is of the one that
    /// `group_of` says.
    pub(crate) fn add(
        &self,
        block: usize,
        sample: u64,
        paths: u64,
        splats: &[Splat],
        group_of: impl Fn(usize) -> usize,
    ) {
        for Splat { pixel: [x, y], value, rounding, emitter } in splats {
            let (x, y) = ((x - self.window.x) as usize, (y - self.window.y) as usize);
            let pixel = y * self.window.width as usize + x;
            let sums = &self.sums[pixel];
            let of_group = (self.groups > 0)
                .then(|| &self.of_groups[pixel * self.groups + group_of(*emitter as usize)]);
            let rounding = f64::from(*rounding);
            let both = sums.values.iter().zip(&sums.squares).zip(value.channels());
            for (c, ((sum, square), v)) in both.enumerate() {
                let parts = f64::from(v) * self.parts;
                let whole = (parts + rounding).floor() as i64;
                sum.fetch_add(whole, Ordering::Relaxed);
                if let Some(of_group) = of_group {
                    of_group[c].fetch_add(whole, Ordering::Relaxed);
                }
                let squared = parts * (parts / self.most);
                square.fetch_add((squared + rounding).floor() as u64, Ordering::Relaxed);
            }
        }
        self.paths.fetch_add(paths, Ordering::Relaxed);
        self.blocks[block].store(sample, Ordering::Relaxed);
    }

    /// Samples that all blocks have.
    pub(super) fn samples(&self) -> u64 {
        self.blocks.iter().map(|b| b.load(Ordering::Relaxed)).min().unwrap_or(u64::MAX)
    }

    /// Light paths so far, and what a part counts in the mean of them.
    fn scale(&self) -> (f64, f64) {
        let paths = self.paths.load(Ordering::Relaxed).max(1) as f64;
        let pixels: f64 = self.size.into_iter().map(f64::from).product();
        (paths, pixels / self.parts)
    }

    /// Of the mean that light paths add to the pixel at this place in the window what started from
    /// the lights of each group.
    pub(super) fn added_groups(&self, index: usize) -> impl Iterator<Item = [f64; 3]> {
        let (paths, per_path) = self.scale();
        let its = &self.of_groups[index * self.groups..(index + 1) * self.groups];
        its.iter().map(move |sums| {
            sums.each_ref().map(|sum| sum.load(Ordering::Relaxed) as f64 * per_path / paths)
        })
    }

    /// What the light paths so far add to the pixel at this place in the window.
    pub(super) fn added(&self, index: usize) -> Added {
        let (paths, per_path) = self.scale();
        let Sums { values, squares } = &self.sums[index];
        let sum = |c: usize| values[c].load(Ordering::Relaxed) as f64 * per_path;
        Added {
            mean: std::array::from_fn(|c| sum(c) / paths),
            variance: std::array::from_fn(|c| {
                let squares = squares[c].load(Ordering::Relaxed) as f64 * self.most;
                let spread = squares * per_path * per_path - sum(c) * sum(c) / paths;
                spread.max(0.0) / (paths * (paths - 1.0).max(1.0))
            }),
        }
    }
}

fn tile_grid(size: [u32; 2]) -> [u64; 2] {
    size.map(|side| u64::from(side.div_ceil(TILE)))
}

fn tiles_each(size: [u32; 2]) -> u64 {
    tile_grid(size).into_iter().product::<u64>().div_ceil(MOST_BLOCKS)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whatever the order, the sums are the same; their mean and variance are those of the values,
    /// of bright ones and of such as are lost a thousand times in rounding.
    #[test]
    fn sums_have_no_order() {
        let window = Crop { x: 2, y: 1, width: 2, height: 2 };
        let splats: Vec<Splat> = (0..4096_u32)
            .map(|i| Splat {
                pixel: [3, 1 + i % 2],
                value: Spectrum::from([1.0, 1e-4 * (i / 2 % 4) as f32, 1e-12]),
                rounding: (i.wrapping_mul(2_654_435_769) >> 8) as f32 / (1 << 24) as f32,
                emitter: i % 3,
            })
            .collect();
        let all = |order: &mut dyn Iterator<Item = Splat>| {
            let sums = Splats::new(window, [10, 10], 1.0, 64, 2);
            let splats: Vec<Splat> = order.collect();
            splats.chunks(100).for_each(|some| {
                // Two of three emitters are of one group.
                sums.add(0, 1, some.len() as u64, some, |emitter| usize::from(emitter == 1));
            });
            sums
        };
        let forth = all(&mut splats.iter().copied());
        let back = all(&mut splats.iter().rev().copied());
        let numbers = |s: &Splats| {
            (0..4).flat_map(|i| [s.added(i).mean, s.added(i).variance]).collect::<Vec<_>>()
        };
        assert_eq!(numbers(&forth), numbers(&back));

        // Half of 4096 paths on each pixel, each worth the 100 pixels of the picture.
        let Added { mean, variance } = forth.added(1);
        assert_eq!(mean[0], 50.0);
        assert!((mean[1] / (50.0 * 1.5e-4) - 1.0).abs() < 1e-6, "{mean:?}");
        assert!((mean[2] / (50.0 * 1e-12) - 1.0).abs() < 0.1, "{mean:?}");
        let expected = (100.0 * 100.0 * 0.5 - 50.0 * 50.0) / 4095.0;
        assert!((variance[0] / expected - 1.0).abs() < 1e-9, "{variance:?}");
        assert_eq!(forth.added(0).mean, [0.0; 3]);
    }
}
