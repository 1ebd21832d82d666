//! Pixels with named channels.

/// A picture: some channels of equal size, each scene-linear unless its maker says otherwise.
///
/// Row 0 is on top. The usual channels are named as OpenEXR names them:
/// `R`, `G`, `B` for radiance or colour, `A` for coverage,
/// `variance.R` and so on for the variance of each pixel's mean, and
/// `samples.Y` for the number of samples in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    width: u32,
    height: u32,
    channels: Vec<Channel>,
}

/// One number per pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Its name, unique within the image.
    pub name: String,
    /// (height, width) values, row 0 on top.
    pub values: Vec<f32>,
}

impl Image {
    /// An image of `channels`, each with `width * height` values. `None` where a channel has another length.
    pub fn new(width: u32, height: u32, channels: Vec<Channel>) -> Option<Self> {
        let pixels = usize::try_from(u64::from(width) * u64::from(height)).ok()?;
        channels.iter().all(|c| c.values.len() == pixels).then_some(Self {
            width,
            height,
            channels,
        })
    }

    /// An image with channels `R`, `G`, `B` from interleaved `pixels`: (height, width), row 0 on
    /// top. `None` where the count does not fit.
    pub fn from_rgb(width: u32, height: u32, pixels: &[[f32; 3]]) -> Option<Self> {
        let channel = |name: &str, i: usize| Channel {
            name: name.to_owned(),
            values: pixels.iter().map(|p| p[i]).collect(),
        };
        Self::new(width, height, vec![channel("R", 0), channel("G", 1), channel("B", 2)])
    }

    /// Pixels in a row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// All channels in their order.
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// The values of the channel `name`: (height, width), row 0 on top.
    pub fn channel(&self, name: &str) -> Option<&[f32]> {
        self.channels.iter().find(|c| c.name == name).map(|c| &*c.values)
    }

    /// The pixels' colours, (height, width): `R`, `G`, `B`, or a lone `Y` in all three.
    /// `None` for an image without colour.
    pub fn rgb(&self) -> Option<Vec<[f32; 3]>> {
        let [r, g, b] = match self.channel("Y") {
            Some(y) => [y; 3],
            None => [self.channel("R")?, self.channel("G")?, self.channel("B")?],
        };
        Some((0..r.len()).map(|i| [r[i], g[i], b[i]]).collect())
    }

    /// The image with no channels but those that `keep` accepts by their names.
    pub fn only(&self, keep: impl Fn(&str) -> bool) -> Self {
        let kept = self.channels.iter().filter(|channel| keep(&channel.name));
        Self { channels: kept.cloned().collect(), ..*self }
    }

    /// A fingerprint of size, channel names and the bits of every value: equal
    /// images have equal hashes, on every machine (64-bit FNV-1a).
    pub fn hash(&self) -> u64 {
        let mut hash: u64 = 0xcbf2_9ce4_8422_2325;
        let mut eat = |bytes: &[u8]| {
            for &byte in bytes {
                hash = (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
            }
        };
        eat(&self.width.to_le_bytes());
        eat(&self.height.to_le_bytes());
        for channel in &self.channels {
            eat(channel.name.as_bytes());
            eat(&[0]);
            for value in &channel.values {
                eat(&value.to_bits().to_le_bytes());
            }
        }
        hash
    }
}
