//! Meshes as PLY files: binary, little endian, with all that a mesh has.
//!
//! Properties are named as other programs name them, as far as these have any: `s t` and `s1 t1`
//! and so on for texture coordinates, `tx ty tz` for tangents (Assimp; Blender for the first set).
//! A fourth number of a tangent, `tw`, is its side, and colours are floating-point numbers.

use super::reader::{COLOR, MORE_SETS, TANGENT};
use rutilant::shape::Mesh;
use rutilant_geom::Vec2;
use std::fmt::Write as _;

/// The content of a PLY file that reads back as `mesh`, bit by bit, but for its name and for more
/// than 16 sets of texture coordinates. What is not there once for each position is left out.
pub fn to_bytes(mesh: &Mesh) -> Vec<u8> {
    let count = mesh.positions.len();
    let fits = |length: usize| length == count && count > 0;
    let sets: Vec<(usize, &[Vec2])> = std::iter::once(&mesh.uvs)
        .chain(&mesh.more_uvs)
        .map(Vec::as_slice)
        .enumerate()
        .take(1 + MORE_SETS)
        .filter(|(_, uvs)| fits(uvs.len()))
        .collect();
    let has_normals = fits(mesh.normals.len());
    let (has_tangents, has_colors) = (fits(mesh.tangents.len()), fits(mesh.colors.len()));

    // What follows.
    let mut header = format!("ply\nformat binary_little_endian 1.0\nelement vertex {count}\n");
    let mut width = 0;
    let mut property = |name: &str| {
        let _ = writeln!(header, "property float {name}");
        width += size_of::<f32>();
    };
    ["x", "y", "z"].into_iter().for_each(&mut property);
    if has_normals {
        ["nx", "ny", "nz"].into_iter().for_each(&mut property);
    }
    for (set, _) in &sets {
        // The first has no number.
        let number = if *set == 0 { String::new() } else { set.to_string() };
        ["s", "t"].into_iter().for_each(|name| property(&format!("{name}{number}")));
    }
    if has_tangents {
        TANGENT.into_iter().for_each(&mut property);
    }
    if has_colors {
        COLOR.into_iter().for_each(&mut property);
    }
    // Some programs read no other types of a list than these.
    let index = if i32::try_from(count).is_ok() { "int" } else { "uint" };
    let faces = mesh.triangles.len();
    let _ = writeln!(header, "element face {faces}\nproperty list uchar {index} vertex_indices");
    header.push_str("end_header\n");

    // The numbers.
    let mut bytes = header.into_bytes();
    bytes.reserve_exact(count * width + faces * (1 + 3 * size_of::<u32>()));
    for i in 0..count {
        let mut put = |numbers: &[f32]| bytes.extend(numbers.iter().flat_map(|n| n.to_le_bytes()));
        put(&mesh.positions[i].to_array());
        if has_normals {
            put(&mesh.normals[i].to_array());
        }
        sets.iter().for_each(|(_, uvs)| put(&uvs[i].to_array()));
        if has_tangents {
            put(&mesh.tangents[i]);
        }
        if has_colors {
            put(&mesh.colors[i]);
        }
    }
    for triangle in &mesh.triangles {
        bytes.push(3);
        bytes.extend(triangle.iter().flat_map(|v| v.to_le_bytes()));
    }
    bytes
}
