//! What a pixel sees first, in the mean and by objects.
//!
//! Albedo and normals count as light does, nothing as 0, so that a denoiser
//! finds edges in them as they are in the picture; but no sample counts less
//! than nothing, where a filter has negative lobes. Places would be blends of
//! before and behind; they are means over the samples that met something.
//! Which objects cover how much of a pixel is counted exactly; the rest hardly
//! differs within a pixel, and is told by some of its samples.

use super::layers::{Layer, Layers};
use crate::cryptomatte::{self, Ids};
use crate::image::Channel;
use crate::integrator::{First, NOTHING};

/// The sums of one pixel, in double precision.
#[derive(Clone, Debug, Default)]
pub(super) struct Features {
    /// Samples that were looked at closely, and those of them that met something: the sums below are
    /// theirs.
    looked: u64,
    found: u64,
    albedo: [f64; 3],
    normal: [f64; 3],
    position: [f64; 3],
    uv: [f64; 2],
    depth: [f64; 1],
}

/// How many samples of one pixel met each object, or [`NOTHING`]. Apart from the sums, because every
/// sample counts here.
#[derive(Clone, Debug)]
pub(super) struct Seen {
    /// What the first sample met.
    main: (u32, u64),
    others: Vec<(u32, u64)>,
}

impl Default for Seen {
    fn default() -> Self {
        Self { main: (NOTHING, 0), others: Vec::new() }
    }
}

impl Seen {
    /// Counts samples by the object that each met, or [`NOTHING`].
    pub(super) fn count(&mut self, objects: &[u32]) {
        for same in objects.chunk_by(|a, b| a == b) {
            let (object, more) = (same[0], same.len() as u64);
            if self.main.1 == 0 || self.main.0 == object {
                self.main = (object, self.main.1 + more);
                continue;
            }
            match self.others.iter_mut().find(|(known, _)| *known == object) {
                Some((_, count)) => *count += more,
                None => self.others.push((object, more)),
            }
        }
    }

    /// 1 and the number of what most samples met, by a number that each object has; 0 where most
    /// met nothing.
    fn most(&self, number_of: impl Fn(u32) -> u32) -> f32 {
        let counts = self.counted(|object| number_of(object) + 1);
        counts.first().map_or(0.0, |(number, _)| *number as f32)
    }

    /// How many samples met what has the same number, or nothing, which has the number 0: the most
    /// first.
    fn counted(&self, number_of: impl Fn(u32) -> u32) -> Vec<(u32, u64)> {
        let mut counts: Vec<(u32, u64)> = Vec::with_capacity(self.others.len() + 1);
        let main = Some(self.main).filter(|(_, count)| *count > 0);
        for (object, count) in main.into_iter().chain(self.others.iter().copied()) {
            let number = if object == NOTHING { 0 } else { number_of(object) };
            match counts.iter_mut().find(|(known, _)| *known == number) {
                Some((_, sum)) => *sum += count,
                None => counts.push((number, count)),
            }
        }
        counts.sort_by_key(|&(number, count)| (std::cmp::Reverse(count), number));
        counts
    }
}

impl Features {
    /// So many more samples are looked at; of those that met nothing nothing else is told.
    pub(super) fn expect(&mut self, looked: u64) {
        self.looked += looked;
    }

    /// Adds what a sample met that is looked at.
    pub(super) fn add(&mut self, first: &First) {
        self.found += 1;
        add(&mut self.albedo, first.albedo.channels());
        add(&mut self.normal, first.normal.to_array());
        add(&mut self.position, first.position.to_array());
        add(&mut self.uv, first.uv.to_array());
        add(&mut self.depth, [first.depth]);
    }

    /// The mean over all samples that were looked at.
    fn mean(&self, sum: f64) -> f32 {
        if self.looked > 0 { (sum / self.looked as f64) as f32 } else { 0.0 }
    }

    /// The mean over those that met something.
    fn mean_of_found(&self, sum: f64) -> f32 {
        if self.found > 0 { (sum / self.found as f64) as f32 } else { 0.0 }
    }
}

/// Adds what is a number.
fn add<const N: usize>(sums: &mut [f64; N], values: [f32; N]) {
    for (sum, value) in sums.iter_mut().zip(values) {
        if value.is_finite() {
            *sum += f64::from(value);
        }
    }
}

/// How a channel follows from the sums of a pixel.
type Reading = fn(&Features) -> f32;

/// The channels of each layer that is a mean.
const MEANS: [(Layer, &[(&str, Reading)]); 5] = [
    (
        Layer::Albedo,
        &[
            ("albedo.R", |f| f.mean(f.albedo[0])),
            ("albedo.G", |f| f.mean(f.albedo[1])),
            ("albedo.B", |f| f.mean(f.albedo[2])),
        ],
    ),
    (
        Layer::Normal,
        &[
            ("normal.X", |f| f.mean(f.normal[0])),
            ("normal.Y", |f| f.mean(f.normal[1])),
            ("normal.Z", |f| f.mean(f.normal[2])),
        ],
    ),
    (Layer::Depth, &[("depth.Z", |f| f.mean_of_found(f.depth[0]))]),
    (
        Layer::Position,
        &[
            ("position.X", |f| f.mean_of_found(f.position[0])),
            ("position.Y", |f| f.mean_of_found(f.position[1])),
            ("position.Z", |f| f.mean_of_found(f.position[2])),
        ],
    ),
    (Layer::Uv, &[("uv.U", |f| f.mean_of_found(f.uv[0])), ("uv.V", |f| f.mean_of_found(f.uv[1]))]),
];

/// The channels of `layers` for these pixels, in their order.
pub(super) fn channels(
    layers: Layers,
    pixels: &[Features],
    seen: &[Seen],
    ids: &Ids,
) -> Vec<Channel> {
    let channel = |name: &str, values| Channel { name: name.to_owned(), values };
    let mut channels = Vec::new();
    for (layer, readings) in MEANS {
        if layers.has(layer) {
            channels.extend(
                readings
                    .iter()
                    .map(|(name, reading)| channel(name, pixels.iter().map(reading).collect())),
            );
        }
    }
    if layers.has(Layer::Object) {
        let numbers = seen.iter().map(|pixel| pixel.most(|object| object));
        channels.push(channel("object.id", numbers.collect()));
    }
    if layers.has(Layer::Material) {
        let numbers = seen.iter().map(|pixel| pixel.most(|object| ids.material_of(object)));
        channels.push(channel("material.id", numbers.collect()));
    }
    if layers.has(Layer::Cryptomatte) {
        for (kind, name) in cryptomatte::NAMES.into_iter().enumerate() {
            mattes(name, seen, |object| ids.of(object)[kind], &mut channels);
        }
    }
    channels
}

/// Ids and their coverages, rank by rank.
fn mattes(name: &str, pixels: &[Seen], id_of: impl Fn(u32) -> u32, channels: &mut Vec<Channel>) {
    /// Two ranks fill the four channels of a level; this many levels are usual.
    const LEVELS: usize = 3;
    let mut levels: Vec<[Vec<f32>; 4]> = Vec::new();
    let more = |levels: &mut Vec<[Vec<f32>; 4]>| {
        levels.push([const { Vec::new() }; 4].map(|_: Vec<f32>| vec![0.0; pixels.len()]));
    };
    for _ in 0..LEVELS {
        more(&mut levels);
    }
    for (at, pixel) in pixels.iter().enumerate() {
        let counts = pixel.counted(&id_of);
        let all: u64 = counts.iter().map(|(_, count)| count).sum();
        for (rank, (id, count)) in counts.into_iter().enumerate() {
            let (level, half) = (rank / 2, rank % 2 * 2);
            if level == levels.len() {
                more(&mut levels);
            }
            levels[level][half][at] = f32::from_bits(id);
            levels[level][half + 1][at] = (count as f64 / all as f64) as f32;
        }
    }
    for (level, values) in levels.into_iter().enumerate() {
        let named = ["R", "G", "B", "A"].map(|last| format!("{name}{level:02}.{last}"));
        channels
            .extend(named.into_iter().zip(values).map(|(name, values)| Channel { name, values }));
    }
}
