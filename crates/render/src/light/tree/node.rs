//! A node of the light tree: eight groups of emitters, and how much light each may bring.
//!
//! What a group brings to a point is estimated from its bounds: intensity over squared distance,
//! times how much of that it sends there, times the cosine under which the surface sees it, each
//! as it is on average over the group's box. Where the bounds say that nothing can arrive, because
//! the box lies below the surface's horizon or all lamps in it face away, the estimate is 0, and
//! only there.
//!
//! Source: Conty Estevez, Kulla, "Importance Sampling of Many Lights with Adaptive Tree
//! Splitting", HPG 2018, section 4.2; Pharr, Jakob, Humphreys, *Physically Based Rendering*,
//! 4th ed., section 12.6.3.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8};
use rutilant_geom::Vec3;
use rutilant_geom::lanes::{LANES, Xyz, Xyz8};

/// Groups in a node. Eight are told apart with one look: a tree of pairs would look three times,
/// each time at coarser bounds.
pub(super) const WIDTH: usize = LANES;

/// What stands behind a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Child {
    /// Nothing.
    None,
    /// The node of this number.
    Node(u32),
    /// The emitter of this number, alone.
    Emitter(u32),
}

impl Child {
    /// The highest bit tells emitters from nodes; all bits are set where there is nothing.
    const EMITTER: u32 = 1 << 31;

    fn packed(self) -> u32 {
        match self {
            Self::None => u32::MAX,
            Self::Node(number) => number,
            Self::Emitter(number) => number | Self::EMITTER,
        }
    }

    fn unpacked(word: u32) -> Self {
        match word {
            u32::MAX => Self::None,
            node if node & Self::EMITTER == 0 => Self::Node(node),
            emitter => Self::Emitter(emitter & !Self::EMITTER),
        }
    }
}

/// Bounds of a group, in the coordinates of the tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group {
    /// The middle of its box.
    pub(super) center: Vec3,
    /// Half the lengths of the box's sides.
    pub(super) half: Vec3,
    /// As in `EmitterBounds`, of all its emitters.
    pub(super) axis: Vec3,
    pub(super) cos_normals: f32,
    pub(super) cos_shines: f32,
    pub(super) two_sided: bool,
    /// The part of its intensity, relative to that of the node's brightest group, that it sends
    /// everywhere alike.
    pub(super) even: f32,
    /// The part that falls with the cosine to the axis.
    pub(super) directed: f32,
}

/// A point to be lit, in the coordinates of the tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seer {
    /// Where.
    pub(super) position: Vec3,
    /// The unit normal on the side that is lit; zero where light counts from everywhere.
    pub(super) normal: Vec3,
}

/// Eight groups. Arrays are by group, so that all are looked at together.
#[derive(Clone, Debug)]
#[repr(align(32))]
pub(super) struct Node {
    center: [[f32; WIDTH]; 3],
    half: [[f32; WIDTH]; 3],
    axis: [[f32; WIDTH]; 3],
    cos_normals: [f32; WIDTH],
    cos_shines: [f32; WIDTH],
    /// 1 where it shines along both directions of its axis, else 0.
    back: [f32; WIDTH],
    even: [f32; WIDTH],
    directed: [f32; WIDTH],
    children: [u32; WIDTH],
}

/// How much each group of a node may bring, and all of them together.
pub(super) struct Shares {
    pub(super) each: [f32; WIDTH],
    pub(super) total: f32,
}

impl Node {
    /// A node without groups.
    pub(super) const EMPTY: Self = Self {
        center: [[0.0; WIDTH]; 3],
        half: [[0.0; WIDTH]; 3],
        axis: [[0.0; WIDTH], [0.0; WIDTH], [1.0; WIDTH]],
        cos_normals: [1.0; WIDTH],
        cos_shines: [0.0; WIDTH],
        back: [0.0; WIDTH],
        even: [0.0; WIDTH],
        directed: [0.0; WIDTH],
        children: [u32::MAX; WIDTH],
    };

    pub(super) fn set(&mut self, i: usize, group: &Group) {
        for axis in 0..3 {
            self.center[axis][i] = group.center[axis];
            self.half[axis][i] = group.half[axis];
            self.axis[axis][i] = group.axis[axis];
        }
        self.cos_normals[i] = group.cos_normals;
        self.cos_shines[i] = group.cos_shines;
        self.back[i] = if group.two_sided { 1.0 } else { 0.0 };
        self.even[i] = group.even;
        self.directed[i] = group.directed;
    }

    pub(super) fn set_child(&mut self, i: usize, child: Child) {
        self.children[i] = child.packed();
    }

    /// The same node where all nodes below it have numbers that are larger by `offset`.
    pub(super) fn moved(mut self, offset: u32) -> Self {
        for i in 0..WIDTH {
            if let Child::Node(number) = self.child(i) {
                self.set_child(i, Child::Node(number + offset));
            }
        }
        self
    }

    #[inline]
    pub(super) fn child(&self, i: usize) -> Child {
        Child::unpacked(self.children[i])
    }

    /// How much of its light each group may bring to a point. All are 0 where none brings any.
    #[inline(always)]
    pub(super) fn shares<S: Simd>(&self, simd: S, seer: &Seer) -> Shares {
        let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
        let smallest = f32x8::splat(simd, SMALLEST);
        let [px, py, pz] = seer.position.to_array().map(|p| f32x8::splat(simd, p));
        let way = Xyz { x: px, y: py, z: pz } - Xyz8::load(simd, &self.center);
        let half = Xyz8::load(simd, &self.half);
        let (distance2, radius2) = (way.dot(way).max(smallest), half.dot(half));
        let per_length = one / distance2.sqrt();

        // The angle that the ball around its box is seen under; all around from inside.
        let sin2_ball = radius2 / distance2;
        let inside = sin2_ball.simd_ge(one);
        let sin_ball = sin2_ball.sqrt();
        let cos_ball = (one - sin2_ball).max(zero).sqrt();

        // The least angle at which it shines here, from a normal.
        let axis = Xyz8::load(simd, &self.axis);
        let back: f32x8<S> = self.back.simd_into(simd);
        let height = axis.dot(way);
        let along = height * per_length;
        let cos_axis = along.max(along.abs() * back - (one - back));
        let sin_axis = sines(cos_axis);
        let cos_normals: f32x8<S> = self.cos_normals.simd_into(simd);
        let sin_normals = sines(cos_normals);
        let cos_off = cos_axis * cos_normals + sin_axis * sin_normals;
        let sin_off = sin_axis * cos_normals - cos_axis * sin_normals;
        let straight = inside | cos_axis.simd_ge(cos_normals) | cos_off.simd_ge(cos_ball);
        let cos_leaves = straight.select(one, cos_off * cos_ball + sin_off * sin_ball);
        let cos_shines: f32x8<S> = self.cos_shines.simd_into(simd);
        let shines = cos_leaves.simd_gt(cos_shines);

        // What it sends here. Nearer than its own size it does not get brighter.
        let distance2 = distance2.max(radius2 * f32x8::splat(simd, NEAREST));
        let per_length = one / distance2.sqrt();
        let reach = axis.x.abs() * half.x + axis.y.abs() * half.y + axis.z.abs() * half.z;
        let front = mean_height(height, reach) + back * mean_height(-height, reach);
        let even: f32x8<S> = self.even.simd_into(simd);
        let directed: f32x8<S> = self.directed.simd_into(simd);
        let sent = even + directed * (front * per_length).min(one);
        let mut light = shines.select(sent / distance2, zero);

        // The cosine under which the surface sees it.
        if seer.normal != Vec3::ZERO {
            let [nx, ny, nz] = seer.normal.to_array().map(|n| f32x8::splat(simd, -n));
            let height = nx * way.x + ny * way.y + nz * way.z;
            let reach = nx.abs() * half.x + ny.abs() * half.y + nz.abs() * half.z;
            light *= (mean_height(height, reach) * per_length).min(one);
        }

        let each: [f32; WIDTH] = light.into();
        let [a, b, c, d, e, f, g, h] = each;
        let total = ((a + b) + (c + d)) + ((e + f) + (g + h));
        if total < f32::INFINITY {
            return Shares { each, total };
        }
        // Where numbers end, all are as good as each other.
        let each = self.children.map(|child| if child == u32::MAX { 0.0 } else { 1.0 });
        Shares { each, total: each.iter().sum() }
    }
}

/// Keeps divisions finite.
const SMALLEST: f32 = 1e-30;

/// The least squared distance that counts, in squared radii of a group's ball.
const NEAREST: f32 = 0.25;

/// The mean height above the horizon, below which it counts as 0, of what extends up and down by
/// `reach` from `height`.
#[inline(always)]
fn mean_height<S: Simd>(height: f32x8<S>, reach: f32x8<S>) -> f32x8<S> {
    let simd = height.token();
    let [zero, quarter, smallest] = [0.0, 0.25, SMALLEST].map(|x| f32x8::splat(simd, x));
    let top = (height + reach).max(zero);
    let across = top * top * quarter / reach.max(smallest);
    height.simd_ge(reach).select(height, across)
}

/// The sines of angles of 0 to π, of which these are the cosines.
#[inline(always)]
fn sines<S: Simd>(cosine: f32x8<S>) -> f32x8<S> {
    let simd = cosine.token();
    (f32x8::splat(simd, 1.0) - cosine * cosine).max(f32x8::splat(simd, 0.0)).sqrt()
}
