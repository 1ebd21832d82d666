//! A ray goes through the tree.
//!
//! Boxes are met in single precision, and never missed: the far side is moved
//! out by more than rounding can do to both sides. The nearest child comes
//! first; the others wait on a stack, which the builder's bound on the depth
//! makes large enough.
//!
//! Source: Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013, with a little more
//! slack than its 2γ(3), for the last culling by a distance that was rounded.

use super::binary::MAX_DEPTH;
use super::wide::{Inside, PACK, WIDTH, WideNode};
use crate::lanes::{LANES, Xyz, Xyz8, each_lane};
use crate::packs::Pack;
use crate::{Ray, Vec3};
use arrayvec::ArrayVec;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, mask32x8};

/// Whether the nearest child is to come first.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Order {
    /// For the closest hit.
    Nearest,
    /// For any hit.
    Any,
}

/// A leaf that a ray may meet something in.
#[derive(Clone, Copy)]
pub(crate) struct Met {
    pub(crate) inside: Inside,
    /// The ray comes into the leaf's box no farther from its origin than this, along any axis.
    pub(crate) way: f32,
}

impl Met {
    #[inline(always)]
    fn new(leaf: Waiting) -> Self {
        Self { inside: leaf.inside(), way: way(leaf.enter()) }
    }
}

/// Calls `leaf` for every leaf that the ray may meet before `limit`, from this part of the tree on,
/// which it enters at `enter`. `leaf` may lower the limit; it tells when it is enough.
#[inline(always)]
pub(crate) fn traverse(
    nodes: &[WideNode],
    boxes: &impl Boxes,
    order: Order,
    (inside, enter): (Inside, f32),
    limit: &mut f32,
    mut leaf: impl FnMut(Met, &mut f32) -> bool,
) {
    let (mut stack, mut next) = (Stack::new(), Waiting::new(enter, inside));
    loop {
        if let Some(number) = next.inside().as_node() {
            let Some(node) = nodes.get(number) else { return };
            if go_into(node, boxes, order, *limit, &mut stack, &mut next) {
                continue;
            }
        } else if leaf(Met::new(next), limit) {
            return;
        }
        if !take_up(*limit, &mut stack, &mut next) {
            return;
        }
    }
}

/// The same for eight rays from the root on, one step of each in turn: while one waits for memory
/// the others go on. `leaf` is told whose leaf it is, and `touch` reads something of each part that
/// is visited a turn later. Only the rays `which` go.
#[inline(always)]
pub(crate) fn traverse_in_turn<S: Simd>(
    nodes: &[WideNode],
    boxes: &[BoxRay<S>; LANES],
    mut which: u32,
    order: Order,
    limits: &mut [f32; LANES],
    touch: impl Fn(Inside) -> u32,
    mut leaf: impl FnMut(usize, Met, &mut f32) -> bool,
) {
    // Written out: in any other way of saying it each is copied, with all that is not there yet.
    let mut stacks: [Stack; LANES] = [
        Stack::new(),
        Stack::new(),
        Stack::new(),
        Stack::new(),
        Stack::new(),
        Stack::new(),
        Stack::new(),
        Stack::new(),
    ];
    let mut all = [Waiting::new(0.0, Inside::node(0)); LANES];
    let mut touched = 0;
    while which != 0 {
        for lane in each_lane(which) {
            let (stack, limit) = (&mut stacks[lane], &mut limits[lane]);
            let mut next = all[lane];
            let more = if let Some(number) = next.inside().as_node() {
                let Some(node) = nodes.get(number) else { return };
                go_into(node, &boxes[lane], order, *limit, stack, &mut next)
                    || take_up(*limit, stack, &mut next)
            } else {
                !leaf(lane, Met::new(next), limit) && take_up(*limit, stack, &mut next)
            };
            if more {
                touched ^= touch(next.inside());
            } else {
                which &= !(1 << lane);
            }
            all[lane] = next;
        }
    }
    std::hint::black_box(touched);
}

/// What one ray has put off. Each node above leaves at most all its children but one.
type Stack = ArrayVec<Waiting, { (WIDTH - 1) * (MAX_DEPTH + 1) }>;

/// Goes on with the nearest child that the ray enters before `limit`, and puts off the others.
#[inline(always)]
fn go_into(
    node: &WideNode,
    boxes: &impl Boxes,
    order: Order,
    limit: f32,
    stack: &mut Stack,
    next: &mut Waiting,
) -> bool {
    let (mut met, enter) = boxes.meet(node, limit);
    if met == 0 {
        return false;
    }
    let take = |met: &mut u32| {
        let lane = met.trailing_zeros() as usize % WIDTH;
        *met &= *met - 1;
        Waiting::new(enter[lane], node.inside[lane])
    };
    *next = take(&mut met);
    let before = stack.len();
    while met != 0 {
        let other = take(&mut met);
        if order == Order::Any {
            stack.push(other);
            continue;
        }
        // The nearest goes on, the nearer of the others lies on top.
        stack.push(other.max(*next));
        *next = other.min(*next);
        let mut place = stack.len() - 1;
        while place > before && stack[place - 1] < stack[place] {
            stack.swap(place - 1, place);
            place -= 1;
        }
    }
    true
}

/// Takes up what was put off last, unless a hit was found before it.
#[inline(always)]
fn take_up(limit: f32, stack: &mut Stack, next: &mut Waiting) -> bool {
    while let Some(waiting) = stack.pop() {
        if waiting.enter() <= limit {
            *next = waiting;
            return true;
        }
    }
    false
}

/// What is still to be visited, below where the ray enters its box: in one number, so that it is
/// kept and compared at once. Positive numbers have the order of their bits.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Waiting(u64);

impl Waiting {
    #[inline(always)]
    fn new(enter: f32, inside: Inside) -> Self {
        Self(u64::from(enter.to_bits()) << 32 | u64::from(inside.bits()))
    }

    #[inline(always)]
    fn enter(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }

    #[inline(always)]
    fn inside(self) -> Inside {
        Inside::from_bits(self.0 as u32)
    }
}

/// What is still to be visited by eight rays, and where each enters it; no number where one does not.
#[derive(Clone, Copy)]
struct WaitingPacket {
    inside: Inside,
    enter: [f32; LANES],
}

/// Fewer rays than this go on alone.
const TOGETHER: u32 = 3;

/// The same for eight rays, each with its limit. Calls `visit` for every leaf that some may meet, and
/// for every part of the tree that only few may: they go on through it alone.
#[inline(always)]
pub(crate) fn traverse_packet<S: Simd>(
    nodes: &[WideNode],
    boxes: &BoxRays<S>,
    limit: &mut f32x8<S>,
    mut visit: impl FnMut(Visit<S>, &mut f32x8<S>),
) {
    let simd = boxes.simd;
    let nowhere = f32x8::splat(simd, f32::NAN);
    let mut stack = ArrayVec::<WaitingPacket, { (WIDTH - 1) * (MAX_DEPTH + 1) }>::new();
    let mut next = WaitingPacket { inside: Inside::node(0), enter: boxes.start.into() };
    loop {
        let enter: f32x8<S> = next.enter.simd_into(simd);
        let active = enter.simd_le(*limit);
        let mask = active.to_bitmask() as u32;
        let count = mask.count_ones();
        if let Some(number) = next.inside.as_node()
            && count >= TOGETHER
        {
            let Some(node) = nodes.get(number) else { return };
            let lead = mask.trailing_zeros() as usize % LANES;
            let before = stack.len();
            let mut keys = ArrayVec::<f32, WIDTH>::new();
            for child in 0..WIDTH {
                if node.sides[0][0][child] == f32::INFINITY {
                    break;
                }
                let (met, enter) = boxes.meet(node, child, *limit);
                let met = met & active;
                if met.any_true() {
                    let key = enter[lead];
                    let enter: [f32; LANES] = met.select(enter, nowhere).into();
                    let mut at = keys.len();
                    keys.push(key);
                    stack.push(WaitingPacket { inside: node.inside[child], enter });
                    while at > 0 && keys[at - 1] < keys[at] {
                        keys.swap(at - 1, at);
                        stack.swap(before + at - 1, before + at);
                        at -= 1;
                    }
                }
            }
        } else if count > 0 {
            visit(Visit { inside: next.inside, enter, mask }, limit);
        }
        let Some(waiting) = stack.pop() else { return };
        next = waiting;
    }
}

/// Part of the tree that some of eight rays may meet.
pub(crate) struct Visit<S: Simd> {
    pub(crate) inside: Inside,
    /// Where each ray enters it.
    pub(crate) enter: f32x8<S>,
    /// Which rays, a bit for each.
    pub(crate) mask: u32,
}

impl<S: Simd> Visit<S> {
    /// Whether there are enough rays to meet the triangles of a leaf together, one after the other,
    /// instead of each ray whole packs.
    #[inline(always)]
    pub(crate) fn together(&self, packs: &[Pack]) -> bool {
        let Some(last) = packs.last() else { return false };
        let triangles = (packs.len() - 1) * PACK + last.len();
        // About so many instructions each takes.
        const EACH: usize = 90;
        const ALONE: usize = 60;
        triangles * EACH <= self.mask.count_ones() as usize * (packs.len() * EACH + ALONE)
    }
}

/// What all boxes ask of eight rays.
pub(crate) struct BoxRays<S: Simd> {
    pub(crate) simd: S,
    pub(crate) origin: Xyz8<S>,
    pub(crate) inverse: Xyz8<S>,
    pub(crate) negative: Xyz<mask32x8<S>>,
    pub(crate) start: f32x8<S>,
    pub(crate) scale: f32x8<S>,
}

impl<S: Simd> BoxRays<S> {
    /// Whether all rays of a set go up, or all down, along each axis.
    #[inline(always)]
    pub(crate) fn go_alike(&self, which: u32) -> bool {
        let alike = |negative: mask32x8<S>| {
            let down = negative.to_bitmask() as u32 & which;
            down == 0 || down == which
        };
        alike(self.negative.x) & alike(self.negative.y) & alike(self.negative.z)
    }

    /// Which rays enter a box before their `limit`, and where.
    #[inline(always)]
    fn meet(&self, node: &WideNode, child: usize, limit: f32x8<S>) -> (mask32x8<S>, f32x8<S>) {
        let simd = self.simd;
        let mut enter = self.start;
        let mut exit = f32x8::splat(simd, f32::INFINITY);
        macro_rules! axis {
            ($i:literal, $axis:ident) => {
                let low = splat(simd, node.sides[$i][0][child]);
                let high = splat(simd, node.sides[$i][1][child]);
                let near = self.negative.$axis.select(high, low);
                let far = self.negative.$axis.select(low, high);
                enter = greater((near - self.origin.$axis) * self.inverse.$axis, enter);
                exit = less((far - self.origin.$axis) * self.inverse.$axis, exit);
            };
        }
        axis!(0, x);
        axis!(1, y);
        axis!(2, z);
        (enter.simd_le(less(exit * SLACK, limit)), enter)
    }

    /// One of them.
    #[inline(always)]
    pub(crate) fn one(&self, lane: usize) -> BoxRay<S> {
        let (origin, inverse) = (self.origin.lane(lane), self.inverse.lane(lane));
        BoxRay::ready(self.simd, origin, inverse, self.start[lane], self.scale[lane])
    }
}

/// Tells which boxes of a node a ray meets.
pub(crate) trait Boxes {
    /// Which boxes the ray enters before `limit`, a bit for each; and where it enters them.
    fn meet(&self, node: &WideNode, limit: f32) -> (u32, [f32; WIDTH]);
}

/// More than twice Ize's 2γ(3) = 7.2e-7.
pub(crate) const SLACK: f32 = 1.0 + 1.0 / (1 << 19) as f32;

/// What all boxes ask of one ray.
pub(crate) struct BoxRay<S: Simd> {
    simd: S,
    origin: [f32x8<S>; 3],
    inverse: [f32x8<S>; 3],
    /// For each axis, which side of a box the ray meets first.
    near: [usize; 3],
    start: f32x8<S>,
    /// Distances here are in units of the ray's `t` times this power of two: the
    /// direction is scaled to a size near one, so that nothing under- or overflows.
    pub(crate) scale: f32,
}

impl<S: Simd> BoxRay<S> {
    /// `None` for a ray with a NaN or an infinity, or without a direction.
    #[inline(always)]
    pub(crate) fn new(simd: S, ray: &Ray) -> Option<Self> {
        let size = ray.direction.abs().max_element();
        let meets = ray.origin.is_finite()
            && ray.direction.is_finite()
            && size > 0.0
            && ray.t_min < ray.t_max;
        if !meets {
            return None;
        }
        let scale = power_of_two_near(size);
        // Both exact.
        let inverse = 1.0 / (ray.direction * (1.0 / scale));
        Some(Self::ready(simd, ray.origin, inverse, ray.t_min * scale, scale))
    }

    /// One of several rays that were made ready together.
    #[inline(always)]
    pub(crate) fn ready(simd: S, origin: Vec3, inverse: Vec3, start: f32, scale: f32) -> Self {
        Self {
            simd,
            origin: [splat(simd, origin.x), splat(simd, origin.y), splat(simd, origin.z)],
            inverse: [splat(simd, inverse.x), splat(simd, inverse.y), splat(simd, inverse.z)],
            near: [first(inverse.x), first(inverse.y), first(inverse.z)],
            start: splat(simd, start),
            scale,
        }
    }
}

impl<S: Simd> Boxes for BoxRay<S> {
    #[inline(always)]
    fn meet(&self, node: &WideNode, limit: f32) -> (u32, [f32; WIDTH]) {
        let simd = self.simd;
        let mut enter = self.start;
        let mut exit = f32x8::splat(simd, f32::INFINITY);
        for axis in 0..3 {
            let side = self.near[axis] & 1;
            let side_at = |side: usize| -> f32x8<S> { node.sides[axis][side].simd_into(simd) };
            let near = (side_at(side) - self.origin[axis]) * self.inverse[axis];
            let far = (side_at(side ^ 1) - self.origin[axis]) * self.inverse[axis];
            // A ray within a side of a box, parallel to it, makes 0 · ∞ = NaN here, which is not
            // taken over.
            enter = greater(near, enter);
            exit = less(far, exit);
        }
        let met = enter.simd_le(less(exit * SLACK, f32x8::splat(simd, limit)));
        (met.to_bitmask() as u32, enter.into())
    }
}

/// What boxes ask of one ray that are larger than their nodes say, by some room on each side.
pub(crate) struct RoomyBoxRay<S: Simd> {
    simd: S,
    /// The origin as the near sides see it, and as the far sides do.
    origins: [[f32x8<S>; 2]; 3],
    inverse: [f32x8<S>; 3],
    near: [usize; 3],
}

impl<S: Simd> RoomyBoxRay<S> {
    /// A ray that starts at `origin`; `direction` has a size near one.
    #[inline(always)]
    pub(crate) fn new(simd: S, origin: Vec3, direction: Vec3, room: Vec3) -> Self {
        let inverse = 1.0 / direction;
        let ahead = room.copysign(inverse);
        let (near, far) = (origin + ahead, origin - ahead);
        Self {
            simd,
            origins: [
                [splat(simd, near.x), splat(simd, far.x)],
                [splat(simd, near.y), splat(simd, far.y)],
                [splat(simd, near.z), splat(simd, far.z)],
            ],
            inverse: [splat(simd, inverse.x), splat(simd, inverse.y), splat(simd, inverse.z)],
            near: [first(inverse.x), first(inverse.y), first(inverse.z)],
        }
    }
}

impl<S: Simd> Boxes for RoomyBoxRay<S> {
    #[inline(always)]
    fn meet(&self, node: &WideNode, limit: f32) -> (u32, [f32; WIDTH]) {
        let simd = self.simd;
        let mut enter = splat(simd, 0.0);
        let mut exit = splat(simd, f32::INFINITY);
        for axis in 0..3 {
            let side = self.near[axis] & 1;
            let side_at = |side: usize| -> f32x8<S> { node.sides[axis][side].simd_into(simd) };
            let [near, far] = self.origins[axis];
            enter = greater((side_at(side) - near) * self.inverse[axis], enter);
            exit = less((side_at(side ^ 1) - far) * self.inverse[axis], exit);
        }
        let met = enter.simd_le(less(exit * SLACK, splat(simd, limit)));
        (met.to_bitmask() as u32, enter.into())
    }
}

/// A box that is entered beyond this holds no hit before `reach`, a ray's `t`. `scale` is that of
/// the [`BoxRay`].
#[inline(always)]
pub(crate) fn limit_of(reach: f64, scale: f32) -> f32 {
    (reach * f64::from(scale)) as f32 * SLACK
}

/// How far along any axis a ray comes until `enter`.
#[inline(always)]
pub(crate) fn way(enter: f32) -> f32 {
    // The scaled direction is shorter than two along each axis.
    2.0 * SLACK * enter
}

#[inline(always)]
fn splat<S: Simd>(simd: S, v: f32) -> f32x8<S> {
    f32x8::splat(simd, v)
}

/// Which side of a box is met first.
#[inline(always)]
fn first(d: f32) -> usize {
    usize::from(d.is_sign_negative())
}

/// The greater of each two numbers; the second where the first is no number.
#[inline(always)]
pub(crate) fn greater<S: Simd>(a: f32x8<S>, b: f32x8<S>) -> f32x8<S> {
    if cfg!(any(target_arch = "x86", target_arch = "x86_64")) { a.max(b) } else { a.max_precise(b) }
}

/// The less of each two numbers; the second where the first is no number.
#[inline(always)]
pub(crate) fn less<S: Simd>(a: f32x8<S>, b: f32x8<S>) -> f32x8<S> {
    if cfg!(any(target_arch = "x86", target_arch = "x86_64")) { a.min(b) } else { a.min_precise(b) }
}

/// The power of two that brings a positive finite number close to one. Exact to divide by.
fn power_of_two_near(size: f32) -> f32 {
    // The exponent bits alone; what is subnormal is at least brought up far.
    f32::from_bits((size.to_bits() & 0x7f80_0000).max(1 << 23))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Aabb;
    use crate::simd::Simd;
    use fearless_simd::dispatch;

    /// Whether a box is met, with all instructions that there are.
    fn meets(bounds: Aabb, ray: &Ray) -> bool {
        let mut node = WideNode::EMPTY;
        node.put(5, &bounds, Inside::node(1));
        let levels = [Simd::Auto, Simd::Scalar, Simd::Sse4, Simd::Avx2].map(Simd::level);
        let mut met = levels.into_iter().flatten().map(|level| {
            dispatch!(level, simd => {
                let ray = BoxRay::new(simd, ray).expect("a proper ray");
                ray.meet(&node, f32::INFINITY).0
            })
        });
        let first = met.next().expect("the best level");
        assert!(met.all(|other| other == first), "{bounds:?} {ray:?}");
        assert!(first & !(1 << 5) == 0, "boxes that are not there");
        first != 0
    }

    /// A ray that runs within a side of a box, along an edge or through a corner meets it.
    #[test]
    fn rays_in_the_sides_of_a_box_are_not_lost() {
        let unit = Aabb { min: Vec3::ZERO, max: Vec3::ONE };
        for axis in 0..3 {
            for sign in [1.0, -1.0] {
                let mut direction = Vec3::ZERO;
                direction[axis] = sign;
                for zero in [0.0, -0.0] {
                    direction[(axis + 1) % 3] = zero;
                    direction[(axis + 2) % 3] = -zero;
                    for corner in 0..9 {
                        let mut origin = Vec3::ZERO;
                        origin[axis] = 0.5 - 2.0 * sign;
                        origin[(axis + 1) % 3] = 0.5 * (corner % 3) as f32;
                        origin[(axis + 2) % 3] = 0.5 * (corner / 3) as f32;
                        assert!(meets(unit, &Ray::new(origin, direction)), "{origin} {direction}");
                        origin[(axis + 1) % 3] = 1.0_f32.next_up();
                        assert!(!meets(unit, &Ray::new(origin, direction)), "{origin} {direction}");
                    }
                }
            }
        }
    }

    /// Flat boxes, tiny and huge directions: nothing under- or overflows.
    #[test]
    fn directions_of_any_length_meet_the_same_boxes() {
        for exponent in -126..=127 {
            let size = f32::from_bits(((exponent + 127) as u32) << 23);
            for thing in [1e-10, 1.0, 1e10] {
                let flat = Aabb { min: Vec3::new(-1.0, -1.0, 2.0), max: Vec3::new(1.0, 1.0, 2.0) };
                let flat = Aabb { min: flat.min * thing, max: flat.max * thing };
                let towards = Vec3::new(0.3, -0.4, 1.0) * size;
                assert!(meets(flat, &Ray::new(Vec3::ZERO, towards)), "{size:e} {thing:e}");
                let past = Vec3::new(0.3, -0.6, 1.0) * size;
                assert!(!meets(flat, &Ray::new(Vec3::ZERO, past)), "{size:e} {thing:e}");
            }
        }
    }
}
