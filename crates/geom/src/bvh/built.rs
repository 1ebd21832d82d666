//! What is said about a tree that was built.

/// What was built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BuildReport {
    /// Primitives in the tree.
    pub primitives: usize,
    /// Primitives that are not in the tree, because their box is empty, NaN or infinite.
    pub left_out: LeftOut,
    /// Nodes, root and leaves included.
    pub nodes: usize,
    /// Leaves.
    pub leaves: usize,
    /// Steps from the root to the deepest leaf; zero for a single leaf and for none.
    pub depth: usize,
    /// Primitives in the fullest leaf.
    pub largest_leaf: usize,
    /// The expected cost of a ray that meets the root's box, by the surface area
    /// heuristic; zero if that box has no area.
    pub sah_cost: f64,
    /// Memory of the tree, in bytes.
    pub bytes: usize,
}

/// Primitives that could not be used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LeftOut {
    /// How many.
    pub count: usize,
    /// The number of the first of them.
    pub first: Option<u32>,
}
