//! Sheen: fibres that stand up from cloth, and dust, which shine towards grazing.
//!
//! Facets are spread as a power of the sine: most of them stand upright. How
//! they hide each other is a curve fitted to a simulation. The softened
//! terminator of the source is left out, for it would not be reciprocal.
//!
//! Directions are drawn evenly; the value is nowhere large enough for more.
//!
//! Not for roughness below 0.3: fibres that stand so straight would send back
//! more light than they get, and are taken as that rough.
//!
//! Source: Estevez and Kulla, "Production Friendly Microfacet Sheen BRDF",
//! SIGGRAPH course, 2017, equations 2 to 4; glTF extension `KHR_materials_sheen`.

use super::gloss::{LEAST_SHEEN, SheenAlbedo};
use crate::color::Spectrum;
use rutilant_geom::{Vec3, real};
use std::f32::consts::PI;

/// A layer of fibres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sheen {
    color: Spectrum,
    alpha: f32,
    albedo: SheenAlbedo,
}

impl Sheen {
    /// `None` where it is black. `roughness` lies between 0 and 1; α is its square.
    pub(super) fn new(color: Spectrum, roughness: f32) -> Option<Self> {
        let roughness = roughness.max(LEAST_SHEEN);
        let alpha = roughness * roughness;
        let albedo = SheenAlbedo::new(roughness);
        (!color.is_black()).then_some(Self { color, alpha, albedo })
    }

    /// The part of light that does not come through to what is below, of any channel the most.
    pub(super) fn taken(&self, mu: f32) -> f32 {
        (self.color.max_channel() * self.albedo.at(mu)).min(1.0)
    }

    /// What is sent back under the cosine `mu`.
    pub(super) fn albedo(&self, mu: f32) -> Spectrum {
        self.color * self.albedo.at(mu)
    }

    /// BSDF value times cosine for directions on one side.
    pub(super) fn eval_cos(&self, wo: Vec3, wi: Vec3) -> Spectrum {
        let (o, i) = (wo.z.abs(), wi.z.abs());
        let half = wo + wi;
        let length2 = half.length_squared();
        if length2 == 0.0 || o == 0.0 {
            return Spectrum::BLACK;
        }
        let sin2 = (half.x * half.x + half.y * half.y) / length2;
        let power = if sin2 > 0.0 { real::exp(real::ln(sin2) * 0.5 / self.alpha) } else { 0.0 };
        let density = (2.0 + 1.0 / self.alpha) * power / (2.0 * PI);
        let hidden = 1.0 + self.hides(o) + self.hides(i);
        self.color * (density / (hidden * 4.0 * o))
    }

    /// Smith's Λ, fitted: Estevez and Kulla 2017, equation 3 and table 1.
    fn hides(&self, cos: f32) -> f32 {
        let softness = (1.0 - self.alpha) * (1.0 - self.alpha);
        let mix = |soft: f32, hard: f32| softness * soft + (1.0 - softness) * hard;
        let (a, b, c) = (mix(25.3245, 21.5473), mix(3.324_35, 3.829_87), mix(0.168_01, 0.198_23));
        let (d, e) = (mix(-1.273_93, -1.977_60), mix(-4.859_67, -4.320_54));
        let curve = |x: f32| a / (1.0 + b * real::pow(x, c)) + d * x + e;
        real::exp(if cos < 0.5 {
            curve(cos)
        } else {
            2.0 * curve(0.5) - curve((1.0 - cos).max(0.0))
        })
    }
}
