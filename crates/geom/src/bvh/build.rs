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
use super::built::LeftOut;
use super::node::{Node, Siblings};
use super::optimize::optimized;
use crate::Aabb;
use glam::Vec4;
use rayon::prelude::*;

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
    /// Whether large parts are divided by where their primitives are along a space-filling curve:
    /// in four fifths of the time, for rays that are a fifth slower.
    pub curve: bool,
    /// In how many rounds parts of the finished tree look for a better place; each takes about as
    /// long as the tree itself.
    pub rounds: u32,
    /// How many triangles those who put a scene together may copy of meshes that stand in several
    /// places, so that all are in one tree, where rays find them soonest. What is beyond is to be
    /// stored once ([`SharedMesh`](crate::SharedMesh)). A triangle takes 90 bytes or so.
    pub copies: u32,
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self {
            bins: 16,
            max_leaf: 4,
            traversal_cost: 1.0,
            intersection_cost: 1.0,
            curve: false,
            rounds: 0,
            copies: 1 << 20,
        }
    }
}

/// How much time a tree is worth. What rays find is the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// For what is edited while one looks at it.
    Fast,
    /// For a picture.
    #[default]
    Default,
    /// For a picture that takes long.
    High,
}

impl From<Quality> for BuildOptions {
    fn from(quality: Quality) -> Self {
        let default = Self::default();
        match quality {
            Quality::Fast => Self { curve: true, ..default },
            Quality::Default => default,
            Quality::High => Self { bins: 32, max_leaf: 1, rounds: 4, ..default },
        }
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
        Self::over(bounds.len(), |i| bounds[i], options)
    }

    /// The same over so many primitives, each with the box that `bounds` gives.
    pub(crate) fn over(
        count: usize,
        bounds: impl Fn(usize) -> Aabb + Sync,
        options: &BuildOptions,
    ) -> Self {
        assert!(count < 1 << 31, "too many primitives for one tree");
        let options = BuildOptions {
            bins: options.bins.clamp(2, MAX_BINS as u32),
            max_leaf: options.max_leaf.max(1),
            ..*options
        };
        let proper = |b: &Aabb| b.is_finite() && !b.is_empty();
        let item = |i: usize| Item::new(&bounds(i), i as u32);
        let mut items: Vec<Item> = (0..count).into_par_iter().map(item).collect();
        let mut left_out = LeftOut::default();
        items.retain(|item| {
            let keep = proper(&item.bounds.aabb());
            if !keep {
                left_out.count += 1;
                left_out.first.get_or_insert(item.number());
            }
            keep
        });

        let part = Part::around(&items);
        if options.curve {
            items = along_curve(&items, &part.centers);
        }
        let unit = unit_of(&part.bounds.aabb());
        let mut order = vec![0; items.len()];
        let grown = (!items.is_empty()).then(|| {
            let task = Task { items: &mut items, order: &mut order, place: 0, depth: 0, part };
            Builder::new(&options, unit).grow(task)
        });
        drop(items);
        let mut siblings = Vec::with_capacity(grown.as_ref().map_or(0, Grown::pairs));
        let root = grown.map(|grown| grown.put(&mut siblings));
        let bvh = Self { root, siblings, order, left_out, options };
        if options.rounds == 0 { bvh } else { optimized(bvh, options.rounds) }
    }
}

/// More bins than this gain nothing.
const MAX_BINS: usize = 64;

/// So few primitives are divided in the best of all places.
const SWEPT: usize = 16;

/// Parts with fewer primitives are built by one thread.
const PARALLEL_FROM: usize = 4096;

/// A box in four lanes. What is in the fourth one means nothing; it is kept near one, where all
/// arithmetic is quick.
#[derive(Clone, Copy)]
struct Span {
    min: Vec4,
    max: Vec4,
}

impl Span {
    const EMPTY: Self = Self {
        min: Vec4::new(f32::INFINITY, f32::INFINITY, f32::INFINITY, 1.0),
        max: Vec4::new(f32::NEG_INFINITY, f32::NEG_INFINITY, f32::NEG_INFINITY, 1.0),
    };

    #[inline(always)]
    fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    #[inline(always)]
    fn grown(self, point: Vec4) -> Self {
        Self { min: self.min.min(point), max: self.max.max(point) }
    }

    /// Twice the middle, which is as good where only the order counts.
    #[inline(always)]
    fn center2(&self) -> Vec4 {
        self.min + self.max
    }

    /// Half the surface area, in squares of what `unit` is one part of. Meaningless if empty.
    #[inline(always)]
    fn half_area(&self, unit: f32) -> f32 {
        let [x, y, z, _] = ((self.max - self.min) * unit).to_array();
        x * (y + z) + y * z
    }

    fn aabb(&self) -> Aabb {
        Aabb { min: self.min.truncate(), max: self.max.truncate() }
    }
}

/// A power of two that brings areas within a box near to one, where they neither over- nor
/// underflow.
fn unit_of(bounds: &Aabb) -> f32 {
    let size = (bounds.max * 0.5 - bounds.min * 0.5).max_element();
    // The exponent alone.
    1.0 / f32::from_bits(size.clamp(1e-30, 1e30).to_bits() & 0x7f80_0000)
}

/// One primitive while the tree is built; its number stands in the bits of the fourth lane.
#[derive(Clone, Copy)]
struct Item {
    bounds: Span,
}

impl Item {
    fn new(bounds: &Aabb, number: u32) -> Self {
        let max = bounds.max.extend(f32::from_bits(number));
        Self { bounds: Span { min: bounds.min.extend(1.0), max } }
    }

    fn number(&self) -> u32 {
        self.bounds.max.w.to_bits()
    }
}

/// What some primitives fill together.
#[derive(Clone, Copy)]
struct Part {
    bounds: Span,
    /// Of twice their middles.
    centers: Span,
}

impl Part {
    fn around(items: &[Item]) -> Self {
        let nothing = Self { bounds: Span::EMPTY, centers: Span::EMPTY };
        items.iter().fold(nothing, |part, item| Self {
            bounds: part.bounds.union(item.bounds),
            centers: part.centers.grown(item.bounds.center2()),
        })
    }
}

/// Some primitives in a bin.
#[derive(Clone, Copy)]
struct Bin {
    bounds: Span,
    count: u32,
}

impl Bin {
    const EMPTY: Self = Self { bounds: Span::EMPTY, count: 0 };

    #[inline(always)]
    fn union(&self, other: &Self) -> Self {
        Self { bounds: self.bounds.union(other.bounds), count: self.count + other.count }
    }

    /// Area times number: the expected cost of meeting all, but for constants.
    #[inline(always)]
    fn cost(&self, unit: f32) -> f32 {
        self.bounds.half_area(unit) * self.count as f32
    }
}

/// A way to divide: what is in bins below `place`, or before it in the order along the axis, goes
/// left.
#[derive(Clone, Copy)]
struct Split {
    axis: usize,
    place: usize,
    cost: f32,
    bounds: [Span; 2],
    largest: usize,
}

/// What is added to a number from 0 to 2²³ is rounded to a whole one.
const WHOLE: f32 = (1 << 23) as f32;

/// Which bin a centre falls into.
#[derive(Clone, Copy)]
struct Binning {
    start: Vec4,
    scale: Vec4,
    last: Vec4,
}

impl Binning {
    fn new(centers: &Span, bins: u32) -> Self {
        // Along an axis without extent, or with one beyond all numbers, the
        // scale is infinite, zero or NaN, and all fall into one bin.
        let scale = Vec4::splat(bins as f32) / (centers.max - centers.min);
        Self { start: centers.min, scale, last: Vec4::splat((bins - 1) as f32) }
    }

    /// The bin along each axis, in the low bits of a float. Takes NaN to zero.
    #[inline(always)]
    fn places(&self, center2: Vec4) -> Vec4 {
        // Half a bin less, rounded to the nearest whole number by what is added.
        let place = (center2 - self.start) * self.scale - Vec4::splat(0.5);
        place.max(Vec4::ZERO).min(self.last) + Vec4::splat(WHOLE)
    }

    #[inline(always)]
    fn bins_of(&self, center2: Vec4) -> [usize; 3] {
        let [x, y, z, _] = self.places(center2).to_array();
        [x, y, z].map(|place| place.to_bits() as usize % MAX_BINS)
    }
}

/// A part that is still to be built.
struct Task<'a> {
    items: &'a mut [Item],
    /// The numbers go here, leaf after leaf.
    order: &'a mut [u32],
    /// Of the first item in the whole order.
    place: usize,
    depth: usize,
    part: Part,
}

impl Task<'_> {
    /// All of it in one leaf.
    fn into_leaf(self) -> Node {
        for (place, item) in self.order.iter_mut().zip(&*self.items) {
            *place = item.number();
        }
        Node::leaf(self.part.bounds.aabb(), self.place as u32, self.items.len() as u32)
    }

    /// Both sides of a division.
    fn split(self, middle: usize, parts: [Part; 2]) -> [Self; 2] {
        let (left, right) = self.items.split_at_mut(middle);
        let (left_order, right_order) = self.order.split_at_mut(middle);
        let (place, depth) = (self.place, self.depth + 1);
        [
            Self { items: left, order: left_order, place, depth, part: parts[0] },
            Self { items: right, order: right_order, place: place + middle, depth, part: parts[1] },
        ]
    }
}

/// A tree whose parts were built apart.
enum Grown {
    /// A node, and what is below it.
    Part(Node, Vec<Siblings>),
    Both(Aabb, Box<[Grown; 2]>),
}

impl Grown {
    /// How many pairs of siblings there are.
    fn pairs(&self) -> usize {
        match self {
            Self::Part(_, below) => below.len(),
            Self::Both(_, both) => 1 + both.iter().map(Self::pairs).sum::<usize>(),
        }
    }

    /// Puts everything into one list, in depth-first order; gives the root.
    fn put(self, out: &mut Vec<Siblings>) -> Node {
        let children = out.len();
        match self {
            Self::Part(root, below) => {
                let moved = |mut node: Node| {
                    if node.count == 0 {
                        node.first += children as u32;
                    }
                    node
                };
                out.extend(below.iter().map(|pair| Siblings(pair.0.map(moved))));
                moved(root)
            }
            Self::Both(bounds, both) => {
                // The children's place comes before all that is below them.
                let root = Node::inner(bounds, children as u32);
                out.push(Siblings([root; 2]));
                out[children] = Siblings(both.map(|child| child.put(out)));
                root
            }
        }
    }
}

struct Builder<'a> {
    options: &'a BuildOptions,
    /// See [`unit_of`].
    unit: f32,
    bins: Box<[[Bin; MAX_BINS]; 3]>,
    few: Box<Few>,
    out: Vec<Siblings>,
}

impl<'a> Builder<'a> {
    fn new(options: &'a BuildOptions, unit: f32) -> Self {
        let bins = Box::new([[Bin::EMPTY; MAX_BINS]; 3]);
        Self { options, unit, bins, few: Box::new(Few::NONE), out: Vec::new() }
    }

    /// Builds a part, large ones by several threads.
    fn grow(mut self, task: Task<'_>) -> Grown {
        if task.items.len() < PARALLEL_FROM {
            self.out.reserve(task.items.len() * 5 / 8);
            let root = self.node(task);
            return Grown::Part(root, self.out);
        }
        let Some((middle, parts)) = self.divide(task.items, &task.part, task.depth) else {
            return Grown::Part(task.into_leaf(), Vec::new());
        };
        let bounds = task.part.bounds.aabb();
        let (options, unit) = (self.options, self.unit);
        let [left, right] = task.split(middle, parts);
        let (left, right) =
            rayon::join(|| self.grow(left), || Builder::new(options, unit).grow(right));
        Grown::Both(bounds, Box::new([left, right]))
    }

    /// Builds a part.
    fn node(&mut self, task: Task<'_>) -> Node {
        if task.items.len() <= SWEPT {
            self.few.take(task.items);
            let few = (0, task.items.len());
            let node = self.node_of_few(few, task.part.bounds, task.place, task.depth);
            self.few.give(task.items, task.order);
            return node;
        }
        // Find the cheapest way to divide, or make a leaf.
        let Some((middle, parts)) = self.divide(task.items, &task.part, task.depth) else {
            return task.into_leaf();
        };
        let bounds = task.part.bounds.aabb();
        // The children's place comes before all that is below them.
        let children = self.out.len();
        let node = Node::inner(bounds, children as u32);
        self.out.push(Siblings([node; 2]));
        let both = task.split(middle, parts).map(|task| self.node(task));
        self.out[children] = Siblings(both);
        node
    }

    /// Puts the items of the left child before those of the right one, more than can be few; gives the number on the left
    /// and what fills both sides, `None` for a leaf.
    fn divide(
        &mut self,
        items: &mut [Item],
        part: &Part,
        depth: usize,
    ) -> Option<(usize, [Part; 2])> {
        if self.options.curve {
            return Some(halves_along_curve(items));
        }
        let binning = Binning::new(&part.centers, self.options.bins);
        let split = self.binned(items, &binning);
        if self.is_leaf(items.len(), &part.bounds, split.map(|split| split.cost)) {
            return None;
        }
        if let Some(Split { axis, place, bounds, largest, .. }) = split
            && depth + 1 + halvings(largest) <= MAX_DEPTH
        {
            let below = WHOLE + place as f32;
            let (middle, centers) =
                partition(items, |center2| binning.places(center2)[axis] < below);
            let [left, right] = [0, 1].map(|i| Part { bounds: bounds[i], centers: centers[i] });
            return Some((middle, [left, right]));
        }

        // Equal centres, or too deep already: halve along the widest axis.
        let axis = widest(&part.centers);
        let middle = items.len() / 2;
        items.sort_unstable_by(|a, b| {
            let key = |item: &Item| item.bounds.center2()[axis];
            key(a).total_cmp(&key(b)).then(a.number().cmp(&b.number()))
        });
        let (left, right) = items.split_at(middle);
        Some((middle, [Part::around(left), Part::around(right)]))
    }

    /// Whether it is cheaper not to divide so many, if that can be done at this cost.
    fn is_leaf(&self, n: usize, bounds: &Span, divided: Option<f32>) -> bool {
        if n > self.options.max_leaf as usize {
            return false;
        }
        let area = bounds.half_area(self.unit);
        let (inner, each) = (self.options.traversal_cost, self.options.intersection_cost);
        divided.is_none_or(|cost| each * area * n as f32 <= inner * area + each * cost)
    }

    /// The cheapest of all planes between bins that leave no side empty.
    fn binned(&mut self, items: &[Item], binning: &Binning) -> Option<Split> {
        let bins = self.options.bins as usize;
        for axis in self.bins.iter_mut() {
            axis[..bins].fill(Bin::EMPTY);
        }
        for item in items {
            let place = binning.bins_of(item.bounds.center2());
            for (axis, place) in self.bins.iter_mut().zip(place) {
                let bin = &mut axis[place];
                bin.bounds = bin.bounds.union(item.bounds);
                bin.count += 1;
            }
        }

        // The axis, the bin, and how many are below it.
        let mut best: Option<(f32, usize, usize, usize)> = None;
        for (axis, bins) in self.bins.iter().map(|axis| &axis[..bins]).enumerate() {
            // Everything from a bin on, from the right; then the planes from the left.
            let mut from = [0.0; MAX_BINS];
            let mut sum = Bin::EMPTY;
            for (from, bin) in from.iter_mut().zip(bins).rev() {
                sum = sum.union(bin);
                *from = sum.cost(self.unit);
            }
            let mut left = Bin::EMPTY;
            for bin in 1..bins.len() {
                left = left.union(&bins[bin - 1]);
                if left.count == 0 || left.count as usize == items.len() {
                    continue;
                }
                let cost = left.cost(self.unit) + from[bin];
                if best.is_none_or(|(least, ..)| cost < least) {
                    best = Some((cost, axis, bin, left.count as usize));
                }
            }
        }
        let (cost, axis, place, count) = best?;
        let (left, right) = self.bins[axis][..bins].split_at(place);
        let all = |bins: &[Bin]| bins.iter().fold(Span::EMPTY, |all, bin| all.union(bin.bounds));
        let largest = count.max(items.len() - count);
        Some(Split { axis, place, cost, bounds: [all(left), all(right)], largest })
    }

    /// Builds a part of the few, which stand from `from` to `to` in each order.
    fn node_of_few(
        &mut self,
        (from, to): (usize, usize),
        bounds: Span,
        place: usize,
        depth: usize,
    ) -> Node {
        let n = to - from;
        let (first, count) = ((place + from) as u32, n as u32);
        if n == 1 {
            return Node::leaf(bounds.aabb(), first, count);
        }
        let mut split = self.few.swept((from, to), self.unit);
        if self.is_leaf(n, &bounds, Some(split.cost)) {
            return Node::leaf(bounds.aabb(), first, count);
        }
        if depth + 1 + halvings(split.largest) > MAX_DEPTH {
            split = self.few.halved((from, to));
        }
        let middle = self.few.partition((from, to), &split);
        let children = self.out.len();
        let node = Node::inner(bounds.aabb(), children as u32);
        self.out.push(Siblings([node; 2]));
        let [left, right] = split.bounds;
        let both = [
            self.node_of_few((from, middle), left, place, depth + 1),
            self.node_of_few((middle, to), right, place, depth + 1),
        ];
        self.out[children] = Siblings(both);
        node
    }
}

/// Few items, in the order of their middles along each axis at once: sorted once, they stay sorted
/// when they are divided.
struct Few {
    boxes: [Span; SWEPT],
    order: [[u8; SWEPT]; 3],
}

impl Few {
    const NONE: Self = Self { boxes: [Span::EMPTY; SWEPT], order: [[0; SWEPT]; 3] };

    /// Equal middles stay in the order of the items.
    fn take(&mut self, items: &[Item]) {
        let n = items.len().min(SWEPT);
        let mut middles = [[f32::INFINITY; SWEPT]; 3];
        for (i, item) in items.iter().take(SWEPT).enumerate() {
            self.boxes[i] = item.bounds;
            let center2 = item.bounds.center2().to_array();
            for (middles, middle) in middles.iter_mut().zip(center2) {
                middles[i] = middle;
            }
        }
        for (order, middles) in self.order.iter_mut().zip(&middles) {
            for (i, middle) in (0..).zip(&middles[..n]) {
                // How many come before.
                let mut rank = 0;
                for (j, other) in (0_u32..).zip(middles) {
                    rank += u32::from((other < middle) | ((other == middle) & (j < i)));
                }
                order[rank as usize % SWEPT] = i as u8;
            }
        }
    }

    /// The numbers, in the order of the leaves.
    fn give(&self, items: &[Item], order: &mut [u32]) {
        for (number, i) in order.iter_mut().zip(self.order[0]) {
            *number = items[usize::from(i)].number();
        }
    }

    #[inline(always)]
    fn at(&self, axis: usize, place: usize) -> Span {
        self.boxes[usize::from(self.order[axis][place % SWEPT]) % SWEPT]
    }

    fn around(&self, axis: usize, from: usize, to: usize) -> Span {
        (from..to).fold(Span::EMPTY, |all, place| all.union(self.at(axis, place)))
    }

    /// The cheapest of all ways to divide them where their middles do along some axis.
    fn swept(&self, (from, to): (usize, usize), unit: f32) -> Split {
        let n = to - from;
        if n == 2 {
            let bounds = [self.at(0, from), self.at(0, from + 1)];
            let cost = bounds[0].half_area(unit) + bounds[1].half_area(unit);
            return Split { axis: 0, place: from + 1, cost, bounds, largest: 1 };
        }
        let mut best = (f32::INFINITY, 0, from + n / 2);
        for axis in 0..3 {
            let mut costs = [0.0; SWEPT];
            let mut sum = Span::EMPTY;
            for place in (from + 1..to).rev() {
                sum = sum.union(self.at(axis, place));
                costs[place % SWEPT] = sum.half_area(unit) * (to - place) as f32;
            }
            let mut left = Span::EMPTY;
            for place in from + 1..to {
                left = left.union(self.at(axis, place - 1));
                let cost = left.half_area(unit) * (place - from) as f32 + costs[place % SWEPT];
                if cost < best.0 {
                    best = (cost, axis, place);
                }
            }
        }
        let (cost, axis, place) = best;
        let bounds = [self.around(axis, from, place), self.around(axis, place, to)];
        Split { axis, place, cost, bounds, largest: (place - from).max(to - place) }
    }

    /// Half of them along the widest axis.
    fn halved(&self, (from, to): (usize, usize)) -> Split {
        let centers =
            (from..to).fold(Span::EMPTY, |all, place| all.grown(self.at(0, place).center2()));
        let axis = widest(&centers);
        let place = from + (to - from) / 2;
        let bounds = [self.around(axis, from, place), self.around(axis, place, to)];
        Split { axis, place, cost: 0.0, bounds, largest: to - place }
    }

    /// Brings the left ones before the right ones in every order; gives where those begin.
    fn partition(&mut self, (from, to): (usize, usize), split: &Split) -> usize {
        let mut is_left = [false; SWEPT];
        for i in &self.order[split.axis][from..split.place] {
            is_left[usize::from(*i) % SWEPT] = true;
        }
        for (axis, order) in self.order.iter_mut().enumerate() {
            if axis == split.axis {
                continue;
            }
            let before = *order;
            let (mut left, mut right) = (from, split.place);
            for i in &before[from..to] {
                let to_left = is_left[usize::from(*i) % SWEPT];
                order[if to_left { left } else { right } % SWEPT] = *i;
                left += usize::from(to_left);
                right += usize::from(!to_left);
            }
        }
        split.place
    }
}

/// The items in the order of their middles along Morton's curve, in whose cells of ten bits along
/// each axis; the cell stands in the bits of the fourth lane.
///
/// Source: Lauterbach et al., "Fast BVH Construction on GPUs", Eurographics 2009.
fn along_curve(items: &[Item], centers: &Span) -> Vec<Item> {
    let cells = Cells::new(centers);
    let key = |(i, item): (usize, &Item)| u64::from(cells.of(item)) << 32 | i as u64;
    let mut keys: Vec<u64> = items.par_iter().enumerate().map(key).collect();
    keys.par_sort_unstable();
    let item = |key: &u64| {
        let mut item = items[*key as u32 as usize];
        item.bounds.min.w = f32::from_bits((key >> 32) as u32);
        item
    };
    keys.par_iter().map(item).collect()
}

/// The cells of Morton's curve.
struct Cells {
    start: Vec4,
    scale: Vec4,
}

impl Cells {
    const ALONG_AXIS: f32 = 1024.0;

    fn new(centers: &Span) -> Self {
        let scale = Vec4::splat(Self::ALONG_AXIS) / (centers.max - centers.min);
        Self { start: centers.min, scale }
    }

    fn of(&self, item: &Item) -> u32 {
        let place = (item.bounds.center2() - self.start) * self.scale;
        // The cast takes NaN to zero and saturates.
        let [x, y, z, _] = place.to_array().map(|p| spread((p as u32).min(1023)));
        x << 2 | y << 1 | z
    }
}

/// Two zeros after each of ten bits.
fn spread(v: u32) -> u32 {
    let v = (v | v << 16) & 0x0300_00ff;
    let v = (v | v << 8) & 0x0300_f00f;
    let v = (v | v << 4) & 0x030c_30c3;
    (v | v << 2) & 0x0924_9249
}

/// Divides where the curve leaves the largest half that holds not all of them; in the middle of
/// one cell. Thirty divisions and the halvings after that stay within [`MAX_DEPTH`].
fn halves_along_curve(items: &[Item]) -> (usize, [Part; 2]) {
    let cell = |item: &Item| item.bounds.min.w.to_bits();
    let (first, last) = (items.first().map_or(0, cell), items.last().map_or(0, cell));
    let middle = match (first ^ last).checked_ilog2() {
        Some(bit) => items.partition_point(|item| cell(item) >> bit & 1 == 0),
        None => items.len() / 2,
    };
    let (left, right) = items.split_at(middle);
    (middle, [Part::around(left), Part::around(right)])
}

fn widest(centers: &Span) -> usize {
    let [x, y, z, _] = (centers.max - centers.min).to_array();
    if x >= y && x >= z { 0 } else { 1 + usize::from(z > y) }
}

/// How often n things must be halved until each stands alone: ⌈log₂ n⌉.
fn halvings(n: usize) -> usize {
    n.next_power_of_two().trailing_zeros() as usize
}

/// Moves what is `left` before the rest, in place; gives how many are left, and what holds twice the
/// middles of both sides.
#[inline(always)]
fn partition(items: &mut [Item], left: impl Fn(Vec4) -> bool) -> (usize, [Span; 2]) {
    let mut middle = 0;
    let mut centers = [Span::EMPTY; 2];
    for i in 0..items.len() {
        let item = items[i];
        let center2 = item.bounds.center2();
        let is_left = left(center2);
        let side = &mut centers[usize::from(!is_left)];
        *side = side.grown(center2);
        // What stands at `middle` is right, or this item itself.
        items[i] = items[middle];
        items[middle] = item;
        middle += usize::from(is_left);
    }
    (middle, centers)
}
