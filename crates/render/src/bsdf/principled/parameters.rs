//! What a principled surface is, in plain numbers.

use crate::color::Spectrum;
use rutilant_geom::Vec3;

/// What a principled surface is at a point: plain numbers, which textures may drive. All but
/// indices, angles, thicknesses and `specular_color` lie between 0 and 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrincipledParameters {
    /// What metal reflects at normal incidence, what a matte body sends back, and what is left of
    /// light each time that it crosses a clear border.
    pub base_color: Spectrum,
    /// The share of metal.
    pub metallic: f32,
    /// How rough metal and gloss are; α is the square.
    pub roughness: f32,
    /// How rough the matte body is: see [`OrenNayar`](crate::bsdf::OrenNayar).
    pub diffuse_roughness: f32,
    /// How much steeper facets are along the tangent: α grows from there to 1 by the square.
    pub anisotropy: f32,
    /// Where the tangent lies, in radians counter-clockwise from the x axis of the shading frame,
    /// which must follow the u direction of the surface.
    pub anisotropy_rotation: f32,
    /// How much of the dielectric's reflection there is.
    pub specular: f32,
    /// A factor on what the dielectric reflects at normal incidence.
    pub specular_color: Spectrum,
    /// Index of refraction of the dielectric, over that in front of it.
    pub eta: f32,
    /// The part of what enters the dielectric that goes through instead of into a matte body.
    pub transmission: f32,
    /// Whether there is nothing behind the surface: light goes through without being bent, and
    /// the back is like the front.
    pub thin_walled: bool,
    /// The part of the matte body that sends light on to the other side.
    pub diffuse_transmission: f32,
    /// The colour of that light.
    pub diffuse_transmission_color: Spectrum,
    /// How much of the surface is coated.
    pub coat: f32,
    /// What is left of light that goes straight through the coat, to the base and back.
    pub coat_color: Spectrum,
    /// How rough the coat is; α is the square.
    pub coat_roughness: f32,
    /// Index of refraction of the coat, at least 1.
    pub coat_ior: f32,
    /// The coat's own unit normal in the shading frame, on the front. What it mirrors below the
    /// surface is lost, so it should lean towards `wo` where it would do that.
    pub coat_normal: Vec3,
    /// The same of all other layers.
    pub normal: Vec3,
    /// What the fibres reflect; none if black.
    pub sheen_color: Spectrum,
    /// How much the fibres lean.
    pub sheen_roughness: f32,
    /// How much of metal and gloss is under a thin film.
    pub iridescence: f32,
    /// Index of refraction of the film, at least 1.
    pub iridescence_ior: f32,
    /// How thick the film is, in nanometres.
    pub iridescence_thickness_nm: f32,
}

impl Default for PrincipledParameters {
    /// Satin plastic: light grey, of index 1.5.
    fn default() -> Self {
        Self {
            base_color: Spectrum::splat(0.8),
            metallic: 0.0,
            roughness: 0.3,
            diffuse_roughness: 0.0,
            anisotropy: 0.0,
            anisotropy_rotation: 0.0,
            specular: 1.0,
            specular_color: Spectrum::WHITE,
            eta: 1.5,
            transmission: 0.0,
            thin_walled: false,
            diffuse_transmission: 0.0,
            diffuse_transmission_color: Spectrum::WHITE,
            coat: 0.0,
            coat_color: Spectrum::WHITE,
            coat_roughness: 0.0,
            coat_ior: 1.5,
            coat_normal: Vec3::Z,
            normal: Vec3::Z,
            sheen_color: Spectrum::BLACK,
            sheen_roughness: 0.5,
            iridescence: 0.0,
            iridescence_ior: 1.3,
            iridescence_thickness_nm: 400.0,
        }
    }
}
