//! Building the light tree: emitters that are near each other and shine alike go together.
//!
//! A node starts with all its emitters as one group and splits the group that promises the most
//! noise, until there are eight. A split is the best of some planes: its cost is each side's
//! intensity, times the square of its size, times how many directions it shines in.
//!
//! Emitters are moved into their places in one array; the numbers of nodes follow from depth-first
//! order. Groups of the root of a large tree are built at the same time, each apart from the others,
//! so that nothing depends on threads.
//!
//! Source: Conty Estevez, Kulla, "Importance Sampling of Many Lights with Adaptive Tree
//! Splitting", HPG 2018, section 4.4, whose cone of normals is here their mean direction: it is a
//! sum, and says as much. The mean's length as a measure of spread: Mardia, Jupp, *Directional
//! Statistics*, 2000, section 9.2.

use super::super::bounds::EmitterBounds;
use super::node::{Child, Group, Node, WIDTH};
use rayon::prelude::*;
use rutilant_geom::{DVec3, Vec3};
use std::ops::Range;

/// An emitter on its way into the tree, in the tree's coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    low: Vec3,
    high: Vec3,
    axis: Vec3,
    cos_normals: f32,
    cos_shines: f32,
    /// Relative to the brightest of all.
    intensity: f32,
    mean: f32,
    number: u32,
    two_sided: bool,
    /// From the root, as in [`Built`], once it is known.
    way: u64,
}

impl Item {
    /// The emitter of this number, seen from `origin` in units of 1 / `scale`. `brightest` is the
    /// largest intensity of all.
    pub(super) fn new(
        number: u32,
        bounds: &EmitterBounds,
        origin: DVec3,
        scale: f64,
        brightest: f64,
    ) -> Self {
        /// Narrower beams are taken for this wide, a degree: rounding would put them out.
        const WIDEST_COSINE: f32 = 0.9998;
        let local = |p: DVec3| ((p - origin) * scale).as_vec3();
        Self {
            low: local(bounds.low),
            high: local(bounds.high),
            axis: bounds.axis,
            cos_normals: bounds.cos_normals,
            cos_shines: bounds.cos_shines.min(WIDEST_COSINE),
            intensity: ((bounds.intensity / brightest) as f32).max(f32::MIN_POSITIVE),
            mean: bounds.mean,
            number,
            two_sided: bounds.two_sided,
            way: 0,
        }
    }

    pub(super) fn number(&self) -> u32 {
        self.number
    }

    fn center(&self) -> Vec3 {
        (self.low + self.high) * 0.5
    }

    /// How it counts in a mean direction: not at all if it shines all around; and two-sided ones
    /// on the same side.
    fn direction(&self) -> Vec3 {
        if self.cos_normals < 0.0 {
            Vec3::ZERO
        } else if self.two_sided && self.axis[self.axis.abs().max_position()] < 0.0 {
            -self.axis
        } else {
            self.axis
        }
    }
}

/// The tree, and the way from its root to each emitter.
pub(super) struct Built {
    pub(super) nodes: Vec<Node>,
    /// By the emitter's number, three bits a step, the first one lowest.
    pub(super) ways: Vec<u64>,
}

/// A node that is still to be made.
struct Task {
    items: Range<usize>,
    depth: u32,
    way: u64,
    /// The node above, and the group there.
    above: Option<(usize, usize)>,
}

/// Some emitters that follow each other, and how much noise they promise.
#[derive(Clone)]
struct Cluster {
    items: Range<usize>,
    cost: f32,
}

/// From this depth on groups are halved by number instead, so that no tree is deeper than ways of
/// 64 bits: each level then takes three bits off the number.
const HALVED_FROM: u32 = 9;

/// From so many emitters on the groups of the root are built at the same time.
const TOGETHER_FROM: usize = 1 << 15;

/// Builds the tree of some of `count` emitters; the way to all others is `nowhere`. Runs on the
/// current rayon thread pool.
pub(super) fn build(items: &mut [Item], count: usize, nowhere: u64) -> Built {
    let root = Task { items: 0..items.len(), depth: 0, way: 0, above: None };
    let nodes = if items.len() < TOGETHER_FROM { grow(items, root) } else { grow_all(items, root) };
    let mut ways = vec![nowhere; count];
    for item in items {
        ways[item.number as usize] = item.way;
    }
    Built { nodes, ways }
}

/// Makes the root here, and all else for each of its groups apart.
fn grow_all(items: &mut [Item], root: Task) -> Vec<Node> {
    let (mut node, mut tasks) = node_of(items, root, 0);
    let mut rest = items;
    let mut parts = Vec::with_capacity(WIDTH);
    let mut start = 0;
    // In the order of the emitters.
    tasks.sort_unstable_by_key(|task| task.items.start);
    for task in tasks {
        let (_, from) = std::mem::take(&mut rest).split_at_mut(task.items.start - start);
        let (own, after) = from.split_at_mut(task.items.len());
        (rest, start) = (after, task.items.end);
        parts.push((own, task));
    }
    let grown: Vec<(usize, Vec<Node>)> = parts
        .into_par_iter()
        .map(|(own, Task { depth, way, above, .. })| {
            let place = above.map_or(0, |(_, i)| i);
            (place, grow(own, Task { items: 0..own.len(), depth, way, above: None }))
        })
        .collect();
    let mut offset = 1;
    for (place, nodes) in &grown {
        node.set_child(*place, Child::Node(offset as u32));
        offset += nodes.len();
    }
    let mut all = Vec::with_capacity(offset);
    all.push(node);
    for (_, nodes) in grown {
        let offset = all.len() as u32;
        all.extend(nodes.into_iter().map(|node| node.moved(offset)));
    }
    all
}

/// Makes a node and everything below it, and tells each emitter its way.
fn grow(items: &mut [Item], top: Task) -> Vec<Node> {
    let (mut nodes, mut tasks) = (Vec::<Node>::with_capacity(items.len() / 4), vec![top]);
    while let Some(task) = tasks.pop() {
        let number = nodes.len();
        if let Some((above, i)) = task.above {
            nodes[above].set_child(i, Child::Node(number as u32));
        }
        let (node, below) = node_of(items, task, number);
        nodes.push(node);
        tasks.extend(below);
    }
    nodes
}

/// Makes one node of this number. What is below it is still to be made.
fn node_of(items: &mut [Item], task: Task, number: usize) -> (Node, Vec<Task>) {
    let Task { items: all, depth, way, .. } = task;
    let (mut node, mut below) = (Node::EMPTY, Vec::new());
    let clusters = eight_of(items, all, depth < HALVED_FROM);
    let totals: Vec<f64> = clusters.iter().map(|c| total_of(&items[c.items.clone()])).collect();
    let largest = totals.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    for (i, (Cluster { items: some, .. }, total)) in clusters.into_iter().zip(totals).enumerate() {
        node.set(i, &group_of(&items[some.clone()], total / largest));
        let way = way | (i as u64) << (3 * depth);
        if let [alone] = &mut items[some.clone()] {
            node.set_child(i, Child::Emitter(alone.number));
            alone.way = way;
        } else {
            below.push(Task { items: some, depth: depth + 1, way, above: Some((number, i)) });
        }
    }
    (node, below)
}

/// Splits emitters into up to eight groups. Those that fit into one node stay together, or go each
/// on its own where there is room.
fn eight_of(items: &mut [Item], all: Range<usize>, by_cost: bool) -> Vec<Cluster> {
    let mut clusters = Vec::with_capacity(WIDTH);
    clusters.push(Cluster { items: all, cost: f32::INFINITY });
    while clusters.len() < WIDTH {
        let promise = |c: &Cluster| match (c.items.len() > WIDTH, by_cost) {
            (false, _) => -1.0,
            (true, true) => c.cost,
            (true, false) => c.items.len() as f32,
        };
        let most = (0..clusters.len())
            .max_by(|&a, &b| promise(&clusters[a]).total_cmp(&promise(&clusters[b])));
        let Some(most) = most.filter(|&i| clusters[i].items.len() > WIDTH) else { break };
        let Cluster { items: Range { start, end }, .. } = clusters[most].clone();
        let (middle, [left, right]) = split(&mut items[start..end], by_cost);
        clusters[most] = Cluster { items: start..start + middle, cost: left };
        clusters.push(Cluster { items: start + middle..end, cost: right });
    }
    // The smallest first, each emitter in a place of its own, if that saves a node.
    while let Some(least) = (0..clusters.len())
        .filter(|&i| clusters[i].items.len() > 1)
        .min_by_key(|&i| clusters[i].items.len())
        .filter(|&i| clusters.len() - 1 + clusters[i].items.len() <= WIDTH)
    {
        let Cluster { items, cost } = clusters.swap_remove(least);
        clusters.extend(items.map(|i| Cluster { items: i..i + 1, cost }));
    }
    clusters
}

fn total_of(items: &[Item]) -> f64 {
    items.iter().map(|item| f64::from(item.intensity)).sum()
}

/// The bounds of some emitters, whose intensity relative to that of the brightest is known.
fn group_of(items: &[Item], share: f64) -> Group {
    let first = &items[0];
    let low = items.iter().fold(first.low, |low, item| low.min(item.low));
    let high = items.iter().fold(first.high, |high, item| high.max(item.high));
    let two_sided = items.iter().any(|item| item.two_sided);
    let share = (share as f32).max(f32::MIN_POSITIVE);
    let group = Group {
        center: (low + high) * 0.5,
        half: (high - low) * 0.5,
        axis: first.axis,
        cos_normals: first.cos_normals,
        cos_shines: items.iter().fold(1.0, |cos, item| item.cos_shines.min(cos)),
        two_sided,
        even: share,
        directed: 0.0,
    };
    if items.len() == 1 {
        let flat = first.cos_normals == 1.0 && first.cos_shines == 0.0;
        return if flat { Group { even: 0.0, directed: share, ..group } } else { group };
    }

    // Two-sided ones are turned to the side that most are on so far.
    let side = |axis: Vec3, to: Vec3| if two_sided && axis.dot(to) < 0.0 { -axis } else { axis };
    let (mut total, mut sent, mut moment) = (0.0, 0.0, Vec3::ZERO);
    for item in items {
        let sends = item.intensity * item.mean;
        (total, sent) = (total + item.intensity, sent + sends);
        if item.cos_normals > -1.0 {
            moment += side(item.axis, moment) * sends;
        }
    }
    // A cosine is ¼ on average over all directions, and ½ without its sign.
    let mean_cosine = if two_sided { 0.5 } else { 0.25 };
    let directed = (moment.length() / total / mean_cosine).min(1.0);
    let even = (sent / total - directed * mean_cosine).max(LEAST_EVEN);
    let group = Group { even: share * even, directed: share * directed, ..group };

    let Some(axis) = moment.try_normalize() else {
        return Group { cos_normals: -1.0, directed: 0.0, ..group };
    };
    let cos_normals = items.iter().fold(1.0_f32, |cos, item| {
        let to_axis = side(item.axis, axis).dot(axis);
        cos.min(cos_of_sum(to_axis, item.cos_normals))
    });
    // What the dot products are rounded by.
    Group { axis, cos_normals: (cos_normals - 1e-6).max(-1.0), ..group }
}

/// Of a group that shines one way only, what it may send elsewhere all the same: its emitters may
/// be turned a little.
const LEAST_EVEN: f32 = 1e-3;

/// The cosine of the sum of two angles of these cosines; −1 where that is more than π.
fn cos_of_sum(a: f32, b: f32) -> f32 {
    if a <= -b {
        return -1.0;
    }
    let sines = (1.0 - a * a).max(0.0) * (1.0 - b * b).max(0.0);
    a * b - sines.sqrt()
}

/// What lies between two planes.
#[derive(Clone, Copy)]
struct Bin {
    low: Vec3,
    high: Vec3,
    direction: Vec3,
    intensity: f32,
    count: u32,
}

impl Bin {
    const EMPTY: Self = Self {
        low: Vec3::INFINITY,
        high: Vec3::NEG_INFINITY,
        direction: Vec3::ZERO,
        intensity: 0.0,
        count: 0,
    };

    fn with(&self, other: &Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            direction: self.direction + other.direction,
            intensity: self.intensity + other.intensity,
            count: self.count + other.count,
        }
    }

    /// The noise that it promises. A length of the mean direction of 1 says that all shine into
    /// one hemisphere, π sr when weighted by the cosine, and 0 that they shine all around, 4 π;
    /// between them lies nearly the sine of half the angle of their cone, as in equation 1 of
    /// Conty Estevez and Kulla.
    fn cost(&self) -> f32 {
        let mean = self.direction.length() / self.count as f32;
        let spread = 1.0 + 3.0 * (1.0 - mean).max(0.0).sqrt();
        self.intensity * (self.high - self.low).length_squared() * spread
    }
}

/// Planes that are tried along each axis, and one more.
const BINS: usize = 12;

/// So many emitters, or up to twice as many, tell where to split.
const SAMPLE: usize = 512;

/// Moves emitters so that one side of a plane comes before the other. Returns where the other
/// begins, with something on both sides, and the costs of both.
fn split(items: &mut [Item], by_cost: bool) -> (usize, [f32; 2]) {
    let first = items[0].center();
    let (low, high) = items.iter().fold((first, first), |(low, high), item| {
        let center = item.center();
        (low.min(center), high.max(center))
    });
    let extent = high - low;
    if !by_cost || extent == Vec3::ZERO {
        return (halve(items, extent), [0.0; 2]);
    }

    // Fill the bins of all three axes; of very many emitters some tell enough.
    let per_length = Vec3::from_array(extent.to_array().map(|length| {
        let per_length = BINS as f32 * (1.0 - 1e-6) / length;
        if per_length.is_finite() { per_length } else { 0.0 }
    }));
    let bins_of = |item: &Item| {
        ((item.center() - low) * per_length).to_array().map(|bin| (bin as usize).min(BINS - 1))
    };
    let mut bins = [[Bin::EMPTY; BINS]; 3];
    for item in items.iter().step_by((items.len() / SAMPLE).max(1)) {
        let direction = item.direction();
        for (bins, place) in bins.iter_mut().zip(bins_of(item)) {
            let bin = &mut bins[place];
            bin.low = bin.low.min(item.low);
            bin.high = bin.high.max(item.high);
            bin.direction += direction;
            bin.intensity += item.intensity;
            bin.count += 1;
        }
    }

    // The best plane of all.
    let mut best: Option<(f32, usize, usize, [f32; 2])> = None;
    for (axis, bins) in bins.iter().enumerate() {
        let mut after = [Bin::EMPTY; BINS];
        let mut right = Bin::EMPTY;
        for (bin, after) in bins.iter().zip(&mut after).rev() {
            right = bin.with(&right);
            *after = right;
        }
        let mut left = Bin::EMPTY;
        for plane in 1..BINS {
            left = left.with(&bins[plane - 1]);
            if left.count == 0 || after[plane].count == 0 {
                continue;
            }
            let costs = [left.cost(), after[plane].cost()];
            let cost = costs[0] + costs[1];
            if best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, axis, plane, costs));
            }
        }
    }
    let Some((_, axis, plane, costs)) = best else { return (halve(items, extent), [0.0; 2]) };

    // Move those before it to the front.
    let (mut front, mut back) = (0, items.len());
    while front < back {
        if bins_of(&items[front])[axis] < plane {
            front += 1;
        } else {
            back -= 1;
            items.swap(front, back);
        }
    }
    (front, costs)
}

/// Halves emitters by their number, across the longest axis.
fn halve(items: &mut [Item], extent: Vec3) -> usize {
    let middle = items.len() / 2;
    let axis = (0..3).max_by(|&a, &b| extent[a].total_cmp(&extent[b])).unwrap_or(0);
    items.select_nth_unstable_by(middle, |a, b| {
        let by_place = a.center()[axis].total_cmp(&b.center()[axis]);
        by_place.then(a.number.cmp(&b.number))
    });
    middle
}
