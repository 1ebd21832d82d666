//! Tangents for meshes that come without: where u grows, at each vertex.
//!
//! The tangent of a vertex is the mean of those of the triangles around it,
//! each brought into the plane of the vertex's normal and weighted by its
//! angle there. Vertices that are the same in all that counts share one;
//! where a picture is mirrored along an edge, the vertices on it are split.
//!
//! Source: Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", master's
//! thesis, University of Copenhagen, 2008, which glTF 2.0 asks for.

use super::mesh::Mesh;
use rutilant_geom::{Vec2, Vec3, real};
use std::collections::HashMap;

impl Mesh {
    /// The same mesh with tangents for set number `set` of its texture coordinates, in place of its
    /// own. Vertices on the border of a mirrored picture are split, which adds some behind those
    /// there are; the triangles keep their order. A mesh without normals or such coordinates stays
    /// as it is.
    #[must_use]
    pub fn with_tangents(&self, set: usize) -> Self {
        let uvs = match set.checked_sub(1) {
            None => Some(&self.uvs),
            Some(more) => self.more_uvs.get(more),
        };
        let count = self.positions.len();
        let Some(uvs) = uvs.filter(|uvs| uvs.len() == count && self.normals.len() == count) else {
            return self.clone();
        };
        let mut groups = Groups::default();
        let corners: Vec<Option<[usize; 3]>> =
            self.triangles.iter().map(|t| groups.add(self, uvs, *t)).collect();

        // A vertex serves the first way round that uses it; the other one gets a copy.
        let mut with = self.clone();
        with.tangents = vec![[1.0, 0.0, 0.0, 1.0]; count];
        let mut served: Vec<Option<usize>> = vec![None; count];
        let mut copies = HashMap::new();
        for (triangle, corners) in with.triangles.iter_mut().zip(corners) {
            let Some(corners) = corners else { continue };
            for (vertex, group) in triangle.iter_mut().zip(corners) {
                let v = *vertex as usize;
                if *served[v].get_or_insert(group) == group {
                    with.tangents[v] = groups.tangent(group);
                    continue;
                }
                *vertex = *copies.entry((v, group)).or_insert_with(|| {
                    with.positions.push(self.positions[v]);
                    with.normals.push(self.normals[v]);
                    with.uvs.extend(self.uvs.get(v));
                    with.colors.extend(self.colors.get(v));
                    for (uvs, own) in with.more_uvs.iter_mut().zip(&self.more_uvs) {
                        uvs.extend(own.get(v));
                    }
                    with.tangents.push(groups.tangent(group));
                    (with.positions.len() - 1) as u32
                });
            }
        }
        with
    }
}

/// Position, normal, texture coordinates and the way round of the picture, bit by bit.
type Key = ([u32; 8], bool);

/// Corners that share a tangent.
#[derive(Default)]
struct Groups {
    known: HashMap<Key, usize>,
    /// The sum of their tangents, their normal, and whether the picture is mirrored.
    sums: Vec<(Vec3, Vec3, bool)>,
}

impl Groups {
    /// Adds a triangle's corners and gives their groups; `None` for one without vertices, or area,
    /// here or on the picture.
    fn add(&mut self, mesh: &Mesh, uvs: &[Vec2], triangle: [u32; 3]) -> Option<[usize; 3]> {
        let vertices = triangle.map(|v| v as usize);
        if vertices.iter().any(|&v| v >= mesh.positions.len()) {
            return None;
        }
        let [a, b, c] = vertices.map(|v| mesh.positions[v]);
        let [s, t, r] = vertices.map(|v| uvs[v]);
        let (p, q) = (t - s, r - s);
        let area = p.perp_dot(q);
        let mirrored = area < 0.0;
        let along = ((b - a) * q.y - (c - a) * p.y) * area.signum();
        let along = along.try_normalize().filter(|_| area != 0.0 && area.is_finite())?;
        let groups = [0, 1, 2].map(|i| {
            let v = vertices[i];
            let normal = mesh.normals[v].normalize_or_zero();
            let [n, m] = [(i + 1) % 3, (i + 2) % 3].map(|k| mesh.positions[vertices[k]]);
            let (x, y) = (n - mesh.positions[v], m - mesh.positions[v]);
            let angle = real::atan2(x.cross(y).length(), x.dot(y));
            let flat = (along - normal * normal.dot(along)).normalize_or_zero();
            let bits = |v: f32| (v + 0.0).to_bits();
            let [px, py, pz] = mesh.positions[v].to_array().map(bits);
            let [nx, ny, nz] = mesh.normals[v].to_array().map(bits);
            let [u, w] = uvs[v].to_array().map(bits);
            let key = ([px, py, pz, nx, ny, nz, u, w], mirrored);
            let next = self.sums.len();
            let group = *self.known.entry(key).or_insert(next);
            if group == next {
                self.sums.push((Vec3::ZERO, normal, mirrored));
            }
            self.sums[group].0 += flat * if angle.is_finite() { angle } else { 0.0 };
            group
        });
        Some(groups)
    }

    fn tangent(&self, group: usize) -> [f32; 4] {
        let (sum, normal, mirrored) = self.sums[group];
        let fallback = normal.any_orthonormal_vector();
        let Vec3 { x, y, z } = sum.try_normalize().unwrap_or(fallback);
        [x, y, z, if mirrored { -1.0 } else { 1.0 }]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two squares side by side, each with all of the picture; on the right one it is mirrored.
    fn butterfly() -> Mesh {
        let at = |x: f32, y: f32| Vec3::new(x, y, 0.0);
        Mesh {
            positions: [at(0., 0.), at(0., 1.), at(-1., 0.), at(-1., 1.), at(1., 0.), at(1., 1.)]
                .to_vec(),
            normals: vec![Vec3::Z; 6],
            uvs: [[1., 0.], [1., 1.], [0., 0.], [0., 1.], [0., 0.], [0., 1.]]
                .map(Vec2::from)
                .to_vec(),
            triangles: vec![[2, 0, 1], [2, 1, 3], [0, 4, 5], [0, 5, 1]],
            ..Mesh::default()
        }
    }

    /// u grows to the right on the left half and to the left on the right one; the middle is split.
    #[test]
    fn mirrored_pictures_are_split() {
        let with = butterfly().with_tangents(0);
        assert_eq!(with.positions.len(), 8);
        for (triangle, expected) in with.triangles.iter().zip([
            [1., 0., 0., 1.],
            [1., 0., 0., 1.],
            [-1., 0., 0., -1.],
            [-1., 0., 0., -1.],
        ]) {
            for &v in triangle {
                assert_eq!(with.tangents[v as usize], expected);
            }
        }
    }

    /// What has no area, no number or no vertex changes nothing, and nothing fails.
    #[test]
    fn broken_triangles_have_no_tangent() {
        let mut mesh = butterfly();
        let whole = mesh.with_tangents(0);
        mesh.triangles.extend([[0, 0, 0], [0, 1, 99]]);
        mesh.positions.push(Vec3::NAN);
        mesh.normals.push(Vec3::ZERO);
        mesh.uvs.push(Vec2::splat(f32::INFINITY));
        mesh.triangles.push([0, 1, 6]);
        let with = mesh.with_tangents(0);
        assert_eq!(with.triangles[..4].len(), whole.triangles.len());
        assert!(with.tangents.iter().flatten().all(|t| t.is_finite()));
        assert_eq!(Mesh::default().with_tangents(3), Mesh::default());
        assert_eq!(mesh.with_tangents(1).tangents, [[0.0; 4]; 0]);
    }
}
