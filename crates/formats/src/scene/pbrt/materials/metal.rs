//! Metals, by their index or their colour.

use crate::error::SceneError;
use crate::scene::pbrt::parameters::Parameters;
use crate::scene::pbrt::scene::Maker;
use crate::scene::pbrt::spectra::Told;
use crate::scene::pbrt::textures::Texel;
use crate::scene::spectrum::{self, normal_reflectance};
use rutilant::color::Rgb;
use rutilant::material::{Conductor, Material, Principled, PrincipledTextures};

/// The largest part of a metal's index.
const MOST_INDEX: f32 = 1000.0;

/// The complex index of a metal.
pub(super) struct Metal {
    pub(super) eta: Rgb,
    pub(super) k: Rgb,
}

impl Metal {
    /// What it reflects of light that falls straight onto it, from a medium of index `outside`.
    pub(super) fn normal_reflectance(&self, outside: f32) -> Rgb {
        Rgb(std::array::from_fn(|i| {
            let [eta, k] = [self.eta, self.k].map(|part| part.0[i] / outside);
            normal_reflectance(eta, k).clamp(0.0, 1.0)
        }))
    }
}

impl Maker<'_> {
    pub(super) fn conductor(
        &mut self,
        parameters: &Parameters,
        old: bool,
    ) -> Result<Material, SceneError> {
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
    pub(super) fn metal(
        &mut self,
        parameters: &Parameters,
        prefix: &str,
    ) -> Result<Metal, SceneError> {
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
}
