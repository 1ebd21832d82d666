//! Eight rays at once.
//!
//! The same arithmetic as for one ray, each operation for eight of them: boxes
//! in single precision, triangles in double, in the same order and rounded the
//! same way, so that each of the eight finds the bits that it finds alone.
//!
//! Rays that go the same way share the reading of nodes and triangles, and in
//! any case the reckoning that every ray needs before and after. Where few of
//! the eight go on together they go on one by one.
//!
//! Source: Benthin, Wald, Woop, Ernst, "Combining Single and Packet-Ray Tracing
//! for Arbitrary Ray Distributions on the Intel MIC Architecture", TVCG 2012.

use crate::Ray;
use crate::bvh::{BoxRays, SLACK};
use crate::each;
use crate::lanes::{LANES, Xyz, Xyz8, at, narrow, narrow_mask, widen, widen_mask};
use crate::packs::{Pack, PackRay, Reach, Sorted, sort_out, turned};
use crate::surfaces::Hit;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, f64x8, mask32x8, mask64x8, u32x8};

/// Eight rays; one whose `t_max` is not beyond its `t_min` is not there.
#[derive(Clone, Copy, Debug)]
pub struct RayPacket {
    /// (axis, ray).
    pub origin: [[f32; LANES]; 3],
    /// (axis, ray).
    pub direction: [[f32; LANES]; 3],
    /// As in [`Ray`].
    pub t_min: [f32; LANES],
    /// As in [`Ray`].
    pub t_max: [f32; LANES],
    /// The triangle that each ray starts on and leaves, so that it need not be met again;
    /// [`HitPacket::NOTHING`] if none, or if it is not known: what is found is the same.
    pub leaves: [u32; LANES],
}

impl RayPacket {
    /// No rays.
    pub const NONE: Self = Self {
        origin: [[0.0; LANES]; 3],
        direction: [[0.0; LANES], [0.0; LANES], [1.0; LANES]],
        t_min: [0.0; LANES],
        t_max: [-1.0; LANES],
        leaves: [HitPacket::NOTHING; LANES],
    };

    /// Up to eight rays.
    pub fn new(rays: &[Ray]) -> Self {
        let mut packet = Self::NONE;
        for (lane, ray) in rays.iter().take(LANES).enumerate() {
            packet.set(lane, ray);
        }
        packet
    }

    /// Whether there is a ray.
    #[inline]
    pub fn is_there(&self, lane: usize) -> bool {
        self.t_min[lane] < self.t_max[lane]
    }

    /// Those that are there, a bit for each.
    #[inline(always)]
    pub fn there(&self) -> u32 {
        (0..LANES).fold(0, |bits, lane| bits | u32::from(self.is_there(lane)) << lane)
    }

    /// Takes away all but these.
    #[inline(always)]
    pub fn keep(&mut self, which: u32) {
        for (lane, t_max) in self.t_max.iter_mut().enumerate() {
            if which >> lane & 1 == 0 {
                *t_max = Self::NONE.t_max[lane];
            }
        }
    }

    /// Puts a ray in its place.
    #[inline]
    pub fn set(&mut self, lane: usize, ray: &Ray) {
        for axis in 0..3 {
            self.origin[axis][lane] = ray.origin[axis];
            self.direction[axis][lane] = ray.direction[axis];
        }
        self.t_min[lane] = ray.t_min;
        self.t_max[lane] = ray.t_max;
        self.leaves[lane] = HitPacket::NOTHING;
    }

    /// One of them.
    #[inline]
    pub fn ray(&self, lane: usize) -> Ray {
        Ray {
            origin: at(&self.origin, lane),
            direction: at(&self.direction, lane),
            t_min: self.t_min[lane],
            t_max: self.t_max[lane],
        }
    }
}

/// Where eight rays met surfaces.
#[derive(Clone, Copy, Debug)]
pub struct HitPacket {
    /// The number of the primitive; [`NOTHING`](Self::NOTHING) where there is none, and the other
    /// numbers mean nothing.
    pub primitive: [u32; LANES],
    /// The number of the instance; [`NOTHING`](Self::NOTHING) where the primitive is of none.
    pub instance: [u32; LANES],
    /// As in [`Hit`].
    pub t: [f32; LANES],
    /// As in [`Hit`].
    pub u: [f32; LANES],
    /// As in [`Hit`].
    pub v: [f32; LANES],
    /// (axis, ray); as in [`Hit`].
    pub position: [[f32; LANES]; 3],
    /// (axis, ray); as in [`Hit`].
    pub normal: [[f32; LANES]; 3],
}

impl HitPacket {
    /// The number of no primitive.
    pub const NOTHING: u32 = u32::MAX;

    /// No hits.
    pub const NONE: Self = Self {
        primitive: [Self::NOTHING; LANES],
        instance: [Self::NOTHING; LANES],
        t: [0.0; LANES],
        u: [0.0; LANES],
        v: [0.0; LANES],
        position: [[0.0; LANES]; 3],
        normal: [[0.0; LANES]; 3],
    };

    /// What one of the rays met.
    #[inline]
    pub fn hit(&self, lane: usize) -> Option<Hit> {
        (self.primitive[lane] != Self::NOTHING).then(|| Hit {
            primitive: self.primitive[lane],
            instance: self.instance(lane),
            t: self.t[lane],
            u: self.u[lane],
            v: self.v[lane],
            position: at(&self.position, lane),
            normal: at(&self.normal, lane),
        })
    }

    /// The number of the instance that one of the rays met, if it did.
    #[inline]
    pub fn instance(&self, lane: usize) -> Option<u32> {
        let instance = self.instance[lane];
        (instance != Self::NOTHING).then_some(instance)
    }

    /// Says what one of the rays met, or that it met nothing.
    pub fn set(&mut self, lane: usize, hit: Option<&Hit>) {
        let Some(hit) = hit else {
            self.primitive[lane] = Self::NOTHING;
            return;
        };
        self.primitive[lane] = hit.primitive;
        self.instance[lane] = hit.instance.unwrap_or(Self::NOTHING);
        (self.t[lane], self.u[lane], self.v[lane]) = (hit.t, hit.u, hit.v);
        for axis in 0..3 {
            self.position[axis][lane] = hit.position[axis];
            self.normal[axis][lane] = hit.normal[axis];
        }
    }
}

/// Eight rays made ready for boxes and triangles.
pub(crate) struct RaysReady<S: Simd> {
    pub(crate) boxes: BoxRays<S>,
    /// Nothing beyond this matters, in the units of the boxes.
    pub(crate) limit: f32x8<S>,
    end: f32x8<S>,
    leaves: u32x8<S>,
    /// The shear of `triangle.rs`, and the scale along the ray.
    shear: Xyz8<S>,
    /// The same as the rows of a matrix.
    rows: [Xyz8<S>; 3],
}

/// What `triangle.rs` asks of eight rays.
pub(crate) struct TriangleRays<S: Simd> {
    simd: S,
    origin: Xyz<f64x8<S>>,
    direction: Xyz<f64x8<S>>,
    turn: Turn<S>,
    shear: Xyz<f64x8<S>>,
    t_min: f64x8<S>,
}

/// Where the ray goes most along x, and where along y.
#[derive(Clone, Copy)]
struct Turn<S: Simd> {
    x: mask64x8<S>,
    y: mask64x8<S>,
}

impl<S: Simd> Turn<S> {
    #[inline(always)]
    fn pick(self, x: f64x8<S>, y: f64x8<S>, z: f64x8<S>) -> f64x8<S> {
        self.x.select(x, self.y.select(y, z))
    }

    /// The coordinates in turn, so that the longest axis becomes the third.
    #[inline(always)]
    fn turned(self, p: Xyz<f64x8<S>>) -> Xyz<f64x8<S>> {
        Xyz {
            x: self.pick(p.y, p.z, p.x),
            y: self.pick(p.z, p.x, p.y),
            z: self.pick(p.x, p.y, p.z),
        }
    }
}

/// The nearest hits so far.
pub(crate) struct NearestPacket<S: Simd> {
    pub(crate) t: f64x8<S>,
    pub(crate) primitive: u32x8<S>,
    /// Barycentric weights times `det`.
    v: f64x8<S>,
    w: f64x8<S>,
    det: f64x8<S>,
    corners: [Xyz8<S>; 3],
}

#[inline(always)]
fn is_finite<S: Simd>(v: Xyz8<S>) -> mask32x8<S> {
    let infinity = f32x8::splat(v.x.token(), f32::INFINITY);
    v.x.abs().simd_lt(infinity) & v.y.abs().simd_lt(infinity) & v.z.abs().simd_lt(infinity)
}

/// Where the largest of these is x, and where y.
#[inline(always)]
fn longest_axis<S: Simd>(size: Xyz8<S>) -> [mask32x8<S>; 2] {
    let is_x = size.x.simd_gt(size.y) & size.x.simd_gt(size.z);
    [is_x, !is_x & size.y.simd_gt(size.z)]
}

impl<S: Simd> RaysReady<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, rays: &RayPacket) -> Self {
        let (origin, direction) =
            (Xyz8::load(simd, &rays.origin), Xyz8::load(simd, &rays.direction));
        let t_min: f32x8<S> = rays.t_min.simd_into(simd);
        let t_max: f32x8<S> = rays.t_max.simd_into(simd);
        let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));

        // Boxes.
        let size = each!(direction, d => d.abs());
        let longest = size.largest();
        let there =
            is_finite(origin) & is_finite(direction) & longest.simd_gt(zero) & t_min.simd_lt(t_max);
        let bits: u32x8<S> = longest.bitcast();
        let scale: f32x8<S> =
            (bits & u32x8::splat(simd, 0x7f80_0000)).max(u32x8::splat(simd, 1 << 23)).bitcast();
        let unscale = one / scale;
        let inverse = each!(direction, d => one / (d * unscale));
        let negative = each!(inverse, d => d.simd_lt(zero));
        let boxes = BoxRays { simd, origin, inverse, negative, start: t_min * scale, scale };
        let limit = narrow(widen(t_max) * widen(scale)) * SLACK;
        let limit = there.select(limit, f32x8::splat(simd, f32::NEG_INFINITY));

        // Triangles.
        let [is_x, is_y] = longest_axis(size);
        let Xyz { x: dx, y: dy, z: dz } = direction;
        let along = is_x.select(dx, is_y.select(dy, dz));
        let x = is_x.select(dy, is_y.select(dz, dx)) / along;
        let y = is_x.select(dz, is_y.select(dx, dy)) / along;
        let z = scale / along;
        let (nx, ny) = (-x, -y);
        Self {
            boxes,
            limit,
            end: t_max * scale,
            leaves: rays.leaves.simd_into(simd),
            shear: Xyz { x, y, z },
            rows: [
                Xyz {
                    x: is_x.select(nx, is_y.select(zero, one)),
                    y: is_x.select(one, is_y.select(nx, zero)),
                    z: is_x.select(zero, is_y.select(one, nx)),
                },
                Xyz {
                    x: is_x.select(ny, is_y.select(one, zero)),
                    y: is_x.select(zero, is_y.select(ny, one)),
                    z: is_x.select(one, is_y.select(zero, ny)),
                },
                Xyz {
                    x: is_x.select(z, zero),
                    y: is_y.select(z, zero),
                    z: (is_x | is_y).select(zero, z),
                },
            ],
        }
    }

    /// Those that are there, a bit for each.
    #[inline(always)]
    pub(crate) fn there(&self) -> u32 {
        let nowhere = f32x8::splat(self.boxes.simd, f32::NEG_INFINITY);
        self.limit.simd_gt(nowhere).to_bitmask() as u32
    }

    /// What all packs ask of one of the rays.
    #[inline(always)]
    pub(crate) fn packs(&self, rays: &RayPacket, lane: usize) -> PackRay<S> {
        let ray = rays.ray(lane);
        let shear = self.shear.lane(lane);
        let (axes, ends) = (turned(ray.direction), [self.boxes.start[lane], self.end[lane]]);
        PackRay::turned(self.boxes.simd, axes, ray.origin, shear, ends, rays.leaves[lane])
    }

    #[inline(always)]
    fn sheared(&self, pack: &Pack, vertex: usize, lane: usize) -> Xyz8<S> {
        let (v, simd) = (&pack.vertices[vertex], self.boxes.simd);
        let p = Xyz {
            x: f32x8::splat(simd, v[0][lane]),
            y: f32x8::splat(simd, v[1][lane]),
            z: f32x8::splat(simd, v[2][lane]),
        } - self.boxes.origin;
        Xyz { x: p.dot(self.rows[0]), y: p.dot(self.rows[1]), z: p.dot(self.rows[2]) }
    }

    /// The rays that start on a triangle and leave it.
    #[inline(always)]
    pub(crate) fn leaving(&self, primitive: u32) -> u32 {
        let number = u32x8::splat(self.boxes.simd, primitive);
        self.leaves.simd_eq(number).to_bitmask() as u32
    }

    /// Sorts out one triangle for all rays, which enter its leaf's box at `enter`.
    #[inline(always)]
    pub(crate) fn sort_out(
        &self,
        pack: &Pack,
        lane: usize,
        enter: f32x8<S>,
        limit: f32x8<S>,
    ) -> Sorted<f32x8<S>, mask32x8<S>> {
        let corners =
            [self.sheared(pack, 0, lane), self.sheared(pack, 1, lane), self.sheared(pack, 2, lane)];
        let edge = f32x8::splat(self.boxes.simd, pack.edges[lane]);
        let way = enter * (2.0 * SLACK) + pack.extent;
        sort_out(corners, edge, way, Reach { start: self.boxes.start, end: self.end, limit })
    }
}

impl<S: Simd> TriangleRays<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, rays: &RayPacket) -> Self {
        let direction = Xyz8::load(simd, &rays.direction);
        let [is_x, is_y] = longest_axis(each!(direction, d => d.abs()));
        let turn = Turn { x: widen_mask(is_x), y: widen_mask(is_y) };
        let direction = each!(direction, d => widen(d));
        let along = turn.turned(direction);
        let origin = Xyz8::load(simd, &rays.origin);
        Self {
            simd,
            origin: each!(origin, o => widen(o)),
            direction,
            turn,
            shear: Xyz {
                x: along.x / along.z,
                y: along.y / along.z,
                z: f64x8::splat(simd, 1.0) / along.z,
            },
            t_min: widen(rays.t_min.simd_into(simd)),
        }
    }

    /// The triangle `corners` of each ray, exactly: the arithmetic of `triangle.rs`.
    #[inline(always)]
    pub(crate) fn meet(
        &self,
        corners: &[[[f32; LANES]; 3]; 3],
        primitive: u32x8<S>,
        nearest: &mut NearestPacket<S>,
    ) {
        let simd = self.simd;
        let nil = f64x8::splat(simd, 0.0);
        let single = [
            Xyz8::load(simd, &corners[0]),
            Xyz8::load(simd, &corners[1]),
            Xyz8::load(simd, &corners[2]),
        ];
        let [a, b, c] = single;
        let (a, b, c) = (each!(a, v => widen(v)), each!(b, v => widen(v)), each!(c, v => widen(v)));
        let from_origin = a - self.origin;
        let (p, q, r) = (
            self.sheared(from_origin),
            self.sheared(b - self.origin),
            self.sheared(c - self.origin),
        );
        let u = r.x * q.y - r.y * q.x;
        let v = p.x * r.y - p.y * r.x;
        let w = q.x * p.y - q.y * p.x;
        let some_less = u.min(v).min(w).simd_lt(nil);
        let some_more = u.max(v).max(w).simd_gt(nil);
        let det = u + v + w;
        let there = primitive.simd_ne(u32x8::splat(simd, HitPacket::NOTHING));
        let mut met = !(some_less & some_more) & !det.simd_eq(nil) & widen_mask(there);

        let sz = self.shear.z;
        let in_front = (p.z * sz).min(q.z * sz).min(r.z * sz).simd_gt(nil);
        let mut t = sz * ((u * p.z + v * q.z + w * r.z) / det);
        if (met & !in_front).any_true() {
            let normal = (b - a).cross(c - a);
            let height = normal.dot(from_origin);
            let size = each!(normal, n => n.abs()).dot(each!(from_origin, p => p.abs()));
            let off = height.abs().simd_gt(size * (16.0 * f64::EPSILON));
            t = in_front.select(t, height / normal.dot(self.direction));
            met &= in_front | off;
        }
        let sooner = t.simd_lt(nearest.t)
            | (t.simd_eq(nearest.t) & widen_mask(primitive.simd_lt(nearest.primitive)));
        met &= t.simd_gt(self.t_min) & sooner;
        nearest.t = met.select(t, nearest.t);
        nearest.v = met.select(v, nearest.v);
        nearest.w = met.select(w, nearest.w);
        nearest.det = met.select(det, nearest.det);
        let met = narrow_mask(met);
        nearest.primitive = met.select(primitive, nearest.primitive);
        for (kept, new) in nearest.corners.iter_mut().zip(single) {
            kept.x = met.select(new.x, kept.x);
            kept.y = met.select(new.y, kept.y);
            kept.z = met.select(new.z, kept.z);
        }
    }

    #[inline(always)]
    fn sheared(&self, p: Xyz<f64x8<S>>) -> Xyz<f64x8<S>> {
        let p = self.turn.turned(p);
        Xyz { x: p.x - self.shear.x * p.z, y: p.y - self.shear.y * p.z, z: p.z }
    }
}

impl<S: Simd> NearestPacket<S> {
    #[inline(always)]
    pub(crate) fn none(simd: S, rays: &RayPacket) -> Self {
        let nil = f64x8::splat(simd, 0.0);
        let t_max: f32x8<S> = rays.t_max.simd_into(simd);
        let none = f32x8::splat(simd, 0.0);
        Self {
            t: widen(t_max),
            primitive: u32x8::splat(simd, HitPacket::NOTHING),
            v: nil,
            w: nil,
            det: f64x8::splat(simd, 1.0),
            corners: [Xyz { x: none, y: none, z: none }; 3],
        }
    }

    /// Where exactly; rounded once at the end.
    #[inline(always)]
    pub(crate) fn finished(&self) -> HitPacket {
        let [a, b, c] = self.corners;
        let (a, b, c) = (each!(a, v => widen(v)), each!(b, v => widen(v)), each!(c, v => widen(v)));
        let (u, v) = (self.v / self.det, self.w / self.det);
        let (p, q) = (b - a, c - a);
        let position = a + p.scaled(u) + q.scaled(v);
        let n = p.cross(q);
        let size = each!(n, n => n.abs());
        let size = size.x.max(size.y).max(size.z);
        let n = each!(n, n => n / size);
        let length = n.dot(n).sqrt();
        let normal = each!(n, n => narrow(n / length));
        HitPacket {
            primitive: self.primitive.into(),
            instance: [HitPacket::NOTHING; LANES],
            t: narrow(self.t).into(),
            u: narrow(u).into(),
            v: narrow(v).into(),
            position: each!(position, p => narrow(p)).store(),
            normal: normal.store(),
        }
    }
}
