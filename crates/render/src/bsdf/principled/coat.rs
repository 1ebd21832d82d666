//! A clear coat over everything else.

use super::PrincipledParameters;
use crate::bsdf::energy::Loss;
use crate::bsdf::fresnel::Fresnel;
use crate::bsdf::gloss::{self, Rise};
use crate::bsdf::microfacet::Ggx;
use crate::color::Spectrum;
use rutilant_geom::real;

/// A clear layer that reflects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Coat {
    /// How much of it there is.
    pub(super) weight: f32,
    pub(super) ior: f32,
    pub(super) color: Spectrum,
    /// `None` where it is smooth.
    pub(super) rough: Option<RoughCoat>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RoughCoat {
    pub(super) ggx: Ggx,
    pub(super) loss: Loss,
    pub(super) rise: Rise,
}

impl Coat {
    pub(super) fn new(its: &PrincipledParameters) -> Option<Self> {
        let alpha = its.coat_roughness * its.coat_roughness;
        let rough = (alpha >= Ggx::LEAST_ALPHA).then(|| RoughCoat {
            ggx: Ggx { alpha },
            loss: Loss::metal(its.coat_roughness),
            rise: Rise::new(its.coat_ior, its.coat_roughness),
        });
        let weight = its.coat;
        let color = its.coat_color.map(|c| 1.0 + (c - 1.0) * weight);
        (weight > 0.0).then_some(Self { weight, ior: its.coat_ior, color, rough })
    }

    /// The part that it reflects in all under the cosine `mu`.
    pub(super) fn reflected(&self, mu: f32) -> f32 {
        match &self.rough {
            None => Fresnel::Exact.dielectric(mu, self.ior).0,
            Some(rough) => {
                let normal = gloss::normal_reflectance(self.ior);
                (1.0 - rough.loss.at(mu)) * (normal + (1.0 - normal) * rough.rise.at(mu))
            }
        }
    }

    /// What is left of light on its way through, under the cosine `mu` outside: slanted ways are
    /// longer.
    pub(super) fn leg(&self, mu: f32) -> Spectrum {
        if self.color == Spectrum::WHITE {
            return Spectrum::WHITE;
        }
        let (_, cos) = Fresnel::Exact.dielectric(mu, self.ior);
        self.color.map(|c| if c > 0.0 { real::exp(real::ln(c) * 0.5 / cos) } else { 0.0 })
    }
}
