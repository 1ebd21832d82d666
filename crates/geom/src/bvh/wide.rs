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

    /// The boxes that are there, and what is in them.
    pub(crate) fn parts(&self) -> impl Iterator<Item = (Aabb, Inside)> {
        let all = (0..WIDTH).map(|lane| (self.bounds(lane), self.inside[lane]));
        all.filter(|(bounds, _)| bounds.min.x <= bounds.max.x)
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

/// How much larger a node is than a pack of triangles.
const NODE_SIZE: f32 = 256.0 / 180.0;

/// What the memory of a pack costs, where a ray through a box as large as the leaves typically are
/// meets one at a cost of one. On a scanned mesh this saves 6 % of all memory, and rays are none the
/// slower: fewer, fuller packs leave more to the cache.
const MEMORY_COST: f32 = 1.5;

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
    cost: impl Fn(&Range<usize>) -> Option<f32> + Sync,
    mut leaf: impl FnMut(Range<usize>) -> Inside,
) -> Vec<WideNode> {
    let Some(root) = bvh.root() else { return Vec::new() };
    let mut plans = vec![[Plan::LEAF; 2]; bvh.siblings().len()];
    let memory = MEMORY_COST * typical_leaf_area(bvh);
    let (plan, _) = Planner { bvh, cost, memory }.plan(root, &mut plans, 0);
    let plans = Plans { bvh, pairs: plans };
    let mut nodes = vec![WideNode::EMPTY];
    // What is still to be made into the node of this number.
    let mut pending = vec![(0, *root, plan)];
    while let Some((number, node, plan)) = pending.pop() {
        let mut children = ArrayVec::<_, WIDTH>::new();
        if plan.is_leaf() {
            children.push((node, plan));
        } else {
            plans.children(&node, plan, WIDTH, &mut children);
        }
        // Where any hit will do, rays take the first box that they meet, then the others from the
        // last one back: larger boxes more often hold one.
        let area = |(node, _): &(Node, Plan)| node.bounds().half_area();
        children.sort_unstable_by(|a, b| area(b).total_cmp(&area(a)));
        if let Some(others) = children.get_mut(1..) {
            others.reverse();
        }
        for (lane, (child, plan)) in children.into_iter().enumerate() {
            let inside = if plan.is_leaf() {
                leaf(plans.places(&child))
            } else {
                let below = nodes.len() as u32;
                nodes.push(WideNode::EMPTY);
                pending.push((below, child, plan));
                Inside::node(below)
            };
            nodes[number as usize].put(lane, &child.bounds(), inside);
        }
    }
    nodes.shrink_to_fit();
    nodes
}

/// What is said about a wide tree, but for `bytes`.
pub(crate) fn report(
    bvh: &Bvh,
    nodes: &[WideNode],
    in_leaf: impl Fn(Inside) -> usize,
) -> BuildReport {
    let mut report = BuildReport {
        primitives: bvh.order().len(),
        left_out: bvh.left_out(),
        nodes: nodes.len(),
        leaves: 0,
        depth: 0,
        largest_leaf: 0,
        sah_cost: 0.0,
        bytes: 0,
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

/// How part of the binary tree is best put into boxes: three bits for each number of them from two
/// on, how many the left child takes then; zero if fewer do as well. And whether it is best a leaf
/// where there is one box.
#[derive(Clone, Copy)]
struct Plan(u32);

impl Plan {
    const NODE: Self = Self(0);
    const LEAF: Self = Self(1 << 31);

    fn is_leaf(self) -> bool {
        self.0 >> 31 == 1
    }

    fn with_left(self, boxes: usize, of_left: u32) -> Self {
        Self(self.0 | of_left << (3 * (boxes - 2)))
    }

    fn left(self, boxes: usize) -> usize {
        (self.0 >> (3 * (boxes - 2)) & 7) as usize
    }

    /// How many boxes are worth it of so many; `None` for one.
    fn boxes(self, most: usize) -> Option<usize> {
        (2..=most).rev().find(|boxes| self.left(*boxes) != 0)
    }
}

/// Part of the binary tree, and the least that it costs in up to one, two, … boxes.
struct Part {
    costs: [f32; WIDTH],
    /// Places in the order of the tree.
    places: Range<usize>,
}

/// Makes the plans.
struct Planner<'a, F> {
    bvh: &'a Bvh,
    cost: F,
    /// The area that a pack's memory is worth.
    memory: f32,
}

/// So many levels from the root on are shared out among threads.
const PARALLEL_LEVELS: usize = 8;

impl<F: Fn(&Range<usize>) -> Option<f32> + Sync> Planner<'_, F> {
    /// Makes those of a node and of all that is below it; the latter go to `plans`, in the order of
    /// the tree.
    fn plan(&self, node: &Node, plans: &mut [[Plan; 2]], level: usize) -> (Plan, Part) {
        let area = node.bounds().half_area();
        let at = match node.content() {
            Content::Children(at) => at,
            Content::Primitives(places) => {
                let cost =
                    (self.cost)(&places).unwrap_or(places.len() as f32) * (area + self.memory);
                return (Plan::LEAF, Part { costs: [cost; WIDTH], places });
            }
        };
        // What is below the left child comes before what is below the right one.
        let [left, right] = &self.bvh.siblings()[at].0;
        let (own, below) = plans.split_at_mut(1);
        let of_left = match right.content() {
            Content::Children(first) => first - at - 1,
            Content::Primitives(_) => below.len(),
        };
        let (below_left, below_right) = below.split_at_mut(of_left);
        let (left, right) = if level < PARALLEL_LEVELS {
            rayon::join(
                || self.plan(left, below_left, level + 1),
                || self.plan(right, below_right, level + 1),
            )
        } else {
            (self.plan(left, below_left, level), self.plan(right, below_right, level))
        };
        own[0] = [left.0, right.0];
        let (left, right) = (left.1, right.1);
        let places = left.places.start..right.places.end;

        // Shared out between both children in the best way.
        let (mut shared, mut of_left) = ([f32::INFINITY; WIDTH], [0_u32; WIDTH]);
        // What the right child costs in one, two, … boxes less; infinitely much in none.
        let mut right_in = [f32::INFINITY; 2 * WIDTH];
        right_in[WIDTH..].copy_from_slice(&right.costs);
        for (of_this, cost) in (1..WIDTH as u32).zip(left.costs) {
            let rest = right_in.iter().skip(WIDTH - of_this as usize);
            for ((shared, of_left), rest) in shared.iter_mut().zip(&mut of_left).zip(rest) {
                let cheaper = cost + rest < *shared;
                *of_left = if cheaper { of_this } else { *of_left };
                *shared = if cheaper { cost + rest } else { *shared };
            }
        }
        // As one box: with all in a node below, or as a leaf.
        let least = shared.iter().copied().fold(f32::INFINITY, f32::min);
        let below = area * NODE_COST + NODE_SIZE * self.memory + least;
        let leaf = (self.cost)(&places).map_or(f32::INFINITY, |cost| (area + self.memory) * cost);
        let mut plan = if leaf <= below { Plan::LEAF } else { Plan::NODE };
        let mut costs = [leaf.min(below); WIDTH];
        for boxes in 2..=WIDTH {
            costs[boxes - 1] = costs[boxes - 2];
            if shared[boxes - 1] < costs[boxes - 1] {
                costs[boxes - 1] = shared[boxes - 1];
                plan = plan.with_left(boxes, of_left[boxes - 1]);
            }
        }
        (plan, Part { costs, places })
    }
}

/// All plans.
struct Plans<'a> {
    bvh: &'a Bvh,
    /// Of every pair of siblings.
    pairs: Vec<[Plan; 2]>,
}

impl Plans<'_> {
    /// The parts that fill up to so many boxes, at least two.
    fn children(
        &self,
        node: &Node,
        plan: Plan,
        boxes: usize,
        out: &mut ArrayVec<(Node, Plan), WIDTH>,
    ) {
        let Content::Children(at) = node.content() else { return };
        let boxes = plan.boxes(boxes).unwrap_or(2);
        let of_left = plan.left(boxes).max(1);
        let both = self.bvh.siblings()[at].0.iter().zip(self.pairs[at]);
        for ((node, plan), boxes) in both.zip([of_left, boxes - of_left]) {
            match plan.boxes(boxes) {
                Some(boxes) => self.children(node, plan, boxes, out),
                None => out.push((*node, plan)),
            }
        }
    }

    /// Where all primitives below a node are.
    fn places(&self, node: &Node) -> Range<usize> {
        let end = |side: usize| {
            let mut node = *node;
            loop {
                match node.content() {
                    Content::Children(at) => node = self.bvh.siblings()[at].0[side],
                    Content::Primitives(places) => return places,
                }
            }
        };
        end(0).start..end(1).end
    }
}

/// The geometric mean of the areas of the leaves, nearly: that of their bits, in which the
/// exponents stand.
fn typical_leaf_area(bvh: &Bvh) -> f32 {
    let (mut sum, mut count) = (0, 0);
    for node in bvh.siblings().iter().flat_map(|pair| &pair.0) {
        if let Content::Primitives(_) = node.content() {
            sum += u64::from(node.bounds().half_area().to_bits());
            count += 1;
        }
    }
    f32::from_bits((sum / u64::max(count, 1)) as u32)
}
