//! The binary tree that the builder makes.

use super::build::BuildOptions;
use super::built::{BuildReport, LeftOut};
use super::node::{Content, Node, Siblings};
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
    pub(super) left_out: LeftOut,
    pub(super) options: BuildOptions,
}

impl Bvh {
    /// What was built. Counts the whole tree.
    pub fn report(&self) -> BuildReport {
        let mut report = BuildReport {
            primitives: self.order.len(),
            left_out: self.left_out,
            nodes: usize::from(self.root.is_some()) + 2 * self.siblings.len(),
            leaves: 0,
            depth: 0,
            largest_leaf: 0,
            sah_cost: 0.0,
            bytes: size_of::<Node>() + size_of_val(&*self.siblings) + size_of_val(&*self.order),
        };
        let mut cost = 0.0;
        let mut pending: Vec<(Node, usize)> = self.root.map(|root| (root, 0)).into_iter().collect();
        while let Some((node, depth)) = pending.pop() {
            let area = half_area(&node.bounds());
            match node.content() {
                Content::Children(at) => {
                    cost += area * f64::from(self.options.traversal_cost);
                    pending.extend(self.siblings[at].0.map(|child| (child, depth + 1)));
                }
                Content::Primitives(places) => {
                    cost += area * f64::from(self.options.intersection_cost) * places.len() as f64;
                    report.leaves += 1;
                    report.depth = report.depth.max(depth);
                    report.largest_leaf = report.largest_leaf.max(places.len());
                }
            }
        }
        let area = half_area(&self.bounds());
        if area > 0.0 {
            report.sah_cost = cost / area;
        }
        report
    }

    /// Primitives that are not in the tree.
    pub fn left_out(&self) -> LeftOut {
        self.left_out
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

    /// The same, and nothing else.
    pub(crate) fn into_order(self) -> Vec<u32> {
        self.order
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

/// Like [`Aabb::half_area`], but in double precision, where nothing overflows.
fn half_area(bounds: &Aabb) -> f64 {
    if bounds.is_empty() {
        return 0.0;
    }
    let e = bounds.max.as_dvec3() - bounds.min.as_dvec3();
    e.x * e.y + e.y * e.z + e.z * e.x
}
