//! From what was rendered to what the window shows.
//!
//! Everything here is done beside the interface, on whole pictures: bytes for
//! the screen, what the histogram counts, how much noise there is.

use eframe::egui::{Color32, ColorImage};
use rayon::prelude::*;
use rutilant::display::Display;
use rutilant::false_color::magma;
use rutilant::image::Image;
use rutilant::settings::IntegratorKind;
use std::sync::Arc;

/// What of a picture is looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Channel {
    /// Light.
    #[default]
    Radiance,
    /// The part of white light that surfaces send back.
    Albedo,
    /// Which way surfaces face.
    Normal,
    /// How far away they are.
    Depth,
    /// How uncertain each pixel still is.
    Variance,
    /// How many samples each pixel has.
    Samples,
}

impl Channel {
    /// All of them, with what people call them.
    pub const ALL: [(Self, &str); 6] = [
        (Self::Radiance, "Radiance"),
        (Self::Albedo, "Albedo"),
        (Self::Normal, "Normal"),
        (Self::Depth, "Depth"),
        (Self::Variance, "Variance"),
        (Self::Samples, "Samples"),
    ];

    /// What has to be rendered for it, where that is not what the scene asks for.
    pub(crate) fn integrator(self) -> Option<IntegratorKind> {
        match self {
            Self::Radiance | Self::Variance | Self::Samples => None,
            Self::Albedo => Some(IntegratorKind::Albedo),
            Self::Normal => Some(IntegratorKind::Normals),
            Self::Depth => Some(IntegratorKind::Depth),
        }
    }
}

/// How a picture is looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct View {
    /// What of it.
    pub channel: Channel,
    /// Exposure and curve, for light.
    pub display: Display,
    /// Luminance as colours, over sixteen stops.
    pub false_color: bool,
    /// What is brighter than the screen can show is marked red, what is no number magenta.
    pub overlay: bool,
    /// The longest side that the graphics can show.
    pub most_side: Option<usize>,
}

/// Bins of a [`Histogram`].
pub(crate) const BINS: usize = 96;

/// How many pixels are how bright, in thirds of stops from 2⁻¹⁶ to 2¹⁶ after exposure.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Histogram {
    /// Red, green, blue.
    pub(crate) counts: [[u32; BINS]; 3],
}

/// A picture for the window.
#[derive(Debug)]
pub(crate) struct Developed {
    pub(crate) size: [u32; 2],
    /// All its pixels.
    pub(crate) pixels: Arc<ColorImage>,
    /// The same, or with fewer pixels where the graphics cannot show so many.
    pub(crate) small: Arc<ColorImage>,
    /// What it was made of.
    pub(crate) image: Arc<Image>,
    pub(crate) histogram: Histogram,
    /// The standard error of pixels over their values, both as root mean squares.
    pub(crate) noise: Option<f32>,
    /// Pixels that the overlay marks.
    pub(crate) clipped: u64,
}

/// How much of a picture is not known yet, and what stands in for it: a coarser one.
pub(crate) fn filled(image: Image, coarse: &Image) -> Image {
    let Some(counts) = image.channel("samples.Y") else { return image };
    if counts.iter().all(|&n| n > 0.0) {
        return image;
    }
    let (width, height) = (image.width(), image.height());
    let scale = |at: u32, from: u32, to: u32| {
        ((u64::from(at) * u64::from(to)) / u64::from(from.max(1))).min(u64::from(to) - 1) as usize
    };
    let channels = image.channels().iter().map(|channel| {
        let mut channel = channel.clone();
        if let Some(stand_in) = coarse.channel(&channel.name).filter(|_| channel.name.len() == 1) {
            for (y, row) in (0..height).zip(channel.values.chunks_exact_mut(width as usize)) {
                let from = scale(y, height, coarse.height()) * coarse.width() as usize;
                for (x, value) in (0..width).zip(row) {
                    if counts[(y * width + x) as usize] == 0.0 {
                        *value = stand_in[from + scale(x, width, coarse.width())];
                    }
                }
            }
        }
        channel
    });
    let channels = channels.collect();
    Image::new(width, height, channels).unwrap_or(image)
}

/// How many samples every pixel has at least.
pub(crate) fn samples_of(image: &Image) -> u64 {
    let counts = image.channel("samples.Y").unwrap_or(&[]);
    least(counts.iter().copied()) as u64
}

/// Makes the bytes that the window shows.
pub(crate) fn develop(image: Arc<Image>, view: &View) -> Developed {
    let (width, height) = (image.width(), image.height());
    let light = image.rgb().unwrap_or_default();
    let numbers = |names: [&str; 3]| names.map(|name| image.channel(name).unwrap_or(&[]));
    // A single sample tells nothing of how far it is off.
    let counts = image.channel("samples.Y").unwrap_or(&[]);
    let noise = noise(&light, numbers(["variance.R", "variance.G", "variance.B"]))
        .filter(|_| counts.iter().all(|&count| count > 1.0));
    let gain = view.display.exposure.exp2();

    let pixels: Vec<Color32> = match view.channel {
        Channel::Radiance => light.par_iter().map(|&rgb| shown(rgb, gain, view)).collect(),
        Channel::Albedo | Channel::Normal => {
            let plain = Display::default();
            light.par_iter().map(|&rgb| opaque(plain.encode(rgb))).collect()
        }
        Channel::Depth => {
            // Where nothing is, the distance is 0: that stays black.
            let near = least(light.iter().map(|p| p[0]).filter(|&d| d > 0.0));
            let far = light.iter().map(|p| p[0]).filter(|d| d.is_finite()).fold(0.0, f32::max);
            let grey = |p: &[f32; 3]| {
                let part = (far - p[0]) / (far - near).max(f32::MIN_POSITIVE);
                let part = if p[0] > 0.0 { 0.1 + 0.9 * part.clamp(0.0, 1.0) } else { 0.0 };
                Color32::from_gray((255.0 * part) as u8)
            };
            light.par_iter().map(grey).collect()
        }
        Channel::Variance => {
            let variance = numbers(["variance.R", "variance.G", "variance.B"]);
            let error = |i: usize| {
                let sum: f32 = variance.iter().filter_map(|c| c.get(i)).sum();
                let mean = light[i].iter().sum::<f32>() / 3.0;
                // From a thousandth of the value to all of it.
                let relative = (sum / 3.0).sqrt() / mean.abs().max(1e-4);
                opaque(encoded(magma(1.0 + relative.max(1e-6).log10() / 3.0)))
            };
            (0..light.len()).into_par_iter().map(error).collect()
        }
        Channel::Samples => {
            let counts = image.channel("samples.Y").unwrap_or(&[]);
            let most = counts.iter().copied().fold(1.0, f32::max);
            let count =
                |i: usize| opaque(encoded(magma(counts.get(i).copied().unwrap_or(0.0) / most)));
            (0..light.len()).into_par_iter().map(count).collect()
        }
    };
    let clipped = light.iter().filter(|p| mark(**p, gain).is_some()).count() as u64;
    let histogram = histogram(&light, gain);
    let pixels = ColorImage::new([width, height].map(|side| side as usize), pixels);
    let pixels = Arc::new(pixels);
    let small = match view.most_side {
        Some(most) if pixels.size.iter().any(|&side| side > most) => {
            Arc::new(shrunk(&pixels, most.max(1)))
        }
        _ => Arc::clone(&pixels),
    };
    Developed { size: [width, height], pixels, small, image, histogram, noise, clipped }
}

/// The means of squares of pixels, so large that no side is longer than `most`.
fn shrunk(image: &ColorImage, most: usize) -> ColorImage {
    let [width, height] = image.size;
    let step = width.max(height).div_ceil(most);
    let size = [width.div_ceil(step), height.div_ceil(step)];
    let mean = |i: usize| {
        let (x, y) = (i % size[0] * step, i / size[0] * step);
        let (mut sum, mut count) = ([0_u32; 3], 0);
        for row in image.pixels.chunks_exact(width).skip(y).take(step) {
            for color in row.iter().skip(x).take(step) {
                sum = [
                    sum[0] + u32::from(color.r()),
                    sum[1] + u32::from(color.g()),
                    sum[2] + u32::from(color.b()),
                ];
                count += 1;
            }
        }
        opaque(sum.map(|channel| (channel / count.max(1)) as u8))
    };
    let pixels = (0..size[0] * size[1]).into_par_iter().map(mean).collect();
    ColorImage::new(size, pixels)
}

fn opaque([r, g, b]: [u8; 3]) -> Color32 {
    Color32::from_rgb(r, g, b)
}

/// Linear light from 0 to 1 as sRGB bytes.
fn encoded(rgb: [f32; 3]) -> [u8; 3] {
    Display::default().encode(rgb)
}

fn shown(rgb: [f32; 3], gain: f32, view: &View) -> Color32 {
    if view.overlay
        && let Some(color) = mark(rgb, gain)
    {
        return color;
    }
    if view.false_color {
        // Eight stops below 1 to eight above.
        let luminance = gain * (0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]);
        return opaque(encoded(magma((luminance.max(1e-9).log2() + 8.0) / 16.0)));
    }
    opaque(view.display.encode(rgb))
}

/// The colour of what cannot be shown as it is.
fn mark(rgb: [f32; 3], gain: f32) -> Option<Color32> {
    if rgb.iter().any(|c| !c.is_finite()) {
        Some(Color32::from_rgb(255, 0, 255))
    } else if rgb.iter().any(|c| c * gain > 1.0) {
        Some(Color32::from_rgb(255, 40, 40))
    } else {
        rgb.iter().any(|c| *c < 0.0).then_some(Color32::from_rgb(40, 120, 255))
    }
}

fn least(values: impl Iterator<Item = f32>) -> f32 {
    values.fold(f32::INFINITY, f32::min)
}

fn noise(light: &[[f32; 3]], variance: [&[f32]; 3]) -> Option<f32> {
    let (mut errors, mut squares) = (0.0_f64, 0.0_f64);
    for (i, rgb) in light.iter().enumerate() {
        for (c, variance) in variance.iter().enumerate() {
            let (value, variance) = (f64::from(rgb[c]), f64::from(*variance.get(i)?));
            if value.is_finite() && variance.is_finite() {
                errors += variance;
                squares += value * value;
            }
        }
    }
    (squares > 0.0).then(|| (errors / squares).sqrt() as f32)
}

fn histogram(light: &[[f32; 3]], gain: f32) -> Histogram {
    let mut counts = [[0; BINS]; 3];
    for rgb in light {
        for (counts, &c) in counts.iter_mut().zip(rgb) {
            let bin = (3.0 * ((c * gain).log2() + 16.0)).floor();
            // What is black, negative or no number has no place on it.
            if bin >= 0.0 && bin.is_finite() {
                counts[(bin as usize).min(BINS - 1)] += 1;
            }
        }
    }
    Histogram { counts }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rutilant::image::Channel as Layer;

    fn image(width: u32, height: u32, pixels: &[[f32; 3]]) -> Arc<Image> {
        Arc::new(Image::from_rgb(width, height, pixels).unwrap())
    }

    /// Light is shown as files show it, to the byte, and marks stand where values are out of
    /// range and nowhere else.
    #[test]
    fn light_is_shown_as_in_files() {
        let values = [[0.18; 3], [2.0, 0.1, 0.1], [f32::NAN, 0.0, 0.0], [-1.0, 0.5, 0.5]];
        let display = Display { exposure: 0.5, ..Display::default() };
        let view = View { display, ..View::default() };
        let developed = develop(image(2, 2, &values), &view);
        for (pixel, value) in developed.pixels.pixels.iter().zip(values) {
            assert_eq!(pixel.to_array()[..3], display.encode(value));
        }
        let marked = develop(image(2, 2, &values), &View { overlay: true, ..view });
        let differ: Vec<bool> = marked
            .pixels
            .pixels
            .iter()
            .zip(&developed.pixels.pixels)
            .map(|(a, b)| a != b)
            .collect();
        assert_eq!(differ, [false, true, true, true]);
        assert_eq!(marked.clipped, 3);
    }

    /// Every channel of every picture gives opaque pixels, whatever numbers are in it.
    #[test]
    fn every_channel_shows_something() {
        let odd = [[f32::NAN; 3], [f32::INFINITY; 3], [-1e30; 3], [1e-40; 3], [0.0; 3], [3.0; 3]];
        let plain = image(3, 2, &odd);
        let mut channels = plain.channels().to_vec();
        for (i, name) in ["variance.R", "variance.G", "variance.B", "samples.Y"].iter().enumerate()
        {
            let values = odd.iter().map(|p| p[0] * i as f32).collect();
            channels.push(Layer { name: (*name).to_owned(), values });
        }
        let full = Arc::new(Image::new(3, 2, channels).unwrap());
        for image in [plain, full, image(0, 0, &[])] {
            for (channel, _) in Channel::ALL {
                for flags in 0..4 {
                    let (false_color, overlay) = (flags & 1 == 1, flags & 2 == 2);
                    let view = View { channel, false_color, overlay, ..View::default() };
                    let developed = develop(Arc::clone(&image), &view);
                    let pixels = &developed.pixels.pixels;
                    assert_eq!(pixels.len() as u32, image.width() * image.height());
                    assert!(pixels.iter().all(|p| p.a() == 255));
                }
            }
        }
    }

    /// Grey 1 at exposure 0 is in the first bin above the middle, and a stop is three bins.
    #[test]
    fn the_histogram_counts_thirds_of_stops() {
        let counts = |value: f32, exposure| {
            let display = Display { exposure, ..Display::default() };
            let view = View { display, ..View::default() };
            develop(image(1, 1, &[[value; 3]]), &view).histogram.counts[1]
        };
        let bin = |value, exposure| counts(value, exposure).iter().position(|&n| n == 1);
        assert_eq!((bin(1.0, 0.0), bin(1.0, 1.0), bin(0.24, 0.0)), (Some(48), Some(51), Some(41)));
        assert_eq!((bin(0.0, 0.0), bin(f32::NAN, 0.0), bin(1e30, 0.0)), (None, None, Some(95)));
    }

    /// What is too large for the graphics is shown smaller, each pixel the mean of those it stands for.
    #[test]
    fn large_pictures_are_shrunk() {
        let pixels: Vec<[f32; 3]> = (0..15).map(|i| [[0.0; 3], [1.0; 3]][i % 2]).collect();
        let view = View { most_side: Some(2), ..View::default() };
        let developed = develop(image(5, 3, &pixels), &view);
        assert_eq!((developed.pixels.size, developed.small.size), ([5, 3], [2, 1]));
        let white = Display::default().encode([1.0; 3])[0];
        let grey = |share: usize| (usize::from(white) * share / 9) as u8;
        assert_eq!(developed.small.pixels[0], Color32::from_gray(grey(4)));
        let whole = View { most_side: Some(5), ..view };
        let whole = develop(image(5, 3, &pixels), &whole);
        assert!(Arc::ptr_eq(&whole.small, &whole.pixels));
    }

    /// Only what has no samples yet is taken from the coarse picture.
    #[test]
    fn gaps_are_filled() {
        let with_counts = |pixels: &[[f32; 3]], counts: &[f32]| {
            let mut channels = image(2, 2, pixels).channels().to_vec();
            channels.push(Layer { name: "samples.Y".into(), values: counts.to_vec() });
            Image::new(2, 2, channels).unwrap()
        };
        let fine = with_counts(&[[1.0; 3], [2.0; 3], [0.0; 3], [4.0; 3]], &[1.0, 1.0, 0.0, 2.0]);
        let coarse = image(1, 1, &[[9.0; 3]]);
        let all = filled(fine, &coarse);
        assert_eq!(all.channel("G").unwrap(), [1.0, 2.0, 9.0, 4.0]);
        assert_eq!(all.channel("samples.Y").unwrap(), [1.0, 1.0, 0.0, 2.0]);
    }

    /// One pixel of value 2 with a standard error of 0.02 has 1 % noise.
    #[test]
    fn noise_is_relative() {
        let mut channels = image(1, 1, &[[2.0; 3]]).channels().to_vec();
        for name in ["variance.R", "variance.G", "variance.B"] {
            channels.push(Layer { name: name.into(), values: vec![4e-4] });
        }
        let image = Arc::new(Image::new(1, 1, channels).unwrap());
        let noise = develop(image, &View::default()).noise.unwrap();
        assert!((noise - 0.01).abs() < 1e-6, "{noise}");
    }
}
