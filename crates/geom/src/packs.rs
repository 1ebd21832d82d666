//! Four triangles at once: which of them a ray certainly misses.
//!
//! The test is that of `triangle.rs` in single precision, with edges moved out by
//! more than rounding can do. Whatever it lets through is met exactly afterwards;
//! it only has to be quick, and never to lose a hit.
//!
//! Where it can tell for certain that a triangle is met, and between which
//! distances, it says so: then what lies beyond need not be looked at.
//!
//! How much rounding can do: let u be 2⁻²⁴, e the longest edge along an axis, and D
//! the way to the leaf's box and the extent of that together, so that no vertex is
//! farther from the origin along any axis. A vertex, taken relative to the origin
//! and sheared, is wrong by at most 6uD along each axis. If the triangle is met, its
//! vertices lie within 2e of the ray, and within 4e at most if the first lies within
//! 2e as far as one can see. An edge function is a difference of two
//! products of such coordinates: it is wrong by at most
//! 4 · 6uD · 4e + 2 (6uD)² + 2u (4e)², which for e ≤ D is less than E = 128uD (e + uD).
//!
//! The distance is a mean of those of the vertices, which are wrong by less than 8uD,
//! weighted by the edge functions. If their sum is more than 8E, the weights
//! together are wrong by less than 10E over the sum.

use crate::bvh::PACK;
use crate::lanes::Xyz;
use crate::packet::HitPacket;
use crate::{Aabb, Ray, Vec3};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, mask32x4};

/// Four triangles. 180 bytes.
#[derive(Clone, Debug)]
pub(crate) struct Pack {
    /// (vertex, axis, triangle).
    pub(crate) vertices: [[[f32; PACK]; 3]; 3],
    /// The longest edge of each along an axis; NaN where there is no triangle.
    pub(crate) edges: [f32; PACK],
    /// The largest extent of the leaf's box along an axis.
    pub(crate) extent: f32,
    /// The number of each.
    pub(crate) primitives: [u32; PACK],
}

/// Triangles with larger coordinates are met one by one: their products could overflow.
pub(crate) const LARGEST: f32 = 1e17;

/// True for a triangle that may be in a pack.
pub(crate) fn fits(corners: [Vec3; 3]) -> bool {
    corners.iter().all(|v| v.abs().max_element() < LARGEST)
}

impl Pack {
    /// Up to four triangles of a leaf with these bounds: their numbers and corners.
    pub(crate) fn new(triangles: &[(u32, [Vec3; 3])], bounds: &Aabb) -> Self {
        let extent = bounds.extent().max_element().next_up();
        let (vertices, edges) = ([[[0.0; PACK]; 3]; 3], [f32::NAN; PACK]);
        let mut pack = Self { vertices, edges, extent, primitives: [0; PACK] };
        for (lane, (number, corners)) in triangles.iter().take(PACK).enumerate() {
            for (vertex, corner) in corners.iter().enumerate() {
                for axis in 0..3 {
                    pack.vertices[vertex][axis][lane] = corner[axis];
                }
            }
            let edges = Aabb::around(*corners).extent().max_element();
            pack.edges[lane] = edges.next_up();
            pack.primitives[lane] = *number;
        }
        pack
    }

    /// How many triangles there are.
    pub(crate) fn len(&self) -> usize {
        self.edges.iter().filter(|edge| !edge.is_nan()).count()
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

/// What single precision can say of rays and triangles.
pub(crate) struct Sorted<V, M> {
    /// True where the triangle may be met.
    pub(crate) may: M,
    /// True where it certainly is.
    pub(crate) sure: M,
    /// Not before this distance.
    pub(crate) from: V,
    /// Not beyond this one.
    pub(crate) until: V,
}

/// Where a ray starts and ends.
#[derive(Clone, Copy)]
pub(crate) struct Reach<V> {
    pub(crate) start: V,
    pub(crate) end: V,
    /// Nothing beyond this matters.
    pub(crate) limit: V,
}

/// Sorts out triangles, each with a ray. Their corners are relative to the origin and sheared, with
/// the distance along the ray as the third coordinate; `edge` is the longest edge along an axis, and
/// no corner is farther than `way` from the origin along any axis.
#[inline(always)]
pub(crate) fn sort_out<S: Simd, V: SimdFloat<S, Element = f32>>(
    [a, b, c]: [Xyz<V>; 3],
    edge: V,
    way: V,
    reach: Reach<V>,
) -> Sorted<V, V::Mask> {
    const U: f32 = f32::EPSILON / 2.0;
    let infinity = V::simd_from(edge.token(), f32::INFINITY);
    let (u, v, w) = (c.x * b.y - c.y * b.x, a.x * c.y - a.y * c.x, b.x * a.y - b.y * a.x);
    let error = (way * U + edge) * (way * (128.0 * U)) + f32::MIN_POSITIVE;
    let (least, most) = (u.min(v).min(w), u.max(v).max(w));
    let huge = way.simd_ge(LARGEST);
    let may = least.simd_ge(-error) | most.simd_le(error) | huge;
    if !may.any_true() {
        return Sorted { may, sure: may, from: infinity, until: infinity };
    }

    let sum = u + v + w;
    let tight = sum.abs().simd_gt(error * 8.0) & !huge;
    let part = V::simd_from(edge.token(), 1.0) / sum;
    let (near, far) = (a.z.min(b.z).min(c.z), a.z.max(b.z).max(c.z));
    let t = (u * a.z + v * b.z + w * c.z) * part;
    let rounding = way * (16.0 * U) + f32::MIN_POSITIVE;
    let around = (far - near) * (error * 10.0 * part).abs() + rounding;
    let from = tight.select((t - around).max(near - rounding), -infinity);
    let until = tight.select((t + around).min(far + rounding), infinity);
    let may = may & from.simd_le(reach.limit) & until.simd_ge(reach.start);
    let close = edge * 2.0;
    let sure = tight
        & (least.simd_ge(error) | most.simd_le(-error))
        & a.x.abs().simd_le(close)
        & a.y.abs().simd_le(close)
        & from.simd_gt(reach.start)
        & until.simd_lt(reach.end);
    Sorted { may, sure: sure & may, from, until }
}

/// What all packs ask of one ray.
pub(crate) struct PackRay<S: Simd> {
    simd: S,
    /// In the order of `axes`.
    origin: Xyz<f32x4<S>>,
    /// The axis along which the ray goes most, as the last.
    axes: [usize; 3],
    /// The shear that turns the ray onto that axis, and the scale along it.
    shear: Xyz<f32x4<S>>,
    start: f32x4<S>,
    end: f32x4<S>,
    /// As in [`RayPacket`](crate::RayPacket).
    pub(crate) leaves: u32,
}

impl<S: Simd> PackRay<S> {
    /// `scale` is what distances are multiplied by.
    #[inline(always)]
    pub(crate) fn new(simd: S, ray: &Ray, scale: f32) -> Self {
        let axes = turned(ray.direction);
        let along = Vec3::from_array(axes.map(|axis| ray.direction[axis]));
        let shear = Vec3::new(along.x / along.z, along.y / along.z, scale / along.z);
        let ends = [ray.t_min * scale, ray.t_max * scale];
        Self::turned(simd, axes, ray.origin, shear, ends, HitPacket::NOTHING)
    }

    #[inline(always)]
    pub(crate) fn turned(
        simd: S,
        axes: [usize; 3],
        origin: Vec3,
        shear: Vec3,
        [start, end]: [f32; 2],
        leaves: u32,
    ) -> Self {
        Self {
            simd,
            origin: Xyz {
                x: f32x4::splat(simd, origin[axes[0]]),
                y: f32x4::splat(simd, origin[axes[1]]),
                z: f32x4::splat(simd, origin[axes[2]]),
            },
            axes,
            shear: Xyz {
                x: f32x4::splat(simd, shear.x),
                y: f32x4::splat(simd, shear.y),
                z: f32x4::splat(simd, shear.z),
            },
            start: f32x4::splat(simd, start),
            end: f32x4::splat(simd, end),
            leaves,
        }
    }

    #[inline(always)]
    fn sheared(&self, pack: &Pack, vertex: usize) -> Xyz<f32x4<S>> {
        let [x, y, z] = self.axes;
        let corner = Xyz {
            x: pack.vertices[vertex][x % 3].simd_into(self.simd),
            y: pack.vertices[vertex][y % 3].simd_into(self.simd),
            z: pack.vertices[vertex][z % 3].simd_into(self.simd),
        } - self.origin;
        Xyz {
            x: corner.x - corner.z * self.shear.x,
            y: corner.y - corner.z * self.shear.y,
            z: corner.z * self.shear.z,
        }
    }

    /// Sorts out four triangles. The ray enters their leaf's box no farther from its origin than
    /// `way` along any axis, and nothing beyond `limit` matters.
    #[inline(always)]
    pub(crate) fn meet(&self, pack: &Pack, way: f32, limit: f32) -> Sorted<f32x4<S>, mask32x4<S>> {
        let simd = self.simd;
        let corners = [self.sheared(pack, 0), self.sheared(pack, 1), self.sheared(pack, 2)];
        let way = f32x4::splat(simd, way + pack.extent);
        let limit = f32x4::splat(simd, limit);
        let reach = Reach { start: self.start, end: self.end, limit };
        sort_out(corners, pack.edges.simd_into(simd), way, reach)
    }
}

/// The axes in turn, so that the one along which the direction is longest becomes the last.
#[inline(always)]
pub(crate) fn turned(direction: Vec3) -> [usize; 3] {
    let size = direction.abs();
    if size.x > size.y && size.x > size.z {
        [1, 2, 0]
    } else if size.y > size.z {
        [2, 0, 1]
    } else {
        [0, 1, 2]
    }
}
