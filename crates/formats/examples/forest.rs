//! Writes a forest: one tree that stands in many places, so that there are far more triangles than
//! memory could hold.
//!
//! ```sh
//! cargo run --release -p rutilant-formats --example forest -- FOLDER PLACES TRIANGLES
//! /usr/bin/time -v rutilant FOLDER/forest.toml --size 1024x1024 --spp 4 -o forest.png
//! ```
//!
//! The tree has about so many TRIANGLES, and stands in so many PLACES. 100000 places of 10000
//! triangles, a billion in all, are rendered within 300 megabytes. `scenes/forest.toml` is what
//! `scenes 900 1800` writes.

use rutilant_geom::{Transform, Vec3, real};
use std::f32::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;
use std::process::ExitCode;
use std::{fs, io};

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [folder, places, triangles] = &words[..] else { return usage() };
    let (Ok(places), Ok(triangles)) = (places.parse(), triangles.parse()) else { return usage() };
    if !(1..=10_000_000).contains(&places) || !(2..=10_000_000).contains(&triangles) {
        return usage();
    }
    match write(Path::new(folder), places, triangles) {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("{folder}: {problem}");
            ExitCode::FAILURE
        }
    }
}

fn usage() -> ExitCode {
    eprintln!("forest FOLDER PLACES TRIANGLES, both up to 10000000");
    ExitCode::from(2)
}

fn write(folder: &Path, places: u32, triangles: u32) -> io::Result<()> {
    let parts = folder.join("forest");
    fs::create_dir_all(&parts)?;
    fs::write(folder.join("forest.toml"), SCENE)?;
    // The same density, however many there are.
    let side = 2.1 * (places as f32).sqrt();
    fs::write(parts.join("hills.ply"), ply(&hills(side)))?;
    fs::write(parts.join("crown.ply"), ply(&crown(triangles / 2)))?;
    fs::write(parts.join("trunk.ply"), ply(&trunk()))?;
    let (mut green, mut gold) = (String::new(), String::new());
    for i in 0..places {
        let part = |k: u32| part(i, k);
        let (x, z) = (side * (part(1) - 0.5), side * (part(2) - 0.5));
        // A clearing to look from.
        if x.abs() < 2.5 && z > -4.0 && z < 9.0 {
            continue;
        }
        let size = 0.8 + 0.9 * part(3) * part(4);
        let place = Transform::translate(Vec3::new(x, height(x, z), z))
            * Transform::rotate(Vec3::new(part(5) - 0.5, 6.0, part(6) - 0.5), TAU * part(7))
            * Transform::scale(Vec3::new(size, size * (0.8 + 0.6 * part(8)), size));
        let (linear, to) = (place.linear(), place.translation());
        let text = if part(9) < 0.15 { &mut gold } else { &mut green };
        for axis in 0..3 {
            let [x, y, z] = [linear.x_axis[axis], linear.y_axis[axis], linear.z_axis[axis]];
            let _ = write!(text, "{x:.3} {y:.3} {z:.3} {:.2}", to[axis]);
            text.push(if axis == 2 { '\n' } else { ' ' });
        }
    }
    fs::write(parts.join("green.txt"), green)?;
    fs::write(parts.join("gold.txt"), gold)
}

const SCENE: &str = r##"# A forest: a crown of leaves and a trunk, each stored once, in hundreds of places.
# Written by `cargo run -p rutilant-formats --example forest`, which makes it as large as you like.
version = 1

[render]
size = [960, 540]
spp = 128
curve = "filmic"
exposure = 0.4

[camera]
position = [0, 3.4, 9]
look_at = [0, 2.6, 0]
fov_degrees = 40

[environment]
color = "#9cc4f0"
scale = 0.7

[[light]]
type = "directional"
direction = [-0.7, -0.55, -0.25]
irradiance = [3.4, 2.9, 2.2]

[[material]]
name = "ground"
type = "matte"
albedo = [0.22, 0.19, 0.09]

[[material]]
name = "bark"
type = "matte"
albedo = [0.16, 0.09, 0.05]

[[material]]
name = "green"
type = "matte"
albedo = [0.10, 0.24, 0.05]

[[material]]
name = "gold"
type = "matte"
albedo = [0.55, 0.27, 0.03]

[[shape]]
type = "mesh"
file = "forest/hills.ply"
smooth_degrees = 180
material = "ground"

[[shape]]
type = "mesh"
file = "forest/crown.ply"
material = "green"
instances = "forest/green.txt"

[[shape]]
type = "mesh"
file = "forest/trunk.ply"
material = "bark"
instances = "forest/green.txt"

[[shape]]
type = "mesh"
file = "forest/crown.ply"
material = "gold"
instances = "forest/gold.txt"

[[shape]]
type = "mesh"
file = "forest/trunk.ply"
material = "bark"
instances = "forest/gold.txt"
"##;

type Mesh = (Vec<Vec3>, Vec<[u32; 3]>);

/// Number `k` of thing `i`, in [0, 1): a hash.
fn part(i: u32, k: u32) -> f32 {
    let x = (i ^ k.wrapping_mul(0x85eb_ca6b)).wrapping_mul(0x9e37_79b9);
    let x = (x ^ (x >> 15)).wrapping_mul(0x2c1b_3c6d);
    ((x ^ (x >> 13)).wrapping_mul(0x297a_2d39) >> 8) as f32 / (1 << 24) as f32
}

/// Of the ground, in metres.
fn height(x: f32, z: f32) -> f32 {
    let far = (x * x + z * z) * 2e-4;
    let rise = far / (1.0 + far / 12.0);
    0.5 * real::sin(0.31 * x + 0.4) * real::cos(0.23 * z) + 0.8 * real::sin(0.07 * z) + rise
}

fn hills(side: f32) -> Mesh {
    const CELLS: u32 = 40;
    let at = |i: u32| side * (1.2 * i as f32 / CELLS as f32 - 0.6);
    let row = CELLS + 1;
    let positions = (0..row * row).map(|i| {
        let (x, z) = (at(i % row), at(i / row));
        // Below the trees, whose feet stand on the hills themselves.
        Vec3::new(x, height(x, z) - 0.05, z)
    });
    let cells = (0..CELLS * CELLS).map(|i| i % CELLS + i / CELLS * row);
    let triangles = cells.flat_map(|i| [[i, i + row, i + 1], [i + 1, i + row, i + row + 1]]);
    (positions.collect(), triangles.collect())
}

/// So many leaves of two triangles, on the boughs of a fir 3 m high.
fn crown(leaves: u32) -> Mesh {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    let boughs = 22;
    for i in 0..leaves.max(1) {
        let part = |k: u32| part(i, k);
        let bough = i % boughs;
        let up = (bough as f32 + 0.5) / boughs as f32;
        let (s, c) = real::sin_cos(2.4 * bough as f32 + 0.9 * (part(1) - 0.5));
        let out = part(2).sqrt() * (1.15 * (1.0 - up) + 0.08);
        let middle = Vec3::new(s * out, 0.5 + 2.5 * up - 0.35 * out + 0.12 * part(3), c * out);
        let along = Vec3::new(s, 0.6 * part(4) - 0.45, c) + Vec3::new(part(5), 0.0, part(6)) * 0.6;
        let along = along.normalize() * (0.16 + 0.1 * part(7));
        let across = along.cross(Vec3::new(part(8) - 0.5, 1.0, part(9) - 0.5)).normalize() * 0.055;
        let first = positions.len() as u32;
        positions.extend([middle, middle + along * 0.5 - across, middle + along]);
        positions.push(middle + along * 0.5 + across);
        triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    (positions, triangles)
}

/// A pole that grows thinner.
fn trunk() -> Mesh {
    const SIDES: u32 = 10;
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for i in 0..SIDES {
        let (s, c) = real::sin_cos(TAU * i as f32 / SIDES as f32);
        positions.extend([Vec3::new(s * 0.09, -0.3, c * 0.09), Vec3::new(s * 0.02, 2.7, c * 0.02)]);
        let [a, b, c, d] = [0, 2, 3, 1].map(|k| (2 * i + k) % (2 * SIDES));
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    (positions, triangles)
}

/// As a binary PLY file.
fn ply((positions, triangles): &Mesh) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\n\
         property float y\nproperty float z\nelement face {}\n\
         property list uchar int vertex_indices\nend_header\n",
        positions.len(),
        triangles.len()
    )
    .into_bytes();
    for position in positions {
        bytes.extend(position.to_array().into_iter().flat_map(f32::to_le_bytes));
    }
    for triangle in triangles {
        bytes.push(3);
        bytes.extend(triangle.iter().flat_map(|v| v.to_le_bytes()));
    }
    bytes
}
