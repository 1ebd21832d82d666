//! How much memory reading takes: so many bytes for a triangle, and none for what is not asked for.
//!
//! In a process of its own, since the system counts memory by process. With times as well, and at
//! any size: `cargo run --release -p rutilant-formats --example load -- 1000000`.

#[path = "common/load.rs"]
mod load;

use load::{BUDGETS, forget_peak, memory, write_hills};
use rutilant::Prepared;
use rutilant_formats::{Limits, ReadOptions, read_scene};

/// The system counts memory by process, so these take turns.
#[test]
fn memory_is_bounded() {
    a_triangle_takes_few_bytes();
    text_bombs_stay_packed();
    pictures_are_unpacked_once();
    too_many_pictures_stay_packed();
}

/// The old program kept a hundred bytes for each triangle, and as many again while it read.
/// Here: two vertices share four triangles, and nothing is stored twice.
fn a_triangle_takes_few_bytes() {
    let folder = tempfile::tempdir().expect("a folder");
    for budget in BUDGETS {
        let path = folder.path().join("hills").with_extension(budget.format);
        let triangles = write_hills(&path, 400).expect("written") as f64;
        let (true, Some(before)) = (forget_peak(), memory("VmRSS")) else {
            eprintln!("skipped: this system does not tell how much memory a process had");
            return;
        };
        let loaded = read_scene(&path, &ReadOptions::default()).expect("read");
        let [peak, after] = ["VmHWM", "VmRSS"].map(|name| memory(name).expect("told"));
        let each = |bytes: u64| bytes.saturating_sub(before) as f64 / triangles;
        let format = budget.format;
        assert!(each(peak) <= budget.bytes, "{format}: {:.1} bytes at the peak", each(peak));
        assert!(each(after) <= 40.0, "{format}: {:.1} bytes stay", each(after));
        // The arrays themselves, by count: 12 bytes for a triangle, 12 for a vertex.
        let mesh = &loaded.scene.meshes[0];
        let bytes = 12 * mesh.positions.capacity() + 12 * mesh.triangles.capacity();
        assert_eq!(mesh.triangles.len() as f64, triangles);
        assert!(bytes as f64 <= 19.0 * triangles, "{format}: {bytes} bytes in arrays");
    }
}

/// Bits of deflate, lowest first in each byte.
struct Bits {
    bytes: Vec<u8>,
    used: u32,
}

impl Bits {
    fn push(&mut self, bits: u32, count: u32) {
        for i in 0..count {
            if self.used.is_multiple_of(8) {
                self.bytes.push(0);
            }
            let last = self.bytes.len() - 1;
            self.bytes[last] |= ((bits >> i & 1) as u8) << (self.used % 8);
            self.used += 1;
        }
    }
}

/// A zlib stream of more than `size` zeros. A match of 258 bytes takes 13 bits.
fn zeros(size: usize) -> Vec<u8> {
    let mut bits = Bits { bytes: vec![0x78, 0x9c], used: 16 };
    // The last block, with fixed codes; a literal 0; matches of 258 bytes one byte back. Codes
    // are written from their highest bit on.
    bits.push(0b011, 3);
    bits.push(u32::from(0b0011_0000_u8.reverse_bits()), 8);
    for _ in 0..size.div_ceil(258) {
        bits.push(u32::from(0b1100_0101_u8.reverse_bits()), 8);
        bits.push(0, 5);
    }
    // The end of the block.
    bits.push(0, 7);
    bits.bytes
}

/// The checksum of PNG chunks: CRC-32, bit by bit.
fn checksum(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc: u32, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| {
            if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 }
        })
    })
}

fn chunk(name: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let named = [name.as_slice(), data].concat();
    let length = (data.len() as u32).to_be_bytes();
    [length.as_slice(), &named, &checksum(&named).to_be_bytes()].concat()
}

/// Two megabytes of compressed text, or of a colour profile, that unpack to a quarter of a
/// gigabyte: nobody asks for them, so nobody unpacks them.
fn text_bombs_stay_packed() {
    let bomb = zeros(256 << 20);
    let pixels = {
        // A pixel of 8-bit grey: its filter, 0, and its value, 0.
        let mut bits = Bits { bytes: vec![0x78, 0x9c], used: 16 };
        bits.push(0b011, 3);
        bits.push(u32::from(0b0011_0000_u8.reverse_bits()), 8);
        bits.push(u32::from(0b0011_0000_u8.reverse_bits()), 8);
        bits.push(0, 7);
        // Adler-32 of two zeros.
        [bits.bytes.as_slice(), &0x0002_0001_u32.to_be_bytes()].concat()
    };
    for (name, head) in
        [(b"zTXt", &b"key\0\0"[..]), (b"iTXt", b"key\0\x01\0\0\0"), (b"iCCP", b"profile\0\0")]
    {
        let png = [
            b"\x89PNG\r\n\x1a\n".to_vec(),
            chunk(b"IHDR", &[0, 0, 0, 1, 0, 0, 0, 1, 8, 0, 0, 0, 0]),
            chunk(name, &[head, &bomb].concat()),
            chunk(b"IDAT", &pixels),
            chunk(b"IEND", &[]),
        ]
        .concat();
        let (true, Some(before)) = (forget_peak(), memory("VmRSS")) else { return };
        let image = rutilant_formats::image::read_bytes(&png, "a.png".as_ref(), &Limits::default())
            .expect("an image");
        assert_eq!(image.channels()[0].values, [0.0]);
        let grown = memory("VmHWM").expect("told").saturating_sub(before);
        assert!(grown < 32 << 20, "{} took {grown} bytes", String::from_utf8_lossy(name));
    }
}

const CAMERA: &str = "version = 1\n[camera]\nposition = [0, 0, 4]\nlook_at = [0, 0, 0]\n";

/// A black picture of `side` pixels each way, in a thousandth of its size.
fn black(side: u32, bits: u8, colors: u8) -> Vec<u8> {
    let [size, channels] = [side as usize, if colors == 2 { 3 } else { 1 }];
    let row = 1 + size * channels * usize::from(bits) / 8;
    let head = [&side.to_be_bytes()[..], &side.to_be_bytes(), &[bits, colors, 0, 0, 0]].concat();
    [
        b"\x89PNG\r\n\x1a\n".to_vec(),
        chunk(b"IHDR", &head),
        chunk(b"IDAT", &zeros(size * row)),
        chunk(b"IEND", &[]),
    ]
    .concat()
}

/// A file may hold a picture a thousand times its size, so nothing is kept twice on the way: codes of
/// 16 bits are unpacked to where they stay, and the smaller versions of a texture, a third in all, are
/// made in place.
fn pictures_are_unpacked_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = "[[texture]]\nname = \"black\"\nimage = \"black.png\"\n\
                 [[material]]\nname = \"m\"\ntype = \"matte\"\nalbedo = { texture = \"black\" }\n\
                 [[shape]]\ntype = \"sphere\"\nradius = 1\nmaterial = \"m\"\n";
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, [CAMERA, scene].concat()).expect("written");
    for (side, bits, colors) in [(4000, 16, 0), (4000, 8, 2)] {
        std::fs::write(folder.path().join("black.png"), black(side, bits, colors))
            .expect("written");
        let (true, Some(before)) = (forget_peak(), memory("VmRSS")) else { return };
        let loaded = read_scene(&path, &ReadOptions::default()).expect("read");
        let bytes = loaded.scene.bitmaps[0].bytes();
        assert_eq!(bytes, 16_000_000 * u64::from(bits / 8) * if colors == 2 { 3 } else { 1 });
        let peak = || memory("VmHWM").expect("told").saturating_sub(before);
        assert!(peak() < bytes + bytes / 4 + (8 << 20), "{bits} bits: {} to read", peak());
        let prepared = Prepared::new(&loaded.scene).expect("prepared");
        let all = prepared.report().texture_bytes;
        assert!(peak() < all + all / 8 + (8 << 20), "{bits} bits: {} of {all}", peak());
    }
}

/// Fifty small files with large pictures are refused by the limit on all of them before more are
/// unpacked than threads read at once.
fn too_many_pictures_stay_packed() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("black.png"), black(4000, 8, 2)).expect("written");
    let texture = |i: u32| {
        let name = format!("black{i}.png");
        let linked = folder.path().join(&name);
        std::fs::copy(folder.path().join("black.png"), linked).expect("copied");
        format!("[[texture]]\nname = \"t{i}\"\nimage = \"{name}\"\n")
    };
    let textures: String = (0..50).map(texture).collect();
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, [CAMERA, &textures].concat()).expect("written");
    let limits = Limits { texture_bytes: 50_000_000, ..Limits::default() };
    let (true, Some(before)) = (forget_peak(), memory("VmRSS")) else { return };
    let error = read_scene(&path, &ReadOptions { limits, ..ReadOptions::default() });
    let error = error.expect_err("too much").to_string();
    assert!(error.contains("96000000 bytes of textures"), "{error}");
    let peak = memory("VmHWM").expect("told").saturating_sub(before);
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get) as u64;
    assert!(peak < (2 + threads) * 50_000_000, "{peak}");
}
