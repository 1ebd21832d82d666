//! Materials of pbrt-v4, and those of pbrt-v3 that went before them.
//!
//! What pbrt has as layers with light between them is [`Principled`] here; the light that goes to and
//! fro between a matte body and the surface above it is in the body's colour. pbrt's roughness is
//! the square root of α, or α itself where it is not remapped; here it is what α is the square of.
//!
//! Source: Pharr, Jakob, Humphreys, *pbrt-v4 input file format*, pbrt.org/fileformat-v4, and
//! *pbrt-v3 input file format*, pbrt.org/fileformat-v3: "Materials"; *Physically Based Rendering*,
//! 3rd ed., section 8.4.2 for the older roughness, 4th ed., section 14.3 for layers.

use super::description::{Named, Placed};
use super::parameters::{Before, Parameters};
use super::scene::Maker;
use super::spectra::Told;
use super::state::Chosen;
use super::textures::{Change, Texel};
use crate::error::{SceneError, SceneErrorKind};
use crate::scene::nearest::nearest;
use crate::scene::spectrum::{self, normal_reflectance};
use crate::shown::shown;
use rutilant::bsdf::Fresnel;
use rutilant::color::Rgb;
use rutilant::material::{
    Absorption, Bumps, Conductor, Dielectric, MAX_IOR, MAX_SPECULAR_COLOR, MOST_ROUGH_RATIO,
    Material, MaterialKind, Matte, Medium, Mirror, Mix, NormalMap, Opacity, OpacityMode,
    Principled, PrincipledTextures, ThinDielectric, most_rough_dispersion,
};
use rutilant::scene::TextureId;
use rutilant::texture::{Channel, ColorInput, Encoding, ScalarInput};
use rutilant_geom::real;

/// Which statement a material comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Which {
    Default,
    Own(usize),
    Named(usize),
}

/// How rough something is, as this renderer says it.
struct Rough {
    roughness: f32,
    texture: Option<(TextureId, Channel)>,
}

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

/// The largest part of a metal's index.
const MOST_INDEX: f32 = 1000.0;

impl Maker<'_> {
    /// The material that a shape names.
    pub(super) fn which(&self, chosen: &Chosen) -> Result<Which, SceneError> {
        match chosen {
            Chosen::Default => Ok(Which::Default),
            Chosen::Own(number) => Ok(Which::Own(*number)),
            Chosen::Named { name, place, before } => {
                self.named_material(name, *before, *place).map(Which::Named)
            }
        }
    }

    fn named_material(
        &self,
        name: &str,
        before: usize,
        place: super::lexer::Place,
    ) -> Result<usize, SceneError> {
        self.names.material(name, before).ok_or_else(|| {
            let known = self.description.named_materials.iter().map(|named| &*named.name);
            let kind = SceneErrorKind::Unknown {
                what: "material",
                name: shown(name),
                closest: nearest(name, known).map(shown),
            };
            self.texts.error(place, kind)
        })
    }

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

    /// What a coat of some thickness has that is not told here.
    fn layers_above(&mut self, parameters: &Parameters) -> Result<(), SceneError> {
        parameters.ignore(&["thickness", "interface.thickness", "maxdepth", "nsamples", "g"]);
        let albedo = self.color(parameters, "albedo", Rgb::BLACK)?;
        if albedo.as_constant() != Some(Rgb::BLACK) {
            let what = format!("the haze between the layers of {} is left out", parameters.of);
            self.note(parameters.place, what);
        }
        Ok(())
    }

    fn matte(&mut self, color: &Texel, roughness: f32, parameters: &Parameters) -> Material {
        if color.as_constant() == Some(Rgb::BLACK) {
            return Material::new(MaterialKind::Black);
        }
        let (factor, texture) = self.unit_color(color, "reflectance", parameters);
        let albedo = ColorInput { factor, texture, vertex_colors: false };
        Matte { roughness, ..Matte::new(albedo) }.into()
    }

    /// Gloss of a given colour above a matte body.
    fn glossy(
        &mut self,
        body: &Texel,
        gloss: &Texel,
        ior: f32,
        rough: &Rough,
        parameters: &Parameters,
    ) -> Material {
        let (base_color, texture) = self.unit_color(body, "Kd", parameters);
        let (specular, gloss_texture) = self.input(gloss);
        let specular_color = Rgb(specular.0.map(|c| c.clamp(0.0, MAX_SPECULAR_COLOR)));
        // A factor on what it reflects straight on is none on what it reflects at grazing.
        let is_dull = specular_color == Rgb::BLACK;
        Principled {
            base_color,
            roughness: rough.roughness,
            specular: if is_dull { 0.0 } else { 1.0 },
            specular_color: if is_dull { Rgb::WHITE } else { specular_color },
            ior,
            textures: PrincipledTextures {
                base_color: texture,
                specular_color: gloss_texture.filter(|_| !is_dull),
                roughness: rough.texture,
                ..Default::default()
            },
            ..Principled::default()
        }
        .into()
    }

    /// A thin sheet that sends a part of the light back and another part on.
    fn leaf(&mut self, back: Texel, on: Texel, parameters: &Parameters) -> Material {
        let most = |texel: &Texel| texel.factor.0.into_iter().fold(0.0, f32::max);
        let (r, t) = (most(&back), most(&on));
        let share = if r + t > 0.0 { t / (r + t) } else { 0.0 };
        let over = |part: f32| if part > 0.0 { Rgb::grey(1.0 / part) } else { Rgb::BLACK };
        let (back, on) = (back.times(over(1.0 - share)), on.times(over(share)));
        let (base_color, base_texture) = self.unit_color(&back, "reflectance", parameters);
        let (through, through_texture) = self.unit_color(&on, "transmittance", parameters);
        Principled {
            base_color,
            specular: 0.0,
            thin_walled: true,
            diffuse_transmission: share,
            diffuse_transmission_color: through,
            textures: PrincipledTextures {
                base_color: base_texture,
                diffuse_transmission_color: through_texture,
                ..Default::default()
            },
            ..Principled::default()
        }
        .into()
    }

    fn conductor(&mut self, parameters: &Parameters, old: bool) -> Result<Material, SceneError> {
        let rough = self.rough(parameters, "", if old { 0.01 } else { 0.0 }, !old)?;
        let varies = match parameters.get("reflectance") {
            Some(_) => Some(self.color(parameters, "reflectance", Rgb::WHITE)?),
            None => None,
        };
        let varies = varies.filter(|texel| texel.varies.is_some());
        if rough.texture.is_some() || varies.is_some() {
            let base = match varies {
                Some(texel) => texel,
                None => Texel::constant(self.metal(parameters, "")?.normal_reflectance(1.0)),
            };
            let (base_color, texture) = self.unit_color(&base, "reflectance", parameters);
            return Ok(Principled {
                base_color,
                metallic: 1.0,
                roughness: rough.roughness,
                textures: PrincipledTextures {
                    base_color: texture,
                    roughness: rough.texture,
                    ..Default::default()
                },
                ..Principled::default()
            }
            .into());
        }
        let Metal { eta, k } = self.metal(parameters, "")?;
        Ok(Conductor::new(eta, k, rough.roughness).into())
    }

    /// The index of a metal.
    fn metal(&mut self, parameters: &Parameters, prefix: &str) -> Result<Metal, SceneError> {
        let of = |name: &str| format!("{prefix}{name}");
        if let Some(told) = self.spectrum(parameters, "reflectance")? {
            // What reflects so much without an index of its own.
            let k = told.reflectance().0.map(|r| {
                let r = r.clamp(0.0, 0.9999);
                2.0 * (r / (1.0 - r)).sqrt()
            });
            return Ok(Metal { eta: Rgb::WHITE, k: Rgb(k) });
        }
        let (eta, k) =
            (self.spectrum(parameters, &of("eta"))?, self.spectrum(parameters, &of("k"))?);
        let [copper_eta, copper_k] = spectrum::metal("Cu").unwrap_or([Rgb::WHITE; 2]);
        let [eta, k] = match (eta, k) {
            (Some(Told::Sampled(eta)), Some(Told::Sampled(k))) => {
                spectrum::metal_of(&eta.held(), &k.held())
            }
            (eta, k) => {
                [eta.map_or(copper_eta, |eta| eta.numbers()), k.map_or(copper_k, |k| k.numbers())]
            }
        };
        let within = |rgb: Rgb| Rgb(rgb.0.map(|c| c.clamp(0.0, MOST_INDEX)));
        Ok(Metal { eta: within(eta), k: within(k) })
    }

    fn glass(
        &mut self,
        ior: f32,
        dispersion: f32,
        roughness: f32,
        [inside, outside]: [&str; 2],
        parameters: &Parameters,
    ) -> Material {
        let mut medium =
            |ior: f32, name: &str| Medium { ior, absorption: self.absorption(name, parameters) };
        let mut made = Dielectric::new(ior);
        if ior >= 1.0 {
            made.interior = medium(ior.min(MAX_IOR), inside);
            made.exterior = medium(1.0, outside);
        } else {
            made.interior = medium(1.0, inside);
            made.exterior = medium((1.0 / ior).min(MAX_IOR), outside);
        }
        let ratio = made.interior.ior.max(made.exterior.ior);
        if roughness > 0.0 && ratio > MOST_ROUGH_RATIO {
            let what = format!(
                "{} is smooth: rough glass has an index of refraction up to {MOST_ROUGH_RATIO}",
                parameters.of
            );
            self.note(parameters.place, what);
        } else {
            made.roughness = roughness;
        }
        let most = if made.roughness > 0.0 { most_rough_dispersion(ratio) } else { f32::MAX };
        made.dispersion = dispersion.min(most);
        made.into()
    }

    /// A surface that is not there, but may be the border of what absorbs.
    fn nothing(&mut self, media: [&str; 2], parameters: &Parameters) -> Material {
        let [inside, outside] = media.map(|name| self.absorption(name, parameters));
        if inside == Absorption::None && outside == Absorption::None {
            return Material::new(MaterialKind::Null);
        }
        Dielectric {
            interior: Medium { ior: 1.0, absorption: inside },
            exterior: Medium { ior: 1.0, absorption: outside },
            ..Dielectric::new(1.0)
        }
        .into()
    }

    fn absorption(&mut self, medium: &str, parameters: &Parameters) -> Absorption {
        if medium.is_empty() {
            return Absorption::None;
        }
        match self.media.get(medium) {
            Some(absorption) => *absorption,
            None => {
                let what = format!("there is no medium \"{}\": nothing stands in", shown(medium));
                self.note(parameters.place, what);
                Absorption::None
            }
        }
    }

    fn disney(&mut self, parameters: &Parameters) -> Result<Material, SceneError> {
        let color = self.color(parameters, "color", Rgb::grey(0.5))?;
        let (base_color, texture) = self.unit_color(&color, "color", parameters);
        let roughness = self.number(parameters, "roughness", 0.5)?;
        let metallic = self.number(parameters, "metallic", 0.0)?;
        let (roughness, rough_texture) = self.scalar(&roughness);
        let (metallic, metal_texture) = self.scalar(&metallic);
        let mut part = |name: &str, default: f32| {
            self.plain_number(parameters, name, default).map(|value| value.clamp(0.0, 1.0))
        };
        let (anisotropy, coat) = (part("anisotropic", 0.0)?, part("clearcoat", 0.0)?);
        let (gloss, sheen) = (part("clearcoatgloss", 1.0)?, part("sheen", 0.0)?);
        let transmission = part("spectrans", 0.0)?;
        let through = self.plain_number(parameters, "difftrans", 1.0)?;
        let thin_walled = parameters.truth_or("thin", false, self.texts)?;
        let ior = self.index(parameters, "eta", 1.5)?.0;
        parameters.ignore(&["speculartint", "sheentint", "flatness", "scatterdistance"]);
        Ok(Principled {
            base_color,
            metallic: metallic.clamp(0.0, 1.0),
            roughness: roughness.clamp(0.0, 1.0),
            anisotropy,
            ior: if transmission > 0.0 { ior.min(MOST_ROUGH_RATIO) } else { ior },
            transmission,
            thin_walled,
            diffuse_transmission: if thin_walled { (0.5 * through).clamp(0.0, 1.0) } else { 0.0 },
            coat: 0.25 * coat,
            coat_roughness: (0.1 + (0.001 - 0.1) * gloss).sqrt(),
            sheen_color: Rgb::grey(sheen),
            textures: PrincipledTextures {
                base_color: texture,
                roughness: rough_texture,
                metallic: metal_texture,
                ..Default::default()
            },
            ..Principled::default()
        }
        .into())
    }

    fn mix(&mut self, parameters: &Parameters) -> Result<Material, SceneError> {
        let place = parameters.place;
        let old = parameters.get("namedmaterial1").is_some();
        let names: Vec<String> = if old {
            let of = |name: &str| parameters.text(name, self.texts);
            let (first, second) = (of("namedmaterial1")?, of("namedmaterial2")?);
            [first, second].into_iter().flatten().map(str::to_owned).collect()
        } else {
            match parameters.get("materials").map(|parameter| &parameter.values) {
                Some(super::parameters::Values::Texts(names)) => names.clone(),
                Some(_) | None => Vec::new(),
            }
        };
        let [first, second] = &names[..] else {
            let what = format!("{} must name two materials", parameters.of);
            return Err(self.texts.invalid(place, what));
        };
        let mut amount = self.number(parameters, "amount", 0.5)?;
        if old {
            // There it was the share of the first.
            amount = amount.changed(Change::Invert);
        }
        if self.making.len() as u64 > self.options.limits.nesting {
            let (asked, allowed) = (self.making.len() as u64, self.options.limits.nesting);
            let kind = SceneErrorKind::Limit { what: "levels of nesting", asked, allowed };
            return Err(self.texts.error(place, kind));
        }
        let Before { materials: before, .. } = parameters.before;
        let mut part = |name: &str| {
            if matches!(name, "interface" | "none") && self.names.material(name, before).is_none() {
                return Ok(Material::new(MaterialKind::Null));
            }
            let number = self.named_material(name, before, place)?;
            self.mixed_parts += 1;
            if self.mixed_parts > MOST_PARTS {
                let what = "mixtures of mixtures have too many parts";
                return Err(self.texts.invalid(place, what));
            }
            self.look(Which::Named(number), ["", ""])
        };
        let (first, second) = (part(first)?, part(second)?);

        // What is mixed with nothing has holes.
        let null = |material: &Material| {
            matches!(material.kind, MaterialKind::Null) && material.opacity.is_none()
        };
        if null(&second) {
            let mut material = first;
            self.open(&mut material, &amount.changed(Change::Invert));
            return Ok(material);
        }
        if null(&first) {
            let mut material = second;
            self.open(&mut material, &amount);
            return Ok(material);
        }
        if amount.varies.is_some() {
            let what = format!("the amount of {} cannot vary: its mean stands in", parameters.of);
            self.note(place, what);
        }
        let [r, g, b] = super::textures::mean(&amount).0;
        let amount = ((r + g + b) / 3.0).clamp(0.0, 1.0);
        if amount == 0.0 {
            return Ok(first);
        }
        if amount == 1.0 {
            return Ok(second);
        }
        let plain = |material: &Material| {
            let mixes = matches!(
                material.kind,
                MaterialKind::Black
                    | MaterialKind::Matte(_)
                    | MaterialKind::Mirror(_)
                    | MaterialKind::Conductor(_)
                    | MaterialKind::ThinDielectric(_)
            );
            mixes && material.opacity.is_none() && material.normal_map.is_none()
        };
        if plain(&first) && plain(&second) {
            let (first, second) = (self.scene.add_material(first), self.scene.add_material(second));
            return Ok(Mix { first, second, amount }.into());
        }
        if let (Some(a), Some(b)) = (layers(&first.kind), layers(&second.kind))
            && let Some(layers) = between(&a, &b, amount)
        {
            let heavier = if amount > 0.5 { second } else { first };
            let kind = MaterialKind::Principled(Box::new(layers));
            return Ok(Material { kind, ..heavier });
        }
        let what = format!(
            "{} mixes what cannot be mixed here: what there is more of stands in for it",
            parameters.of
        );
        self.note(place, what);
        Ok(if amount > 0.5 { second } else { first })
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

    /// Factor and texture of a colour, whose factor lies between 0 and 1.
    fn unit_color(
        &mut self,
        texel: &Texel,
        name: &str,
        parameters: &Parameters,
    ) -> (Rgb, Option<TextureId>) {
        let (factor, texture) = self.input(texel);
        if !factor.is_within(0.0..=1.0) {
            let what =
                format!("\"{name}\" of {} is moved into the range from 0 to 1", parameters.of);
            self.note(parameters.place, what);
        }
        (Rgb(factor.0.map(|c| c.clamp(0.0, 1.0))), texture)
    }

    /// Index of refraction and dispersion.
    fn index(
        &mut self,
        parameters: &Parameters,
        name: &str,
        default: f32,
    ) -> Result<(f32, f32), SceneError> {
        let (ior, dispersion) = match self.spectrum(parameters, name)? {
            None => (default, 0.0),
            Some(Told::Glass(glass)) => (glass.ior, glass.abbe.map_or(0.0, |abbe| 20.0 / abbe)),
            Some(Told::Sampled(eta)) => {
                let eta = eta.held();
                let [f, d, c] = [486.13, 587.56, 656.27].map(|nm| eta.at(nm));
                // The Abbe number is (d − 1) / (F − C).
                let dispersion =
                    if d > 1.0 { (20.0 * (f - c) / (d - 1.0)).clamp(0.0, 20.0) } else { 0.0 };
                (d, dispersion)
            }
            Some(told) => (told.numbers().0[1], 0.0),
        };
        if !(ior > 0.0 && ior.is_finite()) {
            let what = format!("\"{name}\" of {} is {ior}, but must be more than 0", parameters.of);
            return Err(self.texts.invalid(parameters.place, what));
        }
        let is_glass = matches!(name, "eta" | "index");
        Ok((ior.clamp(if is_glass { 0.1 } else { 1.0 }, MAX_IOR), dispersion))
    }

    /// How rough it is; `square` where what is written is the square of α.
    fn rough(
        &mut self,
        parameters: &Parameters,
        prefix: &str,
        default: f32,
        square: bool,
    ) -> Result<Rough, SceneError> {
        let of = |name: &str| format!("{prefix}{name}");
        let both = self.number(parameters, &of("roughness"), default)?;
        let mut along = |name: &str| match parameters.get(&of(name)) {
            Some(_) => self.number(parameters, &of(name), default),
            None => Ok(both.clone()),
        };
        let (u, v) = (along("uroughness")?, along("vroughness")?);
        let remap = parameters.truth_or("remaproughness", true, self.texts)?;
        let alpha = |x: f32| match (remap, square) {
            (false, _) => x,
            (true, true) => x.max(0.0).sqrt(),
            (true, false) => older_alpha(x),
        };
        let is_smooth = |texel: &Texel| texel.as_number().is_some_and(|x| x <= 0.0);
        if is_smooth(&u) && is_smooth(&v) {
            return Ok(Rough { roughness: 0.0, texture: None });
        }
        match (u.as_number(), v.as_number()) {
            (Some(u), Some(v)) => {
                if u != v {
                    let what =
                        format!("{} is as rough along u as along v: their mean", parameters.of);
                    self.note(parameters.place, what);
                }
                // As steep in the mean square, as brushed surfaces are told here.
                let (u, v) = (alpha(u), alpha(v));
                let alpha = (0.5 * (u * u + v * v)).sqrt().min(1.0);
                Ok(Rough { roughness: alpha.sqrt(), texture: None })
            }
            (u_number, _) => {
                let varies = if u_number.is_none() { u } else { v };
                let exponent = if remap { 0.25 } else { 0.5 };
                let (factor, texture) = self.scalar(&varies.changed(Change::Power(exponent)));
                Ok(Rough { roughness: factor.clamp(0.0, 1.0), texture })
            }
        }
    }

    fn even(&mut self, rough: &Rough, parameters: &Parameters) {
        if rough.texture.is_some() {
            let what = format!("{} is as rough everywhere", parameters.of);
            self.note(parameters.place, what);
        }
    }
}

/// Parts of mixtures, each time that they are looked at.
const MOST_PARTS: usize = 100_000;

/// The complex index of a metal.
struct Metal {
    eta: Rgb,
    k: Rgb,
}

impl Metal {
    /// What it reflects of light that falls straight onto it, from a medium of index `outside`.
    fn normal_reflectance(&self, outside: f32) -> Rgb {
        Rgb(std::array::from_fn(|i| {
            let [eta, k] = [self.eta, self.k].map(|part| part.0[i] / outside);
            normal_reflectance(eta, k).clamp(0.0, 1.0)
        }))
    }
}

/// What a dielectric surface sends back of diffuse light that comes to it from inside. The light
/// that enters from outside, 1 − R of it, leaves by the same ways, of which there are n² as many
/// inside: 1 − (1 − R) / n².
pub(super) fn sent_back_inside(ior: f32) -> f32 {
    if ior <= 1.0 {
        return 0.0;
    }
    const STEPS: u32 = 256;
    // The mean of Fresnel's reflectance over the cosine-weighted hemisphere: 2 ∫ F(µ) µ dµ.
    let step = 1.0 / STEPS as f32;
    let mut outside = 0.0;
    for i in 0..STEPS {
        let mu = (i as f32 + 0.5) * step;
        let (reflected, _) = Fresnel::Exact.dielectric(mu, ior);
        outside += 2.0 * reflected * mu * step;
    }
    1.0 - (1.0 - outside) / (ior * ior)
}

/// α for a roughness as pbrt-v3 has it: Pharr, Jakob, Humphreys, 3rd ed., section 8.4.2.
fn older_alpha(roughness: f32) -> f32 {
    let x = real::ln(roughness.max(1e-3));
    1.621_42 + x * (0.819_955 + x * (0.173_4 + x * (0.017_120_1 + x * 0.000_640_711)))
}

/// The same as layers, where that can be said.
fn layers(kind: &MaterialKind) -> Option<Principled> {
    match kind {
        MaterialKind::Principled(layers) => Some(**layers),
        MaterialKind::Matte(matte) => Some(Principled {
            base_color: matte.albedo.factor,
            diffuse_roughness: matte.roughness,
            specular: 0.0,
            textures: PrincipledTextures {
                base_color: matte.albedo.texture,
                vertex_colors: matte.albedo.vertex_colors,
                ..Default::default()
            },
            ..Principled::default()
        }),
        MaterialKind::Black => {
            Some(Principled { base_color: Rgb::BLACK, specular: 0.0, ..Principled::default() })
        }
        MaterialKind::Mirror(mirror) => Some(Principled {
            base_color: mirror.reflectance,
            metallic: 1.0,
            roughness: 0.0,
            ..Principled::default()
        }),
        MaterialKind::Conductor(conductor) => {
            let metal = Metal { eta: conductor.eta, k: conductor.k };
            Some(Principled {
                base_color: metal.normal_reflectance(1.0),
                metallic: 1.0,
                roughness: conductor.roughness,
                ..Principled::default()
            })
        }
        MaterialKind::Null
        | MaterialKind::Dielectric(_)
        | MaterialKind::ThinDielectric(_)
        | MaterialKind::Mix(_)
        | MaterialKind::Custom(_) => None,
    }
}

/// Layers whose numbers lie between those of two others; `None` where textures are in the way.
fn between(a: &Principled, b: &Principled, amount: f32) -> Option<Principled> {
    if a.textures != b.textures || a.thin_walled != b.thin_walled {
        return None;
    }
    let lerp = |a: f32, b: f32| a + (b - a) * amount;
    let colors = |a: Rgb, b: Rgb| Rgb(std::array::from_fn(|i| lerp(a.0[i], b.0[i])));
    Some(Principled {
        base_color: colors(a.base_color, b.base_color),
        metallic: lerp(a.metallic, b.metallic),
        roughness: lerp(a.roughness, b.roughness),
        diffuse_roughness: lerp(a.diffuse_roughness, b.diffuse_roughness),
        specular: lerp(a.specular, b.specular),
        specular_color: colors(a.specular_color, b.specular_color),
        ior: lerp(a.ior, b.ior),
        transmission: lerp(a.transmission, b.transmission),
        diffuse_transmission: lerp(a.diffuse_transmission, b.diffuse_transmission),
        coat: lerp(a.coat, b.coat),
        coat_roughness: if a.coat > 0.0 { a.coat_roughness } else { b.coat_roughness },
        coat_ior: if a.coat > 0.0 { a.coat_ior } else { b.coat_ior },
        ..*a
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Walsh's closed form for the diffuse reflectance of an index of 1.5 is 0.0918, so inside it
    /// sends back 0.596, as Duntley 1942 has it; no border sends nothing back.
    #[test]
    fn surfaces_send_diffuse_light_back_inside() {
        assert!((sent_back_inside(1.5) - 0.596_4).abs() < 1e-3, "{}", sent_back_inside(1.5));
        assert!((sent_back_inside(1.33) - 0.472).abs() < 2e-3, "{}", sent_back_inside(1.33));
        assert_eq!(sent_back_inside(1.0), 0.0);
    }

    /// Values of the older polynomial that can be checked by hand: at 1 all logarithms are 0.
    #[test]
    fn older_roughness_is_a_polynomial_of_the_logarithm() {
        assert!((older_alpha(1.0) - 1.621_42).abs() < 1e-6);
        let x = 0.1_f64.ln();
        let expected = 1.62142
            + 0.819955 * x
            + 0.1734 * x * x
            + 0.0171201 * x.powi(3)
            + 0.000640711 * x.powi(4);
        assert!((f64::from(older_alpha(0.1)) - expected).abs() < 1e-5);
    }
}
