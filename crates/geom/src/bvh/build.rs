//! Building the tree from the top down, where the surface area heuristic says.
//!
//! The primitives' centres are counted into a few bins along each axis, and the
//! boundary between two bins with the least expected cost divides them, if that
//! is cheaper than a leaf. Few primitives are sorted instead, and every way to
//! divide them is tried. Large parts are built in parallel; a part is divided in
//! the same way whoever does it, so the tree has the same bits for any number of
//! threads.
//!
//! Depth is bounded for any input: a node of n primitives at depth d is divided
//! by the heuristic only while every child could still be finished by halving
//! within [`MAX_DEPTH`], that is while d + 1 + ⌈log₂ n'⌉ stays within it.
//! Halving keeps that invariant, and 2³² primitives start at 32.
//!
//! Source: Wald, "On fast Construction of SAH-based Bounding Volume
//! Hierarchies", IEEE Symposium on Interactive Ray Tracing, 2007.

use super::binary::{Bvh, MAX_DEPTH};
use super::built::{BuildReport, LeftOut};
use super::node::{Node, Siblings};
use crate::{Aabb, Vec3};

/// How a tree is built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BuildOptions {
    /// Bins along each axis, 2 to 64; others are moved into that range. Eight
    /// bins have seven planes between them, 21 over the three axes. Parts of few primitives are
    /// divided without bins.
    pub bins: u32,
    /// The most primitives in a leaf, at least 1. [`Surfaces`](crate::Surfaces) take up to sixteen
    /// triangles together again where that is cheaper.
    pub max_leaf: u32,
    /// What it costs to look into a node's two children; only the ratio to the
    /// cost of a primitive counts.
    pub traversal_cost: f32,
    /// What it costs to meet one primitive.
    pub intersection_cost: f32,
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self { bins: 16, max_leaf: 4, traversal_cost: 1.0, intersection_cost: 1.0 }
    }
}

impl Bvh {
    /// Builds the tree over primitives with these bounds.
    ///
    /// A primitive whose box is empty, NaN or infinite is left out and counted.
    /// Runs on the current rayon thread pool.
    ///
    /// # Panics
    ///
    /// If there are 2³¹ primitives or more.
    pub fn build(bounds: &[Aabb], options: &BuildOptions) -> Self {
        assert!(bounds.len() < 1 << 31, "too many primitives for one tree");
        let proper = |b: &Aabb| b.is_finite() && !b.is_empty();
        let mut items = Vec::with_capacity(bounds.len());
        let mut left_out = LeftOut::default();
        for (number, bounds) in (0u32..).zip(bounds) {
            if proper(bounds) {
                items.push(Item { bounds: *bounds, number });
            } else {
                left_out.count += 1;
                left_out.first.get_or_insert(number);
            }
        }

        let options = &BuildOptions {
            bins: options.bins.clamp(2, MAX_BINS as u32),
            max_leaf: options.max_leaf.max(1),
            ..*options
        };
        let mut siblings = Vec::new();
        let root = (!items.is_empty()).then(|| {
            let part = Part::around(&items);
            Builder { options, bins: Box::new([[Bin::EMPTY; MAX_BINS]; 3]), out: &mut siblings }
                .node(&mut items, &part, 0, 0)
        });
        siblings.shrink_to_fit();
        let order: Vec<u32> = items.iter().map(|item| item.number).collect();

        let report = report(root.as_ref(), &siblings, &order, left_out, options);
        Self { root, siblings, order, report }
    }
}

/// More bins than this gain nothing.
const MAX_BINS: usize = 64;

/// So few primitives are divided in the best of all places.
const SWEPT: usize = 16;

/// Parts with fewer primitives are built by one thread.
const PARALLEL_FROM: usize = 4096;

/// One primitive while the tree is built.
#[derive(Clone, Copy)]
struct Item {
    bounds: Aabb,
    number: u32,
}

/// What some primitives fill together.
#[derive(Clone, Copy)]
struct Part {
    bounds: Aabb,
    centers: Aabb,
}

impl Part {
    fn around(items: &[Item]) -> Self {
        let empty = Self { bounds: Aabb::EMPTY, centers: Aabb::EMPTY };
        items.iter().fold(empty, |part, item| Self {
            bounds: part.bounds.union(item.bounds),
            centers: part.centers.grown(item.bounds.center()),
        })
    }
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: Aabb,
    count: u32,
}

impl Bin {
    const EMPTY: Self = Self { bounds: Aabb::EMPTY, count: 0 };

    fn union(&self, other: &Self) -> Self {
        Self { bounds: self.bounds.union(other.bounds), count: self.count + other.count }
    }

    /// Area times number: the expected cost of meeting all, but for constants.
    fn cost(&self) -> f64 {
        half_area(&self.bounds) * f64::from(self.count)
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

/// A way to divide: what is in bins below `place`, or before it in the order along the axis, goes
/// left.
#[derive(Clone, Copy)]
struct Split {
    axis: usize,
    place: usize,
    cost: f64,
    largest: usize,
}

/// Which bin a centre falls into.
#[derive(Clone, Copy)]
struct Binning {
    start: Vec3,
    scale: Vec3,
    last: u32,
}

impl Binning {
    fn new(centers: &Aabb, bins: u32) -> Self {
        // Along an axis without extent, or with one beyond all numbers, the
        // scale is infinite, zero or NaN, and all fall into one bin.
        let scale = Vec3::splat(bins as f32) / centers.extent();
        Self { start: centers.min, scale, last: bins - 1 }
    }

    #[inline]
    fn bins_of(&self, center: Vec3) -> [usize; 3] {
        // The cast takes NaN to zero and saturates.
        ((center - self.start) * self.scale)
            .to_array()
            .map(|place| (place as i32 as u32).min(self.last) as usize)
    }
}

struct Builder<'a> {
    options: &'a BuildOptions,
    bins: Box<[[Bin; MAX_BINS]; 3]>,
    out: &'a mut Vec<Siblings>,
}

impl Builder<'_> {
    /// Builds the node of `items`, `place` being their first place in the order.
    fn node(&mut self, items: &mut [Item], part: &Part, place: usize, depth: usize) -> Node {
        // Find the cheapest way to divide, or make a leaf.
        let Some(middle) = self.divide(items, part, depth) else {
            return Node::leaf(part.bounds, place as u32, items.len() as u32);
        };
        let (left, right) = items.split_at_mut(middle);
        let (left_part, right_part) = (Part::around(left), Part::around(right));

        // The children's place comes before all that is below them.
        let children = self.out.len();
        let pending = Node::leaf(part.bounds, 0, 1);
        self.out.push(Siblings([pending; 2]));
        let pair = if left.len() + right.len() < PARALLEL_FROM {
            [
                self.node(left, &left_part, place, depth + 1),
                self.node(right, &right_part, place + middle, depth + 1),
            ]
        } else {
            let options = self.options;
            let apart = |items: &mut [Item], part: &Part, place: usize| {
                let mut out = Vec::with_capacity(items.len() / 2);
                let bins = Box::new([[Bin::EMPTY; MAX_BINS]; 3]);
                let node =
                    Builder { options, bins, out: &mut out }.node(items, part, place, depth + 1);
                (node, out)
            };
            let (left, right) = rayon::join(
                || apart(left, &left_part, place),
                || apart(right, &right_part, place + middle),
            );
            [self.append(left), self.append(right)]
        };
        self.out[children] = Siblings(pair);
        Node::inner(part.bounds, children as u32)
    }

    /// Takes over a subtree that was built apart; gives its root.
    fn append(&mut self, (root, below): (Node, Vec<Siblings>)) -> Node {
        let base = self.out.len() as u32;
        let moved = |mut node: Node| {
            if node.count == 0 {
                node.first += base;
            }
            node
        };
        self.out.extend(below.iter().map(|pair| Siblings(pair.0.map(moved))));
        moved(root)
    }

    /// Puts the items of the left child before those of the right one, and gives
    /// the number on the left; `None` for a leaf.
    fn divide(&mut self, items: &mut [Item], part: &Part, depth: usize) -> Option<usize> {
        let n = items.len();
        let may_be_leaf = n <= self.options.max_leaf as usize;
        if n == 1 {
            return None;
        }
        let binning = Binning::new(&part.centers, self.options.bins);
        let few = n <= SWEPT;
        if let Some(split) = if few { self.swept(items) } else { self.binned(items, &binning) } {
            let inner = f64::from(self.options.traversal_cost) * half_area(&part.bounds)
                + f64::from(self.options.intersection_cost) * split.cost;
            let leaf =
                f64::from(self.options.intersection_cost) * half_area(&part.bounds) * n as f64;
            if may_be_leaf && leaf <= inner {
                return None;
            }
            if depth + 1 + halvings(split.largest) <= MAX_DEPTH {
                if few {
                    sort_by_center(items, split.axis);
                    return Some(split.place);
                }
                return Some(partition(items, |item| {
                    binning.bins_of(item.bounds.center())[split.axis] < split.place
                }));
            }
        } else if may_be_leaf {
            return None;
        }

        // Equal centres, or too deep already: halve along the widest axis.
        let e = part.centers.extent();
        let axis = if e.x >= e.y && e.x >= e.z { 0 } else { 1 + usize::from(e.z > e.y) };
        let middle = n / 2;
        items.select_nth_unstable_by(middle, |a, b| {
            let key = |item: &Item| item.bounds.center()[axis];
            key(a).total_cmp(&key(b)).then(a.number.cmp(&b.number))
        });
        Some(middle)
    }

    /// The cheapest of all ways to divide few items where their centres do along some axis.
    fn swept(&self, items: &mut [Item]) -> Option<Split> {
        let n = items.len();
        let mut best: Option<Split> = None;
        for axis in 0..3 {
            sort_by_center(items, axis);
            let mut from = [0.0; SWEPT];
            let mut sum = Aabb::EMPTY;
            for i in (1..n).rev() {
                sum = sum.union(items[i].bounds);
                from[i] = half_area(&sum) * (n - i) as f64;
            }
            let mut left = Aabb::EMPTY;
            for place in 1..n {
                left = left.union(items[place - 1].bounds);
                let cost = half_area(&left) * place as f64 + from[place];
                if best.is_none_or(|best| cost < best.cost) {
                    best = Some(Split { axis, place, cost, largest: place.max(n - place) });
                }
            }
        }
        best
    }

    /// The cheapest of all planes between bins that leave no side empty.
    fn binned(&mut self, items: &[Item], binning: &Binning) -> Option<Split> {
        let bins = self.options.bins as usize;
        for axis in self.bins.iter_mut() {
            axis[..bins].fill(Bin::EMPTY);
        }
        for item in items {
            let place = binning.bins_of(item.bounds.center());
            for (axis, place) in self.bins.iter_mut().zip(place) {
                let bin = &mut axis[place % MAX_BINS];
                bin.bounds = bin.bounds.union(item.bounds);
                bin.count += 1;
            }
        }

        let mut best: Option<Split> = None;
        for (axis, bins) in self.bins.iter().map(|axis| &axis[..bins]).enumerate() {
            // Everything from a bin on, from the right; then the planes from the left.
            let mut from = [Bin::EMPTY; MAX_BINS];
            let mut sum = Bin::EMPTY;
            for (from, bin) in from.iter_mut().zip(bins).rev() {
                sum = sum.union(bin);
                *from = sum;
            }
            let mut left = Bin::EMPTY;
            for bin in 1..bins.len() {
                left = left.union(&bins[bin - 1]);
                let right = &from[bin];
                if left.count == 0 || right.count == 0 {
                    continue;
                }
                let cost = left.cost() + right.cost();
                if best.is_none_or(|best| cost < best.cost) {
                    let largest = left.count.max(right.count) as usize;
                    best = Some(Split { axis, place: bin, cost, largest });
                }
            }
        }
        best
    }
}

/// Equal centres stay in the order of their numbers.
fn sort_by_center(items: &mut [Item], axis: usize) {
    let key = |item: &Item| item.bounds.min[axis] + item.bounds.max[axis];
    items.sort_unstable_by(|a, b| key(a).total_cmp(&key(b)).then(a.number.cmp(&b.number)));
}

/// How often n things must be halved until each stands alone: ⌈log₂ n⌉.
fn halvings(n: usize) -> usize {
    n.next_power_of_two().trailing_zeros() as usize
}

/// Moves what is `left` before the rest, in place; gives how many are left.
fn partition(items: &mut [Item], left: impl Fn(&Item) -> bool) -> usize {
    let (mut start, mut end) = (0, items.len());
    loop {
        while start < end && left(&items[start]) {
            start += 1;
        }
        while start < end && !left(&items[end - 1]) {
            end -= 1;
        }
        if start >= end {
            return start;
        }
        items.swap(start, end - 1);
        start += 1;
        end -= 1;
    }
}

/// Counts the finished tree.
fn report(
    root: Option<&Node>,
    siblings: &[Siblings],
    order: &[u32],
    left_out: LeftOut,
    options: &BuildOptions,
) -> BuildReport {
    let mut report = BuildReport {
        primitives: order.len(),
        left_out,
        nodes: usize::from(root.is_some()) + 2 * siblings.len(),
        leaves: 0,
        depth: 0,
        largest_leaf: 0,
        sah_cost: 0.0,
        bytes: size_of::<Node>() + size_of_val(siblings) + size_of_val(order),
    };
    let mut cost = 0.0;
    let mut pending: Vec<(Node, usize)> = root.iter().map(|&&root| (root, 0)).collect();
    while let Some((node, depth)) = pending.pop() {
        let area = half_area(&node.bounds());
        if node.count == 0 {
            cost += area * f64::from(options.traversal_cost);
            pending.extend(siblings[node.first as usize].0.map(|child| (child, depth + 1)));
        } else {
            cost += area * f64::from(options.intersection_cost) * f64::from(node.count);
            report.leaves += 1;
            report.depth = report.depth.max(depth);
            report.largest_leaf = report.largest_leaf.max(node.count as usize);
        }
    }
    let area = root.map_or(0.0, |root| half_area(&root.bounds()));
    if area > 0.0 {
        report.sah_cost = cost / area;
    }
    report
}
