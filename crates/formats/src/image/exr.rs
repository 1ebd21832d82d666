//! OpenEXR: light in named channels.
//!
//! The first layer that holds flat pixels is read. The image is the display
//! window: what the data window leaves of it is 0, what it has beyond is left
//! out. If there are no channels `R`, `G`, `B` or `Y`, but some with a prefix
//! like `ViewLayer.Combined.R`, the first prefix is taken off. `R`, `G`, `B`
//! and `A` come first, in this order.
//!
//! Not read: deep data, DWAA and DWAB compression, subsampled channels.
//!
//! Source: *Technical Introduction to OpenEXR* and *OpenEXR File Layout*,
//! Academy Software Foundation.

use super::check;
use super::options::{Precision, WriteOptions};
use crate::limits::Limits;
use crate::shown::shown;
use ::exr::meta::BlockDescription;
use ::exr::meta::attribute::{AttributeValue, Text};
use ::exr::meta::header::{Header, standard_names};
use ::exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, IntegerBounds, Layer,
    LayerAttributes, LineOrder, ReadChannels, ReadLayers, WritableImage, f16,
};
use rutilant::image::{Channel, Image};
use std::io::Cursor;

/// Of the codes that OpenEXR has, deflate makes the most of a byte.
const EXPANSION: u64 = 1032;

/// Blocks of so many bytes may be declared by any file: few tiles, and few scan lines, are larger.
const LARGEST_FREE_BLOCK: u64 = 1 << 26;

/// Below so many pixels, threads cost more than they give.
const PARALLEL_FROM: u64 = 1 << 18;

pub(super) fn read(bytes: &[u8], limits: &Limits) -> Result<Image, String> {
    // Sizes first, before the decoder takes memory for them.
    let chunks = ::exr::block::read(Cursor::new(bytes), false).map_err(|e| plain(&e))?;
    for header in chunks.headers() {
        check_header(header, bytes.len(), limits)?;
    }
    let pixels = chunks.headers().iter().map(|h| h.layer_size.area() as u64).max();

    let reader = ::exr::image::read::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes();
    let reader = if pixels < Some(PARALLEL_FROM) { reader.non_parallel() } else { reader };
    let image = reader.from_chunks(chunks).map_err(|e| plain(&e))?;

    let layer = image.layer_data;
    let position = layer.attributes.layer_position;
    let data = IntegerBounds::new(position, layer.size);
    let channel_count = layer.channel_data.list.len();
    let frame = Frame::new(data, image.attributes.display_window, channel_count, limits)?;
    let mut channels: Vec<Channel> = Vec::new();
    for channel in layer.channel_data.list {
        let name = channel.name.to_string();
        if channels.iter().any(|c| c.name == name) {
            return Err(format!("two channels \"{}\"", shown(&name)));
        }
        let values = match channel.sample_data {
            FlatSamples::F32(values) => values,
            FlatSamples::F16(values) => values.iter().map(|v| v.to_f32()).collect(),
            FlatSamples::U32(values) => values.iter().map(|&v| v as f32).collect(),
        };
        channels.push(Channel { name, values: frame.place(values) });
    }
    take_off_prefix(&mut channels);
    channels.sort_by_cached_key(|c| order(&c.name));
    Image::new(frame.size.0, frame.size.1, channels)
        .ok_or_else(|| "the decoder gave another size than the header".to_owned())
}

fn check_header(header: &Header, bytes: usize, limits: &Limits) -> Result<(), String> {
    if header.deep {
        return Err("deep pixels are not read".to_owned());
    }
    let (width, height) = (header.layer_size.width() as u64, header.layer_size.height() as u64);
    let pixel_bytes = header.channels.list.iter().map(|c| c.sample_type.bytes_per_sample() as u64);
    let pixel_bytes: u64 = pixel_bytes.sum();
    check::size(width, height, limits, pixel_bytes, bytes, EXPANSION)?;
    // A block takes memory as soon as it states its size, which may be that of a whole one.
    let (columns, rows) = match header.blocks {
        BlockDescription::Tiles(tiles) => {
            (tiles.tile_size.width() as u64, tiles.tile_size.height() as u64)
        }
        BlockDescription::ScanLines => (width, header.compression.scan_lines_per_block() as u64),
    };
    let block = columns.saturating_mul(rows).saturating_mul(pixel_bytes);
    if block > (bytes as u64).saturating_mul(EXPANSION).saturating_add(LARGEST_FREE_BLOCK) {
        return Err(format!("blocks of {columns}x{rows} pixels are too large for {bytes} bytes"));
    }
    // Each block of pixels has at least an entry of 8 bytes in a table.
    let blocks = header.chunk_count as u64;
    if blocks.saturating_mul(8) > bytes as u64 {
        return Err(format!("{blocks} blocks are declared, but there are only {bytes} bytes"));
    }
    Ok(())
}

/// Where the pixels of the file stand in the image.
struct Frame {
    size: (u32, u32),
    /// Columns and rows of the file, and what is added to get those of the image.
    data_size: (usize, usize),
    offset: (i64, i64),
}

impl Frame {
    fn new(
        data: IntegerBounds,
        display: IntegerBounds,
        channels: usize,
        limits: &Limits,
    ) -> Result<Self, String> {
        let (width, height) = (display.size.width(), display.size.height());
        check::size(width as u64, height as u64, limits, 0, 0, 0)?;
        // A frame of black around the pixels is worth its memory, a universe of it is not. The
        // colours of a small window of a large picture are free.
        const MOST_BLACK: usize = 64;
        const FREE: usize = 1 << 25;
        let values = |pixels: usize| pixels.saturating_mul(channels);
        let most = values(data.size.area()).saturating_mul(MOST_BLACK).saturating_add(FREE);
        if values(width.saturating_mul(height)) > most {
            return Err(format!(
                "the display window of {width}x{height} is far larger than the {}x{} pixels in it",
                data.size.width(),
                data.size.height()
            ));
        }
        let offset = |of: fn(IntegerBounds) -> i32| i64::from(of(data)) - i64::from(of(display));
        Ok(Self {
            size: (width as u32, height as u32),
            data_size: (data.size.width(), data.size.height()),
            offset: (offset(|b| b.position.x()), offset(|b| b.position.y())),
        })
    }

    fn place(&self, values: Vec<f32>) -> Vec<f32> {
        let (width, height) = (self.size.0 as usize, self.size.1 as usize);
        if self.offset == (0, 0) && self.data_size == (width, height) {
            return values;
        }
        // The columns that image and file share: where they begin in each, and how many.
        let shared = |offset: i64, of_data: usize, of_image: usize| {
            let start = offset.max(0);
            let end = (offset + of_data as i64).min(of_image as i64);
            let count = usize::try_from(end - start).unwrap_or(0);
            let start_in_data = start - offset;
            (start as usize, start_in_data as usize, count)
        };
        let (x, data_x, columns) = shared(self.offset.0, self.data_size.0, width);
        let (y, data_y, rows) = shared(self.offset.1, self.data_size.1, height);
        let mut placed = vec![0.0; width * height];
        if columns > 0 {
            for row in 0..rows {
                let from = (data_y + row) * self.data_size.0 + data_x;
                let to = (y + row) * width + x;
                placed[to..to + columns].copy_from_slice(&values[from..from + columns]);
            }
        }
        placed
    }
}

/// Takes the first prefix `P.` off where there are `P.R`, `P.G` and `P.B`, but no colour without one.
fn take_off_prefix(channels: &mut [Channel]) {
    let has = |name: &str| channels.iter().any(|c| c.name == name);
    if has("R") || has("G") || has("B") || has("Y") {
        return;
    }
    let prefix = channels
        .iter()
        .filter_map(|c| c.name.strip_suffix('R').filter(|prefix| prefix.ends_with('.')))
        .find(|prefix| has(&format!("{prefix}G")) && has(&format!("{prefix}B")));
    let Some(prefix) = prefix.map(str::to_owned) else { return };
    for channel in channels {
        if let Some(name) = channel.name.strip_prefix(&prefix) {
            channel.name = name.to_owned();
        }
    }
}

/// Files keep channels by the alphabet; people think of red first.
fn order(name: &str) -> (String, usize, String) {
    let (layer, last) = name.rsplit_once('.').unwrap_or(("", name));
    let rank = ["R", "G", "B", "Y", "A"].iter().position(|&n| n == last).unwrap_or(usize::MAX);
    (layer.to_owned(), rank, last.to_owned())
}

pub(super) fn write(image: &Image, options: &WriteOptions) -> Result<Vec<u8>, String> {
    if image.channels().is_empty() {
        return Err("an image without channels cannot be written".to_owned());
    }
    let text = |text: &str| {
        Text::new_or_none(text)
            .ok_or_else(|| format!("\"{text}\" does not fit an EXR: Latin-1 only"))
    };
    let mut list = Vec::new();
    for channel in image.channels() {
        if channel.name.is_empty() || channel.name.len() > LONGEST_NAME {
            return Err(format!(
                "the channel name \"{}\" does not fit an EXR: 1 to {LONGEST_NAME} bytes",
                channel.name
            ));
        }
        list.push(AnyChannel::new(text(&channel.name)?, samples(channel, options.precision)));
    }
    let mut attributes = LayerAttributes {
        software_name: Some(text(&format!("Rutilant {}", env!("CARGO_PKG_VERSION")))?),
        ..LayerAttributes::default()
    };
    for (name, value) in &options.metadata {
        if name.is_empty() || name.len() > LONGEST_NAME || value.is_empty() {
            return Err(format!("the text \"{name}\" cannot be kept: empty, or its name too long"));
        }
        let key = text(name)?;
        if standard_names::ALL.contains(&name.as_bytes()) {
            return Err(format!("the text \"{name}\" cannot be kept: EXR uses that name itself"));
        }
        attributes.other.insert(key, AttributeValue::Text(text(value)?));
    }
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let size = (image.width() as usize, image.height() as usize);
    let layer = Layer::new(size, attributes, encoding, AnyChannels::sort(list.into()));
    let mut bytes = Cursor::new(Vec::new());
    ::exr::image::Image::from_layer(layer)
        .write()
        .to_buffered(&mut bytes)
        .map_err(|e| plain(&e))?;
    let mut bytes = bytes.into_inner();
    sort_attributes(&mut bytes);
    Ok(bytes)
}

/// A channel's values in the type that loses least of them for their room.
fn samples(channel: &Channel, precision: Precision) -> FlatSamples {
    let layer = channel.name.rsplit_once('.').map_or("", |(layer, _)| layer);
    // Halves would count to 2048 only. Whatever is no count stays as it is.
    let is_count = |v: &f32| *v >= 0.0 && *v < u32::MAX as f32 && v.fract() == 0.0;
    let counts = layer == "samples" || channel.name.ends_with(".id");
    if counts && channel.values.iter().all(is_count) {
        return FlatSamples::U32(channel.values.iter().map(|&v| v as u32).collect());
    }
    match precision {
        Precision::Half if !needs_floats(layer) => {
            FlatSamples::F16(channel.values.iter().map(|&v| half(v)).collect())
        }
        Precision::Half | Precision::Float => FlatSamples::F32(channel.values.clone()),
    }
}

/// Whether halves would spoil a layer: the variance of a clean pixel is less than the smallest half,
/// places have more than three digits, and ids are nothing but their bits.
fn needs_floats(layer: &str) -> bool {
    ["variance", "samples", "depth", "position", "uv", "object", "material"].contains(&layer)
        || layer.starts_with("Crypto")
}

/// Names of more bytes need a flag that old readers refuse.
const LONGEST_NAME: usize = 31;

/// The nearest half. What is finite stays finite.
fn half(value: f32) -> f16 {
    let value =
        if value.is_finite() { value.clamp(f16::MIN.to_f32(), f16::MAX.to_f32()) } else { value };
    f16::from_f32(value)
}

/// Brings the attributes of a file's only header into alphabetical order: the writer puts them
/// in a new order each time, and equal images shall give equal files.
fn sort_attributes(file: &mut [u8]) {
    // Magic number and version take 8 bytes.
    let Some(header) = file.get(8..) else { return };
    let mut attributes = Vec::new();
    let mut at = 0;
    let text_end = |from: usize| Some(from + header.get(from..)?.iter().position(|&b| b == 0)?);
    while header.get(at).is_some_and(|&byte| byte != 0) {
        // A name, a type, both ended by 0, the size of the value, the value.
        let attribute = || {
            let size_at = text_end(text_end(at)? + 1)? + 1;
            let size = i32::from_le_bytes(*header.get(size_at..)?.first_chunk()?);
            let end = size_at + 4 + usize::try_from(size).ok()?;
            header.get(at..end)
        };
        let Some(bytes) = attribute() else { return };
        attributes.push(bytes.to_vec());
        at += bytes.len();
    }
    attributes.sort();
    file[8..8 + at].copy_from_slice(&attributes.concat());
}

/// The decoder's words without its own frame around them.
fn plain(error: &::exr::error::Error) -> String {
    match error {
        ::exr::error::Error::Invalid(what) | ::exr::error::Error::NotSupported(what) => {
            match &**what {
                "file identifier missing" => "this is not an EXR file".to_owned(),
                "reference to missing bytes" => "the file ends early".to_owned(),
                what => what.to_owned(),
            }
        }
        other => other.to_string(),
    }
}
