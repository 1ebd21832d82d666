//! What a pixel sees first, in the mean and by objects.
//!
//! Albedo and normals count as light does, nothing as 0, so that a denoiser
//! finds edges in them as they are in the picture. Places would be blends of
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
    /// Samples, and those that met something.
    count: u64,
    met: u64,
    /// Samples that were looked at closely, and those of them that met something: the sums below are
    /// theirs.
    looked: u64,
    found: u64,
    albedo: [f64; 3],
    normal: [f64; 3],
    position: [f64; 3],
    uv: [f64; 2],
    depth: f64,
    /// How many samples met each object, in the order of the first sample that did.
    objects: Vec<(u32, u64)>,
}

impl Features {
    /// Counts samples by the object that each met, or [`NOTHING`]; `looked` of them are looked at.
    pub(super) fn count(&mut self, objects: &[u32], looked: u64) {
        self.count += objects.len() as u64;
        self.looked += looked;
        for same in objects.chunk_by(|a, b| a == b) {
            let (object, more) = (same[0], same.len() as u64);
            if object == NOTHING {
                continue;
            }
            self.met += more;
            match self.objects.iter_mut().find(|(known, _)| *known == object) {
                Some((_, count)) => *count += more,
                None => self.objects.push((object, more)),
            }
        }
    }

    /// Adds what a sample met that is looked at and counts `weight`.
    pub(super) fn look(&mut self, first: &First, weight: f32) {
        self.found += 1;
        let weight = f64::from(weight);
        add(&mut self.albedo, first.albedo.channels(), weight);
        add(&mut self.normal, first.normal.to_array(), weight);
        add(&mut self.position, first.position.to_array(), 1.0);
        add(&mut self.uv, first.uv.to_array(), 1.0);
        self.depth += f64::from(first.depth);
    }

    /// The mean over all samples that were looked at.
    fn mean(&self, sum: f64) -> f32 {
        if self.looked > 0 { (sum / self.looked as f64) as f32 } else { 0.0 }
    }

    /// The mean over those that met something.
    fn mean_of_found(&self, sum: f64) -> f32 {
        if self.found > 0 { (sum / self.found as f64) as f32 } else { 0.0 }
    }

    /// 1 and the number of what most samples met, by a number that each object has; 0 where most
    /// met nothing.
    fn most(&self, number_of: impl Fn(u32) -> u32) -> f32 {
        let of = |object| number_of(object) + 1;
        let counts = self.counted(0, of);
        counts.first().map_or(0.0, |(number, _)| *number as f32)
    }

    /// How many samples met what has the same number, or nothing, which has the number `nothing`: the
    /// most first.
    fn counted(&self, nothing: u32, number_of: impl Fn(u32) -> u32) -> Vec<(u32, u64)> {
        let mut counts: Vec<(u32, u64)> = Vec::with_capacity(self.objects.len() + 1);
        let met = self.objects.iter().map(|&(object, count)| (number_of(object), count));
        let missed = (self.count > self.met).then_some((nothing, self.count - self.met));
        for (number, count) in met.chain(missed) {
            match counts.iter_mut().find(|(known, _)| *known == number) {
                Some((_, sum)) => *sum += count,
                None => counts.push((number, count)),
            }
        }
        counts.sort_by_key(|&(number, count)| (std::cmp::Reverse(count), number));
        counts
    }
}

/// Adds what is a number.
fn add<const N: usize>(sums: &mut [f64; N], values: [f32; N], weight: f64) {
    for (sum, value) in sums.iter_mut().zip(values) {
        if value.is_finite() {
            *sum += f64::from(value) * weight;
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
    (Layer::Depth, &[("depth.Z", |f| f.mean_of_found(f.depth))]),
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
pub(super) fn channels(layers: Layers, pixels: &[Features], ids: &Ids) -> Vec<Channel> {
    let channel = |name: &str, value: &dyn Fn(&Features) -> f32| Channel {
        name: name.to_owned(),
        values: pixels.iter().map(value).collect(),
    };
    let mut channels = Vec::new();
    for (layer, readings) in MEANS {
        if layers.has(layer) {
            channels.extend(readings.iter().map(|(name, reading)| channel(name, reading)));
        }
    }
    if layers.has(Layer::Object) {
        channels.push(channel("object.id", &|pixel| pixel.most(|object| object)));
    }
    if layers.has(Layer::Material) {
        channels.push(channel("material.id", &|pixel| pixel.most(|o| ids.material_of(o))));
    }
    if layers.has(Layer::Cryptomatte) {
        for (kind, name) in cryptomatte::NAMES.into_iter().enumerate() {
            mattes(name, pixels, |object| ids.of(object)[kind], &mut channels);
        }
    }
    channels
}

/// Ids and their coverages, rank by rank.
fn mattes(
    name: &str,
    pixels: &[Features],
    id_of: impl Fn(u32) -> u32,
    channels: &mut Vec<Channel>,
) {
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
        for (rank, (id, count)) in pixel.counted(0, &id_of).into_iter().enumerate() {
            let (level, half) = (rank / 2, rank % 2 * 2);
            if level == levels.len() {
                more(&mut levels);
            }
            levels[level][half][at] = f32::from_bits(id);
            levels[level][half + 1][at] = (count as f64 / pixel.count as f64) as f32;
        }
    }
    for (level, values) in levels.into_iter().enumerate() {
        let named = ["R", "G", "B", "A"].map(|last| format!("{name}{level:02}.{last}"));
        channels
            .extend(named.into_iter().zip(values).map(|(name, values)| Channel { name, values }));
    }
}
