//! Pictures as files hold them: what has 8 bits keeps 8 bits.

/// Pixels for textures. How codes become light is the texture's to say
/// ([`Encoding`](super::Encoding)).
#[derive(Clone, Debug, PartialEq)]
pub struct Bitmap {
    width: u32,
    height: u32,
    channels: usize,
    texels: Texels,
}

/// (height, width, channel) values, row 0 on top.
#[derive(Clone, Debug, PartialEq)]
pub enum Texels {
    /// Codes, 255 stands for 1.
    Eight(Vec<u8>),
    /// Codes, 65535 stands for 1.
    Sixteen(Vec<u16>),
    /// Light itself.
    Float(Vec<f32>),
}

impl Texels {
    fn len(&self) -> usize {
        match self {
            Self::Eight(codes) => codes.len(),
            Self::Sixteen(codes) => codes.len(),
            Self::Float(values) => values.len(),
        }
    }

    /// Bytes that they take.
    fn bytes(&self) -> u64 {
        let each = match self {
            Self::Eight(_) => 1,
            Self::Sixteen(_) => 2,
            Self::Float(_) => 4,
        };
        self.len() as u64 * each
    }
}

impl Bitmap {
    /// A bitmap of 1 channel (grey), 2 (grey and opacity), 3 (red, green, blue) or 4 (these and
    /// opacity). `None` where `texels` are not `width * height * channels` in number, or none.
    pub fn new(width: u32, height: u32, channels: usize, texels: Texels) -> Option<Self> {
        let count = u64::from(width) * u64::from(height) * channels as u64;
        let fits = (1..=4).contains(&channels) && count > 0 && texels.len() as u64 == count;
        fits.then_some(Self { width, height, channels, texels })
    }

    /// One pixel of 8 bits, which stands for the same everywhere.
    pub fn solid(rgba: [u8; 4]) -> Self {
        Self { width: 1, height: 1, channels: 4, texels: Texels::Eight(rgba.to_vec()) }
    }

    /// Texels in a row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Values for each texel, 1 to 4.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// The values.
    pub fn texels(&self) -> &Texels {
        &self.texels
    }

    /// Whether it has a channel for opacity.
    pub fn has_alpha(&self) -> bool {
        self.channels.is_multiple_of(2)
    }

    /// Bytes that its texels take.
    pub fn bytes(&self) -> u64 {
        self.texels.bytes()
    }
}
