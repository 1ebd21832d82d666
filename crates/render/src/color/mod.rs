//! Colours that people write, and light that rays carry.
//!
//! Both are three numbers over the sRGB/Rec. 709 primaries, scene-linear. They
//! are types of their own because they mean different things: an [`Rgb`] is an
//! authored value (an albedo, a tint, a radiance in a file), a [`Spectrum`] is
//! what is traced, and the latter will one day hold wavelengths.

mod observer;
mod rgb;
mod spectrum;

pub use observer::color_matching;
pub use rgb::Rgb;
pub use spectrum::Spectrum;
