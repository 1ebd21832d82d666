//! A bounding volume hierarchy: a tree of boxes around primitives.
//!
//! The tree knows only boxes and numbers. Who owns the primitives gives their
//! boxes to [`Bvh::build`], makes an eight-wide tree of the binary one, and
//! meets the primitives itself when a ray comes to a leaf. What a ray finds
//! never depends on the shape of the tree: boxes are only left out where no hit
//! can be.

mod build;
mod node;
mod traverse;
mod wide;

use crate::Aabb;
pub use build::{BuildOptions, BuildReport, LeftOut};
pub use node::{Content, Node, Siblings};
pub(crate) use traverse::{Met, Order, traverse};
pub(crate) use wide::{Inside, PACK, WideNode, report, widened};

/// The deepest a leaf can lie below the root, for any input; see `build.rs`.
pub const MAX_DEPTH: usize = 64;

/// A tree of boxes around primitives. Empty if there were none.
#[derive(Clone, Debug, PartialEq)]
pub struct Bvh {
    root: Option<Node>,
    /// All other nodes, two children of one parent together, in depth-first order.
    siblings: Vec<Siblings>,
    /// The numbers of the primitives, leaf after leaf.
    order: Vec<u32>,
    report: BuildReport,
}

impl Bvh {
    /// What was built.
    pub fn report(&self) -> &BuildReport {
        &self.report
    }

    /// The box around everything; [`Aabb::EMPTY`] for the empty tree.
    pub fn bounds(&self) -> Aabb {
        self.root.map_or(Aabb::EMPTY, |root| root.bounds())
    }

    /// The primitive numbers in the order of the leaves. A leaf holds a range of
    /// places in this order; primitives that were left out have no place.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// The top of the tree, `None` if it is empty.
    pub fn root(&self) -> Option<&Node> {
        self.root.as_ref()
    }

    /// All nodes but the root: pairs of children, in depth-first order.
    pub fn siblings(&self) -> &[Siblings] {
        &self.siblings
    }
}
