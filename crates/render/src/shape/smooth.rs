//! Smooth normals for meshes that come without.
//!
//! The normal of a vertex is the mean of the normals around it, each triangle
//! weighted by its angle there: how finely a flat side is cut into triangles
//! then does not matter. Across a crease, an edge too sharp to be meant as
//! round, nothing is averaged: its vertices are split, one for each side.
//!
//! Source: Thürmer and Wüthrich, "Computing Vertex Normals from Polygonal
//! Facets", JGT 3(1), 1998.

use super::mesh::Mesh;
use rutilant_geom::{Vec3, real};
use std::collections::HashMap;

impl Mesh {
    /// The same surface with smooth normals in place of its own.
    ///
    /// `crease` is the largest angle, in radians, between two triangles that are smoothed over the
    /// edge they share: 0 smooths what is flat already, π everything. Edges of one triangle, or of
    /// three and more, are creases. Vertices at the same point count as one, so that seams of
    /// texture coordinates do not show; where creases meet a vertex it is split, which adds
    /// vertices behind those there are. The triangles keep their order.
    ///
    /// Triangles without area, not finite or with vertices that do not exist smooth nothing.
    #[must_use]
    pub fn smoothed(&self, crease: f32) -> Self {
        let faces: Vec<Face> = self.triangles.iter().map(|t| Face::new(self, *t)).collect();
        let mut fans = self.fans(&faces, crease);

        // Every corner adds to the normal of the fan it belongs to.
        let mut sums = vec![Vec3::ZERO; 3 * faces.len()];
        for (i, face) in faces.iter().enumerate() {
            for k in 0..3 {
                sums[fans.find(3 * i + k)] += face.normal * face.angles[k];
            }
        }

        // A vertex serves the first fan that uses it; each further fan gets a copy.
        let mut smooth = Self { normals: vec![Vec3::Y; self.positions.len()], ..self.clone() };
        let mut served = vec![None; self.positions.len()];
        let mut copies = HashMap::new();
        for (i, triangle) in smooth.triangles.iter_mut().enumerate() {
            for (k, vertex) in triangle.iter_mut().enumerate() {
                let (v, fan) = (*vertex as usize, fans.find(3 * i + k));
                let Some(first) = served.get_mut(v) else { continue };
                if *first.get_or_insert(fan) == fan {
                    smooth.normals[v] = sums[fan].try_normalize().unwrap_or(Vec3::Y);
                    continue;
                }
                *vertex = *copies.entry((v, fan)).or_insert_with(|| {
                    smooth.positions.push(self.positions[v]);
                    smooth.normals.push(sums[fan].try_normalize().unwrap_or(Vec3::Y));
                    smooth.uvs.extend(self.uvs.get(v));
                    smooth.colors.extend(self.colors.get(v));
                    smooth.tangents.extend(self.tangents.get(v));
                    for (uvs, own) in smooth.more_uvs.iter_mut().zip(&self.more_uvs) {
                        uvs.extend(own.get(v));
                    }
                    (smooth.positions.len() - 1) as u32
                });
            }
        }
        smooth
    }

    /// Joins the corners (three for each triangle) around a point that no crease parts.
    fn fans(&self, faces: &[Face], crease: f32) -> Fans {
        let mut fans = Fans { parents: (0..3 * faces.len()).collect() };
        // The slack lets a flat surface be flat in spite of rounding.
        let least_cosine = real::sin_cos(crease).1 - 1e-6;

        // All edges as (point, point, corner at the first, corner at the second), equal ones
        // side by side, in the order of their triangles.
        let points = self.points();
        let mut edges = Vec::with_capacity(3 * faces.len());
        for (i, face) in faces.iter().enumerate().filter(|(_, f)| f.normal != Vec3::ZERO) {
            for k in 0..3 {
                let ends = [k, (k + 1) % 3].map(|k| (points[face.vertices[k] as usize], 3 * i + k));
                let [a, b] = if ends[0].0 < ends[1].0 { ends } else { [ends[1], ends[0]] };
                edges.push((a.0, b.0, a.1, b.1));
            }
        }
        edges.sort_unstable();

        for same in edges.chunk_by(|e, f| (e.0, e.1) == (f.0, f.1)) {
            let [(_, _, a, b), (_, _, c, d)] = *same else { continue };
            if faces[a / 3].normal.dot(faces[c / 3].normal) >= least_cosine {
                fans.join(a, c);
                fans.join(b, d);
            }
        }
        fans
    }

    /// For each vertex the first vertex at the same point.
    fn points(&self) -> Vec<u32> {
        let mut first = HashMap::with_capacity(self.positions.len());
        self.positions
            .iter()
            .zip(0_u32..)
            // The sum makes −0 a plain 0.
            .map(|(p, v)| *first.entry((*p + Vec3::ZERO).to_array().map(f32::to_bits)).or_insert(v))
            .collect()
    }
}

/// What a triangle adds to the normals of its vertices.
struct Face {
    vertices: [u32; 3],
    /// Of unit length; zero for a triangle that smooths nothing.
    normal: Vec3,
    /// At each vertex, in radians.
    angles: [f32; 3],
}

impl Face {
    fn new(mesh: &Mesh, vertices: [u32; 3]) -> Self {
        let nothing = Self { vertices, normal: Vec3::ZERO, angles: [0.0; 3] };
        let mut corners = [Vec3::ZERO; 3];
        for (corner, v) in corners.iter_mut().zip(vertices) {
            match mesh.positions.get(v as usize) {
                Some(p) => *corner = *p,
                None => return nothing,
            }
        }
        let [a, b, c] = corners;
        // Tiny triangles have normals too: sides are brought to length 1 at most before they
        // are multiplied.
        let longest = [b - a, c - b, a - c].into_iter().map(Vec3::length).fold(0.0, f32::max);
        let sides = [b - a, c - b, a - c].map(|side| side / longest);
        let Some(normal) = sides[0].cross(-sides[2]).try_normalize() else { return nothing };
        // From the side that leaves a corner to the one that comes in, seen from there.
        let angle = |leaving: Vec3, coming: Vec3| {
            real::atan2(leaving.cross(-coming).length(), leaving.dot(-coming))
        };
        let angles =
            [angle(sides[0], sides[2]), angle(sides[1], sides[0]), angle(sides[2], sides[1])];
        Self { vertices, normal, angles }
    }
}

/// Sets of corners. A set is known by its first corner.
struct Fans {
    parents: Vec<usize>,
}

impl Fans {
    fn find(&mut self, mut corner: usize) -> usize {
        while self.parents[corner] != corner {
            // Halve the way for those who come later.
            self.parents[corner] = self.parents[self.parents[corner]];
            corner = self.parents[corner];
        }
        corner
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.find(a), self.find(b));
        self.parents[a.max(b)] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::{FRAC_PI_2, PI};

    /// A cube around the origin with 8 vertices. Every side's diagonal is chosen so that some
    /// corners touch one triangle of a side and some two: only weights by angle make up for it.
    fn cube() -> Mesh {
        let positions = (0..8)
            .map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32))
            .map(|p| 2.0 * p - Vec3::ONE)
            .collect();
        let sides: [[u32; 4]; 6] =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Mesh { positions, triangles, ..Mesh::default() }
    }

    /// How a side is cut into triangles is not seen: without creases every corner of a cube
    /// points along its diagonal.
    #[test]
    fn angles_make_up_for_the_diagonals() {
        let smooth = cube().smoothed(PI);
        assert_eq!(smooth.positions, cube().positions);
        assert_eq!(smooth.triangles, cube().triangles);
        for (p, n) in smooth.positions.iter().zip(&smooth.normals) {
            assert!((p.normalize() - *n).length() < 1e-6, "{p} {n}");
        }
    }

    /// With creases a cube keeps its sides: each corner splits in three, and every normal is its
    /// triangle's own.
    #[test]
    fn creases_split_vertices() {
        let sharp = cube().smoothed(FRAC_PI_2 - 0.01);
        assert_eq!(sharp.positions.len(), 24);
        assert_eq!(sharp.positions[..8], cube().positions);
        for (t, old) in sharp.triangles.iter().zip(&cube().triangles) {
            let [a, b, c] = t.map(|v| sharp.positions[v as usize]);
            assert_eq!([a, b, c], old.map(|v| cube().positions[v as usize]));
            let flat = (b - a).cross(c - a).normalize();
            for v in t {
                assert!((sharp.normals[*v as usize] - flat).length() < 1e-6);
            }
        }
    }

    /// A seam, where vertices are double because their texture coordinates differ, is not seen,
    /// and the coordinates stay with their vertices.
    #[test]
    fn seams_do_not_show() {
        let mut roof = Mesh {
            positions: [
                [0., 0., 0.],
                [0., 0., 1.],
                [-1., -0.3, 0.],
                [0., 0., 1.],
                [-0., 0., 0.],
                [1., -0.3, 0.],
            ]
            .map(Vec3::from)
            .to_vec(),
            triangles: vec![[0, 2, 1], [3, 5, 4]],
            ..Mesh::default()
        };
        roof.uvs = (0..6).map(|i| [i as f32, 0.0].into()).collect();
        let smooth = roof.smoothed(1.0);
        for ridge in [0, 1, 3, 4] {
            assert!((smooth.normals[ridge] - Vec3::Y).length() < 1e-6, "{}", smooth.normals[ridge]);
        }
        assert_eq!(smooth.uvs, roof.uvs);
        assert!(roof.smoothed(0.1).normals[0].x < -0.1);
    }

    /// Nothing that a file can hold makes smoothing fail: no area, no number, no vertex, three
    /// triangles on an edge.
    #[test]
    fn broken_triangles_smooth_nothing() {
        let mut mesh = cube();
        mesh.positions.extend([Vec3::NAN, Vec3::INFINITY, Vec3::splat(1e30), Vec3::splat(-1e-30)]);
        mesh.triangles.extend([
            [0, 0, 0],
            [0, 1, 8],
            [1, 2, 9],
            [0, 1, 99],
            [10, 11, 10],
            [8, 9, 8],
        ]);
        let smooth = mesh.smoothed(PI);
        for (p, n) in cube().positions.iter().zip(&smooth.normals) {
            assert!((p.normalize() - *n).length() < 1e-6, "{p} {n}");
        }
        assert!(smooth.normals.iter().all(|n| n.is_normalized()));
        assert_eq!(smooth.normals.len(), smooth.positions.len());
        mesh.triangles.push([0, 2, 7]);
        assert!(mesh.smoothed(PI).normals.iter().all(|n| n.is_normalized()));
        assert_eq!(Mesh::default().smoothed(1.0), Mesh::default());
    }
}
