//! Pictures of one number per pixel, and how they are blurred.

use rayon::prelude::*;

/// One number per pixel.
pub(super) struct Plane {
    /// Pixels in a row.
    pub(super) width: usize,
    /// (height, width) numbers.
    pub(super) values: Vec<f32>,
}

impl Plane {
    /// Weighted sums with `across` along rows, then `down` along columns; both
    /// have odd lengths. Pixels outside take the value of the nearest inside.
    pub(super) fn convolved(&self, across: &[f32], down: &[f32]) -> Self {
        let width = self.width;
        let height = self.values.len() / width;

        let mut rows = vec![0.0; self.values.len()];
        let radius = across.len() / 2;
        rows.par_chunks_mut(width).zip(self.values.par_chunks(width)).for_each(|(to, from)| {
            let outside = |x: f32| std::iter::repeat_n(x, radius);
            let padded: Vec<f32> = outside(from[0])
                .chain(from.iter().copied())
                .chain(outside(from[width - 1]))
                .collect();
            for (tap, weight) in across.iter().enumerate() {
                to.iter_mut().zip(&padded[tap..]).for_each(|(to, from)| *to += weight * from);
            }
        });

        let mut values = vec![0.0; self.values.len()];
        let radius = down.len() / 2;
        values.par_chunks_mut(width).enumerate().for_each(|(y, to)| {
            for (tap, weight) in down.iter().enumerate() {
                let from = (y + tap).saturating_sub(radius).min(height - 1) * width;
                for (value, row) in to.iter_mut().zip(&rows[from..from + width]) {
                    *value += weight * row;
                }
            }
        });
        Self { width, values }
    }
}

/// A function at the whole numbers from `-radius` to `radius`.
pub(super) fn taps(radius: f32, f: impl Fn(f32) -> f32) -> Vec<f32> {
    let r = radius as i32;
    (-r..=r).map(|x| f(x as f32)).collect()
}
