//! Four triangles at once: which of them a ray certainly misses.
//!
//! The test is that of `triangle.rs` in single precision, with edges moved out by
//! more than rounding can do. Whatever it lets through is met exactly afterwards;
//! it only has to be quick, and never to lose a hit.
//!
//! How much rounding can do: let u be 2⁻²⁴, e the longest edge along an axis, and D
//! the way to the leaf's box and the extent of that together, so that no vertex is
//! farther from the origin along any axis. A vertex, taken relative to the origin
//! and sheared, is wrong by at most 6uD along each axis. If the triangle is met, its
//! vertices lie within 2e of the ray, and an edge function is a difference of two
//! products of such coordinates: it is wrong by at most
//! 4 · 6uD · 2e + 2 (6uD)² + 2u (2e)², which for e ≤ D is less than 64uD (e + 2uD).

use crate::bvh::PACK;
use crate::{Aabb, Ray, Vec3};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4};

/// Four triangles. 176 bytes.
#[derive(Clone, Debug)]
#[repr(align(16))]
pub(crate) struct Pack {
    /// (vertex, axis, triangle).
    vertices: [[[f32; PACK]; 3]; 3],
    /// The longest edge of each along an axis; NaN where there is no triangle.
    edges: [f32; PACK],
    /// The largest extent of the leaf's box along an axis.
    extent: f32,
    /// The place of the first triangle in the order of the tree; the others follow.
    first: u32,
}

/// Triangles with larger coordinates are met one by one: their products could overflow.
const LARGEST: f32 = 1e17;

/// True for a triangle that may be in a pack.
pub(crate) fn fits(corners: [Vec3; 3]) -> bool {
    corners.iter().all(|v| v.abs().max_element() < LARGEST)
}

impl Pack {
    /// Up to four triangles of a leaf with these bounds.
    pub(crate) fn new(triangles: &[[Vec3; 3]], first: usize, bounds: &Aabb) -> Self {
        let extent = bounds.extent().max_element().next_up();
        let (vertices, edges) = ([[[0.0; PACK]; 3]; 3], [f32::NAN; PACK]);
        let mut pack = Self { vertices, edges, extent, first: first as u32 };
        for (lane, corners) in triangles.iter().take(PACK).enumerate() {
            for (vertex, corner) in corners.iter().enumerate() {
                for axis in 0..3 {
                    pack.vertices[vertex][axis][lane] = corner[axis];
                }
            }
            let edges = Aabb::around(*corners).extent().max_element();
            pack.edges[lane] = edges.next_up();
        }
        pack
    }

    /// How many triangles there are.
    pub(crate) fn len(&self) -> usize {
        self.edges.iter().filter(|edge| !edge.is_nan()).count()
    }

    /// The place of one triangle in the order of the tree.
    #[inline(always)]
    pub(crate) fn place(&self, lane: usize) -> usize {
        self.first as usize + lane
    }

    /// The corners of one triangle.
    #[inline(always)]
    pub(crate) fn triangle(&self, lane: usize) -> [Vec3; 3] {
        let v = &self.vertices;
        let at =
            |i: usize| Vec3::new(v[i][0][lane % PACK], v[i][1][lane % PACK], v[i][2][lane % PACK]);
        [at(0), at(1), at(2)]
    }
}

/// What all packs ask of one ray.
pub(crate) struct PackRay<S: Simd> {
    simd: S,
    /// In the order of `axes`.
    origin: [f32x4<S>; 3],
    /// The axis along which the ray goes most, as the last.
    axes: [usize; 3],
    /// The shear that turns the ray onto that axis.
    shear: [f32x4<S>; 2],
}

impl<S: Simd> PackRay<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, ray: &Ray) -> Self {
        let size = ray.direction.abs();
        let axes = if size.x > size.y && size.x > size.z {
            [1, 2, 0]
        } else if size.y > size.z {
            [2, 0, 1]
        } else {
            [0, 1, 2]
        };
        let along = |axis: usize| ray.direction[axes[axis]];
        let splat = |v: f32| f32x4::splat(simd, v);
        Self {
            simd,
            origin: [
                splat(ray.origin[axes[0]]),
                splat(ray.origin[axes[1]]),
                splat(ray.origin[axes[2]]),
            ],
            axes,
            shear: [splat(along(0) / along(2)), splat(along(1) / along(2))],
        }
    }

    /// Which triangles the ray may meet, a bit for each. It enters the leaf's box no farther from
    /// its origin than `way` along any axis.
    #[inline(always)]
    pub(crate) fn meet(&self, pack: &Pack, way: f32) -> u32 {
        const U: f32 = f32::EPSILON / 2.0;
        let simd = self.simd;
        if way >= LARGEST {
            return (1 << PACK) - 1;
        }
        let lanes = |vertex: usize, i: usize| -> f32x4<S> {
            let lanes: f32x4<S> = pack.vertices[vertex][self.axes[i] % 3].simd_into(simd);
            lanes - self.origin[i]
        };
        let sheared = |vertex: usize| -> [f32x4<S>; 2] {
            let along = lanes(vertex, 2);
            let [sx, sy] = self.shear;
            [lanes(vertex, 0) - along * sx, lanes(vertex, 1) - along * sy]
        };
        let (a, b, c) = (sheared(0), sheared(1), sheared(2));
        let edge_function = |p: [f32x4<S>; 2], q: [f32x4<S>; 2]| p[0] * q[1] - p[1] * q[0];
        let (u, v, w) = (edge_function(c, b), edge_function(a, c), edge_function(b, a));

        let edges: f32x4<S> = pack.edges.simd_into(simd);
        let reach = way + pack.extent;
        let bound = (edges + 2.0 * U * reach) * (64.0 * U * reach) + f32::MIN_POSITIVE;
        let (least, most) = (u.min(v).min(w), u.max(v).max(w));
        (least.simd_ge(-bound) | most.simd_le(bound)).to_bitmask() as u32
    }
}
