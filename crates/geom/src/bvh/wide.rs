//! The tree that rays go through: eight boxes to a node, triangles in packs of four.
//!
//! It is made of the binary tree by taking nodes together. A ray is tested
//! against all boxes of a node at once, and against all triangles of a pack.
//! Both tests are in single precision and only sort out what is certainly
//! missed: a hit is decided by the exact test that follows, so that the same
//! bits are found whatever the processor has for doing eight things at once.
//!
//! Sources: Wald, Benthin, Boulos, "Getting Rid of Packets", IEEE Symposium on
//! Interactive Ray Tracing, 2008; Ylitie, Karras, Laine, "Efficient Incoherent
//! Ray Traversal on GPUs Through Compressed Wide BVHs", HPG 2017.

use super::binary::Bvh;
use super::built::BuildReport;
use super::node::{Content, Node};
use crate::{Aabb, Vec3};
use arrayvec::ArrayVec;
use std::ops::Range;

/// Boxes in a node.
pub(crate) const WIDTH: usize = 8;

/// Triangles in a pack.
pub(crate) const PACK: usize = 4;

/// Eight boxes, and what is in them. 256 bytes, four cache lines.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(crate) struct WideNode {
    /// For each axis the lower sides of all boxes, then the upper ones. Boxes that are not there
    /// have their sides at infinity, the wrong way round.
    pub(crate) sides: [[[f32; WIDTH]; 2]; 3],
    /// What is inside.
    pub(crate) inside: [Inside; WIDTH],
}

/// What is in a box: the number of a node, or packs of triangles, or a leaf of another kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Inside(u32);

impl Inside {
    const LEAF: u32 = 1 << 31;
    /// Packs in a leaf, at most.
    pub(crate) const MOST_PACKS: u32 = 15;

    /// A node.
    pub(crate) fn node(number: u32) -> Self {
        Self(number)
    }

    /// So many packs from this one on; none for the leaf of another kind with this number.
    pub(crate) fn leaf(first: u32, packs: u32) -> Self {
        Self(Self::LEAF | first << 4 | packs)
    }

    #[inline(always)]
    pub(crate) fn bits(self) -> u32 {
        self.0
    }

    #[inline(always)]
    pub(crate) fn from_bits(bits: u32) -> Self {
        Self(bits)
    }

    /// The number of the node, if it is one.
    #[inline(always)]
    pub(crate) fn as_node(self) -> Option<usize> {
        (self.0 & Self::LEAF == 0).then_some(self.0 as usize)
    }

    /// The first pack and how many there are.
    #[inline(always)]
    pub(crate) fn as_leaf(self) -> (usize, usize) {
        (((self.0 & !Self::LEAF) >> 4) as usize, (self.0 & 15) as usize)
    }
}

impl WideNode {
    pub(super) const EMPTY: Self = Self {
        sides: [[[f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]]; 3],
        inside: [Inside(0); WIDTH],
    };

    fn bounds(&self, lane: usize) -> Aabb {
        let corner = |side: usize| {
            let sides = &self.sides;
            Vec3::new(sides[0][side][lane], sides[1][side][lane], sides[2][side][lane])
        };
        Aabb { min: corner(0), max: corner(1) }
    }

    pub(super) fn put(&mut self, lane: usize, bounds: &Aabb, inside: Inside) {
        let (min, max) = (bounds.min.to_array(), bounds.max.to_array());
        for (axis, sides) in self.sides.iter_mut().enumerate() {
            sides[0][lane] = min[axis];
            sides[1][lane] = max[axis];
        }
        self.inside[lane] = inside;
    }
}

/// What it costs to look into eight boxes, where a pack of triangles costs one.
const NODE_COST: f32 = 1.5;

/// Takes the nodes of a binary tree together, in the way that costs least by the surface area
/// heuristic; small parts of it become leaves.
///
/// `cost` tells what it costs to meet the primitives of a leaf, or `None` where they are too many
/// for one; `leaf` makes a leaf. Both are given places in the order of the tree. The first node is
/// the root; there is none for an empty tree.
///
/// Source: Ylitie et al. 2017, section 3.1.
pub(crate) fn widened(
    bvh: &Bvh,
    cost: impl Fn(&Range<usize>) -> Option<f32>,
    mut leaf: impl FnMut(Range<usize>, &Aabb) -> Inside,
) -> Vec<WideNode> {
    let Some(root) = bvh.root() else { return Vec::new() };
    let parts = Parts::new(bvh, cost);
    let mut nodes = vec![WideNode::EMPTY];
    // What is still to be made into the node of this number.
    let mut pending = vec![(0, *root, parts.of(root))];
    while let Some((number, node, part)) = pending.pop() {
        let mut children = ArrayVec::<_, WIDTH>::new();
        if part.is_leaf {
            children.push((node, part));
        } else {
            parts.children(&node, WIDTH, &mut children);
        }
        for (lane, (child, part)) in children.into_iter().enumerate() {
            let inside = if part.is_leaf {
                leaf(part.places(), &child.bounds())
            } else {
                let below = nodes.len() as u32;
                nodes.push(WideNode::EMPTY);
                pending.push((below, child, part));
                Inside::node(below)
            };
            nodes[number as usize].put(lane, &child.bounds(), inside);
        }
    }
    nodes
}

/// What is said about a wide tree. `primitives` and `left_out` are those of the binary one.
pub(crate) fn report(
    bvh: &Bvh,
    nodes: &[WideNode],
    in_leaf: impl Fn(Inside) -> usize,
) -> BuildReport {
    let mut report = BuildReport {
        nodes: nodes.len(),
        leaves: 0,
        depth: 0,
        largest_leaf: 0,
        sah_cost: 0.0,
        ..*bvh.report()
    };
    let half_area = |bounds: Aabb| f64::from(bounds.half_area());
    let mut pending: Vec<_> = bvh.root().map(|root| (0, 0, root.bounds())).into_iter().collect();
    let mut cost = 0.0;
    while let Some((number, depth, bounds)) = pending.pop() {
        let node: &WideNode = &nodes[number];
        cost += f64::from(NODE_COST) * half_area(bounds);
        for lane in (0..WIDTH).filter(|lane| node.sides[0][0][*lane] <= node.sides[0][1][*lane]) {
            let (inside, bounds) = (node.inside[lane], node.bounds(lane));
            match inside.as_node() {
                Some(below) => pending.push((below, depth + 1, bounds)),
                None => {
                    let (primitives, (_, packs)) = (in_leaf(inside), inside.as_leaf());
                    let tests = if packs == 0 { primitives } else { packs };
                    cost += tests as f64 * half_area(bounds);
                    report.leaves += 1;
                    report.depth = report.depth.max(depth + 1);
                    report.largest_leaf = report.largest_leaf.max(primitives);
                }
            }
        }
    }
    let area = half_area(bvh.bounds());
    if area > 0.0 {
        report.sah_cost = cost / area;
    }
    report
}

/// Part of the binary tree, and what it costs.
#[derive(Clone, Copy)]
struct Part {
    /// The least cost if it takes up to one, two, … of the boxes in a node.
    costs: [f32; WIDTH],
    /// Places in the order of the tree.
    first: u32,
    count: u32,
    /// True if it costs least as a leaf.
    is_leaf: bool,
}

impl Part {
    fn places(&self) -> Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }
}

/// All of them.
struct Parts<'a, F> {
    bvh: &'a Bvh,
    cost: F,
    /// Of every pair of siblings.
    pairs: Vec<[Part; 2]>,
}

impl<'a, F: Fn(&Range<usize>) -> Option<f32>> Parts<'a, F> {
    fn new(bvh: &'a Bvh, cost: F) -> Self {
        let nothing = Part { costs: [0.0; WIDTH], first: 0, count: 0, is_leaf: true };
        let mut parts = Self { bvh, cost, pairs: vec![[nothing; 2]; bvh.siblings().len()] };
        // Children come after their parents.
        for (i, pair) in bvh.siblings().iter().enumerate().rev() {
            parts.pairs[i] = [parts.of(&pair.0[0]), parts.of(&pair.0[1])];
        }
        parts
    }

    /// What `node` costs; what is below it must be known.
    fn of(&self, node: &Node) -> Part {
        let area = node.bounds().half_area();
        match node.content() {
            Content::Primitives(places) => Part {
                costs: [area * (self.cost)(&places).unwrap_or(places.len() as f32); WIDTH],
                first: places.start as u32,
                count: places.len() as u32,
                is_leaf: true,
            },
            Content::Children(at) => {
                let [left, right] = &self.pairs[at];
                let (first, count) = (left.first, left.count + right.count);
                let mut part = Part { costs: [0.0; WIDTH], first, count, is_leaf: false };
                // Shared out between both children in the best way.
                let mut least = f32::INFINITY;
                for boxes in 2..=WIDTH {
                    least = least.min(Self::shared(left, right, boxes).1);
                    part.costs[boxes - 1] = least;
                }
                // As one box: with all in a node below, or as a leaf.
                let below = area * NODE_COST + least;
                let leaf = (self.cost)(&part.places()).map_or(f32::INFINITY, |cost| area * cost);
                part.is_leaf = leaf <= below;
                part.costs[0] = leaf.min(below);
                for boxes in 1..WIDTH {
                    part.costs[boxes] = part.costs[boxes].min(part.costs[boxes - 1]);
                }
                part
            }
        }
    }

    /// How many of so many boxes the left child takes at best, and what both cost then.
    fn shared(left: &Part, right: &Part, boxes: usize) -> (usize, f32) {
        let cost = |of_left: usize| left.costs[of_left - 1] + right.costs[boxes - of_left - 1];
        let best = (2..boxes).fold(1, |best, i| if cost(i) < cost(best) { i } else { best });
        (best, cost(best))
    }

    /// The parts that fill up to so many boxes.
    fn children(&self, node: &Node, boxes: usize, out: &mut ArrayVec<(Node, Part), WIDTH>) {
        let Content::Children(at) = node.content() else { return };
        let [left, right] = &self.pairs[at];
        // Fewer boxes may do.
        let boxes = (2..=boxes).fold(2, |best, i| {
            let cost = |i| Self::shared(left, right, i).1;
            if cost(i) < cost(best) { i } else { best }
        });
        let (of_left, _) = Self::shared(left, right, boxes);
        let both = self.bvh.siblings()[at].0;
        for ((node, part), boxes) in both.iter().zip([left, right]).zip([of_left, boxes - of_left])
        {
            // The fewest boxes that cost no more.
            let boxes = (1..=boxes).find(|i| part.costs[i - 1] <= part.costs[boxes - 1]);
            match boxes {
                Some(boxes @ 2..) => self.children(node, boxes, out),
                _ => out.push((*node, *part)),
            }
        }
    }
}
