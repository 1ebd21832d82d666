//! Which of many lights to sample.
//!
//! All equally often, as in the 2017 report; in proportion to power; or, where there are many, by
//! what each may bring to the point that is lit (`tree/`).
//! The power of lights at infinity says nothing about what they do at a point
//! (it grows with the scene), so each of them is chosen as often as all lights
//! within the scene together.

use super::emitter::Emitter;
use super::shading_point::ShadingPoint;
use super::tree::LightTree;
use crate::math::distribution::Distribution1d;
use crate::settings::LightSelection;
use fearless_simd::Level;
use std::sync::Arc;

/// Chooses emitters by number.
#[derive(Clone, Debug)]
pub enum EmitterSelection {
    /// There are none.
    None,
    /// Each of this many equally often.
    Uniform(u32),
    /// In proportion to a weight.
    Weighted(Distribution1d),
    /// By what they may bring to the point.
    Tree(TreeSelection),
}

/// A tree of the lights within the scene, and the lights at infinity.
#[derive(Clone, Debug)]
pub struct TreeSelection {
    tree: Arc<LightTree>,
    /// The numbers of lights at infinity.
    endless: Vec<u32>,
    /// With which instructions the tree is looked at.
    level: Level,
}

/// From so many lights within the scene on, the tree is the usual choice. Fewer are not worth
/// looking at: example `many_lights`.
const MANY: usize = 6;

impl EmitterSelection {
    /// Chooses among `emitters` in the way of `kind`; `scene_radius` as in [`Emitter::power`].
    pub fn new(kind: LightSelection, emitters: &[Emitter], scene_radius: f32) -> Self {
        let tree = || Some((Arc::new(LightTree::new(emitters)?), Level::new()));
        Self::with_tree(kind, emitters, scene_radius, tree)
    }

    /// The same with the tree of these emitters, if it is needed, and the instructions to use.
    pub(crate) fn with_tree(
        kind: LightSelection,
        emitters: &[Emitter],
        scene_radius: f32,
        tree: impl FnOnce() -> Option<(Arc<LightTree>, Level)>,
    ) -> Self {
        Self::among(kind, emitters, scene_radius, tree, |_| true)
    }

    /// The same for paths that find light by scattered rays as well, weighted against each other:
    /// then light from everywhere alike is left to those.
    ///
    /// Source: Karlík et al., "MIS Compensation: Optimizing Sampling Techniques in Multiple
    /// Importance Sampling", SIGGRAPH Asia 2019: of an even sky nothing is left to sample.
    pub(crate) fn beside_scattering(
        kind: LightSelection,
        emitters: &[Emitter],
        scene_radius: f32,
        tree: impl FnOnce() -> Option<(Arc<LightTree>, Level)>,
    ) -> Self {
        Self::among(kind, emitters, scene_radius, tree, |e| !e.is_even_sky())
    }

    /// Chooses among some lights within the scene, by number, in proportion to their power.
    pub(crate) fn of(emitters: &[Emitter], chosen: impl Fn(usize) -> bool) -> Self {
        let power = |(i, e): (usize, &Emitter)| {
            if chosen(i) { f64::from(e.power(1.0).luminance()) } else { 0.0 }
        };
        let weights: Vec<f64> = emitters.iter().enumerate().map(power).collect();
        Distribution1d::new(weights.into_iter()).map_or(Self::None, Self::Weighted)
    }

    fn among(
        kind: LightSelection,
        emitters: &[Emitter],
        scene_radius: f32,
        tree: impl FnOnce() -> Option<(Arc<LightTree>, Level)>,
        chosen: impl Fn(&Emitter) -> bool,
    ) -> Self {
        let count = emitters.iter().filter(|e| chosen(e)).count();
        if count == 0 {
            return Self::None;
        }
        let uniform = || {
            if count == emitters.len() {
                return Self::Uniform(count as u32);
            }
            let weights = emitters.iter().map(|e| f64::from(u8::from(chosen(e))));
            Distribution1d::new(weights).map_or(Self::None, Self::Weighted)
        };
        let by_power = || {
            if emitters.len() == 1 {
                return uniform();
            }
            let power = |e: &Emitter| f64::from(e.power(scene_radius).luminance());
            let finite: f64 = emitters.iter().filter(|e| !e.is_infinite()).map(power).sum();
            let weights = emitters.iter().map(|e| match e.is_infinite() {
                _ if !chosen(e) => 0.0,
                true if power(e) == 0.0 => 0.0,
                true if finite > 0.0 => finite,
                true => 1.0,
                false => power(e),
            });
            let weights: Vec<f64> = weights.collect();
            Distribution1d::new(weights.into_iter()).map_or_else(uniform, Self::Weighted)
        };
        let by_tree = || {
            let shines = |e: &Emitter| e.is_infinite() && chosen(e) && !e.power(1.0).is_black();
            let endless = (0..).zip(emitters).filter(|(_, e)| shines(e)).map(|(i, _)| i);
            match tree() {
                Some((tree, level)) => {
                    Self::Tree(TreeSelection { tree, endless: endless.collect(), level })
                }
                // There are only lights at infinity.
                None => by_power(),
            }
        };
        match kind {
            LightSelection::Uniform => uniform(),
            LightSelection::Power => by_power(),
            LightSelection::Tree => by_tree(),
            LightSelection::Auto => {
                let finite = emitters.iter().filter(|e| e.bounds().is_some());
                if finite.take(MANY).count() == MANY { by_tree() } else { by_power() }
            }
        }
    }

    /// False where there is no choice, and [`select`](Self::select) needs no random number.
    pub fn chooses(&self) -> bool {
        match self {
            Self::None | Self::Uniform(1) => false,
            Self::Uniform(_) | Self::Weighted(_) | Self::Tree(_) => true,
        }
    }

    /// True where the choice depends on the point, and needs two random numbers.
    #[inline]
    pub fn looks(&self) -> bool {
        match self {
            Self::None | Self::Uniform(_) | Self::Weighted(_) => false,
            Self::Tree(_) => true,
        }
    }

    /// The number of an emitter that may light `point`, and the probability of this choice; `None`
    /// where there is none. `u` is in [0, 1), and so is `fine`, which says where between that and
    /// the next number of 24 bits; both are looked at only where [`chooses`](Self::chooses) and
    /// [`looks`](Self::looks) say so.
    #[inline]
    pub fn select(&self, point: &ShadingPoint, u: f32, fine: f32) -> Option<(usize, f32)> {
        match self {
            Self::None => None,
            Self::Uniform(count) => {
                let i = ((u * *count as f32) as u32).min(count - 1);
                Some((i as usize, 1.0 / *count as f32))
            }
            Self::Weighted(weights) => {
                let (i, _) = weights.sample_step(u);
                Some((i, weights.pmf(i)))
            }
            Self::Tree(all) => all.select(point, u, fine),
        }
    }

    /// The probability of choosing `emitter` for `point`.
    #[inline]
    pub fn pmf(&self, point: &ShadingPoint, emitter: usize) -> f32 {
        match self {
            Self::None => 0.0,
            Self::Uniform(count) => 1.0 / *count as f32,
            Self::Weighted(weights) => weights.pmf(emitter),
            Self::Tree(all) => all.pmf(point, emitter),
        }
    }
}

impl TreeSelection {
    fn select(&self, point: &ShadingPoint, u: f32, fine: f32) -> Option<(usize, f32)> {
        /// 2⁻²⁴, by which numbers drawn differ at least.
        const STEP: f64 = 0.5 * f32::EPSILON as f64;
        // 48 bits: with 24 a million emitters would get a few numbers each, and dim ones none.
        let u = f64::from(u) + f64::from(fine) * STEP;
        let parts = 1 + self.endless.len();
        let part = u * parts as f64;
        if let Some(&number) = self.endless.get(part as usize) {
            return Some((number as usize, 1.0 / parts as f32));
        }
        let within = (part - self.endless.len() as f64).min(1.0 - 0.5 * f64::EPSILON);
        let (emitter, pmf) = self.tree.select(self.level, point, within)?;
        Some((emitter, pmf / parts as f32))
    }

    fn pmf(&self, point: &ShadingPoint, emitter: usize) -> f32 {
        let parts = 1 + self.endless.len();
        if self.endless.contains(&(emitter as u32)) {
            return 1.0 / parts as f32;
        }
        self.tree.pmf(self.level, point, emitter) / parts as f32
    }
}
