//! Glass, water, gems: a smooth or rough border between two clear media.

use crate::bsdf::{Distribution, Fresnel};
use crate::color::{Rgb, Spectrum};
use crate::dispersion::{largest_index, most_dispersion};
use crate::problem::{NOT_NEGATIVE, POSITIVE, Place, SceneProblem, UNIT};
use rutilant_geom::real;

/// A border. The interior is where the surface normals point away from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    /// What is inside, glass of index 1.5 for example.
    pub interior: Medium,
    /// What is outside, most often air. If nothing absorbs there, what absorbed around the body
    /// before it was entered goes on doing so.
    pub exterior: Medium,
    /// How the reflected part is computed; exactly where the border is rough.
    pub fresnel: Fresnel,
    /// Which medium fills the place where bodies overlap: that of the highest priority, of equal
    /// ones that of the first material. Its border then has what surrounds it on the other side,
    /// and the exterior counts only where no other medium with a priority is. `None` takes no
    /// part: interior and exterior are as declared, everywhere.
    ///
    /// Bodies must be closed; they may overlap or touch. They may not glow.
    pub priority: Option<u32>,
    /// How rough the border is, 0 (smooth) to 1. The α of its facets is the square.
    pub roughness: f32,
    /// How its facets are distributed.
    pub distribution: Distribution,
    /// How much the index inside changes with the colour of light, 0 to 20: 20 over the Abbe number,
    /// 0 for not at all. The index itself is that for yellow light (587.6 nm). Crown glass has 0.31,
    /// flint glass 0.55 and more, diamond 0.36.
    pub dispersion: f32,
}

/// A clear medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Medium {
    /// Index of refraction, 1 for air, at least 1.
    pub ior: f32,
    /// The colour that light takes on inside.
    pub absorption: Absorption,
}

/// How light fades on its way through a medium (Beer's law).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Absorption {
    /// Not at all.
    None,
    /// To exp(−σ d) after a distance d: σ per metre, 0 or more.
    Coefficient(Rgb),
    /// To `color` (above 0, at most 1) after `distance` metres.
    ColorAtDistance {
        /// What is left of white light.
        color: Rgb,
        /// After how far, in metres.
        distance: f32,
    },
}

/// The highest index of refraction accepted; diamond has 2.42, germanium 4.
pub const MAX_IOR: f32 = 10.0;

/// The most that indices may differ by at a rough border. Beyond it light that is trapped inside
/// gets out so rarely that no number of samples finds it; diamond has 2.42.
pub const MOST_ROUGH_RATIO: f32 = 2.5;

/// The highest dispersion accepted: an Abbe number of 1.
pub const MAX_DISPERSION: f32 = 20.0;

/// Violet light must get out of rough glass again as well; `ratio` is that of its indices.
pub(super) fn check_rough_dispersion(place: Place, ratio: f32) -> Result<(), SceneProblem> {
    if ratio <= MOST_ROUGH_RATIO * 1.0001 {
        return Ok(());
    }
    let what = format!(
        "for violet light indices of refraction then differ by a factor of {ratio}, and roughness \
         must be 0: up to {MOST_ROUGH_RATIO} glass may be rough"
    );
    Err(place.problem("dispersion", what))
}

/// The most that rough glass of this index may disperse, at most [`MAX_DISPERSION`]: see [`Dielectric`].
pub fn most_rough_dispersion(ior: f32) -> f32 {
    most_dispersion(ior, MOST_ROUGH_RATIO).min(MAX_DISPERSION)
}

impl Medium {
    /// Air, or nothing.
    pub const AIR: Self = Self { ior: 1.0, absorption: Absorption::None };

    fn validate(
        &self,
        place: Place,
        ior: &'static str,
        absorption: bool,
    ) -> Result<(), SceneProblem> {
        place.check(ior, [self.ior], 1.0..=MAX_IOR)?;
        self.absorption.validate(place, |name| if absorption { name } else { ior })
    }
}

impl Absorption {
    /// `key` gives the key at which a problem with the one that it gets is told.
    pub(super) fn validate(
        &self,
        place: Place,
        key: impl Fn(&'static str) -> &'static str,
    ) -> Result<(), SceneProblem> {
        match *self {
            Self::None => Ok(()),
            Self::Coefficient(sigma) => place.check(key("sigma_a"), sigma.0, NOT_NEGATIVE),
            Self::ColorAtDistance { color, distance } => {
                place.check(key("absorption_color"), color.0, f32::MIN_POSITIVE..=1.0)?;
                place.check(key("absorption_distance"), [distance], POSITIVE)
            }
        }
    }

    /// The absorption coefficient σ in 1/m.
    pub fn coefficient(&self) -> Spectrum {
        match *self {
            Self::None => Spectrum::BLACK,
            Self::Coefficient(sigma) => sigma.into(),
            // The sum with zero makes −0 a plain 0.
            Self::ColorAtDistance { color, distance } => {
                Spectrum::from(color).map(|c| -real::ln(c) / distance + 0.0)
            }
        }
    }
}

impl Dielectric {
    /// Smooth clear glass of some index in air, with the exact Fresnel equations.
    pub fn new(ior: f32) -> Self {
        Self {
            interior: Medium { ior, absorption: Absorption::None },
            exterior: Medium::AIR,
            fresnel: Fresnel::Exact,
            priority: None,
            roughness: 0.0,
            distribution: Distribution::Ggx,
            dispersion: 0.0,
        }
    }

    pub(super) fn validate(&self, place: Place) -> Result<(), SceneProblem> {
        self.interior.validate(place, "ior", true)?;
        self.exterior.validate(place, "exterior_ior", false)?;
        place.check("roughness", [self.roughness], UNIT)?;
        let (a, b) = (self.interior.ior, self.exterior.ior);
        let ratio = (a / b).max(b / a);
        if self.roughness > 0.0 && ratio > MOST_ROUGH_RATIO {
            return Err(place.problem(
                "roughness",
                format!(
                    "roughness is {}, but where indices of refraction differ by a factor of \
                     {ratio} it must be 0: up to {MOST_ROUGH_RATIO} glass may be rough",
                    self.roughness
                ),
            ));
        }
        place.check("dispersion", [self.dispersion], 0.0..=MAX_DISPERSION)?;
        if self.roughness > 0.0 {
            check_rough_dispersion(place, largest_index(a, self.dispersion) / b)?;
        }
        match self.fresnel {
            Fresnel::Schlick if self.roughness > 0.0 => Err(place.problem(
                "fresnel",
                "fresnel \"schlick\" is for smooth glass; rough glass takes \"exact\"",
            )),
            Fresnel::Schlick | Fresnel::Exact => Ok(()),
        }
    }
}
