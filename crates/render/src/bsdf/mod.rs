//! How a surface scatters light at a point.
//!
//! A [`Bsdf`] is a weighted sum of [`Lobe`]s, or the layers of a [`Principled`] surface. Directions are unit vectors in
//! the shading frame, z along the normal; both point away from the surface:
//! `wo` to where light leaves, `wi` to where it came from. Each lobe holds on
//! both sides of the surface.

mod beckmann;
mod conductor;
mod dielectric;
mod energy;
mod fresnel;
mod gloss;
mod lambert;
mod microfacet;
mod mirror;
mod oren_nayar;
mod principled;
mod rough_conductor;
mod rough_dielectric;
mod sample;
mod sheen;
mod thin_dielectric;
mod thin_film;
mod uniform_lambert;

pub use conductor::SmoothConductor;
pub use dielectric::SmoothDielectric;
pub use fresnel::Fresnel;
pub use lambert::Lambert;
pub use microfacet::{Distribution, Ggx};
pub use mirror::PerfectMirror;
pub use oren_nayar::OrenNayar;
pub use principled::{Principled, PrincipledParameters};
pub use rough_conductor::RoughConductor;
pub use rough_dielectric::RoughDielectric;
pub use sample::BsdfSample;
pub(crate) use sample::BsdfSamples;
pub use thin_dielectric::ThinDielectric;
pub use uniform_lambert::UniformLambert;

use crate::color::Spectrum;
use rutilant_geom::{Vec2, Vec3};

/// One way of scattering.
///
/// What rough lobes do is called and not inlined here: simple ones would pay for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lobe {
    /// Diffuse reflection.
    Lambert(Lambert),
    /// The same, with evenly drawn directions.
    UniformLambert(UniformLambert),
    /// Diffuse reflection from a rough surface.
    OrenNayar(OrenNayar),
    /// Mirror reflection, the same at every angle.
    Mirror(PerfectMirror),
    /// Mirror reflection as metal does it.
    Conductor(SmoothConductor),
    /// Reflection by rough metal.
    RoughConductor(RoughConductor),
    /// Reflection and refraction.
    Dielectric(SmoothDielectric),
    /// Reflection and refraction at a rough border.
    RoughDielectric(RoughDielectric),
    /// Reflection by a pane, and the way through it.
    ThinDielectric(ThinDielectric),
}

impl Lobe {
    /// True for a lobe that scatters into single directions: it can only be sampled.
    pub fn is_delta(&self) -> bool {
        match self {
            Self::Lambert(_)
            | Self::UniformLambert(_)
            | Self::OrenNayar(_)
            | Self::RoughConductor(_)
            | Self::RoughDielectric(_) => false,
            Self::Mirror(_)
            | Self::Conductor(_)
            | Self::Dielectric(_)
            | Self::ThinDielectric(_) => true,
        }
    }

    /// True for a lobe that scatters light through the surface, and not into single directions.
    pub fn is_translucent(&self) -> bool {
        match self {
            Self::RoughDielectric(_) => true,
            Self::Lambert(_)
            | Self::UniformLambert(_)
            | Self::OrenNayar(_)
            | Self::RoughConductor(_)
            | Self::Mirror(_)
            | Self::Conductor(_)
            | Self::Dielectric(_)
            | Self::ThinDielectric(_) => false,
        }
    }

    /// True for a lobe that [`sample`](Self::sample)s in one of several ways, by `choice`.
    fn chooses(&self) -> bool {
        match self {
            Self::OrenNayar(_)
            | Self::RoughConductor(_)
            | Self::Dielectric(_)
            | Self::RoughDielectric(_)
            | Self::ThinDielectric(_) => true,
            Self::Lambert(_) | Self::UniformLambert(_) | Self::Mirror(_) | Self::Conductor(_) => {
                false
            }
        }
    }

    /// BSDF value times cosine, `f(wo, wi) |cos θi|`, and the density with which
    /// [`sample`](Self::sample) draws `wi`, both in 1/sr. Zero for delta lobes.
    #[inline]
    pub fn eval_cos_pdf(&self, wo: Vec3, wi: Vec3) -> (Spectrum, f32) {
        match self {
            Self::Lambert(l) => (l.eval_cos(wo, wi), l.pdf(wo, wi)),
            Self::UniformLambert(l) => (l.eval_cos(wo, wi), l.pdf(wo, wi)),
            Self::OrenNayar(l) => (l.eval_cos(wo, wi), l.pdf(wo, wi)),
            Self::RoughConductor(l) => l.eval_cos_pdf(wo, wi),
            Self::RoughDielectric(l) => l.eval_cos_pdf(wo, wi),
            Self::Mirror(_)
            | Self::Conductor(_)
            | Self::Dielectric(_)
            | Self::ThinDielectric(_) => (Spectrum::BLACK, 0.0),
        }
    }

    /// Draws the direction the light came from. `choice` and `u` hold numbers in [0, 1).
    /// `None` where nothing is scattered.
    #[inline]
    pub fn sample(&self, wo: Vec3, choice: f32, u: Vec2) -> Option<BsdfSample> {
        match self {
            Self::Lambert(l) => l.sample(wo, u),
            Self::UniformLambert(l) => l.sample(wo, u),
            Self::OrenNayar(l) => l.sample(wo, choice, u),
            Self::Mirror(l) => l.sample(wo),
            Self::Conductor(l) => l.sample(wo),
            Self::RoughConductor(l) => l.sample(wo, choice, u),
            Self::Dielectric(l) => l.sample(wo, choice),
            Self::RoughDielectric(l) => l.sample(wo, choice, u),
            Self::ThinDielectric(l) => l.sample(wo, choice),
        }
    }

    /// About what part of white light it sends on, 0 to 1 per channel: for choosing between
    /// lobes, for roulette and for pictures of albedo, not for energy balances.
    pub fn albedo(&self) -> Spectrum {
        match self {
            Self::Lambert(l) => l.albedo,
            Self::UniformLambert(l) => l.albedo,
            Self::OrenNayar(l) => l.albedo(),
            Self::Mirror(l) => l.reflectance,
            Self::Conductor(l) => l.albedo(),
            Self::RoughConductor(l) => l.albedo(),
            Self::Dielectric(_) | Self::RoughDielectric(_) => Spectrum::WHITE,
            Self::ThinDielectric(l) => l.albedo(),
        }
    }
}

/// How a surface scatters: nothing, one lobe, a weighted sum of several, or layers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bsdf {
    form: Form,
    /// How many lobes are not deltas; of layers 1 where some of them are not.
    spread: u8,
    /// Whether one of those scatters light through the surface.
    translucent: bool,
    /// Whether sampling has a choice to make.
    chooses: bool,
}

/// What a BSDF is made of.
#[expect(clippy::large_enum_variant, reason = "it is copied once for a material, or for a hit")]
#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    Sum([Option<WeightedLobe>; Bsdf::MAX_LOBES]),
    Layers(Principled),
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct WeightedLobe {
    lobe: Lobe,
    /// The factor on its value.
    weight: f32,
    /// How often it is chosen. All add up to 1.
    pmf: f32,
}

/// How a surface scatters light.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Scattering {
    /// Not at all.
    Black,
    /// A matte surface of this albedo.
    Lambert(Spectrum),
    /// A smooth border of this relative index, exactly as the Fresnel equations say.
    Dielectric(f32),
    /// Like nothing of the above.
    Other,
}

impl Default for Bsdf {
    fn default() -> Self {
        Self::BLACK
    }
}

impl From<PrincipledParameters> for Bsdf {
    /// Cheap enough to be done at every hit.
    fn from(parameters: PrincipledParameters) -> Self {
        Principled::new(parameters).into()
    }
}

impl From<Principled> for Bsdf {
    fn from(layers: Principled) -> Self {
        Self {
            form: Form::Layers(layers),
            spread: u8::from(layers.has_spread()),
            translucent: layers.is_translucent(),
            chooses: true,
        }
    }
}

impl From<Lobe> for Bsdf {
    fn from(lobe: Lobe) -> Self {
        Self::sum([(1.0, lobe)])
    }
}

impl Bsdf {
    /// What it is, for eight paths at once.
    pub(crate) fn scattering(&self) -> Scattering {
        let lobes = match &self.form {
            Form::Sum(lobes) => lobes,
            Form::Layers(_) => return Scattering::Other,
        };
        match lobes {
            [None, None] => Scattering::Black,
            [Some(WeightedLobe { lobe, weight: 1.0, pmf: 1.0 }), None] => match lobe {
                Lobe::Lambert(l) => Scattering::Lambert(l.albedo),
                Lobe::Dielectric(SmoothDielectric { eta, fresnel: Fresnel::Exact }) => {
                    Scattering::Dielectric(*eta)
                }
                Lobe::UniformLambert(_)
                | Lobe::OrenNayar(_)
                | Lobe::Mirror(_)
                | Lobe::Conductor(_)
                | Lobe::RoughConductor(_)
                | Lobe::Dielectric(_)
                | Lobe::RoughDielectric(_)
                | Lobe::ThinDielectric(_) => Scattering::Other,
            },
            _ => Scattering::Other,
        }
    }

    /// The most lobes that one surface may have.
    pub const MAX_LOBES: usize = 2;

    /// Absorbs everything.
    pub const BLACK: Self =
        Self { form: Form::Sum([None; 2]), spread: 0, translucent: false, chooses: false };

    /// Lobes with their weights; those that send nothing back are left out, as are those
    /// beyond [`MAX_LOBES`](Self::MAX_LOBES). Each is chosen in proportion to weight and albedo.
    pub fn sum(lobes: impl IntoIterator<Item = (f32, Lobe)>) -> Self {
        let importance = |weight: f32, lobe: &Lobe| weight * lobe.albedo().max_channel();
        // What is no number stays, and is found in the picture.
        let sends = |weight: f32, lobe: &Lobe| {
            let importance = importance(weight, lobe);
            importance > 0.0 || importance.is_nan()
        };
        let mut kept = lobes.into_iter().filter(|(weight, lobe)| sends(*weight, lobe));
        let kept: [_; Self::MAX_LOBES] = std::array::from_fn(|_| kept.next());
        let total: f32 = kept.iter().flatten().map(|(w, l)| importance(*w, l)).sum();
        let lobes = || kept.iter().flatten().map(|(_, lobe)| lobe);
        Self {
            spread: lobes().filter(|l| !l.is_delta()).count() as u8,
            translucent: lobes().any(Lobe::is_translucent),
            chooses: lobes().count() > 1 || lobes().any(Lobe::chooses),
            form: Form::Sum(kept.map(|kept| {
                kept.map(|(weight, lobe)| WeightedLobe {
                    lobe,
                    weight,
                    pmf: importance(weight, &lobe) / total,
                })
            })),
        }
    }

    /// Those of a sum.
    fn lobes(&self) -> impl Iterator<Item = &WeightedLobe> {
        let lobes = match &self.form {
            Form::Sum(lobes) => lobes.as_slice(),
            Form::Layers(_) => &[],
        };
        lobes.iter().flatten()
    }

    /// The same with another index of refraction below over that above, where light can cross:
    /// for borders whose sides are known only where a ray meets them.
    #[must_use]
    pub(crate) fn with_eta(self, eta: f32) -> Self {
        if let Form::Layers(layers) = &self.form {
            return layers.with_eta(eta).into();
        }
        let lobe = |lobe| match lobe {
            Lobe::Dielectric(l) => Lobe::Dielectric(SmoothDielectric { eta, ..l }),
            Lobe::RoughDielectric(l) => l.with_eta(eta).map_or(
                Lobe::Dielectric(SmoothDielectric { eta, fresnel: Fresnel::Exact }),
                Lobe::RoughDielectric,
            ),
            Lobe::Lambert(_)
            | Lobe::UniformLambert(_)
            | Lobe::OrenNayar(_)
            | Lobe::Mirror(_)
            | Lobe::Conductor(_)
            | Lobe::RoughConductor(_)
            | Lobe::ThinDielectric(_) => lobe,
        };
        Self::sum(self.lobes().map(|l| (l.weight, lobe(l.lobe))))
    }

    /// True when light sampling can find nothing here: every lobe is a delta, or there is none.
    pub fn is_delta(&self) -> bool {
        self.spread == 0
    }

    /// True when some of it is scattered into single directions.
    pub(crate) fn has_delta(&self) -> bool {
        match &self.form {
            Form::Sum(_) => self.lobes().count() > usize::from(self.spread),
            Form::Layers(layers) => layers.has_delta(),
        }
    }

    /// How often [`sample`](Self::sample) scatters into a single direction.
    pub(crate) fn delta_pmf(&self) -> f32 {
        match &self.form {
            Form::Sum(_) => self.lobes().filter(|l| l.lobe.is_delta()).map(|l| l.pmf).sum(),
            Form::Layers(layers) => layers.delta_pmf(),
        }
    }

    /// True when what [`sample`](Self::sample) gives depends on `choice`.
    pub(crate) fn chooses(&self) -> bool {
        self.chooses
    }

    /// True when light sampling can find light beyond the surface.
    pub fn is_translucent(&self) -> bool {
        self.translucent
    }

    /// BSDF value times cosine, `f(wo, wi) |cos θi|`, and the density with which
    /// [`sample`](Self::sample) draws `wi`, both in 1/sr and without the delta lobes.
    #[inline]
    pub fn eval_cos_pdf(&self, wo: Vec3, wi: Vec3) -> (Spectrum, f32) {
        if let Form::Layers(layers) = &self.form {
            return layers.eval_cos_pdf(wo, wi);
        }
        let mut sum = (Spectrum::BLACK, 0.0);
        for l in self.lobes() {
            let (value, pdf) = l.lobe.eval_cos_pdf(wo, wi);
            sum = (sum.0 + value * l.weight, sum.1 + pdf * l.pmf);
        }
        sum
    }

    /// BSDF value times cosine, `f(wo, wi) |cos θi|`, in 1/sr, without the delta lobes.
    pub fn eval_cos(&self, wo: Vec3, wi: Vec3) -> Spectrum {
        self.eval_cos_pdf(wo, wi).0
    }

    /// The density with which [`sample`](Self::sample) draws `wi` from the lobes that are not
    /// deltas, in 1/sr.
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        self.eval_cos_pdf(wo, wi).1
    }

    /// Draws the direction the light came from, given `wo`, where it leaves to.
    ///
    /// `choice` and `u` hold numbers in [0, 1). `None` where nothing is scattered.
    pub fn sample(&self, wo: Vec3, choice: f32, u: Vec2) -> Option<BsdfSample> {
        if let Form::Layers(layers) = &self.form {
            return layers.sample(wo, choice, u);
        }
        // Find the lobe; what is left of the choice is as good as new.
        let mut left = choice;
        let mut chosen = None;
        for lobe in self.lobes() {
            chosen = Some((lobe, (left / lobe.pmf).min(BELOW_ONE)));
            if left < lobe.pmf {
                break;
            }
            left -= lobe.pmf;
        }
        let (chosen, choice) = chosen?;
        let sample = chosen.lobe.sample(wo, choice, u)?;

        // Only this lobe could have drawn it, or others as well.
        if sample.delta || self.spread == 1 {
            let weight = sample.weight * (chosen.weight / chosen.pmf);
            return Some(BsdfSample { weight, pdf: sample.pdf * chosen.pmf, ..sample });
        }
        let (value, pdf) = self.eval_cos_pdf(wo, sample.wi);
        let weight = value / pdf;
        (pdf > 0.0).then_some(BsdfSample { weight, pdf, ..sample })
    }

    /// About what part of white light is sent on, 0 to 1 per channel; see [`Lobe::albedo`].
    pub fn albedo(&self) -> Spectrum {
        if let Form::Layers(layers) = &self.form {
            return layers.albedo();
        }
        self.lobes().fold(Spectrum::BLACK, |sum, l| sum + l.lobe.albedo() * l.weight)
    }
}

/// The largest number below 1.
const BELOW_ONE: f32 = 1.0 - 0.5 * f32::EPSILON;
