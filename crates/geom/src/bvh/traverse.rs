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
use super::wide::{Inside, WIDTH, WideNode};
use crate::Ray;
use arrayvec::ArrayVec;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8};

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

/// Calls `leaf` for every leaf that the ray may meet before its reach. `leaf` gives the reach from
/// then on, a ray's `t`; `None` when it is enough.
#[inline(always)]
pub(crate) fn traverse<S: Simd>(
    simd: S,
    nodes: &[WideNode],
    ray: &Ray,
    order: Order,
    mut leaf: impl FnMut(Met) -> Option<f64>,
) {
    let Some(boxes) = BoxRay::new(simd, ray) else { return };
    let mut limit = boxes.limit(f64::from(ray.t_max));
    // Each node above leaves at most all its children but one.
    let mut stack = ArrayVec::<Waiting, { (WIDTH - 1) * (MAX_DEPTH + 1) }>::new();
    let mut next = Waiting::new(0.0, Inside::node(0));
    loop {
        if let Some(number) = next.inside().as_node() {
            let Some(node) = nodes.get(number) else { return };
            let (mut met, enter) = boxes.meet(node, limit);
            if met != 0 {
                let take = |met: &mut u32| {
                    let lane = met.trailing_zeros() as usize % WIDTH;
                    *met &= *met - 1;
                    Waiting::new(enter[lane], node.inside[lane])
                };
                next = take(&mut met);
                let before = stack.len();
                while met != 0 {
                    let other = take(&mut met);
                    if order == Order::Any {
                        stack.push(other);
                        continue;
                    }
                    // The nearest goes on, the nearer of the others lies on top.
                    stack.push(other.max(next));
                    next = other.min(next);
                    let mut place = stack.len() - 1;
                    while place > before && stack[place - 1] < stack[place] {
                        stack.swap(place - 1, place);
                        place -= 1;
                    }
                }
                continue;
            }
        } else {
            let met = Met { inside: next.inside(), way: boxes.way(next.enter()) };
            let Some(reach) = leaf(met) else { return };
            limit = boxes.limit(reach);
        }

        // Take up what waits, unless a hit was found before it.
        loop {
            let Some(waiting) = stack.pop() else { return };
            if waiting.enter() <= limit {
                next = waiting;
                break;
            }
        }
    }
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

/// More than twice Ize's 2γ(3) = 7.2e-7.
const SLACK: f32 = 1.0 + 1.0 / (1 << 19) as f32;

/// What all boxes ask of one ray.
struct BoxRay<S: Simd> {
    simd: S,
    origin: [f32x8<S>; 3],
    inverse: [f32x8<S>; 3],
    /// For each axis, which side of a box the ray meets first.
    near: [usize; 3],
    start: f32x8<S>,
    /// Distances here are in units of the ray's `t` times this power of two: the
    /// direction is scaled to a size near one, so that nothing under- or overflows.
    scale: f32,
}

impl<S: Simd> BoxRay<S> {
    /// `None` for a ray with a NaN or an infinity, or without a direction.
    #[inline(always)]
    fn new(simd: S, ray: &Ray) -> Option<Self> {
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
        let direction = ray.direction * (1.0 / scale);
        let inverse = 1.0 / direction;
        let splat = |v: f32| f32x8::splat(simd, v);
        let first = |d: f32| usize::from(d.is_sign_negative());
        Some(Self {
            simd,
            origin: [splat(ray.origin.x), splat(ray.origin.y), splat(ray.origin.z)],
            inverse: [splat(inverse.x), splat(inverse.y), splat(inverse.z)],
            near: [first(direction.x), first(direction.y), first(direction.z)],
            start: splat(ray.t_min * scale),
            scale,
        })
    }

    /// Which boxes the ray enters before `limit`, a bit for each; and where it enters them.
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

    /// A box that is entered beyond this holds no hit before `reach`, a ray's `t`.
    #[inline(always)]
    fn limit(&self, reach: f64) -> f32 {
        (reach * f64::from(self.scale)) as f32 * SLACK
    }

    /// How far along any axis the ray comes until `enter`.
    #[inline(always)]
    fn way(&self, enter: f32) -> f32 {
        // The scaled direction is shorter than two along each axis.
        2.0 * SLACK * enter
    }
}

/// The greater of each two numbers; the second where the first is no number.
#[inline(always)]
fn greater<S: Simd>(a: f32x8<S>, b: f32x8<S>) -> f32x8<S> {
    if cfg!(any(target_arch = "x86", target_arch = "x86_64")) { a.max(b) } else { a.max_precise(b) }
}

/// The less of each two numbers; the second where the first is no number.
#[inline(always)]
fn less<S: Simd>(a: f32x8<S>, b: f32x8<S>) -> f32x8<S> {
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
    use crate::simd::Simd;
    use crate::{Aabb, Vec3};
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
