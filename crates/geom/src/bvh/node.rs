//! A node: a box, and what is inside.

use crate::{Aabb, Vec3};
use std::ops::Range;

/// A box, and either two children or some primitives in it. 32 bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// The lower corner, then the upper one: a ray picks the nearer by its sign.
    pub(super) corners: [[f32; 3]; 2],
    /// Of an inner node the place of its children, of a leaf its first place in the order.
    pub(super) first: u32,
    /// How many primitives a leaf holds, at least one; zero marks an inner node.
    pub(super) count: u32,
}

/// The two children of one parent, on one cache line.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub struct Siblings(pub [Node; 2]);

const _: () = assert!(size_of::<Node>() == 32 && size_of::<Siblings>() == 64);

/// What is inside a node's box.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Content {
    /// The children: a place in [`Bvh::siblings`](super::Bvh::siblings).
    Children(usize),
    /// The primitives: places in [`Bvh::order`](super::Bvh::order).
    Primitives(Range<usize>),
}

impl Node {
    pub(super) fn inner(bounds: Aabb, children: u32) -> Self {
        Self { corners: corners(bounds), first: children, count: 0 }
    }

    pub(super) fn leaf(bounds: Aabb, first: u32, count: u32) -> Self {
        debug_assert!(count > 0);
        Self { corners: corners(bounds), first, count }
    }

    /// The box around all that is inside.
    pub fn bounds(&self) -> Aabb {
        let [min, max] = self.corners.map(Vec3::from_array);
        Aabb { min, max }
    }

    /// What is inside.
    pub fn content(&self) -> Content {
        let first = self.first as usize;
        match self.count as usize {
            0 => Content::Children(first),
            count => Content::Primitives(first..first + count),
        }
    }
}

fn corners(bounds: Aabb) -> [[f32; 3]; 2] {
    [bounds.min.to_array(), bounds.max.to_array()]
}
