//! Pictures to compare.

use rayon::prelude::*;

/// A picture as rows of colours, row 0 on top; at least one pixel.
#[derive(Clone, Debug)]
pub(crate) struct Pixels {
    /// Pixels in a row.
    pub(super) width: usize,
    /// (height, width) colours.
    pub(super) values: Vec<[f32; 3]>,
}

impl Pixels {
    /// Every pixel by itself.
    pub(super) fn map(&self, f: impl Fn([f32; 3]) -> [f32; 3] + Sync) -> Self {
        Self { width: self.width, values: self.values.par_iter().map(|rgb| f(*rgb)).collect() }
    }
}
