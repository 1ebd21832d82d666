//! Light as the renderer carries it.

use super::rgb::Rgb;
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Sub};

/// A radiance, a throughput or an absorption, per channel.
///
/// Unit and meaning follow from the place it stands in. All operations work
/// channel by channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spectrum([f32; 3]);

impl Spectrum {
    /// No light.
    pub const BLACK: Self = Self::splat(0.0);
    /// One in each channel.
    pub const WHITE: Self = Self::splat(1.0);

    /// The same value in each channel.
    pub const fn splat(value: f32) -> Self {
        Self([value; 3])
    }

    /// The channels, in the order red, green, blue.
    pub const fn channels(self) -> [f32; 3] {
        self.0
    }

    /// Relative luminance: how bright an eye finds it (Rec. 709).
    pub fn luminance(self) -> f32 {
        let [r, g, b] = self.0;
        0.212_671 * r + 0.715_160 * g + 0.072_169 * b
    }

    /// The largest channel.
    pub fn max_channel(self) -> f32 {
        let [r, g, b] = self.0;
        r.max(g).max(b)
    }

    /// True when there is no light in any channel.
    pub fn is_black(self) -> bool {
        self.0 == [0.0; 3]
    }

    /// True when every channel is a finite number.
    pub fn is_finite(self) -> bool {
        self.0.iter().all(|c| c.is_finite())
    }

    /// Applies a function to each channel.
    #[must_use]
    pub fn map(self, f: impl FnMut(f32) -> f32) -> Self {
        Self(self.0.map(f))
    }

    fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([f(a, x), f(b, y), f(c, z)])
    }
}

impl From<Rgb> for Spectrum {
    fn from(rgb: Rgb) -> Self {
        Self(rgb.0)
    }
}

impl From<[f32; 3]> for Spectrum {
    fn from(channels: [f32; 3]) -> Self {
        Self(channels)
    }
}

impl Add for Spectrum {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl AddAssign for Spectrum {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for Spectrum {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl Mul for Spectrum {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

impl MulAssign for Spectrum {
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}

impl Mul<f32> for Spectrum {
    type Output = Self;
    fn mul(self, factor: f32) -> Self {
        self.map(|c| c * factor)
    }
}

impl MulAssign<f32> for Spectrum {
    fn mul_assign(&mut self, factor: f32) {
        *self = *self * factor;
    }
}

impl Div<f32> for Spectrum {
    type Output = Self;
    fn div(self, divisor: f32) -> Self {
        self.map(|c| c / divisor)
    }
}
