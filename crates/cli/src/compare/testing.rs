//! Pictures by formula, the same in any language: for tests against other programs.

use super::pixels::Pixels;

fn picture((width, height): (usize, usize), f: impl Fn(usize, usize) -> [f32; 3]) -> Pixels {
    let values = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    Pixels { width, values: values.map(|(x, y)| f(x, y)).collect() }
}

/// A number in [0, 1) from place, channel and seed.
fn hash(x: usize, y: usize, channel: u32, seed: u32) -> f32 {
    let mut v = (x as u32).wrapping_mul(0x9e37_79b1);
    v = v.wrapping_add((y as u32).wrapping_mul(0x85eb_ca77));
    v = v.wrapping_add(channel.wrapping_mul(0xc2b2_ae3d));
    v = v.wrapping_add(seed.wrapping_mul(0x27d4_eb2f));
    v = (v ^ (v >> 15)).wrapping_mul(0x2c1b_3c6d);
    v = (v ^ (v >> 12)).wrapping_mul(0x297a_2d39);
    v ^= v >> 15;
    (v >> 8) as f32 / (1 << 24) as f32
}

/// Every channel of every pixel on its own.
pub(crate) fn noise(size: (usize, usize), seed: u32) -> Pixels {
    picture(size, |x, y| [0, 1, 2].map(|c| hash(x, y, c, seed)))
}

/// Red grows to the right, green downwards, blue both ways.
pub(crate) fn ramp((width, height): (usize, usize)) -> Pixels {
    let part = |a: usize, n: usize| a as f32 / n.saturating_sub(1).max(1) as f32;
    picture((width, height), |x, y| {
        [part(x, width), part(y, height), (x + y) as f32 / (width + height - 2).max(1) as f32]
    })
}

/// Squares of `side` pixels.
pub(crate) fn checker(size: (usize, usize), side: usize) -> Pixels {
    picture(size, |x, y| {
        let k = ((x / side + y / side) % 2) as f32;
        [k, 0.25 + 0.5 * k, 1.0 - k]
    })
}

/// The picture with noise of the whole width `amount`, clamped to 0..1.
pub(crate) fn noisy(picture: &Pixels, seed: u32, amount: f32) -> Pixels {
    let grain = noise((picture.width, picture.values.len() / picture.width), seed);
    let values = picture.values.iter().zip(grain.values);
    let values =
        values.map(|(p, g)| [0, 1, 2].map(|i| (p[i] + amount * (g[i] - 0.5)).clamp(0.0, 1.0)));
    Pixels { width: picture.width, values: values.collect() }
}

/// The picture one pixel to the right; its first column stays.
pub(crate) fn shifted(picture: &Pixels) -> Pixels {
    let rows = picture.values.chunks(picture.width);
    let values = rows.flat_map(|row| row[..1].iter().chain(&row[..row.len() - 1]));
    Pixels { width: picture.width, values: values.copied().collect() }
}
