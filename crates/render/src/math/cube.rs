//! Directions on the six faces of a cube.
//!
//! Faces are numbered +x, −x, +y, −y, +z, −z, and oriented as OpenGL's are, with the row that comes
//! first in memory on top: `u` runs to the right and `v` downwards.
//!
//! Source: Segal, Akeley, *The OpenGL Graphics System*, version 4.6, table 8.19.

use rutilant_geom::{Vec2, Vec3};

/// How a face lies in space: its middle, and where its `u` and `v` run to.
pub const FACES: [[Vec3; 3]; 6] = [
    [Vec3::X, Vec3::NEG_Z, Vec3::NEG_Y],
    [Vec3::NEG_X, Vec3::Z, Vec3::NEG_Y],
    [Vec3::Y, Vec3::X, Vec3::Z],
    [Vec3::NEG_Y, Vec3::X, Vec3::NEG_Z],
    [Vec3::Z, Vec3::X, Vec3::NEG_Y],
    [Vec3::NEG_Z, Vec3::NEG_X, Vec3::NEG_Y],
];

/// The number of the face whose middle is the unit vector `axis` along a coordinate axis.
pub fn face_of(axis: Vec3) -> usize {
    FACES.iter().position(|[middle, ..]| *middle == axis).unwrap_or(0)
}

/// The face, and the point of it, that shows a direction of any length but 0; both coordinates in
/// [0, 1). An edge belongs to the face of the earlier axis.
pub fn uv_from_direction(d: Vec3) -> (usize, Vec2) {
    let [x, y, z] = d.abs().to_array();
    let axis = if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    };
    let face = 2 * axis + usize::from(d[axis] < 0.0);
    let [_, right, down] = FACES[face];
    const LAST: f32 = 1.0 - 0.5 * f32::EPSILON;
    let on_face = Vec2::new(d.dot(right), d.dot(down)) / d[axis].abs();
    (face, (0.5 * on_face + 0.5).clamp(Vec2::ZERO, Vec2::splat(LAST)))
}

/// The unit direction that a point of a face shows.
pub fn direction_from_uv(face: usize, uv: Vec2) -> Vec3 {
    let [middle, right, down] = FACES[face];
    let [u, v] = (2.0 * uv - Vec2::ONE).to_array();
    (middle + right * u + down * v).normalize()
}

/// How much of a face a unit of solid angle covers around a unit direction: of a cube with sides
/// of 2, a distance of `1 / most` is seen under the cosine `most`.
pub fn uv_per_solid_angle(d: Vec3) -> f32 {
    let most = d.abs().max_element();
    0.25 / (most * most * most)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// OpenGL's table, worked by hand: s = ½ (sc / |ma| + 1) and t alike, where (sc, tc, ma) is
    /// (−z, −y, x), (z, −y, x), (x, z, y), (x, −z, y), (x, −y, z), (−x, −y, z).
    #[test]
    fn faces_are_those_of_opengl() {
        for (d, face, uv) in [
            ([4.0, 2.0, 1.0], 0, [0.375, 0.25]),
            ([-4.0, 2.0, 1.0], 1, [0.625, 0.25]),
            ([1.0, 4.0, 2.0], 2, [0.625, 0.75]),
            ([1.0, -4.0, 2.0], 3, [0.625, 0.25]),
            ([2.0, 1.0, 4.0], 4, [0.75, 0.375]),
            ([2.0, 1.0, -4.0], 5, [0.25, 0.375]),
        ] {
            let (d, uv) = (Vec3::from(d), Vec2::from(uv));
            assert_eq!(uv_from_direction(d), (face, uv), "{d}");
            let back = direction_from_uv(face, uv);
            assert!((back - d.normalize()).length() < 1e-6, "{face} {uv}: {back}");
            assert_eq!(face_of(FACES[face][0]), face);
        }
    }

    /// The density of each face adds up to a sixth of the sphere.
    #[test]
    fn a_face_is_a_sixth_of_the_sphere() {
        let n = 256;
        let solid_angle = |i: i32| {
            let uv = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
            f64::from(1.0 / uv_per_solid_angle(direction_from_uv(3, uv)))
        };
        let face = (0..n * n).map(solid_angle).sum::<f64>() / f64::from(n * n);
        assert!((face / (std::f64::consts::PI * 4.0 / 6.0) - 1.0).abs() < 1e-4, "{face}");
    }
}
