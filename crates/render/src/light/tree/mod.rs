//! The light tree: chooses one of very many emitters by what each may bring to a point.
//!
//! Emitters near each other are grouped, groups are grouped again, eight to a node. From the root
//! down, a group is chosen in proportion to what its bounds say that it may bring to the point: see
//! `node.rs`. The same steps tell the probability of any emitter, whose way from the root is known.
//!
//! One in [`ANY`] choices takes any emitter, each as often. So none is chosen more rarely than that,
//! whatever bounds and rounding make of it, and no light is lost.
//!
//! Not for a few lights: their power is known without a look at the point. Whether something is in
//! the way of a light is not looked at either.
//!
//! Source: Conty Estevez, Kulla, "Importance Sampling of Many Lights with Adaptive Tree
//! Splitting", HPG 2018, without the splitting: a path looks at one light at each surface. Pharr,
//! Jakob, Humphreys, *Physically Based Rendering*, 4th ed., section 12.6.3. Mixing with a uniform
//! choice: Hesterberg, "Weighted Average Importance Sampling and Defensive Mixture Distributions",
//! Technometrics 37, 1995.

mod build;
mod node;

use super::emitter::Emitter;
use super::shading_point::ShadingPoint;
use build::{Built, Item};
use fearless_simd::{Fallback, Level, Simd};
use node::{Child, Node, Seer};
use rutilant_geom::{DVec3, with_vectors};

/// One of so many choices takes any emitter.
const ANY: f64 = 64.0;

/// Emitters within the scene, grouped.
#[derive(Clone, Debug)]
pub(crate) struct LightTree {
    nodes: Vec<Node>,
    /// The way to each emitter, by its number; [`NOWHERE`](Self::NOWHERE) where it is not in the tree.
    ways: Vec<u64>,
    /// The numbers of all emitters that are.
    numbers: Vec<u32>,
    /// The tree's coordinates: all emitters lie within 1 of this.
    origin: DVec3,
    scale: f64,
}

impl LightTree {
    /// Not the way to any emitter: ways have 63 bits.
    const NOWHERE: u64 = u64::MAX;

    /// The tree of those emitters that shine from somewhere within the scene. `None` where there
    /// are none, or too many for 31 bits.
    pub(crate) fn new(emitters: &[Emitter]) -> Option<Self> {
        let bounds = || (0..).zip(emitters).filter_map(|(i, e)| Some((i, e.bounds()?)));
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (mut brightest, mut count) = (0.0, 0);
        for (_, bounds) in bounds() {
            (low, high) = (low.min(bounds.low), high.max(bounds.high));
            brightest = bounds.intensity.max(brightest);
            count += 1;
        }
        if count == 0 || emitters.len() >= 1 << 31 {
            return None;
        }
        let origin = (low + high) * 0.5;
        let radius = (high - origin).length();
        let scale = if radius > 0.0 { 1.0 / radius } else { 1.0 };
        let mut items = Vec::with_capacity(count);
        items.extend(bounds().map(|(i, b)| Item::new(i, &b, origin, scale, brightest)));
        let numbers = items.iter().map(Item::number).collect();
        let Built { nodes, ways } = build::build(&mut items, emitters.len(), Self::NOWHERE);
        Some(Self { nodes, ways, numbers, origin, scale })
    }

    /// The number of an emitter that may light `point`, and the probability of this choice; `None`
    /// where a look at the point shows that none does. `u` in [0, 1) is stretched at each step
    /// down, so it needs more digits than single precision has.
    pub(super) fn select(
        &self,
        level: Level,
        point: &ShadingPoint,
        u: f64,
    ) -> Option<(usize, f32)> {
        let seer = self.seer(point);
        let u = u * ANY;
        if u < 1.0 {
            let count = self.numbers.len();
            let number = self.numbers[((u * count as f64) as usize).min(count - 1)] as usize;
            return Some((number, self.pmf_seen(level, &seer, number)));
        }
        let u = (u - 1.0) / (ANY - 1.0);
        let (number, pmf) = with_vectors!(level, simd => self.descend(simd, &seer, u),
            else self.descend(Fallback::new(), &seer, u))?;
        Some((number, self.mixed(pmf)))
    }

    /// The choice of the tree alone.
    #[inline(always)]
    fn descend<S: Simd>(&self, simd: S, seer: &Seer, mut u: f64) -> Option<(usize, f32)> {
        let (mut node, mut pmf) = (0, 1.0);
        loop {
            let shares = self.nodes[node].shares(simd, seer);
            let mut left = u * f64::from(shares.total);
            let (mut chosen, mut before) = (None, 0.0);
            for (i, &share) in shares.each.iter().enumerate() {
                if share > 0.0 {
                    (chosen, before) = (Some(i), left);
                    if left < f64::from(share) {
                        break;
                    }
                    left -= f64::from(share);
                }
            }
            // Where no group shines here there is nothing to choose.
            let chosen = chosen?;
            let share = shares.each[chosen];
            pmf *= share / shares.total;
            match self.nodes[node].child(chosen) {
                Child::Node(next) => node = next as usize,
                Child::Emitter(number) => return Some((number as usize, pmf)),
                Child::None => return None,
            }
            u = (before / f64::from(share)).clamp(0.0, 1.0 - 0.5 * f64::EPSILON);
        }
    }

    /// The probability of choosing `emitter` for `point`; 0 for those that are not in the tree.
    pub(super) fn pmf(&self, level: Level, point: &ShadingPoint, emitter: usize) -> f32 {
        self.pmf_seen(level, &self.seer(point), emitter)
    }

    fn pmf_seen(&self, level: Level, seer: &Seer, emitter: usize) -> f32 {
        let way = self.ways[emitter];
        if way == Self::NOWHERE {
            return 0.0;
        }
        self.mixed(with_vectors!(level, simd => self.follow(simd, seer, way),
            else self.follow(Fallback::new(), seer, way)))
    }

    /// The probability with which the tree alone goes this way.
    #[inline(always)]
    fn follow<S: Simd>(&self, simd: S, seer: &Seer, mut way: u64) -> f32 {
        let (mut node, mut pmf) = (0, 1.0);
        loop {
            let (shares, chosen) = (self.nodes[node].shares(simd, seer), (way & 7) as usize);
            let share = shares.each[chosen];
            if share == 0.0 {
                return 0.0;
            }
            pmf *= share / shares.total;
            match self.nodes[node].child(chosen) {
                Child::Node(next) => node = next as usize,
                Child::Emitter(_) => return pmf,
                Child::None => return 0.0,
            }
            way >>= 3;
        }
    }

    /// The probability of what the tree alone chooses with `pmf`.
    fn mixed(&self, pmf: f32) -> f32 {
        let any = 1.0 / ANY as f32;
        pmf * (1.0 - any) + any / self.numbers.len() as f32
    }

    fn seer(&self, point: &ShadingPoint) -> Seer {
        /// Farther off, in sizes of the tree, all directions and distances are the same; and no
        /// square overflows.
        const FARTHEST: f64 = 1e15;
        let local = (point.position.as_dvec3() - self.origin) * self.scale;
        let farthest = DVec3::splat(FARTHEST);
        Seer { position: local.clamp(-farthest, farthest).as_vec3(), normal: point.normal }
    }
}
