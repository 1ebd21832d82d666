//! Matte bodies with something above them, leaves, and what Disney's material says.

use super::inputs::Rough;
use crate::error::SceneError;
use crate::scene::disney::tint_once;
use crate::scene::pbrt::parameters::Parameters;
use crate::scene::pbrt::scene::Maker;
use crate::scene::pbrt::textures::Texel;
use rutilant::bsdf::Fresnel;
use rutilant::color::Rgb;
use rutilant::material::{
    MAX_SPECULAR_COLOR, MOST_ROUGH_RATIO, Material, Principled, PrincipledTextures,
};

impl Maker<'_> {
    /// What a coat of some thickness has that is not told here.
    pub(super) fn layers_above(&mut self, parameters: &Parameters) -> Result<(), SceneError> {
        parameters.ignore(&["thickness", "interface.thickness", "maxdepth", "nsamples", "g"]);
        let albedo = self.color(parameters, "albedo", Rgb::BLACK)?;
        if albedo.as_constant() != Some(Rgb::BLACK) {
            let what = format!("the haze between the layers of {} is left out", parameters.of);
            self.note(parameters.place, what);
        }
        Ok(())
    }

    /// Gloss of a given colour above a matte body.
    pub(super) fn glossy(
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
    pub(super) fn leaf(&mut self, back: Texel, on: Texel, parameters: &Parameters) -> Material {
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

    pub(super) fn disney(&mut self, parameters: &Parameters) -> Result<Material, SceneError> {
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
        let mut layers = Principled {
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
        };
        if let Some(what) = tint_once(&mut layers) {
            self.note(parameters.place, what);
        }
        Ok(layers.into())
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
}
