//! Materials of pbrt-v4, and those of pbrt-v3 that went before them.
//!
//! What pbrt has as layers with light between them is [`Principled`] here; the light that goes to and
//! fro between a matte body and the surface above it is in the body's colour. pbrt's roughness is
//! the square root of α, or α itself where it is not remapped; here it is what α is the square of.
//!
//! Source: Pharr, Jakob, Humphreys, *pbrt-v4 input file format*, pbrt.org/fileformat-v4, and
//! *pbrt-v3 input file format*, pbrt.org/fileformat-v3: "Materials"; *Physically Based Rendering*,
//! 3rd ed., section 8.4.2 for the older roughness, 4th ed., section 14.3 for layers.

mod glass;
mod inputs;
mod layers;
mod metal;
mod mix;
mod which;

pub(super) use which::Which;

use super::description::{Named, Placed};
use super::parameters::Parameters;
use super::scene::Maker;
use super::textures::{Change, Texel};
use crate::error::{SceneError, SceneErrorKind};
use crate::scene::nearest::nearest;
use crate::scene::spectrum::normal_reflectance;
use crate::shown::shown;
use layers::sent_back_inside;
use rutilant::color::Rgb;
use rutilant::material::{
    Bumps, MOST_ROUGH_RATIO, Material, MaterialKind, Matte, Mirror, NormalMap, Opacity,
    OpacityMode, Principled, PrincipledTextures, ThinDielectric,
};
use rutilant::texture::{ColorInput, Encoding, ScalarInput};

/// The kinds there are.
const KINDS: [&str; 27] = [
    "coatedconductor",
    "coateddiffuse",
    "conductor",
    "dielectric",
    "diffuse",
    "diffusetransmission",
    "disney",
    "fourier",
    "glass",
    "hair",
    "interface",
    "kdsubsurface",
    "matte",
    "measured",
    "metal",
    "mirror",
    "mix",
    "none",
    "plastic",
    "sss",
    "substrate",
    "subsurface",
    "thindielectric",
    "translucent",
    "uber",
    "null",
    "dielectricinterface",
];

impl Maker<'_> {
    /// How a surface looks that has this material and stands between these media.
    pub(super) fn look(
        &mut self,
        which: Which,
        [inside, outside]: [&str; 2],
    ) -> Result<Material, SceneError> {
        let description = self.description;
        let (name, kind, parameters) = match which {
            Which::Default => {
                return Ok(Matte::new(Rgb::grey(0.5)).into());
            }
            Which::Own(number) => {
                let Named { name, parameters } = &description.own_materials[number];
                ("", name.clone(), parameters)
            }
            Which::Named(number) => {
                let Named { name, parameters } = &description.named_materials[number];
                let kind = parameters.text("type", self.texts)?.unwrap_or("diffuse").to_owned();
                (&**name, kind, parameters)
            }
        };
        if self.making.contains(&which) {
            let what = format!("{} is made of itself", parameters.of);
            return Err(self.texts.invalid(parameters.place, what));
        }
        self.making.push(which);
        let made = self.made_material(&kind, parameters, [inside, outside])?;
        self.making.pop();
        let mut material = made.named(name);
        self.bumps(&mut material, parameters)?;
        parameters.tell_unused(self.texts, &mut self.notes);
        Ok(material)
    }

    fn bumps(
        &mut self,
        material: &mut Material,
        parameters: &Parameters,
    ) -> Result<(), SceneError> {
        if let Some(name) = parameters.text("normalmap", self.texts)? {
            let name = name.to_owned();
            let texture = self.plain_picture(&name, Encoding::Linear, parameters.place);
            material.normal_map = Some(NormalMap { texture, scale: 1.0, shows: Bumps::Normals });
        }
        for name in ["displacement", "bumpmap"] {
            let heights = self.number(parameters, name, 0.0)?;
            if heights.varies.is_some() {
                let (scale, texture) = self.scalar(&heights);
                material.normal_map =
                    texture.map(|(texture, _)| NormalMap { texture, scale, shows: Bumps::Heights });
            }
        }
        Ok(())
    }

    fn made_material(
        &mut self,
        kind: &str,
        parameters: &Parameters,
        media: [&str; 2],
    ) -> Result<Material, SceneError> {
        let grey = Rgb::grey;
        let place = parameters.place;
        Ok(match kind {
            // pbrt-v4.
            "diffuse" => {
                let reflectance = self.color(parameters, "reflectance", grey(0.5))?;
                self.matte(&reflectance, 0.0, parameters)
            }
            "coateddiffuse" => {
                let body = self.color(parameters, "reflectance", grey(0.5))?;
                let ior = self.index(parameters, "eta", 1.5)?.0;
                let rough = self.rough(parameters, "", 0.0, true)?;
                self.layers_above(parameters)?;
                let body = body.changed(Change::Below(sent_back_inside(ior)));
                let (base_color, texture) = self.unit_color(&body, "reflectance", parameters);
                let textures = PrincipledTextures {
                    base_color: texture,
                    roughness: rough.texture,
                    ..Default::default()
                };
                let roughness = rough.roughness;
                Principled { base_color, roughness, ior, textures, ..Principled::default() }.into()
            }
            "conductor" => self.conductor(parameters, false)?,
            "coatedconductor" => {
                let metal = self.metal(parameters, "conductor.")?;
                let ior = self.index(parameters, "interface.eta", 1.5)?.0;
                let coat = self.rough(parameters, "interface.", 0.0, true)?;
                let base = self.rough(parameters, "conductor.", 0.0, true)?;
                self.layers_above(parameters)?;
                let what = format!(
                    "{} is metal under a coat, whose colour follows from its index for light that \
                     falls straight onto it",
                    parameters.of
                );
                self.note(place, what);
                Principled {
                    base_color: metal.normal_reflectance(ior),
                    metallic: 1.0,
                    roughness: base.roughness,
                    coat: 1.0,
                    coat_ior: ior,
                    coat_roughness: coat.roughness,
                    textures: PrincipledTextures {
                        roughness: base.texture,
                        coat_roughness: coat.texture,
                        ..Default::default()
                    },
                    ..Principled::default()
                }
                .into()
            }
            "dielectric" | "dielectricinterface" => {
                let (ior, dispersion) = self.index(parameters, "eta", 1.5)?;
                let rough = self.rough(parameters, "", 0.0, true)?;
                self.even(&rough, parameters);
                self.glass(ior, dispersion, rough.roughness, media, parameters)
            }
            "thindielectric" => {
                let ior = self.index(parameters, "eta", 1.5)?.0;
                ThinDielectric { ior, color: Rgb::WHITE }.into()
            }
            "diffusetransmission" => {
                let scale = parameters.number_or("scale", 1.0, self.texts)?;
                let back = self.color(parameters, "reflectance", grey(0.25))?.times(grey(scale));
                let on = self.color(parameters, "transmittance", grey(0.25))?.times(grey(scale));
                self.leaf(back, on, parameters)
            }
            "interface" | "none" | "" | "null" => self.nothing(media, parameters),
            "mix" => self.mix(parameters)?,
            "subsurface" | "kdsubsurface" | "sss" => {
                let what = format!(
                    "{} has no light that comes out elsewhere: a matte body under a clear surface \
                     stands in",
                    parameters.of
                );
                self.note(place, what);
                let default = self.color(parameters, "Kd", grey(0.5))?;
                let body = match parameters.get("reflectance") {
                    Some(_) => self.color(parameters, "reflectance", grey(0.5))?,
                    None => default,
                };
                let ior = self.index(parameters, "eta", 1.33)?.0;
                let rough = self.rough(parameters, "", 0.0, true)?;
                parameters.ignore(&["mfp", "sigma_a", "sigma_s", "scale", "g", "name", "Kr", "Kt"]);
                let (base_color, texture) = self.unit_color(&body, "reflectance", parameters);
                let textures =
                    PrincipledTextures { base_color: texture, ..PrincipledTextures::default() };
                let roughness = rough.roughness;
                Principled { base_color, roughness, ior, textures, ..Principled::default() }.into()
            }
            "hair" | "measured" | "fourier" => {
                let what = format!("materials of type \"{kind}\" are not made: grey stands in");
                self.note(place, what);
                parameters.ignore(&[
                    "filename",
                    "bsdffile",
                    "sigma_a",
                    "color",
                    "reflectance",
                    "eumelanin",
                    "pheomelanin",
                    "eta",
                    "beta_m",
                    "beta_n",
                    "alpha",
                ]);
                Matte::new(grey(0.5)).into()
            }

            // pbrt-v3.
            "matte" => {
                let color = self.color(parameters, "Kd", grey(0.5))?;
                let sigma = self.plain_number(parameters, "sigma", 0.0)?;
                // Slopes of 90° are as rough as can be said.
                let roughness = (sigma.to_radians() / std::f32::consts::FRAC_PI_2).clamp(0.0, 1.0);
                self.matte(&color, roughness, parameters)
            }
            "plastic" => {
                let (body, gloss) = (
                    self.color(parameters, "Kd", grey(0.25))?,
                    self.color(parameters, "Ks", grey(0.25))?,
                );
                let rough = self.rough(parameters, "", 0.1, false)?;
                self.glossy(&body, &gloss, 1.5, &rough, parameters)
            }
            "substrate" => {
                let (body, gloss) = (
                    self.color(parameters, "Kd", grey(0.5))?,
                    self.color(parameters, "Ks", grey(0.5))?,
                );
                let rough = self.rough(parameters, "", 0.1, false)?;
                // What it reflects is said for light that falls straight onto it, not as a factor.
                let gloss = gloss.times(grey(1.0 / normal_reflectance(1.5, 0.0)));
                self.glossy(&body, &gloss, 1.5, &rough, parameters)
            }
            "metal" => self.conductor(parameters, true)?,
            "mirror" => {
                let color = self.color(parameters, "Kr", grey(0.9))?;
                let (reflectance, texture) = self.unit_color(&color, "Kr", parameters);
                match texture {
                    None => Mirror { reflectance }.into(),
                    Some(texture) => Principled {
                        base_color: reflectance,
                        metallic: 1.0,
                        roughness: 0.0,
                        textures: PrincipledTextures {
                            base_color: Some(texture),
                            ..Default::default()
                        },
                        ..Principled::default()
                    }
                    .into(),
                }
            }
            "glass" => {
                let (back, on) = (
                    self.color(parameters, "Kr", Rgb::WHITE)?,
                    self.color(parameters, "Kt", Rgb::WHITE)?,
                );
                let name = if parameters.get("index").is_some() { "index" } else { "eta" };
                let (ior, dispersion) = self.index(parameters, name, 1.5)?;
                let rough = self.rough(parameters, "", 0.0, false)?;
                self.even(&rough, parameters);
                let white = Some(Rgb::WHITE);
                if back.as_constant() == white && on.as_constant() == white {
                    self.glass(ior, dispersion, rough.roughness, media, parameters)
                } else {
                    let (base_color, texture) = self.unit_color(&on, "Kt", parameters);
                    let (specular, _) = self.scalar(&back);
                    Principled {
                        base_color,
                        roughness: rough.roughness,
                        ior: ior.clamp(1.0, MOST_ROUGH_RATIO),
                        specular: specular.clamp(0.0, 1.0),
                        transmission: 1.0,
                        textures: PrincipledTextures { base_color: texture, ..Default::default() },
                        ..Principled::default()
                    }
                    .into()
                }
            }
            "uber" => {
                let (body, gloss) = (
                    self.color(parameters, "Kd", grey(0.25))?,
                    self.color(parameters, "Ks", grey(0.25))?,
                );
                let (back, on) = (
                    self.color(parameters, "Kr", Rgb::BLACK)?,
                    self.color(parameters, "Kt", Rgb::BLACK)?,
                );
                let name = if parameters.get("index").is_some() { "index" } else { "eta" };
                let ior = self.index(parameters, name, 1.5)?.0;
                let rough = self.rough(parameters, "", 0.1, false)?;
                for (name, texel) in [("Kr", &back), ("Kt", &on)] {
                    if texel.as_constant() != Some(Rgb::BLACK) {
                        let what = format!("\"{name}\" of {} is left out", parameters.of);
                        self.note(place, what);
                    }
                }
                let opacity = self.number(parameters, "opacity", 1.0)?;
                let mut material = self.glossy(&body, &gloss, ior, &rough, parameters);
                self.open(&mut material, &opacity);
                material
            }
            "translucent" => {
                let (body, back, on) = (
                    self.color(parameters, "Kd", grey(0.25))?,
                    self.color(parameters, "reflect", grey(0.5))?,
                    self.color(parameters, "transmit", grey(0.5))?,
                );
                let what = format!("the gloss of {} is left out", parameters.of);
                self.note(place, what);
                parameters.ignore(&["Ks", "roughness", "remaproughness"]);
                let (back, on) = (super::textures::mean(&back), super::textures::mean(&on));
                self.leaf(body.clone().times(back), body.times(on), parameters)
            }
            "disney" => self.disney(parameters)?,
            other => {
                let kind = SceneErrorKind::Unknown {
                    what: "type of materials",
                    name: shown(other),
                    closest: nearest(other, KINDS).map(str::to_owned),
                };
                return Err(self.texts.error(place, kind));
            }
        })
    }

    fn matte(&mut self, color: &Texel, roughness: f32, parameters: &Parameters) -> Material {
        if color.as_constant() == Some(Rgb::BLACK) {
            return Material::new(MaterialKind::Black);
        }
        let (factor, texture) = self.unit_color(color, "reflectance", parameters);
        let albedo = ColorInput { factor, texture, vertex_colors: false };
        Matte { roughness, ..Matte::new(albedo) }.into()
    }

    /// Leaves so much of a surface.
    pub(super) fn open(&mut self, material: &mut Material, part: &Texel) {
        if part.as_number().is_some_and(|part| part >= 1.0) {
            return;
        }
        let (factor, texture) = self.scalar(part);
        let factor = factor.clamp(0.0, 1.0);
        let amount = match material.opacity.map(|opacity| opacity.amount) {
            // One of them can vary.
            Some(own) if texture.is_none() => ScalarInput { factor: own.factor * factor, ..own },
            Some(own) => ScalarInput { factor: own.factor * factor, texture },
            None => ScalarInput { factor, texture },
        };
        let (vertex_colors, mode) = (false, OpacityMode::Blend);
        material.opacity = Some(Opacity { amount, vertex_colors, mode });
    }

    /// The opacity that a shape has.
    pub(super) fn alpha(&mut self, placed: &Placed) -> Result<Texel, SceneError> {
        if placed.parameters.get("shadowalpha").is_some() {
            let what = "\"shadowalpha\" is left out: shadows follow from \"alpha\"";
            self.note(placed.parameters.place, what);
        }
        self.number(&placed.parameters, "alpha", 1.0)
    }
}
