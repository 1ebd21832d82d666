//! Round bodies cut up into triangles: what scenes tell by a radius, and what is not a whole sphere
//! or disk.
//!
//! Each is a grid over u, around the z axis from +x on, and v; normals are those of the round body.

use rutilant::shape::Mesh;
use rutilant_geom::{Vec2, Vec3, real};

/// Steps of a full turn: an outline of so many is off by 0.03 %.
const STEPS: u32 = 128;

fn steps(degrees: f32) -> u32 {
    ((degrees.abs() / 360.0 * STEPS as f32).ceil() as u32).max(1)
}

/// A part of a sphere: from the first latitude, where v is 0, to the second, where it is 1, and over
/// so many degrees. Latitudes are in degrees, +z is 90.
pub(super) fn sphere(radius: f32, [first, last]: [f32; 2], turn: f32) -> Mesh {
    grid([steps(turn), steps(last - first)], |u, v| {
        let (s, c) = real::sin_cos_degrees(u * turn);
        let (up, away) = real::sin_cos_degrees(first + (last - first) * v);
        let normal = Vec3::new(away * c, away * s, up);
        (normal * radius, normal)
    })
}

/// A part of a disk around z, which looks along +z; v goes from its edge to `inner`.
pub(super) fn ring(radius: f32, inner: f32, height: f32, turn: f32) -> Mesh {
    grid([steps(turn), 1], |u, v| {
        let (s, c) = real::sin_cos_degrees(u * turn);
        let away = radius + (inner - radius) * v;
        (Vec3::new(away * c, away * s, height), Vec3::Z)
    })
}

/// A part of the side of a cylinder around z, without its ends.
pub(super) fn cylinder(radius: f32, [low, high]: [f32; 2], turn: f32) -> Mesh {
    grid([steps(turn), 1], |u, v| {
        let (s, c) = real::sin_cos_degrees(u * turn);
        let normal = Vec3::new(c, s, 0.0);
        (normal * radius + Vec3::Z * (low + (high - low) * v), normal)
    })
}

/// A grid of vertices, `point` of which gives position and normal for (u, v) in 0..1; fronts are
/// where the normals point.
fn grid([along, up]: [u32; 2], point: impl Fn(f32, f32) -> (Vec3, Vec3)) -> Mesh {
    let mut mesh = Mesh::default();
    for row in 0..=up {
        for column in 0..=along {
            let (u, v) = (column as f32 / along as f32, row as f32 / up as f32);
            let (position, normal) = point(u, v);
            mesh.positions.push(position);
            mesh.normals.push(normal);
            mesh.uvs.push(Vec2::new(u, v));
        }
    }
    for row in 0..up {
        for column in 0..along {
            let at = row * (along + 1) + column;
            let [a, b, c, d] = [at, at + 1, at + along + 2, at + along + 1];
            for triangle in [[a, b, c], [a, c, d]] {
                let [p, q, r] = triangle.map(|i| mesh.positions[i as usize].as_dvec3());
                // At a pole a row is a point, and one of the two has no area.
                if p == q || q == r || r == p {
                    continue;
                }
                let normal: Vec3 = triangle.iter().map(|i| mesh.normals[*i as usize]).sum();
                let inwards = (q - p).cross(r - p).dot(normal.as_dvec3()) < 0.0;
                let [p, q, r] = triangle;
                mesh.triangles.push(if inwards { [p, r, q] } else { triangle });
            }
        }
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fronts are where normals point, whichever way u and v run; at poles no triangle is left that
    /// has no area; and the area is that of the round body, to what its outline is off.
    #[test]
    fn round_bodies_look_outwards() {
        let pi = std::f64::consts::PI;
        for (mesh, triangles, area) in [
            (sphere(2.0, [90.0, -90.0], 360.0), 16_128, 16.0 * pi),
            (sphere(2.0, [-90.0, 90.0], 360.0), 16_128, 16.0 * pi),
            (sphere(2.0, [0.0, 90.0], 90.0), 2 * 32 * 32 - 32, 2.0 * pi),
            (cylinder(2.0, [-1.0, 2.0], 360.0), 256, 12.0 * pi),
            (ring(2.0, 1.0, 5.0, 360.0), 256, 3.0 * pi),
            (ring(2.0, 0.0, 5.0, 180.0), 64, 2.0 * pi),
        ] {
            assert_eq!(mesh.triangles.len(), triangles);
            let mut sum = 0.0;
            for triangle in &mesh.triangles {
                let [a, b, c] = triangle.map(|i| mesh.positions[i as usize].as_dvec3());
                let front = (b - a).cross(c - a);
                sum += 0.5 * front.length();
                for i in triangle {
                    assert!(mesh.normals[*i as usize].as_dvec3().dot(front) > 0.0);
                }
            }
            assert!((sum / area - 1.0).abs() < 1e-3, "{sum}, not {area}");
        }
    }
}
