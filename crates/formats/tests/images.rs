//! What is written is what is read, damage is refused, and a failed write leaves no trace.

mod common;

use common::{Random, cut_everywhere};
use rutilant::image::{Channel, Image};
use rutilant_formats::Limits;
use rutilant_formats::image::{
    Format, Pixels, Precision, WriteOptions, check_writable, read, read_bytes, write,
};
use std::fs;
use std::path::{Path, PathBuf};

/// Values that formats like to lose.
const HARD: [f32; 12] = [
    0.0,
    -0.0,
    1.0,
    -1.5,
    1e-45,
    1e-40,
    f32::MIN_POSITIVE,
    f32::MAX,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
    0.1,
];

fn image(width: u32, height: u32, names: &[&str], value: impl Fn(usize, usize) -> f32) -> Image {
    let count = (width * height) as usize;
    let channels = names.iter().enumerate().map(|(c, name)| Channel {
        name: (*name).to_owned(),
        values: (0..count).map(|i| value(c, i)).collect(),
    });
    Image::new(width, height, channels.collect()).expect("sizes fit")
}

fn hard_image(width: u32, height: u32, names: &[&str]) -> Image {
    image(width, height, names, |c, i| HARD[(i * 5 + c * 7) % HARD.len()])
}

/// The file that an image becomes, and the image that it becomes again.
fn round_trip(name: &str, pixels: Pixels<'_>, options: &WriteOptions) -> (Vec<u8>, Image) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(name);
    write(&path, pixels, options).expect("written");
    let bytes = fs::read(&path).expect("there");
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1, "nothing else is left");
    (bytes, read(&path, &Limits::default()).expect("read"))
}

fn bits(image: &Image) -> Vec<(String, Vec<u32>)> {
    let bits = |c: &Channel| c.values.iter().map(|v| v.to_bits()).collect();
    image.channels().iter().map(|c| (c.name.clone(), bits(c))).collect()
}

fn refusal(name: &str, bytes: &[u8]) -> String {
    refusal_within(name, bytes, &Limits::default())
}

fn refusal_within(name: &str, bytes: &[u8], limits: &Limits) -> String {
    match read_bytes(bytes, Path::new(name), limits) {
        Ok(image) => panic!("{name} was read: {}x{}", image.width(), image.height()),
        Err(error) => error.to_string(),
    }
}

/// EXR as float keeps every bit of every channel: NaN, infinities, −0, subnormals.
#[test]
fn exr_float_keeps_every_bit() {
    let names = ["R", "G", "B", "A", "albedo.R", "albedo.G", "albedo.B", "depth.Z", "variance.Y"];
    for (width, height) in [(1, 1), (7, 5), (33, 40), (600, 500)] {
        let original = hard_image(width, height, &names);
        let (_, back) = round_trip("a.exr", Pixels::Light(&original), &WriteOptions::default());
        assert_eq!((back.width(), back.height()), (width, height));
        assert_eq!(bits(&back), bits(&original), "order and bits of all channels");
        assert_eq!(back.hash(), original.hash());
    }
}

/// EXR as half rounds to the nearest half; finite values stay finite.
#[test]
fn exr_half_rounds_to_nearest() {
    let values = [0.1, 65504.0, 65520.0, 1e30, -1e30, f32::INFINITY, 6e-8, 1.0 + 1.0 / 4096.0];
    let expected =
        [0.099_975_586, 65504.0, 65504.0, 65504.0, -65504.0, f32::INFINITY, 5.960_464_5e-8, 1.0];
    let original = image(8, 1, &["R", "G", "B"], |_, i| values[i]);
    let options = WriteOptions { precision: Precision::Half, ..WriteOptions::default() };
    let (half_file, back) = round_trip("a.exr", Pixels::Light(&original), &options);
    assert_eq!(back.channel("G").expect("G"), expected);
    let (float_file, _) = round_trip("a.exr", Pixels::Light(&original), &WriteOptions::default());
    assert!(half_file.len() < float_file.len());
}

/// Equal images give equal files, and texts are found in them by their names.
#[test]
fn exr_files_are_the_same_each_time() {
    let metadata = ["spp", "seed", "time", "integrator", "scene", "sampler"]
        .map(|name| (name.to_owned(), format!("value of {name}")));
    let options = WriteOptions { metadata: metadata.to_vec(), ..WriteOptions::default() };
    let original = hard_image(5, 4, &["R", "G", "B"]);
    let (first, _) = round_trip("a.exr", Pixels::Light(&original), &options);
    for _ in 0..4 {
        let (again, back) = round_trip("a.exr", Pixels::Light(&original), &options);
        assert!(again == first, "the same bytes");
        assert_eq!(bits(&back), bits(&original));
    }
    let holds = |text: &str| first.windows(text.len()).any(|w| w == text.as_bytes());
    for text in ["software\0string\0", "Rutilant 0.", "spp\0string\0", "value of sampler"] {
        assert!(holds(text), "{text} is in the file");
    }
}

/// A data window that is not the display window: its pixels stand where they belong, the rest is
/// black. Negative corners are usual where a renderer draws beyond the frame.
#[test]
fn exr_data_windows_stand_in_their_display_window() {
    use exr::prelude::*;
    let file = |position: (i32, i32), display: (i32, i32, usize, usize)| {
        let values: Vec<f32> = (1..=6).map(|v| v as f32).collect();
        let channel = AnyChannel::new("Y", FlatSamples::F32(values));
        let channels = AnyChannels::sort(vec![channel].into());
        let attributes = LayerAttributes::default().with_position(Vec2(position.0, position.1));
        let layer = Layer::new((3, 2), attributes, Encoding::UNCOMPRESSED, channels);
        let mut image = exr::image::Image::from_layer(layer);
        image.attributes.display_window =
            IntegerBounds::new((display.0, display.1), (display.2, display.3));
        let mut bytes = std::io::Cursor::new(Vec::new());
        image.write().to_buffered(&mut bytes).expect("written");
        bytes.into_inner()
    };
    let values = |bytes: &[u8]| {
        let image = read_bytes(bytes, Path::new("a.exr"), &Limits::default()).expect("read");
        (image.width(), image.height(), image.channel("Y").expect("Y").to_vec())
    };
    let inside = values(&file((1, 1), (0, 0, 4, 3)));
    assert_eq!(inside, (4, 3, vec![0., 0., 0., 0., 0., 1., 2., 3., 0., 4., 5., 6.]));
    let beyond = values(&file((-1, -1), (0, 0, 2, 2)));
    assert_eq!(beyond, (2, 2, vec![5., 6., 0., 0.]));
    let moved = values(&file((-7, 9), (-7, 9, 3, 2)));
    assert_eq!(moved, (3, 2, vec![1., 2., 3., 4., 5., 6.]));
    let elsewhere = values(&file((100, 100), (0, 0, 2, 1)));
    assert_eq!(elsewhere, (2, 1, vec![0., 0.]));
    let universe = refusal("a.exr", &file((0, 0), (-1_000_000, 0, 10_000_000, 20)));
    assert_eq!(
        universe,
        "a.exr: the display window of 10000000x20 is far larger than the 3x2 pixels in it"
    );
}

/// Half and uint channels become float, and a lone layer's prefix is taken off.
#[test]
fn exr_layers_and_types_are_understood() {
    use exr::prelude::*;
    let channels = AnyChannels::sort(
        vec![
            AnyChannel::new("view.R", FlatSamples::F16(vec![f16::from_f32(0.5); 4])),
            AnyChannel::new("view.G", FlatSamples::F32(vec![0.25; 4])),
            AnyChannel::new("view.B", FlatSamples::U32(vec![7; 4])),
            AnyChannel::new("other.Z", FlatSamples::F32(vec![9.0; 4])),
        ]
        .into(),
    );
    let layer = Layer::new((2, 2), LayerAttributes::default(), Encoding::FAST_LOSSLESS, channels);
    let mut bytes = std::io::Cursor::new(Vec::new());
    exr::image::Image::from_layer(layer).write().to_buffered(&mut bytes).expect("written");
    let image = read_bytes(bytes.get_ref(), Path::new("a.exr"), &Limits::default()).expect("read");
    assert_eq!(image.rgb().expect("colours"), vec![[0.5, 0.25, 7.0]; 4]);
    assert_eq!(image.channel("other.Z"), Some(&[9.0; 4][..]));
}

/// PFM keeps every bit, of colours and of greys, and its rows are not upside down.
#[test]
fn pfm_keeps_every_bit() {
    for names in [&["R", "G", "B"][..], &["Y"]] {
        let original = hard_image(9, 4, names);
        let (_, back) = round_trip("a.pfm", Pixels::Light(&original), &WriteOptions::default());
        assert_eq!(bits(&back), bits(&original));
    }
    let mut big_endian = b"Pf 1 2 1.0\n".to_vec();
    big_endian.extend([2.0_f32, 1.0].iter().flat_map(|v| v.to_be_bytes()));
    let image = read_bytes(&big_endian, Path::new("a.pfm"), &Limits::default()).expect("read");
    assert_eq!(image.channel("Y"), Some(&[1.0, 2.0][..]));
}

/// RGBE keeps every channel to within 1/256 of the pixel's largest, over its whole range, for
/// widths with and without run-length code. What it cannot hold becomes 0 or the largest.
#[test]
fn hdr_keeps_a_part_in_256() {
    let mut random = Random(3);
    for width in [1, 7, 8, 40, 300] {
        let values: Vec<[f32; 3]> = (0..width * 6)
            .map(|i| {
                let size = 2.0_f32.powi((random.below(240) as i32) - 120);
                let flat = i % 20 < 11;
                [0; 3].map(|_| if flat { 0.3 } else { size * random.unit() })
            })
            .collect();
        let original = image(width, 6, &["R", "G", "B"], |c, i| values[i][c]);
        let (_, back) = round_trip("a.hdr", Pixels::Light(&original), &WriteOptions::default());
        for (before, after) in values.iter().zip(back.rgb().expect("colours")) {
            let largest = before.iter().copied().fold(0.0, f32::max);
            for (b, a) in before.iter().zip(after) {
                assert!((b - a).abs() <= largest / 256.0, "{before:?} came back as {after:?}");
            }
        }
        // What has been through RGBE once goes through unchanged.
        let (_, again) = round_trip("a.hdr", Pixels::Light(&back), &WriteOptions::default());
        assert_eq!(bits(&again), bits(&back));
    }
    let hard = image(8, 1, &["R", "G", "B"], |_, i| {
        [f32::NAN, -1.0, 0.0, f32::INFINITY, f32::MAX, 1e-45, 1e-39, 255.999][i]
    });
    let (_, back) = round_trip("a.hdr", Pixels::Light(&hard), &WriteOptions::default());
    let largest = 255.0 * 2.0_f32.powi(119);
    assert_eq!(back.channel("R").expect("R"), [0.0, 0.0, 0.0, largest, largest, 0.0, 0.0, 256.0]);
}

/// All eight ways in which scanlines can lie, and both run-length codes.
#[test]
fn hdr_orientations_and_codes() {
    // Pixels a b c over d e f, by brightness; each string is the order in the file.
    let orders = [
        ("-Y 2 +X 3", "abcdef"),
        ("-Y 2 -X 3", "cbafed"),
        ("+Y 2 +X 3", "defabc"),
        ("+Y 2 -X 3", "fedcba"),
        ("+X 3 -Y 2", "adbecf"),
        ("+X 3 +Y 2", "daebfc"),
        ("-X 3 -Y 2", "cfbead"),
        ("-X 3 +Y 2", "fcebda"),
    ];
    for (resolution, order) in orders {
        let mut bytes = format!("#?RADIANCE\n\n{resolution}\n").into_bytes();
        bytes.extend(order.bytes().flat_map(|letter| [letter, letter, letter, 136]));
        let image = read_bytes(&bytes, Path::new("a.hdr"), &Limits::default()).expect("read");
        assert_eq!((image.width(), image.height()), (3, 2), "{resolution}");
        let expected: Vec<f32> = b"abcdef".iter().map(|&letter| letter.into()).collect();
        assert_eq!(image.channel("R").expect("R"), expected, "{resolution}");
    }

    let mut old = b"#?RGBE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 300\n".to_vec();
    // A pixel, repeated 42 times, then 1 times 256 more; then another.
    old.extend([5, 6, 7, 136, 1, 1, 1, 42, 1, 1, 1, 1, 9, 9, 9, 136]);
    let image = read_bytes(&old, Path::new("a.hdr"), &Limits::default()).expect("read");
    let green = image.channel("G").expect("G");
    assert!(green[..299].iter().all(|&g| g == 6.0) && green[299] == 9.0);
}

/// PNG keeps every code exactly: written codes, decoded by the sRGB curve, are the same codes
/// when encoded again by an independent formula.
#[test]
fn png_codes_are_exact() {
    let codes: Vec<u8> = (0..=255_u8).flat_map(|i| [i, 255 - i, i.wrapping_mul(7)]).collect();
    let pixels = Pixels::Display { width: 16, height: 16, rgb8: &codes };
    let (_, back) = round_trip("a.png", pixels, &WriteOptions::default());
    let encode = |v: f32| {
        let v = f64::from(v);
        let code = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
        (code * 255.0).round() as u8
    };
    let again: Vec<u8> = back.rgb().expect("colours").iter().flat_map(|p| p.map(encode)).collect();
    assert_eq!(again, codes);
    let red = back.channel("R").expect("R");
    assert_eq!((red[0], red[255]), (0.0, 1.0));
    assert!(red.is_sorted());
}

/// All 65536 codes, in all channels: a byte order exchanged, or a step over 8 bits, loses some.
#[test]
fn png_16_bit_codes_are_exact() {
    let codes: Vec<u16> = (0..256 * 256 * 3_u32).map(|i| (i / 3) as u16).collect();
    let pixels = Pixels::Display16 { width: 256, height: 256, rgb16: &codes };
    let (bytes, back) = round_trip("a.png", pixels, &WriteOptions::default());
    assert_eq!(bytes[24..26], [16, 2], "16 bits, red, green and blue");
    let light = |code: usize| rutilant::display::linear_from_srgb(code as f64 / 65535.0) as f32;
    for name in ["R", "G", "B"] {
        for (code, value) in back.channel(name).expect(name).iter().enumerate() {
            assert_eq!(value.to_bits(), light(code).to_bits(), "{name} {code}");
        }
    }
}

/// Halves count to 2048 and end at 65504, and the variance of a clean pixel is less than the
/// smallest of them: both are kept in 32 bits, whatever the colours are stored in.
#[test]
fn exr_keeps_counts_and_variances_in_full() {
    let names = ["R", "G", "B", "variance.R", "variance.G", "variance.B", "samples.Y"];
    let value = |c: usize, i: usize| match c {
        0..3 => 0.5,
        3..6 => 1e-9 * (i + 1) as f32,
        _ => (1 << 24) as f32 - i as f32,
    };
    let original = image(5, 3, &names, value);
    let options = WriteOptions { precision: Precision::Half, ..WriteOptions::default() };
    for options in [options, WriteOptions::default()] {
        let (bytes, back) = round_trip("a.exr", Pixels::Light(&original), &options);
        for name in &names[..] {
            assert_eq!(back.channel(name), original.channel(name), "{name}");
        }
        // A channel's entry is its name, 0, and its type: 0 for uint, 1 for half, 2 for float.
        let kind = |name: &[u8]| {
            let at = bytes.windows(name.len()).position(|w| w == name).expect("a channel");
            bytes[at + name.len()]
        };
        assert_eq!((kind(b"samples.Y\0"), kind(b"variance.R\0")), (0, 2));
    }
    // What is no count is no less safe.
    let strange = image(4, 1, &["samples.Y"], |_, i| [0.5, -1.0, f32::NAN, f32::INFINITY][i]);
    let (_, back) = round_trip("a.exr", Pixels::Light(&strange), &WriteOptions::default());
    assert_eq!(bits(&back), bits(&strange));
}

/// Layers keep their names, and each the type that it needs, whatever the colours are stored in: ids
/// count, the bits of mattes are hashes, and places have more than three digits.
#[test]
fn exr_layers_have_the_types_they_need() {
    const UINT: u8 = 0;
    const HALF: u8 = 1;
    const FLOAT: u8 = 2;
    let layers = [
        ("R", HALF),
        ("albedo.R", HALF),
        ("normal.X", HALF),
        ("emission.R", HALF),
        ("direct.R", HALF),
        ("indirect.R", HALF),
        ("Combined_12345678901234567890.R", HALF),
        ("depth.Z", FLOAT),
        ("position.X", FLOAT),
        ("uv.U", FLOAT),
        ("variance.R", FLOAT),
        ("CryptoObject00.R", FLOAT),
        ("CryptoMaterial12.A", FLOAT),
        ("CryptoAsset00.G", FLOAT),
        ("object.id", UINT),
        ("material.id", UINT),
        ("samples.Y", UINT),
    ];
    let names = layers.map(|(name, _)| name);
    let value = |c: usize, i: usize| match layers[c].1 {
        // A million and one is no half, and neither is the float whose bits are an id.
        UINT => 1_000_001.0 + i as f32,
        FLOAT => f32::from_bits(0x3ae3_9a51 + i as u32),
        _ => 0.25 * i as f32,
    };
    let original = image(3, 2, &names, value);
    let half = WriteOptions { precision: Precision::Half, ..WriteOptions::default() };
    for (options, colors) in [(half, HALF), (WriteOptions::default(), FLOAT)] {
        let (bytes, back) = round_trip("a.exr", Pixels::Light(&original), &options);
        for (name, kind) in layers {
            assert_eq!(back.channel(name), original.channel(name), "{name}");
            let entry = [b"\0", name.as_bytes(), b"\0"].concat();
            let at = bytes.windows(entry.len()).position(|w| w == entry).expect("a channel");
            let expected = if kind == HALF { colors } else { kind };
            assert_eq!(bytes[at + entry.len()], expected, "{name}");
        }
    }
    // A name that old readers could not take is refused.
    let long = image(1, 1, &["a_layer_of_more_than_thirty.red2"], |_, _| 0.0);
    let error = write(Path::new("a.exr"), Pixels::Light(&long), &WriteOptions::default());
    assert!(error.is_err());
}

/// Greys, palettes, alpha and 16 bits. Alpha is not encoded, so it is not decoded.
#[test]
fn png_kinds_are_understood() {
    use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
    let png = |samples: &[u8], color| {
        let mut bytes = Vec::new();
        PngEncoder::new(&mut bytes).write_image(samples, 2, 1, color).expect("encoded");
        read_bytes(&bytes, Path::new("a.png"), &Limits::default()).expect("read")
    };
    let grey = png(&[0, 255], ExtendedColorType::L8);
    assert_eq!(grey.rgb().expect("colours"), [[0.0; 3], [1.0; 3]]);
    let alpha = png(&[188, 188, 0, 51, 0, 0, 0, 255], ExtendedColorType::Rgba8);
    assert_eq!(alpha.channel("A"), Some(&[0.2, 1.0][..]));
    let red = alpha.channel("R").expect("R")[0];
    assert!((red - 0.502_886_5).abs() < 1e-6, "sRGB 188 is {red}");
    let words: Vec<u8> =
        [0_u16, 65535, 48316, 32768, 1, 2].iter().flat_map(|w| w.to_ne_bytes()).collect();
    let deep = png(&words, ExtendedColorType::Rgb16);
    assert_eq!(deep.channel("G").expect("G")[0], 1.0);
    let blue = deep.channel("B").expect("B")[0];
    assert!((blue - 0.502_886_5).abs() < 1e-5, "sRGB 48316/65535 is {blue}");
}

/// JPEG comes back as nearly the same picture.
#[test]
fn jpeg_is_nearly_the_same() {
    let codes: Vec<u8> = (0..64 * 48).flat_map(|i| [i as u8 % 64 + 90, 128, 200]).collect();
    let pixels = Pixels::Display { width: 64, height: 48, rgb8: &codes };
    let (_, back) = round_trip("a.jpg", pixels, &WriteOptions::default());
    assert_eq!((back.width(), back.height()), (64, 48));
    let green = back.channel("G").expect("G");
    let mean = green.iter().sum::<f32>() / green.len() as f32;
    assert!((mean - 0.215_86).abs() < 0.01, "sRGB 128 is 0.216, the mean is {mean}");
}

/// The bytes say what a file is, even if its name does not.
#[test]
fn content_goes_before_extension() {
    let original = hard_image(3, 2, &["R", "G", "B"]);
    let (bytes, _) = round_trip("a.pfm", Pixels::Light(&original), &WriteOptions::default());
    let image = read_bytes(&bytes, Path::new("a.png"), &Limits::default()).expect("read");
    assert_eq!(bits(&image), bits(&original));
}

/// One clear line for each way in which a file can be wrong.
#[test]
fn errors_say_what_is_wrong() {
    let cases: [(&str, &[u8], &str); 18] = [
        (
            "a.bmp",
            b"BM",
            "a.bmp: no image format .bmp; there are .exr, .hdr, .pfm, .png, .jpg, .webp, .tga",
        ),
        (
            "sky",
            b"",
            "sky: no extension, so no image format; there are .exr, .hdr, .pfm, .png, .jpg, .webp, .tga",
        ),
        ("a.hdr", b"", "a.hdr: the header has no end"),
        ("a.hdr", b"hello\n", "a.hdr: this is not a Radiance file: it does not begin with \"#?\""),
        (
            "a.hdr",
            b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n",
            "a.hdr: pixels in format \"32-bit_rle_xyze\" are not read, only 32-bit_rle_rgbe",
        ),
        (
            "a.hdr",
            b"#?RADIANCE\n\n-Y 5\n",
            "a.hdr: \"-Y 5\" is not a resolution like \"-Y 512 +X 1024\"",
        ),
        ("a.hdr", b"#?RADIANCE\n\n-Y 0 +X 1\n", "a.hdr: the image has 1x0 pixels"),
        (
            "a.hdr",
            b"#?RADIANCE\n\n-Y 2 +X 1\n\x01\x02\x03\x04",
            "a.hdr: the file ends after 1 of 2 scanlines",
        ),
        (
            "a.hdr",
            b"#?RADIANCE\n\n-Y 1 +X 9\n\x02\x02\x00\x08\x81\x81\x81\x81",
            "a.hdr: scanline 0 of 1 is not coded rightly",
        ),
        ("a.pfm", b"PF\n2 x\n", "a.pfm: \"x\" is not a height"),
        ("a.pfm", b"PF\n2 2\n0\n", "a.pfm: \"0\" is not a scale"),
        ("a.pfm", b"PF 2", "a.pfm: the header has no height"),
        ("a.pfm", b"P5 2 2 1\n", "a.pfm: this is not a PFM file: it begins with neither PF nor Pf"),
        ("a.pfm", b"Pf 1 2 -1\nabcdefg", "a.pfm: the file ends after 1 of 2 rows"),
        (
            "a.pfm",
            b"PF 60000 60000 -1\n",
            "a.pfm: 60000x60000 are 3600000000 pixels, but at most 268435456 are allowed; allow more with --limit pixels=N",
        ),
        ("a.png", b"\x89PNG\r\n\x1a\n", "a.png: the file ends in its header"),
        ("a.jpg", b"\xff\xd8\xff\xe0", "a.jpg: the file ends before its picture does"),
        ("a.exr", b"hello", "a.exr: this is not an EXR file"),
    ];
    for (name, bytes, expected) in cases {
        assert_eq!(refusal(name, bytes), expected);
    }
    let missing = read(Path::new("no/such/sky.hdr"), &Limits::default()).expect_err("missing");
    assert!(missing.to_string().starts_with("no/such/sky.hdr: No such file"), "{missing}");
    let folder = tempfile::tempdir().expect("a folder");
    let error = read(folder.path(), &Limits::default()).expect_err("a folder");
    assert!(error.to_string().ends_with(": this is a folder, not a file"), "{error}");
}

/// Headers that promise more than the file holds are refused before memory is taken, even by a
/// caller who allows everything. Were it taken, these would need terabytes.
#[test]
fn lying_headers_take_no_memory() {
    let all = Limits { file_bytes: u64::MAX, pixels: u64::MAX, ..Limits::default() };
    let codes = [50; 12];
    let small = Pixels::Display { width: 2, height: 2, rgb8: &codes };
    let light = image(2, 2, &["R", "G", "B"], |_, i| i as f32);

    let (mut png, _) = round_trip("a.png", small, &WriteOptions::default());
    png[16..24].copy_from_slice(&[0x00, 0x10, 0, 0, 0x00, 0x10, 0, 0]);
    let count = png.len();
    assert_eq!(
        refusal_within("a.png", &png, &all),
        format!("a.png: 1048576x1048576 pixels are declared, but only {count} bytes follow")
    );

    let (mut jpeg, _) = round_trip("a.jpg", small, &WriteOptions::default());
    let frame = jpeg.windows(2).position(|w| w == [0xff, 0xc0]).expect("a frame header");
    jpeg[frame + 5..frame + 9].fill(0xff);
    assert!(refusal_within("a.jpg", &jpeg, &all).contains("65535x65535 pixels are declared"));

    // The data window is four numbers after its name, type and length.
    let (mut exr, _) = round_trip("a.exr", Pixels::Light(&light), &WriteOptions::default());
    for window in [&b"dataWindow\0box2i\0"[..], b"displayWindow\0box2i\0"] {
        let at = exr.windows(window.len()).position(|w| w == window).expect("a window");
        let corner = at + window.len() + 4 + 8;
        exr[corner..corner + 4].copy_from_slice(&1_000_000_i32.to_le_bytes());
        exr[corner + 4..corner + 8].copy_from_slice(&1_000_000_i32.to_le_bytes());
    }
    assert_eq!(refusal_within("a.exr", &exr, &all), "a.exr: chunk count not matching data size");
    let count = exr.windows(15).position(|w| w == b"chunkCount\0int\0").expect("a count") + 19;
    exr[count..count + 4].copy_from_slice(&62_501_i32.to_le_bytes());
    let refused = refusal_within("a.exr", &exr, &all);
    assert!(refused.contains("1000001x1000001 pixels are declared"), "{refused}");

    for (header, expected) in [
        (
            "#?RADIANCE\n\n-Y 4000000000 +X 4000000000\n",
            "4000000000x4000000000 pixels are declared, but only 8 bytes follow",
        ),
        ("PF 4000000000 4000000000 -1\n", "the file ends after 0 of 4000000000 rows"),
    ] {
        let mut bytes = header.as_bytes().to_vec();
        bytes.extend([2, 2, 127, 255, 1, 2, 3, 4]);
        assert_eq!(refusal_within("a.hdr", &bytes, &all), format!("a.hdr: {expected}"));
    }

    let tight = Limits { pixels: 3, ..Limits::default() };
    let (whole, _) = round_trip("a.png", small, &WriteOptions::default());
    assert_eq!(
        refusal_within("a.png", &whole, &tight),
        "a.png: 2x2 are 4 pixels, but at most 3 are allowed; allow more with --limit pixels=N"
    );
}

/// Files that are whole, and tiny, and ask for very much: a display window around a pixel with
/// many channels, and runs of runs. Each is held against the bytes that are there.
#[test]
fn bombs_are_held_against_their_bytes() {
    use exr::prelude::*;
    // 200 channels of one pixel, in a display window of a million: 800 MB of black.
    let list = (0..200).map(|i| AnyChannel::new(&*format!("c{i}"), FlatSamples::F32(vec![1.0])));
    let channels = AnyChannels::sort(list.collect());
    let layer = Layer::new((1, 1), LayerAttributes::default(), Encoding::UNCOMPRESSED, channels);
    let mut image = exr::image::Image::from_layer(layer);
    image.attributes.display_window = IntegerBounds::new((0, 0), (1000, 1000));
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).expect("written");
    assert_eq!(
        refusal("a.exr", bytes.get_ref()),
        "a.exr: the display window of 1000x1000 is far larger than the 1x1 pixels in it"
    );
    // One pixel, and runs of 255 times 256 times more of it.
    let mut hdr = b"#?RADIANCE\n\n-Y 10000 +X 16711936\n".to_vec();
    hdr.extend([9, 9, 9, 130, 1, 1, 1, 255, 1, 1, 1, 255, 1, 1, 1, 254]);
    let all = Limits { pixels: u64::MAX, ..Limits::default() };
    assert_eq!(
        refusal_within("a.hdr", &hdr, &all),
        "a.hdr: 16711936x10000 pixels are declared, but only 16 bytes follow"
    );
}

/// A small EXR file with halves, floats and uints in a given code.
fn coded_exr(encoding: exr::prelude::Encoding) -> Vec<u8> {
    use exr::prelude::*;
    let channels = AnyChannels::sort(
        vec![
            AnyChannel::new("R", FlatSamples::F16((0..70_u8).map(f16::from).collect())),
            AnyChannel::new("G", FlatSamples::F32((0..70).map(|i| i as f32).collect())),
            AnyChannel::new("B", FlatSamples::U32((0..70).collect())),
        ]
        .into(),
    );
    let layer = Layer::new((10, 7), LayerAttributes::default(), encoding, channels);
    let mut bytes = std::io::Cursor::new(Vec::new());
    exr::image::Image::from_layer(layer).write().to_buffered(&mut bytes).expect("written");
    bytes.into_inner()
}

/// Small files of every format and of several kinds of code.
fn samples() -> Vec<(&'static str, Vec<u8>)> {
    let options = WriteOptions {
        metadata: vec![("spp".to_owned(), "64".to_owned())],
        ..WriteOptions::default()
    };
    let codes: Vec<u8> = (0..9 * 6 * 3).map(|i| (i * 5) as u8).collect();
    let display = Pixels::Display { width: 9, height: 6, rgb8: &codes };
    let light = image(9, 6, &["R", "G", "B"], |c, i| (i / 4 * 3 + c) as f32 * 0.1);
    let mut old_hdr = b"#?RGBE\n\n-Y 1 +X 50\n".to_vec();
    old_hdr.extend([5, 6, 7, 136, 1, 1, 1, 48, 9, 9, 9, 136]);
    let mut samples = vec![("old.hdr", old_hdr)];
    for name in ["a.exr", "a.hdr", "a.pfm"] {
        samples.push((name, round_trip(name, Pixels::Light(&light), &options).0));
    }
    for (name, encoding) in [
        ("piz.exr", exr::prelude::Encoding::SMALL_LOSSLESS),
        ("tiles.exr", exr::prelude::Encoding::FAST_LOSSLESS),
        ("plain.exr", exr::prelude::Encoding::UNCOMPRESSED),
    ] {
        samples.push((name, coded_exr(encoding)));
    }
    for name in ["a.png", "a.jpg"] {
        samples.push((name, round_trip(name, display, &options).0));
    }
    samples
}

/// A file cut short anywhere is refused, and never a panic.
#[test]
fn files_cut_short_are_refused() {
    for (name, bytes) in samples() {
        cut_everywhere(&bytes, |cut| {
            let result = read_bytes(cut, Path::new(name), &Limits::default());
            // The checksum behind the pixels, and the last chunk of a PNG, are not missed.
            let spare = if name == "a.png" { 16 } else { 0 };
            assert!(
                result.is_err() || cut.len() + spare >= bytes.len(),
                "{name} was read from {} of {} bytes",
                cut.len(),
                bytes.len()
            );
        });
    }
}

/// A failed write leaves what was there, and nothing else.
#[test]
fn a_failed_write_changes_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| -> PathBuf { folder.path().join(name) };
    let light = image(2, 2, &["R", "G", "B"], |_, _| 1.0);
    let no_color = image(2, 2, &["Z"], |_, _| 1.0);
    let codes = [50; 12];
    let display = Pixels::Display { width: 2, height: 2, rgb8: &codes };
    let short = Pixels::Display { width: 2, height: 3, rgb8: &codes };
    let words = [50; 12];
    let display_16 = Pixels::Display16 { width: 2, height: 2, rgb16: &words };
    let short_16 = Pixels::Display16 { width: 3, height: 2, rgb16: &words };
    for name in ["old.png", "old.exr", "old.hdr", "old.txt"] {
        fs::write(at(name), "old").expect("written");
    }
    fs::create_dir(at("folder.exr")).expect("made");

    let options = WriteOptions::default();
    let reserved = WriteOptions {
        metadata: vec![("channels".to_owned(), "x".to_owned())],
        ..WriteOptions::default()
    };
    let cases = [
        (
            "old.png",
            Pixels::Light(&light),
            &options,
            ".png holds colours for a display, but these pixels are light: encode them first, or write .exr",
        ),
        (
            "old.exr",
            display,
            &options,
            ".exr holds light, but these pixels are encoded for a display: write .png, or give the light itself",
        ),
        ("old.png", short, &options, "12 bytes are not 3 for each of 2x3 pixels"),
        ("old.png", short_16, &options, "12 words are not 3 for each of 3x2 pixels"),
        (
            "old.jpg",
            display_16,
            &options,
            ".jpg holds 8 bits a colour, but these pixels have 16: write .png",
        ),
        (
            "old.hdr",
            Pixels::Light(&no_color),
            &options,
            "the image has no channels R, G and B, nor Y",
        ),
        (
            "old.exr",
            Pixels::Light(&light),
            &reserved,
            "the text \"channels\" cannot be kept: EXR uses that name itself",
        ),
        (
            "old.txt",
            Pixels::Light(&light),
            &options,
            "no image format .txt; there are .exr, .hdr, .pfm, .png, .jpg",
        ),
        (
            "folder.exr",
            Pixels::Light(&light),
            &options,
            "cannot write: this is a folder, not a file",
        ),
    ];
    for (name, pixels, options, expected) in cases {
        let error = write(&at(name), pixels, options).expect_err(name);
        assert_eq!(error.to_string(), format!("{}: {expected}", at(name).display()));
    }
    let missing = at("missing/a.exr");
    let error = write(&missing, &light, &options).expect_err("no folder");
    let expected = format!(
        "{}: cannot write: there is no folder {}",
        missing.display(),
        at("missing").display()
    );
    assert_eq!(error.to_string(), expected);

    for name in ["old.png", "old.exr", "old.hdr", "old.txt"] {
        assert_eq!(fs::read(at(name)).expect("there"), b"old", "{name}");
    }
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 5, "no leftovers");
}

/// What cannot be written is known before the work, and asking leaves no trace.
#[test]
fn writability_is_known_before() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| -> PathBuf { folder.path().join(name) };
    fs::write(at("old.exr"), "old").expect("written");
    fs::write(at("kept.exr"), "kept").expect("written");
    let mut permissions = fs::metadata(at("kept.exr")).expect("there").permissions();
    permissions.set_readonly(true);
    fs::set_permissions(at("kept.exr"), permissions).expect("set");
    fs::create_dir(at("folder.png")).expect("made");

    for name in ["new.exr", "new.JPG", "old.exr"] {
        check_writable(&at(name)).unwrap_or_else(|e| panic!("{e}"));
    }
    for (name, expected) in [
        ("kept.exr", "cannot write: the file is read-only"),
        ("folder.png", "cannot write: this is a folder, not a file"),
        ("a.gif", "no image format .gif; there are .exr, .hdr, .pfm, .png, .jpg"),
        ("missing/a.png", "cannot write: there is no folder"),
    ] {
        let error = check_writable(&at(name)).expect_err(name).to_string();
        assert!(error.contains(expected), "{error}");
    }
    assert_eq!(fs::read(at("old.exr")).expect("there"), b"old");
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 3, "no leftovers");
    assert!(Format::from_path(Path::new("a.png")).is_ok_and(Format::is_for_display));
    assert!(Format::from_path(Path::new("a.exr")).is_ok_and(|f| !f.is_for_display()));
}

/// A written file has the rights of any new file, or those of the file it replaces; a symbolic
/// link stays one. A folder that takes no files is refused (root may write everywhere, so for
/// root nothing is seen).
#[cfg(unix)]
#[test]
fn rights_and_links_survive() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| -> PathBuf { folder.path().join(name) };
    let mode = |name: &str| fs::metadata(at(name)).expect("there").permissions().mode() & 0o777;
    let light = image(2, 2, &["R", "G", "B"], |_, _| 1.0);
    let options = WriteOptions::default();

    fs::write(at("plain"), "").expect("written");
    write(&at("new.exr"), &light, &options).expect("written");
    assert_eq!(mode("new.exr"), mode("plain"));
    fs::set_permissions(at("new.exr"), fs::Permissions::from_mode(0o640)).expect("set");
    symlink(at("new.exr"), at("link.exr")).expect("linked");
    write(&at("link.exr"), &light, &options).expect("written");
    assert_eq!(mode("new.exr"), 0o640);
    assert!(fs::symlink_metadata(at("link.exr")).expect("there").is_symlink());
    // Also where it leads to nothing: then nothing is written.
    symlink(at("gone.exr"), at("dangling.exr")).expect("linked");
    assert!(check_writable(&at("dangling.exr")).is_err());
    assert!(write(&at("dangling.exr"), &light, &options).is_err());
    assert!(fs::symlink_metadata(at("dangling.exr")).expect("there").is_symlink());
    assert!(!at("gone.exr").exists());

    fs::create_dir(at("closed")).expect("made");
    fs::set_permissions(at("closed"), fs::Permissions::from_mode(0o555)).expect("set");
    if fs::write(at("closed/probe"), "").is_err() {
        assert!(check_writable(&at("closed/a.exr")).is_err());
        assert!(write(&at("closed/a.exr"), &light, &options).is_err());
    }
    fs::set_permissions(at("closed"), fs::Permissions::from_mode(0o755)).expect("set");
}
