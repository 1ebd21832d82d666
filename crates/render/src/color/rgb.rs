//! An authored colour.

/// Red, green and blue, scene-linear over the sRGB/Rec. 709 primaries.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rgb(pub [f32; 3]);

impl Rgb {
    /// Nothing.
    pub const BLACK: Self = Self::grey(0.0);
    /// One in each channel.
    pub const WHITE: Self = Self::grey(1.0);

    /// From three channels.
    pub const fn new(r: f32, g: f32, b: f32) -> Self {
        Self([r, g, b])
    }

    /// The same value in each channel.
    pub const fn grey(value: f32) -> Self {
        Self([value; 3])
    }

    /// True when every channel is a finite number.
    pub fn is_finite(&self) -> bool {
        self.0.iter().all(|c| c.is_finite())
    }

    /// True when every channel lies in `range`; never true for NaN.
    pub fn is_within(&self, range: std::ops::RangeInclusive<f32>) -> bool {
        self.0.iter().all(|c| range.contains(c))
    }
}
