//! A ray goes through the tree.
//!
//! Boxes are met in single precision, and never missed: the far side is moved
//! out by more than rounding can do to both sides. Of two children the nearer
//! comes first; the other waits on a stack of fixed size, which the builder's
//! bound on the depth makes large enough.
//!
//! Source: Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013, with a little more
//! slack than its 2γ(3), for the last culling by a distance that was rounded.

use super::node::{Node, Siblings};
use super::{Bvh, MAX_DEPTH};
use crate::{Ray, Vec3};

/// What a ray met first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest<T> {
    /// The number of the primitive.
    pub primitive: u32,
    /// Distance along the ray, in lengths of its direction.
    pub t: f64,
    /// What the primitive said about the hit.
    pub what: T,
}

impl Bvh {
    /// The hit with the least `t`; of equal ones that of the smallest primitive number.
    ///
    /// `meet` is given a place in [`order`](Self::order) and tells whether and
    /// where the ray meets the primitive there, at `t_min < t < t_max` and
    /// within the box it was built with. A ray that is not finite meets nothing.
    #[inline]
    pub fn closest<T>(
        &self,
        ray: &Ray,
        mut meet: impl FnMut(usize) -> Option<(f64, T)>,
    ) -> Option<Closest<T>> {
        let mut best: Option<Closest<T>> = None;
        self.traverse(ray, |places, reach| {
            for place in places {
                let Some((t, what)) = meet(place) else { continue };
                let primitive = self.order[place];
                let nearer = match &best {
                    None => true,
                    Some(best) => t < best.t || t == best.t && primitive < best.primitive,
                };
                if nearer {
                    best = Some(Closest { primitive, t, what });
                    *reach = t;
                }
            }
            false
        });
        best
    }

    /// Whether anything is met at all. `meet` as for [`closest`](Self::closest).
    #[inline]
    pub fn occluded(&self, ray: &Ray, mut meet: impl FnMut(usize) -> bool) -> bool {
        let mut met = false;
        self.traverse(ray, |mut places, _| {
            met = places.any(&mut meet);
            met
        });
        met
    }

    /// Calls `leaf` for every leaf that the ray may meet before its `reach`,
    /// which `leaf` may shorten, until `leaf` says that it is enough.
    #[inline]
    fn traverse(&self, ray: &Ray, mut leaf: impl FnMut(std::ops::Range<usize>, &mut f64) -> bool) {
        let (Some(root), Some(boxes)) = (&self.root, BoxRay::new(ray)) else { return };
        let mut reach = f64::from(ray.t_max);
        let mut limit = boxes.limit(reach);
        let Some(_) = boxes.entry(root, limit) else { return };

        let mut stack = [Waiting { first: 0, count: 0, entry: 0.0 }; MAX_DEPTH];
        let mut waiting = 0;
        let (mut first, mut count) = (root.first, root.count);
        loop {
            if count == 0 {
                // Look into both children, and go into the nearer one.
                let Siblings([left, right]) = &self.siblings[first as usize];
                match (boxes.entry(left, limit), boxes.entry(right, limit)) {
                    (Some(l), Some(r)) => {
                        let (near, far, entry) =
                            if l <= r { (left, right, r) } else { (right, left, l) };
                        stack[waiting] = Waiting { first: far.first, count: far.count, entry };
                        waiting += 1;
                        (first, count) = (near.first, near.count);
                        continue;
                    }
                    (Some(_), None) => {
                        (first, count) = (left.first, left.count);
                        continue;
                    }
                    (None, Some(_)) => {
                        (first, count) = (right.first, right.count);
                        continue;
                    }
                    (None, None) => {}
                }
            } else {
                let first = first as usize;
                if leaf(first..first + count as usize, &mut reach) {
                    return;
                }
                limit = boxes.limit(reach);
            }

            // Take up what waits, unless a hit was found before it.
            loop {
                if waiting == 0 {
                    return;
                }
                waiting -= 1;
                let next = stack[waiting];
                if next.entry <= limit {
                    (first, count) = (next.first, next.count);
                    break;
                }
            }
        }
    }
}

/// A node that is still to be visited, and where the ray enters its box.
#[derive(Clone, Copy)]
struct Waiting {
    first: u32,
    count: u32,
    entry: f32,
}

/// More than twice Ize's 2γ(3) = 7.2e-7.
const SLACK: f32 = 1.0 + 1.0 / (1 << 19) as f32;

/// What all boxes ask of one ray.
struct BoxRay {
    origin: Vec3,
    inverse: Vec3,
    /// For each axis, which corner of a box the ray meets first.
    near: [usize; 3],
    start: f32,
    /// Distances here are in units of the ray's `t` times this power of two: the
    /// direction is scaled to a size near one, so that nothing under- or overflows.
    scale: f32,
}

impl BoxRay {
    /// `None` for a ray with a NaN or an infinity, or without a direction.
    #[inline(always)]
    fn new(ray: &Ray) -> Option<Self> {
        let size = ray.direction.abs().max_element();
        let meets = ray.origin.is_finite()
            && ray.direction.is_finite()
            && size > 0.0
            && ray.t_min < ray.t_max;
        if !meets {
            return None;
        }
        let scale = power_of_two_near(size);
        let direction = ray.direction / scale;
        Some(Self {
            origin: ray.origin,
            inverse: 1.0 / direction,
            near: direction.to_array().map(|d| usize::from(d.is_sign_negative())),
            start: ray.t_min * scale,
            scale,
        })
    }

    /// Where the ray enters a box, or its start inside; `None` if it misses the
    /// box or enters it beyond `limit`.
    #[inline(always)]
    fn entry(&self, node: &Node, limit: f32) -> Option<f32> {
        let (mut enter, mut exit) = (self.start, f32::INFINITY);
        for axis in 0..3 {
            let near = self.near[axis] & 1;
            let t_near = (node.corners[near][axis] - self.origin[axis]) * self.inverse[axis];
            let t_far = (node.corners[near ^ 1][axis] - self.origin[axis]) * self.inverse[axis];
            // A ray within a side of the box, parallel to it, makes 0 · ∞ = NaN
            // here, which no comparison takes over.
            enter = if t_near > enter { t_near } else { enter };
            exit = if t_far < exit { t_far } else { exit };
        }
        (enter <= exit * SLACK && enter <= limit).then_some(enter)
    }

    /// A box that is entered beyond this holds no hit before `reach`, a ray's `t`.
    #[inline(always)]
    fn limit(&self, reach: f64) -> f32 {
        (reach * f64::from(self.scale)) as f32 * SLACK
    }
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

    fn meets(bounds: Aabb, ray: &Ray) -> bool {
        let ray = BoxRay::new(ray).expect("a proper ray");
        ray.entry(&Node::leaf(bounds, 0, 1), f32::INFINITY).is_some()
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
