//! A picture and ever smaller versions of it.
//!
//! Each level has half the width and height of the one before, rounded down,
//! and holds the exact means of what it covers, of light and not of codes.
//! Colours weigh by their opacity: what cannot be seen does not bleed.
//! A lookup takes the level whose texels are about as large as what is looked
//! at, and in it the four texels around the place.
//!
//! Source: Williams, "Pyramidal Parametrics", SIGGRAPH 1983.

use super::bitmap::{Bitmap, Texels};
use super::image::{Encoding, Interpolation, Wrap};
use crate::display::linear_from_srgb;
use rayon::prelude::*;
use rutilant_geom::Vec2;
use std::sync::Arc;

/// A picture in all its sizes.
#[derive(Clone, Debug)]
pub(crate) struct Pyramid {
    /// The picture itself, shared with the scene.
    base: Arc<Bitmap>,
    /// From half its size to one texel.
    smaller: Vec<Bitmap>,
    codes: Codes,
}

/// Four texels of a picture, found but not yet read, and where between them a place is.
///
/// Reading waits for memory. Where several places are looked at, all are found first, so that it is
/// waited for once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Footprint<'p> {
    bitmap: &'p Bitmap,
    codes: &'p Codes,
    /// Left and right.
    columns: [u32; 2],
    /// The upper and the lower one.
    rows: [u32; 2],
    /// How far from left to right, and from the upper to the lower row.
    parts: [f32; 2],
}

/// What codes mean.
#[derive(Clone, Debug)]
struct Codes {
    /// The value of each code of a colour; empty for floating-point pixels.
    values: Arc<[f32]>,
    /// The value of the first code of opacity.
    alpha: f32,
}

impl Codes {
    fn new(texels: &Texels, encoding: Encoding) -> Self {
        let last = match texels {
            Texels::Eight(_) => f64::from(u8::MAX),
            Texels::Sixteen(_) => f64::from(u16::MAX),
            Texels::Float(_) => return Self { values: Arc::new([]), alpha: 1.0 },
        };
        let value = |code: u32| match encoding {
            Encoding::Srgb => linear_from_srgb(f64::from(code) / last) as f32,
            Encoding::Linear => (f64::from(code) / last) as f32,
        };
        Self { values: (0..=last as u32).map(value).collect(), alpha: (1.0 / last) as f32 }
    }

    /// The code whose value is nearest.
    fn nearest(&self, value: f32) -> usize {
        let above = self.values.partition_point(|v| *v < value).min(self.values.len() - 1);
        let Some(below) = above.checked_sub(1) else { return above };
        let (over, under) = (self.values[above] - value, value - self.values[below]);
        if over <= under { above } else { below }
    }
}

impl Pyramid {
    pub(crate) fn new(base: Arc<Bitmap>, encoding: Encoding) -> Self {
        let codes = Codes::new(base.texels(), encoding);
        let mut smaller: Vec<Bitmap> = Vec::new();
        loop {
            let above = smaller.last().unwrap_or(&base);
            if above.width().max(above.height()) == 1 {
                break;
            }
            let Some(half) = halved(above, &codes) else { break };
            smaller.push(half);
        }
        Self { base, smaller, codes }
    }

    /// Bytes that it takes, the picture itself included.
    pub(crate) fn bytes(&self) -> u64 {
        self.base.bytes() + self.smaller.iter().map(Bitmap::bytes).sum::<u64>()
    }

    /// The mean over all of the picture: red, green, blue and opacity.
    pub(crate) fn mean(&self) -> [f32; 4] {
        let [texel] = texels(self.smaller.last().unwrap_or(&self.base), &self.codes, [[0, 0]]);
        texel
    }

    /// How wide a texel is, in texture coordinates, in the mean of both directions.
    pub(crate) fn texel(&self) -> f32 {
        1.0 / (self.base.width() as f32 * self.base.height() as f32).sqrt()
    }

    /// The texels at `uv`, over a `width` in texture coordinates.
    #[inline]
    pub(crate) fn find(
        &self,
        uv: Vec2,
        width: f32,
        wrap: [Wrap; 2],
        interpolation: Interpolation,
    ) -> Footprint<'_> {
        let Self { base, codes, .. } = self;
        let side = ((base.width() as f32) * (base.height() as f32)).sqrt();
        let bitmap = self.level(width * side);
        let (u, v) = (wrap[0].within(uv.x), wrap[1].within(uv.y));
        let size = [bitmap.width(), bitmap.height()];
        let (x, y) = (u * size[0] as f32, (1.0 - v) * size[1] as f32);
        let (columns, rows, parts) = match interpolation {
            Interpolation::Nearest => {
                let (i, j) = ((x as u32).min(size[0] - 1), (y as u32).min(size[1] - 1));
                ([i; 2], [j; 2], [0.0; 2])
            }
            Interpolation::Bilinear => {
                let (columns, p) = wrap[0].neighbours(x, size[0]);
                let (rows, q) = wrap[1].neighbours(y, size[1]);
                (columns, rows, [p, q])
            }
        };
        Footprint { bitmap, codes, columns, rows, parts }
    }

    /// The level whose texels are at most as large as `width` texels of the picture.
    #[inline]
    fn level(&self, width: f32) -> &Bitmap {
        // The exponent of a number is its logarithm, rounded down.
        let exponent = (width.max(1.0).to_bits() >> 23) as usize - 127;
        match exponent.min(self.smaller.len()).checked_sub(1) {
            None => &self.base,
            Some(i) => &self.smaller[i],
        }
    }
}

impl Footprint<'_> {
    /// Red, green, blue and opacity.
    #[inline]
    pub(crate) fn read(&self) -> [f32; 4] {
        let [p, q] = self.parts;
        let ([i, k], [j, l]) = (self.columns, self.rows);
        let [a, b, c, d] = texels(self.bitmap, self.codes, [[i, j], [k, j], [i, l], [k, l]]);
        between(between(a, b, p), between(c, d, p), q)
    }
}

/// What is so far from `a` on the way to `b`.
#[inline]
fn between(a: [f32; 4], b: [f32; 4], part: f32) -> [f32; 4] {
    [0, 1, 2, 3].map(|i| a[i] + (b[i] - a[i]) * part)
}

/// Red, green, blue and opacity of texels, each by its column and row. What kind they are of is
/// asked once for all.
#[inline]
fn texels<const N: usize>(bitmap: &Bitmap, codes: &Codes, at: [[u32; 2]; N]) -> [[f32; 4]; N] {
    let (width, channels) = (bitmap.width() as usize, bitmap.channels());
    let first = at.map(|[x, y]| (y as usize * width + x as usize) * channels);
    match bitmap.texels() {
        Texels::Eight(t) => spread(
            t,
            channels,
            first,
            |code| codes.values[usize::from(code)],
            |code| f32::from(code) * codes.alpha,
        ),
        Texels::Sixteen(t) => spread(
            t,
            channels,
            first,
            |code| codes.values[usize::from(code)],
            |code| f32::from(code) * codes.alpha,
        ),
        Texels::Float(t) => spread(t, channels, first, |value| value, |value| value),
    }
}

/// One to four channels as red, green, blue and opacity, from each of the `first` ones on.
#[inline(always)]
fn spread<T: Copy, const N: usize>(
    values: &[T],
    channels: usize,
    first: [usize; N],
    color: impl Fn(T) -> f32,
    alpha: impl Fn(T) -> f32,
) -> [[f32; 4]; N] {
    match channels {
        1 => first.map(|i| {
            let grey = color(values[i]);
            [grey, grey, grey, 1.0]
        }),
        2 => first.map(|i| {
            let grey = color(values[i]);
            [grey, grey, grey, alpha(values[i + 1])]
        }),
        3 => first.map(|i| {
            let [r, g, b] = [values[i], values[i + 1], values[i + 2]].map(&color);
            [r, g, b, 1.0]
        }),
        _ => first.map(|i| {
            let [r, g, b] = [values[i], values[i + 1], values[i + 2]].map(&color);
            [r, g, b, alpha(values[i + 3])]
        }),
    }
}

/// The picture at half its size; `None` never, for it has texels.
fn halved(bitmap: &Bitmap, codes: &Codes) -> Option<Bitmap> {
    let [width, height] = [bitmap.width(), bitmap.height()].map(|side| (side / 2).max(1));
    let channels = bitmap.channels();
    let columns = covers(bitmap.width(), width);
    let rows = covers(bitmap.height(), height);
    let (columns, rows) = (&columns, &rows);
    let values = |j: usize| {
        (0..width as usize).flat_map(move |i| {
            let [r, g, b, a] = mean(bitmap, codes, &columns[i], &rows[j]);
            [r, if channels == 2 { a } else { g }, b, a].into_iter().take(channels)
        })
    };
    let is_alpha = |i: usize| bitmap.has_alpha() && i % channels == channels - 1;
    let code = |(i, value): (usize, f32)| match is_alpha(i) {
        true => (value / codes.alpha + 0.5) as usize,
        false => codes.nearest(value),
    };
    let of_row = |j: usize| values(j).enumerate().map(code);
    let size = [width as usize * channels, height as usize];
    let texels = match bitmap.texels() {
        Texels::Eight(_) => Texels::Eight(filled(size, |j| of_row(j).map(|code| code as u8))),
        Texels::Sixteen(_) => Texels::Sixteen(filled(size, |j| of_row(j).map(|code| code as u16))),
        Texels::Float(_) => Texels::Float(filled(size, values)),
    };
    Bitmap::new(width, height, channels, texels)
}

/// Rows of values, made each by itself, and nothing kept beside them: there may be a billion.
fn filled<T: Clone + Default + Send, R: Iterator<Item = T>>(
    [width, height]: [usize; 2],
    row: impl Fn(usize) -> R + Sync,
) -> Vec<T> {
    let mut all = vec![T::default(); width * height];
    all.par_chunks_mut(width).enumerate().for_each(|(j, values)| {
        values.iter_mut().zip(row(j)).for_each(|(value, made)| *value = made);
    });
    all
}

/// For each of `to` parts of a row of `from` texels: which texels it covers, and how much of each,
/// as a part of it. All are whole multiples of 1 / `from`.
fn covers(from: u32, to: u32) -> Vec<Vec<(u32, f64)>> {
    let (from, to) = (u64::from(from), u64::from(to));
    let cover = |i: u64| {
        let (start, end) = (i * from, (i + 1) * from);
        let texels = start / to..end.div_ceil(to);
        let part = |x: u64| end.min((x + 1) * to) - start.max(x * to);
        texels.map(|x| (x as u32, part(x) as f64 / from as f64)).collect()
    };
    (0..to).map(cover).collect()
}

/// The mean of some texels.
fn mean(bitmap: &Bitmap, codes: &Codes, columns: &[(u32, f64)], rows: &[(u32, f64)]) -> [f32; 4] {
    let (mut plain, mut opaque, mut alpha) = ([0.0; 3], [0.0; 3], 0.0);
    for &(y, q) in rows {
        for &(x, p) in columns {
            let [texel] = texels(bitmap, codes, [[x, y]]);
            let [r, g, b, a] = texel.map(f64::from);
            let weight = p * q;
            for (i, value) in [r, g, b].into_iter().enumerate() {
                plain[i] += value * weight;
                opaque[i] += value * a * weight;
            }
            alpha += a * weight;
        }
    }
    let [r, g, b] = if alpha > 0.0 { opaque.map(|sum| sum / alpha) } else { plain };
    [r, g, b, alpha].map(|v| v as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(width: u32, height: u32, codes: Vec<u8>) -> Arc<Bitmap> {
        Arc::new(Bitmap::new(width, height, 1, Texels::Eight(codes)).unwrap())
    }

    fn float(width: u32, height: u32, values: Vec<f32>) -> Pyramid {
        let bitmap = Bitmap::new(width, height, 1, Texels::Float(values)).unwrap();
        Pyramid::new(Arc::new(bitmap), Encoding::Linear)
    }

    const REPEAT: [Wrap; 2] = [Wrap::Repeat; 2];

    /// Whatever the size, the one texel at the top is the mean of all: a pyramid that drops a
    /// column or weighs one twice fails here.
    #[test]
    fn the_top_is_the_mean() {
        for (width, height) in [(1, 1), (2, 2), (3, 5), (7, 1), (64, 48), (1, 33), (255, 254)] {
            let values: Vec<f32> = (0..width * height).map(|i| ((i * 37) % 101) as f32).collect();
            let expected = values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len() as f64;
            let [r, g, b, a] = float(width, height, values).mean();
            assert!((f64::from(r) - expected).abs() < 1e-4 * expected.max(1.0), "{width} {height}");
            assert_eq!([g, b, a], [r, r, 1.0]);
        }
    }

    /// Black and white in turn are half the light, which is code 188 and not 128.
    #[test]
    fn light_is_averaged_not_codes() {
        let board: Vec<u8> = (0..16).map(|i| if (i + i / 4) % 2 == 0 { 0 } else { 255 }).collect();
        let srgb = Pyramid::new(grey(4, 4, board.clone()), Encoding::Srgb);
        assert_eq!(srgb.smaller[0].texels(), &Texels::Eight(vec![188; 4]));
        assert!((srgb.mean()[0] - 0.5).abs() < 3e-3);
        let linear = Pyramid::new(grey(4, 4, board), Encoding::Linear);
        assert!((linear.mean()[0] - 0.5).abs() < 3e-3);
    }

    /// Every code is the nearest to its own value, in both encodings and depths.
    #[test]
    fn codes_come_back() {
        for encoding in [Encoding::Srgb, Encoding::Linear] {
            for texels in [Texels::Eight(Vec::new()), Texels::Sixteen(Vec::new())] {
                let codes = Codes::new(&texels, encoding);
                for (code, value) in codes.values.iter().enumerate() {
                    assert_eq!(codes.nearest(*value), code);
                }
                assert_eq!(codes.nearest(-1.0), 0);
                assert_eq!(codes.nearest(2.0), codes.values.len() - 1);
            }
        }
    }

    /// A green leaf on clear black: its edge stays green in every level.
    #[test]
    fn what_is_clear_does_not_bleed() {
        let leaf = [0, 200, 0, 255];
        let texels: Vec<u8> = [leaf, [0; 4], [0; 4], [0; 4]].concat();
        let bitmap = Arc::new(Bitmap::new(2, 2, 4, Texels::Eight(texels)).unwrap());
        let [r, g, b, a] = Pyramid::new(bitmap, Encoding::Linear).mean();
        assert!((g - 200.0 / 255.0).abs() < 3e-3 && r == 0.0 && b == 0.0);
        assert!((a - 0.25).abs() < 3e-3, "{a}");
    }

    /// (0, 0) is the lower left corner, and the middles of texels have their values.
    #[test]
    fn coordinates_start_at_the_lower_left() {
        let p = float(2, 2, vec![1.0, 2.0, 3.0, 4.0]);
        let at = |u, v| p.find(Vec2::new(u, v), 0.0, REPEAT, Interpolation::Bilinear).read()[0];
        assert_eq!([at(0.25, 0.25), at(0.75, 0.25)], [3.0, 4.0]);
        assert_eq!([at(0.25, 0.75), at(0.75, 0.75)], [1.0, 2.0]);
        assert_eq!(at(0.5, 0.5), 2.5);
    }

    /// Beyond the edges: again, mirrored, or the edge.
    #[test]
    fn edges_wrap() {
        let p = float(4, 1, vec![0.0, 1.0, 2.0, 3.0]);
        let at = |u, wrap| {
            let wrap = [wrap, Wrap::Clamp];
            p.find(Vec2::new(u, 0.5), 0.0, wrap, Interpolation::Bilinear).read()[0]
        };
        for turn in [-3.0, -1.0, 1.0, 2.0, 100.0] {
            assert_eq!(at(0.375 + turn, Wrap::Repeat), 1.0);
            assert_eq!(at(0.375 + 2.0 * turn, Wrap::Mirror), 1.0);
            assert_eq!(at(2.0 * turn - 0.375, Wrap::Mirror), 1.0);
        }
        assert_eq!(at(1.0, Wrap::Repeat), 1.5);
        assert_eq!(at(1.0, Wrap::Mirror), 3.0);
        assert_eq!([at(-7.0, Wrap::Clamp), at(9.0, Wrap::Clamp)], [0.0, 3.0]);
        // One column is its own neighbour, and what rounds to the far edge is still within.
        let one = float(1, 1, vec![7.0]);
        for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
            for u in [0.0, 0.3, 1.0, -1e-9, 1.0 - 1e-9] {
                let found = one.find(Vec2::new(u, u), 0.0, [wrap; 2], Interpolation::Bilinear);
                assert_eq!(found.read(), [7.0, 7.0, 7.0, 1.0]);
            }
            for (x, i) in [(0.0, 0), (4.0, 3), (3.999_999_8, 3), (0.5, 0), (0.499, 0)] {
                let ([first, second], part) = wrap.neighbours(x, 4);
                assert!(first < 4 && second < 4 && (0.0..=1.0).contains(&part), "{x} {part}");
                assert!([first, second].contains(&i), "{x}: {first} {second}");
            }
        }
        for u in [f32::NAN, f32::INFINITY, f32::MAX, f32::MIN] {
            for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
                assert!(at(u, wrap).is_finite());
            }
        }
    }

    /// The wider the view, the fewer texels are looked at, down to one; and never more than a
    /// factor of two away.
    #[test]
    fn levels_follow_the_width() {
        let p = float(64, 64, vec![1.0; 64 * 64]);
        for (width, side) in [(0.0, 64), (1.0, 64), (1.9, 64), (2.0, 32), (7.9, 16), (8.0, 8)] {
            assert_eq!(p.level(width).width(), side, "{width}");
        }
        for width in [64.0, 1e9, f32::INFINITY] {
            assert_eq!(p.level(width).width(), 1);
        }
        assert_eq!(p.level(f32::NAN).width(), 64);
    }

    /// 8 bits stay 8 bits: all levels together take a third more.
    #[test]
    fn memory_is_four_thirds() {
        let bytes = Pyramid::new(grey(512, 512, vec![7; 512 * 512]), Encoding::Srgb).bytes();
        assert!((349_000..350_000).contains(&bytes), "{bytes}");
    }
}
