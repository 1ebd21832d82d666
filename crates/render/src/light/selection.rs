//! Which of many lights to sample.
//!
//! Either all equally often, as in the 2017 report, or in proportion to power.
//! The power of lights at infinity says nothing about what they do at a point
//! (it grows with the scene), so each of them is chosen as often as all lights
//! within the scene together.
//!
//! Choosing takes the shading point, so that a light tree can stand here.

use super::emitter::Emitter;
use crate::math::distribution::Distribution1d;
use crate::settings::LightSelection;
use rutilant_geom::Vec3;

/// Chooses emitters by number.
#[derive(Clone, Debug)]
pub enum EmitterSelection {
    /// There are none.
    None,
    /// Each of this many equally often.
    Uniform(u32),
    /// In proportion to a weight.
    Weighted(Distribution1d),
}

impl EmitterSelection {
    /// Chooses among `emitters` in the way of `kind`; `scene_radius` as in [`Emitter::power`].
    pub fn new(kind: LightSelection, emitters: &[Emitter], scene_radius: f32) -> Self {
        Self::among(kind, emitters, scene_radius, |_| true)
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
    ) -> Self {
        Self::among(kind, emitters, scene_radius, |e| !e.is_even_sky())
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
        match kind {
            LightSelection::Uniform => uniform(),
            LightSelection::Power if emitters.len() == 1 => uniform(),
            LightSelection::Power => {
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
            }
        }
    }

    /// False where there is no choice, and [`select`](Self::select) needs no random number.
    pub fn chooses(&self) -> bool {
        match self {
            Self::None | Self::Uniform(1) => false,
            Self::Uniform(_) | Self::Weighted(_) => true,
        }
    }

    /// The number of an emitter that may light `from`, and the probability of this choice.
    #[inline]
    pub fn select(&self, _from: Vec3, u: f32) -> Option<(usize, f32)> {
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
        }
    }

    /// The probability of choosing `emitter` at `from`.
    #[inline]
    pub fn pmf(&self, _from: Vec3, emitter: usize) -> f32 {
        match self {
            Self::None => 0.0,
            Self::Uniform(count) => 1.0 / *count as f32,
            Self::Weighted(weights) => weights.pmf(emitter),
        }
    }
}
