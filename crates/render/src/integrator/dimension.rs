//! The decisions along a path, each with random numbers of its own.

use crate::bsdf::{Bsdf, BsdfSample};
use crate::light::{EmitterSelection, ShadingPoint};
use crate::sampler::Sampler;
use rutilant_geom::{Vec2, Vec3};

/// Where within the pixel's filter.
pub(crate) const FILM: u32 = 0;
/// Where on the lens.
pub(crate) const LENS: u32 = 1;

/// Which band of the spectrum is left, where one has to be chosen; as far from all other decisions as
/// those of light paths are.
pub(crate) const BAND: u32 = u32::MAX - 7;

/// The decisions at the start of a light path, and where it comes to the camera. They are the last
/// there are: no path from the camera is long enough to come to them.
pub(crate) mod light_path {
    /// Which lamp.
    pub(crate) const LAMP: u32 = u32::MAX;
    /// Where on it.
    pub(crate) const POINT: u32 = u32::MAX - 1;
    /// Towards which caster.
    pub(crate) const CASTER: u32 = u32::MAX - 2;
    /// In which direction.
    pub(crate) const DIRECTION: u32 = u32::MAX - 3;
    /// Through which point of the lens it is seen.
    pub(crate) const LENS: u32 = u32::MAX - 4;
    /// By which of the pixels that see it.
    pub(crate) const PIXEL: u32 = u32::MAX - 5;
    /// How what it brings is rounded.
    pub(crate) const ROUNDING: u32 = u32::MAX - 6;
}

/// The decisions at the end of a path's `depth`-th segment, from 1.
#[derive(Clone, Copy)]
pub(crate) struct Bounce(u32);

impl Bounce {
    pub(crate) fn at(depth: u32) -> Self {
        Self(5_u32.wrapping_mul(depth.wrapping_sub(1)).wrapping_add(2))
    }

    /// The same of a light path.
    pub(crate) fn of_light(depth: u32) -> Self {
        Self::at(depth.wrapping_add(1 << 29))
    }

    /// Which of the BSDF's ways to scatter.
    pub(crate) fn lobe(self) -> u32 {
        self.0
    }

    /// The scattered direction.
    pub(crate) fn direction(self) -> u32 {
        self.0.wrapping_add(1)
    }

    /// Which light.
    pub(crate) fn light(self) -> u32 {
        self.0.wrapping_add(2)
    }

    /// More digits of which light: far from all other decisions, which are few to a bounce.
    pub(crate) fn light_finely(self) -> u32 {
        self.0.wrapping_add(2 + (5 << 28))
    }

    /// Where on that light.
    pub(crate) fn light_point(self) -> u32 {
        self.0.wrapping_add(3)
    }

    /// Whether the path goes on.
    pub(crate) fn roulette(self) -> u32 {
        self.0.wrapping_add(4)
    }

    /// Draws the direction that a BSDF scatters into, with only the random numbers that it needs.
    #[inline]
    pub(crate) fn scatter<S: Sampler>(
        self,
        bsdf: &Bsdf,
        wo: Vec3,
        sampler: &S,
    ) -> Option<BsdfSample> {
        let choice = if bsdf.chooses() { sampler.d1(self.lobe()) } else { 0.0 };
        let u = if bsdf.is_delta() { Vec2::ZERO } else { sampler.d2(self.direction()) };
        bsdf.sample(wo, choice, u)
    }

    /// Chooses a light for `point`: its number, and the probability of this choice.
    #[inline]
    pub(crate) fn select<S: Sampler>(
        self,
        selection: &EmitterSelection,
        point: &ShadingPoint,
        sampler: &S,
    ) -> Option<(usize, f32)> {
        let u = if selection.chooses() { sampler.d1(self.light()) } else { 0.0 };
        let fine = if selection.looks() { sampler.d1(self.light_finely()) } else { 0.0 };
        selection.select(point, u, fine)
    }
}
