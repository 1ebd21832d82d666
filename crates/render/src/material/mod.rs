//! How surfaces look: what an author writes, and the lobes that come of it.

mod conductor;
mod custom;
mod dielectric;
mod emission;
mod matte;
mod metals;
mod mirror;
mod mix;
mod normal_map;
mod opacity;
mod principled;
mod sides;
mod thin_dielectric;

pub use conductor::Conductor;
pub use custom::{CustomMaterial, SurfacePoint};
pub use dielectric::{
    Absorption, Dielectric, MAX_DISPERSION, MAX_IOR, MOST_ROUGH_RATIO, Medium,
    most_rough_dispersion,
};
pub use emission::{Emission, EmittedLight};
pub use matte::{HemisphereSampling, Matte};
pub use metals::Metal;
pub use mirror::Mirror;
pub use mix::Mix;
pub use normal_map::{Bumps, NormalMap};
pub use opacity::{Opacity, OpacityMode};
pub use principled::{MAX_FILM_NM, MAX_SPECULAR_COLOR, Principled, PrincipledTextures};
pub use sides::Sides;
pub use thin_dielectric::ThinDielectric;

use crate::color::Rgb;
use crate::id::TextureId;
use crate::problem::{Place, SceneProblem, UNIT};
use std::sync::Arc;

/// Why a body with a priority has no emission.
const NO_GLOW_WITH_PRIORITY: &str = "a dielectric with a priority cannot glow: where it lies \
                                     within another, its surface is not there";

/// A surface: how it scatters, and the light it gives by itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// What the author calls it; may be empty.
    pub name: String,
    /// How it scatters light.
    pub kind: MaterialKind,
    /// The light it gives; none if `None`.
    pub emission: Option<Emission>,
    /// How much of it is there; all if `None`.
    pub opacity: Option<Opacity>,
    /// Turns the normal that it is shaded by.
    pub normal_map: Option<NormalMap>,
    /// From where it is there.
    pub sides: Sides,
}

/// How a surface scatters light.
#[derive(Clone, Debug, PartialEq)]
pub enum MaterialKind {
    /// Absorbs everything; lamps are often this.
    Black,
    /// Nothing: light passes as if there were no surface.
    Null,
    /// Diffuse.
    Matte(Matte),
    /// A perfect mirror of a given colour.
    Mirror(Mirror),
    /// Metal.
    Conductor(Conductor),
    /// Glass, water: clear, with or without colour.
    Dielectric(Dielectric),
    /// A pane of glass without an inside.
    ThinDielectric(ThinDielectric),
    /// Layers over a base: plastic, paint, cloth. Apart, for it is large and others are small.
    Principled(Box<Principled>),
    /// Two other materials in some proportion.
    Mix(Mix),
    /// A material of others' making.
    Custom(Arc<dyn CustomMaterial>),
}

impl Material {
    /// A material without a name that gives no light.
    pub fn new(kind: MaterialKind) -> Self {
        let (emission, opacity, normal_map) = (None, None, None);
        Self { name: String::new(), kind, emission, opacity, normal_map, sides: Sides::Both }
    }

    /// The same material under a name.
    #[must_use]
    pub fn named(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// The same material, giving light.
    #[must_use]
    pub fn emitting(mut self, emission: Emission) -> Self {
        self.emission = Some(emission);
        self
    }

    /// Tells the texture of each input that has one, to be changed: for scenes that are put together
    /// of parts.
    pub fn each_texture_mut(&mut self, mut tell: impl FnMut(&mut TextureId)) {
        if let Some((texture, _)) = self.opacity.as_mut().and_then(|o| o.amount.texture.as_mut()) {
            tell(texture);
        }
        self.normal_map.iter_mut().for_each(|map| tell(&mut map.texture));
        self.emission.iter_mut().filter_map(|e| e.texture.as_mut()).for_each(&mut tell);
        match &mut self.kind {
            MaterialKind::Principled(m) => m.each_texture_mut(tell),
            MaterialKind::Matte(m) => m.albedo.texture.iter_mut().for_each(&mut tell),
            MaterialKind::Black
            | MaterialKind::Null
            | MaterialKind::Mirror(_)
            | MaterialKind::Conductor(_)
            | MaterialKind::Dielectric(_)
            | MaterialKind::ThinDielectric(_)
            | MaterialKind::Mix(_)
            | MaterialKind::Custom(_) => {}
        }
    }

    /// True where rays meet its front alone. `all` are the materials of its scene.
    pub(crate) fn is_one_sided(&self, all: &[Self]) -> bool {
        match self.sides {
            Sides::Both => false,
            Sides::Front => !self.lets_light_through(all),
        }
    }

    /// True where light that falls on one side may leave on the other. Custom materials are taken
    /// to know what they say.
    fn lets_light_through(&self, all: &[Self]) -> bool {
        match &self.kind {
            MaterialKind::Black
            | MaterialKind::Matte(_)
            | MaterialKind::Mirror(_)
            | MaterialKind::Conductor(_)
            | MaterialKind::Custom(_) => false,
            MaterialKind::Null | MaterialKind::Dielectric(_) | MaterialKind::ThinDielectric(_) => {
                true
            }
            MaterialKind::Principled(p) => p.transmission > 0.0 || p.diffuse_transmission > 0.0,
            MaterialKind::Mix(mix) => [mix.first, mix.second]
                .into_iter()
                .filter_map(|id| all.get(id.0 as usize))
                .any(|part| part.lets_light_through(&[])),
        }
    }

    /// False where nothing glows, or only black.
    pub fn gives_light(&self) -> bool {
        self.emission.is_some_and(|e| match e.light {
            EmittedLight::Radiance(rgb) | EmittedLight::Power(rgb) => rgb != Rgb::BLACK,
        })
    }

    pub(crate) fn validate(
        &self,
        index: usize,
        all: &[Self],
        textures: usize,
    ) -> Result<(), SceneProblem> {
        let place = Place::Material(index);
        match &self.kind {
            MaterialKind::Black | MaterialKind::Null | MaterialKind::Custom(_) => {}
            MaterialKind::Matte(m) => m.validate(place, textures)?,
            MaterialKind::Mirror(m) => m.validate(place)?,
            MaterialKind::Conductor(m) => m.validate(place)?,
            MaterialKind::Dielectric(m) => {
                m.validate(place)?;
                if m.priority.is_some() && self.emission.is_some() {
                    return Err(place.problem("emission", NO_GLOW_WITH_PRIORITY));
                }
            }
            MaterialKind::ThinDielectric(m) => m.validate(place)?,
            MaterialKind::Principled(m) => {
                m.validate(place, textures)?;
                if m.priority.is_some() && self.emission.is_some() {
                    return Err(place.problem("emission", NO_GLOW_WITH_PRIORITY));
                }
            }
            MaterialKind::Mix(m) => m.validate(place, all)?,
        }
        if let Some(opacity) = &self.opacity {
            opacity.validate(place, textures)?;
        }
        if let Some(map) = &self.normal_map {
            map.validate(place, ["normal_map", "normal_scale"], textures)?;
        }
        self.emission.as_ref().map_or(Ok(()), |e| e.validate(place, textures))
    }
}

impl Mix {
    /// Its parts are materials that scatter on their own and have no inside.
    fn validate(&self, place: Place, all: &[Material]) -> Result<(), SceneProblem> {
        place.check("amount", [self.amount], UNIT)?;
        for (key, id) in [("first", self.first), ("second", self.second)] {
            let what = match all.get(id.0 as usize).map(|m| &m.kind) {
                None => format!("there is no material number {}", id.0),
                Some(MaterialKind::Mix(_)) => {
                    format!("{key} is itself a mix; mix plain materials instead")
                }
                Some(MaterialKind::Dielectric(_)) => format!(
                    "{key} is a dielectric, which cannot be mixed: what is inside would be in doubt"
                ),
                Some(MaterialKind::Principled(_)) => format!(
                    "{key} is principled, which cannot be mixed: its own keys say in which \
                     proportion there is what"
                ),
                Some(MaterialKind::Custom(_)) => format!(
                    "{key} is a custom material, which cannot be mixed: let it do the mixing"
                ),
                Some(
                    MaterialKind::Black
                    | MaterialKind::Null
                    | MaterialKind::Matte(_)
                    | MaterialKind::Mirror(_)
                    | MaterialKind::Conductor(_)
                    | MaterialKind::ThinDielectric(_),
                ) => continue,
            };
            return Err(place.problem(key, what));
        }
        Ok(())
    }
}

macro_rules! material_from {
    ($($kind:ident),*) => {$(
        impl From<$kind> for Material {
            fn from(kind: $kind) -> Self {
                Self::new(MaterialKind::$kind(kind))
            }
        }
    )*};
}
material_from!(Matte, Mirror, Conductor, Dielectric, ThinDielectric, Mix);

impl From<Principled> for Material {
    fn from(layers: Principled) -> Self {
        Self::new(MaterialKind::Principled(Box::new(layers)))
    }
}

impl From<Arc<dyn CustomMaterial>> for Material {
    fn from(custom: Arc<dyn CustomMaterial>) -> Self {
        Self::new(MaterialKind::Custom(custom))
    }
}

impl From<Emission> for Material {
    /// A black surface that gives light: a lamp.
    fn from(emission: Emission) -> Self {
        Self::new(MaterialKind::Black).emitting(emission)
    }
}
