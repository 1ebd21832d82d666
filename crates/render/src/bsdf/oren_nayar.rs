//! Rough diffuse reflection: clay, plaster, the moon.
//!
//! A rough matte surface looks flatter than a Lambertian one: grazing parts and
//! what looks back towards the light are brighter. This is Fujii's form of the
//! Oren–Nayar model, and what it loses to further bounces between its slopes is
//! given back by a second, reciprocal term, so that a white surface stays white
//! at every roughness.
//!
//! Directions are drawn from the cosine around the normal, or, towards grazing
//! `wo` and for rough surfaces more often, from the cosine around the horizontal
//! direction on the side of `wo`, folded up into the hemisphere. The value is at
//! most a sum of the two, so no sample weighs much more than the albedo.
//!
//! Source: Oren and Nayar, "Generalization of Lambert's Reflectance Model",
//! SIGGRAPH 1994; Portsmouth, Kutz, Hill, "EON: A Practical Energy-Preserving
//! Rough Diffuse BRDF", JCGT 14(1), 2025. The way of sampling is our own.

use super::sample::BsdfSample;
use crate::color::Spectrum;
use crate::math::warp;
use rutilant_geom::{Vec2, Vec3, real};
use std::f32::consts::{FRAC_1_PI, PI};

/// A rough matte surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrenNayar {
    albedo: Spectrum,
    roughness: f32,
    /// What a flat surface scatters once, of a white one's 1.
    flat: f32,
    /// The colour of what is scattered more than once, over the mean of what is left for it.
    many: Spectrum,
}

impl OrenNayar {
    /// `albedo` is the part of the light that each slope sends back, 0 to 1, and what a white
    /// surface sends back in all; `roughness` lies between 0 (Lambert) and 1.
    pub fn new(albedo: Spectrum, roughness: f32) -> Self {
        let flat = 1.0 / (1.0 + (0.5 - 2.0 / (3.0 * PI)) * roughness);
        // The mean of `scattered_once` over the cosine-weighted hemisphere.
        let once = flat * (1.0 + (2.0 / 3.0 - 28.0 / (15.0 * PI)) * roughness);
        // Less is only rounding, and next to nothing is left to give back.
        let given_back = if 1.0 - once > 1e-6 { 1.0 / (1.0 - once) } else { 0.0 };
        let many = albedo.map(|a| a * a * once / (1.0 - a * (1.0 - once)) * given_back);
        Self { albedo, roughness, flat, many }
    }

    /// What part of white light single scattering sends on in all, seen under the cosine `mu`.
    fn scattered_once(&self, mu: f32) -> f32 {
        let sin = ((1.0 - mu) * (1.0 + mu)).max(0.0).sqrt();
        // (1 - sin³) / cos = cos (1 + sin + sin²) / (1 + sin), also at cos = 0.
        let grazing = sin * (mu * (1.0 + sin + sin * sin) / (1.0 + sin) - 1.0);
        let g = sin * (real::acos(mu.min(1.0)) - sin * mu) + 2.0 / 3.0 * grazing;
        self.flat * (1.0 + self.roughness * FRAC_1_PI * g)
    }

    /// BSDF value times cosine, `f(wo, wi) |cos θi|`, in 1/sr.
    #[inline(never)]
    pub fn eval_cos(&self, wo: Vec3, wi: Vec3) -> Spectrum {
        if wo.z * wi.z <= 0.0 {
            return Spectrum::BLACK;
        }
        let (o, i) = (wo.z.abs(), wi.z.abs());
        // The cosine between the two, without what their heights contribute.
        let s = wo.x * wi.x + wo.y * wi.y;
        let leaning = s * if s > 0.0 { i / i.max(o) } else { i };
        let once = self.flat * (i + self.roughness * leaning);
        let left = |mu| (1.0 - self.scattered_once(mu)).max(0.0);
        (self.albedo * once + self.many * (left(o) * left(i) * i)) * FRAC_1_PI
    }

    /// The part of the BSDF that is the same in all directions of one side, in 1/sr: no more than
    /// there is anywhere.
    pub(super) fn even_part(&self) -> Spectrum {
        self.albedo * (self.flat * (1.0 - self.roughness) * FRAC_1_PI)
    }

    /// The density of [`sample`](Self::sample), in 1/sr.
    #[inline(never)]
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        if wo.z * wi.z <= 0.0 {
            return 0.0;
        }
        let (share, ahead) = self.leaning(wo);
        let along = (ahead.x * wi.x + ahead.y * wi.y).max(0.0);
        // Folding brings both halves of the sideways hemisphere together.
        (1.0 - share) * warp::cosine_hemisphere_pdf(wi.z.abs())
            + share * 2.0 * warp::cosine_hemisphere_pdf(along)
    }

    /// Draws the direction the light came from, given `wo`, where it leaves to.
    ///
    /// `choice` and `u` hold numbers in [0, 1). `None` for a direction in the surface itself,
    /// which scatters nothing.
    #[inline(never)]
    pub fn sample(&self, wo: Vec3, choice: f32, u: Vec2) -> Option<BsdfSample> {
        let (share, ahead) = self.leaning(wo);
        let d = warp::cosine_hemisphere(u);
        let up = if choice < share {
            // x becomes the height, z lies along `ahead`.
            Vec3::new(ahead.x * d.z - ahead.y * d.y, ahead.y * d.z + ahead.x * d.y, d.x.abs())
        } else {
            d
        };
        let wi = if wo.z < 0.0 { Vec3::new(up.x, up.y, -up.z) } else { up };
        let pdf = self.pdf(wo, wi);
        (pdf > 0.0).then(|| BsdfSample {
            wi,
            weight: self.eval_cos(wo, wi) / pdf,
            pdf,
            delta: false,
            eta: 1.0,
        })
    }

    /// The part of light sent back, nearly.
    pub fn albedo(&self) -> Spectrum {
        self.albedo
    }

    /// How often the sideways cosine is drawn, and its direction in the surface.
    fn leaning(&self, wo: Vec3) -> (f32, Vec2) {
        let across = Vec2::new(wo.x, wo.y);
        let sin = across.length();
        if sin == 0.0 {
            return (0.0, Vec2::X);
        }
        // Found by trying what makes the weights most even.
        let lean = 0.6 * self.roughness * sin * sin * sin;
        (lean / (1.0 + lean), across / sin)
    }
}
