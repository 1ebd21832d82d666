//! A pane of glass so thin that it needs no inside: windows, soap films, cling film.
//!
//! Light passes straight on or is mirrored. Between the two faces it goes to and
//! fro, and every time a part leaves: the geometric series over that is summed
//! here, with what the glass absorbs on every pass.
//!
//! Not for glass whose edges, thickness or bending of light are to be seen.
//!
//! Source: Stokes, "On the Intensity of the Light Reflected from or Transmitted
//! through a Pile of Plates", 1862.

use super::fresnel::Fresnel;
use super::mirror::reflection;
use super::sample::BsdfSample;
use crate::color::Spectrum;
use rutilant_geom::{Vec3, real};

/// A thin pane, the same from both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinDielectric {
    /// Index of refraction of the pane over that around it.
    eta: f32,
    /// How often light is absorbed on the straight way through: -ln of what is left.
    depth: Spectrum,
}

impl ThinDielectric {
    /// `color` is what is left of white light after one pass at normal incidence, 0 to 1, without
    /// what the faces reflect.
    pub fn new(eta: f32, color: Spectrum) -> Self {
        // The sum with zero makes -0 a plain 0. A channel of 0 is infinitely deep.
        Self { eta, depth: color.map(|c| -real::ln(c) + 0.0) }
    }

    /// Draws reflection or the way straight on; `choice` in [0, 1) decides. `None` for a
    /// direction in the surface itself.
    #[inline(never)]
    pub fn sample(&self, wo: Vec3, choice: f32) -> Option<BsdfSample> {
        let (reflected, passed) = self.parts(wo.z.abs());
        let (r, p) = (reflected.max_channel(), passed.max_channel());
        let chance = r / (r + p);
        if choice < chance {
            let mirrored = reflection(wo, reflected / chance)?;
            return Some(BsdfSample { pdf: chance, ..mirrored });
        }
        let pdf = 1.0 - chance;
        (wo.z != 0.0 && pdf > 0.0).then(|| BsdfSample {
            wi: -wo,
            weight: passed / pdf,
            pdf,
            delta: true,
            eta: 1.0,
        })
    }

    /// What is sent on at normal incidence.
    pub fn albedo(&self) -> Spectrum {
        let (reflected, passed) = self.parts(1.0);
        reflected + passed
    }

    /// What is reflected and what passes, both faces and all ways between them together.
    fn parts(&self, cos: f32) -> (Spectrum, Spectrum) {
        if self.eta == 1.0 && self.depth.is_black() {
            return (Spectrum::BLACK, Spectrum::WHITE);
        }
        let (r, cos_t) = Fresnel::Exact.dielectric(cos, self.eta);
        let t = 1.0 - r;
        // What one pass leaves; slanted ones are longer.
        let pass = self.depth.map(|d| if d > 0.0 { real::exp(-d / cos_t) } else { 1.0 });
        // r + t² r a² (1 + r² a² + …), and t² a (1 + r² a² + …).
        let series = |a: f32| if r < 1.0 { t * t * a / (1.0 - r * r * a * a) } else { 0.0 };
        (pass.map(|a| r + r * a * series(a)), pass.map(series))
    }
}
