//! Pictures as formats for displays hold them: codes of 8 or 16 bits.

use ::image::{ColorType, ImageDecoder};
use rutilant::display::linear_from_srgb;
use rutilant::image::{Channel, Image};
use rutilant::texture::{Bitmap, Texels};
use std::sync::LazyLock;

/// The light of each 8-bit code.
static LIGHT_8: LazyLock<Vec<f32>> = LazyLock::new(|| table(u8::MAX.into()));
/// The light of each 16-bit code.
static LIGHT_16: LazyLock<Vec<f32>> = LazyLock::new(|| table(u16::MAX.into()));

fn table(last: u32) -> Vec<f32> {
    (0..=last).map(|code| linear_from_srgb(f64::from(code) / f64::from(last)) as f32).collect()
}

/// A decoded picture. With one or two channels the first is grey, else the first three are red,
/// green and blue; the last of an even number is opacity, with which colours are not multiplied.
pub(super) struct Codes {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) channels: usize,
    pub(super) samples: Samples,
}

/// (height, width, channel) codes, row 0 on top.
pub(super) enum Samples {
    Eight(Vec<u8>),
    Sixteen(Vec<u16>),
}

impl Codes {
    /// What a decoder gives, whose sizes are checked, in 8 bits.
    pub(super) fn decoded(decoder: impl ImageDecoder) -> Result<Self, String> {
        let (width, height) = decoder.dimensions();
        let channels = match decoder.color_type() {
            ColorType::L8 => 1,
            ColorType::La8 => 2,
            ColorType::Rgb8 => 3,
            ColorType::Rgba8 => 4,
            other => return Err(format!("pixels of type {other:?} are not read")),
        };
        let total = usize::try_from(decoder.total_bytes()).map_err(|e| e.to_string())?;
        let mut buffer = vec![0; total];
        decoder.read_image(&mut buffer).map_err(|e| e.to_string())?;
        Ok(Self { width, height, channels, samples: Samples::Eight(buffer) })
    }

    /// The light that the codes stand for, taken as sRGB but for opacity, in channels `Y` or `R`,
    /// `G`, `B`, and `A`. `None` where the samples do not fit the size.
    pub(super) fn light(&self) -> Option<Image> {
        let names: &[&str] = match self.channels {
            1 => &["Y"],
            2 => &["Y", "A"],
            3 => &["R", "G", "B"],
            4 => &["R", "G", "B", "A"],
            _ => return None,
        };
        let channel = |(i, name): (usize, &&str)| {
            let values = match (&self.samples, *name) {
                (Samples::Eight(bytes), "A") => {
                    every(bytes, i, self.channels).map(|&a| f32::from(a) / 255.0).collect()
                }
                (Samples::Eight(bytes), _) => {
                    every(bytes, i, self.channels).map(|&c| LIGHT_8[usize::from(c)]).collect()
                }
                (Samples::Sixteen(words), "A") => {
                    every(words, i, self.channels).map(|&a| f32::from(a) / 65535.0).collect()
                }
                (Samples::Sixteen(words), _) => {
                    every(words, i, self.channels).map(|&c| LIGHT_16[usize::from(c)]).collect()
                }
            };
            Channel { name: (*name).to_owned(), values }
        };
        Image::new(self.width, self.height, names.iter().enumerate().map(channel).collect())
    }

    /// The codes themselves, for a texture. `None` where the samples do not fit the size.
    pub(super) fn bitmap(self) -> Option<Bitmap> {
        let texels = match self.samples {
            Samples::Eight(bytes) => Texels::Eight(bytes),
            Samples::Sixteen(words) => Texels::Sixteen(words),
        };
        Bitmap::new(self.width, self.height, self.channels, texels)
    }
}

fn every<T>(samples: &[T], first: usize, step: usize) -> impl Iterator<Item = &T> {
    samples.iter().skip(first).step_by(step)
}

/// A bitmap of light as a picture whose [`bitmap_of`] it is; `None` for one of codes.
pub(super) fn image_of(bitmap: &Bitmap) -> Option<Image> {
    let Texels::Float(values) = bitmap.texels() else { return None };
    let names: &[&str] = match bitmap.channels() {
        1 => &["Y"],
        2 => &["Y", "A"],
        3 => &["R", "G", "B"],
        _ => &["R", "G", "B", "A"],
    };
    let channels = names.iter().enumerate().map(|(i, name)| {
        let values = every(values, i, bitmap.channels()).copied().collect();
        Channel { name: (*name).to_owned(), values }
    });
    Image::new(bitmap.width(), bitmap.height(), channels.collect())
}

/// A picture of light as a texture: its colour, and its opacity where it has a channel `A`. `None`
/// where it has no colour.
pub(super) fn bitmap_of(image: &Image) -> Option<Bitmap> {
    let grey = image.channel("R").is_none() && image.channel("Y").is_some();
    let colors: &[&str] = if grey { &["Y"] } else { &["R", "G", "B"] };
    let names = colors.iter().chain(&["A"]).filter_map(|name| image.channel(name));
    let channels: Vec<&[f32]> = names.collect();
    if channels.len() < colors.len() || colors.iter().any(|name| image.channel(name).is_none()) {
        return None;
    }
    let pixels = image.width() as usize * image.height() as usize;
    let texels = (0..pixels).flat_map(|i| channels.iter().map(move |values| values[i]));
    Bitmap::new(image.width(), image.height(), channels.len(), Texels::Float(texels.collect()))
}
