//! Layers over a base: plastic, painted and brushed metal, varnished wood, cloth, coloured glass.

use super::dielectric::{
    Absorption, MAX_DISPERSION, MAX_IOR, MOST_ROUGH_RATIO, check_rough_dispersion,
};
use super::normal_map::NormalMap;
use crate::bsdf::PrincipledParameters;
use crate::color::{Rgb, Spectrum};
use crate::dispersion::largest_index;
use crate::id::TextureId;
use crate::problem::{FINITE, Place, SceneProblem, UNIT};
use crate::texture::Channel;
use rutilant_geom::Vec3;

/// A surface of layers, told by plain numbers: see [`bsdf::Principled`](crate::bsdf::Principled).
/// Everything but indices, angles, thicknesses and the specular colour lies between 0 and 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Principled {
    /// What metal reflects at normal incidence, what a matte body sends back, and what is left of
    /// light each time that it crosses a clear border.
    pub base_color: Rgb,
    /// The share of metal.
    pub metallic: f32,
    /// How rough metal and gloss are, 0 (a mirror) to 1. The α of GGX is its square.
    pub roughness: f32,
    /// How rough the matte body is: see [`Matte`](super::Matte).
    pub diffuse_roughness: f32,
    /// How much rougher it is along the tangent than across.
    pub anisotropy: f32,
    /// Where the tangent lies, in radians from the direction in which u grows towards that in which
    /// v does. Both are those of the mesh's tangents where it has some, else of its first set of
    /// texture coordinates; on a sphere east and north. Without any the tangent lies somewhere.
    pub anisotropy_rotation: f32,
    /// How much of the dielectric's reflection there is.
    pub specular: f32,
    /// A factor on what the dielectric reflects at normal incidence, 0 to [`MAX_SPECULAR_COLOR`];
    /// what is reflected is not above 1 whatever it is.
    pub specular_color: Rgb,
    /// Index of refraction of the dielectric, 1 to 10.
    pub ior: f32,
    /// How much a body's index changes with the colour of light that goes into it: as for
    /// [`Dielectric`](super::Dielectric).
    pub dispersion: f32,
    /// The part of what enters the dielectric that goes through instead of into a matte body.
    pub transmission: f32,
    /// Whether there is nothing behind the surface. If there is, it is a closed body, and its
    /// inside is where normals point away from.
    pub thin_walled: bool,
    /// The part of the matte body that sends light on to the other side.
    pub diffuse_transmission: f32,
    /// The colour of that light.
    pub diffuse_transmission_color: Rgb,
    /// The colour that light takes on inside of a body that is not thin.
    pub absorption: Absorption,
    /// As for [`Dielectric`](super::Dielectric); only where light goes through a body.
    pub priority: Option<u32>,
    /// How much of the surface is coated.
    pub coat: f32,
    /// What is left of light that goes straight through the coat, to the base and back.
    pub coat_color: Rgb,
    /// How rough the coat is.
    pub coat_roughness: f32,
    /// Index of refraction of the coat, 1 to 10.
    pub coat_ior: f32,
    /// Turns the normal of the coat. The material's own normal map does not: bumps are under the coat.
    pub coat_normal_map: Option<NormalMap>,
    /// What fibres on the surface reflect; none if black.
    pub sheen_color: Rgb,
    /// How much the fibres lean; less than 0.3 is taken as that.
    pub sheen_roughness: f32,
    /// How much of metal and gloss is under a thin film.
    pub iridescence: f32,
    /// Index of refraction of the film, 1 to 10.
    pub iridescence_ior: f32,
    /// How thick the film is, in nanometres, 0 to 100000; where a texture is 1, if it has one.
    pub iridescence_thickness_nm: f32,
    /// How thick it is where its texture is 0.
    pub iridescence_thickness_minimum_nm: f32,
    /// What varies over the surface: factors on the numbers.
    pub textures: PrincipledTextures,
}

/// The textures that are factors on what a [`Principled`] surface is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[expect(missing_docs, reason = "each is named after the number that it is a factor on")]
pub struct PrincipledTextures {
    pub base_color: Option<TextureId>,
    /// The colours of the mesh's vertices are a factor on the base colour as well.
    pub vertex_colors: bool,
    pub metallic: Option<(TextureId, Channel)>,
    pub roughness: Option<(TextureId, Channel)>,
    pub anisotropy: Option<(TextureId, Channel)>,
    /// Red and green, from 0..1 to −1..1, are a direction along u and v, which the rotation turns.
    pub anisotropy_direction: Option<TextureId>,
    pub specular: Option<(TextureId, Channel)>,
    pub specular_color: Option<TextureId>,
    pub transmission: Option<(TextureId, Channel)>,
    pub diffuse_transmission: Option<(TextureId, Channel)>,
    pub diffuse_transmission_color: Option<TextureId>,
    pub coat: Option<(TextureId, Channel)>,
    pub coat_roughness: Option<(TextureId, Channel)>,
    pub sheen_color: Option<TextureId>,
    pub sheen_roughness: Option<(TextureId, Channel)>,
    pub iridescence: Option<(TextureId, Channel)>,
    pub iridescence_thickness_nm: Option<(TextureId, Channel)>,
}

impl PrincipledTextures {
    /// Whether there is one.
    pub fn vary(&self) -> bool {
        let mut some = self.vertex_colors;
        let mut own = *self;
        own.each_mut(|_, _| some = true);
        some
    }

    /// Tells each, with its key, to be changed.
    pub(super) fn each_mut(&mut self, mut tell: impl FnMut(&'static str, &mut TextureId)) {
        for (key, texture) in [
            ("base_color", &mut self.base_color),
            ("anisotropy_direction", &mut self.anisotropy_direction),
            ("specular_color", &mut self.specular_color),
            ("diffuse_transmission_color", &mut self.diffuse_transmission_color),
            ("sheen_color", &mut self.sheen_color),
        ] {
            texture.iter_mut().for_each(|id| tell(key, id));
        }
        for (key, texture) in [
            ("metallic", &mut self.metallic),
            ("roughness", &mut self.roughness),
            ("anisotropy", &mut self.anisotropy),
            ("specular", &mut self.specular),
            ("transmission", &mut self.transmission),
            ("diffuse_transmission", &mut self.diffuse_transmission),
            ("coat", &mut self.coat),
            ("coat_roughness", &mut self.coat_roughness),
            ("sheen_roughness", &mut self.sheen_roughness),
            ("iridescence", &mut self.iridescence),
            ("iridescence_thickness_nm", &mut self.iridescence_thickness_nm),
        ] {
            texture.iter_mut().for_each(|(id, _)| tell(key, id));
        }
    }
}

/// The brightest specular colour that is accepted: with it even what has an index of 1.003 reflects
/// everything.
pub const MAX_SPECULAR_COLOR: f32 = 1e6;

/// The thickest film that is accepted, in nanometres: interference in thicker ones has no colour.
pub const MAX_FILM_NM: f32 = 1e5;

impl Default for Principled {
    /// Satin plastic, light grey: no layer but the base and its gloss.
    fn default() -> Self {
        Self {
            base_color: Rgb::grey(0.8),
            metallic: 0.0,
            roughness: 0.3,
            diffuse_roughness: 0.0,
            anisotropy: 0.0,
            anisotropy_rotation: 0.0,
            specular: 1.0,
            specular_color: Rgb::WHITE,
            ior: 1.5,
            dispersion: 0.0,
            transmission: 0.0,
            thin_walled: false,
            diffuse_transmission: 0.0,
            diffuse_transmission_color: Rgb::WHITE,
            absorption: Absorption::None,
            priority: None,
            coat: 0.0,
            coat_color: Rgb::WHITE,
            coat_roughness: 0.0,
            coat_ior: 1.5,
            coat_normal_map: None,
            sheen_color: Rgb::BLACK,
            sheen_roughness: 0.5,
            iridescence: 0.0,
            iridescence_ior: 1.3,
            iridescence_thickness_nm: 400.0,
            iridescence_thickness_minimum_nm: 0.0,
            textures: PrincipledTextures::default(),
        }
    }
}

impl Principled {
    /// What it is at every point, over a medium of index 1.
    pub fn parameters(&self) -> PrincipledParameters {
        PrincipledParameters {
            base_color: self.base_color.into(),
            metallic: self.metallic,
            roughness: self.roughness,
            diffuse_roughness: self.diffuse_roughness,
            anisotropy: self.anisotropy,
            anisotropy_rotation: self.anisotropy_rotation,
            specular: self.specular,
            specular_color: self.specular_color.into(),
            eta: self.ior,
            transmission: self.transmission,
            thin_walled: self.thin_walled,
            diffuse_transmission: self.diffuse_transmission,
            diffuse_transmission_color: self.diffuse_transmission_color.into(),
            coat: self.coat,
            coat_color: self.coat_color.into(),
            coat_roughness: self.coat_roughness,
            coat_ior: self.coat_ior,
            coat_normal: Vec3::Z,
            normal: Vec3::Z,
            sheen_color: self.sheen_color.into(),
            sheen_roughness: self.sheen_roughness,
            iridescence: self.iridescence,
            iridescence_ior: self.iridescence_ior,
            iridescence_thickness_nm: self.iridescence_thickness_nm,
        }
    }

    /// True where light goes through the surface into a body.
    pub fn has_inside(&self) -> bool {
        let matte = self.transmission < 1.0 && self.diffuse_transmission > 0.0;
        !self.thin_walled && self.metallic < 1.0 && (self.transmission > 0.0 || matte)
    }

    /// True where the normal of the coat is not that of what is below it, which is `bumpy` or not.
    pub(crate) fn has_own_coat_normal(&self, bumpy: bool) -> bool {
        self.coat > 0.0 && (bumpy || self.coat_normal_map.is_some())
    }

    /// Tells the texture of each input that has one, to be changed.
    pub(super) fn each_texture_mut(&mut self, mut tell: impl FnMut(&mut TextureId)) {
        self.coat_normal_map.iter_mut().for_each(|map| tell(&mut map.texture));
        self.textures.each_mut(|_, id| tell(id));
    }

    /// True where facets are steeper one way than the other, which the surface's directions decide.
    pub(crate) fn is_anisotropic(&self) -> bool {
        self.anisotropy > 0.0
    }

    /// The same where colours and numbers, with textures on them, have these values.
    pub(crate) fn varied(
        &self,
        color: impl Fn(Rgb, Option<TextureId>, bool) -> Spectrum,
        scalar: impl Fn(f32, Option<(TextureId, Channel)>) -> f32,
    ) -> PrincipledParameters {
        let of = &self.textures;
        // Whatever pictures hold, a part is a part.
        let part = |factor, texture| scalar(factor, texture).clamp(0.0, 1.0);
        let up_to = |most: f32, color: Spectrum| color.map(|c| c.clamp(0.0, most));
        let tint = |factor, texture| up_to(1.0, color(factor, texture, false));
        let [least, most] = [self.iridescence_thickness_minimum_nm, self.iridescence_thickness_nm];
        let thickness = match of.iridescence_thickness_nm {
            None => most,
            Some(texture) => least + (most - least) * scalar(1.0, Some(texture)),
        };
        PrincipledParameters {
            base_color: up_to(1.0, color(self.base_color, of.base_color, of.vertex_colors)),
            metallic: part(self.metallic, of.metallic),
            roughness: part(self.roughness, of.roughness),
            anisotropy: part(self.anisotropy, of.anisotropy),
            specular: part(self.specular, of.specular),
            specular_color: up_to(
                MAX_SPECULAR_COLOR,
                color(self.specular_color, of.specular_color, false),
            ),
            transmission: part(self.transmission, of.transmission),
            diffuse_transmission: part(self.diffuse_transmission, of.diffuse_transmission),
            diffuse_transmission_color: tint(
                self.diffuse_transmission_color,
                of.diffuse_transmission_color,
            ),
            coat: part(self.coat, of.coat),
            coat_roughness: part(self.coat_roughness, of.coat_roughness),
            sheen_color: tint(self.sheen_color, of.sheen_color),
            sheen_roughness: part(self.sheen_roughness, of.sheen_roughness),
            iridescence: part(self.iridescence, of.iridescence),
            iridescence_thickness_nm: thickness.clamp(0.0, MAX_FILM_NM),
            ..self.parameters()
        }
    }

    pub(super) fn validate(&self, place: Place, textures: usize) -> Result<(), SceneProblem> {
        let mut wrong = None;
        let mut all = self.textures;
        all.each_mut(|key, id| {
            wrong = wrong.or((id.0 as usize >= textures).then_some((key, id.0)));
        });
        if let Some((key, id)) = wrong {
            return Err(place.problem(key, format!("there is no texture number {id}")));
        }
        for (key, color) in [
            ("base_color", self.base_color),
            ("diffuse_transmission_color", self.diffuse_transmission_color),
            ("coat_color", self.coat_color),
            ("sheen_color", self.sheen_color),
        ] {
            place.check(key, color.0, UNIT)?;
        }
        place.check("specular_color", self.specular_color.0, 0.0..=MAX_SPECULAR_COLOR)?;
        for (key, part) in [
            ("metallic", self.metallic),
            ("roughness", self.roughness),
            ("diffuse_roughness", self.diffuse_roughness),
            ("anisotropy", self.anisotropy),
            ("specular", self.specular),
            ("transmission", self.transmission),
            ("diffuse_transmission", self.diffuse_transmission),
            ("coat", self.coat),
            ("coat_roughness", self.coat_roughness),
            ("sheen_roughness", self.sheen_roughness),
            ("iridescence", self.iridescence),
        ] {
            place.check(key, [part], UNIT)?;
        }
        for (key, ior) in [
            ("ior", self.ior),
            ("coat_ior", self.coat_ior),
            ("iridescence_ior", self.iridescence_ior),
        ] {
            place.check(key, [ior], 1.0..=MAX_IOR)?;
        }
        place.check("anisotropy_rotation_degrees", [self.anisotropy_rotation], FINITE)?;
        for (key, thickness) in [
            ("iridescence_thickness_nm", self.iridescence_thickness_nm),
            ("iridescence_thickness_minimum_nm", self.iridescence_thickness_minimum_nm),
        ] {
            place.check(key, [thickness], 0.0..=MAX_FILM_NM)?;
        }
        place.check("dispersion", [self.dispersion], 0.0..=MAX_DISPERSION)?;
        if let Some(map) = &self.coat_normal_map {
            map.validate(place, ["coat_normal_map", "coat_normal_scale"], textures)?;
        }
        self.absorption.validate(place, |name| name)?;
        self.validate_inside(place)
    }

    /// What is inside must be there, and light must get out of it again.
    fn validate_inside(&self, place: Place) -> Result<(), SceneProblem> {
        let is_rough = self.roughness > 0.0 || self.anisotropy > 0.0;
        if self.has_inside() && is_rough && self.ior > MOST_ROUGH_RATIO {
            let what = format!(
                "roughness is {}, but where light goes through a body of ior {} it must be 0, and \
                 so must anisotropy: up to {MOST_ROUGH_RATIO} glass may be rough",
                self.roughness, self.ior
            );
            return Err(place.problem("roughness", what));
        }
        if self.has_inside() && is_rough {
            check_rough_dispersion(place, largest_index(self.ior, self.dispersion))?;
        }
        if self.priority.is_some() && !self.has_inside() {
            let what = "a priority is for bodies that light goes through: transmission must be \
                        more than 0, metallic less than 1, and thin_walled false";
            return Err(place.problem("priority", what));
        }
        Ok(())
    }
}
