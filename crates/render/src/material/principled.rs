//! Layers over a base: plastic, painted and brushed metal, varnished wood, cloth, coloured glass.

use super::dielectric::{Absorption, MAX_IOR, MOST_ROUGH_RATIO};
use crate::bsdf::PrincipledParameters;
use crate::color::Rgb;
use crate::problem::{FINITE, Place, SceneProblem, UNIT};

/// A surface of layers, told by plain numbers: see [`bsdf::Principled`](crate::bsdf::Principled).
/// Everything but indices, angles and thicknesses lies between 0 and 1.
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
    /// Where the tangent lies, in radians counter-clockwise from the u direction of the surface:
    /// for now, from the x axis of the shading frame, which must follow it.
    pub anisotropy_rotation: f32,
    /// How much of the dielectric's reflection there is.
    pub specular: f32,
    /// A factor on what the dielectric reflects at normal incidence.
    pub specular_color: Rgb,
    /// Index of refraction of the dielectric, 1 to 10.
    pub ior: f32,
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
    /// What fibres on the surface reflect; none if black.
    pub sheen_color: Rgb,
    /// How much the fibres lean; less than 0.3 is taken as that.
    pub sheen_roughness: f32,
    /// How much of metal and gloss is under a thin film.
    pub iridescence: f32,
    /// Index of refraction of the film, 1 to 10.
    pub iridescence_ior: f32,
    /// How thick the film is, in nanometres, 0 to 100000.
    pub iridescence_thickness_nm: f32,
}

/// The thickest film: interference in thicker ones has no colour.
const THICKEST_FILM: f32 = 1e5;

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
            sheen_color: Rgb::BLACK,
            sheen_roughness: 0.5,
            iridescence: 0.0,
            iridescence_ior: 1.3,
            iridescence_thickness_nm: 400.0,
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

    pub(super) fn validate(&self, place: Place) -> Result<(), SceneProblem> {
        for (key, color) in [
            ("base_color", self.base_color),
            ("specular_color", self.specular_color),
            ("diffuse_transmission_color", self.diffuse_transmission_color),
            ("coat_color", self.coat_color),
            ("sheen_color", self.sheen_color),
        ] {
            place.check(key, color.0, UNIT)?;
        }
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
        let thickness = self.iridescence_thickness_nm;
        place.check("iridescence_thickness_nm", [thickness], 0.0..=THICKEST_FILM)?;
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
        if self.priority.is_some() && !self.has_inside() {
            let what = "a priority is for bodies that light goes through: transmission must be \
                        more than 0, metallic less than 1, and thin_walled false";
            return Err(place.problem("priority", what));
        }
        Ok(())
    }
}
