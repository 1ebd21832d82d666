//! The images of formats that hold sRGB codes: from codes to light.

use rutilant::display::linear_from_srgb;
use rutilant::image::{Channel, Image};
use std::sync::LazyLock;

/// The light of each 8-bit code.
static LIGHT_8: LazyLock<Vec<f32>> = LazyLock::new(|| table(u8::MAX.into()));
/// The light of each 16-bit code.
static LIGHT_16: LazyLock<Vec<f32>> = LazyLock::new(|| table(u16::MAX.into()));

fn table(last: u32) -> Vec<f32> {
    (0..=last).map(|code| linear_from_srgb(f64::from(code) / f64::from(last)) as f32).collect()
}

/// The image of decoded 8- or 16-bit samples: (height, width, channel), row 0 on top. With one or
/// two channels the first is `Y`, else the first three are `R`, `G`, `B`; the last of an even
/// number is `A`, which is not encoded, and with which colours are not multiplied.
pub(super) fn image(
    width: u32,
    height: u32,
    channels: usize,
    samples: Samples<'_>,
) -> Option<Image> {
    let names: &[&str] = match channels {
        1 => &["Y"],
        2 => &["Y", "A"],
        3 => &["R", "G", "B"],
        4 => &["R", "G", "B", "A"],
        _ => return None,
    };
    let channel = |(i, name): (usize, &&str)| {
        let values = match (samples, *name) {
            (Samples::Eight(bytes), "A") => {
                every(bytes, i, channels).map(|&a| f32::from(a) / 255.0).collect()
            }
            (Samples::Eight(bytes), _) => {
                every(bytes, i, channels).map(|&code| LIGHT_8[usize::from(code)]).collect()
            }
            (Samples::Sixteen(words), "A") => {
                every(words, i, channels).map(|&a| f32::from(a) / 65535.0).collect()
            }
            (Samples::Sixteen(words), _) => {
                every(words, i, channels).map(|&code| LIGHT_16[usize::from(code)]).collect()
            }
        };
        Channel { name: (*name).to_owned(), values }
    };
    Image::new(width, height, names.iter().enumerate().map(channel).collect())
}

/// Samples as a decoder gives them.
#[derive(Clone, Copy)]
pub(super) enum Samples<'a> {
    Eight(&'a [u8]),
    Sixteen(&'a [u16]),
}

fn every<T>(samples: &[T], first: usize, step: usize) -> impl Iterator<Item = &T> {
    samples.iter().skip(first).step_by(step)
}
