//! The binary tree that the builder makes.

use super::built::BuildReport;
use super::node::{Node, Siblings};
use crate::Aabb;

/// The deepest a leaf can lie below the root, for any input; see `build.rs`.
pub const MAX_DEPTH: usize = 64;

/// A tree of boxes around primitives. Empty if there were none.
#[derive(Clone, Debug, PartialEq)]
pub struct Bvh {
    pub(super) root: Option<Node>,
    /// All other nodes, two children of one parent together, in depth-first order.
    pub(super) siblings: Vec<Siblings>,
    /// The numbers of the primitives, leaf after leaf.
    pub(super) order: Vec<u32>,
    pub(super) report: BuildReport,
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
