//! `rutilant compare`: how far a picture is from a reference.

mod false_color;
mod flip;
mod metrics;
#[cfg(test)]
mod testing;

/// A picture as rows of colours, row 0 on top; at least one pixel.
#[derive(Clone, Debug)]
pub(crate) struct Pixels {
    /// Pixels in a row.
    width: usize,
    /// (height, width) colours.
    values: Vec<[f32; 3]>,
}

impl Pixels {
    /// Every pixel by itself.
    fn map(&self, f: impl Fn([f32; 3]) -> [f32; 3]) -> Self {
        Self { width: self.width, values: self.values.iter().map(|rgb| f(*rgb)).collect() }
    }
}

/// From an sRGB value to linear light, both 0 to 1 (IEC 61966-2-1).
fn srgb_decode(v: f32) -> f32 {
    if v <= 0.040_45 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}
