//! Numbers that several kinds of materials share: colours, indices, roughness.
//!
//! Source: as for `mod.rs`.

use crate::error::SceneError;
use crate::scene::pbrt::parameters::Parameters;
use crate::scene::pbrt::scene::Maker;
use crate::scene::pbrt::spectra::Told;
use crate::scene::pbrt::textures::{Change, Texel};
use rutilant::color::Rgb;
use rutilant::material::MAX_IOR;
use rutilant::scene::TextureId;
use rutilant::texture::Channel;
use rutilant_geom::real;

/// How rough something is, as this renderer says it.
pub(super) struct Rough {
    pub(super) roughness: f32,
    pub(super) texture: Option<(TextureId, Channel)>,
}

impl Maker<'_> {
    /// Factor and texture of a colour, whose factor lies between 0 and 1.
    pub(super) fn unit_color(
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
    pub(super) fn index(
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
    pub(super) fn rough(
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

    pub(super) fn even(&mut self, rough: &Rough, parameters: &Parameters) {
        if rough.texture.is_some() {
            let what = format!("{} is as rough everywhere", parameters.of);
            self.note(parameters.place, what);
        }
    }
}

/// α for a roughness as pbrt-v3 has it: Pharr, Jakob, Humphreys, 3rd ed., section 8.4.2.
fn older_alpha(roughness: f32) -> f32 {
    let x = real::ln(roughness.max(1e-3));
    1.621_42 + x * (0.819_955 + x * (0.173_4 + x * (0.017_120_1 + x * 0.000_640_711)))
}

#[cfg(test)]
mod tests {
    use super::*;

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
